//! Mie scattering: a homogeneous sphere in a plane wave, exactly.
//!
//! Size parameter x = π d n/λ0 (d diameter, n index of the medium), relative index m = N_particle/n,
//! time dependence exp(−iωt), so Im m ≥ 0 absorbs. Notation of Bohren & Huffman, *Absorption and
//! Scattering of Light by Small Particles* (Wiley 1983, doi:10.1002/9783527618156), chapter 4.
//!
//! Range: 1e-30 ≤ x ≤ 1e5, Re m > 0, Im m ≥ 0. Accuracy, held against multi-precision tables for
//! 0.001 ≤ x ≤ 5000: 1e-9 relative for the efficiencies and for g.
//!
//! With ρₙ(z) = ψₙ(z)/ψₙ₋₁(z) and the logarithmic derivative Dₙ(z) = (n+1)/z − ρₙ₊₁(z) the coefficients
//! read aₙ = A(ψ)/A(ψ − iχ), bₙ = B(ψ)/B(ψ − iχ),
//!
//! A(f) = fₙ₊₁ + [(n+1)(1 − m²)/(m²x) − ρₙ₊₁(mx)/m] fₙ, B(f) = fₙ₊₁ − m ρₙ₊₁(mx) fₙ,
//!
//! algebraically the usual forms, but the terms of order 1/x that cancel for small x are already
//! cancelled by hand: no separate small-particle series is needed.

mod suspension;

pub use suspension::{Suspension, suspension, suspension_absorption};

use crate::math::{PI, cos, sin};
use num_complex::Complex64;

/// Efficiencies (cross section / π r²) and asymmetry of a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Efficiencies {
    /// Extinction: scattering + absorption.
    pub q_ext: f64,
    /// Scattering.
    pub q_sca: f64,
    /// Absorption, without cancellation for weakly absorbing spheres; exactly 0 where Im m = 0.
    pub q_abs: f64,
    /// Backscattering, 4π (dC/dω at 180°)/(π r²): the radar convention.
    pub q_back: f64,
    /// Mean cosine of the scattering angle.
    pub g: f64,
}

/// Scattering matrix at one angle, unpolarised incident light normalised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix {
    /// Phase function, per steradian: S11/(π x² Q_sca), ∫ p11 dω = 1.
    pub p11: f64,
    /// S12/S11 = (|S2|² − |S1|²)/(|S2|² + |S1|²); −S12/S11 is the degree of linear polarisation.
    pub s12: f64,
    /// S33/S11 = 2 Re(S1 S2*)/(|S2|² + |S1|²).
    pub s33: f64,
    /// S34/S11 = 2 Im(S2 S1*)/(|S2|² + |S1|²).
    pub s34: f64,
}

/// The expansion coefficients of one sphere, from which everything else follows.
#[derive(Clone, Debug)]
pub struct Coefficients {
    x: f64,
    a: Vec<Complex64>,
    b: Vec<Complex64>,
    /// Σ (2n+1)(Re aₙ − |aₙ|² + Re bₙ − |bₙ|²): the absorbed share of the sums.
    absorbed: f64,
}

/// ρₙ(z) for n = 0 ..= top (entry 0 unused), by downward recurrence ρₙ = 1/((2n+1)/z − ρₙ₊₁) from far
/// above both the last order and |z|: stable for every complex z.
fn ratios(z: Complex64, top: usize) -> Vec<Complex64> {
    let start = (1.1 * z.norm().max(top as f64)) as usize + 60;
    let inverse = z.inv();
    let mut rho = vec![Complex64::ZERO; top + 1];
    let mut r = z / (2 * start + 3) as f64;
    for n in (1..=start).rev() {
        let mut below = inverse * (2 * n + 1) as f64 - r;
        // ψₙ₋₁ vanishes exactly: a zero moved by far less than rounding (Lentz 1976).
        if below == Complex64::ZERO {
            below = Complex64::new(1e-30, 0.0);
        }
        r = below.inv();
        if n <= top {
            rho[n] = r;
        }
    }
    rho
}

/// Riccati–Bessel functions ψₙ = x jₙ and χₙ = −x yₙ for n = 0 ..= top. χ and, up to n = x, ψ go
/// upward; beyond, where ψ decays and upward would blow up, ψₙ = ρₙ ψₙ₋₁.
fn riccati_bessel(x: f64, top: usize) -> (Vec<f64>, Vec<f64>) {
    let rho = ratios(Complex64::new(x, 0.0), top);
    let (s, c) = (sin(x), cos(x));
    let mut psi = vec![s; top + 1];
    let mut chi = vec![c; top + 1];
    for n in 1..=top {
        let k = (2 * n - 1) as f64 / x;
        let (psi_2, chi_2) = if n == 1 { (c, -s) } else { (psi[n - 2], chi[n - 2]) };
        chi[n] = k * chi[n - 1] - chi_2;
        psi[n] = if (n as f64) < x { k * psi[n - 1] - psi_2 } else { rho[n].re * psi[n - 1] };
    }
    (psi, chi)
}

/// Number of orders: beyond x + 4.05 x^{1/3} + 2 (Wiscombe, Appl. Opt. 19, 1505 (1980),
/// doi:10.1364/AO.19.001505) the terms fall faster than geometrically; eight more leave nothing. For
/// very small x four orders hold x⁸ relative to the first.
fn orders(x: f64) -> usize {
    if x < 0.02 { 4 } else { (x + 4.05 * crate::math::cbrt(x)) as usize + 10 }
}

impl Coefficients {
    /// For relative index `m` (Im m ≥ 0) and size parameter `x`.
    pub fn new(m: Complex64, x: f64) -> Self {
        let top = orders(x);
        let (psi, chi) = riccati_bessel(x, top + 1);
        let rho = ratios(m * x, top + 1);
        let inverse = m.inv();
        let contrast = (1.0 - m) * (1.0 + m) * inverse * inverse / x;
        let mut sphere =
            Coefficients { x, a: Vec::with_capacity(top), b: Vec::with_capacity(top), absorbed: 0.0 };
        for n in 1..=top {
            let order = (n + 1) as f64;
            let electric = contrast * order - rho[n + 1] * inverse;
            let magnetic = -m * rho[n + 1];
            // −Im(Dₙ/m) and −Im(m Dₙ); the Wronskian ψₙχₙ₊₁ − ψₙ₊₁χₙ = 1 gives Re aₙ − |aₙ|² from them.
            let loss_a = -(electric.im);
            let loss_b = -(magnetic.im);
            for (alpha, loss, out) in [(electric, loss_a, &mut sphere.a), (magnetic, loss_b, &mut sphere.b)] {
                let top = psi[n + 1] + alpha * psi[n];
                let bottom = top - Complex64::i() * (chi[n + 1] + alpha * chi[n]);
                out.push(top / bottom);
                sphere.absorbed += (2 * n + 1) as f64 * loss / bottom.norm_sqr();
            }
        }
        sphere
    }

    /// Efficiencies and asymmetry:
    /// Q_sca = (2/x²) Σ (2n+1)(|aₙ|² + |bₙ|²), Q_abs from Re aₙ − |aₙ|² = −Im(Dₙ(mx)/m)/|denominator|²,
    /// Q_ext their sum, g by Bohren & Huffman section 4.5.
    pub fn efficiencies(&self) -> Efficiencies {
        let (mut sca, mut turn, mut back) = (0.0, 0.0, Complex64::ZERO);
        for (i, (a, b)) in self.a.iter().zip(&self.b).enumerate() {
            let n = (i + 1) as f64;
            let k = 2.0 * n + 1.0;
            sca += k * (a.norm_sqr() + b.norm_sqr());
            back += (a - b) * if i % 2 == 0 { -k } else { k };
            turn += k / (n * (n + 1.0)) * (a * b.conj()).re;
            if let (Some(a1), Some(b1)) = (self.a.get(i + 1), self.b.get(i + 1)) {
                turn += n * (n + 2.0) / (n + 1.0) * (a * a1.conj() + b * b1.conj()).re;
            }
        }
        let x2 = self.x * self.x;
        let (q_sca, q_abs) = (2.0 * sca / x2, 2.0 * self.absorbed / x2);
        let g = if sca > 0.0 { 2.0 * turn / sca } else { 0.0 };
        Efficiencies { q_ext: q_sca + q_abs, q_sca, q_abs, q_back: back.norm_sqr() / x2, g }
    }

    /// Amplitudes (S1, S2) at the angle with 1 − cos θ = `near` and 1 + cos θ = `far`:
    /// S1 = Σ (2n+1)/(n(n+1)) (aₙπₙ + bₙτₙ), S2 = Σ (2n+1)/(n(n+1)) (aₙτₙ + bₙπₙ).
    ///
    /// πₙ, τₙ run upward in the differences δₙ = πₙ − πₙ₋₁ and t = 1 − |cos θ|, from the nearer pole
    /// (π, τ are even or odd): recurrences in cos θ itself lose n² ulp near the poles.
    pub fn amplitudes(&self, near: f64, far: f64) -> (Complex64, Complex64) {
        let t = near.min(far);
        let backward = near > far;
        let (mut s1, mut s2) = (Complex64::ZERO, Complex64::ZERO);
        let (mut before, mut pi, mut delta) = (0.0, 1.0, 1.0);
        for (i, (a, b)) in self.a.iter().zip(&self.b).enumerate() {
            let n = (i + 1) as f64;
            let scale = (2.0 * n + 1.0) / (n * (n + 1.0));
            let tau = scale * (n * (delta - t * pi) - before);
            let (p, q) = match (backward, i % 2) {
                (true, 0) => (scale * pi, -tau),
                (true, _) => (-scale * pi, tau),
                _ => (scale * pi, tau),
            };
            s1 += a * p + b * q;
            s2 += a * q + b * p;
            delta = ((n + 1.0) * delta - (2.0 * n + 1.0) * t * pi) / n;
            before = pi;
            pi += delta;
        }
        (s1, s2)
    }

    /// Scattering matrix at a scattering angle in rad, 0 to π.
    pub fn matrix(&self, angle: f64) -> Matrix {
        let (s, c) = (sin(0.5 * angle), cos(0.5 * angle));
        let (s1, s2) = self.amplitudes(2.0 * s * s, 2.0 * c * c);
        let (i1, i2) = (s1.norm_sqr(), s2.norm_sqr());
        let s11 = 0.5 * (i1 + i2);
        let (re, im) = ((s1 * s2.conj()).re, (s2 * s1.conj()).im);
        Matrix {
            p11: s11 / (PI * self.x * self.x * self.efficiencies().q_sca),
            s12: 0.5 * (i2 - i1) / s11,
            s33: re / s11,
            s34: im / s11,
        }
    }
}

/// Efficiencies of a sphere of relative index `m` = n + iκ and size parameter `x`.
pub fn efficiencies(m: Complex64, x: f64) -> Efficiencies {
    Coefficients::new(m, x).efficiencies()
}

/// Amplitudes (S1, S2) at the cosines `cosines`.
pub fn amplitudes(m: Complex64, x: f64, cosines: &[f64]) -> Vec<(Complex64, Complex64)> {
    let sphere = Coefficients::new(m, x);
    cosines.iter().map(|c| sphere.amplitudes(1.0 - c, 1.0 + c)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rayleigh limit at the smallest x: Q_sca = (8/3) x⁴ |L|², Q_abs = 4x Im L, L = (m² − 1)/(m² + 2).
    #[test]
    fn the_smallest_spheres() {
        let m = Complex64::new(1.5, 1e-3);
        let l = (m * m - 1.0) / (m * m + 2.0);
        for x in [1e-30, 1e-20, 1e-8] {
            let q = efficiencies(m, x);
            let sca = 8.0 / 3.0 * x * x * x * x * l.norm_sqr();
            assert!((q.q_sca / sca - 1.0).abs() < 1e-12, "{q:?}");
            assert!((q.q_abs / (4.0 * x * l.im) - 1.0).abs() < 1e-12, "{q:?}");
            assert!((q.q_back / (1.5 * sca) - 1.0).abs() < 1e-12 && q.g >= 0.0 && q.g <= x * x, "{q:?}");
        }
    }

    /// The number of orders steps at x = 0.02: nothing else may.
    #[test]
    fn the_change_of_orders_is_invisible() {
        let m = Complex64::new(1.742, 0.0);
        let (below, above) = (efficiencies(m, 0.02 - 1e-13), efficiencies(m, 0.02));
        assert_eq!(below.q_abs, 0.0);
        assert!((below.q_sca / above.q_sca - 1.0).abs() < 1e-10 && (below.g / above.g - 1.0).abs() < 1e-10);
    }

    /// Weak absorption is proportional to κ down to κ = 1e-15, where Q_ext − Q_sca has no digit left.
    #[test]
    fn weak_absorption_is_linear() {
        let per = |kappa: f64| efficiencies(Complex64::new(1.5, kappa), 40.0).q_abs / kappa;
        assert!((per(1e-15) / per(1e-9) - 1.0).abs() < 1e-6, "{} {}", per(1e-15), per(1e-9));
    }

    /// Optical theorem: Q_ext = (4/x²) Re S(0), a sum independent of the ones in `efficiencies`.
    #[test]
    fn optical_theorem() {
        for (m, x) in [
            (Complex64::new(1.33, 0.0), 0.3),
            (Complex64::new(1.5, 0.1), 30.0),
            (Complex64::new(0.65, 2.0), 800.0),
        ] {
            let (s1, s2) = amplitudes(m, x, &[1.0])[0];
            let q = efficiencies(m, x).q_ext;
            assert!((4.0 * s1.re / (x * x) / q - 1.0).abs() < 1e-11 && s1 == s2, "{m} {x}");
        }
    }
}
