//! Rayleigh phase function of particles far smaller than the wavelength, unpolarised light
//! (paper (12), (13); the paper prints cos θ² for cos²θ), per steradian:
//!
//! p = (3/16π)(1 + cos²θ), mean cosine 0. The scattering coefficient goes with λ⁻⁴.

use super::Polar;
use crate::math::{PI, cbrt};
use crate::rng::Stream;

/// Density per steradian.
#[inline]
pub fn pdf(cos: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cos * cos)
}

/// Probability of a cosine below `cos`: (cos³ + 3 cos + 4)/8, in s = 1 + cos: s(6 − 3s + s²)/8.
#[inline]
pub fn cdf(cos: f64) -> f64 {
    let s = 1.0 + cos;
    0.125 * s * (6.0 - 3.0 * s + s * s)
}

/// (1 − cos θ, 1 + cos θ, sin θ) at which [`cdf`] is ξ ∈ [0, 1], each relatively accurate.
///
/// With h = min(ξ, 1 − ξ) and q = 2 − 4h the cubic c³ + 3c = 2q has the one real root
/// c = u − 1/u = 2q/(u² + 1 + u⁻²), u³ = q + √(q² + 1): |cos θ|. The distance t = 1 − |cos θ| to the
/// nearer pole satisfies t(6 − 3t + t²) = 8h; one step t = 8h/(6 − 3t₀ + t₀²) from t₀ = 1 − c turns
/// the absolute accuracy of c into relative accuracy of t.
#[inline]
pub fn polar(xi: f64) -> (f64, f64, f64) {
    let h = xi.min(1.0 - xi);
    let q = 4.0 * (0.5 - h);
    let u = cbrt(q + (q * q + 1.0).sqrt());
    let u2 = u * u;
    let t0 = 1.0 - 2.0 * q / (u2 + 1.0 + 1.0 / u2);
    let t = 8.0 * h / (6.0 + t0 * (t0 - 3.0));
    let sin = (t * (2.0 - t)).sqrt();
    if xi < 0.5 { (2.0 - t, t, sin) } else { (t, 2.0 - t, sin) }
}

/// Draws a scattering angle: [`polar`] at a uniform ξ.
#[inline]
pub fn sample(rng: &mut Stream) -> Polar {
    let (near, far, sin) = polar(rng.uniform());
    Polar::from_parts(near, far, sin)
}
