//! `compare`: the same sheet in several universes, into a folder.

use super::realise::{self, RealiseArgs};
use super::run::{default_folder, manifest};
use super::{Failure, Finished, RunArgs, SceneArgs, heading, load, say};
use crate::report::html::{Part, Report};
use crate::report::{self, RunFolder, csv, write_atomic};
use crate::run::clock::processor_seconds;
use crate::scene::Scene;
use crate::study::compare::{Comparison, Entry, Options, compare as held};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What `compare` was asked to do.
#[derive(Clone, Debug, Default)]
pub struct CompareArgs {
    /// Universes; empty: all that the scene can be in.
    pub universes: Vec<Entry>,
    /// Other scenes to hold beside.
    pub with: Vec<PathBuf>,
    /// Edge of the voxels of `voxels`, µm.
    pub voxel: Option<f64>,
    /// Edge of the periodic cell of `bodies` and `voxels`, µm.
    pub cell: Option<f64>,
    /// How.
    pub options: Options,
}

/// Runs, writes the folder, prints verdicts and prices.
///
/// # Errors
/// Scenes that cannot be read, fewer than two universes, a folder that cannot be written.
pub fn compare(scene_args: &SceneArgs, args: &RunArgs, asked: &CompareArgs) -> Result<(), Failure> {
    let started = (Instant::now(), processor_seconds());
    let (scene, _) = load(scene_args)?;
    if asked.universes.contains(&Entry::Voxels) && asked.voxel.is_none() {
        let way = "--voxel 0.5um (a third of the thinnest wall, or less)";
        return Err(Failure::Input(format!("error: universe `voxels` needs the edge of a voxel: {way}")));
    }
    let mut others = Vec::new();
    for path in &asked.with {
        let (other, _) = load(&SceneArgs { path: path.clone(), ..scene_args.clone() })?;
        others.push((Entry::Other(path.clone()).to_string(), other));
    }
    let mut entries = asked.universes.clone();
    if entries.is_empty() && others.is_empty() {
        entries = Entry::all(&scene);
    } else if entries.is_empty() {
        entries = vec![Entry::Written];
    }
    let out = args.out.clone().unwrap_or_else(|| default_folder(&scene.path).with_extension("compare"));
    let unwritten = |e: io::Error| Failure::Input(format!("error: results folder {}: {e}", out.display()));
    let folder = RunFolder::create(&out, args.force).map_err(unwritten)?;
    others.extend(realised(scene_args, asked, folder.path())?);
    entries.retain(|e| !matches!(e, Entry::Bodies | Entry::Voxels));
    let talk = !args.quiet && !args.json;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads)
        .build()
        .map_err(|e| Failure::Internal(e.to_string()))?;
    let told = |name: &str| {
        if talk {
            eprintln!("running {name} …");
        }
    };
    let found = pool
        .install(|| held(&scene, &entries, &others, &asked.options, told))
        .map_err(|e| Failure::Input(format!("error: {}: {e}", scene.path.display())))?;
    write(&folder, &found, args, started).map_err(unwritten)?;
    if args.json {
        return say(&found.json());
    }
    if talk {
        say(&format!("{}\n{found}\n{}\nresults in {}", heading(&scene), found.price_text(), out.display()))?;
    }
    Ok(())
}

/// The realisation that `bodies` and `voxels` are: written into the folder, and read as scenes.
fn realised(scene: &SceneArgs, asked: &CompareArgs, folder: &Path) -> Result<Vec<(String, Scene)>, Failure> {
    let wants = |e: Entry| asked.universes.contains(&e);
    if !wants(Entry::Bodies) && !wants(Entry::Voxels) {
        return Ok(Vec::new());
    }
    let voxel = asked.voxel.filter(|_| wants(Entry::Voxels));
    let stem = folder.join("realisation");
    let how = RealiseArgs { out: Some(stem), voxel, cell: asked.cell, force: true, ..RealiseArgs::default() };
    let told = realise::realise(scene, &how)?;
    write_atomic(&folder.join("realisation.txt"), told.as_bytes())
        .map_err(|e| Failure::Input(format!("error: {}: {e}", folder.display())))?;
    let read = |name: &str, file: &str| {
        // The values of -D stand in the files.
        let args = SceneArgs { path: folder.join(file), defines: Vec::new(), ..scene.clone() };
        Ok((name.to_owned(), load(&args)?.0))
    };
    let bodies = wants(Entry::Bodies).then(|| read("bodies", "realisation.xml"));
    let voxels = wants(Entry::Voxels).then(|| read("voxels", "realisation-voxels.xml"));
    bodies.into_iter().chain(voxels).collect()
}

fn write(folder: &RunFolder, found: &Comparison, args: &RunArgs, started: (Instant, f64)) -> io::Result<()> {
    let finished = |i: usize| {
        let r = &found.ran[i];
        Finished {
            scene: r.scene.clone(),
            plan: r.plan.clone(),
            outcome: r.outcome.clone(),
            result: r.result.clone(),
            expects: (Vec::new(), true),
        }
    };
    for r in &found.ran {
        let own = RunFolder::create(&folder.path().join(&r.name), true)?;
        report::folder::write(&own, &r.scene, &r.plan, &r.outcome, &r.result)?;
    }
    folder.write("compare.json", found.json().as_bytes())?;
    folder.write("compare.txt", found.to_string().as_bytes())?;
    folder.write("compare.csv", csv::table(&found.rows).as_bytes())?;
    folder.write("verdicts.csv", csv::table(&found.claims).as_bytes())?;
    folder.write("realisations.csv", csv::table(&found.spreads).as_bytes())?;
    // Times: these two differ from run to run, as the manifest does.
    folder.write("prices.csv", csv::table(&found.prices).as_bytes())?;
    folder.write("prices.txt", found.price_text().as_bytes())?;
    for (stem, plot) in found.plots() {
        plot.write(folder, &stem)?;
    }
    let manifest = manifest(&finished(found.reference), args, started);
    folder.write("manifest.json", manifest.to_json().as_bytes())?;
    let mut parts: Vec<Part> = found
        .ran
        .iter()
        .map(|r| Part { label: &r.name, scene: &r.scene, outcome: &r.outcome, result: &r.result })
        .collect();
    parts.swap(0, found.reference);
    let tables = [
        ("Verdicts against the reference".to_owned(), csv::table(&found.claims)),
        ("Between realisations".to_owned(), csv::table(&found.spreads)),
        ("Prices".to_owned(), csv::table(&found.prices)),
        ("Every value against the reference".to_owned(), csv::table(&found.rows)),
    ];
    let plan = &found.ran[found.reference].plan;
    let page = Report { parts: &parts, plan, manifest: &manifest, sweep: None, tables: &tables }.page();
    folder.write("report.html", page.as_bytes())
}
