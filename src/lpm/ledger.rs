//! Where the power of a history went.

/// Powers of one history, one entry per wavelength lane, relative to the emitted power:
/// 1 = absorbed + escaped + roulette + masked + lost + truncated + converted, to rounding.
#[derive(Clone, Debug)]
pub struct Ledger<const N: usize> {
    /// Absorbed in media and at opaque surfaces and backings.
    pub absorbed: [f64; N],
    /// Left through a face or to infinity.
    pub escaped: [f64; N],
    /// Balance of the roulette: power of the killed minus power given to survivors; mean 0.
    pub roulette: [f64; N],
    /// Removed by masking and shadowing of facets (single scattering); mean 0 where renormalised.
    pub masked: [f64; N],
    /// No valid next interface.
    pub lost: [f64; N],
    /// Stopped by the event cap.
    pub truncated: [f64; N],
    /// Moved to other lanes by events that change the wavelength, less what came from them; the sum over
    /// all lanes is 0. Spectral loop only.
    pub converted: [f64; N],
    /// Emitted: 1, but 0 in lanes that the history gets its power in by conversion only.
    pub emitted: [f64; N],
}

impl<const N: usize> Default for Ledger<N> {
    fn default() -> Self {
        let z = [0.0; N];
        Ledger {
            absorbed: z,
            escaped: z,
            roulette: z,
            masked: z,
            lost: z,
            truncated: z,
            converted: z,
            emitted: [1.0; N],
        }
    }
}

impl<const N: usize> Ledger<N> {
    /// Anything beside absorption and escape, in any lane.
    #[inline]
    pub fn rare(&self) -> bool {
        let rare = |i: usize| {
            let (a, b) = (self.roulette[i] != 0.0, self.masked[i] != 0.0);
            let changed = N > 1 && self.converted[i] != 0.0;
            a | b | (self.lost[i] != 0.0) | (self.truncated[i] != 0.0) | changed
        };
        (0..N).any(rare)
    }

    /// |emitted − sum of all entries|, the worst lane of the first `lanes`.
    pub fn imbalance(&self, lanes: usize) -> f64 {
        (0..lanes)
            .map(|i| {
                let sum = self.absorbed[i]
                    + self.escaped[i]
                    + self.roulette[i]
                    + self.masked[i]
                    + self.lost[i]
                    + self.truncated[i];
                if N > 1 {
                    // Weights between wavelengths move up to N times the power in and out: their rounding
                    // counts against that.
                    let moved = 1.0 + self.roulette[i].abs();
                    (self.emitted[i] - sum - self.converted[i]).abs() / moved
                } else {
                    (1.0 - sum).abs()
                }
            })
            .fold(0.0, f64::max)
    }
}

/// Adds lane by lane.
#[inline]
pub fn add<const N: usize>(to: &mut [f64; N], w: &[f64; N]) {
    for (t, x) in to.iter_mut().zip(w) {
        *t += x;
    }
}

/// Multiplies every lane.
#[inline]
pub fn scaled<const N: usize>(w: &[f64; N], f: f64) -> [f64; N] {
    let mut out = [0.0; N];
    for (o, x) in out.iter_mut().zip(w) {
        *o = x * f;
    }
    out
}

/// Sum of the first `lanes` lanes, in eight parts: no addition waits for the one before.
#[inline]
pub fn total<const N: usize>(w: &[f64; N], lanes: usize) -> f64 {
    let mut parts = [0.0; 8];
    for k in 0..N {
        parts[k & 7] += if k < lanes { w[k] } else { 0.0 };
    }
    ((parts[0] + parts[4]) + (parts[1] + parts[5])) + ((parts[2] + parts[6]) + (parts[3] + parts[7]))
}

/// The largest lane.
#[inline]
pub fn largest<const N: usize>(w: &[f64; N]) -> f64 {
    w.iter().copied().fold(0.0, f64::max)
}
