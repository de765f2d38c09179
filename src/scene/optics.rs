//! From the checked scene to the optical side of a run: media and surfaces at the wavelengths of a
//! group.

use super::effects::Kind;
use super::media::{Media, Origin};
use super::model::{self, Populate, Ratio as RatioOf, SapFrame, SapSpec, Scatterer, SurfaceKind};
use crate::lpm::light::MediumSap;
use crate::lpm::patches::{SapRule, SurfaceSap};
use crate::lpm::split::Split;
use crate::lpm::surface::{Directions, Ratio, SurfaceLaw};
use crate::lpm::{Light, Medium};
use crate::material::absorption_from_k;
use crate::math::FRAC_PI_2;
use crate::microfacet::{Microfacet, Slopes};
use crate::phase::{Phase, mie};
use crate::sap::SapDirections;

/// Steps of θ in the table of an angular reflection ratio.
const ANGLES: usize = 361;
/// Nodes of a particle size law.
const SIZE_NODES: usize = 32;

/// Media and surfaces at `wavelengths` (nm, at most `N`).
///
/// # Errors
/// A table that does not cover a wavelength, a SAP that cannot be made.
pub fn light<const N: usize>(
    scene: &model::Scene,
    media: &Media,
    wavelengths: &[f64],
) -> Result<Light<N>, String> {
    let mut light = Light { media: Vec::new(), surfaces: Vec::new(), lanes: wavelengths.len() };
    for origin in &media.origins {
        light.media.push(medium(scene, origin, wavelengths)?);
    }
    let etas = relative_indices(&light.media);
    for surface in &scene.surfaces {
        light.surfaces.push(surface_law(surface, wavelengths, &etas)?);
    }
    Ok(light)
}

/// SAPs over which the branching `split` goes, at its granularity.
///
/// # Errors
/// A SAP that cannot be made.
pub fn split<const N: usize>(light: &Light<N>, nside: u32, floor: f64) -> Result<Split, String> {
    let rule =
        SapRule { nside, exact: true, directions: SapDirections::Density, resolved: true, roll_random: true };
    let text = |e: crate::sap::SapError| e.to_string();
    let media = light
        .media
        .iter()
        .map(|m| (m.mu_s > 0.0).then(|| MediumSap::new(&m.phase, &rule)).transpose())
        .collect::<Result<_, _>>()
        .map_err(text)?;
    let etas = relative_indices(&light.media);
    let surfaces = light
        .surfaces
        .iter()
        .map(|s| {
            let smooth = matches!(s.directions, Directions::Smooth);
            (!smooth)
                .then(|| SurfaceSap::new(&s.directions, s.sap.as_ref().map_or(rule, |x| x.rule()), &etas))
                .transpose()
        })
        .collect::<Result<_, _>>()
        .map_err(text)?;
    Ok(Split { floor, media, surfaces })
}

/// Group index n − λ dn/dλ of every medium at `nm`, by a difference over 1 nm inside the index data; of an
/// average the volume average.
///
/// # Errors
/// A table that does not cover the wavelength.
pub fn group_indices(scene: &model::Scene, media: &Media, nm: f64) -> Result<Vec<f64>, String> {
    let of = |material: &model::Material| -> Result<f64, String> {
        let index = |at: f64| material.index.at(at).map(|n| n.re);
        let n = index(nm).map_err(|e| format!("material '{}': {e}", material.id))?;
        let (below, above) = (index(nm - 0.5), index(nm + 0.5));
        let slope = match (below, above) {
            (Ok(b), Ok(a)) => a - b,
            (Ok(b), Err(_)) => 2.0 * (n - b),
            (Err(_), Ok(a)) => 2.0 * (a - n),
            (Err(_), Err(_)) => 0.0,
        };
        Ok(n - nm * slope)
    };
    let each = |origin: &Origin| match origin {
        Origin::Material(i) => of(&scene.materials[*i]),
        Origin::Average(parts) => {
            parts.iter().try_fold(0.0, |sum, (i, share)| Ok(sum + share * of(&scene.materials[*i])?))
        }
    };
    media.origins.iter().map(each).collect()
}

fn relative_indices<const N: usize>(media: &[Medium<N>]) -> Vec<f64> {
    let mut etas: Vec<f64> = Vec::new();
    for a in media {
        for b in media {
            let eta = b.n.re / a.n.re;
            if !etas.contains(&eta) {
                etas.push(eta);
            }
        }
    }
    etas
}

/// Optical constants of one material at one wavelength.
struct Constants {
    n: num_complex::Complex64,
    mu_a: f64,
    mu_s: f64,
    phases: Vec<(f64, Phase)>,
}

fn constants(material: &model::Material, nm: f64, absorption_only: bool) -> Result<Constants, String> {
    let of = |e: String| format!("material '{}': {e}", material.id);
    let n = material.index.at(nm).map_err(|e| of(e.to_string()))?;
    let mut mu_a = absorption_from_k(n.im, nm);
    if let Some(a) = &material.absorption {
        mu_a += a.at(nm).map_err(|e| of(e.to_string()))?;
    }
    let mut phases = Vec::new();
    for scatterer in &material.scattering {
        match scatterer {
            Scatterer::Coefficient { .. } if absorption_only => {}
            Scatterer::Coefficient { mu_s, phase } => {
                phases.push((mu_s.at(nm).map_err(|e| of(e.to_string()))?, phase.clone()));
            }
            Scatterer::Mie { diameter, index, volume_fraction } => {
                let particle = index.at(nm).map_err(|e| of(e.to_string()))?;
                let nodes = sizes_that_count(diameter);
                if absorption_only {
                    mu_a += mie::suspension_absorption(&nodes, particle, n.re, nm, *volume_fraction)
                        .map_err(|e| of(e.to_string()))?;
                    continue;
                }
                let s = mie::suspension(&nodes, particle, n.re, nm, *volume_fraction)
                    .map_err(|e| of(e.to_string()))?;
                mu_a += s.mu_a;
                phases.push((s.mu_s, s.phase));
            }
        }
    }
    phases.retain(|(mu_s, _)| *mu_s > 0.0);
    Ok(Constants { n, mu_a, mu_s: phases.iter().map(|p| p.0).sum(), phases })
}

/// Nodes of a size law without the far tails: what is left out holds less than 1e-6 of the particles'
/// projected area and of their volume, and would cost most of the work (Mie series grow with size).
pub(super) fn sizes_that_count(diameter: &crate::law::SizeLaw) -> Vec<(f64, f64)> {
    const LEFT_OUT: f64 = 1e-6;
    let nodes = diameter.nodes(SIZE_NODES);
    let share = |power: i32| -> Vec<f64> {
        let part: Vec<f64> = nodes.iter().map(|(d, p)| p * d.powi(power)).collect();
        let total: f64 = part.iter().sum();
        part.iter().map(|x| x / total).collect()
    };
    let (area, volume) = (share(2), share(3));
    let limit = LEFT_OUT / SIZE_NODES as f64;
    let kept = nodes.iter().enumerate().filter(|(i, _)| area[*i] > limit || volume[*i] > limit);
    kept.map(|(_, n)| *n).collect()
}

fn phase_of(mut parts: Vec<(f64, Phase)>) -> Result<Phase, String> {
    match parts.len() {
        0 => Ok(Phase::Isotropic),
        1 => Ok(parts.remove(0).1),
        _ => Phase::mixture(parts).map_err(|e| e.to_string()),
    }
}

fn medium<const N: usize>(
    scene: &model::Scene,
    origin: &Origin,
    wavelengths: &[f64],
) -> Result<Medium<N>, String> {
    let average;
    let (parts, sap): (&[(usize, f64)], _) = match origin {
        Origin::Material(i) => {
            average = [(*i, 1.0)];
            (&average, scene.materials[*i].sap)
        }
        Origin::Average(parts) => (parts, None),
    };
    // Index, scattering and phase function are those of the first wavelength: the plan puts wavelengths
    // into one group only where they are the same for all.
    let mut mu_a = [0.0; N];
    let mut first = None;
    for (lane, &nm) in wavelengths.iter().enumerate() {
        let mut sum = Constants { n: num_complex::Complex64::ZERO, mu_a: 0.0, mu_s: 0.0, phases: Vec::new() };
        for &(material, share) in parts {
            let c = constants(&scene.materials[material], nm, first.is_some())?;
            sum.n = c.n;
            sum.mu_a += share * c.mu_a;
            sum.mu_s += share * c.mu_s;
            sum.phases.extend(c.phases.into_iter().map(|(w, p)| (share * w, p)));
        }
        mu_a[lane] = sum.mu_a;
        if first.is_none() {
            first = Some(sum);
        }
    }
    let first = first.ok_or("no wavelength")?;
    // Unused lanes follow the last one, so that they never steer the roulette.
    for lane in wavelengths.len()..N {
        mu_a[lane] = mu_a[wavelengths.len() - 1];
    }
    let phase = phase_of(first.phases)?;
    let sap = match sap {
        Some(spec) if first.mu_s > 0.0 => {
            Some(MediumSap::new(&phase, &rule(&spec)).map_err(|e| e.to_string())?)
        }
        _ => None,
    };
    let mut medium = Medium::clear(1.0).with(mu_a, first.mu_s, phase);
    medium.n = first.n;
    medium.real = first.n.im == 0.0;
    medium.sap = sap;
    medium.absorbs |= scene.forced_on(Kind::Absorption);
    Ok(medium)
}

fn rule(spec: &SapSpec) -> SapRule {
    SapRule {
        nside: spec.nside,
        exact: spec.populate == Populate::Exact,
        directions: match spec.directions {
            model::Directions::Centre => SapDirections::Centre,
            model::Directions::Density => SapDirections::Density,
            model::Directions::Uniform => SapDirections::Uniform,
        },
        resolved: spec.frame == SapFrame::Resolved,
        roll_random: spec.roll_random,
    }
}

fn surface_law<const N: usize>(
    surface: &model::Surface,
    wavelengths: &[f64],
    etas: &[f64],
) -> Result<SurfaceLaw<N>, String> {
    let of = |e: String| format!("surface '{}': {e}", surface.id);
    let directions = match surface.kind {
        SurfaceKind::Smooth => Directions::Smooth,
        SurfaceKind::Lambertian { per_patch: true } => Directions::PerPatch,
        SurfaceKind::Lambertian { per_patch: false } => Directions::Lambertian,
        // A rough surface of slope 0 is the smooth one, bit for bit.
        SurfaceKind::Rough { m: 0.0, .. } => Directions::Smooth,
        SurfaceKind::Rough { slopes, m, multiple_bounce: model::MultipleBounce::Walk } => {
            Directions::Walk(Microfacet::new(slope_law(slopes), m).map_err(|e| of(e.to_string()))?)
        }
        SurfaceKind::Rough { slopes, m, multiple_bounce } => Directions::Facets {
            law: Microfacet::new(slope_law(slopes), m).map_err(|e| of(e.to_string()))?,
            renormalised: multiple_bounce == model::MultipleBounce::Renormalised,
        },
    };
    let sap = match (&surface.sap, &directions) {
        (Some(spec), d) if !matches!(d, Directions::Smooth) => {
            Some(SurfaceSap::new(d, rule(spec), etas).map_err(|e| of(e.to_string()))?)
        }
        _ => None,
    };
    Ok(SurfaceLaw {
        directions,
        ratio: ratio(&surface.ratio, wavelengths).map_err(of)?,
        opaque: surface.opaque,
        sap,
    })
}

fn slope_law(slopes: model::Slopes) -> Slopes {
    match slopes {
        model::Slopes::Gaussian => Slopes::Gaussian,
        model::Slopes::Exponential => Slopes::Exponential,
        model::Slopes::Ggx => Slopes::Ggx,
    }
}

fn ratio<const N: usize>(ratio: &RatioOf, wavelengths: &[f64]) -> Result<Ratio<N>, String> {
    let lanes = |f: &dyn Fn(f64) -> Result<f64, String>| -> Result<[f64; N], String> {
        let mut out = [0.0; N];
        for (o, &nm) in out.iter_mut().zip(wavelengths) {
            *o = f(nm)?.clamp(0.0, 1.0);
        }
        // Unused lanes follow the last one.
        let last = out[wavelengths.len() - 1];
        out[wavelengths.len()..].fill(last);
        Ok(out)
    };
    Ok(match ratio {
        RatioOf::Fresnel => Ratio::Fresnel,
        RatioOf::PaperAmplitude => Ratio::PaperAmplitude,
        RatioOf::Spectrum(s) => Ratio::Constant(lanes(&|nm| s.at(nm).map_err(|e| e.to_string()))?),
        RatioOf::Film { index, thickness } => {
            let mut by = [0.0; N];
            for (t, nm) in by.iter_mut().zip(wavelengths) {
                *t = thickness / (nm * 1e-3);
            }
            let last = by[wavelengths.len() - 1];
            by[wavelengths.len()..].fill(last);
            Ratio::Film { index: *index, thickness: by }
        }
        RatioOf::Table { wavelengths: rows, angles, values } => {
            let mut table = Vec::with_capacity(ANGLES);
            for k in 0..ANGLES {
                let theta = FRAC_PI_2 * k as f64 / (ANGLES - 1) as f64;
                table.push(lanes(&|nm| bilinear(rows, angles, values, nm, theta))?);
            }
            Ratio::Angle(table)
        }
    })
}

/// Bilinear interpolation over wavelength (refused outside) and angle (constant outside).
fn bilinear(rows: &[f64], columns: &[f64], values: &[f64], nm: f64, theta: f64) -> Result<f64, String> {
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    if rows.len() > 1 && !(first..=last).contains(&nm) {
        return Err(format!("{nm} nm lies outside the reflection table ({first} to {last} nm)"));
    }
    let (i, f) = cell(rows, nm);
    let (j, g) = cell(columns, theta);
    let at = |i: usize, j: usize| values[i.min(rows.len() - 1) * columns.len() + j.min(columns.len() - 1)];
    Ok((1.0 - f) * ((1.0 - g) * at(i, j) + g * at(i, j + 1))
        + f * ((1.0 - g) * at(i + 1, j) + g * at(i + 1, j + 1)))
}

fn cell(knots: &[f64], x: f64) -> (usize, f64) {
    let i = knots.partition_point(|k| *k <= x).saturating_sub(1).min(knots.len().saturating_sub(2));
    match knots.get(i + 1) {
        Some(next) => (i, ((x - knots[i]) / (next - knots[i])).clamp(0.0, 1.0)),
        None => (0, 0.0),
    }
}
