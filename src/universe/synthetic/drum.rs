//! Bodies that fill a sheet without end, made as a ray needs them.
//!
//! Light guided in fibres travels over thousands of radii sideways, and no box around unbounded
//! fibres is without bias. So the fibres of one **realisation** of a Poisson (Boolean) ensemble are
//! ordered by the distance ρ at which they come closest to the z axis within the sheet, and generated
//! in annuli R_k ≤ ρ < R_(k+1), each from a random stream of its own, keyed by (seed, realisation,
//! kind, k): what a ray finds does not depend on which ray asked first. A worker keeps the annuli that
//! it has generated, and lists of their fibres in the cells of a grid, in its [`Grown`] memory.
//!
//! An **ensemble** ([`Boolean::ensemble`]) draws a realisation for each history, or for each run of
//! histories that share their memory; each of these meets it at a place of its own.
//!
//! Lines of direction u and density ν (length over volume) have the measure ν dp dq over the plane
//! across u. With p along the horizontal normal and H' the thickness (widened by the largest body
//! radius), all that come within R lie in |p| < R, |q| < ½ H' cos τ + R |sin τ|, τ the tilt.

use super::flight::{self, Ahead, Asker, Space};
use super::grid::{Item, Lattice, Lists, Walk};
use super::place::{Displaced, Group, MOST_TRIES, Place};
use super::realise::{Boolean, RealiseError, is_endless, is_level, parts_of};
use super::region::{Extent, Hull, Key, MOST, Region, Rule, pair_hollows};
use super::{Part, next_in};
use crate::math::DVec3;
use crate::rng::{Purpose, Stream};
use crate::universe::statistical::kind::Kind;
use crate::universe::statistical::section::Body;
use crate::universe::{Interface, MediumId, Next, Ray, Start, Universe};
use std::collections::HashMap;

/// Cells along the side of a tile, as a power of two.
const TILE_BITS: i32 = 4;
const TILE: i32 = 1 << TILE_BITS;
/// Tiles kept at a time; beyond, all are dropped (the fibres stay).
const MOST_TILES: usize = 4096;
/// Cells from the axis beyond which nothing is searched.
const FAR: u32 = 1 << 28;

/// One realisation of a Boolean sheet, unbounded sideways; what has been generated of it lies in the
/// [`Grown`] memory of each worker.
#[derive(Clone, Debug)]
pub struct Drum {
    model: Boolean,
    seed: u64,
    /// `None`: drawn.
    realisation: Option<u64>,
    /// Histories are displaced within ± this, µm.
    spread: f64,
    from_pores: bool,
    /// Largest half width of a body (half size where it has an end), µm.
    widest: f64,
    /// How far above and below the sheet the centre of a body of each kind may stand, µm.
    margins: Vec<f64>,
    lattice: Lattice,
    layers: i32,
    /// Radius of the first annulus, µm; each next one reaches 1.5 times as far.
    first: f64,
    print: u64,
}

/// Where histories meet a realisation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entry {
    /// Each history is displaced at random within ± this, µm, along x and y; `None`: forty mean
    /// thicknesses of the bodies.
    pub spread: Option<f64>,
    /// Where it comes into a body it is displaced again: light starts in pores.
    pub from_pores: bool,
}

/// Bodies of a [`Drum`] generated so far.
#[derive(Default, Debug)]
pub struct Grown {
    /// Seed, realisation and print of the drum.
    of: Option<[u64; 3]>,
    regions: Vec<Region>,
    /// Of the bodies (hollows excepted), as are the extents.
    hulls: Vec<Hull>,
    extents: Vec<Extent>,
    annuli: u32,
    radius: f64,
    tiles: HashMap<[i32; 2], u32>,
    lists: Vec<Lists>,
}

impl Grown {
    /// Radius up to which all bodies that come within it are known, µm.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Bodies generated so far.
    pub fn bodies(&self) -> usize {
        self.extents.len()
    }
}

impl Drum {
    /// The realisation number `realisation` of `model`.
    ///
    /// # Errors
    /// [`RealiseError`] where the model cannot be realised.
    pub fn new(model: &Boolean, seed: u64, realisation: u64) -> Result<Self, RealiseError> {
        Self::made(model, seed, Some(realisation), Entry { spread: Some(0.0), from_pores: false })
    }

    /// All realisations of `model`.
    ///
    /// # Errors
    /// [`RealiseError`] where the model cannot be realised.
    pub fn ensemble(model: &Boolean, seed: u64, entry: Entry) -> Result<Self, RealiseError> {
        Self::made(model, seed, None, entry)
    }

    fn made(
        model: &Boolean,
        seed: u64,
        realisation: Option<u64>,
        entry: Entry,
    ) -> Result<Self, RealiseError> {
        model.check()?;
        let (widest, thickness) = model.widths();
        let [bottom, top] = model.sheet;
        let height = top - bottom;
        let layers = (height / thickness).round().clamp(1.0, 1e4);
        let size = DVec3::new(thickness, thickness, height * 1.002 / layers);
        let origin = DVec3::new(0.0, 0.0, bottom - 0.001 * height);
        let mut print = 0xcbf2_9ce4_8422_2325_u64;
        for x in model.density.iter().chain([&bottom, &top, &widest, &thickness]) {
            print = (print ^ x.to_bits()).wrapping_mul(0x0100_0000_01b3);
        }
        Ok(Drum {
            model: model.clone(),
            seed,
            realisation,
            spread: entry.spread.unwrap_or(40.0 * thickness),
            from_pores: entry.from_pores,
            widest,
            margins: (0..model.kinds.len()).map(|i| model.bounds(i).height).collect(),
            lattice: Lattice::new(origin, size),
            layers: layers as i32,
            first: 24.0 * thickness + widest,
            print,
        })
    }

    /// Medium that a ray is in where [`Universe::enter`], `moved`, `crossed` or `reflected` left it.
    pub fn medium(&self, place: &Displaced, memory: &Grown) -> MediumId {
        self.rule().owner(place.place.inside.items(), |k| &memory.regions[k.region()]).medium
    }

    fn rule(&self) -> Rule {
        Rule { overlap: self.model.overlap, ambient: self.model.pore }
    }

    /// How bodies are searched, in words.
    pub fn describe_search(&self) -> String {
        format!(
            "drum that grows ahead of the rays, grid cells of {:.3} µm, {} over the thickness, histories within \
             ± {:.0} µm",
            self.lattice.size.x, self.layers, self.spread
        )
    }

    /// The Boolean sheet.
    pub fn model(&self) -> &Boolean {
        &self.model
    }

    /// The sheet's lower and upper plane, µm.
    pub fn planes(&self) -> [f64; 2] {
        self.model.sheet
    }

    /// Seed of its realisations.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Histories are displaced within ± this, µm.
    pub(super) fn spread(&self) -> f64 {
        self.spread
    }

    /// What tells realisations of different models apart.
    pub(super) fn print(&self) -> u64 {
        self.print
    }

    /// Radius of the disc in which about `count` bodies come together, µm; at least that of the first
    /// annulus.
    pub fn radius_of(&self, count: f64) -> f64 {
        let per = |r: f64| -> f64 {
            let each = (0..self.model.kinds.len()).map(|i| {
                let height = self.model.sheet[1] - self.model.sheet[0];
                let area = match is_endless(&self.model.kinds[i]) {
                    true => 2.0 * r,
                    false => crate::math::PI * r * r,
                };
                self.model.number(i) * area * height
            });
            each.sum()
        };
        let mut radius = self.first;
        while per(radius) < count && radius < 1e4 * self.first {
            radius *= 1.2;
        }
        radius
    }

    /// Bodies of a realisation that come within `radius` (µm) of the z axis, and more; each with its
    /// hollow, in ascending rank.
    pub fn bodies(&self, seed: u64, realisation: u64, radius: f64) -> Vec<(Part, Option<Part>)> {
        let mut grown = Grown { of: Some([seed, realisation, self.print]), ..Grown::default() };
        self.grow(&mut grown, radius);
        let mut outer: Vec<&Region> = grown.regions.iter().filter(|r| !r.is_hole()).collect();
        outer.sort_by_key(|r| r.rank);
        outer.into_iter().map(|r| (r.part, r.hollow().map(|h| grown.regions[h as usize].part))).collect()
    }

    /// Has `memory` hold the realisation number `realisation`.
    pub(super) fn hold(&self, memory: &mut Grown, realisation: u64) {
        let key = Some([self.seed, realisation, self.print]);
        if memory.of != key {
            *memory = Grown { of: key, ..Grown::default() };
        }
    }

    /// A ray that comes in at `shift` from where it seems to.
    pub(super) fn stand(&self, ray: &Ray, shift: DVec3, memory: &mut Grown) -> Start<Displaced> {
        let mut here = Displaced { place: Place::new(*ray), shift };
        here.place = flight::start(&mut self.view(memory), &here.shifted(ray));
        // More bodies than can be numbered: nothing is right from here on.
        here.place.lost |= memory.regions.len() >= MOST;
        Start { place: here, medium: self.medium(&here, memory) }
    }

    fn view<'a>(&'a self, grown: &'a mut Grown) -> Growing<'a> {
        Growing { drum: self, grown }
    }

    /// Generates annuli until all bodies within `radius` of the z axis are known.
    fn grow(&self, grown: &mut Grown, radius: f64) {
        let Some([seed, realisation, _]) = grown.of else { return };
        while grown.radius < radius {
            let (from, to) = match grown.annuli {
                0 => (0.0, self.first),
                k => (self.reach(k), self.reach(k + 1)),
            };
            for i in 0..self.model.kinds.len() {
                let stream = u64::from(grown.annuli) << 16 | i as u64;
                let mut rng = Stream::of(seed, realisation, stream, Purpose::Realisation);
                self.annulus(grown, i, [from, to], &mut rng);
            }
            grown.annuli += 1;
            grown.radius = to - self.widest;
        }
    }

    /// Outer radius of the first k annuli.
    fn reach(&self, k: u32) -> f64 {
        (1..k).fold(self.first, |r, _| 1.5 * r)
    }

    /// Bodies of one kind that come closest to the axis between two radii.
    fn annulus(&self, grown: &mut Grown, i: usize, [from, to]: [f64; 2], rng: &mut Stream) {
        let (kind, number) = (&self.model.kinds[i], self.model.number(i));
        let [bottom, top] = self.model.sheet;
        let height = top - bottom + 2.0 * self.margins[i];
        let middle = DVec3::new(0.0, 0.0, 0.5 * (bottom + top));
        let (endless, level) = (is_endless(kind), is_level(kind));
        let (width, depth) = match (endless, level) {
            // Uniform in the square around the disc.
            (false, _) => (2.0 * to, 2.0 * to * height),
            (true, true) => (2.0 * (to - from), height),
            (true, false) => (2.0 * to, (height * height + 4.0 * to * to).sqrt()),
        };
        let mut arrivals = rng.exponential();
        while arrivals < number * width * depth {
            arrivals += rng.exponential();
            let mut body = kind.draw(rng);
            let rank = (rng.bits() >> 32) as u32;
            let [u1, u2] = [rng.uniform(), rng.uniform()];
            let centre = if !endless {
                let at = DVec3::new(2.0 * u1 - 1.0, 2.0 * u2 - 1.0, 0.0) * to;
                Some(at + DVec3::Z * (height * (rng.uniform() - 0.5)))
            } else if level {
                let p = (2.0 * u1 - 1.0) * (to - from);
                let normal = DVec3::new(-body.frame.z.y, body.frame.z.x, 0.0);
                Some(normal * (p + from.copysign(p)) + DVec3::Z * (height * (u2 - 0.5)))
            } else {
                tilted(body.frame.z, to, [2.0 * u1 - 1.0, (u2 - 0.5) * depth], height)
            };
            let Some(centre) = centre else { continue };
            body.centre = middle + centre;
            let closest = (centre.x * centre.x + centre.y * centre.y).sqrt();
            if (from..to).contains(&closest) && self.model.stands(kind, &body, rng) {
                add(grown, kind, &body, rank);
            }
        }
    }

    /// The lists of a tile's cells, made when first asked for.
    fn tile(&self, grown: &mut Grown, tile: [i32; 2]) -> u32 {
        if let Some(&number) = grown.tiles.get(&tile) {
            return number;
        }
        let size = self.lattice.size;
        let corner = |k: i32, s: f64| f64::max((f64::from(k) * s).abs(), (f64::from(k + 1) * s).abs());
        let far = DVec3::new(
            corner(tile[0], size.x * f64::from(TILE)),
            corner(tile[1], size.y * f64::from(TILE)),
            0.0,
        );
        self.grow(grown, far.length() + 0.01 * size.x);
        if grown.lists.len() >= MOST_TILES {
            grown.tiles.clear();
            grown.lists.clear();
        }
        let lo = [tile[0] * TILE, tile[1] * TILE, 0];
        let hi = [lo[0] + TILE - 1, lo[1] + TILE - 1, self.layers - 1];
        let span = DVec3::new(f64::from(TILE), f64::from(TILE), f64::from(self.layers)) * size;
        let middle =
            self.lattice.origin + DVec3::new(f64::from(lo[0]), f64::from(lo[1]), 0.0) * size + span * 0.5;
        let near: Vec<(u32, &Extent)> =
            (0..).zip(&grown.extents).filter(|(_, e)| e.reaches(middle, span * 0.501)).collect();
        let cells = (TILE * TILE * self.layers) as usize;
        let lists = Lists::new(cells, |tell| {
            for (body, extent) in &near {
                self.lattice.cells_of(extent, lo, hi, |cell| tell(self.slot(cell), Item::new(*body, [0; 2])));
            }
        });
        let number = grown.lists.len() as u32;
        grown.lists.push(lists);
        grown.tiles.insert(tile, number);
        number
    }

    /// Number of a cell within its tile.
    #[inline]
    fn slot(&self, [x, y, z]: [i32; 3]) -> usize {
        (((y & (TILE - 1)) << TILE_BITS | (x & (TILE - 1))) * self.layers + z) as usize
    }
}

/// Where the axis of a line along `u` comes closest to the z axis within |z| < ½ `height`: the line
/// passes the origin at `p` (in units of `to`) along its horizontal normal and at `q` along the other
/// one. `None` if it does not come within `to`.
fn tilted(u: DVec3, to: f64, [p, q]: [f64; 2], height: f64) -> Option<DVec3> {
    let level = (u.x * u.x + u.y * u.y).sqrt();
    let normal = if level > 0.0 { DVec3::new(-u.y, u.x, 0.0) / level } else { DVec3::X };
    if q.abs() >= 0.5 * height * level + to * u.z.abs() {
        return None;
    }
    let at = normal * (p * to) + u.cross(normal) * q;
    // The piece of the axis between the planes, and its point closest to the z axis.
    let (lo, hi) = if u.z == 0.0 {
        (f64::NEG_INFINITY, f64::INFINITY)
    } else {
        let (a, b) = ((-0.5 * height - at.z) / u.z, (0.5 * height - at.z) / u.z);
        (a.min(b), a.max(b))
    };
    let w = if level > 0.0 { -(at.x * u.x + at.y * u.y) / (level * level) } else { 0.0 };
    Some(at + u * w.clamp(lo, hi))
}

fn add(grown: &mut Grown, kind: &Kind, body: &Body, rank: u32) {
    let first = grown.regions.len();
    for part in parts_of(kind, body) {
        grown.regions.push(Region::new(part, rank));
    }
    pair_hollows(&mut grown.regions, first);
    let shape = &grown.regions[first].part.shape;
    grown.hulls.push(Hull::of(first as u32, shape));
    grown.extents.extend(Extent::of(shape));
}

fn tile_of(cell: [i32; 3]) -> [i32; 2] {
    [cell[0] >> TILE_BITS, cell[1] >> TILE_BITS]
}

/// A drum with what has been generated of it.
struct Growing<'a> {
    drum: &'a Drum,
    grown: &'a mut Grown,
}

/// A walk through tiles.
struct Tour {
    walk: Walk,
    ahead: Ahead,
    tile: [i32; 2],
    lists: u32,
}

impl Space for Growing<'_> {
    type Cursor = Tour;

    #[inline]
    fn rule(&self) -> Rule {
        self.drum.rule()
    }
    #[inline]
    fn region(&self, number: usize) -> &Region {
        &self.grown.regions[number]
    }
    #[inline]
    fn period(&self) -> [f64; 2] {
        [0.0; 2]
    }

    fn search(&mut self, ray: &Ray) -> Tour {
        let lattice = &self.drum.lattice;
        let mut walk = Walk::new(lattice, ray, 0.0);
        walk.keep_within(lattice, ray, 2, 0, self.drum.layers - 1);
        walk.over = walk.cell[0].unsigned_abs().max(walk.cell[1].unsigned_abs()) > FAR;
        let tile = tile_of(walk.cell);
        let lists = if walk.over { 0 } else { self.drum.tile(self.grown, tile) };
        Tour { walk, ahead: Ahead::new(), tile, lists }
    }

    fn entries(&mut self, tour: &mut Tour, asker: &Asker, after: f64, group: &mut Group) {
        let ray = asker.ray;
        let mut known = tour.ahead.recall(after, group);
        while !tour.walk.over {
            let grown = &*self.grown;
            if !known {
                tour.ahead.look();
                for item in grown.lists[tour.lists as usize].of(self.drum.slot(tour.walk.cell)) {
                    let hull = &grown.hulls[item.body() as usize];
                    if !hull.missed_by(ray.origin, ray.dir) {
                        let key = Key::new(hull.region, [0; 2]);
                        let region = &grown.regions[hull.region as usize];
                        tour.ahead.try_entry(region, key, [0.0; 2], asker, after, group);
                    }
                }
            }
            known = false;
            if group.distance <= tour.walk.end() {
                return;
            }
            tour.walk.step(&self.drum.lattice, ray);
            let [x, y, z] = tour.walk.cell;
            if z < 0 || z >= self.drum.layers || x.unsigned_abs().max(y.unsigned_abs()) > FAR {
                tour.walk.over = true;
                return;
            }
            let tile = tile_of(tour.walk.cell);
            if tile != tour.tile {
                tour.tile = tile;
                tour.lists = self.drum.tile(self.grown, tile);
            }
        }
    }

    fn around(&mut self, point: DVec3, mut tell: impl FnMut(&Self, Key)) {
        let mut cell = self.drum.lattice.cell(point);
        if cell[0].unsigned_abs().max(cell[1].unsigned_abs()) > FAR {
            return;
        }
        cell[2] = cell[2].clamp(0, self.drum.layers - 1);
        let lists = self.drum.tile(self.grown, tile_of(cell));
        for item in self.grown.lists[lists as usize].of(self.drum.slot(cell)) {
            tell(self, Key::new(self.grown.hulls[item.body() as usize].region, [0; 2]));
        }
    }
}

impl Universe for Drum {
    type Memory = Grown;
    type Place = Displaced;

    /// Bodies belong to the realisation, not to the history: one that is given is kept.
    fn forget(&self, memory: &mut Grown) {
        match self.realisation {
            Some(realisation) => self.hold(memory, realisation),
            None => memory.of = None,
        }
    }

    fn share(&self, memory: &mut Grown) {
        if self.realisation.is_some() {
            self.forget(memory);
        }
    }

    fn enter(&self, ray: &Ray, memory: &mut Grown, rng: &mut Stream) -> Start<Displaced> {
        let held = memory.of.filter(|of| of[2] == self.print).map(|of| of[1]);
        let realisation = self.realisation.or(held).unwrap_or_else(|| rng.bits());
        self.hold(memory, realisation);
        let mut tries = 0;
        loop {
            let mut away = || if self.spread > 0.0 { 2.0 * rng.uniform() - 1.0 } else { 0.0 };
            let shift = DVec3::new(away(), away(), 0.0) * self.spread;
            let start = self.stand(ray, shift, memory);
            if !self.from_pores || start.place.in_pore() || tries == MOST_TRIES {
                return start;
            }
            tries += 1;
        }
    }

    fn come_back(
        &self,
        ray: &Ray,
        place: &Displaced,
        memory: &mut Grown,
        _: &mut Stream,
    ) -> Start<Displaced> {
        self.stand(ray, place.shift, memory)
    }

    #[inline]
    fn next(&self, ray: &Ray, here: &mut Displaced, memory: &mut Grown, limit: f64, _: &mut Stream) -> Next {
        let ray = here.shifted(ray);
        next_in(&mut self.view(memory), Some(self.model.sheet), &ray, &mut here.place, limit)
    }

    fn moved(&self, ray: &Ray, here: &mut Displaced, memory: &mut Grown, d: f64) {
        let ray = here.shifted(ray);
        flight::moved(&mut self.view(memory), &mut here.place, &ray, d);
    }

    fn reflected(&self, ray: &Ray, here: &mut Displaced, _: &mut Grown, _at: &Interface) {
        here.place.turn_back(here.shifted(ray));
    }

    fn crossed(&self, ray: &mut Ray, here: &mut Displaced, _: &mut Grown, _at: &Interface) {
        here.place.go_on(here.shifted(ray));
    }
}
