//! Laws of size and orientation: density, moments, and samplers by own inverse CDF or exact rejection.
//!
//! A [`SizeLaw`] is the law of one positive size (µm); [`Azimuth`], [`Tilt`] and [`Roll`] together
//! orient a fibre (rad). Every sampler draws from [`crate::rng::Stream`] alone and is exact: the
//! density that is sampled is the density that `pdf` returns, without tables in between.

mod bounded;
mod families;
pub mod orientation;
mod power;
mod quadrature;
pub mod size;

pub use orientation::{Azimuth, Roll, Tilt, axis};
pub use size::{LawError, SizeLaw, Weighting};
