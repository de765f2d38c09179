//! Slab P1: µa 1, µs 9 /mm, Henyey–Greenstein g 0.75, 0.2 mm, index-matched, light at 0°. The case by
//! which Monte Carlo codes of turbid media are compared.
#![allow(missing_docs)]

mod common;

use common::{Case, best_ns, report};
use divan::Bencher;
use divan::counter::ItemsCount;
use lightpro::lpm::surface::SurfaceLaw;
use lightpro::lpm::{Light, Medium, World};
use lightpro::math::DVec3;
use lightpro::phase::Phase;
use lightpro::rng::Stream;
use lightpro::source::Source;
use lightpro::universe::sheet::Slab;
use lightpro::universe::statistical::{Population, Rules, Rung, StatisticalUniverse};
use lightpro::universe::{MediumId, SurfaceId};
use std::hint::black_box;

const HEIGHT: f64 = 200.0;

fn universe() -> StatisticalUniverse {
    let layer =
        Population::plain(Slab { top: HEIGHT, bottom: 0.0, pore: MediumId(1), surface: SurfaceId::SMOOTH });
    let rules = Rules {
        rung: Rung::Homogeneous,
        outside: MediumId(0),
        bottom_surface: SurfaceId::SMOOTH,
        contained: false,
        start_in_bodies: false,
        backing: false,
        clear: [true; 2],
    };
    StatisticalUniverse::new(vec![layer], rules)
}

fn light() -> Light<1> {
    let turbid = Medium::clear(1.0).with([1e-3], 9e-3, Phase::HenyeyGreenstein(0.75));
    Light { media: vec![Medium::clear(1.0), turbid], surfaces: vec![SurfaceLaw::default()], lanes: 1 }
}

fn case<'a>(universe: &'a StatisticalUniverse, light: &'a Light<1>) -> Case<'a, StatisticalUniverse> {
    let world = World {
        universe,
        light,
        roulette: 1e-3,
        event_cap: 1_000_000,
        split: None,
        pile: 1,
        top: HEIGHT,
        bottom: 0.0,
        backing: None,
        gap: None,
        analog: false,
        full: None,
    };
    let source = Source::collimated(0.0, 0.0, DVec3::new(0.0, 0.0, HEIGHT), 0.0);
    Case { world, source, histories: 20_000 }
}

#[divan::bench]
fn scattering_events(bencher: Bencher) {
    let (universe, light) = (universe(), light());
    let case = case(&universe, &light);
    let layout = case.layout();
    bencher.counter(ItemsCount::new(case.count().scatterings)).bench_local(|| case.run(black_box(&layout)));
}

/// The classic loop of turbid media for comparison, as Wang, Jacques and Zheng give it (MCML, 1995,
/// DOI 10.1016/0169-2607(95)01640-F): hop, drop, spin, with the elementary functions of the platform, absorbed power
/// by depth, roulette. Returns scatterings, reflected and transmitted power.
#[inline(never)]
#[allow(clippy::disallowed_methods)]
fn classic(histories: u64, rng: &mut Stream, absorbed: &mut [f64; 64]) -> (u64, f64, f64) {
    const G: f64 = 0.75;
    let (mu_a, mu_t) = (black_box(1e-3), black_box(1e-2));
    let (mut scatterings, mut reflected, mut transmitted) = (0, 0.0, 0.0);
    for _ in 0..histories {
        let (mut weight, mut x, mut y, mut z) = (1.0, 0.0, 0.0, 0.0);
        let (mut ux, mut uy, mut uz) = (0.0, 0.0, 1.0_f64);
        loop {
            let step = -rng.uniform_positive().ln() / mu_t;
            let wall = if uz > 0.0 { (HEIGHT - z) / uz } else { -z / uz };
            if uz != 0.0 && step > wall {
                *(if uz > 0.0 { &mut transmitted } else { &mut reflected }) += weight;
                black_box((x, y));
                break;
            }
            (x, y, z) = (x + step * ux, y + step * uy, z + step * uz);
            let dropped = weight * mu_a / mu_t;
            weight -= dropped;
            absorbed[((z * 0.25) as usize).min(63)] += dropped;
            scatterings += 1;
            let ratio = (1.0 - G * G) / (1.0 - G + 2.0 * G * rng.uniform());
            let cos = (1.0 + G * G - ratio * ratio) / (2.0 * G);
            let sin = (1.0 - cos * cos).sqrt();
            let (sin_phi, cos_phi) = (std::f64::consts::TAU * rng.uniform()).sin_cos();
            if uz.abs() > 1.0 - 1e-12 {
                (ux, uy, uz) = (sin * cos_phi, sin * sin_phi, cos * uz.signum());
            } else {
                let root = (1.0 - uz * uz).sqrt();
                let old = (ux, uy, uz);
                ux = sin * (old.0 * old.2 * cos_phi - old.1 * sin_phi) / root + old.0 * cos;
                uy = sin * (old.1 * old.2 * cos_phi + old.0 * sin_phi) / root + old.1 * cos;
                uz = -sin * cos_phi * root + old.2 * cos;
            }
            if weight < 1e-4 {
                if rng.uniform() >= 0.1 {
                    break;
                }
                weight *= 10.0;
            }
        }
    }
    (scatterings, reflected, transmitted)
}

/// Time of the classic loop per scattering event; its totals are those of P1 (R .097395, T .660958).
fn classic_ns() -> f64 {
    let (histories, mut absorbed) = (20_000, [0.0; 64]);
    let (events, reflected, transmitted) = classic(histories, &mut common::stream(), &mut absorbed);
    let off = (reflected / histories as f64 - 0.097_395, transmitted / histories as f64 - 0.660_958);
    assert!(off.0.abs() < 0.01 && off.1.abs() < 0.015, "the classic loop is wrong by {off:?}");
    best_ns(events, || classic(histories, &mut common::stream(), &mut absorbed))
}

fn main() {
    divan::main();
    report(|| {
        let (universe, light) = (universe(), light());
        let case = case(&universe, &light);
        let (layout, count) = (case.layout(), case.count());
        let total = best_ns(1, || case.run(black_box(&layout)));
        vec![
            ("P1, scattering event".into(), total / count.scatterings as f64),
            ("P1, history".into(), total / case.histories as f64),
            ("P1, classic loop, scattering event".into(), classic_ns()),
        ]
    });
}
