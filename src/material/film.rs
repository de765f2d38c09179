//! Thin film between two media: interference by Airy's formula (Born & Wolf, Principles of Optics, 7th
//! ed., § 7.6; pearlescent pigments and coatings).
//!
//! With the normal wave numbers k_j = √(N_j² − N1² sin²θ) (Re ≥ 0, Im > 0 where Re = 0) in units of 2π/λ
//! and β = 2π d k_f/λ, for each state of polarisation
//!
//! r = (r1f + rf2 e^(2iβ))/(1 + r1f rf2 e^(2iβ)), t = t1f tf2 e^(iβ)/(1 + r1f rf2 e^(2iβ)),
//!
//! r⊥ = (k_i − k_j)/(k_i + k_j), r∥ = (N_j² k_i − N_i² k_j)/(N_j² k_i + N_i² k_j), signs as in
//! [`super::fresnel`]; t⊥ = 1 + r⊥, t∥ of the magnetic field 1 + r∥. Powers R = |r|², T⊥ = Re k2/Re k1 |t|²,
//! T∥ = Re(k2/N2²)/Re(k1/N1²) |t|²; what is missing to 1 is absorbed in the film.

use num_complex::Complex64;

/// Amplitudes and powers of a film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Airy {
    /// Amplitude r⊥.
    pub rs: Complex64,
    /// Amplitude r∥.
    pub rp: Complex64,
    /// Amplitude t⊥ of the electric field.
    pub ts: Complex64,
    /// Amplitude t∥ of the electric field.
    pub tp: Complex64,
    /// Power T⊥.
    pub transmittance_s: f64,
    /// Power T∥.
    pub transmittance_p: f64,
}

impl Airy {
    /// Film of index `film` and thickness `thickness` (in vacuum wavelengths) between `n1`, where light
    /// comes from at the cosine `cos_i`, and `n2`.
    pub fn new(n1: Complex64, film: Complex64, n2: Complex64, thickness: f64, cos_i: f64) -> Self {
        let along = n1 * n1 * ((1.0 - cos_i) * (1.0 + cos_i));
        let normal = |n: Complex64| {
            let k = (n * n - along).sqrt();
            if k.re < 0.0 || k.re == 0.0 && k.im < 0.0 { -k } else { k }
        };
        let (k1, kf, k2) = (n1 * cos_i, normal(film), normal(n2));
        let s = |a: Complex64, b: Complex64| {
            let sum = a + b;
            if sum == Complex64::ZERO { Complex64::ZERO } else { (a - b) / sum }
        };
        let p = |(na, ka): (Complex64, Complex64), (nb, kb): (Complex64, Complex64)| {
            s(nb * nb * ka, na * na * kb)
        };
        let half = expi(kf * (2.0 * crate::math::PI * thickness));
        let round = half * half;
        let whole = |first: Complex64, second: Complex64| {
            let bottom = 1.0 + first * second * round;
            ((first + second * round) / bottom, (1.0 + first) * (1.0 + second) * half / bottom)
        };
        let (rs, ts) = whole(s(k1, kf), s(kf, k2));
        let (rp, tp_magnetic) = whole(p((n1, k1), (film, kf)), p((film, kf), (n2, k2)));
        let tp = tp_magnetic * n1 / n2;
        let flux_s = if k1.re > 0.0 { k2.re / k1.re } else { 0.0 };
        let (a, b) = ((k1 / (n1 * n1)).re, (k2 / (n2 * n2)).re);
        let flux_p = if a > 0.0 { b / a } else { 0.0 };
        Airy {
            rs,
            rp,
            ts,
            tp,
            transmittance_s: flux_s * ts.norm_sqr(),
            transmittance_p: flux_p * tp_magnetic.norm_sqr(),
        }
    }

    /// Power reflectance of unpolarised light.
    pub fn reflectance(&self) -> f64 {
        0.5 * (self.rs.norm_sqr() + self.rp.norm_sqr())
    }

    /// Power transmittance of unpolarised light.
    pub fn transmittance(&self) -> f64 {
        0.5 * (self.transmittance_s + self.transmittance_p)
    }
}

/// e^(iz).
fn expi(z: Complex64) -> Complex64 {
    let (sin, cos) = crate::math::sin_cos(z.re);
    Complex64::new(cos, sin) * crate::math::exp(-z.im)
}

#[cfg(test)]
mod tests {
    use super::super::fresnel::Fresnel;
    use super::*;

    fn real(n: f64) -> Complex64 {
        Complex64::new(n, 0.0)
    }

    /// Without thickness the film is not there, whatever its index; nor if it is one of the media.
    #[test]
    fn no_film_is_fresnel() {
        for (n1, n2) in
            [(real(1.0), real(1.5)), (real(1.5), real(1.0)), (real(1.0), Complex64::new(0.9, 2.6))]
        {
            for i in 0..=20 {
                let c = 0.02 + 0.98 * f64::from(i) / 20.0;
                let f = Fresnel::new(n1, n2, 1.0, c);
                for a in [Airy::new(n1, real(2.3), n2, 0.0, c), Airy::new(n1, n1, n2, 0.0, c)] {
                    assert!((a.rs - f.rs).norm() < 1e-13 && (a.rp - f.rp).norm() < 1e-13, "{a:?} {f:?}");
                    assert!((a.transmittance_s - f.transmittance_s).abs() < 1e-13);
                    assert!((a.transmittance_p - f.transmittance_p).abs() < 1e-13);
                }
            }
        }
    }

    /// A quarter wave of √(n1 n2) reflects nothing; half a wave is not there; Airy's real formula between.
    #[test]
    fn quarter_and_half_waves() {
        let (n1, n2) = (1.0, 1.52);
        let nf = 1.52_f64.sqrt();
        let at = |film: f64, d: f64| Airy::new(real(n1), real(film), real(n2), d, 1.0).reflectance();
        assert!(at(nf, 0.25 / nf) < 1e-30);
        let bare = ((n1 - n2) / (n1 + n2)).powi(2);
        assert!((at(2.3, 0.5 / 2.3) - bare).abs() < 1e-15);
        for k in 0..20 {
            let d = 0.05 * f64::from(k);
            let (a, b) = ((n1 - 2.3) / (n1 + 2.3), (2.3 - n2) / (2.3 + n2));
            let c = 2.0 * a * b * crate::math::cos(4.0 * crate::math::PI * 2.3 * d);
            let want = (a * a + b * b + c) / (1.0 + a * a * b * b + c);
            assert!((at(2.3, d) - want).abs() < 1e-14);
        }
    }

    /// Lossless films keep the power at every angle, total reflection and tunnelling included, and reflect
    /// the same from both sides.
    #[test]
    fn power_and_reciprocity() {
        for (n1, nf, n2, d) in [(1.0, 2.3, 1.5, 0.3), (1.5, 1.0, 1.5, 0.2), (1.5, 2.6, 1.0, 0.7)] {
            for i in 1..=50 {
                let c = f64::from(i) / 50.0;
                let a = Airy::new(real(n1), real(nf), real(n2), d, c);
                assert!(
                    (a.rs.norm_sqr() + a.transmittance_s - 1.0).abs() < 1e-12,
                    "{n1} {nf} {n2} {c}: {a:?}"
                );
                assert!((a.rp.norm_sqr() + a.transmittance_p - 1.0).abs() < 1e-12);
                let sin2 = n1 * n1 * (1.0 - c * c) / (n2 * n2);
                if sin2 < 1.0 {
                    let b = Airy::new(real(n2), real(nf), real(n1), d, (1.0 - sin2).sqrt());
                    assert!((a.reflectance() - b.reflectance()).abs() < 1e-12);
                }
            }
        }
        // An absorbing film takes its share.
        let a = Airy::new(real(1.0), Complex64::new(2.0, 0.3), real(1.5), 0.4, 0.8);
        assert!(a.reflectance() + a.transmittance() < 0.9);
    }
}
