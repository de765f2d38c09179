//! A straight flight through regions: surfaces in order, until one of them parts two media.
//!
//! What the ray is in follows from its state, never from a point test: ways out of the regions that
//! contain it, and the hollows of these, are computed at once; regions that it is outside of come
//! from an index ([`Space::entries`]), nearest first. Surfaces at exactly the same distance are
//! crossed at once.

use super::place::{Group, Known, Place, Set};
use super::region::{Event, Key, Owner, Region, Rule, seen_from};
use crate::math::DVec3;
use crate::universe::shape::{Chord, Convex, Shape, ShapeFace};
use crate::universe::{Interface, Ray, against};
use arrayvec::ArrayVec;

/// What a ray knows of itself when it asks what it may enter.
pub(super) struct Asker<'a> {
    pub ray: &'a Ray,
    pub inside: &'a Set,
    pub left: Key,
}

/// Regions in space, with an index that tells which a ray may enter.
pub(super) trait Space {
    /// Where a search along a ray stands.
    type Cursor;

    fn rule(&self) -> Rule;
    fn region(&self, number: usize) -> &Region;
    fn period(&self) -> [f64; 2];

    /// Begins a search along a ray.
    fn search(&mut self, ray: &Ray) -> Self::Cursor;

    /// Offers the nearest entries beyond the distance `after` into regions (hollows excepted) that
    /// the ray is outside of and has not just left. Calls of one search come with rising `after`.
    fn entries(&mut self, cursor: &mut Self::Cursor, asker: &Asker, after: f64, group: &mut Group);

    /// Numbers of all regions (hollows excepted) that may contain `point`.
    fn around(&mut self, point: DVec3, tell: impl FnMut(&Self, Key));
}

/// Where a ray enters a region that it is outside of and has not just left.
#[inline]
fn entry(region: &Region, key: Key, period: [f64; 2], asker: &Asker) -> Option<Event> {
    if key == asker.left || asker.inside.contains(key) {
        return None;
    }
    let c = region.part.shape.way_through(&seen_from(asker.ray, key, period))?;
    Some(Event { t: c.t_in, key, enters: true, face: c.face_in })
}

/// Tests one region for an entry.
#[inline]
pub(super) fn try_entry(
    region: &Region,
    key: Key,
    period: [f64; 2],
    asker: &Asker,
    after: f64,
    group: &mut Group,
) {
    if !group.holds(key)
        && let Some(e) = entry(region, key, period, asker)
        && e.t > after
    {
        group.offer(e);
    }
}

/// Entries that a walk from cell to cell has found ahead: a body is tested once, though it lies in
/// several cells and a search behind a buried surface goes on in the same cell.
pub(super) struct Ahead {
    found: ArrayVec<Event, 12>,
    /// The present cell has been gone through, and all that is in it was kept.
    known: bool,
}

impl Ahead {
    pub fn new() -> Self {
        Ahead { found: ArrayVec::new_const(), known: false }
    }

    /// A search begins beyond `after`: offers what is known. Whether the present cell is.
    #[inline]
    pub fn recall(&mut self, after: f64, group: &mut Group) -> bool {
        if self.found.is_empty() {
            return self.known;
        }
        self.found.retain(|e| e.t > after);
        self.found.iter().for_each(|e| group.offer(*e));
        self.known
    }

    /// A cell is gone through: what it holds is known from now on.
    #[inline]
    pub fn look(&mut self) {
        self.known = true;
    }

    /// Tests one region for an entry. What finds no room is found again in its cell.
    #[inline]
    pub fn try_entry(
        &mut self,
        region: &Region,
        key: Key,
        period: [f64; 2],
        asker: &Asker,
        after: f64,
        group: &mut Group,
    ) {
        if !self.found.iter().any(|e| e.key == key)
            && !group.holds(key)
            && let Some(e) = entry(region, key, period, asker)
            && e.t > after
        {
            self.known &= self.found.try_push(e).is_ok();
            group.offer(e);
        }
    }
}

/// A flight under way.
struct Flight<'a, S: Space> {
    space: &'a mut S,
    ray: &'a Ray,
    known: Known,
}

impl<S: Space> Flight<'_, S> {
    fn region(&self, key: Key) -> &Region {
        self.space.region(key.region())
    }

    fn chord(&self, key: Key) -> Option<Chord> {
        self.region(key).part.shape.way_through(&seen_from(self.ray, key, self.space.period()))
    }

    /// Takes note of the ways out at the start.
    fn begin(&mut self, inside: &Set, left: Key) -> Option<()> {
        for &key in inside.items() {
            let region = self.space.region(key.region());
            let (o, d) = region.part.shape.local(&seen_from(self.ray, key, self.space.period()));
            let (t, face) = region.part.shape.shape.leaves(o, d);
            self.known.push(Event { t, key, enters: false, face })?;
            // A hollow stands in its body's frame: the same local ray.
            if let Some(hollow) = region.hollow()
                && let key = key.of(hollow)
                && key != left
                && !inside.contains(key)
                && let Some(c) = self.space.region(hollow as usize).way_from_body(o, d)
                && c.t_in < t
            {
                self.known.push(Event { t: c.t_in, key, enters: true, face: c.face_in })?;
            }
        }
        Some(())
    }

    /// Crosses all surfaces of a group: out of regions first, so that room is there. A hollow that
    /// shares the cap of its body is entered with it. `None` where there is no room.
    #[inline]
    fn cross(&self, set: &mut Set, group: &Group) -> Option<()> {
        for e in group.items().iter().filter(|e| !e.enters) {
            set.remove(e.key);
        }
        for e in group.items().iter().filter(|e| e.enters) {
            set.insert(e.key)?;
            let region = self.region(e.key);
            if (e.face != ShapeFace::Side || region.flush)
                && let Some(hollow) = region.hollow().map(|h| e.key.of(h))
                && self.chord(hollow).is_some_and(|c| c.t_in <= e.t)
            {
                set.insert(hollow)?;
            }
        }
        (!group.overflow).then_some(())
    }

    /// Goes on behind buried surfaces: what has been entered has ways out and hollows.
    fn pass(&mut self, set: &Set, group: &Group) -> Option<()> {
        self.known.pass(group.distance);
        for e in group.items().iter().filter(|e| e.enters) {
            let Some(c) = self.chord(e.key) else { continue };
            self.known.push(Event { t: c.t_out, key: e.key, enters: false, face: c.face_out })?;
            if let Some(hollow) = self.region(e.key).hollow().map(|h| e.key.of(h))
                && let Some(c) = self.chord(hollow)
            {
                let (enters, t, face) = match set.contains(hollow) {
                    true => (false, c.t_out, c.face_out),
                    // Rounding may put a thin wall's inner surface before its outer one.
                    false => (true, c.t_in.max(group.distance), c.face_in),
                };
                self.known.push(Event { t, key: hollow, enters, face })?;
            }
        }
        Some(())
    }
}

/// An interface ahead: the surface, and who owns the far side.
pub(super) struct Met {
    pub event: Event,
    pub beyond: Owner,
}

/// What a flight has found.
pub(super) enum Found {
    /// An interface.
    Met(Met),
    /// Nothing within the limit.
    Nothing,
    /// Too many regions at one point.
    Lost,
}

/// Flies along the place's ray up to `limit`, to the first interface if `stops`, and leaves in the
/// place what has been seen.
pub(super) fn fly<S: Space>(space: &mut S, place: &mut Place, limit: f64, stops: bool) -> Found {
    let Place { ray, inside, left, before, beyond, quiet, distance, seen, region, .. } = place;
    let mut cursor = space.search(ray);
    let mut flight = Flight { space, ray, known: Known::new() };
    if flight.begin(inside, *left).is_none() {
        return Found::Lost;
    }
    before.copy_from(inside);
    let mut old = stops.then(|| owner(flight.space, before));
    let mut after = f64::NEG_INFINITY;
    loop {
        let mut group = Group::new(limit);
        flight.known.items().iter().for_each(|e| group.offer(*e));
        let asker = Asker { ray, inside, left: *left };
        flight.space.entries(&mut cursor, &asker, after, &mut group);
        if group.items().is_empty() {
            *seen = limit;
            return Found::Nothing;
        }
        beyond.copy_from(before);
        if flight.cross(beyond, &group).is_none() {
            return Found::Lost;
        }
        *quiet = quiet.min(group.distance);
        if let Some(old) = &mut old {
            let new = owner(flight.space, beyond);
            if let Some(event) = judge(flight.space, old, &new, &group) {
                (*seen, *distance, *region) = (group.distance, group.distance, event.key);
                return Found::Met(Met { event, beyond: new });
            }
            *old = new;
        }
        if flight.pass(beyond, &group).is_none() {
            return Found::Lost;
        }
        before.copy_from(beyond);
        after = group.distance;
    }
}

#[inline]
fn owner<S: Space>(space: &S, set: &Set) -> Owner {
    space.rule().owner(set.items(), |k| space.region(k.region()))
}

/// The surface of a group that parts the media of `old` and `new`, if one does.
#[inline]
fn judge<S: Space>(space: &S, old: &Owner, new: &Owner, group: &Group) -> Option<Event> {
    let event = match group.items() {
        [one] => *one,
        several => *several.iter().max_by_key(|e| standing(space, old, new, e))?,
    };
    let surface = space.region(event.key.region()).part.surface;
    space.rule().separates(old, new, surface).then_some(event)
}

/// Of several surfaces at one place, that of the owner on either side with the higher rank.
fn standing<S: Space>(space: &S, old: &Owner, new: &Owner, e: &Event) -> (bool, u32, Key) {
    let body = |k: Key| {
        let r = space.region(k.region());
        if r.is_hole() { k.of(r.outer) } else { k }
    };
    let own = |o: &Owner| o.key != Key::NONE && body(o.key) == body(e.key);
    (own(old) || own(new), space.region(e.key.region()).rank, e.key)
}

/// The interface of `met` as the ray sees it.
#[inline]
pub(super) fn interface<S: Space>(space: &S, ray: &Ray, met: &Met) -> Interface {
    let Event { t, key, enters, face } = met.event;
    let part = &space.region(key.region()).part;
    let outward = part.shape.normal_on(&seen_from(ray, key, space.period()), t, face);
    let normal = against(ray.dir, if enters { outward } else { -outward });
    let axis = match part.shape.shape {
        Shape::Cylinder(_) => part.shape.frame.z,
        Shape::Slanted(s) => part.shape.frame.z + part.shape.frame.y * s.slope,
        _ => DVec3::ZERO,
    };
    Interface {
        distance: t,
        normal,
        facet: normal,
        axis,
        beyond: met.beyond.medium,
        surface: part.surface,
        body: part.body,
    }
}

/// The regions that a ray starts in. A point exactly on a surface is inside if the ray goes in; on the
/// plane of a slab or half space, where sheets are lit, it still stands before the plane and meets it
/// at distance 0.
pub(super) fn start<S: Space>(space: &mut S, ray: &Ray) -> Place {
    let mut place = Place::new(*ray);
    let inside = |s: &S, key: Key| {
        let shape = &s.region(key.region()).part.shape;
        let seen = seen_from(ray, key, s.period());
        shape.starts_inside(&seen) && !shape.meets_at_start(&seen)
    };
    space.around(ray.origin, |s, key| {
        if inside(s, key) {
            place.lost |= place.inside.insert(key).is_none();
            if let Some(hollow) = s.region(key.region()).hollow().map(|h| key.of(h))
                && inside(s, hollow)
            {
                place.lost |= place.inside.insert(hollow).is_none();
            }
        }
    });
    place
}

/// An event inside a medium after a way `d`: what the ray is in now.
pub(super) fn moved<S: Space>(space: &mut S, place: &mut Place, ray: &Ray, d: f64) {
    if place.quiet <= d {
        // Buried surfaces were passed on the way, but never the interface itself.
        if d < place.seen {
            if let Found::Lost = fly(space, place, d, false) {
                place.lost = true;
            }
        } else if place.seen.is_nan() {
            place.lost = true;
        }
        let Place { inside, before, .. } = place;
        inside.copy_from(before);
    }
    place.left = Key::NONE;
    place.look(*ray);
}
