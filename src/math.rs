//! Elementary functions, frames and roots: the one place where a formula meets floating point.
//!
//! Every logarithm, exponential and trigonometric function of the program is called through this
//! module, so that the same source gives the same bits on every machine. Transport uses the
//! polynomials of [`fast`]; everything else is correctly rounded or close to it (crate `pxfm`,
//! pure Rust). Square roots, sums and products are exact IEEE-754 operations and need no wrapper.

pub mod fast;
pub mod frame;
pub mod quadratic;

pub use frame::{Frame, orthonormal};
pub use glam::{DVec2, DVec3};
pub use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Natural logarithm.
#[inline]
pub fn ln(x: f64) -> f64 {
    pxfm::f_log(x)
}
/// ln(1 + x), accurate for small x.
#[inline]
pub fn ln_1p(x: f64) -> f64 {
    pxfm::f_log1p(x)
}
/// Bessel function J1.
pub fn bessel_j1(x: f64) -> f64 {
    pxfm::f_j1(x)
}
/// Bessel function of the second kind Y0, x > 0.
pub fn bessel_y0(x: f64) -> f64 {
    pxfm::f_y0(x)
}
/// Bessel function of the second kind Y1, x > 0.
pub fn bessel_y1(x: f64) -> f64 {
    pxfm::f_y1(x)
}
/// Exponential.
#[inline]
pub fn exp(x: f64) -> f64 {
    pxfm::f_exp(x)
}
/// exp(x) − 1, accurate for small x.
#[inline]
pub fn expm1(x: f64) -> f64 {
    pxfm::f_expm1(x)
}
/// Sine of an angle in radians.
#[inline]
pub fn sin(x: f64) -> f64 {
    pxfm::f_sin(x)
}
/// Cosine of an angle in radians.
#[inline]
pub fn cos(x: f64) -> f64 {
    pxfm::f_cos(x)
}
/// Sine and cosine of an angle in radians.
#[inline]
pub fn sin_cos(x: f64) -> (f64, f64) {
    pxfm::f_sincos(x)
}
/// Tangent of an angle in radians.
#[inline]
pub fn tan(x: f64) -> f64 {
    pxfm::f_tan(x)
}
/// Arc sine in radians; the argument is limited to [−1, 1] (rounding may step just outside).
#[inline]
pub fn asin(x: f64) -> f64 {
    pxfm::f_asin(x.clamp(-1.0, 1.0))
}
/// Arc cosine in radians; the argument is limited to [−1, 1] (rounding may step just outside).
#[inline]
pub fn acos(x: f64) -> f64 {
    pxfm::f_acos(x.clamp(-1.0, 1.0))
}
/// Arc tangent in radians.
#[inline]
pub fn atan(x: f64) -> f64 {
    pxfm::f_atan(x)
}
/// Angle of the point (x, y) in (−π, π].
#[inline]
pub fn atan2(y: f64, x: f64) -> f64 {
    pxfm::f_atan2(y, x)
}
/// Hyperbolic sine.
#[inline]
pub fn sinh(x: f64) -> f64 {
    pxfm::f_sinh(x)
}
/// Hyperbolic cosine.
#[inline]
pub fn cosh(x: f64) -> f64 {
    pxfm::f_cosh(x)
}
/// Hyperbolic tangent.
#[inline]
pub fn tanh(x: f64) -> f64 {
    pxfm::f_tanh(x)
}
/// x raised to the power y.
#[inline]
pub fn pow(x: f64, y: f64) -> f64 {
    pxfm::f_pow(x, y)
}
/// Cube root.
#[inline]
pub fn cbrt(x: f64) -> f64 {
    pxfm::f_cbrt(x)
}
/// Decimal logarithm.
#[inline]
pub fn log10(x: f64) -> f64 {
    pxfm::f_log10(x)
}
/// Error function.
#[inline]
pub fn erf(x: f64) -> f64 {
    pxfm::f_erf(x)
}
/// Complementary error function.
#[inline]
pub fn erfc(x: f64) -> f64 {
    pxfm::f_erfc(x)
}
/// Natural logarithm of the gamma function.
#[inline]
pub fn ln_gamma(x: f64) -> f64 {
    pxfm::f_lgamma(x)
}
/// Bessel function of the first kind, order 0.
#[inline]
pub fn bessel_j0(x: f64) -> f64 {
    pxfm::f_j0(x)
}
/// Modified Bessel function of the first kind, order 0.
#[inline]
pub fn bessel_i0(x: f64) -> f64 {
    pxfm::f_i0(x)
}
/// Modified Bessel function of the second kind, order 1.
#[inline]
pub fn bessel_k1(x: f64) -> f64 {
    pxfm::f_k1(x)
}

/// Sum with the rounding error carried along (Neumaier's variant of Kahan's sum): the error does
/// not grow with the number of terms.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sum {
    sum: f64,
    carry: f64,
}

impl Sum {
    /// Adds one term.
    #[inline]
    pub fn add(&mut self, x: f64) {
        let t = self.sum + x;
        self.carry += if self.sum.abs() >= x.abs() { (self.sum - t) + x } else { (x - t) + self.sum };
        self.sum = t;
    }
    /// The sum of all terms so far.
    #[inline]
    pub fn value(&self) -> f64 {
        self.sum + self.carry
    }
}

impl FromIterator<f64> for Sum {
    fn from_iter<I: IntoIterator<Item = f64>>(terms: I) -> Self {
        let mut s = Sum::default();
        for x in terms {
            s.add(x);
        }
        s
    }
}

/// Nodes and weights of Gauss–Legendre quadrature of order `n` on [a, b]:
/// ∫ f ≈ Σ wᵢ f(xᵢ), exact for polynomials up to degree 2n − 1.
pub fn gauss_legendre(n: usize, a: f64, b: f64) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = cos(PI * (i as f64 + 0.75) / (n as f64 + 0.5));
            let mut dp = 0.0;
            for _ in 0..100 {
                let (mut p0, mut p1) = (1.0, x);
                for k in 2..=n {
                    let k = k as f64;
                    let p2 = ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k;
                    p0 = p1;
                    p1 = p2;
                }
                if n == 1 {
                    p0 = 1.0;
                }
                dp = n as f64 * (x * p1 - p0) / (x * x - 1.0);
                let step = p1 / dp;
                x -= step;
                if step.abs() < 1e-15 {
                    break;
                }
            }
            let w = 2.0 / ((1.0 - x * x) * dp * dp);
            (0.5 * (a + b) + 0.5 * (b - a) * x, 0.5 * (b - a) * w)
        })
        .collect()
}
