//! Solids as shaded polygons, drawn from back to front.

use super::{Eye, colour};
use crate::math::{DVec3, TAU, sin_cos};
use crate::universe::shape::{Placed, Shape};
use crate::universe::synthetic::Part;
use crate::universe::topography::Topography;
use crate::universe::voxel::VoxelUniverse;
use crate::universe::{Face, MediumId};
use std::fmt::Write;

/// Corners around a section.
const AROUND: usize = 14;
/// Steps of brightness.
const SHADES: f64 = 12.0;
/// Blocks of voxels along an edge of the window.
const BLOCKS: usize = 30;
/// Patches of a measured surface along an edge of the window.
const PATCHES: usize = 56;

/// A convex piece: its depth, and polygons with their colour.
pub struct Item {
    depth: f64,
    faces: Vec<(Vec<(f64, f64)>, String)>,
}

/// Draws from back to front; neighbours of one colour share a path. Colours are classes, for short paths.
pub fn paint(mut items: Vec<Item>, out: &mut String) {
    items.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let mut colours: Vec<String> = Vec::new();
    let (mut paths, mut last) = (String::new(), usize::MAX);
    for (corners, colour) in items.into_iter().flat_map(|i| i.faces) {
        let class = colours.iter().position(|c| *c == colour).unwrap_or_else(|| {
            colours.push(colour);
            colours.len() - 1
        });
        if class != last {
            let _ = write!(
                paths,
                "{}<path class=\"v{class}\" d=\"",
                if last == usize::MAX { "" } else { "\"/>\n" }
            );
            last = class;
        }
        for (i, (x, y)) in corners.iter().enumerate() {
            let _ = write!(paths, "{}{x:.1} {y:.1}", ["M", "L", " "][i.min(2)]);
        }
        paths.push('z');
    }
    if last == usize::MAX {
        return;
    }
    let styles: String =
        colours.iter().enumerate().map(|(i, c)| format!(".view .v{i}{{fill:{c};stroke:{c}}}")).collect();
    let _ =
        writeln!(out, "<style>{styles}</style>\n<g class=\"v-bodies\" stroke-width=\".4\">{paths}\"/></g>");
}

fn shaded(medium: usize, brightness: f64) -> String {
    colour(medium, (brightness * SHADES).round() / SHADES)
}

fn polygon(eye: &Eye, points: &[DVec3]) -> Vec<(f64, f64)> {
    points.iter().map(|p| eye.place(*p)).collect()
}

/// Pieces of a body within the window; `media` are the numbers of its solid and of its hollow.
#[allow(clippy::too_many_arguments)]
pub fn body(
    part: &Part,
    hollow: Option<&Part>,
    media: [usize; 2],
    shift: DVec3,
    eye: &Eye,
    window: [[f64; 2]; 2],
    planes: [f64; 2],
    items: &mut Vec<Item>,
) {
    let placed = Placed::new(part.shape.shape, part.shape.centre + shift, part.shape.frame);
    let bounds = [[window[0][0], window[1][0]], [window[0][1], window[1][1]], planes];
    match placed.shape {
        Shape::Cylinder(c) => {
            let lumen = hollow.and_then(|h| match h.shape.shape {
                Shape::Cylinder(l) => Some((l.a, l.b)),
                _ => None,
            });
            let reach = c.half_length.unwrap_or(f64::INFINITY);
            let Some((from, to)) = within(&placed, [-reach, reach], &bounds) else { return };
            tube(
                &Tube { placed: &placed, a: c.a, b: c.b, lumen, media, slope: (0.0, 0.0) },
                from,
                to,
                eye,
                items,
            );
        }
        Shape::Slanted(s) => {
            let lumen = hollow.and_then(|h| match h.shape.shape {
                Shape::Slanted(l) => Some((l.a, l.b)),
                _ => None,
            });
            let Some((from, to)) = within(&placed, [s.from, s.to], &bounds) else { return };
            let slope = (s.centre(0.0), s.slope);
            tube(&Tube { placed: &placed, a: s.a, b: s.b, lumen, media, slope }, from, to, eye, items);
        }
        Shape::Ellipsoid(e) => {
            let p = placed.centre;
            if bounds[..2].iter().zip([p.x, p.y]).all(|(b, x)| b[0] <= x && x <= b[1]) {
                ellipsoid(&placed, [e.a, e.b, e.c], media[0], eye, items);
            }
        }
        Shape::Cuboid(b) => {
            let limit = |v: DVec3| {
                DVec3::new(v.x.clamp(bounds[0][0], bounds[0][1]), v.y.clamp(bounds[1][0], bounds[1][1]), v.z)
            };
            let [low, high] = [b.min, b.max].map(|v| limit(v + placed.centre));
            if (high - low).min_element() > 0.0 {
                items.push(cuboid(low, high, media[0], [true; 3], eye));
            }
        }
        // Without end: the box itself shows where the sheet is.
        Shape::HalfSpace(_) | Shape::SlabZ(_) => {}
    }
}

/// The part of the axis (local z) whose points lie within the bounds; level axes by their middle only in z.
fn within(placed: &Placed, range: [f64; 2], bounds: &[[f64; 2]; 3]) -> Option<(f64, f64)> {
    let (mut from, mut to) = (range[0], range[1]);
    let (c, d) = (placed.centre, placed.frame.z);
    for (k, (x, u)) in [(c.x, d.x), (c.y, d.y), (c.z, d.z)].into_iter().enumerate() {
        let [low, high] = bounds[k];
        if u.abs() < 1e-9 {
            if k < 2 && (x < low || x > high) {
                return None;
            }
            continue;
        }
        let (a, b) = ((low - x) / u, (high - x) / u);
        from = from.max(a.min(b));
        to = to.min(a.max(b));
    }
    (to > from && from.is_finite() && to.is_finite()).then_some((from, to))
}

struct Tube<'a> {
    placed: &'a Placed,
    a: f64,
    b: f64,
    lumen: Option<(f64, f64)>,
    media: [usize; 2],
    /// Height of the axis at z = 0 and its rise.
    slope: (f64, f64),
}

impl Tube<'_> {
    fn ring(&self, z: f64, a: f64, b: f64) -> Vec<DVec3> {
        let corner = |i: usize| {
            let (s, c) = sin_cos(TAU * i as f64 / AROUND as f64);
            let local = DVec3::new(a * c, b * s + self.slope.0 + self.slope.1 * z, z);
            self.placed.centre + self.placed.frame.to_world(local)
        };
        (0..AROUND).map(corner).collect()
    }
}

/// A tube cut into pieces as long as it is wide, so that crossing tubes are drawn in the right order.
fn tube(t: &Tube, from: f64, to: f64, eye: &Eye, items: &mut Vec<Item>) {
    let pieces = ((to - from) / (1.6 * t.a.max(t.b)).max(6.0 / eye.scale)).ceil().clamp(1.0, 60.0) as usize;
    let step = (to - from) / pieces as f64;
    let frame = t.placed.frame;
    let normal = |i: usize| {
        let (s, c) = sin_cos(TAU * (i as f64 + 0.5) / AROUND as f64);
        frame.to_world(DVec3::new(t.b * c, t.a * s, 0.0)).normalize()
    };
    let mut low = t.ring(from, t.a, t.b);
    for k in 0..pieces {
        let z = from + (k + 1) as f64 * step;
        let high = t.ring(z, t.a, t.b);
        let mut faces = Vec::new();
        for i in 0..AROUND {
            let (n, j) = (normal(i), (i + 1) % AROUND);
            if n.dot(eye.toward) > 0.0 {
                let face = polygon(eye, &[low[i], low[j], high[j], high[i]]);
                faces.push((face, shaded(t.media[0], eye.shade(n))));
            }
        }
        for (end, sign, z) in [(k == 0, -1.0, from), (k + 1 == pieces, 1.0, z)] {
            let n = frame.z * sign;
            if end && n.dot(eye.toward) > 0.0 {
                let ring = if sign < 0.0 { &low } else { &high };
                faces.push((polygon(eye, ring), shaded(t.media[0], 0.94 * eye.shade(n))));
                if let Some((a, b)) = t.lumen {
                    faces.push((polygon(eye, &t.ring(z, a, b)), shaded(t.media[1], 0.5)));
                }
            }
        }
        let middle = t.placed.centre
            + frame.to_world(DVec3::new(0.0, t.slope.0 + t.slope.1 * (z - 0.5 * step), z - 0.5 * step));
        items.push(Item { depth: eye.depth(middle), faces });
        low = high;
    }
}

/// The outline of an ellipsoid as seen, and two lighter ones within.
fn ellipsoid(placed: &Placed, half: [f64; 3], medium: usize, eye: &Eye, items: &mut Vec<Item>) {
    let f = placed.frame;
    // Rows of the map from the unit sphere to the picture.
    let row = |r: DVec3| DVec3::new(half[0] * f.x.dot(r), half[1] * f.y.dot(r), half[2] * f.z.dot(r));
    let (p, q) = (row(eye.right), row(eye.up));
    let e1 = p.normalize();
    let e2 = (q - e1 * q.dot(e1)).normalize_or_zero();
    let (x, y) = eye.place(placed.centre);
    let outline = |size: f64, shift: f64| -> Vec<(f64, f64)> {
        let corner = |i: usize| {
            let (s, c) = sin_cos(TAU * i as f64 / AROUND as f64);
            let u = (e1 * c + e2 * s) * size + (e2 * 0.8 - e1 * 0.5) * shift;
            (x + eye.scale * u.dot(p), y - eye.scale * u.dot(q))
        };
        (0..AROUND).map(corner).collect()
    };
    let mut faces = vec![(outline(1.0, 0.0), shaded(medium, 0.66))];
    if eye.scale * p.length() > 1.5 {
        faces.push((outline(0.74, 0.2), shaded(medium, 0.84)));
        faces.push((outline(0.4, 0.36), shaded(medium, 1.0)));
    }
    items.push(Item { depth: eye.depth(placed.centre), faces });
}

/// The faces of a box that look to the viewer, those along x, y and z where they are wanted.
fn cuboid(low: DVec3, high: DVec3, medium: usize, shown: [bool; 3], eye: &Eye) -> Item {
    let at = |x: bool, y: bool, z: bool| {
        DVec3::new(
            if x { high.x } else { low.x },
            if y { high.y } else { low.y },
            if z { high.z } else { low.z },
        )
    };
    let (px, py, pz) = (eye.toward.x > 0.0, eye.toward.y > 0.0, eye.toward.z > 0.0);
    let sign = |up: bool| if up { 1.0 } else { -1.0 };
    let (f, t) = (false, true);
    let all = [
        ([at(px, f, f), at(px, t, f), at(px, t, t), at(px, f, t)], DVec3::X * sign(px)),
        ([at(f, py, f), at(t, py, f), at(t, py, t), at(f, py, t)], DVec3::Y * sign(py)),
        ([at(f, f, pz), at(t, f, pz), at(t, t, pz), at(f, t, pz)], DVec3::Z * sign(pz)),
    ];
    let faces = all.into_iter().zip(shown).filter(|f| f.1);
    let faces =
        faces.map(|((corners, n), _)| (polygon(eye, &corners), shaded(medium, eye.shade(n)))).collect();
    Item { depth: eye.depth((low + high) * 0.5), faces }
}

/// Measured surfaces as patches, where a body stands behind them: that on top is seen.
pub fn surfaces(
    u: &Topography,
    window: [[f64; 2]; 2],
    eye: &Eye,
    number: &mut dyn FnMut(MediumId) -> usize,
    items: &mut Vec<Item>,
) {
    let Some(skin) = u.skin(Face::Top) else { return };
    let step = [0, 1].map(|a| (window[1][a] - window[0][a]) / PATCHES as f64);
    let at = |i: usize, j: usize| {
        let (x, y) = (window[0][0] + i as f64 * step[0], window[0][1] + j as f64 * step[1]);
        DVec3::new(x, y, skin.map.height(x, y))
    };
    for i in 0..PATCHES {
        for j in 0..PATCHES {
            let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let middle = (corners[0] + corners[1] + corners[2] + corners[3]) * 0.25;
            let up = (corners[2] - corners[0]).cross(corners[3] - corners[1]).normalize();
            let medium = u.bodies().medium_at(middle - DVec3::Z * (1e-3 * step[0]));
            if medium == u.bodies().ambient() {
                continue;
            }
            let face = (polygon(eye, &corners), shaded(number(medium), eye.shade(up)));
            items.push(Item { depth: eye.depth(middle), faces: vec![face] });
        }
    }
}

/// Blocks of voxels: their faces towards the viewer where another medium lies before them. The medium of
/// the first voxels above the sheet is taken as clear.
pub fn voxels(
    u: &VoxelUniverse,
    window: [[f64; 2]; 2],
    planes: [f64; 2],
    eye: &Eye,
    number: &mut dyn FnMut(MediumId) -> usize,
    items: &mut Vec<Item>,
) {
    let (edge, _) = u.sizes();
    let side = window[1][0] - window[0][0];
    let least = side / BLOCKS as f64;
    // Whole voxels together.
    let size = edge.map(|e| e * (least / e).ceil().max(1.0));
    let count = [side, side, planes[1] - planes[0]].map(|l| l);
    let n: [i64; 3] = [0, 1, 2].map(|k| (count[k] / size[k]).floor().max(1.0) as i64);
    let corner = DVec3::new(window[0][0], window[0][1], planes[0]);
    let low = |i: [i64; 3]| {
        corner + DVec3::new(i[0] as f64 * size[0], i[1] as f64 * size[1], i[2] as f64 * size[2])
    };
    let step = DVec3::new(size[0], size[1], size[2]);
    let clear = u.medium_at(DVec3::new(0.0, 0.0, planes[1] + 1.0));
    let medium = |i: [i64; 3]| {
        let inside = (0..3).all(|k| i[k] >= 0 && i[k] < n[k]);
        if inside { u.medium_at(low(i) + step * 0.5 + DVec3::splat(1e-6)) } else { clear }
    };
    let ahead = [eye.toward.x, eye.toward.y, eye.toward.z].map(|t| if t > 0.0 { 1 } else { -1 });
    for x in 0..n[0] {
        for y in 0..n[1] {
            for z in 0..n[2] {
                let own = medium([x, y, z]);
                if own == clear {
                    continue;
                }
                let shown = [0, 1, 2].map(|k| {
                    let mut next = [x, y, z];
                    next[k] += ahead[k];
                    medium(next) == clear
                });
                if shown != [false; 3] {
                    let at = low([x, y, z]);
                    items.push(cuboid(at, at + step, number(own), shown, eye));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::frame::Frame;
    use crate::universe::shape::Ellipsoid;

    /// The outline of a ball is a circle of its radius, whatever its frame.
    #[test]
    fn a_ball_is_round() {
        let eye = Eye::new();
        let frame = Frame::from_pole(DVec3::new(0.3, -0.5, 0.8).normalize());
        let placed = Placed::new(Shape::Ellipsoid(Ellipsoid::sphere(7.0)), DVec3::ZERO, frame);
        let mut items = Vec::new();
        ellipsoid(&placed, [7.0; 3], 0, &eye, &mut items);
        for (x, y) in &items[0].faces[0].0 {
            assert!(((x * x + y * y).sqrt() - 7.0).abs() < 1e-9);
        }
    }

    /// A box shows three faces whose areas are those of the projections of its sides.
    #[test]
    fn faces_of_a_box_have_their_projected_areas() {
        let eye = Eye::new();
        let size = DVec3::new(2.0, 3.0, 5.0);
        let item = cuboid(DVec3::ZERO, size, 0, [true; 3], &eye);
        let area = |p: &[(f64, f64)]| {
            let turn = (0..p.len()).map(|i| {
                let (a, b) = (p[i], p[(i + 1) % p.len()]);
                0.5 * (a.0 * b.1 - a.1 * b.0)
            });
            turn.sum::<f64>().abs()
        };
        let t = eye.toward.abs();
        let wanted = [t.x * size.y * size.z, t.y * size.x * size.z, t.z * size.x * size.y];
        for (face, want) in item.faces.iter().zip(wanted) {
            assert!((area(&face.0) - want).abs() < 1e-9, "{} {want}", area(&face.0));
        }
    }
}
