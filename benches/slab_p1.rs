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
        ]
    });
}
