//! Size laws.

use super::bounded::Bounded;
use super::families::{GeneralisedGamma, Lognormal};
use super::power::{PowerBins, cumulate, pick};
use super::quadrature::gauss;
use crate::math::{Sum, gauss_legendre, ln, pow};
use crate::rng::Stream;

/// How a size law was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weighting {
    /// Each particle counts once.
    Number,
    /// Each particle counts by its length.
    Length,
    /// Each particle counts by its mass.
    Mass,
}

/// What is wrong with the parameters of a law.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LawError {
    /// A parameter lies outside its range.
    #[error("{parameter} = {value} is outside its range: {range}")]
    Range {
        /// Name of the parameter.
        parameter: &'static str,
        /// The value given.
        value: f64,
        /// The range in words.
        range: &'static str,
    },
    /// The ends of an interval do not ascend.
    #[error("the upper end {hi} must be greater than the lower end {lo}")]
    Interval {
        /// Lower end.
        lo: f64,
        /// Upper end.
        hi: f64,
    },
    /// A histogram needs one more edge than weights.
    #[error("{edges} edges and {weights} weights: a histogram of n ≥ 1 weights has n + 1 edges")]
    Lengths {
        /// Number of edges.
        edges: usize,
        /// Number of weights.
        weights: usize,
    },
    /// A mixture or histogram without weight.
    #[error("the weights sum to 0: at least one must be positive")]
    NoWeight,
    /// x^p · pdf(x) has no finite integral.
    #[error(
        "the law cannot be weighted by size to the power {exponent}: it holds too many sizes near 0, \
         so the weighted law has no finite norm (give it a positive lower end)"
    )]
    Divergent {
        /// The exponent p.
        exponent: f64,
    },
}

/// Checks that a parameter is finite and satisfies a condition.
pub(super) fn check(
    parameter: &'static str,
    value: f64,
    range: &'static str,
    holds: bool,
) -> Result<f64, LawError> {
    if value.is_finite() && holds { Ok(value) } else { Err(LawError::Range { parameter, value, range }) }
}

fn positive(parameter: &'static str, value: f64) -> Result<f64, LawError> {
    check(parameter, value, "finite and > 0", value > 0.0)
}

fn interval(lo: f64, hi: f64) -> Result<(), LawError> {
    check("lower end", lo, "finite and ≥ 0", lo >= 0.0)?;
    check("upper end", hi, "finite and > 0", hi > 0.0)?;
    if hi > lo { Ok(()) } else { Err(LawError::Interval { lo, hi }) }
}

/// A law of a positive size x, µm (or of a positive ratio of sizes).
///
/// Made by the constructor functions, which check their parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum SizeLaw {
    /// One value.
    Constant(f64),
    /// Uniform, histogram, and their tilted forms.
    Bins(PowerBins),
    /// Lognormal.
    Lognormal(Lognormal),
    /// Gamma, Weibull, and their tilted forms.
    Gamma(GeneralisedGamma),
    /// Truncated normal, beta, and their tilted forms.
    Bounded(Box<Bounded>),
    /// Mixture.
    Mixture(Mixture),
}

/// Weighted sum of laws.
#[derive(Clone, Debug, PartialEq)]
pub struct Mixture {
    probability: Vec<f64>,
    cumulative: Vec<f64>,
    laws: Vec<SizeLaw>,
}

impl Mixture {
    fn new(weights: &[f64], laws: Vec<SizeLaw>) -> Self {
        let (cumulative, total) = cumulate(weights);
        Mixture { probability: weights.iter().map(|w| w / total).collect(), cumulative, laws }
    }
    fn average(&self, f: impl Fn(&SizeLaw) -> f64) -> f64 {
        self.parts().map(|(w, law)| w * f(law)).collect::<Sum>().value()
    }
    /// The laws of positive weight.
    fn parts(&self) -> impl Iterator<Item = (f64, &SizeLaw)> {
        self.probability.iter().copied().zip(&self.laws).filter(|(w, _)| *w > 0.0)
    }
}

impl SizeLaw {
    /// Always x > 0.
    pub fn constant(x: f64) -> Result<SizeLaw, LawError> {
        Ok(SizeLaw::Constant(positive("size", x)?))
    }

    /// Uniform on [lo, hi], 0 ≤ lo < hi.
    pub fn uniform(lo: f64, hi: f64) -> Result<SizeLaw, LawError> {
        interval(lo, hi)?;
        Ok(SizeLaw::Bins(PowerBins::new(vec![lo, hi], &[1.0], 0.0)))
    }

    /// Normal law of the given mean and standard deviation (before truncation) limited to [lo, hi].
    pub fn truncated_normal(mean: f64, sd: f64, lo: f64, hi: f64) -> Result<SizeLaw, LawError> {
        interval(lo, hi)?;
        check("mean", mean, "finite", true)?;
        positive("standard deviation", sd)?;
        Ok(SizeLaw::Bounded(Box::new(Bounded::truncated_normal(mean, sd, lo, hi))))
    }

    /// Lognormal: ln x is normal about ln(median) with standard deviation `sigma` in (0, 10].
    pub fn lognormal(median: f64, sigma: f64) -> Result<SizeLaw, LawError> {
        positive("median", median)?;
        check("sigma of ln", sigma, "> 0 and ≤ 10", sigma > 0.0 && sigma <= 10.0)?;
        Ok(SizeLaw::Lognormal(Lognormal { mu: ln(median), sigma }))
    }

    /// Gamma law: density ∝ x^(shape−1) exp(−x·shape/mean); shape in [0.01, 1e6].
    pub fn gamma(mean: f64, shape: f64) -> Result<SizeLaw, LawError> {
        positive("mean", mean)?;
        check("shape", shape, "0.01 to 1e6", (0.01..=1e6).contains(&shape))?;
        Ok(SizeLaw::Gamma(GeneralisedGamma { scale: mean / shape, d: shape, c: 1.0 }))
    }

    /// Weibull law: P(X > x) = exp(−(x/scale)^shape); shape in [0.1, 1000].
    pub fn weibull(scale: f64, shape: f64) -> Result<SizeLaw, LawError> {
        positive("scale", scale)?;
        check("shape", shape, "0.1 to 1000", (0.1..=1000.0).contains(&shape))?;
        Ok(SizeLaw::Gamma(GeneralisedGamma { scale, d: shape, c: shape }))
    }

    /// Beta law stretched over [lo, hi]: density ∝ (x−lo)^(a−1) (hi−x)^(b−1); a, b in [0.01, 1e6].
    pub fn beta(a: f64, b: f64, lo: f64, hi: f64) -> Result<SizeLaw, LawError> {
        interval(lo, hi)?;
        check("beta exponent a", a, "0.01 to 1e6", (0.01..=1e6).contains(&a))?;
        check("beta exponent b", b, "0.01 to 1e6", (0.01..=1e6).contains(&b))?;
        Ok(SizeLaw::Bounded(Box::new(Bounded::beta(a, b, lo, hi))))
    }

    /// Histogram: weight i is the probability (in any unit) of [edge i, edge i+1], uniform inside.
    pub fn histogram(edges: Vec<f64>, weights: Vec<f64>) -> Result<SizeLaw, LawError> {
        if weights.is_empty() || edges.len() != weights.len() + 1 {
            return Err(LawError::Lengths { edges: edges.len(), weights: weights.len() });
        }
        for pair in edges.windows(2) {
            interval(pair[0], pair[1])?;
        }
        check_weights(weights.iter().copied())?;
        Ok(SizeLaw::Bins(PowerBins::new(edges, &weights, 0.0)))
    }

    /// Mixture: each law with its weight (in any unit).
    pub fn mixture(parts: Vec<(f64, SizeLaw)>) -> Result<SizeLaw, LawError> {
        check_weights(parts.iter().map(|(w, _)| *w))?;
        let (weights, laws): (Vec<f64>, Vec<SizeLaw>) = parts.into_iter().unzip();
        Ok(SizeLaw::Mixture(Mixture::new(&weights, laws)))
    }

    /// Probability density at x, 1/µm (infinite at the value of a constant).
    pub fn pdf(&self, x: f64) -> f64 {
        if x <= 0.0 && !matches!(self, SizeLaw::Bins(_)) {
            return 0.0;
        }
        match self {
            SizeLaw::Constant(c) if x == *c => f64::INFINITY,
            SizeLaw::Constant(_) => 0.0,
            SizeLaw::Bins(l) => l.pdf(x),
            SizeLaw::Lognormal(l) => l.pdf(x),
            SizeLaw::Gamma(l) => l.pdf(x),
            SizeLaw::Bounded(l) => l.pdf(x),
            SizeLaw::Mixture(m) => m.average(|l| l.pdf(x)),
        }
    }

    /// P(size ≤ x).
    pub fn cdf(&self, x: f64) -> f64 {
        if x <= 0.0 {
            return 0.0;
        }
        match self {
            SizeLaw::Constant(c) => f64::from(x >= *c),
            SizeLaw::Bins(l) => l.cdf(x),
            SizeLaw::Lognormal(l) => l.cdf(x),
            SizeLaw::Gamma(l) => l.cdf(x),
            SizeLaw::Bounded(l) => l.cdf(x),
            SizeLaw::Mixture(m) => m.average(|l| l.cdf(x)),
        }
    }

    /// Mean size, µm.
    pub fn mean(&self) -> f64 {
        self.moment(1.0)
    }

    /// E[x^p], µm^p; infinite where it diverges.
    pub fn moment(&self, p: f64) -> f64 {
        if p == 0.0 {
            return 1.0;
        }
        if self.check_tilt(p).is_err() {
            return f64::INFINITY;
        }
        match self {
            SizeLaw::Constant(c) => pow(*c, p),
            SizeLaw::Bins(l) => l.moment(p),
            SizeLaw::Lognormal(l) => l.moment(p),
            SizeLaw::Gamma(l) => l.moment(p),
            SizeLaw::Bounded(l) => l.moment(p),
            SizeLaw::Mixture(m) => m.average(|l| l.moment(p)),
        }
    }

    /// One size.
    #[inline]
    pub fn sample(&self, stream: &mut Stream) -> f64 {
        match self {
            SizeLaw::Constant(c) => *c,
            _ => self.sample_spread(stream),
        }
    }

    fn sample_spread(&self, stream: &mut Stream) -> f64 {
        match self {
            SizeLaw::Constant(c) => *c,
            SizeLaw::Bins(l) => l.sample(stream),
            SizeLaw::Lognormal(l) => l.sample(stream),
            SizeLaw::Gamma(l) => l.sample(stream),
            SizeLaw::Bounded(l) => l.sample(stream),
            SizeLaw::Mixture(m) => m.laws[pick(&m.cumulative, stream.uniform_positive())].sample(stream),
        }
    }

    /// Whether x^p · pdf(x) has a finite norm, so that [`SizeLaw::tilted`] exists: an error names the
    /// exponent when the law holds too many sizes near 0.
    pub fn check_tilt(&self, p: f64) -> Result<(), LawError> {
        let possible = match self {
            SizeLaw::Constant(_) | SizeLaw::Lognormal(_) => true,
            SizeLaw::Bins(l) => l.can_tilt(p),
            SizeLaw::Gamma(l) => l.can_tilt(p),
            SizeLaw::Bounded(l) => l.can_tilt(p),
            SizeLaw::Mixture(m) => m.parts().all(|(_, l)| l.check_tilt(p).is_ok()),
        };
        if possible && p.is_finite() { Ok(()) } else { Err(LawError::Divergent { exponent: p }) }
    }

    /// The law with density ∝ x^p · pdf(x): what is seen when particles are met in proportion to
    /// size^p. Exact for every law.
    ///
    /// # Panics
    /// When no such law exists; ask [`SizeLaw::check_tilt`] first where p < 0 comes from user input.
    pub fn tilted(&self, p: f64) -> SizeLaw {
        if let Err(e) = self.check_tilt(p) {
            panic!("{e}");
        }
        if p == 0.0 {
            return self.clone();
        }
        match self {
            SizeLaw::Constant(c) => SizeLaw::Constant(*c),
            SizeLaw::Bins(l) => SizeLaw::Bins(l.tilted(p)),
            SizeLaw::Lognormal(l) => SizeLaw::Lognormal(l.tilted(p)),
            SizeLaw::Gamma(l) => SizeLaw::Gamma(l.tilted(p)),
            SizeLaw::Bounded(l) => SizeLaw::Bounded(Box::new(l.tilted(p))),
            SizeLaw::Mixture(m) => {
                let weights: Vec<f64> = m.parts().map(|(w, l)| w * l.moment(p)).collect();
                SizeLaw::Mixture(Mixture::new(&weights, m.parts().map(|(_, l)| l.tilted(p)).collect()))
            }
        }
    }

    /// Number-weighted law from a measured one: a length- or mass-weighted law counts each particle in
    /// proportion to size^`exponent`, so it is tilted back by −`exponent`; a number-weighted law is
    /// returned as it is.
    ///
    /// # Panics
    /// As [`SizeLaw::tilted`]: ask `law.check_tilt(-exponent)` first.
    pub fn from_weighted(law: SizeLaw, weighting: Weighting, exponent: f64) -> SizeLaw {
        match weighting {
            Weighting::Number => law,
            Weighting::Length | Weighting::Mass => law.tilted(-exponent),
        }
    }

    /// Least upper bound of the support, µm; infinite for lognormal, gamma and Weibull.
    pub fn upper(&self) -> f64 {
        match self {
            SizeLaw::Constant(c) => *c,
            SizeLaw::Bins(l) => l.upper(),
            SizeLaw::Lognormal(_) | SizeLaw::Gamma(_) => f64::INFINITY,
            SizeLaw::Bounded(l) => l.upper(),
            SizeLaw::Mixture(m) => m.parts().map(|(_, l)| l.upper()).fold(0.0, f64::max),
        }
    }

    /// Greatest lower bound of the support, µm.
    pub fn lower(&self) -> f64 {
        match self {
            SizeLaw::Constant(c) => *c,
            SizeLaw::Bins(l) => l.lower(),
            SizeLaw::Lognormal(_) | SizeLaw::Gamma(_) => 0.0,
            SizeLaw::Bounded(l) => l.lower(),
            SizeLaw::Mixture(m) => m.parts().map(|(_, l)| l.lower()).fold(f64::INFINITY, f64::min),
        }
    }

    /// Nodes (x, probability) of the Gauss rule that belongs to the law: E[f(x)] ≈ Σ probability·f(x).
    /// Exact for polynomials in x up to degree 2n − 1 (lognormal: in ln x; Weibull of shape < ½
    /// and its tilted forms: in (x/scale)^shape). Probabilities sum to 1. A constant gives one node, a
    /// mixture n for each of its laws.
    pub fn nodes(&self, n: usize) -> Vec<(f64, f64)> {
        let n = n.max(1);
        match self {
            SizeLaw::Constant(c) => vec![(*c, 1.0)],
            SizeLaw::Bins(l) => gauss(&l.points(&gauss_legendre(n.max(16), 0.0, 1.0)), n),
            SizeLaw::Lognormal(l) => l.nodes(n),
            SizeLaw::Gamma(l) => l.nodes(n),
            SizeLaw::Bounded(l) => gauss(&l.points(), n),
            SizeLaw::Mixture(m) => {
                m.parts().flat_map(|(w, l)| l.nodes(n).into_iter().map(move |(x, p)| (x, w * p))).collect()
            }
        }
    }
}

fn check_weights(weights: impl Iterator<Item = f64>) -> Result<(), LawError> {
    let mut total = 0.0;
    for w in weights {
        total += check("weight", w, "finite and ≥ 0", w >= 0.0)?;
    }
    if total > 0.0 { Ok(()) } else { Err(LawError::NoWeight) }
}
