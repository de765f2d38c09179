//! Figures F1 to F9, each with the numbers behind it.

use super::{Setting4, Study};
use crate::math::{ln, log10, pow};
use crate::report::csv::table;
use crate::report::plot::{Bar, BarPlot, Curve, LinePlot, Plot};
use crate::stats::student_quantile;
use serde::Serialize;

/// A point of a plot, for its CSV.
#[derive(Serialize)]
struct Value<'a> {
    series: &'a str,
    x: f64,
    y: f64,
    error: f64,
}

fn lines(title: &str, x: (&str, &str), y: (&str, &str), curves: &[Curve], dots: bool) -> Plot {
    let rows: Vec<Value> = curves
        .iter()
        .flat_map(|c| c.points.iter().map(|&(x, y, error)| Value { series: &c.label, x, y, error }))
        .collect();
    Plot { svg: LinePlot { title, x, y, curves, dots }.svg(), csv: table(&rows) }
}

fn curve(label: &str, points: Vec<(f64, f64, f64)>) -> Curve {
    Curve { label: label.to_owned(), points }
}

/// Bias that is told from 0 (two errors), else 0.
fn bias(s: &Setting4) -> f64 {
    if s.bias.abs() > 2.0 * s.bias_error { s.bias.abs() } else { 0.0 }
}

/// √(bias² + noise²) after `t` processor seconds, with the biases of the scene's own settings of the other
/// knobs.
fn rmse(settings: &[&Setting4], s: &Setting4, t: f64) -> f64 {
    let others = settings.iter().filter(|o| o.knob != s.knob && o.mark.starts_with("own"));
    let rest: f64 = others.map(|o| bias(o) * bias(o)).sum();
    (bias(s) * bias(s) + rest + s.error * s.error * s.cpu_seconds / t).sqrt()
}

/// All figures that the study has data for: file stem and plot.
pub fn all(study: &Study) -> Vec<(&'static str, Plot)> {
    let Some(first) = study.results.first().map(|r| r.figure.clone()) else { return Vec::new() };
    let settings: Vec<&Setting4> = study.settings.iter().filter(|s| s.figure == first).collect();
    let mut out = vec![("f5_mean", mean(study)), ("f5_vov", vov(study)), ("f5_fom", merit(study))];
    if !settings.is_empty() {
        out.insert(0, ("f1_error_time", error_time(study, &settings, &first)));
        out.insert(1, ("f2_pareto", pareto(&settings, &first)));
    }
    out.extend(convergence(&settings).map(|p| ("f3_convergence", p)));
    out.extend(budget(study, &first).map(|p| ("f4_budget", p)));
    out.extend(tail(study).map(|p| ("f6_tail", p)));
    if study.effects.iter().any(|e| e.times.is_some()) {
        out.push(("f7_effects", effects(study)));
    }
    out.push(("f7_phases", phases(study)));
    if !study.threads.is_empty() {
        out.push(("f8_threads", speed(study)));
    }
    let memory: Vec<&Setting4> = settings.iter().copied().filter(|s| s.knob == "memory").collect();
    if !memory.is_empty() {
        out.push(("f9_rungs", rungs(&memory, &first)));
    }
    out
}

fn error_time(study: &Study, settings: &[&Setting4], figure: &str) -> Plot {
    let own = study.base.cpu;
    let model = |s: &Setting4| {
        let at = |i: i32| {
            let t = own * pow(10.0, -1.5 + 0.25 * f64::from(i));
            (log10(t), log10(rmse(settings, s, t)), 0.0)
        };
        curve(&format!("{} {}", s.knob, s.setting), (0..=20).map(at).collect())
    };
    let knob = settings.iter().find(|s| s.knob == "memory").or(settings.first()).map(|s| s.knob.clone());
    let mut curves: Vec<Curve> =
        settings.iter().filter(|s| Some(&s.knob) == knob.as_ref()).map(|s| model(s)).collect();
    let measured = study.steps.iter().map(|s| (log10(s.cpu_seconds), log10(s.error), 0.0)).collect();
    curves.push(curve("this run, noise", measured));
    let title = format!("F1 Error (bias and noise) of {figure} against time");
    lines(&title, ("log₁₀ processor time", "s"), ("log₁₀ error", "1"), &curves, false)
}

fn pareto(settings: &[&Setting4], figure: &str) -> Plot {
    let mut all: Vec<(f64, f64, String)> = settings
        .iter()
        .map(|s| (s.cpu_seconds, rmse(settings, s, s.cpu_seconds), format!("{} {}", s.knob, s.setting)))
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best = f64::INFINITY;
    let mut front = Vec::new();
    for (t, e, _) in &all {
        if *e < best {
            best = *e;
            front.push((log10(*t), log10(*e), 0.0));
        }
    }
    let mut curves = vec![curve("front", front)];
    curves.extend(all.iter().map(|(t, e, label)| curve(label, vec![(log10(*t), log10(*e), 0.0)])));
    let title = format!("F2 Error (bias and noise) of {figure}, as run");
    lines(&title, ("log₁₀ processor time", "s"), ("log₁₀ error", "1"), &curves, true)
}

/// Value against h² of a knob with meshes.
fn convergence(settings: &[&Setting4]) -> Option<Plot> {
    // A mesh is what halves from one setting to the next.
    let first =
        settings.iter().find(|s| ["patches", "voxels", "wavelength grid"].contains(&s.knob.as_str()))?;
    let of: Vec<&&Setting4> = settings.iter().filter(|s| s.knob == first.knob).collect();
    let mut points: Vec<(f64, f64, f64)> = of.iter().map(|s| (s.h * s.h, s.value, s.error)).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut curves = vec![curve("value", points)];
    if let Some(r) = of.iter().find_map(|s| s.richardson) {
        curves.push(curve("extrapolated", vec![(0.0, r, 0.0)]));
    }
    let title = format!("F3 {} against mesh size squared", first.figure);
    let x = format!("h² of the {}", first.knob);
    Some(lines(&title, (&x, "1"), (&first.figure, "1"), &curves, true))
}

fn budget(study: &Study, figure: &str) -> Option<Plot> {
    let bars: Vec<Bar> = study
        .budget
        .iter()
        .filter(|s| s.figure == figure)
        .map(|s| Bar {
            label: format!("{} ({})", s.source, s.how),
            value: s.size.map_or(0.0, f64::abs),
            error: s.error.unwrap_or(0.0),
        })
        .collect();
    let title = format!("F4 Sources of error of {figure}");
    (!bars.is_empty()).then(|| BarPlot { title: &title, x: ("error", "1"), bars: &bars }.plot())
}

fn mean(study: &Study) -> Plot {
    let points = study.steps.iter().map(|s| (log10(s.histories as f64), s.mean, s.error)).collect();
    let curves = [curve("reflectance", points)];
    lines("F5 Running mean ± error", ("log₁₀ histories", "1"), ("reflectance", "1"), &curves, true)
}

fn vov(study: &Study) -> Plot {
    let points: Vec<_> = study
        .steps
        .iter()
        .filter(|s| s.vov > 0.0)
        .map(|s| (log10(s.histories as f64), log10(s.vov), 0.0))
        .collect();
    let guide: Vec<_> = match points.first() {
        Some(&(x, y, _)) => points.iter().map(|p| (p.0, y - (p.0 - x), 0.0)).collect(),
        None => Vec::new(),
    };
    let curves = [curve("VOV", points), curve("slope −1", guide)];
    lines("F5 Variance of the variance", ("log₁₀ histories", "1"), ("log₁₀ VOV", "1"), &curves, false)
}

fn merit(study: &Study) -> Plot {
    let points = study.steps.iter().map(|s| (log10(s.histories as f64), s.figure_of_merit, 0.0)).collect();
    let curves = [curve("figure of merit", points)];
    lines(
        "F5 Figure of merit: level in a sound run",
        ("log₁₀ histories", "1"),
        ("1/(relative error² · time)", "1/s"),
        &curves,
        true,
    )
}

/// Means of replicas in units of their spread, against the quantiles of a normal law.
fn tail(study: &Study) -> Option<Plot> {
    let n = study.replicas.len();
    if n < 4 {
        return None;
    }
    let mean = study.replicas.iter().sum::<f64>() / n as f64;
    let sd = (study.replicas.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1) as f64).sqrt();
    let mut z: Vec<f64> = study.replicas.iter().map(|x| (x - mean) / sd.max(f64::MIN_POSITIVE)).collect();
    z.sort_by(f64::total_cmp);
    let quantile = |i: usize| student_quantile((i as f64 + 0.625) / (n as f64 + 0.25), f64::INFINITY);
    let points: Vec<_> = z.iter().enumerate().map(|(i, z)| (quantile(i), *z, 0.0)).collect();
    let normal = points.iter().map(|p| (p.0, p.0, 0.0)).collect();
    let curves = [curve("replicas", points), curve("normal law", normal)];
    Some(lines(
        "F6 Tails: means of replicas against a normal law",
        ("normal quantile", "1"),
        ("deviation / spread", "1"),
        &curves,
        true,
    ))
}

fn effects(study: &Study) -> Plot {
    let bars: Vec<Bar> = study
        .effects
        .iter()
        .filter_map(|e| {
            let word = if e.on { "without" } else { "with" };
            Some(Bar { label: format!("{word} {}", e.effect), value: e.times?, error: 0.0 })
        })
        .collect();
    BarPlot { title: "F7 Time with an effect toggled", x: ("time over that of the plan", "1"), bars: &bars }
        .plot()
}

fn phases(study: &Study) -> Plot {
    let bar = |(label, value): (&str, f64)| Bar { label: label.to_owned(), value, error: 0.0 };
    let names = ["scene made ready", "light", "figures"];
    let bars: Vec<Bar> = names.into_iter().zip(study.phases).map(bar).collect();
    BarPlot { title: "F7 Time by phase", x: ("processor time", "s"), bars: &bars }.plot()
}

fn speed(study: &Study) -> Plot {
    let one = study.threads[0].1;
    let points: Vec<_> = study.threads.iter().map(|t| (t.0 as f64, one / t.1, 0.0)).collect();
    let ideal = study.threads.iter().map(|t| (t.0 as f64, t.0 as f64, 0.0)).collect();
    let same = study.threads.iter().all(|t| t.2);
    let title = if same {
        "F8 Speed against threads: byte-identical"
    } else {
        "F8 Speed against threads: BYTES DIFFER"
    };
    lines(
        title,
        ("threads", "1"),
        ("speed over one thread", "1"),
        &[curve("measured", points), curve("ideal", ideal)],
        true,
    )
}

fn rungs(memory: &[&Setting4], figure: &str) -> Plot {
    let wanted = 1e-3;
    let at = |s: &&Setting4| {
        let t = s.cpu_seconds * (s.error / wanted) * (s.error / wanted);
        let half = student_quantile(0.975, 31.0) * s.bias_error;
        curve(&format!("memory {}", s.setting), vec![(log10(t), s.bias, half)])
    };
    let curves: Vec<Curve> = memory.iter().map(at).collect();
    let title = format!("F9 {figure}: rungs and their price");
    lines(
        &title,
        ("log₁₀ processor time to ± 0.001", "s"),
        ("difference from exact, 95 %", "1"),
        &curves,
        true,
    )
}

/// Slope of log error against log time over the run: −1/2 in a sound one.
pub fn slope(study: &Study) -> Option<f64> {
    let points: Vec<(f64, f64)> =
        study.steps.iter().filter(|s| s.error > 0.0).map(|s| (ln(s.histories as f64), ln(s.error))).collect();
    let n = points.len() as f64;
    if points.len() < 3 {
        return None;
    }
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let sxy: f64 = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    let sxx: f64 = points.iter().map(|p| (p.0 - mx) * (p.0 - mx)).sum();
    Some(sxy / sxx)
}
