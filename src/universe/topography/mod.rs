//! Explicit bodies cut off by measured surfaces: a sheet with its topography.
//!
//! Above (or below) the bodies of a [`SyntheticUniverse`] stands a surface z = h(x, y), a
//! [`HeightMap`]. On its far side there is nothing but the medium outside; on its near side the bodies are
//! what they are without it. Where a ray meets the surface, the medium beyond is that of the bodies at that
//! point: a coating (a slab that reaches above the highest peak), the wall of a fibre that is cut there, a
//! pore. Where nothing changes there is nothing to be seen, and light goes straight on.
//!
//! Which side a ray is on is its **state** and never asked of a point again, so rounding cannot move a ray
//! through the surface.

pub mod file;

use super::shape::height::{Ahead, HeightMap, Meeting};
use super::synthetic::{Place, SyntheticUniverse};
use super::{BodyId, Face, Interface, MediumId, Next, Ray, Start, SurfaceId, Universe, against};
use crate::math::DVec3;
use crate::rng::Stream;
use std::sync::Arc;

/// A surface that cuts the bodies off.
#[derive(Clone, Debug)]
pub struct Skin {
    /// Heights, µm.
    pub map: Arc<HeightMap>,
    /// Law of the surface.
    pub surface: SurfaceId,
}

/// Surfaces that no universe can be made of.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// No surface at all.
    #[error("a topography has a surface on top, or at the bottom, or both")]
    Nothing,
    /// Surfaces that do not repeat together.
    #[error("the upper surface repeats every {} x {} um, the lower one every {} x {} um", .0[0], .0[1], .1[0], .1[1])]
    Sides([f64; 2], [f64; 2]),
    /// A surface and bodies that do not repeat together.
    #[error("the surface repeats every {} x {} um, the cell every {} x {} um", .0[0], .0[1], .1[0], .1[1])]
    Period([f64; 2], [f64; 2]),
    /// A surface that reaches beyond the planes of the cell.
    #[error("the surface from {} to {} um leaves the cell from {} to {} um", .0[0], .0[1], .1[0], .1[1])]
    Planes([f64; 2], [f64; 2]),
    /// The surfaces cut each other.
    #[error("the lower surface reaches up to {1} um, the upper one down to {0} um")]
    Cross(f64, f64),
}

/// Whether surfaces on top and at the bottom fit each other and the cell of the bodies, if there is one: its
/// periods, and its lower and upper plane, µm.
///
/// # Errors
/// What does not fit.
pub fn agree(skins: &[Option<Skin>; 2], cell: Option<([f64; 2], [f64; 2])>) -> Result<(), Error> {
    // Within rounding.
    let together = |a: [f64; 2], b: [f64; 2]| (0..2).all(|k| (a[k] - b[k]).abs() <= 1e-9 * a[k]);
    for (map, (period, planes)) in skins.iter().flatten().map(|s| &s.map).zip(cell.into_iter().cycle()) {
        if !together(map.period(), period) {
            return Err(Error::Period(map.period(), period));
        }
        if map.range()[0] <= planes[0] || map.range()[1] > planes[1] {
            return Err(Error::Planes(map.range(), planes));
        }
    }
    match skins {
        [None, None] => Err(Error::Nothing),
        [Some(top), Some(bottom)] if !together(top.map.period(), bottom.map.period()) => {
            Err(Error::Sides(top.map.period(), bottom.map.period()))
        }
        [Some(top), Some(bottom)] if top.map.range()[0] <= bottom.map.range()[1] => {
            Err(Error::Cross(top.map.range()[0], bottom.map.range()[1]))
        }
        _ => Ok(()),
    }
}

/// Bodies between measured surfaces.
#[derive(Clone, Debug)]
pub struct Topography {
    bodies: SyntheticUniverse,
    /// By [`Face`]: top, bottom.
    skins: [Option<Skin>; 2],
    /// Upper and lower plane of a sheet, where rays leave.
    planes: Option<[f64; 2]>,
    anywhere: bool,
}

/// On which side of the surfaces a ray is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Zone {
    #[default]
    Within,
    Beyond(Face),
}

/// Where a ray is in a [`Topography`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Carved {
    zone: Zone,
    /// Among the bodies, where the ray is within.
    here: Place,
    /// The surface that the ray starts on.
    left: Option<Face>,
    /// The surface that lies ahead, and what is behind it.
    ahead: Option<(Face, Place)>,
    /// From where the ray seems to be to where it is among the bodies, µm.
    shift: DVec3,
}

impl Topography {
    /// `bodies` below the surface `top` and above the surface `bottom` (at least one of them). `anywhere`:
    /// each history finds all of it displaced sideways by chance, so that light falls evenly on the surface;
    /// bodies then have to be the same everywhere, or to repeat themselves with it.
    ///
    /// # Errors
    /// [`Error`]: see [`agree`].
    pub fn new(
        bodies: SyntheticUniverse,
        top: Option<Skin>,
        bottom: Option<Skin>,
        anywhere: bool,
    ) -> Result<Self, Error> {
        let skins = [top, bottom];
        agree(&skins, Some(bodies.period()).filter(|p| p[0] > 0.0).zip(bodies.sheet()))?;
        let planes = bodies.sheet().map(|[bottom, top]| [top, bottom]);
        Ok(Topography { bodies, skins, planes, anywhere })
    }

    /// The bodies, as they are without the surfaces.
    pub fn bodies(&self) -> &SyntheticUniverse {
        &self.bodies
    }

    /// The surface on a side.
    pub fn skin(&self, face: Face) -> Option<&Skin> {
        self.skins[face as usize].as_ref()
    }

    /// Periods along x and y, µm.
    pub fn period(&self) -> [f64; 2] {
        self.skins.iter().flatten().next().map_or([0.0; 2], |s| s.map.period())
    }

    /// Whether each history finds it displaced by chance.
    pub fn anywhere(&self) -> bool {
        self.anywhere
    }

    /// The same, standing still.
    pub fn still(&self) -> Self {
        Topography { anywhere: false, ..self.clone() }
    }

    /// Whether a point lies between the surfaces.
    pub fn holds(&self, point: DVec3) -> bool {
        let beyond = |face: Face| {
            self.skin(face).is_some_and(|s| {
                let h = s.map.height(point.x, point.y);
                if face == Face::Top { point.z > h } else { point.z < h }
            })
        };
        !beyond(Face::Top) && !beyond(Face::Bottom)
    }

    /// Medium at a point: for checks and pictures.
    pub fn medium_at(&self, point: DVec3) -> MediumId {
        if self.holds(point) { self.bodies.medium_at(point) } else { self.bodies.ambient() }
    }

    /// Medium that a ray is in.
    pub fn medium(&self, place: &Carved) -> MediumId {
        match place.zone {
            Zone::Within => self.bodies.medium(&place.here),
            Zone::Beyond(_) => self.bodies.ambient(),
        }
    }

    /// On which side a ray starts: exactly on the surface it is still beyond if it goes in.
    fn zone(&self, ray: &Ray) -> Zone {
        let beyond = |face: Face, way: f64| {
            self.skin(face).is_some_and(|s| {
                let over = way * (ray.origin.z - s.map.height(ray.origin.x, ray.origin.y));
                over > 0.0 || (over == 0.0 && way * ray.dir.z <= 0.0)
            })
        };
        if beyond(Face::Top, 1.0) {
            Zone::Beyond(Face::Top)
        } else if beyond(Face::Bottom, -1.0) {
            Zone::Beyond(Face::Bottom)
        } else {
            Zone::Within
        }
    }

    /// The surface on a side, as met by a ray `beyond` it or within, up to `reach`.
    fn meet(&self, face: Face, beyond: bool, ray: &Ray, place: &Carved, reach: f64) -> Ahead {
        match self.skin(face) {
            Some(s) => s.map.ahead(ray, beyond == (face == Face::Top), place.left == Some(face), reach),
            None => Ahead::Free,
        }
    }

    fn interface(&self, face: Face, ray: &Ray, met: &Meeting, beyond: MediumId) -> Next {
        let surface = self.skin(face).map_or(SurfaceId::SMOOTH, |s| s.surface);
        // Numbers behind those of all bodies.
        let body = BodyId(self.bodies.count() as u32 + face as u32);
        let outward = if ray.dir.dot(met.up) > 0.0 { -met.up } else { met.up };
        let normal = against(ray.dir, outward);
        let axis = DVec3::ZERO;
        Next::Interface(Interface {
            distance: met.distance,
            normal,
            facet: normal,
            axis,
            beyond,
            surface,
            body,
        })
    }

    /// From beyond a surface.
    fn next_beyond(&self, face: Face, ray: &Ray, p: &mut Carved, limit: f64) -> Next {
        let (edge, side) = match self.planes {
            Some([top, bottom]) => super::sheet::plane_ahead(ray, top, bottom),
            None => (f64::INFINITY, if ray.dir.z < 0.0 { Face::Bottom } else { Face::Top }),
        };
        match self.meet(face, true, ray, p, limit.min(edge)) {
            Ahead::Met(met) => {
                let there = Ray { origin: ray.at(met.distance), dir: ray.dir };
                let behind = self.bodies.enter_still(&there);
                p.ahead = Some((face, behind.place));
                self.interface(face, ray, &met, behind.medium)
            }
            Ahead::Free
                if side == face && edge <= limit && (edge < f64::INFINITY || self.planes.is_none()) =>
            {
                Next::Edge { face, distance: edge }
            }
            Ahead::Free if limit < f64::INFINITY => Next::Limit,
            // Along the surface for ever, or into it where there is none.
            _ => Next::Lost,
        }
    }

    /// From within.
    fn next_within(&self, ray: &Ray, p: &mut Carved, limit: f64, rng: &mut Stream) -> Next {
        let next = self.bodies.next(ray, &mut p.here, &mut (), limit, rng);
        let mut reach = match &next {
            Next::Interface(at) => at.distance,
            Next::Edge { distance, .. } => *distance,
            Next::Limit => limit,
            // Along planes without end a sheet's bodies have no answer, the surface may.
            Next::Lost if p.here.is_lost() => return Next::Lost,
            Next::Lost => limit,
        };
        let mut first = None;
        for face in [Face::Top, Face::Bottom] {
            match self.meet(face, false, ray, p, reach) {
                Ahead::Met(met) => {
                    reach = met.distance;
                    first = Some((face, met));
                }
                Ahead::Free => {}
                Ahead::Endless => return Next::Lost,
            }
        }
        let Some((face, met)) = first else { return next };
        p.ahead = Some((face, Place::default()));
        self.interface(face, ray, &met, self.bodies.ambient())
    }
}

impl Universe for Topography {
    type Memory = ();
    type Place = Carved;

    fn forget(&self, _: &mut ()) {}

    fn enter(&self, ray: &Ray, _: &mut (), rng: &mut Stream) -> Start<Carved> {
        let mut shift = DVec3::ZERO;
        if self.anywhere {
            let [x, y] = self.period();
            shift = DVec3::new(x * rng.uniform(), y * rng.uniform(), 0.0);
        }
        self.come_back(ray, &Carved { shift, ..Carved::default() }, &mut (), rng)
    }

    fn come_back(&self, ray: &Ray, at: &Carved, _: &mut (), _: &mut Stream) -> Start<Carved> {
        let ray = at.displaced(ray);
        let zone = self.zone(&ray);
        let here = if zone == Zone::Within { self.bodies.enter_still(&ray).place } else { Place::default() };
        let place = Carved { zone, here, left: None, ahead: None, shift: at.shift };
        Start { place, medium: self.medium(&place) }
    }

    fn next(&self, ray: &Ray, p: &mut Carved, _: &mut (), limit: f64, rng: &mut Stream) -> Next {
        let ray = p.displaced(ray);
        p.ahead = None;
        if !ray.origin.is_finite() || !ray.dir.is_finite() {
            return Next::Lost;
        }
        match p.zone {
            Zone::Beyond(face) => self.next_beyond(face, &ray, p, limit),
            Zone::Within => self.next_within(&ray, p, limit, rng),
        }
    }

    fn moved(&self, ray: &Ray, p: &mut Carved, _: &mut (), d: f64) {
        (p.left, p.ahead) = (None, None);
        if p.zone == Zone::Within {
            self.bodies.moved(&p.displaced(ray), &mut p.here, &mut (), d);
        }
    }

    fn reflected(&self, ray: &Ray, p: &mut Carved, _: &mut (), at: &Interface) {
        let ray = p.displaced(ray);
        let surface = p.ahead.take();
        p.left = surface.map(|s| s.0);
        match (p.zone, surface) {
            (Zone::Beyond(_), _) => {}
            // As far as the surface the ray has moved as any ray does.
            (Zone::Within, Some(_)) => self.bodies.moved(&ray, &mut p.here, &mut (), at.distance),
            (Zone::Within, None) => self.bodies.reflected(&ray, &mut p.here, &mut (), at),
        }
    }

    fn crossed(&self, ray: &mut Ray, p: &mut Carved, _: &mut (), at: &Interface) {
        let Some((face, behind)) = p.ahead.take() else {
            p.left = None;
            let mut there = p.displaced(ray);
            return self.bodies.crossed(&mut there, &mut p.here, &mut (), at);
        };
        p.left = Some(face);
        p.here = behind;
        p.zone = if p.zone == Zone::Within { Zone::Beyond(face) } else { Zone::Within };
    }
}

impl Carved {
    /// The ray among the bodies.
    fn displaced(&self, ray: &Ray) -> Ray {
        Ray { origin: ray.origin + self.shift, dir: ray.dir }
    }
}
