//! Alias table: a discrete law drawn with one multiplication and one comparison.

use super::SapError;

/// Alias table (Walker 1977; built after Vose, IEEE Trans. Softw. Eng. 17, 972 (1991),
/// doi:10.1109/32.92917): n slots of equal probability, each shared by its own item and one alias.
///
/// An entry is 8 bytes: the own share in units of 2⁻³² and the alias. The probability of each item
/// equals its ratio within 2⁻³², and an item with ratio 0 is never drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AliasTable {
    slots: Vec<Slot>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Slot {
    /// Own item where the fraction is below threshold/2³², the alias otherwise.
    threshold: u32,
    alias: u32,
}

impl AliasTable {
    /// Table of the law proportional to `shares` (finite, not negative, sum above 0).
    pub fn new(shares: &[f64]) -> Result<Self, SapError> {
        let sum = checked_sum(shares)?;
        let n = shares.len();
        let mut own: Vec<f64> = shares.iter().map(|r| r / sum * n as f64).collect();
        let mut alias: Vec<u32> = (0..n as u32).collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| own[i] < 1.0);
        while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
            small.pop();
            alias[s] = l as u32;
            own[l] -= 1.0 - own[s];
            if own[l] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        // What is left over holds 1 up to rounding, unless its ratio is 0.
        let greatest = (0..n).max_by(|&a, &b| shares[a].total_cmp(&shares[b])).unwrap_or(0);
        for i in small.into_iter().chain(large) {
            if shares[i] > 0.0 {
                own[i] = 1.0;
            } else {
                alias[i] = greatest as u32;
            }
        }
        let slots = own.iter().zip(alias).map(|(&p, alias)| slot(p, alias)).collect();
        Ok(AliasTable { slots })
    }

    /// Number of items.
    pub fn len(&self) -> usize {
        self.slots.len()
    }

    /// True for a table without items (never built by [`AliasTable::new`]).
    pub fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// The item that 64 random bits choose. The upper part of bits × n is the slot, the lower part
    /// the fraction within it.
    #[inline]
    pub fn draw(&self, bits: u64) -> usize {
        let product = u128::from(bits) * self.slots.len() as u128;
        let slot = (product >> 64) as usize;
        let fraction = (product as u64 >> 32) as u32;
        let Slot { threshold, alias } = self.slots[slot];
        // Chosen by a mask: a branch here is right no more often than chance.
        let own = usize::from(fraction < threshold).wrapping_neg();
        (slot & own) | (alias as usize & !own)
    }

    /// Probability of each item as the table holds it.
    pub fn probabilities(&self) -> Vec<f64> {
        let n = self.slots.len() as f64;
        let mut p = vec![0.0; self.slots.len()];
        for (i, slot) in self.slots.iter().enumerate() {
            let own = f64::from(slot.threshold) / TWO_32;
            p[i] += own / n;
            p[slot.alias as usize] += (1.0 - own) / n;
        }
        p
    }
}

const TWO_32: f64 = 4_294_967_296.0;

fn slot(own: f64, alias: u32) -> Slot {
    // A full slot saturates at 2³² − 1; its alias is itself, or takes 2⁻³² of one slot.
    Slot { threshold: (own * TWO_32).round() as u32, alias }
}

/// Sum of shares that form a law.
pub(crate) fn checked_sum(shares: &[f64]) -> Result<f64, SapError> {
    if let Some(patch) = shares.iter().position(|r| !(r.is_finite() && *r >= 0.0)) {
        return Err(SapError::Share { patch, share: shares[patch] });
    }
    let sum = shares.iter().copied().collect::<crate::math::Sum>().value();
    if sum > 0.0 && sum.is_finite() && shares.len() <= u32::MAX as usize {
        Ok(sum)
    } else {
        Err(SapError::Empty)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    #[test]
    fn table_holds_the_ratios() {
        let mut rng = Stream::of(1, 0, 0, Purpose::Probe);
        for n in [1, 2, 12, 192, 3072, 49_152] {
            let shares: Vec<f64> = (0..n)
                .map(|i| if i % 7 == 3 { 0.0 } else { rng.exponential() * rng.exponential().powi(6) })
                .collect();
            let sum: f64 = shares.iter().sum();
            let table = AliasTable::new(&shares).unwrap();
            for (p, s) in table.probabilities().iter().zip(&shares) {
                assert!((p - s / sum).abs() <= 1.0 / TWO_32, "{p} {}", s / sum);
                assert!(*s > 0.0 || *p == 0.0);
            }
        }
        assert!(matches!(AliasTable::new(&[]), Err(SapError::Empty)));
        assert!(matches!(AliasTable::new(&[0.0, 0.0]), Err(SapError::Empty)));
        assert!(matches!(AliasTable::new(&[1.0, f64::NAN]), Err(SapError::Share { patch: 1, .. })));
    }

    #[test]
    fn draws_follow_the_ratios() {
        let shares: Vec<f64> = (0..48).map(|i| f64::from(i * i % 17)).collect();
        let sum: f64 = shares.iter().sum();
        let table = AliasTable::new(&shares).unwrap();
        let mut rng = Stream::of(2, 0, 0, Purpose::Probe);
        let draws = 1_000_000;
        let mut hits = [0.0; 48];
        for _ in 0..draws {
            hits[table.draw(rng.bits())] += 1.0;
        }
        let chi = |bend: f64| {
            let mut chi2 = 0.0;
            for i in 0..48 {
                let want = shares[i] / sum * f64::from(draws) * (1.0 + bend * (i % 2) as f64);
                if want == 0.0 {
                    assert_eq!(hits[i], 0.0);
                } else {
                    chi2 += (hits[i] - want) * (hits[i] - want) / want;
                }
            }
            chi2
        };
        // 45 items of positive ratio: 44 degrees of freedom, 99.99 % quantile 88.
        assert!(chi(0.0) < 88.0, "{}", chi(0.0));
        assert!(chi(0.02) > 88.0, "a change of 2 % in every other ratio must show");
    }
}
