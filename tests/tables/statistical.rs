//! Statistical sheets: chord-length sampling, Markov mixtures and the averaged medium.

use crate::transport::*;
use lightpro::lpm::Medium;
use lightpro::phase::Phase;
use lightpro::universe::statistical::Rung;
use lightpro::universe::statistical::amount::{Rule, Target};

#[test]
fn quick() {
    use std::time::Instant;
    for rho in [1.0, 0.8] {
        let mut s = Sheet::fibres(1.0, None, Target::Body(0.3), 10.0);
        s.surface = OWN;
        let u = s.build();
        let l = light(Medium::clear(1.0), Some(opaque_lambertian(rho)));
        let t0 = Instant::now();
        let t = run(&u, &l, &diffuse(10.0), 10.0, 400_000);
        println!(
            "white CLS rho {rho} R {:?} T {:?} path {:?} coll {:?} {:?}",
            t.r(),
            t.t(),
            t.path(AIR),
            t.interfaces(),
            t0.elapsed()
        );
    }
    for (rung, name) in [(Rung::Forgetful, "LCLS"), (Rung::Markov, "MARKOV")] {
        for c in [1.0, 0.9] {
            let mut s = Sheet::fibres(1.0, None, Target::Body(0.3), 10.0);
            s.rung = rung;
            s.rule = if rung == Rung::Markov { Rule::Union } else { Rule::Apart };
            s.start_in_bodies = true;
            let u = s.build();
            let l = light(Medium::clear(1.0).with([2.0 * (1.0 - c)], 2.0 * c, Phase::Isotropic), None);
            let t = run(&u, &l, &diffuse(10.0), 10.0, 400_000);
            println!("{name} c {c} R {:?} T {:?}", t.r(), t.t());
        }
    }
    for wall in [Some(0.27), None] {
        for contained in [false, true] {
            for (name, src) in [("diffuse", diffuse(4.0)), ("normal", normal(4.0))] {
                let mut s = Sheet::fibres(1.0, wall, Target::Density(0.11353316), 4.0);
                s.contained = contained;
                s.start_in_bodies = !contained;
                let u = s.build();
                for alpha in [0.0, 0.1] {
                    let l = light(Medium::clear(1.55).with([alpha], 0.0, Phase::Isotropic), None);
                    let t0 = Instant::now();
                    let t = run(&u, &l, &src, 4.0, 400_000);
                    println!(
                        "hollow {wall:?} contained {contained} {name} a {alpha} R {:?} T {:?} wall {:?} air {:?} int {:?} {:?}",
                        t.r(),
                        t.t(),
                        t.path(SOLID),
                        t.path(AIR),
                        t.interfaces(),
                        t0.elapsed()
                    );
                }
            }
        }
    }
}
