//! Reference tables: independent values that the program is held against.
//!
//! Tables are read from the folder named by `LIGHTPRO_REFERENCE`, else from `tests/reference` (cuts,
//! provenance in its README). Each test prints rows checked, the worst deviation in units of its
//! tolerance, and the rows that the program cannot express, by name and reason.
#![allow(clippy::disallowed_methods, missing_docs)]

mod copper;
mod explicit;
mod fresnel;
mod harness;
mod mie;
mod phase;
mod microfacet;
mod colour;
mod kubelka_munk;
mod particles;
mod statistical;
mod mixture;
mod transport;
mod slab;
mod healpix;
mod sap;
mod half_space;
