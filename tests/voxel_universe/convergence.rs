//! A voxelised sphere and hollow fibre against the exact bodies: the same rays with the same random
//! numbers.

use super::*;
use lightpro::math::Frame;
use lightpro::universe::BodyId;
use lightpro::universe::shape::{Ellipsoid, EllipticCylinder, Placed, Shape};
use lightpro::universe::synthetic::{Part, SyntheticUniverse};

/// Radius of the bodies, µm.
const RADIUS: f64 = 10.0;
const INDEX: [f64; 3] = [1.0, 1.5, 1.0];
/// Where the sphere's centre lies between the voxels.
const OFF: DVec3 = DVec3::new(0.13, 0.37, 0.21);

pub struct Body {
    hollow: bool,
    exact: SyntheticUniverse,
}

impl Body {
    fn part(shape: Placed, medium: u16) -> Part {
        Part {
            shape,
            medium: MediumId(medium),
            surface: SurfaceId::SMOOTH,
            priority: 0,
            body: BodyId(u32::from(medium)),
        }
    }

    fn sphere() -> Self {
        let world = Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
        let ball = Placed::new(Shape::Ellipsoid(Ellipsoid::sphere(RADIUS)), DVec3::ZERO, world);
        Body { hollow: false, exact: SyntheticUniverse::new(AIR, vec![Body::part(ball, 1)]).unwrap() }
    }

    /// Unbounded along y, lumen of .6 radii.
    fn fibre() -> Self {
        let frame = Frame { x: DVec3::Z, y: DVec3::X, z: DVec3::Y };
        let tube = |r: f64| {
            let c = EllipticCylinder { a: r, b: r, half_length: None };
            Placed::new(Shape::Cylinder(c), DVec3::ZERO, frame)
        };
        let parts = vec![Body::part(tube(RADIUS), 1), Body::part(tube(0.6 * RADIUS), 0)];
        Body { hollow: true, exact: SyntheticUniverse::new(AIR, parts).unwrap() }
    }

    /// Distance from the middle, or the axis.
    fn flat(&self, p: DVec3) -> DVec3 {
        if self.hollow { DVec3::new(p.x, 0.0, p.z) } else { p }
    }

    /// Voxels of which `per_radius` make a radius, and where in them the exact body's middle is.
    fn voxels(&self, per_radius: usize, normals: NormalRule, steps: Steps) -> (VoxelUniverse, DVec3) {
        let edge = RADIUS / per_radius as f64;
        let side = 2 * (per_radius + 8);
        let along = if self.hollow { 16 } else { side };
        let middle = DVec3::new(0.0, 0.0, 0.5 * side as f64 * edge) + OFF * edge;
        let volume = voxelised([side, along, side], edge, |p| {
            let r = self.flat(p - middle).length();
            u8::from(r < RADIUS && (!self.hollow || r > 0.6 * RADIUS))
        });
        let rules = Rules { normals, steps, lateral: Lateral::Periodic, ..rules(edge) };
        (VoxelUniverse::new(volume, phases(2), &rules).unwrap(), middle)
    }

    /// A ray that meets the body's outline, from the hull of radius `hull` about it.
    fn ray(&self, hull: f64, s: &mut Stream) -> Ray {
        let dir = loop {
            let d = isotropic(s);
            // Along an unbounded fibre there is no outline to aim at.
            if !self.hollow || self.flat(d).length() > 0.2 {
                break d;
            }
        };
        let across = self.flat(dir).normalize();
        let frame = Frame::from_pole(across);
        let start = if self.hollow {
            let side = across.cross(DVec3::Y);
            side * (RADIUS * (2.0 * s.uniform() - 1.0))
        } else {
            let (sin, cos) = (TAU * s.uniform()).sin_cos();
            (frame.x * cos + frame.y * sin) * (RADIUS * s.uniform().sqrt())
        };
        let back = (hull * hull - start.length_squared()).sqrt();
        Ray { origin: start - dir * (back / self.flat(dir).length()), dir }
    }

    /// Distance until a ray about `middle` leaves the hull.
    fn to_hull(&self, ray: &Ray, middle: DVec3, hull: f64) -> f64 {
        let (o, u) = (self.flat(ray.origin - middle), self.flat(ray.dir));
        let (a, b, c) = (u.length_squared(), o.dot(u), o.length_squared() - hull * hull);
        let root = (b * b - a * c).max(0.0).sqrt();
        ((root - b) / a).max(0.0)
    }
}

/// Mean and standard error.
#[derive(Clone, Copy, Default)]
pub struct Mean {
    n: f64,
    sum: f64,
    squares: f64,
}

impl Mean {
    fn push(&mut self, x: f64) {
        self.n += 1.0;
        self.sum += x;
        self.squares += x * x;
    }
    fn add(&mut self, o: &Mean) {
        self.n += o.n;
        self.sum += o.sum;
        self.squares += o.squares;
    }
    pub fn mean(&self) -> f64 {
        self.sum / self.n
    }
    pub fn error(&self) -> f64 {
        ((self.squares / self.n - self.mean() * self.mean()) / self.n).sqrt()
    }
}

/// Voxels minus exact: reflected share (out·in < 0), ⟨cos Θ⟩, path inside over the radius.
#[derive(Default)]
pub struct Difference {
    pub exact: [Mean; 3],
    pub of: [Mean; 3],
    pub passed: u64,
    pub forced: u64,
    pub events: u64,
    pub lost: u64,
}

pub fn compare(body: &Body, per_radius: usize, normals: NormalRule, steps: Steps, rays: u64) -> Difference {
    let (voxels, middle) = body.voxels(per_radius, normals, steps);
    let hull = RADIUS * (1.0 + 4.0 / per_radius as f64);
    let share = |thread: u64| {
        let mut d = Difference::default();
        let mut memory = Default::default();
        for i in (thread..rays).step_by(2) {
            let mut s = stream(i);
            let ray = body.ray(hull, &mut s);
            let (mut one, mut two) = (stream(1 << 40 | i), stream(1 << 40 | i));
            let limit = |r: &Ray| body.to_hull(r, DVec3::ZERO, hull);
            let Some(a) = follow(&body.exact, ray, &mut (), &INDEX, limit, &mut one) else { panic!() };
            let moved = Ray { origin: ray.origin + middle, dir: ray.dir };
            let limit = |r: &Ray| body.to_hull(r, middle, hull);
            let Some(b) = follow(&voxels, moved, &mut memory, &INDEX, limit, &mut two) else {
                d.lost += 1;
                continue;
            };
            d.events += u64::from(b.events);
            let score = |l: &Left| {
                let cos = l.dir.dot(ray.dir);
                [f64::from(u8::from(cos < 0.0)), cos, l.inside / RADIUS]
            };
            for (k, (x, y)) in score(&a).into_iter().zip(score(&b)).enumerate() {
                d.exact[k].push(x);
                d.of[k].push(y - x);
            }
        }
        (d.passed, d.forced) = (memory.passed, memory.forced);
        d
    };
    std::thread::scope(|scope| {
        let other = scope.spawn(|| share(1));
        let mut d = share(0);
        let o = other.join().unwrap();
        for k in 0..3 {
            d.exact[k].add(&o.exact[k]);
            d.of[k].add(&o.of[k]);
        }
        d.passed += o.passed;
        d.forced += o.forced;
        d.events += o.events;
        d.lost += o.lost;
        d
    })
}

fn table(name: &str, body: &Body, normals: NormalRule, steps: Steps, rays: u64) -> Vec<Difference> {
    println!("{name}");
    println!("voxels/r  R            error            <cos>        error            path         error            per event: passed  forced");
    let mut out: Vec<Difference> = Vec::new();
    for per_radius in [8, 16, 32, 64] {
        let d = compare(body, per_radius, normals, steps, rays);
        let cells: Vec<String> = (0..3)
            .map(|k| format!("{:.5} {:+.5}({:.5})", d.exact[k].mean(), d.of[k].mean(), d.of[k].error()))
            .collect();
        let per = |n: u64| n as f64 / d.events as f64;
        let order = out.last().map_or(String::new(), |before| {
            let o = |k: usize| (before.of[k].mean() / d.of[k].mean()).abs().log2();
            format!("order {:.1} {:.1} {:.1}", o(0), o(1), o(2))
        });
        println!(
            "{per_radius:>8}  {}   {:.4} {:.5}  lost {}  {order}",
            cells.join("   "),
            per(d.passed),
            per(d.forced),
            d.lost
        );
        out.push(d);
    }
    out
}

#[test]
fn a_sphere_converges() {
    let body = Body::sphere();
    table("sphere, smoothed", &body, NormalRule::Smoothed(2.0), Steps::Passed, 200_000);
    table("sphere, mirrored", &body, NormalRule::Smoothed(2.0), Steps::Mirrored, 200_000);
    table("sphere, faces", &body, NormalRule::Faces, Steps::Passed, 200_000);
}

#[test]
fn a_hollow_fibre_converges() {
    let body = Body::fibre();
    table("fibre, smoothed", &body, NormalRule::Smoothed(2.0), Steps::Passed, 200_000);
    table("fibre, mirrored", &body, NormalRule::Smoothed(2.0), Steps::Mirrored, 200_000);
    table("fibre, faces", &body, NormalRule::Faces, Steps::Passed, 200_000);
}

#[test]
#[ignore]
fn diagnose() {
    for body in [Body::sphere(), Body::fibre()] {
        let per_radius = 32;
        let (voxels, middle) = body.voxels(per_radius, NormalRule::Smoothed(2.0), Steps::Passed);
        let hull = RADIUS * (1.0 + 4.0 / per_radius as f64);
        let mut bins = vec![[Mean::default(); 4]; 10];
        let mut ybins = vec![[Mean::default(); 4]; 10];
        let mut memory = Default::default();
        for i in 0..100_000 {
            let mut s = stream(i);
            let ray = body.ray(hull, &mut s);
            let (mut one, mut two) = (stream(1 << 40 | i), stream(1 << 40 | i));
            let Some(a) = follow(&body.exact, ray, &mut (), &INDEX, |r| body.to_hull(r, DVec3::ZERO, hull), &mut one) else { panic!() };
            let moved = Ray { origin: ray.origin + middle, dir: ray.dir };
            let Some(b) = follow(&voxels, moved, &mut memory, &INDEX, |r| body.to_hull(r, middle, hull), &mut two) else { continue };
            let f = body.flat(ray.dir).normalize();
            let rho = body.flat(ray.origin).cross(f).length() / RADIUS;
            let k = ((rho * rho) * 10.0) as usize;
            let d = b.dir.dot(ray.dir) - a.dir.dot(ray.dir);
            for (bins, k) in [(&mut bins, k), (&mut ybins, (ray.dir.y.abs() * 10.0) as usize)] {
                let m = &mut bins[k.min(9)];
                m[0].push(d);
                m[1].push(f64::from(b.events) - f64::from(a.events));
                m[2].push(f64::from(u8::from(b.events != a.events)));
                m[3].push(f64::from(u8::from(b.events > 1000)));
            }
        }
        for (name, bins) in [("rho2", bins), ("uy", ybins)] {
            for (k, m) in bins.iter().enumerate() {
                println!("{name} {k}: dcos {:+.5}({:.5}) events {:+.3}({:.3}) other {:.4} >1000 {:.5}", m[0].mean(), m[0].error(), m[1].mean(), m[1].error(), m[2].mean(), m[3].mean());
            }
        }
    }
}
