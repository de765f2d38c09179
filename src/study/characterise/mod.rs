//! `characterise`: the statistics of an explicit sheet, measured by straight lines and by counting its
//! bodies, in files that a statistical scene takes.

pub mod bodies;
pub mod lines;

use crate::scene::plan::Plan;
use crate::scene::written::escaped;
use crate::scene::{Scene, Universe as Where};
use crate::universe::any::AnyUniverse;
use crate::universe::synthetic;
use bodies::{Population, Window, populations};
use lines::{Counted, DIRECTIONS, Lines, SLICES, equivalent_section, measure, total, with_error};
use std::collections::BTreeSet;
use std::fmt::{self, Write};

/// Bodies that are counted in each realisation, about, where there is no end of them; and realisations.
const BODIES: f64 = 40_000.0;
/// Bodies of a realisation around which lines go on, about.
const KNOWN: f64 = 4_000.0;
/// See [`BODIES`].
const REALISATIONS: u32 = 5;

/// The statistics of a sheet.
#[derive(Clone, Debug)]
pub struct Characteristics {
    /// Names of media.
    pub media: Vec<String>,
    /// Materials of media.
    pub materials: Vec<String>,
    /// Medium between the bodies.
    pub pore: usize,
    /// Thickness, µm.
    pub thickness: f64,
    /// What lines met, by groups.
    pub groups: Vec<Counted>,
    /// All groups together.
    pub all: Counted,
    /// Explicit bodies.
    pub populations: Vec<Population>,
    /// Media of their hollows.
    pub hollows: BTreeSet<usize>,
}

/// Measures a scene's universe with straight lines.
///
/// # Errors
/// A scene that cannot be made, or whose universe has no even face to measure on.
pub fn characterise(scene: &Scene, lines: u64) -> Result<Characteristics, String> {
    let plan = Plan::new(scene)?;
    let (planes, media, seed) = ([plan.bottom, plan.top], plan.media.names.len(), scene.run.seed);
    let (mut bodies, mut window) = (Vec::new(), Window::Cells(0.0));
    let free = Lines { number: lines, shared: 1, seed, reach: f64::INFINITY };
    let within = |radius: f64| {
        let reach = radius.max(10.0 * (planes[1] - planes[0]));
        Lines { shared: scene.run.shared, reach, ..free }
    };
    let groups = match &plan.universe {
        AnyUniverse::Realised(drum) => {
            let radius = drum.radius_of(BODIES);
            bodies = (0..REALISATIONS).flat_map(|r| drum.bodies(seed, u64::from(r), radius)).collect();
            window = Window::Discs(radius, REALISATIONS);
            measure(drum, planes, media, within(drum.radius_of(KNOWN)))
        }
        AnyUniverse::Stack(stack) => {
            let drums = || stack.layers().filter_map(|l| l.1);
            let radius = drums().map(|d| d.radius_of(BODIES)).fold(f64::INFINITY, f64::min);
            let known = |r: u32| drums().flat_map(move |d| d.bodies(d.seed(), u64::from(r), radius));
            bodies = (0..REALISATIONS).flat_map(known).collect();
            window = Window::Discs(radius, REALISATIONS);
            let far = drums().map(|d| d.radius_of(KNOWN)).fold(f64::INFINITY, f64::min);
            measure(stack, planes, media, within(far))
        }
        AnyUniverse::Ensemble(u) => {
            let [x, y] = u.cells()[0].period();
            bodies = u.cells().iter().flat_map(|c| c.bodies()).collect();
            window = Window::Cells(x * y * u.cells().len() as f64);
            measure(u, planes, media, free)
        }
        AnyUniverse::Topography(u) if u.anywhere() => {
            let [x, y] = u.period();
            bodies = u.bodies().bodies().filter(|b| synthetic::corners(&b.0.shape).is_some()).collect();
            window = Window::Cells(x * y);
            measure(u, planes, media, free)
        }
        AnyUniverse::Voxel(voxels) => measure(voxels, planes, media, free),
        AnyUniverse::Statistical(u) => measure(u, planes, media, free),
        AnyUniverse::Lazy(u) => measure(u, planes, media, free),
        AnyUniverse::Mixture(u) => measure(u, planes, media, free),
        AnyUniverse::Synthetic(_) | AnyUniverse::Topography(_) => {
            return Err(
                "single bodies are no sheet: lines cannot fall evenly on them; characterise takes a \
                        realised <sheet> (kind=\"synthetic\" with <fibres> or <particles>), a <cell>, a volume, or any \
                        statistical universe"
                    .to_owned(),
            );
        }
    };
    let outside = match &scene.universe {
        Where::Statistical(s) => s.layers[0].pore,
        Where::Realised(r) => r.sheet.layers[0].pore,
        Where::Voxel(v) => v.rules.outside,
        Where::Mixture(m) => m.outside,
        Where::Synthetic(s) => s.ambient,
    };
    let materials = plan.media.origins.iter().map(|o| match o {
        crate::scene::media::Origin::Material(i) => scene.materials[*i].id.clone(),
        crate::scene::media::Origin::Average(_) => String::new(),
    });
    Ok(Characteristics {
        materials: materials.collect(),
        media: plan.media.names.clone(),
        pore: usize::from(outside.0),
        thickness: plan.top - plan.bottom,
        all: total(&groups),
        groups,
        hollows: bodies.iter().filter_map(|b| b.1).map(|h| usize::from(h.medium.0)).collect(),
        populations: populations(&bodies, window, planes),
    })
}

impl Characteristics {
    /// Media that are there.
    fn present(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.media.len()).filter(|&m| self.all.length_of(m) > 0.0)
    }

    /// A value and its standard error.
    pub fn value(&self, f: impl Fn(&Counted) -> f64) -> (f64, f64) {
        with_error(&self.groups, f)
    }

    /// Rate (1/µm) at which interfaces end chords of `medium`, by |cos θ|: (from, to, rate, standard error).
    /// Of the pores of a Boolean sheet this is Σ(u) of the bodies.
    pub fn rates(&self, medium: usize) -> Vec<[f64; 4]> {
        let row = |b: usize| {
            let (rate, se) = self.value(|c| c.ends[medium][b] / c.length[medium][b]);
            [b as f64 / DIRECTIONS as f64, (b + 1) as f64 / DIRECTIONS as f64, rate, se]
        };
        (0..DIRECTIONS).filter(|&b| self.all.length[medium][b] > 0.0).map(row).collect()
    }

    /// `chords.csv`: survival of the chords of each medium.
    pub fn chords_csv(&self) -> String {
        let mut out = "medium,longer_than_um,share\n".to_owned();
        for m in self.present() {
            for (length, share) in self.all.survival(m) {
                let _ = writeln!(out, "{},{length},{share}", self.media[m]);
            }
        }
        out
    }

    /// `rates.csv`: chords of each medium by direction.
    pub fn rates_csv(&self) -> String {
        let mut out = "medium,cos_from,cos_to,rate_per_um,standard_error_per_um,mean_chord_um\n".to_owned();
        for m in self.present() {
            for [from, to, rate, se] in self.rates(m) {
                let _ = writeln!(out, "{},{from},{to},{rate},{se},{}", self.media[m], 1.0 / rate);
            }
        }
        out
    }

    /// `transitions.csv`: what follows a medium at its interfaces.
    pub fn transitions_csv(&self) -> String {
        let mut out = "from,to,share,standard_error,area_per_volume_per_um\n".to_owned();
        for (from, to) in self.present().flat_map(|a| self.present().map(move |b| (a, b))) {
            if self.all.between(from, to) > 0.0 {
                let leaving = |c: &Counted| self.present().map(|m| c.between(from, m)).sum::<f64>();
                let (share, se) = self.value(|c| c.between(from, to) / leaving(c));
                let area = 2.0 * (self.all.between(from, to) + self.all.between(to, from)) / self.all.whole();
                let _ = writeln!(out, "{},{},{share},{se},{area}", self.media[from], self.media[to]);
            }
        }
        out
    }

    /// `profile.csv`: share of each medium over depth.
    pub fn profile_csv(&self) -> String {
        let mut out = "depth_um,medium,share,standard_error\n".to_owned();
        for slice in 0..SLICES {
            let depth = (slice as f64 + 0.5) / SLICES as f64 * self.thickness;
            for m in self.present() {
                let whole = |c: &Counted| c.depth.iter().map(|d| d[slice]).sum::<f64>();
                let (share, se) = self.value(|c| c.depth[m][slice] / whole(c));
                let _ = writeln!(out, "{depth},{},{share},{se}", self.media[m]);
            }
        }
        out
    }

    /// Distribution files, with names, and the `<universe>` that uses them.
    pub fn files(&self, scene: &str) -> Vec<(String, String)> {
        let source = format!("measured from the scene '{scene}'");
        let mut files = Vec::new();
        let mut layer = String::new();
        let counted = |m: usize| self.populations.iter().any(|p| usize::from(p.medium.0) == m);
        for m in self.present().filter(|&m| m != self.pore && !counted(m) && !self.hollows.contains(&m)) {
            let Some(text) = self.equivalent(m, &source) else { continue };
            let file = file_name(&self.media[m], &files);
            let _ = writeln!(
                layer,
                "      <fibres from=\"{file}\" name=\"{}\" material=\"{}\" volume-fraction=\"{:.6}\"/>",
                escaped(&self.media[m]),
                escaped(&self.materials[m]),
                self.all.share(m)
            );
            files.push((file, text));
        }
        for p in &self.populations {
            let m = usize::from(p.medium.0);
            let file = file_name(&self.media[m], &files);
            let tag = if p.kind == "fibres" { "fibres" } else { "particles" };
            let _ = writeln!(
                layer,
                "      <{tag} from=\"{file}\" name=\"{}\" material=\"{}\" {}/>",
                escaped(&self.media[m]),
                escaped(&self.materials[m]),
                p.amount()
            );
            files.push((file, p.distribution(&self.media[m], &source)));
        }
        let pore = &self.materials[self.pore];
        let universe = format!(
            "<!-- The sheet by its statistics, measured by lightpro characterise. Put it into the scene in place of \
             its universe. -->\n<universe kind=\"statistical\" memory=\"full\" edges=\"cut\" outside=\"{0}\">\n  \
             <sheet thickness=\"{1} um\" pore=\"{0}\">\n    <layer>\n{layer}    </layer>\n  </sheet>\n</universe>\n",
            escaped(pore),
            self.thickness,
        );
        files.push(("universe.xml".to_owned(), universe));
        files
    }

    /// The flat solid fibres without end that have the mean chord and the normals of a medium of which no
    /// bodies are counted: what a volume of voxels, or a sheet of bent fibres, tells of them.
    fn equivalent(&self, medium: usize, source: &str) -> Option<String> {
        let [n, xx, yy, zz, xy] = self.all.normals[medium];
        if n == 0.0 {
            return None;
        }
        let (flatness, width) = equivalent_section(zz / n, self.all.mean_chord(medium));
        // Normals lie across the axes: their level part is turned by a right angle.
        let order = (((yy - xx).powi(2) + 4.0 * xy * xy).sqrt() / (xx + yy)).min(0.999);
        let azimuth = 0.5 * crate::math::atan2(-2.0 * xy, yy - xx);
        let direction = if order > 0.01 {
            format!(
                " orientation=\"wrapped-cauchy\" mean-direction=\"{:.3} deg\" rho=\"{order:.5}\"",
                azimuth.to_degrees()
            )
        } else {
            String::new()
        };
        Some(format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- Measured by lightpro characterise. No bodies are known \
             here: solid fibres lying flat with the mean chord (4 V/S = {:.4} um) and the normals (mean square \
             across the sheet {:.4}) of this medium. -->\n<distribution kind=\"fibres\" name=\"{}\" \
             source=\"{}\">\n  <fibres{direction} roll=\"flat\" wall=\"solid\" width=\"{width:.4} um\" \
             flatness=\"{flatness:.4}\"/>\n</distribution>\n",
            self.all.mean_chord(medium),
            zz / n,
            escaped(&self.media[medium]),
            escaped(source),
        ))
    }
}

/// A file name for a medium that no other has.
fn file_name(medium: &str, taken: &[(String, String)]) -> String {
    let plain: String = medium.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
    let mut name = format!("{plain}.xml");
    let mut n = 2;
    while name == "universe.xml" || taken.iter().any(|t| t.0 == name) {
        name = format!("{plain}-{n}.xml");
        n += 1;
    }
    name
}

impl fmt::Display for Characteristics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let c = &self.all;
        writeln!(f, "{} straight lines, isotropic and uniform; {} lost", c.lines, c.lost)?;
        let (s, se) = self.value(Counted::surface);
        writeln!(f, "thickness {} um, interfaces S_V {s:.5}({se:.5}) 1/um", self.thickness)?;
        writeln!(
            f,
            "{:<20} {:>18} {:>24} {:>12} {:>10}",
            "medium", "share of volume", "mean chord 4V/S um", "azimuth", "order"
        )?;
        for m in self.present() {
            let (share, share_se) = self.value(|c| c.share(m));
            let (chord, chord_se) = self.value(|c| c.mean_chord(m));
            let order = c.order(m).map_or((String::new(), String::new()), |(a, o)| {
                (format!("{:.1} deg", a.to_degrees()), format!("{o:.4}"))
            });
            writeln!(
                f,
                "{:<20} {:>18} {:>24} {:>12} {:>10}",
                self.media[m],
                format!("{share:.5}({share_se:.5})"),
                if chord.is_finite() { format!("{chord:.4}({chord_se:.4})") } else { "none ends".to_owned() },
                order.0,
                order.1
            )?;
        }
        for p in &self.populations {
            let name = &self.media[usize::from(p.medium.0)];
            writeln!(f, "{name}: {} bodies counted, {}", p.count, p.amount().replace('"', ""))?;
        }
        Ok(())
    }
}
