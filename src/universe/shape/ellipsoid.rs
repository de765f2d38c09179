//! Ellipsoid: flake, fine, pore, filler, sphere.

use super::integral::carlson_rg;
use super::{Chord, Convex, ShapeFace, starts_in_ball};
use crate::math::fast::cos_sin_turn;
use crate::math::quadratic::ball_roots;
use crate::math::{DVec3, PI, orthonormal};

/// Ellipsoid x²/a² + y²/b² + z²/c² ≤ 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Half axis along local x, µm.
    pub a: f64,
    /// Half axis along local y, µm.
    pub b: f64,
    /// Half axis along local z, µm.
    pub c: f64,
}

impl Ellipsoid {
    /// A ball.
    pub fn sphere(radius: f64) -> Self {
        Ellipsoid { a: radius, b: radius, c: radius }
    }

    #[inline]
    fn axes(&self) -> DVec3 {
        DVec3::new(self.a, self.b, self.c)
    }

    /// Roots in the space where the ellipsoid is the unit ball, and the closest approach.
    #[inline]
    fn roots(&self, o: DVec3, d: DVec3) -> (f64, Option<(f64, f64)>) {
        let (q, e) = (o / self.axes(), d / self.axes());
        let (dd, od) = (e.dot(e), q.dot(e));
        let mid = -od / dd;
        (mid, ball_roots(dd, od, (q + e * mid).length_squared()))
    }

    /// Projected area along a unit direction u: π √(b²c²u_x² + a²c²u_y² + a²b²u_z²), µm².
    #[inline]
    pub fn projected_area(&self, dir: DVec3) -> f64 {
        let cofactor = DVec3::new(self.b * self.c, self.a * self.c, self.a * self.b);
        PI * (cofactor * dir).length()
    }

    /// Volume 4π abc/3, µm³.
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.a * self.b * self.c
    }

    /// Surface 4π R_G(a²b², a²c², b²c²), µm² (DLMF 19.33.1).
    pub fn surface_area(&self) -> f64 {
        let m = self.a.max(self.b).max(self.c);
        let (x, y, z) = (self.a * self.b / (m * m), self.a * self.c / (m * m), self.b * self.c / (m * m));
        4.0 * PI * m * m * carlson_rg(x * x, y * y, z * z)
    }

    /// Mean chord of isotropic uniform lines, 4V/S (Cauchy), µm.
    pub fn mean_chord(&self) -> f64 {
        4.0 * self.volume() / self.surface_area()
    }

    /// Where a line along the unit direction `dir` (local) that is uniform over the projected area
    /// enters: `u1`, `u2` in (0, 1) are area inside the disc and turn. Returns the point, µm, and the
    /// outward unit normal.
    ///
    /// Scaling to the unit ball maps lines along `dir` to parallel lines with constant density,
    /// so a uniform disc there is the uniform projection here.
    #[inline]
    pub fn entry_uniform(&self, dir: DVec3, u1: f64, u2: f64) -> (DVec3, DVec3) {
        let e = (dir / self.axes()).normalize();
        let (m1, m2) = orthonormal(e);
        let (cos, sin) = cos_sin_turn(u2);
        let q = (m1 * cos + m2 * sin) * u1.sqrt() - e * (1.0 - u1).sqrt();
        (q * self.axes(), (q / self.axes()).normalize())
    }
}

impl Convex for Ellipsoid {
    #[inline]
    fn chord(&self, o: DVec3, d: DVec3) -> Option<Chord> {
        let (t_in, t_out) = self.roots(o, d).1?;
        Some(Chord { t_in, t_out, face_in: ShapeFace::Side, face_out: ShapeFace::Side })
    }

    #[inline]
    fn way_out(&self, o: DVec3, d: DVec3) -> (f64, ShapeFace) {
        let (mid, roots) = self.roots(o, d);
        (roots.map_or(2.0 * mid, |r| r.1), ShapeFace::Side)
    }

    #[inline]
    fn normal(&self, p: DVec3, _: ShapeFace) -> DVec3 {
        (p / self.axes() / self.axes()).normalize()
    }

    fn starts_inside(&self, o: DVec3, d: DVec3) -> bool {
        let (q, e) = (o / self.axes(), d / self.axes());
        starts_in_ball(q.length_squared(), q.dot(e))
    }

    #[inline]
    fn contains(&self, p: DVec3) -> bool {
        (p / self.axes()).length_squared() <= 1.0
    }
}
