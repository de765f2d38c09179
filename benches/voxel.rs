//! Voxels: a step of the walk, a normal kept and computed, a whole history in the shipped volume.
#![allow(missing_docs)]

mod common;

use common::{CALLS, best_ns, report, stream};
use lightpro::math::DVec3;
use lightpro::rng::Stream;
use lightpro::universe::voxel::lattice::{Lateral, Lattice, Walk};
use lightpro::universe::voxel::normal::{FaceId, Normals, Window};
use lightpro::universe::voxel::{NormalRule, Phase, Rules, Steps, Volume, VoxelUniverse};
use lightpro::universe::{MediumId, Next, Ray, SurfaceId, Universe};
use std::hint::black_box;
use std::sync::Arc;

/// A ball of .8 half edges, n³ voxels; and a lone voxel of a third and fourth phase: 2 bits each.
fn ball(n: usize) -> Volume {
    let half = 0.5 * n as f64;
    let phase = |i: usize| {
        let p = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64) + 0.5 - half;
        if i < 2 { 2 + i as u8 } else { u8::from(p.length() < 0.8 * half) }
    };
    Volume::of([n; 3], &(0..n * n * n).map(phase).collect::<Vec<_>>()).unwrap()
}

fn direction(s: &mut Stream) -> DVec3 {
    let z = 2.0 * s.uniform() - 1.0;
    let (c, sin) = s.azimuth();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * c, r * sin, z)
}

/// Steps of 1000 from cell to cell, looking at each.
#[inline(never)]
fn steps(lattice: &Lattice, s: &mut Stream) -> u64 {
    let mut sum = 0;
    let n = lattice.cells(2);
    for _ in 0..CALLS / 1000 {
        // Sideways, so that it stays in the volume.
        let (cos, sin) = s.azimuth();
        let dir = DVec3::new(cos, sin, 0.01 * (s.uniform() - 0.5)).normalize();
        let ray = Ray { origin: DVec3::new(0.0, 0.0, 0.5 * n as f64), dir };
        let mut walk = Walk::new(lattice, &ray, [0.5, 0.5], [0, 0, n / 2]);
        for _ in 0..1000 {
            let (axis, _) = walk.ahead();
            walk.step(axis);
            sum += u64::from(walk.phase());
        }
    }
    sum
}

/// Interfaces met by diffuse light that goes straight on.
#[inline(never)]
fn interfaces(u: &VoxelUniverse, memory: &mut <VoxelUniverse as Universe>::Memory, s: &mut Stream) -> u64 {
    let mut met = 0;
    while met < 10_000 {
        let dir = direction(s);
        let dir = if dir.z > -0.05 { -DVec3::Z } else { dir };
        let mut ray = Ray { origin: DVec3::Z * u.thickness(), dir };
        let mut place = u.enter(&ray, memory, s).place;
        while let Next::Interface(at) = u.next(&ray, &mut place, memory, f64::INFINITY, s) {
            ray.origin = ray.at(at.distance);
            u.crossed(&mut ray, &mut place, memory, &at);
            met += 1;
        }
    }
    met
}

fn main() {
    report(|| {
        let mut rows = Vec::new();
        for n in [32, 64, 256, 512] {
            let volume = ball(n);
            let bytes = volume.bytes();
            let lattice = Lattice::new(Arc::new(volume), [1.0; 3], Lateral::Mirror, 0);
            let mut s = stream();
            let ns = best_ns(CALLS, || steps(black_box(&lattice), &mut s));
            rows.push((format!("step, {n}^3 voxels of 2 bits ({} kB)", bytes / 1000), ns));
        }
        let lattice = Lattice::new(Arc::new(ball(64)), [1.0; 3], Lateral::Mirror, 0);
        let face = FaceId { low: [6, 32, 32], axis: 0 };
        let mut window = Window::default();
        for sigma in [2.0, 3.0] {
            let fresh = || Normals::new(&lattice, sigma);
            let many: Vec<Normals> = (0..8).map(|_| fresh()).collect();
            let kept = &many[0];
            let mut low = 0;
            let computed = best_ns(1, || {
                // Another face each time, none met before.
                low += 1;
                let low = [6, 8 + low % 48, 8 + low / 48 % 48];
                many[1].of_face(&lattice, FaceId { low, axis: 0 }, (0, 1), &mut window)
            });
            kept.of_face(&lattice, face, (0, 1), &mut window);
            let again = best_ns(1000, || {
                (0..1000)
                    .map(|_| kept.of_face(&lattice, black_box(face), (0, 1), &mut window)[0].x)
                    .sum::<f64>()
            });
            rows.push((format!("normals of a face, sigma {sigma}, computed"), computed));
            rows.push((format!("normals of a face, sigma {sigma}, kept"), again));
        }
        let phases: Vec<Phase> =
            (0..4).map(|m| Phase { medium: MediumId(m), surface: SurfaceId::SMOOTH }).collect();
        for (name, normals) in [("smoothed", NormalRule::Smoothed(2.0)), ("faces", NormalRule::Faces)] {
            let rules = Rules {
                edge: [1.0; 3],
                lateral: Lateral::Mirror,
                normals,
                steps: Steps::Passed,
                anywhere: true,
                outside: MediumId(0),
            };
            let u = VoxelUniverse::new(ball(64), phases.clone(), &rules).unwrap();
            let (mut memory, mut s) = (Default::default(), stream());
            let ns = best_ns(10_000, || interfaces(&u, &mut memory, &mut s));
            rows.push((format!("interface in 64^3 voxels, normals {name}"), ns));
        }
        rows
    });
}
