//! Relations that every run must keep, whatever the scene: balance, reciprocity, invariance.

use lightpro::command::{Finished, RunArgs, finish};
use lightpro::material::fresnel;
use lightpro::math::{DVec3, Frame};
use lightpro::run::Health;
use lightpro::sap::Healpix;
use lightpro::scene::{Options, read_text};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::path::Path;

pub fn run(scene: &str, histories: u64) -> Finished {
    let scene = read_text(scene, Path::new("scene.xml"), &Options::default())
        .unwrap_or_else(|found| panic!("{found}\n{scene}"));
    let done =
        finish(scene, &RunArgs { histories: Some(histories), ..RunArgs::default() }, |_| true).unwrap();
    assert_eq!(Health::of(&done.outcome).failure(), None);
    done
}

/// A figure and its standard error.
pub fn figure(done: &Finished, name: &str) -> (f64, f64) {
    let f = done.result.figure(name, None).unwrap();
    (f.value.unwrap(), f.error.unwrap_or(0.0))
}

/// All power that the ledger has, of 1 that entered.
pub fn balance(done: &Finished) -> f64 {
    done.result.ledger.0.iter().map(|l| l.1.value).sum()
}

fn figures(done: &Finished) -> Vec<(f64, f64)> {
    ["reflectance", "transmittance", "absorptance"].iter().map(|n| figure(done, n)).collect()
}

/// Largest deviation of two runs in standard errors of their difference (independent streams).
fn apart(a: &Finished, b: &Finished) -> f64 {
    let z = |(a, b): ((f64, f64), (f64, f64))| {
        if a.0 == b.0 { 0.0 } else { (a.0 - b.0).abs() / (a.1 * a.1 + b.1 * b.1).sqrt() }
    };
    figures(a).into_iter().zip(figures(b)).map(z).fold(0.0, f64::max)
}

/// Spheres and a fibre of glass and gel on a slab, lit from a point; all lengths times `scale`, moved by
/// `shift` (in unscaled lengths), in this order.
fn bodies(scale: f64, shift: DVec3, swapped: bool) -> String {
    let at = |x: f64, y: f64, z: f64| {
        let p = (DVec3::new(x, y, z) + shift) * scale;
        format!("{} {} {} um", p.x, p.y, p.z)
    };
    let length = |x: f64| format!("{} um", x * scale);
    let coefficient = |x: f64| format!("{} 1/um", x / scale);
    let mut list = [
        format!("<sphere centre=\"{}\" radius=\"{}\" material=\"glass\"/>", at(0.0, 0.0, 4.0), length(3.0)),
        format!("<sphere centre=\"{}\" radius=\"{}\" material=\"gel\"/>", at(0.5, 0.25, -6.0), length(4.0)),
    ];
    if swapped {
        list.swap(0, 1);
    }
    format!(
        r#"<scene name="bodies" version="1"><materials>
  <material id="air" index="1"/>
  <material id="glass" index="1.5" absorption="{}"/>
  <material id="gel" index="1.25" absorption="{}"><scattering mu-s="{}" g="0.5"/></material>
</materials>
<universe kind="synthetic" outside="air">{}</universe>
<source kind="point" position="{}" target="{}" half-angle="20 deg"/></scene>"#,
        coefficient(0.03125),
        coefficient(0.0625),
        coefficient(0.25),
        list.join(""),
        at(0.0, 0.0, 16.0),
        at(0.0, 0.0, 0.0)
    )
}

/// Lengths times a power of two: every product and quotient scales exactly, so the bytes are the same.
/// Other factors: the same within 3 standard errors.
#[test]
fn scale_changes_nothing() {
    let plain = run(&bodies(1.0, DVec3::ZERO, false), 50_000);
    for scale in [2_f64.powi(20), 2_f64.powi(-20)] {
        let scaled = run(&bodies(scale, DVec3::ZERO, false), 50_000);
        assert_eq!(scaled.result.to_json(), plain.result.to_json(), "scale {scale}");
    }
    for scale in [1e6, 1e-6] {
        let text = bodies(scale, DVec3::ZERO, false).replace("</scene>", "<run seed=\"9\"/></scene>");
        let z = apart(&run(&text, 50_000), &plain);
        assert!(z < 3.0, "scale {scale}: z = {z}");
    }
}

#[test]
fn place_and_order_change_nothing() {
    let plain = run(&bodies(1.0, DVec3::ZERO, false), 50_000);
    let moved = |shift, swapped| {
        run(&bodies(1.0, shift, swapped).replace("</scene>", "<run seed=\"9\"/></scene>"), 50_000)
    };
    for shift in [DVec3::new(1000.0, -300.0, 70.0), DVec3::new(1e6, 1e6, -1e6)] {
        let z = apart(&moved(shift, false), &plain);
        assert!(z < 3.0, "moved by {shift}: z = {z}");
    }
    let z = apart(&moved(DVec3::ZERO, true), &plain);
    assert!(z < 3.0, "other order: z = {z}");
    // The check bites: a sphere 10 % larger.
    let other = bodies(1.0, DVec3::ZERO, false).replace("radius=\"3 um\"", "radius=\"3.3 um\"");
    assert!(apart(&run(&other, 50_000), &plain) > 5.0);
}

/// A slab of `pieces` equal layers; `names` materials of the same properties take turns.
fn slab(kind: &str, tau: f64, albedo: f64, pieces: u32, names: usize, more: &str) -> String {
    let (mu_s, mu_a) = (tau * albedo / 100.0, tau * (1.0 - albedo) / 100.0);
    let material = |i: usize| {
        format!(
            "<material id=\"m{i}\" index=\"1.4\" absorption=\"{mu_a} 1/um\"><scattering mu-s=\"{mu_s} 1/um\" g=\"0.3\"/></material>"
        )
    };
    let materials: String = (0..names).map(material).collect();
    let layer = |i: u32| {
        let m = i as usize % names;
        format!("<layer thickness=\"{} um\" material=\"m{m}\"/>", 100.0 / f64::from(pieces))
    };
    let layers: String = (0..pieces).map(layer).collect();
    format!(
        "<scene name=\"slab\" version=\"1\"><materials><material id=\"air\" index=\"1\"/>{materials}</materials>\
         <universe {kind} outside=\"air\"><sheet thickness=\"100 um\">{layers}</sheet></universe>\
         <source kind=\"diffuse\"/><run {more}/></scene>"
    )
}

const HOMOGENEOUS: &str = "kind=\"statistical\" memory=\"homogeneous\"";
const SYNTHETIC: &str = "kind=\"synthetic\"";

#[test]
fn a_slab_in_pieces_is_the_slab() {
    let whole = run(&slab(HOMOGENEOUS, 4.0, 0.95, 1, 1, ""), 40_000);
    for kind in [HOMOGENEOUS, SYNTHETIC] {
        for pieces in [2, 3, 5, 10] {
            let cut = run(&slab(kind, 4.0, 0.95, pieces, 1, &format!("seed=\"{pieces}\"")), 40_000);
            let z = apart(&cut, &whole);
            assert!(z < 3.5, "{kind}, {pieces} pieces: z = {z}");
        }
    }
    assert!(apart(&run(&slab(HOMOGENEOUS, 4.3, 0.95, 1, 1, ""), 40_000), &whole) > 5.0, "the check bites");
}

/// Two names for one medium: the same slab (a free path may be drawn anew at the seam).
#[test]
fn equal_media_can_be_merged() {
    for kind in [HOMOGENEOUS, SYNTHETIC] {
        let one = run(&slab(kind, 4.0, 0.95, 6, 1, ""), 40_000);
        let z = apart(&run(&slab(kind, 4.0, 0.95, 6, 2, "seed=\"9\""), 40_000), &one);
        assert!(z < 3.5, "{kind}: z = {z}");
    }
}

/// A component whose share is next to nothing changes nothing.
#[test]
fn a_component_of_no_density_is_no_component() {
    let with = |body: &str| {
        format!(
            "<scene name=\"x\" version=\"1\"><materials><material id=\"air\" index=\"1\"/>\
             <material id=\"wall\" index=\"1.5\" absorption=\"2 1/mm\"/><material id=\"ink\" index=\"2\" absorption=\"1 1/um\"/></materials>\
             <universe kind=\"statistical\" memory=\"none\" outside=\"air\"><sheet thickness=\"100 um\" pore=\"air\"><layer>\
             <fibres material=\"wall\" width=\"20 um\" flatness=\"0.4\" wall=\"3 um\" grammage=\"50 g/m2\"/>{body}</layer></sheet></universe>\
             <source kind=\"diffuse\"/></scene>"
        )
    };
    let ink = |share: f64| {
        with(&format!(
            "<particles shape=\"sphere\" diameter=\"5 um\" material=\"ink\" volume-fraction=\"{share}\"></particles>"
        ))
    };
    let plain = run(&with(""), 40_000);
    let z = apart(&run(&ink(1e-12), 40_000), &plain);
    assert!(z < 3.0, "z = {z}");
    assert!(apart(&run(&ink(0.02), 40_000), &plain) > 5.0, "the check bites");
}

#[test]
fn deep_slabs_keep_their_ledger() {
    for kind in [HOMOGENEOUS, SYNTHETIC] {
        for (tau, albedo, histories) in
            [(1e-12, 0.5, 20_000), (1e-3, 1.0, 20_000), (1e3, 0.999, 4000), (1e4, 1.0, 300), (1e6, 0.9, 4000)]
        {
            let done = run(&slab(kind, tau, albedo, 1, 1, ""), histories);
            let total = balance(&done);
            assert!((total - 1.0).abs() < 1e-12, "{kind}, τ {tau}: {total}");
        }
    }
}

/// A source in a clear sphere (n 1.5, at 0.9 of the radius): what meets the wall beyond the critical
/// angle never leaves. Its share is cos α with sin α = 1/(1.5 · 0.9).
#[test]
fn the_event_cap_books_what_it_cuts() {
    let done = run(
        "<scene name=\"trap\" version=\"1\"><materials><material id=\"air\" index=\"1\"/><material id=\"glass\" index=\"1.5\"/></materials>\
         <universe kind=\"synthetic\" outside=\"air\"><sphere centre=\"0 0 0 um\" radius=\"10 um\" material=\"glass\"/></universe>\
         <source kind=\"point\" position=\"9 0 0 um\" target=\"9 0 1 um\" half-angle=\"180 deg\"/><run event-cap=\"500\"/></scene>",
        20_000,
    );
    let trapped = (1.0 - 1.0 / (1.5 * 0.9_f64).powi(2)).sqrt();
    let share = done.result.ledger.0.iter().find(|l| l.0 == "truncated").unwrap().1;
    let z = (share.value - trapped) / share.error;
    assert!(z.abs() < 4.0, "{} instead of {trapped}: z = {z}", share.value);
    let health = Health::of(&done.outcome);
    assert_eq!(health.capped, (share.value * 20_000.0).round() as u64);
    assert_eq!(health.records.len(), 100);
    assert!(health.warning().unwrap().contains("event cap"));
}

/// So many cases of a property, the same in every run.
pub fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(20_261_123),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(cases(256))]

    /// R + T = 1, and light that goes back the way it came is reflected alike.
    #[test]
    fn interfaces_conserve_and_reciprocate(n1 in 1.0..4.0_f64, n2 in 1.0..4.0_f64, c in 1e-6..1.0_f64) {
        let d = fresnel::dielectric(n1, n2, c);
        prop_assert!((d.r + d.t - 1.0).abs() < 4e-16 && d.r >= 0.0 && d.t >= 0.0);
        if d.t > 0.0 && d.cos_t > 1e-3 {
            // The cosine handed back is rounded: so much of the first cosine, and 4 n of that in R, is unknown.
            let eta = n1.max(n2) / n1.min(n2);
            let unknown = 1e-15 + 2.0 * f64::EPSILON * eta * eta / c;
            let back = fresnel::dielectric(n2, n1, d.cos_t);
            prop_assert!((back.r - d.r).abs() < 4.0 * eta * unknown, "{} {}", back.r, d.r);
            prop_assert!((back.cos_t - c).abs() < unknown, "{} {c}", back.cos_t);
        }
    }

    /// Frames turn there and back, and are right-handed.
    #[test]
    fn frames_are_rotations(x in -1.0..1.0_f64, y in -1.0..1.0_f64, z in -1.0..1.0_f64, v in prop::array::uniform3(-1.0..1.0_f64)) {
        prop_assume!(DVec3::new(x, y, z).length() > 1e-3);
        let f = Frame::from_pole(DVec3::new(x, y, z).normalize());
        let v = DVec3::from_array(v);
        prop_assert!((f.to_world(f.to_local(v)) - v).length() < 1e-15);
        prop_assert!((f.x.cross(f.y) - f.z).length() < 1e-15);
    }

    /// A patch holds its own centre, at every granularity.
    #[test]
    fn patches_hold_their_centres(k in 0..9_u32, share in 0.0..1.0_f64) {
        let hp = Healpix::new(1 << k).unwrap();
        let pix = ((share * hp.npix() as f64) as usize).min(hp.npix() - 1);
        prop_assert_eq!(hp.pix_of(hp.centre(pix)), pix);
    }
}

proptest! {
    #![proptest_config(cases(24))]

    /// Any slab: the ledger of each history closes to 1e-12, all power is booked.
    #[test]
    fn slabs_balance(log_tau in -6.0..2.0_f64, albedo in 0.0..1.0_f64, pieces in 1..5_u32, analog in any::<bool>()) {
        let more = if analog { "absorption=\"analog\"" } else { "" };
        let done = run(&slab(HOMOGENEOUS, 10_f64.powf(log_tau), albedo, pieces, 1, more), 500);
        let total = balance(&done);
        prop_assert!((total - 1.0).abs() < 1e-12, "{total}");
    }
}
