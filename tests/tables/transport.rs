//! Runs a small world and reads its totals.

use lightpro::law::{Azimuth, Roll, SizeLaw, Tilt};
use lightpro::lpm::surface::{Directions, Ratio, SurfaceLaw};
use lightpro::lpm::{Light, Medium, World};
use lightpro::math::DVec3;
use lightpro::run::{Histories, run_group};
use lightpro::source::Source;
use lightpro::tally::{Cell, Layout, Node};
use lightpro::universe::sheet::Slab;
use lightpro::universe::statistical::amount::{Rule, Target, averages, coverage, densities};
use lightpro::universe::statistical::kind::{Kind, Sizes};
use lightpro::universe::statistical::{Population, Rules, Rung, StatisticalUniverse};
use lightpro::universe::{BodyId, MediumId, SurfaceId, Universe};

/// Media of all these worlds: outside and pores, solid, lumen.
pub const AIR: MediumId = MediumId(0);
pub const SOLID: MediumId = MediumId(1);
/// The second surface law.
pub const OWN: SurfaceId = SurfaceId(1);

pub struct Totals {
    pub node: Node,
    pub layout: Layout,
}

impl Totals {
    /// Mean and standard error of a cell.
    pub fn cell(&self, cell: usize) -> (f64, f64) {
        let m = self.node.moments(cell, 0, 1);
        (m.mean(), m.standard_error())
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
    pub tilt: Tilt,
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
            },
            tilt: Tilt::InPlane,
            target,
            height,
            rung: Rung::Forgetful,
            rule: Rule::Union,
            contained: false,
            start_in_bodies: false,
            surface: SurfaceId::SMOOTH,
        }
    }

    pub fn build(self) -> StatisticalUniverse {
        let kind = Kind::new(
            self.sizes,
            Azimuth::Uniform,
            self.tilt,
            Roll::Uniform,
            SOLID,
            AIR,
            self.surface,
            BodyId(1),
        );
        let cover = [coverage(&kind, self.height, self.contained)];
        let density = densities(self.rule, &[self.target], &cover).unwrap();
        let shares = averages(self.rule, &density, &cover);
        let layer = Population {
            slab: Slab { top: self.height, bottom: 0.0, pore: AIR, surface: SurfaceId::SMOOTH },
            kinds: vec![kind],
            density,
            share: vec![shares[0].1],
            solid: vec![cover[0].solid / cover[0].content],
            grace: None,
        };
        StatisticalUniverse::new(
            vec![layer],
            Rules {
                rung: self.rung,
                outside: AIR,
                bottom_surface: SurfaceId::SMOOTH,
                contained: self.contained,
                start_in_bodies: self.start_in_bodies,
                backing: false,
            },
        )
    }
}

/// Air, the given solid, and the given surface law as [`OWN`].
pub fn light(solid: Medium<1>, own: Option<SurfaceLaw<1>>) -> Light<1> {
    let mut surfaces = vec![SurfaceLaw::default()];
    surfaces.extend(own);
    Light { media: vec![Medium::clear(1.0), solid], surfaces, lanes: 1 }
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
    Layout { lanes: 1, media, angular: None, depth: None, checkpoint: None, path: true, view: None, pile: 1 }
}

pub fn run<U: Universe>(universe: &U, light: &Light<1>, source: &Source, height: f64, count: u64) -> Totals {
    run_with(universe, light, source, height, count, layout(light.media.len()))
}

pub fn run_with<U: Universe>(
    universe: &U,
    light: &Light<1>,
    source: &Source,
    height: f64,
    count: u64,
    layout: Layout,
) -> Totals {
    let world = World {
        universe,
        light,
        roulette: 1e-3,
        event_cap: 1_000_000,
        split: None,
        pile: 1,
        top: height,
        bottom: 0.0,
        backing: None,
        analog: false,
    };
    let node =
        run_group(&world, source, &layout, Histories { seed: 20_261_122, group: 0, count }, |_, _| true);
    assert!(node.worst_imbalance < 1e-12, "ledger off by {}", node.worst_imbalance);
    assert_eq!((node.lost, node.capped), (0, 0), "lost, capped");
    Totals { node, layout }
}
