//! `run --sweep`: one scene at several values of one thing, side by side.

use super::finish::verdict;
use super::run::{default_folder, manifest};
use super::{Failure, Finished, RunArgs, SceneArgs, cpu_seconds, finish, load, say};
use crate::report::html::{Part, Report, sweep_csv, sweep_curves};
use crate::report::plot::{Curve, LinePlot};
use crate::report::{self, RunFolder, RunResult};
use std::path::PathBuf;
use std::time::Instant;

/// What a sweep changes: a placeholder of the scene, or an attribute as `element.attribute`, `id.attribute`.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Its name, e.g. `wall.index` or `source.polar`.
    pub name: String,
    /// Values as numbers, for the table.
    pub values: Vec<f64>,
    /// Unit that goes behind each of them; empty: none.
    pub unit: String,
}

impl Sweep {
    /// `name=from:to:step`, or `name=a,b,c`, each with a unit behind if it needs one: "source.polar=0:75:15 deg".
    ///
    /// # Errors
    /// What is wrong with the text.
    pub fn parse(text: &str) -> Result<Self, String> {
        const SHAPE: &str = "expected NAME=FROM:TO:STEP or NAME=A,B,C, with a unit behind if it has one";
        let (name, values) = text.split_once('=').ok_or(SHAPE)?;
        let values = values.trim();
        let end = values
            .find(|c: char| c.is_whitespace() || c.is_alphabetic() && c != 'e' && c != 'E')
            .unwrap_or(values.len());
        let (numbers, unit) = (values[..end].trim(), values[end..].trim());
        let number = |t: &str| t.trim().parse::<f64>().map_err(|_| format!("`{t}` is no number; {SHAPE}"));
        let parts: Vec<&str> = numbers.split(':').collect();
        let values = match parts[..] {
            [list] => list.split(',').map(number).collect::<Result<Vec<f64>, _>>()?,
            [from, to, step] => grid(number(from)?, number(to)?, number(step)?)?,
            _ => return Err(SHAPE.to_owned()),
        };
        if name.trim().is_empty() || values.iter().any(|v| !v.is_finite()) {
            return Err(SHAPE.to_owned());
        }
        Ok(Sweep { name: name.trim().to_owned(), values, unit: unit.to_owned() })
    }

    /// A value as it goes into the scene.
    fn text(&self, value: f64) -> String {
        // 1.5 + 3 · 0.02 is 1.56 for a reader.
        let number = format!("{value:.10}");
        let number = number.trim_end_matches('0').trim_end_matches('.');
        if self.unit.is_empty() { number.to_owned() } else { format!("{number} {}", self.unit) }
    }
}

fn grid(from: f64, to: f64, step: f64) -> Result<Vec<f64>, String> {
    let count = (to - from) / step * (1.0 + 1e-12) + 1e-9;
    if !(step != 0.0 && (0.0..1000.0).contains(&count)) {
        return Err(format!("{from}:{to}:{step} gives no values, or more than 1000"));
    }
    Ok((0..=count as u64).map(|i| from + i as f64 * step).collect())
}

/// Runs the scene at every value into a folder of its own, and puts table, plots and report of all of them
/// above. Expected figures of the scene hold for the scene as written and are not checked.
///
/// # Errors
/// As `run`.
pub fn run(scene_args: &SceneArgs, args: &RunArgs, sweep: &Sweep) -> Result<(), Failure> {
    let out = args.out.clone().unwrap_or_else(|| default_folder(&scene_args.path));
    let told = |e: std::io::Error, path: &std::path::Path| {
        Failure::Input(format!("error: results folder {}: {e}", path.display()))
    };
    // Every point is read before the first one is run.
    let mut points = Vec::new();
    for &value in &sweep.values {
        let mut own = scene_args.clone();
        own.defines.push((sweep.name.clone(), sweep.text(value)));
        points.push((sweep.text(value), load(&own)?.0));
    }
    let top = RunFolder::create(&out, args.force).map_err(|e| told(e, &out))?;
    let started = (Instant::now(), cpu_seconds());
    let talk = !args.quiet && !args.json;
    let mut done: Vec<(String, Finished)> = Vec::new();
    for (label, mut scene) in points {
        scene.expects.clear();
        let path: PathBuf = out.join(format!("{}={}", sweep.name, label.replace(' ', "")));
        let folder = RunFolder::create(&path, args.force).map_err(|e| told(e, &path))?;
        let begun = (Instant::now(), cpu_seconds());
        let point = finish(scene, args, |_| true)?;
        report::folder::write(&folder, &point.scene, &point.plan, &point.outcome, &point.result)
            .and_then(|()| folder.write("manifest.json", manifest(&point, args, begun).to_json().as_bytes()))
            .map_err(|e| told(e, &path))?;
        verdict(&point)?;
        if talk {
            say(&format!("{} = {label}: {}", sweep.name, path.display()))?;
        }
        done.push((label, point));
    }
    let parts: Vec<Part> = done
        .iter()
        .map(|(label, p)| Part { label, scene: &p.scene, outcome: &p.outcome, result: &p.result })
        .collect();
    let Some((_, first)) = done.first() else { return Ok(()) };
    let manifest = manifest(first, args, started);
    let report = Report {
        parts: &parts,
        plan: &first.plan,
        manifest: &manifest,
        sweep: Some((&sweep.name, &sweep.values, &sweep.unit)),
        tables: &[],
    };
    let results: Vec<&RunResult> = done.iter().map(|(_, p)| &p.result).collect();
    write(&top, sweep, &results, &report).map_err(|e| told(e, &out))?;
    if talk {
        say(&format!("{} runs; table, plots and report in {}", done.len(), out.display()))?;
    }
    Ok(())
}

fn write(top: &RunFolder, sweep: &Sweep, results: &[&RunResult], report: &Report) -> std::io::Result<()> {
    top.write("sweep.csv", sweep_csv(&sweep.name, results, &sweep.values).as_bytes())?;
    for (label, unit, points) in sweep_curves(results, &sweep.values) {
        let plain: String =
            label.chars().map(|c| if c.is_alphanumeric() || c == '_' { c } else { '-' }).collect();
        let curve = Curve { label: label.clone(), points };
        let x_unit = if sweep.unit.is_empty() { "1" } else { &sweep.unit };
        let svg = LinePlot {
            title: &label,
            x: (&sweep.name, x_unit),
            y: (&label, &unit),
            curves: &[curve],
            dots: true,
        }
        .svg();
        top.write(&format!("sweep_{}.svg", plain.trim_end_matches('-')), svg.as_bytes())?;
    }
    top.write("report.html", report.page().as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_are_read_with_their_units() {
        let s = Sweep::parse("wall.index=1.50:1.58:0.02").unwrap();
        assert_eq!((s.name.as_str(), s.values.len(), s.unit.as_str()), ("wall.index", 5, ""));
        assert_eq!(
            s.values.iter().map(|v| s.text(*v)).collect::<Vec<_>>().join(" "),
            "1.5 1.52 1.54 1.56 1.58"
        );
        let s = Sweep::parse("source.polar=0:75:15 deg").unwrap();
        assert_eq!((s.values.len(), s.text(s.values[1])), (6, "15 deg".to_owned()));
        assert_eq!(Sweep::parse("t=10,20,1e2um").unwrap().values, [10.0, 20.0, 100.0]);
        for bad in ["x", "x=", "=1,2", "x=1:2", "x=1:2:0", "x=2:1:0.1", "x=a,b", "x=0:1e9:1"] {
            assert!(Sweep::parse(bad).is_err(), "{bad}");
        }
    }
}
