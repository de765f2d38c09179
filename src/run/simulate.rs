//! Runs a scene: every wavelength group through its universe, results side by side.

use super::{Histories, run_group};
use crate::lpm::{LANES, World};
use crate::math::cos;
use crate::sap::Healpix;
use crate::scene::effects::Kind;
use crate::scene::plan::Plan;
use crate::scene::{Branching, OpticsGeometry, Scene, Universe as Where, full, optics};
use crate::stats::{Fold, Moments};
use crate::tally::layout::Depth;
use crate::tally::{Cell, Layout, Node, View};
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
    /// Lane of the light that excites, where events change the wavelength.
    pub excited: Option<usize>,
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
    /// (wavelength, group, lane) over all wavelengths; where events change the wavelength, light that
    /// comes out as it went in.
    pub fn wavelengths(&self) -> impl Iterator<Item = (f64, &GroupResult, usize)> {
        let own = |g: &GroupResult, lane: usize| g.excited.is_none_or(|e| e == lane);
        self.groups.iter().flat_map(move |g| {
            let lanes = g.wavelengths.iter().enumerate().filter(move |(i, _)| own(g, *i));
            lanes.map(move |(i, &w)| (w, g, i))
        })
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
        let lanes = if plan.full { LANES } else { wavelengths.len() };
        let result = match (&plan.universe, lanes) {
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
    let layout = layout(scene, plan, wavelengths.len())?;
    let full = plan.full.then(|| full::full(scene, plan, wavelengths, group as usize)).transpose()?;
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
        pile: layout.pile,
        top: plan.top,
        bottom: plan.bottom,
        backing: backing(scene),
        analog: !scene.run.implicit_capture,
        full: full.as_ref(),
    };
    let histories = Histories { seed: scene.run.seed, group, count: scene.run.histories };
    let node = run_group(&world, &plan.source, &layout, histories, |fold, done| tell(fold, done, &layout));
    let excited = plan.converts.then_some(group as usize);
    Ok(GroupResult { wavelengths: wavelengths.to_vec(), node, layout, excited })
}

fn backing(scene: &Scene) -> Option<f64> {
    match &scene.universe {
        Where::Statistical(sheet) => sheet.backing,
        Where::Mixture(mixture) => mixture.backing,
        Where::Synthetic(_) | Where::Voxel(_) => None,
    }
}

/// The cells that the scene's detectors and figures need.
fn layout(scene: &Scene, plan: &Plan, lanes: usize) -> Result<Layout, String> {
    let view = scene.optics.as_ref().map(|o| match o.geometry {
        OpticsGeometry::Total => View::All,
        OpticsGeometry::DiffuseNormal => View::Cone { cos: cos(o.view) },
    });
    let angular = scene.detect.angular.map(Healpix::new).transpose().map_err(|e| e.to_string())?;
    Ok(Layout {
        lanes,
        shared: scene.run.shared,
        media: plan.media.names.len(),
        angular,
        depth: scene.detect.depth.map(|bins| Depth { bins, top: plan.top, bottom: plan.bottom }),
        checkpoint: scene.detect.checkpoint,
        path: scene.detect.path,
        time: scene.has(Kind::Time),
        view,
        pile: scene.optics.as_ref().map_or(1, |o| o.pile),
    })
}
