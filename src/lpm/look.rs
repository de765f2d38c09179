//! Next-event estimation: from every event the power that would go straight to a distant eye, instead of
//! waiting for a ray that happens to leave in its direction.
//!
//! At a subsurface event the eye in direction o gets w p(u·o) e^(−τ) per solid angle, at a Lambertian
//! surface w R cosθ/π e^(−τ): w the power, τ the optical depth along the straight way out, 0 where anything
//! opaque stands in it (J. E. Pritchard & L. L. Carter, LA-5176, 1972: point and ring detectors; here at
//! infinity, so without their 1/r²). Unbiased where a ray meets the outside by such an event alone: equal
//! refractive indices, no mirror (the plan checks it). Light that no event has turned is not seen.

use super::history::{History, Path, Scorer, World};
use super::surface::{Directions, SurfaceLaw};
use crate::math::{DVec3, PI, exp};
use crate::rng::Stream;
use crate::universe::{Interface, Next, Universe};

/// Looks from a subsurface event that ends a flight of `flown` µm, before its new direction is taken.
#[inline(never)]
pub fn from_medium<U: Universe, S: Scorer<N>, const N: usize>(
    world: &World<U, N>,
    path: &Path<U::Place, N>,
    flown: f64,
    h: &mut History<U, N>,
    tally: &mut S,
    rng: &mut Stream,
) {
    let medium = &world.light.media[usize::from(path.medium.0)];
    let mut view = 0;
    while let Some(eye) = tally.eye(view) {
        let mut probe = *path;
        probe.ray.dir = eye;
        let density = medium.phase.pdf(path.ray.dir.dot(eye));
        world.universe.moved(&probe.ray, &mut probe.place, &mut h.memory, flown);
        if let Some(kept) = way_out(world, probe, h, rng) {
            tally.seen(view, &std::array::from_fn(|i| path.power[i] * density * kept[i]));
        }
        view += 1;
    }
}

/// Looks from a Lambertian surface that the ray meets at `at`.
#[inline(never)]
pub fn from_surface<U: Universe, S: Scorer<N>, const N: usize>(
    world: &World<U, N>,
    path: &Path<U::Place, N>,
    at: &Interface,
    law: &SurfaceLaw<N>,
    h: &mut History<U, N>,
    tally: &mut S,
    rng: &mut Stream,
) {
    if !matches!(law.directions, Directions::Lambertian) {
        return;
    }
    let media = &world.light.media;
    let (here, beyond) = (&media[usize::from(path.medium.0)], &media[usize::from(at.beyond.0)]);
    let reflected = law.reflectance(here, beyond, -path.ray.dir.dot(at.normal));
    let mut view = 0;
    while let Some(eye) = tally.eye(view) {
        let cos = eye.dot(at.normal);
        if cos > 0.0 && eye.dot(at.facet) > 0.0 {
            let mut probe = *path;
            probe.ray.dir = eye;
            world.universe.reflected(&probe.ray, &mut probe.place, &mut h.memory, at);
            if let Some(kept) = way_out(world, probe, h, rng) {
                let power = std::array::from_fn(|i| path.power[i] * reflected[i] * cos / PI * kept[i]);
                tally.seen(view, &power);
            }
        }
        view += 1;
    }
}

/// Share that comes straight out of the scene in the direction of `probe`, by lane; `None`: nothing does.
fn way_out<U: Universe, const N: usize>(
    world: &World<U, N>,
    mut probe: Path<U::Place, N>,
    h: &mut History<U, N>,
    rng: &mut Stream,
) -> Option<[f64; N]> {
    let mut depth = [0.0; N];
    for _ in 0..world.event_cap {
        let here = &world.light.media[usize::from(probe.medium.0)];
        let next = world.universe.next(&probe.ray, &mut probe.place, &mut h.memory, f64::INFINITY, rng);
        let distance = match &next {
            Next::Interface(at) => at.distance,
            Next::Edge { distance, .. } => *distance,
            Next::Limit | Next::Lost => return None,
        };
        for (d, mu_a) in depth.iter_mut().zip(&here.mu_a) {
            let rate = mu_a + here.mu_s;
            // A clear medium stays clear, however far.
            *d += if rate > 0.0 { rate * distance } else { 0.0 };
        }
        match &next {
            Next::Interface(at) => {
                let beyond = &world.light.media[usize::from(at.beyond.0)];
                if !world.light.surfaces[usize::from(at.surface.0)].transparent(here, beyond) {
                    return None;
                }
                probe.ray.origin = probe.ray.at(at.distance);
                world.universe.crossed(&mut probe.ray, &mut probe.place, &mut h.memory, at);
                probe.medium = at.beyond;
            }
            _ => return Some(depth.map(|d| exp(-d))),
        }
    }
    None
}

/// A direction from polar angle and azimuth, rad.
pub fn eye(polar: f64, azimuth: f64) -> DVec3 {
    let ((s, c), (sa, ca)) = (crate::math::sin_cos(polar), crate::math::sin_cos(azimuth));
    DVec3::new(s * ca, s * sa, c)
}
