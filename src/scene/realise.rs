//! Statistical sheets realised body by body.

use super::deposit;
use super::media::Media;
use super::model::{Edges, Realised, Scene, StartIn, StatisticalSheet};
use super::statistical::{LayerReport, clear_faces, populations};
use crate::universe::SurfaceId;
use crate::universe::any::AnyUniverse;
use crate::universe::statistical::Population;
use crate::universe::synthetic::drum::Entry;
use crate::universe::synthetic::realise::Boolean;
use crate::universe::synthetic::stack::{Faces, Layer, Stack};

/// The ensemble of realisations, its thickness (µm), its reports and what `plan` says of it.
///
/// # Errors
/// Amounts that cannot be; sheets that cannot be realised, and what to do.
pub fn build(
    realised: &Realised,
    scene: &Scene,
    media: &mut Media,
) -> Result<(AnyUniverse, f64, Vec<LayerReport>, Vec<String>), String> {
    let sheet = &realised.sheet;
    if let Some(how) = &realised.deposit {
        return deposit::build(how, sheet, scene, media);
    }
    let (layers, reports) = layers(sheet, scene, media)?;
    let from_pores = sheet.edges == Edges::Cut && sheet.start == StartIn::Pore;
    let entry = Entry { spread: realised.spread, from_pores };
    let mut notes = vec![format!(
        "realisations of the Boolean (Poisson) ensemble, one for every {} histories: their mean is what \
         memory=\"full\" gives",
        scene.run.shared
    )];
    let top = layers.first().map_or(0.0, |l| l.slab.top);
    if let (true, Some(model)) = (clear_faces(sheet, scene) == [true; 2], only(&layers)) {
        let drum = model.ensemble(scene.run.seed, entry).map_err(|e| e.to_string())?;
        notes.push(drum.describe_search());
        return Ok((AnyUniverse::Realised(drum), top, reports, notes));
    }
    let faces = Faces {
        outside: sheet.outside,
        bottom_surface: SurfaceId::SMOOTH,
        open: super::statistical::open_faces(sheet, scene),
    };
    let stack = Stack::ensemble(&layers, faces, scene.run.seed, entry).map_err(|e| e.to_string())?;
    for (i, (_, drum)) in stack.layers().enumerate() {
        notes.extend(drum.map(|d| format!("layer {}: {}", i + 1, d.describe_search())));
    }
    Ok((AnyUniverse::Stack(stack), top, reports, notes))
}

/// The layers, and the reports of those with bodies.
fn layers(
    sheet: &StatisticalSheet,
    scene: &Scene,
    media: &mut Media,
) -> Result<(Vec<Layer>, Vec<LayerReport>), String> {
    let (populations, reports) = populations(sheet, scene, media)?;
    let layer = |p: Population| {
        let slab = p.slab;
        let bodies = (!p.kinds.is_empty()).then(|| Boolean {
            kinds: p.kinds,
            density: p.density,
            sheet: [slab.bottom, slab.top],
            pore: slab.pore,
            overlap: sheet.overlap,
            contained: sheet.edges == Edges::Contained,
        });
        Layer { slab, bodies }
    };
    Ok((populations.into_iter().map(layer).collect(), reports))
}

/// The bodies of a sheet of one layer.
fn only(layers: &[Layer]) -> Option<&Boolean> {
    match layers {
        [one] => one.bodies.as_ref(),
        _ => None,
    }
}

/// The layers of a sheet that a `<cell>` can hold, top to bottom: bodies between common pores, and homogeneous
/// slabs.
///
/// # Errors
/// As [`build`]; bodies that reach through an inner plane, pores of several media, planes and faces with a
/// surface of their own where bodies are.
pub fn plies(realised: &Realised, scene: &Scene, media: &mut Media) -> Result<Vec<Layer>, String> {
    const INSTEAD: &str = "kind=\"synthetic\" with the <sheet> itself takes it";
    let sheet = &realised.sheet;
    let (layers, _) = layers(sheet, scene, media)?;
    let porous: Vec<&Layer> = layers.iter().filter(|l| l.bodies.is_some()).collect();
    let index = |m: crate::universe::MediumId| &scene.materials[usize::from(m.0)].index;
    if porous.is_empty() {
        return Err("no layer holds bodies: a <sheet> of homogeneous layers is explicit already".to_owned());
    }
    if porous.iter().any(|l| index(l.slab.pore) != index(sheet.outside)) {
        return Err(format!(
            "the pores of a <cell> are the medium outside, or one of its refractive index; {INSTEAD}"
        ));
    }
    if porous.iter().any(|l| l.slab.pore != porous[0].slab.pore) {
        return Err(format!(
            "a <cell> has one medium between its bodies, these layers have several; {INSTEAD}"
        ));
    }
    if layers.len() > 1 && porous[0].slab.pore != sheet.outside {
        return Err(format!("the pores of several layers in a <cell> are the medium outside; {INSTEAD}"));
    }
    if layers.len() > 1 && sheet.edges == Edges::Cut {
        return Err(format!(
            "bodies of a <cell> are not cut at inner planes: edges=\"contained\"; {INSTEAD}"
        ));
    }
    if layers.iter().any(|l| l.slab.surface != SurfaceId::SMOOTH) {
        return Err(format!("the planes of layers have no `surface` of their own in a <cell>; {INSTEAD}"));
    }
    Ok(layers)
}
