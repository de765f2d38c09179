//! The synthetic universe: chord laws, hard cases, and walks that lose no ray.
#![allow(clippy::disallowed_methods, missing_docs)]

#[path = "walking/mod.rs"]
mod walking;
#[path = "tables/harness.rs"]
#[allow(dead_code)]
mod harness;
#[path = "synthetic_universe/chords.rs"]
mod chords;
#[path = "synthetic_universe/drum.rs"]
mod drum;
#[path = "synthetic_universe/hard_cases.rs"]
mod hard_cases;
#[path = "synthetic_universe/many.rs"]
mod many;
#[path = "synthetic_universe/slanted.rs"]
mod slanted;
#[path = "synthetic_universe/union.rs"]
mod union;
#[path = "synthetic_universe/walks.rs"]
mod walks;

use lightpro::math::{DVec3, Frame, TAU};
use lightpro::rng::{Purpose, Stream};
use lightpro::universe::shape::{Cuboid, Ellipsoid, EllipticCylinder, Placed, Shape, SlabZ};
use lightpro::universe::synthetic::{Part, SyntheticUniverse};
use lightpro::universe::{BodyId, Interface, MediumId, Next, Ray, SurfaceId, Universe};
pub use walking::isotropic;

pub const AIR: MediumId = MediumId(0);
pub const WORLD: Frame = Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z };

pub fn stream(history: u64) -> Stream {
    Stream::of(4711, 0, history, Purpose::Probe)
}

pub fn random_frame(s: &mut Stream) -> Frame {
    let z = isotropic(s);
    let toward = isotropic(s);
    let f = Frame::with_x_toward(z, toward);
    Frame { x: f.x.normalize(), y: f.y.normalize(), z: f.z }
}

pub fn part(shape: Placed, medium: u16, body: u32) -> Part {
    Part { shape, medium: MediumId(medium), surface: SurfaceId::SMOOTH, priority: 0, body: BodyId(body) }
}

pub fn sphere(centre: DVec3, radius: f64) -> Placed {
    Placed::new(Shape::Ellipsoid(Ellipsoid::sphere(radius)), centre, WORLD)
}

pub fn cylinder(a: f64, b: f64, half_length: Option<f64>, centre: DVec3, frame: Frame) -> Placed {
    Placed::new(Shape::Cylinder(EllipticCylinder { a, b, half_length }), centre, frame)
}

pub fn slab(z_min: f64, z_max: f64) -> Placed {
    Placed::at_origin(Shape::SlabZ(SlabZ { z_min, z_max }))
}

pub fn cuboid(min: DVec3, max: DVec3) -> Placed {
    Placed::at_origin(Shape::Cuboid(Cuboid { min, max }))
}

pub fn universe(parts: Vec<Part>) -> SyntheticUniverse {
    SyntheticUniverse::new(AIR, parts).unwrap()
}

pub fn ray(origin: [f64; 3], dir: [f64; 3]) -> Ray {
    Ray { origin: DVec3::from_array(origin), dir: DVec3::from_array(dir) }
}

/// Runs straight through everything: the interfaces in order, with their absolute distances.
pub fn straight(u: &SyntheticUniverse, ray: Ray) -> Vec<(f64, Interface)> {
    let mut s = stream(0);
    let mut place = u.enter(&ray, &mut (), &mut s).place;
    let (mut met, mut r, mut gone) = (Vec::new(), ray, 0.0);
    while let Next::Interface(at) = u.next(&r, &mut place, &mut (), f64::INFINITY, &mut s) {
        gone += at.distance;
        r.origin = r.at(at.distance);
        u.crossed(&mut r, &mut place, &mut (), &at);
        met.push((gone, at));
        assert!(met.len() < 1000, "no end");
    }
    met
}
