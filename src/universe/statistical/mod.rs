//! The statistical universe: a sheet known only by its statistics. What a ray meets is drawn when it
//! is needed and forgotten when the history ends; one dial, the rung, says how much is remembered.
//!
//! | rung | keeps | here |
//! | --- | --- | --- |
//! | [`Rung::Homogeneous`] | nothing: a body is met, traced exactly, and the ray goes on from where it entered (Boltzmann–Grad) | [`State::Body`], the body and its entry point |
//! | [`Rung::Markov`] | the medium: chords of all phases exponential with direction-dependent means, redrawn after each event (algorithm A, Levermore–Pomraning) | [`State::Markov`] |
//! | [`Rung::Forgetful`] (`none`) | the body that the ray is in, as an exact local shape | [`State::Body`] |
//!
//! In the pores the free path to the next body is exponential with rate Σ(u) = Σ_i ν_i A_i(u); it is
//! drawn with the majorant and thinned exactly by the candidate bodies themselves ([`kind`]).

pub mod amount;
pub mod grace;
pub mod kind;
pub mod lazy;
mod markov;
mod place;
pub mod profile;
pub mod section;

use super::sheet::{Room, Slab, plane_ahead};
use super::{Face, Interface, MediumId, Next, Ray, Start, SurfaceId, Universe};
use crate::math::DVec3;
use crate::rng::Stream;
use grace::Grace;
use kind::Kind;
pub use place::{Pending, Place, State};
use section::{Body, Left, Part};

/// How much is remembered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rung {
    /// Nothing.
    Homogeneous,
    /// The medium.
    Markov,
    /// The body that the ray is in (`memory="none"`).
    Forgetful,
}

/// A layer and the bodies in it.
#[derive(Clone, Debug)]
pub struct Population {
    /// Planes and pore medium.
    pub slab: Slab,
    /// Kinds of bodies; empty: a homogeneous layer.
    pub kinds: Vec<Kind>,
    /// Density ν of each kind that counts for the rate, per pore volume: 1/µm² (fibres) or 1/µm³.
    pub density: Vec<f64>,
    /// Mean content of a body of each kind, per unit of `density`.
    pub content: Vec<f64>,
    /// Body share of each kind.
    pub share: Vec<f64>,
    /// Share of each kind's body that is solid.
    pub solid: Vec<f64>,
    /// Free paths by law instead of by density.
    pub grace: Option<Grace>,
}

impl Population {
    /// A layer without bodies.
    pub fn plain(slab: Slab) -> Self {
        Population {
            slab,
            kinds: vec![],
            density: vec![],
            content: vec![],
            share: vec![],
            solid: vec![],
            grace: None,
        }
    }

    /// Majorant rates of the kinds, 1/µm, summed up. Surface in contact with another body is not met
    /// from the pores.
    fn rates(&self) -> Vec<f64> {
        let mut sum = 0.0;
        self.kinds
            .iter()
            .zip(&self.density)
            .map(|(k, nu)| {
                let most = k.profile.as_ref().map_or(1.0, |p| p.most());
                sum += k.majorant * most * (1.0 - k.bonded) * nu;
                sum
            })
            .collect()
    }

    /// Whether a body may stand where it is: within the planes if it has to, and by its profile.
    #[inline]
    fn stands(&self, contained: bool, kind: &Kind, body: &Body, rng: &mut Stream) -> bool {
        let slab = &self.slab;
        if contained {
            let h = body.half_height();
            if body.centre.z - h < slab.bottom || body.centre.z + h > slab.top {
                return false;
            }
        }
        let Some(profile) = &kind.profile else { return true };
        let depth = (slab.top - body.centre.z) / (slab.top - slab.bottom);
        rng.uniform() * profile.most() < profile.at(depth)
    }
}

/// A statistical sheet; layers from top to bottom.
#[derive(Clone, Debug)]
pub struct StatisticalUniverse {
    layers: Vec<Population>,
    rung: Rung,
    outside: MediumId,
    /// Law of the lowest plane.
    bottom_surface: SurfaceId,
    /// Bodies lie wholly between the planes.
    contained: bool,
    /// Light may start inside bodies (`cut` sheets).
    start_in_bodies: bool,
    /// Faces without a surface: the ray just leaves.
    open_top: bool,
    open_bottom: bool,
    /// Per layer: majorant rate of all kinds, 1/µm, and its running sums.
    rates: Vec<Vec<f64>>,
}

/// What a sheet needs beside its layers.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Memory.
    pub rung: Rung,
    /// Medium above and below.
    pub outside: MediumId,
    /// Law of the lowest plane.
    pub bottom_surface: SurfaceId,
    /// Bodies wholly between the planes.
    pub contained: bool,
    /// Light may start inside bodies.
    pub start_in_bodies: bool,
    /// A backing in optical contact: the lower face has no surface.
    pub backing: bool,
    /// The upper and the lower face are smooth and part media of equal index: light passes as if nothing
    /// were there, so no event is spent on them.
    pub clear: [bool; 2],
}

impl StatisticalUniverse {
    /// A sheet from its layers.
    pub fn new(layers: Vec<Population>, rules: Rules) -> Self {
        let rates = layers.iter().map(Population::rates).collect();
        let open = |layer: Option<&Population>, surface: SurfaceId| {
            layer.is_some_and(|l| l.slab.pore == rules.outside && surface == SurfaceId::SMOOTH)
        };
        let open_top = rules.clear[0]
            || open(layers.first(), layers.first().map_or(SurfaceId::SMOOTH, |l| l.slab.surface));
        let open_bottom = rules.clear[1] || rules.backing || open(layers.last(), rules.bottom_surface);
        StatisticalUniverse {
            open_top,
            open_bottom,
            rates,
            rung: rules.rung,
            outside: rules.outside,
            bottom_surface: rules.bottom_surface,
            contained: rules.contained,
            start_in_bodies: rules.start_in_bodies,
            layers,
        }
    }

    /// Thickness of the whole sheet, µm.
    pub fn thickness(&self) -> f64 {
        self.layers.first().map_or(0.0, |l| l.slab.top) - self.layers.last().map_or(0.0, |l| l.slab.bottom)
    }

    /// Whether the upper and the lower face have no surface: rays just leave.
    pub fn open(&self) -> [bool; 2] {
        [self.open_top, self.open_bottom]
    }

    /// Layers, top to bottom.
    pub fn layers(&self) -> &[Population] {
        &self.layers
    }

    /// What a ray that reaches a plane of layer `layer` finds there.
    fn face(&self, layer: usize, face: Face, distance: f64, place: &mut Place) -> Next {
        let (last, open, normal) = match face {
            Face::Top => (layer == 0, self.open_top, -DVec3::Z),
            Face::Bottom => (layer + 1 == self.layers.len(), self.open_bottom, DVec3::Z),
        };
        if last && open {
            return Next::Edge { face, distance };
        }
        place.pending = Pending::Plane(face);
        let (beyond, surface) = match (face, last) {
            (Face::Top, true) => (self.outside, self.layers[0].slab.surface),
            (Face::Bottom, true) => (self.outside, self.bottom_surface),
            (Face::Top, false) => (self.layers[layer - 1].slab.pore, self.layers[layer].slab.surface),
            (Face::Bottom, false) => (self.layers[layer + 1].slab.pore, self.layers[layer + 1].slab.surface),
        };
        Next::Interface(plane_interface(distance, normal, beyond, surface))
    }

    /// From outside, the sheet's face is met at once, or never.
    fn outside_next(&self, face: Face, ray: &Ray, place: &mut Place) -> Next {
        let inwards = match face {
            Face::Top => ray.dir.z < 0.0,
            Face::Bottom => ray.dir.z > 0.0,
        };
        if !inwards {
            return Next::Edge { face, distance: 0.0 };
        }
        place.pending = Pending::Plane(face);
        let (slab, surface, normal) = match face {
            Face::Top => (&self.layers[0].slab, self.layers[0].slab.surface, DVec3::Z),
            Face::Bottom => (&self.layers[self.layers.len() - 1].slab, self.bottom_surface, -DVec3::Z),
        };
        Next::Interface(plane_interface(0.0, normal, slab.pore, surface))
    }

    /// In a layer without bodies: the next plane.
    #[inline]
    fn plane_next(&self, layer: usize, ray: &Ray, place: &mut Place, limit: f64) -> Next {
        let slab = &self.layers[layer].slab;
        let (to_plane, face) = plane_ahead(ray, slab.top, slab.bottom);
        if to_plane <= limit { self.face(layer, face, to_plane, place) } else { Next::Limit }
    }

    /// In the pores: the next body or plane.
    #[inline]
    fn pore_next(&self, layer: usize, ray: &Ray, place: &mut Place, limit: f64, rng: &mut Stream) -> Next {
        let slab = &self.layers[layer].slab;
        let (to_plane, face) = plane_ahead(ray, slab.top, slab.bottom);
        if matches!(place.pending, Pending::Unexplored) {
            place.pending = self.explore(layer, ray, place, limit.min(to_plane), rng);
        }
        if let (Pending::Meet { distance, outward, surface }, Some(body)) = (place.pending, &place.body) {
            let kind = &self.layers[layer].kinds[usize::from(body.kind)];
            // The lumen is open at the ends.
            let open = surface == Left::Cap && body.part_at(ray.at(distance)) == Part::Lumen;
            return Next::Interface(Interface {
                distance,
                normal: outward,
                facet: outward,
                axis: body.frame.z,
                beyond: if open { kind.lumen } else { kind.wall },
                surface: kind.surface,
                body: kind.body,
            });
        }
        if to_plane <= limit { self.face(layer, face, to_plane, place) } else { Next::Limit }
    }

    /// Draws the first body within `reach` into `place`, or finds nothing.
    #[inline]
    fn explore(&self, layer: usize, ray: &Ray, place: &mut Place, reach: f64, rng: &mut Stream) -> Pending {
        let population = &self.layers[layer];
        if let Some(grace) = &population.grace {
            let from = if let State::Pore { from } = place.state { from } else { None };
            return match grace.explore(population, ray, from, reach, rng) {
                Some((distance, met)) => {
                    place.body = Some(met.body);
                    Pending::Meet { distance, outward: met.outward, surface: met.surface }
                }
                None => Pending::Nothing,
            };
        }
        let rates = &self.rates[layer];
        let Some(&total) = rates.last() else { return Pending::Nothing };
        let mut distance = 0.0;
        loop {
            distance += rng.exponential() / total;
            if distance >= reach {
                return Pending::Nothing;
            }
            let index = pick(rates, total, rng);
            let at = ray.at(distance);
            let kind = &population.kinds[index];
            if let Some(met) = kind.candidate(ray.dir, at, index as u16, rng)
                && population.stands(self.contained, kind, &met.body, rng)
            {
                place.body = Some(met.body);
                return Pending::Meet { distance, outward: met.outward, surface: met.surface };
            }
        }
    }

    /// Inside a body known by its shape.
    #[inline]
    fn body_next(&self, layer: usize, ray: &Ray, place: &mut Place, limit: f64, rng: &mut Stream) -> Next {
        if let (Pending::Contact { distance, outward }, Some(body)) = (place.pending, &place.body) {
            return self.contact(layer, body, distance, outward);
        }
        let (State::Body { part, left }, Some(body)) = (place.state, &place.body) else { return Next::Lost };
        let population = &self.layers[layer];
        let kind = &population.kinds[usize::from(body.kind)];
        let crossing = body.leave(ray.origin, ray.dir, part, left);
        if self.rung != Rung::Homogeneous {
            let (to_plane, face) = plane_ahead(ray, population.slab.top, population.slab.bottom);
            if to_plane <= limit && crossing.is_none_or(|c| to_plane < c.t) {
                return if to_plane.is_finite() { self.cut_face(layer, face, to_plane) } else { Next::Lost };
            }
        }
        let Some(crossing) = crossing else {
            return if limit.is_finite() { Next::Limit } else { Next::Lost };
        };
        if crossing.t > limit {
            return Next::Limit;
        }
        let (beyond, normal) = match (crossing.surface, part) {
            (Left::Lumen, Part::Wall) => (kind.lumen, crossing.outward),
            (Left::Lumen, Part::Lumen) => (kind.wall, -crossing.outward),
            _ => (population.slab.pore, -crossing.outward),
        };
        let axis = body.frame.z;
        if kind.bonded > 0.0
            && crossing.surface == Left::Outer
            && !matches!(place.pending, Pending::Leave(_))
            && rng.uniform() < kind.bonded
            && let Some(met) = self.neighbour(layer, body.kind, ray, crossing.t, rng)
        {
            place.body = Some(met.body);
            place.pending = Pending::Contact { distance: crossing.t, outward: met.outward };
            return self.contact(layer, &met.body, crossing.t, met.outward);
        }
        place.pending = Pending::Leave(crossing.surface);
        Next::Interface(Interface {
            distance: crossing.t,
            normal,
            facet: normal,
            axis,
            beyond,
            surface: kind.surface,
            body: kind.body,
        })
    }

    /// A body of the same kind in optical contact where the ray leaves its own; none where no room is
    /// found for it (next to the faces of a `contained` sheet).
    fn neighbour(
        &self,
        layer: usize,
        kind: u16,
        ray: &Ray,
        distance: f64,
        rng: &mut Stream,
    ) -> Option<kind::Encounter> {
        const TRIES: u32 = 64;
        let population = &self.layers[layer];
        let of = &population.kinds[usize::from(kind)];
        (0..TRIES).find_map(|_| {
            of.candidate(ray.dir, ray.at(distance), kind, rng)
                .filter(|met| population.stands(self.contained, of, &met.body, rng))
        })
    }

    /// From wall to wall: no medium changes, and the surface is none.
    fn contact(&self, layer: usize, body: &Body, distance: f64, outward: DVec3) -> Next {
        let kind = &self.layers[layer].kinds[usize::from(body.kind)];
        Next::Interface(Interface {
            distance,
            normal: outward,
            facet: outward,
            axis: body.frame.z,
            beyond: kind.wall,
            surface: SurfaceId::SMOOTH,
            body: kind.body,
        })
    }

    /// A cut plane has no surface: also from inside a wall, the ray leaves.
    fn cut_face(&self, layer: usize, face: Face, distance: f64) -> Next {
        let last = match face {
            Face::Top => layer == 0,
            Face::Bottom => layer + 1 == self.layers.len(),
        };
        if last { Next::Edge { face, distance } } else { Next::Lost }
    }
}

pub(in crate::universe) fn plane_interface(
    distance: f64,
    normal: DVec3,
    beyond: MediumId,
    surface: SurfaceId,
) -> Interface {
    Interface { distance, normal, facet: normal, axis: DVec3::X, beyond, surface, body: super::BodyId(0) }
}

/// Index drawn in proportion to the steps of the running sums `sums` with total `total`.
#[inline]
fn pick(sums: &[f64], total: f64, rng: &mut Stream) -> usize {
    if sums.len() == 1 {
        return 0;
    }
    let x = rng.uniform() * total;
    sums.iter().position(|&s| x < s).unwrap_or(sums.len() - 1)
}

impl Universe for StatisticalUniverse {
    type Memory = ();
    type Place = Place;

    fn forget(&self, _: &mut ()) {}

    fn enter(&self, ray: &Ray, _: &mut (), rng: &mut Stream) -> Start<Place> {
        let mut place = Place::default();
        let medium = self.enter_into(ray, &mut place, &mut (), rng);
        Start { place, medium }
    }

    #[inline]
    fn enter_into(&self, ray: &Ray, place: &mut Place, _: &mut (), rng: &mut Stream) -> MediumId {
        let face = if ray.dir.z <= 0.0 { Face::Top } else { Face::Bottom };
        let (layer, open) = match face {
            Face::Top => (0, self.open_top),
            Face::Bottom => (self.layers.len() - 1, self.open_bottom),
        };
        (place.layer, place.pending, place.entered) = (layer as u16, Pending::Unexplored, ray.origin);
        place.body = None;
        if !open {
            place.state = State::Outside(face);
            return self.outside;
        }
        let population = &self.layers[layer];
        if self.start_in_bodies
            && let Some(medium) = start_in_body(population, self.rung, ray, place, rng)
        {
            return medium;
        }
        place.state = State::Pore { from: None };
        population.slab.pore
    }

    #[inline]
    fn room(&self, place: &Place) -> Room {
        let layer = &self.layers[usize::from(place.layer)];
        match place.state {
            State::Pore { .. } if layer.kinds.is_empty() => {
                Room { top: layer.slab.top, bottom: layer.slab.bottom }
            }
            _ => Room::NONE,
        }
    }

    #[inline]
    fn next(&self, ray: &Ray, place: &mut Place, _: &mut (), limit: f64, rng: &mut Stream) -> Next {
        let layer = usize::from(place.layer);
        match place.state {
            State::Pore { .. } if self.layers[layer].kinds.is_empty() => {
                self.plane_next(layer, ray, place, limit)
            }
            State::Pore { .. } => self.pore_next(layer, ray, place, limit, rng),
            State::Body { .. } => self.body_next(layer, ray, place, limit, rng),
            State::Markov { .. } => self.markov_next(layer, ray, place, limit, rng),
            State::Outside(face) => self.outside_next(face, ray, place),
        }
    }

    #[inline]
    fn moved(&self, _: &Ray, place: &mut Place, _: &mut (), _: f64) {
        place.pending = Pending::Unexplored;
        match &mut place.state {
            State::Body { left, .. } => *left = Left::Nothing,
            State::Pore { from } => *from = None,
            _ => {}
        }
    }

    #[inline]
    fn reflected(&self, _: &Ray, place: &mut Place, _: &mut (), _: &Interface) {
        match (&mut place.state, place.pending) {
            (State::Body { left, .. }, Pending::Leave(surface)) => *left = surface,
            (State::Pore { from }, Pending::Meet { .. }) => *from = place.body.as_ref().map(|b| b.kind),
            _ => {}
        }
        place.pending = Pending::Unexplored;
    }

    #[inline]
    fn crossed(&self, ray: &mut Ray, place: &mut Place, _: &mut (), _: &Interface) {
        let pending = std::mem::replace(&mut place.pending, Pending::Unexplored);
        place.state = match (place.state, pending) {
            (State::Pore { .. }, Pending::Meet { surface, .. }) => {
                place.entered = ray.origin;
                match &place.body {
                    Some(body) if self.rung == Rung::Markov => {
                        State::Markov { kind: body.kind, part: Part::Wall }
                    }
                    Some(body) if surface == Left::Cap => {
                        State::Body { part: body.part_at(ray.origin), left: surface }
                    }
                    _ => State::Body { part: Part::Wall, left: surface },
                }
            }
            (State::Body { part, .. }, Pending::Leave(Left::Lumen)) => {
                let part = if part == Part::Wall { Part::Lumen } else { Part::Wall };
                State::Body { part, left: Left::Lumen }
            }
            (State::Body { .. }, Pending::Contact { .. }) => {
                State::Body { part: Part::Wall, left: Left::Outer }
            }
            (State::Body { .. }, Pending::Leave(_)) => {
                if self.rung == Rung::Homogeneous {
                    ray.origin = place.entered;
                }
                State::Pore { from: place.body.as_ref().map(|b| b.kind) }
            }
            (State::Markov { kind, part }, Pending::Chord { inward, .. }) => match (part, inward) {
                (Part::Wall, true) => State::Markov { kind, part: Part::Lumen },
                (Part::Lumen, _) => State::Markov { kind, part: Part::Wall },
                (Part::Wall, false) => State::Pore { from: Some(kind) },
            },
            (State::Outside(_), _) => State::Pore { from: None },
            (State::Pore { .. }, Pending::Plane(face)) => self.through_plane(place, face),
            (state, _) => state,
        };
    }
}

impl StatisticalUniverse {
    /// Crosses a plane out of a pore: into the neighbouring layer or out of the sheet.
    fn through_plane(&self, place: &mut Place, face: Face) -> State {
        let last = self.layers.len() as u16 - 1;
        match face {
            Face::Top if place.layer == 0 => State::Outside(Face::Top),
            Face::Bottom if place.layer == last => State::Outside(Face::Bottom),
            Face::Top => {
                place.layer -= 1;
                State::Pore { from: None }
            }
            Face::Bottom => {
                place.layer += 1;
                State::Pore { from: None }
            }
        }
    }
}

/// A start on a cut plane is inside a body with the probability of the bodies' share.
fn start_in_body(
    p: &Population,
    rung: Rung,
    ray: &Ray,
    place: &mut Place,
    rng: &mut Stream,
) -> Option<MediumId> {
    if p.share.is_empty() {
        return None;
    }
    let x = rng.uniform();
    let mut sum = 0.0;
    let index = p.share.iter().position(|s| {
        sum += s;
        x < sum
    })?;
    let kind = &p.kinds[index];
    if rung == Rung::Markov {
        let part = if rng.uniform() < p.solid[index] { Part::Wall } else { Part::Lumen };
        let medium = if part == Part::Wall { kind.wall } else { kind.lumen };
        place.state = State::Markov { kind: index as u16, part };
        return Some(medium);
    }
    let body = kind.covering(ray.origin, index as u16, rng);
    let part = body.part_at(ray.origin);
    let medium = if part == Part::Wall { kind.wall } else { kind.lumen };
    place.state = State::Body { part, left: Left::Nothing };
    place.body = Some(body);
    Some(medium)
}
