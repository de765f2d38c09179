//! Where a flight starts on a surface that rounding has put on the wrong side of it.
//!
//! In the groove between two bodies a ray that is thrown back and forth comes nearer to the edge with every
//! flight, until both surfaces stand within rounding of it. The surface just left is known
//! ([`Stands`](super::Stands)); the other may lie a rounding before the ray or behind it.

use super::flight::{Boundary, Change, Misplaced, boundaries, medium_behind};
use super::memory::{Memory, NONE, Sighting, Touched};
use super::{Exactness, LazyUniverse, Place};
use crate::universe::Ray;

impl Boundary {
    /// Moves the surface to the other side of the flight's start.
    fn settle(&self, touched: &mut [Touched]) {
        let other = if self.distance > 0.0 { 0.0 } else { f64::MIN_POSITIVE };
        for t in touched.iter_mut().filter(|t| t.body == self.body) {
            let s = &mut t.spans;
            let all = [&mut s.from, &mut s.to, &mut s.lumen_from, &mut s.lumen_to];
            all.into_iter().filter(|d| **d == self.distance).for_each(|d| *d = other);
        }
    }
}

impl<E: Exactness> LazyUniverse<E> {
    /// The ray stands within rounding of a surface, in the groove between two bodies, on the side that its
    /// medium denies. The medium is right: a surface that only rounding has passed is met where the ray
    /// stands, and one that the ray has left in truth, though not yet by rounding, is taken as left. No such
    /// surface nearby: the ray is lost.
    #[cold]
    pub(super) fn groove(
        &self,
        ray: &Ray,
        place: &Place,
        m: &mut Memory,
        (scanned, stop): (f64, f64),
    ) -> Result<Option<Change>, Misplaced> {
        let pore = self.sheet.layers[usize::from(place.layer)].slab.pore;
        let beyond = medium_behind(&m.touched, 0.0, self.overlap, pore);
        let near = Self::within_rounding(ray, place, m);
        let explains = near.iter().find(|b| {
            let mut other = m.touched.clone();
            b.settle(&mut other);
            medium_behind(&other, 0.0, self.overlap, pore) == place.medium
        });
        if let Some(left) = explains
            && left.distance > 0.0
        {
            left.settle(&mut m.touched);
            return self.change_ahead(place, m, scanned, stop);
        }
        let Boundary { surface, enters, body, .. } = *explains.or(near.first()).ok_or(Misplaced)?;
        Ok(Some(Change { distance: 0.0, body, surface, enters, beyond, layer: place.layer, outward: None }))
    }

    /// The surfaces at the ray's start, nearest first; their bodies are among those touched from now on.
    fn within_rounding(ray: &Ray, place: &Place, m: &mut Memory) -> Vec<Boundary> {
        /// Largest distance that rounding can explain, in half widths.
        const ROUNDING: f64 = 1e-7;
        let mut near: Vec<Boundary> = Vec::new();
        let mut index = place.past.sighting;
        while index != NONE {
            let Sighting { body, before, layer, .. } = m.sightings[index as usize];
            index = before;
            if layer != place.layer || near.iter().any(|n| n.body == body) {
                continue;
            }
            let Some(t) = Self::touched(ray, place, body, m) else { continue };
            let most = ROUNDING * m.bodies[body as usize].body.outer.a;
            let here = boundaries(&t).into_iter().filter(|b| b.0.abs() <= most);
            let known = near.len();
            near.extend(here.map(|(distance, surface, enters)| Boundary { distance, surface, enters, body }));
            if near.len() > known && !m.touched.iter().any(|t| t.body == body) {
                m.touched.push(t);
            }
        }
        near.sort_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()));
        near
    }
}
