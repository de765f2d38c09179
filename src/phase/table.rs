//! Tabulated phase function: a user's measurement, or a computed law (Mie).
//!
//! p is piecewise linear in cos θ between its knots and normalised to ∫ p dω = 1. It is sampled by
//! its exact inverse: a segment from an alias table of the segment masses, then within the segment
//! the root of the quadratic distribution function.

use super::alias::{self, Cell};
use super::{PhaseError, Polar, error};
use crate::math::{PI, Sum, TAU, cos, sin};
use crate::rng::Stream;

/// A tabulated phase function.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// In order of rising angle.
    segments: Vec<Segment>,
    mean_cosine: f64,
    integral: f64,
}

/// One segment, between two knots.
#[derive(Clone, Debug, PartialEq)]
struct Segment {
    /// 1 − cos θ at the start.
    near: f64,
    /// Length in cos θ.
    width: f64,
    /// 1 + cos θ at the end.
    far: f64,
    /// Density at the start and at the end, per steradian.
    p: [f64; 2],
    cell: Cell,
}

/// One knot. 1 − cos and 1 + cos are both kept: each is exact where the other has rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knot {
    pub near: f64,
    pub far: f64,
    pub p: f64,
}

impl Knot {
    pub fn at_angle(angle: f64, p: f64) -> Self {
        let (s, c) = (sin(0.5 * angle), cos(0.5 * angle));
        Knot { near: 2.0 * s * s, far: 2.0 * c * c, p }
    }
}

/// Length in cos θ between two knots, without cancellation at either pole.
pub(super) fn width(a: &Knot, b: &Knot) -> f64 {
    if b.near <= 1.0 { b.near - a.near } else { a.far - b.far }
}

impl Table {
    /// From (scattering angle in rad, p) with rising angles, from 0 to π; p ≥ 0 in any unit, it is
    /// normalised. Refuses fewer than two knots, angles that do not rise or do not reach both poles
    /// (a phase function is not guessed beyond its data), negative or non-finite values, p = 0
    /// throughout.
    pub fn from_angles(knots: &[(f64, f64)]) -> Result<Self, PhaseError> {
        let numbers: Vec<usize> = (1..=knots.len()).collect();
        Self::checked("knot", &numbers, knots)
    }

    /// From (cos θ, p) with cosines that all rise or all fall, between −1 and 1, both reached; else as
    /// [`Table::from_angles`].
    pub fn from_cosines(knots: &[(f64, f64)]) -> Result<Self, PhaseError> {
        let rising = knots.len() > 1 && knots[1].0 > knots[0].0;
        let place = |i: usize| if rising { knots.len() - i } else { i + 1 };
        let ordered: Vec<Knot> = (0..knots.len())
            .map(|i| knots[place(i) - 1])
            .map(|(c, p)| Knot { near: 1.0 - c, far: 1.0 + c, p })
            .collect();
        for (i, k) in ordered.iter().enumerate() {
            let inside = k.near >= 0.0 && k.far >= 0.0;
            let falls = i == 0 || (ordered[i - 1].near < k.near || ordered[i - 1].far > k.far);
            if !inside || !falls {
                return Err(error::place("knot", place(i), "the cosines must run from −1 to 1 in one order"));
            }
            density(k.p).map_err(|m| error::place("knot", place(i), m))?;
        }
        if ordered.len() < 2 || ordered[0].near != 0.0 || ordered[ordered.len() - 1].far != 0.0 {
            return Err(PhaseError::Whole("the table must reach from cos θ = −1 to 1".into()));
        }
        Self::new(&ordered)
    }

    /// From a text with a line `angle_deg, p` for each knot, angles rising from 0 to 180 degrees. Empty
    /// lines, comments from `#` on, and one line of column names at the head are allowed. Errors name
    /// the line; conditions as [`Table::from_angles`].
    ///
    /// ```
    /// use lightpro::phase::Table;
    /// let forward = Table::from_csv("angle_deg, p\n0, 3\n90, 1\n180, 1 # any unit\n").unwrap();
    /// assert!(forward.mean_cosine() > 0.0);
    /// assert_eq!(Table::from_csv("0, 1\n200, 1").unwrap_err().to_string(),
    ///            "line 2: angle 200 is outside 0 to 180 degrees");
    /// ```
    pub fn from_csv(text: &str) -> Result<Self, PhaseError> {
        let (mut lines, mut knots) = (Vec::new(), Vec::new());
        let mut names_allowed = true;
        for (i, line) in text.lines().enumerate() {
            let content = line.split('#').next().unwrap_or_default().trim();
            if content.is_empty() {
                continue;
            }
            let wrong = |message: String| error::place("line", i + 1, message);
            let cells: Vec<&str> = content.split(',').map(str::trim).collect();
            let [angle, p] = cells[..] else {
                return Err(wrong(format!("expected 'angle_deg, p', found '{content}'")));
            };
            if std::mem::take(&mut names_allowed)
                && angle.parse::<f64>().is_err()
                && p.parse::<f64>().is_err()
            {
                continue;
            }
            let number = |t: &str| t.parse::<f64>().map_err(|_| wrong(format!("'{t}' is no number")));
            let angle = number(angle)?;
            if !(0.0..=180.0).contains(&angle) {
                return Err(wrong(format!("angle {angle} is outside 0 to 180 degrees")));
            }
            lines.push(i + 1);
            // 180° must give π itself, which a product with π/180 need not.
            knots.push((angle / 180.0 * PI, number(p)?));
        }
        Self::checked("line", &lines, &knots)
    }

    fn checked(kind: &'static str, numbers: &[usize], knots: &[(f64, f64)]) -> Result<Self, PhaseError> {
        for (i, &(angle, p)) in knots.iter().enumerate() {
            let wrong = |message: String| error::place(kind, numbers[i], message);
            if !(0.0..=PI).contains(&angle) {
                return Err(wrong(format!("angle {angle} rad is outside 0 to π")));
            }
            if i > 0 && angle <= knots[i - 1].0 {
                return Err(wrong("the angles must rise".into()));
            }
            density(p).map_err(wrong)?;
        }
        let pole = knots.first().is_some_and(|k| k.0 == 0.0) && knots.last().is_some_and(|k| k.0 == PI);
        if !pole {
            return Err(PhaseError::Whole("the table must reach from 0 to 180 degrees".into()));
        }
        let mut knots: Vec<Knot> = knots.iter().map(|&(angle, p)| Knot::at_angle(angle, p)).collect();
        if let Some(last) = knots.last_mut() {
            last.far = 0.0;
        }
        Self::new(&knots)
    }

    /// From knots already in order, reaching both poles.
    pub(super) fn new(knots: &[Knot]) -> Result<Self, PhaseError> {
        let pairs = || knots.windows(2).map(|k| (&k[0], &k[1], width(&k[0], &k[1])));
        if pairs().any(|(_, _, w)| w <= 0.0) {
            return Err(PhaseError::Whole("two knots of the table have the same cos θ".into()));
        }
        let masses: Vec<f64> = pairs().map(|(a, b, w)| TAU * w * 0.5 * (a.p + b.p)).collect();
        let integral = masses.iter().copied().collect::<Sum>().value();
        if !(integral > 0.0 && integral.is_finite()) {
            return Err(PhaseError::Whole("a phase function must have a positive, finite integral".into()));
        }
        // ∫ (1 − cos θ) p dω, exact for linear p: keeps 1 − g accurate for a narrow forward peak.
        let turned: Sum = pairs()
            .map(|(a, b, w)| TAU * w * (0.5 * (a.p + b.p) * (a.near + 0.5 * w) + (b.p - a.p) * w / 12.0))
            .collect();
        let cells = alias::cells(&masses);
        let segments = pairs()
            .zip(cells)
            .map(|((a, b, width), cell)| Segment {
                near: a.near,
                width,
                far: b.far,
                p: [a.p / integral, b.p / integral],
                cell,
            })
            .collect();
        Ok(Table { segments, mean_cosine: 1.0 - turned.value() / integral, integral })
    }

    /// 2π ∫ p dcos θ of the values as they were written: 1 where they were normalised per steradian.
    pub fn integral_as_written(&self) -> f64 {
        self.integral
    }

    /// Number of knots.
    pub fn knots(&self) -> usize {
        self.segments.len() + 1
    }

    /// Mean cosine, exact for the piecewise linear density.
    pub fn mean_cosine(&self) -> f64 {
        self.mean_cosine
    }

    pub(super) fn sample(&self, rng: &mut Stream) -> Polar {
        let i = alias::draw(self.segments.len(), |i| self.segments[i].cell, rng);
        let s = &self.segments[i];
        // Share v of the segment's mass from its start: f(p0 + (p1 − p0) f/2) = v (p0 + p1)/2. The
        // root and its complement, both without cancellation; 0/0 at an empty end is 0.
        let (v, rest) = {
            let v = rng.uniform();
            (v, 1.0 - v)
        };
        let [p0, p1] = s.p;
        let here = (p0 * p0 * rest + p1 * p1 * v).sqrt();
        let near = s.near + s.width * (v * (p0 + p1) / (p0 + here).max(f64::MIN_POSITIVE));
        let far = s.far + s.width * (rest * (p0 + p1) / (p1 + here).max(f64::MIN_POSITIVE));
        Polar::from_parts(near, far, (near * far).sqrt())
    }

    fn segment(&self, cos: f64) -> usize {
        let near = 1.0 - cos;
        self.segments.partition_point(|s| s.near <= near).saturating_sub(1)
    }

    fn pdf_in(&self, segment: usize, cos: f64) -> f64 {
        let s = &self.segments[segment];
        let f = ((1.0 - cos - s.near) / s.width).clamp(0.0, 1.0);
        s.p[0] * (1.0 - f) + s.p[1] * f
    }

    pub(super) fn pdf(&self, cos: f64) -> f64 {
        self.pdf_in(self.segment(cos), cos)
    }

    pub(super) fn max_on(&self, lo: f64, hi: f64) -> f64 {
        let (first, last) = (self.segment(hi), self.segment(lo));
        let ends = self.pdf_in(first, hi).max(self.pdf_in(last, lo));
        self.segments[first..last].iter().fold(ends, |m, s| m.max(s.p[1]))
    }
}

fn density(p: f64) -> Result<(), String> {
    if p >= 0.0 && p.is_finite() { Ok(()) } else { Err(format!("p = {p} is not a number ≥ 0")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_one_is_isotropic() {
        let t = Table::from_csv("0,1\n180,1").unwrap();
        assert!((t.integral_as_written() - 4.0 * PI).abs() < 1e-14 && t.mean_cosine().abs() < 1e-15);
        assert!((t.pdf(0.3) - 0.25 / PI).abs() < 1e-16);
    }

    /// p ∝ 1 + cos θ: g = 1/3; both ways of writing it.
    #[test]
    fn linear_in_cosine() {
        let up = Table::from_cosines(&[(-1.0, 0.0), (0.2, 1.2), (1.0, 2.0)]).unwrap();
        let down = Table::from_cosines(&[(1.0, 2.0), (0.2, 1.2), (-1.0, 0.0)]).unwrap();
        assert_eq!(up, down);
        assert!((up.mean_cosine() - 1.0 / 3.0).abs() < 1e-15);
        assert!((up.pdf(-0.5) - 0.5 / (4.0 * PI)).abs() < 1e-16);
    }

    #[test]
    fn errors_name_the_place() {
        let error = |t: &str| Table::from_csv(t).unwrap_err().to_string();
        assert_eq!(error("angle, p\n0, 1\nx, 2"), "line 3: 'x' is no number");
        assert_eq!(error("# one\n\n0, 1\n90, -2\n180, 1"), "line 4: p = -2 is not a number ≥ 0");
        assert_eq!(error("0, 1\n90, 1\n90, 1\n180, 1"), "line 3: the angles must rise");
        assert_eq!(error("0, 1\n90"), "line 2: expected 'angle_deg, p', found '90'");
        assert_eq!(error("0, nan\n180, 1"), "line 1: p = NaN is not a number ≥ 0");
        assert_eq!(error("angle, p\nagain, p"), "line 2: 'again' is no number");
        for whole in ["", "0, 1\n90, 1", "10, 1\n180, 1", "0, 0\n180, 0", "0, 1e308\n180, 1e308"] {
            assert!(matches!(Table::from_csv(whole), Err(PhaseError::Whole(_))), "{whole}");
        }
        assert!(Table::from_cosines(&[(-1.0, 1.0), (1.5, 1.0)]).is_err());
        assert!(Table::from_cosines(&[(-1.0, 1.0), (0.5, 1.0), (0.2, 1.0), (1.0, 1.0)]).is_err());
        assert!(Table::from_cosines(&[]).is_err());
    }
}
