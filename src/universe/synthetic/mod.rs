//! The synthetic universe: bodies known explicitly.
//!
//! A body is one or more convex **regions** ([`Part`]); a hollow fibre is its outer cylinder and,
//! next in the list, its lumen. The **owner** of a point follows from the [`Overlap`] rule; the
//! point's medium is the owner's, or the ambient medium. A ray carries the set of regions that
//! contain it ([`Place`]) and never asks a point test for it again: rounding cannot move a ray into
//! another medium.
//!
//! A surface is an interface where the owner changes. It is buried, and no event, where the owner
//! stays, or where the media on both sides are the same and the surface is smooth. Surfaces at
//! exactly the same distance (a plane shared by two layers, the open end of a tube) are crossed at
//! once: there is no film of zero thickness between bodies in contact.
//!
//! Many bodies are searched through a uniform grid or a hierarchy of boxes ([`Search`]); the answers
//! are the same bits as those of a search one by one.
//!
//! Horizontal planes of [`SlabZ`](super::shape::SlabZ) and of boxes [`Placed::at_origin`] are met at
//! (z_plane − z)/u_z as written; another implementation with the same expression gets the same bits.

mod bvh;
pub mod drum;
pub mod ensemble;
mod flight;
mod grid;
mod index;
mod place;
pub mod realise;
mod region;
pub mod stack;

pub use index::Search;
pub use place::{CAPACITY, Displaced, Place};

use super::shape::{Placed, Shape};
use super::sheet::plane_ahead;
use super::{BodyId, Face, Interface, MediumId, Next, Overlap, Ray, Start, SurfaceId, Universe};
use crate::math::DVec3;
use crate::rng::Stream;
use flight::{Asker, Found, Space};
use index::Index;
use place::Group;
use region::{Key, Region, Rule};

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

/// How bodies are put together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Who owns a point that several bodies cover; marks are the parts' priorities, the later part goes
    /// before at equal priority. A **hollow** is a part right behind a part of the same body and priority
    /// that lies concentric within it (a fibre's lumen). With `Union`, hollows and bodies of the ambient
    /// medium lose to every solid; walls of the same medium merge, whatever their surfaces, and so do
    /// hollows and pores.
    pub overlap: Overlap,
    /// Lower and upper plane of a sheet, µm: there is no surface there, rays leave, also from inside a
    /// body (`cut`). `None`: unbounded.
    pub sheet: Option<[f64; 2]>,
    /// The scene repeats itself along x and y with these periods, µm. No ray leaves sideways, and
    /// none is moved: positions stay where they are, the bodies' images differ by whole multiples of
    /// the periods.
    pub period: Option<[f64; 2]>,
    /// How bodies are searched.
    pub search: Search,
}

impl Default for Setting {
    /// Bodies by priority, in unbounded space.
    fn default() -> Self {
        Setting { overlap: Overlap::Priority, sheet: None, period: None, search: Search::default() }
    }
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
    /// A part without end, or longer than two periods, in a periodic scene.
    #[error("part {0}: too long for the period of the scene (at most two periods; slabs excepted)")]
    TooLong(usize),
    /// A period or the thickness of the sheet is not positive and finite.
    #[error("periods must be positive and finite, and the sheet's upper plane above its lower one")]
    Setting,
}

/// Explicit bodies in an ambient medium.
#[derive(Clone, Debug)]
pub struct SyntheticUniverse {
    rule: Rule,
    /// Ascending priority: of two regions the one with the higher number owns a common point.
    regions: Vec<Region>,
    index: Box<Index>,
    sheet: Option<[f64; 2]>,
    period: [f64; 2],
}

impl SyntheticUniverse {
    /// A universe of `parts` in `ambient`, unbounded, overlaps by priority. Parts without volume (a
    /// length of exactly 0: no lumen, a collapsed one) contain nothing and are left out.
    ///
    /// # Errors
    /// [`Error`] where a part makes no sense.
    pub fn new(ambient: MediumId, parts: Vec<Part>) -> Result<Self, Error> {
        Self::with(ambient, parts, Setting::default())
    }

    /// A universe of `parts` in `ambient`, put together as `setting` says.
    ///
    /// # Errors
    /// [`Error`] where a part or the setting makes no sense.
    pub fn with(ambient: MediumId, parts: Vec<Part>, setting: Setting) -> Result<Self, Error> {
        if parts.len() >= region::MOST {
            return Err(Error::TooMany(parts.len()));
        }
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if !setting.period.iter().flatten().all(|&p| positive(p))
            || !setting.sheet.iter().all(|s| s[0].is_finite() && positive(s[1] - s[0]))
        {
            return Err(Error::Setting);
        }
        for (i, part) in parts.iter().enumerate() {
            check(i, &part.shape)?;
            if let Some(period) = setting.period {
                check_length(i, &part.shape, period)?;
            }
        }
        let mut parts: Vec<Part> =
            parts.into_iter().filter(|p| p.shape.shape.extents().iter().all(|&e| e > 0.0)).collect();
        parts.sort_by_key(|p| p.priority);
        let mut regions: Vec<Region> =
            parts.into_iter().enumerate().map(|(i, p)| Region::new(p, i as u32)).collect();
        region::pair_hollows(&mut regions, 0);
        let index = Box::new(Index::new(&regions, setting.search, setting.period));
        Ok(SyntheticUniverse {
            rule: Rule { overlap: setting.overlap, ambient },
            regions,
            index,
            sheet: setting.sheet,
            period: setting.period.unwrap_or_default(),
        })
    }

    /// Medium at a point, by containment (surfaces count as inside): for checks and pictures.
    pub fn medium_at(&self, point: DVec3) -> MediumId {
        let mut keys = Vec::new();
        let ray = Ray { origin: point, dir: DVec3::Z };
        let contains = |key: Key| {
            let seen = region::seen_from(&ray, key, self.period);
            self.regions[key.region()].part.shape.contains(seen.origin)
        };
        self.index.around(point, |key| {
            if contains(key) {
                keys.push(key);
                keys.extend(self.regions[key.region()].hollow().map(|h| key.of(h)).filter(|h| contains(*h)));
            }
        });
        self.rule.owner(&keys, |k| &self.regions[k.region()]).medium
    }

    /// Medium around the bodies.
    pub fn ambient(&self) -> MediumId {
        self.rule.ambient
    }

    /// Periods along x and y, µm; 0 without.
    pub fn period(&self) -> [f64; 2] {
        self.period
    }

    /// Lower and upper plane of the sheet, µm, if it has any.
    pub fn sheet(&self) -> Option<[f64; 2]> {
        self.sheet
    }

    /// [`Universe::enter`], which asks no chance here.
    pub(in crate::universe) fn enter_still(&self, ray: &Ray) -> Start<Place> {
        let place = flight::start(&mut Still(self), ray);
        Start { place, medium: self.medium(&place) }
    }

    /// The bodies, each with its hollow, in ascending rank.
    pub fn bodies(&self) -> impl Iterator<Item = (Part, Option<Part>)> + '_ {
        let outer = self.regions.iter().filter(|r| !r.is_hole());
        outer.map(|r| (r.part, r.hollow().map(|h| self.regions[h as usize].part)))
    }

    /// Number of bodies, hollows counted.
    pub fn count(&self) -> usize {
        self.regions.len()
    }

    /// Thickness of the thinnest body, or of its wall where it is hollow, µm.
    pub fn thinnest(&self) -> f64 {
        let least = |p: &Part| p.shape.shape.extents().into_iter().fold(f64::INFINITY, f64::min);
        let of = |(body, hollow): (Part, Option<Part>)| match hollow {
            Some(hollow) => least(&body) - least(&hollow),
            None => 2.0 * least(&body),
        };
        self.bodies().map(of).fold(f64::INFINITY, f64::min)
    }

    /// Numbers (in the order of [`Self::bodies`] with hollows counted) of the bodies whose solid or hollow
    /// covers a point.
    pub fn bodies_at(&self, point: DVec3) -> Vec<usize> {
        let ray = Ray { origin: point, dir: DVec3::Z };
        let mut found = Vec::new();
        self.index.around(point, |key| {
            let seen = region::seen_from(&ray, key, self.period);
            if self.regions[key.region()].part.shape.contains(seen.origin) {
                found.push(key.region());
            }
        });
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Medium that a ray is in where [`Universe::enter`], `moved`, `crossed` or `reflected` left it.
    pub fn medium(&self, place: &Place) -> MediumId {
        self.rule.owner(place.inside.items(), |k| &self.regions[k.region()]).medium
    }

    /// How the bodies are searched, in words: for the plan.
    pub fn describe_search(&self) -> String {
        self.index.describe()
    }

    /// Memory of bodies and index, bytes.
    pub fn bytes(&self) -> usize {
        self.regions.capacity() * size_of::<Region>() + self.index.bytes()
    }
}

/// Lower and upper corner of the box about a placed shape, µm, infinite where it has no end; `None` for half
/// spaces and slabs.
pub fn corners(shape: &Placed) -> Option<(DVec3, DVec3)> {
    region::Extent::of(shape).map(|e| e.corners())
}

/// Sizes, position and axes of part `i`.
fn check(i: usize, placed: &Placed) -> Result<(), Error> {
    let finite = placed.centre.is_finite()
        && match placed.shape {
            Shape::Cuboid(b) => b.min.is_finite() && b.max.is_finite(),
            Shape::SlabZ(s) => s.z_min.is_finite() && s.z_max.is_finite(),
            Shape::Slanted(s) => [s.from, s.to, s.height, s.slope].iter().all(|x| x.is_finite()),
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

/// Images of a part −4…3 periods away can be told apart; slabs have none.
fn check_length(i: usize, placed: &Placed, period: [f64; 2]) -> Result<(), Error> {
    let far = match region::Extent::of(placed) {
        None => !matches!(placed.shape, Shape::SlabZ(_)),
        Some(e) => {
            let (lo, hi) = e.corners();
            (0..2).any(|axis| {
                let p = period[axis];
                hi[axis] - lo[axis] > 2.0 * p || lo[axis] < -3.0 * p || hi[axis] > 3.0 * p
            })
        }
    };
    if far { Err(Error::TooLong(i)) } else { Ok(()) }
}

/// The space of a universe that does not change.
struct Still<'a>(&'a SyntheticUniverse);

impl Space for Still<'_> {
    type Cursor = Option<(grid::Walk, flight::Ahead)>;

    #[inline]
    fn rule(&self) -> Rule {
        self.0.rule
    }
    #[inline]
    fn region(&self, number: usize) -> &Region {
        &self.0.regions[number]
    }
    #[inline]
    fn period(&self) -> [f64; 2] {
        self.0.period
    }
    #[inline]
    fn search(&mut self, ray: &Ray) -> Self::Cursor {
        self.0.index.search(ray)
    }
    #[inline]
    fn entries(&mut self, cursor: &mut Self::Cursor, asker: &Asker, after: f64, group: &mut Group) {
        self.0.index.entries(&self.0.regions, cursor, asker, after, group);
    }
    fn around(&mut self, point: DVec3, mut tell: impl FnMut(&Self, Key)) {
        self.0.index.around(point, |key| tell(self, key));
    }
}

/// The next surface or plane of a sheet (if there is one) in any space.
fn next_in<S: Space>(
    space: &mut S,
    sheet: Option<[f64; 2]>,
    ray: &Ray,
    place: &mut Place,
    limit: f64,
) -> Next {
    place.look(*ray);
    if place.lost || !ray.origin.is_finite() || !ray.dir.is_finite() {
        return Next::Lost;
    }
    let (edge, face) = match sheet {
        Some([bottom, top]) => plane_ahead(ray, top, bottom),
        None => (f64::INFINITY, if ray.dir.z < 0.0 { Face::Bottom } else { Face::Top }),
    };
    match flight::fly(space, place, limit.min(edge), true) {
        Found::Lost => Next::Lost,
        Found::Met(met) if met.event.t < edge => Next::Interface(flight::interface(space, ray, &met)),
        _ if edge <= limit && (edge < f64::INFINITY || sheet.is_none()) => {
            Next::Edge { face, distance: edge }
        }
        Found::Nothing if limit < f64::INFINITY => Next::Limit,
        _ => Next::Lost, // along the planes of a sheet without end, and nothing there
    }
}

impl Universe for SyntheticUniverse {
    type Memory = ();
    type Place = Place;

    fn forget(&self, _: &mut ()) {}

    /// A point exactly on a surface is inside if the ray goes in; on the plane of a slab or half space,
    /// where sheets are lit, it still stands before the plane and meets it at distance 0.
    fn enter(&self, ray: &Ray, _: &mut (), _: &mut Stream) -> Start<Place> {
        self.enter_still(ray)
    }

    #[inline]
    fn next(&self, ray: &Ray, place: &mut Place, _: &mut (), limit: f64, _: &mut Stream) -> Next {
        next_in(&mut Still(self), self.sheet, ray, place, limit)
    }

    fn moved(&self, ray: &Ray, place: &mut Place, _: &mut (), d: f64) {
        flight::moved(&mut Still(self), place, ray, d);
    }

    fn reflected(&self, ray: &Ray, place: &mut Place, _: &mut (), _at: &Interface) {
        place.turn_back(*ray);
    }

    fn crossed(&self, ray: &mut Ray, place: &mut Place, _: &mut (), _at: &Interface) {
        place.go_on(*ray);
    }
}
