use super::*;
use crate::lpm::light::Medium;
use crate::rng::Purpose;
use crate::universe::{BodyId, MediumId, SurfaceId};

/// A ray caught in a round rod keeps its angle of incidence over any number of total reflections:
/// rounding errors must not feed on themselves.
#[test]
fn total_reflections_keep_the_angle() {
    let (here, beyond) = (Medium::<1>::clear(1.55), Medium::clear(1.0));
    let mut rng = Stream::of(20_261_122, 0, 0, Purpose::Probe);
    for cos in [0.05, 0.3, 0.64, 0.76] {
        let along = 0.5 * (1.0 - cos * cos);
        let mut p = DVec3::X;
        let mut dir = DVec3::new(-cos, (1.0 - cos * cos - along * along).sqrt(), along);
        for k in 0..200_000 {
            let across = DVec3::new(dir.x, dir.y, 0.0);
            p += across * (-2.0 * p.dot(across) / across.length_squared());
            p /= p.length();
            let normal = -p;
            let at = Interface {
                distance: 1.0,
                normal,
                facet: normal,
                axis: DVec3::Z,
                beyond: MediumId(0),
                surface: SurfaceId::SMOOTH,
                body: BodyId(1),
            };
            let m = Meeting { dir, at: &at, here: &here, beyond: &beyond };
            assert!((m.cos_i() - cos).abs() < 1e-9, "{} for {cos} after {k}", m.cos_i());
            assert!((dir.length() - 1.0).abs() < 1e-14);
            match smooth_dielectric(&m, &mut rng) {
                Fate::Reflected { dir: d, .. } => dir = d,
                fate => panic!("{fate:?} after {k}"),
            }
        }
    }
}
