//! Spectra.
/// A quantity over vacuum wavelength.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same at every wavelength.
    Constant(f64),
}
