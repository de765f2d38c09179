//! Spectra: a quantity over vacuum wavelength (nm), as a constant, a table or a dispersion formula.
//!
//! - [`Table`]: linear interpolation between ascending wavelengths.
//! - [`Formula`]: the nine dispersion formulas of refractiveindex.info.
//! - [`csv`], [`rii`]: readers that name line and column of what they refuse.
//! - [`cie`]: illuminants and colour-matching functions.
//!
//! Outside its range a spectrum answers with an error that names it and its range, unless it was
//! told to hold its end values ([`Extrapolate::Clamp`]).

pub mod cie;
pub mod csv;
pub mod formula;
pub mod rii;
pub mod table;

pub use formula::{Dispersion, Formula};
pub use table::{Extrapolate, Table};

/// A quantity over vacuum wavelength (nm): refractive index, absorption coefficient (1/µm),
/// reflectance, power … Cheap to clone (tables are shared).
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same at every wavelength.
    Constant(f64),
    /// Linear interpolation in a table.
    Tabulated(Table),
    /// A dispersion formula.
    Formula(Formula),
}

impl Spectrum {
    /// Value at the vacuum wavelength `nm`.
    ///
    /// # Errors
    /// [`SpectrumError::OutOfRange`] outside the range of a table or formula (a table may clamp
    /// instead), [`SpectrumError::NotReal`] where a formula has no real value.
    pub fn at(&self, nm: f64) -> Result<f64, SpectrumError> {
        match self {
            Spectrum::Constant(value) => Ok(*value),
            Spectrum::Tabulated(table) => table.at(nm),
            Spectrum::Formula(formula) => formula.at(nm),
        }
    }

    /// Vacuum wavelengths (nm) between which the spectrum is known; None: everywhere.
    pub fn range(&self) -> Option<(f64, f64)> {
        match self {
            Spectrum::Constant(_) => None,
            Spectrum::Tabulated(table) => Some(table.range()),
            Spectrum::Formula(formula) => Some(formula.range()),
        }
    }

    /// True where the value cannot depend on wavelength: a constant, or a clamped table of equal values.
    pub fn is_constant(&self) -> bool {
        match self {
            Spectrum::Constant(_) => true,
            Spectrum::Tabulated(table) => table.is_constant(),
            Spectrum::Formula(_) => false,
        }
    }

    /// The same spectrum with another rule beyond its ends; constants and formulas stay as they are
    /// (a formula beyond its range is no measurement).
    pub fn extrapolated(self, rule: Extrapolate) -> Self {
        match self {
            Spectrum::Tabulated(table) => Spectrum::Tabulated(table.extrapolated(rule)),
            other => other,
        }
    }
}

impl From<Table> for Spectrum {
    fn from(table: Table) -> Self {
        Spectrum::Tabulated(table)
    }
}

impl From<Formula> for Spectrum {
    fn from(formula: Formula) -> Self {
        Spectrum::Formula(formula)
    }
}

/// What can be wrong with a spectrum or the file that holds it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SpectrumError {
    /// The wavelength asked for lies outside the spectrum.
    #[error("{name}: no value at {nm} nm, known from {low} nm to {high} nm")]
    OutOfRange {
        /// The spectrum.
        name: String,
        /// Wavelength asked for, nm.
        nm: f64,
        /// First wavelength, nm.
        low: f64,
        /// Last wavelength, nm.
        high: f64,
    },
    /// A formula has no real value at a wavelength (a negative square, a pole).
    #[error("{name}: the dispersion formula has no real value at {nm} nm")]
    NotReal {
        /// The spectrum.
        name: String,
        /// Wavelength, nm.
        nm: f64,
    },
    /// A place in a text does not hold what it should.
    #[error("{name}:{line}:{column}: {what}")]
    Text {
        /// The file or table.
        name: String,
        /// Line, from 1.
        line: usize,
        /// Character in the line, from 1.
        column: usize,
        /// What is wrong there.
        what: String,
    },
    /// Values that make no spectrum, without a place in a text.
    #[error("{name}: {what}")]
    Invalid {
        /// The spectrum.
        name: String,
        /// What is wrong.
        what: String,
    },
}

impl SpectrumError {
    pub(crate) fn text(name: &str, line: usize, column: usize, what: impl Into<String>) -> Self {
        SpectrumError::Text { name: name.to_owned(), line, column, what: what.into() }
    }

    pub(crate) fn invalid(name: &str, what: impl Into<String>) -> Self {
        SpectrumError::Invalid { name: name.to_owned(), what: what.into() }
    }
}

/// `nm` moved onto the range [low, high] where it lies outside by rounding only (parts in 10¹²: a file's
/// range in µm and a scene's wavelength in nm are both rounded), else None.
fn inside((low, high): (f64, f64), nm: f64) -> Option<f64> {
    let slack = 1e-12;
    (nm >= low * (1.0 - slack) && nm <= high * (1.0 + slack)).then(|| nm.clamp(low, high))
}
