//! `study effects`: every effect toggled, with common random numbers: what it changes in each figure, and
//! what it costs.
//!
//! The change of a figure is paired where both runs draw alike: histories of one number share their
//! stream, and the interval comes from the differences batch by batch (jackknife over the replicas).

use crate::report::Figure;
use crate::run::clock::processor_seconds;
use crate::run::{Outcome, simulate};
use crate::scene::Scene;
use crate::scene::effects::{Kind, Override, apply};
use crate::scene::plan::Plan;
use crate::stats::interval95;
use crate::tally::Cell;
use std::fmt;

/// Change of a figure by an effect.
#[derive(Clone, Debug)]
pub struct Change {
    /// Figure as the plan has it.
    pub figure: Figure,
    /// Figure with the effect toggled, less the figure as planned.
    pub by: f64,
    /// 95 % interval of the change.
    pub interval: (f64, f64),
}

/// One effect toggled.
#[derive(Clone, Debug)]
pub struct Toggled {
    /// Effect.
    pub kind: Kind,
    /// As planned.
    pub on: bool,
    /// Changes and price, or why it cannot be toggled.
    pub outcome: Result<Price, String>,
}

/// What a toggled run changes and costs.
#[derive(Clone, Debug)]
pub struct Price {
    /// Changes of the totals, at every wavelength.
    pub changes: Vec<Change>,
    /// ns per event.
    pub ns_per_event: f64,
    /// Events per history.
    pub events: f64,
    /// Seconds of the run over those of the planned run.
    pub time: f64,
}

/// The study of a scene.
#[derive(Clone, Debug)]
pub struct Study {
    /// ns per event, events per history of the planned run.
    pub planned: (f64, f64),
    /// Every effect.
    pub effects: Vec<Toggled>,
    /// Everything on that can be: which, and its price.
    pub everything: Option<(Vec<Kind>, Price)>,
}

struct Timed {
    outcome: Outcome,
    /// Processor seconds.
    seconds: f64,
}

impl Timed {
    fn ns_per_event(&self) -> f64 {
        self.seconds * 1e9 / self.outcome.events() as f64
    }
    fn events_per_history(&self) -> f64 {
        self.outcome.events() as f64 / (self.outcome.histories * self.outcome.groups.len() as u64) as f64
    }
}

/// Shortest of three runs on one thread, in processor time: other load on the machine only ever adds.
fn run(scene: &Scene) -> Result<Timed, String> {
    let plan = Plan::new(scene)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|e| e.to_string())?;
    let mut best: Option<Timed> = None;
    for _ in 0..3 {
        let started = processor_seconds();
        let outcome = pool.install(|| simulate(scene, &plan, |_| true)).map_err(|e| e.to_string())?;
        let seconds = processor_seconds() - started;
        if best.as_ref().is_none_or(|b| seconds < b.seconds) {
            best = Some(Timed { outcome, seconds });
        }
    }
    best.ok_or_else(|| "no run".to_owned())
}

/// Toggles every effect of the scene.
///
/// # Errors
/// A scene that cannot be run as planned.
pub fn study(scene: &Scene) -> Result<Study, String> {
    let base = run(scene)?;
    let mut effects = Vec::new();
    for &kind in Kind::ALL {
        let on = scene.has(kind);
        let outcome = toggled(scene, kind, !on).and_then(|other| Ok(price(&base, &run(&other)?)));
        effects.push(Toggled { kind, on, outcome });
    }
    let (all, kinds) = everything(scene);
    let everything = run(&all).ok().map(|timed| (kinds, price(&base, &timed)));
    Ok(Study { planned: (base.ns_per_event(), base.events_per_history()), effects, everything })
}

fn price(base: &Timed, timed: &Timed) -> Price {
    Price {
        changes: changes(&base.outcome, &timed.outcome),
        ns_per_event: timed.ns_per_event(),
        events: timed.events_per_history(),
        time: timed.seconds / base.seconds,
    }
}

/// The scene with every effect on that has a neutral parameter there; patches stay out, they know no plane
/// of reference for polarised light.
pub fn everything(scene: &Scene) -> (Scene, Vec<Kind>) {
    let mut all = scene.clone();
    let mut forced = Vec::new();
    for &kind in Kind::ALL.iter().filter(|k| **k != Kind::Sap) {
        if !all.has(kind)
            && let Ok(other) = toggled(&all, kind, true)
        {
            all = other;
            forced.push(kind);
        }
    }
    (all, forced)
}

/// The scene with one effect forced.
fn toggled(scene: &Scene, kind: Kind, on: bool) -> Result<Scene, String> {
    let mut other = scene.clone();
    if other.overrides.iter().any(|o| o.kind == kind) {
        return Err("already overridden in the scene".to_owned());
    }
    let reason = "study of effects".to_owned();
    apply(&mut other, vec![Override { kind, on, reason, called: Vec::new(), flag: true }])?;
    Ok(other)
}

/// Changes of reflectance and transmittance at every wavelength, from the differences of replicas.
pub(super) fn changes(base: &Outcome, other: &Outcome) -> Vec<Change> {
    let mut out = Vec::new();
    for (name, cell) in [("reflectance", Cell::Reflected), ("transmittance", Cell::Transmitted)] {
        for (nm, group, lane) in base.wavelengths() {
            let Some((_, with, at)) = other.wavelengths().find(|w| w.0 == nm) else { continue };
            let means = |g: &crate::run::simulate::GroupResult, lane: usize| -> Vec<f64> {
                let index = g.layout.of(cell) * g.layout.lanes + lane;
                g.node.replicas.values().map(|(n, sums)| sums[index] / *n as f64).collect()
            };
            let (a, b) = (means(group, lane), means(with, at));
            let (ma, mb) =
                (group.moments(group.layout.of(cell), lane), with.moments(with.layout.of(cell), at));
            let by = mb.mean() - ma.mean();
            let n = a.len().min(b.len());
            // Paired over replicas; fewer than two know no spread: then as if independent.
            let (se, dof) = if n > 1 {
                let d: Vec<f64> = a.iter().zip(&b).map(|(a, b)| b - a).collect();
                let mean = d.iter().sum::<f64>() / n as f64;
                let var = d.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1) as f64;
                ((var / n as f64).sqrt(), (n - 1) as f64)
            } else {
                let (ea, eb) = (ma.standard_error(), mb.standard_error());
                ((ea * ea + eb * eb).sqrt(), 1e6)
            };
            let figure = Figure::new(name, ma.mean(), ma.standard_error(), "1").at_wavelength(nm);
            out.push(Change { figure, by, interval: interval95(by, se, dof) });
        }
    }
    out
}

impl fmt::Display for Study {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "as planned: {:.0} ns per event, {:.2} events per history",
            self.planned.0, self.planned.1
        )?;
        writeln!(
            f,
            "toggled                        now   time     ns/event  events  largest change (95 % interval)"
        )?;
        for t in &self.effects {
            let name = t.kind.name();
            let now = if t.on { "on" } else { "off" };
            match &t.outcome {
                Err(why) => writeln!(f, "{name:<30} {now:<4}  cannot be toggled: {why}")?,
                Ok(p) => {
                    let largest = p.changes.iter().max_by(|a, b| a.by.abs().total_cmp(&b.by.abs()));
                    let change = largest.map_or(String::new(), |c| {
                        let nm = c.figure.wavelength_nm.unwrap_or(0.0);
                        let (lo, hi) = c.interval;
                        format!("{} at {nm} nm {:+.5} ({lo:+.5} to {hi:+.5})", c.figure.name, c.by)
                    });
                    writeln!(
                        f,
                        "{name:<30} {now:<4}  x{:<6.2} {:>8.0}  {:>6.2}  {change}",
                        p.time, p.ns_per_event, p.events
                    )?;
                }
            }
        }
        if let Some((kinds, p)) = &self.everything {
            let names: Vec<&str> = kinds.iter().map(|k| k.name()).collect();
            writeln!(
                f,
                "everything on: x{:.2} the time of the plan; beside it {}",
                p.time,
                names.join(", ")
            )?;
        }
        Ok(())
    }
}
