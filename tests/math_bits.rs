//! The bits of every elementary function over a million arguments: the same on every machine and for
//! every instruction set. A changed hash is a value-breaking change.
#![allow(missing_docs)]

use lightpro::math::{self, fast};
use lightpro::rng::{Purpose, Stream};

/// 64-bit FNV-1a over the bits of results.
fn hash(h: u64, x: f64) -> u64 {
    // All NaN are one: their payload is no result.
    let bits = if x.is_nan() { u64::MAX } else { x.to_bits() };
    bits.to_le_bytes().iter().fold(h, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
}

/// A million arguments: two thirds spread over [low, high], one third over all magnitudes in it.
fn over(low: f64, high: f64, f: impl Fn(f64) -> f64) -> u64 {
    let mut rng = Stream::of(20_261_122, 0, 0, Purpose::Probe);
    let mut h = 0xcbf2_9ce4_8422_2325;
    for i in 0..1_000_000 {
        let x = low + (high - low) * rng.uniform();
        let x = if i % 3 == 0 { x * f64::from_bits((1023 - (rng.bits() % 60)) << 52) } else { x };
        h = hash(h, f(x.clamp(low, high)));
    }
    h
}

#[test]
fn every_function_has_its_bits() {
    let got = [
        ("ln", over(1e-300, 1e6, math::ln)),
        ("ln_1p", over(-0.999, 10.0, math::ln_1p)),
        ("exp", over(-700.0, 700.0, math::exp)),
        ("expm1", over(-40.0, 40.0, math::expm1)),
        ("sin", over(-1e3, 1e3, math::sin)),
        ("cos", over(-1e3, 1e3, math::cos)),
        ("tan", over(-1e3, 1e3, math::tan)),
        ("asin", over(-1.0, 1.0, math::asin)),
        ("acos", over(-1.0, 1.0, math::acos)),
        ("atan", over(-1e6, 1e6, math::atan)),
        ("atan2", over(-1.0, 1.0, |x| math::atan2(x, 0.3 - x))),
        ("sinh", over(-20.0, 20.0, math::sinh)),
        ("cosh", over(-20.0, 20.0, math::cosh)),
        ("tanh", over(-20.0, 20.0, math::tanh)),
        ("pow", over(1e-9, 1e3, |x| math::pow(x, 1.7))),
        ("cbrt", over(-1e9, 1e9, math::cbrt)),
        ("log10", over(1e-300, 1e9, math::log10)),
        ("erf", over(-6.0, 6.0, math::erf)),
        ("erfc", over(-6.0, 26.0, math::erfc)),
        ("ln_gamma", over(1e-3, 170.0, math::ln_gamma)),
        ("bessel_i0", over(0.0, 30.0, math::bessel_i0)),
        ("bessel_k1", over(1e-3, 30.0, math::bessel_k1)),
        ("fast::ln", over(1e-16, 1.0, fast::ln)),
        ("fast::exp", over(-700.0, 0.0, fast::exp)),
        ("fast::one_minus_exp_neg", over(0.0, 60.0, fast::one_minus_exp_neg)),
        (
            "fast::one_minus_exp_neg_each",
            over(0.0, 60.0, |t| {
                let each = fast::one_minus_exp_neg_each(&[t, 0.5 * t, 2.0 * t]);
                each[0] + each[1] + each[2]
            }),
        ),
        (
            "fast::cos_sin_eighth",
            over(-std::f64::consts::FRAC_PI_4, std::f64::consts::FRAC_PI_4, |x| {
                let (c, s) = fast::cos_sin_eighth(x);
                c + 3.0 * s
            }),
        ),
        (
            "fast::cos_sin_turn",
            over(0.0, 1.0, |u| {
                let (c, s) = fast::cos_sin_turn(u);
                c + 3.0 * s
            }),
        ),
    ];
    let lines: String = got.iter().map(|(name, h)| format!("{h:016x}  {name}\n")).collect();
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/math_bits.txt");
    if std::env::var_os("LIGHTPRO_WRITE").is_some() {
        std::fs::write(&path, &lines).unwrap();
    }
    assert_eq!(lines, std::fs::read_to_string(&path).unwrap_or_default());
}
