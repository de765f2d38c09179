//! Cases where a careless ray test goes wrong.

use super::*;
use lightpro::universe::Face;
use lightpro::universe::shape::{Convex, HalfSpace};
use lightpro::universe::synthetic::{CAPACITY, Error};

fn media(met: &[(f64, Interface)]) -> Vec<u16> {
    met.iter().map(|(_, at)| at.beyond.0).collect()
}

/// Distance from the surface x²/a² + y²/b² (+ z²/c²) = 1, first order.
fn off_surface(p: DVec3, half: DVec3) -> f64 {
    let q = p / half;
    ((q.length_squared() - 1.0) / (2.0 * (q / half).length())).abs()
}

#[test]
fn hits_stay_on_the_surface_a_million_radii_away() {
    let mut s = stream(1);
    let (mut worst, mut worst_far) = (0.0_f64, 0.0_f64);
    for i in 0..200_000 {
        let (a, b, c) = (1.0, 0.2 + s.uniform(), 0.3 + s.uniform());
        let frame = random_frame(&mut s);
        let far = if i % 2 == 0 { 1e6 } else { 1e8 };
        // Shifted as well: the whole scene stands a million radii from the origin.
        let centre = isotropic(&mut s) * if i % 4 < 2 { 0.0 } else { far };
        let fibre = i % 3 == 0;
        let half = DVec3::new(a, b, if fibre { f64::INFINITY } else { c });
        let shape = if fibre {
            Shape::Cylinder(EllipticCylinder { a, b, half_length: None })
        } else {
            Shape::Ellipsoid(Ellipsoid { a, b, c })
        };
        let placed = Placed::new(shape, centre, frame);
        let dir = isotropic(&mut s);
        let aim = centre + isotropic(&mut s) * (0.15 * s.uniform());
        let ray = Ray { origin: aim - dir * far, dir };
        let met = straight(&universe(vec![part(placed, 1, 0)]), ray);
        if fibre && met.len() != 2 {
            continue; // nearly along the axis
        }
        assert_eq!(media(&met), [1, 0]);
        let at = ray.at(met[0].0);
        let off = off_surface(frame.to_local(at - centre), half);
        let slot = if far == 1e6 { &mut worst } else { &mut worst_far };
        *slot = slot.max(off);
        assert!(met[1].1.distance > 0.0);
    }
    println!("off the surface by {worst:.1e} radii at 1e6, {worst_far:.1e} at 1e8");
    assert!(worst < 1e-8 && worst_far < 1e-6);
}

#[test]
fn a_wall_of_a_billionth_of_the_radius_is_crossed_twice() {
    for far in [3.0, 1e6] {
        for (dx, dy) in [(1.0, 0.0), (0.6, 0.8), (0.0, -1.0)] {
            let f = WORLD;
            let u = universe(vec![
                part(cylinder(1.0, 1.0, None, DVec3::ZERO, f), 1, 0),
                part(cylinder(1.0 - 1e-9, 1.0 - 1e-9, None, DVec3::ZERO, f), 2, 0),
            ]);
            let met = straight(&u, ray([-dx * far, -dy * far, 0.0], [dx, dy, 0.0]));
            assert_eq!(media(&met), [1, 2, 1, 0]);
            let off = 4e-16 * far;
            assert!((met[1].1.distance - 1e-9).abs() < off && (met[3].1.distance - 1e-9).abs() < 1e-15);
            assert!((met[2].1.distance - 2.0).abs() < 1e-8);
        }
    }
}

#[test]
fn rays_along_the_axis() {
    let lumen = |half| {
        universe(vec![
            part(cylinder(2.0, 1.0, half, DVec3::ZERO, WORLD), 1, 0),
            part(cylinder(1.0, 0.5, half, DVec3::ZERO, WORLD), 2, 0),
        ])
    };
    for zero in [0.0, -0.0, 1e-200] {
        // Unbounded: in wall or lumen for ever, or never in it.
        for x in [0.0, 1.5, 3.0] {
            let u = lumen(None);
            let r = ray([x, 0.0, 5.0], [zero, zero, -1.0]);
            assert!(straight(&u, r).is_empty());
            let start = u.enter(&r, &mut (), &mut stream(0));
            assert_eq!(start.medium.0, [2, 1, 0][(x / 1.5) as usize]);
            let end = u.next(&r, &mut { start.place }, &mut (), f64::INFINITY, &mut stream(0));
            assert_eq!(end, Next::Edge { face: Face::Bottom, distance: f64::INFINITY });
        }
        // Bounded: through the end of the wall, or through the open end of the lumen, where no wall
        // of zero thickness stands.
        for (x, medium) in [(1.5, 1), (0.2, 2)] {
            let met = straight(&lumen(Some(4.0)), ray([x, zero, 9.0], [zero, -zero, -1.0]));
            assert_eq!(media(&met), [medium, 0]);
            assert_eq!((met[0].0, met[1].0), (5.0, 13.0));
            assert_eq!((met[0].1.normal, met[1].1.normal), (DVec3::Z, DVec3::Z));
            assert_eq!(met[0].1.axis, DVec3::Z);
        }
        // Along the side exactly: tangent, no hit.
        assert!(straight(&lumen(Some(4.0)), ray([2.0, 3.0, 1.0], [zero, -1.0, zero])).is_empty());
    }
}

#[test]
fn zero_and_collapsed_lumens_hold_nothing() {
    for (a, b) in [(0.0, 0.0), (1.0, 0.0)] {
        let u = universe(vec![
            part(cylinder(2.0, 1.0, None, DVec3::ZERO, WORLD), 1, 0),
            part(cylinder(a, b, None, DVec3::ZERO, WORLD), 2, 0),
        ]);
        assert_eq!(media(&straight(&u, ray([-5.0, 0.0, 0.0], [1.0, 0.0, 0.0]))), [1, 0]);
        assert_eq!(u.medium_at(DVec3::ZERO).0, 1);
    }
}

#[test]
fn layers_in_contact_have_no_film_between() {
    // Planes at numbers that are no dyadic fractions; each layer once above the other in priority.
    for swap in [false, true] {
        let mut parts = vec![part(slab(0.1, 0.7), 1, 0), part(slab(0.7, 1.9), 2, 1)];
        if swap {
            parts.reverse();
        }
        let u = universe(parts);
        for k in 0..1000 {
            let dir = DVec3::new(0.3 + 0.01 * f64::from(k), 0.2, -1.0).normalize();
            let down = Ray { origin: DVec3::new(0.4, 0.3, 5.0 + 0.001 * f64::from(k)), dir };
            let met = straight(&u, down);
            assert_eq!(media(&met), [2, 1, 0]);
            let first = met[0].1;
            assert_eq!(first.distance.to_bits(), ((1.9 - down.origin.z) / dir.z).to_bits());
            let z = down.at(first.distance).z;
            assert_eq!(met[1].1.distance.to_bits(), ((0.7 - z) / dir.z).to_bits());
            // The same surface from below.
            let up = straight(&u, Ray { origin: DVec3::ZERO, dir: -dir });
            assert_eq!(media(&up), [1, 2, 0]);
            assert_eq!((up[1].1.body, up[1].1.normal), (met[1].1.body, -DVec3::Z));
        }
    }
    // Three boxes in a row along x, sharing faces.
    let u = universe(
        [(0.1, 0.3), (0.3, 0.7), (0.7, 0.9)]
            .into_iter()
            .enumerate()
            .map(|(i, (lo, hi))| {
                part(cuboid(DVec3::new(lo, 0.0, 0.0), DVec3::new(hi, 1.0, 1.0)), 1 + i as u16, i as u32)
            })
            .collect(),
    );
    let r = Ray { origin: DVec3::new(-3.0, 0.2, 0.3), dir: DVec3::new(1.0, 0.1, 0.05).normalize() };
    assert_eq!(media(&straight(&u, r)), [1, 2, 3, 0]);
}

#[test]
fn tangent_and_equal_bodies() {
    // Equal spheres: the later rules, the earlier is buried from all sides.
    let u = universe(vec![part(sphere(DVec3::ZERO, 1.3), 1, 0), part(sphere(DVec3::ZERO, 1.3), 2, 1)]);
    let mut s = stream(8);
    for _ in 0..1000 {
        let dir = isotropic(&mut s);
        let r = Ray { origin: isotropic(&mut s) * 0.4 - dir * 7.0, dir };
        let met = straight(&u, r);
        assert_eq!(media(&met), [2, 0]);
        assert_eq!(met[0].1.body, BodyId(1));
    }
    // Spheres that touch in one point, ray through that point: out of one, into the other.
    let u = universe(vec![part(sphere(DVec3::X, 1.0), 1, 0), part(sphere(-DVec3::X, 1.0), 2, 1)]);
    let met = straight(&u, ray([5.0, 0.0, 0.0], [-1.0, 0.0, 0.0]));
    assert_eq!(media(&met), [1, 2, 0]);
    // Ray in the common tangent plane: touches both, meets none.
    assert!(straight(&u, ray([0.0, 5.0, 0.0], [-0.0, -1.0, 0.0])).is_empty());
    // Ball tangent from within.
    let u = universe(vec![part(sphere(DVec3::ZERO, 2.0), 1, 0), part(sphere(DVec3::Z, 1.0), 2, 1)]);
    let met = straight(&u, ray([0.0, 0.0, 9.0], [0.0, 0.0, -1.0]));
    assert_eq!(media(&met), [2, 1, 0]);
    assert_eq!(met.iter().map(|m| m.0).collect::<Vec<_>>(), [7.0, 9.0, 11.0]);
}

#[test]
fn overlaps_of_one_medium_hide_their_smooth_surfaces() {
    let two = |surface| {
        let mut b = part(sphere(DVec3::X, 1.5), 1, 1);
        b.surface = SurfaceId(surface);
        universe(vec![part(sphere(-DVec3::X, 1.5), 1, 0), b])
    };
    let r = ray([-9.0, 0.1, 0.0], [1.0, 0.0, 0.0]);
    let smooth = straight(&two(0), r);
    assert_eq!(media(&smooth), [1, 0]);
    assert_eq!((smooth[0].1.body, smooth[1].1.body), (BodyId(0), BodyId(1)));
    // A surface law of its own makes an event of the entry into the later body.
    assert_eq!(media(&straight(&two(1), r)), [1, 1, 0]);
    // Scattered between buried surfaces the ray still knows where it is.
    let u = two(0);
    let mut s = stream(12);
    let mut at = ray([-2.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    let mut place = u.enter(&at, &mut (), &mut s).place;
    assert_eq!(u.next(&at, &mut place, &mut (), 3.5, &mut s), Next::Limit);
    at = ray([1.5, 0.0, 0.0], [0.0, 1.0, 0.0]);
    u.moved(&at, &mut place, &mut (), 3.5);
    let Next::Interface(out) = u.next(&at, &mut place, &mut (), f64::INFINITY, &mut s) else { panic!() };
    assert!((out.distance - 2.0_f64.sqrt()).abs() < 1e-15 && out.beyond == AIR);
}

#[test]
fn starts_on_a_surface_go_where_they_look() {
    let u = universe(vec![part(sphere(DVec3::new(0.0, 0.0, -2.0), 3.0), 1, 0)]);
    let s = &mut stream(2);
    let pole = [0.0, 0.0, 1.0];
    assert_eq!(u.enter(&ray(pole, [0.0, 0.0, -1.0]), &mut (), s).medium.0, 1);
    assert_eq!(u.enter(&ray(pole, [0.0, -0.0, 1.0]), &mut (), s).medium, AIR);
    assert_eq!(u.enter(&ray(pole, [0.6, 0.0, 0.8]), &mut (), s).medium, AIR);
    assert_eq!(u.enter(&ray(pole, [0.6, 0.0, -0.8]), &mut (), s).medium.0, 1);
    assert!(straight(&u, ray(pole, [0.6, 0.0, 0.8])).is_empty());
    assert_eq!(media(&straight(&u, ray(pole, [0.6, 0.0, -0.8]))), [0]);
}

/// A mirrored ray inside a sphere stays there, on the surface, for a million reflections, grazing
/// too. Positions are rounded to ε: an angle θ gathers noise ε/θ per reflection, and below θ = √ε,
/// where the arc rises above its chord by less than an ulp, rounding carries the point along the
/// tangent (off by x²/2 after a way x of at most 2·10⁶ θ); the state holds it inside all the same.
#[test]
fn whispering_rays_stay() {
    let u = universe(vec![part(sphere(DVec3::ZERO, 1.0), 1, 0)]);
    let s = &mut stream(2);
    for grazing in [0.5_f64, 1e-3, 1e-6, 1e-9] {
        let mut r = ray([0.0, 0.0, 1.0], [grazing.cos(), 0.0, -grazing.sin()]);
        let mut place = u.enter(&r, &mut (), s).place;
        let (mut drift, mut angle) = (0.0_f64, 0.0_f64);
        for _ in 0..1_000_000 {
            let Next::Interface(at) = u.next(&r, &mut place, &mut (), f64::INFINITY, s) else {
                panic!("lost")
            };
            let cos = -r.dir.dot(at.normal);
            assert!(cos >= 0.0 && at.beyond == AIR);
            r.origin = r.at(at.distance);
            r.dir = (r.dir + at.normal * (2.0 * cos)).normalize();
            u.reflected(&r, &mut place, &mut (), &at);
            drift = drift.max((r.origin.length() - 1.0).abs());
            angle = angle.max((cos / grazing.sin() - 1.0).abs());
        }
        println!("grazing {grazing}: off the surface {drift:.1e}, angle off by {angle:.1e} relative");
        if grazing > f64::EPSILON.sqrt() {
            assert!(drift < 1e-15 && angle < 1e3 * f64::EPSILON / (grazing * grazing) + 1e-9);
        } else {
            assert!(drift < 0.5 * (2e6 * grazing).powi(2));
        }
    }
}

#[test]
fn half_spaces_and_edges() {
    let n = DVec3::new(0.0, 0.6, 0.8);
    let plane = Placed::new(Shape::HalfSpace(HalfSpace), n * 2.0, Frame::from_pole(n));
    let u = universe(vec![part(plane, 1, 0)]);
    let met = straight(&u, Ray { origin: n * 10.0, dir: -n });
    assert_eq!(media(&met), [1]);
    assert!((met[0].0 - 8.0).abs() < 1e-14 && (met[0].1.normal - n).length() < 1e-15);
    assert_eq!(media(&straight(&u, Ray { origin: -n * 10.0, dir: n })), [0]);
    assert!(straight(&u, Ray { origin: n * 10.0, dir: DVec3::X }).is_empty());
    assert!(straight(&u, Ray { origin: n * 10.0, dir: n }).is_empty());
    let s = &mut stream(0);
    for (z, face) in [(1.0, Face::Top), (0.0, Face::Top), (-0.0, Face::Top), (-1.0, Face::Bottom)] {
        let r = ray([0.0, 50.0, 50.0], [(1.0_f64 - z * z).sqrt(), 0.0, z]);
        let r = if z < 0.0 { Ray { origin: -r.origin, ..r } } else { r };
        let mut place = u.enter(&r, &mut (), s).place;
        assert_eq!(u.next(&r, &mut place, &mut (), 1e9, s), Next::Limit);
        assert_eq!(
            u.next(&r, &mut place, &mut (), f64::INFINITY, s),
            Next::Edge { face, distance: f64::INFINITY }
        );
    }
    // A slab seen in its plane, from outside and from inside, has no end.
    let u = universe(vec![part(slab(0.0, 1.0), 1, 0)]);
    for z in [-0.5, 0.5, 1.5] {
        assert!(straight(&u, ray([0.0, 0.0, z], [1.0, 0.0, -0.0])).is_empty());
        assert!(straight(&u, ray([0.0, 0.0, z], [1.0, 0.0, 1e-320])).len() < 2);
    }
}

#[test]
fn too_deep_is_lost_not_wrong() {
    let balls =
        |n: usize| universe((0..n).map(|i| part(sphere(DVec3::ZERO, 1.0 + i as f64), 1, 0)).rev().collect());
    let s = &mut stream(0);
    let r = ray([0.0, 0.0, 99.0], [0.0, 0.0, -1.0]);
    assert_eq!(straight(&balls(CAPACITY), r).len(), 2);
    let u = balls(CAPACITY + 1);
    let mut place = u.enter(&r, &mut (), s).place;
    let Next::Interface(at) = u.next(&r, &mut place, &mut (), f64::INFINITY, s) else { panic!() };
    let mut inside = Ray { origin: r.at(at.distance), ..r };
    u.crossed(&mut inside, &mut place, &mut (), &at);
    assert_eq!(u.next(&inside, &mut place, &mut (), f64::INFINITY, s), Next::Lost);
    let mut place = u.enter(&ray([0.0; 3], [0.0, 0.0, 1.0]), &mut (), s).place;
    assert!(place.is_lost());
    assert_eq!(u.next(&ray([0.0; 3], [0.0, 0.0, 1.0]), &mut place, &mut (), 1.0, s), Next::Lost);
    let nan = ray([f64::NAN, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let mut place = u.enter(&nan, &mut (), s).place;
    assert_eq!(u.next(&nan, &mut place, &mut (), 1.0, s), Next::Lost);
}

#[test]
fn parts_that_make_no_sense_are_refused() {
    let skew = Frame { x: DVec3::X, y: DVec3::new(0.1, 1.0, 0.0), z: DVec3::Z };
    for (shape, error) in [
        (sphere(DVec3::ZERO, -1.0), Error::Size(1)),
        (sphere(DVec3::ZERO, f64::NAN), Error::Size(1)),
        (sphere(DVec3::X * f64::INFINITY, 1.0), Error::Size(1)),
        (slab(1.0, 0.0), Error::Size(1)),
        (cuboid(DVec3::ZERO, DVec3::new(1.0, f64::INFINITY, 1.0)), Error::Size(1)),
        (cylinder(1.0, 1.0, Some(f64::NAN), DVec3::ZERO, WORLD), Error::Size(1)),
        (cylinder(1.0, 1.0, None, DVec3::ZERO, skew), Error::Frame(1)),
    ] {
        let parts = vec![part(sphere(DVec3::ZERO, 1.0), 1, 0), part(shape, 1, 1)];
        assert_eq!(SyntheticUniverse::new(AIR, parts).unwrap_err(), error);
    }
}

/// The shapes themselves: a state is obeyed even where the point contradicts it by rounding.
#[test]
fn states_outrank_rounding() {
    let shapes = [
        Shape::Cylinder(EllipticCylinder { a: 2.0, b: 1.0, half_length: None }),
        Shape::Cylinder(EllipticCylinder { a: 2.0, b: 1.0, half_length: Some(50.0) }),
        Shape::Ellipsoid(Ellipsoid { a: 2.0, b: 1.0, c: 3.0 }),
        Shape::Cuboid(Cuboid::centred(DVec3::new(2.0, 1.0, 3.0))),
    ];
    for shape in shapes {
        for off in [-1e-12, -1e-15, 0.0, 1e-15, 1e-12] {
            let p = DVec3::new(2.0 + off, 0.0, 0.0);
            for d in [DVec3::X, DVec3::new(0.6, 0.8, 0.0), DVec3::new(1e-3, 1.0, 0.0).normalize()] {
                // Going out: left behind from outside, left at once from inside.
                assert_eq!(shape.entry(p, d, true), None);
                assert_eq!(shape.entry(p, d, false), None, "{shape:?} {off} {d}");
                let hit = shape.exit(p, d);
                assert!(hit.t <= 1e-8 && hit.normal.dot(d) > 0.0, "{shape:?} {off} {d} {hit:?}");
                // Going in: met at once from outside, crossed wholly from inside.
                let hit = shape.entry(p, -d, false).unwrap();
                assert!(hit.t <= 1e-8 && hit.normal.dot(-d) < 0.0, "{shape:?} {off} {d} {hit:?}");
                let across = shape.exit(p, -d);
                assert!(across.t > 1e-4 && across.t < 5.0, "{shape:?} {off} {d} {across:?}");
                assert_eq!(shape.entry(p, -d, true), None);
                assert_eq!(shape.span(p, d).map(|s| s.0 < s.1), Some(true));
            }
        }
    }
}

/// An open fibre: its lumen ends where it does. A ray in the wall is reflected at the end so flatly that
/// rounding has it behind the end for longer than its way to the lumen: it meets the lumen's side, where
/// that is, and not its end.
#[test]
fn rays_that_slide_along_an_open_end_meet_the_lumen() {
    let s = &mut stream(12);
    let (outer, inner, half) = (10.0, 7.3, 200.0);
    let mut behind = 0;
    for _ in 0..20_000 {
        let frame = random_frame(s);
        let at = DVec3::new(s.uniform(), s.uniform(), s.uniform()) * 1000.0;
        let wall = part(cylinder(outer, outer, Some(half), at, frame), 1, 0);
        let lumen = part(cylinder(inner, inner, Some(half), at, frame), 0, 0);
        let u = universe(vec![wall, lumen]);
        let turn = TAU * s.uniform();
        let out = frame.x * turn.cos() + frame.y * turn.sin();
        let gap = 10_f64.powf(-3.0 * s.uniform());
        let origin = at + out * (inner + gap) + frame.z * (half - 0.5);
        let ray = Ray { origin, dir: frame.z };
        let mut place = u.enter(&ray, &mut (), s).place;
        let Next::Interface(end) = u.next(&ray, &mut place, &mut (), f64::INFINITY, s) else { panic!() };
        assert!((end.distance - 0.5).abs() < 1e-9 && (end.normal + frame.z).length() < 1e-12);
        let dir = (end.normal * 10_f64.powf(-7.0 - 7.0 * s.uniform()) - out).normalize();
        let ray = Ray { origin: ray.at(end.distance), dir };
        behind += u32::from((ray.origin - at).dot(frame.z) > half);
        u.reflected(&ray, &mut place, &mut (), &end);
        let Next::Interface(met) = u.next(&ray, &mut place, &mut (), f64::INFINITY, s) else { panic!() };
        assert!((met.distance - gap).abs() < 1e-9, "{} instead of {gap}", met.distance);
        assert!((met.normal - out).length() < 1e-9 && met.beyond == AIR, "{met:?}");
    }
    assert!(behind > 1000, "rounding has put {behind} rays behind the end");
}
