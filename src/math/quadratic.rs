//! Line against quadric, without cancellation.

/// Roots t₁ ≤ t₂ of |o + t d|² = 1 in a space where the body is the unit ball (of any dimension
/// whose inner products are given), or `None` if the line misses.
///
/// `dd` = d·d, `od` = o·d, and `oo_minus` must be the caller's |o + t* d|² at the closest approach
/// t* = −od/dd, computed from the moved point itself: the half chord √((1 − |p|²)/dd) is then free
/// of the cancellation that b² − 4ac suffers far from the body (relative error ~1e-16·distance
/// instead of its square).
#[inline]
pub fn ball_roots(dd: f64, od: f64, closest2: f64) -> Option<(f64, f64)> {
    let room = 1.0 - closest2;
    if room <= 0.0 || dd <= 0.0 {
        return None;
    }
    let inverse = 1.0 / dd;
    let mid = -od * inverse;
    let half = (room * inverse).sqrt();
    Some((mid - half, mid + half))
}
