//! HEALPix: the sphere in 12·nside² patches of equal area on rings of equal latitude
//! (Górski et al., ApJ 622, 759 (2005), doi:10.1086/427976), RING numbering, **any** nside ≥ 1.
//!
//! Twelve faces carry coordinates (x, y) ∈ \[0, nside\]²; the patch (ix, iy) of a face is the unit
//! square at that corner, and the map from face to sphere keeps area. With w = jr·nside − x − y the
//! latitude coordinate (w = ring number at a centre; 0 at the north, 4·nside at the south pole) and
//! n = min(w, nside, 4·nside − w):
//!
//! - caps (w ≤ nside, w ≥ 3·nside): |z| = 1 − n²/(3·nside²)
//! - belt: z = 2(2·nside − w)/(3·nside)
//! - azimuth: φ = (π/4)(jp + (x − y)/n)
//!
//! jr and jp are the face's ring and azimuth offsets.

use super::SapError;
use crate::math::fast::cos_sin_turn;
use crate::math::{DVec3, FRAC_PI_2, PI, atan2};

/// Ring offset of the twelve faces, in units of nside.
const FACE_RING: [i64; 12] = [2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4];
/// Azimuth offset of the twelve faces, in eighths of a turn.
const FACE_AZIMUTH: [i64; 12] = [1, 3, 5, 7, 0, 2, 4, 6, 1, 3, 5, 7];

/// One half of the sphere about a frame's pole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// z > 0.
    Upper,
    /// z < 0.
    Lower,
}

/// One ring of patches of equal latitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// First patch of the ring.
    pub start: usize,
    /// Number of patches.
    pub count: usize,
    /// Height of the centres, cos of the polar angle.
    pub z: f64,
    /// True where the first centre stands half a patch away from φ = 0.
    pub shifted: bool,
}

/// The tessellation with granularity nside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Healpix {
    nside: i64,
}

/// A patch by face and integer face coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FacePatch {
    /// Face, 0–3 north, 4–7 equator, 8–11 south.
    pub face: usize,
    /// Towards north-east.
    pub ix: i64,
    /// Towards north-west.
    pub iy: i64,
}

impl Healpix {
    /// Largest granularity accepted (8·10⁸ patches).
    pub const MAX_NSIDE: u32 = 8192;

    /// Tessellation with 12·nside² patches; nside from 1 to [`Healpix::MAX_NSIDE`], not only powers
    /// of two.
    pub fn new(nside: u32) -> Result<Self, SapError> {
        if (1..=Self::MAX_NSIDE).contains(&nside) {
            Ok(Healpix { nside: i64::from(nside) })
        } else {
            Err(SapError::Granularity(nside))
        }
    }

    /// Granularity.
    pub fn nside(&self) -> u32 {
        self.nside as u32
    }

    /// Number of patches, 12·nside².
    pub fn npix(&self) -> usize {
        (12 * self.nside * self.nside) as usize
    }

    /// Solid angle of each patch, 4π/npix (sr).
    pub fn area(&self) -> f64 {
        4.0 * PI / self.npix() as f64
    }

    /// Number of rings, 4·nside − 1, numbered from 1 in the north.
    pub fn rings(&self) -> usize {
        (4 * self.nside - 1) as usize
    }

    /// Patches north of the belt's first ring.
    fn cap(&self) -> i64 {
        2 * self.nside * (self.nside - 1)
    }

    /// Ring number `ring` (1 … 4·nside − 1, from the north).
    pub fn ring(&self, ring: usize) -> Ring {
        let (n, r) = (self.nside, ring as i64);
        let (start, count, shifted) = if r < n {
            (2 * r * (r - 1), 4 * r, true)
        } else if r <= 3 * n {
            (self.cap() + (r - n) * 4 * n, 4 * n, (r - n) & 1 == 0)
        } else {
            let s = 4 * n - r;
            (12 * n * n - 2 * s * (s + 1), 4 * s, true)
        };
        Ring { start: start as usize, count: count as usize, z: self.z_at(r as f64), shifted }
    }

    /// Ring number of a patch.
    pub fn ring_of(&self, pix: usize) -> usize {
        let (n, p, npix) = (self.nside, pix as i64, self.npix() as i64);
        let ring = if p < self.cap() {
            (1 + (1 + 2 * p).isqrt()) >> 1
        } else if p < npix - self.cap() {
            (p - self.cap()) / (4 * n) + n
        } else {
            4 * n - ((1 + (2 * (npix - p) - 1).isqrt()) >> 1)
        };
        ring as usize
    }

    /// Height at latitude coordinate w ∈ [0, 4·nside].
    pub(crate) fn z_at(&self, w: f64) -> f64 {
        let n = self.nside as f64;
        if w < n {
            1.0 - w * w / (3.0 * n * n)
        } else if w <= 3.0 * n {
            (2.0 * n - w) * (2.0 / 3.0) / n
        } else {
            let s = 4.0 * n - w;
            s * s / (3.0 * n * n) - 1.0
        }
    }

    /// Patch that holds the direction `dir` (unit).
    ///
    /// On a common border either neighbour may answer; within 1e-15 of a border rounding decides.
    pub fn pix_of(&self, dir: DVec3) -> usize {
        let (n, nf) = (self.nside, self.nside as f64);
        // Quarters of a turn in [0, 4); −1e-20 + 4 rounds to 4, the border itself.
        let mut turn = atan2(dir.y, dir.x) / FRAC_PI_2;
        if turn < 0.0 {
            turn += 4.0;
        }
        if turn >= 4.0 {
            turn = 0.0;
        }
        let za = dir.z.abs();
        let pix = if za <= 2.0 / 3.0 {
            let (a, b) = (nf * (0.5 + turn), nf * dir.z * 0.75);
            let (jp, jm) = ((a - b).floor() as i64, (a + b).floor() as i64);
            // On |z| = 2/3 rounding of a ± b may step one ring out of the belt.
            let (jp, jm) = (jp.min(jm + n), jm.min(jp + n));
            let ir = n + 1 + jp - jm;
            let shift = 1 - (ir & 1);
            let ip = ((jp + jm - n + shift + 1 + 8 * n) >> 1) % (4 * n);
            self.cap() + (ir - 1) * 4 * n + ip
        } else {
            // nside·sqrt(3(1 − |z|)), with 1 − |z| from the distance to the axis.
            let r2 = dir.x * dir.x + dir.y * dir.y;
            let w = (nf * (3.0 * r2 / (1.0 + za)).sqrt()).min(nf);
            let quarter = turn.floor();
            let part = turn - quarter;
            let jp = ((part * w).floor() as i64).min(n - 1);
            let jm = (((1.0 - part) * w).floor() as i64).min(n - 1 - jp);
            let ir = jp + jm + 1;
            let ip = quarter as i64 * ir + jp;
            if dir.z > 0.0 { 2 * ir * (ir - 1) + ip } else { 12 * n * n - 2 * ir * (ir + 1) + ip }
        };
        pix as usize
    }

    /// Face and face coordinates of a patch.
    pub fn face_patch(&self, pix: usize) -> FacePatch {
        let (n, p) = (self.nside, pix as i64);
        let ring = self.ring_of(pix) as i64;
        let info = self.ring(ring as usize);
        let i = p - info.start as i64 + 1;
        let (face, quarter, shift) = if ring < n {
            ((i - 1) / ring, ring, 0)
        } else if ring <= 3 * n {
            let (down, up) = (ring - n + 1, 3 * n + 1 - ring);
            let a = (i - down / 2 + n - 1) / n;
            let b = (i - up / 2 + n - 1) / n;
            let face = match b.cmp(&a) {
                std::cmp::Ordering::Equal => (b & 3) + 4,
                std::cmp::Ordering::Less => b,
                std::cmp::Ordering::Greater => a + 8,
            };
            (face, n, i64::from(!info.shifted))
        } else {
            let s = 4 * n - ring;
            (8 + (i - 1) / s, s, 0)
        };
        let face = face as usize;
        let down = ring - FACE_RING[face] * n + 1;
        let mut across = 2 * i - FACE_AZIMUTH[face] * quarter - shift - 1;
        if across >= 2 * n {
            across -= 8 * n;
        }
        FacePatch { face, ix: (across - down) >> 1, iy: (-across - down) >> 1 }
    }

    /// Patch at a place of a face: the inverse of [`Healpix::face_patch`].
    pub fn pix_at(&self, at: FacePatch) -> usize {
        let n = self.nside;
        let r = FACE_RING[at.face] * n - at.ix - at.iy - 1;
        let ring = self.ring(r as usize);
        let quarter = ring.count as i64 / 4;
        let shift = i64::from(!ring.shifted);
        let mut jp = (FACE_AZIMUTH[at.face] * quarter + at.ix - at.iy + 1 + shift) / 2;
        if jp < 1 {
            jp += 4 * n;
        }
        ring.start + jp as usize - 1
    }

    /// Latitude coordinate w of the point (x, y) of a face: jr·nside − x − y, and its azimuth
    /// numbers (jp, x − y).
    pub(crate) fn face_offsets(&self, face: usize) -> (f64, f64) {
        ((FACE_RING[face] * self.nside) as f64, FACE_AZIMUTH[face] as f64)
    }

    /// Does the patch lie on the equator, cut by the horizon?
    #[inline]
    pub(crate) fn on_equator(&self, at: FacePatch) -> bool {
        (FACE_RING[at.face] - 2) * self.nside == at.ix + at.iy + 1
    }

    /// Direction of the centre of a patch.
    pub fn centre(&self, pix: usize) -> DVec3 {
        let ring = self.ring_of(pix);
        let info = self.ring(ring);
        let half = if info.shifted { 0.5 } else { 0.0 };
        let turn = ((pix - info.start) as f64 + half) / info.count as f64;
        self.direction_on(ring as f64, turn)
    }

    /// Direction at latitude coordinate w and azimuth 2π·turn.
    fn direction_on(&self, w: f64, turn: f64) -> DVec3 {
        let n = self.nside as f64;
        let z = self.z_at(w);
        let pole = w.min(4.0 * n - w);
        let sin = if pole < n {
            let t = pole * pole / (3.0 * n * n);
            (t * (2.0 - t)).sqrt()
        } else {
            (1.0 - z * z).sqrt()
        };
        let (c, s) = cos_sin_turn(turn);
        DVec3::new(sin * c, sin * s, z)
    }

    /// Direction at the face coordinates (x, y) ∈ \[0, nside\]². Equal areas of the square are equal
    /// areas on the sphere.
    pub fn direction_at(&self, face: usize, x: f64, y: f64) -> DVec3 {
        let (south, azimuth) = self.face_offsets(face);
        let w = south - x - y;
        let n = w.min(self.nside as f64).min(4.0 * self.nside as f64 - w);
        let turn = 0.125 * (azimuth + (x - y) / n.max(f64::MIN_POSITIVE));
        // Rounding next to a pole, where the azimuth means nothing, may leave the face.
        self.direction_on(w, turn.clamp(-0.125, 1.0))
    }

    /// Direction at (fx, fy) ∈ \[0, 1\]² of a patch: (0, 0) the southern, (1, 1) the northern corner,
    /// (1, 0) the eastern, (0, 1) the western.
    pub fn direction_in(&self, pix: usize, fx: f64, fy: f64) -> DVec3 {
        let at = self.face_patch(pix);
        self.direction_at(at.face, at.ix as f64 + fx, at.iy as f64 + fy)
    }

    /// Centres of the k × k parts of equal area of a patch.
    pub fn subdivide(&self, pix: usize, k: usize) -> impl Iterator<Item = DVec3> + '_ {
        let mid = move |i: usize| (i as f64 + 0.5) / k as f64;
        (0..k * k).map(move |i| self.direction_in(pix, mid(i % k), mid(i / k)))
    }

    /// `step` points on each of the four edges of a patch, from the northern corner over west,
    /// south and east.
    pub fn boundaries(&self, pix: usize, step: usize) -> Vec<DVec3> {
        let corner = [(1.0, 1.0), (0.0, 1.0), (0.0, 0.0), (1.0, 0.0)];
        let along = [(-1.0, 0.0), (0.0, -1.0), (1.0, 0.0), (0.0, 1.0)];
        let mut points = Vec::with_capacity(4 * step);
        for (c, a) in corner.iter().zip(along) {
            for i in 0..step {
                let t = i as f64 / step as f64;
                points.push(self.direction_in(pix, c.0 + a.0 * t, c.1 + a.1 * t));
            }
        }
        points
    }

    /// Least and greatest height z (cos of the polar angle) on a patch.
    pub fn z_range(&self, pix: usize) -> (f64, f64) {
        let ring = self.ring_of(pix) as f64;
        (self.z_at(ring + 1.0), self.z_at(ring - 1.0))
    }

    /// Number in the NESTED scheme; None unless nside is a power of two.
    pub fn ring2nest(&self, pix: usize) -> Option<usize> {
        if self.nside & (self.nside - 1) != 0 {
            return None;
        }
        let at = self.face_patch(pix);
        let spread = |v: i64| (0..14).fold(0_usize, |acc, b| acc | ((v as usize >> b & 1) << (2 * b)));
        Some(at.face * (self.nside * self.nside) as usize + spread(at.ix) + 2 * spread(at.iy))
    }

    /// The neighbours SW, W, NW, N, NE, E, SE, S of a patch; −1 where there is none (at the eight
    /// corners where three faces meet).
    pub fn neighbours(&self, pix: usize) -> [i64; 8] {
        const STEP: [(i64, i64); 8] = [(-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1)];
        let (n, at) = (self.nside, self.face_patch(pix));
        STEP.map(|(dx, dy)| {
            let (mut x, mut y) = (at.ix + dx, at.iy + dy);
            let side = |v: i64| if v < 0 { -1 } else { i64::from(v >= n) };
            let (sx, sy) = (side(x), side(y));
            let beside = (4 + sx + 3 * sy) as usize;
            x -= sx * n;
            y -= sy * n;
            let face = NEIGHBOUR_FACE[beside][at.face];
            if face < 0 {
                return -1;
            }
            let turn = NEIGHBOUR_TURN[beside][at.face / 4];
            if turn & 1 != 0 {
                x = n - 1 - x;
            }
            if turn & 2 != 0 {
                y = n - 1 - y;
            }
            if turn & 4 != 0 {
                (x, y) = (y, x);
            }
            self.pix_at(FacePatch { face: face as usize, ix: x, iy: y }) as i64
        })
    }
}

/// Face reached from each face over its S, SE, E, SW, (own), NE, W, NW, N side.
const NEIGHBOUR_FACE: [[i64; 12]; 9] = [
    [8, 9, 10, 11, -1, -1, -1, -1, 10, 11, 8, 9],
    [5, 6, 7, 4, 8, 9, 10, 11, 9, 10, 11, 8],
    [-1, -1, -1, -1, 5, 6, 7, 4, -1, -1, -1, -1],
    [4, 5, 6, 7, 11, 8, 9, 10, 11, 8, 9, 10],
    [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11],
    [1, 2, 3, 0, 0, 1, 2, 3, 5, 6, 7, 4],
    [-1, -1, -1, -1, 7, 4, 5, 6, -1, -1, -1, -1],
    [3, 0, 1, 2, 3, 0, 1, 2, 4, 5, 6, 7],
    [2, 3, 0, 1, -1, -1, -1, -1, 0, 1, 2, 3],
];
/// How the coordinates turn over that side (bits: mirror x, mirror y, swap), for the northern,
/// equatorial and southern faces.
const NEIGHBOUR_TURN: [[u8; 3]; 9] =
    [[0, 0, 3], [0, 0, 6], [0, 0, 0], [0, 0, 5], [0, 0, 0], [5, 0, 0], [0, 0, 0], [6, 0, 0], [3, 0, 0]];
