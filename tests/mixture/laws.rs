//! Chords, phases at a point, which phase follows which.

use crate::{RUNGS, THREE, chain, down, slab, stream};
use lightpro::math::DVec3;
use lightpro::universe::mixture::chain::{Chain, ChainError, Phase};
use lightpro::universe::mixture::memory::Memory;
use lightpro::universe::mixture::{MixtureUniverse, Rung};
use lightpro::universe::{MediumId, Next, Ray, Universe};

/// Phase (from 0) and length of the pieces of a straight ray, first and last included.
fn pieces(universe: &MixtureUniverse, mut ray: Ray, number: u64, most: usize) -> Vec<(usize, f64)> {
    let (mut memory, mut rng) = (Memory::default(), stream(number));
    let start = universe.enter(&ray, &mut memory, &mut rng);
    let (mut place, mut medium) = (start.place, start.medium);
    let mut out = Vec::new();
    while out.len() < most {
        match universe.next(&ray, &mut place, &mut memory, f64::INFINITY, &mut rng) {
            Next::Interface(at) => {
                out.push((usize::from(medium.0) - 1, at.distance));
                ray.origin = ray.at(at.distance);
                universe.crossed(&mut ray, &mut place, &mut memory, &at);
                medium = at.beyond;
            }
            Next::Edge { distance, .. } => {
                out.push((usize::from(medium.0) - 1, distance));
                break;
            }
            other => panic!("{other:?}"),
        }
    }
    out
}

/// Kolmogorov distance of a sample from the exponential law, times √n.
fn kolmogorov(mut sample: Vec<f64>, mean: f64) -> f64 {
    sample.sort_by(f64::total_cmp);
    let n = sample.len() as f64;
    let distance = |(i, x): (usize, &f64)| {
        let f = 1.0 - (-x / mean).exp();
        (f - i as f64 / n).max((i + 1) as f64 / n - f)
    };
    sample.iter().enumerate().map(distance).fold(0.0, f64::max) * n.sqrt()
}

/// Chords of phase i are exponential of mean Λ_i/|µ| on every rung, down and up; Kolmogorov–Smirnov at
/// 1e-3 for all 60 samples together.
#[test]
fn chords_are_exponential() {
    const CRITICAL: f64 = 2.42; // 2 e^(−2x²) = 1e-3/60
    let mut worst: f64 = 0.0;
    for rung in RUNGS {
        // So thick that ten chords never reach the other face: no chord is missed for its length.
        let universe = slab(&THREE, 1e4, rung, true);
        for (mu, upwards) in [(1.0, false), (0.5, true), (0.2, false), (0.9, true)] {
            let mut chords = vec![Vec::new(); 3];
            let (z, sign) = if upwards { (0.0, -1.0) } else { (1e4, 1.0) };
            for number in 0..20_000 {
                let ray = Ray { origin: DVec3::new(0.0, 0.0, z), dir: down(mu) * DVec3::new(1.0, 1.0, sign) };
                for (phase, length) in pieces(&universe, ray, number, 10) {
                    chords[phase].push(length);
                }
            }
            for (phase, sample) in chords.into_iter().enumerate() {
                let d = kolmogorov(sample.clone(), THREE[phase].0 / mu);
                let off = kolmogorov(sample, 1.05 * THREE[phase].0 / mu);
                assert!(d < CRITICAL, "{rung:?}, µ = {mu}, phase {phase}: √n D = {d}");
                assert!(off > CRITICAL, "a mean off by 5 % is not noticed: {off}");
                worst = worst.max(d);
            }
        }
    }
    println!("worst √n D = {worst:.3}, critical {CRITICAL}");
}

/// At every depth of a whole realisation a point is in phase i with probability p_i, within three
/// standard errors; planes between i and j are as frequent in either order.
#[test]
fn phases_have_their_shares() {
    const COUNT: u64 = 100_000;
    const DEPTHS: [f64; 4] = [0.0, 0.7, 2.5, 6.0];
    let universe = slab(&THREE, 6.0, Rung::Full, true);
    let volume = universe.chain().volume().to_vec();
    let (mut at, mut planes) = ([[0.0; 3]; 4], [[0.0; 3]; 3]);
    for number in 0..COUNT {
        let ray = Ray { origin: DVec3::new(0.0, 0.0, 6.0), dir: -DVec3::Z };
        let pieces = pieces(&universe, ray, number, usize::MAX);
        let mut from = 0.0;
        for (i, (phase, length)) in pieces.iter().enumerate() {
            let last = i + 1 == pieces.len();
            for (k, depth) in DEPTHS.iter().enumerate() {
                if *depth >= from && (last || *depth < from + length) {
                    at[k][*phase] += 1.0 / COUNT as f64;
                }
            }
            if let Some((next, _)) = pieces.get(i + 1) {
                planes[*phase][*next] += 1.0;
            }
            from += length;
        }
    }
    for (k, depth) in DEPTHS.iter().enumerate() {
        for i in 0..3 {
            let se = (volume[i] * (1.0 - volume[i]) / COUNT as f64).sqrt();
            let z = (at[k][i] - volume[i]) / se;
            println!(
                "depth {depth}: phase {i} {:.5}, want {:.5}, {z:+.2} standard errors",
                at[k][i], volume[i]
            );
            assert!(z.abs() < 3.0, "depth {depth}, phase {i}");
        }
    }
    // Density of planes i–j: a_i a_j over Σ Λ_i a_i (A − a_i).
    let shares = THREE.map(|p| p.1);
    let norm: f64 = THREE.iter().map(|(chord, a)| chord * a * (shares.iter().sum::<f64>() - a)).sum();
    for i in 0..3 {
        assert_eq!(planes[i][i], 0.0);
        for j in (0..3).filter(|j| *j != i) {
            let want = 6.0 * COUNT as f64 * shares[i] * shares[j] / norm;
            let z = (planes[i][j] - want) / want.sqrt();
            println!("planes {i}–{j}: {}, want {want:.0}, {z:+.2}", planes[i][j]);
            assert!(z.abs() < 4.0);
        }
    }
}

#[test]
fn volume_shares() {
    let two = chain(&[(0.99, 1.0), (0.11, 7.0)]);
    assert!((two.volume()[0] - 0.9).abs() < 1e-15, "two phases: Λ_i/ΣΛ, whatever the shares");
    let equal = chain(&[(1.0, 1.0), (2.0, 1.0), (5.0, 1.0)]);
    assert!((equal.volume()[2] - 0.625).abs() < 1e-15, "equal shares: Λ_i/ΣΛ");
    // A Poisson tessellation in three colours: p_i = a_i where Λ_i = Λ/(1 − p_i).
    let p = [0.2, 0.3, 0.5];
    let coloured = chain(&p.map(|p| (3.0 / (1.0 - p), p)));
    for (got, want) in coloured.volume().iter().zip(p) {
        assert!((got - want).abs() < 1e-15);
    }
}

#[test]
fn no_mixture() {
    let phase = |chord, share| Phase { medium: MediumId(1), chord, share };
    assert_eq!(Chain::new(vec![phase(1.0, 1.0)]).unwrap_err(), ChainError::Phases);
    let of = |p| Chain::new(vec![phase(1.0, 1.0), p]).unwrap_err();
    assert_eq!(of(phase(0.0, 1.0)), ChainError::Chord(1, 0.0));
    assert!(matches!(of(phase(f64::NAN, 1.0)), ChainError::Chord(1, _)));
    assert_eq!(of(phase(1.0, -1.0)), ChainError::Share(1, -1.0));
}
