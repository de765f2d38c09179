//! Light that comes out at another wavelength: fluorescence, Raman and Brillouin scattering, on the grid
//! of wavelengths of a scene.
//!
//! **Fluorescence** (optical brighteners): photons are absorbed at the rate µf(λ) and a share η (quantum
//! yield) is emitted again, isotropic and unpolarised, with a spectrum that does not depend on the
//! excitation (Kasha's rule). In power, the bispectral (Donaldson) matrix of one event is
//! D(λ → λ′) = η e(λ′) Δλ′ λ/λ′ with e the emitted photons per nm, ∫ e dλ′ = 1 (Donaldson, Br. J. Appl.
//! Phys. 5 (1954) 210, doi:10.1088/0508-3443/5/6/304). Light is emitted at λ′ ≥ λ only; what the law has
//! below goes to heat, so no event gains power.
//!
//! **Raman**, **Brillouin**: 1/λ′ = 1/λ − Δν (Stokes) and, for Brillouin, 1/λ + Δν with equal chance
//! (anti-Stokes); one photon for one.

/// Where an event sends light: one target among those of a wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Index of the wavelength.
    pub lane: usize,
    /// Probability that it is this one or one before it in the list.
    pub cumulative: f64,
    /// Power after the event over power before.
    pub kept: f64,
}

/// A process that changes the wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct Conversion {
    /// Events per µm at each wavelength of the grid.
    pub rate: Vec<f64>,
    /// Where they send light, per incoming wavelength; what is left of probability is heat (and light that
    /// leaves the grid).
    pub targets: Vec<Vec<Target>>,
}

/// Width of each bin of the grid, nm: half way to the neighbours, outer ones symmetric.
pub fn widths(nm: &[f64]) -> Vec<f64> {
    let n = nm.len();
    (0..n)
        .map(|i| {
            let below = if i > 0 { nm[i] - nm[i - 1] } else { nm.get(1).map_or(1.0, |x| x - nm[0]) };
            let above = if i + 1 < n { nm[i + 1] - nm[i] } else { below };
            0.5 * (below + above)
        })
        .collect()
}

impl Conversion {
    /// Fluorescence: absorption coefficients `rate` (1/µm) and emitted photons per nm `emission` (any
    /// unit, its sum over the bins is normalised) at the wavelengths `nm`.
    pub fn fluorescence(nm: &[f64], rate: Vec<f64>, emission: &[f64], quantum_yield: f64) -> Self {
        let photons: Vec<f64> = emission.iter().zip(widths(nm)).map(|(e, w)| e * w).collect();
        let all: f64 = photons.iter().sum();
        let targets = (0..nm.len())
            .map(|i| {
                let mut cumulative = 0.0;
                (i..nm.len())
                    .filter(|&j| photons[j] > 0.0)
                    .map(|j| {
                        cumulative += photons[j] / all;
                        Target { lane: j, cumulative, kept: quantum_yield * nm[i] / nm[j] }
                    })
                    .collect()
            })
            .collect();
        Conversion { rate, targets }
    }

    /// A shift of `shift` (wavenumber, 1/µm) down, or up and down with equal chance, at the rate `rate`
    /// (1/µm) at the wavelengths `nm`.
    ///
    /// # Errors
    /// A grid that does not resolve the shift: the step (nm) that it needs.
    pub fn shifted(nm: &[f64], rate: Vec<f64>, shift: f64, both: bool) -> Result<Self, f64> {
        let target = |from: f64, by: f64| 1e3 / (1e3 / from - by);
        // A shift is resolved where it leads at least one step away.
        let needed = nm.iter().map(|&l| (target(l, shift) - l).abs()).fold(f64::INFINITY, f64::min);
        let coarsest = nm.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        if nm.len() < 2 || coarsest > needed * (1.0 + 1e-9) {
            return Err(needed);
        }
        let bins = widths(nm);
        let lane = |to: f64| (0..nm.len()).find(|&j| (to - nm[j]).abs() <= 0.5 * bins[j]);
        let ways: &[(f64, f64)] = if both { &[(shift, 0.5), (-shift, 1.0)] } else { &[(shift, 1.0)] };
        let targets = nm
            .iter()
            .map(|&from| {
                let mut found = Vec::new();
                let (mut before, mut cumulative) = (0.0, 0.0);
                for &(by, upto) in ways {
                    let to = target(from, by);
                    if let Some(lane) = lane(to).filter(|_| to > 0.0) {
                        cumulative += upto - before;
                        found.push(Target { lane, cumulative, kept: from / nm[lane] });
                    }
                    before = upto;
                }
                found
            })
            .collect();
        Ok(Conversion { rate, targets })
    }

    /// Power that an event at wavelength `i` sends to `j`, over the power before: the bispectral matrix.
    pub fn bispectral(&self, i: usize, j: usize) -> f64 {
        let mut before = 0.0;
        for t in &self.targets[i] {
            if t.lane == j {
                return (t.cumulative - before) * t.kept;
            }
            before = t.cumulative;
        }
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Photons are conserved: Σ D λ′/λ = quantum yield where all emission lies above the excitation.
    #[test]
    fn photons_are_conserved() {
        let nm: Vec<f64> = (0..20).map(|i| 320.0 + 20.0 * f64::from(i)).collect();
        let emission: Vec<f64> = nm.iter().map(|l| if *l > 400.0 { 700.0 - l } else { 0.0 }).collect();
        let c = Conversion::fluorescence(&nm, vec![0.1; 20], &emission, 0.7);
        for i in 0..4 {
            let photons: f64 = (0..20).map(|j| c.bispectral(i, j) * nm[j] / nm[i]).sum();
            assert!((photons - 0.7).abs() < 1e-14);
            let power: f64 = (0..20).map(|j| c.bispectral(i, j)).sum();
            assert!(power < 0.7);
        }
        assert!((0..20).all(|i| (0..i).all(|j| c.bispectral(i, j) == 0.0)));
    }

    /// 2900 /cm takes 500 nm to 584.8 nm; half a wavenumber is 15 pm at 550 nm.
    #[test]
    fn shifts_and_what_resolves_them() {
        let nm: Vec<f64> = (0..31).map(|i| 400.0 + 10.0 * f64::from(i)).collect();
        let c = Conversion::shifted(&nm, vec![1e-5; 31], 0.29, false).unwrap();
        assert_eq!((c.targets[10][0].lane, c.targets[10].len()), (18, 1));
        let needed = Conversion::shifted(&nm, vec![1e-5; 31], 0.5e-4, true).unwrap_err();
        assert!((needed - 0.008).abs() < 1e-4, "{needed}");
        let fine: Vec<f64> = (0..31).map(|i| 550.0 + 0.01 * f64::from(i)).collect();
        let c = Conversion::shifted(&fine, vec![1e-5; 31], 0.5e-4, true).unwrap();
        assert_eq!(c.targets[15].iter().map(|t| t.lane).collect::<Vec<_>>(), [17, 13]);
    }
}
