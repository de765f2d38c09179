//! The Adams–Larsen–Pomraning suite: binary Markov mixtures in slabs, on every rung of the memory
//! ladder.

use crate::harness::{Check, Row, rows, within};
use crate::transport::{AIR, Totals, diffuse, run};
use lightpro::lpm::{Light, Medium};
use lightpro::phase::Phase;
use lightpro::universe::mixture::chain::{Chain, Phase as MixturePhase};
use lightpro::universe::mixture::{MixtureUniverse, Rules, Rung};
use lightpro::universe::{MediumId, SurfaceId};
use std::cell::RefCell;
use std::collections::HashMap;

/// A case of the suite: thickness, and by phase mean chord, Σt, and scattering share.
struct Case {
    height: f64,
    chord: [f64; 2],
    sigma: [f64; 2],
    c: [f64; 2],
}

impl Case {
    fn of(parameters: &str) -> Self {
        let after =
            |key: &str| parameters.split(key).nth(1).unwrap_or_else(|| panic!("{key} in {parameters}"));
        let pair = |key: &str| -> [f64; 2] {
            let inner = after(key).trim_start_matches('(').split(')').next().unwrap();
            let numbers: Vec<f64> = inner.split(',').map(|x| x.parse().unwrap()).collect();
            numbers.try_into().unwrap()
        };
        Case {
            height: after(" L=").split(' ').next().unwrap().parse().unwrap(),
            chord: pair(" Lambda="),
            sigma: pair(" Sigma_t="),
            c: pair(" c="),
        }
    }

    fn run(&self, rung: Rung, histories: u64) -> Totals {
        let phase =
            |i: usize| MixturePhase { medium: MediumId(i as u16 + 1), chord: self.chord[i], share: 1.0 };
        let rules = Rules { rung, outside: AIR, surface: SurfaceId::SMOOTH, clear: [true; 2] };
        let chain = Chain::new(vec![phase(0), phase(1)]).unwrap();
        let universe = MixtureUniverse::new(chain, self.height, rules);
        let medium = |i: usize| {
            let scattering = self.sigma[i] * self.c[i];
            Medium::clear(1.0).with([self.sigma[i] - scattering], scattering, Phase::Isotropic)
        };
        let light = Light {
            media: vec![Medium::clear(1.0), medium(0), medium(1)],
            surfaces: vec![lightpro::lpm::surface::SurfaceLaw::default()],
            lanes: 1,
        };
        run(&universe, &light, &diffuse(self.height), self.height, histories)
    }
}

fn rung(universe: &str) -> Rung {
    match universe {
        "CLS" => Rung::Phase,
        "LRP" => Rung::Layers(1),
        "BENCH" | "MEM-full" | "LAZY-full" => Rung::Full,
        other => panic!("universe {other}"),
    }
}

/// Histories per case: the tolerance, 0.001, is then above four standard errors.
const HISTORIES: u64 = 4_000_000;

/// A row of the suite; all mean chords times `stretch`.
pub fn check(row: &Row, stretch: f64, kept: &RefCell<HashMap<String, Totals>>) -> Check {
    let (p, universe) = (row.text("parameters"), row.text("universe"));
    let mut kept = kept.borrow_mut();
    let totals = kept.entry(format!("{p} {universe}")).or_insert_with(|| {
        let case = Case::of(p);
        let histories = if stretch == 1.0 { HISTORIES } else { HISTORIES / 4 };
        Case { chord: case.chord.map(|x| x * stretch), ..case }.run(rung(universe), histories)
    });
    let (got, se) = match row.text("quantity") {
        "R" => totals.r(),
        "T" => totals.t(),
        other => panic!("quantity {other}"),
    };
    if stretch == 1.0 {
        println!(
            "ALP {} {universe:5} {} {got:.5} ± {se:.5}, reference {}",
            &p[..7],
            row.text("quantity"),
            row.text("value")
        );
    }
    within(got, row.f("value"), row.f("suggested_abs_tolerance"))
}

/// Rows of the suite that remember or forget layers.
fn suite() -> Vec<Row> {
    let mut rows = rows("statistical_universe.csv");
    rows.retain(|r| r.text("problem") == "ALP" && r.text("universe") != "AM");
    rows
}

/// The tolerance bites: layers 5 % thicker.
#[test]
fn mixtures_notice() {
    let kept = RefCell::default();
    let suite = suite();
    let failed =
        suite.iter().filter(|r| matches!(check(r, 1.05, &kept), Check::Deviation(d) if d > 1.0)).count();
    println!("ALP, chords × 1.05: {failed} of {} rows fail", suite.len());
    assert!(failed >= suite.len() / 2);
}

/// More memory tends to the whole: k = 0 (none), 1, 2, 4, 8, 16 beside the bench of every case. All rungs
/// draw the same numbers until the first plane that one has forgotten, so differences are sharper than
/// their standard errors.
#[test]
fn memory_tends_to_the_whole() {
    let mut cases: Vec<String> = suite().iter().map(|r| r.text("parameters").to_owned()).collect();
    cases.dedup();
    assert_eq!(cases.len(), 3);
    for p in cases {
        let case = Case::of(&p);
        let both = |rung| {
            let t = case.run(rung, 1_000_000);
            [t.r(), t.t()]
        };
        let full = both(Rung::Full);
        println!(
            "{} full: R {:.5} ± {:.5}, T {:.5} ± {:.5}",
            &p[..7],
            full[0].0,
            full[0].1,
            full[1].0,
            full[1].1
        );
        let mut before = [f64::INFINITY; 2];
        for k in [0, 1, 2, 4, 8, 16] {
            let got = both(if k == 0 { Rung::Phase } else { Rung::Layers(k) });
            let off: [f64; 2] = std::array::from_fn(|i| got[i].0 - full[i].0);
            println!("  k = {k:2}: R {:.5} ({:+.5}), T {:.5} ({:+.5})", got[0].0, off[0], got[1].0, off[1]);
            for i in 0..2 {
                assert!(off[i].abs() <= before[i] + 3.0 * full[i].1, "k = {k}: further from the whole");
                assert!(k > 0 || off[i].abs() > 10.0 * full[i].1, "no memory: as good as all");
                assert!(k < 16 || off[i].abs() < full[i].1, "k = 16: not yet the whole");
                before[i] = off[i].abs();
            }
        }
    }
}
