//! Realisations of a statistical population: the exact Boolean (Poisson) ensemble.
//!
//! Bodies of each kind stand independently, with a density ν (length over volume of unbounded fibres,
//! number over volume of others) of their centroids, and overlap; each carries a random mark that
//! decides between solids. Their number is a Poisson variate. The mean over realisations is what rung
//! `full` of the statistical universe computes without geometry.

use super::drum::{Drum, Entry};
use super::{Error, Part, Search, Setting, SyntheticUniverse};
use crate::law::Tilt;
use crate::math::DVec3;
use crate::rng::{Purpose, Stream};
use crate::universe::shape::{Ellipsoid, EllipticCylinder, Placed, Shape};
use crate::universe::statistical::kind::{Kind, Sizes};
use crate::universe::statistical::section::{Body, HalfAxes};
use crate::universe::{MediumId, Overlap};
use thiserror::Error as ThisError;

/// A Boolean sheet: kinds of bodies and their densities between two planes.
#[derive(Clone, Debug)]
pub struct Boolean {
    /// Kinds of bodies.
    pub kinds: Vec<Kind>,
    /// Density ν of each kind before overlaps: length over volume of fibres, 1/µm²; number over volume
    /// of others, 1/µm³.
    pub density: Vec<f64>,
    /// Lower and upper plane, µm; no surface there.
    pub sheet: [f64; 2],
    /// Medium between the bodies.
    pub pore: MediumId,
    /// Who owns what several bodies cover.
    pub overlap: Overlap,
    /// Bodies that do not lie wholly between the planes are left out (`contained`); else the planes
    /// cut what they meet (`cut`).
    pub contained: bool,
}

/// A population that cannot be realised.
#[derive(Clone, Copy, Debug, PartialEq, ThisError)]
pub enum RealiseError {
    /// No body can be made of these parts.
    #[error(transparent)]
    Parts(#[from] Error),
    /// As many densities as kinds are needed, each finite and not negative; the planes in order.
    #[error(
        "densities must be finite and not negative, one per kind, and the upper plane above the lower one"
    )]
    Amount,
    /// Tilted fibres without end reach through every plane.
    #[error(
        "kind {0}: fibres without end that leave the plane cannot lie wholly within a sheet; use edges=\"cut\" or a fibre length"
    )]
    Tilted(usize),
    /// A periodic cell holds bodies with an end only.
    #[error("kind {0}: fibres without end fit no periodic cell")]
    Endless(usize),
}

impl Boolean {
    /// The realisation number `realisation` without end sideways, generated as rays need it.
    ///
    /// # Errors
    /// [`RealiseError`] where the population cannot be realised.
    pub fn drum(&self, seed: u64, realisation: u64) -> Result<Drum, RealiseError> {
        Drum::new(self, seed, realisation)
    }

    /// All realisations, each drawn for a history, or for the histories that share a memory.
    ///
    /// # Errors
    /// [`RealiseError`] where the population cannot be realised.
    pub fn ensemble(&self, seed: u64, entry: Entry) -> Result<Drum, RealiseError> {
        Drum::ensemble(self, seed, entry)
    }

    /// The realisation number `realisation` in a laterally periodic cell of the given periods, µm.
    /// Periods should exceed two body lengths and twenty lateral spreads of light; to check, double.
    ///
    /// # Errors
    /// [`RealiseError`] where the population cannot be realised.
    pub fn cell(
        &self,
        period: [f64; 2],
        seed: u64,
        realisation: u64,
    ) -> Result<SyntheticUniverse, RealiseError> {
        self.check()?;
        let [bottom, top] = self.sheet;
        let mut bodies: Vec<(u32, [Option<Part>; 2])> = Vec::new();
        for (i, kind) in self.kinds.iter().enumerate() {
            if is_endless(kind) {
                return Err(RealiseError::Endless(i));
            }
            let margin = self.bounds(i).height;
            let height = top - bottom + 2.0 * margin;
            let mut rng = Stream::of(seed, realisation, i as u64, Purpose::Realisation);
            let expected = self.number(i) * period[0] * period[1] * height;
            let mut arrivals = rng.exponential();
            while arrivals < expected {
                arrivals += rng.exponential();
                let mut body = kind.draw(&mut rng);
                let mark = (rng.bits() >> 32) as u32;
                body.centre = DVec3::new(
                    period[0] * rng.uniform(),
                    period[1] * rng.uniform(),
                    bottom - margin + height * rng.uniform(),
                );
                if self.stands(kind, &body, &mut rng) {
                    let mut parts = parts_of(kind, &body);
                    bodies.push((mark, [parts.next(), parts.next()]));
                }
            }
        }
        bodies.sort_by_key(|b| b.0); // stable: equal marks by order of making
        let parts = bodies.into_iter().flat_map(|b| b.1).flatten().collect();
        let setting = Setting {
            overlap: self.overlap,
            sheet: Some(self.sheet),
            period: Some(period),
            search: Search::Automatic,
        };
        Ok(SyntheticUniverse::with(self.pore, parts, setting)?)
    }

    pub(super) fn check(&self) -> Result<(), RealiseError> {
        let [bottom, top] = self.sheet;
        let amounts = self.density.len() == self.kinds.len()
            && self.density.iter().all(|&d| d.is_finite() && d >= 0.0)
            && bottom.is_finite()
            && top.is_finite()
            && top > bottom;
        if !amounts {
            return Err(RealiseError::Amount);
        }
        let tilted = |k: &Kind| is_endless(k) && !is_level(k) && (self.contained || k.profile.is_some());
        match self.kinds.iter().position(tilted) {
            Some(i) => Err(RealiseError::Tilted(i)),
            None => Ok(()),
        }
    }

    /// Density of bodies of kind `i` before thinning ([`Boolean::stands`]): number over volume, length
    /// over volume of unbounded fibres.
    pub(super) fn number(&self, i: usize) -> f64 {
        let kind = &self.kinds[i];
        let most = kind.profile.as_ref().map_or(1.0, |p| p.most());
        let length = match kind.sizes() {
            Sizes::Fibre { length: Some(length), .. } => length.mean(),
            _ => 1.0,
        };
        self.density[i] * most / length
    }

    /// Whether a body may stand where it is: within the planes if it has to, and by its kind's density
    /// over depth.
    pub(super) fn stands(&self, kind: &Kind, body: &Body, rng: &mut Stream) -> bool {
        let [bottom, top] = self.sheet;
        let (h, z) = (body.half_height(), body.centre.z);
        if self.contained && (z - h < bottom || z + h > top) {
            return false;
        }
        // Bodies that do not reach the sheet are nothing to it (where tilted fibres end is not known).
        if (is_level(kind) || !is_endless(kind)) && (z + h < bottom || z - h > top) {
            return false;
        }
        let Some(profile) = &kind.profile else { return true };
        let depth = (top - body.centre.z) / (top - bottom);
        rng.uniform() * profile.most() < profile.at(depth)
    }

    /// Bounds of the bodies of kind `i`. Size laws without upper bound are taken to end at twice the largest
    /// of 4096 bodies: what little is beyond may be missed at the rim of what a ray has explored.
    pub(super) fn bounds(&self, i: usize) -> Bounds {
        const SAMPLES: u32 = 4096;
        let kind = &self.kinds[i];
        let mut rng = Stream::of(0xd0_07, 0, i as u64, Purpose::Probe);
        let (mut across, mut along, mut thickness) = (0.0_f64, 0.0_f64, 0.0);
        let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
        for _ in 0..SAMPLES {
            let body = kind.draw(&mut rng);
            let outer = &body.outer;
            across = across.max(outer.a.max(outer.b));
            along = along.max(finite(outer.c).max(finite(body.ends)));
            thickness += 2.0 * (outer.a * outer.b).sqrt() / f64::from(SAMPLES);
        }
        let (upper_across, upper_along) = upper(kind.sizes());
        let bound = |upper: f64, seen: f64| if upper.is_finite() { upper } else { 2.0 * seen };
        let (across, along) = (bound(upper_across, across), bound(upper_along, along));
        let size = across + along;
        // The axis of a level fibre adds nothing to its height.
        let height = if kind.is_fibre() && is_level(kind) { across } else { size };
        Bounds { size, height, thickness }
    }

    /// Length of the longest body, µm.
    pub fn longest(&self) -> f64 {
        (0..self.kinds.len())
            .filter(|&i| self.density[i] > 0.0)
            .map(|i| 2.0 * self.bounds(i).size)
            .fold(0.0, f64::max)
    }

    /// Largest half size of any body, and the mean thickness, µm.
    pub(super) fn widths(&self) -> (f64, f64) {
        let present: Vec<Bounds> =
            (0..self.kinds.len()).filter(|&i| self.density[i] > 0.0).map(|i| self.bounds(i)).collect();
        if present.is_empty() {
            let height = self.sheet[1] - self.sheet[0];
            return (height, height);
        }
        let widest = present.iter().map(|b| b.size).fold(0.0, f64::max);
        (widest, present.iter().map(|b| b.thickness).sum::<f64>() / present.len() as f64)
    }
}

/// Bounds of the bodies of a kind, µm.
pub(super) struct Bounds {
    /// Largest distance of a surface from the body's centre (from the axis of an unbounded one).
    pub size: f64,
    /// Largest half height.
    pub height: f64,
    /// Mean thickness.
    thickness: f64,
}

/// Whether bodies have no end along their axis.
pub(super) fn is_endless(kind: &Kind) -> bool {
    matches!(kind.sizes(), Sizes::Fibre { length: None, .. })
}

/// Whether axes lie in the plane.
pub(super) fn is_level(kind: &Kind) -> bool {
    kind.tilt == Tilt::InPlane
}

/// Largest half widths across and along the axis that laws of size allow.
fn upper(sizes: &Sizes) -> (f64, f64) {
    let (across, along) = match sizes {
        Sizes::Fibre { width, flatness, length, .. } => {
            (width.upper() * flatness.upper().max(1.0), length.as_ref().map_or(0.0, |l| l.upper()))
        }
        Sizes::Ellipsoid([a, b, c]) => (a.upper().max(b.upper()), c.upper()),
        Sizes::Sphere(d) => (d.upper(), 0.0),
        Sizes::Disc { diameter, thickness } => (diameter.upper(), thickness.upper()),
    };
    (0.5 * across, 0.5 * along)
}

/// The regions of a body: outer surface and hollow.
pub(in crate::universe) fn parts_of(kind: &Kind, body: &Body) -> impl Iterator<Item = Part> + use<> {
    let (surface, centre, frame, id) = (kind.surface, body.centre, body.frame, kind.body);
    let shape = |h: &HalfAxes| match h.c.is_infinite() {
        true => Shape::Cylinder(EllipticCylinder {
            a: h.a,
            b: h.b,
            half_length: body.ends.is_finite().then_some(body.ends),
        }),
        false => Shape::Ellipsoid(Ellipsoid { a: h.a, b: h.b, c: h.c }),
    };
    let shapes = [Some((shape(&body.outer), kind.wall)), body.lumen.as_ref().map(|l| (shape(l), kind.lumen))];
    shapes.into_iter().flatten().map(move |(shape, medium)| Part {
        shape: Placed::new(shape, centre, frame),
        medium,
        surface,
        priority: 0,
        body: id,
    })
}
