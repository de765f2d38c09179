//! Gaussian slopes, the paper's equation (25); D is the law of Beckmann & Spizzichino (1963):
//! P22(ζ) = exp(−ζ²/m²)/(πm²), D = exp(−tan²θ/m²)/(πm² cos⁴θ), ⟨ζ²⟩ = m², ⟨ζ⟩ = m√π/2.

use super::{FRAC_1_PI, FRAC_1_SQRT_PI, visible_by_rejection};
use crate::math::{DVec3, erfc, exp};
use crate::rng::Stream;

/// P22 at ζ².
pub(super) fn slope_density(zeta2: f64, m: f64) -> f64 {
    FRAC_1_PI * exp(-zeta2 / (m * m)) / (m * m)
}

/// D at cosθ > 0.
pub(super) fn d(cos: f64, sin2: f64, m: f64) -> f64 {
    let cos2 = cos * cos;
    let p = slope_density(sin2 / cos2, m);
    // exp vanishes long before cos⁴ does.
    if p == 0.0 { 0.0 } else { p / (cos2 * cos2) }
}

/// cosθ Λ = m sinθ [exp(−a²)/(2√π) − a erfc(a)/2], a = cotθ/m (exact Smith integral).
#[inline]
pub(super) fn hidden_area(cos: f64, sin: f64, m: f64) -> f64 {
    let scale = m * sin;
    // Beyond a = 6 the bracket is below 1e-18: it no longer changes cosθ (1 + Λ).
    if cos >= 6.0 * scale {
        return 0.0;
    }
    let a = cos / scale;
    scale * 0.5 * (FRAC_1_SQRT_PI * exp(-a * a) - a * erfc(a)).max(0.0)
}

/// Visible normal: ζ = m√E (Rayleigh) or, weighted with ζ, m√Γ(3/2) (Maxwell).
#[inline]
pub(super) fn sample_visible(i: DVec3, m: f64, rng: &mut Stream) -> DVec3 {
    let mean = m / (2.0 * FRAC_1_SQRT_PI);
    visible_by_rejection(
        i,
        mean,
        rng,
        |rng| m * rng.exponential().sqrt(),
        |rng| {
            // Γ(3/2) = E + E' cos²: an exponential and half the square of a normal variate.
            let c = rng.azimuth().0;
            m * (rng.exponential() + rng.exponential() * c * c).sqrt()
        },
    )
}
