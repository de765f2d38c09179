//! Are two means the same? Difference and equivalence are different questions: not to see a difference
//! is no proof that there is none.

use super::student::{student_cdf, student_quantile};

/// A difference of two means, tested both ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tested {
    /// P of a difference as large or larger if the means were equal (two-sided, Student's t).
    pub p_difference: f64,
    /// P of a difference as small or smaller if the means were a margin apart: the larger of two one-sided
    /// tests (Schuirmann 1987, doi:10.1007/BF01068419).
    pub p_equivalence: f64,
}

impl Tested {
    /// Of a difference with standard error `error` of `dof` degrees of freedom against ± `margin`. Without
    /// an error (0: both exact) the answer is certain; NaN passes through.
    pub fn of(difference: f64, error: f64, dof: f64, margin: f64) -> Tested {
        if error == 0.0 {
            let certain = |yes: bool| if yes { 0.0 } else { 1.0 };
            return Tested {
                p_difference: certain(difference != 0.0),
                p_equivalence: certain(difference.abs() < margin),
            };
        }
        // Far tails by the distribution at −|t|: 1 − P would cancel.
        let tail = |t: f64| student_cdf(-t, dof);
        Tested {
            p_difference: (2.0 * tail((difference / error).abs())).min(1.0),
            p_equivalence: tail((difference + margin) / error).max(tail((margin - difference) / error)),
        }
    }
}

/// p-values of a family of tests adjusted so that all verdicts together are wrong with at most the level
/// of one (Holm 1979): pᵢ ≤ … ranked upwards, max over j ≤ i of min(1, (m − j + 1) pⱼ). NaN counts as 1.
pub fn holm(p: &[f64]) -> Vec<f64> {
    let of = |i: usize| if p[i].is_nan() { 1.0 } else { p[i] };
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| of(a).total_cmp(&of(b)));
    let mut out = vec![1.0; p.len()];
    let mut largest = 0.0_f64;
    for (rank, &i) in order.iter().enumerate() {
        largest = largest.max((of(i) * (p.len() - rank) as f64).min(1.0));
        out[i] = largest;
    }
    out
}

/// The standard error at which a difference would be decided with probability .8, tests at level `alpha`:
/// the larger of those that show it (difference ≠ 0) and that show it to be within the margin.
pub fn deciding_error(difference: f64, margin: f64, alpha: f64) -> f64 {
    let z = |p: f64| student_quantile(p, f64::INFINITY);
    let power = z(0.8);
    let shown = difference.abs() / (z(1.0 - 0.5 * alpha) + power);
    // At no difference both one-sided tests must succeed: a power of .9 each.
    let equal = (margin - difference.abs()) / (z(1.0 - alpha) + z(0.9));
    shown.max(equal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    #[test]
    fn holm_by_hand() {
        // Sorted .01 .02 .03 .04, times 4 3 2 1: .04 .06 .06 .06.
        assert_eq!(holm(&[0.04, 0.01, 0.03, 0.02]), [0.06, 0.04, 0.06, 0.06]);
        assert_eq!(holm(&[0.5, f64::NAN, 0.9]), [1.0, 1.0, 1.0]);
        assert!(holm(&[]).is_empty());
    }

    #[test]
    fn the_two_questions_have_their_own_answers() {
        // Well known and small: different, and within the margin.
        let t = Tested::of(0.001, 0.0001, 1e9, 0.005);
        assert!(t.p_difference < 1e-20 && t.p_equivalence < 1e-20);
        // Known badly: neither.
        let t = Tested::of(0.001, 0.01, 1e9, 0.005);
        assert!(t.p_difference > 0.9 && t.p_equivalence > 0.3);
        // At the margin: as likely as not.
        assert!((Tested::of(0.005, 0.001, 1e9, 0.005).p_equivalence - 0.5).abs() < 1e-9);
        assert_eq!(Tested::of(0.0, 0.0, 9.0, 0.1).p_equivalence, 0.0);
        assert!(Tested::of(f64::NAN, 1.0, 9.0, 0.1).p_equivalence.is_nan());
    }

    /// Of pairs exactly a margin apart, 5 % are called equivalent at the most; of equal pairs, 5 % different.
    #[test]
    fn false_verdicts_are_as_rare_as_the_level_says() {
        let mut rng = Stream::of(4, 0, 0, Purpose::Probe);
        let normal = |rng: &mut Stream| {
            let (r, a) = ((2.0 * rng.exponential()).sqrt(), 2.0 * crate::math::PI * rng.uniform());
            r * crate::math::cos(a)
        };
        const N: u32 = 20_000;
        let (mut same, mut apart) = (0, 0);
        for _ in 0..N {
            // Five batches a mean: the error is known with 4 degrees of freedom.
            let mut measured = |mean: f64| {
                let x: Vec<f64> = (0..5).map(|_| mean + normal(&mut rng)).collect();
                let m = x.iter().sum::<f64>() / 5.0;
                let var = x.iter().map(|x| (x - m) * (x - m)).sum::<f64>() / 4.0;
                (m, (var / 5.0).sqrt())
            };
            let (d, e) = measured(0.0);
            same += u32::from(Tested::of(d, e, 4.0, 3.0).p_difference < 0.05);
            let (d, e) = measured(3.0);
            apart += u32::from(Tested::of(d, e, 4.0, 3.0).p_equivalence < 0.05);
        }
        for k in [same, apart] {
            assert!((f64::from(k) / f64::from(N) - 0.05).abs() < 0.006, "{same} {apart} of {N}");
        }
    }

    #[test]
    fn the_deciding_error_decides() {
        let alpha = 1e-3;
        for d in [0.0, 0.001, 0.0045, 0.006, 0.03] {
            let e = deciding_error(d, 0.005, alpha);
            let t = Tested::of(d, e, 1e9, 0.005);
            assert!(t.p_difference < alpha || t.p_equivalence < alpha, "{d}: {e} {t:?}");
        }
    }
}
