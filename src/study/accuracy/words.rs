//! The study in words, as files, and the setting to paste.

use super::plots;
use super::{Setting4, Study};
use crate::report::csv::table;
use crate::report::text::{digits, with_error};
use serde::Serialize;
use std::fmt;

impl Study {
    /// The recommended settings as they are written in a scene, one line an element; only what differs from
    /// the scene is more than a reminder.
    pub fn snippet(&self) -> String {
        let Some(first) = self.results.first() else { return String::new() };
        let of = |knob: &str| {
            let mut rows = self.settings.iter().filter(|s| s.knob == knob && s.figure == first.figure);
            rows.find(|s| s.mark.contains("recommended"))
        };
        let mut lines = Vec::new();
        if let Some(s) = of("memory") {
            lines.push(format!("<universe kind=\"statistical\" memory=\"{}\">", s.setting));
        }
        if let Some(s) = of("patches") {
            lines.push(match s.h {
                0.0 => "<!-- no <sap>: the continuous law -->".to_owned(),
                _ => format!("<sap nside=\"{}\"/>", s.setting),
            });
        }
        if let Some(s) = of("wavelength grid") {
            lines.push(format!("<spectrum step=\"{}\"/>", s.setting));
        }
        if let Some(s) = of("voxels").filter(|s| s.setting != "1") {
            lines.push(format!("<volume coarser=\"{}\">", s.setting));
        }
        let mut run = String::from("<run");
        if let Some(s) = of("roulette") {
            run += &format!(" roulette=\"{}\"", s.setting);
        }
        match of("branching floor") {
            Some(s) if s.h == 0.0 => run += " branching=\"sample\"",
            Some(s) => run += &format!(" branching=\"split\" floor=\"{}\"", s.setting),
            None => {}
        }
        if let Some(n) = self
            .times
            .iter()
            .filter(|t| t.figure == first.figure && t.target.ends_with(":0.3%"))
            .find_map(|t| t.histories)
        {
            run += &format!(" histories=\"{n}\"");
        }
        lines.push(run + "/>");
        lines.join("\n")
    }

    /// Files of the study: name and content.
    pub fn files(&self) -> Vec<(String, String)> {
        #[derive(Serialize)]
        struct All<'a> {
            lightpro: &'static str,
            scene: &'a str,
            histories: u64,
            t1: &'a [super::Result1],
            t2: &'a [super::Source2],
            t2_inputs: &'a [super::Input2],
            t3: &'a [super::Time3],
            held_out: &'a Option<super::Held>,
            t4: &'a [Setting4],
            t5: &'a [super::Effect5],
            course: &'a [super::Step],
            phases: [f64; 3],
            threads: &'a [(u64, f64, bool)],
            recommended: String,
        }
        let all = All {
            lightpro: env!("CARGO_PKG_VERSION"),
            scene: &self.scene.name,
            histories: self.base.result.histories,
            t1: &self.results,
            t2: &self.budget,
            t2_inputs: &self.inputs,
            t3: &self.times,
            held_out: &self.held,
            t4: &self.settings,
            t5: &self.effects,
            course: &self.steps,
            phases: self.phases,
            threads: &self.threads,
            recommended: self.snippet(),
        };
        let json = serde_json::to_string_pretty(&all).expect("plain data is always JSON") + "\n";
        let held: Vec<_> = self.held.iter().collect();
        let mut out: Vec<(String, String)> = vec![
            ("accuracy.json".into(), json),
            ("accuracy.txt".into(), self.to_string()),
            ("t1_results.csv".into(), table(&self.results)),
            ("t2_budget.csv".into(), table(&self.budget)),
            ("t2_inputs.csv".into(), table(&self.inputs)),
            ("t3_times.csv".into(), table(&self.times)),
            ("t3_held_out.csv".into(), table(&held)),
            ("t4_settings.csv".into(), table(&self.settings)),
            ("t5_effects.csv".into(), table(&self.effects)),
            ("recommended.xml".into(), self.snippet() + "\n"),
        ];
        for (stem, plot) in plots::all(self) {
            out.push((format!("{stem}.svg"), plot.svg));
            out.push((format!("{stem}.csv"), plot.csv));
        }
        out
    }

    fn knob_lines(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\nT4 settings: bias against the reference, price of the same error over that of the scene's own"
        )?;
        for s in &self.settings {
            let mark = if s.mark.is_empty() { String::new() } else { format!("  [{}]", s.mark) };
            let order = s.order.map_or(String::new(), |o| format!("  order {o:.2}"));
            let extrapolated = s.richardson.map_or(String::new(), |r| format!("  extrapolated {r:.5}"));
            writeln!(
                f,
                "  {:<16} {:<16} {:<26} {:>22}  {:>24}  x{:<8}{order}{extrapolated}{mark}",
                s.knob,
                s.setting,
                s.figure,
                with_error(s.value, Some(s.error)),
                with_error(s.bias, Some(s.bias_error)),
                digits(s.times_own, 3)
            )?;
        }
        for (knob, why) in &self.refused {
            writeln!(f, "  {knob}: not tried: {why}")?;
        }
        Ok(())
    }
}

impl fmt::Display for Study {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "T1 results of {} histories of each wavelength group, {} s of processor",
            self.base.result.histories,
            digits(self.base.cpu, 3)
        )?;
        for r in &self.results {
            let vov = r.vov.map_or(String::new(), |v| format!("  VOV {}", digits(v, 2)));
            let skew = r.skewness.map_or(String::new(), |s| format!("  skewness {}", digits(s, 3)));
            writeln!(
                f,
                "  {:<28} {:>20}  95 %: {} to {}  relative {} %  FOM {} /s{vov}{skew}",
                r.figure,
                with_error(r.value, Some(r.error)),
                digits(r.low95, 6),
                digits(r.high95, 6),
                digits(100.0 * r.relative_error, 2),
                digits(r.figure_of_merit, 3)
            )?;
        }
        if let Some(slope) = plots::slope(self) {
            writeln!(f, "  slope of log error against log histories {slope:.3} (-0.5 in a sound run)")?;
        }
        if !self.budget.is_empty() {
            writeln!(f, "\nT2 sources of error, never merged")?;
        }
        for s in &self.budget {
            let size = s.size.map_or("?".to_owned(), |x| digits(x, 2));
            writeln!(f, "  {:<28} {:<18} {:>10}  {:<12} {}", s.figure, s.source, size, s.how, s.note)?;
        }
        for i in &self.inputs {
            let change = with_error(i.change, Some(i.error));
            writeln!(f, "  {:<28} + 1 %: {:<40} {change:>22}", i.figure, i.input)?;
        }
        if !self.times.is_empty() {
            writeln!(f, "\nT3 processor time to a target (95 % band)")?;
        }
        for t in &self.times {
            let time = t.cpu_seconds.zip(t.low.zip(t.high)).map_or(String::new(), |(s, (a, b))| {
                format!(
                    "{} s ({} to {}), {} histories ",
                    digits(s, 3),
                    digits(a, 3),
                    digits(b, 3),
                    t.histories.unwrap_or(0)
                )
            });
            writeln!(f, "  {:<34} {time}{}", t.target, t.note)?;
        }
        if let Some(h) = &self.held {
            writeln!(
                f,
                "  held out: {}: predicted {} s, measured {} s to the target, ratio {:.2}; error {} for {} wanted, z {:+.1}",
                h.target,
                digits(h.predicted_cpu, 3),
                digits(h.cpu_of_target, 3),
                h.ratio,
                digits(h.reached, 2),
                digits(h.wanted, 2),
                h.z
            )?;
        }
        self.knob_lines(f)?;
        if !self.effects.is_empty() {
            writeln!(
                f,
                "\nT5 effects toggled: time over that of the plan, ns per event, events a history, largest change of R or T"
            )?;
        }
        for e in &self.effects {
            let number = |x: Option<f64>, n: usize| x.map_or("-".to_owned(), |x| digits(x, n));
            writeln!(
                f,
                "  {:<26} {:<4} x{:<6} {:>8} {:>8} {:>10}  {}",
                e.effect,
                if e.on { "on" } else { "off" },
                number(e.times, 3),
                number(e.ns_per_event, 3),
                number(e.events, 3),
                number(e.change, 2),
                e.note
            )?;
        }
        for (n, seconds, same) in &self.threads {
            let bytes = if *same { "the same bytes" } else { "OTHER BYTES" };
            writeln!(f, "  {n} threads: {} s on the clock, {bytes}", digits(*seconds, 3))?;
        }
        write!(f, "\nrecommended\n{}", self.snippet())
    }
}
