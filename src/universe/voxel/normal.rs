//! Normals of a voxelised surface: the gradient of the phase indicator, smoothed by a Gaussian.
//!
//! At a face between a voxel of phase P and one of phase Q let s = +1 in P, −1 in Q, 0 in any third
//! phase. The normal is n ∝ Σ s(c) ∇G_σ(v − c) over the cells c within 3σ (per axis, in voxels) of a
//! lattice vertex v, G_σ the Gaussian; between the four vertices of the face it is interpolated
//! linearly, so that it does not jump from face to face.
//!
//! A wall of few voxels has P on both sides, and the far side would cancel the near one. So only what
//! hangs together with the two voxels of the face counts as what it is, by a flood fill within the
//! window: P not connected to this P counts as Q (the far side of the wall continues the wall), Q not
//! connected to this Q counts as P (another wall across a gap continues the gap).

use super::lattice::Lattice;
use crate::math::{DVec3, exp};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// A face between two voxels of the folded volume: the lower voxel and the axis across.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaceId {
    /// Voxel on the lower side (−1 along z: the outside below).
    pub low: [i64; 3],
    /// Axis across the face.
    pub axis: usize,
}

/// Bits of a row of a window.
type Row = u64;

/// Weights of a Gaussian and its derivative about a vertex.
#[derive(Debug)]
struct Kernel {
    reach: usize,
    weight: Vec<f64>,
    slope: Vec<f64>,
    /// Sums of (weight, slope) over the set bits of each byte of a row.
    sums: Vec<[[f64; 2]; 256]>,
}

impl Kernel {
    fn new(sigma: f64) -> Self {
        let reach = (3.0 * sigma).ceil() as usize;
        let offset = |k: usize| k as f64 + 0.5 - reach as f64;
        let weight: Vec<f64> = (0..2 * reach)
            .map(|k| {
                let x = offset(k) / sigma;
                exp(-0.5 * x * x)
            })
            .collect();
        let slope: Vec<f64> = (0..2 * reach).map(|k| offset(k) * weight[k] / (sigma * sigma)).collect();
        let chunks = (2 * reach).div_ceil(8);
        let sum = |chunk: usize, byte: usize| {
            (0..8)
                .filter(|b| byte >> b & 1 == 1)
                .map(|b| 8 * chunk + b)
                .filter(|k| *k < 2 * reach)
                .fold([0.0; 2], |s, k| [s[0] + weight[k], s[1] + slope[k]])
        };
        let sums = (0..chunks).map(|c| std::array::from_fn(|byte| sum(c, byte))).collect();
        Kernel { reach, weight, slope, sums }
    }

    /// Σ weight and Σ slope over the set bits.
    #[inline]
    fn row(&self, bits: Row) -> [f64; 2] {
        let mut out = [0.0; 2];
        for (chunk, table) in self.sums.iter().enumerate() {
            let s = table[(bits >> (8 * chunk) & 0xff) as usize];
            out[0] += s[0];
            out[1] += s[1];
        }
        out
    }
}

/// Scratch of one worker.
#[derive(Debug, Default)]
pub struct Window {
    extent: [usize; 3],
    /// Rows along x of the cells of the two phases, at y + extent_y · z.
    plus: Vec<Row>,
    minus: Vec<Row>,
    part: Vec<Row>,
    other: Vec<Row>,
}

impl Window {
    /// Fills the rows of phases `p` and `q` from the cell `start` on.
    fn fill(&mut self, lattice: &Lattice, start: [i64; 3], extent: [usize; 3], (p, q): (u8, u8)) {
        self.extent = extent;
        let rows = extent[1] * extent[2];
        for rows_of in [&mut self.plus, &mut self.minus, &mut self.part, &mut self.other] {
            rows_of.clear();
            rows_of.resize(rows, 0);
        }
        let [nx, ny, _] = lattice.volume.cells();
        let columns: [usize; 64] = std::array::from_fn(|x| lattice.fold(0, start[0] + x as i64).0 as usize);
        for z in 0..extent[2] {
            let k = start[2] + z as i64;
            let inside = k >= 0 && k < lattice.cells(2);
            for y in 0..extent[1] {
                let at = y + extent[1] * z;
                if !inside {
                    let all = (1 << extent[0]) - 1;
                    self.plus[at] = if lattice.outside == p { all } else { 0 };
                    self.minus[at] = if lattice.outside == q { all } else { 0 };
                    continue;
                }
                let j = lattice.fold(1, start[1] + y as i64).0 as usize;
                let base = nx * (j + ny * k as usize);
                let (mut plus, mut minus) = (0, 0);
                for (x, column) in columns[..extent[0]].iter().enumerate() {
                    let phase = lattice.volume.get(base + column);
                    plus |= Row::from(phase == p) << x;
                    minus |= Row::from(phase == q) << x;
                }
                (self.plus[at], self.minus[at]) = (plus, minus);
            }
        }
    }

    /// Keeps of each phase what is connected (through faces) to its seed, and counts the rest to the
    /// other phase.
    fn connect(&mut self, plus_seed: [usize; 3], minus_seed: [usize; 3]) {
        flood(&self.plus, &mut self.part, plus_seed, self.extent);
        flood(&self.minus, &mut self.other, minus_seed, self.extent);
        for i in 0..self.plus.len() {
            let (p, q) = (self.plus[i], self.minus[i]);
            self.plus[i] = self.part[i] | (q & !self.other[i]);
            self.minus[i] = self.other[i] | (p & !self.part[i]);
        }
    }

    /// Σ s ∇G about the vertex that lies `offset` (0 or 1 each) from the window's first one.
    fn gradient(&self, kernel: &Kernel, offset: [usize; 3]) -> DVec3 {
        let n = 2 * kernel.reach;
        let mask = (1 << n) - 1;
        let mut g = DVec3::ZERO;
        for z in 0..n {
            let (mut plain, mut x, mut y) = (0.0, 0.0, 0.0);
            for (k, (wy, dy)) in kernel.weight.iter().zip(&kernel.slope).enumerate() {
                let at = k + offset[1] + self.extent[1] * (z + offset[2]);
                let (p, q) = (self.plus[at] >> offset[0] & mask, self.minus[at] >> offset[0] & mask);
                if p == 0 && q == 0 {
                    continue;
                }
                let (p, q) = (kernel.row(p), kernel.row(q));
                let (w, d) = (p[0] - q[0], p[1] - q[1]);
                plain += wy * w;
                x += wy * d;
                y += dy * w;
            }
            g += DVec3::new(kernel.weight[z] * x, kernel.weight[z] * y, kernel.slope[z] * plain);
        }
        g
    }
}

/// What is connected to `seed` through faces, row by row until nothing is added.
fn flood(of: &[Row], into: &mut [Row], seed: [usize; 3], extent: [usize; 3]) {
    let [_, ny, nz] = extent;
    into.fill(0);
    into[seed[1] + ny * seed[2]] = 1 << seed[0] & of[seed[1] + ny * seed[2]];
    let mut grow = |y: usize, z: usize| {
        let at = y + ny * z;
        let mut row = into[at];
        if y > 0 {
            row |= into[at - 1];
        }
        if y + 1 < ny {
            row |= into[at + 1];
        }
        if z > 0 {
            row |= into[at - ny];
        }
        if z + 1 < nz {
            row |= into[at + ny];
        }
        row &= of[at];
        // Along the row: Kogge–Stone fill both ways.
        let mut free = of[at];
        let (mut up, mut down, mut free_down) = (row, row, free);
        for s in [1, 2, 4, 8, 16, 32] {
            up |= free & (up << s);
            free &= free << s;
            down |= free_down & (down >> s);
            free_down &= free_down >> s;
        }
        let row = up | down;
        let changed = row != into[at];
        into[at] = row;
        changed
    };
    loop {
        let mut changed = false;
        for z in 0..nz {
            for y in 0..ny {
                changed |= grow(y, z);
            }
        }
        if !changed {
            return;
        }
        changed = false;
        for z in (0..nz).rev() {
            for y in (0..ny).rev() {
                changed |= grow(y, z);
            }
        }
        if !changed {
            return;
        }
    }
}

/// Normals of one volume, kept as they are asked for. What is kept is what is computed anew
/// otherwise, bit for bit: results depend neither on the order of questions nor on threads.
#[derive(Clone, Debug)]
pub struct Normals {
    kernel: Arc<Kernel>,
    kept: Arc<[AtomicU64]>,
    log_slots: u32,
    key_bits: u32,
}

/// Odd: multiplication is one-to-one on the low bits.
const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;
/// Bits of a component of a kept normal.
const FINE: u32 = 20;
/// Marks a slot in use.
const USED: u64 = 1 << 63;

impl Normals {
    /// Normals smoothed over `sigma` voxels (0.5 … 6).
    pub fn new(lattice: &Lattice, sigma: f64) -> Self {
        let corners = 12 * (lattice.volume.len() as u64 + 2 * (lattice.cells(0) * lattice.cells(1)) as u64);
        let key_bits = 64 - corners.leading_zeros();
        // Half a slot per voxel face corner of small volumes, 64 MiB at most.
        let log_slots = key_bits.saturating_sub(1).clamp(8, 23);
        let kept = (0..1_usize << log_slots).map(|_| AtomicU64::new(0)).collect();
        Normals { kernel: Arc::new(Kernel::new(sigma)), kept, log_slots, key_bits: key_bits.max(log_slots) }
    }

    /// Normals at the four vertices of a face, towards its lower voxel's phase p from its upper voxel's q, `phases` = (p, q), in the order of
    /// the two other axes (first axis fastest); zero where nothing points anywhere.
    pub fn of_face(
        &self,
        lattice: &Lattice,
        face: FaceId,
        phases: (u8, u8),
        window: &mut Window,
    ) -> [DVec3; 4] {
        let mut out = [DVec3::ZERO; 4];
        let cells = |a: usize| lattice.cells(a) as u64;
        let [x, y, z] = face.low.map(|i| i as u64);
        let number = (x + cells(0) * (y + cells(1) * z.wrapping_add(1))) * 3 + face.axis as u64;
        let slot = |corner: u64| {
            let bits = (number * 4 + corner).wrapping_mul(SPREAD) & ((1 << self.key_bits) - 1);
            let tag = bits >> self.log_slots << (2 * FINE);
            (&self.kept[(bits & ((1 << self.log_slots) - 1)) as usize], USED | tag)
        };
        let mut all = true;
        for (corner, n) in out.iter_mut().enumerate() {
            let (kept, tag) = slot(corner as u64);
            let word = kept.load(Relaxed);
            if word >> (2 * FINE) == tag >> (2 * FINE) {
                *n = unpack(word);
            } else {
                all = false;
                break;
            }
        }
        if all {
            return out;
        }
        for (corner, n) in self.compute(lattice, face, phases, window).into_iter().enumerate() {
            let (kept, tag) = slot(corner as u64);
            let word = tag | pack(n);
            kept.store(word, Relaxed);
            out[corner] = unpack(word);
        }
        out
    }

    fn compute(&self, lattice: &Lattice, face: FaceId, phases: (u8, u8), window: &mut Window) -> [DVec3; 4] {
        let (a, r) = (face.axis, self.kernel.reach);
        let mut start = face.low.map(|i| i - r as i64);
        let mut extent = [2 * r + 1; 3];
        start[a] += 1;
        extent[a] -= 1;
        window.fill(lattice, start, extent, phases);
        let mut seed = [r; 3];
        seed[a] = r - 1;
        let mut beyond = seed;
        beyond[a] = r;
        window.connect(seed, beyond);
        let (b, c) = others(a);
        std::array::from_fn(|corner| {
            let mut offset = [0; 3];
            offset[b] = corner & 1;
            offset[c] = corner >> 1;
            self.direction(lattice, window, offset)
        })
    }

    /// The gradient as a direction in space: edges may be of unequal length.
    fn direction(&self, lattice: &Lattice, window: &Window, offset: [usize; 3]) -> DVec3 {
        (window.gradient(&self.kernel, offset) / DVec3::from_array(lattice.edge)).normalize_or_zero()
    }

    /// Normal towards phase p from q about the vertex nearest to a point of the lattice (in cells),
    /// connected or not.
    pub fn about(&self, lattice: &Lattice, point: DVec3, phases: (u8, u8), window: &mut Window) -> DVec3 {
        let r = self.kernel.reach;
        let start = point.to_array().map(|x| x.round() as i64 - r as i64);
        window.fill(lattice, start, [2 * r; 3], phases);
        self.direction(lattice, window, [0; 3])
    }
}

/// The other two axes.
#[inline]
pub fn others(axis: usize) -> (usize, usize) {
    match axis {
        0 => (1, 2),
        1 => (0, 2),
        _ => (0, 1),
    }
}

/// Octahedral map of a direction to 2 × [`FINE`] bits (error below 5e-6 rad); 0 stands for no
/// direction.
fn pack(n: DVec3) -> u64 {
    if n == DVec3::ZERO {
        return 0;
    }
    let n = n / (n.x.abs() + n.y.abs() + n.z.abs());
    let (x, y) = if n.z >= 0.0 {
        (n.x, n.y)
    } else {
        ((1.0 - n.y.abs()).copysign(n.x), (1.0 - n.x.abs()).copysign(n.y))
    };
    let most = f64::from((1_u32 << FINE) - 2);
    let fine = |v: f64| 1 + ((0.5 * v + 0.5) * most).round().clamp(0.0, most) as u64;
    fine(x) << FINE | fine(y)
}

fn unpack(word: u64) -> DVec3 {
    let word = word & ((1 << (2 * FINE)) - 1);
    if word == 0 {
        return DVec3::ZERO;
    }
    let most = f64::from((1_u32 << FINE) - 2);
    let coarse = |v: u64| (v - 1) as f64 / most * 2.0 - 1.0;
    let (x, y) = (coarse(word >> FINE), coarse(word & ((1 << FINE) - 1)));
    let z = 1.0 - x.abs() - y.abs();
    let n = if z >= 0.0 {
        DVec3::new(x, y, z)
    } else {
        DVec3::new((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y), z)
    };
    n.normalize()
}

#[cfg(test)]
mod tests;
