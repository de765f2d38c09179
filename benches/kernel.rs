//! The fixed kernel and its parts: what one event costs at least.
#![allow(missing_docs)]

mod common;

use common::{CALLS, best_ns, fixed_kernel, report, stream};
use divan::Bencher;
use divan::counter::ItemsCount;
use lightpro::math::fast;
use lightpro::rng::Stream;
use std::hint::black_box;

fn draws(rng: &mut Stream) -> f64 {
    (0..CALLS).fold(0.0, |sum, _| sum + rng.uniform())
}

/// Latency of a chain, as in the life of a ray: each argument comes from the result before.
fn ln(_: &mut Stream) -> f64 {
    (0..CALLS).fold(0.3, |x, _| 1.5 + 0.1 * fast::ln(x))
}

fn cos_sin_turn(_: &mut Stream) -> f64 {
    (0..CALLS).fold(0.3, |x, _| {
        let (c, s) = fast::cos_sin_turn(x);
        0.5 + 0.2 * (c + s)
    })
}

fn one_minus_exp_neg(_: &mut Stream) -> f64 {
    (0..CALLS).fold(0.3, |x, _| 0.1 + 0.2 * fast::one_minus_exp_neg(x))
}

fn division(_: &mut Stream) -> f64 {
    (0..CALLS).fold(0.3, |x, _| 1.0 / (1.0 + x))
}

type Kernel = (&'static str, fn(&mut Stream) -> f64);

const KERNELS: [Kernel; 6] = [
    ("fixed kernel", fixed_kernel),
    ("draw", draws),
    ("ln", ln),
    ("cos_sin_turn", cos_sin_turn),
    ("one_minus_exp_neg", one_minus_exp_neg),
    ("divide and add", division),
];

#[divan::bench(args = KERNELS.map(|k| k.0))]
fn kernel(bencher: Bencher, name: &str) {
    let work = KERNELS.iter().find(|k| k.0 == name).unwrap().1;
    let mut rng = stream();
    bencher.counter(ItemsCount::new(CALLS)).bench_local(|| work(black_box(&mut rng)));
}

fn main() {
    divan::main();
    report(|| {
        let mut rng = stream();
        let mut time =
            |(name, work): &Kernel| (name.to_string(), best_ns(CALLS, || work(black_box(&mut rng))));
        KERNELS.iter().map(&mut time).collect()
    });
}
