//! Walks through voxels.

use super::*;

#[test]
fn straight_rays_find_the_shares_of_the_volume() {
    let volume = Volume::of(example::CELLS, &example::labels()).unwrap();
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
                println!("{lateral:?} {normals:?} {k}: {:.3} want {want:.3}", path[k] / rays as f64);
            }
        }
    }
}
