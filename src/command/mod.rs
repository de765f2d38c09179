//! What the commands do; `main` only parses their arguments.

mod aims;
mod compare;
mod finish;
mod folder;
mod realise;
mod replay;
mod run;
mod stop;
mod study;
pub mod sweep;

pub use compare::{CompareArgs, compare};
pub use finish::{Finished, finish};
pub use realise::{RealiseArgs, realise, structure};
pub use replay::{ReplayArgs, replay};
pub use run::{merge, resume, run};
pub use study::{study_accuracy, study_sap};

use crate::run::clock::processor_seconds as cpu_seconds;

use crate::report::{self, RunResult};
use crate::scene::plan::Plan;
use crate::scene::{self, Options, Scene};
use crate::study::target::Target;
use std::fmt;
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How a command ends when it does not succeed; the number is the exit code.
#[derive(Debug)]
pub enum Failure {
    /// Bad input: the scene, a file, a folder.
    Input(String),
    /// A check of the physics failed.
    Physics(String),
    /// The program's own fault.
    Internal(String),
    /// Stopped by a signal of this number, with what was saved.
    Stopped(u8, String),
}

impl Failure {
    /// Exit code: 2 bad input, 1 physics, 70 internal, 128 + signal (130 Ctrl-C, 143 SIGTERM).
    pub fn code(&self) -> u8 {
        match self {
            Failure::Physics(_) => 1,
            Failure::Input(_) => 2,
            Failure::Internal(_) => 70,
            Failure::Stopped(signal, _) => 128_u8.saturating_add(*signal),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Input(text) | Failure::Physics(text) | Failure::Stopped(_, text) => f.write_str(text),
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

impl SceneArgs {
    /// How the scene is read.
    pub fn reading(&self) -> Options {
        Options {
            allow_outside: self.allow_outside,
            defines: self.defines.clone(),
            effects: self.effects.clone(),
        }
    }
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
    /// Only these histories, a shard: whole batches of 4096.
    pub range: Option<Range<u64>>,
    /// Stop when these figures are known well enough.
    pub targets: Vec<Target>,
    /// Stop after this time on the clock, with what is done by then.
    pub max_time: Option<Duration>,
    /// Refuse a run that would need more bytes of memory than this.
    pub max_memory: Option<u64>,
    /// Time between checkpoints; by default a minute, or more where writing one takes long.
    pub checkpoint_every: Option<Duration>,
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

/// Writes a line to standard output.
///
/// # Errors
/// A closed pipe, a full disk.
pub fn say(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    let told = out.write_all(text.as_bytes()).and_then(|()| {
        if text.ends_with('\n') { Ok(()) } else { out.write_all(b"\n") }.and_then(|()| out.flush())
    });
    told.map_err(|e| Failure::Input(format!("error: standard output: {e}")))
}

/// Reads a scene and settles its plan.
///
/// # Errors
/// Every fault of the file, rendered.
pub fn load(args: &SceneArgs) -> Result<(Scene, Plan), Failure> {
    let scene = scene::read(&args.path, &args.reading())
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

/// `characterise`: the statistics of a scene's universe, printed and as files in `out`.
///
/// # Errors
/// A scene that cannot be read or measured, files that cannot be written.
pub fn characterise(
    args: &SceneArgs,
    lines: u64,
    out: Option<&Path>,
    force: bool,
) -> Result<String, Failure> {
    let (scene, _) = load(args)?;
    let told = |path: &Path, e: &dyn fmt::Display| Failure::Input(format!("error: {}: {e}", path.display()));
    let found = crate::study::characterise::characterise(&scene, lines).map_err(|e| told(&scene.path, &e))?;
    let mut text = format!("{}\n{found}", heading(&scene));
    if let Some(folder) = out {
        if !force && folder.join("universe.xml").exists() {
            let full = "holds results already; --force overwrites them";
            return Err(told(folder, &full));
        }
        std::fs::create_dir_all(folder).map_err(|e| told(folder, &e))?;
        let mut files = found.files(&scene.name);
        files.push(("chords.csv".to_owned(), found.chords_csv()));
        files.push(("rates.csv".to_owned(), found.rates_csv()));
        files.push(("transitions.csv".to_owned(), found.transitions_csv()));
        files.push(("profile.csv".to_owned(), found.profile_csv()));
        for (name, content) in &files {
            let path = folder.join(name);
            report::write_atomic(&path, content.as_bytes()).map_err(|e| told(&path, &e))?;
        }
        let names: Vec<&str> = files.iter().map(|f| f.0.as_str()).collect();
        text += &format!("{}: {}\n", folder.display(), names.join(", "));
    }
    Ok(text)
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

/// `difference`: what tells the results in two folders (or `result.json` files) apart; the table also as
/// CSV into `out`.
///
/// # Errors
/// Results that cannot be read, a file that cannot be written.
pub fn difference(first: &Path, second: &Path, out: Option<&Path>) -> Result<String, Failure> {
    let read = |path: &Path| {
        let path = if path.is_dir() { path.join("result.json") } else { path.to_owned() };
        let told = |e: &dyn fmt::Display| Failure::Input(format!("error: {}: {e}", path.display()));
        let text = std::fs::read_to_string(&path).map_err(|e| told(&e))?;
        RunResult::from_json(&text).map_err(|e| told(&e))
    };
    let (a, b) = (read(first)?, read(second)?);
    let rows = report::difference::rows(&a, &b);
    if let Some(path) = out {
        report::write_atomic(path, report::difference::csv(&rows).as_bytes())
            .map_err(|e| Failure::Input(format!("error: {}: {e}", path.display())))?;
    }
    Ok(format!("{} -> {}\n{}", a.scene, b.scene, report::difference::text(&rows)))
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
