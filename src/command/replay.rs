//! `replay`: one history again.

use super::folder::{checkpoint, scene_of};
use super::{Failure, SceneArgs, load, say};
use crate::report::file::write_atomic;
use crate::run::replay;
use std::path::PathBuf;

/// What `replay` was asked to do.
#[derive(Clone, Debug, Default)]
pub struct ReplayArgs {
    /// Number of the history.
    pub history: u64,
    /// Wavelength, nm; by default the scene's first.
    pub wavelength: Option<f64>,
    /// Seed, instead of the scene's.
    pub seed: Option<u64>,
    /// Folder for `history-N.txt`, `.csv` and `.vtp`; by default the results folder, if one is named.
    pub out: Option<PathBuf>,
}

/// `replay`: the exact path of a history of a results folder or a scene, printed and written.
///
/// # Errors
/// As [`load`]; a history or wavelength that the run does not have.
pub fn replay(of: &SceneArgs, args: &ReplayArgs) -> Result<(), Failure> {
    let mut out = args.out.clone();
    let (scene, plan) = if of.path.is_dir() {
        let identity = checkpoint(&of.path)?.identity;
        if args.history >= identity.histories {
            let text = format!("error: the run has the histories 0 to {}", identity.histories - 1);
            return Err(Failure::Input(text));
        }
        out = out.or_else(|| Some(of.path.clone()));
        scene_of(&identity)?
    } else {
        let (mut scene, plan) = load(of)?;
        scene.run.seed = args.seed.unwrap_or(scene.run.seed);
        (scene, plan)
    };
    let trail = replay::replay(&scene, &plan, args.history, args.wavelength)
        .map_err(|e| Failure::Input(format!("error: {}: {e}", scene.path.display())))?;
    let text = trail.text(&scene, &plan);
    if let Some(folder) = out {
        std::fs::create_dir_all(&folder)
            .map_err(|e| Failure::Input(format!("error: {}: {e}", folder.display())))?;
        let files = [("txt", &text), ("csv", &trail.csv(&plan)), ("vtp", &trail.vtp())];
        for (ending, content) in files {
            let path = folder.join(format!("history-{}.{ending}", args.history));
            write_atomic(&path, content.as_bytes())
                .map_err(|e| Failure::Input(format!("error: {}: {e}", path.display())))?;
        }
    }
    say(&text)
}
