//! The full Klems basis: 145 patches of a hemisphere in nine rings (J. H. Klems, ASHRAE Trans. 100 (1994)
//! 1065), in which windows and luminaires are described.

use crate::math::{DVec3, PI, TAU, acos, atan2, sin};
use std::fmt::Write as _;

/// Patches of a hemisphere.
pub const PATCHES: usize = 145;

/// Upper polar limit in degrees and number of patches of each ring.
pub const RINGS: [(f64, usize); 9] =
    [(5.0, 1), (15.0, 8), (25.0, 16), (35.0, 20), (45.0, 24), (55.0, 24), (65.0, 24), (75.0, 16), (90.0, 12)];

/// Patch of a direction: polar angle from the normal of its own side, azimuth from x; patch 0 of a ring is
/// centred on azimuth 0.
pub fn patch(dir: DVec3) -> usize {
    let polar = acos(dir.z.abs().min(1.0)) * 180.0 / PI;
    let mut first = 0;
    for (upper, n) in RINGS {
        if polar < upper || upper == 90.0 {
            let turn = if dir.x == 0.0 && dir.y == 0.0 { 0.0 } else { atan2(dir.y, dir.x) / TAU };
            let at = (turn * n as f64 + 0.5).rem_euclid(n as f64) as usize;
            return first + at.min(n - 1);
        }
        first += n;
    }
    PATCHES - 1
}

/// Ring of a patch, from the normal outwards.
pub fn ring(patch: usize) -> usize {
    let mut first = 0;
    let within = |(_, n): &(f64, usize)| {
        first += n;
        patch < first
    };
    RINGS.iter().position(within).unwrap_or(RINGS.len() - 1)
}

/// ∫ cos θ dω over a patch, sr; the sum over a hemisphere is π.
pub fn projected(patch: usize) -> f64 {
    let (mut first, mut lower) = (0, 0.0);
    for (upper, n) in RINGS {
        if patch < first + n {
            let s = |deg: f64| sin(deg * PI / 180.0);
            return PI * (s(upper) * s(upper) - s(lower) * s(lower)) / n as f64;
        }
        (first, lower) = (first + n, upper);
    }
    0.0
}

/// The definition of the basis that BSDF files carry.
pub fn angle_basis_xml() -> String {
    let mut out = String::from("<AngleBasis><AngleBasisName>LBNL/Klems Full</AngleBasisName>\n");
    let mut lower = 0.0;
    for (upper, n) in RINGS {
        let middle = if lower == 0.0 { 0.0 } else { 0.5 * (lower + upper) };
        let _ = writeln!(
            out,
            "<AngleBasisBlock><Theta>{middle}</Theta><nPhis>{n}</nPhis><ThetaBounds><LowerTheta>{lower}</LowerTheta>\
             <UpperTheta>{upper}</UpperTheta></ThetaBounds></AngleBasisBlock>"
        );
        lower = upper;
    }
    out + "</AngleBasis>"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{cos, sin_cos};

    #[test]
    fn patches_tile_the_hemisphere() {
        assert_eq!(RINGS.iter().map(|r| r.1).sum::<usize>(), PATCHES);
        assert!(((0..PATCHES).map(projected).sum::<f64>() - PI).abs() < 1e-14);
        // Shares of Lambertian light by even points in (sin²θ, azimuth).
        let mut counts = [0usize; PATCHES];
        let (rings, turns) = (400, 720);
        for i in 0..rings {
            for j in 0..turns {
                let s2 = (f64::from(i) + 0.5) / f64::from(rings);
                let (s, c) = sin_cos(TAU * (f64::from(j) + 0.5) / f64::from(turns));
                let r = s2.sqrt();
                counts[patch(DVec3::new(r * c, r * s, (1.0 - s2).sqrt()))] += 1;
            }
        }
        for (i, n) in counts.iter().enumerate() {
            let share = *n as f64 / f64::from(rings * turns);
            assert!((share - projected(i) / PI).abs() < 4e-4, "{i}: {share} {}", projected(i) / PI);
        }
        assert_eq!(patch(DVec3::Z), 0);
        let at = |polar: f64, azimuth: f64| {
            let (p, a) = (polar.to_radians(), azimuth.to_radians());
            patch(DVec3::new(sin(p) * cos(a), sin(p) * sin(a), cos(p)))
        };
        assert_eq!((at(10.0, 0.0), at(10.0, -22.0), at(10.0, 23.0), at(20.0, 0.0)), (1, 1, 2, 9));
    }
}
