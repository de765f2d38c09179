//! Scenes: the document as written, the checked scene, the plan.

pub mod model;

pub use model::*;
