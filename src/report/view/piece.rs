//! The piece of the sheet that is drawn: which bodies or voxels stand in it.

use super::Eye;
use super::solids::{self, Item};
use crate::law::Tilt;
use crate::math::{DVec3, PI};
use crate::scene::Scene;
use crate::scene::plan::Plan;
use crate::universe::any::AnyUniverse;
use crate::universe::shape::Shape;
use crate::universe::statistical::kind::{Kind, Sizes};
use crate::universe::synthetic::drum::Drum;
use crate::universe::synthetic::realise::Boolean;
use crate::universe::synthetic::{Part, SyntheticUniverse, corners};
use crate::universe::topography::Topography;
use crate::universe::voxel::VoxelUniverse;
use crate::universe::{MediumId, Overlap};

/// Bodies of a kind that are drawn, about.
const FIBRES: f64 = 300.0;
const PARTICLES: f64 = 260.0;
/// Bodies (pieces of them) that are drawn at most.
const MOST: usize = 900;

/// A body and its hollow.
type Body = (Part, Option<Part>);

enum What {
    /// Bodies, and the share of each medium's bodies that is drawn where that is not all.
    Bodies(Vec<Body>, Vec<(MediumId, f64)>),
    Cut(Topography, Vec<Body>),
    Voxels(VoxelUniverse),
}

/// What is drawn.
pub(super) struct Piece {
    what: What,
    /// The universe without a random place for each history.
    pub still: Option<AnyUniverse>,
    /// Lower and upper plane, µm.
    pub planes: [f64; 2],
    /// Edge of the square window, µm.
    pub side: f64,
    /// Its middle, where bodies fix it.
    pub middle: Option<[f64; 2]>,
    /// What the picture shows.
    pub words: &'static str,
}

const REALISED: &str = "Bodies: a realisation of the same statistics; each history of the run has its own.";

impl Piece {
    /// A piece of the universe of a plan, about twice as wide as the sheet is thick.
    pub fn of(scene: &Scene, plan: &Plan) -> Self {
        let planes = [plan.bottom, plan.top];
        match &plan.universe {
            AnyUniverse::Synthetic(u) => alone(u, planes),
            AnyUniverse::Ensemble(u) => cell(&u.cells()[0], planes),
            AnyUniverse::Topography(u) => cut(u, planes),
            AnyUniverse::Voxel(u) => voxels(u, planes),
            AnyUniverse::Realised(drum) => drawn(scene, std::slice::from_ref(drum.model()), planes, REALISED),
            AnyUniverse::Stack(stack) => {
                let models: Vec<_> =
                    stack.layers().filter_map(|l| l.1).map(|drum| drum.model().clone()).collect();
                drawn(scene, &models, planes, REALISED)
            }
            AnyUniverse::Statistical(u) => statistical(scene, u.layers(), planes),
            AnyUniverse::Lazy(u) => statistical(scene, u.sheet().layers(), planes),
            AnyUniverse::Mixture(_) => {
                let words = "Layers of random thickness stand nowhere: the box is the sheet.";
                Piece { words, ..drawn(scene, &[], planes, "") }
            }
        }
    }

    /// Draws what stands in the window; the media drawn, each with the share of its bodies.
    pub fn draw(&self, eye: &Eye, window: [[f64; 2]; 2], out: &mut String) -> Vec<(MediumId, f64)> {
        let mut media: Vec<(MediumId, f64)> = Vec::new();
        let mut number = |medium: MediumId| match media.iter().position(|m| m.0 == medium) {
            Some(i) => i,
            None => {
                media.push((medium, 1.0));
                media.len() - 1
            }
        };
        let mut items: Vec<Item> = Vec::new();
        let mut shares: &[(MediumId, f64)] = &[];
        match &self.what {
            What::Bodies(bodies, drawn) => {
                // Coordinates of the bodies of statistics count from the middle of the window.
                let shift = match self.middle {
                    Some(_) => DVec3::ZERO,
                    None => DVec3::new(
                        0.5 * (window[0][0] + window[1][0]),
                        0.5 * (window[0][1] + window[1][1]),
                        0.0,
                    ),
                };
                let ends = |p: &Part| !matches!(p.shape.shape, Shape::HalfSpace(_) | Shape::SlabZ(_));
                for (part, hollow) in bodies.iter().filter(|b| ends(&b.0)) {
                    let media = [number(part.medium), hollow.map_or(0, |h| number(h.medium))];
                    solids::body(part, hollow.as_ref(), media, shift, eye, window, self.planes, &mut items);
                }
                shares = drawn;
            }
            What::Cut(u, bodies) => {
                for (part, hollow) in bodies {
                    let media = [number(part.medium), hollow.map_or(0, |h| number(h.medium))];
                    let still = DVec3::ZERO;
                    solids::body(part, hollow.as_ref(), media, still, eye, window, self.planes, &mut items);
                }
                solids::surfaces(u, window, eye, &mut number, &mut items);
            }
            What::Voxels(u) => solids::voxels(u, window, self.planes, eye, &mut number, &mut items),
        }
        solids::paint(items, out);
        for (medium, share) in shares {
            media.iter_mut().filter(|m| m.0 == *medium).for_each(|m| m.1 = *share);
        }
        media
    }
}

/// Explicit bodies without a cell: about the origin if that lies among them.
fn alone(u: &SyntheticUniverse, planes: [f64; 2]) -> Piece {
    let bodies: Vec<Body> = u.bodies().collect();
    let mut bounds: Option<(DVec3, DVec3)> = None;
    for (part, _) in &bodies {
        if let Some((low, high)) = corners(&part.shape).filter(|c| c.0.is_finite() && c.1.is_finite()) {
            bounds = Some(bounds.map_or((low, high), |b| (b.0.min(low), b.1.max(high))));
        }
    }
    let words = "Bodies of the scene; surfaces without end are not drawn beyond the box.";
    let height = planes[1] - planes[0];
    let (middle, side, planes) = match bounds {
        Some((low, high)) => {
            let within = low.x <= 0.0 && low.y <= 0.0 && high.x >= 0.0 && high.y >= 0.0;
            let m = (low + high) * 0.5;
            let wide = (high - low).x.max((high - low).y);
            let planes = if height.is_finite() && height > 0.0 { planes } else { [low.z, high.z] };
            let middle = if within { [0.0, 0.0] } else { [m.x, m.y] };
            (middle, wide.min(8.0 * (planes[1] - planes[0])), planes)
        }
        None if height.is_finite() && height > 0.0 => ([0.0, 0.0], 2.0 * height, planes),
        None => ([0.0, 0.0], 100.0, [-25.0, 25.0]),
    };
    few(Piece {
        what: What::Bodies(bodies, Vec::new()),
        still: None,
        planes,
        side,
        middle: Some(middle),
        words,
    })
}

/// A periodic cell and its neighbours.
fn cell(u: &SyntheticUniverse, planes: [f64; 2]) -> Piece {
    let period = u.period();
    let mut bodies = Vec::new();
    for (part, hollow) in u.bodies() {
        for i in [-1.0, 0.0, 1.0] {
            for j in [-1.0, 0.0, 1.0] {
                let shift = DVec3::new(i * period[0], j * period[1], 0.0);
                let moved = |mut p: Part| {
                    p.shape.centre += shift;
                    p
                };
                bodies.push((moved(part), hollow.map(moved)));
            }
        }
    }
    let side = (2.2 * (planes[1] - planes[0])).min(period[0]).min(period[1]);
    few(Piece {
        what: What::Bodies(bodies, Vec::new()),
        still: Some(AnyUniverse::Synthetic(u.clone())),
        planes,
        side,
        middle: Some([0.0; 2]),
        words: "Bodies of the scene (of its first realisation), which stand still here for all paths.",
    })
}

/// Measured surfaces, and bodies with an end between them.
fn cut(u: &Topography, planes: [f64; 2]) -> Piece {
    let [x, y] = u.period();
    let ends = |p: &Part| corners(&p.shape).is_some_and(|(l, h)| l.is_finite() && h.is_finite());
    let bodies: Vec<Body> = u.bodies().bodies().filter(|b| ends(&b.0)).collect();
    Piece {
        what: What::Cut(u.still(), bodies),
        still: Some(AnyUniverse::Topography(u.still())),
        planes,
        side: x.min(y).min((4.0 * (planes[1] - planes[0])).max(0.25 * x.min(y))),
        middle: Some([0.0; 2]),
        words: "A piece of the measured surface, which stands still here for all paths.",
    }
}

/// Narrower until it holds no more than [`MOST`] bodies.
fn few(mut piece: Piece) -> Piece {
    let What::Bodies(bodies, _) = &mut piece.what else { return piece };
    let middle = piece.middle.unwrap_or([0.0; 2]);
    let near = |b: &Body, side: f64| {
        corners(&b.0.shape).is_none_or(|(low, high)| {
            [(low.x, high.x), (low.y, high.y)]
                .iter()
                .zip(middle)
                .all(|((l, h), m)| *l < m + 0.5 * side && *h > m - 0.5 * side)
        })
    };
    bodies.retain(|b| near(b, piece.side));
    while bodies.len() > MOST {
        piece.side *= 0.85;
        bodies.retain(|b| near(b, piece.side));
    }
    piece
}

fn voxels(u: &VoxelUniverse, planes: [f64; 2]) -> Piece {
    let (_, size) = u.sizes();
    Piece {
        what: What::Voxels(u.clone()),
        still: Some(AnyUniverse::Voxel(u.still())),
        planes,
        side: (2.0 * (planes[1] - planes[0])).min(size[0]).min(size[1]),
        middle: Some([0.0; 2]),
        words: "A piece of the volume, which stands still here for all paths; blocks of voxels where it is fine.",
    }
}

fn statistical(
    scene: &Scene,
    layers: &[crate::universe::statistical::Population],
    planes: [f64; 2],
) -> Piece {
    let sheet = scene.universe.sheet();
    let contained = sheet.is_some_and(|s| s.edges == crate::scene::Edges::Contained);
    let overlap = sheet.map_or(Overlap::Union, |s| s.overlap);
    let models: Vec<Boolean> = layers
        .iter()
        .map(|l| Boolean {
            kinds: l.kinds.clone(),
            density: l.density.clone(),
            sheet: [l.slab.bottom, l.slab.top],
            pore: l.slab.pore,
            overlap,
            contained,
        })
        .collect();
    let words = if models.iter().any(|m| !m.kinds.is_empty()) {
        "Bodies: one realisation of the sheet's statistics. In the run bodies are drawn as light meets them, so \
         that paths turn at bodies of their own."
    } else {
        "The layers hold no bodies: the box is the sheet."
    };
    drawn(scene, &models, planes, words)
}

/// A realisation of the models, each kind of body by itself; of those that are too many a random share.
fn drawn(scene: &Scene, models: &[Boolean], planes: [f64; 2], words: &'static str) -> Piece {
    let height = planes[1] - planes[0];
    let fibres = models.iter().flat_map(|m| m.kinds.iter().zip(&m.density)).filter(|k| k.0.is_fibre());
    let widest = fibres.map(|k| width(k.0)).fold(0.0, f64::max);
    let side = (1.6 * height).max(5.0 * widest);
    let radius = 0.75 * side;
    let (mut bodies, mut shares) = (Vec::new(), Vec::new());
    for model in models {
        for (kind, &density) in model.kinds.iter().zip(&model.density) {
            let layer = model.sheet[1] - model.sheet[0];
            let (number, most) = match kind.sizes() {
                Sizes::Fibre { length: Some(l), .. } => {
                    (density / l.mean() * layer * PI * radius * (radius + l.mean() / 1.57), FIBRES)
                }
                Sizes::Fibre { .. } => (density * layer * 2.0 * radius, FIBRES),
                _ => (density * layer * PI * radius * radius, PARTICLES),
            };
            let share = (most / number).min(1.0);
            let one = Boolean { kinds: vec![kind.clone()], density: vec![density * share], ..model.clone() };
            // Fibres without end that leave the plane have no realisation.
            let Ok(drum) = Drum::new(&one, scene.run.seed, 0) else { continue };
            let here = drum.bodies(scene.run.seed, bodies.len() as u64, radius);
            if share < 1.0 {
                shares.extend(here.first().map(|b| (b.0.medium, share)));
            }
            bodies.extend(here);
        }
    }
    let near = |b: &Body| {
        corners(&b.0.shape).is_none_or(|(l, h)| {
            l.x < 0.5 * side && l.y < 0.5 * side && h.x > -0.5 * side && h.y > -0.5 * side
        })
    };
    bodies.retain(near);
    Piece { what: What::Bodies(bodies, shares), still: None, planes, side, middle: None, words }
}

fn width(kind: &Kind) -> f64 {
    match kind.sizes() {
        Sizes::Fibre { width, .. } if kind.tilt == Tilt::InPlane => width.mean(),
        Sizes::Fibre { width, .. } => 1.5 * width.mean(),
        _ => 0.0,
    }
}
