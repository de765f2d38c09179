//! Many bodies: the index (grid, hierarchy) answers with the bits of a search one by one, loses no
//! ray near or far, and a periodic cell is what its name says.

use super::*;
use lightpro::universe::Face;
use lightpro::universe::synthetic::{Overlap, Search, Setting};

/// Hollow and solid fibres, spheres, boxes, flakes; finite, with overlaps, in a box of `side` µm.
pub fn crowd(count: u32, side: f64, sizes: f64, seed: u64) -> Vec<Part> {
    let mut s = stream(seed);
    let mut parts = Vec::new();
    for body in 0..count {
        let at = DVec3::new(s.uniform(), s.uniform(), s.uniform()) * side;
        let r = 1.0 + (sizes - 1.0) * s.uniform();
        let frame = random_frame(&mut s);
        let priority = (body % 3) as i32;
        let medium = 1 + (body % 3) as u16;
        let mut add = |shape, medium| parts.push(Part { priority, ..part(shape, medium, body) });
        match body % 5 {
            0 | 1 => {
                add(cylinder(r, 0.4 * r, Some(6.0 * r), at, frame), medium);
                add(cylinder(0.7 * r, 0.2 * r, Some(6.0 * r), at, frame), 0);
            }
            2 => add(sphere(at, r), medium),
            3 => {
                let e = Ellipsoid { a: r, b: 0.5 * r, c: 0.2 * r };
                add(Placed::new(Shape::Ellipsoid(e), at, frame), medium);
            }
            _ => {
                let half = DVec3::new(r, 0.3 * r, 0.5 * r);
                add(Placed::new(Shape::Cuboid(Cuboid::centred(half)), at, frame), medium);
            }
        }
    }
    parts
}

pub fn with(parts: Vec<Part>, setting: Setting) -> SyntheticUniverse {
    SyntheticUniverse::with(AIR, parts, setting).unwrap()
}

/// A walk of `events` events from random points of the box; every answer as bits.
fn bits(u: &SyntheticUniverse, side: f64, events: usize, far: f64) -> Vec<[u64; 5]> {
    let s = &mut stream(9);
    let mut seen = Vec::new();
    while seen.len() < events {
        let dir = isotropic(s);
        let aim = DVec3::new(s.uniform(), s.uniform(), s.uniform()) * side;
        let back = if s.uniform() < 0.5 { 0.0 } else { far };
        let mut ray = Ray { origin: aim - dir * back, dir };
        let mut place = u.enter(&ray, &mut (), s).place;
        for _ in 0..100 {
            let limit = if s.uniform() < 0.3 && back == 0.0 { 4.0 * s.exponential() } else { f64::INFINITY };
            match u.next(&ray, &mut place, &mut (), limit, s) {
                Next::Interface(at) => {
                    let n = at.normal;
                    let rest = u64::from(at.beyond.0) << 32 | u64::from(at.body.0);
                    seen.push([at.distance, n.x, n.y, n.z].map(f64::to_bits).into_iter().chain([rest]).collect::<Vec<_>>().try_into().unwrap());
                    ray.origin = ray.at(at.distance);
                    let d = isotropic(s);
                    let up = if d.dot(n) < 0.0 { -d } else { d };
                    match (4.0 * s.uniform()) as u32 {
                        0 => {
                            ray.dir = up;
                            u.reflected(&ray, &mut place, &mut (), &at);
                        }
                        1 => {
                            ray.dir = -up;
                            u.crossed(&mut ray, &mut place, &mut (), &at);
                        }
                        _ => u.crossed(&mut ray, &mut place, &mut (), &at),
                    }
                }
                Next::Limit => {
                    seen.push([1, limit.to_bits(), u64::from(u.medium(&place).0), 0, 0]);
                    ray = Ray { origin: ray.at(limit), dir: isotropic(s) };
                    u.moved(&ray, &mut place, &mut (), limit);
                }
                Next::Edge { .. } => break,
                Next::Lost => panic!("lost"),
            }
        }
    }
    seen
}

#[test]
fn every_search_answers_with_the_same_bits() {
    for (count, side, sizes) in [(60, 12.0, 2.0), (800, 40.0, 2.0), (400, 220.0, 30.0), (300, 900.0, 3.0)] {
        for overlap in [Overlap::Priority, Overlap::Union] {
            let mut parts = crowd(count, side, sizes, 5);
            // Something everywhere, and something far larger than the rest.
            parts.push(Part { priority: -5, ..part(slab(0.3 * side, 0.6 * side), 4, 9001) });
            parts.push(Part { priority: -4, ..part(sphere(DVec3::splat(0.5 * side), 0.4 * side), 5, 9002) });
            let answers = [Search::Linear, Search::Grid, Search::Hierarchy, Search::Automatic].map(|search| {
                let u = with(parts.clone(), Setting { overlap, search, ..Setting::default() });
                println!("{count} {overlap:?} {search:?}: {}", u.describe_search());
                bits(&u, side, 30_000, 3.0 * side)
            });
            for other in &answers[1..] {
                let first = answers[0].iter().zip(other).position(|(a, b)| a != b);
                assert_eq!(first, None, "{count} {overlap:?}");
            }
            let u = with(parts.clone(), Setting { overlap, search: Search::Linear, ..Setting::default() });
            parts[7].shape.centre.x += 1e-9;
            let other = with(parts, Setting { overlap, ..Setting::default() });
            assert!(bits(&u, side, 30_000, 0.0) != bits(&other, side, 30_000, 0.0), "a body moved unseen");
        }
    }
}

#[test]
fn the_choice_follows_the_scene() {
    let words = |parts| with(parts, Setting::default()).describe_search();
    assert!(words(crowd(10, 20.0, 2.0, 1)).contains("one by one"));
    assert!(words(crowd(3000, 60.0, 2.0, 1)).starts_with("uniform grid"));
    assert!(words(crowd(300, 3000.0, 2.0, 1)).starts_with("hierarchy"));
    assert!(words(crowd(3000, 100.0, 100.0, 1)).starts_with("hierarchy"));
}
