//! Optical constants of a medium and what follows from them at a smooth interface.
//!
//! Time dependence exp(−iωt), complex index N = n + iκ with κ ≥ 0 (absorption); the paper mixes the
//! signs in its (3). Lengths in µm, vacuum wavelengths in nm.

pub mod conversion;
pub mod film;
pub mod fresnel;
pub mod reflection_table;

pub use conversion::Conversion;
pub use reflection_table::ReflectionTable;

use crate::math::PI;
use crate::spectrum::{Spectrum, SpectrumError, rii};
use num_complex::Complex64;

/// Complex refractive index over vacuum wavelength, N(λ) = n(λ) + iκ(λ).
#[derive(Clone, Debug, PartialEq)]
pub struct RefractiveIndex {
    /// Real part n.
    pub n: Spectrum,
    /// Imaginary part κ ≥ 0; None: no absorption in the file, κ = 0.
    pub k: Option<Spectrum>,
}

impl RefractiveIndex {
    /// Index `n` at every wavelength, no absorption.
    pub fn constant(n: f64) -> Self {
        RefractiveIndex { n: Spectrum::Constant(n), k: None }
    }

    /// Index of a file of refractiveindex.info ([`rii::read`]).
    ///
    /// # Errors
    /// As [`rii::read`].
    pub fn from_rii(text: &str, name: &str) -> Result<Self, SpectrumError> {
        rii::read(text, name).map(Self::from)
    }

    /// N = n + iκ at the vacuum wavelength `nm`.
    ///
    /// # Errors
    /// Outside the range of n or κ; [`SpectrumError::Invalid`] where n ≤ 0 or κ < 0, which is no
    /// passive medium.
    pub fn at(&self, nm: f64) -> Result<Complex64, SpectrumError> {
        let n = self.n.at(nm)?;
        let k = self.k.as_ref().map_or(Ok(0.0), |k| k.at(nm))?;
        if n > 0.0 && k >= 0.0 {
            return Ok(Complex64::new(n, k));
        }
        Err(SpectrumError::invalid(
            "refractive index",
            format!("n = {n}, κ = {k} at {nm} nm: a medium has n > 0 and κ ≥ 0"),
        ))
    }

    /// Vacuum wavelengths (nm) where both n and κ are known; None: everywhere.
    pub fn range(&self) -> Option<(f64, f64)> {
        match (self.n.range(), self.k.as_ref().and_then(Spectrum::range)) {
            (Some(a), Some(b)) => Some((a.0.max(b.0), a.1.min(b.1))),
            (a, b) => a.or(b),
        }
    }

    /// True where N cannot depend on wavelength.
    pub fn is_constant(&self) -> bool {
        self.n.is_constant() && self.k.as_ref().is_none_or(Spectrum::is_constant)
    }

    /// Absorption coefficient (1/µm) that belongs to κ at `nm`; see [`absorption_from_k`].
    ///
    /// # Errors
    /// As [`RefractiveIndex::at`].
    pub fn absorption(&self, nm: f64) -> Result<f64, SpectrumError> {
        Ok(absorption_from_k(self.at(nm)?.im, nm))
    }
}

impl From<(Spectrum, Option<Spectrum>)> for RefractiveIndex {
    /// The pair (n, κ), as [`rii::read`] gives it.
    fn from((n, k): (Spectrum, Option<Spectrum>)) -> Self {
        RefractiveIndex { n, k }
    }
}

/// Absorption coefficient α = 4πκ/λ₀ in 1/µm from the imaginary part κ of the index at the vacuum
/// wavelength `nm` (paper eq. 2: power falls as exp(−α s)).
pub fn absorption_from_k(k: f64, nm: f64) -> f64 {
    4.0 * PI * k / (nm * 1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::Table;

    #[test]
    fn absorption_of_copper_at_500_nm_is_one_over_15_5_nm() {
        // κ = 2.571 (Johnson & Christy, 500 nm): 1/α = 500/(4π 2.571) = 15.476 nm.
        assert!((1000.0 / absorption_from_k(2.571, 500.0) - 15.4761).abs() < 1e-3);
    }

    #[test]
    fn index_of_n_and_k_has_the_common_range() {
        let table = |nm: [f64; 2], v: f64| Spectrum::from(Table::new("t", nm, [v, v]).unwrap());
        let index = RefractiveIndex { n: table([400.0, 600.0], 1.5), k: Some(table([500.0, 700.0], 0.25)) };
        assert_eq!(index.at(550.0).unwrap(), Complex64::new(1.5, 0.25));
        assert_eq!(index.range(), Some((500.0, 600.0)));
        assert!(index.at(450.0).is_err() && index.at(650.0).is_err());
        assert!(!index.is_constant() && RefractiveIndex::constant(1.55).is_constant());
        assert_eq!(RefractiveIndex::constant(1.55).at(1.0).unwrap(), Complex64::new(1.55, 0.0));
        assert!(RefractiveIndex::constant(-1.0).at(500.0).is_err());
        assert!(
            RefractiveIndex { n: Spectrum::Constant(1.5), k: Some(Spectrum::Constant(-1e-9)) }
                .at(500.0)
                .is_err()
        );
    }
}
