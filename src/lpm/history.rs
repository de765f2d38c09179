//! The event loop: one history from source to fate.

use super::full::{self, Extra, Full};
use super::ledger::{Ledger, add, largest, scaled, total};
use super::light::{Light, Medium};
use super::look;
use super::surface::{Fate, Meeting};
use crate::math::{DVec3, fast};
use crate::rng::Stream;
use crate::universe::sheet::Room;
use crate::universe::{Face, Interface, MediumId, Next, Ray, Universe};

/// What a run holds fixed for all histories of a wavelength group.
#[derive(Debug)]
pub struct World<'a, U: Universe, const N: usize> {
    /// Where components are.
    pub universe: &'a U,
    /// What they do with light.
    pub light: &'a Light<N>,
    /// Power below which roulette plays, relative to the emitted power.
    pub roulette: f64,
    /// Guard on events per history.
    pub event_cap: u64,
    /// Split into all patches instead of drawing one; SAPs and floor.
    pub split: Option<&'a super::split::Split>,
    /// Sheets in the simulated pile (1: the sheet alone).
    pub pile: u32,
    /// Height of the upper face, where light that comes back from a pile enters again, µm.
    pub top: f64,
    /// Height of the lower face, µm.
    pub bottom: f64,
    /// Lambertian backing in optical contact with the lower face: its reflectance.
    pub backing: Option<f64>,
    /// Lambertian backing below an air gap: its reflectance. Light that it sends back no longer counts to
    /// the sheet alone.
    pub gap: Option<f64>,
    /// Analog absorption: a ray is absorbed as a whole or not at all (one lane only).
    pub analog: bool,
    /// Effects of the full loop (spectral loop only: N > 1).
    pub full: Option<&'a Full<N>>,
}

/// A ray on its way.
#[derive(Clone, Copy, Debug)]
pub struct Path<P, const N: usize> {
    /// Position and direction.
    pub ray: Ray,
    /// Where the universe sees it.
    pub place: P,
    /// Medium it is in.
    pub medium: MediumId,
    /// Power by lane.
    pub power: [f64; N],
    /// Sheet of the pile, 0 on top.
    pub sheet: u32,
    /// Deepest sheet entered so far.
    pub deepest: u32,
}

impl<P, const N: usize> Path<P, N> {
    /// Still in the first sheet, never left it: what single-sheet figures count.
    #[inline]
    pub fn single(&self) -> bool {
        self.deepest == 0
    }
}

/// Hears what happens to a history. Every method has an empty default: a tally takes what it needs.
pub trait Scorer<const N: usize> {
    /// A step of length `distance` in `medium` from the path's present position; `absorbed` is the power
    /// that stays there.
    fn step<P>(&mut self, _path: &Path<P, N>, _distance: f64, _mu_a: &[f64; N], _absorbed: &[f64; N]) {}
    /// Of flights and subsurface events, only the power left behind matters: [`Scorer::took`] may stand for
    /// [`Scorer::step`] and [`Scorer::scattered`].
    fn hears_totals_only(&self) -> bool {
        false
    }
    /// Power left behind in a medium by a path that was never out of the first sheet (`single`).
    fn took(&mut self, _medium: MediumId, _single: bool, _absorbed: &[f64; N]) {}
    /// A subsurface event; true: next-event estimation looks from here.
    fn scattered<P>(&mut self, _path: &Path<P, N>) -> bool {
        false
    }
    /// An interface is met (before its fate is drawn); true as for `scattered`.
    fn interface<P>(&mut self, _path: &Path<P, N>, _at: &Interface) -> bool {
        false
    }
    /// Direction towards the `view`-th eye at infinity.
    fn eye(&self, _view: usize) -> Option<DVec3> {
        None
    }
    /// Power per solid angle that goes straight to an eye.
    fn seen(&mut self, _view: usize, _power: &[f64; N]) {}
    /// Power absorbed at an opaque surface (by the medium beyond) or by the backing (`None`).
    fn absorbed_at<P>(&mut self, _path: &Path<P, N>, _beyond: Option<MediumId>, _power: &[f64; N]) {}
    /// Power leaves the first sheet (or the scene) for the first time.
    fn leaves<P>(&mut self, _path: &Path<P, N>, _face: Face) {}
    /// The same in the full loop: what the path carries beside its power.
    fn leaves_full<P>(&mut self, path: &Path<P, N>, face: Face, _extra: &Extra<N>) {
        self.leaves(path, face);
    }
    /// Power leaves the top of a pile after having been below the first sheet.
    fn leaves_pile<P>(&mut self, _path: &Path<P, N>) {}
    /// The universe has no answer where the path stands.
    fn lost<P>(&mut self, _path: &Path<P, N>) {}
}

/// Scratch of one worker, reused from history to history: nothing is allocated once warm.
#[derive(Debug)]
pub struct History<U: Universe, const N: usize> {
    /// Universe's memory.
    pub memory: U::Memory,
    /// Branches waiting.
    pub bank: Vec<Path<U::Place, N>>,
    /// Where the power went.
    pub ledger: Ledger<N>,
    /// Events so far.
    pub events: u64,
    /// The next history shares the realisation of the last.
    pub continues: bool,
    /// Number of the history: which wavelength draws, where they take turns.
    pub number: u64,
    /// What the full loop carries beside the power.
    pub extra: Extra<N>,
}

impl<U: Universe, const N: usize> Default for History<U, N> {
    fn default() -> Self {
        History {
            memory: Default::default(),
            bank: Vec::new(),
            ledger: Ledger::default(),
            events: 0,
            continues: false,
            number: 0,
            extra: Extra::default(),
        }
    }
}

/// Traces one history that starts as `ray` with unit power in every lane. The ledger of `h` holds the
/// balance afterwards.
pub fn trace<U: Universe, S: Scorer<N>, const N: usize>(
    world: &World<U, N>,
    ray: Ray,
    h: &mut History<U, N>,
    tally: &mut S,
    rng: &mut Stream,
) {
    h.ledger = Ledger::default();
    h.events = 0;
    h.bank.clear();
    if h.continues {
        world.universe.share(&mut h.memory);
    } else {
        world.universe.forget(&mut h.memory);
    }
    world.universe.begin(&mut h.memory, h.number);
    let place = U::Place::default();
    let mut path = Path { ray, place, medium: MediumId(0), power: [1.0; N], sheet: 0, deepest: 0 };
    path.medium = world.universe.enter_into(&ray, &mut path.place, &mut h.memory, rng);
    if N > 1
        && let Some(full) = world.full
    {
        (h.extra, path.power) = full.start(&ray, h.number, world.light.lanes);
        h.ledger.emitted = path.power;
        while full::stay(world, full, &mut path, h, tally, rng) {}
        return;
    }
    let Some(split) = world.split else {
        while stay(world, &mut path, h, tally, rng) {}
        return;
    };
    loop {
        while counted(world, &path, h) && split.step(world, &mut path, h, tally, rng) {}
        let Some(branch) = h.bank.pop() else { return };
        path = branch;
    }
}

/// Counts an event; false, and the power is truncated, past the cap.
#[inline]
pub(super) fn counted<U: Universe, const N: usize>(
    world: &World<U, N>,
    path: &Path<U::Place, N>,
    h: &mut History<U, N>,
) -> bool {
    h.events += 1;
    if h.events > world.event_cap {
        add(&mut h.ledger.truncated, &path.power);
        return false;
    }
    true
}

/// A stay in one medium: free path, next interface, attenuation, subsurface event, again and again
/// until the ray meets an interface, leaves, or ends. True while the ray lives.
#[inline(always)]
fn stay<U: Universe, S: Scorer<N>, const N: usize>(
    world: &World<U, N>,
    path: &mut Path<U::Place, N>,
    h: &mut History<U, N>,
    tally: &mut S,
    rng: &mut Stream,
) -> bool {
    let medium = &world.light.media[usize::from(path.medium.0)];
    let room = world.universe.room(&path.place);
    let quick = room != Room::NONE && !world.analog && tally.hears_totals_only();
    loop {
        let free = if quick {
            let Some(free) = wander(world, medium, room, path, h, tally, rng) else { return false };
            free
        } else {
            if !counted(world, path, h) {
                return false;
            }
            medium.free_path(rng)
        };
        let next = world.universe.next(&path.ray, &mut path.place, &mut h.memory, free, rng);
        match &next {
            Next::Limit => {
                // Drawn first: the next flight waits for it, nothing waits for the attenuation.
                let dir = medium.scatter(path.ray.dir, rng);
                if !attenuate(world, medium, path, free, h, tally, rng) {
                    return false;
                }
                if tally.scattered(path) {
                    look::from_medium(world, path, free, h, tally, rng);
                }
                path.ray.dir = dir;
                world.universe.moved(&path.ray, &mut path.place, &mut h.memory, free);
                if !roulette(world, path, h, rng) {
                    return false;
                }
            }
            Next::Interface(at) => {
                return attenuate(world, medium, path, at.distance, h, tally, rng)
                    && meet(world, medium, path, at, h, tally, rng)
                    && roulette(world, path, h, rng);
            }
            Next::Edge { face, distance } => {
                return leave(world, medium, path, *face, *distance, h, tally, rng);
            }
            Next::Lost => {
                add(&mut h.ledger.lost, &path.power);
                tally.lost(path);
                return false;
            }
        }
    }
}

/// Flights in a [`Room`] where nobody listens: the same draws and the same sums as in [`stay`], with the
/// ray in registers. The free path of the flight that leaves the room; `None` if the ray ends.
#[inline(always)]
fn wander<U: Universe, S: Scorer<N>, const N: usize>(
    world: &World<U, N>,
    medium: &Medium<N>,
    room: Room,
    path: &mut Path<U::Place, N>,
    h: &mut History<U, N>,
    tally: &mut S,
    rng: &mut Stream,
) -> Option<f64> {
    let Ray { mut origin, mut dir } = path.ray;
    let (mut power, mut sum) = (path.power, h.ledger.absorbed);
    let (place, single) = (path.medium, path.single());
    let mut events = h.events;
    let mut alive = true;
    let left = loop {
        events += 1;
        let free = medium.free_path(rng);
        let end = origin + dir * free;
        let inside = room.bottom < end.z && end.z < room.top;
        if !inside | (events > world.event_cap) {
            break free;
        }
        let turned = medium.scatter(dir, rng);
        if medium.absorbs {
            let mut taken = fast::one_minus_exp_neg_each(&scaled(&medium.mu_a, free));
            for i in 0..N {
                taken[i] *= power[i];
                sum[i] += taken[i];
                power[i] -= taken[i];
            }
            tally.took(place, single, &taken);
        }
        (origin, dir) = (end, turned);
        if largest(&power) < world.roulette {
            path.power = power;
            alive = roulette(world, path, h, rng);
            power = path.power;
            if !alive {
                break free;
            }
        }
    };
    (path.ray, path.power) = (Ray { origin, dir }, power);
    (h.ledger.absorbed, h.events) = (sum, events);
    if alive && events > world.event_cap {
        add(&mut h.ledger.truncated, &path.power);
        alive = false;
    }
    alive.then_some(left)
}

/// The last flight before a face of the sheet, and what happens there.
#[inline(never)]
#[allow(clippy::too_many_arguments)]
pub(super) fn leave<U: Universe, S: Scorer<N>, const N: usize>(
    world: &World<U, N>,
    medium: &Medium<N>,
    path: &mut Path<U::Place, N>,
    face: Face,
    distance: f64,
    h: &mut History<U, N>,
    tally: &mut S,
    rng: &mut Stream,
) -> bool {
    attenuate(world, medium, path, distance, h, tally, rng)
        && edge(world, path, face, h, tally, rng)
        && roulette(world, path, h, rng)
}

/// Moves the ray by `distance` and leaves the absorbed share behind: 1 − e^(−µa s), paper (15) and (17)
/// in exact form. False if analog absorption took the ray.
#[inline(always)]
pub fn attenuate<U: Universe, S: Scorer<N>, const N: usize>(
    world: &World<U, N>,
    medium: &Medium<N>,
    path: &mut Path<U::Place, N>,
    distance: f64,
    h: &mut History<U, N>,
    tally: &mut S,
    rng: &mut Stream,
) -> bool {
    let mut absorbed = [0.0; N];
    let mut alive = true;
    if medium.absorbs {
        if world.analog {
            alive = rng.uniform() >= fast::one_minus_exp_neg(medium.mu_a[0] * distance);
            if !alive {
                absorbed = path.power;
            }
        } else {
            // A lane without absorption stays without, however far: 0 · ∞ is no number.
            absorbed = fast::one_minus_exp_neg_each(&scaled(&medium.mu_a, distance.min(f64::MAX)));
            for (a, p) in absorbed.iter_mut().zip(&path.power) {
                *a *= p;
            }
        }
        add(&mut h.ledger.absorbed, &absorbed);
    }
    tally.step(path, distance, &medium.mu_a, &absorbed);
    if medium.absorbs {
        for (p, a) in path.power.iter_mut().zip(&absorbed) {
            *p -= a;
        }
    }
    if distance.is_finite() {
        path.ray.origin += path.ray.dir * distance;
    }
    alive
}

/// A surface event, paper (18) and (19).
#[inline(always)]
fn meet<U: Universe, S: Scorer<N>, const N: usize>(
    world: &World<U, N>,
    here: &Medium<N>,
    path: &mut Path<U::Place, N>,
    at: &Interface,
    h: &mut History<U, N>,
    tally: &mut S,
    rng: &mut Stream,
) -> bool {
    let beyond = &world.light.media[usize::from(at.beyond.0)];
    let law = &world.light.surfaces[usize::from(at.surface.0)];
    if law.transparent(here, beyond) {
        world.universe.crossed(&mut path.ray, &mut path.place, &mut h.memory, at);
        path.medium = at.beyond;
        return true;
    }
    if tally.interface(path, at) {
        look::from_surface(world, path, at, law, h, tally, rng);
    }
    let meeting = Meeting { dir: path.ray.dir, at, here, beyond };
    let fate = law.draw(&meeting, &mut path.power, &mut h.ledger, rng);
    settle(world, path, at, fate, h, tally)
}

/// Carries out what a surface has decided.
#[inline(always)]
pub fn settle<U: Universe, S: Scorer<N>, const N: usize>(
    world: &World<U, N>,
    path: &mut Path<U::Place, N>,
    at: &Interface,
    fate: Fate<N>,
    h: &mut History<U, N>,
    tally: &mut S,
) -> bool {
    match fate {
        Fate::Reflected { dir, absorbed } => {
            if let Some(power) = absorbed {
                tally.absorbed_at(path, Some(at.beyond), &power);
            }
            path.ray.dir = dir;
            world.universe.reflected(&path.ray, &mut path.place, &mut h.memory, at);
            true
        }
        Fate::Refracted { dir } => {
            path.ray.dir = dir;
            world.universe.crossed(&mut path.ray, &mut path.place, &mut h.memory, at);
            path.medium = at.beyond;
            true
        }
        Fate::Absorbed => {
            let power = path.power;
            tally.absorbed_at(path, Some(at.beyond), &power);
            add(&mut h.ledger.absorbed, &power);
            false
        }
        Fate::Masked => {
            add(&mut h.ledger.masked, &path.power);
            false
        }
    }
}

/// The ray reaches a face of the sheet, or infinity: it escapes, meets the backing, or goes to the
/// neighbouring sheet of a pile.
pub fn edge<U: Universe, S: Scorer<N>, const N: usize>(
    world: &World<U, N>,
    path: &mut Path<U::Place, N>,
    face: Face,
    h: &mut History<U, N>,
    tally: &mut S,
    rng: &mut Stream,
) -> bool {
    if face == Face::Bottom
        && let Some(rg) = world.backing
    {
        let absorbed = scaled(&path.power, 1.0 - rg);
        tally.absorbed_at(path, None, &absorbed);
        add(&mut h.ledger.absorbed, &absorbed);
        path.power = scaled(&path.power, rg);
        let up = lambertian_up(rng);
        if N > 1 && world.full.is_some() {
            h.extra.state = super::polarised::State::none(up);
        }
        return rg > 0.0 && enter_again(world, path, up, true, h, rng);
    }
    if path.single() {
        match world.full {
            Some(full) if N > 1 => full::leaves(full, path, face, h, tally),
            _ => tally.leaves(path, face),
        }
    }
    if face == Face::Bottom
        && let Some(rg) = world.gap
    {
        add(&mut h.ledger.absorbed, &scaled(&path.power, 1.0 - rg));
        path.power = scaled(&path.power, rg);
        path.deepest = 1;
        let up = lambertian_up(rng);
        if N > 1 && world.full.is_some() {
            h.extra.state = super::polarised::State::none(up);
        }
        return rg > 0.0 && enter_again(world, path, up, true, h, rng);
    }
    match face {
        Face::Top if path.sheet > 0 => {
            path.sheet -= 1;
            enter_again(world, path, path.ray.dir, false, h, rng)
        }
        Face::Bottom if path.sheet + 1 < world.pile => {
            path.sheet += 1;
            path.deepest = path.deepest.max(path.sheet);
            enter_again(world, path, path.ray.dir, false, h, rng)
        }
        _ => {
            if !path.single() && face == Face::Top {
                tally.leaves_pile(path);
            }
            add(&mut h.ledger.escaped, &path.power);
            false
        }
    }
}

/// A direction upwards by Lambert's law.
fn lambertian_up(rng: &mut Stream) -> DVec3 {
    let (cos, sin) = rng.azimuth();
    let s2 = rng.uniform();
    let s = s2.sqrt();
    DVec3::new(s * cos, s * sin, (1.0 - s2).sqrt())
}

/// Into the `same` sheet again, or the next one of a pile, an independent sheet: same point.
fn enter_again<U: Universe, const N: usize>(
    world: &World<U, N>,
    path: &mut Path<U::Place, N>,
    dir: DVec3,
    same: bool,
    h: &mut History<U, N>,
    rng: &mut Stream,
) -> bool {
    path.ray.dir = dir;
    path.ray.origin.z = if dir.z > 0.0 { world.bottom } else { world.top };
    if same {
        let start = world.universe.come_back(&path.ray, &path.place, &mut h.memory, rng);
        (path.place, path.medium) = (start.place, start.medium);
    } else {
        path.medium = world.universe.enter_into(&path.ray, &mut path.place, &mut h.memory, rng);
    }
    true
}

/// Unbiased roulette of weak rays: survival with probability 0.1 at tenfold power. Looks at the largest
/// lane.
#[inline]
pub(super) fn roulette<U: Universe, const N: usize>(
    world: &World<U, N>,
    path: &mut Path<U::Place, N>,
    h: &mut History<U, N>,
    rng: &mut Stream,
) -> bool {
    const SURVIVAL: f64 = 0.1;
    // One lane that is strong enough settles it: no need to look at the others.
    let power = match world.full {
        // Lanes that go together by weights differ up to N-fold: their mean.
        Some(full) if N > 1 && full.lanes == full::Lanes::Weighted => {
            let lanes = world.light.lanes as f64;
            if path.power[h.extra.lane] / lanes >= world.roulette {
                return true;
            }
            total(&path.power, world.light.lanes) / lanes
        }
        _ if path.power[0] >= world.roulette => return true,
        _ => largest(&path.power),
    };
    if power >= world.roulette {
        return true;
    }
    if power > 0.0 && rng.uniform() < SURVIVAL {
        let gained = scaled(&path.power, 1.0 - 1.0 / SURVIVAL);
        add(&mut h.ledger.roulette, &gained);
        path.power = scaled(&path.power, 1.0 / SURVIVAL);
        return true;
    }
    add(&mut h.ledger.roulette, &path.power);
    false
}
