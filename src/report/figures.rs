//! From the sums of a run to figures with error bars.

use super::result::{EffectUsed, MemoryUsed, Share, VoxelSteps};
use super::{Figure, Ordered, RunResult, Status};
use crate::optics::figures::{Measured, PaperWeights};
use crate::run::Outcome;
use crate::run::simulate::GroupResult;
use crate::scene::plan::Plan;
use crate::scene::{Amount, Scene};
use crate::stats::{self, Moments, jackknife};
use crate::tally::{Cell, klems};
use crate::universe::{Kept, MediumId};

/// Everything that goes into `result.json`.
pub fn result(scene: &Scene, plan: &Plan, outcome: &Outcome) -> RunResult {
    let mut figures =
        if plan.converts { super::fluorescence::figures(outcome) } else { paper_figures(scene, outcome) };
    figures.extend(spectral(scene, plan, outcome));
    // What is not counted history by history comes from a jackknife over the replicas.
    let replicas = outcome.groups.iter().map(|g| g.node.replicas.len()).min().unwrap_or(0);
    for f in figures.iter_mut().filter(|f| f.dof.is_none()) {
        f.dof = Some(replicas as f64 - 1.0);
    }
    label(scene, &mut figures);
    RunResult {
        lightpro: env!("CARGO_PKG_VERSION").to_owned(),
        scene: scene.name.clone(),
        complete: outcome.complete,
        histories: outcome.groups.first().map_or(0, |g| g.node.histories),
        figures,
        ledger: ledger(plan, outcome),
        effects: effects(plan),
        memory: memory(outcome),
        voxels: steps(outcome),
    }
}

/// Says at every figure what was forced off although the scene calls for it.
fn label(scene: &Scene, figures: &mut [Figure]) {
    let lacking: Vec<String> =
        scene.forced_off().map(|o| format!("without {} ({})", o.kind.name(), o.reason)).collect();
    if lacking.is_empty() {
        return;
    }
    for f in figures {
        let before = f.note.take().map_or(String::new(), |n| format!("{n}; "));
        f.note = Some(format!("{before}{}", lacking.join(", ")));
    }
}

/// What histories have kept, if anything.
fn memory(outcome: &Outcome) -> Option<MemoryUsed> {
    let mut kept = Kept::default();
    outcome.groups.iter().for_each(|g| kept.add(g.node.kept));
    let samples: u64 = outcome.groups.iter().map(|g| g.node.samples).sum();
    (kept.segments > 0).then(|| MemoryUsed {
        bodies: kept.bodies as f64 / samples as f64,
        segments: kept.segments as f64 / samples as f64,
        largest_bytes: kept.bytes,
        pockets: kept.pockets,
    })
}

/// What the staircases of a volume did, if anything.
fn steps(outcome: &Outcome) -> Option<VoxelSteps> {
    let mut kept = Kept::default();
    outcome.groups.iter().for_each(|g| kept.add(g.node.kept));
    let histories: u64 = outcome.groups.iter().map(|g| g.node.histories).sum();
    let mean = |n: u64| n as f64 / histories as f64;
    (kept.steps + kept.forced > 0).then(|| VoxelSteps { passed: mean(kept.steps), forced: mean(kept.forced) })
}

/// Effects of the plan, for result and manifest.
pub fn effects(plan: &Plan) -> Ordered<EffectUsed> {
    let used = |e: &crate::scene::effects::Effect| {
        (e.name.to_owned(), EffectUsed { on: e.on, why: e.reason.clone() })
    };
    Ordered(plan.effects.iter().map(used).collect())
}

/// A figure from the moments of its scores.
pub fn figure(name: &str, m: &Moments, batches: u64, unit: &str) -> Figure {
    let figure = Figure::new(name, m.mean(), m.standard_error(), unit).with_dof(m.dof());
    match stats::status(m, None, batches) {
        stats::Status::Ok => figure,
        stats::Status::Unreliable(why) => figure.with_status(Status::Unreliable).with_note(why),
        stats::Status::UpperBound => {
            let bound = stats::upper_bound95(m.n);
            Figure { value: Some(bound), error: None, ..figure }
                .with_status(Status::UpperBound)
                .with_note("nothing was counted; 95 % upper bound of the share of histories")
        }
    }
}

/// Mean and standard error of the scores of a set of cells together: exact, as the batches' replicas add
/// them history by history; one degree of freedom less than there are replicas.
pub fn together(group: &GroupResult, lane: usize, cells: &[usize]) -> (f64, f64) {
    let lanes = group.layout.lanes;
    let replicas: Vec<(u64, Vec<f64>)> = group
        .node
        .replicas
        .values()
        .map(|(n, sums)| (*n, vec![cells.iter().map(|c| sums[c * lanes + lane]).sum()]))
        .collect();
    jackknife(&replicas, |mean| mean.to_vec())[0]
}

/// Reciprocity of the BRDF as it came out, from the Klems matrix of diffuse light: power reflected from patches
/// into patches of rings farther from the normal, less that on the same ways back. Helmholtz's f(i, o) = f(o, i)
/// makes it 0; masked, renormalised or paper-style surfaces need not keep it.
fn reciprocity(group: &GroupResult, lane: usize) -> Option<Figure> {
    let layout = &group.layout;
    layout.detectors.klems.then_some(())?;
    let start = layout.detectors_start() + layout.detectors.klems_start();
    let cell = |from: usize, to: usize| (start + from * 2 * klems::PATCHES + to) * layout.lanes + lane;
    let outwards = |from: usize| {
        (0..klems::PATCHES).filter(move |&to| klems::ring(from) < klems::ring(to)).map(move |to| (from, to))
    };
    let pairs: Vec<(usize, usize)> = (0..klems::PATCHES).flat_map(outwards).collect();
    let replicas: Vec<(u64, Vec<f64>)> = (group.node.replicas.values())
        .map(|(n, sums)| {
            (*n, vec![pairs.iter().map(|&(i, o)| sums[cell(i, o)] - sums[cell(o, i)]).sum::<f64>()])
        })
        .collect();
    let (defect, error) = jackknife(&replicas, |mean| mean.to_vec())[0];
    let note = "power reflected outwards less that on the ways back: 0 where the BRDF is reciprocal";
    Some(Figure::new("brdf_reciprocity_defect", defect, error, "1").with_note(note))
}

/// Mean of one cell over that of another.
fn quotient(group: &GroupResult, lane: usize, top: usize, bottom: usize) -> (f64, f64) {
    let lanes = group.layout.lanes;
    let replicas: Vec<(u64, Vec<f64>)> = (group.node.replicas.values())
        .map(|(n, sums)| (*n, vec![sums[top * lanes + lane], sums[bottom * lanes + lane]]))
        .collect();
    jackknife(&replicas, |mean| vec![mean[0] / mean[1]])[0]
}

/// Totals and path figures at each wavelength.
fn spectral(scene: &Scene, plan: &Plan, outcome: &Outcome) -> Vec<Figure> {
    let mut out = Vec::new();
    for (nm, group, lane) in outcome.wavelengths() {
        let layout = &group.layout;
        let batches = group.node.batches;
        let mut put = |f: Figure| out.push(f.at_wavelength(nm));
        let cell = |c: Cell| group.moments(layout.of(c), lane);
        put(figure("reflectance", &cell(Cell::Reflected), batches, "1"));
        put(figure("transmittance", &cell(Cell::Transmitted), batches, "1"));
        for (name, side) in [("reflectance", 0), ("transmittance", 1)] {
            if let Some((sd, error)) = group.between(side, lane) {
                put(Figure::new(&format!("{name}_between_realisations"), sd, error, "1"));
            }
        }
        reciprocity(group, lane).into_iter().for_each(&mut put);
        let media = || (0..plan.media.names.len()).map(|i| MediumId(i as u16));
        let mut cells: Vec<usize> = media().map(|m| layout.absorbed(m)).collect();
        cells.push(layout.of(Cell::Backing));
        let (a, se) = together(group, lane, &cells);
        put(Figure::new("absorptance", a, se, "1"));
        for (id, name) in media().zip(&plan.media.names) {
            let m = group.moments(layout.absorbed(id), lane);
            if m.mean() > 0.0 {
                put(figure("absorbed", &m, batches, "1").of_component(name));
            }
        }
        if plan.converts {
            put(figure("converted", &cell(Cell::Converted), batches, "1"));
        }
        if scene.detect.checkpoint.is_some() {
            put(figure("checkpoint", &cell(Cell::Checkpoint), batches, "1"));
        }
        if layout.time {
            for (name, time, of) in [
                ("mean_time_reflected", Cell::TimeReflected, Cell::Reflected),
                ("mean_time_transmitted", Cell::TimeTransmitted, Cell::Transmitted),
            ] {
                let (t, se) = quotient(group, lane, layout.of(time), layout.of(of));
                put(Figure::new(name, t, se, "ps"));
            }
        }
        if scene.detect.path {
            for (id, name) in media().zip(&plan.media.names) {
                let m = group.moments(layout.path_length(id), lane);
                if m.mean() > 0.0 {
                    put(figure("mean_path", &m, batches, "um").of_component(name));
                }
            }
            put(figure("mean_collisions", &cell(Cell::Interfaces), batches, "1"));
            put(figure("mean_scatterings", &cell(Cell::Scatterings), batches, "1"));
        }
        super::instruments::figures(scene, group, lane).into_iter().for_each(&mut put);
    }
    out
}

/// Cells of the simulated pile at doubling `level`.
fn pile_cells(group: &GroupResult, level: usize) -> std::ops::Range<usize> {
    let start = group.layout.pile_cell(0);
    start..start + level + 1
}

/// Per replica: histories, and sums of R0 then R of each pile doubling, over all wavelengths.
fn pile_replicas(outcome: &Outcome, levels: usize) -> Vec<(u64, Vec<f64>)> {
    let Some(first) = outcome.groups.first() else { return Vec::new() };
    let keys: Vec<u8> = first.node.replicas.keys().copied().collect();
    keys.iter()
        .map(|key| {
            let mut sums = Vec::new();
            for level in 0..levels {
                for (_, group, lane) in outcome.wavelengths() {
                    let (_, have) = &group.node.replicas[key];
                    let at = |c: usize| have[c * group.layout.lanes + lane];
                    sums.push(pile_cells(group, level).map(at).sum());
                }
            }
            (first.node.replicas[key].0, sums)
        })
        .collect()
}

/// Brightness, opacity, s and k, colour and whiteness; R0 and R∞ at each wavelength.
fn paper_figures(scene: &Scene, outcome: &Outcome) -> Vec<Figure> {
    let Some(optics) = &scene.optics else { return Vec::new() };
    if outcome.groups.is_empty() {
        return Vec::new();
    }
    let wavelengths: Vec<f64> = outcome.wavelengths().map(|w| w.0).collect();
    let n = wavelengths.len();
    let levels = outcome.groups[0].layout.pile_levels();
    let weights = PaperWeights::new(&wavelengths);
    let grammage = optics.grammage.or_else(|| sheet_grammage(scene));
    let measure = |mean: &[f64]| {
        weights.evaluate(Measured {
            r0: Some(&mean[..n]),
            r_inf: (levels > 1 && optics.backing.is_none()).then(|| &mean[(levels - 1) * n..]),
            grammage: grammage.map(|g| g * 1e-3),
        })
    };
    let replicas = pile_replicas(outcome, levels);
    let values = jackknife(&replicas, |mean| {
        let mut out: Vec<f64> =
            measure(mean).iter().map(|f| *f.value.as_ref().unwrap_or(&f64::NAN)).collect();
        out.extend_from_slice(mean);
        // What the last doubling of the pile added, at each wavelength.
        for i in 0..n {
            out.push(if levels > 1 { mean[(levels - 1) * n + i] - mean[(levels - 2) * n + i] } else { 0.0 });
        }
        out
    });
    let means: Vec<f64> = values[values.len() - n * (levels + 1)..].iter().map(|v| v.0).collect();
    let kinds = measure(&means[..n * levels]);
    let batches = outcome.groups.iter().map(|g| g.node.batches).min().unwrap_or(0);
    let trust = |f: Figure| {
        if batches < 10 && f.status == Status::Ok {
            f.with_status(Status::Unreliable).with_note("fewer than 10 batches")
        } else {
            f
        }
    };
    let mut out: Vec<Figure> =
        kinds.iter().zip(&values).map(|(f, (_, se))| trust(Figure::of_paper(f, *se))).collect();
    let spectral = &values[kinds.len()..];
    for (i, &nm) in wavelengths.iter().enumerate() {
        let (r0, r_inf, last) = (spectral[i], spectral[(levels - 1) * n + i], spectral[levels * n + i]);
        out.push(trust(Figure::new("r0", r0.0, r0.1, "1").at_wavelength(nm)));
        if levels < 2 {
            continue;
        }
        if optics.backing.is_some() {
            out.push(trust(Figure::new("r_backing", r_inf.0, r_inf.1, "1").at_wavelength(nm)));
            continue;
        }
        let mut pad = trust(Figure::new("r_infinity", r_inf.0, r_inf.1, "1").at_wavelength(nm));
        if last.0 > r_inf.1 {
            pad = pad.with_status(Status::Unreliable).with_note(&format!(
                "the last doubling to {} sheets still added {:.1e}: a thicker pile (<optics pile=…>)",
                optics.pile, last.0
            ));
        }
        out.push(pad);
    }
    out
}

/// Grammage of the sheet as the scene gives it, g/m².
fn sheet_grammage(scene: &Scene) -> Option<f64> {
    let sheet = scene.universe.sheet()?;
    let mut sum = 0.0;
    for c in sheet.layers.iter().flat_map(|l| &l.components) {
        match c.amount {
            Amount::Grammage(g) => sum += g,
            _ => return None,
        }
    }
    (sum > 0.0).then_some(sum)
}

/// Where the power went, averaged over wavelengths.
fn ledger(plan: &Plan, outcome: &Outcome) -> Ordered<Share> {
    // Where events change the wavelength, a pass emits one unit of power into all its lanes.
    let count = if plan.converts { outcome.groups.len() } else { outcome.wavelengths().count() } as f64;
    let mean = |cells: &dyn Fn(&GroupResult) -> Vec<usize>| {
        let (mut value, mut variance) = (0.0, 0.0);
        for group in &outcome.groups {
            // Wavelengths of one group share their histories: their errors add.
            let mut se = 0.0;
            for lane in 0..group.layout.lanes {
                let (v, e) = together(group, lane, &cells(group));
                value += v / count;
                se += if e.is_finite() { e / count } else { 0.0 };
            }
            variance += se * se;
        }
        Share { value, error: variance.sqrt() }
    };
    let one = |c: Cell| mean(&|g: &GroupResult| vec![g.layout.of(c)]);
    let mut rows = vec![
        ("reflected".to_owned(), one(Cell::Reflected)),
        ("transmitted".to_owned(), one(Cell::Transmitted)),
    ];
    for (i, name) in plan.media.names.iter().enumerate() {
        let share = mean(&|g: &GroupResult| vec![g.layout.absorbed(MediumId(i as u16))]);
        if share.value > 0.0 {
            rows.push((format!("absorbed: {name}"), share));
        }
    }
    for (name, cell) in [
        ("backing", Cell::Backing),
        ("masked", Cell::Masked),
        ("roulette balance", Cell::Roulette),
        ("lost", Cell::Lost),
        ("truncated", Cell::Truncated),
    ] {
        let share = one(cell);
        let always = matches!(cell, Cell::Roulette | Cell::Lost | Cell::Truncated);
        if always || share.value != 0.0 {
            rows.push((name.to_owned(), share));
        }
    }
    Ordered(rows)
}
