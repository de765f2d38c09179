//! Effects: which steps of the life of light a scene calls for, with the line that does, why the others
//! are off, and what a person overrides with a reason.
//!
//! Forcing an effect off takes out of the checked scene what calls for it; forcing one on puts in the
//! neutral parameter with which it changes nothing (`tests/effects.rs` holds the two together).

use super::model::{self, Branching, ConversionKind, Ratio, Scatterer, Scene, SurfaceKind};
use crate::material::{absorption_from_k, fresnel::weakly_absorbing};
use crate::phase::Phase;
use crate::spectrum::{Spectrum, Table};
use std::collections::BTreeMap;

/// Lines of the scene file by what stands there ("material wall", "surface coat", "source" …).
pub type Lines = BTreeMap<String, usize>;

/// One effect: simulated or not, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Effect {
    /// Name.
    pub name: &'static str,
    /// Simulated.
    pub on: bool,
    /// What calls for it, or why nothing does.
    pub reason: String,
    /// Somebody decided otherwise than the scene: the reason given.
    pub forced: Option<String>,
}

/// A person's decision on an effect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    /// Effect.
    pub kind: Kind,
    /// On or off.
    pub on: bool,
    /// Why.
    pub reason: String,
    /// What in the scene had called for it.
    pub called: Vec<String>,
    /// Decided on the command line, not in the scene.
    pub flag: bool,
}

impl std::fmt::Display for Override {
    /// As on the command line.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}:{}", self.kind.id(), if self.on { "on" } else { "off" }, self.reason)
    }
}

impl Override {
    /// `name=on:reason` or `name=off:reason`, as on the command line.
    ///
    /// # Errors
    /// What is missing or unknown.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (name, rest) = text.split_once('=').ok_or("expected NAME=on:REASON or NAME=off:REASON")?;
        let (state, reason) = rest.split_once(':').unwrap_or((rest, ""));
        let kind = Kind::of(name.trim()).ok_or_else(|| {
            let ids: Vec<String> = Kind::ALL.iter().map(|k| k.id()).collect();
            format!("no effect is called '{}'; there are {}", name.trim(), ids.join(", "))
        })?;
        let on = match state.trim() {
            "on" => true,
            "off" => false,
            other => return Err(format!("an effect is 'on' or 'off', not '{other}'")),
        };
        if reason.trim().is_empty() {
            return Err(format!("an override needs its reason: {name}={state}:REASON"));
        }
        Ok(Override { kind, on, reason: reason.trim().to_owned(), called: Vec::new(), flag: true })
    }
}

/// The effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Power left behind along the path.
    Absorption,
    /// Reflection and refraction where indices differ.
    Fresnel,
    /// n(λ) turns rays.
    Dispersion,
    /// Facets.
    Rough,
    /// Totally diffuse surfaces.
    Lambertian,
    /// Scattering inside media.
    Subsurface,
    /// Sphere Area Partitioning.
    Sap,
    /// Stokes parameters through surfaces and scattering.
    Polarisation,
    /// Dyes that emit what they absorb at longer wavelengths.
    Fluorescence,
    /// Raman and Brillouin scattering.
    Shifts,
    /// Interference in films on surfaces.
    Films,
    /// Light that goes on between the facets of rough surfaces.
    Bounces,
    /// Time of flight.
    Time,
}

impl Kind {
    /// All, in the order of the plan.
    pub const ALL: &'static [Kind] = &[
        Kind::Absorption,
        Kind::Fresnel,
        Kind::Dispersion,
        Kind::Rough,
        Kind::Lambertian,
        Kind::Subsurface,
        Kind::Sap,
        Kind::Polarisation,
        Kind::Fluorescence,
        Kind::Shifts,
        Kind::Films,
        Kind::Bounces,
        Kind::Time,
    ];

    /// Name in plans and results.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Absorption => "absorption",
            Kind::Fresnel => "fresnel interfaces",
            Kind::Dispersion => "dispersion",
            Kind::Rough => "rough surfaces",
            Kind::Lambertian => "lambertian surfaces",
            Kind::Subsurface => "subsurface scattering",
            Kind::Sap => "sphere area partitioning",
            Kind::Polarisation => "polarisation",
            Kind::Fluorescence => "fluorescence",
            Kind::Shifts => "wavenumber shifts",
            Kind::Films => "thin films",
            Kind::Bounces => "multiple bounces",
            Kind::Time => "time of flight",
        }
    }

    /// Name in scenes and flags: the same with hyphens.
    pub fn id(self) -> String {
        self.name().replace(' ', "-")
    }

    /// From its name, with hyphens or blanks.
    pub fn of(name: &str) -> Option<Kind> {
        let name = name.replace('-', " ");
        Kind::ALL.iter().copied().find(|k| k.name() == name)
    }

    /// What calls for it: things of the scene with their lines; empty if nothing does.
    fn callers(self, scene: &Scene) -> Vec<String> {
        let materials = |f: &dyn Fn(&model::Material) -> bool| -> Vec<String> {
            let found = scene.materials.iter().filter(|m| f(m));
            found.map(|m| placed(scene, "material", &m.id)).collect()
        };
        let surfaces = |f: &dyn Fn(&model::Surface) -> bool| -> Vec<String> {
            let found = scene.surfaces.iter().filter(|s| f(s));
            found.map(|s| placed(scene, "surface", &s.id)).collect()
        };
        let first = scene.materials.first().map(|m| &m.index);
        match self {
            Kind::Absorption => materials(&absorbing),
            Kind::Fresnel => materials(&|m| Some(&m.index) != first),
            Kind::Dispersion if scene.wavelengths.len() == 1 => Vec::new(),
            Kind::Dispersion => materials(&|m| !m.index.is_constant()),
            Kind::Rough => surfaces(&|s| matches!(s.kind, SurfaceKind::Rough { m, .. } if m > 0.0)),
            Kind::Lambertian => surfaces(&|s| matches!(s.kind, SurfaceKind::Lambertian { .. })),
            Kind::Subsurface => materials(&|m| !m.scattering.is_empty()),
            Kind::Sap => {
                let mut by = surfaces(&|s| s.sap.is_some());
                by.extend(materials(&|m| m.sap.is_some()));
                if let Branching::Split { nside, .. } = scene.run.branching {
                    by.push(format!("branching split over nside {nside}{}", line(scene, "run")));
                }
                by
            }
            Kind::Films => surfaces(&|s| matches!(s.ratio, Ratio::Film { thickness, .. } if thickness > 0.0)),
            Kind::Bounces => surfaces(&bounces),
            Kind::Time if scene.detect.time => vec![format!("the detectors{}", line(scene, "detect"))],
            Kind::Time => Vec::new(),
            Kind::Fluorescence => materials(&|m| m.conversions.iter().any(|c| fluoresces(c.0))),
            Kind::Shifts => materials(&|m| m.conversions.iter().any(|c| !fluoresces(c.0))),
            Kind::Polarisation => {
                let mut by = Vec::new();
                if scene.polarised.is_some() {
                    by.push(format!("the source{}", line(scene, "source")));
                }
                if scene.detect.analyser.is_some() {
                    by.push(format!("the analyser{}", line(scene, "detect")));
                }
                by
            }
        }
    }

    /// Words before what calls for it, and why it is off where nothing does.
    fn words(self, scene: &Scene) -> (&'static str, &'static str) {
        match self {
            Kind::Absorption => ("called for by", "no material has κ or an absorption"),
            Kind::Fresnel => ("indices differ:", "all refractive indices are equal"),
            Kind::Dispersion if scene.wavelengths.len() == 1 => ("index over wavelength:", "one wavelength"),
            Kind::Dispersion => ("index over wavelength:", "no index depends on wavelength"),
            Kind::Rough => ("called for by", "all surfaces are smooth or Lambertian"),
            Kind::Lambertian => ("called for by", "no surface is Lambertian"),
            Kind::Subsurface => ("called for by", "no material scatters"),
            Kind::Sap => ("called for by", "no <sap>: continuous laws"),
            Kind::Fluorescence => ("called for by", "no material fluoresces"),
            Kind::Films => ("called for by", "no surface has a film"),
            Kind::Bounces => {
                ("called for by", "no rough surface asks for it: what facets mask is in the ledger")
            }
            Kind::Time => ("called for by", "no detector asks for it"),
            Kind::Shifts => ("called for by", "no Raman or Brillouin scattering"),
            Kind::Polarisation => (
                "called for by",
                "no polarised light, no analyser: every surface sees the mean of both states",
            ),
        }
    }

    /// Takes out of the scene what calls for the effect.
    fn remove(self, scene: &mut Scene) -> Result<(), String> {
        match self {
            Kind::Absorption => scene.materials.iter_mut().for_each(|m| {
                (m.absorption, m.index.k) = (None, None);
                for s in &mut m.scattering {
                    if let Scatterer::Mie { index, .. } = s {
                        index.k = None;
                    }
                }
            }),
            Kind::Fresnel => {
                if let Some(first) = scene.materials.first().map(|m| m.index.clone()) {
                    for m in &mut scene.materials {
                        // Absorption by κ stays; only the step of the index goes.
                        m.index.n = first.n.clone();
                    }
                }
                if scene.materials.iter().any(|m| m.index.k.is_some()) {
                    flatten(scene)?;
                }
            }
            Kind::Dispersion => flatten(scene)?,
            Kind::Rough => scene.surfaces.iter_mut().for_each(|s| {
                if matches!(s.kind, SurfaceKind::Rough { .. }) {
                    (s.kind, s.sap) = (SurfaceKind::Smooth, None);
                }
            }),
            Kind::Lambertian => scene.surfaces.iter_mut().for_each(|s| {
                if matches!(s.kind, SurfaceKind::Lambertian { .. }) {
                    (s.kind, s.sap) = (SurfaceKind::Smooth, None);
                }
            }),
            Kind::Subsurface => scene.materials.iter_mut().for_each(|m| m.scattering.clear()),
            Kind::Sap => {
                let per_patch = |s: &model::Surface| s.kind == SurfaceKind::Lambertian { per_patch: true };
                if let Some(s) = scene.surfaces.iter().find(|s| per_patch(s)) {
                    return Err(format!(
                        "'{}' is equal power per patch: it has no law without patches",
                        s.id
                    ));
                }
                scene.surfaces.iter_mut().for_each(|s| s.sap = None);
                scene.materials.iter_mut().for_each(|m| m.sap = None);
                scene.run.branching = Branching::Sample;
            }
            Kind::Fluorescence => {
                let grid = scene.wavelengths.clone();
                for m in &mut scene.materials {
                    // The dye goes on absorbing.
                    for (_, c) in m.conversions.iter().filter(|c| fluoresces(c.0)) {
                        let mut all = c.rate.clone();
                        for (a, nm) in all.iter_mut().zip(&grid) {
                            let own = m.absorption.as_ref().map_or(Ok(0.0), |s| s.at(*nm));
                            *a += own.map_err(|e| format!("material '{}': {e}", m.id))?;
                        }
                        let table = Table::new(&m.id, grid.clone(), all).map_err(|e| e.to_string())?;
                        m.absorption = Some(table.into());
                    }
                    m.conversions.retain(|c| !fluoresces(c.0));
                }
            }
            Kind::Films => scene.surfaces.iter_mut().for_each(|s| {
                if matches!(s.ratio, Ratio::Film { .. }) {
                    s.ratio = Ratio::Fresnel;
                }
            }),
            Kind::Bounces => scene.surfaces.iter_mut().for_each(|s| {
                if let SurfaceKind::Rough { multiple_bounce, .. } = &mut s.kind {
                    *multiple_bounce = model::MultipleBounce::Off;
                }
            }),
            Kind::Time => scene.detect.time = false,
            Kind::Shifts => {
                scene.materials.iter_mut().for_each(|m| m.conversions.retain(|c| fluoresces(c.0)))
            }
            Kind::Polarisation => (scene.polarised, scene.detect.analyser) = (None, None),
        }
        Ok(())
    }

    /// Puts the neutral parameter into the scene: the effect's steps are taken and change nothing.
    fn neutral(self, scene: &mut Scene) -> Result<(), String> {
        let none = |what: &str| Err(format!("{} cannot be forced on: {what}", self.name()));
        match self {
            // `optics` and `plan` look at the override itself.
            Kind::Absorption | Kind::Dispersion => {}
            // A film without thickness is no film, but every surface with it is an event: also where
            // indices are equal.
            Kind::Fresnel | Kind::Films => scene.surfaces.iter_mut().for_each(|s| {
                if matches!(s.ratio, Ratio::Fresnel) {
                    s.ratio = Ratio::Film { index: 1.0, thickness: 0.0 };
                }
            }),
            Kind::Time => {
                if !scene.run.implicit_capture || scene.run.branching != Branching::Sample {
                    return none("it needs branching=\"sample\" and absorption=\"implicit\"");
                }
                scene.detect.time = true;
            }
            Kind::Rough => scene.surfaces.iter_mut().for_each(|s| {
                if s.kind == SurfaceKind::Smooth {
                    s.kind = SurfaceKind::Rough {
                        slopes: model::Slopes::Gaussian,
                        m: NEUTRAL_SLOPE,
                        multiple_bounce: model::MultipleBounce::Off,
                    };
                }
            }),
            Kind::Polarisation => {
                if !Kind::Sap.callers(scene).is_empty() {
                    return none("patches know no plane of reference");
                }
                if !scene.run.implicit_capture {
                    return none("absorption is analog");
                }
                if !Kind::Bounces.callers(scene).is_empty() {
                    return none("walks between facets keep no state");
                }
            }
            Kind::Bounces => return none("give a rough surface multiple-bounce=\"walk\""),
            Kind::Fluorescence => return none("give a material a <fluorescence>"),
            Kind::Shifts => return none("give a material a <shift>"),
            Kind::Lambertian => return none("give a surface kind=\"lambertian\""),
            Kind::Subsurface => {
                // Not where rays go on for ever: they would scatter for certain.
                let unbounded = match &scene.universe {
                    model::Universe::Synthetic(s) => Some(usize::from(s.ambient.0)),
                    _ => None,
                };
                for (i, m) in scene.materials.iter_mut().enumerate() {
                    if m.scattering.is_empty() && Some(i) != unbounded {
                        let mu_s = Spectrum::Constant(NEUTRAL_SCATTERING);
                        m.scattering.push(Scatterer::Coefficient { mu_s, phase: Phase::Isotropic });
                    }
                }
            }
            Kind::Sap => {
                let spec = model::SapSpec {
                    nside: 4,
                    populate: model::Populate::Exact,
                    directions: model::Directions::Density,
                    frame: model::SapFrame::Resolved,
                    roll_random: true,
                };
                let rough = |s: &model::Surface| s.kind != SurfaceKind::Smooth;
                scene.surfaces.iter_mut().filter(|s| rough(s)).for_each(|s| s.sap = Some(spec));
                let scatters = |m: &model::Material| !m.scattering.is_empty();
                scene.materials.iter_mut().filter(|m| scatters(m)).for_each(|m| m.sap = Some(spec));
            }
        }
        Ok(())
    }
}

/// rms slope of a surface that is rough in name only.
const NEUTRAL_SLOPE: f64 = 1e-7;
/// 1/µm: one event in a metre.
const NEUTRAL_SCATTERING: f64 = 1e-6;

fn bounces(s: &model::Surface) -> bool {
    matches!(s.kind, SurfaceKind::Rough { m, multiple_bounce, .. }
        if m > 0.0 && multiple_bounce != model::MultipleBounce::Off)
}

fn fluoresces(kind: ConversionKind) -> bool {
    kind == ConversionKind::Fluorescence
}

fn absorbing(m: &model::Material) -> bool {
    let particles = |s: &Scatterer| matches!(s, Scatterer::Mie { index, .. } if index.k.is_some());
    m.absorption.is_some() || m.index.k.is_some() || m.scattering.iter().any(particles)
}

/// `'id' (line 7)`.
fn placed(scene: &Scene, what: &str, id: &str) -> String {
    format!("'{id}'{}", line(scene, &format!("{what} {id}")))
}

/// ` (line 7)`, or nothing where the scene does not say it itself.
pub(super) fn line(scene: &Scene, key: &str) -> String {
    scene.lines.get(key).map_or(String::new(), |n| format!(" (line {n})"))
}

/// n(λ) becomes n in the middle of the spectrum; what κ(λ) absorbs stays, as absorption.
fn flatten(scene: &mut Scene) -> Result<(), String> {
    let grid = scene.wavelengths.clone();
    let middle = 0.5 * (grid[0] + grid[grid.len() - 1]);
    for m in &mut scene.materials {
        let of = |e: crate::spectrum::SpectrumError| format!("material '{}': {e}", m.id);
        let mut absorbed = Vec::with_capacity(grid.len());
        for &nm in &grid {
            let n = m.index.at(nm).map_err(of)?;
            if !weakly_absorbing(n) {
                return Err(format!("'{}' is a metal at {nm} nm: its index is its reflectance", m.id));
            }
            let own = m.absorption.as_ref().map_or(Ok(0.0), |a| a.at(nm)).map_err(of)?;
            absorbed.push(own + absorption_from_k(n.im, nm));
        }
        m.index.n = Spectrum::Constant(m.index.n.at(middle).map_err(of)?);
        if m.index.k.take().is_some() {
            m.absorption = Some(match grid.len() {
                1 => Spectrum::Constant(absorbed[0]),
                _ => Table::new(&m.id, grid.clone(), absorbed).map_err(of)?.into(),
            });
        }
    }
    Ok(())
}

/// Applies overrides to a checked scene and records in them what they decided against.
///
/// # Errors
/// An effect that cannot be forced so, with the reason.
pub fn apply(scene: &mut Scene, overrides: Vec<Override>) -> Result<(), String> {
    for mut o in overrides {
        if scene.overrides.iter().any(|x| x.kind == o.kind) {
            return Err(format!("{} is overridden twice", o.kind.name()));
        }
        o.called = o.kind.callers(scene);
        match (o.on, o.called.is_empty()) {
            (true, false) | (false, true) => {}
            (true, true) => o.kind.neutral(scene)?,
            (false, false) => o.kind.remove(scene)?,
        }
        scene.overrides.push(o);
    }
    Ok(())
}

impl Scene {
    /// The effect is on although nothing calls for it.
    pub fn forced_on(&self, kind: Kind) -> bool {
        self.overrides.iter().any(|o| o.kind == kind && o.on && o.called.is_empty())
    }

    /// The effect is simulated.
    pub fn has(&self, kind: Kind) -> bool {
        self.forced_on(kind) || !kind.callers(self).is_empty()
    }

    /// Effects that are off although the scene calls for them: every figure lacks them.
    pub fn forced_off(&self) -> impl Iterator<Item = &Override> {
        self.overrides.iter().filter(|o| !o.on && !o.called.is_empty())
    }
}

/// All effects of a scene, its overrides applied.
pub fn settle(scene: &Scene) -> Vec<Effect> {
    Kind::ALL.iter().map(|&kind| effect(scene, kind)).collect()
}

fn effect(scene: &Scene, kind: Kind) -> Effect {
    let (by, off) = kind.words(scene);
    let told = |called: &[String]| {
        if called.is_empty() { off.to_owned() } else { format!("{by} {}", called.join(", ")) }
    };
    match scene.overrides.iter().find(|o| o.kind == kind) {
        Some(o) if o.on == o.called.is_empty() => Effect {
            name: kind.name(),
            on: o.on,
            reason: format!("forced {} ({}); {}", if o.on { "on" } else { "off" }, o.reason, told(&o.called)),
            forced: Some(o.reason.clone()),
        },
        _ => {
            let called = kind.callers(scene);
            Effect { name: kind.name(), on: !called.is_empty(), reason: told(&called), forced: None }
        }
    }
}
