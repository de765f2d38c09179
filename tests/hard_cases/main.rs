//! The hard cases of the design, one by one: what goes wrong in the plain form (measured here), and what
//! the program gives. `docs/numerics.md` is written from this test: LIGHTPRO_WRITE=1 cargo test --test
//! hard_cases.
#![allow(clippy::disallowed_methods, missing_docs)]

mod cases;
mod faults;
mod plain;
mod properties;
mod relations;
#[path = "../walking/mod.rs"]
mod walking;

use std::path::Path;

/// A line of the table.
pub struct Row {
    /// The item of the design's list.
    pub case: &'static str,
    /// What the plain form does.
    pub plain: String,
    /// What ours gives.
    pub ours: String,
    /// Where it is held: files with the names of tests or scenes in them.
    pub held: &'static [(&'static str, &'static str)],
}

/// One significant digit: enough to compare, and the same for every rounding of the last bits.
pub fn one(x: f64) -> String {
    format!("{x:.0e}")
}

const HEAD: &str = "# Where formulas meet floating point

What a textbook form does in double precision where it is hard, measured, and what the program does instead. Written by `LIGHTPRO_WRITE=1 cargo test --test hard_cases`; the test fails where this page is out of step. The last column names the test that holds the case (file: name).

Long runs, by hand (each is an ignored test that prints what it found): 1e8 stressed interfaces of statistical sheets that remember all, eight flights, or nothing (one ray in four at 1e-9 to 1e-1 rad along the surface it left; 1e-5 at least where there is memory, which learns whatever crosses a lumen of endless length), none lost, none wrong, none off its fibre by more than .03 of what rounding allows (`hundred_million` of `statistical_universe`, a minute); 1e8 stressed interfaces of explicit fibres at origins 0, 1 mm and 24 mm, alone and in periodic cells, none lost, none wrong (`hundred_million` of `synthetic_universe`, 2 minutes); 1e8 stressed voxel crossings, three kinds of surface and two of borders, none lost, none wrong (`hundred_million` of `voxel_universe`, 19 minutes); P2 from two families of generators, 7.4e7 histories each: .579961(57) by PCG64-DXSM and .579805(57) by Philox beside .5799(1), z with that uncertainty 0.5 and -0.8 (`both_families_at_1e_4` of `generators`, 15 minutes).

| case | plain form | here | held by |
| --- | --- | --- | --- |
";

const FAULTS: &str = "
# Bad input and faults

What happens where the input or the machine fails. The tests named hold it; of the long ones a short form runs with the others.

| fault | what happens | held by |
| --- | --- | --- |
";

/// Names of tests with their files, each looked up in its file.
fn names(what: &str, held: &[(&str, &str)]) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let name = |(file, name): &(&str, &str)| {
        let content = std::fs::read_to_string(root.join(file)).unwrap_or_default();
        assert!(content.contains(name), "{what}: no `{name}` in {file}");
        format!("`{file}`: {}", name.trim_start_matches("fn "))
    };
    held.iter().map(name).collect::<Vec<_>>().join("; ")
}

#[test]
fn the_page_is_in_step() {
    let mut text = HEAD.to_owned();
    for row in cases::all() {
        text += &format!("| {} | {} | {} | {} |\n", row.case, row.plain, row.ours, names(row.case, row.held));
    }
    text += FAULTS;
    for row in faults::FAULTS {
        text += &format!("| {} | {} | {} |\n", row.fault, row.happens, names(row.fault, row.held));
    }
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/numerics.md");
    if std::env::var_os("LIGHTPRO_WRITE").is_some() {
        std::fs::write(&page, &text).unwrap();
    }
    let stands = std::fs::read_to_string(&page).unwrap_or_default();
    assert!(stands == text, "docs/numerics.md is out of step: LIGHTPRO_WRITE=1 cargo test --test hard_cases");
}
