//! BRDF in exact directions by next-event estimation: closed forms, reciprocity, gain.

use super::*;
use lightpro::math::gauss_legendre;
use std::f64::consts::PI;

/// Chandrasekhar's H for isotropic scattering of albedo ω: 1/H(µ) = √(1 − ω) + (ω/2) ∫ µ′H(µ′)/(µ + µ′) dµ′.
fn h_function(albedo: f64) -> impl Fn(f64) -> f64 {
    let nodes = gauss_legendre(64, 0.0, 1.0);
    let at = move |mu: f64, nodes: &[(f64, f64)], h: &[f64]| {
        let sum: f64 = nodes.iter().zip(h).map(|((m, w), h)| w * m * h / (mu + m)).sum();
        1.0 / ((1.0 - albedo).sqrt() + 0.5 * albedo * sum)
    };
    let mut h = vec![1.0; nodes.len()];
    for _ in 0..500 {
        h = nodes.iter().map(|(m, _)| at(*m, &nodes, &h)).collect();
    }
    move |mu| at(mu, &nodes, &h)
}

fn brdf(material: &str, slabs: &str, polar: f64, rest: &str, histories: u64) -> Finished {
    let rest = format!(r#"<source polar="{polar} deg"/><detect {rest}</detect>"#);
    run(&scene(material, "", slabs, &rest), histories)
}

const DEEP: &str = r#"<slab z-min="-1000 um" z-max="0 um" material="paper"/>"#;
const ISOTROPIC: &str =
    r#"<material id="paper" index="1" absorption="0.01 1/um"><scattering mu-s="0.09 1/um"/></material>"#;

/// A half space: f = ω/(4π) H(µ) H(µ0)/(µ + µ0).
#[test]
fn an_isotropic_half_space_has_chandrasekhars_brdf() {
    let h = h_function(0.9);
    let cos = |deg: f64| deg.to_radians().cos();
    for incidence in [0.0, 60.0] {
        let views = r#"><view polar="0 deg"/><view polar="30 deg" azimuth="70 deg"/><view polar="75 deg" azimuth="180 deg"/>"#;
        let done = brdf(ISOTROPIC, DEEP, incidence, views, 200_000);
        let got: Vec<_> = done.result.figures.iter().filter(|f| f.name == "brdf").collect();
        assert_eq!(got.len(), 3);
        for f in got {
            let (m, m0) = (cos(f.polar_deg.unwrap()), cos(incidence));
            let want = 0.9 / (4.0 * PI) * h(m) * h(m0) / (m + m0);
            agree(
                &format!("{incidence} -> {:?}", f.polar_deg),
                (f.value.unwrap(), f.error.unwrap()),
                want,
                1e-5,
            );
        }
    }
}

/// Two layers of other albedo and phase function: f(i, o) = f(o, i).
#[test]
fn the_brdf_of_a_layered_slab_is_reciprocal() {
    let materials = r#"<material id="top" index="1" absorption="0.002 1/um"><scattering mu-s="0.03 1/um" g="0.8"/></material>
        <material id="base" index="1" absorption="0.01 1/um"><scattering mu-s="0.05 1/um" g="-0.3"/></material>"#;
    let slabs = r#"<slab z-min="-100 um" z-max="0 um" material="base"/><slab z-min="0 um" z-max="30 um" material="top"/>"#;
    for (i, o) in [(0.0, 60.0), (20.0, 70.0), (45.0, 80.0)] {
        let of = |from: f64, to: f64| {
            figure(
                &brdf(
                    materials,
                    slabs,
                    from,
                    &format!(r#"><view polar="{to} deg" azimuth="40 deg"/>"#),
                    300_000,
                ),
                "brdf",
                None,
            )
        };
        let (a, b) = (of(i, o), of(o, i));
        let z = (a.0 - b.0) / (a.1 * a.1 + b.1 * b.1).sqrt();
        println!("{i} <-> {o}: {:.5} ± {:.5}, {:.5} ± {:.5}, z {z:.2}", a.0, a.1, b.0, b.1);
        assert!(z.abs() < 4.0);
        // The check bites: exitances without the cosine are not reciprocal.
        let c = |deg: f64| deg.to_radians().cos();
        let off = (a.0 * c(o) - b.0 * c(i)) / ((a.1 * c(o)).powi(2) + (b.1 * c(i)).powi(2)).sqrt();
        assert!(off.abs() > 10.0);
    }
}

/// Light turned round through a slab of two layers: what goes down from i to o goes up from o to i, which is
/// what goes down through the slab upside down.
#[test]
fn the_btdf_of_a_layered_slab_is_reciprocal() {
    let materials = r#"<material id="top" index="1" absorption="0.002 1/um"><scattering mu-s="0.03 1/um" g="0.8"/></material>
        <material id="base" index="1" absorption="0.01 1/um"><scattering mu-s="0.05 1/um" g="-0.3"/></material>"#;
    let slabs = |upper: &str, lower: &str, plane: f64| {
        format!(
            r#"<slab z-min="-20 um" z-max="{plane} um" material="{lower}"/><slab z-min="{plane} um" z-max="30 um" material="{upper}"/>"#
        )
    };
    let (as_is, upside_down) = (slabs("top", "base", 0.0), slabs("base", "top", 10.0));
    for (i, o) in [(0.0, 60.0), (20.0, 70.0), (45.0, 75.0)] {
        let of = |slabs: &str, from: f64, to: f64| {
            let view = format!(r#"><view polar="{} deg" azimuth="40 deg"/>"#, 180.0 - to);
            figure(&brdf(materials, slabs, from, &view, 300_000), "btdf", None)
        };
        let (a, b) = (of(&as_is, i, o), of(&upside_down, o, i));
        let z = (a.0 - b.0) / (a.1 * a.1 + b.1 * b.1).sqrt();
        println!("{i} <-> {o}: {:.5} ± {:.5}, {:.5} ± {:.5}, z {z:.2}", a.0, a.1, b.0, b.1);
        assert!(a.0 > 0.0 && z.abs() < 4.0);
        // The check bites: exitances without the cosine are not reciprocal.
        let c = |deg: f64| deg.to_radians().cos();
        let off = (a.0 * c(o) - b.0 * c(i)) / ((a.1 * c(o)).powi(2) + (b.1 * c(i)).powi(2)).sqrt();
        assert!(off.abs() > 10.0);
    }
}

/// The floor of a clear gap is seen as 1/π from everywhere; a wall before it is not looked through.
#[test]
fn a_lambertian_floor_is_seen_and_hidden() {
    let surfaces = r#"<surface id="white" kind="lambertian" reflectance="0.8" opaque="yes"/>"#;
    let bodies = |roof: &str| {
        format!(
            r#"<slab z-min="0 um" z-max="100 um" material="air"/>
               <slab z-min="-10 um" z-max="0 um" material="air" surface="white"/>{roof}"#
        )
    };
    let rest = r#"<detect><view polar="50 deg"/></detect>"#;
    let open = run(&scene("", surfaces, &bodies(""), rest), 10_000);
    let (value, error) = figure(&open, "brdf", None);
    assert!((value - 0.8 / PI).abs() < 1e-9 && error < 1e-9, "{value} {error}");
    // The line from the lit spot at 50 deg passes (x, z) = (59.6, 50) um.
    let roof = r#"<box min="50 -10 45 um" max="70 10 55 um" material="air" surface="white"/>"#;
    let shut = run(&scene("", surfaces, &bodies(roof), rest), 10_000);
    // What is left comes by way of the roof: less than a tenth.
    let (hidden, _) = figure(&shut, "brdf", None);
    assert!(hidden < 0.1 * value, "{hidden}");
}

/// Variance for equal histories against the patch of the same direction (nside 8): the gain is printed.
#[test]
fn next_events_gain_over_patches() {
    let done =
        brdf(ISOTROPIC, DEEP, 0.0, r#"angular="nside 8"><view polar="30 deg" azimuth="70 deg"/>"#, 100_000);
    let view = figure(&done, "brdf", None);
    let group = &done.outcome.groups[0];
    let directions = lightpro::report::directions::Directions::leaving(&done.scene, group).unwrap();
    let rows = lightpro::report::directions::bsdf_rows(&directions, group, 0);
    // Azimuths of patches count from the mirror direction: light along x = 0 comes from azimuth 0.
    let near = rows
        .iter()
        .filter(|r| r.kind == "brdf")
        .min_by(|a, b| {
            let off = |r: &lightpro::report::directions::BsdfRow| {
                (r.polar_deg - 30.0).powi(2) + ((r.azimuth_deg - 250.0) * 0.5).powi(2)
            };
            off(a).total_cmp(&off(b))
        })
        .unwrap();
    let gain = (near.error_per_sr / view.1).powi(2);
    println!(
        "patch {:.5} ± {:.5}, view {:.5} ± {:.5}: variance {gain:.0} times smaller",
        near.f_per_sr, near.error_per_sr, view.0, view.1
    );
    assert!(((near.f_per_sr - view.0) / near.error_per_sr).abs() < 4.5);
    assert!(gain > 20.0, "{gain}");
}

/// Scenes in which it would miss light are refused with the reason.
#[test]
fn mirrors_are_refused() {
    let glass = r#"<material id="paper" index="1.5"><scattering mu-s="1 1/mm"/></material>"#;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/test.xml");
    let text = scene(glass, "", DEEP, r#"<detect><view polar="30 deg"/></detect>"#);
    let read = read_text(&text, &path, &Options::default()).unwrap_or_else(|d| panic!("{d}"));
    let refused = lightpro::scene::plan::Plan::new(&read).unwrap_err();
    assert!(refused.contains("indices differ"), "{refused}");
}

/// The picture of the report: bodies and paths where they are, the same bytes each time; other histories give
/// other paths and the same bodies.
#[test]
fn the_sheet_and_its_light_are_drawn() {
    let material = r#"<material id="wall" index="1.5"/>"#;
    let bodies = r#"<sphere centre="0 0 -30 um" radius="20 um" material="wall"/><sphere centre="30 10 -60 um" radius="15 um" material="wall"/>"#;
    let done = run(&scene(material, "", bodies, r#"<source polar="0 deg"/>"#), 4096);
    let view = |scene: &lightpro::scene::Scene| lightpro::report::view::svg(scene, &done.plan).unwrap();
    let (svg, caption) = view(&done.scene);
    assert_eq!((&svg, &caption), (&view(&done.scene).0, &view(&done.scene).1));
    let part = |svg: &str, class: &str| {
        let at = svg.find(&format!("<g class=\"{class}\"")).unwrap();
        svg[at..at + svg[at..].find("</g>").unwrap()].to_owned()
    };
    assert!(svg.matches("class=\"v-path\"").count() > 1 && svg.matches("class=\"v-grid\"").count() == 1);
    assert!(part(&svg, "v-bodies").matches('z').count() >= 6, "two balls");
    assert!(svg.contains("wall") && svg.contains("µm") && caption.contains("nside"));
    let mut other = done.scene.clone();
    other.run.seed += 1;
    let (changed, _) = view(&other);
    assert_eq!(part(&svg, "v-bodies"), part(&changed, "v-bodies"));
    assert!(svg != changed);
}

/// What a user sees of reciprocity: a figure beside the Klems matrix. Isotropic scattering keeps it, facets whose
/// masked light is given back by their albedo do not.
#[test]
fn reciprocity_is_a_figure_of_the_klems_basis() {
    let rest = r#"<source kind="diffuse"/><detect klems="yes"/>"#;
    let defect = |done: &Finished| {
        let f = done.result.figures.iter().find(|f| f.name == "brdf_reciprocity_defect").unwrap();
        (f.value.unwrap(), f.error.unwrap())
    };
    let (kept, se) = defect(&run(&scene(ISOTROPIC, "", DEEP, rest), 400_000));
    println!("isotropic {kept} ± {se}");
    assert!(kept.abs() < 4.0 * se && se < 2e-3, "{kept} ± {se}");
    let facets = r#"<surface id="rough" kind="rough" m="0.7" multiple-bounce="renormalised" reflectance="1" opaque="yes"/>"#;
    let slab = r#"<slab z-min="-10 um" z-max="0 um" material="air" surface="rough"/>"#;
    let (broken, se) = defect(&run(&scene("", facets, slab, rest), 400_000));
    println!("renormalised facets {broken} ± {se}");
    assert!(broken.abs() > 8.0 * se, "{broken} ± {se}");
}
