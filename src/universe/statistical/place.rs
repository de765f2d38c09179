//! Where a ray is in a statistical sheet, and what has been drawn for it.

use super::section::{Body, Left, Part};
use crate::math::DVec3;
use crate::universe::Face;

/// Where a ray is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    /// Above or below the sheet.
    Outside(Face),
    /// In the pores (or a homogeneous layer).
    Pore {
        /// Kind of the body just left, if the ray starts from a surface (the Grace way asks).
        from: Option<u16>,
    },
    /// In the body of the place, an exact shape.
    Body {
        /// Wall or lumen.
        part: Part,
        /// Surface just left.
        left: Left,
    },
    /// In a body known by its kind only (rung `markov`).
    Markov {
        /// Kind.
        kind: u16,
        /// Wall or lumen.
        part: Part,
    },
}

/// What the last `next` has drawn.
#[derive(Clone, Copy, Debug, Default)]
pub enum Pending {
    /// Nothing asked yet.
    #[default]
    Unexplored,
    /// Nothing there.
    Nothing,
    /// The body of the place.
    Meet {
        /// How far.
        distance: f64,
        /// Outward normal where the ray enters.
        outward: DVec3,
        /// Side or end.
        surface: Left,
    },
    /// A surface of the body that the ray is in.
    Leave(Left),
    /// The body of the place, in optical contact with the one that the ray is in.
    Contact {
        /// How far.
        distance: f64,
        /// Its outward normal there.
        outward: DVec3,
    },
    /// A plane of the layer.
    Plane(Face),
    /// The end of a chord (rung `markov`).
    Chord {
        /// How far.
        distance: f64,
        /// From the wall into the lumen.
        inward: bool,
        /// Normal against the ray.
        outward: DVec3,
        /// Fibre axis.
        axis: DVec3,
    },
}

/// Where a ray is, and what it has been told to meet next.
#[derive(Clone, Copy, Debug, Default)]
pub struct Place {
    pub(super) layer: u16,
    pub(super) state: State,
    pub(super) pending: Pending,
    /// The body that the ray is in or is about to meet; drawn here once and never moved.
    pub(super) body: Option<Body>,
    /// Where the ray entered it (rung `homogeneous`).
    pub(super) entered: DVec3,
}

impl Default for State {
    fn default() -> Self {
        State::Outside(Face::Top)
    }
}
