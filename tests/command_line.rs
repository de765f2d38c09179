//! The program as a person calls it: commands, exit codes, files, messages.
#![allow(missing_docs)]

use assert_cmd::Command;
use std::path::Path;

fn lightpro(folder: &Path) -> Command {
    let mut c = Command::cargo_bin("lightpro").unwrap();
    c.current_dir(folder);
    c
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn run_writes_a_folder_and_never_overwrites_it() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("r");
    let run = |force: bool| {
        let mut c = lightpro(root());
        c.args(["run", "scenes/handsheet.xml", "--histories", "5000", "-o"]).arg(&out);
        if force {
            c.arg("--force");
        }
        c.output().unwrap()
    };
    let first = run(false);
    assert!(first.status.success(), "{}", text(&first.stderr));
    let said = text(&first.stdout);
    for word in ["effects", "brightness_r457", "opacity", "m2/kg", "results in"] {
        assert!(said.contains(word), "{word} in\n{said}");
    }
    for file in ["result.json", "manifest.json", "figures.csv", "spectra.csv", "ledger.csv", "angular.csv"] {
        assert!(out.join(file).is_file(), "{file}");
    }
    for plot in ["spectra_plot.svg", "ledger_plot.svg", "angular_polar.svg", "absorbed_by_depth_plot.svg"] {
        let svg = std::fs::read_to_string(out.join(plot)).unwrap();
        assert!(svg.starts_with("<svg") || svg.contains("<svg"), "{plot}");
    }
    let before = std::fs::read(out.join("result.json")).unwrap();
    let second = run(false);
    assert_eq!(second.status.code(), Some(2));
    assert!(text(&second.stderr).contains("--force"), "{}", text(&second.stderr));
    assert!(run(true).status.success());
    assert_eq!(before, std::fs::read(out.join("result.json")).unwrap(), "same seed, same bytes");
}

#[test]
fn json_goes_to_standard_output_alone() {
    let dir = tempfile::tempdir().unwrap();
    let done = lightpro(root())
        .args(["run", "scenes/verify/glass-plate.xml", "--histories", "1e5", "--json", "-o"])
        .arg(dir.path().join("r"))
        .output()
        .unwrap();
    let value: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(value["histories"], 100_000);
    assert_eq!(value["figures"][0]["name"], "reflectance");
}

#[test]
fn a_failed_expectation_exits_with_1() {
    let dir = tempfile::tempdir().unwrap();
    let done = lightpro(root())
        .args(["run", "scenes/seed/fig12-reflectance.xml", "-D", "ratio=paper-amplitude"])
        .args(["--histories", "20000", "-o"])
        .arg(dir.path().join("r"))
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(1));
    assert!(text(&done.stderr).contains("FAILS"), "{}", text(&done.stderr));
}

#[test]
fn bad_input_exits_with_2_and_shows_the_place() {
    let dir = tempfile::tempdir().unwrap();
    let scene = dir.path().join("bad.xml");
    std::fs::write(
        &scene,
        r#"<scene name="x" version="1">
  <materials><material id="air" index="1"/></materials>
  <universe kind="synthetic" outside="air">
    <sphere centre="0 0 0 um" radius="3" material="copper"/>
  </universe>
</scene>
"#,
    )
    .unwrap();
    for command in ["run", "plan", "check"] {
        let done = lightpro(dir.path()).args([command, "bad.xml"]).output().unwrap();
        assert_eq!(done.status.code(), Some(2), "{command}");
        let said = text(&done.stderr);
        assert!(
            said.contains("bad.xml:4:") && said.contains("radius=\"3\"") && said.contains("copper"),
            "{said}"
        );
        assert!(said.contains('^'), "{said}");
    }
    assert!(!dir.path().join("results").exists(), "nothing is left behind");
    let missing = lightpro(dir.path()).args(["run", "none.xml"]).output().unwrap();
    assert_eq!(missing.status.code(), Some(2));
}

#[test]
fn plan_and_materials_answer() {
    let plan = lightpro(root()).args(["plan", "scenes/copy-paper.xml"]).output().unwrap();
    let said = text(&plan.stdout);
    assert!(
        said.contains("Mie scattering") && said.contains("realised") && said.contains("porosity"),
        "{said}"
    );
    let list = lightpro(root()).args(["materials", "cu_"]).output().unwrap();
    assert!(text(&list.stdout).contains("Cu_Hagemann.yml"), "{}", text(&list.stdout));
    assert!(lightpro(root()).arg("schema").output().unwrap().status.success());
}

#[test]
fn an_unwritable_folder_is_told_before_the_run() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("file");
    std::fs::write(&file, "x").unwrap();
    let done = lightpro(root())
        .args(["run", "scenes/handsheet.xml", "--histories", "1e9", "-o"])
        .arg(file.join("below"))
        .timeout(std::time::Duration::from_secs(20))
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(2), "{}", text(&done.stderr));
}

#[test]
fn completions_manual_and_schemas_are_printed() {
    let dir = tempfile::tempdir().unwrap();
    let ask = |args: &[&str]| {
        let done = lightpro(dir.path()).args(args).output().unwrap();
        assert!(done.status.success(), "{args:?}: {}", text(&done.stderr));
        text(&done.stdout)
    };
    for shell in ["bash", "zsh", "fish"] {
        assert!(ask(&["completions", shell]).contains("histories"), "{shell}");
    }
    ask(&["manual"]);
    let page = std::fs::read_to_string(dir.path().join("lightpro-run.1")).unwrap();
    assert!(page.contains("sweep") && page.starts_with(".ie"), "{}", &page[..60]);
    assert!(ask(&["schema"]).contains("<xs:schema"));
    assert!(ask(&["schema", "--result"]).contains("\"histories\""));
}

#[test]
fn a_sweep_that_cannot_be_says_so() {
    let dir = tempfile::tempdir().unwrap();
    for (sweep, want) in
        [("wall.index=1.5:1.6", "expected NAME=FROM:TO:STEP"), ("walls.index=1.5,1.6", "walls")]
    {
        let done = lightpro(root())
            .args(["run", "scenes/tutorial/sheet.xml", "--sweep", sweep, "-o"])
            .arg(dir.path().join("r"))
            .output()
            .unwrap();
        assert_eq!(done.status.code(), Some(2), "{}", text(&done.stderr));
        assert!(text(&done.stderr).contains(want), "{}", text(&done.stderr));
    }
}
