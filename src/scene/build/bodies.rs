//! The synthetic universe: explicit bodies.

use super::{Node, Reading};
use crate::math::{DVec3, Frame};
use crate::scene::diagnostic::Diagnostic;
use crate::scene::model::*;
use crate::universe::shape::SlantedCylinder;
use crate::universe::{MediumId, Overlap};

impl Reading<'_> {
    pub fn synthetic(&mut self, e: Node<'_>, materials: &[Material]) -> Universe {
        let ambient = self.outside(e);
        let (mut bodies, mut cell, mut skins, mut random) = (Vec::new(), None, Vec::new(), None);
        for c in e.all_children() {
            if c.own.name == "mixture" {
                let d = Diagnostic::error(c.own.place, "a <mixture> is known by its statistics only");
                self.out.push(d.help("use kind=\"statistical\""));
            } else if c.own.name == "volume" {
                let d = Diagnostic::error(c.own.place, "a <volume> is known voxel by voxel");
                self.out.push(d.help("use kind=\"voxel\""));
            } else if c.own.name == "cell" {
                cell = self.cell(e, c);
            } else if c.own.name == "topography" {
                random = random.or(c.text("position").map(|p| p == "random"));
                skins.push(c);
            } else if c.own.name == "realise" {
                let d = Diagnostic::error(c.own.place, "nothing to realise");
                self.out.push(d.help("a <sheet> whose layers hold <fibres> or <particles>"));
                c.use_all();
            } else if c.own.name == "sheet" {
                bodies.extend(self.slabs(e, c));
            } else if let Some(geometry) = self.geometry(c, ambient) {
                let body = self.body(c, geometry, bodies.len());
                self.check_optical_size(c.own.place, &body, ambient, materials);
                bodies.push(body);
            }
        }
        if bodies.is_empty() {
            let d = Diagnostic::error(e.own.place, "the universe is empty");
            self.out
                .push(d.help("add a primitive (sphere, ellipsoid, cylinder, box, plane, slab) or a <sheet>"));
        }
        let skins = self.skins(&skins, cell.as_ref());
        if skins.iter().any(Option::is_some) {
            self.stands_with(e, cell.as_ref(), &bodies, random);
        }
        Universe::Synthetic(Synthetic { cell, ambient, bodies, skins, random })
    }

    fn cell(&mut self, universe: Node<'_>, e: Node<'_>) -> Option<Cell> {
        let (period, bottom, top) = (e.list("period")?, e.number("bottom")?, e.number("top")?);
        if bottom >= top {
            self.error(e.place("top"), "`top` must be above `bottom`");
        }
        let overlap = match universe.text("overlap") {
            Some("priority") => Overlap::Priority,
            Some("forbid") => Overlap::Forbid,
            _ => Overlap::Union,
        };
        let start = if universe.text("start") == Some("pore") { StartIn::Pore } else { StartIn::Anywhere };
        let planes = [bottom, top];
        match period[..] {
            [p] => Some(Cell { period: [p; 2], planes, overlap, start }),
            [x, y] => Some(Cell { period: [x, y], planes, overlap, start }),
            _ => {
                self.error(e.place("period"), "expected one or two edges");
                None
            }
        }
    }

    fn body(&mut self, e: Node<'_>, geometry: Geometry, number: usize) -> Body {
        let name = e.text("name").map_or_else(|| format!("{} {}", e.own.name, number + 1), str::to_string);
        Body {
            name,
            geometry,
            material: self.material(e, "material").unwrap_or(MediumId(0)),
            surface: self.surface_id(e, "surface"),
            priority: e.text("priority").and_then(|p| p.parse().ok()).unwrap_or(0),
        }
    }

    /// The homogeneous layers of a sheet, from z = thickness down to z = 0.
    fn slabs(&mut self, universe: Node<'_>, sheet: Node<'_>) -> Vec<Body> {
        if self.backing(universe, sheet).is_some() {
            let d = Diagnostic::error(sheet.place("backing"), "a synthetic universe has no backing");
            self.out.push(
                d.help("put a <slab> with an opaque Lambertian surface below, or use kind=\"statistical\""),
            );
        }
        let _ = sheet.text("name");
        let layers = self.layers(sheet);
        let mut top: f64 = layers.iter().map(|l| l.1.thickness).sum();
        let count = layers.len();
        let mut bodies = Vec::new();
        for (i, (node, layer)) in layers.into_iter().enumerate() {
            let z_max = top;
            top = if i + 1 == count { 0.0 } else { top - layer.thickness };
            bodies.push(Body {
                name: node.text("name").map_or_else(|| format!("layer {}", i + 1), str::to_string),
                geometry: Geometry::Slab { z_min: top, z_max },
                material: layer.pore,
                surface: layer.surface,
                priority: 0,
            });
        }
        bodies
    }

    fn geometry(&mut self, e: Node<'_>, ambient: MediumId) -> Option<Geometry> {
        match e.own.name.as_str() {
            "sphere" => Some(Geometry::Sphere { centre: e.vector("centre")?, radius: e.number("radius")? }),
            "ellipsoid" => {
                let half_axes = e.vector("half-axes");
                let (axis, major) = self.frame(e, DVec3::Z)?;
                Some(Geometry::Ellipsoid { centre: e.vector("centre")?, half_axes: half_axes?, axis, major })
            }
            "cylinder" => self.cylinder(e, ambient),
            "piece" => self.piece(e, ambient),
            "box" => {
                let (min, max) = (e.vector("min")?, e.vector("max")?);
                if min.cmpge(max).any() {
                    self.error(e.place("max"), "every coordinate of `max` must be above that of `min`");
                }
                Some(Geometry::Box { min, max })
            }
            "plane" => {
                let point = e.vector("point");
                let normal = self.direction(e, "normal", DVec3::Z)?;
                Some(Geometry::Plane { point: point?, normal })
            }
            _ => {
                let (z_min, z_max) = (e.number("z-min")?, e.number("z-max")?);
                if z_min >= z_max {
                    self.error(e.place("z-max"), "`z-max` must be above `z-min`");
                }
                Some(Geometry::Slab { z_min, z_max })
            }
        }
    }

    fn cylinder(&mut self, e: Node<'_>, ambient: MediumId) -> Option<Geometry> {
        let centre = e.vector("centre");
        let half_length = e.number("length").map(|l| 0.5 * l);
        let frame = self.frame(e, DVec3::X);
        let (a, b) = match e.one_of(self, &["radius", "half-axes"], Some("a section"))? {
            "radius" => {
                let r = e.number("radius")?;
                (r, r)
            }
            _ => {
                let v = e.list("half-axes").filter(|v| v.len() == 2)?;
                (v[0], v[1])
            }
        };
        let lumen = match e.number("wall") {
            Some(t) if t < a.min(b) => Some(((a - t, b - t), self.material(e, "lumen").unwrap_or(ambient))),
            Some(t) => {
                let d = Diagnostic::error(e.place("wall"), format!("a wall of {t} um leaves no lumen"));
                self.out.push(d.help(format!("below {} um, or without `wall`: solid", a.min(b))));
                None
            }
            None => None,
        };
        let (axis, major) = frame?;
        Some(Geometry::Cylinder { centre: centre?, axis, major, half_axes: (a, b), half_length, lumen })
    }

    fn piece(&mut self, e: Node<'_>, ambient: MediumId) -> Option<Geometry> {
        let (section, hollow, frame) = (e.list("half-axes")?, e.list("hollow"), self.frame(e, DVec3::X)?);
        let [a, b] = section[..] else { return None };
        let (from, to) = (e.number("from")?, e.number("to")?);
        if from >= to {
            self.error(e.place("to"), "`to` must be above `from`");
        }
        let lumen = match hollow.as_deref() {
            Some(&[x, y]) if x < a && y < b => Some(((x, y), self.material(e, "lumen").unwrap_or(ambient))),
            Some(_) => {
                self.error(e.place("hollow"), "the hollow must lie within the section");
                None
            }
            None => None,
        };
        let (height, slope) = (e.number("height")?, e.number("slope")?);
        let shape = SlantedCylinder { a, b, from, to, height, slope };
        let (axis, major) = frame;
        Some(Geometry::Piece { centre: e.vector("centre")?, axis, major, shape, lumen })
    }

    /// A direction made unit.
    fn direction(&mut self, e: Node<'_>, name: &str, default: DVec3) -> Option<DVec3> {
        if e.text(name).is_none() {
            return Some(default);
        }
        let v = e.vector(name)?;
        let largest = v.abs().max_element();
        if largest == 0.0 {
            self.error(e.place(name), "a direction of length zero");
            return None;
        }
        Some((v / largest).normalize())
    }

    /// `axis` and the unit part of `major` across it; without `major` the horizontal direction across
    /// the axis (x for a vertical axis).
    fn frame(&mut self, e: Node<'_>, default: DVec3) -> Option<(DVec3, DVec3)> {
        let axis = self.direction(e, "axis", default)?;
        let horizontal = if axis.x.abs() + axis.y.abs() < 1e-12 { DVec3::X } else { DVec3::Z.cross(axis) };
        let major = self.direction(e, "major", horizontal)?;
        if axis.cross(major).length_squared() < 1e-12 {
            self.error(e.place("major"), "`major` is parallel to `axis`");
            return None;
        }
        Some((axis, Frame::with_x_toward(axis, major).x))
    }
}
