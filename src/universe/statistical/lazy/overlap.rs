//! Whether two convex bodies overlap (overlap rule `forbid`).

use crate::math::DVec3;
use crate::universe::statistical::section::Body;

/// Largest number of support points asked for; bodies that it cannot tell apart count as overlapping.
const STEPS: u32 = 64;

/// Whether two bodies have a common point.
///
/// Two unbounded cylinders with axes a₁, a₂ overlap exactly if their shadows on n = a₁ × a₂ do. Others
/// are told apart by a separating direction, found by Gilbert's method of the point of the Minkowski
/// difference next to the origin (Gilbert 1966, SIAM J. Control 4, 61), for unbounded fibres in the plane
/// across their axis.
pub fn overlap(a: &Body, b: &Body) -> bool {
    let between = b.centre - a.centre;
    let (ua, ub) = (unbounded(a), unbounded(b));
    if let (Some(x), Some(y)) = (ua, ub) {
        let n = x.cross(y);
        let length = n.length();
        if length > 1e-9 {
            let n = n / length;
            return between.dot(n).abs() < reach(a, n) + reach(b, n);
        }
    }
    let across = |v: DVec3| match ua.or(ub) {
        Some(axis) => v - axis * v.dot(axis),
        None => v,
    };
    let mut nearest = across(between);
    for _ in 0..STEPS {
        let length = nearest.length();
        if length < 1e-12 {
            return true;
        }
        let n = nearest / length;
        // The point of b − a farthest towards the origin as seen from `nearest`.
        let s = across(between - support(b, n) - support(a, n));
        if s.dot(n) > 0.0 {
            return false;
        }
        let edge = s - nearest;
        let t = (-nearest.dot(edge) / edge.length_squared().max(1e-300)).clamp(0.0, 1.0);
        nearest += edge * t;
    }
    true
}

/// Axis of an unbounded body.
fn unbounded(b: &Body) -> Option<DVec3> {
    (b.outer.c.is_infinite() && b.ends.is_infinite()).then_some(b.frame.z)
}

/// The point of a body, from its centre, that lies farthest along `n`; its axial part is left out for
/// unbounded bodies.
fn support(b: &Body, n: DVec3) -> DVec3 {
    let l = b.frame.to_local(n);
    let h = &b.outer;
    let (x, y) = (h.a * h.a * l.x, h.b * h.b * l.y);
    if h.c.is_finite() {
        let z = h.c * h.c * l.z;
        let length = (x * l.x + y * l.y + z * l.z).sqrt();
        return b.frame.to_world(DVec3::new(x, y, z)) / length;
    }
    let length = (x * l.x + y * l.y).sqrt().max(1e-300);
    let z = if b.ends.is_finite() { b.ends.copysign(l.z) } else { 0.0 };
    b.frame.to_world(DVec3::new(x / length, y / length, z))
}

/// How far a body reaches along `n` from its centre.
fn reach(b: &Body, n: DVec3) -> f64 {
    support(b, n).dot(n)
}
