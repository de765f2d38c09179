//! Reflectance of a smooth interface for diffuse light.

use super::Fresnel;
use crate::math::{Sum, gauss_legendre};
use num_complex::Complex64;

/// Reflectance for perfectly diffuse unpolarised light, 2 ∫₀¹ R(µ) µ dµ, from `n1` to `n2`, µ2 = µ1;
/// error ≤ 1e-10.
///
/// With v = µ² it is ∫₀¹ R dv. R has square roots at grazing (v = 0) and at the critical angle
/// (v = −Re(η² − 1)), however close together: the range is cut there and Gauss–Legendre panels halve
/// towards each such end.
pub fn diffuse_reflectance(n1: Complex64, n2: Complex64) -> f64 {
    let d = (n2 - n1) * (n2 + n1) / (n1 * n1);
    let critical = (-d.re).clamp(0.0, 1.0);
    let (panel, last) = (gauss_legendre(16, 0.5, 1.0), gauss_legendre(16, 0.0, 1.0));
    let (panel, last) = (&panel, &last);
    let reflectance = |v: f64| Fresnel::new(n1, n2, 1.0, v.sqrt()).reflectance();
    let pieces = [(0.0, critical), (critical, 1.0)];
    let halves = pieces.iter().flat_map(|&(a, b)| [(a, 0.5 * (b - a)), (b, -0.5 * (b - a))]);
    let sum: Sum = halves
        .filter(|(_, width)| *width != 0.0)
        .flat_map(|(end, width)| (0..=PANELS).map(move |p| (p, end, width / f64::from(1_u32 << p))))
        .flat_map(|(p, end, width)| {
            let rule = if p < PANELS { panel } else { last };
            rule.iter().map(move |&(x, w)| (end + width * x, width.abs() * w))
        })
        .map(|(v, w)| w * reflectance(v))
        .collect();
    sum.value()
}

/// Halvings towards an end; the last panel, 2⁻³⁰ of the range, holds the square root itself.
const PANELS: u32 = 30;
