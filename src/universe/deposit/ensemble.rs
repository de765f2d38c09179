//! Realisations of a deposited sheet, and what they came to.

use super::{CLEAR, Deposit, DepositError, Figures, Laid};
use crate::universe::synthetic::SyntheticUniverse;
use crate::universe::synthetic::ensemble::Ensemble;
use rayon::prelude::*;

/// Realisations of one sheet, and their structure.
#[derive(Clone, Debug)]
pub struct Deposited {
    ensemble: Ensemble,
    figures: Vec<Figures>,
    top: f64,
    /// Mean volume of solid over area by kind, µm.
    solids: Vec<f64>,
    /// Fibres cut to three cells, over all realisations.
    cut: usize,
}

impl Deposited {
    /// The realisations 0 … `realisations` − 1 of `model`, made on rayon's current threads; `shared` histories
    /// in succession meet the same one; `gap`: see [`Laid::figures`].
    ///
    /// # Errors
    /// [`DepositError`]; amounts missed by more than 1 %.
    pub fn new(
        model: &Deposit,
        seed: u64,
        realisations: u64,
        shared: u64,
        gap: f64,
    ) -> Result<Self, DepositError> {
        let lay = |r: u64| {
            let laid = model.lay(seed, r)?;
            model.met(&laid)?;
            let figures = laid.figures(gap);
            Ok((laid, figures))
        };
        let laid: Vec<(Laid, Figures)> =
            (0..realisations.max(1)).into_par_iter().map(lay).collect::<Result<_, DepositError>>()?;
        let top = laid.iter().map(|l| l.0.top).fold(0.0, f64::max) + CLEAR;
        let sheets = laid.par_iter().map(|l| model.universe(&l.0, top)).collect::<Result<_, _>>()?;
        let mut solids = vec![0.0; model.kinds.len()];
        for (l, _) in &laid {
            l.solids(&mut solids);
        }
        solids.iter_mut().for_each(|s| *s /= laid.len() as f64);
        let cut = laid.iter().map(|l| l.0.cut).sum();
        let figures = laid.into_iter().map(|l| l.1).collect();
        Ok(Deposited { ensemble: Ensemble::new(sheets, shared), figures, solids, cut, top })
    }

    /// Upper plane, above all bodies of all realisations, µm; the lower one is at 0.
    pub fn top(&self) -> f64 {
        self.top
    }

    /// Structure of each realisation.
    pub fn figures(&self) -> &[Figures] {
        &self.figures
    }

    /// Mean volume of solid over area of each kind, µm.
    pub fn solids(&self) -> &[f64] {
        &self.solids
    }

    /// Fibres cut to three cells, over all realisations.
    pub fn cut(&self) -> usize {
        self.cut
    }

    /// The realisations.
    pub fn sheets(&self) -> &[SyntheticUniverse] {
        self.ensemble.cells()
    }

    /// What light meets.
    pub fn into_ensemble(self) -> Ensemble {
        self.ensemble
    }

    /// Memory of all realisations, bytes.
    pub fn bytes(&self) -> usize {
        self.sheets().iter().map(SyntheticUniverse::bytes).sum()
    }
}
