//! Surface events: the power that meets an interface is reflected or refracted, smooth, Lambertian or
//! by microfacets, by the continuous law or over the patches of a SAP.

use super::ledger::{Ledger, add};
use super::light::Medium;
use crate::material::film::Airy;
use crate::material::fresnel::{self, NormalComponents};
use crate::math::frame::renormalise;
use crate::math::{DVec3, Frame};
use crate::microfacet::{Masking, Microfacet, reflect_about, refract_about};
use crate::rng::Stream;
use crate::universe::Interface;
use num_complex::Complex64;

/// An interface as a ray meets it.
#[derive(Clone, Copy, Debug)]
pub struct Meeting<'a, const N: usize> {
    /// Direction of the ray.
    pub dir: DVec3,
    /// Geometry.
    pub at: &'a Interface,
    /// Medium of the ray.
    pub here: &'a Medium<N>,
    /// Medium on the other side.
    pub beyond: &'a Medium<N>,
}

impl<const N: usize> Meeting<'_, N> {
    /// Cosine of the angle of incidence; rounding at grazing incidence never makes it negative.
    #[inline]
    pub fn cos_i(&self) -> f64 {
        (-self.dir.dot(self.at.normal)).clamp(0.0, 1.0)
    }
}

/// What becomes of the ray.
#[derive(Clone, Copy, Debug)]
pub enum Fate<const N: usize> {
    /// Back into its own medium; at opaque surfaces part of the power stayed there.
    Reflected {
        /// New direction.
        dir: DVec3,
        /// Power absorbed at the surface.
        absorbed: Option<[f64; N]>,
    },
    /// Into the medium beyond.
    Refracted {
        /// New direction.
        dir: DVec3,
    },
    /// Into an absorber that has no real direction for it.
    Absorbed,
    /// Masked or shadowed by other facets.
    Masked,
}

/// Reflected share of the power.
#[derive(Clone, Debug)]
pub enum Ratio<const N: usize> {
    /// Power reflectance after Fresnel, unpolarised.
    Fresnel,
    /// The paper's (8), (9) and figure 12: |r| in place of |r|².
    PaperAmplitude,
    /// The same at every angle, by lane.
    Constant([f64; N]),
    /// Fresnel with a thin film between: its real index, and its thickness in vacuum wavelengths by lane.
    Film {
        /// Index.
        index: f64,
        /// Thickness over wavelength.
        thickness: [f64; N],
    },
    /// Over the angle of incidence: per lane a table on equal steps of θ from 0 to π/2.
    Angle(Vec<[f64; N]>),
}

/// Directions.
#[derive(Debug)]
pub enum Directions {
    /// Specular.
    Smooth,
    /// Equal radiance about the normal.
    Lambertian,
    /// Equal power per solid angle about the normal (the paper's words, taken literally).
    PerPatch,
    /// Microfacets, with their treatment of masked power.
    Facets {
        /// Law of the slopes.
        law: Microfacet,
        /// Divide by the white directional albedo.
        renormalised: bool,
    },
    /// Microfacets with all bounces between them.
    Walk(Microfacet),
}

/// Law of a surface at the wavelengths of a group.
#[derive(Debug)]
pub struct SurfaceLaw<const N: usize> {
    /// Directions.
    pub directions: Directions,
    /// Reflected share.
    pub ratio: Ratio<N>,
    /// What is not reflected is absorbed at the surface.
    pub opaque: bool,
    /// Sphere Area Partitioning; `None`: the continuous law.
    pub sap: Option<super::patches::SurfaceSap>,
}

impl<const N: usize> Default for SurfaceLaw<N> {
    fn default() -> Self {
        SurfaceLaw { directions: Directions::Smooth, ratio: Ratio::Fresnel, opaque: false, sap: None }
    }
}

impl<const N: usize> SurfaceLaw<N> {
    /// Equal indices at a smooth surface without a law of its own: no event, no random number.
    #[inline]
    pub fn transparent(&self, here: &Medium<N>, beyond: &Medium<N>) -> bool {
        here.n == beyond.n && self.plain()
    }

    /// Smooth, after Fresnel, nothing absorbed at the surface.
    #[inline]
    fn plain(&self) -> bool {
        matches!((&self.directions, &self.ratio, self.opaque), (Directions::Smooth, Ratio::Fresnel, false))
    }

    /// The reflected share differs between lanes and decides which way rays go.
    pub fn varies(&self) -> bool {
        let differ = |r: &[f64; N]| r.iter().any(|x| *x != r[0]);
        !self.opaque
            && match &self.ratio {
                Ratio::Fresnel | Ratio::PaperAmplitude => false,
                Ratio::Constant(r) => differ(r),
                Ratio::Film { thickness, .. } => differ(thickness),
                Ratio::Angle(rows) => rows.iter().any(differ),
            }
    }

    /// Reflected share by lane at the mean plane.
    pub fn reflectance(&self, here: &Medium<N>, beyond: &Medium<N>, cos_i: f64) -> [f64; N] {
        match &self.ratio {
            Ratio::Fresnel => [fresnel_power(here, beyond, cos_i); N],
            Ratio::PaperAmplitude => {
                [fresnel::paper_amplitude_average(here.n, beyond.n, cos_i).clamp(0.0, 1.0); N]
            }
            Ratio::Constant(r) => *r,
            Ratio::Film { index, thickness } => {
                let mut r = [0.0; N];
                for k in 0..N {
                    // Lanes in use differ; those that are not repeat the last.
                    r[k] = if k > 0 && thickness[k] == thickness[k - 1] {
                        r[k - 1]
                    } else {
                        film(here.n, *index, beyond.n, thickness[k], cos_i).reflectance().clamp(0.0, 1.0)
                    };
                }
                r
            }
            Ratio::Angle(table) => interpolated(table, crate::math::acos(cos_i)),
        }
    }

    /// Draws one outgoing ray. The share of an opaque surface is carried as weight; elsewhere the
    /// reflected share (equal in all lanes) decides between the two sides.
    #[inline(always)]
    pub fn draw(
        &self,
        m: &Meeting<N>,
        power: &mut [f64; N],
        ledger: &mut Ledger<N>,
        rng: &mut Stream,
    ) -> Fate<N> {
        if self.plain() && m.here.real && m.beyond.real {
            return smooth_dielectric(m, rng);
        }
        self.draw_other(m, power, ledger, rng)
    }

    /// Out of the way of the commonest event.
    #[inline(never)]
    fn draw_other(
        &self,
        m: &Meeting<N>,
        power: &mut [f64; N],
        ledger: &mut Ledger<N>,
        rng: &mut Stream,
    ) -> Fate<N> {
        match &self.directions {
            Directions::Facets { law, renormalised } if self.sap.is_none() => {
                self.facet(law, *renormalised, m, power, ledger, rng)
            }
            Directions::Walk(facets) => super::walk::draw(self, facets, m, power, ledger, rng),
            _ => self.mean_plane(m, power, ledger, rng),
        }
    }

    /// Surfaces whose reflected share is that of the mean plane: smooth, Lambertian, SAPs.
    fn mean_plane(
        &self,
        m: &Meeting<N>,
        power: &mut [f64; N],
        ledger: &mut Ledger<N>,
        rng: &mut Stream,
    ) -> Fate<N> {
        if let Some(sap) = &self.sap
            && sap.is_resolved()
        {
            return sap.draw_resolved(self, m, power, ledger, rng);
        }
        let r = self.reflectance(m.here, m.beyond, m.cos_i());
        if self.opaque {
            let absorbed = keep(power, &r, ledger);
            return Fate::Reflected { dir: self.reflected_direction(m, rng), absorbed: Some(absorbed) };
        }
        if r[0] >= 1.0 || rng.uniform() < r[0] {
            return Fate::Reflected { dir: self.reflected_direction(m, rng), absorbed: None };
        }
        match self.refracted_direction(m, rng) {
            Some(dir) => Fate::Refracted { dir },
            None => Fate::Absorbed,
        }
    }

    /// A direction of the reflected side.
    pub fn reflected_direction(&self, m: &Meeting<N>, rng: &mut Stream) -> DVec3 {
        let n = m.at.normal;
        let dir = match (&self.sap, &self.directions) {
            (Some(sap), _) => sap.draw_reflected(self, m, rng),
            (None, Directions::Lambertian) => lambertian(n, rng),
            (None, Directions::PerPatch) => hemisphere(n, rng),
            _ => fresnel::reflect(m.dir, n),
        };
        right_side(dir, m.at.facet)
    }

    /// A direction beyond; `None` where no real one exists (out of an absorber past the critical angle).
    pub fn refracted_direction(&self, m: &Meeting<N>, rng: &mut Stream) -> Option<DVec3> {
        let n = m.at.normal;
        let dir = match (&self.sap, &self.directions) {
            (Some(sap), _) => sap.draw_refracted(self, m, rng)?,
            (None, Directions::Lambertian) => lambertian(-n, rng),
            (None, Directions::PerPatch) => hemisphere(-n, rng),
            _ => snell(m)?,
        };
        Some(right_side(dir, -m.at.facet))
    }

    /// Continuous microfacet law: a visible facet is drawn, it reflects or refracts, and what other
    /// facets mask is taken off the power.
    fn facet(
        &self,
        law: &Microfacet,
        renormalised: bool,
        m: &Meeting<N>,
        power: &mut [f64; N],
        ledger: &mut Ledger<N>,
        rng: &mut Stream,
    ) -> Fate<N> {
        let frame = Frame::with_x_toward(m.at.normal, m.at.axis);
        let i = frame.to_local(-m.dir);
        let i = DVec3::new(i.x, i.y, i.z.max(0.0));
        let h = law.sample_visible(i, rng);
        let (out, fate) = self.at_facet(m, &frame, i, h, power, ledger, rng);
        let Some(out) = out else { return fate };
        let mut seen = if out.z > 0.0 {
            law.reflected_weight(i, out, Masking::Separable)
        } else {
            law.transmitted_weight(out)
        };
        if renormalised {
            seen /= law.directional_albedo_white(i.z, Masking::Separable);
        }
        let before = *power;
        for (p, b) in power.iter_mut().zip(&before) {
            *p = b * seen;
        }
        let masked: [f64; N] = std::array::from_fn(|k| before[k] - power[k]);
        add(&mut ledger.masked, &masked);
        fate
    }

    /// Fate at the facet `h` (local frame): Fresnel at the facet's own angle of incidence decides, and
    /// the local outgoing direction is returned with it (none where the facet is masked).
    #[allow(clippy::too_many_arguments)]
    fn at_facet(
        &self,
        m: &Meeting<N>,
        frame: &Frame,
        i: DVec3,
        h: DVec3,
        power: &mut [f64; N],
        ledger: &mut Ledger<N>,
        rng: &mut Stream,
    ) -> (Option<DVec3>, Fate<N>) {
        let cos_d = i.dot(h).clamp(0.0, 1.0);
        let r = self.reflectance(m.here, m.beyond, cos_d);
        let mut absorbed = None;
        let reflected = if self.opaque {
            absorbed = Some(keep(power, &r, ledger));
            true
        } else {
            r[0] >= 1.0 || rng.uniform() < r[0]
        };
        if !reflected && !fresnel::weakly_absorbing(m.beyond.n) {
            // What enters a facet of a metal stays in it, whichever way the facet leans.
            return (None, Fate::Absorbed);
        }
        let eta = m.beyond.n.re / m.here.n.re;
        let out = if reflected { Some(reflect_about(i, h)) } else { refract_about(i, h, eta) };
        let Some(out) = out.filter(|o| if reflected { o.z > 0.0 } else { o.z < 0.0 }) else {
            return (None, Fate::Masked);
        };
        let dir = frame.to_world(out);
        let fate = if reflected { Fate::Reflected { dir, absorbed } } else { Fate::Refracted { dir } };
        (Some(out), fate)
    }

    /// Fate of a resolved patch: `out` is the reflected direction that the patch stands for, its half
    /// vector with `i` the facet.
    #[allow(clippy::too_many_arguments)]
    pub fn by_half_vector(
        &self,
        m: &Meeting<N>,
        frame: &Frame,
        i: DVec3,
        out: DVec3,
        power: &mut [f64; N],
        ledger: &mut Ledger<N>,
        rng: &mut Stream,
    ) -> Fate<N> {
        let h = (i + out).normalize_or(DVec3::Z);
        let (local, fate) = self.at_facet(m, frame, i, h, power, ledger, rng);
        match (local, fate) {
            (Some(_), Fate::Reflected { absorbed, .. }) => {
                Fate::Reflected { dir: frame.to_world(out), absorbed }
            }
            (_, fate) => fate,
        }
    }
}

/// The commonest event: two transparent media, a smooth surface.
///
/// The rounding error of the direction's length is taken off before the normal is known, when nothing
/// waits for it. All that follows uses that direction, the cosine too: a cosine of the raw direction
/// would hand its error on fourfold, and it would grow from reflection to reflection.
#[inline(always)]
fn smooth_dielectric<const N: usize>(m: &Meeting<N>, rng: &mut Stream) -> Fate<N> {
    let dir = renormalise(m.dir);
    let n = m.at.normal;
    let cos_i = (-dir.dot(n)).clamp(0.0, 1.0);
    if let Some(met) = NormalComponents::new(m.here.n.re, m.beyond.n.re, cos_i)
        && met.transmits(rng.uniform())
    {
        return Fate::Refracted { dir: right_side(met.refract(dir, n), -m.at.facet) };
    }
    Fate::Reflected { dir: right_side(dir + n * (2.0 * cos_i), m.at.facet), absorbed: None }
}

/// Keeps the reflected share of an opaque surface; returns what it absorbs.
#[inline]
pub(super) fn keep<const N: usize>(power: &mut [f64; N], r: &[f64; N], ledger: &mut Ledger<N>) -> [f64; N] {
    let mut absorbed = [0.0; N];
    for i in 0..N {
        let kept = power[i] * r[i];
        absorbed[i] = power[i] - kept;
        power[i] = kept;
    }
    add(&mut ledger.absorbed, &absorbed);
    absorbed
}

/// Unpolarised power reflectance between two media, complex where one absorbs.
#[inline]
pub fn fresnel_power<const N: usize>(here: &Medium<N>, beyond: &Medium<N>, cos_i: f64) -> f64 {
    fresnel::interface(here.n, beyond.n, cos_i).r.clamp(0.0, 1.0)
}

/// A thin film of real index between two media; a weakly absorbing incident medium counts as real.
pub(super) fn film(n1: Complex64, index: f64, n2: Complex64, thickness: f64, cos_i: f64) -> Airy {
    let n1 = if fresnel::weakly_absorbing(n1) { Complex64::from(n1.re) } else { n1 };
    Airy::new(n1, Complex64::from(index), n2, thickness, cos_i)
}

/// Refracted direction after Snell; into an absorber by the planes of constant phase.
pub fn snell<const N: usize>(m: &Meeting<N>) -> Option<DVec3> {
    let cos_i = m.cos_i();
    let met = fresnel::interface(m.here.n, m.beyond.n, cos_i);
    if met.cos_t <= 0.0 {
        return None;
    }
    Some(if m.beyond.real && fresnel::weakly_absorbing(m.here.n) {
        fresnel::refract(m.dir, m.at.normal, cos_i, met.cos_t, m.beyond.n.re / m.here.n.re)
    } else {
        fresnel::refract_at(m.dir, m.at.normal, met.cos_t)
    })
}

/// Cosine-weighted direction about `n`.
#[inline]
pub fn lambertian(n: DVec3, rng: &mut Stream) -> DVec3 {
    let u = rng.uniform();
    let (cos, sin) = rng.azimuth();
    let r = u.sqrt();
    let (x, y) = crate::math::orthonormal(n);
    crate::math::frame::renormalise(x * (r * cos) + y * (r * sin) + n * (1.0 - u).sqrt())
}

/// Uniform direction on the hemisphere about `n`.
fn hemisphere(n: DVec3, rng: &mut Stream) -> DVec3 {
    let z = rng.uniform_positive();
    let (cos, sin) = rng.azimuth();
    let r = ((1.0 - z) * (1.0 + z)).sqrt();
    let (x, y) = crate::math::orthonormal(n);
    crate::math::frame::renormalise(x * (r * cos) + y * (r * sin) + n * z)
}

/// A direction on the wrong side of the true face is mirrored about it.
#[inline]
pub(super) fn right_side(dir: DVec3, facet: DVec3) -> DVec3 {
    let c = dir.dot(facet);
    if c < 0.0 { dir - facet * (2.0 * c) } else { dir }
}

/// Linear interpolation in a table on equal steps of θ from 0 to π/2.
fn interpolated<const N: usize>(table: &[[f64; N]], theta: f64) -> [f64; N] {
    let x = theta / crate::math::FRAC_PI_2 * (table.len() - 1) as f64;
    let i = (x as usize).min(table.len() - 2);
    let f = x - i as f64;
    std::array::from_fn(|k| table[i][k] + f * (table[i + 1][k] - table[i][k]))
}

#[cfg(test)]
mod tests;
