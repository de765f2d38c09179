//! The lattice of voxels and the walk of a ray through it, cell by cell.
//!
//! Sideways the volume is repeated without end, as it is or mirrored; above and below it lies one more
//! layer of cells without height limit, the outside. Cells are integers: a ray is in the cell that it
//! has walked into, whatever rounding says of its coordinates, so corners, edges, starts on faces and
//! rays along faces need no rule of their own.

use super::volume::Volume;
use crate::universe::Ray;
use std::sync::Arc;

/// How the volume continues sideways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lateral {
    /// Reflected at its side faces: no seam, whatever it was cut out of.
    Mirror,
    /// Repeated as it is.
    Periodic,
}

/// The volume in space: x and y of a lattice point are (index · edge), z too, from the lower face up.
#[derive(Clone, Debug)]
pub struct Lattice {
    /// The voxels.
    pub volume: Arc<Volume>,
    /// Edges of a voxel, µm.
    pub edge: [f64; 3],
    /// Sides.
    pub lateral: Lateral,
    /// Phase above and below.
    pub outside: u8,
    cells: [i64; 3],
    stride: [isize; 3],
}

impl Lattice {
    /// A volume with voxels of the given edges (µm).
    pub fn new(volume: Arc<Volume>, edge: [f64; 3], lateral: Lateral, outside: u8) -> Self {
        let n = volume.cells();
        let stride = [1, n[0] as isize, (n[0] * n[1]) as isize];
        Lattice { volume, edge, lateral, outside, cells: n.map(|n| n as i64), stride }
    }

    /// Height, µm.
    pub fn top(&self) -> f64 {
        self.cells[2] as f64 * self.edge[2]
    }

    /// After what the lattice repeats along x or y, µm.
    pub fn period(&self, axis: usize) -> f64 {
        let n = self.cells[axis] as f64 * self.edge[axis];
        if self.lateral == Lateral::Mirror { 2.0 * n } else { n }
    }

    /// Number of voxels along an axis.
    pub fn cells(&self, axis: usize) -> i64 {
        self.cells[axis]
    }

    /// Column of the volume that lattice column `i` along x or y is, and whether it is seen mirrored.
    #[inline]
    pub fn fold(&self, axis: usize, i: i64) -> (i64, bool) {
        let n = self.cells[axis];
        if axis == 2 {
            return (i, false);
        }
        if self.lateral == Lateral::Periodic {
            return (i.rem_euclid(n), false);
        }
        let m = i.rem_euclid(2 * n);
        if m < n { (m, false) } else { (2 * n - 1 - m, true) }
    }

    /// Phase of a lattice cell.
    #[inline]
    pub fn phase(&self, cell: [i64; 3]) -> u8 {
        if cell[2] < 0 || cell[2] >= self.cells[2] {
            return self.outside;
        }
        let (x, y) = (self.fold(0, cell[0]).0 as usize, self.fold(1, cell[1]).0 as usize);
        self.volume.at([x, y, cell[2] as usize])
    }

    /// The cell of a point; on a plane between two the one ahead, on the upper and lower face the
    /// outside.
    pub fn locate(&self, point: [f64; 3], dir: [f64; 3]) -> [i64; 3] {
        let mut cell = [0; 3];
        for a in 0..3 {
            let q = point[a] / self.edge[a];
            let floor = q.floor();
            cell[a] = if q == floor && dir[a] < 0.0 { floor as i64 - 1 } else { floor as i64 };
        }
        cell[2] = if point[2] >= self.top() {
            self.cells[2]
        } else if point[2] <= 0.0 {
            -1
        } else {
            cell[2].clamp(0, self.cells[2] - 1)
        };
        cell
    }
}

/// A ray on its way through the lattice.
#[derive(Clone)]
pub struct Walk<'a> {
    lattice: &'a Lattice,
    volume: &'a Volume,
    origin: [f64; 3],
    inverse: [f64; 3],
    /// Distances to the next plane of each axis.
    t: [f64; 3],
    sign: [i64; 3],
    /// Where it is.
    pub cell: [i64; 3],
    stride: [isize; 3],
    /// Cells that still lie ahead before a side of the volume.
    room: [i64; 3],
    index: isize,
    outside: bool,
}

/// Below this a component of the direction leads nowhere within 1e150 edges.
const STILL: f64 = 1e-150;

impl<'a> Walk<'a> {
    /// A ray in `cell`; `shift` is what turns its x and y into those of the lattice.
    pub fn new(lattice: &'a Lattice, ray: &Ray, shift: [f64; 2], cell: [i64; 3]) -> Self {
        let origin = [ray.origin.x + shift[0], ray.origin.y + shift[1], ray.origin.z];
        let dir = ray.dir.to_array();
        let sign = dir.map(|u| if u > STILL { 1 } else { -i64::from(u < -STILL) });
        let outside = cell[2] < 0 || cell[2] >= lattice.cells[2];
        let inverse = dir.map(|u| 1.0 / u);
        let mut walk = Walk {
            lattice,
            volume: &lattice.volume,
            origin,
            inverse,
            t: [f64::INFINITY; 3],
            sign,
            cell,
            stride: [0; 3],
            room: [0; 3],
            index: 0,
            outside,
        };
        if outside && !walk.leaves() {
            // From outside straight to where it comes in.
            let plane = if cell[2] < 0 { 0.0 } else { lattice.top() };
            let t = ((plane - origin[2]) * inverse[2]).max(0.0);
            let at = lattice.locate([0, 1, 2].map(|a| origin[a] + dir[a] * t), dir);
            walk.cell = [at[0], at[1], cell[2]];
        }
        walk.set_out();
        walk
    }

    /// Index, strides, room and planes from the cell.
    fn set_out(&mut self) {
        let mut column = self.cell;
        column[2] = column[2].clamp(0, self.lattice.cells[2] - 1);
        self.index = 0;
        for a in 0..3 {
            let (i, mirrored) = self.lattice.fold(a, column[a]);
            let n = self.lattice.cells[a];
            let s = if mirrored { -self.sign[a] } else { self.sign[a] };
            self.stride[a] = s as isize * self.lattice.stride[a];
            self.room[a] = if s > 0 { n - 1 - i } else { i };
            self.index += i as isize * self.lattice.stride[a];
            self.plane_ahead(a);
        }
    }

    #[inline]
    fn plane_ahead(&mut self, a: usize) {
        if self.sign[a] != 0 {
            let plane = (self.cell[a] + i64::from(self.sign[a] > 0)) as f64 * self.lattice.edge[a];
            self.t[a] = (plane - self.origin[a]) * self.inverse[a];
        }
    }

    /// In the layer above or below the volume.
    #[inline]
    pub fn is_outside(&self) -> bool {
        self.outside
    }

    /// Outside, and not on its way in.
    #[inline]
    pub fn leaves(&self) -> bool {
        self.outside && if self.cell[2] < 0 { self.sign[2] <= 0 } else { self.sign[2] >= 0 }
    }

    /// Phase of the cell.
    #[inline]
    pub fn phase(&self) -> u8 {
        if self.outside { self.lattice.outside } else { self.volume.get(self.index as usize) }
    }

    /// Axis across which the ray leaves the cell, and where (≥ 0).
    #[inline]
    pub fn ahead(&self) -> (usize, f64) {
        let [x, y, z] = self.t;
        let (a, t) = if y < x { (1, y) } else { (0, x) };
        let (a, t) = if z < t { (2, z) } else { (a, t) };
        (a, t.max(0.0))
    }

    /// Into the next cell across `a`.
    #[inline]
    pub fn step(&mut self, a: usize) {
        self.cell[a] += self.sign[a];
        self.plane_ahead(a);
        if self.room[a] > 0 && !(self.outside && a == 2) {
            self.room[a] -= 1;
            self.index += self.stride[a];
        } else {
            self.past_the_side(a);
        }
    }

    fn past_the_side(&mut self, a: usize) {
        let n = self.lattice.cells[a];
        if a == 2 {
            self.room[2] = if self.outside { n - 1 } else { 0 };
            self.outside = !self.outside;
        } else {
            self.room[a] = n - 1;
            match self.lattice.lateral {
                Lateral::Mirror => self.stride[a] = -self.stride[a],
                Lateral::Periodic => self.index -= self.stride[a] * (n as isize - 1),
            }
        }
    }

    /// Sign of the step across `a`.
    #[inline]
    pub fn sign(&self, a: usize) -> i64 {
        self.sign[a]
    }

    /// Place along `a` at distance `t`, in edges from the cell's lower plane, within [0, 1].
    #[inline]
    pub fn within(&self, a: usize, t: f64, dir: f64) -> f64 {
        ((self.origin[a] + dir * t) / self.lattice.edge[a] - self.cell[a] as f64).clamp(0.0, 1.0)
    }
}
