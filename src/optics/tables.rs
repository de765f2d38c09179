//! Tables of the CIE and of ISO 2470-1, as in `distributions/cie/*.csv` (each file names its origin).

use std::sync::OnceLock;

/// Wavelengths of the summation in nm: 360, 365 … 780.
pub const NODES: usize = 85;

/// Wavelength in nm of node `i` of the 5 nm summation.
pub fn node(i: usize) -> f64 {
    360.0 + 5.0 * i as f64
}

/// Colour-matching functions x̄, ȳ, z̄ at the nodes (dimensionless).
pub type Matching = [[f64; 3]; NODES];
/// Relative spectral power of an illuminant at the nodes (100 at 560 nm).
pub type Power = [f64; NODES];

/// Rows of numbers of a CSV text with `#` comments and one heading line.
fn rows(text: &str) -> impl Iterator<Item = Vec<f64>> + '_ {
    text.lines().filter(|l| !l.starts_with('#')).skip(1).map(|l| {
        l.split(',').map(|cell| cell.trim().parse().expect("a number in an embedded table")).collect()
    })
}

/// Column values at the nodes, `width` columns after the wavelength.
fn at_nodes<const W: usize>(text: &str) -> [[f64; W]; NODES] {
    let mut out = [[f64::NAN; W]; NODES];
    for row in rows(text) {
        let i = (row[0] - 360.0) / 5.0;
        if (0.0..NODES as f64).contains(&i) && i.fract() == 0.0 {
            out[i as usize].copy_from_slice(&row[1..=W]);
        }
    }
    out
}

macro_rules! power {
    ($(#[$doc:meta])* $name:ident, $file:literal) => {
        $(#[$doc])*
        pub fn $name() -> &'static Power {
            static TABLE: OnceLock<Power> = OnceLock::new();
            TABLE.get_or_init(|| {
                at_nodes::<1>(include_str!(concat!("../../distributions/cie/", $file))).map(|[s]| s)
            })
        }
    };
}
power!(
    /// CIE illuminant A (incandescent light, 2856 K).
    illuminant_a, "illuminant_A_5nm.csv"
);
power!(
    /// CIE illuminant C (indoor daylight; brightness and opacity of paper).
    illuminant_c, "illuminant_C_5nm.csv"
);
power!(
    /// CIE illuminant D50 (graphic arts).
    illuminant_d50, "illuminant_D50_5nm.csv"
);
power!(
    /// CIE illuminant D65 (outdoor daylight).
    illuminant_d65, "illuminant_D65_5nm.csv"
);

/// CIE 1931 standard observer, 2° field.
pub fn observer_2deg() -> &'static Matching {
    static TABLE: OnceLock<Matching> = OnceLock::new();
    TABLE.get_or_init(|| at_nodes(include_str!("../../distributions/cie/cie1931_2deg_5nm.csv")))
}

/// CIE 1964 standard observer, 10° field.
pub fn observer_10deg() -> &'static Matching {
    static TABLE: OnceLock<Matching> = OnceLock::new();
    TABLE.get_or_init(|| at_nodes(include_str!("../../distributions/cie/cie1964_10deg_5nm.csv")))
}

/// Weights of ISO brightness R457 (ISO 2470-1) as (wavelength in nm, weight); they add up to 100.
pub fn r457() -> &'static [(f64, f64)] {
    static TABLE: OnceLock<Vec<(f64, f64)>> = OnceLock::new();
    TABLE.get_or_init(|| {
        rows(include_str!("../../distributions/cie/R457_weights_10nm.csv")).map(|r| (r[0], r[1])).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_node_of_every_table_is_filled() {
        for power in [illuminant_a(), illuminant_c(), illuminant_d50(), illuminant_d65()] {
            assert!(power.iter().all(|s| s.is_finite() && *s > 0.0));
            assert_eq!(
                power[(560 - 360) / 5].round(),
                if std::ptr::eq(power, illuminant_c()) { 105.0 } else { 100.0 }
            );
        }
        for observer in [observer_2deg(), observer_10deg()] {
            assert!(observer.iter().flatten().all(|x| x.is_finite() && *x >= -1e-20));
        }
    }

    #[test]
    fn brightness_weights_have_the_effective_wavelength_of_the_standard() {
        let sum: f64 = r457().iter().map(|w| w.1).sum();
        let mean: f64 = r457().iter().map(|w| w.0 * w.1).sum::<f64>() / sum;
        assert!((sum - 100.0).abs() < 1e-9, "sum {sum}");
        assert!((mean - 457.0).abs() < 0.5, "effective wavelength {mean} nm");
    }

    /// S_C ȳ, computed independently and rounded to six decimals.
    #[test]
    fn luminance_weights_agree_with_the_table_of_iso_2471() {
        let products: Vec<f64> = (0..NODES).map(|i| illuminant_c()[i] * observer_2deg()[i][1]).collect();
        let sum: f64 = products.iter().sum();
        let table: Vec<f64> =
            rows(include_str!("../../distributions/cie/Y_C2_weights_5nm.csv")).map(|r| r[1]).collect();
        assert_eq!(table.len(), NODES);
        for (p, w) in products.iter().zip(table) {
            assert!((100.0 * p / sum - w).abs() < 6e-7, "{} against {w}", 100.0 * p / sum);
        }
    }
}
