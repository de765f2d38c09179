//! Results folders that hold a run: their checkpoint, their room, their debris.

use super::{Failure, SceneArgs, load};
use crate::report::RunFolder;
use crate::run::checkpoint::{self, Checkpoint, Identity};
use crate::run::limits;
use crate::scene::Scene;
use crate::scene::effects::Override;
use crate::scene::plan::Plan;
use std::path::Path;

/// Name of the file.
pub const CHECKPOINT: &str = "checkpoint";

/// Reads the checkpoint of a results folder.
pub fn checkpoint(dir: &Path) -> Result<Checkpoint, Failure> {
    let path = dir.join(CHECKPOINT);
    let refuse = |e: String| Failure::Input(format!("error: {}: {e}", path.display()));
    let bytes = std::fs::read(&path).map_err(|e| refuse(e.to_string()))?;
    checkpoint::from_bytes(&bytes).map_err(refuse)
}

/// Reads the scene that a run is of, as it was then.
pub fn scene_of(identity: &Identity) -> Result<(Scene, Plan), Failure> {
    let args = SceneArgs {
        path: identity.scene.clone(),
        defines: identity.defines.clone(),
        allow_outside: identity.allow_outside,
        effects: identity.effects.iter().filter_map(|e| Override::parse(e).ok()).collect(),
    };
    let (mut scene, _) = load(&args)?;
    scene.run.histories = identity.histories;
    scene.run.seed = identity.seed;
    let now = Identity::of(&scene, &args.defines, args.allow_outside, identity.range.clone())
        .with_targets(identity.targets.clone());
    if let Some(why) = identity.differs(&now) {
        let scene = identity.scene.display();
        return Err(Failure::Input(format!(
            "error: the stored run is not one of {scene} as it is now: {why}"
        )));
    }
    let plan = super::planned(&scene)?;
    Ok((scene, plan))
}

/// Removes what a killed process left half written.
pub fn sweep(dir: &Path) {
    let Ok(entries) = std::fs::read_dir(dir) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with('.') && (name.ends_with(".part") || name.starts_with(".probe.")) {
            // Debris; if it cannot go, it does no harm.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Refuses a run that memory or disk cannot hold; tells what it needs.
pub fn room(
    folder: &RunFolder,
    scene: &Scene,
    plan: &Plan,
    histories: u64,
    threads: usize,
    max_memory: Option<u64>,
) -> Result<String, Failure> {
    let threads = if threads == 0 { rayon::current_num_threads() } else { threads };
    let need = limits::need(scene, plan, histories, threads as u64)
        .map_err(|e| Failure::Input(format!("error: {}: {e}", scene.path.display())))?;
    let held = limits::resident().unwrap_or(0);
    let memory = need.memory.saturating_add(held);
    let mb = |bytes: u64| format!("{:.0} MB", (bytes as f64 / 1e6).ceil());
    let limit = max_memory
        .map(|m| (m, "--max-memory"))
        .or_else(|| limits::available().map(|a| (a.saturating_add(held), "the free memory of this machine")));
    if let Some((limit, whose)) = limit.filter(|l| memory > l.0) {
        return Err(Failure::Input(format!(
            "error: the run needs about {} of memory, {whose} is {}\n\
             help: fewer detectors (angular, depth), fewer threads, or fewer wavelengths",
            mb(memory),
            mb(limit)
        )));
    }
    if let Some(free) = free(folder.path()).filter(|&f| f < need.disk) {
        return Err(Failure::Input(format!(
            "error: the run needs up to {} of disk in {}, {} are free",
            mb(need.disk),
            folder.path().display(),
            mb(free)
        )));
    }
    Ok(format!("needs about {} of memory and up to {} of disk", mb(memory), mb(need.disk)))
}

/// Bytes that a user may still write below `path`, where the system tells.
#[cfg(unix)]
fn free(path: &Path) -> Option<u64> {
    let s = rustix::fs::statvfs(path).ok()?;
    Some(s.f_bavail.saturating_mul(s.f_frsize))
}
/// Bytes that a user may still write below `path`, where the system tells.
#[cfg(not(unix))]
fn free(_path: &Path) -> Option<u64> {
    None
}
