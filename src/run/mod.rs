//! Runs histories: batches of a fixed size on all threads, folded in a fixed order, so that the
//! result is the same bytes for any number of threads, shards and interruptions.

mod batch;
pub mod checkpoint;
pub mod clock;
pub mod health;
pub mod limits;
pub mod replay;
pub mod simulate;
pub mod sums;
mod workers;

pub use checkpoint::{Checkpoint, Identity};
pub use health::Health;
pub use simulate::{Outcome, Progress, Trouble, simulate};
pub use sums::Sums;
pub use workers::{Fault, Watch};

use crate::lpm::World;
use crate::rng::Generator;
use crate::source::Source;
use crate::stats::Fold;
use crate::tally::{Layout, Node};
use crate::universe::Universe;

pub use crate::scene::BATCH;

/// Which histories of which stream family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Histories {
    /// Seed of the run.
    pub seed: u64,
    /// Wavelength group: groups draw different numbers.
    pub group: u64,
    /// Number of histories.
    pub count: u64,
}

/// Runs one wavelength group. `progress` hears of each finished batch with the sums so far and may stop
/// the run by returning false.
///
/// # Panics
/// When a history does.
pub fn run_group<U: Universe, const N: usize>(
    world: &World<U, N>,
    source: &Source,
    layout: &Layout,
    histories: Histories,
    mut progress: impl FnMut(&Fold<Sums>, u64) -> bool + Send,
) -> Node {
    let generator = Generator::default();
    let group = batch::Traced { world, source, layout, histories, batch: BATCH, generator };
    let mut state = [Fold::default()];
    let mut round = |s: &[Fold<Sums>]| progress(&s[0], (s[0].next() * BATCH).min(histories.count));
    let watch = Watch { stop: &|| false, round: &mut round };
    if let Err(fault) = workers::work(&[&group], &mut state, histories.count.div_ceil(BATCH), watch) {
        panic!("{fault}");
    }
    let [fold] = state;
    fold.finish().unwrap_or_default().node
}
