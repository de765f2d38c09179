//! What a scene calls for, settled before the first ray, with reasons.

use super::effects::{self, Effect, Kind};
use super::media::Media;
use super::model::{self, Memory, Ratio, Scatterer, Scene, Universe};
use super::statistical::LayerReport;
use super::{mixture, realise, statistical, synthetic, voxel};
use crate::lpm::LANES;
use crate::math::DVec3;
use crate::source::Source;
use crate::universe::Overlap;
use crate::universe::any::AnyUniverse;
use crate::universe::synthetic::ensemble::Ensemble;
use std::fmt;

/// Everything a run needs beside the optical constants.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Where components are.
    pub universe: AnyUniverse,
    /// Media and their names.
    pub media: Media,
    /// The source, in place.
    pub source: Source,
    /// Upper and lower face, µm.
    pub top: f64,
    /// See `top`.
    pub bottom: f64,
    /// Layers of bodies, as they came out.
    pub layers: Vec<LayerReport>,
    /// Wavelengths that share their paths, nm; each group is traced by itself.
    pub groups: Vec<Vec<f64>>,
    /// The full loop runs.
    pub full: bool,
    /// Events change the wavelength: a group is one wavelength of excitation with all wavelengths of
    /// emission in its lanes.
    pub converts: bool,
    /// Wavelengths go together by weights.
    pub weighted: bool,
    /// Why the wavelengths are grouped so.
    pub spectrum: String,
    /// Effects.
    pub effects: Vec<Effect>,
    /// Warnings and remarks.
    pub remarks: Vec<String>,
}

impl Plan {
    /// Settles what to simulate.
    ///
    /// # Errors
    /// A scene that cannot be made, with the reason.
    pub fn new(scene: &Scene) -> Result<Self, String> {
        let mut media = Media::of(scene.materials.iter().map(|m| m.id.clone()));
        let mut notes = Vec::new();
        let (universe, layers, faces) = match &scene.universe {
            Universe::Statistical(sheet) => {
                let (u, top, layers) = statistical::build(sheet, scene, &mut media)?;
                (u, layers, Some((top, 0.0)))
            }
            Universe::Mixture(m) => {
                let (universe, found) = mixture::build(m, scene, &mut media)?;
                notes = found;
                (universe, Vec::new(), Some((m.thickness, 0.0)))
            }
            Universe::Realised(r) => {
                let (universe, top, layers, found) = realise::build(r, scene, &mut media)?;
                notes = found;
                (universe, layers, Some((top, 0.0)))
            }
            Universe::Synthetic(s) => {
                let u = synthetic::universe(s).map_err(|e| e.to_string())?;
                notes.extend(s.cell.map(|_| u.describe_search()));
                let universe = match s.cell {
                    _ if s.skins.iter().any(Option::is_some) => {
                        let (made, told) = synthetic::topography(s, u, scene)?;
                        notes.extend(told);
                        AnyUniverse::Topography(made)
                    }
                    Some(cell) => {
                        let in_pores = cell.start == model::StartIn::Pore;
                        AnyUniverse::Ensemble(Ensemble::new(vec![u], 1).from_pores(in_pores))
                    }
                    None => AnyUniverse::Synthetic(u),
                };
                (universe, Vec::new(), extent(s))
            }
            Universe::Voxel(v) => {
                let (universe, found) = voxel::build(v, scene)?;
                notes = found;
                let top = universe.thickness();
                (AnyUniverse::Voxel(universe), Vec::new(), Some((top, 0.0)))
            }
        };
        let walks = |s: &&model::Surface| {
            let walk = model::MultipleBounce::Walk;
            matches!(s.kind, model::SurfaceKind::Rough { multiple_bounce, .. } if multiple_bounce == walk)
        };
        if let (model::Branching::Split { .. }, Some(s)) =
            (scene.run.branching, scene.surfaces.iter().find(walks))
        {
            return Err(format!(
                "surface '{}': a walk between facets has no patches: branching=\"sample\"",
                s.id
            ));
        }
        let (top, bottom) = faces.unwrap_or((0.0, 0.0));
        let source = source(&scene.source, faces)?;
        let (groups, spectrum) = groups(scene);
        let converts = converts(scene);
        let weighted = !converts && groups.iter().any(|g| g.len() > 1) && differs(scene).is_some();
        let full = converts || weighted || scene.has(Kind::Polarisation) || scene.has(Kind::Time);
        if !scene.detect.views.is_empty() {
            let other = if full { Err("effects change the light on its way".to_owned()) } else { Ok(()) };
            super::reciprocity::seen_by_next_event(scene)
                .and(other)
                .map_err(|e| format!("<view> would miss light: {e}"))?;
        }
        let effects = effects::settle(scene);
        let mut remarks = remarks(scene, &layers);
        remarks.extend(notes);
        remarks.extend(super::reciprocity::remark(scene));
        remarks.extend(scene.warnings.iter().cloned());
        Ok(Plan {
            universe,
            media,
            source,
            top,
            bottom,
            layers,
            groups,
            full,
            converts,
            weighted,
            spectrum,
            effects,
            remarks,
        })
    }
}

/// Height of the uppermost and lowest point of the bodies; `None` where they have no end.
fn extent(s: &model::Synthetic) -> Option<(f64, f64)> {
    let mut range = (f64::NEG_INFINITY, f64::INFINITY);
    match s.cell {
        Some(cell) => range = (cell.planes[1], cell.planes[0]),
        None => {
            for body in &s.bodies {
                let (low, high) = vertical(&body.geometry)?;
                range = (range.0.max(high), range.1.min(low));
            }
        }
    }
    // Beyond a surface there is nothing.
    if let [Some(top), _] = &s.skins {
        let [lowest, highest] = top.map.range();
        range = (highest, range.1.min(lowest));
    }
    if let [_, Some(bottom)] = &s.skins {
        range.1 = bottom.map.range()[0];
    }
    (range.0.is_finite() && range.1.is_finite()).then_some(range)
}

fn vertical(g: &model::Geometry) -> Option<(f64, f64)> {
    use model::Geometry as G;
    let about = |z: f64, h: f64| Some((z - h, z + h));
    match g {
        G::Sphere { centre, radius } => about(centre.z, *radius),
        G::Ellipsoid { centre, half_axes: h, axis, major } => {
            let third = axis.cross(*major);
            let h2 = (h.x * major.z).powi(2) + (h.y * third.z).powi(2) + (h.z * axis.z).powi(2);
            about(centre.z, h2.sqrt())
        }
        G::Cylinder { centre, axis, major, half_axes: (a, b), half_length, .. } => {
            let along = match half_length {
                Some(l) => l * axis.z.abs(),
                None if axis.z == 0.0 => 0.0,
                None => return None,
            };
            let across = ((a * major.z).powi(2) + (b * axis.cross(*major).z).powi(2)).sqrt();
            about(centre.z, along + across)
        }
        G::Piece { centre, axis, major, shape, .. } => {
            let up = axis.cross(*major);
            let across = ((shape.a * major.z).powi(2) + (shape.b * up.z).powi(2)).sqrt();
            let ends = [shape.from, shape.to].map(|t| centre.z + axis.z * t + up.z * shape.centre(t));
            Some((ends[0].min(ends[1]) - across, ends[0].max(ends[1]) + across))
        }
        G::Box { min, max } => Some((min.z, max.z)),
        // A half space below a horizontal plane ends the scene on top.
        G::Plane { point, normal } if *normal == DVec3::Z => Some((point.z, point.z)),
        G::Plane { .. } => None,
        G::Slab { z_min, z_max } => Some((*z_min, *z_max)),
    }
}

fn source(spec: &model::Source, faces: Option<(f64, f64)>) -> Result<Source, String> {
    let centre = || {
        faces.map(|(top, _)| DVec3::new(0.0, 0.0, top)).ok_or_else(|| {
            "a collimated or diffuse source shines on the top of the scene, and these bodies have none: \
             use <source kind=\"point\" …>, or bound the bodies"
                .to_owned()
        })
    };
    Ok(match *spec {
        model::Source::Collimated { polar, azimuth, radius } => {
            Source::collimated(polar, azimuth, centre()?, radius)
        }
        model::Source::Diffuse { trap } => Source::diffuse(centre()?, trap),
        model::Source::Point { position, target, half_angle } => Source::point(position, target, half_angle),
    })
}

/// An index that differs between wavelengths and turns rays.
fn turns(scene: &Scene) -> Option<String> {
    let varies = scene.materials.iter().find(|m| !m.index.is_constant());
    varies.map(|m| format!("the refractive index of '{}' depends on wavelength and turns rays", m.id))
}

/// What differs between wavelengths although directions do not: µs(λ), p(λ), R(λ).
fn differs(scene: &Scene) -> Option<String> {
    for m in &scene.materials {
        for s in &m.scattering {
            match s {
                Scatterer::Coefficient { mu_s, .. } if !mu_s.is_constant() => {
                    return Some(format!("the scattering coefficient of '{}' depends on wavelength", m.id));
                }
                Scatterer::Mie { .. } => {
                    return Some(format!("Mie scattering in '{}' depends on wavelength", m.id));
                }
                Scatterer::Coefficient { .. } => {}
            }
        }
    }
    let found = scene.surfaces.iter().find(|s| varies(&s.ratio) && !s.opaque);
    found.map(|s| format!("the reflected share of '{}' depends on wavelength", s.id))
}

fn varies(r: &Ratio) -> bool {
    match r {
        Ratio::Fresnel | Ratio::PaperAmplitude => false,
        Ratio::Spectrum(s) => !s.is_constant(),
        Ratio::Film { thickness, .. } => *thickness > 0.0,
        Ratio::Table { wavelengths, .. } => wavelengths.len() > 1,
    }
}

/// Why wavelengths that differ cannot go together by weights; `None`: they can.
fn apart(scene: &Scene) -> Option<&'static str> {
    match scene.run.weights {
        Some(false) => return Some("weights between wavelengths are not wanted"),
        None if scene.optics.as_ref().is_some_and(|o| o.pile > 1) => {
            return Some(
                "long paths through a pile spread weights between wavelengths (weights=\"yes\" takes them)",
            );
        }
        _ => {}
    }
    if scene.has(Kind::Polarisation) {
        return Some("polarised light scatters in planes of its own at each");
    }
    if scene.has(Kind::Sap) {
        return Some("patches belong to one");
    }
    let rough = |s: &model::Surface| matches!(s.kind, model::SurfaceKind::Rough { .. });
    let facets = scene.surfaces.iter().any(|s| rough(s) && varies(&s.ratio) && !s.opaque);
    facets.then_some("facets reflect each otherwise")
}

fn converts(scene: &Scene) -> bool {
    scene.materials.iter().any(|m| !m.conversions.is_empty())
}

fn groups(scene: &Scene) -> (Vec<Vec<f64>>, String) {
    let single = || scene.wavelengths.iter().map(|&w| vec![w]).collect();
    if converts(scene) {
        return (
            scene.wavelengths.iter().map(|_| scene.wavelengths.clone()).collect(),
            "one wavelength of excitation per pass, every wavelength of emission in it: events change the \
             wavelength"
                .to_owned(),
        );
    }
    if scene.wavelengths.len() == 1 {
        return (single(), "one wavelength".to_owned());
    }
    if !scene.run.implicit_capture {
        return (single(), "one wavelength per history: analog absorption kills whole rays".to_owned());
    }
    if scene.forced_on(Kind::Dispersion) {
        return (single(), "one wavelength per history: dispersion is forced on".to_owned());
    }
    if let Some(why) = turns(scene) {
        return (single(), format!("one wavelength per history: {why}"));
    }
    let together = || scene.wavelengths.chunks(LANES).map(<[f64]>::to_vec).collect();
    match (differs(scene), apart(scene)) {
        (Some(why), Some(apart)) => (single(), format!("one wavelength per history: {why}; {apart}")),
        (Some(why), None) => (
            together(),
            format!("weighted: {why}, directions do not; one wavelength draws, the others follow by weights"),
        ),
        (None, _) => (
            together(),
            "white: paths do not depend on wavelength, each carries a weight per wavelength".to_owned(),
        ),
    }
}

/// What the memory rung is exact for, and where it is known to be biased for what the scene asks.
fn remarks(scene: &Scene, layers: &[LayerReport]) -> Vec<String> {
    let Universe::Statistical(sheet) = &scene.universe else { return Vec::new() };
    if layers.is_empty() {
        return Vec::new();
    }
    let mut out = vec![rung(sheet)];
    let forgets = !matches!(sheet.memory, Memory::Full);
    let bodies = || sheet.layers.iter().flat_map(|l| &l.components);
    let opaque = |c: &model::Component| scene.surfaces[usize::from(c.surface.0)].opaque;
    let index = |m: crate::universe::MediumId| &scene.materials[usize::from(m.0)].index;
    let refracts =
        sheet.layers.iter().any(|l| l.components.iter().any(|c| index(c.material) != index(l.pore)));
    let absorbs = bodies().any(|c| {
        let m = &scene.materials[usize::from(c.material.0)];
        !opaque(c) && (m.absorption.is_some() || m.index.k.is_some())
    });
    if forgets && scene.detect.angular.is_some() {
        out.push(
            "warning: without a full memory the angular distribution lacks the peak around retro-reflection \
             (for white fibres at a share of .3 the factor over 0-10 deg is .67 instead of .91)"
                .to_owned(),
        );
    }
    if forgets && absorbs && sheet.memory != Memory::Homogeneous {
        out.push(
            "warning: the transmittance of absorbing sheets is biased without a full memory: light that \
             comes back through the same pores, and light guided from fibre to fibre, is missing"
                .to_owned(),
        );
    }
    if forgets && refracts && bodies().any(|c| matches!(c.shape, model::Shape::Fibre { .. })) {
        out.push(
            "warning: below full memory the path inside the walls of refracting fibres comes out 20-80 % \
             short: light guided through their overlaps is lost"
                .to_owned(),
        );
    }
    let in_plane = bodies()
        .any(|c| c.tilt == crate::law::Tilt::InPlane && matches!(c.shape, model::Shape::Fibre { .. }));
    if in_plane && sheet.layers.iter().any(|l| l.grace.is_some()) {
        out.push(
            "warning: a free-path law that is the same for all directions contradicts in-plane fibres: the \
             mean path 2H of a lossless sheet is missed (18.3 instead of 20)"
                .to_owned(),
        );
    }
    if sheet.overlap == Overlap::Forbid {
        out.push(
            "warning: overlap forbid is an approximation of hard packing: bodies that would cut a known \
             one are refused, and somewhat less than the nominal amount stands in the sheet"
                .to_owned(),
        );
    }
    if scene.run.shared > 1 {
        out.push(format!(
            "{} histories share a realisation: errors count realisations, and the variance between them is \
             that of spots of the size of the beam",
            scene.run.shared
        ));
    }
    out
}

/// The rung and what it is exact for.
fn rung(sheet: &model::StatisticalSheet) -> String {
    match sheet.memory {
        Memory::Homogeneous => {
            "memory homogeneous: a body is met, and the ray goes on where it entered; exact \
                                only where chords are far shorter than free paths"
                .to_owned()
        }
        Memory::Markov => "memory markov: the medium only; exact for straight rays with Markov chords; the \
                           reflectance of scattering sheets comes out too low"
            .to_owned(),
        Memory::None => {
            "memory none: the body that the ray is in; exact for straight rays and single bodies; \
                         a sheet's reflectance is known to be off by up to some hundredths"
                .to_owned()
        }
        Memory::Last(k) => format!(
            "memory {k}: the last {k} flights and the bodies on them; between none and full, and the mean path \
             2H of a lossless sheet is missed by up to 4 %"
        ),
        Memory::Full if sheet.overlap == Overlap::Forbid => {
            "memory full: everything met is remembered, and new bodies keep clear of it".to_owned()
        }
        Memory::Full => {
            "memory full: exact: equals the mean over all explicit Boolean realisations".to_owned()
        }
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "effects")?;
        for e in &self.effects {
            writeln!(f, "  {} {:<26} {}", if e.on { "on " } else { "off" }, e.name, e.reason)?;
        }
        let groups = match self.groups.len() {
            1 => format!("{} wavelength(s) in one pass", self.groups[0].len()),
            n if self.converts => format!("{n} wavelengths in {n} passes"),
            n => format!("{} wavelengths in {n} passes", self.groups.iter().map(Vec::len).sum::<usize>()),
        };
        writeln!(f, "loop\n  {}", if self.full { "full" } else { "minimal" })?;
        writeln!(f, "spectrum\n  {groups}; {}", self.spectrum)?;
        for (i, layer) in self.layers.iter().enumerate() {
            writeln!(f, "layer {} of bodies (rate {:?})", i + 1, layer.rate)?;
            writeln!(
                f,
                "  porosity {:.3} with lumens, S_V {:.4} /um, mean chord of pores and lumens {:.2} um, mean free path \
                 in the pores across the sheet {:.2} um",
                layer.porosity,
                layer.surface(),
                4.0 * layer.porosity / layer.surface(),
                layer.free_path_vertical
            )?;
            for c in &layer.components {
                writeln!(
                    f,
                    "  {:<24} {:6.2} g/m2 realised, {:.2} before overlaps, solid {:.4}, body {:.4}, surface {:.4} /um, \
                     density {:.4e}",
                    c.name, c.grammage, c.nominal, c.solid, c.body, c.surface, c.density
                )?;
                if let Some(coarseness) = c.coarseness {
                    writeln!(
                        f,
                        "  {:<24} wall area {:.1} um2, coarseness {:.3} mg/m",
                        "", c.solid_content, coarseness
                    )?;
                }
            }
        }
        for r in &self.remarks {
            writeln!(f, "note: {r}")?;
        }
        Ok(())
    }
}
