//! Input data: what each number of a scene, wrong by one per cent, does to the figures. A scene states no
//! uncertainties; these are the coefficients that carry its reader's own. Sizes of bodies are left to sweeps.

use super::settings::difference;
use super::*;
use crate::scene::{Amount, Material, Scatterer, Source, StatisticalSheet};
use crate::spectrum::{Spectrum, SpectrumError, Table};
use serde::{Deserialize, Serialize};

/// Relative change of each number.
const BY: f64 = 0.01;

/// T2, input data in parts: change of a figure for one number 1 % larger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Input2 {
    /// Figure.
    pub figure: String,
    /// Which number.
    pub input: String,
    /// Change of the figure.
    pub change: f64,
    /// Its standard error.
    pub error: f64,
}

/// Runs the scene with each of its numbers 1 % larger, drawing the same numbers.
pub(super) fn tried(scene: &Scene, figures: &[Figure], base: &Timed) -> Vec<Input2> {
    let mut out = Vec::new();
    for (input, other) in larger(scene) {
        // What cannot be made 1 % larger (a fraction beyond 1, a wall as thick as its fibre) has no row.
        let Ok(t) = timed(&other) else { continue };
        for f in figures {
            let Some(g) = t.result.figures.iter().find(|g| g.is_of(f) && g.value.is_some()) else { continue };
            let (change, error) = difference(base, f, &t, g);
            out.push(Input2 { figure: f.title(), input: input.clone(), change, error });
        }
    }
    out
}

/// The numbers of a scene, by name, and the scene with each 1 % larger.
fn larger(scene: &Scene) -> Vec<(String, Scene)> {
    let mut out = Vec::new();
    for (i, m) in scene.materials.iter().enumerate() {
        let mut with = |what: &str, set: &dyn Fn(&mut Material) -> Result<(), SpectrumError>| {
            let mut other = scene.clone();
            if set(&mut other.materials[i]).is_ok() {
                out.push((format!("{what} of '{}'", m.id), other));
            }
        };
        let scaled = |s: &Spectrum| scaled(s, &scene.wavelengths);
        // Air is known.
        if !matches!(m.index.n, Spectrum::Constant(n) if (n - 1.0).abs() < 1e-3) {
            with("index", &|m| scaled(&m.index.n).map(|n| m.index.n = n));
        }
        if let Some(k) = &m.index.k {
            with("kappa", &|m| scaled(k).map(|k| m.index.k = Some(k)));
        }
        if let Some(a) = &m.absorption {
            with("absorption", &|m| scaled(a).map(|a| m.absorption = Some(a)));
        }
        for (j, s) in m.scattering.iter().enumerate() {
            let what = match s {
                Scatterer::Coefficient { .. } => "scattering",
                Scatterer::Mie { .. } => "volume fraction of particles",
            };
            with(what, &|m| {
                match &mut m.scattering[j] {
                    Scatterer::Coefficient { mu_s, .. } => *mu_s = scaled(mu_s)?,
                    Scatterer::Mie { volume_fraction, .. } => *volume_fraction *= 1.0 + BY,
                }
                Ok(())
            });
        }
    }
    let Universe::Statistical(sheet) = &scene.universe else { return out };
    let mut with = |what: String, set: &dyn Fn(&mut StatisticalSheet)| {
        let mut sheet = sheet.clone();
        set(&mut sheet);
        out.push((what, Scene { universe: Universe::Statistical(sheet), ..scene.clone() }));
    };
    for (l, layer) in sheet.layers.iter().enumerate() {
        let place = if sheet.layers.len() > 1 { format!(" {}", l + 1) } else { String::new() };
        // A source with a place of its own stands where it stood: its sheet has a given thickness.
        if !matches!(scene.source, Source::Point { .. }) {
            with(format!("thickness of layer{place}"), &|s| s.layers[l].thickness *= 1.0 + BY);
        }
        for (k, c) in layer.components.iter().enumerate() {
            with(format!("amount of '{}'", c.name), &|s| {
                let (Amount::Grammage(x)
                | Amount::LengthDensity(x)
                | Amount::NumberDensity(x)
                | Amount::VolumeFraction(x)) = &mut s.layers[l].components[k].amount;
                *x *= 1.0 + BY;
            });
        }
    }
    out
}

/// The spectrum 1 % larger, at the scene's wavelengths.
fn scaled(s: &Spectrum, wavelengths: &[f64]) -> Result<Spectrum, SpectrumError> {
    if let Spectrum::Constant(x) = s {
        return Ok(Spectrum::Constant(x * (1.0 + BY)));
    }
    let values: Result<Vec<f64>, _> = wavelengths.iter().map(|&nm| Ok(s.at(nm)? * (1.0 + BY))).collect();
    Ok(Table::new("1 % larger", wavelengths, values?)?.into())
}
