//! Draw of one of n items with given weights in constant time: Walker's alias method, set up after
//! Vose, IEEE Trans. Softw. Eng. 17(9), 972 (1991), doi:10.1109/32.92917.

use crate::rng::Stream;

/// A cell of the alias table: keep the cell's own item with probability `keep`, else take `other`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cell {
    keep: f64,
    other: u32,
}

/// The cells for `weights` ≥ 0 with a positive, finite sum. An item of weight 0 is never drawn.
pub(super) fn cells(weights: &[f64]) -> Vec<Cell> {
    let n = weights.len();
    let mean = weights.iter().sum::<f64>() / n as f64;
    let mut left: Vec<f64> = weights.iter().map(|w| w / mean).collect();
    let mut cells: Vec<Cell> = (0..n).map(|i| Cell { keep: 1.0, other: i as u32 }).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| left[i] < 1.0);
    while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
        small.pop();
        cells[s] = Cell { keep: left[s], other: l as u32 };
        left[l] -= 1.0 - left[s];
        if left[l] < 1.0 {
            large.pop();
            small.push(l);
        }
    }
    // What rounding leaves over is 1 up to rounding and keeps itself, unless its weight is 0.
    let heaviest = (0..n).fold(0, |h, i| if weights[i] > weights[h] { i } else { h });
    for s in small {
        if weights[s] == 0.0 {
            cells[s] = Cell { keep: 0.0, other: heaviest as u32 };
        }
    }
    cells
}

/// Draws an item; `cell(i)` gives the i-th of `n` cells.
#[inline]
pub(super) fn draw(n: usize, cell: impl Fn(usize) -> Cell, rng: &mut Stream) -> usize {
    let u = rng.uniform() * n as f64;
    let i = u as usize;
    let c = cell(i);
    if u - (i as f64) < c.keep { i } else { c.other as usize }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The probabilities that the cells stand for, summed exactly.
    #[test]
    fn cells_carry_the_weights() {
        for weights in
            [vec![1.0], vec![0.0, 3.0, 0.0, 1.0], (0..1000).map(|i| f64::from(i % 17)).collect::<Vec<_>>()]
        {
            let n = weights.len();
            let mut share = vec![0.0; n];
            for (i, c) in cells(&weights).iter().enumerate() {
                share[i] += c.keep / n as f64;
                share[c.other as usize] += (1.0 - c.keep) / n as f64;
            }
            let sum: f64 = weights.iter().sum();
            for (w, s) in weights.iter().zip(&share) {
                assert!((w / sum - s).abs() < 1e-14 && (*w > 0.0 || *s == 0.0));
            }
        }
    }
}
