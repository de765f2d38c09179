//! Tidy tables: one observation a row, one quantity a column, units in the headings. Numbers are
//! written so that they read back exactly; an empty cell is a value that does not exist.

use super::result::Figure;
use serde::{Deserialize, Serialize};

/// One value of a spectrum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpectrumRow {
    /// Curve, e.g. `R over black`.
    pub series: String,
    /// Vacuum wavelength in nm.
    pub wavelength_nm: f64,
    /// Value.
    pub value: f64,
    /// Standard error.
    pub error: f64,
}

/// One patch of an angular distribution.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AngularRow {
    /// Index of the patch (HEALPix RING).
    pub patch: u64,
    /// Polar angle of the centre from the normal, degrees.
    pub polar_deg: f64,
    /// Azimuth of the centre, degrees.
    pub azimuth_deg: f64,
    /// Solid angle of the patch in sr.
    pub solid_angle_sr: f64,
    /// Value per sr.
    pub value_per_sr: f64,
    /// Standard error per sr.
    pub error_per_sr: f64,
}

/// One layer of a depth profile.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DepthRow {
    /// Curve, e.g. a component or a wavelength.
    pub series: String,
    /// Upper side of the layer, µm below the top of the sheet.
    pub from_um: f64,
    /// Lower side, µm.
    pub to_um: f64,
    /// Value.
    pub value: f64,
    /// Standard error.
    pub error: f64,
}

/// One fate in the ledger of power.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LedgerRow {
    /// Where the power went.
    pub fate: String,
    /// Share of the emitted power.
    pub share: f64,
    /// Standard error.
    pub error: f64,
}

/// One row of `figures.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FigureRow {
    /// Stable name.
    pub name: String,
    /// Vacuum wavelength in nm.
    pub wavelength_nm: Option<f64>,
    /// Polar angle, degrees.
    pub polar_deg: Option<f64>,
    /// Azimuth, degrees.
    pub azimuth_deg: Option<f64>,
    /// Component.
    pub component: Option<String>,
    /// Value in `unit`.
    pub value: Option<f64>,
    /// Standard error in `unit`.
    pub error: Option<f64>,
    /// Unit.
    pub unit: String,
    /// Status as in `result.json`.
    pub status: super::Status,
    /// Note.
    pub note: Option<String>,
}

/// Table of `rows` with a heading line. An empty table is empty text.
pub fn table<R: Serialize>(rows: &[R]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).expect("plain rows in memory");
    }
    String::from_utf8(writer.into_inner().expect("plain rows in memory")).expect("rows are UTF-8")
}

/// `figures.csv`: all columns of [`Figure`], in the order of `result.json`.
pub fn figures(figures: &[Figure]) -> String {
    let row = |f: &Figure| FigureRow {
        name: f.name.clone(),
        wavelength_nm: f.wavelength_nm,
        polar_deg: f.polar_deg,
        azimuth_deg: f.azimuth_deg,
        component: f.component.clone(),
        value: f.value,
        error: f.error,
        unit: f.unit.clone(),
        status: f.status,
        note: f.note.clone(),
    };
    table(&figures.iter().map(row).collect::<Vec<_>>())
}

/// Rows of a table that [`table`] wrote.
pub fn parse<R: for<'a> Deserialize<'a>>(text: &str) -> Result<Vec<R>, csv::Error> {
    csv::Reader::from_reader(text.as_bytes()).deserialize().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_read_back_exactly() {
        let rows = vec![
            SpectrumRow { series: "R, \"top\"".into(), wavelength_nm: 550.0, value: 0.1 + 0.2, error: 1e-17 },
            SpectrumRow { series: "T".into(), wavelength_nm: 560.0, value: 0.25, error: 0.0 },
        ];
        let text = table(&rows);
        assert!(text.starts_with("series,wavelength_nm,value,error\n"));
        assert_eq!(parse::<SpectrumRow>(&text).unwrap(), rows);
        let patch = vec![AngularRow {
            patch: 7,
            polar_deg: 11.7,
            azimuth_deg: 45.0,
            solid_angle_sr: 0.26,
            value_per_sr: 0.31,
            error_per_sr: 0.002,
        }];
        assert_eq!(parse::<AngularRow>(&table(&patch)).unwrap(), patch);
    }

    #[test]
    fn figures_keep_their_gaps() {
        let list = [
            Figure::new("reflectance", 0.5, 0.01, "1").at_wavelength(550.0),
            Figure::new("opacity", f64::NAN, 0.0, "%").with_note("not available: needs 400–700 nm"),
        ];
        let text = figures(&list);
        let mut lines = text.lines();
        assert_eq!(
            lines.next(),
            Some("name,wavelength_nm,polar_deg,azimuth_deg,component,value,error,unit,status,note")
        );
        assert_eq!(lines.next(), Some("reflectance,550.0,,,,0.5,0.01,1,ok,"));
        assert_eq!(lines.next(), Some("opacity,,,,,,,%,not available,not available: needs 400–700 nm"));
        assert_eq!(parse::<FigureRow>(&text).unwrap()[1].value, None);
    }
}
