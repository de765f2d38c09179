//! Sizes, directions and amounts of explicit bodies, as the statistics that a scene takes.

use crate::math::{DVec3, PI};
use crate::scene::written::escaped;
use crate::universe::MediumId;
use crate::universe::shape::{Placed, Shape};
use crate::universe::synthetic::Part;
use std::fmt::Write;

/// Classes of a histogram.
const CLASSES: usize = 32;

/// A body: its surface, and that of its hollow.
pub type BodyParts = (Part, Option<Part>);

/// Where bodies were counted.
#[derive(Clone, Copy, Debug)]
pub enum Window {
    /// Periodic cells of this area together, µm².
    Cells(f64),
    /// Discs about the z axis, of this radius (µm), of so many realisations.
    Discs(f64, u32),
}

/// Bodies of one medium as statistics.
#[derive(Clone, Debug)]
pub struct Population {
    /// Solid medium.
    pub medium: MediumId,
    /// Bodies counted.
    pub count: usize,
    /// `fibres` or `flakes`: of `<distribution kind=…>`.
    pub kind: &'static str,
    /// Full sizes, µm, by the name of the law's element.
    pub sizes: Vec<(&'static str, Vec<f64>)>,
    /// Cylinders: length over volume, 1/µm²; others: number over volume, 1/µm³.
    pub density: f64,
    /// All cylinders end.
    pub finite: bool,
    /// Preferred azimuth (rad) and order |⟨e^2iφ⟩|.
    pub order: (f64, f64),
    /// Root mean square tilt, rad.
    pub tilt: f64,
    /// Root mean square roll of the section about the axis, rad.
    pub roll: f64,
}

/// Populations of `bodies`, one for each solid medium and kind of shape, between two planes.
pub fn populations(bodies: &[BodyParts], window: Window, planes: [f64; 2]) -> Vec<Population> {
    let is_fibre = |p: &Part| matches!(p.shape.shape, Shape::Cylinder(_));
    let is_flake = |p: &Part| matches!(p.shape.shape, Shape::Ellipsoid(_));
    let mut media: Vec<MediumId> = bodies.iter().map(|b| b.0.medium).collect();
    media.sort();
    media.dedup();
    let mut found = Vec::new();
    for medium in media {
        let of = |test: &dyn Fn(&Part) -> bool| -> Vec<&BodyParts> {
            bodies.iter().filter(|b| b.0.medium == medium && test(&b.0)).collect()
        };
        let (fibres, flakes) = (of(&is_fibre), of(&is_flake));
        if !fibres.is_empty() {
            found.push(population(&fibres, medium, "fibres", window, planes));
        }
        if !flakes.is_empty() {
            found.push(population(&flakes, medium, "flakes", window, planes));
        }
    }
    found
}

fn population(
    bodies: &[&BodyParts],
    medium: MediumId,
    kind: &'static str,
    window: Window,
    planes: [f64; 2],
) -> Population {
    let fibres = kind == "fibres";
    let sizes = if fibres { sections(bodies) } else { axes(bodies) };
    let (mut amount, mut double, mut tilt2, mut roll2, mut weights) = (0.0, [0.0; 2], 0.0, 0.0, 0.0);
    for (body, _) in bodies {
        let shape = &body.shape;
        let weight =
            if fibres { length_within(shape, window, planes) } else { stands(shape, window, planes) };
        amount += weight;
        let axis = if fibres { shape.frame.z } else { shape.frame.x };
        let level = axis.x * axis.x + axis.y * axis.y;
        if weight > 0.0 && level > 0.0 {
            weights += weight;
            double[0] += weight * (axis.x * axis.x - axis.y * axis.y) / level;
            double[1] += weight * 2.0 * axis.x * axis.y / level;
            let tilt = crate::math::asin(axis.z.clamp(-1.0, 1.0));
            let roll = roll_of(axis, if fibres { shape.frame.x } else { shape.frame.y });
            tilt2 += weight * tilt * tilt;
            roll2 += weight * roll * roll;
        }
    }
    let area = match window {
        Window::Cells(area) => area,
        Window::Discs(r, n) => PI * r * r * f64::from(n),
    };
    let weights = f64::max(weights, f64::MIN_POSITIVE);
    Population {
        medium,
        count: bodies.len(),
        kind,
        sizes,
        density: amount / (area * (planes[1] - planes[0])),
        finite: bodies
            .iter()
            .all(|b| b.0.shape.shape.extents().iter().all(|e| e.is_finite()) && ends(&b.0.shape)),
        order: (
            0.5 * crate::math::atan2(double[1], double[0]),
            (double[0] * double[0] + double[1] * double[1]).sqrt() / weights,
        ),
        tilt: (tilt2 / weights).sqrt(),
        roll: (roll2 / weights).sqrt(),
    }
}

fn ends(p: &Placed) -> bool {
    !matches!(p.shape, Shape::Cylinder(c) if c.half_length.is_none())
}

/// Angle by which `across` is turned about `axis` out of the plane of the sheet, up to half a turn.
fn roll_of(axis: DVec3, across: DVec3) -> f64 {
    let side = DVec3::Z.cross(axis);
    if side.length_squared() < 1e-24 {
        return 0.0;
    }
    let side = side.normalize();
    let (c, s) = (across.dot(side), across.dot(axis.cross(side)));
    crate::math::atan(if c == 0.0 { f64::INFINITY } else { s / c })
}

/// Width, flatness, wall and length.
fn sections(bodies: &[&BodyParts]) -> Vec<(&'static str, Vec<f64>)> {
    let (mut width, mut flatness, mut wall, mut length) = (vec![], vec![], vec![], vec![]);
    for (body, hollow) in bodies {
        let Shape::Cylinder(c) = body.shape.shape else { continue };
        width.push(2.0 * c.a);
        flatness.push(c.b / c.a);
        length.extend(c.half_length.map(|h| 2.0 * h));
        wall.push(match hollow.map(|h| h.shape.shape) {
            Some(Shape::Cylinder(h)) => c.b - h.b,
            _ => c.b,
        });
    }
    vec![("width", width), ("flatness", flatness), ("wall", wall), ("length", length)]
}

fn axes(bodies: &[&BodyParts]) -> Vec<(&'static str, Vec<f64>)> {
    let mut full = [vec![], vec![], vec![]];
    for (body, _) in bodies {
        if let Shape::Ellipsoid(e) = body.shape.shape {
            full.iter_mut().zip([e.a, e.b, e.c]).for_each(|(list, h)| list.push(2.0 * h));
        }
    }
    let [a, b, c] = full;
    vec![("a", a), ("b", b), ("c", c)]
}

/// Length of an axis within the window and between the planes, µm. In a periodic cell all of a body whose
/// centre is there counts: what it lacks beyond a plane others have.
fn length_within(p: &Placed, window: Window, [bottom, top]: [f64; 2]) -> f64 {
    let Shape::Cylinder(c) = p.shape else { return 0.0 };
    let Window::Discs(radius, _) = window else {
        return if (bottom..top).contains(&p.centre.z) { 2.0 * c.half_length.unwrap_or(0.0) } else { 0.0 };
    };
    let (o, u) = (p.centre, p.frame.z);
    let reach = c.half_length.unwrap_or(f64::INFINITY);
    let (mut from, mut to) = (-reach, reach);
    let planes = if u.z == 0.0 {
        if !(bottom..top).contains(&o.z) {
            return 0.0;
        }
        [f64::NEG_INFINITY, f64::INFINITY]
    } else {
        let (a, b) = ((bottom - o.z) / u.z, (top - o.z) / u.z);
        [a.min(b), a.max(b)]
    };
    let (uu, ou, oo) = (u.x * u.x + u.y * u.y, o.x * u.x + o.y * u.y, o.x * o.x + o.y * o.y);
    let room = ou * ou - uu * (oo - radius * radius);
    if room <= 0.0 || uu == 0.0 {
        return 0.0;
    }
    from = from.max(planes[0]).max((-ou - room.sqrt()) / uu);
    to = to.min(planes[1]).min((-ou + room.sqrt()) / uu);
    (to - from).max(0.0)
}

/// 1 for a body whose centre is in the window and between the planes.
fn stands(p: &Placed, window: Window, [bottom, top]: [f64; 2]) -> f64 {
    let near = match window {
        Window::Cells(_) => true,
        Window::Discs(r, _) => p.centre.x * p.centre.x + p.centre.y * p.centre.y < r * r,
    };
    f64::from(near && (bottom..top).contains(&p.centre.z))
}

impl Population {
    /// A `<distribution>` file of this population.
    pub fn distribution(&self, name: &str, source: &str) -> String {
        let mut out = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- Measured by lightpro characterise: {} bodies. -->\n\
             <distribution kind=\"{}\" name=\"{}\" source=\"{}\">\n",
            self.count,
            self.kind,
            escaped(name),
            escaped(source),
        );
        let tag = if self.kind == "fibres" { "fibres" } else { "particles" };
        let _ = write!(out, "  <{tag}");
        if tag == "particles" {
            let _ = write!(out, " shape=\"ellipsoid\"");
        } else if self.finite {
            let _ = write!(out, " ends=\"flat\"");
        }
        let _ = write!(out, "{}", self.direction());
        let _ = writeln!(out, ">");
        for (name, values) in self.sizes.iter().filter(|(_, v)| !v.is_empty()) {
            let _ = writeln!(out, "    {}", law(name, values));
        }
        let _ = write!(out, "  </{tag}>\n</distribution>\n");
        out
    }

    /// Attributes of direction. Azimuths of order below that of chance, 2/√n, are uniform.
    fn direction(&self) -> String {
        const ISOTROPIC: f64 = 0.6837; // √(π²/4 − 2), of tilts with an even sine
        let (mean, order) = self.order;
        if self.tilt > 0.95 * ISOTROPIC {
            return " orientation=\"isotropic\"".to_owned();
        }
        let mut out = String::new();
        if order > 2.0 / (self.count as f64).sqrt() {
            let _ = write!(
                out,
                " orientation=\"wrapped-cauchy\" mean-direction=\"{:.3} deg\" rho=\"{order:.5}\"",
                mean.to_degrees()
            );
        }
        if self.tilt > 1e-6 {
            let _ = write!(out, " tilt=\"{:.4} deg\"", self.tilt.to_degrees());
        }
        // A section without direction is turned by √(π²/12) in the mean square.
        let roll = match self.roll {
            r if r < 1e-6 => "flat".to_owned(),
            r if r > 0.9 * PI / 12.0_f64.sqrt() => "uniform".to_owned(),
            r => format!("normal\" roll-sd=\"{:.4} deg", r.to_degrees()),
        };
        let _ = write!(out, " roll=\"{roll}\"");
        out
    }

    /// The amount as an attribute.
    pub fn amount(&self) -> String {
        match self.kind {
            "fibres" => format!("length-density=\"{:e} 1/um2\"", self.density),
            _ => format!("number-density=\"{:e} 1/um3\"", self.density),
        }
    }
}

/// A law of sizes as an element: constant, or a histogram of equal classes.
fn law(name: &str, values: &[f64]) -> String {
    let (lo, hi) = values.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), &v| (l.min(v), h.max(v)));
    let unit = if name == "flatness" { "" } else { " um" };
    if hi - lo <= 1e-9 * hi {
        return format!("<{name} law=\"constant\" value=\"{lo}{unit}\"/>");
    }
    let step = (hi - lo) / CLASSES as f64;
    let mut counts = [0_u64; CLASSES];
    for v in values {
        counts[(((v - lo) / step) as usize).min(CLASSES - 1)] += 1;
    }
    let edges: Vec<String> = (0..=CLASSES).map(|i| format!("{:.6}", lo + step * i as f64)).collect();
    let weights: Vec<String> = counts.iter().map(u64::to_string).collect();
    format!(
        "<{name} law=\"histogram\" edges=\"{}{unit}\" weights=\"{}\" weighted=\"number\"/>",
        edges.join(" "),
        weights.join(" ")
    )
}
