//! Kubelka–Munk theory against 80-digit values, and against published handsheets.

use crate::harness::{Check, Row, hold, rows, within};
use lightpro::optics::{Coefficients, Layer};

/// Relative tolerance: some tens of roundings (T = exp(−γw) with γw up to 60 has that many alone).
const RELATIVE: f64 = 2e-14;

fn relative(got: f64, want: f64) -> f64 {
    match within(got, want, RELATIVE * want.abs().max(f64::MIN_POSITIVE)) {
        Check::Deviation(d) => d,
        Check::Cannot(_) => unreachable!(),
    }
}

/// Worst deviation of all columns of a row, with s scaled by `scale`.
fn deviation(row: &Row, scale: f64) -> f64 {
    let layer = Layer::new(scale * row.f("s_m2_per_kg"), row.f("k_m2_per_kg"), row.f("w_kg_per_m2")).unwrap();
    let mut worst = relative(layer.r0, row.f("R0_black"))
        .max(relative(layer.t, row.f("T")))
        .max(relative(layer.r_inf, row.f("Rinf")))
        .max(relative(layer.over(0.8), row.f("R_over_Rg0.8")));
    // Sheets that absorb nothing are printed with the rounding of the 80 digits (1e-82).
    worst = worst.max(if row.f("k_m2_per_kg") == 0.0 {
        layer.absorbed / f64::MIN_POSITIVE
    } else {
        relative(layer.absorbed, row.f("absorbed"))
    });
    if let Some(opacity) = row.maybe("opacity_R0/Rinf") {
        worst = worst.max(relative(layer.opacity.unwrap(), opacity));
    }
    worst
}

#[test]
fn forward_agrees_in_every_column() {
    hold("kubelka_munk.csv", |row| Check::Deviation(deviation(row, 1.0)));
}

/// s larger by 1e-11 shows in every row whose figures depend on s.
#[test]
fn forward_tolerance_bites() {
    let all = rows("kubelka_munk.csv");
    let scattering: Vec<&Row> =
        all.iter().filter(|r| r.f("s_m2_per_kg") > 0.0 && r.f("w_kg_per_m2") > 0.0).collect();
    assert!(!scattering.is_empty());
    let caught = scattering.iter().filter(|r| deviation(r, 1.0 + 1e-11) > 1.0).count();
    assert_eq!(caught, scattering.len());
}

fn inverse_deviation(row: &Row, scale: f64) -> f64 {
    let got = Coefficients::from_r0_r_inf(scale * row.f("R0"), row.f("Rinf"), row.f("w_kg_per_m2")).unwrap();
    relative(got.s, row.f("s_m2_per_kg")).max(relative(got.k, row.f("k_m2_per_kg")))
}

#[test]
fn inverse_agrees() {
    hold("kubelka_munk_inverse.csv", |row| Check::Deviation(inverse_deviation(row, 1.0)));
}

#[test]
fn inverse_tolerance_bites() {
    for row in rows("kubelka_munk_inverse.csv") {
        assert!(inverse_deviation(&row, 1.0 - 1e-12) > 1.0, "line {}", row.line);
    }
}

/// Handsheets of 65 g/m² (Cellulose 28 (2021) 5807, table 5); the table is data about paper, and is
/// read from the project even where `LIGHTPRO_REFERENCE` names another folder of reference values.
fn handsheets() -> Vec<[f64; 3]> {
    let text = include_str!("../reference/km_handsheets.csv");
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let columns: Vec<usize> = ["s_m2kg", "k_m2kg", "opacity_pct"]
        .iter()
        .map(|name| reader.headers().unwrap().iter().position(|h| h == *name).unwrap())
        .collect();
    let rows = reader.records().map(|record| {
        let record = record.unwrap();
        [0, 1, 2].map(|i| record[columns[i]].parse().unwrap())
    });
    rows.collect()
}

/// Published s and k (rounded) of 65 g/m² give the published opacity within 0.1.
#[test]
fn handsheet_opacities_follow_from_s_and_k() {
    let opacity = |s, k, w| 100.0 * Layer::new(s, k, w).unwrap().opacity.unwrap();
    let sheets = handsheets();
    assert_eq!(sheets.len(), 33);
    let worst = sheets.iter().map(|&[s, k, o]| (opacity(s, k, 0.065) - o).abs()).fold(0.0, f64::max);
    println!("33 handsheets: opacity within {worst:.3}");
    assert!(worst < 0.1);
    // The same check with 66 g/m² fails.
    assert!(sheets.iter().any(|&[s, k, o]| (opacity(s, k, 0.066) - o).abs() > 0.1));
}

/// Inverted: the published opacity, s and k give the grammage 65.0 ± 0.2 g/m², widened by what the
/// rounding of the opacity to ±0.05 means (which grows as the sheet becomes opaque).
#[test]
fn handsheet_grammage_follows_from_opacity() {
    let grammage = |s: f64, k: f64, opacity: f64| {
        let r_inf = Coefficients { s, k }.r_infinity();
        // ISO 9416 gives s w.
        1000.0 * Coefficients::from_r0_r_inf(0.01 * opacity * r_inf, r_inf, 1.0).unwrap().s / s
    };
    for &[s, k, o] in &handsheets() {
        let w = grammage(s, k, o);
        let rounding = 0.5 * (grammage(s, k, o + 0.05) - grammage(s, k, o - 0.05));
        assert!((w - 65.0).abs() < 0.2 + rounding, "s {s} k {k}: {w} ± {rounding}");
    }
    let clear: Vec<[f64; 3]> = handsheets().into_iter().filter(|r| r[2] < 96.0).collect();
    assert_eq!(clear.len(), 27);
    assert!(clear.iter().all(|&[s, k, o]| (grammage(s, k, o) - 65.0).abs() < 0.2));
    assert!(clear.iter().any(|&[s, k, o]| (grammage(1.005 * s, k, o) - 65.0).abs() > 0.2));
}
