//! The shipped volume scenes/data/fibres.nrrd: nine hollow fibres, made here from a seed.
//! `LIGHTPRO_WRITE=1 cargo test --test voxel_universe the_shipped` writes it anew, and a plate.

use super::*;
use lightpro::universe::voxel::read::{Labels, open};
use lightpro::universe::voxel::write::{Grid, nrrd};
use std::path::Path;

pub const CELLS: [usize; 3] = [64, 64, 48];

/// Labels of the centres of voxels of 1/`fine` µm: 0 pore, 1 wall, 2 lumen. Fibres lie in the plane, unbounded, flattened;
/// where they overlap a wall is a wall.
pub fn labels(fine: usize) -> Vec<u8> {
    let h = 1.0 / fine as f64;
    let centre = |i: usize| (i as f64 + 0.5) * h;
    let mut s = stream(48);
    let fibres: Vec<_> = (0..9)
        .map(|i| {
            let azimuth = TAU * s.uniform();
            let offset = 64.0 * (s.uniform() - 0.5);
            let z = 8.0 + 4.0 * f64::from(i);
            let half = (8.0 + 4.0 * s.uniform(), 4.5 + 2.0 * s.uniform());
            let wall = 2.5 + s.uniform();
            (azimuth.sin_cos(), offset, z, half, wall)
        })
        .collect();
    let mut out = Vec::new();
    for k in 0..fine * CELLS[2] {
        for j in 0..fine * CELLS[1] {
            for i in 0..fine * CELLS[0] {
                let (x, y, z) = (centre(i) - 32.0, centre(j) - 32.0, centre(k));
                let mut label = 0;
                for ((sin, cos), offset, height, (a, b), wall) in &fibres {
                    let across = x * sin - y * cos - offset;
                    let level = |a: f64, b: f64| (across / a).powi(2) + ((z - height) / b).powi(2);
                    if level(*a, *b) < 1.0 {
                        let lumen = level(a - wall, b - wall) < 1.0;
                        label = if lumen && label != 1 { 2 } else { 1 };
                    }
                }
                out.push(label);
            }
        }
    }
    out
}

#[test]
fn the_shipped_volume_is_what_the_seed_makes() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/data/fibres.nrrd");
    let made = labels(1);
    if std::env::var_os("LIGHTPRO_WRITE").is_some() {
        let plane = CELLS[0] * CELLS[1];
        let grid = Grid { cells: CELLS, edge: [1.0; 3] };
        nrrd(&file, grid, true, |z, slice| slice.copy_from_slice(&made[z * plane..][..plane])).unwrap();
    }
    let map = Labels::new(vec![(0, 0, 0), (1, 1, 1), (2, 2, 2)]).unwrap();
    let shipped = open(&file).unwrap().load(&map, false, 1 << 20).unwrap();
    assert!(shipped == Volume::of(CELLS, &made).unwrap());
    let shares: Vec<f64> = shipped.counts(3).iter().map(|&n| n as f64 / made.len() as f64).collect();
    println!("{shares:?}, {} bytes", std::fs::metadata(&file).unwrap().len());
    assert!(shares[1] > 0.15 && shares[2] > 0.02, "{shares:?}");
    assert!(std::fs::metadata(&file).unwrap().len() < 100_000);
}

#[test]
fn the_shipped_plate_is_solid() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/data/plate.nrrd");
    let cells = [8, 8, 4];
    if std::env::var_os("LIGHTPRO_WRITE").is_some() {
        nrrd(&file, Grid { cells, edge: [10.0, 10.0, 25.0] }, false, |_, slice| slice.fill(255)).unwrap();
    }
    let map = Labels::new(vec![(255, 255, 0)]).unwrap();
    let shipped = open(&file).unwrap().load(&map, false, 256).unwrap();
    assert!(shipped == Volume::of(cells, &[0; 256]).unwrap());
}

/// A run tells what the staircases did to its rays, whatever the number of threads: steps passed, and faces met
/// against their smooth normal, which `steps="mirrored"` meets everywhere and faces as normals never.
#[test]
fn a_run_counts_the_steps_of_its_staircases() {
    use lightpro::command::{RunArgs, SceneArgs, finish, load};
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("scenes/voxel-sheet.xml")).unwrap();
    let text = text.replace("../distributions", &root.join("distributions").display().to_string());
    let text = text
        .replace(" smoothing=\"${smoothing}\"", "")
        .replace("<define name=\"smoothing\" value=\"2\"/>", "");
    let text = text.replace("data/fibres", &root.join("scenes/data/fibres").display().to_string());
    let folder = tempfile::tempdir().unwrap();
    let run = |rule: &str, threads: usize| {
        let path = folder.path().join("v.xml");
        std::fs::write(&path, text.replace("top=\"last\"", &format!("top=\"last\" {rule}"))).unwrap();
        let (scene, _) = load(&SceneArgs { path, allow_outside: true, ..SceneArgs::default() }).unwrap();
        let run = RunArgs { histories: Some(2 * 4096), threads, ..RunArgs::default() };
        finish(scene, &run, |_| true).unwrap().result
    };
    let counted = |rule: &str| {
        let result = run(rule, 1);
        println!("{rule}: {:?}", result.voxels);
        assert_eq!(result.to_json(), run(rule, 2).to_json());
        result.voxels.map(|v| (v.passed, v.forced))
    };
    let (passed, forced) = counted("").unwrap();
    assert!(passed > 0.1 && forced < 0.1 * passed && forced > 0.0);
    let (none, met) = counted("steps=\"mirrored\"").unwrap();
    assert!(none == 0.0 && met > 5.0 * forced);
    assert_eq!(counted("normals=\"faces\""), None);
}
