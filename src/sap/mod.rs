//! Sphere Area Partitioning.
