//! What holds in a lossless, diffusely lit sheet whatever the bodies do with light.

use crate::transport::*;
use lightpro::lpm::Medium;
use lightpro::math::PI;
use lightpro::phase::Phase;
use lightpro::universe::statistical::amount::{Rule, Target};

const HEIGHT: f64 = 10.0;
const SHARE: f64 = 0.3;

/// One invariant: value found, its standard error, value demanded.
struct Invariant(&'static str, (f64, f64), f64);

/// All invariants at `count` histories.
fn measured(count: u64) -> Vec<Invariant> {
    let white = || light(Medium::clear(1.0), Some(opaque_lambertian(1.0)));
    let fibres = Sheet { surface: OWN, ..Sheet::fibres(1.0, None, Target::Body(SHARE), HEIGHT) };
    let length = -(1.0 - SHARE).ln() / PI;
    let f = run(&fibres.build(), &white(), &diffuse(HEIGHT), HEIGHT, count);
    let spheres = Sheet { surface: OWN, ..Sheet::spheres(1.0, Target::Body(SHARE), HEIGHT) };
    let number = -(1.0 - SHARE).ln() / (4.0 / 3.0 * PI);
    let s = run(&spheres.build(), &white(), &diffuse(HEIGHT), HEIGHT, count);
    let matched = Sheet {
        rule: Rule::Apart,
        start_in_bodies: true,
        ..Sheet::fibres(1.0, None, Target::Body(SHARE), HEIGHT)
    };
    let scatters = light(Medium::clear(1.0).with([0.0], 0.5, Phase::HenyeyGreenstein(0.5)), None);
    let m = run(&matched.build(), &scatters, &diffuse(HEIGHT), HEIGHT, count);
    vec![
        Invariant("white fibres: void path 2H", f.path(AIR), 2.0 * HEIGHT),
        Invariant("white fibres: collisions π r L_V H", f.interfaces(), PI * length * HEIGHT),
        Invariant("white spheres: void path 2H", s.path(AIR), 2.0 * HEIGHT),
        Invariant("white spheres: collisions 2H π a² n", s.interfaces(), 2.0 * HEIGHT * PI * number),
        Invariant("index-matched scattering fibres: path inside 2Hφ", m.path(SOLID), 2.0 * HEIGHT * SHARE),
        Invariant("index-matched scattering fibres: path outside", m.path(AIR), 2.0 * HEIGHT * (1.0 - SHARE)),
    ]
}

fn hold(count: u64, sigmas: f64, precision: f64) {
    for Invariant(name, (got, se), want) in measured(count) {
        println!(
            "{name}: {got:.5} ± {se:.5} (3 standard errors: {:.3} %), want {want:.5}, {:+.2} standard errors",
            300.0 * se / got,
            (got - want) / se
        );
        assert!((got - want).abs() < sigmas * se, "{name}");
        assert!(3.0 * se < precision * want, "{name}: 3 standard errors are {:.2e}", 3.0 * se / want);
    }
}

/// At a precision (three standard errors) of 0.3 %; six figures at once are allowed 3.51 standard errors, the
/// level of one at 3 (Šidák). The long run below holds each to 3.
#[test]
fn lossless_sheets() {
    hold(1_500_000, 3.51, 3e-3);
}

/// Within three standard errors of 0.1 %.
#[test]
#[ignore = "long: cargo test --release --test statistical_universe lossless_sheets_closely -- --ignored --nocapture"]
fn lossless_sheets_closely() {
    hold(16_000_000, 3.0, 1e-3);
}

/// The invariant bites: 2 % absorption at each collision shows.
#[test]
fn losses_show() {
    let fibres = Sheet { surface: OWN, ..Sheet::fibres(1.0, None, Target::Body(SHARE), HEIGHT) };
    let grey = light(Medium::clear(1.0), Some(opaque_lambertian(0.98)));
    let (got, se) = run(&fibres.build(), &grey, &diffuse(HEIGHT), HEIGHT, 200_000).path(AIR);
    assert!(2.0 * HEIGHT - got > 10.0 * se, "{got} ± {se}");
}
