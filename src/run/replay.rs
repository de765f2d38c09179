//! One history again, with everything that happens to it: as text, CSV, and VTP for ParaView.
//!
//! A history draws from a stream of its own, so its path can be traced again alone, to the last bit.

use super::simulate;
use crate::lpm::ledger::Ledger;
use crate::lpm::{Path, Scorer};
use crate::math::DVec3;
use crate::scene::Scene;
use crate::scene::plan::Plan;
use crate::universe::{Face, Interface, MediumId};
use std::fmt::Write;

/// What happened.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// A straight flight of this length, µm; the power that stays on it.
    Flight {
        /// µm.
        distance: f64,
        /// Power absorbed.
        absorbed: f64,
    },
    /// Scattered inside the medium.
    Scattered,
    /// Met an interface.
    Interface {
        /// Unit normal against the ray.
        normal: DVec3,
        /// Medium beyond.
        beyond: MediumId,
        /// Surface law.
        surface: u16,
        /// Body.
        body: u32,
    },
    /// Absorbed at an opaque surface (of this medium) or by the backing: power.
    AbsorbedAt(Option<MediumId>, f64),
    /// Left the first sheet, or the scene.
    Leaves(Face),
    /// Left the top of a pile.
    LeavesPile,
    /// The universe had no answer.
    Lost,
}

/// An event of a history.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// What happened.
    pub what: What,
    /// Where, µm; a flight: its start.
    pub at: DVec3,
    /// Direction before the event.
    pub dir: DVec3,
    /// Medium.
    pub medium: MediumId,
    /// Power before the event.
    pub power: f64,
    /// Sheet of the pile.
    pub sheet: u32,
}

/// The path of one history.
#[derive(Clone, Debug, Default)]
pub struct Trail {
    /// Directions of next-event estimation.
    eyes: Vec<DVec3>,
    /// Wavelength lane that powers are told of.
    pub lane: usize,
    /// In the order they happened; branches one after the other.
    pub events: Vec<Event>,
    /// Ledger: absorbed, escaped, roulette, masked, lost, truncated.
    pub fates: [f64; 6],
    /// Events counted.
    pub count: u64,
}

const FATES: [&str; 6] = ["absorbed", "escaped", "roulette balance", "masked", "lost", "truncated"];

impl Trail {
    /// Forgets the history before.
    pub(super) fn begin(&mut self) {
        self.events.clear();
    }

    /// The balance of the history.
    pub(super) fn end<const N: usize>(&mut self, l: &Ledger<N>, count: u64) {
        let i = self.lane;
        self.fates = [l.absorbed, l.escaped, l.roulette, l.masked, l.lost, l.truncated].map(|w| w[i]);
        self.count = count;
    }

    fn push<P, const N: usize>(&mut self, path: &Path<P, N>, what: What) {
        let (at, dir) = (path.ray.origin, path.ray.dir);
        let power = path.power[self.lane];
        self.events.push(Event { what, at, dir, medium: path.medium, power, sheet: path.sheet });
    }
}

impl<const N: usize> Scorer<N> for Trail {
    fn step<P>(&mut self, path: &Path<P, N>, distance: f64, _mu_a: &[f64; N], absorbed: &[f64; N]) {
        let absorbed = absorbed[self.lane];
        self.push(path, What::Flight { distance, absorbed });
    }
    fn scattered<P>(&mut self, path: &Path<P, N>) -> bool {
        self.push(path, What::Scattered);
        path.single() && !self.eyes.is_empty()
    }
    fn eye(&self, view: usize) -> Option<DVec3> {
        self.eyes.get(view).copied()
    }
    fn interface<P>(&mut self, path: &Path<P, N>, at: &Interface) -> bool {
        let (normal, beyond, surface, body) = (at.normal, at.beyond, at.surface.0, at.body.0);
        self.push(path, What::Interface { normal, beyond, surface, body });
        path.single() && !self.eyes.is_empty()
    }
    fn absorbed_at<P>(&mut self, path: &Path<P, N>, beyond: Option<MediumId>, power: &[f64; N]) {
        let power = power[self.lane];
        self.push(path, What::AbsorbedAt(beyond, power));
    }
    fn leaves<P>(&mut self, path: &Path<P, N>, face: Face) {
        self.push(path, What::Leaves(face));
    }
    fn leaves_pile<P>(&mut self, path: &Path<P, N>) {
        self.push(path, What::LeavesPile);
    }
    fn lost<P>(&mut self, path: &Path<P, N>) {
        self.push(path, What::Lost);
    }
}

/// Traces the history `number` of the group that holds the wavelength (nm; by default the first).
///
/// # Errors
/// A wavelength that the scene does not have; constants that are missing.
pub fn replay(scene: &Scene, plan: &Plan, number: u64, wavelength: Option<f64>) -> Result<Trail, String> {
    let wanted = wavelength.unwrap_or(plan.groups[0][0]);
    let place = plan
        .groups
        .iter()
        .enumerate()
        .find_map(|(g, list)| Some((g, list.iter().position(|w| (w - wanted).abs() < 1e-9)?)));
    let Some((group, lane)) = place else {
        let list: Vec<String> = scene.wavelengths.iter().map(f64::to_string).collect();
        return Err(format!("no wavelength {wanted} nm; the scene has {}", list.join(", ")));
    };
    let group = simulate::group(scene, plan, group)?;
    Ok(trail(group.as_ref(), number, lane))
}

/// Traces the first histories, at most `count`, at the first wavelength.
///
/// # Errors
/// Constants that are missing.
pub fn first(scene: &Scene, plan: &Plan, count: u64) -> Result<Vec<Trail>, String> {
    let group = simulate::group(scene, plan, 0)?;
    Ok((0..count.min(scene.run.histories)).map(|number| trail(group.as_ref(), number, 0)).collect())
}

fn trail(group: &dyn simulate::Group, number: u64, lane: usize) -> Trail {
    // Looks of next-event estimation draw from the same stream.
    let eyes = group.layout().detectors.views.clone();
    let mut trail = Trail { lane, eyes, ..Trail::default() };
    group.replay(number, &mut trail);
    trail
}

fn place(v: DVec3) -> String {
    format!("({} {} {})", v.x, v.y, v.z)
}

impl Trail {
    /// A line per event, and the balance.
    pub fn text(&self, scene: &Scene, plan: &Plan) -> String {
        let name = |m: MediumId| plan.media.names.get(usize::from(m.0)).map_or("?", String::as_str);
        let mut out = String::new();
        for (i, e) in self.events.iter().enumerate() {
            let (at, dir, medium) = (place(e.at), place(e.dir), name(e.medium));
            let what = match &e.what {
                What::Flight { distance, absorbed } => {
                    format!("flies {distance} um along {dir} in '{medium}'; {absorbed} absorbed on the way")
                }
                What::Scattered => format!("scattered in '{medium}'"),
                What::Interface { normal, beyond, surface, body } => {
                    let id = scene.surfaces.get(usize::from(*surface)).map_or("?", |s| s.id.as_str());
                    let (n, beyond) = (place(*normal), name(*beyond));
                    format!("meets body {body}: '{medium}' to '{beyond}', surface '{id}', normal {n}")
                }
                What::AbsorbedAt(Some(m), power) => {
                    format!("{power} absorbed at the surface of '{}'", name(*m))
                }
                What::AbsorbedAt(None, power) => format!("{power} absorbed by the backing"),
                What::Leaves(Face::Top) => format!("leaves upwards along {dir}"),
                What::Leaves(Face::Bottom) => format!("leaves downwards along {dir}"),
                What::LeavesPile => format!("leaves the pile along {dir}"),
                What::Lost => format!("lost: no next interface along {dir} in '{medium}'"),
            };
            let _ = writeln!(out, "{:>6}  power {:<22} at {at} um: {what}", i + 1, e.power);
        }
        let fates = FATES.iter().zip(self.fates).filter(|f| f.1 != 0.0);
        let list: Vec<String> = fates.map(|(name, power)| format!("{name} {power}")).collect();
        let sum: f64 = self.fates.iter().sum();
        let _ = writeln!(out, "{} events; {}; sum {sum}", self.count, list.join(", "));
        out
    }

    /// A row per event. Lengths in µm; `distance_um` and `absorbed` of flights and absorptions only.
    pub fn csv(&self, plan: &Plan) -> String {
        let mut out = String::from(
            "event,what,x_um,y_um,z_um,ux,uy,uz,medium,power,distance_um,absorbed,beyond,sheet\n",
        );
        let name = |m: MediumId| plan.media.names.get(usize::from(m.0)).map_or("", String::as_str);
        for (i, e) in self.events.iter().enumerate() {
            let (what, distance, absorbed, beyond) = match &e.what {
                What::Flight { distance, absorbed } => {
                    ("flight", distance.to_string(), absorbed.to_string(), "")
                }
                What::Scattered => ("scattered", String::new(), String::new(), ""),
                What::Interface { beyond, .. } => ("interface", String::new(), String::new(), name(*beyond)),
                What::AbsorbedAt(m, power) => {
                    ("absorbed", String::new(), power.to_string(), m.map_or("backing", name))
                }
                What::Leaves(Face::Top) => ("leaves_top", String::new(), String::new(), ""),
                What::Leaves(Face::Bottom) => ("leaves_bottom", String::new(), String::new(), ""),
                What::LeavesPile => ("leaves_pile", String::new(), String::new(), ""),
                What::Lost => ("lost", String::new(), String::new(), ""),
            };
            let (p, d, m) = (e.at, e.dir, name(e.medium));
            let quoted = |s: &str| if s.contains(',') { format!("\"{s}\"") } else { s.to_owned() };
            let _ = writeln!(
                out,
                "{},{what},{},{},{},{},{},{},{},{},{distance},{absorbed},{},{}",
                i + 1,
                p.x,
                p.y,
                p.z,
                d.x,
                d.y,
                d.z,
                quoted(m),
                e.power,
                quoted(beyond),
                e.sheet
            );
        }
        out
    }

    /// VTK PolyData: a line per flight with its event number, medium, power and absorbed power. A flight
    /// to infinity is drawn as long as the rest of the path is wide.
    pub fn vtp(&self) -> String {
        let flights: Vec<(usize, &Event, f64, f64)> = self
            .events
            .iter()
            .enumerate()
            .filter_map(|(i, e)| match e.what {
                What::Flight { distance, absorbed } => Some((i + 1, e, distance, absorbed)),
                _ => None,
            })
            .collect();
        let origin = flights.first().map_or(DVec3::ZERO, |f| f.1.at);
        let wide = flights.iter().map(|f| (f.1.at - origin).length()).fold(10.0, f64::max);
        let (mut points, mut ends) = (String::new(), String::new());
        let [mut event, mut medium, mut power, mut lost] = [const { String::new() }; 4];
        for (k, (number, e, distance, absorbed)) in flights.iter().enumerate() {
            let end = e.at + e.dir * if distance.is_finite() { *distance } else { wide };
            let _ = writeln!(points, "{} {} {} {} {} {}", e.at.x, e.at.y, e.at.z, end.x, end.y, end.z);
            let _ = write!(ends, "{} {} ", 2 * k, 2 * k + 1);
            let _ = write!(event, "{number} ");
            let _ = write!(medium, "{} ", e.medium.0);
            let _ = write!(power, "{} ", e.power);
            let _ = write!(lost, "{absorbed} ");
        }
        let n = flights.len();
        let offsets: String = (1..=n).map(|k| format!("{} ", 2 * k)).collect();
        let array = |kind: &str, name: &str, more: &str, text: &str| {
            format!(
                "<DataArray type=\"{kind}\" Name=\"{name}\"{more} format=\"ascii\">\n{text}\n</DataArray>\n"
            )
        };
        let mut out = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\">\n<PolyData>\n",
        );
        let _ = writeln!(
            out,
            "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"{n}\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">",
            2 * n
        );
        let three = " NumberOfComponents=\"3\"";
        let _ =
            write!(out, "<Points>\n{}</Points>\n", array("Float64", "points_um", three, points.trim_end()));
        let lines = array("Int64", "connectivity", "", ends.trim_end())
            + &array("Int64", "offsets", "", offsets.trim_end());
        let _ = write!(out, "<Lines>\n{lines}</Lines>\n<CellData>\n");
        out += &array("Int64", "event", "", event.trim_end());
        out += &array("Int64", "medium", "", medium.trim_end());
        out += &array("Float64", "power", "", power.trim_end());
        out += &array("Float64", "absorbed", "", lost.trim_end());
        out += "</CellData>\n</Piece>\n</PolyData>\n</VTKFile>\n";
        out
    }
}
