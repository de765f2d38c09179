//! Orientation laws.
/// Law of the in-plane azimuth of a fibre axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Azimuth {
    /// Uniform.
    Uniform,
}
/// Law of the roll of the section's major axis about the fibre axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Roll {
    /// Major axis in the sheet plane.
    Flat,
    /// Uniform.
    Uniform,
}
