//! Moments, intervals, jackknife, folds, goodness of fit.

use crate::stream;
use lightpro::stats::*;

#[test]
fn moments_agree_with_direct_computation() {
    let mut rng = stream(1);
    // Two histories of three score nothing, as in a rare fate.
    let scores: Vec<f64> =
        (0..5000).map(|_| if rng.uniform() < 0.33 { rng.exponential() } else { 0.0 }).collect();
    let (mut whole, mut left, mut right) = (Moments::default(), Moments::default(), Moments::default());
    for (i, w) in scores.iter().enumerate() {
        whole.add(*w);
        if i < 1234 { left.add(*w) } else { right.add(*w) }
    }
    left.merge(&right);
    assert_eq!(left.n, whole.n);
    assert_eq!(Moments::from_sums(whole.n, whole.sums), whole);

    let n = scores.len() as f64;
    let mean = scores.iter().sum::<f64>() / n;
    let about = |k: i32| scores.iter().map(|w| (w - mean).powi(k)).sum::<f64>();
    let variance = about(2) / (n - 1.0);
    let se = (variance / n).sqrt();
    for m in [whole, left] {
        for (name, got, want) in [
            ("mean", m.mean(), mean),
            ("variance", m.variance(), variance),
            ("standard error", m.standard_error(), se),
            ("relative error", m.relative_error(), se / mean),
            ("skewness", m.skewness(), about(3) / n / (about(2) / n).powf(1.5)),
            ("vov", m.vov(), about(4) / about(2).powi(2) - 1.0 / n),
            ("figure of merit", m.figure_of_merit(2.5), (mean / se).powi(2) / 2.5),
        ] {
            assert!((got / want - 1.0).abs() < 1e-12, "{name}: {got} instead of {want}");
        }
    }
}

#[test]
fn degenerate_moments() {
    let mut m = Moments::default();
    assert!(m.mean().is_nan() && m.variance().is_nan());
    m.add(2.0);
    assert_eq!(m.mean(), 2.0);
    assert!(m.standard_error().is_nan());
    m.add(2.0);
    assert_eq!((m.variance(), m.vov(), m.skewness()), (0.0, 0.0, 0.0));
}

#[test]
fn student_quantiles() {
    for (dof, want) in [
        (1.0, 12.706_204_736_174_69),
        (2.0, 4.302_652_729_749_462),
        (5.0, 2.570_581_835_636_313_6),
        (9.0, 2.262_157_162_798_205),
        (30.0, 2.042_272_456_301_236),
        (99.0, 1.984_216_951_508_683),
        (199.0, 1.971_956_544_249_395),
        (1000.0, 1.962_339_080_791_641_7),
        (100_000.0, 1.959_987_709_080_094),
        (1e9, 1.959_963_984_540_054),
    ] {
        let (lo, hi) = interval95(0.0, 1.0, dof);
        assert!((hi / want - 1.0).abs() < 1e-7, "{dof}: {hi} instead of {want}");
        assert_eq!(lo, -hi);
    }
    assert!(interval95(0.0, 1.0, 0.0).0.is_nan());
}

/// 95 % intervals of the mean of 5, 10 and 40 batches of normal scores cover the truth 95 times in 100.
#[test]
fn intervals_cover_the_truth() {
    for (k, batches) in [5_u32, 10, 40].into_iter().enumerate() {
        let mut rng = stream(10 + k as u64);
        let trials = 8000;
        let mut covered = 0.0;
        for _ in 0..trials {
            let mut m = Moments::default();
            (0..batches).for_each(|_| m.add(3.0 + rng.normal()));
            let (lo, hi) = interval95(m.mean(), m.standard_error(), f64::from(batches - 1));
            covered += f64::from(u8::from(lo <= 3.0 && 3.0 <= hi));
        }
        let share = covered / f64::from(trials);
        let sd = (0.95_f64 * 0.05 / f64::from(trials)).sqrt();
        assert!((share - 0.95).abs() < 3.5 * sd, "{batches} batches: {share}");
    }
}

#[test]
fn doubtful_results_say_why() {
    let mut good = Moments::default();
    let mut rng = stream(20);
    (0..1000).for_each(|_| good.add(rng.uniform()));
    assert_eq!(status(&good, Some(1000), 20), Status::Ok);
    assert_eq!(status(&good, None, 20), Status::Ok);
    assert_eq!(status(&good, Some(99), 20), Status::Unreliable("fewer than 100 histories scored"));
    assert_eq!(status(&good, Some(1000), 9), Status::Unreliable("fewer than 10 batches"));
    let mut rare = good;
    rare.add(1e4);
    assert!(rare.vov() > 0.1);
    assert_eq!(status(&rare, None, 20), Status::Unreliable("variance of the variance above 0.1"));
    let none = Moments::from_sums(5000, [0.0; 4]);
    assert_eq!(status(&none, None, 20), Status::UpperBound);
    // (1 − p)ⁿ = 0.05 at the bound.
    let p = upper_bound95(5000);
    assert!(((1.0 - p).powi(5000) / 0.05 - 1.0).abs() < 0.01);
}

/// Replicas of two correlated scores with means 2 and 5.
fn replicas(rng: &mut lightpro::rng::Stream, sizes: &[u64]) -> Vec<(u64, Vec<f64>)> {
    let one = |n: &u64| {
        let mut sums = vec![0.0; 2];
        for _ in 0..*n {
            let a = rng.exponential();
            sums[0] += 2.0 * a;
            sums[1] += 4.0 + 0.5 * a + 0.5 * rng.exponential();
        }
        (*n, sums)
    };
    sizes.iter().map(one).collect()
}

#[test]
fn jackknife_of_a_mean_is_the_standard_error() {
    let r = replicas(&mut stream(30), &[50; 24]);
    let got = jackknife(&r, |m| m.to_vec());
    for (k, (value, se)) in got.iter().enumerate() {
        let mut batch = Moments::default();
        r.iter().for_each(|(n, s)| batch.add(s[k] / *n as f64));
        assert!((value / batch.mean() - 1.0).abs() < 1e-14);
        assert!((se / batch.standard_error() - 1.0).abs() < 1e-10, "{se} {}", batch.standard_error());
    }
}

/// Delta method: var(a/b)·N = var a/b² + a² var b/b⁴ − 2a cov/b³, here with var a = 4, var b = 0.5,
/// cov = 1, a = 2, b = 5.
#[test]
fn jackknife_of_a_ratio_agrees_with_the_delta_method_and_the_spread() {
    let delta = 4.0 / 25.0 + 4.0 * 0.5 / 625.0 - 2.0 * 2.0 / 125.0;
    let unequal: Vec<u64> = (0..60).map(|i| 20 + 5 * (i % 7)).collect();
    for (k, sizes) in [vec![40; 60], unequal].into_iter().enumerate() {
        let histories: u64 = sizes.iter().sum();
        let want = (delta / histories as f64).sqrt();
        let mut rng = stream(40 + k as u64);
        let (mut spread, mut errors) = (Moments::default(), Moments::default());
        for _ in 0..600 {
            let got = jackknife(&replicas(&mut rng, &sizes), |m| vec![m[0] / m[1]]);
            spread.add(got[0].0);
            errors.add(got[0].1 * got[0].1);
        }
        // 600 repetitions know a variance to √(2/600) = 6 %, the mean error far better.
        assert!((errors.mean().sqrt() / want - 1.0).abs() < 0.02, "{} {want}", errors.mean().sqrt());
        assert!((spread.variance().sqrt() / want - 1.0).abs() < 0.09, "{} {want}", spread.variance().sqrt());
        assert!((spread.mean() - 0.4).abs() < 4.0 * spread.standard_error());
    }
}

#[test]
fn jackknife_passes_not_a_number_through_and_knows_its_limits() {
    let r = replicas(&mut stream(50), &[10; 5]);
    let got = jackknife(&r, |m| vec![f64::NAN, m[0]]);
    assert!(got[0].0.is_nan() && got[0].1.is_nan() && got[1].1 > 0.0);
    let one = jackknife(&r[..1], |m| m.to_vec());
    assert!(one[0].0 > 0.0 && one[0].1.is_nan());
    let mut padded = r.clone();
    padded.insert(2, (0, vec![0.0, 0.0]));
    assert_eq!(jackknife(&padded, |m| m.to_vec()), jackknife(&r, |m| m.to_vec()));
    assert!(jackknife(&[], |m| m.to_vec()).is_empty());
}

/// The order of merges, written out.
#[derive(Clone, Debug, PartialEq)]
struct Tree(String);
impl Merge for Tree {
    fn merge(&mut self, later: Self) {
        self.0 = format!("({} {})", self.0, later.0);
    }
}

fn whole(n: u64) -> Fold<Tree> {
    let mut fold = Fold::default();
    (0..n).for_each(|i| fold.push(Tree(i.to_string())));
    fold
}

#[test]
fn fold_is_a_fixed_binary_tree() {
    assert_eq!(whole(0).finish(), None);
    assert_eq!(whole(1).finish().unwrap().0, "0");
    assert_eq!(whole(4).finish().unwrap().0, "((0 1) (2 3))");
    assert_eq!(whole(7).finish().unwrap().0, "(((0 1) (2 3)) ((4 5) 6))");
    assert_eq!(whole(7).peek(), whole(7).finish());
    assert_eq!(whole(7).next(), 7);
}

#[test]
fn fold_does_not_depend_on_how_the_batches_are_shared_out() {
    let n = 41;
    let want = whole(n);
    let mut rng = stream(60);
    for trial in 0..500 {
        let mut cuts: Vec<u64> = (0..1 + trial % 5).map(|_| rng.bits() % (n + 1)).collect();
        cuts.extend([0, n]);
        cuts.sort_unstable();
        let mut total = Fold::default();
        for range in cuts.windows(2) {
            let mut shard = Fold::starting_at(range[0]);
            (range[0]..range[1]).for_each(|i| shard.push(Tree(i.to_string())));
            for node in shard.nodes() {
                total.push_node(node.clone()).expect("aligned and in order");
            }
        }
        assert_eq!(total, want, "{cuts:?}");
        assert_eq!(total.finish(), want.peek());
    }
}

#[test]
fn fold_refuses_gaps_and_misaligned_nodes() {
    let mut fold = whole(2);
    let node = |first, level| Node { first, level, value: Tree(String::new()) };
    assert!(fold.push_node(node(3, 0)).is_err());
    assert!(fold.push_node(node(2, 2)).is_err());
    assert!(fold.push_node(node(2, 1)).is_ok());
    assert_eq!(fold.next(), 4);
}

#[test]
fn chi_square_tail_values() {
    // 5 % points of the chi-square law.
    for (x, dof) in
        [(3.841_458_820_694_124, 1.0), (18.307_038_053_275_146, 10.0), (124.342_113_404_004_1, 100.0)]
    {
        assert!((chi_square_p(x, dof) - 0.05).abs() < 1e-9, "{dof}: {}", chi_square_p(x, dof));
    }
}

/// At the 5 % level, 400 true hypotheses raise about 20 alarms: within the 99.9 % binomial bounds.
#[test]
fn goodness_of_fit_tests_keep_their_error_rates() {
    let (mut chi, mut ks) = (0, 0);
    let shares = [0.2, 0.3, 0.002, 0.001, 0.15, 0.147, 0.1, 0.1];
    for seed in 0..400 {
        let mut rng = stream(1000 + seed);
        let mut counts = [0.0; 8];
        for _ in 0..1000 {
            let u = rng.uniform();
            let mut sum = 0.0;
            let cell = shares.iter().position(|s| {
                sum += s;
                u < sum
            });
            counts[cell.unwrap_or(7)] += 1.0;
        }
        chi += u32::from(chi_square_pooled(&counts, &shares.map(|s| 1000.0 * s)) < 0.05);
        let mut sample: Vec<f64> = (0..200).map(|_| rng.exponential()).collect();
        sample.sort_by(f64::total_cmp);
        ks += u32::from(ks_p_value(&sample, |x| 1.0 - (-x).exp()) < 0.05);
    }
    println!("alarms: chi-square {chi}, Kolmogorov–Smirnov {ks} of 400");
    for alarms in [chi, ks] {
        assert!((8..=35).contains(&alarms), "{chi} {ks}");
    }
}

#[test]
fn goodness_of_fit_tests_notice_a_wrong_law() {
    let mut rng = stream(70);
    let mut sample: Vec<f64> = (0..5000).map(|_| 1.1 * rng.exponential()).collect();
    sample.sort_by(f64::total_cmp);
    assert!(ks_p_value(&sample, |x| 1.0 - (-x).exp()) < 1e-4);
    assert!(ks_p_value(&sample, |x| 1.0 - (-x / 1.1).exp()) > 1e-3);
    assert_eq!(chi_square_pooled(&[10.0, 1.0], &[11.0, 0.0]), 0.0);
    assert!(chi_square_pooled(&[60.0, 40.0], &[50.0, 50.0]) < 0.05);
    assert_eq!(chi_square_pooled(&[3.0, 4.0], &[4.0, 3.0]), 1.0);
    assert!(chi_square_pooled(&[3.0, 4.0], &[f64::NAN, 3.0]).is_nan());
}

#[test]
fn sidak_shares_out_the_false_alarm_rate() {
    for m in [1, 7, 1000] {
        let level = sidak(0.01, m);
        assert!(((1.0 - level).powi(m as i32) - 0.99).abs() < 1e-12);
    }
}

#[test]
fn normal_tail_values() {
    for (z, p) in [
        (0.0, 1.0),
        (1.959_963_984_540_054, 0.05),
        (-3.290_526_731_491_926, 0.001),
        (6.0, 1.973_175_290_075e-9),
    ] {
        assert!((z_p_value(z) / p - 1.0).abs() < 1e-11, "{z}: {}", z_p_value(z));
    }
}

/// The z-test against a stored mean and variance: of 400 seeds about 20 alarm at the 5 % level, scores
/// rare and skewed as fates are; families of 20 at the Šidák level about as many; and it bites.
#[test]
fn the_z_test_keeps_its_error_rate_and_bites() {
    // Score e with probability 0.3, else nothing: mean 0.3, variance 0.3·2 − 0.09.
    let run = |seed: u64, n: u32, shift: f64| {
        let mut rng = stream(seed);
        let mut m = Moments::default();
        (0..n).for_each(|_| m.add(if rng.uniform() < 0.3 { rng.exponential() + shift } else { 0.0 }));
        m
    };
    let exact = Stored { mean: 0.3, variance: 0.51, histories: f64::INFINITY };
    let (mut alarms, mut of_two, mut families) = (0, 0, 0);
    for seed in 0..400 {
        alarms += u32::from(z_p_value(exact.z(&run(5000 + seed, 2000, 0.0))) < 0.05);
        // Against another run of a tenth of the histories.
        let other = run(15_000 + seed, 200, 0.0);
        let stored = Stored { mean: other.mean(), variance: 0.51, histories: 200.0 };
        of_two += u32::from(z_p_value(stored.z(&run(25_000 + seed, 2000, 0.0))) < 0.05);
        let level = sidak(0.05, 20);
        let mut family = (0..20).map(|k| exact.z(&run(100_000 + 20 * seed + k, 2000, 0.0)));
        families += u32::from(family.any(|z| z_p_value(z) < level));
    }
    println!("alarms of 400: exact {alarms}, stored run {of_two}, families of 20 {families}");
    // 99.9 % bounds of the binomial law of 400 trials at 5 %, as above.
    assert!([alarms, of_two, families].iter().all(|n| (8..=35).contains(n)), "{alarms} {of_two} {families}");
    // Scores 0.04 higher: the mean is off by 0.012, 5 standard errors of 1e5 histories.
    assert!(exact.z(&run(1, 100_000, 0.04)).abs() > 3.0);
}
