//! Orientation laws: azimuth of a fibre axis in the sheet, tilt out of the sheet, roll of the section.

use super::size::{LawError, check};
use crate::math::{DVec3, PI, TAU, acos, asin, atan2, bessel_i0, cos, exp, fast, sin, sin_cos};
use crate::rng::Stream;

/// Law of the in-plane azimuth φ of a fibre axis, rad from the machine direction x. An axis has no
/// sense, so φ has period π; densities are on [0, π).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Azimuth {
    /// Uniform: 1/π.
    Uniform,
    /// von Mises law of the double angle: exp(κ cos 2(φ−φ₀)) / (π I₀(κ)).
    VonMises {
        /// φ₀, rad.
        mean_direction: f64,
        /// Concentration κ ≥ 0; 0 is uniform.
        kappa: f64,
    },
    /// Wrapped Cauchy law of the double angle: (1−ρ²) / (π (1 + ρ² − 2ρ cos 2(φ−φ₀))).
    WrappedCauchy {
        /// φ₀, rad.
        mean_direction: f64,
        /// Mean resultant length 0 ≤ ρ < 1; 0 is uniform.
        rho: f64,
    },
}

impl Azimuth {
    /// von Mises law about `mean_direction` (rad) with concentration 0 ≤ κ ≤ 1e6.
    pub fn von_mises(mean_direction: f64, kappa: f64) -> Result<Azimuth, LawError> {
        check("mean direction", mean_direction, "finite", true)?;
        check("kappa", kappa, "0 to 1e6", (0.0..=1e6).contains(&kappa))?;
        Ok(Azimuth::VonMises { mean_direction, kappa })
    }

    /// Wrapped Cauchy law about `mean_direction` (rad) with 0 ≤ ρ < 1.
    pub fn wrapped_cauchy(mean_direction: f64, rho: f64) -> Result<Azimuth, LawError> {
        check("mean direction", mean_direction, "finite", true)?;
        check("rho", rho, "0 ≤ rho < 1", (0.0..1.0).contains(&rho))?;
        Ok(Azimuth::WrappedCauchy { mean_direction, rho })
    }

    /// Density at φ (any φ; period π), 1/rad; its integral over [0, π) is 1.
    pub fn pdf(&self, phi: f64) -> f64 {
        // 1 − cos 2Δ = 2 sin²Δ keeps its digits near the mean direction.
        match *self {
            Azimuth::Uniform => 1.0 / PI,
            Azimuth::VonMises { mean_direction, kappa } => {
                let s = sin(phi - mean_direction);
                exp(-2.0 * kappa * s * s) / (PI * scaled_i0(kappa))
            }
            Azimuth::WrappedCauchy { mean_direction, rho } => {
                let s = sin(phi - mean_direction);
                (1.0 - rho) * (1.0 + rho) / (PI * ((1.0 - rho) * (1.0 - rho) + 4.0 * rho * s * s))
            }
        }
    }

    /// One azimuth in [0, π).
    #[inline]
    pub fn sample(&self, stream: &mut Stream) -> f64 {
        match *self {
            Azimuth::Uniform => PI * stream.uniform(),
            Azimuth::VonMises { mean_direction, kappa } => {
                wrap(mean_direction + 0.5 * sample_von_mises(kappa, stream))
            }
            // The map tan φ → (1−ρ)/(1+ρ) tan φ takes a uniform axis to a wrapped Cauchy one
            // (McCullagh 1996, doi:10.1214/aos/1032526970).
            Azimuth::WrappedCauchy { mean_direction, rho } => {
                let (c, s) = stream.azimuth();
                wrap(mean_direction + atan2((1.0 - rho) * s, (1.0 + rho) * c))
            }
        }
    }

    /// Cosine and sine of one azimuth, with sine ≥ 0: the form that transport needs.
    #[inline]
    pub fn sample_cos_sin(&self, stream: &mut Stream) -> (f64, f64) {
        match self {
            Azimuth::Uniform => fast::cos_sin_turn(0.5 * stream.uniform()),
            _ => fast::cos_sin_turn(self.sample(stream) / TAU),
        }
    }

    /// E[cos 2(φ−φ₀)]: 0 for uniform, I₁(κ)/I₀(κ) for von Mises, ρ for wrapped Cauchy.
    pub fn order_parameter(&self) -> f64 {
        match *self {
            Azimuth::Uniform => 0.0,
            Azimuth::VonMises { kappa, .. } => bessel_ratio(kappa),
            Azimuth::WrappedCauchy { rho, .. } => rho,
        }
    }
}

/// The same axis in [0, π).
#[inline]
fn wrap(phi: f64) -> f64 {
    let w = phi - PI * (phi / PI).floor();
    if (0.0..PI).contains(&w) { w } else { 0.0 }
}

/// Angle θ in [−π, π] with density ∝ exp(κ cos θ): Best & Fisher 1979 (doi:10.2307/2346732), or under
/// a flat envelope when κ is small.
fn sample_von_mises(kappa: f64, stream: &mut Stream) -> f64 {
    if kappa < 0.5 {
        loop {
            let (c, s) = stream.azimuth();
            if stream.exponential() >= kappa * (1.0 - c) {
                return atan2(s, c);
            }
        }
    }
    let tau = 1.0 + (1.0 + 4.0 * kappa * kappa).sqrt();
    let rho = (tau - (2.0 * tau).sqrt()) / (2.0 * kappa);
    let r = (1.0 + rho * rho) / (2.0 * rho);
    loop {
        let z = stream.azimuth().0;
        let f = (1.0 + r * z) / (r + z);
        let c = kappa * (r - f);
        // Accept with probability (c e^{1−c}) : ln u ≤ ln c + 1 − c.
        if -stream.exponential() <= crate::math::ln(c) + 1.0 - c {
            let theta = acos(f);
            return if stream.uniform() < 0.5 { -theta } else { theta };
        }
    }
}

/// I₀(κ) e^(−κ); beyond κ = 100 by its asymptotic series (DLMF 10.40.1).
fn scaled_i0(kappa: f64) -> f64 {
    if kappa <= 100.0 {
        return bessel_i0(kappa) * exp(-kappa);
    }
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..15 {
        let odd = f64::from(2 * k - 1);
        term *= odd * odd / (f64::from(k) * 8.0 * kappa);
        sum += term;
    }
    sum / (2.0 * PI * kappa).sqrt()
}

/// I₁(κ)/I₀(κ) by its continued fraction (DLMF 10.33.1), from the far end.
fn bessel_ratio(kappa: f64) -> f64 {
    let depth = 30 + (50.0 * kappa).sqrt() as u32;
    (1..=depth).rev().fold(0.0, |r, k| kappa / (2.0 * f64::from(k) + kappa * r))
}

/// Law of the angle by which the axis leaves the sheet plane, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tilt {
    /// In the plane: 0.
    InPlane,
    /// Axis uniform on the sphere (together with a uniform azimuth): density ½ cos τ on [−π/2, π/2].
    Isotropic,
    /// Normal about 0.
    Normal {
        /// Standard deviation, rad.
        sd: f64,
    },
}

impl Tilt {
    /// Normal law about the plane with standard deviation `sd` (rad, 0 to π/2).
    pub fn normal(sd: f64) -> Result<Tilt, LawError> {
        Ok(Tilt::Normal { sd: check("tilt", sd, "0 to π/2 rad", (0.0..=0.5 * PI).contains(&sd))? })
    }

    /// One tilt, rad. [`Tilt::InPlane`] draws no number.
    #[inline]
    pub fn sample(&self, stream: &mut Stream) -> f64 {
        match *self {
            Tilt::InPlane => 0.0,
            Tilt::Isotropic => asin(2.0 * stream.uniform() - 1.0),
            Tilt::Normal { sd } => sd * stream.normal(),
        }
    }
}

/// Law of the roll of the section's major axis about the fibre axis, rad; 0 = in the sheet plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Roll {
    /// Major axis in the sheet plane: 0.
    Flat,
    /// Uniform on [0, π): the section is the same after half a turn.
    Uniform,
    /// Normal about flat.
    Normal {
        /// Standard deviation, rad.
        sd: f64,
    },
}

impl Roll {
    /// Normal law about flat with standard deviation `sd` (rad, 0 to π).
    pub fn normal(sd: f64) -> Result<Roll, LawError> {
        Ok(Roll::Normal { sd: check("roll", sd, "0 to π rad", (0.0..=PI).contains(&sd))? })
    }

    /// One roll, rad. [`Roll::Flat`] draws no number.
    #[inline]
    pub fn sample(&self, stream: &mut Stream) -> f64 {
        match *self {
            Roll::Flat => 0.0,
            Roll::Uniform => PI * stream.uniform(),
            Roll::Normal { sd } => sd * stream.normal(),
        }
    }
}

/// Unit axis (cos φ cos τ, sin φ cos τ, sin τ) of azimuth φ and tilt τ, rad; its z is exactly 0 for
/// τ = 0.
#[inline]
pub fn axis(azimuth: f64, tilt: f64) -> DVec3 {
    let (s, c) = sin_cos(azimuth);
    if tilt == 0.0 {
        return DVec3::new(c, s, 0.0);
    }
    let ct = cos(tilt);
    DVec3::new(c * ct, s * ct, sin(tilt))
}
