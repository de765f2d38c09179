//! Sphere Area Partitioning: draw of a patch, patch of a direction.
#![allow(missing_docs)]

mod common;

use common::{CALLS, best_ns, report, stream};
use divan::Bencher;
use divan::counter::ItemsCount;
use lightpro::math::DVec3;
use lightpro::rng::Stream;
use lightpro::sap::{AliasTable, Healpix};
use std::hint::black_box;

const NSIDES: [u32; 3] = [4, 16, 64];

/// Table of a law that falls off from patch 0, as a phase function does from its pole.
fn table(nside: u32) -> AliasTable {
    let n = 12 * nside * nside;
    let shares: Vec<f64> = (0..n).map(|i| 1.0 / (0.01 + f64::from(i) / f64::from(n)).powi(2)).collect();
    AliasTable::new(&shares).unwrap()
}

#[inline(never)]
fn draws(table: &AliasTable, rng: &mut Stream) -> usize {
    (0..CALLS).fold(0, |sum, _| sum + table.draw(rng.bits()))
}

/// The draw alone: 64 bits by a multiplication in place of the generator.
#[inline(never)]
fn table_alone(table: &AliasTable) -> usize {
    (0..CALLS).fold(0, |sum, i| sum + table.draw(i.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}

/// Directions spread over the sphere.
fn directions() -> Vec<DVec3> {
    let mut rng = stream();
    (0..4096)
        .map(|_| {
            let z = 2.0 * rng.uniform() - 1.0;
            let (c, s) = rng.azimuth();
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * c, r * s, z)
        })
        .collect()
}

#[inline(never)]
fn patches(hp: &Healpix, directions: &[DVec3]) -> usize {
    directions.iter().map(|d| hp.pix_of(*d)).sum()
}

#[divan::bench(args = NSIDES)]
fn alias_draw(bencher: Bencher, nside: u32) {
    let (table, mut rng) = (table(nside), stream());
    bencher.counter(ItemsCount::new(CALLS)).bench_local(|| draws(black_box(&table), &mut rng));
}

#[divan::bench(args = NSIDES)]
fn pix_of(bencher: Bencher, nside: u32) {
    let (hp, directions) = (Healpix::new(nside).unwrap(), directions());
    bencher.counter(ItemsCount::new(directions.len())).bench_local(|| patches(black_box(&hp), &directions));
}

fn main() {
    divan::main();
    report(|| {
        let (directions, mut rng) = (directions(), stream());
        let mut rows = Vec::new();
        for nside in NSIDES {
            let (table, hp) = (table(nside), Healpix::new(nside).unwrap());
            let drawn = best_ns(CALLS, || draws(black_box(&table), &mut rng));
            rows.push((format!("alias draw with its random bits, nside {nside}"), drawn));
            let alone = best_ns(CALLS, || table_alone(black_box(&table)));
            rows.push((format!("alias draw alone, nside {nside}"), alone));
            let found = best_ns(directions.len() as u64, || patches(black_box(&hp), &directions));
            rows.push((format!("patch of a direction, nside {nside}"), found));
        }
        rows
    });
}
