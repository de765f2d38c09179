//! From the checked scene to the full loop's effects at the wavelengths of a group.

use super::effects::Kind;
use super::media::Origin;
use super::model::{ParticleShape, Scatterer, Scene, Source};
use super::optics;
use super::plan::Plan;
use crate::lpm::Light;
use crate::lpm::full::{Full, Lanes, Polarisation};
use crate::lpm::polarised::State;
use crate::lpm::weights::Differences;
use crate::material::Conversion;
use crate::math::{DVec3, sin_cos};
use crate::phase::polarised::{ScatteringMatrix, Stokes};
use crate::phase::{Phase, mie};

/// Effects of the full loop.
///
/// # Errors
/// Optical constants that are missing at a wavelength.
pub fn full<const N: usize>(
    scene: &Scene,
    plan: &Plan,
    wavelengths: &[f64],
    group: usize,
) -> Result<Full<N>, String> {
    let nm = if plan.converts { wavelengths[group] } else { wavelengths[0] };
    let polarisation = scene.has(Kind::Polarisation).then(|| polarisation(scene, plan, nm)).transpose()?;
    let mut full = Full { polarisation, time: scene.has(Kind::Time), ..Full::default() };
    if plan.weighted {
        full.lanes = Lanes::Weighted;
        let d = &scene.detect;
        let eager = d.path || d.depth.is_some() || d.checkpoint.is_some();
        full.lights = lights(scene, plan, wavelengths)?;
        full.differences = Differences::between(&mut full.lights, eager)?;
    }
    if plan.converts {
        full.lanes = Lanes::One(group);
        full.lights = lights(scene, plan, wavelengths)?;
        full.converters = plan.media.origins.iter().map(|o| conversions(scene, o)).collect();
    }
    Ok(full)
}

/// Light at each wavelength by itself.
fn lights<const N: usize>(scene: &Scene, plan: &Plan, wavelengths: &[f64]) -> Result<Vec<Light<N>>, String> {
    wavelengths.iter().map(|&nm| optics::light::<N>(scene, &plan.media, &[nm])).collect()
}

/// Parts of a medium: materials by index, with their shares.
fn parts(origin: &Origin) -> Vec<(usize, f64)> {
    match origin {
        Origin::Material(i) => vec![(*i, 1.0)],
        Origin::Average(parts) => parts.clone(),
    }
}

/// Events of a medium that change the wavelength.
fn conversions(scene: &Scene, origin: &Origin) -> Vec<Conversion> {
    let of = |(i, share): (usize, f64)| {
        scene.materials[i].conversions.iter().map(move |(_, c)| Conversion {
            rate: c.rate.iter().map(|r| share * r).collect(),
            targets: c.targets.clone(),
        })
    };
    parts(origin).into_iter().flat_map(of).collect()
}

/// Source state, scattering matrices and analyser.
fn polarisation(scene: &Scene, plan: &Plan, nm: f64) -> Result<Polarisation, String> {
    let matrices = plan.media.origins.iter().map(|o| matrix(scene, o, nm)).collect::<Result<_, _>>()?;
    // The plane of incidence; its horizontal direction where light comes from the normal.
    let axis = match scene.source {
        Source::Collimated { polar, azimuth, .. } => {
            let ((s, c), (sa, ca)) = (sin_cos(polar), sin_cos(azimuth));
            DVec3::new(c * ca, c * sa, -s)
        }
        _ => DVec3::X,
    };
    let source = State { stokes: scene.polarised.unwrap_or(Stokes::NONE), axis };
    Ok(Polarisation { source, matrices, analyser: scene.detect.analyser })
}

/// Scattering matrix of a medium.
fn matrix(scene: &Scene, origin: &Origin, nm: f64) -> Result<ScatteringMatrix, String> {
    let mut all: Vec<(f64, Phase, ScatteringMatrix)> = Vec::new();
    for (i, share) in parts(origin) {
        let material = &scene.materials[i];
        let of = |e: String| format!("material '{}': {e}", material.id);
        for scatterer in &material.scattering {
            let (mu_s, phase, matrix) = match scatterer {
                Scatterer::Coefficient { mu_s, phase, .. } => {
                    let own = match phase {
                        Phase::Rayleigh => ScatteringMatrix::Rayleigh,
                        _ => ScatteringMatrix::Depolarising,
                    };
                    (mu_s.at(nm).map_err(|e| of(e.to_string()))?, phase.clone(), own)
                }
                Scatterer::Mie { shape: ParticleShape::Fibril, .. } => {
                    return Err(of("fibrils say nothing of polarised light".to_owned()));
                }
                Scatterer::Mie { diameter, index, volume_fraction, .. } => {
                    let n = material.index.at(nm).map_err(|e| of(e.to_string()))?.re;
                    let particle = index.at(nm).map_err(|e| of(e.to_string()))?;
                    let nodes = optics::sizes_that_count(diameter);
                    let s = mie::suspension(&nodes, particle, n, nm, *volume_fraction)
                        .map_err(|e| of(e.to_string()))?;
                    (s.mu_s, s.phase, ScatteringMatrix::mie(&nodes, particle, n, nm))
                }
            };
            if mu_s > 0.0 {
                all.push((share * mu_s, phase, matrix));
            }
        }
    }
    Ok(ScatteringMatrix::mixed(&all))
}
