//! What a history has met: bodies and traced segments, append-only. A place holds the newest entry of
//! its own past, each entry the one before: a branch is a copy of a place and sees only its own past.

use crate::math::{DVec2, DVec3};
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

impl Default for Past {
    fn default() -> Self {
        NOTHING
    }
}

/// Nothing known.
pub(super) const NOTHING: Past = Past { sighting: NONE, segment: NONE, flights: 0 };

/// A straight piece of a line, as tests of known bodies need it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    origin: DVec3,
    dir: DVec3,
    length: f64,
    /// Range of z.
    low: f64,
    high: f64,
}

impl Piece {
    #[inline]
    pub fn new(ray: &Ray, length: f64) -> Self {
        let (a, rise) = (ray.origin.z, ray.dir.z);
        let b = if rise == 0.0 { a } else { a + rise * length };
        Piece { origin: ray.origin, dir: ray.dir, length, low: a.min(b), high: a.max(b) }
    }
}

/// A body as far as quick tests need it: its range of z, and the box and the quadric around it in
/// coordinates in which its half sizes are 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sighting {
    low: f64,
    high: f64,
    centre: DVec3,
    /// The frame's axes over the half sizes; the axis of an unbounded cylinder is 0.
    axes: [DVec3; 3],
    /// Reciprocal half sizes, and the largest of them.
    inverse: DVec3,
    scale: f64,
    extent: Extent,
    pub layer: u16,
    /// The body itself.
    pub body: u32,
    /// Flight on which it was met.
    pub flight: u32,
    pub before: u32,
}

/// How a body ends along its third axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Extent {
    Unbounded,
    Flat,
    Round,
}

impl Sighting {
    pub fn of(body: &Body, index: u32, layer: u16, flight: u32) -> Self {
        let (h, f) = (&body.outer, &body.frame);
        let inverse = DVec3::new(1.0 / h.a, 1.0 / h.b, 1.0 / h.c.min(body.ends));
        let extent = match (h.c.is_finite(), body.ends.is_finite()) {
            (true, _) => Extent::Round,
            (false, true) => Extent::Flat,
            (false, false) => Extent::Unbounded,
        };
        let endless = extent == Extent::Unbounded && f.z.z != 0.0;
        let half = if endless { f64::INFINITY } else { body.half_height() };
        let reach = half * (1.0 + 1e-9) + 1e-12 * body.centre.z.abs();
        Sighting {
            low: body.centre.z - reach,
            high: body.centre.z + reach,
            centre: body.centre,
            axes: [f.x * inverse.x, f.y * inverse.y, f.z * inverse.z],
            inverse,
            scale: inverse.max_element(),
            extent,
            body: index,
            flight,
            layer,
            before: NONE,
        }
    }

    #[inline]
    fn scaled(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.axes[0]), v.dot(self.axes[1]), v.dot(self.axes[2]))
    }

    /// What a sure miss must exceed 1 by: above the rounding of the products.
    #[inline]
    fn margin(&self, w: DVec3) -> f64 {
        1e-9 + 1e-12 * self.scale * (w.x.abs() + w.y.abs() + w.z.abs())
    }

    /// False only if the body surely misses the ball of radius `r` about `p`: the box around the body
    /// does, by one of its faces.
    #[inline]
    pub fn near(&self, p: DVec3, r: f64) -> bool {
        let w = p - self.centre;
        let q = self.scaled(w);
        let room = DVec3::splat(1.0 + self.margin(w)) + self.inverse * (r * (1.0 + 1e-9));
        (q.x.abs() <= room.x) & (q.y.abs() <= room.y) & (q.z.abs() <= room.z)
    }

    /// True only if the body surely misses the piece: by its height; or the line passes beside the
    /// quadric, or the piece begins behind it or ends before it.
    ///
    /// But for the height without a branch: most known bodies are missed, the few others cannot be foretold.
    #[inline]
    pub fn misses(&self, piece: &Piece) -> bool {
        self.low > piece.high || self.high < piece.low || self.misses_line(piece)
    }

    #[inline]
    fn misses_line(&self, piece: &Piece) -> bool {
        let Piece { origin, dir, length, .. } = *piece;
        let w = origin - self.centre;
        let limit = 1.0 + self.margin(w);
        let limit2 = limit * limit;
        if self.extent == Extent::Unbounded {
            let flat = |v: DVec3| DVec2::new(v.dot(self.axes[0]), v.dot(self.axes[1]));
            let (p, q) = (flat(w), flat(dir));
            let (qq, pq, beside) = (q.length_squared(), p.dot(q), p.perp_dot(q));
            let end = (p + q * length).length_squared();
            return (beside * beside > limit2 * qq)
                | ((pq > 0.0) & (p.length_squared() > limit2))
                | ((pq + qq * length < 0.0) & (end > limit2));
        }
        let (p, q) = (self.scaled(w), self.scaled(dir));
        let end = p + q * length;
        let off_ends = (p.z.min(end.z) > limit) | (p.z.max(end.z) < -limit);
        let round = DVec3::new(1.0, 1.0, if self.extent == Extent::Round { 1.0 } else { 0.0 });
        let (p, q, end) = (p * round, q * round, end * round);
        let (qq, pq) = (q.length_squared(), p.dot(q));
        off_ends
            | (p.cross(q).length_squared() > limit2 * qq)
            | ((pq > 0.0) & (p.length_squared() > limit2))
            | ((pq + qq * length < 0.0) & (end.length_squared() > limit2))
    }
}

/// A straight piece of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    piece: Piece,
    layer: u16,
    before: u32,
}

impl Segment {
    /// Whether a body holds a point of the segment (the planted fault: and the segment misses its lumen).
    #[inline]
    fn meets(&self, body: &Body, whole: bool) -> bool {
        let Some(s) = body.spans(self.piece.origin, self.piece.dir, None) else { return false };
        let (a, b) = (s.from.max(0.0), s.to.min(self.piece.length));
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
const MANY: usize = 24;

/// How the sightings of a past lie in memory.
#[derive(Clone, Copy, Debug)]
pub(super) enum Chain {
    /// One after the other, few of them.
    Few,
    /// One after the other, so many that a list of the near ones pays.
    Many,
    /// Among those of other branches.
    Linked,
}

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
            ..Kept::default()
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

    /// How the sightings of `past` can be gone through.
    #[inline]
    pub(super) fn chain(&self, past: &Past) -> Chain {
        let n = self.sightings.len();
        match n - self.first_sighting {
            _ if past.sighting == NONE || !self.unbranched || past.sighting as usize + 1 != n => {
                Chain::Linked
            }
            known if known < MANY => Chain::Few,
            _ => Chain::Many,
        }
    }

    /// All sightings of an unbranched past.
    #[inline]
    pub(super) fn all(&self) -> &[Sighting] {
        &self.sightings[self.first_sighting..]
    }

    /// Lists the sightings of an unbranched past that may reach into a ball (centre, radius), to be read
    /// by [`Memory::nearby`]. The list is made for a ball larger by `slack` and kept while that holds.
    pub(super) fn gather_near(&mut self, (middle, half): (DVec3, f64), slack: f64) {
        let n = self.sightings.len();
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
    }

    /// The sightings listed.
    #[inline]
    pub(super) fn nearby(&self) -> impl Iterator<Item = &Sighting> {
        self.nearby.list.iter().map(|i| &self.sightings[*i as usize])
    }

    /// Keeps a traced segment.
    pub(super) fn keep(&mut self, past: &mut Past, ray: &Ray, length: f64, layer: u16) {
        let index = self.segments.len();
        if past.segment == NONE {
            (self.base, self.straight) = (index, true);
        } else if past.segment as usize + 1 != index {
            self.straight = false;
        }
        self.segments.push(Segment { piece: Piece::new(ray, length), layer, before: past.segment });
        past.segment = index as u32;
        past.flights += 1;
        self.enclose();
    }

    /// Completes the boxes of runs that have become full.
    fn enclose(&mut self) {
        let n = self.segments.len();
        if n.is_multiple_of(RUN) {
            let run = self.segments[n - RUN..].iter().fold(Bounds::EMPTY, |b, s| {
                let from = s.piece.origin;
                let to = from + s.piece.dir * s.piece.length;
                b.with(Bounds { low: from.min(to), high: from.max(to) })
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
        s.layer == quick.layer && !quick.misses(&s.piece) && s.meets(body, whole)
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
