//! Where the emitted power went: one bar that adds up to all of it.

use super::Plot;
use super::canvas::{Anchor, draw, fitted};
use super::colours::{FAINT_INK, INK, series};
use crate::report::csv::{LedgerRow, table};
use crate::report::result::{Ordered, Share};
use crate::report::text::with_error;

/// The bar of a ledger.
#[derive(Clone, Debug, PartialEq)]
pub struct LedgerBar<'a> {
    /// Title.
    pub title: &'a str,
    /// Fate → share of the emitted power.
    pub ledger: &'a Ordered<Share>,
}

impl LedgerBar<'_> {
    /// Bar, and a line for each fate with its share ± standard error in per cent, and the sum.
    pub fn plot(&self) -> Plot {
        let entries = &self.ledger.0;
        let sum: f64 = entries.iter().map(|(_, s)| s.value).sum();
        let (left, right, top) = (24.0, 536.0, 42.0);
        let height = 144.0 + 18.0 * entries.len() as f64;
        let svg = draw(560.0, height, self.title, |c| {
            c.heading(&fitted(self.title, 13.5, right - left), (left, 20.0));
            let scale = (right - left) / sum.max(1.0);
            let mut x = left;
            for (i, (_, share)) in entries.iter().enumerate() {
                let end = x + share.value.max(0.0) * scale;
                c.rectangle((x, top), (end, top + 34.0), series(i), 1.0);
                x = end;
            }
            let (low, high) = (top - 0.5, top + 34.5);
            let box_end = left + scale;
            c.line(&[(left, low), (box_end, low), (box_end, high), (left, high), (left, low)], INK, 0.8);
            for percent in [0, 20, 40, 60, 80, 100] {
                let px = left + scale * f64::from(percent) / 100.0;
                c.line(&[(px, high), (px, high + 4.0)], INK, 0.8);
                c.text(&percent.to_string(), (px, high + 13.0), 10.0, INK, Anchor::Middle);
            }
            let middle = 0.5 * (left + box_end);
            c.text("share of the emitted power (%)", (middle, high + 30.0), 11.0, INK, Anchor::Middle);
            let mut y = high + 54.0;
            for (i, (fate, share)) in entries.iter().enumerate() {
                c.rectangle((left, y - 5.0), (left + 12.0, y + 5.0), series(i), 1.0);
                c.text(&fitted(fate, 10.5, 280.0), (left + 20.0, y), 10.5, INK, Anchor::Start);
                let text = format!("{} %", with_error(100.0 * share.value, Some(100.0 * share.error)));
                c.text(&text, (right, y), 10.5, INK, Anchor::End);
                y += 18.0;
            }
            c.text(&format!("sum {:.6} %", 100.0 * sum), (right, y), 10.5, FAINT_INK, Anchor::End);
        });
        let row =
            |(fate, s): &(String, Share)| LedgerRow { fate: fate.clone(), share: s.value, error: s.error };
        Plot { svg, csv: table(&entries.iter().map(row).collect::<Vec<_>>()) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::{look, texts};
    use super::*;

    #[test]
    fn every_fate_is_named_with_its_share() {
        let share = |value, error| Share { value, error };
        let ledger = Ordered(vec![
            ("reflected by the surface".to_owned(), share(0.0412, 2e-4)),
            ("reflected after entering".to_owned(), share(0.6911, 4e-4)),
            ("transmitted".to_owned(), share(0.1702, 3e-4)),
            ("absorbed in wall".to_owned(), share(0.0951, 2e-4)),
            ("left at the side & lost".to_owned(), share(0.0024, 1e-4)),
        ]);
        let plot = LedgerBar { title: "Energy ledger, 550 nm", ledger: &ledger }.plot();
        look(&plot, "ledger.svg");
        let texts = texts(&plot.svg);
        assert!(texts.iter().any(|t| t == "69.110 ± 0.040 %"), "{texts:?}");
        assert!(texts.iter().any(|t| t == "left at the side &amp; lost"));
        assert!(texts.iter().any(|t| t == "sum 100.000000 %"));
        let rows: Vec<LedgerRow> = crate::report::csv::parse(&plot.csv).unwrap();
        assert_eq!(rows[2], LedgerRow { fate: "transmitted".into(), share: 0.1702, error: 3e-4 });
    }
}
