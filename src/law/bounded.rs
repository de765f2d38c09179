//! Laws on a bounded support with density ∝ x^p (x−lo)^(a−1) (hi−x)^(b−1) exp(−(x−m)²/2s²):
//! truncated normal, beta, and their tilted forms, sampled by exact rejection under a piecewise
//! envelope that is built once.

use super::power::{cumulate, pick, power_integral, power_inverse};
use super::quadrature::RULE;
use crate::math::{Sum, exp, ln};
use crate::rng::Stream;

/// Parameters of the density.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shape {
    lo: f64,
    hi: f64,
    /// Power of x beside those below; 0 when lo = 0 (then in `a`).
    p: f64,
    a: f64,
    b: f64,
    /// Mean and standard deviation of the normal factor.
    normal: Option<(f64, f64)>,
}

/// coefficient × ln(argument), 0 for coefficient 0 whatever the argument.
#[inline]
fn power_term(coefficient: f64, argument: f64) -> f64 {
    if coefficient == 0.0 { 0.0 } else { coefficient * ln(argument.max(0.0)) }
}

impl Shape {
    /// The terms (coefficient, argument at x) of the logarithm of the density.
    fn powers(&self, x: f64) -> [(f64, f64); 3] {
        [(self.p, x), (self.a - 1.0, x - self.lo), (self.b - 1.0, self.hi - x)]
    }
    /// −(x−m)²/2s², less its value at the point of the support nearest to m: for a mean far outside
    /// the squares themselves would cancel.
    #[inline]
    fn normal_term(&self, x: f64) -> f64 {
        self.normal.map_or(0.0, |(m, s)| {
            let nearest = m.clamp(self.lo, self.hi);
            let d = (x - nearest) / s;
            -0.5 * d * (d + 2.0 * (nearest - m) / s)
        })
    }
    /// Concave part of ln density: normal term and powers with positive coefficients.
    fn concave(&self, x: f64) -> f64 {
        self.powers(x).iter().filter(|(c, _)| *c > 0.0).map(|(c, y)| power_term(*c, *y)).sum::<f64>()
            + self.normal_term(x)
    }
    /// Derivative of the concave part, decreasing in x.
    fn concave_slope(&self, x: f64) -> f64 {
        let side = [1.0, 1.0, -1.0];
        let powers = self.powers(x);
        let slope = |i: usize| if powers[i].0 > 0.0 { side[i] * powers[i].0 / powers[i].1 } else { 0.0 };
        (0..3).map(slope).sum::<f64>() - self.normal.map_or(0.0, |(m, s)| (x - m) / (s * s))
    }
    /// Where the concave part is largest.
    fn concave_mode(&self) -> f64 {
        let (mut lo, mut hi) = (self.lo, self.hi);
        for _ in 0..200 {
            let mid = 0.5 * (lo + hi);
            *(if self.concave_slope(mid) > 0.0 { &mut lo } else { &mut hi }) = mid;
        }
        0.5 * (lo + hi)
    }
}

/// A piece of the envelope: x = anchor ± s with proposal density ∝ s^q on [s0, s1], and the largest
/// value `ceiling` of ln(density / s^q) on it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    anchor: f64,
    sign: f64,
    s0: f64,
    s1: f64,
    q: f64,
    ceiling: f64,
}

impl Piece {
    #[inline]
    fn x(&self, s: f64) -> f64 {
        self.anchor + self.sign * s
    }
    /// ln(density / s^q) at s; s itself, not x − anchor, keeps the digits near an end.
    #[inline]
    fn rest(&self, shape: &Shape, s: f64) -> f64 {
        let x = self.x(s);
        let left = if self.sign > 0.0 { s + (self.anchor - shape.lo) } else { x - shape.lo };
        let right = if self.sign > 0.0 { shape.hi - x } else { s + (shape.hi - self.anchor) };
        let (a, b) = if self.q == 0.0 {
            (shape.a - 1.0, shape.b - 1.0)
        } else if self.sign > 0.0 {
            (0.0, shape.b - 1.0)
        } else {
            (shape.a - 1.0, 0.0)
        };
        power_term(shape.p, x) + power_term(a, left) + power_term(b, right) + shape.normal_term(x)
    }
    /// Upper bound of `rest` on the piece: the concave part at its own mode, each other power
    /// (monotone) at its better end.
    fn bound(&self, shape: &Shape, mode: f64) -> f64 {
        let (x0, x1) = (self.x(self.s0), self.x(self.s1));
        let top = mode.clamp(x0.min(x1), x0.max(x1));
        let anchored = if self.q == 0.0 {
            3
        } else if self.sign > 0.0 {
            1
        } else {
            2
        };
        let (e0, e1) = (shape.powers(x0), shape.powers(x1));
        let convex = (0..3).filter(|i| e0[*i].0 < 0.0 && *i != anchored);
        shape.concave(top)
            + convex.map(|i| power_term(e0[i].0, e0[i].1).max(power_term(e1[i].0, e1[i].1))).sum::<f64>()
    }
    fn ln_mass(&self) -> f64 {
        self.ceiling + ln(power_integral(self.s0, self.s1, self.q))
    }
    /// Quadrature points (s, weight) of s^q exp(rest − reference) on [s0, s1]: Gauss–Legendre, toward
    /// a singular end in ever smaller octaves until what remains is a pure power.
    fn points(&self, shape: &Shape, s0: f64, s1: f64, reference: f64) -> Vec<(f64, f64)> {
        let density = |s: f64| exp(self.rest(shape, s) + power_term(self.q, s) - reference);
        let mut points = Vec::with_capacity(RULE.len());
        let mut top = s1;
        for _ in 0..60 {
            let bottom = if self.q == 0.0 { s0 } else { s0.max(0.5 * top) };
            points.extend(RULE.iter().map(|(v, w)| {
                let s = bottom + (top - bottom) * v;
                (s, w * (top - bottom) * density(s))
            }));
            top = bottom;
            if top <= s0 {
                return points;
            }
        }
        let s = power_inverse(s0, top, self.q, 0.5);
        points.push((s, power_integral(s0, top, self.q) * exp(self.rest(shape, s) - reference)));
        points
    }
    /// ∫ s^q exp(rest − reference) ds over [s0, s1].
    fn integral(&self, shape: &Shape, s0: f64, s1: f64, reference: f64) -> f64 {
        self.points(shape, s0, s1, reference).into_iter().map(|(_, w)| w).collect::<Sum>().value()
    }
}

/// The law: shape, envelope and masses.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounded {
    shape: Shape,
    pieces: Vec<Piece>,
    /// Cumulative proposal masses, normalised.
    proposal: Vec<f64>,
    /// Cumulative true masses, normalised.
    cumulative: Vec<f64>,
    /// ln of the largest ceiling: scale of the masses.
    reference: f64,
    /// ∫ density · exp(−reference).
    total: f64,
}

impl Bounded {
    pub(super) fn truncated_normal(mean: f64, sd: f64, lo: f64, hi: f64) -> Self {
        Self::new(Shape { lo, hi, p: 0.0, a: 1.0, b: 1.0, normal: Some((mean, sd)) })
    }
    pub(super) fn beta(a: f64, b: f64, lo: f64, hi: f64) -> Self {
        Self::new(Shape { lo, hi, p: 0.0, a, b, normal: None })
    }

    fn new(shape: Shape) -> Self {
        let mode = shape.concave_mode();
        let pieces = envelope(&shape, mode);
        let reference = pieces.iter().map(|p| p.ceiling).fold(f64::NEG_INFINITY, f64::max);
        let upper: Vec<f64> = pieces.iter().map(|p| exp(p.ln_mass() - reference)).collect();
        let masses: Vec<f64> = pieces.iter().map(|p| p.integral(&shape, p.s0, p.s1, reference)).collect();
        let (proposal, _) = cumulate(&upper);
        let (cumulative, total) = cumulate(&masses);
        Bounded { shape, pieces, proposal, cumulative, reference, total }
    }

    pub(super) fn lower(&self) -> f64 {
        self.shape.lo
    }
    pub(super) fn upper(&self) -> f64 {
        self.shape.hi
    }
    pub(super) fn can_tilt(&self, p: f64) -> bool {
        self.shape.lo > 0.0 || self.shape.a + p > 0.0
    }
    pub(super) fn tilted(&self, p: f64) -> Self {
        let mut shape = self.shape;
        *(if shape.lo == 0.0 { &mut shape.a } else { &mut shape.p }) += p;
        Self::new(shape)
    }
    /// E[x^p] = ∫ x^p f / ∫ f: the norm of the tilted law over the norm of this one.
    pub(super) fn moment(&self, p: f64) -> f64 {
        let t = self.tilted(p);
        exp(t.reference - self.reference) * t.total / self.total
    }

    fn find(&self, x: f64) -> usize {
        let end = |p: &Piece| if p.sign > 0.0 { p.x(p.s1) } else { p.x(p.s0) };
        self.pieces.partition_point(|p| end(p) < x).min(self.pieces.len() - 1)
    }
    pub(super) fn pdf(&self, x: f64) -> f64 {
        if !(self.shape.lo..=self.shape.hi).contains(&x) {
            return 0.0;
        }
        let piece = &self.pieces[self.find(x)];
        let s = (x - piece.anchor) * piece.sign;
        exp(piece.rest(&self.shape, s) + power_term(piece.q, s) - self.reference) / self.total
    }
    pub(super) fn cdf(&self, x: f64) -> f64 {
        if x <= self.shape.lo {
            return 0.0;
        }
        if x >= self.shape.hi {
            return 1.0;
        }
        let i = self.find(x);
        let piece = &self.pieces[i];
        let s = ((x - piece.anchor) * piece.sign).clamp(piece.s0, piece.s1);
        let part = |s0, s1| piece.integral(&self.shape, s0, s1, self.reference) / self.total;
        if piece.sign > 0.0 {
            (if i == 0 { 0.0 } else { self.cumulative[i - 1] }) + part(piece.s0, s)
        } else {
            self.cumulative[i] - part(piece.s0, s)
        }
    }

    pub(super) fn sample(&self, stream: &mut Stream) -> f64 {
        loop {
            let piece = &self.pieces[pick(&self.proposal, stream.uniform_positive())];
            let s = power_inverse(piece.s0, piece.s1, piece.q, stream.uniform_positive());
            if -stream.exponential() <= piece.rest(&self.shape, s) - piece.ceiling {
                let x = piece.x(s).clamp(self.shape.lo, self.shape.hi);
                return x.max(f64::MIN_POSITIVE);
            }
        }
    }

    /// The law as many weighted points, for Gauss quadrature.
    pub(super) fn points(&self) -> Vec<(f64, f64)> {
        let of_piece = |p: &Piece| -> Vec<(f64, f64)> {
            let points = p.points(&self.shape, p.s0, p.s1, self.reference).into_iter();
            points.map(|(s, w)| (p.x(s), w / self.total)).collect()
        };
        self.pieces.iter().flat_map(of_piece).collect()
    }
}

/// Splits the support until every piece that matters (more than 1e-18 of the whole) varies by less
/// than a factor 2 under its ceiling, in ascending order of x.
fn envelope(shape: &Shape, mode: f64) -> Vec<Piece> {
    let (lo, hi) = (shape.lo, shape.hi);
    let finish = |mut piece: Piece| {
        piece.ceiling = piece.bound(shape, mode);
        piece
    };
    let from = |anchor: f64, sign: f64, s0: f64, s1: f64, exponent: f64| {
        finish(Piece { anchor, sign, s0, s1, q: exponent.min(0.0), ceiling: 0.0 })
    };
    let mid =
        if mode > lo + 1e-9 * (hi - lo) && mode < hi - 1e-9 * (hi - lo) { mode } else { 0.5 * (lo + hi) };
    let left = from(lo, 1.0, 0.0, mid - lo, shape.a - 1.0);
    // Counting from a far upper end would cost digits of x: only where that end is singular.
    let right = if shape.b < 1.0 {
        from(hi, -1.0, 0.0, hi - mid, shape.b - 1.0)
    } else {
        from(mid, 1.0, 0.0, hi - mid, 0.0)
    };
    let mut pieces = vec![left, right];
    for _ in 0..200 {
        let masses: Vec<f64> = pieces.iter().map(Piece::ln_mass).collect();
        let top = masses.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let total = top + ln(masses.iter().map(|m| exp(m - top)).sum::<f64>());
        let (mut next, mut split) = (Vec::with_capacity(2 * pieces.len()), false);
        for (p, ln_mass) in pieces.iter().zip(&masses) {
            let floor = p.rest(shape, p.s0).min(p.rest(shape, p.s1));
            let half = 0.5 * (p.s0 + p.s1);
            let divisible = half > p.s0 && half < p.s1;
            if p.ceiling - floor > 0.69 && ln_mass - total > -41.4 && divisible {
                let mut halves = [finish(Piece { s1: half, ..*p }), finish(Piece { s0: half, ..*p })];
                if p.sign < 0.0 {
                    halves.swap(0, 1);
                }
                next.extend(halves);
                split = true;
            } else {
                next.push(*p);
            }
        }
        pieces = next;
        if !split {
            break;
        }
    }
    pieces
}
