//! Multiple bounces on a rough surface: a random walk on Smith's microsurface (Heitz, Hanika, d'Eon &
//! Dachsbacher, ACM TOG 35(4) (2016) 58, doi:10.1145/2897824.2925943).
//!
//! The surface has facets of the slope law at heights of a uniform law, facets and heights independent. A
//! ray that travels along w at the height of cumulated probability c leaves upwards with probability
//! G1 = c^Λ(w) (0 where it goes down), else it meets a facet at c/(1 − U)^(1/Λ), drawn with the density of
//! visible normals seen from where it comes. Λ(−w) = −1 − Λ(w). Below the surface the same holds with the
//! whole picture turned upside down. No power is lost: what the single bounce masks goes on.

use super::{Microfacet, reflect_about, refract_about};
use crate::math::DVec3;
use crate::rng::Stream;

/// Where the walk ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// Leaves on the side it came from, along this direction.
    Back(DVec3),
    /// Leaves on the other side.
    Through(DVec3),
    /// Given up to what lies beyond (the caller's decision).
    Inside,
    /// Too many bounces (grazing rays in a very rough surface).
    Stuck,
}

/// What a facet does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bounce {
    /// Reflects.
    Reflect,
    /// Refracts.
    Refract,
    /// Takes the ray.
    Take,
}

/// Facets met at most.
const MOST: usize = 1000;

impl Microfacet {
    /// Walks from the direction `i` (local, from the surface back towards the light, i.z ≥ 0). `eta` =
    /// N2/N1; `facet` decides at each facet from the cosine of incidence and whether the ray comes from
    /// below.
    pub fn walk(
        &self,
        i: DVec3,
        eta: f64,
        rng: &mut Stream,
        mut facet: impl FnMut(f64, bool, &mut Stream) -> Bounce,
    ) -> End {
        let (mut w, mut below) = (-i, false);
        // Cumulated probability of the height, counted from the far side of the ray's own medium.
        let mut c = 1.0;
        for _ in 0..MOST {
            // Upside down, below is above.
            let up = if below { -w } else { w };
            let Some(height) = self.height(up.z, c, rng) else {
                return if below { End::Through(w) } else { End::Back(w) };
            };
            c = height;
            let from = -up;
            let h = self.sample_visible(from, rng);
            let cos = from.dot(h).clamp(0.0, 1.0);
            let relative = if below { 1.0 / eta } else { eta };
            match facet(cos, below, rng) {
                Bounce::Reflect => {
                    let out = reflect_about(from, h);
                    w = if below { -out } else { out };
                }
                Bounce::Refract => {
                    let Some(out) = refract_about(from, h, relative) else { return End::Stuck };
                    w = if below { -out } else { out };
                    below = !below;
                    c = 1.0 - c;
                }
                Bounce::Take => return End::Inside,
            }
        }
        End::Stuck
    }

    /// Height (as cumulated probability) of the next facet of a ray with vertical component `z` from the
    /// height `c`; `None`: it leaves.
    fn height(&self, z: f64, c: f64, rng: &mut Stream) -> Option<f64> {
        let u = rng.uniform_positive();
        if z > 0.9999 {
            return None;
        }
        if z < -0.9999 {
            return Some(c * u);
        }
        if z.abs() < 1e-4 {
            return Some(c);
        }
        let lambda = if z > 0.0 { self.lambda(z) } else { -1.0 - self.lambda(-z) };
        // 1 − U below is uniform too: u.
        if z > 0.0 && u <= crate::math::pow(c, lambda) {
            return None;
        }
        Some((c / crate::math::pow(u, 1.0 / lambda)).min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Slopes;
    use super::*;
    use crate::rng::Purpose;

    /// The first meeting of a walk is Smith's: of rays that come in, a share G1 of reflected ones leaves at
    /// once, and no power is lost however rough the surface is.
    #[test]
    fn walks_keep_the_power_and_start_as_single_bounces() {
        for (slopes, m) in [(Slopes::Gaussian, 0.3), (Slopes::Gaussian, 1.0), (Slopes::Exponential, 0.7)] {
            let surface = Microfacet::new(slopes, m).unwrap();
            for cos in [1.0, 0.6, 0.15] {
                let i = DVec3::new((1.0_f64 - cos * cos).sqrt(), 0.0, cos);
                let mut rng = Stream::of(7, 0, 0, Purpose::Probe);
                const N: u32 = 100_000;
                let (mut once, mut stuck) = (0_u32, 0_u32);
                for _ in 0..N {
                    let mut bounces = 0;
                    let end = surface.walk(i, 1.5, &mut rng, |_, below, _| {
                        assert!(!below);
                        bounces += 1;
                        Bounce::Reflect
                    });
                    match end {
                        End::Back(w) => assert!(w.z > 0.0 && (w.length() - 1.0).abs() < 1e-12),
                        _ => stuck += 1,
                    }
                    once += u32::from(bounces == 1);
                }
                // Height-correlated masking is exact for this model: share of single bounces = its albedo.
                let want = surface.directional_albedo(cos, super::super::Masking::Correlated, |_| 1.0);
                let got = f64::from(once) / f64::from(N);
                let se = (want * (1.0 - want) / f64::from(N)).sqrt().max(1e-5);
                println!("{slopes:?} m {m} cos {cos}: single {got:.4}, wanted {want:.4}, stuck {stuck}");
                assert!((got - want).abs() < 4.5 * se + 2e-4, "{slopes:?} {m} {cos}: {got} {want}");
                assert!(stuck <= N / 10_000, "{stuck} of {N}");
            }
        }
    }
}
