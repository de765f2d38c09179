//! Fluorescence and wavenumber shifts of a material.

use super::{Node, Reading, materials::short};
use crate::lpm::LANES;
use crate::material::Conversion;
use crate::math::exp;
use crate::scene::adapters;
use crate::scene::diagnostic::Diagnostic;
use crate::scene::model::ConversionKind;
use crate::spectrum::Spectrum;

/// Share of a band that may lie beyond the scene's wavelengths.
const BEYOND: f64 = 0.05;

impl Reading<'_> {
    pub fn conversions(&mut self, e: Node<'_>) -> Vec<(ConversionKind, Conversion)> {
        let mut out = Vec::new();
        for f in e.children("fluorescence") {
            if let Some(c) = self.fluorescence(f) {
                out.push((ConversionKind::Fluorescence, c));
            }
        }
        for s in e.children("shift") {
            out.extend(self.shift(s));
        }
        let places = e.children("fluorescence").chain(e.children("shift"));
        if let (Some(first), true) = (places.into_iter().next(), self.wavelengths.len() > LANES) {
            let (n, nm) = (self.wavelengths.len(), &self.wavelengths);
            let step = (nm[n - 1] - nm[0]) / (LANES - 1) as f64;
            let text = format!("events that change the wavelength take at most {LANES} wavelengths, not {n}");
            let d = Diagnostic::error(first.own.place, text);
            self.out.push(d.help(format!("a step of {step:.1} nm or more between the same ends")));
        }
        out
    }

    fn fluorescence(&mut self, e: Node<'_>) -> Option<Conversion> {
        let grid = self.wavelengths.clone();
        let rate = match e.one_of(self, &["absorption", "absorption-file"], Some("an absorption"))? {
            "absorption" => {
                let (most, peak) = (e.number("absorption"), e.needed(self, "peak", "`absorption`"));
                let (most, peak, sd) = (most?, peak?, e.number("width")?);
                grid.iter().map(|nm| most * gaussian(*nm, peak, sd)).collect()
            }
            _ => self.band(e, "absorption-file")?.0,
        };
        let (emission, inside) = match e.one_of(self, &["emission", "emission-file"], Some("an emission"))? {
            "emission" => {
                let (peak, sd) = (e.number("emission")?, e.number("emission-width")?);
                let share = |x: f64| crate::math::erf((x - peak) / (sd * std::f64::consts::SQRT_2));
                let w = crate::material::conversion::widths(&grid);
                let n = grid.len();
                let inside = 0.5 * (share(grid[n - 1] + 0.5 * w[n - 1]) - share(grid[0] - 0.5 * w[0]));
                (grid.iter().map(|nm| gaussian(*nm, peak, sd)).collect(), inside)
            }
            _ => self.band(e, "emission-file")?,
        };
        if inside < 1.0 - BEYOND || grid.len() < 2 {
            let d = Diagnostic::error(
                e.own.place,
                format!(
                    "{:.0} % of the emission lies beyond the scene's wavelengths",
                    100.0 * (1.0 - inside)
                ),
            );
            self.out.push(d.help("a <spectrum> that holds the bands of absorption and emission"));
            return None;
        }
        Some(Conversion::fluorescence(&grid, rate, &emission, e.number("quantum-yield")?))
    }

    /// A band from a file on the scene's wavelengths (0 outside the file), and the share of it in them.
    fn band(&mut self, e: Node<'_>, name: &str) -> Option<(Vec<f64>, f64)> {
        let a = e.attribute(name)?;
        let (path, text) = self.file(a)?;
        let name = short(&path);
        let found =
            adapters::spectrum_csv(&text, &name).map_err(|why| self.error(a.value_place, why)).ok()?;
        let at = |s: &Spectrum, nm: f64| s.at(nm).unwrap_or(0.0);
        let grid = self.wavelengths.clone();
        let values: Vec<f64> = grid.iter().map(|nm| at(&found, *nm)).collect();
        if let Some(bad) = values.iter().find(|v| **v < 0.0) {
            self.error(a.value_place, format!("{name}: {bad} is negative"));
            return None;
        }
        let (low, high) = adapters::range(&found).unwrap_or((grid[0], grid[grid.len() - 1]));
        const STEPS: usize = 2000;
        let (mut all, mut inside) = (0.0, 0.0);
        let w = crate::material::conversion::widths(&grid);
        let ends = (grid[0] - 0.5 * w[0], grid[grid.len() - 1] + 0.5 * w[grid.len() - 1]);
        for i in 0..STEPS {
            let nm = low + (high - low) * (i as f64 + 0.5) / STEPS as f64;
            let v = at(&found, nm);
            all += v;
            inside += if nm >= ends.0 && nm <= ends.1 { v } else { 0.0 };
        }
        Some((values, if all > 0.0 { inside / all } else { 0.0 }))
    }

    fn shift(&mut self, e: Node<'_>) -> Option<(ConversionKind, Conversion)> {
        let brillouin = e.text("kind") == Some("brillouin");
        let grid = self.wavelengths.clone();
        let (by, rate) = (e.number("by")?, e.number("rate")?);
        let kind = if brillouin { ConversionKind::Brillouin } else { ConversionKind::Raman };
        match Conversion::shifted(&grid, vec![rate; grid.len()], by, brillouin) {
            Ok(c) => Some((kind, c)),
            Err(step) => {
                let d = Diagnostic::error(e.place("by"), "the spectrum is too coarse for this shift");
                let step = if step < 0.1 { format!("{:.4} nm", step) } else { format!("{step:.2} nm") };
                self.out.push(d.help(format!("a <spectrum> with a step of at most {step} resolves it")));
                None
            }
        }
    }
}

fn gaussian(nm: f64, peak: f64, sd: f64) -> f64 {
    let x = (nm - peak) / sd;
    exp(-0.5 * x * x)
}
