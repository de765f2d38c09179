//! The law of the layers: a reversible Markov chain of phases over depth.
//!
//! Layers of phase i are exponential in thickness with mean Λ_i; the phase behind the end of a layer of
//! phase i is j ≠ i with probability
//!
//! P_ij = a_j / Σ_{k≠i} a_k,
//!
//! a the shares of the phases. Planes between i and j then have the density a_i a_j in either order
//! (detailed balance), so the mixture is the same read upwards and downwards, and a point lies in
//! phase i with probability
//!
//! p_i = Λ_i a_i (A − a_i) / Σ_j Λ_j a_j (A − a_j), A = Σ a.
//!
//! Two cases are the usual ones. Equal shares (always so for two phases, where a does not matter):
//! P_ij = 1/(M − 1) and p_i = Λ_i/ΣΛ_j. Shares a_i = p_i with Λ_i = Λ/(1 − p_i): a Poisson tessellation
//! with spacing Λ whose cells are coloured independently, P_ij = p_j/(1 − p_i).
//!
//! Source: Adams, Larsen & Pomraning 1989, J. Quant. Spectrosc. Radiat. Transfer 42, 253,
//! doi:10.1016/0022-4073(89)90072-1 (two phases); Larmier et al. 2017, arXiv:1609.07948 (coloured tessellations).

use super::super::MediumId;
use crate::rng::Stream;
use thiserror::Error;

/// A phase of a mixture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// What its layers are made of.
    pub medium: MediumId,
    /// Mean thickness Λ of a layer, µm.
    pub chord: f64,
    /// Share a among the phases that may follow another; 1 unless there are more than two.
    pub share: f64,
}

/// Phases that make no mixture.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum ChainError {
    /// A layer must have a neighbour.
    #[error("a mixture has at least two phases, and at most 65535")]
    Phases,
    /// Chord of that phase (from 0).
    #[error("mean chord {1} um of phase {0}: a chord is positive and finite")]
    Chord(usize, f64),
    /// Share of that phase (from 0).
    #[error("share {1} of phase {0}: a share is positive and finite")]
    Share(usize, f64),
}

/// The chain of phases.
#[derive(Clone, Debug)]
pub struct Chain {
    phases: Vec<Phase>,
    volume: Vec<f64>,
    total_share: f64,
}

impl Chain {
    /// The chain of these phases.
    ///
    /// # Errors
    /// Fewer than two phases; chords or shares that are not positive and finite.
    pub fn new(phases: Vec<Phase>) -> Result<Self, ChainError> {
        if phases.len() < 2 || phases.len() > usize::from(u16::MAX) {
            return Err(ChainError::Phases);
        }
        for (i, p) in phases.iter().enumerate() {
            if !(p.chord > 0.0 && p.chord.is_finite()) {
                return Err(ChainError::Chord(i, p.chord));
            }
            if !(p.share > 0.0 && p.share.is_finite()) {
                return Err(ChainError::Share(i, p.share));
            }
        }
        let total_share: f64 = phases.iter().map(|p| p.share).sum();
        let others = |i: usize| -> f64 {
            phases.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, p)| p.share).sum()
        };
        let weights: Vec<f64> =
            phases.iter().enumerate().map(|(i, p)| p.chord * p.share * others(i)).collect();
        let sum: f64 = weights.iter().sum();
        Ok(Chain { volume: weights.iter().map(|w| w / sum).collect(), total_share, phases })
    }

    /// The phases.
    pub fn phases(&self) -> &[Phase] {
        &self.phases
    }

    /// Share p_i of the volume that is of each phase.
    pub fn volume(&self) -> &[f64] {
        &self.volume
    }

    /// Medium of phase `i`.
    #[inline]
    pub(super) fn medium(&self, i: u16) -> MediumId {
        self.phases[usize::from(i)].medium
    }

    /// Thickness of what is left of a layer of phase `i`, µm: exponential, whatever is known of it.
    #[inline]
    pub(super) fn rest(&self, i: u16, rng: &mut Stream) -> f64 {
        self.phases[usize::from(i)].chord * rng.exponential()
    }

    /// Phase at a point of which nothing is known.
    pub(super) fn at_a_point(&self, rng: &mut Stream) -> u16 {
        let mut x = rng.uniform();
        for (i, p) in self.volume.iter().enumerate() {
            x -= p;
            if x < 0.0 {
                return i as u16;
            }
        }
        self.phases.len() as u16 - 1
    }

    /// Phase behind the end of a layer of phase `i`. Two phases take no random number.
    #[inline]
    pub(super) fn behind(&self, i: u16, rng: &mut Stream) -> u16 {
        if self.phases.len() == 2 {
            return 1 - i;
        }
        let mut x = rng.uniform() * (self.total_share - self.phases[usize::from(i)].share);
        let mut last = i;
        for (j, p) in self.phases.iter().enumerate().filter(|(j, _)| *j != usize::from(i)) {
            last = j as u16;
            x -= p.share;
            if x < 0.0 {
                break;
            }
        }
        last
    }
}
