//! Fibrils: circular cylinders without end, their axes in all directions, in a medium.
//!
//! Scattering by one cylinder met at the angle ζ to its axis: C. F. Bohren & D. R. Huffman, Absorption and
//! Scattering of Light by Small Particles (1983), § 8.4. Scattered light leaves on the cone of half angle ζ about
//! the axis; at the angle Θ around it the deflection is sin(θ/2) = sin ζ sin(Θ/2).

use super::super::table::Knot;
use super::super::{Phase, PhaseError, Table, error};
use super::Suspension;
use crate::math::{PI, TAU, bessel_j0, bessel_j1, bessel_y0, bessel_y1, cos, gauss_legendre, sin};
use num_complex::Complex64;
use std::sync::Arc;

/// Directions of axes, ∫ d cos ζ.
const AXES: usize = 64;
/// Angles around the axis.
const AROUND: usize = 1024;
/// Steps of sin(θ/2) of the phase function.
const STEPS: usize = 512;
/// Largest size parameter.
const LARGEST: f64 = 200.0;

/// Coefficients of one cylinder at one ζ: b_n and a_n of case I (electric field in the plane of axis and light),
/// a_n and b_n of case II (across it). b_nII = −a_nI.
struct Oblique {
    b1: Vec<Complex64>,
    a1: Vec<Complex64>,
    a2: Vec<Complex64>,
}

/// J_0 … J_n of z by recurrence from far above, normalised by J_0 + 2 Σ J_2k = 1.
fn bessel_j(n: usize, z: Complex64) -> Vec<Complex64> {
    let far = (n as f64).max(z.norm());
    let start = (far + 20.0 + (60.0 * far).sqrt()) as usize | 1;
    let (mut above, mut here) = (Complex64::ZERO, Complex64::new(1e-30, 0.0));
    let (mut out, mut sum) = (vec![Complex64::ZERO; n + 1], Complex64::ZERO);
    for k in (0..start).rev() {
        // J_k = 2(k + 1)/z J_(k+1) − J_(k+2).
        let below = here * (2.0 * (k + 1) as f64) / z - above;
        (above, here) = (here, below);
        if k <= n {
            out[k] = here;
        }
        if k % 2 == 0 {
            sum += if k == 0 { here } else { 2.0 * here };
        }
        if here.norm() > 1e100 {
            let scale = 1e-100;
            (above, here, sum) = (above * scale, here * scale, sum * scale);
            out.iter_mut().for_each(|x| *x *= scale);
        }
    }
    out.iter_mut().for_each(|x| *x /= sum);
    out
}

/// H_0 … H_n (first kind) of a real argument.
fn hankel(n: usize, x: f64) -> Vec<Complex64> {
    let mut j: Vec<f64> = bessel_j(n.max(1), Complex64::new(x, 0.0)).iter().map(|j| j.re).collect();
    (j[0], j[1]) = (bessel_j0(x), bessel_j1(x));
    let mut y = vec![bessel_y0(x), bessel_y1(x)];
    for k in 2..=n {
        y.push(2.0 * (k - 1) as f64 / x * y[k - 1] - y[k - 2]);
    }
    (0..=n).map(|k| Complex64::new(j[k], y[k])).collect()
}

/// f'_n = f_(n−1) − n/z f_n.
fn slope(f: &[Complex64], n: usize, z: Complex64) -> Complex64 {
    if n == 0 { -f[1] } else { f[n - 1] - f[n] * n as f64 / z }
}

impl Oblique {
    /// Of relative index `m`, size parameter `x` = π d n_medium/λ0, cosine of the angle between light and axis.
    fn new(m: Complex64, x: f64, cos_zeta: f64) -> Self {
        let xi = x * (1.0 - cos_zeta * cos_zeta).sqrt();
        let eta = (m * m - cos_zeta * cos_zeta).sqrt() * x;
        let n = (x + 4.0 * crate::math::pow(x, 1.0 / 3.0) + 4.0) as usize;
        let (j, h) = (bessel_j(n, eta), hankel(n, xi));
        let outer: Vec<Complex64> = h.iter().map(|h| Complex64::new(h.re, 0.0)).collect();
        let (xi, i) = (Complex64::new(xi, 0.0), Complex64::I);
        let step = xi * xi / (eta * eta) - 1.0;
        let mut out = Oblique { b1: Vec::new(), a1: Vec::new(), a2: Vec::new() };
        for k in 0..=n {
            let (dj, dh, djx) = (slope(&j, k, eta), slope(&h, k, xi), slope(&outer, k, xi));
            let (jn, hn, jx) = (j[k], h[k], outer[k]);
            let twist = eta * jn * step * (k as f64 * cos_zeta);
            let (c, d) = (twist * jx, twist * hn);
            let a = i * xi * (xi * dj * jx - eta * jn * djx);
            let b = xi * (m * m * xi * dj * jx - eta * jn * djx);
            let v = xi * (m * m * xi * dj * hn - eta * jn * dh);
            let w = i * xi * (eta * jn * dh - xi * dj * hn);
            let under = w * v + i * d * d;
            // Terms so high that J has left the range of numbers scatter nothing.
            let term = |x: Complex64| if x.is_finite() { x } else { Complex64::ZERO };
            out.a1.push(term((c * v - b * d) / under));
            out.b1.push(term((w * b + i * d * c) / under));
            out.a2.push(term(-(a * v - i * c * d) / under));
        }
        out
    }

    /// Efficiencies of scattering and extinction, cases I and II.
    fn efficiencies(&self, x: f64) -> [[f64; 2]; 2] {
        let both = |zero: Complex64, own: &[Complex64]| {
            let tail = own.iter().zip(&self.a1).skip(1);
            let sca: f64 = tail.map(|(o, c)| o.norm_sqr() + c.norm_sqr()).sum();
            let ext: f64 = own.iter().skip(1).map(|o| o.re).sum();
            [2.0 / x * (zero.norm_sqr() + 2.0 * sca), 2.0 / x * (zero.re + 2.0 * ext)]
        };
        [both(self.b1[0], &self.b1), both(self.a2[0], &self.a2)]
    }

    /// ½ Σ |T|² at the angle Θ (cosine c, sine s): unpolarised light.
    fn intensity(&self, c: f64, s: f64) -> f64 {
        let (mut t1, mut t2, mut t3) = (self.b1[0], self.a2[0], Complex64::ZERO);
        let (mut ck, mut sk) = (c, s);
        for k in 1..self.b1.len() {
            t1 += self.b1[k] * (2.0 * ck);
            t2 += self.a2[k] * (2.0 * ck);
            t3 += self.a1[k] * (2.0 * sk);
            (ck, sk) = (ck * c - sk * s, sk * c + ck * s);
        }
        0.5 * (t1.norm_sqr() + t2.norm_sqr()) + t3.norm_sqr()
    }
}

/// Coefficients and phase function of fibrils with a law of diameters: axes isotropic, unpolarised light,
/// **independent scattering** as in [`super::suspension`], whose arguments these are; probabilities count length.
///
/// With n_L = φ/(Σ pᵢ π dᵢ²/4) the length over volume, µ = n_L Σ pᵢ dᵢ ∫₀¹ Q(ζ) d cos ζ. Near the forward direction
/// the phase function of cylinders without end goes as 1/θ; the table holds its mean over steps of 1/512 of
/// sin(θ/2).
///
/// # Errors
/// As [`super::suspension`], with a size parameter of at most 200.
pub fn fibrils(
    nodes: &[(f64, f64)],
    n_particle: Complex64,
    n_medium: f64,
    wavelength_nm: f64,
    volume_fraction: f64,
) -> Result<Suspension, PhaseError> {
    super::suspension::check(nodes, n_particle, n_medium, wavelength_nm, volume_fraction)?;
    let m = n_particle / n_medium;
    let wavenumber = TAU * n_medium / (wavelength_nm * 1e-3);
    let section: f64 = nodes.iter().map(|(d, p)| p * PI * d * d / 4.0).sum();
    if m == Complex64::ONE {
        return Ok(Suspension { mu_s: 0.0, mu_a: 0.0, g: 0.0, phase: Phase::Isotropic });
    }
    let turns: Vec<(f64, f64, f64)> = (0..AROUND)
        .map(|k| PI * (k as f64 + 0.5) / AROUND as f64)
        .map(|t| (cos(t), sin(t), sin(0.5 * t)))
        .collect();
    let (mut sca, mut abs) = (0.0, 0.0);
    let mut mass = vec![0.0; STEPS + 1];
    for &(d, p) in nodes.iter().filter(|n| n.1 > 0.0) {
        let x = 0.5 * d * wavenumber;
        error::range("size parameter of a fibril", x, x <= LARGEST, "at most 200")?;
        for (cos_zeta, weight) in gauss_legendre(AXES, 0.0, 1.0) {
            let one = Oblique::new(m, x, cos_zeta);
            let q = one.efficiencies(x);
            sca += p * d * weight * 0.5 * (q[0][0] + q[1][0]);
            abs += p * d * weight * 0.5 * (q[0][1] - q[0][0] + q[1][1] - q[1][0]);
            let sin_zeta = (1.0 - cos_zeta * cos_zeta).sqrt();
            // Q = 1/(πx) ∫ |T|² dΘ over the whole turn, here twice the half.
            let share = p * d * weight * 2.0 / (x * AROUND as f64);
            for &(c, s, half) in &turns {
                spread(&mut mass, sin_zeta * half, share * one.intensity(c, s));
            }
        }
    }
    let length = volume_fraction / section;
    let (mu_s, mu_a) = (length * sca, length * abs.max(0.0));
    if sca == 0.0 {
        return Ok(Suspension { mu_s, mu_a, g: 0.0, phase: Phase::Isotropic });
    }
    let table = table(&mass)?;
    let g = table.mean_cosine();
    Ok(Suspension { mu_s, mu_a, g, phase: Phase::Table(Arc::new(table)) })
}

/// Puts a mass at u = sin(θ/2) on the knots beside it, so that the mean of cos θ = 1 − 2u² stays.
fn spread(mass: &mut [f64], u: f64, w: f64) {
    let at = u * STEPS as f64;
    let i = (at as usize).min(STEPS - 1);
    let low = i as f64;
    let f = (at * at - low * low) / (2.0 * low + 1.0);
    mass[i] += w * (1.0 - f);
    mass[i + 1] += w * f;
}

/// Masses of knots as a density linear between them.
fn table(mass: &[f64]) -> Result<Table, PhaseError> {
    let u2 = |i: usize| (i as f64 / STEPS as f64).powi(2);
    let knot = |(i, w): (usize, &f64)| {
        let (a, b) = (u2(i.saturating_sub(1)), u2((i + 1).min(STEPS)));
        // ∫ of the knot's hat function over cos θ is b − a.
        Knot { near: 2.0 * u2(i), far: 2.0 * (1.0 - u2(i)), p: w / (TAU * (b - a)) }
    };
    Table::new(&mass.iter().enumerate().map(knot).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No absorption: what is taken out of the beam is scattered, in either polarisation at any angle.
    #[test]
    fn optical_theorem() {
        let mut worst = 0.0_f64;
        for m in [0.8, 1.1, 1.5, 2.5] {
            for x in [1e-3, 0.1, 1.0, 5.0, 30.0, 150.0] {
                for c in [0.0, 0.3, 0.7, 0.95, 0.999] {
                    if m < 1.0 && c >= m {
                        continue;
                    }
                    for [sca, ext] in Oblique::new(m.into(), x, c).efficiencies(x) {
                        let off = (sca - ext).abs() / ext;
                        assert!(off < 1e-9, "m {m} x {x} cos {c}: {sca} {ext}");
                        worst = worst.max(off);
                    }
                }
            }
        }
        println!("worst {worst:e}");
    }

    /// Thin cylinders at right angles (Bohren & Huffman, § 8.4.5): Q_I = π²x³/8 (m² − 1)², Q_II = π²x³/4
    /// ((m² − 1)/(m² + 1))²; thick ones take out twice what they cover, seen aslant.
    #[test]
    fn limits() {
        let (m, x) = (1.5_f64, 1e-3_f64);
        let [[one, _], [two, _]] = Oblique::new(m.into(), x, 0.0).efficiencies(x);
        let (m2, base) = (m * m, PI * PI * x * x * x);
        assert!((one / (base / 8.0 * (m2 - 1.0).powi(2)) - 1.0).abs() < 1e-4, "{one}");
        assert!((two / (base / 4.0 * ((m2 - 1.0) / (m2 + 1.0)).powi(2)) - 1.0).abs() < 1e-4, "{two}");
        let (x, absorbing) = (190.0, Complex64::new(1.5, 0.2));
        for c in [0.0, 0.5, 0.8] {
            let q = Oblique::new(absorbing, x, c).efficiencies(x);
            let want = 2.0 * (1.0_f64 - c * c).sqrt();
            for [_, ext] in q {
                assert!((ext / want - 1.0).abs() < 0.05, "cos {c}: {ext} for {want}");
            }
        }
    }

    /// The table holds all that is scattered, and the mean cosine: by the first Fourier terms of the intensity
    /// around the axis, ⟨cos θ⟩ = ⟨cos²ζ + sin²ζ cos Θ⟩, without the table's angles.
    #[test]
    fn tables_hold_the_sums() {
        for (d, n, kappa) in [(0.05, 1.55, 0.0), (0.3, 1.55, 0.0), (1.5, 1.55, 0.01)] {
            let s = fibrils(&[(d, 1.0)], Complex64::new(n, kappa), 1.33, 550.0, 0.02).unwrap();
            let Phase::Table(table) = &s.phase else { panic!("no table") };
            let x = PI * d * 1.33 / 0.55;
            let length = 0.02 / (PI * d * d / 4.0);
            // As written the masses are µs/n_L.
            let off = table.integral_as_written() * length / s.mu_s - 1.0;
            println!("d {d}: x {x:.2} mu_s {:.5} mu_a {:.5} g {:.5} off {off:.1e}", s.mu_s, s.mu_a, s.g);
            assert!(off.abs() < 1e-9 && (s.mu_a > 1e-9) == (kappa > 0.0), "{off}");
            let m = Complex64::new(n, kappa) / 1.33;
            let (mut all, mut forward) = (0.0, 0.0);
            for (c, w) in gauss_legendre(AXES, 0.0, 1.0) {
                let one = Oblique::new(m, x, c);
                // ∫ |T|² and ∫ |T|² cos Θ over the turn, of T = Σ t_k e^(ikΘ) with t_−k = ± t_k.
                let series = |t: &dyn Fn(i64) -> Complex64| {
                    let top = one.b1.len() as i64;
                    let sum = |step: i64| (-top..=top).map(|k| (t(k) * t(k + step).conj()).re).sum::<f64>();
                    (sum(0), sum(1))
                };
                let get =
                    |v: &[Complex64], k: i64| v.get(k.unsigned_abs() as usize).copied().unwrap_or_default();
                let parts = [
                    (0.5, series(&|k| get(&one.b1, k))),
                    (0.5, series(&|k| get(&one.a2, k))),
                    // 2 Σ a sin kΘ.
                    (1.0, series(&|k| get(&one.a1, k) * (k.signum() as f64))),
                ];
                for (share, (zero, first)) in parts {
                    all += w * share * zero;
                    forward += w * share * (c * c * zero + (1.0 - c * c) * first);
                }
            }
            assert!((s.g - forward / all).abs() < 1e-5, "g {} for {}", s.g, forward / all);
        }
        assert!(fibrils(&[(80.0, 1.0)], Complex64::new(1.55, 0.0), 1.0, 550.0, 0.02).is_err());
    }
}
