//! Markov mixtures in one dimension: planar layers of random thickness of two or more phases
//! ([`chain`]), drawn when a ray needs them. A ray of direction cosine µ sees chords of mean Λ_i/|µ|. The
//! planes between layers are real interfaces; light whose phases differ in nothing but absorption and
//! scattering passes them unaware.
//!
//! | rung | a branch remembers | known as |
//! | --- | --- | --- |
//! | [`Rung::Phase`] | the phase that it is in; the way to the plane ahead is drawn anew after each event | chord length sampling, algorithm A, Levermore–Pomraning |
//! | [`Rung::Layers`] (1) | both planes of its layer, until it leaves the layer | local realisation preserving, algorithm B |
//! | [`Rung::Layers`] (k) | the k layers that it was in last | 2: algorithm C |
//! | [`Rung::Full`] | every layer that it has met | exact: the mean over all realisations |
//!
//! `Full` is exact because a layer is exponential in thickness, so what is left of it beyond the known
//! stretch does not depend on what is known: drawing planes one by one as they are met gives the law of
//! the whole realisation. The homogeneous rung (atomic mix) is a plain layer of the averaged medium and
//! needs no universe of its own.
//!
//! What is remembered of a plane is its height and both its phases. A plane is never asked for from the
//! side where the ray goes away from it, so the plane just left needs no care.
//!
//! Sources: Adams, Larsen & Pomraning 1989, doi:10.1016/0022-4073(89)90072-1; Zimmerman & Adams 1991,
//! Trans. Am. Nucl. Soc., "Algorithms for Monte Carlo particle transport in binary statistical mixtures"
//! (A, B, C).

pub mod chain;
pub mod memory;

use super::sheet::plane_ahead;
use super::{BodyId, Face, Interface, MediumId, Next, Ray, Start, SurfaceId, Universe};
use crate::math::DVec3;
use crate::rng::Stream;
use chain::Chain;
use memory::{Known, Layer, Memory, Plane};

/// How much is remembered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rung {
    /// The phase.
    Phase,
    /// The last k ≥ 1 layers (0 counts as 1).
    Layers(u32),
    /// Every layer.
    Full,
}

/// What a mixture needs beside its phases.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Memory.
    pub rung: Rung,
    /// Medium above and below.
    pub outside: MediumId,
    /// Law of the planes between phases; the two faces are smooth.
    pub surface: SurfaceId,
    /// The upper and the lower face part every phase from something of equal index: light passes as if
    /// nothing were there, so no event is spent on them. So it is too with a backing in optical contact.
    pub clear: [bool; 2],
}

/// A slab of layers between z = thickness (where light comes from) and z = 0.
#[derive(Clone, Debug)]
pub struct MixtureUniverse {
    chain: Chain,
    thickness: f64,
    rules: Rules,
}

/// Where a ray is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    /// Above or below the slab; `None`: in it.
    outside: Option<Face>,
    known: Known,
    /// What the last `next` has told.
    pending: Pending,
}

impl Place {
    /// Layers known to this branch.
    pub fn layers_known(&self) -> u32 {
        self.known.count()
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Pending {
    #[default]
    Nothing,
    Face(Face),
    Plane {
        upwards: bool,
    },
}

impl MixtureUniverse {
    /// A slab of `thickness` µm.
    pub fn new(chain: Chain, thickness: f64, rules: Rules) -> Self {
        MixtureUniverse { chain, thickness, rules }
    }

    /// Thickness, µm.
    pub fn thickness(&self) -> f64 {
        self.thickness
    }

    /// The law of its layers.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// How much is remembered.
    pub fn rung(&self) -> Rung {
        self.rules.rung
    }

    fn clear(&self, face: Face) -> bool {
        self.rules.clear[usize::from(face == Face::Bottom)]
    }

    /// The layer around a start: all that is asked of it later is drawn from here, so rungs with a memory
    /// settle both its planes now. A face stands for a plane that no ray can reach.
    fn first_layer(&self, z: f64, rng: &mut Stream) -> Layer {
        let phase = self.chain.at_a_point(rng);
        if self.rules.rung == Rung::Phase {
            return Layer { phase, up: None, down: None };
        }
        let up = if z < self.thickness { z + self.chain.rest(phase, rng) } else { self.thickness };
        let down = if z > 0.0 { z - self.chain.rest(phase, rng) } else { 0.0 };
        let plane = |z: f64, rng: &mut Stream| Some(Plane { z, beyond: self.chain.behind(phase, rng) });
        Layer { phase, up: plane(up, rng), down: plane(down, rng) }
    }

    /// The plane ahead, drawn if it is not known: from the plane behind, or (rung [`Rung::Phase`], which
    /// knows none) from the ray.
    #[inline]
    fn plane(&self, upwards: bool, z: f64, layer: &mut Layer, rng: &mut Stream) -> Plane {
        let (ahead, behind) = if upwards { (&mut layer.up, layer.down) } else { (&mut layer.down, layer.up) };
        *ahead.get_or_insert_with(|| {
            let rest = self.chain.rest(layer.phase, rng);
            let from = behind.map_or(z, |p| p.z);
            let z = if upwards { from + rest } else { from - rest };
            Plane { z, beyond: self.chain.behind(layer.phase, rng) }
        })
    }

    /// From outside, a face is met once, or never.
    fn outside_next(&self, face: Face, ray: &Ray, place: &mut Place, limit: f64) -> Next {
        let (inwards, z, normal) = match face {
            Face::Top => (ray.dir.z < 0.0, self.thickness, DVec3::Z),
            Face::Bottom => (ray.dir.z > 0.0, 0.0, -DVec3::Z),
        };
        if !inwards {
            return Next::Edge { face, distance: 0.0 };
        }
        let distance = ((z - ray.origin.z) / ray.dir.z).max(0.0);
        if distance > limit {
            return Next::Limit;
        }
        place.pending = Pending::Face(face);
        let beyond = self.chain.medium(place.known.layer.phase);
        Next::Interface(interface(distance, normal, beyond, SurfaceId::SMOOTH, 0))
    }

    /// After an event in its medium, or at a plane: what rung [`Rung::Phase`] knew is worth no more.
    #[inline]
    fn event(&self, place: &mut Place) {
        place.pending = Pending::Nothing;
        if self.rules.rung == Rung::Phase {
            (place.known.layer.up, place.known.layer.down) = (None, None);
        }
    }
}

/// A horizontal interface; body 0 is a face, body i + 1 the layers of phase i.
#[inline]
fn interface(distance: f64, normal: DVec3, beyond: MediumId, surface: SurfaceId, body: u32) -> Interface {
    Interface { distance, normal, facet: normal, axis: DVec3::X, beyond, surface, body: BodyId(body) }
}

impl Universe for MixtureUniverse {
    type Memory = Memory;
    type Place = Place;

    fn forget(&self, memory: &mut Memory) {
        memory.clear();
    }

    fn enter(&self, ray: &Ray, memory: &mut Memory, rng: &mut Stream) -> Start<Place> {
        let z = ray.origin.z;
        let (face, inwards) =
            if z >= self.thickness { (Face::Top, ray.dir.z < 0.0) } else { (Face::Bottom, ray.dir.z > 0.0) };
        let within = z > 0.0 && z < self.thickness;
        let on_face = (z == self.thickness || z == 0.0) && inwards && self.clear(face);
        let outside = (!within && !on_face).then_some(face);
        // From outside the first layer begins at the face that the ray meets.
        let known = Known::only(self.first_layer(z.clamp(0.0, self.thickness), rng), memory);
        let medium = outside.map_or(self.chain.medium(known.layer.phase), |_| self.rules.outside);
        Start { place: Place { outside, known, pending: Pending::Nothing }, medium }
    }

    #[inline]
    fn next(&self, ray: &Ray, place: &mut Place, _: &mut Memory, limit: f64, rng: &mut Stream) -> Next {
        if let Some(face) = place.outside {
            return self.outside_next(face, ray, place, limit);
        }
        let (to_face, face) = plane_ahead(ray, self.thickness, 0.0);
        // A ray in the plane meets nothing.
        if to_face.is_finite() {
            let upwards = face == Face::Top;
            let plane = self.plane(upwards, ray.origin.z, &mut place.known.layer, rng);
            let distance = ((plane.z - ray.origin.z) / ray.dir.z).max(0.0);
            if distance < to_face {
                if distance > limit {
                    return Next::Limit;
                }
                place.pending = Pending::Plane { upwards };
                let normal = if upwards { -DVec3::Z } else { DVec3::Z };
                let beyond = self.chain.medium(plane.beyond);
                let body = u32::from(plane.beyond) + 1;
                return Next::Interface(interface(distance, normal, beyond, self.rules.surface, body));
            }
        }
        if to_face > limit {
            return Next::Limit;
        }
        if self.clear(face) {
            return Next::Edge { face, distance: to_face };
        }
        place.pending = Pending::Face(face);
        let normal = if face == Face::Top { -DVec3::Z } else { DVec3::Z };
        Next::Interface(interface(to_face, normal, self.rules.outside, SurfaceId::SMOOTH, 0))
    }

    #[inline]
    fn moved(&self, _: &Ray, place: &mut Place, _: &mut Memory, _: f64) {
        self.event(place);
    }

    #[inline]
    fn reflected(&self, _: &Ray, place: &mut Place, _: &mut Memory, _: &Interface) {
        self.event(place);
    }

    #[inline]
    fn crossed(&self, _: &mut Ray, place: &mut Place, memory: &mut Memory, _: &Interface) {
        match place.pending {
            Pending::Face(face) => {
                place.outside = if place.outside.is_some() { None } else { Some(face) };
            }
            Pending::Plane { upwards } => {
                let most = match self.rules.rung {
                    Rung::Phase => 1,
                    Rung::Layers(k) => k.max(1),
                    Rung::Full => u32::MAX,
                };
                place.known.cross(upwards, most, memory);
            }
            Pending::Nothing => {}
        }
        self.event(place);
    }
}
