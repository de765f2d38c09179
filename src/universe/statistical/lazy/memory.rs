//! What a history has met: bodies and traced segments, append-only. A place holds the newest entry of
//! its own past, each entry the one before: a branch is a copy of a place and sees only its own past.

use crate::math::{DVec3, Frame};
use crate::universe::statistical::section::{Body, Spans};
use crate::universe::{Kept, MediumId, Ray};

/// No entry.
pub(super) const NONE: u32 = u32::MAX;

/// The newest entries of a past.
#[derive(Clone, Copy, Debug)]
pub struct Past {
    pub(super) sighting: u32,
    pub(super) segment: u32,
    /// Flights so far: the ordinal of the newest.
    pub(super) flights: u32,
}

/// Nothing known.
pub(super) const NOTHING: Past = Past { sighting: NONE, segment: NONE, flights: 0 };

/// A body as far as a quick test needs it: the box around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sighting {
    centre: DVec3,
    frame: Frame,
    /// Half sizes along the frame's axes.
    half: DVec3,
    /// The body itself.
    pub body: u32,
    /// Flight on which it was met.
    pub flight: u32,
    pub layer: u16,
    pub before: u32,
}

impl Sighting {
    pub fn of(body: &Body, index: u32, layer: u16, flight: u32) -> Self {
        let h = &body.outer;
        Sighting {
            centre: body.centre,
            frame: body.frame,
            half: DVec3::new(h.a, h.b, h.c.min(body.ends)),
            body: index,
            flight,
            layer,
            before: NONE,
        }
    }

    /// False only if the body surely misses the ball of radius `r` about `p`: the box around the body
    /// does, by one of its faces. The margin is above the rounding of the products.
    #[inline]
    pub fn near(&self, p: DVec3, r: f64) -> bool {
        let w = p - self.centre;
        let r = r * (1.0 + 1e-9) + 1e-12 * (w.x.abs() + w.y.abs() + w.z.abs());
        w.dot(self.frame.y).abs() <= self.half.y + r
            && w.dot(self.frame.x).abs() <= self.half.x + r
            && (self.half.z.is_infinite() || w.dot(self.frame.z).abs() <= self.half.z + r)
    }
}

/// A straight piece of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    from: DVec3,
    dir: DVec3,
    length: f64,
    layer: u16,
    before: u32,
}

impl Segment {
    /// Whether a body holds a point of the segment (the planted fault: and the segment misses its lumen).
    #[inline]
    fn meets(&self, body: &Body, whole: bool) -> bool {
        let Some(s) = body.spans(self.from, self.dir, None) else { return false };
        let (a, b) = (s.from.max(0.0), s.to.min(self.length));
        a <= b && (whole || s.lumen_from >= b || s.lumen_to <= a)
    }
}

/// Segments whose bounds are kept together.
const RUN: usize = 16;

/// A box around a run of segments.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    const EMPTY: Bounds = Bounds { low: DVec3::splat(f64::INFINITY), high: DVec3::splat(f64::NEG_INFINITY) };

    fn with(self, other: Bounds) -> Bounds {
        Bounds { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn ball(&self) -> (DVec3, f64) {
        (0.5 * (self.low + self.high), 0.5 * (self.high - self.low).length())
    }
}

/// A known body on the present flight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touched {
    pub spans: Spans,
    pub body: u32,
    pub solid: Solid,
}

/// What a body is made of, and its random mark: of two that overlap the higher rules.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solid {
    pub mark: f64,
    pub wall: MediumId,
    pub lumen: MediumId,
}

/// A body that has been met.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub body: Body,
    pub solid: Solid,
}

/// Bodies known before a list of the near ones pays.
const MANY: usize = 8;

/// The known bodies near a ball: most flights of a long history stay in it for a while, and need not ask
/// the others.
#[derive(Debug, Default)]
struct Nearby {
    /// Sightings that reach into the ball, among those before `through`.
    list: Vec<u32>,
    centre: DVec3,
    radius: f64,
    through: usize,
}

/// Memory of a history; cleared between histories, never freed.
#[derive(Debug)]
pub struct Memory {
    pub(super) bodies: Vec<Known>,
    pub(super) sightings: Vec<Sighting>,
    segments: Vec<Segment>,
    /// Boxes around runs of [`RUN`] segments, and around runs of such runs.
    runs: Vec<Bounds>,
    runs_of_runs: Vec<Bounds>,
    nearby: Nearby,
    /// The present chain of sightings begins here, and is unbranched so far.
    first_sighting: usize,
    unbranched: bool,
    /// Scratch of a flight.
    pub(super) touched: Vec<Touched>,
    /// Where the present chain of segments begins; it is unbranched so far if `straight`.
    base: usize,
    straight: bool,
    /// The past that new rays start with (histories that share a realisation).
    pub(super) common: Past,
    /// Pockets forgotten so far.
    pub(super) pockets: u64,
}

impl Default for Memory {
    fn default() -> Self {
        Memory {
            bodies: Vec::new(),
            sightings: Vec::new(),
            segments: Vec::new(),
            runs: Vec::new(),
            runs_of_runs: Vec::new(),
            nearby: Nearby::default(),
            first_sighting: 0,
            unbranched: true,
            touched: Vec::new(),
            base: 0,
            straight: true,
            common: NOTHING,
            pockets: 0,
        }
    }
}

impl Memory {
    pub(super) fn clear(&mut self) {
        self.bodies.clear();
        self.sightings.clear();
        self.segments.clear();
        self.runs.clear();
        self.runs_of_runs.clear();
        (self.base, self.straight, self.common, self.pockets) = (0, true, NOTHING, 0);
        (self.first_sighting, self.unbranched) = (0, true);
        self.nearby.list.clear();
        (self.nearby.radius, self.nearby.through) = (0.0, 0);
    }

    /// Bodies, segments and bytes in use.
    pub fn kept(&self) -> Kept {
        let bytes = size_of_val(&self.bodies[..])
            + size_of_val(&self.sightings[..])
            + size_of_val(&self.segments[..])
            + size_of_val(&self.runs[..])
            + size_of_val(&self.runs_of_runs[..]);
        Kept {
            bodies: self.bodies.len() as u64,
            segments: self.segments.len() as u64,
            bytes: bytes as u64,
            pockets: self.pockets,
        }
    }

    /// Everything known so far is known to the rays that start from now on.
    pub(super) fn share(&mut self) {
        let flights = self.segments.len() as u32;
        let last = |n: usize| if n == 0 { NONE } else { n as u32 - 1 };
        self.common =
            Past { sighting: last(self.sightings.len()), segment: last(self.segments.len()), flights };
    }

    /// A new body, known to `past` from now on, met on flight `flight`.
    pub(super) fn learn(&mut self, past: &mut Past, known: Known, layer: u16, flight: u32) -> u32 {
        let index = self.bodies.len() as u32;
        self.bodies.push(known);
        self.see(past, Sighting::of(&known.body, index, layer, flight));
        index
    }

    /// Another sighting of a known body.
    pub(super) fn see(&mut self, past: &mut Past, sighting: Sighting) {
        let index = self.sightings.len();
        if past.sighting == NONE {
            (self.first_sighting, self.unbranched) = (index, true);
            self.nearby.radius = 0.0;
        } else if past.sighting as usize + 1 != index {
            self.unbranched = false;
        }
        self.sightings.push(Sighting { before: past.sighting, ..sighting });
        past.sighting = index as u32;
    }

    /// The sightings of an unbranched past that may reach into the ball of radius `half` about `middle`,
    /// if there are so many that it pays; a list is kept for a ball larger by `slack`.
    pub(super) fn near(&mut self, past: &Past, middle: DVec3, half: f64, slack: f64) -> Option<&[u32]> {
        let n = self.sightings.len();
        if n - self.first_sighting < MANY || !self.unbranched || past.sighting as usize + 1 != n {
            return None;
        }
        let list = &mut self.nearby;
        let reaches = middle.distance(list.centre) + half;
        if list.radius == 0.0 || reaches.is_nan() || reaches > list.radius {
            list.list.clear();
            (list.centre, list.radius, list.through) = (middle, half + slack, self.first_sighting);
        }
        for (i, s) in self.sightings.iter().enumerate().skip(list.through) {
            if s.near(list.centre, list.radius) {
                list.list.push(i as u32);
            }
        }
        list.through = n;
        Some(&list.list)
    }

    /// A sighting of the list of the near ones.
    #[inline]
    pub(super) fn nearby(&self, i: usize) -> &Sighting {
        &self.sightings[self.nearby.list[i] as usize]
    }

    /// Keeps a traced segment.
    pub(super) fn keep(&mut self, past: &mut Past, ray: &Ray, length: f64, layer: u16) {
        let index = self.segments.len();
        if past.segment == NONE {
            (self.base, self.straight) = (index, true);
        } else if past.segment as usize + 1 != index {
            self.straight = false;
        }
        self.segments.push(Segment { from: ray.origin, dir: ray.dir, length, layer, before: past.segment });
        past.segment = index as u32;
        past.flights += 1;
        self.enclose();
    }

    /// Completes the boxes of runs that have become full.
    fn enclose(&mut self) {
        let n = self.segments.len();
        if n.is_multiple_of(RUN) {
            let run = self.segments[n - RUN..].iter().fold(Bounds::EMPTY, |b, s| {
                let to = s.from + s.dir * s.length;
                b.with(Bounds { low: s.from.min(to), high: s.from.max(to) })
            });
            self.runs.push(run);
            if self.runs.len().is_multiple_of(RUN) {
                let runs = &self.runs[self.runs.len() - RUN..];
                self.runs_of_runs.push(runs.iter().fold(Bounds::EMPTY, |a, b| a.with(*b)));
            }
        }
    }

    /// Whether a body of `layer` would have been met by an earlier segment of `past`, of the last `most`
    /// ones. `whole`: the body as a whole counts, not its wall only.
    pub(super) fn would_have_seen(
        &self,
        past: &Past,
        body: &Body,
        layer: u16,
        most: u32,
        whole: bool,
    ) -> bool {
        let quick = Sighting::of(body, 0, layer, 0);
        if most == u32::MAX && self.straight && past.segment as usize + 1 == self.segments.len() {
            return self.any_segment(&quick, body, whole);
        }
        let (mut index, mut left) = (past.segment, most);
        while index != NONE && left > 0 {
            let s = &self.segments[index as usize];
            if self.segment_meets(s, &quick, body, whole) {
                return true;
            }
            (index, left) = (s.before, left - 1);
        }
        false
    }

    #[inline]
    fn segment_meets(&self, s: &Segment, quick: &Sighting, body: &Body, whole: bool) -> bool {
        let half = 0.5 * s.length;
        s.layer == quick.layer && quick.near(s.from + s.dir * half, half) && s.meets(body, whole)
    }

    /// The same over the whole unbranched chain, run by run.
    fn any_segment(&self, quick: &Sighting, body: &Body, whole: bool) -> bool {
        let n = self.segments.len();
        let within = |b: &Bounds| {
            let (centre, radius) = b.ball();
            quick.near(centre, radius)
        };
        // Newest first: what would have been seen was mostly seen nearby, and not long ago.
        let mut end = n;
        while end > self.base {
            let begin = (end - 1) / RUN * RUN;
            if end.is_multiple_of(RUN * RUN)
                && let Some(b) = self.runs_of_runs.get(end / (RUN * RUN) - 1)
                && !within(b)
            {
                end -= RUN * RUN;
                continue;
            }
            let known = self.runs.get(begin / RUN);
            let segments = &self.segments[begin.max(self.base)..end];
            if known.is_none_or(within)
                && segments.iter().rev().any(|s| self.segment_meets(s, quick, body, whole))
            {
                return true;
            }
            end = begin;
        }
        false
    }
}
