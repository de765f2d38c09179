//! Phase functions: where light goes when it is scattered inside a medium.
//!
//! p(cos θ) is the density of the new direction per steradian, ∫ p dω = 1, θ the angle between old
//! and new direction; the azimuth is uniform. One law a file; every law gives `sample`, `pdf`,
//! `mean_cosine` and an upper bound on an interval, and a chi-square test holds them together.

mod alias;
mod error;
pub mod henyey_greenstein;
pub mod mie;
mod mixture;
pub mod polarised;
pub mod rayleigh;
mod table;

pub use error::PhaseError;
pub use henyey_greenstein as hg;
pub use mixture::Mixture;
pub use table::Table;

use crate::math::{DVec3, PI, frame};
use crate::rng::Stream;
use std::sync::Arc;

/// Cosine and sine of a scattering angle, each accurate by itself: `sin` keeps its relative accuracy
/// at θ → 0 and θ → π, where √(1 − cos²) would lose all of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polar {
    /// cos θ, absolute error of some 1e-16.
    pub cos: f64,
    /// sin θ ≥ 0, relative error of some 1e-16.
    pub sin: f64,
}

impl Polar {
    /// From 1 − cos θ, 1 + cos θ and sin θ, each relatively accurate.
    #[inline]
    pub fn from_parts(one_minus_cos: f64, one_plus_cos: f64, sin: f64) -> Self {
        let cos = if one_minus_cos < 1.0 { 1.0 - one_minus_cos } else { one_plus_cos - 1.0 };
        Polar { cos, sin }
    }
}

/// A phase function, per steradian, ∫ p dω = 1.
///
/// The parameters of the variants are taken as they are; the checked constructors
/// ([`Phase::henyey_greenstein`], [`Phase::two_term`]) refuse what is outside their range.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// Equal in all directions: p = 1/4π.
    Isotropic,
    /// Henyey–Greenstein with mean cosine g, |g| < 1 (paper (14)); see [`hg`].
    HenyeyGreenstein(f64),
    /// Two-term Henyey–Greenstein: p = w p(g1) + (1 − w) p(g2), 0 ≤ w ≤ 1
    /// (Irvine, Astrophys. J. 142, 1563 (1965), doi:10.1086/148436): a forward lobe with a backward one.
    TwoTerm {
        /// Share of the first lobe.
        w: f64,
        /// Mean cosine of the first lobe.
        g1: f64,
        /// Mean cosine of the second lobe.
        g2: f64,
    },
    /// Rayleigh: p = (3/16π)(1 + cos²θ) (paper (12), (13)); see [`rayleigh`].
    Rayleigh,
    /// Tabulated p(cos θ), Mie included.
    Table(Arc<Table>),
    /// Weighted sum of phase functions.
    Mixture(Arc<Mixture>),
}

// In the inner loop: two of them fit a cache line.
const _: () = assert!(size_of::<Phase>() <= 32);

impl Phase {
    /// Henyey–Greenstein; refuses |g| ≥ 1 and NaN.
    pub fn henyey_greenstein(g: f64) -> Result<Self, PhaseError> {
        error::mean_cosine("g", g)?;
        Ok(Phase::HenyeyGreenstein(g))
    }

    /// Two-term Henyey–Greenstein; refuses w outside [0, 1] and |g| ≥ 1.
    pub fn two_term(w: f64, g1: f64, g2: f64) -> Result<Self, PhaseError> {
        error::range("w", w, (0.0..=1.0).contains(&w), "0 to 1")?;
        error::mean_cosine("g1", g1)?;
        error::mean_cosine("g2", g2)?;
        Ok(Phase::TwoTerm { w, g1, g2 })
    }

    /// Weighted sum of phase functions; see [`Mixture::new`].
    pub fn mixture(parts: Vec<(f64, Phase)>) -> Result<Self, PhaseError> {
        Ok(Phase::Mixture(Arc::new(Mixture::new(parts)?)))
    }

    /// Draws a scattering angle.
    #[inline(always)]
    pub fn sample(&self, rng: &mut Stream) -> Polar {
        if let Phase::HenyeyGreenstein(g) = self { hg::sample(*g, rng) } else { self.sample_other(rng) }
    }

    /// Out of the way of the commonest law.
    #[inline(never)]
    fn sample_other(&self, rng: &mut Stream) -> Polar {
        match self {
            Phase::HenyeyGreenstein(g) => hg::sample(*g, rng),
            Phase::Isotropic => hg::sample(0.0, rng),
            Phase::TwoTerm { w, g1, g2 } => hg::sample(if rng.uniform() < *w { *g1 } else { *g2 }, rng),
            Phase::Rayleigh => rayleigh::sample(rng),
            Phase::Table(t) => t.sample(rng),
            Phase::Mixture(m) => m.sample(rng),
        }
    }

    /// Density per steradian at cos θ ∈ [−1, 1].
    #[inline]
    pub fn pdf(&self, cos: f64) -> f64 {
        match self {
            Phase::HenyeyGreenstein(g) => hg::pdf(cos, *g),
            Phase::Isotropic => 0.25 / PI,
            Phase::TwoTerm { w, g1, g2 } => w * hg::pdf(cos, *g1) + (1.0 - w) * hg::pdf(cos, *g2),
            Phase::Rayleigh => rayleigh::pdf(cos),
            Phase::Table(t) => t.pdf(cos),
            Phase::Mixture(m) => m.pdf(cos),
        }
    }

    /// Mean cosine of the scattering angle, g = 2π ∫ cos θ p dcos θ.
    pub fn mean_cosine(&self) -> f64 {
        match self {
            Phase::HenyeyGreenstein(g) => *g,
            Phase::Isotropic | Phase::Rayleigh => 0.0,
            Phase::TwoTerm { w, g1, g2 } => w * g1 + (1.0 - w) * g2,
            Phase::Table(t) => t.mean_cosine(),
            Phase::Mixture(m) => m.mean_cosine(),
        }
    }

    /// Upper bound of the density for cos θ in [`cos_lo`, `cos_hi`] (rejection inside a patch): the
    /// maximum itself for isotropic, Henyey–Greenstein, Rayleigh and tables; for sums of laws the sum
    /// of the maxima, which is the maximum where all parts rise the same way.
    #[inline]
    pub fn max_on(&self, cos_lo: f64, cos_hi: f64) -> f64 {
        match self {
            Phase::HenyeyGreenstein(g) => hg::max_on(cos_lo, cos_hi, *g),
            Phase::Isotropic => 0.25 / PI,
            Phase::TwoTerm { w, g1, g2 } => {
                w * hg::max_on(cos_lo, cos_hi, *g1) + (1.0 - w) * hg::max_on(cos_lo, cos_hi, *g2)
            }
            Phase::Rayleigh => rayleigh::pdf(cos_lo.abs().max(cos_hi.abs())),
            Phase::Table(t) => t.max_on(cos_lo, cos_hi),
            Phase::Mixture(m) => m.max_on(cos_lo, cos_hi),
        }
    }

    /// New direction (unit) of light that travelled along `dir` (unit): a drawn angle and a uniform
    /// azimuth.
    #[inline(always)]
    pub fn scatter(&self, dir: DVec3, rng: &mut Stream) -> DVec3 {
        let polar = self.sample(rng);
        let (cos_p, sin_p) = rng.azimuth();
        frame::deflect(dir, polar.cos, polar.sin, cos_p, sin_p)
    }
}
