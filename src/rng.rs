//! Random numbers: one independent stream per history.
//!
//! The generator is PCG64-DXSM (crate `rand_pcg`; O'Neill 2014, HMC-CS-2014-0905). State **and**
//! increment of each stream are hashed from (seed, realisation, history, purpose), so histories can
//! run in any order, on any machine, alone or together, and draw the same numbers. Streams are never
//! made by `advance`: such streams correlate.
//!
//! A stream can draw from another family instead, [`Generator::Philox`]: a check that no result leans
//! on the generator.

#[cfg(any(feature = "philox", debug_assertions))]
mod philox;
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

/// Families of generators.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Generator {
    /// PCG64-DXSM: a linear congruential generator modulo 2¹²⁸ with a permuted output.
    #[default]
    Pcg64Dxsm,
    /// Philox4x64-10: a block cipher of the draw's number.
    Philox,
}

/// A stream of random numbers.
#[derive(Clone)]
pub struct Stream {
    pcg: Pcg64Dxsm,
    /// Draws from the other family, where a build has it.
    #[cfg(any(feature = "philox", debug_assertions))]
    philox: Option<philox::Philox>,
}

impl std::fmt::Debug for Stream {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Stream").finish_non_exhaustive()
    }
}

/// This build can draw from another family than PCG: test builds, and others with the feature `philox`. To
/// ask at each draw which family it is costs 1 to 3 % of all instructions, so that programs for use leave
/// it out.
pub const SWAPS: bool = cfg!(any(feature = "philox", debug_assertions));

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
        Stream {
            pcg: Pcg64Dxsm::new(word(5) << 64 | word(6), word(7) << 64 | word(8)),
            #[cfg(any(feature = "philox", debug_assertions))]
            philox: None,
        }
    }

    /// The same from another family: its key is what the stream would draw next. Builds without another
    /// family ([`SWAPS`]) stay with theirs; runs that ask for it there are refused.
    #[inline]
    #[cfg_attr(not(any(feature = "philox", debug_assertions)), allow(unused_variables, unused_mut))]
    pub fn with(mut self, generator: Generator) -> Self {
        #[cfg(any(feature = "philox", debug_assertions))]
        if generator == Generator::Philox {
            let key = [self.pcg.next_u64(), self.pcg.next_u64()];
            self.philox = Some(philox::Philox::new(key));
        }
        self
    }

    /// 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        #[cfg(any(feature = "philox", debug_assertions))]
        if let Some(philox) = &mut self.philox {
            return philox.bits();
        }
        self.pcg.next_u64()
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
        for chunk in dst.chunks_mut(8) {
            chunk.copy_from_slice(&self.bits().to_le_bytes()[..chunk.len()]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
