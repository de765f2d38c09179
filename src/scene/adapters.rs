//! Every call of the scene reader into spectra, laws and phase functions.

use crate::law::{Azimuth, Roll, SizeLaw, Tilt, Weighting};
use crate::material::RefractiveIndex;
use crate::phase::{Phase, Table};
use crate::rng::Stream;
use crate::spectrum::{Extrapolate, Spectrum, csv, rii};
use num_complex::Complex64;
use std::sync::Arc;

type Answer<T> = Result<T, String>;

fn told<T, E: std::fmt::Display>(r: Result<T, E>) -> Answer<T> {
    r.map_err(|e| e.to_string())
}

/// A spectrum of a two-column CSV text.
pub fn spectrum_csv(text: &str, name: &str) -> Answer<Spectrum> {
    told(csv::read(text, name).map(Spectrum::from))
}

/// n(λ) and κ(λ) of a refractiveindex.info text.
pub fn index_rii(text: &str, name: &str) -> Answer<(Spectrum, Option<Spectrum>)> {
    told(rii::read(text, name))
}

/// A constant spectrum.
pub fn flat(x: f64) -> Spectrum {
    Spectrum::Constant(x)
}

/// The spectrum with its end values held beyond its range; None where it cannot (a formula).
pub fn clamped(s: Spectrum) -> Option<Spectrum> {
    match s {
        Spectrum::Formula(_) => None,
        s => Some(s.extrapolated(Extrapolate::Clamp)),
    }
}

/// Range of a spectrum, nm; None: everywhere.
pub fn range(s: &Spectrum) -> Option<(f64, f64)> {
    s.range()
}

/// Index from its parts.
pub fn index(n: Spectrum, k: Option<Spectrum>) -> RefractiveIndex {
    RefractiveIndex { n, k }
}

/// n + iκ at a wavelength, nm; a passive medium has n > 0 and κ ≥ 0.
pub fn index_at(index: &RefractiveIndex, nm: f64) -> Answer<Complex64> {
    let n = told(index.n.at(nm))?;
    let k = index.k.as_ref().map_or(Ok(0.0), |k| told(k.at(nm)))?;
    if n > 0.0 && k >= 0.0 {
        return Ok(Complex64::new(n, k));
    }
    Err(format!("n = {n}, κ = {k} at {nm} nm: a medium has n > 0 and κ ≥ 0"))
}

// ---- laws ----

/// One value.
pub fn constant(x: f64) -> Answer<SizeLaw> {
    told(SizeLaw::constant(x))
}
/// Uniform between two ends.
pub fn uniform(lo: f64, hi: f64) -> Answer<SizeLaw> {
    told(SizeLaw::uniform(lo, hi))
}
/// Normal, truncated.
pub fn truncated_normal(mean: f64, sd: f64, lo: f64, hi: f64) -> Answer<SizeLaw> {
    told(SizeLaw::truncated_normal(mean, sd, lo, hi))
}
/// Lognormal.
pub fn lognormal(median: f64, sigma: f64) -> Answer<SizeLaw> {
    told(SizeLaw::lognormal(median, sigma))
}
/// Gamma.
pub fn gamma(mean: f64, shape: f64) -> Answer<SizeLaw> {
    told(SizeLaw::gamma(mean, shape))
}
/// Weibull.
pub fn weibull(scale: f64, shape: f64) -> Answer<SizeLaw> {
    told(SizeLaw::weibull(scale, shape))
}
/// Beta between two ends.
pub fn beta(a: f64, b: f64, lo: f64, hi: f64) -> Answer<SizeLaw> {
    told(SizeLaw::beta(a, b, lo, hi))
}
/// Histogram.
pub fn histogram(edges: Vec<f64>, weights: Vec<f64>) -> Answer<SizeLaw> {
    told(SizeLaw::histogram(edges, weights))
}
/// Mixture.
pub fn mixture(parts: Vec<(f64, SizeLaw)>) -> Answer<SizeLaw> {
    told(SizeLaw::mixture(parts))
}
/// By number, from a law that counts each particle by x^exponent.
pub fn from_weighted(law: SizeLaw, weighting: Weighting, exponent: f64) -> Answer<SizeLaw> {
    told(law.check_tilt(-exponent))?;
    Ok(SizeLaw::from_weighted(law, weighting, exponent))
}
/// Largest value of a law.
pub fn upper(law: &SizeLaw) -> f64 {
    law.upper()
}
/// One draw.
pub fn draw(law: &SizeLaw, rng: &mut Stream) -> f64 {
    law.sample(rng)
}
/// von Mises azimuth.
pub fn von_mises(mean: f64, kappa: f64) -> Answer<Azimuth> {
    told(Azimuth::von_mises(mean, kappa))
}
/// Wrapped Cauchy azimuth.
pub fn wrapped_cauchy(mean: f64, rho: f64) -> Answer<Azimuth> {
    told(Azimuth::wrapped_cauchy(mean, rho))
}
/// Normal roll.
pub fn roll_normal(sd: f64) -> Answer<Roll> {
    told(Roll::normal(sd))
}

/// Normal tilt out of the plane.
pub fn tilt_normal(sd: f64) -> Answer<Tilt> {
    told(Tilt::normal(sd))
}

// ---- phase functions ----

/// Henyey–Greenstein.
pub fn henyey_greenstein(g: f64) -> Answer<Phase> {
    told(Phase::henyey_greenstein(g))
}
/// Two-term Henyey–Greenstein.
pub fn two_term(w: f64, g1: f64, g2: f64) -> Answer<Phase> {
    told(Phase::two_term(w, g1, g2))
}
/// Rayleigh.
pub fn rayleigh() -> Phase {
    Phase::Rayleigh
}
/// A user's table, CSV of angle and density.
pub fn phase_table(text: &str, name: &str) -> Answer<Phase> {
    let table = Table::from_csv(text).map_err(|e| format!("{name}: {e}"))?;
    Ok(Phase::Table(Arc::new(table)))
}
