//! Phase functions.
/// A phase function.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// Equal in all directions.
    Isotropic,
}
