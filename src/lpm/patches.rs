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
    peak: Peak,
    density: &dyn Fn(DVec3) -> f64,
) -> Population {
    if rule.exact {
        populate_exact_peaks(hp, density, half, TOLERANCE, &[peak])
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
        let peak = Peak { direction: DVec3::Z, width };
        let shares = populated(&hp, rule, None, peak, &density).shares;
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
    /// Resolved reflection: one per incidence bin, made when first asked for.
    bins: Vec<OnceLock<Lobe>>,
    /// Resolved refraction: per relative index, one per incidence bin; `None` where nothing passes.
    refracted_bins: Vec<(f64, Vec<OnceLock<Option<Lobe>>>)>,
}

/// A SAP of one incidence bin and the share of white light that it holds.
#[derive(Debug)]
pub struct Lobe {
    /// Directions; those of refraction are mirrored to the upper half sphere.
    pub sap: Sap,
    /// Directional albedo for facets that reflect (or refract) everything.
    pub albedo: f64,
}

/// What a resolved surface offers a ray.
#[derive(Debug)]
pub struct Resolved<'a> {
    /// Surface frame, x towards where the light comes from.
    pub frame: Frame,
    /// Incidence of the bin, local, pointing back to the light.
    pub incidence: DVec3,
    /// Reflected side.
    pub reflected: &'a Lobe,
    /// Refracted side.
    pub refracted: Option<&'a Lobe>,
    /// N2/N1.
    pub eta: f64,
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
        let mut sap = SurfaceSap {
            rule,
            reflected: None,
            refracted: Vec::new(),
            bins: Vec::new(),
            refracted_bins: Vec::new(),
        };
        match directions {
            Directions::Facets { .. } if rule.resolved => {
                sap.bins = (0..=BINS).map(|_| OnceLock::new()).collect();
                let empty = || (0..=BINS).map(|_| OnceLock::new()).collect();
                sap.refracted_bins = etas.iter().map(|&eta| (eta, empty())).collect();
            }
            Directions::Facets { law, .. } => {
                let density = |o: DVec3| law.reflected_density(DVec3::Z, o, Masking::Separable);
                sap.reflected = Some(upper(&hp, &rule, pole(law.m()), &density)?);
                sap.refracted = etas.iter().map(|&eta| (eta, OnceLock::new())).collect();
            }
            _ => sap.reflected = Some(upper(&hp, &rule, pole(1.0), &|o| standing_density(directions, o))?),
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

    /// The SAPs of the (randomly chosen) neighbouring incidence bin: bins mix by linear interpolation.
    pub fn resolved<const N: usize>(
        &self,
        facets: &Microfacet,
        m: &Meeting<N>,
        rng: &mut Stream,
    ) -> Resolved<'_> {
        let x = crate::math::acos(m.cos_i()) / crate::math::FRAC_PI_2 * BINS as f64;
        let lower = (x as usize).min(BINS - 1);
        let bin = lower + usize::from(rng.uniform() < x - lower as f64);
        let eta = m.beyond.n.re / m.here.n.re;
        let slots = self.refracted_bins.iter().find(|(e, _)| *e == eta).map(|(_, slots)| slots);
        Resolved {
            frame: frame_surface(m.at.normal, m.dir, m.at.axis),
            incidence: incidence(bin),
            reflected: self.bins[bin].get_or_init(|| reflection_lobe(facets, bin, &self.rule)),
            refracted: slots
                .and_then(|s| s[bin].get_or_init(|| refraction_lobe(facets, bin, eta, &self.rule)).as_ref()),
            eta,
        }
    }

    /// Draws from the SAPs of the incidence bin; Fresnel at the facet angle decides reflection or
    /// refraction, so that the tables do not depend on wavelength.
    ///
    /// A dielectric's side is drawn with the mean plane's reflectance q (kept within 0.1…0.9), a patch
    /// of that side by its white share, and the power carries albedo × F/q, or × (1 − F)/(1 − q):
    /// what it differs from 1 is booked as masked, whose mean is the power that masking removes.
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
        let met = self.resolved(facets, m, rng);
        let whole = if *renormalised { met.reflected.albedo } else { 1.0 };
        if law.opaque || !fresnel::weakly_absorbing(m.beyond.n) {
            weigh(power, met.reflected.albedo / whole, ledger);
            let out = self.reflected_out(facets, &met, rng);
            return law.by_half_vector(m, &met.frame, met.incidence, out, power, ledger, rng);
        }
        let q = law.reflectance(m.here, m.beyond, m.cos_i())[0].clamp(0.1, 0.9);
        if rng.uniform() < q {
            let out = self.reflected_out(facets, &met, rng);
            let f = law.reflectance(m.here, m.beyond, facet_cosine(met.incidence, out, 1.0))[0];
            weigh(power, met.reflected.albedo * f / (q * whole), ledger);
            return Fate::Reflected { dir: met.frame.to_world(out), absorbed: None };
        }
        let Some(lobe) = met.refracted else { return Fate::Masked };
        let out = self.refracted_out(facets, &met, lobe, lobe.sap.draw(rng), rng);
        let f = law.reflectance(m.here, m.beyond, facet_cosine(met.incidence, out, met.eta))[0];
        weigh(power, lobe.albedo * (1.0 - f) / ((1.0 - q) * whole), ledger);
        Fate::Refracted { dir: met.frame.to_world(out) }
    }

    fn reflected_out(&self, facets: &Microfacet, met: &Resolved, rng: &mut Stream) -> DVec3 {
        let patch = met.reflected.sap.draw(rng);
        let density = |o: DVec3| facets.reflected_density(met.incidence, o, Masking::Separable);
        met.reflected.sap.direction(patch, self.rule.directions, rng, density)
    }

    /// Direction (local, downwards) that stands for a patch of the refracted lobe.
    pub fn refracted_out(
        &self,
        facets: &Microfacet,
        met: &Resolved,
        lobe: &Lobe,
        patch: usize,
        rng: &mut Stream,
    ) -> DVec3 {
        let density = |o: DVec3| facets.transmitted_density(met.incidence, mirrored(o), met.eta);
        mirrored(lobe.sap.direction(patch, self.rule.directions, rng, density))
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

/// Multiplies the power; the difference is booked as masked.
fn weigh<const N: usize>(power: &mut [f64; N], weight: f64, ledger: &mut Ledger<N>) {
    let before = *power;
    for p in power.iter_mut() {
        *p *= weight;
    }
    let masked = std::array::from_fn(|k| before[k] - power[k]);
    add(&mut ledger.masked, &masked);
}

/// The direction on the other side of the plane.
fn mirrored(o: DVec3) -> DVec3 {
    DVec3::new(o.x, o.y, -o.z)
}

/// Cosine of incidence at the facet that turns `i` into `out`: its normal is along i + η o, η = 1 for
/// reflection.
pub fn facet_cosine(i: DVec3, out: DVec3, eta: f64) -> f64 {
    i.dot((i + out * eta).normalize_or(DVec3::Z)).abs().min(1.0)
}

fn reflection_lobe(facets: &Microfacet, bin: usize, rule: &SapRule) -> Lobe {
    let i = incidence(bin);
    let hp = Healpix::new(rule.nside).unwrap_or_else(|_| unreachable!("checked in new"));
    let density = |o: DVec3| facets.reflected_density(i, o, Masking::Separable);
    let peak = Peak { direction: DVec3::new(-i.x, 0.0, i.z), width: facets.m().min(1.0) };
    let sap = upper(&hp, rule, peak, &density)
        .unwrap_or_else(|e| unreachable!("a facet law has power in every bin: {e}"));
    Lobe { sap, albedo: facets.directional_albedo_white(i.z, Masking::Separable) }
}

/// `None` where nothing passes (total reflection at every facet, or no step of the index).
fn refraction_lobe(facets: &Microfacet, bin: usize, eta: f64, rule: &SapRule) -> Option<Lobe> {
    let i = incidence(bin);
    let hp = Healpix::new(rule.nside).unwrap_or_else(|_| unreachable!("checked in new"));
    let density = |o: DVec3| facets.transmitted_density(i, mirrored(o), eta);
    let sin = (i.x / eta).min(1.0);
    let width = (facets.m() * (eta - 1.0).abs() / eta).clamp(1e-3, 1.0);
    let peak = Peak { direction: DVec3::new(-sin, 0.0, (1.0 - sin * sin).sqrt()), width };
    let exact = populate_exact_peaks(&hp, &density, Some(Half::Upper), TOLERANCE, &[peak]);
    let sap = upper(&hp, rule, peak, &density).ok()?;
    Some(Lobe { sap, albedo: exact.sum })
}

/// Incidence direction of a bin, local frame (x towards where light comes from).
fn incidence(bin: usize) -> DVec3 {
    let theta = (bin as f64 / BINS as f64).min(0.999) * crate::math::FRAC_PI_2;
    let (s, c) = sin_cos(theta);
    DVec3::new(s, 0.0, c)
}

/// A lobe about the pole.
fn pole(width: f64) -> Peak {
    Peak { direction: DVec3::Z, width: width.min(1.0) }
}

/// A SAP on the upper half sphere.
fn upper(hp: &Healpix, rule: &SapRule, peak: Peak, density: &dyn Fn(DVec3) -> f64) -> Result<Sap, SapError> {
    let half = Some(Half::Upper);
    let shares = populated(hp, rule, half, peak, density).shares;
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
    upper(&hp, rule, pole(width), &density).unwrap_or_else(|e| unreachable!("a facet law refracts: {e}"))
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
        Directions::Facets { law, .. } | Directions::Walk(law) => {
            law.reflected_density(DVec3::Z, o, Masking::Separable)
        }
        other => standing_density(other, o),
    }
}

/// Local density of the refracted SAP.
pub fn refracted_density(directions: &Directions, o: DVec3, eta: f64) -> f64 {
    match directions {
        Directions::Facets { law, .. } | Directions::Walk(law) => {
            law.transmitted_density(DVec3::Z, DVec3::new(o.x, o.y, -o.z), eta)
        }
        other => standing_density(other, o),
    }
}
