//! Which cells a scene needs, and where they stand.

use super::{Detectors, View};
use crate::math::DVec3;
use crate::sap::Healpix;
use crate::universe::MediumId;

/// Cells that every run has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// Power that leaves the upper face (upwards, in an unbounded scene).
    Reflected,
    /// Power that leaves the lower face.
    Transmitted,
    /// Power absorbed by the backing.
    Backing,
    /// Roulette balance.
    Roulette,
    /// Masked by facets.
    Masked,
    /// Lost.
    Lost,
    /// Truncated by the event cap.
    Truncated,
    /// Interfaces met, weighted by power.
    Interfaces,
    /// Subsurface events, weighted by power.
    Scatterings,
    /// Power through the checkpoint plane, upwards.
    Checkpoint,
    /// Power moved to other wavelengths, less what came from them.
    Converted,
    /// Power times time of flight (ps) that leaves the upper face.
    TimeReflected,
    /// The same of the lower face.
    TimeTransmitted,
}

const FIXED: usize = 13;

/// Depth bins over the sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depth {
    /// Number of bins, from the top.
    pub bins: u32,
    /// Upper face, µm.
    pub top: f64,
    /// Lower face, µm.
    pub bottom: f64,
}

/// The cells of a run.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Wavelengths carried.
    pub lanes: usize,
    /// Histories that share one realisation: what they score together is one sample.
    pub shared: u64,
    /// So many realisations are met in turn, batch by batch; `None`: one for each history, or for those that
    /// share one.
    pub realisations: Option<u64>,
    /// Number of media.
    pub media: usize,
    /// Directions of what leaves.
    pub angular: Option<Healpix>,
    /// Depth bins.
    pub depth: Option<Depth>,
    /// Height of the checkpoint plane, µm.
    pub checkpoint: Option<f64>,
    /// Path lengths and event counts.
    pub path: bool,
    /// Times of flight.
    pub time: bool,
    /// Instrument of the optical figures.
    pub view: Option<View>,
    /// Sheets in the pile.
    pub pile: u32,
    /// Detectors of what leaves the sheet.
    pub detectors: Detectors,
}

impl Layout {
    /// Position of a fixed cell.
    #[inline]
    pub fn of(&self, cell: Cell) -> usize {
        cell as usize
    }

    /// Power absorbed in a medium.
    #[inline]
    pub fn absorbed(&self, medium: MediumId) -> usize {
        FIXED + usize::from(medium.0)
    }

    /// Path length in a medium, weighted by power, µm.
    #[inline]
    pub fn path_length(&self, medium: MediumId) -> usize {
        FIXED + self.media + usize::from(medium.0)
    }

    fn pile_start(&self) -> usize {
        FIXED + 2 * self.media
    }

    /// Doublings of the pile, the single sheet included.
    pub fn pile_levels(&self) -> usize {
        if self.view.is_some() { 1 + ceil_log2(self.pile) } else { 0 }
    }

    /// Seen power of rays whose deepest sheet is `deepest`: cell k holds 2^(k−1) ≤ deepest < 2^k, so
    /// that cells 0…k together give the pile of 2^k sheets.
    #[inline]
    pub fn pile_cell(&self, deepest: u32) -> usize {
        self.pile_start() + ceil_log2(deepest + 1)
    }

    fn angular_start(&self) -> usize {
        self.pile_start() + self.pile_levels()
    }

    fn patches(&self) -> usize {
        self.angular.as_ref().map_or(0, Healpix::npix)
    }

    /// Cell of a direction that leaves: all patches upwards, then all patches downwards, so that the
    /// patches on the horizon keep the two apart.
    #[inline]
    pub fn angular_cell(&self, dir: DVec3) -> Option<usize> {
        let side = if dir.z < 0.0 { self.patches() } else { 0 };
        self.angular.as_ref().map(|h| self.angular_start() + side + h.pix_of(dir))
    }

    /// Cells of the angular tally: upwards, then downwards.
    pub fn angular_range(&self) -> std::ops::Range<usize> {
        let start = self.angular_start();
        start..start + 2 * self.patches()
    }

    /// Cell of a direction through the checkpoint plane.
    #[inline]
    pub fn checkpoint_cell(&self, dir: DVec3) -> Option<usize> {
        let start = self.angular_start() + 2 * self.patches();
        self.angular.as_ref().map(|h| start + h.pix_of(dir))
    }

    /// Cells of the directions through the checkpoint plane.
    pub fn checkpoint_range(&self) -> std::ops::Range<usize> {
        let start = self.angular_start() + 2 * self.patches();
        start..start + if self.checkpoint.is_some() { self.patches() } else { 0 }
    }

    fn depth_start(&self) -> usize {
        self.checkpoint_range().end
    }

    /// Absorbed power of a medium in a depth bin; the next cell is its fluence (path per history, µm).
    #[inline]
    pub fn depth_cell(&self, medium: MediumId, bin: usize) -> usize {
        let bins = self.depth.map_or(0, |d| d.bins as usize);
        self.depth_start() + 2 * (usize::from(medium.0) * bins + bin)
    }

    /// First cell of the detectors.
    pub fn detectors_start(&self) -> usize {
        self.depth_start() + 2 * self.media * self.depth.map_or(0, |d| d.bins as usize)
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.detectors_start() + self.detectors.cells()
    }
}

/// Smallest k with 2^k ≥ n.
#[inline]
fn ceil_log2(n: u32) -> usize {
    (32 - n.saturating_sub(1).leading_zeros()) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn piles_fall_into_doublings() {
        let expected = [0, 1, 2, 2, 3, 3, 3, 3, 4];
        for (deepest, k) in expected.iter().enumerate() {
            assert_eq!(ceil_log2(deepest as u32 + 1), *k, "deepest {deepest}");
        }
    }
}
