//! The synthetic universe: bodies known explicitly.
//!
//! A body is one or more convex **regions** ([`Part`]); a hollow fibre is its outer cylinder and,
//! next in the list, its lumen. The **owner** of a point is the region of highest priority that
//! contains it, the later one at equal priority; the point's medium is the owner's, or the ambient
//! medium. A ray carries the set of regions that contain it ([`Place`]) and never asks a point test
//! for it again: rounding cannot move a ray into another medium.
//!
//! A surface is an interface where the owner changes. It is buried, and no event, where the owner
//! stays, or where the media on both sides are the same and the surface is smooth. Surfaces at
//! exactly the same distance (a plane shared by two layers, the open end of a tube) are crossed at
//! once: there is no film of zero thickness between bodies in contact.
//!
//! Horizontal planes of [`SlabZ`](super::shape::SlabZ) and of boxes [`Placed::at_origin`] are met at
//! (z_plane − z)/u_z as written; another implementation with the same expression gets the same bits.

mod place;

pub use place::{CAPACITY, Place};

use super::shape::{Placed, Shape};
use super::{BodyId, Face, Interface, MediumId, Next, Ray, Start, SurfaceId, Universe};
use crate::math::DVec3;
use crate::rng::Stream;
use place::{Group, NONE, Set};

/// One convex region of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Shape at its place, µm.
    pub shape: Placed,
    /// Medium inside.
    pub medium: MediumId,
    /// Law of its surface.
    pub surface: SurfaceId,
    /// Higher wins where regions overlap; the later part wins at equal priority.
    pub priority: i32,
    /// Body that it belongs to.
    pub body: BodyId,
}

/// A part that no universe can be built from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// A length, position or direction is NaN or infinite, or a length is negative.
    #[error("part {0}: sizes must be finite and not negative, positions finite")]
    Size(usize),
    /// Frame not orthonormal within 1e-12.
    #[error("part {0}: its axes are not unit and orthogonal")]
    Frame(usize),
    /// More parts than a region number can tell.
    #[error("{0} parts are too many")]
    TooMany(usize),
}

/// Which regions a ray may meet. Now: all of them. A grid answers here with the regions of the
/// cells along the ray; it must always include those that contain the origin.
#[derive(Clone, Debug)]
struct Index {
    regions: u32,
}

impl Index {
    #[inline]
    fn candidates(&self, _ray: &Ray) -> std::ops::Range<u32> {
        0..self.regions
    }
}

/// Explicit bodies in an unbounded ambient medium.
#[derive(Clone, Debug)]
pub struct SyntheticUniverse {
    ambient: MediumId,
    /// Ascending priority: of two regions the one with the higher number owns a common point.
    regions: Vec<Part>,
    index: Index,
}

impl SyntheticUniverse {
    /// A universe of `parts` in `ambient`. Parts without volume (a length of exactly 0: no lumen, a
    /// collapsed one) contain nothing and are left out.
    pub fn new(ambient: MediumId, parts: Vec<Part>) -> Result<Self, Error> {
        if parts.len() >= (NONE >> 1) as usize {
            return Err(Error::TooMany(parts.len()));
        }
        for (i, part) in parts.iter().enumerate() {
            check(i, &part.shape)?;
        }
        let mut regions: Vec<Part> =
            parts.into_iter().filter(|p| p.shape.shape.extents().iter().all(|&e| e > 0.0)).collect();
        regions.sort_by_key(|p| p.priority);
        let index = Index { regions: regions.len() as u32 };
        Ok(SyntheticUniverse { ambient, regions, index })
    }

    /// Medium at a point, by containment (surfaces count as inside): for checks and pictures.
    pub fn medium_at(&self, point: DVec3) -> MediumId {
        self.regions.iter().rfind(|r| r.shape.contains(point)).map_or(self.ambient, |r| r.medium)
    }

    /// Medium that a ray is in where [`Universe::enter`], `moved`, `crossed` or `reflected` left it.
    pub fn medium(&self, place: &Place) -> MediumId {
        self.medium_of(place.inside.top())
    }

    #[inline]
    fn medium_of(&self, owner: Option<u32>) -> MediumId {
        owner.map_or(self.ambient, |r| self.regions[r as usize].medium)
    }

    /// Where the ray of `place` still has to enter region `r` (−∞ if it is inside) and to leave it,
    /// judged from the state at the ray's origin; `None` if it meets neither.
    #[inline]
    fn crossings(&self, ray: &Ray, place: &Place, r: u32) -> Option<(f64, f64)> {
        let shape = &self.regions[r as usize].shape;
        if place.inside.contains(r) {
            Some((f64::NEG_INFINITY, shape.way_out(ray)))
        } else if place.left == r {
            None // convex, and just left
        } else {
            shape.way_through(ray).map(|c| (c.t_in, c.t_out))
        }
    }

    /// The nearest surfaces beyond the distance `after` and within `limit`: all those at exactly the
    /// same distance.
    #[inline]
    fn nearest(&self, ray: &Ray, place: &Place, after: f64, limit: f64) -> Option<Group> {
        let mut group = Group::new(limit);
        for r in self.index.candidates(ray) {
            if let Some((t_in, t_out)) = self.crossings(ray, place, r) {
                if t_in > after {
                    group.offer(t_in, r, true);
                } else if t_out > after {
                    group.offer(t_out, r, false);
                }
            }
        }
        group.found().then_some(group)
    }

    /// Regions around the ray of `place` at distance `t`, crossings at `t` itself included or not.
    fn set_at(&self, place: &Place, t: f64, inclusive: bool) -> Option<Set> {
        let passed = |x: f64| x < t || (inclusive && x == t);
        let mut set = Set::default();
        for r in self.index.candidates(&place.ray) {
            if let Some((t_in, t_out)) = self.crossings(&place.ray, place, r)
                && passed(t_in)
                && !passed(t_out)
            {
                set.insert(r)?;
            }
        }
        Some(set)
    }

    /// The surface that separates the media where the owner changes from `before` to `after`: that
    /// of the higher region, seen the same from both sides. `None` if it is buried.
    #[inline]
    fn separates(&self, before: Option<u32>, after: Option<u32>) -> Option<u32> {
        if before == after {
            return None;
        }
        let surface = before.max(after)?;
        let same = self.medium_of(before) == self.medium_of(after);
        (!same || self.regions[surface as usize].surface != SurfaceId::SMOOTH).then_some(surface)
    }

    /// The interface with region `r`, at `t`.
    #[inline]
    fn interface(&self, ray: &Ray, t: f64, r: u32, enters: bool, beyond: MediumId) -> Interface {
        let region = &self.regions[r as usize];
        let normal = against(ray.dir, region.shape.normal(ray, t, enters), enters);
        let axis = match region.shape.shape {
            Shape::Cylinder(_) => region.shape.frame.z,
            _ => DVec3::ZERO,
        };
        Interface {
            distance: t,
            normal,
            facet: normal,
            axis,
            beyond,
            surface: region.surface,
            body: region.body,
        }
    }
}

/// The unit normal against the ray. Where a grazing hit leaves the normal on the wrong side by
/// rounding, it is turned to the right one by twice as much (at least by the rounding of a dot
/// product, 4 ε, so that the result is surely against the ray).
#[inline]
fn against(dir: DVec3, outward: DVec3, enters: bool) -> DVec3 {
    let n = if enters { outward } else { -outward };
    let cos = n.dot(dir);
    if cos >= 0.0 { (n - dir * (cos + cos.max(4.0 * f64::EPSILON))).normalize() } else { n }
}

/// Sizes, position and axes of part `i`.
fn check(i: usize, placed: &Placed) -> Result<(), Error> {
    let finite = placed.centre.is_finite()
        && match placed.shape {
            Shape::Cuboid(b) => b.min.is_finite() && b.max.is_finite(),
            Shape::SlabZ(s) => s.z_min.is_finite() && s.z_max.is_finite(),
            _ => true,
        };
    if !finite || !placed.shape.extents().iter().all(|e| e.is_finite() && *e >= 0.0) {
        return Err(Error::Size(i));
    }
    let f = &placed.frame;
    let off = [
        f.x.length_squared() - 1.0,
        f.y.length_squared() - 1.0,
        f.z.length_squared() - 1.0,
        f.x.dot(f.y),
        f.y.dot(f.z),
        f.z.dot(f.x),
    ];
    if off.iter().all(|e| e.abs() <= 1e-12) { Ok(()) } else { Err(Error::Frame(i)) }
}

impl Universe for SyntheticUniverse {
    type Memory = ();
    type Place = Place;

    fn forget(&self, _: &mut ()) {}

    /// A point exactly on a surface is inside if the ray goes in; on the plane of a slab or half space,
    /// where sheets are lit, it still stands before the plane and meets it at distance 0.
    fn enter(&self, ray: &Ray, _: &mut (), _: &mut Stream) -> Start<Place> {
        let mut place = Place::new(*ray);
        for r in 0..self.index.regions {
            let shape = &self.regions[r as usize].shape;
            if shape.starts_inside(ray) && !shape.meets_at_start(ray) && place.inside.insert(r).is_none() {
                place.lost = true;
            }
        }
        Start { place, medium: self.medium(&place) }
    }

    fn next(&self, ray: &Ray, place: &mut Place, _: &mut (), limit: f64, _: &mut Stream) -> Next {
        place.look(*ray);
        if place.lost || !ray.origin.is_finite() || !ray.dir.is_finite() {
            return Next::Lost;
        }
        let mut set = place.inside;
        let mut after = f64::NEG_INFINITY;
        while let Some(group) = self.nearest(ray, place, after, limit) {
            let before = set.top();
            if group.apply(&mut set).is_none() {
                return Next::Lost;
            }
            let first = place.quiet == f64::INFINITY;
            if first {
                place.quiet = group.distance;
            }
            if let Some(r) = self.separates(before, set.top()) {
                let enters = set.contains(r);
                place.await_interface(group.distance, r, first && group.single());
                return Next::Interface(self.interface(
                    ray,
                    group.distance,
                    r,
                    enters,
                    self.medium_of(set.top()),
                ));
            }
            after = group.distance;
        }
        if limit < f64::INFINITY {
            return Next::Limit;
        }
        let face = if ray.dir.z < 0.0 { Face::Bottom } else { Face::Top };
        Next::Edge { face, distance: f64::INFINITY }
    }

    fn moved(&self, ray: &Ray, place: &mut Place, _: &mut (), d: f64) {
        if place.quiet <= d {
            // Buried surfaces were passed on the way, but never the interface itself.
            let inclusive = d < place.distance;
            let set = self.set_at(place, d.min(place.distance), inclusive);
            place.settle(set, NONE, *ray);
        } else {
            place.settle(Some(place.inside), NONE, *ray);
        }
    }

    fn reflected(&self, ray: &Ray, place: &mut Place, _: &mut (), _at: &Interface) {
        let before = if place.quiet < place.distance {
            self.set_at(place, place.distance, false)
        } else {
            Some(place.inside)
        };
        let region = place.region;
        // Still outside the region: it cannot be met again before another event.
        let left = if before.is_some_and(|s| s.contains(region)) { NONE } else { region };
        place.settle(before, left, *ray);
    }

    fn crossed(&self, ray: &mut Ray, place: &mut Place, _: &mut (), _at: &Interface) {
        let region = place.region;
        if region == NONE {
            place.lost = true; // nothing lay ahead: no answer is right
            return;
        }
        let beyond = if place.single {
            let mut set = place.inside;
            set.toggle(region).map(|()| set)
        } else {
            self.set_at(place, place.distance, true)
        };
        let left = if beyond.is_some_and(|s| s.contains(region)) { NONE } else { region };
        place.settle(beyond, left, *ray);
    }
}
