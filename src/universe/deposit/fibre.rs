//! A fibre that comes down: the support below it, and the lowest course that it can bend into.

use super::ground::Ground;
use super::{CLEAR, Deposit, ellipse, pressed};
use crate::math::{DVec3, Frame};
use crate::rng::Stream;
use crate::universe::shape::{Placed, Shape, SlantedCylinder};
use crate::universe::statistical::kind::Kind;
use crate::universe::statistical::section::Body;
use crate::universe::synthetic::Part;

/// How far a chain of pieces may stray from the course that it follows, µm.
const STRAY: f64 = 0.05;
/// Longest piece, µm.
const LONGEST: f64 = 50.0;

/// A fibre before it comes down.
pub(super) struct Blank {
    kind: usize,
    /// Where it may come down.
    places: Vec<DVec3>,
    frame: Frame,
    half: f64,
    outer: (f64, f64),
    lumen: Option<(f64, f64)>,
}

/// A fibre that lies.
#[derive(Clone, Debug)]
pub struct Fibre {
    /// Kind.
    pub kind: usize,
    /// Its middle, at height 0, µm.
    pub centre: DVec3,
    /// Across, up, along.
    pub frame: Frame,
    /// Half length along its course's shadow, µm.
    pub half: f64,
    /// Half axes of the section: across, up, µm.
    pub outer: (f64, f64),
    /// Half axes of the lumen.
    pub lumen: Option<(f64, f64)>,
    /// (Place along, height of the section's centre), µm: corners of the course.
    pub knots: Vec<(f64, f64)>,
}

impl Blank {
    /// A fibre with the sizes and the azimuth of `body` somewhere in the cell. An azimuth along which it
    /// would lie on its own images is drawn again.
    pub fn new((kind, law): (usize, &Kind), mut body: Body, model: &Deposit, rng: &mut Stream) -> Self {
        let cell = model.cell;
        let lumen = body.lumen.map(|l| (l.a, l.b));
        let (b, lumen) = pressed(body.outer.a, body.outer.b, lumen, model.pressing);
        let mut place = |_| DVec3::new(cell * rng.uniform(), cell * rng.uniform(), 0.0);
        let places = (0..model.places.max(1)).map(&mut place).collect();
        let mut tries = 0;
        while tries < 1000 && meets_itself(body.frame.z, body.ends, body.outer.a, cell) {
            body.frame = law.orientation(rng);
            tries += 1;
        }
        let axis = DVec3 { z: 0.0, ..body.frame.z };
        let z = if axis.length_squared() > 1e-12 { axis.normalize() } else { DVec3::X };
        let x = DVec3::new(-z.y, z.x, 0.0);
        let frame = Frame { x, y: DVec3::Z, z };
        Blank { kind, places, frame, half: body.ends, outer: (body.outer.a, b), lumen }
    }

    /// Comes to lie on `ground`, of its places at the one where the sheet stands lowest below it.
    pub fn settle(self, ground: &Ground, flexibility: f64) -> Fibre {
        let Blank { kind, places, frame, half, outer, lumen } = self;
        let mut fibre = Fibre { kind, centre: places[0], frame, half, outer, lumen, knots: Vec::new() };
        if places.len() > 1 {
            let height = |p: &DVec3| ground.support(&Fibre { centre: *p, ..fibre.clone() });
            let lowest = places.iter().map(|p| (height(p), p)).min_by(|a, b| a.0.total_cmp(&b.0));
            fibre.centre = lowest.map_or(fibre.centre, |l| *l.1);
        }
        let bins = ground.bins(half);
        let step = 2.0 * half / bins as f64;
        let mut need = vec![CLEAR + outer.1; bins];
        ground.under(&fibre, |first, last, height| {
            for n in &mut need[first..=last] {
                *n = n.max(height);
            }
        });
        let mut course: Vec<f64> =
            (0..=bins).map(|k| need[k.saturating_sub(1)].max(need[k.min(bins - 1)])).collect();
        let floor = course.clone();
        // The lowest course above that is nowhere steeper …
        let most = flexibility * step;
        for k in 1..=bins {
            course[k] = course[k].max(course[k - 1] - most);
        }
        for k in (0..bins).rev() {
            course[k] = course[k].max(course[k + 1] - most);
        }
        // … bent evenly, over one thickness on either side, never lower.
        even_out(&mut course, (2.0 * outer.1 / step).ceil() as usize);
        for (c, f) in course.iter_mut().zip(&floor) {
            *c = c.max(*f);
        }
        fibre.knots = corners(&course, -half, step);
        fibre
    }
}

/// Whether a straight fibre covers some of its images in neighbouring cells.
fn meets_itself(axis: DVec3, half: f64, a: f64, cell: f64) -> bool {
    let reach = (2.0 * half / cell).ceil() as i32;
    let near = |i: i32, j: i32| {
        let (x, y) = (f64::from(i) * cell, f64::from(j) * cell);
        let (along, across) = ((x * axis.x + y * axis.y).abs(), (x * axis.y - y * axis.x).abs());
        (i, j) != (0, 0) && along < 2.0 * half + 4.0 && across < 2.0 * a + 4.0
    };
    (-reach..=reach).any(|i| (-reach..=reach).any(|j| near(i, j)))
}

/// Highest value within m places on either side, then the mean over as many: nowhere below what it was,
/// nowhere steeper, and the slope changes by no more than 2F per 2m places.
fn even_out(course: &mut [f64], m: usize) {
    let n = course.len();
    let window = |k: usize| k.saturating_sub(m)..(k + m + 1).min(n);
    let high: Vec<f64> =
        (0..n).map(|k| course[window(k)].iter().copied().fold(f64::NEG_INFINITY, f64::max)).collect();
    let mut sums = vec![0.0; n + 1];
    for k in 0..n {
        sums[k + 1] = sums[k] + high[k];
    }
    for (k, c) in course.iter_mut().enumerate() {
        let w = window(k);
        *c = (sums[w.end] - sums[w.start]) / w.len() as f64;
    }
}

/// As few corners as follow the course within [`STRAY`], then raised so that no chord lies below it.
fn corners(course: &[f64], first: f64, step: f64) -> Vec<(f64, f64)> {
    let last = course.len() - 1;
    let longest = ((LONGEST / step) as usize).max(1);
    let chord =
        |i: usize, j: usize, k: usize| course[i] + (course[j] - course[i]) * (k - i) as f64 / (j - i) as f64;
    let strays = |i: usize, j: usize| (i + 1..j).any(|k| (chord(i, j, k) - course[k]).abs() > STRAY);
    let mut at = vec![0];
    let mut i = 0;
    while i < last {
        let mut j = i + 1;
        while j < last && j - i < longest && !strays(i, j + 1) {
            j += 1;
        }
        at.push(j);
        i = j;
    }
    let mut lift = vec![0.0_f64; at.len()];
    for (s, w) in at.windows(2).enumerate() {
        let below = (w[0]..=w[1]).map(|k| course[k] - chord(w[0], w[1], k)).fold(0.0, f64::max);
        lift[s] = lift[s].max(below);
        lift[s + 1] = lift[s + 1].max(below);
    }
    at.iter().zip(lift).map(|(&k, up)| (first + step * k as f64, course[k] + up)).collect()
}

impl Fibre {
    /// Highest point, µm.
    pub fn top(&self) -> f64 {
        self.knots.iter().map(|k| k.1).fold(f64::NEG_INFINITY, f64::max) + self.outer.1
    }

    /// Its pieces, with the given half axes of the section.
    pub fn pieces(&self, axes: (f64, f64)) -> impl Iterator<Item = SlantedCylinder> {
        self.knots.windows(2).map(move |k| SlantedCylinder::between(axes.0, axes.1, k[0], k[1]))
    }

    /// Area of the wall's section, µm².
    pub fn wall_area(&self) -> f64 {
        ellipse(self.outer.0, self.outer.1) - self.lumen.map_or(0.0, |(a, b)| ellipse(a, b))
    }

    /// Largest change of slope from piece to piece, rad.
    pub fn sharpest(&self) -> f64 {
        let slope = |k: &[(f64, f64)]| crate::math::atan((k[1].1 - k[0].1) / (k[1].0 - k[0].0));
        let turn = |k: &[(f64, f64)]| (slope(&k[1..]) - slope(&k[..2])).abs();
        self.knots.windows(3).map(turn).fold(0.0, f64::max)
    }

    /// Its regions: each piece and the hollow in it.
    pub(super) fn parts(&self, kind: &Kind) -> Vec<Part> {
        let mut parts = Vec::new();
        for k in self.knots.windows(2) {
            for (axes, medium) in [(Some(self.outer), kind.wall), (self.lumen, kind.lumen)] {
                let Some((a, b)) = axes else { continue };
                let piece = SlantedCylinder::between(a, b, k[0], k[1]);
                parts.push(Part {
                    shape: Placed::new(Shape::Slanted(piece), self.centre, self.frame),
                    medium,
                    surface: kind.surface,
                    priority: 0,
                    body: kind.body,
                });
            }
        }
        parts
    }
}
