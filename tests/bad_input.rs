//! Bad input: every fault of a scene is told with its place, its text underlined, and a way out; all
//! faults of a file at once; nothing panics.
#![allow(clippy::disallowed_methods, missing_docs)]

use lightpro::scene::{Diagnostics, Options, Scene, Universe, read, read_text, table};
use std::path::{Path, PathBuf};

const GOOD: &str = r#"<?xml version="1.0"?>
<!-- a scene with one of nearly everything -->
<scene name="test" version="1">
  <define name="angle" value="10 deg"/>
  <materials>
    <material id="air" index="1.00027"/>
    <material id="wall" index="1.55" absorption="0.1 1/mm">
      <scattering mu-s="1 1/mm" g="0.8"/>
      <particles diameter="0.3 um" index="2.5" kappa="0.01" volume-fraction="1 %"/>
    </material>
    <material id="copper" index-file="distributions/refractive-index/Cu_Hagemann.yml"/>
  </materials>
  <surfaces>
    <surface id="matt" kind="rough" slopes="ggx" m="0.3"><sap nside="nside 4" frame="rotated"/></surface>
  </surfaces>
  <universe kind="statistical" memory="none" edges="contained" outside="air">
    <sheet thickness="100 um" pore="air">
      <layer>
        <fibres name="pulp" material="wall" width="30 um" flatness="0.3" wall="2.3 um" grammage="60 g/m2" surface="matt"/>
        <particles shape="sphere" material="wall" volume-fraction="2 %"><diameter law="uniform" from="10 um" to="12 um"/></particles>
      </layer>
    </sheet>
  </universe>
  <source kind="collimated" polar="${angle}"/>
  <spectrum from="500 nm" to="600 nm" step="50 nm"/>
  <detect total="yes" angular="nside 8" depth="50" checkpoint="2.5 um" path="yes"/>
  <optics geometry="d/0" pile="8"/>
  <run histories="1e4" seed="7" branching="split" split-nside="2" floor="1e-2"/>
  <expect quantity="reflectance" wavelength="550 nm" value="0.8" error="0.01" source="nobody"/>
</scene>
"#;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn with(text: &str, options: &Options) -> Result<Scene, Diagnostics> {
    read_text(text, &root().join("scene.xml"), options)
}

fn scene(text: &str) -> Result<Scene, Diagnostics> {
    with(text, &Options::default())
}

/// The good scene with one piece of text replaced: the message, with the place of `at` in it.
fn broken(from: &str, to: &str) -> String {
    assert_eq!(GOOD.matches(from).count(), 1, "`{from}` must stand once in the good scene");
    let text = GOOD.replacen(from, to, 1);
    let found = scene(&text).expect_err(to);
    assert!(found.error_count() >= 1);
    found.to_string()
}

/// Asserts that the message holds every piece, and the place "line:column" of `at` in the changed text.
#[track_caller]
fn told(from: &str, to: &str, at: &str, pieces: &[&str]) {
    let text = GOOD.replacen(from, to, 1);
    let shown = broken(from, to);
    let i = GOOD.find(from).unwrap() + to.find(at).unwrap_or_else(|| panic!("{at} in {to}"));
    let line = text[..i].matches('\n').count() + 1;
    let column = text[..i].rsplit('\n').next().unwrap().chars().count() + 1;
    // Without `at` the place is another than that of the change: some line and column.
    let place = if at.is_empty() { "scene.xml:".to_string() } else { format!("scene.xml:{line}:{column}\n") };
    assert!(shown.contains(&place), "{place} not in\n{shown}");
    assert!(shown.contains('^'), "{shown}");
    for piece in pieces {
        assert!(shown.contains(piece), "`{piece}` not in\n{shown}");
    }
}

/// A byte order mark is read over, and places are counted with it (found by fuzzing: a panic).
#[test]
fn byte_order_mark() {
    assert!(scene(&format!("\u{feff}{GOOD}")).is_ok());
    for text in ["\u{feff}'<?xml version=\"1.0\"", "\u{feff}text", "\u{feff}<scene", "\u{feff}\u{feff}é<"] {
        let plain = text.trim_start_matches('\u{feff}');
        let (marked, plain) = (scene(text).unwrap_err(), scene(plain).unwrap_err());
        assert_eq!(marked.to_string().lines().next(), plain.to_string().lines().next());
    }
}

#[test]
fn the_good_scene_is_good() {
    let s = scene(GOOD).unwrap_or_else(|d| panic!("{d}"));
    assert_eq!(s.wavelengths, [500.0, 550.0, 600.0]);
    assert!(s.warnings.is_empty(), "{:?}", s.warnings);
    assert_eq!(s.files.len(), 2);
    assert_eq!(s.run.histories, 10_000);
    assert!((s.materials[1].absorption.as_ref().unwrap().at(550.0).unwrap() - 1e-4).abs() < 1e-19);
    let Universe::Statistical(sheet) = s.universe else { panic!() };
    assert_eq!(sheet.layers[0].thickness, 100.0);
    assert_eq!(sheet.layers[0].components.len(), 2);
}

#[test]
fn one_message_whole() {
    let shown =
        broken("thickness=\"100 um\"", "thicknes=\"100 um\"").replace(&root().display().to_string(), "DIR");
    let want = "\
error: unknown attribute `thicknes` of <sheet>
  --> DIR/scene.xml:17:12
   |
17 |     <sheet thicknes=\"100 um\" pore=\"air\">
   |            ^^^^^^^^ did you mean `thickness`?
   |
   = help: <sheet> takes: thickness, pore, backing, name
";
    assert!(shown.contains(want), "{shown}");
}

#[test]
fn names() {
    told(
        "<sheet thickness=\"100 um\" pore=\"air\">",
        "<sheet thicknes=\"100 um\" pore=\"air\">",
        "thicknes",
        &["did you mean `thickness`?"],
    );
    told(
        "<detect total",
        "<detekt total",
        "detekt",
        &["unknown element <detekt> in <scene>", "did you mean `detect`?"],
    );
    told(
        "kind=\"statistical\"",
        "kind=\"statistcal\"",
        "statistcal",
        &["`statistcal` is not known", "did you mean `statistical`?"],
    );
    told(
        "pore=\"air\"",
        "pore=\"aire\"",
        "aire",
        &["no material has the id `aire`", "did you mean `air`?", "defined: air, wall, copper"],
    );
    told(
        "surface=\"matt\"",
        "surface=\"mat\"",
        "mat\"",
        &["no surface has the id `mat`", "did you mean `matt`?"],
    );
    told(
        "<material id=\"wall\"",
        "<material id=\"air\"",
        "air",
        &["the id `air` is given twice", "first here"],
    );
    told(
        "seed=\"7\"",
        "seed=\"7\" seed=\"8\"",
        "seed=\"8\"",
        &["attribute `seed` is repeated", "the first is here"],
    );
    told("<detect total", "<detect/><detect total", "detect total", &["<detect> is repeated in <scene>"]);
    told(
        "kind=\"rough\"",
        "kind=\"smooth\"",
        "",
        &["attribute `m` has no effect here", "attribute `slopes` has no effect here"],
    );
    told(
        "<optics geometry=\"d/0\" pile=\"8\"/>",
        "<sheet/>",
        "sheet",
        &["unknown element <sheet> in <scene>", "does not belong here"],
    );
}

#[test]
fn numbers() {
    told(
        "100 um",
        "100",
        "100",
        &[
            "expected a length with its unit, found `100` without unit",
            "write \"100 um\"; known units: um, nm, mm, cm, m, km",
        ],
    );
    told("100 um", "100 g/m2", "100 g/m2", &["`g/m2` is no unit of it"]);
    told(
        "60 g/m2",
        "60 gsm",
        "60 gsm",
        &["expected a grammage, but `gsm` is no unit of it", "known units: g/m2, kg/m2"],
    );
    told("100 um", "-100 um", "-100 um", &["`-100 um` is out of range", "allowed: > 0 um"]);
    told("1e4", "1e999", "1e999", &["`1e999`, which is not a finite number"]);
    told("\"1e4\"", "\"1.5\"", "1.5", &["expected a whole number, found `1.5`"]);
    told("m=\"0.3\"", "m=\"nan\"", "nan", &["`nan`, which is not a finite number"]);
    told("index=\"1.55\"", "index=\"inf\"", "inf", &["`inf`, which is not a finite number"]);
    told("g=\"0.8\"", "g=\"1\"", "1\"", &["`1` is out of range", "allowed: > -1 and < 1"]);
    told(
        "flatness=\"0.3\"",
        "flatness=\"0.3 um\"",
        "0.3 um",
        &["expected a plain number, but `um` is no unit of it", "a number without unit is expected"],
    );
    told("1e-2", "one", "one", &["expected a plain number, found `one`"]);
}

#[test]
fn what_belongs_together() {
    told(
        " grammage=\"60 g/m2\"",
        "",
        "",
        &["<fibres> needs an amount", "exactly one of `grammage`, `length-density`"],
    );
    told(
        "grammage=\"60 g/m2\"",
        "grammage=\"60 g/m2\" volume-fraction=\".2\"",
        "volume-fraction",
        &["`grammage` and `volume-fraction` exclude each other"],
    );
    told(" m=\"0.3\"", "", "", &["<surface> with kind `rough` needs `m`"]);
    told(
        "<material id=\"air\" index=\"1.00027\"/>",
        "<material id=\"air\"/>",
        "material",
        &["<material> needs a refractive index"],
    );
    told(" name=\"test\"", "", "", &["<scene> needs the attribute `name`"]);
    told("60 g/m2", "200 g/m2", "", &["`pulp` would fill 133.3 %", "impossible amount"]);
    told(
        "polar=\"${angle}\"",
        "polar=\"${angle}\" trap=\"1 deg\"",
        "trap",
        &["attribute `trap` has no effect here"],
    );
    told(
        "wavelength=\"550 nm\" value",
        "wavelength=\"551 nm\" value",
        "551",
        &["the scene does not simulate 551 nm", "500, 550, 600 nm"],
    );
    told("to=\"600 nm\"", "to=\"400 nm\"", "400 nm", &["`to` is below `from`"]);
    told(
        "uniform\" from=\"10 um\"",
        "lognormal\" median=\"10 um\"",
        "",
        &["<diameter> with law `lognormal` needs `sigma`"],
    );
}

#[test]
fn cut_edges_take_one_layer_of_bodies() {
    let two = GOOD
        .replace("edges=\"contained\"", "edges=\"cut\"")
        .replace("</layer>", "</layer><layer thickness=\"10 um\"><fibres material=\"wall\" width=\"30 um\" wall=\"solid\" grammage=\"1 g/m2\"/></layer>");
    let shown = scene(&two).expect_err("two layers").to_string();
    assert!(shown.contains("a second layer of bodies under edges=\"cut\""), "{shown}");
    assert!(
        shown.contains("use edges=\"contained\" or memory=\"full\", or put all bodies into one layer"),
        "{shown}"
    );
}

/// What a memory rung cannot do is said with a way out.
#[test]
fn memory_rungs_say_what_they_cannot() {
    let sheet = |memory: &str, edges: &str, fibres: &str, run: &str| {
        let text = format!(
            r#"<scene name="rungs" version="1">
  <materials><material id="air" index="1"/><material id="wall" index="1.5"><scattering mu-s="10 1/mm"/></material></materials>
  <universe kind="statistical" memory="{memory}" edges="{edges}">
    <sheet thickness="100 um" pore="air"><layer><fibres material="wall" width="20 um" wall="solid" volume-fraction="0.3" {fibres}</layer></sheet>
  </universe>
  <source kind="diffuse"/><spectrum at="550 nm"/>
  <run histories="4096" {run}/>
</scene>"#
        );
        scene(&text)
    };
    sheet("full", "contained", "/>", "histories-per-realisation=\"16\"").expect("a good scene");
    for (memory, edges, fibres, run, says) in [
        ("4", "contained", "/>", "", "a finite memory is wrong for `fibres`, whose material scatters inside"),
        ("full", "contained", "bonded=\"0.2\"/>", "", "`bonded` of `fibres` belongs to memory=\"none\""),
        (
            "markov",
            "cut",
            "><profile><at depth=\"0\" density=\"1\"/></profile></fibres>",
            "",
            "this memory knows no <profile>",
        ),
        ("none", "contained", "tilt=\"10 deg\"/>", "", "cannot lie wholly in the sheet"),
        (
            "full",
            "cut",
            "tilt=\"10 deg\"><profile><at depth=\"0\" density=\"1\"/></profile></fibres>",
            "",
            "have no depth that a <profile> could ask for",
        ),
        ("none", "contained", "/>", "histories-per-realisation=\"16\"", "only where it is remembered"),
        ("full", "contained", "/>", "histories-per-realisation=\"12\"", "no whole number of realisations"),
    ] {
        let shown = sheet(memory, edges, fibres, run).expect_err(says).to_string();
        assert!(shown.contains(says) && shown.contains("help:"), "{says}:\n{shown}");
    }
}

#[test]
fn files() {
    told(
        "distributions/refractive-index/Cu_Hagemann.yml",
        "distributions/refractive-index/Cu_Hageman.yml",
        "distributions",
        &["no such file", "did you mean `Cu_Hagemann.yml`?"],
    );
    told(
        "distributions/refractive-index/Cu_Hagemann.yml",
        "../../etc/passwd",
        "../../etc/passwd",
        &["is outside the scene's folder", "/etc/passwd", "--allow-outside"],
    );
    told(
        "distributions/refractive-index/Cu_Hagemann.yml",
        "distributions/refractive-index/COMMIT.txt",
        "distributions",
        &["COMMIT.txt"],
    );
    told("from=\"500 nm\" to=\"600 nm\"", "from=\"500 nm\" to=\"900000 nm\"", "", &["scene.xml:11:"]);
}

#[test]
fn a_path_out_is_allowed_by_the_option_only() {
    let dir = tempfile::tempdir().unwrap();
    let inside = dir.path().join("inside");
    std::fs::create_dir(&inside).unwrap();
    std::fs::write(dir.path().join("mu.csv"), "nm,mu\n400,0.1\n700,0.2\n").unwrap();
    let text = GOOD
        .replace("distributions/refractive-index/Cu_Hagemann.yml", "n.yml")
        .replace("index-file=\"n.yml\"", "index=\"1.2\" absorption-file=\"../mu.csv\"");
    let at = inside.join("scene.xml");
    let refused = read_text(&text, &at, &Options::default()).expect_err("outside").to_string();
    assert!(refused.contains("is outside the scene's folder") && refused.contains("mu.csv"), "{refused}");
    let allowed = Options { allow_outside: true, ..Options::default() };
    let s = read_text(&text, &at, &allowed).unwrap_or_else(|d| panic!("{d}"));
    let mu = s.materials[2].absorption.as_ref().unwrap();
    assert!((mu.at(550.0).unwrap() - 0.15).abs() < 1e-15);
    #[cfg(unix)]
    {
        // A link inside that leads out is a way out too.
        std::os::unix::fs::symlink(dir.path().join("mu.csv"), inside.join("link.csv")).unwrap();
        let linked = text.replace("../mu.csv", "link.csv");
        assert!(read_text(&linked, &at, &Options::default()).is_err());
    }
}

#[test]
fn wavelengths_outside_a_table() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("mu.csv"), "nm,mu\n520,0.1\n700,0.2\n").unwrap();
    let text = GOOD.replace(
        "index-file=\"distributions/refractive-index/Cu_Hagemann.yml\"",
        "index=\"1.2\" absorption-file=\"mu.csv\"",
    );
    let at = dir.path().join("scene.xml");
    let shown = read_text(&text, &at, &Options::default()).expect_err("500 nm").to_string();
    assert!(
        shown.contains("mu.csv: absorption is known from 520 nm to 700 nm, the scene asks for 500 nm"),
        "{shown}"
    );
    assert!(shown.contains("extrapolate=\"clamp\""), "{shown}");
    let clamped = text.replace("absorption-file=", "extrapolate=\"clamp\" absorption-file=");
    let s = read_text(&clamped, &at, &Options::default()).unwrap_or_else(|d| panic!("{d}"));
    assert_eq!(s.warnings.len(), 1);
    assert!(s.warnings[0].contains("its end values are held"), "{}", s.warnings[0]);
    assert_eq!(s.materials[2].absorption.as_ref().unwrap().at(500.0), Ok(0.1));
}

#[test]
fn xml_itself() {
    let cut = &GOOD[..GOOD.len() / 2];
    let deep = format!("<scene>{}", "<a>".repeat(80));
    for (text, want) in [
        (cut.to_string(), "not closed"),
        (GOOD.replace("</scene>", ""), "the file ends inside <scene>"),
        (format!("{GOOD}<scene/>"), "a second root element <scene>"),
        (String::new(), "the file has no root element"),
        (format!("{GOOD}trailing"), "text after the end of <scene>"),
        (GOOD.replace("<materials>", "<materials>air"), "text inside <materials>"),
        (GOOD.replace("nobody", "no\0body"), "a NUL byte"),
        (GOOD.replace("nobody", "&nobody;"), "undefined or malformed entity"),
        (format!("<!DOCTYPE scene [<!ENTITY a \"b\">]>{}", &GOOD[21..]), "a DOCTYPE is not allowed"),
        (deep, "nested deeper than 64"),
        ("<distribution/>".to_string(), "the root element is <distribution>"),
    ] {
        let found = scene(&text).expect_err(want);
        assert_eq!(found.error_count(), 1, "{found}");
        let shown = found.to_string();
        assert!(shown.contains(want), "{shown}");
        assert!(shown.contains("scene.xml:"), "{shown}");
    }
    let dir = tempfile::tempdir().unwrap();
    let big = dir.path().join("big.xml");
    std::fs::File::create(&big).unwrap().set_len((64 << 20) + 1).unwrap();
    let shown = read(&big, &Options::default()).expect_err("large").to_string();
    assert!(shown.contains("larger than 64 MiB"), "{shown}");
    let shown = read(&dir.path().join("none.xml"), &Options::default()).expect_err("none").to_string();
    assert!(shown.contains("none.xml: no such file"), "{shown}");
}

#[test]
fn all_errors_at_once() {
    let text = GOOD
        .replace("100 um", "100")
        .replace("<detect total", "<detekt total")
        .replace("pore=\"air\"", "pore=\"aire\"")
        .replace("g=\"0.8\"", "g=\"2\"")
        .replace("name=\"test\"", "nam=\"test\"")
        .replace("seed=\"7\"", "seed=\"-7\"");
    let found = scene(&text).expect_err("six faults");
    assert_eq!(found.error_count(), 6, "{found}");
    let shown = found.to_string();
    assert!(shown.ends_with("6 errors\n"), "{shown}");
    let lines: Vec<usize> = found.errors().filter_map(|d| d.place).map(|p| found.line_column(p).0).collect();
    for line in [3, 8, 17, 26, 28] {
        assert!(lines.contains(&line), "line {line} of {lines:?}");
    }
}

#[test]
fn placeholders() {
    let polar = |s: &Scene| match s.source {
        lightpro::scene::Source::Collimated { polar, .. } => polar.to_degrees(),
        _ => panic!(),
    };
    assert!((polar(&scene(GOOD).unwrap()) - 10.0).abs() < 1e-12);
    let options = |n: &str, v: &str| Options { defines: vec![(n.into(), v.into())], ..Options::default() };
    assert!((polar(&with(GOOD, &options("angle", "45 deg")).unwrap()) - 45.0).abs() < 1e-12);
    let shown = with(GOOD, &options("angel", "45 deg")).expect_err("unused").to_string();
    assert!(shown.contains("-D angel=45 deg: no attribute asks for ${angel}"), "{shown}");
    assert!(shown.contains("did you mean `angle`?"), "{shown}");
    let shown = with(GOOD, &options("angle", "45")).expect_err("no unit").to_string();
    assert!(shown.contains("found `45` without unit"), "{shown}");
    told(
        "${angle}",
        "${angel}",
        "${angel}",
        &["the placeholder ${angel} has no value", "did you mean ${angle}?"],
    );
    told("${angle}", "${angle", "${angle", &["a placeholder without `}`"]);
}

#[test]
fn contradictions_are_warned_of() {
    let text = GOOD.replace("grammage=\"60 g/m2\"", "grammage=\"60 g/m2\" coarseness=\"0.5 mg/m\"");
    let s = scene(&text).unwrap_or_else(|d| panic!("{d}"));
    assert_eq!(s.warnings.len(), 1, "{:?}", s.warnings);
    // π (15·4.5 − 12.7·2.2) = 124.28 µm², times 1500 kg/m³ = 0.186 mg/m.
    assert!(s.warnings[0].contains("coarseness 0.5 mg/m"), "{}", s.warnings[0]);
    assert!(s.warnings[0].contains("wall area of 124.3 um2 is 0.186 mg/m"), "{}", s.warnings[0]);
    let near = GOOD.replace("grammage=\"60 g/m2\"", "grammage=\"60 g/m2\" coarseness=\"0.17 mg/m\"");
    assert!(scene(&near).unwrap().warnings.is_empty());

    let small = GOOD.replace("from=\"10 um\" to=\"12 um\"", "from=\"0.9 um\" to=\"1.1 um\"");
    let s = scene(&small).unwrap();
    // 1 µm: π·1.00027/0.6 · (1.55/1.00027 − 1) = 2.88.
    assert!(s.warnings[0].contains("x|m − 1| = 2.88 at 600 nm"), "{:?}", s.warnings);
}

/// Every law and orientation by its name; means as the laws' formulas say.
#[test]
fn laws() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("w.csv"), "from,to,weight\n10,20,1\n20,40,3\n").unwrap();
    for (law, mean) in [
        ("law=\"constant\" value=\"30 um\"", 30.0),
        ("law=\"uniform\" from=\"20 um\" to=\"40 um\"", 30.0),
        ("law=\"truncated-normal\" mean=\"30 um\" sd=\"5 um\" from=\"10 um\" to=\"50 um\"", 30.0),
        ("law=\"lognormal\" median=\"30 um\" sigma=\"0.2\"", 30.0 * 0.02_f64.exp()),
        ("law=\"gamma\" mean=\"0.03 mm\" shape=\"4\"", 30.0),
        ("law=\"weibull\" scale=\"30 um\" shape=\"1\"", 30.0),
        ("law=\"beta\" alpha=\"2\" beta=\"2\" from=\"20 um\" to=\"40 um\"", 30.0),
        ("law=\"histogram\" edges=\"10 20 40 um\" weights=\"1 3\"", 26.25),
        ("law=\"histogram\" file=\"w.csv\"", 26.25),
        // Mass of a hollow fibre ∝ width: number density ∝ pdf/x, mean 20/ln 2 on [20, 40].
        ("law=\"uniform\" from=\"20 um\" to=\"40 um\" weighted=\"mass\"", 20.0 / 2.0_f64.ln()),
    ] {
        let text = GOOD
            .replace("index-file=\"distributions/refractive-index/Cu_Hagemann.yml\"", "index=\"1.2\"")
            .replace(
                "width=\"30 um\" ",
                "orientation=\"wrapped-cauchy\" rho=\"0.3\" roll=\"normal\" roll-sd=\"5 deg\" ",
            )
            .replace("surface=\"matt\"/>", &format!("surface=\"matt\"><width {law}/></fibres>"));
        let s = read_text(&text, &dir.path().join("scene.xml"), &Options::default())
            .unwrap_or_else(|d| panic!("{d}"));
        let Universe::Statistical(sheet) = &s.universe else { panic!() };
        let lightpro::scene::Shape::Fibre { width, .. } = &sheet.layers[0].components[0].shape else {
            panic!()
        };
        assert!((width.mean() / mean - 1.0).abs() < 1e-6, "{law}: {} for {mean}", width.mean());
    }
    told(
        "<diameter law=\"uniform\" from=\"10 um\" to=\"12 um\"/>",
        "<diameter law=\"uniform\" from=\"12 um\" to=\"10 um\"/>",
        "diameter",
        &["must be greater than the lower end"],
    );
    told(
        "flatness=\"0.3\" wall=\"2.3 um\" grammage=\"60 g/m2\" surface=\"matt\"/>",
        "wall=\"2.3 um\" grammage=\"60 g/m2\" surface=\"matt\"><flatness law=\"gamma\" mean=\".3\" shape=\"9\"/></fibres>",
        "flatness law",
        &["<flatness> may not exceed 1"],
    );
}

/// Explicit bodies, and a homogeneous sheet turned into slabs.
#[test]
fn synthetic() {
    use lightpro::scene::Geometry;
    let scene_with = |bodies: &str| {
        let (start, end) = (GOOD.find("<universe").unwrap(), GOOD.find("</universe>").unwrap());
        let surfaces = GOOD.find("  <surfaces>").unwrap();
        let universe = format!("<universe kind=\"synthetic\">{bodies}");
        scene(&format!("{}{}{universe}{}", &GOOD[..surfaces], &GOOD[surfaces..start], &GOOD[end..]))
    };
    let bodies = "<sphere centre=\"0 0 -2 um\" radius=\"3 um\" material=\"copper\" surface=\"matt\" priority=\"-1\"/>\
        <ellipsoid half-axes=\"9 8 7 um\" axis=\"0 0 5\" major=\"0 2 1\" material=\"wall\"/>\
        <cylinder radius=\"5 um\" wall=\"1 um\" length=\"1 mm\" axis=\"1 1 0\" material=\"wall\"/>\
        <box min=\"0 0 0 um\" max=\"1 1 1 um\" material=\"wall\"/>\
        <plane normal=\"0 0 -3\" material=\"wall\"/><slab z-min=\"-1 um\" z-max=\"2 um\" material=\"wall\"/>";
    let s = scene_with(bodies).unwrap_or_else(|d| panic!("{d}"));
    let Universe::Synthetic(u) = &s.universe else { panic!() };
    assert_eq!(u.bodies.len(), 6);
    assert_eq!((u.bodies[0].priority, u.bodies[0].surface.0, u.bodies[0].material.0), (-1, 1, 2));
    let Geometry::Ellipsoid { axis, major, .. } = u.bodies[1].geometry else { panic!() };
    assert!(axis.dot(major).abs() < 1e-15 && (major.y - 1.0).abs() < 1e-15);
    let Geometry::Cylinder { half_length, lumen, axis, major, .. } = u.bodies[2].geometry else { panic!() };
    assert_eq!((half_length, lumen.map(|l| l.0)), (Some(500.0), Some((4.0, 4.0))));
    assert!(axis.dot(major).abs() < 1e-15 && major.z == 0.0);
    let s = scene_with("<sheet thickness=\"30 um\"><layer material=\"wall\" thickness=\"10 um\"/><layer material=\"air\"/></sheet>")
        .unwrap_or_else(|d| panic!("{d}"));
    let Universe::Synthetic(u) = &s.universe else { panic!() };
    assert_eq!(u.bodies[0].geometry_z(), (20.0, 30.0));
    assert_eq!(u.bodies[1].geometry_z(), (0.0, 20.0));
    for (bad, want) in [
        ("", "the universe is empty"),
        ("<sphere radius=\"1 um\"/>", "<sphere> needs the attribute `material`"),
        ("<cylinder radius=\"1 um\" wall=\"2 um\" material=\"wall\"/>", "leaves no lumen"),
        ("<cylinder radius=\"1 um\" major=\"2 0 0\" material=\"wall\"/>", "`major` is parallel to `axis`"),
        ("<plane normal=\"0 0 0\" material=\"wall\"/>", "a direction of length zero"),
        ("<box min=\"0 0 0 um\" max=\"1 0 1 um\" material=\"wall\"/>", "must be above that of `min`"),
        ("<sphere centre=\"1 2 um\" radius=\"1 um\" material=\"wall\"/>", "expected 3 numbers, found 2"),
    ] {
        let shown = scene_with(bad).expect_err(want).to_string();
        assert!(shown.contains(want), "{shown}");
    }
}

trait GeometryZ {
    fn geometry_z(&self) -> (f64, f64);
}
impl GeometryZ for lightpro::scene::Body {
    fn geometry_z(&self) -> (f64, f64) {
        match self.geometry {
            lightpro::scene::Geometry::Slab { z_min, z_max } => (z_min, z_max),
            _ => panic!("no slab"),
        }
    }
}

/// Every shipped XML file is read: scenes as they are, distributions through a scene that uses them.
#[test]
fn shipped_files() {
    let mut files = Vec::new();
    for folder in ["distributions", "scenes", "examples"] {
        collect(&root().join(folder), &mut files);
    }
    let mut counted = 0;
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        // Parts are read by the scenes that include them.
        if text.contains("<scene-part>") {
            continue;
        }
        let s = if text.contains("<distribution") {
            scene_of(&file, &text)
        } else {
            read(&file, &Options::default())
        };
        let s = s.unwrap_or_else(|d| panic!("{}:\n{d}", file.display()));
        let flakes = text.contains("kind=\"flakes\"");
        assert!(flakes || !text.contains("<distribution") || s.warnings.is_empty(), "{:?}", s.warnings);
        counted += 1;
    }
    assert!(counted >= 10, "{counted} files");
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let Ok(list) = std::fs::read_dir(folder) else { return };
    for entry in list.map(|e| e.unwrap().path()) {
        if entry.is_dir() {
            collect(&entry, files);
        } else if entry.extension().is_some_and(|e| e == "xml") {
            files.push(entry);
        }
    }
}

fn scene_of(file: &Path, text: &str) -> Result<Scene, Diagnostics> {
    let path = file.strip_prefix(root()).unwrap().display().to_string();
    let text = if text.contains("kind=\"filler\"") {
        GOOD.replace(
            "<particles diameter=\"0.3 um\" index=\"2.5\" kappa=\"0.01\" ",
            &format!("<particles from=\"{path}\" "),
        )
    } else if text.contains("kind=\"flakes\"") {
        GOOD.replace("<particles shape=\"sphere\" material", &format!("<particles from=\"{path}\" material"))
            .replace("<diameter law=\"uniform\" from=\"10 um\" to=\"12 um\"/>", "")
    } else {
        GOOD.replace("width=\"30 um\" flatness=\"0.3\" wall=\"2.3 um\"", &format!("from=\"{path}\""))
    };
    assert!(text.contains(&path));
    scene(&text)
}

/// The coarseness that a pulp file states agrees with its section within 5 %.
#[test]
fn pulps_agree_with_themselves() {
    for name in ["bleached-softwood-kraft", "birch-kraft", "eucalyptus-kraft", "tmp", "ctmp"] {
        let file = root().join(format!("distributions/pulp/{name}.xml"));
        let text = std::fs::read_to_string(&file).unwrap();
        let s = scene_of(&file, &text).unwrap_or_else(|d| panic!("{d}"));
        let Universe::Statistical(sheet) = &s.universe else { panic!() };
        let c = &sheet.layers[0].components[0];
        let implied = lightpro::scene::implied_coarseness(c).unwrap();
        let stated = c.coarseness.unwrap();
        println!(
            "{name}: stated {stated} mg/m, section {implied:.4} mg/m, {:+.1} %",
            100.0 * (implied / stated - 1.0)
        );
        assert!((implied / stated - 1.0).abs() < 0.05, "{name}: {implied} against {stated}");
    }
}

/// An attribute set from the command line, by id and by element; parts of scenes; what is wrong with them.
#[test]
fn attributes_from_outside_and_parts() {
    let set = |name: &str, value: &str| Options {
        defines: vec![(name.to_owned(), value.to_owned())],
        ..Options::default()
    };
    let s = with(GOOD, &set("wall.index", "1.53")).unwrap_or_else(|d| panic!("{d}"));
    assert_eq!(s.materials[1].index.at(550.0).unwrap().re, 1.53);
    let s = with(GOOD, &set("run.seed", "11")).unwrap_or_else(|d| panic!("{d}"));
    assert_eq!(s.run.seed, 11);
    for (name, want) in [
        ("walls.index", "no element has the id or name `walls`"),
        ("material.index", "3 elements are called `material`"),
        ("wall.indx", "did you mean `index`"),
    ] {
        let shown = with(GOOD, &set(name, "1")).expect_err(name).to_string();
        assert!(shown.contains(want), "{shown}");
    }
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
    write(
        "media.xml",
        r#"<scene-part><materials><material id="glass" index="1.5"/></materials></scene-part>"#,
    );
    write("other.xml", "<scene name=\"x\" version=\"1\"/>");
    let scene = |file: &str| {
        format!(
            r#"<scene name="x" version="1"><include file="{file}"/>
  <materials><material id="air" index="1"/></materials>
  <universe kind="synthetic" outside="air"><sphere radius="3 um" material="glass"/></universe></scene>"#
        )
    };
    let read = |file: &str| read_text(&scene(file), &dir.path().join("x.xml"), &Options::default());
    let s = read("media.xml").unwrap_or_else(|d| panic!("{d}"));
    assert_eq!((s.materials.len(), s.files.len()), (2, 2));
    assert!(read("other.xml").expect_err("a scene").to_string().contains("the file holds <scene>"));
    assert!(read("meda.xml").expect_err("no file").to_string().contains("did you mean `media.xml`"));
}

/// Generated files stand in the repository as they are generated. `LIGHTPRO_WRITE=1` writes them.
#[test]
fn schema_and_page_are_in_step() {
    for (path, text) in [("schema/scene.xsd", table::xsd()), ("docs/scene.md", table::markdown())] {
        let path = root().join(path);
        if std::env::var_os("LIGHTPRO_WRITE").is_some() {
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, &text).unwrap();
        }
        let stands = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(stands == text, "{} is out of step: run this test with LIGHTPRO_WRITE=1", path.display());
    }
}

/// Bytes deleted, replaced, doubled and swapped at random: an answer every time, and every message can
/// be rendered.
#[test]
fn mutations_never_panic() {
    use lightpro::rng::{Purpose, Stream};
    let mut rng = Stream::of(20_261_122, 0, 0, Purpose::Probe);
    let mut below = |n: usize| (rng.uniform() * n as f64) as usize;
    let alphabet: Vec<char> = "<>/\"'=&;${}%-+.0123456789eEnaif um\n\0µ²🦀x".chars().collect();
    let (mut accepted, mut refused) = (0, 0);
    for _ in 0..3000 {
        let mut text: Vec<char> = GOOD.chars().collect();
        for _ in 0..1 + below(4) {
            let i = below(text.len());
            match below(5) {
                0 => {
                    text.remove(i);
                }
                1 => text[i] = alphabet[below(alphabet.len())],
                2 => text.insert(i, alphabet[below(alphabet.len())]),
                3 => {
                    let j = (i + 1 + below(40)).min(text.len());
                    text.drain(i..j);
                }
                _ => {
                    let j = (i + 1 + below(40)).min(text.len());
                    let piece: Vec<char> = text[i..j].to_vec();
                    let k = below(text.len());
                    text.splice(k..k, piece);
                }
            }
        }
        let text: String = text.into_iter().collect();
        match scene(&text) {
            Ok(_) => accepted += 1,
            Err(d) => {
                refused += 1;
                assert!(d.error_count() > 0 && d.to_string().contains("error"));
            }
        }
    }
    println!("{accepted} accepted, {refused} refused");
    assert!(refused > 1000 && accepted > 10);
}
