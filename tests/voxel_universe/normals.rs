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
        if let Next::Interface(at) = u.next(&ray, &mut place, &mut memory, f64::INFINITY, &mut s) {
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

#[test]
fn table_of_normals() {
    for sigma in [1.5, 2.0, 3.0, 4.0] {
        for per_radius in [8, 16, 32, 64] {
            let edge = 1.0;
            let radius = per_radius as f64;
            let side = 2 * per_radius + 20;
            for flat in [false, true] {
                let middle = DVec3::new(0.13, 0.37, 0.5 * side as f64 + 0.21);
                let level = |p: DVec3| if flat { DVec3::new(p.x, 0.0, p.z) } else { p };
                let along = if flat { 8 } else { side };
                let volume = voxelised([side, along, side], edge, |p| u8::from(level(p - middle).length() < radius));
                let rules = Rules { normals: NormalRule::Smoothed(sigma), ..rules(edge) };
                let u = VoxelUniverse::new(volume, phases(2), &rules).unwrap();
                let start = |s: &mut Stream| {
                    // From just outside towards a point of the surface, cosine about its normal.
                    let n = level(isotropic(s)).normalize();
                    let d = loop {
                        let d = isotropic(s);
                        if s.uniform() < -d.dot(n) {
                            break d;
                        }
                    };
                    Ray { origin: middle + n * radius - d * 3.5, dir: d }
                };
                let a = angles(&u, 20_000, start, |p| level(p - middle).normalize());
                println!("sigma {sigma} r {per_radius:>3} {}: rms {:.3} deg worst {:.2} deg  R rms {:.4} bias {:+.5}  n {}", if flat {"fibre "} else {"sphere"}, a.rms.to_degrees(), a.worst.to_degrees(), a.fresnel, a.bias, a.n);
            }
        }
    }
}
