//! Rough interfaces as facets: slope distributions, masking, visible normals (physics of the paper's
//! section 2.1 and equations (11), (23)–(25)).
//!
//! A facet has the slope vector (ζx, ζy), ζ = tanθh, and the normal h ∝ (ζx, ζy, 1) in the local frame
//! whose z axis is the mean normal on the side of the incoming light. A law is an isotropic density
//! P22(ζ) of slope vectors, ∫P22 d²ζ = 1, and the density of facet area per solid angle of normals is
//! D(h) = P22(tanθh)/cos⁴θh, so that ∫D cosθh dω = 1.
//!
//! All directions here are local unit vectors: `i` points from the surface back towards the light
//! (i.z > 0), `o` points away from the surface along the outgoing light (o.z > 0 reflected,
//! o.z < 0 transmitted).
//!
//! References: Cook & Torrance, ACM TOG 1 (1982) 7, doi:10.1145/357290.357293; Walter, Marschner, Li &
//! Torrance, EGSR 2007, doi:10.2312/EGWR/EGSR07/195-206; Heitz, JCGT 3(2) (2014) 48 and 7(4) (2018) 1;
//! Dupuy & Benyoub, CGF 42 (2023), doi:10.1111/cgf.14867.

mod albedo;
mod chebyshev;
mod direction;
mod exponential;
mod gaussian;
mod ggx;
mod seed;
pub mod walk;

pub use direction::{reflect_about, refract_about};
pub use seed::{facet_slope, ring_mass, seed_eq11};

use crate::math::{DVec3, PI};
use crate::rng::Stream;
use std::sync::OnceLock;

/// Law of the facet slopes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slopes {
    /// Gaussian slopes, equation (25): P22 = exp(−ζ²/m²)/(πm²); as D it is Beckmann's law.
    Gaussian,
    /// Exponential slopes: P22 = exp(−ζ/b)/(2πb²), b = m/√6, so that ⟨ζ²⟩ = m².
    Exponential,
    /// GGX (Trowbridge & Reitz): P22 = 1/(πm²(1 + ζ²/m²)²), m = α; ⟨ζ²⟩ is infinite.
    Ggx,
}

/// How masking of the incoming and of the outgoing light go together in G2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Masking {
    /// Independent: G2 = G1(i) G1(o).
    Separable,
    /// At one height of the facet (Smith): G2 = 1/(1 + Λ(i) + Λ(o)). For reflection only.
    Correlated,
}

/// Why a rough surface cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RoughnessError {
    /// The slope is no positive number, or outside the range where directions can resolve it.
    #[error("rms slope m = {0} must lie in 1e-9 … 1000 (slope, not height in nm; 0 is the smooth interface)")]
    Slope(f64),
}

/// A rough surface: a slope law and its slope m (dimensionless).
///
/// Gaussian and exponential: m is √⟨ζ²⟩, the rms of the slope vector (the Beckmann roughness);
/// GGX: m is the width α. Accuracy: D, G1, Λ, densities to a few units in the last place times the
/// condition of exp (exponential law: Λ within 1e-12 relative).
#[derive(Clone, Debug)]
pub struct Microfacet {
    law: Slopes,
    m: f64,
    white: OnceLock<albedo::Table>,
}

impl Microfacet {
    /// Surface of law `law` and slope `m` in 1e-9 … 1000. m = 0 is the smooth interface and has no
    /// facets: it is not made here.
    pub fn new(law: Slopes, m: f64) -> Result<Self, RoughnessError> {
        if !(1e-9..=1e3).contains(&m) {
            return Err(RoughnessError::Slope(m));
        }
        Ok(Microfacet { law, m, white: OnceLock::new() })
    }

    /// The slope law.
    pub fn law(&self) -> Slopes {
        self.law
    }

    /// The slope m.
    pub fn m(&self) -> f64 {
        self.m
    }

    /// D(θh), facet area per surface area and solid angle of normals (1/sr); 0 for cosθh ≤ 0.
    ///
    /// The relative error of `cos_h` near 1 enters as Δcos/(1 − cos)·ζ²/m²: where the normal itself is
    /// known, [`Microfacet::d_at`] is better.
    pub fn d(&self, cos_h: f64) -> f64 {
        self.d_cos_sin2(cos_h, (1.0 - cos_h) * (1.0 + cos_h))
    }

    /// D at the facet normal `h` (unit), 1/sr; 0 for h.z ≤ 0.
    pub fn d_at(&self, h: DVec3) -> f64 {
        self.d_cos_sin2(h.z, h.x * h.x + h.y * h.y)
    }

    fn d_cos_sin2(&self, cos: f64, sin2: f64) -> f64 {
        if cos <= 0.0 {
            return 0.0;
        }
        match self.law {
            Slopes::Gaussian => gaussian::d(cos, sin2, self.m),
            Slopes::Exponential => exponential::d(cos, sin2, self.m),
            Slopes::Ggx => ggx::d(cos, sin2, self.m),
        }
    }

    /// Density of slope vectors P22(ζ), ∫P22 2πζ dζ = 1 (dimensionless); the height h in equation (24).
    pub fn slope_density(&self, zeta: f64) -> f64 {
        match self.law {
            Slopes::Gaussian => gaussian::slope_density(zeta * zeta, self.m),
            Slopes::Exponential => exponential::slope_density(zeta, self.m),
            Slopes::Ggx => ggx::slope_density(zeta * zeta, self.m),
        }
    }

    /// Projected area of the facets turned away from a direction, per surface area:
    /// cosθ Λ = ∫ max(0, −i·h) D dω ≥ 0.
    fn hidden_area(&self, cos: f64, sin: f64) -> f64 {
        match self.law {
            Slopes::Gaussian => gaussian::hidden_area(cos, sin, self.m),
            Slopes::Exponential => exponential::hidden_area(cos, sin, self.m),
            Slopes::Ggx => ggx::hidden_area(cos, sin, self.m),
        }
    }

    /// Projected area of the facets turned towards direction `cos` (0 ≤ cos ≤ 1), per surface area:
    /// ∫ max(0, i·h) D dω = cosθ (1 + Λ) = cosθ/G1. Finite and positive down to cos = 0.
    pub fn projected_area(&self, cos: f64) -> f64 {
        cos + self.hidden_area(cos, sine(cos))
    }

    /// Smith's Λ(θ) = (1/G1 − 1), for 0 ≤ cos ≤ 1; infinite at cos = 0.
    pub fn lambda(&self, cos: f64) -> f64 {
        self.hidden_area(cos, sine(cos)) / cos
    }

    /// Smith's masking G1(θ) = 1/(1 + Λ), the share of the facets turned towards direction `cos`
    /// (0 ≤ cos ≤ 1) that are seen from there.
    pub fn g1(&self, cos: f64) -> f64 {
        cos / self.projected_area(cos)
    }

    /// Separable masking G1(i) G1(o), for reflection and transmission (cosines taken positive).
    pub fn g2_separable(&self, cos_i: f64, cos_o: f64) -> f64 {
        self.g1(cos_i) * self.g1(cos_o)
    }

    /// Height-correlated masking 1/(1 + Λ(i) + Λ(o)), for reflection.
    pub fn g2_correlated(&self, cos_i: f64, cos_o: f64) -> f64 {
        1.0 / (1.0 + self.lambda(cos_i) + self.lambda(cos_o))
    }

    /// Density of visible normals, 1/sr: D_v(h; i) = G1(i) max(0, i·h) D(h)/cosθi; ∫D_v dω = 1.
    pub fn pdf_visible(&self, i: DVec3, h: DVec3) -> f64 {
        i.dot(h).max(0.0) * self.d_at(h) / self.area_towards(i)
    }

    /// Facet normal drawn with the density [`Microfacet::pdf_visible`], exactly at any roughness and
    /// incidence, i.z = 0 included.
    ///
    /// Gaussian and exponential: rejection in slope space, at least 1/π accepted. GGX: spherical cap of
    /// Dupuy & Benyoub 2023, no rejection.
    #[inline]
    pub fn sample_visible(&self, i: DVec3, rng: &mut Stream) -> DVec3 {
        match self.law {
            Slopes::Gaussian => gaussian::sample_visible(i, self.m, rng),
            Slopes::Exponential => exponential::sample_visible(i, self.m, rng),
            Slopes::Ggx => ggx::sample_visible(i, self.m, rng),
        }
    }

    /// Weight G2/G1(i) of a ray reflected from `i` into `o` by a facet drawn with `sample_visible`
    /// (times the facet's Fresnel reflectance); 0 where o goes into the surface (single bounce).
    #[inline]
    pub fn reflected_weight(&self, i: DVec3, o: DVec3, masking: Masking) -> f64 {
        if o.z <= 0.0 {
            return 0.0;
        }
        let hidden = self.hidden_area(o.z, tilt(o));
        match masking {
            Masking::Separable => o.z / (o.z + hidden),
            Masking::Correlated => {
                // (1 + Λi)/(1 + Λi + Λo), both sides times cosθi cosθo: finite at grazing.
                let seen = self.area_towards(i) * o.z;
                seen / (seen + i.z.max(0.0) * hidden)
            }
        }
    }

    /// Weight G2/G1(i) = G1(o) (separable) of a ray transmitted into `o` by a facet drawn with
    /// `sample_visible` (times the facet's Fresnel transmittance); 0 where o.z ≥ 0 (single bounce).
    #[inline]
    pub fn transmitted_weight(&self, o: DVec3) -> f64 {
        if o.z >= 0.0 {
            return 0.0;
        }
        -o.z / (self.hidden_area(-o.z, tilt(o)) - o.z)
    }

    /// White density of the reflected direction, 1/sr: f cosθo = D(h) G2/(4 cosθi), the Fresnel
    /// reflectance at cosθd = i·h left to the caller. Its integral over o is the directional albedo.
    pub fn reflected_density(&self, i: DVec3, o: DVec3, masking: Masking) -> f64 {
        let h = (i + o).normalize_or_zero();
        if o.z <= 0.0 || h.z <= 0.0 {
            return 0.0;
        }
        self.d_at(h) / (4.0 * self.area_towards(i)) * self.reflected_weight(i, o, masking)
    }

    /// White density of the transmitted direction, 1/sr, separable masking (Walter et al. 2007,
    /// equations 16, 17, 21): D_v(h; i) G1(o) η²|o·h|/(i·h + η o·h)², h ∝ ±(i + ηo); the Fresnel
    /// transmittance at cosθd = i·h left to the caller.
    ///
    /// `eta` = N2/N1, light goes from 1 to 2. Power density, without the factor η⁻² of radiance. At
    /// η = 1 every facet transmits straight on: no density exists and 0 is returned.
    pub fn transmitted_density(&self, i: DVec3, o: DVec3, eta: f64) -> f64 {
        let along = i + o * eta;
        let h = along.normalize_or_zero() * 1.0_f64.copysign(along.z);
        let (cos_i, cos_o) = (i.dot(h), o.dot(h));
        if o.z >= 0.0 || h.z <= 0.0 || cos_i <= 0.0 || cos_o >= 0.0 {
            return 0.0;
        }
        // |i + ηo|² = (i·h + η o·h)², as i + ηo is parallel to h.
        let jacobian = eta * eta * -cos_o / along.length_squared();
        self.pdf_visible(i, h) * jacobian * self.transmitted_weight(o)
    }

    /// Directional albedo ∫ reflected density · F dω of the single bounce, by quadrature:
    /// `reflectance(cosθd)` is the facet's Fresnel reflectance at cosθd = i·h, `cos` the incidence,
    /// 0 ≤ cos ≤ 1. Absolute error below 1e-9 for smooth F and m ≤ 1, 4e-7 at m = 2; an F with the kink
    /// of total reflection costs up to 5e-3 where m is small.
    pub fn directional_albedo(&self, cos: f64, masking: Masking, reflectance: impl Fn(f64) -> f64) -> f64 {
        let [separable, correlated] = albedo::quadrature(self, &albedo::FINE, cos, reflectance);
        match masking {
            Masking::Separable => separable,
            Masking::Correlated => correlated,
        }
    }

    /// Directional albedo of the white single bounce (F = 1): what `multiple-bounce="renormalised"`
    /// divides by. Interpolated (error below 1e-6 for m ≤ 2) in a table that is made at the first call.
    pub fn directional_albedo_white(&self, cos: f64, masking: Masking) -> f64 {
        self.white.get_or_init(|| albedo::Table::new(self)).value(cos, masking)
    }

    /// cosθi/G1(i) of a direction, its sine taken from x and y.
    fn area_towards(&self, i: DVec3) -> f64 {
        let cos = i.z.max(0.0);
        cos + self.hidden_area(cos, tilt(i))
    }
}

/// sinθ of a cosine.
fn sine(cos: f64) -> f64 {
    ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt()
}

/// sinθ of a local direction.
fn tilt(u: DVec3) -> f64 {
    (u.x * u.x + u.y * u.y).sqrt()
}

/// Unit normal of the facet with slope ζ at the azimuth (cos, sin) counted from the plane of `i`.
fn normal_of_slope(i: DVec3, zeta: f64, (cos, sin): (f64, f64)) -> DVec3 {
    let s = tilt(i);
    let (x, y) = if s > 0.0 { (i.x / s, i.y / s) } else { (1.0, 0.0) };
    let up = 1.0 / (1.0 + zeta * zeta).sqrt();
    let side = zeta * up;
    DVec3::new(side * (cos * x - sin * y), side * (cos * y + sin * x), up)
}

/// Slope and azimuth with density ∝ P22(ζ) ζ (c + sζ cosφ)₊ by rejection; c < 0 is light from below the
/// plane (walks: it goes up and meets a facet).
///
/// The majorant P22(ζ) ζ (c + sζ) is a mixture, with weights c and s⟨ζ⟩, of the law of ζ itself
/// (`plain`) and of the law weighted with ζ (`weighted`). At least 1/π of the trials is accepted (the
/// mean of cos₊ over a turn, reached at grazing incidence).
fn visible_by_rejection(
    i: DVec3,
    mean_slope: f64,
    rng: &mut Stream,
    plain: impl Fn(&mut Stream) -> f64,
    weighted: impl Fn(&mut Stream) -> f64,
) -> DVec3 {
    let (c, s) = (i.z, tilt(i));
    let most = c.max(0.0);
    loop {
        let zeta = if rng.uniform() * (most + s * mean_slope) < most { plain(rng) } else { weighted(rng) };
        let azimuth = rng.azimuth();
        if rng.uniform() * (most + s * zeta) < c + s * zeta * azimuth.0 {
            return normal_of_slope(i, zeta, azimuth);
        }
    }
}

/// 1/√π.
const FRAC_1_SQRT_PI: f64 = std::f64::consts::FRAC_2_SQRT_PI / 2.0;
/// 1/π.
const FRAC_1_PI: f64 = 1.0 / PI;

#[cfg(test)]
mod tests;
