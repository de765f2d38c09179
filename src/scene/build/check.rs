//! Consistency of a sheet: amounts that fit, sizes that agree with coarseness, geometric optics only
//! where it holds.

use super::{Node, Reading};
use crate::law::{SizeLaw, Tilt};
use crate::math::PI;
use crate::scene::adapters;
use crate::scene::diagnostic::{Diagnostic, Place};
use crate::scene::model::*;
use crate::universe::{MediumId, Overlap};

/// Nodes of each law in means over several: smooth functions are exact, the kink of full collapse costs
/// some 0.1 %.
const NODES: usize = 24;

/// Mean of a function of independent sizes, by product quadrature.
fn mean_of<const N: usize>(laws: [&SizeLaw; N], f: impl Fn([f64; N]) -> f64) -> f64 {
    let nodes = laws.map(|l| l.nodes(NODES));
    let mut index = [0; N];
    let mut sum = 0.0;
    loop {
        let weight: f64 = (0..N).map(|k| nodes[k][index[k]].1).product();
        sum += weight * f(std::array::from_fn(|k| nodes[k][index[k]].0));
        // The next combination, as a counter counts.
        let Some(k) = (0..N).find(|&k| index[k] + 1 < nodes[k].len()) else { return sum };
        index[..k].fill(0);
        index[k] += 1;
    }
}

/// Mean areas of the whole section and of its wall, µm². The section is an ellipse with half axes a, b;
/// the lumen one with a − t, b − t, nothing where either is ≤ 0 (fully collapsed).
pub fn section_areas(width: &SizeLaw, flatness: &SizeLaw, wall: Option<&SizeLaw>) -> (f64, f64) {
    let outer = mean_of([width, flatness], |[w, f]| 0.25 * PI * w * w * f);
    let Some(wall) = wall else { return (outer, outer) };
    let lumen = mean_of([width, flatness, wall], |[w, f, t]| {
        let (a, b) = (0.5 * w - t, 0.5 * w * f - t);
        if a > 0.0 && b > 0.0 { PI * a * b } else { 0.0 }
    });
    (outer, outer - lumen)
}

/// Coarseness that follows from the section, mg/m: density × mean wall area (1 kg/m³ · 1 µm² = 1e-6
/// mg/m); None for particles.
pub fn implied_coarseness(c: &Component) -> Option<f64> {
    let Shape::Fibre { width, flatness, wall, .. } = &c.shape else { return None };
    Some(1e-6 * c.density * section_areas(width, flatness, wall.as_ref()).1)
}

impl Reading<'_> {
    pub fn check_sheet(
        &mut self,
        universe: Node<'_>,
        sheet: &StatisticalSheet,
        layers: &[(Node<'_>, Layer)],
        materials: &[Material],
        surfaces: &[Surface],
    ) {
        if self.out.error_count() > 0 {
            return;
        }
        self.check_memory(universe, sheet, layers, materials, surfaces);
        let with_bodies: Vec<&(Node<'_>, Layer)> =
            layers.iter().filter(|l| !l.1.components.is_empty()).collect();
        let remembers = matches!(sheet.memory, Memory::Last(_) | Memory::Full);
        if let (Edges::Cut, false, [_, second, ..]) = (sheet.edges, remembers, with_bodies.as_slice()) {
            self.out.push(
                Diagnostic::error(second.0.own.place, "a second layer of bodies under edges=\"cut\"")
                    .label("bodies would be cut between two layers")
                    .other(universe.place("edges"), "asked for here")
                    .help("use edges=\"contained\" or memory=\"full\", or put all bodies into one layer"),
            );
        }
        for (node, layer) in layers {
            self.check_amounts(*node, layer, sheet.overlap);
            let bodies =
                node.all_children().filter(|c| matches!(c.own.name.as_str(), "fibres" | "particles"));
            for (e, c) in bodies.zip(&layer.components) {
                self.check_coarseness(e, c);
                let opaque = surfaces.get(usize::from(c.surface.0)).is_some_and(|s| s.opaque);
                if let (Some(d), false) = (smallest_size(&c.shape), opaque) {
                    self.check_size(e.own.place, &c.name, d, (c.material, layer.pore), materials);
                }
            }
        }
    }

    /// What a rung cannot do with a layer.
    fn check_memory(
        &mut self,
        universe: Node<'_>,
        sheet: &StatisticalSheet,
        layers: &[(Node<'_>, Layer)],
        materials: &[Material],
        surfaces: &[Surface],
    ) {
        let remembers = matches!(sheet.memory, Memory::Last(_) | Memory::Full);
        let bodies = layers.iter().flat_map(|(node, layer)| {
            let nodes = node.all_children().filter(|c| matches!(c.own.name.as_str(), "fibres" | "particles"));
            nodes.zip(&layer.components)
        });
        for (e, c) in bodies {
            let opaque = surfaces.get(usize::from(c.surface.0)).is_some_and(|s| s.opaque);
            let scatters = materials.get(usize::from(c.material.0)).is_some_and(|m| !m.scattering.is_empty());
            let tilted = c.tilt != Tilt::InPlane && matches!(c.shape, Shape::Fibre { finite: false, .. });
            let (place, problem, help) = if matches!(sheet.memory, Memory::Last(_)) && scatters && !opaque {
                (
                    universe.place("memory"),
                    format!("a finite memory is wrong for `{}`, whose material scatters inside", c.name),
                    "memory=\"full\", or memory=\"none\"",
                )
            } else if c.bonded > 0.0 && sheet.memory != Memory::None {
                (
                    e.place("bonded"),
                    format!("`bonded` of `{}` belongs to memory=\"none\"", c.name),
                    "where bodies overlap they are in contact by chance already: leave it out",
                )
            } else if c.profile.is_some() && !matches!(sheet.memory, Memory::None) && !remembers {
                (
                    e.own.place,
                    format!("this memory knows no <profile>, and `{}` has one", c.name),
                    "memory=\"full\" or memory=\"none\"",
                )
            } else if tilted && c.profile.is_some() {
                (
                    e.own.place,
                    format!(
                        "the unbounded tilted fibres `{}` have no depth that a <profile> could ask for",
                        c.name
                    ),
                    "ends=\"flat\" gives them an end, and so a centre",
                )
            } else if tilted && sheet.edges == Edges::Contained && layers.iter().all(|l| l.1.grace.is_none())
            {
                (
                    e.own.place,
                    format!("the unbounded tilted fibres `{}` cannot lie wholly in the sheet", c.name),
                    "ends=\"flat\", or edges=\"cut\"",
                )
            } else {
                continue;
            };
            self.out.push(Diagnostic::error(place, problem).help(help));
        }
        if let (true, Some((node, _))) = (remembers, layers.iter().find(|l| l.1.grace.is_some())) {
            self.out.push(
                Diagnostic::error(node.own.place, "a layer with <free-path> has no bodies to remember")
                    .other(universe.place("memory"), "asked for here")
                    .help("memory=\"none\""),
            );
        }
    }

    /// Grammage G in a layer of thickness T needs the wall fraction G/(ρT) < 1.
    fn check_amounts(&mut self, layer: Node<'_>, l: &Layer, overlap: Overlap) {
        let mut total = 0.0;
        for c in &l.components {
            let share = match c.amount {
                Amount::Grammage(g) => 1e3 * g / (c.density * l.thickness),
                Amount::VolumeFraction(v) => v,
                _ => 0.0,
            };
            total += share;
            // Under `priority` a lumen takes wall away: φ_wall < A_wall/A_out.
            let most = match (&c.shape, overlap, c.amount) {
                (Shape::Fibre { width, flatness, wall, .. }, Overlap::Priority, Amount::Grammage(_)) => {
                    let (outer, solid) = section_areas(width, flatness, wall.as_ref());
                    solid / outer
                }
                _ => 1.0,
            };
            if share >= most {
                self.out.push(
                    Diagnostic::error(
                        layer.own.place,
                        format!(
                            "`{}` would fill {:.1} % of a layer of {} um, which holds less than {:.1} %",
                            c.name,
                            100.0 * share,
                            l.thickness,
                            100.0 * most
                        ),
                    )
                    .label("impossible amount")
                    .help("a thicker layer, or a smaller amount"),
                );
                return;
            }
        }
        if total >= 1.0 {
            let message = format!("the bodies together would fill {:.1} % of the layer", 100.0 * total);
            let d = Diagnostic::error(layer.own.place, message).label("impossible amount");
            self.out.push(d.help("a thicker layer, or smaller amounts"));
        }
    }

    fn check_coarseness(&mut self, e: Node<'_>, c: &Component) {
        let (Some(given), Some(implied)) = (c.coarseness, implied_coarseness(c)) else { return };
        let area = 1e6 * implied / c.density;
        if (implied / given - 1.0).abs() > 0.2 {
            let place =
                if e.own.attribute("coarseness").is_some() { e.place("coarseness") } else { e.place("from") };
            self.out.push(
                Diagnostic::warning(
                    place,
                    format!(
                        "`{}`: the coarseness {given} mg/m and the section contradict each other: {} kg/m3 × a mean wall area of {area:.1} um2 is {implied:.3} mg/m",
                        c.name, c.density
                    ),
                )
                .label(format!("{:+.0} % by width, flatness and wall", 100.0 * (implied / given - 1.0)))
                .help("amounts are taken from the section; correct width, flatness or wall, or leave coarseness out"),
            );
        }
    }

    /// As the same check of a sheet, for an explicit body.
    pub fn check_optical_size(
        &mut self,
        place: Place,
        body: &Body,
        ambient: MediumId,
        materials: &[Material],
    ) {
        let size = match &body.geometry {
            Geometry::Sphere { radius, .. } => 2.0 * radius,
            Geometry::Ellipsoid { half_axes, .. } => 2.0 * half_axes.min_element(),
            _ => return,
        };
        self.check_size(place, &body.name, size, (body.material, ambient), materials);
    }

    /// Geometric optics needs x|m − 1| of 10 or more, x = π d n/λ, m the relative index.
    fn check_size(
        &mut self,
        place: Place,
        name: &str,
        size: f64,
        media: (MediumId, MediumId),
        materials: &[Material],
    ) {
        let index =
            |m: MediumId, nm: f64| adapters::index_at(&materials.get(usize::from(m.0))?.index, nm).ok();
        let contrast = |nm: f64| {
            let (inside, around) = (index(media.0, nm)?, index(media.1, nm)?);
            let m = inside / around;
            let difference = ((m.re - 1.0) * (m.re - 1.0) + m.im * m.im).sqrt();
            (difference > 1e-9).then_some((PI * size * around.re / (1e-3 * nm) * difference, nm))
        };
        let worst = self.wavelengths.iter().filter_map(|nm| contrast(*nm)).min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((x, nm)) = worst
            && x < 10.0
        {
            self.out.push(
                Diagnostic::warning(
                    place,
                    format!("`{name}` of {size:.3} um is small for geometric optics: x|m − 1| = {x:.2} at {nm} nm, below 10"),
                )
                .help("small particles belong to the medium that holds them: <material …><particles diameter=… index=… volume-fraction=…/></material>"),
            );
        }
    }
}

/// Mean of the smallest size of a particle, µm; None for fibres.
fn smallest_size(shape: &Shape) -> Option<f64> {
    match shape {
        Shape::Fibre { .. } => None,
        Shape::Sphere { diameter } => Some(mean_of([diameter], |[d]| d)),
        Shape::Disc { diameter, thickness } => Some(mean_of([diameter, thickness], |[d, t]| d.min(t))),
        Shape::Ellipsoid { axes: [a, b, c] } => Some(mean_of([a, b, c], |[a, b, c]| a.min(b).min(c))),
    }
}
