//! Counters that tell a sound run from a sick one, and their ceilings.

use super::simulate::Outcome;
use super::sums::Troubled;
use serde::{Deserialize, Serialize};

/// Worst |1 − ledger| of a history that passes.
pub const IMBALANCE: f64 = 1e-12;

/// Lost rays that pass among `histories`: max(10, 1e-6 N).
pub fn lost_ceiling(histories: u64) -> f64 {
    f64::max(10.0, 1e-6 * histories as f64)
}

/// A record with its place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// First wavelength of its group, nm.
    pub wavelength_nm: f64,
    /// History and what happened to it.
    #[serde(flatten)]
    pub troubled: Troubled,
}

/// Health of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Health {
    /// Histories run, over all wavelength groups.
    pub histories: u64,
    /// Histories that lost power.
    pub lost: u64,
    /// Histories that the event cap cut short.
    pub capped: u64,
    /// Worst |1 − ledger| of any history.
    pub worst_imbalance: f64,
    /// The first of the lost and capped histories, for `lightpro replay`.
    pub records: Vec<Record>,
}

impl Health {
    /// Counters of a run.
    pub fn of(outcome: &Outcome) -> Health {
        let (lost, capped) = outcome.troubled();
        let of_group = |g: &super::simulate::GroupResult| {
            let wavelength_nm = g.wavelengths.first().copied().unwrap_or(f64::NAN);
            g.troubled.iter().map(|&troubled| Record { wavelength_nm, troubled }).collect::<Vec<_>>()
        };
        Health {
            histories: outcome.groups.iter().map(|g| g.node.histories).sum(),
            lost,
            capped,
            worst_imbalance: outcome.worst_imbalance(),
            records: outcome.groups.iter().flat_map(of_group).collect(),
        }
    }

    /// What is beyond its ceiling: a run that fails.
    pub fn failure(&self) -> Option<String> {
        if self.lost as f64 > lost_ceiling(self.histories) {
            let first = self.records.first().map_or(String::new(), |r| {
                format!(
                    "; see `lightpro replay … --history {} --wavelength {}`",
                    r.troubled.history, r.wavelength_nm
                )
            });
            return Some(format!("{} of {} histories lost power{first}", self.lost, self.histories));
        }
        (self.worst_imbalance > IMBALANCE)
            .then(|| format!("the energy ledger of a history is off by {:.1e}", self.worst_imbalance))
    }

    /// What is no failure but worth a line.
    pub fn warning(&self) -> Option<String> {
        (self.lost + self.capped > 0).then(|| {
            format!(
                "warning: {} histories lost power, {} were cut short by the event cap; \
                 their numbers are in manifest.json",
                self.lost, self.capped
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fault of the design's table: lost ray beyond max(10, 1e-6 N).
    #[test]
    fn lost_rays_and_open_ledgers_fail_beyond_their_ceilings() {
        let with = |lost, histories| Health { lost, histories, ..Health::default() };
        assert_eq!(with(10, 1000).failure(), None);
        assert!(with(11, 1000).failure().is_some_and(|t| t.contains("11 of 1000")));
        assert_eq!(with(20, 20_000_000).failure(), None);
        assert!(with(21, 20_000_000).failure().is_some());
        let open = |worst_imbalance| Health { worst_imbalance, ..Health::default() };
        assert_eq!(open(1e-12).failure(), None);
        assert!(open(1.1e-12).failure().is_some());
    }
}
