//! Sums of one or many batches, merged in a fixed order.

use crate::stats::{Merge, Moments};
use crate::universe::Kept;
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
    /// Samples: histories, or groups of them that share a realisation.
    pub samples: u64,
    /// Per lane: Σw² of what single histories reflect and transmit, where several share a realisation.
    pub single: Vec<[f64; 2]>,
    /// What the universe has kept of the samples.
    pub kept: Kept,
    /// Per cell and lane (cell-major): Σw … Σw⁴ over samples.
    pub sums: Vec<[f64; 4]>,
    /// Per replica: samples and Σw of each cell and lane.
    pub replicas: BTreeMap<u8, (u64, Vec<f64>)>,
}

impl Node {
    /// The node of one batch of `samples` samples with the given sums.
    pub fn batch(replica: u8, sums: Vec<[f64; 4]>, samples: u64) -> Self {
        let first = sums.iter().map(|s| s[0]).collect();
        let replicas = BTreeMap::from([(replica, (samples, first))]);
        Node { histories: samples, samples, batches: 1, sums, replicas, ..Node::default() }
    }

    /// Moments of a cell in a lane, over all samples.
    pub fn moments(&self, cell: usize, lane: usize, lanes: usize) -> Moments {
        Moments::from_sums(self.samples, self.sums[cell * lanes + lane])
    }

    /// The same where each replica is a realisation: one sample of each, R Σw_r/n, so that the mean is that of
    /// all histories and the variance that between realisations with what is left of the histories'.
    pub fn by_replica(&self, cell: usize, lane: usize, lanes: usize) -> Moments {
        let mut moments = Moments::default();
        let scale = self.replicas.len() as f64 / self.samples as f64;
        self.replicas.values().for_each(|(_, sums)| moments.add(scale * sums[cell * lanes + lane]));
        moments
    }

    /// Standard deviation between realisations of the figure that `moments` describes (a sample is a
    /// realisation), and its error: the variance of the means of m histories each, less the m-th part of the
    /// variance of histories within a realisation; `squares` is Σw² over single histories. `None` where none
    /// share one.
    pub fn between(&self, moments: &Moments, squares: f64) -> Option<(f64, f64)> {
        let (n, groups) = (self.histories as f64, moments.n as f64);
        if self.histories == moments.n || moments.n < 2 {
            return None;
        }
        let m = n / groups;
        let within = (squares - m * moments.sums[1]) / (n - groups);
        let between = moments.variance() - within / m;
        // Two mean squares: relative variance 2/(degrees of freedom) each.
        let error = (2.0 * moments.variance().powi(2) / (groups - 1.0)
            + 2.0 * (within / m).powi(2) / (n - groups))
            .sqrt();
        let sd = between.max(0.0).sqrt();
        Some((sd, if sd * sd > error { error / (2.0 * sd) } else { error.sqrt() }))
    }
}

impl Merge for Node {
    fn merge(&mut self, later: Self) {
        self.histories += later.histories;
        self.samples += later.samples;
        self.kept.add(later.kept);
        self.single.resize(self.single.len().max(later.single.len()), [0.0; 2]);
        for (a, b) in self.single.iter_mut().zip(&later.single) {
            *a = [a[0] + b[0], a[1] + b[1]];
        }
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
