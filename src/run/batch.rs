//! One batch, history by history.

use super::Histories;
use super::sums::{Fate, RECORDS, Sums, Troubled};
use crate::lpm::{History, Ledger, Scorer, World, trace};
use crate::rng::{Generator, Purpose, Stream};
use crate::source::Source;
use crate::tally::{Layout, Tally, node::REPLICAS};
use crate::universe::Universe;
use std::sync::atomic::{AtomicU64, Ordering};

/// Something that can be run batch by batch: a wavelength group.
pub trait Batches: Sync {
    /// Runs the batch `index`; `now` holds the number of the history under way.
    fn batch(&self, index: u64, now: &AtomicU64) -> Sums;
}

/// A group whose world is at hand.
#[derive(Debug)]
pub struct Traced<'a, U: Universe, const N: usize> {
    /// World.
    pub world: &'a World<'a, U, N>,
    /// Where histories start.
    pub source: &'a Source,
    /// Cells.
    pub layout: &'a Layout,
    /// Which histories.
    pub histories: Histories,
    /// How many of them are a batch.
    pub batch: u64,
    /// Family of their streams.
    pub generator: Generator,
}

impl<U: Universe, const N: usize> Batches for Traced<'_, U, N> {
    fn batch(&self, index: u64, now: &AtomicU64) -> Sums {
        let mut tally: Tally<N> = Tally::new(self.layout);
        let mut h: History<U, N> = History::default();
        let mut troubled = Vec::new();
        for number in index * self.batch..((index + 1) * self.batch).min(self.histories.count) {
            now.store(number, Ordering::Relaxed);
            self.history(number, &mut h, &mut tally);
            if h.ledger.rare() && troubled.len() < RECORDS {
                troubled.extend(fate(&h.ledger).map(|fate| Troubled { history: number, fate }));
            }
            tally.end_history(&h.ledger, h.events, self.world.universe.kept(&h.memory));
        }
        Sums { node: tally.finish((index % self.layout.realisations.unwrap_or(REPLICAS)) as u8), troubled }
    }
}

impl<U: Universe, const N: usize> Traced<'_, U, N> {
    /// Traces one history; the memory of the one before is shared where realisations are.
    pub fn history<S: Scorer<N>>(&self, number: u64, h: &mut History<U, N>, scorer: &mut S) {
        h.continues = !number.is_multiple_of(self.layout.shared);
        let mut rng = Stream::of(self.histories.seed, self.histories.group, number, Purpose::Transport)
            .with(self.generator);
        h.number = number;
        let ray = self.source.emit(&mut rng);
        trace(self.world, ray, h, scorer, &mut rng);
    }
}

fn fate<const N: usize>(ledger: &Ledger<N>) -> Option<Fate> {
    let any = |w: &[f64; N]| w.iter().any(|&x| x != 0.0);
    match (any(&ledger.lost), any(&ledger.truncated)) {
        (true, _) => Some(Fate::Lost),
        (_, true) => Some(Fate::Capped),
        _ => None,
    }
}
