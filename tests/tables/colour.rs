//! Colour of five spectra against colour-science, to 1e-9.

use crate::harness::{Check, Row, hold, rows, within};
use lightpro::optics::colour::{ColourWeights, Observer, WhitenessFormula, brightness_weights};
use lightpro::optics::figures::PaperWeights;
use lightpro::optics::reflectance::dot;
use lightpro::optics::tables;

fn spectrum(name: &str) -> (Vec<f64>, Vec<f64>) {
    rows("colour_spectra.csv").iter().map(|r| (r.f("wavelength_nm"), r.f(name))).unzip()
}

/// Worst deviation of a row's 28 values, the spectrum moved by `shift` at all wavelengths.
fn deviation(row: &Row, shift: f64) -> f64 {
    let (wavelengths, mut values) = spectrum(row.text("spectrum"));
    values.iter_mut().for_each(|v| *v += shift);
    let near = |got: f64, column: &str| {
        let want = row.f(column);
        match within(got, want, 1e-9 * want.abs().max(1.0)) {
            Check::Deviation(d) => d,
            Check::Cannot(_) => unreachable!(),
        }
    };
    let mut worst: f64 = 0.0;
    for (observer, suffix) in Observer::ALL.into_iter().zip(["D6510", "C2", "D502", "A10"]) {
        let weights = ColourWeights::new(&wavelengths, observer).unwrap();
        let (xyz, lab) = (weights.xyz(&values), weights.lab(&values));
        let got = [("X", xyz.x), ("Y", xyz.y), ("Z", xyz.z), ("L", lab.l), ("a", lab.a), ("b", lab.b)];
        for (letter, got) in got {
            worst = worst.max(near(got, &format!("{letter}_{suffix}")));
        }
        if observer == Observer::D65Deg10 {
            worst = worst
                .max(near(WhitenessFormula::D65_10.whiteness(xyz), "whiteness_CIE_D65_10"))
                .max(near(WhitenessFormula::D65_10.tint(xyz), "tint_CIE_D65_10"));
        }
    }
    let brightness = dot(&brightness_weights(&wavelengths).unwrap(), &values);
    let luminance = PaperWeights::new(&wavelengths).luminance(&values).unwrap();
    worst.max(near(brightness, "R457_10nm_weights")).max(near(luminance, "RY_C2"))
}

#[test]
fn colours_agree() {
    hold("colour_values.csv", |row| Check::Deviation(deviation(row, 0.0)));
}

/// A reflectance that is off by 1e-9 is seen in every spectrum.
#[test]
fn colour_tolerance_bites() {
    for row in rows("colour_values.csv") {
        assert!(deviation(&row, 1e-9) > 1.0, "{}", row.text("spectrum"));
    }
}

/// Worst relative deviation of a row of the 5 nm tables, read at a node `off` places away.
fn table_deviation(row: &Row, off: usize) -> f64 {
    let i = ((row.f("wavelength_nm") - 360.0) / 5.0) as usize + off;
    let (two, ten) = (tables::observer_2deg()[i], tables::observer_10deg()[i]);
    let got = [
        ("x2", two[0]),
        ("y2", two[1]),
        ("z2", two[2]),
        ("x10", ten[0]),
        ("y10", ten[1]),
        ("z10", ten[2]),
        ("D65", tables::illuminant_d65()[i]),
        ("C", tables::illuminant_c()[i]),
        ("D50", tables::illuminant_d50()[i]),
        ("A", tables::illuminant_a()[i]),
    ];
    got.iter().fold(0.0, |worst: f64, (column, got)| {
        worst.max((got - row.f(column)).abs() / (1e-12 * row.f(column).abs() + 1e-18))
    })
}

#[test]
fn embedded_tables_agree() {
    hold("colour_tables_5nm.csv", |row| Check::Deviation(table_deviation(row, 0)));
}

/// The neighbouring wavelength fails.
#[test]
fn table_tolerance_bites() {
    for row in rows("colour_tables_5nm.csv").iter().filter(|r| r.f("wavelength_nm") < 780.0) {
        assert!(table_deviation(row, 1) > 1.0, "line {}", row.line);
    }
}
