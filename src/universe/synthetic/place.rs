//! Where a ray is among regions: the set that contains it, the surface just left, and what lies ahead.

use super::region::{Event, Key};
use crate::math::DVec3;
use crate::universe::Ray;
use arrayvec::ArrayVec;

/// Most regions that may contain one point; a ray in more is lost (and counted). A hollow fibre is
/// two regions, so this is twelve fibres deep.
pub const CAPACITY: usize = 24;

/// Regions around a point that are copied without asking how many there are.
const FEW: usize = 4;

/// A small ascending set of regions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Set {
    len: u32,
    items: [Key; CAPACITY],
}

impl Default for Set {
    fn default() -> Self {
        Set { len: 0, items: [Key::NONE; CAPACITY] }
    }
}

impl Set {
    #[inline]
    pub fn items(&self) -> &[Key] {
        &self.items[..self.len as usize]
    }

    #[inline]
    pub fn contains(&self, key: Key) -> bool {
        self.items().contains(&key)
    }

    /// Becomes equal to `other`; only what is filled is copied.
    #[inline]
    pub fn copy_from(&mut self, other: &Set) {
        // Nearly all sets are small: a copy of known length is two moves, not a call.
        self.items[..FEW].copy_from_slice(&other.items[..FEW]);
        let n = other.len as usize;
        if n > FEW {
            self.items[FEW..n].copy_from_slice(&other.items[FEW..n]);
        }
        self.len = other.len;
    }

    /// Adds `key` (once); `None` where there is no room.
    #[inline]
    pub fn insert(&mut self, key: Key) -> Option<()> {
        let n = self.len as usize;
        let mut at = n;
        while at > 0 && self.items[at - 1] > key {
            at -= 1;
        }
        if at > 0 && self.items[at - 1] == key {
            return Some(());
        }
        if n == CAPACITY {
            return None;
        }
        for i in (at..n).rev() {
            self.items[i + 1] = self.items[i];
        }
        self.items[at] = key;
        self.len += 1;
        Some(())
    }

    /// Takes `key` out, if it is in.
    #[inline]
    pub fn remove(&mut self, key: Key) {
        if let Some(at) = self.items().iter().position(|&x| x == key) {
            for i in at + 1..self.len as usize {
                self.items[i - 1] = self.items[i];
            }
            self.len -= 1;
        }
    }
}

/// Most surfaces at exactly the same distance.
const SAME: usize = 16;

/// Surfaces met at exactly the same distance; nearly always one.
pub(super) struct Group {
    pub distance: f64,
    pub overflow: bool,
    items: ArrayVec<Event, SAME>,
}

impl Group {
    /// An empty group that takes surfaces up to `limit`.
    #[inline]
    pub fn new(limit: f64) -> Self {
        Group { distance: limit, overflow: false, items: ArrayVec::new_const() }
    }

    /// Takes a surface if it is as near as those so far, and drops these if it is nearer.
    #[inline]
    pub fn offer(&mut self, event: Event) {
        if event.t < self.distance {
            self.items.clear();
            (self.distance, self.overflow) = (event.t, false);
        }
        if event.t == self.distance && event.t < f64::INFINITY {
            self.overflow |= self.items.try_push(event).is_err();
        }
    }

    /// Whether a surface of this region is among them (told by a cell before).
    #[inline]
    pub fn holds(&self, key: Key) -> bool {
        self.items().iter().any(|e| e.key == key)
    }

    #[inline]
    pub fn items(&self) -> &[Event] {
        &self.items
    }
}

/// Surfaces ahead of a ray that its state alone tells: ways out, and entries of hollows.
pub(super) struct Known(ArrayVec<Event, { CAPACITY + CAPACITY / 2 }>);

impl Known {
    #[inline]
    pub fn new() -> Self {
        Known(ArrayVec::new_const())
    }

    #[inline]
    pub fn push(&mut self, event: Event) -> Option<()> {
        self.0.try_push(event).ok()
    }

    #[inline]
    pub fn items(&self) -> &[Event] {
        &self.0
    }

    /// Drops all up to the distance `t`.
    #[inline]
    pub fn pass(&mut self, t: f64) {
        self.0.retain(|e| e.t > t);
    }
}

/// Where a ray is: the regions that contain it at its origin, the region that it just left, and
/// what [`next`](crate::universe::Universe::next) saw ahead (for `moved`, `reflected` and `crossed`).
/// Whether the ray is inside a region is told by the set; only the surface of a region just left on
/// its outer side needs a mark, for inside a convex region the way out is the larger root anyway.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Regions around the origin of `ray`.
    pub(super) inside: Set,
    /// Region whose surface the ray starts on, outside; or `NONE`.
    pub(super) left: Key,
    /// Region whose interface lies ahead; or `NONE`.
    pub(super) region: Key,
    /// No way to go on: more regions at one point than the set can hold.
    pub(super) lost: bool,
    /// The ray last asked for.
    pub(super) ray: Ray,
    /// Distance of the first surface of any kind (buried ones too), or ∞.
    pub(super) quiet: f64,
    /// Distance of the interface, or ∞.
    pub(super) distance: f64,
    /// How far all is known: the limit where nothing was met, else the interface.
    pub(super) seen: f64,
    /// Regions just before `seen` (at the limit itself: with what lies there).
    pub(super) before: Set,
    /// Regions behind the interface.
    pub(super) beyond: Set,
}

impl Place {
    pub(in crate::universe) fn new(ray: Ray) -> Self {
        Place {
            inside: Set::default(),
            left: Key::NONE,
            region: Key::NONE,
            lost: false,
            ray,
            quiet: f64::INFINITY,
            distance: f64::INFINITY,
            seen: f64::NAN,
            before: Set::default(),
            beyond: Set::default(),
        }
    }

    /// Forgets what lay ahead; `ray` is about to be asked for.
    #[inline]
    pub(super) fn look(&mut self, ray: Ray) {
        self.ray = ray;
        self.region = Key::NONE;
        self.quiet = f64::INFINITY;
        self.distance = f64::INFINITY;
        self.seen = f64::NAN;
    }

    /// The ray has been reflected before the interface, and goes on along `ray`.
    pub(super) fn turn_back(&mut self, ray: Ray) {
        let Place { region, before, inside, .. } = self;
        if *region != Key::NONE {
            inside.copy_from(before);
            // Still outside the region: it cannot be met again before another event.
            self.left = if inside.contains(*region) { Key::NONE } else { *region };
        } else {
            self.left = Key::NONE;
        }
        self.look(ray);
    }

    /// The ray has crossed the interface, and goes on along `ray`.
    pub(super) fn go_on(&mut self, ray: Ray) {
        let Place { region, beyond, inside, .. } = self;
        if *region == Key::NONE {
            self.lost = true; // nothing lay ahead: no answer is right
            return;
        }
        inside.copy_from(beyond);
        self.left = if inside.contains(*region) { Key::NONE } else { *region };
        self.look(ray);
    }

    /// Whether the ray is in more regions than can be told: it goes on nowhere.
    pub fn is_lost(&self) -> bool {
        self.lost
    }
}

/// Displacements that are tried to start in a pore.
pub(super) const MOST_TRIES: u32 = 10_000;

impl Default for Place {
    fn default() -> Self {
        Place::new(Ray::default())
    }
}

/// Where a ray is in a universe that it finds displaced sideways.
#[derive(Clone, Copy, Debug, Default)]
pub struct Displaced {
    pub(super) place: Place,
    /// From where the ray seems to be to where it is among the bodies, µm.
    pub(super) shift: DVec3,
}

impl Displaced {
    /// Whether no body is around the ray. A lumen is no pore, though its medium be the same.
    #[inline]
    pub(super) fn in_pore(&self) -> bool {
        self.place.inside.items().is_empty()
    }

    /// Whether a body is around the ray where it reaches the limit that was last asked for.
    pub(super) fn covered_ahead(&self) -> bool {
        !self.place.before.items().is_empty()
    }

    /// The ray among the bodies.
    #[inline]
    pub(super) fn shifted(&self, ray: &Ray) -> Ray {
        Ray { origin: ray.origin + self.shift, dir: ray.dir }
    }
}
