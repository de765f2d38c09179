//! Geometric optics of one body in a parallel beam: sphere, pore, solid and hollow fibre, copper
//! sphere.

use crate::harness::{Check, Row, hold, rows, within};
use crate::transport::{AIR, SOLID, Score, walk, world};
use lightpro::lpm::full::{Full, Polarisation};
use lightpro::lpm::polarised::State;
use lightpro::lpm::surface::SurfaceLaw;
use lightpro::lpm::{History, Light, Medium, Path, Scorer, World, trace};
use lightpro::math::{DVec3, Frame, gauss_legendre};
use lightpro::phase::Phase;
use lightpro::phase::polarised::ScatteringMatrix;
use lightpro::rng::{Purpose, Stream};
use lightpro::universe::shape::{Ellipsoid, EllipticCylinder, Placed, Shape};
use lightpro::universe::synthetic::{Part, SyntheticUniverse};
use lightpro::universe::{BodyId, Face, Interface, Ray, SurfaceId};
use num_complex::Complex64;
use std::cell::RefCell;
use std::collections::HashMap;

/// Outer surface, and the lumen's.
const OUTER: BodyId = BodyId(1);
const INNER: BodyId = BodyId(2);

/// The body of a row, about the origin, of outer radius 1; fibres along z.
fn body(row: &Row) -> SyntheticUniverse {
    let part = |shape, medium, body| Part {
        shape: Placed::at_origin(shape),
        medium,
        surface: SurfaceId::SMOOTH,
        priority: 0,
        body,
    };
    let cylinder = |r| Shape::Cylinder(EllipticCylinder { a: r, b: r, half_length: None });
    let outer =
        if row.text("shape") == "sphere" { Shape::Ellipsoid(Ellipsoid::sphere(1.0)) } else { cylinder(1.0) };
    let mut parts = vec![part(outer, SOLID, OUTER)];
    let lumen = row.f("rho_inner/outer");
    if lumen > 0.0 {
        assert_eq!(row.f("n_lumen_rel"), 1.0);
        parts.push(part(cylinder(lumen), AIR, INNER));
    }
    SyntheticUniverse::new(AIR, parts).unwrap()
}

/// A ray of the beam, uniform over the body's shadow.
fn beam(row: &Row, rng: &mut Stream) -> Ray {
    if row.text("shape") == "sphere" {
        let (r, (c, s)) = (rng.uniform().sqrt(), rng.azimuth());
        return Ray { origin: DVec3::new(r * c, r * s, 4.0), dir: -DVec3::Z };
    }
    let (s, c) = row.f("tilt_deg").to_radians().sin_cos();
    let dir = DVec3::new(-c, 0.0, s);
    let offset = DVec3::new(0.0, 2.0 * rng.uniform() - 1.0, 0.0);
    Ray { origin: offset - dir * 10.0, dir }
}

const ORDERS: usize = 8;

/// What leaves a body: by number of meetings with the outer surface, and by angle.
struct Scattered {
    forward: DVec3,
    fibre: bool,
    met: usize,
    histories: f64,
    absorbed: f64,
    /// Σ of w, w·cos, (w·cos)².
    cos: [f64; 3],
    /// Per order (the last: all beyond): Σ w, Σ w².
    orders: [[f64; 2]; ORDERS],
    /// Per degree of the scattering angle (fibres: of the azimuth about the axis, as in the table): Σ w, Σ w².
    degrees: Vec<[f64; 2]>,
}

impl Scattered {
    fn along(forward: DVec3, fibre: bool) -> Self {
        Scattered {
            forward,
            fibre,
            met: 0,
            histories: 0.0,
            absorbed: 0.0,
            cos: [0.0; 3],
            orders: [[0.0; 2]; ORDERS],
            degrees: vec![[0.0; 2]; 180],
        }
    }
    /// Mean of a cell and its standard error.
    fn mean(&self, cell: [f64; 2]) -> (f64, f64) {
        let m = cell[0] / self.histories;
        (m, ((cell[1] / self.histories - m * m).max(0.0) / self.histories).sqrt())
    }
}

/// Cosine of the azimuth about z between two directions.
fn azimuth(a: DVec3, b: DVec3) -> f64 {
    let (a, b) = (a.truncate(), b.truncate());
    (a.dot(b) / (a.length() * b.length())).clamp(-1.0, 1.0)
}

impl<const N: usize> Scorer<N> for Scattered {
    fn step<P>(&mut self, _: &Path<P, N>, _: f64, _: &[f64; N], absorbed: &[f64; N]) {
        self.absorbed += absorbed[0];
    }
    fn interface<P>(&mut self, _: &Path<P, N>, at: &Interface) -> bool {
        self.met += usize::from(at.body == OUTER);
        false
    }
    fn leaves<P>(&mut self, path: &Path<P, N>, _: Face) {
        let w = path.power[0];
        let cos = path.ray.dir.dot(self.forward).clamp(-1.0, 1.0);
        for (s, x) in self.cos.iter_mut().zip([w, w * cos, w * w * cos * cos]) {
            *s += x;
        }
        let order = &mut self.orders[(self.met - 1).min(ORDERS - 1)];
        order[0] += w;
        order[1] += w * w;
        // The forward direction of a fibre lies in the x–z plane, its axis is z.
        let turn = if self.fibre { azimuth(path.ray.dir, self.forward) } else { cos };
        let bin = &mut self.degrees[(turn.acos().to_degrees() as usize).min(179)];
        bin[0] += w;
        bin[1] += w * w;
    }
}

impl<const N: usize> Score<N> for Scattered {
    fn end(&mut self) {
        self.met = 0;
        self.histories += 1.0;
    }
    fn merge(&mut self, o: Self) {
        self.histories += o.histories;
        self.absorbed += o.absorbed;
        self.cos.iter_mut().zip(o.cos).for_each(|(a, b)| *a += b);
        let cells = self.orders.iter_mut().chain(&mut self.degrees);
        for (a, b) in cells.zip(o.orders.iter().chain(&o.degrees)) {
            a[0] += b[0];
            a[1] += b[1];
        }
    }
}

/// The body of a row in the beam; `shift` is added to its index.
fn scattered(row: &Row, shift: f64, count: u64) -> Scattered {
    let universe = body(row);
    let mu_a = row.f("absorption_coeff_x_outer_radius");
    let solid = Medium::clear(row.f("n_rel") + shift).with([mu_a], 0.0, Phase::Isotropic);
    let light =
        Light { media: vec![Medium::clear(1.0), solid], surfaces: vec![SurfaceLaw::default()], lanes: 1 };
    let world = World { roulette: 0.0, ..world(&universe, &light, 0.0) };
    let forward = beam(row, &mut Stream::of(0, 0, 0, Purpose::Probe)).dir;
    let fibre = row.text("shape") == "cyl";
    walk(&world, count, || Scattered::along(forward, fibre), |rng| beam(row, rng))
}

/// The same in the full loop with polarisation: unpolarised light that surfaces polarise.
fn scattered_polarised(row: &Row, count: u64) -> Scattered {
    let universe = body(row);
    let mu_a = row.f("absorption_coeff_x_outer_radius");
    let solid = Medium::clear(row.f("n_rel")).with([mu_a; 2], 0.0, Phase::Isotropic);
    let light =
        Light { media: vec![Medium::clear(1.0), solid], surfaces: vec![SurfaceLaw::default()], lanes: 1 };
    let matrices = vec![ScatteringMatrix::Depolarising; 2];
    let polarisation = Some(Polarisation { source: State::default(), matrices, analyser: None });
    let full = Full { polarisation, ..Full::default() };
    let world = World { roulette: 0.0, full: Some(&full), ..world(&universe, &light, 0.0) };
    let forward = beam(row, &mut Stream::of(0, 0, 0, Purpose::Probe)).dir;
    let fibre = row.text("shape") == "cyl";
    walk(&world, count, || Scattered::along(forward, fibre), |rng| beam(row, rng))
}

/// With polarisation on, <cos Θ> and the energies per order meet the polarised columns; without, they
/// miss them by many errors.
#[test]
fn go_particles_polarised() {
    let off = |row: &Row, seen: &Scattered| {
        let n = seen.histories;
        let cos = seen.cos[1] / seen.cos[0];
        let se = ((seen.cos[2] / n - (seen.cos[1] / n).powi(2)) / n).sqrt() * n / seen.cos[0];
        let d = (cos - row.f("mean_cosTheta_polarised(s,p separate)")).abs();
        let mut worst = (d / 1e-3).max(d / (5.0 * se));
        for (order, cell) in seen.orders.iter().enumerate().take(7) {
            let (got, se) = seen.mean(*cell);
            let want = row.f(&format!("E{order}_pol"));
            worst = worst.max((got - want).abs() / (5.0 * se + row.f("quad_diff").max(1e-9)));
        }
        println!("{:<40} <cos> {cos:.6} ± {se:.6}; worst {worst:.3} of its tolerance", row.text("case"));
        worst
    };
    let given = |row: &Row| row.maybe("mean_cosTheta_polarised(s,p separate)").is_some();
    hold("go_particles.csv", |row| {
        if !given(row) {
            return Check::Cannot("the table has no polarised value");
        }
        Check::Deviation(off(row, &scattered_polarised(row, COUNT)))
    });
    for row in rows("go_particles.csv").iter().filter(|r| given(r)) {
        assert!(off(row, &scattered(row, 0.0, COUNT)) > 1.0, "{}: scalar light passes too", row.text("case"));
    }
}

const COUNT: u64 = 4_000_000;

thread_local! {
    static KEPT: RefCell<HashMap<String, Scattered>> = RefCell::default();
}

/// Deviation of the scattered light from a row: <cos Θ> within 1e-3 and 5 standard errors, absorbed
/// share and energies per order within 5 standard errors.
fn deviation(row: &Row, seen: &Scattered) -> f64 {
    let n = seen.histories;
    let mean_cos = seen.cos[1] / seen.cos[0];
    let se_cos = ((seen.cos[2] / n - (seen.cos[1] / n).powi(2)) / n).sqrt() * n / seen.cos[0];
    let want = row.f("mean_cosTheta_scalarFresnel");
    let off = (mean_cos - want).abs();
    let mut worst = (off / 1e-3).max(off / (5.0 * se_cos));
    worst = worst.max((seen.absorbed / n - row.f("absorbed_fraction")).abs() / 3e-4);
    for (order, cell) in seen.orders.iter().enumerate() {
        let column = if order < 7 { format!("E{order}_scalar") } else { "E_rest_scalar".to_owned() };
        let (got, se) = seen.mean(*cell);
        let d = (got - row.f(&column)).abs() / (5.0 * se + row.f("quad_diff").max(1e-9));
        worst = worst.max(d);
    }
    worst
}

#[test]
fn go_particles() {
    hold("go_particles.csv", |row| {
        let seen = scattered(row, 0.0, COUNT);
        let d = deviation(row, &seen);
        println!(
            "{:<40} <cos> {:.6} (table {:.6}), absorbed {:.6}; worst {d:.3} of its tolerance",
            row.text("case"),
            seen.cos[1] / seen.cos[0],
            row.f("mean_cosTheta_scalarFresnel"),
            seen.absorbed / seen.histories
        );
        Check::Deviation(d)
    });
}

/// The tolerance bites: index + 0.02 shows in every row.
#[test]
fn go_particles_notice() {
    for row in rows("go_particles.csv") {
        let d = deviation(&row, &scattered(&row, 0.02, COUNT / 8));
        println!("{}: n + 0.02 → {d:.1} tolerances", row.text("case"));
        assert!(d > 1.0, "{} does not notice", row.text("case"));
    }
}

/// Energy per degree: z-test with the level of Šidák over all bins (5.0 σ for a family error of
/// 0.1 %), the table's own grid error, and 12/N for bins that hardly any history reaches.
#[test]
fn go_histograms() {
    let bodies = rows("go_particles.csv");
    let check = |row: &Row, shift: f64, count: u64| {
        KEPT.with_borrow_mut(|kept| {
            let case = row.text("case");
            let seen = kept.entry(format!("{case} {shift}")).or_insert_with(|| {
                scattered(bodies.iter().find(|b| b.text("case") == case).unwrap(), shift, count)
            });
            let (got, se) = seen.mean(seen.degrees[row.u("bin_lo_deg") as usize]);
            let tolerance = (5.0 * se).max(12.0 / seen.histories) + row.f("grid_diff");
            within(got, row.f("energy_scalar"), tolerance)
        })
    };
    hold("go_histograms.csv", |row| check(row, 0.0, COUNT));
    println!("go_histograms.csv: column energy_pol not expressible: polarisation is not in this version");
    let failed = rows("go_histograms.csv")
        .iter()
        .filter(|r| r.text("case") == "sphere_n1.5")
        .filter(|r| matches!(check(r, 0.01, COUNT / 2), Check::Deviation(d) if d > 1.0))
        .count();
    println!("sphere_n1.5 with n + 0.01: {failed} bins fail");
    assert!(failed >= 10);
}

/// Hears where the one ray of a history goes and with which power.
#[derive(Default)]
struct Out(DVec3, f64);

impl Scorer<1> for Out {
    fn leaves<P>(&mut self, path: &Path<P, 1>, _: Face) {
        *self = Out(path.ray.dir, path.power[0]);
    }
}

/// A specular opaque sphere: one ray at impact parameter b gives (cos of scattering, reflectance).
fn mirror(light: &Light<1>, b: f64) -> (f64, f64) {
    let sphere = Part {
        shape: Placed::at_origin(Shape::Ellipsoid(Ellipsoid::sphere(1.0))),
        medium: SOLID,
        surface: SurfaceId(1),
        priority: 0,
        body: OUTER,
    };
    let universe = SyntheticUniverse::new(AIR, vec![sphere]).unwrap();
    let world = World { roulette: 0.0, ..world(&universe, light, 0.0) };
    let ray = Ray { origin: DVec3::new(b, 0.0, 4.0), dir: -DVec3::Z };
    let mut out = Out::default();
    let mut h = History::default();
    trace(&world, ray, &mut h, &mut out, &mut Stream::of(1, 0, 0, Purpose::Transport));
    assert!(h.ledger.imbalance(1) < 1e-12);
    (-out.0.z, out.1)
}

/// Differential cross-section from traced rays: |d(b²)|/2 over |d cos Θ| times the reflectance; scattered
/// fraction and mean cosine by quadrature over the impact parameter b = sin φ.
fn copper_row(row: &Row, shift: f64) -> Check {
    let mut metal = Medium::clear(1.0);
    metal.n = Complex64::new(row.f("n") + shift, row.f("k"));
    metal.real = false;
    let opaque = SurfaceLaw { opaque: true, ..SurfaceLaw::default() };
    let light = Light {
        media: vec![Medium::clear(1.0), metal],
        surfaces: vec![SurfaceLaw::default(), opaque],
        lanes: 1,
    };
    // A sphere sends impact b to the angle with cos² of half of it = b².
    let half = 0.5 * row.f("scatter_angle_deg").to_radians();
    let b2 = half.cos().powi(2);
    let (near, far) = ((b2 - 1e-6).max(0.0), (b2 + 1e-6).min(1.0 - 1e-12));
    let (c0, _) = mirror(&light, near.sqrt());
    let (c1, _) = mirror(&light, far.sqrt());
    let (cos, r) = mirror(&light, half.cos());
    assert!((cos - row.f("scatter_angle_deg").to_radians().cos()).abs() < 1e-9, "angle {cos}");
    let sigma = 0.5 * (far - near) / (c1 - c0) * r;
    let (mut all, mut forward) = (0.0, 0.0);
    for (phi, w) in gauss_legendre(64, 0.0, std::f64::consts::FRAC_PI_2) {
        let (cos, r) = mirror(&light, phi.sin());
        all += w * (2.0 * phi).sin() * r;
        forward += w * (2.0 * phi).sin() * r * cos;
    }
    let pairs = [
        (sigma, "dsigma/dOmega/a^2"),
        (all, "scattered_fraction_of_pi_a2"),
        (forward / all, "mean_cos_of_scattered"),
    ];
    let worst = pairs.iter().map(|(got, c)| (got - row.f(c)).abs() / 1e-8).fold(0.0, f64::max);
    Check::Deviation(if worst.is_nan() { f64::INFINITY } else { worst })
}

#[test]
fn copper_sphere() {
    hold("copper_sphere_scatter.csv", |row| copper_row(row, 0.0));
    for row in rows("copper_sphere_scatter.csv") {
        assert!(matches!(copper_row(&row, 1e-5), Check::Deviation(d) if d > 1.0), "n + 1e-5 goes unnoticed");
    }
}

mod statistical {
    //! The same bodies as statistical ones: encounters follow the hits of a synthetic body.

    use super::*;
    use crate::transport::Sheet;
    use lightpro::law::{Roll, SizeLaw, Tilt};
    use lightpro::universe::statistical::amount::Target;
    use lightpro::universe::statistical::kind::{Kind, Sizes};
    use lightpro::universe::statistical::section::{Left, Part as In};
    use lightpro::universe::{Next, Universe};

    /// P of a two-sample Kolmogorov–Smirnov statistic at least as large (asymptotic law).
    pub fn two_sample(mut a: Vec<f64>, mut b: Vec<f64>) -> f64 {
        a.sort_by(f64::total_cmp);
        b.sort_by(f64::total_cmp);
        let (n, m) = (a.len() as f64, b.len() as f64);
        let (mut i, mut j, mut d) = (0, 0, 0.0_f64);
        while i < a.len() && j < b.len() {
            let x = a[i].min(b[j]);
            i += a[i..].partition_point(|v| *v <= x);
            j += b[j..].partition_point(|v| *v <= x);
            d = d.max((i as f64 / n - j as f64 / m).abs());
        }
        let lambda = d * (n * m / (n + m)).sqrt();
        let terms = (1..100).map(f64::from);
        let sum: f64 = terms
            .map(|k| (if k as u32 % 2 == 1 { 2.0 } else { -2.0 }) * (-2.0 * k * k * lambda * lambda).exp())
            .sum();
        if lambda < 0.3 { 1.0 } else { sum.clamp(0.0, 1.0) }
    }

    /// What is compared, per hit: entry cosine, outward normal, chord through the whole body, way to
    /// the first surface inside (lumen or far side), distance of the ray from the body's centre line.
    const LAWS: [&str; 7] = ["cos", "n_x", "n_y", "n_z", "chord", "first", "offset"];

    fn by_kind(kind: &Kind, dir: DVec3, rng: &mut Stream) -> [f64; 7] {
        loop {
            let at = DVec3::new(3.0, -2.0, 1.0);
            let Some(met) = kind.candidate(dir, at, 0, rng) else { continue };
            let whole = lightpro::universe::statistical::section::Body { lumen: None, ..met.body };
            let chord = whole.leave(at, dir, In::Wall, Left::Outer).unwrap().t;
            let first = met.body.leave(at, dir, In::Wall, Left::Outer).unwrap().t;
            let n = met.outward;
            let offset = offset(at - met.body.centre, dir, met.body.frame.z, kind.is_fibre());
            return [-n.dot(dir), n.x, n.y, n.z, chord, first, offset];
        }
    }

    /// Distance of the line from the fibre's axis, or from the centre.
    fn offset(from: DVec3, dir: DVec3, axis: DVec3, fibre: bool) -> f64 {
        if fibre { from.dot(dir.cross(axis)) / dir.cross(axis).length() } else { from.cross(dir).length() }
    }

    /// Geometry of a body with full freedom of the test: half axes, lumen, orientation law.
    struct Example {
        name: &'static str,
        sheet: Sheet,
        dir: DVec3,
    }

    /// The same by a synthetic body at the origin: a random orientation, and rays sent blindly into a
    /// disc (fibres: a strip across the axis) that covers any of its shadows.
    fn by_body(e: &Example, rng: &mut Stream) -> [f64; 7] {
        loop {
            let (frame, shape, lumen) = draw(&e.sheet, rng);
            let fibre = matches!(shape, Shape::Cylinder(_));
            let part = |shape, body| Part {
                shape: Placed::new(shape, DVec3::ZERO, frame),
                medium: SOLID,
                surface: SurfaceId(1),
                priority: 0,
                body,
            };
            let outer = SyntheticUniverse::new(AIR, vec![part(shape, OUTER)]).unwrap();
            // Beside a ray line fixed in space the axis stands uniformly over the plane across the
            // ray: the strip is met in proportion to sin γ.
            let start = if fibre {
                let across = e.dir.cross(frame.z);
                if rng.uniform() >= across.length() {
                    continue;
                }
                across.normalize() * (2.0 * rng.uniform() - 1.0)
            } else {
                let (x, y) = lightpro::math::orthonormal(e.dir);
                let (r, (c, s)) = (1.01 * rng.uniform().sqrt(), rng.azimuth());
                (x * c + y * s) * r
            };
            let far = if fibre { 1.0 / e.dir.cross(frame.z).length() } else { 1.0 };
            let mut ray = Ray { origin: start - e.dir * (3.0 * far), dir: e.dir };
            let mut place = outer.enter(&ray, &mut (), rng).place;
            let Next::Interface(at) = outer.next(&ray, &mut place, &mut (), f64::INFINITY, rng) else {
                continue;
            };
            ray.origin = ray.at(at.distance);
            outer.crossed(&mut ray, &mut place, &mut (), &at);
            let inside = |u: &SyntheticUniverse, place: &mut _, rng: &mut Stream| match u.next(
                &ray,
                place,
                &mut (),
                f64::INFINITY,
                rng,
            ) {
                Next::Interface(at) => at.distance,
                other => panic!("{other:?}"),
            };
            let chord = inside(&outer, &mut place, rng);
            let first = match lumen {
                None => chord,
                Some(l) => {
                    let lumen = SyntheticUniverse::new(AIR, vec![part(l, INNER)]).unwrap();
                    let mut place = lumen.enter(&ray, &mut (), rng).place;
                    match lumen.next(&ray, &mut place, &mut (), chord, rng) {
                        Next::Interface(at) => at.distance,
                        _ => chord,
                    }
                }
            };
            let n = at.normal;
            let offset = offset(ray.origin, e.dir, frame.z, fibre);
            return [-n.dot(e.dir), n.x, n.y, n.z, chord, first, offset];
        }
    }

    /// Orientation and shape by the laws of the sheet, written out here again.
    fn draw(sheet: &Sheet, rng: &mut Stream) -> (Frame, Shape, Option<Shape>) {
        let constant = |l: &SizeLaw| if let SizeLaw::Constant(x) = l { *x } else { panic!("constants only") };
        let axis = match sheet.tilt {
            Tilt::InPlane => {
                let (c, s) = rng.azimuth();
                DVec3::new(c, s, 0.0)
            }
            _ => {
                let (z, (c, s)) = (2.0 * rng.uniform() - 1.0, rng.azimuth());
                let r = (1.0 - z * z).sqrt();
                DVec3::new(r * c, r * s, z)
            }
        };
        let flat = DVec3::Z.cross(axis).normalize();
        let x = match sheet.roll {
            Roll::Flat => flat,
            _ => {
                let (c, s) = rng.azimuth();
                flat * c + axis.cross(flat) * s
            }
        };
        let frame = Frame { x, y: axis.cross(x), z: axis };
        match &sheet.sizes {
            Sizes::Fibre { width, flatness, wall, .. } => {
                let a = 0.5 * constant(width);
                let b = a * constant(flatness);
                let lumen = wall.as_ref().map(|w| (a - constant(w), b - constant(w)));
                let shape = |a, b| Shape::Cylinder(EllipticCylinder { a, b, half_length: None });
                (frame, shape(a, b), lumen.map(|(a, b)| shape(a, b)))
            }
            Sizes::Sphere(d) => (frame, Shape::Ellipsoid(Ellipsoid::sphere(0.5 * constant(d))), None),
            Sizes::Ellipsoid(d) => {
                let [a, b, c] = [0, 1, 2].map(|i| 0.5 * constant(&d[i]));
                (frame, Shape::Ellipsoid(Ellipsoid { a, b, c }), None)
            }
            Sizes::Disc { diameter, thickness } => {
                let (r, half) = (0.5 * constant(diameter), 0.5 * constant(thickness));
                let disc = EllipticCylinder { a: r, b: r, half_length: Some(half) };
                (frame, Shape::Cylinder(disc), None)
            }
        }
    }

    fn examples() -> Vec<Example> {
        let towards = |polar: f64| {
            let (s, c) = polar.to_radians().sin_cos();
            DVec3::new(s * 0.6, s * 0.8, -c)
        };
        let fibres = |wall| Sheet::fibres(1.0, wall, Target::Body(0.3), 10.0);
        let elliptic = |wall, roll| Sheet {
            sizes: Sizes::Fibre {
                width: SizeLaw::Constant(2.0),
                flatness: SizeLaw::Constant(0.35),
                wall,
                length: None,
            },
            roll,
            ..fibres(None)
        };
        let axes = [1.6, 1.0, 0.4].map(SizeLaw::Constant);
        let wall = Some(SizeLaw::Constant(0.1));
        vec![
            Example { name: "fibre across", sheet: fibres(None), dir: towards(0.0) },
            Example {
                name: "hollow fibre in plane, 30°",
                sheet: fibres(Some(4.0 / 15.0)),
                dir: towards(30.0),
            },
            Example {
                name: "hollow fibre in plane, 60°",
                sheet: fibres(Some(4.0 / 15.0)),
                dir: towards(60.0),
            },
            Example {
                name: "flat elliptic fibre, 40°",
                sheet: elliptic(None, Roll::Flat),
                dir: towards(40.0),
            },
            Example {
                name: "flat hollow elliptic fibre, 70°",
                sheet: elliptic(wall.clone(), Roll::Flat),
                dir: towards(70.0),
            },
            Example {
                name: "rolled hollow elliptic fibre",
                sheet: elliptic(wall, Roll::Uniform),
                dir: towards(20.0),
            },
            Example {
                name: "isotropic hollow fibre",
                sheet: Sheet { tilt: Tilt::Isotropic, ..fibres(Some(0.27)) },
                dir: towards(0.0),
            },
            Example {
                name: "sphere",
                sheet: Sheet::spheres(1.0, Target::Body(0.3), 10.0),
                dir: towards(50.0),
            },
            Example {
                name: "isotropic ellipsoid",
                sheet: Sheet { sizes: Sizes::Ellipsoid(axes), tilt: Tilt::Isotropic, ..fibres(None) },
                dir: towards(25.0),
            },
        ]
    }

    fn columns(hits: Vec<[f64; 7]>) -> [Vec<f64>; 7] {
        std::array::from_fn(|k| hits.iter().map(|h| h[k]).collect())
    }

    /// Laws of the sample whose p-value lies under the Šidák level of the whole family.
    fn differing(e: &Example, by: &Kind, count: usize) -> (Vec<&'static str>, f64) {
        let level = lightpro::stats::sidak(1e-3, 9 * LAWS.len());
        let mut rng = Stream::of(20_261_122, 3, 0, Purpose::Probe);
        let a = columns((0..count).map(|_| by_kind(by, e.dir, &mut rng)).collect());
        let b = columns((0..count).map(|_| by_body(e, &mut rng)).collect());
        let mut least = 1.0_f64;
        let mut names = Vec::new();
        for ((a, b), name) in a.into_iter().zip(b).zip(LAWS) {
            // n_z of an in-plane fibre met across is the cosine itself; a constant law (0 against
            // rounding) has no distribution to compare.
            let spread = a.iter().fold(0.0_f64, |m, x| m.max((x - a[0]).abs()));
            if spread < 1e-9 {
                continue;
            }
            let p = two_sample(a, b);
            least = least.min(p);
            if p < level {
                names.push(name);
            }
        }
        (names, least)
    }

    #[test]
    fn encounters_follow_synthetic_hits() {
        for e in examples() {
            let (names, least) = differing(&e, &e.sheet.kind(), 60_000);
            println!("{:<34} least p of {} laws: {least:.4}", e.name, LAWS.len());
            assert!(names.is_empty(), "{}: {names:?} differ, p {least:e}", e.name);
        }
    }

    /// The test bites: a fibre 2 % wider, or round instead of flat, is told apart.
    #[test]
    fn encounters_tell_bodies_apart() {
        let all = examples();
        let wider = Sheet::fibres(1.02, None, Target::Body(0.3), 10.0).kind();
        let (names, least) = differing(&all[0], &wider, 60_000);
        println!("2 % wider: {names:?}, p {least:e}");
        assert!(!names.is_empty());
        let (names, least) = differing(&all[3], &all[5].sheet.kind(), 60_000);
        println!("rolled for flat: {names:?}, p {least:e}");
        assert!(names.len() >= 4);
    }
}
