//! The textbook forms, run where they are hard: each returns the fault that it shows.

use lightpro::math::DVec3;
use lightpro::rng::{Purpose, Stream};
use std::hint::black_box;

/// Ten layers of a tenth on top of each other, and where their face should be.
pub fn film() -> f64 {
    ((0..10).fold(0.0, |z, _| z + black_box(0.1)) - 1.0_f64).abs()
}

/// Where b² − 4c puts the near side of a sphere of radius `r`, seen along its middle from `far`.
fn near_side(far: f64, r: f64) -> f64 {
    let (b, c) = (-2.0 * far, far * far - r * r);
    0.5 * (-b - (b * b - 4.0 * c).sqrt())
}

/// Relative error of the thickness of a wall of 1e-9 radii seen from 1e6 radii.
pub fn thin_wall() -> f64 {
    let seen = near_side(black_box(1e6), 1.0 - 1e-9) - near_side(black_box(1e6), 1.0);
    (seen / 1e-9 - 1.0).abs()
}

/// x²/a² + y²/b² in the middle of a lumen of no height.
pub fn zero_axis() -> f64 {
    (black_box(0.0_f64) / black_box(0.0)).powi(2)
}

/// A ray that runs along the wall of a circle at `graze` rad, reflected up to a million times: how far off
/// the wall it came, and after how many reflections it met the wall where it stood, or not at all.
pub fn whispering(graze: f64) -> (f64, Option<u32>) {
    let (mut p, mut d) = (DVec3::X, DVec3::new(-graze.sin(), graze.cos(), 0.0));
    let mut worst = 0.0_f64;
    for k in 0..1_000_000 {
        let (b, c) = (2.0 * p.dot(d), p.length_squared() - 1.0);
        let t = 0.5 * (-b + (b * b - 4.0 * c).sqrt());
        if t.is_nan() || t < 0.5 * graze {
            return (worst, Some(k));
        }
        p += d * t;
        d -= p * (2.0 * d.dot(p));
        worst = worst.max((p.length() - 1.0).abs());
    }
    (worst, None)
}

/// Root of the quadratic for a ray along the axis.
pub fn along_axis() -> f64 {
    let (a, b, c) = (black_box(0.0_f64), 0.0, -0.75);
    (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
}

/// Share of the rays in a plane that touches a fibre (axis in the plane below it) that are taken for hits.
pub fn tangent() -> f64 {
    let mut s = Stream::of(4, 0, 0, Purpose::Probe);
    let hit = |_: &u32| {
        let (r, turn) = (0.1 + s.uniform(), std::f64::consts::TAU * s.uniform());
        let (origin, dir) = (DVec3::new(s.normal(), s.normal(), r), DVec3::new(turn.cos(), turn.sin(), 0.0));
        let axis = DVec3::new(0.6, 0.8, 0.0);
        let (o, d) = (origin - axis * origin.dot(axis), dir - axis * dir.dot(axis));
        let (a, b, c) = (d.length_squared(), 2.0 * o.dot(d), o.length_squared() - r * r);
        b * b - 4.0 * a * c > 0.0
    };
    (0..1000_u32).filter(hit).count() as f64 / 1000.0
}

/// Share of the light in a sphere of radius 1e-3 that a ray offset by 1e-4 carries through the wall unseen
/// (cosine law inside, one reflection after the other).
pub fn epsilon() -> f64 {
    let mut s = Stream::of(5, 0, 0, Purpose::Probe);
    (0..1_000_000).filter(|_| 2.0 * 1e-3 * s.uniform_positive().sqrt() < 1e-4).count() as f64 / 1e6
}

/// Slab test of a ray in the face itself: (face − origin)/direction.
pub fn zero_direction() -> f64 {
    (black_box(1.0_f64) - 1.0) * (1.0 / black_box(0.0_f64))
}

/// Share of the steps of a march down from face to face, by position, that stay in their voxel.
pub fn diagonal() -> f64 {
    let (mut p, d) = (DVec3::splat(0.1), DVec3::new(-0.6, -0.64, -0.48));
    let mut stuck = 0;
    for _ in 0..10_000 {
        let ahead = (p.floor() - p) / d;
        let next = p + d * ahead.min_element();
        stuck += u32::from(next.floor() == p.floor());
        // A march that stands still is pushed on, or it would stand for ever.
        p = if next == p { p + d * 1e-9 } else { next };
    }
    f64::from(stuck) / 1e4
}

/// Place in a ring of four patches of an azimuth just below 0.
pub fn seam() -> f64 {
    let turn = std::f64::consts::TAU;
    (black_box(-1e-17_f64).rem_euclid(turn) / turn * 4.0).floor()
}

/// Share of an isotropic source at .9 of the radius of a glass sphere that total reflection keeps.
pub fn trapped() -> f64 {
    (1.0 - 1.0 / (1.5 * black_box(0.9_f64)).powi(2)).sqrt()
}

/// Upper neighbour of the last wavelength in a table of four.
pub fn table_end() -> usize {
    ((black_box(700.0_f64) - 400.0) / 100.0) as usize + 1
}

/// Reduced chi-square of a histogram of one bin.
pub fn one_bin() -> f64 {
    let (observed, expected, bins) = (black_box(100.0_f64), 100.0, 1.0);
    ((observed - expected) * (observed - expected) / expected) / (bins - 1.0)
}
