//! `study sap`: the paper's Sphere Area Partitioning against the continuous law: granularity, direction
//! inside a patch, frame, drawn ray against rays into all patches.

use super::timed::{Timed, timed};
use crate::lpm::light::MediumSap;
use crate::lpm::patches::SapRule;
use crate::math::{DVec3, TAU, cos, sin};
use crate::phase::Phase;
use crate::report::plot::{Curve, LinePlot, Plot};
use crate::report::{csv, text::with_error};
use crate::rng::{Purpose, Stream};
use crate::sap::{Healpix, SapDirections};
use crate::scene::{Branching, Directions, Populate, SapFrame, SapSpec, Scene};
use crate::stats::Moments;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Granularities of the study.
pub const GRANULARITIES: [u32; 7] = [1, 2, 3, 4, 6, 8, 16];

/// Bias of the mean cosine by patches: (1 − g′)/(1 − g) − 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BiasRow {
    /// Asymmetry of the Henyey–Greenstein law.
    pub g: f64,
    /// Granularity.
    pub nside: u32,
    /// `pole`: the forward direction is a pole of the patches, as in transport; `random`: anywhere.
    pub axis: String,
    /// `centre`, `density` or `uniform`.
    pub directions: String,
    /// Bias, from integrals over the patches.
    pub bias: f64,
    /// Bias of drawn directions; at the pole those of transport.
    pub drawn: f64,
    /// Standard error of `drawn`.
    pub error: f64,
}

const WORDS: [(SapDirections, Directions, &str); 3] = [
    (SapDirections::Centre, Directions::Centre, "centre"),
    (SapDirections::Density, Directions::Density, "density"),
    (SapDirections::Uniform, Directions::Uniform, "uniform"),
];

/// Biases of exactly populated patches at asymmetry `g`, with `draws` directions each.
///
/// About a random axis the patch of a drawn direction d is as likely as any, and the mean of (direction that
/// stands for it)·axis is g E[direction·d]: with m the mean vector of a patch and c its centre g⟨c·m⟩ for
/// centres and g⟨m²⟩ for uniform directions. Single axes are spread about that mean (nside 4, g = .9: 4.5 %
/// along (1,1,1), 11.8 % at the pole, 5.2 % on average).
///
/// # Errors
/// An asymmetry or granularity out of range.
pub fn biases(g: f64, granularities: &[u32], draws: u64) -> Result<Vec<BiasRow>, String> {
    let phase = Phase::henyey_greenstein(g).map_err(|e| e.to_string())?;
    let mut out = Vec::new();
    for &nside in granularities {
        let hp = Healpix::new(nside).map_err(|e| e.to_string())?;
        let means: Vec<DVec3> = (0..hp.npix()).map(|p| hp.mean_vector(p, None)).collect();
        for (i, (directions, _, word)) in WORDS.into_iter().enumerate() {
            let rule = SapRule { nside, exact: true, directions, resolved: true, roll_random: true };
            let table = MediumSap::new(&phase, &rule).map_err(|e| e.to_string())?;
            let of = |pix: usize| match directions {
                SapDirections::Centre => hp.centre(pix),
                _ => means[pix],
            };
            let shares = table.sap.ratios();
            let pole = match directions {
                SapDirections::Density => g,
                _ => (0..hp.npix()).map(|p| shares[p] * of(p).z).sum(),
            };
            let random = match directions {
                SapDirections::Density => g,
                _ => g * (0..hp.npix()).map(|p| of(p).dot(means[p])).sum::<f64>() / hp.npix() as f64,
            };
            let mut rng = Stream::of(20_261_123, u64::from(nside), i as u64, Purpose::Probe);
            let (mut at_pole, mut anywhere) = (Moments::default(), Moments::default());
            for _ in 0..draws {
                at_pole.add(table.scatter(&phase, DVec3::Z, &mut rng).z);
                let axis = isotropic(&mut rng);
                let d = phase.scatter(axis, &mut rng);
                let pix = hp.pix_of(d);
                let stands = match directions {
                    SapDirections::Centre => hp.centre(pix),
                    SapDirections::Uniform => hp.uniform_in(pix, &mut rng),
                    SapDirections::Density => d,
                };
                anywhere.add(stands.dot(axis));
            }
            for (axis, exact, m) in [("pole", pole, at_pole), ("random", random, anywhere)] {
                let bias = |mean: f64| (1.0 - mean) / (1.0 - g) - 1.0;
                out.push(BiasRow {
                    g,
                    nside,
                    axis: axis.to_owned(),
                    directions: word.to_owned(),
                    bias: bias(exact),
                    drawn: bias(m.mean()),
                    error: m.standard_error() / (1.0 - g),
                });
            }
        }
    }
    Ok(out)
}

fn isotropic(rng: &mut Stream) -> DVec3 {
    let z = 2.0 * rng.uniform() - 1.0;
    let (r, a) = ((1.0 - z * z).sqrt(), TAU * rng.uniform());
    DVec3::new(r * cos(a), r * sin(a), z)
}

/// A scene with patches against the same with the continuous law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightRow {
    /// Scene.
    pub scene: String,
    /// Granularity; 0: the continuous law.
    pub nside: u32,
    /// `centre`, `density`, `uniform`; empty: the continuous law.
    pub directions: String,
    /// `rotated` or `resolved` (surfaces).
    pub frame: String,
    /// `exact` or `centre`.
    pub populate: String,
    /// `sample` or `split`.
    pub branching: String,
    /// Figure, at the first wavelength.
    pub figure: String,
    /// Value.
    pub value: f64,
    /// Standard error.
    pub error: f64,
    /// Less that of the continuous law.
    pub difference: f64,
    /// Standard error of the difference.
    pub difference_error: f64,
    /// Figure of merit over that of the continuous law, 1/(error² · processor time): differs from run to run.
    pub merit: f64,
}

/// A variant of a scene.
struct Variant {
    nside: u32,
    spec: Option<SapSpec>,
    split: bool,
}

/// Runs a scene with patches of every kind, with `histories` each. Scenes without patches get them on every
/// medium that scatters and every rough or Lambertian surface.
///
/// # Errors
/// A scene that cannot be run as the continuous law has it; variants that cannot be are left out.
pub fn light(scene: &Scene, granularities: &[u32], histories: u64) -> Result<Vec<LightRow>, String> {
    let spec = |nside, populate, directions, frame| SapSpec {
        nside,
        populate,
        directions,
        frame,
        roll_random: true,
    };
    let mut variants = Vec::new();
    for &nside in granularities {
        for (_, directions, _) in WORDS {
            for frame in [SapFrame::Resolved, SapFrame::Rotated] {
                let sap = spec(nside, Populate::Exact, directions, frame);
                variants.push(Variant { nside, spec: Some(sap), split: false });
            }
        }
        // The paper as it stands: density at the centres, centres, turned.
        let paper = spec(nside, Populate::Centre, Directions::Centre, SapFrame::Rotated);
        variants.push(Variant { nside, spec: Some(paper), split: false });
        if nside <= 2 {
            let sap = spec(nside, Populate::Exact, Directions::Density, SapFrame::Resolved);
            variants.push(Variant { nside, spec: Some(sap), split: true });
        }
    }
    let mut base = with(scene, None, false, histories);
    base.expects.clear();
    let base = timed(&base)?;
    let mut out = rows(scene, &base, &base, &Variant { nside: 0, spec: None, split: false });
    let surfaces = scene.surfaces.iter().any(rough);
    for v in variants {
        let rotated = v.spec.is_some_and(|s| s.frame == SapFrame::Rotated && s.populate == Populate::Exact);
        // Media have one frame.
        if rotated && !surfaces {
            continue;
        }
        let own = with(scene, v.spec, v.split, if v.split { histories / 8 } else { histories });
        if let Ok(ran) = timed(&own) {
            out.extend(rows(scene, &base, &ran, &v));
        }
    }
    Ok(out)
}

fn rough(s: &crate::scene::Surface) -> bool {
    use crate::scene::SurfaceKind as K;
    matches!(s.kind, K::Rough { .. } | K::Lambertian { .. })
}

fn with(scene: &Scene, spec: Option<SapSpec>, split: bool, histories: u64) -> Scene {
    let mut out = scene.clone();
    out.materials.iter_mut().filter(|m| !m.scattering.is_empty()).for_each(|m| m.sap = spec);
    out.surfaces.iter_mut().filter(|s| rough(s)).for_each(|s| s.sap = spec);
    out.run.branching = match (split, spec) {
        (true, Some(s)) => Branching::Split { nside: s.nside, floor: 1e-2 },
        _ => Branching::Sample,
    };
    out.run.histories = histories;
    out
}

fn rows(scene: &Scene, base: &Timed, ran: &Timed, v: &Variant) -> Vec<LightRow> {
    let nm = scene.wavelengths[0];
    let names = ["reflectance", "transmittance", "checkpoint"];
    let find =
        |r: &Timed, name: &str| r.result.figure(name, Some(nm)).and_then(|f| Some((f.value?, f.error?)));
    names
        .iter()
        .filter_map(|name| {
            let ((a, ea), (b, eb)) = (find(base, name)?, find(ran, name)?);
            let is_base = v.nside == 0;
            let word = |w: &str| if is_base { String::new() } else { w.to_owned() };
            let spec = v.spec;
            let directions =
                spec.and_then(|s| WORDS.iter().find(|w| w.1 == s.directions)).map_or("", |w| w.2);
            let rotated = spec.is_some_and(|s| s.frame == SapFrame::Rotated);
            let centre = spec.is_some_and(|s| s.populate == Populate::Centre);
            Some(LightRow {
                scene: scene.name.clone(),
                nside: v.nside,
                directions: directions.to_owned(),
                frame: word(if rotated { "rotated" } else { "resolved" }),
                populate: word(if centre { "centre" } else { "exact" }),
                branching: word(if v.split { "split" } else { "sample" }),
                figure: (*name).to_owned(),
                value: b,
                error: eb,
                difference: b - a,
                difference_error: if is_base { 0.0 } else { (ea * ea + eb * eb).sqrt() },
                merit: (ea * ea * base.cpu) / (eb * eb * ran.cpu),
            })
        })
        .collect()
}

/// The study: both tables.
#[derive(Clone, Debug)]
pub struct Study {
    /// Mean cosine by patches.
    pub biases: Vec<BiasRow>,
    /// Light in scenes.
    pub light: Vec<LightRow>,
}

impl Study {
    /// Files of the study: name and content.
    pub fn files(&self) -> Vec<(String, String)> {
        let plot = self.plot();
        vec![
            ("sap_bias.csv".into(), csv::table(&self.biases)),
            ("sap_light.csv".into(), csv::table(&self.light)),
            ("sap.txt".into(), self.to_string()),
            ("sap_bias.svg".into(), plot.svg),
            ("sap_bias_plot.csv".into(), plot.csv),
        ]
    }

    /// log₁₀ of the bias against log₁₀ of the granularity: straight lines of slope −2.
    pub fn plot(&self) -> Plot {
        let mut curves: Vec<Curve> = Vec::new();
        for r in self.biases.iter().filter(|r| r.directions != "density" && r.bias > 0.0) {
            let label = format!("{}, {} axis", r.directions, r.axis);
            let at = (crate::math::log10(f64::from(r.nside)), crate::math::log10(r.bias), 0.0);
            match curves.iter_mut().find(|c| c.label == label) {
                Some(c) => c.points.push(at),
                None => curves.push(Curve { label, points: vec![at] }),
            }
        }
        let title = "Bias of 1 − g by patches, Henyey–Greenstein";
        let x = ("log₁₀ granularity", "1");
        let svg = LinePlot { title, x, y: ("log₁₀ bias", "1"), curves: &curves, dots: true }.svg();
        Plot { svg, csv: csv::table(&self.biases) }
    }
}

impl fmt::Display for Study {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "bias of 1 - g by patches, per cent: from integrals (drawn)")?;
        for r in &self.biases {
            let drawn = with_error(100.0 * r.drawn, Some(100.0 * r.error));
            writeln!(
                f,
                "  g {} nside {:>2} {:<6} axis {:<8} {:>8.3} ({drawn})",
                r.g,
                r.nside,
                r.axis,
                r.directions,
                100.0 * r.bias
            )?;
        }
        let mut scene = "";
        for r in &self.light {
            if r.scene != scene {
                scene = &r.scene;
                writeln!(f, "\n{scene}: patches less the continuous law; figure of merit over its own")?;
            }
            let what = if r.nside == 0 {
                "continuous".to_owned()
            } else {
                format!("nside {:>2} {} {} {} {}", r.nside, r.directions, r.frame, r.populate, r.branching)
            };
            writeln!(
                f,
                "  {what:<48} {:<14} {:>22}  {:>24}  {:.2}",
                r.figure,
                with_error(r.value, Some(r.error)),
                if r.nside == 0 { String::new() } else { with_error(r.difference, Some(r.difference_error)) },
                r.merit
            )?;
        }
        Ok(())
    }
}
