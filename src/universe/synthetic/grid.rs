//! Uniform grids: which regions lie in a cell, and the walk of a ray from cell to cell.
//!
//! A region is listed in every cell that it may touch, enlarged by 10⁻⁵ of a cell, so that the
//! rounding of a ray's way cannot come between a surface and its cell. The walk counts cells by
//! integers; the distance to a cell's wall is computed anew from its number, never added up.

use super::region::{Extent, Key};
use crate::math::DVec3;
use crate::universe::Ray;

/// Equal cells that fill space: cell i reaches from origin + i size to origin + (i + 1) size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    pub origin: DVec3,
    pub size: DVec3,
    inverse: DVec3,
}

impl Lattice {
    pub fn new(origin: DVec3, size: DVec3) -> Self {
        Lattice { origin, size, inverse: size.recip() }
    }

    /// The cell of a point.
    #[inline]
    pub fn cell(&self, p: DVec3) -> [i32; 3] {
        ((p - self.origin) * self.inverse).to_array().map(floor)
    }

    #[inline]
    fn wall(&self, axis: usize, number: i32) -> f64 {
        self.origin[axis] + f64::from(number) * self.size[axis]
    }

    /// Calls `list` with every cell between `lo` and `hi` (inclusive) that a region may touch.
    pub fn cells_of(&self, e: &Extent, lo: [i32; 3], hi: [i32; 3], mut list: impl FnMut([i32; 3])) {
        let slack = self.size * 1e-5;
        let near = e.across + slack;
        let half = self.size * 0.5 + slack;
        // Slices across the steepest direction; in each, the piece of the axis that may reach in.
        let main = steepest(e.axis());
        let (a, b) = ((main + 1) % 3, (main + 2) % 3);
        let along = e.half() * e.axis()[main].abs() + near[main];
        let number = |x: f64| floor((x - self.origin[main]) * self.inverse[main]);
        let (first, last) = (number(e.centre[main] - along), number(e.centre[main] + along));
        for i in lo[main].max(first)..=hi[main].min(last) {
            let to = |x: f64| e.axis() * ((x - e.centre[main]) / e.axis()[main]).clamp(-e.half(), e.half());
            let p = e.centre + to(self.wall(main, i) - near[main]);
            let q = e.centre + to(self.wall(main, i + 1) + near[main]);
            let (from, to) = (self.cell(p.min(q) - near), self.cell(p.max(q) + near));
            for j in lo[a].max(from[a])..=hi[a].min(to[a]) {
                for k in lo[b].max(from[b])..=hi[b].min(to[b]) {
                    let mut cell = [0; 3];
                    (cell[main], cell[a], cell[b]) = (i, j, k);
                    let middle =
                        self.origin + DVec3::from_array(cell.map(|c| f64::from(c) + 0.5)) * self.size;
                    if e.reaches(middle, half) {
                        list(cell);
                    }
                }
            }
        }
    }
}

/// Largest whole number not above x; far outside of what an i32 holds, its ends.
#[inline]
fn floor(x: f64) -> i32 {
    let below = x as i32; // towards zero, saturating
    if f64::from(below) > x { below.saturating_sub(1) } else { below }
}

fn steepest(v: DVec3) -> usize {
    let a = v.abs();
    if a.x >= a.y && a.x >= a.z {
        0
    } else if a.y >= a.z {
        1
    } else {
        2
    }
}

/// A ray on its way from cell to cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk {
    pub cell: [i32; 3],
    step: [i32; 3],
    /// Distances to the walls ahead.
    ahead: [f64; 3],
    inverse: [f64; 3],
    /// Outside for good.
    pub over: bool,
}

impl Walk {
    /// A walk that begins in the cell of the ray's point at distance `t`.
    #[inline]
    pub fn new(lattice: &Lattice, ray: &Ray, t: f64) -> Self {
        let cell = lattice.cell(if t > 0.0 { ray.at(t) } else { ray.origin });
        let mut walk = Walk { cell, step: [0; 3], ahead: [f64::INFINITY; 3], inverse: [0.0; 3], over: false };
        for axis in 0..3 {
            let d = ray.dir[axis];
            if d != 0.0 {
                walk.step[axis] = if d > 0.0 { 1 } else { -1 };
                walk.inverse[axis] = 1.0 / d;
                walk.ahead[axis] = walk.distance(lattice, ray, axis);
            }
        }
        walk
    }

    #[inline]
    fn distance(&self, lattice: &Lattice, ray: &Ray, axis: usize) -> f64 {
        let number = self.cell[axis] + i32::from(self.step[axis] > 0);
        (lattice.wall(axis, number) - ray.origin[axis]) * self.inverse[axis]
    }

    /// Moves a first cell that rounding has put just outside the box into it.
    #[inline]
    pub fn keep_within(&mut self, lattice: &Lattice, ray: &Ray, axis: usize, first: i32, last: i32) {
        let inside = self.cell[axis].clamp(first, last);
        if inside != self.cell[axis] {
            self.cell[axis] = inside;
            if self.step[axis] != 0 {
                self.ahead[axis] = self.distance(lattice, ray, axis);
            }
        }
    }

    /// Where the ray leaves the present cell.
    #[inline]
    pub fn end(&self) -> f64 {
        self.ahead[0].min(self.ahead[1]).min(self.ahead[2])
    }

    /// Into the next cell; the axis across which it lies.
    #[inline]
    pub fn step(&mut self, lattice: &Lattice, ray: &Ray) -> usize {
        let [x, y, z] = self.ahead;
        let axis = if x <= y && x <= z {
            0
        } else if y <= z {
            1
        } else {
            2
        };
        self.cell[axis] = self.cell[axis].saturating_add(self.step[axis]);
        self.ahead[axis] = self.distance(lattice, ray, axis);
        axis
    }
}

/// A body in a cell: its number, and the steps of the periodic image that lies there (−4…3 each).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Item(u32);

impl Item {
    pub fn new(body: u32, image: [i32; 2]) -> Self {
        Item(body | ((image[0] & 7) as u32) << 26 | ((image[1] & 7) as u32) << 29)
    }

    #[inline]
    pub fn body(self) -> u32 {
        self.0 & ((1 << 26) - 1)
    }

    /// The key of its region, seen from a cell that lies `cell` periods away from the first.
    #[inline]
    pub fn key(self, region: u32, cell: [i32; 2]) -> Key {
        if self.0 >> 26 == 0 && cell == [0; 2] {
            return Key::new(region, [0; 2]);
        }
        let signed = |bits: u32| ((bits << 29) as i32) >> 29;
        let x = cell[0] - signed(self.0 >> 26);
        let y = cell[1] - signed(self.0 >> 29);
        Key::new(region, [x as i16, y as i16])
    }
}

/// Lists of a block of cells, one behind the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Lists {
    starts: Vec<u32>,
    items: Vec<Item>,
}

impl Lists {
    /// Two passes over all (cell number, item) pairs that `each` tells: count, then fill.
    pub fn new(cells: usize, mut each: impl FnMut(&mut dyn FnMut(usize, Item))) -> Self {
        let mut starts = vec![0_u32; cells + 1];
        each(&mut |cell, _| starts[cell + 1] += 1);
        for i in 0..cells {
            starts[i + 1] += starts[i];
        }
        let mut items = vec![Item(0); starts[cells] as usize];
        let mut fill = starts.clone();
        each(&mut |cell, item| {
            items[fill[cell] as usize] = item;
            fill[cell] += 1;
        });
        Lists { starts, items }
    }

    #[inline]
    pub fn of(&self, cell: usize) -> &[Item] {
        &self.items[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    pub fn bytes(&self) -> usize {
        4 * (self.starts.capacity() + self.items.capacity())
    }

    pub fn entries(&self) -> usize {
        self.items.len()
    }
}

/// Number of a cell: columns along z lie together, as sheets are thin and rays cross them.
#[inline]
fn slot(n: [i32; 3], [x, y, z]: [i32; 3]) -> usize {
    (y as usize * n[0] as usize + x as usize) * n[2] as usize + z as usize
}

/// A box of cells, laterally repeated without end if `periodic`.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub lattice: Lattice,
    pub n: [i32; 3],
    pub periodic: bool,
    lists: Lists,
}

impl Grid {
    /// A grid over a box; bodies (number, extent) are listed in the cells that they may touch.
    pub fn new(lattice: Lattice, n: [i32; 3], periodic: bool, bodies: &[(u32, Extent)]) -> Self {
        const FAR: i32 = 1 << 20;
        let cells = n.iter().map(|&k| k as usize).product();
        let (lo, hi) =
            if periodic { ([-FAR, -FAR, 0], [FAR, FAR, n[2] - 1]) } else { ([0; 3], n.map(|k| k - 1)) };
        let lists = Lists::new(cells, |tell| {
            for (body, extent) in bodies {
                lattice.cells_of(extent, lo, hi, |[x, y, z]| {
                    let image = [x.div_euclid(n[0]), y.div_euclid(n[1])];
                    let (x, y) = (x.rem_euclid(n[0]), y.rem_euclid(n[1]));
                    tell(slot(n, [x, y, z]), Item::new(*body, image));
                });
            }
        });
        Grid { lattice, n, periodic, lists }
    }

    /// Regions listed in a cell, and how many periods away it lies; `None` outside the box.
    #[inline]
    pub fn list(&self, [x, y, z]: [i32; 3]) -> Option<(&[Item], [i32; 2])> {
        let n = self.n;
        if z < 0 || z >= n[2] {
            return None;
        }
        if x >= 0 && y >= 0 && x < n[0] && y < n[1] {
            return Some((self.lists.of(slot(n, [x, y, z])), [0; 2]));
        }
        if !self.periodic {
            return None;
        }
        let image = [x.div_euclid(n[0]), y.div_euclid(n[1])];
        let (x, y) = (x - image[0] * n[0], y - image[1] * n[1]);
        Some((self.lists.of(slot(n, [x, y, z])), image))
    }

    /// Begins a walk: from the ray's origin, or from where it comes into the box.
    #[inline]
    pub fn walk(&self, ray: &Ray) -> Walk {
        let top = DVec3::from_array(self.n.map(f64::from)) * self.lattice.size + self.lattice.origin;
        let (mut from, mut to) = (0.0_f64, f64::INFINITY);
        let (o, low) = (ray.origin, self.lattice.origin);
        let level = o.z > low.z && o.z < top.z;
        if level && (self.periodic || (o.x > low.x && o.x < top.x && o.y > low.y && o.y < top.y)) {
            return Walk::new(&self.lattice, ray, 0.0);
        }
        for axis in if self.periodic { 2..3 } else { 0..3 } {
            let (o, d) = (ray.origin[axis], ray.dir[axis]);
            let (lo, hi) = (self.lattice.origin[axis], top[axis]);
            if d == 0.0 {
                to = if o < lo || o > hi { -1.0 } else { to };
            } else {
                let (a, b) = ((lo - o) / d, (hi - o) / d);
                from = from.max(a.min(b));
                to = to.min(a.max(b));
            }
        }
        let mut walk = Walk::new(&self.lattice, ray, from);
        walk.over = from > to;
        if !walk.over {
            for axis in if self.periodic { 2..3 } else { 0..3 } {
                walk.keep_within(&self.lattice, ray, axis, 0, self.n[axis] - 1);
            }
        }
        walk
    }

    pub fn bytes(&self) -> usize {
        self.lists.bytes()
    }

    /// Mean number of regions in a cell.
    pub fn filling(&self) -> f64 {
        self.lists.entries() as f64 / self.n.iter().map(|&k| f64::from(k)).product::<f64>()
    }
}
