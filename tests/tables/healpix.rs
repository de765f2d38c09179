//! HEALPix against the 60-digit tables, and properties for every granularity.

use crate::harness::{Check, Row, hold, rows, within};
use lightpro::math::{DVec3, PI};
use lightpro::rng::{Purpose, Stream};
use lightpro::sap::{FacePatch, Half, Healpix, SapError};

fn hp(row: &Row) -> Healpix {
    Healpix::new(row.u("nside") as u32).unwrap()
}

fn vector(row: &Row, names: [&str; 3]) -> DVec3 {
    DVec3::new(row.f(names[0]), row.f(names[1]), row.f(names[2]))
}

/// Largest component of a difference.
fn apart(a: DVec3, b: DVec3) -> f64 {
    (a - b).abs().max_element()
}

fn same(got: i64, want: i64) -> Check {
    Check::Deviation(if got == want { 0.0 } else { f64::INFINITY })
}

const XYZ: [&str; 3] = ["x", "y", "z"];
/// Absolute error allowed of a direction's component: three roundings of 2.2e-16.
const DIRECTION: f64 = 7e-16;
/// The table of borders is itself rounded: against 50 digits it errs by up to 7.4e-16.
const BORDER: f64 = 1e-15;

#[test]
fn centres() {
    for file in ["healpix_centres.csv", "healpix_centres_large.csv"] {
        hold(file, |row| {
            within(apart(hp(row).centre(row.u("pix_ring") as usize), vector(row, XYZ)), 0.0, DIRECTION)
        });
    }
}

#[test]
fn rings() {
    hold("healpix_rings.csv", |row| {
        let hp = hp(row);
        let ring = hp.ring(row.u("ring") as usize);
        let whole = hp.npix() == row.u("npix") as usize
            && ring.start == row.u("start_pix") as usize
            && ring.count == row.u("n_in_ring") as usize
            && ring.shifted == (row.u("shifted") == 1)
            && (ring.start..ring.start + ring.count).all(|p| hp.ring_of(p) == row.u("ring") as usize);
        if whole { within(ring.z, row.f("z"), 2.3e-16) } else { Check::Deviation(f64::INFINITY) }
    });
}

#[test]
fn vec2pix() {
    hold("healpix_vec2pix.csv", |row| {
        if row.f("boundary_margin") <= 1e-10 {
            return Check::Cannot("on a border (margin ≤ 1e-10): either side may answer");
        }
        same(hp(row).pix_of(vector(row, XYZ)) as i64, row.u("pix_ring_exact") as i64)
    });
}

/// On a border the answer is one of the patches that meet there.
#[test]
fn borders_answer_with_a_patch_that_touches() {
    for row in rows("healpix_vec2pix.csv").iter().filter(|r| r.f("boundary_margin") <= 1e-10) {
        let (hp, u) = (hp(row), vector(row, XYZ));
        let reach = 2.0 * hp.area().sqrt();
        assert!((hp.centre(hp.pix_of(u)) - u).length() < reach, "line {}", row.line);
    }
    for nside in [1, 2, 3, 4, 7, 8, 16] {
        let hp = Healpix::new(nside).unwrap();
        for pix in 0..hp.npix() {
            let near = hp.neighbours(pix);
            let diagonal: Vec<i64> =
                near.iter().filter(|&&p| p >= 0).flat_map(|&p| hp.neighbours(p as usize)).collect();
            for b in hp.boundaries(pix, 5) {
                let got = hp.pix_of(b) as i64;
                assert!(got == pix as i64 || near.contains(&got) || diagonal.contains(&got));
            }
        }
    }
}

#[test]
fn neighbours() {
    hold("healpix_neighbours.csv", |row| {
        let want = ["SW", "W", "NW", "N", "NE", "E", "SE", "S"].map(|c| row.f(c) as i64);
        let got = hp(row).neighbours(row.u("pix_ring") as usize);
        Check::Deviation(if got == want { 0.0 } else { f64::INFINITY })
    });
}

#[test]
fn boundaries() {
    hold("healpix_boundaries.csv", |row| {
        let points = hp(row).boundaries(row.u("pix_ring") as usize, row.u("step") as usize);
        within(apart(points[row.u("k") as usize], vector(row, XYZ)), 0.0, BORDER)
    });
}

#[test]
fn ring2nest() {
    hold("healpix_ring2nest.csv", |row| {
        let got = hp(row).ring2nest(row.u("pix_ring") as usize).unwrap();
        same(got as i64, row.u("pix_nest") as i64)
    });
    assert_eq!(Healpix::new(3).unwrap().ring2nest(5), None);
}

#[test]
fn pixel_mean() {
    hold("healpix_pixel_mean.csv", |row| {
        let (hp, pix) = (hp(row), row.u("pix_ring") as usize);
        let mean = hp.mean_vector(pix, None);
        let angle = mean.cross(hp.centre(pix)).length().atan2(mean.dot(hp.centre(pix))).to_degrees();
        if (angle - row.f("offset_from_centre_deg")).abs() > 1e-12 {
            return Check::Deviation(f64::INFINITY);
        }
        within(apart(mean, vector(row, ["mx", "my", "mz"])), 0.0, 2e-15)
    });
}

/// The tolerances bite: a height off by one part in 1e14, the centre in place of the mean, a point of
/// the border off by 2e-15 of its patch, a direction off by 3 mrad.
#[test]
fn tolerances_bite() {
    let moved = rows("healpix_centres.csv").iter().any(|row| {
        let c = hp(row).centre(row.u("pix_ring") as usize);
        apart(DVec3::new(c.x, c.y, c.z * (1.0 + 1e-14)), vector(row, XYZ)) > DIRECTION
    });
    assert!(moved);
    let border = rows("healpix_boundaries.csv").iter().any(|row| {
        let (hp, k, step) = (hp(row), row.u("k") as usize, row.u("step") as usize);
        let points = hp.boundaries(row.u("pix_ring") as usize, step);
        let next = points[(k + 1) % points.len()];
        apart(points[k] + (next - points[k]) * 2e-15, vector(row, XYZ)) > BORDER
    });
    assert!(border);
    let mean = rows("healpix_pixel_mean.csv").iter().any(|row| {
        let c = hp(row).centre(row.u("pix_ring") as usize);
        apart(c, vector(row, ["mx", "my", "mz"])) > 2e-15
    });
    assert!(mean, "the centre is not the mean");
    let other = rows("healpix_vec2pix.csv").iter().any(|row| {
        let u = vector(row, XYZ) + DVec3::new(3e-3, 0.0, 0.0);
        hp(row).pix_of(u.normalize()) != row.u("pix_ring_exact") as usize
    });
    assert!(other, "3 mrad must leave some patch");
}

#[test]
fn round_trips_for_every_granularity() {
    for nside in 1..=64 {
        let hp = Healpix::new(nside).unwrap();
        let mut seen = 0;
        for pix in 0..hp.npix() {
            assert_eq!(hp.pix_of(hp.centre(pix)), pix, "nside {nside}");
            let at = hp.face_patch(pix);
            assert_eq!(hp.pix_at(at), pix, "nside {nside}");
            assert!(apart(hp.direction_in(pix, 0.5, 0.5), hp.centre(pix)) < DIRECTION);
            let (lo, hi) = hp.z_range(pix);
            assert!(lo < hp.centre(pix).z && hp.centre(pix).z < hi);
            seen += 1;
        }
        assert_eq!(seen, hp.npix());
        assert!((hp.area() * seen as f64 - 4.0 * PI).abs() < 1e-13);
    }
    assert_eq!(Healpix::new(0), Err(SapError::Granularity(0)));
    assert_eq!(Healpix::new(8193), Err(SapError::Granularity(8193)));
}

#[test]
fn poles_and_the_seam() {
    for nside in [1, 2, 3, 5, 8, 17, 64, 1000, 8192] {
        let hp = Healpix::new(nside).unwrap();
        let n = hp.npix();
        assert!(hp.pix_of(DVec3::Z) < 4 && hp.pix_of(-DVec3::Z) >= n - 4);
        for tiny in [1e-300, 1e-20, 1e-9] {
            for (x, y, quarter) in [(1.0, 1.0, 0), (-1.0, 1.0, 1), (-1.0, -1.0, 2), (1.0, -1.0, 3)] {
                assert_eq!(hp.pix_of(DVec3::new(x * tiny, y * tiny, 1.0)), quarter);
                assert_eq!(hp.pix_of(DVec3::new(x * tiny, y * tiny, -1.0)), n - 4 + quarter);
            }
        }
        for z in [-1.0, -0.9, -2.0 / 3.0, -0.3, 0.0, 0.1, 2.0 / 3.0, 0.667, 0.999_999_9] {
            let s = (1.0_f64 - z * z).sqrt();
            for y in [-1e-320, -1e-20, -1e-17, -1e-12, -0.0, 0.0, 1e-12] {
                let pix = hp.pix_of(DVec3::new(s, y, z));
                assert!(pix < n);
                let reach = 2.0 * hp.area().sqrt();
                assert!((hp.centre(pix) - DVec3::new(s, y, z)).length() < reach);
            }
        }
    }
}

/// The k² parts of a patch are patches of the tessellation with k·nside: equal area by construction.
#[test]
fn parts_are_patches_of_the_finer_tessellation() {
    for (nside, k) in [(1, 2), (1, 7), (2, 3), (3, 5), (4, 4), (5, 3), (8, 2)] {
        let (hp, fine) = (Healpix::new(nside).unwrap(), Healpix::new(nside * k).unwrap());
        for pix in 0..hp.npix() {
            let at = hp.face_patch(pix);
            for (i, u) in hp.subdivide(pix, k as usize).enumerate() {
                let k = i64::from(k);
                let part =
                    FacePatch { face: at.face, ix: at.ix * k + i as i64 % k, iy: at.iy * k + i as i64 / k };
                assert_eq!(fine.face_patch(fine.pix_of(u)), part);
            }
        }
    }
}

/// `uniform_in` stays in its patch and fills its 9 × 9 parts evenly (χ² over all patches); squeezing
/// one coordinate by up to 10 % is seen.
#[test]
fn uniform_in_is_uniform() {
    let mut rng = Stream::of(7, 0, 0, Purpose::Probe);
    for nside in [1_u32, 2, 3, 6] {
        let (hp, fine) = (Healpix::new(nside).unwrap(), Healpix::new(9 * nside).unwrap());
        let draws = 12 * 40_000 / hp.npix();
        let chi = |pick: &mut dyn FnMut(usize) -> DVec3| {
            let (mut chi2, mut outside) = (0.0, 0);
            for pix in 0..hp.npix() {
                let at = hp.face_patch(pix);
                let mut hits = [0.0; 81];
                for _ in 0..draws {
                    let f = fine.face_patch(fine.pix_of(pick(pix)));
                    let (x, y) = (f.ix - 9 * at.ix, f.iy - 9 * at.iy);
                    if f.face == at.face && (0..9).contains(&x) && (0..9).contains(&y) {
                        hits[(9 * y + x) as usize] += 1.0;
                    } else {
                        outside += 1;
                    }
                }
                let want = draws as f64 / 81.0;
                chi2 += hits.iter().map(|h| (h - want) * (h - want) / want).sum::<f64>();
            }
            assert_eq!(outside, 0);
            let freedom = 80.0 * hp.npix() as f64;
            (chi2 - freedom) / (2.0 * freedom).sqrt()
        };
        let good = chi(&mut |pix| hp.uniform_in(pix, &mut rng));
        assert!(good.abs() < 4.0, "nside {nside}: {good} standard deviations");
        let bent = chi(&mut |pix| {
            let (x, y) = (rng.uniform(), rng.uniform());
            hp.direction_in(pix, x * (1.0 - 0.1 * (1.0 - x)), y)
        });
        assert!(bent > 4.0, "nside {nside}: bent {bent}");
    }
}

/// In a half sphere: always on its side, mean as `mean_vector` says.
#[test]
fn uniform_in_half_fills_the_visible_part() {
    let mut rng = Stream::of(8, 0, 0, Purpose::Probe);
    for nside in [1, 2, 3] {
        let hp = Healpix::new(nside).unwrap();
        for half in [Half::Upper, Half::Lower] {
            let sign = if half == Half::Upper { 1.0 } else { -1.0 };
            for pix in (0..hp.npix()).filter(|&p| hp.share_in(p, Some(half)) == 0.5) {
                let n = 20_000;
                let mut sum = DVec3::ZERO;
                for _ in 0..n {
                    let u = hp.uniform_in_half(pix, Some(half), &mut rng);
                    assert!(u.z * sign >= 0.0);
                    sum += u;
                }
                let mean = hp.mean_vector(pix, Some(half));
                // Spread of a component is below the patch's radius, 0.4 at nside 2: five of its SE.
                let limit = 5.0 * 0.5 * hp.area().sqrt() / f64::from(n).sqrt();
                assert!(apart(sum / f64::from(n), mean) < limit);
            }
        }
    }
}
