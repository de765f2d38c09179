//! Where components are: sheets known by statistics, mixtures, bodies, volumes.

use crate::law::{Azimuth, Roll, SizeLaw, Tilt};
use crate::math::DVec3;
use crate::universe::shape::SlantedCylinder;
use crate::universe::topography::Skin;
use crate::universe::voxel::{self, Volume};
use crate::universe::{MediumId, Overlap, SurfaceId};
use std::sync::Arc;

/// Memory rung of the statistical universe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// Nothing: bodies take no room.
    Homogeneous,
    /// The medium only.
    Markov,
    /// The body the ray is in.
    None,
    /// The last k flights and the bodies met on them; of a mixture the last k layers.
    Last(u32),
    /// Everything met.
    Full,
}

/// Rate of rung `none`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rate {
    /// Keeps mass.
    Matched,
    /// Keeps surface.
    Boolean,
}

/// What happens at the faces of a sheet of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edges {
    /// An unbounded medium cut by the planes.
    Cut,
    /// Bodies lie wholly between the planes.
    Contained,
}

/// Where light may start in a `cut` sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartIn {
    /// Anywhere on the plane, inside bodies too.
    Anywhere,
    /// In pores only.
    Pore,
}

/// Where components are.
#[derive(Clone, Debug)]
pub enum Universe {
    /// Known by statistics only.
    Statistical(StatisticalSheet),
    /// Planar layers of random thickness.
    Mixture(Mixture),
    /// Known explicitly.
    Synthetic(Synthetic),
    /// Explicit, drawn from statistics.
    Realised(Realised),
    /// Known voxel by voxel.
    Voxel(Voxels),
}

impl Universe {
    /// The statistics of a sheet, drawn as light meets it or realised.
    pub fn sheet(&self) -> Option<&StatisticalSheet> {
        match self {
            Universe::Statistical(sheet) | Universe::Realised(Realised { sheet, .. }) => Some(sheet),
            Universe::Mixture(_) | Universe::Synthetic(_) | Universe::Voxel(_) => None,
        }
    }
}

/// A statistical sheet realised body by body: the exact (Boolean) ensemble that `memory="full"` is the mean
/// over, or deposited.
#[derive(Clone, Debug)]
pub struct Realised {
    /// The statistics.
    pub sheet: StatisticalSheet,
    /// Histories of a realisation meet it at random within ± this, µm; `None`: forty mean thicknesses of
    /// its bodies.
    pub spread: Option<f64>,
    /// Bodies fall one by one instead.
    pub deposit: Option<Depositing>,
}

/// How fibres fall on a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depositing {
    /// Steepest course of a fibre.
    pub flexibility: f64,
    /// Height of sections over that as drawn; `None`: found so that the sheet gets its thickness.
    pub pressing: Option<f64>,
    /// Places tried for each fibre.
    pub places: u32,
    /// Edge of the periodic cell, µm.
    pub cell: f64,
    /// Realisations that histories meet in turn, batch by batch.
    pub realisations: u64,
    /// Distance within which surfaces count as bonded, µm.
    pub gap: f64,
}

/// A labelled volume.
#[derive(Clone, Debug)]
pub struct Voxels {
    /// The voxels: indices into `phases`.
    pub volume: Arc<Volume>,
    /// What they are made of.
    pub phases: Vec<voxel::Phase>,
    /// How the volume is placed and read; `anywhere` as asked for, or as the source wants it.
    pub rules: voxel::Rules,
    /// Position asked for: displaced at random, or fixed.
    pub random: Option<bool>,
}

/// A statistical sheet.
#[derive(Clone, Debug)]
pub struct StatisticalSheet {
    /// Memory rung.
    pub memory: Memory,
    /// Rate of rung `none`; None: matched for bodies that light enters, boolean for opaque ones.
    pub rate: Option<Rate>,
    /// Overlap rule.
    pub overlap: Overlap,
    /// Edges.
    pub edges: Edges,
    /// Start.
    pub start: StartIn,
    /// Medium outside.
    pub outside: MediumId,
    /// Layers, top (where light comes from) to bottom.
    pub layers: Vec<Layer>,
    /// Lambertian backing in optical contact below: reflectance.
    pub backing: Option<f64>,
}

/// A Markov mixture: planar layers of random thickness of two or more phases.
#[derive(Clone, Debug, PartialEq)]
pub struct Mixture {
    /// Memory rung; `None` and `Markov` are one here.
    pub memory: Memory,
    /// µm.
    pub thickness: f64,
    /// Phases.
    pub phases: Vec<MixturePhase>,
    /// Law of the planes between phases.
    pub surface: SurfaceId,
    /// Medium outside.
    pub outside: MediumId,
    /// Lambertian backing in optical contact below: reflectance.
    pub backing: Option<f64>,
}

/// A phase of a mixture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixturePhase {
    /// Medium.
    pub material: MediumId,
    /// Mean thickness of a layer, µm.
    pub chord: f64,
    /// Share among the phases that may follow another.
    pub share: f64,
}

/// A layer of a sheet: a medium and the bodies in it.
#[derive(Clone, Debug)]
pub struct Layer {
    /// µm.
    pub thickness: f64,
    /// Medium between the bodies.
    pub pore: MediumId,
    /// Surface law of the layer's upper plane where media differ.
    pub surface: SurfaceId,
    /// Bodies; empty: a homogeneous layer.
    pub components: Vec<Component>,
    /// The Grace way, instead of densities.
    pub grace: Option<Grace>,
}

/// Free-path law of the Grace way.
#[derive(Clone, Debug, PartialEq)]
pub enum FreePath {
    /// Exponential with a mean, µm.
    Exponential(f64),
    /// Gamma with mean µm and shape.
    Gamma {
        /// Mean, µm.
        mean: f64,
        /// Shape k (1 is exponential).
        shape: f64,
    },
    /// Histogram: upper bin edges (µm, ascending, from 0) and weights.
    Empirical {
        /// Edges, one more than weights, first 0.
        edges: Vec<f64>,
        /// Weights ≥ 0.
        weights: Vec<f64>,
    },
}

/// Free-path laws and component-type table over depth (program Grace).
#[derive(Clone, Debug)]
pub struct Grace {
    /// Free path in the pore medium, from a surface.
    pub free_path: FreePath,
    /// Rows over relative depth: (depth from the top, 0…1, probability per component, summing to 1);
    /// linear between rows.
    pub types: Vec<(f64, Vec<f64>)>,
    /// Probability that the component just left is met again is multiplied by this (contact
    /// reduction, 1 = none), the rest renormalised.
    pub contact: f64,
}

/// One kind of body in a layer.
#[derive(Clone, Debug)]
pub struct Component {
    /// Name, for tallies.
    pub name: String,
    /// Shape and sizes.
    pub shape: Shape,
    /// Solid medium.
    pub material: MediumId,
    /// Medium inside the lumen.
    pub lumen: MediumId,
    /// Law of all surfaces of the body.
    pub surface: SurfaceId,
    /// In-plane azimuth of the axis.
    pub azimuth: Azimuth,
    /// Tilt of the axis out of the plane.
    pub tilt: Tilt,
    /// Roll of the section.
    pub roll: Roll,
    /// How much.
    pub amount: Amount,
    /// Relative density over relative depth, (depth, density) rows; None: uniform.
    pub profile: Option<Vec<(f64, f64)>>,
    /// Share of the outer surface in optical contact with another body of the layer.
    pub bonded: f64,
    /// Density of the solid, kg/m³.
    pub density: f64,
    /// Coarseness, kg/m ×1e6 = mg/m, if given.
    pub coarseness: Option<f64>,
}

/// Shape of a body.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Cylinder of elliptic section.
    Fibre {
        /// Full width (major axis) of the section, µm.
        width: SizeLaw,
        /// Height over width, 0 < f ≤ 1.
        flatness: SizeLaw,
        /// Wall thickness, µm; None: solid.
        wall: Option<SizeLaw>,
        /// Length, µm.
        length: SizeLaw,
        /// Whether fibres end in flat ends; else they are unbounded and `length` serves amounts only.
        finite: bool,
    },
    /// Ellipsoid with full axes, µm: the first two in the plane of the sheet (`roll` flat).
    Ellipsoid {
        /// Full axes.
        axes: [SizeLaw; 3],
    },
    /// Sphere.
    Sphere {
        /// µm.
        diameter: SizeLaw,
    },
    /// Round disc, flat in the sheet.
    Disc {
        /// µm.
        diameter: SizeLaw,
        /// µm.
        thickness: SizeLaw,
    },
}

/// How much of a component a layer holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amount {
    /// g/m² of solid really present.
    Grammage(f64),
    /// Total fibre length over volume, 1/µm².
    LengthDensity(f64),
    /// Number over volume, 1/µm³.
    NumberDensity(f64),
    /// Body volume (wall and lumen) fraction after overlaps.
    VolumeFraction(f64),
}

/// Explicit bodies that repeat themselves sideways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Periods along x and y, µm.
    pub period: [f64; 2],
    /// Lower and upper plane, µm.
    pub planes: [f64; 2],
    /// Who owns what several bodies cover.
    pub overlap: Overlap,
    /// Where light may start.
    pub start: StartIn,
}

/// An explicit scene.
#[derive(Clone, Debug)]
pub struct Synthetic {
    /// The cell that they fill; `None`: they stand alone.
    pub cell: Option<Cell>,
    /// Medium around everything.
    pub ambient: MediumId,
    /// Bodies in the order of the file; later ones win at equal priority.
    pub bodies: Vec<Body>,
    /// Surfaces that cut them off: on top, at the bottom.
    pub skins: [Option<Skin>; 2],
    /// Whether each history finds bodies and surfaces displaced by chance, as written.
    pub random: Option<bool>,
}

/// An explicit body.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name.
    pub name: String,
    /// Geometry.
    pub geometry: Geometry,
    /// Medium inside.
    pub material: MediumId,
    /// Surface law.
    pub surface: SurfaceId,
    /// Higher wins where bodies overlap.
    pub priority: i32,
}

/// Explicit geometry; lengths µm, half axes.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// Ball.
    Sphere {
        /// Centre.
        centre: DVec3,
        /// Radius.
        radius: f64,
    },
    /// Ellipsoid with half axes along the (unit, orthogonal) frame x, y, z.
    Ellipsoid {
        /// Centre.
        centre: DVec3,
        /// Half axes.
        half_axes: DVec3,
        /// Direction of the third half axis.
        axis: DVec3,
        /// Direction of the first half axis.
        major: DVec3,
    },
    /// Cylinder of elliptic section, optionally hollow and bounded.
    Cylinder {
        /// A point on the axis (the middle of a bounded one).
        centre: DVec3,
        /// Axis direction, unit.
        axis: DVec3,
        /// Direction of the first half axis of the section, unit, orthogonal to `axis`.
        major: DVec3,
        /// Half axes of the section.
        half_axes: (f64, f64),
        /// Half length; None: unbounded.
        half_length: Option<f64>,
        /// Half axes of the lumen and its medium.
        lumen: Option<((f64, f64), MediumId)>,
    },
    /// Piece of a bent fibre.
    Piece {
        /// Origin of its frame.
        centre: DVec3,
        /// Course, unit.
        axis: DVec3,
        /// Direction of the first half axis of the section, unit, orthogonal to `axis`.
        major: DVec3,
        /// The solid.
        shape: SlantedCylinder,
        /// Half axes of the lumen and its medium.
        lumen: Option<((f64, f64), MediumId)>,
    },
    /// Axis-aligned box.
    Box {
        /// Lower corner.
        min: DVec3,
        /// Upper corner.
        max: DVec3,
    },
    /// Half space behind a plane.
    Plane {
        /// A point on it.
        point: DVec3,
        /// Outward normal, unit.
        normal: DVec3,
    },
    /// Horizontal slab z_min ≤ z ≤ z_max, unbounded sideways.
    Slab {
        /// Lower plane.
        z_min: f64,
        /// Upper plane.
        z_max: f64,
    },
}
