//! The synthetic universe: the next interface among 10³, 10⁴, 10⁵ hollow fibres that cover 40 % of
//! their volume (in-plane, 1 mm × 20 µm, wall 2.7 µm, overlaps merged, a sheet of 100 µm, repeated
//! sideways), for rays that go straight on at one interface of two and anywhere at the other.
#![allow(missing_docs)]

mod common;

use common::{best_ns, report};
use divan::Bencher;
use divan::counter::ItemsCount;
use lightpro::math::{DVec3, PI, TAU, ln, sin_cos};
use lightpro::rng::{Purpose, Stream};
use lightpro::universe::Overlap;
use lightpro::universe::shape::{EllipticCylinder, Placed, Shape};
use lightpro::universe::statistical::kind::oriented;
use lightpro::universe::synthetic::{Part, Search, Setting, SyntheticUniverse};
use lightpro::universe::{BodyId, MediumId, Next, Ray, SurfaceId, Universe};
use std::hint::black_box;
use std::time::Instant;

const HEIGHT: f64 = 100.0;
const LENGTH: f64 = 1000.0;
const RADIUS: f64 = 10.0;
const WALL: f64 = 2.7;
const COUNTS: [u64; 3] = [1_000, 10_000, 100_000];

/// Side of the square that `count` fibres cover by 40 %.
fn side(count: u64) -> f64 {
    let volume = count as f64 * PI * RADIUS * RADIUS * LENGTH / -ln(0.6);
    (volume / HEIGHT).sqrt()
}

fn parts(count: u64) -> Vec<Part> {
    let mut rng = Stream::of(1, 0, count, Purpose::Realisation);
    let side = side(count);
    let mut parts = Vec::new();
    for body in 0..count {
        let (s, c) = sin_cos(PI * rng.uniform());
        let frame = oriented((c, s), 0.0, 0.0, true);
        let at = DVec3::new(side * rng.uniform(), side * rng.uniform(), HEIGHT * rng.uniform());
        for (r, medium) in [(RADIUS, 1), (RADIUS - WALL, 0)] {
            let shape = Shape::Cylinder(EllipticCylinder { a: r, b: r, half_length: Some(0.5 * LENGTH) });
            parts.push(Part {
                shape: Placed::new(shape, at, frame),
                medium: MediumId(medium),
                surface: SurfaceId::SMOOTH,
                priority: 0,
                body: BodyId(body as u32),
            });
        }
    }
    parts
}

fn universe(parts: Vec<Part>, side: f64, search: Search) -> SyntheticUniverse {
    let period = (search != Search::Hierarchy).then_some([side, side]);
    let setting = Setting { overlap: Overlap::Union, sheet: Some([0.0, HEIGHT]), period, search };
    SyntheticUniverse::with(MediumId(0), parts, setting).unwrap()
}

fn isotropic(rng: &mut Stream) -> DVec3 {
    let z = 2.0 * rng.uniform() - 1.0;
    let (s, c) = sin_cos(TAU * rng.uniform());
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * c, r * s, z)
}

/// Follows rays over `events` interfaces.
#[inline(never)]
fn walk(u: &SyntheticUniverse, side: f64, events: u64, rng: &mut Stream) -> f64 {
    let (mut met, mut sum) = (0, 0.0);
    while met < events {
        let origin = DVec3::new(side * rng.uniform(), side * rng.uniform(), HEIGHT * rng.uniform());
        let mut ray = Ray { origin, dir: isotropic(rng) };
        let mut place = u.enter(&ray, &mut (), rng).place;
        while let Next::Interface(at) = u.next(&ray, &mut place, &mut (), f64::INFINITY, rng) {
            met += 1;
            sum += at.distance;
            ray.origin = ray.at(at.distance);
            let u1 = rng.uniform();
            if u1 < 0.5 {
                let d = isotropic(rng);
                let up = if d.dot(at.normal) < 0.0 { -d } else { d };
                if u1 < 0.25 {
                    ray.dir = up;
                    u.reflected(&ray, &mut place, &mut (), &at);
                    continue;
                }
                ray.dir = -up;
            }
            u.crossed(&mut ray, &mut place, &mut (), &at);
        }
    }
    sum / met as f64
}

const EVENTS: u64 = 200_000;

#[divan::bench(args = COUNTS)]
fn next_interface(bencher: Bencher, count: u64) {
    let side = side(count);
    let u = universe(parts(count), side, Search::Automatic);
    let mut rng = common::stream();
    bencher.counter(ItemsCount::new(EVENTS)).bench_local(|| walk(black_box(&u), side, EVENTS, &mut rng));
}

fn main() {
    divan::main();
    report(|| {
        let mut rows = Vec::new();
        for (search, counts) in [(Search::Automatic, &COUNTS[..]), (Search::Hierarchy, &COUNTS[..2])] {
            for &count in counts {
                let (side, parts) = (side(count), parts(count));
                let begun = Instant::now();
                let u = universe(parts, side, search);
                let built = begun.elapsed().as_secs_f64();
                println!(
                    "{count} fibres: {:.2} s, {:.1} MB; {}",
                    built,
                    u.bytes() as f64 * 1e-6,
                    u.describe_search()
                );
                let mut rng = common::stream();
                let mut mean = 0.0;
                let ns = best_ns(EVENTS, || mean = walk(black_box(&u), side, EVENTS, &mut rng));
                println!("mean way to the next interface {mean:.2} µm");
                rows.push((format!("next interface, {count} fibres, {search:?}"), ns));
            }
        }
        rows
    });
}
