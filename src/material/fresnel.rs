//! Fresnel.
