//! Pictures of `docs/statistical-universe.md`: the memory ladder and the hot spot, made by the program from
//! small runs. `LIGHTPRO_WRITE=1 cargo test --release --test ladder_figures` renews them.
#![allow(missing_docs)]
#![allow(clippy::disallowed_methods)]

use lightpro::command::{RunArgs, finish};
use lightpro::report::RunResult;
use lightpro::report::plot::{Curve, LinePlot};
use lightpro::sap::Healpix;
use lightpro::scene::{Options, read_text};
use std::path::Path;

/// A sheet of white fibres of radius 1 µm, 10 µm thick, at a body share.
fn scene(share: f64, memory: &str, rest: &str) -> String {
    format!(
        r#"<scene name="ladder" version="1">
  <materials><material id="air" index="1"/><material id="wall" index="1.5"/></materials>
  <surfaces><surface id="white" kind="lambertian" reflectance="1" opaque="yes"/></surfaces>
  <universe kind="statistical" outside="air" memory="{memory}" edges="cut" start="pore">
    <sheet thickness="10 um" pore="air"><layer>
      <fibres material="wall" width="2 um" wall="solid" roll="uniform" volume-fraction="{share}" surface="white"/>
    </layer></sheet>
  </universe>
  {rest}
</scene>"#
    )
}

fn run(text: &str, histories: u64) -> RunResult {
    let options = Options::default();
    let scene = read_text(text, Path::new("ladder.xml"), &options).unwrap_or_else(|e| panic!("{e:?}"));
    let args = RunArgs { histories: Some(histories), ..RunArgs::default() };
    finish(scene, &args, |_| true).unwrap().result
}

fn figure(r: &RunResult, name: &str) -> (f64, f64) {
    let f = r.figures.iter().find(|f| f.name == name).unwrap();
    (f.value.unwrap(), f.error.unwrap())
}

fn write(name: &str, svg: &str) {
    if std::env::var_os("LIGHTPRO_WRITE").is_some() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/figures").join(name);
        std::fs::write(path, svg).unwrap();
    }
}

/// R over the rungs at three shares; none lies far below, full on the explicit realisations.
#[test]
fn ladder() {
    let histories = if std::env::var_os("LIGHTPRO_WRITE").is_some() { 400_000 } else { 60_000 };
    let mut curves = Vec::new();
    for (share, explicit) in [(0.1, 0.4501), (0.3, 0.7696), (0.5, 0.8973)] {
        let diffuse = r#"<source kind="diffuse"/><spectrum at="550 nm"/>"#;
        let points: Vec<(f64, f64, f64)> = ["none", "1", "2", "4", "8", "16", "full"]
            .iter()
            .enumerate()
            .map(|(i, memory)| {
                let (r, se) = figure(&run(&scene(share, memory, diffuse), histories), "reflectance");
                println!("share {share}, memory {memory}: R {r:.4} ± {se:.4}");
                (i as f64, r, se)
            })
            .collect();
        assert!((points[6].1 - explicit).abs() < 4.0 * points[6].2 + 0.002);
        assert!(points[6].1 - points[0].1 > 0.02);
        let line = Curve { label: format!("share {share}"), points };
        let mean = Curve {
            label: format!("explicit {share}"),
            points: vec![(0.0, explicit, 9e-4), (6.0, explicit, 9e-4)],
        };
        curves.extend([line, mean]);
    }
    let plot = LinePlot {
        title: "Reflectance of white fibre sheets over the rung",
        x: ("rung: none, k = 1, 2, 4, 8, 16, full", "1"),
        y: ("reflectance", "1"),
        curves: &curves,
        dots: true,
    };
    write("ladder.svg", &plot.svg());
}

/// Bidirectional reflectance factor around the way back, with and without memory.
#[test]
fn hot_spot() {
    let histories = if std::env::var_os("LIGHTPRO_WRITE").is_some() { 4_000_000 } else { 200_000 };
    let healpix = Healpix::new(16).unwrap();
    let mut curves = Vec::new();
    for memory in ["none", "full"] {
        let rest =
            r#"<source kind="collimated" polar="0 deg"/><spectrum at="550 nm"/><detect angular="nside 16"/>"#;
        let text = scene(0.3, memory, rest);
        let args = RunArgs { histories: Some(histories), ..RunArgs::default() };
        let scene = read_text(&text, Path::new("ladder.xml"), &Options::default()).unwrap();
        let done = finish(scene, &args, |_| true).unwrap();
        let group = &done.outcome.groups[0];
        // Rings of patches: power over that of the perfect diffuser.
        let mut rings: Vec<(f64, f64, f64)> = Vec::new();
        for pixel in 0..healpix.npix() {
            let centre = healpix.centre(pixel);
            if centre.z <= 0.05 {
                continue;
            }
            let cell = group.layout.angular_cell(centre).unwrap();
            let power = group.moments(cell, 0).mean();
            let lambert = centre.z * healpix.area() / std::f64::consts::PI;
            match rings.last_mut() {
                Some(r) if (r.0 - centre.z).abs() < 1e-9 => *r = (r.0, r.1 + power, r.2 + lambert),
                _ => rings.push((centre.z, power, lambert)),
            }
        }
        let mut points: Vec<(f64, f64, f64)> = rings
            .iter()
            .map(|(z, power, lambert)| {
                let factor = power / lambert;
                (z.acos().to_degrees(), factor, (power / histories as f64).sqrt() / lambert)
            })
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        println!("memory {memory}: {:?}", &points[..4]);
        curves.push(Curve { label: format!("memory {memory}"), points });
    }
    assert!(curves[1].points[0].1 > curves[0].points[0].1 + 0.1, "no hot spot");
    let plot = LinePlot {
        title: "White fibres, share .3, light along the normal: the way back",
        x: ("polar angle", "deg"),
        y: ("bidirectional reflectance factor", "1"),
        curves: &curves,
        dots: false,
    };
    write("hot-spot.svg", &plot.svg());
}
