//! Figures of paper optics from reflectances: Kubelka–Munk s and k, opacity, ISO brightness, colour,
//! whiteness, and colour differences.
//!
//! Everything here is a pure and cheap function of reflectance values, so that standard errors can
//! be had by evaluating the same figure on leave-one-out averages (jackknife). A figure that the
//! wavelengths of a scene do not permit is [`NotAvailable`] with the reason, never a guess.

pub mod tables;
pub mod reflectance;
pub mod kubelka_munk;
pub mod colour;
pub mod difference;
pub mod figures;

pub use colour::{ColourWeights, Lab, Observer, WhitenessFormula, Xyz};
pub use difference::{delta_e_2000, delta_e_ab};
pub use figures::{PaperFigure, PaperWeights};
pub use kubelka_munk::{Coefficients, Layer};
pub use reflectance::{NotAvailable, SpectralReflectance};
