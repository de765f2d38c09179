//! Markov mixtures of planar layers: laws of the layers, the contract, closed forms, explicit
//! realisations, reading of scenes. The Adams–Larsen–Pomraning suite is in `tests/tables/mixture.rs`.
#![allow(clippy::disallowed_methods, missing_docs)]

#[path = "mixture/contract.rs"]
mod contract;
#[path = "tables/harness.rs"]
#[allow(dead_code)]
mod harness;
#[path = "mixture/laws.rs"]
mod laws;
#[path = "mixture/light.rs"]
mod light;
#[path = "mixture/reading.rs"]
mod reading;
#[path = "tables/transport.rs"]
#[allow(dead_code)]
mod transport;

use lightpro::math::DVec3;
use lightpro::rng::{Purpose, Stream};
use lightpro::universe::mixture::chain::{Chain, Phase};
use lightpro::universe::mixture::{MixtureUniverse, Rules, Rung};
use lightpro::universe::{MediumId, SurfaceId};

/// Medium outside; that of phase i is i + 1.
pub const OUTSIDE: MediumId = MediumId(0);

pub const RUNGS: [Rung; 5] = [Rung::Phase, Rung::Layers(1), Rung::Layers(2), Rung::Layers(4), Rung::Full];

/// Three phases of unequal chords and shares.
pub const THREE: [(f64, f64); 3] = [(0.5, 1.0), (1.5, 2.0), (1.0, 4.0)];

pub fn stream(number: u64) -> Stream {
    Stream::of(4712, 0, number, Purpose::Probe)
}

/// Direction down at cosine µ.
pub fn down(mu: f64) -> DVec3 {
    DVec3::new((1.0 - mu * mu).sqrt(), 0.0, -mu)
}

/// The chain of phases given by (chord, share).
pub fn chain(phases: &[(f64, f64)]) -> Chain {
    let phase =
        |(i, &(chord, share)): (usize, &(f64, f64))| Phase { medium: MediumId(i as u16 + 1), chord, share };
    Chain::new(phases.iter().enumerate().map(phase).collect()).unwrap()
}

/// A slab of it; faces without a surface if `clear`.
pub fn slab(phases: &[(f64, f64)], height: f64, rung: Rung, clear: bool) -> MixtureUniverse {
    let rules = Rules { rung, outside: OUTSIDE, surface: SurfaceId::SMOOTH, clear: [clear; 2] };
    MixtureUniverse::new(chain(phases), height, rules)
}
