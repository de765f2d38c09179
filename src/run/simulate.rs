//! Runs a scene: every wavelength group through its universe, results side by side.

use super::{Histories, run_group};
use crate::lpm::{LANES, World, look};
use crate::math::{DVec3, cos};
use crate::sap::Healpix;
use crate::scene::plan::Plan;
use crate::scene::{Branching, OpticsGeometry, PaperOptics, Scene, Universe as Where, optics};
use crate::source::Source;
use crate::stats::{Fold, Moments};
use crate::tally::detectors::{self, Aperture, Flight, Lateral};
use crate::tally::layout::Depth;
use crate::tally::{Cell, Detectors, Layout, Node, View};
use crate::universe::Universe;
use crate::universe::any::AnyUniverse;

/// Results of one wavelength group.
#[derive(Clone, Debug)]
pub struct GroupResult {
    /// nm.
    pub wavelengths: Vec<f64>,
    /// Sums.
    pub node: Node,
    /// Cells.
    pub layout: Layout,
}

impl GroupResult {
    /// Moments of a cell at the group's `lane`-th wavelength.
    pub fn moments(&self, cell: usize, lane: usize) -> Moments {
        self.node.moments(cell, lane, self.layout.lanes)
    }
}

/// Results of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// One per wavelength group, in the plan's order.
    pub groups: Vec<GroupResult>,
    /// Histories per group that were asked for.
    pub histories: u64,
    /// All histories were run.
    pub complete: bool,
}

impl Outcome {
    /// (wavelength, group, lane) over all wavelengths.
    pub fn wavelengths(&self) -> impl Iterator<Item = (f64, &GroupResult, usize)> {
        self.groups.iter().flat_map(|g| g.wavelengths.iter().enumerate().map(move |(i, &w)| (w, g, i)))
    }

    /// Histories with lost power, and with power cut by the event cap.
    pub fn troubled(&self) -> (u64, u64) {
        self.groups.iter().fold((0, 0), |(l, c), g| (l + g.node.lost, c + g.node.capped))
    }

    /// Worst |1 − ledger| of any history.
    pub fn worst_imbalance(&self) -> f64 {
        self.groups.iter().map(|g| g.node.worst_imbalance).fold(0.0, f64::max)
    }

    /// Events over all groups.
    pub fn events(&self) -> u64 {
        self.groups.iter().map(|g| g.node.events).sum()
    }
}

/// How far a run is.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Histories finished, over all groups.
    pub done: u64,
    /// Histories asked for, over all groups.
    pub total: u64,
    /// Reflected share so far of the group under way (its first wavelength), with standard error.
    pub reflectance: (f64, f64),
}

/// Runs all histories of a scene on rayon's current threads.
///
/// # Errors
/// Optical constants that are missing at a wavelength, SAPs that cannot be made.
pub fn simulate(
    scene: &Scene,
    plan: &Plan,
    mut progress: impl FnMut(Progress) -> bool,
) -> Result<Outcome, String> {
    let mut groups = Vec::new();
    let total = scene.run.histories * plan.groups.len() as u64;
    let mut complete = true;
    for (index, wavelengths) in plan.groups.iter().enumerate() {
        let before = scene.run.histories * index as u64;
        let mut tell = |fold: &Fold<Node>, done: u64, layout: &Layout| {
            let now = fold.peek().map_or((0.0, f64::NAN), |n| {
                let m = n.moments(layout.of(Cell::Reflected), 0, layout.lanes);
                (m.mean(), m.standard_error())
            });
            progress(Progress { done: before + done, total, reflectance: now })
        };
        let group = index as u64;
        let result = match (&plan.universe, wavelengths.len()) {
            (AnyUniverse::Statistical(u), 1) => one::<_, 1>(scene, plan, u, wavelengths, group, &mut tell),
            (AnyUniverse::Statistical(u), _) => {
                one::<_, LANES>(scene, plan, u, wavelengths, group, &mut tell)
            }
            (AnyUniverse::Lazy(u), 1) => one::<_, 1>(scene, plan, u, wavelengths, group, &mut tell),
            (AnyUniverse::Lazy(u), _) => one::<_, LANES>(scene, plan, u, wavelengths, group, &mut tell),
            (AnyUniverse::Mixture(u), 1) => one::<_, 1>(scene, plan, u, wavelengths, group, &mut tell),
            (AnyUniverse::Mixture(u), _) => one::<_, LANES>(scene, plan, u, wavelengths, group, &mut tell),
            (AnyUniverse::Synthetic(u), 1) => one::<_, 1>(scene, plan, u, wavelengths, group, &mut tell),
            (AnyUniverse::Synthetic(u), _) => one::<_, LANES>(scene, plan, u, wavelengths, group, &mut tell),
            (AnyUniverse::Voxel(u), 1) => one::<_, 1>(scene, plan, u, wavelengths, group, &mut tell),
            (AnyUniverse::Voxel(u), _) => one::<_, LANES>(scene, plan, u, wavelengths, group, &mut tell),
        }?;
        complete &= result.node.histories == scene.run.histories;
        groups.push(result);
        if !complete {
            break;
        }
    }
    Ok(Outcome { groups, histories: scene.run.histories, complete })
}

/// One group in one universe.
fn one<U: Universe, const N: usize>(
    scene: &Scene,
    plan: &Plan,
    universe: &U,
    wavelengths: &[f64],
    group: u64,
    tell: &mut impl FnMut(&Fold<Node>, u64, &Layout) -> bool,
) -> Result<GroupResult, String> {
    let light = optics::light::<N>(scene, &plan.media, wavelengths)?;
    let layout = layout(scene, plan, wavelengths)?;
    let split = match scene.run.branching {
        Branching::Split { nside, floor } => Some(optics::split(&light, nside, floor)?),
        Branching::Sample => None,
    };
    let world = World {
        universe,
        light: &light,
        roulette: scene.run.roulette,
        event_cap: scene.run.event_cap,
        split: split.as_ref(),
        pile: scene.optics.as_ref().map_or(1, |o| o.pile),
        gap: scene.optics.as_ref().and_then(|o| o.backing),
        top: plan.top,
        bottom: plan.bottom,
        backing: backing(scene),
        analog: !scene.run.implicit_capture,
    };
    let histories = Histories { seed: scene.run.seed, group, count: scene.run.histories };
    let node = run_group(&world, &plan.source, &layout, histories, |fold, done| tell(fold, done, &layout));
    Ok(GroupResult { wavelengths: wavelengths.to_vec(), node, layout })
}

fn backing(scene: &Scene) -> Option<f64> {
    match &scene.universe {
        Where::Statistical(sheet) => sheet.backing,
        Where::Mixture(mixture) => mixture.backing,
        Where::Synthetic(_) | Where::Voxel(_) => None,
    }
}

/// The cells that the scene's detectors and figures need.
fn layout(scene: &Scene, plan: &Plan, wavelengths: &[f64]) -> Result<Layout, String> {
    let (lanes, nm) = (wavelengths.len(), wavelengths[0]);
    let view = scene.optics.as_ref().map(|o| view(o, &plan.source));
    let angular = scene.detect.angular.map(Healpix::new).transpose().map_err(|e| e.to_string())?;
    Ok(Layout {
        lanes,
        shared: scene.run.shared,
        media: plan.media.names.len(),
        angular,
        depth: scene.detect.depth.map(|bins| Depth { bins, top: plan.top, bottom: plan.bottom }),
        checkpoint: scene.detect.checkpoint,
        path: scene.detect.path,
        view,
        // A backing below a gap is counted as one more sheet.
        pile: scene.optics.as_ref().map_or(1, |o| if o.backing.is_some() { 2 } else { o.pile }),
        detectors: detectors(scene, plan, nm)?,
    })
}

/// How the instrument of the optical figures looks.
fn view(optics: &PaperOptics, source: &Source) -> View {
    match optics.geometry {
        OpticsGeometry::DiffuseNormal | OpticsGeometry::FortyFiveNormal => {
            View::Cone { cos: cos(optics.view) }
        }
        OpticsGeometry::NormalDiffuse | OpticsGeometry::EightDiffuse if optics.trap > 0.0 => {
            let light = travelling(source).unwrap_or(-DVec3::Z);
            let polar = optics.geometry.polar().unwrap_or(0.0);
            View::Beyond {
                axis: DVec3::new(light.x, light.y, -light.z),
                cos: cos(optics.trap),
                share: 1.0 - detectors::lambertian_in_cone(polar, optics.trap),
            }
        }
        _ => View::All,
    }
}

/// Direction of parallel light.
fn travelling(source: &Source) -> Option<DVec3> {
    match source {
        Source::Collimated { dir, .. } => Some(*dir),
        _ => None,
    }
}

/// Detectors that the scene asks for; the time of flight is that of the wavelength `nm`.
fn detectors(scene: &Scene, plan: &Plan, nm: f64) -> Result<Detectors, String> {
    let asked = &scene.detect;
    let mut apertures = Vec::new();
    if let Some(light) = travelling(&plan.source) {
        apertures.extend(asked.gloss.map(|(opening, across)| Aperture::gloss(light, opening, across)));
        apertures.extend(asked.haze.map(|angle| Aperture::haze(light, angle)));
    }
    let flight = match asked.flight {
        Some((longest, bins)) => {
            Some(Flight { longest, bins, group_index: optics::group_indices(scene, &plan.media, nm)? })
        }
        None => None,
    };
    let screen = |h: &crate::scene::Halftone| detectors::Halftone {
        coverage: h.coverage,
        period: h.period,
        ink: h.ink,
    };
    Ok(Detectors {
        apertures,
        lateral: asked.lateral.map(|(radius, rings)| Lateral::new(radius, rings)),
        halftones: asked.halftones.iter().map(screen).collect(),
        flight,
        views: asked.views.iter().map(|(polar, azimuth)| look::eye(*polar, *azimuth)).collect(),
        klems: asked.klems,
        faces: (plan.top, plan.bottom),
    })
}
