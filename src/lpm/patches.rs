//! Sphere Area Partitioning at work (paper 3.3): subsurface and surface events over patches.

use super::ledger::{Ledger, add};
use super::light::MediumSap;
use super::surface::{Directions, Fate, Meeting, SurfaceLaw};
use crate::material::fresnel;
use crate::math::{DVec3, Frame, sin_cos};
use crate::microfacet::{Masking, Microfacet};
use crate::phase::Phase;
use crate::rng::Stream;
use crate::sap::{
    Half, Healpix, Peak, Population, Sap, SapDirections, SapError, estimated_bounds, frame_medium,
    frame_specular, frame_surface, populate_centre, populate_exact_peaks,
};
use std::sync::OnceLock;

/// What a SAP is asked to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SapRule {
    /// Granularity.
    pub nside: u32,
    /// Population by the integral over each patch; else density at the centre times area (the paper).
    pub exact: bool,
    /// Direction that stands for a patch.
    pub directions: SapDirections,
    /// Surfaces: one SAP per incidence bin in the surface frame; else populated at normal incidence and
    /// turned to the specular direction (the paper).
    pub resolved: bool,
    /// Media: roll drawn for each event.
    pub roll_random: bool,
}

/// Largest quadrature error of a patch's share.
const TOLERANCE: f64 = 1e-9;

fn populated(
    hp: &Healpix,
    rule: &SapRule,
    half: Option<Half>,
    width: f64,
    density: &dyn Fn(DVec3) -> f64,
) -> Population {
    if rule.exact {
        populate_exact_peaks(hp, density, half, TOLERANCE, &[Peak { direction: DVec3::Z, width }])
    } else {
        populate_centre(hp, density, half)
    }
}

impl MediumSap {
    /// The SAP of a phase function: pole along the forward direction.
    ///
    /// # Errors
    /// A granularity out of range, or a phase function whose density vanishes at every centre.
    pub fn new(phase: &Phase, rule: &SapRule) -> Result<Self, SapError> {
        let hp = Healpix::new(rule.nside)?;
        let density = |u: DVec3| phase.pdf(u.z);
        let width = (1.0 - phase.mean_cosine()).max(1e-6);
        let shares = populated(&hp, rule, None, width, &density).shares;
        let bounds = (0..hp.npix())
            .map(|p| {
                let (lo, hi) = hp.z_range(p);
                phase.max_on(lo, hi) * (1.0 + 1e-9)
            })
            .collect();
        let sap = Sap::new(hp, &shares, None)?.with_bounds(bounds, &density)?;
        Ok(MediumSap { sap, directions: rule.directions, roll_random: rule.roll_random })
    }

    /// Frame about the forward direction.
    pub fn frame(&self, forward: DVec3, rng: &mut Stream) -> Frame {
        frame_medium(forward, self.roll_random.then(|| rng.uniform()))
    }

    /// Draws a patch and its direction.
    pub fn scatter(&self, phase: &Phase, forward: DVec3, rng: &mut Stream) -> DVec3 {
        let frame = self.frame(forward, rng);
        let patch = self.sap.draw(rng);
        frame.to_world(self.sap.direction(patch, self.directions, rng, |u| phase.pdf(u.z)))
    }
}

/// SAPs of a surface: one whole sphere for reflection, one for refraction.
#[derive(Debug)]
pub struct SurfaceSap {
    rule: SapRule,
    /// Standing (Lambertian) or populated at normal incidence and turned.
    reflected: Option<Sap>,
    /// Turned, for refraction: one per relative index that the scene holds.
    refracted: Vec<(f64, OnceLock<Sap>)>,
    /// Resolved: one per incidence bin, with its white directional albedo, made when first asked for.
    bins: Vec<OnceLock<(Sap, f64)>>,
}

/// Incidence bins of a resolved SAP over 0…90°.
const BINS: usize = 45;

impl SurfaceSap {
    /// SAPs for `directions`; `etas` are the relative indices N2/N1 that the surface may meet.
    ///
    /// # Errors
    /// A granularity out of range.
    pub fn new(directions: &Directions, rule: SapRule, etas: &[f64]) -> Result<Self, SapError> {
        let hp = Healpix::new(rule.nside)?;
        let mut sap = SurfaceSap { rule, reflected: None, refracted: Vec::new(), bins: Vec::new() };
        match directions {
            Directions::Facets { .. } if rule.resolved => {
                sap.bins = (0..=BINS).map(|_| OnceLock::new()).collect();
            }
            Directions::Facets { law, .. } => {
                let density = |o: DVec3| law.reflected_density(DVec3::Z, o, Masking::Separable);
                sap.reflected = Some(upper(&hp, &rule, law.m(), &density)?);
                sap.refracted = etas.iter().map(|&eta| (eta, OnceLock::new())).collect();
            }
            _ => sap.reflected = Some(upper(&hp, &rule, 1.0, &|o| standing_density(directions, o))?),
        }
        Ok(sap)
    }

    /// One SAP per incidence bin.
    pub fn is_resolved(&self) -> bool {
        !self.bins.is_empty()
    }

    /// Frame and SAP of the reflected side, with the density that populated it.
    pub fn reflected<const N: usize>(&self, m: &Meeting<N>) -> (Frame, &Sap) {
        let sap = self.reflected.as_ref().unwrap_or_else(|| unreachable!("resolved SAPs are drawn as such"));
        let n = m.at.normal;
        let frame = if self.refracted.is_empty() {
            frame_surface(n, m.dir, m.at.axis)
        } else {
            frame_specular(fresnel::reflect(m.dir, n), n, m.at.axis)
        };
        (frame, sap)
    }

    /// A direction of the reflected side.
    pub fn draw_reflected<const N: usize>(
        &self,
        law: &SurfaceLaw<N>,
        m: &Meeting<N>,
        rng: &mut Stream,
    ) -> DVec3 {
        let (frame, sap) = self.reflected(m);
        let density = |o: DVec3| reflected_density(&law.directions, o);
        sap.draw_visible(&frame, m.at.normal, self.rule.directions, rng, density)
            .map_or_else(|| fresnel::reflect(m.dir, m.at.normal), |(_, dir)| dir)
    }

    /// Frame, SAP and relative index of the refracted side for the specular refraction `specular`.
    pub fn refracted<'a, const N: usize>(
        &'a self,
        law: &SurfaceLaw<N>,
        m: &Meeting<N>,
        specular: DVec3,
    ) -> Option<(Frame, &'a Sap, f64)> {
        let n = -m.at.normal;
        let eta = m.beyond.n.re / m.here.n.re;
        let Directions::Facets { law: facets, .. } = &law.directions else {
            // Lambertian: the same standing SAP about the other side's normal.
            return self.reflected.as_ref().map(|s| (frame_surface(n, m.dir, m.at.axis), s, eta));
        };
        let (_, slot) = self.refracted.iter().find(|(e, _)| *e == eta)?;
        let sap = slot.get_or_init(|| refraction_sap(facets, eta, &self.rule));
        Some((frame_specular(specular, n, m.at.axis), sap, eta))
    }

    /// A direction beyond; `None` where the specular one is not real.
    pub fn draw_refracted<const N: usize>(
        &self,
        law: &SurfaceLaw<N>,
        m: &Meeting<N>,
        rng: &mut Stream,
    ) -> Option<DVec3> {
        let specular = super::surface::snell(m)?;
        let Some((frame, sap, eta)) = self.refracted(law, m, specular) else { return Some(specular) };
        let density = |o: DVec3| refracted_density(&law.directions, o, eta);
        sap.draw_visible(&frame, -m.at.normal, self.rule.directions, rng, density)
            .map_or(Some(specular), |(_, dir)| Some(dir))
    }

    /// The frame, the SAP of the (randomly chosen) nearest incidence bin, its white albedo and its
    /// incidence: bins mix by linear interpolation.
    pub fn resolved<const N: usize>(
        &self,
        facets: &Microfacet,
        m: &Meeting<N>,
        rng: &mut Stream,
    ) -> (Frame, &Sap, f64, DVec3) {
        let x = crate::math::acos(m.cos_i()) / crate::math::FRAC_PI_2 * BINS as f64;
        let lower = (x as usize).min(BINS - 1);
        let bin = lower + usize::from(rng.uniform() < x - lower as f64);
        let i = incidence(bin);
        let (sap, albedo) = self.bins[bin].get_or_init(|| {
            let hp = Healpix::new(self.rule.nside).unwrap_or_else(|_| unreachable!("checked in new"));
            let density = |o: DVec3| facets.reflected_density(i, o, Masking::Separable);
            let sap = upper(&hp, &self.rule, facets.m(), &density)
                .unwrap_or_else(|e| unreachable!("a facet law has power in every bin: {e}"));
            (sap, facets.directional_albedo_white(i.z, Masking::Separable))
        });
        (frame_surface(m.at.normal, m.dir, m.at.axis), sap, *albedo, i)
    }

    /// Draws from the SAP of the incidence bin; Fresnel at the facet angle decides reflection or
    /// refraction.
    pub fn draw_resolved<const N: usize>(
        &self,
        law: &SurfaceLaw<N>,
        m: &Meeting<N>,
        power: &mut [f64; N],
        ledger: &mut Ledger<N>,
        rng: &mut Stream,
    ) -> Fate<N> {
        let Directions::Facets { law: facets, renormalised } = &law.directions else {
            unreachable!("only facets are resolved");
        };
        let (frame, sap, albedo, bin_i) = self.resolved(facets, m, rng);
        let patch = sap.draw(rng);
        let density = |o: DVec3| facets.reflected_density(bin_i, o, Masking::Separable);
        let out = sap.direction(patch, self.rule.directions, rng, density);
        if !renormalised {
            let masked = power.map(|p| p * (1.0 - albedo));
            for (p, l) in power.iter_mut().zip(&masked) {
                *p -= l;
            }
            add(&mut ledger.masked, &masked);
        }
        let i = frame.to_local(-m.dir);
        law.by_half_vector(m, &frame, i, out, power, ledger, rng)
    }

    /// What it was asked to be.
    pub fn rule(&self) -> SapRule {
        self.rule
    }

    /// How directions inside a patch are chosen.
    pub fn directions(&self) -> SapDirections {
        self.rule.directions
    }
}

/// Incidence direction of a bin, local frame (x towards where light comes from).
fn incidence(bin: usize) -> DVec3 {
    let theta = (bin as f64 / BINS as f64).min(0.999) * crate::math::FRAC_PI_2;
    let (s, c) = sin_cos(theta);
    DVec3::new(s, 0.0, c)
}

/// A SAP on the upper half sphere.
fn upper(hp: &Healpix, rule: &SapRule, width: f64, density: &dyn Fn(DVec3) -> f64) -> Result<Sap, SapError> {
    let half = Some(Half::Upper);
    let shares = populated(hp, rule, half, width.min(1.0), density).shares;
    let sap = Sap::new(*hp, &shares, half)?;
    if rule.directions == SapDirections::Density {
        sap.with_bounds(estimated_bounds(hp, density, half), density)
    } else {
        Ok(sap)
    }
}

fn refraction_sap(facets: &Microfacet, eta: f64, rule: &SapRule) -> Sap {
    let hp = Healpix::new(rule.nside).unwrap_or_else(|_| unreachable!("checked in new"));
    let density = |o: DVec3| facets.transmitted_density(DVec3::Z, DVec3::new(o.x, o.y, -o.z), eta);
    // A relative index near 1 sharpens the lobe by |η − 1|.
    let width = facets.m() * (eta - 1.0).abs().max(1e-3);
    upper(&hp, rule, width, &density).unwrap_or_else(|e| unreachable!("a facet law refracts: {e}"))
}

/// Density of the standing SAPs of Lambertian surfaces.
fn standing_density(directions: &Directions, o: DVec3) -> f64 {
    match directions {
        Directions::PerPatch => 0.5 / crate::math::PI,
        _ => o.z.max(0.0) / crate::math::PI,
    }
}

/// Local density of the reflected SAP.
pub fn reflected_density(directions: &Directions, o: DVec3) -> f64 {
    match directions {
        Directions::Facets { law, .. } => law.reflected_density(DVec3::Z, o, Masking::Separable),
        other => standing_density(other, o),
    }
}

/// Local density of the refracted SAP.
pub fn refracted_density(directions: &Directions, o: DVec3, eta: f64) -> f64 {
    match directions {
        Directions::Facets { law, .. } => law.transmitted_density(DVec3::Z, DVec3::new(o.x, o.y, -o.z), eta),
        other => standing_density(other, o),
    }
}
