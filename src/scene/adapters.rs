//! Every call of the scene reader into spectra, laws and phase functions.

use crate::law::{Azimuth, Roll, SizeLaw, Weighting};
use crate::material::RefractiveIndex;
use crate::math::exp;
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

// ---- laws: stand-ins until `law` is merged (each names the constructor it stands for) ----

/// `SizeLaw::constant`
pub fn constant(x: f64) -> Answer<SizeLaw> {
    Ok(SizeLaw::Constant(x))
}
fn checked(ok: bool, what: &str, mean: f64) -> Answer<SizeLaw> {
    if ok { Ok(SizeLaw::Constant(mean)) } else { Err(what.to_string()) }
}
/// `SizeLaw::uniform`
pub fn uniform(lo: f64, hi: f64) -> Answer<SizeLaw> {
    checked(lo < hi, "a uniform law needs from < to", 0.5 * (lo + hi))
}
/// `SizeLaw::truncated_normal`
pub fn truncated_normal(mean: f64, _sd: f64, lo: f64, hi: f64) -> Answer<SizeLaw> {
    checked(lo < hi, "a truncated normal law needs from < to", mean)
}
/// `SizeLaw::lognormal`
pub fn lognormal(median: f64, sigma: f64) -> Answer<SizeLaw> {
    checked(true, "", median * exp(0.5 * sigma * sigma))
}
/// `SizeLaw::gamma`
pub fn gamma(mean: f64, _shape: f64) -> Answer<SizeLaw> {
    checked(true, "", mean)
}
/// `SizeLaw::weibull`
pub fn weibull(scale: f64, _shape: f64) -> Answer<SizeLaw> {
    checked(true, "", scale)
}
/// `SizeLaw::beta`
pub fn beta(a: f64, b: f64, lo: f64, hi: f64) -> Answer<SizeLaw> {
    checked(lo < hi, "a beta law needs from < to", lo + (hi - lo) * a / (a + b))
}
/// `SizeLaw::histogram`
pub fn histogram(edges: &[f64], weights: &[f64]) -> Answer<SizeLaw> {
    let sum: f64 = weights.iter().sum();
    let mean = (0..weights.len()).map(|i| 0.5 * weights[i] * (edges[i] + edges[i + 1])).sum::<f64>() / sum;
    checked(sum > 0.0, "the weights of a histogram sum to zero", mean)
}
/// `SizeLaw::mixture`
pub fn mixture(parts: Vec<(f64, SizeLaw)>) -> Answer<SizeLaw> {
    let mean = parts.iter().map(|(w, SizeLaw::Constant(x))| w * x).sum();
    checked(!parts.is_empty(), "a mixture needs parts", mean)
}
/// `SizeLaw::from_weighted`
pub fn from_weighted(law: SizeLaw, _weighting: Weighting, _exponent: f64) -> Answer<SizeLaw> {
    Ok(law)
}
/// `SizeLaw::sample`
pub fn draw(law: &SizeLaw, _rng: &mut Stream) -> f64 {
    let SizeLaw::Constant(x) = law;
    *x
}
/// `Azimuth::von_mises`
pub fn von_mises(_mean: f64, _kappa: f64) -> Answer<Azimuth> {
    Ok(Azimuth::Uniform)
}
/// `Azimuth::wrapped_cauchy`
pub fn wrapped_cauchy(_mean: f64, _rho: f64) -> Answer<Azimuth> {
    Ok(Azimuth::Uniform)
}
/// `Roll::Normal`
pub fn roll_normal(_sd: f64) -> Answer<Roll> {
    Ok(Roll::Uniform)
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
