//! Weighted sum of phase functions: p = Σ wᵢ pᵢ, Σ wᵢ = 1. The weights are the shares of the
//! scattering events, so several scatterers in one medium have wᵢ = µs,ᵢ/µs.

use super::alias::{self, Cell};
use super::{Phase, PhaseError, Polar, error};
use crate::rng::Stream;

/// A weighted sum of phase functions.
#[derive(Clone, Debug, PartialEq)]
pub struct Mixture {
    parts: Vec<Part>,
}

#[derive(Clone, Debug, PartialEq)]
struct Part {
    weight: f64,
    phase: Phase,
    cell: Cell,
}

impl Mixture {
    /// From (weight, phase function); the weights ≥ 0 are divided by their sum. Refuses an empty list
    /// and a negative, infinite or missing weight.
    pub fn new(parts: Vec<(f64, Phase)>) -> Result<Self, PhaseError> {
        if let Some(i) = parts.iter().position(|(w, _)| !(*w >= 0.0 && w.is_finite())) {
            return Err(error::place("part", i + 1, format!("weight {} is not a number ≥ 0", parts[i].0)));
        }
        let sum: f64 = parts.iter().map(|(w, _)| w).sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return Err(PhaseError::Whole(
                "the weights of a mixture must have a positive, finite sum".into(),
            ));
        }
        let weights: Vec<f64> = parts.iter().map(|(w, _)| w / sum).collect();
        let cells = alias::cells(&weights);
        let parts = (parts.into_iter().zip(weights).zip(cells))
            .map(|(((_, phase), weight), cell)| Part { weight, phase, cell })
            .collect();
        Ok(Mixture { parts })
    }

    /// The parts: (share of the events, phase function).
    pub fn parts(&self) -> impl Iterator<Item = (f64, &Phase)> {
        self.parts.iter().map(|p| (p.weight, &p.phase))
    }

    pub(super) fn sample(&self, rng: &mut Stream) -> Polar {
        let i = alias::draw(self.parts.len(), |i| self.parts[i].cell, rng);
        self.parts[i].phase.sample(rng)
    }

    pub(super) fn pdf(&self, cos: f64) -> f64 {
        self.parts().map(|(w, p)| w * p.pdf(cos)).sum()
    }

    pub(super) fn mean_cosine(&self) -> f64 {
        self.parts().map(|(w, p)| w * p.mean_cosine()).sum()
    }

    pub(super) fn max_on(&self, lo: f64, hi: f64) -> f64 {
        self.parts().map(|(w, p)| w * p.max_on(lo, hi)).sum()
    }
}
