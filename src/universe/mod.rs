//! Where components are. A universe knows nothing of light: it answers which interface a ray meets
//! next, how far away, with which normal, and what lies beyond.
//!
//! Contract (tested for every universe):
//! * [`Universe::next`] twice with the same ray and limit and nothing between gives the same answer;
//! * no ray is lost and no ray is offset by an epsilon: a [`Universe::Place`] remembers the surface
//!   just left, and its root is removed analytically;
//! * normals are unit and point against the ray;
//! * a branch is a copy of the place and sees only its own past.

pub mod any;
pub mod deposit;
pub mod mixture;
pub mod shape;
pub mod sheet;
pub mod statistical;
pub mod synthetic;
pub mod topography;
pub mod voxel;

use crate::math::DVec3;
use crate::rng::Stream;
use sheet::Room;

/// Medium: index into the scene's materials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MediumId(pub u16);

/// Surface law: index into the scene's surfaces; 0 is the smooth surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SurfaceId(pub u16);

impl SurfaceId {
    /// The smooth dielectric surface, always present.
    pub const SMOOTH: SurfaceId = SurfaceId(0);
}

/// Body (or population of bodies) that an interface belongs to; for tallies by component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BodyId(pub u32);

/// A straight ray: origin in µm, unit direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ray {
    /// Where it starts, µm.
    pub origin: DVec3,
    /// Where it goes, unit length.
    pub dir: DVec3,
}

impl Ray {
    /// The point at distance `t`.
    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.dir * t
    }
}

/// What holds where bodies overlap. Marks are random numbers of bodies, or given priorities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlap {
    /// A point is solid if any wall covers it; of different solids the highest mark rules.
    Union,
    /// The body of the highest mark rules, wall or lumen.
    Priority,
    /// Bodies do not overlap. In the statistical universe an approximation of hard packing: a body is
    /// refused if it cuts one already known. Explicit bodies are taken as apart; where they are not, as
    /// `Priority`.
    Forbid,
}

/// The unit normal against the ray. Where rounding (or smoothing) leaves a normal on the wrong side, it
/// is turned to the right one by as little as keeps it there: twice its fault, at least the rounding of a
/// dot product, 4 ε.
#[inline]
fn against(dir: DVec3, normal: DVec3) -> DVec3 {
    let cos = normal.dot(dir);
    if cos >= 0.0 { (normal - dir * (cos + cos.max(4.0 * f64::EPSILON))).normalize() } else { normal }
}

/// Outer faces of a sheet, or the far away of an unbounded scene (by the sign of the direction's z).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Face {
    /// z = thickness: where light comes from.
    #[default]
    Top,
    /// z = 0.
    Bottom,
}

/// An interface met by a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Distance along the ray, µm, ≥ 0.
    pub distance: f64,
    /// Unit normal against the ray, used for directions.
    pub normal: DVec3,
    /// Unit normal of the true face, against the ray; equals `normal` unless that is smoothed.
    pub facet: DVec3,
    /// Machine direction of the surface (fibre axis), for the roll of the SAP frame; need not be unit
    /// nor tangent, zero where the surface has none.
    pub axis: DVec3,
    /// Medium on the other side.
    pub beyond: MediumId,
    /// Law of the surface.
    pub surface: SurfaceId,
    /// Body whose surface it is.
    pub body: BodyId,
}

/// What a ray meets next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Next {
    /// An interface, within the limit.
    Interface(Interface),
    /// The ray leaves the universe: through a face of the sheet at `distance`, or to infinity.
    Edge {
        /// Which way out.
        face: Face,
        /// Distance along the ray, µm; infinite in an unbounded scene.
        distance: f64,
    },
    /// Nothing within the limit.
    Limit,
    /// No valid answer: the ray is lost and its power goes to the ledger.
    Lost,
}

/// What a universe has to tell of histories: what they have kept in memory, and what staircases of voxels did to
/// them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Bodies met.
    pub bodies: u64,
    /// Segments traced.
    pub segments: u64,
    /// Bytes in use, of the history that needed most.
    pub bytes: u64,
    /// Pockets forgotten (finite memory).
    pub pockets: u64,
    /// Steps of a voxel staircase that rays passed, for the surface that it stands for has none.
    pub steps: u64,
    /// Voxel interfaces met although the ray came from the wrong side of their smooth normal.
    pub forced: u64,
}

impl Kept {
    /// Adds another history's.
    pub fn add(&mut self, other: Kept) {
        self.bodies += other.bodies;
        self.segments += other.segments;
        self.bytes = self.bytes.max(other.bytes);
        self.pockets += other.pockets;
        self.steps += other.steps;
        self.forced += other.forced;
    }
}

/// The start of a history.
#[derive(Clone, Copy, Debug)]
pub struct Start<P> {
    /// Where the ray is.
    pub place: P,
    /// Medium it starts in.
    pub medium: MediumId,
}

/// A place full of components; see the module's contract.
pub trait Universe: Sync {
    /// Per history: bodies met, segments traced; append-only, cleared between histories.
    type Memory: Default + Send;
    /// Where a ray is: a small value, or a node in `Memory`. The default is nowhere, and must be entered.
    type Place: Copy + Default + Send;

    /// Clears the memory before a history; nothing is freed.
    fn forget(&self, memory: &mut Self::Memory);

    /// The next history shares the realisation of the one before: what that has met is known to it.
    /// Universes that remember nothing have nothing to share.
    fn share(&self, memory: &mut Self::Memory) {
        self.forget(memory);
    }

    /// The history `number` is about to enter: where there are several realisations, which one it meets.
    fn begin(&self, _memory: &mut Self::Memory, _number: u64) {}

    /// What is remembered.
    fn kept(&self, _memory: &Self::Memory) -> Kept {
        Kept::default()
    }

    /// A ray enters from outside (or starts anywhere inside an unbounded scene).
    fn enter(&self, ray: &Ray, memory: &mut Self::Memory, rng: &mut Stream) -> Start<Self::Place>;

    /// [`Universe::enter`] into a place that exists already, which the loop need not copy. The medium.
    fn enter_into(
        &self,
        ray: &Ray,
        place: &mut Self::Place,
        memory: &mut Self::Memory,
        rng: &mut Stream,
    ) -> MediumId {
        let start = self.enter(ray, memory, rng);
        *place = start.place;
        start.medium
    }

    /// The ray that left by a face comes back into the same sheet at `ray` (a backing in optical contact).
    /// Universes that forget draw the place anew.
    fn come_back(
        &self,
        ray: &Ray,
        _place: &Self::Place,
        memory: &mut Self::Memory,
        rng: &mut Stream,
    ) -> Start<Self::Place> {
        self.enter(ray, memory, rng)
    }

    /// Room without bodies around `place`: a flight that ends at a height strictly between the two meets
    /// nothing on its way, as [`Universe::next`] would say, and need not ask it. Empty where bodies are, or
    /// where the universe does not know.
    fn room(&self, _place: &Self::Place) -> Room {
        Room::NONE
    }

    /// The next interface, edge or nothing within `limit` (µm, may be infinite).
    fn next(
        &self,
        ray: &Ray,
        place: &mut Self::Place,
        memory: &mut Self::Memory,
        limit: f64,
        rng: &mut Stream,
    ) -> Next;

    /// The ray moved by `d` inside its medium and has the new direction of `ray` (whose origin is
    /// the new position).
    fn moved(&self, ray: &Ray, place: &mut Self::Place, memory: &mut Self::Memory, d: f64);

    /// The ray was reflected at `at`; `ray` is the reflected ray.
    fn reflected(&self, ray: &Ray, place: &mut Self::Place, memory: &mut Self::Memory, at: &Interface);

    /// The ray crossed `at`; `ray` is the ray beyond. The universe may move its origin (rungs whose
    /// bodies take no room put the ray back where it entered).
    fn crossed(&self, ray: &mut Ray, place: &mut Self::Place, memory: &mut Self::Memory, at: &Interface);
}
