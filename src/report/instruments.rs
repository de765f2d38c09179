//! Figures and tables of the detectors: gloss, haze, halftone, lateral spread, path length and time of
//! flight.

use super::csv::table;
use super::plot::{Curve, LinePlot, Plot};
use super::{Figure, RunFolder, Status};
use crate::math::{PI, pow};
use crate::optics::reflectance::interpolation;
use crate::run::Outcome;
use crate::run::simulate::GroupResult;
use crate::scene::{Halftone, Scene, Source};
use crate::stats::jackknife;
use crate::tally::detectors::{Measures, black_glass};
use crate::tally::{Cell, Layout};
use crate::universe::Face;
use serde::{Deserialize, Serialize};
use std::io;

/// Speed of light in vacuum, µm/ps.
pub const LIGHT_SPEED: f64 = 299.792_458;

const FACES: [(Face, &str); 2] = [(Face::Top, "reflected"), (Face::Bottom, "transmitted")];

/// Replicas of a set of cells in one lane, for a jackknife over functions of their means.
pub fn replicas(
    group: &GroupResult,
    lane: usize,
    cells: impl Iterator<Item = usize> + Clone,
) -> Vec<(u64, Vec<f64>)> {
    let lanes = group.layout.lanes;
    let of =
        |(n, sums): &(u64, Vec<f64>)| (*n, cells.clone().map(|c| sums[c * lanes + lane]).collect::<Vec<_>>());
    group.node.replicas.values().map(of).collect()
}

fn face_cell(layout: &Layout, face: Face) -> usize {
    layout.of(if face == Face::Top { Cell::Reflected } else { Cell::Transmitted })
}

/// All figures of the detectors at one wavelength (to be set by the caller).
pub fn figures(scene: &Scene, group: &GroupResult, lane: usize) -> Vec<Figure> {
    let mut out = Vec::new();
    apertures(scene, group, lane, &mut out);
    halftones(scene, group, lane, &mut out);
    views(scene, group, lane, &mut out);
    lateral(group, lane, &mut out);
    flight(group, lane, &mut out);
    out
}

/// Gloss (100 for black glass) and haze (share of the transmitted light, %).
fn apertures(scene: &Scene, group: &GroupResult, lane: usize, out: &mut Vec<Figure>) {
    let layout = &group.layout;
    let Source::Collimated { polar, .. } = scene.source else { return };
    for (i, aperture) in layout.detectors.apertures.iter().enumerate() {
        let cell = layout.detectors_start() + i;
        match aperture.measures {
            Measures::Gloss => {
                let m = group.moments(cell, lane);
                let scale = 100.0 / black_glass(polar);
                let f = super::figures::figure("gloss", &m, group.node.batches, "1");
                let f = Figure { value: f.value.map(|v| v * scale), error: f.error.map(|e| e * scale), ..f };
                out.push(Figure { polar_deg: Some(polar * 180.0 / PI), ..f });
            }
            Measures::Haze => {
                let cells = [cell, layout.of(Cell::Transmitted)];
                let reps = replicas(group, lane, cells.into_iter());
                let (value, error) = jackknife(&reps, |m| vec![100.0 * m[0] / m[1]])[0];
                out.push(told(Figure::new("haze", value, error, "%"), "light that is transmitted"));
            }
        }
    }
}

/// BRDF or BTDF in exact directions: radiant intensity per incident power over |cos θ|, 1/sr.
fn views(scene: &Scene, group: &GroupResult, lane: usize, out: &mut Vec<Figure>) {
    let layout = &group.layout;
    let start = layout.detectors_start() + layout.detectors.views_start();
    for (i, &(polar, azimuth)) in scene.detect.views.iter().enumerate() {
        let m = group.moments(start + i, lane);
        let scale = 1.0 / crate::math::cos(polar).abs();
        let name = if polar <= crate::math::FRAC_PI_2 { "brdf" } else { "btdf" };
        let f = Figure::new(name, m.mean() * scale, m.standard_error() * scale, "1/sr").with_dof(m.dof());
        let deg = |x: f64| x * 180.0 / PI;
        out.push(f.in_direction(deg(polar), deg(azimuth)));
    }
}

/// The figure, with the reason where there is none.
fn told(figure: Figure, needs: &str) -> Figure {
    if figure.status == Status::NotAvailable {
        figure.with_note(&format!("not available: needs {needs}"))
    } else {
        figure
    }
}

/// Yule–Nielsen factor n of a halftone: ρ^(1/n) = a t^(1/n) + 1 − a, with ρ the reflectance of the
/// halftone and t that of the solid ink, both over that of the bare sheet, and a the coverage
/// (J. A. C. Yule and W. J. Nielsen, Proc. TAGA 1951, 65). 1: light leaves where it entered
/// (Murray–Davies); 2: it forgets where. NaN where no n in 0.8 … 100 gives ρ.
pub fn yule_nielsen(rho: f64, coverage: f64, solid: f64) -> f64 {
    // The black solid ink of transmittance 0 leaves (1 − a)^n.
    let of = |n: f64| pow(coverage * pow(solid, 1.0 / n) + 1.0 - coverage, n);
    let (mut low, mut high) = (0.8, 100.0);
    if !(of(high) < rho && rho < of(low)) {
        return f64::NAN;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if of(middle) > rho { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Reflectance of each halftone, and its n.
fn halftones(scene: &Scene, group: &GroupResult, lane: usize, out: &mut Vec<Figure>) {
    let layout = &group.layout;
    let start = layout.detectors_start() + layout.detectors.halftone_start();
    for (i, screen) in scene.detect.halftones.iter().enumerate() {
        let cells = [start + i, layout.of(Cell::Reflected)];
        let reps = replicas(group, lane, cells.into_iter());
        let n = |rho: f64| yule_nielsen(rho, screen.coverage, screen.ink * screen.ink);
        let values = jackknife(&reps, |m| vec![m[0], n(m[0] / m[1])]);
        let name = screen_name(screen);
        let r = Figure::new("halftone_reflectance", values[0].0, values[0].1, "1").of_component(&name);
        let n = Figure::new("yule_nielsen_n", values[1].0, values[1].1, "1").of_component(&name);
        out.push(r);
        out.push(told(n, "ink that shows: a coverage between 0 and 1, and enough histories"));
    }
}

fn screen_name(h: &Halftone) -> String {
    format!("{:.0} % ink, {:.0} um", 100.0 * h.coverage, h.period)
}

/// Modulation transfer function of a face: (frequency 1/µm, value, standard error), from frequency 0.
fn mtf(group: &GroupResult, lane: usize, face: Face) -> Option<Vec<(f64, f64, f64)>> {
    let layout = &group.layout;
    let lateral = layout.detectors.lateral.as_ref()?;
    let start = layout.detectors_start() + layout.detectors.mtf_start(face);
    let cells = [face_cell(layout, face)].into_iter().chain(start..start + lateral.frequencies.len());
    let values = jackknife(&replicas(group, lane, cells), |m| m.iter().map(|x| x / m[0]).collect());
    if !values[0].0.is_finite() {
        return None;
    }
    let places = [0.0].into_iter().chain(lateral.frequencies.iter().copied());
    Some(places.zip(values).map(|(f, (v, e))| (f, v, e)).collect())
}

/// Where a falling curve of (place, value) first goes below one half, by the cubic through the four points
/// about it.
fn half_place(places: &[f64], values: &[f64]) -> f64 {
    let below = values.iter().position(|v| *v < 0.5).filter(|i| *i > 0);
    let Some(i) = below else { return f64::NAN };
    let at = |x: f64| interpolation(places, x).map(|(i, w)| w * values[i]).sum::<f64>();
    let (mut low, mut high) = (places[i - 1], places[i]);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if at(middle) < 0.5 { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

/// Spatial frequency at which the modulation falls to one half, 1/mm.
fn lateral(group: &GroupResult, lane: usize, out: &mut Vec<Figure>) {
    let layout = &group.layout;
    let Some(lateral) = &layout.detectors.lateral else { return };
    let places: Vec<f64> = [0.0].into_iter().chain(lateral.frequencies.iter().copied()).collect();
    for (face, name) in FACES {
        if group.moments(face_cell(layout, face), lane).mean() == 0.0 {
            continue;
        }
        let start = layout.detectors_start() + layout.detectors.mtf_start(face);
        let cells = [face_cell(layout, face)].into_iter().chain(start..start + lateral.frequencies.len());
        let half = |m: &[f64]| {
            let values: Vec<f64> = m.iter().map(|x| x / m[0]).collect();
            vec![1e3 * half_place(&places, &values)]
        };
        let (value, error) = jackknife(&replicas(group, lane, cells), half)[0];
        let figure = Figure::new("mtf_half_frequency", value, error, "1/mm").of_component(name);
        out.push(told(figure, "frequencies at which the modulation is below one half: a smaller `lateral`"));
    }
}

/// Mean path (µm) and mean time of flight (ps) of the light that leaves each face.
fn flight(group: &GroupResult, lane: usize, out: &mut Vec<Figure>) {
    let layout = &group.layout;
    let Some(flight) = &layout.detectors.flight else { return };
    for (face, name) in FACES {
        if group.moments(face_cell(layout, face), lane).mean() == 0.0 {
            continue;
        }
        let sums =
            layout.detectors_start() + layout.detectors.flight_start(face) + 2 * (flight.bins as usize + 1);
        let cells = [face_cell(layout, face), sums, sums + 1];
        let of = |m: &[f64]| vec![m[1] / m[0], m[2] / m[0] / LIGHT_SPEED];
        let values = jackknife(&replicas(group, lane, cells.into_iter()), of);
        let put = |what: &str, (v, e): (f64, f64), unit| Figure::new(what, v, e, unit).of_component(name);
        out.push(put("path_length", values[0], "um"));
        out.push(put("time_of_flight", values[1], "ps"));
    }
}

/// One value of a curve over a place, frequency, length or time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurveRow {
    /// Vacuum wavelength in nm.
    pub wavelength_nm: f64,
    /// `reflected` or `transmitted`.
    pub light: String,
    /// Beginning of the bin, or the place itself (unit in the file's documentation).
    pub from: f64,
    /// End of the bin, or the place itself; empty: beyond.
    pub to: Option<f64>,
    /// Value.
    pub value: f64,
    /// Standard error.
    pub error: f64,
}

/// Writes tables and plots of lateral spread and flight, for all wavelengths.
///
/// # Errors
/// What the file system says.
pub fn write(folder: &RunFolder, scene: &Scene, outcome: &Outcome) -> io::Result<()> {
    for t in tables(outcome) {
        let plot = Plot { svg: t.svg(&scene.name), csv: table(&t.rows) };
        plot.write(folder, t.stem)?;
    }
    Ok(())
}

/// A table with its plot.
#[derive(Clone, Debug)]
pub struct CurveTable {
    /// File name without ending.
    pub stem: &'static str,
    /// Title of the plot.
    pub title: &'static str,
    /// Quantity and unit along x.
    pub x: (&'static str, &'static str),
    /// Quantity and unit along y.
    pub y: (&'static str, &'static str),
    /// Rows, all wavelengths.
    pub rows: Vec<CurveRow>,
}

impl CurveTable {
    /// Curves of the first wavelength.
    pub fn curves(&self) -> Vec<Curve> {
        let nm = self.rows.first().map_or(0.0, |r| r.wavelength_nm);
        let curve = |name: &str| {
            let rows = self.rows.iter().filter(|r| r.wavelength_nm == nm && r.light == name);
            let points = rows.filter_map(|r| Some((0.5 * (r.from + r.to?), r.value, r.error))).collect();
            Curve { label: name.to_owned(), points }
        };
        FACES.iter().map(|(_, name)| curve(name)).filter(|c| !c.points.is_empty()).collect()
    }

    /// The plot of the first wavelength.
    pub fn svg(&self, scene: &str) -> String {
        let nm = self.rows.first().map_or(0.0, |r| r.wavelength_nm);
        let title = format!("{}, {nm:.0} nm: {scene}", self.title);
        LinePlot { title: &title, x: self.x, y: self.y, curves: &self.curves(), dots: false }.svg()
    }
}

/// The tables of all detectors with curves.
pub fn tables(outcome: &Outcome) -> Vec<CurveTable> {
    let mut psf = CurveTable {
        stem: "point_spread",
        title: "Point spread",
        x: ("distance from where light enters", "µm"),
        y: ("power per area", "1/mm²"),
        rows: Vec::new(),
    };
    let mut edge = CurveTable {
        stem: "edge_response",
        title: "Edge response",
        x: ("distance from the edge", "µm"),
        y: ("share of the full field", "1"),
        rows: Vec::new(),
    };
    let mut transfer = CurveTable {
        stem: "mtf",
        title: "Modulation transfer",
        x: ("spatial frequency", "1/mm"),
        y: ("modulation", "1"),
        rows: Vec::new(),
    };
    let mut paths = CurveTable {
        stem: "path_histogram",
        title: "Path length of light that leaves",
        x: ("path length", "µm"),
        y: ("share per path length", "1/µm"),
        rows: Vec::new(),
    };
    let mut times = CurveTable {
        stem: "time_histogram",
        title: "Time of flight",
        x: ("time of flight", "ps"),
        y: ("share per time", "1/ps"),
        rows: Vec::new(),
    };
    for (nm, group, lane) in outcome.wavelengths() {
        for (face, light) in FACES {
            if group.moments(face_cell(&group.layout, face), lane).mean() == 0.0 {
                continue;
            }
            let row = |from, to, value, error| CurveRow {
                wavelength_nm: nm,
                light: light.to_owned(),
                from,
                to,
                value,
                error,
            };
            psf.rows.extend(rings(group, lane, face).map(|(f, t, v, e)| row(f, t, v, e)));
            edge.rows.extend(edges(group, lane, face).into_iter().map(|(x, v, e)| row(x, Some(x), v, e)));
            let points = mtf(group, lane, face).unwrap_or_default();
            transfer.rows.extend(points.into_iter().map(|(f, v, e)| row(1e3 * f, Some(1e3 * f), v, e)));
            paths.rows.extend(bins(group, lane, face, false).map(|(f, t, v, e)| row(f, t, v, e)));
            times.rows.extend(bins(group, lane, face, true).map(|(f, t, v, e)| row(f, t, v, e)));
        }
    }
    [psf, edge, transfer, paths, times].into_iter().filter(|t| !t.rows.is_empty()).collect()
}

type Bin = (f64, Option<f64>, f64, f64);

/// Rings of the point spread function, power per area in 1/mm²; the last row is the power beyond.
fn rings(group: &GroupResult, lane: usize, face: Face) -> impl Iterator<Item = Bin> + '_ {
    let layout = &group.layout;
    layout.detectors.lateral.iter().flat_map(move |lateral| {
        let start = layout.detectors_start() + layout.detectors.lateral_start(face);
        let step = lateral.radius / f64::from(lateral.rings);
        (0..=lateral.rings).map(move |i| {
            let m = group.moments(start + i as usize, lane);
            let from = f64::from(i) * step;
            if i == lateral.rings {
                return (from, None, m.mean(), m.standard_error());
            }
            let to = from + step;
            let area = 1e-6 * PI * (to * to - from * from);
            (from, Some(to), m.mean() / area, m.standard_error() / area)
        })
    })
}

/// Edge response: share of the full field's light at a distance from the edge of a lit half plane.
fn edges(group: &GroupResult, lane: usize, face: Face) -> Vec<(f64, f64, f64)> {
    let layout = &group.layout;
    let Some(lateral) = &layout.detectors.lateral else { return Vec::new() };
    let start = layout.detectors_start() + layout.detectors.edge_start(face);
    let places = lateral.edge_places();
    let cells = [face_cell(layout, face)].into_iter().chain(start..start + places.len());
    let values = jackknife(&replicas(group, lane, cells), |m| m[1..].iter().map(|x| x / m[0]).collect());
    places.into_iter().zip(values).map(|(x, (v, e))| (x, v, e)).collect()
}

/// Bins of the path (µm) or time (ps) histogram as a density; the last row is the share beyond.
fn bins(group: &GroupResult, lane: usize, face: Face, time: bool) -> impl Iterator<Item = Bin> + '_ {
    let layout = &group.layout;
    layout.detectors.flight.iter().flat_map(move |flight| {
        let n = flight.bins;
        let skip = if time { n as usize + 1 } else { 0 };
        let start = layout.detectors_start() + layout.detectors.flight_start(face) + skip;
        let end = if time { flight.latest() / LIGHT_SPEED } else { flight.longest };
        let step = end / f64::from(n);
        (0..=n).map(move |i| {
            let m = group.moments(start + i as usize, lane);
            let from = f64::from(i) * step;
            if i == n {
                return (from, None, m.mean(), m.standard_error());
            }
            (from, Some(from + step), m.mean() / step, m.standard_error() / step)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn yule_nielsen_factors_of_known_halftones() {
        for (n, a, t) in [(1.0, 0.5, 0.0025), (1.7, 0.3, 0.01), (2.0, 0.5, 0.04), (1.2, 0.8, 0.0)] {
            let rho = pow(a * pow(t, 1.0 / n) + 1.0 - a, n);
            assert!((yule_nielsen(rho, a, t) - n).abs() < 1e-9, "{n} {a} {t}");
        }
        // Light that forgets where it entered: (1 − a + a ink)².
        assert!((yule_nielsen((1.0 - 0.4 + 0.4 * 0.3_f64).powi(2), 0.4, 0.09) - 2.0).abs() < 1e-9);
        assert!(yule_nielsen(1.0, 0.0, 0.01).is_nan() && yule_nielsen(0.01, 1.0, 0.01).is_nan());
    }

    #[test]
    fn half_places_lie_between_points() {
        let parabola = [0.0, 1.0, 2.0, 3.0].map(|x| 1.0 - 0.125 * x * x);
        assert!((half_place(&[0.0, 1.0, 2.0, 3.0], &parabola) - 2.0).abs() < 1e-9);
        assert!(half_place(&[0.0, 1.0], &[1.0, 0.6]).is_nan());
    }
}
