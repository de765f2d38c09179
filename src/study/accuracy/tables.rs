//! Rows of the tables T1 to T5.

use serde::{Deserialize, Serialize};

/// T1: a watched figure with what tells whether its error is to be believed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Result1 {
    /// Figure.
    pub figure: String,
    /// Value.
    pub value: f64,
    /// Standard error.
    pub error: f64,
    /// Lower end of the 95 % interval (Student's t).
    pub low95: f64,
    /// Upper end.
    pub high95: f64,
    /// Error over value.
    pub relative_error: f64,
    /// Variance of the variance, of figures counted history by history.
    pub vov: Option<f64>,
    /// Skewness of the scores.
    pub skewness: Option<f64>,
    /// Degrees of freedom of the error.
    pub dof: Option<f64>,
    /// 1/(relative error² · processor s): differs from run to run.
    pub figure_of_merit: f64,
    /// Unit.
    pub unit: String,
}

/// T2: a source of error of a figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Source2 {
    /// Figure.
    pub figure: String,
    /// Source.
    pub source: String,
    /// Its size in the figure's unit; empty: unknown.
    pub size: Option<f64>,
    /// Standard error of the size.
    pub error: Option<f64>,
    /// `measured`, `bounded`, `assumed` or `not assessed`.
    pub how: String,
    /// From what.
    pub note: String,
}

/// T3: time to a target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Time3 {
    /// Figure.
    pub figure: String,
    /// Target, as typed for `--target`.
    pub target: String,
    /// Error wanted, in the figure's unit.
    pub wanted: f64,
    /// Predicted histories per wavelength group; empty: never.
    pub histories: Option<u64>,
    /// Predicted processor seconds.
    pub cpu_seconds: Option<f64>,
    /// Lower end of their 95 % band.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
    /// "never", and what to do; or what is counted in.
    pub note: String,
}

/// T4: a setting of a knob.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setting4 {
    /// Knob.
    pub knob: String,
    /// Setting.
    pub setting: String,
    /// Mesh size; 0: exact.
    pub h: f64,
    /// Figure.
    pub figure: String,
    /// Value.
    pub value: f64,
    /// Standard error.
    pub error: f64,
    /// Less the reference setting's.
    pub bias: f64,
    /// Standard error of that (paired where both draw alike).
    pub bias_error: f64,
    /// Histories per wavelength group.
    pub histories: u64,
    /// Processor seconds.
    pub cpu_seconds: f64,
    /// Processor time for the same standard error, over that of the scene's own setting.
    pub times_own: f64,
    /// Observed order from the three finest meshes, where their differences can be told from noise.
    pub order: Option<f64>,
    /// Second-order extrapolation, only where the ratio per doubling is near 4.
    pub richardson: Option<f64>,
    /// `own`, `reference`, `recommended`.
    pub mark: String,
}

/// T5: an effect toggled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Effect5 {
    /// Effect.
    pub effect: String,
    /// As planned.
    pub on: bool,
    /// Processor time with it toggled, over the plan's.
    pub times: Option<f64>,
    /// ns per event with it toggled.
    pub ns_per_event: Option<f64>,
    /// Events per history with it toggled.
    pub events: Option<f64>,
    /// Largest change of reflectance or transmittance.
    pub change: Option<f64>,
    /// 95 % interval of the change.
    pub low95: Option<f64>,
    /// Upper end.
    pub high95: Option<f64>,
    /// What calls for it, why it is off, or why it cannot be toggled.
    pub note: String,
}

/// The held-out run: predicted against measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Held {
    /// Figure and target.
    pub target: String,
    /// Histories per wavelength group.
    pub histories: u64,
    /// Predicted processor seconds.
    pub predicted_cpu: f64,
    /// Measured ones.
    pub measured_cpu: f64,
    /// Wanted standard error.
    pub wanted: f64,
    /// Standard error reached.
    pub reached: f64,
    /// Processor seconds that the target itself would have taken, by the error reached.
    pub cpu_of_target: f64,
    /// Measured seconds over predicted ones.
    pub ratio: f64,
    /// Held-out value less that of the study, over their joint error.
    pub z: f64,
}
