//! Gauss quadrature for the weight of any law (Golub & Welsch 1969, doi:10.1090/S0025-5718-69-99647-1;
//! recurrence from a fine discretisation by Stieltjes' procedure, Gautschi 2004).

use crate::math::{Sum, gauss_legendre};
use std::sync::LazyLock;

/// Gauss–Legendre rule of 16 points on [0, 1].
pub(super) static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(16, 0.0, 1.0));

/// Gauss–Hermite rule of n points: averages over a standard normal variate.
pub(super) fn hermite(n: usize) -> Vec<(f64, f64)> {
    let off: Vec<f64> = (1..n).map(|k| (k as f64).sqrt()).collect();
    golub_welsch(vec![0.0; n], off)
}

/// Gauss rule of n points for the discrete measure of many weighted points: exact for polynomials
/// up to degree 2n − 1. Weights sum to 1.
pub(super) fn gauss(points: &[(f64, f64)], n: usize) -> Vec<(f64, f64)> {
    // Points without weight far from the others would only make the polynomials overflow.
    let heaviest = points.iter().map(|(_, w)| *w).fold(0.0, f64::max);
    let points: Vec<(f64, f64)> = points.iter().copied().filter(|(_, w)| *w > 1e-300 * heaviest).collect();
    let mean = |f: &dyn Fn(usize) -> f64| -> f64 {
        points.iter().enumerate().map(|(j, (_, w))| w * f(j)).collect::<Sum>().value()
    };
    let total = mean(&|_| 1.0);
    let (mut last, mut now) = (vec![0.0; points.len()], vec![1.0 / total.sqrt(); points.len()]);
    let (mut diagonal, mut off) = (Vec::new(), Vec::new());
    let mut beta = 0.0;
    for k in 0..n.min(points.len()) {
        let alpha = mean(&|j| points[j].0 * now[j] * now[j]);
        diagonal.push(alpha);
        for j in 0..points.len() {
            let next = (points[j].0 - alpha) * now[j] - beta * last[j];
            last[j] = now[j];
            now[j] = next;
        }
        beta = mean(&|j| now[j] * now[j]).sqrt();
        if k + 1 == n.min(points.len()) || beta <= 1e-14 * alpha.abs() {
            break;
        }
        off.push(beta);
        now.iter_mut().for_each(|v| *v /= beta);
    }
    golub_welsch(diagonal, off)
}

/// Nodes and weights from the symmetric tridiagonal (Jacobi) matrix, by QL with implicit shifts.
fn golub_welsch(mut d: Vec<f64>, mut e: Vec<f64>) -> Vec<(f64, f64)> {
    let n = d.len();
    e.resize(n, 0.0);
    let mut z = vec![0.0; n];
    z[0] = 1.0;
    for l in 0..n {
        for _ in 0..200 {
            let m = (l..n - 1)
                .find(|m| e[*m].abs() <= f64::EPSILON * (d[*m].abs() + d[*m + 1].abs()))
                .unwrap_or(n - 1);
            if m == l {
                break;
            }
            let mut g = (d[l + 1] - d[l]) / (2.0 * e[l]);
            let mut r = (g * g + 1.0).sqrt();
            g = d[m] - d[l] + e[l] / (g + r.copysign(g));
            let (mut s, mut c, mut p) = (1.0, 1.0, 0.0);
            for i in (l..m).rev() {
                let (f, b) = (s * e[i], c * e[i]);
                r = (f * f + g * g).sqrt();
                e[i + 1] = r;
                s = f / r;
                c = g / r;
                g = d[i + 1] - p;
                r = (d[i] - g) * s + 2.0 * c * b;
                p = s * r;
                d[i + 1] = g + p;
                g = c * r - b;
                let f = z[i + 1];
                z[i + 1] = s * z[i] + c * f;
                z[i] = c * z[i] - s * f;
            }
            d[l] -= p;
            e[l] = g;
            e[m] = 0.0;
        }
    }
    let mut nodes: Vec<(f64, f64)> = d.iter().zip(&z).map(|(x, z)| (*x, z * z)).collect();
    nodes.sort_by(|a, b| a.0.total_cmp(&b.0));
    nodes
}
