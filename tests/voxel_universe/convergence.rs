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
    pub caught: u64,
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
                d.caught += 1;
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
        d.caught += o.caught;
        d
    })
}

/// Differences at 8 … 64 voxels a radius, printed with the order observed from row to row.
fn table(
    name: &str,
    body: &Body,
    normals: impl Fn(usize) -> NormalRule,
    steps: Steps,
    sizes: &[usize],
) -> Vec<Difference> {
    println!("{name}: exact, voxels minus exact (standard error); order; per event");
    println!("voxels/r   R                           <cos>                       path/r");
    let mut out: Vec<Difference> = Vec::new();
    for &per_radius in sizes {
        let d = compare(body, per_radius, normals(per_radius), steps, RAYS);
        let cells: Vec<String> = (0..3)
            .map(|k| format!("{:.5} {:+.5} ({:.5})", d.exact[k].mean(), d.of[k].mean(), d.of[k].error()))
            .collect();
        let order = out.last().map_or(String::new(), |before| {
            let o = |k: usize| (before.of[k].mean() / d.of[k].mean()).abs().log2();
            format!("order R {:.1} cos {:.1};", o(0), o(1))
        });
        let per = |n: u64| n as f64 / d.events as f64;
        println!(
            "{per_radius:>8}   {}   {order} passed {:.4} forced {:.5}; {} of {RAYS} rays caught",
            cells.join("   "),
            per(d.passed),
            per(d.forced),
            d.caught
        );
        out.push(d);
    }
    out
}

const RAYS: u64 = 60_000;
const SIZES: [usize; 4] = [8, 16, 32, 64];

/// Smoothing that grows with the root of the radius in voxels: wider in voxels, narrower in µm.
fn widening(per_radius: usize) -> NormalRule {
    NormalRule::Smoothed(2.0 * (per_radius as f64 / 8.0).sqrt())
}

/// Order from the first to the last row, three halvings of the voxel.
fn order(rows: &[Difference], quantity: usize) -> f64 {
    let of = |d: &Difference| d.of[quantity].mean().abs();
    (of(&rows[0]) / of(&rows[rows.len() - 1])).log2() / (rows.len() - 1) as f64
}

/// What must hold of a body: the smoothed normals converge, faces and mirrored steps do not.
fn converges(name: &str, body: &Body) {
    let rows =
        table(&format!("{name}, smoothed over 2 sqrt(r/8) voxels"), body, widening, Steps::Passed, &SIZES);
    for d in &rows {
        assert!(d.caught < RAYS / 200, "{} rays caught", d.caught);
    }
    let (of_r, of_cos) = (order(&rows, 0), order(&rows, 1));
    println!("overall order: R {of_r:.2}, <cos> {of_cos:.2}");
    assert!(of_r > 0.6, "order of R {of_r}");
    let last = &rows[3];
    assert!(last.of[0].mean().abs() < 0.003 + 3.0 * last.of[0].error(), "R {}", last.of[0].mean());
    assert!(last.of[1].mean().abs() < 0.004 + 3.0 * last.of[1].error(), "cos {}", last.of[1].mean());
    let two = |_| NormalRule::Smoothed(2.0);
    let fixed = table(&format!("{name}, smoothed over 2 voxels"), body, two, Steps::Passed, &[16, 64]);
    assert!(fixed[1].of[0].mean().abs() < 0.006 + 3.0 * fixed[1].of[0].error());
    for (what, rule, steps, least) in [
        ("voxel faces", NormalRule::Faces, Steps::Passed, 0.07),
        ("steps mirrored", NormalRule::Smoothed(2.0), Steps::Mirrored, 0.05),
    ] {
        let rows = table(&format!("{name}, {what}"), body, |_| rule, steps, &[16, 64]);
        let (coarse, fine) = (rows[0].of[0].mean(), rows[1].of[0].mean());
        assert!(fine > least && fine > 0.8 * coarse, "{what} would converge: {coarse} {fine}");
    }
}

#[test]
fn a_sphere_converges_with_smoothed_normals_only() {
    converges("sphere", &Body::sphere());
}

#[test]
fn a_hollow_fibre_converges_with_smoothed_normals_only() {
    converges("hollow fibre", &Body::fibre());
}

/// Path of diffuse light by medium, per unit of what the mean-path theorem says: 2 n² H φ, here with
/// light from both sides (the volume upside down gives the other) and a wall that scatters, so that
/// every state is reached.
fn sheet_paths(fine: usize, normals: NormalRule, steps: Steps, rays: u64) -> [f64; 3] {
    let edge = 1.0 / fine as f64;
    let cells = example::CELLS.map(|n| n * fine);
    let upright = example::labels(fine);
    let turned: Vec<u8> = upright.chunks(cells[0] * cells[1]).rev().flatten().copied().collect();
    let mut path = [0.0; 3];
    let mut shares = Vec::new();
    for (side, labels) in [upright, turned].iter().enumerate() {
        let volume = Volume::of(cells, labels).unwrap();
        shares = volume.counts(3).iter().map(|&n| n as f64 / volume.len() as f64).collect();
        let rules = Rules { normals, steps, anywhere: true, ..rules(edge) };
        let u = VoxelUniverse::new(volume, phases(3), &rules).unwrap();
        let mut m = Default::default();
        for i in 0..rays {
            let s = &mut stream(i + side as u64 * rays);
            let u2 = s.uniform();
            let (sin, cos) = (TAU * s.uniform()).sin_cos();
            let dir = DVec3::new(u2.sqrt() * cos, u2.sqrt() * sin, -(1.0 - u2).sqrt());
            let mut ray = Ray { origin: DVec3::Z * u.thickness(), dir };
            let start = u.enter(&ray, &mut m, s);
            let (mut place, mut medium) = (start.place, start.medium);
            for _ in 0..100_000 {
                let free = if medium == MediumId(1) { 20.0 * s.exponential() } else { f64::INFINITY };
                let seen = u.next(&ray, &mut place, &mut m, free, s);
                let step = match &seen {
                    Next::Interface(at) => at.distance,
                    Next::Edge { distance, .. } => *distance,
                    _ => free,
                };
                path[usize::from(medium.0)] += step;
                ray.origin = ray.at(step);
                match seen {
                    Next::Interface(at) => {
                        let index = |m: MediumId| INDEX[usize::from(m.0)];
                        let (dir, crosses) = fresnel_event(ray.dir, &at, index(medium), index(at.beyond), s);
                        ray.dir = dir;
                        if crosses {
                            u.crossed(&mut ray, &mut place, &mut m, &at);
                            medium = at.beyond;
                        } else {
                            u.reflected(&ray, &mut place, &mut m, &at);
                        }
                    }
                    Next::Limit => {
                        ray.dir = isotropic(s);
                        u.moved(&ray, &mut place, &mut m, free);
                    }
                    _ => break,
                }
            }
        }
    }
    let square = |k: usize| INDEX[k] * INDEX[k];
    [0, 1, 2].map(|k| path[k] / (2.0 * rays as f64) / (2.0 * square(k) * 48.0 * shares[k]))
}

/// Nine hollow fibres at voxels of 1, .5 and .25 µm: how far the mean paths are from the theorem. Voxel
/// faces as normals keep it exactly (and are wrong in their directions); smoothed normals approach it;
/// mirrored steps do not.
#[test]
fn mean_paths_in_a_sheet_of_fibres_converge() {
    let mut worst = Vec::new();
    for fine in [1, 2, 4] {
        let p = sheet_paths(fine, NormalRule::Smoothed(2.0), Steps::Passed, 40_000);
        println!(
            "voxel {} um, smoothed: pores {:.4}, walls {:.4}, lumens {:.4}",
            1.0 / fine as f64,
            p[0],
            p[1],
            p[2]
        );
        worst.push(p.iter().map(|x| (x - 1.0).abs()).fold(0.0, f64::max));
    }
    assert!(worst[1] < 0.7 * worst[0] && worst[2] < 0.4 * worst[0] && worst[2] < 0.04, "{worst:?}");
    let p = sheet_paths(1, NormalRule::Faces, Steps::Passed, 40_000);
    println!("faces: {p:?}");
    assert!(p.iter().all(|x| (x - 1.0).abs() < 0.012), "{p:?}");
    let p = sheet_paths(4, NormalRule::Smoothed(2.0), Steps::Mirrored, 40_000);
    println!("voxel 0.25 um, mirrored: {p:?}");
    assert!((p[1] - 1.0).abs() > 0.08, "{p:?}");
}
