//! Dispersion formulas of refractiveindex.info.

use super::{SpectrumError, inside};
use crate::math::pow;
use std::sync::Arc;

/// The nine dispersion formulas of refractiveindex.info, λ in µm, coefficients C₁, C₂, …
/// (M. N. Polyanskiy, Sci. Data 11, 94 (2024), 10.1038/s41597-023-02898-2; "Dispersion formulas"
/// of the database).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dispersion {
    /// 1: n² − 1 = C₁ + Σ C₂ᵢλ²/(λ² − C₂ᵢ₊₁²).
    Sellmeier,
    /// 2: n² − 1 = C₁ + Σ C₂ᵢλ²/(λ² − C₂ᵢ₊₁).
    Sellmeier2,
    /// 3: n² = C₁ + Σ C₂ᵢ λ^C₂ᵢ₊₁.
    Polynomial,
    /// 4: n² = C₁ + C₂λ^C₃/(λ² − C₄^C₅) + C₆λ^C₇/(λ² − C₈^C₉) + C₁₀λ^C₁₁ + C₁₂λ^C₁₃ + …
    RefractiveIndexInfo,
    /// 5: n = C₁ + Σ C₂ᵢ λ^C₂ᵢ₊₁.
    Cauchy,
    /// 6: n − 1 = C₁ + Σ C₂ᵢ/(C₂ᵢ₊₁ − λ⁻²).
    Gases,
    /// 7: n = C₁ + C₂/(λ² − 0.028) + C₃/(λ² − 0.028)² + C₄λ² + C₅λ⁴ + C₆λ⁶.
    Herzberger,
    /// 8: (n² − 1)/(n² + 2) = C₁ + C₂λ²/(λ² − C₃) + C₄λ².
    Retro,
    /// 9: n² = C₁ + C₂/(λ² − C₃) + C₄(λ − C₅)/((λ − C₅)² + C₆).
    Exotic,
}

impl Dispersion {
    /// The formula with number 1 … 9.
    pub fn from_number(number: u32) -> Option<Self> {
        use Dispersion::*;
        let all = [
            Sellmeier,
            Sellmeier2,
            Polynomial,
            RefractiveIndexInfo,
            Cauchy,
            Gases,
            Herzberger,
            Retro,
            Exotic,
        ];
        all.get(usize::try_from(number).ok()?.checked_sub(1)?).copied()
    }

    /// True where so many coefficients make a complete formula.
    fn takes(self, count: usize) -> bool {
        match self {
            Dispersion::RefractiveIndexInfo => matches!(count, 1 | 5) || (count >= 9 && count % 2 == 1),
            Dispersion::Herzberger => (3..=6).contains(&count),
            Dispersion::Retro => count == 4,
            Dispersion::Exotic => count == 6,
            _ => count % 2 == 1,
        }
    }

    /// n at λ = `um` micrometres; not finite where the formula has no real value.
    fn value(self, c: &[f64], um: f64) -> f64 {
        let l2 = um * um;
        let pairs = |from: usize, term: &dyn Fn(f64, f64) -> f64| -> f64 {
            c[from..].chunks_exact(2).map(|p| term(p[0], p[1])).sum()
        };
        match self {
            Dispersion::Sellmeier => (1.0 + c[0] + pairs(1, &|a, b| a * l2 / (l2 - b * b))).sqrt(),
            Dispersion::Sellmeier2 => (1.0 + c[0] + pairs(1, &|a, b| a * l2 / (l2 - b))).sqrt(),
            Dispersion::Polynomial => (c[0] + pairs(1, &|a, b| a * pow(um, b))).sqrt(),
            Dispersion::RefractiveIndexInfo => {
                let resonances = &c[1..c.len().min(9)];
                let sum: f64 = resonances
                    .chunks_exact(4)
                    .map(|r| if r[0] == 0.0 { 0.0 } else { r[0] * pow(um, r[1]) / (l2 - pow(r[2], r[3])) })
                    .sum();
                (c[0] + sum + pairs(c.len().min(9), &|a, b| a * pow(um, b))).sqrt()
            }
            Dispersion::Cauchy => c[0] + pairs(1, &|a, b| a * pow(um, b)),
            Dispersion::Gases => 1.0 + c[0] + pairs(1, &|a, b| a / (b - 1.0 / l2)),
            Dispersion::Herzberger => {
                let l = 1.0 / (l2 - 0.028);
                c[0] + l * (c[1] + l * c[2]) + c[3..].iter().rev().fold(0.0, |sum, a| l2 * (a + sum))
            }
            Dispersion::Retro => {
                let p = c[0] + c[1] * l2 / (l2 - c[2]) + c[3] * l2;
                ((1.0 + 2.0 * p) / (1.0 - p)).sqrt()
            }
            Dispersion::Exotic => {
                let d = um - c[4];
                (c[0] + c[1] / (l2 - c[2]) + c[3] * d / (d * d + c[5])).sqrt()
            }
        }
    }
}

/// A dispersion formula with its coefficients and its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    name: Arc<str>,
    kind: Dispersion,
    coefficients: Arc<[f64]>,
    range: (f64, f64),
}

impl Formula {
    /// Formula `kind` with the coefficients C₁, C₂, … (for λ in µm), valid between the vacuum
    /// wavelengths `range` in nm; `name` stands in messages.
    ///
    /// # Errors
    /// [`SpectrumError::Invalid`] if the coefficients are too few, too many, leave a term
    /// incomplete or are not finite, or the range is empty.
    pub fn new(
        name: &str,
        kind: Dispersion,
        coefficients: &[f64],
        range: (f64, f64),
    ) -> Result<Self, SpectrumError> {
        let wrong = |what: String| Err(SpectrumError::invalid(name, what));
        if !kind.takes(coefficients.len()) {
            return wrong(format!("{} coefficients do not fit the formula {kind:?}", coefficients.len()));
        }
        if let Some(c) = coefficients.iter().find(|c| !c.is_finite()) {
            return wrong(format!("coefficient {c} is not finite"));
        }
        if !(range.0 > 0.0 && range.0 <= range.1 && range.1.is_finite()) {
            return wrong(format!("{} to {} nm is no range", range.0, range.1));
        }
        Ok(Formula { name: name.into(), kind, coefficients: coefficients.into(), range })
    }

    /// Name, for messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Which formula.
    pub fn kind(&self) -> Dispersion {
        self.kind
    }

    /// Coefficients C₁, C₂, … for λ in µm.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// First and last vacuum wavelength, nm.
    pub fn range(&self) -> (f64, f64) {
        self.range
    }

    /// n at the vacuum wavelength `nm`.
    ///
    /// # Errors
    /// [`SpectrumError::OutOfRange`] outside the range, [`SpectrumError::NotReal`] at a pole or
    /// where n² < 0.
    pub fn at(&self, nm: f64) -> Result<f64, SpectrumError> {
        let name = || self.name.to_string();
        let (low, high) = self.range;
        let x = inside(self.range, nm).ok_or_else(|| SpectrumError::OutOfRange {
            name: name(),
            nm,
            low,
            high,
        })?;
        let n = self.kind.value(&self.coefficients, x / 1000.0);
        if n.is_finite() { Ok(n) } else { Err(SpectrumError::NotReal { name: name(), nm }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each formula against its definition, worked out by hand at λ = 2 µm (λ² = 4, λ⁻² = ¼) with
    /// coefficients that keep the terms apart.
    #[test]
    fn each_formula_by_hand() {
        let at = |number, c: &[f64]| {
            Formula::new("f", Dispersion::from_number(number).unwrap(), c, (100.0, 5000.0))
                .unwrap()
                .at(2000.0)
                .unwrap()
        };
        let near = |got: f64, want: f64| assert!((got - want).abs() < 1e-14, "{got} {want}");
        // 1 + 0.5 + 3·4/(4 − 1²) + 0.75·4/(4 − 0.5²) = 5.5 + 0.8
        near(at(1, &[0.5, 3.0, 1.0, 0.75, 0.5]), 6.3_f64.sqrt());
        // 1 + 0.5 + 3·4/(4 − 1) + 0.875·4/(4 − 0.5) = 5.5 + 1
        near(at(2, &[0.5, 3.0, 1.0, 0.875, 0.5]), 6.5_f64.sqrt());
        // 2 + 0.5·2² + 8·2⁻² = 6
        near(at(3, &[2.0, 0.5, 2.0, 8.0, -2.0]), 6.0_f64.sqrt());
        // 1 + 3·2¹/(4 − 1³) + 2·2²/(4 − 0.75¹) + 0.25·2³ = 1 + 2 + 8/3.25 + 2
        near(
            at(4, &[1.0, 3.0, 1.0, 1.0, 3.0, 2.0, 2.0, 0.75, 1.0, 0.25, 3.0]),
            (1.0 + 2.0 + 8.0 / 3.25 + 2.0_f64).sqrt(),
        );
        near(at(4, &[1.0, 3.0, 1.0, 1.0, 3.0]), 3.0_f64.sqrt());
        // 1.5 + 0.04·2⁻² + 0.32·2⁻⁴
        near(at(5, &[1.5, 0.04, -2.0, 0.32, -4.0]), 1.5 + 0.01 + 0.02);
        // 1 + 0.001 + 0.05/(100.25 − 0.25) + 0.002/(40.25 − 0.25)
        near(at(6, &[0.001, 0.05, 100.25, 0.002, 40.25]), 1.001 + 0.0005 + 0.00005);
        // L = 1/3.972
        let l = 1.0 / 3.972;
        near(
            at(7, &[1.5, 0.1, 0.2, 0.01, 0.002, 0.0003]),
            1.5 + 0.1 * l + 0.2 * l * l + 0.04 + 0.032 + 0.0192,
        );
        near(at(7, &[1.5, 0.1, 0.2]), 1.5 + 0.1 * l + 0.2 * l * l);
        // p = 0.1 + 0.15·4/(4 − 1) + 0.0125·4 = 0.35; n² = 1.7/0.65
        near(at(8, &[0.1, 0.15, 1.0, 0.0125]), (1.7_f64 / 0.65).sqrt());
        // 2 + 1.5/(4 − 1) + 0.5·(2 − 1.5)/(0.25 + 0.25) = 3
        near(at(9, &[2.0, 1.5, 1.0, 0.5, 1.5, 0.25]), 3.0_f64.sqrt());
    }

    #[test]
    fn wrong_counts_poles_and_ranges_are_errors() {
        let new = |k, c: &[f64]| Formula::new("glass", k, c, (400.0, 700.0));
        assert!(new(Dispersion::Sellmeier, &[0.0, 1.0]).is_err());
        assert!(new(Dispersion::Sellmeier, &[]).is_err());
        assert!(new(Dispersion::RefractiveIndexInfo, &[1.0; 7]).is_err());
        assert!(new(Dispersion::Retro, &[0.1; 5]).is_err());
        assert!(new(Dispersion::Cauchy, &[f64::NAN]).is_err());
        assert!(Formula::new("g", Dispersion::Cauchy, &[1.5], (700.0, 400.0)).is_err());
        assert!(Dispersion::from_number(0).is_none() && Dispersion::from_number(10).is_none());
        let f = new(Dispersion::Cauchy, &[1.5]).unwrap();
        assert_eq!(
            f.at(800.0).unwrap_err().to_string(),
            "glass: no value at 800 nm, known from 400 nm to 700 nm"
        );
        let pole = new(Dispersion::Sellmeier2, &[0.0, 1.0, 0.25]).unwrap();
        assert_eq!(pole.at(500.0).unwrap_err(), SpectrumError::NotReal { name: "glass".into(), nm: 500.0 });
        assert!(matches!(pole.at(450.0), Err(SpectrumError::NotReal { .. })));
    }
}
