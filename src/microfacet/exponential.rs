//! Exponential slopes: P22(ζ) = exp(−ζ/b)/(2πb²), D = exp(−tanθ/b)/(2πb² cos⁴θ), b = m/√6.
//! ⟨ζ⟩ = 2b, ⟨ζ²⟩ = 6b² = m².
//!
//! Masking: the slope along a line has the density P2(x) = |x| K1(|x|/b)/(πb²), hence with a = cotθ/b
//! Λ = (1/a)∫ₐ^∞ (t − a) t K1(t) dt/π = [2 K1(a) − Ki1(a)]/π, Ki1(a) = ∫ₐ^∞ K0(t) dt
//! = (1/π) ∫₀^∞ exp(−a cosh u)(2 cosh u − 1/cosh u) du.

use super::chebyshev::Series;
use super::{FRAC_1_PI, visible_by_rejection};
use crate::math::{DVec3, cosh, exp, fast, ln};
use crate::rng::Stream;
use std::sync::LazyLock;

/// √6: m/b.
const SQRT_6: f64 = 2.449_489_742_783_178;

/// P22 at ζ.
pub(super) fn slope_density(zeta: f64, m: f64) -> f64 {
    let b = m / SQRT_6;
    0.5 * FRAC_1_PI * exp(-zeta / b) / (b * b)
}

/// D at cosθ > 0.
pub(super) fn d(cos: f64, sin2: f64, m: f64) -> f64 {
    let p = slope_density(sin2.max(0.0).sqrt() / cos, m);
    let cos2 = cos * cos;
    if p == 0.0 { 0.0 } else { p / (cos2 * cos2) }
}

/// cosθ Λ = b sinθ · aΛ(a).
#[inline]
pub(super) fn hidden_area(cos: f64, sin: f64, m: f64) -> f64 {
    let scale = m / SQRT_6 * sin;
    if cos >= SCALED_END * scale {
        return 0.0;
    }
    scale * a_lambda(cos / scale)
}

/// From here on exp(−a) is below 1e-26 and Λ no longer counts beside 1.
const SCALED_END: f64 = 60.0;
/// Below it aΛ = 2/π − a/2 within a² |ln a| = 2e-15.
const SCALED_START: f64 = 1e-8;
/// Number of pieces of the table in ln a.
const PIECES: usize = 64;

/// aΛ(a), relative error below 1e-12.
#[inline]
fn a_lambda(a: f64) -> f64 {
    if a < SCALED_START {
        return 2.0 * FRAC_1_PI - 0.5 * a;
    }
    let table = &*TABLE;
    let x = (fast::ln(a) - table.start) * table.per_unit;
    let piece = (x as usize).min(PIECES - 1);
    FRAC_1_PI * fast::exp(-a) * table.pieces[piece].value(2.0 * (x - piece as f64) - 1.0)
}

/// π aΛ(a) exp(a) as a function of ln a, piecewise; the same for every m.
struct Table {
    start: f64,
    per_unit: f64,
    pieces: Vec<Series<10>>,
}

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let (start, end) = (ln(SCALED_START), ln(SCALED_END));
    let width = (end - start) / PIECES as f64;
    let pieces = (0..PIECES)
        .map(|k| Series::fit(|t| scaled_integral(exp(start + width * (k as f64 + 0.5 * (1.0 + t))))))
        .collect();
    Table { start, per_unit: 1.0 / width, pieces }
});

/// π aΛ(a) exp(a) = a ∫₀^∞ exp(−a (cosh u − 1))(2 cosh u − 1/cosh u) du by the trapezoidal rule: the
/// integrand is analytic in |Im u| < π/2 and falls doubly exponentially; relative error about
/// exp(a − π²/h), at most 1e-16 at the end of the table.
fn scaled_integral(a: f64) -> f64 {
    const H: f64 = 0.1;
    let mut sum = 0.5;
    for k in 1.. {
        let c = cosh(H * f64::from(k));
        let term = exp(-a * (c - 1.0)) * (2.0 * c - 1.0 / c);
        sum += term;
        if term < 1e-18 * sum {
            break;
        }
    }
    a * H * sum
}

/// Visible normal: ζ = b Γ(2) or, weighted with ζ, b Γ(3).
#[inline]
pub(super) fn sample_visible(i: DVec3, m: f64, rng: &mut Stream) -> DVec3 {
    let b = m / SQRT_6;
    visible_by_rejection(
        i,
        2.0 * b,
        rng,
        |rng| b * (rng.exponential() + rng.exponential()),
        |rng| b * (rng.exponential() + rng.exponential() + rng.exponential()),
    )
}
