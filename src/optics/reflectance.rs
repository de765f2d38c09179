//! A reflectance over wavelength, and the weights that turn it into a broad-band value.

use std::fmt;

/// Why a figure cannot be had from the data at hand. Displayed as "not available: needs …".
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not available: needs {needs}")]
pub struct NotAvailable {
    /// What the figure needs, as a phrase after "needs".
    pub needs: String,
}

impl NotAvailable {
    /// A figure that needs `what`.
    pub fn needs(what: impl fmt::Display) -> Self {
        NotAvailable { needs: what.to_string() }
    }
}

/// Widest step in nm between wavelengths for which colour is defined (CIE 15: 20 nm).
pub const WIDEST_STEP: f64 = 20.0;

/// Reflectance (or transmittance) factors at wavelengths in nm; 1 is the perfect diffuser.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralReflectance {
    wavelengths: Vec<f64>,
    values: Vec<f64>,
}

impl SpectralReflectance {
    /// Pairs wavelengths (nm, strictly increasing) with values (finite).
    pub fn new(wavelengths: Vec<f64>, values: Vec<f64>) -> Result<Self, NotAvailable> {
        if wavelengths.len() != values.len() || wavelengths.is_empty() {
            return Err(NotAvailable::needs("one value for each wavelength"));
        }
        if !values.iter().all(|v| v.is_finite()) {
            return Err(NotAvailable::needs("finite values at all wavelengths"));
        }
        increasing(&wavelengths)?;
        Ok(SpectralReflectance { wavelengths, values })
    }
    /// Wavelengths in nm.
    pub fn wavelengths(&self) -> &[f64] {
        &self.wavelengths
    }
    /// Values.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
    /// Value at `wavelength` nm by the rule of [`interpolation`].
    pub fn at(&self, wavelength: f64) -> f64 {
        interpolation(&self.wavelengths, wavelength).map(|(i, w)| w * self.values[i]).sum()
    }
}

fn increasing(wavelengths: &[f64]) -> Result<(), NotAvailable> {
    let rising = wavelengths.windows(2).all(|w| w[0] < w[1]);
    if rising && wavelengths.iter().all(|w| w.is_finite()) {
        Ok(())
    } else {
        Err(NotAvailable::needs("finite wavelengths in increasing order"))
    }
}

/// Checks that `wavelengths` reach from `from` to `to` nm in steps of at most [`WIDEST_STEP`].
pub fn covers(wavelengths: &[f64], from: f64, to: f64) -> Result<(), NotAvailable> {
    increasing(wavelengths)?;
    const ROUNDING: f64 = 1e-6;
    let inside = |w: &&[f64]| w[1] > from + ROUNDING && w[0] < to - ROUNDING;
    let reaches = wavelengths.first().is_some_and(|&w| w <= from + ROUNDING)
        && wavelengths.last().is_some_and(|&w| w >= to - ROUNDING);
    if !reaches {
        Err(NotAvailable::needs(format_args!("{from}–{to} nm")))
    } else if wavelengths.windows(2).filter(inside).any(|w| w[1] - w[0] > WIDEST_STEP + ROUNDING) {
        Err(NotAvailable::needs(format_args!("{from}–{to} nm in steps of at most {WIDEST_STEP} nm")))
    } else {
        Ok(())
    }
}

/// Interpolation at `wavelength` on the increasing grid `wavelengths`, as up to four pairs (index,
/// weight) whose weights add up to 1; linear in the values, as dot products and jackknives need.
///
/// Rule (that of ASTM E2022 and E308): the value itself on a grid point; between grid points the
/// cubic through the two neighbours on each side, the quadratic in the first and last interval;
/// beyond the ends the value at the end. Where neighbouring steps differ by more than a factor of
/// two, a straight line (a cubic would amplify noise).
pub fn interpolation(wavelengths: &[f64], wavelength: f64) -> impl Iterator<Item = (usize, f64)> {
    let n = wavelengths.len();
    let above = wavelengths.partition_point(|&g| g < wavelength);
    let (first, last) = if above == n {
        (n - 1, n - 1)
    } else if above == 0 || wavelengths[above] == wavelength {
        (above, above)
    } else {
        let (first, last) = (above.saturating_sub(2), (above + 1).min(n - 1));
        let step = wavelengths[above] - wavelengths[above - 1];
        let even = wavelengths[first..=last].windows(2).all(|w| {
            let ratio = (w[1] - w[0]) / step;
            (0.5..=2.0).contains(&ratio)
        });
        if even { (first, last) } else { (above - 1, above) }
    };
    let points: Vec<f64> = wavelengths[first..=last].to_vec();
    (0..points.len()).map(move |i| {
        let weight = (0..points.len())
            .filter(|&j| j != i)
            .map(|j| (wavelength - points[j]) / (points[i] - points[j]))
            .product::<f64>();
        (first + i, weight)
    })
}

/// Weights on `wavelengths` of the sum Σ wⱼ r(λⱼ) over `nodes` (λⱼ in nm, wⱼ): the broad-band value
/// is then the dot product of these weights with the values on the grid.
pub fn gathered(wavelengths: &[f64], nodes: impl Iterator<Item = (f64, f64)>) -> Vec<f64> {
    let mut weights = vec![0.0; wavelengths.len()];
    for (wavelength, weight) in nodes {
        for (i, share) in interpolation(wavelengths, wavelength) {
            weights[i] += weight * share;
        }
    }
    weights
}

/// Σ wᵢ vᵢ.
pub fn dot(weights: &[f64], values: &[f64]) -> f64 {
    debug_assert_eq!(weights.len(), values.len());
    weights.iter().zip(values).map(|(w, v)| w * v).collect::<crate::math::Sum>().value()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolation_is_exact_for_cubics_and_keeps_the_ends() {
        let grid: Vec<f64> = (0..16).map(|i| 400.0 + 20.0 * i as f64).collect();
        let cubic = |x: f64| {
            let t = (x - 550.0) / 100.0;
            0.3 + t * (0.2 + t * (0.1 - 0.05 * t))
        };
        let r = SpectralReflectance::new(grid.clone(), grid.iter().map(|&w| cubic(w)).collect()).unwrap();
        for x in [421.0, 555.5, 660.0, 678.9] {
            assert!((r.at(x) - cubic(x)).abs() < 1e-14);
        }
        assert!((r.at(410.0) - cubic(410.0)).abs() > 1e-5, "the first interval is a quadratic");
        assert!((r.at(410.0) - cubic(410.0)).abs() < 1e-3);
        assert_eq!(r.at(300.0), r.values()[0]);
        assert_eq!(r.at(800.0), r.values()[15]);
    }

    #[test]
    fn uneven_steps_are_joined_by_straight_lines() {
        let r = SpectralReflectance::new(vec![400.0, 401.0, 421.0, 422.0], vec![0.0, 1.0, 0.0, 5.0]).unwrap();
        assert_eq!(r.at(411.0), 0.5);
    }

    #[test]
    fn reasons_name_the_range() {
        let grid: Vec<f64> = (0..29).map(|i| 400.0 + 10.0 * i as f64).collect();
        assert_eq!(covers(&grid, 400.0, 700.0).unwrap_err().to_string(), "not available: needs 400–700 nm");
        assert!(covers(&grid, 400.0, 510.0).is_ok());
        let coarse = covers(&[400.0, 450.0, 700.0], 400.0, 700.0).unwrap_err().to_string();
        assert_eq!(coarse, "not available: needs 400–700 nm in steps of at most 20 nm");
        assert!(SpectralReflectance::new(vec![500.0, 400.0], vec![1.0, 1.0]).is_err());
        assert!(SpectralReflectance::new(vec![500.0], vec![f64::NAN]).is_err());
    }
}
