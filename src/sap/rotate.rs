//! Turning a SAP (paper 3.3.3): frames, and the horizon of a turned SAP.
//!
//! Turned to the specular direction, part of the populated half sphere comes to lie beyond the
//! horizon of the surface. That power is folded back: the visible part is renormalised to 1.

use super::{Sap, SapDirections};
use crate::math::{DVec3, Frame, TAU, sin_cos};
use crate::rng::Stream;

/// Redraws before [`Sap::draw_visible`] gives up; with half the power visible it comes to 2⁻⁴⁰⁹⁶.
const MOST_REDRAWS: usize = 4096;

/// Frame with pole `pole` and x toward `toward`; where that has no part across the pole (by 1e-9),
/// x toward `axis`.
fn frame(pole: DVec3, toward: DVec3, axis: DVec3) -> Frame {
    let across = toward - pole * toward.dot(pole);
    let toward = if across.length_squared() > 1e-18 { toward } else { axis };
    Frame::with_x_toward(pole, toward)
}

/// Frame `rotated`: pole in the specular direction (reflected or refracted), x in the plane of
/// incidence on the side that the light comes from.
///
/// `normal` points into the half space that the light goes to: the surface normal for reflection,
/// its negative for refraction. At normal incidence x is toward `axis`, the surface's own direction.
pub fn frame_specular(specular: DVec3, normal: DVec3, axis: DVec3) -> Frame {
    frame(specular, normal, axis)
}

/// Frame `resolved`: pole the normal (against the ray), x in the plane of incidence, on the side
/// that the light comes from; `incoming` the direction in which the ray travels. At normal incidence
/// x is toward `axis`. The specular direction has x < 0.
pub fn frame_surface(normal: DVec3, incoming: DVec3, axis: DVec3) -> Frame {
    frame(normal, -incoming, axis)
}

/// Frame of a medium: pole the direction of travel; `roll` a uniform number on [0, 1) for the roll
/// about it (`random`), or None for the fixed roll of the paper, by which every pole shows the same
/// four azimuths.
pub fn frame_medium(forward: DVec3, roll: Option<f64>) -> Frame {
    let f = Frame::from_pole(forward);
    let Some(turn) = roll else { return f };
    let (s, c) = sin_cos(TAU * turn);
    Frame { x: f.x * c + f.y * s, y: f.y * c - f.x * s, z: f.z }
}

impl Sap {
    /// Visible share of a patch and its visible mean direction (local), `normal` local. For
    /// `Density` the share is that of the density, otherwise that of the area.
    fn visible_part(
        &self,
        patch: usize,
        normal: DVec3,
        how: SapDirections,
        density: &impl Fn(DVec3) -> f64,
    ) -> (f64, DVec3) {
        let height = normal.dot(self.centre(patch));
        if height > self.sin_radius(patch) {
            return (1.0, self.centre(patch));
        }
        if height < -self.sin_radius(patch) {
            return (0.0, self.centre(patch));
        }
        let by_density = how == SapDirections::Density;
        let weight = |u: DVec3| if by_density { density(u) } else { 1.0 };
        let (part, vector, whole) = self.healpix().visible_moments(patch, self.half(), normal, &weight);
        if part > 0.0 && part < whole * (1.0 - 1e-12) {
            (part / whole, vector.normalize())
        } else {
            (if part > 0.0 { 1.0 } else { 0.0 }, self.centre(patch))
        }
    }

    /// Share of the power on the side of `normal` (world) when the SAP stands in `frame`.
    pub fn visible_share(
        &self,
        frame: &Frame,
        normal: DVec3,
        how: SapDirections,
        density: impl Fn(DVec3) -> f64,
    ) -> f64 {
        let n = frame.to_local(normal);
        let share = |p| match self.ratios()[p] {
            0.0 => 0.0,
            ratio => ratio * self.visible_part(p, n, how, &density).0,
        };
        (0..self.ratios().len()).map(share).sum()
    }

    /// Draws a patch and a direction (world) on the side of `normal`: what falls beyond the horizon
    /// is drawn again, which folds its power back in proportion. `density` is local.
    ///
    /// None where 4096 draws in a row fall beyond the horizon: no power is visible.
    #[inline]
    pub fn draw_visible(
        &self,
        frame: &Frame,
        normal: DVec3,
        how: SapDirections,
        rng: &mut Stream,
        density: impl Fn(DVec3) -> f64,
    ) -> Option<(usize, DVec3)> {
        let n = frame.to_local(normal);
        for _ in 0..MOST_REDRAWS {
            let patch = self.draw(rng);
            let height = n.dot(self.centre(patch));
            if height < -self.sin_radius(patch) {
                continue;
            }
            if height > self.sin_radius(patch) {
                return Some((patch, frame.to_world(self.direction(patch, how, rng, &density))));
            }
            // Cut by the horizon: a probe decides, so that the patch counts by its visible share.
            let probe = match how {
                SapDirections::Density => self.direction(patch, how, rng, &density),
                _ => self.direction(patch, SapDirections::Uniform, rng, &density),
            };
            if probe.dot(n) <= 0.0 {
                continue;
            }
            let local = match how {
                SapDirections::Centre => self.visible_centre(patch, n, probe),
                _ => probe,
            };
            return Some((patch, frame.to_world(local)));
        }
        None
    }

    /// Mean direction of the visible part of a patch, of which `inside` is a point.
    fn visible_centre(&self, patch: usize, normal: DVec3, inside: DVec3) -> DVec3 {
        let (_, centre) = self.visible_part(patch, normal, SapDirections::Uniform, &|_| 1.0);
        // A sliver between the rows of the quadrature has no mean: its own point stands for it.
        if centre.dot(normal) > 0.0 { centre } else { inside }
    }

    /// Visits each patch that has power on the side of `normal` with its renormalised ratio (they
    /// sum to 1) and its direction (world), for the branching `split`. Directions are those of
    /// [`Sap::draw_visible`]; `density` is local.
    pub fn for_each_visible(
        &self,
        frame: &Frame,
        normal: DVec3,
        how: SapDirections,
        rng: &mut Stream,
        density: impl Fn(DVec3) -> f64,
        mut visit: impl FnMut(usize, f64, DVec3),
    ) {
        let n = frame.to_local(normal);
        let parts: Vec<(usize, f64, DVec3)> = (0..self.ratios().len())
            .filter(|&p| self.ratios()[p] > 0.0)
            .map(|p| {
                let (share, centre) = self.visible_part(p, n, how, &density);
                (p, self.ratios()[p] * share, centre)
            })
            .filter(|(_, ratio, _)| *ratio > 0.0)
            .collect();
        let sum: f64 = parts.iter().map(|p| p.1).sum();
        for (patch, ratio, centre) in parts {
            let local = match how {
                SapDirections::Centre => Some(centre),
                _ => (0..MOST_REDRAWS)
                    .map(|_| self.direction(patch, how, rng, &density))
                    .find(|u| u.dot(n) > 0.0),
            };
            // A sliver that no draw meets keeps the mean of its visible part.
            visit(patch, ratio / sum, frame.to_world(local.unwrap_or(centre)));
        }
    }
}
