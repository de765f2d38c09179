//! Figures of sheets whose light changes its wavelength: bispectral factors, total radiance factors under
//! illuminants with and without their ultraviolet, whiteness.
//!
//! D(λ → λ′): power that comes out in the bin of λ′ over power that goes in in that of λ (the geometry of
//! `<optics>`, else all reflected power). Under an illuminant of relative power S the total radiance
//! factor is β_T(λ′) = Σ_λ S(λ) Δλ D(λ → λ′)/(S(λ′) Δλ′), the sum of the reflected one D(λ′ → λ′) and the
//! luminescent one. UV excluded means S = 0 below 420 nm; there the reflected factor stands.

use super::{Figure, Status};
use crate::material::conversion::widths;
use crate::optics::figures::{Measured, PaperWeights};
use crate::run::Outcome;
use crate::spectrum::cie::{Illuminant, illuminant};
use crate::stats::jackknife;
use crate::tally::Cell;

/// Wavelength (nm) below which light is cut off where UV is excluded.
const CUT: f64 = 420.0;

/// Illuminations: name, illuminant, and the wavelength below which there is no light.
const LIGHTS: [(&str, Illuminant, f64, &str); 3] = [
    ("D65", Illuminant::D65, 0.0, "d65_10"),
    ("C", Illuminant::C, 0.0, "c_2"),
    ("D65, UV excluded", Illuminant::D65, CUT, "d65_10"),
];

/// All figures of an outcome whose groups are wavelengths of excitation.
pub fn figures(outcome: &Outcome) -> Vec<Figure> {
    let Some(first) = outcome.groups.first().filter(|_| outcome.complete) else { return Vec::new() };
    let nm = first.wavelengths.clone();
    let n = nm.len();
    let power: Vec<Vec<f64>> = LIGHTS.iter().map(|l| spectrum(&nm, l)).collect();
    let paper = PaperWeights::new(&nm);
    let names = |name: &str, suffix: &str| {
        name == "brightness_r457"
            || name.starts_with("whiteness") && name.ends_with(suffix)
            || name.contains("_star_") && name.ends_with(suffix)
            || name.starts_with("tint") && name.ends_with(suffix)
    };
    let colours = |beta: &[f64], suffix: &str| -> Vec<crate::optics::PaperFigure> {
        let all = paper.evaluate(Measured { r0: None, r_inf: Some(beta), grammage: None });
        all.into_iter().filter(|f| names(&f.name, suffix)).collect()
    };
    let values = jackknife(&replicas(outcome), |d| {
        let mut out = d.to_vec();
        for (l, s) in LIGHTS.iter().zip(&power) {
            let beta = total(d, s, n);
            out.extend(colours(&beta, l.3).iter().map(|f| *f.value.as_ref().unwrap_or(&f64::NAN)));
            out.extend(beta);
        }
        out
    });
    let few = outcome.groups.iter().any(|g| g.node.batches < 10);
    let trust = |f: Figure| {
        let doubtful = few && f.status == Status::Ok;
        if doubtful { f.with_status(Status::Unreliable).with_note("fewer than 10 batches") } else { f }
    };
    let mut out = Vec::new();
    let mut at = n * n;
    let mean: Vec<f64> = values[..at].iter().map(|v| v.0).collect();
    for (l, s) in LIGHTS.iter().zip(&power) {
        for f in colours(&total(&mean, s, n), l.3) {
            out.push(trust(Figure::of_paper(&f, values[at].1).of_component(l.0)));
            at += 1;
        }
        for &x in &nm {
            let (value, error) = values[at];
            let f = Figure::new("total_radiance_factor", value, error, "1");
            out.push(trust(f.at_wavelength(x).of_component(l.0)));
            at += 1;
        }
    }
    for (i, from) in nm.iter().enumerate() {
        for (j, to) in nm.iter().enumerate() {
            let (value, error) = values[i * n + j];
            if i == j || value != 0.0 {
                let f = Figure::new("bispectral_factor", value, error, "1");
                out.push(trust(f.at_wavelength(*to).of_component(&format!("excited at {from} nm"))));
            }
        }
    }
    out
}

/// Power of an illuminant in the bins.
fn spectrum(nm: &[f64], (_, which, cut, _): &(&str, Illuminant, f64, &str)) -> Vec<f64> {
    let table = illuminant(*which);
    let of = |(x, w): (&f64, f64)| if *x < *cut { 0.0 } else { w * table.at(*x).unwrap_or(0.0) };
    nm.iter().zip(widths(nm)).map(of).collect()
}

/// Total radiance factors from the bispectral factors `d` (row: excitation).
fn total(d: &[f64], power: &[f64], n: usize) -> Vec<f64> {
    (0..n)
        .map(|j| {
            if power[j] == 0.0 {
                return d[j * n + j];
            }
            (0..n).map(|i| power[i] * d[i * n + j]).sum::<f64>() / power[j]
        })
        .collect()
}

/// Per replica: histories and sums of the bispectral factors.
fn replicas(outcome: &Outcome) -> Vec<(u64, Vec<f64>)> {
    let first = &outcome.groups[0];
    let levels = first.layout.pile_levels();
    (first.node.replicas.iter())
        .map(|(key, (count, _))| {
            let mut sums = Vec::new();
            for group in &outcome.groups {
                let layout = &group.layout;
                let cells: Vec<usize> = if levels > 0 {
                    let start = layout.pile_cell(0);
                    (start..start + levels).collect()
                } else {
                    vec![layout.of(Cell::Reflected)]
                };
                let have = &group.node.replicas[key].1;
                for lane in 0..group.wavelengths.len() {
                    sums.push(cells.iter().map(|c| have[c * layout.lanes + lane]).sum());
                }
            }
            (*count, sums)
        })
        .collect()
}
