//! Scenes: the document as written, the checked scene, the plan.

pub mod adapters;
mod build;
pub mod deposit;
pub mod diagnostic;
pub mod document;
pub mod effects;
pub mod full;
pub mod media;
pub mod mixture;
pub mod model;
pub mod optics;
pub mod plan;
pub mod reciprocity;
pub mod realise;
pub mod statistical;
pub mod synthetic;
pub mod table;
pub mod voxel;
pub mod written;

pub use build::{Options, implied_coarseness, read, read_text, section_areas};
pub use diagnostic::Diagnostics;
pub use model::*;
