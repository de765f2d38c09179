//! The forming sheet seen from above: how high it stands over each element of the cell.

use super::{CLEAR, Fibre};

/// Heights over a square grid of a periodic cell.
pub(super) struct Ground {
    n: i64,
    pitch: f64,
    /// Highest point over the whole of an element, µm, or more.
    high: Vec<f64>,
    /// Highest and lowest surface over an element's middle.
    surface: Vec<f32>,
    under: Vec<f32>,
}

/// An element below a fibre.
struct Below {
    index: usize,
    /// Its middle along and across the fibre, from the fibre's middle, µm.
    along: f64,
    across: f64,
}

/// √(1 − (y/a)²): height of an ellipse over its half axis.
fn arch(y: f64, a: f64) -> f64 {
    let s = y / a;
    (1.0 - s * s).max(0.0).sqrt()
}

impl Ground {
    pub fn new(cell: f64, pitch: f64) -> Self {
        let n = (cell / pitch).ceil().max(1.0);
        let elements = (n * n) as usize;
        Ground {
            n: n as i64,
            pitch: cell / n,
            high: vec![0.0; elements],
            surface: vec![CLEAR as f32; elements],
            under: vec![f32::INFINITY; elements],
        }
    }

    /// Steps into which a fibre's length is divided: at most as long as an element is wide.
    pub fn bins(&self, half: f64) -> usize {
        (2.0 * half / self.pitch).ceil().max(1.0) as usize
    }

    /// Half extent of an element along any direction of the fibre's frame.
    fn reach(&self, fibre: &Fibre) -> f64 {
        0.5 * self.pitch * (fibre.frame.z.x.abs() + fibre.frame.z.y.abs())
    }

    /// All elements that a fibre covers in part.
    fn visit(&self, fibre: &Fibre, mut tell: impl FnMut(Below)) {
        let (c, s) = (fibre.frame.z.x, fibre.frame.z.y);
        let reach = self.reach(fibre);
        let (long, wide) = (fibre.half + reach, fibre.outer.0 + reach);
        let tall = long * s.abs() + wide * c.abs();
        let number = |x: f64| x / self.pitch - 0.5;
        let (first, last) =
            (number(fibre.centre.y - tall).ceil() as i64, number(fibre.centre.y + tall).floor() as i64);
        // dx with lo ≤ dx k + shift ≤ hi, |…| ≤ limit.
        let within = |k: f64, shift: f64, limit: f64| {
            if k.abs() < 1e-12 {
                return if shift.abs() <= limit { (-1e9, 1e9) } else { (1.0, 0.0) };
            }
            let (p, q) = ((-limit - shift) / k, (limit - shift) / k);
            (p.min(q), p.max(q))
        };
        for row in first..=last {
            let dy = (row as f64 + 0.5) * self.pitch - fibre.centre.y;
            let (a, b) = (within(c, dy * s, long), within(-s, dy * c, wide));
            let (lo, hi) = (a.0.max(b.0), a.1.min(b.1));
            if lo > hi {
                continue;
            }
            let start = row.rem_euclid(self.n) * self.n;
            let (from, to) =
                (number(fibre.centre.x + lo).ceil() as i64, number(fibre.centre.x + hi).floor() as i64);
            for column in from..=to {
                let dx = (column as f64 + 0.5) * self.pitch - fibre.centre.x;
                let index = (start + column.rem_euclid(self.n)) as usize;
                tell(Below { index, along: dx * c + dy * s, across: dy * c - dx * s });
            }
        }
    }

    /// How high the sheet stands below a fibre: mean over its length of the highest of five points across.
    pub fn support(&self, fibre: &Fibre) -> f64 {
        const STEP: f64 = 4.0;
        let count = (2.0 * fibre.half / STEP).ceil().max(1.0);
        let at = |x: f64| ((x / self.pitch).floor() as i64).rem_euclid(self.n);
        let height = |k: i32| {
            let along = fibre.half * (2.0 * (f64::from(k) + 0.5) / count - 1.0);
            let point = |j: i32| {
                let p = fibre.centre
                    + fibre.frame.z * along
                    + fibre.frame.x * (0.4 * f64::from(j) * fibre.outer.0);
                self.high[(at(p.y) * self.n + at(p.x)) as usize]
            };
            (-2..=2).map(point).fold(0.0, f64::max)
        };
        (0..count as i32).map(height).sum::<f64>() / count
    }

    /// Tells the steps `first..=last` of the fibre that must not have its centre below a height.
    pub fn under(&self, fibre: &Fibre, mut tell: impl FnMut(usize, usize, f64)) {
        let (a, b) = fibre.outer;
        let (steps, reach) = (Steps::of(self, fibre), self.reach(fibre));
        self.visit(fibre, |e| {
            let nearest = (e.across.abs() - reach).max(0.0);
            if nearest < a && self.high[e.index] > 0.0 {
                let (first, last) = steps.between(e.along - reach, e.along + reach);
                tell(first, last, self.high[e.index] + b * arch(nearest, a));
            }
        });
    }

    /// The sheet grows by a fibre.
    pub fn raise(&mut self, fibre: &Fibre) {
        let (a, b) = fibre.outer;
        let (steps, reach) = (Steps::of(self, fibre), self.reach(fibre));
        let heights = steps.heights(fibre);
        let mut below = Vec::new();
        self.visit(fibre, |e| below.push(e));
        for e in below {
            let nearest = (e.across.abs() - reach).max(0.0);
            if nearest >= a {
                continue;
            }
            let (first, last) = steps.between(e.along - reach, e.along + reach);
            let centre = heights[first..=last + 1].iter().copied().fold(0.0, f64::max);
            let high = &mut self.high[e.index];
            *high = high.max(centre + b * arch(nearest, a));
            if e.across.abs() < a && e.along.abs() < fibre.half {
                let (k, _) = steps.between(e.along, e.along);
                let x = (e.along + fibre.half) / steps.width - k as f64;
                let centre = heights[k] + x * (heights[k + 1] - heights[k]);
                let arch = b * arch(e.across, a);
                let (surface, under) = (&mut self.surface[e.index], &mut self.under[e.index]);
                *surface = surface.max((centre + arch) as f32);
                *under = under.min((centre - arch) as f32);
            }
        }
    }

    /// Mean height between the lowest and the uppermost surface, µm.
    pub fn thickness(&self) -> f64 {
        let of = |(s, u): (&f32, &f32)| if u.is_finite() { f64::from(*s) - f64::from(*u) } else { 0.0 };
        self.surface.iter().zip(&self.under).map(of).sum::<f64>() / self.surface.len() as f64
    }

    /// Share of the cell over which something lies.
    pub fn covered(&self) -> f64 {
        self.under.iter().filter(|u| u.is_finite()).count() as f64 / self.under.len() as f64
    }

    /// Lowest and uppermost surface over a point of the cell, if something lies there.
    pub fn column(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let at = |x: f64| ((x / self.pitch) as i64).rem_euclid(self.n);
        let index = (at(y) * self.n + at(x)) as usize;
        let under = self.under[index];
        under.is_finite().then(|| (f64::from(under), f64::from(self.surface[index])))
    }
}

/// A fibre's length in equal steps.
struct Steps {
    half: f64,
    width: f64,
    count: usize,
}

impl Steps {
    fn of(ground: &Ground, fibre: &Fibre) -> Self {
        let count = ground.bins(fibre.half);
        Steps { half: fibre.half, width: 2.0 * fibre.half / count as f64, count }
    }

    /// Steps that hold the stretch from `lo` to `hi`.
    fn between(&self, lo: f64, hi: f64) -> (usize, usize) {
        let of = |x: f64| (((x + self.half) / self.width).max(0.0) as usize).min(self.count - 1);
        (of(lo), of(hi))
    }

    /// Heights of the fibre's centre at the ends of all steps.
    fn heights(&self, fibre: &Fibre) -> Vec<f64> {
        let mut heights = Vec::with_capacity(self.count + 1);
        let mut piece = 0;
        for k in 0..=self.count {
            let z = self.width * k as f64 - self.half;
            while piece + 2 < fibre.knots.len() && fibre.knots[piece + 1].0 <= z {
                piece += 1;
            }
            let (p, q) = (fibre.knots[piece], fibre.knots[piece + 1]);
            heights.push(p.1 + (q.1 - p.1) * (z - p.0) / (q.0 - p.0));
        }
        heights
    }
}
