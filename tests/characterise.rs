//! What `characterise` measures of a sheet whose statistics are known; and its files in a scene.
#![allow(clippy::disallowed_methods, missing_docs)]

use lightpro::scene::{Options, Scene, read, read_text};
use lightpro::study::characterise::characterise;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

const MATERIALS: &str = r#"<materials><material id="air" index="1"/><material id="lumen" index="1"/><material id="wall" index="1.55"/></materials>"#;

fn scene_in(folder: &Path, universe: &str) -> Scene {
    let text = format!(
        "<scene name=\"known\" version=\"1\">{MATERIALS}{universe}<source kind=\"diffuse\"/><run histories=\"8192\"/></scene>"
    );
    match read_text(&text, &folder.join("scene.xml"), &Options::default()) {
        Ok(scene) => scene,
        Err(found) => panic!("{found}"),
    }
}

/// Complete elliptic integral E(m), by the midpoint rule (exponentially exact).
fn elliptic_e(m: f64) -> f64 {
    let n = 200;
    (0..n).map(|i| (1.0 - m * (PI * (f64::from(i) + 0.5) / f64::from(n)).sin().powi(2)).sqrt()).sum::<f64>()
        * PI
        / (2.0 * f64::from(n))
}

/// ∫ over |cos θ| from a to b of E(sin²θ), over b − a.
fn mean_e(a: f64, b: f64) -> f64 {
    let n = 40;
    (0..n)
        .map(|i| {
            let c = a + (b - a) * (f64::from(i) + 0.5) / f64::from(n);
            // Lines enter with a density of |cos θ|, and run 1/|cos θ|: even in |cos θ|.
            elliptic_e(1.0 - c * c)
        })
        .sum::<f64>()
        / f64::from(n)
}

const RADIUS: f64 = 1.0;
const LUMEN: f64 = 0.73;
const DENSITY: f64 = 0.11353316;

fn known(kind: &str) -> String {
    format!(
        "<universe kind=\"{kind}\" memory=\"full\" edges=\"cut\" outside=\"air\"><sheet thickness=\"8 um\" pore=\"air\"><layer>\
         <fibres name=\"pulp\" material=\"wall\" lumen=\"lumen\" width=\"2 um\" wall=\"{} um\" roll=\"uniform\" \
         orientation=\"wrapped-cauchy\" mean-direction=\"20 deg\" rho=\"0.4\" length-density=\"{DENSITY} 1/um2\"/>\
         </layer></sheet></universe>",
        RADIUS - LUMEN
    )
}

/// A Boolean realisation gives its own input back: rates by direction, mean chords 4V/S, share of volume,
/// orientation and amount within 1 %, and within 4 standard errors.
#[test]
fn a_boolean_realisation_returns_its_own_input() {
    let found = characterise(&scene_in(&root(), &known("synthetic")), 400_000).unwrap();
    let medium = |name: &str| found.media.iter().position(|m| m == name).unwrap();
    let (air, wall, lumen) = (medium("air"), medium("pulp"), medium("lumen"));
    assert_eq!(found.all.lost, 0);
    let mut worst: f64 = 0.0;
    let mut close = |what: &str, (got, se): (f64, f64), want: f64| {
        let (off, z) = (got / want - 1.0, (got - want) / se);
        println!("{what}: {got:.5}({se:.5}), closed form {want:.5}, {:+.2} %, z {z:+.2}", 100.0 * off);
        worst = worst.max(off.abs());
        assert!(off.abs() < 0.01 && z.abs() < 4.0, "{what}");
    };
    let solid = 1.0 - (-DENSITY * PI * (RADIUS * RADIUS - LUMEN * LUMEN)).exp();
    close("share of walls", found.value(|c| c.share(wall)), solid);
    // Pores: what no fibre covers. Chords end at walls in all directions alike.
    let pores = (-DENSITY * PI * RADIUS * RADIUS).exp();
    close("share of pores", found.value(|c| c.share(air)), pores);
    close("mean chord of pores", found.value(|c| c.mean_chord(air)), 2.0 / (PI * RADIUS * DENSITY));
    let surface = 2.0 * PI * (RADIUS + LUMEN) * DENSITY * (1.0 - solid);
    close("interfaces", found.value(|c| c.surface()), surface);
    close("mean chord of walls", found.value(|c| c.mean_chord(wall)), 4.0 * solid / surface);
    close("share of lumens", found.value(|c| c.share(lumen)), 1.0 - solid - pores);
    for [from, to, rate, se] in found.rates(air) {
        let want = 2.0 * RADIUS * DENSITY * 2.0 / PI * mean_e(from, to);
        close(&format!("rate in pores, cos {from:.1}-{to:.1}"), (rate, se), want);
    }
    close("order of the axes", found.value(|c| c.order(wall).unwrap().1), 0.4);
    let azimuth = found.value(|c| c.order(wall).unwrap().0.to_degrees());
    assert!((azimuth.0 - 20.0).abs() < 4.0 * azimuth.1 && azimuth.1 < 0.5, "{azimuth:?}");
    let counted = &found.populations[0];
    assert!((counted.density / DENSITY - 1.0).abs() < 0.01, "{}", counted.density);
    assert!((counted.order.1 - 0.4).abs() < 0.01 && counted.tilt < 1e-9);
    println!("worst {:.2} %", 100.0 * worst);
}

/// Chords of pores between bodies that stand independently are exponential in each direction; over the
/// directions their survival is the mean of exponentials.
#[test]
fn chords_survive_as_the_rates_say() {
    let found = characterise(&scene_in(&root(), &known("statistical")), 200_000).unwrap();
    let air = found.media.iter().position(|m| m == "air").unwrap();
    let n = 400;
    let rate = |c: f64| 2.0 * RADIUS * DENSITY * 2.0 / PI * elliptic_e(1.0 - c * c);
    // Chords begin at walls in proportion to the rate.
    let rates: Vec<f64> = (0..n).map(|i| rate((f64::from(i) + 0.5) / f64::from(n))).collect();
    let total: f64 = rates.iter().sum();
    let mut worst: f64 = 0.0;
    for (length, share) in found.all.survival(air) {
        let want = rates.iter().map(|r| r * (-r * length).exp()).sum::<f64>() / total;
        worst = worst.max((share - want).abs());
    }
    println!("survival of chords: worst {worst:.5}");
    assert!(worst < 0.01, "{worst}");
}

/// The files in a scene: it is read, and its statistics are those measured.
#[test]
fn the_files_make_a_statistical_scene() {
    let folder = tempfile::tempdir().unwrap();
    for universe in [known("synthetic"), String::new()] {
        let found = match universe.is_empty() {
            false => characterise(&scene_in(&root(), &universe), 50_000).unwrap(),
            true => characterise(
                &read(&root().join("scenes/voxel-sheet.xml"), &Options::default()).unwrap(),
                50_000,
            )
            .unwrap(),
        };
        let files = found.files("known & \"quoted\"");
        for (name, text) in &files {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let text = &files.iter().find(|f| f.0 == "universe.xml").unwrap().1;
        let body = text.split_once("-->\n").unwrap().1;
        let again = characterise(&scene_in(folder.path(), body), 50_000).unwrap();
        for (m, name) in found.media.iter().enumerate() {
            let Some(same) = again.media.iter().position(|n| n == name) else { continue };
            if found.all.length_of(m) > 0.0
                && again.all.length_of(same) > 0.0
                && name != "lumen"
                && name != "air"
            {
                let ratio = again.all.share(same) / found.all.share(m);
                assert!((ratio - 1.0).abs() < 0.03, "{name}: {ratio}");
            }
        }
    }
}

/// Single bodies are refused with a way out.
#[test]
fn single_bodies_are_no_sheet() {
    let universe =
        "<universe kind=\"synthetic\" outside=\"air\"><sphere material=\"wall\" radius=\"1 um\"/></universe>";
    let told = characterise(&scene_in(&root(), universe), 1000).unwrap_err();
    assert!(told.contains("realised <sheet>"), "{told}");
}

/// Lines that go on within a few thicknesses of the place where they came in, on the other half of their way, find
/// what lines find that go as far as they may.
#[test]
fn short_lines_find_what_long_ones_do() {
    use lightpro::scene::plan::Plan;
    use lightpro::study::characterise::lines::{Lines, measure, with_error};
    use lightpro::universe::any::AnyUniverse;
    let scene = scene_in(&root(), &known("synthetic"));
    let plan = Plan::new(&scene).unwrap();
    let AnyUniverse::Realised(drum) = &plan.universe else { panic!() };
    let lines = |reach: f64, seed: u64| {
        let lines = Lines { number: 100_000, shared: 64, seed, reach };
        measure(drum, [plan.bottom, plan.top], plan.media.names.len(), lines)
    };
    let (long, short) = (lines(f64::INFINITY, 1), lines(12.0, 2));
    let mut worst = 0.0_f64;
    for name in ["surface", "share of pores", "mean chord of pores", "rate of level lines in pores"] {
        let of = |c: &lightpro::study::characterise::lines::Counted| match name {
            "surface" => c.surface(),
            "share of pores" => c.share(0),
            "mean chord of pores" => c.mean_chord(0),
            _ => c.ends[0][0] / c.length[0][0],
        };
        let ((a, sa), (b, sb)) = (with_error(&long, of), with_error(&short, of));
        let z = (a - b) / (sa * sa + sb * sb).sqrt();
        println!("{name}: {a:.5}({sa:.5}) far, {b:.5}({sb:.5}) near, z {z:.2}");
        assert!(z.is_finite());
        worst = worst.max(z.abs());
    }
    assert!(worst < 3.7, "{worst}"); // four at once at 1e-3
}
