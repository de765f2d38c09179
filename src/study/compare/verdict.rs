//! From values with errors to verdicts.
//!
//! A **claim** is a figure or a whole curve of one universe against the reference. Of a curve every point must
//! be equivalent for the curve to be (an intersection-union test, each point at the full level), and one
//! point that differs is enough to differ (Bonferroni over its points). Over all claims of a comparison both
//! kinds of p-values are adjusted after Holm, so that with probability .95 not one verdict is wrong.

use super::points::{Axis, Point, margin_of};
use crate::stats::{Tested, deciding_error, holm, student_quantile, welch};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Probability that any verdict of a comparison is wrong.
pub const LEVEL: f64 = 0.05;

/// One value against the reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Universe.
    pub universe: String,
    /// Figure or curve.
    pub figure: String,
    /// What the curve runs over; empty: a single figure.
    pub along: Option<String>,
    /// Where on the curve.
    pub at: Option<f64>,
    /// Unit of the values.
    pub unit: String,
    /// Value in the reference universe.
    pub reference: f64,
    /// Its standard error.
    pub reference_error: f64,
    /// Value in this universe.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
    /// Value less reference.
    pub difference: f64,
    /// Standard error of the difference.
    pub difference_error: f64,
    /// 95 % interval of the difference (Student's t, degrees of freedom after Welch).
    pub low95: f64,
    /// Its upper end.
    pub high95: f64,
    /// Difference over its error; empty where both are exact.
    pub z: Option<f64>,
    /// Degrees of freedom; empty: many.
    pub dof: Option<f64>,
    /// Differences within ± this count as none.
    pub margin: f64,
    /// p of the test for a difference, by itself.
    pub p_difference: f64,
    /// p of the test for equivalence, by itself.
    pub p_equivalence: f64,
}

/// What a comparison says of a figure or curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// Shown to be within the margin.
    #[serde(rename = "agree")]
    Agree,
    /// Shown to be different (and not shown to be within the margin).
    #[serde(rename = "differ")]
    Differ,
    /// Neither.
    #[serde(rename = "not decidable")]
    Open,
}

/// One figure or curve against the reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// Universe.
    pub universe: String,
    /// Figure or curve.
    pub figure: String,
    /// Points of the curve; 1: a figure.
    pub points: u64,
    /// Verdict.
    pub verdict: Verdict,
    /// Where the difference is largest as a share of the margin; empty: a figure.
    pub at: Option<f64>,
    /// The difference there.
    pub difference: f64,
    /// Its standard error.
    pub error: f64,
    /// The margin there.
    pub margin: f64,
    /// Unit.
    pub unit: String,
    /// p of the test for a difference, over its points and all claims.
    pub p_difference: f64,
    /// p of the test for equivalence, over its points and all claims.
    pub p_equivalence: f64,
    /// Times as many histories that would decide it.
    pub times: Option<f64>,
}

/// A point against that of the reference, if it has it.
pub fn row(universe: &str, point: &Point, reference: &[Point], margin: f64) -> Option<Row> {
    let same = |p: &&Point| p.figure == point.figure && place(p, point);
    let r = reference.iter().find(same)?;
    let margin = margin_of(point, r.value, margin);
    let difference = point.value - r.value;
    let error = (point.error * point.error + r.error * r.error).sqrt();
    let dof = welch(&[(point.error, point.dof), (r.error, r.dof)]).max(1.0);
    let t = student_quantile(0.975, dof);
    let tested = Tested::of(difference, error, dof, margin);
    Some(Row {
        universe: universe.to_owned(),
        figure: point.figure.clone(),
        along: point.at.map(|(a, _)| a.words().0.to_owned()),
        at: point.at.map(|a| a.1),
        unit: point.unit.clone(),
        reference: r.value,
        reference_error: r.error,
        value: point.value,
        error: point.error,
        difference,
        difference_error: error,
        low95: difference - t * error,
        high95: difference + t * error,
        z: (error > 0.0).then(|| difference / error),
        dof: dof.is_finite().then_some(dof),
        margin,
        p_difference: tested.p_difference,
        p_equivalence: tested.p_equivalence,
    })
}

/// Whether two points are at one place.
fn place(a: &Point, b: &Point) -> bool {
    let close = |(x, u): (Axis, f64), (y, v): (Axis, f64)| x == y && (u - v).abs() <= 1e-6 * (1.0 + v.abs());
    match (a.at, b.at) {
        (None, None) => true,
        (Some(a), Some(b)) => close(a, b),
        _ => false,
    }
}

/// Verdicts of all rows, a claim for each figure and curve of each universe, in the order of the rows.
pub fn claims(rows: &[Row]) -> Vec<Claim> {
    // Points of a curve need not stand together.
    let mut groups: Vec<Vec<&Row>> = Vec::new();
    for row in rows {
        match groups.iter_mut().find(|g| g[0].universe == row.universe && g[0].figure == row.figure) {
            Some(g) => g.push(row),
            None => groups.push(vec![row]),
        }
    }
    let differ: Vec<f64> = groups
        .iter()
        .map(|g| (g.len() as f64 * g.iter().map(|r| r.p_difference).fold(1.0, f64::min)).min(1.0))
        .collect();
    let agree: Vec<f64> =
        groups.iter().map(|g| g.iter().map(|r| r.p_equivalence).fold(0.0, nan_max)).collect();
    let (p_differ, p_agree) = (holm(&differ), holm(&agree));
    let family = groups.len();
    let all = groups.iter().zip(p_differ.into_iter().zip(p_agree));
    all.map(|(g, (p_difference, p_equivalence))| claim(g, p_difference, p_equivalence, family)).collect()
}

fn nan_max(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { 1.0 } else { a.max(b) }
}

fn claim(rows: &[&Row], p_difference: f64, p_equivalence: f64, family: usize) -> Claim {
    let verdict = if p_equivalence < LEVEL {
        Verdict::Agree
    } else if p_difference < LEVEL {
        Verdict::Differ
    } else {
        Verdict::Open
    };
    let share = |r: &Row| (r.difference / r.margin).abs();
    // Of a curve the point that differs most surely, of an equal one that of the largest difference.
    let sure = |r: &Row| r.z.map_or(0.0, f64::abs);
    let key = |r: &Row| if verdict == Verdict::Differ { sure(r) } else { share(r) };
    let worst = rows.iter().max_by(|a, b| key(a).total_cmp(&key(b))).expect("a claim has points");
    // Every point of a curve must be decided, or one of them differ.
    let alpha = LEVEL / family as f64;
    let times = rows
        .iter()
        .map(|r| {
            let wanted = deciding_error(r.difference, r.margin, alpha);
            let noise = (r.difference_error / wanted) * (r.difference_error / wanted);
            // An error known by few degrees of freedom decides nothing, however small.
            noise.max(r.dof.map_or(0.0, |dof| 30.0 / dof))
        })
        .fold(0.0, f64::max);
    Claim {
        universe: worst.universe.clone(),
        figure: worst.figure.clone(),
        points: rows.len() as u64,
        verdict,
        at: worst.at,
        difference: worst.difference,
        error: worst.difference_error,
        margin: worst.margin,
        unit: worst.unit.clone(),
        p_difference,
        p_equivalence,
        times: (verdict == Verdict::Open && times.is_finite()).then_some(times.max(1.1)),
    }
}

impl fmt::Display for Claim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use crate::report::text::{digits, with_error};
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        let at = self.at.map_or(String::new(), |x| format!(" at {}", digits(x, 4)));
        let difference = with_error(self.difference, Some(self.error));
        let margin = digits(self.margin, 2);
        match self.verdict {
            Verdict::Agree => write!(f, "agree within {margin}{unit} ({difference}{at})"),
            Verdict::Differ => write!(f, "differ by {difference}{unit}{at}"),
            Verdict::Open => {
                let times =
                    self.times.map_or("many times".to_owned(), |t| format!("about {} times", digits(t, 2)));
                write!(
                    f,
                    "not decidable with so many histories ({difference}{unit}{at}, margin {margin}); {times} as many would"
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(figure: &str, at: Option<f64>, value: f64, error: f64) -> Point {
        let at = at.map(|x| (Axis::Polar, x));
        Point { figure: figure.into(), at, value, error, dof: f64::INFINITY, unit: "1".into() }
    }

    fn judged(pairs: &[(Point, Point)]) -> Vec<Claim> {
        let reference: Vec<Point> = pairs.iter().map(|p| p.0.clone()).collect();
        let rows: Vec<Row> = pairs.iter().filter_map(|p| row("u", &p.1, &reference, 0.005)).collect();
        assert_eq!(rows.len(), pairs.len());
        claims(&rows)
    }

    #[test]
    fn three_verdicts() {
        let pair = |d: f64, e: f64, name: &str| (point(name, None, 0.5, e), point(name, None, 0.5 + d, e));
        let all = judged(&[
            pair(0.0005, 0.0004, "reflectance"),
            pair(0.03, 0.0004, "transmittance"),
            pair(0.004, 0.002, "absorptance"),
        ]);
        let verdicts: Vec<Verdict> = all.iter().map(|c| c.verdict).collect();
        assert_eq!(verdicts, [Verdict::Agree, Verdict::Differ, Verdict::Open]);
        assert!(all[2].to_string().contains("not decidable"), "{}", all[2]);
        // As many times the histories as it says decide it.
        let times = all[2].times.unwrap();
        let again = judged(&[
            pair(0.0005, 0.0004, "reflectance"),
            pair(0.03, 0.0004, "transmittance"),
            pair(0.004, 0.002 / times.sqrt(), "absorptance"),
        ]);
        assert_ne!(again[2].verdict, Verdict::Open, "{times}");
    }

    #[test]
    fn one_point_makes_a_curve_differ_and_all_make_it_agree() {
        let curve = |bump: f64| -> Vec<(Point, Point)> {
            (0..10)
                .map(|i| {
                    let x = Some(f64::from(i));
                    (
                        point("brf", x, 0.8, 0.002),
                        point("brf", x, if i == 3 { 0.8 + bump } else { 0.8 }, 0.002),
                    )
                })
                .collect()
        };
        let c = &judged(&curve(0.0))[0];
        assert_eq!((c.verdict, c.points), (Verdict::Agree, 10));
        let c = &judged(&curve(0.04))[0];
        assert_eq!((c.verdict, c.at), (Verdict::Differ, Some(3.0)));
    }

    /// Without correction, 100 equal figures would show five differences.
    #[test]
    fn many_figures_raise_no_false_alarm() {
        let mut rng = crate::rng::Stream::of(11, 0, 0, crate::rng::Purpose::Probe);
        let mut alarms = 0;
        for _ in 0..200 {
            let pairs: Vec<_> = (0..40)
                .map(|i| {
                    let name = format!("absorbed [{i}]");
                    let (r, a) = ((2.0 * rng.exponential()).sqrt(), 2.0 * crate::math::PI * rng.uniform());
                    let noise = 0.001 * std::f64::consts::SQRT_2 * r * crate::math::cos(a);
                    (point(&name, None, 0.5, 0.001), point(&name, None, 0.5 + noise, 0.001))
                })
                .collect();
            alarms += u32::from(judged(&pairs).iter().any(|c| c.p_difference < LEVEL));
        }
        // 5 % of 200 are 10 ± 3.1.
        assert!(alarms <= 20, "{alarms} of 200");
    }
}
