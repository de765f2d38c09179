//! Branching `split`, the paper's own way: every event sends one ray into each patch of its SAP. Power
//! above a floor goes on; below it, roulette. The number of rays grows as patches^depth, which the
//! floor stops; the mean is the same as that of `sample`.

use super::history::{History, Path, Scorer, World, attenuate, edge, settle};
use super::ledger::{Ledger, add, largest, scaled};
use super::light::MediumSap;
use super::patches::{self, SurfaceSap};
use super::surface::{Fate, Meeting, SurfaceLaw, snell};
use crate::material::fresnel;
use crate::math::{DVec3, fast, ln_1p};
use crate::microfacet::Masking;
use crate::rng::Stream;
use crate::universe::{Interface, Next, Universe};

/// SAPs that events split over.
#[derive(Debug)]
pub struct Split {
    /// Power floor relative to the emitted power.
    pub floor: f64,
    /// Per medium that scatters.
    pub media: Vec<Option<MediumSap>>,
    /// Per surface that is not smooth.
    pub surfaces: Vec<Option<SurfaceSap>>,
}

impl Split {
    /// One event: the forced share σ = 1 − e^(−µs D) scatters at a depth drawn from the exponential
    /// truncated to [0, D] (paper (16), made exact); the rest goes on to the interface (17)–(19).
    pub fn step<U: Universe, S: Scorer<N>, const N: usize>(
        &self,
        world: &World<U, N>,
        path: &mut Path<U::Place, N>,
        h: &mut History<U, N>,
        tally: &mut S,
        rng: &mut Stream,
    ) -> bool {
        let next = world.universe.next(&path.ray, &mut path.place, &mut h.memory, f64::INFINITY, rng);
        let distance = match next {
            Next::Interface(at) => at.distance,
            Next::Edge { distance, .. } => distance,
            Next::Limit | Next::Lost => {
                add(&mut h.ledger.lost, &path.power);
                tally.lost(path);
                return false;
            }
        };
        if !self.scatter(world, path, distance, h, tally, rng) {
            return false;
        }
        let medium = &world.light.media[usize::from(path.medium.0)];
        match next {
            Next::Interface(at) => {
                attenuate(world, medium, path, distance, h, tally, rng);
                self.meet(world, path, &at, h, tally, rng)
            }
            Next::Edge { face, .. } => {
                attenuate(world, medium, path, distance, h, tally, rng);
                edge(world, path, face, h, tally, rng)
            }
            Next::Limit | Next::Lost => false,
        }
    }

    /// Sends the scattered share into the patches of the medium's SAP; false if nothing is left.
    fn scatter<U: Universe, S: Scorer<N>, const N: usize>(
        &self,
        world: &World<U, N>,
        path: &mut Path<U::Place, N>,
        distance: f64,
        h: &mut History<U, N>,
        tally: &mut S,
        rng: &mut Stream,
    ) -> bool {
        let index = usize::from(path.medium.0);
        let medium = &world.light.media[index];
        let Some(sap) = self.media.get(index).and_then(Option::as_ref) else { return true };
        let share = fast::one_minus_exp_neg(medium.mu_s * distance);
        if share <= 0.0 {
            return true;
        }
        let depth = (-ln_1p(-rng.uniform() * share) / medium.mu_s).min(distance);
        let mut branch = *path;
        branch.power = scaled(&path.power, share);
        for (p, b) in path.power.iter_mut().zip(&branch.power) {
            *p -= b;
        }
        attenuate(world, medium, &mut branch, depth, h, tally, rng);
        tally.scattered(&branch);
        let frame = sap.frame(branch.ray.dir, rng);
        for (patch, &ratio) in sap.sap.ratios().iter().enumerate() {
            let Some(power) = self.admit(&scaled(&branch.power, ratio), &mut h.ledger, rng) else { continue };
            let local = sap.sap.direction(patch, sap.directions, rng, |u| medium.phase.pdf(u.z));
            let mut child = Path { power, ..branch };
            child.ray.dir = frame.to_world(local);
            world.universe.moved(&child.ray, &mut child.place, &mut h.memory, depth);
            h.bank.push(child);
        }
        largest(&path.power) > 0.0
    }

    /// Floor and roulette of a new branch: the power it goes on with.
    fn admit<const N: usize>(
        &self,
        power: &[f64; N],
        ledger: &mut Ledger<N>,
        rng: &mut Stream,
    ) -> Option<[f64; N]> {
        let most = largest(power);
        if most >= self.floor {
            return Some(*power);
        }
        let survival = most / self.floor;
        if most > 0.0 && rng.uniform() < survival {
            let raised = scaled(power, 1.0 / survival);
            let balance = std::array::from_fn(|i| power[i] - raised[i]);
            add(&mut ledger.roulette, &balance);
            return Some(raised);
        }
        add(&mut ledger.roulette, power);
        None
    }

    /// Both sides of a surface, all patches of each.
    fn meet<U: Universe, S: Scorer<N>, const N: usize>(
        &self,
        world: &World<U, N>,
        path: &mut Path<U::Place, N>,
        at: &Interface,
        h: &mut History<U, N>,
        tally: &mut S,
        rng: &mut Stream,
    ) -> bool {
        let media = &world.light.media;
        let (here, beyond) = (&media[usize::from(path.medium.0)], &media[usize::from(at.beyond.0)]);
        let law = &world.light.surfaces[usize::from(at.surface.0)];
        if law.transparent(here, beyond) {
            return settle(world, path, at, Fate::Refracted { dir: path.ray.dir }, h, tally);
        }
        tally.interface(path, at);
        let meeting = Meeting { dir: path.ray.dir, at, here, beyond };
        let sap = self.surfaces.get(usize::from(at.surface.0)).and_then(Option::as_ref);
        let ledger = &mut h.ledger;
        let mut early = |power: &[f64; N], rng: &mut Stream| self.admit(power, ledger, rng);
        for (power, fate) in outgoing(&mut early, law, sap, &meeting, &path.power, rng) {
            if let Fate::Masked = fate {
                add(&mut h.ledger.masked, &power);
                continue;
            }
            if let Fate::Absorbed = fate {
                let part = Path { power, ..*path };
                tally.absorbed_at(&part, Some(at.beyond), &power);
                add(&mut h.ledger.absorbed, &power);
                continue;
            }
            let Some(power) = self.admit(&power, &mut h.ledger, rng) else { continue };
            let mut child = Path { power, ..*path };
            if settle(world, &mut child, at, fate, h, tally) {
                h.bank.push(child);
            }
        }
        false
    }
}

/// Floor and roulette: the power that a branch goes on with.
type Admit<'a, const N: usize> = dyn FnMut(&[f64; N], &mut Stream) -> Option<[f64; N]> + 'a;

/// Power and fate of every branch of a surface event; the powers sum to `power`.
fn outgoing<const N: usize>(
    admit: &mut Admit<N>,
    law: &SurfaceLaw<N>,
    sap: Option<&SurfaceSap>,
    m: &Meeting<N>,
    power: &[f64; N],
    rng: &mut Stream,
) -> Vec<([f64; N], Fate<N>)> {
    if let (Some(sap), super::surface::Directions::Facets { law: facets, renormalised }) =
        (sap, &law.directions)
        && sap.is_resolved()
    {
        return resolved(admit, law, sap, facets, *renormalised, m, power, rng);
    }
    let r = law.reflectance(m.here, m.beyond, m.cos_i());
    let reflected: [f64; N] = std::array::from_fn(|i| power[i] * r[i]);
    let refracted: [f64; N] = std::array::from_fn(|i| power[i] - reflected[i]);
    let mut out = Vec::new();
    let mirror = |dir| Fate::Reflected { dir, absorbed: None };
    match sap {
        Some(sap) => {
            let (frame, table) = sap.reflected(m);
            let density = |o: DVec3| patches::reflected_density(&law.directions, o);
            table.for_each_visible(&frame, m.at.normal, sap.directions(), rng, density, |_, ratio, dir| {
                out.push((scaled(&reflected, ratio), mirror(dir)));
            });
        }
        None => out.push((reflected, mirror(law.reflected_direction(m, rng)))),
    }
    if law.opaque {
        out.push((refracted, Fate::Absorbed));
        return out;
    }
    if largest(&refracted) == 0.0 {
        return out;
    }
    let Some(specular) = snell(m) else {
        out.push((refracted, Fate::Absorbed));
        return out;
    };
    match sap.and_then(|s| s.refracted(law, m, specular).map(|t| (s, t))) {
        Some((sap, (frame, table, eta))) => {
            let density = |o: DVec3| patches::refracted_density(&law.directions, o, eta);
            table.for_each_visible(&frame, -m.at.normal, sap.directions(), rng, density, |_, ratio, dir| {
                out.push((scaled(&refracted, ratio), Fate::Refracted { dir }));
            });
        }
        None => match law.refracted_direction(m, rng) {
            Some(dir) => out.push((refracted, Fate::Refracted { dir })),
            None => out.push((refracted, Fate::Absorbed)),
        },
    }
    out
}

/// Branches of a resolved SAP: each patch stands for a facet, which reflects and refracts.
#[allow(clippy::too_many_arguments)]
fn resolved<const N: usize>(
    admit: &mut Admit<N>,
    law: &SurfaceLaw<N>,
    sap: &SurfaceSap,
    facets: &crate::microfacet::Microfacet,
    renormalised: bool,
    m: &Meeting<N>,
    power: &[f64; N],
    rng: &mut Stream,
) -> Vec<([f64; N], Fate<N>)> {
    let met = sap.resolved(facets, m, rng);
    let i = met.incidence;
    let whole = if renormalised { met.reflected.albedo } else { 1.0 };
    let stays = law.opaque || !fresnel::weakly_absorbing(m.beyond.n);
    let refracted = met.refracted.filter(|_| !stays);
    // White shares of both sides, less what Fresnel leaves of them below, are what masking removes.
    let white = met.reflected.albedo + refracted.map_or(0.0, |lobe| lobe.albedo);
    let mut masked = scaled(power, 1.0 - white / whole);
    let mut out = Vec::new();
    let density = |o: DVec3| facets.reflected_density(i, o, Masking::Separable);
    let table = &met.reflected.sap;
    for (patch, &ratio) in table.ratios().iter().enumerate().filter(|(_, r)| **r > 0.0) {
        // Roulette first: directions of patches that it kills need not be drawn.
        let share = scaled(power, met.reflected.albedo / whole * ratio);
        let Some(share) = admit(&share, rng) else { continue };
        let o = table.direction(patch, sap.directions(), rng, density);
        let r = law.reflectance(m.here, m.beyond, patches::facet_cosine(i, o, 1.0));
        let back: [f64; N] = std::array::from_fn(|k| share[k] * r[k]);
        let lost: [f64; N] = std::array::from_fn(|k| share[k] - back[k]);
        out.push((back, Fate::Reflected { dir: met.frame.to_world(o), absorbed: None }));
        if stays {
            out.push((lost, Fate::Absorbed));
        } else {
            add(&mut masked, &lost);
        }
    }
    if let Some(lobe) = refracted {
        for (patch, &ratio) in lobe.sap.ratios().iter().enumerate().filter(|(_, r)| **r > 0.0) {
            let Some(share) = admit(&scaled(power, lobe.albedo / whole * ratio), rng) else { continue };
            let o = sap.refracted_out(facets, &met, lobe, patch, rng);
            let r = law.reflectance(m.here, m.beyond, patches::facet_cosine(i, o, met.eta));
            let on: [f64; N] = std::array::from_fn(|k| share[k] * (1.0 - r[k]));
            add(&mut masked, &std::array::from_fn(|k| share[k] - on[k]));
            out.push((on, Fate::Refracted { dir: met.frame.to_world(o) }));
        }
    }
    out.push((masked, Fate::Masked));
    out
}
