//! What a batch leaves behind: its sums, and which of its histories went wrong.

use crate::stats::Merge;
use crate::tally::Node;
use serde::{Deserialize, Serialize};

/// Records kept of histories that went wrong, per wavelength group: the first ones.
pub const RECORDS: usize = 100;

/// How a history went wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fate {
    /// Power was lost: the universe had no answer.
    Lost,
    /// The event cap cut it short.
    Capped,
}

/// A history that went wrong, for `replay`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Troubled {
    /// Its number.
    pub history: u64,
    /// What happened.
    pub fate: Fate,
}

/// Sums of a range of batches.
#[derive(Clone, Debug, Default)]
pub struct Sums {
    /// Cells and counters.
    pub node: Node,
    /// The first [`RECORDS`] histories that went wrong, in order.
    pub troubled: Vec<Troubled>,
}

impl Merge for Sums {
    fn merge(&mut self, later: Self) {
        self.node.merge(later.node);
        self.troubled.extend(later.troubled);
        self.troubled.truncate(RECORDS);
    }
}
