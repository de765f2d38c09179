//! The universe: a Markov mixture of planar layers.

use super::sheet::memory;
use super::{Node, Reading};
use crate::scene::diagnostic::Diagnostic;
use crate::scene::model::*;
use crate::universe::MediumId;

impl Reading<'_> {
    pub fn markov_mixture(&mut self, e: Node<'_>, own: Node<'_>, materials: &[Material]) -> Mixture {
        let phases: Vec<MixturePhase> = own
            .children("phase")
            .map(|p| MixturePhase {
                material: self.material(p, "material").unwrap_or(MediumId(0)),
                chord: p.number("chord").unwrap_or(1.0),
                share: p.number("share").unwrap_or(1.0),
            })
            .collect();
        if phases.len() < 2 && !own.own.misspelt.get() {
            let d = Diagnostic::error(own.own.place, "a mixture has at least two phases");
            self.out.push(d.help("one material alone is a <sheet> with a <layer material=…/>"));
        }
        let mixture = Mixture {
            memory: memory(e),
            thickness: own.number("thickness").unwrap_or(1.0),
            phases,
            surface: self.surface_id(own, "surface"),
            outside: self.outside(e),
            backing: self.backing(e, own),
        };
        self.check_average(e, &mixture, materials);
        mixture
    }

    /// Only what differs in absorption and scattering alone has a volume average.
    fn check_average(&mut self, e: Node<'_>, mixture: &Mixture, materials: &[Material]) {
        if mixture.memory != Memory::Homogeneous || self.out.error_count() > 0 {
            return;
        }
        let index = |p: &MixturePhase| materials.get(usize::from(p.material.0)).map(|m| &m.index);
        let differ = mixture.phases.windows(2).any(|p| index(&p[0]) != index(&p[1]));
        if differ || mixture.surface != crate::universe::SurfaceId::SMOOTH {
            let message = "phases with surfaces between them have no homogeneous average";
            let d = Diagnostic::error(e.place("memory"), message);
            self.out.push(d.help("phases of one refractive index and smooth planes, or another memory"));
        }
    }
}
