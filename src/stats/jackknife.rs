//! Standard errors of functions of means.

use crate::math::Sum;

/// Value and standard error of functions of the means of several scores.
///
/// `replicas` are (histories n_r, sums of each score over them), independent of each other; `f` maps
/// the means per history to any number of figures (reflectance, brightness, L*a*b* …) at once. The
/// value is f at the overall means. The error is the delete-one jackknife for unequal group sizes
/// (Busing, Meijer & van der Leeden 1999, doi:10.1023/A:1008800423698): with h_r = n/n_r,
/// pseudo-values t_r = h_r f − (h_r − 1) f₍₋ᵣ₎ and t their n_r-weighted mean,
/// se² = (1/R) Σ (t_r − t)²/(h_r − 1). For equal sizes this is the usual (R−1)/R Σ (f₍₋ᵣ₎ − f̄)².
///
/// Empty replicas are left out; with fewer than two the error is NaN. NaN of `f` passes through.
pub fn jackknife(replicas: &[(u64, Vec<f64>)], f: impl Fn(&[f64]) -> Vec<f64>) -> Vec<(f64, f64)> {
    let replicas: Vec<&(u64, Vec<f64>)> = replicas.iter().filter(|(n, _)| *n > 0).collect();
    let n: u64 = replicas.iter().map(|r| r.0).sum();
    let width = replicas.first().map_or(0, |r| r.1.len());
    // Without replica r the sums are added anew: subtracting it from the total would cancel.
    let figures = |without: Option<usize>| {
        let kept = || replicas.iter().enumerate().filter(move |(i, _)| Some(*i) != without).map(|(_, r)| r);
        let histories = kept().map(|r| r.0).sum::<u64>() as f64;
        let mean = |k: usize| kept().map(|r| r.1[k]).collect::<Sum>().value() / histories;
        f(&(0..width).map(mean).collect::<Vec<f64>>())
    };
    let values = figures(None);
    if replicas.len() < 2 {
        return values.into_iter().map(|v| (v, f64::NAN)).collect();
    }
    let deleted: Vec<Vec<f64>> = (0..replicas.len()).map(|r| figures(Some(r))).collect();
    let share: Vec<f64> = replicas.iter().map(|r| r.0 as f64 / n as f64).collect();
    let error = |k: usize| {
        let pseudo = |r: usize| (values[k] - (1.0 - share[r]) * deleted[r][k]) / share[r];
        let centre = (0..deleted.len()).map(|r| share[r] * pseudo(r)).collect::<Sum>().value();
        let term = |r: usize| (pseudo(r) - centre) * (pseudo(r) - centre) / (1.0 / share[r] - 1.0);
        ((0..deleted.len()).map(term).collect::<Sum>().value() / deleted.len() as f64).sqrt()
    };
    (0..values.len()).map(|k| (values[k], error(k))).collect()
}
