//! Targets of a run under way: looked at after fixed numbers of batches.

use super::target::{self, Seen, Target};
use crate::report::{self, RunResult};
use crate::run::simulate::{advance, fresh, outcome};
use crate::run::{BATCH, Outcome, Sums, Trouble, Watch};
use crate::scene::Scene;
use crate::scene::plan::Plan;
use crate::stats::Fold;

/// Targets, and what the last look at them found.
#[derive(Debug)]
pub struct Aims<'a> {
    targets: &'a [Target],
    seen: Vec<Seen>,
    /// Histories per wavelength group after which all were met.
    pub reached: Option<u64>,
}

impl<'a> Aims<'a> {
    /// Before the first look.
    pub fn new(targets: &'a [Target]) -> Self {
        Aims { targets, seen: Vec::new(), reached: None }
    }

    /// Looks, if it is time to: true where all targets are met. A function of the sums alone.
    pub fn look(&mut self, scene: &Scene, plan: &Plan, state: &[Fold<Sums>]) -> bool {
        let batches = state.first().map_or(0, Fold::next);
        let done = batches * BATCH;
        if self.targets.is_empty() || !target::is_look(batches) || done > scene.run.histories {
            return false;
        }
        // What is being run has a layout: its sums make figures.
        let Ok(sums) = outcome(scene, plan, state.to_vec(), 0..done) else { return false };
        let result = report::figures::result(scene, plan, &sums);
        self.seen = target::look(self.targets, &result, batches);
        let met = self.seen.iter().all(|s| s.met);
        self.reached = met.then_some(done);
        met
    }

    /// Histories per wavelength group that should do.
    pub fn predicted(&self) -> Option<u64> {
        target::predicted(&self.seen)
    }
}

/// Runs a scene on rayon's current threads until its targets are met, or to its last history: what
/// `run --target` computes, without touching the disk.
///
/// # Errors
/// As [`crate::run::simulate`].
pub fn run(scene: &Scene, targets: &[Target]) -> Result<(Outcome, RunResult, Vec<Seen>), Trouble> {
    let plan = Plan::new(scene).map_err(Trouble::Input)?;
    let mut state = fresh(&plan, 0);
    let mut aims = Aims::new(targets);
    let mut round = |s: &[Fold<Sums>]| !aims.look(scene, &plan, s);
    let watch = Watch { stop: &|| false, round: &mut round };
    advance(scene, &plan, &mut state, 0..scene.run.histories, watch)?;
    let end = aims.reached.unwrap_or(scene.run.histories);
    let outcome = outcome(scene, &plan, state, 0..end).map_err(Trouble::Input)?;
    let result = report::figures::result(scene, &plan, &outcome);
    let batches = outcome.groups.iter().map(|g| g.node.batches).min().unwrap_or(0);
    let seen = target::look(targets, &result, batches);
    Ok((outcome, result, seen))
}
