//! A sheet to draw on, in points, over the SVG backend of plotters (whose pixels are whole numbers:
//! each point is divided into [`FINE`]).

use super::colours::{INK, Rgb, WHITE};
use plotters::prelude::{
    Color, DrawingBackend, FontStyle, IntoFont, RGBAColor, RGBColor, SVGBackend, ShapeStyle, TextStyle,
};
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Steps of the backend per point.
const FINE: f64 = 10.0;

/// Which end of a text stands at the given place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// A place on the canvas.
pub type Place = (f64, f64);

fn pen(rgb: Rgb, alpha: f64, width: f64) -> ShapeStyle {
    let stroke_width = (width * FINE).round().max(1.0) as u32;
    ShapeStyle { color: RGBAColor(rgb.0, rgb.1, rgb.2, alpha), filled: false, stroke_width }
}

fn fine(p: Place) -> (i32, i32) {
    ((p.0 * FINE).round() as i32, (p.1 * FINE).round() as i32)
}

pub struct Canvas<'a> {
    backend: SVGBackend<'a>,
}

// Drawing into memory cannot fail: the result of the backend is dropped.
impl Canvas<'_> {
    pub fn line(&mut self, places: &[Place], rgb: Rgb, width: f64) {
        let _ = self.backend.draw_path(places.iter().map(|p| fine(*p)), &pen(rgb, 1.0, width));
    }
    pub fn dashed(&mut self, from: Place, to: Place, rgb: Rgb, width: f64) {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let dashes = ((dx * dx + dy * dy).sqrt() / 6.0).ceil().max(1.0);
        for i in 0..dashes as usize {
            let at = |t: f64| (from.0 + t * dx / dashes, from.1 + t * dy / dashes);
            self.line(&[at(i as f64), at(i as f64 + 0.55)], rgb, width);
        }
    }
    pub fn fill(&mut self, places: &[Place], rgb: Rgb, alpha: f64) {
        let _ = self.backend.fill_polygon(places.iter().map(|p| fine(*p)), &pen(rgb, alpha, 0.0));
    }
    pub fn rectangle(&mut self, from: Place, to: Place, rgb: Rgb, alpha: f64) {
        let _ = self.backend.draw_rect(fine(from), fine(to), &pen(rgb, alpha, 0.0), true);
    }
    pub fn disc(&mut self, centre: Place, radius: f64, rgb: Rgb) {
        let _ = self.backend.draw_circle(fine(centre), (radius * FINE) as u32, &pen(rgb, 1.0, 0.0), true);
    }
    pub fn ring(&mut self, centre: Place, radius: f64, rgb: Rgb, width: f64) {
        let _ = self.backend.draw_circle(fine(centre), (radius * FINE) as u32, &pen(rgb, 1.0, width), false);
    }
    /// Text with the middle of its height at `at`.
    pub fn text(&mut self, text: &str, at: Place, size: f64, rgb: Rgb, anchor: Anchor) {
        self.words(text, at, size, rgb, anchor, FontTransform::None, FontStyle::Normal);
    }
    /// Text that reads upwards, its middle at `at`.
    pub fn text_up(&mut self, text: &str, at: Place, size: f64) {
        self.words(text, at, size, INK, Anchor::Middle, FontTransform::Rotate270, FontStyle::Normal);
    }
    /// Bold heading that starts at `at`.
    pub fn heading(&mut self, text: &str, at: Place) {
        self.words(text, at, 13.0, INK, Anchor::Start, FontTransform::None, FontStyle::Bold);
    }
    #[allow(clippy::too_many_arguments)]
    fn words(
        &mut self,
        text: &str,
        at: Place,
        size: f64,
        rgb: Rgb,
        anchor: Anchor,
        turn: FontTransform,
        face: FontStyle,
    ) {
        let h = match anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        // The backend divides sizes by 1.24.
        let font = ("sans-serif", 1.24 * size * FINE).into_font().style(face).transform(turn);
        let colour = RGBColor(rgb.0, rgb.1, rgb.2).to_rgba();
        let style = TextStyle::from(font).color(&colour).pos(Pos::new(h, VPos::Center));
        let _ = self.backend.draw_text(text, &style, fine(at));
    }
}

/// An SVG document of `width` × `height` points with a white ground.
pub fn draw(width: f64, height: f64, title: &str, content: impl FnOnce(&mut Canvas)) -> String {
    let size = ((width * FINE) as u32, (height * FINE) as u32);
    let mut svg = String::new();
    {
        let mut canvas = Canvas { backend: SVGBackend::with_string(&mut svg, size) };
        canvas.rectangle((0.0, 0.0), (width, height), WHITE, 1.0);
        content(&mut canvas);
        let _ = canvas.backend.present();
    }
    let escaped = quick_xml::escape::escape(title);
    let (head, body) = svg.split_once('\n').unwrap_or(("", ""));
    let head = head.replacen(
        &format!("width=\"{}\" height=\"{}\"", size.0, size.1),
        &format!("width=\"{width}pt\" height=\"{height}pt\" role=\"img\""),
        1,
    );
    // Plain white on black for readers who ask for it; hues stay.
    const DARK: &str = "<style>@media (prefers-color-scheme: dark) { :root { filter: invert(1) hue-rotate(180deg); } }</style>";
    format!("{head}\n<title>{escaped}</title>\n{DARK}\n{body}")
}

/// Width of `text` in points at font `size`, estimated from above (that of DejaVu Sans, the widest
/// of the common sans-serif fonts).
pub fn width(text: &str, size: f64) -> f64 {
    let em = |c: char| match c {
        'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' | ' ' | '(' | ')' | '[' | ']' => 0.4,
        'f' | 't' | 'r' | '/' | 'I' => 0.45,
        'm' | 'w' | 'M' | 'W' | '±' | '−' | '–' | '×' | '%' | '+' | '=' | '<' | '>' => 0.95,
        'A'..='Z' => 0.75,
        _ => 0.64,
    };
    size * text.chars().map(em).sum::<f64>()
}

/// `text`, or its beginning and an ellipsis where it would be wider than `limit` points.
pub fn fitted(text: &str, size: f64, limit: f64) -> String {
    if width(text, size) <= limit {
        return text.to_owned();
    }
    let mut short: String = text.to_owned();
    while !short.is_empty() && width(&short, size) + size > limit {
        short.pop();
    }
    format!("{}…", short.trim_end())
}
