//! Spectra at the price of one where scattering depends on wavelength and directions do not: one path
//! is drawn by the laws of one wavelength (each takes its turn), and stands for all others by weights.
//!
//! Lane k of a path x that lane j might have drawn with probability p_j(x) carries
//! w_k = p_k(x)/mean_j p_j(x) (balance heuristic over all lanes; Veach & Guibas 1995,
//! doi:10.1145/218380.218498; Wilkie et al. 2014, doi:10.1111/cgf.12419). It never exceeds the number of
//! lanes, its mean is 1, and it is 1 where all lanes agree. The ledger books the difference with the
//! roulette's: its mean is 0.

use super::history::History;
use super::ledger::total;
use super::light::Light;
use super::surface::{Directions, Fate, Meeting, SurfaceLaw};
use crate::math::fast;
use crate::phase::{Phase, Table};
use crate::rng::Stream;
use crate::universe::Universe;
use std::sync::Arc;

/// Steps of sin(θ/2) on which phase functions that differ between lanes are held: linear in cos θ between,
/// for the draw as for the weights.
const STEPS: usize = 2048;
/// Scatterings after which weights are settled at the latest: their product stays a number.
const MOST: u32 = 64;

/// How a medium scatters in every lane.
#[derive(Debug)]
pub struct Scattering<const N: usize> {
    /// Coefficients by lane, 1/µm.
    mu_s: [f64; N],
    /// The smallest of them.
    least: f64,
    /// Density µs p(cos θ) of an event by lane at the steps, where phase functions differ.
    rows: Option<Vec<[f64; N]>>,
}

/// What differs between lanes, per medium; `None` where nothing does.
#[derive(Debug, Default)]
pub struct Differences<const N: usize> {
    /// Per medium.
    pub media: Vec<Option<Scattering<N>>>,
    /// Weights are settled at every event: a tally looks at each step.
    pub eager: bool,
}

/// Cosine of a step: 1 − 2 sin²(θ/2).
fn knot(i: usize) -> f64 {
    let u = i as f64 / STEPS as f64;
    1.0 - 2.0 * u * u
}

impl<const N: usize> Differences<N> {
    /// Of one light per lane; their phase functions that differ are brought onto common steps.
    ///
    /// # Errors
    /// A phase function that cannot be tabulated.
    pub fn between(lights: &mut [Light<N>], eager: bool) -> Result<Self, String> {
        let media = (0..lights[0].media.len()).map(|m| Self::medium(lights, m)).collect::<Result<_, _>>()?;
        Ok(Differences { media, eager })
    }

    fn medium(lights: &mut [Light<N>], m: usize) -> Result<Option<Scattering<N>>, String> {
        let lanes = lights.len();
        let mu_s: [f64; N] = std::array::from_fn(|k| lights[k.min(lanes - 1)].media[m].mu_s);
        let least = mu_s.iter().copied().fold(f64::INFINITY, f64::min);
        let first = lights[0].media[m].phase.clone();
        let same = lights.iter().all(|l| l.media[m].phase == first);
        if same {
            let differ = mu_s.iter().any(|x| *x != mu_s[0]);
            return Ok(differ.then_some(Scattering { mu_s, least, rows: None }));
        }
        let mut rows = vec![[0.0; N]; STEPS + 1];
        for k in 0..N {
            if k >= lanes {
                rows.iter_mut().for_each(|r| r[k] = r[lanes - 1]);
                continue;
            }
            let medium = &mut lights[k].media[m];
            let knots: Vec<(f64, f64)> = (0..=STEPS).map(|i| (knot(i), medium.phase.pdf(knot(i)))).collect();
            let table = Table::from_cosines(&knots).map_err(|e| e.to_string())?;
            let scale = medium.mu_s / table.integral_as_written();
            rows.iter_mut().zip(&knots).for_each(|(r, knot)| r[k] = knot.1 * scale);
            medium.phase = Phase::Table(Arc::new(table));
        }
        Ok(Some(Scattering { mu_s, least, rows: Some(rows) }))
    }
}

/// Densities of a stay in one medium by lane, not yet in the powers.
#[derive(Debug)]
pub struct Pending<const N: usize> {
    by: [f64; N],
    path: f64,
    events: u32,
}

impl<const N: usize> Pending<N> {
    /// Nothing yet.
    pub fn new() -> Self {
        Pending { by: [1.0; N], path: 0.0, events: 0 }
    }

    /// A flight of `distance`.
    #[inline]
    pub fn flight(&mut self, distance: f64) {
        self.path += distance.min(f64::MAX);
    }

    /// A scattering by the angle with cosine `c`, drawn by lane `lane`: density µs p by lane over its own.
    #[inline]
    pub fn turned(&mut self, medium: &Scattering<N>, c: f64, lane: usize) {
        self.events += 1;
        let Some(rows) = &medium.rows else {
            let own = 1.0 / medium.mu_s[lane];
            for (b, m) in self.by.iter_mut().zip(&medium.mu_s) {
                *b *= m * own;
            }
            return;
        };
        let x2 = 0.5 * (1.0 - c) * (STEPS * STEPS) as f64;
        let i = (x2.sqrt() as usize).min(STEPS - 1);
        let f = ((x2 - (i * i) as f64) / (2 * i + 1) as f64).clamp(0.0, 1.0);
        let (near, far) = (&rows[i], &rows[i + 1]);
        let own = 1.0 / (near[lane] + f * (far[lane] - near[lane]));
        for k in 0..N {
            self.by[k] *= (near[k] + f * (far[k] - near[k])) * own;
        }
    }

    /// More would leave the range of numbers.
    #[inline]
    pub fn full(&self) -> bool {
        self.events >= MOST
    }

    /// Brings the powers in line: the densities so far, with e^(−µs s) of the path.
    #[inline]
    pub fn settle<U: Universe>(
        &mut self,
        medium: &Scattering<N>,
        lanes: usize,
        power: &mut [f64; N],
        h: &mut History<U, N>,
    ) {
        // Only ratios count: over that of the lane that scatters least.
        let mut depth = [0.0; N];
        for (d, m) in depth.iter_mut().zip(&medium.mu_s) {
            *d = (m - medium.least) * self.path;
        }
        let mut by = fast::one_minus_exp_neg_each(&depth);
        for (b, pending) in by.iter_mut().zip(&self.by) {
            *b = (1.0 - *b) * pending;
        }
        *self = Pending::new();
        apply(&by, lanes, power, h);
    }
}

impl<const N: usize> Default for Pending<N> {
    fn default() -> Self {
        Self::new()
    }
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
    for k in 0..N {
        likelihood[k] *= by[k] * own;
    }
    let scale = lanes as f64 / total(likelihood, lanes);
    let (ledger, carry) = (&mut h.ledger.roulette, &mut h.extra.carry);
    for k in 0..N {
        likelihood[k] *= scale;
        let after = power[k] * (by[k] * own * scale);
        // What rounding takes from the running sum is carried on: powers go up and down a thousand times.
        let balance = (power[k] - after) - carry[k];
        let sum = ledger[k] + balance;
        carry[k] = (sum - ledger[k]) - balance;
        ledger[k] = sum;
        power[k] = after;
    }
}
