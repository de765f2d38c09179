//! What `run --target` checks before and tells after.

use super::finish::{conclude, on_pool, with_overrides};
use super::{Failure, Finished, RunArgs};
use crate::report::{RunFolder, csv};
use crate::run::Watch;
use crate::run::simulate::fresh;
use crate::scene::Scene;
use crate::study::target::{self, Seen, Target};

/// Refuses targets of figures that the scene does not have: a few histories are enough to know.
pub fn check(scene: &Scene, targets: &[Target]) -> Result<(), Failure> {
    let few = RunArgs { histories: Some(64 * scene.run.shared), ..RunArgs::default() };
    let (scene, plan, range) = with_overrides(scene.clone(), &few)?;
    let mut state = fresh(&plan, 0);
    let watch = Watch { stop: &|| false, round: &mut |_| true };
    on_pool(&scene, &plan, &mut state, &range, 1, watch)?;
    let probe = conclude(scene, plan, state, range)?;
    target::check(targets, &probe.result).map_err(|e| Failure::Input(format!("error: {e}")))
}

fn last(targets: &[Target], done: &Finished) -> Vec<Seen> {
    let batches = done.outcome.groups.iter().map(|g| g.node.batches).min().unwrap_or(0);
    target::look(targets, &done.result, batches)
}

/// Writes `targets.csv`, where there are any.
pub fn write(folder: &RunFolder, targets: &[Target], done: &Finished) -> std::io::Result<()> {
    if targets.is_empty() {
        return Ok(());
    }
    folder.write("targets.csv", csv::table(&last(targets, done)).as_bytes())
}

/// What a person wants to see of them.
pub fn told(targets: &[Target], done: &Finished) -> Option<String> {
    (!targets.is_empty()).then(|| target::text(&last(targets, done), &done.result).trim_end().to_owned())
}
