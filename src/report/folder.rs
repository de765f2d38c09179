//! The results folder of a run: figures, tables, plots.

use super::csv::{LedgerRow, SpectrumRow};
use super::directions::{self, Directions};
use super::plot::{Curve, HemisphereMap, LedgerBar, PolarCurve, PolarPlot, in_plane, spectra};
use super::{RunFolder, RunResult, csv};
use crate::run::Outcome;
use crate::run::simulate::GroupResult;
use crate::sap::Healpix;
use crate::scene::Scene;
use crate::scene::plan::Plan;
use std::io;
use std::ops::Range;

/// Writes everything but the manifest.
///
/// # Errors
/// What the file system says.
pub fn write(
    folder: &RunFolder,
    scene: &Scene,
    plan: &Plan,
    outcome: &Outcome,
    result: &RunResult,
) -> io::Result<()> {
    folder.write("result.json", result.to_json().as_bytes())?;
    folder.write("figures.csv", csv::figures(&result.figures).as_bytes())?;
    ledger(folder, result)?;
    spectrum(folder, scene, result)?;
    super::instruments::write(folder, scene, outcome)?;
    for_others(folder, scene, outcome)?;
    if let Some(first) = outcome.groups.first() {
        angular(folder, scene, first)?;
        depth(folder, plan, outcome)?;
    }
    Ok(())
}

fn ledger(folder: &RunFolder, result: &RunResult) -> io::Result<()> {
    let rows: Vec<LedgerRow> = result
        .ledger
        .0
        .iter()
        .map(|(fate, s)| LedgerRow { fate: fate.clone(), share: s.value, error: s.error })
        .collect();
    folder.write("ledger.csv", csv::table(&rows).as_bytes())?;
    let title = format!("{}: where the light went", result.scene);
    LedgerBar { title: &title, ledger: &result.ledger }.plot().write(folder, "ledger_plot")
}

/// Maps, arrays, BRDF and BSDF of directions, at all wavelengths.
fn for_others(folder: &RunFolder, scene: &Scene, outcome: &Outcome) -> io::Result<()> {
    let Some(first) = outcome.groups.first() else { return Ok(()) };
    if let Some(xml) = super::files::bsdf_xml(&scene.name, first) {
        folder.write("bsdf.xml", xml.as_bytes())?;
    }
    let (Some(directions), Some(hp)) = (Directions::leaving(scene, first), &first.layout.angular) else {
        return Ok(());
    };
    for (name, bytes) in super::files::angular(&directions, outcome, hp.nside()) {
        folder.write(&name, &bytes)?;
    }
    let rows: Vec<_> = outcome
        .wavelengths()
        .flat_map(|(_, group, lane)| directions::bsdf_rows(&directions, group, lane))
        .collect();
    folder.write("brdf.csv", csv::table(&rows).as_bytes())
}

/// Spectra of the figures that have a wavelength: rows and curves.
pub fn spectral_curves(result: &RunResult) -> (Vec<SpectrumRow>, Vec<Curve>) {
    let names = [
        ("reflectance", "reflectance"),
        ("transmittance", "transmittance"),
        ("absorptance", "absorptance"),
        ("r0", "R0, one sheet over black"),
        ("r_infinity", "R∞, pile of sheets"),
        ("r_backing", "RB, over the backing"),
        ("checkpoint", "checkpoint plane"),
    ];
    let mut rows = Vec::new();
    let mut curves: Vec<Curve> = Vec::new();
    for (name, label) in names {
        // A bound is no point of a spectrum.
        let measured = |f: &&super::Figure| f.name == name && f.component.is_none() && f.error.is_some();
        let of: Vec<_> = result.figures.iter().filter(measured).collect();
        let points: Vec<(f64, f64, f64)> =
            of.iter().filter_map(|f| Some((f.wavelength_nm?, f.value?, f.error.unwrap_or(0.0)))).collect();
        rows.extend(points.iter().map(|&(nm, value, error)| SpectrumRow {
            series: label.to_owned(),
            wavelength_nm: nm,
            value,
            error,
        }));
        if !points.is_empty() {
            curves.push(Curve { label: label.to_owned(), points });
        }
    }
    (rows, curves)
}

/// Table of spectra, and their plot if there are several wavelengths.
fn spectrum(folder: &RunFolder, scene: &Scene, result: &RunResult) -> io::Result<()> {
    let (rows, curves) = spectral_curves(result);
    folder.write("spectra.csv", csv::table(&rows).as_bytes())?;
    if scene.wavelengths.len() > 1 {
        let title = format!("{}: spectra", scene.name);
        spectra(&title, ("share of the incident power", "1"), &curves).write(folder, "spectra_plot")?;
    }
    Ok(())
}

/// Polar diagram, hemisphere map and table of what leaves, at the first wavelength.
fn angular(folder: &RunFolder, scene: &Scene, group: &GroupResult) -> io::Result<()> {
    let Some(hp) = &group.layout.angular else { return Ok(()) };
    write_angular(folder, scene, group, hp, group.layout.angular_range(), "angular")?;
    let checkpoint = group.layout.checkpoint_range();
    if checkpoint.is_empty() {
        return Ok(());
    }
    write_angular(folder, scene, group, hp, checkpoint, "checkpoint")
}

fn write_angular(
    folder: &RunFolder,
    scene: &Scene,
    group: &GroupResult,
    hp: &Healpix,
    cells: Range<usize>,
    stem: &str,
) -> io::Result<()> {
    let directions = Directions::new(scene, hp, cells);
    let patches = directions.plotted(group, 0);
    folder.write(&format!("{stem}.csv"), directions::angular_csv(&patches).as_bytes())?;
    let nm = group.wavelengths[0];
    let title = format!("{}, {nm:.0} nm", scene.name);
    let value = ("radiant intensity per incident power", "1/sr");
    let incidence_deg = directions.incidence_deg;
    let curve = PolarCurve { label: format!("{nm:.0} nm"), points: in_plane(&patches), smooth: false };
    PolarPlot { title: &title, value, incidence_deg, decades: None, curves: &[curve] }
        .plot()
        .write(folder, &format!("{stem}_polar"))?;
    for (below, name) in [(false, "above"), (true, "below")] {
        let any = patches.iter().any(|p| (p.polar_deg > 90.0) == below && p.value > 0.0);
        if any {
            HemisphereMap { title: &title, value, incidence_deg, below, patches: &patches }
                .plot()
                .write(folder, &format!("{stem}_{name}"))?;
        }
    }
    Ok(())
}

/// Absorption and fluence over depth: tables of all wavelengths, and plots.
fn depth(folder: &RunFolder, plan: &Plan, outcome: &Outcome) -> io::Result<()> {
    for (stem, csv) in super::depth::tables(plan, outcome) {
        folder.write(&format!("{stem}.csv"), csv.as_bytes())?;
    }
    for (_, stem, plot) in super::depth::plots(plan, outcome) {
        plot.write(folder, &stem)?;
    }
    Ok(())
}
