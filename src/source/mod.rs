//! Light sources: where a history starts and in which direction.

use crate::math::{DVec3, Frame, TAU, cos, sin_cos};
use crate::rng::Stream;
use crate::universe::Ray;

/// A source of unit power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// Parallel light on the upper face: from polar angle `polar` and azimuth `azimuth` (of where it
    /// comes from), entering on a disc of `radius` µm about `centre`.
    Collimated {
        /// Direction of travel, unit.
        dir: DVec3,
        /// Middle of the entry disc, on the upper face, µm.
        centre: DVec3,
        /// µm; 0 is a pencil.
        radius: f64,
    },
    /// Lambertian light on the upper face: radiance equal in all directions outside a dark cone about
    /// the normal (the gloss trap of a d/0 instrument).
    Diffuse {
        /// Point of entry, µm.
        centre: DVec3,
        /// cos² of the dark cone's half angle (1: no cone).
        cos2_trap: f64,
    },
    /// A point that emits evenly into a cone.
    Point {
        /// µm.
        position: DVec3,
        /// Frame whose z is the cone's axis.
        frame: Frame,
        /// 1 − cos of the half angle; 0 is a pencil, 2 emits all around.
        opening: f64,
    },
}

impl Source {
    /// Parallel light from the angles (rad) of where it comes from.
    pub fn collimated(polar: f64, azimuth: f64, centre: DVec3, radius: f64) -> Self {
        let (s, c) = sin_cos(polar);
        let (sa, ca) = sin_cos(azimuth);
        Source::Collimated { dir: -DVec3::new(s * ca, s * sa, c), centre, radius }
    }

    /// Diffuse light with a dark cone of half angle `trap` (rad).
    pub fn diffuse(centre: DVec3, trap: f64) -> Self {
        let c = cos(trap);
        Source::Diffuse { centre, cos2_trap: if trap > 0.0 { c * c } else { 1.0 } }
    }

    /// A point source at `position` that aims at `target` with a cone of `half_angle` (rad).
    pub fn point(position: DVec3, target: DVec3, half_angle: f64) -> Self {
        let half = 0.5 * half_angle;
        let s = crate::math::sin(half);
        Source::Point {
            position,
            frame: Frame::from_pole((target - position).normalize()),
            opening: 2.0 * s * s,
        }
    }

    /// The start of a history.
    #[inline]
    pub fn emit(&self, rng: &mut Stream) -> Ray {
        match *self {
            Source::Collimated { dir, centre, radius } => {
                if radius == 0.0 {
                    return Ray { origin: centre, dir };
                }
                let r = radius * rng.uniform().sqrt();
                let (c, s) = rng.azimuth();
                Ray { origin: centre + DVec3::new(r * c, r * s, 0.0), dir }
            }
            Source::Diffuse { centre, cos2_trap } => {
                let cos2 = cos2_trap * rng.uniform_positive();
                let (c, s) = rng.azimuth();
                let sin = (1.0 - cos2).sqrt();
                Ray { origin: centre, dir: DVec3::new(sin * c, sin * s, -cos2.sqrt()) }
            }
            Source::Point { position, frame, opening } => {
                if opening == 0.0 {
                    return Ray { origin: position, dir: frame.z };
                }
                let away = opening * rng.uniform();
                let sin = (away * (2.0 - away)).max(0.0).sqrt();
                let (c, s) = rng.azimuth();
                let dir = frame.to_world(DVec3::new(sin * c, sin * s, 1.0 - away));
                Ray { origin: position, dir: crate::math::frame::renormalise(dir) }
            }
        }
    }

    /// Solid angle that a point source fills, sr (others: 2π).
    pub fn solid_angle(&self) -> f64 {
        match self {
            Source::Point { opening, .. } => TAU * opening,
            _ => TAU,
        }
    }
}
