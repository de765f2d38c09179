//! The voxel universe: convergence to explicit bodies, normals, walks that lose no ray, files.
#![allow(clippy::disallowed_methods, missing_docs)]

#[path = "walking/mod.rs"]
#[allow(dead_code)]
mod walking;
#[path = "voxel_universe/convergence.rs"]
mod convergence;
#[path = "voxel_universe/example.rs"]
mod example;
#[path = "voxel_universe/files.rs"]
mod files;
#[path = "voxel_universe/normals.rs"]
mod normals;
#[path = "voxel_universe/walks.rs"]
mod walks;

use lightpro::material::fresnel;
use lightpro::math::{DVec3, TAU};
use lightpro::rng::{Purpose, Stream};
use lightpro::universe::voxel::{Lateral, NormalRule, Phase, Rules, Steps, Volume, VoxelUniverse};
use lightpro::universe::{Interface, MediumId, Next, Ray, SurfaceId, Universe};
pub use walking::isotropic;

pub const AIR: MediumId = MediumId(0);

pub fn stream(history: u64) -> Stream {
    Stream::of(815, 0, history, Purpose::Probe)
}

/// Media 0, 1, 2 …, all smooth.
pub fn phases(n: u16) -> Vec<Phase> {
    (0..n).map(|m| Phase { medium: MediumId(m), surface: SurfaceId::SMOOTH }).collect()
}

pub fn rules(edge: f64) -> Rules {
    Rules {
        edge: [edge; 3],
        lateral: Lateral::Mirror,
        normals: NormalRule::Smoothed(2.0),
        steps: Steps::Passed,
        anywhere: false,
        outside: AIR,
    }
}

/// Voxels of a body: phase of each voxel's centre (µm, x = y = 0 in the middle, z from the bottom).
pub fn voxelised(cells: [usize; 3], edge: f64, mut phase: impl FnMut(DVec3) -> u8) -> Volume {
    let mut out = Vec::with_capacity(cells.iter().product());
    for z in 0..cells[2] {
        for y in 0..cells[1] {
            for x in 0..cells[0] {
                let c = |i: usize, n: usize| (i as f64 + 0.5 - 0.5 * n as f64) * edge;
                let p = DVec3::new(c(x, cells[0]), c(y, cells[1]), (z as f64 + 0.5) * edge);
                out.push(phase(p));
            }
        }
    }
    Volume::of(cells, &out).unwrap()
}

/// Light at an interface between smooth dielectrics: the new direction, and whether it goes across.
/// Directions on the wrong side of the facet are mirrored, as everywhere.
pub fn fresnel_event(dir: DVec3, at: &Interface, n1: f64, n2: f64, s: &mut Stream) -> (DVec3, bool) {
    let cos = (-dir.dot(at.normal)).clamp(0.0, 1.0);
    let d = fresnel::dielectric(n1, n2, cos);
    let side = |u: DVec3, f: DVec3| {
        let c = u.dot(f);
        if c < 0.0 { u - f * (2.0 * c) } else { u }
    };
    if d.r >= 1.0 || s.uniform() < d.r {
        (side(fresnel::reflect(dir, at.normal), at.facet).normalize(), false)
    } else {
        let u = fresnel::refract(dir, at.normal, cos, d.cos_t, n2 / n1);
        (side(u, -at.facet).normalize(), true)
    }
}

/// How a ray left: its direction, its path in media above 0, its interfaces. `None`: lost, or caught
/// for 2000 events.
pub struct Left {
    pub dir: DVec3,
    pub inside: f64,
    pub events: u32,
}

/// Follows a ray until it is `limit(ray)` away from where `limit` is 0 or less.
pub fn follow<U: Universe>(
    u: &U,
    mut ray: Ray,
    memory: &mut U::Memory,
    index: &[f64],
    limit: impl Fn(&Ray) -> f64,
    s: &mut Stream,
) -> Option<Left> {
    u.forget(memory);
    let start = u.enter(&ray, memory, s);
    let (mut place, mut medium) = (start.place, start.medium);
    let mut inside = 0.0;
    for events in 0..2000 {
        let end = limit(&ray);
        match u.next(&ray, &mut place, memory, end, s) {
            Next::Interface(at) => {
                inside += if medium == AIR { 0.0 } else { at.distance };
                let (n1, n2) = (index[usize::from(medium.0)], index[usize::from(at.beyond.0)]);
                let origin = ray.at(at.distance);
                let (dir, crosses) = fresnel_event(ray.dir, &at, n1, n2, s);
                ray = Ray { origin, dir };
                if crosses {
                    u.crossed(&mut ray, &mut place, memory, &at);
                    medium = at.beyond;
                } else {
                    u.reflected(&ray, &mut place, memory, &at);
                }
            }
            Next::Limit | Next::Edge { .. } => return Some(Left { dir: ray.dir, inside, events }),
            Next::Lost => return None,
        }
    }
    None
}
