//! Shapes bounded by planes. Every plane is met at (plane − o)/d, and by nothing else: layers that
//! share a plane give the same bits, whichever layer is asked.

use super::{Chord, Convex, ShapeFace};
use crate::math::DVec3;

/// Box min ≤ p ≤ max along the axes. Its faces are kept as given (not as centre ± half), so that
/// boxes that share a face share it exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Lower corner, µm.
    pub min: DVec3,
    /// Upper corner, µm.
    pub max: DVec3,
}

/// Half space z ≤ 0 below a plane with outward normal +z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HalfSpace;

/// Slab z_min ≤ z ≤ z_max, unbounded sideways. A plane z_p is met at (z_p − z)/u_z exactly as
/// written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabZ {
    /// Lower plane, µm.
    pub z_min: f64,
    /// Upper plane, µm.
    pub z_max: f64,
}

/// Interval of a line between two planes of one coordinate (the z faces by name).
#[inline]
pub(super) fn between(lo: f64, hi: f64, o: f64, d: f64) -> Option<Chord> {
    use ShapeFace::{CapBottom, CapTop};
    if d > 0.0 {
        Some(Chord { t_in: (lo - o) / d, t_out: (hi - o) / d, face_in: CapBottom, face_out: CapTop })
    } else if d < 0.0 {
        Some(Chord { t_in: (hi - o) / d, t_out: (lo - o) / d, face_in: CapTop, face_out: CapBottom })
    } else {
        (lo <= o && o <= hi).then_some(Chord {
            t_in: f64::NEG_INFINITY,
            t_out: f64::INFINITY,
            face_in: CapBottom,
            face_out: CapTop,
        })
    }
}

/// Where a ray known to be between two planes leaves: the plane that it faces.
#[inline]
pub(super) fn leave(lo: f64, hi: f64, o: f64, d: f64) -> (f64, ShapeFace) {
    if d > 0.0 {
        ((hi - o) / d, ShapeFace::CapTop)
    } else if d < 0.0 {
        ((lo - o) / d, ShapeFace::CapBottom)
    } else {
        (f64::INFINITY, ShapeFace::CapTop)
    }
}

/// The same face on another axis of a cuboid (0 = x, 1 = y, 2 = z).
#[inline]
fn on_axis(face: ShapeFace, axis: usize) -> ShapeFace {
    match (axis, face == ShapeFace::CapTop) {
        (0, false) => ShapeFace::XMin,
        (0, true) => ShapeFace::XMax,
        (1, false) => ShapeFace::YMin,
        (1, true) => ShapeFace::YMax,
        _ => face,
    }
}

/// A chord that holds the start: its near end counts as inside, its far end as outside.
#[inline]
pub(super) fn holds_start(chord: Option<Chord>) -> bool {
    chord.is_some_and(|c| c.t_in <= 0.0 && 0.0 < c.t_out)
}

/// Outward normal of a plane face.
#[inline]
fn plane_normal(face: ShapeFace) -> DVec3 {
    match face {
        ShapeFace::XMin => -DVec3::X,
        ShapeFace::XMax => DVec3::X,
        ShapeFace::YMin => -DVec3::Y,
        ShapeFace::YMax => DVec3::Y,
        ShapeFace::CapBottom => -DVec3::Z,
        _ => DVec3::Z,
    }
}

impl Cuboid {
    /// Box of the given half edges around the local origin.
    pub fn centred(half: DVec3) -> Self {
        Cuboid { min: -half, max: half }
    }

    /// Volume, µm³.
    pub fn volume(&self) -> f64 {
        (self.max - self.min).element_product()
    }

    /// Surface, µm².
    pub fn surface_area(&self) -> f64 {
        let e = self.max - self.min;
        2.0 * (e.x * e.y + e.y * e.z + e.z * e.x)
    }

    /// Mean chord of isotropic uniform lines, 4V/S (Cauchy), µm.
    pub fn mean_chord(&self) -> f64 {
        4.0 * self.volume() / self.surface_area()
    }

    /// Projected area along a unit direction, µm².
    pub fn projected_area(&self, dir: DVec3) -> f64 {
        let e = self.max - self.min;
        e.y * e.z * dir.x.abs() + e.x * e.z * dir.y.abs() + e.x * e.y * dir.z.abs()
    }
}

impl Convex for Cuboid {
    #[inline]
    fn chord(&self, o: DVec3, d: DVec3) -> Option<Chord> {
        let mut all = between(self.min.z, self.max.z, o.z, d.z)?;
        for axis in 0..2 {
            let c = between(self.min[axis], self.max[axis], o[axis], d[axis])?;
            if c.t_in > all.t_in {
                (all.t_in, all.face_in) = (c.t_in, on_axis(c.face_in, axis));
            }
            if c.t_out < all.t_out {
                (all.t_out, all.face_out) = (c.t_out, on_axis(c.face_out, axis));
            }
        }
        (all.t_in < all.t_out).then_some(all)
    }

    #[inline]
    fn way_out(&self, o: DVec3, d: DVec3) -> (f64, ShapeFace) {
        let mut out = leave(self.min.z, self.max.z, o.z, d.z);
        for axis in 0..2 {
            let (t, face) = leave(self.min[axis], self.max[axis], o[axis], d[axis]);
            if t < out.0 {
                out = (t, on_axis(face, axis));
            }
        }
        out
    }

    #[inline]
    fn normal(&self, _: DVec3, face: ShapeFace) -> DVec3 {
        plane_normal(face)
    }

    fn starts_inside(&self, o: DVec3, d: DVec3) -> bool {
        holds_start(self.chord(o, d))
    }

    #[inline]
    fn contains(&self, p: DVec3) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }
}

impl Convex for HalfSpace {
    #[inline]
    fn chord(&self, o: DVec3, d: DVec3) -> Option<Chord> {
        let mut c = between(f64::NEG_INFINITY, 0.0, o.z, d.z)?;
        // The other plane is infinitely far: rename the face, keep the distance.
        (c.face_in, c.face_out) = (ShapeFace::CapTop, ShapeFace::CapTop);
        Some(c)
    }

    #[inline]
    fn way_out(&self, o: DVec3, d: DVec3) -> (f64, ShapeFace) {
        (if d.z > 0.0 { -o.z / d.z } else { f64::INFINITY }, ShapeFace::CapTop)
    }

    #[inline]
    fn normal(&self, _: DVec3, _: ShapeFace) -> DVec3 {
        DVec3::Z
    }

    fn starts_inside(&self, o: DVec3, d: DVec3) -> bool {
        holds_start(self.chord(o, d))
    }

    #[inline]
    fn contains(&self, p: DVec3) -> bool {
        p.z <= 0.0
    }
}

impl SlabZ {
    /// Mean chord of isotropic uniform lines, 4V/S = 2 × thickness, µm.
    pub fn mean_chord(&self) -> f64 {
        2.0 * (self.z_max - self.z_min)
    }
}

impl Convex for SlabZ {
    #[inline]
    fn chord(&self, o: DVec3, d: DVec3) -> Option<Chord> {
        between(self.z_min, self.z_max, o.z, d.z)
    }

    #[inline]
    fn way_out(&self, o: DVec3, d: DVec3) -> (f64, ShapeFace) {
        leave(self.z_min, self.z_max, o.z, d.z)
    }

    #[inline]
    fn normal(&self, _: DVec3, face: ShapeFace) -> DVec3 {
        plane_normal(face)
    }

    fn starts_inside(&self, o: DVec3, d: DVec3) -> bool {
        holds_start(self.chord(o, d))
    }

    #[inline]
    fn contains(&self, p: DVec3) -> bool {
        self.z_min <= p.z && p.z <= self.z_max
    }
}
