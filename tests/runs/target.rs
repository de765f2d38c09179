//! `run --target`: where a run ends depends on scene, seed and targets alone.

use crate::{files, lightpro, place, text, well};
use lightpro::report::RunResult;
use lightpro::report::csv::parse;
use lightpro::study::target::Seen;
use std::path::Path;

/// Reached after some twenty batches.
const TARGETS: [&str; 4] = ["--target", "reflectance@450:0.35%", "--target", "absorptance:0.75%"];

fn run(dir: &Path, out: &str, more: &[&str]) {
    well(
        &lightpro(dir)
            .args(["run", "scene.xml", "--quiet", "-o", out])
            .args(TARGETS)
            .args(more)
            .output()
            .unwrap(),
    );
}

fn result(folder: &Path) -> RunResult {
    RunResult::from_json(&std::fs::read_to_string(folder.join("result.json")).unwrap()).unwrap()
}

#[test]
fn threads_and_interruptions_change_no_byte() {
    let dir = place();
    run(dir.path(), "one", &["--threads", "1"]);
    run(dir.path(), "three", &["--threads", "3"]);
    let one = files(&dir.path().join("one"));
    assert_eq!(one, files(&dir.path().join("three")), "threads");
    // Stopped by the clock again and again.
    run(dir.path(), "cut", &["--max-time", "60ms", "--checkpoint-every", "0s"]);
    let mut stops = 0;
    while !result_is_complete(&dir.path().join("cut")) {
        stops += 1;
        assert!(stops < 1000);
        let time = ["--max-time", "60ms", "--quiet"];
        well(&lightpro(dir.path()).args(["resume", "cut"]).args(time).output().unwrap());
    }
    assert_eq!(one, files(&dir.path().join("cut")), "{stops} interruptions");
    // Taken up after its end it stays.
    well(&lightpro(dir.path()).args(["resume", "cut", "--quiet"]).output().unwrap());
    assert_eq!(one, files(&dir.path().join("cut")));
}

fn result_is_complete(folder: &Path) -> bool {
    folder.join("result.json").is_file() && result(folder).complete
}

#[test]
fn the_bytes_are_those_of_so_many_histories_and_the_targets_hold() {
    let dir = place();
    run(dir.path(), "aimed", &[]);
    let n = result(&dir.path().join("aimed")).histories;
    assert!(n >= 16 * 4096 && n.is_multiple_of(4096), "{n}");
    let histories = n.to_string();
    let plain = ["run", "scene.xml", "--quiet", "-o", "plain", "--histories", &histories];
    well(&lightpro(dir.path()).args(plain).output().unwrap());
    let mut aimed = files(&dir.path().join("aimed"));
    let rows: Vec<Seen> = parse(&text(&aimed.remove("targets.csv").unwrap())).unwrap();
    assert_eq!(aimed, files(&dir.path().join("plain")));
    // One wavelength of reflectance, both of absorptance.
    assert_eq!(rows.len(), 3);
    for r in &rows {
        assert!(r.met && r.error.unwrap() <= r.wanted.unwrap(), "{r:?}");
        assert!(r.low95.unwrap() < r.value.unwrap() && r.value.unwrap() < r.high95.unwrap());
        // By Student's t: replicas know their spread less well than 65536 histories theirs.
        let width = (r.high95.unwrap() - r.value.unwrap()) / r.error.unwrap();
        let absorptance = r.figure.starts_with("absorptance");
        assert!(if absorptance { width > 2.0 } else { (width - 1.96).abs() < 1e-3 }, "{width}");
    }
}

#[test]
fn what_cannot_be_met_is_told() {
    let dir = place();
    let go = |more: &[&str]| {
        lightpro(dir.path()).args(["run", "scene.xml", "--force"]).args(more).output().unwrap()
    };
    let missed = go(&["--target", "reflectance:1e-7", "--histories", "50000"]);
    well(&missed);
    let said = text(&missed.stdout);
    assert!(said.contains("NOT met; about "), "{said}");
    for (target, why) in [
        ("reflectivity:1%", "no figure `reflectivity`"),
        ("reflectance@500:1%", "not had at 500 nm"),
        ("brightness:0.1", "not available: needs"),
    ] {
        let refused = go(&["--target", target]);
        assert_eq!(refused.status.code(), Some(2));
        assert!(text(&refused.stderr).contains(why), "{}", text(&refused.stderr));
    }
    let shard = go(&["--target", "reflectance:1%", "--histories-range", "0..4096"]);
    assert_eq!(shard.status.code(), Some(2));
}
