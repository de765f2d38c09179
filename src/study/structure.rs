//! What stands where in an explicit universe: sections, overlaps, meshes, and the same sheet written out.

use super::characterise::bodies::BodyParts;
use crate::math::DVec3;
use crate::report::mesh::surface_vtp;
use crate::report::plot::section::{Section, colour};
use crate::rng::{Purpose, Stream};
use crate::scene::media::Media;
use crate::scene::plan::Plan;
use crate::scene::{Scene, Universe as Where};
use crate::universe::any::AnyUniverse;
use crate::universe::sheet::Slab;
use crate::universe::synthetic::drum::Drum;
use crate::universe::synthetic::{Search, Setting, SyntheticUniverse, corners};
use crate::universe::topography::Topography;
use crate::universe::voxel::VoxelUniverse;
use crate::universe::{Face, MediumId};
use std::fmt::Write;

/// Bodies of a drum that are looked at, about.
const BODIES: f64 = 3000.0;

/// An explicit universe, or a piece of one, to be looked at.
pub struct Structure {
    what: What,
    /// Lower and upper plane, µm.
    pub planes: [f64; 2],
    /// Middle and size along x and y of the piece, µm.
    pub window: [[f64; 2]; 2],
    /// Bodies, each with its hollow.
    pub bodies: Vec<BodyParts>,
    media: Media,
}

enum What {
    Bodies(SyntheticUniverse),
    /// Upper plane, medium and bodies of each layer, top to bottom.
    Layers(Vec<(Slab, Option<SyntheticUniverse>)>),
    Cut(Topography),
    Voxels(VoxelUniverse),
}

impl Structure {
    /// The structure of a scene, of its first realisation where it has several.
    ///
    /// # Errors
    /// Universes known by statistics only, and bodies without bounds.
    pub fn of(scene: &Scene, plan: Plan) -> Result<Self, String> {
        let planes = [plan.bottom, plan.top];
        let media = plan.media;
        let whole = |u: &SyntheticUniverse| -> Vec<BodyParts> { u.bodies().collect() };
        Ok(match plan.universe {
            AnyUniverse::Ensemble(u) => {
                let u = u.cells()[0].clone();
                let ([x, y], bodies) = (u.period(), whole(&u));
                let window = [[0.5 * x, 0.5 * y], [x, y]];
                Structure { what: What::Bodies(u), planes, window, bodies, media }
            }
            AnyUniverse::Synthetic(u) => {
                let bodies = whole(&u);
                let window = around(&bodies)?;
                Structure { what: What::Bodies(u), planes, window, bodies, media }
            }
            AnyUniverse::Realised(drum) => {
                let radius = drum.radius_of(BODIES);
                let (u, bodies) = standing(&drum, scene.run.seed, radius)?;
                let side = radius * std::f64::consts::SQRT_2; // the square within the disc that is known
                Structure { what: What::Bodies(u), planes, window: [[0.0; 2], [side; 2]], bodies, media }
            }
            AnyUniverse::Stack(stack) => {
                let drums = || stack.layers().filter_map(|l| l.1);
                let radius = drums().map(|d| d.radius_of(BODIES)).fold(f64::INFINITY, f64::min);
                let (mut layers, mut bodies) = (Vec::new(), Vec::new());
                for (slab, drum) in stack.layers() {
                    let stands = drum.map(|d| standing(d, d.seed(), radius)).transpose()?;
                    let (u, own) = stands.unzip();
                    layers.push((slab, u));
                    bodies.extend(own.into_iter().flatten());
                }
                let side = radius * std::f64::consts::SQRT_2;
                Structure { what: What::Layers(layers), planes, window: [[0.0; 2], [side; 2]], bodies, media }
            }
            AnyUniverse::Topography(u) => {
                let ([x, y], bodies) = (u.period(), whole(u.bodies()));
                let window = [[0.5 * x, 0.5 * y], [x, y]];
                Structure { what: What::Cut(u), planes, window, bodies, media }
            }
            AnyUniverse::Voxel(u) => {
                let cells = u.volume().cells();
                let Where::Voxel(v) = &scene.universe else { return Err("no volume".to_owned()) };
                let size = [0, 1].map(|a| cells[a] as f64 * v.rules.edge[a]);
                Structure {
                    what: What::Voxels(u),
                    planes,
                    window: [[0.0; 2], size],
                    bodies: Vec::new(),
                    media,
                }
            }
            AnyUniverse::Statistical(_) | AnyUniverse::Lazy(_) | AnyUniverse::Mixture(_) => {
                return Err("a sheet known by its statistics stands nowhere: kind=\"synthetic\" realises it"
                    .to_owned());
            }
        })
    }

    /// Medium at a point.
    pub fn medium_at(&self, point: DVec3) -> MediumId {
        match &self.what {
            What::Bodies(u) => u.medium_at(point),
            What::Layers(layers) => {
                let (slab, u) = layer_at(layers, point.z);
                u.as_ref().map_or(slab.pore, |u| u.medium_at(point))
            }
            What::Cut(u) => u.medium_at(point),
            What::Voxels(u) => u.medium_at(point),
        }
    }

    /// Numbers of the bodies that cover a point.
    fn bodies_at(&self, point: DVec3) -> Vec<usize> {
        match &self.what {
            What::Bodies(u) => u.bodies_at(point),
            What::Layers(layers) => {
                let above = layers.iter().take_while(|l| point.z < l.0.bottom);
                let first: usize = above.filter_map(|l| l.1.as_ref()).map(SyntheticUniverse::count).sum();
                let here = layer_at(layers, point.z).1.as_ref();
                here.map_or(Vec::new(), |u| u.bodies_at(point).into_iter().map(|b| first + b).collect())
            }
            What::Cut(u) if u.holds(point) => u.bodies().bodies_at(point),
            What::Cut(_) | What::Voxels(_) => Vec::new(),
        }
    }

    /// Measured surfaces for ParaView: (side, VTP).
    pub fn surfaces(&self) -> Vec<(&'static str, String)> {
        let What::Cut(u) = &self.what else { return Vec::new() };
        let draw = |(name, face, behind): (&'static str, Face, f64)| {
            let map = &u.skin(face)?.map;
            let step = DVec3::Z * (behind * map.grid().1[0]);
            Some((name, surface_vtp(map, |p| u32::from(u.bodies().medium_at(p + step).0))))
        };
        [("top", Face::Top, -1e-3), ("bottom", Face::Bottom, 1e-3)].into_iter().filter_map(draw).collect()
    }

    fn class_at(&self, point: DVec3) -> usize {
        usize::from(self.medium_at(point).0)
    }

    /// Sections in three planes through the middle, at most `most` µm wide: (name, SVG).
    pub fn sections(&self, title: &str, most: f64) -> Vec<(&'static str, String)> {
        let [middle, size] = self.window;
        let [bottom, top] = self.planes;
        let height = top - bottom;
        let width = size.map(|s| s.min(most));
        let corner = [0, 1].map(|a| middle[a] - 0.5 * width[a]);
        let planes = [
            ("xz", DVec3::new(corner[0], middle[1], bottom), DVec3::X, DVec3::Z, [width[0], height]),
            ("yz", DVec3::new(middle[0], corner[1], bottom), DVec3::Y, DVec3::Z, [width[1], height]),
            ("xy", DVec3::new(corner[0], corner[1], bottom + 0.5 * height), DVec3::X, DVec3::Y, width),
        ];
        let draw = |(name, origin, right, up, size): (&'static str, DVec3, DVec3, DVec3, [f64; 2])| {
            let section = Section { origin, right, up, size, pixel: size[0] / 900.0 };
            let pore = self.pore();
            let classes: Vec<_> = self
                .media
                .names
                .iter()
                .enumerate()
                .map(|(i, n)| {
                    (n.as_str(), (i != pore).then(|| colour(i.saturating_sub(usize::from(i > pore)))))
                })
                .collect();
            (name, section.svg(&format!("{title}, {name} plane"), &classes, |p| self.class_at(p)))
        };
        planes.into_iter().map(draw).collect()
    }

    /// The medium that is most of a line above the middle of the sheet: that between the bodies.
    fn pore(&self) -> usize {
        match &self.what {
            What::Bodies(u) => usize::from(u.ambient().0),
            What::Cut(u) => usize::from(u.bodies().ambient().0),
            What::Layers(layers) => {
                let holds = layers.iter().find(|l| l.1.is_some()).or(layers.first());
                holds.map_or(0, |l| usize::from(l.0.pore.0))
            }
            What::Voxels(_) => 0,
        }
    }

    /// Where bodies overlap: `points` even in the window; the share of space that several bodies cover, and
    /// the pairs found first, with a point of each.
    pub fn overlaps(&self, points: u64, seed: u64) -> Overlaps {
        let [middle, size] = self.window;
        let [bottom, top] = self.planes;
        let mut rng = Stream::of(seed, 0, 1 << 40, Purpose::Probe);
        let mut found = Overlaps { points, covered: 0, several: 0, pairs: Vec::new() };
        if matches!(self.what, What::Voxels(_)) {
            return found;
        }
        for _ in 0..points {
            let at = DVec3::new(
                middle[0] + size[0] * (rng.uniform() - 0.5),
                middle[1] + size[1] * (rng.uniform() - 0.5),
                bottom + (top - bottom) * rng.uniform(),
            );
            let bodies = self.bodies_at(at);
            found.covered += u64::from(!bodies.is_empty());
            if let [a, b, ..] = bodies[..] {
                found.several += 1;
                let known = found.pairs.iter_mut().find(|p| p.0 == [a, b]);
                match known {
                    Some(pair) => pair.2 += 1,
                    None => found.pairs.push(([a, b], at, 1)),
                }
            }
        }
        found.pairs.sort_by(|a, b| b.2.cmp(&a.2).then(a.0.cmp(&b.0)));
        found
    }
}

/// Overlaps found by sampling.
#[derive(Clone, Debug)]
pub struct Overlaps {
    /// Points sampled.
    pub points: u64,
    /// Points in any body.
    pub covered: u64,
    /// Points in several.
    pub several: u64,
    /// Pairs of bodies, a point in both, and points found: those found most often first.
    pub pairs: Vec<([usize; 2], DVec3, u64)>,
}

impl Overlaps {
    /// In words, the ten greatest pairs with coordinates.
    pub fn describe(&self) -> String {
        let share = |n: u64| 100.0 * n as f64 / self.points as f64;
        let mut out = format!(
            "bodies cover {:.3} % of space, several at once {:.3} % ({} pairs found with {} points)\n",
            share(self.covered),
            share(self.several),
            self.pairs.len(),
            self.points
        );
        for ([a, b], at, n) in self.pairs.iter().take(10) {
            let _ = writeln!(
                out,
                "  bodies {a} and {b} share {:.4} % of space, e.g. at {:.3} {:.3} {:.3} um",
                share(*n),
                at.x,
                at.y,
                at.z
            );
        }
        out
    }
}

fn layer_at(layers: &[(Slab, Option<SyntheticUniverse>)], z: f64) -> &(Slab, Option<SyntheticUniverse>) {
    let below = layers.iter().take_while(|l| z < l.0.bottom).count();
    &layers[below.min(layers.len() - 1)]
}

/// The first realisation of a drum within `radius` of the z axis.
fn standing(drum: &Drum, seed: u64, radius: f64) -> Result<(SyntheticUniverse, Vec<BodyParts>), String> {
    let model = drum.model();
    let bodies = drum.bodies(seed, 0, radius);
    let parts = bodies.iter().flat_map(|b| [Some(b.0), b.1]).flatten().collect();
    let setting =
        Setting { overlap: model.overlap, sheet: Some(model.sheet), period: None, search: Search::Automatic };
    let u = SyntheticUniverse::with(model.pore, parts, setting).map_err(|e| e.to_string())?;
    Ok((u, bodies))
}

/// Middle and size of what holds all bodies.
fn around(bodies: &[BodyParts]) -> Result<[[f64; 2]; 2], String> {
    let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (body, _) in bodies {
        if let Some((l, h)) = corners(&body.shape) {
            (lo, hi) = (lo.min(l), hi.max(h));
        }
    }
    let size = [hi.x - lo.x, hi.y - lo.y];
    if size.iter().all(|s| s.is_finite() && *s > 0.0) {
        return Ok([[0.5 * (lo.x + hi.x), 0.5 * (lo.y + hi.y)], size]);
    }
    Err("bodies without end have no picture".to_owned())
}
