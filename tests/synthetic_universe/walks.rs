//! Random walks among overlapping and nested bodies: no ray is lost, and the medium that a place
//! remembers is the medium that containment tells.

use super::*;

const REGION: f64 = 30.0;

/// 30 bodies in a box of ±30 µm: hollow fibres, spheres, ellipsoids, boxes, nested and overlapping,
/// with priorities, shared media and a rough surface here and there.
pub fn thirty_bodies() -> Vec<Part> {
    let mut s = stream(30);
    let mut parts = Vec::new();
    for body in 0..30_u32 {
        let centre = DVec3::new(s.uniform() - 0.5, s.uniform() - 0.5, s.uniform() - 0.5) * REGION;
        let size = 2.0 + 8.0 * s.uniform();
        let flat = 0.2 + 0.8 * s.uniform();
        let frame = random_frame(&mut s);
        let medium = 1 + (body % 5) as u16;
        let mut add = |shape: Placed, medium: u16| {
            let surface = SurfaceId((body % 3) as u16);
            let priority = (body % 4) as i32 - 1;
            parts.push(Part { surface, priority, ..part(shape, medium, body) });
        };
        match body % 5 {
            0 | 1 => {
                let long = (body % 2 == 0).then_some(3.0 * size);
                let wall = if body == 1 { 1e-9 * size } else { 0.3 * flat * size };
                add(cylinder(size, flat * size, long, centre, frame), medium);
                add(cylinder(size - wall, flat * size - wall, long, centre, frame), 0);
            }
            2 => {
                add(sphere(centre, size), medium);
                add(sphere(centre, 0.6 * size), 7);
                // Tangent from within, at the top.
                add(sphere(centre + DVec3::Z * (0.3 * size), 0.3 * size), 8);
            }
            3 => {
                let e = Ellipsoid { a: size, b: flat * size, c: 0.3 * size };
                add(Placed::new(Shape::Ellipsoid(e), centre, frame), medium);
            }
            _ => {
                let half = DVec3::new(size, flat * size, 0.5 * size);
                add(cuboid(centre - half, centre + half), medium);
                // Shares three faces with the first.
                add(cuboid(centre - half, centre), 9);
            }
        }
    }
    parts
}

/// Whether the medium at `p` is `medium`, or becomes so within 1e-9 µm.
fn medium_is(u: &SyntheticUniverse, p: DVec3, medium: MediumId) -> bool {
    if u.medium_at(p) == medium {
        return true;
    }
    let near = |i: i32| f64::from(i - 1) * 1e-9;
    (0..27).any(|k| u.medium_at(p + DVec3::new(near(k % 3), near(k / 3 % 3), near(k / 9))) == medium)
}

/// Steps, rays that escaped, least and total disagreement.
#[derive(Default, Debug)]
struct Tally {
    steps: u64,
    interfaces: u64,
    escaped: u64,
    lost: u64,
    wrong: u64,
    tilted: u64,
}

fn walk(u: &SyntheticUniverse, history: u64, steps: u64) -> Tally {
    let s = &mut stream(history);
    let mut t = Tally::default();
    while t.steps < steps {
        let dir = isotropic(s);
        let aim = DVec3::new(s.uniform() - 0.5, s.uniform() - 0.5, s.uniform() - 0.5) * REGION;
        // One history in eight starts anywhere, in whatever is there.
        let back = if s.uniform() < 0.125 { 0.0 } else { 10.0 * REGION };
        let mut ray = Ray { origin: aim - dir * back, dir };
        let start = u.enter(&ray, &mut (), s);
        let (mut place, mut medium) = (start.place, start.medium);
        for _ in 0..2000 {
            t.steps += 1;
            let limit = if s.uniform() < 0.3 { 5.0 * s.exponential() } else { f64::INFINITY };
            let seen = u.next(&ray, &mut place, &mut (), limit, s);
            if s.uniform() < 0.05 {
                assert_eq!(
                    seen,
                    u.next(&ray, &mut place, &mut (), limit, s),
                    "asked twice, answered otherwise"
                );
            }
            t.wrong += u64::from(u.medium(&place) != medium);
            match seen {
                Next::Lost => {
                    t.lost += 1;
                    break;
                }
                Next::Edge { .. } => {
                    t.escaped += 1;
                    t.wrong += u64::from(medium != AIR);
                    break;
                }
                Next::Limit => {
                    t.wrong += u64::from(!medium_is(u, ray.at(0.5 * limit), medium));
                    ray = Ray { origin: ray.at(limit), dir: isotropic(s) };
                    u.moved(&ray, &mut place, &mut (), limit);
                }
                Next::Interface(at) => {
                    t.interfaces += 1;
                    t.wrong += u64::from(!medium_is(u, ray.at(0.5 * at.distance), medium));
                    let cos = -ray.dir.dot(at.normal);
                    t.tilted += u64::from(cos < 0.0 || (at.normal.length() - 1.0).abs() > 1e-15);
                    assert!(at.distance >= 0.0 && at.distance <= limit);
                    let point = ray.at(at.distance);
                    if s.uniform() < 0.4 {
                        // Half of them as a mirror, half anywhere on the side of the normal.
                        let mirrored = ray.dir + at.normal * (2.0 * cos);
                        let dir = if s.uniform() < 0.5 { mirrored } else { upward(at.normal, s) };
                        ray = Ray { origin: point, dir: dir.normalize() };
                        u.reflected(&ray, &mut place, &mut (), &at);
                    } else {
                        let dir = if s.uniform() < 0.5 { ray.dir } else { upward(-at.normal, s) };
                        ray = Ray { origin: point, dir };
                        u.crossed(&mut ray, &mut place, &mut (), &at);
                        medium = at.beyond;
                    }
                }
            }
        }
    }
    t
}

/// Isotropic on the side of `n`.
fn upward(n: DVec3, s: &mut Stream) -> DVec3 {
    let d = isotropic(s);
    if d.dot(n) < 0.0 { -d } else { d }
}

#[test]
fn ten_million_steps_lose_no_ray() {
    let u = universe(thirty_bodies());
    let tallies: Vec<Tally> = std::thread::scope(|scope| {
        let u = &u;
        let threads: Vec<_> = (0..4).map(|k| scope.spawn(move || walk(u, 1000 + k, 2_500_000))).collect();
        threads.into_iter().map(|t| t.join().unwrap()).collect()
    });
    println!("{tallies:#?}");
    assert!(tallies.iter().map(|t| t.steps).sum::<u64>() >= 10_000_000);
    assert!(tallies.iter().map(|t| t.escaped).sum::<u64>() > 10_000);
    for t in &tallies {
        assert_eq!((t.lost, t.wrong, t.tilted), (0, 0, 0));
    }
}

/// The check above sees a universe whose bodies differ by a hair from those that the ray walks.
#[test]
fn the_walk_notices_a_body_that_is_elsewhere() {
    let u = universe(thirty_bodies());
    let mut moved = thirty_bodies();
    moved.iter_mut().for_each(|p| p.shape.centre += DVec3::X * 1e-3);
    let other = universe(moved);
    let s = &mut stream(3);
    let mut wrong = 0;
    for _ in 0..200_000 {
        let r = Ray { origin: isotropic(s) * 100.0, dir: DVec3::ZERO };
        let aim = DVec3::new(s.uniform() - 0.5, s.uniform() - 0.5, s.uniform() - 0.5) * REGION;
        let mut r = Ray { dir: (aim - r.origin).normalize(), ..r };
        let mut place = u.enter(&r, &mut (), s).place;
        while let Next::Interface(at) = u.next(&r, &mut place, &mut (), f64::INFINITY, s) {
            wrong += usize::from(!medium_is(&other, r.at(0.5 * at.distance), u.medium(&place)));
            r.origin = r.at(at.distance);
            u.crossed(&mut r, &mut place, &mut (), &at);
        }
    }
    assert!(wrong > 10, "{wrong}");
}

/// One walk of the scene with all lengths × `scale`: distances and normals, bit by bit.
fn trace(scale: f64) -> Vec<[u64; 4]> {
    let parts = thirty_bodies()
        .into_iter()
        .map(|p| {
            let shape = match p.shape.shape {
                Shape::Cylinder(c) => Shape::Cylinder(EllipticCylinder {
                    a: c.a * scale,
                    b: c.b * scale,
                    half_length: c.half_length.map(|h| h * scale),
                }),
                Shape::Ellipsoid(e) => {
                    Shape::Ellipsoid(Ellipsoid { a: e.a * scale, b: e.b * scale, c: e.c * scale })
                }
                Shape::Cuboid(b) => Shape::Cuboid(Cuboid { min: b.min * scale, max: b.max * scale }),
                other => other,
            };
            Part { shape: Placed::new(shape, p.shape.centre * scale, p.shape.frame), ..p }
        })
        .collect();
    let u = universe(parts);
    let s = &mut stream(99);
    let mut bits = Vec::new();
    for _ in 0..2000 {
        let mut ray = Ray { origin: isotropic(s) * (REGION * scale), dir: isotropic(s) };
        let mut place = u.enter(&ray, &mut (), s).place;
        for _ in 0..50 {
            let Next::Interface(at) = u.next(&ray, &mut place, &mut (), 100.0 * scale, s) else { break };
            bits.push([
                (at.distance / scale).to_bits(),
                at.normal.x.to_bits(),
                at.normal.y.to_bits(),
                at.normal.z.to_bits() ^ u64::from(at.beyond.0),
            ]);
            ray.origin = ray.at(at.distance);
            if s.uniform() < 0.4 {
                ray.dir = upward(at.normal, s);
                u.reflected(&ray, &mut place, &mut (), &at);
            } else {
                u.crossed(&mut ray, &mut place, &mut (), &at);
            }
        }
    }
    bits
}

#[test]
fn powers_of_two_change_no_bit() {
    let one = trace(1.0);
    assert!(one.len() > 5000, "{}", one.len());
    for power in [-20, -7, 20] {
        assert!(one == trace(f64::powi(2.0, power)), "scale 2^{power}");
    }
}
