//! `realise` and `check --structure`: the same sheet as explicit scene, mesh and voxels.
#![allow(clippy::disallowed_methods, missing_docs)]

use assert_cmd::Command;
use lightpro::run::simulate;
use lightpro::scene::plan::Plan;
use lightpro::scene::{Options, Scene, Universe, read};
use lightpro::study::characterise::characterise;
use std::path::Path;

const SHEET: &str = r#"<?xml version="1.0"?>
<!-- kept -->
<scene name="tubes" version="1">
  <materials><material id="air" index="1"/><material id="lumen" index="1"/><material id="wall" index="1.55"/></materials>
  <universe kind="statistical" memory="full" outside="air" edges="contained">
    <sheet thickness="30 um" pore="air"><layer>
      <fibres name="pulp" material="wall" lumen="lumen" width="10 um" flatness=".5" wall="1.5 um" length="100 um" ends="flat" grammage="8 g/m2"/>
      <particles shape="sphere" material="wall" diameter="5 um" volume-fraction="1 %"/>
    </layer></sheet>
  </universe>
  <source kind="diffuse"/>
  <run histories="16384"/>
</scene>
"#;

fn lightpro(folder: &Path, args: &[&str]) -> std::process::Output {
    Command::cargo_bin("lightpro").unwrap().current_dir(folder).args(args).output().unwrap()
}

fn told(out: &std::process::Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&out.stdout), String::from_utf8_lossy(&out.stderr))
}

fn scene(path: &Path) -> Scene {
    read(path, &Options::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// R with its standard error.
fn reflectance(scene: &Scene) -> (f64, f64) {
    let plan = Plan::new(scene).unwrap();
    let outcome = simulate(scene, &plan, |_| true).unwrap();
    assert_eq!(outcome.troubled().0, 0);
    let (_, group, lane) = outcome.wavelengths().next().unwrap();
    let m = group.moments(group.layout.of(lightpro::tally::Cell::Reflected), lane);
    (m.mean(), m.standard_error())
}

/// One sheet, three scenes: bodies, and voxels of them, hold the same shares of volume and reflect alike; the
/// ensemble that they were drawn from lies within the spread of realisations.
#[test]
fn one_sheet_as_bodies_and_as_voxels() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("sheet.xml"), SHEET).unwrap();
    let args = ["realise", "sheet.xml", "--cell", "0.15 mm", "--voxel", "0.25 um", "--vti"];
    let out = lightpro(folder.path(), &args);
    assert!(out.status.success(), "{}", told(&out));
    // Nothing is overwritten without being asked to.
    let again = lightpro(folder.path(), &args);
    assert_eq!(again.status.code(), Some(2));
    assert!(told(&again).contains("--force"), "{}", told(&again));

    let text = std::fs::read_to_string(path("sheet-realised.xml")).unwrap();
    assert!(text.contains("<!-- kept -->") && text.contains("<run histories=\"16384\"/>"));
    let (bodies, voxels) = (scene(&path("sheet-realised.xml")), scene(&path("sheet-realised-voxels.xml")));
    let Universe::Synthetic(explicit) = &bodies.universe else { panic!("no bodies") };
    assert!(explicit.bodies.len() > 40 && explicit.cell.unwrap().period == [150.0; 2]);

    let (b, v) = (characterise(&bodies, 50_000).unwrap(), characterise(&voxels, 50_000).unwrap());
    for (name, medium) in [("wall", 2), ("lumen", 1)] {
        // In the scene of voxels media are materials.
        let (in_bodies, in_voxels) = (b.value(|c| c.share(medium)), v.value(|c| c.share(medium)));
        let off = in_voxels.0 / in_bodies.0 - 1.0;
        println!("{name}: {in_bodies:?} as bodies, {in_voxels:?} as voxels");
        assert!(off.abs() < 0.02, "{name}: {off}");
    }
    let ((rb, sb), (rv, sv)) = (reflectance(&bodies), reflectance(&voxels));
    println!("R {rb:.4}({sb:.4}) as bodies, {rv:.4}({sv:.4}) as voxels");
    // Walls are six voxels thick (with three R is .02 lower: docs/voxels.md).
    assert!((rb - rv).abs() < 0.01 + 3.0 * (sb * sb + sv * sv).sqrt());
    let (r, s) = reflectance(&scene(&path("sheet.xml")));
    println!("R {r:.4}({s:.4}) by statistics");
    assert!((rb - r).abs() < 0.06);
}

/// `compare` makes the realisation itself: the same bodies, as they are and as voxels, beside the ensemble.
#[test]
fn a_comparison_of_statistics_bodies_and_voxels() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("sheet.xml"), SHEET).unwrap();
    let wanted = "compare sheet.xml -D pulp.wall=1.6um --universes full,bodies,voxels --reference bodies --quiet -o out";
    let mut args: Vec<&str> = wanted.split(' ').collect();
    let refused = lightpro(folder.path(), &args);
    assert_eq!(refused.status.code(), Some(2));
    assert!(told(&refused).contains("--voxel 0.5um"), "{}", told(&refused));
    args.extend(["--voxel", "0.25 um", "--cell", "0.15 mm", "--max-time", "60 s"]);
    let out = lightpro(folder.path(), &args);
    assert!(out.status.success(), "{}", told(&out));
    let out = folder.path().join("out");
    let verdicts = std::fs::read_to_string(out.join("verdicts.csv")).unwrap();
    let of = |universe: &str| verdicts.lines().filter(|l| l.starts_with(universe)).count();
    assert!(of("full") > 0 && of("full") == of("voxels") && of("bodies") == 0, "{verdicts}");
    let text = std::fs::read_to_string(out.join("compare.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    println!("{verdicts}{}", json["reference"]);
    assert_eq!(json["reference"], "bodies");
    for file in ["realisation.xml", "realisation-voxels.nrrd", "realisation.vtp", "report.html"] {
        assert!(out.join(file).is_file(), "{file}");
    }
}

/// Placeholders and values of the command line stand in the written scene, in its universe and elsewhere.
#[test]
fn values_of_the_command_line_stand_in_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let text = SHEET.replace("index=\"1.55\"", "index=\"${n}\"").replace("\"10 um\"", "\"${w}\"").replace(
        "<materials>",
        "<define name=\"n\" value=\"1.55\"/><define name=\"w\" value=\"8 um\"/><materials>",
    );
    std::fs::write(folder.path().join("sheet.xml"), text).unwrap();
    let wanted = "realise sheet.xml -D n=1.6 -D pulp.length=80um -D run.seed=7 --cell 0.15mm -o out";
    let out = lightpro(folder.path(), &wanted.split(' ').collect::<Vec<_>>());
    assert!(out.status.success(), "{}", told(&out));
    let text = std::fs::read_to_string(folder.path().join("out.xml")).unwrap();
    assert!(!text.contains("${") && !text.contains("<define"), "{text}");
    let read = scene(&folder.path().join("out.xml"));
    assert_eq!(read.run.seed, 7);
    assert!(text.contains("<run seed=\"7\" histories=\"16384\"/>") && text.contains("index=\"1.6\""));
    let fibres: Vec<&str> = text.lines().filter(|l| l.contains("<cylinder")).collect();
    let drawn = |l: &str| l.contains("half-axes=\"4 2 um\"") && l.contains("length=\"80 um\"");
    assert!(fibres.len() > 10 && fibres.iter().all(|l| drawn(l)), "{:?}", fibres.first());
}

/// The mesh holds every body: two rings of a fibre's outside and two of its lumen, and the rings of spheres.
#[test]
fn a_mesh_of_all_bodies() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("sheet.xml"), SHEET).unwrap();
    let out = lightpro(folder.path(), &["realise", "sheet.xml", "--cell", "0.25 mm", "-o", "cell"]);
    assert!(out.status.success(), "{}", told(&out));
    let text = std::fs::read_to_string(folder.path().join("cell.xml")).unwrap();
    let (fibres, spheres) = (text.matches("<cylinder").count(), text.matches("<sphere").count());
    let vtp = std::fs::read_to_string(folder.path().join("cell.vtp")).unwrap();
    let number = |name: &str| -> usize {
        let rest = vtp.split_once(&format!("{name}=\"")).unwrap().1;
        rest.split_once('"').unwrap().0.parse().unwrap()
    };
    assert_eq!(number("NumberOfPoints"), fibres * 4 * 16 + spheres * 9 * 16);
    assert_eq!(number("NumberOfPolys"), fibres * (2 * 16 + 2) + spheres * 8 * 16);
    // As many of each kind as the densities say, within four standard deviations of Poisson numbers.
    assert!(fibres > 50 && spheres > 50, "{fibres} {spheres}");
}

/// Amounts found by straight lines, overlaps with coordinates, sections as pictures.
#[test]
fn the_structure_is_told_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("sheet.xml"), SHEET.replace("statistical", "synthetic")).unwrap();
    let out = lightpro(folder.path(), &["check", "sheet.xml", "--structure", "-o", "pictures"]);
    let text = told(&out);
    assert!(out.status.success(), "{text}");
    let line = text.lines().find(|l| l.contains("g/m2 of solid found") && l.starts_with("pulp")).unwrap();
    let found: f64 = line.split_whitespace().nth(1).unwrap().split('(').next().unwrap().parse().unwrap();
    assert!((found / 8.0 - 1.0).abs() < 0.01, "{line}");
    assert!(text.contains(" 0 lost") && text.contains("share") && text.contains("walls merge"), "{text}");
    for name in ["section-xz.svg", "section-yz.svg", "section-xy.svg", "bodies.vtp"] {
        let size = std::fs::metadata(folder.path().join("pictures").join(name)).unwrap().len();
        assert!(size > 1000, "{name}");
    }
}

/// What cannot be realised is told with a way out.
#[test]
fn refusals() {
    let folder = tempfile::tempdir().unwrap();
    let write = |text: &str| std::fs::write(folder.path().join("s.xml"), text).unwrap();
    let refused = |args: &[&str], part: &str| {
        let out = lightpro(folder.path(), args);
        assert_eq!(out.status.code(), Some(2));
        assert!(told(&out).contains(part), "{}", told(&out));
    };
    write(&SHEET.replace(" ends=\"flat\"", ""));
    refused(&["realise", "s.xml"], "ends=\"flat\"");
    write(SHEET);
    refused(&["check", "s.xml", "--structure"], "kind=\"synthetic\"");
    refused(&["realise", "s.xml", "--cell", "0 mm"], "above 0");
    write(&SHEET.replace("<sheet thickness", "<cell period=\"1 1 1 mm\" top=\"1 mm\"/><sheet thickness"));
    refused(&["check", "s.xml"], "cell");
}

/// A deposited sheet written down: pieces of bent fibres whose joints part nothing. One realisation reflects
/// as its ensemble does, within the spread of realisations; no history is lost.
#[test]
fn a_deposited_sheet_is_written_too() {
    let folder = tempfile::tempdir().unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/verify/deposited-lossless.xml");
    let text =
        std::fs::read_to_string(shipped).unwrap().replace("histories=\"65536\"", "histories=\"32768\"");
    std::fs::write(folder.path().join("sheet.xml"), text).unwrap();
    let out = lightpro(folder.path(), &["realise", "sheet.xml"]);
    assert!(out.status.success(), "{}", told(&out));
    let written = scene(&folder.path().join("sheet-realised.xml"));
    let Universe::Synthetic(explicit) = &written.universe else { panic!("no bodies") };
    assert!(explicit.bodies.len() > 1000);
    let ((one, s1), (all, s2)) =
        (reflectance(&written), reflectance(&scene(&folder.path().join("sheet.xml"))));
    println!("R {one:.4}({s1:.4}) of one realisation, {all:.4}({s2:.4}) of four");
    assert!((one - all).abs() < 0.03);
}

/// Two plies under a coating, each with bodies of its own.
const BOARD: &str = r#"<scene name="board" version="1">
  <materials><material id="air" index="1"/><material id="pulp" index="1.55"/><material id="fine" index="1.5" absorption="1 1/mm"/>
    <material id="coat" index="1.4"/></materials>
  <universe kind="KIND" memory="full" outside="air" edges="contained">
    <sheet thickness="55 um" pore="air">
      <layer thickness="5 um" material="coat"/>
      <layer thickness="30 um"><fibres name="pulp" material="pulp" width="16 um" flatness=".5" wall="1.5 um" length="100 um" ends="flat" volume-fraction="0.3"/></layer>
      <layer thickness="20 um"><particles name="fine" shape="sphere" material="fine" diameter="18 um" volume-fraction="0.2"/></layer>
    </sheet>
  </universe>
  <source kind="diffuse"/>
  <run histories="32768"/>
</scene>
"#;

/// Layers of one pore medium are realised into one cell, a homogeneous one as a slab, each body in its layer; shares
/// of volume and R are those of the ensemble of such sheets. Its structure is told and drawn like any other.
#[test]
fn plies_stand_above_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("board.xml"), BOARD.replace("KIND", "statistical")).unwrap();
    std::fs::write(path("ensemble.xml"), BOARD.replace("KIND", "synthetic")).unwrap();
    let out = lightpro(folder.path(), &["realise", "board.xml", "--cell", "0.4 mm"]);
    assert!(out.status.success(), "{}", told(&out));
    let cell = scene(&path("board-realised.xml"));
    let Universe::Synthetic(explicit) = &cell.universe else { panic!("no bodies") };
    assert_eq!(explicit.cell.unwrap().planes, [0.0, 56.0]);
    let plan = Plan::new(&cell).unwrap();
    let lightpro::universe::any::AnyUniverse::Ensemble(u) = &plan.universe else { panic!() };
    let (mut pulp, mut fine) = (0, 0);
    for (body, _) in u.cells()[0].bodies() {
        let (z, media) = (body.shape.centre.z, &cell.materials);
        match media[usize::from(body.medium.0)].id.as_str() {
            "pulp" => pulp += u64::from((24.0..=46.0).contains(&z)),
            "fine" => fine += u64::from((9.0..=11.0).contains(&z)),
            _ => {}
        }
    }
    // All bodies but the slab.
    assert_eq!(pulp + fine + 1, explicit.bodies.len() as u64);
    let ensemble = scene(&path("ensemble.xml"));
    let (a, b) = (characterise(&cell, 20_000).unwrap(), characterise(&ensemble, 20_000).unwrap());
    for medium in ["air", "pulp", "fine", "coat"] {
        // The cell has a micrometre of air above the coating.
        let share = |of: &lightpro::study::characterise::Characteristics| {
            let all = (0..of.media.len()).filter(|&m| of.materials[m] == medium);
            let shares = all.map(|m| of.value(|c| c.share(m))).filter(|s| s.0 > 0.0);
            shares.fold((0.0, 0.0), |sum, s| (sum.0 + s.0, f64::hypot(sum.1, s.1)))
        };
        let (a, b) = (share(&a), share(&b));
        let (a, air) = (56.0 / 55.0 * a.0, if medium == "air" { 1.0 / 55.0 } else { 0.0 });
        println!("{medium}: {:.4} in the cell, {:.4} in the ensemble", a - air, b.0);
        assert!((a - air - b.0).abs() < 0.01 + 3.0 * b.1);
    }
    let ((rc, sc), (re, se)) = (reflectance(&cell), reflectance(&ensemble));
    println!("R {rc:.4}({sc:.4}) of the cell, {re:.4}({se:.4}) of the ensemble");
    assert!((rc - re).abs() < 0.004 + 3.0 * (sc * sc + se * se).sqrt());

    let out = lightpro(folder.path(), &["check", "ensemble.xml", "--structure", "-o", "pictures"]);
    let text = told(&out);
    assert!(out.status.success() && text.contains(" 0 lost"), "{text}");
    let coat = text.lines().find(|l| l.starts_with("coat")).unwrap();
    assert_eq!(coat.split_whitespace().count(), 3, "a plane has no fibre axis: {coat}");
    let share: f64 = coat.split_whitespace().nth(1).unwrap().split('(').next().unwrap().parse().unwrap();
    assert!((share - 5.0 / 55.0).abs() < 0.001, "{coat}");
    let section = std::fs::read_to_string(path("pictures/section-xz.svg")).unwrap();
    assert!(["coat", "pulp", "fine"].iter().all(|m| section.contains(m)), "{}", section.len());
}

/// A backing is no body, and that is told.
#[test]
fn a_backing_is_not_left_out_in_silence() {
    let folder = tempfile::tempdir().unwrap();
    let text = SHEET.replace("pore=\"air\"", "pore=\"air\" backing=\"80 %\"");
    std::fs::write(folder.path().join("s.xml"), text).unwrap();
    let out = lightpro(folder.path(), &["realise", "s.xml", "--cell", "0.1 mm"]);
    assert!(out.status.success() && told(&out).contains("reflectance 0.8) is left out"), "{}", told(&out));
}

/// What a cell cannot hold.
#[test]
fn plies_that_no_cell_holds() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |from: &str, to: &str, part: &str| {
        assert!(BOARD.contains(from));
        let text = BOARD.replace("KIND", "statistical").replacen(from, to, 1);
        std::fs::write(folder.path().join("s.xml"), text).unwrap();
        let out = lightpro(folder.path(), &["realise", "s.xml"]);
        assert_eq!(out.status.code(), Some(2), "{}", told(&out));
        assert!(told(&out).contains(part) && told(&out).contains("kind=\"synthetic\""), "{}", told(&out));
    };
    refused("edges=\"contained\"", "edges=\"cut\"", "are not cut at inner planes");
    refused("pore=\"air\"", "pore=\"coat\"", "the medium outside");
    let rough = r#"<layer thickness="5 um" surface="r" material="coat"/>"#;
    let with = BOARD.replace(
        "</materials>",
        r#"</materials><surfaces><surface id="r" kind="rough" m="0.2"/></surfaces>"#,
    );
    let text =
        with.replace("KIND", "statistical").replace(r#"<layer thickness="5 um" material="coat"/>"#, rough);
    std::fs::write(folder.path().join("r.xml"), text).unwrap();
    let out = lightpro(folder.path(), &["realise", "r.xml"]);
    assert!(told(&out).contains("no `surface` of their own"), "{}", told(&out));
}
