//! lpm.
