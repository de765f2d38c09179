//! What the commands do; `main` only parses their arguments.

use crate::report::manifest::{Host, InputFile, peak_memory_bytes};
use crate::report::{self, Manifest, RunFolder, RunResult, text};
use crate::run::{Outcome, Progress, simulate};
use crate::scene::plan::Plan;
use crate::scene::{self, Options, Scene};
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// How a command ends when it does not succeed; the number is the exit code.
#[derive(Debug)]
pub enum Failure {
    /// Bad input: the scene, a file, a folder.
    Input(String),
    /// A check of the physics failed.
    Physics(String),
    /// The program's own fault.
    Internal(String),
}

impl Failure {
    /// Exit code: 2 bad input, 1 physics, 70 internal.
    pub fn code(&self) -> u8 {
        match self {
            Failure::Physics(_) => 1,
            Failure::Input(_) => 2,
            Failure::Internal(_) => 70,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Input(text) | Failure::Physics(text) => f.write_str(text),
            Failure::Internal(text) => write!(f, "internal error: {text}"),
        }
    }
}

/// A scene file and what the command line says about it.
#[derive(Clone, Debug, Default)]
pub struct SceneArgs {
    /// The file.
    pub path: PathBuf,
    /// `-D name=value`.
    pub defines: Vec<(String, String)>,
    /// Files outside the scene's folder may be read.
    pub allow_outside: bool,
    /// `--effect name=on|off:reason`.
    pub effects: Vec<crate::scene::effects::Override>,
}

/// What `run` was asked to do.
#[derive(Clone, Debug, Default)]
pub struct RunArgs {
    /// Folder for the results; by default `results/` and the scene's file name.
    pub out: Option<PathBuf>,
    /// Overrides of the scene.
    pub histories: Option<u64>,
    /// See `histories`.
    pub seed: Option<u64>,
    /// Threads; 0: as many as the machine has.
    pub threads: usize,
    /// Existing results may be overwritten.
    pub force: bool,
    /// Nothing on the terminal but errors.
    pub quiet: bool,
    /// `result.json` on standard output.
    pub json: bool,
    /// The command as typed.
    pub command_line: Vec<String>,
}

/// Reads a scene and settles its plan.
///
/// # Errors
/// Every fault of the file, rendered.
pub fn load(args: &SceneArgs) -> Result<(Scene, Plan), Failure> {
    let options = Options {
        allow_outside: args.allow_outside,
        defines: args.defines.clone(),
        effects: args.effects.clone(),
    };
    let scene = scene::read(&args.path, &options)
        .map_err(|d| Failure::Input(d.render_for_stderr().trim_end().to_owned()))?;
    let plan = planned(&scene)?;
    Ok((scene, plan))
}

fn planned(scene: &Scene) -> Result<Plan, Failure> {
    Plan::new(scene).map_err(|e| Failure::Input(format!("error: {}: {e}", scene.path.display())))
}

/// `plan`: what will be simulated and why.
///
/// # Errors
/// A scene that cannot be read or made.
pub fn plan(args: &SceneArgs) -> Result<String, Failure> {
    let (scene, plan) = load(args)?;
    Ok(format!("{}\n{plan}", heading(&scene)))
}

/// `study effects`: every effect toggled.
///
/// # Errors
/// A scene that cannot be read or run.
pub fn study_effects(args: &SceneArgs, histories: Option<u64>) -> Result<String, Failure> {
    let (mut scene, _) = load(args)?;
    if let Some(n) = histories {
        scene.run.histories = n;
    }
    let study = crate::study::effects::study(&scene)
        .map_err(|e| Failure::Input(format!("error: {}: {e}", scene.path.display())))?;
    Ok(format!("{}\n{study}", heading(&scene)))
}

fn heading(scene: &Scene) -> String {
    format!("{} ({})", scene.name, scene.path.display())
}

/// `check`: every error and warning of the scene; optical constants at every wavelength.
///
/// # Errors
/// A scene that cannot be read or made.
pub fn check(args: &SceneArgs) -> Result<String, Failure> {
    let (scene, plan) = load(args)?;
    for wavelengths in &plan.groups {
        for &nm in wavelengths {
            scene::optics::light::<1>(&scene, &plan.media, &[nm])
                .map_err(|e| Failure::Input(format!("error: {}: {e}", scene.path.display())))?;
        }
    }
    let mut text = String::new();
    for warning in &scene.warnings {
        text += &format!("{}\n", warning.trim_end());
    }
    let n = scene.warnings.len();
    text += &format!("{}: ok, {n} warning{}", heading(&scene), if n == 1 { "" } else { "s" });
    Ok(text)
}

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
/// Constants missing at a wavelength, no threads to be had.
pub fn finish(
    mut scene: Scene,
    args: &RunArgs,
    progress: impl FnMut(Progress) -> bool + Send,
) -> Result<Finished, Failure> {
    if let Some(n) = args.histories {
        scene.run.histories = n;
    }
    if let Some(seed) = args.seed {
        scene.run.seed = seed;
    }
    let plan = planned(&scene)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads)
        .build()
        .map_err(|e| Failure::Internal(e.to_string()))?;
    let outcome = pool
        .install(|| simulate(&scene, &plan, progress))
        .map_err(|e| Failure::Input(format!("error: {}: {e}", scene.path.display())))?;
    let result = report::figures::result(&scene, &plan, &outcome);
    let expects = expectations(&scene, &result);
    Ok(Finished { scene, plan, outcome, result, expects })
}

/// `run`: simulates, writes the results folder, prints the table of figures.
///
/// # Errors
/// As [`load`] and [`finish`]; a folder that cannot be written; a physics check that fails.
pub fn run(scene_args: &SceneArgs, args: &RunArgs) -> Result<(), Failure> {
    let (scene, plan) = load(scene_args)?;
    let out = args.out.clone().unwrap_or_else(|| default_folder(&scene.path));
    let folder = RunFolder::create(&out, args.force)
        .map_err(|e| Failure::Input(format!("error: results folder {}: {e}", out.display())))?;
    let talk = !args.quiet && !args.json;
    if talk {
        println!("{}\n{plan}", heading(&scene));
    }
    let bar = bar(&scene, &plan, args.quiet);
    let started = (Instant::now(), cpu_seconds());
    let done = finish(scene, args, |p| {
        bar.set_position(p.done);
        bar.set_message(format!("R {:.4} ± {:.4}", p.reflectance.0, p.reflectance.1));
        true
    })?;
    bar.finish_and_clear();
    let manifest = manifest(&done, args, started);
    report::folder::write(&folder, &done.scene, &done.plan, &done.outcome, &done.result)
        .and_then(|()| folder.write("manifest.json", manifest.to_json().as_bytes()))
        .map_err(|e| Failure::Input(format!("error: writing to {}: {e}", out.display())))?;
    if args.json {
        print!("{}", done.result.to_json());
    } else if talk {
        println!("{}", text::figures(&shown(&done.result)));
        for line in &done.expects.0 {
            println!("{line}");
        }
        if let Some(memory) = &done.result.memory {
            println!("{memory}");
        }
        println!(
            "{} histories, {:.3e} events, {:.1} s on the clock, {:.1} s of processor; results in {}",
            done.outcome.histories * done.outcome.groups.len() as u64,
            done.outcome.events() as f64,
            manifest.wall_seconds,
            manifest.cpu_seconds,
            out.display()
        );
    }
    verdict(&done)
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

fn default_folder(scene: &Path) -> PathBuf {
    Path::new("results").join(scene.file_stem().unwrap_or(scene.as_os_str()))
}

fn bar(scene: &Scene, plan: &Plan, quiet: bool) -> indicatif::ProgressBar {
    let total = scene.run.histories * plan.groups.len() as u64;
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
fn verdict(done: &Finished) -> Result<(), Failure> {
    let (lost, _) = done.outcome.troubled();
    let histories = done.outcome.histories * done.outcome.groups.len() as u64;
    if lost as f64 > f64::max(10.0, 1e-6 * histories as f64) {
        return Err(Failure::Physics(format!("{lost} of {histories} histories lost power")));
    }
    let off = done.outcome.worst_imbalance();
    if off > 1e-12 {
        return Err(Failure::Physics(format!("the energy ledger of a history is off by {off:.1e}")));
    }
    if !done.expects.1 {
        let failing: Vec<&str> =
            done.expects.0.iter().filter(|l| l.ends_with("FAILS")).map(String::as_str).collect();
        return Err(Failure::Physics(failing.join("\n")));
    }
    Ok(())
}

fn manifest(done: &Finished, args: &RunArgs, (clock, cpu): (Instant, f64)) -> Manifest {
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

/// Processor seconds of this process so far, where the system tells (Linux; else 0).
pub fn cpu_seconds() -> f64 {
    // Fields 14 and 15 of /proc/self/stat, after the parenthesised name: clock ticks of 1/100 s.
    std::fs::read_to_string("/proc/self/stat")
        .ok()
        .and_then(|s| {
            let rest = s.rsplit_once(')')?.1.to_owned();
            let f: Vec<&str> = rest.split_whitespace().collect();
            Some((f.get(11)?.parse::<f64>().ok()? + f.get(12)?.parse::<f64>().ok()?) / 100.0)
        })
        .unwrap_or(0.0)
}

/// `materials`: index files whose name holds `filter`, with n and κ at three wavelengths.
///
/// # Errors
/// A folder that cannot be read.
pub fn materials(folder: &Path, filter: &str) -> Result<String, Failure> {
    let dir = folder.join("refractive-index");
    let listing = std::fs::read_dir(&dir).map_err(|e| {
        Failure::Input(format!("error: {}: {e}; --from names the folder `distributions`", dir.display()))
    })?;
    let mut names: Vec<PathBuf> = listing
        .filter_map(|e| e.ok().map(|e| e.path()))
        .filter(|p| p.extension().is_some_and(|x| x == "yml"))
        .filter(|p| p.to_string_lossy().to_lowercase().contains(&filter.to_lowercase()))
        .collect();
    names.sort();
    let mut out =
        format!("{:<26} {:>14}  {:>22}  {:>22}  {:>22}\n", "file", "range nm", "457 nm", "557 nm", "650 nm");
    for path in names {
        let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let text = std::fs::read_to_string(&path)
            .map_err(|e| Failure::Input(format!("error: {}: {e}", path.display())))?;
        let index = crate::material::RefractiveIndex::from_rii(&text, &name)
            .map_err(|e| Failure::Input(format!("error: {e}")))?;
        let at = |nm| match index.at(nm) {
            Ok(n) if n.im == 0.0 => format!("{:.4}", n.re),
            Ok(n) => format!("{:.4} + {:.3e} i", n.re, n.im),
            Err(_) => "-".to_owned(),
        };
        let range = index.range().map_or("all".to_owned(), |(a, b)| format!("{a:.0}-{b:.0}"));
        out += &format!("{name:<26} {range:>14}  {:>22}  {:>22}  {:>22}\n", at(457.0), at(557.0), at(650.0));
    }
    Ok(out)
}
