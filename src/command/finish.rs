//! From a scene to figures, without touching the disk.

use super::{Failure, RunArgs, planned};
use crate::report::{self, RunResult, text};
use crate::run::simulate::{State, advance, fresh, outcome};
use crate::run::{BATCH, Health, Outcome, Progress, Sums, Trouble, Watch};
use crate::scene::Scene;
use crate::scene::plan::Plan;
use crate::stats::Fold;
use std::ops::Range;

/// A scene that has been run.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The scene with its overrides.
    pub scene: Scene,
    /// Its plan.
    pub plan: Plan,
    /// Sums.
    pub outcome: Outcome,
    /// Figures.
    pub result: RunResult,
    /// Expected figures: one line each, and whether all hold.
    pub expects: (Vec<String>, bool),
}

/// Runs a scene on a pool of threads, without touching the disk.
///
/// # Errors
/// Constants missing at a wavelength, no threads to be had, a worker that panics.
pub fn finish(
    scene: Scene,
    args: &RunArgs,
    mut progress: impl FnMut(Progress) -> bool + Send,
) -> Result<Finished, Failure> {
    let (scene, plan, range) = with_overrides(scene, args)?;
    let mut state = fresh(&plan, range.start);
    let mut round = |s: &[Fold<Sums>]| progress(Progress::of(s, &range, scene.run.histories));
    let watch = Watch { stop: &|| false, round: &mut round };
    on_pool(&scene, &plan, &mut state, &range, args.threads, watch)?;
    conclude(scene, plan, state, range)
}

/// The scene with what the command line says, its plan, and the histories to run.
pub fn with_overrides(mut scene: Scene, args: &RunArgs) -> Result<(Scene, Plan, Range<u64>), Failure> {
    if let Some(n) = args.histories {
        scene.run.histories = n;
    }
    if let Some(seed) = args.seed {
        scene.run.seed = seed;
    }
    let all = 0..scene.run.histories;
    let range = args.range.clone().unwrap_or(all.clone());
    let whole = |n: u64| n.is_multiple_of(BATCH);
    if range.is_empty()
        || range.end > all.end
        || !whole(range.start)
        || !(whole(range.end) || range.end == all.end)
    {
        return Err(Failure::Input(format!(
            "error: histories {}..{} are no shard of {}: a shard is a range of whole batches of {BATCH} histories\n\
             help: multiples of {BATCH}; the last shard ends with the last history",
            range.start, range.end, all.end
        )));
    }
    let plan = planned(&scene)?;
    Ok((scene, plan, range))
}

/// [`advance`] on a pool of so many threads.
pub fn on_pool(
    scene: &Scene,
    plan: &Plan,
    state: &mut State,
    range: &Range<u64>,
    threads: usize,
    watch: Watch<'_>,
) -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| Failure::Internal(e.to_string()))?;
    pool.install(|| advance(scene, plan, state, range.clone(), watch)).map_err(|trouble| match trouble {
        Trouble::Input(e) => Failure::Input(format!("error: {}: {e}", scene.path.display())),
        Trouble::Fault(fault) => {
            let wavelength = plan.groups[fault.group as usize][0];
            Failure::Internal(format!(
                "{fault}\nhelp: `lightpro replay {} --history {} --wavelength {wavelength}` shows it again; \
                 no results are written",
                scene.path.display(),
                fault.history
            ))
        }
    })
}

/// Figures from the sums of a run.
pub fn conclude(scene: Scene, plan: Plan, state: State, range: Range<u64>) -> Result<Finished, Failure> {
    let outcome = outcome(&scene, &plan, state, range)
        .map_err(|e| Failure::Input(format!("error: {}: {e}", scene.path.display())))?;
    let result = report::figures::result(&scene, &plan, &outcome);
    let expects = expectations(&scene, &result);
    Ok(Finished { scene, plan, outcome, result, expects })
}

/// Expected figures of the scene against the result: within the tolerance and 4 standard errors.
fn expectations(scene: &Scene, result: &RunResult) -> (Vec<String>, bool) {
    let mut lines = Vec::new();
    let mut all = true;
    for e in &scene.expects {
        let mut at = e.component.as_ref().map_or(String::new(), |c| format!(" [{c}]"));
        at += &e.wavelength.map_or(String::new(), |nm| format!(" at {nm} nm"));
        let wanted = e.wavelength.or_else(|| (scene.wavelengths.len() == 1).then(|| scene.wavelengths[0]));
        let found = result.figures.iter().find(|f| {
            f.name == e.quantity
                && f.component == e.component
                && (f.wavelength_nm.is_none() || f.wavelength_nm == wanted)
        });
        let (verdict, got) = match found.and_then(|f| f.value.map(|v| (v, f.error.unwrap_or(0.0)))) {
            None => (false, "no such figure".to_owned()),
            Some((v, se)) => ((v - e.value).abs() <= e.error + 4.0 * se, text::with_error(v, Some(se))),
        };
        all &= verdict;
        let word = if verdict { "holds" } else { "FAILS" };
        lines.push(format!(
            "expected {}{at} = {} ± {} ({}): {got}, {word}",
            e.quantity, e.value, e.error, e.source
        ));
    }
    (lines, all)
}

/// The physics checks that a run must pass: ledger, lost rays, expected figures.
pub fn verdict(done: &Finished) -> Result<(), Failure> {
    if let Some(text) = Health::of(&done.outcome).failure() {
        return Err(Failure::Physics(text));
    }
    if !done.expects.1 {
        let failing: Vec<&str> =
            done.expects.0.iter().filter(|l| l.ends_with("FAILS")).map(String::as_str).collect();
        return Err(Failure::Physics(failing.join("\n")));
    }
    Ok(())
}
