//! Faults of the machine: a message, an exit code, and the old files whole.

use crate::{files, lightpro, place, text, well};
use lightpro::run::checkpoint::from_bytes;
use std::fs::File;
use std::path::Path;
use std::process::{Command, Output, Stdio};

const RUN: [&str; 5] = ["run", "scene.xml", "-o", "r", "--force"];

/// A folder with a finished run `r`, and its files, the checkpoint included.
fn finished() -> (tempfile::TempDir, Vec<u8>) {
    let dir = place();
    well(&lightpro(dir.path()).args(RUN).output().unwrap());
    let checkpoint = std::fs::read(dir.path().join("r/checkpoint")).unwrap();
    (dir, checkpoint)
}

fn refused(done: &Output, word: &str) {
    let said = text(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{said}");
    assert!(said.contains(word) && !said.contains("panicked"), "{word} in\n{said}");
}

fn intact(dir: &Path, before: &(std::collections::BTreeMap<String, Vec<u8>>, Vec<u8>)) {
    assert_eq!(files(&dir.join("r")), before.0);
    assert_eq!(std::fs::read(dir.join("r/checkpoint")).unwrap(), before.1);
}

/// Fault of the design's table: closed pipe.
#[test]
fn a_closed_pipe_is_told_and_nothing_is_touched() {
    let (dir, checkpoint) = finished();
    let before = (files(&dir.path().join("r")), checkpoint);
    let mut child = lightpro(dir.path())
        .args(RUN)
        .args(["--seed", "6"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    refused(&child.wait_with_output().unwrap(), "standard output");
    intact(dir.path(), &before);
    for command in ["plan", "check", "schema"] {
        let mut c = lightpro(dir.path());
        c.arg(command).args((command != "schema").then_some("scene.xml"));
        let full = File::options().write(true).open("/dev/full").unwrap();
        refused(&c.stdout(full).output().unwrap(), "standard output");
    }
}

/// Fault of the design's table: disk full. The limit on the size of a file stands for it: a write fails
/// half way.
#[test]
fn a_full_disk_is_told_and_leaves_the_old_files() {
    let (dir, checkpoint) = finished();
    let before = (files(&dir.path().join("r")), checkpoint);
    let program = assert_cmd::cargo::cargo_bin("lightpro");
    let limited = |blocks: u32, command: &str| -> Output {
        let line = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" {command}");
        Command::new("sh").current_dir(dir.path()).args(["-c", &line]).arg(&program).output().unwrap()
    };
    // The first checkpoint does not fit: nothing is touched.
    refused(&limited(0, "run scene.xml --quiet -o r --force --seed 6"), "writing to r");
    intact(dir.path(), &before);
    // A later checkpoint does not fit: the run stops, the checkpoint before it stays, and goes on later.
    let small = limited(4, "run scene.xml --quiet -o s --checkpoint-every 0s");
    refused(&small, "what was there before is whole");
    let stored = from_bytes(&std::fs::read(dir.path().join("s/checkpoint")).unwrap()).unwrap();
    assert!(stored.state[0].next() < 37);
    let names: Vec<_> =
        std::fs::read_dir(dir.path().join("s")).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names, ["checkpoint"], "no partial file");
    well(&lightpro(dir.path()).args(["resume", "s", "--quiet"]).output().unwrap());
    assert_eq!(files(&dir.path().join("s")), before.0);
}

/// Fault of the design's table: memory.
#[test]
fn too_little_memory_is_refused_before_the_run() {
    let (dir, checkpoint) = finished();
    let before = (files(&dir.path().join("r")), checkpoint);
    let done = lightpro(dir.path()).args(RUN).args(["--max-memory", "1MB", "--seed", "6"]).output().unwrap();
    refused(&done, "--max-memory");
    intact(dir.path(), &before);
    let said = text(&lightpro(dir.path()).args(RUN).output().unwrap().stdout);
    assert!(said.contains("MB of memory and up to"), "{said}");
}

#[test]
fn a_used_folder_names_resume_and_a_changed_scene_is_refused() {
    let (dir, _) = finished();
    let done = lightpro(dir.path()).args(["run", "scene.xml", "-o", "r"]).output().unwrap();
    refused(&done, "lightpro resume");
    let scene = std::fs::read_to_string(dir.path().join("scene.xml")).unwrap();
    std::fs::write(dir.path().join("scene.xml"), scene.replace("1.47", "1.48")).unwrap();
    refused(&lightpro(dir.path()).args(["resume", "r"]).output().unwrap(), "scene.xml has changed");
    refused(&lightpro(dir.path()).args(["merge", "r", "-o", "m"]).output().unwrap(), "scene.xml has changed");
    std::fs::remove_file(dir.path().join("scene.xml")).unwrap();
    refused(&lightpro(dir.path()).args(["resume", "r"]).output().unwrap(), "scene.xml");
}

/// Every byte of a checkpoint matters: a changed, missing or added one is found, never believed.
#[test]
fn a_damaged_checkpoint_is_refused() {
    let (dir, good) = finished();
    from_bytes(&good).unwrap();
    let step = (good.len() / 2000).max(1);
    for at in (0..40).chain((40..good.len()).step_by(step)) {
        for bit in [1, 0x80] {
            let mut bad = good.clone();
            bad[at] ^= bit;
            assert!(from_bytes(&bad).is_err(), "byte {at}");
        }
        assert!(from_bytes(&good[..at]).is_err(), "cut at {at}");
    }
    let mut long = good.clone();
    long.push(0);
    assert!(from_bytes(&long).is_err());
    std::fs::write(dir.path().join("r/checkpoint"), &good[..good.len() / 2]).unwrap();
    refused(&lightpro(dir.path()).args(["resume", "r"]).output().unwrap(), "bytes where");
}

/// Sums with counters near the end of their range, behind a checksum that is right (found by fuzzing: an
/// addition overflowed).
#[test]
fn impossible_counters_are_refused() {
    let told = lightpro::run::checkpoint::decode(include_bytes!("counter-overflow.bin")).unwrap_err();
    assert_eq!(told, "damaged: a counter is impossible");
}
