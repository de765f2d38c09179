//! Rung `markov`: only the medium is known; chords of all phases are exponential with means that depend
//! on direction, redrawn after each event (algorithm A, Levermore–Pomraning).

use super::section::Part;
use super::{Pending, Place, State, StatisticalUniverse};
use crate::rng::Stream;
use crate::universe::sheet::plane_ahead;
use crate::universe::{Interface, Next, Ray};

impl StatisticalUniverse {
    /// Rung `markov`, inside a body: the wall or lumen ends at a rate that depends on direction only.
    pub(super) fn markov_next(
        &self,
        layer: usize,
        ray: &Ray,
        place: &mut Place,
        limit: f64,
        rng: &mut Stream,
    ) -> Next {
        let State::Markov { kind: index, part } = place.state else { return Next::Lost };
        let population = &self.layers[layer];
        let kind = &population.kinds[usize::from(index)];
        let (to_plane, face) = plane_ahead(ray, population.slab.top, population.slab.bottom);
        if matches!(place.pending, Pending::Unexplored) {
            place.pending = self.markov_explore(layer, index, part, ray, limit.min(to_plane), rng);
        }
        let Pending::Chord { distance, inward, outward, axis } = place.pending else {
            return if to_plane <= limit { self.cut_face(layer, face, to_plane) } else { Next::Limit };
        };
        let beyond = match (inward, part) {
            (true, _) => kind.lumen,
            (false, Part::Lumen) => kind.wall,
            (false, Part::Wall) => population.slab.pore,
        };
        // The surface that ends a chord is drawn like one that begins it, seen from the other side.
        Next::Interface(Interface {
            distance,
            normal: outward,
            facet: outward,
            axis,
            beyond,
            surface: kind.surface,
            body: kind.body,
        })
    }

    /// Rates of the ends of a wall or lumen chord: the surface that is met per pore length, Σ_i(u),
    /// over the phase's share per pore share, so that all phases keep their volume.
    fn markov_explore(
        &self,
        layer: usize,
        index: u16,
        part: Part,
        ray: &Ray,
        reach: f64,
        rng: &mut Stream,
    ) -> Pending {
        let population = &self.layers[layer];
        let i = usize::from(index);
        let kind = &population.kinds[i];
        let pore = 1.0 - population.share.iter().sum::<f64>();
        let solid = population.share[i] * population.solid[i];
        let phase = if part == Part::Wall { solid } else { population.share[i] - solid };
        // Twice the rate for walls: a candidate is asked for one of its two surfaces, at random.
        let asked = if part == Part::Wall { 2.0 } else { 1.0 };
        let rate = asked * kind.majorant * population.density[i] * pore / phase;
        let mut distance = 0.0;
        loop {
            distance += rng.exponential() / rate;
            if distance >= reach {
                return Pending::Nothing;
            }
            let at = ray.at(distance);
            let Some(met) = kind.candidate(ray.dir, at, index, rng) else { continue };
            let lumen = met.body.lumen;
            // The same line meets the lumen too if it passes close enough to the axis.
            let through = lumen.and_then(|l| {
                let o = met.body.frame.to_local(at - met.body.centre);
                let d = met.body.frame.to_local(ray.dir);
                l.crossings(o, d).map(|(near, _)| met.body.frame.to_world(l.normal(o + d * near)))
            });
            let axis = met.body.frame.z;
            match part {
                Part::Wall if rng.uniform() < 0.5 => {
                    return Pending::Chord { distance, inward: false, outward: met.outward, axis };
                }
                _ => {
                    if let Some(outward) = through {
                        return Pending::Chord { distance, inward: part == Part::Wall, outward, axis };
                    }
                }
            }
        }
    }
}
