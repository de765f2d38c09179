//! Modules import only from those above them in the order of `src/lib.rs`; universes know nothing of
//! light; light knows no particular universe.
#![allow(missing_docs)]

use std::path::{Path, PathBuf};

/// What a module must not mention although the order would allow it: (module, path, why).
const APART: &[(&str, &[&str], &str)] = &[
    ("universe", &["phase"], "a universe knows nothing of light"),
    ("universe", &["microfacet"], "a universe knows nothing of light"),
    ("universe", &["lpm"], "a universe knows nothing of light"),
    ("lpm", &["universe", "statistical"], "light is the same in every universe"),
    ("lpm", &["universe", "synthetic"], "light is the same in every universe"),
    ("lpm", &["universe", "mixture"], "light is the same in every universe"),
    ("lpm", &["universe", "deposit"], "light is the same in every universe"),
    ("lpm", &["universe", "voxel"], "light is the same in every universe"),
    ("lpm", &["universe", "any"], "light is the same in every universe"),
];

/// Module names in the order of `src/lib.rs`.
fn order(lib: &str) -> Vec<String> {
    lib.lines()
        .filter_map(|l| l.strip_prefix("pub mod ").or_else(|| l.strip_prefix("mod ")))
        .filter_map(|l| l.strip_suffix(';'))
        .map(str::to_owned)
        .collect()
}

/// Module path of a source file: `src/sap/alias.rs` → [sap, alias], `src/sap/mod.rs` → [sap].
fn module_of(file: &Path) -> Vec<String> {
    let mut parts: Vec<String> =
        file.with_extension("").components().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
    parts.retain(|p| p != "src");
    if parts.last().is_some_and(|p| p == "mod" || p == "lib") {
        parts.pop();
    }
    parts
}

/// The text without its comments, documentation included.
fn code(text: &str) -> String {
    text.lines().map(|l| l.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// All paths that a `use` tree (or a path in code) at the start of `text` names, and what follows it.
fn paths<'a>(text: &'a str, prefix: &[String], found: &mut Vec<Vec<String>>) -> &'a str {
    let text = text.trim_start();
    if let Some(mut rest) = text.strip_prefix('{') {
        loop {
            rest = paths(rest, prefix, found).trim_start();
            match rest.strip_prefix(',') {
                Some(more) if more.trim_start().starts_with('}') => return &more.trim_start()[1..],
                Some(more) => rest = more,
                None => return rest.strip_prefix('}').unwrap_or(rest),
            }
        }
    }
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    let (name, rest) = text.split_at(end);
    let mut path = prefix.to_vec();
    if !name.is_empty() {
        path.push(name.to_owned());
    }
    if let Some(rest) = rest.strip_prefix("::") {
        return paths(rest, &path, found);
    }
    found.push(path);
    // `as name` or `*`: up to what ends the item.
    rest.trim_start_matches(|c: char| c == '*' || c == ' ' || c.is_alphanumeric() || c == '_')
}

/// Paths from the crate's root that a file names, by `crate::` or by enough `super::`.
fn named(text: &str, module: &[String]) -> Vec<Vec<String>> {
    let text = code(text);
    let mut found = Vec::new();
    for (at, _) in text.match_indices("crate::") {
        let inside = text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        if !inside {
            paths(&text[at + "crate::".len()..], &[], &mut found);
        }
    }
    let up = "super::".repeat(module.len().max(1));
    for (at, _) in text.match_indices(&up) {
        let start = !text[..at].ends_with(|c: char| c.is_alphanumeric() || c == ':');
        if start {
            paths(&text[at + up.len()..], &[], &mut found);
        }
    }
    found
}

/// What is wrong with a file: one line each.
fn violations(file: &Path, text: &str, order: &[String]) -> Vec<String> {
    let module = module_of(file);
    let Some(own) = module.first().and_then(|m| order.iter().position(|o| o == m)) else { return vec![] };
    let mut wrong = Vec::new();
    for path in named(text, &module) {
        let Some(at) = path.first().and_then(|m| order.iter().position(|o| o == m)) else { continue };
        let name = path.join("::");
        if at > own {
            wrong.push(format!("{}: {} stands above {name}", file.display(), order[own]));
        }
        for (who, what, why) in APART {
            if *who == order[own] && path.iter().zip(*what).filter(|(a, b)| a == b).count() == what.len() {
                wrong.push(format!("{}: {name} in {who}: {why}", file.display()));
            }
        }
    }
    wrong
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn modules_import_only_from_those_above() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let order = order(&std::fs::read_to_string(root.join("src/lib.rs")).unwrap());
    let mut files = Vec::new();
    sources(&root.join("src"), &mut files);
    let (mut wrong, mut seen) = (Vec::new(), 0);
    for file in &files {
        let text = std::fs::read_to_string(file).unwrap();
        let name = file.strip_prefix(root).unwrap();
        seen += named(&text, &module_of(name)).len();
        wrong.extend(violations(name, &text, &order));
    }
    assert!(order.len() > 10 && files.len() > 50 && seen > 200, "{} {} {seen}", order.len(), files.len());
    assert!(wrong.is_empty(), "{} violations:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn planted_violations_are_noticed() {
    let order: Vec<String> =
        ["math", "phase", "microfacet", "universe", "lpm", "tally"].map(str::to_owned).to_vec();
    let count = |file: &str, text: &str| violations(Path::new(file), text, &order).len();
    // Downwards, by import, in a group, by path, by `super`.
    assert_eq!(count("src/math/fast.rs", "use crate::tally::Cell;"), 1);
    assert_eq!(count("src/lpm/mod.rs", "use crate::{math::{self, DVec3}, tally::{Cell, Layout},\n};"), 2);
    assert_eq!(count("src/phase/mod.rs", "fn f() -> f64 { crate::lpm::history::x() }"), 1);
    assert_eq!(count("src/phase/mod.rs", "pub use super::lpm as light;"), 1);
    assert_eq!(count("src/phase/mie/law.rs", "use super::super::super::tally;"), 1);
    // A universe that knows light, light that knows a universe.
    assert_eq!(count("src/universe/mod.rs", "use crate::phase::Phase;"), 1);
    assert_eq!(count("src/universe/voxel/mod.rs", "use crate::{math, microfacet};"), 1);
    assert_eq!(count("src/lpm/history.rs", "use crate::universe::{Face, statistical::Place};"), 1);
    assert_eq!(count("src/lpm/history.rs", "type U = crate::universe::any::AnyUniverse;"), 1);
    assert_eq!(count("src/lpm/split.rs", "use crate::universe::{mixture, voxel::Place};"), 2);
    // What is allowed.
    assert_eq!(count("src/lpm/history.rs", "use crate::universe::{Face, Universe};\nuse super::split;"), 0);
    assert_eq!(count("src/universe/mod.rs", "//! [`crate::lpm`]\nlet phase = 1; // crate::lpm"), 0);
    assert_eq!(count("src/tally/mod.rs", "use crate::{lpm, universe::any};"), 0);
    assert_eq!(count("src/phase/mod.rs", "use super::lpmx;"), 0);
    assert_eq!(count("src/main.rs", "use lightpro::tally;"), 0);
}
