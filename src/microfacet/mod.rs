//! Microfacets.
