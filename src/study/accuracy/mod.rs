//! `study accuracy`: what is known of a scene's figures, what every source of error contributes, what each
//! setting costs, and how long a wanted error takes. `study convergence` is the same for one knob.
//!
//! Times are processor seconds; they differ from run to run, and so do these tables.

mod budget;
mod inputs;
mod knobs;
mod plots;
mod settings;
mod tables;
mod words;

pub use inputs::Input2;
pub use knobs::Knob;
pub use tables::{Effect5, Held, Result1, Setting4, Source2, Time3};

use super::timed::{Timed, timed};
use super::{effects, target};
use crate::report::{Figure, Status};
use crate::run::BATCH;
use crate::scene::{Memory, Scene, Universe};
use crate::stats::{Moments, student_quantile};
use crate::tally::Cell;

/// How a study is made.
#[derive(Clone, Debug)]
pub struct Options {
    /// Histories per wavelength group of each setting, instead of the scene's.
    pub histories: Option<u64>,
    /// Processor seconds that each setting may take.
    pub each: f64,
    /// Only this knob (`study convergence`).
    pub knob: Option<String>,
    /// Effects are toggled too.
    pub effects: bool,
    /// Input data are changed too.
    pub inputs: bool,
    /// Error of a reflectance (of 100 for figures in per cent) that settings are recommended for.
    pub wanted: f64,
}

impl Default for Options {
    fn default() -> Self {
        Options { histories: None, each: 20.0, knob: None, effects: true, inputs: true, wanted: 2e-3 }
    }
}

/// How a run went on: after so many histories, processor seconds, mean, error, VOV of the first watched figure.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Step {
    /// Histories per wavelength group.
    pub histories: u64,
    /// Processor seconds.
    pub cpu_seconds: f64,
    /// Running mean of the reflectance.
    pub mean: f64,
    /// Its standard error.
    pub error: f64,
    /// Its variance of the variance.
    pub vov: f64,
    /// Its figure of merit, 1/s.
    pub figure_of_merit: f64,
}

/// A study of a scene.
#[derive(Clone, Debug)]
pub struct Study {
    /// The scene with as many histories as were run.
    pub scene: Scene,
    /// The run of the scene as it is.
    pub base: Timed,
    /// Its course.
    pub steps: Vec<Step>,
    /// T1.
    pub results: Vec<Result1>,
    /// T2.
    pub budget: Vec<Source2>,
    /// T2, input data in parts.
    pub inputs: Vec<Input2>,
    /// T3.
    pub times: Vec<Time3>,
    /// The held-out run.
    pub held: Option<Held>,
    /// T4.
    pub settings: Vec<Setting4>,
    /// T5.
    pub effects: Vec<Effect5>,
    /// Seconds of the processor for making the scene ready, for its light and for its figures.
    pub phases: [f64; 3],
    /// Threads, seconds on the clock, same bytes as one thread.
    pub threads: Vec<(u64, f64, bool)>,
    /// Means of the reflectance in the replicas.
    pub replicas: Vec<f64>,
    /// Knobs that could not be tried, and why.
    pub refused: Vec<(String, String)>,
}

/// Smallest share of the settings' scene that is run.
const BATCHES: u64 = 32;

/// Figures that are watched: reflectance and transmittance at the middle wavelength, brightness, opacity.
fn watched(scene: &Scene, t: &Timed) -> Vec<Figure> {
    let nm = scene.wavelengths[scene.wavelengths.len() / 2];
    let known =
        |f: &Figure| f.value.is_some() && f.error.is_some_and(|e| e > 0.0) && f.status != Status::UpperBound;
    [("reflectance", Some(nm)), ("transmittance", Some(nm)), ("brightness_r457", None), ("opacity", None)]
        .iter()
        .filter_map(|(name, nm)| t.result.figure(name, *nm).filter(|f| known(f)).cloned())
        .collect()
}

/// Error wanted of a figure where settings are recommended.
fn wanted_of(f: &Figure, wanted: f64) -> f64 {
    if f.unit == "%" { 100.0 * wanted } else { wanted }
}

/// Studies a scene on rayon's current threads; `told` hears what is being run.
///
/// # Errors
/// A scene that cannot be run as it is; a knob that it does not have.
pub fn study(scene: &Scene, options: &Options, mut told: impl FnMut(&str)) -> Result<Study, String> {
    let mut own = scene.clone();
    own.expects.clear();
    if let Some(n) = options.histories {
        own.run.histories = n;
    }
    told("the scene as it is");
    fit(&mut own, options.each)?;
    let (base, steps, phases) = course(&own)?;
    let figures = watched(&own, &base);
    if figures.is_empty() {
        return Err("nothing is reflected or transmitted: no figure to study".to_owned());
    }
    let mut all = knobs::all(&own);
    if let Some(name) = &options.knob {
        let names: Vec<&str> = all.iter().map(|k| k.name).collect();
        if !names.contains(&name.as_str()) {
            return Err(format!("the scene has no knob `{name}`; it has {}", names.join(", ")));
        }
        all.retain(|k| k.name == *name);
    }
    let (mut settings, mut refused) = (Vec::new(), Vec::new());
    for knob in &all {
        told(knob.name);
        match settings::turn(knob, &figures, options, &base) {
            Ok(rows) => settings.extend(rows),
            Err(why) => refused.push((knob.name.to_owned(), why)),
        }
    }
    let mut out = Study {
        results: figures.iter().map(|f| result(f, &own, &base)).collect(),
        replicas: replica_means(&own, &base),
        scene: own,
        base,
        steps,
        budget: Vec::new(),
        inputs: Vec::new(),
        times: Vec::new(),
        held: None,
        settings,
        effects: Vec::new(),
        phases,
        threads: Vec::new(),
        refused,
    };
    if options.knob.is_some() {
        return Ok(out);
    }
    if options.effects {
        told("effects");
        out.effects = settings::toggled(&out.scene);
    }
    if options.inputs {
        told("input data");
        out.inputs = inputs::tried(&out.scene, &figures, &out.base);
    }
    out.budget = figures.iter().flat_map(|f| budget::sources(f, &out)).collect();
    out.times = figures.iter().flat_map(|f| budget::times(f, &out)).collect();
    told("a held-out run");
    out.held = held_out(&out, options.each)?;
    told("threads");
    out.threads = threads(&out.scene)?;
    Ok(out)
}

/// As many histories as fit into `seconds` of processor, in batches so small that there are [`BATCHES`].
fn fit(scene: &mut Scene, seconds: f64) -> Result<(), String> {
    let price = |n: u64| {
        let mut few = scene.clone();
        (few.run.histories, few.run.batch) = (n, n);
        timed(&few).map(|t| t.cpu)
    };
    // Between a few and four times as many: what is made before the first history does not count.
    let n = (64 * scene.run.shared).min(1024);
    let each = (price(4 * n)? - price(n)?).max(1e-7) / (3 * n) as f64;
    let n = scene.run.histories.min((seconds / each) as u64).max(BATCHES * scene.run.shared.max(2));
    scene.run.batch = BATCH.min(1 << (n / BATCHES).ilog2());
    if matches!(&scene.universe, Universe::Realised(r) if r.deposit.is_some()) {
        // Each batch meets a sheet of its own.
        scene.run.batch = BATCH;
    }
    scene.run.histories = n.div_ceil(scene.run.batch) * scene.run.batch;
    Ok(())
}

/// Runs the scene in pieces and notes how mean and error go on: four times per doubling of histories.
fn course(scene: &Scene) -> Result<(Timed, Vec<Step>, [f64; 3]), String> {
    use crate::run::clock::processor_seconds;
    use crate::run::simulate::{advance, fresh, outcome};
    let before = processor_seconds();
    let plan = crate::scene::plan::Plan::new(scene)?;
    let mut state = fresh(&plan, 0);
    let (clock, began) = (std::time::Instant::now(), processor_seconds());
    let mut steps = Vec::new();
    let group = plan
        .groups
        .iter()
        .position(|g| g.contains(&scene.wavelengths[scene.wavelengths.len() / 2]))
        .unwrap_or(0);
    let lane =
        |g: &[f64]| g.iter().position(|w| *w == scene.wavelengths[scene.wavelengths.len() / 2]).unwrap_or(0);
    let lane = lane(&plan.groups[group]);
    let lanes = plan.groups[group].len();
    let mut round = |s: &[crate::stats::Fold<crate::run::Sums>]| {
        let done = s[group].next();
        if target::is_look(done) || [2, 4, 8].contains(&done) {
            let mut m = Moments::default();
            for node in s[group].nodes().iter().map(|n| &n.value.node) {
                m.merge(&node.moments(Cell::Reflected as usize, lane, lanes));
            }
            let cpu_seconds = (processor_seconds() - began).max(1e-9);
            steps.push(Step {
                histories: done * scene.run.batch,
                cpu_seconds,
                mean: m.mean(),
                error: m.standard_error(),
                vov: m.vov(),
                figure_of_merit: m.figure_of_merit(cpu_seconds),
            });
        }
        true
    };
    let watch = crate::run::Watch { stop: &|| false, round: &mut round };
    advance(scene, &plan, &mut state, 0..scene.run.histories, watch).map_err(|e| e.to_string())?;
    let (cpu, wall) = (processor_seconds() - began, clock.elapsed().as_secs_f64());
    let outcome = outcome(scene, &plan, state, 0..scene.run.histories)?;
    let result = crate::report::figures::result(scene, &plan, &outcome);
    let phases = [began - before, cpu, processor_seconds() - began - cpu];
    Ok((Timed { outcome, result, cpu: cpu.max(1e-9), wall }, steps, phases))
}

/// Moments of reflectance or transmittance, where the figure is one of them.
fn moments(f: &Figure, t: &Timed) -> Option<Moments> {
    let cell = match f.name.as_str() {
        "reflectance" => Cell::Reflected,
        "transmittance" => Cell::Transmitted,
        _ => return None,
    };
    let (_, group, lane) = t.outcome.wavelengths().find(|w| Some(w.0) == f.wavelength_nm)?;
    Some(group.moments(group.layout.of(cell), lane))
}

fn result(f: &Figure, _scene: &Scene, base: &Timed) -> Result1 {
    let (value, error) = (f.value.unwrap_or(f64::NAN), f.error.unwrap_or(f64::NAN));
    let (low95, high95) = f.interval95().unwrap_or((f64::NAN, f64::NAN));
    let m = moments(f, base);
    let relative_error = error / value.abs();
    Result1 {
        figure: f.title(),
        value,
        error,
        low95,
        high95,
        relative_error,
        vov: m.map(|m| m.vov()),
        skewness: m.map(|m| m.skewness()),
        dof: f.dof.filter(|d| d.is_finite()),
        figure_of_merit: 1.0 / (relative_error * relative_error * base.cpu),
        unit: f.unit.clone(),
    }
}

fn replica_means(scene: &Scene, base: &Timed) -> Vec<f64> {
    let nm = scene.wavelengths[scene.wavelengths.len() / 2];
    let Some((_, g, lane)) = base.outcome.wavelengths().find(|w| w.0 == nm) else { return Vec::new() };
    let index = g.layout.of(Cell::Reflected) * g.layout.lanes + lane;
    g.node.replicas.values().map(|(n, sums)| sums[index] / *n as f64).collect()
}

/// One run of another seed to the hardest target that fits into `seconds`: does the prediction hold?
fn held_out(study: &Study, seconds: f64) -> Result<Option<Held>, String> {
    let reachable = |t: &&Time3| {
        t.note.is_empty() && t.cpu_seconds.is_some_and(|s| s <= seconds.max(2.0 * study.base.cpu))
    };
    let Some(t) = study
        .times
        .iter()
        .filter(reachable)
        .max_by(|a, b| a.cpu_seconds.partial_cmp(&b.cpu_seconds).unwrap_or(std::cmp::Ordering::Equal))
    else {
        return Ok(None);
    };
    let (Some(predicted_cpu), Some(n)) = (t.cpu_seconds, t.histories) else { return Ok(None) };
    let mut scene = study.scene.clone();
    scene.run.seed = scene.run.seed.wrapping_add(0x5eed);
    scene.run.batch = BATCH.min(1 << (n / BATCHES).max(scene.run.shared).max(2).ilog2());
    scene.run.histories = n.div_ceil(scene.run.batch) * scene.run.batch;
    let ran = timed(&scene)?;
    let title = |f: &&Figure| f.title() == t.figure;
    let find = |r: &Timed| r.result.figures.iter().find(title).and_then(|f| Some((f.value?, f.error?)));
    let (Some((new, reached)), Some((old, error))) = (find(&ran), find(&study.base)) else { return Ok(None) };
    // Whole batches are more than were predicted.
    let measured_cpu = ran.cpu * n as f64 / scene.run.histories as f64;
    Ok(Some(Held {
        target: t.target.clone(),
        histories: scene.run.histories,
        predicted_cpu,
        measured_cpu,
        wanted: t.wanted,
        reached,
        cpu_of_target: ran.cpu * (reached / t.wanted).powi(2),
        ratio: ran.cpu * (reached / t.wanted).powi(2) / predicted_cpu,
        z: (new - old) / (reached * reached + error * error).sqrt(),
    }))
}

/// The same run on 1, 2, 4 … threads: seconds on the clock, and whether the bytes are the same.
fn threads(scene: &Scene) -> Result<Vec<(u64, f64, bool)>, String> {
    let mut few = scene.clone();
    few.run.histories = (scene.run.histories / 4).max(scene.run.batch * 2);
    let most = std::thread::available_parallelism().map_or(1, usize::from);
    let mut out: Vec<(u64, f64, bool)> = Vec::new();
    let mut first = None;
    for n in [1, 2, 4, 8, 16, 32].into_iter().filter(|n| *n <= most.max(2)) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().map_err(|e| e.to_string())?;
        let ran = pool.install(|| timed(&few))?;
        let json = ran.result.to_json();
        let same = *first.get_or_insert_with(|| json.clone()) == json;
        out.push((n as u64, ran.wall, same));
    }
    Ok(out)
}
