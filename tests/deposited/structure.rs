//! What deposited sheets come to.

use super::*;
use lightpro::rng::{Purpose, Stream};
use lightpro::universe::deposit::{DepositError, Laid, Sought};

/// Kraft fibres in a small cell.
fn small(grammage: f64) -> Deposit {
    Deposit { pressing: 0.6, ..sheet(grammage, 400.0) }
}

fn grammage(laid: &Laid) -> f64 {
    laid.figures(0.0).solid * 1.5
}

/// Nothing overlaps, fibres bend by little from piece to piece, and the sheet weighs what it should.
#[test]
fn no_two_bodies_share_a_point() {
    for (flexibility, places) in [(0.0, 1), (0.3, 16), (2.0, 16)] {
        let d = Deposit { flexibility, places, ..small(80.0) };
        let laid = d.lay(3, 1).unwrap();
        let f = laid.figures(0.5);
        println!("F {flexibility}: {f:?}");
        // Pressing rounds nothing: the wall that was drawn is the wall that lies.
        assert!((f.solid - laid.laid[0]).abs() < 1e-9 * f.solid);
        assert!((f.solid * 1.5 / 80.0 - 1.0).abs() < 0.001, "{}", f.solid * 1.5);
        assert_eq!(f.overlap, 0.0, "of 4e5 points");
        assert!(f.sharpest < 0.8 && (flexibility > 0.0 || f.sharpest < 1e-9));
        assert!(f.porosity > 0.3 && f.porosity < 0.95 && f.thickness < f.between_plates);
        let steepest = laid.fibres.iter().flat_map(|x| x.pieces(x.outer)).map(|p| p.slope.abs());
        // Corners are raised by up to .05 um over a piece of 1 um or more.
        assert!(steepest.fold(0.0, f64::max) < flexibility + 0.11);
    }
}

/// A check of that check: fibres let down by a tenth of their height overlap, and are found.
#[test]
fn overlaps_are_found() {
    let mut laid = small(60.0).lay(3, 1).unwrap();
    for (i, f) in laid.fibres.iter_mut().enumerate() {
        let down = 0.2 * f.outer.1 * f64::from(u8::from(i % 2 == 0));
        f.knots.iter_mut().for_each(|k| k.1 -= down);
    }
    let overlap = laid.figures(0.5).overlap;
    assert!(overlap > 1e-4, "{overlap}");
}

/// Fibres lie on something: lowered by half a micrometre any of them overlaps another or sinks.
#[test]
fn fibres_rest_on_what_is_below() {
    let laid = small(60.0).lay(5, 0).unwrap();
    let gap = |g: f64| laid.figures(g).bonded;
    let (near, far) = (gap(0.1), gap(2.0));
    println!("bonded within .1 um {near:.4}, within 2 um {far:.4}");
    assert!(near < far && far > 0.05);
    // The first fibre lies on the plane.
    let first = &laid.fibres[0];
    assert!(first.knots.iter().all(|k| (k.1 - first.outer.1 - 0.1).abs() < 1e-12));
}

/// More flexible, more pressed, more choice: a thinner sheet; the same draws give the same sheet.
#[test]
fn the_sheet_gets_thinner() {
    let thickness = |d: &Deposit| d.lay(7, 0).unwrap().thickness;
    let d = small(60.0);
    let t = thickness(&d);
    assert_eq!(t, thickness(&d.clone()));
    assert!(thickness(&Deposit { flexibility: 0.1, ..d.clone() }) > t);
    assert!(thickness(&Deposit { pressing: 0.8, ..d.clone() }) > t);
    assert!(thickness(&Deposit { places: 1, ..d.clone() }) > t);
}

#[test]
fn the_thickness_is_found() {
    let d = small(60.0);
    let from = d.lay(9, 0).unwrap().thickness;
    for sought in [Sought::Pressing, Sought::Flexibility] {
        let start = match sought {
            Sought::Pressing => Deposit { pressing: 1.0, ..d.clone() },
            Sought::Flexibility => Deposit { flexibility: 0.0, ..d.clone() },
        };
        let found = start.to_thickness(from, sought, 9, 1).unwrap();
        let got = found.lay(9, 0).unwrap().thickness;
        println!("{sought:?}: {got:.3} of {from:.3} um, F {} pressing {}", found.flexibility, found.pressing);
        assert!((got / from - 1.0).abs() < 0.01);
    }
    let e = d.to_thickness(5.0, Sought::Pressing, 9, 1).unwrap_err();
    assert!(matches!(e, DepositError::Thickness { .. }), "{e}");
}

/// Spheres in the pores: as many as asked for, none in another body; too many are told, not dropped.
#[test]
fn fillers_stand_in_pores() {
    let sizes = Sizes::Sphere(SizeLaw::lognormal(3.0, 0.3).unwrap());
    let filler = Kind::new(
        sizes,
        Azimuth::Uniform,
        Tilt::InPlane,
        Roll::Flat,
        WALL,
        AIR,
        SurfaceId::SMOOTH,
        BodyId(2),
    );
    let mut d = small(40.0);
    d.kinds.push(filler);
    d.amounts.push(Amount::Solid(0.5));
    let laid = d.lay(11, 0).unwrap();
    d.met(&laid).unwrap();
    let f = laid.figures(0.5);
    println!("{} particles, overlap {:.1e}", laid.particles.len(), f.overlap);
    assert!(f.overlap < 1e-3 && laid.particles.len() > 2000);
    assert!((f.solid - laid.laid.iter().sum::<f64>()).abs() < 1e-9 * f.solid);
    // What fits nowhere is told.
    let sizes = Sizes::Sphere(SizeLaw::Constant(90.0));
    d.kinds[1] = Kind::new(
        sizes,
        Azimuth::Uniform,
        Tilt::InPlane,
        Roll::Flat,
        WALL,
        AIR,
        SurfaceId::SMOOTH,
        BodyId(2),
    );
    let full = d.lay(11, 0).unwrap();
    assert!(matches!(d.met(&full), Err(DepositError::Amount { kind: 1, .. })));
}

/// The universe holds what was laid: the solid share of points is the volume laid.
#[test]
fn the_universe_holds_the_solid() {
    let d = small(60.0);
    let laid = d.lay(13, 0).unwrap();
    let u = d.universe(&laid, laid.top + 0.1).unwrap();
    let mut rng = Stream::of(1, 0, 0, Purpose::Probe);
    let n = 200_000;
    let at = |rng: &mut Stream| {
        let p = lightpro::math::DVec3::new(
            400.0 * rng.uniform(),
            400.0 * rng.uniform(),
            laid.top * rng.uniform(),
        );
        u.medium_at(p) == WALL
    };
    let share = (0..n).filter(|_| at(&mut rng)).count() as f64 / f64::from(n);
    let want = grammage(&laid) / 1.5 / laid.top;
    let sd = (want * (1.0 - want) / f64::from(n)).sqrt();
    println!("solid {share:.4}, laid {want:.4}, z {:+.2}", (share - want) / sd);
    assert!((share - want).abs() < 4.0 * sd);
}

#[test]
fn what_cannot_fall() {
    let mut d = small(60.0);
    d.kinds[0] = {
        let sizes = Sizes::Fibre {
            width: SizeLaw::Constant(20.0),
            flatness: SizeLaw::Constant(0.3),
            wall: None,
            length: None,
        };
        Kind::new(sizes, Azimuth::Uniform, Tilt::InPlane, Roll::Flat, WALL, AIR, SurfaceId::SMOOTH, BodyId(1))
    };
    assert_eq!(d.lay(1, 0).unwrap_err(), DepositError::Endless(0));
    assert_eq!(Deposit { pressing: 1.5, ..small(60.0) }.lay(1, 0).unwrap_err(), DepositError::Setting);
}

#[test]
#[ignore = "study (a minute): cargo test --release --test deposited study -- --ignored --nocapture"]
fn study() {
    println!(
        "g/m2 F pressing places | thickness plates um | kg/m3 porosity S_V | bonded within .1 .5 1 um | overlap bend \
         pieces fibres coverage open | s"
    );
    let row = |grammage: f64, flexibility: f64, pressing: f64, places: u32| {
        let d = Deposit { flexibility, pressing, places, ..sheet(grammage, 1000.0) };
        let start = std::time::Instant::now();
        let laid = d.lay(1, 0).unwrap();
        let took = start.elapsed().as_secs_f64();
        let f = laid.figures(0.5);
        let [b1, b2] = [0.1, 1.0].map(|g| laid.figures(g).bonded);
        println!(
            "{grammage:3} {flexibility:.2} {pressing:.2} {places:3} | {:7.2} {:7.2} | {:4.0} {:.3} {:.4} | {b1:.3} {:.3} \
             {b2:.3} | {:.0e} {:.3} {:6} {} {:.2} {:.3} | {took:.2}",
            f.thickness,
            f.between_plates,
            f.solid * 1500.0 / f.thickness,
            f.porosity,
            f.surface,
            f.bonded,
            f.overlap,
            f.sharpest,
            f.pieces,
            laid.fibres.len(),
            f.coverage,
            1.0 - f.covered
        );
    };
    for places in [1, 16, 64, 256] {
        for pressing in [1.0, 0.7, 0.5, 0.35] {
            row(80.0, 0.5, pressing, places);
        }
    }
    for flexibility in [0.1, 0.25, 1.0] {
        row(80.0, flexibility, 0.5, 16);
    }
    for grammage in [20.0, 40.0] {
        row(grammage, 0.5, 0.5, 16);
    }
}

/// Figures and picture of docs/deposited.md.
#[test]
#[ignore = "writes docs/figures/deposited-section.svg, prints figures (minutes): cargo test --release --test deposited page -- --ignored --nocapture"]
fn page() {
    use lightpro::command::{RunArgs, SceneArgs, finish, load};
    use lightpro::math::DVec3;
    use lightpro::report::plot::section::{Section, colour};
    use lightpro::universe::any::AnyUniverse;
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let args = SceneArgs { path: root.join("scenes/deposited-kraft.xml"), ..SceneArgs::default() };
    let (scene, plan) = load(&args).unwrap();
    println!("{plan}");
    let AnyUniverse::Ensemble(u) = &plan.universe else { panic!("not deposited") };
    let section = Section {
        origin: DVec3::new(100.0, 437.0, -6.0),
        right: DVec3::X,
        up: DVec3::Z,
        size: [600.0, plan.top + 12.0],
        pixel: 0.5,
    };
    let air = scene.materials.iter().position(|m| m.id == "air").unwrap() as u16;
    let classes = [("pore and lumen", None), ("fibre wall", Some(colour(0)))];
    let title = "Section of a deposited sheet of bleached softwood kraft, 80 g/m² (realisation 1)";
    let sheet = &u.cells()[0];
    let svg = section.svg(title, &classes, |p| usize::from(sheet.medium_at(p) != MediumId(air)));
    std::fs::write(root.join("docs/figures/deposited-section.svg"), svg).unwrap();
    let run = RunArgs { histories: Some(32_768), ..RunArgs::default() };
    let done = finish(scene, &run, |_| true).unwrap();
    println!(
        "troubled {:?}, worst imbalance {:.1e}",
        done.outcome.troubled(),
        done.outcome.worst_imbalance()
    );
    for f in &done.result.figures {
        println!(
            "{} {:?} {:?}: {:?} ± {:?} {}",
            f.name, f.wavelength_nm, f.component, f.value, f.error, f.unit
        );
    }
}
