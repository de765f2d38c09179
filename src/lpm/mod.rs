//! The Light Propagation Model (paper, section 3): the life of a ray, from its start to its fate.
//!
//! One ray lives in one component, with one direction, from one event to the next: it is attenuated,
//! meets a subsurface event or an interface, and its power goes on in new directions, energy
//! conserved. The universe says where components are; nothing here knows which universe it is.
//!
//! Powers are carried as `[f64; N]`, one lane per wavelength: `N = 1` is the minimal loop, `N = LANES`
//! the one for spectra whose paths do not depend on wavelength (white Monte Carlo). The latter has room
//! for the full set of effects (`full`), taken up only where a scene calls for them: so there are two
//! compiled loops per universe, and the minimal one knows nothing of the others' effects.

pub mod convert;
pub mod full;
pub mod history;
pub mod ledger;
pub mod light;
pub mod look;
pub mod patches;
pub mod polarised;
pub mod split;
pub mod surface;
pub mod walk;
pub mod weights;

pub use full::Full;
pub use history::{History, Path, Scorer, World, trace};
pub use ledger::Ledger;
pub use light::{Light, Medium};

/// Wavelengths carried by one path of the spectral loop.
pub const LANES: usize = 32;
