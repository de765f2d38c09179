//! Realisations of a deposited sheet, and light that meets one after the other.

use super::{CLEAR, Deposit, DepositError, Figures, Laid};
use crate::math::DVec3;
use crate::rng::Stream;
use crate::universe::synthetic::{Place, SyntheticUniverse};
use crate::universe::{Interface, MediumId, Next, Ray, Start, Universe};
use rayon::prelude::*;

/// Realisations of one sheet. A history meets that of its number, at a place of its own in the cell.
#[derive(Clone, Debug)]
pub struct Deposited {
    sheets: Vec<SyntheticUniverse>,
    figures: Vec<Figures>,
    /// Edge of the cell, µm.
    cell: f64,
    top: f64,
    /// Mean volume of solid over area by kind, µm.
    solids: Vec<f64>,
    /// Fibres cut to three cells, over all realisations.
    cut: usize,
    /// Histories in succession that meet the same realisation.
    shared: u64,
}

/// Number of the realisation that the present history meets.
#[derive(Clone, Copy, Debug, Default)]
pub struct Held(usize);

/// Where a ray is: in a realisation, displaced against it.
#[derive(Clone, Copy, Debug)]
pub struct Here {
    place: Place,
    shift: DVec3,
}

impl Here {
    fn shifted(&self, ray: &Ray) -> Ray {
        Ray { origin: ray.origin + self.shift, dir: ray.dir }
    }
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
        Ok(Deposited { sheets, figures, solids, cut, cell: model.cell, top, shared: shared.max(1) })
    }

    /// Upper plane, above all bodies of all realisations, µm; the lower one is at 0.
    pub fn top(&self) -> f64 {
        self.top
    }

    /// Edge of the cell, µm.
    pub fn cell(&self) -> f64 {
        self.cell
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
        &self.sheets
    }

    /// Memory of all realisations, bytes.
    pub fn bytes(&self) -> usize {
        self.sheets.iter().map(SyntheticUniverse::bytes).sum()
    }

    /// The realisation that the history `number` meets.
    pub fn realisation(&self, number: u64) -> usize {
        (number / self.shared % self.sheets.len() as u64) as usize
    }

    /// Medium that a ray is in.
    pub fn medium(&self, here: &Here, held: &Held) -> MediumId {
        self.sheets[held.0].medium(&here.place)
    }
}

impl Universe for Deposited {
    type Memory = Held;
    type Place = Here;

    fn forget(&self, _: &mut Held) {}

    fn begin(&self, held: &mut Held, number: u64) {
        held.0 = self.realisation(number);
    }

    fn enter(&self, ray: &Ray, held: &mut Held, rng: &mut Stream) -> Start<Here> {
        let shift = DVec3::new(rng.uniform(), rng.uniform(), 0.0) * self.cell;
        let here = Here { place: Place::new(*ray), shift };
        self.come_back(ray, &here, held, rng)
    }

    fn come_back(&self, ray: &Ray, here: &Here, held: &mut Held, rng: &mut Stream) -> Start<Here> {
        let Start { place, medium } = self.sheets[held.0].enter(&here.shifted(ray), &mut (), rng);
        Start { place: Here { place, shift: here.shift }, medium }
    }

    #[inline]
    fn next(&self, ray: &Ray, here: &mut Here, held: &mut Held, limit: f64, rng: &mut Stream) -> Next {
        self.sheets[held.0].next(&here.shifted(ray), &mut here.place, &mut (), limit, rng)
    }

    fn moved(&self, ray: &Ray, here: &mut Here, held: &mut Held, d: f64) {
        self.sheets[held.0].moved(&here.shifted(ray), &mut here.place, &mut (), d);
    }

    fn reflected(&self, ray: &Ray, here: &mut Here, held: &mut Held, at: &Interface) {
        self.sheets[held.0].reflected(&here.shifted(ray), &mut here.place, &mut (), at);
    }

    fn crossed(&self, ray: &mut Ray, here: &mut Here, held: &mut Held, at: &Interface) {
        let mut moved = here.shifted(ray);
        self.sheets[held.0].crossed(&mut moved, &mut here.place, &mut (), at);
    }
}
