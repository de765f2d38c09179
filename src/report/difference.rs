//! What tells two results apart: colour differences, and every figure that both have.

use super::csv::table;
use super::text::with_error;
use super::{Figure, RunResult};
use crate::optics::{Lab, Observer, delta_e_2000, delta_e_ab};
use serde::{Deserialize, Serialize};

/// One line of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DifferenceRow {
    /// Figure.
    pub name: String,
    /// Vacuum wavelength in nm.
    pub wavelength_nm: Option<f64>,
    /// Component.
    pub component: Option<String>,
    /// Value of the first result.
    pub first: Option<f64>,
    /// Value of the second.
    pub second: Option<f64>,
    /// Second less first; for colour differences ΔE itself.
    pub difference: f64,
    /// Standard error of the difference, the two results taken as independent.
    pub error: f64,
    /// Difference over its error.
    pub z: Option<f64>,
    /// Unit.
    pub unit: String,
    /// What a reader should know.
    pub note: Option<String>,
}

/// All figures that both results have with values and errors, colour differences first.
pub fn rows(first: &RunResult, second: &RunResult) -> Vec<DifferenceRow> {
    let mut out: Vec<DifferenceRow> =
        Observer::ALL.iter().flat_map(|o| colour(first, second, *o)).flatten().collect();
    for a in &first.figures {
        let same = |b: &&Figure| {
            b.name == a.name
                && b.wavelength_nm == a.wavelength_nm
                && b.component == a.component
                && b.polar_deg == a.polar_deg
        };
        let Some(b) = second.figures.iter().find(same) else { continue };
        let (Some(x), Some(y), Some(dx), Some(dy)) = (a.value, b.value, a.error, b.error) else { continue };
        let error = (dx * dx + dy * dy).sqrt();
        out.push(DifferenceRow {
            name: a.name.clone(),
            wavelength_nm: a.wavelength_nm,
            component: a.component.clone(),
            first: Some(x),
            second: Some(y),
            difference: y - x,
            error,
            z: (error > 0.0).then(|| (y - x) / error),
            unit: a.unit.clone(),
            note: None,
        });
    }
    out
}

/// L*, a*, b* and their errors.
fn lab(result: &RunResult, suffix: &str) -> Option<([f64; 3], [f64; 3])> {
    let mut out = ([0.0; 3], [0.0; 3]);
    for (i, name) in ["l_star", "a_star", "b_star"].iter().enumerate() {
        let f = result.figure(&format!("{name}_{suffix}"), None)?;
        (out.0[i], out.1[i]) = (f.value?, f.error?);
    }
    Some(out)
}

/// ΔE*ab and ΔE00 under one condition. Errors by the delta method; L*, a* and b* of one result come from
/// the same histories, with an unknown correlation, and their errors are added as if it were full (an
/// upper bound); the two results are independent.
fn colour(first: &RunResult, second: &RunResult, observer: Observer) -> [Option<DifferenceRow>; 2] {
    let suffix = observer.suffix();
    let (Some((a, da)), Some((b, db))) = (lab(first, suffix), lab(second, suffix)) else {
        return [None, None];
    };
    let of = |c: [f64; 3]| Lab { l: c[0], a: c[1], b: c[2] };
    let row = |name: &str, delta: fn(Lab, Lab) -> f64| {
        let value = delta(of(a), of(b));
        let slope = |which: usize, i: usize| {
            const STEP: f64 = 1e-3;
            let at = |h: f64| {
                let (mut a, mut b) = (a, b);
                if which == 0 {
                    a[i] += h
                } else {
                    b[i] += h
                }
                delta(of(a), of(b))
            };
            ((at(STEP) - at(-STEP)) / (2.0 * STEP)).abs()
        };
        let sum = |which: usize, d: [f64; 3]| (0..3).map(|i| slope(which, i) * d[i]).sum::<f64>();
        let error = (sum(0, da).powi(2) + sum(1, db).powi(2)).sqrt();
        // Near 0 the slope vanishes: a colour difference is never below the noise of its coordinates.
        let noise = da.iter().chain(&db).map(|d| d * d).sum::<f64>().sqrt();
        let note = (value < 2.0 * noise).then(|| {
            "not told apart from 0: the value is within twice the error of the coordinates".to_owned()
        });
        let error = if note.is_some() { error.max(noise) } else { error };
        DifferenceRow {
            name: format!("{name}_{suffix}"),
            wavelength_nm: None,
            component: None,
            first: None,
            second: None,
            difference: value,
            error,
            z: (error > 0.0).then(|| value / error),
            unit: "1".to_owned(),
            note,
        }
    };
    [Some(row("delta_e_ab", delta_e_ab)), Some(row("delta_e_00", delta_e_2000))]
}

/// CSV of the rows.
pub fn csv(rows: &[DifferenceRow]) -> String {
    table(rows)
}

/// The rows for a terminal; of spectra the first, middle and last wavelength.
pub fn text(rows: &[DifferenceRow]) -> String {
    let mut wavelengths: Vec<f64> = rows.iter().filter_map(|r| r.wavelength_nm).collect();
    wavelengths.sort_by(f64::total_cmp);
    wavelengths.dedup();
    let few = match wavelengths[..] {
        [] => Vec::new(),
        [first, .., last] => vec![first, wavelengths[wavelengths.len() / 2], last],
        [only] => vec![only],
    };
    let mut out = String::new();
    for r in rows.iter().filter(|r| r.wavelength_nm.is_none_or(|nm| few.contains(&nm))) {
        let mut what = r.name.clone();
        what += &r.component.as_ref().map_or(String::new(), |c| format!(" [{c}]"));
        what += &r.wavelength_nm.map_or(String::new(), |nm| format!(" at {nm} nm"));
        let unit = if r.unit == "1" { "" } else { &r.unit };
        let pair = match (r.first, r.second) {
            (Some(a), Some(b)) => format!("{a:.5} -> {b:.5}"),
            _ => String::new(),
        };
        let z = r.z.map_or(String::new(), |z| format!("z {z:+.1}"));
        let note = r.note.as_deref().unwrap_or("");
        let line = format!(
            "  {what:<38} {pair:>22}  {:>24} {unit:<6} {z:<9} {note}",
            with_error(r.difference, Some(r.error))
        );
        out += &format!("{}\n", line.trim_end());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Ordered;

    fn result(l: f64, error: f64) -> RunResult {
        let figures = [("l_star", l), ("a_star", 0.5), ("b_star", 2.0)]
            .iter()
            .map(|(n, v)| Figure::new(&format!("{n}_c_2"), *v, error, "1"))
            .chain([Figure::new("r0", 0.01 * l, 1e-3, "1").at_wavelength(550.0)])
            .collect();
        RunResult {
            lightpro: "0".into(),
            scene: "x".into(),
            complete: true,
            histories: 1,
            figures,
            ledger: Ordered::default(),
            effects: Ordered::default(),
            memory: None,
            voxels: None,
        }
    }

    #[test]
    fn a_step_of_lightness_is_its_own_difference() {
        let rows = rows(&result(94.0, 0.01), &result(95.0, 0.02));
        assert_eq!(rows[0].name, "delta_e_ab_c_2");
        assert!((rows[0].difference - 1.0).abs() < 1e-12);
        assert!((rows[0].error - 5e-4_f64.sqrt()).abs() < 1e-6, "{}", rows[0].error);
        assert!(rows[1].name == "delta_e_00_c_2" && rows[1].difference < 1.0);
        let r0 = rows.last().unwrap();
        assert!(
            (r0.difference - 0.01).abs() < 1e-12 && (r0.z.unwrap() - 0.01 / 2e-6_f64.sqrt()).abs() < 1e-6
        );
        assert!(text(&rows).contains("delta_e_00_c_2") && csv(&rows).starts_with("name,wavelength_nm"));
    }

    #[test]
    fn equal_colours_are_not_told_apart() {
        let rows = rows(&result(94.0, 0.01), &result(94.0, 0.01));
        assert!(rows[0].note.is_some() && rows[0].error > 0.02);
    }
}
