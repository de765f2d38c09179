//! Slanted cylinders: hits against bisection and against straight ones, joints that are no interfaces.

use super::*;
use lightpro::universe::Overlap;
use lightpro::universe::shape::{Convex, SlantedCylinder};
use lightpro::universe::synthetic::Setting;

fn some(s: &mut Stream) -> SlantedCylinder {
    let a = 1.0 + 10.0 * s.uniform();
    let from = 20.0 * (s.uniform() - 0.5);
    SlantedCylinder {
        a,
        b: a * (0.1 + 0.9 * s.uniform()),
        from,
        to: from + 1.0 + 20.0 * s.uniform(),
        height: 10.0 * (s.uniform() - 0.5),
        slope: 2.0 * (s.uniform() - 0.5),
    }
}

/// ≤ 0 inside; convex.
fn level(c: &SlantedCylinder, p: DVec3) -> f64 {
    let y = p.y - (c.height + c.slope * (p.z - c.from));
    let side = ((p.x / c.a).powi(2) + (y / c.b).powi(2)).sqrt() - 1.0;
    side.max(c.from - p.z).max(p.z - c.to)
}

/// A point inside and the two crossings by bisection.
fn bisect(c: &SlantedCylinder, o: DVec3, d: DVec3, inside: f64, step: f64) -> f64 {
    let (mut lo, mut hi) = (inside, inside + step);
    while level(c, o + d * hi) <= 0.0 {
        hi += step;
    }
    for _ in 0..200 {
        let mid = 0.5 * (lo + hi);
        if level(c, o + d * mid) <= 0.0 { lo = mid } else { hi = mid }
    }
    0.5 * (lo + hi)
}

#[test]
fn hits_are_those_of_bisection() {
    let s = &mut stream(1);
    let (mut worst, mut worst_normal) = (0.0_f64, 0.0_f64);
    for _ in 0..20_000 {
        let c = some(s);
        let z = c.from + (c.to - c.from) * s.uniform();
        let (r, phi) = (0.99 * s.uniform().sqrt(), TAU * s.uniform());
        let p = DVec3::new(c.a * r * phi.cos(), c.centre(z) + c.b * r * phi.sin(), z);
        let d = isotropic(s);
        let o = p - d * 40.0;
        let chord = c.chord(o, d).unwrap();
        let want = [bisect(&c, o, d, 40.0, -1.0), bisect(&c, o, d, 40.0, 1.0)];
        worst = worst.max((chord.t_in - want[0]).abs()).max((chord.t_out - want[1]).abs());
        let (t, face) = c.way_out(p, d);
        worst = worst.max((t + 40.0 - want[1]).abs());
        assert_eq!(face, chord.face_out);
        assert!(c.contains(p) && c.starts_inside(p, d) && !c.contains(o + d * (chord.t_in - 1e-6)));
        // The normal by differences of the implicit function, where no edge is near.
        let at = o + d * chord.t_in;
        let n = c.normal(at, chord.face_in);
        let (h, f) = (1e-6, |q| level(&c, q));
        let g = DVec3::new(
            f(at + DVec3::X * h) - f(at - DVec3::X * h),
            f(at + DVec3::Y * h) - f(at - DVec3::Y * h),
            f(at + DVec3::Z * h) - f(at - DVec3::Z * h),
        );
        if at.z - c.from > 1e-3 && c.to - at.z > 1e-3 {
            worst_normal = worst_normal.max((g.normalize() - n).length());
        }
        assert!((n.length() - 1.0).abs() < 1e-15 && n.dot(d) <= 0.0);
    }
    println!("worst hit {worst:.1e} um, worst normal {worst_normal:.1e}");
    assert!(worst < 3e-13 * 50.0 && worst_normal < 1e-7, "{worst} {worst_normal}");
}

/// Level, it is the straight cylinder: the same bits.
#[test]
fn a_level_one_is_straight() {
    let s = &mut stream(2);
    let mut met = 0;
    for _ in 0..20_000 {
        let h = 1.0 + 10.0 * s.uniform();
        let c = SlantedCylinder { from: -h, to: h, height: 0.0, slope: 0.0, ..some(s) };
        let e = EllipticCylinder { a: c.a, b: c.b, half_length: Some(h) };
        let o = isotropic(s) * 30.0;
        let d = (isotropic(s) * 6.0 - o).normalize();
        assert_eq!(c.chord(o, d), e.chord(o, d));
        assert_eq!(c.way_out(o, d), e.way_out(o, d));
        if let (Some(x), Some(y)) = (c.entry(o, d, false), e.entry(o, d, false)) {
            assert_eq!(x, y);
            met += 1;
        }
    }
    assert!(met > 1000);
}

/// Volume by sampling; the surface by the mean chord of isotropic lines, 4V/S (Cauchy).
#[test]
fn volume_and_surface() {
    let s = &mut stream(3);
    let c = SlantedCylinder { a: 3.0, b: 1.0, from: 0.0, to: 5.0, height: 1.0, slope: 0.8 };
    let (mut n, mut chords) = (0.0, 0.0);
    let middle = DVec3::new(0.0, 3.0, 2.5);
    for _ in 0..400_000 {
        let d = isotropic(s);
        let f = Frame::from_pole(d);
        let (x, y) = (10.0 * (s.uniform() - 0.5), 10.0 * (s.uniform() - 0.5));
        if let Some((lo, hi)) = c.span(middle + f.x * x + f.y * y - d * 20.0, d) {
            (n, chords) = (n + 1.0, chords + hi - lo);
        }
    }
    let area = n / 400_000.0 * 100.0 * 4.0; // S = 4 × mean shadow
    let volume = chords / 400_000.0 * 100.0;
    let surface = c.side_area() + 2.0 * std::f64::consts::PI * c.a * c.b;
    assert!((volume / c.volume() - 1.0).abs() < 0.01, "{volume} {}", c.volume());
    assert!((area / surface - 1.0).abs() < 0.01, "{area} {surface}");
}

/// A hollow fibre cut into pieces of given slopes.
fn chain(knots: &[(f64, f64)], placed: (DVec3, Frame), body: u32) -> Vec<Part> {
    let mut parts = Vec::new();
    for k in knots.windows(2) {
        for (a, b, medium) in [(6.0, 2.5, 1), (4.0, 0.5, 0)] {
            let piece = SlantedCylinder::between(a, b, k[0], k[1]);
            parts.push(part(Placed::new(Shape::Slanted(piece), placed.0, placed.1), medium, body));
        }
    }
    parts
}

fn merged(parts: Vec<Part>) -> SyntheticUniverse {
    let setting = Setting { overlap: Overlap::Union, ..Setting::default() };
    SyntheticUniverse::with(AIR, parts, setting).unwrap()
}

/// Cut into ten pieces, a straight fibre has the same interfaces.
#[test]
fn a_cut_fibre_has_no_more_interfaces() {
    let s = &mut stream(4);
    let frame = random_frame(s);
    let placed = (DVec3::new(1.0, -2.0, 3.0), frame);
    let at = |z: f64| (z, 0.3 * z);
    let whole = merged(chain(&[at(-50.0), at(50.0)], placed, 7));
    let cut: Vec<(f64, f64)> = (0..=10).map(|i| at(-50.0 + 10.0 * f64::from(i))).collect();
    let cut = merged(chain(&cut, placed, 7));
    let (mut worst, mut count) = (0.0_f64, 0);
    for _ in 0..20_000 {
        let z = 90.0 * (s.uniform() - 0.5);
        let p = placed.0 + frame.to_world(DVec3::new(8.0 * (s.uniform() - 0.5), 0.3 * z, z));
        // Half of them nearly along the fibre.
        let d = if s.uniform() < 0.5 {
            isotropic(s)
        } else {
            (isotropic(s) * 0.1 + frame.to_world(DVec3::new(0.0, 0.3, 1.0))).normalize()
        };
        let r = Ray { origin: p - d * 300.0, dir: d };
        let (one, ten) = (straight(&whole, r), straight(&cut, r));
        assert_eq!(one.len(), ten.len());
        for (x, y) in one.iter().zip(&ten) {
            worst = worst.max((x.0 - y.0).abs() / 300.0).max((x.1.normal - y.1.normal).length());
            assert_eq!(x.1.beyond, y.1.beyond);
        }
        count += one.len();
    }
    println!("{count} interfaces, worst {worst:.1e}");
    assert!(worst < 1e-12 && count > 40_000, "{worst} {count}");
}

/// Walks in a bundle of bent hollow fibres: nothing lost, the medium of the place is that of the point.
#[test]
fn walks_in_bent_fibres() {
    let s = &mut stream(5);
    let mut parts = Vec::new();
    for body in 0..8 {
        let mut y = 6.0 * f64::from(body);
        let knots: Vec<(f64, f64)> = (0..12)
            .map(|i| {
                y += 2.0 * (s.uniform() - 0.5);
                (-30.0 + 5.0 * f64::from(i), y)
            })
            .collect();
        let (sin, cos) = (TAU * s.uniform()).sin_cos();
        let axis = DVec3::new(cos, sin, 0.0);
        let x = DVec3::new(-sin, cos, 0.0);
        parts.extend(chain(&knots, (DVec3::ZERO, Frame { x, y: axis.cross(x), z: axis }), body));
    }
    let u = merged(parts);
    let (mut interfaces, mut wrong) = (0, 0);
    for _ in 0..9000 {
        let dir = isotropic(s);
        let aim = DVec3::new(40.0 * (s.uniform() - 0.5), 40.0 * (s.uniform() - 0.5), 48.0 * s.uniform());
        let mut ray = Ray { origin: aim - dir * 200.0, dir };
        let start = u.enter(&ray, &mut (), s);
        let (mut place, mut medium) = (start.place, start.medium);
        for _ in 0..60 {
            match u.next(&ray, &mut place, &mut (), f64::INFINITY, s) {
                Next::Lost => panic!("lost"),
                Next::Interface(at) => {
                    interfaces += 1;
                    let middle = ray.at(0.5 * at.distance);
                    wrong += u64::from(at.distance > 1e-9 && u.medium_at(middle) != medium);
                    assert!(ray.dir.dot(at.normal) <= 0.0 && (at.normal.length() - 1.0).abs() < 1e-15);
                    ray.origin = ray.at(at.distance);
                    let cos = -ray.dir.dot(at.normal);
                    if s.uniform() < 0.5 {
                        ray.dir = (ray.dir + at.normal * (2.0 * cos)).normalize();
                        u.reflected(&ray, &mut place, &mut (), &at);
                    } else {
                        medium = at.beyond;
                        u.crossed(&mut ray, &mut place, &mut (), &at);
                    }
                }
                _ => break,
            }
        }
    }
    println!("{interfaces} interfaces");
    assert!(interfaces > 20_000);
    assert_eq!(wrong, 0);
}
