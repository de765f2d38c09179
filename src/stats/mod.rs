//! Statistics of a run: moments of scores, confidence intervals, jackknife, ordered sums, and the
//! goodness-of-fit tests that hold every sampler to its density and every run to a stored one.

mod fit;
mod fold;
mod jackknife;
mod moments;

pub use fit::{Stored, chi_square_p, chi_square_pooled, ks_p_value, sidak, z_p_value};
pub use fold::{Fold, Merge, Node};
pub use jackknife::jackknife;
pub use moments::{Moments, Status, interval95, status, upper_bound95};
