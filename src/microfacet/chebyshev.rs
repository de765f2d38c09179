//! Chebyshev series on [−1, 1], for tables of smooth functions.

use crate::math::{PI, cos};

/// Σ c_j T_j(t), c_0 counted half.
#[derive(Clone, Debug)]
pub(super) struct Series<const N: usize>([f64; N]);

impl<const N: usize> Series<N> {
    /// The N nodes cos(π(k + ½)/N).
    pub(super) fn nodes() -> [f64; N] {
        std::array::from_fn(|k| cos(PI * (k as f64 + 0.5) / N as f64))
    }

    /// Series through the values at the nodes.
    pub(super) fn through(values: [f64; N]) -> Self {
        Series(std::array::from_fn(|j| {
            let term = |(k, v): (usize, &f64)| v * cos(PI * j as f64 * (k as f64 + 0.5) / N as f64);
            2.0 / N as f64 * values.iter().enumerate().map(term).sum::<f64>()
        }))
    }

    /// Series of `f`.
    pub(super) fn fit(f: impl Fn(f64) -> f64) -> Self {
        Self::through(Self::nodes().map(f))
    }

    /// Value at t (Clenshaw).
    #[inline]
    pub(super) fn value(&self, t: f64) -> f64 {
        let (mut b1, mut b2) = (0.0, 0.0);
        for &c in self.0[1..].iter().rev() {
            (b1, b2) = (2.0 * t * b1 - b2 + c, b1);
        }
        t * b1 - b2 + 0.5 * self.0[0]
    }

    /// Size of the last two terms: an estimate of the error.
    pub(super) fn tail(&self) -> f64 {
        self.0[N - 1].abs() + self.0[N - 2].abs()
    }
}
