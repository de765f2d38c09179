//! The SAP as transport uses it: ratios, alias table, directions.

use super::alias::checked_sum;
use super::{AliasTable, FacePatch, Half, Healpix, SapError};
use crate::math::DVec3;
use crate::rng::Stream;

/// Direction of the ray that stands for a drawn patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SapDirections {
    /// Centre of the patch, mean direction of its visible part where the horizon cuts it: the
    /// paper's property 2. Biased to second order in the patch size.
    Centre,
    /// Drawn from the density inside the visible part: unbiased with exact ratios.
    Density,
    /// Drawn uniformly over the visible part.
    Uniform,
}

/// A populated SAP in its local frame.
///
/// `half` is the half sphere that holds the power (surfaces); None for media. Directions are local:
/// turn them with a [`crate::math::Frame`], see [`super::frame_specular`].
#[derive(Clone, Debug)]
pub struct Sap {
    healpix: Healpix,
    half: Option<Half>,
    ratios: Vec<f64>,
    sum: f64,
    alias: AliasTable,
    /// Centre, or mean direction of the visible part.
    centres: Vec<DVec3>,
    /// Place on its face, which spares each draw two divisions and a root.
    places: Vec<FacePatch>,
    /// Angular radius about the centre, as sine.
    radii: Vec<f64>,
    /// Upper bound of the density on each patch (1/sr); empty until given.
    bounds: Vec<f64>,
}

impl Sap {
    /// Table from one share per patch; ratios are the shares divided by their sum.
    ///
    /// # Errors
    /// Wrong number of shares, a share that is negative or not finite, no share above 0, a share on
    /// a patch that lies wholly outside `half`.
    pub fn new(healpix: Healpix, shares: &[f64], half: Option<Half>) -> Result<Self, SapError> {
        let want = healpix.npix();
        if shares.len() != want {
            return Err(SapError::Length { got: shares.len(), want });
        }
        let sum = checked_sum(shares)?;
        let hidden = |&p: &usize| shares[p] > 0.0 && healpix.share_in(p, half) == 0.0;
        if let Some(patch) = (0..want).find(hidden) {
            return Err(SapError::Hidden { patch, share: shares[patch] });
        }
        let centres: Vec<DVec3> = (0..want).map(|p| healpix.representative(p, half)).collect();
        let radii = centres.iter().enumerate().map(|(p, c)| sin_radius(&healpix, p, *c)).collect();
        let places = (0..want).map(|p| healpix.face_patch(p)).collect();
        let alias = AliasTable::new(shares)?;
        let ratios = shares.iter().map(|s| s / sum).collect();
        Ok(Sap { healpix, half, ratios, sum, alias, centres, places, radii, bounds: Vec::new() })
    }

    /// Adds an upper bound of the density on each patch (1/sr), needed for
    /// [`SapDirections::Density`]. The density may have any constant factor, the bounds the same.
    ///
    /// # Errors
    /// Wrong number of bounds; a density above its bound on a grid of 9 × 9 points of a patch.
    pub fn with_bounds(mut self, bounds: Vec<f64>, density: &dyn Fn(DVec3) -> f64) -> Result<Self, SapError> {
        if bounds.len() != self.ratios.len() {
            return Err(SapError::Length { got: bounds.len(), want: self.ratios.len() });
        }
        for (patch, &bound) in bounds.iter().enumerate().filter(|(p, _)| self.ratios[*p] > 0.0) {
            let found = grid(&self.healpix, patch, self.half, 8, density).into_iter().fold(0.0, f64::max);
            if bound.is_nan() || found > bound * (1.0 + 1e-9) {
                return Err(SapError::Bound { patch, density: found, bound });
            }
        }
        self.bounds = bounds;
        Ok(self)
    }

    /// The tessellation.
    pub fn healpix(&self) -> &Healpix {
        &self.healpix
    }

    /// The half sphere that holds the power.
    pub fn half(&self) -> Option<Half> {
        self.half
    }

    /// Ratio of each patch in RING order; they sum to 1.
    pub fn ratios(&self) -> &[f64] {
        &self.ratios
    }

    /// Sum of the shares before they became ratios: for an exact population of a surface its
    /// directional albedo.
    pub fn sum(&self) -> f64 {
        self.sum
    }

    /// Direction that stands for a patch with [`SapDirections::Centre`] (local).
    pub fn centre(&self, patch: usize) -> DVec3 {
        self.centres[patch]
    }

    /// Sine of the angular radius of a patch about its centre (π/2 and more counts as 1).
    pub(crate) fn sin_radius(&self, patch: usize) -> f64 {
        self.radii[patch]
    }

    /// Draws a patch by its ratio.
    #[inline]
    pub fn draw(&self, rng: &mut Stream) -> usize {
        self.alias.draw(rng.bits())
    }

    /// Direction of a drawn patch (local, unit). `density` is asked only for
    /// [`SapDirections::Density`]: uniform proposals are accepted with density/bound.
    ///
    /// # Panics
    /// `Density` without [`Sap::with_bounds`].
    #[inline]
    pub fn direction(
        &self,
        patch: usize,
        how: SapDirections,
        rng: &mut Stream,
        density: impl Fn(DVec3) -> f64,
    ) -> DVec3 {
        match how {
            SapDirections::Centre => self.centres[patch],
            SapDirections::Uniform => self.healpix.uniform_at(self.places[patch], self.half, rng),
            SapDirections::Density => {
                assert!(!self.bounds.is_empty(), "Sap::with_bounds comes before SapDirections::Density");
                loop {
                    let u = self.healpix.uniform_at(self.places[patch], self.half, rng);
                    let d = density(u);
                    // A density that is no number ends the loop.
                    if d.is_nan() || rng.uniform() * self.bounds[patch] < d {
                        return u;
                    }
                }
            }
        }
    }

    /// Mean share of accepted proposals per draw with [`SapDirections::Density`]: 1 / Σ ratio ×
    /// bound·area/share. A law with a low value is better sampled by itself. None without bounds.
    pub fn acceptance(&self) -> Option<f64> {
        if self.bounds.is_empty() {
            return None;
        }
        let area = |p| self.healpix.area() * self.healpix.share_in(p, self.half);
        let tries: f64 = (0..self.ratios.len())
            .filter(|&p| self.ratios[p] > 0.0)
            .map(|p| self.bounds[p] * area(p) / self.sum)
            .sum();
        Some(1.0 / tries)
    }

    /// Mean cosine to the pole, Σ ratio × z of the patch's direction: the g′ of the SAP where the
    /// pole is the axis of a phase function. (1 − g′)/(1 − g) − 1 is the bias of the population and
    /// direction chosen. None for `Density`, which has the law's own.
    pub fn mean_cosine(&self, how: SapDirections) -> Option<f64> {
        let z = |p: usize| match how {
            SapDirections::Centre => Some(self.centres[p].z),
            SapDirections::Uniform => Some(self.healpix.mean_vector(p, self.half).z),
            SapDirections::Density => None,
        };
        (0..self.ratios.len()).map(|p| z(p).map(|z| z * self.ratios[p])).sum()
    }
}

/// Sine of the largest angle between `centre` and the border of a patch, with 2 % to spare.
fn sin_radius(hp: &Healpix, pix: usize, centre: DVec3) -> f64 {
    let chord = hp.boundaries(pix, 8).into_iter().map(|b| (b - centre).length()).fold(0.0, f64::max) * 1.02;
    // chord = 2 sin(a/2)  ⇒  sin a = chord·sqrt(1 − chord²/4)
    if chord * chord >= 2.0 { 1.0 } else { chord * (1.0 - 0.25 * chord * chord).sqrt() }
}

/// Density at (k + 1)² points of the visible part of a patch, borders included.
fn grid(hp: &Healpix, pix: usize, half: Option<Half>, k: usize, density: &dyn Fn(DVec3) -> f64) -> Vec<f64> {
    let cut = hp.share_in(pix, half) == 0.5;
    let mut values = Vec::with_capacity((k + 1) * (k + 1));
    for i in 0..=k {
        for j in 0..=k {
            let (mut fx, mut fy) = (i as f64 / k as f64, j as f64 / k as f64);
            if cut && (fx + fy > 1.0) != (half == Some(Half::Upper)) {
                (fx, fy) = (1.0 - fy, 1.0 - fx);
            }
            values.push(density(hp.direction_in(pix, fx, fy)));
        }
    }
    values
}

/// Upper bounds of a density without a closed form: the greatest of 17 × 17 values on each patch
/// plus the greatest step between neighbouring ones. **An estimate**, right for densities that are
/// smooth on a sixteenth of a patch; a law with a known maximum gives its own.
pub fn estimated_bounds(hp: &Healpix, density: &dyn Fn(DVec3) -> f64, half: Option<Half>) -> Vec<f64> {
    const K: usize = 16;
    let bound = |pix| {
        if hp.share_in(pix, half) == 0.0 {
            return 0.0;
        }
        let d = grid(hp, pix, half, K, density);
        let (mut top, mut step) = (0.0_f64, 0.0_f64);
        for (i, &here) in d.iter().enumerate() {
            top = top.max(here);
            if i % (K + 1) != K {
                step = step.max((d[i + 1] - here).abs());
            }
            if i + K + 1 < d.len() {
                step = step.max((d[i + K + 1] - here).abs());
            }
        }
        top + step
    };
    (0..hp.npix()).map(bound).collect()
}
