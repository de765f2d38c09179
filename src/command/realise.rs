//! `realise`, and what `check` tells of the structure of a scene.

use super::{Failure, SceneArgs, heading, load};
use crate::report::{mesh, write_atomic};
use crate::scene::media::Media;
use crate::scene::model::{Cell, Edges, StartIn};
use crate::scene::{Options, Scene, Universe, realise, written};
use crate::study::characterise::bodies::BodyParts;
use crate::study::characterise::lines;
use crate::study::structure::Structure;
use crate::universe::shape::{Placed, Shape, SlabZ};
use crate::universe::synthetic::realise::Boolean;
use crate::universe::synthetic::stack::{self, Layer};
use crate::universe::synthetic::{Part, Search, Setting, SyntheticUniverse};
use crate::universe::voxel::write::{self, Grid, Vti};
use crate::universe::{BodyId, MediumId, Overlap, SurfaceId};
use std::fmt;
use std::path::{Path, PathBuf};

/// What `realise` was asked to write.
#[derive(Clone, Debug, Default)]
pub struct RealiseArgs {
    /// Stem of the files; by default the scene's path without `.xml`, and `-realised`.
    pub out: Option<PathBuf>,
    /// Number of the realisation.
    pub realisation: u64,
    /// Edge of the periodic cell, µm.
    pub cell: Option<f64>,
    /// Edge of a voxel, µm: write a volume too.
    pub voxel: Option<f64>,
    /// The volume as MetaImage (.mhd and .raw) instead of NRRD.
    pub mhd: bool,
    /// The volume as VTK ImageData beside it.
    pub vti: bool,
    /// Existing files may be overwritten.
    pub force: bool,
}

/// One realisation of a sheet.
struct Drawn {
    universe: SyntheticUniverse,
    cell: Cell,
    media: Media,
}

fn told(path: &Path, e: &dyn fmt::Display) -> Failure {
    Failure::Input(format!("error: {}: {e}", path.display()))
}

/// The scene that is realised, as it was read.
struct Source<'a> {
    text: String,
    path: &'a Path,
    options: Options,
}

impl Source<'_> {
    /// Its text with another universe.
    fn with(&self, universe: &str) -> Result<String, Failure> {
        written::replace_universe(&self.text, self.path, &self.options, universe).map_err(Failure::Input)
    }
}

/// `realise`: a statistical sheet body by body, as a scene, a mesh and a volume.
///
/// # Errors
/// Sheets that cannot be realised, files that cannot be written.
pub fn realise(args: &SceneArgs, how: &RealiseArgs) -> Result<String, Failure> {
    let (scene, _) = load(args)?;
    let drawn = draw(&scene, how).map_err(|e| told(&scene.path, &e))?;
    let stem = how.out.clone().unwrap_or_else(|| {
        let name = scene.path.file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        scene.path.with_file_name(format!("{name}-realised"))
    });
    let named = |end: &str| PathBuf::from(format!("{}{end}", stem.display()));
    let files = Files {
        scene: named(".xml"),
        mesh: named(".vtp"),
        volume: how.voxel.map(|_| named(if how.mhd { "-voxels.mhd" } else { "-voxels.nrrd" })),
        vti: how.voxel.filter(|_| how.vti).map(|_| named("-voxels.vti")),
        voxel_scene: how.voxel.map(|_| named("-voxels.xml")),
    };
    files.free(how.force)?;
    let bodies: Vec<BodyParts> = drawn.universe.bodies().collect();
    let text = std::fs::read_to_string(&scene.path).map_err(|e| told(&scene.path, &e))?;
    let source = Source { text, path: &scene.path, options: args.reading() };
    let universe = written::explicit(&bodies, drawn.cell, drawn.universe.ambient(), &drawn.media, &scene)
        .map_err(|e| told(&scene.path, &e))?;
    write_atomic(&files.scene, source.with(&universe)?.as_bytes()).map_err(|e| told(&files.scene, &e))?;
    let (vtp, left_out) = mesh::vtp(&bodies);
    write_atomic(&files.mesh, vtp.as_bytes()).map_err(|e| told(&files.mesh, &e))?;
    let [x, y] = drawn.cell.period;
    let mut said = format!(
        "{}\nrealisation {}: {} bodies in a cell of {x:.1} x {y:.1} x {:.1} um\n{}\n{}\n",
        heading(&scene),
        how.realisation,
        bodies.len(),
        drawn.cell.planes[1] - drawn.cell.planes[0],
        files.scene.display(),
        files.mesh.display()
    );
    if left_out > 0 {
        said += &format!("{left_out} bodies without end are not in the mesh\n");
    }
    if let Some(rho) = scene.universe.sheet().and_then(|s| s.backing) {
        said += &format!(
            "warning: bodies and volumes have no backing, that of the sheet (reflectance {rho}) is left out: put a <slab> with \
             an opaque Lambertian surface below the cell\n"
        );
    }
    if let Some(edge) = how.voxel {
        said += &voxelise(&drawn, &scene, edge, &files, &source, how.mhd)?;
    }
    if stem.parent() != scene.path.parent() && !scene.files.is_empty() {
        said +=
            "files that the scene names are meant from its own folder: write beside it, or move them too\n";
    }
    Ok(said)
}

struct Files {
    scene: PathBuf,
    mesh: PathBuf,
    volume: Option<PathBuf>,
    vti: Option<PathBuf>,
    voxel_scene: Option<PathBuf>,
}

impl Files {
    fn free(&self, force: bool) -> Result<(), Failure> {
        let own = [Some(&self.scene), Some(&self.mesh)].into_iter();
        let all = own.chain([&self.volume, &self.vti, &self.voxel_scene].map(Option::as_ref));
        match all.flatten().find(|p| !force && p.exists()) {
            Some(taken) => Err(told(taken, &"is there already; --force overwrites it, -o names others")),
            None => Ok(()),
        }
    }
}

fn draw(scene: &Scene, how: &RealiseArgs) -> Result<Drawn, String> {
    let Universe::Statistical(sheet) = &scene.universe else {
        return match &scene.universe {
            Universe::Realised(realised) => draw_sheet(realised, scene, how),
            Universe::Voxel(_) | Universe::Synthetic(_) => {
                Err("is explicit already: realise takes a <sheet> of statistics".to_owned())
            }
            _ => Err("a <mixture> has no bodies to realise; a <sheet> has".to_owned()),
        };
    };
    let realised = crate::scene::Realised { sheet: sheet.clone(), spread: None, deposit: None };
    draw_sheet(&realised, scene, how)
}

fn draw_sheet(realised: &crate::scene::Realised, scene: &Scene, how: &RealiseArgs) -> Result<Drawn, String> {
    let mut media = Media::of(scene.materials.iter().map(|m| m.id.clone()));
    if let Some(deposit) = &realised.deposit {
        let (number, seed) = (how.realisation, scene.run.seed);
        let (universe, planes) = crate::scene::deposit::one(
            deposit,
            &realised.sheet,
            scene,
            &mut media,
            [seed, number],
            how.cell,
        )?;
        let cell =
            Cell { period: universe.period(), planes, overlap: Overlap::Union, start: StartIn::Anywhere };
        return Ok(Drawn { universe, cell, media });
    }
    let layers = realise::plies(realised, scene, &mut media)?;
    let ([bottom, top], models) = (planes(&layers), layers.iter().filter_map(|l| l.bodies.as_ref()));
    let longest = models.clone().map(Boolean::longest).fold(0.0, f64::max);
    // Two lengths of the longest body; at least twenty thicknesses of the sheet.
    let side = how.cell.unwrap_or_else(|| (2.2 * longest).max(20.0 * (top - bottom)));
    let mut parts = Vec::new();
    for (i, layer) in layers.iter().enumerate() {
        let Some(model) = &layer.bodies else {
            parts.push(slab(layer, i));
            continue;
        };
        let seed = stack::seed_of(scene.run.seed, i);
        let own = model.cell([side; 2], seed, how.realisation).map_err(|e| {
            format!("{e} (a periodic cell wants bodies with an end: ends=\"flat\" and a length)")
        })?;
        parts.extend(own.bodies().flat_map(|b| [Some(b.0), b.1]).flatten());
    }
    // Bodies of several layers, all of priority 0, are of different layers or as their layer ranked them.
    let model = models.clone().next().ok_or("no layer holds bodies")?;
    let setting = Setting {
        overlap: model.overlap,
        sheet: Some([bottom, top]),
        period: Some([side; 2]),
        search: Search::Automatic,
    };
    let universe = SyntheticUniverse::with(model.pore, parts, setting).map_err(|e| e.to_string())?;
    let sheet = &realised.sheet;
    let start = if sheet.edges == Edges::Cut { sheet.start } else { StartIn::Anywhere };
    let cell = Cell { period: [side; 2], planes: [bottom, top], overlap: model.overlap, start };
    Ok(Drawn { universe, cell, media })
}

/// Planes of a cell of such layers: those of the sheet, or beyond a homogeneous layer's face by a micrometre, for
/// the planes of a cell are no surfaces.
fn planes(layers: &[Layer]) -> [f64; 2] {
    let beyond = |l: &Layer| if l.bodies.is_some() { 0.0 } else { 1.0 };
    let ends = layers.first().zip(layers.last());
    ends.map_or([0.0; 2], |(top, bottom)| [bottom.slab.bottom - beyond(bottom), top.slab.top + beyond(top)])
}

/// A homogeneous layer as a body.
fn slab(layer: &Layer, number: usize) -> Part {
    let shape = Shape::SlabZ(SlabZ { z_min: layer.slab.bottom, z_max: layer.slab.top });
    Part {
        shape: Placed::at_origin(shape),
        medium: layer.slab.pore,
        surface: SurfaceId::SMOOTH,
        priority: 0,
        body: BodyId(number as u32),
    }
}

/// Writes the volume and its scene; says what became of the shares of volume.
fn voxelise(
    drawn: &Drawn,
    scene: &Scene,
    edge: f64,
    files: &Files,
    source: &Source,
    mhd: bool,
) -> Result<String, Failure> {
    let (Some(volume), Some(voxel_scene)) = (&files.volume, &files.voxel_scene) else {
        return Ok(String::new());
    };
    let [bottom, top] = drawn.cell.planes;
    let sizes = [drawn.cell.period[0], drawn.cell.period[1], top - bottom];
    let cells = sizes.map(|s| (s / edge).round().max(1.0) as usize);
    // Voxels fill the cell: their edges differ from what was asked for by less than half of one in all.
    let edges = [0, 1, 2].map(|a| sizes[a] / cells[a] as f64);
    let mut labels: Vec<MediumId> = vec![drawn.universe.ambient()];
    for (body, hollow) in drawn.universe.bodies() {
        for medium in [Some(body.medium), hollow.map(|h| h.medium)].into_iter().flatten() {
            if !labels.contains(&medium) {
                labels.push(medium);
            }
        }
    }
    let mut counts = vec![0_u64; labels.len()];
    let grid = Grid { cells, edge: edges };
    let mut beside = match &files.vti {
        Some(file) => Some(Vti::create(file, grid, bottom).map_err(|e| told(file, &e))?),
        None => None,
    };
    let mut fault = None;
    let slice = |z: usize, out: &mut [u8]| {
        use rayon::prelude::*;
        out.par_chunks_mut(cells[0]).enumerate().for_each(|(y, row)| {
            for (x, label) in row.iter_mut().enumerate() {
                let at = crate::math::DVec3::new(
                    (x as f64 + 0.5) * edges[0],
                    (y as f64 + 0.5) * edges[1],
                    bottom + (z as f64 + 0.5) * edges[2],
                );
                let medium = drawn.universe.medium_at(at);
                *label = labels.iter().position(|&m| m == medium).unwrap_or(0) as u8;
            }
        });
        out.iter().for_each(|&l| counts[usize::from(l)] += 1);
        let written = beside.as_mut().map_or(Ok(()), |v| v.slice(out));
        fault = fault.take().or(written.err());
    };
    let done = if mhd { write::mhd(volume, grid, slice) } else { write::nrrd(volume, grid, true, slice) };
    done.map_err(|e| told(volume, &e))?;
    if let (Some(file), Some(v)) = (&files.vti, beside) {
        fault.map_or(Ok(()), Err).and_then(|()| v.finish()).map_err(|e| told(file, &e))?;
    }
    let name = volume.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let universe = written::voxels(&name, edges, &labels, drawn.universe.ambient(), &drawn.media, scene);
    write_atomic(voxel_scene, source.with(&universe)?.as_bytes()).map_err(|e| told(voxel_scene, &e))?;
    let total: u64 = counts.iter().sum();
    let shares: Vec<String> = labels
        .iter()
        .zip(&counts)
        .map(|(m, &n)| {
            format!("{} {:.3} %", drawn.media.names[usize::from(m.0)], 100.0 * n as f64 / total as f64)
        })
        .collect();
    let [x, y, z] = cells;
    let finer = match edge > 0.34 * drawn.universe.thinnest() {
        true => {
            "fewer than three voxels lie across the thinnest wall: surfaces will be off (docs/voxels.md)\n"
        }
        false => "",
    };
    Ok(format!(
        "{} ({x} x {y} x {z} voxels: {})\n{}\n{finer}",
        volume.display(),
        shares.join(", "),
        voxel_scene.display()
    ))
}

/// `check --structure`: amounts measured, overlaps, lost rays; sections and a mesh into `folder`.
///
/// # Errors
/// Universes that stand nowhere, files that cannot be written.
pub fn structure(args: &SceneArgs, folder: Option<&Path>) -> Result<String, Failure> {
    let (scene, plan) = load(args)?;
    let bad = |e: String| told(&scene.path, &e);
    let mut text = measured(&scene).map_err(bad)?;
    let overlap = scene.universe.sheet().map(|s| s.overlap);
    let structure = Structure::of(&scene, plan).map_err(bad)?;
    if !structure.bodies.is_empty() {
        let found = structure.overlaps(200_000, scene.run.seed);
        text += &found.describe();
        if found.several > 0 {
            text += match overlap {
                Some(Overlap::Union) => "  overlap=\"union\": walls merge\n",
                Some(Overlap::Forbid) => "  overlap=\"forbid\": these should not be\n",
                _ => "  the body of higher priority, of two equal ones the later, owns what several cover\n",
            };
        }
    }
    if let Some(folder) = folder {
        std::fs::create_dir_all(folder).map_err(|e| told(folder, &e))?;
        let mut files: Vec<(String, String)> = structure
            .sections(&scene.name, 400.0)
            .into_iter()
            .map(|(name, svg)| (format!("section-{name}.svg"), svg))
            .collect();
        if !structure.bodies.is_empty() {
            files.push(("bodies.vtp".to_owned(), mesh::vtp(&structure.bodies).0));
        }
        files
            .extend(structure.surfaces().into_iter().map(|(name, vtp)| (format!("surface-{name}.vtp"), vtp)));
        for (name, content) in &files {
            let path = folder.join(name);
            write_atomic(&path, content.as_bytes()).map_err(|e| told(&path, &e))?;
            text += &format!("{}\n", path.display());
        }
    }
    Ok(format!("{}\n{text}", heading(&scene)))
}

/// Amounts by straight lines, and rays lost by a small run.
fn measured(scene: &Scene) -> Result<String, String> {
    let mut out = String::new();
    if let Ok(found) = crate::study::characterise::characterise(scene, 100_000) {
        out += &found.to_string();
        if let Some(sheet) = scene.universe.sheet() {
            let density = |name: &str| {
                let all = sheet.layers.iter().flat_map(|l| &l.components);
                all.filter(|c| name == c.name || name.starts_with(&c.name)).map(|c| c.density).next()
            };
            for (m, name) in found.media.iter().enumerate().skip(scene.materials.len()) {
                if let Some(density) = density(name) {
                    let grammage = |c: &lines::Counted| c.share(m) * found.thickness * density * 1e-3;
                    let (g, se) = found.value(grammage);
                    out += &format!("{name}: {g:.3}({se:.3}) g/m2 of solid found\n");
                }
            }
        }
    }
    let mut probe = scene.clone();
    probe.run.histories = 4096;
    let plan = crate::scene::plan::Plan::new(&probe)?;
    let outcome = crate::run::simulate(&probe, &plan, |_| true).map_err(|e| e.to_string())?;
    let (lost, capped) = outcome.troubled();
    out += &format!(
        "probe: {} histories, {} events, {lost} lost, {capped} capped\n",
        outcome.done(),
        outcome.events()
    );
    Ok(out)
}
