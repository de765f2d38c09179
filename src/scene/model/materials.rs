//! Media and surfaces of a scene.

use crate::law::SizeLaw;
use crate::material::{Conversion, RefractiveIndex};
use crate::phase::Phase;
use crate::spectrum::Spectrum;

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

/// Shape of particles that scatter by Mie theory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParticleShape {
    /// Spheres.
    Sphere,
    /// Circular cylinders without end, axes in all directions.
    Fibril,
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
    /// Spheres or fibrils far apart: Mie theory (Q, g, S11).
    Mie {
        /// Spheres, or cylinders without end.
        shape: ParticleShape,
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
