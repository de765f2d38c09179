//! Killed, stopped, cut in shards: the same bytes.

use crate::{files, lightpro, place, text, well};
use lightpro::report::RunResult;
use lightpro::rng::{Purpose, Stream};
use rustix::process::{Pid, Signal, kill_process};
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

fn run(dir: &Path, out: &str, more: &[&str]) -> std::process::Output {
    lightpro(dir).args(["run", "scene.xml", "--quiet", "-o", out]).args(more).output().unwrap()
}

fn start(dir: &Path, arguments: &[&str]) -> Child {
    lightpro(dir).args(arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

fn signal(child: &Child, signal: Signal) {
    // The process may have ended by itself.
    let _ = kill_process(Pid::from_child(child), signal);
}

/// Kills runs at random moments, checkpoints being written after every round, and resumes them (killing
/// some of the resumed ones too): (kills that hit a run under way, files found half written).
fn killed(times: u64) -> (u64, u64) {
    let dir = place();
    let whole = Instant::now();
    well(&run(dir.path(), "whole", &["--checkpoint-every", "0s"]));
    let span = whole.elapsed().as_secs_f64();
    let expected = files(&dir.path().join("whole"));
    let mut rng = Stream::of(9, 0, times, Purpose::Probe);
    let (mut hit, mut half) = (0, 0);
    for k in 0..times {
        let out = format!("k{k}");
        let mut arguments = vec!["run", "scene.xml", "--quiet", "--checkpoint-every", "0s", "-o", &out];
        for _ in 0..2 {
            let mut child = start(dir.path(), &arguments);
            std::thread::sleep(Duration::from_secs_f64(rng.uniform() * span * 0.9));
            signal(&child, Signal::KILL);
            let ended = child.wait().unwrap();
            let folder = dir.path().join(&out);
            hit += u64::from(!ended.success());
            let names =
                |d: &Path| std::fs::read_dir(d).into_iter().flatten().flatten().map(|e| e.file_name());
            half += names(&folder).filter(|n| n.to_string_lossy().ends_with(".part")).count() as u64;
            // Before its first checkpoint there is no run yet, and `resume` says so.
            let begun = folder.join("checkpoint").is_file();
            arguments = if begun {
                vec!["resume", &out, "--quiet", "--checkpoint-every", "0s"]
            } else {
                let refused = lightpro(dir.path()).args(["resume", &out]).output().unwrap();
                assert_eq!(refused.status.code(), Some(2));
                assert!(text(&refused.stderr).contains("checkpoint"), "{}", text(&refused.stderr));
                vec!["run", "scene.xml", "--quiet", "--force", "--checkpoint-every", "0s", "-o", &out]
            };
        }
        well(&lightpro(dir.path()).args(&arguments).output().unwrap());
        let folder = dir.path().join(&out);
        if arguments[0] == "run" {
            well(&lightpro(dir.path()).args(["resume", &out, "--quiet"]).output().unwrap());
        }
        assert_eq!(files(&folder), expected, "kill {k}");
        std::fs::remove_dir_all(folder).unwrap();
    }
    (hit, half)
}

/// Fault of the design's table: kill −9, power loss.
#[test]
fn a_killed_run_resumes_to_the_same_bytes() {
    let (hit, _) = killed(4);
    assert!(hit > 0, "no run was hit");
}

/// The long one: `cargo test --test runs -- --ignored --nocapture killed_at_100`.
#[test]
#[ignore = "long: cargo test --test runs killed_at_100 -- --ignored --nocapture"]
fn killed_at_100_random_moments() {
    let (hit, half) = killed(100);
    println!("{hit} of 200 kills hit a run under way, {half} found a file half written");
    assert!(hit >= 100 && half > 0, "{hit} {half}");
}

/// Stops runs by SIGTERM or Ctrl-C at random moments; partial results are those of a run of the same
/// number of histories, and `resume` ends as if nothing had been: number of partial results compared.
fn stopped(times: u64) -> u64 {
    let dir = place();
    let whole = Instant::now();
    well(&run(dir.path(), "whole", &[]));
    let span = whole.elapsed().as_secs_f64();
    let expected = files(&dir.path().join("whole"));
    let mut rng = Stream::of(10, 0, times, Purpose::Probe);
    let mut compared = 0;
    for k in 0..times {
        let out = format!("s{k}");
        let folder = dir.path().join(&out);
        let (kind, code) = if k % 2 == 0 { (Signal::TERM, 143) } else { (Signal::INT, 130) };
        let mut child = start(dir.path(), &["run", "scene.xml", "--quiet", "-o", &out]);
        while !folder.join("checkpoint").is_file() {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_secs_f64(rng.uniform() * span * 0.8));
        signal(&child, kind);
        let ended = child.wait().unwrap();
        if ended.success() {
            continue;
        }
        assert_eq!(ended.code(), Some(code));
        if let Ok(json) = std::fs::read_to_string(folder.join("result.json")) {
            let mut partial = RunResult::from_json(&json).unwrap();
            assert!(!partial.complete && partial.histories < 150_000);
            let n = partial.histories.to_string();
            well(&run(dir.path(), "prefix", &["--histories", &n, "--force"]));
            partial.complete = true;
            let mut got = files(&folder);
            got.insert("result.json".into(), partial.to_json().into_bytes());
            let mut want = files(&dir.path().join("prefix"));
            // The report tells how many histories were asked for.
            for files in [&mut got, &mut want] {
                files.remove("report.html");
            }
            assert_eq!(got, want, "stopped after {n}");
            compared += 1;
        }
        well(&lightpro(dir.path()).args(["resume", &out, "--quiet"]).output().unwrap());
        assert_eq!(files(&folder), expected, "stop {k}");
    }
    compared
}

/// Fault of the design's table: Ctrl-C, SIGTERM.
#[test]
fn a_stopped_run_is_a_prefix_and_resumes() {
    assert!(stopped(6) > 0, "no run was stopped in time");
}

/// The long one: `cargo test --test runs -- --ignored --nocapture stopped_at_100`.
#[test]
#[ignore = "long: cargo test --test runs stopped_at_100 -- --ignored --nocapture"]
fn stopped_at_100_random_moments() {
    let compared = stopped(100);
    println!("{compared} partial results compared");
    assert!(compared >= 50, "{compared}");
}

/// Fault of the design's table: a second signal stops at once.
#[test]
fn a_second_signal_stops_at_once() {
    let dir = place();
    // Without absorption, behind mirrors of itself: a batch takes minutes.
    let scene = std::fs::read_to_string(dir.path().join("scene.xml")).unwrap();
    let slow = scene.replace("absorption=\"0.0001 1/um\"", "").replace("absorption=\"0.002 1/um\"", "");
    let slow = slow.replace("0.05 1/um", "5e3 1/um").replace("absorption=\"analog\"", "");
    std::fs::write(dir.path().join("scene.xml"), slow).unwrap();
    let mut child = start(dir.path(), &["run", "scene.xml", "--quiet", "-o", "r"]);
    while !dir.path().join("r/checkpoint").is_file() {
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(200));
    signal(&child, Signal::TERM);
    std::thread::sleep(Duration::from_millis(500));
    assert!(child.try_wait().unwrap().is_none(), "the batch is finished first");
    signal(&child, Signal::TERM);
    assert_eq!(child.wait().unwrap().code(), Some(143));
    let names: Vec<_> =
        std::fs::read_dir(dir.path().join("r")).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names, ["checkpoint"], "no partial file");
}

#[test]
fn time_ends_a_run_with_what_is_done() {
    let dir = place();
    let done = run(dir.path(), "r", &["--max-time", "150ms"]);
    well(&done);
    let folder = dir.path().join("r");
    well(&lightpro(dir.path()).args(["resume", "r", "--quiet"]).output().unwrap());
    well(&run(dir.path(), "whole", &["--threads", "1"]));
    assert_eq!(files(&folder), files(&dir.path().join("whole")));
}

#[test]
fn shards_merge_to_the_same_bytes() {
    let dir = place();
    well(&run(dir.path(), "whole", &[]));
    for (name, range) in [("a", "0..12288"), ("b", "12288..81920"), ("c", "81920..150000")] {
        well(&run(dir.path(), name, &["--histories-range", range]));
    }
    let merge = |shards: &[&str], out: &str| {
        lightpro(dir.path()).arg("merge").args(shards).args(["--quiet", "-o", out]).output().unwrap()
    };
    well(&merge(&["c", "a", "b"], "merged"));
    assert_eq!(files(&dir.path().join("merged")), files(&dir.path().join("whole")));
    let refused = |shards: &[&str], why: &str| {
        let done = merge(shards, "never");
        assert_eq!(done.status.code(), Some(2));
        assert!(text(&done.stderr).contains(why), "{}", text(&done.stderr));
        assert!(!dir.path().join("never").exists());
    };
    refused(&["a", "c"], "12288..81920 are missing");
    refused(&["a", "b"], "81920..150000 are missing");
    refused(&["a", "b", "b", "c"], "are there twice");
    well(&run(dir.path(), "other", &["--histories-range", "12288..81920", "--seed", "6"]));
    refused(&["a", "other", "c"], "of seed 6");
    for range in ["100..4096", "0..5000", "4096..4096", "0..200704"] {
        let done = run(dir.path(), "never", &["--histories-range", range]);
        assert_eq!(done.status.code(), Some(2), "{range}");
        assert!(text(&done.stderr).contains("no shard of 150000"), "{}", text(&done.stderr));
    }
}
