//! Rough surfaces with all their bounces: Fresnel at every facet of a walk on the microsurface.

use super::ledger::{Ledger, add};
use super::surface::{Fate, Meeting, SurfaceLaw};
use crate::material::fresnel;
use crate::math::{DVec3, Frame};
use crate::microfacet::Microfacet;
use crate::microfacet::walk::{Bounce, End};
use crate::rng::Stream;

/// A surface event: one outgoing ray.
pub fn draw<const N: usize>(
    law: &SurfaceLaw<N>,
    facets: &Microfacet,
    m: &Meeting<N>,
    power: &mut [f64; N],
    ledger: &mut Ledger<N>,
    rng: &mut Stream,
) -> Fate<N> {
    let frame = Frame::with_x_toward(m.at.normal, m.at.axis);
    let i = frame.to_local(-m.dir);
    let i = DVec3::new(i.x, i.y, i.z.max(0.0));
    let metal = !fresnel::weakly_absorbing(m.beyond.n);
    let mut lost = [0.0; N];
    let end = facets.walk(i, m.beyond.n.re / m.here.n.re, rng, |cos, below, rng| {
        let (from, to) = if below { (m.beyond, m.here) } else { (m.here, m.beyond) };
        let r = law.reflectance(from, to, cos);
        if law.opaque {
            for k in 0..N {
                let kept = power[k] * r[k];
                lost[k] += power[k] - kept;
                power[k] = kept;
            }
            return Bounce::Reflect;
        }
        match (r[0] >= 1.0 || rng.uniform() < r[0], metal) {
            (true, _) => Bounce::Reflect,
            (false, true) => Bounce::Take,
            (false, false) => Bounce::Refract,
        }
    });
    add(&mut ledger.absorbed, &lost);
    let absorbed = law.opaque.then_some(lost);
    match end {
        End::Back(w) => Fate::Reflected { dir: frame.to_world(w), absorbed },
        End::Through(w) => Fate::Refracted { dir: frame.to_world(w) },
        End::Inside => Fate::Absorbed,
        End::Stuck => Fate::Masked,
    }
}
