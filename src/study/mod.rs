//! Many runs of a scene, compared; and when a run has gone far enough.

pub mod aims;
pub mod compare;
pub mod effects;
pub mod target;
