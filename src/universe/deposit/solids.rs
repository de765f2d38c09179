//! Which bodies may hold a point: lists of pieces over a lateral grid.

use super::{Fibre, Particle};
use crate::math::DVec3;
use crate::universe::shape::{Convex, SlantedCylinder};

/// Edge of a cell of the grid, µm, about.
const PITCH: f64 = 8.0;

/// A piece of a fibre, or a particle, as one periodic image of it.
#[derive(Clone, Copy)]
struct Item {
    body: u32,
    /// Number of the piece; none: a particle.
    piece: u32,
    /// What is added to a point of the cell to come to the original, in periods.
    shift: [i16; 2],
}

const PARTICLE: u32 = u32::MAX;

/// Bodies over a lateral grid of the periodic cell; fibres first, then particles, numbered through.
pub(super) struct Solids {
    cell: f64,
    n: i64,
    pitch: f64,
    lists: Vec<Vec<Item>>,
    fibres: usize,
}

impl Solids {
    pub fn new(cell: f64, fibres: &[Fibre]) -> Self {
        let n = (cell / PITCH).ceil().max(1.0);
        let lists = vec![Vec::new(); (n * n) as usize];
        let mut solids = Solids { cell, n: n as i64, pitch: cell / n, lists, fibres: fibres.len() };
        for (body, f) in (0..).zip(fibres) {
            for (piece, k) in (0..).zip(f.knots.windows(2)) {
                let at = |z: f64| f.centre + f.frame.z * z;
                let wide = f.frame.x.abs() * f.outer.0;
                let (p, q) = (at(k[0].0), at(k[1].0));
                solids.list(body, piece, p.min(q) - wide, p.max(q) + wide);
            }
        }
        solids
    }

    /// Adds a particle about `centre` (number `body` of all).
    pub fn add(&mut self, body: u32, centre: DVec3, radius: f64) {
        self.list(body, PARTICLE, centre - DVec3::splat(radius), centre + DVec3::splat(radius));
    }

    fn list(&mut self, body: u32, piece: u32, lo: DVec3, hi: DVec3) {
        let number = |x: f64| (x / self.pitch).floor() as i64;
        for j in number(lo.y)..=number(hi.y) {
            for i in number(lo.x)..=number(hi.x) {
                let shift = [i.div_euclid(self.n) as i16, j.div_euclid(self.n) as i16];
                let cell = j.rem_euclid(self.n) * self.n + i.rem_euclid(self.n);
                self.lists[cell as usize].push(Item { body, piece, shift });
            }
        }
    }

    /// Bodies that hold the point (lumens count as body), each once.
    pub fn holding(&self, fibres: &[Fibre], particles: &[Particle], p: DVec3, found: &mut Vec<u32>) {
        found.clear();
        let home = |x: f64| x.rem_euclid(self.cell).min(self.cell * (1.0 - 1e-15));
        let q = DVec3::new(home(p.x), home(p.y), p.z);
        let number = |x: f64| ((x / self.pitch) as i64).min(self.n - 1);
        for item in &self.lists[(number(q.y) * self.n + number(q.x)) as usize] {
            let shift = DVec3::new(f64::from(item.shift[0]), f64::from(item.shift[1]), 0.0) * self.cell;
            let holds = if item.piece == PARTICLE {
                particles[item.body as usize - self.fibres].holds(q + shift)
            } else {
                let f = &fibres[item.body as usize];
                let k = &f.knots[item.piece as usize..item.piece as usize + 2];
                let piece = SlantedCylinder::between(f.outer.0, f.outer.1, k[0], k[1]);
                piece.contains(f.frame.to_local(q + shift - f.centre))
            };
            if holds && !found.contains(&item.body) {
                found.push(item.body);
            }
        }
    }
}
