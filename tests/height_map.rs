//! The surface of a height map: against planes, against a search by bisection, and under stress.
#![allow(missing_docs, clippy::disallowed_methods)]

use lightpro::math::DVec3;
use lightpro::rng::{Purpose, Stream};
use lightpro::universe::Ray;
use lightpro::universe::shape::height::{Ahead, HeightError, HeightMap, Meeting};
use lightpro::universe::sheet::plane_ahead;

fn dice(number: u64) -> Stream {
    Stream::of(20, 0, number, Purpose::Probe)
}

/// A rough map with steep and level places, a saddle in most cells; `scale` multiplies all lengths.
fn rough(scale: f64) -> HeightMap {
    let (nx, ny) = (24, 17);
    let mut rng = dice(1);
    let wave = |i: usize, j: usize| {
        2.0 * (std::f64::consts::TAU * i as f64 / 24.0).sin()
            + (std::f64::consts::TAU * 2.0 * j as f64 / 17.0).cos()
    };
    let heights = (0..nx * ny).map(|k| scale * (wave(k % nx, k / nx) + 0.8 * rng.uniform())).collect();
    HeightMap::new(heights, [nx, ny], [0.75 * scale, 1.25 * scale]).unwrap()
}

fn met(ahead: Ahead) -> Option<Meeting> {
    match ahead {
        Ahead::Met(m) => Some(m),
        Ahead::Free => None,
        Ahead::Endless => panic!("endless"),
    }
}

fn direction(rng: &mut Stream) -> DVec3 {
    let (c, f) = (2.0 * rng.uniform() - 1.0, std::f64::consts::TAU * rng.uniform());
    let s = (1.0 - c * c).sqrt();
    DVec3::new(s * f.cos(), s * f.sin(), c)
}

#[test]
fn maps_that_are_none_are_refused() {
    let map = |h: Vec<f64>, n, p| HeightMap::new(h, n, p).unwrap_err();
    assert_eq!(map(vec![0.0; 4], [4, 1], [1.0; 2]), HeightError::Nodes);
    let measured = |h: Vec<f64>, n| HeightMap::measured(h, n, [1.0; 2], true, Some(0.0)).unwrap_err();
    assert_eq!(measured(vec![], [0, 0]), HeightError::Nodes);
    assert_eq!(measured(vec![0.0; 5], [3, 2]), HeightError::Nodes);
    assert_eq!(map(vec![0.0; 5], [2, 2], [1.0; 2]), HeightError::Nodes);
    assert_eq!(map(vec![0.0; 4], [2, 2], [0.0, 1.0]), HeightError::Pixel);
    assert_eq!(map(vec![0.0; 4], [2, 2], [1.0, f64::NAN]), HeightError::Pixel);
    assert_eq!(map(vec![0.0, 1.0, f64::NAN, 0.0, 1.0, 2.0], [3, 2], [1.0; 2]), HeightError::Hole(2, 0));
    assert_eq!(map(vec![0.0, 1.0, 0.0, f64::INFINITY], [2, 2], [1.0; 2]), HeightError::Hole(1, 1));
}

/// A map of one height is the plane of a slab, bit for bit.
#[test]
fn a_flat_map_is_a_plane() {
    let map = HeightMap::new(vec![0.7; 12], [4, 3], [0.3, 0.9]).unwrap();
    let mut rng = dice(2);
    for _ in 0..10_000 {
        let above = rng.uniform() < 0.5;
        let z = 0.7 + if above { 1.0 } else { -1.0 } * 3.0 * rng.uniform();
        let ray = Ray { origin: DVec3::new(rng.uniform(), rng.uniform(), z), dir: direction(&mut rng) };
        let want = (above == (ray.dir.z < 0.0)).then(|| plane_ahead(&ray, 0.7, 0.7).0);
        let got = met(map.ahead(&ray, above, false, f64::INFINITY));
        assert_eq!(got.map(|m| (m.distance.to_bits(), m.up)), want.map(|t| (t.to_bits(), DVec3::Z)));
    }
}

/// Where the heights rise evenly (all but the last cells of the period) the surface is the tilted plane.
#[test]
fn a_ramp_is_a_tilted_plane() {
    let (n, slope) = (64, [0.35, -0.2]);
    let heights = (0..n * n).map(|k| slope[0] * (k % n) as f64 + slope[1] * (k / n) as f64).collect();
    let map = HeightMap::new(heights, [n, n], [1.0; 2]).unwrap();
    let up = DVec3::new(-slope[0], -slope[1], 1.0).normalize();
    let (mut rng, mut worst) = (dice(3), 0.0_f64);
    for _ in 0..10_000 {
        // Aimed at a point of the middle, from close by.
        let at = DVec3::new(20.0 + 24.0 * rng.uniform(), 20.0 + 24.0 * rng.uniform(), 0.0);
        let at = at + DVec3::Z * (slope[0] * at.x + slope[1] * at.y);
        let dir = direction(&mut rng);
        let above = dir.dot(up) < 0.0;
        let way = 10.0 * rng.uniform();
        let hit = met(map.ahead(&Ray { origin: at - dir * way, dir }, above, false, 1e3)).unwrap();
        if dir.dot(up).abs() > 1e-3 {
            worst = worst.max((hit.distance - way).abs() * dir.dot(up).abs());
        }
        assert!(hit.up.dot(up) > 1.0 - 1e-12, "{:?}", hit.up);
    }
    println!("worst distance from the plane {worst:e} um");
    assert!(worst < 1e-12);
}

/// The first change of sign of z − h along a ray, by small steps and bisection: an independent search.
fn bisected(height: &dyn Fn(f64, f64) -> f64, ray: &Ray, above: bool, reach: f64) -> Option<f64> {
    let f = |t: f64| {
        let p = ray.at(t);
        (p.z - height(p.x, p.y)) * if above { 1.0 } else { -1.0 }
    };
    let step = 2e-3;
    let mut t = 0.0;
    while t < reach {
        if f(t + step) < 0.0 {
            let (mut lo, mut hi) = (t, t + step);
            for _ in 0..60 {
                let mid = 0.5 * (lo + hi);
                if f(mid) < 0.0 { hi = mid } else { lo = mid }
            }
            return Some(hi);
        }
        t += step;
    }
    None
}

/// Interpolation of four heights, written once more.
fn bilinear(heights: &[f64], n: [usize; 2], pixel: [f64; 2], x: f64, y: f64) -> f64 {
    let (x, y) = ((x / pixel[0]).rem_euclid(n[0] as f64), (y / pixel[1]).rem_euclid(n[1] as f64));
    let (i, j) = (x as usize % n[0], y as usize % n[1]);
    let (u, v) = (x - x.floor(), y - y.floor());
    let h = |i: usize, j: usize| heights[(j % n[1]) * n[0] + i % n[0]];
    (1.0 - v) * ((1.0 - u) * h(i, j) + u * h(i + 1, j)) + v * ((1.0 - u) * h(i, j + 1) + u * h(i + 1, j + 1))
}

#[test]
fn the_first_crossing_is_found() {
    let (n, pixel) = ([9, 7], [0.5, 0.8]);
    let mut rng = dice(4);
    let heights: Vec<f64> = (0..63).map(|_| rng.uniform()).collect();
    let map = HeightMap::new(heights.clone(), n, pixel).unwrap();
    let height = |x: f64, y: f64| bilinear(&heights, n, pixel, x, y);
    let (mut found, mut worst) = (0, 0.0_f64);
    for _ in 0..4000 {
        let at = DVec3::new(20.0 * rng.uniform() - 10.0, 20.0 * rng.uniform() - 10.0, 0.0);
        assert!((map.height(at.x, at.y) - height(at.x, at.y)).abs() < 1e-13);
        let origin = at + DVec3::Z * (1.4 * rng.uniform() - 0.2);
        let above = origin.z > height(origin.x, origin.y);
        let ray = Ray { origin, dir: direction(&mut rng) };
        let got = met(map.ahead(&ray, above, false, 4.0)).map(|m| m.distance);
        let want = bisected(&height, &ray, above, 4.0);
        // The steps miss what grazes by less than they see.
        match (got, want) {
            (Some(g), Some(w)) if (g - w).abs() < 1e-9 => {
                (found, worst) = (found + 1, worst.max((g - w).abs()))
            }
            (None, None) => {}
            (Some(g), _) => {
                let graze = (1..50).map(|k| ray.at(g + 2e-3 * f64::from(k) / 25.0));
                let depth = graze.map(|p| (p.z - height(p.x, p.y)).abs()).fold(0.0, f64::max);
                assert!(want.is_none_or(|w| w > g) && depth < 0.02, "{got:?} {want:?} {depth}");
            }
            (None, Some(w)) => assert!(w > 4.0 - 4e-3, "missed at {w}"),
        }
    }
    println!("{found} crossings, worst {worst:e} um from bisection");
    assert!(found > 1500);
}

/// Reflected and transmitted at every crossing, half of them grazing: the way from crossing to crossing lies
/// on the side that the ray is on, and nothing is lost. (crossings, worst depth on the wrong side)
fn stressed(scale: f64, crossings: u64, note: &mut Vec<u64>) -> (u64, f64) {
    let map = rough(scale);
    let [lo, hi] = map.range();
    let mut rng = dice(5);
    let (mut met_, mut worst) = (0, 0.0_f64);
    while met_ < crossings {
        let mut above = rng.uniform() < 0.5;
        let z = if above { hi + scale } else { lo - scale };
        let sign = if above { -1.0 } else { 1.0 };
        let mut dir = direction(&mut rng);
        dir.z = dir.z.abs() * sign;
        let mut ray =
            Ray { origin: DVec3::new(200.0 * scale * rng.uniform(), -50.0 * scale * rng.uniform(), z), dir };
        let mut left = false;
        for _ in 0..200 {
            let side = if above { 1.0 } else { -1.0 };
            let Some(hit) = met(map.ahead(&ray, above, left, 200.0 * scale)) else { break };
            met_ += 1;
            note.push((hit.distance / scale).to_bits());
            assert!((hit.up.length() - 1.0).abs() < 1e-14 && hit.up.z > 0.0);
            assert!(hit.distance >= 0.0);
            for k in 1..8 {
                let p = ray.at(hit.distance * f64::from(k) / 8.0);
                worst = worst.max(-side * (p.z - map.height(p.x, p.y)) / scale);
            }
            let p = ray.at(hit.distance);
            worst = worst.max((p.z - map.height(p.x, p.y)).abs() / scale);
            // On: to either side, any direction of that half space, half of them grazing.
            above = (rng.uniform() < 0.5) == above;
            let side = if above { 1.0 } else { -1.0 };
            let mut dir = direction(&mut rng);
            let tangent = dir - hit.up * dir.dot(hit.up);
            let grazing = [1e-3, 1e-6, 1e-9, 1e-12][(4.0 * rng.uniform()) as usize];
            if rng.uniform() < 0.5 {
                dir = (tangent.normalize() + hit.up * (side * grazing)).normalize();
            } else {
                dir = tangent + hit.up * (side * dir.dot(hit.up).abs());
            }
            (ray, left) = (Ray { origin: p, dir }, true);
        }
    }
    (met_, worst)
}

#[test]
fn no_ray_is_lost_under_stress() {
    let (count, worst) = stressed(1.0, 1_000_000, &mut Vec::new());
    println!("{count} crossings, worst {worst:e} um on the wrong side");
    assert!(worst < 1e-11);
}

#[test]
fn scale_changes_no_bit() {
    let [mut one, mut small, mut large] = [const { Vec::new() }; 3];
    stressed(1.0, 20_000, &mut one);
    stressed(f64::exp2(-20.0), 20_000, &mut small);
    stressed(f64::exp2(20.0), 20_000, &mut large);
    assert!(one == small && one == large);
}

/// Vertical light on h = A sin kx: the mean cosine of the facets' tilt against the integral of the smooth
/// surface's, 1/√(1 + A²k² cos²), to second order in the pixel.
#[test]
fn a_sine_has_the_normals_of_a_sine() {
    let error = |n: usize| {
        let wave = |i: usize| (std::f64::consts::TAU * i as f64 / n as f64).sin();
        let map = HeightMap::new((0..2 * n).map(|k| wave(k % n)).collect(), [n, 2], [10.0 / n as f64, 1.0])
            .unwrap();
        let (mut got, mut want, rays) = (0.0, 0.0, 20_000);
        for i in 0..rays {
            let x = 10.0 * (f64::from(i) + 0.37) / f64::from(rays);
            let ray = Ray { origin: DVec3::new(x, 0.4, 5.0), dir: -DVec3::Z };
            got += met(map.ahead(&ray, true, false, 100.0)).unwrap().up.z;
            let slope = 0.628_318_530_717_958_6 * (0.628_318_530_717_958_6 * x).cos();
            want += 1.0 / (1.0 + slope * slope).sqrt();
        }
        ((got - want) / f64::from(rays)).abs()
    };
    let errors = [error(20), error(40), error(80)];
    println!("mean cosine off by {errors:?}");
    assert!(errors[0] < 2e-3 && errors[1] < 0.3 * errors[0] && errors[2] < 0.3 * errors[1]);
}
