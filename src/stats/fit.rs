//! Goodness of fit: does a sample follow its law?

use super::Moments;
use crate::math::{erfc, exp, expm1, ln_1p};
use statrs::function::gamma::checked_gamma_ur;

/// P(χ² of `dof` degrees of freedom ≥ statistic).
pub fn chi_square_p(statistic: f64, dof: f64) -> f64 {
    if statistic <= 0.0 {
        return 1.0;
    }
    if statistic == f64::INFINITY {
        return 0.0;
    }
    checked_gamma_ur(0.5 * dof, 0.5 * statistic).unwrap_or(f64::NAN)
}

/// p-value of Pearson's chi-square test of counts against expected counts of the same total.
///
/// Neighbouring cells are pooled until each expects at least 5; degrees of freedom are the pooled
/// cells − 1. 1 when fewer than two pooled cells remain; 0 when something was observed where nothing
/// at all is expected; NaN passes through.
pub fn chi_square_pooled(observed: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(observed.len(), expected.len(), "one expected count for each observed one");
    let mut cells: Vec<(f64, f64)> = Vec::new();
    let mut open = (0.0, 0.0);
    for (o, e) in observed.iter().zip(expected) {
        if e.is_nan() || (*e <= 0.0 && *o > 0.0) {
            return if e.is_nan() { f64::NAN } else { 0.0 };
        }
        open = (open.0 + o, open.1 + e);
        if open.1 >= 5.0 {
            cells.push(open);
            open = (0.0, 0.0);
        }
    }
    if let Some(last) = cells.last_mut() {
        *last = (last.0 + open.0, last.1 + open.1);
    }
    if cells.len() < 2 {
        return 1.0;
    }
    let statistic: f64 = cells.iter().map(|(o, e)| (o - e) * (o - e) / e).sum();
    chi_square_p(statistic, (cells.len() - 1) as f64)
}

/// p-value of the Kolmogorov–Smirnov test of a sorted sample against a continuous CDF: the asymptotic
/// law with Stephens' (1970) correction for finite n, good to about 0.01 from n = 10 on.
pub fn ks_p_value(sorted: &[f64], cdf: impl Fn(f64) -> f64) -> f64 {
    let n = sorted.len() as f64;
    let gap = |(i, x): (usize, &f64)| {
        let c = cdf(*x);
        (c - i as f64 / n).max((i + 1) as f64 / n - c)
    };
    let d = sorted.iter().enumerate().map(gap).fold(0.0, f64::max);
    let lambda = (n.sqrt() + 0.12 + 0.11 / n.sqrt()) * d;
    if lambda < 0.3 {
        return 1.0;
    }
    let term = |k: i32| {
        let k = f64::from(k);
        2.0 * exp(-2.0 * k * k * lambda * lambda)
    };
    (1..=50).map(|k| if k % 2 == 1 { term(k) } else { -term(k) }).sum::<f64>().clamp(0.0, 1.0)
}

/// Level of each of `family` independent tests so that the family raises a false alarm with
/// probability `alpha` (Šidák 1967): 1 − (1 − α)^(1/m).
pub fn sidak(alpha: f64, family: usize) -> f64 {
    -expm1(ln_1p(-alpha) / family.max(1) as f64)
}

/// P(|Z| ≥ |z|) of a standard normal Z.
pub fn z_p_value(z: f64) -> f64 {
    erfc(z.abs() * std::f64::consts::FRAC_1_SQRT_2)
}

/// A mean that an earlier run has found, with the variance of its histories.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stored {
    /// Mean score.
    pub mean: f64,
    /// Variance of the score of a history.
    pub variance: f64,
    /// Histories; infinite for a value known exactly.
    pub histories: f64,
}

impl Stored {
    /// Deviation of a new run's mean from the stored one in standard deviations of their difference. The
    /// stored variance serves for both: a new run without the rare high scores would else judge itself.
    pub fn z(&self, new: &Moments) -> f64 {
        let difference = new.mean() - self.mean;
        difference / (self.variance * (1.0 / new.n as f64 + 1.0 / self.histories)).sqrt()
    }
}
