//! The planes of a sheet: layers over depth, faces, and the distance to the next plane.

use super::{Face, MediumId, Ray, SurfaceId};

/// A layer between two horizontal planes, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slab {
    /// Upper plane.
    pub top: f64,
    /// Lower plane.
    pub bottom: f64,
    /// Medium (between the bodies, if it holds any).
    pub pore: MediumId,
    /// Law of the upper plane.
    pub surface: SurfaceId,
}

/// Heights between which nothing is met, µm; see [`super::Universe::room`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// Upper plane.
    pub top: f64,
    /// Lower plane.
    pub bottom: f64,
}

impl Room {
    /// No room at all.
    pub const NONE: Room = Room { top: f64::NEG_INFINITY, bottom: f64::INFINITY };
}

/// Distance along `ray` to the plane ahead and which one it is: (z_plane − z)/u_z, never negative;
/// infinite for a ray in the plane. Every universe uses this one expression, so that the same slab
/// gives the same bits in each.
#[inline]
pub fn plane_ahead(ray: &Ray, top: f64, bottom: f64) -> (f64, Face) {
    let uz = ray.dir.z;
    if uz == 0.0 {
        return (f64::INFINITY, Face::Top);
    }
    // A choice of values, not of ways: up or down cannot be foreseen.
    let (plane, face) = if uz < 0.0 { (bottom, Face::Bottom) } else { (top, Face::Top) };
    (((plane - ray.origin.z) / uz).max(0.0), face)
}
