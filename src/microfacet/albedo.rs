//! Directional albedo of the single bounce, by quadrature in slope space, and its table.
//!
//! E(i) = ∫ D_v(h; i) (G2/G1(i)) F dωh = (1/σ) ∫∫ P22(ζ) ζ (c + sζ cosφ) w(o) F dζ dφ over the facets
//! whose reflection leaves the surface: 0 < ζ < ζ⁺(φ), ζ⁺ = tanθ cosφ + √(tan²θ cos²φ + 1). Both
//! integrals by Gauss–Legendre rules that are graded where the integrand has layers: at cosφ = 0 (grazing
//! incidence) and at the far end of ζ (grazing exit, the tail of GGX).

use super::chebyshev::Series;
use super::{Masking, Microfacet, Slopes, sine};
use crate::math::{PI, gauss_legendre, ln, sin, sinh};
use std::sync::LazyLock;

/// Node of a rule on (0, 1): x, 1 − x and weight.
struct Node {
    x: f64,
    rest: f64,
    weight: f64,
}

/// Gauss–Legendre rule of order `n` in u, 1 − x = uᵖ: graded towards x = 1.
fn graded(n: usize, p: i32) -> Vec<Node> {
    let node = |(u, w): (f64, f64)| {
        let slope = (1..p).fold(1.0, |power, _| power * u);
        let rest = slope * u;
        Node { x: 1.0 - rest, rest, weight: f64::from(p) * slope * w }
    };
    gauss_legendre(n, 0.0, 1.0).into_iter().map(node).collect()
}

/// Nodes of the double integral.
pub(super) struct Rule {
    /// For laws that fall exponentially.
    short: Vec<Node>,
    /// For the algebraic tail of GGX.
    long: Vec<Node>,
    /// (|cosφ|, weight) of a quarter turn, graded towards cosφ = 0.
    azimuth: Vec<(f64, f64)>,
}

impl Rule {
    fn new(radial: usize, azimuthal: usize, p: i32) -> Self {
        let quarter = |n: Node| (sin(0.5 * PI * n.rest), 0.5 * PI * n.weight);
        Rule {
            short: graded(radial, 2),
            long: graded(radial, 8),
            azimuth: graded(azimuthal, p).into_iter().map(quarter).collect(),
        }
    }
}

/// For single values: error below 1e-9 up to m = 1, 4e-7 at m = 2.
pub(super) static FINE: LazyLock<Rule> = LazyLock::new(|| Rule::new(96, 64, 4));
/// For the table: error below 2e-7 up to m = 1, 1e-6 at m = 2.
static COARSE: LazyLock<Rule> = LazyLock::new(|| Rule::new(40, 24, 3));

/// Albedo with separable and with correlated masking.
pub(super) fn quadrature(
    surface: &Microfacet,
    rule: &Rule,
    cos: f64,
    reflectance: impl Fn(f64) -> f64,
) -> [f64; 2] {
    let sin = sine(cos);
    let area = surface.projected_area(cos);
    let radial = if surface.law == Slopes::Ggx { &rule.long } else { &rule.short };
    let mut total = [0.0; 2];
    for &(cosine, w_phi) in &rule.azimuth {
        for s_cos in [sin * cosine, -sin * cosine] {
            let reach = reach(cos, s_cos);
            let mut ray = [0.0; 2];
            for node in radial {
                let (zeta, mass) = slope_at(surface, reach, node);
                let norm2 = 1.0 + zeta * zeta;
                // i·h √(1 + ζ²)
                let facing = cos + s_cos * zeta;
                let cos_o = (2.0 * facing / norm2 - cos).clamp(0.0, 1.0);
                if mass == 0.0 || facing <= 0.0 || cos_o == 0.0 {
                    continue;
                }
                let hidden = surface.hidden_area(cos_o, sine(cos_o));
                let light = mass * facing * reflectance(facing / norm2.sqrt());
                let seen = area * cos_o;
                ray[0] += light * cos_o / (cos_o + hidden);
                ray[1] += light * seen / (seen + cos * hidden);
            }
            total[0] += w_phi * ray[0];
            total[1] += w_phi * ray[1];
        }
    }
    // The other half turn is the mirror image.
    total.map(|x| 2.0 * x / area)
}

/// Largest slope ζ⁺ that still reflects out of the surface: positive root of
/// c ζ² − 2 s cosφ ζ − c = 0 (the other is −1/ζ⁺).
fn reach(c: f64, s_cos: f64) -> f64 {
    let far = s_cos.abs() + (s_cos * s_cos + c * c).sqrt();
    if s_cos >= 0.0 { far / c } else { c / far }
}

/// Slope at a node and P22(ζ) ζ dζ there. ζ = κ v/√(1 − v²) with κ near the width of the law spreads
/// the mass over v and leaves the algebraic tail of GGX (κ = m: P22 ζ dζ = v dv/π) without singularity.
fn slope_at(surface: &Microfacet, reach: f64, node: &Node) -> (f64, f64) {
    let k = surface.m
        * match surface.law {
            Slopes::Gaussian => 1.5,
            Slopes::Exponential => 1.3,
            Slopes::Ggx => 1.0,
        };
    // End of v and its distance from 1, without cancellation.
    let (end, beyond) = if reach.is_finite() {
        let r = (k * k + reach * reach).sqrt();
        (reach / r, k * k / (r * (r + reach)))
    } else {
        (1.0, 0.0)
    };
    let v = end * node.x;
    let q = (beyond + end * node.rest) * (1.0 + v);
    let zeta = k * v / q.sqrt();
    (zeta, surface.slope_density(zeta) * k * k * v / (q * q) * end * node.weight)
}

/// Number of nodes of a piece.
const ORDER: usize = 9;
/// Bound of the last terms of a piece; the error is smaller still.
const TOLERANCE: f64 = 2e-7;

/// White albedo over the incidence, piecewise in y = asinh(cosθ/m).
#[derive(Clone, Debug)]
pub(super) struct Table {
    m: f64,
    /// (end of the piece in y, half its width, separable, correlated), ascending.
    pieces: Vec<(f64, f64, [Series<ORDER>; 2])>,
}

impl Table {
    /// Bisects [0, asinh(1/m)] until each piece is as smooth as asked.
    pub(super) fn new(surface: &Microfacet) -> Self {
        let m = surface.m;
        let mut pieces = Vec::new();
        let mut open = vec![(0.0, asinh(1.0 / m), 0)];
        while let Some((a, b, depth)) = open.pop() {
            let (mid, half) = (0.5 * (a + b), 0.5 * (b - a));
            let at = |t: f64| quadrature(surface, &COARSE, (m * sinh(mid + half * t)).min(1.0), |_| 1.0);
            let values = Series::<ORDER>::nodes().map(at);
            let fit = [values.map(|v| v[0]), values.map(|v| v[1])].map(Series::through);
            if depth < 8 && fit.iter().any(|s| s.tail() > TOLERANCE) {
                open.push((mid, b, depth + 1));
                open.push((a, mid, depth + 1));
            } else {
                pieces.push((b, half, fit));
            }
        }
        Table { m, pieces }
    }

    /// Interpolated albedo.
    pub(super) fn value(&self, cos: f64, masking: Masking) -> f64 {
        let y = asinh(cos.clamp(0.0, 1.0) / self.m);
        let k = self.pieces.partition_point(|p| p.0 < y).min(self.pieces.len() - 1);
        let (end, half, fit) = &self.pieces[k];
        fit[usize::from(masking == Masking::Correlated)].value(1.0 + (y - end) / half)
    }
}

/// Inverse hyperbolic sine for x ≥ 0.
fn asinh(x: f64) -> f64 {
    ln(x + (1.0 + x * x).sqrt())
}
