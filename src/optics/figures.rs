//! The figures by which paper is bought, from the reflectance of a sheet and of an opaque pad.

use super::colour::{ColourWeights, Observer, WhitenessFormula, brightness_weights};
use super::kubelka_munk::{Coefficients, ILL_CONDITIONED_OPACITY};
use super::reflectance::{NotAvailable, dot};

/// One figure: its stable name, its unit, and its value or what it needs.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperFigure {
    /// Name as in `result.json`.
    pub name: String,
    /// Unit: `%`, `m2/kg` or `1`.
    pub unit: &'static str,
    /// Value, or the reason why there is none.
    pub value: Result<f64, NotAvailable>,
    /// What a reader should know, e.g. that s is ill-conditioned.
    pub caution: Option<&'static str>,
}

/// Reflectances of one sheet at the wavelengths of a [`PaperWeights`]; 1 is the perfect diffuser.
#[derive(Clone, Copy, Debug, Default)]
pub struct Measured<'a> {
    /// R0, of one sheet over black.
    pub r0: Option<&'a [f64]>,
    /// R∞, of an opaque pad of such sheets.
    pub r_inf: Option<&'a [f64]>,
    /// Grammage in kg/m².
    pub grammage: Option<f64>,
}

/// Weights of all broad-band figures for a fixed grid of wavelengths, worked out once; evaluating
/// the figures is then a few dot products, cheap enough for every replica of a jackknife.
#[derive(Clone, Debug)]
pub struct PaperWeights {
    brightness: Result<Vec<f64>, NotAvailable>,
    colours: [Result<ColourWeights, NotAvailable>; 4],
}

impl PaperWeights {
    /// Weights for reflectances at `wavelengths` in nm.
    pub fn new(wavelengths: &[f64]) -> Self {
        PaperWeights {
            brightness: brightness_weights(wavelengths),
            colours: Observer::ALL.map(|observer| ColourWeights::new(wavelengths, observer)),
        }
    }

    /// Weights of X, Y, Z under `observer`.
    pub fn colour(&self, observer: Observer) -> Result<&ColourWeights, NotAvailable> {
        let i = Observer::ALL.iter().position(|o| *o == observer).unwrap_or(0);
        self.colours[i].as_ref().map_err(Clone::clone)
    }

    /// ISO brightness R457 in per cent of an opaque pad, Σ W(λ) R∞(λ) (ISO 2470-1).
    pub fn brightness(&self, r_inf: &[f64]) -> Result<f64, NotAvailable> {
        self.brightness.as_ref().map(|w| 100.0 * dot(w, r_inf)).map_err(Clone::clone)
    }

    /// Luminance factor Y in per cent for C/2° (ISO 2471).
    pub fn luminance(&self, values: &[f64]) -> Result<f64, NotAvailable> {
        Ok(100.0 * self.colour(Observer::CDeg2)?.luminance_factor(values))
    }

    /// Opacity 100 R0,Y/R∞,Y in per cent (ISO 2471).
    pub fn opacity(&self, r0: &[f64], r_inf: &[f64]) -> Result<f64, NotAvailable> {
        let pad = self.luminance(r_inf)?;
        if pad > 0.0 {
            Ok(100.0 * self.luminance(r0)? / pad)
        } else {
            Err(NotAvailable::needs("a pad that reflects"))
        }
    }

    /// s and k in m²/kg from the luminance factors R0,Y and R∞,Y and the grammage `w` in kg/m²
    /// (ISO 9416).
    pub fn coefficients(&self, r0: &[f64], r_inf: &[f64], w: f64) -> Result<Coefficients, NotAvailable> {
        Coefficients::from_r0_r_inf(self.luminance(r0)? / 100.0, self.luminance(r_inf)? / 100.0, w)
    }

    /// All figures, always the same names in the same order, whatever is available.
    pub fn evaluate(&self, sheet: Measured) -> Vec<PaperFigure> {
        let pad = || sheet.r_inf.ok_or_else(|| NotAvailable::needs("R∞ of an opaque pad"));
        let single = || sheet.r0.ok_or_else(|| NotAvailable::needs("R0 of one sheet over black"));
        let grammage = || sheet.grammage.ok_or_else(|| NotAvailable::needs("the grammage of the sheet"));
        let opacity = single().and_then(|r0| self.opacity(r0, pad()?));
        let s_k = single().and_then(|r0| self.coefficients(r0, pad()?, grammage()?));
        let near = opacity.as_ref().is_ok_and(|o| *o > 100.0 * ILL_CONDITIONED_OPACITY);
        let ill = near.then_some("opacity above 95 %: s and k are ill-conditioned");

        let mut figures = Vec::new();
        let mut put = |name: &str, unit, value, caution| {
            figures.push(PaperFigure { name: name.to_owned(), unit, value, caution })
        };
        put("brightness_r457", "%", pad().and_then(|r| self.brightness(r)), None);
        put("sheet_r457_over_black", "%", single().and_then(|r| self.brightness(r)), None);
        put("luminance_factor_c_2", "%", pad().and_then(|r| self.luminance(r)), None);
        put("opacity", "%", opacity, None);
        put("s", "m2/kg", s_k.clone().map(|c| c.s), ill);
        put("k", "m2/kg", s_k.map(|c| c.k), ill);
        for (observer, formula) in
            [(Observer::D65Deg10, WhitenessFormula::D65_10), (Observer::CDeg2, WhitenessFormula::C_2)]
        {
            let xyz = pad().and_then(|r| Ok(self.colour(observer)?.xyz(r)));
            let outside = xyz.as_ref().is_ok_and(|c| !formula.applies(*c));
            let caution = outside.then_some("outside the limits of the formula: not a white");
            let suffix = observer.suffix();
            put(&format!("whiteness_cie_{suffix}"), "1", xyz.clone().map(|c| formula.whiteness(c)), caution);
            put(&format!("tint_cie_{suffix}"), "1", xyz.map(|c| formula.tint(c)), caution);
        }
        for observer in Observer::ALL {
            let lab = pad().and_then(|r| Ok(self.colour(observer)?.lab(r)));
            let suffix = observer.suffix();
            put(&format!("l_star_{suffix}"), "1", lab.clone().map(|c| c.l), None);
            put(&format!("a_star_{suffix}"), "1", lab.clone().map(|c| c.a), None);
            put(&format!("b_star_{suffix}"), "1", lab.map(|c| c.b), None);
        }
        figures
    }
}

/// Half-angle in degrees of the gloss trap of the d/0 geometry (ISO 2469).
pub const GLOSS_TRAP_DEG: f64 = 15.5;

/// Reflectance factor d/0 by reciprocity from the power that leaves beyond the gloss trap, as a
/// share of light incident at 0°: R = P/cos² 15.5° = P/0.92858. It is 1 for a Lambertian surface
/// that reflects everything. Valid only where the universe is reciprocal.
pub fn diffuse_zero(power_beyond_trap: f64) -> f64 {
    let c = crate::math::cos(GLOSS_TRAP_DEG * std::f64::consts::PI / 180.0);
    power_beyond_trap / (c * c)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(figures: &[PaperFigure], name: &str) -> f64 {
        *figures.iter().find(|f| f.name == name).unwrap().value.as_ref().unwrap()
    }

    #[test]
    fn perfect_white_has_perfect_figures() {
        let grid: Vec<f64> = (0..31).map(|i| 400.0 + 10.0 * i as f64).collect();
        let (white, sheet) = (vec![1.0; 31], vec![0.6; 31]);
        let all = PaperWeights::new(&grid).evaluate(Measured {
            r0: Some(&sheet),
            r_inf: Some(&white),
            grammage: Some(0.08),
        });
        assert_eq!(all.len(), 22);
        for name in ["brightness_r457", "luminance_factor_c_2", "l_star_d65_10", "l_star_c_2"] {
            assert!((value(&all, name) - 100.0).abs() < 1e-10, "{name}");
        }
        assert!((value(&all, "opacity") - 60.0).abs() < 1e-11);
        assert!((value(&all, "s") - 18.75).abs() < 1e-9, "k = 0: s = R0/(w (1 − R0))");
        assert!(value(&all, "k").abs() < 1e-20);
        assert!((value(&all, "whiteness_cie_d65_10") - 100.0).abs() < 0.1);
        assert!(value(&all, "a_star_d50_2").abs() < 1e-11);
        assert!(all.iter().all(|f| f.caution.is_none()));
    }

    #[test]
    fn what_is_missing_is_said_and_the_names_stay() {
        let grid = [550.0];
        let all = PaperWeights::new(&grid).evaluate(Measured { r_inf: Some(&[0.8]), ..Default::default() });
        let none = PaperWeights::new(&grid).evaluate(Measured::default());
        let reason = |f: &[PaperFigure], name: &str| {
            f.iter().find(|f| f.name == name).unwrap().value.as_ref().unwrap_err().to_string()
        };
        assert_eq!(reason(&all, "brightness_r457"), "not available: needs 400–510 nm");
        assert_eq!(reason(&all, "l_star_c_2"), "not available: needs 400–700 nm");
        assert_eq!(reason(&all, "opacity"), "not available: needs R0 of one sheet over black");
        assert_eq!(reason(&none, "brightness_r457"), "not available: needs R∞ of an opaque pad");
        assert!(all.iter().map(|f| &f.name).eq(none.iter().map(|f| &f.name)));
    }

    #[test]
    fn nearly_opaque_sheets_carry_a_caution() {
        let grid: Vec<f64> = (0..31).map(|i| 400.0 + 10.0 * i as f64).collect();
        let (pad, sheet) = (vec![0.7; 31], vec![0.69; 31]);
        let all = PaperWeights::new(&grid).evaluate(Measured {
            r0: Some(&sheet),
            r_inf: Some(&pad),
            grammage: Some(0.08),
        });
        let s = all.iter().find(|f| f.name == "s").unwrap();
        assert!(s.value.is_ok() && s.caution.unwrap().contains("95 %"));
    }

    /// ∫ beyond the trap of cos θ/π over the hemisphere is cos² 15.5°.
    #[test]
    fn lambertian_light_reads_one_in_d0() {
        let beyond: f64 =
            crate::math::gauss_legendre(20, GLOSS_TRAP_DEG.to_radians(), crate::math::FRAC_PI_2)
                .iter()
                .map(|(t, w)| w * 2.0 * crate::math::sin(*t) * crate::math::cos(*t))
                .sum();
        assert!((diffuse_zero(beyond) - 1.0).abs() < 1e-13);
        assert!((1.0 / diffuse_zero(1.0) - 0.92858).abs() < 1e-5);
    }
}
