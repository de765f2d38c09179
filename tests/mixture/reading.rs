//! Mixtures in scene files.

use lightpro::scene::plan::Plan;
use lightpro::scene::{Diagnostics, Memory, Options, Scene, Universe, read_text};
use lightpro::universe::any::AnyUniverse;
use lightpro::universe::mixture::Rung;
use std::path::Path;

const GOOD: &str = r#"<scene name="test" version="1">
  <materials>
    <material id="air" index="1"/>
    <material id="a" index="1" absorption="0.1 1/um"/>
    <material id="b" index="1"><scattering mu-s="1 1/um"/></material>
    <material id="glass" index="1.5"/>
  </materials>
  <universe kind="statistical" memory="full" outside="air">
    <mixture thickness="10 um">
      <phase material="a" chord="1.5 um"/>
      <phase material="b" chord="500 nm"/>
    </mixture>
  </universe>
</scene>
"#;

fn scene(text: &str) -> Result<Scene, Diagnostics> {
    read_text(text, Path::new("scene.xml"), &Options::default())
}

fn with(from: &str, to: &str) -> String {
    assert_eq!(GOOD.matches(from).count(), 1, "{from}");
    GOOD.replacen(from, to, 1)
}

#[track_caller]
fn told(from: &str, to: &str, pieces: &[&str]) {
    let shown = scene(&with(from, to)).expect_err(to).to_string();
    for piece in pieces {
        assert!(shown.contains(piece), "`{piece}` not in\n{shown}");
    }
}

#[test]
fn a_mixture_is_read() {
    let s = scene(GOOD).unwrap_or_else(|d| panic!("{d}"));
    let Universe::Mixture(m) = &s.universe else { panic!() };
    assert_eq!((m.memory, m.thickness, m.phases.len()), (Memory::Full, 10.0, 2));
    assert_eq!((m.phases[1].chord, m.phases[1].share), (0.5, 1.0));
    let plan = Plan::new(&s).unwrap();
    assert_eq!((plan.top, plan.bottom), (10.0, 0.0));
    assert!(plan.remarks.iter().any(|r| r.contains("'a' 75.00 %")), "{:?}", plan.remarks);
}

#[test]
fn every_rung_is_read() {
    for (memory, want) in [
        ("none", Some("Phase")),
        ("markov", Some("Phase")),
        ("1", Some("Layers(1)")),
        ("8", Some("Layers(8)")),
        ("full", Some("Full")),
        ("homogeneous", None),
    ] {
        let s = scene(&with(r#"memory="full""#, &format!(r#"memory="{memory}""#))).unwrap();
        match (Plan::new(&s).unwrap().universe, want) {
            (AnyUniverse::Mixture(u), Some(want)) => {
                let rung: Rung = u.rung();
                assert_eq!(format!("{rung:?}"), want);
            }
            (AnyUniverse::Statistical(_), None) => {}
            (other, _) => panic!("{memory}: {other:?}"),
        }
    }
}

#[test]
fn faults_are_told() {
    told(r#"<phase material="b" chord="500 nm"/>"#, "", &["at least two phases", "<layer material=…/>"]);
    told(r#"chord="500 nm""#, r#"chord="0 um""#, &["`0 um` is out of range"]);
    told(r#"chord="500 nm""#, "", &["<phase> needs the attribute `chord`"]);
    told(r#"material="b" chord"#, r#"material="c" chord"#, &["`c`"]);
    told(r#"memory="full""#, r#"memory="0""#, &["out of range"]);
    told(r#"memory="full""#, r#"memory="all""#, &["homogeneous, markov, none, full"]);
    told(r#"outside="air""#, r#"outside="air" edges="cut""#, &["attribute `edges` has no effect here"]);
    told(r#"kind="statistical" memory="full""#, r#"kind="synthetic""#, &["known by its statistics only"]);
    let uneven = with(r#"memory="full""#, r#"memory="homogeneous""#);
    let uneven = uneven.replacen(r#"material="b""#, r#"material="glass""#, 1);
    assert!(scene(&uneven).expect_err("").to_string().contains("no homogeneous average"));
}
