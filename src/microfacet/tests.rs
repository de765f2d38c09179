//! Integrals that each law must satisfy, by rules that the code itself does not use.

use super::*;
use crate::math::{acos, gauss_legendre, sin_cos, sinh};
use crate::rng::Purpose;

const LAWS: [Slopes; 3] = [Slopes::Gaussian, Slopes::Exponential, Slopes::Ggx];

fn surface(law: Slopes, m: f64) -> Microfacet {
    Microfacet::new(law, m).unwrap()
}

/// Composite Gauss–Legendre rule.
fn rule(n: usize, pieces: usize, a: f64, b: f64) -> Vec<(f64, f64)> {
    let step = (b - a) / pieces as f64;
    let base = gauss_legendre(n, 0.0, step);
    (0..pieces).flat_map(|k| base.iter().map(move |&(x, w)| (a + step * k as f64 + x, w))).collect()
}

/// ∫ f(ζ) P22(ζ) 2πζ dζ through D: ζ = m sinh t, dω cosθ = ζ cos⁴θ dζ dφ.
fn slope_integral(s: &Microfacet, f: impl Fn(f64) -> f64) -> f64 {
    rule(12, 60, 0.0, 22.0)
        .iter()
        .map(|&(t, w)| {
            let zeta = s.m() * sinh(t);
            let dzeta = (s.m() * s.m() + zeta * zeta).sqrt() * w;
            let cos = 1.0 / (1.0 + zeta * zeta).sqrt();
            let h = DVec3::new(zeta * cos, 0.0, cos);
            f(zeta) * s.d_at(h) * cos * cos * cos * cos * 2.0 * PI * zeta * dzeta
        })
        .sum()
}

#[test]
fn d_is_normalised_and_m_is_the_rms_slope() {
    for m in [1e-4, 0.01, 0.3, 1.0, 3.0] {
        for law in LAWS {
            let s = surface(law, m);
            let norm = slope_integral(&s, |_| 1.0);
            assert!((norm - 1.0).abs() < 1e-12, "{law:?} m = {m}: {norm}");
            if law != Slopes::Ggx {
                let rms = slope_integral(&s, |z| z * z).sqrt();
                assert!((rms / m - 1.0).abs() < 1e-12, "{law:?} m = {m}: {rms}");
            }
        }
    }
}

/// ∫ max(0, i·h) D dω in slope space, the azimuth integrated over the lit part only:
/// inner ∫(c + sζ cosφ)₊ dφ by Gauss–Legendre up to φ₀ = acos(−c/(sζ)).
fn projected_area_direct(s: &Microfacet, cos: f64) -> f64 {
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    let b = s.m() / 6.0_f64.sqrt();
    let edge = if sin > 0.0 { cos / sin / b } else { f64::INFINITY };
    let azimuths = gauss_legendre(40, 0.0, 1.0);
    let inner = |y: f64| -> f64 {
        let end = if y <= edge { PI } else { acos(-edge / y) };
        let lit = |phi: f64| cos + sin * b * y * sin_cos(phi).1;
        azimuths.iter().map(|&(x, w)| 2.0 * end * w * lit(end * x)).sum()
    };
    let density = |y: f64| crate::math::exp(-y) * y / (2.0 * PI);
    let knee = edge.min(80.0);
    let below = rule(20, 40, 0.0, knee);
    // The lit part opens like √(ζ − cotθ): y = knee + v² is smooth there.
    let above = rule(20, 40, 0.0, (80.0 - knee).sqrt());
    below.iter().map(|&(y, w)| w * density(y) * inner(y)).sum::<f64>()
        + above
            .iter()
            .map(|&(v, w)| {
                let y = knee + v * v;
                2.0 * v * w * density(y) * inner(y)
            })
            .sum::<f64>()
}

#[test]
fn exponential_masking_equals_its_defining_integral() {
    let mut worst = 0.0_f64;
    for m in [1e-3, 0.05, 0.3, 1.0, 2.0] {
        let s = surface(Slopes::Exponential, m);
        for cos in [1.0, 0.95, 0.7, 0.3, 0.1, 0.03, 1e-2, 1e-3, 1e-5] {
            let direct = cos / projected_area_direct(&s, cos);
            worst = worst.max((s.g1(cos) / direct - 1.0).abs());
        }
    }
    println!("G1, exponential slopes: worst relative deviation {worst:.1e}");
    assert!(worst < 1e-11);
    // It bites: a slope off by 1e-9.
    let off = surface(Slopes::Exponential, 0.3 * (1.0 + 1e-9));
    let direct = 0.03 / projected_area_direct(&surface(Slopes::Exponential, 0.3), 0.03);
    assert!((off.g1(0.03) / direct - 1.0).abs() > 1e-11);
}

/// Λ = [2 K1(a) − Ki1(a)]/π with K1 from the library and Ki1 by Bickley's integral.
#[test]
fn exponential_lambda_in_bessel_functions() {
    let m = 6.0_f64.sqrt(); // b = 1
    let s = surface(Slopes::Exponential, m);
    for k in 0..200 {
        let a = crate::math::pow(10.0, -4.0 + 5.5 * f64::from(k) / 199.0);
        let ki1: f64 = rule(20, 30, 0.0, 9.0_f64.sqrt())
            .iter()
            .map(|&(v, w)| {
                // Ki1 = ∫ exp(−a cosh u)/cosh u du, u = 4v².
                let u = v * v * 4.0;
                let c = crate::math::cosh(u);
                8.0 * v * w * crate::math::exp(-a * c) / c
            })
            .sum();
        let want = (2.0 * crate::math::bessel_k1(a) - ki1) / PI;
        let cos = a / (1.0 + a * a).sqrt();
        let got = s.lambda(cos);
        // cos → sin → a costs a² ε relative in a; Λ falls like exp(−a).
        let tolerance = 1e-12 * want + 4e-16 * a * a * a * want;
        assert!((got - want).abs() < tolerance, "a = {a}: {got} {want} {:.1e}", got / want - 1.0);
    }
}

/// Integral over the upper (sign 1) or lower (sign −1) hemisphere of directions.
fn hemisphere(sign: f64, n: usize, f: impl Fn(DVec3) -> f64) -> f64 {
    let turns = rule(8, n, 0.0, PI);
    rule(8, n, 0.0, 0.5 * PI)
        .iter()
        .map(|&(theta, w)| {
            let (s, c) = sin_cos(theta);
            let ring: f64 = turns
                .iter()
                .map(|&(phi, v)| {
                    let (y, x) = sin_cos(phi);
                    v * f(DVec3::new(s * x, s * y, sign * c))
                })
                .sum();
            2.0 * w * s * ring
        })
        .sum()
}

fn incidence(degrees: f64) -> DVec3 {
    let (s, c) = sin_cos(degrees * PI / 180.0);
    DVec3::new(s, 0.0, c)
}

/// ∫ reflected density dω over outgoing directions + masked share over facets = 1: the two are taken in
/// different variables, so the Jacobian 1/(4 i·h) and the weights are held together.
#[test]
fn reflected_and_masked_power_make_one() {
    for law in LAWS {
        for (m, degrees) in [(0.3, 0.0), (0.3, 50.0), (1.0, 20.0), (1.0, 75.0)] {
            let s = surface(law, m);
            let i = incidence(degrees);
            for masking in [Masking::Separable, Masking::Correlated] {
                let reflected = hemisphere(1.0, 40, |o| s.reflected_density(i, o, masking));
                let masked = hemisphere(1.0, 60, |h| {
                    let o = reflect_about(i, h);
                    s.pdf_visible(i, h) * (1.0 - s.reflected_weight(i, o, masking))
                });
                let sum = reflected + masked;
                assert!((sum - 1.0).abs() < 2e-5, "{law:?} m = {m} {degrees}°: {sum}");
                let albedo = s.directional_albedo(i.z, masking, |_| 1.0);
                assert!((albedo - reflected).abs() < 2e-5, "{law:?} {m} {degrees}: {albedo} {reflected}");
            }
        }
    }
}

/// The same for transmission, where Walter's Jacobian stands. The rule here is of first order at a jump:
/// in o where the facet stands upright (D of GGX is finite there), in h where total reflection begins.
/// So both sides carry the test function h.z² cos²θt; the plain sum is taken where nothing jumps.
#[test]
fn transmitted_and_masked_power_make_one() {
    for law in LAWS {
        for (m, degrees, eta) in [(0.3, 0.0, 1.5), (0.3, 50.0, 1.5), (1.0, 20.0, 1.5), (0.3, 20.0, 1.0 / 1.5)]
        {
            let s = surface(law, m);
            let i = incidence(degrees);
            let case = format!("{law:?} m = {m} {degrees}° η = {eta}");
            let integrals = |g: fn(DVec3, DVec3) -> f64| {
                let through = hemisphere(-1.0, 60, |o| {
                    s.transmitted_density(i, o, eta) * g((i + o * eta).normalize_or_zero(), o)
                });
                let from_facets = hemisphere(1.0, 60, |h| {
                    let share = |o| s.transmitted_weight(o) * g(h, o);
                    s.pdf_visible(i, h) * refract_about(i, h, eta).map_or(0.0, share)
                });
                (through, from_facets)
            };
            let (through, facets) = integrals(|h, o| (h.z * o.dot(h)).powi(2));
            assert!((through - facets).abs() < 1e-5, "{case}: {through} {facets}");
            if law != Slopes::Ggx && eta > 1.0 {
                let (through, _) = integrals(|_, _| 1.0);
                let masked = hemisphere(1.0, 60, |h| {
                    let w = refract_about(i, h, eta).map_or(0.0, |o| s.transmitted_weight(o));
                    s.pdf_visible(i, h) * (1.0 - w)
                });
                assert!((through + masked - 1.0).abs() < 2e-5, "{case}: {through} + {masked}");
            }
        }
    }
}

/// f cosθi symmetric: D G2/(4 cosθi cosθo) does not change when i and o change places.
#[test]
fn reflection_is_reciprocal() {
    for law in LAWS {
        let s = surface(law, 0.4);
        let (a, b) = (incidence(70.0), DVec3::new(0.3, 0.4, 0.75_f64.sqrt()));
        for masking in [Masking::Separable, Masking::Correlated] {
            let there = s.reflected_density(a, b, masking) * a.z;
            let back = s.reflected_density(b, a, masking) * b.z;
            assert!((there / back - 1.0).abs() < 1e-13);
        }
        let g2 = s.g1(a.z) * s.reflected_weight(a, b, Masking::Correlated);
        assert!((g2 / s.g2_correlated(a.z, b.z) - 1.0).abs() < 1e-13);
        let g2 = s.g1(a.z) * s.reflected_weight(a, b, Masking::Separable);
        assert!((g2 / s.g2_separable(a.z, b.z) - 1.0).abs() < 1e-13);
    }
}

#[test]
fn refraction_obeys_snell_and_density_meets_its_facet() {
    let i = incidence(35.0);
    let h = DVec3::new(0.1, -0.2, 1.0).normalize();
    for eta in [1.5, 1.0 / 1.5, 1.0001, 2.5] {
        let o = refract_about(i, h, eta).unwrap();
        assert!((o.length() - 1.0).abs() < 1e-15);
        assert!((i.cross(h).length() - eta * o.cross(h).length()).abs() < 1e-15);
        assert!(o.dot(h) < 0.0);
        let along = (i + o * eta).normalize();
        assert!((along.dot(h).abs() - 1.0).abs() < 1e-9, "{eta}");
    }
    assert!(refract_about(incidence(60.0), DVec3::Z, 1.0 / 1.5).is_none());
    assert_eq!(refract_about(i, h, 1.0).map(|o| (o + i).length() < 1e-15), Some(true));
}

/// The table of the white albedo against the quadrature between its nodes.
#[test]
fn white_albedo_table_interpolates_within_1e_6() {
    for law in LAWS {
        for m in [1e-4, 0.01, 0.1, 0.5, 1.0, 2.0] {
            let s = surface(law, m);
            let start = std::time::Instant::now();
            s.directional_albedo_white(1.0, Masking::Separable);
            let made = start.elapsed();
            let mut worst = 0.0_f64;
            for k in 0..60 {
                let x = (f64::from(k) + 0.41) / 60.0;
                // Half of the cosines near grazing, on the scale of m.
                for cos in [x, (m * x * 3.0).min(1.0)] {
                    for masking in [Masking::Separable, Masking::Correlated] {
                        let exact = s.directional_albedo(cos, masking, |_| 1.0);
                        worst = worst.max((s.directional_albedo_white(cos, masking) - exact).abs());
                    }
                }
            }
            println!("white albedo, {law:?} m = {m}: table within {worst:.1e}, made in {made:?}");
            assert!(worst < 1e-6, "{law:?} m = {m}: {worst}");
        }
    }
}

#[test]
fn extreme_slopes_and_grazing_stay_finite() {
    let mut rng = Stream::of(3, 0, 0, Purpose::Probe);
    for law in LAWS {
        for m in [1e-9, 1e-4, 1.0, 1e3] {
            let s = surface(law, m);
            assert!(s.d(1.0).is_finite() && s.d(1e-300) >= 0.0 && s.d(1e-300).is_finite());
            assert_eq!(s.d(0.0), 0.0);
            assert!(s.g1(0.0) == 0.0 && s.g1(1.0) == 1.0);
            for i in [DVec3::Z, DVec3::X, incidence(89.999_999), -incidence(45.0).with_z(-0.5_f64.sqrt())] {
                for _ in 0..200 {
                    let h = s.sample_visible(i, &mut rng);
                    assert!((h.length() - 1.0).abs() < 1e-14 && h.z >= 0.0, "{law:?} {m} {h}");
                    assert!(i.dot(h) >= -1e-12, "{law:?} {m} {i} {h}");
                    let o = reflect_about(i, h);
                    for masking in [Masking::Separable, Masking::Correlated] {
                        assert!((0.0..=1.0).contains(&s.reflected_weight(i, o, masking)));
                        assert!(s.reflected_density(i, o, masking).is_finite());
                    }
                    assert!(s.pdf_visible(i, h).is_finite());
                }
            }
        }
        let peak = surface(law, 1e-4).d(1.0);
        assert!(peak > 3e7 && peak < 1e8, "{peak}");
    }
    for m in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Microfacet::new(Slopes::Ggx, m).is_err());
    }
}

/// Equation (23) is the slope tanθh of the half vector.
#[test]
fn facet_slope_is_that_of_the_half_vector() {
    for (ti, tp, phi) in [(0.3, 0.9, 1.0), (1.2, 1.2, 3.0), (0.7, 0.7 + 1e-7, 1e-7), (0.0, 0.4, 0.0)] {
        let (si, ci) = sin_cos(ti);
        let (sp, cp) = sin_cos(tp);
        let (y, x) = sin_cos(phi);
        let h = DVec3::new(-si + sp * x, sp * y, ci + cp);
        let want = (h.x * h.x + h.y * h.y).sqrt() / h.z;
        assert!((facet_slope(ti, tp, phi) - want).abs() < 1e-15 + 1e-14 * want);
    }
    assert_eq!(facet_slope(0.8, 0.8, 0.0), 0.0);
}
