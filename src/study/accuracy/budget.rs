//! T2: sources of error; T3: time to a wanted error.

use super::*;

/// The bias of the scene's own setting of a knob, if it is told from 0 (two errors), and the row.
fn own_bias<'a>(study: &'a Study, knob: &str, figure: &str) -> Option<(&'a Setting4, bool)> {
    let row =
        study.settings.iter().find(|s| s.knob == knob && s.figure == figure && s.mark.starts_with("own"))?;
    Some((row, row.bias.abs() > 2.0 * row.bias_error))
}

/// T2 of a figure: one line a source, never merged.
pub(super) fn sources(f: &Figure, study: &Study) -> Vec<Source2> {
    let title = f.title();
    let mut out = Vec::new();
    let mut put = |source: &str, size: Option<f64>, error: Option<f64>, how: &str, note: String| {
        out.push(Source2 {
            figure: title.clone(),
            source: source.to_owned(),
            size,
            error,
            how: how.to_owned(),
            note,
        });
    };
    let n = study.base.result.histories;
    put("statistical", f.error, None, "measured", format!("{n} histories of each wavelength group"));
    let between =
        study.base.result.figures.iter().find(|g| {
            g.name == format!("{}_between_realisations", f.name) && g.wavelength_nm == f.wavelength_nm
        });
    match (between.and_then(|b| b.value), study.scene.run.shared) {
        (Some(sd), m) => {
            let size = sd / ((n / m) as f64).sqrt();
            put(
                "realisation",
                Some(size),
                None,
                "measured",
                format!("contained in the statistical error; {m} histories each"),
            );
        }
        (None, _) => {
            let note = match &study.scene.universe {
                Universe::Statistical(_) | Universe::Realised(_) => {
                    "every history has a realisation of its own"
                }
                _ => "one given structure: others of its kind were not seen",
            };
            let known = study.scene.universe.sheet().is_some();
            put(
                "realisation",
                known.then_some(0.0),
                None,
                if known { "assumed" } else { "not assessed" },
                note.to_owned(),
            );
        }
    }
    for (source, knob, absent) in [
        ("SAP", "patches", "no patches: the continuous law"),
        ("branching", "branching floor", "drawn rays, no branches"),
        ("roulette", "roulette", "analog absorption"),
        ("wavelength grid", "wavelength grid", "the figure belongs to one wavelength"),
        ("universe model", "memory", ""),
    ] {
        match own_bias(study, knob, &title) {
            Some((row, told)) => {
                let how = if told { "measured" } else { "bounded" };
                let size = if told { row.bias } else { 2.0 * row.bias_error };
                let of = study.settings.iter().find(|s| s.knob == knob && s.mark.contains("reference"));
                let note = format!("setting {} against {}", row.setting, of.map_or("", |r| &r.setting));
                let exact = row.mark.contains("reference") && row.h == 0.0;
                if exact {
                    put(source, Some(0.0), None, "assumed", format!("{} is the reference", row.setting));
                } else {
                    put(source, Some(size), Some(row.bias_error), how, note);
                }
            }
            None if source == "universe model" => {
                let note = match &study.scene.universe {
                    Universe::Statistical(s) if s.memory == Memory::Full => {
                        "full memory: exact for the Boolean ensemble"
                    }
                    Universe::Realised(_) => "explicit realisations of the Boolean ensemble",
                    _ => "compare with another universe: lightpro compare",
                };
                put(source, None, None, "not assessed", note.to_owned());
            }
            None if study.refused.iter().any(|r| r.0 == knob) => {
                put(
                    source,
                    None,
                    None,
                    "not assessed",
                    study.refused.iter().find(|r| r.0 == knob).map_or(String::new(), |r| r.1.clone()),
                );
            }
            None => put(source, Some(0.0), None, "assumed", absent.to_owned()),
        }
    }
    put_voxels(study, &title, &mut put);
    let off = study.effects.iter().filter(|e| !e.on && e.change.is_some());
    let largest = off.max_by(|a, b| {
        a.change.map(f64::abs).partial_cmp(&b.change.map(f64::abs)).unwrap_or(std::cmp::Ordering::Equal)
    });
    match largest {
        Some(e) => put(
            "effects left out",
            e.change.map(f64::abs),
            None,
            "bounded",
            format!("{}: the largest change of R or T by any that can be put in", e.effect),
        ),
        None => put("effects left out", None, None, "not assessed", String::new()),
    }
    put_inputs(study, &title, &mut put);
    out
}

type Put<'a> = dyn FnMut(&str, Option<f64>, Option<f64>, &str, String) + 'a;

/// Voxel size: of an error of first order or better, what twice the size changes is the most that is left.
fn put_voxels(study: &Study, title: &str, put: &mut Put<'_>) {
    let twice = study.settings.iter().find(|s| s.knob == "voxels" && s.figure == title && s.setting == "2");
    match (&study.scene.universe, twice) {
        (Universe::Voxel(_), Some(s)) => {
            let size = s.bias.abs() + 2.0 * s.bias_error;
            let note = "the change by voxels of twice the size".to_owned();
            put("voxel size", Some(size), Some(s.bias_error), "bounded", note);
        }
        (Universe::Voxel(_), None) => {
            let note = "a finer volume beside: lightpro compare --with".to_owned();
            put("voxel size", None, None, "not assessed", note);
        }
        _ => put("voxel size", Some(0.0), None, "assumed", "no voxels".to_owned()),
    }
}

/// Input data, each number taken to be known to 1 %: root of the sum of squares, less what noise adds to it.
fn put_inputs(study: &Study, title: &str, put: &mut Put<'_>) {
    let rows: Vec<&Input2> = study.inputs.iter().filter(|i| i.figure == title).collect();
    let Some(most) = rows.iter().max_by(|a, b| a.change.abs().total_cmp(&b.change.abs())) else {
        let note = "a scene states no uncertainties: run --sweep over them".to_owned();
        return put("input data", None, None, "not assessed", note);
    };
    let noise: f64 = rows.iter().map(|i| i.error * i.error).sum();
    let squares: f64 = rows.iter().map(|i| i.change * i.change).sum();
    // Not told from noise: what could be hidden in it.
    let told = squares > 4.0 * noise;
    let size = if told { (squares - noise).sqrt() } else { 2.0 * noise.sqrt() };
    let note =
        format!("each of {} numbers known to 1 %: most by {} ({:+.5})", rows.len(), most.input, most.change);
    put("input data", Some(size), Some(noise.sqrt()), "assumed", note);
}

/// T3 of a figure.
pub(super) fn times(f: &Figure, study: &Study) -> Vec<Time3> {
    let (value, error) = (f.value.unwrap_or(f64::NAN), f.error.unwrap_or(f64::NAN));
    let mut targets: Vec<(String, f64)> =
        [10.0, 3.0, 1.0, 0.3, 0.1].iter().map(|p| (format!("{p}%"), p * 0.01 * value.abs())).collect();
    if f.unit == "%" {
        targets.push(("0.1".to_owned(), 0.1));
    }
    let name = f
        .wavelength_nm
        .filter(|_| study.scene.wavelengths.len() > 1)
        .map_or(f.name.clone(), |nm| format!("{}@{nm}", f.name));
    // Floors: biases of the scene's own settings that are told from 0.
    let floors: Vec<&Setting4> = ["memory", "patches", "wavelength grid"]
        .iter()
        .filter_map(|k| own_bias(study, k, &f.title()).filter(|b| b.1).map(|b| b.0))
        .collect();
    let floor = floors.iter().map(|r| r.bias * r.bias).sum::<f64>().sqrt();
    let row = |(target, wanted): (String, f64)| {
        let target = format!("{name}:{target}");
        let left = wanted * wanted - floor * floor;
        if left <= 0.0 {
            return Time3 {
                figure: f.title(),
                target,
                wanted,
                histories: None,
                cpu_seconds: None,
                low: None,
                high: None,
                note: never(study, &floors, floor, wanted),
            };
        }
        let times = error * error / left;
        // A variance known with ν degrees of freedom: ± 2 √(2/ν).
        let band = 2.0 * (2.0 / f.dof.unwrap_or(31.0).max(2.0)).sqrt();
        let cpu = study.base.cpu * times;
        Time3 {
            figure: f.title(),
            target,
            wanted,
            histories: Some((study.base.result.histories as f64 * times).ceil() as u64),
            cpu_seconds: Some(cpu),
            low: Some(cpu / (1.0 + band)),
            high: Some(cpu * (1.0 + band)),
            note: if floor > 0.0 { format!("bias {floor:.5} counted in") } else { String::new() },
        }
    };
    targets.into_iter().map(row).collect()
}

/// Why a target is out of reach, and the cheapest setting that reaches it.
fn never(study: &Study, floors: &[&Setting4], floor: f64, wanted: f64) -> String {
    let worst = floors.iter().max_by(|a, b| a.bias.abs().total_cmp(&b.bias.abs()));
    let Some(worst) = worst else { return String::new() };
    let mut text = format!("never: floor is {floor:.5} by {} {}", worst.knob, worst.setting);
    let others = study.settings.iter().filter(|s| {
        s.knob == worst.knob
            && s.figure == worst.figure
            && s.setting != worst.setting
            && (s.bias.abs() <= 2.0 * s.bias_error || s.bias.abs() < wanted)
    });
    let price = |s: &&Setting4| s.error * s.error * s.cpu_seconds / (wanted * wanted);
    if let Some(better) = others.min_by(|a, b| price(a).total_cmp(&price(b))) {
        text += &format!("; {} {} instead, estimated {:.3} s", better.knob, better.setting, price(&better));
    }
    text
}
