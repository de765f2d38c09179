//! Bounding volume hierarchy over pieces of bodies, for sparse scenes and bodies of many sizes: long
//! fibres are cut into pieces of five thicknesses (100 µm of a 20 µm fibre), so that boxes fit.

use super::region::Extent;
use crate::math::DVec3;
use crate::universe::Ray;

/// A box, enlarged by 10⁻⁶ of its size for the rounding of the slab test.
#[derive(Clone, Copy, Debug)]
struct Aabb {
    lo: DVec3,
    hi: DVec3,
}

impl Aabb {
    fn union(self, o: Aabb) -> Aabb {
        Aabb { lo: self.lo.min(o.lo), hi: self.hi.max(o.hi) }
    }

    /// Where the ray comes in (0 from inside), or ∞ if it does not up to `limit`.
    #[inline]
    fn entry(&self, origin: DVec3, inverse: DVec3, limit: f64) -> f64 {
        let (a, b) = ((self.lo - origin) * inverse, (self.hi - origin) * inverse);
        // 0 · ∞ (in the plane of a face) is NaN, which min and max pass over.
        let near = a.x.min(b.x).max(a.y.min(b.y)).max(a.z.min(b.z)).max(0.0);
        let far = a.x.max(b.x).min(a.y.max(b.y)).min(a.z.max(b.z)).min(limit);
        // Far origins round both ends: a box just missed is looked into.
        if near <= far * (1.0 + 1e-12) { near } else { f64::INFINITY }
    }
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    /// Leaf: first piece; else the second child (the first follows its parent).
    at: u32,
    /// Pieces of a leaf; 0: no leaf.
    count: u32,
}

/// The hierarchy; pieces know the number of their body.
#[derive(Clone, Debug)]
pub(super) struct Bvh {
    nodes: Vec<Node>,
    pieces: Vec<(Aabb, u32)>,
}

const LEAF: usize = 4;

impl Bvh {
    /// Over bodies with their region, thickness (µm) and extent.
    pub fn new(bodies: &[(u32, f64, Extent)]) -> Self {
        let mut pieces = Vec::new();
        for (number, (_, thickness, extent)) in (0..).zip(bodies) {
            cut(extent, 5.0 * thickness, |bounds| pieces.push((bounds, number)));
        }
        let mut bvh = Bvh { nodes: Vec::new(), pieces };
        if !bvh.pieces.is_empty() {
            bvh.split(0, bvh.pieces.len());
        }
        bvh
    }

    /// Node over the pieces from `from` to `to`, halved at the median of the widest direction.
    fn split(&mut self, from: usize, to: usize) {
        let pieces = &mut self.pieces[from..to];
        let bounds = pieces.iter().skip(1).fold(pieces[0].0, |b, p| b.union(p.0));
        let number = self.nodes.len();
        self.nodes.push(Node { bounds, at: from as u32, count: (to - from) as u32 });
        if to - from <= LEAF {
            return;
        }
        let middle = |p: &(Aabb, u32)| p.0.lo + p.0.hi;
        let first = middle(&pieces[0]);
        let (lo, hi) = pieces.iter().fold((first, first), |(l, h), p| (l.min(middle(p)), h.max(middle(p))));
        let wide = hi - lo;
        let axis = if wide.x >= wide.y && wide.x >= wide.z {
            0
        } else if wide.y >= wide.z {
            1
        } else {
            2
        };
        let half = (to - from) / 2;
        pieces.select_nth_unstable_by(half, |a, b| {
            middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.1.cmp(&b.1))
        });
        self.split(from, from + half);
        let second = self.nodes.len() as u32;
        self.split(from + half, to);
        self.nodes[number].at = second;
        self.nodes[number].count = 0;
    }

    /// Tells the bodies of all pieces whose boxes the ray comes into up to `limit`, nearer boxes first;
    /// `tell` answers with the limit from then on.
    #[inline]
    pub fn along(&self, ray: &Ray, mut limit: f64, mut tell: impl FnMut(u32) -> f64) {
        if self.nodes.is_empty() {
            return;
        }
        let (o, inverse) = (ray.origin, ray.dir.recip());
        let mut stack = [(0_u32, 0.0_f64); 64];
        let mut depth = 1;
        stack[0].1 = self.nodes[0].bounds.entry(o, inverse, limit);
        while depth > 0 {
            depth -= 1;
            let (number, near) = stack[depth];
            if near > limit || near == f64::INFINITY {
                continue;
            }
            let node = &self.nodes[number as usize];
            if node.count > 0 {
                for (bounds, body) in &self.pieces[node.at as usize..(node.at + node.count) as usize] {
                    if bounds.entry(o, inverse, limit) < f64::INFINITY {
                        limit = tell(*body);
                    }
                }
                continue;
            }
            let children = [number + 1, node.at];
            let [a, b] = children.map(|c| self.nodes[c as usize].bounds.entry(o, inverse, limit));
            let order =
                if a <= b { [(node.at, b), (number + 1, a)] } else { [(number + 1, a), (node.at, b)] };
            for child in order {
                stack[depth] = child;
                depth += 1;
            }
        }
    }

    /// Tells the bodies of all pieces whose boxes hold a point (some more than once).
    pub fn around(&self, p: DVec3, mut tell: impl FnMut(u32)) {
        let holds = |b: &Aabb| p.cmpge(b.lo).all() && p.cmple(b.hi).all();
        let mut stack = if self.nodes.is_empty() { vec![] } else { vec![0_u32] };
        while let Some(number) = stack.pop() {
            let node = &self.nodes[number as usize];
            if !holds(&node.bounds) {
                continue;
            }
            if node.count == 0 {
                stack.extend([number + 1, node.at]);
            } else {
                let pieces = &self.pieces[node.at as usize..(node.at + node.count) as usize];
                pieces.iter().filter(|p| holds(&p.0)).for_each(|p| tell(p.1));
            }
        }
    }

    pub fn pieces(&self) -> usize {
        self.pieces.len()
    }

    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>() + self.pieces.capacity() * size_of::<(Aabb, u32)>()
    }
}

/// Boxes of the pieces of a body, none longer than about `length`.
fn cut(e: &Extent, length: f64, mut tell: impl FnMut(Aabb)) {
    let pieces = (2.0 * e.half() / length).ceil().clamp(1.0, 1e4);
    let step = 2.0 * e.half() / pieces;
    for i in 0..pieces as u32 {
        let from = e.centre + e.axis() * (f64::from(i) * step - e.half());
        let to = e.centre + e.axis() * (f64::from(i + 1) * step - e.half());
        let (lo, hi) = (from.min(to) - e.across, from.max(to) + e.across);
        let slack = (hi - lo).max_element() * 1e-6;
        tell(Aabb { lo: lo - slack, hi: hi + slack });
    }
}
