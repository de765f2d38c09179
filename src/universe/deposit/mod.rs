//! Deposited sheets: fibres fall one by one on the forming sheet and bend over what lies below.
//!
//! The model is of the KCL-PAKKA family (Niskanen & Alava, Phys. Rev. Lett. 73, 1994, 3475; Nilsen,
//! Zabihian & Niskanen, TAPPI J. 81(5), 1998, 163). In a laterally periodic cell, fibres come down in
//! random order at random places and azimuths. A fibre comes to lie on the lowest course along which it
//! touches nothing and rises or falls by no more than its **flexibility** F = |dz/ds| allows. Of several
//! **places** drawn it takes the one where the sheet stands lowest, as drainage carries fibres to thin spots.
//! **Pressing** flattens sections before: lumens give way, walls keep their area. Fillers go into the pores
//! that are left.
//!
//! A fibre is a chain of [`SlantedCylinder`](super::shape::SlantedCylinder)s with common end sections:
//! its volume is exact, it overlaps neither itself nor, by construction, another. The support is read off a
//! height map that holds in each lateral element the highest point over the *whole* element, and each fibre's
//! underside is taken at its lowest there.

mod ensemble;
mod fibre;
mod fill;
mod ground;
mod measure;
mod solids;

pub use ensemble::Deposited;
pub use fibre::Fibre;
pub use fill::Particle;
pub use measure::Figures;

use super::statistical::kind::{Kind, Sizes};
use super::statistical::section::Body;
use super::synthetic::{self, Part, Search, Setting, SyntheticUniverse};
use super::{MediumId, Overlap};
use crate::math::PI;
use crate::rng::{Purpose, Stream};
use fibre::Blank;
use ground::Ground;
use thiserror::Error as ThisError;

/// How much of a kind lies on an area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amount {
    /// Volume of solid over area, µm.
    Solid(f64),
    /// Volume of whole bodies as drawn, lumens included, over area, µm.
    Body(f64),
    /// Length of fibres over area, 1/µm.
    Length(f64),
    /// Number over area, 1/µm².
    Number(f64),
}

impl Amount {
    fn wanted(self) -> f64 {
        match self {
            Amount::Solid(x) | Amount::Body(x) | Amount::Length(x) | Amount::Number(x) => x,
        }
    }
}

/// A sheet to be deposited.
#[derive(Clone, Debug)]
pub struct Deposit {
    /// Kinds of bodies; fibres have a length.
    pub kinds: Vec<Kind>,
    /// How much of each.
    pub amounts: Vec<Amount>,
    /// Medium between the bodies.
    pub pore: MediumId,
    /// Edge of the square cell that repeats itself, µm.
    pub cell: f64,
    /// Steepest course of a fibre, |dz/ds|.
    pub flexibility: f64,
    /// Height of a fibre's section over that as drawn, in (0, 1]; not below its bare wall.
    pub pressing: f64,
    /// Places tried for a fibre, which comes down where the sheet stands lowest below it: drainage carries fibres
    /// to thin spots. 1: anywhere at random.
    pub places: u32,
}

/// A sheet that cannot be deposited.
#[derive(Clone, Debug, PartialEq, ThisError)]
pub enum DepositError {
    /// Parameters out of range.
    #[error("the cell must be positive, flexibility not negative, pressing in (0, 1], one amount per kind")]
    Setting,
    /// Fibres without end.
    #[error("kind {0}: fibres without end cannot fall on a sheet; give a length")]
    Endless(usize),
    /// The cell is too small for the amount to be met.
    #[error(
        "kind {kind}: {got:.3e} instead of {wanted:.3e} per area lies in the cell, more than 1 % off; a larger cell{more}"
    )]
    Amount {
        /// Which kind.
        kind: usize,
        /// Placed.
        got: f64,
        /// Asked for.
        wanted: f64,
        /// Further advice.
        more: &'static str,
    },
    /// No parameter makes the sheet as thick as wanted.
    #[error(
        "no {what} makes the sheet {wanted:.2} um thick: {from:.2} um at {what} {low}, {to:.2} um at {what} {high}"
    )]
    Thickness {
        /// The parameter that was sought.
        what: &'static str,
        /// µm.
        wanted: f64,
        /// µm at `low`.
        from: f64,
        /// Its end.
        low: f64,
        /// µm at `high`.
        to: f64,
        /// Its other end.
        high: f64,
    },
    /// Bodies that make no universe.
    #[error(transparent)]
    Parts(#[from] synthetic::Error),
}

/// Height of the plane on which the sheet forms over the plane z = 0 where it ends for light, µm.
pub const CLEAR: f64 = 0.1;
/// Edge of an element of the height map, µm, about.
const PITCH: f64 = 1.0;

/// A deposited realisation.
#[derive(Clone, Debug)]
pub struct Laid {
    /// Fibres in the order in which they fell.
    pub fibres: Vec<Fibre>,
    /// Particles.
    pub particles: Vec<Particle>,
    /// Edge of the cell, µm.
    pub cell: f64,
    /// Mean thickness: height of the uppermost surface less that of the lowest one over every point of the
    /// cell (0 where nothing lies), averaged, µm.
    pub thickness: f64,
    /// Highest point of a body, µm.
    pub top: f64,
    /// Share of the cell over which something lies.
    pub covered: f64,
    /// Fibres cut to three cells.
    pub cut: usize,
    /// Per kind: what lies per area, in the terms of its amount.
    pub laid: Vec<f64>,
}

/// What was drawn of a kind.
#[derive(Default)]
struct Drawn {
    /// Over area, in the terms of its amount.
    laid: f64,
    /// Fibres cut to three cells.
    cut: usize,
}

impl Deposit {
    fn check(&self) -> Result<(), DepositError> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if !positive(self.cell)
            || !positive(self.pressing)
            || self.pressing > 1.0
            || self.flexibility.is_nan()
            || self.flexibility < 0.0
            || self.amounts.len() != self.kinds.len()
        {
            return Err(DepositError::Setting);
        }
        let endless = |k: &Kind| matches!(k.sizes(), Sizes::Fibre { length: None, .. });
        self.kinds.iter().position(endless).map_or(Ok(()), |i| Err(DepositError::Endless(i)))
    }

    /// Bodies of kind `i` up to its amount: the last fibre is cut to what is missing, a particle too many left
    /// out if that comes closer. Fibres are cut to three cells: images farther away could not be told apart.
    fn draw(&self, i: usize, rng: &mut Stream, mut keep: impl FnMut(Body, &mut Stream)) -> Drawn {
        let (kind, amount) = (&self.kinds[i], self.amounts[i]);
        let area = self.cell * self.cell;
        let wanted = amount.wanted() * area;
        let by_length = kind.is_fibre() && !matches!(amount, Amount::Number(_));
        let mut drawn = Drawn::default();
        while drawn.laid < wanted {
            let mut body = kind.draw(rng);
            if kind.is_fibre() && body.ends > 1.5 * self.cell {
                body.ends = 1.5 * self.cell;
                drawn.cut += 1;
            }
            let (mine, left) = (measure_of(amount, kind, &body), wanted - drawn.laid);
            if by_length && mine > left {
                body.ends *= left / mine;
                // What is shorter than wide is no fibre.
                if body.ends > body.outer.a {
                    drawn.laid += left;
                    keep(body, rng);
                }
                break;
            }
            if 0.5 * mine > left {
                break;
            }
            drawn.laid += mine;
            keep(body, rng);
        }
        drawn.laid /= area;
        drawn
    }

    /// Deposits the realisation number `realisation`. The draws do not depend on flexibility and pressing.
    ///
    /// # Errors
    /// [`DepositError`].
    pub fn lay(&self, seed: u64, realisation: u64) -> Result<Laid, DepositError> {
        self.check()?;
        let mut blanks: Vec<(u64, Blank)> = Vec::new();
        let mut laid = vec![0.0; self.kinds.len()];
        let mut cut = 0;
        for (i, kind) in self.kinds.iter().enumerate().filter(|(_, k)| k.is_fibre()) {
            let mut rng = Stream::of(seed, realisation, i as u64, Purpose::Realisation);
            let drawn = self.draw(i, &mut rng, |body, rng| {
                let blank = Blank::new((i, kind), body, self, rng);
                blanks.push((rng.bits(), blank));
            });
            laid[i] = drawn.laid;
            cut += drawn.cut;
        }
        blanks.sort_by_key(|b| b.0);
        let mut ground = Ground::new(self.cell, PITCH);
        let fibres: Vec<Fibre> = blanks
            .into_iter()
            .map(|(_, blank)| {
                let fibre = blank.settle(&ground, self.flexibility);
                ground.raise(&fibre);
                fibre
            })
            .collect();
        let mut sheet = Laid {
            top: fibres.iter().map(Fibre::top).fold(CLEAR, f64::max),
            thickness: ground.thickness(),
            covered: ground.covered(),
            fibres,
            particles: Vec::new(),
            cell: self.cell,
            cut,
            laid,
        };
        fill::fill(self, &ground, &mut sheet, seed, realisation);
        Ok(sheet)
    }

    /// Whether all amounts are met within 1 %.
    ///
    /// # Errors
    /// [`DepositError::Amount`]: the first one that is not.
    pub fn met(&self, laid: &Laid) -> Result<(), DepositError> {
        for (kind, (amount, &got)) in self.amounts.iter().zip(&laid.laid).enumerate() {
            let wanted = amount.wanted();
            if (got - wanted).abs() > 0.01 * wanted {
                let more =
                    if self.kinds[kind].is_fibre() { "" } else { ", or fewer particles: the pores are full" };
                return Err(DepositError::Amount { kind, got, wanted, more });
            }
        }
        Ok(())
    }

    /// The universe of a realisation, its planes at z = 0 and `top`.
    ///
    /// # Errors
    /// [`DepositError::Parts`].
    pub fn universe(&self, laid: &Laid, top: f64) -> Result<SyntheticUniverse, DepositError> {
        let setting = Setting {
            // Joints within a fibre part nothing, whatever its surface.
            overlap: Overlap::Union,
            sheet: Some([0.0, top]),
            period: Some([self.cell; 2]),
            search: Search::Automatic,
        };
        Ok(SyntheticUniverse::with(self.pore, self.parts(laid), setting)?)
    }

    /// The regions of all bodies.
    pub fn parts(&self, laid: &Laid) -> Vec<Part> {
        let fibres = laid.fibres.iter().flat_map(|f| f.parts(&self.kinds[f.kind]));
        let particles = laid.particles.iter().flat_map(|p| p.parts(&self.kinds[p.kind]));
        fibres.chain(particles).collect()
    }

    /// The same sheet with one parameter chosen so that the mean of `realisations` realisations is `wanted` µm
    /// thick, within 0.2 %: the flexibility (between 0 and 2), or the pressing (between 0.05 and 1).
    ///
    /// # Errors
    /// [`DepositError::Thickness`] where none is.
    pub fn to_thickness(
        &self,
        wanted: f64,
        sought: Sought,
        seed: u64,
        realisations: u64,
    ) -> Result<Deposit, DepositError> {
        let bare = Deposit { kinds: self.kinds.clone(), ..self.clone() };
        let with = |x: f64| {
            let mut d = bare.clone();
            match sought {
                Sought::Flexibility => d.flexibility = x,
                Sought::Pressing => d.pressing = x,
            }
            d
        };
        let thickness = |x: f64| -> Result<f64, DepositError> {
            let d = with(x);
            let mut sum = 0.0;
            for r in 0..realisations {
                sum += d.lay_fibres(seed, r)?;
            }
            Ok(sum / realisations as f64)
        };
        let (what, mut low, mut high) = match sought {
            Sought::Flexibility => ("flexibility", 0.0, 2.0),
            Sought::Pressing => ("pressing", 0.05, 1.0),
        };
        let (from, to) = (thickness(low)?, thickness(high)?);
        let (mut at_low, mut at_high) = (from, to);
        if !(from.min(to)..=from.max(to)).contains(&wanted) {
            return Err(DepositError::Thickness { what, wanted, from, low, to, high });
        }
        for round in 0..40 {
            // False position, with a bisection every third time.
            let share = if round % 3 == 2 { 0.5 } else { (wanted - at_low) / (at_high - at_low) };
            let x = low + (high - low) * share.clamp(0.02, 0.98);
            let t = thickness(x)?;
            if (t / wanted - 1.0).abs() < 0.002 {
                return Ok(with(x));
            }
            if (t > wanted) == (at_low > wanted) { (low, at_low) = (x, t) } else { (high, at_high) = (x, t) }
        }
        Ok(with(0.5 * (low + high)))
    }

    /// Mean thickness without fillers (they lie in pores and add none).
    fn lay_fibres(&self, seed: u64, realisation: u64) -> Result<f64, DepositError> {
        let amount = |i: usize| if self.kinds[i].is_fibre() { self.amounts[i] } else { Amount::Number(0.0) };
        let amounts = (0..self.kinds.len()).map(amount).collect();
        Ok(Deposit { amounts, ..self.clone() }.lay(seed, realisation)?.thickness)
    }
}

/// What [`Deposit::to_thickness`] may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sought {
    /// The flexibility.
    Flexibility,
    /// The pressing.
    Pressing,
}

/// One body in the terms of an amount.
fn measure_of(amount: Amount, kind: &Kind, body: &Body) -> f64 {
    let length = if body.ends.is_finite() { 2.0 * body.ends } else { 1.0 };
    let content = length * body.outer.content();
    match amount {
        Amount::Solid(_) => content - length * body.lumen.map_or(0.0, |l| l.content()),
        Amount::Body(_) => content,
        Amount::Length(_) if kind.is_fibre() => length,
        Amount::Length(_) | Amount::Number(_) => 1.0,
    }
}

/// A section pressed to `pressing` of its height b: width a stays, the wall keeps its area with an even
/// thickness t, t² − (a + b')t + A/π = 0; where it fills the section, b' = A/(π a) and no lumen is left.
/// Returns b' and the lumen's half axes.
fn pressed(a: f64, b: f64, lumen: Option<(f64, f64)>, pressing: f64) -> (f64, Option<(f64, f64)>) {
    let Some((la, lb)) = lumen else { return (b, None) };
    if pressing >= 1.0 {
        return (b, lumen);
    }
    let wall = a * b - la * lb; // A/π
    let height = pressing * b;
    if wall >= 0.999 * a * height {
        return (wall / a, None);
    }
    let half = 0.5 * (a + height);
    let t = half - (half * half - wall).sqrt();
    (height, Some((a - t, height - t)))
}

/// Area of an ellipse, µm².
fn ellipse(a: f64, b: f64) -> f64 {
    PI * a * b
}
