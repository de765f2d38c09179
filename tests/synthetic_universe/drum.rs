//! Boolean realisations: the drum is the same however it is grown, and obeys the Poisson laws near
//! and far; cells hold what they should.

use super::*;
use lightpro::law::{Azimuth, Roll, SizeLaw, Tilt};
use lightpro::universe::Overlap;
use lightpro::universe::statistical::kind::{Kind, Sizes};
use lightpro::universe::synthetic::drum::{Drum, Grown};
use lightpro::universe::synthetic::realise::{Boolean, RealiseError};

const HEIGHT: f64 = 10.0;
const L_V: f64 = 0.1135;

fn fibres(tilt: Tilt, wall: Option<f64>, length: Option<f64>) -> Kind {
    let sizes = Sizes::Fibre {
        width: SizeLaw::Constant(2.0),
        flatness: SizeLaw::Constant(1.0),
        wall: wall.map(SizeLaw::Constant),
        length: length.map(SizeLaw::Constant),
    };
    let surface = SurfaceId::SMOOTH;
    Kind::new(sizes, Azimuth::Uniform, tilt, Roll::Uniform, MediumId(1), AIR, surface, BodyId(1))
}

fn model(kind: Kind, contained: bool) -> Boolean {
    Boolean {
        kinds: vec![kind],
        density: vec![L_V],
        sheet: [0.0, HEIGHT],
        pore: AIR,
        overlap: Overlap::Union,
        contained,
    }
}

/// Bits of a walk from around (x, 0) at the top of the sheet.
fn walk(drum: &Drum, grown: &mut Grown, x: f64, history: u64) -> Vec<u64> {
    let s = &mut stream(history);
    let mut bits = Vec::new();
    for _ in 0..50 {
        let d = isotropic(s);
        let mut ray = Ray {
            origin: DVec3::new(x + 20.0 * s.uniform(), s.uniform(), HEIGHT),
            dir: DVec3::new(d.x, d.y, -d.z.abs()),
        };
        let mut place = drum.enter(&ray, grown, s).place;
        for _ in 0..200 {
            let Next::Interface(at) = drum.next(&ray, &mut place, grown, f64::INFINITY, s) else { break };
            bits.extend([at.distance.to_bits(), at.normal.x.to_bits(), u64::from(at.beyond.0)]);
            ray.origin = ray.at(at.distance);
            if s.uniform() < 0.3 {
                let d = isotropic(s);
                ray.dir = if d.dot(at.normal) < 0.0 { -d } else { d };
                drum.reflected(&ray, &mut place, grown, &at);
            } else {
                drum.crossed(&mut ray, &mut place, grown, &at);
            }
        }
    }
    bits
}

#[test]
fn a_drum_is_the_same_however_it_is_grown() {
    for tilt in [Tilt::InPlane, Tilt::Isotropic] {
        let drum = model(fibres(tilt, Some(0.27), None), false).drum(3, 5).unwrap();
        let (mut first, mut second) = (Grown::default(), Grown::default());
        let near = walk(&drum, &mut first, 0.0, 1);
        let far = walk(&drum, &mut first, 180.0, 2);
        assert!(first.radius() > 180.0 && first.bodies() > 50);
        // The other way round: far first.
        assert!(far == walk(&drum, &mut second, 180.0, 2));
        assert!(near == walk(&drum, &mut second, 0.0, 1));
        assert!(near.len() > 1000 && far.len() > 1000);
        // Another realisation is another sheet, in memory that held this one.
        let other = model(fibres(tilt, Some(0.27), None), false).drum(3, 6).unwrap();
        assert!(near != walk(&other, &mut second, 0.0, 1));
        assert!(near == walk(&drum, &mut second, 0.0, 1));
    }
}

/// Mean of `measure` over realisations, and its standard error.
fn mean(
    realisations: u64,
    model: &Boolean,
    measure: impl Fn(&Drum, &mut Grown, &mut Stream) -> f64,
) -> (f64, f64) {
    let (mut sum, mut square) = (0.0, 0.0);
    let mut grown = Grown::default();
    for k in 0..realisations {
        let drum = model.drum(11, k).unwrap();
        let x = measure(&drum, &mut grown, &mut stream(1000 + k));
        sum += x;
        square += x * x;
    }
    let n = realisations as f64;
    (sum / n, ((square / n - (sum / n).powi(2)) / n).sqrt())
}

fn agrees(what: &str, (got, se): (f64, f64), want: f64) {
    println!("{what}: {got:.5}({se:.5}), expected {want:.5}, z {:+.2}", (got - want) / se);
    assert!((got - want).abs() < 4.5 * se, "{what}");
}

/// Share of solid at random points of the sheet, at several distances from the axis of the drum, and
/// interfaces along vertical lines.
#[test]
fn drums_obey_the_poisson_laws_near_and_far() {
    let solid_share = 1.0 - (-L_V * std::f64::consts::PI).exp();
    for tilt in [Tilt::InPlane, Tilt::Isotropic] {
        for far in [0.0, 60.0, 150.0] {
            let m = model(fibres(tilt, None, None), false);
            let share = mean(300, &m, |drum, grown, s| {
                let inside = (0..40).filter(|_| {
                    let phi = TAU * s.uniform();
                    let at = DVec3::new(far * phi.cos(), far * phi.sin(), HEIGHT * s.uniform());
                    drum.enter(&Ray { origin: at, dir: isotropic(s) }, grown, s).medium == MediumId(1)
                });
                inside.count() as f64 / 40.0
            });
            agrees(&format!("{tilt:?} share at {far}"), share, solid_share);
        }
    }
    // Surfaces met along a vertical line of length H: 2 · 2 r L_V ⟨sin γ⟩ H (1 − share of solid), each
    // fibre's entry and exit seen unless another fibre covers it.
    for (tilt, sine) in [(Tilt::InPlane, 1.0), (Tilt::Isotropic, std::f64::consts::PI / 4.0)] {
        let m = model(fibres(tilt, None, None), false);
        let hits = mean(300, &m, |drum, grown, s| {
            let mut count = 0;
            for _ in 0..20 {
                let phi = TAU * s.uniform();
                let origin = DVec3::new(30.0 * phi.cos(), 30.0 * phi.sin(), HEIGHT);
                let mut ray = Ray { origin, dir: -DVec3::Z };
                let mut place = drum.enter(&ray, grown, s).place;
                while let Next::Interface(at) = drum.next(&ray, &mut place, grown, f64::INFINITY, s) {
                    count += 1;
                    ray.origin = ray.at(at.distance);
                    drum.crossed(&mut ray, &mut place, grown, &at);
                }
            }
            f64::from(count) / 20.0
        });
        agrees(&format!("{tilt:?} interfaces"), hits, 4.0 * L_V * sine * HEIGHT * (1.0 - solid_share));
    }
}

/// `contained`: nothing is cut, and the share over depth is that of discs whose centres keep clear.
#[test]
fn contained_fibres_keep_clear_of_the_planes() {
    let m = model(fibres(Tilt::InPlane, None, None), true);
    for z in [0.3_f64, 1.0, 5.0] {
        // Area of the disc about z that centres above height 1 may take: beyond a chord at 1 − z.
        let chord = (1.0 - z).max(-1.0);
        let area = chord.acos() - chord * (1.0 - chord * chord).sqrt();
        let share = mean(400, &m, |drum, grown, s| {
            let inside = (0..40).filter(|_| {
                let at = DVec3::new(40.0 * (s.uniform() - 0.5), 40.0 * (s.uniform() - 0.5), z);
                drum.enter(&Ray { origin: at, dir: isotropic(s) }, grown, s).medium == MediumId(1)
            });
            inside.count() as f64 / 40.0
        });
        agrees(&format!("contained, depth {z}"), share, 1.0 - (-L_V * area).exp());
    }
    let tilted = model(fibres(Tilt::Isotropic, None, None), true);
    assert_eq!(tilted.drum(1, 1).err(), Some(RealiseError::Tilted(0)));
}

/// Finite fibres in a periodic cell, and in a drum: the same share.
#[test]
fn finite_fibres_fill_cells_and_drums_alike() {
    for tilt in [Tilt::InPlane, Tilt::Isotropic] {
        let m = model(fibres(tilt, Some(0.27), Some(15.0)), false);
        let want = 1.0 - (-L_V * std::f64::consts::PI * (1.0 - 0.73 * 0.73)).exp();
        let (mut sum, mut square) = (0.0, 0.0);
        for k in 0..100 {
            let u = m.cell([40.0, 50.0], 2, k).unwrap();
            let s = &mut stream(k);
            let inside = (0..400).filter(|_| {
                let at = DVec3::new(300.0 * s.uniform(), 300.0 * s.uniform(), HEIGHT * s.uniform());
                u.medium_at(at) == MediumId(1)
            });
            let x = inside.count() as f64 / 400.0;
            sum += x;
            square += x * x;
        }
        let average = sum / 100.0;
        agrees(
            &format!("{tilt:?} cell"),
            (average, ((square / 100.0 - average * average) / 100.0).sqrt()),
            want,
        );
        let share = mean(100, &m, |drum, grown, s| {
            let inside = (0..100).filter(|_| {
                let at = DVec3::new(60.0 * s.uniform(), 10.0 * s.uniform(), HEIGHT * s.uniform());
                drum.enter(&Ray { origin: at, dir: isotropic(s) }, grown, s).medium == MediumId(1)
            });
            inside.count() as f64 / 100.0
        });
        agrees(&format!("{tilt:?} drum"), share, want);
    }
    let endless = model(fibres(Tilt::InPlane, None, None), false);
    assert_eq!(endless.cell([40.0; 2], 1, 1).err(), Some(RealiseError::Endless(0)));
}
