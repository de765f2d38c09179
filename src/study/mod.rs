//! Many runs of a scene, compared; and when a run has gone far enough.

pub mod accuracy;
pub mod aims;
pub mod characterise;
pub mod compare;
pub mod effects;
pub mod sap;
pub mod structure;
pub mod target;
pub mod timed;
