//! Paths of histories: lines coloured by where they end.

use super::Eye;
use crate::math::DVec3;
use crate::run::replay::{Trail, What};
use std::fmt::Write;

/// Paths drawn of each kind.
pub const EACH: usize = 4;
/// Flights drawn of one path.
const FLIGHTS: usize = 250;

/// Where a path ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Leaves upwards.
    Reflected,
    /// Leaves downwards.
    Transmitted,
    /// Ends inside.
    Ended,
}

impl Fate {
    pub fn colour(self) -> &'static str {
        match self {
            Fate::Reflected => "#d55e00",
            Fate::Transmitted => "#0072b2",
            Fate::Ended => "#262626",
        }
    }

    pub fn words(self) -> &'static str {
        match self {
            Fate::Reflected => "leaves upwards",
            Fate::Transmitted => "leaves downwards",
            Fate::Ended => "ends inside (absorbed, or weak)",
        }
    }
}

/// A path from its entry to its end.
#[derive(Clone, Debug)]
struct Line {
    fate: Fate,
    points: Vec<DVec3>,
    /// Direction of the light that comes in.
    from: DVec3,
    /// Direction in which it leaves.
    to: DVec3,
}

/// Paths to be drawn.
#[derive(Clone, Debug)]
pub struct Trails {
    lines: Vec<Line>,
}

impl Trails {
    /// The paths of `traced`, the first few of each kind; of a history that branches its first branch.
    /// Those that enter further than `side` from the first are left out.
    pub fn of(traced: &[Trail], planes: [f64; 2], side: f64) -> Self {
        let mut lines: Vec<Line> = Vec::new();
        for line in traced.iter().filter_map(|t| line(t, planes)) {
            let few = lines.iter().filter(|l| l.fate == line.fate).count() < EACH;
            let near = lines.first().is_none_or(|f| {
                let d = f.points[0] - line.points[0];
                d.x.abs().max(d.y.abs()) < 0.8 * side
            });
            if few && near {
                lines.push(line);
            }
        }
        Trails { lines }
    }

    /// Middle of the entries.
    pub fn middle(&self) -> [f64; 2] {
        let n = self.lines.len().max(1) as f64;
        let sum: DVec3 = self.lines.iter().map(|l| l.points[0]).sum();
        [sum.x / n, sum.y / n]
    }

    /// Length of the arrows outside the sheet, µm.
    pub fn reach(&self, planes: [f64; 2], side: f64) -> f64 {
        (0.22 * side).max(0.15 * (planes[1] - planes[0]))
    }

    /// Draws them; how many of each kind.
    pub fn draw(&self, eye: &Eye, window: [[f64; 2]; 2], reach: f64, out: &mut String) -> [usize; 3] {
        let mut counts = [0; 3];
        for line in &self.lines {
            counts[line.fate as usize] += 1;
            let mut points = vec![line.points[0] - line.from * (reach / line.from.z.abs().max(0.5))];
            let kept = line.points.iter().take_while(|p| inside(**p, window));
            points.extend(kept);
            let whole = points.len() > line.points.len();
            if whole && line.fate != Fate::Ended {
                let last = points[points.len() - 1];
                points.push(last + line.to * (0.8 * reach / line.to.z.abs().max(0.8)));
            }
            let places: Vec<(f64, f64)> = points.iter().map(|p| eye.place(*p)).collect();
            let mut d = String::new();
            for (i, (x, y)) in places.iter().enumerate() {
                let _ = write!(d, "{}{x:.1} {y:.1}", if i == 0 { "M" } else { "L" });
            }
            let mut more = String::new();
            let (x, y) = places[places.len() - 1];
            if whole && line.fate == Fate::Ended {
                let _ = write!(
                    more,
                    "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{}\" stroke=\"#fff\"/>",
                    line.fate.colour()
                );
            } else if whole {
                more = arrow(places[places.len() - 2], (x, y), line.fate.colour());
            }
            let _ = writeln!(
                out,
                "<g class=\"v-path\" fill=\"none\"><path d=\"{d}\" stroke=\"#fff\" stroke-width=\"2.8\" stroke-opacity=\".8\"/>\
                 <path d=\"{d}\" stroke=\"{}\" stroke-width=\"1.3\"/>{}{more}</g>",
                line.fate.colour(),
                arrow(places[0], between(places[0], places[1], 0.6), line.fate.colour()),
            );
        }
        counts
    }
}

fn between(a: (f64, f64), b: (f64, f64), t: f64) -> (f64, f64) {
    (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1))
}

fn arrow(from: (f64, f64), to: (f64, f64), colour: &str) -> String {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let long = (dx * dx + dy * dy).sqrt().max(1e-9);
    let (dx, dy) = (dx / long, dy / long);
    let side = |s: f64| (to.0 - 8.0 * dx - s * dy, to.1 - 8.0 * dy + s * dx);
    let ((ax, ay), (bx, by)) = (side(3.2), side(-3.2));
    format!("<path d=\"M{:.1} {:.1}L{ax:.1} {ay:.1} {bx:.1} {by:.1}z\" fill=\"{colour}\"/>", to.0, to.1)
}

/// Within the window and half of it on each side.
fn inside(p: DVec3, window: [[f64; 2]; 2]) -> bool {
    let [low, high] = window;
    let more = 0.06 * (high[0] - low[0]);
    p.x > low[0] - more && p.x < high[0] + more && p.y > low[1] - more && p.y < high[1] + more
}

/// The first branch of a history. `None` if nothing was met.
fn line(trail: &Trail, planes: [f64; 2]) -> Option<Line> {
    let (mut points, mut fate) = (Vec::<DVec3>::new(), Fate::Ended);
    let [bottom, top] = planes;
    let (mut from, mut to) = (DVec3::ZERO, DVec3::ZERO);
    for e in &trail.events {
        match e.what {
            What::Flight { distance, .. } => {
                if points.is_empty() {
                    from = e.dir;
                    // Light starts somewhere above: seen from where it reaches the sheet's plane.
                    let above = if e.dir.z < 0.0 { ((e.at.z - top) / -e.dir.z).max(0.0) } else { 0.0 };
                    points.push(e.at + e.dir * above.min(distance));
                }
                to = e.dir;
                if distance.is_finite() {
                    let end = e.at + e.dir * distance;
                    if points.len() < FLIGHTS && end.z > bottom - 1e3 && end.z < top + 1e3 {
                        points.push(end);
                    }
                }
            }
            What::Leaves(_) | What::LeavesPile => {
                fate = if e.dir.z > 0.0 { Fate::Reflected } else { Fate::Transmitted };
                to = e.dir;
                break;
            }
            What::AbsorbedAt(..) | What::Lost => break,
            What::Scattered | What::Interface { .. } => {}
        }
    }
    // A history that was cut leaves no arrow.
    if points.len() >= FLIGHTS {
        fate = Fate::Ended;
    }
    (!points.is_empty()).then_some(Line { fate, points, from, to })
}
