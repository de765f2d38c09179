//! The Grace way: no densities, but a free-path law and a table of component types over depth.
//!
//! A non-exponential free path needs two laws: p(s) from a surface, and the equilibrium law
//! p_e(s) = (1/s̄) ∫_s^∞ p from the sheet's edge or from an event inside the medium; without the second
//! the mean path 2H of a lossless diffusely lit sheet and reciprocity break. p_e is drawn as a uniform
//! part of a length-weighted free path.

use super::Population;
use super::kind::Encounter;
use crate::law::SizeLaw;
use crate::rng::Stream;
use crate::universe::Ray;

/// Free paths and types.
#[derive(Clone, Debug)]
pub struct Grace {
    path: SizeLaw,
    weighted: SizeLaw,
    /// Relative depth from the top (0…1) and probability of each kind, ascending.
    types: Vec<(f64, Vec<f64>)>,
    /// Factor on the probability of the kind just left.
    contact: f64,
}

impl Grace {
    /// Free-path law (µm), type table over relative depth (rows ascending, each summing to 1), and the
    /// factor by which the kind just left is less likely to be met again.
    pub fn new(path: SizeLaw, types: Vec<(f64, Vec<f64>)>, contact: f64) -> Self {
        Grace { weighted: path.tilted(1.0), path, types, contact }
    }

    /// A free path in µm: from a surface, or the equilibrium law.
    pub fn free_path(&self, from_surface: bool, rng: &mut Stream) -> f64 {
        if from_surface { self.path.sample(rng) } else { self.weighted.sample(rng) * rng.uniform() }
    }

    /// Probabilities of the kinds at a relative depth.
    fn at_depth(&self, depth: f64) -> Vec<f64> {
        let after = self.types.partition_point(|(d, _)| *d <= depth);
        if after == 0 {
            return self.types[0].1.clone();
        }
        let (d0, p0) = &self.types[after - 1];
        let Some((d1, p1)) = self.types.get(after) else { return p0.clone() };
        let f = (depth - d0) / (d1 - d0);
        p0.iter().zip(p1).map(|(a, b)| a + f * (b - a)).collect()
    }

    /// The next body within `reach` and its distance; `from`: kind of the body just left.
    pub(super) fn explore(
        &self,
        p: &Population,
        ray: &Ray,
        from: Option<u16>,
        reach: f64,
        rng: &mut Stream,
    ) -> Option<(f64, Encounter)> {
        let distance = self.free_path(from.is_some(), rng);
        if distance >= reach {
            return None;
        }
        let at = ray.at(distance);
        let depth = (p.slab.top - at.z) / (p.slab.top - p.slab.bottom);
        let mut weights = self.at_depth(depth);
        if let Some(kind) = from {
            weights[usize::from(kind)] *= self.contact;
        }
        let total: f64 = weights.iter().sum();
        let mut x = rng.uniform() * total;
        let index = weights
            .iter()
            .position(|w| {
                x -= w;
                x < 0.0
            })
            .unwrap_or(weights.len() - 1);
        // The type is settled; the body is drawn among those of its kind that the ray can meet.
        loop {
            if let Some(encounter) = p.kinds[index].candidate(ray.dir, at, index as u16, rng) {
                return Some((distance, encounter));
            }
        }
    }
}
