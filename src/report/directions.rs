//! Where the light goes: patches of the angular tally with their geometry, and the files that other
//! tools read from them.

use super::csv::{AngularRow, table};
use super::plot::Patch;
use crate::math::{DVec3, PI, acos, atan2};
use crate::run::simulate::GroupResult;
use crate::sap::{Half, Healpix};
use crate::scene::{Scene, Source};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Geometry of one patch in one half space.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchGeometry {
    /// HEALPix RING index.
    pub pix: usize,
    /// Half space.
    pub half: Half,
    /// Polar angle of its middle from the upward normal, degrees.
    pub polar_deg: f64,
    /// Azimuth of its middle from the mirror direction, degrees.
    pub azimuth_deg: f64,
    /// Solid angle, sr.
    pub area: f64,
    /// ∫ |cos θ| dω over it, sr; the patches of a half space sum to π.
    pub projected: f64,
    /// Boundary as (polar, azimuth) in degrees.
    pub outline: Vec<(f64, f64)>,
}

/// Patches of a tally of directions.
#[derive(Clone, Debug)]
pub struct Directions {
    /// Upwards first, then (where they are counted) downwards; patches on the horizon have a part in each.
    pub patches: Vec<PatchGeometry>,
    /// First cell of the upper and of the lower half.
    starts: Vec<usize>,
    /// Polar angle of incidence, degrees, of parallel light.
    pub incidence_deg: Option<f64>,
}

/// Polar angle and azimuth of where the light comes from, rad; diffuse light has no angle.
fn incidence(source: &Source) -> (Option<f64>, f64) {
    match *source {
        Source::Collimated { polar, azimuth, .. } => (Some(polar), azimuth),
        Source::Point { position, target, .. } => {
            let d: DVec3 = (position - target).normalize();
            let azimuth = if d.x == 0.0 && d.y == 0.0 { 0.0 } else { atan2(d.y, d.x) };
            (Some(acos(d.z)), azimuth)
        }
        Source::Diffuse { .. } => (None, PI),
    }
}

fn degrees(x: f64) -> f64 {
    x * 180.0 / PI
}

impl Directions {
    /// The patches of `cells` over `hp`. Azimuths count from the mirror direction: light from 180°.
    pub fn new(scene: &Scene, hp: &Healpix, cells: Range<usize>) -> Self {
        let (polar, azimuth) = incidence(&scene.source);
        let turn = azimuth + PI;
        let angles = |d: DVec3| {
            let azimuth = degrees(atan2(d.y, d.x) - turn);
            (degrees(acos(d.z)), azimuth - 360.0 * (azimuth / 360.0).floor())
        };
        let starts: Vec<usize> = cells.step_by(hp.npix()).collect();
        let mut patches = Vec::new();
        for half in [Half::Upper, Half::Lower].into_iter().take(starts.len()) {
            let first = patches.len();
            for pix in 0..hp.npix() {
                let area = hp.area() * hp.share_in(pix, Some(half));
                if area == 0.0 {
                    continue;
                }
                let (polar_deg, azimuth_deg) = angles(hp.representative(pix, Some(half)));
                patches.push(PatchGeometry {
                    pix,
                    half,
                    polar_deg,
                    azimuth_deg,
                    area,
                    projected: projected(hp, pix, half),
                    outline: hp.boundaries(pix, 6).into_iter().map(angles).collect(),
                });
            }
            // The sum over a half space is π: what is left of the quadrature's error is spread evenly.
            let sum: f64 = patches[first..].iter().map(|p| p.projected).sum();
            patches[first..].iter_mut().for_each(|p| p.projected *= PI / sum);
        }
        Directions { patches, starts, incidence_deg: polar.map(degrees) }
    }

    /// The directions of what leaves, if the run has counted them.
    pub fn leaving(scene: &Scene, group: &GroupResult) -> Option<Self> {
        let hp = group.layout.angular.as_ref()?;
        Some(Directions::new(scene, hp, group.layout.angular_range()))
    }

    /// Power and standard error in every patch, per emitted power.
    pub fn powers(&self, group: &GroupResult, lane: usize) -> Vec<(f64, f64)> {
        let cell = |p: &PatchGeometry| self.starts[usize::from(p.half == Half::Lower)] + p.pix;
        let of = |p: &PatchGeometry| {
            let m = group.moments(cell(p), lane);
            (m.mean(), m.standard_error())
        };
        self.patches.iter().map(of).collect()
    }

    /// Patches for plots: intensity, 1/sr.
    pub fn plotted(&self, group: &GroupResult, lane: usize) -> Vec<Patch> {
        let patch = |(p, (power, error)): (&PatchGeometry, (f64, f64))| Patch {
            patch: p.pix as u64,
            polar_deg: p.polar_deg,
            azimuth_deg: p.azimuth_deg,
            solid_angle_sr: p.area,
            value: power / p.area,
            error: error / p.area,
            outline: p.outline.clone(),
        };
        self.patches.iter().zip(self.powers(group, lane)).map(patch).collect()
    }
}

/// ∫ |cos θ| dω over the part of a patch in `half`, by 32² points.
fn projected(hp: &Healpix, pix: usize, half: Half) -> f64 {
    const SIDE: usize = 32;
    let up = if half == Half::Upper { 1.0 } else { -1.0 };
    let sum: f64 = hp.subdivide(pix, SIDE).map(|d| (up * d.z).max(0.0)).sum();
    hp.area() * sum / (SIDE * SIDE) as f64
}

/// Rows of `angular.csv`.
pub fn angular_csv(patches: &[Patch]) -> String {
    let row = |p: &Patch| AngularRow {
        patch: p.patch,
        polar_deg: p.polar_deg,
        azimuth_deg: p.azimuth_deg,
        solid_angle_sr: p.solid_angle_sr,
        value_per_sr: p.value,
        error_per_sr: p.error,
    };
    table(&patches.iter().map(row).collect::<Vec<_>>())
}

/// One value of a BRDF or BTDF.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BsdfRow {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Polar angle of incidence, degrees; empty: diffuse light.
    pub incidence_deg: Option<f64>,
    /// `brdf` or `btdf`.
    pub kind: String,
    /// HEALPix RING index.
    pub patch: u64,
    /// Polar angle of the patch's middle from the upward normal, degrees.
    pub polar_deg: f64,
    /// Azimuth of it from the mirror direction, degrees.
    pub azimuth_deg: f64,
    /// f = dL/dE, mean over the patch weighted with cos θ, 1/sr.
    pub f_per_sr: f64,
    /// Standard error, 1/sr.
    pub error_per_sr: f64,
    /// Radiance factor β = π f.
    pub radiance_factor: f64,
}

/// Rows of `brdf.csv` at one wavelength: f = P/∫|cos θ| dω of every patch, P the share of the incident power
/// that leaves through it (the mean of dL/dE over the patch, weighted with cos θ).
pub fn bsdf_rows(d: &Directions, group: &GroupResult, lane: usize) -> Vec<BsdfRow> {
    let nm = group.wavelengths[lane];
    let row = |(p, (power, error)): (&PatchGeometry, (f64, f64))| BsdfRow {
        wavelength_nm: nm,
        incidence_deg: d.incidence_deg,
        kind: if p.half == Half::Upper { "brdf" } else { "btdf" }.to_owned(),
        patch: p.pix as u64,
        polar_deg: p.polar_deg,
        azimuth_deg: p.azimuth_deg,
        f_per_sr: power / p.projected,
        error_per_sr: error / p.projected,
        radiance_factor: PI * power / p.projected,
    };
    d.patches.iter().zip(d.powers(group, lane)).map(row).collect()
}
