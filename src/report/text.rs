//! The table of figures that a run ends with on the terminal.

use super::result::{Figure, Status};
use crate::math::{log10, pow};

/// `value ± error` with two significant digits of the error: "0.73120 ± 0.00040". Without an
/// error, six significant digits of the value; very large and very small numbers in exponents.
pub fn with_error(value: f64, error: Option<f64>) -> String {
    let Some(error) = error.filter(|e| e.is_finite() && *e > 0.0) else {
        let decimals = (5 - magnitude(value)).clamp(0, 12) as usize;
        let outside = value != 0.0 && !(-5..7).contains(&magnitude(value));
        return if outside { format!("{value:.5e}") } else { format!("{value:.decimals$}") };
    };
    let largest = magnitude(value).max(magnitude(error));
    if (-4..7).contains(&largest) {
        let decimals = (1 - magnitude(error)).clamp(0, 15) as usize;
        format!("{value:.decimals$} ± {error:.decimals$}")
    } else {
        let decimals = (largest - magnitude(error) + 1).clamp(0, 15) as usize;
        let scale = pow(10.0, f64::from(largest));
        format!("({:.decimals$} ± {:.decimals$})e{largest}", value / scale, error / scale)
    }
}

/// A number with `n` significant digits; very large and very small ones in exponents.
pub fn digits(value: f64, n: usize) -> String {
    let places = n.max(1) - 1;
    if value != 0.0 && value.is_finite() && !(-5..7).contains(&magnitude(value)) {
        return format!("{value:.places$e}");
    }
    let decimals = (places as i32 - magnitude(value)).clamp(0, 15) as usize;
    format!("{value:.decimals$}")
}

/// Decimal exponent of the first digit; 0 for 0.
fn magnitude(x: f64) -> i32 {
    if x == 0.0 || !x.is_finite() { 0 } else { log10(x.abs()).floor() as i32 }
}

/// One line a figure: what, value ± error, unit, and status and note where there is something to
/// say. Columns are aligned; the unit 1 is left blank.
pub fn figures(figures: &[Figure]) -> String {
    let rows: Vec<[String; 4]> = figures
        .iter()
        .map(|f| {
            let value = f.value.map_or_else(|| "–".to_owned(), |v| with_error(v, f.error));
            let bound = if f.status == Status::UpperBound { "< " } else { "" };
            let mut remark = match f.status {
                Status::Unreliable => "unreliable".to_owned(),
                Status::UpperBound => "upper bound".to_owned(),
                Status::Ok | Status::NotAvailable => String::new(),
            };
            if let Some(note) = &f.note {
                remark += if remark.is_empty() { "" } else { "; " };
                remark += note;
            }
            let unit = if f.unit == "1" { String::new() } else { f.unit.clone() };
            [f.title(), format!("{bound}{value}"), unit, remark]
        })
        .collect();
    let width = |c: usize| rows.iter().map(|r| r[c].chars().count()).max().unwrap_or(0);
    let (a, b, c) = (width(0), width(1), width(2));
    rows.iter()
        .map(|[what, value, unit, remark]| {
            let line = format!("  {what:<a$}  {value:>b$}  {unit:<c$}  {remark}");
            format!("{}\n", line.trim_end())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_show_the_digits_that_their_errors_allow() {
        for (value, error, text) in [
            (0.7312, Some(0.0004), "0.73120 ± 0.00040"),
            (84.236, Some(1.3), "84.2 ± 1.3"),
            (1234.0, Some(120.0), "1234 ± 120"),
            (3.2e-9, Some(1.5e-10), "(3.20 ± 0.15)e-9"),
            (0.5, None, "0.500000"),
            (100.0, Some(0.0), "100.000"),
            (0.0, None, "0.00000"),
            (4.5e-8, None, "4.50000e-8"),
        ] {
            assert_eq!(with_error(value, error), text);
        }
    }

    #[test]
    fn the_table_is_aligned_and_says_what_is_missing() {
        let text = figures(&[
            Figure::new("reflectance", 0.7312, 0.0004, "1").at_wavelength(550.0),
            Figure::new("s", 35.2, 0.4, "m2/kg"),
            Figure::new("absorptance", 1e-4, 0.0, "1").of_component("wall").with_status(Status::UpperBound),
            Figure::new("opacity", f64::NAN, 0.0, "%").with_note("not available: needs 400–700 nm"),
        ]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "  reflectance at 550 nm  0.73120 ± 0.00040");
        assert_eq!(lines[1], "  s                           35.20 ± 0.40  m2/kg");
        assert_eq!(lines[2], "  absorptance [wall]         < 0.000100000         upper bound");
        assert_eq!(
            lines[3],
            "  opacity                                –  %      not available: needs 400–700 nm"
        );
    }
}
