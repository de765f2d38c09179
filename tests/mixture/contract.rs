//! What every universe promises, and what a branch remembers.

use crate::{RUNGS, THREE, down, slab, stream};
use lightpro::math::DVec3;
use lightpro::rng::Stream;
use lightpro::universe::mixture::memory::Memory;
use lightpro::universe::mixture::{MixtureUniverse, Place, Rung};
use lightpro::universe::{Face, Next, Ray, Universe};

const HEIGHT: f64 = 8.0;

/// A ray at random events: scattered, reflected, passed on.
#[derive(Clone, Copy)]
struct Walk {
    ray: Ray,
    place: Place,
}

impl Walk {
    fn begin(universe: &MixtureUniverse, memory: &mut Memory, rng: &mut Stream) -> Self {
        let ray = Ray { origin: DVec3::new(0.0, 0.0, HEIGHT), dir: down(0.1 + 0.9 * rng.uniform()) };
        Walk { ray, place: universe.enter(&ray, memory, rng).place }
    }

    /// One event, `next` asked twice; `None` at the end.
    fn step(&mut self, universe: &MixtureUniverse, memory: &mut Memory, rng: &mut Stream) -> Option<Next> {
        let limit = if rng.uniform() < 0.4 { 3.0 * rng.uniform() } else { f64::INFINITY };
        let next = universe.next(&self.ray, &mut self.place, memory, limit, rng);
        let again = universe.next(&self.ray, &mut self.place, memory, limit, rng);
        assert_eq!(next, again, "asked twice");
        match next {
            Next::Interface(at) => {
                assert!(at.distance >= 0.0 && at.distance <= limit, "distance {}", at.distance);
                assert!(
                    at.normal.z.abs() == 1.0 && at.normal.dot(self.ray.dir) < 0.0,
                    "normal {}",
                    at.normal
                );
                self.ray.origin = self.ray.at(at.distance);
                if rng.uniform() < 0.2 {
                    self.ray.dir = lightpro::material::fresnel::reflect(self.ray.dir, at.normal);
                    universe.reflected(&self.ray, &mut self.place, memory, &at);
                } else {
                    universe.crossed(&mut self.ray, &mut self.place, memory, &at);
                }
            }
            Next::Limit => {
                self.ray.origin = self.ray.at(limit);
                let (c, s) = rng.azimuth();
                let z = 2.0 * rng.uniform() - 1.0;
                let r = (1.0 - z * z).sqrt();
                self.ray.dir = DVec3::new(r * c, r * s, z);
                universe.moved(&self.ray, &mut self.place, memory, limit);
            }
            Next::Edge { face, distance } => {
                assert!(distance >= 0.0 && distance <= limit);
                let want = if face == Face::Top { HEIGHT } else { 0.0 };
                let z = self.ray.at(distance).z;
                assert!((z - want).abs() < 1e-9, "leaves at z = {z}");
                return None;
            }
            Next::Lost => panic!("lost"),
        }
        Some(next)
    }
}

#[test]
fn walks_keep_the_contract() {
    for clear in [true, false] {
        for rung in RUNGS {
            let universe = slab(&THREE, HEIGHT, rung, clear);
            let (mut memory, mut events) = (Memory::default(), 0);
            for number in 0..20_000 {
                let mut rng = stream(number);
                universe.forget(&mut memory);
                let mut walk = Walk::begin(&universe, &mut memory, &mut rng);
                while walk.step(&universe, &mut memory, &mut rng).is_some() {
                    events += 1;
                    if let Rung::Layers(k) = rung {
                        assert!(walk.place.layers_known() <= k);
                    }
                }
            }
            assert!(events > 100_000, "{rung:?}: {events} events");
        }
    }
}

/// With full memory a ray finds every plane again, bit by bit, and no new one between those met; with
/// the last k layers, those of the last k.
#[test]
fn planes_are_found_again() {
    for rung in [Rung::Layers(1), Rung::Layers(2), Rung::Layers(4), Rung::Full] {
        let keep = if let Rung::Layers(k) = rung { k as usize } else { usize::MAX };
        let universe = slab(&THREE, HEIGHT, rung, true);
        let (mut memory, mut again, mut fresh) = (Memory::default(), 0, 0);
        for number in 0..5_000 {
            let mut rng = stream(number);
            universe.forget(&mut memory);
            let mut walk = Walk::begin(&universe, &mut memory, &mut rng);
            // Planes around the layers known, ascending; the faces are the ends.
            let mut planes = std::collections::VecDeque::from([HEIGHT]);
            // The plane above the ray is planes[above].
            let mut above = 0;
            loop {
                let before = walk;
                let Some(next) = walk.step(&universe, &mut memory, &mut rng) else { break };
                let Next::Interface(at) = next else { continue };
                let upwards = before.ray.dir.z > 0.0;
                let z = before.ray.at(at.distance).z;
                let known =
                    if upwards { planes.get(above) } else { planes.get(above.wrapping_sub(1)) }.copied();
                match known {
                    Some(plane) => {
                        again += 1;
                        assert!((z - plane).abs() < 1e-12 * HEIGHT, "{rung:?}: {z}, known {plane}");
                    }
                    None if upwards => planes.push_back(z),
                    None => {
                        planes.push_front(z);
                        above += 1;
                    }
                }
                fresh += u32::from(known.is_none());
                let crossed = (walk.ray.dir.z > 0.0) == upwards;
                if crossed {
                    above = if upwards { above + 1 } else { above - 1 };
                    // k layers have k + 1 planes; the one ahead of a new layer is not yet drawn.
                    while planes.len() > keep && upwards && above == planes.len() {
                        planes.pop_front();
                        above -= 1;
                    }
                    while planes.len() > keep && !upwards && above == 0 {
                        planes.pop_back();
                    }
                }
            }
        }
        println!("{rung:?}: {again} planes met again, {fresh} new");
        assert!(again > 5_000 && fresh > 5_000);
    }
}

/// What a walk meets from a place on, as numbers.
fn tale(
    universe: &MixtureUniverse,
    mut walk: Walk,
    memory: &mut Memory,
    rng: &mut Stream,
    most: usize,
) -> Vec<Next> {
    let mut out = Vec::new();
    while out.len() < most {
        match walk.step(universe, memory, rng) {
            Some(next) => out.push(next),
            None => break,
        }
    }
    out
}

/// A branch sees its own past only: it goes the same way whether its siblings have gone before it,
/// are there at all, or the memory was filled by other histories.
#[test]
fn branches_see_their_own_past() {
    for rung in RUNGS {
        let universe = slab(&THREE, HEIGHT, rung, true);
        let (mut crowded, mut compared) = (Memory::default(), 0);
        for number in 0..2_000 {
            universe.forget(&mut crowded);
            let mut alone = Memory::default();
            let begin = |memory: &mut Memory| {
                let mut rng = stream(number);
                let mut walk = Walk::begin(&universe, memory, &mut rng);
                for _ in 0..10 {
                    walk.step(&universe, memory, &mut rng)?;
                }
                Some(walk)
            };
            let (Some(one), Some(other)) = (begin(&mut alone), begin(&mut crowded)) else { continue };
            for sibling in 0..4 {
                tale(&universe, other, &mut crowded, &mut stream(1_000_000 + 10 * number + sibling), 50);
            }
            let mine = |walk, memory: &mut Memory| {
                tale(&universe, walk, memory, &mut stream(2_000_000 + number), 50)
            };
            let (a, b) = (mine(one, &mut alone), mine(other, &mut crowded));
            assert_eq!(a, b, "{rung:?}");
            compared += a.len();
        }
        assert!(compared > 2_000, "{rung:?}: {compared}");
    }
}

/// A memory that is cleared while a branch waits takes the layers beyond its own, no more: the branch
/// goes on validly and meets the planes of its own layer again.
#[test]
fn a_cleared_memory_harms_no_branch() {
    for rung in RUNGS {
        let universe = slab(&THREE, HEIGHT, rung, true);
        let mut memory = Memory::default();
        for number in 0..2_000 {
            let mut rng = stream(number);
            universe.forget(&mut memory);
            let mut walk = Walk::begin(&universe, &mut memory, &mut rng);
            for _ in 0..10 {
                if walk.step(&universe, &mut memory, &mut rng).is_none() {
                    break;
                }
            }
            let mut before = walk.place;
            let first = universe.next(&walk.ray, &mut before, &mut memory, f64::INFINITY, &mut rng.clone());
            universe.forget(&mut memory);
            // Others fill the arena anew.
            let other = Walk::begin(&universe, &mut memory, &mut rng.clone());
            tale(&universe, other, &mut memory, &mut stream(3_000_000 + number), 30);
            let then =
                universe.next(&walk.ray, &mut walk.place, &mut memory, f64::INFINITY, &mut rng.clone());
            assert_eq!(first, then);
            while walk.step(&universe, &mut memory, &mut rng).is_some() {}
        }
    }
}
