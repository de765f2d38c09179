//! Curves with error bands over one axis: spectra and depth profiles.

use super::Plot;
use super::axes::{Frame, Ticks};
use super::canvas::{Anchor, Canvas, draw, fitted, width};
use super::colours::{INK, series};
use crate::report::csv::{DepthRow, SpectrumRow, table};

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Name in the legend.
    pub label: String,
    /// (x, value, standard error), by increasing x; points that are not finite leave a gap.
    pub points: Vec<(f64, f64, f64)>,
}

/// A plot of curves over one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct LinePlot<'a> {
    /// Title.
    pub title: &'a str,
    /// Quantity and unit of the horizontal axis ("1": no unit).
    pub x: (&'a str, &'a str),
    /// Quantity and unit of the vertical axis.
    pub y: (&'a str, &'a str),
    /// Curves.
    pub curves: &'a [Curve],
    /// Dots at the points (measured places) besides the line.
    pub dots: bool,
}

/// Size of the plot in points.
const SIZE: (f64, f64) = (560.0, 360.0);

impl LinePlot<'_> {
    /// The SVG document. The band around each curve is ± one standard error.
    pub fn svg(&self) -> String {
        let finite = |p: &&(f64, f64, f64)| p.0.is_finite() && p.1.is_finite();
        let all = || self.curves.iter().flat_map(|c| c.points.iter()).filter(finite);
        let range = |low: &dyn Fn(&(f64, f64, f64)) -> f64, high: &dyn Fn(&(f64, f64, f64)) -> f64| {
            let lo = all().map(low).fold(f64::INFINITY, f64::min);
            let hi = all().map(high).fold(f64::NEG_INFINITY, f64::max);
            if lo <= hi { (lo, hi) } else { (0.0, 1.0) }
        };
        let (x_lo, x_hi) = range(&|p| p.0, &|p| p.0);
        let (x_lo, x_hi) = if x_lo < x_hi { (x_lo, x_hi) } else { (x_lo - 10.0, x_hi + 10.0) };
        let (mut y_lo, mut y_hi) = range(&|p| p.1 - error(p), &|p| p.1 + error(p));
        if y_hi - y_lo <= 1e-9 * y_hi.abs().max(y_lo.abs()) {
            let room = if y_hi == 0.0 { 1.0 } else { 0.1 * y_hi.abs() };
            (y_lo, y_hi) = (y_lo - room, y_hi + room);
        }
        // Zero belongs to the picture unless the curves are far from it.
        if y_lo > 0.0 && y_lo < 0.5 * y_hi {
            y_lo = 0.0;
        } else if y_hi < 0.0 && y_hi > 0.5 * y_lo {
            y_hi = 0.0;
        }
        let (x_ticks, y_ticks) = (Ticks::inside(x_lo, x_hi, 7), Ticks::enclosing(y_lo, y_hi, 6));

        let legend = self.legend_width();
        let widest = y_ticks.labels.iter().map(|l| width(l, 10.0)).fold(0.0, f64::max);
        let frame = Frame {
            left: 36.0 + widest,
            top: 40.0,
            right: SIZE.0 - 18.0 - legend,
            bottom: SIZE.1 - 48.0,
            x: (x_lo, x_hi),
            y: (y_ticks.first(), y_ticks.last()),
        };
        draw(SIZE.0, SIZE.1, self.title, |c| {
            c.heading(&fitted(self.title, 13.5, SIZE.0 - frame.left - 12.0), (frame.left, 20.0));
            let labels = (x_ticks.axis_label(self.x.0, self.x.1), y_ticks.axis_label(self.y.0, self.y.1));
            frame.draw(c, &x_ticks, &y_ticks, &labels.0, &labels.1);
            for (i, curve) in self.curves.iter().enumerate() {
                self.curve(c, &frame, curve, i);
            }
            frame.outline(c);
            if legend > 0.0 {
                self.legend(c, frame.right + 12.0, frame.top + 8.0, legend);
            }
        })
    }

    fn curve(&self, c: &mut Canvas, frame: &Frame, curve: &Curve, i: usize) {
        for run in curve.points.split(|p| !(p.0.is_finite() && p.1.is_finite())) {
            let upper = run.iter().map(|p| frame.place(p.0, p.1 + error(p)));
            let lower = run.iter().rev().map(|p| frame.place(p.0, p.1 - error(p)));
            let band: Vec<_> = upper.chain(lower).collect();
            if run.len() > 1 {
                c.fill(&band, series(i), 0.22);
            }
            let line: Vec<_> = run.iter().map(|p| frame.place(p.0, p.1)).collect();
            c.line(&line, series(i), 1.5);
            if self.dots || run.len() == 1 {
                for (p, at) in run.iter().zip(&line) {
                    c.line(
                        &[frame.place(p.0, p.1 - error(p)), frame.place(p.0, p.1 + error(p))],
                        series(i),
                        0.9,
                    );
                    c.disc(*at, 2.2, series(i));
                }
            }
        }
    }

    /// Width of the legend beside the frame; 0 for a single curve, which the axis names.
    fn legend_width(&self) -> f64 {
        let widest = self.curves.iter().map(|c| width(&c.label, 10.0)).fold(0.0, f64::max);
        if self.curves.len() > 1 { (widest + 38.0).min(190.0) } else { 0.0 }
    }

    fn legend(&self, c: &mut Canvas, left: f64, top: f64, width: f64) {
        let line = (19.0_f64).min((SIZE.1 - 60.0 - top) / self.curves.len() as f64);
        for (i, curve) in self.curves.iter().enumerate() {
            let y = top + i as f64 * line;
            c.rectangle((left, y - 4.0), (left + 18.0, y + 4.0), series(i), 0.22);
            c.line(&[(left, y), (left + 18.0, y)], series(i), 1.5);
            c.text(&fitted(&curve.label, 10.0, width - 34.0), (left + 24.0, y), 10.0, INK, Anchor::Start);
        }
    }
}

/// Standard error of a point as drawn: 0 where it is unknown.
fn error(p: &(f64, f64, f64)) -> f64 {
    if p.2.is_finite() { p.2.abs() } else { 0.0 }
}

/// Spectra: curves over vacuum wavelength in nm; `y` is quantity and unit.
pub fn spectra(title: &str, y: (&str, &str), curves: &[Curve]) -> Plot {
    let few = curves.iter().all(|c| c.points.len() <= 40);
    let svg = LinePlot { title, x: ("wavelength", "nm"), y, curves, dots: few }.svg();
    let row = |label: &str, p: &(f64, f64, f64)| SpectrumRow {
        series: label.to_owned(),
        wavelength_nm: p.0,
        value: p.1,
        error: p.2,
    };
    let rows: Vec<_> = curves.iter().flat_map(|c| c.points.iter().map(|p| row(&c.label, p))).collect();
    Plot { svg, csv: table(&rows) }
}

/// Depth profile: stairs over the depth in µm below the top of the sheet. `edges` are the n + 1
/// limits of the n layers; the curves' points are (anything, value, standard error), one a layer.
pub fn depth_profile(title: &str, y: (&str, &str), edges: &[f64], curves: &[Curve]) -> Plot {
    let stairs: Vec<Curve> = curves
        .iter()
        .map(|curve| Curve {
            label: curve.label.clone(),
            points: edges
                .windows(2)
                .zip(&curve.points)
                .flat_map(|(e, p)| [(e[0], p.1, p.2), (e[1], p.1, p.2)])
                .collect(),
        })
        .collect();
    let svg = LinePlot { title, x: ("depth below the top", "µm"), y, curves: &stairs, dots: false }.svg();
    let layers = |curve: &Curve| -> Vec<DepthRow> {
        let row = |(e, p): (&[f64], &(f64, f64, f64))| DepthRow {
            series: curve.label.clone(),
            from_um: e[0],
            to_um: e[1],
            value: p.1,
            error: p.2,
        };
        edges.windows(2).zip(&curve.points).map(row).collect()
    };
    Plot { svg, csv: table(&curves.iter().flat_map(layers).collect::<Vec<_>>()) }
}

#[cfg(test)]
mod tests {
    use super::super::checks::{look, texts};
    use super::*;
    use crate::math::exp;
    use crate::report::csv::parse;

    fn curve(label: &str, f: impl Fn(f64) -> f64, error: f64) -> Curve {
        let points = (0..31).map(|i| 400.0 + 10.0 * f64::from(i)).map(|w| (w, f(w), error)).collect();
        Curve { label: label.into(), points }
    }

    #[test]
    fn spectra_name_their_axes_and_curves() {
        let curves = [
            curve("R∞ of a pad", |w| 0.9 - 0.25 * exp(-(w - 380.0) / 60.0), 0.006),
            curve("R0 over black", |w| 0.8 - 0.22 * exp(-(w - 380.0) / 60.0), 0.01),
            curve("transmittance <T>", |w| 0.08 + 0.0001 * (w - 400.0), 0.004),
        ];
        let plot = spectra("Bleached kraft, 80 g/m²", ("reflectance, transmittance", "1"), &curves);
        look(&plot, "spectra.svg");
        let texts = texts(&plot.svg);
        for label in ["wavelength (nm)", "reflectance, transmittance", "R0 over black", "400", "700", "0.0"] {
            assert!(texts.iter().any(|t| t == label), "{label} in {texts:?}");
        }
        assert!(texts.iter().any(|t| t == "transmittance &lt;T&gt;"), "{texts:?}");
        let rows: Vec<SpectrumRow> = parse(&plot.csv).unwrap();
        assert_eq!(rows.len(), 93);
        assert_eq!((rows[31].series.as_str(), rows[31].value), ("R0 over black", curves[1].points[0].1));
    }

    #[test]
    fn depth_profiles_are_stairs_and_gaps_stay_gaps() {
        let edges: Vec<f64> = (0..=20).map(|i| 5.0 * f64::from(i)).collect();
        let layer = |a: f64| (0..20).map(move |i| (0.0, a * exp(-f64::from(i) / 6.0), 0.03 * a)).collect();
        let mut curves = [
            Curve { label: "wall".into(), points: layer(2e-5) },
            Curve { label: "ink".into(), points: layer(7e-6) },
        ];
        curves[1].points[4].1 = f64::NAN;
        let plot = depth_profile("Absorbed power by depth", ("absorbed share", "1/µm"), &edges, &curves);
        look(&plot, "depth.svg");
        let texts = texts(&plot.svg);
        assert!(texts.iter().any(|t| t == "absorbed share (×10⁻⁵ 1/µm)"), "{texts:?}");
        assert!(texts.iter().any(|t| t == "depth below the top (µm)"));
        assert_eq!(parse::<DepthRow>(&plot.csv).unwrap()[1].from_um, 5.0);
    }

    #[test]
    fn empty_and_single_points_are_drawn() {
        texts(&spectra("nothing", ("R", "1"), &[]).svg);
        let one = Curve { label: "one".into(), points: vec![(550.0, 0.7, f64::NAN)] };
        let plot = spectra("one wavelength", ("reflectance", "1"), &[one]);
        look(&plot, "one.svg");
        assert!(texts(&plot.svg).iter().any(|t| t == "reflectance"));
    }
}
