//! Directional albedo of the single bounce, by quadrature in slope space, and its table.
//!
//! E(i) = ∫ D_v(h; i) (G2/G1(i)) F dωh = (1/σ) ∫∫ P22(ζ) ζ (c + sζ cosφ) w(o) F dζ dφ over the facets
//! whose reflection leaves the surface: 0 < ζ < ζ⁺(φ), ζ⁺ = tanθ cosφ + √(tan²θ cos²φ + 1). Both
//! integrals by the double-exponential rule, which resolves layers at the ends (cosφ = 0 at grazing
//! incidence, the tail of GGX, grazing exits).

use super::chebyshev::Series;
use super::{FRAC_1_PI, Masking, Microfacet, Slopes, sine};
use crate::math::{PI, cosh, exp, ln, sin, sinh};
use std::sync::LazyLock;

/// Node of a rule on (0, 1): x, 1 − x and weight.
struct Node {
    x: f64,
    rest: f64,
    weight: f64,
}

/// Double-exponential rule on (0, 1): x = 1/(1 + exp(−π sinh t)), t = kh (Takahasi & Mori 1974).
fn double_exponential(h: f64) -> Vec<Node> {
    let n = (3.1 / h) as i32;
    (-n..=n)
        .map(|k| {
            let t = h * f64::from(k);
            let e = exp(-PI * sinh(t));
            let (x, rest) = (1.0 / (1.0 + e), e / (1.0 + e));
            Node { x, rest, weight: h * PI * cosh(t) * x * rest }
        })
        .collect()
}

static RADIAL: LazyLock<Vec<Node>> = LazyLock::new(|| double_exponential(0.125));
/// (|cosφ|, weight): distances from φ = π/2, where the region changes fast at grazing incidence.
static AZIMUTHAL: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| {
    let node = |n: Node| (sin(0.5 * PI * n.x), 0.5 * PI * n.weight);
    double_exponential(0.18).into_iter().map(node).collect()
});

/// Albedo with separable and with correlated masking.
pub(super) fn quadrature(surface: &Microfacet, cos: f64, reflectance: impl Fn(f64) -> f64) -> [f64; 2] {
    let sin = sine(cos);
    let area = surface.projected_area(cos);
    let mut total = [0.0; 2];
    for &(cosine, w_phi) in AZIMUTHAL.iter() {
        for s_cos in [sin * cosine, -sin * cosine] {
            let reach = reach(cos, s_cos);
            let mut ray = [0.0; 2];
            for node in RADIAL.iter() {
                let (zeta, mass) = radial(surface, reach, node);
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

/// Slope at a node and P22(ζ) ζ dζ there; the variable is chosen per law so that the mass is spread out.
fn radial(surface: &Microfacet, reach: f64, node: &Node) -> (f64, f64) {
    let m = surface.m;
    match surface.law {
        Slopes::Gaussian => {
            let end = (reach / m).min(6.2);
            let y = end * node.x;
            (m * y, FRAC_1_PI * exp(-y * y) * y * end * node.weight)
        }
        Slopes::Exponential => {
            let b = m / 6.0_f64.sqrt();
            let end = (reach / b).min(42.0);
            let y = end * node.x;
            (b * y, 0.5 * FRAC_1_PI * exp(-y) * y * end * node.weight)
        }
        Slopes::Ggx => {
            // ζ = m v/√(1 − v²): P22 ζ dζ = v dv/π.
            let (end, beyond) = if reach.is_finite() {
                let r = (m * m + reach * reach).sqrt();
                (reach / r, m * m / (r * (r + reach)))
            } else {
                (1.0, 0.0)
            };
            let (v, rest) = (end * node.x, beyond + end * node.rest);
            (m * v / (rest * (1.0 + v)).sqrt(), FRAC_1_PI * v * end * node.weight)
        }
    }
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
            let at = |t: f64| quadrature(surface, (m * sinh(mid + half * t)).min(1.0), |_| 1.0);
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
