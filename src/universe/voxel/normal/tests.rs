//! Keeping and connecting; thin walls.

use super::super::lattice::Lateral;
use super::super::volume::Volume;
use super::*;
use crate::rng::{Purpose, Stream};

#[test]
fn a_kept_direction_is_the_direction() {
    let mut s = Stream::of(1, 0, 0, Purpose::Probe);
    let mut worst: f64 = 0.0;
    for i in 0..100_000 {
        let mut n = DVec3::new(s.uniform() - 0.5, s.uniform() - 0.5, s.uniform() - 0.5);
        if i % 7 == 0 {
            n.x = 0.0;
        }
        if i % 5 == 0 {
            n.z = -0.0;
        }
        let n = n.normalize();
        worst = worst.max(n.cross(unpack(pack(n))).length());
    }
    for n in [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z] {
        worst = worst.max(n.cross(unpack(pack(n))).length());
        assert!(n.dot(unpack(pack(n))) > 0.0);
    }
    println!("worst error {worst:.1e} rad");
    assert!(worst < 5e-6, "{worst}");
    assert_eq!(unpack(pack(DVec3::ZERO)), DVec3::ZERO);
}

#[test]
fn a_flood_stays_on_its_side_of_a_wall() {
    // 7 × 3 × 2 cells; a wall of zeros at x = 3 with a gap in the last row only.
    let wall = 0b111_0111;
    let mut of = vec![wall; 6];
    let mut into = vec![0; 6];
    flood(&of, &mut into, [0, 0, 0], [7, 3, 2]);
    assert_eq!(into, vec![0b000_0111; 6]);
    of[5] = 0b111_1111;
    flood(&of, &mut into, [0, 0, 0], [7, 3, 2]);
    assert_eq!(into, of);
}
/// Rms angle (rad) between the normals at all outer faces of a shell and its radius; as used, and without
/// looking at what is connected.
fn shell(radius: f64, wall: f64, sigma: f64) -> [f64; 2] {
    let n = 2 * radius as usize + 20;
    let middle = DVec3::new(0.13, 0.37, 0.21) + DVec3::splat(0.5 * n as f64);
    let at = |i: usize| DVec3::new((i % n) as f64 + 0.5, (i / n % n) as f64 + 0.5, (i / n / n) as f64 + 0.5);
    let phases: Vec<u8> = (0..n * n * n)
        .map(|i| {
            let r = (at(i) - middle).length();
            u8::from(r < radius && r > radius - wall)
        })
        .collect();
    let lattice =
        Lattice::new(Arc::new(Volume::of([n; 3], &phases).unwrap()), [1.0; 3], Lateral::Periodic, 0);
    let normals = Normals::new(&lattice, sigma);
    let mut window = Window::default();
    let (mut sums, mut count) = ([0.0; 2], 0.0);
    for i in 0..n * n * n {
        let next = i + 1;
        // Faces across x on the outer side, from pore to wall.
        let from = at(i) - middle;
        if i % n + 1 == n || phases[i] == phases[next] || from.length() < radius - 0.5 * wall {
            continue;
        }
        let low = [i % n, i / n % n, i / n / n].map(|k| k as i64);
        let pair = (phases[i], phases[next]);
        let outward = |g: DVec3| if pair.0 == 0 { g } else { -g };
        let corners = normals.of_face(&lattice, FaceId { low, axis: 0 }, pair, &mut window);
        let vertex = DVec3::new(low[0] as f64 + 1.0, low[1] as f64, low[2] as f64);
        let exact = (vertex - middle).normalize();
        let plain = normals.about(&lattice, vertex, pair, &mut window);
        for (sum, g) in sums.iter_mut().zip([corners[0], plain]) {
            let g = outward(g);
            let angle = crate::math::atan2(g.cross(exact).length(), g.dot(exact));
            *sum += angle * angle;
        }
        count += 1.0;
    }
    assert!(count > 100.0);
    sums.map(|s| (s / count).sqrt())
}

/// Walls of 2 and 3 voxels: with the far side counted as more wall the error is that of a solid body.
#[test]
fn a_thin_wall_looks_where_it_does() {
    for sigma in [2.0, 3.0] {
        let solid = shell(16.0, 16.0, sigma);
        for wall in [2.0, 3.0, 4.0, 6.0] {
            let [used, plain] = shell(16.0, wall, sigma);
            println!(
                "sigma {sigma}, wall {wall} voxels: {:.2} deg, without connection {:.2} deg (solid {:.2})",
                used.to_degrees(),
                plain.to_degrees(),
                solid[0].to_degrees()
            );
            assert!(used < 1.2 * solid[0], "{used} {}", solid[0]);
        }
        let [_, plain] = shell(16.0, 2.0, sigma);
        assert!(plain > 2.0 * solid[0], "the plain gradient should suffer: {plain}");
    }
}
