//! Properties that hold for any parameters: reciprocity of rough surfaces, sums over patches, round trips of
//! the tessellation, rotation of a scene, and what each universe promises of `next` and of branches.

use crate::relations::{balance, cases, figure, run};
use glam::DMat3;
use lightpro::lpm::light::MediumSap;
use lightpro::lpm::patches::SapRule;
use lightpro::math::{DVec3, TAU};
use lightpro::microfacet::{Masking, Microfacet, Slopes};
use lightpro::phase::Phase;
use lightpro::rng::{Purpose, Stream};
use lightpro::sap::{AliasTable, Healpix, SapDirections};
use lightpro::scene::plan::Plan;
use lightpro::scene::{Options, read, read_text};
use lightpro::universe::any::AnyUniverse;
use lightpro::universe::{Next, Ray, Universe};
use proptest::prelude::*;
use std::path::Path;

use crate::walking::{isotropic, onward};

/// Direction of polar angle acos `c` and azimuth `a`.
fn direction(c: f64, a: f64) -> DVec3 {
    let s = (1.0 - c * c).sqrt();
    DVec3::new(s * a.cos(), s * a.sin(), c)
}

fn mirrored(v: DVec3) -> DVec3 {
    DVec3::new(v.x, v.y, -v.z)
}

/// Relative difference of two densities; 0 where both are next to nothing (far out in a Gaussian the
/// rounding of the slope counts a thousandfold).
fn unlike(a: f64, b: f64) -> f64 {
    if a.max(b) < 1e-30 { 0.0 } else { (a - b).abs() / a.max(b) }
}

proptest! {
    #![proptest_config(cases(512))]

    /// Helmholtz: f(i → o) = f(o → i); through the surface f(i → o) = η² f(o → i) of the relative index η,
    /// light going back (Walter et al. 2007). Density = f cos θo; the facet's Fresnel factor is the same on
    /// the way back (`interfaces_conserve_and_reciprocate`).
    #[test]
    fn rough_surfaces_are_reciprocal(
        gaussian in any::<bool>(), log_m in -2.0..0.3_f64, eta in 0.5..2.5_f64,
        ci in 1e-3..1.0_f64, ai in 0.0..TAU, co in 1e-3..1.0_f64, ao in 0.0..TAU,
    ) {
        let law = if gaussian { Slopes::Gaussian } else { Slopes::Ggx };
        let facets = Microfacet::new(law, 10_f64.powf(log_m)).unwrap();
        let (i, o) = (direction(ci, ai), direction(co, ao));
        for masking in [Masking::Separable, Masking::Correlated] {
            let f = |i, o: DVec3| facets.reflected_density(i, o, masking) / o.z;
            prop_assert!(unlike(f(i, o), f(o, i)) < 1e-9, "{} {}", f(i, o), f(o, i));
        }
        prop_assume!((eta - 1.0).abs() > 1e-3);
        let through = |i, o: DVec3, eta| facets.transmitted_density(i, o, eta) / o.z.abs();
        let (there, back) = (through(i, mirrored(o), eta), through(o, mirrored(i), 1.0 / eta));
        prop_assert!(unlike(there, eta * eta * back) < 1e-9, "{there} {back}");
    }

    /// A table of chances draws each entry with its share to 2⁻³², zeros never.
    #[test]
    fn tables_of_chances_keep_their_shares(mut shares in prop::collection::vec(0.0..1.0_f64, 1..60), hole in 0..60_usize) {
        if hole < shares.len() && shares.len() > 1 { shares[hole] = 0.0; }
        let total: f64 = shares.iter().sum();
        prop_assume!(total > 0.0);
        let table = AliasTable::new(&shares).unwrap();
        for (p, share) in table.probabilities().iter().zip(&shares) {
            prop_assert!((p - share / total).abs() < 2_f64.powi(-32), "{p} for {}", share / total);
            prop_assert!(*share > 0.0 || *p == 0.0);
        }
    }

    /// Direction → patch → place on its face → patch → direction.
    #[test]
    fn the_tessellation_goes_there_and_back(k in 0..13_u32, c in -1.0..1.0_f64, a in 0.0..TAU, fx in 0.001..0.999_f64, fy in 0.001..0.999_f64) {
        let hp = Healpix::new(1 << k).unwrap();
        let pix = hp.pix_of(direction(c, a));
        prop_assert!(pix < hp.npix());
        prop_assert_eq!(hp.pix_at(hp.face_patch(pix)), pix);
        let inside = hp.direction_in(pix, fx, fy);
        prop_assert_eq!(hp.pix_of(inside), pix);
        prop_assert!((inside.length() - 1.0).abs() < 1e-15);
        // No direction of a patch is farther from its centre than the patch is wide.
        prop_assert!(direction(c, a).distance(hp.centre(pix)) < 1.8 * hp.area().sqrt());
    }
}

proptest! {
    #![proptest_config(cases(24))]

    /// The patches of any phase function share the power out whole, and never below nothing.
    #[test]
    fn patches_share_the_power_out(g1 in -0.95..0.95_f64, g2 in -0.95..0.95_f64, w in 0.0..1.0_f64, k in 0..5_u32, exact in any::<bool>()) {
        for phase in [Phase::HenyeyGreenstein(g1), Phase::TwoTerm { w, g1, g2 }, Phase::Rayleigh, Phase::Isotropic] {
            let rule = SapRule { nside: 1 << k, exact, directions: SapDirections::Density, resolved: true, roll_random: true };
            let sap = MediumSap::new(&phase, &rule).unwrap().sap;
            let sum: f64 = sap.ratios().iter().sum();
            prop_assert!((sum - 1.0).abs() < 1e-13, "{sum}");
            prop_assert!(sap.ratios().iter().all(|&r| r >= 0.0));
            // Exact shares are the integral over all patches of the density, which is 1.
            prop_assert!(!exact || (sap.sum() - 1.0).abs() < 1e-9, "{}", sap.sum());
        }
    }
}

/// Glass and gel balls and a fibre about the origin, lit from a point: all turned by `turn`.
fn turned(turn: DMat3, seed: u64) -> String {
    let at = |v: DVec3| {
        let p = turn * v;
        format!("{} {} {}", p.x, p.y, p.z)
    };
    format!(
        r#"<scene name="turned" version="1"><materials><material id="air" index="1"/>
  <material id="glass" index="1.5" absorption="0.03 1/um"/>
  <material id="gel" index="1.25" absorption="0.06 1/um"><scattering mu-s="0.25 1/um" g="0.5"/></material></materials>
<universe kind="synthetic" outside="air">
  <sphere centre="{} um" radius="3 um" material="glass"/><sphere centre="{} um" radius="4 um" material="gel"/>
  <cylinder centre="{} um" axis="{}" radius="1.5 um" length="9 um" material="glass"/></universe>
<source kind="point" position="{} um" target="0 0 0 um" half-angle="25 deg"/><run seed="{seed}"/></scene>"#,
        at(DVec3::new(0.0, 0.0, 4.0)),
        at(DVec3::new(0.5, 0.25, -6.0)),
        at(DVec3::new(5.0, 1.0, 1.0)),
        at(DVec3::new(0.3, 0.8, 0.1)),
        at(DVec3::new(0.0, 0.0, 16.0)),
    )
}

proptest! {
    #![proptest_config(cases(12))]

    /// A scene turned as a whole absorbs the same; about the vertical it reflects the same, too.
    #[test]
    fn turned_scenes_are_the_same(x in -1.0..1.0_f64, y in -1.0..1.0_f64, z in -1.0..1.0_f64, angle in 0.0..TAU) {
        let axis = DVec3::new(x, y, z);
        prop_assume!(axis.length() > 1e-2);
        let still = run(&turned(DMat3::IDENTITY, 1), 20_000);
        let apart = |names: &[&str], turn: DMat3| {
            let other = run(&turned(turn, 2), 20_000);
            names.iter().map(|n| {
                let ((a, da), (b, db)) = (figure(&still, n), figure(&other, n));
                (a - b).abs() / da.hypot(db)
            }).fold(0.0, f64::max)
        };
        // 48 figures: 1 in 1,000 families has one beyond 4.3.
        let z = apart(&["absorptance"], DMat3::from_axis_angle(axis.normalize(), angle));
        prop_assert!(z < 4.3, "about {axis}: z = {z}");
        let z = apart(&["reflectance", "transmittance", "absorptance"], DMat3::from_rotation_z(angle));
        prop_assert!(z < 4.3, "about the vertical: z = {z}");
    }

    /// All power of any history of bodies is booked, roulette included.
    #[test]
    fn bodies_balance(seed in 0..1000_u64, split in any::<bool>()) {
        let mode = if split { r#"<run branching="split" "# } else { r#"<run roulette="0.3" "# };
        let done = run(&turned(DMat3::IDENTITY, seed).replace("<run ", mode), 300);
        prop_assert!((balance(&done) - 1.0).abs() < 1e-12, "{}", balance(&done));
    }
}

/// A step of a walk: what came next.
struct Walk<P> {
    ray: Ray,
    place: P,
}

impl<P: Copy + Default + Send> Walk<P> {
    fn begin<U: Universe<Place = P>>(u: &U, top: f64, memory: &mut U::Memory, s: &mut Stream) -> Self {
        let d = isotropic(s);
        let ray = Ray { origin: DVec3::new(0.1, 0.2, top), dir: if d.z > 0.0 { -d } else { d } };
        Walk { ray, place: u.enter(&ray, memory, s).place }
    }

    /// Asked twice, `next` answers the same.
    fn step<U: Universe<Place = P>>(&mut self, u: &U, memory: &mut U::Memory, s: &mut Stream) -> Next {
        let limit = if s.uniform() < 0.3 { 5.0 * s.exponential() } else { f64::INFINITY };
        let next = u.next(&self.ray, &mut self.place, memory, limit, s);
        assert_eq!(u.next(&self.ray, &mut self.place, memory, limit, s), next, "asked twice");
        match next {
            Next::Interface(at) => {
                let (reflects, dir) = onward(&at, self.ray.dir, isotropic(s), 4.0, s);
                self.ray = Ray { origin: self.ray.at(at.distance), dir };
                if reflects {
                    u.reflected(&self.ray, &mut self.place, memory, &at);
                } else {
                    u.crossed(&mut self.ray, &mut self.place, memory, &at);
                }
            }
            Next::Limit => {
                self.ray = Ray { origin: self.ray.at(limit), dir: isotropic(s) };
                u.moved(&self.ray, &mut self.place, memory, limit);
            }
            Next::Edge { .. } | Next::Lost => {}
        }
        next
    }

    fn tale<U: Universe<Place = P>>(
        &mut self,
        u: &U,
        memory: &mut U::Memory,
        s: &mut Stream,
        most: usize,
    ) -> Vec<Next> {
        let mut out = Vec::new();
        while out.len() < most {
            let next = self.step(u, memory, s);
            out.push(next);
            assert_ne!(next, Next::Lost);
            if matches!(next, Next::Edge { .. }) {
                break;
            }
        }
        out
    }
}

/// The walk of history `seed`, and a branch of it after `before` steps, which goes the same way whether its
/// siblings have gone before it or not. How many steps were compared.
fn contract<U: Universe>(u: &U, top: f64, seed: u64, before: usize) -> usize {
    let stream = |k: u64| Stream::of(seed, 0, k, Purpose::Probe);
    let begin = |memory: &mut U::Memory| {
        u.forget(memory);
        u.begin(memory, seed);
        let mut s = stream(0);
        let mut walk = Walk::begin(u, top, memory, &mut s);
        let told = walk.tale(u, memory, &mut s, before);
        (walk, told)
    };
    let (mut alone, mut crowded) = (U::Memory::default(), U::Memory::default());
    let ((mut one, told), (mut other, again)) = (begin(&mut alone), begin(&mut crowded));
    assert_eq!(told, again, "the same history");
    if told.last().is_some_and(|n| matches!(n, Next::Edge { .. })) {
        return told.len();
    }
    for sibling in 1..4 {
        Walk { ray: other.ray, place: other.place }.tale(u, &mut crowded, &mut stream(sibling), 30);
    }
    let (mine, theirs) =
        (one.tale(u, &mut alone, &mut stream(9), 30), other.tale(u, &mut crowded, &mut stream(9), 30));
    assert_eq!(mine, theirs, "a branch sees only its own past");
    told.len() + mine.len()
}

fn keeps(plan: &Plan, seed: u64, before: usize) -> usize {
    let top = plan.top;
    match &plan.universe {
        AnyUniverse::Statistical(u) => contract(u, top, seed, before),
        AnyUniverse::Lazy(u) => contract(u, top, seed, before),
        AnyUniverse::Mixture(u) => contract(u, top, seed, before),
        AnyUniverse::Synthetic(u) => contract(u, top, seed, before),
        AnyUniverse::Ensemble(u) => contract(u, top, seed, before),
        AnyUniverse::Realised(u) => contract(u, top, seed, before),
        AnyUniverse::Stack(u) => contract(u, top, seed, before),
        AnyUniverse::Topography(u) => contract(u, top, seed, before),
        AnyUniverse::Voxel(u) => contract(u, top, seed, before),
    }
}

/// A sheet of hollow fibres, known as `universe` says.
fn fibres(universe: &str, share: f64, wall: f64) -> String {
    format!(
        r#"<scene name="sheet" version="1"><materials><material id="air" index="1"/><material id="wall" index="1.5"/></materials>
<universe {universe} outside="air"><sheet thickness="100 um" pore="air"><layer>
<fibres material="wall" width="20 um" flatness="0.5" wall="{wall} um" volume-fraction="{share}"/></layer></sheet></universe>
<source kind="diffuse"/></scene>"#
    )
}

/// Spheres anywhere in a window, overlapping as they like.
fn balls(seed: u64, cell: bool) -> String {
    let mut s = Stream::of(seed, 0, 0, Purpose::Probe);
    let mut at = || 40.0 * s.uniform() - 20.0;
    let list: String = (0..30)
        .map(|k| {
            let (x, y, z) = (at(), at(), at());
            format!(
                r#"<sphere centre="{x} {y} {z} um" radius="{} um" material="{}"/>"#,
                1.0 + f64::from(k) / 6.0,
                ["gel", "glass"][k as usize % 2]
            )
        })
        .collect();
    let cell = if cell { r#"<cell period="45 um" bottom="-30 um" top="30 um"/>"# } else { "" };
    format!(
        r#"<scene name="balls" version="1"><materials><material id="air" index="1"/><material id="glass" index="1.5"/><material id="gel" index="1.3"/></materials>
<universe kind="synthetic" outside="air">{cell}{list}</universe><source kind="diffuse"/></scene>"#
    )
}

proptest! {
    #![proptest_config(cases(24))]

    /// What the trait promises, in every universe.
    #[test]
    fn universes_keep_their_contract(seed in 0..100_000_u64, share in 0.05..0.6_f64, wall in 1.0..4.0_f64, before in 0..25_usize) {
        let statistical = ["homogeneous", "markov", "none", "2", "8", "full"].map(|rung| {
            fibres(&format!(r#"kind="statistical" memory="{rung}""#), share, wall)
        });
        let realised = fibres(r#"kind="synthetic""#, share, wall);
        let film = |text: String| {
            text.replace("<layer>", r#"<layer thickness="60 um">"#)
                .replace("</layer>", r#"</layer><layer thickness="40 um" material="wall"/>"#)
        };
        let layered = [statistical[2].clone(), statistical[5].clone(), realised.clone()].map(film);
        let others = [realised, balls(seed, false), balls(seed, true)];
        for text in statistical.into_iter().chain(layered).chain(others) {
            let scene = read_text(&text, Path::new("scene.xml"), &Options::default());
            let plan = Plan::new(&scene.unwrap_or_else(|e| panic!("{e}"))).unwrap();
            let steps: usize = (0..20).map(|k| keeps(&plan, seed + k, before)).sum();
            prop_assert!(steps >= 20, "{text}: {steps}");
        }
    }
}

/// The same of what stands in files.
#[test]
fn mixtures_and_voxels_keep_their_contract() {
    for file in
        ["scenes/verify/alp-3c-full.xml", "scenes/voxel-sheet.xml", "scenes/verify/topography-sine.xml"]
    {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
        let plan = Plan::new(&read(&path, &Options::default()).unwrap_or_else(|e| panic!("{e}"))).unwrap();
        for before in [0, 1, 3, 8, 20] {
            let steps: usize = (0..100).map(|k| keeps(&plan, 1000 * before as u64 + k, before)).sum();
            assert!(steps > 100, "{file}: {steps}");
        }
    }
}
