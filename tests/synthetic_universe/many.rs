//! Many bodies: the index (grid, hierarchy) answers with the bits of a search one by one, loses no
//! ray near or far, and a periodic cell is what its name says.

use super::*;
use crate::walking::onward;
use lightpro::universe::Overlap;
use lightpro::universe::synthetic::{Search, Setting};

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
                    seen.push(
                        [at.distance, n.x, n.y, n.z]
                            .map(f64::to_bits)
                            .into_iter()
                            .chain([rest])
                            .collect::<Vec<_>>()
                            .try_into()
                            .unwrap(),
                    );
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
            let answers =
                [Search::Linear, Search::Grid, Search::Hierarchy, Search::Automatic].map(|search| {
                    let u = with(parts.clone(), Setting { overlap, search, ..Setting::default() });
                    println!("{count} {overlap:?} {search:?}: {}", u.describe_search());
                    bits(&u, side, 30_000, 3.0 * side)
                });
            for other in &answers[1..] {
                let first = answers[0].iter().zip(other).position(|(a, b)| a != b);
                assert_eq!(first, None, "{count} {overlap:?}");
            }
            let u = with(parts.clone(), Setting { overlap, search: Search::Linear, ..Setting::default() });
            // Some bodies: a single one need not be on the way of any ray.
            parts.iter_mut().step_by(7).for_each(|p| p.shape.centre.x += 1e-9);
            let other = with(parts, Setting { overlap, ..Setting::default() });
            assert!(bits(&u, side, 30_000, 0.0) != bits(&other, side, 30_000, 0.0), "bodies moved unseen");
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

/// Hollow fibres in the plane that cover 40 % of a square of `side` µm, moved to `at`.
pub fn mat(side: f64, at: DVec3) -> Vec<Part> {
    let mut s = stream(77);
    let (r, length, height) = (10.0, 400.0, 100.0);
    let volume = std::f64::consts::PI * r * r * length;
    let count = (-0.6_f64.ln() * side * side * height / volume) as u32;
    let mut parts = Vec::new();
    for body in 0..count {
        let phi = std::f64::consts::PI * s.uniform();
        let z = DVec3::new(phi.cos(), phi.sin(), 0.0);
        let frame = Frame { x: z.cross(-DVec3::Z), y: DVec3::Z, z };
        let centre = at + DVec3::new(side * s.uniform(), side * s.uniform(), height * s.uniform());
        for (radius, medium) in [(r, 1), (0.73 * r, 0)] {
            parts.push(part(cylinder(radius, radius, Some(0.5 * length), centre, frame), medium, body));
        }
    }
    parts
}

/// Whether the medium at `p` is `medium`, or becomes so within `slack`.
fn medium_near(u: &SyntheticUniverse, p: DVec3, medium: MediumId, slack: f64) -> bool {
    let near = |i: i32| f64::from(i - 1) * slack;
    u.medium_at(p) == medium
        || (0..27).any(|k| u.medium_at(p + DVec3::new(near(k % 3), near(k / 3 % 3), near(k / 9))) == medium)
}

/// Follows rays over `events` interfaces, one in four of them sent on along the surface within 1e-9 to
/// 1e-1 rad; counts what is lost, and media that are not those of the point.
fn follow(u: &SyntheticUniverse, at: DVec3, side: f64, history: u64, events: u64) -> (u64, u64, u64) {
    let s = &mut stream(history);
    let (mut met, mut lost, mut wrong) = (0, 0, 0);
    while met < events {
        let origin = at + DVec3::new(side * s.uniform(), side * s.uniform(), 100.0 * s.uniform());
        let mut ray = Ray { origin, dir: isotropic(s) };
        let start = u.enter(&ray, &mut (), s);
        let (mut place, mut medium) = (start.place, start.medium);
        loop {
            match u.next(&ray, &mut place, &mut (), f64::INFINITY, s) {
                Next::Interface(i) => {
                    met += 1;
                    if met % 16 == 0 {
                        let middle = ray.at(0.5 * i.distance);
                        let slack = 1e-12 * (1e3 + at.length());
                        wrong += u64::from(!medium_near(u, middle, medium, slack));
                    }
                    ray.origin = ray.at(i.distance);
                    let d = isotropic(s);
                    let (reflects, dir) = onward(&i, ray.dir, d, 9.0, s);
                    ray.dir = dir;
                    if reflects {
                        u.reflected(&ray, &mut place, &mut (), &i);
                    } else {
                        u.crossed(&mut ray, &mut place, &mut (), &i);
                        medium = i.beyond;
                    }
                }
                Next::Edge { .. } => break,
                _ => {
                    lost += 1;
                    break;
                }
            }
        }
    }
    (met, lost, wrong)
}

fn none_lost(events: u64) {
    for away in [0.0, 1e3, 24e3] {
        let at = DVec3::new(away, -away, away);
        for period in [None, Some([1000.0; 2])] {
            let at = if period.is_some() { DVec3::new(0.0, 0.0, at.z) } else { at };
            let setting = Setting {
                overlap: Overlap::Union,
                sheet: Some([at.z, at.z + 100.0]),
                period,
                search: Search::Automatic,
            };
            let u = with(mat(1000.0, at), setting);
            assert!(u.describe_search().starts_with("uniform grid"), "{}", u.describe_search());
            // In a periodic cell the rays themselves start far away.
            let from = if period.is_some() { at + DVec3::new(away, away, 0.0) } else { at };
            let all = std::thread::scope(|scope| {
                let u = &u;
                let work = |k| scope.spawn(move || follow(u, from, 1000.0, 40 + k, events / 12));
                let threads: Vec<_> = (0..2_u64).map(work).collect();
                threads
                    .into_iter()
                    .map(|t| t.join().unwrap())
                    .fold((0, 0, 0), |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2))
            });
            println!("{away} µm away, period {period:?}: {all:?} met, lost, wrong");
            assert_eq!((all.1, all.2), (0, 0));
        }
    }
}

#[test]
fn no_ray_is_lost_near_or_far() {
    none_lost(1_200_000);
}

#[test]
#[ignore = "long: cargo test --release --test synthetic_universe hundred_million -- --ignored --nocapture"]
fn no_ray_is_lost_in_a_hundred_million_interfaces() {
    none_lost(100_000_000);
}

fn periodic(parts: Vec<Part>, period: [f64; 2], height: f64) -> SyntheticUniverse {
    let sheet = Some([0.0, height]);
    with(parts, Setting { overlap: Overlap::Union, sheet, period: Some(period), ..Setting::default() })
}

/// Follows straight rays from the sheet's upper plane: all distances, and bodies.
fn straight_through(u: &SyntheticUniverse, shift: DVec3, rays: usize) -> Vec<(f64, u32)> {
    let s = &mut stream(31);
    let mut seen = Vec::new();
    for _ in 0..rays {
        let d = isotropic(s);
        let dir = if d.z > 0.0 { -d } else { d };
        // On a lattice of 2⁻²⁰, so that a shift by a whole period changes no bit of what follows.
        let at = DVec3::new(s.uniform(), s.uniform(), 0.0) * 64.0;
        let at = (at * 1048576.0).floor() / 1048576.0 + DVec3::Z * 32.0;
        let mut ray = Ray { origin: at + shift, dir };
        let mut place = u.enter(&ray, &mut (), s).place;
        let mut gone = 0.0;
        for _ in 0..1000 {
            let Next::Interface(i) = u.next(&ray, &mut place, &mut (), f64::INFINITY, s) else { break };
            gone += i.distance;
            seen.push((gone, i.body.0));
            ray.origin = ray.at(i.distance);
            u.crossed(&mut ray, &mut place, &mut (), &i);
        }
    }
    seen
}

fn small_crowd() -> Vec<Part> {
    crowd(600, 64.0, 2.0, 8)
        .into_iter()
        .map(|mut p| {
            p.shape.centre.z *= 0.5;
            p
        })
        .collect()
}

#[test]
fn a_periodic_cell_repeats_itself() {
    let parts = small_crowd();
    let one = periodic(parts.clone(), [64.0; 2], 32.0);
    assert!(one.describe_search().contains("repeated sideways"));
    let base = straight_through(&one, DVec3::ZERO, 2000);
    assert!(base.len() > 20_000);
    // First interfaces of rays moved by whole periods: the same bits (later origins are rounded).
    for (x, y) in [(1.0, 0.0), (-3.0, 2.0), (0.0, -16.0)] {
        let other = straight_through(&one, DVec3::new(x, y, 0.0) * 64.0, 2000);
        assert_eq!(base.len(), other.len());
        assert_eq!(base[0], other[0]);
        let off = base.iter().zip(&other).map(|(a, b)| (a.0 - b.0).abs()).fold(0.0, f64::max);
        assert!(off < 1e-8 && base.iter().zip(&other).all(|(a, b)| a.1 == b.1), "{off}");
    }
    // A cell of twice the period that holds everything four times is the same scene.
    let four = (0..4)
        .flat_map(|k| {
            let shift = DVec3::new(f64::from(k % 2), f64::from(k / 2), 0.0) * 64.0;
            parts.iter().map(move |p| {
                let mut p = *p;
                p.shape.centre += shift;
                p
            })
        })
        .collect();
    let double = straight_through(&periodic(four, [128.0; 2], 32.0), DVec3::ZERO, 2000);
    assert_eq!(base.len(), double.len());
    let off = base.iter().zip(&double).map(|(a, b)| (a.0 - b.0).abs()).fold(0.0, f64::max);
    assert!(off < 1e-9, "{off}");
    // And not the same with another period.
    let other = straight_through(&periodic(parts, [65.0, 64.0], 32.0), DVec3::ZERO, 2000);
    assert_ne!(base.len(), other.len());
}

#[test]
fn what_fits_no_period_is_refused() {
    use lightpro::universe::synthetic::Error;
    let setting = |period| Setting { sheet: Some([0.0, 9.0]), period: Some(period), ..Setting::default() };
    let try_with =
        |p: Placed, period| SyntheticUniverse::with(AIR, vec![part(p, 1, 0)], setting(period)).err();
    let x = Frame { x: DVec3::Y, y: DVec3::Z, z: DVec3::X };
    let fibre = |h| cylinder(1.0, 1.0, h, DVec3::ZERO, x);
    assert_eq!(try_with(fibre(None), [10.0; 2]), Some(Error::TooLong(0)));
    assert_eq!(try_with(fibre(Some(11.0)), [10.0; 2]), Some(Error::TooLong(0)));
    assert_eq!(try_with(fibre(Some(8.0)), [10.0; 2]), None);
    assert_eq!(try_with(slab(0.0, 1.0), [10.0; 2]), None);
    assert_eq!(try_with(slab(0.0, 1.0), [10.0, 0.0]), Some(Error::Setting));
    assert_eq!(try_with(slab(0.0, 1.0), [f64::NAN, 1.0]), Some(Error::Setting));
}
