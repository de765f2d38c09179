//! What a run leaves behind: `result.json`, tidy tables, plots, the manifest, and the table of
//! figures on the terminal. Deterministic: the same result gives the same bytes.

pub mod file;
pub mod result;
pub mod schema;
pub mod csv;
pub mod text;
pub mod manifest;
pub mod mesh;
pub mod plot;
pub mod figures;
pub mod files;
pub mod instruments;
pub mod difference;
pub mod directions;
pub mod fluorescence;
pub mod depth;
pub mod folder;
pub mod view;
pub mod html;

pub use file::{RunFolder, write_atomic};
pub use manifest::Manifest;
pub use result::{Figure, Ordered, RunResult, Status};
