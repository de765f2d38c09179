//! Picture of a piece of the sheet from above and aside, with the paths of the first histories, and the
//! sphere of directions of one event. Plain SVG; the results of the run do not depend on it.

mod paths;
mod piece;
mod solids;
mod sphere;

use crate::math::{DVec3, PI, sin_cos};
use crate::run::replay;
use crate::scene::Scene;
use crate::scene::plan::Plan;
use crate::universe::MediumId;
use paths::{Fate, Trails};
use piece::Piece;
use quick_xml::escape::escape;
use std::fmt::Write;

/// Histories that are traced again for the picture.
const HISTORIES: u64 = 48;
/// Room for the piece, points.
const LEFT: [f64; 4] = [16.0, 40.0, 520.0, 352.0];

/// A direction to look from, orthogonal projection.
#[derive(Clone, Copy, Debug)]
pub(super) struct Eye {
    right: DVec3,
    up: DVec3,
    /// To who looks.
    toward: DVec3,
    /// Points per µm.
    scale: f64,
    /// Where the world's `centre` stands, points.
    at: (f64, f64),
    centre: DVec3,
}

impl Eye {
    /// From 25° above the sheet, the light's plane of incidence (xz) across the picture.
    fn new() -> Self {
        let (s, c) = sin_cos(-62.0 * PI / 180.0);
        let (se, ce) = sin_cos(25.0 * PI / 180.0);
        let toward = DVec3::new(ce * c, ce * s, se);
        let right = DVec3::new(-s, c, 0.0);
        Eye { right, up: toward.cross(right), toward, scale: 1.0, at: (0.0, 0.0), centre: DVec3::ZERO }
    }

    /// In points.
    fn place(&self, p: DVec3) -> (f64, f64) {
        let d = p - self.centre;
        (self.at.0 + self.scale * d.dot(self.right), self.at.1 - self.scale * d.dot(self.up))
    }

    fn depth(&self, p: DVec3) -> f64 {
        p.dot(self.toward)
    }

    /// Scaled and placed so that `points` fill the room (x from, y from, x to, y to).
    fn fitted(mut self, points: &[DVec3], room: [f64; 4]) -> Self {
        let (mut low, mut high) = ((f64::INFINITY, f64::INFINITY), (f64::NEG_INFINITY, f64::NEG_INFINITY));
        for p in points {
            let (x, y) = self.place(*p);
            low = (low.0.min(x), low.1.min(y));
            high = (high.0.max(x), high.1.max(y));
        }
        let s = ((room[2] - room[0]) / (high.0 - low.0)).min((room[3] - room[1]) / (high.1 - low.1));
        self.at = (
            0.5 * (room[0] + room[2]) - s * 0.5 * (low.0 + high.0),
            0.5 * (room[1] + room[3]) - s * 0.5 * (low.1 + high.1),
        );
        self.scale = s;
        self
    }

    /// Brightness of a face, 0 to 1: light from the upper left.
    fn shade(&self, normal: DVec3) -> f64 {
        let light = (self.toward * 0.45 + self.up * 0.85 - self.right * 0.3).normalize();
        0.58 + 0.42 * normal.dot(light).max(0.0)
    }
}

/// Colours of media: pale, so that paths stand out.
const MEDIA: [(u8, u8, u8); 6] =
    [(228, 212, 178), (172, 200, 214), (214, 186, 206), (190, 208, 170), (236, 190, 164), (200, 200, 200)];

/// Colour of the `i`-th medium drawn, `shade` of its brightness.
fn colour(i: usize, shade: f64) -> String {
    let (r, g, b) = MEDIA[i % MEDIA.len()];
    let of = |c: u8| (f64::from(c) * shade).round() as u8;
    format!("#{:02x}{:02x}{:02x}", of(r), of(g), of(b))
}

/// Bodies, paths and sphere as SVG, and what is to be said below it. `None` where no history can be traced.
///
/// Where the universe places the sheet at random for each history, explicit bodies and volumes stand still
/// here, so that paths and bodies belong together. A sheet known by its statistics is drawn as one
/// realisation of them; its paths are those of the run, whose bodies are drawn as light meets them.
pub fn svg(scene: &Scene, plan: &Plan) -> Option<(String, String)> {
    let piece = Piece::of(scene, plan);
    let still = piece.still.clone().map(|universe| Plan { universe, ..plan.clone() });
    let traced = replay::first(scene, still.as_ref().unwrap_or(plan), HISTORIES).ok()?;
    let trails = Trails::of(&traced, piece.planes, piece.side);
    let middle = piece.middle.unwrap_or_else(|| trails.middle());
    let [bottom, top] = piece.planes;
    let half = 0.5 * piece.side;
    let corner = |i: usize| {
        let sign = |bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
        let z = if i & 4 == 0 { bottom } else { top };
        DVec3::new(middle[0] + half * sign(1), middle[1] + half * sign(2), z)
    };
    let corners: Vec<DVec3> = (0..8).map(corner).collect();
    // Room above for the light that comes and goes.
    let reach = trails.reach(piece.planes, piece.side);
    let mut bounds = corners.clone();
    bounds.extend(corners.iter().map(|p| *p + DVec3::Z * if p.z == top { reach } else { -0.7 * reach }));
    let eye = Eye::new().fitted(&bounds, LEFT);

    let mut body = String::new();
    let window = [[middle[0] - half, middle[1] - half], [middle[0] + half, middle[1] + half]];
    frame(&corners, &eye, false, &mut body);
    let drawn = piece.draw(&eye, window, &mut body);
    frame(&corners, &eye, true, &mut body);
    let counts = trails.draw(&eye, window, reach, &mut body);
    let sphere = sphere::draw(scene, &traced, &mut body);
    let bottom_line = legend(plan, &drawn, counts, piece.side, &eye, &mut body);
    let height = bottom_line + 14.0;
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"view\" viewBox=\"0 0 760 {height:.0}\" role=\"img\" font-size=\"11\" \
         font-family=\"system-ui,'DejaVu Sans',sans-serif\" stroke-linejoin=\"round\">\n<title>Sheet and paths</title>\n<style>{STYLE}</style>\n\
         <rect class=\"v-ground\" width=\"760\" height=\"{height:.0}\"/>\n{body}</svg>\n"
    );
    let mut caption = piece.words.to_owned();
    caption += &format!(
        " Paths of the first histories at {} nm: white-rimmed lines, drawn over the bodies; up to {} of each kind, cut where they leave the piece.",
        plan.groups[0][0],
        paths::EACH
    );
    caption += &sphere;
    Some((svg, caption))
}

const STYLE: &str = ".view text{fill:#262626}.view .v-ground{fill:#fff}.view .v-frame{stroke:#777;fill:none}.view .v-grid{stroke:#8a8a8a}\
                     @media (prefers-color-scheme:dark){.view text{fill:#e6e6e6}.view .v-ground{fill:#16181a}.view .v-frame{stroke:#999}}\
                     @media print{.view text{fill:#000}.view .v-ground{fill:#fff}.view .v-frame{stroke:#777}}";

/// Edges of the box; those in front of what stands in it, or those behind.
fn frame(corners: &[DVec3], eye: &Eye, front: bool, out: &mut String) {
    let nearest = (0..8).max_by(|a, b| eye.depth(corners[*a]).total_cmp(&eye.depth(corners[*b])));
    let hidden = nearest.unwrap_or(0) ^ 7;
    let mut d = String::new();
    for a in 0..8_usize {
        for bit in [1, 2, 4] {
            let b = a ^ bit;
            if a < b && (a == hidden || b == hidden) != front {
                let ((x1, y1), (x2, y2)) = (eye.place(corners[a]), eye.place(corners[b]));
                let _ = write!(d, "M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}");
            }
        }
    }
    let (dash, width) = if front { ("", 0.8) } else { (" stroke-dasharray=\"3 3\"", 0.6) };
    let _ = writeln!(out, "<path class=\"v-frame\" d=\"{d}\" stroke-width=\"{width}\"{dash}/>");
}

/// Media, kinds of paths and the scale; returns its lower edge.
fn legend(
    plan: &Plan,
    media: &[(MediumId, f64)],
    counts: [usize; 3],
    side: f64,
    eye: &Eye,
    out: &mut String,
) -> f64 {
    let mut at = (16.0, 384.0);
    let mut entry = |mark: &dyn Fn(f64, f64) -> String, words: &str, out: &mut String| {
        let wide = 26.0 + super::plot::width(words, 11.0);
        if at.0 + wide > 744.0 {
            at = (16.0, at.1 + 18.0);
        }
        let _ = writeln!(
            out,
            "{}<text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            mark(at.0, at.1),
            at.0 + 22.0,
            at.1 + 4.0,
            escape(words)
        );
        at.0 += wide + 10.0;
    };
    let bar = [0.01, 0.1, 1.0, 10.0, 100.0, 1000.0, 1e4]
        .into_iter()
        .flat_map(|b| [b, 2.0 * b, 5.0 * b])
        .rfind(|b| 4.0 * b <= side)
        .unwrap_or(0.01);
    // The box's edge along x lies aslant: the bar has its length as drawn.
    let long = bar * eye.scale * eye.right.x.abs();
    let _ = writeln!(
        out,
        "<path class=\"v-frame\" d=\"M16 362v-6m0 3h{long:.1}m0 -3v6\" stroke-width=\"1.4\"/>\
         <text x=\"{:.1}\" y=\"363\">{bar} µm along the front edge</text>",
        24.0 + long
    );
    let kinds = [Fate::Reflected, Fate::Transmitted, Fate::Ended];
    for (kind, n) in kinds.into_iter().zip(counts) {
        let mark = |x: f64, y: f64| {
            // On white, as in the picture: dark lines are seen on a dark page too.
            format!(
                "<path d=\"M{x:.1} {y:.1}h16\" stroke=\"#fff\" stroke-width=\"4.4\"/>\
                 <path d=\"M{x:.1} {y:.1}h16\" stroke=\"{}\" stroke-width=\"2.4\"/>",
                kind.colour()
            )
        };
        entry(&mark, &format!("{} ({n})", kind.words()), out);
    }
    for (i, (medium, share)) in media.iter().enumerate() {
        let name = plan.media.names.get(usize::from(medium.0)).map_or("?", String::as_str);
        let mark = |x: f64, y: f64| {
            format!(
                "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"14\" height=\"10\" fill=\"{}\" stroke=\"#777\" stroke-width=\".5\"/>",
                y - 5.0,
                colour(i, 1.0)
            )
        };
        let words = match *share {
            s if s < 1.0 => format!("{name} (1 of {:.0} drawn)", (1.0 / s).max(2.0)),
            _ => name.to_owned(),
        };
        entry(&mark, &words, out);
    }
    at.1
}
