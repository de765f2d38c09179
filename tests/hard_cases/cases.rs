//! The rows of the table.

use crate::plain;
use crate::{Row, one};
use lightpro::material::fresnel;
use lightpro::math::{DVec3, fast, frame, orthonormal};
use lightpro::phase::henyey_greenstein;
use lightpro::rng::{Purpose, Stream};
use lightpro::stats::Fold;
use num_complex::Complex64;

fn row(
    case: &'static str,
    plain: impl Into<String>,
    ours: impl Into<String>,
    held: &'static [(&'static str, &'static str)],
) -> Row {
    let plain = plain.into();
    let plain = if plain == "-" { "no fault measured".to_owned() } else { plain };
    Row { case, plain, ours: ours.into(), held }
}

fn relative(got: f64, want: f64) -> f64 {
    (got / want - 1.0).abs()
}

pub fn all() -> Vec<Row> {
    let mut rows = fresnel_rows();
    rows.extend(phase_rows());
    rows.extend(geometry_rows());
    rows.extend(universe_rows());
    rows.extend(number_rows());
    rows
}

const FRESNEL: &str = "src/material/fresnel/tests.rs";

/// R of the textbook, unpolarised: Snell's law for the sine, then the amplitudes.
fn textbook(n1: f64, n2: f64, cos_i: f64) -> f64 {
    let sin_t = n1 / n2 * (1.0 - cos_i * cos_i).sqrt();
    let cos_t = (1.0 - sin_t * sin_t).sqrt();
    let rs = (n1 * cos_i - n2 * cos_t) / (n1 * cos_i + n2 * cos_t);
    let rp = (n2 * cos_i - n1 * cos_t) / (n2 * cos_i + n1 * cos_t);
    0.5 * (rs * rs + rp * rp)
}

fn fresnel_rows() -> Vec<Row> {
    // T at 89.999999 degrees from 1 to 1.5, first order in the cosine c: 4 c (n2² + 1)/(2 √(n2² − 1))…
    let c = 1e-6_f64.to_radians();
    let b = 1.25_f64.sqrt();
    // T⊥ = 4 c b/(c + b)², T∥ = 4 n² c b/(n² c + b)²: sums of positive terms, exact to rounding.
    let exact = 2.0 * c * b * (1.0 / (c + b).powi(2) + 2.25 / (2.25 * c + b).powi(2));
    let grazing =
        (relative(1.0 - textbook(1.0, 1.5, c), exact), relative(fresnel::dielectric(1.0, 1.5, c).t, exact));
    assert!(grazing.1 < 1e-14 && grazing.0 > 1e-12, "{grazing:?}");

    let critical = (1.0_f64 - 1.0 / 2.25).sqrt();
    let (inside, outside) = (critical * (1.0 - 1e-12), critical * (1.0 + 1e-12));
    let d = fresnel::dielectric(1.5, 1.0, inside);
    assert!(textbook(1.5, 1.0, inside).is_nan() && (d.r, d.t) == (1.0, 0.0));
    // Just transmitted: b² = n1²(c² − c_c²), T to first order in b.
    let d = fresnel::dielectric(1.5, 1.0, outside);
    let b = 1.5 * critical * 2e-12_f64.sqrt();
    let first = 2.0 * b * (1.0 / (1.5 * critical) + 1.5 / critical);
    let just = relative(d.t, first);
    assert!(just < 1e-3, "{just}");

    // Index step 1e-12 at 60 degrees: r⊥ = −δ/(2c²), r∥ = −δ(1 − 2c²)/(2c²)·… with c² = 1/4.
    let step = 1.0 + 1e-12;
    let delta = step - 1.0;
    let want = 0.5 * ((delta / 0.5_f64).powi(2) + (delta * 0.5 / 0.5_f64).powi(2));
    let matched =
        (relative(textbook(1.0, step, 0.5), want), relative(fresnel::dielectric(1.0, step, 0.5).r, want));
    assert!(matched.1 < 1e-10 && matched.0 > 1e-6, "{matched:?}");

    // Huge κ: what is absorbed, 4n/((n + 1)² + κ²), at normal incidence.
    let metal = Complex64::new(1.5, 1e9);
    let want = 6.0 / (6.25 + 1e18);
    let huge =
        (1.0 - ((metal - 1.0) / (metal + 1.0)).norm_sqr(), fresnel::interface(1.0.into(), metal, 1.0).t);
    assert!(relative(huge.1, want) < 1e-14 && relative(huge.0, want) > 0.5, "{huge:?}");

    // Both media absorb, beyond the critical angle: the principal root of kz² grows into the second medium.
    let (n1, n2) = (Complex64::new(2.0, 1.5), Complex64::new(1.0, 1e-3));
    let (mut worst, mut ours) = (0.0_f64, 0.0_f64);
    for k in 1..1000 {
        let c = f64::from(k) * 1e-3;
        let sin_t2 = (n1 / n2).powi(2) * (1.0 - c * c);
        let cos_t = (1.0 - sin_t2).sqrt();
        let r = ((n1 * c - n2 * cos_t) / (n1 * c + n2 * cos_t)).norm_sqr();
        worst = worst.max(r);
        let d = fresnel::interface(n1, n2, c);
        assert!((d.r + d.t - 1.0).abs() < 1e-15 && d.t >= 0.0);
        ours = ours.max(d.r);
    }
    assert!(ours <= 1.0);
    vec![
        row(
            "grazing incidence, 89.999999°",
            format!("T = 1 − R off by {}", one(grazing.0)),
            format!(
                "{} (below 1e-14)",
                if grazing.1 == 0.0 { "exact".into() } else { "rounding".to_string() }
            ),
            &[
                (FRESNEL, "transmission_near_grazing_keeps_its_relative_accuracy"),
                ("tests/tables/fresnel.rs", "fresnel.csv"),
            ],
        ),
        row(
            "total reflection, critical angle ± 1e-12",
            "NaN beyond it (root of a negative number)",
            "R = 1 exactly beyond it; T of the first order just before it",
            &[(FRESNEL, "total_reflection_is_exactly_one")],
        ),
        row(
            "index match, 1 ± 1e-12",
            format!("R off by {} at 60°", one(matched.0)),
            "below 1e-10 of R; R = 0 for equal indices",
            &[
                (FRESNEL, "index_match_has_the_small_reflectance_of_its_step"),
                (FRESNEL, "equal_media_have_no_interface"),
            ],
        ),
        row(
            "huge κ (1e9)",
            format!("absorbed share 1 − R = {} instead of {want:.0e}", one(huge.0)),
            "relative accuracy 1e-14",
            &[(FRESNEL, "no_input_gives_a_nan_or_power_out_of_nothing")],
        ),
        row(
            "tiny κ (1e-300)",
            "-",
            "as a dielectric",
            &[(FRESNEL, "no_input_gives_a_nan_or_power_out_of_nothing")],
        ),
        row(
            "absorbing on both sides",
            format!("no fault measured: R up to {worst:.2} with the principal root"),
            "R ≤ 1, R + T = 1 to 1e-15",
            &[
                (FRESNEL, "no_input_gives_a_nan_or_power_out_of_nothing"),
                (FRESNEL, "an_absorbing_wall_never_reflects_more_than_all"),
            ],
        ),
    ]
}

fn phase_rows() -> Vec<Row> {
    let plain = |g: f64, xi: f64| {
        let s = (1.0 - g * g) / (1.0 - g + 2.0 * g * xi);
        (1.0 + g * g - s * s) / (2.0 * g)
    };
    assert!(plain(0.0, 0.3).is_nan());
    let small = (plain(1e-15, 0.3) - (2.0 * 0.3 - 1.0)).abs();
    let (near, _, _) = henyey_greenstein::polar(0.3, 1e-15);
    assert!((near - 1.4).abs() < 1e-14);
    let g = 1.0 - 1e-9;
    let (near, _, _) = henyey_greenstein::polar(0.3, g);
    let sharp = relative(1.0 - plain(g, 0.3), near);
    assert!(small > 1e-3 && sharp > 1e-3, "{small} {sharp}");
    let t = 1e-12;
    let thin =
        (relative(1.0 - (-t_of(t)).exp(), t_of(t)), relative(fast::one_minus_exp_neg(t), -(-t).exp_m1()));
    assert!(thin.1 < 1e-15 && thin.0 > 1e-6);
    vec![
        row(
            "g = 0",
            "NaN",
            "isotropic, no branch",
            &[
                ("tests/chi_square_phase.rs", "the_test_bites"),
                ("tests/tables/phase.rs", "phase_inverse_cdf.csv"),
            ],
        ),
        row(
            "g = 1e-15",
            format!("cosine off by {}", one(small)),
            "1e-15 relative",
            &[("tests/tables/phase.rs", "phase_inverse_cdf.csv")],
        ),
        row(
            "g = ±(1 − 1e-9)",
            format!("1 − cos θ off by {}", one(sharp)),
            "1e-15 relative",
            &[("tests/tables/phase.rs", "phase_inverse_cdf.csv")],
        ),
        row(
            "roughness 0, 1e-6, 1",
            "-",
            "0 is the smooth surface; slopes keep their law",
            &[("src/microfacet/tests.rs", "extreme_slopes_and_grazing_stay_finite")],
        ),
        row(
            "optical depth 1e-12",
            format!("1 − exp(−τ) off by {}", one(thin.0)),
            "2 ulp",
            &[("src/math/fast.rs", "one_minus_exp_neg_keeps_small_arguments")],
        ),
        row(
            "optical depth 1e6; albedo 1, τ = 1e4",
            "-",
            "ledger of each history closes to 1e-12",
            &[
                ("scenes/hard/white-slab.xml", "1e4"),
                ("tests/hard_cases/relations.rs", "deep_slabs_keep_their_ledger"),
            ],
        ),
    ]
}

fn t_of(t: f64) -> f64 {
    std::hint::black_box(t)
}

const HARD: &str = "tests/synthetic_universe/hard_cases.rs";

/// Distance from the unit sphere at which b² − 4ac puts a hit, seen from `far` radii away.
fn plain_sphere(far: f64) -> f64 {
    let mut s = Stream::of(1, 0, 0, Purpose::Probe);
    let (mut worst, mut missed) = (0.0_f64, 0);
    for _ in 0..1000 {
        let turn = std::f64::consts::TAU * s.uniform();
        let offset = 0.9 * s.uniform();
        let dir = DVec3::new(0.6, 0.64, 0.48);
        let (x, y) = orthonormal(dir);
        let origin = (x * turn.cos() + y * turn.sin()) * offset - dir * far;
        let (b, c) = (2.0 * origin.dot(dir), origin.length_squared() - 1.0);
        let d = b * b - 4.0 * c;
        if d < 0.0 {
            missed += 1;
            continue;
        }
        let hit = origin + dir * (0.5 * (-b - d.sqrt()));
        worst = worst.max((hit.length() - 1.0).abs());
    }
    worst.max(f64::from(missed) * 1e-3)
}

fn geometry_rows() -> Vec<Row> {
    let (million, far) = (plain_sphere(1e6), plain_sphere(1e8));
    assert!(million > 1e-6 && far > 1e-2, "{million} {far}");
    // A ray that starts on the sphere, as rounded, and looks in: the near root should be itself.
    let mut s = Stream::of(2, 0, 0, Purpose::Probe);
    let (mut twice, n) = (0, 10_000);
    for _ in 0..n {
        let p = DVec3::new(s.normal(), s.normal(), s.normal()).normalize();
        let d = DVec3::new(s.normal(), s.normal(), s.normal()).normalize();
        // Outwards: nothing should be met.
        let d = if d.dot(p) < 0.0 { -d } else { d };
        let (b, c) = (2.0 * p.dot(d), p.length_squared() - 1.0);
        let root = (b * b - 4.0 * c).max(0.0).sqrt();
        twice += u32::from(0.5 * (-b + root) > 0.0);
    }
    let again = f64::from(twice) / f64::from(n);
    assert!(again > 0.1);
    // Frame of the textbook, x = (1, 0, 0) × n … by division by 1 + nz.
    let n = DVec3::new(0.0, 0.0, -1.0);
    let plain = 1.0 / (1.0 + n.z);
    let (x, y) = orthonormal(n);
    let off = (x.length() - 1.0).abs().max((y.length() - 1.0).abs()).max(x.dot(y).abs()).max(x.dot(n).abs());
    assert!(plain.is_infinite() && off < 1e-15);
    // A million turns without renormalising.
    let (mut bare, mut kept) = (DVec3::Z, DVec3::Z);
    for _ in 0..1_000_000 {
        let (c, (cp, sp)) = (2.0 * s.uniform() - 1.0, s.azimuth());
        let sin = (1.0 - c * c).sqrt();
        let (x, y) = orthonormal(bare);
        bare = x * (sin * cp) + y * (sin * sp) + bare * c;
        kept = frame::deflect(kept, c, sin, cp, sp);
    }
    let drift = ((bare.length() - 1.0).abs(), (kept.length() - 1.0).abs());
    assert!(drift.1 < 1e-15);
    let whispering = match plain::whispering(1e-7) {
        (_, Some(n)) => format!("meets the wall where it stands, or never, after {n} reflections"),
        (off, None) => format!("off the wall by {} after 1e6 reflections", one(off)),
    };
    vec![
        row(
            "coincident, tangent and nested surfaces",
            format!("a film of {} of the thickness between them", one(plain::film())),
            "no film: the state decides, not the point",
            &[(HARD, "layers_in_contact_have_no_film_between"), (HARD, "tangent_and_equal_bodies")],
        ),
        row(
            "wall 1e-9 of the radius",
            format!("seen from 1e6 radii its thickness is off by {} of itself", one(plain::thin_wall())),
            "crossed twice",
            &[(HARD, "a_wall_of_a_billionth_of_the_radius_is_crossed_twice")],
        ),
        row(
            "zero lumen",
            format!("x²/a² = {}", plain::zero_axis()),
            "holds nothing",
            &[(HARD, "zero_and_collapsed_lumens_hold_nothing")],
        ),
        row(
            "fully collapsed fibre",
            format!("x²/a² = {}", plain::zero_axis()),
            "holds nothing",
            &[(HARD, "zero_and_collapsed_lumens_hold_nothing")],
        ),
        row(
            "V-grooves between overlapping fibres",
            "-",
            "overlaps of one medium hide their smooth surfaces; no ray lost, and in their tip, 1e-13 radii from the edge, none enters the surface that it is leaving",
            &[
                (
                    "tests/statistical_universe/stress.rs",
                    "deep_in_a_groove_no_surface_is_entered_from_behind",
                ),
                (HARD, "overlaps_of_one_medium_hide_their_smooth_surfaces"),
                ("tests/synthetic_universe/union.rs", "walls_win_over_hollows_and_merge"),
            ],
        ),
        row(
            "borders of the cells of a height map, grazing its surface",
            "-",
            "a million crossings, none lost; the medium told is the one that is there",
            &[
                ("tests/height_map.rs", "no_ray_is_lost_under_stress"),
                ("tests/topography.rs", "what_is_told_is_there"),
            ],
        ),
        row(
            "whispering rays in smooth fibres",
            whispering,
            "a million reflections, on the surface",
            &[(HARD, "whispering_rays_stay")],
        ),
        row(
            "ray along the axis of a cylinder",
            format!("root of the quadratic = {}", plain::along_axis()),
            "for ever in wall or lumen, or through its ends",
            &[(HARD, "rays_along_the_axis")],
        ),
        row(
            "ray in the plane of in-plane fibres",
            format!("{:.2} of the rays that touch are taken for hits", plain::tangent()),
            "tangent: no hit",
            &[(HARD, "rays_along_the_axis")],
        ),
        row(
            "origin 1e6 radii away",
            format!("hits off by {} radii", one(million)),
            "below 1e-8",
            &[(HARD, "hits_stay_on_the_surface_a_million_radii_away")],
        ),
        row(
            "origin 24 mm or 1 km from the body (1e8 radii)",
            format!("hits off, or missed, by {}", one(far)),
            "below 1e-6",
            &[(HARD, "hits_stay_on_the_surface_a_million_radii_away")],
        ),
        row(
            "scale 1e-6 … 1e6 of the same scene",
            format!(
                "an offset of 1e-4 carries {} of the light unseen through the wall of a sphere of 1e-3",
                one(plain::epsilon())
            ),
            "the same bytes for 2^±20, 3 standard errors for 10^±6",
            &[("tests/hard_cases/relations.rs", "scale_changes_nothing")],
        ),
        row(
            "ray starting on a surface",
            format!("meets it again in {again:.1} of the starts outwards"),
            "never: the root of the surface just left is taken out",
            &[(HARD, "starts_on_a_surface_go_where_they_look"), (HARD, "states_outrank_rounding")],
        ),
        row(
            "direction components exactly 0 or −0",
            format!("slab test: 0 · ∞ = {}", plain::zero_direction()),
            "no NaN",
            &[
                (HARD, "half_spaces_and_edges"),
                (HARD, "rays_along_the_axis"),
                ("tests/voxel_universe/walks.rs", "fn stressed"),
            ],
        ),
        row(
            "n = (0, 0, −1) frames",
            "1/(1 + n_z) = ∞",
            format!("orthonormal to {}", if off == 0.0 { "the bit".to_owned() } else { one(off) }),
            &[("src/math/frame.rs", "frames_are_orthonormal_everywhere")],
        ),
        row(
            "unit length after 1e6 turns",
            format!("no fault measured: off by {}", one(drift.0)),
            "below 1e-15",
            &[("src/math/frame.rs", "a_million_deflections_keep_unit_length")],
        ),
    ]
}

fn universe_rows() -> Vec<Row> {
    vec![
        row(
            "voxel corners and edges",
            format!("{:.2} of the steps stay in their voxel", plain::diagonal()),
            "1e8 stressed crossings, none lost",
            &[
                ("tests/voxel_universe/walks.rs", "a_million_stressed_crossings_lose_no_ray"),
                ("tests/voxel_universe/walks.rs", "a_hundred_million_stressed_crossings_lose_no_ray"),
            ],
        ),
        row(
            "HEALPix poles",
            "no fault measured: atan2(0, 0) = 0",
            "a patch that touches",
            &[("tests/tables/healpix.rs", "poles_and_the_seam")],
        ),
        row(
            "HEALPix φ just below 0 or 2π",
            format!("place {} in a ring that ends at 3", plain::seam()),
            "the first or last patch of the ring",
            &[("tests/tables/healpix.rs", "poles_and_the_seam")],
        ),
        row(
            "HEALPix patch borders",
            "-",
            "a patch that touches",
            &[("tests/tables/healpix.rs", "borders_answer_with_a_patch_that_touches")],
        ),
        row(
            "event cap",
            format!("no end for {:.2} of the light", plain::trapped()),
            "power truncated, booked, its history recorded",
            &[("tests/hard_cases/relations.rs", "the_event_cap_books_what_it_cuts")],
        ),
        row(
            "pocket traps",
            format!("no end for {:.2} of the light", plain::trapped()),
            "roulette and event cap end them; the ledger closes",
            &[("tests/hard_cases/relations.rs", "the_event_cap_books_what_it_cuts")],
        ),
    ]
}

fn number_rows() -> Vec<Row> {
    // 2^24 scores of 0.1: one after the other, and in a tree over batches of 4096.
    let n = 1_u64 << 24;
    let (mut plain, mut single, mut fold) = (0.0_f64, 0.0_f32, Fold::default());
    for _ in 0..n / 4096 {
        let mut batch = 0.0;
        for _ in 0..4096 {
            plain += 0.1;
            single += 0.1;
            batch += 0.1;
        }
        fold.push(batch);
    }
    let want = 0.1 * n as f64;
    let (plain, single, ours) =
        (relative(plain, want), relative(f64::from(single), want), relative(fold.finish().unwrap(), want));
    assert!(ours < 1e-13 && plain > 5.0 * ours && single > 1e-2, "{plain} {single} {ours}");
    // The exponential of a uniform number in [0, 1) by −ln.
    let infinite = -(0.0_f64).ln();
    let mut s = Stream::of(3, 0, 0, Purpose::Probe);
    let longest = (0..1_000_000).map(|_| s.exponential()).fold(0.0, f64::max);
    assert!(infinite.is_infinite() && longest < 80.0);
    let smallest = -s.uniform_positive().min(1.0 / 9_007_199_254_740_992.0).ln();
    assert!((smallest - 36.7).abs() < 0.1);
    // A denormal weight: its square is nothing.
    let weight = f64::MIN_POSITIVE / 8.0;
    assert!(weight > 0.0 && weight * weight == 0.0 && fast::one_minus_exp_neg(weight) == weight);
    vec![
        row(
            "sums over 1e10 scores",
            format!("2^24 terms one by one: off by {} (single precision {})", one(plain), one(single)),
            "below 1e-13: batches in a binary tree, error ~ log₂ of their number",
            &[("tests/laws/statistics.rs", "fold")],
        ),
        row(
            "denormal weights",
            format!("survivors of roulette amplified by 1/w = {}", 1.0 / weight),
            "absorbed and summed like others; roulette ends them",
            &[("tests/hard_cases/cases.rs", "denormal")],
        ),
        row(
            "wavelength at the ends of a table",
            format!("entry {} of a table that ends at 3", plain::table_end()),
            "the ends belong to the table; beyond is an error that names it",
            &[("tests/bad_input.rs", "wavelengths_outside_a_table")],
        ),
        row(
            "one-bin histograms",
            format!("χ² per degree of freedom = {}", plain::one_bin()),
            "p = 1",
            &[("tests/laws/statistics.rs", "goodness_of_fit_tests_notice_a_wrong_law")],
        ),
        row(
            "−ln u at u = 0",
            "∞",
            "never drawn: the ziggurat's longest of 1e6 draws is finite",
            &[("src/rng/tests.rs", "exponential_follows_its_law")],
        ),
        row(
            "−ln u at u = 1 and the smallest u",
            "−0 and a cut tail at 36.7",
            "tail without end, lengths ≥ 0",
            &[("src/rng/tests.rs", "exponential_follows_its_law")],
        ),
    ]
}
