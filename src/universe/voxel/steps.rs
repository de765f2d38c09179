//! What a change of phase is: an interface of the smooth surface, or a step of the staircase that
//! stands for it (see the universe's own page).

use super::lattice::Walk;
use super::normal::{FaceId, others};
use super::{Place, REACH, Scratch, Steps, VoxelUniverse};
use crate::math::DVec3;
use crate::universe::{BodyId, Interface, Ray, SurfaceId, against};

impl VoxelUniverse {
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
    pub(super) fn meets(
        &self,
        walk: &Walk<'_>,
        ray: &Ray,
        passed: &Passed,
        turned: bool,
        scratch: &mut Scratch,
    ) -> Met {
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
    pub(super) fn within_step(
        &self,
        walk: &Walk<'_>,
        ray: &Ray,
        place: &Place,
        scratch: &mut Scratch,
    ) -> Met {
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
pub(super) enum Met {
    Interface(Interface),
    /// A step of the staircase: so many cells on, the ray is in its own phase again.
    Step(u32),
}

/// A face that a walk has passed.
#[derive(Clone, Copy)]
pub(super) struct Passed {
    axis: usize,
    sign: i64,
    t: f64,
    from: [i64; 3],
    to: [i64; 3],
    /// Place on the face, in edges from the lower corner of the cells.
    at: [f64; 3],
    own: u8,
    pub(super) other: u8,
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
    pub(super) fn after(walk: &Walk<'_>, ray: &Ray, axis: usize, t: f64, from: [i64; 3], own: u8) -> Self {
        let dir = ray.dir.to_array();
        let at = [0, 1, 2].map(|k| walk.within(k, t, dir[k]));
        Passed { axis, sign: walk.sign(axis), t, from, to: walk.cell, at, own, other: walk.phase() }
    }
}
