//! Absorption and fluence over depth by component, at all wavelengths.

use super::csv::table;
use super::plot::{Curve, Plot, depth_profile};
use crate::run::Outcome;
use crate::run::simulate::GroupResult;
use crate::scene::plan::Plan;
use crate::universe::MediumId;
use serde::Serialize;

/// Wavelengths in one plot at most.
const TOGETHER: usize = 7;

/// Value, its place and its error, as a curve has them.
type Points = Vec<(f64, f64, f64)>;

/// What is counted over depth: cell, name, unit.
const QUANTITIES: [(usize, &str, &str); 2] =
    [(0, "absorbed power per depth", "1/um"), (1, "fluence per incident flux", "1")];

/// A row of `absorbed_by_depth.csv` (1/um) and `fluence_by_depth.csv` (1).
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Row<'a> {
    series: &'a str,
    wavelength_nm: f64,
    from_um: f64,
    to_um: f64,
    value: f64,
    error: f64,
}

/// Limits of the layers, µm below the top; `None` where depth was not counted.
fn edges(group: &GroupResult) -> Option<Vec<f64>> {
    let depth = group.layout.depth.as_ref()?;
    let step = (depth.top - depth.bottom) / f64::from(depth.bins);
    Some((0..=depth.bins).map(|i| f64::from(i) * step).collect())
}

/// Profile of a component; `None` if nothing was counted.
fn profile(
    group: &GroupResult,
    lane: usize,
    component: usize,
    which: usize,
    edges: &[f64],
) -> Option<Points> {
    let cell = |bin| group.layout.depth_cell(MediumId(component as u16), bin) + which;
    let points: Points = edges
        .windows(2)
        .enumerate()
        .map(|(b, e)| {
            let (m, step) = (group.moments(cell(b), lane), e[1] - e[0]);
            (0.5 * (e[0] + e[1]), m.mean() / step, m.standard_error() / step)
        })
        .collect();
    points.iter().any(|p| p.1 != 0.0).then_some(points)
}

/// Files of the results folder: stem, and all components at all wavelengths as CSV.
pub fn tables(plan: &Plan, outcome: &Outcome) -> Vec<(&'static str, String)> {
    let Some(edges) = outcome.groups.first().and_then(edges) else { return Vec::new() };
    let mut out = Vec::new();
    for ((which, ..), stem) in QUANTITIES.into_iter().zip(["absorbed_by_depth", "fluence_by_depth"]) {
        let mut rows = Vec::new();
        for (series, component) in plan.media.names.iter().zip(0..) {
            for (wavelength_nm, group, lane) in outcome.wavelengths() {
                let points = profile(group, lane, component, which, &edges).unwrap_or_default();
                rows.extend(edges.windows(2).zip(points).map(|(e, (_, value, error))| Row {
                    series,
                    wavelength_nm,
                    from_um: e[0],
                    to_um: e[1],
                    value,
                    error,
                }));
            }
        }
        if !rows.is_empty() {
            out.push((stem, table(&rows)));
        }
    }
    out
}

/// Plots: what they show, the stem of their file, and the plot. All components at the first wavelength; and
/// where there are several wavelengths, up to seven of them for the component with the largest values.
pub fn plots(plan: &Plan, outcome: &Outcome) -> Vec<(String, String, Plot)> {
    let Some(first) = outcome.groups.first() else { return Vec::new() };
    let Some(edges) = edges(first) else { return Vec::new() };
    let all: Vec<(f64, &GroupResult, usize)> = outcome.wavelengths().collect();
    let mut out = Vec::new();
    for ((which, what, unit), stem) in QUANTITIES.into_iter().zip(["absorbed_by_depth", "fluence_by_depth"]) {
        let mut curves = Vec::new();
        for (i, name) in plan.media.names.iter().enumerate() {
            let points = profile(first, 0, i, which, &edges);
            curves.extend(points.map(|points| Curve { label: name.clone(), points }));
        }
        if !curves.is_empty() {
            let title = format!("{what}, {:.0} nm", first.wavelengths[0]);
            let plot = depth_profile(&title, (what, unit), &edges, &curves);
            out.push((format!("{what}: by component"), format!("{stem}_plot"), plot));
        }
        let total = |component: usize| -> f64 {
            let each = all.iter().filter_map(|(_, g, lane)| profile(g, *lane, component, which, &edges));
            each.flatten().map(|p| p.1).sum()
        };
        let totals: Vec<f64> = (0..plan.media.names.len()).map(total).collect();
        let most = (0..totals.len()).max_by(|a, b| totals[*a].total_cmp(&totals[*b]));
        let Some(most) = most.filter(|&i| all.len() > 1 && totals[i] > 0.0) else { continue };
        let shown = all.len().min(TOGETHER);
        let curves: Vec<Curve> = (0..shown)
            .filter_map(|k| {
                let (nm, group, lane) = all[k * (all.len() - 1) / (shown - 1)];
                let points = profile(group, lane, most, which, &edges)?;
                Some(Curve { label: format!("{nm:.0} nm"), points })
            })
            .collect();
        let name = &plan.media.names[most];
        let plot = depth_profile(&format!("{what}: {name}"), (what, unit), &edges, &curves);
        out.push((format!("{what} in '{name}': by wavelength"), format!("{stem}_wavelengths"), plot));
    }
    out
}
