//! The sphere of directions in equal patches, with those of one event of the first path.

use super::Eye;
use crate::material::fresnel::reflect;
use crate::math::DVec3;
use crate::run::replay::{Trail, What};
use crate::sap::Healpix;
use crate::scene::Scene;
use crate::scene::SurfaceKind;
use std::fmt::Write;

const CENTRE: (f64, f64) = (648.0, 188.0);
const RADIUS: f64 = 84.0;
/// Finest grid that is drawn.
const FINEST: u32 = 8;

struct Event {
    /// Where the light comes from.
    from: DVec3,
    normal: Option<DVec3>,
    on: DVec3,
}

/// The first event of the traced histories that has a flight after it; an interface if there is one.
fn event(trails: &[Trail]) -> Option<Event> {
    let found = |wants_normal: bool| {
        trails.iter().flat_map(|t| t.events.windows(2)).find_map(|pair| {
            let What::Flight { .. } = pair[1].what else { return None };
            let normal = match pair[0].what {
                What::Interface { normal, .. } => Some(normal),
                What::Scattered if !wants_normal => None,
                _ => return None,
            };
            // An interface without a change of direction shows nothing.
            let turned = (pair[1].dir - pair[0].dir).length() > 0.02;
            turned.then_some(Event { from: -pair[0].dir, normal, on: pair[1].dir })
        })
    };
    found(true).or_else(|| found(false))
}

/// Patches of the run: those of the tally of directions, of a surface's SAPs, or 768.
fn nside(scene: &Scene) -> (u32, &'static str) {
    if let Some(n) = scene.detect.angular {
        return (n, "of the tally of directions");
    }
    let rough = |s: &crate::scene::Surface| match s.kind {
        SurfaceKind::Smooth => None,
        _ => s.sap.map(|sap| sap.nside),
    };
    match scene
        .surfaces
        .iter()
        .find_map(rough)
        .or_else(|| scene.materials.iter().find_map(|m| m.sap.map(|s| s.nside)))
    {
        Some(n) => (n, "of its SAPs"),
        None => (FINEST, "that such tallies have by default"),
    }
}

/// Draws the sphere; what is to be said of it.
pub fn draw(scene: &Scene, trails: &[Trail], out: &mut String) -> String {
    let (n, whose) = nside(scene);
    let (Ok(fine), Ok(grid)) = (Healpix::new(n), Healpix::new(n.min(FINEST))) else { return String::new() };
    let mut eye = Eye::new();
    eye.scale = RADIUS;
    eye.at = CENTRE;
    let outline = |hp: &Healpix, pix: usize| {
        let mut d = String::new();
        for (i, p) in hp.boundaries(pix, 4).into_iter().enumerate() {
            let (x, y) = eye.place(p);
            let _ = write!(d, "{}{x:.1} {y:.1}", ["M", "L", " "][i.min(2)]);
        }
        d + "z"
    };
    let _ = writeln!(
        out,
        "<g class=\"v-sphere\"><text x=\"{:.0}\" y=\"52\" text-anchor=\"middle\">Directions at one event</text>\
         <text x=\"{:.0}\" y=\"67\" text-anchor=\"middle\">{} patches of equal area</text>\
         <circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{RADIUS}\" fill=\"#8fa8b8\" fill-opacity=\".16\"/>",
        CENTRE.0,
        CENTRE.0,
        fine.npix(),
        CENTRE.0,
        CENTRE.1
    );
    let event = event(trails);
    let mut marks: Vec<(DVec3, &str, &str)> = Vec::new();
    if let Some(e) = &event {
        marks.push((e.from, "#d55e00", "the light comes from"));
        if let Some(normal) = e.normal {
            let mirror = reflect(-e.from, normal);
            if fine.pix_of(mirror) != fine.pix_of(e.on) {
                marks.push((mirror, "#cc79a7", "mirror direction"));
            }
        }
        marks.push((e.on, "#009e73", "it goes on into"));
    }
    let patch = |(dir, colour, _): &(DVec3, &str, &str), front: bool| {
        let pix = fine.pix_of(*dir);
        let shown = (fine.centre(pix).dot(eye.toward) >= 0.0) == front;
        let opacity = if front { ".95" } else { ".4" };
        shown.then(|| {
            format!(
                "<path fill=\"{colour}\" stroke=\"{colour}\" fill-opacity=\"{opacity}\" d=\"{}\"/>",
                outline(&fine, pix)
            )
        })
    };
    out.extend(marks.iter().filter_map(|m| patch(m, false)));
    let mut web = String::new();
    for pix in (0..grid.npix()).filter(|&p| grid.centre(p).dot(eye.toward) > 0.0) {
        web += &outline(&grid, pix);
    }
    let _ = writeln!(out, "<path class=\"v-grid\" fill=\"none\" stroke-width=\".45\" d=\"{web}\"/>");
    out.extend(marks.iter().filter_map(|m| patch(m, true)));
    for (dir, colour, _) in &marks {
        let (x, y) = eye.place(*dir);
        let back = if dir.dot(eye.toward) < 0.0 { " stroke-dasharray=\"4 3\"" } else { "" };
        let _ = writeln!(
            out,
            "<path d=\"M{:.1} {:.1}L{x:.1} {y:.1}\" stroke=\"{colour}\" stroke-width=\"1.6\" fill=\"none\"{back}/>",
            CENTRE.0, CENTRE.1
        );
    }
    if let Some(normal) = event.as_ref().and_then(|e| e.normal) {
        let (x, y) = eye.place(normal * 1.0);
        let _ = writeln!(
            out,
            "<path class=\"v-frame\" d=\"M{:.1} {:.1}L{x:.1} {y:.1}\" stroke-width=\"1.2\" stroke-dasharray=\"1.5 2.5\"/>",
            CENTRE.0, CENTRE.1
        );
    }
    let _ = writeln!(
        out,
        "<circle class=\"v-dot\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"2.2\" fill=\"#777\"/>",
        CENTRE.0, CENTRE.1
    );
    let mut y = CENTRE.1 + RADIUS + 22.0;
    for (_, colour, words) in &marks {
        let _ = writeln!(
            out,
            "<rect x=\"580\" y=\"{:.1}\" width=\"12\" height=\"10\" fill=\"{colour}\"/><text x=\"600\" y=\"{:.1}\">{words}</text>",
            y - 9.0,
            y
        );
        y += 17.0;
    }
    if event.as_ref().is_some_and(|e| e.normal.is_some()) {
        let _ = writeln!(
            out,
            "<path class=\"v-frame\" d=\"M580 {:.1}h12\" stroke-width=\"1.2\" stroke-dasharray=\"1.5 2.5\"/>\
             <text x=\"600\" y=\"{y:.1}\">surface normal</text>",
            y - 4.0
        );
    }
    out.push_str("</g>\n");
    let coarse = if n > FINEST { format!("; lines at {FINEST}") } else { String::new() };
    format!(" Sphere: HEALPix patches {whose} (nside {n}{coarse}); pale and dashed: behind.")
}
