//! What all benches share: the fixed kernel that speeds are stated against, and a timer.
#![allow(dead_code)]

use lightpro::lpm::{History, Path, Scorer, World, trace};
use lightpro::math::fast;
use lightpro::rng::{Purpose, Stream};
use lightpro::source::Source;
use lightpro::tally::{Layout, Tally};
use lightpro::universe::{Interface, MediumId, Universe};
use std::hint::black_box;
use std::time::Instant;

/// Evaluations in one call of a kernel.
pub const CALLS: u64 = 1_000_000;

pub fn stream() -> Stream {
    Stream::of(20_261_122, 0, 0, Purpose::Transport)
}

/// The fixed kernel, [`CALLS`] times: one draw of Pcg64Dxsm, one ln, one cos and sin of a turn, one
/// division. Each evaluation starts from the result of the one before, as the events of a ray do.
#[inline(never)]
pub fn fixed_kernel(rng: &mut Stream) -> f64 {
    let mut x = 0.25;
    for _ in 0..CALLS {
        let u = rng.uniform_positive();
        let (c, s) = fast::cos_sin_turn(0.5 * (u + x));
        x = 1.0 / (2.0 - fast::ln(u) + c * s);
    }
    x
}

/// Shortest time of one of `per` equal pieces of `work` over repetitions, ns: other load on the machine
/// only ever adds.
pub fn best_ns<T>(per: u64, mut work: impl FnMut() -> T) -> f64 {
    let mut best = f64::INFINITY;
    let (begin, mut rounds) = (Instant::now(), 0);
    while rounds < 5 || rounds < 60 && begin.elapsed().as_secs_f64() < 3.0 {
        let started = Instant::now();
        black_box(work());
        best = best.min(started.elapsed().as_secs_f64() * 1e9 / per as f64);
        rounds += 1;
    }
    best
}

/// Prints times (ns) beside that of the fixed kernel of the same run. Not when cargo only lists or tests.
pub fn report(rows: impl FnOnce() -> Vec<(String, f64)>) {
    if std::env::args().any(|a| a == "--test" || a == "--list") {
        return;
    }
    let mut rng = stream();
    let kernel = |rng: &mut Stream| best_ns(CALLS, || fixed_kernel(rng));
    let before = kernel(&mut rng);
    let rows = rows();
    let kernel = before.min(kernel(&mut rng));
    println!("\nfixed kernel {kernel:.2} ns");
    for (name, ns) in rows {
        println!("{name:<44} {ns:>9.2} ns  {:>8.3} kernels  {:>8.3} M/s", ns / kernel, 1e3 / ns);
    }
}

/// What a set of histories consists of.
#[derive(Default)]
pub struct Count {
    pub events: u64,
    pub scatterings: u64,
    pub interfaces: u64,
    /// Bodies entered from the pore medium.
    pub bodies: u64,
}

/// The pore medium of the benches.
pub const PORE: MediumId = MediumId(0);

impl<const N: usize> Scorer<N> for Count {
    fn scattered<P>(&mut self, _: &Path<P, N>) -> bool {
        self.scatterings += 1;
        false
    }
    fn interface<P>(&mut self, path: &Path<P, N>, _: &Interface) -> bool {
        self.interfaces += 1;
        self.bodies += u64::from(path.medium == PORE);
        false
    }
}

/// A world, its source, and a number of histories.
pub struct Case<'a, U: Universe> {
    pub world: World<'a, U, 1>,
    pub source: Source,
    pub histories: u64,
}

impl<U: Universe> Case<'_, U> {
    /// Counts the events, outside the time.
    pub fn count(&self) -> Count {
        let (mut h, mut count) = (History::default(), Count::default());
        for number in 0..self.histories {
            let mut rng = Stream::of(1, 0, number, Purpose::Transport);
            let ray = self.source.emit(&mut rng);
            trace(&self.world, ray, &mut h, &mut count, &mut rng);
            count.events += h.events;
        }
        count
    }

    /// The history loop as a run has it, with a tally of totals.
    #[inline(never)]
    pub fn run(&self, layout: &Layout) -> u64 {
        let (mut h, mut tally) = (History::default(), Tally::<1>::new(layout));
        for number in 0..self.histories {
            let mut rng = Stream::of(1, 0, number, Purpose::Transport);
            let ray = self.source.emit(&mut rng);
            trace(&self.world, ray, &mut h, &mut tally, &mut rng);
            tally.end_history(&h.ledger, h.events, Default::default());
        }
        tally.finish(0).events
    }

    /// Totals only.
    pub fn layout(&self) -> Layout {
        Layout {
            shared: 1,
            realisations: None,
            lanes: 1,
            media: self.world.light.media.len(),
            angular: None,
            depth: None,
            checkpoint: None,
            path: false,
            time: false,
            view: None,
            pile: 1,
            detectors: Default::default(),
        }
    }
}
