use super::*;

/// Cosines from grazing to normal, extremes included.
fn cosines() -> Vec<f64> {
    let mut all = vec![0.0, 5e-324, 1e-308, 1e-200, 1e-155, 1e-16, 1e-8, 1e-3, 1.0 - 1e-16, 1.0];
    all.extend((1..40).map(|i| f64::from(i) / 40.0));
    all
}

fn indices() -> [f64; 12] {
    [
        1e-3,
        0.05,
        0.999_999_999_999,
        1.0,
        1.0 + f64::EPSILON,
        1.000_000_000_001,
        1.33,
        1.5,
        1.55,
        2.7,
        10.0,
        1e3,
    ]
}

#[test]
fn no_input_gives_a_nan_or_power_out_of_nothing() {
    for n1 in indices() {
        for n2 in indices() {
            for c in cosines() {
                let i = dielectric(n1, n2, c);
                for x in [i.r, i.t, i.cos_t] {
                    assert!((0.0..=1.0).contains(&x), "{n1} {n2} {c}: {i:?}");
                }
                assert!((i.r + i.t - 1.0).abs() <= f64::EPSILON, "{n1} {n2} {c}: {i:?}");
                for k1 in [0.0, 1e-100, 1e-12, 1e-3, 0.1, 4.0] {
                    for k2 in [0.0, 1e-100, 1e-12, 1e-3, 0.1, 4.0, 1e3] {
                        any_interface_is_sound(Complex64::new(n1, k1), Complex64::new(n2, k2), c);
                    }
                }
            }
        }
    }
}

fn any_interface_is_sound(n1: Complex64, n2: Complex64, c: f64) {
    for mu in [0.1, 1.0, 10.0] {
        let f = Fresnel::new(n1, n2, mu, c);
        let sound = [f.reflectance_s, f.reflectance_p, f.transmittance_s, f.transmittance_p];
        assert!(sound.iter().all(|x| (0.0..=1.0 + 4e-16).contains(x)), "{n1} {n2} {mu} {c}: {f:?}");
        assert!((f.reflectance() + f.transmittance() - 1.0).abs() < 1e-14, "{n1} {n2} {mu} {c}: {f:?}");
        assert!(f.rs.is_finite() && f.rp.is_finite() && f.q.is_finite(), "{n1} {n2} {mu} {c}: {f:?}");
        assert!(f.q.re >= 0.0 && (f.q.re > 0.0 || f.q.im >= 0.0));
    }
    let i = interface(n1, n2, c);
    assert!([i.r, i.t, i.cos_t].iter().all(|x| (0.0..=1.0 + 4e-16).contains(x)), "{n1} {n2} {c}: {i:?}");
    let cos_t = refraction_angle_absorbing(n1.re, n2, c);
    assert!((0.0..=1.0).contains(&cos_t), "{n1} {n2} {c}");
}

#[test]
fn the_fast_path_is_the_complex_one() {
    for n1 in indices() {
        for n2 in indices() {
            for c in cosines() {
                let (i, f) = (dielectric(n1, n2, c), Fresnel::new(n1.into(), n2.into(), 1.0, c));
                // The paths round q² differently by some ulp of its terms; T goes with q.
                let relative = 1e-15 * (4.0 + 1.0 / f.q.re.powi(2).max(1e-300));
                assert!((i.r - f.reflectance()).abs() <= 4e-16 + relative * i.t, "{n1} {n2} {c}");
                // 1e-300: the last cosines are subnormal.
                let off = (i.t - f.transmittance()).abs();
                assert!(off <= relative * i.t + 1e-300, "{n1} {n2} {c}: {i:?} {f:?}");
                let cos_t = refraction_angle_absorbing(n1, n2.into(), c);
                assert!((i.cos_t - cos_t).abs() <= relative * i.cos_t, "{n1} {n2} {c}: {} {cos_t}", i.cos_t);
            }
        }
    }
}

/// R(1→2, θi) = R(2→1, θt). The error of the returned angle, at most 4 ulp of cosθt, moves R(2→1)
/// within what it takes at the neighbouring angles (much, where Brewster and critical angle meet).
#[test]
fn reflection_is_reciprocal() {
    let mut worst = 0.0_f64;
    for n1 in indices() {
        for n2 in indices() {
            for c in cosines() {
                let there = dielectric(n1, n2, c);
                // Beyond a ratio of 100 a cosine near 1 is too coarse to hold the angle.
                if there.t == 0.0 || (n2 / n1).max(n1 / n2) > 100.0 {
                    continue;
                }
                let back = |cos_t: f64| dielectric(n2, n1, cos_t).r;
                let near = (-8..=8).map(|i| {
                    let step = 0.5 * f64::from(i) * f64::EPSILON * there.cos_t;
                    back((there.cos_t + step).clamp(0.0, 1.0))
                });
                let (low, high) = near.fold((1.0_f64, 0.0_f64), |(l, h), r| (l.min(r), h.max(r)));
                let slack = high - low + 8e-16;
                let off = (there.r - back(there.cos_t)).abs() / slack;
                worst = worst.max(off);
                assert!(off <= 1.0, "{n1} {n2} {c}: {} {}", there.r, back(there.cos_t));
            }
        }
    }
    println!("reciprocity: worst {worst:.3} of its tolerance");
}

#[test]
fn total_reflection_is_exactly_one() {
    for c in [0.0, 1e-9, 0.1, 0.5, 0.74] {
        assert_eq!(dielectric(1.5, 1.0, c), Dielectric { r: 1.0, t: 0.0, cos_t: 0.0 });
        let f = Fresnel::new(1.5.into(), 1.0.into(), 1.0, c);
        assert_eq!((f.reflectance(), f.transmittance()), (1.0, 0.0));
    }
    assert!(dielectric(1.5, 1.0, 0.75).t > 0.0);
}

#[test]
fn equal_media_have_no_interface() {
    for c in cosines() {
        assert_eq!(dielectric(1.55, 1.55, c), Dielectric { r: 0.0, t: 1.0, cos_t: c });
        let n = Complex64::new(1.5, 0.1);
        let i = interface(n, n, c);
        assert!(i.r == 0.0 && i.t == 1.0 && (i.cos_t - c).abs() < 1e-15);
    }
}

/// At cosθ = 1e-16 the textbook 1 − R has lost 42 %; T must be linear in cosθ there.
#[test]
fn transmission_near_grazing_keeps_its_relative_accuracy() {
    let slope = |c: f64| dielectric(1.0, 1.5, c).t / c;
    // T = 2 cosθ (1/q)(1 + η²) for cosθ → 0, q = sqrt(η² − 1).
    let want = 2.0 * (1.0 + 2.25) / 1.25_f64.sqrt();
    for c in [1e-16, 1e-30, 1e-200] {
        assert!((slope(c) / want - 1.0).abs() < 1e-14, "{c}: {} {want}", slope(c));
    }
}

#[test]
fn index_match_has_the_small_reflectance_of_its_step() {
    for step in [1e-12, -1e-12, 1e-9] {
        let n2 = 1.5 + step;
        // Normal incidence: R = ((n2 − n1)/(n2 + n1))².
        let want = ((n2 - 1.5) / (n2 + 1.5)) * ((n2 - 1.5) / (n2 + 1.5));
        assert!((dielectric(1.5, n2, 1.0).r / want - 1.0).abs() < 1e-14);
    }
}

/// The weak-absorber rule errs by O(κ1/n1) away from the critical angle.
#[test]
fn weak_absorber_rule_errs_as_stated() {
    for c in [0.8, 0.9, 1.0] {
        for k in [1e-6, 1e-4, 9.9e-4 * 1.5] {
            let n1 = Complex64::new(1.5, k);
            let exact = Fresnel::new(n1, Complex64::from(1.0), 1.0, c).reflectance();
            let off = (interface(n1, Complex64::from(1.0), c).r - exact).abs();
            assert!(weakly_absorbing(n1) && off < k / 1.5, "{c} {k}: {off}");
        }
    }
    assert!(!weakly_absorbing(Complex64::new(1.5, 0.0015)));
    // Not a vacuous rule: just above it the complex formula is used.
    let n1 = Complex64::new(1.5, 0.1);
    let f = Fresnel::new(n1, Complex64::from(1.0), 1.0, 0.9);
    assert_eq!(interface(n1, Complex64::from(1.0), 0.9).r, f.reflectance());
    // Beyond the critical angle: no real direction, and what is not reflected is absorbed.
    let beyond = interface(n1, Complex64::from(1.0), 0.5);
    assert!(beyond.cos_t == 0.0 && beyond.t > 0.1 && beyond.r < 1.0);
}

/// A fibre wall that absorbs lets light out: the root rule Im q ≥ 0 would give R > 1.
#[test]
fn an_absorbing_wall_never_reflects_more_than_all() {
    for k in [1e-6, 1e-3, 0.1, 1.0] {
        for c in cosines() {
            let f = Fresnel::new(Complex64::new(1.55, k), Complex64::from(1.0), 1.0, c);
            assert!(f.reflectance_s <= 1.0 && f.reflectance_p <= 1.0, "{k} {c}: {f:?}");
        }
    }
}

#[test]
fn directions_are_unit_and_obey_snell() {
    let n = DVec3::new(0.3, -0.5, 0.8).normalize();
    let side = crate::math::orthonormal(n).0;
    for c in [1.0, 0.999_999, 0.7, 0.3, 1e-3, 1e-9] {
        let sin = f64::sqrt((1.0 - c) * (1.0 + c));
        let u = side * sin - n * c;
        for (n1, n2) in [(1.0, 1.5), (1.5, 1.55), (1.5, 1.0), (1.0, 1.0 + 1e-12)] {
            let i = dielectric(n1, n2, c);
            let r = reflect(u, n);
            assert!((r.length() - 1.0).abs() < 4e-16 && (r.dot(n) - c).abs() < 4e-16);
            if i.t == 0.0 {
                continue;
            }
            let t = refract(u, n, c, i.cos_t, n2 / n1);
            assert!((t.length() - 1.0).abs() < 4e-16, "{c} {n1} {n2}: {}", t.length());
            assert!((t.dot(n) + i.cos_t).abs() < 1e-15 && t.cross(n).dot(u).abs() < 1e-15);
            let snell = n2 * t.cross(n).length() - n1 * sin;
            assert!(snell.abs() < 1e-15, "{c} {n1} {n2}: {snell}");
            let off = (t - refract_at(u, n, i.cos_t)).length();
            // cosθt holds sinθt to ε/sinθt only.
            let sin_t = n1 / n2 * sin;
            assert!(off < 4e-16 + 2.0 * f64::EPSILON / sin_t.max(1e-8), "{c} {n1} {n2}: {off}");
        }
    }
    assert_eq!(refract_at(-DVec3::Z, DVec3::Z, 1.0), -DVec3::Z);
}

/// Into copper at 45°: tan ψ = sinθ/Re q (Born & Wolf §14.2); a normal ray stays normal.
#[test]
fn real_angle_in_an_absorbing_medium() {
    let copper = Complex64::new(0.22, 3.747);
    let c = 0.5_f64.sqrt();
    let q = (copper * copper - 0.5).sqrt();
    let psi = refraction_angle_absorbing(1.0, copper, c);
    let tan = (1.0 - psi * psi).sqrt() / psi;
    assert!((tan - c / q.re).abs() < 1e-12 * tan);
    assert_eq!(refraction_angle_absorbing(1.0, copper, 1.0), 1.0);
}

#[test]
fn diffuse_reflectance_knows_its_limits() {
    let r = |n1: f64, n2: f64| diffuse_reflectance(n1.into(), n2.into());
    assert_eq!(r(1.5, 1.5), 0.0);
    // Energy balance of the two sides (n²-law): n1² (1 − R12) = n2² (1 − R21).
    for (a, b) in [(1.0, 1.5), (1.0, 1.000_001), (1.5, 1.55), (1.0, 4.0), (1.0, 100.0)] {
        let (there, back) = (a * a * (1.0 - r(a, b)), b * b * (1.0 - r(b, a)));
        assert!((there - back).abs() < 1e-10 * a * a, "{a} {b}: {there} {back}");
    }
}
