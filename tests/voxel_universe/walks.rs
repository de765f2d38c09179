//! Walks through voxels.

use super::*;

#[test]
fn straight_rays_find_the_shares_of_the_volume() {
    let volume = Volume::of(example::CELLS, &example::labels(1)).unwrap();
    let counts = volume.counts(3);
    let n = volume.len() as f64;
    for normals in [NormalRule::Faces, NormalRule::Smoothed(2.0)] {
        for lateral in [Lateral::Mirror, Lateral::Periodic] {
            let rules = Rules { anywhere: true, lateral, normals, ..rules(1.0) };
            let u = VoxelUniverse::new(volume.clone(), phases(3), &rules).unwrap();
            let mut m = Default::default();
            let mut path = [0.0; 3];
            let rays = 200_000;
            for i in 0..rays {
                let mut s = stream(i);
                let u2 = s.uniform();
                let (sin, cos) = (TAU * s.uniform()).sin_cos();
                let r = u2.sqrt();
                let dir = DVec3::new(r * cos, r * sin, -(1.0 - u2).sqrt()).normalize();
                let mut ray = Ray { origin: DVec3::Z * 48.0, dir };
                let start = u.enter(&ray, &mut m, &mut s);
                let (mut place, mut medium) = (start.place, start.medium);
                loop {
                    match u.next(&ray, &mut place, &mut m, f64::INFINITY, &mut s) {
                        Next::Interface(at) => {
                            path[usize::from(medium.0)] += at.distance;
                            ray.origin = ray.at(at.distance);
                            u.crossed(&mut ray, &mut place, &mut m, &at);
                            medium = at.beyond;
                        }
                        Next::Edge { distance, .. } => {
                            path[usize::from(medium.0)] += distance;
                            break;
                        }
                        _ => panic!(),
                    }
                }
            }
            for k in 0..3 {
                let want = 2.0 * 48.0 * counts[k] as f64 / n;
                let got = path[k] / rays as f64;
                println!("{lateral:?} {normals:?} medium {k}: {got:.3} um, expected {want:.3}");
                assert!((got / want - 1.0).abs() < 0.012, "{got} {want}");
            }
        }
    }
}

/// Noise, balls and a wall one voxel thick: every kind of corner.
fn rough_volume() -> Volume {
    let mut s = stream(77);
    voxelised([23, 17, 19], 1.0, |p| {
        let ball = (p - DVec3::new(2.0, 1.0, 9.0)).length() < 6.0;
        let wall = (p.x + 8.5).abs() < 0.6;
        let noise = s.uniform();
        if wall || noise < 0.03 {
            1
        } else if ball {
            2
        } else {
            u8::from(noise > 0.97) * 3
        }
    })
}

/// A direction of the hard kind: along axes, edges and diagonals, with components 0 and −0, or nearly so.
fn stressed(s: &mut Stream) -> DVec3 {
    let kind = s.uniform();
    if kind < 0.4 {
        return isotropic(s);
    }
    let pick = |s: &mut Stream| match (7.0 * s.uniform()) as u32 {
        0 => 0.0,
        1 => -0.0,
        2 => 1.0,
        3 => -1.0,
        4 => 1e-17,
        5 => -1e-300,
        _ => 1e-9,
    };
    let d = DVec3::new(pick(s), pick(s), pick(s));
    if d.length() < 1e-3 { -DVec3::Z } else { d.normalize() }
}

#[derive(Debug, Default)]
struct Tally {
    crossings: u64,
    edges: u64,
    lost: u64,
    wrong: u64,
    capped: u64,
}

/// Random events at every interface: mirrored, straight on, and anywhere on either side.
fn walk(u: &VoxelUniverse, history: u64, crossings: u64) -> Tally {
    let s = &mut stream(history);
    let mut m = Default::default();
    let mut t = Tally::default();
    while t.crossings < crossings {
        // On lattice points and planes, on the faces of the sheet, anywhere, and far off sideways.
        let whole = |s: &mut Stream, n: f64| (n * s.uniform()).floor();
        let mut origin = DVec3::new(whole(s, 23.0) - 11.5, whole(s, 17.0) - 8.5, whole(s, 20.0));
        if s.uniform() < 0.5 {
            origin += DVec3::new(s.uniform(), s.uniform(), s.uniform() - 0.5);
        }
        if s.uniform() < 0.1 {
            origin.x += 24_000.0;
        }
        let mut ray = Ray { origin, dir: stressed(s) };
        let start = u.enter(&ray, &mut m, s);
        let (mut place, mut medium) = (start.place, start.medium);
        for event in 0..2000 {
            t.capped += u64::from(event == 1999);
            let limit = if s.uniform() < 0.3 { 5.0 * s.exponential() } else { f64::INFINITY };
            let seen = u.next(&ray, &mut place, &mut m, limit, s);
            if s.uniform() < 0.1 {
                assert_eq!(
                    seen,
                    u.next(&ray, &mut place, &mut m, limit, s),
                    "asked twice, answered otherwise"
                );
            }
            t.wrong += u64::from(u.medium_in(&place) != medium);
            match seen {
                Next::Lost => {
                    t.lost += 1;
                    break;
                }
                Next::Edge { distance, .. } => {
                    t.edges += 1;
                    // A level ray in an endless wall, 2^20 voxels from the next face.
                    let endless = distance > 1e6;
                    t.wrong += u64::from((medium != AIR && !endless) || distance < 0.0);
                    break;
                }
                Next::Limit => {
                    // Also as far as part of the way, as forced scattering asks.
                    let d = if s.uniform() < 0.3 { limit * s.uniform() } else { limit };
                    ray = Ray { origin: ray.at(d), dir: stressed(s) };
                    u.moved(&ray, &mut place, &mut m, d);
                }
                Next::Interface(at) => {
                    t.crossings += 1;
                    let cos = -ray.dir.dot(at.normal);
                    assert!(at.distance >= 0.0 && at.distance <= limit, "{}", at.distance);
                    assert!(cos > 0.0 && (at.normal.length() - 1.0).abs() < 1e-14, "{cos} {:?}", at.normal);
                    assert!((at.facet.length() - 1.0).abs() < 1e-14 && -ray.dir.dot(at.facet) > 0.0);
                    assert!(at.beyond != medium);
                    let origin = ray.at(at.distance);
                    let side = |n: DVec3, d: DVec3| if d.dot(n) < 0.0 { d - n * (2.0 * d.dot(n)) } else { d };
                    if s.uniform() < 0.5 {
                        let mirrored = ray.dir + at.normal * (2.0 * cos);
                        let dir = if s.uniform() < 0.5 { mirrored } else { side(at.normal, stressed(s)) };
                        ray = Ray { origin, dir: side(at.facet, dir).normalize() };
                        u.reflected(&ray, &mut place, &mut m, &at);
                    } else {
                        let dir = if s.uniform() < 0.5 { ray.dir } else { side(-at.normal, stressed(s)) };
                        ray = Ray { origin, dir: side(-at.facet, dir) };
                        u.crossed(&mut ray, &mut place, &mut m, &at);
                        medium = at.beyond;
                    }
                }
            }
        }
    }
    t
}

fn stress(crossings: u64) {
    let cases = [
        (NormalRule::Smoothed(2.0), Steps::Passed, Lateral::Mirror),
        (NormalRule::Smoothed(1.0), Steps::Mirrored, Lateral::Periodic),
        (NormalRule::Faces, Steps::Passed, Lateral::Mirror),
    ];
    for (normals, steps, lateral) in cases {
        let rules = Rules { normals, steps, lateral, ..rules(1.0) };
        let u = VoxelUniverse::new(rough_volume(), phases(4), &rules).unwrap();
        let per = crossings / cases.len() as u64 / 2;
        let tallies: Vec<Tally> = std::thread::scope(|scope| {
            let u = &u;
            let threads: Vec<_> = (0..2).map(|k| scope.spawn(move || walk(u, 100 + k, per))).collect();
            threads.into_iter().map(|t| t.join().unwrap()).collect()
        });
        for t in tallies {
            println!("{normals:?} {steps:?} {lateral:?}: {t:?}");
            assert_eq!((t.lost, t.wrong), (0, 0));
            assert!(t.crossings >= per && t.edges > 0);
            assert!(t.capped < 1 + t.edges / 20, "{} rays do not leave", t.capped);
        }
    }
}

#[test]
fn a_million_stressed_crossings_lose_no_ray() {
    stress(1_000_000);
}

#[test]
#[ignore = "some ten minutes"]
fn a_hundred_million_stressed_crossings_lose_no_ray() {
    stress(100_000_000);
}

/// An axis-aligned slab is known exactly by its voxels: planes, distances and normals.
#[test]
fn a_slab_of_voxels_is_a_slab() {
    for normals in [NormalRule::Smoothed(2.0), NormalRule::Faces] {
        let volume = voxelised([5, 4, 10], 2.0, |p| u8::from(p.z > 4.0 && p.z < 16.0));
        let u = VoxelUniverse::new(volume, phases(2), &Rules { normals, ..rules(2.0) }).unwrap();
        let (mut m, mut s) = (Default::default(), stream(5));
        for _ in 0..1000 {
            let mut dir = isotropic(&mut s);
            dir.z = -dir.z.abs();
            let mut ray = Ray { origin: DVec3::new(s.uniform(), s.uniform(), 20.0), dir };
            let mut place = u.enter(&ray, &mut m, &mut s).place;
            for (plane, medium) in [(16.0, 1), (4.0, 0)] {
                let Next::Interface(at) = u.next(&ray, &mut place, &mut m, f64::INFINITY, &mut s) else {
                    panic!("nothing met")
                };
                let want = (plane - ray.origin.z) / dir.z;
                assert!((at.distance / want - 1.0).abs() < 1e-12 && at.beyond == MediumId(medium));
                assert!((at.normal - DVec3::Z).length() < 3e-6, "{:?}", at.normal);
                ray.origin = ray.at(at.distance);
                u.crossed(&mut ray, &mut place, &mut m, &at);
            }
            let end = u.next(&ray, &mut place, &mut m, f64::INFINITY, &mut s);
            assert!(matches!(end, Next::Edge { face: lightpro::universe::Face::Bottom, .. }), "{end:?}");
        }
    }
}
