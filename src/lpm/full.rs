//! The full loop: the same life of a ray as in `history`, with the effects that need more than a power
//! per wavelength: polarisation, events that change the wavelength, weights between wavelengths whose
//! media differ, and the time of flight.
//!
//! Compiled for the spectral loop only (N > 1): the minimal loop knows nothing of it.

use super::history::{History, Scorer, World, attenuate, counted, leave, roulette, settle};
use super::ledger::add;
use super::light::{Light, Medium};
use super::polarised::{self, State};
use super::surface::Meeting;
use super::weights::{self, Differences, Pending, Scattering};
use crate::material::Conversion;
use crate::math::DVec3;
use crate::phase::Phase;
use crate::phase::polarised::{ScatteringMatrix, Stokes};
use crate::rng::Stream;
use crate::universe::{Face, Interface, Next, Ray, Universe};

/// Effects of the full loop, settled for a run.
#[derive(Debug, Default)]
pub struct Full<const N: usize> {
    /// Polarisation, if it is simulated.
    pub polarisation: Option<Polarisation>,
    /// One light per lane where media differ between wavelengths; empty: one for all.
    pub lights: Vec<Light<N>>,
    /// What differs between lanes, where they go together by weights.
    pub differences: Differences<N>,
    /// How lanes go together.
    pub lanes: Lanes,
    /// Per medium: events that change the wavelength.
    pub converters: Vec<Vec<Conversion>>,
    /// Time of flight is asked for.
    pub time: bool,
}

/// What a history carries in its lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lanes {
    /// All wavelengths alike.
    #[default]
    White,
    /// All wavelengths, one of them (by the history's number) draws and the others follow by weights.
    Weighted,
    /// One wavelength at a time, this one at the start; events may change it.
    One(usize),
}

/// Polarisation of a run.
#[derive(Clone, Debug)]
pub struct Polarisation {
    /// State of the emitted light; its axis is made orthogonal to each ray.
    pub source: State,
    /// Per medium.
    pub matrices: Vec<ScatteringMatrix>,
    /// What stands before the detectors.
    pub analyser: Option<Analyser>,
}

/// An ideal polariser before the detectors. Its reference plane holds the ray and the normal of the sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Analyser {
    /// Passes the field in the plane of the ray and the normal.
    Parallel,
    /// Passes the field across it.
    Perpendicular,
}

/// What a history carries beside its power.
#[derive(Clone, Copy, Debug)]
pub struct Extra<const N: usize> {
    /// Polarisation.
    pub state: State,
    /// Lane that draws.
    pub lane: usize,
    /// Probability of the path so far by lane, over its mean.
    pub likelihood: [f64; N],
    /// Rounding of the weights' balance in the ledger, carried on.
    pub carry: [f64; N],
    /// Optical path Σ n s, µm.
    pub optical_path: f64,
}

impl<const N: usize> Default for Extra<N> {
    fn default() -> Self {
        Extra { state: State::default(), lane: 0, likelihood: [1.0; N], carry: [0.0; N], optical_path: 0.0 }
    }
}

impl<const N: usize> Full<N> {
    /// The start of history `number`: what it carries, and the power by lane.
    pub fn start(&self, ray: &Ray, number: u64, lanes: usize) -> (Extra<N>, [f64; N]) {
        let mut extra = Extra::default();
        let mut power = [1.0; N];
        if let Some(p) = &self.polarisation {
            let across = p.source.axis - ray.dir * p.source.axis.dot(ray.dir);
            extra.state = match across.try_normalize() {
                Some(axis) => State { stokes: p.source.stokes, axis },
                None => State::none(ray.dir),
            };
        }
        match self.lanes {
            Lanes::White => {}
            Lanes::Weighted => extra.lane = (number / weights::TURN % lanes as u64) as usize,
            Lanes::One(lane) => {
                extra.lane = lane;
                power = std::array::from_fn(|k| f64::from(u8::from(k == lane)));
            }
        }
        (extra, power)
    }

    /// Light as the present lane sees it.
    #[inline]
    fn light<'a>(&'a self, common: &'a Light<N>, lane: usize) -> &'a Light<N> {
        match self.lanes {
            Lanes::One(_) => self.lights.get(lane).unwrap_or(common),
            _ => common,
        }
    }

    /// Share of the power of a leaving ray that passes the analyser.
    pub fn analysed(&self, extra: &Extra<N>, dir: DVec3) -> f64 {
        let Some(analyser) = self.polarisation.as_ref().and_then(|p| p.analyser) else { return 1.0 };
        let q = meridional(&extra.state, dir).q;
        match analyser {
            Analyser::Parallel => 0.5 * (1.0 + q),
            Analyser::Perpendicular => 0.5 * (1.0 - q),
        }
    }
}

/// Stokes parameters with the axis in the plane of the ray and z, towards growing polar angle (along x for
/// a vertical ray).
pub fn meridional(state: &State, dir: DVec3) -> Stokes {
    let side = DVec3::Z.cross(dir);
    let axis = if side.length_squared() > 1e-24 {
        side.normalize().cross(dir)
    } else {
        DVec3::new(dir.z.signum(), 0.0, 0.0)
    };
    state.along(dir, axis).stokes
}

/// A stay in one medium, as in `history`, with the full set of effects. True while the ray lives.
pub(super) fn stay<U: Universe, S: Scorer<N>, const N: usize>(
    world: &World<U, N>,
    full: &Full<N>,
    path: &mut super::Path<U::Place, N>,
    h: &mut History<U, N>,
    tally: &mut S,
    rng: &mut Stream,
) -> bool {
    let index = usize::from(path.medium.0);
    if full.lanes == Lanes::Weighted
        && let Some(scattering) = &full.differences.media[index]
    {
        return stay_weighted(world, full, scattering, path, h, tally, rng);
    }
    if !counted(world, path, h) {
        return false;
    }
    let light = full.light(world.light, h.extra.lane);
    let medium = &light.media[index];
    let converters = full.converters.get(index).map_or(&[][..], Vec::as_slice);
    let changes: f64 = converters.iter().map(|c| c.rate[h.extra.lane]).sum();
    let free =
        if changes > 0.0 { rng.exponential() / (medium.mu_s + changes) } else { medium.free_path(rng) };
    let next = world.universe.next(&path.ray, &mut path.place, &mut h.memory, free, rng);
    if let Next::Limit | Next::Interface(_) | Next::Edge { .. } = next {
        let distance = match &next {
            Next::Interface(at) => at.distance,
            Next::Edge { distance, .. } => *distance,
            _ => free,
        };
        if full.time && distance.is_finite() {
            h.extra.optical_path += medium.n.re * distance;
        }
    }
    match &next {
        Next::Limit => {
            if !attenuate(world, medium, path, free, h, tally, rng) {
                return false;
            }
            if changes > 0.0 && rng.uniform() * (medium.mu_s + changes) < changes {
                if !super::convert::event(converters, changes, path, h, tally, rng) {
                    return false;
                }
                path.ray.dir = Phase::Isotropic.scatter(path.ray.dir, rng);
                h.extra.state = State::none(path.ray.dir);
            } else {
                tally.scattered(path);
                path.ray.dir = turn(full, medium, index, path.ray.dir, h, rng);
            }
            world.universe.moved(&path.ray, &mut path.place, &mut h.memory, free);
            roulette(world, path, h, rng)
        }
        Next::Interface(at) => {
            attenuate(world, medium, path, at.distance, h, tally, rng)
                && meet(world, full, light, medium, path, at, h, tally, rng)
                && roulette(world, path, h, rng)
        }
        Next::Edge { face, distance } => leave(world, medium, path, *face, *distance, h, tally, rng),
        Next::Lost => {
            add(&mut h.ledger.lost, &path.power);
            false
        }
    }
}

/// New direction after a subsurface event.
fn turn<U: Universe, const N: usize>(
    full: &Full<N>,
    medium: &Medium<N>,
    index: usize,
    dir: DVec3,
    h: &mut History<U, N>,
    rng: &mut Stream,
) -> DVec3 {
    if let Some(p) = &full.polarisation {
        return polarised::scatter(medium, &p.matrices[index], dir, &mut h.extra.state, rng);
    }
    medium.scatter(dir, rng)
}

/// A stay in a medium whose scattering differs between lanes: the lane of the history draws, and the
/// others' weights are settled when something looks at the powers. True while the ray lives.
fn stay_weighted<U: Universe, S: Scorer<N>, const N: usize>(
    world: &World<U, N>,
    full: &Full<N>,
    scattering: &Scattering<N>,
    path: &mut super::Path<U::Place, N>,
    h: &mut History<U, N>,
    tally: &mut S,
    rng: &mut Stream,
) -> bool {
    let index = usize::from(path.medium.0);
    let (lanes, lane) = (world.light.lanes, h.extra.lane);
    let medium = &world.light.media[index];
    let draws = &full.lights[lane].media[index];
    let eager = medium.absorbs || full.differences.eager;
    let mut pending = Pending::new();
    loop {
        if !counted(world, path, h) {
            return false;
        }
        let free = draws.free_path(rng);
        let next = world.universe.next(&path.ray, &mut path.place, &mut h.memory, free, rng);
        let distance = match &next {
            Next::Limit => free,
            Next::Interface(at) => at.distance,
            Next::Edge { distance, .. } => *distance,
            Next::Lost => {
                add(&mut h.ledger.lost, &path.power);
                return false;
            }
        };
        if full.time && distance.is_finite() {
            h.extra.optical_path += medium.n.re * distance;
        }
        pending.flight(distance);
        let mut dir = path.ray.dir;
        let ends = !matches!(next, Next::Limit);
        if !ends {
            dir = draws.scatter(path.ray.dir, rng);
            pending.turned(scattering, path.ray.dir.dot(dir).clamp(-1.0, 1.0), lane);
        }
        // What the flight leaves behind belongs to its whole density, that of its end included.
        if eager || ends || pending.full() {
            pending.settle(scattering, lanes, &mut path.power, h);
        }
        match &next {
            Next::Limit => {
                if !attenuate(world, medium, path, free, h, tally, rng) {
                    return false;
                }
                tally.scattered(path);
                path.ray.dir = dir;
                world.universe.moved(&path.ray, &mut path.place, &mut h.memory, free);
                if eager && !roulette(world, path, h, rng) {
                    return false;
                }
            }
            Next::Interface(at) => {
                return attenuate(world, medium, path, at.distance, h, tally, rng)
                    && meet(world, full, world.light, medium, path, at, h, tally, rng)
                    && roulette(world, path, h, rng);
            }
            Next::Edge { face, distance } => {
                return leave(world, medium, path, *face, *distance, h, tally, rng);
            }
            Next::Lost => unreachable!("told above"),
        }
    }
}

/// A surface event.
#[allow(clippy::too_many_arguments)]
fn meet<U: Universe, S: Scorer<N>, const N: usize>(
    world: &World<U, N>,
    full: &Full<N>,
    light: &Light<N>,
    here: &Medium<N>,
    path: &mut super::Path<U::Place, N>,
    at: &Interface,
    h: &mut History<U, N>,
    tally: &mut S,
    rng: &mut Stream,
) -> bool {
    let beyond = &light.media[usize::from(at.beyond.0)];
    let law = &light.surfaces[usize::from(at.surface.0)];
    if law.transparent(here, beyond) {
        world.universe.crossed(&mut path.ray, &mut path.place, &mut h.memory, at);
        path.medium = at.beyond;
        return true;
    }
    tally.interface(path, at);
    let meeting = Meeting { dir: path.ray.dir, at, here, beyond };
    let fate = if full.polarisation.is_some() {
        let mut state = h.extra.state;
        let fate = polarised::draw(law, &meeting, &mut state, &mut path.power, &mut h.ledger, rng);
        h.extra.state = state;
        fate
    } else if full.lanes == Lanes::Weighted && law.varies() {
        let (fate, by) = weights::surface(law, &meeting, h.extra.lane, rng);
        weights::apply(&by, world.light.lanes, &mut path.power, h);
        fate
    } else {
        law.draw(&meeting, &mut path.power, &mut h.ledger, rng)
    };
    settle(world, path, at, fate, h, tally)
}

/// The ray leaves: the detectors see what the analyser passes.
pub(super) fn leaves<U: Universe, S: Scorer<N>, const N: usize>(
    full: &Full<N>,
    path: &super::Path<U::Place, N>,
    face: Face,
    h: &History<U, N>,
    tally: &mut S,
) {
    let share = full.analysed(&h.extra, path.ray.dir);
    let mut seen = *path;
    seen.power = path.power.map(|p| p * share);
    tally.leaves_full(&seen, face, &h.extra);
}
