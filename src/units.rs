//! Units: "12 um", "80 g/m2", "550 nm", "30 deg" ↔ internal numbers.
//!
//! Internal units: length µm, wavelength nm, angle rad, coefficients 1/µm, grammage g/m², coarseness
//! mg/m, density kg/m³, length density 1/µm², number density 1/µm³, fractions 1. A quantity with a
//! dimension needs its unit; a number without dimension takes none. Nothing is guessed.

use std::fmt;

/// What a number measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Length, µm.
    Length,
    /// Vacuum wavelength, nm.
    Wavelength,
    /// Angle, rad.
    Angle,
    /// Absorption or scattering coefficient, 1/µm.
    Coefficient,
    /// Mass over sheet area, g/m².
    Grammage,
    /// Fibre mass over fibre length, mg/m.
    Coarseness,
    /// Mass over volume, kg/m³.
    Density,
    /// Fibre length over volume, 1/µm².
    LengthDensity,
    /// Number over volume, 1/µm³.
    NumberDensity,
    /// Share of a whole: a plain number or %.
    Fraction,
    /// Number without dimension.
    Number,
    /// Whole number ≥ 0; "1e6" is one.
    Count,
}

/// How a unit turns into the internal one; division by a power of ten is exact where multiplication
/// by its inverse is not.
#[derive(Clone, Copy, Debug)]
enum Factor {
    Times(f64),
    Over(f64),
}
use Factor::{Over, Times};

impl Factor {
    fn to_internal(self, x: f64) -> f64 {
        match self {
            Times(f) => x * f,
            Over(f) => x / f,
        }
    }
    fn in_this_unit(self, x: f64) -> f64 {
        match self {
            Times(f) => x / f,
            Over(f) => x * f,
        }
    }
}

impl Quantity {
    /// Units by name, the internal one first.
    fn table(self) -> &'static [(&'static str, Factor)] {
        match self {
            Quantity::Length => &[
                ("um", Times(1.0)),
                ("nm", Over(1e3)),
                ("mm", Times(1e3)),
                ("cm", Times(1e4)),
                ("m", Times(1e6)),
                ("km", Times(1e9)),
            ],
            Quantity::Wavelength => &[("nm", Times(1.0)), ("um", Times(1e3)), ("mm", Times(1e6))],
            Quantity::Angle => {
                &[("rad", Times(1.0)), ("deg", Times(std::f64::consts::PI / 180.0)), ("mrad", Over(1e3))]
            }
            Quantity::Coefficient => &[
                ("1/um", Times(1.0)),
                ("1/nm", Times(1e3)),
                ("1/mm", Over(1e3)),
                ("1/cm", Over(1e4)),
                ("1/m", Over(1e6)),
            ],
            Quantity::Grammage => &[("g/m2", Times(1.0)), ("kg/m2", Times(1e3))],
            Quantity::Coarseness => {
                &[("mg/m", Times(1.0)), ("mg/100m", Over(1e2)), ("ug/m", Over(1e3)), ("g/m", Times(1e3))]
            }
            Quantity::Density => &[("kg/m3", Times(1.0)), ("g/cm3", Times(1e3)), ("g/m3", Over(1e3))],
            Quantity::LengthDensity => {
                &[("1/um2", Times(1.0)), ("1/mm2", Over(1e6)), ("mm/mm3", Over(1e6)), ("um/um3", Times(1.0))]
            }
            Quantity::NumberDensity => &[("1/um3", Times(1.0)), ("1/mm3", Over(1e9))],
            Quantity::Fraction => &[("", Times(1.0)), ("%", Over(1e2))],
            Quantity::Number | Quantity::Count => &[("", Times(1.0))],
        }
    }

    /// Name in messages: "a length".
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Length => "a length",
            Quantity::Wavelength => "a wavelength",
            Quantity::Angle => "an angle",
            Quantity::Coefficient => "a coefficient (inverse length)",
            Quantity::Grammage => "a grammage",
            Quantity::Coarseness => "a coarseness",
            Quantity::Density => "a density",
            Quantity::LengthDensity => "a length density",
            Quantity::NumberDensity => "a number density",
            Quantity::Fraction => "a fraction (number or %)",
            Quantity::Number => "a plain number",
            Quantity::Count => "a whole number",
        }
    }

    /// Does a number of this quantity need a unit?
    pub fn has_unit(self) -> bool {
        !self.table()[0].0.is_empty()
    }

    /// Names of the units, the internal one first.
    pub fn units(self) -> Vec<&'static str> {
        self.table().iter().map(|u| u.0).filter(|u| !u.is_empty()).collect()
    }

    /// The internal value as text with its internal unit: `Length.show(12.5)` is "12.5 um". Read back
    /// by [`Quantity::parse`] it gives the same bits.
    pub fn show(self, x: f64) -> String {
        let unit = self.table()[0].0;
        let number =
            if x != 0.0 && !(1e-4..1e15).contains(&x.abs()) { format!("{x:e}") } else { format!("{x}") };
        if unit.is_empty() { number } else { format!("{number} {unit}") }
    }

    /// The value in one of the units of [`Quantity::units`]; None for another unit.
    pub fn in_unit(self, x: f64, unit: &str) -> Option<f64> {
        self.table().iter().find(|u| u.0 == unit).map(|u| u.1.in_this_unit(x))
    }

    /// Reads one number with its unit into internal units.
    ///
    /// # Errors
    /// [`UnitError`] for anything but one finite number with a unit of this quantity.
    pub fn parse(self, text: &str) -> Result<f64, UnitError> {
        let (number, unit) = split(text).ok_or_else(|| self.not_a_number(text))?;
        if unit.is_empty() && self.has_unit() {
            return Err(UnitError::MissingUnit { quantity: self, text: text.trim().into() });
        }
        self.convert(number, unit, text)
    }

    /// Reads numbers parted by blanks or commas; a number without unit takes the next unit in the list:
    /// "400 500 600 nm", "0 0 -2 um", "450 nm, 0.55 um".
    ///
    /// # Errors
    /// As [`Quantity::parse`], for the first bad item.
    pub fn parse_list(self, text: &str) -> Result<Vec<f64>, UnitError> {
        let mut items: Vec<(&str, &str)> = Vec::new();
        let mut rest = text.trim_start_matches(is_gap);
        while !rest.is_empty() {
            let end = number_end(rest).ok_or_else(|| self.not_a_number(rest))?;
            let (number, tail) = rest.split_at(end);
            let unit_start = tail.trim_start();
            let unit_len = unit_start.find(is_gap).unwrap_or(unit_start.len());
            let first = unit_start.chars().next();
            if first.is_some_and(|c| {
                !is_gap(c) && number_end(unit_start).is_none() || is_unit_with_digit(unit_start)
            }) {
                items.push((number, &unit_start[..unit_len]));
                rest = unit_start[unit_len..].trim_start_matches(is_gap);
            } else {
                items.push((number, ""));
                rest = tail.trim_start_matches(is_gap);
            }
        }
        if items.is_empty() {
            return Err(self.not_a_number(text));
        }
        let mut unit = "";
        let mut values = Vec::with_capacity(items.len());
        for &(number, own) in items.iter().rev() {
            if !own.is_empty() {
                unit = own;
            }
            if unit.is_empty() && self.has_unit() {
                return Err(UnitError::MissingUnit { quantity: self, text: text.trim().into() });
            }
            values.push(self.convert(number, unit, number)?);
        }
        values.reverse();
        Ok(values)
    }

    fn not_a_number(self, text: &str) -> UnitError {
        let text = text.trim();
        let word = text.trim_start_matches(['+', '-']).to_ascii_lowercase();
        if word.starts_with("nan") || word.starts_with("inf") {
            return UnitError::NotFinite { quantity: self, text: text.into() };
        }
        UnitError::NotANumber { quantity: self, text: text.into() }
    }

    fn convert(self, number: &str, unit: &str, text: &str) -> Result<f64, UnitError> {
        let text = text.trim();
        let value: f64 = number.parse().map_err(|_| self.not_a_number(text))?;
        let unit = canonical(unit);
        let Some((_, factor)) = self.table().iter().find(|u| u.0 == unit) else {
            return Err(UnitError::UnknownUnit { quantity: self, unit });
        };
        let value = factor.to_internal(value);
        if !value.is_finite() {
            return Err(UnitError::NotFinite { quantity: self, text: text.into() });
        }
        if self == Quantity::Count && (value < 0.0 || value.fract() != 0.0) {
            return Err(UnitError::NotWhole { text: text.into() });
        }
        Ok(value)
    }
}

/// Reads a whole number ≥ 0 exactly: digits up to u64, or a float form that is whole ("1e6").
///
/// # Errors
/// [`UnitError`] where the text is no whole number or is too large.
pub fn count(text: &str) -> Result<u64, UnitError> {
    if let Ok(n) = text.trim().parse::<u64>() {
        return Ok(n);
    }
    let x = Quantity::Count.parse(text)?;
    if x > 9_007_199_254_740_992.0 {
        return Err(UnitError::NotWhole { text: text.trim().into() });
    }
    Ok(x as u64)
}

/// Why a number was not read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UnitError {
    /// No number at the start.
    NotANumber {
        /// What was expected.
        quantity: Quantity,
        /// What stands there.
        text: String,
    },
    /// nan, inf, or too large for a double.
    NotFinite {
        /// What was expected.
        quantity: Quantity,
        /// What stands there.
        text: String,
    },
    /// A dimension without unit.
    MissingUnit {
        /// What was expected.
        quantity: Quantity,
        /// What stands there.
        text: String,
    },
    /// A unit of another quantity, or of none.
    UnknownUnit {
        /// What was expected.
        quantity: Quantity,
        /// What stands there.
        unit: String,
    },
    /// A count that is negative, broken or beyond 2⁵³.
    NotWhole {
        /// What stands there.
        text: String,
    },
}

impl UnitError {
    /// A way out: an example or the units that are known.
    pub fn help(&self) -> String {
        match self {
            UnitError::MissingUnit { quantity, text } => format!(
                "write \"{text} {}\"; known units: {}",
                quantity.units().first().unwrap_or(&""),
                quantity.units().join(", ")
            ),
            UnitError::UnknownUnit { quantity, .. } | UnitError::NotANumber { quantity, .. } => {
                let units = quantity.units();
                if units.is_empty() {
                    "a number without unit is expected".into()
                } else {
                    format!("known units: {}", units.join(", "))
                }
            }
            UnitError::NotFinite { .. } => "every number of a scene is finite".into(),
            UnitError::NotWhole { .. } => "whole numbers from 0 to 2^53, as 100000 or 1e5".into(),
        }
    }
}

impl fmt::Display for UnitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            UnitError::NotANumber { quantity, text } => {
                write!(f, "expected {}, found `{text}`", quantity.name())
            }
            UnitError::NotFinite { quantity, text } => {
                write!(f, "expected {}, found `{text}`, which is not a finite number", quantity.name())
            }
            UnitError::MissingUnit { quantity, text } => {
                write!(f, "expected {} with its unit, found `{text}` without unit", quantity.name())
            }
            UnitError::UnknownUnit { quantity, unit } => {
                write!(f, "expected {}, but `{unit}` is no unit of it", quantity.name())
            }
            UnitError::NotWhole { text } => write!(f, "expected a whole number, found `{text}`"),
        }
    }
}
impl std::error::Error for UnitError {}

/// Splits "12 um" into number and unit.
fn split(text: &str) -> Option<(&str, &str)> {
    let text = text.trim();
    let (number, unit) = text.split_at(number_end(text)?);
    Some((number, unit.trim()))
}

/// Length of the decimal number at the start of `s` (sign, digits, point, exponent), if there is one.
fn number_end(s: &str) -> Option<usize> {
    let b = s.as_bytes();
    let digits = |from: usize| b[from..].iter().take_while(|c| c.is_ascii_digit()).count();
    let mut i = usize::from(matches!(b.first(), Some(b'+' | b'-')));
    let whole = digits(i);
    i += whole;
    let mut broken = 0;
    if b.get(i) == Some(&b'.') {
        broken = digits(i + 1);
        i += 1 + broken;
    }
    if whole + broken == 0 {
        return None;
    }
    if matches!(b.get(i), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(b.get(i + 1), Some(b'+' | b'-')));
        let exponent = digits(i + 1 + sign);
        if exponent > 0 {
            i += 1 + sign + exponent;
        }
    }
    Some(i)
}

/// Units that begin like a number: "1/mm".
fn is_unit_with_digit(s: &str) -> bool {
    s.starts_with("1/")
}

fn is_gap(c: char) -> bool {
    c.is_whitespace() || c == ',' || c == ';'
}

/// One spelling for µ, μ, °, ², ³.
fn canonical(unit: &str) -> String {
    unit.chars()
        .filter(|c| !c.is_whitespace())
        .map(|c| match c {
            'µ' | 'μ' => 'u',
            '²' => '2',
            '³' => '3',
            c => c,
        })
        .collect::<String>()
        .replace('°', "deg")
        .replace('^', "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_with_units() {
        for (q, text, want) in [
            (Quantity::Length, "12 um", 12.0),
            (Quantity::Length, "12µm", 12.0),
            (Quantity::Length, " 12.5 μm ", 12.5),
            (Quantity::Length, "550 nm", 0.55),
            (Quantity::Length, "-.1 mm", -100.0),
            (Quantity::Wavelength, "0.55 um", 550.0),
            (Quantity::Angle, "180 deg", std::f64::consts::PI),
            (Quantity::Angle, "90°", std::f64::consts::FRAC_PI_2),
            (Quantity::Coefficient, "0.1 1/mm", 1e-4),
            (Quantity::Grammage, "80 g/m²", 80.0),
            (Quantity::Coarseness, "1.5 mg/m", 1.5),
            (Quantity::Coarseness, "18 mg/100m", 0.18),
            (Quantity::Density, "1.5 g/cm3", 1500.0),
            (Quantity::LengthDensity, "1000 mm/mm3", 1e-3),
            (Quantity::NumberDensity, "5 1/mm3", 5e-9),
            (Quantity::Fraction, "5 %", 0.05),
            (Quantity::Fraction, "0.25", 0.25),
            (Quantity::Number, "1e6", 1e6),
            (Quantity::Number, "+.5E-2", 0.005),
        ] {
            assert_eq!(q.parse(text), Ok(want), "{text}");
        }
        assert_eq!(count("1e6"), Ok(1_000_000));
        assert_eq!(count("18446744073709551615"), Ok(u64::MAX));
    }

    #[test]
    fn lists_take_the_next_unit() {
        assert_eq!(Quantity::Length.parse_list("0 0 -2 um"), Ok(vec![0.0, 0.0, -2.0]));
        assert_eq!(Quantity::Wavelength.parse_list("400, 0.5 um, 600 nm"), Ok(vec![400e3, 500.0, 600.0]));
        assert_eq!(Quantity::Coefficient.parse_list("3 1/mm 4 1/um"), Ok(vec![3e-3, 4.0]));
        assert_eq!(Quantity::Number.parse_list("1 0 0"), Ok(vec![1.0, 0.0, 0.0]));
        assert_eq!(Quantity::Length.parse_list("1um,2mm"), Ok(vec![1.0, 2000.0]));
        assert!(Quantity::Length.parse_list("1 um 2").is_err(), "a last number without unit");
        assert!(Quantity::Length.parse_list("").is_err());
        assert!(Quantity::Number.parse_list("1 x 2").is_err());
    }

    #[test]
    fn refusals_say_what_was_expected() {
        let message = |q: Quantity, t: &str| {
            let e = q.parse(t).unwrap_err();
            format!("{e} | {}", e.help())
        };
        assert_eq!(
            message(Quantity::Length, "12"),
            "expected a length with its unit, found `12` without unit | write \"12 um\"; known units: um, nm, mm, cm, m, km"
        );
        assert_eq!(
            message(Quantity::Grammage, "80 gsm"),
            "expected a grammage, but `gsm` is no unit of it | known units: g/m2, kg/m2"
        );
        for bad in ["nan", "inf", "-inf", "1e999", "NaN um", "1e999 um", "1e308 km"] {
            assert!(
                matches!(
                    Quantity::Length.parse(bad),
                    Err(UnitError::NotFinite { .. } | UnitError::MissingUnit { .. })
                ),
                "{bad}"
            );
        }
        for bad in ["", "um", "1,5 um", "--1 um", "0x10 um", "1 um um", "1e um", "."] {
            assert!(Quantity::Length.parse(bad).is_err(), "{bad}");
        }
        for bad in ["1.5", "-1", "1e300", "18446744073709551616"] {
            assert!(count(bad).is_err(), "{bad}");
        }
        assert!(Quantity::Number.parse("1 um").is_err());
        assert!(Quantity::Fraction.parse("5 %%").is_err());
    }

    /// What `show` writes, `parse` reads to the same bits.
    #[test]
    fn show_and_parse_are_inverse() {
        for x in [0.0, 1.0, 0.1, 1.0 / 3.0, 12.5, 1e-9, 1.234e22, -7.25, f64::MIN_POSITIVE] {
            for q in [Quantity::Length, Quantity::Coarseness, Quantity::NumberDensity, Quantity::Number] {
                assert_eq!(q.parse(&q.show(x)).unwrap().to_bits(), x.to_bits(), "{}", q.show(x));
            }
        }
        assert_eq!(Quantity::Length.in_unit(12_000.0, "mm"), Some(12.0));
    }
}
