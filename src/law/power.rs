//! Power laws on intervals, and laws that are a power of the size inside bins.

use crate::math::{Sum, exp, expm1, ln, ln_1p, pow};
use crate::rng::Stream;

/// ∫ s^q ds over [s0, s1]; infinite when s0 = 0 and q ≤ −1.
pub(super) fn power_integral(s0: f64, s1: f64, q: f64) -> f64 {
    if s1 <= s0 {
        return 0.0;
    }
    if q == 0.0 {
        return s1 - s0;
    }
    let k = q + 1.0;
    if s0 == 0.0 {
        return if k > 0.0 { pow(s1, k) / k } else { f64::INFINITY };
    }
    let l = ln(s1 / s0);
    if k == 0.0 { l } else { exp(k * ln(s0)) * expm1(k * l) / k }
}

/// CDF at s of the density ∝ s^q on [s0, s1].
pub(super) fn power_cdf(s0: f64, s1: f64, q: f64, s: f64) -> f64 {
    if s <= s0 {
        return 0.0;
    }
    if s >= s1 {
        return 1.0;
    }
    let k = q + 1.0;
    if q == 0.0 {
        (s - s0) / (s1 - s0)
    } else if s0 == 0.0 {
        pow(s / s1, k)
    } else if k == 0.0 {
        ln(s / s0) / ln(s1 / s0)
    } else {
        expm1(k * ln(s / s0)) / expm1(k * ln(s1 / s0))
    }
}

/// Inverse of [`power_cdf`] at v in (0, 1].
#[inline]
pub(super) fn power_inverse(s0: f64, s1: f64, q: f64, v: f64) -> f64 {
    let k = q + 1.0;
    let s = if q == 0.0 {
        s0 + v * (s1 - s0)
    } else if s0 == 0.0 {
        s1 * pow(v, 1.0 / k)
    } else if k == 0.0 {
        s0 * exp(v * ln(s1 / s0))
    } else {
        s0 * exp(ln_1p(v * expm1(k * ln(s1 / s0))) / k)
    };
    s.clamp(s0, s1)
}

/// First index whose cumulative value reaches `u`.
#[inline]
pub(super) fn pick(cumulative: &[f64], u: f64) -> usize {
    cumulative.partition_point(|c| *c < u).min(cumulative.len() - 1)
}

/// Cumulative sums divided by their total, and the total.
pub(super) fn cumulate(weights: &[f64]) -> (Vec<f64>, f64) {
    let mut sum = Sum::default();
    let mut cumulative: Vec<f64> = weights
        .iter()
        .map(|w| {
            sum.add(*w);
            sum.value()
        })
        .collect();
    let total = sum.value();
    for c in &mut cumulative {
        *c /= total;
    }
    (cumulative, total)
}

/// Bins of given probability, inside each of which the density is ∝ x^q: uniform laws and
/// histograms (q = 0) and their tilted forms (q ≠ 0), all in closed form.
#[derive(Clone, Debug, PartialEq)]
pub struct PowerBins {
    edges: Vec<f64>,
    probability: Vec<f64>,
    cumulative: Vec<f64>,
    q: f64,
}

impl PowerBins {
    pub(super) fn new(edges: Vec<f64>, weights: &[f64], q: f64) -> Self {
        let (cumulative, total) = cumulate(weights);
        let probability = weights.iter().map(|w| w / total).collect();
        PowerBins { edges, probability, cumulative, q }
    }

    fn bin(&self, i: usize) -> (f64, f64) {
        (self.edges[i], self.edges[i + 1])
    }

    /// Index of the bin that holds x, if any does.
    fn find(&self, x: f64) -> Option<usize> {
        let last = self.edges.len() - 1;
        (x >= self.edges[0] && x <= self.edges[last])
            .then(|| self.edges.partition_point(|e| *e <= x).clamp(1, last) - 1)
    }

    pub(super) fn pdf(&self, x: f64) -> f64 {
        let Some(i) = self.find(x) else { return 0.0 };
        if self.probability[i] == 0.0 {
            return 0.0;
        }
        let (a, b) = self.bin(i);
        let power = if self.q == 0.0 { 1.0 } else { pow(x, self.q) };
        self.probability[i] * power / power_integral(a, b, self.q)
    }

    pub(super) fn cdf(&self, x: f64) -> f64 {
        let Some(i) = self.find(x) else { return f64::from(x > self.edges[0]) };
        let (a, b) = self.bin(i);
        let before = if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        before + self.probability[i] * power_cdf(a, b, self.q, x)
    }

    /// Probability of each bin × mean of x^p inside the bin.
    fn moments(&self, p: f64) -> Vec<f64> {
        (0..self.probability.len())
            .map(|i| {
                let (a, b) = self.bin(i);
                match self.probability[i] {
                    0.0 => 0.0,
                    w => w * power_integral(a, b, self.q + p) / power_integral(a, b, self.q),
                }
            })
            .collect()
    }

    pub(super) fn moment(&self, p: f64) -> f64 {
        self.moments(p).into_iter().collect::<Sum>().value()
    }

    pub(super) fn tilted(&self, p: f64) -> Self {
        PowerBins::new(self.edges.clone(), &self.moments(p), self.q + p)
    }

    pub(super) fn can_tilt(&self, p: f64) -> bool {
        self.lower() > 0.0 || self.q + p > -1.0
    }

    #[inline]
    pub(super) fn sample(&self, stream: &mut Stream) -> f64 {
        let i =
            if self.probability.len() == 1 { 0 } else { pick(&self.cumulative, stream.uniform_positive()) };
        power_inverse(self.edges[i], self.edges[i + 1], self.q, stream.uniform_positive())
    }

    pub(super) fn lower(&self) -> f64 {
        let first = self.probability.iter().position(|w| *w > 0.0).unwrap_or(0);
        self.edges[first]
    }

    pub(super) fn upper(&self) -> f64 {
        let last = self.probability.iter().rposition(|w| *w > 0.0).unwrap_or(0);
        self.edges[last + 1]
    }

    /// The law as many weighted points, for Gauss quadrature: a rule on [0, 1] in each octave of x
    /// of each bin (in the whole bin for q = 0).
    pub(super) fn points(&self, rule: &[(f64, f64)]) -> Vec<(f64, f64)> {
        let mut points = Vec::new();
        for (i, w) in self.probability.iter().enumerate().filter(|(_, w)| **w > 0.0) {
            let (a, b) = self.bin(i);
            let scale = w / power_integral(a, b, self.q);
            let mut top = b;
            for _ in 0..60 {
                let bottom = if self.q == 0.0 { a } else { a.max(0.5 * top) };
                points.extend(rule.iter().map(|(v, dv)| {
                    let x = bottom + v * (top - bottom);
                    (x, scale * dv * (top - bottom) * if self.q == 0.0 { 1.0 } else { pow(x, self.q) })
                }));
                top = bottom;
                if top <= a {
                    break;
                }
            }
            if top > a {
                points.push((power_inverse(a, top, self.q, 0.5), scale * power_integral(a, top, self.q)));
            }
        }
        points
    }
}
