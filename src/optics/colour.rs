//! Colour of a reflectance: tristimulus values, L*a*b*, CIE whiteness and tint, ISO brightness.
//!
//! X = κ Σ S(λ) x̄(λ) R(λ), likewise Y and Z, κ = 100/Σ S ȳ, over 360, 365 … 780 nm (CIE 15; ASTM
//! E308 with 5 nm tables). Wavelengths of 400–700 nm in steps of at most 20 nm are needed; see
//! [`super::reflectance::interpolation`] for the rule between and beyond the given wavelengths.

use super::reflectance::{NotAvailable, covers, dot, gathered};
use super::tables::{self, NODES, node};
use crate::math::cbrt;

/// Illuminant and standard observer of a colour measurement (ISO 5631).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observer {
    /// D65, 10°: outdoor daylight (ISO 5631-2).
    D65Deg10,
    /// C, 2°: indoor daylight (ISO 5631-1).
    CDeg2,
    /// D50, 2°: graphic arts (ISO 5631-3).
    D50Deg2,
    /// A, 10°: incandescent light.
    ADeg10,
}

impl Observer {
    /// All conditions, in the order of reports.
    pub const ALL: [Observer; 4] = [Self::D65Deg10, Self::CDeg2, Self::D50Deg2, Self::ADeg10];

    /// Ending of figure names, as in `l_star_d65_10`.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::D65Deg10 => "d65_10",
            Self::CDeg2 => "c_2",
            Self::D50Deg2 => "d50_2",
            Self::ADeg10 => "a_10",
        }
    }
    fn tables(self) -> (&'static tables::Power, &'static tables::Matching) {
        match self {
            Self::D65Deg10 => (tables::illuminant_d65(), tables::observer_10deg()),
            Self::CDeg2 => (tables::illuminant_c(), tables::observer_2deg()),
            Self::D50Deg2 => (tables::illuminant_d50(), tables::observer_2deg()),
            Self::ADeg10 => (tables::illuminant_a(), tables::observer_10deg()),
        }
    }
}

/// CIE tristimulus values; Y = 100 for the perfect diffuser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Xyz {
    /// X.
    pub x: f64,
    /// Y, the luminance factor in per cent.
    pub y: f64,
    /// Z.
    pub z: f64,
}

impl Xyz {
    /// Chromaticity coordinates x = X/(X + Y + Z), y = Y/(X + Y + Z); NaN for black.
    pub fn chromaticity(self) -> (f64, f64) {
        let sum = self.x + self.y + self.z;
        (self.x / sum, self.y / sum)
    }
    /// CIE 1976 L*a*b* for the white point `white`: L* = 116 f(Y/Yn) − 16,
    /// a* = 500 [f(X/Xn) − f(Y/Yn)], b* = 200 [f(Y/Yn) − f(Z/Zn)], with f(t) = t^⅓ above (6/29)³ and
    /// t/(3 (6/29)²) + 4/29 below (CIE 15, ISO 11664-4).
    pub fn lab(self, white: Xyz) -> Lab {
        let f = |t: f64| {
            const KNEE: f64 = 6.0 / 29.0;
            if t > KNEE * KNEE * KNEE { cbrt(t) } else { t / (3.0 * KNEE * KNEE) + 4.0 / 29.0 }
        };
        let (x, y, z) = (f(self.x / white.x), f(self.y / white.y), f(self.z / white.z));
        Lab { l: 116.0 * y - 16.0, a: 500.0 * (x - y), b: 200.0 * (y - z) }
    }
}

/// CIE 1976 L*a*b* colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lab {
    /// Lightness L*, 0 (black) to 100 (perfect diffuser).
    pub l: f64,
    /// Redness a* (negative: green).
    pub a: f64,
    /// Yellowness b* (negative: blue).
    pub b: f64,
}

/// Weights of X, Y and Z on a fixed grid of wavelengths: a colour costs three dot products.
#[derive(Clone, Debug)]
pub struct ColourWeights {
    weights: [Vec<f64>; 3],
    white: Xyz,
}

impl ColourWeights {
    /// Weights for reflectances at `wavelengths` (nm, increasing); needs 400–700 nm.
    pub fn new(wavelengths: &[f64], observer: Observer) -> Result<Self, NotAvailable> {
        covers(wavelengths, 400.0, 700.0)?;
        let (power, matching) = observer.tables();
        let luminance: f64 = (0..NODES).map(|i| power[i] * matching[i][1]).sum();
        let node_weight = |i: usize, c: usize| 100.0 * power[i] * matching[i][c] / luminance;
        let white = |c| (0..NODES).map(|i| node_weight(i, c)).sum();
        Ok(ColourWeights {
            weights: [0, 1, 2]
                .map(|c| gathered(wavelengths, (0..NODES).map(|i| (node(i), node_weight(i, c))))),
            white: Xyz { x: white(0), y: white(1), z: white(2) },
        })
    }
    /// Tristimulus values of the perfect diffuser.
    pub fn white(&self) -> Xyz {
        self.white
    }
    /// Tristimulus values of the reflectance factors `values` at the grid of wavelengths.
    pub fn xyz(&self, values: &[f64]) -> Xyz {
        let [x, y, z] = [0, 1, 2].map(|c| dot(&self.weights[c], values));
        Xyz { x, y, z }
    }
    /// L*a*b* of the reflectance factors `values`.
    pub fn lab(&self, values: &[f64]) -> Lab {
        self.xyz(values).lab(self.white)
    }
    /// Luminance factor Y/100 (1 for the perfect diffuser); for C/2° the value of ISO 2471.
    pub fn luminance_factor(&self, values: &[f64]) -> f64 {
        dot(&self.weights[1], values) / 100.0
    }
}

/// Constants of CIE whiteness W = Y + 800 (xn − x) + 1700 (yn − y) and of tint
/// T = t (xn − x) − 650 (yn − y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WhitenessFormula {
    /// Chromaticity xn, yn of the perfect diffuser as the standard rounds it.
    pub white_point: (f64, f64),
    /// Factor t of the tint.
    pub tint_factor: f64,
}

impl WhitenessFormula {
    /// D65/10° (ISO 11475).
    pub const D65_10: Self = WhitenessFormula { white_point: (0.3138, 0.3310), tint_factor: 900.0 };
    /// C/2° (ISO 11476).
    pub const C_2: Self = WhitenessFormula { white_point: (0.3101, 0.3162), tint_factor: 1000.0 };

    /// CIE whiteness of the colour `xyz` under the formula's illuminant and observer.
    pub fn whiteness(self, xyz: Xyz) -> f64 {
        let (x, y) = xyz.chromaticity();
        xyz.y + 800.0 * (self.white_point.0 - x) + 1700.0 * (self.white_point.1 - y)
    }
    /// Tint (positive: greenish, negative: reddish).
    pub fn tint(self, xyz: Xyz) -> f64 {
        let (x, y) = xyz.chromaticity();
        self.tint_factor * (self.white_point.0 - x) - 650.0 * (self.white_point.1 - y)
    }
    /// Whether the colour is white in the sense of the standard: 40 < W < 5Y − 280 and |T| < 3.
    /// Outside, W and T have no meaning.
    pub fn applies(self, xyz: Xyz) -> bool {
        let w = self.whiteness(xyz);
        w > 40.0 && w < 5.0 * xyz.y - 280.0 && self.tint(xyz).abs() < 3.0
    }
}

/// Weights of the brightness integral on a grid of wavelengths; their dot product with R∞ is R457
/// as a fraction (ISO 2470-1; 1 for the perfect diffuser). Needs 400–510 nm.
pub fn brightness_weights(wavelengths: &[f64]) -> Result<Vec<f64>, NotAvailable> {
    covers(wavelengths, 400.0, 510.0)?;
    let sum: f64 = tables::r457().iter().map(|w| w.1).sum();
    Ok(gathered(wavelengths, tables::r457().iter().map(|&(wavelength, w)| (wavelength, w / sum))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(step: usize) -> Vec<f64> {
        (360..=780).step_by(step).map(|w| w as f64).collect()
    }

    #[test]
    fn the_perfect_diffuser_is_white_on_any_grid() {
        for step in [1, 5, 10, 20] {
            for observer in Observer::ALL {
                let weights = ColourWeights::new(&grid(step), observer).unwrap();
                let ones = vec![1.0; grid(step).len()];
                let lab = weights.lab(&ones);
                assert!(
                    (lab.l - 100.0).abs() < 1e-11 && lab.a.abs() < 1e-11 && lab.b.abs() < 1e-11,
                    "{lab:?}"
                );
                assert!((weights.luminance_factor(&ones) - 1.0).abs() < 1e-13);
            }
            let ones = vec![1.0; grid(step).len()];
            let brightness = dot(&brightness_weights(&grid(step)).unwrap(), &ones);
            assert!((brightness - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn white_points_are_those_that_the_standards_round() {
        let white = |observer| ColourWeights::new(&grid(5), observer).unwrap().white();
        for (observer, formula) in
            [(Observer::D65Deg10, WhitenessFormula::D65_10), (Observer::CDeg2, WhitenessFormula::C_2)]
        {
            let (x, y) = white(observer).chromaticity();
            assert!((x - formula.white_point.0).abs() < 1e-4 && (y - formula.white_point.1).abs() < 1e-4);
            assert!((formula.whiteness(white(observer)) - 100.0).abs() < 0.2);
        }
    }

    #[test]
    fn a_smooth_spectrum_in_20_nm_steps_has_the_colour_of_5_nm_steps() {
        let kraft = |w: f64| 0.9 - 0.1 * crate::math::exp(-(w - 360.0) / 60.0);
        let lab = |step| {
            let g = grid(step);
            let values: Vec<f64> = g.iter().map(|&w| kraft(w)).collect();
            ColourWeights::new(&g, Observer::CDeg2).unwrap().lab(&values)
        };
        let (fine, coarse) = (lab(5), lab(20));
        assert!((fine.l - coarse.l).abs() < 1e-3 && (fine.b - coarse.b).abs() < 5e-3, "{fine:?} {coarse:?}");
    }

    #[test]
    fn black_has_no_lightness() {
        let weights = ColourWeights::new(&grid(10), Observer::CDeg2).unwrap();
        let lab = weights.lab(&vec![0.0; grid(10).len()]);
        assert!(lab.l.abs() < 1e-12 && lab.a == 0.0 && lab.b == 0.0);
    }

    #[test]
    fn narrow_spectra_say_what_is_missing() {
        let narrow: Vec<f64> = (40..=60).map(|i| 10.0 * i as f64).collect();
        let reason = ColourWeights::new(&narrow, Observer::CDeg2).unwrap_err().to_string();
        assert_eq!(reason, "not available: needs 400–700 nm");
        assert!(brightness_weights(&narrow).is_ok());
        assert_eq!(brightness_weights(&[550.0]).unwrap_err().to_string(), "not available: needs 400–510 nm");
    }
}
