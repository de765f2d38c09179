//! Spectra at the price of one where scattering depends on wavelength and directions do not: one path
//! is drawn by the laws of one wavelength (each takes its turn), and stands for all others by weights.
//!
//! Lane k of a path x that lane j might have drawn with probability p_j(x) carries
//! w_k = p_k(x)/mean_j p_j(x) (balance heuristic over all lanes; Veach & Guibas 1995,
//! doi:10.1145/218380.218498; Wilkie et al. 2014, doi:10.1111/cgf.12419). It never exceeds the number of
//! lanes, its mean is 1, and it is 1 where all lanes agree. The ledger books the difference with the
//! roulette's: its mean is 0.

use super::history::History;
use super::ledger::add;
use super::light::Light;
use super::surface::{Directions, Fate, Meeting, SurfaceLaw};
use crate::math::{PI, acos, cos, fast};
use crate::phase::{Phase, Table};
use crate::rng::Stream;
use crate::universe::Universe;
use std::sync::Arc;

/// Steps of θ on which phase functions that differ between lanes are held: linear in cos θ between, for
/// the draw as for the weights.
const STEPS: usize = 8192;

/// What differs between lanes, per medium.
#[derive(Debug, Default)]
pub struct Differences<const N: usize> {
    /// Scattering coefficients by lane, 1/µm, where they differ.
    pub mu_s: Vec<Option<[f64; N]>>,
    /// Densities at the steps of θ by lane, where phase functions differ.
    pub phase: Vec<Option<Vec<[f64; N]>>>,
}

impl<const N: usize> Differences<N> {
    /// Of one light per lane; their phase functions that differ are brought onto common steps.
    ///
    /// # Errors
    /// A phase function that cannot be tabulated.
    pub fn between(lights: &mut [Light<N>]) -> Result<Self, String> {
        let mut out = Differences { mu_s: Vec::new(), phase: Vec::new() };
        let lanes = lights.len();
        for m in 0..lights[0].media.len() {
            let at = |k: usize| lights[k.min(lanes - 1)].media[m].mu_s;
            let mu_s: [f64; N] = std::array::from_fn(at);
            out.mu_s.push(mu_s.iter().any(|x| *x != mu_s[0]).then_some(mu_s));
            let first = lights[0].media[m].phase.clone();
            if lights.iter().all(|l| l.media[m].phase == first) {
                out.phase.push(None);
                continue;
            }
            let mut rows = vec![[0.0; N]; STEPS + 1];
            for k in 0..N {
                if k >= lanes {
                    rows.iter_mut().for_each(|r| r[k] = r[lanes - 1]);
                    continue;
                }
                let medium = &mut lights[k].media[m];
                let angle = |i: usize| if i == STEPS { PI } else { PI * i as f64 / STEPS as f64 };
                let knots: Vec<(f64, f64)> =
                    (0..=STEPS).map(|i| (angle(i), medium.phase.pdf(cos(angle(i))))).collect();
                let table = Table::from_angles(&knots).map_err(|e| e.to_string())?;
                let whole = table.integral_as_written();
                rows.iter_mut().zip(&knots).for_each(|(r, knot)| r[k] = knot.1 / whole);
                medium.phase = Phase::Table(Arc::new(table));
            }
            out.phase.push(Some(rows));
        }
        Ok(out)
    }

    /// Density of a flight of `distance` by lane: µs e^(−µs s) if it ends in an event, e^(−µs s) if it ends
    /// at a surface; `None` where lanes do not differ.
    #[inline]
    pub fn flight(&self, medium: usize, distance: f64, scatters: bool) -> Option<[f64; N]> {
        let mu_s = self.mu_s[medium].as_ref()?;
        let distance = distance.min(f64::MAX);
        let gone = fast::one_minus_exp_neg_each(&mu_s.map(|m| m * distance));
        Some(std::array::from_fn(|k| (1.0 - gone[k]) * if scatters { mu_s[k] } else { 1.0 }))
    }

    /// Density of a turn by the angle with cosine `c`, by lane.
    #[inline]
    pub fn turned(&self, medium: usize, c: f64) -> Option<[f64; N]> {
        let rows = self.phase[medium].as_ref()?;
        let step = PI / STEPS as f64;
        let i = ((acos(c) / step) as usize).min(STEPS - 1);
        let (a, b) = (fast_cos(i as f64 * step), fast_cos((i + 1) as f64 * step));
        let f = ((a - c) / (a - b)).clamp(0.0, 1.0);
        let (near, far) = (&rows[i], &rows[i + 1]);
        Some(std::array::from_fn(|k| near[k] + f * (far[k] - near[k])))
    }
}

/// cos x for 0 ≤ x ≤ π, to some 1e-16 absolute.
#[inline]
fn fast_cos(x: f64) -> f64 {
    fast::cos_sin_turn(x * (0.5 / PI)).0
}

/// Surface whose reflected share depends on wavelength: lane `lane` draws.
pub fn surface<const N: usize>(
    law: &SurfaceLaw<N>,
    m: &Meeting<N>,
    lane: usize,
    rng: &mut Stream,
) -> (Fate<N>, [f64; N]) {
    let r = law.reflectance(m.here, m.beyond, m.cos_i());
    debug_assert!(!law.opaque && !matches!(law.directions, Directions::Facets { .. }));
    if rng.uniform() < r[lane] {
        return (Fate::Reflected { dir: law.reflected_direction(m, rng), absorbed: None }, r);
    }
    let passed = r.map(|r| 1.0 - r);
    match law.refracted_direction(m, rng) {
        Some(dir) => (Fate::Refracted { dir }, passed),
        None => (Fate::Absorbed, passed),
    }
}

/// Multiplies the likelihoods with the densities `by` of an event and brings the power of every lane in
/// line.
#[inline]
pub fn apply<U: Universe, const N: usize>(
    by: &[f64; N],
    lanes: usize,
    power: &mut [f64; N],
    h: &mut History<U, N>,
) {
    // Over that of the drawing lane, which is positive: where all agree, exactly 1.
    let own = 1.0 / by[h.extra.lane];
    let likelihood = &mut h.extra.likelihood;
    let mut sum = 0.0;
    for k in 0..N {
        likelihood[k] *= by[k] * own;
        sum += if k < lanes { likelihood[k] } else { 0.0 };
    }
    let scale = lanes as f64 / sum;
    let mut balance = [0.0; N];
    for k in 0..N {
        likelihood[k] *= scale;
        let f = by[k] * own * scale;
        balance[k] = power[k] * (1.0 - f);
        power[k] *= f;
    }
    add(&mut h.ledger.roulette, &balance);
}
