//! From amounts to densities: how many bodies make a layer of given grammage, after overlaps and
//! after the thinning at its faces.
//!
//! The expected share of a component at depth z follows from the densities ν_j of all kinds and their
//! coverage per unit density, out_j(z) for whole bodies and wall_j(z) for their solid:
//!
//! | rule | solid share of kind i at z |
//! | --- | --- |
//! | [`Rule::Union`] | (1 − e^(−Λw)) ν_i wall_i/Λw, Λw = Σ ν_j wall_j |
//! | [`Rule::Priority`] | (1 − e^(−Λ)) ν_i wall_i/Λ, Λ = Σ ν_j out_j |
//! | [`Rule::Apart`] | ν_i wall_i/(1 + Σ ν_j out_j): bodies that take room from the pores, ν counted in the pore volume (rung `none` with matched rate) |
//!
//! `cut` sheets have out = body content everywhere; in `contained` sheets the centre of a body of half
//! height h lies uniformly in [h, H − h], and out(z) thins towards the faces. The densities are found
//! by a multiplicative fixed-point iteration on the depth averages.

use super::kind::Kind;
use super::section::{Body, HalfAxes, half_height};
use crate::math::{PI, asin, gauss_legendre};
use crate::rng::{Purpose, Stream};
use std::sync::LazyLock;
use thiserror::Error;

/// How bodies share space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// A point is solid if any wall covers it.
    Union,
    /// The highest mark rules, wall or lumen.
    Priority,
    /// Bodies do not overlap; densities count in the pore volume.
    Apart,
}

/// How much of one kind a layer shall hold, averaged over its depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// Solid volume over layer volume.
    Solid(f64),
    /// Body volume (wall and lumen) over layer volume.
    Body(f64),
    /// Length (fibres, 1/µm²) or number (others, 1/µm³) over layer volume, before overlaps.
    Density(f64),
}

/// An amount that cannot be.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum AmountError {
    /// Share of one or above.
    #[error(
        "the layer would be {0:.1} % solid: more than its thickness can hold; less grammage or a thicker layer"
    )]
    TooMuch(f64),
    /// The rule cannot reach the target.
    #[error(
        "no density of bodies gives the wanted amount under this overlap rule (reached {reached:.4} of {wanted:.4} solid share); use overlap=\"union\", less grammage or a thicker layer"
    )]
    Unreachable {
        /// Share reached.
        reached: f64,
        /// Share wanted.
        wanted: f64,
    },
    /// Bodies thicker than the layer.
    #[error(
        "bodies of kind {0} are all thicker than the layer; a thicker layer, thinner bodies or edges=\"cut\""
    )]
    NoRoom(usize),
}

/// Coverage per unit density of one kind over depth.
#[derive(Clone, Debug)]
pub struct Coverage {
    /// Whole bodies.
    pub out: Vec<f64>,
    /// Solid only.
    pub wall: Vec<f64>,
    /// Mean content of one body (area of a fibre's section, volume of others).
    pub content: f64,
    /// Mean solid content.
    pub solid: f64,
    /// Mean outer surface (perimeter of a section per length of fibre, with the flat ends; or area).
    pub surface: f64,
    /// Mean surface of the lumen.
    pub inner: f64,
}

/// Gauss–Legendre nodes over relative depth (0…1) and their weights.
pub fn depth_nodes() -> Vec<(f64, f64)> {
    gauss_legendre(48, 0.0, 1.0)
}

/// Bodies drawn to average the coverage: a fixed stratified sample, the same for every run.
const SAMPLES: usize = 16_384;

/// Coverage of a kind in a layer of thickness `h_layer` (µm).
pub fn coverage(kind: &Kind, h_layer: f64, contained: bool) -> Coverage {
    let depths = depth_nodes();
    let mut c = Coverage {
        out: vec![0.0; depths.len()],
        wall: vec![0.0; depths.len()],
        content: 0.0,
        solid: 0.0,
        surface: 0.0,
        inner: 0.0,
    };
    let mut rng = Stream::of(0x0c0_7e4a6e, 0, 0, Purpose::Probe);
    let mut weight = 0.0;
    for _ in 0..SAMPLES {
        let body = kind.draw(&mut rng);
        // Length laws count fibres by number, amounts count them by length.
        let w = if kind.is_fibre() && body.ends.is_finite() { body.ends } else { 1.0 };
        weight += w;
        let (content, hollow) = contents(&body, kind.is_fibre());
        c.content += w * content;
        c.solid += w * (content - hollow);
        c.surface += w * surface_of(&body, kind.is_fibre());
        if kind.is_fibre() && body.ends.is_finite() {
            c.surface += content - hollow; // two ends on twice the half length w
        }
        c.inner += w * body.lumen.map_or(0.0, |l| perimeter(l.a, l.b));
        for (j, (depth, _)) in depths.iter().enumerate() {
            let shares = covered(kind, &body, h_layer, *depth, contained);
            c.out[j] += w * content * shares.0;
            c.wall[j] += w * (content * shares.0 - hollow * shares.1);
        }
    }
    let scaled = |v: &mut f64| *v /= weight;
    [&mut c.content, &mut c.solid, &mut c.surface, &mut c.inner].into_iter().for_each(scaled);
    c.out.iter_mut().chain(&mut c.wall).for_each(scaled);
    c
}

/// Content of a body and of its lumen: per length for fibres.
fn contents(body: &Body, fibre: bool) -> (f64, f64) {
    let length = if fibre || body.ends.is_infinite() { 1.0 } else { 2.0 * body.ends };
    (length * body.outer.content(), length * body.lumen.map_or(0.0, |l| l.content()))
}

/// Coverage at relative depth `depth` by such bodies (and their lumens) at unit density, over their
/// content: 1 where bodies stand anywhere, less near the faces that they may not cut.
fn covered(kind: &Kind, body: &Body, h_layer: f64, depth: f64, contained: bool) -> (f64, f64) {
    let height = body.half_height();
    // Centres may stand from `low` to `high`, measured down from the top.
    let (low, high) = if contained { (height, h_layer - height) } else { (-height, h_layer + height) };
    if low >= high {
        return (0.0, 0.0);
    }
    let z = depth * h_layer;
    let part = |axes: &HalfAxes| match &kind.profile {
        None if !contained => 1.0,
        None => below(z - low, body, axes) - below(z - high, body, axes),
        Some(profile) => {
            // Slices of the body: the weight of each is the density where the centre would stand.
            const SLICES: u32 = 24;
            // Below and above these the centre would stand where none may.
            let (from, to) = if contained { (z - high, z - low) } else { (-height, height) };
            let (from, to) = (from.max(-height), to.min(height));
            if from >= to {
                return 0.0;
            }
            let edge = |i: u32| from + (to - from) * f64::from(i) / f64::from(SLICES);
            (0..SLICES)
                .map(|i| {
                    let centre = z - 0.5 * (edge(i) + edge(i + 1));
                    profile.at(centre / h_layer)
                        * (below(edge(i + 1), body, axes) - below(edge(i), body, axes))
                })
                .sum()
        }
    };
    (part(&body.outer), body.lumen.as_ref().map_or(0.0, part))
}

/// Share of a body (with these axes) that lies below height `z` over its centre, µm.
fn below(z: f64, body: &Body, axes: &HalfAxes) -> f64 {
    let across = half_height(&body.frame, axes, f64::INFINITY);
    let axial = if body.ends.is_finite() { body.ends * body.frame.z.z.abs() } else { 0.0 };
    let share = |z: f64| slice(if across > 0.0 { z / across } else { z.signum() }, axes);
    if axial < 1e-9 * across {
        return share(z);
    }
    static NODES: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(16, -1.0, 1.0));
    NODES.iter().map(|(s, w)| 0.5 * w * share(z - axial * s)).sum()
}

/// Share of an ellipse's area (ellipsoid's volume) below relative height s: 0 at −1, 1 at 1.
fn slice(s: f64, axes: &HalfAxes) -> f64 {
    let s = s.clamp(-1.0, 1.0);
    if axes.c.is_infinite() {
        0.5 + (s * (1.0 - s * s).sqrt() + asin(s)) / PI
    } else {
        0.5 + 0.25 * s * (3.0 - s * s)
    }
}

/// Outer surface of a body: perimeter of a section (fibres, per length) or area.
fn surface_of(body: &Body, fibre: bool) -> f64 {
    let axes = &body.outer;
    let (a, b, c) = (axes.a, axes.b, axes.c);
    if !fibre && c.is_infinite() {
        return 2.0 * PI * a * (a + 2.0 * body.ends);
    }
    if c.is_infinite() {
        perimeter(a, b)
    } else {
        // Thomsen's formula, within 1.1 %; exact for spheres.
        let p = 1.6075;
        let pow = crate::math::pow;
        4.0 * PI * pow((pow(a * b, p) + pow(b * c, p) + pow(c * a, p)) / 3.0, 1.0 / p)
    }
}

/// Perimeter of an ellipse. The Gauss–Kummer series converges slowly for flat sections; Ramanujan's second
/// formula errs by less than 4e-4 there and by far less elsewhere, enough for a printed figure.
fn perimeter(a: f64, b: f64) -> f64 {
    let h = ((a - b) / (a + b)).powi(2);
    PI * (a + b) * (1.0 + 3.0 * h / (10.0 + (4.0 - 3.0 * h).sqrt()))
}

/// Solid and body shares of each kind at depth node `j`.
fn shares(rule: Rule, nu: &[f64], cover: &[Coverage], j: usize) -> Vec<(f64, f64)> {
    let out: f64 = nu.iter().zip(cover).map(|(n, c)| n * c.out[j]).sum();
    let wall: f64 = nu.iter().zip(cover).map(|(n, c)| n * c.wall[j]).sum();
    let covered = |x: f64| if x > 0.0 { -crate::math::expm1(-x) / x } else { 1.0 };
    nu.iter()
        .zip(cover)
        .map(|(n, c)| {
            let (o, w) = (n * c.out[j], n * c.wall[j]);
            match rule {
                Rule::Union => (w * covered(wall), o * covered(out)),
                Rule::Priority => (w * covered(out), o * covered(out)),
                Rule::Apart => (w / (1.0 + out), o / (1.0 + out)),
            }
        })
        .collect()
}

/// Depth averages of the solid and body shares of each kind.
pub fn averages(rule: Rule, nu: &[f64], cover: &[Coverage]) -> Vec<(f64, f64)> {
    let mut mean = vec![(0.0, 0.0); nu.len()];
    for (j, (_, w)) in depth_nodes().iter().enumerate() {
        for (m, s) in mean.iter_mut().zip(shares(rule, nu, cover, j)) {
            m.0 += w * s.0;
            m.1 += w * s.1;
        }
    }
    mean
}

/// Surface of each kind between solid and pore (lumens are pores too) over layer volume, 1/µm, after
/// overlaps; over depth it is taken to be spread like the body's content.
///
/// | rule | share of the outer surface S | of the lumen's |
/// | --- | --- | --- |
/// | [`Rule::Union`] | e^(−Λw): no wall covers it | the same |
/// | [`Rule::Priority`] | ω e^(−Λ) + (1 − ω)(1 − e^(−Λ))/Λ, ω = Λw/Λ: no higher mark covers it, and no wall lies behind | (1 − e^(−Λ))/Λ |
/// | [`Rule::Apart`] | all, ν/(1 + Λ) per layer volume | all |
pub fn surfaces(rule: Rule, nu: &[f64], cover: &[Coverage]) -> Vec<f64> {
    let mut mean = vec![0.0; nu.len()];
    for (j, (_, weight)) in depth_nodes().iter().enumerate() {
        let out: f64 = nu.iter().zip(cover).map(|(n, c)| n * c.out[j]).sum();
        let wall: f64 = nu.iter().zip(cover).map(|(n, c)| n * c.wall[j]).sum();
        if out <= 0.0 {
            continue;
        }
        let (bare, top) = (crate::math::exp(-out), -crate::math::expm1(-out) / out);
        let (outer, inner) = match rule {
            Rule::Union => (crate::math::exp(-wall), crate::math::exp(-wall)),
            Rule::Priority => (wall / out * bare + (1.0 - wall / out) * top, top),
            Rule::Apart => (1.0 / (1.0 + out), 1.0 / (1.0 + out)),
        };
        for (m, (n, c)) in mean.iter_mut().zip(nu.iter().zip(cover)) {
            *m += weight * n * c.out[j] / c.content * (outer * c.surface + inner * c.inner);
        }
    }
    mean
}

/// Shares that bodies of these densities would have if none overlapped: depth averages of ν wall (under
/// [`Rule::Apart`] they do not overlap).
pub fn nominal(rule: Rule, nu: &[f64], cover: &[Coverage]) -> Vec<f64> {
    if rule == Rule::Apart {
        return averages(rule, nu, cover).iter().map(|s| s.0).collect();
    }
    let nodes = depth_nodes();
    let mean = |c: &Coverage| nodes.iter().zip(&c.wall).map(|((_, w), x)| w * x).sum::<f64>();
    nu.iter().zip(cover).map(|(n, c)| n * mean(c)).collect()
}

/// Densities ν_i that reach the targets under `rule`. [`Target::Density`] under [`Rule::Apart`] means
/// the body share that overlapping bodies of that density would cover.
///
/// # Errors
/// [`AmountError`] where no density does.
pub fn densities(rule: Rule, targets: &[Target], cover: &[Coverage]) -> Result<Vec<f64>, AmountError> {
    for (i, c) in cover.iter().enumerate() {
        if c.out.iter().all(|&x| x <= 0.0) {
            return Err(AmountError::NoRoom(i));
        }
    }
    let targets = as_shares(rule, targets, cover);
    let solid: f64 = targets.iter().map(|t| if let Target::Solid(s) = t { *s } else { 0.0 }).sum();
    let body: f64 = targets.iter().map(|t| if let Target::Body(s) = t { *s } else { 0.0 }).sum();
    if solid + body >= 1.0 {
        return Err(AmountError::TooMuch(100.0 * (solid + body)));
    }
    let mut nu: Vec<f64> = targets
        .iter()
        .zip(cover)
        .map(|(t, c)| match t {
            Target::Solid(s) => s / c.solid,
            Target::Body(s) => s / c.content,
            Target::Density(d) => *d,
        })
        .collect();
    let mut worst = f64::INFINITY;
    for _ in 0..20_000 {
        let now = averages(rule, &nu, cover);
        worst = 0.0;
        for ((n, t), (s, b)) in nu.iter_mut().zip(&targets).zip(&now) {
            let ratio = match t {
                Target::Solid(want) if *want > 0.0 => want / s,
                Target::Body(want) if *want > 0.0 => want / b,
                _ => 1.0,
            };
            *n *= ratio;
            worst = f64::max(worst, (ratio - 1.0).abs());
        }
        if worst < 1e-12 {
            return Ok(nu);
        }
        if nu.iter().zip(cover).any(|(n, c)| n * c.content > 200.0 || !n.is_finite()) {
            break;
        }
    }
    if worst < 1e-9 {
        return Ok(nu);
    }
    let reached: f64 = averages(rule, &nu, cover).iter().map(|s| s.0).sum();
    Err(AmountError::Unreachable { reached, wanted: solid.max(body) })
}

/// Under [`Rule::Apart`], densities given before overlaps become the body shares that overlapping
/// bodies of those densities cover: Λ_i (1 − e^(−Λ))/Λ.
fn as_shares(rule: Rule, targets: &[Target], cover: &[Coverage]) -> Vec<Target> {
    if rule != Rule::Apart {
        return targets.to_vec();
    }
    let lambda: f64 = targets
        .iter()
        .zip(cover)
        .map(|(t, c)| if let Target::Density(d) = t { d * c.content } else { 0.0 })
        .sum();
    let covered = if lambda > 0.0 { -crate::math::expm1(-lambda) / lambda } else { 1.0 };
    targets
        .iter()
        .zip(cover)
        .map(|(t, c)| match t {
            Target::Density(d) => Target::Body(d * c.content * covered),
            other => *other,
        })
        .collect()
}
