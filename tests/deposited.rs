//! Deposited sheets: fibres that fall and bend, and light in them.
#![allow(missing_docs, clippy::disallowed_methods)]

#[path = "deposited/light.rs"]
mod light;
#[path = "deposited/structure.rs"]
mod structure;

use lightpro::law::{Azimuth, Roll, SizeLaw, Tilt};
use lightpro::universe::deposit::{Amount, Deposit};
use lightpro::universe::statistical::kind::{Kind, Sizes};
use lightpro::universe::{BodyId, MediumId, SurfaceId};

pub const AIR: MediumId = MediumId(0);
pub const WALL: MediumId = MediumId(1);

/// Bleached softwood kraft as in `distributions/pulp/bleached-softwood-kraft.xml`.
pub fn kraft() -> Kind {
    let sizes = Sizes::Fibre {
        width: SizeLaw::lognormal(29.1, 0.25).unwrap(),
        flatness: SizeLaw::truncated_normal(0.3, 0.08, 0.1, 0.8).unwrap(),
        wall: Some(SizeLaw::lognormal(2.25, 0.3).unwrap()),
        length: Some(SizeLaw::lognormal(1990.0 * (-0.25_f64).exp(), 0.5).unwrap()),
    };
    Kind::new(sizes, Azimuth::Uniform, Tilt::InPlane, Roll::Flat, WALL, AIR, SurfaceId::SMOOTH, BodyId(1))
}

/// Such fibres of `grammage` g/m² at 1500 kg/m³.
pub fn sheet(grammage: f64, cell: f64) -> Deposit {
    Deposit {
        kinds: vec![kraft()],
        amounts: vec![Amount::Solid(grammage / 1.5)],
        pore: AIR,
        cell,
        flexibility: 0.5,
        pressing: 1.0,
        places: 16,
    }
}
