//! Steps of random walks, for tests of any universe.

use lightpro::math::{DVec3, TAU};
use lightpro::rng::Stream;
use lightpro::universe::Interface;

/// Isotropic direction.
pub fn isotropic(s: &mut Stream) -> DVec3 {
    let z = 2.0 * s.uniform() - 1.0;
    let (sin, cos) = (TAU * s.uniform()).sin_cos();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z).normalize()
}

/// The way on from the interface `at`, met along `dir`: one in four flat along the surface, at 10^−`decades` to
/// 1e-1 rad, to either side; one in four along `d` (drawn at random), to either side; the others straight on.
/// Whether that is a reflection, and the direction.
pub fn onward(at: &Interface, dir: DVec3, d: DVec3, decades: f64, s: &mut Stream) -> (bool, DVec3) {
    let n = at.normal;
    let up = if d.dot(n) < 0.0 { -d } else { d };
    let flat = (d - n * d.dot(n)).normalize();
    let grazing = (flat + n * 10_f64.powf(-1.0 - (decades - 1.0) * s.uniform())).normalize();
    match (8.0 * s.uniform()) as u32 {
        0 => (true, grazing),
        1 => (false, (grazing - n * (2.0 * grazing.dot(n))).normalize()),
        2 => (true, up),
        3 => (false, -up),
        _ => (false, dir),
    }
}
