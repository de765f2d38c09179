//! `study accuracy`, `study convergence`, `study sap`: studies that write a folder.

use super::run::{default_folder, manifest};
use super::{Failure, Finished, RunArgs, SceneArgs, heading, load, say};
use crate::report::RunFolder;
use crate::report::html::{Part, Report};
use crate::run::clock::processor_seconds;
use crate::scene::plan::Plan;
use crate::study::{accuracy, sap};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

fn unwritten(out: &Path, e: io::Error) -> Failure {
    Failure::Input(format!("error: results folder {}: {e}", out.display()))
}

fn pool(threads: usize) -> Result<rayon::ThreadPool, Failure> {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| Failure::Internal(e.to_string()))
}

fn write(folder: &RunFolder, files: &[(String, String)]) -> io::Result<()> {
    files.iter().try_for_each(|(name, text)| folder.write(name, text.as_bytes()))
}

/// `study accuracy`, and with a knob `study convergence`: tables T1 to T5, figures F1 to F9, the report.
///
/// # Errors
/// A scene that cannot be read or run, a knob that it does not have, a folder that cannot be written.
pub fn study_accuracy(
    scene_args: &SceneArgs,
    args: &RunArgs,
    options: &accuracy::Options,
) -> Result<(), Failure> {
    let started = (Instant::now(), processor_seconds());
    let (scene, _) = load(scene_args)?;
    let name = if options.knob.is_some() { "convergence" } else { "accuracy" };
    let out = args.out.clone().unwrap_or_else(|| default_folder(&scene.path).with_extension(name));
    let folder = RunFolder::create(&out, args.force).map_err(|e| unwritten(&out, e))?;
    let talk = !args.quiet;
    let told = |what: &str| {
        if talk {
            eprintln!("{what} …");
        }
    };
    let found = pool(args.threads)?
        .install(|| accuracy::study(&scene, options, told))
        .map_err(|e| Failure::Input(format!("error: {}: {e}", scene.path.display())))?;
    let files = found.files();
    write(&folder, &files).map_err(|e| unwritten(&out, e))?;
    let plan = Plan::new(&found.scene).map_err(Failure::Internal)?;
    let done = Finished {
        scene: found.scene.clone(),
        plan,
        outcome: found.base.outcome.clone(),
        result: found.base.result.clone(),
        expects: (Vec::new(), true),
    };
    let manifest = manifest(&done, args, started);
    let part = Part { label: "", scene: &done.scene, outcome: &done.outcome, result: &done.result };
    let titles = [
        ("t1_results.csv", "T1 Results"),
        ("t2_budget.csv", "T2 Sources of error"),
        ("t2_inputs.csv", "T2 Input data"),
        ("t3_times.csv", "T3 Time to a target"),
        ("t3_held_out.csv", "T3 The held-out run"),
        ("t4_settings.csv", "T4 Settings"),
        ("t5_effects.csv", "T5 Effects"),
    ];
    let table = |(file, title): &(&str, &str)| {
        let text = files.iter().find(|f| f.0 == *file).map(|f| f.1.clone());
        text.filter(|t| !t.is_empty()).map(|t| ((*title).to_owned(), t))
    };
    let tables: Vec<(String, String)> = titles.iter().filter_map(table).collect();
    let page =
        Report { parts: &[part], plan: &done.plan, manifest: &manifest, sweep: None, tables: &tables }.page();
    folder
        .write("manifest.json", manifest.to_json().as_bytes())
        .and_then(|()| folder.write("report.html", page.as_bytes()))
        .map_err(|e| unwritten(&out, e))?;
    if talk {
        say(&format!("{}\n{found}\nresults in {}", heading(&scene), out.display()))?;
    }
    Ok(())
}

/// `study sap`: patches against the continuous law, by themselves and in scenes.
///
/// # Errors
/// Scenes that cannot be read or run, a folder that cannot be written.
pub fn study_sap(
    scenes: &[PathBuf],
    args: &RunArgs,
    g: f64,
    granularities: &[u32],
    histories: u64,
) -> Result<(), Failure> {
    let mut read = Vec::new();
    for path in scenes {
        read.push(load(&SceneArgs { path: path.clone(), ..SceneArgs::default() })?.0);
    }
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("results/sap"));
    let folder = RunFolder::create(&out, args.force).map_err(|e| unwritten(&out, e))?;
    let found = pool(args.threads)?
        .install(|| {
            let biases = sap::biases(g, granularities, histories)?;
            let mut light = Vec::new();
            for scene in &read {
                light.extend(sap::light(scene, granularities, histories)?);
            }
            Ok(sap::Study { biases, light })
        })
        .map_err(|e: String| Failure::Input(format!("error: {e}")))?;
    write(&folder, &found.files()).map_err(|e| unwritten(&out, e))?;
    if !args.quiet {
        say(&format!("{found}\nresults in {}", out.display()))?;
    }
    Ok(())
}
