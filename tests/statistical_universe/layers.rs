//! Several layers.

use crate::transport::*;
use lightpro::lpm::{Light, Medium};
use lightpro::phase::Phase;
use lightpro::tally::Cell;
use lightpro::universe::MediumId;
use lightpro::universe::statistical::StatisticalUniverse;
use lightpro::universe::statistical::amount::{Rule, Target};

/// Two contained layers of different fibres: nothing is lost (the run asserts it, and that each ledger
/// closes to 1e-12), and the energy of all ends sums to 1.
#[test]
fn two_layers_lose_nothing() {
    let upper = Sheet { contained: true, ..Sheet::fibres(1.0, Some(0.27), Target::Body(0.3), 6.0) };
    let lower =
        Sheet { contained: true, rule: Rule::Apart, ..Sheet::fibres(2.0, None, Target::Body(0.4), 9.0) };
    let layers = |first: &Sheet, second: &Sheet| {
        let layers = vec![first.population(second.height), second.population(0.0)];
        StatisticalUniverse::new(layers, upper.rules())
    };
    for index in [1.55, 1.0] {
        let fibre = Medium::clear(index).with([0.01], 0.05, Phase::HenyeyGreenstein(0.8));
        let light = light(fibre, None);
        let mut seen = Vec::new();
        for (first, second) in [(&upper, &lower), (&lower, &upper)] {
            let t = run(&layers(first, second), &light, &diffuse(15.0), 15.0, 400_000);
            let parts = [t.r(), t.t(), t.cell(t.layout.absorbed(SOLID)), t.cell(t.layout.of(Cell::Roulette))];
            let sum: f64 = parts.iter().map(|p| p.0).sum();
            println!(
                "n {index}: R {:?} T {:?} absorbed {:?}, sum − 1 = {:.1e}",
                parts[0],
                parts[1],
                parts[2],
                sum - 1.0
            );
            assert!((sum - 1.0).abs() < 1e-11);
            seen.push(t.t());
        }
        // Diffuse transmission from both sides. Rung `none` near a face that bodies do not cross is not
        // exactly reciprocal (entries thin out ahead of the ray, not behind it): of order r/H.
        let [t, t2] = [seen[0], seen[1]];
        let bias = if index == 1.0 { 0.0 } else { 0.008 };
        assert!((t.0 - t2.0).abs() < 4.0 * t.1.hypot(t2.1) + bias, "T {t:?} {t2:?}");
    }
}

/// A homogeneous layer cut into 1…10 pieces of the same medium is the same layer.
#[test]
fn pieces_make_the_whole() {
    let mut media = vec![Medium::clear(1.0)];
    let scatters = || Medium::clear(1.5).with([0.01], 1.0, Phase::HenyeyGreenstein(0.7));
    media.extend((0..10).map(|_| scatters()));
    let light = Light { media, surfaces: vec![Default::default()], lanes: 1 };
    let whole = run(&pieces(1), &light, &diffuse(6.0), 6.0, 400_000);
    let mut worst = 0.0_f64;
    for n in 2..=10 {
        let cut = run(&pieces(n), &light, &diffuse(6.0), 6.0, 400_000);
        for (a, b) in [(cut.r(), whole.r()), (cut.t(), whole.t())] {
            // Same seed, other numbers of draws: only the whole's own first steps agree.
            let d = (a.0 - b.0).abs() / a.1.hypot(b.1);
            assert!(d < 3.0, "{n} pieces: {a:?} against {b:?}");
            worst = worst.max(d);
        }
    }
    println!("2…10 pieces: worst {worst:.2} standard errors; R {:?} T {:?}", whole.r(), whole.t());
}

/// Six free paths in `n` unequal pieces.
fn pieces(n: u16) -> StatisticalUniverse {
    let plane = |i: u16| 6.0 * (1.0 - (f64::from(i) / f64::from(n)).powf(1.3));
    let layer = |i: u16| plain(plane(i), if i + 1 == n { 0.0 } else { plane(i + 1) }, MediumId(i + 1));
    plain_sheet((0..n).map(layer).collect())
}
