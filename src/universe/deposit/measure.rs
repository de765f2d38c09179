//! What a deposited sheet came to: figures of its structure, measured.

use super::solids::Solids;
use super::{CLEAR, Laid, ellipse};
use crate::math::DVec3;
use crate::rng::{Purpose, Stream};
use crate::universe::shape::integral::ellipse_perimeter;

/// Structure of a realisation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Mean thickness ([`Laid::thickness`]), µm.
    pub thickness: f64,
    /// Height of the highest point over the forming plane: between flat plates, µm.
    pub between_plates: f64,
    /// Volume of fibre walls and particles over area, µm.
    pub solid: f64,
    /// Volume of whole bodies, lumens included, over area, µm.
    pub body: f64,
    /// Share of the mean thickness that is not solid: pores and lumens.
    pub porosity: f64,
    /// Surface of solids, lumens' included, over cell area and mean thickness, 1/µm.
    pub surface: f64,
    /// Share of the fibres' outer surface with another body within the gap: relative bonded area.
    pub bonded: f64,
    /// Volume in more than one body over the volume in any, by sampling.
    pub overlap: f64,
    /// Largest change of slope along a fibre, from piece to piece, rad.
    pub sharpest: f64,
    /// Mean layers of fibre over a point: coverage.
    pub coverage: f64,
    /// Share of the cell over which something lies.
    pub covered: f64,
    /// Pieces of fibres.
    pub pieces: usize,
}

/// Points by which overlaps and bonds are measured.
const SAMPLES: u32 = 400_000;

impl Laid {
    /// Measures the sheet; `gap` is the distance within which surfaces count as bonded, µm.
    pub fn figures(&self, gap: f64) -> Figures {
        let area = self.cell * self.cell;
        let (mut solid, mut body, mut surface, mut shadow) = (0.0, 0.0, 0.0, 0.0);
        for f in &self.fibres {
            let (a, b) = f.outer;
            solid += 2.0 * f.half * f.wall_area();
            body += 2.0 * f.half * ellipse(a, b);
            surface += 2.0 * f.wall_area() + f.pieces(f.outer).map(|p| p.side_area()).sum::<f64>();
            surface += f.lumen.map_or(0.0, |l| f.pieces(l).map(|p| p.side_area()).sum());
            shadow += 4.0 * f.half * a;
        }
        for p in &self.particles {
            solid += p.volume();
            body += p.volume();
            surface += surface_of(p);
        }
        let solids = self.index();
        Figures {
            thickness: self.thickness,
            between_plates: self.top - CLEAR,
            solid: solid / area,
            body: body / area,
            porosity: 1.0 - solid / area / self.thickness,
            surface: surface / area / self.thickness,
            bonded: self.bonded(&solids, gap),
            overlap: self.overlap(&solids),
            sharpest: self.fibres.iter().map(|f| f.sharpest()).fold(0.0, f64::max),
            coverage: shadow / area,
            covered: self.covered,
            pieces: self.fibres.iter().map(|f| f.knots.len() - 1).sum(),
        }
    }

    /// Adds the volume of solid over area of each kind, µm.
    pub(super) fn solids(&self, by_kind: &mut [f64]) {
        let area = self.cell * self.cell;
        self.fibres.iter().for_each(|f| by_kind[f.kind] += 2.0 * f.half * f.wall_area() / area);
        self.particles.iter().for_each(|p| by_kind[p.kind] += p.volume() / area);
    }

    fn index(&self) -> Solids {
        let mut solids = Solids::new(self.cell, &self.fibres);
        for (i, p) in self.particles.iter().enumerate() {
            solids.add((self.fibres.len() + i) as u32, p.body.centre, p.radius());
        }
        solids
    }

    fn overlap(&self, solids: &Solids) -> f64 {
        let mut rng = Stream::of(1, 0, 0, Purpose::Probe);
        let (mut any, mut several, mut found) = (0_u32, 0_u32, Vec::new());
        for _ in 0..SAMPLES {
            let p =
                DVec3::new(self.cell * rng.uniform(), self.cell * rng.uniform(), self.top * rng.uniform());
            solids.holding(&self.fibres, &self.particles, p, &mut found);
            any += u32::from(!found.is_empty());
            several += u32::from(found.len() > 1);
        }
        f64::from(several) / f64::from(any.max(1))
    }

    /// By points spread evenly over the fibres' outer sides (lengths by stratified places along all of
    /// them), each moved out by the gap.
    fn bonded(&self, solids: &Solids, gap: f64) -> f64 {
        let mut rng = Stream::of(2, 0, 0, Purpose::Probe);
        let perimeter = |a: f64, b: f64| ellipse_perimeter(a, b);
        let total: f64 = self.fibres.iter().map(|f| 2.0 * f.half * perimeter(f.outer.0, f.outer.1)).sum();
        let (mut near, mut count, mut found) = (0_u32, 0_u32, Vec::new());
        for (number, f) in (0..).zip(&self.fibres) {
            let (a, b) = f.outer;
            let share = 2.0 * f.half * perimeter(a, b) / total * f64::from(SAMPLES);
            for _ in 0..(share + rng.uniform()) as u32 {
                // Uniform over the perimeter: rejection against the longest element of arc, max(a, b) dθ.
                let (s, c) = loop {
                    let (c, s) = rng.azimuth();
                    let arc = (a * a * s * s + b * b * c * c).sqrt();
                    if rng.uniform() * a.max(b) < arc {
                        break (s, c);
                    }
                };
                let z = f.half * (2.0 * rng.uniform() - 1.0);
                let k = f.knots.partition_point(|k| k.0 <= z).clamp(1, f.knots.len() - 1);
                let (p, q) = (f.knots[k - 1], f.knots[k]);
                let slope = (q.1 - p.1) / (q.0 - p.0);
                let normal = DVec3::new(c / a, s / b, -slope * s / b).normalize();
                let at = DVec3::new(a * c, p.1 + slope * (z - p.0) + b * s, z) + normal * gap;
                let world = f.centre + f.frame.to_world(at);
                solids.holding(&self.fibres, &self.particles, world, &mut found);
                near += u32::from(found.iter().any(|&other| other != number));
                count += 1;
            }
        }
        f64::from(near) / f64::from(count.max(1))
    }
}

/// Surface of a particle, µm²: by Thomsen's formula within 1.1 %.
fn surface_of(p: &super::Particle) -> f64 {
    use crate::math::{PI, pow};
    let o = &p.body.outer;
    if o.c.is_infinite() {
        return 2.0 * PI * o.a * (o.a + 2.0 * p.body.ends);
    }
    let power = |x: f64| pow(x, 1.6075);
    4.0 * PI * pow((power(o.a * o.b) + power(o.b * o.c) + power(o.c * o.a)) / 3.0, 1.0 / 1.6075)
}
