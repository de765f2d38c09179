//! How far smoothed normals are from the exact ones.

use super::*;

/// Rms and worst angle (rad) between the normals that rays from outside are given and the exact ones,
/// over rays from all directions at the convex side of a body about `middle`; and the rms error of the
/// Fresnel reflectance, n = 1.5.
pub struct Angles {
    pub rms: f64,
    pub worst: f64,
    pub fresnel: f64,
    pub bias: f64,
    pub n: u64,
}

pub fn angles(
    u: &VoxelUniverse,
    rays: u64,
    start: impl Fn(&mut Stream) -> Ray,
    exact: impl Fn(DVec3) -> DVec3,
) -> Angles {
    let mut memory = Default::default();
    let (mut sum, mut worst, mut fresnel, mut bias, mut n) = (0.0, 0.0_f64, 0.0, 0.0, 0);
    for i in 0..rays {
        let mut s = stream(i);
        let ray = start(&mut s);
        let begin = u.enter(&ray, &mut memory, &mut s);
        let mut place = begin.place;
        // The start may lie in a step of the staircase.
        if begin.medium != AIR {
            continue;
        }
        // Farther away it is the neighbour in the mirror.
        if let Next::Interface(at) = u.next(&ray, &mut place, &mut memory, 8.0, &mut s) {
            let m = exact(ray.at(at.distance));
            let angle = at.normal.cross(m).length().atan2(at.normal.dot(m));
            let cos = -ray.dir.dot(m);
            if cos <= 0.0 {
                continue;
            }
            let r = |c: f64| fresnel::dielectric(1.0, 1.5, c).r;
            let off = r(-ray.dir.dot(at.normal)) - r(cos);
            sum += angle * angle;
            worst = worst.max(angle);
            fresnel += off * off;
            bias += off;
            n += 1;
        }
    }
    let of = |x: f64| (x / n as f64).sqrt();
    Angles { rms: of(sum), worst, fresnel: of(fresnel), bias: bias / n as f64, n }
}

/// Sphere or unbounded fibre of a radius in voxels.
fn round(flat: bool, per_radius: usize, normals: NormalRule) -> Angles {
    let radius = per_radius as f64;
    let side = 2 * per_radius + 20;
    let middle = DVec3::new(0.13, 0.37, 0.5 * side as f64 + 0.21);
    let level = |p: DVec3| if flat { DVec3::new(p.x, 0.0, p.z) } else { p };
    let along = if flat { 8 } else { side };
    let volume = voxelised([side, along, side], 1.0, |p| u8::from(level(p - middle).length() < radius));
    let u = VoxelUniverse::new(volume, phases(2), &Rules { normals, ..rules(1.0) }).unwrap();
    // From just outside towards a point of the surface, cosine about its normal.
    let start = |s: &mut Stream| {
        let n = level(isotropic(s)).normalize();
        let dir = loop {
            let d = isotropic(s);
            if s.uniform() < -d.dot(n) {
                break d;
            }
        };
        Ray { origin: middle + n * radius - dir * 3.5, dir }
    };
    angles(&u, 20_000, start, |p| level(p - middle).normalize())
}

/// The table of docs/voxels.md. Curvature costs nothing; what is left is the lattice, less the wider the
/// smoothing, and more where the surface runs along an axis.
#[test]
fn smoothed_normals_are_a_degree_off_and_faces_some_fifty() {
    for sigma in [1.0, 1.5, 2.0, 3.0, 4.0] {
        for flat in [false, true] {
            for per_radius in [8, 16, 32, 64] {
                let a = round(flat, per_radius, NormalRule::Smoothed(sigma));
                println!(
                    "sigma {sigma} r {per_radius:>2} {}: rms {:.2} deg, worst {:.2}; Fresnel R rms {:.4}, mean {:+.5} ({})",
                    if flat { "fibre " } else { "sphere" },
                    a.rms.to_degrees(),
                    a.worst.to_degrees(),
                    a.fresnel,
                    a.bias,
                    a.n
                );
                let most = if flat { 4.8 } else { 2.2 } / sigma;
                if sigma >= 2.0 {
                    assert!(a.rms.to_degrees() < most, "{} above {most}", a.rms.to_degrees());
                }
            }
        }
    }
    for per_radius in [8, 64] {
        let a = round(false, per_radius, NormalRule::Faces);
        println!(
            "faces r {per_radius:>2}: rms {:.1} deg; Fresnel R rms {:.3}, mean {:+.3}",
            a.rms.to_degrees(),
            a.fresnel,
            a.bias
        );
        assert!(a.rms.to_degrees() > 30.0);
    }
}
