//! `result.json`: every figure of a run with its standard error, unit and status.

use crate::optics::PaperFigure;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::marker::PhantomData;

/// How far a figure can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Status {
    /// Value and standard error hold.
    #[serde(rename = "ok")]
    Ok,
    /// Too few or too uneven contributions: the standard error itself is doubtful.
    #[serde(rename = "unreliable")]
    Unreliable,
    /// Nothing was counted: the value is the bound below which the truth lies.
    #[serde(rename = "upper bound")]
    UpperBound,
    /// There is no value; the note says what it needs.
    #[serde(rename = "not available")]
    NotAvailable,
}

/// One figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// Stable name, e.g. `reflectance`.
    pub name: String,
    /// Vacuum wavelength in nm, if the figure has one.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub wavelength_nm: Option<f64>,
    /// Polar angle from the normal in degrees, if directional.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub polar_deg: Option<f64>,
    /// Azimuth in degrees, if directional.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub azimuth_deg: Option<f64>,
    /// Component that the figure belongs to, e.g. the material that absorbs.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub component: Option<String>,
    /// Value in `unit`; `null` if there is none.
    pub value: Option<f64>,
    /// Standard error in `unit`; `null` if unknown.
    pub error: Option<f64>,
    /// Unit: `1`, `%`, `1/sr`, `um`, `m2/kg` …
    pub unit: String,
    /// How far to trust it.
    pub status: Status,
    /// What a reader should know.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub note: Option<String>,
    /// Degrees of freedom of `error`, for Student's t: 2/VOV of scores counted history by history, replicas
    /// less one of jackknives. Not stored in files.
    #[serde(skip)]
    pub dof: Option<f64>,
}

impl Figure {
    /// A figure with value and standard error. A value that is not finite becomes `null` and "not
    /// available"; an error that is not finite becomes `null` and the figure "unreliable".
    pub fn new(name: &str, value: f64, error: f64, unit: &str) -> Self {
        let finite = |x: f64| x.is_finite().then_some(x);
        let status = match (value.is_finite(), error.is_finite()) {
            (true, true) => Status::Ok,
            (true, false) => Status::Unreliable,
            _ => Status::NotAvailable,
        };
        Figure {
            name: name.to_owned(),
            wavelength_nm: None,
            polar_deg: None,
            azimuth_deg: None,
            component: None,
            value: finite(value),
            error: finite(error).filter(|_| value.is_finite()),
            unit: unit.to_owned(),
            status,
            note: None,
            dof: None,
        }
    }
    /// A figure of paper optics with its standard error (from a jackknife over the same figure).
    pub fn of_paper(figure: &PaperFigure, error: f64) -> Self {
        let mut out =
            Figure::new(&figure.name, *figure.value.as_ref().unwrap_or(&f64::NAN), error, figure.unit);
        out.note = match &figure.value {
            Ok(_) => figure.caution.map(str::to_owned),
            Err(reason) => Some(reason.to_string()),
        };
        out
    }
    /// The same at a wavelength in nm.
    pub fn at_wavelength(mut self, nm: f64) -> Self {
        self.wavelength_nm = Some(nm);
        self
    }
    /// The same in a direction, in degrees.
    pub fn in_direction(mut self, polar_deg: f64, azimuth_deg: f64) -> Self {
        (self.polar_deg, self.azimuth_deg) = (Some(polar_deg), Some(azimuth_deg));
        self
    }
    /// The same for one component.
    pub fn of_component(mut self, component: &str) -> Self {
        self.component = Some(component.to_owned());
        self
    }
    /// The same with the degrees of freedom of its error.
    pub fn with_dof(mut self, dof: f64) -> Self {
        self.dof = Some(dof);
        self
    }
    /// 95 % interval by Student's t; as of a normal law where the degrees of freedom are unknown.
    pub fn interval95(&self) -> Option<(f64, f64)> {
        Some(crate::stats::interval95(self.value?, self.error?, self.dof.unwrap_or(f64::INFINITY)))
    }
    /// What the figure is of: name, component, wavelength, direction.
    pub fn title(&self) -> String {
        let mut text = self.name.clone();
        if let Some(component) = &self.component {
            text += &format!(" [{component}]");
        }
        if let Some(nm) = self.wavelength_nm {
            text += &format!(" at {nm} nm");
        }
        if let Some(polar) = self.polar_deg {
            text += &format!(" ({polar}°, {}°)", self.azimuth_deg.unwrap_or(0.0));
        }
        text
    }
    /// Whether both are the same figure, of whatever value.
    pub fn is_of(&self, other: &Figure) -> bool {
        let of = |f: &Figure| (f.wavelength_nm, f.polar_deg, f.azimuth_deg);
        self.name == other.name && self.component == other.component && of(self) == of(other)
    }
    /// The same with another status.
    pub fn with_status(mut self, status: Status) -> Self {
        self.status = status;
        self
    }
    /// The same with a note.
    pub fn with_note(mut self, note: &str) -> Self {
        self.note = Some(note.to_owned());
        self
    }
}

/// A share of the emitted power.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Share {
    /// Share of the emitted power, 0 to 1.
    pub value: f64,
    /// Standard error.
    pub error: f64,
}

/// Whether an effect was simulated, and why.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectUsed {
    /// Simulated.
    pub on: bool,
    /// The line of the scene that calls for it, or why nothing does.
    pub why: String,
}

/// A JSON object that keeps the order in which it was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Ordered<V>(pub Vec<(String, V)>);

impl<V> Default for Ordered<V> {
    fn default() -> Self {
        Ordered(Vec::new())
    }
}

impl<V: Serialize> Serialize for Ordered<V> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(k, v)| (k, v)))
    }
}

impl<'de, V: Deserialize<'de>> Deserialize<'de> for Ordered<V> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entries<V>(PhantomData<V>);
        impl<'de, V: Deserialize<'de>> Visitor<'de> for Entries<V> {
            type Value = Ordered<V>;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Ordered(entries))
            }
        }
        deserializer.deserialize_map(Entries(PhantomData))
    }
}

/// Everything in `result.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunResult {
    /// Version of the program.
    pub lightpro: String,
    /// Name of the scene.
    pub scene: String,
    /// Whether the run reached its end or its target (false: stopped by time or by hand).
    pub complete: bool,
    /// Number of histories.
    pub histories: u64,
    /// Figures, in a fixed order.
    pub figures: Vec<Figure>,
    /// Where the emitted power went: fate → share.
    pub ledger: Ordered<Share>,
    /// Effects: name → used or not, and why.
    pub effects: Ordered<EffectUsed>,
    /// What the statistical universe remembered, where it remembers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory: Option<MemoryUsed>,
    /// What the staircases of a volume did to rays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub voxels: Option<VoxelSteps>,
}

/// Steps of staircases and faces whose smooth normal contradicts them, mean per history.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VoxelSteps {
    /// Steps that rays passed, for the surface has none.
    pub passed: f64,
    /// Interfaces met although the ray came from the wrong side of the smooth normal: the face's own normal (steps
    /// mirrored: the nearest one that looks against the ray) took its place.
    pub forced: f64,
}

impl std::fmt::Display for VoxelSteps {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let VoxelSteps { passed, forced } = self;
        write!(f, "voxels: {passed:.3} steps passed and {forced:.4} faces met against their normal a history")
    }
}

/// What histories have kept in memory; histories that share a realisation count as one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MemoryUsed {
    /// Bodies met, mean per history.
    pub bodies: f64,
    /// Segments traced, mean per history.
    pub segments: f64,
    /// Bytes that the largest history needed.
    pub largest_bytes: u64,
    /// Pockets forgotten (finite memory), in all.
    pub pockets: u64,
}

impl std::fmt::Display for MemoryUsed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "memory: {:.1} bodies and {:.1} segments a history, at most {:.0} kB; {} pockets forgotten",
            self.bodies,
            self.segments,
            self.largest_bytes as f64 / 1e3,
            self.pockets
        )
    }
}

impl RunResult {
    /// Text of `result.json`: indented, in a fixed order, numbers so that they read back exactly.
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).expect("plain data is always JSON");
        text.push('\n');
        text
    }
    /// Reads what [`RunResult::to_json`] wrote.
    pub fn from_json(text: &str) -> serde_json::Result<Self> {
        serde_json::from_str(text)
    }
    /// The figure `name`, at `wavelength_nm` if given.
    pub fn figure(&self, name: &str, wavelength_nm: Option<f64>) -> Option<&Figure> {
        self.figures
            .iter()
            .find(|f| f.name == name && (wavelength_nm.is_none() || f.wavelength_nm == wavelength_nm))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> RunResult {
        let share = |value, error| Share { value, error };
        RunResult {
            lightpro: "0.1.0".into(),
            scene: "copy paper, 80 g/m2".into(),
            complete: true,
            histories: 4096,
            figures: vec![
                Figure::new("reflectance", 0.7312, 0.0004, "1").at_wavelength(550.0),
                Figure::new("brdf", f64::NAN, 1.0, "1/sr").in_direction(30.0, 180.0),
                Figure::new("absorptance", 1e-7, 0.0, "1")
                    .of_component("wall")
                    .with_status(Status::UpperBound),
            ],
            ledger: Ordered(vec![
                ("reflected".into(), share(0.7312, 4e-4)),
                ("absorbed".into(), share(0.1, 1e-4)),
            ]),
            effects: Ordered(vec![(
                "polarisation".into(),
                EffectUsed { on: false, why: "nothing needs it".into() },
            )]),
            memory: None,
            voxels: None,
        }
    }

    #[test]
    fn the_written_form_is_pinned() {
        let text = example().to_json();
        let compact: String = serde_json::to_string(&example()).unwrap();
        assert_eq!(
            compact,
            concat!(
                r#"{"lightpro":"0.1.0","scene":"copy paper, 80 g/m2","complete":true,"histories":4096,"figures":["#,
                r#"{"name":"reflectance","wavelength_nm":550.0,"value":0.7312,"error":0.0004,"unit":"1","status":"ok"},"#,
                r#"{"name":"brdf","polar_deg":30.0,"azimuth_deg":180.0,"value":null,"error":null,"unit":"1/sr","#,
                r#""status":"not available"},"#,
                r#"{"name":"absorptance","component":"wall","value":1e-7,"error":0.0,"unit":"1","#,
                r#""status":"upper bound"}],"#,
                r#""ledger":{"reflected":{"value":0.7312,"error":0.0004},"absorbed":{"value":0.1,"error":0.0001}},"#,
                r#""effects":{"polarisation":{"on":false,"why":"nothing needs it"}}}"#
            )
        );
        assert!(text.ends_with("}\n"));
    }

    #[test]
    fn results_survive_the_round_trip_to_the_last_bit() {
        let mut result = example();
        result.figures[0].value = Some(0.1 + 0.2);
        let back = RunResult::from_json(&result.to_json()).unwrap();
        assert_eq!(back, result);
        assert_eq!(back.to_json(), result.to_json());
        assert_eq!(back.figure("reflectance", Some(550.0)).unwrap().value, Some(0.1 + 0.2));
        assert!(back.figure("reflectance", Some(551.0)).is_none());
        assert!(RunResult::from_json(&result.to_json().replace("\"ok\"", "\"fine\"")).is_err());
    }

    #[test]
    fn missing_figures_carry_their_reason() {
        let paper = PaperFigure {
            name: "opacity".into(),
            unit: "%",
            value: Err(crate::optics::NotAvailable::needs("400–700 nm")),
            caution: None,
        };
        let figure = Figure::of_paper(&paper, 0.1);
        assert_eq!((figure.value, figure.error, figure.status), (None, None, Status::NotAvailable));
        assert_eq!(figure.note.as_deref(), Some("not available: needs 400–700 nm"));
        assert_eq!(Figure::new("x", 1.0, f64::INFINITY, "1").status, Status::Unreliable);
    }
}
