//! The optical side of a scene at one wavelength, or at several that share their paths.

use super::surface::SurfaceLaw;
use crate::math::DVec3;
use crate::phase::Phase;
use crate::rng::Stream;
use crate::sap::Sap;
use num_complex::Complex64;

/// Media and surface laws, indexed by [`crate::universe::MediumId`] and
/// [`crate::universe::SurfaceId`].
#[derive(Debug)]
pub struct Light<const N: usize> {
    /// Media.
    pub media: Vec<Medium<N>>,
    /// Surface laws; 0 is smooth.
    pub surfaces: Vec<SurfaceLaw<N>>,
    /// Lanes in use, 1…N.
    pub lanes: usize,
}

/// A medium as a ray sees it.
#[derive(Debug)]
pub struct Medium<const N: usize> {
    /// Refractive index n + iκ, the same in all lanes.
    pub n: Complex64,
    /// κ = 0: the real formulas of Fresnel and Snell hold.
    pub real: bool,
    /// Absorption coefficient by lane, 1/µm (that of κ included).
    pub mu_a: [f64; N],
    /// Any lane absorbs.
    pub absorbs: bool,
    /// Scattering coefficient, 1/µm, the same in all lanes; set by [`Medium::with`].
    pub mu_s: f64,
    /// 1/µs, µm.
    mean_free_path: f64,
    /// Phase function.
    pub phase: Phase,
    /// Sphere Area Partitioning of the phase function; `None`: the continuous law.
    pub sap: Option<MediumSap>,
}

/// SAP of a phase function: pole along the forward direction.
#[derive(Debug)]
pub struct MediumSap {
    /// The table.
    pub sap: Sap,
    /// How directions inside a patch are chosen.
    pub directions: crate::sap::SapDirections,
    /// Roll about the pole drawn for each event (else fixed: the paper).
    pub roll_random: bool,
}

impl<const N: usize> Medium<N> {
    /// A medium that neither absorbs nor scatters.
    pub fn clear(n: f64) -> Self {
        Medium {
            n: Complex64::new(n, 0.0),
            real: true,
            mu_a: [0.0; N],
            absorbs: false,
            mu_s: 0.0,
            mean_free_path: f64::INFINITY,
            phase: Phase::Isotropic,
            sap: None,
        }
    }

    /// With absorption, scattering coefficient (1/µm) and phase function.
    pub fn with(mut self, mu_a: [f64; N], mu_s: f64, phase: Phase) -> Self {
        self.absorbs = mu_a.iter().any(|&x| x > 0.0);
        (self.mu_a, self.mu_s, self.phase) = (mu_a, mu_s, phase);
        self.mean_free_path = 1.0 / mu_s;
        self
    }

    /// Free path to the next subsurface event: exponential with mean 1/µs, infinite without scattering
    /// (and then no number is drawn).
    #[inline]
    pub fn free_path(&self, rng: &mut Stream) -> f64 {
        if self.mu_s > 0.0 { rng.exponential() * self.mean_free_path } else { f64::INFINITY }
    }

    /// New direction after a subsurface event.
    #[inline(always)]
    pub fn scatter(&self, dir: DVec3, rng: &mut Stream) -> DVec3 {
        match &self.sap {
            None => self.phase.scatter(dir, rng),
            Some(sap) => sap.scatter(&self.phase, dir, rng),
        }
    }
}
