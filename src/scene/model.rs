//! The checked scene: what a scene file means, all defaults filled in, all units internal
//! (µm, nm, rad, 1/µm; grammage in g/m²).

use crate::law::{Azimuth, Roll, SizeLaw, Tilt};
use crate::lpm::full::Analyser;
use crate::material::{Conversion, RefractiveIndex};
use crate::math::DVec3;
use crate::phase::Phase;
use crate::phase::polarised::Stokes;
use crate::rng::Generator;
use crate::spectrum::Spectrum;
use crate::universe::voxel::{self, Volume};
use crate::universe::{MediumId, Overlap, SurfaceId};
use std::path::PathBuf;
use std::sync::Arc;

/// A whole scene.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name, for titles.
    pub name: String,
    /// The file it was read from.
    pub path: PathBuf,
    /// Materials; [`MediumId`] indexes this list.
    pub materials: Vec<Material>,
    /// Surface laws; [`SurfaceId`] indexes this list, entry 0 is the smooth surface.
    pub surfaces: Vec<Surface>,
    /// Where components are.
    pub universe: Universe,
    /// Light.
    pub source: Source,
    /// Polarisation of the emitted light, if it has one: field angles count from the plane of incidence.
    pub polarised: Option<Stokes>,
    /// Vacuum wavelengths, nm, ascending.
    pub wavelengths: Vec<f64>,
    /// What is measured.
    pub detect: Detect,
    /// Figures of paper optics, if asked for.
    pub optics: Option<PaperOptics>,
    /// How it is run.
    pub run: Run,
    /// Expected values.
    pub expects: Vec<Expect>,
    /// Decisions on effects, applied to what stands above.
    pub overrides: Vec<super::effects::Override>,
    /// Lines of the scene file.
    pub lines: super::effects::Lines,
    /// Warnings found while reading, already rendered with their place.
    pub warnings: Vec<String>,
    /// Every file that the scene is made of (scene, distributions, tables) with its bytes' SHA-like
    /// 64-bit FNV hash, for the manifest.
    pub files: Vec<(PathBuf, u64)>,
}

/// A material (component medium).
#[derive(Clone, Debug)]
pub struct Material {
    /// Identifier in the scene.
    pub id: String,
    /// n(λ) + iκ(λ).
    pub index: RefractiveIndex,
    /// Absorption coefficient beside that of κ, 1/µm.
    pub absorption: Option<Spectrum>,
    /// Subsurface scattering.
    pub scattering: Vec<Scatterer>,
    /// Events that change the wavelength, on the scene's wavelengths.
    pub conversions: Vec<(ConversionKind, Conversion)>,
    /// Sphere Area Partitioning of the scattering; None: the continuous law.
    pub sap: Option<SapSpec>,
}

/// What changes the wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConversionKind {
    /// Absorption and emission by a dye.
    Fluorescence,
    /// A fixed shift down.
    Raman,
    /// A small shift up and down.
    Brillouin,
}

/// One kind of scatterer in a medium.
#[derive(Clone, Debug)]
pub enum Scatterer {
    /// Scattering coefficient and phase function given directly.
    Coefficient {
        /// µs, 1/µm.
        mu_s: Spectrum,
        /// Phase function, the same at every wavelength.
        phase: Phase,
    },
    /// Spheres far apart: Mie theory (Q, g, S11).
    Mie {
        /// Diameter law, µm, weighted by number.
        diameter: SizeLaw,
        /// Index of the particles.
        index: RefractiveIndex,
        /// Particle volume over medium volume.
        volume_fraction: f64,
    },
}

/// How a patch of a SAP gets its ratio.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Populate {
    /// Integral of the density over the patch.
    Exact,
    /// Density at the centre times area, renormalised (the paper's way).
    Centre,
}

/// Direction of the ray that stands for a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Directions {
    /// Centre of the patch (of its visible part where the horizon cuts it): the paper's way.
    Centre,
    /// Drawn from the true density inside the patch: unbiased.
    Density,
    /// Drawn uniformly in the visible part.
    Uniform,
}

/// Frame of a surface SAP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SapFrame {
    /// Populated at normal incidence, turned to the specular direction (the paper's way).
    Rotated,
    /// One SAP per incidence bin in the surface frame.
    Resolved,
}

/// Sphere Area Partitioning of one surface or medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SapSpec {
    /// Granularity, ≥ 1: 12 nside² patches.
    pub nside: u32,
    /// Population.
    pub populate: Populate,
    /// Directions.
    pub directions: Directions,
    /// Frame (surfaces).
    pub frame: SapFrame,
    /// Random roll about the pole (media); false is the paper's fixed roll.
    pub roll_random: bool,
}

/// Slope distribution of a rough surface; `m` is the rms slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slopes {
    /// Beckmann = Gaussian slopes.
    Gaussian,
    /// Exponential slopes.
    Exponential,
    /// GGX (Trowbridge–Reitz); m is its α.
    Ggx,
}

/// Power lost to masked facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MultipleBounce {
    /// Single scatter only; the rest stands in the ledger as `masked`.
    Off,
    /// Divided by the white directional albedo of the same law.
    Renormalised,
    /// Random walk on the microsurface: all bounces.
    Walk,
}

/// Directional behaviour of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SurfaceKind {
    /// Specular.
    Smooth,
    /// Equal radiance in all directions, or (`per_patch`) equal power per patch.
    Lambertian {
        /// The paper's "reflect equally": equal power per SAP patch.
        per_patch: bool,
    },
    /// Microfacets.
    Rough {
        /// Slope law.
        slopes: Slopes,
        /// rms slope (α for GGX).
        m: f64,
        /// Treatment of masked power.
        multiple_bounce: MultipleBounce,
    },
}

/// How much is reflected.
#[derive(Clone, Debug)]
pub enum Ratio {
    /// Fresnel power reflectance of the two media.
    Fresnel,
    /// The paper's curve: |r| in place of |r|² (kept to reproduce its figure 12).
    PaperAmplitude,
    /// Given over wavelength.
    Spectrum(Spectrum),
    /// Fresnel with a thin film between the media (interference).
    Film {
        /// Real index of the film.
        index: f64,
        /// µm.
        thickness: f64,
    },
    /// Given over wavelength (nm, rows) and incidence angle (rad, columns); bilinear.
    Table {
        /// nm, ascending.
        wavelengths: Vec<f64>,
        /// rad, ascending from 0 to π/2.
        angles: Vec<f64>,
        /// Row-major.
        values: Vec<f64>,
    },
}

/// Law of a surface.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Identifier in the scene.
    pub id: String,
    /// Directions.
    pub kind: SurfaceKind,
    /// Reflected share.
    pub ratio: Ratio,
    /// What is not reflected is absorbed at the surface instead of being refracted.
    pub opaque: bool,
    /// Sphere Area Partitioning; None: the continuous law itself.
    pub sap: Option<SapSpec>,
}

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
/// over.
#[derive(Clone, Debug)]
pub struct Realised {
    /// The statistics.
    pub sheet: StatisticalSheet,
    /// Histories of a realisation meet it at random within ± this, µm; `None`: forty mean thicknesses of
    /// its bodies.
    pub spread: Option<f64>,
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

/// An explicit scene.
#[derive(Clone, Debug)]
pub struct Synthetic {
    /// Medium around everything.
    pub ambient: MediumId,
    /// Bodies in the order of the file; later ones win at equal priority.
    pub bodies: Vec<Body>,
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

/// Light source.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// Parallel light; `polar` from the normal, `azimuth` of where it comes from.
    Collimated {
        /// rad.
        polar: f64,
        /// rad.
        azimuth: f64,
        /// Radius of the beam's disc around the origin's normal, µm; 0: a pencil.
        radius: f64,
    },
    /// Lambertian light on the top face (or from a hemisphere), optionally without a polar cone
    /// (gloss trap of a d/0 instrument).
    Diffuse {
        /// Half angle of the dark cone around the normal, rad.
        trap: f64,
    },
    /// A point that emits into a cone.
    Point {
        /// µm.
        position: DVec3,
        /// Point it aims at, µm.
        target: DVec3,
        /// Half angle of the cone, rad; 0: one direction (a pencil), π: isotropic.
        half_angle: f64,
    },
}

/// What is measured beside totals.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Detect {
    /// Angular tally: nside of HEALPix bins.
    pub angular: Option<u32>,
    /// Absorption and fluence over this many depth bins.
    pub depth: Option<u32>,
    /// Checkpoint plane at height z (µm): scores rays with u_z > 0.
    pub checkpoint: Option<f64>,
    /// Mean path and collisions by medium.
    pub path: bool,
    /// Mean time of flight.
    pub time: bool,
    /// Polariser before the detectors.
    pub analyser: Option<Analyser>,
    /// Opening of the glossmeter's window, rad: in and across the plane of incidence (`None`: a circle).
    pub gloss: Option<(f64, Option<f64>)>,
    /// Angle beyond which transmitted light is haze, rad.
    pub haze: Option<f64>,
    /// Lateral spread: radius (µm) and rings.
    pub lateral: Option<(f64, u32)>,
    /// Path-length histograms: longest (µm) and bins.
    pub flight: Option<(f64, u32)>,
    /// Halftone screens.
    pub halftones: Vec<Halftone>,
    /// Scattering matrix in the Klems basis.
    pub klems: bool,
    /// Exact directions by next-event estimation: polar angle and azimuth, rad.
    pub views: Vec<(f64, f64)>,
}

/// A line screen of ink upon the sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Halftone {
    /// Share of the area under ink.
    pub coverage: f64,
    /// Period of the lines, µm.
    pub period: f64,
    /// Transmittance of the ink film for one passage.
    pub ink: f64,
}

/// Geometry of a reflectance factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpticsGeometry {
    /// d/0: diffuse light, view at 0°.
    DiffuseNormal,
    /// 0/d: light from 0°, all that leaves outside the gloss trap.
    NormalDiffuse,
    /// 45/0: light from 45°, view at 0°.
    FortyFiveNormal,
    /// 8/d: light from 8°, all that leaves outside the trap, if there is one.
    EightDiffuse,
    /// Light as the source says, all reflected power counted.
    Total,
}

impl OpticsGeometry {
    /// The word of the scene.
    pub fn word(self) -> &'static str {
        match self {
            Self::DiffuseNormal => "d/0",
            Self::NormalDiffuse => "0/d",
            Self::FortyFiveNormal => "45/0",
            Self::EightDiffuse => "8/d",
            Self::Total => "total",
        }
    }

    /// Polar angle of the parallel light that the geometry asks for, rad.
    pub fn polar(self) -> Option<f64> {
        let degrees = match self {
            Self::NormalDiffuse => 0.0,
            Self::FortyFiveNormal => 45.0,
            Self::EightDiffuse => 8.0,
            Self::DiffuseNormal | Self::Total => return None,
        };
        Some(degrees * crate::math::PI / 180.0)
    }
}

/// Figures of paper optics.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperOptics {
    /// How the reflectance factor is measured.
    pub geometry: OpticsGeometry,
    /// Half angle of the viewing cone for d/0 and 45/0, rad.
    pub view: f64,
    /// Half angle of the gloss trap for 0/d and 8/d, rad; 0: none.
    pub trap: f64,
    /// Reflectance of the backing below an air gap, instead of the pile.
    pub backing: Option<f64>,
    /// Most sheets in the simulated pile.
    pub pile: u32,
    /// Grammage for s and k, g/m²; None: that of the sheet.
    pub grammage: Option<f64>,
}

/// Branching.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Branching {
    /// One outgoing ray per event.
    Sample,
    /// One ray per patch above a power floor; roulette below.
    Split {
        /// Granularity of the split.
        nside: u32,
        /// Power floor relative to the emitted power.
        floor: f64,
    },
}

/// How a scene is run.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Histories per wavelength group.
    pub histories: u64,
    /// Seed.
    pub seed: u64,
    /// Branching.
    pub branching: Branching,
    /// Roulette starts below this share of the start power.
    pub roulette: f64,
    /// Guard on events per history.
    pub event_cap: u64,
    /// Histories that share one realisation.
    pub shared: u64,
    /// Wavelengths whose scattering differs may go together by weights.
    pub weights: bool,
    /// Implicit capture (true) or analog absorption.
    pub implicit_capture: bool,
    /// Family of the generator.
    pub generator: Generator,
}

/// An expected figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Expect {
    /// Name as in `result.json`.
    pub quantity: String,
    /// Wavelength, nm, if the figure has one.
    pub wavelength: Option<f64>,
    /// Component, if the figure has one.
    pub component: Option<String>,
    /// Value.
    pub value: f64,
    /// Absolute tolerance, beside 4 standard errors.
    pub error: f64,
    /// Where it comes from.
    pub source: String,
}
