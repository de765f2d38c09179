//! Visible normals: the sampler against its density, by chi-square over a grid of the hemisphere.
#![allow(clippy::disallowed_methods, missing_docs)]

use lightpro::math::{DVec3, TAU, gauss_legendre};
use lightpro::microfacet::{Microfacet, Slopes};
use lightpro::rng::{Purpose, Stream};
use lightpro::stats::{chi_square_pooled, sidak};

const LAWS: [Slopes; 3] = [Slopes::Gaussian, Slopes::Exponential, Slopes::Ggx];
const SLOPES: [f64; 3] = [0.05, 0.3, 1.0];
const INCIDENCE: [f64; 4] = [0.0, 45.0, 75.0, 89.0];
/// Rings in tanθh/m; the last one reaches the horizon.
const RINGS: [f64; 13] = [0.0, 0.15, 0.3, 0.45, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0, 2.6, 4.0, f64::INFINITY];
const SECTORS: usize = 16;
const SAMPLES: u32 = 200_000;

/// Local incidence at an azimuth that is no axis of the grid.
fn incidence(degrees: f64) -> DVec3 {
    let (s, c) = degrees.to_radians().sin_cos();
    DVec3::new(s * 0.83_f64.cos(), s * 0.83_f64.sin(), c)
}

/// Shares of the cells: ∫ pdf_visible dω by composite Gauss–Legendre in θ and φ.
fn expected(surface: &Microfacet, i: DVec3) -> Vec<f64> {
    const SUB: usize = 8;
    let unit = gauss_legendre(6, 0.0, 1.0);
    let line = |a: f64, b: f64| -> Vec<(f64, f64)> {
        let step = (b - a) / SUB as f64;
        (0..SUB).flat_map(|k| unit.iter().map(move |&(x, w)| (a + step * (k as f64 + x), w * step))).collect()
    };
    let mut cells = Vec::new();
    for ring in RINGS.windows(2) {
        let thetas = line((surface.m() * ring[0]).atan(), (surface.m() * ring[1]).atan());
        for k in 0..SECTORS {
            let phis = line(TAU * k as f64 / SECTORS as f64, TAU * (k + 1) as f64 / SECTORS as f64);
            let mut mass = 0.0;
            for &(theta, w) in &thetas {
                let (s, c) = theta.sin_cos();
                for &(phi, v) in &phis {
                    let h = DVec3::new(s * phi.cos(), s * phi.sin(), c);
                    mass += w * v * s * surface.pdf_visible(i, h);
                }
            }
            cells.push(mass);
        }
    }
    cells
}

/// Hits of the cells of a grid made for slope `m`.
fn counts(surface: &Microfacet, m: f64, i: DVec3, history: u64) -> Vec<f64> {
    let mut rng = Stream::of(20_080, 0, history, Purpose::Transport);
    let mut cells = vec![0.0; (RINGS.len() - 1) * SECTORS];
    for _ in 0..SAMPLES {
        let h = surface.sample_visible(i, &mut rng);
        let slope = (h.x * h.x + h.y * h.y).sqrt() / h.z / m;
        let ring = RINGS.partition_point(|&r| r <= slope).min(RINGS.len() - 1) - 1;
        let turn = h.y.atan2(h.x).rem_euclid(TAU) / TAU;
        cells[ring * SECTORS + ((turn * SECTORS as f64) as usize).min(SECTORS - 1)] += 1.0;
    }
    cells
}

/// Probability of a chi-square at least as large, neighbouring cells pooled to an expectation of 5.
fn p_value(expected: &[f64], counts: &[f64]) -> f64 {
    let expected: Vec<f64> = expected.iter().map(|share| f64::from(SAMPLES) * share).collect();
    chi_square_pooled(counts, &expected)
}

#[test]
fn visible_normals_follow_their_density() {
    // Šidák: 1 % over all cases together.
    let level = sidak(0.01, LAWS.len() * SLOPES.len() * INCIDENCE.len());
    let mut history = 0;
    let mut least = 1.0_f64;
    for law in LAWS {
        for m in SLOPES {
            let surface = Microfacet::new(law, m).unwrap();
            for degrees in INCIDENCE {
                let i = incidence(degrees);
                let shares = expected(&surface, i);
                let total: f64 = shares.iter().sum();
                assert!((total - 1.0).abs() < 2e-4, "{law:?} m = {m} {degrees}°: ∫ pdf = {total}");
                let p = p_value(&shares, &counts(&surface, m, i, history));
                history += 1;
                least = least.min(p);
                assert!(p > level, "{law:?} m = {m} {degrees}°: p = {p:.2e}, {level:.1e} asked");
            }
        }
    }
    println!(
        "{} cases of {SAMPLES} normals: least p {least:.2e}, level {level:.1e}",
        LAWS.len() * SLOPES.len() * INCIDENCE.len()
    );
}

/// It bites: a slope off by 2 %, an incidence off by 5°: every law is found out.
#[test]
fn a_wrong_slope_or_direction_is_found_out() {
    for law in LAWS {
        let right = Microfacet::new(law, 0.3).unwrap();
        let shares = expected(&right, incidence(45.0));
        let rough = Microfacet::new(law, 0.3 * 1.02).unwrap();
        assert!(p_value(&shares, &counts(&rough, 0.3, incidence(45.0), 900)) < 1e-4, "{law:?}: slope");
        assert!(p_value(&shares, &counts(&right, 0.3, incidence(50.0), 901)) < 1e-4, "{law:?}: incidence");
    }
}
