//! Populating a SAP: the share of each patch from a density over directions.

use super::healpix::{Half, Healpix};
use super::patch::Triangle;
use crate::math::{DVec3, Sum, gauss_legendre};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::LazyLock;

/// Shares of all patches.
#[derive(Clone, Debug, PartialEq)]
pub struct Population {
    /// Share of each patch in RING order.
    pub shares: Vec<f64>,
    /// `exact`: ∫ density, the sum of the shares (for a surface its directional albedo).
    /// `centre`: the raw sum before the shares were renormalised to 1.
    pub sum: f64,
    /// `exact`: bound on the quadrature error of the worst patch, as estimated. `centre`: NaN.
    pub error: f64,
}

/// Where a density is narrow: direction and the angle (rad) over which it changes by a factor of
/// order 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Direction of the peak (unit).
    pub direction: DVec3,
    /// Its angular width.
    pub width: f64,
}

/// Share of each patch = ∫ density dω over the patch (over its part in `half`, if given), by
/// hierarchical subdivision until each patch is known within `tol` (absolute: a density integrates
/// to about 1; the error estimate is that of a lower order, the true error usually a thousandth).
///
/// The shares are **not** renormalised. `density` is per steradian. A peak narrower than about a
/// twentieth of a patch can be missed by all first nodes: use [`populate_exact_peaks`] for it. A
/// density with a jump inside a patch stops at 4096 cells per patch; `error` then tells.
pub fn populate_exact(
    hp: &Healpix,
    density: &dyn Fn(DVec3) -> f64,
    half: Option<Half>,
    tol: f64,
) -> Population {
    populate_exact_peaks(hp, density, half, tol, &[])
}

/// [`populate_exact`] for densities with narrow peaks: cells near a peak are first subdivided to
/// the peak's width, so that no width down to 1e-8 is missed.
pub fn populate_exact_peaks(
    hp: &Healpix,
    density: &dyn Fn(DVec3) -> f64,
    half: Option<Half>,
    tol: f64,
    peaks: &[Peak],
) -> Population {
    let (mut shares, mut error) = (Vec::with_capacity(hp.npix()), 0.0_f64);
    let scale = 0.5 * hp.area();
    for pix in 0..hp.npix() {
        let mut sum = Integral { density, scale, heap: BinaryHeap::new(), error: 0.0 };
        for t in hp.triangles(pix).into_iter().filter(|t| half.is_none_or(|h| t.half == h)) {
            sum.start(&t, [0.0, 1.0], [-1.0, 1.0], peaks);
        }
        shares.push(sum.refine(tol));
        error = error.max(sum.error);
    }
    let sum = shares.iter().copied().collect::<Sum>().value();
    Population { shares, sum, error }
}

/// Share of each patch = density at its centre × area, renormalised to 1 (the paper's way; the raw
/// sum is returned and shows how far off it is). Patches cut by the horizon use the mean direction
/// and the area of their visible part. Where the density is 0 at every centre the shares stay 0.
pub fn populate_centre(hp: &Healpix, density: &dyn Fn(DVec3) -> f64, half: Option<Half>) -> Population {
    let mut shares: Vec<f64> = (0..hp.npix())
        .map(|pix| match hp.share_in(pix, half) {
            0.0 => 0.0,
            part => density(hp.representative(pix, half)) * hp.area() * part,
        })
        .collect();
    let sum = shares.iter().copied().collect::<Sum>().value();
    if sum > 0.0 {
        shares.iter_mut().for_each(|s| *s /= sum);
    }
    Population { shares, sum, error: f64::NAN }
}

/// Most cells per patch.
const MOST_CELLS: usize = 4096;
/// Depth to which a peak forces subdivision: 2⁻³⁰ of a patch.
const PEAK_DEPTH: u32 = 30;

/// A rectangle of a triangle's (s, v) coordinates with its integral and error estimate.
struct Cell {
    triangle: Triangle,
    s: [f64; 2],
    v: [f64; 2],
    value: f64,
    error: f64,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Cell {}
impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error)
    }
}

/// Adaptive integral over one patch.
struct Integral<'a> {
    density: &'a dyn Fn(DVec3) -> f64,
    /// Half the area of the patch.
    scale: f64,
    heap: BinaryHeap<Cell>,
    error: f64,
}

impl Integral<'_> {
    /// Adds a cell, subdivided first while it is wider than a peak and its distance from it.
    fn start(&mut self, t: &Triangle, s: [f64; 2], v: [f64; 2], peaks: &[Peak]) {
        self.start_at(t, s, v, peaks, PEAK_DEPTH);
    }

    fn start_at(&mut self, t: &Triangle, s: [f64; 2], v: [f64; 2], peaks: &[Peak], depth: u32) {
        if depth > 0 && peaks.iter().any(|p| too_wide(t, s, v, p)) {
            for (s, v) in quarters(s, v) {
                self.start_at(t, s, v, peaks, depth - 1);
            }
        } else {
            self.add(t, s, v);
        }
    }

    fn add(&mut self, t: &Triangle, s: [f64; 2], v: [f64; 2]) {
        let (value, error) = self.gauss(t, s, v);
        self.error += error;
        self.heap.push(Cell { triangle: *t, s, v, value, error });
    }

    /// Gauss quadrature of 7 × 7 points, and its difference from 4 × 4.
    fn gauss(&self, t: &Triangle, s: [f64; 2], v: [f64; 2]) -> (f64, f64) {
        static FINE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(7, 0.0, 1.0));
        static COARSE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(4, 0.0, 1.0));
        let by = |rule: &[(f64, f64)]| {
            let mut sum = 0.0;
            for &(a, wa) in rule {
                let at = s[0] + (s[1] - s[0]) * a;
                let row = t.row(at);
                let across =
                    rule.iter().map(|&(b, wb)| wb * (self.density)(row.direction(v[0] + (v[1] - v[0]) * b)));
                sum += wa * at * across.sum::<f64>();
            }
            sum * (s[1] - s[0]) * (v[1] - v[0]) * self.scale
        };
        let fine = by(&FINE);
        (fine, (fine - by(&COARSE)).abs())
    }

    /// Subdivides the worst cell until the sum of the errors is below `tol`; the integral.
    fn refine(&mut self, tol: f64) -> f64 {
        while self.error > tol && self.heap.len() < MOST_CELLS {
            let Some(worst) = self.heap.pop() else { break };
            if worst.error <= 4.0 * f64::EPSILON * worst.value.abs() {
                self.heap.push(worst); // rounding: nothing to gain
                break;
            }
            self.error -= worst.error;
            for (s, v) in quarters(worst.s, worst.v) {
                self.add(&worst.triangle, s, v);
            }
        }
        self.error = self.heap.iter().map(|c| c.error).sum();
        self.heap.iter().map(|c| c.value).collect::<Sum>().value()
    }
}

fn quarters(s: [f64; 2], v: [f64; 2]) -> [([f64; 2], [f64; 2]); 4] {
    let (sm, vm) = (0.5 * (s[0] + s[1]), 0.5 * (v[0] + v[1]));
    [([s[0], sm], [v[0], vm]), ([s[0], sm], [vm, v[1]]), ([sm, s[1]], [v[0], vm]), ([sm, s[1]], [vm, v[1]])]
}

/// Is the cell wider than the peak, and nearer to it than its own width?
fn too_wide(t: &Triangle, s: [f64; 2], v: [f64; 2], peak: &Peak) -> bool {
    let middle = t.row(0.5 * (s[0] + s[1])).direction(0.5 * (v[0] + v[1]));
    let mut radius = 0.0_f64;
    for at in s {
        let row = t.row(at);
        for across in v {
            radius = radius.max((row.direction(across) - middle).length());
        }
    }
    radius > peak.width && (peak.direction - middle).length() < 2.0 * radius
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{PI, exp};

    /// A cap of half angle 1e-3, Gaussian in the chord: ∫ = 1 − e^(−4/w²) = 1, and only the hint
    /// makes it visible at nside 1.
    #[test]
    fn a_needle_is_found_by_its_hint() {
        let hp = Healpix::new(1).unwrap();
        let axis = DVec3::new(0.3, -0.5, 0.8).normalize();
        let width: f64 = 1e-4;
        let density = |u: DVec3| exp(-(u - axis).length_squared() / (width * width)) / (PI * width * width);
        let peak = Peak { direction: axis, width };
        let found = populate_exact_peaks(&hp, &density, None, 1e-10, &[peak]);
        assert!((found.sum - 1.0).abs() < 1e-10 && found.error <= 1e-10, "{} {}", found.sum, found.error);
        let missed = populate_exact(&hp, &density, None, 1e-10);
        assert!(missed.sum < 0.5, "without the hint it is missed: {}", missed.sum);
    }

    /// ∫ z over the upper half = π, and over each cut patch exactly; nothing from the lower half.
    #[test]
    fn the_horizon_is_exact() {
        for nside in [1, 2, 3, 5, 8] {
            let hp = Healpix::new(nside).unwrap();
            let p = populate_exact(&hp, &|u| u.z / PI, Some(Half::Upper), 1e-12);
            assert!((p.sum - 1.0).abs() < 1e-13, "{}", p.sum);
            for (pix, share) in p.shares.iter().enumerate() {
                assert_eq!(hp.share_in(pix, Some(Half::Upper)) == 0.0, *share == 0.0);
                let mean = hp.mean_vector(pix, Some(Half::Upper));
                let area = hp.area() * hp.share_in(pix, Some(Half::Upper));
                assert!((share - mean.z * area / PI).abs() < 1e-14);
            }
        }
    }

    /// A jump inside patches (a cone of half angle 0.5 about a skew axis) is honest about its error.
    #[test]
    fn a_jump_reports_its_error() {
        let hp = Healpix::new(1).unwrap();
        let axis = DVec3::new(0.3, -0.5, 0.8).normalize();
        let cos = crate::math::cos(0.5);
        let density = |u: DVec3| if u.dot(axis) > cos { 1.0 / (2.0 * PI * (1.0 - cos)) } else { 0.0 };
        let p = populate_exact(&hp, &density, None, 1e-10);
        assert!(p.error > 1e-10 && (p.sum - 1.0).abs() < 12.0 * p.error, "{} {}", p.sum, p.error);
        assert!((p.sum - 1.0).abs() < 1e-4, "{}", p.sum);
    }
}
