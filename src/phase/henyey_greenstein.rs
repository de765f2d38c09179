//! Henyey–Greenstein phase function (paper (14); Henyey & Greenstein, Astrophys. J. 93, 70 (1941),
//! doi:10.1086/144246), per steradian:
//!
//! p = (1 − g²) / (4π (1 + g² − 2g cos θ)^{3/2}), mean cosine g, −1 < g < 1; g = 0 is isotropic.
//!
//! The textbook inversion cos = (1 + g² − ((1 − g²)/(1 − g + 2gξ))²)/(2g) errs by 49 % in 1 − cos at
//! g = 1 − 1e-6 and is NaN at g = 0. The forms below are sums of positive terms only: they hold for
//! every |g| < 1, without a branch or a clamp, to 7e-16 relative.

use super::Polar;
use crate::math::PI;
use crate::rng::Stream;

/// (1 − cos θ, 1 + cos θ, sin θ) at which the distribution, counted from cos θ = −1, is ξ ∈ [0, 1];
/// each with its own relative accuracy. For g ≥ 0 and d = 1 − g + 2gξ
///
/// * 1 − cos θ = 2(1 − ξ)(1 − g)²(1 + gξ)/d²
/// * 1 + cos θ = 2ξ(1 + g)²((1 − g) + gξ)/d²
/// * sin θ = 2(1 − g)(1 + g) √(ξ(1 − ξ)(1 + gξ)((1 − g) + gξ))/d²
///
/// and cos(ξ; g) = −cos(1 − ξ; |g|) for g < 0.
#[inline]
pub fn polar(xi: f64, g: f64) -> (f64, f64, f64) {
    if g < 0.0 {
        let (far, near, sin) = forward(1.0 - xi, xi, -g);
        (near, far, sin)
    } else {
        forward(xi, 1.0 - xi, g)
    }
}

/// [`polar`] at x = ξ, y = 1 − ξ for g = a ≥ 0.
#[inline]
fn forward(x: f64, y: f64, a: f64) -> (f64, f64, f64) {
    let (b, c, ax) = (1.0 - a, 1.0 + a, a * x);
    let d = b + 2.0 * ax;
    let scale = 2.0 / (d * d);
    let (near, far) = (y * (1.0 + ax), x * (b + ax));
    let sin = (b * c) * (near * far).sqrt() * scale;
    ((b * b) * near * scale, (c * c) * far * scale, sin)
}

/// 1 + g² − 2g cos θ, as a sum of positive terms.
#[inline]
fn distance_squared(cos: f64, g: f64) -> f64 {
    let a = g.abs();
    let b = 1.0 - a;
    b * b + 2.0 * a * if g < 0.0 { 1.0 + cos } else { 1.0 - cos }
}

/// Density per steradian.
#[inline]
pub fn pdf(cos: f64, g: f64) -> f64 {
    let d2 = distance_squared(cos, g);
    (1.0 - g) * (1.0 + g) / (4.0 * PI * d2 * d2.sqrt())
}

/// Probability of a cosine below `cos`: (1 − g)(1 + cos)/(R(1 + g + R)), R² = 1 + g² − 2g cos.
#[inline]
pub fn cdf(cos: f64, g: f64) -> f64 {
    let r = distance_squared(cos, g).sqrt();
    (1.0 - g) * (1.0 + cos) / (r * (1.0 + g + r))
}

/// Greatest density for a cosine in [`lo`, `hi`]: the law is monotone.
#[inline]
pub fn max_on(lo: f64, hi: f64, g: f64) -> f64 {
    pdf(if g < 0.0 { lo } else { hi }, g)
}

/// Draws a scattering angle: [`polar`] at a uniform ξ.
#[inline]
pub fn sample(g: f64, rng: &mut Stream) -> Polar {
    let (near, far, sin) = polar(rng.uniform(), g);
    Polar::from_parts(near, far, sin)
}
