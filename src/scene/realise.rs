//! Statistical sheets realised body by body.

use super::deposit;
use super::media::Media;
use super::model::{Edges, Realised, Scene, StartIn};
use super::statistical::{LayerReport, clear_faces, populations};
use crate::universe::any::AnyUniverse;
use crate::universe::synthetic::drum::Entry;
use crate::universe::synthetic::realise::Boolean;

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
    let (model, reports) = model(realised, scene, media)?;
    let from_pores = sheet.edges == Edges::Cut && sheet.start == StartIn::Pore;
    let entry = Entry { spread: realised.spread, from_pores };
    let drum = model.ensemble(scene.run.seed, entry).map_err(|e| e.to_string())?;
    let notes = vec![
        format!(
            "realisations of the Boolean (Poisson) ensemble, one for every {} histories: their mean is what \
             memory=\"full\" gives",
            scene.run.shared
        ),
        drum.describe_search(),
    ];
    Ok((AnyUniverse::Realised(drum), model.sheet[1], reports, notes))
}

/// The Boolean sheet, and its report.
///
/// # Errors
/// As [`build`].
pub fn model(
    realised: &Realised,
    scene: &Scene,
    media: &mut Media,
) -> Result<(Boolean, Vec<LayerReport>), String> {
    let sheet = &realised.sheet;
    let (mut layers, reports) = populations(sheet, scene, media)?;
    let layer = match layers.pop() {
        Some(layer) if layers.is_empty() && !layer.kinds.is_empty() => layer,
        _ => {
            return Err(
                "realisations have one layer of bodies; kind=\"statistical\" takes several".to_owned()
            );
        }
    };
    if clear_faces(sheet, scene) != [true; 2] {
        return Err("the faces of a realised sheet have no surface of their own: the pores must have the \
                    refractive index of what is outside, and the layer no `surface`; kind=\"statistical\" \
                    takes both"
            .to_owned());
    }
    let model = Boolean {
        kinds: layer.kinds,
        density: layer.density,
        sheet: [layer.slab.bottom, layer.slab.top],
        pore: layer.slab.pore,
        overlap: sheet.overlap,
        contained: sheet.edges == Edges::Contained,
    };
    Ok((model, reports))
}
