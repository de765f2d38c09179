//! Kubelka–Munk theory of a sheet, and its inversion as in ISO 9416.
//!
//! Two opposite diffuse fluxes i (down) and j (up): di/dw = −(s + k) i + s j, dj/dw = (s + k) j − s i,
//! with grammage w in kg/m², scattering coefficient s and absorption coefficient k in m²/kg
//! (P. Kubelka, J. Opt. Soc. Am. 38 (1948) 448, doi:10.1364/JOSA.38.000448).
//!
//! The textbook forms with a = 1 + k/s, b = √(a² − 1), coth and sinh lose digits or overflow for
//! k → 0, s → 0 and large bsw. Here γ = bs = √(k (k + 2s)), E = exp(−γw),
//! S = (1 − E²)/2γ, C = (1 + E²)/2 and D = (s + k) S + C, of which every term is positive:
//! no limit needs a case of its own but γw = 0, where S = w.

use super::reflectance::NotAvailable;
use crate::math::{exp, expm1, ln_1p};

/// What Kubelka–Munk theory says of one sheet; all values are shares of the diffuse light upon it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Reflectance over black, R0 = s S/D.
    pub r0: f64,
    /// Transmittance, T = E/D.
    pub t: f64,
    /// Absorptance over black, 1 − R0 − T, without cancellation.
    pub absorbed: f64,
    /// Reflectivity of an opaque pile of such sheets, R∞ = s/(s + k + γ); 0 if s = 0.
    pub r_inf: f64,
    /// Opacity R0/R∞ = 1 − E²/D (ISO 2471); None if R∞ = 0.
    pub opacity: Option<f64>,
    /// 1 − R0, without cancellation.
    not_reflected: f64,
}

impl Layer {
    /// Layer of scattering coefficient `s` and absorption coefficient `k` (m²/kg) and grammage `w`
    /// (kg/m²). All are finite and not negative; a negative or non-finite input gives an error.
    pub fn new(s: f64, k: f64, w: f64) -> Result<Layer, NotAvailable> {
        if ![s, k, w].iter().all(|x| x.is_finite() && *x >= 0.0) {
            return Err(NotAvailable::needs("s, k and grammage that are finite and not negative"));
        }
        let gamma = k.sqrt() * (k + 2.0 * s).sqrt();
        let x = gamma * w;
        let e = exp(-x);
        let sinh = if x > 0.0 { -expm1(-2.0 * x) / (2.0 * gamma) } else { w };
        let cosh = 0.5 * (1.0 + e * e);
        let d = (s + k) * sinh + cosh;
        let lost = -expm1(-x);
        Ok(Layer {
            r0: s * sinh / d,
            t: e / d,
            absorbed: (k * sinh + 0.5 * lost * lost) / d,
            r_inf: if s > 0.0 { s / (s + k + gamma) } else { 0.0 },
            opacity: (s > 0.0).then(|| (s + k + gamma) * sinh / d),
            not_reflected: (k * sinh + cosh) / d,
        })
    }

    /// Reflectance over a backing of reflectance `rg`: R = R0 + T² Rg/(1 − R0 Rg).
    pub fn over(&self, rg: f64) -> f64 {
        // 1 − R0 Rg as a sum of two positive terms.
        let open = self.not_reflected + (1.0 - rg) * self.r0;
        self.r0 + self.t * self.t * rg / open
    }
}

/// Scattering and absorption coefficient of a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Scattering coefficient s in m²/kg.
    pub s: f64,
    /// Absorption coefficient k in m²/kg.
    pub k: f64,
}

/// Opacity above which s and k from R0 and R∞ are ill-conditioned: they follow the difference
/// R∞ − R0, which is then less than a twentieth of R∞, so that its relative error is more than
/// twenty times that of the reflectances.
pub const ILL_CONDITIONED_OPACITY: f64 = 0.95;

impl Coefficients {
    /// s and k from the reflectance factor over black `r0`, of an opaque pad `r_inf`, and the
    /// grammage `w` in kg/m² (ISO 9416):
    /// s = ln[R∞ (1 − R0 R∞)/(R∞ − R0)] / [w (1/R∞ − R∞)], k = s (1 − R∞)²/2R∞.
    ///
    /// Needs 0 ≤ R0 < R∞ and R0 R∞ < 1. R∞ = 1 gives the limit s = R0/[w (1 − R0)], k = 0; the
    /// formula holds smoothly on to the R∞ just above 1 that noise leaves for a white sheet. As
    /// R0 → R∞ the errors of s and k grow as 1/(R∞ − R0): see [`ILL_CONDITIONED_OPACITY`].
    pub fn from_r0_r_inf(r0: f64, r_inf: f64, w: f64) -> Result<Self, NotAvailable> {
        grammage(w)?;
        if !(r0 >= 0.0 && r0 < r_inf && r0 * r_inf < 1.0) {
            return Err(NotAvailable::needs("0 ≤ R0 < R∞ and R0 R∞ < 1"));
        }
        // The logarithm is ln(1 + z) with z = R0 (1 − R∞²)/(R∞ − R0): no case for R∞ → 1.
        let between = r_inf - r0;
        let z = r0 * (1.0 - r_inf) * (1.0 + r_inf) / between;
        let s = r_inf * r0 / (w * between) * per_argument(ln_1p(z), z);
        Ok(Coefficients { s, k: s * (1.0 - r_inf) * (1.0 - r_inf) / (2.0 * r_inf) })
    }

    /// s and k from reflectance over black `r0` and transmittance `t` of one sheet of grammage `w`
    /// (kg/m²): a = 1 + (1 − R0 − T)(1 − R0 + T)/2R0, s = arsinh(b R0/T)/(w b), k = (a − 1) s.
    ///
    /// Well-conditioned for any opacity, and the only way when no pad was simulated; an R∞ that is
    /// derived from it is a Kubelka–Munk extrapolation and must be labelled as such. Needs R0 > 0,
    /// T > 0 and R0 + T ≤ 1 (a sum above 1 by less than 1e-9, as rounding leaves it for a white
    /// sheet, counts as 1).
    pub fn from_r0_t(r0: f64, t: f64, w: f64) -> Result<Self, NotAvailable> {
        grammage(w)?;
        if !(r0 > 0.0 && t > 0.0 && r0 + t <= 1.0 + 1e-9) {
            return Err(NotAvailable::needs("R0 > 0, T > 0 and R0 + T ≤ 1"));
        }
        let a_minus_1 = (1.0 - r0 - t).max(0.0) * (1.0 - r0 + t) / (2.0 * r0);
        let b = (a_minus_1 * (a_minus_1 + 2.0)).sqrt();
        let y = b * r0 / t;
        let arsinh = ln_1p(y + y * y / (1.0 + (1.0 + y * y).sqrt()));
        let s = r0 / (t * w) * per_argument(arsinh, y);
        Ok(Coefficients { s, k: a_minus_1 * s })
    }

    /// Reflectivity of an opaque pile by Kubelka–Munk theory, R∞ = s/(s + k + √(k (k + 2s))).
    pub fn r_infinity(self) -> f64 {
        let gamma = self.k.sqrt() * (self.k + 2.0 * self.s).sqrt();
        if self.s > 0.0 { self.s / (self.s + self.k + gamma) } else { 0.0 }
    }
}

/// f(x)/x for an odd-like f with f(x) → x.
fn per_argument(f: f64, x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { f / x }
}

fn grammage(w: f64) -> Result<(), NotAvailable> {
    if w > 0.0 && w.is_finite() { Ok(()) } else { Err(NotAvailable::needs("a positive grammage")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_inversions_return_what_made_the_layer() {
        for (s, k, w) in [(35.0, 0.2, 0.08), (20.0, 1e-9, 0.04), (50.0, 20.0, 0.01), (1.0, 0.0, 1e-3)] {
            let layer = Layer::new(s, k, w).unwrap();
            let pad = Coefficients::from_r0_r_inf(layer.r0, layer.r_inf, w).unwrap();
            let sheet = Coefficients::from_r0_t(layer.r0, layer.t, w).unwrap();
            assert!((pad.s / s - 1.0).abs() < 1e-11, "{pad:?}");
            assert!((pad.k - k).abs() < 1e-11 * s, "{pad:?}");
            assert!((sheet.s / s - 1.0).abs() < 1e-11, "{sheet:?}");
            assert!((sheet.k - k).abs() < 1e-11 * s, "{sheet:?}");
            assert!((pad.r_infinity() - layer.r_inf).abs() < 1e-6);
        }
    }

    /// Two sheets of half the grammage, one upon the other, are the whole sheet.
    #[test]
    fn half_sheets_add_up() {
        for (s, k, w) in [(35.0, 0.2, 0.08), (20.0, 0.0, 1.0), (0.0, 2.0, 0.3), (65.0, 20.0, 1.0)] {
            let whole = Layer::new(s, k, w).unwrap();
            let half = Layer::new(s, k, 0.5 * w).unwrap();
            assert!((half.over(half.r0) - whole.r0).abs() < 1e-15);
            assert!((whole.r0 + whole.t + whole.absorbed - 1.0).abs() < 4e-16);
        }
    }

    #[test]
    fn impossible_inputs_are_refused() {
        assert!(Layer::new(-1.0, 0.0, 0.1).is_err());
        assert!(Layer::new(1.0, f64::NAN, 0.1).is_err());
        assert!(Coefficients::from_r0_r_inf(0.8, 0.8, 0.08).is_err());
        assert!(Coefficients::from_r0_r_inf(0.9, 1.2, 0.08).is_err());
        assert!(Coefficients::from_r0_r_inf(0.7, 0.8, 0.0).is_err());
        assert!(Coefficients::from_r0_t(0.6, 0.41, 0.08).is_err());
    }
}
