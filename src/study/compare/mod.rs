//! `compare`: the same sheet in several universes; where they agree, where they differ, what each costs.

mod points;
mod price;
mod text;
mod universes;
mod verdict;

pub use points::{Axis, Point, margin_of};
pub use price::{Price, Spread};
pub use universes::Entry;
pub use verdict::{Claim, LEVEL, Row, Verdict};

use crate::report::{self, RunResult};
use crate::run::clock::processor_seconds;
use crate::run::simulate::{advance, fresh, outcome};
use crate::run::{BATCH, Outcome, Watch};
use crate::scene::plan::Plan;
use crate::scene::{Branching, Edges, Memory, Realised, Scene, StartIn, Universe};
use std::time::{Duration, Instant};

/// Batches of each universe at least.
const BATCHES: u64 = 32;

/// Histories that share an explicit realisation where neither scene nor command say.
const SHARED: u64 = 16;

/// How a comparison is made.
#[derive(Clone, Debug)]
pub struct Options {
    /// Differences of a reflectance within ± this count as none; other figures follow ([`margin_of`]).
    pub margin: f64,
    /// Standard error (of a reflectance, and as its share of the margin of others) that prices are given
    /// for.
    pub error: f64,
    /// Histories per wavelength group in each universe, instead of the scene's.
    pub histories: Option<u64>,
    /// Histories that share a realisation, where universes have realisations.
    pub shared: Option<u64>,
    /// Time on the clock for all universes together; what is not done by then is left out, batch by batch.
    pub time: Duration,
    /// Name of the reference; by default Boolean realisations, else full memory, else the first.
    pub reference: Option<String>,
}

impl Default for Options {
    /// Margin .005, priced at .001, eight minutes.
    fn default() -> Self {
        Options {
            margin: 0.005,
            error: 1e-3,
            histories: None,
            shared: None,
            time: Duration::from_secs(480),
            reference: None,
        }
    }
}

/// A universe that has been run.
#[derive(Debug)]
pub struct Ran {
    /// Its name.
    pub name: String,
    /// The scene in it.
    pub scene: Scene,
    /// Its plan.
    pub plan: Plan,
    /// Sums.
    pub outcome: Outcome,
    /// Figures.
    pub result: RunResult,
    /// What is compared.
    pub points: Vec<Point>,
    /// Processor seconds.
    pub cpu: f64,
    /// Seconds on the clock.
    pub wall: f64,
}

/// A comparison.
#[derive(Debug)]
pub struct Comparison {
    /// Universes that were run.
    pub ran: Vec<Ran>,
    /// Those that could not be, and why.
    pub refused: Vec<(String, String)>,
    /// Which of `ran` the others are held against.
    pub reference: usize,
    /// How.
    pub options: Options,
    /// Every value against the reference.
    pub rows: Vec<Row>,
    /// Verdicts.
    pub claims: Vec<Claim>,
    /// Prices.
    pub prices: Vec<Price>,
    /// Variance between realisations, where they are told apart.
    pub spreads: Vec<Spread>,
}

/// Runs a scene in all these universes (`others`: scenes of their own with their names) on rayon's current
/// threads, and compares. `told` hears the name of each before it starts.
///
/// # Errors
/// Fewer than two universes that can be run; a reference that is not among them; a worker that panics.
pub fn compare(
    scene: &Scene,
    entries: &[Entry],
    others: &[(String, Scene)],
    options: &Options,
    mut told: impl FnMut(&str),
) -> Result<Comparison, String> {
    if !(options.margin > 0.0 && options.error > 0.0) {
        return Err("margin and error must be positive".to_owned());
    }
    if let Some(m) = options.shared.filter(|m| !m.is_power_of_two() || *m > BATCH) {
        return Err(format!("{m} histories per realisation: 1, 2, 4 … {BATCH}"));
    }
    let mut refused = Vec::new();
    let mut scenes: Vec<(String, Scene, Plan)> = Vec::new();
    let made = entries.iter().map(|e| (e.to_string(), e.of(scene)));
    let given = others.iter().map(|(name, s)| (name.clone(), Entry::Written.of(s)));
    for (i, (name, own)) in made.chain(given).enumerate() {
        let ready = own.and_then(|s| {
            let s = prepared(s, options, i);
            let plan = Plan::new(&s)?;
            Ok((s, plan))
        });
        match ready {
            Ok((s, plan)) => scenes.push((name, s, plan)),
            Err(why) => refused.push((name, why)),
        }
    }
    if scenes.len() < 2 {
        let why: Vec<String> = refused.iter().map(|(n, w)| format!("{n}: {w}")).collect();
        return Err(format!("a comparison needs two universes that can be run; {}", why.join("; ")));
    }
    let reference = reference(&scenes, options)?;
    let started = Instant::now();
    let mut roots = Vec::new();
    for (name, scene, plan) in &scenes {
        roots.push(price_of_history(scene, plan).map_err(|e| format!("{name}: {e}"))?.sqrt());
    }
    let mut ran = Vec::new();
    for (i, (name, scene, plan)) in scenes.into_iter().enumerate() {
        told(&name);
        // Time as the root of the price of a history: so the differences have the least error. What one leaves of
        // its share is there for the others.
        let share = roots[i] / roots[i..].iter().sum::<f64>();
        let time = options.time.saturating_sub(started.elapsed()).mul_f64(share);
        ran.push(run(name, scene, plan, time, roots[i] * roots[i])?);
    }
    let rows: Vec<Row> = ran
        .iter()
        .enumerate()
        .filter(|(i, _)| *i != reference)
        .flat_map(|(_, r)| {
            r.points.iter().filter_map(|p| verdict::row(&r.name, p, &ran[reference].points, options.margin))
        })
        .collect();
    let claims = verdict::claims(&rows);
    let prices = price::prices(&ran, reference, options);
    let spreads = ran.iter().flat_map(price::spreads).collect();
    Ok(Comparison { ran, refused, reference, options: options.clone(), rows, claims, prices, spreads })
}

/// The scene as it is run: independent of the others, with shared realisations.
fn prepared(mut scene: Scene, options: &Options, number: usize) -> Scene {
    scene.run.histories = options.histories.unwrap_or(scene.run.histories).max(BATCHES * 2);
    // Another seed each: equal streams would make universes that draw alike look better than they are.
    scene.run.seed = scene.run.seed.wrapping_add(number as u64 * 0x9e37_79b9);
    let split = matches!(scene.run.branching, Branching::Split { .. });
    let most = 1 << (scene.run.histories / BATCHES).ilog2();
    scene.run.shared = match &scene.universe {
        Universe::Realised(Realised { deposit: Some(_), .. }) => 1,
        Universe::Realised(_) => options.shared.unwrap_or(SHARED).min(most),
        Universe::Statistical(s) if s.memory == Memory::Full && !split => {
            // A later history may find a body where it should start in a pore.
            let anywhere = s.edges == Edges::Contained || s.start == StartIn::Anywhere;
            if anywhere { options.shared.unwrap_or(1).min(most) } else { 1 }
        }
        _ => 1,
    };
    scene
}

fn reference(scenes: &[(String, Scene, Plan)], options: &Options) -> Result<usize, String> {
    let find = |name: &str| scenes.iter().position(|s| s.0 == name);
    match &options.reference {
        Some(name) => find(name).ok_or_else(|| {
            let names: Vec<&str> = scenes.iter().map(|s| s.0.as_str()).collect();
            format!("no universe `{name}` to be the reference; there are {}", names.join(", "))
        }),
        None => Ok(find("boolean").or_else(|| find("full")).unwrap_or(0)),
    }
}

/// Processor seconds of a history (of all wavelength groups): between a few and four times as many, so that
/// what is made before the first history does not count.
fn price_of_history(scene: &Scene, plan: &Plan) -> Result<f64, String> {
    let price = |n: u64| {
        let mut pilot = scene.clone();
        (pilot.run.histories, pilot.run.batch) = (n, n);
        let cpu = processor_seconds();
        let mut state = fresh(plan, 0);
        let watch = Watch { stop: &|| false, round: &mut |_| true };
        advance(&pilot, plan, &mut state, 0..n, watch).map_err(|e| e.to_string())?;
        Ok::<f64, String>(processor_seconds() - cpu)
    };
    let few = scene.run.shared.max(16);
    Ok((price(4 * few)? - price(few)?).max(1e-6) / (3 * few) as f64)
}

/// As many histories as `time` allows, and batches so small that there are [`BATCHES`] of them: errors of
/// derived figures come from batches.
fn cut(scene: &mut Scene, time: Duration, each: f64) {
    let room = 0.8 * time.as_secs_f64() * rayon::current_num_threads() as f64 / each;
    let least = BATCHES * scene.run.shared.max(2);
    let wanted = scene.run.histories.min(room as u64).max(least);
    scene.run.batch = BATCH.min(1 << (wanted / BATCHES).ilog2());
    if let Universe::Realised(Realised { deposit: Some(d), .. }) = &scene.universe {
        // Each batch meets a sheet of its own: whole batches, as many for each sheet.
        scene.run.batch = BATCH;
        scene.run.histories = wanted.div_ceil(BATCH * d.realisations) * BATCH * d.realisations;
        return;
    }
    scene.run.histories = wanted / scene.run.batch * scene.run.batch;
}

/// Runs one universe for at most `time`, one batch at least.
fn run(name: String, mut scene: Scene, plan: Plan, time: Duration, each: f64) -> Result<Ran, String> {
    let clock = Instant::now();
    cut(&mut scene, time, each);
    let cpu = processor_seconds();
    let mut state = fresh(&plan, 0);
    let all = 0..scene.run.histories;
    let mut round = |_: &[crate::stats::Fold<crate::run::Sums>]| clock.elapsed() < time;
    let watch = Watch { stop: &|| false, round: &mut round };
    advance(&scene, &plan, &mut state, all.clone(), watch).map_err(|e| format!("{name}: {e}"))?;
    let (cpu, wall) = (processor_seconds() - cpu, clock.elapsed().as_secs_f64());
    let outcome = outcome(&scene, &plan, state, all)?;
    let result = report::figures::result(&scene, &plan, &outcome);
    let points = points::points(&scene, &plan, &outcome, &result);
    Ok(Ran { name, scene, plan, outcome, result, points, cpu, wall })
}
