//! GGX (Trowbridge & Reitz 1975; Walter et al. 2007): P22(ζ) = 1/(πm²(1 + ζ²/m²)²), m = α,
//! D = m²/(π (sin²θ + m² cos²θ)²), Λ = (√(1 + m² tan²θ) − 1)/2. ⟨ζ⟩ = πm/2, ⟨ζ²⟩ = ∞.

use super::FRAC_1_PI;
use crate::math::DVec3;
use crate::rng::Stream;

/// P22 at ζ².
pub(super) fn slope_density(zeta2: f64, m: f64) -> f64 {
    let r = m / (m * m + zeta2);
    FRAC_1_PI * r * r
}

/// D at cosθ > 0.
pub(super) fn d(cos: f64, sin2: f64, m: f64) -> f64 {
    let stretched = m * cos;
    let r = m / (sin2 + stretched * stretched);
    FRAC_1_PI * r * r
}

/// cosθ Λ = (√(cos² + m² sin²) − cos)/2, without cancellation.
#[inline]
pub(super) fn hidden_area(cos: f64, sin: f64, m: f64) -> f64 {
    let ms2 = m * m * sin * sin;
    if ms2 == 0.0 { 0.0 } else { 0.5 * ms2 / ((cos * cos + ms2).sqrt() + cos) }
}

/// Visible normal. Stretching by m turns the surface into a hemisphere, whose visible normals are the
/// half vectors between the stretched direction w and a direction uniform on the cap z > −w.z
/// (Dupuy & Benyoub 2023).
#[inline]
pub(super) fn sample_visible(i: DVec3, m: f64, rng: &mut Stream) -> DVec3 {
    let w = DVec3::new(m * i.x, m * i.y, i.z.max(0.0)).normalize();
    let (cos, sin) = rng.azimuth();
    // u in (0, 1]: h.z = z + w.z = u (1 + w.z) > 0.
    let up = rng.uniform_positive() * (1.0 + w.z);
    let z = up - w.z;
    let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
    DVec3::new(m * (r * cos + w.x), m * (r * sin + w.y), up).normalize()
}
