//! A kind of body: its laws, and the body that a ray meets, drawn with the right weight.
//!
//! A body is met in proportion to its area projected along the ray: fibres by w(ψ) sin γ (w the
//! width of the section across the ray, γ the angle between ray and axis), ellipsoids by
//! π√(b²c²u_x² + a²c²u_y² + a²b²u_z²). The weight is imposed by exact rejection against a majorant,
//! never by a table: candidates come at rate [`Kind::majorant`] per unit density.

use super::profile::Profile;
use super::section::{Body, HalfAxes, Left};
use crate::law::{Azimuth, Roll, SizeLaw, Tilt};
use crate::math::{DVec3, Frame, PI, TAU, fast};
use crate::rng::Stream;
use crate::universe::{BodyId, MediumId, SurfaceId};

/// Shape and size laws; full widths and diameters in µm, weighted by number (fibres: by length).
#[derive(Clone, Debug)]
pub enum Sizes {
    /// Cylinder of elliptic section, unbounded or with flat ends.
    Fibre {
        /// Major axis.
        width: SizeLaw,
        /// Minor over major axis.
        flatness: SizeLaw,
        /// Wall thickness; `None`: solid.
        wall: Option<SizeLaw>,
        /// Length by number; `None`: unbounded. The ends are flat and the lumen is open there.
        length: Option<SizeLaw>,
    },
    /// Ellipsoid with three full axes.
    Ellipsoid([SizeLaw; 3]),
    /// Sphere.
    Sphere(SizeLaw),
    /// Round disc: a flake.
    Disc {
        /// Diameter.
        diameter: SizeLaw,
        /// Height.
        thickness: SizeLaw,
    },
}

/// A population of bodies.
#[derive(Clone, Debug)]
pub struct Kind {
    sizes: Sizes,
    /// The same weighted by volume: bodies that cover a given point.
    by_volume: Sizes,
    /// The size laws with the weights of a hit: width for fibres, d² for spheres, products of two
    /// axes for ellipsoids.
    met: Met,
    /// Majorant of the projected area (length for fibres) of one body, averaged over sizes, µm² (µm).
    pub majorant: f64,
    /// Relative density over depth, judged at the body's centroid; `None`: uniform.
    pub profile: Option<Profile>,
    /// Relative bonded area: share of the outer surface in optical contact with another body (rung
    /// `none`; where bodies overlap by chance the other rungs find their contacts themselves).
    pub bonded: f64,
    /// In-plane azimuth of the axis.
    pub azimuth: Azimuth,
    /// Tilt of the axis out of the plane.
    pub tilt: Tilt,
    /// Roll of the section about the axis.
    pub roll: Roll,
    /// Solid medium.
    pub wall: MediumId,
    /// Medium in the hollow.
    pub lumen: MediumId,
    /// Law of its surfaces.
    pub surface: SurfaceId,
    /// For tallies.
    pub body: BodyId,
}

#[derive(Clone, Debug)]
enum Met {
    /// `ends`: share of the majorant that belongs to the flat ends, with the law of the width there.
    Fibre {
        width: SizeLaw,
        ends: Option<Ends>,
    },
    Disc {
        diameter: SizeLaw,
        thickness: SizeLaw,
        broad: SizeLaw,
        side: f64,
    },
    Ellipsoid {
        share: [f64; 3],
        tilted: [SizeLaw; 3],
    },
    Sphere {
        diameter: SizeLaw,
    },
}

/// How the flat ends of finite fibres are met.
#[derive(Clone, Debug)]
struct Ends {
    /// Majorant of the sides over that of the whole.
    side: f64,
    /// Length of a fibre met at its side.
    long: SizeLaw,
    /// Width and flatness of a fibre met at its end.
    broad: (SizeLaw, SizeLaw),
}

/// A body met by a ray, in its own frame: the entry point and the outward normal there.
#[derive(Clone, Copy, Debug)]
pub struct Encounter {
    /// The body, placed so that the given point of the ray is the entry point.
    pub body: Body,
    /// Outward unit normal at the entry point, world coordinates.
    pub outward: DVec3,
    /// Surface that holds the entry point.
    pub surface: Left,
}

impl Kind {
    /// A kind from its laws.
    #[allow(clippy::too_many_arguments)]
    pub fn new(
        sizes: Sizes,
        azimuth: Azimuth,
        tilt: Tilt,
        roll: Roll,
        wall: MediumId,
        lumen: MediumId,
        surface: SurfaceId,
        body: BodyId,
    ) -> Self {
        let (met, majorant) = match &sizes {
            Sizes::Fibre { width, length: None, .. } => {
                (Met::Fibre { width: width.tilted(1.0), ends: None }, width.mean())
            }
            Sizes::Fibre { width, flatness, length: Some(length), .. } => {
                let ends = PI / 4.0 * width.moment(2.0) * flatness.mean() / length.mean();
                let majorant = width.mean() + ends;
                let ends = Ends {
                    side: width.mean() / majorant,
                    long: length.tilted(1.0),
                    broad: (width.tilted(2.0), flatness.tilted(1.0)),
                };
                (Met::Fibre { width: width.tilted(1.0), ends: Some(ends) }, majorant)
            }
            Sizes::Disc { diameter, thickness } => {
                let side = diameter.mean() * thickness.mean();
                let majorant = side + PI / 4.0 * diameter.moment(2.0);
                let met = Met::Disc {
                    diameter: diameter.tilted(1.0),
                    thickness: thickness.tilted(1.0),
                    broad: diameter.tilted(2.0),
                    side: side / majorant,
                };
                (met, majorant)
            }
            Sizes::Sphere(d) => (Met::Sphere { diameter: d.tilted(2.0) }, PI / 4.0 * d.moment(2.0)),
            Sizes::Ellipsoid(axes) => {
                let m = [axes[0].mean(), axes[1].mean(), axes[2].mean()];
                let pairs = [m[1] * m[2], m[2] * m[0], m[0] * m[1]];
                let total: f64 = pairs.iter().sum();
                (
                    Met::Ellipsoid {
                        share: pairs.map(|p| p / total),
                        tilted: [axes[0].tilted(1.0), axes[1].tilted(1.0), axes[2].tilted(1.0)],
                    },
                    PI / 4.0 * total,
                )
            }
        };
        Kind {
            by_volume: sizes.by_volume(),
            sizes,
            met,
            majorant,
            profile: None,
            bonded: 0.0,
            azimuth,
            tilt,
            roll,
            wall,
            lumen,
            surface,
            body,
        }
    }

    /// The laws of size.
    pub fn sizes(&self) -> &Sizes {
        &self.sizes
    }

    /// Whether bodies are unbounded fibres (amounts are lengths over volume).
    pub fn is_fibre(&self) -> bool {
        matches!(self.sizes, Sizes::Fibre { .. })
    }

    /// A random orientation: x major axis, y minor axis, z body axis.
    #[inline]
    pub fn orientation(&self, rng: &mut Stream) -> Frame {
        if let Sizes::Sphere(_) = self.sizes {
            return Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
        }
        let tilt = self.tilt.sample(rng);
        let azimuth = self.azimuth.sample_cos_sin(rng);
        let roll = self.roll.sample(rng);
        oriented(azimuth, tilt, roll, self.is_fibre())
    }

    /// One candidate for a hit by a ray along `dir` that passes the point `at`: `None` if the
    /// rejection falls on "not met" (no body there).
    #[inline]
    pub fn candidate(&self, dir: DVec3, at: DVec3, kind: u16, rng: &mut Stream) -> Option<Encounter> {
        let frame = self.orientation(rng);
        let d = frame.to_local(dir);
        let hit = match (&self.met, &self.sizes) {
            (Met::Fibre { width, ends: None }, Sizes::Fibre { flatness, wall, .. }) => {
                fibre_met(width, flatness, wall.as_ref(), d, rng)?
            }
            (Met::Fibre { width, ends: Some(ends) }, Sizes::Fibre { flatness, wall, length, .. }) => {
                if rng.uniform() < ends.side {
                    let half = 0.5 * ends.long.sample(rng);
                    fibre_met(width, flatness, wall.as_ref(), d, rng)?.along(half, rng)
                } else {
                    let half = 0.5 * length.as_ref().map_or(f64::INFINITY, |l| l.sample(rng));
                    end_met((&ends.broad.0, &ends.broad.1), wall.as_ref(), half, d, rng)?
                }
            }
            (Met::Disc { diameter, thickness, broad, side }, Sizes::Disc { thickness: plain, .. }) => {
                if rng.uniform() < *side {
                    let half = 0.5 * thickness.sample(rng);
                    fibre_met(diameter, &SizeLaw::Constant(1.0), None, d, rng)?.along(half, rng)
                } else {
                    let half = 0.5 * plain.sample(rng);
                    end_met((broad, &SizeLaw::Constant(1.0)), None, half, d, rng)?
                }
            }
            (Met::Sphere { diameter }, _) => {
                let r = 0.5 * diameter.sample(rng);
                Hit::rounded(HalfAxes::new(r, r, r), ball_entry(d, rng) * r)
            }
            (Met::Ellipsoid { share, tilted }, Sizes::Ellipsoid(axes)) => {
                ellipsoid_met(axes, tilted, share, d, rng)?
            }
            _ => unreachable!("met and sizes are made together"),
        };
        let Hit { outer, lumen, ends, local, surface } = hit;
        let outward = match surface {
            Left::Cap => frame.z * 1.0_f64.copysign(local.z),
            _ => frame.to_world(outer.normal(local)),
        };
        let centre = at - frame.to_world(local);
        Some(Encounter { body: Body { frame, centre, outer, lumen, ends, kind }, outward, surface })
    }

    /// One body by number (fibres: by length), without a place: its frame and shape about the origin.
    pub fn draw(&self, rng: &mut Stream) -> Body {
        self.body_of(&self.sizes, rng)
    }

    /// A body that covers the point `at`, drawn by volume: sizes weighted by content, orientation
    /// unweighted, the point uniform inside.
    pub fn covering(&self, at: DVec3, kind: u16, rng: &mut Stream) -> Body {
        let body = self.body_of(&self.by_volume, rng);
        let Body { frame, outer, ends, .. } = body;
        let (cos, sin) = rng.azimuth();
        let local = if outer.c.is_infinite() {
            let r = rng.uniform().sqrt();
            let z = if ends.is_finite() { ends * (2.0 * rng.uniform() - 1.0) } else { 0.0 };
            DVec3::new(outer.a * r * cos, outer.b * r * sin, z)
        } else {
            let r = crate::math::cbrt(rng.uniform());
            let z = 2.0 * rng.uniform() - 1.0;
            let s = (1.0 - z * z).sqrt();
            DVec3::new(outer.a * s * cos, outer.b * s * sin, outer.c * z) * r
        };
        Body { centre: at - frame.to_world(local), kind, ..body }
    }

    /// A body of these sizes about the origin.
    fn body_of(&self, sizes: &Sizes, rng: &mut Stream) -> Body {
        let frame = self.orientation(rng);
        let (outer, lumen, ends) = sizes.sample(rng);
        Body { frame, centre: DVec3::ZERO, outer, lumen, ends, kind: 0 }
    }
}

impl Sizes {
    /// The same laws weighted by the volume of the body.
    fn by_volume(&self) -> Sizes {
        match self {
            Sizes::Fibre { width, flatness, wall, length } => Sizes::Fibre {
                width: width.tilted(2.0),
                flatness: flatness.tilted(1.0),
                wall: wall.clone(),
                length: length.as_ref().map(|l| l.tilted(1.0)),
            },
            Sizes::Sphere(d) => Sizes::Sphere(d.tilted(3.0)),
            Sizes::Ellipsoid(axes) => Sizes::Ellipsoid([0, 1, 2].map(|i| axes[i].tilted(1.0))),
            Sizes::Disc { diameter, thickness } => {
                Sizes::Disc { diameter: diameter.tilted(2.0), thickness: thickness.tilted(1.0) }
            }
        }
    }

    /// Half axes, those of the lumen, and the half length between flat ends.
    fn sample(&self, rng: &mut Stream) -> (HalfAxes, Option<HalfAxes>, f64) {
        match self {
            Sizes::Fibre { width, flatness, wall, length } => {
                let a = 0.5 * width.sample(rng);
                let b = a * flatness.sample(rng);
                let lumen = wall.as_ref().and_then(|w| lumen_of(a, b, w.sample(rng)));
                let ends = length.as_ref().map_or(f64::INFINITY, |l| 0.5 * l.sample(rng));
                (HalfAxes::fibre(a, b), lumen, ends)
            }
            Sizes::Sphere(d) => {
                let r = 0.5 * d.sample(rng);
                (HalfAxes::new(r, r, r), None, f64::INFINITY)
            }
            Sizes::Ellipsoid(axes) => {
                let h = [0, 1, 2].map(|i| 0.5 * axes[i].sample(rng));
                (HalfAxes::new(h[0], h[1], h[2]), None, f64::INFINITY)
            }
            Sizes::Disc { diameter, thickness } => {
                let r = 0.5 * diameter.sample(rng);
                (HalfAxes::fibre(r, r), None, 0.5 * thickness.sample(rng))
            }
        }
    }
}

/// Sine and cosine of an angle in [−2π, 2π], for the inner loop.
#[inline]
fn turned(angle: f64) -> (f64, f64) {
    let (cos, sin) = fast::cos_sin_turn(angle * (1.0 / TAU));
    (sin, cos)
}

/// Frame of a body with in-plane azimuth (cosine, sine), tilt and roll. For fibres z is the axis and roll 0
/// lays the major axis into the sheet plane; for flakes roll 0 lays the third axis along the sheet
/// normal, `tilt` tips it.
#[inline]
pub fn oriented((cos_p, sin_p): (f64, f64), tilt: f64, roll: f64, fibre: bool) -> Frame {
    let (sin_t, cos_t) = if tilt == 0.0 { (0.0, 1.0) } else { turned(tilt) };
    let axis = DVec3::new(cos_p * cos_t, sin_p * cos_t, sin_t);
    let side = DVec3::new(-sin_p, cos_p, 0.0);
    let up = axis.cross(side);
    let (sin_r, cos_r) = if roll == 0.0 { (0.0, 1.0) } else { turned(roll) };
    let x = side * cos_r + up * sin_r;
    if fibre { Frame { x, y: axis.cross(x), z: axis } } else { Frame { x: axis, y: x, z: axis.cross(x) } }
}

/// Lumen of a section with half axes a, b and wall thickness t: half axes a − t, b − t; none where the
/// fibre is fully collapsed.
#[inline]
pub fn lumen_of(a: f64, b: f64, t: f64) -> Option<HalfAxes> {
    (t < a && t < b).then(|| HalfAxes::fibre(a - t, b - t))
}

/// A body met: outer and lumen half axes, half length, entry point in its own frame and its surface.
struct Hit {
    outer: HalfAxes,
    lumen: Option<HalfAxes>,
    ends: f64,
    local: DVec3,
    surface: Left,
}

impl Hit {
    /// Without ends.
    #[inline]
    fn rounded(outer: HalfAxes, local: DVec3) -> Self {
        Hit { outer, lumen: None, ends: f64::INFINITY, local, surface: Left::Outer }
    }

    /// The same fibre with flat ends: the entry point is anywhere along it.
    #[inline]
    fn along(self, half: f64, rng: &mut Stream) -> Self {
        let z = half * (2.0 * rng.uniform() - 1.0);
        Hit { ends: half, local: DVec3 { z, ..self.local }, ..self }
    }
}

/// A fibre or disc that a ray along `d` (local) meets at the flat end that faces it: met in proportion
/// to |cos γ|, the point uniform over the end.
#[inline]
fn end_met(
    broad: (&SizeLaw, &SizeLaw),
    wall: Option<&SizeLaw>,
    half: f64,
    d: DVec3,
    rng: &mut Stream,
) -> Option<Hit> {
    if rng.uniform() >= d.z.abs() {
        return None;
    }
    let a = 0.5 * broad.0.sample(rng);
    let b = a * broad.1.sample(rng);
    let lumen = wall.and_then(|w| lumen_of(a, b, w.sample(rng)));
    let r = rng.uniform().sqrt();
    let (cos, sin) = rng.azimuth();
    let local = DVec3::new(a * r * cos, b * r * sin, -half.copysign(d.z));
    Some(Hit { outer: HalfAxes::fibre(a, b), lumen, ends: half, local, surface: Left::Cap })
}

/// A fibre that a ray along `d` (local) meets.
///
/// The offset of the axis from the ray is uniform over the majorant width 2a: what falls beyond the
/// true half width w(ψ)/2, or is lost to sin γ, is no hit. Neither depends on the size itself, which
/// is drawn only for a hit.
#[inline]
fn fibre_met(
    width: &SizeLaw,
    flatness: &SizeLaw,
    wall: Option<&SizeLaw>,
    d: DVec3,
    rng: &mut Stream,
) -> Option<Hit> {
    let sin = (d.x * d.x + d.y * d.y).sqrt();
    if rng.uniform() >= sin {
        return None;
    }
    let (ex, ey) = (d.x / sin, d.y / sin);
    let flat = flatness.sample(rng);
    let half_width = (ey * ey + flat * flat * ex * ex).sqrt();
    let offset = 2.0 * rng.uniform() - 1.0;
    if offset.abs() >= half_width {
        return None;
    }
    let a = 0.5 * width.sample(rng);
    let b = a * flat;
    let lumen = wall.and_then(|w| lumen_of(a, b, w.sample(rng)));
    let local = section_entry(a, b, ex, ey, offset / half_width);
    Some(Hit { lumen, ..Hit::rounded(HalfAxes::fibre(a, b), local) })
}

/// An ellipsoid that a ray along `d` (local) meets; `plain` of its axes, drawn with probability
/// `share`, keeps its law while the two others are weighted by size.
fn ellipsoid_met(
    axes: &[SizeLaw; 3],
    tilted: &[SizeLaw; 3],
    share: &[f64; 3],
    d: DVec3,
    rng: &mut Stream,
) -> Option<Hit> {
    let pick = rng.uniform();
    let plain = if pick < share[0] {
        0
    } else if pick < share[0] + share[1] {
        1
    } else {
        2
    };
    let mut h = [0.0; 3];
    for (i, v) in h.iter_mut().enumerate() {
        *v = 0.5 * if i == plain { axes[i].sample(rng) } else { tilted[i].sample(rng) };
    }
    let [a, b, c] = h;
    let products = DVec3::new(b * c, c * a, a * b);
    let area = (products * d).length();
    if rng.uniform() * (products.x + products.y + products.z) >= area {
        return None;
    }
    // The ball's disc maps affinely to the ellipsoid's shadow: uniform stays uniform.
    let scaled = DVec3::new(d.x / a, d.y / b, d.z / c).normalize();
    let e = ball_entry(scaled, rng);
    Some(Hit::rounded(HalfAxes::new(a, b, c), DVec3::new(a * e.x, b * e.y, c * e.z)))
}

/// Entry point of a line along (ex, ey) into the ellipse, at `offset` in (−1, 1) of its half shadow.
#[inline]
fn section_entry(a: f64, b: f64, ex: f64, ey: f64, offset: f64) -> DVec3 {
    // In the space where the ellipse is the unit circle the line runs along q at the same relative
    // offset.
    let (qx, qy) = (ex / a, ey / b);
    let l = (qx * qx + qy * qy).sqrt();
    let (qx, qy) = (qx / l, qy / l);
    let back = (1.0 - offset * offset).sqrt();
    DVec3::new(a * (-qy * offset - qx * back), b * (qx * offset - qy * back), 0.0)
}

/// Entry point on the unit ball of a line along `d` (unit), uniform over the ball's shadow.
#[inline]
fn ball_entry(d: DVec3, rng: &mut Stream) -> DVec3 {
    let u = rng.uniform();
    let (cos, sin) = rng.azimuth();
    let r = u.sqrt();
    let (x, y) = crate::math::orthonormal(d);
    x * (r * cos) + y * (r * sin) - d * (1.0 - u).sqrt()
}
