//! A run with its price in processor time.

use crate::report::{self, RunResult};
use crate::run::clock::processor_seconds;
use crate::run::{Outcome, simulate};
use crate::scene::Scene;
use crate::scene::plan::Plan;
use std::time::Instant;

/// A scene that has been run.
#[derive(Clone, Debug)]
pub struct Timed {
    /// Sums.
    pub outcome: Outcome,
    /// Figures.
    pub result: RunResult,
    /// Processor seconds of transport, on however many threads.
    pub cpu: f64,
    /// Seconds on the clock.
    pub wall: f64,
}

/// Runs a scene on rayon's current threads.
///
/// # Errors
/// A scene that cannot be made or run.
pub fn timed(scene: &Scene) -> Result<Timed, String> {
    let plan = Plan::new(scene)?;
    let (clock, cpu) = (Instant::now(), processor_seconds());
    let outcome = simulate(scene, &plan, |_| true).map_err(|e| e.to_string())?;
    let (cpu, wall) = (processor_seconds() - cpu, clock.elapsed().as_secs_f64());
    let result = report::figures::result(scene, &plan, &outcome);
    Ok(Timed { outcome, result, cpu: cpu.max(1e-9), wall })
}
