//! The body that a ray has met: exact local shape, where it stands, and where a ray leaves it.

use crate::math::frame::renormalise;
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
        let inverse = 1.0 / dd;
        let mid = -od * inverse;
        // Half chord by way of the closest point itself (see [`crate::math::quadratic::ball_roots`]).
        let room = 1.0 - (p + q * mid).length_squared();
        (room > 0.0).then(|| {
            let half = (room * inverse).sqrt();
            (mid - half, mid + half)
        })
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
        if inv.x == inv.y && (inv.z == 0.0 || inv.z == inv.x) {
            // Round: the scaled point is unit, but for the rounding of the root.
            return renormalise(p * inv);
        }
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

/// Where a line is in a body: from an entry to an exit, and the same of its lumen; −∞ where the ray is
/// known to be inside already.
#[derive(Clone, Copy, Debug)]
pub struct Spans {
    /// Distance of the entry into the body.
    pub from: f64,
    /// Distance of the exit.
    pub to: f64,
    /// Distance of the entry into the lumen; ∞ if the line misses it.
    pub lumen_from: f64,
    /// Distance of the exit out of the lumen; ∞ if the line misses it.
    pub lumen_to: f64,
    /// Surfaces of these four.
    pub surfaces: [Left; 4],
}

impl Spans {
    /// Whether the body holds the point just behind distance `t`.
    #[inline]
    pub fn holds(&self, t: f64) -> bool {
        self.from <= t && t < self.to
    }

    /// Whether its lumen does.
    #[inline]
    pub fn in_lumen(&self, t: f64) -> bool {
        self.lumen_from <= t && t < self.lumen_to
    }

    /// Whether the line meets the lumen.
    #[inline]
    pub fn meets_lumen(&self) -> bool {
        self.lumen_to < f64::INFINITY
    }
}

/// Outward normal of the end on the side of `along`.
#[inline]
fn end_normal(axis: DVec3, along: f64) -> DVec3 {
    if along < 0.0 { -axis } else { axis }
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
        let (o, d) = self.local(origin, dir);
        // A grazing ray that rounding puts outside leaves where it stands.
        let (from, to) = self.outer.stretch(o, d).or(inside.then_some((0.0, 0.0)))?;
        let surfaces = [Left::Outer, Left::Outer, Left::Lumen, Left::Lumen];
        let (none, no) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut s = Spans { from, to, lumen_from: none, lumen_to: none, surfaces };
        let in_lumen = matches!(left, Some((Left::Lumen, true)));
        if let Some(lumen) = &self.lumen
            && !matches!(left, Some((Left::Lumen, false)))
            && let Some((from, to)) = lumen.stretch(o, d).or(in_lumen.then_some((0.0, 0.0)))
        {
            (s.lumen_from, s.lumen_to) = (from, to);
        }
        if self.ends.is_finite() {
            self.cut(&mut s, o, d, inside)?;
        }
        if inside {
            (s.from, s.to) = (no, s.to.max(0.0));
        }
        if in_lumen {
            (s.lumen_from, s.lumen_to) = (no, s.lumen_to.max(0.0));
        }
        (s.to > s.from).then_some(s)
    }

    /// Cuts the stretches at the flat ends; `None` if nothing is left.
    fn cut(&self, s: &mut Spans, o: DVec3, d: DVec3, inside: bool) -> Option<()> {
        let (mut first, last) = self.between_ends(o, d)?;
        if inside {
            // Standing on an end: body and opening begin here.
            first = f64::NEG_INFINITY;
        }
        let cut = |from: &mut f64, to: &mut f64, surfaces: &mut [Left]| {
            if first > *from {
                (*from, surfaces[0]) = (first, Left::Cap);
            }
            if last < *to {
                (*to, surfaces[1]) = (last, Left::Cap);
            }
        };
        let (outer, lumen) = s.surfaces.split_at_mut(2);
        cut(&mut s.from, &mut s.to, outer);
        if s.lumen_to < f64::INFINITY {
            cut(&mut s.lumen_from, &mut s.lumen_to, lumen);
            if s.lumen_from >= s.lumen_to {
                (s.lumen_from, s.lumen_to) = (f64::INFINITY, f64::INFINITY);
            }
        }
        Some(())
    }

    /// A ray in the body's frame; without ends nothing asks for the axial part.
    #[inline]
    fn local(&self, origin: DVec3, dir: DVec3) -> (DVec3, DVec3) {
        let w = origin - self.centre;
        let f = &self.frame;
        if self.ends.is_infinite() && self.outer.c.is_infinite() {
            let flat = |v: DVec3| DVec3::new(f.x.dot(v), f.y.dot(v), 0.0);
            return (flat(w), flat(dir));
        }
        (f.to_local(w), f.to_local(dir))
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
