//! What is measured. Every tally is a set of cells; a history adds power to cells, and when it ends
//! the first four powers of what it scored in each cell go to the sums of its batch.

pub mod detectors;
pub mod klems;
pub mod layout;
pub mod node;

pub use detectors::Detectors;
pub use layout::{Cell, Layout};
pub use node::Node;

use crate::lpm::full::Extra;
use crate::lpm::ledger::{Ledger, add};
use crate::lpm::{Path, Scorer};
use crate::math::{DVec3, fast};
use crate::universe::{Face, Interface, Kept, MediumId};

/// Scores of one batch.
#[derive(Debug)]
pub struct Tally<'a, const N: usize> {
    layout: &'a Layout,
    /// More than totals is asked for of every step.
    steps: bool,
    /// Detectors hear what leaves.
    detects: bool,
    /// Events are counted, or looked from.
    events_heard: bool,
    /// Path (µm) and delay (µm of vacuum) of the present history so far, where asked for.
    flown: (f64, f64),
    /// Direction in which the present history entered, where asked for.
    entered: Option<DVec3>,
    /// Scores of the present history.
    now: Vec<Score<N>>,
    /// Cells that the present history has touched: the first `count`.
    touched: Vec<u32>,
    count: usize,
    /// Per cell: sums of w, w², w³, w⁴ over histories.
    sums: Vec<[[f64; N]; 4]>,
    histories: u64,
    events: u64,
    worst_imbalance: f64,
    lost: u64,
    capped: u64,
    /// Σw² of what single histories reflect and transmit, where several share a realisation.
    single: Vec<[f64; 2]>,
    before: [[f64; N]; 2],
    kept: Kept,
}

/// What the present history has scored in a cell.
#[derive(Clone, Debug)]
struct Score<const N: usize> {
    power: [f64; N],
    touched: bool,
}

impl<'a, const N: usize> Tally<'a, N> {
    /// Empty cells.
    pub fn new(layout: &'a Layout) -> Self {
        let n = layout.cells();
        Tally {
            layout,
            steps: layout.checkpoint.is_some()
                || layout.path
                || layout.depth.is_some()
                || layout.detectors.flight.is_some()
                || layout.detectors.klems,
            detects: !layout.detectors.is_empty(),
            events_heard: layout.path || !layout.detectors.views.is_empty(),
            flown: (0.0, 0.0),
            entered: None,
            now: vec![Score { power: [0.0; N], touched: false }; n],
            touched: vec![0; n + 1],
            count: 0,
            sums: vec![[[0.0; N]; 4]; n],
            histories: 0,
            events: 0,
            worst_imbalance: 0.0,
            lost: 0,
            capped: 0,
            single: vec![[0.0; 2]; layout.lanes],
            before: [[0.0; N]; 2],
            kept: Kept::default(),
        }
    }

    #[inline]
    fn score(&mut self, cell: usize, power: &[f64; N]) {
        let score = &mut self.now[cell];
        add(&mut score.power, power);
        // No branch: whether a cell is touched for the first time cannot be foreseen.
        self.touched[self.count] = cell as u32;
        self.count += usize::from(!score.touched);
        score.touched = true;
    }

    /// Ends a history: its ledger is checked and its scores go to the sums; `kept` is what the universe
    /// remembers of it.
    pub fn end_history(&mut self, ledger: &Ledger<N>, events: u64, kept: Kept) {
        self.histories += 1;
        self.events += events;
        self.flown = (0.0, 0.0);
        self.entered = None;
        if ledger.rare() {
            self.score_rare(ledger);
        }
        self.worst_imbalance = self.worst_imbalance.max(ledger.imbalance(self.layout.lanes));
        if self.layout.shared > 1 {
            self.note_single();
            if !self.histories.is_multiple_of(self.layout.shared) {
                return;
            }
            self.before = [[0.0; N]; 2];
        }
        self.kept.add(kept);
        // The mean of the histories that share a realisation is one sample.
        let share = 1.0 / self.layout.shared as f64;
        for &cell in &self.touched[..self.count] {
            let cell = cell as usize;
            let score = &mut self.now[cell];
            score.touched = false;
            let w = std::mem::replace(&mut score.power, [0.0; N]).map(|w| w * share);
            let sums = &mut self.sums[cell];
            for i in 0..N {
                let w2 = w[i] * w[i];
                sums[0][i] += w[i];
                sums[1][i] += w2;
                sums[2][i] += w2 * w[i];
                sums[3][i] += w2 * w2;
            }
        }
        self.count = 0;
    }

    /// Squares of what the history that ends has reflected and transmitted by itself.
    #[inline(never)]
    fn note_single(&mut self) {
        for (side, cell) in [Cell::Reflected, Cell::Transmitted].into_iter().enumerate() {
            let now = self.now[self.layout.of(cell)].power;
            for (lane, sums) in self.single.iter_mut().enumerate() {
                let w = now[lane] - self.before[side][lane];
                sums[side] += w * w;
            }
            self.before[side] = now;
        }
    }

    /// Entries of the ledger that most histories leave empty.
    #[inline(never)]
    fn score_rare(&mut self, ledger: &Ledger<N>) {
        let any = |w: &[f64; N]| w.iter().any(|&x| x != 0.0);
        for (cell, power) in [
            (Cell::Roulette, &ledger.roulette),
            (Cell::Masked, &ledger.masked),
            (Cell::Lost, &ledger.lost),
            (Cell::Truncated, &ledger.truncated),
            (Cell::Converted, &ledger.converted),
        ] {
            if any(power) {
                self.score(self.layout.of(cell), power);
            }
        }
        self.lost += u64::from(any(&ledger.lost));
        self.capped += u64::from(any(&ledger.truncated));
    }

    /// The batch's sums, as replica number `replica`.
    pub fn finish(self, replica: u8) -> Node {
        let lanes = self.layout.lanes;
        let mut sums = Vec::with_capacity(self.sums.len() * lanes);
        for cell in &self.sums {
            sums.extend((0..lanes).map(|lane| cell.map(|power| power[lane])));
        }
        let samples = self.histories / self.layout.shared;
        let node = Node::batch(replica, sums, samples);
        Node {
            histories: self.histories,
            events: self.events,
            worst_imbalance: self.worst_imbalance,
            lost: self.lost,
            capped: self.capped,
            single: self.single,
            kept: self.kept,
            ..node
        }
    }

    /// Checkpoint plane, path length and depth of a step.
    #[inline(never)]
    fn score_step<P>(&mut self, path: &Path<P, N>, distance: f64, mu_a: &[f64; N], absorbed: &[f64; N]) {
        if let Some(z) = self.layout.checkpoint
            && path.ray.dir.z > 0.0
            && path.ray.origin.z < z
            && path.ray.origin.z + path.ray.dir.z * distance >= z
        {
            self.score_checkpoint(path, z, mu_a);
        }
        self.entered.get_or_insert(path.ray.dir);
        if let Some(flight) = &self.layout.detectors.flight
            && distance.is_finite()
        {
            self.flown.0 += distance;
            self.flown.1 += distance * flight.group_index[usize::from(path.medium.0)];
        }
        if self.layout.path && distance.is_finite() {
            let fluence: [f64; N] = std::array::from_fn(|i| {
                if mu_a[i] > 0.0 { absorbed[i] / mu_a[i] } else { path.power[i] * distance }
            });
            self.score(self.layout.path_length(path.medium), &fluence);
        }
        if self.layout.depth.is_some() && distance.is_finite() {
            self.score_depth(path, distance, mu_a);
        }
    }

    /// The power that arrives at the checkpoint plane.
    #[cold]
    fn score_checkpoint<P>(&mut self, path: &Path<P, N>, z: f64, mu_a: &[f64; N]) {
        let s = (z - path.ray.origin.z) / path.ray.dir.z;
        let mut power = path.power;
        for (p, mu) in power.iter_mut().zip(mu_a) {
            *p *= 1.0 - fast::one_minus_exp_neg(mu * s);
        }
        self.score(self.layout.of(Cell::Checkpoint), &power);
        if let Some(cell) = self.layout.checkpoint_cell(path.ray.dir) {
            self.score(cell, &power);
        }
    }

    /// Counts an event where events are counted; whether eyes look from it.
    #[inline]
    fn hear_event<P>(&mut self, path: &Path<P, N>, cell: Cell) -> bool {
        if self.layout.path && path.single() {
            self.score(self.layout.of(cell), &path.power);
        }
        path.single() && !self.layout.detectors.views.is_empty()
    }

    /// What detectors hear of power that leaves.
    #[inline(never)]
    fn score_detectors<P>(&mut self, path: &Path<P, N>, face: Face) {
        let (layout, power) = (self.layout, path.power);
        let start = layout.detectors_start();
        let way = layout.detectors.way_out(face, path.ray.origin, path.ray.dir);
        let index =
            layout.detectors.flight.as_ref().map_or(1.0, |f| f.group_index[usize::from(path.medium.0)]);
        let flown = (self.flown.0 + way, self.flown.1 + way * index);
        let dirs = (self.entered.unwrap_or(-DVec3::Z), path.ray.dir);
        layout.detectors.hear(face, path.ray.at(way), dirs, flown, |cell, factor| {
            self.score(start + cell, &power.map(|p| p * factor));
        });
    }

    /// Splits a step over depth bins: absorbed power and path (fluence) in each.
    #[inline(never)]
    fn score_depth<P>(&mut self, path: &Path<P, N>, distance: f64, mu_a: &[f64; N]) {
        let Some(depth) = &self.layout.depth else { return };
        let (z0, uz) = (path.ray.origin.z, path.ray.dir.z);
        let (bins, height) = (depth.bins as usize, (depth.top - depth.bottom) / f64::from(depth.bins));
        let bin_of = |z: f64| (((depth.top - z) / height) as usize).min(bins - 1);
        let mut at = 0.0;
        let mut bin = bin_of(z0 - 1e-12 * uz.signum() * -height);
        let mut left: [f64; N] = path.power;
        loop {
            // Where the ray leaves this bin.
            let edge = if uz < 0.0 {
                depth.top - (bin + 1) as f64 * height
            } else {
                depth.top - bin as f64 * height
            };
            let to_edge = if uz == 0.0 { f64::INFINITY } else { (edge - z0) / uz };
            let end = to_edge.clamp(at, distance);
            let s = end - at;
            let (mut absorbed, mut fluence) = ([0.0; N], [0.0; N]);
            for i in 0..N {
                absorbed[i] = left[i] * fast::one_minus_exp_neg(mu_a[i] * s);
                fluence[i] = if mu_a[i] > 0.0 { absorbed[i] / mu_a[i] } else { left[i] * s };
                left[i] -= absorbed[i];
            }
            let cell = self.layout.depth_cell(path.medium, bin);
            self.score(cell, &absorbed);
            self.score(cell + 1, &fluence);
            at = end;
            let last = if uz < 0.0 { bin + 1 == bins } else { bin == 0 };
            if at >= distance || last {
                return;
            }
            bin = if uz < 0.0 { bin + 1 } else { bin - 1 };
        }
    }
}

impl<const N: usize> Scorer<N> for Tally<'_, N> {
    #[inline]
    fn step<P>(&mut self, path: &Path<P, N>, distance: f64, mu_a: &[f64; N], absorbed: &[f64; N]) {
        self.took(path.medium, path.single(), absorbed);
        if self.steps && path.single() {
            self.score_step(path, distance, mu_a, absorbed);
        }
    }

    #[inline]
    fn hears_totals_only(&self) -> bool {
        !self.steps && !self.events_heard
    }

    #[inline]
    fn took(&mut self, medium: MediumId, single: bool, absorbed: &[f64; N]) {
        if single && (absorbed[0] > 0.0 || N > 1 && absorbed.iter().any(|&x| x > 0.0)) {
            self.score(self.layout.absorbed(medium), absorbed);
        }
    }

    #[inline]
    fn scattered<P>(&mut self, path: &Path<P, N>) -> bool {
        self.events_heard && self.hear_event(path, Cell::Scatterings)
    }

    #[inline]
    fn interface<P>(&mut self, path: &Path<P, N>, _at: &Interface) -> bool {
        self.events_heard && self.hear_event(path, Cell::Interfaces)
    }

    fn eye(&self, view: usize) -> Option<DVec3> {
        self.layout.detectors.views.get(view).copied()
    }

    fn seen(&mut self, view: usize, power: &[f64; N]) {
        let cell = self.layout.detectors_start() + self.layout.detectors.views_start() + view;
        self.score(cell, power);
    }

    fn absorbed_at<P>(&mut self, path: &Path<P, N>, beyond: Option<MediumId>, power: &[f64; N]) {
        if path.single() {
            let cell = beyond.map_or(self.layout.of(Cell::Backing), |m| self.layout.absorbed(m));
            self.score(cell, power);
        }
    }

    fn leaves<P>(&mut self, path: &Path<P, N>, face: Face) {
        let cell = if face == Face::Top { Cell::Reflected } else { Cell::Transmitted };
        self.score(self.layout.of(cell), &path.power);
        if let Some(cell) = self.layout.angular_cell(path.ray.dir) {
            self.score(cell, &path.power);
        }
        if face == Face::Top
            && let Some(view) = &self.layout.view
            && let Some(factor) = view.factor(path.ray.dir)
        {
            let seen = path.power.map(|p| p * factor);
            self.score(self.layout.pile_cell(0), &seen);
        }
        if self.detects {
            self.score_detectors(path, face);
        }
    }

    fn leaves_full<P>(&mut self, path: &Path<P, N>, face: Face, extra: &Extra<N>) {
        self.leaves(path, face);
        if self.layout.time {
            let cell = if face == Face::Top { Cell::TimeReflected } else { Cell::TimeTransmitted };
            let weighted = path.power.map(|p| p * extra.optical_path / LIGHT_UM_PER_PS);
            self.score(self.layout.of(cell), &weighted);
        }
    }

    fn leaves_pile<P>(&mut self, path: &Path<P, N>) {
        if let Some(view) = &self.layout.view
            && let Some(factor) = view.factor(path.ray.dir)
        {
            let seen = path.power.map(|p| p * factor);
            let cell = self.layout.pile_cell(path.deepest);
            self.score(cell, &seen);
        }
    }
}

/// Speed of light in vacuum, µm/ps.
const LIGHT_UM_PER_PS: f64 = 299.792_458;

/// How an instrument looks at the sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// All reflected power.
    All,
    /// A cone about the normal: reflectance factor = power in the cone over that of the perfect
    /// diffuser, sin² of the half angle.
    Cone {
        /// Cosine of the half angle.
        cos: f64,
    },
    /// All but a cone (gloss trap): reflectance factor = power outside it over that of the perfect
    /// diffuser.
    Beyond {
        /// Middle of the trap.
        axis: DVec3,
        /// Cosine of its half angle.
        cos: f64,
        /// Share of Lambertian light that it lets pass.
        share: f64,
    },
}

impl View {
    /// Factor on the power of a ray that leaves along `dir`; `None` if it is not seen.
    #[inline]
    pub fn factor(&self, dir: DVec3) -> Option<f64> {
        match *self {
            View::All => Some(1.0),
            View::Cone { cos } => (dir.z >= cos).then(|| 1.0 / ((1.0 - cos) * (1.0 + cos))),
            View::Beyond { axis, cos, share } => (dir.dot(axis) < cos).then(|| 1.0 / share),
        }
    }
}
