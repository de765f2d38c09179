//! Measured surfaces that cut explicit bodies off.

use super::{Node, Reading};
use crate::scene::diagnostic::Diagnostic;
use crate::scene::model::{Body, Cell, Geometry, Source};
use crate::universe::shape::height::{HeightError, HeightMap};
use crate::universe::topography::{self, Error, Skin, file};
use std::sync::Arc;

impl Reading<'_> {
    /// The surfaces on top and at the bottom.
    pub fn skins(&mut self, elements: &[Node<'_>], cell: Option<&Cell>) -> [Option<Skin>; 2] {
        let mut skins: [Option<Skin>; 2] = [None, None];
        let mut sides = [None, None];
        for e in elements {
            let side = usize::from(e.text("side") == Some("bottom"));
            if let Some(first) = sides[side].replace(e.own.place) {
                let name = ["top", "bottom"][side];
                let d = Diagnostic::error(e.own.place, format!("a second surface on the {name}"));
                self.out.push(
                    d.other(first, "the first one")
                        .help("each side has one: take one of the maps, or the other side"),
                );
            }
            // Nothing is read for a scene that is refused anyway.
            if self.out.error_count() == 0 {
                skins[side] = self.skin(*e);
            }
        }
        let cell = cell.map(|c| (c.period, c.planes));
        if let (Some(e), true) = (elements.last(), self.out.error_count() == 0)
            && let Err(error) = topography::agree(&skins, cell)
        {
            let d = Diagnostic::error(e.own.place, error.to_string());
            self.out.push(match error {
                Error::Sides(..) => {
                    d.help("both sides of a sheet are measured over the same area: cut out the same")
                }
                Error::Period(..) => {
                    d.help("a map of n pixels repeats after n of them, mirrored after 2 n - 2")
                }
                Error::Planes(..) => d.help("raise `top` or lower `bottom` of the <cell>, or set `level`"),
                _ => d.help("`level` puts the mean of a map at a height: set them further apart"),
            });
        }
        skins
    }

    fn skin(&mut self, e: Node<'_>) -> Option<Skin> {
        let surface = self.surface_id(e, "surface");
        let a = e.attribute("file")?;
        let (path, full) = self.located(a)?;
        let read = match file::read(&full) {
            Ok(read) => read,
            Err(error) => {
                let d = Diagnostic::error(a.value_place, error.to_string());
                self.out.push(d.help(error.help));
                return None;
            }
        };
        let _ = self.note_file(&path);
        let own = match e.list("pixel").as_deref() {
            Some(&[p]) => Some([p; 2]),
            Some(&[x, y]) => Some([x, y]),
            Some(other) => {
                let what = format!("expected one or two edges, found {}", other.len());
                let d = Diagnostic::error(e.place("pixel"), what);
                self.out.push(d.help("as \"1 um\", or \"1 2 um\" for x and y"));
                return None;
            }
            None => None,
        };
        let Some(pixel) = own.or(read.scale.map(|s| s.0)) else {
            let d = Diagnostic::error(e.own.place, "the size of a pixel is not known");
            self.out.push(d.help("as pixel=\"1 um\", or \"1 2 um\" for x and y: this file does not tell"));
            return None;
        };
        let unit = e.number("unit").or(read.scale.map(|s| s.1)).unwrap_or(1.0);
        let columns = read.nodes[0];
        let made = HeightMap::measured(
            read.values.iter().map(|v| v * unit).collect(),
            read.nodes,
            pixel,
            e.text("lateral") != Some("periodic"),
            e.number("level"),
        );
        match made {
            Ok(map) => Some(Skin { map: Arc::new(map), surface }),
            Err(error) => {
                let d = Diagnostic::error(a.value_place, error.to_string());
                self.out.push(match error {
                    HeightError::Hole(column, row) => d.help(format!(
                        "value {} of the file; instruments leave holes where they saw nothing: interpolate them",
                        row * columns + column
                    )),
                    _ => d,
                });
                None
            }
        }
    }

    /// Bodies that stand alone have a place; what is displaced by chance must be the same everywhere.
    pub fn stands_with(&mut self, e: Node<'_>, cell: Option<&Cell>, bodies: &[Body], random: Option<bool>) {
        if random == Some(true) && cell.is_none() && !even(bodies) {
            let d = Diagnostic::error(e.own.place, "bodies that stand alone cannot be displaced by chance");
            self.out
                .push(d.help("position=\"fixed\" for the <topography>, or a <cell> in which they repeat"));
        }
        if e.text("start") == Some("pore") {
            let d = Diagnostic::error(e.place("start"), "light starts outside the measured surface");
            self.out.push(d.help("start=\"anywhere\""));
        }
    }
}

/// Whether bodies are the same everywhere sideways.
pub fn even(bodies: &[Body]) -> bool {
    bodies.iter().all(|b| match &b.geometry {
        Geometry::Slab { .. } => true,
        Geometry::Plane { normal, .. } => normal.x == 0.0 && normal.y == 0.0,
        _ => false,
    })
}

/// Whether each history finds bodies and surfaces displaced by chance.
pub fn anywhere(cell: bool, bodies: &[Body], written: Option<bool>, source: &Source) -> bool {
    let placed = matches!(source, Source::Point { .. })
        || matches!(source, Source::Collimated { radius, .. } if *radius > 0.0);
    written.unwrap_or(!placed && (cell || even(bodies)))
}
