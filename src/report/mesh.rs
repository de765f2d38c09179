//! Surfaces of explicit bodies as VTK PolyData (`.vtp`), for ParaView.

use crate::math::{DVec3, PI, TAU, sin_cos};
use crate::universe::shape::height::HeightMap;
use crate::universe::shape::{Ellipsoid, Placed, Shape};
use crate::universe::synthetic::Part;
use std::fmt::Write;

/// Corners around a section.
const AROUND: usize = 16;
/// Rings of an ellipsoid from pole to pole.
const RINGS: usize = 8;

/// A mesh of polygons with numbers for each.
#[derive(Debug, Default)]
struct Mesh {
    points: Vec<DVec3>,
    /// Corners of each polygon.
    faces: Vec<Vec<usize>>,
    /// Body number, medium number and whether it bounds a hollow, of each polygon.
    tags: Vec<[u32; 3]>,
}

/// The surfaces of `bodies`, each with its hollow; `µm`. Every cell carries the number of its body in the
/// list, of its medium, and 1 for hollows. Shapes without end (planes, slabs, endless cylinders) are left
/// out; their number comes with the text.
pub fn vtp(bodies: &[(Part, Option<Part>)]) -> (String, usize) {
    let (mut mesh, mut left_out) = (Mesh::default(), 0);
    for (number, (body, hollow)) in (0_u32..).zip(bodies) {
        let drawn = mesh.add(&body.shape, [number, u32::from(body.medium.0), 0]);
        left_out += usize::from(!drawn);
        if let Some(hollow) = hollow {
            mesh.add(&hollow.shape, [number, u32::from(hollow.medium.0), 1]);
        }
    }
    (mesh.write(), left_out)
}

/// Most cells of a measured surface along an edge.
const CELLS: usize = 500;

/// A period of a measured surface, µm; of large maps every so many heights. Body and hollow are 0, the medium
/// is that behind it.
pub fn surface_vtp(map: &HeightMap, medium: impl Fn(DVec3) -> u32) -> String {
    let mut mesh = Mesh::default();
    let (nodes, pixel) = map.grid();
    let every = nodes.map(|n| n.div_ceil(CELLS));
    let cells = [0, 1].map(|a| nodes[a].div_ceil(every[a]));
    // The last node is the first of the next period.
    let place = |i: usize, a: usize| (i * every[a]).min(nodes[a]) as f64 * pixel[a];
    for j in 0..=cells[1] {
        for i in 0..=cells[0] {
            let (x, y) = (place(i, 0), place(j, 1));
            mesh.points.push(DVec3::new(x, y, map.height(x, y)));
        }
    }
    let row = cells[0] + 1;
    for j in 0..cells[1] {
        for i in 0..cells[0] {
            let first = j * row + i;
            let corners = vec![first, first + 1, first + row + 1, first + row];
            let middle = corners.iter().map(|&k| mesh.points[k]).sum::<DVec3>() * 0.25;
            mesh.face(corners, [0, medium(middle), 0]);
        }
    }
    mesh.write()
}

impl Mesh {
    /// Whether the shape could be drawn.
    fn add(&mut self, placed: &Placed, tags: [u32; 3]) -> bool {
        let world = |p: DVec3| placed.centre + placed.frame.to_world(p);
        match placed.shape {
            Shape::Cylinder(c) => {
                let Some(h) = c.half_length else { return false };
                let ring = |z: f64| section(c.a, c.b).map(move |p| world(DVec3::new(p.0, p.1, z)));
                self.tube(ring(-h).collect(), ring(h).collect(), tags);
            }
            Shape::Slanted(s) => {
                let ring =
                    |z: f64| section(s.a, s.b).map(move |p| world(DVec3::new(p.0, s.centre(z) + p.1, z)));
                self.tube(ring(s.from).collect(), ring(s.to).collect(), tags);
            }
            Shape::Ellipsoid(e) => self.ellipsoid(&e, world, tags),
            Shape::Cuboid(b) => self.cuboid(b.min, b.max, world, tags),
            _ => return false,
        }
        true
    }

    /// Two rings, the band between them, and their caps.
    fn tube(&mut self, low: Vec<DVec3>, high: Vec<DVec3>, tags: [u32; 3]) {
        let (first, n) = (self.points.len(), low.len());
        self.points.extend(low);
        self.points.extend(high);
        for i in 0..n {
            let j = (i + 1) % n;
            self.face(vec![first + i, first + j, first + n + j, first + n + i], tags);
        }
        // The ends of a hollow are open.
        if tags[2] == 0 {
            self.face((first..first + n).rev().collect(), tags);
            self.face((first + n..first + 2 * n).collect(), tags);
        }
    }

    fn ellipsoid(&mut self, e: &Ellipsoid, world: impl Fn(DVec3) -> DVec3, tags: [u32; 3]) {
        let first = self.points.len();
        for ring in 0..=RINGS {
            let (s, c) = sin_cos(PI * ring as f64 / RINGS as f64);
            self.points.extend(section(e.a * s, e.b * s).map(|p| world(DVec3::new(p.0, p.1, e.c * c))));
        }
        for ring in 0..RINGS {
            let (upper, lower) = (first + ring * AROUND, first + (ring + 1) * AROUND);
            for i in 0..AROUND {
                let j = (i + 1) % AROUND;
                self.face(vec![lower + i, lower + j, upper + j, upper + i], tags);
            }
        }
    }

    fn cuboid(&mut self, min: DVec3, max: DVec3, world: impl Fn(DVec3) -> DVec3, tags: [u32; 3]) {
        let square = |z: f64| {
            [(min.x, min.y), (max.x, min.y), (max.x, max.y), (min.x, max.y)]
                .map(|(x, y)| world(DVec3::new(x, y, z)))
        };
        self.tube(square(min.z).to_vec(), square(max.z).to_vec(), tags);
    }

    fn face(&mut self, corners: Vec<usize>, tags: [u32; 3]) {
        self.faces.push(corners);
        self.tags.push(tags);
    }

    fn write(&self) -> String {
        let mut out = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\">\n<PolyData>\n\
             <Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n",
            self.points.len(),
            self.faces.len()
        );
        let points =
            self.points.iter().map(|p| format!("{:.4} {:.4} {:.4}\n", p.x, p.y, p.z)).collect::<String>();
        out += "<Points>\n";
        array(&mut out, "Float32", "points_um\" NumberOfComponents=\"3", &points);
        let mut offset = 0;
        let mut offsets = String::new();
        let mut corners = String::new();
        for face in &self.faces {
            offset += face.len();
            let _ = write!(offsets, "{offset} ");
            face.iter().for_each(|i| {
                let _ = write!(corners, "{i} ");
            });
        }
        out += "</Points>\n<Polys>\n";
        array(&mut out, "Int64", "connectivity", &corners);
        array(&mut out, "Int64", "offsets", &offsets);
        out += "</Polys>\n<CellData>\n";
        for (k, name) in ["body", "medium", "hollow"].iter().enumerate() {
            let numbers: String = self.tags.iter().map(|t| format!("{} ", t[k])).collect();
            array(&mut out, "UInt32", name, &numbers);
        }
        out += "</CellData>\n</Piece>\n</PolyData>\n</VTKFile>\n";
        out
    }
}

/// Corners of a section of half axes a and b.
fn section(a: f64, b: f64) -> impl Iterator<Item = (f64, f64)> {
    (0..AROUND).map(move |i| {
        let (s, c) = sin_cos(TAU * i as f64 / AROUND as f64);
        (a * c, b * s)
    })
}

fn array(out: &mut String, kind: &str, name: &str, numbers: &str) {
    let _ = writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">\n{}\n</DataArray>",
        numbers.trim_end()
    );
}
