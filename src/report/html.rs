//! `report.html`: one file that holds everything and opens offline. Plots are plain SVG; a small script of
//! its own moves the polar plot with the sliders.

use super::directions::Directions;
use super::plot::{Curve, LedgerBar, LinePlot, Plot};
use super::result::Status;
use super::text::with_error;
use super::{Figure, Manifest, RunResult, depth, folder, instruments, view};
use crate::math::pow;
use crate::run::Outcome;
use crate::scene::Scene;
use crate::scene::plan::Plan;
use quick_xml::escape::escape;
use std::fmt::Write as _;

/// One run of a report; several make a sweep.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// What sets it apart, e.g. "45 deg"; empty for a single run.
    pub label: &'a str,
    /// The scene.
    pub scene: &'a Scene,
    /// Sums.
    pub outcome: &'a Outcome,
    /// Figures.
    pub result: &'a RunResult,
}

/// A report to be written.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// Runs; the first one is shown in full.
    pub parts: &'a [Part<'a>],
    /// Plan of the first.
    pub plan: &'a Plan,
    /// How to repeat it.
    pub manifest: &'a Manifest,
    /// What a sweep changes: its name and values, and the unit.
    pub sweep: Option<(&'a str, &'a [f64], &'a str)>,
    /// Tables of studies and comparisons: title and CSV.
    pub tables: &'a [(String, String)],
}

impl Report<'_> {
    /// The page.
    pub fn page(&self) -> String {
        let Some(first) = self.parts.first() else { return String::new() };
        let mut body = String::new();
        self.heading(first, &mut body);
        if let Some(sweep) = self.sweep {
            self.sweep_section(sweep, &mut body);
        }
        figures(first.result, &mut body);
        colours(first.result, &mut body);
        let data = self.directions(&mut body);
        self.plots(first, &mut body);
        for (title, csv) in self.tables {
            let _ = write!(body, "<h2>{}</h2>{}", escape(title), csv_table(csv));
        }
        effects(first.result, &mut body);
        if let Some((svg, caption)) = view::svg(first.scene, self.plan) {
            let _ = writeln!(
                body,
                "<h2 id=\"sheet\">The sheet and the light in it</h2>\n<figure class=\"wide\">{svg}<figcaption>{}</figcaption></figure>",
                escape(&caption)
            );
        }
        self.understood(first, &mut body);
        let title = escape(&first.scene.name);
        let (style, script) = (include_str!("html/style.css"), include_str!("html/script.js"));
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n<style>\n{style}</style>\n</head>\n\
             <body>\n{body}\n<script type=\"application/json\" id=\"data\">{data}</script>\n\
             <script>\n{script}</script>\n</body>\n</html>\n"
        )
    }

    fn heading(&self, first: &Part, body: &mut String) {
        let r = first.result;
        let state = if r.complete { "" } else { " · stopped before its end" };
        let several = match self.sweep {
            Some((name, values, _)) => format!(" · {} runs over {}", values.len(), escape(name)),
            None => String::new(),
        };
        let _ = writeln!(
            body,
            "<h1>{}</h1>\n<p class=\"lead\">LightPro {} · {} histories for each of {} wavelength group(s), seed {}\
             {several}{state}. “±” is one standard error.</p>",
            escape(&first.scene.name),
            escape(&r.lightpro),
            r.histories,
            first.outcome.groups.len(),
            self.manifest.seed
        );
    }

    /// Data of the polar plots, and their place; `null` where no directions were counted.
    fn directions(&self, body: &mut String) -> String {
        let Some(first) = self.parts.first() else { return "null".into() };
        let of = |p: &Part| p.outcome.groups.first().and_then(|g| Directions::leaving(p.scene, g));
        let Some(patches) = of(first) else { return "null".into() };
        let wavelengths: Vec<f64> = first.outcome.wavelengths().map(|w| w.0).collect();
        // At most some 2e5 values, so that the file stays below 2 MB.
        let room = 200_000 / (patches.patches.len() * self.parts.len()).max(1);
        let shown: Vec<usize> = thinned(wavelengths.len(), room.clamp(1, 64));
        let cut = in_cut(&patches);
        let mut runs = Vec::new();
        for part in self.parts {
            let Some(own) = of(part).filter(|d| d.patches.len() == patches.patches.len()) else { continue };
            let all: Vec<_> = part.outcome.wavelengths().collect();
            let (mut powers, mut errors) = (Vec::new(), Vec::new());
            for &i in &shown {
                let Some((_, group, lane)) = all.get(i) else { continue };
                let values = own.powers(group, *lane);
                powers.push(list(values.iter().map(|v| v.0)));
                errors.push(list(cut.iter().map(|&i| values[i].1)));
            }
            let incidence = own.incidence_deg.map_or("null".into(), |x| format!("{x:.3}"));
            let label = if part.label.is_empty() { "this run" } else { part.label };
            runs.push(format!(
                "{{\"label\":{},\"incidence\":{incidence},\"powers\":[{}],\"errors\":[{}]}}",
                serde_json::to_string(label).unwrap_or_default(),
                powers.join(","),
                errors.join(",")
            ));
        }
        let geometry: Vec<String> = patches
            .patches
            .iter()
            .map(|p| {
                let outline: Vec<String> =
                    p.outline.iter().step_by(3).map(|(a, b)| format!("{a:.1},{b:.1}")).collect();
                format!(
                    "[{:.3},{:.2},{:.5},{:.6},[{}]]",
                    p.polar_deg,
                    p.azimuth_deg,
                    p.area,
                    p.projected,
                    outline.join(",")
                )
            })
            .collect();
        self.controls(shown.len(), runs.len(), body);
        format!(
            "{{\"wavelengths\":{},\"cut\":{:?},\"patches\":[{}],\"runs\":[{}]}}",
            list(shown.iter().map(|&i| wavelengths[i])),
            cut,
            geometry.join(","),
            runs.join(",")
        )
    }

    fn controls(&self, wavelengths: usize, runs: usize, body: &mut String) {
        let what = self.sweep.map_or("incidence", |s| s.0);
        let hidden = |n: usize| if n < 2 { " disabled" } else { "" };
        let _ = writeln!(
            body,
            "<h2 id=\"directions\">Where the light goes</h2>\n<div class=\"controls\">\
             <label>wavelength <input type=\"range\" id=\"wavelength\" min=\"0\" max=\"{}\" value=\"{}\" step=\"1\"{}>\
             <output id=\"wavelength-out\"></output></label>\
             <label{}>{} <input type=\"range\" id=\"run\" min=\"0\" max=\"{}\" value=\"0\" step=\"1\"{}>\
             <output id=\"run-out\"></output></label>\
             <label>shown <select id=\"quantity\"><option value=\"intensity\">radiant intensity</option>\
             <option value=\"factor\">radiance factor</option></select></label></div>\n\
             <div class=\"grid\"><figure><svg class=\"live\" id=\"polar\" role=\"img\" \
             aria-label=\"polar plot\"></svg><figcaption>Plane of incidence; dots are patches, bars one standard \
             error. One scale for all positions of the sliders.</figcaption></figure>\
             <figure><svg class=\"live\" id=\"map\" viewBox=\"0 0 540 330\" role=\"img\" \
             aria-label=\"hemisphere map\"></svg><figcaption>Whole hemispheres, equal areas; azimuth 0° (mirror \
             direction) to the right.</figcaption></figure></div>",
            wavelengths.saturating_sub(1),
            wavelengths / 2,
            hidden(wavelengths),
            if runs < 2 { " hidden" } else { "" },
            escape(what),
            runs.saturating_sub(1),
            hidden(runs)
        );
    }

    /// Spectra, depth profiles, detectors, ledger.
    fn plots(&self, first: &Part, body: &mut String) {
        let mut figures: Vec<(String, String)> = Vec::new();
        if first.scene.wavelengths.len() > 1 {
            let curves = folder::spectral_curves(first.result).1;
            let plot = super::plot::spectra("Spectra", ("share of the incident power", "1"), &curves);
            figures.push(("Bands are ± one standard error.".into(), inline(&plot)));
        }
        for (what, _, plot) in depth::plots(self.plan, first.outcome) {
            figures.push((format!("{what}, ± one standard error."), inline(&plot)));
        }
        for t in instruments::tables(first.outcome) {
            let svg = svg_only(&t.svg(&first.scene.name));
            figures.push((format!("{}.csv holds all wavelengths.", t.stem), svg));
        }
        let ledger = LedgerBar { title: "Where the light went", ledger: &first.result.ledger }.plot();
        figures.push(("Mean over wavelengths; all of the emitted power.".into(), inline(&ledger)));
        body.push_str("<h2>Spectra, profiles, ledger</h2>\n<div class=\"grid\">\n");
        for (caption, svg) in figures {
            let _ = writeln!(body, "<figure>{svg}<figcaption>{}</figcaption></figure>", escape(&caption));
        }
        body.push_str("</div>\n");
    }

    /// Plan, scene and what repeats the run.
    fn understood(&self, first: &Part, body: &mut String) {
        let m = self.manifest;
        let _ = writeln!(body, "<h2>Plan</h2>\n<pre>{}</pre>", escape(self.plan.to_string()));
        let _ = writeln!(
            body,
            "<h2>Scene as understood</h2>\n<details><summary>All values, defaults filled in</summary><pre>{}</pre>\
             </details>",
            escape(beginning(&serde_json::to_string_pretty(&m.scene).unwrap_or_default()))
        );
        if let Ok(text) = std::fs::read_to_string(&first.scene.path) {
            let _ = writeln!(
                body,
                "<details><summary>The scene file</summary><pre>{}</pre></details>",
                escape(beginning(&text))
            );
        }
        let mut rows = vec![
            ("version", m.lightpro.clone()),
            ("seed", m.seed.to_string()),
            ("histories", first.result.histories.to_string()),
        ];
        // By name: where the files stand may differ from one machine to the next.
        let name = |path: &str| path.rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
        rows.extend(m.files.iter().map(|f| ("file", format!("{} ({})", name(&f.path), f.hash))));
        body.push_str(
            "<h2>To repeat it</h2>\n<p>Same scene, seed, histories and version give the same bytes of this page and of \
             all tables on any number of threads. <code>manifest.json</code> beside it tells the command as typed, \
             machine and times.</p>\n<table>",
        );
        for (what, value) in rows {
            let _ = write!(body, "<tr><th>{what}</th><td>{}</td></tr>", escape(&value));
        }
        body.push_str("</table>\n");
    }

    /// Table and plots of the broad-band figures (or those of the middle wavelength) over a sweep.
    fn sweep_section(&self, (name, values, unit): (&str, &[f64], &str), body: &mut String) {
        let results: Vec<&RunResult> = self.parts.iter().map(|p| p.result).collect();
        let _ = writeln!(body, "<h2>Sweep of {}</h2>\n<div class=\"grid\">", escape(name));
        for (label, unit_y, points) in sweep_curves(&results, values).into_iter().take(8) {
            let curve = Curve { label: label.clone(), points };
            let svg = LinePlot {
                title: &label,
                x: (name, if unit.is_empty() { "1" } else { unit }),
                y: (&label, &unit_y),
                curves: &[curve],
                dots: true,
            }
            .svg();
            let _ = writeln!(body, "<figure>{}</figure>", svg_only(&svg));
        }
        body.push_str("</div>\n");
        let _ = writeln!(body, "{}", csv_table(&sweep_csv(name, &results, values)));
        let _ = writeln!(
            body,
            "<p class=\"lead\">What follows is the first run, {} = {}.</p>",
            escape(name),
            self.parts[0].label
        );
    }
}

/// A figure over a sweep: label, unit, (value of the sweep, value, standard error).
pub type SweepCurve = (String, String, Vec<(f64, f64, f64)>);

/// Figures worth a curve over a sweep: (label, unit, points); of spectra the middle wavelength.
pub fn sweep_curves(results: &[&RunResult], values: &[f64]) -> Vec<SweepCurve> {
    let Some(first) = results.first() else { return Vec::new() };
    let wavelengths: Vec<f64> = first.figures.iter().filter_map(|f| f.wavelength_nm).collect();
    let middle = wavelengths.get(wavelengths.len() / 2).copied();
    let mut out = Vec::new();
    for f in &first.figures {
        if f.value.is_none() || f.wavelength_nm.is_some() && f.wavelength_nm != middle {
            continue;
        }
        let same = |g: &&Figure| {
            g.name == f.name && g.component == f.component && g.wavelength_nm == f.wavelength_nm
        };
        let points: Vec<(f64, f64, f64)> = results
            .iter()
            .zip(values)
            .filter_map(|(r, x)| {
                let g = r.figures.iter().find(same)?;
                Some((*x, g.value?, g.error.unwrap_or(f64::NAN)))
            })
            .collect();
        let mut label = f.name.clone();
        label += &f.component.as_ref().map_or(String::new(), |c| format!(" [{c}]"));
        label += &f.wavelength_nm.map_or(String::new(), |nm| format!(" at {nm} nm"));
        out.push((label, f.unit.clone(), points));
    }
    out
}

/// One row a value of the sweep, two columns a figure: value and standard error.
pub fn sweep_csv(name: &str, results: &[&RunResult], values: &[f64]) -> String {
    let curves = sweep_curves(results, values);
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    let mut head = vec![name.to_owned()];
    for (label, unit, _) in &curves {
        head.push(if unit == "1" { label.clone() } else { format!("{label} ({unit})") });
        head.push(format!("error of {label}"));
    }
    let _ = writer.write_record(&head);
    for x in values {
        let mut row = vec![x.to_string()];
        for (_, _, points) in &curves {
            let p = points.iter().find(|p| p.0 == *x);
            row.push(p.map_or(String::new(), |p| p.1.to_string()));
            row.push(p.filter(|p| p.2.is_finite()).map_or(String::new(), |p| p.2.to_string()));
        }
        let _ = writer.write_record(&row);
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// A text for the page: of one with thousands of bodies the beginning.
fn beginning(text: &str) -> std::borrow::Cow<'_, str> {
    const MOST: usize = 200_000;
    if text.len() <= MOST {
        return text.into();
    }
    let end = (0..=MOST).rfind(|&i| text.is_char_boundary(i)).unwrap_or(0);
    format!("{}\n… cut here: {} of {} bytes", &text[..end], end, text.len()).into()
}

/// At most `room` of `n` indices, evenly spread, first and last among them.
fn thinned(n: usize, room: usize) -> Vec<usize> {
    if n <= room {
        return (0..n).collect();
    }
    let mut out: Vec<usize> =
        (0..room).map(|i| if room == 1 { n / 2 } else { i * (n - 1) / (room - 1) }).collect();
    out.dedup();
    out
}

/// Patches of the plane of incidence, by the rule of `plot::in_plane`.
fn in_cut(d: &Directions) -> Vec<usize> {
    let near = |p: &super::directions::PatchGeometry| {
        let rad = crate::math::PI / 180.0;
        let off = crate::math::sin(p.polar_deg * rad) * crate::math::sin(p.azimuth_deg * rad);
        off.abs() <= (0.5 * p.area).sqrt()
    };
    (0..d.patches.len()).filter(|&i| near(&d.patches[i])).collect()
}

/// A JSON list, four significant digits.
fn list(values: impl Iterator<Item = f64>) -> String {
    let digits = |v: f64| {
        if v == 0.0 || !v.is_finite() {
            "0".to_owned()
        } else if (0.001..1e5).contains(&v.abs()) {
            let text = format!("{v:.6}");
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            format!("{v:.3e}")
        }
    };
    format!("[{}]", values.map(digits).collect::<Vec<_>>().join(","))
}

fn inline(plot: &Plot) -> String {
    svg_only(&plot.svg)
}

/// The SVG element alone, to stand in a page.
fn svg_only(svg: &str) -> String {
    let start = svg.find("<svg").unwrap_or(0);
    let svg = svg[start..].replacen("<svg", "<svg class=\"plot\"", 1);
    // The page has a dark mode of its own.
    match (svg.find("<style>"), svg.find("</style>")) {
        (Some(from), Some(to)) => format!("{}{}", &svg[..from], &svg[to + "</style>".len()..]),
        _ => svg,
    }
}

fn figures(result: &RunResult, body: &mut String) {
    let row = |f: &Figure| {
        let mut name = escape(&f.name).into_owned();
        if let Some(c) = &f.component {
            name += &format!(" [{}]", escape(c));
        }
        let value = f.value.map_or_else(|| "–".to_owned(), |v| with_error(v, f.error));
        let bound = if f.status == Status::UpperBound { "&lt; " } else { "" };
        let nm = f.wavelength_nm.map_or(String::new(), |x| x.to_string());
        let unit = if f.unit == "1" { "" } else { &f.unit };
        let status = match f.status {
            Status::Ok => "",
            Status::Unreliable => "unreliable",
            Status::UpperBound => "upper bound",
            Status::NotAvailable => "not available",
        };
        let note = f.note.as_deref().unwrap_or("");
        let note = note.strip_prefix("not available: ").unwrap_or(note);
        let sep = if status.is_empty() || note.is_empty() { "" } else { ": " };
        format!(
            "<tr><td>{name}</td><td class=\"n\">{nm}</td><td class=\"n\">{bound}{value}</td><td>{}</td><td>{status}{sep}{}\
             </td></tr>\n",
            escape(unit),
            escape(note)
        )
    };
    let head = "<tr><th>figure</th><th class=\"n\">nm</th><th class=\"n\">value</th><th>unit</th><th>remark</th></tr>";
    let table = |rows: &[&Figure]| {
        format!(
            "<div class=\"scroll\"><table>{head}\n{}</table></div>\n",
            rows.iter().map(|f| row(f)).collect::<String>()
        )
    };
    let (spectral, whole): (Vec<&Figure>, Vec<&Figure>) =
        result.figures.iter().partition(|f| f.wavelength_nm.is_some());
    body.push_str("<h2>Figures</h2>\n");
    if !whole.is_empty() {
        body.push_str(&table(&whole));
    }
    if spectral.len() <= 12 {
        body.push_str(&table(&spectral));
    } else {
        let _ = writeln!(
            body,
            "<details><summary>{} figures by wavelength</summary>{}</details>",
            spectral.len(),
            table(&spectral)
        );
    }
}

/// Colour of the opaque pad as a screen shows it, for each condition.
fn colours(result: &RunResult, body: &mut String) {
    let names = [("d65_10", "D65, 10°"), ("c_2", "C, 2°"), ("d50_2", "D50, 2°")];
    let mut out = String::new();
    for (suffix, name) in names {
        let of =
            |star: &str| result.figure(&format!("{star}_star_{suffix}"), None).map(|f| (f.value, f.error));
        let (Some((Some(l), dl)), Some((Some(a), da)), Some((Some(b), db))) = (of("l"), of("a"), of("b"))
        else {
            continue;
        };
        let (r, g, blue) = screen_colour(l, a, b);
        let _ = write!(
            out,
            "<div><i style=\"background:rgb({r},{g},{blue})\"></i>{name}<br>L* {}<br>a* {}<br>b* {}</div>",
            with_error(l, dl),
            with_error(a, da),
            with_error(b, db)
        );
    }
    if !out.is_empty() {
        let _ = writeln!(body, "<h2>Colour of the opaque pad</h2>\n<div class=\"patches\">{out}</div>");
    }
}

/// sRGB of L*a*b*, its white shown as the screen's white (D65).
fn screen_colour(l: f64, a: f64, b: f64) -> (u8, u8, u8) {
    let fy = (l + 16.0) / 116.0;
    let inverse = |t: f64| {
        const KNEE: f64 = 6.0 / 29.0;
        if t > KNEE { t * t * t } else { 3.0 * KNEE * KNEE * (t - 4.0 / 29.0) }
    };
    let (x, y, z) = (0.950_47 * inverse(fy + a / 500.0), inverse(fy), 1.088_83 * inverse(fy - b / 200.0));
    let shown = |v: f64| {
        let v = v.clamp(0.0, 1.0);
        let v = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * pow(v, 1.0 / 2.4) - 0.055 };
        (255.0 * v).round() as u8
    };
    (
        shown(3.240_97 * x - 1.537_383 * y - 0.498_611 * z),
        shown(-0.969_244 * x + 1.875_968 * y + 0.041_555 * z),
        shown(0.055_63 * x - 0.203_977 * y + 1.056_972 * z),
    )
}

fn effects(result: &RunResult, body: &mut String) {
    body.push_str("<h2>Effects</h2>\n<table><tr><th>effect</th><th></th><th>why</th></tr>\n");
    for (name, e) in &result.effects.0 {
        let (class, word) = if e.on { ("", "on") } else { (" class=\"off\"", "off") };
        let _ = writeln!(
            body,
            "<tr{class}><td>{}</td><td>{word}</td><td>{}</td></tr>",
            escape(name),
            escape(&e.why)
        );
    }
    body.push_str("</table>\n");
}

/// Columns of a table that fit a printed page.
const COLUMNS: usize = 9;

/// A CSV text as a table; a wide one as several, each with the first column.
fn csv_table(text: &str) -> String {
    let mut reader =
        ::csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(text.as_bytes());
    let records: Vec<::csv::StringRecord> = reader.records().flatten().collect();
    let wide = records.iter().map(::csv::StringRecord::len).max().unwrap_or(0);
    let step = if wide <= COLUMNS { COLUMNS } else { COLUMNS - 1 };
    let mut out = String::new();
    for from in (1..wide.max(2)).step_by(step) {
        out.push_str("<div class=\"scroll\"><table>");
        for (i, record) in records.iter().enumerate() {
            out.push_str("<tr>");
            for cell in record.iter().take(1).chain(record.iter().skip(from).take(step)) {
                let number = cell.parse::<f64>();
                let shown = match number {
                    Ok(x) if cell.len() > 8 => format!("{x:.6}"),
                    _ => escape(cell).into_owned(),
                };
                let tag = if i == 0 { "th" } else { "td" };
                let class = if i > 0 && number.is_ok() { " class=\"n\"" } else { "" };
                let _ = write!(out, "<{tag}{class}>{shown}</{tag}>");
            }
            out.push_str("</tr>\n");
        }
        out.push_str("</table></div>\n");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_and_grey_are_shown_as_such() {
        assert_eq!(screen_colour(100.0, 0.0, 0.0), (255, 255, 255));
        assert_eq!(screen_colour(0.0, 0.0, 0.0), (0, 0, 0));
        let (r, g, b) = screen_colour(53.585, 0.0, 0.0);
        assert!(r == g && g == b && r.abs_diff(128) <= 1, "{r} {g} {b}");
        let (r, g, b) = screen_colour(53.24, 80.09, 67.20);
        assert!(r >= 254 && g <= 2 && b <= 2, "the red primary: {r} {g} {b}");
    }

    /// Every value of a wide table stands in it, in tables of at most [`COLUMNS`] columns.
    #[test]
    fn wide_tables_are_cut() {
        let row = |c: char| (0..20).map(|i| format!("{c}{i}")).collect::<Vec<_>>().join(",");
        let html = csv_table(&format!("{}\n{}\n", row('h'), row('v')));
        assert!((0..20).all(|i| html.contains(&format!("<th>h{i}</th>")) && html.contains(&format!("<td>v{i}</td>"))));
        assert_eq!(html.matches("<table>").count(), 3);
        assert!(html.split("</tr>").all(|r| r.matches("<td>").count() <= COLUMNS));
        assert_eq!(csv_table("a,b\n1,2\n").matches("<table>").count(), 1);
    }

    #[test]
    fn numbers_are_short_and_wavelengths_thinned() {
        assert_eq!(list([0.0, 0.5, 1.25e-7, 400.0].into_iter()), "[0,0.5,1.250e-7,400]");
        assert_eq!(thinned(5, 8), [0, 1, 2, 3, 4]);
        assert_eq!(thinned(31, 4), [0, 10, 20, 30]);
    }
}
