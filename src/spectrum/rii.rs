//! Reader for files of the refractiveindex.info database (YAML).

use super::{Dispersion, Formula, Spectrum, SpectrumError, Table};
use serde::Deserialize;
use serde_saphyr::Spanned;

#[derive(Deserialize)]
struct Document {
    #[serde(rename = "DATA")]
    data: Vec<Spanned<Block>>,
}

#[derive(Deserialize)]
struct Block {
    #[serde(rename = "type")]
    kind: String,
    /// First and last wavelength, µm; `range` in older files.
    #[serde(alias = "range")]
    wavelength_range: Option<String>,
    coefficients: Option<String>,
    data: Option<Spanned<String>>,
}

/// Reads a file of the refractiveindex.info database: n(λ) and, where the file has it, κ(λ), which
/// may come from one block (`tabulated nk`) or from two (a formula and `tabulated k`). Wavelengths
/// are µm in the file, nm here. Some published tables are not sorted or give a wavelength twice:
/// rows are sorted, values at the same wavelength averaged. κ without n is refused.
///
/// # Errors
/// [`SpectrumError::Text`] with the line of what cannot be read, [`SpectrumError::Invalid`] where n
/// is missing or given twice.
pub fn read(text: &str, name: &str) -> Result<(Spectrum, Option<Spectrum>), SpectrumError> {
    let document: Document = serde_saphyr::from_str(text).map_err(|e| yaml_error(&e, name))?;
    let (mut n, mut k) = (None, None);
    for block in &document.data {
        let line = usize::try_from(block.referenced.line()).unwrap_or(0);
        let (new_n, new_k) = read_block(&block.value, name, line, text)?;
        for (slot, new, letter) in [(&mut n, new_n, 'n'), (&mut k, new_k, 'k')] {
            if slot.is_some() && new.is_some() {
                return Err(SpectrumError::text(name, line, 1, format!("{letter} is given twice")));
            }
            *slot = slot.take().or(new);
        }
    }
    let n = n.ok_or_else(|| SpectrumError::invalid(name, "the file gives no refractive index n"))?;
    Ok((n, k))
}

type Pair = (Option<Spectrum>, Option<Spectrum>);

fn read_block(block: &Block, name: &str, line: usize, text: &str) -> Result<Pair, SpectrumError> {
    let wrong = |what: String| SpectrumError::text(name, line, 1, what);
    let missing = |what: &str| wrong(format!("a block '{}' needs '{what}'", block.kind));
    let mut words = block.kind.split_whitespace();
    match (words.next(), words.next()) {
        (Some("tabulated"), Some(columns @ ("n" | "k" | "nk"))) => {
            let data = block.data.as_ref().ok_or_else(|| missing("data"))?;
            let mut tables = tabulated(data, columns, name, text)?.into_iter().map(Spectrum::from);
            let first = tables.next();
            Ok(if columns == "k" { (None, first) } else { (first, tables.next()) })
        }
        (Some("formula"), Some(number)) => {
            let kind = number.parse().ok().and_then(Dispersion::from_number);
            let kind = kind.ok_or_else(|| wrong(format!("'{number}' is no formula from 1 to 9")))?;
            let numbers = |what: &str, t: &Option<String>| -> Result<Vec<f64>, SpectrumError> {
                let t = t.as_ref().ok_or_else(|| missing(what))?;
                t.split_whitespace().map(|w| number_of(w).ok_or_else(|| wrong(no_number(w)))).collect()
            };
            let coefficients = numbers("coefficients", &block.coefficients)?;
            let range = numbers("wavelength_range", &block.wavelength_range)?;
            let [low, high] = range[..] else {
                return Err(wrong("wavelength_range has two numbers".into()));
            };
            let formula = Formula::new(name, kind, &coefficients, (low * 1000.0, high * 1000.0));
            Ok((Some(formula.map_err(|e| wrong(bare(e)))?.into()), None))
        }
        _ => Err(wrong(format!("unknown type '{}'", block.kind))),
    }
}

/// The one or two tables of a `data` text.
fn tabulated(
    data: &Spanned<String>,
    columns: &str,
    name: &str,
    text: &str,
) -> Result<Vec<Table>, SpectrumError> {
    let first_line = first_content_line(data, text);
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for (i, row) in data.value.lines().enumerate() {
        let wrong = |what: String| SpectrumError::text(name, first_line + i, 1, what);
        let numbers = row
            .split_whitespace()
            .map(|w| number_of(w).ok_or_else(|| wrong(no_number(w))))
            .collect::<Result<Vec<_>, _>>()?;
        if numbers.is_empty() {
            continue;
        }
        if numbers.len() != columns.len() + 1 {
            return Err(wrong(format!("{} numbers where {} belong", numbers.len(), columns.len() + 1)));
        }
        if numbers[0] <= 0.0 {
            return Err(wrong(format!("{} µm is no wavelength", numbers[0])));
        }
        rows.push(numbers);
    }
    rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let groups: Vec<&[Vec<f64>]> = rows.chunk_by(|a, b| a[0] == b[0]).collect();
    let nm: Vec<f64> = groups.iter().map(|g| g[0][0] * 1000.0).collect();
    (1..=columns.len())
        .map(|c| {
            let mean = |g: &&[Vec<f64>]| g.iter().map(|r| r[c]).sum::<f64>() / g.len() as f64;
            Table::new(name, nm.clone(), groups.iter().map(mean).collect::<Vec<_>>())
        })
        .collect()
}

/// Line of the first row of a block scalar: the reader reports the line of its `|` or of its
/// content, so look at the text.
fn first_content_line(data: &Spanned<String>, text: &str) -> usize {
    let line = usize::try_from(data.referenced.line()).unwrap_or(0);
    let holds_indicator = text.lines().nth(line.saturating_sub(1)).is_some_and(|l| l.contains("data:"));
    line + usize::from(holds_indicator)
}

fn number_of(word: &str) -> Option<f64> {
    word.parse::<f64>().ok().filter(|x| x.is_finite())
}

fn no_number(word: &str) -> String {
    format!("'{word}' is no finite number")
}

/// The message without the name of the file, which stands before the place.
fn bare(error: SpectrumError) -> String {
    match error {
        SpectrumError::Invalid { what, .. } => what,
        other => other.to_string(),
    }
}

fn yaml_error(error: &serde_saphyr::Error, name: &str) -> SpectrumError {
    let what = error.without_snippet().to_string();
    let place = |x: u64| usize::try_from(x).unwrap_or(0);
    match error.location() {
        Some(at) => SpectrumError::text(name, place(at.line()), place(at.column()), what),
        None => SpectrumError::invalid(name, what),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn n_by_a_formula_and_k_by_a_table() {
        let text = "REFERENCES: |\n  x\nDATA:\n  - type: formula 5\n    wavelength_range: 0.4 0.7\n    \
                    coefficients: 1.5\n  - type: tabulated k\n    data: |\n        0.4 1e-3\n        0.6 3e-3\n";
        let (n, k) = read(text, "glass").unwrap();
        assert_eq!((n.at(500.0).unwrap(), n.range()), (1.5, Some((400.0, 700.0))));
        assert_eq!(k.unwrap().at(500.0).unwrap(), 2e-3);
    }

    #[test]
    fn unsorted_rows_are_sorted_and_equal_wavelengths_averaged() {
        let text = "DATA:\n  - type: tabulated nk\n    data: |\n      0.5 1.5 0.1\n      0.4 1.4 0.2\n      0.5 1.7 0.3\n";
        let (n, k) = read(text, "t").unwrap();
        assert_eq!((n.at(400.0).unwrap(), n.at(500.0).unwrap()), (1.4, 1.6));
        assert_eq!(k.unwrap().at(500.0).unwrap(), 0.2);
    }

    #[test]
    fn refusals_name_the_line() {
        for (text, message) in [
            (
                "DATA:\n  - type: tabulated n\n    data: |\n      0.4 1.4\n      0.5 x\n",
                "t:5:1: 'x' is no finite number",
            ),
            (
                "DATA:\n  - type: tabulated nk\n    data: |\n      0.4 1.4\n",
                "t:4:1: 2 numbers where 3 belong",
            ),
            (
                "DATA:\n  - type: tabulated k\n    data: |\n      0.4 1.4\n",
                "t: the file gives no refractive index n",
            ),
            (
                "DATA:\n  - type: tabulated n\n    data: |\n      0.4 1\n  - type: tabulated n\n    data: |\n      0.4 1\n",
                "t:5:1: n is given twice",
            ),
            ("DATA:\n  - type: formula 12\n    coefficients: 1\n", "t:2:1: '12' is no formula from 1 to 9"),
            (
                "DATA:\n  - type: formula 1\n    coefficients: 1 2 3\n",
                "t:2:1: a block 'formula 1' needs 'wavelength_range'",
            ),
            (
                "DATA:\n  - type: formula 1\n    coefficients: 1 2\n    wavelength_range: 0.4 0.7\n",
                "t:2:1: 2 coefficients do not fit the formula Sellmeier",
            ),
            ("DATA:\n  - type: tabulated q\n", "t:2:1: unknown type 'tabulated q'"),
        ] {
            assert_eq!(read(text, "t").unwrap_err().to_string(), message, "{text}");
        }
        assert!(matches!(read("DATA: [", "t"), Err(SpectrumError::Text { line: 1, .. })));
        assert!(read("", "t").is_err());
        assert!(read("SPECS: 1", "t").is_err());
    }
}
