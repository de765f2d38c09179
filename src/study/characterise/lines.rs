//! Straight lines through a universe: chords, interfaces and directions, as stereology counts them.
//!
//! Lines enter the sheet from above, evenly over its face and by Lambert's law: together they are lines
//! isotropic and uniform in space (IUR). Nothing turns them. Along such lines
//!
//! * the share of length in a medium is its share of volume, φ = L_m/L;
//! * the area of interfaces over volume is S_V = 2 I/L (I interfaces met);
//! * the mean chord of a medium is L_m/I_m (I_m interfaces that end a chord of it) = 4φ/S_V,m; both sums take
//!   the pieces cut off by the faces, without which long chords would be missed;
//! * the survival of chords is that of Kaplan & Meier (1958, doi:10.1080/01621459.1958.10501452): chords that
//!   a face ends are censored;
//! * every element of surface is met in proportion to its area whatever its direction, so that means over
//!   interfaces are means over area.

use crate::math::{DVec3, PI, asin, ln, log10};
use crate::rng::{Purpose, Stream};
use crate::source::Source;
use crate::universe::{Next, Universe};
use rayon::prelude::*;

/// Equal classes of |cos θ|, θ from the normal of the sheet.
pub const DIRECTIONS: usize = 10;
/// Slices over the depth.
pub const SLICES: usize = 40;
/// Independent groups of lines: errors come from their spread.
pub const GROUPS: u64 = 32;
/// Classes of chords, 50 to a decade from 10⁻³ µm.
const CLASSES: usize = 450;

/// What lines have counted; all sums are over lines.
#[derive(Clone, Debug)]
pub struct Counted {
    media: usize,
    /// Length in each medium and class of direction, µm.
    pub length: Vec<[f64; DIRECTIONS]>,
    /// Interfaces that end a chord of each medium.
    pub ends: Vec<[f64; DIRECTIONS]>,
    /// Interfaces from medium (row) to medium.
    pub passed: Vec<f64>,
    /// Length in each medium by slice, from the top.
    pub depth: Vec<[f64; SLICES]>,
    /// Interfaces of bodies with an axis, by solid medium: number, Σ cos 2φ, Σ sin 2φ, Σ tilt².
    pub axes: Vec<[f64; 4]>,
    /// Interfaces between solid medium (row) and the pores: Σ of 1, n_x², n_y², n_z², n_x n_y.
    pub normals: Vec<[f64; 5]>,
    /// Chords that an interface began, by class of direction: ended by an interface, and by a face.
    chords: Vec<[[Vec<u32>; 2]; DIRECTIONS]>,
    /// Lines without an answer.
    pub lost: u64,
    /// Lines.
    pub lines: u64,
}

impl Counted {
    fn new(media: usize) -> Self {
        Counted {
            media,
            length: vec![[0.0; DIRECTIONS]; media],
            ends: vec![[0.0; DIRECTIONS]; media],
            passed: vec![0.0; media * media],
            depth: vec![[0.0; SLICES]; media],
            axes: vec![[0.0; 4]; media],
            normals: vec![[0.0; 5]; media],
            chords: vec![std::array::from_fn(|_| [vec![0; CLASSES], vec![0; CLASSES]]); media],
            lost: 0,
            lines: 0,
        }
    }

    /// Adds another group's.
    fn add(&mut self, other: &Counted) {
        fn each<const N: usize>(a: &mut [[f64; N]], b: &[[f64; N]]) {
            a.iter_mut().flatten().zip(b.iter().flatten()).for_each(|(a, b)| *a += b);
        }
        each(&mut self.length, &other.length);
        each(&mut self.ends, &other.ends);
        each(&mut self.depth, &other.depth);
        each(&mut self.axes, &other.axes);
        each(&mut self.normals, &other.normals);
        self.passed.iter_mut().zip(&other.passed).for_each(|(a, b)| *a += b);
        for (a, b) in self.chords.iter_mut().flatten().flatten().zip(other.chords.iter().flatten().flatten())
        {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        }
        self.lost += other.lost;
        self.lines += other.lines;
    }

    /// Interfaces from one medium into another.
    pub fn between(&self, from: usize, to: usize) -> f64 {
        self.passed[from * self.media + to]
    }

    /// Length of a medium, µm.
    pub fn length_of(&self, medium: usize) -> f64 {
        self.length[medium].iter().sum()
    }

    /// Length of all, µm.
    pub fn whole(&self) -> f64 {
        (0..self.media).map(|m| self.length_of(m)).sum()
    }

    /// Share of volume.
    pub fn share(&self, medium: usize) -> f64 {
        self.length_of(medium) / self.whole()
    }

    /// Mean chord, µm.
    pub fn mean_chord(&self, medium: usize) -> f64 {
        self.length_of(medium) / self.ends[medium].iter().sum::<f64>()
    }

    /// Area of all interfaces over volume, 1/µm.
    pub fn surface(&self) -> f64 {
        2.0 * self.passed.iter().sum::<f64>() / self.whole()
    }

    /// Preferred azimuth (rad) and order |⟨e^2iφ⟩| of the axes of bodies of a medium.
    pub fn order(&self, medium: usize) -> Option<(f64, f64)> {
        let [n, c, s, _] = self.axes[medium];
        (n > 0.0).then(|| (0.5 * crate::math::atan2(s, c), (c * c + s * s).sqrt() / n))
    }

    /// Root mean square tilt of the axes out of the plane, rad.
    pub fn tilt(&self, medium: usize) -> Option<f64> {
        let [n, _, _, t2] = self.axes[medium];
        (n > 0.0).then(|| (t2 / n).sqrt())
    }

    /// Survival of the chords of a medium: (length µm, share of chords that are longer), at the upper end
    /// of each class that holds any. Each direction by itself, for steep lines are cut off sooner; then
    /// the mean over the interfaces at which chords begin. Ends where the faces cut all chords of some
    /// direction.
    pub fn survival(&self, medium: usize) -> Vec<(f64, f64)> {
        let all: f64 = self.ends[medium].iter().sum();
        let mut whole = vec![0.0; CLASSES];
        for (chords, ends) in self.chords[medium].iter().zip(&self.ends[medium]) {
            let left = kaplan_meier(chords);
            whole.iter_mut().zip(left).for_each(|(w, l)| *w += l * ends / all);
        }
        let ended = |class: usize| self.chords[medium].iter().any(|c| c[0][class] > 0);
        let longest = |c: &[Vec<u32>; 2]| (0..CLASSES).rev().find(|&i| c[0][i] + c[1][i] > 0);
        let seen = self.chords[medium].iter().filter_map(longest).min().unwrap_or(0);
        (0..seen).filter(|&c| ended(c)).map(|c| (upper_end(c), whole[c])).collect()
    }
}

/// Share of chords longer than the upper end of each class.
fn kaplan_meier([ended, cut]: &[Vec<u32>; 2]) -> Vec<f64> {
    let mut at_risk: u64 = ended.iter().chain(cut).map(|&n| u64::from(n)).sum();
    let mut left = 1.0;
    let mut shares = Vec::with_capacity(CLASSES);
    for (&e, &c) in ended.iter().zip(cut) {
        let (e, c) = (u64::from(e), u64::from(c));
        if e > 0 {
            // Chords cut within the class were at risk for half of it.
            left *= 1.0 - e as f64 / (at_risk as f64 - 0.5 * c as f64).max(e as f64);
        }
        at_risk -= e + c;
        shares.push(left);
    }
    shares
}

fn class_of(length: f64) -> usize {
    (50.0 * (log10(length.max(1e-3)) + 3.0)).clamp(0.0, CLASSES as f64 - 1.0) as usize
}

/// Upper end of a class of chords, µm.
fn upper_end(class: usize) -> f64 {
    crate::math::exp((class as f64 + 1.0) * (ln(10.0) / 50.0)) * 1e-3
}

/// Lines through a universe.
#[derive(Clone, Copy, Debug)]
pub struct Lines {
    /// How many.
    pub number: u64,
    /// Lines that share a realisation.
    pub shared: u64,
    /// Seed.
    pub seed: u64,
    /// How far sideways a line goes, µm; may be infinite. Then it goes on at its height as far on the other side of the
    /// place where it came in, for between the two the bodies are known, and the chord that it is on is cut, as
    /// by a face. An even sheet is the same everywhere, so that nothing is biased by it, and level lines need
    /// no bodies for miles around.
    pub reach: f64,
}

/// What lines through `universe` meet between the planes `bottom` and `top` (µm), group by group.
pub fn measure<U: Universe>(
    universe: &U,
    [bottom, top]: [f64; 2],
    media: usize,
    lines: Lines,
) -> Vec<Counted> {
    let Lines { number: all, shared, seed, reach } = lines;
    let each = all.div_ceil(GROUPS);
    let source = Source::diffuse(DVec3::new(0.0, 0.0, top), 0.0);
    let group = |number: u64| {
        let mut counted = Counted::new(media);
        let mut memory = U::Memory::default();
        for i in 0..each {
            let line = number * each + i;
            let mut rng = Stream::of(seed, 0, line, Purpose::Probe);
            // As in a run: the first of those that share draws the realisation, or a number names it.
            universe.begin(&mut memory, line);
            if i % shared == 0 {
                universe.forget(&mut memory);
            } else {
                universe.share(&mut memory);
            }
            follow(universe, &source, [bottom, top], reach, &mut memory, &mut rng, &mut counted);
        }
        counted
    };
    (0..GROUPS).into_par_iter().map(group).collect()
}

/// All groups together.
pub fn total(groups: &[Counted]) -> Counted {
    let mut all = Counted::new(groups.first().map_or(0, |g| g.media));
    groups.iter().for_each(|g| all.add(g));
    all
}

/// A value of all groups, and its standard error by the jackknife over them.
pub fn with_error(groups: &[Counted], f: impl Fn(&Counted) -> f64) -> (f64, f64) {
    let value = f(&total(groups));
    let without = |k: usize| {
        let rest: Vec<Counted> =
            groups.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, g)| g.clone()).collect();
        f(&total(&rest))
    };
    let left_out: Vec<f64> = (0..groups.len()).map(without).collect();
    let n = left_out.len() as f64;
    let mean = left_out.iter().sum::<f64>() / n;
    let spread: f64 = left_out.iter().map(|x| (x - mean) * (x - mean)).sum();
    (value, (spread * (n - 1.0) / n).sqrt())
}

fn follow<U: Universe>(
    universe: &U,
    source: &Source,
    [bottom, top]: [f64; 2],
    reach: f64,
    memory: &mut U::Memory,
    rng: &mut Stream,
    counted: &mut Counted,
) {
    let mut ray = source.emit(rng);
    let came_in = ray.origin;
    let level = (ray.dir.x * ray.dir.x + ray.dir.y * ray.dir.y).sqrt();
    let far = reach / level;
    let mut left = far;
    let start = universe.enter(&ray, memory, rng);
    let (mut place, mut medium) = (start.place, usize::from(start.medium.0));
    let bin = ((ray.dir.z.abs() * DIRECTIONS as f64) as usize).min(DIRECTIONS - 1);
    let slice = |z: f64| ((top - z) / (top - bottom) * SLICES as f64).clamp(0.0, SLICES as f64);
    let mut from_interface = false;
    counted.lines += 1;
    loop {
        let next = universe.next(&ray, &mut place, memory, left, rng);
        let (length, met) = match next {
            Next::Interface(at) => (at.distance, Some(at)),
            Next::Edge { distance, .. } if distance.is_finite() => (distance, None),
            Next::Limit => (left, None),
            Next::Edge { .. } | Next::Lost => {
                counted.lost += 1;
                return;
            }
        };
        counted.length[medium][bin] += length;
        let ends = [slice(ray.origin.z), slice(ray.at(length).z)];
        spread(&mut counted.depth[medium], ends, length);
        if from_interface {
            counted.chords[medium][bin][usize::from(met.is_none())][class_of(length)] += 1;
        }
        if let Next::Limit = next {
            let back = came_in - ray.dir * far;
            ray.origin = DVec3::new(back.x, back.y, ray.at(length).z);
            let start = universe.come_back(&ray, &place, memory, rng);
            (place, medium) = (start.place, usize::from(start.medium.0));
            (from_interface, left) = (false, 2.0 * far);
            continue;
        }
        let Some(at) = met else { return };
        left -= length;
        let beyond = usize::from(at.beyond.0);
        counted.ends[medium][bin] += 1.0;
        counted.passed[medium * counted.media + beyond] += 1.0;
        for side in [medium, beyond] {
            tell_surface(counted, side, at.facet, at.axis);
        }
        ray.origin = ray.at(length);
        universe.crossed(&mut ray, &mut place, memory, &at);
        (medium, from_interface) = (beyond, true);
    }
}

/// A length over slices from `a` to `b` (in slices from the top).
fn spread(slices: &mut [f64; SLICES], [a, b]: [f64; 2], length: f64) {
    let (lo, hi) = (a.min(b), a.max(b));
    let first = (lo as usize).min(SLICES - 1);
    if hi - lo < 1e-9 {
        slices[first] += length;
        return;
    }
    for (i, slice) in slices.iter_mut().enumerate().skip(first) {
        let share = hi.min(i as f64 + 1.0) - lo.max(i as f64);
        if share <= 0.0 {
            break;
        }
        *slice += length * share / (hi - lo);
    }
}

fn tell_surface(counted: &mut Counted, medium: usize, n: DVec3, axis: DVec3) {
    let sums = &mut counted.normals[medium];
    for (sum, x) in sums.iter_mut().zip([1.0, n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y]) {
        *sum += x;
    }
    let level = axis.x * axis.x + axis.y * axis.y;
    // The planes of layers have a machine direction too, and are no bodies.
    let plane = n.x == 0.0 && n.y == 0.0;
    if level > 0.0 && !plane {
        let tilt = asin((axis.z / axis.length()).clamp(-1.0, 1.0));
        let sums = &mut counted.axes[medium];
        let double = [(axis.x * axis.x - axis.y * axis.y) / level, 2.0 * axis.x * axis.y / level];
        for (sum, x) in sums.iter_mut().zip([1.0, double[0], double[1], tilt * tilt]) {
            *sum += x;
        }
    }
}

/// Flatness and width (µm) of the solid cylinder of elliptic section, lying flat in the plane, whose surface
/// has the mean square ⟨n_z²⟩ of its normals over area, and the mean chord 4A/P.
pub fn equivalent_section(nz2: f64, chord: f64) -> (f64, f64) {
    // With x = a cos t, y = b sin t, ds² = a² sin² + b² cos², n_z² ds = (a sin)²/ds dt; a = 1, b = f.
    let moments = |f: f64| {
        const STEPS: usize = 720;
        let (mut weighted, mut perimeter) = (0.0, 0.0);
        for i in 0..STEPS {
            let (s, c) = crate::math::sin_cos(2.0 * PI * (i as f64 + 0.5) / STEPS as f64);
            let ds = (s * s + f * f * c * c).sqrt();
            weighted += s * s / ds;
            perimeter += ds * (2.0 * PI / STEPS as f64);
        }
        (weighted * (2.0 * PI / STEPS as f64) / perimeter, perimeter)
    };
    let (mut lo, mut hi) = (0.01, 1.0);
    for _ in 0..60 {
        let f = 0.5 * (lo + hi);
        if moments(f).0 > nz2 { lo = f } else { hi = f }
    }
    let f = 0.5 * (lo + hi);
    // Chord 4π f a²/(a P): half axis a = chord P/(4 π f).
    (f, 2.0 * chord * moments(f).1 / (4.0 * PI * f))
}
