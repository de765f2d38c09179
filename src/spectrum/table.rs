//! A tabulated spectrum.

use super::{SpectrumError, inside};
use std::sync::Arc;

/// What a table answers beyond its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Extrapolate {
    /// An error that names the table and its range.
    #[default]
    Refuse,
    /// The value at the nearer end.
    Clamp,
}

/// Values at ascending vacuum wavelengths (nm), linear in between. Shared: a clone costs nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    name: Arc<str>,
    nm: Arc<[f64]>,
    values: Arc<[f64]>,
    extrapolate: Extrapolate,
}

impl Table {
    /// Table of `values` at the vacuum wavelengths `nm`; `name` stands in messages. Refuses to
    /// extrapolate; see [`Table::extrapolated`].
    ///
    /// # Errors
    /// [`SpectrumError::Invalid`] if it is empty, the lengths differ, the wavelengths are not
    /// positive and strictly ascending, or anything is not finite.
    pub fn new(
        name: &str,
        nm: impl Into<Arc<[f64]>>,
        values: impl Into<Arc<[f64]>>,
    ) -> Result<Self, SpectrumError> {
        let (nm, values) = (nm.into(), values.into());
        let wrong = |what: String| Err(SpectrumError::invalid(name, what));
        if nm.is_empty() {
            return wrong("the table is empty".into());
        }
        if nm.len() != values.len() {
            return wrong(format!("{} wavelengths but {} values", nm.len(), values.len()));
        }
        if let Some(i) = (0..nm.len()).find(|&i| !(nm[i].is_finite() && nm[i] > 0.0 && values[i].is_finite()))
        {
            return wrong(format!("row {}: '{}, {}' is no wavelength and value", i + 1, nm[i], values[i]));
        }
        if let Some(i) = (1..nm.len()).find(|&i| nm[i] <= nm[i - 1]) {
            return wrong(format!("row {}: {} nm does not follow {} nm", i + 1, nm[i], nm[i - 1]));
        }
        Ok(Table { name: name.into(), nm, values, extrapolate: Extrapolate::Refuse })
    }

    /// The same table with another rule beyond its ends.
    pub fn extrapolated(mut self, rule: Extrapolate) -> Self {
        self.extrapolate = rule;
        self
    }

    /// Name, for messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Vacuum wavelengths of the nodes, nm, ascending.
    pub fn wavelengths(&self) -> &[f64] {
        &self.nm
    }

    /// Values at the nodes.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// First and last wavelength, nm.
    pub fn range(&self) -> (f64, f64) {
        (self.nm[0], self.nm[self.nm.len() - 1])
    }

    /// True where every wavelength gives the same value.
    pub fn is_constant(&self) -> bool {
        self.extrapolate == Extrapolate::Clamp && self.values.iter().all(|v| *v == self.values[0])
    }

    /// Value at `nm`: exact at the nodes, linear between them.
    ///
    /// # Errors
    /// [`SpectrumError::OutOfRange`] beyond the ends of a table that refuses to extrapolate.
    pub fn at(&self, nm: f64) -> Result<f64, SpectrumError> {
        let (low, high) = self.range();
        let x = match (inside((low, high), nm), self.extrapolate) {
            (Some(x), _) => x,
            (None, Extrapolate::Clamp) if !nm.is_nan() => nm.clamp(low, high),
            _ => return Err(SpectrumError::OutOfRange { name: self.name.to_string(), nm, low, high }),
        };
        // First node at or beyond x: x lies in (nm[i−1], nm[i]].
        let i = self.nm.partition_point(|w| *w < x);
        if self.nm[i] == x {
            return Ok(self.values[i]);
        }
        let t = (x - self.nm[i - 1]) / (self.nm[i] - self.nm[i - 1]);
        Ok((1.0 - t) * self.values[i - 1] + t * self.values[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_between_nodes_exact_at_nodes_refused_outside() {
        let t = Table::new("dye", [400.0, 500.0, 700.0], [1.0, 3.0, -1.0]).unwrap();
        assert_eq!(t.at(400.0).unwrap(), 1.0);
        assert_eq!(t.at(450.0).unwrap(), 2.0);
        assert_eq!(t.at(600.0).unwrap(), 1.0);
        assert_eq!(t.at(700.0).unwrap(), -1.0);
        let message = t.at(399.0).unwrap_err().to_string();
        assert_eq!(message, "dye: no value at 399 nm, known from 400 nm to 700 nm");
        assert!(t.at(f64::NAN).is_err());
        assert_eq!(t.at(400.0 * (1.0 - 1e-13)).unwrap(), 1.0);
        let clamped = t.extrapolated(Extrapolate::Clamp);
        assert_eq!((clamped.at(1.0).unwrap(), clamped.at(1e9).unwrap()), (1.0, -1.0));
        assert!(clamped.at(f64::NAN).is_err());
        assert!(!clamped.is_constant());
    }

    #[test]
    fn what_is_no_table_is_refused() {
        let new = |nm: &[f64], v: &[f64]| Table::new("t", nm, v);
        assert!(new(&[], &[]).is_err());
        assert!(new(&[1.0, 2.0], &[1.0]).is_err());
        assert!(new(&[1.0, 1.0], &[1.0, 2.0]).is_err());
        assert!(new(&[2.0, 1.0], &[1.0, 2.0]).is_err());
        assert!(new(&[0.0, 1.0], &[1.0, 2.0]).is_err());
        assert!(new(&[1.0, 2.0], &[1.0, f64::NAN]).is_err());
        assert!(new(&[1.0], &[1.0]).unwrap().extrapolated(Extrapolate::Clamp).is_constant());
    }
}
