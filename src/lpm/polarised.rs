//! Polarised light at surfaces and in media: the state of a ray and how events change it.
//!
//! The plane of incidence (of the facet) has the perpendicular direction s ∝ k × n, which is the same
//! before and after; the parallel one is k × s for each ray. With it the amplitudes of
//! [`fresnel::Fresnel`] are r∥, r⊥ as they stand (a reflection at 0° turns both fields), and total
//! reflection keeps its phases.

use super::ledger::{Ledger, add};
use super::light::Medium;
use super::surface::{
    Directions, Fate, Meeting, Ratio, SurfaceLaw, film, keep, lambertian, right_side, snell,
};
use crate::material::fresnel::{self, Fresnel};
use crate::math::frame::{orthonormal, renormalise};
use crate::math::{DVec3, Frame};
use crate::microfacet::{Masking, Microfacet, reflect_about, refract_about};
use crate::phase::polarised::{ScatteringMatrix, Stokes};
use crate::rng::Stream;
use num_complex::Complex64;

/// Polarisation of a ray with its reference axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Stokes parameters over the power.
    pub stokes: Stokes,
    /// Parallel direction, unit, across the ray.
    pub axis: DVec3,
}

impl Default for State {
    fn default() -> Self {
        State { stokes: Stokes::NONE, axis: DVec3::X }
    }
}

impl State {
    /// Unpolarised light along `dir`.
    pub fn none(dir: DVec3) -> Self {
        State { stokes: Stokes::NONE, axis: orthonormal(dir).0 }
    }

    /// The same light of direction `dir` with the reference axis `axis` (unit, across `dir`).
    #[inline]
    pub fn along(self, dir: DVec3, axis: DVec3) -> Self {
        let (c, s) = (self.axis.dot(axis), self.axis.cross(dir).dot(axis));
        State { stokes: self.stokes.turned(c, s), axis }
    }

    /// Referred to the plane of `dir` and `normal`; where they are parallel to the plane there is.
    #[inline]
    fn in_plane(self, dir: DVec3, normal: DVec3) -> (Self, DVec3) {
        let side = dir.cross(normal);
        let l2 = side.length_squared();
        if l2 < 1e-24 {
            return (self, self.axis.cross(dir));
        }
        let side = side * (1.0 / l2.sqrt());
        (self.along(dir, dir.cross(side)), side)
    }

    /// Of a ray that goes on along `dir` with the perpendicular direction `side`.
    #[inline]
    fn after(stokes: Stokes, dir: DVec3, side: DVec3) -> Self {
        let axis = dir.cross(side);
        let l2 = axis.length_squared();
        if l2 < 1e-12 { State::none(dir) } else { State { stokes, axis: axis * (1.0 / l2.sqrt()) } }
    }
}

/// Scattering in a medium: angle by the phase function, azimuth by 1 + S12/S11 (Q cos 2φ + U sin 2φ).
#[inline]
pub fn scatter<const N: usize>(
    medium: &Medium<N>,
    matrix: &ScatteringMatrix,
    dir: DVec3,
    state: &mut State,
    rng: &mut Stream,
) -> DVec3 {
    if matrix == &ScatteringMatrix::Depolarising {
        let dir = medium.scatter(dir, rng);
        *state = State::none(dir);
        return dir;
    }
    let polar = medium.phase.sample(rng);
    let e = matrix.at(polar.cos, polar.sin);
    let Stokes { q, u, .. } = state.stokes;
    let most = 1.0 + e.s12.abs() * (q * q + u * u).sqrt();
    let (c, s) = loop {
        let (c, s) = rng.azimuth();
        let density = 1.0 + e.s12 * (q * (c - s) * (c + s) + 2.0 * u * c * s);
        if most == 1.0 || rng.uniform() * most <= density {
            break (c, s);
        }
    };
    let axis = state.axis * c + state.axis.cross(dir) * s;
    let out = renormalise(dir * polar.cos + axis * polar.sin);
    let stokes = e.scatter(state.stokes.turned(c, s));
    *state = State { stokes, axis: renormalise(axis * polar.cos - dir * polar.sin) };
    // Two unit directions drift apart from a right angle over thousands of events: the axis follows.
    state.axis = renormalise(state.axis - out * state.axis.dot(out));
    out
}

/// Power factors and cross amplitude of one side of an interface, for [`Stokes::through`].
#[derive(Clone, Copy)]
struct Side {
    p: f64,
    s: f64,
    cross: Complex64,
}

/// Reflection and transmission of an interface at cosine `cos_i`. Laws other than Fresnel and films say
/// how much is reflected, not in which state: they reflect as an ideal mirror and pass the state on.
fn sides<const N: usize>(law: &SurfaceLaw<N>, m: &Meeting<N>, cos_i: f64) -> (Side, Side) {
    match &law.ratio {
        Ratio::Fresnel => {
            let n1 = m.here.n;
            let n1 = if fresnel::weakly_absorbing(n1) { Complex64::from(n1.re) } else { n1 };
            let f = Fresnel::new(n1, m.beyond.n, 1.0, cos_i);
            let back = Side { p: f.reflectance_p, s: f.reflectance_s, cross: f.rp * f.rs.conj() };
            let (tp, ts) = ((f.rp + 1.0) * n1 / m.beyond.n, f.rs + 1.0);
            let (p, s) = (f.transmittance_p, f.transmittance_s);
            (back, passed(tp * ts.conj(), p, s))
        }
        Ratio::Film { index, thickness } => {
            let f = film(m.here.n, *index, m.beyond.n, thickness[0], cos_i);
            let back = Side { p: f.rp.norm_sqr(), s: f.rs.norm_sqr(), cross: f.rp * f.rs.conj() };
            let (p, s) = (1.0 - back.p, 1.0 - back.s);
            (back, passed(f.tp * f.ts.conj(), p, s))
        }
        _ => {
            let r = law.reflectance(m.here, m.beyond, cos_i)[0];
            let side = |x: f64, sign: f64| Side { p: x, s: x, cross: Complex64::from(sign * x) };
            (side(r, -1.0), side(1.0 - r, 1.0))
        }
    }
}

/// The transmitted side from its powers and the phase between its amplitudes.
fn passed(phase: Complex64, p: f64, s: f64) -> Side {
    let length = phase.norm();
    let cross = if length > 0.0 { phase * ((p * s).max(0.0).sqrt() / length) } else { Complex64::ZERO };
    Side { p, s, cross }
}

/// What an interface decides: on which side the ray goes on, the power left at an opaque one, the
/// perpendicular direction; the state is that after the event, its axis still to be set.
struct Decided<const N: usize> {
    reflected: bool,
    absorbed: Option<[f64; N]>,
    stokes: Stokes,
    side: DVec3,
}

/// Fresnel at the plane or facet of world normal `normal`.
fn decide<const N: usize>(
    law: &SurfaceLaw<N>,
    m: &Meeting<N>,
    (normal, cos_i): (DVec3, f64),
    state: State,
    power: &mut [f64; N],
    ledger: &mut Ledger<N>,
    rng: &mut Stream,
) -> Decided<N> {
    let (referred, side) = state.in_plane(m.dir, normal);
    let (back, on) = sides(law, m, cos_i);
    let (r, reflected) = referred.stokes.through(back.p, back.s, back.cross);
    if law.opaque {
        let absorbed = keep(power, &[r; N], ledger);
        return Decided { reflected: true, absorbed: Some(absorbed), stokes: reflected, side };
    }
    if r >= 1.0 || rng.uniform() < r {
        return Decided { reflected: true, absorbed: None, stokes: reflected, side };
    }
    let (_, stokes) = referred.stokes.through(on.p, on.s, on.cross);
    Decided { reflected: false, absorbed: None, stokes, side }
}

/// A surface event of polarised light: one outgoing ray, its state in `state`.
pub fn draw<const N: usize>(
    law: &SurfaceLaw<N>,
    m: &Meeting<N>,
    state: &mut State,
    power: &mut [f64; N],
    ledger: &mut Ledger<N>,
    rng: &mut Stream,
) -> Fate<N> {
    if let Directions::Facets { law: facets, renormalised } = &law.directions {
        return facet(law, facets, *renormalised, m, state, power, ledger, rng);
    }
    let n = m.at.normal;
    let decided = decide(law, m, (n, m.cos_i()), *state, power, ledger, rng);
    let smooth = matches!(law.directions, Directions::Smooth);
    let (dir, facet) = match (decided.reflected, smooth) {
        (true, true) => (Some(fresnel::reflect(m.dir, n)), m.at.facet),
        (true, false) => (Some(lambertian(n, rng)), m.at.facet),
        (false, true) => (snell(m), -m.at.facet),
        (false, false) => (Some(lambertian(-n, rng)), -m.at.facet),
    };
    let Some(dir) = dir.map(|d| right_side(d, facet)) else { return Fate::Absorbed };
    *state = if smooth { State::after(decided.stokes, dir, decided.side) } else { State::none(dir) };
    match decided.reflected {
        true => Fate::Reflected { dir, absorbed: decided.absorbed },
        false => Fate::Refracted { dir },
    }
}

/// Microfacets: a visible facet is drawn, it reflects or refracts as a small plane, and what other facets
/// mask is taken off the power.
#[allow(clippy::too_many_arguments)]
fn facet<const N: usize>(
    law: &SurfaceLaw<N>,
    facets: &Microfacet,
    renormalised: bool,
    m: &Meeting<N>,
    state: &mut State,
    power: &mut [f64; N],
    ledger: &mut Ledger<N>,
    rng: &mut Stream,
) -> Fate<N> {
    let frame = Frame::with_x_toward(m.at.normal, m.at.axis);
    let i = frame.to_local(-m.dir);
    let i = DVec3::new(i.x, i.y, i.z.max(0.0));
    let h = facets.sample_visible(i, rng);
    let plane = (frame.to_world(h), i.dot(h).clamp(0.0, 1.0));
    let decided = decide(law, m, plane, *state, power, ledger, rng);
    if !decided.reflected && !fresnel::weakly_absorbing(m.beyond.n) {
        return Fate::Absorbed;
    }
    let eta = m.beyond.n.re / m.here.n.re;
    let out = if decided.reflected { Some(reflect_about(i, h)) } else { refract_about(i, h, eta) };
    let Some(out) = out.filter(|o| if decided.reflected { o.z > 0.0 } else { o.z < 0.0 }) else {
        return Fate::Masked;
    };
    let mut seen = if decided.reflected {
        facets.reflected_weight(i, out, Masking::Separable)
    } else {
        facets.transmitted_weight(out)
    };
    if renormalised {
        seen /= facets.directional_albedo_white(i.z, Masking::Separable);
    }
    let masked: [f64; N] = std::array::from_fn(|k| power[k] * (1.0 - seen));
    for (p, x) in power.iter_mut().zip(&masked) {
        *p -= x;
    }
    add(&mut ledger.masked, &masked);
    let dir = frame.to_world(out);
    *state = State::after(decided.stokes, dir, decided.side);
    match decided.reflected {
        true => Fate::Reflected { dir, absorbed: decided.absorbed },
        false => Fate::Refracted { dir },
    }
}
