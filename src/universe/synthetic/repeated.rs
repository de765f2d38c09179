//! A cell of bodies that repeats itself sideways, met anywhere.

use super::{Place, SyntheticUniverse};
use crate::math::DVec3;
use crate::rng::Stream;
use crate::universe::{Interface, MediumId, Next, Ray, Start, Universe};

/// A periodic cell; every history finds it displaced sideways by chance, so that light falls evenly on the
/// sheet that the cell stands for.
#[derive(Clone, Debug)]
pub struct Repeated {
    cell: SyntheticUniverse,
}

/// Where a ray is, displaced against the cell.
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

impl Repeated {
    /// A universe with periods, met anywhere; one without stands still.
    pub fn new(cell: SyntheticUniverse) -> Self {
        Repeated { cell }
    }

    /// The cell.
    pub fn cell(&self) -> &SyntheticUniverse {
        &self.cell
    }

    /// Medium that a ray is in.
    pub fn medium(&self, here: &Here) -> MediumId {
        self.cell.medium(&here.place)
    }
}

impl Universe for Repeated {
    type Memory = ();
    type Place = Here;

    fn forget(&self, _: &mut ()) {}

    fn enter(&self, ray: &Ray, memory: &mut (), rng: &mut Stream) -> Start<Here> {
        let [x, y] = self.cell.period();
        let shift = DVec3::new(x * rng.uniform(), y * rng.uniform(), 0.0);
        self.come_back(ray, &Here { place: Place::new(*ray), shift }, memory, rng)
    }

    fn come_back(&self, ray: &Ray, here: &Here, _: &mut (), rng: &mut Stream) -> Start<Here> {
        let Start { place, medium } = self.cell.enter(&here.shifted(ray), &mut (), rng);
        Start { place: Here { place, shift: here.shift }, medium }
    }

    #[inline]
    fn next(&self, ray: &Ray, here: &mut Here, _: &mut (), limit: f64, rng: &mut Stream) -> Next {
        self.cell.next(&here.shifted(ray), &mut here.place, &mut (), limit, rng)
    }

    fn moved(&self, ray: &Ray, here: &mut Here, _: &mut (), d: f64) {
        self.cell.moved(&here.shifted(ray), &mut here.place, &mut (), d);
    }

    fn reflected(&self, ray: &Ray, here: &mut Here, _: &mut (), at: &Interface) {
        self.cell.reflected(&here.shifted(ray), &mut here.place, &mut (), at);
    }

    fn crossed(&self, ray: &mut Ray, here: &mut Here, _: &mut (), at: &Interface) {
        let mut moved = here.shifted(ray);
        self.cell.crossed(&mut moved, &mut here.place, &mut (), at);
    }
}
