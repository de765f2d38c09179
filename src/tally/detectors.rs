//! Detectors of light that leaves the sheet: apertures (gloss, haze), lateral spread, halftone, path
//! length and time of flight. Each is a set of cells after those of [`super::Layout`].

use super::klems;
use crate::math::{DVec3, FRAC_PI_2, Frame, PI, acos, asin, bessel_j0, cos, sin, tan};
use crate::universe::Face;

/// The detectors of a run; the default has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Detectors {
    /// Apertures.
    pub apertures: Vec<Aperture>,
    /// Lateral spread of light about the place where it entered.
    pub lateral: Option<Lateral>,
    /// Halftone screens of ink upon the sheet.
    pub halftones: Vec<Halftone>,
    /// Histograms of path length and time of flight.
    pub flight: Option<Flight>,
    /// Directions towards eyes at infinity, for next-event estimation.
    pub views: Vec<DVec3>,
    /// Scattering matrix in the Klems basis, incident × outgoing (above, then below).
    pub klems: bool,
    /// Heights of the upper and lower face, µm: where light counts as having left.
    pub faces: (f64, f64),
}

/// Which figure an aperture measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measures {
    /// Specular gloss: power inside the receiver's window about the mirror direction.
    Gloss,
    /// Haze: transmitted power that is turned by more than the half angle.
    Haze,
}

/// An opening through which light that leaves is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aperture {
    /// What it is for.
    pub measures: Measures,
    /// Side of the sheet.
    pub face: Face,
    /// Frame whose z is the middle of the opening and whose x lies in the plane of incidence.
    pub frame: Frame,
    /// The opening.
    pub window: Window,
}

/// Shape of an opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Window {
    /// Inside a cone: cosine of its half angle.
    Inside(f64),
    /// Outside a cone.
    Outside(f64),
    /// A rectangle: tangents of its half angles in and across the plane of incidence.
    Rectangle(f64, f64),
}

impl Aperture {
    /// The window of a glossmeter about the mirror direction of parallel light that travels along
    /// `light`; full opening angles (rad) in and across the plane of incidence, `None`: a circle.
    pub fn gloss(light: DVec3, opening: f64, across: Option<f64>) -> Self {
        let window = match across {
            None => Window::Inside(cos(0.5 * opening)),
            Some(across) => Window::Rectangle(tan(0.5 * opening), tan(0.5 * across)),
        };
        let mirror = DVec3::new(light.x, light.y, -light.z);
        // x in the plane of incidence, y across it.
        let across = DVec3::Z.cross(mirror).try_normalize().unwrap_or(DVec3::Y);
        let frame = Frame { x: across.cross(mirror), y: across, z: mirror };
        Aperture { measures: Measures::Gloss, face: Face::Top, frame, window }
    }

    /// Transmitted light that parallel light along `light` is turned into by more than `angle` (rad;
    /// ASTM D1003: 2.5°).
    pub fn haze(light: DVec3, angle: f64) -> Self {
        Aperture {
            measures: Measures::Haze,
            face: Face::Bottom,
            frame: Frame::from_pole(light),
            window: Window::Outside(cos(angle)),
        }
    }

    /// Whether light that leaves by `face` along `dir` passes.
    #[inline]
    pub fn passes(&self, face: Face, dir: DVec3) -> bool {
        if face != self.face {
            return false;
        }
        let along = dir.dot(self.frame.z);
        match self.window {
            Window::Inside(cos) => along >= cos,
            Window::Outside(cos) => along < cos,
            Window::Rectangle(in_plane, across) => {
                along > 0.0
                    && dir.dot(self.frame.x).abs() <= in_plane * along
                    && dir.dot(self.frame.y).abs() <= across * along
            }
        }
    }
}

/// Lateral spread: point spread function in rings, edge response and modulation transfer function, for
/// each face. Meant for light that enters at x = y = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Lateral {
    /// Radius of the outermost ring, µm.
    pub radius: f64,
    /// Number of rings of equal width.
    pub rings: u32,
    /// Spatial frequencies of the modulation transfer function, 1/µm.
    pub frequencies: Vec<f64>,
}

impl Lateral {
    /// Rings over `radius` µm; frequencies in even steps up to that where a period takes four rings.
    pub fn new(radius: f64, rings: u32) -> Self {
        let steps = 40;
        let highest = f64::from(rings) / (4.0 * radius);
        let frequencies = (1..=steps).map(|i| highest * f64::from(i) / f64::from(steps)).collect();
        Lateral { radius, rings, frequencies }
    }

    /// Distances from the edge at which the edge response is scored, µm: −radius … radius.
    pub fn edge_places(&self) -> Vec<f64> {
        (-20..=20).map(|i| self.radius * f64::from(i) / 20.0).collect()
    }

    /// Cells of one face: rings and beyond, frequencies, edge places.
    fn cells(&self) -> usize {
        self.rings as usize + 1 + self.frequencies.len() + 41
    }

    /// Ring of the distance `r`; the last one holds all beyond.
    fn ring(&self, r: f64) -> usize {
        ((r / self.radius * f64::from(self.rings)) as usize).min(self.rings as usize)
    }
}

/// A line screen of ink: an ink film without scattering upon the sheet, its lines across x, that light
/// passes where it enters and where it leaves. Its place is random: scores are the mean over all places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Halftone {
    /// Share of the area under ink.
    pub coverage: f64,
    /// Period of the lines, µm.
    pub period: f64,
    /// Transmittance of the ink film for one passage.
    pub ink: f64,
}

impl Halftone {
    /// Mean over places of t(u) t(u + x), t the transmittance of the film where light enters and leaves
    /// x apart: (1 − c a)² − … = 1 − 2 c a + c² A(x), c = 1 − ink, A the share of places with ink at both
    /// ends, a triangle of period p between max(0, 2a − 1) and a.
    pub fn passed(&self, x: f64) -> f64 {
        let (a, c) = (self.coverage, 1.0 - self.ink);
        let lag = (x / self.period).abs();
        let lag = lag - lag.floor();
        let lag = lag.min(1.0 - lag);
        let both = (a - lag).max(0.0).max(2.0 * a - 1.0);
        1.0 - 2.0 * c * a + c * c * both
    }
}

/// Histograms of path length (µm) and time of flight (µm of vacuum) of the light that leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    /// Path length at the end of the last bin, µm.
    pub longest: f64,
    /// Bins; one more holds all beyond.
    pub bins: u32,
    /// Group index n − λ dn/dλ of each medium, for the time of flight.
    pub group_index: Vec<f64>,
}

impl Flight {
    /// Delay at the end of the last bin, µm of vacuum: the longest path in the slowest medium.
    pub fn latest(&self) -> f64 {
        self.longest * self.group_index.iter().fold(1.0_f64, |m, n| m.max(*n))
    }

    /// Cells of one face: path histogram, time histogram, Σ power × path, Σ power × delay.
    fn cells(&self) -> usize {
        2 * (self.bins as usize + 1) + 2
    }

    fn bin(&self, x: f64, end: f64) -> usize {
        ((x / end * f64::from(self.bins)) as usize).min(self.bins as usize)
    }
}

fn side(face: Face) -> usize {
    usize::from(face == Face::Bottom)
}

impl Detectors {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.cells() == 0
    }

    /// Way from `place` along `dir` to the plane of `face`, µm; 0 there and beyond. Rays that fly off
    /// into an unbounded scene stand where they met something last.
    pub fn way_out(&self, face: Face, place: DVec3, dir: DVec3) -> f64 {
        let plane = if face == Face::Top { self.faces.0 } else { self.faces.1 };
        let way = (plane - place.z) / dir.z;
        if way.is_finite() { way.max(0.0) } else { 0.0 }
    }

    /// First cell of the lateral spread at `face`.
    pub fn lateral_start(&self, face: Face) -> usize {
        self.apertures.len() + side(face) * self.lateral.as_ref().map_or(0, Lateral::cells)
    }

    /// First cell of the modulation transfer function at `face`.
    pub fn mtf_start(&self, face: Face) -> usize {
        self.lateral_start(face) + self.lateral.as_ref().map_or(0, |l| l.rings as usize + 1)
    }

    /// First cell of the edge response at `face`.
    pub fn edge_start(&self, face: Face) -> usize {
        self.mtf_start(face) + self.lateral.as_ref().map_or(0, |l| l.frequencies.len())
    }

    /// First cell of the halftones.
    pub fn halftone_start(&self) -> usize {
        self.apertures.len() + 2 * self.lateral.as_ref().map_or(0, Lateral::cells)
    }

    /// First cell of the path histogram at `face`; that of times follows, then Σ power × path (µm) and
    /// Σ power × delay (µm of vacuum).
    pub fn flight_start(&self, face: Face) -> usize {
        self.halftone_start()
            + self.halftones.len()
            + side(face) * self.flight.as_ref().map_or(0, Flight::cells)
    }

    /// First cell of the views.
    pub fn views_start(&self) -> usize {
        self.halftone_start() + self.halftones.len() + 2 * self.flight.as_ref().map_or(0, Flight::cells)
    }

    /// First cell of the Klems matrix.
    pub fn klems_start(&self) -> usize {
        self.views_start() + self.views.len()
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.klems_start() + if self.klems { 2 * klems::PATCHES * klems::PATCHES } else { 0 }
    }

    /// What light that entered along `from` and leaves by `face` at `place` along `dir`, after `travelled`
    /// µm and `delay` µm of vacuum, adds to cells: (cell, factor on its power).
    pub fn hear(
        &self,
        face: Face,
        place: DVec3,
        (from, dir): (DVec3, DVec3),
        (travelled, delay): (f64, f64),
        mut score: impl FnMut(usize, f64),
    ) {
        if self.klems {
            let row = klems::patch(-from) * 2 * klems::PATCHES;
            score(self.klems_start() + row + side(face) * klems::PATCHES + klems::patch(dir), 1.0);
        }
        for (i, aperture) in self.apertures.iter().enumerate() {
            if aperture.passes(face, dir) {
                score(i, 1.0);
            }
        }
        if let Some(lateral) = &self.lateral {
            self.spread(lateral, face, place, &mut score);
        }
        if face == Face::Top {
            for (i, halftone) in self.halftones.iter().enumerate() {
                score(self.halftone_start() + i, halftone.passed(place.x));
            }
        }
        if let Some(flight) = &self.flight {
            let start = self.flight_start(face);
            let bins = flight.bins as usize + 1;
            score(start + flight.bin(travelled, flight.longest), 1.0);
            score(start + bins + flight.bin(delay, flight.latest()), 1.0);
            score(start + 2 * bins, travelled);
            score(start + 2 * bins + 1, delay);
        }
    }

    /// A place at distance r: its ring; J0(2π f r), the mean of cos(2π f x) over azimuths; and the share
    /// of azimuths for which it lies before the edge, 1 − acos(x/r)/π.
    fn spread(&self, lateral: &Lateral, face: Face, place: DVec3, score: &mut impl FnMut(usize, f64)) {
        let r = (place.x * place.x + place.y * place.y).sqrt();
        score(self.lateral_start(face) + lateral.ring(r), 1.0);
        for (i, f) in lateral.frequencies.iter().enumerate() {
            score(self.mtf_start(face) + i, bessel_j0(2.0 * PI * f * r));
        }
        for (i, x) in lateral.edge_places().into_iter().enumerate() {
            let share = if x >= r {
                1.0
            } else if x <= -r {
                0.0
            } else {
                1.0 - acos(x / r) / PI
            };
            if share > 0.0 {
                score(self.edge_start(face) + i, share);
            }
        }
    }
}

/// Share of Lambertian light inside a cone of half angle `half` about a direction at `polar` (rad) from
/// the normal, wholly above the horizon: sin² half · cos polar.
pub fn lambertian_in_cone(polar: f64, half: f64) -> f64 {
    debug_assert!(polar + half <= FRAC_PI_2 + 1e-12);
    let s = sin(half);
    s * s * cos(polar)
}

/// Reflectance of the black glass that reads 100 at `polar` rad, unpolarised (Fresnel): index 1.540 at 20° and
/// 75° (TAPPI T653, T480), 1.567 at 60° (ISO 2813). 0.2601 at 75°, 0.1001 at 60°.
pub fn black_glass(polar: f64) -> f64 {
    let sixty = (polar * 180.0 / PI).round() == 60.0;
    let index = if sixty { 1.567 } else { 1.540 };
    let (ci, ct) = (cos(polar), cos(asin(sin(polar) / index)));
    let rs = (ci - index * ct) / (ci + index * ct);
    let rp = (index * ci - ct) / (index * ci + ct);
    0.5 * (rs * rs + rp * rp)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::gauss_legendre;

    /// TAPPI T480: a perfect mirror reads 384.4.
    #[test]
    fn a_mirror_has_384_gloss_units_at_75_degrees() {
        assert!((100.0 / black_glass(75.0_f64.to_radians()) - 384.4).abs() < 0.05);
        assert!((black_glass(0.0) - (0.54_f64 / 2.54).powi(2)).abs() < 1e-15);
        // ISO 2813: glass of 1.567.
        assert!((black_glass(60.0_f64.to_radians()) - 0.100_056).abs() < 1e-6);
    }

    #[test]
    fn windows_stand_about_the_mirror_direction() {
        let at = |polar: f64, azimuth: f64| {
            let (p, a) = (polar.to_radians(), azimuth.to_radians());
            DVec3::new(sin(p) * cos(a), sin(p) * sin(a), cos(p))
        };
        let light = -at(60.0, 180.0);
        let round = Aperture::gloss(light, 5f64.to_radians(), None);
        let flat = Aperture::gloss(light, 4.4f64.to_radians(), Some(11.7f64.to_radians()));
        for (polar, azimuth, in_round, in_flat) in [
            (60.0, 0.0, true, true),
            (62.4, 0.0, true, false),
            (62.1, 0.0, true, true),
            (62.6, 0.0, false, false),
            (60.0, 4.0, false, true),
            (60.0, 7.5, false, false),
            (60.0, 180.0, false, false),
        ] {
            assert_eq!(round.passes(Face::Top, at(polar, azimuth)), in_round, "{polar} {azimuth}");
            assert_eq!(flat.passes(Face::Top, at(polar, azimuth)), in_flat, "{polar} {azimuth}");
        }
        assert!(!round.passes(Face::Bottom, at(60.0, 0.0)));
        let haze = Aperture::haze(-DVec3::Z, 2.5f64.to_radians());
        assert!(!haze.passes(Face::Bottom, -at(2.4, 30.0)) && haze.passes(Face::Bottom, -at(2.6, 30.0)));
    }

    /// The closed form against the mean over places.
    #[test]
    fn a_screen_passes_what_the_mean_over_its_places_passes() {
        let n = 20_000;
        for (coverage, ink) in [(0.3, 0.1), (0.5, 0.0), (0.8, 0.4), (0.0, 0.2), (1.0, 0.2)] {
            let h = Halftone { coverage, period: 150.0, ink };
            let t = |u: f64| if (u / h.period).rem_euclid(1.0) < coverage { ink } else { 1.0 };
            for x in [0.0, 10.0, -40.0, 75.0, 140.0, 1000.0] {
                let mean = (0..n)
                    .map(|i| (f64::from(i) + 0.5) / f64::from(n) * h.period)
                    .map(|u| t(u) * t(u + x))
                    .sum::<f64>()
                    / f64::from(n);
                assert!((h.passed(x) - mean).abs() < 2e-4, "{h:?} {x}: {} {mean}", h.passed(x));
            }
        }
    }

    #[test]
    fn lambertian_light_in_a_tilted_cone() {
        // ∫ over the cone of cosθ/π, the cone's axis at 8°.
        let (polar, half) = (8f64.to_radians(), 5f64.to_radians());
        let sum: f64 = gauss_legendre(24, 0.0, half)
            .iter()
            .map(|(t, w)| w * sin(*t) * 2.0 * PI * cos(*t) * cos(polar) / PI)
            .sum();
        assert!((sum - lambertian_in_cone(polar, half)).abs() < 1e-14);
    }

    #[test]
    fn cells_do_not_overlap_and_fill_the_range() {
        let d = Detectors {
            apertures: vec![Aperture::haze(-DVec3::Z, 0.04)],
            lateral: Some(Lateral::new(200.0, 10)),
            halftones: vec![Halftone { coverage: 0.5, period: 150.0, ink: 0.1 }; 2],
            flight: Some(Flight { longest: 500.0, bins: 20, group_index: vec![1.0, 1.6] }),
            views: Vec::new(),
            klems: false,
            faces: (0.0, 0.0),
        };
        let mut seen = vec![0; d.cells()];
        for face in [Face::Top, Face::Bottom] {
            for i in 0..4000 {
                let place = DVec3::new(0.1 * f64::from(i), 0.0, 0.0);
                let flown = (0.3 * f64::from(i), 0.4 * f64::from(i));
                d.hear(face, place, (-DVec3::Z, DVec3::new(0.6, 0.0, -0.8)), flown, |cell, _| {
                    seen[cell] += 1
                });
            }
        }
        assert!(seen.iter().all(|n| *n > 0), "{seen:?}");
        assert_eq!(d.flight_start(Face::Bottom) + 2 * 21 + 2, d.cells());
    }
}
