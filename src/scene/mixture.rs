//! From the checked scene to a Markov mixture of layers.

use super::media::Media;
use super::model::{self, Memory, Mixture};
use crate::universe::any::AnyUniverse;
use crate::universe::mixture::chain::{Chain, Phase};
use crate::universe::mixture::{MixtureUniverse, Rules, Rung};
use crate::universe::sheet::Slab;
use crate::universe::statistical as plain;
use crate::universe::{MediumId, SurfaceId};

/// The universe, and what `plan` has to say of it. Rung `homogeneous` is one layer of the volume average.
///
/// # Errors
/// Phases that make no mixture, or have no average: why.
pub fn build(
    mixture: &Mixture,
    scene: &model::Scene,
    media: &mut Media,
) -> Result<(AnyUniverse, Vec<String>), String> {
    let phases =
        mixture.phases.iter().map(|p| Phase { medium: p.material, chord: p.chord, share: p.share }).collect();
    let chain = Chain::new(phases).map_err(|e| e.to_string())?;
    let remarks = remarks(mixture, scene, &chain);
    let index = |m: MediumId| &scene.materials[usize::from(m.0)].index;
    let clear = mixture.phases.iter().all(|p| index(p.material) == index(mixture.outside));
    let clear = [clear, clear || mixture.backing.is_some()];
    let rung = match mixture.memory {
        Memory::Homogeneous => {
            let first = index(mixture.phases[0].material);
            if mixture.surface != SurfaceId::SMOOTH
                || mixture.phases.iter().any(|p| index(p.material) != first)
            {
                return Err("phases with surfaces between them have no homogeneous average".to_owned());
            }
            return Ok((average(mixture, &chain, clear, media), remarks));
        }
        Memory::Markov | Memory::None => Rung::Phase,
        Memory::Last(k) => Rung::Layers(k),
        Memory::Full => Rung::Full,
    };
    let rules = Rules { rung, outside: mixture.outside, surface: mixture.surface, clear };
    Ok((AnyUniverse::Mixture(MixtureUniverse::new(chain, mixture.thickness, rules)), remarks))
}

/// Atomic mix: every property averaged over volume.
fn average(mixture: &Mixture, chain: &Chain, clear: [bool; 2], media: &mut Media) -> AnyUniverse {
    let parts =
        chain.phases().iter().zip(chain.volume()).map(|(p, v)| (usize::from(p.medium.0), *v)).collect();
    let pore = media.average("mixture", parts);
    let slab = Slab { top: mixture.thickness, bottom: 0.0, pore, surface: SurfaceId::SMOOTH };
    let layer = plain::Population::plain(slab);
    let rules = plain::Rules {
        rung: plain::Rung::Homogeneous,
        outside: mixture.outside,
        bottom_surface: SurfaceId::SMOOTH,
        contained: false,
        start_in_bodies: false,
        backing: mixture.backing.is_some(),
        clear,
    };
    AnyUniverse::Statistical(plain::StatisticalUniverse::new(vec![layer], rules))
}

fn remarks(mixture: &Mixture, scene: &model::Scene, chain: &Chain) -> Vec<String> {
    let phases = chain.phases().iter().zip(chain.volume()).map(|(p, v)| {
        let name = &scene.materials[usize::from(p.medium.0)].id;
        format!("'{name}' {:.2} % in layers of {} um", 100.0 * v, p.chord)
    });
    let mut out = vec![format!("mixture: {}", phases.collect::<Vec<_>>().join(", "))];
    out.extend(match mixture.memory {
        Memory::Homogeneous => {
            Some("memory homogeneous: exact only where layers are far thinner than free paths".to_owned())
        }
        Memory::Markov | Memory::None => Some(
            "memory markov, none: exact for straight rays; light that turns meets other layers".to_owned(),
        ),
        Memory::Last(1) => Some("memory 1: light that turns finds the layer again that it is in".to_owned()),
        Memory::Last(k) => Some(format!("memory {k}: light that turns finds the last {k} layers again")),
        Memory::Full => None,
    });
    let comes_back =
        mixture.backing.is_some_and(|r| r > 0.0) || scene.optics.as_ref().is_some_and(|o| o.pile > 1);
    if comes_back && matches!(mixture.memory, Memory::Last(_) | Memory::Full) {
        out.push("light that comes back from a backing or another sheet meets other layers".to_owned());
    }
    out
}
