//! A straight flight through regions: surfaces in order, until one of them parts two media.
//!
//! What the ray is in follows from its state, never from a point test: ways out of the regions that
//! contain it, and the hollows of these, are computed at once; regions that it is outside of come
//! from an index ([`Space::entries`]), nearest first. Surfaces at exactly the same distance are
//! crossed at once.

use super::place::{Group, Known, Place, Set};
use super::region::{Event, Key, Owner, Region, Rule, seen_from};
use crate::math::DVec3;
use crate::universe::shape::{Chord, Shape, ShapeFace};
use crate::universe::{Interface, Ray, against};

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
    if key == asker.left || asker.inside.contains(key) || group.holds(key) {
        return;
    }
    if let Some(c) = region.part.shape.way_through(&seen_from(asker.ray, key, period))
        && c.t_in > after
        && c.t_in <= group.distance
    {
        group.offer(Event { t: c.t_in, key, enters: true, face: c.face_in });
    }
}

/// A flight under way.
struct Flight<'a, S: Space> {
    space: &'a mut S,
    ray: &'a Ray,
    set: Set,
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
    fn begin(&mut self, place: &Place) -> Option<()> {
        for &key in place.inside.items() {
            let region = self.region(key);
            let (t, face) = region.part.shape.way_out_face(&seen_from(self.ray, key, self.space.period()));
            let hollow = region.hollow().map(|h| key.of(h));
            self.known.push(Event { t, key, enters: false, face })?;
            if let Some(hollow) = hollow
                && hollow != place.left
                && !place.inside.contains(hollow)
                && let Some(c) = self.chord(hollow)
            {
                self.known.push(Event { t: c.t_in, key: hollow, enters: true, face: c.face_in })?;
            }
        }
        Some(())
    }

    /// The nearest surfaces beyond `after`.
    fn nearest(&mut self, cursor: &mut S::Cursor, place: &Place, after: f64, limit: f64) -> Group {
        let mut group = Group::new(limit);
        self.known.items().iter().for_each(|e| group.offer(*e));
        let asker = Asker { ray: self.ray, inside: &place.inside, left: place.left };
        self.space.entries(cursor, &asker, after, &mut group);
        group
    }

    /// Crosses all surfaces of a group: out of regions first, so that room is there. A hollow that
    /// shares the cap of its body is entered with it. `None` where there is no room.
    fn cross(&mut self, group: &Group) -> Option<()> {
        for e in group.items().iter().filter(|e| !e.enters) {
            self.set.remove(e.key);
        }
        for e in group.items().iter().filter(|e| e.enters) {
            self.set.insert(e.key)?;
            let region = self.region(e.key);
            if (e.face != ShapeFace::Side || region.flush)
                && let Some(hollow) = region.hollow().map(|h| e.key.of(h))
                && self.chord(hollow).is_some_and(|c| c.t_in <= e.t)
            {
                self.set.insert(hollow)?;
            }
        }
        (!group.overflow).then_some(())
    }

    /// Goes on behind buried surfaces: what has been entered has ways out and hollows.
    fn pass(&mut self, group: &Group) -> Option<()> {
        self.known.pass(group.distance);
        for e in group.items().iter().filter(|e| e.enters) {
            let Some(c) = self.chord(e.key) else { continue };
            self.known.push(Event { t: c.t_out, key: e.key, enters: false, face: c.face_out })?;
            if let Some(hollow) = self.region(e.key).hollow().map(|h| e.key.of(h))
                && let Some(c) = self.chord(hollow)
            {
                let (enters, t, face) = match self.set.contains(hollow) {
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
    let ray = place.ray;
    let mut cursor = space.search(&ray);
    let mut flight = Flight { space, ray: &ray, set: place.inside, known: Known::new() };
    let mut after = f64::NEG_INFINITY;
    if flight.begin(place).is_none() {
        return Found::Lost;
    }
    loop {
        let group = flight.nearest(&mut cursor, place, after, limit);
        if group.items().is_empty() {
            place.before.copy_from(&flight.set);
            place.seen = limit;
            return Found::Nothing;
        }
        place.before.copy_from(&flight.set);
        if flight.cross(&group).is_none() {
            return Found::Lost;
        }
        place.quiet = place.quiet.min(group.distance);
        if stops && let Some(met) = judge(flight.space, &place.before, &flight.set, &group) {
            place.beyond.copy_from(&flight.set);
            place.seen = group.distance;
            place.distance = group.distance;
            place.region = met.event.key;
            return Found::Met(met);
        }
        if flight.pass(&group).is_none() {
            return Found::Lost;
        }
        after = group.distance;
    }
}

/// Whether the surfaces of a group part two media, and which of them does.
fn judge<S: Space>(space: &S, before: &Set, after: &Set, group: &Group) -> Option<Met> {
    let rule = space.rule();
    let owner = |set: &Set| rule.owner(set.items(), |k| space.region(k.region()));
    let (old, new) = (owner(before), owner(after));
    // Of several surfaces at one place, that of the owner on either side with the higher rank.
    let standing = |e: &&Event| {
        let body = |k: Key| {
            let r = space.region(k.region());
            if r.is_hole() { k.of(r.outer) } else { k }
        };
        let own = |o: &Owner| o.key != Key::NONE && body(o.key) == body(e.key);
        (own(&old) || own(&new), space.region(e.key.region()).rank, e.key)
    };
    let event = match group.items() {
        [one] => *one,
        several => *several.iter().max_by_key(standing)?,
    };
    let surface = space.region(event.key.region()).part.surface;
    rule.separates(&old, &new, surface).then_some(Met { event, beyond: new })
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
