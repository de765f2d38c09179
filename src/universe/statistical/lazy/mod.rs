//! Rungs with a memory: the lazy realisation of a Poisson (Boolean) ensemble.
//!
//! A Poisson process is independent on disjoint sets, so the bodies that meet no traced segment are
//! still Poisson, whatever the history has seen. For a flight from x along u:
//!
//! * candidates of unknown bodies arrive at rate Σ(u), in pores, walls and lumens alike, up to the first
//!   change of medium, the end of the free path, or the edge;
//! * a candidate that an earlier segment would have met is rejected: it would have been seen. Otherwise
//!   it is known from then on;
//! * the nearest surface among the known bodies is found exactly.
//!
//! With everything remembered (`memory="full"`) the mean over histories is the mean over all explicit
//! realisations. With the last k flights remembered (`memory="k"`) it climbs there from rung `none`; a
//! finite k is meant for bodies without volume scattering.
//!
//! Overlaps: [`Overlap::Union`], [`Overlap::Priority`], and [`Overlap::Forbid`], an approximation of hard
//! packing (candidates inside known bodies or across them are rejected).

mod flight;
mod groove;
mod memory;
pub mod overlap;

pub use memory::Memory;

use super::StatisticalUniverse;
use super::kind::Kind;
use super::section::Left;
use crate::math::DVec3;
use crate::rng::Stream;
use crate::universe::sheet::plane_ahead;
use crate::universe::{
    Face, Interface, Kept, MediumId, Next, Overlap, Ray, Start, SurfaceId, Universe, against,
};
use flight::Change;
use memory::{Known, NOTHING, Past, Solid};
use std::marker::PhantomData;

/// What exactness rests on. The defaults are right; tests plant each fault on purpose and show that it
/// is caught.
pub trait Exactness: Sync {
    /// Candidates arrive inside walls and lumens too.
    const CANDIDATES_INSIDE: bool = true;
    /// The whole body rejects, not its wall.
    const WHOLE_BODY_REJECTS: bool = true;
    /// Every earlier segment rejects, not only the last.
    const EVERY_SEGMENT_REJECTS: bool = true;
    /// The present flight rejects as well: wrong.
    const PRESENT_FLIGHT_REJECTS: bool = false;
    /// Bodies over the start are met like bodies on the way (axis by sin γ): wrong.
    const START_WEIGHTED: bool = false;
}

/// The exact rules.
#[derive(Clone, Copy, Debug)]
pub struct Exact;
impl Exactness for Exact {}

/// A statistical sheet that remembers.
#[derive(Clone, Debug)]
pub struct LazyUniverse<E = Exact> {
    sheet: StatisticalUniverse,
    overlap: Overlap,
    /// Flights remembered; `u32::MAX`: all.
    last: u32,
    /// Marks decide (several solids, or priority).
    marks: bool,
    /// The one solid of a sheet whose lumens are pores too, if that is all there is.
    only_wall: Option<MediumId>,
    exactness: PhantomData<E>,
}

/// Where a ray is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Place {
    layer: u16,
    outside: Option<Face>,
    medium: MediumId,
    stands: Option<Stands>,
    past: Past,
    /// Interfaces since a new body was met.
    stale: u32,
    answer: Option<Answer>,
}

/// The surface that a ray stands on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stands {
    body: u32,
    surface: Left,
    /// On the inner side of it.
    inside: bool,
}

/// What the last `next` has found.
#[derive(Clone, Copy, Debug)]
struct Answer {
    next: Next,
    met: Met,
}

#[derive(Clone, Copy, Debug)]
enum Met {
    Nothing,
    Plane(Face),
    Surface { body: u32, surface: Left, enters: bool },
}

/// Interfaces without a new body after which a finite memory forgets: it may have walled the ray into a
/// pocket that no sheet has.
const POCKET: u32 = 200;

impl LazyUniverse<Exact> {
    /// Remembers the last `last` flights of `sheet` (`None`: all).
    pub fn new(sheet: StatisticalUniverse, overlap: Overlap, last: Option<u32>) -> Self {
        Self::with_exactness(sheet, overlap, last)
    }
}

impl<E: Exactness> LazyUniverse<E> {
    /// The same by other rules.
    pub fn with_exactness(sheet: StatisticalUniverse, overlap: Overlap, last: Option<u32>) -> Self {
        let mut media: Vec<[MediumId; 2]> =
            sheet.layers.iter().flat_map(|l| l.kinds.iter().map(|k| [k.wall, k.lumen])).collect();
        media.dedup();
        let hollow_is_pore = sheet.layers.iter().all(|l| l.kinds.iter().all(|k| k.lumen == l.slab.pore));
        let only_wall = match media[..] {
            [[wall, _]] if hollow_is_pore && overlap != Overlap::Priority => Some(wall),
            _ => None,
        };
        let marks = overlap == Overlap::Priority || media.len() > 1;
        LazyUniverse {
            sheet,
            overlap,
            last: last.unwrap_or(u32::MAX),
            marks,
            only_wall,
            exactness: PhantomData,
        }
    }

    /// The sheet.
    pub fn sheet(&self) -> &StatisticalUniverse {
        &self.sheet
    }

    /// What lies ahead within `limit`.
    fn look(&self, ray: &Ray, place: &mut Place, m: &mut Memory, limit: f64, rng: &mut Stream) -> Answer {
        if let Some(face) = place.outside {
            return self.face_ahead(face, ray, place, m, rng);
        }
        if place.stale > POCKET && self.last != u32::MAX {
            self.leave_pocket(ray, place, m);
        }
        let slab = &self.sheet.layers[usize::from(place.layer)].slab;
        let (to_plane, face) = plane_ahead(ray, slab.top, slab.bottom);
        let nothing = |next| Answer { next, met: Met::Nothing };
        match self.fly(ray, place, m, limit.min(to_plane), rng) {
            Ok(Some(change)) => return self.surface(ray, &change, m),
            Ok(None) => {}
            Err(_) => return nothing(Next::Lost),
        }
        if to_plane <= limit && to_plane.is_finite() {
            return self.plane(face, to_plane, ray, place, m, rng);
        }
        nothing(if limit.is_finite() { Next::Limit } else { Next::Lost })
    }

    /// The surface of a body where the medium changes.
    fn surface(&self, ray: &Ray, change: &Change, m: &Memory) -> Answer {
        let body = &m.bodies[change.body as usize].body;
        let layer = usize::from(change.layer);
        let kind = &self.sheet.layers[layer].kinds[usize::from(body.kind)];
        let outward = change.outward.unwrap_or_else(|| body.outward(change.surface, ray.at(change.distance)));
        let normal = against(ray.dir, if change.enters { outward } else { -outward });
        let interface = Interface {
            distance: change.distance,
            normal,
            facet: normal,
            axis: body.frame.z,
            beyond: change.beyond,
            surface: kind.surface,
            body: kind.body,
        };
        Answer {
            next: Next::Interface(interface),
            met: Met::Surface { body: change.body, surface: change.surface, enters: change.enters },
        }
    }

    /// A plane of the layer. A cut plane has no surface, also inside a body.
    fn plane(
        &self,
        face: Face,
        distance: f64,
        ray: &Ray,
        place: &mut Place,
        m: &mut Memory,
        rng: &mut Stream,
    ) -> Answer {
        let layer = usize::from(place.layer);
        let last = match face {
            Face::Top => layer == 0,
            Face::Bottom => layer + 1 == self.sheet.layers.len(),
        };
        let edge = Answer { next: Next::Edge { face, distance }, met: Met::Nothing };
        let open = if face == Face::Top { self.sheet.open_top } else { self.sheet.open_bottom };
        if last && (open || flight::covered(&m.touched, distance)) {
            return edge;
        }
        let (beyond, surface) = match (face, last) {
            (Face::Top, true) => (self.sheet.outside, self.sheet.layers[0].slab.surface),
            (Face::Bottom, true) => (self.sheet.outside, self.sheet.bottom_surface),
            (Face::Top, false) => {
                let next = place.layer - 1;
                (
                    self.start(next, ray.at(distance), ray.dir, place, m, rng, !self.sheet.contained),
                    self.sheet.layers[layer].slab.surface,
                )
            }
            (Face::Bottom, false) => {
                let next = place.layer + 1;
                let surface = self.sheet.layers[layer + 1].slab.surface;
                (self.start(next, ray.at(distance), ray.dir, place, m, rng, !self.sheet.contained), surface)
            }
        };
        let normal = if face == Face::Top { -DVec3::Z } else { DVec3::Z };
        plane_answer(face, distance, normal, beyond, surface)
    }

    /// From outside, the sheet's face is met at once, or never.
    fn face_ahead(
        &self,
        face: Face,
        ray: &Ray,
        place: &mut Place,
        m: &mut Memory,
        rng: &mut Stream,
    ) -> Answer {
        let (inwards, layer, surface, normal) = match face {
            Face::Top => (ray.dir.z < 0.0, 0, self.sheet.layers[0].slab.surface, DVec3::Z),
            Face::Bottom => {
                (ray.dir.z > 0.0, self.sheet.layers.len() - 1, self.sheet.bottom_surface, -DVec3::Z)
            }
        };
        if !inwards {
            return Answer { next: Next::Edge { face, distance: 0.0 }, met: Met::Nothing };
        }
        let covered = self.sheet.start_in_bodies;
        let beyond = self.start(layer as u16, ray.origin, ray.dir, place, m, rng, covered);
        plane_answer(face, 0.0, normal, beyond, surface)
    }

    /// Explores the point `at` of a plane of `layer`: the medium there. Where bodies may cover it
    /// (`covered`) they are Poisson with mean ν V̄, drawn by volume, their orientation unweighted, unless
    /// an earlier segment would have met them.
    #[allow(clippy::too_many_arguments)]
    fn start(
        &self,
        layer: u16,
        at: DVec3,
        dir: DVec3,
        place: &mut Place,
        m: &mut Memory,
        rng: &mut Stream,
        covered: bool,
    ) -> MediumId {
        let population = &self.sheet.layers[usize::from(layer)];
        if covered {
            for (index, kind) in population.kinds.iter().enumerate() {
                let most = kind.profile.as_ref().map_or(1.0, |p| p.most());
                let mean = population.density[index] * population.content[index] * most;
                let mut room = mean - rng.exponential();
                while room > 0.0 {
                    room -= rng.exponential();
                    let mut body = kind.covering(at, index as u16, rng);
                    while E::START_WEIGHTED && rng.uniform() >= dir.cross(body.frame.z).length() {
                        body = kind.covering(at, index as u16, rng);
                    }
                    let known = self.known(kind, body, rng);
                    if population.stands(false, kind, &body, rng)
                        && !m.would_have_seen(&place.past, &body, layer, self.last, E::WHOLE_BODY_REJECTS)
                        && !(self.overlap == Overlap::Forbid && self.clashes(place, &body, layer, m))
                    {
                        let flight = place.past.flights + 1;
                        m.learn(&mut place.past, known, layer, flight);
                    }
                }
            }
        }
        let here = Ray { origin: at, dir };
        let seen = Place { layer, stands: None, ..*place };
        self.touch(&here, &seen, 0.0, m);
        let medium = flight::medium_behind(&m.touched, 0.0, self.overlap, population.slab.pore);
        m.keep(&mut place.past, &here, 0.0, layer);
        medium
    }

    /// A body to be remembered, with a mark where marks decide.
    #[inline]
    fn known(&self, kind: &Kind, body: super::section::Body, rng: &mut Stream) -> Known {
        let mark = if self.marks { rng.uniform() } else { 0.0 };
        Known { body, solid: Solid { mark, wall: kind.wall, lumen: kind.lumen } }
    }

    /// Whether `body` would cut a known one.
    fn clashes(&self, place: &Place, body: &super::section::Body, layer: u16, m: &Memory) -> bool {
        let mut index = place.past.sighting;
        while index != memory::NONE {
            let s = &m.sightings[index as usize];
            if s.layer == layer && overlap::overlap(body, &m.bodies[s.body as usize].body) {
                return true;
            }
            index = s.before;
        }
        false
    }

    /// Forgets all but the bodies around the ray.
    fn leave_pocket(&self, ray: &Ray, place: &mut Place, m: &mut Memory) {
        self.touch(ray, place, 0.0, m);
        let flight = place.past.flights + 1;
        let mut past = Past { flights: place.past.flights, ..NOTHING };
        let around: Vec<u32> = m.touched.iter().map(|t| t.body).collect();
        let stands = place.stands.map(|s| s.body).filter(|b| !around.contains(b));
        for body in around.into_iter().chain(stands) {
            let s = memory::Sighting::of(&m.bodies[body as usize].body, body, place.layer, flight);
            m.see(&mut past, s);
        }
        (place.past, place.stale) = (past, 0);
        m.pockets += 1;
    }
}

fn plane_answer(face: Face, distance: f64, normal: DVec3, beyond: MediumId, surface: SurfaceId) -> Answer {
    Answer {
        next: Next::Interface(super::plane_interface(distance, normal, beyond, surface)),
        met: Met::Plane(face),
    }
}

impl<E: Exactness> Universe for LazyUniverse<E> {
    type Memory = Memory;
    type Place = Place;

    fn forget(&self, memory: &mut Memory) {
        memory.clear();
    }

    fn share(&self, memory: &mut Memory) {
        memory.share();
    }

    fn kept(&self, memory: &Memory) -> Kept {
        memory.kept()
    }

    fn enter(&self, ray: &Ray, m: &mut Memory, rng: &mut Stream) -> Start<Place> {
        let face = if ray.dir.z <= 0.0 { Face::Top } else { Face::Bottom };
        let (layer, open) = match face {
            Face::Top => (0, self.sheet.open_top),
            Face::Bottom => (self.sheet.layers.len() - 1, self.sheet.open_bottom),
        };
        let mut place = Place {
            layer: layer as u16,
            outside: (!open).then_some(face),
            medium: self.sheet.outside,
            stands: None,
            past: m.common,
            stale: 0,
            answer: None,
        };
        if open {
            let covered = self.sheet.start_in_bodies;
            place.medium = self.start(layer as u16, ray.origin, ray.dir, &mut place, m, rng, covered);
        }
        Start { place, medium: place.medium }
    }

    fn come_back(&self, ray: &Ray, place: &Place, m: &mut Memory, rng: &mut Stream) -> Start<Place> {
        let mut place = Place { stands: None, answer: None, ..*place };
        let (layer, covered) = (place.layer, !self.sheet.contained);
        place.medium = self.start(layer, ray.origin, ray.dir, &mut place, m, rng, covered);
        Start { place, medium: place.medium }
    }

    #[inline]
    fn next(&self, ray: &Ray, place: &mut Place, m: &mut Memory, limit: f64, rng: &mut Stream) -> Next {
        if let Some(answer) = &place.answer {
            return answer.next;
        }
        let answer = self.look(ray, place, m, limit, rng);
        place.answer = Some(answer);
        answer.next
    }

    #[inline]
    fn moved(&self, _: &Ray, place: &mut Place, _: &mut Memory, _: f64) {
        (place.answer, place.stands) = (None, None);
    }

    #[inline]
    fn reflected(&self, _: &Ray, place: &mut Place, _: &mut Memory, _: &Interface) {
        place.stands = None; // at a plane the ray has left the body that it stood on
        if let Some(Answer { met: Met::Surface { body, surface, enters }, .. }) = place.answer.take() {
            place.stands = Some(Stands { body, surface, inside: !enters });
            place.stale += 1;
        }
    }

    #[inline]
    fn crossed(&self, _: &mut Ray, place: &mut Place, _: &mut Memory, at: &Interface) {
        match place.answer.take().map(|a| a.met) {
            Some(Met::Surface { body, surface, enters }) => {
                place.stands = Some(Stands { body, surface, inside: enters });
                place.stale += 1;
            }
            Some(Met::Plane(face)) => self.through_plane(place, face),
            _ => {}
        }
        place.medium = at.beyond;
    }
}

impl<E: Exactness> LazyUniverse<E> {
    /// Crosses a plane: into the sheet, into the neighbouring layer, or out.
    fn through_plane(&self, place: &mut Place, face: Face) {
        place.stands = None;
        if place.outside.take().is_some() {
            return;
        }
        match face {
            Face::Top if place.layer == 0 => place.outside = Some(face),
            Face::Bottom if usize::from(place.layer) + 1 == self.sheet.layers.len() => {
                place.outside = Some(face)
            }
            Face::Top => place.layer -= 1,
            Face::Bottom => place.layer += 1,
        }
    }
}
