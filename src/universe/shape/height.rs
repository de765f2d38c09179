//! A surface z = h(x, y) from a map of heights: sheet topography.
//!
//! Heights stand at the nodes of a rectangular grid that repeats itself along x and y; between four nodes the
//! surface is the **bilinear patch** through them: h = h₀₀ + b u + c v + d u v. It is continuous everywhere;
//! its normal is continuous within a cell and turns at the border of two cells (by the second difference of
//! the heights over the pixel), where it is that of the cell that the ray comes through.
//!
//! Along a ray f = z − h is a quadratic in each cell. What a ray may meet follows from its **state**, the
//! side that it is on: from above only a root where f falls, from below only one where it rises. The surface
//! just left is a root of the other kind, and is taken out analytically: f = t (B + C t). No epsilon. At the
//! border of two cells both sides' rounded values of f decide in turn, so that no ray slips through.

use crate::math::DVec3;
use crate::universe::Ray;

/// Heights that no surface can be made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HeightError {
    /// Too few nodes, or not as many heights as nodes.
    #[error("a map of heights has at least 2 x 2 nodes, and one height for each")]
    Nodes,
    /// No pixel size.
    #[error("the pixel size must be positive and finite along x and y")]
    Pixel,
    /// A hole: no number where a height should be.
    #[error("no height at column {0}, row {1}: holes have to be filled before")]
    Hole(usize, usize),
}

/// A surface z = h(x, y), µm, periodic along x and y.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    nodes: [usize; 2],
    pixel: [f64; 2],
    heights: Vec<f64>,
    range: [f64; 2],
}

/// Where a ray meets the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// Distance along the ray, µm, ≥ 0.
    pub distance: f64,
    /// Unit normal that points up.
    pub up: DVec3,
}

/// What a search along a ray has come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ahead {
    /// The surface.
    Met(Meeting),
    /// No surface within the reach.
    Free,
    /// More than [`MOST_CELLS`] cells without an answer: a ray along a groove.
    Endless,
}

/// Cells that a ray is followed through at most.
pub const MOST_CELLS: u64 = 1 << 24;

/// The surface over one cell: h = a + b u + c v + d u v, with u, v from 0 to 1.
#[derive(Clone, Copy)]
struct Patch {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
}

impl HeightMap {
    /// `heights` (µm) row by row: x runs fastest, node (i, j) stands at x = i·`pixel[0]`, y = j·`pixel[1]` (µm).
    ///
    /// # Errors
    /// [`HeightError`]: too few nodes, no pixel size, NaN or infinite heights.
    pub fn new(heights: Vec<f64>, nodes: [usize; 2], pixel: [f64; 2]) -> Result<Self, HeightError> {
        if nodes.iter().any(|&n| n < 2) || nodes[0].checked_mul(nodes[1]) != Some(heights.len()) {
            return Err(HeightError::Nodes);
        }
        if !pixel.iter().all(|&p| p > 0.0 && p.is_finite()) {
            return Err(HeightError::Pixel);
        }
        if let Some(i) = heights.iter().position(|h| !h.is_finite()) {
            return Err(HeightError::Hole(i % nodes[0], i / nodes[0]));
        }
        let range =
            heights.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], &h| [lo.min(h), hi.max(h)]);
        Ok(HeightMap { nodes, pixel, heights, range })
    }

    /// A map as instruments measure it: `mirror` lets it go on by reflection at its borders, so that it has no
    /// seam; `level` (µm) moves its mean there; a profile, one row or column, is drawn out across.
    ///
    /// # Errors
    /// [`HeightError`], places counted as given.
    pub fn measured(
        mut heights: Vec<f64>,
        mut nodes: [usize; 2],
        pixel: [f64; 2],
        mirror: bool,
        level: Option<f64>,
    ) -> Result<Self, HeightError> {
        if heights.is_empty() || nodes[0].checked_mul(nodes[1]) != Some(heights.len()) {
            return Err(HeightError::Nodes);
        }
        if let Some(i) = heights.iter().position(|h| !h.is_finite()) {
            return Err(HeightError::Hole(i % nodes[0], i / nodes[0]));
        }
        if let Some(level) = level {
            let mean = heights.iter().sum::<f64>() / heights.len() as f64;
            heights.iter_mut().for_each(|h| *h += level - mean);
        }
        let along = |n: usize| match n {
            1 => vec![0, 0],
            n if mirror => (0..n).chain((1..n - 1).rev()).collect(),
            n => (0..n).collect::<Vec<_>>(),
        };
        let (columns, rows) = (along(nodes[0]), along(nodes[1]));
        if (columns.len(), rows.len()) != (nodes[0], nodes[1]) {
            let row = |j: usize| columns.iter().map(move |&i| j * nodes[0] + i);
            let order: Vec<usize> = rows.iter().flat_map(|&j| row(j)).collect();
            heights = order.into_iter().map(|k| heights[k]).collect();
            nodes = [columns.len(), rows.len()];
        }
        Self::new(heights, nodes, pixel)
    }

    /// Nodes along x and y of a period, and the edges of a cell between them, µm.
    pub fn grid(&self) -> ([usize; 2], [f64; 2]) {
        (self.nodes, self.pixel)
    }

    /// Mean height and root mean square deviation from it (Sq of ISO 25178-2) of the nodes, µm, and the root
    /// mean square slope of the surface along x and y (Sdq² is the sum of their squares).
    pub fn roughness(&self) -> (f64, f64, [f64; 2]) {
        let n = self.heights.len() as f64;
        let mean = self.heights.iter().sum::<f64>() / n;
        let square = self.heights.iter().map(|h| (h - mean) * (h - mean)).sum::<f64>() / n;
        let mut slopes = [0.0; 2];
        for k in 0..self.heights.len() {
            let p = self.patch([(k % self.nodes[0]) as i64, (k / self.nodes[0]) as i64]);
            // Means over the patch of (b + d v)² and (c + d u)².
            slopes[0] += p.b * p.b + p.b * p.d + p.d * p.d / 3.0;
            slopes[1] += p.c * p.c + p.c * p.d + p.d * p.d / 3.0;
        }
        (mean, square.sqrt(), [0, 1].map(|a| (slopes[a] / n).sqrt() / self.pixel[a]))
    }

    /// Lowest and highest point, µm.
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// Periods along x and y, µm.
    pub fn period(&self) -> [f64; 2] {
        [0, 1].map(|a| self.nodes[a] as f64 * self.pixel[a])
    }

    /// Height over a point, µm.
    pub fn height(&self, x: f64, y: f64) -> f64 {
        let (cell, [u, v]) = self.cell(x, y);
        let p = self.patch(cell);
        p.a + p.b * u + v * (p.c + p.d * u)
    }

    /// Cell of a point, and where in it.
    fn cell(&self, x: f64, y: f64) -> ([i64; 2], [f64; 2]) {
        let at = [x / self.pixel[0], y / self.pixel[1]];
        let cell = at.map(f64::floor);
        (cell.map(|c| c as i64), [at[0] - cell[0], at[1] - cell[1]])
    }

    fn patch(&self, cell: [i64; 2]) -> Patch {
        let node = |dx: i64, dy: i64| {
            let i = (cell[0] + dx).rem_euclid(self.nodes[0] as i64) as usize;
            let j = (cell[1] + dy).rem_euclid(self.nodes[1] as i64) as usize;
            self.heights[j * self.nodes[0] + i]
        };
        let (h, x, y, xy) = (node(0, 0), node(1, 0), node(0, 1), node(1, 1));
        Patch { a: h, b: x - h, c: y - h, d: (xy - x) - (y - h) }
    }

    /// Unit normal of a cell's patch at (u, v), upwards.
    fn normal(&self, p: &Patch, [u, v]: [f64; 2]) -> DVec3 {
        let [dx, dy] = self.pixel;
        DVec3::new(-(p.b + p.d * v) / dx, -(p.c + p.d * u) / dy, 1.0).normalize()
    }

    /// The surface ahead of a ray that is `above` it (or below), within `reach` (µm); `just_left`: the ray
    /// starts on it. Where rounding puts the start on the wrong side, the side told decides: the surface is
    /// then met at distance 0 by a ray that goes on through it.
    pub fn ahead(&self, ray: &Ray, above: bool, just_left: bool, reach: f64) -> Ahead {
        let side = if above { 1.0 } else { -1.0 };
        let (mut t, end) = self.between(ray, above, reach);
        if t > end {
            return Ahead::Free;
        }
        if self.range[0] == self.range[1] {
            return self.plane(t, just_left || above == (ray.dir.z >= 0.0));
        }
        let mut walk = Walk::new(self, ray, t);
        let mut fresh = just_left && t == 0.0;
        for _ in 0..MOST_CELLS {
            let stop = walk.end().min(end);
            let patch = self.patch(walk.cell);
            // Where in the cell the ray is, from its own start: nothing adds up from cell to cell.
            let at = |t: f64| {
                let local = |a: usize| (ray.origin[a] + ray.dir[a] * t) / self.pixel[a] - walk.cell[a] as f64;
                [local(0), local(1)]
            };
            let [u, v] = at(t);
            let [du, dv] = [ray.dir.x / self.pixel[0], ray.dir.y / self.pixel[1]];
            let a = (ray.origin.z + ray.dir.z * t) - (patch.a + patch.b * u + v * (patch.c + patch.d * u));
            let b = ray.dir.z - (patch.b * du + patch.c * dv + patch.d * (u * dv + v * du));
            let c = -patch.d * du * dv;
            if let Some(way) = falls(side * a, side * b, side * c, fresh)
                && t + way <= stop
            {
                let distance = t + way;
                return Ahead::Met(Meeting { distance, up: self.normal(&patch, at(distance)) });
            }
            if stop >= end {
                return Ahead::Free;
            }
            fresh = false;
            t = stop.max(t);
            walk.step(self, ray);
        }
        Ahead::Endless
    }

    /// A map of one height, met at (h − z)/u_z like every horizontal plane: same bits as a slab's face.
    fn plane(&self, distance: f64, away: bool) -> Ahead {
        if away { Ahead::Free } else { Ahead::Met(Meeting { distance, up: DVec3::Z }) }
    }

    /// From where to where on its way a ray may meet the surface: between the lowest and the highest point.
    fn between(&self, ray: &Ray, above: bool, reach: f64) -> (f64, f64) {
        let ([lo, hi], z, w) = (self.range, ray.origin.z, ray.dir.z);
        let (near, far) = if w < 0.0 { (hi, lo) } else { (lo, hi) };
        // Before the range the ray is on its side surely; behind it only if it goes back to that side. A ray
        // on the way out that rounding left behind the range meets nothing.
        let from = match (w != 0.0, above == (w < 0.0)) {
            (true, true) => ((near - z) / w).max(0.0),
            _ => 0.0,
        };
        let to = match (w != 0.0, above == (w > 0.0)) {
            (true, true) => (far - z) / w,
            _ => f64::INFINITY,
        };
        let flat = w == 0.0 && (if above { z > hi } else { z < lo });
        if flat { (0.0, -1.0) } else { (from, reach.min(to)) }
    }
}

/// Where A + B t + C t² falls through 0 for a ray on its positive side; `fresh` (or A ≤ 0 by rounding): t = 0
/// is the root just left.
#[inline]
fn falls(a: f64, b: f64, c: f64, fresh: bool) -> Option<f64> {
    if fresh || a <= 0.0 {
        return match (b < 0.0, c < 0.0) {
            (true, _) => Some(0.0),
            (false, true) => Some(-b / c),
            (false, false) => None,
        };
    }
    let disc = b * b - 4.0 * a * c;
    if disc < 0.0 || (b >= 0.0 && c >= 0.0) {
        return None;
    }
    let root = disc.sqrt();
    Some(if b < 0.0 { 2.0 * a / (root - b) } else { (b + root) / (-2.0 * c) })
}

/// A walk from cell to cell; borders are at their own places, not summed.
struct Walk {
    cell: [i64; 2],
    next: [f64; 2],
}

impl Walk {
    fn new(map: &HeightMap, ray: &Ray, t: f64) -> Self {
        let at = ray.at(t);
        let mut walk = Walk { cell: map.cell(at.x, at.y).0, next: [f64::INFINITY; 2] };
        for axis in 0..2 {
            walk.border(map, ray, axis);
        }
        walk
    }

    /// Distance of the border ahead along an axis.
    fn border(&mut self, map: &HeightMap, ray: &Ray, axis: usize) {
        let d = ray.dir[axis];
        let ahead = self.cell[axis] + i64::from(d > 0.0);
        self.next[axis] =
            if d == 0.0 { f64::INFINITY } else { (ahead as f64 * map.pixel[axis] - ray.origin[axis]) / d };
    }

    fn end(&self) -> f64 {
        self.next[0].min(self.next[1])
    }

    fn step(&mut self, map: &HeightMap, ray: &Ray) {
        let axis = usize::from(self.next[1] < self.next[0]);
        self.cell[axis] += if ray.dir[axis] > 0.0 { 1 } else { -1 };
        self.border(map, ray, axis);
    }
}
