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

    /// Area (per fibre length π a b) or volume (4π abc/3).
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

impl Body {
    /// The next surface that a ray inside the body meets; `None` only for a ray along the axis of an
    /// unbounded fibre. Convexity tells which roots can count: in the lumen the far root of the
    /// lumen; in the wall the near root of the lumen, unless the ray has just left it, else the far
    /// root of the outer surface. No root is judged by its distance.
    #[inline]
    pub fn leave(&self, origin: DVec3, dir: DVec3, part: Part, left: Left) -> Option<Crossing> {
        let o = self.frame.to_local(origin - self.centre);
        let d = self.frame.to_local(dir);
        let hit = |axes: &HalfAxes, t: f64, surface: Left| {
            let t = t.max(0.0);
            Crossing { t, outward: self.frame.to_world(axes.normal(o + d * t)), surface }
        };
        match (part, &self.lumen) {
            (Part::Lumen, Some(lumen)) => {
                let (_, far) = lumen.crossings(o, d).unwrap_or((0.0, 0.0));
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
                    None => None,
                }
            }
        }
    }

    /// Half of the body's extent along z.
    pub fn half_height(&self) -> f64 {
        half_height(&self.frame, &self.outer)
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

/// Half extent along world z of a body with these axes; the axial term of an unbounded in-plane
/// fibre is left out.
pub fn half_height(frame: &Frame, axes: &HalfAxes) -> f64 {
    let mut h2 = (axes.a * frame.x.z).powi(2) + (axes.b * frame.y.z).powi(2);
    if axes.c.is_finite() {
        h2 += (axes.c * frame.z.z).powi(2);
    }
    h2.sqrt()
}
