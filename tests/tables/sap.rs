//! SAP: exact shares against the tables, directions, bias, and the turned SAP.

use crate::harness::{Check, Row, hold, rows, within};
use lightpro::math::{DVec3, FRAC_PI_2, Frame, PI};
use lightpro::rng::{Purpose, Stream};
use lightpro::sap::{
    Half, Healpix, Population, Sap, SapDirections, SapError, estimated_bounds, frame_medium, frame_specular,
    frame_surface, populate_centre, populate_exact,
};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Henyey–Greenstein (14) about `axis`, with 1 − cos from the chord.
fn hg(g: f64, axis: DVec3) -> impl Fn(DVec3) -> f64 {
    move |u| {
        let d = (1.0 - g) * (1.0 - g) + g * (u - axis).length_squared();
        (1.0 - g) * (1.0 + g) / (4.0 * PI * d * d.sqrt())
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Law {
    Beckmann,
    Ggx,
}

/// Smith's G1 of the direction with cosine c.
fn g1(law: Law, m: f64, c: f64) -> f64 {
    let t = (1.0 - c * c).max(0.0).sqrt() / c;
    if t == 0.0 {
        return 1.0;
    }
    match law {
        Law::Ggx => 2.0 / (1.0 + (1.0 + m * m * t * t).sqrt()),
        Law::Beckmann => {
            let a = 1.0 / (m * t);
            // 2/(1 + erf a + e^(−a²)/(a√π))
            2.0 / (1.0 + lightpro::math::erf(a) + (-a * a).exp() / (a * PI.sqrt()))
        }
    }
}

/// White reflected light per steradian, single scatter, separable masking: D G1(i) G1(o)/(4 cos i);
/// the light comes from azimuth 0.
fn reflected(law: Law, m: f64, theta: f64) -> impl Fn(DVec3) -> f64 {
    let i = DVec3::new(theta.sin(), 0.0, theta.cos());
    move |o| {
        let h = i + o;
        let tan2 = (h.x * h.x + h.y * h.y) / (h.z * h.z);
        let cos2 = 1.0 / (1.0 + tan2);
        let d = match law {
            Law::Beckmann => (-tan2 / (m * m)).exp() / (PI * m * m * cos2 * cos2),
            Law::Ggx => m * m / (PI * (cos2 * (m * m + tan2)).powi(2)),
        };
        d * g1(law, m, i.z) * g1(law, m, o.z) / (4.0 * i.z)
    }
}

/// Shares of all cases that a table asks for, each populated once.
#[derive(Default)]
struct Cases(RefCell<BTreeMap<String, Population>>);

impl Cases {
    fn share(&self, key: String, pix: usize, populate: impl FnOnce() -> Population) -> f64 {
        self.0.borrow_mut().entry(key).or_insert_with(populate).shares[pix]
    }
}

fn hg_row<'a>(cases: &'a Cases, factor: f64, tol: f64) -> impl Fn(&Row) -> Check + 'a {
    move |row| {
        let key = [row.text("nside"), row.text("g"), row.text("axis_name")].join(" ");
        let got = cases.share(key, row.u("pix_ring") as usize, || {
            let axis = DVec3::new(row.f("ax"), row.f("ay"), row.f("az"));
            let hp = Healpix::new(row.u("nside") as u32).unwrap();
            populate_exact(&hp, &hg(row.f("g") * factor, axis), None, 1e-12)
        });
        within(got, row.f("weight"), tol)
    }
}

fn microfacet_row<'a>(cases: &'a Cases, factor: f64, tol: f64) -> impl Fn(&Row) -> Check + 'a {
    move |row| {
        let key = [row.text("nside"), row.text("dist"), row.text("alpha"), row.text("theta_i_deg")].join(" ");
        let got = cases.share(key, row.u("pix_ring") as usize, || {
            let law = if row.text("dist") == "ggx" { Law::Ggx } else { Law::Beckmann };
            let density = reflected(law, row.f("alpha") * factor, row.f("theta_i_deg").to_radians());
            let hp = Healpix::new(row.u("nside") as u32).unwrap();
            populate_exact(&hp, &density, Some(Half::Upper), 1e-13)
        });
        within(got, row.f("weight_reflected_white"), tol)
    }
}

fn failing(file: &str, check: impl Fn(&Row) -> Check) -> usize {
    rows(file).iter().filter(|r| matches!(check(r), Check::Deviation(d) if d > 1.0)).count()
}

/// Absolute error of a share allowed, of a whole of 1.
const HG_TOLERANCE: f64 = 2e-14;
const MICROFACET_TOLERANCE: f64 = 2e-14;

#[test]
fn hg_patch_weights() {
    let cases = Cases::default();
    hold("hg_patch_weights.csv", hg_row(&cases, 1.0, HG_TOLERANCE));
    for (key, p) in cases.0.borrow().iter() {
        assert!((p.sum - 1.0).abs() < 1e-12 && p.error <= 1e-12, "{key}: {} {}", p.sum, p.error);
    }
}

#[test]
fn hg_tolerance_bites() {
    let cases = Cases::default();
    assert!(failing("hg_patch_weights.csv", hg_row(&cases, 1.0 + 1e-11, HG_TOLERANCE)) > 0);
}

#[test]
fn microfacet_patch_weights() {
    let cases = Cases::default();
    hold("microfacet_patch_weights.csv", microfacet_row(&cases, 1.0, MICROFACET_TOLERANCE));
    // Sums: single-scatter directional albedo, microfacet_albedo.csv.
    let albedo =
        [("16 beckmann 0.5 75.0", 0.900_008_823_311_002), ("4 ggx 0.3 75.0", 0.808_410_681_679_287_2)];
    for (key, want) in albedo {
        let got = cases.0.borrow()[key].sum;
        assert!((got - want).abs() < 1e-13, "{key}: {got}");
    }
}

#[test]
fn microfacet_tolerance_bites() {
    let cases = Cases::default();
    assert!(failing("microfacet_patch_weights.csv", microfacet_row(&cases, 1.0 + 1e-11, 2e-14)) > 0);
}

/// Bias of the mean cosine, (1 − g′)/(1 − g) − 1 in per cent.
fn bias(g: f64, mean: f64) -> f64 {
    100.0 * ((1.0 - mean) / (1.0 - g) - 1.0)
}

/// Exact shares with centre or uniform directions at g = .9.
///
/// Random axis: ∫ p(a·u) a dω_a = g u, so the mean of Σ w d·a over all axes is g ⟨m·d⟩, m the mean
/// vector of a patch and d the direction taken (its centre, or m itself).
#[test]
fn bias_of_centre_and_uniform() {
    let g = 0.9;
    let want =
        [(4, [5.21, 11.8, 14.9], 0.05), (8, [1.308, 2.53, 3.32], 0.005), (16, [0.3275, 0.60, 0.80], 0.005)];
    for (nside, [random, centre, uniform], digits) in want {
        let hp = Healpix::new(nside).unwrap();
        let n = hp.npix() as f64;
        let (mut c, mut u) = (0.0, 0.0);
        for pix in 0..hp.npix() {
            let m = hp.mean_vector(pix, None);
            c += m.dot(hp.centre(pix)) / n;
            u += m.dot(m) / n;
        }
        let population = populate_exact(&hp, &hg(g, DVec3::Z), None, 1e-12);
        let sap = Sap::new(hp, &population.shares, None).unwrap();
        let got = [
            bias(g, g * c),
            bias(g, sap.mean_cosine(SapDirections::Centre).unwrap()),
            bias(g, sap.mean_cosine(SapDirections::Uniform).unwrap()),
        ];
        println!("nside {nside}: {got:.4?}, uniform at a random axis {:.4}", bias(g, g * u));
        assert!((got[0] - random).abs() <= digits, "random axis {got:?}");
        assert!((got[1] - centre).abs() <= digits, "pole, centre {got:?}");
        assert!((got[2] - uniform).abs() <= digits, "pole, uniform {got:?}");
        let twice = bias(g, g * u) / bias(g, g * c);
        assert!((twice - 2.0).abs() < 0.02, "uniform is {twice} times centre");
        assert_eq!(sap.mean_cosine(SapDirections::Density), None);
    }
}

/// The mean over drawn axes is the closed form above, and the axis at the pole is not typical.
#[test]
fn bias_over_drawn_axes() {
    let (g, hp) = (0.9, Healpix::new(4).unwrap());
    let mut rng = Stream::of(3, 0, 0, Purpose::Probe);
    let axes = 1000;
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..axes {
        let z = 2.0 * rng.uniform() - 1.0;
        let (c, s) = rng.azimuth();
        let r = (1.0 - z * z).sqrt();
        let axis = DVec3::new(r * c, r * s, z);
        let shares = populate_exact(&hp, &hg(g, axis), None, 1e-9).shares;
        let mean = shares.iter().enumerate().map(|(p, w)| w * hp.centre(p).dot(axis)).sum();
        sum += bias(g, mean);
        squares += bias(g, mean) * bias(g, mean);
    }
    let n = f64::from(axes);
    let error = ((squares / n - (sum / n).powi(2)) / n).sqrt();
    println!("random axis, nside 4: {:.3} ± {error:.3} %", sum / n);
    assert!((sum / n - 5.21).abs() < 4.0 * error + 0.005);
    assert!((11.8 - sum / n) > 5.0);
}

/// ξ(cosθ) of Henyey–Greenstein: the share of light scattered beyond θ.
fn hg_cdf(g: f64, cos: f64) -> f64 {
    (1.0 - g * g) / (2.0 * g) * (1.0 / (1.0 + g * g - 2.0 * g * cos).sqrt() - 1.0 / (1.0 + g))
}

/// χ² of drawn cosines in 50 classes of equal probability, and the mean cosine with its error.
fn chi_square(sap: &Sap, how: SapDirections, g: f64) -> (f64, f64, f64) {
    let mut rng = Stream::of(4, 0, 0, Purpose::Probe);
    let density = hg(g, DVec3::Z);
    let draws = 400_000;
    let (mut hits, mut sum, mut squares) = ([0.0; 50], 0.0, 0.0);
    for _ in 0..draws {
        let patch = sap.draw(&mut rng);
        let u = sap.direction(patch, how, &mut rng, &density);
        hits[((hg_cdf(g, u.z) * 50.0) as usize).min(49)] += 1.0;
        sum += u.z;
        squares += u.z * u.z;
    }
    let n = f64::from(draws);
    let chi2 = hits.iter().map(|h| (h - n / 50.0).powi(2) / (n / 50.0)).sum();
    (chi2, sum / n, ((squares / n - (sum / n).powi(2)) / n).sqrt())
}

/// `density` has no bias; `uniform` and `centre` show theirs in the same test.
#[test]
fn density_directions_follow_the_law() {
    for (nside, g) in [(1, 0.5), (2, 0.9), (4, 0.9)] {
        let (hp, density) = (Healpix::new(nside).unwrap(), hg(g, DVec3::Z));
        // HG grows with the cosine: its bound is the value at the northern corner.
        let top = |z: f64| density(DVec3::new((1.0 - z * z).max(0.0).sqrt(), 0.0, z));
        let bounds: Vec<f64> = (0..hp.npix()).map(|p| top(hp.z_range(p).1)).collect();
        let shares = populate_exact(&hp, &density, None, 1e-10).shares;
        let sap = Sap::new(hp, &shares, None).unwrap().with_bounds(bounds.clone(), &density).unwrap();
        let (chi2, mean, error) = chi_square(&sap, SapDirections::Density, g);
        println!("nside {nside} g {g}: χ² {chi2:.1}, mean {mean:.5}, acceptance {:?}", sap.acceptance());
        // 49 degrees of freedom: 99.99 % quantile 95.
        assert!(chi2 < 95.0 && (mean - g).abs() < 4.0 * error, "{chi2} {mean} ± {error}");
        assert!(chi_square(&sap, SapDirections::Uniform, g).0 > 95.0);
        assert!(chi_square(&sap, SapDirections::Centre, g).0 > 95.0);
        let low = bounds.iter().map(|b| b * 0.9).collect();
        assert!(matches!(
            Sap::new(hp, &shares, None).unwrap().with_bounds(low, &density),
            Err(SapError::Bound { .. })
        ));
    }
}

#[test]
fn populate_centre_is_the_papers_way() {
    let axis = DVec3::new(0.3, -0.5, 0.8).normalize();
    for (nside, g) in [(1, 0.9), (4, 0.9), (16, 0.5)] {
        let hp = Healpix::new(nside).unwrap();
        let p = populate_centre(&hp, &hg(g, axis), None);
        let raw: f64 = (0..hp.npix()).map(|i| hg(g, axis)(hp.centre(i)) * hp.area()).sum();
        assert!((p.sum - raw).abs() < 1e-13 * raw);
        assert!((p.shares.iter().sum::<f64>() - 1.0).abs() < 1e-13);
        for (i, s) in p.shares.iter().enumerate() {
            assert!((s - hg(g, axis)(hp.centre(i)) * hp.area() / raw).abs() < 1e-15);
        }
    }
    // Raw sums stray far from 1 where the law is narrow.
    let one = |g, axis| populate_centre(&Healpix::new(1).unwrap(), &hg(g, axis), None).sum;
    assert!(one(0.99, DVec3::Z) < 0.1 && one(0.9, Healpix::new(1).unwrap().centre(0)) > 5.0);
    // Lambertian light: the cut patches carry their visible half only.
    let hp = Healpix::new(2).unwrap();
    let p = populate_centre(&hp, &|u| u.z / PI, Some(Half::Upper));
    assert!((p.sum - 1.0).abs() < 0.05, "{}", p.sum);
    assert!(
        p.shares.iter().enumerate().all(|(i, s)| (*s > 0.0) == (hp.share_in(i, Some(Half::Upper)) > 0.0))
    );
}

#[test]
fn wrong_tables_are_refused() {
    let hp = Healpix::new(1).unwrap();
    assert_eq!(Sap::new(hp, &[1.0; 11], None).unwrap_err(), SapError::Length { got: 11, want: 12 });
    assert_eq!(Sap::new(hp, &[0.0; 12], None).unwrap_err(), SapError::Empty);
    assert_eq!(
        Sap::new(hp, &[1.0; 12], Some(Half::Upper)).unwrap_err(),
        SapError::Hidden { patch: 8, share: 1.0 }
    );
    let sap = Sap::new(hp, &[2.0; 12], None).unwrap();
    assert!((sap.ratios().iter().sum::<f64>() - 1.0).abs() < 1e-15 && sap.sum() == 24.0);
}

#[test]
fn frames_stand_in_the_plane_of_incidence() {
    let normal = DVec3::new(0.2, -0.4, 0.9).normalize();
    let machine = DVec3::new(1.0, 0.5, 0.0).normalize();
    let side = (DVec3::X - normal * normal.x).normalize();
    for theta in [1e-6_f64, 0.3, 1.2, 1.57] {
        let (s, c) = theta.sin_cos();
        let incoming = side * s - normal * c;
        let surface = frame_surface(normal, incoming, machine);
        assert!((surface.x + side).length() < 1e-9 && (surface.z - normal).length() < 1e-15);
        let reflected = side * s + normal * c;
        assert!((surface.to_local(reflected) - DVec3::new(-s, 0.0, c)).length() < 1e-9);
        // Turning by θ in the plane of incidence carries one frame into the other.
        let turned = frame_specular(reflected, normal, machine);
        assert!((turned.y - surface.y).length() < 1e-9 && turned.x.dot(normal) > 0.0);
        let refracted = side * (s / 1.5) - normal * (1.0 - s * s / 2.25).sqrt();
        let below = frame_specular(refracted, -normal, machine);
        assert!(below.x.dot(side) < 0.0 && below.y.dot(side).abs() < 1e-9);
    }
    let upright = frame_surface(normal, -normal, machine);
    assert!((upright.x - (machine - normal * machine.dot(normal)).normalize()).length() < 1e-12);
    let f = frame_medium(normal, Some(0.25));
    let fixed = frame_medium(normal, None);
    assert!((f.x - fixed.y).length() < 1e-15 && (f.x.cross(f.y) - f.z).length() < 1e-15);
}

/// Equal ratios over the upper half, turned by θ: the visible lune holds 1 − θ/π of it.
#[test]
fn visible_share_of_a_lune() {
    for nside in [1, 2, 3, 8] {
        let hp = Healpix::new(nside).unwrap();
        let shares: Vec<f64> = (0..hp.npix()).map(|p| hp.share_in(p, Some(Half::Upper))).collect();
        let sap = Sap::new(hp, &shares, Some(Half::Upper)).unwrap();
        for (theta, roll) in [(0.0, 0.0), (0.1, 0.3), (0.7, 1.0), (1.2, 2.5), (FRAC_PI_2, 4.0)] {
            let frame = frame_medium(DVec3::new(theta.sin(), 0.0, theta.cos()), Some(roll / 7.0));
            let share = sap.visible_share(&frame, DVec3::Z, SapDirections::Centre, |_| 1.0);
            assert!((share - (1.0 - theta / PI)).abs() < 1e-6, "nside {nside} θ {theta}: {share}");
        }
    }
}

/// Drawing and splitting tell the same story for a turned SAP: frequencies and mean direction.
#[test]
fn draws_and_splits_agree_beyond_the_horizon() {
    let density = reflected(Law::Beckmann, 0.5, 0.0);
    for nside in [2, 3] {
        let hp = Healpix::new(nside).unwrap();
        let shares = populate_exact(&hp, &density, Some(Half::Upper), 1e-10).shares;
        let bounds = estimated_bounds(&hp, &density, Some(Half::Upper));
        let sap = Sap::new(hp, &shares, Some(Half::Upper)).unwrap().with_bounds(bounds, &density).unwrap();
        for (how, theta) in [
            (SapDirections::Centre, 1.2_f64),
            (SapDirections::Uniform, 1.2),
            (SapDirections::Density, 1.2),
            (SapDirections::Density, 0.4),
        ] {
            let specular = DVec3::new(-theta.sin(), 0.0, theta.cos());
            let frame = frame_specular(specular, DVec3::Z, DVec3::X);
            compare(&sap, &frame, how, &density);
        }
    }
}

fn compare(sap: &Sap, frame: &Frame, how: SapDirections, density: &dyn Fn(DVec3) -> f64) {
    let mut rng = Stream::of(5, 0, 0, Purpose::Probe);
    let n = sap.ratios().len();
    let (mut ratio, mut mean, mut squares) = (vec![0.0; n], DVec3::ZERO, 0.0);
    let repeats = 300.0;
    for _ in 0..repeats as usize {
        let mut one = DVec3::ZERO;
        sap.for_each_visible(frame, DVec3::Z, how, &mut rng, density, |patch, r, u| {
            assert!(u.z > 0.0, "{how:?}: {u}");
            ratio[patch] = r;
            one += u * r;
        });
        mean += one / repeats;
        squares += one.length_squared() / repeats;
    }
    assert!((ratio.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    let draws = 200_000;
    let (mut hits, mut drawn) = (vec![0.0; n], DVec3::ZERO);
    for _ in 0..draws {
        let (patch, u) = sap.draw_visible(frame, DVec3::Z, how, &mut rng, density).unwrap();
        assert!(u.z > 0.0);
        hits[patch] += 1.0;
        drawn += u / f64::from(draws);
    }
    let (mut chi2, mut freedom) = (0.0, -1.0);
    for (h, r) in hits.iter().zip(&ratio) {
        let want = r * f64::from(draws);
        if want > 10.0 {
            chi2 += (h - want) * (h - want) / want;
            freedom += 1.0;
        }
    }
    let sigma = (chi2 - freedom) / (2.0_f64 * freedom).sqrt();
    println!("{how:?}: χ² {chi2:.1} of {freedom}, mean {mean:.4} and {drawn:.4}");
    assert!(sigma < 4.5, "{how:?}: χ² {chi2} for {freedom}");
    let split_error = (squares - mean.length_squared()).max(0.0) / repeats;
    let error = (split_error + (1.0 - drawn.length_squared()) / f64::from(draws)).sqrt();
    assert!((mean - drawn).length() < 4.0 * error, "{how:?}: {mean} {drawn} ± {error}");
    // The unfolded ratios do not pass: the horizon matters.
    let raw: f64 = hits
        .iter()
        .zip(sap.ratios())
        .filter(|(_, r)| **r * f64::from(draws) > 10.0)
        .map(|(h, r)| (h - r * f64::from(draws)).powi(2) / (r * f64::from(draws)))
        .sum();
    assert!(raw > chi2 + 100.0, "{raw} {chi2}");
}

/// Nothing visible: None, not an endless loop.
#[test]
fn hidden_power_is_an_answer() {
    let hp = Healpix::new(2).unwrap();
    let mut shares = vec![0.0; hp.npix()];
    shares[0] = 1.0;
    let sap = Sap::new(hp, &shares, Some(Half::Upper)).unwrap();
    let frame = Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
    let mut rng = Stream::of(6, 0, 0, Purpose::Probe);
    assert!(sap.draw_visible(&frame, -DVec3::Z, SapDirections::Centre, &mut rng, |_| 1.0).is_none());
    assert_eq!(sap.visible_share(&frame, -DVec3::Z, SapDirections::Centre, |_| 1.0), 0.0);
}
