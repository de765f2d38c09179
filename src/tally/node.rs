//! Sums of one or many batches, merged in a fixed order.

use crate::stats::{Merge, Moments};
use std::collections::BTreeMap;

/// Replicas that the batches are dealt to, for the errors of derived figures.
pub const REPLICAS: u64 = 32;

/// Sums over a range of batches.
#[derive(Clone, Debug, Default)]
pub struct Node {
    /// Histories.
    pub histories: u64,
    /// Batches.
    pub batches: u64,
    /// Events.
    pub events: u64,
    /// Worst |1 − ledger| of any history.
    pub worst_imbalance: f64,
    /// Histories with lost power.
    pub lost: u64,
    /// Histories stopped by the event cap.
    pub capped: u64,
    /// Per cell and lane (cell-major): Σw … Σw⁴ over histories.
    pub sums: Vec<[f64; 4]>,
    /// Per replica: histories and Σw of each cell and lane.
    pub replicas: BTreeMap<u8, (u64, Vec<f64>)>,
}

impl Node {
    /// The node of one batch.
    pub fn batch(
        replica: u8,
        sums: Vec<[f64; 4]>,
        histories: u64,
        events: u64,
        worst_imbalance: f64,
        lost: u64,
        capped: u64,
    ) -> Self {
        let first = sums.iter().map(|s| s[0]).collect();
        Node {
            histories,
            batches: 1,
            events,
            worst_imbalance,
            lost,
            capped,
            sums,
            replicas: BTreeMap::from([(replica, (histories, first))]),
        }
    }

    /// Moments of a cell in a lane, over all histories.
    pub fn moments(&self, cell: usize, lane: usize, lanes: usize) -> Moments {
        Moments::from_sums(self.histories, self.sums[cell * lanes + lane])
    }
}

impl Merge for Node {
    fn merge(&mut self, later: Self) {
        self.histories += later.histories;
        self.batches += later.batches;
        self.events += later.events;
        self.worst_imbalance = self.worst_imbalance.max(later.worst_imbalance);
        self.lost += later.lost;
        self.capped += later.capped;
        for (a, b) in self.sums.iter_mut().zip(&later.sums) {
            for (x, y) in a.iter_mut().zip(b) {
                *x += y;
            }
        }
        for (replica, (n, sums)) in later.replicas {
            match self.replicas.entry(replica) {
                std::collections::btree_map::Entry::Vacant(e) => {
                    e.insert((n, sums));
                }
                std::collections::btree_map::Entry::Occupied(mut e) => {
                    let (have, total) = e.get_mut();
                    *have += n;
                    for (x, y) in total.iter_mut().zip(&sums) {
                        *x += y;
                    }
                }
            }
        }
    }
}
