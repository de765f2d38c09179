//! Reflection and refraction at a smooth interface (Fresnel, Snell).
//!
//! From N1 (incident side) to N2, η = N2/N1, m = µ2/µ1, the paper's (4)–(7) with N → N2/N1:
//!
//! r⊥ = (m cosθi − q)/(m cosθi + q), r∥ = (η² cosθi − m q)/(η² cosθi + m q), q² = η² − sin²θi,
//!
//! root with Re q ≥ 0, and Im q > 0 where Re q = 0. Powers are squares, R⊥ = |r⊥|², R∥ = |r∥|²,
//! R = (R⊥ + R∥)/2, T = 1 − R; the paper's (8), (9) average amplitudes, which vanishes at normal
//! incidence for every material ([`paper_amplitude_average`] keeps the variant of its figure 12).
//!
//! The differences above cancel near grazing, near index match and near R = 1. They are evaluated as
//!
//! - q² = (η − 1)(η + 1) + cos²θi with η − 1 = (N2 − N1)/N1; as η² − (1 − cosθi)(1 + cosθi) where
//!   that has the smaller terms (steep incidence from the denser medium),
//! - where the numerators nearly vanish, r⊥ = ((m² − 1) cos²θi − (η² − 1))/(m cosθi + q)² and
//!   r∥ = ((η² − 1)(η² cos²θi − sin²θi) + (1 − m²) q²)/(η² cosθi + m q)²,
//! - T⊥ = 4 m cosθi Re q/|m cosθi + q|², T∥ = 4 m cosθi Re q (|q|² + sin²θi)/|η² cosθi + m q|²,
//!   which equal 1 − |r|² identically (Re(η² q*) = Re q (|q|² + sin²θi)) and keep their relative
//!   accuracy at any angle.

use crate::math::DVec3;
use crate::math::frame::renormalise;
use num_complex::Complex64;

mod diffuse;
pub use diffuse::diffuse_reflectance;

/// Amplitudes and powers of the light that a smooth interface reflects and transmits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fresnel {
    /// Amplitude coefficient r⊥ (s).
    pub rs: Complex64,
    /// Amplitude coefficient r∥ (p), positive for real η > 1 at normal incidence.
    pub rp: Complex64,
    /// Normal component of the transmitted wave vector over the vacuum one, over N1: q.
    pub q: Complex64,
    /// Power reflectance R⊥.
    pub reflectance_s: f64,
    /// Power reflectance R∥.
    pub reflectance_p: f64,
    /// T⊥ = 1 − R⊥, with relative accuracy also where it is small.
    pub transmittance_s: f64,
    /// T∥ = 1 − R∥, with relative accuracy also where it is small.
    pub transmittance_p: f64,
}

impl Fresnel {
    /// Interface from `n1` (incident side) to `n2`, permeability ratio `mu` = µ2/µ1 (1 for all but
    /// magnetic media), cosine of the angle of incidence `cos_i` in [0, 1].
    ///
    /// Reflectances err by less than the change that 2 ulp in each input make, plus 4e-16. Equal
    /// media have no interface: r = 0 at every angle, 90° included.
    pub fn new(n1: Complex64, n2: Complex64, mu: f64, cos_i: f64) -> Self {
        let c = cos_i;
        let d = (n2 - n1) * (n2 + n1) / (n1 * n1); // η² − 1
        if d == Complex64::ZERO {
            return Self::same_index(mu, c);
        }
        let (c2, sin2, eta) = (c * c, (1.0 - c) * (1.0 + c), n2 / n1);
        let eta2 = eta * eta;
        let q = root(if eta2.norm_sqr() < 0.25 && sin2 < 0.5 { eta2 - sin2 } else { d + c2 });
        let rs = ratio(Complex64::from(mu * c), q, (mu - 1.0) * (mu + 1.0) * c2 - d);
        let (a, b) = (eta2 * c, q * mu);
        let rp = ratio(a, b, d * (eta2 * c2 - sin2) + (1.0 - mu) * (1.0 + mu) * q * q);
        let flux = 4.0 * mu * c;
        let (reflectance_s, transmittance_s) = powers(rs, flux * (q.re / (q + mu * c).norm_sqr()));
        let p = q.re * (q.norm_sqr() + sin2) / (a + b).norm_sqr();
        let (reflectance_p, transmittance_p) = powers(rp, flux * p);
        Fresnel { rs, rp, q, reflectance_s, reflectance_p, transmittance_s, transmittance_p }
    }

    /// η = 1: only the permeability differs, and nothing depends on the angle.
    fn same_index(mu: f64, cos_i: f64) -> Self {
        let r = (mu - 1.0) / (mu + 1.0);
        let t = 4.0 * mu / ((mu + 1.0) * (mu + 1.0));
        Fresnel {
            rs: Complex64::from(r),
            rp: Complex64::from(-r),
            q: Complex64::from(cos_i),
            reflectance_s: r * r,
            reflectance_p: r * r,
            transmittance_s: t,
            transmittance_p: t,
        }
    }

    /// Power reflectance of unpolarised light, R = (R⊥ + R∥)/2.
    pub fn reflectance(&self) -> f64 {
        0.5 * (self.reflectance_s + self.reflectance_p)
    }

    /// Power transmittance of unpolarised light, T = 1 − R with relative accuracy.
    pub fn transmittance(&self) -> f64 {
        0.5 * (self.transmittance_s + self.transmittance_p)
    }
}

/// (a − b)/(a + b), by way of `squares` = a² − b² where a and b nearly cancel.
fn ratio(a: Complex64, b: Complex64, squares: Complex64) -> Complex64 {
    let (difference, sum) = (a - b, a + b);
    if difference.norm_sqr() < 0.25 * sum.norm_sqr() { squares / sum / sum } else { difference / sum }
}

/// R and T from the amplitude and the flux formula of T, each from the other where that is exact.
fn powers(r: Complex64, t: f64) -> (f64, f64) {
    if t < 0.5 { (1.0 - t, t) } else { (r.norm_sqr(), 1.0 - r.norm_sqr()) }
}

/// Square root of `z` with Re ≥ 0, and Im > 0 where Re = 0; no overflow, no cancellation.
fn root(z: Complex64) -> Complex64 {
    let scale = z.re.abs().max(z.im.abs());
    if scale == 0.0 {
        return Complex64::ZERO;
    }
    let (x, y) = (z.re / scale, z.im / scale);
    let larger = (0.5 * ((x * x + y * y).sqrt() + x.abs())).sqrt() * scale.sqrt();
    let smaller = z.im.abs() / (2.0 * larger);
    if z.re >= 0.0 {
        Complex64::new(larger, smaller.copysign(z.im))
    } else {
        Complex64::new(smaller, if smaller == 0.0 { larger } else { larger.copysign(z.im) })
    }
}

/// Unpolarised light at a smooth interface, as transport needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Reflected share R of the power, exactly 1 in total reflection.
    pub r: f64,
    /// Transmitted share T = 1 − R, with relative accuracy also where it is small.
    pub t: f64,
    /// Cosine of the angle of refraction; 0 where nothing is refracted.
    pub cos_t: f64,
}

impl Dielectric {
    const TOTAL: Dielectric = Dielectric { r: 1.0, t: 0.0, cos_t: 0.0 };
}

/// Interface between two dielectrics, real indices `n1` (incident side) and `n2`, µ2 = µ1, `cos_i`
/// in [0, 1]: the fast path of transport.
///
/// T⊥ = 4ab/S², T∥ = 4 n2² ab/P² with the normal components of the wave vectors a = n1 cosθi and
/// b = n2 cosθt (Snell's law (10): b² = n2² − n1² sin²θi), S = a + b, P = n2² cosθi + n1 b. Total
/// reflection where b² ≤ 0. Equal indices: R = 0 at every angle.
#[inline]
pub fn dielectric(n1: f64, n2: f64, cos_i: f64) -> Dielectric {
    let c = cos_i;
    let d = (n2 - n1) * (n2 + n1);
    if d == 0.0 {
        return Dielectric { r: 0.0, t: 1.0, cos_t: c };
    }
    let Some(normal) = NormalComponents::new(n1, n2, c) else { return Dielectric::TOTAL };
    let NormalComponents { a, b, .. } = normal;
    let (s, p) = (1.0 / (a + b), 1.0 / (n2 * n2 * c + n1 * b));
    let t = 2.0 * a * b * (s * s + n2 * n2 * (p * p));
    let (r, t) = if t < 0.5 {
        (1.0 - t, t)
    } else {
        let rs = d * s * s;
        let rp = d * (n2 * n2 * (c * c) - n1 * n1 * ((1.0 - c) * (1.0 + c))) * p * p;
        let r = 0.5 * (rs * rs + rp * rp);
        (r, 1.0 - r)
    };
    Dielectric { r, t, cos_t: (b / n2).min(1.0) }
}

/// Normal components of the wave vectors on both sides of an interface between dielectrics, over the
/// vacuum one: a = n1 cosθi, b = n2 cosθt.
#[derive(Clone, Copy, Debug)]
pub struct NormalComponents {
    n1: f64,
    n2: f64,
    cos_i: f64,
    a: f64,
    b: f64,
}

impl NormalComponents {
    /// `None` in total reflection, b² = n2² − n1² sin²θi ≤ 0.
    #[inline]
    pub fn new(n1: f64, n2: f64, cos_i: f64) -> Option<Self> {
        let (c, a) = (cos_i, n1 * cos_i);
        // The form with the smaller terms: a choice of values, not of ways.
        let small = n2 * n2 - n1 * n1 * ((1.0 - c) * (1.0 + c));
        let large = (n2 - n1) * (n2 + n1) + a * a;
        let b2 = if n2 * n2 < 0.5 * (n1 * n1) { small } else { large };
        (b2 > 0.0).then(|| NormalComponents { n1, n2, cos_i, a, b: b2.sqrt() })
    }

    /// Whether `u`, uniform on [0, 1), falls on the transmitted share, u < T, multiplied out: a draw
    /// does not wait for a division.
    #[inline]
    pub fn transmits(&self, u: f64) -> bool {
        let &NormalComponents { n1, n2, cos_i, a, b } = self;
        let (s, p) = (a + b, n2 * n2 * cos_i + n1 * b);
        let (s2, p2) = (s * s, p * p);
        u * (s2 * p2) < 2.0 * a * b * (p2 + n2 * n2 * s2)
    }

    /// Direction of the refracted ray: (n1 u + (a − b) n)/n2, unit where `dir` and `normal` (against the
    /// ray) are.
    #[inline]
    pub fn refract(&self, dir: DVec3, normal: DVec3) -> DVec3 {
        (dir * self.n1 + normal * (self.a - self.b)) * (1.0 / self.n2)
    }
}

/// κ/n below which the incident medium counts as transparent at an interface (its absorption along
/// the path stays); the error in R and in the angle is of this order.
pub const WEAK_ABSORPTION: f64 = 1e-3;

/// True where the medium counts as transparent at an interface: κ < 1e-3 n.
pub fn weakly_absorbing(n: Complex64) -> bool {
    n.im < WEAK_ABSORPTION * n.re
}

/// Interface between any two media, unpolarised light, µ2 = µ1.
///
/// A weakly absorbing incident medium is treated as real ([`weakly_absorbing`]); two real indices
/// take [`dielectric`]; else the complex formulas with the real angle of
/// [`refraction_angle_absorbing`]. Out of a strongly absorbing medium beyond the critical angle the
/// transmitted wave has no real direction: then `cos_t` = 0 while `t` > 0, and `t` is absorbed at
/// the interface.
pub fn interface(n1: Complex64, n2: Complex64, cos_i: f64) -> Dielectric {
    let n1 = if weakly_absorbing(n1) { Complex64::from(n1.re) } else { n1 };
    if n1.im == 0.0 && n2.im == 0.0 {
        return dielectric(n1.re, n2.re, cos_i);
    }
    let f = Fresnel::new(n1, n2, 1.0, cos_i);
    let kz = n1 * f.q;
    let evanescent = kz.im < -kz.re;
    let cos_t = if evanescent { 0.0 } else { phase_cosine(kz.re, n1.re, cos_i) };
    Dielectric { r: f.reflectance(), t: f.transmittance(), cos_t }
}

/// Cosine of the real angle of refraction from a transparent medium `n1` into an absorbing one
/// `n2`: the angle between the normal and that of the planes of constant phase, tan ψ =
/// sinθi/Re q (Born & Wolf, Principles of Optics, 7th ed., §14.2). For real `n2` Snell's law, with
/// 0 in total reflection.
pub fn refraction_angle_absorbing(n1: f64, n2: Complex64, cos_i: f64) -> f64 {
    phase_cosine(Fresnel::new(n1.into(), n2, 1.0, cos_i).q.re, 1.0, cos_i)
}

/// Cosine of the direction with normal component `kz` and tangential component `n1` sinθi.
fn phase_cosine(kz: f64, n1: f64, cos_i: f64) -> f64 {
    let k2 = kz * kz + n1 * n1 * (1.0 - cos_i) * (1.0 + cos_i);
    if k2 > 0.0 { (kz / k2.sqrt()).clamp(0.0, 1.0) } else { cos_i }
}

/// Direction of the refracted ray: `dir` and `normal` unit, `normal` against the ray,
/// dir·normal = −cosθi, `eta` = n2/n1. u/η + n (cosθi/η − cosθt), renormalised. Into an absorbing
/// medium hand in the real ratio sinθi/sinθt for `eta` ([`refract_at`] needs none).
#[inline]
pub fn refract(dir: DVec3, normal: DVec3, cos_i: f64, cos_t: f64, eta: f64) -> DVec3 {
    let inverse = 1.0 / eta;
    renormalise(dir * inverse + normal * (inverse * cos_i - cos_t))
}

/// Direction of the refracted ray from the cosine `cos_t` of its angle alone: in the plane of
/// incidence, whatever the media (Snell's law or [`refraction_angle_absorbing`]). A cosine knows its
/// sine to ε/sinθt only; between dielectrics [`refract`] is exact to rounding.
pub fn refract_at(dir: DVec3, normal: DVec3, cos_t: f64) -> DVec3 {
    let side = dir - normal * dir.dot(normal);
    let sin_i2 = side.length_squared();
    if sin_i2 == 0.0 {
        return -normal;
    }
    let sin_t = ((1.0 - cos_t) * (1.0 + cos_t)).max(0.0).sqrt();
    renormalise(side * (sin_t / sin_i2.sqrt()) - normal * cos_t)
}

/// Direction of the reflected ray, u − 2 (u·n) n, renormalised.
#[inline]
pub fn reflect(dir: DVec3, normal: DVec3) -> DVec3 {
    renormalise(dir - normal * (2.0 * dir.dot(normal)))
}

/// What the paper's figures 12 and 13 show in place of the reflectance: the mean of the amplitudes
/// (|r⊥| + |r∥|)/2 without the squares. For copper it is too high by 0.21 (300–500 nm) and 0.04
/// (600–700 nm), which is the paper's own observation. For reproducing those figures only.
pub fn paper_amplitude_average(n1: Complex64, n2: Complex64, cos_i: f64) -> f64 {
    let f = Fresnel::new(n1, n2, 1.0, cos_i);
    0.5 * (f.reflectance_s.sqrt() + f.reflectance_p.sqrt())
}

#[cfg(test)]
mod tests;
