//! Spheres of many sizes in a medium: scattering and absorption coefficients and phase function.

use super::super::table::{Knot, width};
use super::super::{Phase, PhaseError, Table, error};
use super::Coefficients;
use crate::math::{PI, Sum, TAU};
use num_complex::Complex64;
use std::sync::Arc;

/// What a suspension of spheres does to light, per µm of path in the medium around them.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspension {
    /// Scattering coefficient, 1/µm.
    pub mu_s: f64,
    /// Absorption coefficient of the spheres, 1/µm (that of the medium comes on top).
    pub mu_a: f64,
    /// Mean cosine, weighted with the scattering cross sections, from the Mie sums.
    pub g: f64,
    /// Phase function; a table except where nothing scatters.
    pub phase: Phase,
}

/// Table against Mie sums: relative deviation of the normalisation, and of g (below |g| = 0.01:
/// 1e-6 absolute).
const CONVERGED: f64 = 1e-4;
/// Probability that may lie off the straight lines, summed without sign, when refinement ends (the last
/// pass quarters it): holds the shape, where the two sums above could agree by chance.
const AIM: f64 = 1e-4;
/// Knots beyond which refinement gives up.
const MOST_KNOTS: usize = 2_000_000;

/// Coefficients and phase function of spheres with a law of sizes.
///
/// `nodes`: (diameter in µm, number probability or any number proportional to it), for example the
/// quadrature nodes of a size law; `n_particle` = n + iκ; `n_medium` real; vacuum wavelength in nm;
/// `volume_fraction` of the spheres φ. With x = π d n_medium/λ0, m = n_particle/n_medium:
///
/// µ = N_V Σ pᵢ Qᵢ π dᵢ²/4, N_V = φ/(Σ pᵢ π dᵢ³/6), p(θ) = Σ pᵢ dCᵢ/dω / Σ pᵢ Cᵢ.
///
/// **Independent scattering** is assumed: every sphere sees the undisturbed wave and intensities add.
/// It holds for dilute suspensions (φ below some 5 %, gaps of several wavelengths); at higher packing
/// dependent scattering lowers µs of small particles, which this function does not model.
///
/// The angular grid starts with some four knots per diffraction lobe of the largest sphere and is
/// halved where a straight line in cos θ misses, until table and Mie sums agree to 1e-4 in
/// normalisation and in g (1e-6 absolute where |g| < 0.01).
///
/// Refuses empty or negative nodes, a fraction outside [0, 1], Re N ≤ 0, κ < 0, x outside 1e-30…1e5,
/// and a grid that does not converge.
pub fn suspension(
    nodes: &[(f64, f64)],
    n_particle: Complex64,
    n_medium: f64,
    wavelength_nm: f64,
    volume_fraction: f64,
) -> Result<Suspension, PhaseError> {
    suspended(nodes, n_particle, n_medium, wavelength_nm, volume_fraction, true)
}

/// Absorption coefficient of the spheres of [`suspension`], 1/µm, without the work for its phase function.
///
/// # Errors
/// As [`suspension`].
pub fn suspension_absorption(
    nodes: &[(f64, f64)],
    n_particle: Complex64,
    n_medium: f64,
    wavelength_nm: f64,
    volume_fraction: f64,
) -> Result<f64, PhaseError> {
    suspended(nodes, n_particle, n_medium, wavelength_nm, volume_fraction, false).map(|s| s.mu_a)
}

fn suspended(
    nodes: &[(f64, f64)],
    n_particle: Complex64,
    n_medium: f64,
    wavelength_nm: f64,
    volume_fraction: f64,
    with_phase: bool,
) -> Result<Suspension, PhaseError> {
    check(nodes, n_particle, n_medium, wavelength_nm, volume_fraction)?;
    let m = n_particle / n_medium;
    let wavenumber = TAU * n_medium / (wavelength_nm * 1e-3);
    let volume: f64 = nodes.iter().map(|(d, p)| p * PI * d * d * d / 6.0).sum();
    if m == Complex64::ONE {
        return Ok(Suspension { mu_s: 0.0, mu_a: 0.0, g: 0.0, phase: Phase::Isotropic });
    }
    let spheres: Vec<(f64, Coefficients)> = (nodes.iter().filter(|(_, p)| *p > 0.0))
        .map(|&(d, p)| (p, Coefficients::new(m, 0.5 * d * wavenumber)))
        .collect();
    let (mut sca, mut abs, mut forward) = (0.0, 0.0, 0.0);
    for (p, sphere) in &spheres {
        let q = sphere.efficiencies();
        let area = p * PI * (sphere.x / wavenumber) * (sphere.x / wavenumber);
        sca += area * q.q_sca;
        abs += area * q.q_abs;
        forward += area * q.q_sca * q.g;
    }
    let number = volume_fraction / volume;
    let (mu_s, mu_a) = (number * sca, number * abs);
    if sca == 0.0 || !with_phase {
        return Ok(Suspension { mu_s, mu_a, g: 0.0, phase: Phase::Isotropic });
    }
    let g = forward / sca;
    // dC/dω = (|S1|² + |S2|²)/(2k²), over the cross section.
    let scale = 0.5 / (wavenumber * wavenumber * sca);
    let density = |near: f64, far: f64| {
        let mut sum = 0.0;
        for (p, sphere) in &spheres {
            let (s1, s2) = sphere.amplitudes(near, far);
            sum += p * (s1.norm_sqr() + s2.norm_sqr());
        }
        sum * scale
    };
    let largest = spheres.iter().fold(0.0_f64, |x, (_, s)| x.max(s.x));
    let table = resolve(density, largest, g)?;
    Ok(Suspension { mu_s, mu_a, g, phase: Phase::Table(Arc::new(table)) })
}

/// Table of `density` (per steradian, ∫ = 1, mean cosine `g`) on a grid refined until it is converged.
fn resolve(density: impl Fn(f64, f64) -> f64, x: f64, g: f64) -> Result<Table, PhaseError> {
    let start = 180.max((4.0 * x) as usize);
    let mut knots: Vec<Knot> = (0..=start)
        .map(|i| {
            let mut k = Knot::at_angle(PI * i as f64 / start as f64, 0.0);
            if i == start {
                k.far = 0.0;
            }
            k.p = density(k.near, k.far);
            k
        })
        .collect();
    let mut coarse: Vec<bool> = vec![true; start];
    let mut aim = AIM;
    loop {
        let (finer, still, missed) = refine(&knots, &coarse, aim, &density);
        (knots, coarse) = (finer, still);
        let table = Table::new(&knots)?;
        let off = (table.integral_as_written() - 1.0).abs();
        let g_off = (table.mean_cosine() - g).abs();
        let converged = off < CONVERGED && g_off < CONVERGED * g.abs().max(0.01);
        if missed < aim {
            if converged {
                return Ok(table);
            }
            // Lines fit everywhere and yet the sums differ: look closer, everywhere.
            aim *= 0.25;
            coarse.fill(true);
        }
        if knots.len() > MOST_KNOTS {
            return Err(PhaseError::Whole(format!(
                "Mie phase function not resolved by {} knots (normalisation off by {off:e}, g by {g_off:e})",
                knots.len()
            )));
        }
    }
}

/// Halves (in cos θ) every segment marked coarse whose middle lies off the straight line by more than
/// its share of `aim`. Returns the knots, which segments are still to be looked at, and the summed
/// deviation (as probability) found in this pass.
fn refine(
    knots: &[Knot],
    coarse: &[bool],
    aim: f64,
    density: impl Fn(f64, f64) -> f64,
) -> (Vec<Knot>, Vec<bool>, f64) {
    let share = aim / coarse.len() as f64;
    let (mut finer, mut still) = (vec![knots[0]], Vec::with_capacity(coarse.len()));
    let mut missed = Sum::default();
    for (pair, &look) in knots.windows(2).zip(coarse) {
        let (a, b) = (pair[0], pair[1]);
        let mut split = false;
        if look {
            let w = width(&a, &b);
            let mut middle = Knot { near: 0.5 * (a.near + b.near), far: 0.5 * (a.far + b.far), p: 0.0 };
            middle.p = density(middle.near, middle.far);
            // Area between parabola and chord: 2/3 of the height at the middle times the width.
            let area = TAU * w * (2.0 / 3.0) * (middle.p - 0.5 * (a.p + b.p)).abs();
            missed.add(area);
            split = area > share;
            if split {
                finer.push(middle);
                still.extend([true, true]);
            }
        }
        if !split {
            still.push(false);
        }
        finer.push(b);
    }
    (finer, still, missed.value())
}

fn check(
    nodes: &[(f64, f64)],
    n_particle: Complex64,
    n_medium: f64,
    wavelength_nm: f64,
    volume_fraction: f64,
) -> Result<(), PhaseError> {
    let positive = |what, v: f64| error::range(what, v, v > 0.0 && v.is_finite(), "above 0");
    positive("refractive index of the medium", n_medium)?;
    positive("wavelength", wavelength_nm)?;
    positive("refractive index of the particle", n_particle.re)?;
    let kappa = n_particle.im;
    error::range("extinction index of the particle", kappa, kappa >= 0.0 && kappa.is_finite(), "0 or above")?;
    error::range("volume fraction", volume_fraction, (0.0..=1.0).contains(&volume_fraction), "0 to 1")?;
    for (i, &(d, p)) in nodes.iter().enumerate() {
        let x = PI * d * n_medium / (wavelength_nm * 1e-3);
        if !(1e-30..=1e5).contains(&x) {
            let message = format!("diameter {d} µm has the size parameter {x}, outside 1e-30 to 1e5");
            return Err(error::place("node", i + 1, message));
        }
        if !(p >= 0.0 && p.is_finite()) {
            return Err(error::place("node", i + 1, format!("probability {p} is not a number ≥ 0")));
        }
    }
    if nodes.iter().any(|n| n.1 > 0.0) {
        Ok(())
    } else {
        Err(PhaseError::Whole("a size law needs at least one diameter with a probability above 0".into()))
    }
}

#[cfg(test)]
mod tests {
    use super::super::efficiencies;
    use super::*;

    /// One size: µs = φ Q (πd²/4)/(πd³/6) = 3 φ Q/(2d); g from the table = g from the sums.
    #[test]
    fn one_size() {
        let (n, medium, d, lambda, fraction) = (Complex64::new(2.7, 1e-3), 1.55, 0.25, 550.0, 0.03);
        let s = suspension(&[(d, 1.0)], n, medium, lambda, fraction).unwrap();
        let q = efficiencies(n / medium, PI * d * medium / (lambda * 1e-3));
        assert!((s.mu_s / (1.5 * fraction * q.q_sca / d) - 1.0).abs() < 1e-12);
        assert!((s.mu_a / (1.5 * fraction * q.q_abs / d) - 1.0).abs() < 1e-12);
        assert!((s.g - q.g).abs() < 1e-14);
    }

    /// Tables converge to the Mie sums, from Rayleigh to a narrow forward peak.
    #[test]
    fn tables_agree_with_the_sums() {
        for (d, n) in [(0.001, 1.658), (0.2, 1.658), (3.0, 1.658), (30.0, 1.33), (100.0, 1.658)] {
            let s =
                suspension(&[(d, 2.0), (1.3 * d, 1.0)], Complex64::new(n, 0.0), 1.0, 550.0, 0.01).unwrap();
            let Phase::Table(t) = &s.phase else { panic!() };
            let (off, g_off) = (t.integral_as_written() - 1.0, t.mean_cosine() - s.g);
            println!("d = {d}: {} knots, norm {off:.1e}, g {} {g_off:.1e}", t.knots(), s.g);
            assert!(off.abs() < 1e-4 && g_off.abs() < 1e-4 * s.g.max(0.01));
            // Between the knots too: the density of the table against the amplitudes.
            let k = TAU / 0.55;
            let spheres = [(2.0, d), (1.0, 1.3 * d)]
                .map(|(p, d)| (p, Coefficients::new(Complex64::new(n, 0.0), 0.5 * d * k)));
            let sca: f64 =
                spheres.iter().map(|(p, c)| p * PI * (c.x / k).powi(2) * c.efficiencies().q_sca).sum();
            let mut apart = 0.0;
            for i in 0..500 {
                let near = 2.0 * (f64::from(i) + 0.37) / 500.0;
                let exact: f64 = (spheres.iter())
                    .map(|(_, c)| c.amplitudes(near, 2.0 - near))
                    .zip([2.0, 1.0])
                    .map(|((s1, s2), p)| p * (s1.norm_sqr() + s2.norm_sqr()) / (2.0 * k * k * sca))
                    .sum();
                apart += TAU * 2.0 / 500.0 * (t.pdf(1.0 - near) - exact).abs();
            }
            assert!(apart < 1e-3, "d = {d}: {apart}");
        }
    }

    #[test]
    fn refusals_and_limits() {
        let n = Complex64::new(1.5, 0.0);
        assert!(suspension(&[], n, 1.0, 550.0, 0.1).is_err());
        assert!(suspension(&[(1.0, -1.0)], n, 1.0, 550.0, 0.1).is_err());
        assert!(suspension(&[(1.0, 1.0), (f64::NAN, 1.0)], n, 1.0, 550.0, 0.1).is_err());
        assert!(suspension(&[(1.0, 1.0)], n, 1.0, 550.0, 1.1).is_err());
        assert!(suspension(&[(1.0, 1.0)], n.conj() - Complex64::i(), 1.0, 550.0, 0.1).is_err());
        let matched = suspension(&[(1.0, 1.0)], n, 1.5, 550.0, 0.1).unwrap();
        assert_eq!((matched.mu_s, matched.mu_a, matched.phase), (0.0, 0.0, Phase::Isotropic));
    }
}
