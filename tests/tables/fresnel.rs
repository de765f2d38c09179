//! Fresnel's formulas and the copper of the paper's experiment in 50-digit arithmetic:
//! `fresnel.csv`, `fresnel_diffuse.csv`.

use crate::harness::{Check, Row, hold, rows, within};
use lightpro::material::fresnel::{self, Fresnel, diffuse_reflectance, refraction_angle_absorbing};
use num_complex::Complex64;

struct Case {
    n1: Complex64,
    n2: Complex64,
    mu: f64,
    cos_i: f64,
}

impl Case {
    fn of(row: &Row) -> Self {
        Case {
            n1: Complex64::new(row.f("n1"), row.f("k1")),
            n2: Complex64::new(row.f("n2"), row.f("k2")),
            mu: row.f("mu_rel"),
            cos_i: row.f("cos_theta_i"),
        }
    }
    fn fresnel(&self) -> Fresnel {
        Fresnel::new(self.n1, self.n2, self.mu, self.cos_i)
    }
    fn real(&self) -> bool {
        self.n1.im == 0.0 && self.n2.im == 0.0 && self.mu == 1.0
    }
}

/// Largest of several deviations.
fn all<const N: usize>(checks: [Check; N]) -> Check {
    Check::Deviation(checks.into_iter().fold(0.0, |worst, c| match c {
        Check::Deviation(d) => worst.max(d),
        Check::Cannot(_) => worst,
    }))
}

fn tolerance(row: &Row, column: &str) -> f64 {
    4.0 * row.f(column) + 4e-16
}

/// R of the table; the rows beyond the critical angle of an absorbing medium stand there with the
/// other root (R > 1): compare with 1/R.
fn want(row: &Row, column: &str) -> f64 {
    let r = row.f(column);
    if r > 1.0 { 1.0 / r } else { r }
}

fn reflectance(row: &Row, case: &Case) -> Check {
    let f = case.fresnel();
    let mean =
        if row.f("R_unpol") > 1.0 { 0.5 * (want(row, "Rs") + want(row, "Rp")) } else { row.f("R_unpol") };
    all([
        within(f.reflectance_s, want(row, "Rs"), tolerance(row, "abs_uncert_Rs")),
        within(f.reflectance_p, want(row, "Rp"), tolerance(row, "abs_uncert_Rp")),
        within(f.reflectance(), mean, tolerance(row, "abs_uncert_R")),
    ])
}

#[test]
fn powers() {
    hold("fresnel.csv", |row| reflectance(row, &Case::of(row)));
}

#[test]
fn powers_of_the_fast_path() {
    hold("fresnel.csv", |row| {
        let case = Case::of(row);
        if !case.real() {
            return Check::Cannot("the fast path is for dielectrics with µ2 = µ1");
        }
        let i = fresnel::dielectric(case.n1.re, case.n2.re, case.cos_i);
        within(i.r, row.f("R_unpol"), tolerance(row, "abs_uncert_R"))
    });
}

/// Transmittances out of a transparent medium: T = 1 − R, so the same tolerance holds.
#[test]
fn transmitted_powers() {
    hold("fresnel.csv", |row| {
        let case = Case::of(row);
        if case.n1.im > 0.0 {
            return Check::Cannot("the Poynting flux out of an absorbing medium is not 1 − R");
        }
        let f = case.fresnel();
        all([
            within(f.transmittance_s, row.f("Ts_poynting"), tolerance(row, "abs_uncert_Rs")),
            within(f.transmittance_p, row.f("Tp_poynting"), tolerance(row, "abs_uncert_Rp")),
            within(f.transmittance(), row.f("one_minus_R"), tolerance(row, "abs_uncert_R")),
        ])
    });
}

/// Small transmittances keep their relative accuracy: near grazing the flux is right to 1e-14 of
/// itself, where 1 − R has no digit left.
#[test]
fn transmitted_powers_near_grazing_are_relatively_right() {
    hold("fresnel.csv", |row| {
        let case = Case::of(row);
        let t = row.f("one_minus_R");
        if case.n1.im > 0.0
            || !(t > 0.0 && t < 1e-3)
            || case.cos_i > 1e-3
            || row.text("case") == "index_matched_grazing"
        {
            return Check::Cannot("not a grazing row with a little transmission");
        }
        within(case.fresnel().transmittance(), t, 1e-14 * t)
    });
}

/// How far q = sqrt(q²) moves when the terms of q² are rounded: 4 ulp of them over 2|q|.
fn q_tolerance(case: &Case, q: f64) -> f64 {
    let eta = case.n2 / case.n1;
    let terms = (eta.norm_sqr() - 1.0).abs().max(case.cos_i * case.cos_i).max(eta.norm_sqr().min(1.0));
    4.0 * f64::EPSILON * terms / (2.0 * q) + 4.0 * f64::EPSILON * q
}

/// Normal component of the transmitted wave vector, N1 q, and the real angle of refraction.
#[test]
fn wave_vector_and_angle_of_refraction() {
    hold("fresnel.csv", |row| {
        let case = Case::of(row);
        if case.n1.im > 0.0 {
            return Check::Cannot("the table takes the other root beyond critical; see `powers`");
        }
        let (n1, q) = (case.n1.re, case.fresnel().q);
        let kz = Complex64::new(row.f("kzt_re"), row.f("kzt_im"));
        let tol = n1 * q_tolerance(&case, q.norm().max(1e-300));
        let cos_psi = row.f("psi_t_deg").to_radians().cos();
        let got = refraction_angle_absorbing(n1, case.n2, case.cos_i);
        // cos ψ = Re q/sqrt(Re q² + sin²): slope sin²/(…)^(3/2) in Re q.
        let sin2 = (1.0 - case.cos_i) * (1.0 + case.cos_i);
        let slope = if sin2 > 0.0 { sin2 / (q.re * q.re + sin2).powf(1.5) } else { 0.0 };
        all([
            within(q.re * n1, kz.re, tol),
            within(q.im * n1, kz.im, tol),
            within(got, cos_psi, tol * slope / n1 + 4e-16),
        ])
    });
}

/// Amplitudes with their phases: 1e-15, plus what q's own conditioning moves r by near the critical
/// angle.
#[test]
fn amplitudes() {
    hold("fresnel.csv", |row| {
        let case = Case::of(row);
        let f = case.fresnel();
        let (s, p) =
            (Complex64::new(row.f("rs_re"), row.f("rs_im")), Complex64::new(row.f("rp_re"), row.f("rp_im")));
        if row.f("R_unpol") > 1.0 {
            // The other root turns r into 1/r.
            return all([
                within((f.rs - 1.0 / s).norm(), 0.0, 1e-14),
                within((f.rp - 1.0 / p).norm(), 0.0, 1e-14),
            ]);
        }
        let (eta2, q, c) = ((case.n2 / case.n1).powi(2), f.q, case.cos_i);
        let dq = q_tolerance(&case, q.norm().max(1e-300));
        // ∂r⊥/∂q = −2mc/(mc + q)², ∂r∥/∂q = −2mη²c/(η²c + mq)².
        let slope_s = 2.0 * case.mu * c / (case.mu * c + q).norm_sqr().max(1e-300);
        let slope_p = 2.0 * case.mu * c * eta2.norm() / (eta2 * c + case.mu * q).norm_sqr().max(1e-300);
        all([
            within((f.rs - s).norm(), 0.0, 1e-15 + 2.0 * dq * slope_s),
            within((f.rp - p).norm(), 0.0, 1e-15 + 2.0 * dq * slope_p),
        ])
    });
}

#[test]
fn diffuse() {
    hold("fresnel_diffuse.csv", |row| {
        let case_n1 = Complex64::new(row.f("n1"), row.f("k1"));
        let case_n2 = Complex64::new(row.f("n2"), row.f("k2"));
        within(diffuse_reflectance(case_n1, case_n2), row.f("R_diffuse_unpol"), 1e-10)
    });
}

/// The same checks notice an index, an angle or an absorption that is off by parts in 10¹².
#[test]
fn tolerances_bite() {
    let perturbations: [fn(&mut Case); 4] = [
        |c| c.n2.re *= 1.0 + 1e-12,
        |c| c.cos_i *= 1.0 - 1e-12,
        |c| c.mu *= 1.0 + 1e-12,
        |c| c.n2.im *= 1.0 + 1e-11,
    ];
    for (i, perturb) in perturbations.into_iter().enumerate() {
        let fails = rows("fresnel.csv")
            .iter()
            .filter(|row| {
                let mut case = Case::of(row);
                perturb(&mut case);
                matches!(reflectance(row, &case), Check::Deviation(d) if d > 1.0)
            })
            .count();
        println!("perturbation {i}: {fails} rows fail");
        assert!(fails > 20, "perturbation {i}: {fails}");
    }
    let first = &rows("fresnel_diffuse.csv")[0];
    let off = diffuse_reflectance(first.f("n1").into(), (first.f("n2") * (1.0 + 1e-8)).into());
    assert!((off - first.f("R_diffuse_unpol")).abs() > 1e-10);
}
