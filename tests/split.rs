//! Branching `split`, every patch of every event, against `sample`, one drawn direction: the same means,
//! every ledger closed.
#![allow(clippy::disallowed_methods, missing_docs)]

#[path = "tables/harness.rs"]
#[allow(dead_code)]
mod harness;
#[path = "tables/transport.rs"]
#[allow(dead_code)]
mod transport;

use harness::{Check, Row, hold, rows};
use lightpro::lpm::light::MediumSap;
use lightpro::lpm::patches::{SapRule, SurfaceSap};
use lightpro::lpm::surface::{Directions, Ratio, SurfaceLaw};
use lightpro::lpm::{Light, Medium, World};
use lightpro::microfacet::{Microfacet, Slopes};
use lightpro::phase::Phase;
use lightpro::sap::SapDirections;
use lightpro::scene::optics;
use lightpro::source::Source;
use lightpro::universe::sheet::Slab;
use lightpro::universe::statistical::{Population, Rules, Rung, StatisticalUniverse};
use lightpro::universe::{MediumId, SurfaceId};
use transport::{AIR, OWN, Totals, diffuse, light, plain, totals, world};

const NSIDE: u32 = 2;
const FLOOR: f64 = 0.02;

fn rule(directions: SapDirections) -> SapRule {
    SapRule { nside: NSIDE, exact: true, directions, resolved: true, roll_random: true }
}

/// A slab of the table.
struct Case {
    universe: StatisticalUniverse,
    light: Light<1>,
    source: Source,
    backing: Option<f64>,
    height: f64,
}

fn layers(row: &Row) -> Vec<[f64; 4]> {
    serde_json::from_str(row.text("layers[(n,albedo,g,tau)...top to bottom]")).unwrap()
}

impl Case {
    fn of(row: &Row, shift_g: f64) -> Self {
        let layers = layers(row);
        let height: f64 = layers.iter().map(|l| l[3]).sum();
        let mut media = vec![Medium::clear(row.f("n_top"))];
        let (mut slabs, mut top) = (Vec::new(), height);
        for (i, [n, albedo, g, tau]) in layers.iter().enumerate() {
            let g = g + shift_g;
            let phase = if g == 0.0 { Phase::Isotropic } else { Phase::HenyeyGreenstein(g) };
            media.push(Medium::clear(*n).with([1.0 - albedo], *albedo, phase));
            let bottom = if i + 1 == layers.len() { 0.0 } else { top - tau };
            slabs.push(plain(top, bottom, MediumId(i as u16 + 1)));
            top = bottom;
        }
        let backing = row.maybe("lambert_bottom");
        let centre = lightpro::math::DVec3::new(0.0, 0.0, height);
        let source = match row.text("incidence(mu0 in top medium|diffuse)") {
            "diffuse" => diffuse(height),
            mu => Source::collimated(mu.parse::<f64>().unwrap().acos(), 0.0, centre, 0.0),
        };
        Case {
            universe: sheet(slabs, backing.is_some()),
            light: Light { media, surfaces: vec![SurfaceLaw::default()], lanes: 1 },
            source,
            backing,
            height,
        }
    }

    /// The usual world on this backing.
    fn world(&self) -> World<'_, StatisticalUniverse, 1> {
        World { backing: self.backing, ..world(&self.universe, &self.light, self.height) }
    }
}

fn sheet(slabs: Vec<Population>, backing: bool) -> StatisticalUniverse {
    let rules = Rules {
        rung: Rung::Homogeneous,
        outside: AIR,
        bottom_surface: slabs[0].slab.surface,
        contained: false,
        start_in_bodies: false,
        backing,
        clear: [false; 2],
    };
    StatisticalUniverse::new(slabs, rules)
}

/// Deviation from the table in units of 4 standard errors.
fn deviation(row: &Row, t: &Totals) -> f64 {
    let mut worst = 0.0_f64;
    for ((got, se), column) in [(t.r(), "R_total"), (t.t(), "T_total")] {
        if let Some(want) = row.maybe(column) {
            worst = worst.max((got - want).abs() / (4.0 * se).max(1e-8));
        }
    }
    worst
}

/// Rows that split and scatter noticeably: every fifth with 0.05 ≤ τ ≤ 2 and albedo above 0.
fn chosen(row: &Row) -> bool {
    let tau: f64 = layers(row).iter().map(|l| l[3]).sum();
    let scatters = layers(row).iter().any(|l| l[1] * l[3] > 0.02);
    (0.05..=2.0).contains(&tau) && scatters && row.line.is_multiple_of(5)
}

const NOT_CHOSEN: &str = "τ above 2 or hardly any scattering, or one of four in five left out for time";

/// Every event over all 48 patches against adding–doubling.
#[test]
fn split_agrees_with_slab_totals() {
    let (mut gs, mut stepped) = (std::collections::BTreeSet::new(), 0);
    for row in rows("slab_totals.csv").iter().filter(|r| chosen(r)) {
        layers(row).iter().for_each(|l| {
            gs.insert(l[2].to_string());
        });
        stepped += usize::from(layers(row).iter().any(|l| l[0] != row.f("n_top")));
    }
    println!("asymmetries {gs:?}, {stepped} rows with steps of the index");
    hold("slab_totals.csv", |row| {
        if !chosen(row) {
            return Check::Cannot(NOT_CHOSEN);
        }
        let case = Case::of(row, 0.0);
        let split = optics::split(&case.light, NSIDE, FLOOR).unwrap();
        let world = World { split: Some(&split), roulette: 0.0, ..case.world() };
        let mut count = 10_000;
        let mut t = totals(&world, &case.source, count);
        while t.r().1.max(t.t().1) > 0.95e-3 {
            count *= 4;
            t = totals(&world, &case.source, count);
        }
        Check::Deviation(deviation(row, &t))
    });
    assert!(gs.len() >= 3 && stepped >= 3);
    let count = rows("slab_totals.csv").iter().filter(|r| chosen(r)).count();
    assert!(count >= 12, "{count} rows");
}

/// Directions by density inside a patch are unbiased: `sample` over the SAP gives the continuous law's
/// totals; patch centres, the paper's way, do not.
#[test]
fn density_directions_are_unbiased() {
    let table = rows("slab_totals.csv");
    let (mut checked, mut worst, mut centred) = (0, 0.0_f64, 0.0_f64);
    for row in table.iter().filter(|r| chosen(r) && layers(r).iter().any(|l| l[1] * l[3] > 0.5)) {
        let with = |directions, histories| {
            let mut case = Case::of(row, 0.0);
            for m in &mut case.light.media {
                m.sap = (m.mu_s > 0.0).then(|| MediumSap::new(&m.phase, &rule(directions)).unwrap());
            }
            deviation(row, &totals(&case.world(), &case.source, histories))
        };
        let d = with(SapDirections::Density, 1_600_000);
        assert!(d <= 1.0, "{} line {}: {d}", row.text("case"), row.line);
        (checked, worst) = (checked + 1, worst.max(d));
        centred = centred.max(with(SapDirections::Centre, 400_000));
    }
    println!("{checked} rows, worst {worst:.3} of 4 standard errors; patch centres up to {centred:.1}");
    assert!(checked >= 5 && centred > 2.0);
}

/// The tolerance bites: g + 0.1, in few histories.
#[test]
fn split_notices_g() {
    let table = rows("slab_totals.csv");
    let strong = table.iter().filter(|r| chosen(r) && layers(r).iter().any(|l| l[1] * l[3] > 0.5));
    let (mut failed, mut all) = (0, 0);
    for row in strong.filter(|r| layers(r).iter().all(|l| l[2] < 0.9)) {
        let case = Case::of(row, 0.1);
        let split = optics::split(&case.light, NSIDE, FLOOR).unwrap();
        let world = World { split: Some(&split), roulette: 0.0, ..case.world() };
        all += 1;
        failed += usize::from(deviation(row, &totals(&world, &case.source, 6_000)) > 1.0);
    }
    println!("g + 0.1: {failed} of {all} rows fail");
    assert!(2 * failed > all);
}

/// A scattering slab with one law on both faces.
fn slab_with(directions: Directions, sap: Option<SapRule>) -> (StatisticalUniverse, Light<1>) {
    let inside = Medium::clear(1.5).with([0.02], 0.5, Phase::HenyeyGreenstein(0.6));
    let sap = sap.map(|r| SurfaceSap::new(&directions, r, &[1.0, 1.5, 1.0 / 1.5]).unwrap());
    let law = SurfaceLaw { directions, ratio: Ratio::Fresnel, opaque: false, sap };
    let layer = Population {
        slab: Slab { top: 2.0, bottom: 0.0, pore: MediumId(1), surface: OWN },
        ..plain(2.0, 0.0, MediumId(1))
    };
    (sheet(vec![layer], false), light(inside, Some(law)))
}

fn rough() -> Directions {
    Directions::Facets { law: Microfacet::new(Slopes::Gaussian, 0.5).unwrap(), renormalised: false }
}

/// Rough and Lambertian faces: both branchings over the same SAPs agree within 4 standard errors, the
/// Lambertian ones with the continuous law too; `totals` asserts that every ledger, roulette and masked power included,
/// closes to 1e-12.
#[test]
fn surfaces_agree_in_both_branchings() {
    assert_eq!(OWN, SurfaceId(1));
    type Named = (&'static str, fn() -> Directions);
    let laws: [Named; 2] = [("rough", rough), ("Lambertian", || Directions::Lambertian)];
    for (name, directions) in laws {
        let coarse = SapRule { nside: 1, ..rule(SapDirections::Density) };
        let (universe, own) = slab_with(directions(), Some(coarse));
        let source = diffuse(2.0);
        let sample = totals(&world(&universe, &own, 2.0), &source, 100_000);
        let split = optics::split(&own, 1, 0.2).unwrap();
        let branching = World { split: Some(&split), roulette: 0.0, ..world(&universe, &own, 2.0) };
        let split = totals(&branching, &source, 8_000);
        let (universe, plain) = slab_with(directions(), None);
        let law = totals(&world(&universe, &plain, 2.0), &source, 200_000);
        let masked = |t: &Totals| t.cell(t.layout.of(lightpro::tally::Cell::Masked));
        for (what, s, p, c) in [
            ("R", split.r(), sample.r(), law.r()),
            ("T", split.t(), sample.t(), law.t()),
            ("masked", masked(&split), masked(&sample), masked(&law)),
        ] {
            let se = s.1.hypot(p.1);
            println!(
                "{name} {what}: split {:.5} ± {:.5}, sample {:.5} ± {:.5}, continuous law {:.5} ± {:.5}",
                s.0, s.1, p.0, p.1, c.0, c.1
            );
            assert!((s.0 - p.0).abs() <= 4.0 * se, "{name} {what}: split {s:?}, sample {p:?}");
            assert!(se < 8e-3, "{name} {what}: {se}");
            assert!((p.0 - c.0).abs() <= 4.0 * p.1.hypot(c.1), "{what}: sample {p:?}, law {c:?}");
        }
    }
}

/// A resolved SAP of a rough dielectric face against the continuous law.
#[test]
fn resolved_saps_refract_what_they_do_not_reflect() {
    let run = |sap| {
        let (universe, light) = slab_with(rough(), sap);
        totals(&world(&universe, &light, 2.0), &diffuse(2.0), 100_000)
    };
    let (sap, law) = (run(Some(SapRule { nside: 1, ..rule(SapDirections::Density) })), run(None));
    for (what, p, c) in [("R", sap.r(), law.r()), ("T", sap.t(), law.t())] {
        println!("{what}: SAP {p:?}, continuous law {c:?}");
        assert!((p.0 - c.0).abs() <= 4.0 * p.1.hypot(c.1), "{what}");
    }
}
