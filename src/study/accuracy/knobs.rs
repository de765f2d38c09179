//! What of a scene can be set finer, and the settings that a study tries.

use crate::scene::{Branching, Memory, SapSpec, Scene, Universe, Voxels};
use std::sync::Arc;

/// One thing that can be set.
#[derive(Clone, Debug)]
pub struct Knob {
    /// Its name.
    pub name: &'static str,
    /// Settings: word, mesh size h (0: exact; errors are expected to go with a power of it), scene.
    pub settings: Vec<(String, f64, Scene)>,
    /// The scene's own setting.
    pub own: usize,
    /// The one that the others are held against: exact, or the finest.
    pub reference: usize,
    /// How the setting is written in a scene: element and attribute.
    pub attribute: &'static str,
}

impl Knob {
    /// Whether the reference is exact rather than only the finest.
    pub fn exact(&self) -> bool {
        self.settings[self.reference].1 == 0.0
    }
}

/// All knobs that a scene has.
pub fn all(scene: &Scene) -> Vec<Knob> {
    [memory(scene), sap(scene), roulette(scene), floor(scene), grid(scene), voxels(scene)]
        .into_iter()
        .flatten()
        .collect()
}

fn memory(scene: &Scene) -> Option<Knob> {
    let Universe::Statistical(sheet) = &scene.universe else { return None };
    if sheet.layers.iter().all(|l| l.components.is_empty()) || sheet.layers.iter().any(|l| l.grace.is_some())
    {
        return None;
    }
    let mut rungs = vec![Memory::None, Memory::Last(1), Memory::Last(4), Memory::Full];
    if !rungs.contains(&sheet.memory) {
        rungs.insert(0, sheet.memory);
    }
    let with = |memory: Memory| {
        let mut out = scene.clone();
        out.run.shared = 1;
        out.universe = Universe::Statistical(crate::scene::StatisticalSheet { memory, ..sheet.clone() });
        let (word, h) = match memory {
            Memory::Homogeneous => ("homogeneous".to_owned(), 1.0),
            Memory::Markov => ("markov".to_owned(), 1.0),
            Memory::None => ("none".to_owned(), 1.0),
            Memory::Last(k) => (k.to_string(), 1.0 / f64::from(k + 1)),
            Memory::Full => ("full".to_owned(), 0.0),
        };
        (word, h, out)
    };
    Some(Knob {
        name: "memory",
        own: rungs.iter().position(|m| *m == sheet.memory)?,
        reference: rungs.len() - 1,
        settings: rungs.into_iter().map(with).collect(),
        attribute: "universe memory",
    })
}

fn patches(scene: &Scene) -> Option<SapSpec> {
    let media = scene.materials.iter().filter_map(|m| m.sap);
    media.chain(scene.surfaces.iter().filter_map(|s| s.sap)).next()
}

fn sap(scene: &Scene) -> Option<Knob> {
    let own = patches(scene)?;
    let with = |nside: Option<u32>| {
        let mut out = scene.clone();
        let set = |s: &mut Option<SapSpec>| {
            *s = s.and_then(|s| nside.map(|nside| SapSpec { nside, ..s }));
        };
        out.materials.iter_mut().for_each(|m| set(&mut m.sap));
        out.surfaces.iter_mut().for_each(|s| set(&mut s.sap));
        let word = nside.map_or("continuous law".to_owned(), |n| n.to_string());
        (word, nside.map_or(0.0, |n| 1.0 / f64::from(n)), out)
    };
    let mut sizes: Vec<u32> = [own.nside / 2, own.nside, 2 * own.nside, 4 * own.nside].into();
    sizes.retain(|n| (1..=64).contains(n));
    let mut settings: Vec<_> = sizes.iter().map(|n| with(Some(*n))).collect();
    settings.push(with(None));
    Some(Knob {
        name: "patches",
        own: sizes.iter().position(|n| *n == own.nside)?,
        reference: settings.len() - 1,
        settings,
        attribute: "sap nside",
    })
}

fn roulette(scene: &Scene) -> Option<Knob> {
    if !scene.run.implicit_capture {
        return None;
    }
    let with = |threshold: f64| {
        let mut out = scene.clone();
        out.run.roulette = threshold;
        (format!("{threshold:e}"), threshold, out)
    };
    let own = scene.run.roulette;
    let settings = vec![with(10.0 * own), with(own), with(0.1 * own)];
    Some(Knob { name: "roulette", settings, own: 1, reference: 2, attribute: "run roulette" })
}

fn floor(scene: &Scene) -> Option<Knob> {
    let Branching::Split { nside, floor } = scene.run.branching else { return None };
    let with = |floor: f64| {
        let mut out = scene.clone();
        out.run.branching = Branching::Split { nside, floor };
        (format!("{floor:e}"), floor, out)
    };
    let mut sampled = scene.clone();
    sampled.run.branching = Branching::Sample;
    let settings =
        vec![with(4.0 * floor), with(floor), with(0.25 * floor), ("sample".to_owned(), 0.0, sampled)];
    Some(Knob { name: "branching floor", settings, own: 1, reference: 3, attribute: "run floor" })
}

/// The wavelength grid, where figures of colour are asked for: as it is, and with points between.
fn grid(scene: &Scene) -> Option<Knob> {
    let own = &scene.wavelengths;
    if scene.optics.is_none() || own.len() < 3 || scene.materials.iter().any(|m| !m.conversions.is_empty()) {
        return None;
    }
    let mut fine = scene.clone();
    fine.wavelengths = own.windows(2).flat_map(|w| [w[0], 0.5 * (w[0] + w[1])]).collect();
    fine.wavelengths.extend(own.last());
    let step = (own[own.len() - 1] - own[0]) / (own.len() - 1) as f64;
    let settings =
        vec![(format!("{step} nm"), step, scene.clone()), (format!("{} nm", 0.5 * step), 0.5 * step, fine)];
    Some(Knob { name: "wavelength grid", settings, own: 0, reference: 1, attribute: "spectrum step" })
}

/// Larger voxels of the same volume: finer ones are not known.
fn voxels(scene: &Scene) -> Option<Knob> {
    let Universe::Voxel(own) = &scene.universe else { return None };
    let with = |factor: usize| {
        let mut out = scene.clone();
        let (volume, times) = own.volume.coarser(factor).ok()?;
        let mut large = Voxels { volume: Arc::new(volume), ..own.clone() };
        large.rules.edge = std::array::from_fn(|k| own.rules.edge[k] * times[k]);
        out.universe = Universe::Voxel(large);
        Some((factor.to_string(), factor as f64, out))
    };
    // Below some voxels nothing of a structure is left.
    let least = own.volume.cells().into_iter().min()?;
    let settings: Vec<_> = [4, 2].into_iter().filter(|f| least >= 4 * f).filter_map(with).collect();
    let own = settings.len();
    let settings = [settings, vec![("1".to_owned(), 1.0, scene.clone())]].concat();
    (own > 0).then_some(Knob { name: "voxels", settings, own, reference: own, attribute: "volume coarser" })
}
