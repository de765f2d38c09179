//! The paper's own facet formulas, equations (11), (23) and (24).

use crate::math::{FRAC_PI_2, PI, cos, exp, sin, tan};

/// Slope of the facet that reflects light from polar angle `theta_i` into the patch (`theta_p`,
/// `phi_p`), equation (23):
/// ζ = √(sin²θi − 2 sinθi sinθp cosφp + sin²θp)/(cosθi + cosθp) = tanθh of the half vector.
/// Angles in rad; φp = 0 is the specular side. Formed as √((sinθi − sinθp)² + 4 sinθi sinθp sin²(φp/2)),
/// which keeps small slopes.
pub fn facet_slope(theta_i: f64, theta_p: f64, phi_p: f64) -> f64 {
    let (si, sp) = (sin(theta_i), sin(theta_p));
    // sinθi − sinθp as a product.
    let difference = 2.0 * cos(0.5 * (theta_i + theta_p)) * sin(0.5 * (theta_i - theta_p));
    let turn = sin(0.5 * phi_p);
    let projected2 = difference * difference + 4.0 * si * sp * turn * turn;
    projected2.max(0.0).sqrt() / (cos(theta_i) + cos(theta_p))
}

/// Mass of the whole ring of slopes at ζ, equation (24): p(ζ) = 2πζ h Δζ with h the height P22(ζ). It is
/// no share of a patch: that follows from the density with its Jacobian 1/(4 cosθd).
pub fn ring_mass(zeta: f64, height: f64, width: f64) -> f64 {
    2.0 * PI * zeta * height * width
}

/// The paper's Beckmann function as printed, equation (11): exp(−tan²θ/m²)/(4m² cos²θ), θ in rad. Not
/// normalised (∫D cosθ dω = 0.785 … 0.468 for m = 0 … 1): for comparison with the paper only.
pub fn seed_eq11(theta: f64, m: f64) -> f64 {
    if theta.abs() >= FRAC_PI_2 {
        return 0.0;
    }
    let (t, c) = (tan(theta) / m, cos(theta));
    exp(-t * t) / (4.0 * m * m * c * c)
}
