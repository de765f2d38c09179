//! Cylinder of elliptic section: a fibre, or its lumen.

use super::integral::ellipse_perimeter;
use super::{Chord, Convex, ShapeFace, starts_in_ball};
use crate::math::quadratic::ball_roots;
use crate::math::{DVec3, PI, sin_cos};

/// Cylinder along local z with section x²/a² + y²/b² ≤ 1, bounded by flat caps at z = ± half_length
/// or unbounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EllipticCylinder {
    /// Half axis of the section along local x, µm.
    pub a: f64,
    /// Half axis of the section along local y, µm.
    pub b: f64,
    /// Half length, µm; `None`: unbounded.
    pub half_length: Option<f64>,
}

/// A line against the unbounded side.
pub(super) enum Side {
    /// Parallel to the axis; whether inside.
    Parallel(bool),
    /// Both roots.
    Roots(f64, f64),
    /// Misses; distance to the closest approach.
    Miss(f64),
}

impl Side {
    /// What of the line lies within the side and between two ends.
    #[inline]
    pub(super) fn between(self, ends: impl FnOnce() -> Option<Chord>) -> Option<Chord> {
        let (lo, hi) = match self {
            Side::Roots(lo, hi) => (lo, hi),
            Side::Parallel(true) => (f64::NEG_INFINITY, f64::INFINITY),
            Side::Parallel(false) | Side::Miss(_) => return None,
        };
        let mut ends = ends()?;
        if lo >= ends.t_in {
            (ends.t_in, ends.face_in) = (lo, ShapeFace::Side);
        }
        if hi <= ends.t_out {
            (ends.t_out, ends.face_out) = (hi, ShapeFace::Side);
        }
        (ends.t_in < ends.t_out).then_some(ends)
    }

    /// Where a ray inside leaves through the side; a line that misses by rounding at twice its closest
    /// approach.
    #[inline]
    pub(super) fn leave(self) -> f64 {
        match self {
            Side::Roots(_, hi) => hi,
            Side::Parallel(_) => f64::INFINITY,
            Side::Miss(mid) => 2.0 * mid,
        }
    }
}

impl EllipticCylinder {
    /// 2-D, in the plane of the section scaled to the unit circle. The distance of the line from
    /// the axis is |q × e|/|e|, free of the cancellation in q·q − (q·e)²/e².
    #[inline]
    pub(super) fn side(&self, o: DVec3, d: DVec3) -> Side {
        let (qx, qy, ex, ey) = (o.x / self.a, o.y / self.b, d.x / self.a, d.y / self.b);
        let dd = ex * ex + ey * ey;
        // Squares below this lose their bits to underflow: a slope of 1e-145 is parallel.
        if dd < 1e-290 {
            return Side::Parallel(qx * qx + qy * qy <= 1.0);
        }
        let od = qx * ex + qy * ey;
        let cross = qx * ey - qy * ex;
        match ball_roots(dd, od, cross * cross / dd) {
            Some((lo, hi)) => Side::Roots(lo, hi),
            None => Side::Miss(-od / dd),
        }
    }

    /// Width of the section seen along a direction in its plane at angle ψ to the half axis a:
    /// w = 2 √(a² sin²ψ + b² cos²ψ), µm.
    pub fn projected_width(&self, psi: f64) -> f64 {
        let (s, c) = sin_cos(psi);
        self.width_along(c, s)
    }

    /// The same width for a direction (x, y) of any length but zero: no angle needed.
    #[inline]
    pub fn width_along(&self, x: f64, y: f64) -> f64 {
        2.0 * ((self.a * self.a * y * y + self.b * self.b * x * x) / (x * x + y * y)).sqrt()
    }

    /// Area of the section, π a b, µm².
    pub fn area(&self) -> f64 {
        PI * self.a * self.b
    }

    /// Perimeter of the section, µm.
    pub fn perimeter(&self) -> f64 {
        ellipse_perimeter(self.a, self.b)
    }

    /// Volume, µm³, or `None` if unbounded.
    pub fn volume(&self) -> Option<f64> {
        self.half_length.map(|h| 2.0 * h * self.area())
    }

    /// Surface with both caps, µm², or `None` if unbounded.
    pub fn surface_area(&self) -> Option<f64> {
        self.half_length.map(|h| 2.0 * h * self.perimeter() + 2.0 * self.area())
    }

    /// Mean chord of isotropic uniform lines, 4V/S (Cauchy), µm.
    pub fn mean_chord(&self) -> f64 {
        match (self.volume(), self.surface_area()) {
            (Some(v), Some(s)) => 4.0 * v / s,
            _ => 4.0 * self.area() / self.perimeter(),
        }
    }

    /// Projected area along a unit direction, side and caps: 2h w |sin γ| + π a b |cos γ|, µm²;
    /// `None` if unbounded.
    pub fn projected_area(&self, dir: DVec3) -> Option<f64> {
        let side = (self.a * self.a * dir.y * dir.y + self.b * self.b * dir.x * dir.x).sqrt();
        self.half_length.map(|h| 4.0 * h * side + self.area() * dir.z.abs())
    }

    /// Where a line along `dir` (local, not parallel to the axis) that is uniform over the
    /// projected width enters the side: `u` in (0, 1) is the offset over that width. Returns the
    /// point in the section (z = 0), µm, and the outward unit normal (z = 0).
    ///
    /// The affine map to the unit circle keeps parallel lines parallel and equally spaced.
    #[inline]
    pub fn entry_uniform(&self, dir: DVec3, u: f64) -> (DVec3, DVec3) {
        let (ex, ey) = (dir.x / self.a, dir.y / self.b);
        let l = (ex * ex + ey * ey).sqrt();
        let (ex, ey) = if l > 0.0 { (ex / l, ey / l) } else { (1.0, 0.0) };
        let s = 2.0 * u - 1.0;
        let depth = 2.0 * (u * (1.0 - u)).sqrt();
        let (qx, qy) = (-s * ey - depth * ex, s * ex - depth * ey);
        let point = DVec3::new(self.a * qx, self.b * qy, 0.0);
        (point, DVec3::new(qx / self.a, qy / self.b, 0.0).normalize())
    }

    /// Interval of the line between the caps, as (t at −h, t at +h) in the order of the ray.
    #[inline]
    fn caps(&self, o: DVec3, d: DVec3) -> Option<Chord> {
        match self.half_length {
            Some(h) => super::plane::between(-h, h, o.z, d.z),
            None => super::plane::between(f64::NEG_INFINITY, f64::INFINITY, 0.0, 0.0),
        }
    }
}

impl Convex for EllipticCylinder {
    #[inline]
    fn chord(&self, o: DVec3, d: DVec3) -> Option<Chord> {
        self.side(o, d).between(|| self.caps(o, d))
    }

    #[inline]
    fn way_out(&self, o: DVec3, d: DVec3) -> (f64, ShapeFace) {
        let side = self.side(o, d).leave();
        match self.half_length.map(|h| super::plane::leave(-h, h, o.z, d.z)) {
            Some((t, face)) if t < side => (t, face),
            _ => (side, ShapeFace::Side),
        }
    }

    #[inline]
    fn normal(&self, p: DVec3, face: ShapeFace) -> DVec3 {
        match face {
            ShapeFace::CapTop => DVec3::Z,
            ShapeFace::CapBottom => -DVec3::Z,
            _ => DVec3::new(p.x / self.a / self.a, p.y / self.b / self.b, 0.0).normalize(),
        }
    }

    fn starts_inside(&self, o: DVec3, d: DVec3) -> bool {
        let (qx, qy, ex, ey) = (o.x / self.a, o.y / self.b, d.x / self.a, d.y / self.b);
        starts_in_ball(qx * qx + qy * qy, qx * ex + qy * ey) && super::plane::holds_start(self.caps(o, d))
    }

    #[inline]
    fn contains(&self, p: DVec3) -> bool {
        let (x, y) = (p.x / self.a, p.y / self.b);
        x * x + y * y <= 1.0 && self.half_length.is_none_or(|h| p.z.abs() <= h)
    }
}
