//! Chi-square test of every phase function: `sample` against `pdf`; azimuth; mean cosine; pinned draws.
#![allow(clippy::disallowed_methods, missing_docs)]

use lightpro::math::{DVec3, gauss_legendre};
use lightpro::phase::{Phase, Polar, Table, mie};
use lightpro::rng::{Purpose, Stream};
use lightpro::stats::{self, chi_square_pooled};
use num_complex::Complex64;
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

const DRAWS: usize = 1_000_000;
/// Chance that a correct program fails one of these tests at all (seeds are fixed; Šidák over laws).
const ALPHA: f64 = 0.01;

fn stream(history: u64) -> Stream {
    Stream::of(20_261_122, 7, history, Purpose::Transport)
}

fn table() -> Phase {
    // A forward peak, an empty gap, an empty pole and a step: what a user's file may hold.
    let text =
        "angle_deg, p\n0, 900\n0.5, 300\n2, 20\n10, 1\n40, 0\n60, 0\n60.001, 0.2\n120, 0.1\n179, 0.3\n180, 0";
    Phase::Table(Arc::new(Table::from_csv(text).unwrap()))
}

fn laws() -> Vec<(&'static str, Phase)> {
    let hg = |g| Phase::henyey_greenstein(g).unwrap();
    let mixed = vec![
        (2.0, hg(0.95)),
        (1.0, Phase::Rayleigh),
        (0.0, hg(0.999)),
        (0.5, table()),
        (1.5, Phase::Isotropic),
    ];
    let calcite =
        mie::suspension(&[(0.8, 0.5), (2.0, 0.5)], Complex64::new(1.658, 0.0), 1.0, 550.0, 0.02).unwrap();
    vec![
        ("isotropic", Phase::Isotropic),
        ("Henyey–Greenstein 0", hg(0.0)),
        ("Henyey–Greenstein 1e-9", hg(1e-9)),
        ("Henyey–Greenstein 0.5", hg(0.5)),
        ("Henyey–Greenstein −0.7", hg(-0.7)),
        ("Henyey–Greenstein 0.95", hg(0.95)),
        ("Henyey–Greenstein −0.999", hg(-0.999)),
        ("Henyey–Greenstein 1 − 1e-6", hg(1.0 - 1e-6)),
        ("two-term", Phase::two_term(0.9, 0.8, -0.4).unwrap()),
        ("Rayleigh", Phase::Rayleigh),
        ("table", table()),
        ("Mie", calcite.phase),
        ("mixture", Phase::mixture(mixed).unwrap()),
    ]
}

/// Edges in t = 1 − |cos θ| towards both poles: five to a decade from 1e-15 on.
fn edges() -> Vec<f64> {
    (-75..=0).map(|i| if i == 0 { 1.0 } else { 10_f64.powf(f64::from(i) / 5.0) }).collect()
}

/// Distance to the nearer pole, from the sine where it is small: tests the sine too.
fn pole_distance(p: Polar) -> f64 {
    p.sin * p.sin / (1.0 + p.cos.abs())
}

fn counts(draws: &[Polar], edges: &[f64]) -> Vec<f64> {
    let n = edges.len();
    let mut counts = vec![0.0; 2 * n];
    for p in draws {
        let bin = edges.partition_point(|e| *e <= pole_distance(*p)).min(n - 1);
        counts[if p.cos >= 0.0 { bin } else { n + bin }] += 1.0;
    }
    counts
}

/// ∫ p dω over the bins, 64 panels of 8 Gauss points each (a table has kinks inside the bins).
fn expected(law: &Phase, edges: &[f64], draws: f64) -> Vec<f64> {
    let mut all = Vec::new();
    for side in [1.0, -1.0] {
        for i in 0..edges.len() {
            let (lo, hi) = (if i == 0 { 0.0 } else { edges[i - 1] }, edges[i]);
            let mut mass = 0.0;
            for k in 0..64 {
                let at = |k: usize| lo + (hi - lo) * k as f64 / 64.0;
                for (t, w) in gauss_legendre(8, at(k), at(k + 1)) {
                    mass += w * TAU * law.pdf(side * (1.0 - t));
                }
            }
            all.push(mass * draws);
        }
    }
    all
}

/// p-value; neighbouring bins are pooled up to an expectation of 5.
fn p_value(counts: &[f64], expected: &[f64]) -> f64 {
    chi_square_pooled(counts, expected)
}

fn sidak(tests: usize) -> f64 {
    stats::sidak(ALPHA, tests)
}

#[test]
fn samples_follow_the_density() {
    let (laws, edges) = (laws(), edges());
    for (i, (name, law)) in laws.iter().enumerate() {
        let mut rng = stream(i as u64);
        let draws: Vec<Polar> = (0..DRAWS).map(|_| law.sample(&mut rng)).collect();
        let want = expected(law, &edges, DRAWS as f64);
        let sum: f64 = want.iter().sum::<f64>() / DRAWS as f64;
        assert!((sum - 1.0).abs() < 1e-4, "{name}: the density integrates to {sum}");
        let p = p_value(&counts(&draws, &edges), &want);
        println!("{name}: p = {p:.4}");
        assert!(p > sidak(laws.len()), "{name}: p = {p}");
        for d in &draws {
            assert!((d.cos * d.cos + d.sin * d.sin - 1.0).abs() < 4e-15, "{name}: {d:?}");
        }
    }
}

/// The same test refuses a law that is off by little: g by 0.003 (0.01 at g = 0), a share by 0.01,
/// isotropic for Rayleigh, a table's forward peak by 5 %.
#[test]
fn the_test_bites() {
    let hg = |g| Phase::HenyeyGreenstein(g);
    let two = |w| Phase::TwoTerm { w, g1: 0.8, g2: -0.4 };
    let peak =
        |p0: f64| Phase::Table(Arc::new(Table::from_angles(&[(0.0, p0), (0.1, 1.0), (PI, 0.5)]).unwrap()));
    let cases = [
        (hg(0.5), hg(0.503)),
        (hg(-0.7), hg(-0.703)),
        (hg(0.0), hg(0.01)),
        (two(0.9), two(0.91)),
        (Phase::Rayleigh, Phase::Isotropic),
        (peak(100.0), peak(105.0)),
    ];
    let edges = edges();
    for (i, (drawn, claimed)) in cases.iter().enumerate() {
        let mut rng = stream(100 + i as u64);
        let draws: Vec<Polar> = (0..DRAWS).map(|_| drawn.sample(&mut rng)).collect();
        let counts = counts(&draws, &edges);
        let p = p_value(&counts, &expected(claimed, &edges, DRAWS as f64));
        assert!(p < sidak(laws().len()), "case {i} passes with p = {p}");
        assert!(p_value(&counts, &expected(drawn, &edges, DRAWS as f64)) > sidak(cases.len()), "case {i}");
    }
}

/// Mean of 1 − |g| over the draws, with its standard error: of the distance to the pole that the law
/// favours, so that no rounding of the cosine enters for a narrow lobe.
fn mean_turn(law: &Phase, rng: &mut Stream) -> (f64, f64) {
    let from = if law.mean_cosine() < 0.0 { -1.0 } else { 1.0 };
    let (mut sum, mut square) = (0.0, 0.0);
    for _ in 0..DRAWS {
        let p = law.sample(rng);
        let turned = if p.cos * from > 0.0 { pole_distance(p) } else { 1.0 - from * p.cos };
        sum += turned;
        square += turned * turned;
    }
    let n = DRAWS as f64;
    let mean = sum / n;
    (mean, ((square / n - mean * mean) / n).sqrt())
}

#[test]
fn mean_cosines() {
    let laws = laws();
    let limit = Normal::standard().inverse_cdf(1.0 - 0.5 * sidak(laws.len()));
    for (i, (name, law)) in laws.iter().enumerate() {
        let (mean, error) = mean_turn(law, &mut stream(200 + i as u64));
        let z = (mean - (1.0 - law.mean_cosine().abs())) / error;
        println!("{name}: 1 − |g| = {mean:e} ± {error:.1e}, z = {z:.2}");
        assert!(z.abs() < limit, "{name}: z = {z}");
    }
    // And it bites: draws at g = 0.5 claimed to be g = 0.504.
    let (mean, error) = mean_turn(&Phase::HenyeyGreenstein(0.5), &mut stream(250));
    assert!(((mean - (1.0 - 0.504)) / error).abs() > limit);
}

/// `scatter` turns by the sampled angle with a uniform azimuth, whatever the direction.
#[test]
fn scatter_is_axially_symmetric() {
    let directions = [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(0.48, -0.6, -0.64)];
    let law = Phase::HenyeyGreenstein(0.3);
    for (i, u) in directions.into_iter().enumerate() {
        let frame = lightpro::math::Frame::from_pole(u);
        let mut rng = stream(300 + i as u64);
        let mut cells = vec![0.0; 64];
        for _ in 0..DRAWS {
            let v = frame.to_local(law.scatter(u, &mut rng));
            assert!((v.length() - 1.0).abs() < 1e-14);
            let turn = (v.y.atan2(v.x) / TAU).rem_euclid(1.0);
            // Azimuth × the two halves of the law: independence of angle and azimuth as well.
            let upper = lightpro::phase::hg::cdf(v.z, 0.3) > 0.5;
            cells[((turn * 32.0) as usize).min(31) + if upper { 32 } else { 0 }] += 1.0;
        }
        let p = p_value(&cells, &vec![DRAWS as f64 / 64.0; 64]);
        assert!(p > sidak(directions.len()), "{u}: p = {p}");
    }
}

/// `max_on` bounds the density, and touches it for every law of one lobe.
#[test]
fn bounds_hold_and_are_tight() {
    for (name, law) in laws() {
        let mut rng = stream(400);
        for _ in 0..500 {
            let (a, b) = (2.0 * rng.uniform() - 1.0, 2.0 * rng.uniform() - 1.0);
            let (lo, hi) = (a.min(b), a.max(b));
            let bound = law.max_on(lo, hi);
            let most = (0..=400)
                .map(|i| law.pdf((lo + (hi - lo) * f64::from(i) / 400.0).min(hi)))
                .fold(0.0, f64::max);
            assert!(most <= bound * (1.0 + 1e-12), "{name}: {most} > {bound} on [{lo}, {hi}]");
            if matches!(law, Phase::Isotropic | Phase::HenyeyGreenstein(_))
                || (law == Phase::Rayleigh && lo * hi > 0.0)
            {
                assert!(most >= bound * (1.0 - 1e-12), "{name}: bound {bound} is loose, {most}");
            }
        }
    }
}

#[test]
fn parameters_out_of_range_are_refused() {
    for g in [1.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Phase::henyey_greenstein(g).is_err() && Phase::two_term(0.5, 0.1, g).is_err());
    }
    assert!(Phase::two_term(1.01, 0.1, 0.1).is_err() && Phase::two_term(f64::NAN, 0.1, 0.1).is_err());
    assert!(Phase::mixture(vec![]).is_err() && Phase::mixture(vec![(0.0, Phase::Rayleigh)]).is_err());
    let negative = Phase::mixture(vec![(1.0, Phase::Rayleigh), (-1.0, Phase::Isotropic)]);
    assert_eq!(negative.unwrap_err().to_string(), "part 2: weight -1 is not a number ≥ 0");
}

/// Value stability: same seed, same draws. Changing these is a value-breaking change.
#[test]
fn first_draws_are_pinned() {
    let mut found = Vec::new();
    for (name, law) in laws() {
        let mut rng = stream(0);
        law.sample(&mut rng);
        found.push((name, law.sample(&mut rng).sin.to_bits()));
    }
    assert_eq!(found, PINNED, "{found:#?}");
}

const PINNED: [(&str, u64); 13] = [
    ("isotropic", 4603156759864940769),
    ("Henyey–Greenstein 0", 4603156759864940769),
    ("Henyey–Greenstein 1e-9", 4603156759871166249),
    ("Henyey–Greenstein 0.5", 4606420535793884272),
    ("Henyey–Greenstein −0.7", 4594208708944603765),
    ("Henyey–Greenstein 0.95", 4602016263038933639),
    ("Henyey–Greenstein −0.999", 4556685162875539932),
    ("Henyey–Greenstein 1 − 1e-6", 4533168267222541854),
    ("two-term", 4598571091490768189),
    ("Rayleigh", 4602158168129258986),
    ("table", 4601261727741212227),
    ("Mie", 4593746276743760002),
    ("mixture", 4594830025091284070),
];
