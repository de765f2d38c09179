use super::*;

/// Value stability: these numbers are part of the program's contract (same seed, same result).
#[test]
fn first_draws_are_pinned() {
    let mut s = Stream::of(20_261_122, 0, 0, Purpose::Transport);
    let first = [s.bits(), s.bits(), s.bits()];
    let mut s = Stream::of(20_261_122, 0, 1, Purpose::Transport);
    let second = [s.bits(), s.bits(), s.bits()];
    assert_ne!(first, second);
    assert_eq!(first, PINNED_0, "{first:?}");
    assert_eq!(second, PINNED_1, "{second:?}");
}
const PINNED_0: [u64; 3] = [9004233200079635120, 10716909521572744637, 10892681980994396528];
const PINNED_1: [u64; 3] = [16588283387482491735, 15640702891698913363, 14378095005981100703];

/// Value stability of the other family.
#[test]
fn philox_draws_are_pinned_and_blocks_are_used_whole() {
    let mut plain = Stream::of(20_261_122, 0, 0, Purpose::Transport);
    let key = [plain.bits(), plain.bits()];
    let mut s = Stream::of(20_261_122, 0, 0, Purpose::Transport).with(Generator::Philox);
    let drawn: Vec<u64> = (0..8).map(|_| s.bits()).collect();
    assert_eq!(drawn[..4], philox::block([0; 4], key));
    assert_eq!(drawn[4..], philox::block([1, 0, 0, 0], key));
    assert_eq!(drawn[..2], PINNED_PHILOX, "{:?}", &drawn[..2]);
}
const PINNED_PHILOX: [u64; 2] = [5_970_358_714_734_373_663, 14_025_565_584_273_293_571];

#[test]
fn ziggurat_layers_have_equal_area() {
    use ziggurat::{AREA, EDGE, TAIL};
    assert!((TAIL * pxfm::f_exp(-TAIL) + pxfm::f_exp(-TAIL) - AREA).abs() < 1e-17);
    assert!((EDGE[0] * pxfm::f_exp(-TAIL) - AREA).abs() < 1e-17);
    for i in 1..256 {
        let area = EDGE[i] * (pxfm::f_exp(-EDGE[i + 1]) - pxfm::f_exp(-EDGE[i]));
        assert!((area / AREA - 1.0).abs() < 1e-12, "layer {i}: {area}");
    }
    assert_eq!(EDGE[256], 0.0);
}

/// Chi-square over bins of equal probability, the last one deep in the tail, and the first moments.
#[test]
fn exponential_follows_its_law() {
    const BINS: usize = 4000;
    let (n, mut counts, mut sums, mut far) = (20_000_000_u64, vec![0_u64; BINS], [0.0; 3], 0_u64);
    let mut rng = Stream::of(20_261_122, 0, 7, Purpose::Probe);
    for _ in 0..n {
        let x = rng.exponential();
        assert!((0.0..80.0).contains(&x));
        counts[((1.0 - pxfm::f_exp(-x)) * BINS as f64) as usize] += 1;
        far += u64::from(x > 10.0);
        for (k, s) in sums.iter_mut().enumerate() {
            *s += x.powi(k as i32 + 1);
        }
    }
    let (n, dof) = (n as f64, BINS as f64 - 1.0);
    let expected = n / BINS as f64;
    let chi2: f64 = counts.iter().map(|&c| (c as f64 - expected).powi(2) / expected).sum();
    assert!(((chi2 - dof) / (2.0 * dof).sqrt()).abs() < 4.0, "chi-square {chi2} of {dof}");
    let tail = n * pxfm::f_exp(-10.0);
    assert!((far as f64 - tail).abs() < 4.0 * tail.sqrt(), "{far} beyond 10, expected {tail}");
    for (k, (mean, variance)) in [(1.0, 1.0), (2.0, 20.0), (6.0, 684.0)].into_iter().enumerate() {
        let z = (sums[k] / n - mean) / (f64::sqrt(variance / n));
        assert!(z.abs() < 4.0, "moment {}: z = {z}", k + 1);
    }
}

#[test]
fn azimuth_is_a_uniform_turn() {
    let (n, mut counts, mut worst) = (4_000_000_u64, [0_u64; 64], 0.0_f64);
    let mut rng = Stream::of(20_261_122, 0, 8, Purpose::Probe);
    for _ in 0..n {
        let bits = rng.clone().bits();
        let (c, s) = rng.azimuth();
        // The angle over π, within an eighth of a turn; then the axes and the side.
        let angle = (bits.cast_signed() >> 11) as f64 / 18_014_398_509_481_984.0;
        let (x, y) = (pxfm::f_cospi(angle), pxfm::f_sinpi(angle));
        let (x, y) = if bits & 1 == 1 { (y, x) } else { (x, y) };
        let side = if bits & 2 == 2 { -1.0 } else { 1.0 };
        worst = worst.max((c - side * x).abs()).max((s - side * y).abs());
        counts[(pxfm::f_atan2pi(s, c) * 32.0 + 32.0).min(63.0) as usize] += 1;
    }
    assert!(worst <= 2.5e-16, "{worst}");
    let expected = n as f64 / 64.0;
    let chi2: f64 = counts.iter().map(|&c| (c as f64 - expected).powi(2) / expected).sum();
    assert!(((chi2 - 63.0) / 126_f64.sqrt()).abs() < 4.0, "chi-square {chi2} of 63");
}

/// z of the correlation of two streams' uniform draws, over n pairs.
fn correlation(n: u64, mut pair: impl FnMut(u64) -> (f64, f64)) -> f64 {
    let sum: f64 = (0..n).map(&mut pair).map(|(x, y)| (x - 0.5) * (y - 0.5)).sum();
    12.0 * sum / (n as f64).sqrt()
}

/// Streams of neighbouring histories, groups, seeds and purposes; draws of one stream at lags; and the
/// same draw of streams far apart by a power of two: no correlation, for either family.
#[test]
fn streams_do_not_correlate() {
    const N: u64 = 200_000;
    let mut worst: f64 = 0.0;
    for generator in [Generator::Pcg64Dxsm, Generator::Philox] {
        let first = |s, r, h, p| Stream::of(s, r, h, p).with(generator).uniform();
        let t = Purpose::Transport;
        let mut hold = |what: &str, z: f64| {
            worst = worst.max(z.abs());
            assert!(z.abs() < 4.5, "{generator:?}, {what}: z = {z}");
        };
        hold("history", correlation(N, |i| (first(1, 0, i, t), first(1, 0, i + 1, t))));
        hold("group", correlation(N, |i| (first(1, 0, i, t), first(1, 1, i, t))));
        hold("seed", correlation(N, |i| (first(1, 0, i, t), first(2, 0, i, t))));
        hold("purpose", correlation(N, |i| (first(1, 0, i, t), first(1, 0, i, Purpose::Probe))));
        hold("seed and history", correlation(N, |i| (first(i, 0, 7, t), first(7, 0, i, t))));
        for k in [12, 20, 32, 40, 63] {
            let far = |i: u64| (first(1, 0, i, t), first(1, 0, i ^ 1 << k, t));
            hold(&format!("2^{k} histories apart"), correlation(N, far));
        }
        for lag in [1, 2, 3, 4, 16] {
            let pair = |i: u64| {
                let mut s = Stream::of(1, 0, i, t).with(generator);
                let x = s.uniform();
                (1..lag).for_each(|_| _ = s.bits());
                (x, s.uniform())
            };
            hold(&format!("lag {lag}"), correlation(N, pair));
        }
        // Single bits of neighbouring streams.
        for bit in [0, 1, 31, 32, 63] {
            let bits = |h| Stream::of(1, 0, h, t).with(generator).bits() >> bit & 1;
            let same = (0..N).filter(|&i| bits(i) == bits(i + 1)).count() as f64;
            hold(&format!("bit {bit}"), (same - 0.5 * N as f64) / (0.25 * N as f64).sqrt());
        }
    }
    assert!(worst > 0.0);
}
