//! Runs a small world and reads its totals.

use lightpro::law::{Azimuth, Roll, SizeLaw, Tilt};
use lightpro::lpm::surface::{Directions, Ratio, SurfaceLaw};
use lightpro::lpm::{History, Light, Medium, Scorer, World, trace};
use lightpro::math::DVec3;
use lightpro::rng::{Purpose, Stream};
use lightpro::run::{Histories, run_group};
use lightpro::source::Source;
use lightpro::tally::{Cell, Layout, Node};
use lightpro::universe::Overlap;
use lightpro::universe::sheet::Slab;
use lightpro::universe::statistical::amount::{Rule, Target, averages, coverage, densities};
use lightpro::universe::statistical::kind::{Kind, Sizes};
use lightpro::universe::statistical::lazy::LazyUniverse;
use lightpro::universe::statistical::{Population, Rules, Rung, StatisticalUniverse};
use lightpro::universe::{BodyId, MediumId, Ray, SurfaceId, Universe};
use rayon::prelude::*;

/// Media of all these worlds: outside and pores, solid, lumen.
pub const AIR: MediumId = MediumId(0);
pub const SOLID: MediumId = MediumId(1);
/// The second surface law.
pub const OWN: SurfaceId = SurfaceId(1);

/// Scores of a run, and where they stand.
pub struct Totals {
    pub node: Node,
    pub layout: Layout,
}

impl Totals {
    /// Mean and standard error of a cell in a lane.
    pub fn lane(&self, cell: usize, lane: usize) -> (f64, f64) {
        let m = self.node.moments(cell, lane, self.layout.lanes);
        (m.mean(), m.standard_error())
    }
    /// The same of the first lane.
    pub fn cell(&self, cell: usize) -> (f64, f64) {
        self.lane(cell, 0)
    }
    pub fn r(&self) -> (f64, f64) {
        self.cell(self.layout.of(Cell::Reflected))
    }
    pub fn t(&self) -> (f64, f64) {
        self.cell(self.layout.of(Cell::Transmitted))
    }
    pub fn interfaces(&self) -> (f64, f64) {
        self.cell(self.layout.of(Cell::Interfaces))
    }
    pub fn path(&self, medium: MediumId) -> (f64, f64) {
        self.cell(self.layout.path_length(medium))
    }
}

/// A sheet of one kind of body.
pub struct Sheet {
    pub sizes: Sizes,
    pub azimuth: Azimuth,
    pub tilt: Tilt,
    pub roll: Roll,
    pub target: Target,
    pub height: f64,
    pub rung: Rung,
    pub rule: Rule,
    pub contained: bool,
    pub start_in_bodies: bool,
    pub surface: SurfaceId,
}

impl Sheet {
    pub fn fibres(r: f64, wall: Option<f64>, target: Target, height: f64) -> Self {
        Sheet {
            sizes: Sizes::Fibre {
                width: SizeLaw::Constant(2.0 * r),
                flatness: SizeLaw::Constant(1.0),
                wall: wall.map(SizeLaw::Constant),
                length: None,
            },
            azimuth: Azimuth::Uniform,
            tilt: Tilt::InPlane,
            roll: Roll::Uniform,
            target,
            height,
            rung: Rung::Forgetful,
            rule: Rule::Union,
            contained: false,
            start_in_bodies: false,
            surface: SurfaceId::SMOOTH,
        }
    }

    /// Spheres of radius `r`.
    pub fn spheres(r: f64, target: Target, height: f64) -> Self {
        Sheet { sizes: Sizes::Sphere(SizeLaw::Constant(2.0 * r)), ..Self::fibres(r, None, target, height) }
    }

    pub fn kind(&self) -> Kind {
        Kind::new(self.sizes.clone(), self.azimuth, self.tilt, self.roll, SOLID, AIR, self.surface, BodyId(1))
    }

    /// The layer between `bottom` and `bottom` + height.
    pub fn population(&self, bottom: f64) -> Population {
        let kind = self.kind();
        let cover = [coverage(&kind, self.height, self.contained)];
        let density = densities(self.rule, &[self.target], &cover).unwrap();
        let shares = averages(self.rule, &density, &cover);
        Population {
            slab: Slab { top: bottom + self.height, bottom, pore: AIR, surface: SurfaceId::SMOOTH },
            kinds: vec![kind],
            density,
            content: vec![cover[0].content],
            share: vec![shares[0].1],
            solid: vec![cover[0].solid / cover[0].content],
            grace: None,
        }
    }

    pub fn rules(&self) -> Rules {
        Rules {
            rung: self.rung,
            outside: AIR,
            bottom_surface: SurfaceId::SMOOTH,
            contained: self.contained,
            start_in_bodies: self.start_in_bodies,
            backing: false,
            clear: [false; 2],
        }
    }

    /// The same sheet remembered: the last `last` flights, or all.
    pub fn remembered(&self, last: Option<u32>) -> LazyUniverse {
        LazyUniverse::new(self.build(), Overlap::Union, last)
    }

    pub fn build(&self) -> StatisticalUniverse {
        StatisticalUniverse::new(vec![self.population(0.0)], self.rules())
    }
}

/// A layer without bodies, of the medium `pore`.
pub fn plain(top: f64, bottom: f64, pore: MediumId) -> Population {
    Population::plain(Slab { top, bottom, pore, surface: SurfaceId::SMOOTH })
}

/// A sheet of homogeneous layers.
pub fn plain_sheet(layers: Vec<Population>) -> StatisticalUniverse {
    StatisticalUniverse::new(
        layers,
        Rules {
            rung: Rung::Homogeneous,
            outside: AIR,
            bottom_surface: SurfaceId::SMOOTH,
            contained: false,
            start_in_bodies: false,
            backing: false,
            clear: [false; 2],
        },
    )
}

/// Air, the given solid, and the given surface law as [`OWN`].
pub fn light<const N: usize>(solid: Medium<N>, own: Option<SurfaceLaw<N>>) -> Light<N> {
    let mut surfaces = vec![SurfaceLaw::default()];
    surfaces.extend(own);
    Light { media: vec![Medium::clear(1.0), solid], surfaces, lanes: N }
}

/// An opaque Lambertian surface of reflectance `rho`.
pub fn opaque_lambertian(rho: f64) -> SurfaceLaw<1> {
    SurfaceLaw { directions: Directions::Lambertian, ratio: Ratio::Constant([rho]), opaque: true, sap: None }
}

pub fn diffuse(height: f64) -> Source {
    Source::diffuse(DVec3::new(0.0, 0.0, height), 0.0)
}

pub fn normal(height: f64) -> Source {
    Source::collimated(0.0, 0.0, DVec3::new(0.0, 0.0, height), 0.0)
}

pub fn layout(media: usize) -> Layout {
    Layout {
        lanes: 1,
        shared: 1,
        realisations: None,
        media,
        angular: None,
        depth: None,
        checkpoint: None,
        path: true,
        time: false,
        view: None,
        pile: 1,
        detectors: Default::default(),
    }
}

/// The usual world: no backing, no pile, weighted absorption.
pub fn world<'a, U: Universe, const N: usize>(
    universe: &'a U,
    light: &'a Light<N>,
    height: f64,
) -> World<'a, U, N> {
    World {
        universe,
        light,
        roulette: 1e-3,
        event_cap: 1_000_000,
        split: None,
        pile: 1,
        top: height,
        bottom: 0.0,
        backing: None,
        gap: None,
        analog: false,
        full: None,
    }
}

pub fn run<U: Universe, const N: usize>(
    universe: &U,
    light: &Light<N>,
    source: &Source,
    height: f64,
    count: u64,
) -> Totals {
    totals(&world(universe, light, height), source, count)
}

/// Runs `count` histories; every ledger closes, nothing is lost or capped.
pub fn totals<U: Universe, const N: usize>(world: &World<U, N>, source: &Source, count: u64) -> Totals {
    let layout = Layout { lanes: world.light.lanes, ..layout(world.light.media.len()) };
    let node =
        run_group(world, source, &layout, Histories { seed: 20_261_122, group: 0, count }, |_, _| true);
    assert!(node.worst_imbalance < 1e-12, "ledger off by {}", node.worst_imbalance);
    assert_eq!((node.lost, node.capped), (0, 0), "lost, capped");
    Totals { node, layout }
}

/// A tally of a test's own: one per chunk of histories, told when a history ends.
pub trait Score<const N: usize>: Scorer<N> + Send {
    fn end(&mut self);
    fn merge(&mut self, other: Self);
}

/// Traces `count` histories that start as `emit` says, scored by copies of `empty`.
pub fn walk<U: Universe, S: Score<N>, const N: usize>(
    world: &World<U, N>,
    count: u64,
    empty: impl Fn() -> S + Sync,
    emit: impl Fn(&mut Stream) -> Ray + Sync,
) -> S {
    const CHUNK: u64 = 16_384;
    let parts: Vec<S> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut score = empty();
            let mut h = History::default();
            for number in chunk * CHUNK..((chunk + 1) * CHUNK).min(count) {
                let mut rng = Stream::of(20_261_122, 1, number, Purpose::Transport);
                let ray = emit(&mut rng);
                trace(world, ray, &mut h, &mut score, &mut rng);
                assert!(h.ledger.imbalance(N) < 1e-12 && h.ledger.lost[0] == 0.0);
                score.end();
            }
            score
        })
        .collect();
    let mut sum = empty();
    parts.into_iter().for_each(|p| sum.merge(p));
    sum
}
