//! Free paths, chords, normals and widths against their closed forms.

use crate::harness::{Check, hold, rows};
use crate::transport::*;
use crate::{down, stream};
use lightpro::law::{Azimuth, Roll, SizeLaw, Tilt};
use lightpro::math::{DVec3, PI, gauss_legendre};
use lightpro::rng::Stream;
use lightpro::stats::{Moments, ks_p_value, sidak};
use lightpro::universe::statistical::StatisticalUniverse;
use lightpro::universe::statistical::amount::Target;
use lightpro::universe::statistical::kind::{Encounter, Kind, Sizes};
use lightpro::universe::statistical::section::{Left, Part};
use lightpro::universe::{Next, Ray, Universe};

/// A layer so high that no path below ends at a plane.
const HIGH: f64 = 1e9;

fn free_paths(universe: &StatisticalUniverse, dir: DVec3, count: usize) -> Vec<f64> {
    let mut rng = stream(1);
    let ray = Ray { origin: DVec3::new(0.0, 0.0, 0.5 * HIGH), dir };
    let draw = |_| {
        let mut place = universe.enter(&ray, &mut (), &mut rng).place;
        match universe.next(&ray, &mut place, &mut (), f64::INFINITY, &mut rng) {
            Next::Interface(at) => at.distance,
            other => panic!("{other:?}"),
        }
    };
    (0..count).map(draw).collect()
}

/// A sheet of one density, met at the Boolean rate.
fn dense(sheet: Sheet) -> StatisticalUniverse {
    Sheet { height: HIGH, ..sheet }.build()
}

/// Mean free path and its standard error.
fn mean_path(universe: &StatisticalUniverse, dir: DVec3, count: usize) -> (f64, f64) {
    let mut m = Moments::default();
    free_paths(universe, dir, count).into_iter().for_each(|x| m.add(x));
    (m.mean(), m.standard_error())
}

/// Free paths of the table's Boolean ensembles: exponential with the tabulated mean
/// (Kolmogorov–Smirnov, family error 0.1 %).
#[test]
fn free_paths_are_exponential() {
    let level = sidak(1e-3, rows("boolean_void_free_path.csv").len());
    let check = |row: &crate::harness::Row, stretch: f64| {
        let r = row.f("R") * stretch;
        let density = Target::Density(row.f("density(number or length per volume)"));
        let sheet = match row.text("model") {
            "spheres" => Sheet::spheres(r, density, HIGH),
            "cylinders_isotropic_3D" => {
                Sheet { tilt: Tilt::Isotropic, ..Sheet::fibres(r, None, density, HIGH) }
            }
            _ => Sheet::fibres(r, None, density, HIGH),
        };
        let polar = row.maybe("ray_angle_from_z_deg").unwrap_or(35.0).to_radians();
        let mean = row.f("mean_free_path_in_void(exponential law)");
        let mut paths = free_paths(&dense(sheet), down(polar), 300_000);
        paths.sort_by(f64::total_cmp);
        // In units of the tolerance: the level is reached at 1.
        let p = ks_p_value(&paths, |x| 1.0 - (-x / mean).exp()).max(1e-300);
        Check::Deviation(p.ln() / level.ln())
    };
    hold("boolean_void_free_path.csv", |row| check(row, 1.0));
    let failed = rows("boolean_void_free_path.csv")
        .iter()
        .filter(|r| matches!(check(r, 1.02), Check::Deviation(d) if d > 1.0))
        .count();
    println!("radius + 2 %: {failed} of 36 rows fail");
    assert!(failed == 36);
}

/// A hit of a kind by a ray along `dir`, at the origin.
fn hit(kind: &Kind, dir: DVec3, rng: &mut Stream) -> Encounter {
    loop {
        if let Some(met) = kind.candidate(dir, DVec3::ZERO, 0, rng) {
            return met;
        }
    }
}

fn chord(kind: &Kind, dir: DVec3, rng: &mut Stream) -> f64 {
    hit(kind, dir, rng).body.leave(DVec3::ZERO, dir, Part::Wall, Left::Outer).unwrap().t
}

/// Chords of what is met, at the table's points of the distribution function (4 standard errors of a
/// binomial share) and in the mean.
#[test]
fn chords_follow_their_laws() {
    const COUNT: usize = 400_000;
    let kept = std::cell::RefCell::new(std::collections::HashMap::new());
    let check = |row: &crate::harness::Row, flatten: f64| {
        let r = row.f("R");
        let shape = row.text("shape").to_owned();
        let mut kept = kept.borrow_mut();
        let sample = kept.entry(format!("{shape} {r} {flatten}")).or_insert_with(|| {
            let mut rng = stream(2);
            let sheet = match shape.as_str() {
                "sphere" => Sheet::spheres(r, Target::Body(0.3), 10.0),
                "infinite_cylinder" => Sheet {
                    tilt: Tilt::Isotropic,
                    sizes: Sizes::Fibre {
                        width: SizeLaw::Constant(2.0 * r),
                        flatness: SizeLaw::Constant(flatten),
                        wall: None,
                        length: None,
                    },
                    ..Sheet::fibres(r, None, Target::Body(0.3), 10.0)
                },
                // The chord of a layer in diffuse light: no body needed.
                _ => {
                    let layer = plain_sheet(vec![plain(r, 0.0, AIR)]);
                    let step = |_| {
                        let ray = diffuse(r).emit(&mut rng);
                        let mut place = layer.enter(&ray, &mut (), &mut rng).place;
                        match layer.next(&ray, &mut place, &mut (), f64::INFINITY, &mut rng) {
                            Next::Edge { distance, .. } => distance,
                            other => panic!("{other:?}"),
                        }
                    };
                    return (0..COUNT).map(step).collect::<Vec<f64>>();
                }
            };
            let kind = sheet.kind();
            (0..COUNT).map(|_| chord(&kind, down(0.6), &mut rng)).collect()
        });
        let n = COUNT as f64;
        let want = row.f("CDF(chord<=l)");
        let limit = row.f("l_over_R") * r * (1.0 + 1e-12);
        let share = sample.iter().filter(|c| **c <= limit).count() as f64 / n;
        let mut worst = (share - want).abs() / (4.0 * (want * (1.0 - want) / n).sqrt()).max(12.0 / n);
        let mut m = Moments::default();
        sample.iter().for_each(|c| m.add(*c));
        // Slabs have no variance of the chord: their mean converges too slowly to be asked.
        if row.maybe("second_moment").is_some_and(f64::is_finite) {
            worst = worst.max((m.mean() - row.f("mean_chord")).abs() / (4.0 * m.standard_error()));
        }
        Check::Deviation(worst)
    };
    hold("chord_cdf.csv", |row| check(row, 1.0));
    let failed = rows("chord_cdf.csv")
        .iter()
        .filter(|r| r.text("shape") == "infinite_cylinder")
        .filter(|r| matches!(check(r, 0.98), Check::Deviation(d) if d > 1.0))
        .count();
    println!("cylinders flattened by 2 %: {failed} of 14 rows fail");
    assert!(failed == 14);
}

/// Mean chord 4V/S (Cauchy) and second moment of isotropic ellipsoids.
#[test]
fn ellipsoids_have_the_mean_chord_of_cauchy() {
    let check = |row: &crate::harness::Row, stretch: f64| {
        let axes = ["a", "b", "c"].map(|c| SizeLaw::Constant(2.0 * row.f(c)));
        let mut axes = axes;
        axes[0] = SizeLaw::Constant(2.0 * row.f("a") * stretch);
        let sheet = Sheet {
            sizes: Sizes::Ellipsoid(axes),
            tilt: Tilt::Isotropic,
            ..Sheet::fibres(1.0, None, Target::Body(0.1), 10.0)
        };
        let (kind, mut rng) = (sheet.kind(), stream(3));
        let (mut mean, mut square) = (Moments::default(), Moments::default());
        for _ in 0..1_000_000 {
            let c = chord(&kind, down(0.4), &mut rng);
            mean.add(c);
            square.add(c * c);
        }
        let d = |m: &Moments, column| (m.mean() - row.f(column)).abs() / (4.0 * m.standard_error());
        Check::Deviation(d(&mean, "mean_chord=4V/S").max(d(&square, "second_moment")))
    };
    hold("chord_ellipsoid.csv", |row| check(row, 1.0));
    for row in rows("chord_ellipsoid.csv") {
        assert!(matches!(check(&row, 1.02), Check::Deviation(d) if d > 1.0), "2 % go unnoticed");
    }
}

/// Cosines of incidence: isotropic surfaces (spheres, isotropic fibres) have density 2µ; an in-plane
/// fibre met vertically has P(cos ≤ c) = 1 − √(1 − c²).
#[test]
fn cosines_of_incidence() {
    let fibres = || Sheet::fibres(1.0, None, Target::Body(0.3), 10.0);
    let isotropic = Sheet { tilt: Tilt::Isotropic, ..fibres() };
    let spheres = Sheet::spheres(1.0, Target::Body(0.3), 10.0);
    let lambert: fn(f64) -> f64 = |c| c * c;
    let across: fn(f64) -> f64 = |c| 1.0 - (1.0 - c * c).max(0.0).sqrt();
    let level = sidak(1e-3, 3);
    let sample = |sheet: &Sheet, dir: DVec3| {
        let (kind, mut rng) = (sheet.kind(), stream(4));
        let mut c: Vec<f64> = (0..300_000).map(|_| -hit(&kind, dir, &mut rng).outward.dot(dir)).collect();
        c.sort_by(f64::total_cmp);
        c
    };
    for (name, sheet, dir, law) in [
        ("spheres", &spheres, down(0.3), lambert),
        ("isotropic fibres", &isotropic, down(0.7), lambert),
        ("in-plane fibres, vertical light", &fibres(), down(0.0), across),
    ] {
        let p = ks_p_value(&sample(sheet, dir), law);
        println!("{name}: p = {p:.4}");
        assert!(p > level, "{name}: p = {p:e}");
    }
    // It bites: light at 10° to the normal is not vertical light.
    assert!(ks_p_value(&sample(&fibres(), down(10_f64.to_radians())), across) < level);
}

/// Rate of elliptic fibres at polar angle θ, axis azimuth φ with density p(φ), major axis flat:
/// Σ/L_V = ∫ p 2√(a² cos²θ + b² sin²θ sin²(φ − φ_ray)) dφ; rolled evenly: mean width perimeter/π.
#[test]
fn elliptic_fibres_are_met_at_the_projected_width() {
    let (a, b, l_v) = (1.0, 0.3, 0.05);
    let sheet = |roll, azimuth| Sheet {
        sizes: Sizes::Fibre {
            width: SizeLaw::Constant(2.0 * a),
            flatness: SizeLaw::Constant(b / a),
            wall: None,
            length: None,
        },
        roll,
        azimuth,
        ..Sheet::fibres(a, None, Target::Density(l_v), HIGH)
    };
    let turn = gauss_legendre(200, 0.0, PI);
    let flat = |theta: f64, azimuth: &dyn Fn(f64) -> f64| -> f64 {
        let width =
            |phi: f64| 2.0 * ((a * theta.cos()).powi(2) + (b * theta.sin() * phi.sin()).powi(2)).sqrt();
        turn.iter().map(|(phi, w)| w * azimuth(*phi) * width(*phi)).sum()
    };
    let uniform = |_: f64| 1.0 / PI;
    let mut worst = 0.0_f64;
    let mut hold = |name: &str, sheet: Sheet, theta: f64, want: f64| {
        let (m, se) = mean_path(&dense(sheet), down(theta), 1_000_000);
        let d = (m * l_v * want - 1.0) / (se / m);
        println!(
            "{name} at {:.0}°: rate {:.6} (closed form {:.6}), {d:+.2} standard errors",
            theta.to_degrees(),
            1.0 / m,
            l_v * want
        );
        assert!(d.abs() < 4.0, "{name}");
        worst = worst.max(d.abs());
    };
    for degrees in [0.0_f64, 30.0, 60.0, 85.0] {
        let theta = degrees.to_radians();
        hold("flat", sheet(Roll::Flat, Azimuth::Uniform), theta, flat(theta, &uniform));
        let perimeter: f64 = gauss_legendre(200, 0.0, PI)
            .iter()
            .map(|(t, w)| 2.0 * w * (a * t.sin()).hypot(b * t.cos()))
            .sum();
        let sin_gamma: f64 =
            turn.iter().map(|(phi, w)| w / PI * (1.0 - (theta.sin() * phi.cos()).powi(2)).sqrt()).sum();
        hold("rolled", sheet(Roll::Uniform, Azimuth::Uniform), theta, perimeter / PI * sin_gamma);
    }
    let rho: f64 = 0.4;
    let cauchy = move |phi: f64| (1.0 - rho * rho) / (PI * (1.0 + rho * rho - 2.0 * rho * (2.0 * phi).cos()));
    let law = Azimuth::wrapped_cauchy(0.0, rho).unwrap();
    let theta = 60_f64.to_radians();
    hold("flat, oriented along the ray", sheet(Roll::Flat, law), theta, flat(theta, &cauchy));
    println!("worst {worst:.2} standard errors");
}

/// Oriented fibres: rates along and across the machine direction, Σ = 2 r L_V ∫ p(φ) |sin(φ − φ_ray)| dφ,
/// with the densities written out here.
#[test]
fn orientation_turns_the_rate() {
    let l_v = 0.1;
    let (kappa, rho): (f64, f64) = (1.5, 0.5);
    let nodes = gauss_legendre(400, 0.0, PI);
    let norm: f64 = nodes.iter().map(|(p, w)| w * (kappa * (2.0 * p).cos()).exp()).sum();
    let mises = move |phi: f64| (kappa * (2.0 * phi).cos()).exp() / norm;
    let cauchy = move |phi: f64| (1.0 - rho * rho) / (PI * (1.0 + rho * rho - 2.0 * rho * (2.0 * phi).cos()));
    type Named<'a> = (&'static str, Azimuth, &'a dyn Fn(f64) -> f64);
    let laws: [Named; 2] = [
        ("von Mises", Azimuth::von_mises(0.0, kappa).unwrap(), &mises),
        ("wrapped Cauchy", Azimuth::wrapped_cauchy(0.0, rho).unwrap(), &cauchy),
    ];
    for (name, azimuth, pdf) in laws {
        let sheet = || Sheet { azimuth, ..Sheet::fibres(1.0, None, Target::Density(l_v), HIGH) };
        let mut rates = Vec::new();
        for (way, dir, shift) in [("MD", DVec3::X, 0.0), ("CD", DVec3::Y, PI / 2.0)] {
            let mean_sin: f64 = nodes.iter().map(|(p, w)| w * pdf(p + shift) * p.sin()).sum();
            let want = 2.0 * l_v * mean_sin;
            let (m, se) = mean_path(&dense(sheet()), dir, 1_000_000);
            let d = (m * want - 1.0) / (se / m);
            println!("{name} {way}: rate {:.6} (quadrature {want:.6}), {d:+.2} standard errors", 1.0 / m);
            assert!(d.abs() < 4.0, "{name} {way}");
            rates.push(1.0 / m);
        }
        assert!(rates[1] > 1.3 * rates[0], "orientation must show: {rates:?}");
    }
}
