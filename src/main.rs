//! `lightpro`: light in paper, from the command line.

use clap::{Args, CommandFactory, Parser, Subcommand};
use lightpro::command::{self, CompareArgs, Failure, ReplayArgs, RunArgs, SceneArgs, say, sweep};
use lightpro::run::limits;
use lightpro::study::compare::{Entry, Options};
use lightpro::study::target::Target;
use lightpro::study::{accuracy, sap};
use std::io::Write;
use std::ops::Range;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// How light travels through paper: fibres, pores, fillers and coatings.
#[derive(Parser)]
#[command(version, about, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Simulate a scene and write its results
    Run {
        #[command(flatten)]
        scene: SceneOptions,
        /// Folder for the results [default: results/<name of the scene file>]
        #[arg(short, long)]
        out: Option<PathBuf>,
        /// Histories per wavelength group, instead of the scene's
        #[arg(long, value_parser = histories)]
        histories: Option<u64>,
        /// Seed, instead of the scene's
        #[arg(long)]
        seed: Option<u64>,
        /// Only the histories a (inclusive) to b (exclusive), whole batches of 4096; see merge
        #[arg(long, value_name = "A..B", value_parser = range)]
        histories_range: Option<Range<u64>>,
        /// Stop when the standard error of a figure is small enough: FIGURE:ERROR, e.g. reflectance:0.1%
        /// (of the value), brightness:0.1 (in its unit), reflectance@550:0.1%; several allowed. --histories
        /// is then the most [default: 1e10]
        #[arg(long, value_name = "FIGURE:ERROR", value_parser = Target::parse, conflicts_with = "histories_range")]
        target: Vec<Target>,
        /// Overwrite results that are there
        #[arg(long)]
        force: bool,
        /// Run at several values of one thing: NAME=FROM:TO:STEP or NAME=A,B,C, with a unit behind if it has
        /// one, as in wall.index=1.50:1.58:0.02 or "source.polar=0:75:15 deg"
        #[arg(long, value_parser = sweep::Sweep::parse, conflicts_with_all = ["histories_range", "json", "target"])]
        sweep: Option<sweep::Sweep>,
        #[command(flatten)]
        how: HowOptions,
    },
    /// Go on with a run that was stopped or killed; ends in the same bytes
    Resume {
        /// Its results folder
        folder: PathBuf,
        #[command(flatten)]
        how: HowOptions,
    },
    /// Make one run of its shards (--histories-range); gives the same bytes
    Merge {
        /// Their results folders
        #[arg(required = true)]
        folders: Vec<PathBuf>,
        /// Folder for the results [default: results/<name of the scene file>]
        #[arg(short, long)]
        out: Option<PathBuf>,
        /// Overwrite results that are there
        #[arg(long)]
        force: bool,
        #[command(flatten)]
        how: HowOptions,
    },
    /// Trace one history again and tell everything that happens to it
    Replay {
        #[command(flatten)]
        scene: SceneOptions,
        /// Number of the history, from 0
        #[arg(long)]
        history: u64,
        /// Wavelength in nm [default: the first]
        #[arg(long)]
        wavelength: Option<f64>,
        /// Seed, instead of the scene's
        #[arg(long)]
        seed: Option<u64>,
        /// Folder for history-N.txt, .csv and .vtp [default: the results folder, if one is named]
        #[arg(short, long)]
        out: Option<PathBuf>,
    },
    /// Say what will be simulated, and why
    Plan {
        #[command(flatten)]
        scene: SceneOptions,
    },
    /// Tell every error and warning of a scene; no histories
    Check {
        #[command(flatten)]
        scene: SceneOptions,
        /// Measure what stands there too: amounts, overlaps with coordinates, lost rays
        #[arg(long)]
        structure: bool,
        /// Folder for sections in three planes (SVG) and the bodies (VTP, for ParaView)
        #[arg(short, long, requires = "structure")]
        out: Option<PathBuf>,
    },
    /// Write a statistical sheet body by body: as a scene, for ParaView (.vtp), and as voxels
    Realise {
        #[command(flatten)]
        scene: SceneOptions,
        /// Beginning of the files' names [default: the scene's, and -realised]
        #[arg(short, long)]
        out: Option<PathBuf>,
        /// Number of the realisation
        #[arg(long, default_value_t = 0)]
        realisation: u64,
        /// Edge of the periodic cell, as in 2mm [default: 2.2 lengths of the longest body, 20 thicknesses]
        #[arg(long, value_name = "LENGTH", value_parser = length)]
        cell: Option<f64>,
        /// Edge of a voxel, as in 0.5um: write a labelled volume and its scene too
        #[arg(long, value_name = "LENGTH", value_parser = length)]
        voxel: Option<f64>,
        /// The volume as MetaImage (.mhd and .raw) instead of NRRD
        #[arg(long, requires = "voxel")]
        mhd: bool,
        /// The volume as VTK ImageData (.vti) for ParaView beside it
        #[arg(long, requires = "voxel")]
        vti: bool,
        /// Overwrite files that are there
        #[arg(long)]
        force: bool,
    },
    /// List the refractive indices that come with the program
    Materials {
        /// Part of a name
        #[arg(default_value = "")]
        filter: String,
        /// Folder of the distributions
        #[arg(long, default_value = "distributions")]
        from: PathBuf,
    },
    /// Say what tells two results apart: colour differences, and every figure that both have
    Difference {
        /// Results folder, or its result.json
        first: PathBuf,
        /// The other
        second: PathBuf,
        /// Write the table as CSV too
        #[arg(short, long)]
        out: Option<PathBuf>,
    },
    /// Run the same sheet in several universes: where they agree, differ, and what each costs
    Compare {
        #[command(flatten)]
        scene: SceneOptions,
        /// homogeneous, markov, none, a number of flights, full (memory of the statistical universe), boolean
        /// and deposited (explicit realisations), bodies and voxels (one and the same realisation in a periodic
        /// cell), scene (as written) [default: all that the scene allows]
        #[arg(long, value_delimiter = ',', value_parser = Entry::parse)]
        universes: Vec<Entry>,
        /// Another scene to hold beside; several allowed
        #[arg(long, value_name = "SCENE")]
        with: Vec<PathBuf>,
        /// Edge of the voxels of universe voxels, as in 0.5um
        #[arg(long, value_name = "LENGTH", value_parser = length)]
        voxel: Option<f64>,
        /// Edge of the cell of bodies and voxels [default: 2.2 lengths of the longest body, 20 thicknesses]
        #[arg(long, value_name = "LENGTH", value_parser = length)]
        cell: Option<f64>,
        /// Name of the reference [default: boolean, else full, else the first]
        #[arg(long)]
        reference: Option<String>,
        /// Reflectances that differ by less count as equal; other figures' margins follow
        #[arg(long, default_value_t = 0.005)]
        margin: f64,
        /// Error of a reflectance that prices are given for
        #[arg(long, default_value_t = 1e-3)]
        error: f64,
        /// Histories per wavelength group in each universe, instead of the scene's
        #[arg(long, value_parser = histories)]
        histories: Option<u64>,
        /// Histories that share a realisation: 1, 2, 4 … 4096 [default: 16 where bodies are explicit]
        #[arg(long, value_parser = histories)]
        histories_per_realisation: Option<u64>,
        /// Folder for the results [default: results/<name of the scene file>.compare]
        #[arg(short, long)]
        out: Option<PathBuf>,
        /// Overwrite results that are there
        #[arg(long)]
        force: bool,
        #[command(flatten)]
        how: HowOptions,
    },
    /// Measure the statistics of a sheet: chords, interfaces, directions, bodies; as a distribution file
    Characterise {
        #[command(flatten)]
        scene: SceneOptions,
        /// Straight lines to measure with
        #[arg(long, default_value = "2e5", value_parser = histories)]
        lines: u64,
        /// Folder for the distribution files, the <universe> that uses them, and tables
        #[arg(short, long)]
        out: Option<PathBuf>,
        /// Overwrite results that are there
        #[arg(long)]
        force: bool,
    },
    /// Toggle what a scene simulates and compare
    Study {
        #[command(subcommand)]
        what: Study,
    },
    /// Print the XML schema of scenes
    Schema {
        /// The reference page of scenes instead
        #[arg(long, conflicts_with = "result")]
        markdown: bool,
        /// The JSON schema of result.json instead
        #[arg(long)]
        result: bool,
    },
    /// Print the completions of a shell, to be sourced by it
    Completions {
        /// Which one
        shell: clap_complete::Shell,
    },
    /// Write the manual pages
    Manual {
        /// Folder to write them into
        #[arg(short, long, default_value = ".")]
        out: PathBuf,
    },
}

/// Where a study goes.
#[derive(Args)]
struct StudyOptions {
    /// Folder for the results [default: results/<name of the scene file>.<study>]
    #[arg(short, long)]
    out: Option<PathBuf>,
    /// Overwrite results that are there
    #[arg(long)]
    force: bool,
    /// Threads [default: all]
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    threads: usize,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

impl StudyOptions {
    fn into_args(self) -> RunArgs {
        RunArgs {
            out: self.out,
            force: self.force,
            threads: self.threads,
            quiet: self.quiet,
            command_line: std::env::args().collect(),
            ..RunArgs::default()
        }
    }
}

#[derive(Subcommand)]
enum Study {
    /// What every source of error contributes, what each setting costs, how long a wanted error takes
    Accuracy {
        #[command(flatten)]
        scene: SceneOptions,
        /// Histories per wavelength group of each setting, instead of the scene's
        #[arg(long, value_parser = histories)]
        histories: Option<u64>,
        /// Processor time that each setting may take
        #[arg(long, value_name = "TIME", default_value = "20s", value_parser = limits::duration)]
        each: Duration,
        /// Error of a reflectance that settings are recommended for
        #[arg(long, default_value_t = 2e-3)]
        error: f64,
        /// Leave out the toggling of effects
        #[arg(long)]
        no_effects: bool,
        /// Leave out the numbers of the scene made 1 % larger
        #[arg(long)]
        no_inputs: bool,
        #[command(flatten)]
        how: StudyOptions,
    },
    /// One setting, ever finer: bias, observed order, price
    Convergence {
        #[command(flatten)]
        scene: SceneOptions,
        /// Which: memory, patches, roulette, "branching floor", "wavelength grid", voxels
        #[arg(long)]
        knob: String,
        /// Histories per wavelength group of each setting, instead of the scene's
        #[arg(long, value_parser = histories)]
        histories: Option<u64>,
        /// Processor time that each setting may take
        #[arg(long, value_name = "TIME", default_value = "20s", value_parser = limits::duration)]
        each: Duration,
        #[command(flatten)]
        how: StudyOptions,
    },
    /// Patches of the sphere (SAP) against the continuous law: granularity, direction, frame, splitting
    Sap {
        /// Scenes to run with patches, e.g. scenes/seed/fig11-gaussian-45-granularity-3.xml
        scenes: Vec<PathBuf>,
        /// Asymmetry of the Henyey–Greenstein law
        #[arg(long, default_value_t = 0.9)]
        g: f64,
        /// Granularities
        #[arg(long, value_delimiter = ',', default_values_t = sap::GRANULARITIES)]
        nside: Vec<u32>,
        /// Histories of each scene, and drawn directions of each table
        #[arg(long, default_value = "4e5", value_parser = histories)]
        histories: u64,
        #[command(flatten)]
        how: StudyOptions,
    },
    /// Every effect: what it changes, with intervals, and what it costs
    Effects {
        #[command(flatten)]
        scene: SceneOptions,
        /// Histories per wavelength group, instead of the scene's
        #[arg(long, value_parser = histories)]
        histories: Option<u64>,
    },
}

/// How a run is carried out: nothing here changes its result.
#[derive(Args)]
struct HowOptions {
    /// Threads; the result does not depend on it [default: all]
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    threads: usize,
    /// Stop after this time (90s, 10m, 2h) with what is done by then
    #[arg(long, value_name = "TIME", value_parser = limits::duration)]
    max_time: Option<Duration>,
    /// Refuse a run that needs more memory (500MB, 8GiB) [default: what is free]
    #[arg(long, value_name = "SIZE", value_parser = limits::size)]
    max_memory: Option<u64>,
    /// Time between checkpoints [default: 1m, more where writing one takes long]
    #[arg(long, value_name = "TIME", value_parser = limits::duration)]
    checkpoint_every: Option<Duration>,
    /// Print nothing but errors
    #[arg(long, conflicts_with = "json")]
    quiet: bool,
    /// Print result.json
    #[arg(long)]
    json: bool,
}

impl HowOptions {
    fn into_args(self) -> RunArgs {
        RunArgs {
            threads: self.threads,
            max_time: self.max_time,
            max_memory: self.max_memory,
            checkpoint_every: self.checkpoint_every,
            quiet: self.quiet,
            json: self.json,
            command_line: std::env::args().collect(),
            ..RunArgs::default()
        }
    }
}

#[derive(Args)]
struct SceneOptions {
    /// Scene file (replay: or the results folder of a run)
    scene: PathBuf,
    /// Value for a ${name} of the scene, or for an attribute: id.attribute, as in wall.index=1.53
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = define)]
    define: Vec<(String, String)>,
    /// Force an effect on or off, with the reason
    #[arg(long = "effect", value_name = "NAME=on|off:REASON", value_parser = lightpro::scene::effects::Override::parse)]
    effects: Vec<lightpro::scene::effects::Override>,
    /// Allow files outside the scene's folder
    #[arg(long)]
    allow_outside: bool,
}

impl SceneOptions {
    fn into_args(self) -> SceneArgs {
        SceneArgs {
            path: self.scene,
            defines: self.define,
            allow_outside: self.allow_outside,
            effects: self.effects,
        }
    }
}

fn define(text: &str) -> Result<(String, String), String> {
    text.split_once('=')
        .map(|(n, v)| (n.to_owned(), v.to_owned()))
        .ok_or_else(|| "expected NAME=VALUE".to_owned())
}

fn histories(text: &str) -> Result<u64, String> {
    lightpro::units::count(text).map_err(|e| e.to_string())
}

/// A length in µm.
fn length(text: &str) -> Result<f64, String> {
    let length = lightpro::units::Quantity::Length.parse(text).map_err(|e| e.to_string())?;
    if length > 0.0 { Ok(length) } else { Err("a length above 0".to_owned()) }
}

fn range(text: &str) -> Result<Range<u64>, String> {
    let (a, b) = text.split_once("..").ok_or("expected A..B, e.g. 0..40960")?;
    Ok(histories(a)?..histories(b)?)
}

fn main() -> ExitCode {
    let ended = match Cli::parse().command {
        Command::Run { scene, out, histories, seed, histories_range: range, target, force, sweep, how } => {
            let args = RunArgs { out, histories, seed, range, targets: target, force, ..how.into_args() };
            match sweep {
                Some(sweep) => command::sweep::run(&scene.into_args(), &args, &sweep),
                None => command::run(&scene.into_args(), &args),
            }
        }
        Command::Resume { folder, how } => command::resume(&folder, &how.into_args()),
        Command::Merge { folders, out, force, how } => {
            command::merge(&folders, &RunArgs { out, force, ..how.into_args() })
        }
        Command::Replay { scene, history, wavelength, seed, out } => {
            command::replay(&scene.into_args(), &ReplayArgs { history, wavelength, seed, out })
        }
        Command::Plan { scene } => command::plan(&scene.into_args()).and_then(|t| say(&t)),
        Command::Compare {
            scene,
            universes,
            with,
            voxel,
            cell,
            reference,
            margin,
            error,
            histories,
            histories_per_realisation: shared,
            out,
            force,
            how,
        } => {
            let time = how.max_time.unwrap_or(Duration::from_secs(480));
            let options = Options { margin, error, histories, shared, time, reference };
            let args = RunArgs { out, force, ..how.into_args() };
            command::compare(
                &scene.into_args(),
                &args,
                &CompareArgs { universes, with, voxel, cell, options },
            )
        }
        Command::Check { scene, structure, out } => {
            let args = scene.into_args();
            command::check(&args).and_then(|t| say(&t)).and_then(|()| match structure {
                true => command::structure(&args, out.as_deref()).and_then(|t| say(&t)),
                false => Ok(()),
            })
        }
        Command::Realise { scene, out, realisation, cell, voxel, mhd, vti, force } => {
            let how = command::RealiseArgs { out, realisation, cell, voxel, mhd, vti, force };
            command::realise(&scene.into_args(), &how).and_then(|t| say(&t))
        }
        Command::Characterise { scene, lines, out, force } => {
            command::characterise(&scene.into_args(), lines, out.as_deref(), force).and_then(|t| say(&t))
        }
        Command::Study { what: Study::Effects { scene, histories } } => {
            command::study_effects(&scene.into_args(), histories).and_then(|t| say(&t))
        }
        Command::Study {
            what: Study::Accuracy { scene, histories, each, error, no_effects, no_inputs, how },
        } => {
            let options = accuracy::Options {
                histories,
                each: each.as_secs_f64(),
                knob: None,
                effects: !no_effects,
                inputs: !no_inputs,
                wanted: error,
            };
            command::study_accuracy(&scene.into_args(), &how.into_args(), &options)
        }
        Command::Study { what: Study::Convergence { scene, knob, histories, each, how } } => {
            let (knob, each) = (Some(knob), each.as_secs_f64());
            let options = accuracy::Options { histories, each, knob, ..accuracy::Options::default() };
            command::study_accuracy(&scene.into_args(), &how.into_args(), &options)
        }
        Command::Study { what: Study::Sap { scenes, g, nside, histories, how } } => {
            command::study_sap(&scenes, &how.into_args(), g, &nside, histories)
        }
        Command::Materials { filter, from } => command::materials(&from, &filter).and_then(|t| say(&t)),
        Command::Difference { first, second, out } => {
            command::difference(&first, &second, out.as_deref()).and_then(|t| say(&t))
        }
        Command::Schema { markdown, result } => {
            use lightpro::scene::table;
            say(&match (markdown, result) {
                (true, _) => table::markdown(),
                (_, true) => lightpro::report::schema::result(),
                _ => table::xsd(),
            })
        }
        Command::Completions { shell } => {
            let mut text = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "lightpro", &mut text);
            say(&String::from_utf8_lossy(&text))
        }
        Command::Manual { out } => clap_mangen::generate_to(Cli::command(), &out)
            .map_err(|e| Failure::Input(format!("error: {}: {e}", out.display()))),
    };
    match ended {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // Nobody may be listening: the exit code says it too.
            let _ = writeln!(std::io::stderr(), "{failure}");
            report_code(&failure)
        }
    }
}

fn report_code(failure: &Failure) -> ExitCode {
    ExitCode::from(failure.code())
}
