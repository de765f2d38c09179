//! Which regions a ray may enter: a list, a grid or a hierarchy, by what the scene is like.

use super::bvh::Bvh;
use super::flight::{Ahead, Asker, try_entry};
use super::grid::{Grid, Lattice, Walk};
use super::place::Group;
use super::region::{Extent, Hull, Key, Region, seen_from};
use crate::math::DVec3;
use crate::universe::Ray;

/// How regions are searched. The answer is the same bits for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Search {
    /// Chosen by what the scene is like.
    #[default]
    Automatic,
    /// All regions, one by one.
    Linear,
    /// A uniform grid; cells as wide as the mean body is thick.
    Grid,
    /// A hierarchy of boxes around pieces of bodies.
    Hierarchy,
}

/// Regions without bounds or far larger than the others, and an index of all others.
#[derive(Clone, Debug)]
pub(super) struct Index {
    everywhere: Vec<u32>,
    /// Of the indexed bodies.
    hulls: Vec<Hull>,
    kind: Kind,
    period: [f64; 2],
}

#[derive(Clone, Debug)]
enum Kind {
    None,
    Grid(Grid),
    Hierarchy(Bvh),
}

/// Fewer bodies than this are searched one by one.
const FEW: usize = 24;
/// Most cells of a grid, and most entries, about.
const MOST_CELLS: f64 = 1.6e7;

/// An indexed body: number, thickness, extent.
type Sized = (u32, f64, Extent);

impl Index {
    pub fn new(regions: &[Region], search: Search, period: Option<[f64; 2]>) -> Self {
        let (mut everywhere, mut bodies): (Vec<u32>, Vec<Sized>) = (vec![], vec![]);
        for (i, r) in regions.iter().enumerate().filter(|(_, r)| !r.is_hole()) {
            let shape = &r.part.shape;
            match Extent::of(shape).filter(|e| e.half().is_finite()) {
                Some(e) => bodies.push((i as u32, Extent::thickness(shape), e)),
                None => everywhere.push(i as u32),
            }
        }
        let few = period.is_none() && bodies.len() < FEW;
        let kind = match search {
            _ if bodies.is_empty() => Kind::None,
            Search::Linear if period.is_none() => Kind::None,
            Search::Automatic if few => Kind::None,
            Search::Hierarchy if period.is_none() => Kind::Hierarchy(Bvh::new(&bodies)),
            _ => {
                let typical = median(bodies.iter().map(|b| b.1).collect());
                if period.is_none() && bodies.iter().filter(|b| b.1 > 8.0 * typical).count() < FEW {
                    everywhere.extend(bodies.iter().filter(|b| b.1 > 8.0 * typical).map(|b| b.0));
                    bodies.retain(|b| b.1 <= 8.0 * typical);
                }
                let plan = Layout::of(&bodies, period);
                let fits =
                    plan.dense() && bodies.iter().all(|b| b.1 <= 8.0 * typical && b.1 >= typical / 8.0);
                if search == Search::Automatic && period.is_none() && !fits {
                    Kind::Hierarchy(Bvh::new(&bodies))
                } else {
                    Kind::Grid(plan.build(&bodies, period.is_some()))
                }
            }
        };
        if let Kind::None = kind {
            everywhere.extend(bodies.iter().map(|b| b.0));
            everywhere.sort_unstable();
        }
        let hulls = bodies.iter().map(|b| Hull::of(b.0, &regions[b.0 as usize].part.shape)).collect();
        Index { everywhere, hulls, kind, period: period.unwrap_or_default() }
    }

    pub fn search(&self, ray: &Ray) -> Option<(Walk, Ahead)> {
        match &self.kind {
            Kind::Grid(grid) => Some((grid.walk(ray), Ahead::new())),
            _ => None,
        }
    }

    #[inline]
    pub fn entries(
        &self,
        regions: &[Region],
        walk: &mut Option<(Walk, Ahead)>,
        asker: &Asker,
        after: f64,
        group: &mut Group,
    ) {
        let ray = asker.ray;
        for &r in &self.everywhere {
            try_entry(&regions[r as usize], Key::new(r, [0; 2]), self.period, asker, after, group);
        }
        match (&self.kind, walk) {
            (Kind::Grid(grid), Some(walk)) => self.in_cells(grid, regions, walk, asker, after, group),
            (Kind::Hierarchy(bvh), _) => bvh.along(ray, group.distance, |body| {
                let hull = &self.hulls[body as usize];
                if !hull.missed_by(ray.origin, ray.dir) {
                    let key = Key::new(hull.region, [0; 2]);
                    try_entry(&regions[hull.region as usize], key, self.period, asker, after, group);
                }
                group.distance
            }),
            _ => {}
        }
    }

    #[inline]
    fn in_cells(
        &self,
        grid: &Grid,
        regions: &[Region],
        (walk, ahead): &mut (Walk, Ahead),
        asker: &Asker,
        after: f64,
        group: &mut Group,
    ) {
        let ray = asker.ray;
        let mut known = ahead.recall(after, group);
        while !walk.over {
            if !known {
                let Some((items, image)) = grid.list(walk.cell) else {
                    walk.over = true;
                    return;
                };
                ahead.look();
                for item in items {
                    let hull = &self.hulls[item.body() as usize];
                    let key = item.key(hull.region, image);
                    if !hull.missed_by(seen_from(ray, key, self.period).origin, ray.dir) {
                        let region = &regions[hull.region as usize];
                        ahead.try_entry(region, key, self.period, asker, after, group);
                    }
                }
            }
            known = false;
            if group.distance <= walk.end() {
                return;
            }
            walk.step(&grid.lattice, ray);
            if walk.cell[0].unsigned_abs().max(walk.cell[1].unsigned_abs()) > i32::MAX as u32 / 2 {
                walk.over = true;
            }
        }
    }

    /// Tells the keys of all regions (hollows excepted) that may contain a point; some twice.
    pub fn around(&self, p: DVec3, mut tell: impl FnMut(Key)) {
        self.everywhere.iter().for_each(|&r| tell(Key::new(r, [0; 2])));
        match &self.kind {
            Kind::None => {}
            Kind::Grid(grid) => {
                if let Some((items, image)) = grid.list(grid.lattice.cell(p)) {
                    items.iter().for_each(|i| tell(i.key(self.hulls[i.body() as usize].region, image)));
                }
            }
            Kind::Hierarchy(bvh) => {
                bvh.around(p, |body| tell(Key::new(self.hulls[body as usize].region, [0; 2])));
            }
        }
    }

    /// In words.
    pub fn describe(&self) -> String {
        let rest = |text: String| match self.everywhere.len() {
            0 => text,
            n => format!("{text}; {n} without bounds or far larger, one by one"),
        };
        match &self.kind {
            Kind::None => format!("{} bodies searched one by one", self.everywhere.len()),
            Kind::Grid(g) => {
                let [x, y, z] = g.n;
                let s = g.lattice.size;
                rest(format!(
                    "uniform grid of {x} × {y} × {z} cells of {:.3} × {:.3} × {:.3} µm, {:.1} bodies in each{}",
                    s.x,
                    s.y,
                    s.z,
                    g.filling(),
                    if g.periodic { ", repeated sideways" } else { "" }
                ))
            }
            Kind::Hierarchy(b) => {
                rest(format!("hierarchy (BVH) over {} boxes of pieces of bodies", b.pieces()))
            }
        }
    }

    /// Memory of the index, bytes.
    pub fn bytes(&self) -> usize {
        let index = match &self.kind {
            Kind::None => 0,
            Kind::Grid(g) => g.bytes(),
            Kind::Hierarchy(b) => b.bytes(),
        };
        index + self.hulls.capacity() * size_of::<Hull>() + 4 * self.everywhere.capacity()
    }
}

fn median(mut x: Vec<f64>) -> f64 {
    let half = x.len() / 2;
    *x.select_nth_unstable_by(half, f64::total_cmp).1
}

/// Of a grid to be.
struct Layout {
    lattice: Lattice,
    n: [i32; 3],
    /// About how many entries all cells have together.
    entries: f64,
}

impl Layout {
    fn of(bodies: &[Sized], period: Option<[f64; 2]>) -> Self {
        let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (_, _, e) in bodies {
            let (l, h) = e.corners();
            (lo, hi) = (lo.min(l), hi.max(h));
        }
        let mean = bodies.iter().map(|b| b.1).sum::<f64>() / bodies.len() as f64;
        let mut size = mean;
        loop {
            // A section of area (2r + s)² through every slice, about.
            let about =
                |e: &Extent| (2.0 * e.half() / size + 1.0) * 1.2 * (2.0 * e.radius / size + 1.0).powi(2);
            let entries = bodies.iter().map(|b| about(&b.2)).sum();
            let layout = Self::with(lo, hi, size, period, entries);
            if layout.cells() + layout.entries <= MOST_CELLS {
                return layout;
            }
            size *= 1.25;
        }
    }

    fn with(lo: DVec3, hi: DVec3, size: f64, period: Option<[f64; 2]>, entries: f64) -> Self {
        let slack = 0.01 * size;
        let mut cell = DVec3::splat(size);
        let mut origin = lo - slack;
        let mut n = ((hi - lo + 2.0 * slack) / size).ceil().to_array().map(|x| x.max(1.0));
        if let Some(period) = period {
            for axis in 0..2 {
                n[axis] = (period[axis] / size).round().max(1.0);
                cell[axis] = period[axis] / n[axis];
                origin[axis] = 0.0;
            }
        }
        Layout { lattice: Lattice::new(origin, cell), n: n.map(|x| x as i32), entries }
    }

    fn cells(&self) -> f64 {
        self.n.iter().map(|&k| f64::from(k)).product()
    }

    /// Whether a walk finds something in every few cells.
    fn dense(&self) -> bool {
        self.cells() <= 8.0 * self.entries
    }

    fn build(&self, bodies: &[Sized], periodic: bool) -> Grid {
        let bodies: Vec<(u32, Extent)> = (0..).zip(bodies).map(|(i, b)| (i, b.2)).collect();
        Grid::new(self.lattice, self.n, periodic, &bodies)
    }
}
