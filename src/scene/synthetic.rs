//! Explicit bodies of a scene as regions of the synthetic universe.

use super::build::topography::anywhere;
use super::model::{Body, Geometry, Scene, Synthetic};
use crate::math::{DVec3, Frame};
use crate::universe::shape::{
    Cuboid, Ellipsoid, EllipticCylinder, HalfSpace, Placed, Shape, SlabZ, SlantedCylinder,
};
use crate::universe::synthetic::{Error, Part, Search, Setting, SyntheticUniverse};
use crate::universe::topography::Topography;
use crate::universe::{BodyId, Face};

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

/// The bodies cut off by measured surfaces, and what `plan` has to say of these.
///
/// # Errors
/// Surfaces that do not fit each other or the bodies.
pub fn topography(
    s: &Synthetic,
    u: SyntheticUniverse,
    scene: &Scene,
) -> Result<(Topography, Vec<String>), String> {
    let [top, bottom] = s.skins.clone();
    let anywhere = anywhere(s.cell.is_some(), &s.bodies, s.random, &scene.source);
    let made = Topography::new(u, top, bottom, anywhere).map_err(|e| e.to_string())?;
    let told = [Face::Top, Face::Bottom].into_iter().filter_map(|face| describe(&made, face)).collect();
    Ok((made, told))
}

fn describe(made: &Topography, face: Face) -> Option<String> {
    let map = &made.skin(face)?.map;
    let ([nx, ny], [dx, dy]) = map.grid();
    let ([lowest, highest], (mean, rms, [sx, sy])) = (map.range(), map.roughness());
    // What stands just behind the surface, seen at the middles of cells.
    let (mut bare, step) = (0_u64, (nx * ny).div_ceil(10_000).max(1));
    let behind = if face == Face::Top { -1.0 } else { 1.0 } * 1e-6 * (highest - lowest).max(dx.min(dy));
    let looks: Vec<usize> = (0..nx * ny).step_by(step).collect();
    for &k in &looks {
        let at = [(k % nx) as f64 + 0.5, (k / nx) as f64 + 0.5];
        let (x, y) = (at[0] * dx, at[1] * dy);
        let point = DVec3::new(x, y, map.height(x, y) + behind);
        bare += u64::from(made.bodies().medium_at(point) == made.bodies().ambient());
    }
    let side = if face == Face::Top { "top" } else { "bottom" };
    let place = if made.anywhere() { "each history finds it displaced at random" } else { "standing still" };
    let mut out = format!(
        "surface on the {side}: {nx} x {ny} heights every {dx} x {dy} um, {lowest:.4} to {highest:.4} um, mean \
         {mean:.4}, rms (Sq) {rms:.4} um; rms slope {sx:.4} along x, {sy:.4} along y; {place}"
    );
    if bare > 0 {
        let share = 100.0 * bare as f64 / looks.len() as f64;
        out += &format!("; behind {share:.1} % of it there is no body: bodies end before it");
    }
    Some(out)
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
