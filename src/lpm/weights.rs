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

/// Histories in a row that one lane draws: its tables stay at hand.
pub const TURN: u64 = 8;
/// Steps of sin(θ/2) on which phase functions that differ between lanes are held, linear in cos θ between, for
/// the draw as for the weights: the fewest of these with which 1 − ⟨cos θ⟩ of every lane is right to [`FINE`],
/// for what fits the cache is drawn faster.
const STEPS: [usize; 5] = [256, 512, 1024, 2048, 4096];
/// See [`STEPS`]; laws so narrow that none suffices (1 − ⟨cos θ⟩ below 8e-4) keep the finest.
const FINE: f64 = 1e-4;
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

/// Points between which a phase function is taken as linear where its steps are made.
const POINTS: usize = 8192;

/// A phase function at so many steps, as a table and as its knots (cos θ = 1 − 2 sin²(θ/2), p).
///
/// A knot has the mean of p under the hat function of its step: integral and mean cosine stay those of p, to
/// 4/3 of the step squared, however the function ripples between.
fn stepped(phase: &Phase, steps: usize) -> Result<(Table, Vec<(f64, f64)>), String> {
    let at = |u: f64| 1.0 - 2.0 * u * u;
    let knot = |i: usize| at(i as f64 / steps as f64);
    let point = |j: usize| at(j as f64 / POINTS as f64);
    let p: Vec<f64> = (0..=POINTS).map(|j| phase.pdf(point(j))).collect();
    let each = POINTS / steps;
    let mut sums = vec![[0.0; 2]; steps + 1];
    for i in 0..steps {
        let (first, length) = (knot(i), knot(i) - knot(i + 1));
        for j in i * each..(i + 1) * each {
            let (a, b) = (point(j), point(j + 1));
            // The hat of the next knot rises from 0 to 1 over the step, that of this one falls.
            let (rise, fall) = ([first - a, first - b].map(|x| x / length), |r: [f64; 2]| r.map(|r| 1.0 - r));
            for (k, [f, g]) in [(i, fall(rise)), (i + 1, rise)] {
                sums[k][0] += (a - b) * (p[j] * (2.0 * f + g) + p[j + 1] * (f + 2.0 * g)) / 6.0;
                sums[k][1] += (a - b) * 0.5 * (f + g);
            }
        }
    }
    let knots: Vec<(f64, f64)> = sums.iter().enumerate().map(|(i, s)| (knot(i), s[0] / s[1])).collect();
    Ok((Table::from_cosines(&knots).map_err(|e| e.to_string())?, knots))
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
        let all = |steps: usize| {
            lights.iter().map(|l| stepped(&l.media[m].phase, steps)).collect::<Result<Vec<_>, _>>()
        };
        let fine = |found: &[(Table, Vec<(f64, f64)>)]| {
            found.iter().zip(lights.iter()).all(|((table, _), l)| {
                let (g, want) = (table.mean_cosine(), l.media[m].phase.mean_cosine());
                (g - want).abs() <= FINE * (1.0 - want)
            })
        };
        let mut found: Vec<_> = Vec::new();
        for steps in STEPS {
            found = all(steps)?;
            if fine(&found) {
                break;
            }
        }
        let mut rows = vec![[0.0; N]; found[0].1.len()];
        for (k, (table, knots)) in found.into_iter().enumerate() {
            let medium = &mut lights[k].media[m];
            let scale = medium.mu_s / table.integral_as_written();
            rows.iter_mut().zip(&knots).for_each(|(r, knot)| r[k] = knot.1 * scale);
            medium.phase = Phase::Table(Arc::new(table));
        }
        rows.iter_mut().for_each(|r| (lanes..N).for_each(|k| r[k] = r[lanes - 1]));
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
        let steps = rows.len() - 1;
        let x2 = 0.5 * (1.0 - c) * (steps * steps) as f64;
        let i = (x2.sqrt() as usize).min(steps - 1);
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
