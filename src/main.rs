//! `lightpro`: light in paper, from the command line.

use clap::{Args, Parser, Subcommand};
use lightpro::command::{self, Failure, RunArgs, SceneArgs};
use std::path::PathBuf;
use std::process::ExitCode;

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
        /// Threads; the result does not depend on it [default: all]
        #[arg(long, default_value_t = 0, hide_default_value = true)]
        threads: usize,
        /// Overwrite results that are there
        #[arg(long)]
        force: bool,
        /// Print nothing but errors
        #[arg(long, conflicts_with = "json")]
        quiet: bool,
        /// Print result.json
        #[arg(long)]
        json: bool,
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
    /// Toggle what a scene simulates and compare
    Study {
        #[command(subcommand)]
        what: Study,
    },
    /// Print the XML schema of scenes
    Schema {
        /// The reference page of scenes instead
        #[arg(long)]
        markdown: bool,
    },
}

#[derive(Subcommand)]
enum Study {
    /// Every effect: what it changes, with intervals, and what it costs
    Effects {
        #[command(flatten)]
        scene: SceneOptions,
        /// Histories per wavelength group, instead of the scene's
        #[arg(long, value_parser = histories)]
        histories: Option<u64>,
    },
}

#[derive(Args)]
struct SceneOptions {
    /// Scene file
    scene: PathBuf,
    /// Value for a ${name} of the scene
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

fn main() -> ExitCode {
    let ended = match Cli::parse().command {
        Command::Run { scene, out, histories, seed, threads, force, quiet, json } => {
            let command_line = std::env::args().collect();
            let args = RunArgs { out, histories, seed, threads, force, quiet, json, command_line };
            command::run(&scene.into_args(), &args)
        }
        Command::Plan { scene } => command::plan(&scene.into_args()).map(|t| print!("{t}")),
        Command::Check { scene } => command::check(&scene.into_args()).map(|t| println!("{t}")),
        Command::Study { what: Study::Effects { scene, histories } } => {
            command::study_effects(&scene.into_args(), histories).map(|t| print!("{t}"))
        }
        Command::Materials { filter, from } => command::materials(&from, &filter).map(|t| print!("{t}")),
        Command::Schema { markdown } => {
            use lightpro::scene::table;
            print!("{}", if markdown { table::markdown() } else { table::xsd() });
            Ok(())
        }
    };
    match ended {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{failure}");
            report_code(&failure)
        }
    }
}

fn report_code(failure: &Failure) -> ExitCode {
    ExitCode::from(failure.code())
}
