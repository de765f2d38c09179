//! A comparison in words, and its curves.

use super::{Claim, Comparison, Point, Ran, Verdict};
use crate::report::plot::{Curve, LinePlot, Plot};
use crate::report::{csv, text::digits};
use serde::Serialize;
use std::fmt::{self, Write as _};

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reference = &self.ran[self.reference];
        writeln!(
            f,
            "reference: {} ({} histories of each wavelength group); margin {} in a reflectance, the others' beside \
             their figures;\nthe probability that any verdict is wrong is {} at most ({} claims, Holm)",
            reference.name,
            reference.result.histories,
            self.options.margin,
            super::LEVEL,
            self.claims.len()
        )?;
        for ran in self.ran.iter().filter(|r| r.name != reference.name) {
            writeln!(f, "\n{} against {} ({} histories)", ran.name, reference.name, ran.result.histories)?;
            let claims: Vec<&Claim> = self.claims.iter().filter(|c| c.universe == ran.name).collect();
            let width = claims.iter().map(|c| c.figure.chars().count()).max().unwrap_or(0);
            for c in claims {
                let curve = if c.points > 1 { format!(" ({} points)", c.points) } else { String::new() };
                writeln!(f, "  {:<width$}  {c}{curve}", c.figure)?;
            }
        }
        for (name, why) in &self.refused {
            writeln!(f, "\n{name}: not run: {why}")?;
        }
        self.spread_lines(f)
    }
}

impl Comparison {
    fn spread_lines(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut first = true;
        for s in &self.spreads {
            let middle = self.ran[self.reference].scene.wavelengths.clone();
            if s.wavelength_nm != middle[middle.len() / 2] {
                continue;
            }
            if std::mem::take(&mut first) {
                writeln!(f, "\nbetween realisations, as the beam sees them")?;
            }
            writeln!(
                f,
                "  {:<12} {:<14} at {} nm: sd {} ± {} over {} realisations of {} histories; of the error of the mean {} \
                 are theirs, {} the histories'",
                s.universe,
                s.figure,
                s.wavelength_nm,
                digits(s.between, 2),
                digits(s.between_error, 2),
                s.realisations,
                s.histories_each,
                digits(s.error_of_realisations, 2),
                digits(s.error_of_histories, 2)
            )?;
        }
        Ok(())
    }

    /// Prices of reflectance, transmittance, brightness and opacity in words: they differ from run to run.
    pub fn price_text(&self) -> String {
        let mut out = format!(
            "{:<14} {:<24} {:>10} {:>10} {:>9}  processor time to the wanted error (bias and noise)\n",
            "universe", "figure", "cpu s", "error", "x ref"
        );
        for p in self.prices.iter().filter(|p| {
            ["reflectance", "transmittance", "brightness_r457", "opacity"].contains(&p.figure.as_str())
        }) {
            let name = p.figure.clone() + &p.wavelength_nm.map_or(String::new(), |nm| format!(" {nm} nm"));
            let time = p
                .cpu_to_wanted
                .map_or(String::new(), |t| format!("{} s to ± {} ", digits(t, 3), digits(p.wanted, 2)));
            let _ = writeln!(
                out,
                "{:<14} {name:<24} {:>10} {:>10} {:>9}  {time}{}",
                p.universe,
                digits(p.cpu_seconds, 3),
                digits(p.error, 2),
                digits(p.times_reference, 3),
                if p.cpu_to_wanted.is_none() {
                    format!("{} (for ± {})", p.note, digits(p.wanted, 2))
                } else {
                    p.note.clone()
                }
            );
        }
        out
    }

    /// What is the same bytes for the same seed and histories: no times.
    pub fn json(&self) -> String {
        #[derive(Serialize)]
        struct Of<'a> {
            lightpro: &'static str,
            reference: &'a str,
            margin: f64,
            level: f64,
            universes: Vec<(&'a str, u64)>,
            refused: &'a [(String, String)],
            claims: &'a [Claim],
            values: &'a [super::Row],
            between_realisations: &'a [super::Spread],
        }
        let of = Of {
            lightpro: env!("CARGO_PKG_VERSION"),
            reference: &self.ran[self.reference].name,
            margin: self.options.margin,
            level: super::LEVEL,
            universes: self.ran.iter().map(|r| (r.name.as_str(), r.result.histories)).collect(),
            refused: &self.refused,
            claims: &self.claims,
            values: &self.rows,
            between_realisations: &self.spreads,
        };
        serde_json::to_string_pretty(&of).expect("plain data is always JSON") + "\n"
    }

    /// Curves of all universes with their bands, a plot each: file stem and plot.
    pub fn plots(&self) -> Vec<(String, Plot)> {
        let base = &self.ran[self.reference];
        let mut names: Vec<&str> = Vec::new();
        for p in base.points.iter().filter(|p| p.at.is_some()) {
            if !names.contains(&p.figure.as_str()) {
                names.push(&p.figure);
            }
        }
        names.into_iter().filter_map(|name| self.plot(name)).collect()
    }

    fn plot(&self, figure: &str) -> Option<(String, Plot)> {
        let of =
            |r: &Ran| -> Vec<Point> { r.points.iter().filter(|p| p.figure == figure).cloned().collect() };
        let first = of(&self.ran[self.reference]);
        if first.len() < 2 {
            return None;
        }
        let (axis, unit) = (first[0].at?.0, first[0].unit.clone());
        let curve = |r: &Ran| Curve {
            label: r.name.clone(),
            points: of(r).iter().filter_map(|p| Some((p.at?.1, p.value, p.error))).collect(),
        };
        let curves: Vec<Curve> = self.ran.iter().map(curve).filter(|c| !c.points.is_empty()).collect();
        #[derive(Serialize)]
        struct Value<'a> {
            universe: &'a str,
            at: f64,
            value: f64,
            error: f64,
        }
        let rows: Vec<Value> = curves
            .iter()
            .flat_map(|c| {
                c.points.iter().map(|&(at, value, error)| Value { universe: &c.label, at, value, error })
            })
            .collect();
        let verdict =
            |v: Verdict| self.claims.iter().filter(|c| c.figure == figure && c.verdict == v).count();
        let title = format!(
            "{figure}: {} agree, {} differ, {} open",
            verdict(Verdict::Agree),
            verdict(Verdict::Differ),
            verdict(Verdict::Open)
        );
        let svg =
            LinePlot { title: &title, x: axis.words(), y: (figure, &unit), curves: &curves, dots: true }
                .svg();
        let stem: String =
            figure.chars().map(|c| if c.is_alphanumeric() || c == '_' { c } else { '-' }).collect();
        Some((format!("compare_{}", stem.trim_end_matches('-')), Plot { svg, csv: csv::table(&rows) }))
    }
}
