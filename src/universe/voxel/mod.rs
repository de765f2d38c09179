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
mod steps;
pub mod volume;
pub mod write;

pub use lattice::Lateral;
pub use volume::{Volume, VolumeError};

use super::sheet::plane_ahead;
use super::{Interface, Kept, MediumId, Next, Ray, Start, SurfaceId, Universe};
use crate::math::DVec3;
use crate::rng::Stream;
use lattice::{Lattice, Walk};
use normal::{Normals, Window};
use std::sync::Arc;
use steps::{Met, Passed};

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

/// Scratch of a worker, and what its history met: nothing of it bears on results.
#[derive(Debug, Default)]
pub struct Scratch {
    window: Window,
    /// Steps of staircases that rays passed.
    pub passed: u64,
    /// Interfaces met although the ray came from the wrong side of their normal.
    pub forced: u64,
}

/// Where a ray is.
#[derive(Clone, Copy, Debug, Default)]
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

    /// The same volume, its middle at the origin for every ray.
    pub fn still(&self) -> Self {
        VoxelUniverse { anywhere: false, ..self.clone() }
    }

    /// Edges of a voxel, µm, and the size of the volume along x and y, µm.
    pub fn sizes(&self) -> ([f64; 3], [f64; 2]) {
        let cells = self.volume().cells();
        let edge = self.lattice.edge;
        (edge, [0, 1].map(|a| cells[a] as f64 * edge[a]))
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
}

impl Universe for VoxelUniverse {
    type Memory = Scratch;
    type Place = Place;

    fn forget(&self, scratch: &mut Scratch) {
        (scratch.passed, scratch.forced) = (0, 0);
    }

    fn kept(&self, scratch: &Scratch) -> Kept {
        Kept { steps: scratch.passed, forced: scratch.forced, ..Kept::default() }
    }

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
