//! Whether a scene is reciprocal, so that 0/d may stand for d/0.

use super::effects::Kind;
use super::model::{self, Memory, MultipleBounce, Ratio, SapFrame, Scene, SurfaceKind, Universe};

/// What proves that light may be turned round, f(i, o) = f(o, i) in the mean over realisations; else what
/// stands in the way.
///
/// Proven for explicit bodies and for statistical sheets of the rungs `full` and `homogeneous`, with smooth
/// Fresnel surfaces, Lambertian surfaces of fixed reflectance, and microfacets by the continuous law or a
/// resolved SAP (single bounce).
///
/// # Errors
/// The first thing found that is not proven to be reciprocal.
pub fn reciprocal(scene: &Scene) -> Result<&'static str, String> {
    match &scene.universe {
        Universe::Synthetic(_) | Universe::Realised(_) => {}
        Universe::Statistical(s) => match s.memory {
            Memory::Full | Memory::Homogeneous => {}
            _ => return Err("a rung that forgets bodies meets others on the way back".to_owned()),
        },
        Universe::Mixture(_) => return Err("mixtures of layers are not proven to be".to_owned()),
        Universe::Voxel(_) => {
            return Err("smoothed normals of voxels are not those of their faces".to_owned());
        }
    }
    for kind in [Kind::Fluorescence, Kind::Shifts, Kind::Polarisation, Kind::Bounces] {
        if scene.has(kind) {
            return Err(format!("it is not shown for the effect '{}'", kind.name()));
        }
    }
    for m in &scene.materials {
        if m.sap.is_some_and(|s| s.directions != model::Directions::Density) {
            return Err(format!("the SAP of '{}' moves directions to the middle of patches", m.id));
        }
    }
    for s in &scene.surfaces {
        let id = &s.id;
        match (&s.kind, &s.ratio) {
            (SurfaceKind::Lambertian { per_patch: false }, Ratio::Spectrum(_)) => {}
            (SurfaceKind::Lambertian { .. }, _) => {
                return Err(format!("the reflectance of '{id}' depends on the incidence alone"));
            }
            (SurfaceKind::Smooth, Ratio::Fresnel) => {}
            (SurfaceKind::Smooth, _) if s.opaque => {}
            (SurfaceKind::Rough { multiple_bounce: MultipleBounce::Renormalised, .. }, _) => {
                return Err(format!("the renormalised facets of '{id}' are not"));
            }
            (SurfaceKind::Rough { .. }, Ratio::Fresnel)
                if s.sap.is_none_or(|p| p.frame == SapFrame::Resolved) => {}
            _ => return Err(format!("the surface law '{id}' is not proven to be")),
        }
    }
    Ok("explicit, full or homogeneous geometry; smooth, Lambertian or resolved surfaces; no fluorescence")
}

/// Whether next-event estimation sees all light that leaves: equal refractive indices, no SAP that moves
/// directions, nothing below the sheet, surfaces clear or Lambertian.
///
/// # Errors
/// What stands in the way.
pub fn seen_by_next_event(scene: &Scene) -> Result<(), String> {
    let first = scene.materials.first().map(|m| &m.index);
    if scene
        .materials
        .iter()
        .any(|m| Some(&m.index) != first || !m.index.is_constant() || m.index.k.is_some())
    {
        return Err("refractive indices differ: the last event may be a mirror".to_owned());
    }
    if scene.materials.iter().any(|m| m.sap.is_some()) {
        return Err("a SAP of a medium sends light into patches, not into exact directions".to_owned());
    }
    let fit = |s: &model::Surface| match (&s.kind, &s.ratio) {
        (SurfaceKind::Smooth, Ratio::Fresnel) => !s.opaque,
        (SurfaceKind::Lambertian { per_patch: false }, Ratio::Spectrum(_)) => s.sap.is_none() && s.opaque,
        _ => false,
    };
    if let Some(s) = scene.surfaces.iter().find(|s| !fit(s)) {
        return Err(format!("the surface '{}' is neither clear nor Lambertian and opaque", s.id));
    }
    match &scene.universe {
        Universe::Statistical(s)
            if s.memory == Memory::Homogeneous && s.layers.iter().any(|l| !l.components.is_empty()) =>
        {
            Err("bodies of the rung homogeneous take no room".to_owned())
        }
        Universe::Statistical(s) if s.backing.is_some() => Err("the backing is not looked at".to_owned()),
        Universe::Mixture(m) if m.backing.is_some() => Err("the backing is not looked at".to_owned()),
        _ => Ok(()),
    }
}

/// What the plan says of the measuring geometry 0/d.
pub fn remark(scene: &Scene) -> Option<String> {
    let optics = scene.optics.as_ref()?;
    (optics.geometry == model::OpticsGeometry::NormalDiffuse).then(|| match reciprocal(scene) {
        Ok(why) => format!("0/d is d/0 here, by reciprocity: {why}"),
        Err(why) => format!(
            "warning: 0/d is not proven to be d/0 here ({why}): simulate d/0 too, `lightpro difference` prints \
             what is between them"
        ),
    })
}
