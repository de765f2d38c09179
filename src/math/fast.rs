//! ln, exp and sin/cos(2πu) for the inner loop of transport: own polynomials, within 2 ulp, plain
//! multiplications and additions only. The same source compiles to scalar and vector code and gives
//! the same bits on every processor.

/// ln 2 in two parts: k · `LN2_HI` is exact for every exponent k.
const LN2_HI: f64 = 6.931_471_803_691_238e-1;
const LN2_LO: f64 = 1.908_214_929_270_587_7e-10;

/// 1.5·2⁵²: adding it rounds to the nearest integer and leaves that in the low mantissa bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Natural logarithm of a positive, finite, normal number; relative error below 2 ulp.
///
/// x = 2ᵏ m with m in [√½, √2); ln m = 2 atanh(f), f = (m − 1)/(m + 1), by its odd series fitted on
/// |f| ≤ 0.1716 (the classical `fdlibm` form). Not for 0, subnormal, infinite or negative numbers:
/// free paths draw from (0, 1].
#[inline]
pub fn ln(x: f64) -> f64 {
    let bits = x.to_bits();
    // Shift the exponent so that the mantissa falls into [√½, √2).
    let shifted = bits.wrapping_add(0x3ff0_0000_0000_0000 - 0x3fe6_a09e_667f_3bcd);
    let k = (shifted >> 52) as i64 - 1023;
    let m = f64::from_bits((shifted & 0x000f_ffff_ffff_ffff) + 0x3fe6_a09e_667f_3bcd);
    let k = k as f64;
    let f = m - 1.0;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let t1 = w * (0.399_999_999_994_094_2 + w * (0.222_221_984_321_497_84 + w * 0.153_138_376_992_093_73));
    let t2 = z
        * (0.666_666_666_666_673_5
            + w * (0.285_714_287_436_623_9 + w * (0.181_835_721_616_180_5 + w * 0.147_981_986_051_165_86)));
    let r = t1 + t2;
    let hfsq = 0.5 * f * f;
    k * LN2_HI - ((hfsq - (s * (hfsq + r) + k * LN2_LO)) - f)
}

/// Exponential for |x| < 700; smaller arguments give 0. Relative error below 2 ulp.
///
/// x = k ln 2 + r with |r| ≤ ½ ln 2, Taylor polynomial of degree 13 in r by Estrin's scheme.
#[inline]
pub fn exp(x: f64) -> f64 {
    let kr = x * std::f64::consts::LOG2_E + ROUND;
    let k = kr - ROUND;
    let r = (x - k * LN2_HI) - k * LN2_LO;
    let p = 1.0 + (r + r * r * exp_tail(r));
    let biased = (kr.to_bits() << 52).wrapping_add(p.to_bits());
    if x < -700.0 { 0.0 } else { f64::from_bits(biased) }
}

/// (eʳ − 1 − r)/r² for |r| ≤ 0.35.
#[inline]
fn exp_tail(r: f64) -> f64 {
    let r2 = r * r;
    let r4 = r2 * r2;
    let a = 0.5 + r * (1.0 / 6.0);
    let b = 1.0 / 24.0 + r * (1.0 / 120.0);
    let c = 1.0 / 720.0 + r * (1.0 / 5040.0);
    let d = 1.0 / 40_320.0 + r * (1.0 / 362_880.0);
    let e = 1.0 / 3_628_800.0 + r * (1.0 / 39_916_800.0);
    let f = 1.0 / 479_001_600.0 + r * (1.0 / 6_227_020_800.0);
    (a + r2 * b) + r4 * ((c + r2 * d) + r4 * (e + r2 * f))
}

/// Below this 1 − e^(−t) is the plain series; the general form gives the same bits there.
const SHORT: f64 = 0.34;

/// 1 − e^(−t) for t ≥ 0, without cancellation for small t.
///
/// Steps through a medium are short against its absorption length nearly always, so that the branch
/// is foreseen and the chain of operations half as long.
#[inline]
pub fn one_minus_exp_neg(t: f64) -> f64 {
    if t < SHORT { one_minus_exp_neg_short(t) } else { one_minus_exp_neg_any(t) }
}

/// [`one_minus_exp_neg`] of every lane, the same bits: one branch for all lanes, none within.
#[inline]
pub fn one_minus_exp_neg_each<const N: usize>(t: &[f64; N]) -> [f64; N] {
    // Loops, not `map`: only these become vector instructions.
    let mut out = [0.0; N];
    if t.iter().all(|&t| t < SHORT) {
        for (o, &t) in out.iter_mut().zip(t) {
            *o = one_minus_exp_neg_short(t);
        }
    } else {
        for (o, &t) in out.iter_mut().zip(t) {
            *o = one_minus_exp_neg_any(t);
        }
    }
    out
}

#[inline]
fn one_minus_exp_neg_short(t: f64) -> f64 {
    let r = -t;
    -(r + r * r * exp_tail(r))
}

/// e^(−t) = 2ᵏ(1 + q) with |q| < ½: (1 − 2ᵏ) − 2ᵏ q, where 1 − 2ᵏ is exact and 0 for small t.
#[inline]
fn one_minus_exp_neg_any(t: f64) -> f64 {
    let kr = ROUND - t * std::f64::consts::LOG2_E;
    let k = kr - ROUND;
    let r = (-t - k * LN2_HI) - k * LN2_LO;
    let q = r + r * r * exp_tail(r);
    let scale = f64::from_bits((kr.to_bits() << 52).wrapping_add(1.0_f64.to_bits()));
    if t > 700.0 { 1.0 } else { (1.0 - scale) - scale * q }
}

/// (cos x, sin x) for |x| ≤ π/4; absolute error below 1.5e-16.
///
/// The polynomials of `fdlibm`, by Estrin's scheme.
#[inline]
pub fn cos_sin_eighth(x: f64) -> (f64, f64) {
    let z = x * x;
    let w = z * z;
    let s1 = -1.666_666_666_666_663_2e-1 + z * 8.333_333_333_322_49e-3;
    let s2 = -1.984_126_982_985_795e-4 + z * 2.755_731_370_707_006_8e-6;
    let s3 = -2.505_076_025_340_686_3e-8 + z * 1.589_690_995_211_55e-10;
    let s = x + (x * z) * (s1 + w * (s2 + w * s3));
    let c1 = 4.166_666_666_666_66e-2 + z * -1.388_888_888_887_411e-3;
    let c2 = 2.480_158_728_947_673e-5 + z * -2.755_731_435_139_066_3e-7;
    let c3 = 2.087_572_321_298_175e-9 + z * -1.135_964_755_778_819_5e-11;
    let c = (1.0 - 0.5 * z) + w * (c1 + w * (c2 + w * c3));
    (c, s)
}

/// (cos 2πu, sin 2πu) for |u| ≤ 1; absolute error below 3e-16.
///
/// The turn is reduced to |v| ≤ 1/8 around the nearest quarter, two Taylor polynomials by Estrin's
/// scheme give sine and cosine there, the quarter swaps and signs them: no branch.
#[inline]
pub fn cos_sin_turn(u: f64) -> (f64, f64) {
    let qr = 4.0 * u + ROUND;
    let q = qr - ROUND;
    let quarter = qr.to_bits();
    let x = (u - 0.25 * q) * std::f64::consts::TAU;
    let z = x * x;
    let z2 = z * z;
    let z4 = z2 * z2;
    let s1 = -1.0 / 6.0 + z * (1.0 / 120.0);
    let s2 = -1.0 / 5040.0 + z * (1.0 / 362_880.0);
    let s3 = -1.0 / 39_916_800.0 + z * (1.0 / 6_227_020_800.0) - z2 * (1.0 / 1_307_674_368_000.0);
    let s = x + x * z * ((s1 + z2 * s2) + z4 * s3);
    let c1 = -0.5 + z * (1.0 / 24.0);
    let c2 = -1.0 / 720.0 + z * (1.0 / 40_320.0);
    let c3 = -1.0 / 3_628_800.0 + z * (1.0 / 479_001_600.0);
    let c4 = -1.0 / 87_178_291_200.0 + z * (1.0 / 20_922_789_888_000.0);
    let c = 1.0 + z * ((c1 + z2 * c2) + z4 * (c3 + z2 * c4));
    // Odd quarters swap the two, by a mask.
    let swap = (s.to_bits() ^ c.to_bits()) & (quarter & 1).wrapping_neg();
    let (a, b) = (c.to_bits() ^ swap, s.to_bits() ^ swap);
    // cos is negated in quarters 1 and 2, sin in quarters 2 and 3.
    let flip_c = ((quarter ^ (quarter >> 1)) & 1) << 63;
    let flip_s = ((quarter >> 1) & 1) << 63;
    (f64::from_bits(a ^ flip_c), f64::from_bits(b ^ flip_s))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ulps(got: f64, want: f64) -> f64 {
        (got - want).abs() / (want.abs() * f64::EPSILON).max(f64::MIN_POSITIVE)
    }

    #[test]
    fn ln_within_two_ulp_of_correct_rounding() {
        let mut x = 1e-300_f64;
        let mut worst: f64 = 0.0;
        while x < 1e300 {
            worst = worst.max(ulps(ln(x), pxfm::f_log(x)));
            x *= 1.000_37 + (x.to_bits() & 0xff) as f64 * 1e-6;
        }
        assert!(worst <= 2.0, "{worst} ulp");
        assert_eq!(ln(1.0), 0.0);
    }

    #[test]
    fn exp_within_two_ulp_of_correct_rounding() {
        let mut worst: f64 = 0.0;
        for i in 0..2_000_000 {
            let x = -699.0 + 1398.0 * (f64::from(i) + 0.37) / 2e6;
            worst = worst.max(ulps(exp(x), pxfm::f_exp(x)));
        }
        assert!(worst <= 2.0, "{worst} ulp");
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(-1e9), 0.0);
    }

    #[test]
    fn one_minus_exp_neg_keeps_small_arguments() {
        let mut t = 1e-300;
        while t < 600.0 {
            assert!(ulps(one_minus_exp_neg(t), -pxfm::f_expm1(-t)) <= 3.0, "t = {t}");
            if t < SHORT {
                assert_eq!(one_minus_exp_neg_short(t), one_minus_exp_neg_any(t), "t = {t}");
            }
            // One long lane sends all of them the other way: the same bits.
            let lanes = [0.1 * t, t, 0.3, 800.0];
            assert_eq!(one_minus_exp_neg_each(&lanes), lanes.map(one_minus_exp_neg), "t = {t}");
            t *= 1.01;
        }
        assert_eq!(one_minus_exp_neg(0.0), 0.0);
        assert_eq!(one_minus_exp_neg(f64::INFINITY), 1.0);
    }

    #[test]
    fn eighth_of_a_turn_matches_sine_and_cosine() {
        let mut worst: f64 = 0.0;
        for i in -1_000_000..=1_000_000 {
            let x = f64::from(i) * (std::f64::consts::FRAC_PI_4 / 1e6);
            let (c, s) = cos_sin_eighth(x);
            worst = worst.max((c - pxfm::f_cos(x)).abs()).max((s - pxfm::f_sin(x)).abs());
        }
        assert!(worst <= 1.7e-16, "{worst}");
    }

    #[test]
    fn turn_matches_sine_and_cosine() {
        let mut worst: f64 = 0.0;
        for i in -1_000_000..=1_000_000 {
            let u = f64::from(i) / 1e6;
            let (c, s) = cos_sin_turn(u);
            worst = worst.max((c - pxfm::f_cospi(2.0 * u)).abs());
            worst = worst.max((s - pxfm::f_sinpi(2.0 * u)).abs());
        }
        assert!(worst <= 3e-16, "{worst}");
    }
}
