//! Polarised light: Stokes parameters, and the scattering matrices of Rayleigh and Mie.
//!
//! Conventions of Bohren & Huffman (1983), chapters 2 and 3, time dependence exp(−iωt). For a ray along
//! k with the reference axis a ⟂ k (the parallel direction) and b = a × k (the perpendicular one):
//!
//! Q = |E_a|² − |E_b|², U = 2 Re(E_a E_b*), V = −2 Im(E_a E_b*), over I = |E_a|² + |E_b|².
//!
//! A sphere (or a mean over turned particles) has S11, S12 = S21, S22 = S11, S33 = S44, S34 = −S43, with
//! the scattering plane as plane of reference.

use super::{Phase, mie};
use crate::math::{PI, atan2};
use num_complex::Complex64;

/// Polarisation of a ray: Stokes parameters over I; q² + u² + v² ≤ 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stokes {
    /// Q/I.
    pub q: f64,
    /// U/I.
    pub u: f64,
    /// V/I.
    pub v: f64,
}

impl Stokes {
    /// No polarisation.
    pub const NONE: Stokes = Stokes { q: 0.0, u: 0.0, v: 0.0 };

    /// The same light with its reference axis turned towards b by the angle with cosine `c`, sine `s`.
    #[inline]
    pub fn turned(self, c: f64, s: f64) -> Stokes {
        let (c2, s2) = ((c - s) * (c + s), 2.0 * c * s);
        Stokes { q: self.q * c2 + self.u * s2, u: self.u * c2 - self.q * s2, v: self.v }
    }

    /// Degree of polarisation.
    pub fn degree(self) -> f64 {
        (self.q * self.q + self.u * self.u + self.v * self.v).sqrt()
    }

    /// Light after an element that is diagonal in the parallel and perpendicular amplitudes: power
    /// factors `p`, `s` of the two and `cross` = A_p A_s*. Returns the factor on I and the new state.
    #[inline]
    pub fn through(self, p: f64, s: f64, cross: Complex64) -> (f64, Stokes) {
        let (sum, difference) = (0.5 * (p + s), 0.5 * (p - s));
        let i = sum + difference * self.q;
        if i <= 0.0 {
            return (0.0, Stokes::NONE);
        }
        let out = Stokes {
            q: (difference + sum * self.q) / i,
            u: (cross.re * self.u + cross.im * self.v) / i,
            v: (cross.re * self.v - cross.im * self.u) / i,
        };
        (i, out.bounded())
    }

    /// Rounding may lift the degree of fully polarised light over 1: it is brought back.
    #[inline]
    fn bounded(self) -> Stokes {
        let d2 = self.q * self.q + self.u * self.u + self.v * self.v;
        if d2 <= 1.0 {
            return self;
        }
        let f = 1.0 / d2.sqrt();
        Stokes { q: self.q * f, u: self.u * f, v: self.v * f }
    }
}

/// Elements of a scattering matrix over S11 at one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elements {
    /// S12/S11.
    pub s12: f64,
    /// S33/S11.
    pub s33: f64,
    /// S34/S11.
    pub s34: f64,
}

impl Elements {
    /// Scattered state of light whose reference axis lies in the scattering plane. Its power is that of
    /// 1 + S12/S11 Q, which the draw of the azimuth has taken into account.
    #[inline]
    pub fn scatter(self, s: Stokes) -> Stokes {
        let i = 1.0 + self.s12 * s.q;
        if i <= 0.0 {
            return Stokes::NONE;
        }
        let out = Stokes {
            q: (self.s12 + s.q) / i,
            u: (self.s33 * s.u + self.s34 * s.v) / i,
            v: (self.s33 * s.v - self.s34 * s.u) / i,
        };
        out.bounded()
    }
}

/// What a medium does to polarisation when it scatters.
#[derive(Clone, Debug, PartialEq)]
pub enum ScatteringMatrix {
    /// Nothing is left of it: S12 = S33 = S34 = 0 (laws that are known by their phase function only).
    Depolarising,
    /// Rayleigh, no anisotropy of the molecule: S12/S11 = −sin²θ/(1 + cos²θ), S33/S11 = 2 cosθ/(1 + cos²θ).
    Rayleigh,
    /// Over θ on equal steps from 0 to π, linear between.
    Table(Vec<Elements>),
}

impl ScatteringMatrix {
    /// At the angle with this cosine and sine.
    #[inline]
    pub fn at(&self, cos: f64, sin: f64) -> Elements {
        match self {
            ScatteringMatrix::Depolarising => Elements { s12: 0.0, s33: 0.0, s34: 0.0 },
            ScatteringMatrix::Rayleigh => {
                let f = 1.0 / (1.0 + cos * cos);
                Elements { s12: -sin * sin * f, s33: 2.0 * cos * f, s34: 0.0 }
            }
            ScatteringMatrix::Table(rows) => {
                let x = atan2(sin, cos) / PI * (rows.len() - 1) as f64;
                let i = (x as usize).min(rows.len() - 2);
                let f = x - i as f64;
                let (a, b) = (rows[i], rows[i + 1]);
                let mix = |a: f64, b: f64| a + f * (b - a);
                Elements { s12: mix(a.s12, b.s12), s33: mix(a.s33, b.s33), s34: mix(a.s34, b.s34) }
            }
        }
    }

    /// Of several scatterers in one medium: (scattering coefficient, phase function, matrix); where
    /// they differ a table on as many steps as the finest of them.
    pub fn mixed(parts: &[(f64, Phase, ScatteringMatrix)]) -> ScatteringMatrix {
        if parts.windows(2).all(|w| w[0].2 == w[1].2) {
            return parts.first().map_or(ScatteringMatrix::Depolarising, |p| p.2.clone());
        }
        let steps =
            parts.iter().map(|p| if let ScatteringMatrix::Table(t) = &p.2 { t.len() } else { STEPS + 1 });
        let steps = steps.max().unwrap_or(STEPS + 1) - 1;
        let row = |i: usize| {
            let (sin, cos) = crate::math::sin_cos(PI * i as f64 / steps as f64);
            let (mut sum, mut out) = (0.0, Elements { s12: 0.0, s33: 0.0, s34: 0.0 });
            for (mu_s, phase, matrix) in parts {
                let (w, e) = (mu_s * phase.pdf(cos), matrix.at(cos, sin));
                sum += w;
                out.s12 += w * e.s12;
                out.s33 += w * e.s33;
                out.s34 += w * e.s34;
            }
            let f = if sum > 0.0 { 1.0 / sum } else { 0.0 };
            Elements { s12: out.s12 * f, s33: out.s33 * f, s34: out.s34 * f }
        };
        ScatteringMatrix::Table((0..=steps).map(row).collect())
    }

    /// Of spheres with a law of sizes, as [`mie::suspension`] takes it: Σ pᵢ S(θ; dᵢ). Steps of a tenth
    /// of a degree, finer for large spheres (32 to a lobe).
    pub fn mie(nodes: &[(f64, f64)], n_particle: Complex64, n_medium: f64, nm: f64) -> ScatteringMatrix {
        let m = n_particle / n_medium;
        if m == Complex64::ONE {
            return ScatteringMatrix::Depolarising;
        }
        let k = 2.0 * PI * n_medium / (nm * 1e-3);
        let spheres: Vec<(f64, mie::Coefficients)> = (nodes.iter().filter(|n| n.1 > 0.0))
            .map(|&(d, p)| (p, mie::Coefficients::new(m, 0.5 * d * k)))
            .collect();
        let largest = nodes.iter().fold(0.0_f64, |x, n| x.max(0.5 * n.0 * k));
        let steps = STEPS.max((32.0 * largest) as usize).min(MOST_STEPS);
        let row = |i: usize| {
            let (s, c) = crate::math::sin_cos(0.5 * PI * i as f64 / steps as f64);
            let (mut s11, mut out) = (0.0, Elements { s12: 0.0, s33: 0.0, s34: 0.0 });
            for (p, sphere) in &spheres {
                let (s1, s2) = sphere.amplitudes(2.0 * s * s, 2.0 * c * c);
                let (i1, i2) = (s1.norm_sqr(), s2.norm_sqr());
                s11 += 0.5 * p * (i1 + i2);
                out.s12 += 0.5 * p * (i2 - i1);
                out.s33 += p * (s1 * s2.conj()).re;
                out.s34 += p * (s2 * s1.conj()).im;
            }
            Elements { s12: out.s12 / s11, s33: out.s33 / s11, s34: out.s34 / s11 }
        };
        ScatteringMatrix::Table((0..=steps).map(row).collect())
    }
}

/// Steps of θ of a table at least.
const STEPS: usize = 1800;
/// And at most.
const MOST_STEPS: usize = 200_000;

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter turn of the axis swaps the two linear states; half a turn changes nothing.
    #[test]
    fn turning_the_axis() {
        let s = Stokes { q: 0.3, u: -0.4, v: 0.5 };
        let near = |a: Stokes, b: Stokes| {
            assert!((a.q - b.q).abs() + (a.u - b.u).abs() + (a.v - b.v).abs() < 1e-15, "{a:?} {b:?}")
        };
        near(s.turned(0.0, 1.0), Stokes { q: -0.3, u: 0.4, v: 0.5 });
        near(s.turned(-1.0, 0.0), s);
        let (sin, cos) = crate::math::sin_cos(0.7);
        near(s.turned(cos, sin).turned(cos, -sin), s);
        // Light along a at 45 degrees to the new axis is U of it, negative towards b.
        let r = 0.5_f64.sqrt();
        near(Stokes { q: 1.0, u: 0.0, v: 0.0 }.turned(r, r), Stokes { q: 0.0, u: -1.0, v: 0.0 });
    }

    /// A pure state stays pure through an element of known amplitudes: E = (1, i)/√2.
    #[test]
    fn amplitudes_and_stokes_agree() {
        let (ap, as_) = (Complex64::new(0.3, 0.4), Complex64::new(-0.2, 0.6));
        let (ea, eb) = (Complex64::new(0.6, 0.0), Complex64::new(0.0, 0.8));
        let stokes = |a: Complex64, b: Complex64| {
            let (i, z) = (a.norm_sqr() + b.norm_sqr(), a * b.conj());
            Stokes { q: (a.norm_sqr() - b.norm_sqr()) / i, u: 2.0 * z.re / i, v: -2.0 * z.im / i }
        };
        let (i, got) = stokes(ea, eb).through(ap.norm_sqr(), as_.norm_sqr(), ap * as_.conj());
        let want = stokes(ap * ea, as_ * eb);
        assert!((got.q - want.q).abs() + (got.u - want.u).abs() + (got.v - want.v).abs() < 1e-14);
        assert!((i - (ap * ea).norm_sqr() - (as_ * eb).norm_sqr()).abs() < 1e-15);
        assert!((got.degree() - 1.0).abs() < 1e-14);
    }

    /// The smallest spheres scatter as Rayleigh says.
    #[test]
    fn small_spheres_are_rayleigh() {
        let table = ScatteringMatrix::mie(&[(0.001, 1.0)], Complex64::new(1.5, 0.0), 1.0, 550.0);
        for i in 0..50 {
            let (s, c) = crate::math::sin_cos(PI * (f64::from(i) + 0.3) / 50.0);
            let (a, b) = (table.at(c, s), ScatteringMatrix::Rayleigh.at(c, s));
            assert!((a.s12 - b.s12).abs() < 1e-5 && (a.s33 - b.s33).abs() < 1e-5 && a.s34.abs() < 1e-5);
        }
    }
}
