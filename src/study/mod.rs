//! Studies of a scene: many runs of it, compared.

pub mod characterise;
pub mod effects;
pub mod structure;
