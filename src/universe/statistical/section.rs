//! The body that a ray has met: exact local shape, where it stands, and where a ray leaves it.

use crate::math::quadratic::ball_roots;
use crate::math::{DVec3, Frame};

/// Half axes of an ellipse (fibre section) or ellipsoid; `c` infinite: unbounded cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfAxes {
    /// Along the frame's x.
    pub a: f64,
    /// Along the frame's y.
    pub b: f64,
    /// Along the frame's z.
    pub c: f64,
    /// Reciprocals: an unbounded half axis gives 0, so that the quadric of a cylinder is that of an
    /// ellipsoid with the axial term gone.
    inverse: DVec3,
}

impl HalfAxes {
    /// Ellipsoid with these half axes.
    #[inline]
    pub fn new(a: f64, b: f64, c: f64) -> Self {
        HalfAxes { a, b, c, inverse: DVec3::new(1.0 / a, 1.0 / b, 1.0 / c) }
    }

    /// Unbounded cylinder of elliptic section.
    #[inline]
    pub fn fibre(a: f64, b: f64) -> Self {
        HalfAxes { a, b, c: f64::INFINITY, inverse: DVec3::new(1.0 / a, 1.0 / b, 0.0) }
    }

    /// Both crossings of the line o + t d (local coordinates) with the surface.
    #[inline]
    pub fn crossings(&self, o: DVec3, d: DVec3) -> Option<(f64, f64)> {
        let inv = self.inverse;
        let (p, q) = (o * inv, d * inv);
        let dd = q.length_squared();
        if dd < 1e-280 {
            return None; // along the axis of an unbounded cylinder
        }
        let od = p.dot(q);
        let closest = p - q * (od / dd);
        ball_roots(dd, od, closest.length_squared())
    }

    /// Both crossings of the line, −∞ and ∞ for a line along the axis inside an unbounded cylinder.
    #[inline]
    pub fn stretch(&self, o: DVec3, d: DVec3) -> Option<(f64, f64)> {
        if self.c.is_infinite() && d.x * d.x + d.y * d.y < 1e-28 {
            let p = o * self.inverse;
            return (p.length_squared() < 1.0).then_some((f64::NEG_INFINITY, f64::INFINITY));
        }
        self.crossings(o, d)
    }

    /// Outward unit normal at a surface point (local coordinates).
    #[inline]
    pub fn normal(&self, p: DVec3) -> DVec3 {
        let inv = self.inverse;
        (p * inv * inv).normalize()
    }

    /// Area of the section (cylinders: per length π a b) or volume (4π abc/3).
    #[inline]
    pub fn content(&self) -> f64 {
        use crate::math::PI;
        if self.c.is_infinite() { PI * self.a * self.b } else { 4.0 / 3.0 * PI * self.a * self.b * self.c }
    }
}

/// Which part of a body a ray is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The solid.
    Wall,
    /// The hollow.
    Lumen,
}

/// Surface that a ray has just left, whose root is known and removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Left {
    /// None: the ray starts in the middle of a medium.
    Nothing,
    /// The outer surface.
    Outer,
    /// The lumen's surface.
    Lumen,
    /// A flat end of a cut fibre.
    Cap,
}

/// A body in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Axes: x major, y minor, z fibre axis.
    pub frame: Frame,
    /// Centre (any point of the axis for a fibre).
    pub centre: DVec3,
    /// Outer half axes.
    pub outer: HalfAxes,
    /// Half axes of the lumen; `None` for a solid or fully collapsed body.
    pub lumen: Option<HalfAxes>,
    /// Half length between flat ends (finite fibres, discs); infinite: no ends.
    pub ends: f64,
    /// Kind in its layer.
    pub kind: u16,
}

/// Crossing of one of the body's surfaces, as seen by a ray inside the body.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// Distance.
    pub t: f64,
    /// Outward unit normal of the crossed surface, world coordinates.
    pub outward: DVec3,
    /// Which surface.
    pub surface: Left,
}

/// Where a line is in a body: the whole body and its lumen, each from an entry to an exit.
#[derive(Clone, Copy, Debug)]
pub struct Spans {
    /// The whole body.
    pub outer: Span,
    /// The hollow.
    pub lumen: Option<Span>,
}

/// A stretch of a line between two surfaces; −∞ where the ray is known to be inside already.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Distance of the entry.
    pub from: f64,
    /// Distance of the exit.
    pub to: f64,
    /// Surface of the entry.
    pub first: Left,
    /// Surface of the exit.
    pub last: Left,
}

/// Outward normal of the end on the side of `along`.
#[inline]
fn end_normal(axis: DVec3, along: f64) -> DVec3 {
    if along < 0.0 { -axis } else { axis }
}

/// Cuts a stretch at flat ends.
#[inline]
fn cut(s: &mut Span, from: f64, to: f64) {
    if from > s.from {
        (s.from, s.first) = (from, Left::Cap);
    }
    if to < s.to {
        (s.to, s.last) = (to, Left::Cap);
    }
}

impl Span {
    /// Whether the stretch holds the point just behind distance `t`.
    #[inline]
    pub fn holds(&self, t: f64) -> bool {
        self.from <= t && t < self.to
    }
}

impl Body {
    /// The next surface that a ray inside the body meets; `None` only for a ray along the axis of an
    /// unbounded fibre. Convexity tells which roots can count: in the lumen the far root of the
    /// lumen; in the wall the near root of the lumen, unless the ray has just left it, else the far
    /// root of the outer surface. No root is judged by its distance.
    #[inline]
    pub fn leave(&self, origin: DVec3, dir: DVec3, part: Part, left: Left) -> Option<Crossing> {
        let o = self.frame.to_local(origin - self.centre);
        let d = self.frame.to_local(dir);
        let end = if self.ends.is_finite() { self.end_ahead(o, d) } else { f64::INFINITY };
        let hit = |axes: &HalfAxes, t: f64, surface: Left| {
            if end < t {
                let outward = end_normal(self.frame.z, d.z);
                return Crossing { t: end.max(0.0), outward, surface: Left::Cap };
            }
            let t = t.max(0.0);
            Crossing { t, outward: self.frame.to_world(axes.normal(o + d * t)), surface }
        };
        match (part, &self.lumen) {
            (Part::Lumen, Some(lumen)) => {
                let far = lumen.crossings(o, d).map_or(if end.is_finite() { end } else { 0.0 }, |c| c.1);
                Some(hit(lumen, far, Left::Lumen))
            }
            (_, lumen) => {
                if let Some(lumen) = lumen
                    && left != Left::Lumen
                    && let Some((near, far)) = lumen.crossings(o, d)
                    && far > 0.0
                    && near + far > 0.0
                {
                    return Some(hit(lumen, near, Left::Lumen));
                }
                match self.outer.crossings(o, d) {
                    Some((_, far)) => Some(hit(&self.outer, far, Left::Outer)),
                    // A grazing ray that rounding puts outside: it leaves where it stands.
                    None if d.x * d.x + d.y * d.y > 1e-280 || self.outer.c.is_finite() => {
                        Some(hit(&self.outer, 0.0, Left::Outer))
                    }
                    None if end.is_finite() => Some(hit(&self.outer, f64::INFINITY, Left::Cap)),
                    None => None,
                }
            }
        }
    }

    /// Distance to the flat end ahead (local coordinates); infinite across the axis.
    #[inline]
    fn end_ahead(&self, o: DVec3, d: DVec3) -> f64 {
        if d.z == 0.0 { f64::INFINITY } else { (self.ends.copysign(d.z) - o.z) / d.z }
    }

    /// Where the line of a ray is in the body, or `None` if it is nowhere ahead of it.
    ///
    /// `left`: the surface of this body that the ray stands on, and whether it is inside that surface;
    /// its root at the ray's origin is removed by convexity, never by distance.
    #[inline]
    pub fn spans(&self, origin: DVec3, dir: DVec3, left: Option<(Left, bool)>) -> Option<Spans> {
        let inside = match left {
            Some((Left::Outer | Left::Cap, false)) => return None,
            Some(_) => true,
            None => false,
        };
        let o = self.frame.to_local(origin - self.centre);
        let d = self.frame.to_local(dir);
        let mut outer = match self.outer.stretch(o, d) {
            Some((from, to)) => Span { from, to, first: Left::Outer, last: Left::Outer },
            // A grazing ray that rounding puts outside leaves where it stands.
            None if inside => Span { from: 0.0, to: 0.0, first: Left::Outer, last: Left::Outer },
            None => return None,
        };
        let ends = if self.ends.is_finite() {
            let (from, to) = self.between_ends(o, d)?;
            cut(&mut outer, from, to);
            Some((from, to))
        } else {
            None
        };
        if inside {
            outer.from = f64::NEG_INFINITY;
            outer.to = outer.to.max(0.0);
        }
        let lumen = match (&self.lumen, left) {
            (None, _) | (_, Some((Left::Lumen, false))) => None,
            (Some(l), _) => {
                let within = matches!(left, Some((Left::Lumen, true)));
                let found = l.stretch(o, d).or(within.then_some((0.0, 0.0)));
                found.map(|(from, to)| {
                    let mut s = Span { from, to, first: Left::Lumen, last: Left::Lumen };
                    if let Some((from, to)) = ends {
                        // Standing on an end: the opening begins here.
                        let from = if inside { f64::NEG_INFINITY } else { from };
                        cut(&mut s, from, to);
                    }
                    if within {
                        s.from = f64::NEG_INFINITY;
                        s.to = s.to.max(0.0);
                    }
                    s
                })
            }
        };
        (outer.to > outer.from).then_some(Spans { outer, lumen: lumen.filter(|l| l.to > l.from) })
    }

    /// Distances between which the line is between the flat ends.
    #[inline]
    fn between_ends(&self, o: DVec3, d: DVec3) -> Option<(f64, f64)> {
        if d.z == 0.0 {
            return (o.z.abs() < self.ends).then_some((f64::NEG_INFINITY, f64::INFINITY));
        }
        let far = self.ends.copysign(d.z);
        Some(((-far - o.z) / d.z, (far - o.z) / d.z))
    }

    /// Outward unit normal of a surface at a point (world), world coordinates.
    #[inline]
    pub fn outward(&self, surface: Left, point: DVec3) -> DVec3 {
        let p = self.frame.to_local(point - self.centre);
        match (surface, &self.lumen) {
            (Left::Cap, _) => end_normal(self.frame.z, p.z),
            (Left::Lumen, Some(l)) => self.frame.to_world(l.normal(p)),
            _ => self.frame.to_world(self.outer.normal(p)),
        }
    }

    /// Half of the body's extent along z.
    pub fn half_height(&self) -> f64 {
        half_height(&self.frame, &self.outer, self.ends)
    }

    /// Whether a point (world) lies in the wall or the lumen; the point is known to be in the body.
    pub fn part_at(&self, point: DVec3) -> Part {
        let p = self.frame.to_local(point - self.centre);
        match &self.lumen {
            Some(l) if (p.x / l.a).powi(2) + (p.y / l.b).powi(2) < 1.0 => Part::Lumen,
            _ => Part::Wall,
        }
    }
}

/// Half extent along world z of a body with these axes and flat ends; the axial term of an unbounded
/// in-plane fibre is left out.
pub fn half_height(frame: &Frame, axes: &HalfAxes, ends: f64) -> f64 {
    let mut h2 = (axes.a * frame.x.z).powi(2) + (axes.b * frame.y.z).powi(2);
    if axes.c.is_finite() {
        h2 += (axes.c * frame.z.z).powi(2);
    }
    let axial = if ends.is_finite() { ends * frame.z.z.abs() } else { 0.0 };
    h2.sqrt() + axial
}
