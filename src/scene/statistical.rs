//! From the checked scene to a statistical universe: amounts become densities.

use super::media::Media;
use super::model::{self, Amount, Edges, Layer, Memory, Rate, Shape, StartIn, StatisticalSheet};
use crate::law::SizeLaw;
use crate::universe::any::AnyUniverse;
use crate::universe::sheet::Slab;
use crate::universe::statistical::amount::{
    AmountError, Coverage, Rule, Target, averages, coverage, densities, nominal, surfaces,
};
use crate::universe::statistical::grace::Grace;
use crate::universe::statistical::kind::{Kind, Sizes};
use crate::universe::statistical::lazy::LazyUniverse;
use crate::universe::statistical::profile::Profile;
use crate::universe::statistical::{Population, Rules, Rung, StatisticalUniverse};
use crate::universe::{BodyId, MediumId, Overlap, SurfaceId};

/// What a layer of bodies came to, for `plan`.
#[derive(Clone, Debug)]
pub struct LayerReport {
    /// Per component.
    pub components: Vec<ComponentReport>,
    /// Share of the layer that is not solid: pores and lumens.
    pub porosity: f64,
    /// Mean free path in the pores for vertical light at mid-depth, µm (its inverse is the rate Σ).
    pub free_path_vertical: f64,
    /// The rate counts bodies as overlapping (`boolean`) or as apart (`matched`, and where bodies are).
    pub rate: Rate,
}

impl LayerReport {
    /// S_V: surface between solid and pore, lumens included, over layer volume, 1/µm.
    pub fn surface(&self) -> f64 {
        self.components.iter().map(|c| c.surface).sum()
    }
}

/// What a component came to.
#[derive(Clone, Debug)]
pub struct ComponentReport {
    /// Name.
    pub name: String,
    /// Solid volume over layer volume.
    pub solid: f64,
    /// Body volume (wall and lumen) over layer volume.
    pub body: f64,
    /// Grammage that stands in the layer, g/m².
    pub grammage: f64,
    /// Density of bodies that the rate uses: 1/µm² (fibres) or 1/µm³.
    pub density: f64,
    /// Grammage before overlaps: what the fibres weighed that were laid, g/m².
    pub nominal: f64,
    /// Surface between solid and pore, lumens included, over layer volume, 1/µm.
    pub surface: f64,
    /// Mean solid area of a section (fibres, µm²) or volume (µm³).
    pub solid_content: f64,
    /// Coarseness that this makes at the component's density, mg/m (fibres).
    pub coarseness: Option<f64>,
}

/// The universe, its thickness (µm) and its reports.
///
/// # Errors
/// Amounts that cannot be: which layer and why.
pub fn build(
    sheet: &StatisticalSheet,
    scene: &model::Scene,
    media: &mut Media,
) -> Result<(AnyUniverse, f64, Vec<LayerReport>), String> {
    let (populations, reports) = populations(sheet, scene, media)?;
    let rules = Rules {
        rung: rung(sheet.memory),
        outside: sheet.outside,
        bottom_surface: SurfaceId::SMOOTH,
        contained: sheet.edges == Edges::Contained,
        start_in_bodies: sheet.edges == Edges::Cut && sheet.start == StartIn::Anywhere,
        backing: sheet.backing.is_some(),
        clear: clear_faces(sheet, scene),
    };
    let universe = StatisticalUniverse::new(populations, rules);
    let top = universe.thickness();
    let remembered = |last| AnyUniverse::Lazy(LazyUniverse::new(universe.clone(), sheet.overlap, last));
    let made = match sheet.memory {
        Memory::Full => remembered(None),
        Memory::Last(k) => remembered(Some(k)),
        _ => AnyUniverse::Statistical(universe),
    };
    Ok((made, top, reports))
}

/// The layers with their densities.
pub(super) fn populations(
    sheet: &StatisticalSheet,
    scene: &model::Scene,
    media: &mut Media,
) -> Result<(Vec<Population>, Vec<LayerReport>), String> {
    let mut top: f64 = sheet.layers.iter().map(|l| l.thickness).sum();
    let mut populations = Vec::new();
    let mut reports = Vec::new();
    for (i, layer) in sheet.layers.iter().enumerate() {
        let bottom = if i + 1 == sheet.layers.len() { 0.0 } else { top - layer.thickness };
        let slab = Slab { top, bottom, pore: layer.pore, surface: layer.surface };
        let (population, report) =
            populate(sheet, layer, slab, scene, media).map_err(|e| format!("layer {}: {e}", i + 1))?;
        populations.push(population);
        reports.extend(report);
        top = bottom;
    }
    Ok((populations, reports))
}

/// Whether the outermost planes part media of equal index with a smooth surface.
pub(super) fn clear_faces(sheet: &StatisticalSheet, scene: &model::Scene) -> [bool; 2] {
    let index = |m: MediumId| &scene.materials[usize::from(m.0)].index;
    let same = |l: Option<&Layer>| l.is_some_and(|l| index(l.pore) == index(sheet.outside));
    let smooth = sheet.layers.first().is_some_and(|l| l.surface == SurfaceId::SMOOTH);
    [smooth && same(sheet.layers.first()), same(sheet.layers.last())]
}

/// Whether rays just leave by the upper and the lower face of a realised sheet, as they do of a statistical
/// one: equal index and smooth, or below a backing in optical contact.
pub(super) fn open_faces(sheet: &StatisticalSheet, scene: &model::Scene) -> [bool; 2] {
    let [top, bottom] = clear_faces(sheet, scene);
    [top, bottom || sheet.backing.is_some()]
}

fn rung(memory: Memory) -> Rung {
    match memory {
        Memory::Homogeneous => Rung::Homogeneous,
        Memory::Markov => Rung::Markov,
        Memory::None | Memory::Last(_) | Memory::Full => Rung::Forgetful,
    }
}

/// Bodies that light enters keep their mass (`matched`), opaque ones their surface (`boolean`); rung
/// `markov` is the Markov mixture of the Boolean sheet, and bodies without room (`homogeneous`) do not
/// displace each other.
fn rate_of(sheet: &StatisticalSheet, layer: &Layer, scene: &model::Scene) -> Rate {
    let opaque = |c: &model::Component| scene.surfaces[usize::from(c.surface.0)].opaque;
    match sheet.rate {
        Some(rate) => rate,
        None if sheet.overlap == Overlap::Forbid => Rate::Matched,
        None if sheet.memory != Memory::None || layer.components.iter().any(opaque) => Rate::Boolean,
        None => Rate::Matched,
    }
}

fn populate(
    sheet: &StatisticalSheet,
    layer: &Layer,
    slab: Slab,
    scene: &model::Scene,
    media: &mut Media,
) -> Result<(Population, Option<LayerReport>), String> {
    if layer.components.is_empty() {
        return Ok((Population::plain(slab), None));
    }
    let contained = sheet.edges == Edges::Contained && layer.grace.is_none();
    let kinds: Vec<Kind> = layer.components.iter().enumerate().map(|(i, c)| kind(c, i, media)).collect();
    let cover: Vec<Coverage> = kinds.iter().map(|k| coverage(k, layer.thickness, contained)).collect();
    let rate = rate_of(sheet, layer, scene);
    let targets: Vec<Target> =
        layer.components.iter().map(|c| target(c.amount, c.density, layer.thickness)).collect();
    let overlapping = if sheet.overlap == Overlap::Priority { Rule::Priority } else { Rule::Union };
    let rule = if rate == Rate::Matched { Rule::Apart } else { overlapping };
    let density = if layer.grace.is_some() {
        vec![0.0; kinds.len()]
    } else {
        densities(rule, &targets, &cover).map_err(|e| named(&e, layer))?
    };
    let shares = averages(rule, &density, &cover);
    if sheet.memory == Memory::Homogeneous
        && let Some(parts) = matched_parts(layer, &shares, scene)
    {
        let pore = media.average(&format!("layer at {:.1} µm", slab.bottom), parts);
        let report = report(layer, &kinds, &cover, (rule, &density), &shares, rate);
        return Ok((Population::plain(Slab { pore, ..slab }), Some(report)));
    }
    let report = report(layer, &kinds, &cover, (rule, &density), &shares, rate);
    let grace = layer.grace.as_ref().map(|g| Grace::new(free_path(&g.free_path), g.types.clone(), g.contact));
    let population = Population {
        slab,
        content: cover.iter().map(|c| c.content).collect(),
        share: shares.iter().map(|s| s.1).collect(),
        solid: cover.iter().map(|c| c.solid / c.content).collect(),
        kinds,
        density,
        grace,
    };
    Ok((population, Some(report)))
}

fn named(e: &AmountError, layer: &Layer) -> String {
    match e {
        AmountError::NoRoom(i) => format!(
            "bodies of '{}' are all thicker than the layer; a thicker layer, thinner bodies or edges=\"cut\"",
            layer.components[*i].name
        ),
        other => other.to_string(),
    }
}

/// Volume shares of all materials of a layer whose bodies are invisible to refraction: then the
/// homogeneous rung is the volume-averaged medium. `None` if any index differs.
fn matched_parts(layer: &Layer, shares: &[(f64, f64)], scene: &model::Scene) -> Option<Vec<(usize, f64)>> {
    let pore = &scene.materials[usize::from(layer.pore.0)];
    let mut parts = Vec::new();
    let mut rest = 1.0;
    for (c, (solid, body)) in layer.components.iter().zip(shares) {
        let (wall, lumen) = (usize::from(c.material.0), usize::from(c.lumen.0));
        let same = |m: usize| scene.materials[m].index == pore.index;
        if !same(wall) || !same(lumen) || c.surface != SurfaceId::SMOOTH {
            return None;
        }
        parts.push((wall, *solid));
        parts.push((lumen, body - solid));
        rest -= body;
    }
    parts.push((usize::from(layer.pore.0), rest));
    Some(parts)
}

pub(super) fn kind(c: &model::Component, index: usize, media: &mut Media) -> Kind {
    let sizes = match &c.shape {
        Shape::Fibre { width, flatness, wall, length, finite } => Sizes::Fibre {
            width: width.clone(),
            flatness: flatness.clone(),
            wall: wall.clone(),
            length: finite.then(|| length.clone()),
        },
        Shape::Disc { diameter, thickness } => {
            Sizes::Disc { diameter: diameter.clone(), thickness: thickness.clone() }
        }
        Shape::Ellipsoid { axes } => Sizes::Ellipsoid(axes.clone()),
        Shape::Sphere { diameter } => Sizes::Sphere(diameter.clone()),
    };
    let solid = media.component(&c.name, usize::from(c.material.0));
    let mut kind =
        Kind::new(sizes, c.azimuth, c.tilt, c.roll, solid, c.lumen, c.surface, BodyId(index as u32 + 1));
    kind.profile = c.profile.as_deref().and_then(Profile::new);
    kind.bonded = c.bonded;
    kind
}

/// Amount as a share or a density; grammage G in g/m², density in kg/m³: share = G/(ρ H).
fn target(amount: Amount, density: f64, thickness: f64) -> Target {
    match amount {
        // g/m² over kg/m³ is mm·1e-3… : 1 g/m² / (1 kg/m³) = 1e-3 m = 1e3 µm.
        Amount::Grammage(g) => Target::Solid(g / density * 1e3 / thickness),
        Amount::LengthDensity(x) | Amount::NumberDensity(x) => Target::Density(x),
        Amount::VolumeFraction(f) => Target::Body(f),
    }
}

fn free_path(law: &model::FreePath) -> SizeLaw {
    let made = match law {
        model::FreePath::Exponential(mean) => SizeLaw::gamma(*mean, 1.0),
        model::FreePath::Gamma { mean, shape } => SizeLaw::gamma(*mean, *shape),
        model::FreePath::Empirical { edges, weights } => SizeLaw::histogram(edges.clone(), weights.clone()),
    };
    made.unwrap_or_else(|e| unreachable!("free-path laws are checked when the scene is read: {e}"))
}

fn report(
    layer: &Layer,
    kinds: &[Kind],
    cover: &[Coverage],
    (rule, density): (Rule, &[f64]),
    shares: &[(f64, f64)],
    rate: Rate,
) -> LayerReport {
    let mid = cover.first().map_or(0, |c| c.out.len() / 2);
    let (laid, surfaces) = (nominal(rule, density, cover), surfaces(rule, density, cover));
    let components: Vec<ComponentReport> = layer
        .components
        .iter()
        .zip(cover)
        .zip(laid.iter().zip(&surfaces))
        .zip(density.iter().zip(shares))
        .map(|(((c, cover), (laid, surface)), (nu, (solid, body)))| ComponentReport {
            name: c.name.clone(),
            solid: *solid,
            body: *body,
            grammage: solid * layer.thickness * c.density * 1e-3,
            density: *nu,
            nominal: laid * layer.thickness * c.density * 1e-3,
            surface: *surface,
            solid_content: cover.solid,
            // kg/m³ · µm² = 1e-12 kg/m = 1e-6 mg/m.
            coarseness: matches!(c.shape, Shape::Fibre { .. }).then_some(c.density * cover.solid * 1e-6),
        })
        .collect();
    let solid: f64 = components.iter().map(|c| c.solid).sum();
    // In-plane bodies across vertical light: the whole majorant counts, thinned by the profile.
    let rate_vertical: f64 = kinds
        .iter()
        .zip(density)
        .zip(cover)
        .map(|((k, nu), c)| nu * k.majorant * c.out[mid] / c.content)
        .sum();
    LayerReport { components, porosity: 1.0 - solid, free_path_vertical: 1.0 / rate_vertical, rate }
}
