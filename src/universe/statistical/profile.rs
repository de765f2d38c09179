//! Density of a kind of body over the depth of its layer.

/// Relative density over relative depth (0 top, 1 bottom), linear between points, constant beyond
/// them, with mean 1 over the layer: the amount stays what it is. It is judged at the body's centroid
/// (fibres: the depth of their axis), a property of the body alone, so that every ray sees the same
/// ensemble.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    points: Vec<(f64, f64)>,
    most: f64,
}

impl Profile {
    /// Profile through (depth, density) points with ascending depths in [0, 1] and densities ≥ 0; the
    /// densities are scaled to mean 1. `None` if the points are no such profile.
    pub fn new(points: &[(f64, f64)]) -> Option<Self> {
        let sound = !points.is_empty()
            && points.windows(2).all(|w| w[0].0 < w[1].0)
            && points.iter().all(|p| (0.0..=1.0).contains(&p.0) && p.1 >= 0.0 && p.1.is_finite());
        if !sound {
            return None;
        }
        let (first, last) = (points[0], points[points.len() - 1]);
        let inner: f64 = points.windows(2).map(|w| 0.5 * (w[0].1 + w[1].1) * (w[1].0 - w[0].0)).sum();
        let mean = inner + first.0 * first.1 + (1.0 - last.0) * last.1;
        if mean <= 0.0 {
            return None;
        }
        let points: Vec<(f64, f64)> = points.iter().map(|p| (p.0, p.1 / mean)).collect();
        let most = points.iter().fold(0.0_f64, |m, p| m.max(p.1));
        Some(Profile { points, most })
    }

    /// Relative density at a relative depth.
    pub fn at(&self, depth: f64) -> f64 {
        let after = self.points.partition_point(|p| p.0 <= depth);
        if after == 0 {
            return self.points[0].1;
        }
        let (d0, p0) = self.points[after - 1];
        let Some(&(d1, p1)) = self.points.get(after) else { return p0 };
        p0 + (depth - d0) / (d1 - d0) * (p1 - p0)
    }

    /// Its largest value, ≥ 1: the factor on a majorant.
    pub fn most(&self) -> f64 {
        self.most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_is_one_and_points_are_met() {
        let p = Profile::new(&[(0.2, 1.0), (0.5, 3.0), (0.9, 0.0)]).unwrap();
        let n = 100_000;
        let mean: f64 = (0..n).map(|i| p.at((f64::from(i) + 0.5) / f64::from(n))).sum::<f64>() / f64::from(n);
        assert!((mean - 1.0).abs() < 1e-9, "{mean}");
        assert_eq!(p.at(0.0), p.at(0.2));
        assert!((p.at(0.5) / p.at(0.1) - 3.0).abs() < 1e-15);
        assert_eq!(p.most(), p.at(0.5));
        assert_eq!(p.at(1.0), 0.0);
    }

    #[test]
    fn what_is_no_profile_is_refused() {
        assert!(Profile::new(&[]).is_none());
        assert!(Profile::new(&[(0.5, 1.0), (0.5, 2.0)]).is_none());
        assert!(Profile::new(&[(0.0, 0.0), (1.0, 0.0)]).is_none());
        assert!(Profile::new(&[(0.0, -1.0), (1.0, 2.0)]).is_none());
        assert!(Profile::new(&[(0.0, 1.0), (1.5, 2.0)]).is_none());
    }
}
