//! Piece of a bent fibre: a cylinder whose elliptic section is the same in every plane across the
//! fibre's course while its centre rises along it.

use super::integral::ellipse_perimeter;
use super::{Chord, Convex, EllipticCylinder, ShapeFace, plane, starts_in_ball};
use crate::math::{DVec3, PI};

/// Points with `from` ≤ z ≤ `to` and x²/a² + (y − y_c)²/b² ≤ 1, y_c = height + slope (z − from): local z
/// runs along the fibre's course in the sheet, y up. The shear y' = y − y_c makes it a straight elliptic
/// cylinder, so that hits are exact; distances along a ray are the same in both.
///
/// Pieces of one fibre share the local frame and the plane where one ends and the next begins: both meet
/// a ray there at (z_plane − z)/u_z, the same bits, with the same section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlantedCylinder {
    /// Half axis of the section across (x), µm.
    pub a: f64,
    /// Half axis of the section upwards (y), µm.
    pub b: f64,
    /// First end, µm along z.
    pub from: f64,
    /// Last end, µm along z.
    pub to: f64,
    /// Height of the section's centre at the first end, µm.
    pub height: f64,
    /// Rise of the centre over way along z.
    pub slope: f64,
}

impl SlantedCylinder {
    /// The piece between two centres of sections (z, y), µm.
    pub fn between(a: f64, b: f64, first: (f64, f64), last: (f64, f64)) -> Self {
        let slope = (last.1 - first.1) / (last.0 - first.0);
        SlantedCylinder { a, b, from: first.0, to: last.0, height: first.1, slope }
    }

    /// Height of the section's centre, µm.
    #[inline]
    pub fn centre(&self, z: f64) -> f64 {
        self.height + self.slope * (z - self.from)
    }

    /// Volume π a b (to − from), µm³: a shear keeps it.
    pub fn volume(&self) -> f64 {
        PI * self.a * self.b * (self.to - self.from)
    }

    /// Curved surface without the ends, µm²: the perimeter of an ellipse with the half axes a √(1 + slope²)
    /// and b, times the length along z.
    pub fn side_area(&self) -> f64 {
        ellipse_perimeter(self.a * (1.0 + self.slope * self.slope).sqrt(), self.b) * (self.to - self.from)
    }

    #[inline]
    fn straight(&self) -> EllipticCylinder {
        EllipticCylinder { a: self.a, b: self.b, half_length: None }
    }

    /// The way through the side alone.
    #[inline]
    pub(super) fn way_through_side(&self, o: DVec3, d: DVec3) -> Option<Chord> {
        let (so, sd) = self.sheared(o, d);
        self.straight().way_through(so, sd)
    }

    /// A point and a direction in the space where the piece is straight and level.
    #[inline]
    fn sheared(&self, o: DVec3, d: DVec3) -> (DVec3, DVec3) {
        (DVec3 { y: o.y - self.centre(o.z), ..o }, DVec3 { y: d.y - self.slope * d.z, ..d })
    }
}

impl Convex for SlantedCylinder {
    #[inline]
    fn chord(&self, o: DVec3, d: DVec3) -> Option<Chord> {
        let (so, sd) = self.sheared(o, d);
        self.straight().side(so, sd).between(|| plane::between(self.from, self.to, o.z, d.z))
    }

    #[inline]
    fn way_out(&self, o: DVec3, d: DVec3) -> (f64, ShapeFace) {
        let (so, sd) = self.sheared(o, d);
        let side = self.straight().side(so, sd).leave();
        match plane::leave(self.from, self.to, o.z, d.z) {
            (t, face) if t < side => (t, face),
            _ => (side, ShapeFace::Side),
        }
    }

    #[inline]
    fn normal(&self, p: DVec3, face: ShapeFace) -> DVec3 {
        match face {
            ShapeFace::CapTop => DVec3::Z,
            ShapeFace::CapBottom => -DVec3::Z,
            _ => {
                let (x, y) = (p.x / self.a / self.a, (p.y - self.centre(p.z)) / self.b / self.b);
                DVec3::new(x, y, 0.0 - self.slope * y).normalize()
            }
        }
    }

    fn contains(&self, p: DVec3) -> bool {
        let (x, y) = (p.x / self.a, (p.y - self.centre(p.z)) / self.b);
        x * x + y * y <= 1.0 && self.from <= p.z && p.z <= self.to
    }

    fn starts_inside(&self, o: DVec3, d: DVec3) -> bool {
        let (so, sd) = self.sheared(o, d);
        let (qx, qy, ex, ey) = (so.x / self.a, so.y / self.b, sd.x / self.a, sd.y / self.b);
        starts_in_ball(qx * qx + qy * qy, qx * ex + qy * ey)
            && plane::holds_start(plane::between(self.from, self.to, o.z, d.z))
    }
}
