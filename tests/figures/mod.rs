//! The figures of a scene's text, for tests that compare scenes.

use lightpro::command::{RunArgs, SceneArgs, finish, load};
use std::path::Path;

pub const NAMES: [&str; 5] = ["reflectance", "transmittance", "absorptance", "mean_path", "mean_collisions"];

/// (name and component, value, error) of all figures that are compared; an upper bound has no error.
pub fn figures(folder: &Path, text: &str, histories: u64) -> Vec<(String, f64, f64)> {
    let path = folder.join("t.xml");
    std::fs::write(&path, text).unwrap();
    let (scene, _) = load(&SceneArgs { path, ..SceneArgs::default() }).unwrap();
    let run = RunArgs { histories: Some(histories), ..RunArgs::default() };
    let done = finish(scene, &run, |_| true).unwrap();
    assert_eq!(done.outcome.troubled(), (0, 0), "lost, capped");
    assert!(done.outcome.worst_imbalance() < 1e-12);
    let figures = done.result.figures.iter().filter(|f| NAMES.contains(&f.name.as_str()));
    figures
        .map(|f| {
            let name = format!("{} {}", f.name, f.component.clone().unwrap_or_default());
            (name, f.value.unwrap(), f.error.unwrap_or(0.0))
        })
        .collect()
}
