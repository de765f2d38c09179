//! Random numbers: one independent stream per history.
//!
//! The generator is PCG64-DXSM (crate `rand_pcg`; O'Neill 2014, HMC-CS-2014-0905). State **and**
//! increment of each stream are hashed from (seed, realisation, history, purpose), so histories can
//! run in any order, on any machine, alone or together, and draw the same numbers. Streams are never
//! made by `advance`: such streams correlate.

mod ziggurat;

use crate::math::{FRAC_PI_4, fast};
use rand_pcg::{Pcg64Dxsm, rand_core::Rng};

/// What a stream is for: two purposes of one history never share a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Purpose {
    /// The history itself.
    Transport = 1,
    /// The realisation of a sheet shared by several histories.
    Realisation = 2,
    /// Point sampling of a scene (`check`).
    Probe = 3,
}

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub struct Stream(Pcg64Dxsm);

/// Finaliser of SplitMix64 (Steele, Lea & Flood 2014): a bijection with full avalanche.
#[inline]
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The upper 53 bits as a number in [0, 1).
#[inline]
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
}

impl Stream {
    /// The stream of one history (or realisation) of a run.
    #[inline]
    pub fn of(seed: u64, realisation: u64, history: u64, purpose: Purpose) -> Self {
        const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
        let mut key = mix(seed.wrapping_add(GOLDEN));
        key = mix(key ^ mix(realisation.wrapping_add(GOLDEN.wrapping_mul(2))));
        key = mix(key ^ mix(history.wrapping_add(GOLDEN.wrapping_mul(3))));
        key = mix(key ^ mix((purpose as u64).wrapping_add(GOLDEN.wrapping_mul(4))));
        let word = |i: u64| u128::from(mix(key.wrapping_add(GOLDEN.wrapping_mul(i))));
        Stream(Pcg64Dxsm::new(word(5) << 64 | word(6), word(7) << 64 | word(8)))
    }

    /// 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform on [0, 1), 53 bits.
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        unit(self.bits())
    }

    /// Uniform on (0, 1], 53 bits: the argument of a logarithm.
    #[inline]
    pub fn uniform_positive(&mut self) -> f64 {
        ((self.bits() >> 11) + 1) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Exponential variate with mean 1, by the ziggurat: 98.9 of 100 draws take one multiplication and
    /// one comparison. 8 bits choose the layer, 53 others the place in it.
    #[inline]
    pub fn exponential(&mut self) -> f64 {
        let (layer, x) = self.in_layer();
        if x < ziggurat::EDGE[layer + 1] { x } else { self.exponential_edge(layer, x) }
    }

    #[inline]
    fn in_layer(&mut self) -> (usize, f64) {
        let bits = self.bits();
        let layer = (bits & 0xff) as usize;
        (layer, unit(bits) * ziggurat::EDGE[layer])
    }

    /// What falls on the rim of a layer is accepted under the curve; the tail is the law itself, moved.
    #[cold]
    #[inline(never)]
    fn exponential_edge(&mut self, mut layer: usize, mut x: f64) -> f64 {
        let mut beyond = 0.0;
        loop {
            let inner = ziggurat::EDGE[layer + 1];
            if x < inner {
                return beyond + x;
            }
            if layer == 0 {
                beyond += ziggurat::TAIL;
            } else {
                let (low, high) = (fast::exp(-ziggurat::EDGE[layer]), fast::exp(-inner));
                if low + self.uniform() * (high - low) < fast::exp(-x) {
                    return beyond + x;
                }
            }
            (layer, x) = self.in_layer();
        }
    }

    /// Cosine and sine of a uniform azimuth; absolute error below 2.5e-16.
    ///
    /// A uniform angle on ±π/4 and two more bits: one swaps the axes, one turns to the other side.
    #[inline]
    pub fn azimuth(&mut self) -> (f64, f64) {
        let bits = self.bits();
        let angle = (bits.cast_signed() >> 11) as f64 * (FRAC_PI_4 / 4_503_599_627_370_496.0);
        let (c, s) = fast::cos_sin_eighth(angle);
        let (c, s, side) = (c.to_bits(), s.to_bits(), (bits & 2) << 62);
        let swap = (c ^ s) & (bits & 1).wrapping_neg() ^ side;
        (f64::from_bits(c ^ swap), f64::from_bits(s ^ swap))
    }

    /// Standard normal variate (Box–Muller, one of the pair).
    #[inline]
    pub fn normal(&mut self) -> f64 {
        let r = (2.0 * self.exponential()).sqrt();
        r * self.azimuth().0
    }
}

/// A stream is a generator of the `rand` family: what needs no pinned bits (scenes made at random,
/// checks of our own samplers) can draw any law of `rand_distr` from it.
impl rand::TryRng for Stream {
    type Error = std::convert::Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Self::Error> {
        Ok((self.bits() >> 32) as u32)
    }
    fn try_next_u64(&mut self) -> Result<u64, Self::Error> {
        Ok(self.bits())
    }
    fn try_fill_bytes(&mut self, dst: &mut [u8]) -> Result<(), Self::Error> {
        self.0.fill_bytes(dst);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
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

    #[test]
    fn neighbouring_histories_do_not_correlate() {
        let n = 20_000_u64;
        let (mut sxy, mut sx) = (0.0, 0.0);
        for h in 0..n {
            let a = Stream::of(1, 0, h, Purpose::Transport).uniform() - 0.5;
            let b = Stream::of(1, 0, h + 1, Purpose::Transport).uniform() - 0.5;
            sxy += a * b;
            sx += a;
        }
        let n = n as f64;
        assert!((12.0 * sxy / n).abs() < 4.0 / n.sqrt());
        assert!((sx / n).abs() < 4.0 / (12.0 * n).sqrt());
    }
}
