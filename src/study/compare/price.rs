//! What each universe costs: time, and so not the same bytes twice. And the variance between realisations.

use super::{Options, Point, Ran, margin_of, verdict};
use crate::stats::student_quantile;
use serde::{Deserialize, Serialize};

/// Price of a figure in one universe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Price {
    /// Universe.
    pub universe: String,
    /// Figure.
    pub figure: String,
    /// Wavelength, nm.
    pub wavelength_nm: Option<f64>,
    /// Histories per wavelength group.
    pub histories: u64,
    /// Processor seconds of the whole run.
    pub cpu_seconds: f64,
    /// Standard error that it gave.
    pub error: f64,
    /// Times the processor time of the reference for the same standard error.
    pub times_reference: f64,
    /// Error (bias and noise) that the next column is for.
    pub wanted: f64,
    /// Processor seconds to reach it; empty: never.
    pub cpu_to_wanted: Option<f64>,
    /// Why never, or what to know.
    pub note: String,
}

/// Prices of every figure, of spectra at the middle wavelength. The bias of a universe is its difference
/// from the reference where that is shown (p < .01), else taken as 0.
pub fn prices(ran: &[Ran], reference: usize, options: &Options) -> Vec<Price> {
    let base = &ran[reference];
    let middle = base.scene.wavelengths[base.scene.wavelengths.len() / 2];
    let priced = |p: &&Point| match p.at {
        None => true,
        Some((axis, x)) => axis == super::Axis::Wavelength && x == middle,
    };
    let mut out = Vec::new();
    for own in ran {
        for p in own.points.iter().filter(priced) {
            let same = |q: &&Point| q.figure == p.figure && q.at == p.at;
            let Some(r) = base.points.iter().find(same) else { continue };
            // A share of the figure's margin as the wanted reflectance error is of that of reflectances.
            let wanted = margin_of(p, r.value, options.margin) * options.error / options.margin;
            let row = verdict::row(&own.name, p, &base.points, options.margin);
            let shown = row.filter(|_| own.name != base.name).filter(|row| row.p_difference < 0.01);
            let bias = shown.as_ref().map_or(0.0, |r| r.difference);
            let noise = p.error * p.error * own.cpu;
            let (cpu_to_wanted, note) = match shown {
                Some(row) if bias.abs() >= wanted => {
                    let t = student_quantile(0.975, row.dof.unwrap_or(f64::INFINITY));
                    let floor = format!("never: floor is {:+.5} ± {:.5}", bias, t * row.difference_error);
                    (None, floor)
                }
                Some(_) => {
                    (Some(noise / (wanted * wanted - bias * bias)), format!("bias {bias:+.5} counted in"))
                }
                None => (Some(noise / (wanted * wanted)), String::new()),
            };
            out.push(Price {
                universe: own.name.clone(),
                figure: p.figure.clone(),
                wavelength_nm: p.at.map(|a| a.1),
                histories: own.result.histories,
                cpu_seconds: own.cpu,
                error: p.error,
                times_reference: noise / (r.error * r.error * base.cpu),
                wanted,
                cpu_to_wanted,
                note,
            });
        }
    }
    out
}

/// Variance between realisations against the noise of histories.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Universe.
    pub universe: String,
    /// Reflectance or transmittance.
    pub figure: String,
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Realisations.
    pub realisations: u64,
    /// Histories in each.
    pub histories_each: u64,
    /// Standard deviation between realisations, and its error.
    pub between: f64,
    /// Error of `between`.
    pub between_error: f64,
    /// Part of the mean's standard error that is due to the realisations drawn.
    pub error_of_realisations: f64,
    /// Part that is due to the histories.
    pub error_of_histories: f64,
}

/// Spreads of one universe; none where every history has a realisation of its own, or there are none.
pub fn spreads(ran: &Ran) -> Vec<Spread> {
    let mut out = Vec::new();
    for f in &ran.result.figures {
        let Some(of) = f.name.strip_suffix("_between_realisations") else { continue };
        let whole = ran.result.figures.iter().find(|g| g.name == of && g.wavelength_nm == f.wavelength_nm);
        let (Some(between), Some(error)) = (f.value, whole.and_then(|w| w.error)) else { continue };
        let each = ran.scene.run.shared;
        let realisations = ran.result.histories / each;
        let of_realisations = (between / (realisations as f64).sqrt()).min(error);
        out.push(Spread {
            universe: ran.name.clone(),
            figure: of.to_owned(),
            wavelength_nm: f.wavelength_nm.unwrap_or(f64::NAN),
            realisations,
            histories_each: each,
            between,
            between_error: f.error.unwrap_or(f64::NAN),
            error_of_realisations: of_realisations,
            error_of_histories: (error * error - of_realisations * of_realisations).max(0.0).sqrt(),
        });
    }
    out
}
