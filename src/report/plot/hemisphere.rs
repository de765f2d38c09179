//! Map of a hemisphere: a disc that keeps areas, one polygon a patch, coloured by value.

use super::Plot;
use super::axes::Ticks;
use super::canvas::{Anchor, Canvas, Place, draw, fitted};
use super::colours::{INCIDENT, INK, WHITE, ramp};
use crate::math::{PI, sin, sin_cos};
use crate::report::csv::{AngularRow, table};

/// One patch of an angular distribution.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Index (HEALPix RING).
    pub patch: u64,
    /// Polar angle of the centre from the upward normal, degrees, 0 to 180.
    pub polar_deg: f64,
    /// Azimuth of the centre, degrees; 0 is the side of the mirror direction.
    pub azimuth_deg: f64,
    /// Solid angle in sr.
    pub solid_angle_sr: f64,
    /// Value per sr.
    pub value: f64,
    /// Standard error per sr.
    pub error: f64,
    /// Boundary as (polar, azimuth) in degrees, in order around; the more points, the rounder.
    pub outline: Vec<(f64, f64)>,
}

/// A map of one hemisphere.
#[derive(Clone, Debug, PartialEq)]
pub struct HemisphereMap<'a> {
    /// Title.
    pub title: &'a str,
    /// Quantity and unit of the colour ("1": no unit).
    pub value: (&'a str, &'a str),
    /// Polar angle of incidence in degrees, if the light is collimated (from azimuth 180).
    pub incidence_deg: Option<f64>,
    /// The hemisphere below the sheet (polar angle beyond 90°) instead of that above.
    pub below: bool,
    /// Patches; those of the other hemisphere are left out, those across the horizon are cut at it.
    pub patches: &'a [Patch],
}

const CENTRE: Place = (214.0, 236.0);
const RADIUS: f64 = 160.0;

/// Lambert's azimuthal equal-area projection, the horizon at [`RADIUS`]: r = R √2 sin(θ/2).
fn project(polar_deg: f64, azimuth_deg: f64) -> Place {
    let r = RADIUS * 2.0_f64.sqrt() * sin(0.5 * polar_deg.min(90.0) * PI / 180.0);
    let (s, c) = sin_cos(azimuth_deg * PI / 180.0);
    (CENTRE.0 + r * c, CENTRE.1 - r * s)
}

impl HemisphereMap<'_> {
    /// Polar angle from the normal of the mapped side.
    fn side_angle(&self, polar_deg: f64) -> f64 {
        if self.below { 180.0 - polar_deg } else { polar_deg }
    }

    /// The map: patches, circles at 30° and 60°, azimuths, incidence, colour bar.
    pub fn plot(&self) -> Plot {
        let shown: Vec<&Patch> = self
            .patches
            .iter()
            .filter(|p| p.outline.len() > 2 && p.value.is_finite())
            .filter(|p| p.outline.iter().any(|o| self.side_angle(o.0) < 90.0 - 1e-9))
            .collect();
        let lo = shown.iter().map(|p| p.value).fold(f64::INFINITY, f64::min);
        let hi = shown.iter().map(|p| p.value).fold(f64::NEG_INFINITY, f64::max);
        let (lo, hi) = if lo <= hi { (lo, hi) } else { (0.0, 1.0) };
        let ticks = Ticks::enclosing(if lo > 0.0 && lo < 0.5 * hi { 0.0 } else { lo }, hi, 5);
        let share = |v: f64| (v - ticks.first()) / (ticks.last() - ticks.first());

        let svg = draw(500.0, 456.0, self.title, |c| {
            c.heading(&fitted(self.title, 13.5, 460.0), (20.0, 20.0));
            for p in &shown {
                let mut polygon: Vec<Place> =
                    p.outline.iter().map(|o| project(self.side_angle(o.0), o.1)).collect();
                c.fill(&polygon, ramp(share(p.value)), 1.0);
                // The outline in the same colour closes the seams between neighbours.
                polygon.push(polygon[0]);
                c.line(&polygon, ramp(share(p.value)), 0.5);
            }
            self.web(c);
            colour_bar(c, &ticks, &fitted(&ticks.axis_label(self.value.0, self.value.1), 11.0, 340.0));
        });
        let rows: Vec<AngularRow> = self.patches.iter().map(row).collect();
        Plot { svg, csv: table(&rows) }
    }

    /// Circles of equal polar angle, azimuths around, the place of the incident light.
    fn web(&self, c: &mut Canvas) {
        for polar in [30.0, 60.0] {
            let circle: Vec<Place> = (0..=120).map(|i| project(polar, 3.0 * f64::from(i))).collect();
            c.line(&circle, WHITE, 0.7);
            let (x, y) = project(polar, 67.5);
            c.rectangle((x - 11.0, y - 6.5), (x + 11.0, y + 6.5), WHITE, 0.8);
            c.text(&format!("{polar}°"), (x, y), 9.5, INK, Anchor::Middle);
        }
        c.ring(CENTRE, RADIUS, INK, 0.9);
        let beyond = |azimuth: f64| {
            let (s, k) = sin_cos(azimuth * PI / 180.0);
            (CENTRE.0 + (RADIUS + 8.0) * k, CENTRE.1 - (RADIUS + 8.0) * s)
        };
        for (azimuth, anchor) in [(0.0, Anchor::Start), (180.0, Anchor::End)] {
            c.text(&format!("{azimuth}°"), beyond(azimuth), 10.0, INK, anchor);
        }
        for (azimuth, down) in [(90.0, -3.0), (270.0, 5.0)] {
            let (x, y) = beyond(azimuth);
            c.text(&format!("{azimuth}°"), (x, y + down), 10.0, INK, Anchor::Middle);
        }
        let side = if self.below { "below the sheet (transmission)" } else { "above the sheet (reflection)" };
        let caption = format!("azimuth around, polar angle outwards, {side}");
        c.text(&caption, (20.0, 426.0), 10.0, INK, Anchor::Start);
        if let Some(angle) = self.incidence_deg {
            if !self.below {
                marker(c, project(angle, 180.0));
            }
            marker(c, (26.0, 443.0));
            let words = if self.below { "(from above)" } else { "comes from here" };
            c.text(&format!("incident light {angle}° {words}"), (38.0, 443.0), 10.0, INCIDENT, Anchor::Start);
        }
    }
}

/// Mark of the incident light: visible on any colour.
fn marker(c: &mut Canvas, at: Place) {
    c.disc(at, 5.4, WHITE);
    c.ring(at, 4.2, INCIDENT, 1.4);
    c.disc(at, 1.6, INCIDENT);
}

/// Upright bar of colours with its numbers, on the right.
fn colour_bar(c: &mut Canvas, ticks: &Ticks, label: &str) {
    let (left, right) = (418.0, 434.0);
    let (top, bottom) = (CENTRE.1 - RADIUS, CENTRE.1 + RADIUS);
    let steps = 128;
    for i in 0..steps {
        let y = |i: i32| bottom - (bottom - top) * f64::from(i) / f64::from(steps);
        let t = (f64::from(i) + 0.5) / f64::from(steps);
        // Each step reaches under the next, so that no seam shows.
        c.rectangle((left, (y(i + 1) - 0.6).max(top)), (right, y(i)), ramp(t), 1.0);
    }
    c.line(&[(left, top), (right, top), (right, bottom), (left, bottom), (left, top)], INK, 0.8);
    for (value, text) in ticks.values.iter().zip(&ticks.labels) {
        let t = (value - ticks.first()) / (ticks.last() - ticks.first());
        let y = bottom - t * (bottom - top);
        c.line(&[(right, y), (right + 4.0, y)], INK, 0.8);
        c.text(text, (right + 7.0, y), 10.0, INK, Anchor::Start);
    }
    c.text_up(label, (486.0, CENTRE.1), 11.0);
}

fn row(p: &Patch) -> AngularRow {
    AngularRow {
        patch: p.patch,
        polar_deg: p.polar_deg,
        azimuth_deg: p.azimuth_deg,
        solid_angle_sr: p.solid_angle_sr,
        value_per_sr: p.value,
        error_per_sr: p.error,
    }
}

/// Rings of 9° (the last across the horizon), each cut into nearly square patches.
#[cfg(test)]
pub(super) fn rings_for_tests(value: impl Fn(f64, f64) -> f64) -> Vec<Patch> {
    let mut patches = Vec::new();
    for ring in 0..11 {
        let (inner, outer) = (9.0 * f64::from(ring), 9.0 * f64::from(ring + 1));
        let polar = 0.5 * (inner + outer);
        let count = if ring == 0 { 4 } else { 4 * (10.0 * sin(polar * PI / 180.0)).round() as i32 };
        let wide = 360.0 / f64::from(count);
        let solid =
            (crate::math::cos(inner * PI / 180.0) - crate::math::cos(outer * PI / 180.0)) * wide * PI / 180.0;
        for i in 0..count {
            let from = f64::from(i) * wide;
            let along = |polar: f64, back: bool| {
                (0..=6).map(move |s| {
                    let t = f64::from(if back { 6 - s } else { s }) / 6.0;
                    (polar, from + t * wide)
                })
            };
            let v = value(polar, from + 0.5 * wide);
            patches.push(Patch {
                patch: patches.len() as u64,
                polar_deg: polar,
                azimuth_deg: from + 0.5 * wide,
                solid_angle_sr: solid,
                value: v,
                error: 0.02 * v + 0.002,
                outline: along(inner, false).chain(along(outer, true)).collect(),
            });
        }
    }
    patches
}

#[cfg(test)]
mod tests {
    use super::super::checks::{look, texts};
    use super::*;
    use crate::math::cos;

    #[test]
    fn the_map_names_its_parts_and_cuts_at_the_horizon() {
        let patches = rings_for_tests(|polar, azimuth| {
            let (t, a) = (polar * PI / 180.0, azimuth * PI / 180.0);
            let mirror = sin(t) * cos(a) * (0.5_f64).sqrt() + cos(t) * (0.5_f64).sqrt();
            0.8 * cos(t).max(0.0) / PI + 0.3 * crate::math::exp((mirror - 1.0) * 20.0)
        });
        let map = HemisphereMap {
            title: "Copper sphere, Gaussian roughness, 550 nm",
            value: ("reflected power per unit incident power", "sr⁻¹"),
            incidence_deg: Some(45.0),
            below: false,
            patches: &patches,
        };
        let plot = map.plot();
        look(&plot, "hemisphere.svg");
        let texts = texts(&plot.svg);
        for label in ["0°", "90°", "180°", "270°", "30°", "60°", "incident light 45° comes from here"]
        {
            assert!(texts.iter().any(|t| t == label), "{label} in {texts:?}");
        }
        assert!(texts.iter().any(|t| t.ends_with("(sr⁻¹)")));
        // The ring from 90° to 99° has no area above the sheet.
        let above = patches.iter().filter(|p| p.polar_deg < 90.0).count();
        assert_eq!(plot.svg.matches("<polygon").count(), above);
        let rows: Vec<AngularRow> = crate::report::csv::parse(&plot.csv).unwrap();
        assert_eq!(rows.len(), patches.len());
        let other = HemisphereMap { below: true, ..map }.plot();
        assert_eq!(other.svg.matches("<polygon").count(), patches.len() - above);
    }

    /// Rings of equal solid angle have equal area on the map.
    #[test]
    fn the_projection_keeps_areas() {
        let area = |from: f64, to: f64| {
            let r = |t: f64| project(t, 0.0).0 - CENTRE.0;
            PI * (r(to) * r(to) - r(from) * r(from))
        };
        let solid = |from: f64, to: f64| cos(from * PI / 180.0) - cos(to * PI / 180.0);
        let whole = area(0.0, 90.0);
        for (from, to) in [(0.0, 10.0), (40.0, 50.0), (80.0, 90.0)] {
            assert!((area(from, to) / whole - solid(from, to)).abs() < 1e-12);
        }
    }
}
