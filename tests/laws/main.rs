//! Every law's sampler, density, distribution function and moments held together, and the statistics
//! that judge them held to their own error rates.

// The standard library's functions serve as the independent reference.
#![allow(clippy::disallowed_methods)]

mod orientations;
mod reference;
mod sizes;
mod statistics;

use lightpro::rng::{Purpose, Stream};

/// A stream for test number `k`.
fn stream(k: u64) -> Stream {
    Stream::of(20_260_101, 0, k, Purpose::Probe)
}

/// ∫ f over [a, b] by tanh-sinh quadrature, which bears singular ends; `f` gets x.
fn integrate(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let h = 1.0 / 64.0;
    let mut sum = 0.0;
    for i in -400..=400 {
        let t = h * f64::from(i);
        let u = std::f64::consts::FRAC_PI_2 * t.sinh();
        // Distance to the nearer end as a share of the width, without cancellation.
        let share = 1.0 / (1.0 + (2.0 * u.abs()).exp());
        let x = if u < 0.0 { a + (b - a) * share } else { b - (b - a) * share };
        let w = 0.5 * (b - a) * std::f64::consts::FRAC_PI_2 * t.cosh() / (u.cosh() * u.cosh());
        if w > 0.0 && x > a && x < b {
            sum += w * f(x);
        }
    }
    sum * h
}

/// ∫ f over [a, ∞), a > 0.
fn integrate_up(a: f64, f: impl Fn(f64) -> f64) -> f64 {
    integrate(0.0, 1.0, |t| {
        let v = f(a / t) * a / (t * t);
        if v.is_finite() { v } else { 0.0 }
    })
}
