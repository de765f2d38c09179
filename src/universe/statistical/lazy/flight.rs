//! One flight of a ray: known bodies on the way, candidates of unknown ones, and the first change of
//! medium.

use super::memory::{Chain, Known, Memory, NONE, Piece, Sighting, Touched};
use super::{Exactness, LazyUniverse, Place, Stands};
use crate::math::DVec3;
use crate::rng::Stream;
use crate::universe::statistical::pick;
use crate::universe::statistical::section::Left;
use crate::universe::{MediumId, Overlap, Ray};

/// A surface where the medium changes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    pub distance: f64,
    pub body: u32,
    pub surface: Left,
    /// Into the body (or its lumen).
    pub enters: bool,
    pub beyond: MediumId,
    pub layer: u16,
    /// Outward normal, where it is known already.
    pub outward: Option<DVec3>,
}

/// Medium just behind distance `t`.
///
/// Wall intervals are those of the present flight: a counter carried along would drift in the grooves
/// between overlapping bodies.
#[inline]
pub(super) fn medium_behind(touched: &[Touched], t: f64, overlap: Overlap, pore: MediumId) -> MediumId {
    let (mut wall, mut lumen) = ((-1.0, pore), (-1.0, pore));
    for b in touched.iter().filter(|b| b.spans.holds(t)) {
        if b.spans.in_lumen(t) {
            if b.solid.mark > lumen.0 {
                lumen = (b.solid.mark, b.solid.lumen);
            }
        } else if b.solid.mark > wall.0 {
            wall = (b.solid.mark, b.solid.wall);
        }
    }
    match overlap {
        Overlap::Priority if lumen.0 > wall.0 => lumen.1,
        _ if wall.0 >= 0.0 => wall.1,
        _ => lumen.1,
    }
}

/// Whether a body holds the point at distance `t`.
pub(super) fn covered(touched: &[Touched], t: f64) -> bool {
    touched.iter().any(|b| b.spans.holds(t))
}

/// All boundaries of a touched body: distance, which surface, inwards.
#[inline]
pub(super) fn boundaries(t: &Touched) -> [(f64, Left, bool); 4] {
    let (s, [a, b, c, d]) = (&t.spans, t.spans.surfaces);
    [(s.from, a, true), (s.to, b, false), (s.lumen_from, c, true), (s.lumen_to, d, false)]
}

/// A surface of a touched body on the way.
#[derive(Clone, Copy)]
pub(super) struct Boundary {
    pub distance: f64,
    pub surface: Left,
    /// Into the body, or its lumen.
    pub enters: bool,
    pub body: u32,
}

const NOWHERE: Boundary =
    Boundary { distance: f64::INFINITY, surface: Left::Nothing, enters: false, body: NONE };

/// The medium at the ray is not the one that it is said to be in.
pub(super) struct Misplaced;

/// In a sheet of one solid, from outside all walls: the first wall ahead.
#[inline]
fn way_in(touched: &[Touched]) -> Result<Boundary, Misplaced> {
    let mut first = NOWHERE;
    for t in touched {
        let (s, body) = (&t.spans, t.body);
        // The wall before the lumen, and the one behind it; walls of no width (an open end) are none.
        let hollow = s.lumen_from.min(s.to);
        if (s.from <= 0.0 && hollow > 0.0) || (s.lumen_to <= 0.0 && s.to > 0.0) {
            return Err(Misplaced);
        }
        if s.from > 0.0 && s.from < first.distance && hollow > s.from {
            first = Boundary { distance: s.from, surface: s.surfaces[0], enters: true, body };
        } else if s.lumen_to > 0.0 && s.lumen_to < first.distance && s.to > s.lumen_to {
            first = Boundary { distance: s.lumen_to, surface: s.surfaces[3], enters: false, body };
        }
    }
    Ok(first)
}

/// In a sheet of one solid, from inside walls: the end of all walls that follow each other.
#[inline]
fn way_out(touched: &[Touched]) -> Result<Boundary, Misplaced> {
    let mut last = Boundary { distance: 0.0, ..NOWHERE };
    loop {
        let before = last.distance;
        for t in touched {
            let (s, body) = (&t.spans, t.body);
            let reaches = |from: f64, to: f64, last: &Boundary| from <= last.distance && to > last.distance;
            if s.meets_lumen() && reaches(s.from, s.lumen_from, &last) {
                last = Boundary { distance: s.lumen_from, surface: s.surfaces[2], enters: true, body };
            }
            let behind = if s.meets_lumen() { s.lumen_to } else { s.from };
            if reaches(behind, s.to, &last) {
                last = Boundary { distance: s.to, surface: s.surfaces[1], enters: false, body };
            }
        }
        if last.distance == before {
            break;
        }
    }
    if last.body == NONE { Err(Misplaced) } else { Ok(last) }
}

impl Boundary {
    /// Takes a boundary if it lies behind `from` and is nearer.
    #[inline]
    fn offer(&mut self, (t, surface, enters): (f64, Left, bool), body: u32, from: f64) {
        if t > from && (t < self.distance || t == self.distance && self.body == NONE) {
            *self = Boundary { distance: t, surface, enters, body };
        }
    }
}

impl<E: Exactness> LazyUniverse<E> {
    /// Follows the ray for `reach` at most; keeps the explored segment and the bodies met.
    pub(super) fn fly(
        &self,
        ray: &Ray,
        place: &mut Place,
        m: &mut Memory,
        reach: f64,
        rng: &mut Stream,
    ) -> Result<Option<Change>, Misplaced> {
        let layer = usize::from(place.layer);
        let mean_free = self.sheet.rates[layer].last().map_or(f64::INFINITY, |rate| 1.0 / rate);
        let mut scanned = f64::NEG_INFINITY;
        // Where the next unknown body may be; it is drawn only if nothing known comes before.
        let mut at = rng.exponential() * mean_free;
        let mut horizon = f64::NEG_INFINITY;
        let (found, end) = loop {
            let stop = at.min(reach);
            if stop > horizon {
                // Twice as far each time: a long flight past many bodies asks each of them a few times only.
                horizon = if horizon > 0.0 { (2.0 * stop).min(reach) } else { stop };
                self.touch(ray, place, horizon, m);
            }
            if let Some(change) = self.first_change(ray, place, m, scanned, stop)? {
                break (Some(change), change.distance);
            }
            if at >= reach {
                break (None, reach);
            }
            if let Some(change) = self.discover(ray, place, m, at, rng) {
                break (Some(change), at);
            }
            scanned = at;
            at += rng.exponential() * mean_free;
        };
        if end.is_finite() {
            if self.last != u32::MAX {
                self.see_again(place, m, end);
            }
            m.keep(&mut place.past, ray, end, place.layer);
        }
        Ok(found)
    }

    /// Asks for an unknown body whose surface the ray meets at distance `at`: it is known from now on. Its
    /// surface, if the medium changes there.
    #[inline]
    fn discover(
        &self,
        ray: &Ray,
        place: &mut Place,
        m: &mut Memory,
        at: f64,
        rng: &mut Stream,
    ) -> Option<Change> {
        let layer = usize::from(place.layer);
        let rates = &self.sheet.rates[layer];
        let population = &self.sheet.layers[layer];
        let index = pick(rates, *rates.last()?, rng);
        let kind = &population.kinds[index];
        let met = kind.candidate(ray.dir, ray.at(at), index as u16, rng)?;
        if !population.stands(self.sheet.contained, kind, &met.body, rng) {
            return None;
        }
        let known = self.known(kind, met.body, rng);
        if !self.is_new(ray, place, m, &known, at) {
            return None;
        }
        let flight = place.past.flights + 1;
        let body = m.learn(&mut place.past, known, place.layer, flight);
        place.stale = 0;
        let beyond = self.enters(ray, place, m, body, at)?;
        Some(Change {
            distance: at,
            body,
            surface: met.surface,
            enters: true,
            beyond,
            layer: place.layer,
            outward: Some(met.outward),
        })
    }

    /// Whether a candidate at distance `at` is a body that could not be known yet.
    fn is_new(&self, ray: &Ray, place: &Place, m: &Memory, known: &Known, at: f64) -> bool {
        if !E::CANDIDATES_INSIDE && covered(&m.touched, at) {
            return false;
        }
        if E::PRESENT_FLIGHT_REJECTS && known.body.spans(ray.origin, ray.dir, None).is_some() {
            return false;
        }
        if self.overlap == Overlap::Forbid
            && (covered(&m.touched, at) || self.clashes(place, &known.body, place.layer, m))
        {
            return false;
        }
        let most = if E::EVERY_SEGMENT_REJECTS { self.last } else { 1 };
        !m.would_have_seen(&place.past, &known.body, place.layer, most, E::WHOLE_BODY_REJECTS)
    }

    /// Collects the known bodies that the ray touches within `stop`.
    pub(super) fn touch(&self, ray: &Ray, place: &Place, stop: f64, m: &mut Memory) {
        let mut touched = std::mem::take(&mut m.touched);
        touched.clear();
        let full = self.last == u32::MAX;
        let chain = if full { m.chain(&place.past) } else { Chain::Linked };
        if let Chain::Many = chain {
            let half = 0.5 * stop.max(0.0);
            let ball = if half.is_finite() { (ray.at(half), half) } else { (ray.origin, f64::INFINITY) };
            let mean_free = self.sheet.rates[usize::from(place.layer)].last().map_or(0.0, |r| 1.0 / r);
            m.gather_near(ball, 2.0 * mean_free);
        }
        let piece = Piece::new(ray, stop);
        let meet = |s: &Sighting, touched: &mut Vec<Touched>| {
            if !s.misses(&piece) && s.layer == place.layer {
                Self::meet(ray, place, stop, s.body, m, touched);
            }
        };
        match chain {
            Chain::Few => m.all().iter().for_each(|s| meet(s, &mut touched)),
            Chain::Many => m.nearby().for_each(|s| meet(s, &mut touched)),
            Chain::Linked => {
                let oldest = (place.past.flights + 1).saturating_sub(self.last);
                let mut index = place.past.sighting;
                while index != NONE {
                    let s = &m.sightings[index as usize];
                    if s.flight < oldest {
                        break;
                    }
                    index = s.before;
                    if full || !touched.iter().any(|t| t.body == s.body) {
                        meet(s, &mut touched);
                    }
                }
            }
        }
        m.touched = touched;
    }

    /// Adds a known body to those touched if the ray meets it within `stop`.
    #[inline]
    fn meet(ray: &Ray, place: &Place, stop: f64, body: u32, m: &Memory, touched: &mut Vec<Touched>) {
        if let Some(t) = Self::touched(ray, place, body, m)
            && t.spans.to >= 0.0
            && t.spans.from <= stop
        {
            touched.push(t);
        }
    }

    /// A known body on the line of the ray.
    #[inline]
    pub(super) fn touched(ray: &Ray, place: &Place, body: u32, m: &Memory) -> Option<Touched> {
        let known = &m.bodies[body as usize];
        let left = match place.stands {
            Some(Stands { body: b, surface, inside }) if b == body => Some((surface, inside)),
            _ => None,
        };
        let spans = known.body.spans(ray.origin, ray.dir, left)?;
        Some(Touched { spans, body, solid: known.solid })
    }

    /// The first change of medium among the touched bodies behind `scanned` and up to `stop`.
    #[inline]
    fn first_change(
        &self,
        ray: &Ray,
        place: &Place,
        m: &mut Memory,
        scanned: f64,
        stop: f64,
    ) -> Result<Option<Change>, Misplaced> {
        match self.change_ahead(place, m, scanned, stop) {
            Err(Misplaced) => self.groove(ray, place, m, (scanned, stop)),
            found => found,
        }
    }

    /// The same, if the touched bodies agree with the medium that the ray is said to be in.
    #[inline]
    pub(super) fn change_ahead(
        &self,
        place: &Place,
        m: &Memory,
        scanned: f64,
        stop: f64,
    ) -> Result<Option<Change>, Misplaced> {
        let Some(wall) = self.only_wall else { return self.any_change(place, m, scanned, stop) };
        let found = if place.medium == wall { way_out(&m.touched) } else { way_in(&m.touched) };
        let found = found?;
        if found.body == NONE || found.distance > stop {
            return Ok(None);
        }
        let Boundary { distance, surface, enters, body } = found;
        let beyond =
            if place.medium == wall { self.sheet.layers[usize::from(place.layer)].slab.pore } else { wall };
        Ok(Some(Change { distance, body, surface, enters, beyond, layer: place.layer, outward: None }))
    }

    /// The same for any number of media and any rule.
    fn any_change(
        &self,
        place: &Place,
        m: &Memory,
        scanned: f64,
        stop: f64,
    ) -> Result<Option<Change>, Misplaced> {
        let pore = self.sheet.layers[usize::from(place.layer)].slab.pore;
        let mut from = scanned;
        if scanned < 0.0 {
            if medium_behind(&m.touched, 0.0, self.overlap, pore) != place.medium {
                return Err(Misplaced);
            }
            from = 0.0;
        }
        if m.touched.is_empty() {
            return Ok(None);
        }
        loop {
            let mut next = Boundary { distance: stop, ..NOWHERE };
            for b in &m.touched {
                boundaries(b).into_iter().for_each(|boundary| next.offer(boundary, b.body, from));
            }
            if next.body == NONE {
                return Ok(None);
            }
            let Boundary { distance, surface, enters, body } = next;
            let beyond = medium_behind(&m.touched, distance, self.overlap, pore);
            if beyond != place.medium {
                let layer = place.layer;
                return Ok(Some(Change { distance, body, surface, enters, beyond, layer, outward: None }));
            }
            from = distance;
        }
    }

    /// Adds the body just learnt to the flight; the medium behind its surface, if that is a change.
    fn enters(&self, ray: &Ray, place: &Place, m: &mut Memory, body: u32, at: f64) -> Option<MediumId> {
        let mut t = Self::touched(ray, place, body, m)?;
        t.spans.from = at;
        if t.spans.meets_lumen() && t.spans.surfaces[2] == Left::Cap {
            t.spans.lumen_from = at; // the opening begins at the same end
        }
        m.touched.push(t);
        let pore = self.sheet.layers[usize::from(place.layer)].slab.pore;
        let beyond = medium_behind(&m.touched, at, self.overlap, pore);
        (beyond != place.medium).then_some(beyond)
    }

    /// A finite memory keeps the bodies that the flight has touched, also those from before.
    fn see_again(&self, place: &mut Place, m: &mut Memory, end: f64) {
        let flight = place.past.flights + 1;
        for i in 0..m.touched.len() {
            let t = m.touched[i];
            if t.spans.from <= end {
                let s = Sighting::of(&m.bodies[t.body as usize].body, t.body, place.layer, flight);
                m.see(&mut place.past, s);
            }
        }
    }
}
