//! Convex shapes in their own frame, and the exact meeting of a ray with them.
//!
//! No test here knows an epsilon. What a ray may meet follows from its **state**, which the caller
//! keeps: a ray inside a convex shape leaves it at the larger root, always; a ray outside that has
//! just left the shape cannot meet it again; any other ray outside meets the smaller root if it
//! approaches the closest point of the line. Rounding may put a point a few ulp on the wrong side of
//! a surface: the state decides, the distance is then 0.
//!
//! Accuracy: the line is first moved to its closest approach (in the space where the shape is the
//! unit ball), then half the chord is added. The hit stays within ~4 ε |o| of the surface for an
//! origin at distance |o| (1e-9 of the radius at 10⁶ radii).

mod cylinder;
mod ellipsoid;
pub mod height;
pub mod integral;
mod plane;
mod slanted;

pub use cylinder::EllipticCylinder;
pub use ellipsoid::Ellipsoid;
pub use plane::{Cuboid, HalfSpace, SlabZ};
pub use slanted::SlantedCylinder;

use crate::math::frame::renormalise;
use crate::math::{DVec3, Frame};
use crate::universe::Ray;

/// Which face of a shape a point lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeFace {
    /// Curved surface of a cylinder or an ellipsoid.
    Side,
    /// Plane with outward normal +z: upper cap, upper face.
    CapTop,
    /// Plane with outward normal −z.
    CapBottom,
    /// Face of a cuboid with outward normal −x.
    XMin,
    /// Face of a cuboid with outward normal +x.
    XMax,
    /// Face of a cuboid with outward normal −y.
    YMin,
    /// Face of a cuboid with outward normal +y.
    YMax,
}

/// The part of a whole line that lies in a convex shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chord {
    /// Where the line enters, µm along the direction; −∞ if it never does.
    pub t_in: f64,
    /// Where it leaves; ∞ if it never does.
    pub t_out: f64,
    /// Face at `t_in`.
    pub face_in: ShapeFace,
    /// Face at `t_out`.
    pub face_out: ShapeFace,
}

/// A ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance, µm, ≥ 0; ∞ where a ray inside an unbounded shape never leaves.
    pub t: f64,
    /// Outward unit normal (of the shape, whichever way the ray goes); zero where `t` is ∞.
    pub normal: DVec3,
    /// Face that is hit.
    pub face: ShapeFace,
}

/// `t`, but never below +0.
#[inline]
fn not_before(t: f64) -> f64 {
    if t > 0.0 { t } else { 0.0 }
}

/// Whether a point where the form q·q takes the value `qq` lies in the unit ball; on its surface, if
/// it moves inwards (`od` = q·e < 0).
#[inline]
fn starts_in_ball(qq: f64, od: f64) -> bool {
    qq < 1.0 || (qq == 1.0 && od < 0.0)
}

/// A convex shape in local coordinates, µm. Directions are unit vectors.
pub trait Convex {
    /// The part of the whole line inside the shape (both roots, `t` of any sign), or `None`.
    fn chord(&self, origin: DVec3, dir: DVec3) -> Option<Chord>;

    /// Where a ray **known to be inside** leaves, unclamped, and through which face. Never fails: a
    /// line that misses by rounding starts on the surface, and leaves at twice its closest approach.
    fn way_out(&self, origin: DVec3, dir: DVec3) -> (f64, ShapeFace);

    /// Outward unit normal at a point of the given face.
    fn normal(&self, point: DVec3, face: ShapeFace) -> DVec3;

    /// Whether a point lies inside or on the surface.
    fn contains(&self, point: DVec3) -> bool;

    /// Whether a ray that starts at `origin` starts inside; exactly on the surface: if it goes in.
    fn starts_inside(&self, origin: DVec3, dir: DVec3) -> bool;

    /// Both roots of the whole line.
    #[inline]
    fn span(&self, origin: DVec3, dir: DVec3) -> Option<(f64, f64)> {
        self.chord(origin, dir).map(|c| (c.t_in, c.t_out))
    }

    /// Chord of a ray **known to be outside** that it has still to run through: `t_in` ≥ 0 and
    /// `t_in` < `t_out`. A point that rounding put behind the surface is about to enter where
    /// the middle of the chord lies ahead (distance 0), and has left where it lies behind.
    #[inline]
    fn way_through(&self, origin: DVec3, dir: DVec3) -> Option<Chord> {
        let mut c = self.chord(origin, dir)?;
        // −∞ + ∞ = NaN (line in an unbounded shape, parallel to it): never met from outside.
        let ahead = c.t_in + c.t_out > 0.0;
        c.t_in = not_before(c.t_in);
        (ahead && c.t_in < c.t_out).then_some(c)
    }

    /// [`Self::way_out`], never before the start.
    #[inline]
    fn leaves(&self, origin: DVec3, dir: DVec3) -> (f64, ShapeFace) {
        let (t, face) = self.way_out(origin, dir);
        (not_before(t), face)
    }

    /// First hit of a ray outside; `just_left`: it starts on this very shape.
    #[inline]
    fn entry(&self, origin: DVec3, dir: DVec3, just_left: bool) -> Option<Hit> {
        if just_left {
            return None;
        }
        let c = self.way_through(origin, dir)?;
        Some(Hit { t: c.t_in, normal: self.normal(origin + dir * c.t_in, c.face_in), face: c.face_in })
    }

    /// Where a ray inside leaves.
    #[inline]
    fn exit(&self, origin: DVec3, dir: DVec3) -> Hit {
        let (t, face) = self.way_out(origin, dir);
        let t = not_before(t);
        let normal = if t < f64::INFINITY { self.normal(origin + dir * t, face) } else { DVec3::ZERO };
        Hit { t, normal, face }
    }
}

/// Any convex shape, in local coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Cylinder of elliptic section along z.
    Cylinder(EllipticCylinder),
    /// Piece of a bent fibre along z, rising in y.
    Slanted(SlantedCylinder),
    /// Ellipsoid along the axes.
    Ellipsoid(Ellipsoid),
    /// Box along the axes.
    Cuboid(Cuboid),
    /// z ≤ 0.
    HalfSpace(HalfSpace),
    /// z_min ≤ z ≤ z_max.
    SlabZ(SlabZ),
}

macro_rules! each {
    ($shape:expr, $s:ident => $call:expr) => {
        match $shape {
            Shape::Cylinder($s) => $call,
            Shape::Slanted($s) => $call,
            Shape::Ellipsoid($s) => $call,
            Shape::Cuboid($s) => $call,
            Shape::HalfSpace($s) => $call,
            Shape::SlabZ($s) => $call,
        }
    };
}

impl Convex for Shape {
    #[inline]
    fn chord(&self, origin: DVec3, dir: DVec3) -> Option<Chord> {
        each!(self, s => s.chord(origin, dir))
    }
    #[inline]
    fn way_out(&self, origin: DVec3, dir: DVec3) -> (f64, ShapeFace) {
        each!(self, s => s.way_out(origin, dir))
    }
    #[inline]
    fn way_through(&self, origin: DVec3, dir: DVec3) -> Option<Chord> {
        each!(self, s => s.way_through(origin, dir))
    }
    #[inline]
    fn normal(&self, point: DVec3, face: ShapeFace) -> DVec3 {
        each!(self, s => s.normal(point, face))
    }
    #[inline]
    fn contains(&self, point: DVec3) -> bool {
        each!(self, s => s.contains(point))
    }
    fn starts_inside(&self, origin: DVec3, dir: DVec3) -> bool {
        each!(self, s => s.starts_inside(origin, dir))
    }
}

impl Shape {
    /// [`Convex::way_through`] of a hollow whose flat ends are those of its body, for a ray that its state
    /// puts into the body: it enters through the side. Judged by the point, a ray that slides along the
    /// common end and that rounding put behind it would enter through the end.
    #[inline]
    pub(in crate::universe) fn way_through_side(&self, o: DVec3, d: DVec3) -> Option<Chord> {
        match self {
            Shape::Cylinder(s) => EllipticCylinder { half_length: None, ..*s }.way_through(o, d),
            Shape::Slanted(s) => s.way_through_side(o, d),
            _ => self.way_through(o, d),
        }
    }

    /// Extents that must be positive and finite for the shape to have a volume, µm.
    pub fn extents(&self) -> [f64; 3] {
        match self {
            Shape::Cylinder(s) => [s.a, s.b, s.half_length.unwrap_or(1.0)],
            Shape::Slanted(s) => [s.a, s.b, s.to - s.from],
            Shape::Ellipsoid(s) => [s.a, s.b, s.c],
            Shape::Cuboid(s) => (s.max - s.min).to_array(),
            Shape::HalfSpace(_) => [1.0; 3],
            Shape::SlabZ(s) => [s.z_max - s.z_min, 1.0, 1.0],
        }
    }
}

/// A shape at its place: local point = frameᵀ (world point − centre).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// The shape.
    pub shape: Shape,
    /// Origin of its frame, µm.
    pub centre: DVec3,
    /// Its axes, orthonormal.
    pub frame: Frame,
    turned: bool,
}

impl Placed {
    /// A shape with its local origin at `centre` and its local axes along `frame` (orthonormal).
    pub fn new(shape: Shape, centre: DVec3, frame: Frame) -> Self {
        let turned = frame != Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
        Placed { shape, centre, frame, turned }
    }

    /// A shape whose local coordinates are those of the world: local and world distances then
    /// agree bit for bit (a horizontal plane is met at (z_plane − z)/u_z).
    pub fn at_origin(shape: Shape) -> Self {
        Self::new(shape, DVec3::ZERO, Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z })
    }

    /// The ray in local coordinates.
    #[inline]
    pub fn local(&self, ray: &Ray) -> (DVec3, DVec3) {
        let o = ray.origin - self.centre;
        if self.turned { (self.frame.to_local(o), self.frame.to_local(ray.dir)) } else { (o, ray.dir) }
    }

    /// [`Convex::starts_inside`] in the world.
    pub fn starts_inside(&self, ray: &Ray) -> bool {
        let (o, d) = self.local(ray);
        self.shape.starts_inside(o, d)
    }

    /// Whether a ray starts exactly on the plane of a slab or half space that it is about to enter.
    pub fn meets_at_start(&self, ray: &Ray) -> bool {
        let (o, d) = self.local(ray);
        matches!(self.shape, Shape::SlabZ(_) | Shape::HalfSpace(_))
            && self.shape.chord(o, d).is_some_and(|c| c.t_in == 0.0)
    }

    /// [`Convex::way_through`] in the world.
    #[inline]
    pub fn way_through(&self, ray: &Ray) -> Option<Chord> {
        let (o, d) = self.local(ray);
        self.shape.way_through(o, d)
    }

    /// Where a ray known to be inside leaves, ≥ 0, ∞ if never.
    #[inline]
    pub fn way_out(&self, ray: &Ray) -> f64 {
        let (o, d) = self.local(ray);
        not_before(self.shape.way_out(o, d).0)
    }

    /// The same, with the face that is met there.
    #[inline]
    pub fn way_out_face(&self, ray: &Ray) -> (f64, ShapeFace) {
        let (o, d) = self.local(ray);
        let (t, face) = self.shape.way_out(o, d);
        (not_before(t), face)
    }

    /// Outward unit normal at distance `t`, on the given face.
    #[inline]
    pub fn normal_on(&self, ray: &Ray, t: f64, face: ShapeFace) -> DVec3 {
        let (o, d) = self.local(ray);
        let n = self.shape.normal(o + d * t, face);
        if self.turned { renormalise(self.frame.to_world(n)) } else { n }
    }

    /// Whether a point lies inside or on the surface.
    #[inline]
    pub fn contains(&self, point: DVec3) -> bool {
        let o = point - self.centre;
        self.shape.contains(if self.turned { self.frame.to_local(o) } else { o })
    }
}
