//! The statistical universe: laws of free paths, chords and normals, the contract, invariants of
//! lossless sheets, amounts, the Grace way, layers.
#![allow(clippy::disallowed_methods, missing_docs)]

#[path = "walking/mod.rs"]
mod walking;
#[path = "statistical_universe/amounts.rs"]
mod amounts;
#[path = "statistical_universe/contract.rs"]
mod contract;
#[path = "statistical_universe/grace.rs"]
mod grace;
#[path = "tables/harness.rs"]
#[allow(dead_code)]
mod harness;
#[path = "statistical_universe/invariants.rs"]
mod invariants;
#[path = "statistical_universe/laws.rs"]
mod laws;
#[path = "statistical_universe/layers.rs"]
mod layers;
#[path = "statistical_universe/memory.rs"]
mod memory;
#[path = "statistical_universe/stress.rs"]
mod stress;
#[path = "tables/transport.rs"]
#[allow(dead_code)]
mod transport;

use lightpro::math::DVec3;
use lightpro::rng::{Purpose, Stream};
use lightpro::universe::statistical::StatisticalUniverse;
use lightpro::universe::{Interface, MediumId, Next, Ray, Universe};

pub fn stream(number: u64) -> Stream {
    Stream::of(4711, 0, number, Purpose::Probe)
}

/// Direction down at a polar angle from z, rad.
pub fn down(polar: f64) -> DVec3 {
    let (s, c) = polar.sin_cos();
    DVec3::new(s, 0.0, -c)
}

/// A straight ray through everything: medium and length of each step, and the interface at its end.
pub fn straight(
    universe: &StatisticalUniverse,
    mut ray: Ray,
    rng: &mut Stream,
    mut heard: impl FnMut(MediumId, f64, Option<&Interface>),
) {
    let start = universe.enter(&ray, &mut (), rng);
    let (mut place, mut medium) = (start.place, start.medium);
    loop {
        match universe.next(&ray, &mut place, &mut (), f64::INFINITY, rng) {
            Next::Interface(at) => {
                heard(medium, at.distance, Some(&at));
                ray.origin = ray.at(at.distance);
                universe.crossed(&mut ray, &mut place, &mut (), &at);
                medium = at.beyond;
            }
            Next::Edge { distance, .. } => return heard(medium, distance, None),
            other => panic!("{other:?}"),
        }
    }
}
