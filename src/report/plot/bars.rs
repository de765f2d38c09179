//! Horizontal bars with error bars: contributions, prices.

use super::Plot;
use super::axes::Ticks;
use super::canvas::{Anchor, draw, fitted, width};
use super::colours::{GRID, INK, series};
use crate::report::csv::table;
use serde::Serialize;

/// One bar.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bar {
    /// Name.
    pub label: String,
    /// Value.
    pub value: f64,
    /// Standard error; 0: none is drawn.
    pub error: f64,
}

/// Bars below one another, over an axis that holds zero.
#[derive(Clone, Debug, PartialEq)]
pub struct BarPlot<'a> {
    /// Title.
    pub title: &'a str,
    /// Quantity and unit ("1": no unit).
    pub x: (&'a str, &'a str),
    /// Bars.
    pub bars: &'a [Bar],
}

impl BarPlot<'_> {
    /// The plot and its numbers.
    pub fn plot(&self) -> Plot {
        let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
        let ends = |b: &Bar| (finite(b.value - b.error.abs()), finite(b.value + b.error.abs()));
        let lo = self.bars.iter().map(|b| ends(b).0).fold(0.0, f64::min);
        let hi = self.bars.iter().map(|b| ends(b).1).fold(0.0, f64::max);
        let ticks = Ticks::enclosing(lo, if hi > lo { hi } else { lo + 1.0 }, 6);
        let widest = self.bars.iter().map(|b| width(&b.label, 10.0)).fold(0.0, f64::max).min(230.0);
        let (left, right, top) = (20.0 + widest, 536.0, 40.0);
        let bottom = top + 20.0 * self.bars.len().max(1) as f64;
        let place = |x: f64| left + (x - ticks.first()) / (ticks.last() - ticks.first()) * (right - left);
        let svg = draw(560.0, bottom + 50.0, self.title, |c| {
            c.heading(&fitted(self.title, 13.5, 530.0), (14.0, 20.0));
            for (value, label) in ticks.values.iter().zip(&ticks.labels) {
                c.line(&[(place(*value), top), (place(*value), bottom)], GRID, 0.6);
                c.text(label, (place(*value), bottom + 12.0), 10.0, INK, Anchor::Middle);
            }
            for (i, b) in self.bars.iter().enumerate() {
                let y = top + 20.0 * (i as f64 + 0.5);
                let (from, to) = (place(0.0_f64.min(finite(b.value))), place(0.0_f64.max(finite(b.value))));
                c.rectangle((from, y - 6.0), (to, y + 6.0), series(i), 0.8);
                if b.error > 0.0 && b.error.is_finite() {
                    c.line(&[(place(ends(b).0), y), (place(ends(b).1), y)], INK, 1.0);
                }
                c.text(&fitted(&b.label, 10.0, widest + 4.0), (left - 6.0, y), 10.0, INK, Anchor::End);
            }
            c.line(&[(place(0.0), top), (place(0.0), bottom)], INK, 0.8);
            let label = ticks.axis_label(self.x.0, self.x.1);
            c.text(&label, (0.5 * (left + right), bottom + 32.0), 11.0, INK, Anchor::Middle);
        });
        Plot { svg, csv: table(self.bars) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::{look, texts};
    use super::*;

    #[test]
    fn bars_name_themselves_and_survive_what_is_not_finite() {
        let bar = |label: &str, value, error| Bar { label: label.into(), value, error };
        let bars =
            [bar("statistical", 0.002, 0.0001), bar("universe model", -0.06, 0.003), bar("x", f64::NAN, 0.0)];
        let plot = BarPlot { title: "Error budget", x: ("error", "1"), bars: &bars }.plot();
        look(&plot, "bars.svg");
        let texts = texts(&plot.svg);
        assert!(
            texts.iter().any(|t| t == "universe model") && texts.iter().any(|t| t == "0.00"),
            "{texts:?}"
        );
        assert_eq!(plot.csv.lines().count(), 4);
        BarPlot { title: "none", x: ("error", "1"), bars: &[] }.plot();
    }
}
