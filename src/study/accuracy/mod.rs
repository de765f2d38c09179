//! `study accuracy`: what is known of a scene's figures, what every source of error contributes, what each
//! setting costs, and how long a wanted error takes. `study convergence` is the same for one knob.
//!
//! Times are processor seconds; they differ from run to run, and so do these tables.

mod knobs;
mod plots;
mod tables;
mod words;

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
    /// Error of a reflectance (of 100 for figures in per cent) that settings are recommended for.
    pub wanted: f64,
}

impl Default for Options {
    fn default() -> Self {
        Options { histories: None, each: 20.0, knob: None, effects: true, wanted: 2e-3 }
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
    /// T3.
    pub times: Vec<Time3>,
    /// The held-out run.
    pub held: Option<Held>,
    /// T4.
    pub settings: Vec<Setting4>,
    /// T5.
    pub effects: Vec<Effect5>,
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
    let (base, steps) = course(&own)?;
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
        match turn(knob, &figures, options, &base) {
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
        times: Vec::new(),
        held: None,
        settings,
        effects: Vec::new(),
        threads: Vec::new(),
        refused,
    };
    if options.knob.is_some() {
        return Ok(out);
    }
    if options.effects {
        told("effects");
        out.effects = toggled(&out.scene);
    }
    out.budget = figures.iter().flat_map(|f| budget(f, &out)).collect();
    out.times = figures.iter().flat_map(|f| times(f, &out)).collect();
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
fn course(scene: &Scene) -> Result<(Timed, Vec<Step>), String> {
    use crate::run::clock::processor_seconds;
    use crate::run::simulate::{advance, fresh, outcome};
    let plan = crate::scene::plan::Plan::new(scene)?;
    let mut state = fresh(&plan, 0);
    let (clock, cpu) = (std::time::Instant::now(), processor_seconds());
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
            let cpu_seconds = (processor_seconds() - cpu).max(1e-9);
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
    let (cpu, wall) = (processor_seconds() - cpu, clock.elapsed().as_secs_f64());
    let outcome = outcome(scene, &plan, state, 0..scene.run.histories)?;
    let result = crate::report::figures::result(scene, &plan, &outcome);
    Ok((Timed { outcome, result, cpu: cpu.max(1e-9), wall }, steps))
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

/// Every setting of a knob, with the seed of the scene: runs that draw alike are compared pair by pair.
fn turn(knob: &Knob, figures: &[Figure], options: &Options, base: &Timed) -> Result<Vec<Setting4>, String> {
    let mut ran: Vec<(usize, Timed, u64)> = Vec::new();
    for (i, (_, _, scene)) in knob.settings.iter().enumerate() {
        if i == knob.own {
            ran.push((i, base.clone(), scene.run.histories));
            continue;
        }
        let mut scene = scene.clone();
        fit(&mut scene, options.each)?;
        ran.push((i, timed(&scene)?, scene.run.histories));
    }
    let reference = ran.iter().find(|r| r.0 == knob.reference).ok_or("no reference")?.1.clone();
    let mut out = Vec::new();
    for f in figures {
        let find = |t: &Timed| t.result.figures.iter().find(|g| g.is_of(f) && g.value.is_some()).cloned();
        let Some(r) = find(&reference) else { continue };
        let own_noise = f.error.map_or(f64::NAN, |e| e * e) * base.cpu;
        let mut rows = Vec::new();
        for (i, t, histories) in &ran {
            let Some(g) = find(t) else { continue };
            let (setting, h, _) = &knob.settings[*i];
            let (bias, bias_error) = difference(&reference, &r, t, &g);
            let error = g.error.unwrap_or(f64::NAN);
            rows.push(Setting4 {
                knob: knob.name.to_owned(),
                setting: setting.clone(),
                h: *h,
                figure: f.title(),
                value: g.value.unwrap_or(f64::NAN),
                error,
                bias,
                bias_error,
                histories: *histories,
                cpu_seconds: t.cpu,
                times_own: error * error * t.cpu / own_noise,
                order: None,
                richardson: None,
                mark: match (*i == knob.own, *i == knob.reference) {
                    (true, true) => "own, reference".to_owned(),
                    (true, false) => "own".to_owned(),
                    (false, true) => "reference".to_owned(),
                    _ => String::new(),
                },
            });
        }
        orders(&mut rows);
        recommend(&mut rows, wanted_of(f, options.wanted));
        out.extend(rows);
    }
    Ok(out)
}

/// Value less reference, and its error: from paired replicas where both have as many histories and draw the
/// same numbers, if that is the smaller error; else as of independent runs.
fn difference(reference: &Timed, r: &Figure, t: &Timed, g: &Figure) -> (f64, f64) {
    let by = g.value.unwrap_or(f64::NAN) - r.value.unwrap_or(f64::NAN);
    if std::ptr::eq(reference, t) || by == 0.0 && r.error == g.error {
        return (0.0, 0.0);
    }
    let apart = (r.error.unwrap_or(0.0).powi(2) + g.error.unwrap_or(0.0).powi(2)).sqrt();
    let alike = reference.result.histories == t.result.histories;
    let changes = if alike { effects::changes(&reference.outcome, &t.outcome) } else { Vec::new() };
    let paired =
        changes.iter().find(|c| c.figure.name == g.name && c.figure.wavelength_nm == g.wavelength_nm);
    // Half the width of a 95 % interval of 31 degrees of freedom.
    let paired = paired.map(|c| 0.5 * (c.interval.1 - c.interval.0) / student_quantile(0.975, 31.0));
    (by, paired.map_or(apart, |p| p.min(apart)))
}

/// Observed order from three meshes h, h/2, h/4 whose differences are above their noise (two errors); second
/// order is extrapolated where the ratio per doubling is between 3 and 5 (exactly 4 for pure second order).
fn orders(rows: &mut [Setting4]) {
    for i in 2..rows.len() {
        let (a, b, c) = (&rows[i - 2], &rows[i - 1], &rows[i]);
        let halves = |x: f64, y: f64| y > 0.0 && (x / y - 2.0).abs() < 1e-9;
        if !(halves(a.h, b.h) && halves(b.h, c.h)) {
            continue;
        }
        let (first, second) = (a.value - b.value, b.value - c.value);
        let noise = |x: &Setting4, y: &Setting4| 2.0 * (x.error * x.error + y.error * y.error).sqrt();
        if first.abs() < noise(a, b) || second.abs() < noise(b, c) || first / second <= 0.0 {
            continue;
        }
        let ratio = first / second;
        let finest = c.value - second / 3.0;
        rows[i].order = Some(crate::math::ln(ratio) / crate::math::ln(2.0));
        rows[i].richardson = (3.0..=5.0).contains(&ratio).then_some(finest);
    }
}

/// Marks the setting that reaches the wanted error (bias and noise) in the least time: cost × noise over what
/// the bias leaves of it. A bias that is not told from 0 counts with its error.
fn recommend(rows: &mut [Setting4], wanted: f64) {
    let price = |r: &Setting4| {
        let bias = if r.bias.abs() > 2.0 * r.bias_error { r.bias.abs() } else { 0.0 };
        let left = wanted * wanted - bias * bias;
        if left > 0.0 { r.error * r.error * r.cpu_seconds / left } else { f64::INFINITY }
    };
    let best = (0..rows.len()).min_by(|a, b| price(&rows[*a]).total_cmp(&price(&rows[*b])));
    // Where nothing is gained (a tenth of the time), the scene stays as it is.
    let own = rows.iter().position(|r| r.mark.starts_with("own"));
    let best = match (best, own) {
        (Some(b), Some(o)) if price(&rows[o]) <= 1.1 * price(&rows[b]) => Some(o),
        _ => best,
    };
    if let Some(best) = best.filter(|b| price(&rows[*b]).is_finite()) {
        let before = std::mem::take(&mut rows[best].mark);
        rows[best].mark =
            if before.is_empty() { "recommended".into() } else { format!("{before}, recommended") };
    }
}

fn toggled(scene: &Scene) -> Vec<Effect5> {
    let mut few = scene.clone();
    few.run.histories = (scene.run.histories / 4).max(scene.run.batch);
    let Ok(study) = effects::study(&few) else { return Vec::new() };
    let row = |t: &effects::Toggled| {
        let price = t.outcome.as_ref().ok();
        let largest = price.and_then(|p| p.changes.iter().max_by(|a, b| a.by.abs().total_cmp(&b.by.abs())));
        let called = crate::scene::effects::settle(scene).into_iter().find(|e| e.name == t.kind.name());
        Effect5 {
            effect: t.kind.name().to_owned(),
            on: t.on,
            times: price.map(|p| p.time),
            ns_per_event: price.map(|p| p.ns_per_event),
            events: price.map(|p| p.events),
            change: largest.map(|c| c.by),
            low95: largest.map(|c| c.interval.0),
            high95: largest.map(|c| c.interval.1),
            note: t.outcome.as_ref().err().cloned().or(called.map(|c| c.reason)).unwrap_or_default(),
        }
    };
    study.effects.iter().map(row).collect()
}

/// The bias of the scene's own setting of a knob, if it is told from 0 (two errors), and the row.
fn own_bias<'a>(study: &'a Study, knob: &str, figure: &str) -> Option<(&'a Setting4, bool)> {
    let row =
        study.settings.iter().find(|s| s.knob == knob && s.figure == figure && s.mark.starts_with("own"))?;
    Some((row, row.bias.abs() > 2.0 * row.bias_error))
}

/// T2 of a figure: one line a source, never merged.
fn budget(f: &Figure, study: &Study) -> Vec<Source2> {
    let title = f.title();
    let mut out = Vec::new();
    let mut put = |source: &str, size: Option<f64>, error: Option<f64>, how: &str, note: String| {
        out.push(Source2 {
            figure: title.clone(),
            source: source.to_owned(),
            size,
            error,
            how: how.to_owned(),
            note,
        });
    };
    let n = study.base.result.histories;
    put("statistical", f.error, None, "measured", format!("{n} histories of each wavelength group"));
    let between =
        study.base.result.figures.iter().find(|g| {
            g.name == format!("{}_between_realisations", f.name) && g.wavelength_nm == f.wavelength_nm
        });
    match (between.and_then(|b| b.value), study.scene.run.shared) {
        (Some(sd), m) => {
            let size = sd / ((n / m) as f64).sqrt();
            put(
                "realisation",
                Some(size),
                None,
                "measured",
                format!("contained in the statistical error; {m} histories each"),
            );
        }
        (None, _) => {
            let note = match &study.scene.universe {
                Universe::Statistical(_) | Universe::Realised(_) => {
                    "every history has a realisation of its own"
                }
                _ => "one given structure: others of its kind were not seen",
            };
            let known = study.scene.universe.sheet().is_some();
            put(
                "realisation",
                known.then_some(0.0),
                None,
                if known { "assumed" } else { "not assessed" },
                note.to_owned(),
            );
        }
    }
    for (source, knob, absent) in [
        ("SAP", "patches", "no patches: the continuous law"),
        ("branching", "branching floor", "drawn rays, no branches"),
        ("roulette", "roulette", "analog absorption"),
        ("wavelength grid", "wavelength grid", "the figure belongs to one wavelength"),
        ("universe model", "memory", ""),
    ] {
        match own_bias(study, knob, &title) {
            Some((row, told)) => {
                let how = if told { "measured" } else { "bounded" };
                let size = if told { row.bias } else { 2.0 * row.bias_error };
                let of = study.settings.iter().find(|s| s.knob == knob && s.mark.contains("reference"));
                let note = format!("setting {} against {}", row.setting, of.map_or("", |r| &r.setting));
                let exact = row.mark.contains("reference") && row.h == 0.0;
                if exact {
                    put(source, Some(0.0), None, "assumed", format!("{} is the reference", row.setting));
                } else {
                    put(source, Some(size), Some(row.bias_error), how, note);
                }
            }
            None if source == "universe model" => {
                let note = match &study.scene.universe {
                    Universe::Statistical(s) if s.memory == Memory::Full => {
                        "full memory: exact for the Boolean ensemble"
                    }
                    Universe::Realised(_) => "explicit realisations of the Boolean ensemble",
                    _ => "compare with another universe: lightpro compare",
                };
                put(source, None, None, "not assessed", note.to_owned());
            }
            None if study.refused.iter().any(|r| r.0 == knob) => {
                put(
                    source,
                    None,
                    None,
                    "not assessed",
                    study.refused.iter().find(|r| r.0 == knob).map_or(String::new(), |r| r.1.clone()),
                );
            }
            None => put(source, Some(0.0), None, "assumed", absent.to_owned()),
        }
    }
    match &study.scene.universe {
        Universe::Voxel(_) => put(
            "voxel size",
            None,
            None,
            "not assessed",
            "a finer volume beside: lightpro compare --with".into(),
        ),
        _ => put("voxel size", Some(0.0), None, "assumed", "no voxels".into()),
    }
    let off = study.effects.iter().filter(|e| !e.on && e.change.is_some());
    let largest = off.max_by(|a, b| {
        a.change.map(f64::abs).partial_cmp(&b.change.map(f64::abs)).unwrap_or(std::cmp::Ordering::Equal)
    });
    match largest {
        Some(e) => put(
            "effects left out",
            e.change.map(f64::abs),
            None,
            "bounded",
            format!("{}: the largest change of R or T by any that can be put in", e.effect),
        ),
        None => put("effects left out", None, None, "not assessed", String::new()),
    }
    put(
        "input data",
        None,
        None,
        "not assessed",
        "a scene states no uncertainties: run --sweep over them".to_owned(),
    );
    out
}

/// T3 of a figure.
fn times(f: &Figure, study: &Study) -> Vec<Time3> {
    let (value, error) = (f.value.unwrap_or(f64::NAN), f.error.unwrap_or(f64::NAN));
    let mut targets: Vec<(String, f64)> =
        [10.0, 3.0, 1.0, 0.3, 0.1].iter().map(|p| (format!("{p}%"), p * 0.01 * value.abs())).collect();
    if f.unit == "%" {
        targets.push(("0.1".to_owned(), 0.1));
    }
    let name = f
        .wavelength_nm
        .filter(|_| study.scene.wavelengths.len() > 1)
        .map_or(f.name.clone(), |nm| format!("{}@{nm}", f.name));
    // Floors: biases of the scene's own settings that are told from 0.
    let floors: Vec<&Setting4> = ["memory", "patches", "wavelength grid"]
        .iter()
        .filter_map(|k| own_bias(study, k, &f.title()).filter(|b| b.1).map(|b| b.0))
        .collect();
    let floor = floors.iter().map(|r| r.bias * r.bias).sum::<f64>().sqrt();
    let row = |(target, wanted): (String, f64)| {
        let target = format!("{name}:{target}");
        let left = wanted * wanted - floor * floor;
        if left <= 0.0 {
            return Time3 {
                figure: f.title(),
                target,
                wanted,
                histories: None,
                cpu_seconds: None,
                low: None,
                high: None,
                note: never(study, &floors, floor, wanted),
            };
        }
        let times = error * error / left;
        // A variance known with ν degrees of freedom: ± 2 √(2/ν).
        let band = 2.0 * (2.0 / f.dof.unwrap_or(31.0).max(2.0)).sqrt();
        let cpu = study.base.cpu * times;
        Time3 {
            figure: f.title(),
            target,
            wanted,
            histories: Some((study.base.result.histories as f64 * times).ceil() as u64),
            cpu_seconds: Some(cpu),
            low: Some(cpu / (1.0 + band)),
            high: Some(cpu * (1.0 + band)),
            note: if floor > 0.0 { format!("bias {floor:.5} counted in") } else { String::new() },
        }
    };
    targets.into_iter().map(row).collect()
}

/// Why a target is out of reach, and the cheapest setting that reaches it.
fn never(study: &Study, floors: &[&Setting4], floor: f64, wanted: f64) -> String {
    let worst = floors.iter().max_by(|a, b| a.bias.abs().total_cmp(&b.bias.abs()));
    let Some(worst) = worst else { return String::new() };
    let mut text = format!("never: floor is {floor:.5} by {} {}", worst.knob, worst.setting);
    let others = study.settings.iter().filter(|s| {
        s.knob == worst.knob
            && s.figure == worst.figure
            && s.setting != worst.setting
            && (s.bias.abs() <= 2.0 * s.bias_error || s.bias.abs() < wanted)
    });
    let price = |s: &&Setting4| s.error * s.error * s.cpu_seconds / (wanted * wanted);
    if let Some(better) = others.min_by(|a, b| price(a).total_cmp(&price(b))) {
        text += &format!("; {} {} instead, estimated {:.3} s", better.knob, better.setting, price(&better));
    }
    text
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
