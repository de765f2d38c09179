//! statistical.
