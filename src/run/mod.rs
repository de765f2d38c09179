//! Runs histories: batches of a fixed size on all threads, folded in a fixed order, so that the
//! result is the same bytes for any number of threads.

pub mod simulate;

pub use simulate::{Outcome, Progress, simulate};

use crate::lpm::{History, World, trace};
use crate::rng::{Purpose, Stream};
use crate::source::Source;
use crate::stats::Fold;
use crate::tally::{Layout, Node, Tally, node::REPLICAS};
use crate::universe::Universe;
use rayon::prelude::*;

/// Histories of a batch.
pub const BATCH: u64 = 4096;

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

/// Runs one wavelength group. `progress` hears of each finished wave of batches with the sums so far and
/// may stop the run by returning false.
pub fn run_group<U: Universe, const N: usize>(
    world: &World<U, N>,
    source: &Source,
    layout: &Layout,
    histories: Histories,
    mut progress: impl FnMut(&Fold<Node>, u64) -> bool,
) -> Node {
    let batches = histories.count.div_ceil(BATCH);
    let wave = 4 * rayon::current_num_threads() as u64;
    let mut fold = Fold::default();
    let mut next = 0;
    while next < batches {
        let end = (next + wave).min(batches);
        let nodes: Vec<Node> =
            (next..end).into_par_iter().map(|b| batch(world, source, layout, histories, b)).collect();
        for node in nodes {
            fold.push(node);
        }
        next = end;
        if !progress(&fold, (next * BATCH).min(histories.count)) {
            break;
        }
    }
    fold.finish().unwrap_or_default()
}

/// One batch, history by history.
fn batch<U: Universe, const N: usize>(
    world: &World<U, N>,
    source: &Source,
    layout: &Layout,
    histories: Histories,
    index: u64,
) -> Node {
    let mut tally: Tally<N> = Tally::new(layout);
    let mut h: History<U, N> = History::default();
    for number in index * BATCH..((index + 1) * BATCH).min(histories.count) {
        h.continues = !number.is_multiple_of(layout.shared);
        h.number = number;
        let mut rng = Stream::of(histories.seed, histories.group, number, Purpose::Transport);
        let ray = source.emit(&mut rng);
        trace(world, ray, &mut h, &mut tally, &mut rng);
        tally.end_history(&h.ledger, h.events, world.universe.kept(&h.memory));
    }
    tally.finish((index % REPLICAS) as u8)
}
