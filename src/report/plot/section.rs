//! Picture of what stands in a plane, from a function of the point.

use super::colours::{INK, Rgb, series};
use crate::math::DVec3;
use std::fmt::Write;

/// A window in a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Lower left corner, µm.
    pub origin: DVec3,
    /// Unit vector to the right.
    pub right: DVec3,
    /// Unit vector upwards.
    pub up: DVec3,
    /// Width and height, µm.
    pub size: [f64; 2],
    /// Edge of a picture element, µm.
    pub pixel: f64,
}

/// A class of points: its name in the legend and its colour (`None`: white, no legend).
pub type Class<'a> = (&'a str, Option<Rgb>);

impl Section {
    /// The SVG document: `class` tells the number of the class (in `classes`) that holds a point. Rows of
    /// equal elements are one rectangle; a bar of 1, 10, 100 or 1000 µm tells the scale.
    pub fn svg(&self, title: &str, classes: &[Class<'_>], mut class: impl FnMut(DVec3) -> usize) -> String {
        let [nx, nz] = self.size.map(|s| (s / self.pixel).round().max(1.0) as usize);
        let mut paths = vec![String::new(); classes.len()];
        for row in 0..nz {
            let left = self.origin + self.up * ((row as f64 + 0.5) * self.pixel);
            let at = |i: usize| left + self.right * ((i as f64 + 0.5) * self.pixel);
            let row_classes: Vec<usize> = (0..nx).map(|i| class(at(i))).collect();
            let mut first = 0;
            for run in row_classes.chunk_by(|a, b| a == b) {
                if let Some(path) = paths.get_mut(run[0]) {
                    let _ = write!(path, "M{first} {}h{}v1h-{}z", nz - 1 - row, run.len(), run.len());
                }
                first += run.len();
            }
        }
        // Points per element.
        let scale = 900.0 / nx as f64;
        let (width, height) = (900.0, nz as f64 * scale);
        let bar = [1.0, 10.0, 100.0, 1000.0].into_iter().rfind(|b| 3.0 * b <= self.size[0]).unwrap_or(0.1);
        let bar_width = bar / self.pixel * scale;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0}\" height=\"{1:.0}\" viewBox=\"0 0 {0:.0} {1:.0}\" \
             font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
             <text x=\"10\" y=\"22\" font-weight=\"bold\" fill=\"{2}\">{3}</text>\n\
             <g transform=\"translate(10 34) scale({scale:.5})\" shape-rendering=\"crispEdges\">\n",
            width + 20.0,
            height + 84.0,
            hex(INK),
            title.replace('&', "&amp;").replace('<', "&lt;"),
        );
        for (path, (_, colour)) in paths.iter().zip(classes) {
            if let (Some(colour), false) = (colour, path.is_empty()) {
                let _ = writeln!(svg, "<path fill=\"{}\" d=\"{path}\"/>", hex(*colour));
            }
        }
        let foot = height + 56.0;
        let _ = writeln!(
            svg,
            "</g>\n<path d=\"M10 {0:.1}h{bar_width:.2}\" stroke=\"{1}\" stroke-width=\"3\"/>\n\
             <text x=\"{2:.1}\" y=\"{3:.1}\" fill=\"{1}\">{bar} µm</text>",
            foot,
            hex(INK),
            18.0 + bar_width,
            foot + 4.0,
        );
        let mut x = 120.0 + bar_width;
        let drawn = paths.iter().zip(classes).filter(|(path, _)| !path.is_empty());
        for (name, colour) in drawn.filter_map(|(_, (n, c))| c.map(|c| (n, c))) {
            let _ = writeln!(
                svg,
                "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"12\" height=\"12\" fill=\"{}\"/><text x=\"{:.1}\" y=\"{:.1}\" \
                 fill=\"{}\">{name}</text>",
                foot - 6.0,
                hex(colour),
                x + 18.0,
                foot + 5.0,
                hex(INK)
            );
            x += 40.0 + 8.0 * name.chars().count() as f64;
        }
        svg.push_str("</svg>\n");
        svg
    }
}

/// Colour of class `i`.
pub fn colour(i: usize) -> Rgb {
    series(i)
}

fn hex((r, g, b): Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::super::checks::texts;
    use super::*;

    /// A disc of radius 5 in a window of 20 × 12: as many elements as its area, none elsewhere.
    #[test]
    fn a_disc_has_its_area() {
        let section =
            Section { origin: DVec3::ZERO, right: DVec3::X, up: DVec3::Z, size: [20.0, 12.0], pixel: 0.1 };
        let centre = DVec3::new(10.0, 0.0, 6.0);
        let svg = section.svg("a < b", &[("air", None), ("wall", Some(colour(0)))], |p| {
            usize::from((p - centre).length() < 5.0)
        });
        let area: f64 = svg
            .split("h-")
            .skip(1)
            .filter_map(|rest| rest.split('z').next().and_then(|n| n.parse::<f64>().ok()))
            .sum();
        assert!((area * 0.01 - 25.0 * std::f64::consts::PI).abs() < 0.2, "{}", area * 0.01);
        assert!(texts(&svg).iter().any(|t| t.contains("1 µm")));
    }
}
