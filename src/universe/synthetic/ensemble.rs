//! Cells of bodies that repeat themselves sideways, met anywhere: one, or several realisations in turn.

use super::place::{Displaced, MOST_TRIES};
use super::{Place, SyntheticUniverse};
use crate::math::DVec3;
use crate::rng::Stream;
use crate::universe::{Interface, MediumId, Next, Ray, Start, Universe};

/// Realisations of one sheet, each a periodic cell. A history meets that of its number, displaced sideways by
/// chance, so that light falls evenly on the sheet that the cell stands for.
#[derive(Clone, Debug)]
pub struct Ensemble {
    cells: Vec<SyntheticUniverse>,
    /// Histories in succession that meet the same one.
    shared: u64,
    from_pores: bool,
}

/// Number of the realisation that the present history meets.
#[derive(Clone, Copy, Debug, Default)]
pub struct Held(usize);

impl Ensemble {
    /// `cells` (at least one; those without periods stand still), met in turn by `shared` histories each.
    pub fn new(cells: Vec<SyntheticUniverse>, shared: u64) -> Self {
        assert!(!cells.is_empty(), "an ensemble of nothing");
        Ensemble { cells, shared: shared.max(1), from_pores: false }
    }

    /// The same, but where light would come into a body it is displaced again: it starts in pores.
    pub fn from_pores(self, from_pores: bool) -> Self {
        Ensemble { from_pores, ..self }
    }

    /// The realisations.
    pub fn cells(&self) -> &[SyntheticUniverse] {
        &self.cells
    }

    /// The realisation that the history `number` meets.
    pub fn realisation(&self, number: u64) -> usize {
        (number / self.shared % self.cells.len() as u64) as usize
    }

    /// Medium that a ray is in.
    pub fn medium(&self, here: &Displaced, held: &Held) -> MediumId {
        self.cells[held.0].medium(&here.place)
    }
}

impl Universe for Ensemble {
    type Memory = Held;
    type Place = Displaced;

    fn forget(&self, _: &mut Held) {}

    fn begin(&self, held: &mut Held, number: u64) {
        held.0 = self.realisation(number);
    }

    fn enter(&self, ray: &Ray, held: &mut Held, rng: &mut Stream) -> Start<Displaced> {
        let [x, y] = self.cells[held.0].period();
        let mut tries = 0;
        loop {
            let shift = DVec3::new(x * rng.uniform(), y * rng.uniform(), 0.0);
            let start = self.come_back(ray, &Displaced { place: Place::new(*ray), shift }, held, rng);
            if !self.from_pores || start.place.in_pore() || tries == MOST_TRIES {
                return start;
            }
            tries += 1;
        }
    }

    fn come_back(&self, ray: &Ray, here: &Displaced, held: &mut Held, rng: &mut Stream) -> Start<Displaced> {
        let Start { place, medium } = self.cells[held.0].enter(&here.shifted(ray), &mut (), rng);
        Start { place: Displaced { place, shift: here.shift }, medium }
    }

    #[inline]
    fn next(&self, ray: &Ray, here: &mut Displaced, held: &mut Held, limit: f64, rng: &mut Stream) -> Next {
        self.cells[held.0].next(&here.shifted(ray), &mut here.place, &mut (), limit, rng)
    }

    fn moved(&self, ray: &Ray, here: &mut Displaced, held: &mut Held, d: f64) {
        self.cells[held.0].moved(&here.shifted(ray), &mut here.place, &mut (), d);
    }

    fn reflected(&self, ray: &Ray, here: &mut Displaced, held: &mut Held, at: &Interface) {
        self.cells[held.0].reflected(&here.shifted(ray), &mut here.place, &mut (), at);
    }

    fn crossed(&self, ray: &mut Ray, here: &mut Displaced, held: &mut Held, at: &Interface) {
        let mut moved = here.shifted(ray);
        self.cells[held.0].crossed(&mut moved, &mut here.place, &mut (), at);
    }
}
