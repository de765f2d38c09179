//! CIE illuminants, colour-matching functions and the weights of paper-optics figures.
//!
//! Tables of `distributions/cie` (provenance and licence there), part of the program. Illuminants
//! run from 300 to 780 nm, colour-matching functions from 360 to 830 nm: beyond an end a table
//! refuses, the caller decides.

use super::{Table, csv};
use std::sync::OnceLock;

macro_rules! file {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/distributions/cie/", $name))
    };
}

/// A CIE standard colorimetric observer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observer {
    /// CIE 1931, 2°.
    Two,
    /// CIE 1964, 10°.
    Ten,
}

/// A CIE illuminant: relative spectral power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Illuminant {
    /// Incandescent, 2856 K.
    A,
    /// Simulated daylight of older standards, no ultraviolet; of ISO brightness and opacity.
    C,
    /// Daylight, 5003 K.
    D50,
    /// Daylight, 6504 K.
    D65,
}

/// Colour-matching functions of an observer over vacuum wavelength (nm).
#[derive(Clone, Debug, PartialEq)]
pub struct ColourMatching {
    /// x̄(λ).
    pub x: Table,
    /// ȳ(λ).
    pub y: Table,
    /// z̄(λ).
    pub z: Table,
}

/// Colour-matching functions, 360 to 830 nm at 5 nm.
pub fn colour_matching(observer: Observer) -> &'static ColourMatching {
    static TWO: OnceLock<ColourMatching> = OnceLock::new();
    static TEN: OnceLock<ColourMatching> = OnceLock::new();
    match observer {
        Observer::Two => TWO.get_or_init(|| matching(file!("cie1931_2deg_5nm.csv"), "CIE 1931 2° observer")),
        Observer::Ten => {
            TEN.get_or_init(|| matching(file!("cie1964_10deg_5nm.csv"), "CIE 1964 10° observer"))
        }
    }
}

/// Colour-matching functions of the CIE 1931 2° observer, 360 to 830 nm at 1 nm.
pub fn colour_matching_two_1nm() -> &'static ColourMatching {
    static TABLE: OnceLock<ColourMatching> = OnceLock::new();
    TABLE.get_or_init(|| matching(file!("cie1931_2deg_1nm.csv"), "CIE 1931 2° observer, 1 nm"))
}

/// Relative spectral power of an illuminant (100 at 560 nm), 300 to 780 nm at 5 nm.
pub fn illuminant(illuminant: Illuminant) -> &'static Table {
    static A: OnceLock<Table> = OnceLock::new();
    static C: OnceLock<Table> = OnceLock::new();
    static D50: OnceLock<Table> = OnceLock::new();
    static D65: OnceLock<Table> = OnceLock::new();
    match illuminant {
        Illuminant::A => A.get_or_init(|| curve(file!("illuminant_A_5nm.csv"), "CIE illuminant A")),
        Illuminant::C => C.get_or_init(|| curve(file!("illuminant_C_5nm.csv"), "CIE illuminant C")),
        Illuminant::D50 => D50.get_or_init(|| curve(file!("illuminant_D50_5nm.csv"), "CIE illuminant D50")),
        Illuminant::D65 => D65.get_or_init(|| curve(file!("illuminant_D65_5nm.csv"), "CIE illuminant D65")),
    }
}

/// Weights of the diffuse blue reflectance factor R457 (ISO brightness, ISO 2470), 400 to 510 nm at
/// 10 nm, sum 100.
pub fn r457() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    TABLE.get_or_init(|| curve(file!("R457_weights_10nm.csv"), "R457 weights"))
}

/// Weights of the luminance factor Y(C/2°) (ISO 2471 opacity, ISO 9416 s and k): illuminant C times
/// ȳ of the 2° observer, 360 to 780 nm at 5 nm, sum 100.
pub fn y_c2() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    TABLE.get_or_init(|| curve(file!("Y_C2_weights_5nm.csv"), "Y(C/2°) weights"))
}

fn curve(text: &str, name: &str) -> Table {
    csv::read(text, name).expect("the program's own table is sound")
}

fn matching(text: &str, name: &str) -> ColourMatching {
    let rows = csv::rows::<4>(text, name).expect("the program's own table is sound");
    let nm: Vec<f64> = rows.iter().map(|r| r.values[0]).collect();
    let column = |c: usize| {
        Table::new(name, nm.clone(), rows.iter().map(|r| r.values[c]).collect::<Vec<_>>())
            .expect("the program's own table is sound")
    };
    ColourMatching { x: column(1), y: column(2), z: column(3) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chromaticity (x, y) of an illuminant, summed at 5 nm over 380 to 780 nm (CIE 15).
    fn chromaticity(i: Illuminant, o: Observer) -> (f64, f64) {
        let (s, m) = (illuminant(i), colour_matching(o));
        let sum = |t: &Table| {
            (0..=80)
                .map(|j| 380.0 + 5.0 * f64::from(j))
                .map(|w| s.at(w).unwrap() * t.at(w).unwrap())
                .sum::<f64>()
        };
        let (x, y, z) = (sum(&m.x), sum(&m.y), sum(&m.z));
        (x / (x + y + z), y / (x + y + z))
    }

    /// CIE 15:2004 table T.3 (2°) and T.3 (10°): published to 5 digits; 5 nm sums agree to 5e-5.
    #[test]
    fn chromaticities_of_cie_15() {
        for (i, o, x, y) in [
            (Illuminant::A, Observer::Two, 0.44758, 0.40745),
            (Illuminant::C, Observer::Two, 0.31006, 0.31616),
            (Illuminant::D50, Observer::Two, 0.34567, 0.35851),
            (Illuminant::D65, Observer::Two, 0.31272, 0.32903),
            (Illuminant::A, Observer::Ten, 0.45117, 0.40594),
            (Illuminant::D50, Observer::Ten, 0.34773, 0.35952),
            (Illuminant::D65, Observer::Ten, 0.31381, 0.33098),
        ] {
            let (gx, gy) = chromaticity(i, o);
            assert!((gx - x).abs() < 5e-5 && (gy - y).abs() < 5e-5, "{i:?} {o:?}: {gx} {gy}");
        }
    }

    #[test]
    fn weights_are_normalised_and_y_is_illuminant_times_observer() {
        let sum = |t: &Table| t.values().iter().sum::<f64>();
        assert!((sum(r457()) - 100.0).abs() < 1e-9);
        assert!((sum(y_c2()) - 100.0).abs() < 1e-4);
        let product = |w: f64| {
            illuminant(Illuminant::C).at(w).unwrap() * colour_matching(Observer::Two).y.at(w).unwrap()
        };
        let all: f64 = y_c2().wavelengths().iter().map(|w| product(*w)).sum();
        for (w, v) in y_c2().wavelengths().iter().zip(y_c2().values()) {
            assert!((100.0 * product(*w) / all - v).abs() < 1e-6, "{w}");
        }
    }

    #[test]
    fn one_nanometre_observer_holds_the_five_nanometre_one() {
        let (fine, coarse) = (colour_matching_two_1nm(), colour_matching(Observer::Two));
        assert_eq!(coarse.y.range(), (360.0, 830.0));
        for w in coarse.y.wavelengths() {
            assert_eq!(fine.y.at(*w).unwrap(), coarse.y.at(*w).unwrap());
        }
        assert_eq!(illuminant(Illuminant::D65).at(560.0).unwrap(), 100.0);
    }
}
