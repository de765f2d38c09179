//! Events that change the wavelength: fluorescence, Raman and Brillouin scattering. Each is a Poisson
//! event of its own rate that competes with scattering; the power moves to another lane.

use super::history::{History, Path, Scorer};
use crate::material::Conversion;
use crate::rng::Stream;
use crate::universe::Universe;

/// One event in the lane of the history: false where nothing is emitted.
pub fn event<U: Universe, S: Scorer<N>, const N: usize>(
    converters: &[Conversion],
    rate: f64,
    path: &mut Path<U::Place, N>,
    h: &mut History<U, N>,
    tally: &mut S,
    rng: &mut Stream,
) -> bool {
    let from = h.extra.lane;
    let mut left = rng.uniform() * rate;
    let mut process = &converters[0];
    for c in converters {
        process = c;
        left -= c.rate[from];
        if left < 0.0 {
            break;
        }
    }
    let power = path.power[from];
    path.power[from] = 0.0;
    let u = rng.uniform();
    let target = process.targets[from].iter().find(|t| u < t.cumulative);
    let on = target.map_or(0.0, |t| power * t.kept);
    let mut heat = [0.0; N];
    heat[from] = power - on;
    h.ledger.absorbed[from] += heat[from];
    tally.absorbed_at(path, Some(path.medium), &heat);
    let Some(target) = target else { return false };
    h.ledger.converted[from] += on;
    h.ledger.converted[target.lane] -= on;
    path.power[target.lane] = on;
    h.extra.lane = target.lane;
    on > 0.0
}
