//! What each rung of the memory ladder costs: time per history relative to rung `none`, and what a
//! history keeps.
#![allow(missing_docs)]

mod common;

use common::{best_ns, report};
use lightpro::law::{Azimuth, Roll, SizeLaw, Tilt};
use lightpro::lpm::surface::{Directions, Ratio, SurfaceLaw};
use lightpro::lpm::{History, Light, Medium, Scorer, World, trace};
use lightpro::math::DVec3;
use lightpro::phase::Phase;
use lightpro::rng::{Purpose, Stream};
use lightpro::source::Source;
use lightpro::universe::Overlap;
use lightpro::universe::sheet::Slab;
use lightpro::universe::statistical::amount::{Rule, Target, averages, coverage, densities};
use lightpro::universe::statistical::kind::{Kind, Sizes};
use lightpro::universe::statistical::lazy::{LazyUniverse, Memory};
use lightpro::universe::statistical::{Population, Rules, Rung, StatisticalUniverse};
use lightpro::universe::{BodyId, MediumId, SurfaceId, Universe};

const AIR: MediumId = MediumId(0);
const SOLID: MediumId = MediumId(1);
const COUNT: u64 = 20_000;

/// A sheet and its light.
struct Sheet {
    name: &'static str,
    height: f64,
    universe: StatisticalUniverse,
    light: Light<1>,
    /// Whether finite k is meant for it.
    finite: bool,
}

struct Fibres {
    width: f64,
    flatness: f64,
    wall: Option<f64>,
    share: f64,
    height: f64,
    contained: bool,
    start_in_bodies: bool,
    surface: SurfaceId,
    rule: Rule,
}

fn fibres(f: &Fibres) -> StatisticalUniverse {
    let sizes = Sizes::Fibre {
        width: SizeLaw::Constant(f.width),
        flatness: SizeLaw::Constant(f.flatness),
        wall: f.wall.map(SizeLaw::Constant),
        length: None,
    };
    let kind =
        Kind::new(sizes, Azimuth::Uniform, Tilt::InPlane, Roll::Flat, SOLID, AIR, f.surface, BodyId(1));
    let cover = [coverage(&kind, f.height, f.contained)];
    let density = densities(f.rule, &[Target::Body(f.share)], &cover).unwrap();
    let share = vec![averages(f.rule, &density, &cover)[0].1];
    let layer = Population {
        slab: Slab { top: f.height, bottom: 0.0, pore: AIR, surface: SurfaceId::SMOOTH },
        kinds: vec![kind],
        content: vec![cover[0].content],
        solid: vec![cover[0].solid / cover[0].content],
        share,
        density,
        grace: None,
    };
    let rules = Rules {
        rung: Rung::Forgetful,
        outside: AIR,
        bottom_surface: SurfaceId::SMOOTH,
        contained: f.contained,
        start_in_bodies: f.start_in_bodies,
        backing: false,
        clear: [false; 2],
    };
    StatisticalUniverse::new(vec![layer], rules)
}

fn light(solid: Medium<1>, own: Option<SurfaceLaw<1>>) -> Light<1> {
    let mut surfaces = vec![SurfaceLaw::default()];
    surfaces.extend(own);
    Light { media: vec![Medium::clear(1.0), solid], surfaces, lanes: 1 }
}

fn sheets() -> Vec<Sheet> {
    let white = || SurfaceLaw {
        directions: Directions::Lambertian,
        ratio: Ratio::Constant([1.0]),
        opaque: true,
        sap: None,
    };
    let round = |share, height, rule| Fibres {
        width: 2.0,
        flatness: 1.0,
        wall: None,
        share,
        height,
        contained: false,
        start_in_bodies: true,
        surface: SurfaceId::SMOOTH,
        rule,
    };
    let opaque = |share, height| Fibres {
        surface: SurfaceId(1),
        start_in_bodies: false,
        ..round(share, height, Rule::Union)
    };
    let scattering = Medium::clear(1.0).with([0.0], 1.0, Phase::Isotropic);
    let hollow = Fibres { wall: Some(0.27), ..round(0.5, 16.0, Rule::Union) };
    // A kraft handsheet, 60 g/m2 in 100 um: flat tubes of 30 um, wall 3 um.
    let paper = Fibres {
        width: 30.0,
        flatness: 0.3,
        wall: Some(3.0),
        share: 0.6,
        height: 100.0,
        contained: true,
        start_in_bodies: false,
        surface: SurfaceId::SMOOTH,
        rule: Rule::Union,
    };
    let dielectric = || light(Medium::clear(1.55), None);
    let whites = || light(Medium::clear(1.0), Some(white()));
    let sheet = |name, f: &Fibres, light, finite| Sheet {
        name,
        height: f.height,
        universe: fibres(f),
        light,
        finite,
    };
    vec![
        sheet("white, φ .3, H 10 r", &opaque(0.3, 10.0), whites(), true),
        sheet("white, φ .5, H 10 r", &opaque(0.5, 10.0), whites(), true),
        sheet("scattering, φ .3, H 10 r", &round(0.3, 10.0, Rule::Union), light(scattering, None), false),
        sheet("hollow dielectric, φ .5, H 16 r", &hollow, dielectric(), true),
        sheet("paper, flat hollow fibres", &paper, dielectric(), true),
    ]
}

struct Nobody;
impl Scorer<1> for Nobody {}

/// Nanoseconds per history, and means of what `kept` says of the memory.
fn time<U: Universe>(sheet: &Sheet, universe: &U, kept: impl Fn(&U::Memory) -> [f64; 3]) -> (f64, [f64; 3]) {
    let world = World {
        universe,
        light: &sheet.light,
        roulette: 1e-3,
        event_cap: 1_000_000,
        split: None,
        pile: 1,
        top: sheet.height,
        bottom: 0.0,
        backing: None,
        gap: None,
        analog: false,
        full: None,
    };
    let source = Source::diffuse(DVec3::new(0.0, 0.0, sheet.height), 0.0);
    let mut h = History::default();
    let mut sums = [0.0; 3];
    let ns = best_ns(COUNT, || {
        sums = [0.0; 3];
        for number in 0..COUNT {
            let mut rng = Stream::of(20_261_122, 0, number, Purpose::Transport);
            let ray = source.emit(&mut rng);
            trace(&world, ray, &mut h, &mut Nobody, &mut rng);
            for (s, k) in sums.iter_mut().zip(kept(&h.memory)) {
                *s += k / COUNT as f64;
            }
        }
        sums[0]
    });
    (ns, sums)
}

fn main() {
    report(|| {
        let mut rows = Vec::new();
        // Words after `--` pick sheets by name.
        let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
        for sheet in sheets() {
            if !wanted.iter().all(|w| sheet.name.contains(w.as_str())) {
                continue;
            }
            let (none, _) = time(&sheet, &sheet.universe, |_| [0.0; 3]);
            rows.push((format!("{}: none", sheet.name), none));
            let finite = [Some(1), Some(2), Some(4), Some(8)];
            let rungs = finite.into_iter().filter(|_| sheet.finite).chain([None]);
            for last in rungs {
                let universe = LazyUniverse::new(sheet.universe.clone(), Overlap::Union, last);
                let kept = |m: &Memory| {
                    let k = m.kept();
                    [k.bodies as f64, k.segments as f64, k.bytes as f64]
                };
                let (ns, [bodies, segments, bytes]) = time(&sheet, &universe, kept);
                let rung = last.map_or("full".to_owned(), |k| format!("k = {k}"));
                let ratio = ns / none;
                rows.push((
                    format!(
                        "{}: {rung}, {ratio:.2} x none; {bodies:.1} bodies, {segments:.1} segments, {:.1} kB",
                        sheet.name,
                        bytes / 1000.0
                    ),
                    ns,
                ));
            }
        }
        rows
    });
}
