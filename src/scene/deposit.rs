//! Sheets whose fibres fall one by one.

use super::media::Media;
use super::model::{Amount, Component, Depositing, Layer, Scene, Shape, StatisticalSheet};
use super::statistical::{ComponentReport, LayerReport, clear_faces, kind};
use crate::law::{Roll, Tilt};
use crate::universe::any::AnyUniverse;
use crate::universe::deposit::{self, Deposit, Deposited, Figures, Sought};
use crate::universe::statistical::amount::coverage;
use crate::universe::statistical::kind::Kind;
use crate::universe::synthetic::SyntheticUniverse;

/// Histories that meet the same realisation in succession: a batch.
const BATCH: u64 = 4096;
/// Realisations by which the pressing is found.
const TRIAL: u64 = 2;

/// The realisations, the height of the upper plane (µm), what they came to, and what `plan` says of it.
///
/// # Errors
/// Sheets that cannot be deposited, and what to do.
pub fn build(
    how: &Depositing,
    sheet: &StatisticalSheet,
    scene: &Scene,
    media: &mut Media,
) -> Result<(AnyUniverse, f64, Vec<LayerReport>, Vec<String>), String> {
    let (model, layer) = model(how, sheet, scene, media)?;
    let universe = Deposited::new(&model, scene.run.seed, how.realisations, BATCH, how.gap)
        .map_err(|e| format!("layer 1: {}", advice(&e)))?;
    let mean = mean(universe.figures());
    let notes = notes(how, layer, &model, &universe, &mean);
    let report = report(layer, &model, &universe, &mean);
    let top = universe.top();
    Ok((AnyUniverse::Ensemble(universe.into_ensemble()), top, vec![report], notes))
}

/// One realisation alone, of (seed, number), in a cell of its own edge (µm) if one is given; and its planes.
///
/// # Errors
/// As [`build`].
pub fn one(
    how: &Depositing,
    sheet: &StatisticalSheet,
    scene: &Scene,
    media: &mut Media,
    [seed, number]: [u64; 2],
    cell: Option<f64>,
) -> Result<(SyntheticUniverse, [f64; 2]), String> {
    let how = Depositing { cell: cell.unwrap_or(how.cell), ..*how };
    let (model, _) = model(&how, sheet, scene, media)?;
    let laid = model.lay(seed, number).map_err(|e| advice(&e))?;
    model.met(&laid).map_err(|e| advice(&e))?;
    let top = laid.top + deposit::CLEAR;
    Ok((model.universe(&laid, top).map_err(|e| advice(&e))?, [0.0, top]))
}

/// The sheet to be deposited, its pressing settled, and its layer.
fn model<'a>(
    how: &Depositing,
    sheet: &'a StatisticalSheet,
    scene: &Scene,
    media: &mut Media,
) -> Result<(Deposit, &'a Layer), String> {
    let [layer] = sheet.layers.as_slice() else {
        return Err("a deposited sheet has one layer of bodies".to_owned());
    };
    if layer.components.is_empty() || layer.grace.is_some() {
        return Err("a deposited sheet has one layer of bodies, and no <free-path>".to_owned());
    }
    if clear_faces(sheet, scene) != [true; 2] {
        return Err("the faces of a deposited sheet have no surface of their own: the pores must have the \
                    refractive index of what is outside, and the layer no `surface`"
            .to_owned());
    }
    if let Some(c) = layer.components.iter().find(|c| c.profile.is_some()) {
        return Err(format!("'{}': a <profile> over depth does not go with fibres that fall", c.name));
    }
    let laid: Vec<Component> = layer.components.iter().map(with_ends).collect();
    let kinds: Vec<Kind> = laid.iter().enumerate().map(|(i, c)| kind(c, i, media)).collect();
    let mut model = Deposit {
        kinds,
        amounts: laid.iter().map(|c| amount(c, layer.thickness)).collect(),
        pore: layer.pore,
        cell: how.cell,
        flexibility: how.flexibility,
        pressing: how.pressing.unwrap_or(1.0),
        places: how.places,
    };
    if how.pressing.is_none() {
        model = model
            .to_thickness(layer.thickness, Sought::Pressing, scene.run.seed, TRIAL.min(how.realisations))
            .map_err(|e| advice(&e))?;
    }
    Ok((model, layer))
}

/// The same component with the ends that its length says.
fn with_ends(c: &Component) -> Component {
    let mut c = c.clone();
    if let Shape::Fibre { finite, .. } = &mut c.shape {
        *finite = true;
    }
    c
}

/// Amounts over area; 1 g/m² over 1 kg/m³ is 1000 µm.
fn amount(c: &Component, thickness: f64) -> deposit::Amount {
    match c.amount {
        Amount::Grammage(g) => deposit::Amount::Solid(g / c.density * 1e3),
        Amount::LengthDensity(x) => deposit::Amount::Length(x * thickness),
        Amount::NumberDensity(x) => deposit::Amount::Number(x * thickness),
        Amount::VolumeFraction(f) => deposit::Amount::Body(f * thickness),
    }
}

fn advice(e: &deposit::DepositError) -> String {
    match e {
        deposit::DepositError::Thickness { .. } => format!(
            "{e}; another `thickness`, more `places`, or a `pressing` of one's own and the thickness that it gives"
        ),
        _ => e.to_string(),
    }
}

fn mean(all: &[Figures]) -> Figures {
    let of = |f: fn(&Figures) -> f64| all.iter().map(f).sum::<f64>() / all.len() as f64;
    let most = |f: fn(&Figures) -> f64| all.iter().map(f).fold(0.0, f64::max);
    Figures {
        thickness: of(|f| f.thickness),
        between_plates: of(|f| f.between_plates),
        solid: of(|f| f.solid),
        body: of(|f| f.body),
        porosity: of(|f| f.porosity),
        surface: of(|f| f.surface),
        bonded: of(|f| f.bonded),
        overlap: most(|f| f.overlap),
        sharpest: most(|f| f.sharpest),
        coverage: of(|f| f.coverage),
        covered: of(|f| f.covered),
        pieces: all.iter().map(|f| f.pieces).sum::<usize>() / all.len(),
    }
}

/// Grammage of component `i` per realisation, g/m².
fn grammage(layer: &Layer, universe: &Deposited, i: usize) -> f64 {
    universe.solids()[i] * layer.components[i].density * 1e-3
}

fn notes(how: &Depositing, layer: &Layer, model: &Deposit, u: &Deposited, f: &Figures) -> Vec<String> {
    let total: f64 = (0..layer.components.len()).map(|i| grammage(layer, u, i)).sum();
    let spread = {
        let n = u.figures().len() as f64;
        let square = u.figures().iter().map(|x| (x.thickness - f.thickness).powi(2)).sum::<f64>();
        (square / (n - 1.0).max(1.0)).sqrt()
    };
    let mut out = vec![
        format!(
            "deposited: {} realisations in a periodic cell of {:.0} um, flexibility {}, pressing {:.4}{}, {} places per \
             fibre; histories meet them in turn, batch by batch, and intervals count realisations",
            how.realisations,
            model.cell,
            model.flexibility,
            model.pressing,
            if how.pressing.is_none() { " (found)" } else { "" },
            model.places
        ),
        format!(
            "deposited: {total:.2} g/m2, mean thickness {:.2} um ({:.2} um between realisations, {:.1} um between \
             plates), density {:.0} kg/m3, porosity {:.4}, S_V {:.4} /um, coverage {:.2}, {:.2} % of the area open",
            f.thickness,
            spread,
            f.between_plates,
            1e3 * total / f.thickness,
            f.porosity,
            f.surface,
            f.coverage,
            100.0 * (1.0 - f.covered)
        ),
        format!(
            "deposited: {:.2} % of the fibres' surface has another body within {} um (relative bonded area; fibres \
             touch in points and lines, optical contact over areas is not modelled); volume in two bodies {:.1e}; \
             sharpest bend between two pieces {:.1} deg",
            100.0 * f.bonded,
            how.gap,
            f.overlap,
            f.sharpest.to_degrees()
        ),
        format!(
            "deposited: {} pieces of fibre per realisation, {} MB in all; {}",
            f.pieces,
            u.bytes() >> 20,
            u.sheets()[0].describe_search()
        ),
    ];
    if how.pressing.is_some() && (f.thickness / layer.thickness - 1.0).abs() > 0.01 {
        out.push(format!(
            "warning: the sheet came out {:.2} um thick, not {:.2} um: without `pressing` it is found",
            f.thickness, layer.thickness
        ));
    }
    let fibre = |c: &&Component| matches!(c.shape, Shape::Fibre { .. });
    if let Some(c) = layer.components.iter().filter(fibre).find(|c| c.tilt != Tilt::InPlane) {
        out.push(format!(
            "warning: the tilt of '{}' says nothing here: fibres bend over what lies below",
            c.name
        ));
    }
    if let Some(c) = layer.components.iter().filter(fibre).find(|c| c.roll != Roll::Flat) {
        out.push(format!(
            "warning: the roll of '{}' says nothing here: fibres fall on their flat side",
            c.name
        ));
    }
    if u.cut() > 0 {
        out.push(format!(
            "deposited: {} fibres of all realisations are longer than three cells and are cut there; a larger `cell` cuts fewer",
            u.cut()
        ));
    }
    out
}

fn report(layer: &Layer, model: &Deposit, u: &Deposited, f: &Figures) -> LayerReport {
    let components = (layer.components.iter().zip(&model.kinds).enumerate())
        .map(|(i, (c, kind))| {
            let cover = coverage(kind, layer.thickness, false);
            let share = u.solids()[i] / f.thickness;
            let number = share / cover.solid;
            ComponentReport {
                name: c.name.clone(),
                solid: share,
                body: number * cover.content,
                grammage: grammage(layer, u, i),
                density: number,
                nominal: grammage(layer, u, i),
                // As the solid is shared: bodies as drawn; the sum over components is the measured surface.
                surface: f.surface * u.solids()[i] / f.solid,
                solid_content: cover.solid,
                coarseness: matches!(c.shape, Shape::Fibre { .. }).then_some(c.density * cover.solid * 1e-6),
            }
        })
        .collect();
    LayerReport {
        components,
        porosity: f.porosity,
        // Shadows of fibres over the pores' height.
        free_path_vertical: (f.thickness - f.body) / f.coverage.max(1e-12),
        rate: super::model::Rate::Matched,
    }
}
