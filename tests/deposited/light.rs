//! Light in deposited sheets, from the scene file on.

use lightpro::command::{RunArgs, SceneArgs, check, finish, load};
use std::path::{Path, PathBuf};

fn scene(realise: &str, fibres: &str, absorption: &str) -> String {
    format!(
        r#"<scene name="t" version="1">
  <materials><material id="air" index="1"/><material id="wall" index="1.5" absorption="{absorption}"/></materials>
  <universe kind="synthetic">
    <sheet thickness="32 um" pore="air"><layer>
      <fibres material="wall" width="20 um" flatness=".35" wall="2 um" grammage="20 g/m2" {fibres}/>
    </layer></sheet>
    <realise model="deposited" {realise}/>
  </universe>
  <source kind="diffuse"/><spectrum at="550 nm"/><detect path="yes"/><run histories="32768"/>
</scene>"#
    )
}

const SMALL: &str = r#"cell=".3 mm" realisations="4""#;
const SHORT: &str = r#"length=".25 mm""#;

fn written(folder: &Path, text: &str) -> SceneArgs {
    let path: PathBuf = folder.join("t.xml");
    std::fs::write(&path, text).unwrap();
    SceneArgs { path, ..SceneArgs::default() }
}

/// The scene's result, its figures by name, and the plan in words.
fn run(text: &str, threads: usize, histories: u64) -> (String, Vec<(String, f64, f64)>, String) {
    let folder = tempfile::tempdir().unwrap();
    let args = written(folder.path(), text);
    let (scene, plan) = load(&args).unwrap();
    let run = RunArgs { histories: Some(histories), threads, ..RunArgs::default() };
    let done = finish(scene, &run, |_| true).unwrap();
    assert_eq!(done.outcome.troubled(), (0, 0), "lost, capped");
    assert!(done.outcome.worst_imbalance() < 1e-12);
    let figures = (done.result.figures.iter())
        .map(|f| (f.name.clone(), f.value.unwrap_or(f64::NAN), f.error.unwrap_or(f64::NAN)))
        .collect();
    (done.result.to_json(), figures, plan.to_string())
}

fn of(figures: &[(String, f64, f64)], name: &str) -> (f64, f64) {
    let f = figures.iter().find(|f| f.0 == name).unwrap_or_else(|| panic!("{name}"));
    (f.1, f.2)
}

/// Nothing is absorbed, nothing lost; grammage and thickness stand in the plan within 1 %.
#[test]
fn what_is_not_reflected_is_transmitted() {
    let (_, figures, plan) = run(&scene(SMALL, SHORT, "0 1/um"), 0, 32_768);
    let ((r, se), (t, _)) = (of(&figures, "reflectance"), of(&figures, "transmittance"));
    println!("R {r:.5} ± {se:.5}, T {t:.5}\n{plan}");
    assert!((r + t - 1.0).abs() < 1e-12 && r > 0.2 && r < 0.8);
    let number = |after: &str| -> f64 {
        let rest = &plan[plan.find(after).unwrap() + after.len()..];
        rest.split_whitespace().next().unwrap().parse().unwrap()
    };
    assert!((number("mean thickness ") / 32.0 - 1.0).abs() < 0.01);
    assert!((number("batch, and intervals count realisations\nnote: deposited: ") / 20.0 - 1.0).abs() < 0.01);
}

#[test]
fn threads_change_no_byte() {
    let text = scene(SMALL, SHORT, "0.001 1/um");
    assert_eq!(run(&text, 1, 16_384).0, run(&text, 2, 16_384).0);
}

/// The interval counts realisations: it is that of their means, and the spread between them is told.
#[test]
fn the_interval_counts_realisations() {
    // Small cells differ much.
    let realise = r#"cell=".12 mm" realisations="8" places="1" pressing="1""#;
    let text = scene(realise, r#"length=".1 mm""#, "0 1/um");
    let (_, few, _) = run(&text, 0, 32_768);
    let (_, many, _) = run(&text, 0, 262_144);
    let ((_, se), (sd, error)) = (of(&many, "reflectance"), of(&many, "reflectance_between_realisations"));
    println!(
        "few {:?}, many {:?}, between {sd:.5} ± {error:.5}",
        of(&few, "reflectance"),
        of(&many, "reflectance")
    );
    // More histories of the same eight realisations do not make the mean over sheets known: the variance of the
    // mean is that between realisations over eight, and what is left of the histories'.
    let left = 0.25 / 262_144.0;
    let want = (sd * sd / 8.0 + left).sqrt();
    assert!(sd > 0.0 && (se / want - 1.0).abs() < 0.2, "{se} {want}");
    let plain = (0.25_f64 / 262_144.0).sqrt();
    assert!(se > 1.5 * plain, "{se} beside {plain} of as many independent histories");
}

/// What cannot be is refused at its place, with a way out.
#[test]
fn refusals() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |text: &str| {
        let args = written(folder.path(), text);
        check(&args).err().map_or_else(|| load(&args).map(|_| ()).unwrap_err().to_string(), |e| e.to_string())
    };
    let endless = refused(&scene(SMALL, "", "0 1/um"));
    assert!(endless.contains("cannot fall on a sheet") && endless.contains("length"), "{endless}");
    let cut = refused(
        &scene(SMALL, SHORT, "0 1/um").replace(r#"kind="synthetic""#, r#"kind="synthetic" edges="cut""#),
    );
    assert!(cut.contains("not cut"), "{cut}");
    let thin = refused(&scene(SMALL, SHORT, "0 1/um").replace("32 um", "18 um"));
    assert!(thin.contains("no pressing makes the sheet"), "{thin}");
    let shared = refused(
        &scene(SMALL, SHORT, "0 1/um")
            .replace(r#"histories="32768""#, r#"histories="32768" histories-per-realisation="64""#),
    );
    assert!(shared.contains("batch by batch"), "{shared}");
}
