//! Explicit bodies of a scene as regions of the synthetic universe.

use super::model::{Body, Geometry, Synthetic};
use crate::math::{DVec3, Frame};
use crate::universe::BodyId;
use crate::universe::shape::{
    Cuboid, Ellipsoid, EllipticCylinder, HalfSpace, Placed, Shape, SlabZ, SlantedCylinder,
};
use crate::universe::synthetic::{Error, Part, Search, Setting, SyntheticUniverse};

/// The universe of an explicit scene; body numbers follow the list of bodies. A hollow fibre is two
/// parts of one body and one priority, the lumen second so that it wins inside.
pub fn universe(scene: &Synthetic) -> Result<SyntheticUniverse, Error> {
    let parts = scene.bodies.iter().enumerate().flat_map(|(i, body)| parts(body, BodyId(i as u32))).collect();
    let Some(cell) = scene.cell else { return SyntheticUniverse::new(scene.ambient, parts) };
    let setting = Setting {
        overlap: cell.overlap,
        sheet: Some(cell.planes),
        period: Some(cell.period),
        search: Search::Automatic,
    };
    SyntheticUniverse::with(scene.ambient, parts, setting)
}

fn parts(body: &Body, id: BodyId) -> Vec<Part> {
    let part =
        |shape, medium| Part { shape, medium, surface: body.surface, priority: body.priority, body: id };
    let mut parts = vec![part(placed(&body.geometry), body.material)];
    if let Geometry::Cylinder { centre, axis, major, half_length, lumen: Some(((a, b), medium)), .. } =
        body.geometry
    {
        let lumen = Shape::Cylinder(EllipticCylinder { a, b, half_length });
        parts.push(part(Placed::new(lumen, centre, frame(axis, major)), medium));
    }
    if let Geometry::Piece { centre, axis, major, shape, lumen: Some(((a, b), medium)) } = body.geometry {
        let hollow = Shape::Slanted(SlantedCylinder { a, b, ..shape });
        parts.push(part(Placed::new(hollow, centre, frame(axis, major)), medium));
    }
    parts
}

fn frame(axis: DVec3, major: DVec3) -> Frame {
    Frame::with_x_toward(axis, major)
}

fn placed(geometry: &Geometry) -> Placed {
    match *geometry {
        Geometry::Sphere { centre, radius } => {
            let world = Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
            Placed::new(Shape::Ellipsoid(Ellipsoid::sphere(radius)), centre, world)
        }
        Geometry::Ellipsoid { centre, half_axes: h, axis, major } => {
            Placed::new(Shape::Ellipsoid(Ellipsoid { a: h.x, b: h.y, c: h.z }), centre, frame(axis, major))
        }
        Geometry::Cylinder { centre, axis, major, half_axes: (a, b), half_length, .. } => {
            Placed::new(Shape::Cylinder(EllipticCylinder { a, b, half_length }), centre, frame(axis, major))
        }
        Geometry::Piece { centre, axis, major, shape, .. } => {
            Placed::new(Shape::Slanted(shape), centre, frame(axis, major))
        }
        Geometry::Box { min, max } => Placed::at_origin(Shape::Cuboid(Cuboid { min, max })),
        Geometry::Plane { point, normal } => {
            Placed::new(Shape::HalfSpace(HalfSpace), point, Frame::from_pole(normal))
        }
        Geometry::Slab { z_min, z_max } => Placed::at_origin(Shape::SlabZ(SlabZ { z_min, z_max })),
    }
}
