//! Regions, the keys that tell them (and their periodic images) apart, and who owns a point.

use super::Part;
use crate::math::{DVec3, Frame};
use crate::universe::shape::{Chord, Convex, Placed, Shape, ShapeFace, SlantedCylinder};
use crate::universe::{MediumId, Overlap, Ray, SurfaceId};

/// Most regions that the number of a key can tell.
pub(super) const MOST: usize = 1 << 26;

/// A region and the periodic image of it that is meant: number, and image steps along x and y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct Key(u64);

impl Key {
    /// No region.
    pub const NONE: Key = Key(u64::MAX);

    #[inline]
    pub fn new(region: u32, image: [i16; 2]) -> Self {
        Key(u64::from(region) | u64::from(image[0] as u16) << 32 | u64::from(image[1] as u16) << 48)
    }

    #[inline]
    pub fn region(self) -> usize {
        (self.0 & (MOST as u64 - 1)) as usize
    }

    /// The same image of another region.
    #[inline]
    pub fn of(self, region: u32) -> Self {
        Key(self.0 >> 32 << 32 | u64::from(region))
    }

    #[inline]
    pub fn image(self) -> Option<[i16; 2]> {
        let bits = (self.0 >> 32) as u32;
        (bits != 0).then_some([bits as u16 as i16, (bits >> 16) as u16 as i16])
    }
}

/// A convex region with its standing among the others.
#[derive(Clone, Debug)]
pub(super) struct Region {
    pub part: Part,
    /// The higher of two ranks owns a common point (walls under `union`: of two solids).
    pub rank: u32,
    /// Number of the region whose hollow this is, or `u32::MAX`.
    pub outer: u32,
    /// Number of its hollow, or `u32::MAX`.
    pub hole: u32,
    /// The hollow may share a surface with it beside the caps.
    pub flush: bool,
    /// As a hollow: its flat ends are those of its body.
    open: bool,
}

impl Region {
    pub fn new(part: Part, rank: u32) -> Self {
        Region { part, rank, outer: u32::MAX, hole: u32::MAX, flush: false, open: false }
    }

    #[inline]
    pub fn is_hole(&self) -> bool {
        self.outer != u32::MAX
    }

    /// As a hollow: the way of a ray that is in its body, in the local frame.
    #[inline]
    pub fn way_from_body(&self, o: DVec3, d: DVec3) -> Option<Chord> {
        let shape = &self.part.shape.shape;
        if self.open { shape.way_through_side(o, d) } else { shape.way_through(o, d) }
    }

    /// The number of its hollow.
    #[inline]
    pub fn hollow(&self) -> Option<u32> {
        (self.hole != u32::MAX).then_some(self.hole)
    }
}

/// Numbers the hollows among `regions` from `first` on: a region right behind another of the same
/// body and priority that lies concentric within it.
pub(super) fn pair_hollows(regions: &mut [Region], first: usize) {
    for i in (first + 1)..regions.len() {
        let (a, b) = (&regions[i - 1], &regions[i]);
        let same = a.part.body == b.part.body && a.part.priority == b.part.priority && !a.is_hole();
        if let (true, Some(flush)) = (same, within(&a.part.shape, &b.part.shape)) {
            regions[i - 1].hole = i as u32;
            regions[i - 1].flush = flush;
            regions[i].open = same_ends(&regions[i - 1].part.shape.shape, &regions[i].part.shape.shape);
            regions[i].outer = (i - 1) as u32;
        }
    }
}

/// Whether a concentric hollow ends where its body does.
fn same_ends(a: &Shape, b: &Shape) -> bool {
    match (a, b) {
        (Shape::Cylinder(a), Shape::Cylinder(b)) => a.half_length == b.half_length,
        (Shape::Slanted(_), Shape::Slanted(_)) => true,
        _ => false,
    }
}

/// Whether `b` lies concentric within `a`, and then whether sides touch.
fn within(a: &Placed, b: &Placed) -> Option<bool> {
    if a.centre != b.centre || a.frame != b.frame {
        return None;
    }
    match (a.shape, b.shape) {
        (Shape::Cylinder(o), Shape::Cylinder(i)) => {
            let shorter = match (o.half_length, i.half_length) {
                (Some(ho), Some(hi)) => hi <= ho,
                (None, _) => true,
                _ => false,
            };
            (i.a <= o.a && i.b <= o.b && shorter).then_some(i.a == o.a || i.b == o.b)
        }
        (Shape::Slanted(o), Shape::Slanted(i)) => {
            let course = |s: SlantedCylinder| [s.from, s.to, s.height, s.slope];
            (i.a <= o.a && i.b <= o.b && course(o) == course(i)).then_some(i.a == o.a || i.b == o.b)
        }
        (Shape::Ellipsoid(o), Shape::Ellipsoid(i)) => {
            (i.a <= o.a && i.b <= o.b && i.c <= o.c).then_some(i.a == o.a || i.b == o.b || i.c == o.c)
        }
        _ => None,
    }
}

/// The medium of a point: its owner, if there is one, and whether that is solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Owner {
    pub key: Key,
    pub medium: MediumId,
    pub solid: bool,
}

/// Rules of ownership.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rule {
    pub overlap: Overlap,
    pub ambient: MediumId,
}

impl Rule {
    /// Who owns a point that lies in all the regions `keys`, and in no other.
    #[inline]
    pub fn owner<'a>(&self, keys: &[Key], region: impl Fn(Key) -> &'a Region) -> Owner {
        let mut best = Owner { key: Key::NONE, medium: self.ambient, solid: false };
        let mut standing = None;
        for &key in keys {
            let r = region(key);
            let solid = !r.is_hole() && r.part.medium != self.ambient;
            let mine = match self.overlap {
                Overlap::Priority | Overlap::Forbid => (true, r.rank, key),
                // A wall is solid where the body's own hollow is not; what is not solid loses.
                Overlap::Union => {
                    if r.hollow().is_some_and(|h| keys.contains(&key.of(h))) {
                        continue;
                    }
                    (solid, r.rank, key)
                }
            };
            if standing.is_none_or(|s| mine > s) {
                standing = Some(mine);
                best = Owner { key, medium: r.part.medium, solid };
            }
        }
        best
    }

    /// Whether there is an interface between points of these owners: `surface` is the law of what is
    /// crossed.
    #[inline]
    pub fn separates(&self, before: &Owner, after: &Owner, surface: SurfaceId) -> bool {
        if before.key == after.key {
            return false;
        }
        let merged = match self.overlap {
            Overlap::Priority | Overlap::Forbid => surface == SurfaceId::SMOOTH,
            Overlap::Union => before.solid == after.solid || surface == SurfaceId::SMOOTH,
        };
        before.medium != after.medium || !merged
    }
}

/// The round hull of a region, by which most regions that a ray misses are told without a division:
/// one cache line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hull {
    centre: DVec3,
    /// Of a cylinder; zero: a ball.
    axis: DVec3,
    /// Square of the radius, enlarged by 0.2 %.
    r2: f64,
    /// Number of the region.
    pub region: u32,
    ball: bool,
}

impl Hull {
    pub fn of(region: u32, placed: &Placed) -> Self {
        let round = matches!(placed.shape, Shape::Cylinder(_));
        let size = |e: Extent| (e.centre, e.ball(&placed.shape));
        let (centre, r) = Extent::of(placed).map_or((DVec3::ZERO, f64::INFINITY), size);
        let axis = if round { placed.frame.z } else { DVec3::ZERO };
        Hull { centre, axis, r2: r * r * 1.002, region, ball: !round }
    }

    /// Whether the line surely misses. The distance of line and axis is |w·(d × a)|/|d × a|; nearly
    /// parallel lines (sine below 1e-4) are left to the exact test.
    #[inline]
    pub fn missed_by(&self, origin: DVec3, dir: DVec3) -> bool {
        let w = origin - self.centre;
        if self.ball {
            return w.cross(dir).length_squared() > self.r2;
        }
        let n = dir.cross(self.axis);
        let (q, nn) = (w.dot(n), n.length_squared());
        q * q > self.r2 * nn && nn > 1e-8
    }
}

fn diagonal(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// What holds a shape: a box along its own axes, endless along the last one where the shape is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub centre: DVec3,
    axes: Frame,
    /// Half edges.
    halves: [f64; 3],
    /// Half extents of the section (without the last axis) along the axes of the world.
    pub across: DVec3,
    /// Radius of the section's round hull.
    pub radius: f64,
}

impl Extent {
    /// `None` for half spaces and slabs.
    pub fn of(p: &Placed) -> Option<Self> {
        let f = p.frame;
        let (centre, halves) = match p.shape {
            Shape::Cylinder(c) => (p.centre, [c.a, c.b, c.half_length.unwrap_or(f64::INFINITY)]),
            // The box around it along the axes of its frame.
            Shape::Slanted(s) => {
                let middle = 0.5 * (s.from + s.to);
                let half = 0.5 * (s.to - s.from);
                let centre = p.centre + f.to_world(DVec3::new(0.0, s.centre(middle), middle));
                (centre, [s.a, s.b + s.slope.abs() * half, half])
            }
            Shape::Ellipsoid(e) => (p.centre, [e.a, e.b, e.c]),
            Shape::Cuboid(b) => {
                (p.centre + f.to_world((b.min + b.max) * 0.5), ((b.max - b.min) * 0.5).to_array())
            }
            Shape::HalfSpace(_) | Shape::SlabZ(_) => return None,
        };
        let (x, y) = (f.x * halves[0], f.y * halves[1]);
        let square = x * x + y * y;
        let round = DVec3::new(square.x.sqrt(), square.y.sqrt(), square.z.sqrt());
        let (across, radius) = match p.shape {
            Shape::Cuboid(_) | Shape::Slanted(_) => (x.abs() + y.abs(), diagonal(halves[0], halves[1])),
            _ => (round, halves[0].max(halves[1])),
        };
        Some(Extent { centre, axes: f, halves, across, radius })
    }

    /// The last axis, unit.
    #[inline]
    pub fn axis(&self) -> DVec3 {
        self.axes.z
    }

    /// Half length along it.
    #[inline]
    pub fn half(&self) -> f64 {
        self.halves[2]
    }

    /// Whether the shape may reach into a box of half edges `half` about `middle`: the box's shadow on
    /// each of the shape's axes overlaps the shape's own.
    #[inline]
    pub fn reaches(&self, middle: DVec3, half: DVec3) -> bool {
        let w = middle - self.centre;
        let near = |axis: DVec3, own: f64| w.dot(axis).abs() <= own + half.dot(axis.abs());
        near(self.axes.x, self.halves[0])
            && near(self.axes.y, self.halves[1])
            && near(self.axes.z, self.halves[2])
    }

    /// Radius about the axis of a cylinder, about the centre of what is none, that holds all.
    fn ball(&self, shape: &Shape) -> f64 {
        match shape {
            Shape::Cylinder(_) => self.radius,
            Shape::Ellipsoid(_) => self.radius.max(self.half()),
            _ => diagonal(self.radius, self.half()),
        }
    }

    /// Lower and upper corner; infinite where the shape has no end.
    pub fn corners(&self) -> (DVec3, DVec3) {
        let reach = if self.half().is_finite() {
            self.axis().abs() * self.half()
        } else {
            DVec3::from_array(self.axis().to_array().map(|a| if a == 0.0 { 0.0 } else { f64::INFINITY }))
        };
        (self.centre - reach - self.across, self.centre + reach + self.across)
    }

    /// Smallest thickness across, µm: what a cell is measured by.
    pub fn thickness(p: &Placed) -> f64 {
        match p.shape {
            Shape::Cylinder(c) => 2.0 * (c.a * c.b).sqrt(),
            Shape::Slanted(s) => 2.0 * (s.a * s.b).sqrt(),
            Shape::Ellipsoid(e) => 2.0 * crate::math::cbrt(e.a * e.b * e.c),
            Shape::Cuboid(b) => crate::math::cbrt((b.max - b.min).element_product()),
            Shape::HalfSpace(_) | Shape::SlabZ(_) => f64::INFINITY,
        }
    }
}

/// A surface met: where, of which region, and from which side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event {
    pub t: f64,
    pub key: Key,
    pub enters: bool,
    pub face: ShapeFace,
}

/// The ray as the original of a periodic image sees it; the ray itself stays where it is.
#[inline]
pub(super) fn seen_from(ray: &Ray, key: Key, period: [f64; 2]) -> Ray {
    match key.image() {
        None => *ray,
        Some([x, y]) => {
            let shift = DVec3::new(f64::from(x) * period[0], f64::from(y) * period[1], 0.0);
            Ray { origin: ray.origin - shift, dir: ray.dir }
        }
    }
}
