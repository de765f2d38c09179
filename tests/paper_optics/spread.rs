//! Lateral spread, halftone, path length and time of flight.

use super::*;
use lightpro::math::{bessel_j0, bessel_k1, gauss_legendre};
use lightpro::report::instruments::{CurveRow, tables};
use std::f64::consts::PI;

/// A clear gap of 100 µm above a white Lambertian floor: all light leaves at r = d tan θ, θ by Lambert.
fn gap(detect: &str) -> String {
    scene(
        "",
        r#"<surface id="white" kind="lambertian" reflectance="1" opaque="yes"/>"#,
        r#"<slab z-min="0 um" z-max="100 um" material="air"/>
           <slab z-min="-10 um" z-max="0 um" material="air" surface="white"/>"#,
        detect,
    )
}

fn curve(done: &Finished, stem: &str) -> Vec<CurveRow> {
    let all = tables(&done.outcome);
    all.into_iter().find(|t| t.stem == stem).unwrap_or_else(|| panic!("no {stem}")).rows
}

/// Closed forms of the gap: PSF 1/(π d² (1 + r²/d²)²), MTF b K1(b) with b = 2π f d, edge response by
/// the line spread 1/(2d (1 + x²/d²)^(3/2)): ½ (1 + x/√(x² + d²)).
#[test]
fn spread_over_a_clear_gap_has_its_closed_forms() {
    const D: f64 = 100.0;
    let done = run(&gap(r#"<detect lateral="400 um" rings="40"/>"#), 1_000_000);
    let mut worst = 0.0_f64;
    for row in curve(&done, "point_spread").iter().filter(|r| r.to.is_some()) {
        let cumulative = |r: f64| r * r / (r * r + D * D);
        let (from, to) = (row.from, row.to.unwrap());
        let want = (cumulative(to) - cumulative(from)) / (1e-6 * PI * (to * to - from * from));
        worst = worst.max(((row.value - want) / row.error).abs());
    }
    for row in curve(&done, "mtf").iter().skip(1) {
        let b = 2.0 * PI * 1e-3 * row.from * D;
        worst = worst.max(((row.value - b * bessel_k1(b)) / row.error).abs());
    }
    for row in curve(&done, "edge_response").iter().filter(|r| r.error > 0.0) {
        let want = 0.5 * (1.0 + row.from / (row.from * row.from + D * D).sqrt());
        worst = worst.max(((row.value - want) / row.error).abs());
    }
    println!("gap: worst z {worst:.2}");
    assert!(worst < 4.5, "{worst}");
    // b K1(b) = 1/2, by bisection: b = 1.257.
    let (mut low, mut high) = (1.0, 2.0);
    for _ in 0..50 {
        let b = 0.5 * (low + high);
        if b * bessel_k1(b) > 0.5 { low = b } else { high = b }
    }
    let b = low;
    agree("half frequency", figure(&done, "mtf_half_frequency", None), 1e3 * b / (2.0 * PI * D), 2e-3);
}

/// Modulation of light that is reflected by an index-matched, isotropically scattering slab under a pencil
/// at normal incidence, by the integral equation of the emission density S in Fourier space,
/// S(z) = ω e^(−z) + ω ∫ K(|z − z′|) S(z′) dz′, K(τ) = ½ ∫₀¹ e^(−τ/µ) J0(k τ √(1 − µ²)/µ) dµ/µ, on
/// `cells` cells of constant S (second order); k = 2π f in units of the extinction.
fn slab_modulation(depth: f64, albedo: f64, k: f64, cells: usize) -> f64 {
    let h = depth / cells as f64;
    let mus = gauss_legendre(64, 0.0, 1.0);
    // Means over a cell of what reaches `at` from it, per unit S: ½ ∫ dµ ∫ ds e^(−s) J0(k s √(1 − µ²)).
    let reach = |from: f64, to: f64| -> f64 {
        let inner = |mu: f64| {
            let (a, b) = (from / mu, (to / mu).min(from / mu + 40.0));
            let panels = (1 + ((b - a) / 2.0) as usize).min(24);
            let w = (b - a) / panels as f64;
            (0..panels)
                .flat_map(|p| gauss_legendre(6, a + p as f64 * w, a + (p + 1) as f64 * w))
                .map(|(s, ws)| ws * (-s).exp() * bessel_j0(k * s * (1.0 - mu * mu).sqrt()))
                .sum::<f64>()
        };
        mus.iter().map(|(mu, w)| 0.5 * w * inner(*mu)).sum()
    };
    // Between cell centres n apart: from (n − ½)h to (n + ½)h; n = 0 twice the half cell.
    let kernel: Vec<f64> = (0..cells)
        .map(|n| {
            if n == 0 { 2.0 * reach(0.0, 0.5 * h) } else { reach((n as f64 - 0.5) * h, (n as f64 + 0.5) * h) }
        })
        .collect();
    let first: Vec<f64> = (0..cells).map(|i| albedo * (-(i as f64 + 0.5) * h).exp()).collect();
    let mut s = first.clone();
    for _ in 0..400 {
        s = (0..cells)
            .map(|i| first[i] + albedo * (0..cells).map(|j| kernel[i.abs_diff(j)] * s[j]).sum::<f64>())
            .collect();
    }
    // What leaves the top: ½ ∫ dµ S e^(−z/µ) J0(k z √(1 − µ²)/µ) over the depth.
    let out = |i: usize| reach_out(i as f64 * h, (i + 1) as f64 * h, k, &mus);
    (0..cells).map(|i| s[i] * out(i)).sum()
}

/// ½ ∫ dz ∫ dµ e^(−z/µ) J0(k z √(1 − µ²)/µ) over a cell.
fn reach_out(from: f64, to: f64, k: f64, mus: &[(f64, f64)]) -> f64 {
    let at = |z: f64| -> f64 {
        mus.iter().map(|(mu, w)| w * (-z / mu).exp() * bessel_j0(k * z * (1.0 - mu * mu).sqrt() / mu)).sum()
    };
    gauss_legendre(4, from, to).iter().map(|(z, w)| 0.5 * w * at(*z)).sum()
}

/// The homogeneous slab against that independent calculation, converged by Richardson's rule.
#[test]
fn modulation_of_a_scattering_slab_agrees_with_the_integral_equation() {
    let (mu_t, albedo, depth) = (0.02, 0.9, 4.0);
    let paper = format!(
        r#"<material id="paper" index="1" absorption="{} 1/um"><scattering mu-s="{} 1/um"/></material>"#,
        mu_t * (1.0 - albedo),
        mu_t * albedo
    );
    let slab = format!(r#"<slab z-min="0 um" z-max="{} um" material="paper"/>"#, depth / mu_t);
    let rest = r#"<detect lateral="400 um" rings="40"/>"#;
    let done = run(&scene(&paper, "", &slab, rest), 2_000_000);
    let rows = curve(&done, "mtf");
    let rows: Vec<_> = rows.iter().filter(|r| r.light == "reflected").collect();
    let solve = |k: f64| {
        let (coarse, fine) = (slab_modulation(depth, albedo, k, 32), slab_modulation(depth, albedo, k, 64));
        (fine + (fine - coarse) / 3.0, (fine - coarse).abs() / 3.0)
    };
    let (whole, _) = solve(0.0);
    agree("reflectance", figure(&done, "reflectance", None), whole, 2e-4);
    for i in [1, 4, 10, 20, 40] {
        let k = 2.0 * PI * 1e-3 * rows[i].from / mu_t;
        let (value, open) = solve(k);
        agree(
            &format!("MTF at {:.2} 1/mm", rows[i].from),
            (rows[i].value, rows[i].error),
            value / whole,
            open / whole + 3e-4,
        );
    }
    // The check bites: an extinction larger by 3 %.
    let other = solve(2.0 * PI * 1e-3 * rows[10].from / (1.03 * mu_t)).0 / whole;
    assert!((rows[10].value - other).abs() > 4.0 * rows[10].error + 6e-4);
}

/// A halftone over the gap: its reflectance by the Fourier series of the screen and the closed modulation
/// transfer, Σ |t_k|² M(k/p); the Yule–Nielsen factor goes from 1 to 2 as the period shrinks.
#[test]
fn halftones_over_a_gap_follow_from_the_modulation_transfer() {
    const D: f64 = 100.0;
    let mut factors = Vec::new();
    for period in [20_000.0, 800.0, 200.0, 20.0] {
        let detect = format!(r#"<detect><halftone coverage="0.4" period="{period} um" ink="0.1"/></detect>"#);
        let done = run(&gap(&detect), 1_000_000);
        let (a, c) = (0.4, 0.9);
        let mut want = (1.0 - c * a) * (1.0 - c * a);
        for k in 1..20_000 {
            let t = c * (PI * f64::from(k) * a).sin() / (PI * f64::from(k));
            let b = 2.0 * PI * f64::from(k) / period * D;
            want += 2.0 * t * t * if b > 1e-9 { b * bessel_k1(b) } else { 1.0 };
        }
        agree(&format!("period {period}"), figure(&done, "halftone_reflectance", None), want, 1e-5);
        factors.push(figure(&done, "yule_nielsen_n", None));
    }
    println!("n {factors:?}");
    assert!(factors.windows(2).all(|w| w[0].0 < w[1].0 + 3.0 * w[1].1));
    assert!((factors[0].0 - 1.0).abs() < 0.03 && (factors[3].0 - 2.0).abs() < 0.01);
}

/// The gap: mean path d + 2d (the mean of 1/cos θ by Lambert is 2), density 2 d²/(s − d)³ beyond 2d; times
/// as paths, at the speed of light.
#[test]
fn paths_over_the_gap_have_their_law() {
    const D: f64 = 100.0;
    let done = run(&gap(r#"<detect path-histogram="1 mm" path-bins="50"/>"#), 1_000_000);
    let mut worst = 0.0_f64;
    let beyond = |s: f64| if s <= 2.0 * D { 1.0 } else { (D / (s - D)).powi(2) };
    for row in curve(&done, "path_histogram").iter().filter(|r| r.error > 0.0) {
        let want = match row.to {
            Some(to) => (beyond(row.from) - beyond(to)) / (to - row.from),
            None => beyond(row.from),
        };
        worst = worst.max(((row.value - want) / row.error).abs());
    }
    println!("paths: worst z {worst:.2}");
    assert!(worst < 4.0);
    // The second moment of the path diverges (slowly): its mean is held loosely.
    let (path, _) = figure(&done, "path_length", Some("reflected"));
    assert!((path - 300.0).abs() < 3.0, "{path}");
    let (time, _) = figure(&done, "time_of_flight", Some("reflected"));
    assert!((time - path / 299.792_458).abs() < 1e-9 * time);
}

/// A plate of dispersive glass: light crosses it at the group velocity.
#[test]
fn time_of_flight_takes_the_group_index() {
    // n = A + B/λ²: the group index is A + 3B/λ².
    let (a, b) = (1.5, 4000.0);
    let dir = tempfile::tempdir().unwrap();
    let rows: String = (0..=60)
        .map(|i| 0.4 + 0.005 * f64::from(i))
        .map(|um| format!("      {um:.3} {:.12}\n", a + b * 1e-6 / (um * um)))
        .collect();
    let yml = format!("DATA:\n  - type: tabulated n\n    data: |\n{rows}");
    std::fs::write(dir.path().join("glass.yml"), yml).unwrap();
    let text = scene(
        r#"<material id="glass" index-file="glass.yml"/>"#,
        "",
        r#"<slab z-min="0 um" z-max="1000 um" material="glass"/>"#,
        r#"<spectrum at="550 nm"/><detect path-histogram="10 mm"/>"#,
    );
    let options = Options::default();
    let scene = read_text(&text, &dir.path().join("x.xml"), &options).unwrap_or_else(|d| panic!("{d}"));
    let args = RunArgs { histories: Some(200_000), ..RunArgs::default() };
    let done = finish(scene, &args, |_| true).unwrap();
    let (path, _) = figure(&done, "path_length", Some("transmitted"));
    let (time, _) = figure(&done, "time_of_flight", Some("transmitted"));
    let group = a + 3.0 * b / (550.0 * 550.0);
    let got = time * 299.792_458 / path;
    println!("group index {got:.6}, wanted {group:.6}");
    assert!((got - group).abs() < 2e-4);
    // Not the phase index.
    assert!((got - (a + b / (550.0 * 550.0))).abs() > 0.02);
}
