//! A statistical sheet of hollow round fibres, rung `none`: wall 0.27 of the radius, index 1.55, smooth
//! surfaces, no absorption, 30 % of the volume in fibres, `cut`; diffuse light.
#![allow(missing_docs)]

mod common;

use common::{Case, PORE, best_ns, report};
use divan::Bencher;
use divan::counter::ItemsCount;
use lightpro::law::{Azimuth, Roll, SizeLaw, Tilt};
use lightpro::lpm::surface::SurfaceLaw;
use lightpro::lpm::{Light, Medium, World};
use lightpro::math::DVec3;
use lightpro::source::Source;
use lightpro::universe::sheet::Slab;
use lightpro::universe::statistical::amount::{Rule, Target, averages, coverage, densities};
use lightpro::universe::statistical::kind::{Kind, Sizes};
use lightpro::universe::statistical::{Population, Rules, Rung, StatisticalUniverse};
use lightpro::universe::{BodyId, MediumId, SurfaceId};
use std::hint::black_box;

const HEIGHT: f64 = 100.0;

fn universe() -> StatisticalUniverse {
    let radius = 10.0;
    let sizes = Sizes::Fibre {
        width: SizeLaw::Constant(2.0 * radius),
        flatness: SizeLaw::Constant(1.0),
        wall: Some(SizeLaw::Constant(0.27 * radius)),
        length: None,
    };
    let (wall, lumen) = (MediumId(1), MediumId(2));
    let kind = Kind::new(
        sizes,
        Azimuth::Uniform,
        Tilt::InPlane,
        Roll::Uniform,
        wall,
        lumen,
        SurfaceId::SMOOTH,
        BodyId(1),
    );
    let cover = [coverage(&kind, HEIGHT, false)];
    let density = densities(Rule::Union, &[Target::Body(0.3)], &cover).unwrap();
    let layer = Population {
        slab: Slab { top: HEIGHT, bottom: 0.0, pore: PORE, surface: SurfaceId::SMOOTH },
        kinds: vec![kind],
        share: vec![averages(Rule::Union, &density, &cover)[0].1],
        density,
        content: vec![cover[0].content],
        solid: vec![cover[0].solid / cover[0].content],
        grace: None,
    };
    let rules = Rules {
        rung: Rung::Forgetful,
        outside: PORE,
        bottom_surface: SurfaceId::SMOOTH,
        contained: false,
        start_in_bodies: true,
        backing: false,
        clear: [false; 2],
    };
    StatisticalUniverse::new(vec![layer], rules)
}

fn light() -> Light<1> {
    let media = vec![Medium::clear(1.0), Medium::clear(1.55), Medium::clear(1.0)];
    Light { media, surfaces: vec![SurfaceLaw::default()], lanes: 1 }
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
    let source = Source::diffuse(DVec3::new(0.0, 0.0, HEIGHT), 0.0);
    Case { world, source, histories: 10_000 }
}

#[divan::bench]
fn surface_events(bencher: Bencher) {
    let (universe, light) = (universe(), light());
    let case = case(&universe, &light);
    let layout = case.layout();
    bencher.counter(ItemsCount::new(case.count().interfaces)).bench_local(|| case.run(black_box(&layout)));
}

fn main() {
    divan::main();
    report(|| {
        let (universe, light) = (universe(), light());
        let case = case(&universe, &light);
        let (layout, count) = (case.layout(), case.count());
        let total = best_ns(1, || case.run(black_box(&layout)));
        vec![
            ("fibres, surface event".into(), total / count.interfaces as f64),
            ("fibres, fibre met".into(), total / count.bodies as f64),
            ("fibres, history".into(), total / case.histories as f64),
        ]
    });
}
