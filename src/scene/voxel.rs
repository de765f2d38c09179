//! From the checked scene to a voxel universe.

use super::model::{Scene, Source, Voxels};
use crate::universe::SurfaceId;
use crate::universe::voxel::{Lateral, NormalRule, Rules, Steps, VoxelUniverse};

/// The universe, and what `plan` has to say of it.
///
/// # Errors
/// Sizes out of range.
pub fn build(v: &Voxels, scene: &Scene) -> Result<(VoxelUniverse, Vec<String>), String> {
    // A source with a place of its own asks for the volume at its own.
    let placed = matches!(scene.source, Source::Point { .. })
        || matches!(scene.source, Source::Collimated { radius, .. } if radius > 0.0);
    let rules = Rules { anywhere: v.random.unwrap_or(!placed), ..v.rules.clone() };
    let universe =
        VoxelUniverse::new(v.volume.clone(), v.phases.clone(), &rules).map_err(|e| e.to_string())?;
    let remarks = remarks(v, &rules, scene);
    Ok((universe, remarks))
}

fn remarks(v: &Voxels, rules: &Rules, scene: &Scene) -> Vec<String> {
    let [nx, ny, nz] = v.volume.cells();
    let [dx, dy, dz] = rules.edge;
    let sides = if rules.lateral == Lateral::Mirror { "mirrored" } else { "repeated" };
    let place = if rules.anywhere { "each ray finds it displaced at random" } else { "standing still" };
    let mut out = vec![format!(
        "volume: {nx} x {ny} x {nz} voxels of {dx} x {dy} x {dz} um, {} bit each, {:.1} MB; sides {sides}, {place}",
        v.volume.bits(),
        v.volume.bytes() as f64 * 1e-6,
    )];
    let counts = v.volume.counts(v.phases.len());
    let shares = v.phases.iter().zip(counts).map(|(p, n)| {
        let material = &scene.materials[usize::from(p.medium.0)].id;
        let surface = match p.surface {
            SurfaceId::SMOOTH => String::new(),
            s => format!(" ({})", scene.surfaces[usize::from(s.0)].id),
        };
        format!("'{material}'{surface} {:.2} %", 100.0 * n as f64 / v.volume.len() as f64)
    });
    out.push(format!("labels: {}", shares.collect::<Vec<_>>().join(", ")));
    out.push(match (rules.normals, rules.steps) {
        (NormalRule::Faces, _) => "normals of voxel faces: they never converge".to_owned(),
        (NormalRule::Smoothed(s), Steps::Passed) => format!("normals smoothed over {s} voxels"),
        (NormalRule::Smoothed(s), Steps::Mirrored) => {
            format!("normals smoothed over {s} voxels; every step of the staircase is met: biased")
        }
    });
    out
}
