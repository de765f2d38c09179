//! A run that survives: what was killed, stopped, cut in shards or met a fault ends in the same bytes, or
//! in a message, and never in half a file.
#![allow(missing_docs)]

mod faults;
mod resume;
mod target;
mod replay;

use assert_cmd::cargo::cargo_bin;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

/// Two layers at two wavelengths that share no path (analog absorption), seen by angle and depth: several
/// wavelength groups, several kinds of cells.
const SCENE: &str = r#"<scene name="two groups" version="1">
  <materials>
    <material id="air" index="1"/>
    <material id="coat" index="1.6" absorption="0.0001 1/um"><scattering mu-s="0.09 1/um" g="0.6"/></material>
    <material id="base" index="1.47" absorption="0.002 1/um"><scattering mu-s="0.05 1/um" g="0.7"/></material>
  </materials>
  <universe kind="synthetic" outside="air">
    <sheet thickness="60 um">
      <layer thickness="20 um" material="coat"/>
      <layer thickness="40 um" material="base"/>
    </sheet>
  </universe>
  <source kind="diffuse"/>
  <spectrum at="450 650 nm"/>
  <detect angular="nside 2" depth="6" path="yes"/>
  <optics geometry="total" pile="1"/>
  <run histories="150000" seed="5" absorption="analog"/>
</scene>
"#;

pub fn lightpro(folder: &Path) -> Command {
    let mut c = Command::new(cargo_bin("lightpro"));
    c.current_dir(folder);
    c
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

pub fn well(o: &Output) {
    assert!(o.status.success(), "{}\n{}", text(&o.stdout), text(&o.stderr));
}

/// All files of a results folder but those that tell times.
pub fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut out = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if name != "manifest.json" && name != "checkpoint" {
            out.insert(name, std::fs::read(&path).unwrap());
        }
    }
    out
}

/// A folder with the scene in it.
pub fn place() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("scene.xml"), SCENE).unwrap();
    dir
}
