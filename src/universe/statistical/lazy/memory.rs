//! What a history has met: bodies and traced segments, append-only. A place holds the newest entry of
//! its own past, each entry the one before: a branch is a copy of a place and sees only its own past.

use crate::math::DVec3;
use crate::universe::statistical::section::{Body, Spans};
use crate::universe::{MediumId, Ray};

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

/// A body as far as a quick test needs it: a sphere or a capsule around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sighting {
    centre: DVec3,
    /// Fibre axis; zero for bodies without.
    axis: DVec3,
    radius: f64,
    /// Half length along the axis.
    ends: f64,
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
        let (axis, radius) =
            if h.c.is_infinite() { (body.frame.z, h.a.max(h.b)) } else { (DVec3::ZERO, h.a.max(h.b).max(h.c)) };
        Sighting {
            centre: body.centre,
            axis,
            radius,
            ends: body.ends,
            body: index,
            flight,
            layer,
            before: NONE,
        }
    }

    /// False only if the body surely misses the ball of radius `r` about `p`.
    #[inline]
    pub fn near(&self, p: DVec3, r: f64) -> bool {
        let w = p - self.centre;
        let along = w.dot(self.axis);
        if along.abs() > self.ends + r {
            return false;
        }
        let w2 = w.length_squared();
        let room = self.radius + r;
        // The difference of squares is sure to 1e-15 of w²; the margin keeps the test on the safe side.
        w2 - along * along <= room * room * (1.0 + 1e-9) + 1e-12 * w2
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
    /// Whether a body holds a point of the segment (or its wall does: the planted fault).
    #[inline]
    fn meets(&self, body: &Body, whole: bool) -> bool {
        let Some(Spans { outer, lumen }) = body.spans(self.from, self.dir, None) else { return false };
        let (a, b) = (outer.from.max(0.0), outer.to.min(self.length));
        if a > b {
            return false;
        }
        whole || !lumen.is_some_and(|l| l.from <= a && l.to >= b)
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
    pub mark: f64,
    pub wall: MediumId,
    pub lumen: MediumId,
}

/// A body and its random mark: of two that overlap the higher rules.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub body: Body,
    pub mark: f64,
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
            touched: Vec::new(),
            base: 0,
            straight: true,
            common: NOTHING,
            pockets: 0,
        }
    }
}

/// What a history has kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Bodies met.
    pub bodies: u64,
    /// Segments traced.
    pub segments: u64,
    /// Bytes in use.
    pub bytes: u64,
    /// Pockets forgotten (finite k).
    pub pockets: u64,
}

impl Memory {
    pub(super) fn clear(&mut self) {
        self.bodies.clear();
        self.sightings.clear();
        self.segments.clear();
        self.runs.clear();
        self.runs_of_runs.clear();
        (self.base, self.straight, self.common, self.pockets) = (0, true, NOTHING, 0);
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
    pub(super) fn share(&mut self, flights: u32) {
        let last = |n: usize| if n == 0 { NONE } else { n as u32 - 1 };
        self.common = Past { sighting: last(self.sightings.len()), segment: last(self.segments.len()), flights };
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
        let index = self.sightings.len() as u32;
        self.sightings.push(Sighting { before: past.sighting, ..sighting });
        past.sighting = index;
    }

    /// Keeps a traced segment.
    pub(super) fn keep(&mut self, past: &mut Past, ray: &Ray, length: f64, layer: u16) {
        let index = self.segments.len();
        if past.segment == NONE {
            (self.base, self.straight) = (index, true);
        } else if past.segment as usize + 1 != index {
            self.straight = false;
        }
        self.segments.push(Segment {
            from: ray.origin,
            dir: ray.dir,
            length,
            layer,
            before: past.segment,
        });
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
    pub(super) fn would_have_seen(&self, past: &Past, body: &Body, layer: u16, most: u32, whole: bool) -> bool {
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
        let mut at = self.base;
        while at < n {
            if at.is_multiple_of(RUN * RUN)
                && let Some(b) = self.runs_of_runs.get(at / (RUN * RUN))
                && !within(b)
            {
                at += RUN * RUN;
                continue;
            }
            if at.is_multiple_of(RUN)
                && let Some(b) = self.runs.get(at / RUN)
                && !within(b)
            {
                at += RUN;
                continue;
            }
            let end = (at / RUN + 1) * RUN;
            if self.segments[at..end.min(n)].iter().any(|s| self.segment_meets(s, quick, body, whole)) {
                return true;
            }
            at = end;
        }
        false
    }
}
