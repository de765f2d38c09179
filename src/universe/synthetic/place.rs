//! Where a ray is among regions: the set that contains it, and the surface just left.

use crate::universe::Ray;

/// Most regions that may contain one point; a ray in more is lost (and counted). A hollow fibre is
/// two regions, so this is eight fibres deep.
pub const CAPACITY: usize = 16;

/// No region.
pub(super) const NONE: u32 = u32::MAX;

/// A small ascending set of region numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Set {
    len: u32,
    items: [u32; CAPACITY],
}

impl Set {
    fn items(&self) -> &[u32] {
        &self.items[..self.len as usize]
    }

    #[inline]
    pub fn contains(&self, r: u32) -> bool {
        self.items().contains(&r)
    }

    /// The highest: the owner of the point.
    #[inline]
    pub fn top(&self) -> Option<u32> {
        self.items().last().copied()
    }

    /// Adds `r` (not yet in); `None` where there is no room.
    #[inline]
    pub fn insert(&mut self, r: u32) -> Option<()> {
        let n = self.len as usize;
        if n == CAPACITY {
            return None;
        }
        let mut at = n;
        while at > 0 && self.items[at - 1] > r {
            self.items[at] = self.items[at - 1];
            at -= 1;
        }
        self.items[at] = r;
        self.len += 1;
        Some(())
    }

    /// Takes `r` out, if it is in.
    #[inline]
    pub fn remove(&mut self, r: u32) {
        if let Some(at) = self.items().iter().position(|&x| x == r) {
            let n = self.len as usize;
            self.items.copy_within(at + 1..n, at);
            self.len -= 1;
        }
    }

    /// In becomes out, out becomes in.
    #[inline]
    pub fn toggle(&mut self, r: u32) -> Option<()> {
        if self.contains(r) {
            self.remove(r);
            Some(())
        } else {
            self.insert(r)
        }
    }
}

/// Surfaces met at exactly the same distance.
pub(super) struct Group {
    pub distance: f64,
    len: usize,
    overflow: bool,
    /// Region number and (lowest bit) whether it is entered.
    items: [u32; CAPACITY],
}

impl Group {
    /// An empty group that takes surfaces up to `limit`.
    #[inline]
    pub fn new(limit: f64) -> Self {
        Group { distance: limit, len: 0, overflow: false, items: [0; CAPACITY] }
    }

    /// Takes a surface at `t` if it is as near as those so far, and drops these if it is nearer.
    #[inline]
    pub fn offer(&mut self, t: f64, r: u32, enters: bool) {
        if t < self.distance {
            (self.distance, self.len, self.overflow) = (t, 0, false);
        }
        if t == self.distance && t < f64::INFINITY {
            if self.len == CAPACITY {
                self.overflow = true;
            } else {
                self.items[self.len] = r << 1 | u32::from(enters);
                self.len += 1;
            }
        }
    }

    #[inline]
    pub fn found(&self) -> bool {
        self.len > 0
    }

    #[inline]
    pub fn single(&self) -> bool {
        self.len == 1
    }

    /// Crosses all surfaces of the group, leaving before entering so that room is there; `None`
    /// where there is none.
    #[inline]
    pub fn apply(&self, set: &mut Set) -> Option<()> {
        let items = &self.items[..self.len];
        items.iter().filter(|i| *i & 1 == 0).for_each(|i| set.remove(i >> 1));
        for i in items.iter().filter(|i| *i & 1 == 1) {
            set.insert(i >> 1)?;
        }
        (!self.overflow).then_some(())
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
    pub(super) left: u32,
    /// Region whose interface lies ahead; or `NONE`.
    pub(super) region: u32,
    /// The interface is the only surface up to and at its distance.
    pub(super) single: bool,
    /// No way to go on: more regions at one point than the set can hold.
    pub(super) lost: bool,
    /// The ray last asked for.
    pub(super) ray: Ray,
    /// Distance of the first surface of any kind (buried ones too), or ∞.
    pub(super) quiet: f64,
    /// Distance of the interface, or ∞.
    pub(super) distance: f64,
}

impl Place {
    pub(super) fn new(ray: Ray) -> Self {
        Place {
            inside: Set::default(),
            left: NONE,
            region: NONE,
            single: false,
            lost: false,
            ray,
            quiet: f64::INFINITY,
            distance: f64::INFINITY,
        }
    }

    /// Forgets what lay ahead; `ray` is about to be asked for.
    #[inline]
    pub(super) fn look(&mut self, ray: Ray) {
        self.ray = ray;
        self.region = NONE;
        self.single = false;
        self.quiet = f64::INFINITY;
        self.distance = f64::INFINITY;
    }

    /// An interface with `region` lies ahead.
    #[inline]
    pub(super) fn await_interface(&mut self, distance: f64, region: u32, single: bool) {
        self.distance = distance;
        self.region = region;
        self.single = single;
    }

    /// The ray has arrived among the regions `set` (`None`: too many) and goes on along `ray`.
    #[inline]
    pub(super) fn settle(&mut self, set: Option<Set>, left: u32, ray: Ray) {
        match set {
            Some(set) => self.inside = set,
            None => self.lost = true,
        }
        self.left = left;
        self.look(ray);
    }

    /// Whether the ray is in more regions than can be told: it goes on nowhere.
    pub fn is_lost(&self) -> bool {
        self.lost
    }
}
