//! The results folder of a run: figures, tables, plots.

use super::csv::{AngularRow, DepthRow, LedgerRow, SpectrumRow};
use super::plot::{
    Curve, HemisphereMap, LedgerBar, Patch, PolarCurve, PolarPlot, depth_profile, in_plane, spectra,
};
use super::{RunFolder, RunResult, csv};
use crate::math::{PI, acos, atan2};
use crate::run::Outcome;
use crate::run::simulate::GroupResult;
use crate::sap::{Half, Healpix};
use crate::scene::plan::Plan;
use crate::scene::{Scene, Source};
use crate::universe::MediumId;
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
    if let Some(first) = outcome.groups.first() {
        angular(folder, scene, first)?;
        depth(folder, plan, first)?;
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

/// Spectra of the figures that have a wavelength, if there are several.
fn spectrum(folder: &RunFolder, scene: &Scene, result: &RunResult) -> io::Result<()> {
    let names = [
        ("reflectance", "reflectance"),
        ("transmittance", "transmittance"),
        ("absorptance", "absorptance"),
        ("r0", "R0, one sheet over black"),
        ("r_infinity", "R∞, pile of sheets"),
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
    let (incidence, turn) = match scene.source {
        Source::Collimated { polar, azimuth, .. } => (Some(polar), azimuth),
        Source::Point { position, target, .. } => {
            let d = (position - target).normalize();
            let azimuth = if d.x == 0.0 && d.y == 0.0 { 0.0 } else { atan2(d.y, d.x) };
            (Some(acos(d.z)), azimuth)
        }
        Source::Diffuse { .. } => (None, PI),
    };
    // Plots put the light at azimuth 180°, the mirror direction at 0°.
    let patches = patches(group, hp, cells, turn + PI);
    let rows: Vec<AngularRow> = patches
        .iter()
        .map(|p| AngularRow {
            patch: p.patch,
            polar_deg: p.polar_deg,
            azimuth_deg: p.azimuth_deg,
            solid_angle_sr: p.solid_angle_sr,
            value_per_sr: p.value,
            error_per_sr: p.error,
        })
        .collect();
    folder.write(&format!("{stem}.csv"), csv::table(&rows).as_bytes())?;
    let nm = group.wavelengths[0];
    let title = format!("{}, {nm:.0} nm", scene.name);
    let value = ("radiant intensity per incident power", "1/sr");
    let incidence_deg = incidence.map(degrees);
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

fn degrees(x: f64) -> f64 {
    x * 180.0 / PI
}

/// Power per solid angle in every patch, with azimuths counted from `turn`.
fn patches(group: &GroupResult, hp: &Healpix, cells: Range<usize>, turn: f64) -> Vec<Patch> {
    let angles = |d: crate::math::DVec3| {
        let azimuth = degrees(atan2(d.y, d.x) - turn);
        (degrees(acos(d.z)), azimuth - 360.0 * (azimuth / 360.0).floor())
    };
    // Upwards first, then (where they are counted) downwards; a patch on the horizon has a part in each.
    let sides = [Half::Upper, Half::Lower].into_iter().zip(cells.step_by(hp.npix()));
    let mut out = Vec::new();
    for (half, first) in sides {
        for pix in 0..hp.npix() {
            let area = hp.area() * hp.share_in(pix, Some(half));
            if area == 0.0 {
                continue;
            }
            let m = group.moments(first + pix, 0);
            let (polar_deg, azimuth_deg) = angles(hp.representative(pix, Some(half)));
            out.push(Patch {
                patch: pix as u64,
                polar_deg,
                azimuth_deg,
                solid_angle_sr: area,
                value: m.mean() / area,
                error: m.standard_error() / area,
                outline: hp.boundaries(pix, 6).into_iter().map(angles).collect(),
            });
        }
    }
    out
}

/// Absorption and fluence over depth by component, at the first wavelength.
fn depth(folder: &RunFolder, plan: &Plan, group: &GroupResult) -> io::Result<()> {
    let Some(depth) = &group.layout.depth else { return Ok(()) };
    let bins = depth.bins as usize;
    let step = (depth.top - depth.bottom) / bins as f64;
    let edges: Vec<f64> = (0..=bins).map(|i| i as f64 * step).collect();
    for (which, name, what, unit) in [
        (0, "absorbed_by_depth", "absorbed power per depth", "1/um"),
        (1, "fluence_by_depth", "fluence per incident flux", "1"),
    ] {
        let mut rows = Vec::new();
        let mut curves = Vec::new();
        for (i, component) in plan.media.names.iter().enumerate() {
            let cell = |bin| group.layout.depth_cell(MediumId(i as u16), bin) + which;
            let moments: Vec<_> = (0..bins).map(|b| group.moments(cell(b), 0)).collect();
            if moments.iter().all(|m| m.mean() == 0.0) {
                continue;
            }
            let points: Vec<(f64, f64, f64)> = moments
                .iter()
                .enumerate()
                .map(|(b, m)| ((b as f64 + 0.5) * step, m.mean() / step, m.standard_error() / step))
                .collect();
            rows.extend(points.iter().enumerate().map(|(b, &(_, value, error))| DepthRow {
                series: component.clone(),
                from_um: edges[b],
                to_um: edges[b + 1],
                value,
                error,
            }));
            curves.push(Curve { label: component.clone(), points });
        }
        folder.write(&format!("{name}.csv"), csv::table(&rows).as_bytes())?;
        if !curves.is_empty() {
            let title = format!("{what}, {:.0} nm", group.wavelengths[0]);
            depth_profile(&title, (what, unit), &edges, &curves).write(folder, &format!("{name}_plot"))?;
        }
    }
    Ok(())
}
