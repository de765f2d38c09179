//! Size laws.
/// How a size law was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weighting {
    /// Each particle counts once.
    Number,
    /// Each particle counts by its length.
    Length,
    /// Each particle counts by its mass.
    Mass,
}
/// A law of a positive size.
#[derive(Clone, Debug, PartialEq)]
pub enum SizeLaw {
    /// One value.
    Constant(f64),
}
