//! Plots as SVG, each with the numbers behind it as CSV.
//!
//! Positions are in points (1/72 inch) from the upper left corner. Nothing is measured with a font:
//! widths of words are estimated on the safe side, so that no label is clipped or overlaps whatever
//! sans-serif font the reader has.

mod canvas;
mod axes;
pub mod bars;
pub mod colours;
pub mod hemisphere;
pub mod ledger;
pub mod lines;
pub mod polar;
pub mod section;

pub use bars::{Bar, BarPlot};
pub(super) use canvas::width;
pub use hemisphere::{HemisphereMap, Patch};
pub use ledger::LedgerBar;
pub use lines::{Curve, LinePlot, depth_profile, spectra};
pub use polar::{CutPoint, PolarCurve, PolarPlot, in_plane};

use super::file::RunFolder;

/// A plot and its numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// SVG document.
    pub svg: String,
    /// The numbers that it shows, as CSV.
    pub csv: String,
}

impl Plot {
    /// Writes `stem.svg` and `stem.csv` into the folder of a run.
    pub fn write(&self, folder: &RunFolder, stem: &str) -> std::io::Result<()> {
        folder.write(&format!("{stem}.svg"), self.svg.as_bytes())?;
        folder.write(&format!("{stem}.csv"), self.csv.as_bytes())
    }
}

#[cfg(test)]
pub(crate) mod checks {
    use quick_xml::events::Event;

    /// Texts of an SVG; panics if it is not well-formed.
    pub fn texts(svg: &str) -> Vec<String> {
        let mut reader = quick_xml::Reader::from_str(svg);
        let (mut out, mut depth, mut inside) = (Vec::new(), 0, false);
        loop {
            match reader.read_event().expect("well-formed XML") {
                Event::Start(tag) => {
                    depth += 1;
                    inside = tag.name().as_ref() == "text";
                    if inside {
                        out.push(String::new());
                    }
                }
                Event::End(_) => {
                    depth -= 1;
                    inside = false;
                }
                Event::Text(t) if inside => {
                    out.last_mut().unwrap().push_str(&t);
                }
                Event::GeneralRef(r) if inside => {
                    let name: &str = &r;
                    out.last_mut().unwrap().push_str(&format!("&{name};"));
                }
                Event::Eof => break,
                _ => {}
            }
        }
        assert_eq!(depth, 0, "every element is closed");
        assert!(!svg.contains("NaN") && !svg.contains("inf\""));
        out.iter().map(|t| t.trim().to_owned()).collect()
    }

    /// Saves the plot for the eye where `LIGHTPRO_LOOK` names a folder.
    pub fn look(plot: &super::Plot, name: &str) {
        if let Some(folder) = std::env::var_os("LIGHTPRO_LOOK") {
            std::fs::write(std::path::Path::new(&folder).join(name), &plot.svg).unwrap();
        }
    }
}
