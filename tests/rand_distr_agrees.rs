//! Our samplers of size laws against those of `rand_distr`, two independent implementations: two-sample
//! Kolmogorov–Smirnov, family-wise error 1e-3.
#![allow(missing_docs, clippy::disallowed_methods)]

use lightpro::law::SizeLaw;
use lightpro::rng::{Purpose, Stream};
use lightpro::stats::sidak;
use rand_distr::Distribution;

const DRAWS: usize = 200_000;

fn stream(n: u64) -> Stream {
    Stream::of(20_261_122, 0, n, Purpose::Probe)
}

/// p-value that two samples come from one law (asymptotic Kolmogorov distribution).
fn two_sample(mut a: Vec<f64>, mut b: Vec<f64>) -> f64 {
    a.sort_by(f64::total_cmp);
    b.sort_by(f64::total_cmp);
    let (mut i, mut j, mut d) = (0, 0, 0.0_f64);
    while i < a.len() && j < b.len() {
        if a[i] <= b[j] {
            i += 1
        } else {
            j += 1
        }
        d = d.max((i as f64 / a.len() as f64 - j as f64 / b.len() as f64).abs());
    }
    let n = (a.len() * b.len()) as f64 / (a.len() + b.len()) as f64;
    let x = d * n.sqrt();
    (1..100)
        .map(|k| 2.0 * (-1.0_f64).powi(k - 1) * (-2.0 * f64::from(k * k) * x * x).exp())
        .sum::<f64>()
        .clamp(0.0, 1.0)
}

fn theirs(law: &impl Distribution<f64>, n: u64) -> Vec<f64> {
    let mut s = stream(n);
    (0..DRAWS).map(|_| law.sample(&mut s)).collect()
}

fn ours(law: &SizeLaw, n: u64) -> Vec<f64> {
    let mut s = stream(n);
    (0..DRAWS).map(|_| law.sample(&mut s)).collect()
}

#[test]
fn families_agree() {
    let (median, sigma) = (29.1_f64, 0.25);
    let p = [
        two_sample(
            ours(&SizeLaw::lognormal(median, sigma).unwrap(), 1),
            theirs(&rand_distr::LogNormal::new(median.ln(), sigma).unwrap(), 2),
        ),
        two_sample(
            ours(&SizeLaw::gamma(6.0, 1.5).unwrap(), 3),
            theirs(&rand_distr::Gamma::new(1.5, 4.0).unwrap(), 4),
        ),
        two_sample(
            ours(&SizeLaw::weibull(2.0, 1.7).unwrap(), 5),
            theirs(&rand_distr::Weibull::new(2.0, 1.7).unwrap(), 6),
        ),
        two_sample(
            ours(&SizeLaw::beta(2.5, 1.2, 0.0, 1.0).unwrap(), 7),
            theirs(&rand_distr::Beta::new(2.5, 1.2).unwrap(), 8),
        ),
        // A number-weighted gamma law of shape 1.5 hit in proportion to its width is one of shape 2.5.
        two_sample(
            ours(&SizeLaw::gamma(6.0, 1.5).unwrap().tilted(1.0), 9),
            theirs(&rand_distr::Gamma::new(2.5, 4.0).unwrap(), 10),
        ),
    ];
    println!("p-values {p:?}");
    let level = sidak(1e-3, p.len());
    assert!(p.iter().all(|&p| p > level), "{p:?} against {level}");
}

#[test]
fn a_wrong_law_is_noticed() {
    let p = two_sample(
        ours(&SizeLaw::gamma(6.0, 1.5).unwrap(), 1),
        theirs(&rand_distr::Gamma::new(1.55, 4.0).unwrap(), 2),
    );
    assert!(p < 1e-6, "{p}");
}
