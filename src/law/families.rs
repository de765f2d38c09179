//! Unbounded families that stay in their family when tilted: lognormal and generalised gamma.

use super::quadrature::{gauss, hermite};
use crate::math::{PI, erfc, exp, ln, ln_1p, ln_gamma, pow};
use crate::rng::Stream;

/// Lognormal law: ln x is normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lognormal {
    /// ln of the median.
    pub(super) mu: f64,
    /// Standard deviation of ln x.
    pub(super) sigma: f64,
}

impl Lognormal {
    fn z(&self, x: f64) -> f64 {
        (ln(x) - self.mu) / self.sigma
    }
    pub(super) fn pdf(&self, x: f64) -> f64 {
        let z = self.z(x);
        exp(-0.5 * z * z) / (x * self.sigma * (2.0 * PI).sqrt())
    }
    pub(super) fn cdf(&self, x: f64) -> f64 {
        0.5 * erfc(-self.z(x) / std::f64::consts::SQRT_2)
    }
    pub(super) fn moment(&self, p: f64) -> f64 {
        exp(p * self.mu + 0.5 * p * p * self.sigma * self.sigma)
    }
    pub(super) fn tilted(&self, p: f64) -> Self {
        Lognormal { mu: self.mu + p * self.sigma * self.sigma, sigma: self.sigma }
    }
    #[inline]
    pub(super) fn sample(&self, stream: &mut Stream) -> f64 {
        crate::math::fast::exp(self.mu + self.sigma * stream.normal())
    }
    pub(super) fn nodes(&self, n: usize) -> Vec<(f64, f64)> {
        hermite(n).into_iter().map(|(z, w)| (exp(self.mu + self.sigma * z), w)).collect()
    }
}

/// Generalised gamma law (Stacy 1962): density ∝ x^(d−1) exp(−(x/a)^c). Gamma: c = 1, d = shape;
/// Weibull: c = d = shape. t = (x/a)^c has a gamma law of shape d/c.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralisedGamma {
    /// Scale a.
    pub(super) scale: f64,
    /// d.
    pub(super) d: f64,
    /// c.
    pub(super) c: f64,
}

impl GeneralisedGamma {
    fn shape(&self) -> f64 {
        self.d / self.c
    }
    /// t = (x/a)^c.
    #[inline]
    fn t(&self, x: f64) -> f64 {
        if self.c == 1.0 { x / self.scale } else { pow(x / self.scale, self.c) }
    }
    /// x = a t^(1/c).
    #[inline]
    fn x(&self, t: f64) -> f64 {
        (self.scale * if self.c == 1.0 { t } else { pow(t, 1.0 / self.c) }).max(f64::MIN_POSITIVE)
    }
    pub(super) fn pdf(&self, x: f64) -> f64 {
        self.c * exp(ln_kernel(self.shape(), self.t(x)) - ln(x))
    }
    pub(super) fn cdf(&self, x: f64) -> f64 {
        gamma_p(self.shape(), self.t(x))
    }
    pub(super) fn moment(&self, p: f64) -> f64 {
        exp(p * ln(self.scale) + ln_gamma_ratio(self.shape(), p / self.c))
    }
    pub(super) fn can_tilt(&self, p: f64) -> bool {
        self.d + p > 0.0
    }
    pub(super) fn tilted(&self, p: f64) -> Self {
        GeneralisedGamma { d: self.d + p, ..*self }
    }
    #[inline]
    pub(super) fn sample(&self, stream: &mut Stream) -> f64 {
        self.x(sample_gamma(self.shape(), stream))
    }

    /// Gauss rule in x (in t when c < ½: the moments of x then no longer determine the law).
    pub(super) fn nodes(&self, n: usize) -> Vec<(f64, f64)> {
        // In s = ln t the density ∝ exp(k s − eˢ) is smooth and falls off on both sides, so the
        // trapezoidal rule converges exponentially. Above, the sum ends so far below the peak that
        // even t^2n does not reach there.
        let k = self.shape();
        let g = |s: f64| k * s - exp(s) - (k * ln(k) - k);
        let reach = |direction: f64, depth: f64| {
            let (mut near, mut far) = (0.0, 1.0);
            while g(ln(k) + direction * far) > -depth {
                near = far;
                far *= 2.0;
            }
            for _ in 0..60 {
                let mid = 0.5 * (near + far);
                *(if g(ln(k) + direction * mid) > -depth { &mut near } else { &mut far }) = mid;
            }
            ln(k) + direction * far
        };
        let (lo, hi) = (reach(-1.0, 45.0), reach(1.0, (60.0 + 8.0 * n as f64).min(600.0)));
        let count = ((hi - lo) / (0.4 / (k + 2.0 * n as f64).sqrt()).min(0.04)).ceil();
        let in_x = self.c >= 0.5;
        let point = |i: usize| {
            let s = lo + (hi - lo) * i as f64 / count;
            (if in_x { exp(s / self.c) } else { exp(s) }, exp(g(s)))
        };
        let points: Vec<(f64, f64)> = (0..=count as usize).map(point).collect();
        let nodes = gauss(&points, n).into_iter();
        nodes.map(|(y, w)| (if in_x { self.scale * y } else { self.x(y) }, w)).collect()
    }
}

/// Gamma variate of unit scale: Marsaglia & Tsang 2000 (doi:10.1145/358407.358414), exact
/// rejection; below shape 1 by the boost U^(1/k), at shape 1 an exponential.
fn sample_gamma(k: f64, stream: &mut Stream) -> f64 {
    if k == 1.0 {
        return stream.exponential();
    }
    if k < 1.0 {
        let boost = pow(stream.uniform_positive(), 1.0 / k);
        return boost * sample_gamma(k + 1.0, stream);
    }
    let d = k - 1.0 / 3.0;
    let c = 1.0 / (9.0 * d).sqrt();
    loop {
        let z = stream.normal();
        let root = 1.0 + c * z;
        let e = stream.exponential();
        if root > 0.0 {
            let v = root * root * root;
            if -e < 0.5 * z * z + d * (1.0 - v + ln(v)) {
                return d * v;
            }
        }
    }
}

/// ln Γ(k) − [(k − ½) ln k − k + ½ ln 2π] for k ≥ 12 (DLMF 5.11.1).
fn stirling(k: f64) -> f64 {
    let r = 1.0 / (k * k);
    (1.0 / 12.0 - r * (1.0 / 360.0 - r * (1.0 / 1260.0 - r * (1.0 / 1680.0 - r / 1188.0)))) / k
}

/// ln(t^k e^(−t) / Γ(k)). For large k its three terms cancel: then by the distance of t from k.
fn ln_kernel(k: f64, t: f64) -> f64 {
    if k < 12.0 {
        return k * ln(t) - t - ln_gamma(k);
    }
    let e = (t - k) / k;
    let phi = if e.abs() < 0.5 { e - ln_1p(e) } else { e - ln(t / k) };
    -k * phi + 0.5 * ln(k / (2.0 * PI)) - stirling(k)
}

/// ln(Γ(k + p)/Γ(k)), likewise.
fn ln_gamma_ratio(k: f64, p: f64) -> f64 {
    if k < 12.0 || k + p < 12.0 {
        return ln_gamma(k + p) - ln_gamma(k);
    }
    p * ln(k) + (k + p - 0.5) * ln_1p(p / k) - p + stirling(k + p) - stirling(k)
}

/// Regularised lower incomplete gamma function P(k, t): series below t = k + 1, continued fraction
/// above (DLMF 8.7.1, 8.9.2).
fn gamma_p(k: f64, t: f64) -> f64 {
    if t <= 0.0 {
        return 0.0;
    }
    if t == f64::INFINITY {
        return 1.0;
    }
    let front = exp(ln_kernel(k, t));
    if t < k + 1.0 {
        let (mut term, mut sum, mut i) = (1.0 / k, 1.0 / k, k);
        while term > sum * 1e-17 {
            i += 1.0;
            term *= t / i;
            sum += term;
        }
        front * sum
    } else {
        let mut b = t + 1.0 - k;
        let (mut c, mut d) = (1e300, 1.0 / b);
        let mut h = d;
        for i in 1..100_000 {
            let an = -f64::from(i) * (f64::from(i) - k);
            b += 2.0;
            let guard = |v: f64| if v.abs() < 1e-300 { 1e-300 } else { v };
            d = 1.0 / guard(an * d + b);
            c = guard(b + an / c);
            h *= d * c;
            if (d * c - 1.0).abs() < 1e-16 {
                break;
            }
        }
        1.0 - front * h
    }
}
