//! Light in mixtures: straight rays in closed form, lossless invariants, explicit realisations,
//! branching.

use crate::transport::{Totals, diffuse, layout, run, totals, world};
use crate::{OUTSIDE, RUNGS, THREE, chain, slab};
use lightpro::lpm::surface::SurfaceLaw;
use lightpro::lpm::{Light, Medium, World};
use lightpro::math::DVec3;
use lightpro::phase::Phase;
use lightpro::rng::Stream;
use lightpro::run::{Histories, run_group};
use lightpro::scene::optics;
use lightpro::source::Source;
use lightpro::universe::mixture::Rung;
use lightpro::universe::shape::{Placed, Shape, SlabZ};
use lightpro::universe::synthetic::{Part, SyntheticUniverse};
use lightpro::universe::{BodyId, MediumId, SurfaceId};
use rayon::prelude::*;

/// Media of the phases behind that outside: n, µa, µs.
fn light(phases: &[(f64, f64, f64)]) -> Light<1> {
    let medium = |(n, a, s): &(f64, f64, f64)| Medium::clear(*n).with([*a], *s, Phase::Isotropic);
    let media = std::iter::once(Medium::clear(1.0)).chain(phases.iter().map(medium)).collect();
    Light { media, surfaces: vec![SurfaceLaw::default()], lanes: 1 }
}

/// Transmission of a straight ray of cosine µ through a mixture that only absorbs: p · e^((Q − Σ/µ) H) · 1,
/// Q_ij = P_ij/Λ_i, Q_ii = −1/Λ_i.
fn straight(phases: &[(f64, f64)], sigma: &[f64], height: f64, mu: f64) -> f64 {
    let m = phases.len();
    let total: f64 = phases.iter().map(|p| p.1).sum();
    // e^(M) = (1 + M/s)^s with four terms of its series, s = 2¹⁴.
    const HALVINGS: i32 = 14;
    let step = height / f64::from(1 << HALVINGS);
    let entry = |i: usize, j: usize| {
        let (chord, share) = phases[i];
        if i == j { -1.0 / chord - sigma[i] / mu } else { phases[j].1 / (total - share) / chord }
    };
    let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
    let square = |f: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        (0..m).map(|i| (0..m).map(|j| f(i, j)).collect()).collect()
    };
    let product =
        |a: &[Vec<f64>], b: &[Vec<f64>]| square(&|i, j| (0..m).map(|k| a[i][k] * b[k][j]).sum::<f64>());
    let small = square(&|i, j| entry(i, j) * step);
    let mut term = square(&unit);
    let mut e = square(&unit);
    for n in 1..=4 {
        term = product(&term, &small);
        e = square(&|i, j| e[i][j] + term[i][j] / (1..=n).product::<i32>() as f64);
    }
    for _ in 0..HALVINGS {
        e = product(&e, &e);
    }
    let p = chain(phases).volume().to_vec();
    (0..m).map(|i| p[i] * e[i].iter().sum::<f64>()).sum()
}

/// The two exponentials of a binary mixture (Levermore, Pomraning, Sanzo & Wong 1986, J. Math. Phys. 27,
/// 2526; Vanderhaegen 1986): r± = ½ (σ̄ + σ̃ ± √((σ̄ − σ̃)² + 4β)), σ̃ = p1 σ0 + p0 σ1 + 1/Λ0 + 1/Λ1,
/// β = p0 p1 (σ0 − σ1)²; T = ((σ̄ − r−) e^(−r+ s) + (r+ − σ̄) e^(−r− s))/(r+ − r−).
fn two_exponentials(chord: [f64; 2], sigma: [f64; 2], s: f64) -> f64 {
    let p = [chord[0] / (chord[0] + chord[1]), chord[1] / (chord[0] + chord[1])];
    let mean = p[0] * sigma[0] + p[1] * sigma[1];
    let other = p[1] * sigma[0] + p[0] * sigma[1] + 1.0 / chord[0] + 1.0 / chord[1];
    let beta = p[0] * p[1] * (sigma[0] - sigma[1]).powi(2);
    let root = ((mean - other).powi(2) + 4.0 * beta).sqrt();
    let (plus, minus) = (0.5 * (mean + other + root), 0.5 * (mean + other - root));
    ((mean - minus) * (-plus * s).exp() + (plus - mean) * (-minus * s).exp()) / (plus - minus)
}

fn beam(height: f64, mu: f64) -> Source {
    Source::collimated(mu.acos(), 0.0, DVec3::new(0.0, 0.0, height), 0.0)
}

/// Every rung is exact for straight rays; four standard errors.
#[test]
fn straight_rays_know_no_rung() {
    const HEIGHT: f64 = 3.0;
    let binary = [(0.99, 1.0), (0.11, 1.0)];
    for mu in [1.0, 0.4] {
        let a = straight(&binary, &[0.1, 9.0], 10.0, mu);
        let b = two_exponentials([0.99 / mu, 0.11 / mu], [0.1, 9.0], 10.0 / mu);
        assert!((a / b - 1.0).abs() < 1e-9, "{a}, {b}");
    }
    let (mut worst, mut noticed, mut cases) = (0.0_f64, 0, 0);
    for rung in RUNGS {
        for (phases, sigma) in [(&binary[..], &[0.1, 9.0][..]), (&THREE[..], &[0.0, 2.0, 0.3][..])] {
            let media: Vec<_> = sigma.iter().map(|s| (1.0, *s, 0.0)).collect();
            for mu in [1.0, 0.4] {
                let universe = slab(phases, HEIGHT, rung, true);
                let (t, se) = run(&universe, &light(&media), &beam(HEIGHT, mu), HEIGHT, 1_000_000).t();
                let want = straight(phases, sigma, HEIGHT, mu);
                let z = (t - want) / se;
                worst = worst.max(z.abs());
                println!(
                    "{rung:?}, {} phases, µ = {mu}: T {t:.6} ± {se:.6}, want {want:.6}, {z:+.2}",
                    phases.len()
                );
                assert!(z.abs() < 4.0);
                let thicker = straight(phases, sigma, 1.02 * HEIGHT, mu);
                noticed += u32::from((thicker - want).abs() > 4.0 * se);
                cases += 1;
            }
        }
    }
    println!(
        "straight rays: worst {worst:.2} standard errors; {noticed} of {cases} would notice 2 % of thickness"
    );
    assert!(2 * noticed >= cases);
}

/// Mean path by phase of a lossless slab under diffuse light: 2 n_i² p_i H. Every rung keeps it: what it
/// forgets is drawn again by the law that it had.
#[test]
fn lossless_paths() {
    let refracting = [(1.0, 0.0, 0.6), (1.5, 0.0, 1.0), (1.3, 0.0, 0.2)];
    let matched = refracting.map(|(_, a, s)| (1.0, a, s));
    let p = chain(&THREE).volume().to_vec();
    let worst = |rung: Rung, media: &[(f64, f64, f64)]| {
        let clear = media.iter().all(|m| m.0 == 1.0);
        let got = run(&slab(&THREE, 6.0, rung, clear), &light(media), &diffuse(6.0), 6.0, 1_000_000);
        let mut worst: f64 = 0.0;
        for (i, m) in media.iter().enumerate() {
            let (path, se) = got.path(MediumId(i as u16 + 1));
            let want = 12.0 * m.0 * m.0 * p[i];
            println!(
                "{rung:?}, n = {}: path {path:.4} ± {se:.4}, want {want:.4}, {:+.2} standard errors",
                m.0,
                (path - want) / se
            );
            worst = worst.max((path - want).abs() / se);
        }
        worst
    };
    for rung in RUNGS {
        assert!(worst(rung, &matched) < 4.0, "{rung:?}");
    }
    for rung in [Rung::Phase, Rung::Full] {
        assert!(worst(rung, &refracting) < 5.0, "{rung:?}, refracting");
    }
}

/// An explicit realisation of the three phases between 0 and `height`, drawn by its own few lines.
fn realisation(height: f64, number: u64) -> SyntheticUniverse {
    let mut rng = Stream::of(77, number, 0, lightpro::rng::Purpose::Realisation);
    let pick = |weights: [f64; 3], rng: &mut Stream| {
        let x = rng.uniform() * weights.iter().sum::<f64>();
        if x < weights[0] { 0 } else { 1 + usize::from(x >= weights[0] + weights[1]) }
    };
    let volume = chain(&THREE).volume().to_vec();
    let mut phase = pick([volume[0], volume[1], volume[2]], &mut rng);
    let (mut z, mut parts) = (0.0, Vec::new());
    while z < height {
        let top = (z - THREE[phase].0 * rng.uniform_positive().ln()).min(height);
        parts.push(Part {
            shape: Placed::at_origin(Shape::SlabZ(SlabZ { z_min: z, z_max: top })),
            medium: MediumId(phase as u16 + 1),
            surface: SurfaceId::SMOOTH,
            priority: 0,
            body: BodyId(parts.len() as u32),
        });
        z = top;
        let mut weights = THREE.map(|p| p.1);
        weights[phase] = 0.0;
        phase = pick(weights, &mut rng);
    }
    SyntheticUniverse::new(OUTSIDE, parts).unwrap()
}

/// Full memory equals the mean over explicit realisations, with refraction, absorption and scattering in
/// three phases; no memory does not.
#[test]
fn full_memory_is_the_mean_over_realisations() {
    const HEIGHT: f64 = 5.0;
    let light = light(&[(1.0, 0.02, 0.0), (1.5, 0.01, 2.0), (1.3, 0.0, 0.3)]);
    let each: Vec<[f64; 2]> = (0..4_000_u64)
        .into_par_iter()
        .map(|number| {
            let universe = realisation(HEIGHT, number);
            let layout = layout(light.media.len());
            let histories = Histories { seed: number, group: 0, count: 300 };
            let node =
                run_group(&world(&universe, &light, HEIGHT), &diffuse(HEIGHT), &layout, histories, |_, _| {
                    true
                });
            let t = Totals { node, layout };
            [t.r().0, t.t().0]
        })
        .collect();
    let n = each.len() as f64;
    let explicit = [0, 1].map(|k| {
        let mean = each.iter().map(|e| e[k]).sum::<f64>() / n;
        let variance = each.iter().map(|e| (e[k] - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, (variance / n).sqrt())
    });
    let of = |rung| {
        let t = run(&slab(&THREE, HEIGHT, rung, false), &light, &diffuse(HEIGHT), HEIGHT, 2_000_000);
        [t.r(), t.t()]
    };
    let apart = |got: [(f64, f64); 2]| -> [f64; 2] {
        std::array::from_fn(|k| {
            let ((a, sa), (b, sb)) = (got[k], explicit[k]);
            (a - b) / (sa * sa + sb * sb).sqrt()
        })
    };
    let (full, none) = (of(Rung::Full), of(Rung::Phase));
    println!("explicit {explicit:.5?}");
    println!("full     {full:.5?}: {:+.2?} standard errors", apart(full));
    println!("none     {none:.5?}: {:+.1?} standard errors", apart(none));
    assert!(apart(full).iter().all(|z| z.abs() < 4.0));
    assert!(apart(none).iter().any(|z| z.abs() > 6.0));
}

/// One ray into every patch gives the means of one ray drawn, on every rung.
#[test]
fn split_is_sample() {
    const HEIGHT: f64 = 2.0;
    let light = light(&[(1.0, 0.1, 0.0), (1.5, 0.05, 1.0), (1.3, 0.1, 0.3)]);
    let split = optics::split(&light, 1, 0.05).unwrap();
    for rung in [Rung::Phase, Rung::Layers(2), Rung::Full] {
        let universe = slab(&THREE, HEIGHT, rung, false);
        let plain = world(&universe, &light, HEIGHT);
        let one = totals(&plain, &diffuse(HEIGHT), 1_000_000);
        let plain = world(&universe, &light, HEIGHT);
        let all = totals(&World { split: Some(&split), ..plain }, &diffuse(HEIGHT), 100_000);
        for (name, (a, sa), (b, sb)) in [("R", one.r(), all.r()), ("T", one.t(), all.t())] {
            let z = (a - b) / (sa * sa + sb * sb).sqrt();
            println!("{rung:?} {name}: sample {a:.5} ± {sa:.5}, split {b:.5} ± {sb:.5}, {z:+.2}");
            assert!(z.abs() < 4.0);
        }
    }
}
