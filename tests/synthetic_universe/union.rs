//! The overlap rule `union`: walls win over hollows, walls of one material merge, the mark decides
//! between materials.

use super::*;
use lightpro::universe::Overlap;
use lightpro::universe::synthetic::Setting;

fn union(parts: Vec<Part>) -> SyntheticUniverse {
    SyntheticUniverse::with(AIR, parts, Setting { overlap: Overlap::Union, ..Setting::default() }).unwrap()
}

/// A hollow fibre along y through (x, 0, 0): radius 2, lumen 1.
fn fibre(x: f64, medium: u16, lumen: u16, body: u32) -> [Part; 2] {
    let frame = Frame { x: DVec3::Z, y: DVec3::X, z: DVec3::Y };
    let at = DVec3::X * x;
    [
        part(cylinder(2.0, 2.0, None, at, frame), medium, body),
        part(cylinder(1.0, 1.0, None, at, frame), lumen, body),
    ]
}

/// Along x: where interfaces are, and what lies beyond.
fn along_x(parts: Vec<Part>) -> Vec<(f64, u16, u32)> {
    let met = straight(&union(parts), ray([-10.0, 0.0, 0.0], [1.0, 0.0, 0.0]));
    met.iter().map(|(t, i)| (((t - 10.0) * 1e9).round() / 1e9, i.beyond.0, i.body.0)).collect()
}

#[test]
fn walls_win_over_hollows_and_merge() {
    // One fibre alone.
    let one = fibre(0.0, 1, 0, 0);
    assert_eq!(along_x(one.to_vec()), [(-2.0, 1, 0), (-1.0, 0, 0), (1.0, 1, 0), (2.0, 0, 0)]);
    // The second's wall stands in the first's lumen, whatever the order: [-.5, .5] of [-1, 1].
    for swap in [false, true] {
        let (mut a, mut b) = (fibre(0.0, 1, 0, 0).to_vec(), fibre(1.5, 1, 0, 1).to_vec());
        if swap {
            std::mem::swap(&mut a, &mut b);
        }
        a.extend(b);
        let met: Vec<(f64, u16)> = along_x(a).iter().map(|m| (m.0, m.1)).collect();
        // First: wall -2…-1, 1…2, lumen -1…1. Second: wall -.5….5, 2.5…3.5, lumen .5…2.5.
        assert_eq!(met, [(-2.0, 1), (-1.0, 0), (-0.5, 1), (0.5, 0), (1.0, 1), (2.0, 0), (2.5, 1), (3.5, 0)]);
    }
}

#[test]
fn the_mark_decides_between_materials() {
    let solid = |x: f64, medium, body| part(sphere(DVec3::X * x, 2.0), medium, body);
    assert_eq!(along_x(vec![solid(0.0, 1, 0), solid(1.0, 2, 1)]), [(-2.0, 1, 0), (-1.0, 2, 1), (3.0, 0, 1)]);
    assert_eq!(along_x(vec![solid(1.0, 2, 1), solid(0.0, 1, 0)]), [(-2.0, 1, 0), (2.0, 2, 0), (3.0, 0, 1)]);
    // A lumen of the later body uncovers the wall of the earlier.
    let mut parts = vec![solid(0.0, 1, 0)];
    parts.extend(fibre(0.0, 2, 0, 1));
    assert_eq!(along_x(parts), [(-2.0, 2, 1), (-1.0, 1, 1), (1.0, 2, 1), (2.0, 0, 1)]);
    // Walls of one material merge even where their surfaces have a law; a hollow's medium may differ.
    let mut rough = vec![solid(0.0, 1, 0), solid(1.0, 1, 1)];
    rough.iter_mut().for_each(|p| p.surface = SurfaceId(1));
    assert_eq!(along_x(rough), [(-2.0, 1, 0), (3.0, 0, 1)]);
    let mut wet = fibre(0.0, 1, 3, 0).to_vec();
    wet.extend(fibre(6.0, 1, 3, 1));
    assert_eq!(along_x(wet).iter().map(|m| m.1).collect::<Vec<_>>(), [1, 3, 1, 0, 1, 3, 1, 0]);
}

/// Shares of a crowd by points and by straight rays agree, and with the formula of the Boolean model.
#[test]
fn shares_by_points_and_by_rays() {
    let side = 60.0;
    let mut s = stream(21);
    let mut parts = Vec::new();
    let (r, h, count) = (2.0_f64, 10.0, 700_u32);
    for body in 0..count {
        let at = DVec3::new(s.uniform(), s.uniform(), s.uniform()) * side;
        let frame = random_frame(&mut s);
        for (radius, medium) in [(r, 1), (0.7 * r, 0)] {
            parts.push(part(cylinder(radius, radius, Some(h), at, frame), medium, body));
        }
    }
    let (lo, hi) = (12.0, 48.0); // far enough from the rim of the crowd
    let density = f64::from(count) / side.powi(3);
    let wall = std::f64::consts::PI * r * r * (1.0 - 0.49) * 2.0 * h;
    let want = 1.0 - (-density * wall).exp();
    let u = union(parts);
    let inner = |s: &mut Stream| DVec3::new(s.uniform(), s.uniform(), s.uniform()) * (hi - lo) + lo;
    let points = 200_000;
    let solid = (0..points).filter(|_| u.medium_at(inner(&mut s)).0 == 1).count() as f64 / f64::from(points);
    let (mut way, mut in_wall) = (0.0, 0.0);
    for _ in 0..20_000 {
        let p = inner(&mut s);
        let dir = [DVec3::X, DVec3::Y, DVec3::Z][(3.0 * s.uniform()) as usize];
        let start = p - dir * (p.dot(dir) - lo);
        let mut ray = Ray { origin: start, dir };
        let begin = u.enter(&ray, &mut (), &mut s);
        let (mut place, mut medium, mut left) = (begin.place, begin.medium, hi - lo);
        while left > 0.0 {
            let seen = u.next(&ray, &mut place, &mut (), left, &mut s);
            let step = if let Next::Interface(i) = &seen { i.distance } else { left };
            way += step;
            in_wall += if medium.0 == 1 { step } else { 0.0 };
            left -= step;
            let Next::Interface(i) = seen else { break };
            ray.origin = ray.at(step);
            u.crossed(&mut ray, &mut place, &mut (), &i);
            medium = i.beyond;
        }
    }
    println!("solid share by points {solid:.4}, by rays {:.4}, expected {want:.4}", in_wall / way);
    assert!((solid - in_wall / way).abs() < 0.006);
    assert!((solid - want).abs() < 0.03, "one realisation of 700 fibres");
}
