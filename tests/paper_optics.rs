//! What paper optics measures, against closed forms and independent calculations.
#![allow(clippy::disallowed_methods, missing_docs)]

#[path = "paper_optics/geometries.rs"]
mod geometries;
#[path = "paper_optics/spread.rs"]
mod spread;
#[path = "paper_optics/views.rs"]
mod views;

use lightpro::command::{Finished, RunArgs, finish};
use lightpro::scene::{Options, read_text};
use std::path::Path;

/// Runs a scene given as text.
pub fn run(text: &str, histories: u64) -> Finished {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/test.xml");
    let scene = read_text(text, &path, &Options::default()).unwrap_or_else(|d| panic!("{d}"));
    let args = RunArgs { histories: Some(histories), ..RunArgs::default() };
    finish(scene, &args, |_| true).unwrap()
}

/// Value and standard error of a figure, of a component if one is named.
pub fn figure(done: &Finished, name: &str, component: Option<&str>) -> (f64, f64) {
    let f = done
        .result
        .figures
        .iter()
        .find(|f| f.name == name && (component.is_none() || f.component.as_deref() == component))
        .unwrap_or_else(|| panic!("no {name}"));
    (f.value.unwrap_or(f64::NAN), f.error.unwrap_or(f64::NAN))
}

/// A scene of one body list in air.
pub fn scene(materials: &str, surfaces: &str, bodies: &str, rest: &str) -> String {
    let surfaces =
        if surfaces.is_empty() { String::new() } else { format!("<surfaces>{surfaces}</surfaces>") };
    format!(
        r#"<scene name="test" version="1">
  <materials><material id="air" index="1"/>{materials}</materials>
  {surfaces}
  <universe kind="synthetic" outside="air">{bodies}</universe>
  {rest}
</scene>"#
    )
}

#[track_caller]
pub fn agree(what: &str, (value, error): (f64, f64), want: f64, also: f64) {
    let z = (value - want) / error;
    println!("{what}: {value:.6} ± {error:.6}, wanted {want:.6}, z {z:.2}");
    assert!((value - want).abs() <= 4.0 * error + also, "{what}: {value} ± {error}, wanted {want}");
}
