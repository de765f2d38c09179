//! Every shipped scene: it checks clean, a small run of it gives pinned bytes, and the same bytes for
//! any number of threads.
//!
//! A changed hash is a value-breaking change: it is written into the CHANGELOG, then
//! `LIGHTPRO_WRITE=1 cargo test --release --test shipped_scenes` renews `tests/shipped_scenes.txt`.
#![allow(missing_docs)]

use lightpro::command::{RunArgs, SceneArgs, check, finish, load};
use std::path::{Path, PathBuf};

fn scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut out = Vec::new();
    let mut folders = vec![root];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "xml")
                // Parts and statistics that scenes take in stand beside them.
                && std::fs::read_to_string(&path).unwrap().contains("<scene ")
            {
                out.push(path);
            }
        }
    }
    out.sort();
    assert!(out.len() > 20, "{} scenes", out.len());
    out
}

/// Name below `scenes/`, with slashes.
fn name(path: &Path) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    path.strip_prefix(root).unwrap().to_string_lossy().replace('\\', "/")
}

fn small_run(path: &Path, threads: usize) -> String {
    let args = SceneArgs { path: path.to_owned(), ..SceneArgs::default() };
    let (scene, plan) = load(&args).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    // Three batches where one pass does all wavelengths, fewer histories where each has its own.
    let histories = if plan.groups.len() > 1 { 600 } else { 2 * 4096 + 100 };
    let run = RunArgs { histories: Some(histories), threads, ..RunArgs::default() };
    let done = finish(scene, &run, |_| true).unwrap();
    assert!(done.outcome.worst_imbalance() < 1e-12, "{}: ledger", path.display());
    assert_eq!(done.outcome.troubled(), (0, 0), "{}: lost, capped", path.display());
    done.result.to_json()
}

/// 64-bit FNV-1a.
fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}

#[test]
fn same_bytes_for_any_number_of_threads_and_pinned() {
    let pinned = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/shipped_scenes.txt");
    let mut lines = Vec::new();
    for path in scenes() {
        let one = small_run(&path, 1);
        for threads in [2, 7] {
            assert_eq!(one, small_run(&path, threads), "{}: {threads} threads", path.display());
        }
        lines.push(format!("{:016x}  {}", hash(&one), name(&path)));
    }
    let text = lines.join("\n") + "\n";
    if std::env::var_os("LIGHTPRO_WRITE").is_some() {
        std::fs::write(&pinned, &text).unwrap();
    }
    let want = std::fs::read_to_string(&pinned).unwrap_or_default();
    let changed: Vec<&str> =
        lines.iter().map(String::as_str).filter(|l| !want.lines().any(|w| w == *l)).collect();
    assert!(changed.is_empty() && want == text, "bytes changed:\n{}", changed.join("\n"));
}

#[test]
fn every_scene_checks_clean() {
    for path in scenes() {
        let args = SceneArgs { path: path.clone(), ..SceneArgs::default() };
        let text = check(&args).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(text.ends_with("ok, 0 warnings"), "{text}");
    }
}

/// The same slab, known by statistics (rung homogeneous) and built of planes: the same bytes.
#[test]
fn a_slab_is_a_slab_in_both_universes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/verify");
    let statistical = small_run(&folder.join("slab-p1-statistical.xml"), 2);
    let synthetic = small_run(&folder.join("slab-p1-synthetic.xml"), 2);
    assert_eq!(statistical, synthetic);
    // With index steps, diffuse light and two layers too.
    let text = std::fs::read_to_string(folder.join("two-layers.xml")).unwrap();
    let run = |kind: &str| {
        let text = text.replace(r#"kind="statistical" memory="homogeneous""#, kind);
        let options = lightpro::scene::Options::default();
        let scene = lightpro::scene::read_text(&text, &folder.join("two-layers.xml"), &options).unwrap();
        let args = RunArgs { histories: Some(20_000), threads: 2, ..RunArgs::default() };
        finish(scene, &args, |_| true).unwrap().result.to_json()
    };
    assert_eq!(run(r#"kind="statistical" memory="homogeneous""#), run(r#"kind="synthetic""#));
}
