//! Polar diagram of light in the plane of incidence, as from a goniometer.

use super::axes::{Ticks, superscript};
use super::canvas::{Anchor, Canvas, Place, draw, fitted, width};
use super::colours::{FAINT_INK, GRID, INCIDENT, INK, WHITE, series};
use super::{Patch, Plot};
use crate::math::{PI, cos, log10, pow, sin, sin_cos};
use crate::report::csv::table;
use serde::{Deserialize, Serialize};

/// One direction in the plane of incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutPoint {
    /// Angle from the upward normal in degrees, −180 to 180: positive towards azimuth 0 (the side of
    /// the mirror direction), beyond ±90 in transmission.
    pub angle_deg: f64,
    /// Value.
    pub value: f64,
    /// Standard error.
    pub error: f64,
}

/// One curve of the diagram.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolarCurve {
    /// Name in the legend.
    pub label: String,
    /// Directions, in any order.
    pub points: Vec<CutPoint>,
    /// A line alone, as for a formula; otherwise dots and error bars too.
    pub smooth: bool,
}

/// A polar diagram.
#[derive(Clone, Debug, PartialEq)]
pub struct PolarPlot<'a> {
    /// Title.
    pub title: &'a str,
    /// Quantity and unit along the radius ("1": no unit).
    pub value: (&'a str, &'a str),
    /// Polar angle of incidence in degrees, if the light is collimated; it comes from azimuth 180.
    pub incidence_deg: Option<f64>,
    /// Number of decades of a logarithmic radius; None: linear from 0.
    pub decades: Option<u32>,
    /// Curves.
    pub curves: &'a [PolarCurve],
}

/// A row of the CSV.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CutRow {
    /// Curve.
    pub series: String,
    /// Angle from the upward normal in degrees, see [`CutPoint`].
    pub angle_deg: f64,
    /// Value.
    pub value: f64,
    /// Standard error.
    pub error: f64,
}

/// The cut through the plane of incidence (azimuth 0 and 180): patches whose centre is within half
/// their diagonal of the plane, √(Ω/2). Patches at the same angle are averaged (their errors taken
/// as independent). Sorted by angle.
pub fn in_plane(patches: &[Patch]) -> Vec<CutPoint> {
    let mut near: Vec<CutPoint> = patches
        .iter()
        .filter_map(|p| {
            let (theta, phi) = (p.polar_deg * PI / 180.0, p.azimuth_deg * PI / 180.0);
            let inside = (sin(theta) * sin(phi)).abs() <= (0.5 * p.solid_angle_sr).sqrt();
            let angle_deg = if cos(phi) >= 0.0 { p.polar_deg } else { -p.polar_deg };
            inside.then_some(CutPoint { angle_deg, value: p.value, error: p.error })
        })
        .collect();
    near.sort_by(|a, b| a.angle_deg.total_cmp(&b.angle_deg));
    near.chunk_by(|a, b| (a.angle_deg - b.angle_deg).abs() < 1e-6)
        .map(|same| {
            let n = same.len() as f64;
            let variance: f64 = same.iter().map(|p| p.error * p.error).sum();
            let value = same.iter().map(|p| p.value).sum::<f64>() / n;
            CutPoint { angle_deg: same[0].angle_deg, value, error: variance.sqrt() / n }
        })
        .collect()
}

/// Where things stand on the canvas.
struct Layout {
    centre: Place,
    radius: f64,
    full: bool,
    /// Value at the outermost ring.
    top: f64,
    decades: Option<u32>,
    /// Rings: value and text.
    rings: Vec<(f64, String)>,
    value_label: String,
}

const WIDTH: f64 = 500.0;
const RADIUS: f64 = 185.0;

impl Layout {
    fn of(plot: &PolarPlot) -> Layout {
        let points = || plot.curves.iter().flat_map(|c| &c.points).filter(|p| p.value.is_finite());
        let largest = points().map(|p| p.value + error(p)).fold(0.0, f64::max);
        let largest = if largest > 0.0 { largest } else { 1.0 };
        let (rings, top, ticks) = match plot.decades {
            None => {
                let ticks = Ticks::enclosing(0.0, largest, 4);
                let rings = ticks.values.iter().copied().zip(ticks.labels.iter().cloned()).skip(1).collect();
                (rings, ticks.last(), ticks)
            }
            Some(n) => {
                let power = (log10(largest) - 1e-9).ceil() as i32;
                let first = power - n as i32 + 1;
                let rings = (first..=power)
                    .map(|e| (pow(10.0, f64::from(e)), format!("10{}", superscript(e))))
                    .collect();
                let plain = Ticks { values: vec![], labels: vec![], exponent: 0 };
                (rings, pow(10.0, f64::from(power)), plain)
            }
        };
        // An opaque body sends nothing below: half a diagram is enough.
        let full = points().any(|p| p.angle_deg.abs() > 90.0 && p.value != 0.0);
        Layout {
            centre: (0.5 * WIDTH, 46.0 + 36.0 + RADIUS),
            radius: RADIUS,
            full,
            top,
            decades: plot.decades,
            rings,
            value_label: ticks.axis_label(plot.value.0, plot.value.1),
        }
    }
    /// Distance from the centre as a share of the radius.
    fn reach(&self, value: f64) -> f64 {
        match self.decades {
            None => (value / self.top).max(0.0),
            Some(_) if value <= 0.0 => 0.0,
            Some(n) => (1.0 + log10(value / self.top) / f64::from(n)).max(0.0),
        }
    }
    /// The place at `distance` points from the centre in direction `angle_deg`.
    fn at(&self, angle_deg: f64, distance: f64) -> Place {
        let (s, c) = sin_cos(angle_deg * PI / 180.0);
        (self.centre.0 + distance * s, self.centre.1 - distance * c)
    }
    fn place(&self, angle_deg: f64, value: f64) -> Place {
        self.at(angle_deg, self.reach(value) * self.radius)
    }
    fn arc(&self, distance: f64) -> Vec<Place> {
        let end = if self.full { 180 } else { 90 };
        (-end..=end).map(|a| self.at(f64::from(a), distance)).collect()
    }
    /// Lowest point of the diagram with its labels.
    fn below(&self) -> f64 {
        self.centre.1 + if self.full { self.radius + 20.0 } else { 18.0 }
    }
}

impl PolarPlot<'_> {
    /// The diagram: rings of equal value with their numbers, spokes each 30°, the incident light as
    /// an arrow, the mirror direction dashed, curves with ± one standard error, legend.
    pub fn plot(&self) -> Plot {
        let layout = Layout::of(self);
        let legend_top = layout.below() + 50.0;
        let named = self.curves.iter().filter(|c| !c.label.is_empty()).count();
        let height = legend_top + 17.0 * named as f64;
        let svg = draw(WIDTH, height, self.title, |c| {
            c.heading(&fitted(self.title, 13.5, WIDTH - 40.0), (20.0, 20.0));
            self.web(c, &layout);
            for (i, curve) in self.curves.iter().enumerate() {
                draw_curve(c, &layout, curve, i);
            }
            self.numbers(c, &layout);
            if let Some(angle) = self.incidence_deg {
                arrow(c, &layout, angle);
            }
            let mut y = legend_top;
            for (i, curve) in self.curves.iter().enumerate().filter(|(_, curve)| !curve.label.is_empty()) {
                let left = layout.centre.0 - layout.radius;
                c.line(&[(left, y), (left + 22.0, y)], series(i), 1.5);
                if !curve.smooth {
                    c.disc((left + 11.0, y), 2.2, series(i));
                }
                c.text(&fitted(&curve.label, 10.0, 330.0), (left + 30.0, y), 10.0, INK, Anchor::Start);
                y += 17.0;
            }
        });
        let row = |curve: &PolarCurve, p: &CutPoint| CutRow {
            series: curve.label.clone(),
            angle_deg: p.angle_deg,
            value: p.value,
            error: p.error,
        };
        let rows: Vec<_> = self.curves.iter().flat_map(|c| c.points.iter().map(|p| row(c, p))).collect();
        Plot { svg, csv: table(&rows) }
    }

    /// Rings, spokes with their angles, the surface, the mirror direction.
    fn web(&self, c: &mut Canvas, layout: &Layout) {
        for (value, _) in &layout.rings {
            c.line(&layout.arc(layout.reach(*value) * layout.radius), GRID, 0.7);
        }
        let end = if layout.full { 180 } else { 90 };
        for angle in (-end..=end).step_by(30).filter(|a| *a != -180) {
            let angle = f64::from(angle);
            c.line(&[layout.centre, layout.at(angle, layout.radius)], GRID, 0.7);
            let taken = self.incidence_deg.is_some_and(|i| (angle + i).abs() < 9.0);
            if !taken {
                // Angles are told from the nearer normal.
                let shown = if angle.abs() > 90.0 { 180.0 - angle.abs() } else { angle.abs() };
                let anchor = match angle {
                    a if a == 0.0 || a == 180.0 => Anchor::Middle,
                    a if a > 0.0 => Anchor::Start,
                    _ => Anchor::End,
                };
                c.text(&format!("{shown}°"), layout.at(angle, layout.radius + 8.0), 10.0, INK, anchor);
            }
        }
        c.line(&layout.arc(layout.radius), INK, 0.8);
        c.line(&[layout.at(-90.0, layout.radius), layout.at(90.0, layout.radius)], INK, 0.8);
        if let Some(angle) = self.incidence_deg.filter(|a| *a > 0.0) {
            c.dashed(layout.centre, layout.at(angle, layout.radius), FAINT_INK, 0.7);
        }
    }

    /// Values of the rings and what they are; azimuths of the two sides.
    fn numbers(&self, c: &mut Canvas, layout: &Layout) {
        let mut free = layout.centre.0;
        for (value, text) in &layout.rings {
            let half = 0.5 * width(text, 9.5);
            let ring = layout.centre.0 + layout.reach(*value) * layout.radius;
            // In the full diagram the last number stands inside the outer circle.
            let last = ring > layout.centre.0 + layout.radius - 1.0;
            let x = if layout.full && last { ring - half - 3.0 } else { ring };
            // A ring without room for its number goes without.
            if x - half > free {
                let y = layout.centre.1 + 11.0;
                if layout.full {
                    c.rectangle((x - half, y - 6.0), (x + half, y + 6.0), WHITE, 0.75);
                }
                c.text(text, (x, y), 9.5, INK, Anchor::Middle);
                free = x + half + 3.0;
            }
        }
        let (left, right) = (layout.centre.0 - layout.radius, layout.centre.0 + layout.radius);
        let y = layout.below() + 10.0;
        c.text("azimuth 180°", (left, y), 10.0, FAINT_INK, Anchor::Start);
        c.text("azimuth 0°", (right, y), 10.0, FAINT_INK, Anchor::End);
        let label = fitted(&layout.value_label, 11.0, WIDTH - 30.0);
        c.text(&label, (layout.centre.0, y + 17.0), 11.0, INK, Anchor::Middle);
    }
}

/// Standard error as drawn: 0 where it is unknown.
fn error(p: &CutPoint) -> f64 {
    if p.error.is_finite() { p.error.abs() } else { 0.0 }
}

/// The arrow of the incident light, outside the rings, and its name beyond its tail.
fn arrow(c: &mut Canvas, layout: &Layout, incidence_deg: f64) {
    let angle = -incidence_deg;
    let (tail, tip) = (layout.radius + 34.0, layout.radius + 3.0);
    c.line(&[layout.at(angle, tail), layout.at(angle, tip + 6.0)], INCIDENT, 1.8);
    let (s, cosine) = sin_cos(angle * PI / 180.0);
    let side = |d: f64| {
        let base = layout.at(angle, tip + 9.0);
        (base.0 + d * cosine, base.1 + d * s)
    };
    c.fill(&[layout.at(angle, tip), side(4.0), side(-4.0)], INCIDENT, 1.0);
    let text = format!("incident {incidence_deg}°");
    if incidence_deg < 25.0 {
        let (x, y) = layout.at(angle, tail);
        c.text(&text, (x + 7.0, y + 1.0), 10.0, INCIDENT, Anchor::Start);
    } else {
        // Above the tail, where the spokes have no labels; never beyond the edge.
        let (x, y) = layout.at(angle, tail);
        let start = (x - 0.5 * width(&text, 10.0)).max(6.0);
        c.text(&text, (start, y - 9.0), 10.0, INCIDENT, Anchor::Start);
    }
}

/// Curve by hemisphere, with its band.
fn draw_curve(c: &mut Canvas, layout: &Layout, curve: &PolarCurve, i: usize) {
    let mut sides = [Vec::new(), Vec::new()];
    for p in curve.points.iter().filter(|p| p.value.is_finite() && p.angle_deg.is_finite()) {
        let below = p.angle_deg.abs() > 90.0;
        // Below, from 90 on over the lower normal to 270.
        let angle_deg = if below && p.angle_deg < 0.0 { p.angle_deg + 360.0 } else { p.angle_deg };
        sides[usize::from(below)].push(CutPoint { angle_deg, ..*p });
    }
    for side in &mut sides {
        side.sort_by(|a, b| a.angle_deg.total_cmp(&b.angle_deg));
        let outer = side.iter().map(|p| layout.place(p.angle_deg, p.value + error(p)));
        let inner = side.iter().rev().map(|p| layout.place(p.angle_deg, p.value - error(p)));
        let band: Vec<Place> = outer.chain(inner).collect();
        if side.len() > 1 {
            c.fill(&band, series(i), 0.2);
        }
        let line: Vec<Place> = side.iter().map(|p| layout.place(p.angle_deg, p.value)).collect();
        c.line(&line, series(i), 1.5);
        for (p, at) in side.iter().zip(&line).filter(|_| !curve.smooth) {
            let bar = [p.value - error(p), p.value + error(p)].map(|v| layout.place(p.angle_deg, v));
            c.line(&bar, series(i), 1.0);
            c.disc(*at, 2.2, series(i));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::{look, texts};
    use super::super::hemisphere::rings_for_tests;
    use super::*;

    fn lobe(angle: f64) -> f64 {
        let d = (angle - 45.0) / 12.0;
        0.8 * cos(angle * PI / 180.0).max(0.0) / PI + 0.15 * crate::math::exp(-d * d)
    }

    fn smooth(label: &str, f: impl Fn(f64) -> f64, end: i32) -> PolarCurve {
        let points =
            (-end..=end).map(f64::from).map(|a| CutPoint { angle_deg: a, value: f(a), error: 0.0 }).collect();
        PolarCurve { label: label.into(), points, smooth: true }
    }

    #[test]
    fn reflection_at_45_degrees() {
        let patches = rings_for_tests(|polar, azimuth| {
            let signed = if azimuth > 90.0 && azimuth < 270.0 { -polar } else { polar };
            if polar < 90.0 { lobe(signed) } else { 0.0 }
        });
        let cut = in_plane(&patches);
        assert!(cut.windows(2).all(|w| w[0].angle_deg < w[1].angle_deg));
        let curves = [
            PolarCurve {
                label: "simulated, patches ± standard error".into(),
                points: cut.clone(),
                smooth: false,
            },
            smooth("Lambertian, 0.8 cos θ/π", |a| 0.8 * cos(a * PI / 180.0) / PI, 90),
        ];
        let plot = PolarPlot {
            title: "Copper sphere, Gaussian roughness, 550 nm",
            value: ("reflected power per unit incident power", "sr⁻¹"),
            incidence_deg: Some(45.0),
            decades: None,
            curves: &curves,
        }
        .plot();
        look(&plot, "polar45.svg");
        let texts = texts(&plot.svg);
        for label in ["incident 45°", "azimuth 0°", "azimuth 180°", "60°", "0.1", "Lambertian, 0.8 cos θ/π"]
        {
            assert!(texts.iter().any(|t| t == label), "{label} in {texts:?}");
        }
        let rows: Vec<CutRow> = crate::report::csv::parse(&plot.csv).unwrap();
        assert_eq!(rows.len(), cut.len() + 181);
        assert_eq!(rows[0].value, cut[0].value);
    }

    #[test]
    fn reflection_and_transmission_at_normal_incidence() {
        let f =
            |a: f64| if a.abs() <= 90.0 { 0.2 * cos(a * PI / 180.0) } else { -0.06 * cos(a * PI / 180.0) };
        let plot = PolarPlot {
            title: "Handsheet, 60 g/m²",
            value: ("power per unit incident power", "sr⁻¹"),
            incidence_deg: Some(0.0),
            decades: None,
            curves: &[smooth("", f, 180)],
        }
        .plot();
        look(&plot, "polar_full.svg");
        assert!(texts(&plot.svg).iter().any(|t| t == "incident 0°"));
        let log = PolarPlot {
            title: "Gloss peak, logarithmic radius",
            value: ("BRDF", "sr⁻¹"),
            incidence_deg: Some(75.0),
            decades: Some(4),
            curves: &[smooth(
                "coated board",
                |a| {
                    let d = (a - 75.0) / 3.0;
                    0.25 + 40.0 * crate::math::exp(-d * d)
                },
                90,
            )],
        }
        .plot();
        look(&log, "polar_log.svg");
        assert!(texts(&log.svg).iter().any(|t| t == "10²"));
    }

    #[test]
    fn the_cut_averages_patches_on_both_sides_of_the_plane() {
        let patch = |azimuth_deg, value| Patch {
            patch: 0,
            polar_deg: 30.0,
            azimuth_deg,
            solid_angle_sr: 0.06,
            value,
            error: 0.1,
            outline: vec![],
        };
        let cut = in_plane(&[patch(10.0, 1.0), patch(350.0, 3.0), patch(90.0, 9.0), patch(190.0, 5.0)]);
        assert_eq!(cut.len(), 2);
        assert_eq!((cut[0].angle_deg, cut[0].value), (-30.0, 5.0));
        assert_eq!((cut[1].angle_deg, cut[1].value), (30.0, 2.0));
        assert!((cut[1].error - 0.1 / 2.0_f64.sqrt()).abs() < 1e-15);
    }
}
