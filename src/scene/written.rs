//! Explicit universes as the text of a scene: what `realise` writes.

use super::build::{self, Options};
use super::diagnostic::Place;
use super::document::{self, Element};
use super::media::{Media, Origin};
use super::model::{Cell, Scene, StartIn};
use crate::math::DVec3;
use crate::universe::shape::{Placed, Shape};
use crate::universe::synthetic::Part;
use crate::universe::{MediumId, Overlap};
use std::fmt::Write;
use std::path::Path;

/// The text of a scene with another `<universe>`. Placeholders are filled, and values of the command line stand
/// in their places: the scene wants neither any more.
///
/// # Errors
/// A text without a universe of its own (it may stand in a file that is included), or with values for such a file.
pub fn replace_universe(
    text: &str,
    path: &Path,
    options: &Options,
    universe: &str,
) -> Result<String, String> {
    let told = |why: &str| format!("{}: {why}", path.display());
    let raw = document::parse(text, 0).map_err(|_| told("cannot be read again"))?;
    let child = |name: &'static str| raw.children.iter().filter(move |c| c.name == name);
    let own = child("universe").next();
    let span = own.ok_or_else(|| told("its <universe> stands in a file that it includes"))?.span;
    let mut edits = vec![(span, universe.trim().to_owned())];
    edits.extend(child("define").map(|d| (d.span, String::new())));
    if edits.len() > 1 || !options.defines.is_empty() {
        if child("include").next().is_some() {
            return Err(told(
                "has <include> and placeholders or -D: write the included parts and the values into it",
            ));
        }
        let settled = build::settled(text, path, options).map_err(|d| d.render_for_stderr())?;
        for (before, after) in raw.children.iter().zip(&settled.children) {
            if !["universe", "define"].contains(&before.name.as_str()) {
                changes(before, after, &mut edits);
            }
        }
        changes(&Element { children: Vec::new(), ..raw.clone() }, &settled, &mut edits);
    }
    edits.sort_by_key(|(place, _)| place.start);
    let (mut out, mut from) = (String::new(), 0);
    for (place, new) in edits {
        out += &text[from..place.start];
        out += &new;
        from = place.end;
    }
    Ok(out + &text[from..])
}

/// Attributes that are otherwise, or new, in `after`, here and below; the trees are of one shape.
fn changes(before: &Element, after: &Element, edits: &mut Vec<(Place, String)>) {
    for a in &after.attributes {
        match before.attribute(&a.name) {
            Some(old) if old.value == a.value => {}
            Some(old) => edits.push((old.value_place, escaped(&a.value))),
            None => {
                let behind = Place { start: before.place.end, ..before.place };
                edits.push((behind, format!(" {}=\"{}\"", a.name, escaped(&a.value))));
            }
        }
    }
    for (b, a) in before.children.iter().zip(&after.children) {
        changes(b, a, edits);
    }
}

/// The `<universe>` of explicit bodies, each with its hollow.
///
/// # Errors
/// Bodies that a scene has no element for.
pub fn explicit(
    bodies: &[(Part, Option<Part>)],
    cell: Cell,
    pore: MediumId,
    media: &Media,
    scene: &Scene,
) -> Result<String, String> {
    let material = |m: MediumId| escaped(&material_of(m, media, scene));
    let [px, py] = cell.period;
    let [bottom, top] = cell.planes;
    let overlap = match cell.overlap {
        Overlap::Union => "union",
        Overlap::Priority => "priority",
        Overlap::Forbid => "forbid",
    };
    let start = if cell.start == StartIn::Pore { " start=\"pore\"" } else { "" };
    let mut out = format!(
        "<universe kind=\"synthetic\" outside=\"{}\" overlap=\"{overlap}\"{start}>\n    <cell period=\"{px} {py} um\" \
         bottom=\"{bottom} um\" top=\"{top} um\"/>\n",
        material(pore)
    );
    for (body, hollow) in bodies {
        let common = common(body, media, &material(body.medium), scene);
        let line = match (body.shape.shape, hollow) {
            (Shape::Cylinder(_), _) => cylinder(body, hollow.as_ref(), &material),
            (Shape::Slanted(_), _) => piece(body, hollow.as_ref(), &material),
            (Shape::Ellipsoid(e), None) if e.a == e.b && e.b == e.c => {
                Some(format!("<sphere radius=\"{} um\"{}", e.a, centre(&body.shape)))
            }
            (Shape::Ellipsoid(e), None) => Some(format!(
                "<ellipsoid half-axes=\"{} {} {} um\"{}{}",
                e.a,
                e.b,
                e.c,
                centre(&body.shape),
                axes(&body.shape)
            )),
            (Shape::SlabZ(s), None) => {
                Some(format!("<slab z-min=\"{} um\" z-max=\"{} um\"", s.z_min, s.z_max))
            }
            _ => None,
        };
        let line = line.ok_or("bodies that have no element of their own in a scene")?;
        let _ = writeln!(out, "    {line}{common}/>");
    }
    out += "  </universe>";
    Ok(out)
}

/// The `<universe>` of a labelled volume: label i stands for `labels[i]`.
pub fn voxels(
    file: &str,
    [x, y, z]: [f64; 3],
    labels: &[MediumId],
    pore: MediumId,
    media: &Media,
    scene: &Scene,
) -> String {
    let material = |m: MediumId| escaped(&material_of(m, media, scene));
    let mut out = format!(
        "<universe kind=\"voxel\" outside=\"{}\">\n    <volume file=\"{}\" voxel=\"{x} {y} {z} um\" top=\"last\" \
         lateral=\"periodic\">\n",
        material(pore),
        escaped(file)
    );
    for (value, &medium) in labels.iter().enumerate() {
        let _ = writeln!(out, "      <label value=\"{value}\" material=\"{}\"/>", material(medium));
    }
    out += "    </volume>\n  </universe>";
    out
}

fn material_of(medium: MediumId, media: &Media, scene: &Scene) -> String {
    match media.origins.get(usize::from(medium.0)) {
        Some(Origin::Material(i)) => scene.materials[*i].id.clone(),
        _ => String::new(),
    }
}

/// Text as it stands in an attribute.
pub fn escaped(text: &str) -> String {
    quick_xml::escape::escape(text).into_owned()
}

fn list(v: DVec3) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}

fn centre(shape: &Placed) -> String {
    format!(" centre=\"{} um\"", list(shape.centre))
}

fn axes(shape: &Placed) -> String {
    format!(" axis=\"{}\" major=\"{}\"", list(shape.frame.z), list(shape.frame.x))
}

/// Name, material, surface and rank.
fn common(body: &Part, media: &Media, material: &str, scene: &Scene) -> String {
    let name = media.names.get(usize::from(body.medium.0)).map(|n| escaped(n)).unwrap_or_default();
    let mut out = format!(" name=\"{name}\" material=\"{material}\"");
    if body.surface.0 > 0 {
        let _ = write!(out, " surface=\"{}\"", escaped(&scene.surfaces[usize::from(body.surface.0)].id));
    }
    if body.priority != 0 {
        let _ = write!(out, " priority=\"{}\"", body.priority);
    }
    out
}

fn cylinder(body: &Part, hollow: Option<&Part>, material: &impl Fn(MediumId) -> String) -> Option<String> {
    let Shape::Cylinder(c) = body.shape.shape else { return None };
    let mut out =
        format!("<cylinder half-axes=\"{} {} um\"{}{}", c.a, c.b, centre(&body.shape), axes(&body.shape));
    if let Some(h) = c.half_length {
        let _ = write!(out, " length=\"{} um\"", 2.0 * h);
    }
    if let Some(hollow) = hollow {
        let Shape::Cylinder(inner) = hollow.shape.shape else { return None };
        let _ = write!(out, " wall=\"{} um\" lumen=\"{}\"", c.b - inner.b, material(hollow.medium));
    }
    Some(out)
}

fn piece(body: &Part, hollow: Option<&Part>, material: &impl Fn(MediumId) -> String) -> Option<String> {
    let Shape::Slanted(s) = body.shape.shape else { return None };
    let mut out = format!(
        "<piece half-axes=\"{} {} um\" from=\"{} um\" to=\"{} um\" height=\"{} um\" slope=\"{}\"{}{}",
        s.a,
        s.b,
        s.from,
        s.to,
        s.height,
        s.slope,
        centre(&body.shape),
        axes(&body.shape)
    );
    if let Some(hollow) = hollow {
        let Shape::Slanted(inner) = hollow.shape.shape else { return None };
        let _ = write!(out, " hollow=\"{} {} um\" lumen=\"{}\"", inner.a, inner.b, material(hollow.medium));
    }
    Some(out)
}
