//! Layers of realised bodies on top of each other, with faces that may have a surface.
//!
//! Each layer is a [`Drum`] between two planes, or a homogeneous slab; layers are independent of each other,
//! and a history meets all of them at the same displacement. Planes are what they are in the statistical
//! universe: bodies end at them (`cut`) or stay clear of them (`contained`), and a ray that reaches an inner
//! plane meets an interface with the layer's surface law, whatever it is in; beyond it is what the
//! neighbouring layer has at that point.

use super::drum::{Drum, Entry, Grown};
use super::place::{Displaced, MOST_TRIES};
use super::realise::{Boolean, RealiseError};
use crate::math::DVec3;
use crate::rng::Stream;
use crate::universe::sheet::{Room, Slab, plane_ahead};
use crate::universe::statistical::plane_interface;
use crate::universe::{Face, Interface, MediumId, Next, Ray, Start, SurfaceId, Universe};

/// A layer: its planes and medium, and the Boolean population between them, if there is one.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Planes, medium and law of the upper plane.
    pub slab: Slab,
    /// Bodies; `None`: homogeneous.
    pub bodies: Option<Boolean>,
}

/// What surrounds the layers.
#[derive(Clone, Copy, Debug)]
pub struct Faces {
    /// Medium above and below.
    pub outside: MediumId,
    /// Law of the lowest plane.
    pub bottom_surface: SurfaceId,
    /// The upper and the lower face have no surface: rays just leave.
    pub open: [bool; 2],
}

#[derive(Clone, Debug)]
struct Storey {
    slab: Slab,
    drum: Option<Drum>,
}

/// Realised layers, top to bottom.
#[derive(Clone, Debug)]
pub struct Stack {
    storeys: Vec<Storey>,
    faces: Faces,
    spread: f64,
    from_pores: bool,
    print: u64,
}

/// Bodies generated so far, layer by layer.
#[derive(Default, Debug)]
pub struct Floors {
    /// Print of the stack and number of the realisation.
    of: Option<[u64; 2]>,
    grown: Vec<Grown>,
}

/// Where a ray is in a [`Stack`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Storeyed {
    layer: u16,
    outside: Option<Face>,
    here: Displaced,
    /// The plane that lies ahead, and what is behind it.
    ahead: Option<(Face, Displaced)>,
}

/// Seed of the layer `number`: the same kinds in two layers must not stand above each other.
pub fn seed_of(seed: u64, number: usize) -> u64 {
    seed.wrapping_add((number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

impl Stack {
    /// All realisations of the layers (at least one, top to bottom).
    ///
    /// # Errors
    /// [`RealiseError`] where a population cannot be realised.
    pub fn ensemble(layers: &[Layer], faces: Faces, seed: u64, entry: Entry) -> Result<Self, RealiseError> {
        let mut storeys = Vec::new();
        for (i, layer) in layers.iter().enumerate() {
            let drum =
                layer.bodies.as_ref().map(|b| Drum::ensemble(b, seed_of(seed, i), entry)).transpose()?;
            storeys.push(Storey { slab: layer.slab, drum });
        }
        let drums = || storeys.iter().filter_map(|s| s.drum.as_ref());
        let spread = drums().map(Drum::spread).fold(0.0, f64::max);
        let print = drums().fold(storeys.len() as u64, |p, d| p.rotate_left(7) ^ d.print());
        Ok(Stack { spread, print, storeys, faces, from_pores: entry.from_pores })
    }

    /// Planes, medium and realisations of the layers, top to bottom.
    pub fn layers(&self) -> impl Iterator<Item = (Slab, Option<&Drum>)> {
        self.storeys.iter().map(|s| (s.slab, s.drum.as_ref()))
    }

    fn last(&self) -> usize {
        self.storeys.len() - 1
    }

    /// What a ray at a point of layer `layer` is in, and the medium there.
    fn stand(&self, layer: usize, ray: &Ray, shift: DVec3, m: &mut Floors) -> Start<Displaced> {
        let Storey { slab, drum } = &self.storeys[layer];
        match drum {
            Some(drum) => drum.stand(ray, shift, &mut m.grown[layer]),
            None => Start { place: Displaced { shift, ..Displaced::default() }, medium: slab.pore },
        }
    }

    /// The plane that a ray inside a layer has reached.
    fn plane(&self, face: Face, distance: f64, ray: &Ray, p: &mut Storeyed, m: &mut Floors) -> Next {
        let layer = usize::from(p.layer);
        let (last, open, normal) = match face {
            Face::Top => (layer == 0, self.faces.open[0], -DVec3::Z),
            Face::Bottom => (layer == self.last(), self.faces.open[1], DVec3::Z),
        };
        // A cut face has no surface inside a body.
        if last && (open || p.here.covered_ahead()) {
            return Next::Edge { face, distance };
        }
        let (surface, next) = match face {
            Face::Top => (self.storeys[layer].slab.surface, layer.wrapping_sub(1)),
            Face::Bottom if last => (self.faces.bottom_surface, layer),
            Face::Bottom => (self.storeys[layer + 1].slab.surface, layer + 1),
        };
        let behind = if last {
            Start { place: p.here, medium: self.faces.outside }
        } else {
            let there = Ray { origin: ray.at(distance), dir: ray.dir };
            self.stand(next, &there, p.here.shift, m)
        };
        p.ahead = Some((face, behind.place));
        Next::Interface(plane_interface(distance, normal, behind.medium, surface))
    }

    /// From outside, the face is met at once, or never.
    fn face_ahead(&self, face: Face, ray: &Ray, p: &mut Storeyed, m: &mut Floors) -> Next {
        let (inwards, surface, normal) = match face {
            Face::Top => (ray.dir.z < 0.0, self.storeys[0].slab.surface, DVec3::Z),
            Face::Bottom => (ray.dir.z > 0.0, self.faces.bottom_surface, -DVec3::Z),
        };
        if !inwards {
            return Next::Edge { face, distance: 0.0 };
        }
        let behind = self.stand(usize::from(p.layer), ray, p.here.shift, m);
        p.ahead = Some((face, behind.place));
        Next::Interface(plane_interface(0.0, normal, behind.medium, surface))
    }

    fn hold(&self, m: &mut Floors, realisation: u64) {
        m.of = Some([self.print, realisation]);
        m.grown.resize_with(self.storeys.len(), Grown::default);
        for (storey, grown) in self.storeys.iter().zip(&mut m.grown) {
            if let Some(drum) = &storey.drum {
                drum.hold(grown, realisation);
            }
        }
    }
}

impl Universe for Stack {
    type Memory = Floors;
    type Place = Storeyed;

    fn forget(&self, m: &mut Floors) {
        m.of = None;
    }

    fn share(&self, _: &mut Floors) {}

    fn enter(&self, ray: &Ray, m: &mut Floors, rng: &mut Stream) -> Start<Storeyed> {
        let held = m.of.filter(|of| of[0] == self.print).map(|of| of[1]);
        let realisation = held.unwrap_or_else(|| rng.bits());
        self.hold(m, realisation);
        let (face, layer, open) = match ray.dir.z <= 0.0 {
            true => (Face::Top, 0, self.faces.open[0]),
            false => (Face::Bottom, self.last(), self.faces.open[1]),
        };
        let mut tries = 0;
        let start = loop {
            let mut away = || if self.spread > 0.0 { 2.0 * rng.uniform() - 1.0 } else { 0.0 };
            let shift = DVec3::new(away(), away(), 0.0) * self.spread;
            let start = self.stand(layer, ray, shift, m);
            if !self.from_pores || start.place.in_pore() || tries == MOST_TRIES {
                break start;
            }
            tries += 1;
        };
        let place = Storeyed {
            layer: layer as u16,
            outside: (!open).then_some(face),
            here: start.place,
            ahead: None,
        };
        Start { place, medium: if open { start.medium } else { self.faces.outside } }
    }

    fn come_back(&self, ray: &Ray, place: &Storeyed, m: &mut Floors, _: &mut Stream) -> Start<Storeyed> {
        let start = self.stand(usize::from(place.layer), ray, place.here.shift, m);
        Start { place: Storeyed { here: start.place, ahead: None, ..*place }, medium: start.medium }
    }

    fn room(&self, place: &Storeyed) -> Room {
        let Storey { slab, drum } = &self.storeys[usize::from(place.layer)];
        match (place.outside, drum) {
            (None, None) => Room { top: slab.top, bottom: slab.bottom },
            _ => Room::NONE,
        }
    }

    fn next(&self, ray: &Ray, p: &mut Storeyed, m: &mut Floors, limit: f64, rng: &mut Stream) -> Next {
        if let Some(face) = p.outside {
            return self.face_ahead(face, ray, p, m);
        }
        p.ahead = None;
        let layer = usize::from(p.layer);
        let Storey { slab, drum } = &self.storeys[layer];
        let next = match drum {
            Some(drum) => drum.next(ray, &mut p.here, &mut m.grown[layer], limit, rng),
            None => match plane_ahead(ray, slab.top, slab.bottom) {
                (distance, face) if distance <= limit && distance < f64::INFINITY => {
                    Next::Edge { face, distance }
                }
                _ if limit < f64::INFINITY => Next::Limit,
                _ => Next::Lost,
            },
        };
        match next {
            Next::Edge { face, distance } => self.plane(face, distance, ray, p, m),
            other => other,
        }
    }

    fn moved(&self, ray: &Ray, p: &mut Storeyed, m: &mut Floors, d: f64) {
        p.ahead = None;
        let layer = usize::from(p.layer);
        if let Some(drum) = &self.storeys[layer].drum {
            drum.moved(ray, &mut p.here, &mut m.grown[layer], d);
        }
    }

    fn reflected(&self, ray: &Ray, p: &mut Storeyed, m: &mut Floors, at: &Interface) {
        let layer = usize::from(p.layer);
        let Some(drum) = &self.storeys[layer].drum else {
            p.ahead = None;
            return;
        };
        match p.ahead.take() {
            Some(_) if p.outside.is_some() => {}
            // As far as the plane the ray has moved as any ray does.
            Some(_) => drum.moved(ray, &mut p.here, &mut m.grown[layer], at.distance),
            None => drum.reflected(ray, &mut p.here, &mut m.grown[layer], at),
        }
    }

    fn crossed(&self, ray: &mut Ray, p: &mut Storeyed, m: &mut Floors, at: &Interface) {
        let layer = usize::from(p.layer);
        match p.ahead.take() {
            Some((face, behind)) => {
                p.here = behind;
                if p.outside.take().is_some() {
                    return;
                }
                match face {
                    Face::Top if layer == 0 => p.outside = Some(face),
                    Face::Bottom if layer == self.last() => p.outside = Some(face),
                    Face::Top => p.layer -= 1,
                    Face::Bottom => p.layer += 1,
                }
            }
            None => {
                if let Some(drum) = &self.storeys[layer].drum {
                    drum.crossed(ray, &mut p.here, &mut m.grown[layer], at);
                }
            }
        }
    }
}
