//! Directions after a facet (local frame; `i` from the surface towards the light, `h` the facet normal
//! on the side of i).

use crate::math::{DVec3, frame::renormalise};

/// Mirror direction about the facet normal: o = 2(i·h)h − i.
#[inline]
pub fn reflect_about(i: DVec3, h: DVec3) -> DVec3 {
    renormalise(h * (2.0 * i.dot(h)) - i)
}

/// Direction refracted at the facet (Walter et al. 2007, equation 40): with c = i·h > 0 and η = N2/N1
/// o = (c/η − cosθt) h − i/η, cosθt = √((η−1)(η+1) + c²)/η; `None` at total reflection.
#[inline]
pub fn refract_about(i: DVec3, h: DVec3, eta: f64) -> Option<DVec3> {
    let c = i.dot(h);
    let q2 = (eta - 1.0) * (eta + 1.0) + c * c;
    (q2 >= 0.0).then(|| renormalise((h * (c - q2.sqrt()) - i) / eta))
}
