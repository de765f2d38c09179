//! The voxel universe: a labelled volume, as a microtomogram is one.
//!
//! The volume lies with its middle above x = y = 0 and its lowest slice on z = 0; sideways it goes on
//! mirrored or periodically ([`Lateral`]), above and below is the outside. Rays walk from voxel to
//! voxel ([`lattice`]); each voxel is of a **phase**, a medium with a surface law, and where the phase
//! changes there is an interface.
//!
//! **Where** an interface is, the voxel faces say; **which way it looks**, the smoothed gradient of the
//! phases about it ([`normal`]). Faces alone look along the axes only, however small the voxels, and
//! never converge ([`NormalRule::Faces`]).
//!
//! A staircase that stands for a smooth surface has steps that this surface has not: a ray that has
//! been reflected or refracted by it meets them from behind (n·u ≥ 0, n the smoothed normal towards the
//! ray's own phase). Such a step is **passed**: the ray goes straight on in its own phase, if within
//! [`REACH`] voxels it comes out of the step through a face that looks the same way (n·n′ > 0). So every
//! crossing of the smooth surface is one event, and positions are off by about a voxel, which vanishes
//! with the voxel. Where the ray does not come out again normals are at fault, and the face itself is
//! met, with its own normal. A ray that has not just been turned by that surface meets it at grazing
//! incidence; one that goes straight through an interface (equal indices) has met nothing, and finds
//! every voxel of the file.
//!
//! With [`Steps::Mirrored`] every step is met; a direction that lands on the wrong side of the face
//! is mirrored about it. That is biased at every voxel size (docs/voxels.md).

pub mod lattice;
pub mod normal;
pub mod read;
pub mod volume;
pub mod write;

pub use lattice::Lateral;
pub use volume::{Volume, VolumeError};

use super::sheet::plane_ahead;
use super::{BodyId, Interface, MediumId, Next, Ray, Start, SurfaceId, Universe};
use crate::math::DVec3;
use crate::rng::Stream;
use lattice::{Lattice, Walk};
use normal::{FaceId, Normals, Window, others};
use std::sync::Arc;

/// Voxels within which a ray must come out of a step of the staircase.
pub const REACH: u32 = 32;

/// A ray so level that the next face is more than this many voxels away …
const LEVEL: f64 = (1 << 20) as f64;
/// … is taken to meet nothing more if it has met nothing for so many voxels.
const FAR: u32 = 1 << 16;

/// What voxels of a phase are made of. Labels of equal medium and surface law are one phase: where they
/// touch there is optical contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Phase {
    /// Medium.
    pub medium: MediumId,
    /// Law of its surface. Between two phases that of the later one counts, unless it alone is smooth.
    pub surface: SurfaceId,
}

/// Which way a voxelised surface looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalRule {
    /// Gradient of the phases, smoothed by a Gaussian of this standard deviation in voxels.
    Smoothed(f64),
    /// The voxel face itself: never converges.
    Faces,
}

/// What becomes of the steps of a staircase that a ray meets from the wrong side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Steps {
    /// Passed: the smooth surface does not have them.
    Passed,
    /// Met: directions on the wrong side of the face are mirrored about it.
    Mirrored,
}

/// How a volume is placed and read.
#[derive(Clone, Debug)]
pub struct Rules {
    /// Edges of a voxel along x, y, z, µm.
    pub edge: [f64; 3],
    /// Sides.
    pub lateral: Lateral,
    /// Normals.
    pub normals: NormalRule,
    /// Steps.
    pub steps: Steps,
    /// Every ray that enters finds the volume displaced sideways at random: light falls evenly on the
    /// sheet that the volume was cut out of. Otherwise the volume stands still.
    pub anywhere: bool,
    /// Medium above and below.
    pub outside: MediumId,
}

/// A volume of voxels between two horizontal faces.
#[derive(Clone, Debug)]
pub struct VoxelUniverse {
    lattice: Lattice,
    phases: Vec<Phase>,
    normals: Option<Normals>,
    steps: Steps,
    anywhere: bool,
}

/// A universe that cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// An edge of a voxel is no positive length.
    #[error("the edges of a voxel must be positive lengths")]
    Edge,
    /// Smoothing out of range.
    #[error("normals are smoothed over 0.5 to 6 voxels")]
    Smoothing,
    /// A voxel of a phase that is not listed, or too many phases.
    #[error("phase {0} of the volume is not known")]
    Phase(usize),
}

/// Scratch of a worker and what it met, over all its histories: nothing of it bears on results.
#[derive(Debug, Default)]
pub struct Scratch {
    window: Window,
    /// Steps of staircases that rays passed.
    pub passed: u64,
    /// Interfaces met although the ray came from the wrong side of their normal.
    pub forced: u64,
}

/// Where a ray is.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Ray of the last `next`.
    ray: Ray,
    /// From the world's x, y to those of the lattice, µm.
    shift: [f64; 2],
    cell: [i64; 3],
    /// Phase that light is in; the cell's, but for steps of a staircase.
    phase: u8,
    /// What `next` found: the cell before the interface, the one behind it, the phase there.
    before: [i64; 3],
    behind: [i64; 3],
    beyond: u8,
    /// Phase across the surface that has just turned the ray.
    turned_by: Option<u8>,
    /// Limit that `next` walked up to, if nothing was met; the cell there is `behind`.
    reached: f64,
}

impl VoxelUniverse {
    /// A universe of a volume whose voxels are indices into `phases`.
    ///
    /// # Errors
    /// Edges or smoothing out of range, voxels without a phase.
    pub fn new(volume: impl Into<Arc<Volume>>, phases: Vec<Phase>, rules: &Rules) -> Result<Self, Error> {
        let volume = volume.into();
        if !rules.edge.iter().all(|e| e.is_finite() && *e > 0.0) {
            return Err(Error::Edge);
        }
        let counts = volume.counts(256);
        if let Some(unknown) = (phases.len()..256).find(|&p| counts[p] > 0) {
            return Err(Error::Phase(unknown));
        }
        let mut phases = phases;
        let around = Phase { medium: rules.outside, surface: SurfaceId::SMOOTH };
        let outside = phases.iter().position(|p| *p == around).unwrap_or_else(|| {
            phases.push(around);
            phases.len() - 1
        });
        let outside = u8::try_from(outside).map_err(|_| Error::Phase(256))?;
        let lattice = Lattice::new(volume, rules.edge, rules.lateral, outside);
        let normals = match rules.normals {
            NormalRule::Faces => None,
            NormalRule::Smoothed(sigma) if (0.5..=6.0).contains(&sigma) => {
                Some(Normals::new(&lattice, sigma))
            }
            NormalRule::Smoothed(_) => return Err(Error::Smoothing),
        };
        Ok(VoxelUniverse { lattice, phases, normals, steps: rules.steps, anywhere: rules.anywhere })
    }

    /// Thickness of the volume, µm.
    pub fn thickness(&self) -> f64 {
        self.lattice.top()
    }

    /// The voxels.
    pub fn volume(&self) -> &Volume {
        &self.lattice.volume
    }

    /// Medium at a point, the volume undisplaced.
    pub fn medium_at(&self, point: DVec3) -> MediumId {
        let [sx, sy] = self.middle();
        let p = [point.x + sx, point.y + sy, point.z];
        self.medium(self.lattice.phase(self.lattice.locate(p, [0.0; 3])))
    }

    /// Medium that light is in at `place`.
    pub fn medium_in(&self, place: &Place) -> MediumId {
        self.medium(place.phase)
    }

    fn medium(&self, phase: u8) -> MediumId {
        self.phases[usize::from(phase)].medium
    }

    fn middle(&self) -> [f64; 2] {
        [0, 1].map(|a| 0.5 * self.lattice.cells(a) as f64 * self.lattice.edge[a])
    }

    /// The face that `walk` has just passed across `axis`: its own normal and the smoothed one at the
    /// point at distance `t`, both towards the cell that the walk came from, of phase `own`.
    #[inline]
    fn normals_of(&self, passed: &Passed, scratch: &mut Scratch) -> (DVec3, DVec3) {
        let a = passed.axis;
        let mut facet = DVec3::ZERO;
        facet[a] = -passed.sign as f64;
        let Some(normals) = &self.normals else { return (facet, facet) };
        // The face in the volume itself: its lower voxel, mirrored axes turned.
        let low = if passed.sign > 0 { passed.from } else { passed.to };
        let folds = [0, 1, 2].map(|k| self.lattice.fold(k, low[k]));
        let mut id = folds.map(|f| f.0);
        let mirrored = folds.map(|f| f.1);
        let own_is_low = (passed.sign > 0) != mirrored[a];
        if mirrored[a] {
            id[a] -= 1;
        }
        let phases = if own_is_low { (passed.own, passed.other) } else { (passed.other, passed.own) };
        let corners =
            normals.of_face(&self.lattice, FaceId { low: id, axis: a }, phases, &mut scratch.window);
        let (b, c) = others(a);
        let place = |k: usize| {
            let f = passed.at[k];
            if mirrored[k] { 1.0 - f } else { f }
        };
        let (fb, fc) = (place(b), place(c));
        let low_edge = corners[0] * (1.0 - fb) + corners[1] * fb;
        let high_edge = corners[2] * (1.0 - fb) + corners[3] * fb;
        let mut n = low_edge * (1.0 - fc) + high_edge * fc;
        for k in 0..3 {
            if mirrored[k] {
                n[k] = -n[k];
            }
        }
        let n = if own_is_low { n } else { -n };
        let length = n.length();
        (facet, if length > 1e-6 { n / length } else { facet })
    }

    /// Steps until the ray of `walk`, in a step of the staircase, comes back into its `own` phase by a
    /// face that looks as `n` does.
    fn comes_out(
        &self,
        mut walk: Walk<'_>,
        ray: &Ray,
        own: u8,
        n: DVec3,
        scratch: &mut Scratch,
    ) -> Option<u32> {
        for steps in 1..=REACH {
            if walk.leaves() {
                return None;
            }
            let from = walk.phase();
            let passed = Passed::step(&mut walk, ray, from);
            if walk.phase() == own {
                let passed = Passed { own: from, other: own, ..passed };
                let (_, back) = self.normals_of(&passed, scratch);
                return (back.dot(n) < 0.0).then_some(steps);
            }
        }
        None
    }

    /// The interface with phase `beyond` at distance `t`.
    fn interface(&self, own: u8, beyond: u8, t: f64, normal: DVec3, facet: DVec3) -> Interface {
        let (early, late) = (own.min(beyond), own.max(beyond));
        let surface = |p: u8| self.phases[usize::from(p)].surface;
        let ruling = if surface(late) == SurfaceId::SMOOTH { early } else { late };
        Interface {
            distance: t,
            normal,
            facet,
            axis: DVec3::ZERO,
            beyond: self.medium(beyond),
            surface: surface(ruling),
            body: BodyId(u32::from(late)),
        }
    }

    /// What a ray meets that has passed from its own phase into another, with the walk already there;
    /// or the steps for which it goes on regardless.
    fn meets(&self, walk: &Walk<'_>, ray: &Ray, passed: &Passed, turned: bool, scratch: &mut Scratch) -> Met {
        let (facet, n) = self.normals_of(passed, scratch);
        let found = |n, facet| Met::Interface(self.interface(passed.own, passed.other, passed.t, n, facet));
        let cos = n.dot(ray.dir);
        if self.steps == Steps::Mirrored || self.normals.is_none() {
            scratch.forced += u64::from(cos >= 0.0);
            return found(against(ray.dir, n), facet);
        }
        if cos < 0.0 || !turned {
            let n = against(ray.dir, n);
            return found(n, n);
        }
        if let Some(steps) = self.comes_out(walk.clone(), ray, passed.own, n, scratch) {
            scratch.passed += 1;
            return Met::Step(steps);
        }
        scratch.forced += 1;
        found(facet, facet)
    }

    /// What a ray meets that starts in a step of a staircase, where an event has turned it.
    fn within_step(&self, walk: &Walk<'_>, ray: &Ray, place: &Place, scratch: &mut Scratch) -> Met {
        let (own, other) = (place.phase, walk.phase());
        let e = self.lattice.edge;
        let n = self.normals.as_ref().map_or(DVec3::ZERO, |normals| {
            let o = ray.origin;
            let at = DVec3::new((o.x + place.shift[0]) / e[0], (o.y + place.shift[1]) / e[1], o.z / e[2]);
            normals.about(&self.lattice, at, (own, other), &mut scratch.window)
        });
        let found = |n| Met::Interface(self.interface(own, other, 0.0, n, n));
        if n.dot(ray.dir) < 0.0 {
            return found(n);
        }
        match self.comes_out(walk.clone(), ray, own, n, scratch) {
            Some(steps) if n != DVec3::ZERO => Met::Step(steps),
            _ => {
                scratch.forced += 1;
                found(-ray.dir)
            }
        }
    }
}

/// What a change of phase turns out to be.
enum Met {
    Interface(Interface),
    /// A step of the staircase: so many cells on, the ray is in its own phase again.
    Step(u32),
}

/// A face that a walk has passed.
#[derive(Clone, Copy)]
struct Passed {
    axis: usize,
    sign: i64,
    t: f64,
    from: [i64; 3],
    to: [i64; 3],
    /// Place on the face, in edges from the lower corner of the cells.
    at: [f64; 3],
    own: u8,
    other: u8,
}

impl Passed {
    /// Takes one step.
    fn step(walk: &mut Walk<'_>, ray: &Ray, own: u8) -> Self {
        let (axis, t) = walk.ahead();
        let from = walk.cell;
        walk.step(axis);
        Passed::after(walk, ray, axis, t, from, own)
    }

    /// The step that `walk` has just taken.
    fn after(walk: &Walk<'_>, ray: &Ray, axis: usize, t: f64, from: [i64; 3], own: u8) -> Self {
        let dir = ray.dir.to_array();
        let at = [0, 1, 2].map(|k| walk.within(k, t, dir[k]));
        Passed { axis, sign: walk.sign(axis), t, from, to: walk.cell, at, own, other: walk.phase() }
    }
}

/// The unit normal against the ray: one on the wrong side is turned to the right one by as little as
/// keeps it there.
fn against(dir: DVec3, n: DVec3) -> DVec3 {
    let cos = n.dot(dir);
    if cos >= 0.0 { (n - dir * (cos + cos.max(4.0 * f64::EPSILON))).normalize() } else { n }
}

impl Universe for VoxelUniverse {
    type Memory = Scratch;
    type Place = Place;

    fn forget(&self, _: &mut Scratch) {}

    /// On the upper and lower face a ray stands outside; elsewhere in the voxel that it points into.
    fn enter(&self, ray: &Ray, _: &mut Scratch, rng: &mut Stream) -> Start<Place> {
        let mut shift = self.middle();
        if self.anywhere {
            for (a, s) in shift.iter_mut().enumerate() {
                *s = rng.uniform() * self.lattice.period(a);
            }
        }
        let origin = [ray.origin.x + shift[0], ray.origin.y + shift[1], ray.origin.z];
        let cell = self.lattice.locate(origin, ray.dir.to_array());
        let phase = self.lattice.phase(cell);
        let place = Place {
            ray: *ray,
            shift,
            cell,
            phase,
            before: cell,
            behind: cell,
            beyond: phase,
            turned_by: None,
            reached: -1.0,
        };
        Start { place, medium: self.medium(phase) }
    }

    fn next(&self, ray: &Ray, place: &mut Place, m: &mut Scratch, limit: f64, _: &mut Stream) -> Next {
        place.ray = *ray;
        place.reached = -1.0;
        let unit = (ray.dir.length_squared() - 1.0).abs() < 0.1;
        if !ray.origin.is_finite() || !unit {
            return Next::Lost;
        }
        let mut walk = Walk::new(&self.lattice, ray, place.shift, place.cell);
        let own = place.phase;
        // Steps left that are passed, and within which a step may still be one of the surface just left.
        let (mut free, mut near) = (0, if place.turned_by.is_some() { REACH } else { 0 });
        if walk.phase() != own {
            match self.within_step(&walk, ray, place, m) {
                Met::Step(steps) => (free, near) = (steps, steps + REACH),
                Met::Interface(at) => {
                    (place.before, place.behind, place.beyond) = (walk.cell, walk.cell, walk.phase());
                    return Next::Interface(at);
                }
            }
        }
        let (ahead, face) = plane_ahead(ray, self.lattice.top(), 0.0);
        // Level, in the volume or beside it: never at a face.
        let ahead = if walk.sign(2) == 0 { f64::INFINITY } else { ahead };
        let least_edge = self.lattice.edge.iter().copied().fold(f64::INFINITY, f64::min);
        let mut far = if ahead > LEVEL * least_edge { FAR } else { u32::MAX };
        while !walk.leaves() && far > 0 {
            far -= 1;
            let (axis, t) = walk.ahead();
            if t > limit {
                (place.behind, place.reached) = (walk.cell, limit);
                return Next::Limit;
            }
            let from = walk.cell;
            walk.step(axis);
            near -= u32::from(near > 0);
            if free > 0 {
                free -= 1;
                continue;
            }
            if walk.phase() == own {
                continue;
            }
            let passed = Passed::after(&walk, ray, axis, t, from, own);
            let turned = near > 0 && place.turned_by.is_none_or(|p| p == passed.other);
            match self.meets(&walk, ray, &passed, turned, m) {
                Met::Step(steps) => (free, near) = (steps, steps + REACH),
                Met::Interface(at) => {
                    (place.before, place.behind, place.beyond) = (from, walk.cell, passed.other);
                    return Next::Interface(at);
                }
            }
        }
        if ahead > limit {
            (place.behind, place.reached) = (walk.cell, limit);
            return Next::Limit;
        }
        Next::Edge { face, distance: ahead }
    }

    fn moved(&self, ray: &Ray, place: &mut Place, _: &mut Scratch, d: f64) {
        if place.reached == d {
            place.cell = place.behind;
        } else {
            let mut walk = Walk::new(&self.lattice, &place.ray, place.shift, place.cell);
            while !walk.leaves() && walk.ahead().1 <= d {
                let (axis, _) = walk.ahead();
                walk.step(axis);
            }
            place.cell = walk.cell;
        }
        place.turned_by = None;
        place.ray = *ray;
    }

    fn reflected(&self, ray: &Ray, place: &mut Place, _: &mut Scratch, _: &Interface) {
        place.cell = place.before;
        place.turned_by = Some(place.beyond);
        place.ray = *ray;
    }

    fn crossed(&self, ray: &mut Ray, place: &mut Place, _: &mut Scratch, _: &Interface) {
        place.turned_by = (ray.dir != place.ray.dir).then_some(place.phase);
        place.cell = place.behind;
        place.phase = place.beyond;
        place.ray = *ray;
    }
}
