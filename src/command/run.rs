//! `run`, `resume` and `merge`: simulations that end in a results folder.

use super::aims;
use super::finish::{conclude, on_pool, verdict, with_overrides};
use super::folder::{CHECKPOINT, checkpoint, room, scene_of, sweep};
use super::stop::Stop;
use super::{Failure, Finished, RunArgs, SceneArgs, cpu_seconds, heading, load, say};
use crate::report::manifest::{Host, InputFile, peak_memory_bytes};
use crate::report::{self, Manifest, RunFolder, RunResult, text};
use crate::run::checkpoint::{Identity, to_bytes};
use crate::run::simulate::{State, fresh};
use crate::run::{BATCH, Health, Progress, Sums, Watch};
use crate::scene::Scene;
use crate::scene::plan::Plan;
use crate::stats::Fold;
use crate::study::aims::Aims;
use crate::study::target::{self, Target};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A run about to go on.
struct Job {
    scene: Scene,
    plan: Plan,
    identity: Identity,
    state: State,
    folder: RunFolder,
    targets: Vec<Target>,
}

/// `run`: simulates, writes the results folder, prints the table of figures.
///
/// # Errors
/// As [`load`] and [`super::finish`]; a folder that cannot be written, too little memory or disk; a
/// physics check that fails; a signal.
pub fn run(scene_args: &SceneArgs, args: &RunArgs) -> Result<(), Failure> {
    let (mut scene, _) = load(scene_args)?;
    if !args.targets.is_empty() {
        aims::check(&scene, &args.targets)?;
        scene.run.histories = target::MOST;
    }
    let (scene, plan, range) = with_overrides(scene, args)?;
    let folder = made(args.out.clone().unwrap_or_else(|| default_folder(&scene.path)), args.force)?;
    let state = fresh(&plan, range.start);
    let targets = args.targets.clone();
    let identity = Identity::of(&scene, &scene_args.defines, scene_args.allow_outside, range)
        .with_targets(targets.iter().map(Target::to_string).collect());
    go(Job { scene, plan, identity, state, folder, targets }, args)
}

/// `resume`: takes a run up at its last checkpoint; ends in the same bytes as if it had never stopped
/// (`manifest.json`, which tells times, apart).
///
/// # Errors
/// As [`run`]; a folder without a valid checkpoint, a scene that has changed.
pub fn resume(dir: &Path, args: &RunArgs) -> Result<(), Failure> {
    let stored = checkpoint(dir)?;
    let (scene, plan) = scene_of(&stored.identity)?;
    sweep(dir);
    let folder = made(dir.to_owned(), true)?;
    let targets = stored.identity.targets.iter().map(|t| Target::parse(t)).collect::<Result<_, _>>();
    let targets = targets.map_err(|e: String| Failure::Input(format!("error: {}: {e}", dir.display())))?;
    go(Job { scene, plan, identity: stored.identity, state: stored.state, folder, targets }, args)
}

/// `merge`: one run from its shards; the same bytes as if it had been run at once (`manifest.json` apart).
///
/// # Errors
/// Shards of different runs, unfinished ones, gaps and overlaps.
pub fn merge(dirs: &[PathBuf], args: &RunArgs) -> Result<(), Failure> {
    let refuse = |dir: &Path, why: String| Failure::Input(format!("error: {}: {why}", dir.display()));
    let mut shards = Vec::new();
    for dir in dirs {
        shards.push((dir, checkpoint(dir)?));
    }
    shards.sort_by_key(|(_, s)| s.identity.range.start);
    let Some((_, first)) = shards.first() else {
        return Err(Failure::Input("error: no shards to merge".to_owned()));
    };
    let mut identity = first.identity.clone();
    let (scene, plan) = scene_of(&identity)?;
    let mut state = fresh(&plan, 0);
    let mut at = 0;
    for (dir, shard) in shards {
        let range = shard.identity.range.clone();
        if let Some(why) = shard.identity.differs(&identity) {
            return Err(refuse(dir, format!("no part of the same run: {why}")));
        }
        if range.start != at {
            let what = if range.start > at { "missing" } else { "there twice" };
            let (low, high) = (at.min(range.start), at.max(range.start));
            return Err(refuse(
                dir,
                format!("starts at history {}: histories {low}..{high} are {what}", range.start),
            ));
        }
        let end = range.end.div_ceil(BATCH);
        if shard.state.len() != state.len() || shard.state.iter().any(|f| f.next() != end) {
            return Err(refuse(dir, "not finished; `lightpro resume` it first".to_owned()));
        }
        for (whole, part) in state.iter_mut().zip(shard.state) {
            for node in part.nodes() {
                if whole.push_node(node.clone()).is_err() {
                    return Err(refuse(dir, "its sums do not follow those before".to_owned()));
                }
            }
        }
        at = range.end;
    }
    if at != identity.histories {
        let text = format!("error: histories {at}..{} are missing", identity.histories);
        return Err(Failure::Input(text));
    }
    identity.range = 0..at;
    let folder = made(args.out.clone().unwrap_or_else(|| default_folder(&scene.path)), args.force)?;
    go(Job { scene, plan, identity, state, folder, targets: Vec::new() }, args)
}

fn made(out: PathBuf, force: bool) -> Result<RunFolder, Failure> {
    RunFolder::create(&out, force).map_err(|e| {
        let resumable = e.kind() == io::ErrorKind::AlreadyExists && out.join(CHECKPOINT).is_file();
        let help = if resumable { "; `lightpro resume` goes on with the run in it" } else { "" };
        Failure::Input(format!("error: results folder {}: {e}{help}", out.display()))
    })
}

pub(super) fn default_folder(scene: &Path) -> PathBuf {
    Path::new("results").join(scene.file_stem().unwrap_or(scene.as_os_str()))
}

/// When checkpoints are written: a hundredth of the time at most, unless asked for more often.
struct Saves {
    every: Option<Duration>,
    last: Instant,
    cost: Duration,
}

impl Saves {
    fn due(&self) -> bool {
        let every = self.every.unwrap_or_else(|| Duration::from_secs(60).max(100 * self.cost));
        self.last.elapsed() >= every
    }
    fn save(&mut self, folder: &RunFolder, identity: &Identity, state: &[Fold<Sums>]) -> io::Result<()> {
        let start = Instant::now();
        folder.write(CHECKPOINT, &to_bytes(identity, state))?;
        (self.last, self.cost) = (Instant::now(), start.elapsed());
        Ok(())
    }
}

/// Runs what is left of a job, and writes its results.
fn go(mut job: Job, args: &RunArgs) -> Result<(), Failure> {
    let unwritten = |path: &Path, e: io::Error| {
        Failure::Input(format!("error: writing to {}: {e}; what was there before is whole", path.display()))
    };
    let out = job.folder.path().to_owned();
    let stop = Stop::listen(args.max_time)?;
    let talk = !args.quiet && !args.json;
    let range = job.identity.range.clone();
    let count = range.end - range.start;
    let needs = room(&job.folder, &job.scene, &job.plan, count, args.threads, args.max_memory)?;
    if talk {
        say(&format!("{}\n{}{needs}", heading(&job.scene), job.plan))?;
        if let Some(at) = job.state.first().map(|f| f.next() * BATCH).filter(|&at| at > range.start) {
            say(&format!("{} histories of each wavelength group are done", at.min(range.end) - range.start))?;
        }
    }
    let mut saves = Saves { every: args.checkpoint_every, last: Instant::now(), cost: Duration::ZERO };
    saves.save(&job.folder, &job.identity, &job.state).map_err(|e| unwritten(&out, e))?;
    let started = (Instant::now(), cpu_seconds());
    let bar = bar(count * job.plan.groups.len() as u64, args.quiet);
    let mut failed = None;
    let mut aims = Aims::new(&job.targets);
    let mut round = |s: &[Fold<Sums>]| {
        let p = Progress::of(s, &range, job.scene.run.histories);
        bar.set_position(p.done);
        bar.set_message(format!("R {:.4} ± {:.4}", p.reflectance.0, p.reflectance.1));
        let enough = aims.look(&job.scene, &job.plan, s);
        if let Some(n) = aims.predicted() {
            bar.set_length(n.min(count) * s.len() as u64);
        }
        if saves.due() {
            failed = saves.save(&job.folder, &job.identity, s).err();
        }
        failed.is_none() && !enough
    };
    // A run may have been killed between reaching its targets and writing its results.
    if round(&job.state) {
        let watch = Watch { stop: &|| stop.asked(), round: &mut round };
        on_pool(&job.scene, &job.plan, &mut job.state, &range, args.threads, watch)?;
    }
    bar.finish_and_clear();
    if let Some(e) = failed {
        return Err(unwritten(&out, e));
    }
    saves.save(&job.folder, &job.identity, &job.state).map_err(|e| unwritten(&out, e))?;
    // At its targets a run is whole: that of so many histories.
    let range = aims.reached.map_or(range, |n| 0..n);
    if let Some(n) = aims.reached {
        job.scene.run.histories = n;
    }
    let done = conclude(job.scene, job.plan, job.state, range)?;
    if !done.outcome.groups.is_empty() {
        let manifest = manifest(&done, args, started);
        report::folder::write(&job.folder, &done.scene, &done.plan, &done.outcome, &done.result)
            .and_then(|()| job.folder.write("manifest.json", manifest.to_json().as_bytes()))
            .and_then(|()| job.folder.write("report.html", page(&done, &manifest).as_bytes()))
            .and_then(|()| aims::write(&job.folder, &job.targets, &done))
            .map_err(|e| unwritten(&out, e))?;
        tell(&done, &manifest, args, &job.targets, &out)?;
    }
    ending(&done, &stop, &out, !talk)
}

/// Stopped, failed or well.
fn ending(done: &Finished, stop: &Stop, out: &Path, quiet: bool) -> Result<(), Failure> {
    let histories = done.outcome.groups.first().map_or(0, |g| g.node.histories);
    let partial = format!(
        "stopped after {histories} of {} histories of each wavelength group; \
         `lightpro resume {}` goes on",
        done.outcome.histories,
        out.display()
    );
    match stop.signal() {
        Some(signal) if !done.outcome.complete => return Err(Failure::Stopped(signal, partial)),
        None if !done.outcome.complete && !quiet => say(&partial)?,
        _ => {}
    }
    verdict(done)
}

/// What a person wants to see of a finished run.
fn tell(
    done: &Finished,
    manifest: &Manifest,
    args: &RunArgs,
    targets: &[Target],
    out: &Path,
) -> Result<(), Failure> {
    if args.json {
        return say(&done.result.to_json());
    }
    if args.quiet {
        return Ok(());
    }
    let mut lines = vec![text::figures(&shown(&done.result)).to_string()];
    lines.extend(done.expects.0.iter().cloned());
    lines.extend(done.result.memory.as_ref().map(ToString::to_string));
    lines.extend(done.result.voxels.as_ref().map(ToString::to_string));
    lines.extend(manifest.health.warning());
    lines.extend(aims::told(targets, done));
    lines.push(format!(
        "{} histories, {:.3e} events, {:.1} s on the clock, {:.1} s of processor; results in {}",
        done.outcome.done(),
        done.outcome.events() as f64,
        manifest.wall_seconds,
        manifest.cpu_seconds,
        out.display()
    ));
    say(&lines.join("\n"))
}

/// The page of one run.
fn page(done: &Finished, manifest: &Manifest) -> String {
    let part =
        report::html::Part { label: "", scene: &done.scene, outcome: &done.outcome, result: &done.result };
    report::html::Report { parts: &[part], plan: &done.plan, manifest, sweep: None, tables: &[] }.page()
}

/// The figures worth a line on the terminal: all of paper optics; of spectra the first, the middle and
/// the last wavelength.
fn shown(result: &RunResult) -> Vec<report::Figure> {
    let mut wavelengths: Vec<f64> = result.figures.iter().filter_map(|f| f.wavelength_nm).collect();
    wavelengths.dedup();
    wavelengths.sort_by(f64::total_cmp);
    wavelengths.dedup();
    let few: Vec<f64> = if wavelengths.len() <= 3 {
        wavelengths
    } else {
        vec![wavelengths[0], wavelengths[wavelengths.len() / 2], wavelengths[wavelengths.len() - 1]]
    };
    let keep = |f: &&report::Figure| f.wavelength_nm.is_none_or(|nm| few.contains(&nm));
    result.figures.iter().filter(keep).cloned().collect()
}

fn bar(total: u64, quiet: bool) -> indicatif::ProgressBar {
    if quiet {
        return indicatif::ProgressBar::hidden();
    }
    let bar = indicatif::ProgressBar::new(total);
    if let Ok(style) = indicatif::ProgressStyle::with_template(
        "{bar:32} {percent:>3} %  {per_sec} histories  {msg}  {eta} left",
    ) {
        bar.set_style(style);
    }
    bar
}

pub(super) fn manifest(done: &Finished, args: &RunArgs, (clock, cpu): (Instant, f64)) -> Manifest {
    let scene = &done.scene;
    let file = |(path, hash): &(PathBuf, u64)| InputFile {
        path: path.display().to_string(),
        hash: format!("{hash:016x}"),
    };
    Manifest {
        lightpro: env!("CARGO_PKG_VERSION").to_owned(),
        command_line: args.command_line.clone(),
        scene: understood(scene),
        files: scene.files.iter().map(file).collect(),
        seed: scene.run.seed,
        effects: report::figures::effects(&done.plan),
        host: Host::here(),
        health: Health::of(&done.outcome),
        threads: if args.threads == 0 { rayon::current_num_threads() } else { args.threads } as u64,
        cpu_seconds: cpu_seconds() - cpu,
        wall_seconds: clock.elapsed().as_secs_f64(),
        peak_memory_bytes: peak_memory_bytes(),
    }
}

/// The scene with all defaults filled in, in internal units.
fn understood(scene: &Scene) -> serde_json::Value {
    serde_json::json!({
        "name": scene.name,
        "units": "um, nm, rad, 1/um, g/m2, kg/m3",
        "materials": scene.materials.iter().map(|m| format!("{m:?}")).collect::<Vec<_>>(),
        "surfaces": scene.surfaces.iter().map(|s| format!("{s:?}")).collect::<Vec<_>>(),
        "universe": format!("{:?}", scene.universe),
        "source": format!("{:?}", scene.source),
        "wavelengths_nm": scene.wavelengths,
        "detect": format!("{:?}", scene.detect),
        "optics": format!("{:?}", scene.optics),
        "run": format!("{:?}", scene.run),
    })
}
