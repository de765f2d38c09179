//! Fillers in the pores that the fibres leave: random sequential addition.

use super::ground::Ground;
use super::solids::Solids;
use super::{CLEAR, Deposit, Laid};
use crate::math::{DVec3, TAU, sin_cos};
use crate::rng::{Purpose, Stream};
use crate::universe::statistical::kind::Kind;
use crate::universe::statistical::section::Body;
use crate::universe::synthetic::Part;
use crate::universe::synthetic::realise::parts_of;

/// A filler particle in its place.
#[derive(Clone, Copy, Debug)]
pub struct Particle {
    /// Kind.
    pub kind: usize,
    /// Shape and place.
    pub body: Body,
}

/// Places tried for a particle before it is left out.
const TRIES: u32 = 400;
/// Particles in succession that find no place: then the pores are full.
const FULL: u32 = 50;
/// Points over a particle's surface that must lie in pores.
const POINTS: usize = 96;

impl Particle {
    /// Its regions.
    pub(super) fn parts(&self, kind: &Kind) -> impl Iterator<Item = Part> + use<> {
        parts_of(kind, &self.body)
    }

    /// Distance from the centre that nothing of it exceeds, µm.
    pub fn radius(&self) -> f64 {
        let o = &self.body.outer;
        if o.c.is_finite() {
            o.a.max(o.b).max(o.c)
        } else {
            (o.a * o.a + self.body.ends * self.body.ends).sqrt()
        }
    }

    /// Whether it holds a point.
    pub fn holds(&self, p: DVec3) -> bool {
        let (o, l) = (&self.body.outer, self.body.frame.to_local(p - self.body.centre));
        let (x, y) = (l.x / o.a, l.y / o.b);
        if o.c.is_finite() {
            let z = l.z / o.c;
            x * x + y * y + z * z <= 1.0
        } else {
            x * x + y * y <= 1.0 && l.z.abs() <= self.body.ends
        }
    }

    /// Volume, µm³.
    pub fn volume(&self) -> f64 {
        self.body.outer.content() * if self.body.ends.is_finite() { 2.0 * self.body.ends } else { 1.0 }
    }

    /// A point of the surface, enlarged by 2 %, for a unit vector.
    fn surface(&self, u: DVec3) -> DVec3 {
        let o = &self.body.outer;
        let local = if o.c.is_finite() {
            DVec3::new(o.a * u.x, o.b * u.y, o.c * u.z)
        } else {
            // The unit sphere moved onto the disc's faces and rim.
            let r = (u.x * u.x + u.y * u.y).sqrt().max(1e-12);
            let out = (1.5 * (1.0 - u.z.abs()).max(0.0)).sqrt().min(1.0);
            let up = if u.z.abs() < 1.0 / 3.0 { 3.0 * u.z } else { u.z.signum() };
            DVec3::new(o.a * out * u.x / r, o.b * out * u.y / r, self.body.ends * up)
        };
        self.body.centre + self.body.frame.to_world(local * 1.02)
    }
}

/// Evenly spread unit vectors (a Fibonacci lattice).
fn even() -> Vec<DVec3> {
    let turn = |i: usize| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / POINTS as f64;
        let (s, c) = sin_cos(TAU * (0.618_033_988_749_895 * i as f64).fract());
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * c, r * s, z)
    };
    (0..POINTS).map(turn).collect()
}

/// Puts the particles of all kinds into the pores of `sheet`; what finds no place stays out, and out of
/// `laid`.
pub(super) fn fill(model: &Deposit, ground: &Ground, sheet: &mut Laid, seed: u64, realisation: u64) {
    let points = even();
    let kinds: Vec<usize> = (0..model.kinds.len()).filter(|&i| !model.kinds[i].is_fibre()).collect();
    if kinds.iter().all(|&i| model.amounts[i].wanted() == 0.0) {
        return;
    }
    let mut solids = Solids::new(sheet.cell, &sheet.fibres);
    let mut found = Vec::new();
    for i in kinds {
        let mut rng = Stream::of(seed, realisation, i as u64, Purpose::Realisation);
        let (mut left_out, area) = (0.0, sheet.cell * sheet.cell);
        let (top, mut failed) = (sheet.top, 0);
        let all = model.draw(i, &mut rng, |body, rng| {
            let mut particle = Particle { kind: i, body };
            let radius = particle.radius();
            let tries = if failed < FULL { TRIES } else { 0 };
            for _ in 0..tries {
                let (x, y) = (sheet.cell * rng.uniform(), sheet.cell * rng.uniform());
                let z = CLEAR + radius + (top - CLEAR - 2.0 * radius).max(0.0) * rng.uniform();
                // In the sheet: between its lowest and its uppermost fibre there.
                if !ground.column(x, y).is_some_and(|(_, up)| z < up) {
                    continue;
                }
                particle.body.centre = DVec3::new(x, y, z);
                let mut clear = |p: DVec3| {
                    solids.holding(&sheet.fibres, &sheet.particles, p, &mut found);
                    found.is_empty()
                };
                if clear(particle.body.centre) && points.iter().all(|u| clear(particle.surface(*u))) {
                    let number = (sheet.fibres.len() + sheet.particles.len()) as u32;
                    solids.add(number, particle.body.centre, radius);
                    sheet.particles.push(particle);
                    failed = 0;
                    return;
                }
            }
            failed += 1;
            left_out += super::measure_of(model.amounts[i], &model.kinds[i], &particle.body);
        });
        sheet.laid[i] = all.laid - left_out / area;
    }
}
