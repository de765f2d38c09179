//! Sphere Area Partitioning (paper 3.3): the sphere about a scattering event in patches of equal
//! area, one ratio per patch.
//!
//! - [`Healpix`]: the tessellation, any granularity.
//! - [`populate_exact`], [`populate_centre`]: ratios from a density over directions.
//! - [`AliasTable`]: draws a patch in about a nanosecond.
//! - [`Sap`]: the table that transport uses: draw a patch, give it a direction; turned to the
//!   specular direction with [`frame_specular`] or standing in the surface frame of
//!   [`frame_surface`].
//!
//! Local frame of a SAP: +z the specular direction (reflected, refracted, forward) for the frame
//! `rotated`, the surface normal for `resolved`; x in the plane of incidence, on the side that the
//! light comes from.

mod alias;
mod healpix;
mod patch;
mod populate;
mod rotate;
mod table;

pub use alias::AliasTable;
pub use healpix::{FacePatch, Half, Healpix, Ring};
pub use populate::{Peak, Population, populate_centre, populate_exact, populate_exact_peaks};
pub use rotate::{frame_medium, frame_specular, frame_surface};
pub use table::{Sap, SapDirections, estimated_bounds};

/// What can be wrong with the input of a SAP.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SapError {
    /// nside out of range.
    #[error("granularity {0} is not between 1 and {max}", max = Healpix::MAX_NSIDE)]
    Granularity(u32),
    /// A share that is no share.
    #[error("patch {patch} has the share {share}; shares are finite and not negative")]
    Share {
        /// Patch in RING order.
        patch: usize,
        /// Its share.
        share: f64,
    },
    /// Nothing to draw from.
    #[error("no patch has a share above 0")]
    Empty,
    /// Number of shares or bounds.
    #[error("{got} values for {want} patches")]
    Length {
        /// Values given.
        got: usize,
        /// Patches.
        want: usize,
    },
    /// A patch beyond the horizon with a share.
    #[error("patch {patch} lies wholly beyond the horizon, yet has the share {share}")]
    Hidden {
        /// Patch in RING order.
        patch: usize,
        /// Its share.
        share: f64,
    },
    /// A bound that the density exceeds.
    #[error("the density reaches {density} in patch {patch}, above its bound {bound}")]
    Bound {
        /// Patch in RING order.
        patch: usize,
        /// Density found (1/sr).
        density: f64,
        /// Bound given (1/sr).
        bound: f64,
    },
}
