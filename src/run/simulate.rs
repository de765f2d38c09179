//! Runs a scene: every wavelength group through its universe, results side by side.

use super::batch::{Batches, Traced};
use super::replay::Trail;
use super::sums::{Sums, Troubled};
use super::workers::{Fault, Watch, work};
use super::{BATCH, Histories};
use crate::lpm::split::Split;
use crate::lpm::{Full, History, LANES, Light, World, look};
use crate::math::{DVec3, cos};
use crate::rng::{self, Generator};
use crate::sap::Healpix;
use crate::scene::effects::Kind;
use crate::scene::plan::Plan;
use crate::scene::{Branching, OpticsGeometry, PaperOptics, Scene, Universe as Where, full, optics};
use crate::source::Source;
use crate::stats::{Fold, Moments};
use crate::tally::detectors::{self, Aperture, Flight, Lateral};
use crate::tally::layout::Depth;
use crate::tally::{Cell, Detectors, Layout, Node, View};
use crate::universe::Universe;
use crate::universe::any::AnyUniverse;
use std::fmt;
use std::ops::Range;
use std::sync::atomic::AtomicU64;

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
    /// The first histories that went wrong.
    pub troubled: Vec<Troubled>,
}

impl GroupResult {
    /// Moments of a cell at the group's `lane`-th wavelength.
    pub fn moments(&self, cell: usize, lane: usize) -> Moments {
        let lanes = self.layout.lanes;
        let own = self.node.moments(cell, lane, lanes);
        match self.layout.realisations {
            // Of what nothing was counted, the histories tell how rare it is, not the realisations.
            Some(_) if self.node.replicas.len() > 1 && own.mean() != 0.0 => {
                self.node.by_replica(cell, lane, lanes)
            }
            _ => own,
        }
    }

    /// Standard deviation between realisations of the reflectance (`side` 0) or transmittance (1), and its
    /// error. `None` where histories share none.
    pub fn between(&self, side: usize, lane: usize) -> Option<(f64, f64)> {
        let cell = self.layout.of([Cell::Reflected, Cell::Transmitted][side]);
        let own = self.node.sums[cell * self.layout.lanes + lane][1];
        let squares = if self.layout.shared > 1 { self.node.single[lane][side] } else { own };
        self.node.between(&self.moments(cell, lane), squares)
    }
}

/// Results of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// One per wavelength group, in the plan's order; all with the same number of histories. Empty if not
    /// one batch of each was finished.
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

    /// Histories run, over all groups.
    pub fn done(&self) -> u64 {
        self.groups.iter().map(|g| g.node.histories).sum()
    }
}

/// How far a run is.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Histories finished, over all groups.
    pub done: u64,
    /// Histories asked for, over all groups.
    pub total: u64,
    /// Reflected share so far at the first wavelength, with standard error.
    pub reflectance: (f64, f64),
}

/// Why a run has no result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// The scene: missing constants, SAPs that cannot be made.
    Input(String),
    /// The program.
    Fault(Fault),
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Trouble::Input(text) => f.write_str(text),
            Trouble::Fault(fault) => fault.fmt(f),
        }
    }
}

/// A wavelength group made ready: what its batches need, owned.
struct Ready<'a, U: Universe, const N: usize> {
    scene: &'a Scene,
    plan: &'a Plan,
    universe: &'a U,
    light: Light<N>,
    split: Option<Split>,
    full: Option<Full<N>>,
    layout: Layout,
    histories: Histories,
}

/// What a run asks of a group, whatever its universe and lanes.
pub(super) trait Group: Batches {
    fn layout(&self) -> &Layout;
    /// Traces the history `number` and tells everything that happens to it.
    fn replay(&self, number: u64, trail: &mut Trail);
}

impl<U: Universe, const N: usize> Ready<'_, U, N> {
    fn traced<T>(&self, what: impl FnOnce(&Traced<U, N>) -> T) -> T {
        let world = World {
            universe: self.universe,
            light: &self.light,
            roulette: self.scene.run.roulette,
            event_cap: self.scene.run.event_cap,
            split: self.split.as_ref(),
            pile: self.scene.optics.as_ref().map_or(1, |o| o.pile),
            gap: self.scene.optics.as_ref().and_then(|o| o.backing),
            top: self.plan.top,
            bottom: self.plan.bottom,
            backing: backing(self.scene),
            analog: !self.scene.run.implicit_capture,
            full: self.full.as_ref(),
        };
        what(&Traced {
            world: &world,
            source: &self.plan.source,
            layout: &self.layout,
            histories: self.histories,
            batch: self.scene.run.batch,
            generator: self.scene.run.generator,
        })
    }
}

impl<U: Universe, const N: usize> Batches for Ready<'_, U, N> {
    fn batch(&self, index: u64, now: &AtomicU64) -> Sums {
        self.traced(|t| t.batch(index, now))
    }
}

impl<U: Universe, const N: usize> Group for Ready<'_, U, N> {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn replay(&self, number: u64, trail: &mut Trail) {
        self.traced(|t| {
            let mut h: History<U, N> = History::default();
            // Histories before it in the same realisation have met some of its bodies.
            for number in number - number % self.layout.shared..=number {
                trail.begin();
                t.history(number, &mut h, trail);
            }
            trail.end(&h.ledger, h.events);
        });
    }
}

/// Makes every wavelength group of a plan ready.
pub(super) fn groups<'a>(scene: &'a Scene, plan: &'a Plan) -> Result<Vec<Box<dyn Group + 'a>>, String> {
    (0..plan.groups.len()).map(|index| group(scene, plan, index)).collect()
}

/// Makes one wavelength group ready.
pub(super) fn group<'a>(
    scene: &'a Scene,
    plan: &'a Plan,
    index: usize,
) -> Result<Box<dyn Group + 'a>, String> {
    if scene.run.generator != Generator::default() && !rng::SWAPS {
        return Err("this program was built without a second generator: \
                    cargo build --release --features philox"
            .to_owned());
    }
    let (w, g) = (plan.groups[index].as_slice(), index as u64);
    match &plan.universe {
        AnyUniverse::Statistical(u) => lanes(scene, plan, u, w, g),
        AnyUniverse::Lazy(u) => lanes(scene, plan, u, w, g),
        AnyUniverse::Mixture(u) => lanes(scene, plan, u, w, g),
        AnyUniverse::Synthetic(u) => lanes(scene, plan, u, w, g),
        AnyUniverse::Ensemble(u) => lanes(scene, plan, u, w, g),
        AnyUniverse::Realised(u) => lanes(scene, plan, u, w, g),
        AnyUniverse::Stack(u) => lanes(scene, plan, u, w, g),
        AnyUniverse::Topography(u) => lanes(scene, plan, u, w, g),
        AnyUniverse::Voxel(u) => lanes(scene, plan, u, w, g),
    }
}

fn lanes<'a, U: Universe>(
    scene: &'a Scene,
    plan: &'a Plan,
    universe: &'a U,
    wavelengths: &[f64],
    group: u64,
) -> Result<Box<dyn Group + 'a>, String> {
    Ok(if wavelengths.len() == 1 && !plan.full {
        Box::new(one::<U, 1>(scene, plan, universe, wavelengths, group)?)
    } else {
        Box::new(one::<U, LANES>(scene, plan, universe, wavelengths, group)?)
    })
}

fn one<'a, U: Universe, const N: usize>(
    scene: &'a Scene,
    plan: &'a Plan,
    universe: &'a U,
    wavelengths: &[f64],
    group: u64,
) -> Result<Ready<'a, U, N>, String> {
    let light = optics::light::<N>(scene, &plan.media, wavelengths)?;
    let split = match scene.run.branching {
        Branching::Split { nside, floor } => Some(optics::split(&light, nside, floor)?),
        Branching::Sample => None,
    };
    let full = plan.full.then(|| full::full(scene, plan, wavelengths, group as usize)).transpose()?;
    let layout = layout(scene, plan, wavelengths)?;
    let histories = Histories { seed: scene.run.seed, group, count: scene.run.histories };
    Ok(Ready { scene, plan, universe, light, split, full, layout, histories })
}

/// Sums of a run so far, a fold per wavelength group.
pub type State = Vec<Fold<Sums>>;

/// The state of a run of the histories from `first` on (a multiple of [`BATCH`]), before its first batch.
pub fn fresh(plan: &Plan, first: u64) -> State {
    plan.groups.iter().map(|_| Fold::starting_at(first / BATCH)).collect()
}

/// Runs all histories of a scene on rayon's current threads.
///
/// # Errors
/// Optical constants that are missing at a wavelength, SAPs that cannot be made; a worker that panics.
pub fn simulate(
    scene: &Scene,
    plan: &Plan,
    mut progress: impl FnMut(Progress) -> bool + Send,
) -> Result<Outcome, Trouble> {
    let mut state = fresh(plan, 0);
    let all = 0..scene.run.histories;
    let mut round = |s: &[Fold<Sums>]| progress(Progress::of(s, &all, scene.run.histories));
    let watch = Watch { stop: &|| false, round: &mut round };
    advance(scene, plan, &mut state, all.clone(), watch)?;
    outcome(scene, plan, state, all).map_err(Trouble::Input)
}

/// Runs what is missing in `state` of the histories `range`, until the watch stops it.
///
/// # Errors
/// As [`simulate`]; a state that does not belong to the scene.
pub fn advance(
    scene: &Scene,
    plan: &Plan,
    state: &mut State,
    range: Range<u64>,
    watch: Watch<'_>,
) -> Result<(), Trouble> {
    let groups = groups(scene, plan).map_err(Trouble::Input)?;
    let fits = groups.len() == state.len()
        && state.iter().all(|f| f.next() == state[0].next())
        && groups.iter().zip(state.iter()).all(|(g, f)| fits(g.layout(), f));
    if !fits {
        return Err(Trouble::Input("the stored sums do not belong to this scene".to_owned()));
    }
    let batches: Vec<&dyn Batches> = groups.iter().map(|g| -> &dyn Batches { &**g }).collect();
    work(&batches, state, range.end.div_ceil(scene.run.batch), watch).map_err(Trouble::Fault)
}

fn fits(layout: &Layout, fold: &Fold<Sums>) -> bool {
    let n = layout.cells() * layout.lanes;
    fold.nodes().iter().map(|node| &node.value.node).all(|node| {
        node.sums.len() == n
            && node.single.len() == layout.lanes
            && node.replicas.values().all(|(_, sums)| sums.len() == n)
    })
}

/// The results of a state of a run over `range`.
///
/// # Errors
/// Detectors that cannot be made.
pub fn outcome(scene: &Scene, plan: &Plan, state: State, range: Range<u64>) -> Result<Outcome, String> {
    let complete = state.iter().all(|f| f.next() == range.end.div_ceil(scene.run.batch));
    let mut groups = Vec::new();
    for (fold, wavelengths) in state.into_iter().zip(&plan.groups) {
        let layout = layout(scene, plan, wavelengths)?;
        if let Some(Sums { node, troubled }) = fold.finish() {
            let excited = plan.converts.then_some(groups.len());
            groups.push(GroupResult { wavelengths: wavelengths.clone(), node, layout, excited, troubled });
        }
    }
    Ok(Outcome { groups, histories: range.end - range.start, complete })
}

impl Progress {
    /// Progress of a state on its way through `range`, of a run of `histories`.
    pub fn of(state: &[Fold<Sums>], range: &Range<u64>, histories: u64) -> Progress {
        let groups = state.len() as u64;
        let done = state.first().map_or(0, |f| (f.next() * BATCH).min(histories) - range.start);
        let mut reflected = Moments::default();
        for node in state.iter().take(1).flat_map(Fold::nodes).map(|n| &n.value.node) {
            // The reflected cell is the first one, its first lane the first wavelength.
            let sums = node.sums.get(Cell::Reflected as usize).copied().unwrap_or_default();
            reflected.merge(&Moments::from_sums(node.samples, sums));
        }
        let reflectance = (reflected.mean(), reflected.standard_error());
        Progress { done: done * groups, total: (range.end - range.start) * groups, reflectance }
    }
}

fn backing(scene: &Scene) -> Option<f64> {
    match &scene.universe {
        Where::Statistical(sheet) => sheet.backing,
        Where::Realised(realised) => realised.sheet.backing,
        Where::Mixture(mixture) => mixture.backing,
        Where::Synthetic(_) | Where::Voxel(_) => None,
    }
}

/// The cells that the scene's detectors and figures need.
pub(super) fn layout(scene: &Scene, plan: &Plan, wavelengths: &[f64]) -> Result<Layout, String> {
    let (lanes, nm) = (wavelengths.len(), wavelengths[0]);
    let view = scene.optics.as_ref().map(|o| view(o, &plan.source));
    let angular = scene.detect.angular.map(Healpix::new).transpose().map_err(|e| e.to_string())?;
    Ok(Layout {
        lanes,
        shared: scene.run.shared,
        realisations: match &plan.universe {
            AnyUniverse::Ensemble(u) if u.cells().len() > 1 => Some(u.cells().len() as u64),
            _ => None,
        },
        media: plan.media.names.len(),
        angular,
        depth: scene.detect.depth.map(|bins| Depth { bins, top: plan.top, bottom: plan.bottom }),
        checkpoint: scene.detect.checkpoint,
        path: scene.detect.path,
        time: scene.has(Kind::Time),
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
