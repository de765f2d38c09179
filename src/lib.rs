//! LightPro simulates how light travels through paper: hollow fibres, pores, fillers and coatings,
//! with reflection, refraction, dispersion, absorption, surface and subsurface scattering.
//!
//! The same Light Propagation Model ([`lpm`]) runs in a **statistical universe** (a sheet known only
//! by its fibre statistics) and in **deterministic universes** (explicit primitives), behind one
//! trait, [`universe::Universe`].
//!
//! Modules stand in the order of their dependencies: each imports only from those above it, and a
//! test guards that.

#![cfg_attr(not(test), warn(clippy::unwrap_used))]

pub mod math;
pub mod units;
pub mod rng;
pub mod law;
pub mod spectrum;
pub mod stats;
pub mod material;
pub mod phase;
pub mod microfacet;
pub mod sap;
pub mod universe;
pub mod source;
pub mod lpm;
pub mod tally;
pub mod scene;
pub mod optics;
pub mod run;
pub mod report;
pub mod study;
pub mod command;
