//! Laws of size and orientation: density, moments, and samplers by own inverse CDF or exact rejection.

pub mod orientation;
pub mod size;

pub use orientation::{Azimuth, Roll};
pub use size::{SizeLaw, Weighting};
