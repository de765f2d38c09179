//! The checked scene: what a scene file means, all defaults filled in, all units internal
//! (µm, nm, rad, 1/µm; grammage in g/m²).

mod materials;
mod universe;

pub use materials::*;
pub use universe::*;

use crate::lpm::full::Analyser;
use crate::math::DVec3;
use crate::phase::polarised::Stokes;
use crate::rng::Generator;
use std::path::PathBuf;

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

/// Histories of a batch.
pub const BATCH: u64 = 4096;

/// How a scene is run.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Histories per wavelength group.
    pub histories: u64,
    /// Seed.
    pub seed: u64,
    /// Histories of a batch: [`BATCH`], or fewer in studies of costly scenes. Histories stay the same; what
    /// is added up together changes.
    pub batch: u64,
    /// Branching.
    pub branching: Branching,
    /// Roulette starts below this share of the start power.
    pub roulette: f64,
    /// Guard on events per history.
    pub event_cap: u64,
    /// Histories that share one realisation.
    pub shared: u64,
    /// Wavelengths whose scattering differs go together by weights; `None`: where that pays.
    pub weights: Option<bool>,
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
