//! The one place where a run asks which universe it is in.

use super::mixture::MixtureUniverse;
use super::statistical::StatisticalUniverse;
use super::statistical::lazy::LazyUniverse;
use super::synthetic::SyntheticUniverse;
use super::synthetic::drum::Drum;
use super::synthetic::ensemble::Ensemble;
use super::synthetic::stack::Stack;
use super::topography::Topography;
use super::voxel::VoxelUniverse;

/// Any universe; matched once per run, never per event.
#[derive(Clone, Debug)]
pub enum AnyUniverse {
    /// Known by statistics.
    Statistical(StatisticalUniverse),
    /// Known by statistics, with a memory of the bodies met.
    Lazy(LazyUniverse),
    /// Layers of random thickness.
    Mixture(MixtureUniverse),
    /// Explicit bodies.
    Synthetic(SyntheticUniverse),
    /// Explicit bodies that repeat themselves sideways, one cell or several in turn.
    Ensemble(Ensemble),
    /// Explicit bodies drawn from statistics, a realisation after the other.
    Realised(Drum),
    /// Several layers of these, or one whose faces have a surface.
    Stack(Stack),
    /// Explicit bodies cut off by measured surfaces.
    Topography(Topography),
    /// A labelled volume.
    Voxel(VoxelUniverse),
}
