//! One flight of a ray: known bodies on the way, candidates of unknown ones, and the first change of
//! medium.

use super::memory::{Known, Memory, NONE, Sighting, Touched};
use super::{Exactness, LazyUniverse, Overlap, Place, Stands};
use crate::math::DVec3;
use crate::rng::Stream;
use crate::universe::statistical::section::{Left, Span};
use crate::universe::{MediumId, Ray};

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
    for b in touched.iter().filter(|b| b.spans.outer.holds(t)) {
        if b.spans.lumen.is_some_and(|l| l.holds(t)) {
            if b.mark > lumen.0 {
                lumen = (b.mark, b.lumen);
            }
        } else if b.mark > wall.0 {
            wall = (b.mark, b.wall);
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
    touched.iter().any(|b| b.spans.outer.holds(t))
}

/// The unit normal against the ray. Where rounding leaves that of a grazing hit on the wrong side, it is
/// turned to the right one.
#[inline]
pub(super) fn against(dir: DVec3, normal: DVec3) -> DVec3 {
    let cos = normal.dot(dir);
    if cos >= 0.0 { (normal - dir * (cos + cos.max(4.0 * f64::EPSILON))).normalize() } else { normal }
}

/// A boundary of a touched body: distance, which surface, inwards.
type Boundary = (f64, Left, bool);

/// All boundaries of a touched body.
#[inline]
fn boundaries(b: &Touched) -> impl Iterator<Item = Boundary> {
    let ends = |s: Span| [(s.from, s.first, true), (s.to, s.last, false)];
    ends(b.spans.outer).into_iter().chain(b.spans.lumen.into_iter().flat_map(ends))
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
    ) -> Option<Change> {
        let layer = usize::from(place.layer);
        let mut scanned = f64::NEG_INFINITY;
        let mut candidate = self.candidate(layer, ray, 0.0, reach, rng);
        let (found, end) = loop {
            let stop = candidate.as_ref().map_or(reach, |c| c.0);
            self.touch(ray, place, stop, m);
            if let Some(change) = self.first_change(ray, place, m, scanned, stop) {
                break (Some(change), change.distance);
            }
            let Some((at, met)) = candidate else { break (None, reach) };
            let known = Known { body: met.body, mark: self.mark(rng) };
            if self.is_new(ray, place, m, &known, at) {
                let flight = place.past.flights + 1;
                let body = m.learn(&mut place.past, known, place.layer, flight);
                place.stale = 0;
                if let Some(beyond) = self.enters(ray, place, m, body, at) {
                    let (surface, outward) = (met.surface, Some(met.outward));
                    let layer = place.layer;
                    break (
                        Some(Change { distance: at, body, surface, enters: true, beyond, layer, outward }),
                        at,
                    );
                }
            }
            scanned = at;
            candidate = self.candidate(layer, ray, at, reach, rng);
        };
        if end.is_finite() {
            if self.last != u32::MAX {
                self.see_again(place, m, end);
            }
            m.keep(&mut place.past, ray, end, place.layer);
        }
        found
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
        m.touched.clear();
        let half = 0.5 * stop.max(0.0);
        let (middle, half) = if half.is_finite() { (ray.at(half), half) } else { (ray.origin, f64::INFINITY) };
        let oldest = (place.past.flights + 1).saturating_sub(self.last);
        let mut index = place.past.sighting;
        while index != NONE {
            let s = m.sightings[index as usize];
            if s.flight < oldest {
                break;
            }
            index = s.before;
            if s.layer != place.layer || !s.near(middle, half) {
                continue;
            }
            if self.last != u32::MAX && m.touched.iter().any(|t| t.body == s.body) {
                continue;
            }
            if let Some(t) = self.touched(ray, place, s.body, m)
                && t.spans.outer.to >= 0.0
                && t.spans.outer.from <= stop
            {
                m.touched.push(t);
            }
        }
    }

    /// A known body on the line of the ray.
    #[inline]
    fn touched(&self, ray: &Ray, place: &Place, body: u32, m: &Memory) -> Option<Touched> {
        let known = &m.bodies[body as usize];
        let left = match place.stands {
            Some(Stands { body: b, surface, inside }) if b == body => Some((surface, inside)),
            _ => None,
        };
        let spans = known.body.spans(ray.origin, ray.dir, left)?;
        let kind = &self.sheet.layers[usize::from(place.layer)].kinds[usize::from(known.body.kind)];
        Some(Touched { spans, body, mark: known.mark, wall: kind.wall, lumen: kind.lumen })
    }

    /// The first change of medium among the touched bodies behind `scanned` and up to `stop`.
    fn first_change(&self, ray: &Ray, place: &Place, m: &Memory, scanned: f64, stop: f64) -> Option<Change> {
        let pore = self.sheet.layers[usize::from(place.layer)].slab.pore;
        let mut from = scanned;
        if scanned < 0.0 {
            if medium_behind(&m.touched, 0.0, self.overlap, pore) != place.medium {
                return self.groove(ray, place, m, pore);
            }
            from = 0.0;
        }
        loop {
            let mut first: Option<(Boundary, u32)> = None;
            for b in &m.touched {
                for boundary in boundaries(b) {
                    let t = boundary.0;
                    if t > from && t <= stop && first.is_none_or(|f| t < f.0.0) {
                        first = Some((boundary, b.body));
                    }
                }
            }
            let ((distance, surface, enters), body) = first?;
            let beyond = medium_behind(&m.touched, distance, self.overlap, pore);
            if beyond != place.medium {
                let layer = place.layer;
                return Some(Change { distance, body, surface, enters, beyond, layer, outward: None });
            }
            from = distance;
        }
    }

    /// The ray stands in the groove between two bodies, and rounding has put it beyond the second
    /// surface: it meets that surface where it stands.
    fn groove(&self, ray: &Ray, place: &Place, m: &Memory, pore: MediumId) -> Option<Change> {
        let mut nearest: Option<(Boundary, u32)> = None;
        let mut index = place.past.sighting;
        while index != NONE {
            let Sighting { body, before, layer, .. } = m.sightings[index as usize];
            index = before;
            if layer != place.layer {
                continue;
            }
            let Some(t) = self.touched(ray, place, body, m) else { continue };
            for b in boundaries(&t) {
                if b.0.is_finite() && nearest.is_none_or(|n| b.0.abs() < n.0.0.abs()) {
                    nearest = Some((b, body));
                }
            }
        }
        let ((_, surface, enters), body) = nearest?;
        let beyond = medium_behind(&m.touched, 0.0, self.overlap, pore);
        Some(Change { distance: 0.0, body, surface, enters, beyond, layer: place.layer, outward: None })
    }

    /// Adds the body just learnt to the flight; the medium behind its surface, if that is a change.
    fn enters(&self, ray: &Ray, place: &Place, m: &mut Memory, body: u32, at: f64) -> Option<MediumId> {
        let mut t = self.touched(ray, place, body, m)?;
        t.spans.outer.from = at;
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
            if t.spans.outer.from <= end {
                let s = Sighting::of(&m.bodies[t.body as usize].body, t.body, place.layer, flight);
                m.see(&mut place.past, s);
            }
        }
    }
}
