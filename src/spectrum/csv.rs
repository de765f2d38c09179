//! Reader for spectra as text: two columns `wavelength_nm,value`.

use super::{SpectrumError, Table};

/// One row of numbers with its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<const N: usize> {
    /// Line, from 1.
    pub line: usize,
    /// Character at which each number starts, from 1.
    pub columns: [usize; N],
    /// The numbers, all finite.
    pub values: [f64; N],
}

/// Reads a spectrum: two columns, vacuum wavelength (nm) and value, separated by a comma; with a
/// header line or without; empty lines and what follows `#` are skipped. `name` stands in messages.
///
/// # Errors
/// [`SpectrumError::Text`] with line and column of a field that is missing, too much or no finite
/// number, and of a wavelength that is not greater than the one before.
pub fn read(text: &str, name: &str) -> Result<Table, SpectrumError> {
    let rows = rows::<2>(text, name)?;
    ascending(&rows, name)?;
    Table::new(
        name,
        rows.iter().map(|r| r.values[0]).collect::<Vec<_>>(),
        rows.iter().map(|r| r.values[1]).collect::<Vec<_>>(),
    )
}

/// All rows of a text with `N` columns of numbers; header and comments as in [`read`].
///
/// # Errors
/// [`SpectrumError::Text`] as in [`read`]; [`SpectrumError::Invalid`] if there is no row.
pub fn rows<const N: usize>(text: &str, name: &str) -> Result<Vec<Row<N>>, SpectrumError> {
    let mut rows = Vec::new();
    let mut first = true;
    for (i, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let content = line.split('#').next().unwrap_or_default();
        if content.trim().is_empty() {
            continue;
        }
        let is_header = first && content.split(',').all(|f| f.trim().parse::<f64>().is_err());
        first = false;
        if !is_header {
            rows.push(row(content, name, i + 1)?);
        }
    }
    if rows.is_empty() {
        return Err(SpectrumError::invalid(name, "the table has no rows"));
    }
    Ok(rows)
}

fn row<const N: usize>(content: &str, name: &str, line: usize) -> Result<Row<N>, SpectrumError> {
    let (mut columns, mut values) = ([0; N], [0.0; N]);
    let (mut count, mut start) = (0, 1);
    for field in content.split(',') {
        let column = start + field.chars().take_while(|c| c.is_whitespace()).count();
        start += field.chars().count() + 1;
        let wrong = |what: String| Err(SpectrumError::text(name, line, column, what));
        if count == N {
            return wrong(format!("a row has {N} numbers"));
        }
        match field.trim().parse::<f64>() {
            Ok(x) if x.is_finite() => (columns[count], values[count]) = (column, x),
            _ => return wrong(format!("'{}' is no finite number", field.trim())),
        }
        count += 1;
    }
    if count < N {
        let column = content.trim_end().chars().count() + 1;
        return Err(SpectrumError::text(name, line, column, format!("{count} of {N} numbers in this row")));
    }
    Ok(Row { line, columns, values })
}

/// Checks that the first column holds positive, strictly ascending wavelengths.
pub(crate) fn ascending<const N: usize>(rows: &[Row<N>], name: &str) -> Result<(), SpectrumError> {
    let mut before = 0.0;
    for r in rows {
        let nm = r.values[0];
        if nm <= before {
            let what = match (nm > 0.0, nm == before) {
                (false, _) => format!("{nm} nm is no wavelength"),
                (true, true) => format!("{nm} nm stands here twice"),
                (true, false) => format!("wavelengths must ascend: {nm} nm follows {before} nm"),
            };
            return Err(SpectrumError::text(name, r.line, r.columns[0], what));
        }
        before = nm;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_header_without_header_with_comments() {
        let t = read("# dye\r\nwavelength_nm,value\r\n400, 1.5 # first\r\n\r\n 500,2e-3\r\n", "dye").unwrap();
        assert_eq!((t.wavelengths(), t.values()), (&[400.0, 500.0][..], &[1.5, 2e-3][..]));
        assert_eq!(read("\u{feff}400,1\n500,2", "dye").unwrap().values(), [1.0, 2.0]);
    }

    #[test]
    fn refusals_name_line_and_column() {
        for (text, message) in [
            ("400,1\n500, nan\n", "t:2:6: 'nan' is no finite number"),
            ("w,v\n400,1\n5oo,2\n", "t:3:1: '5oo' is no finite number"),
            ("400,1\n\n400,2", "t:3:1: 400 nm stands here twice"),
            ("400,1\n 390,2", "t:2:2: wavelengths must ascend: 390 nm follows 400 nm"),
            ("400,1\n500", "t:2:4: 1 of 2 numbers in this row"),
            ("400,1,7", "t:1:7: a row has 2 numbers"),
            ("400,inf", "t:1:5: 'inf' is no finite number"),
            ("-5,1", "t:1:1: -5 nm is no wavelength"),
            ("400,\n", "t:1:5: '' is no finite number"),
            ("# nothing\nw,v\n", "t: the table has no rows"),
            ("", "t: the table has no rows"),
        ] {
            assert_eq!(read(text, "t").unwrap_err().to_string(), message);
        }
    }

    /// The shipped wall absorptions hold what their headers derive: µa = kρ/2, ρ = 1500 kg/m³, falling
    /// by e in 90 nm.
    #[test]
    fn shipped_absorption_is_what_its_header_says() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("distributions/absorption");
        let mut count = 0;
        for (name, k, at) in [
            ("bleached-kraft", 0.25, 457.0),
            ("birch-kraft", 0.25, 457.0),
            ("eucalyptus-kraft", 0.25, 457.0),
            ("tmp-unbleached", 4.5, 457.0),
            ("ctmp", 1.25, 557.0),
        ] {
            let table =
                read(&std::fs::read_to_string(folder.join(name).with_extension("csv")).unwrap(), name)
                    .unwrap();
            assert_eq!(table.range(), (360.0, 780.0));
            for (nm, got) in table.wavelengths().iter().zip(table.values()) {
                let want = k * 1500.0 / 2.0 * 1e-6 * crate::math::exp(-(nm - at) / 90.0);
                assert!((got / want - 1.0).abs() < 1e-5, "{name} {nm}: {got} {want}");
            }
            count += 1;
        }
        assert_eq!(count, std::fs::read_dir(folder).unwrap().count());
    }
}
