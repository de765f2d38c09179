//! Round tick values, and the frame of a plot with two straight axes.

use super::canvas::{Anchor, Canvas, Place};
use super::colours::{GRID, INK};
use crate::math::{log10, pow};

/// Round values over a range, with their texts.
#[derive(Clone, Debug, PartialEq)]
pub struct Ticks {
    pub values: Vec<f64>,
    pub labels: Vec<String>,
    /// Power of ten that the labels leave out.
    pub exponent: i32,
}

impl Ticks {
    /// About `count` ticks at multiples of 1, 2 or 5 × 10ⁿ that enclose [lo, hi].
    pub fn enclosing(lo: f64, hi: f64, count: usize) -> Ticks {
        let span = if hi > lo { hi - lo } else { lo.abs().max(1e-30) };
        let raw = span / count.max(1) as f64;
        let decade = pow(10.0, log10(raw).floor());
        let step =
            [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * decade >= 0.999 * raw).unwrap_or(10.0) * decade;
        let first = (lo / step + 1e-9).floor() as i64;
        let last = ((hi / step - 1e-9).ceil() as i64).max(first + 1);
        Ticks::of((first..=last).map(|i| i as f64 * step).collect(), step)
    }
    /// Ticks at multiples of `step` inside [lo, hi].
    pub fn inside(lo: f64, hi: f64, count: usize) -> Ticks {
        let mut ticks = Ticks::enclosing(lo, hi, count);
        let slack = 1e-9 * (hi - lo).abs();
        let keep: Vec<bool> = ticks.values.iter().map(|v| *v >= lo - slack && *v <= hi + slack).collect();
        let mut kept = keep.iter();
        ticks.values.retain(|_| *kept.next().unwrap_or(&false));
        let mut kept = keep.iter();
        ticks.labels.retain(|_| *kept.next().unwrap_or(&false));
        ticks
    }
    fn of(values: Vec<f64>, step: f64) -> Ticks {
        let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let power = if largest > 0.0 { (log10(largest) + 1e-9).floor() as i32 } else { 0 };
        let exponent = if (-2..5).contains(&power) { 0 } else { power };
        let scale = pow(10.0, f64::from(exponent));
        let decimals = (-(log10(step / scale) + 1e-9).floor()).clamp(0.0, 12.0) as usize;
        let label = |v: &f64| format!("{:.decimals$}", v / scale).replace('-', "−");
        Ticks { labels: values.iter().map(label).collect(), values, exponent }
    }
    pub fn first(&self) -> f64 {
        self.values.first().copied().unwrap_or(0.0)
    }
    pub fn last(&self) -> f64 {
        self.values.last().copied().unwrap_or(1.0)
    }
    /// `quantity (×10ⁿ unit)`, "1" being no unit.
    pub fn axis_label(&self, quantity: &str, unit: &str) -> String {
        let unit = if unit == "1" { "" } else { unit };
        match (self.exponent, unit) {
            (0, "") => quantity.to_owned(),
            (0, _) => format!("{quantity} ({unit})"),
            (n, "") => format!("{quantity} (×10{})", superscript(n)),
            (n, _) => format!("{quantity} (×10{} {unit})", superscript(n)),
        }
    }
}

/// A whole number in raised digits.
pub fn superscript(n: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        c => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][c.to_digit(10).unwrap_or(0) as usize],
    };
    n.to_string().chars().map(raised).collect()
}

/// The rectangle of a plot: corners on the canvas and the ranges that they stand for.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
    pub x: (f64, f64),
    pub y: (f64, f64),
}

impl Frame {
    pub fn place(&self, x: f64, y: f64) -> Place {
        let along = |v: f64, (lo, hi): (f64, f64)| (v - lo) / (hi - lo);
        (
            self.left + along(x, self.x) * (self.right - self.left),
            self.bottom - along(y, self.y) * (self.bottom - self.top),
        )
    }
    /// Grid, box, ticks and axis labels.
    pub fn draw(&self, c: &mut Canvas, x: &Ticks, y: &Ticks, x_label: &str, y_label: &str) {
        for (value, label) in x.values.iter().zip(&x.labels) {
            let px = self.place(*value, self.y.0).0;
            c.line(&[(px, self.top), (px, self.bottom)], GRID, 0.6);
            c.line(&[(px, self.bottom), (px, self.bottom + 4.0)], INK, 0.8);
            c.text(label, (px, self.bottom + 13.0), 10.0, INK, Anchor::Middle);
        }
        for (value, label) in y.values.iter().zip(&y.labels) {
            let py = self.place(self.x.0, *value).1;
            c.line(&[(self.left, py), (self.right, py)], GRID, 0.6);
            c.line(&[(self.left - 4.0, py), (self.left, py)], INK, 0.8);
            c.text(label, (self.left - 7.0, py), 10.0, INK, Anchor::End);
        }
        c.text(x_label, (0.5 * (self.left + self.right), self.bottom + 31.0), 11.0, INK, Anchor::Middle);
        c.text_up(y_label, (16.0, 0.5 * (self.top + self.bottom)), 11.0);
    }
    /// The box, over the curves.
    pub fn outline(&self, c: &mut Canvas) {
        let (l, t, r, b) = (self.left, self.top, self.right, self.bottom);
        c.line(&[(l, t), (r, t), (r, b), (l, b), (l, t)], INK, 0.8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_enclose() {
        let t = Ticks::enclosing(0.0, 0.87, 5);
        assert_eq!(t.labels, ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        let t = Ticks::inside(400.0, 700.0, 6);
        assert_eq!(t.labels, ["400", "450", "500", "550", "600", "650", "700"]);
        let t = Ticks::enclosing(0.0, 3.1e-6, 4);
        assert_eq!((t.labels.join(" "), t.exponent), ("0 1 2 3 4".into(), -6));
        assert_eq!(t.axis_label("s", "1/µm"), "s (×10⁻⁶ 1/µm)");
        assert_eq!(Ticks::enclosing(-2.0, 2.0, 4).labels[0], "−2");
        assert!(Ticks::enclosing(0.7, 0.7, 4).values.len() >= 2);
        assert!(Ticks::enclosing(0.0, 0.0, 4).values.len() >= 2);
    }
}
