//! Student's t, for intervals and tests of means.

use crate::math::{PI, erfc, tan};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Degrees of freedom from which Student's t is taken as normal in [`student_cdf`] (they differ by less
/// than 1e-6 there).
const NORMAL: f64 = 1e6;

/// P(T ≤ t) of Student's t with `dof` degrees of freedom (∞: normal); NaN for dof < 1.
pub fn student_cdf(t: f64, dof: f64) -> f64 {
    if dof.is_nan() || dof < 1.0 || t.is_nan() {
        return f64::NAN;
    }
    if dof >= NORMAL || t.is_infinite() {
        return 0.5 * erfc(-t * std::f64::consts::FRAC_1_SQRT_2);
    }
    StudentsT::new(0.0, 1.0, dof).map_or(f64::NAN, |law| law.cdf(t))
}

/// The quantile t with P(T ≤ t) = `p` of Student's t with `dof` degrees of freedom (∞: normal), by
/// bisection of [`student_cdf`] to the last bit but a few; NaN for dof < 1 or p outside (0, 1).
pub fn student_quantile(p: f64, dof: f64) -> f64 {
    if dof.is_nan() || dof < 1.0 || !(p > 0.0 && p < 1.0) {
        return f64::NAN;
    }
    if p == 0.975 {
        return two_sided95(dof);
    }
    if dof == 1.0 {
        return tan(PI * (p - 0.5));
    }
    let upper = p.max(1.0 - p);
    let mut high = 1.0;
    while student_cdf(high, dof) < upper && high < 1e8 {
        high *= 2.0;
    }
    let mut low = 0.0;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if student_cdf(middle, dof) < upper { low = middle } else { high = middle }
    }
    if p < 0.5 { -0.5 * (low + high) } else { 0.5 * (low + high) }
}

/// 97.5 % quantile of Student's t.
pub(super) fn two_sided95(dof: f64) -> f64 {
    if dof.is_nan() || dof < 1.0 {
        return f64::NAN;
    }
    if dof == 1.0 {
        return tan(0.475 * PI);
    }
    if dof >= 200.0 {
        // Expansion about the normal quantile (Abramowitz & Stegun 26.7.5), to 1e-10 here.
        const Z: f64 = 1.959_963_984_540_054;
        const Z2: f64 = Z * Z;
        let first = Z * (Z2 + 1.0) / 4.0;
        let second = Z * ((5.0 * Z2 + 16.0) * Z2 + 3.0) / 96.0;
        let third = Z * (((3.0 * Z2 + 19.0) * Z2 + 17.0) * Z2 - 15.0) / 384.0;
        return Z + (first + (second + third / dof) / dof) / dof;
    }
    StudentsT::new(0.0, 1.0, dof).map_or(f64::NAN, |t| t.inverse_cdf(0.975))
}

/// Welch–Satterthwaite degrees of freedom of √(Σ e²), each error e with its own (Welch 1947,
/// doi:10.1093/biomet/34.1-2.28): (Σ e²)²/Σ(e⁴/ν).
pub fn welch(parts: &[(f64, f64)]) -> f64 {
    let total: f64 = parts.iter().map(|(e, _)| e * e).sum();
    let spread: f64 = parts.iter().map(|(e, dof)| (e * e) * (e * e) / dof).sum();
    if spread > 0.0 { total * total / spread } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_meet_the_tables() {
        // Abramowitz & Stegun, table 26.10.
        for (p, dof, t) in [
            (0.95, 9.0, 1.833),
            (0.995, 9.0, 3.250),
            (0.95, 31.0, 1.696),
            (0.975, 9.0, 2.262),
            (0.95, f64::INFINITY, 1.645),
            (0.95, 1.0, 6.314),
            (0.999, 3.0, 10.215),
        ] {
            assert!((student_quantile(p, dof) - t).abs() < 6e-4, "{p} {dof}: {}", student_quantile(p, dof));
            assert!((student_cdf(student_quantile(p, dof), dof) - p).abs() < 1e-9);
            assert!((student_quantile(1.0 - p, dof) + student_quantile(p, dof)).abs() < 1e-6);
        }
        assert!(student_quantile(0.9, 0.5).is_nan() && student_cdf(1.0, f64::NAN).is_nan());
    }

    #[test]
    fn welch_keeps_equal_parts_and_drops_exact_ones() {
        assert!((welch(&[(1.0, 9.0), (1.0, 9.0)]) - 18.0).abs() < 1e-12);
        assert!((welch(&[(1.0, 9.0), (0.0, 2.0)]) - 9.0).abs() < 1e-12);
        assert_eq!(welch(&[(1.0, f64::INFINITY)]), f64::INFINITY);
    }
}
