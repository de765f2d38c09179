//! Statistics of a run: moments of scores, confidence intervals, jackknife, ordered sums, and the
//! goodness-of-fit tests that hold every sampler to its density and every run to a stored one.

mod equivalence;
mod fit;
mod fold;
mod jackknife;
mod moments;
mod student;

pub use equivalence::{Tested, deciding_error, holm};
pub use fit::{Stored, chi_square_p, chi_square_pooled, ks_p_value, sidak, z_p_value};
pub use fold::{Fold, Merge, Node};
pub use jackknife::jackknife;
pub use moments::{Moments, Status, interval95, status, upper_bound95};
pub use student::{student_cdf, student_quantile, welch};
