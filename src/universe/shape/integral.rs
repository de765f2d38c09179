//! Elliptic integrals for perimeters and surfaces, to rounding.

use crate::math::PI;

/// Perimeter of an ellipse with half axes `a`, `b` > 0, µm: 2π N(a², b²)/M(a, b) with the
/// arithmetic–geometric mean M and the modified one N (Adlaj, Notices AMS 59, 2012, 1094).
/// Relative error ~1e-15 for b/a down to 1e-9.
pub fn ellipse_perimeter(a: f64, b: f64) -> f64 {
    let long = a.max(b);
    let beta = a.min(b) / long;
    let (mut m, mut g) = (1.0, beta);
    let (mut x, mut y, mut z) = (1.0, beta * beta, 0.0);
    // Quadratic convergence: the mean of two numbers 1e-8 apart is right to 1e-17. No step more,
    // for |z| doubles with each.
    while (m - g).abs() > 1e-8 || (x - y).abs() > 1e-8 {
        (m, g) = (0.5 * (m + g), (m * g).sqrt());
        let r = ((x - z) * (y - z)).sqrt();
        (x, y, z) = (0.5 * (x + y), z + r, z - r);
    }
    2.0 * PI * long * (0.5 * (x + y)) / (0.5 * (m + g))
}

/// Carlson's R_F(x, y, z) and R_D(x, y, z) by duplication (Carlson, Numer. Algorithms 10, 1995, 13),
/// truncation below 1e-17.
fn carlson_rf_rd(x: f64, y: f64, z: f64) -> (f64, f64) {
    let (mut x, mut y, mut z) = (x, y, z);
    let (mut sum, mut scale) = (0.0, 1.0);
    for _ in 0..200 {
        let mean = (x + y + z) / 3.0;
        let spread = (1.0 - x / mean).abs().max((1.0 - y / mean).abs()).max((1.0 - z / mean).abs());
        if spread < 1e-3 {
            break;
        }
        let (sx, sy, sz) = (x.sqrt(), y.sqrt(), z.sqrt());
        let lambda = sx * sy + sx * sz + sy * sz;
        sum += scale / (sz * (z + lambda));
        scale *= 0.25;
        (x, y, z) = (0.25 * (x + lambda), 0.25 * (y + lambda), 0.25 * (z + lambda));
    }
    let mean = (x + y + z) / 3.0;
    let (dx, dy) = (1.0 - x / mean, 1.0 - y / mean);
    let dz = -dx - dy;
    let (e2, e3) = (dx * dy - dz * dz, dx * dy * dz);
    let rf = (1.0 - e2 / 10.0 + e3 / 14.0 + e2 * e2 / 24.0 - 3.0 * e2 * e3 / 44.0) / mean.sqrt();

    let mean = (x + y + 3.0 * z) / 5.0;
    let (dx, dy) = (1.0 - x / mean, 1.0 - y / mean);
    let dz = -(dx + dy) / 3.0;
    let (xy, zz) = (dx * dy, dz * dz);
    let (e2, e3) = (xy - 6.0 * zz, (3.0 * xy - 8.0 * zz) * dz);
    let (e4, e5) = (3.0 * (xy - zz) * zz, xy * zz * dz);
    let series =
        1.0 - 3.0 / 14.0 * e2 + e3 / 6.0 + 9.0 / 88.0 * e2 * e2 - 3.0 / 22.0 * e4 - 9.0 / 52.0 * e2 * e3
            + 3.0 / 26.0 * e5;
    (rf, 3.0 * sum + scale * series / (mean * mean.sqrt()))
}

/// Carlson's R_G(x, y, z), all arguments > 0 (DLMF 19.21.10):
/// 2 R_G = z R_F − (x − z)(y − z) R_D/3 + √(xy/z), with z the middle argument, so that no term
/// cancels.
pub fn carlson_rg(x: f64, y: f64, z: f64) -> f64 {
    let mut v = [x, y, z];
    v.sort_by(f64::total_cmp);
    let [x, z, y] = v;
    let (rf, rd) = carlson_rf_rd(x, y, z);
    0.5 * (z * rf - (x - z) * (y - z) * rd / 3.0 + (x * y / z).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{gauss_legendre, sin_cos};

    #[test]
    fn perimeter_against_quadrature_and_limits() {
        for (a, b) in [(1.0, 1.0), (3.0, 2.0), (0.2, 15.0), (1.0, 0.05)] {
            // Periodic integrand: the trapezoid rule converges exponentially.
            let n = 4000;
            let sum: f64 = (0..n)
                .map(|i| {
                    let (s, c) = sin_cos(2.0 * PI * f64::from(i) / f64::from(n));
                    (a * a * s * s + b * b * c * c).sqrt()
                })
                .sum();
            let want = 2.0 * PI * sum / f64::from(n);
            assert!((ellipse_perimeter(a, b) / want - 1.0).abs() < 1e-13, "{a} {b}");
        }
        assert!((ellipse_perimeter(1.0, 1e-9) / 4.0 - 1.0).abs() < 1e-14);
    }

    #[test]
    fn surface_integral_against_quadrature() {
        assert!((carlson_rg(1.0, 1.0, 1.0) - 1.0).abs() < 1e-15);
        // R_G(x, x, x)-like scaling and a value from DLMF's definition by double quadrature.
        for (x, y, z) in [(4.0_f64, 2.0, 1.0), (0.3, 5.0, 2.0), (1.0, 1.0, 9.0)] {
            let mut sum = 0.0;
            for (mu, w) in gauss_legendre(60, 0.0, 1.0) {
                let n = 200;
                for i in 0..n {
                    let (s, c) = sin_cos(PI * (f64::from(i) + 0.5) / f64::from(n));
                    let t = 1.0 - mu * mu;
                    sum += w / f64::from(n) * (x * t * c * c + y * t * s * s + z * mu * mu).sqrt();
                }
            }
            assert!((carlson_rg(x, y, z) / sum - 1.0).abs() < 1e-12, "{x} {y} {z}");
        }
    }
}
