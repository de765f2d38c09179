//! T4: what every setting of a knob changes and costs, and T5: what effects do.

use super::*;

/// Every setting of a knob, with the seed of the scene: runs that draw alike are compared pair by pair.
pub(super) fn turn(
    knob: &Knob,
    figures: &[Figure],
    options: &Options,
    base: &Timed,
) -> Result<Vec<Setting4>, String> {
    let mut ran: Vec<(usize, Timed, u64)> = Vec::new();
    for (i, (_, _, scene)) in knob.settings.iter().enumerate() {
        if i == knob.own {
            ran.push((i, base.clone(), scene.run.histories));
            continue;
        }
        let mut scene = scene.clone();
        fit(&mut scene, options.each)?;
        ran.push((i, timed(&scene)?, scene.run.histories));
    }
    let reference = ran.iter().find(|r| r.0 == knob.reference).ok_or("no reference")?.1.clone();
    let mut out = Vec::new();
    for f in figures {
        let find = |t: &Timed| t.result.figures.iter().find(|g| g.is_of(f) && g.value.is_some()).cloned();
        let Some(r) = find(&reference) else { continue };
        let own_noise = f.error.map_or(f64::NAN, |e| e * e) * base.cpu;
        let mut rows = Vec::new();
        for (i, t, histories) in &ran {
            let Some(g) = find(t) else { continue };
            let (setting, h, _) = &knob.settings[*i];
            let (bias, bias_error) = difference(&reference, &r, t, &g);
            let error = g.error.unwrap_or(f64::NAN);
            rows.push(Setting4 {
                knob: knob.name.to_owned(),
                setting: setting.clone(),
                h: *h,
                figure: f.title(),
                value: g.value.unwrap_or(f64::NAN),
                error,
                bias,
                bias_error,
                histories: *histories,
                cpu_seconds: t.cpu,
                times_own: error * error * t.cpu / own_noise,
                order: None,
                richardson: None,
                mark: match (*i == knob.own, *i == knob.reference) {
                    (true, true) => "own, reference".to_owned(),
                    (true, false) => "own".to_owned(),
                    (false, true) => "reference".to_owned(),
                    _ => String::new(),
                },
            });
        }
        orders(&mut rows);
        recommend(&mut rows, wanted_of(f, options.wanted));
        out.extend(rows);
    }
    Ok(out)
}

/// Value less reference, and its error: from paired replicas where both have as many histories and draw the
/// same numbers, if that is the smaller error; else as of independent runs.
pub(super) fn difference(reference: &Timed, r: &Figure, t: &Timed, g: &Figure) -> (f64, f64) {
    let by = g.value.unwrap_or(f64::NAN) - r.value.unwrap_or(f64::NAN);
    if std::ptr::eq(reference, t) || by == 0.0 && r.error == g.error {
        return (0.0, 0.0);
    }
    let apart = (r.error.unwrap_or(0.0).powi(2) + g.error.unwrap_or(0.0).powi(2)).sqrt();
    let alike = reference.result.histories == t.result.histories;
    let changes = if alike { effects::changes(&reference.outcome, &t.outcome) } else { Vec::new() };
    let paired =
        changes.iter().find(|c| c.figure.name == g.name && c.figure.wavelength_nm == g.wavelength_nm);
    // Half the width of a 95 % interval of 31 degrees of freedom.
    let paired = paired.map(|c| 0.5 * (c.interval.1 - c.interval.0) / student_quantile(0.975, 31.0));
    (by, paired.map_or(apart, |p| p.min(apart)))
}

/// Observed order from three meshes h, h/2, h/4 whose differences are above their noise (two errors); second
/// order is extrapolated where the ratio per doubling is between 3 and 5 (exactly 4 for pure second order).
fn orders(rows: &mut [Setting4]) {
    for i in 2..rows.len() {
        let (a, b, c) = (&rows[i - 2], &rows[i - 1], &rows[i]);
        let halves = |x: f64, y: f64| y > 0.0 && (x / y - 2.0).abs() < 1e-9;
        if !(halves(a.h, b.h) && halves(b.h, c.h)) {
            continue;
        }
        let (first, second) = (a.value - b.value, b.value - c.value);
        let noise = |x: &Setting4, y: &Setting4| 2.0 * (x.error * x.error + y.error * y.error).sqrt();
        if first.abs() < noise(a, b) || second.abs() < noise(b, c) || first / second <= 0.0 {
            continue;
        }
        let ratio = first / second;
        let finest = c.value - second / 3.0;
        rows[i].order = Some(crate::math::ln(ratio) / crate::math::ln(2.0));
        rows[i].richardson = (3.0..=5.0).contains(&ratio).then_some(finest);
    }
}

/// Marks the setting that reaches the wanted error (bias and noise) in the least time: cost × noise over what
/// the bias leaves of it. A bias that is not told from 0 counts with its error.
fn recommend(rows: &mut [Setting4], wanted: f64) {
    let price = |r: &Setting4| {
        let bias = if r.bias.abs() > 2.0 * r.bias_error { r.bias.abs() } else { 0.0 };
        let left = wanted * wanted - bias * bias;
        if left > 0.0 { r.error * r.error * r.cpu_seconds / left } else { f64::INFINITY }
    };
    let best = (0..rows.len()).min_by(|a, b| price(&rows[*a]).total_cmp(&price(&rows[*b])));
    // Where nothing is gained (a tenth of the time), the scene stays as it is.
    let own = rows.iter().position(|r| r.mark.starts_with("own"));
    let best = match (best, own) {
        (Some(b), Some(o)) if price(&rows[o]) <= 1.1 * price(&rows[b]) => Some(o),
        _ => best,
    };
    if let Some(best) = best.filter(|b| price(&rows[*b]).is_finite()) {
        let before = std::mem::take(&mut rows[best].mark);
        rows[best].mark =
            if before.is_empty() { "recommended".into() } else { format!("{before}, recommended") };
    }
}

pub(super) fn toggled(scene: &Scene) -> Vec<Effect5> {
    let mut few = scene.clone();
    few.run.histories = (scene.run.histories / 4).max(scene.run.batch);
    let Ok(study) = effects::study(&few) else { return Vec::new() };
    let row = |t: &effects::Toggled| {
        let price = t.outcome.as_ref().ok();
        let largest = price.and_then(|p| p.changes.iter().max_by(|a, b| a.by.abs().total_cmp(&b.by.abs())));
        let called = crate::scene::effects::settle(scene).into_iter().find(|e| e.name == t.kind.name());
        Effect5 {
            effect: t.kind.name().to_owned(),
            on: t.on,
            times: price.map(|p| p.time),
            ns_per_event: price.map(|p| p.ns_per_event),
            events: price.map(|p| p.events),
            change: largest.map(|c| c.by),
            low95: largest.map(|c| c.interval.0),
            high95: largest.map(|c| c.interval.1),
            note: t.outcome.as_ref().err().cloned().or(called.map(|c| c.reason)).unwrap_or_default(),
        }
    };
    study.effects.iter().map(row).collect()
}
