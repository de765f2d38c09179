//! Do nominal 95 % intervals cover 95 %? Runs that stop at a target, repeated with other seeds.
#![allow(missing_docs)]
#![allow(clippy::disallowed_methods)]

use lightpro::report::Figure;
use lightpro::scene::{Options, Scene, read_text};
use lightpro::study::aims;
use lightpro::study::target::Target;

/// A thin slab that scatters and absorbs, some 2 events a history.
const SCENE: &str = r#"<scene name="thin slab" version="1">
  <materials>
    <material id="air" index="1"/>
    <material id="slab" index="1" absorption="0.004 1/um"><scattering mu-s="0.01 1/um" g="0.3"/></material>
  </materials>
  <universe kind="synthetic" outside="air">
    <sheet thickness="60 um"><layer thickness="60 um" material="slab"/></sheet>
  </universe>
  <source kind="diffuse"/>
  <spectrum at="550 nm"/>
  <run histories="4e6" seed="1"/>
</scene>
"#;

fn scene(seed: u64) -> Scene {
    let mut scene = read_text(SCENE, "coverage.xml".as_ref(), &Options::default()).unwrap();
    scene.run.seed = seed;
    scene
}

/// Of so many repetitions the share whose 95 % interval covers the mean over all of them, and the mean
/// number of batches.
fn coverage(figure: &str, percent: f64, repetitions: u64) -> (f64, f64) {
    let target = [Target::parse(&format!("{figure}:{percent}%")).unwrap()];
    let runs: Vec<(u64, Figure)> = (0..repetitions)
        .map(|seed| {
            let (outcome, result, seen) = aims::run(&scene(1000 + seed), &target).unwrap();
            assert!(seen.iter().all(|s| s.met), "{seen:?}");
            (outcome.done(), result.figure(figure, None).unwrap().clone())
        })
        .collect();
    // Sums over a stopped sample are unbiased (Wald): means weighted by their histories.
    let total: u64 = runs.iter().map(|r| r.0).sum();
    let truth = runs.iter().map(|(n, f)| *n as f64 * f.value.unwrap()).sum::<f64>() / total as f64;
    let covers = |f: &Figure| f.interval95().is_some_and(|(low, high)| low <= truth && truth <= high);
    let share = runs.iter().filter(|r| covers(&r.1)).count() as f64 / repetitions as f64;
    (share, total as f64 / (4096 * repetitions) as f64)
}

/// Counted history by history, and from replicas; stopped at the floor, a little above it, and far above.
/// 2,000 repetitions know a share of .95 to ± .005.
#[test]
#[ignore = "1e9 histories: cargo test --test coverage -- --ignored"]
fn intervals_of_runs_with_targets_cover_what_they_say() {
    for (figure, percent) in
        [("reflectance", 1.4), ("absorptance", 0.5), ("absorptance", 0.33), ("absorptance", 0.15)]
    {
        let (share, batches) = coverage(figure, percent, 2000);
        println!("{figure} to {percent} %: {share:.4} covered, {batches:.1} batches");
        assert!((0.93..=0.97).contains(&share), "{figure} to {percent} %: {share}, {batches} batches");
    }
}

/// The same in short: 120 repetitions know the share to ± .02 and see errors that are wrong by half.
#[test]
fn intervals_cover_roughly() {
    let (share, batches) = coverage("reflectance", 1.4, 120);
    assert!((0.87..=1.0).contains(&share), "{share}");
    assert!((10.0..=40.0).contains(&batches), "{batches}");
}
