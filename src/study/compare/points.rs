//! What of a result is compared: figures, and curves point by point.

use crate::math::PI;
use crate::report::directions::Directions;
use crate::report::figures::together;
use crate::report::{Figure, RunResult, Status, instruments};
use crate::run::Outcome;
use crate::run::simulate::GroupResult;
use crate::sap::Half;
use crate::scene::Scene;
use crate::scene::plan::Plan;
use crate::universe::MediumId;
use std::ops::Range;

/// One value of a figure or curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Figure or curve that it belongs to.
    pub figure: String,
    /// Along which axis, and where; `None`: a figure without one.
    pub at: Option<(Axis, f64)>,
    /// Value.
    pub value: f64,
    /// Standard error.
    pub error: f64,
    /// Degrees of freedom of `error`.
    pub dof: f64,
    /// Unit.
    pub unit: String,
}

/// What a curve runs over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Vacuum wavelength, nm.
    Wavelength,
    /// Polar angle from the normal of the face, degrees.
    Polar,
    /// Depth below the top, µm.
    Depth,
    /// Distance, spatial frequency, path length: the unit of its table.
    Place,
}

impl Axis {
    /// Name and unit.
    pub fn words(self) -> (&'static str, &'static str) {
        match self {
            Axis::Wavelength => ("wavelength", "nm"),
            Axis::Polar => ("polar angle", "deg"),
            Axis::Depth => ("depth below the top", "µm"),
            Axis::Place => ("place", "1"),
        }
    }
}

/// How far apart two values of a figure may be to count as equal; `margin` is that of a reflectance, and the
/// others follow: 100 × for figures in per cent and of colour, 5 × for reflectance factors of directions, and
/// 2 × as a share of the value for lengths, numbers and coefficients.
pub fn margin_of(point: &Point, reference: f64, margin: f64) -> f64 {
    const SHARES: [&str; 9] = [
        "reflectance",
        "transmittance",
        "absorptance",
        "absorbed",
        "r0",
        "r_infinity",
        "r_backing",
        "checkpoint",
        "converted",
    ];
    let name = point.figure.split([' ', '[']).next().unwrap_or_default();
    if SHARES.contains(&name) {
        margin
    } else if name == "brf" || name == "btf" {
        5.0 * margin
    } else if point.unit == "%" || ["l_star", "a_star", "b_star"].iter().any(|c| name.starts_with(c)) {
        100.0 * margin
    } else if ["whiteness", "tint"].iter().any(|c| name.starts_with(c)) {
        400.0 * margin
    } else {
        2.0 * margin * reference.abs()
    }
}

/// All points of a result.
pub fn points(scene: &Scene, plan: &Plan, outcome: &Outcome, result: &RunResult) -> Vec<Point> {
    let mut out: Vec<Point> = result.figures.iter().filter_map(|f| figure(f, scene)).collect();
    let all: Vec<_> = outcome.wavelengths().collect();
    if let Some(&(_, group, lane)) = all.get(all.len() / 2) {
        out.extend(rings(scene, group, lane));
        out.extend(depth(plan, group, lane));
    }
    for t in instruments::tables(outcome) {
        let Some(first) = t.rows.first().map(|r| r.wavelength_nm) else { continue };
        for r in t.rows.iter().filter(|r| r.wavelength_nm == first && r.error.is_finite()) {
            let Some(to) = r.to else { continue };
            out.push(Point {
                figure: format!("{} [{}]", t.stem, r.light),
                at: Some((Axis::Place, 0.5 * (r.from + to))),
                value: r.value,
                error: r.error,
                dof: replicas(outcome),
                unit: t.y.1.to_owned(),
            });
        }
    }
    out
}

fn replicas(outcome: &Outcome) -> f64 {
    outcome.groups.iter().map(|g| g.node.replicas.len()).min().unwrap_or(0) as f64 - 1.0
}

/// A figure with an error; bounds and what is not available are not compared, nor is the variance between
/// realisations, which is told by itself.
fn figure(f: &Figure, scene: &Scene) -> Option<Point> {
    if matches!(f.status, Status::UpperBound | Status::NotAvailable)
        || f.name.ends_with("_between_realisations")
    {
        return None;
    }
    let mut name = f.name.clone();
    name += &f.component.as_ref().map_or(String::new(), |c| format!(" [{c}]"));
    name += &f.polar_deg.map_or(String::new(), |p| format!(" ({p}°, {}°)", f.azimuth_deg.unwrap_or(0.0)));
    let several = scene.wavelengths.len() > 1;
    Some(Point {
        figure: name,
        at: f.wavelength_nm.filter(|_| several).map(|nm| (Axis::Wavelength, nm)),
        value: f.value?,
        error: f.error?,
        dof: f.dof.unwrap_or(f64::INFINITY),
        unit: f.unit.clone(),
    })
}

/// Least ∫ cos θ dω of a ring of directions, sr: less is seen by too few histories to compare.
const RING: f64 = 0.25;

/// Reflectance and transmittance factors π dP/(cos θ dω) of rings of patches about the normal (the mean over
/// azimuth; neighbouring rings go together up to [`RING`]), at the middle wavelength.
fn rings(scene: &Scene, group: &GroupResult, lane: usize) -> Vec<Point> {
    let Some(directions) = Directions::leaving(scene, group) else { return Vec::new() };
    let cells: Range<usize> = group.layout.angular_range();
    let npix = (cells.end - cells.start) / 2;
    let mut out: Vec<Point> = Vec::new();
    for (half, name) in [(Half::Upper, "brf"), (Half::Lower, "btf")] {
        // Patches by polar angle, from the normal of the face.
        let from = |p: f64| if half == Half::Upper { p } else { 180.0 - p };
        let mut patches: Vec<(f64, usize, f64)> = directions
            .patches
            .iter()
            .filter(|p| p.half == half)
            .map(|p| {
                let start = cells.start + if half == Half::Lower { npix } else { 0 };
                (from(p.polar_deg), start + p.pix, p.projected)
            })
            .collect();
        patches.sort_by(|a, b| a.0.total_cmp(&b.0));
        let projected_of = |ring: &[(f64, usize, f64)]| ring.iter().map(|p| p.2).sum::<f64>();
        let mut wide: Vec<Vec<(f64, usize, f64)>> = Vec::new();
        for ring in patches.chunk_by(|a, b| (a.0 - b.0).abs() < 1e-6) {
            match wide.last_mut().filter(|w| projected_of(w) < RING) {
                Some(last) => last.extend(ring),
                None => wide.push(ring.to_vec()),
            }
        }
        // What is left over at the horizon goes to the last whole ring.
        if wide.len() > 1 && wide.last().is_some_and(|w| projected_of(w) < RING) {
            let rest = wide.pop().unwrap_or_default();
            wide.last_mut().into_iter().for_each(|w| w.extend(&rest));
        }
        for ring in &wide {
            let projected = projected_of(ring);
            let polar = ring.iter().map(|p| p.0 * p.2).sum::<f64>() / projected;
            let own: Vec<usize> = ring.iter().map(|p| p.1).collect();
            let (power, error) = together(group, lane, &own);
            out.push(Point {
                figure: name.to_owned(),
                at: Some((Axis::Polar, polar)),
                value: PI * power / projected,
                error: PI * error / projected,
                dof: group.node.replicas.len() as f64 - 1.0,
                unit: "1".to_owned(),
            });
        }
    }
    out
}

/// Path per depth (fluence over incident flux) in layers, over all media, at the middle wavelength.
fn depth(plan: &Plan, group: &GroupResult, lane: usize) -> Vec<Point> {
    let Some(depth) = group.layout.depth else { return Vec::new() };
    let height = (depth.top - depth.bottom) / f64::from(depth.bins);
    (0..depth.bins as usize)
        .map(|bin| {
            let media = 0..plan.media.names.len();
            let cells: Vec<usize> =
                media.map(|m| group.layout.depth_cell(MediumId(m as u16), bin) + 1).collect();
            let (path, error) = together(group, lane, &cells);
            Point {
                figure: "fluence".to_owned(),
                at: Some((Axis::Depth, (bin as f64 + 0.5) * height)),
                value: path / height,
                error: error / height,
                dof: group.node.replicas.len() as f64 - 1.0,
                unit: "1".to_owned(),
            }
        })
        .collect()
}
