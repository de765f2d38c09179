//! What can be wrong with the parameters of a phase function.

/// A phase function was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PhaseError {
    /// A parameter is outside its range, or no number.
    #[error("{what} = {value} is outside its range ({range})")]
    Range {
        /// Name of the parameter.
        what: &'static str,
        /// Value as given.
        value: f64,
        /// Allowed values, in words.
        range: &'static str,
    },
    /// A line of a text, or a knot or part of a list (counted from 1), is wrong.
    #[error("{kind} {number}: {message}")]
    Place {
        /// "line", "knot", "part" or "node".
        kind: &'static str,
        /// Its number, from 1.
        number: usize,
        /// What is wrong.
        message: String,
    },
    /// The input as a whole is wrong.
    #[error("{0}")]
    Whole(String),
}

/// Refuses `value` unless `ok`.
pub(super) fn range(what: &'static str, value: f64, ok: bool, range: &'static str) -> Result<(), PhaseError> {
    if ok { Ok(()) } else { Err(PhaseError::Range { what, value, range }) }
}

/// Refuses a mean cosine outside (−1, 1).
pub(super) fn mean_cosine(what: &'static str, g: f64) -> Result<(), PhaseError> {
    range(what, g, g.abs() < 1.0, "−1 < g < 1")
}

/// An error at one place of a list.
pub(super) fn place(kind: &'static str, number: usize, message: impl Into<String>) -> PhaseError {
    PhaseError::Place { kind, number, message: message.into() }
}
