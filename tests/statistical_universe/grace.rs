//! Free paths by law: the equilibrium law keeps the mean path 2H, the law of surfaces alone breaks it.

use crate::stream;
use crate::transport::*;
use lightpro::law::SizeLaw;
use lightpro::lpm::Medium;
use lightpro::math::DVec3;
use lightpro::phase::Phase;
use lightpro::rng::Stream;
use lightpro::stats::{ks_p_value, sidak};
use lightpro::universe::sheet::plane_ahead;
use lightpro::universe::statistical::StatisticalUniverse;
use lightpro::universe::statistical::amount::Target;
use lightpro::universe::statistical::grace::Grace;
use lightpro::universe::statistical::kind::{Encounter, Kind};
use lightpro::universe::{BodyId, Interface, Next, Ray, Start, Universe};

const HEIGHT: f64 = 10.0;
const MEAN: f64 = 4.0;

fn law(shape: f64) -> Grace {
    Grace::new(SizeLaw::gamma(MEAN, shape).unwrap(), vec![(0.0, vec![1.0])], 1.0)
}

/// White spheres, or in-plane fibres.
fn bodies(fibres: bool) -> Sheet {
    let spheres = Sheet { surface: OWN, ..Sheet::spheres(1.0, Target::Body(0.3), HEIGHT) };
    if fibres {
        Sheet { sizes: Sheet::fibres(1.0, None, Target::Body(0.3), HEIGHT).sizes, ..spheres }
    } else {
        spheres
    }
}

/// White bodies at gamma free paths.
fn sheet(shape: f64, fibres: bool) -> StatisticalUniverse {
    let sheet = bodies(fibres);
    let mut layer = sheet.population(0.0);
    (layer.grace, layer.density) = (Some(law(shape)), vec![0.0]);
    StatisticalUniverse::new(vec![layer], sheet.rules())
}

/// A second implementation, white bodies only: `always` takes the law of surfaces for every path.
struct Double {
    grace: Grace,
    kind: Kind,
    always: bool,
}

#[derive(Clone, Copy, Default)]
struct Here {
    from_surface: bool,
    next: Option<(Option<f64>, Option<Encounter>)>,
}

impl Universe for Double {
    type Memory = ();
    type Place = Here;
    fn forget(&self, _: &mut ()) {}
    fn enter(&self, _: &Ray, _: &mut (), _: &mut Stream) -> Start<Here> {
        Start { place: Here { from_surface: self.always, next: None }, medium: AIR }
    }
    fn next(&self, ray: &Ray, place: &mut Here, _: &mut (), limit: f64, rng: &mut Stream) -> Next {
        let (edge, face) = plane_ahead(ray, HEIGHT, 0.0);
        if place.next.is_none() {
            let free = self.grace.free_path(place.from_surface, rng);
            let found = (free < edge.min(limit)).then(|| {
                loop {
                    if let Some(e) = self.kind.candidate(ray.dir, ray.at(free), 0, rng) {
                        return e;
                    }
                }
            });
            place.next = Some((found.map(|_| free), found));
        }
        match place.next {
            Some((Some(distance), Some(met))) => Next::Interface(Interface {
                distance,
                normal: met.outward,
                facet: met.outward,
                axis: DVec3::ZERO,
                beyond: SOLID,
                surface: OWN,
                body: BodyId(1),
            }),
            _ if edge <= limit => Next::Edge { face, distance: edge },
            _ => Next::Limit,
        }
    }
    fn moved(&self, _: &Ray, place: &mut Here, _: &mut (), _: f64) {
        *place = Here { from_surface: self.always, next: None };
    }
    fn reflected(&self, _: &Ray, place: &mut Here, _: &mut (), _: &Interface) {
        *place = Here { from_surface: true, next: None };
    }
    fn crossed(&self, _: &mut Ray, _: &mut Here, _: &mut (), _: &Interface) {
        unreachable!("opaque");
    }
}

/// Air that scatters (or not) between white bodies.
fn white(mu_s: f64) -> lightpro::lpm::Light<1> {
    let mut light = light(Medium::clear(1.0), Some(opaque_lambertian(1.0)));
    light.media[0] = Medium::clear(1.0).with([0.0], mu_s, Phase::Isotropic);
    light
}

/// Gamma free paths of shape 3 keep the mean path 2H, with and without events between the surfaces;
/// the law of surfaces taken for every path breaks it.
#[test]
fn mean_path_is_twice_the_thickness() {
    let source = diffuse(HEIGHT);
    for mu_s in [0.0, 0.2] {
        let real = run(&sheet(3.0, false), &white(mu_s), &source, HEIGHT, 1_000_000);
        let kind = bodies(false).kind();
        let double = |always| Double { grace: law(3.0), kind: kind.clone(), always };
        let right = run(&double(false), &white(mu_s), &source, HEIGHT, 1_000_000);
        let wrong = run(&double(true), &white(mu_s), &source, HEIGHT, 1_000_000);
        let paths = [real.path(AIR), right.path(AIR), wrong.path(AIR)];
        println!(
            "µs = {mu_s}: path (2H = 20): universe {:?}, second implementation {:?}, surface law everywhere {:?}",
            paths[0], paths[1], paths[2]
        );
        println!("          R {:?} {:?} {:?}", real.r(), right.r(), wrong.r());
        for (got, se) in &paths[..2] {
            assert!((got - 2.0 * HEIGHT).abs() < 4.0 * se, "{got} ± {se}");
        }
        let (got, se) = paths[2];
        assert!((got - 2.0 * HEIGHT).abs() > 20.0 * se, "surface law everywhere: {got} ± {se}");
        let (a, b) = (real.r(), right.r());
        assert!((a.0 - b.0).abs() < 4.0 * a.1.hypot(b.1));
        // Collisions: 2H over the mean free path between surfaces, without other events in between.
        let (got, se) = real.interfaces();
        assert!((got - 2.0 * HEIGHT / MEAN).abs() < 4.0 * se, "collisions {got} ± {se}");
    }
}

/// In-plane fibres at a free path that does not depend on direction are not reciprocal: Σ(u) of such
/// fibres is larger across the sheet than along it, and the mean path is no longer 2H, with any law.
#[test]
fn direction_blind_paths_suit_isotropic_bodies_only() {
    for shape in [1.0, 3.0] {
        let (got, se) = run(&sheet(shape, true), &white(0.0), &diffuse(HEIGHT), HEIGHT, 300_000).path(AIR);
        println!("in-plane fibres, gamma of shape {shape}: path {got:.3} ± {se:.3}, 2H = 20");
        assert!((0.85..0.98).contains(&(got / (2.0 * HEIGHT))), "{got}");
    }
}

/// Shape 1 is the exponential law: the sheet is that of the density with the same mean free path
/// (isotropic: spheres).
#[test]
fn exponential_law_is_the_density() {
    let spheres = Sheet {
        surface: OWN,
        ..Sheet::spheres(1.0, Target::Density(1.0 / (MEAN * std::f64::consts::PI)), HEIGHT)
    };
    let mut layer = spheres.population(0.0);
    layer.grace = Some(law(1.0));
    let rules = spheres.rules();
    let grace =
        run(&StatisticalUniverse::new(vec![layer], rules), &white(0.1), &diffuse(HEIGHT), HEIGHT, 500_000);
    let plain = run(&spheres.build(), &white(0.1), &diffuse(HEIGHT), HEIGHT, 500_000);
    println!("R by law {:?}, by density {:?}", grace.r(), plain.r());
    let (a, b) = (grace.r(), plain.r());
    assert!((a.0 - b.0).abs() < 4.0 * a.1.hypot(b.1));
}

/// The equilibrium law itself: P(s > x) = (1/s̄) ∫_x^∞ P(free path > t) dt; for gamma of shape 3 and scale
/// c it is e^(−x/c) (1 + 2x/(3c) + x²/(6c²)).
#[test]
fn equilibrium_law() {
    let (grace, mut rng) = (law(3.0), stream(9));
    let c = MEAN / 3.0;
    let mut sample = |from| {
        let mut s: Vec<f64> = (0..300_000).map(|_| grace.free_path(from, &mut rng)).collect();
        s.sort_by(f64::total_cmp);
        s
    };
    let equilibrium = |x: f64| {
        let t = x / c;
        1.0 - (-t).exp() * (1.0 + 2.0 * t / 3.0 + t * t / 6.0)
    };
    let surface = |x: f64| {
        let t = x / c;
        1.0 - (-t).exp() * (1.0 + t + t * t / 2.0)
    };
    let p = [ks_p_value(&sample(false), equilibrium), ks_p_value(&sample(true), surface)];
    println!("equilibrium p {:.4}, surface p {:.4}", p[0], p[1]);
    assert!(p.iter().all(|p| *p > sidak(1e-3, 2)), "{p:?}");
}
