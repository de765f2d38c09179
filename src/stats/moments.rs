//! Moments of the scores of histories, and what they say about a mean.

use super::fold::Merge;
use super::student::two_sided95;

/// First four moments of the score w of a history; histories that scored nothing count as w = 0.
///
/// Central moments are formed from the raw sums, so they lose about 2·log₁₀(mean/sd) digits
/// (fourth: twice that) when the scores hardly vary.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// Number of histories.
    pub n: u64,
    /// Σw, Σw², Σw³, Σw⁴.
    pub sums: [f64; 4],
}

impl Moments {
    /// From the number of histories and Σw, Σw², Σw³, Σw⁴.
    pub fn from_sums(n: u64, sums: [f64; 4]) -> Self {
        Moments { n, sums }
    }

    /// Adds the score of one history.
    #[inline]
    pub fn add(&mut self, w: f64) {
        let w2 = w * w;
        self.n += 1;
        self.sums[0] += w;
        self.sums[1] += w2;
        self.sums[2] += w2 * w;
        self.sums[3] += w2 * w2;
    }

    /// Adds the scores of other histories.
    pub fn merge(&mut self, other: &Moments) {
        self.n += other.n;
        for (a, b) in self.sums.iter_mut().zip(other.sums) {
            *a += b;
        }
    }

    /// Raw moment E[w^k], k = 1…4.
    fn raw(&self, k: usize) -> f64 {
        self.sums[k - 1] / self.n as f64
    }

    /// Σ(w − w̄)^k / n for k = 2, 3, 4; the even ones are never negative.
    fn central(&self) -> [f64; 3] {
        let m = self.raw(1);
        let (r2, r3, r4) = (self.raw(2), self.raw(3), self.raw(4));
        let m2 = r2 - m * m;
        let m3 = r3 - m * (3.0 * r2 - 2.0 * m * m);
        let m4 = r4 - m * (4.0 * r3 - m * (6.0 * r2 - 3.0 * m * m));
        [m2.max(0.0), m3, m4.max(0.0)]
    }

    /// Mean score per history; NaN without histories.
    pub fn mean(&self) -> f64 {
        self.raw(1)
    }

    /// Unbiased variance of the score of one history, Σ(w − w̄)²/(n − 1); NaN for n < 2.
    pub fn variance(&self) -> f64 {
        if self.n < 2 {
            return f64::NAN;
        }
        self.central()[0] * self.n as f64 / (self.n - 1) as f64
    }

    /// Standard error of the mean.
    pub fn standard_error(&self) -> f64 {
        (self.variance() / self.n as f64).sqrt()
    }

    /// Standard error / |mean|.
    pub fn relative_error(&self) -> f64 {
        self.standard_error() / self.mean().abs()
    }

    /// Relative variance of the variance as MCNP defines it (LA-UR-03-1987, eq. 2.19):
    /// Σ(w − w̄)⁴ / (Σ(w − w̄)²)² − 1/n; 0 when the scores do not vary.
    pub fn vov(&self) -> f64 {
        let [m2, _, m4] = self.central();
        if m2 == 0.0 { 0.0 } else { (m4 / (m2 * m2) - 1.0) / self.n as f64 }
    }

    /// Degrees of freedom of the standard error: a variance whose relative variance is VOV has about 2/VOV;
    /// never more than n − 1.
    pub fn dof(&self) -> f64 {
        (2.0 / self.vov()).min(self.n as f64 - 1.0)
    }

    /// Skewness of the score, m₃/m₂^(3/2); 0 when the scores do not vary.
    pub fn skewness(&self) -> f64 {
        let [m2, m3, _] = self.central();
        if m2 == 0.0 { 0.0 } else { m3 / (m2 * m2.sqrt()) }
    }

    /// Figure of merit 1/(relative error² · CPU time), 1/s: constant in a well-behaved run.
    pub fn figure_of_merit(&self, cpu_s: f64) -> f64 {
        let r = self.relative_error();
        1.0 / (r * r * cpu_s)
    }
}

impl Merge for Moments {
    fn merge(&mut self, later: Self) {
        Moments::merge(self, &later);
    }
}

/// Two-sided 95 % confidence interval (low, high) of a mean by Student's t with `dof` degrees of
/// freedom; NaN for dof < 1.
pub fn interval95(mean: f64, se: f64, dof: f64) -> (f64, f64) {
    let t = two_sided95(dof);
    (mean - t * se, mean + t * se)
}

/// Whether a mean and its confidence interval can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// They can.
    Ok,
    /// They cannot, for this reason.
    Unreliable(&'static str),
    /// Nothing scored: only the upper bound of [`upper_bound95`] is known.
    UpperBound,
}

/// Judges a mean: no score → upper bound; fewer than 100 scoring histories (if their number is
/// known), fewer than 10 batches, or variance of the variance above 0.1 → unreliable.
pub fn status(moments: &Moments, scoring: Option<u64>, batches: u64) -> Status {
    if scoring == Some(0) || moments.sums[1] == 0.0 {
        Status::UpperBound
    } else if scoring.is_some_and(|s| s < 100) {
        Status::Unreliable("fewer than 100 histories scored")
    } else if batches < 10 {
        Status::Unreliable("fewer than 10 batches")
    } else if moments.vov() > 0.1 {
        Status::Unreliable("variance of the variance above 0.1")
    } else {
        Status::Ok
    }
}

/// 95 % upper bound 3/n of the probability of an event that n histories never showed
/// ((1 − p)ⁿ = 0.05), for scores of at most 1.
pub fn upper_bound95(n: u64) -> f64 {
    3.0 / n as f64
}
