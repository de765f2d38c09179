//! Reads a table, holds each row against the program, reports.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;

/// One row: column name → text.
pub struct Row {
    pub line: usize,
    cells: HashMap<String, String>,
}

impl Row {
    pub fn text(&self, column: &str) -> &str {
        self.cells.get(column).unwrap_or_else(|| panic!("no column {column}"))
    }
    pub fn f(&self, column: &str) -> f64 {
        let t = self.text(column);
        t.trim().parse().unwrap_or_else(|_| panic!("line {}: column {column}: '{t}' is no number", self.line))
    }
    /// A number, or None where the cell is empty or `nan`.
    pub fn maybe(&self, column: &str) -> Option<f64> {
        self.text(column).trim().parse().ok().filter(|x: &f64| !x.is_nan())
    }
    pub fn u(&self, column: &str) -> u64 {
        self.f(column) as u64
    }
}

/// Verdict on one row.
pub enum Check {
    /// Deviation in units of the tolerance (≤ 1 passes).
    Deviation(f64),
    /// The program cannot express this row: why.
    Cannot(&'static str),
}

/// Folder of the tables.
pub fn folder() -> PathBuf {
    std::env::var_os("LIGHTPRO_REFERENCE")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/reference"), PathBuf::from)
}

/// All rows of a table.
pub fn rows(file: &str) -> Vec<Row> {
    let path = folder().join(file);
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(&path)
        .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    reader
        .records()
        .enumerate()
        .map(|(i, record)| Row {
            line: i + 2,
            cells: names.iter().cloned().zip(record.unwrap().iter().map(str::to_owned)).collect(),
        })
        .collect()
}

/// Deviation of `got` from `want` in units of `tolerance`; NaN counts as infinite.
pub fn within(got: f64, want: f64, tolerance: f64) -> Check {
    let d = (got - want).abs() / tolerance;
    Check::Deviation(if d.is_nan() { f64::INFINITY } else { d })
}

/// Holds every row of `file` against `check`; panics if any deviates by more than its tolerance.
pub fn hold(file: &str, check: impl Fn(&Row) -> Check) {
    let (mut checked, mut worst, mut worst_line) = (0, 0.0_f64, 0);
    let mut failed = Vec::new();
    let mut cannot: BTreeMap<&str, usize> = BTreeMap::new();
    for row in rows(file) {
        match check(&row) {
            Check::Deviation(d) => {
                checked += 1;
                if d > worst {
                    (worst, worst_line) = (d, row.line);
                }
                if d > 1.0 || d.is_nan() {
                    failed.push((row.line, d));
                }
            }
            Check::Cannot(why) => *cannot.entry(why).or_default() += 1,
        }
    }
    println!("{file}: {checked} rows checked, worst {worst:.3} of its tolerance (line {worst_line})");
    for (why, n) in &cannot {
        println!("{file}: {n} rows not expressible: {why}");
    }
    assert!(checked > 0, "{file}: no row checked");
    assert!(
        failed.is_empty(),
        "{file}: {} of {checked} rows fail, first (line, deviation): {:?}",
        failed.len(),
        &failed[..failed.len().min(8)]
    );
}
