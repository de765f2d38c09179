//! What every universe promises.

use crate::transport::*;
use crate::{down, stream};
use lightpro::law::Tilt;
use lightpro::math::DVec3;
use lightpro::universe::statistical::amount::{Rule, Target};
use lightpro::universe::statistical::{Rung, StatisticalUniverse};
use lightpro::universe::{MediumId, Next, Ray, Universe};

fn sheets() -> Vec<(&'static str, StatisticalUniverse)> {
    let hollow = |contained| Sheet {
        contained,
        start_in_bodies: !contained,
        ..Sheet::fibres(1.0, Some(0.27), Target::Body(0.3), 8.0)
    };
    vec![
        ("none, cut", hollow(false).build()),
        ("none, contained", hollow(true).build()),
        ("none, matched", Sheet { rule: Rule::Apart, ..hollow(false) }.build()),
        ("markov", Sheet { rung: Rung::Markov, ..hollow(false) }.build()),
        ("homogeneous", Sheet { rung: Rung::Homogeneous, start_in_bodies: false, ..hollow(false) }.build()),
        ("isotropic", Sheet { tilt: Tilt::Isotropic, ..hollow(false) }.build()),
        ("no bodies", plain_sheet(vec![plain(8.0, 3.0, MediumId(1)), plain(3.0, 0.0, MediumId(2))])),
        ("spheres", Sheet::spheres(1.0, Target::Body(0.2), 8.0).build()),
    ]
}

/// Random walks: asked twice, `next` answers the same; distances are not negative and within the limit;
/// normals are unit and against the ray; no ray is lost.
#[test]
fn walks_keep_the_contract() {
    for (name, universe) in sheets() {
        keeps_contract(name, &universe, 20_000);
    }
}

/// Random walks through one universe of height 8.
pub fn keeps_contract<U: Universe>(name: &str, universe: &U, walks: u64) {
    let mut memory = U::Memory::default();
    {
        let (mut events, mut worst_unit, mut roomy) = (0_u64, 0.0_f64, 0_u64);
        for number in 0..walks {
            universe.forget(&mut memory);
            let mut rng = stream(number);
            let mut ray = Ray { origin: DVec3::new(0.0, 0.0, 8.0), dir: down(1.4 * rng.uniform()) };
            let mut place = universe.enter(&ray, &mut memory, &mut rng).place;
            for _ in 0..400 {
                events += 1;
                let limit = if rng.uniform() < 0.3 { 3.0 * rng.uniform() } else { f64::INFINITY };
                let next = universe.next(&ray, &mut place, &mut memory, limit, &mut rng);
                let again = universe.next(&ray, &mut place, &mut memory, limit, &mut rng);
                assert_eq!(next, again, "{name}: asked twice");
                let (room, end) = (universe.room(&place), ray.origin.z + ray.dir.z * limit);
                let within = room.bottom < end && end < room.top;
                assert!(!within || next == Next::Limit, "{name}: {next:?} in a room");
                roomy += u64::from(within);
                match next {
                    Next::Interface(at) => {
                        assert!(
                            at.distance >= 0.0 && at.distance <= limit,
                            "{name}: distance {}",
                            at.distance
                        );
                        worst_unit = worst_unit.max((at.normal.length_squared() - 1.0).abs());
                        assert!(at.normal.dot(ray.dir) <= 1e-7, "{name}: normal along the ray");
                        ray.origin = ray.at(at.distance);
                        if rng.uniform() < 0.4 {
                            ray.dir = lightpro::material::fresnel::reflect(ray.dir, at.normal);
                            universe.reflected(&ray, &mut place, &mut memory, &at);
                        } else {
                            universe.crossed(&mut ray, &mut place, &mut memory, &at);
                        }
                    }
                    Next::Limit => {
                        ray.origin = ray.at(limit);
                        let (c, s) = rng.azimuth();
                        let z = 2.0 * rng.uniform() - 1.0;
                        let r = (1.0 - z * z).sqrt();
                        ray.dir = DVec3::new(r * c, r * s, z);
                        universe.moved(&ray, &mut place, &mut memory, limit);
                    }
                    Next::Edge { distance, .. } => {
                        assert!(distance >= 0.0 && distance <= limit);
                        let z = ray.at(distance).z;
                        assert!(!(1e-9..=8.0 - 1e-9).contains(&z), "{name}: leaves at z = {z}");
                        break;
                    }
                    Next::Lost => panic!("{name}: lost"),
                }
            }
        }
        assert_eq!(roomy > 0, name == "no bodies", "{name}: {roomy} flights in a room");
        println!("{name}: {events} events, |n|² − 1 up to {worst_unit:.1e}");
        assert!(worst_unit < 1e-12 && events > 2 * walks);
    }
}
