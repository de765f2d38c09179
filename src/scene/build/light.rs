//! Light, what is measured, and how it is run.

use super::{Node, Reading};
use crate::lpm::full::Analyser;
use crate::math::FRAC_PI_2;
use crate::phase::polarised::Stokes;
use crate::rng::Generator;
use crate::scene::diagnostic::Diagnostic;
use crate::scene::effects::{Kind, Override, apply};
use crate::scene::model::*;

const PARALLEL: &str = "<source kind=\"collimated\" polar=\"75 deg\"/>";
const SPREAD: &str = "lateral spread is counted from the one point where light enters";
const PENCIL: &str = "a pencil of light: a collimated source of radius 0, or a diffuse one";

/// The measuring geometry as written.
fn geometry(e: Node<'_>) -> OpticsGeometry {
    use OpticsGeometry as G;
    let all = [G::DiffuseNormal, G::NormalDiffuse, G::FortyFiveNormal, G::EightDiffuse, G::Total];
    let word = e.text("geometry");
    all.into_iter().find(|g| Some(g.word()) == word).unwrap_or(G::DiffuseNormal)
}

fn halftone(e: &Node<'_>) -> Option<Halftone> {
    Some(Halftone { coverage: e.number("coverage")?, period: e.number("period")?, ink: e.number("ink")? })
}

impl Reading<'_> {
    /// Wavelengths, nm, ascending.
    pub fn spectrum(&mut self, e: Option<Node<'_>>) -> Vec<f64> {
        let found = e.and_then(|e| self.wavelengths(e));
        found.filter(|w| !w.is_empty()).unwrap_or_else(|| vec![550.0])
    }

    fn wavelengths(&mut self, e: Node<'_>) -> Option<Vec<f64>> {
        match e.one_of(self, &["at", "from"], Some("wavelengths"))? {
            "at" => {
                let mut list = e.list("at")?;
                list.sort_by(f64::total_cmp);
                if let Some(twice) = list.windows(2).find(|w| w[0] == w[1]) {
                    self.error(e.place("at"), format!("{} nm is given twice", twice[0]));
                }
                Some(list)
            }
            _ => {
                let mut n = |name| e.needed(self, name, "`from`");
                let (to, step) = (n("to"), n("step"));
                let (from, to, step) = (e.number("from")?, to?, step?);
                if to < from {
                    self.error(e.place("to"), format!("`to` is below `from` ({from} nm)"));
                    return None;
                }
                let count = (to - from) / step * (1.0 + 1e-12) + 1e-9;
                if count > 1e5 {
                    self.error(e.place("step"), "more than 100000 wavelengths");
                    return None;
                }
                Some((0..=count as u64).map(|i| from + i as f64 * step).collect())
            }
        }
    }

    /// State of the light, if it has one.
    pub fn polarisation(&mut self, e: Node<'_>) -> Option<Stokes> {
        let kind = e.text("polarisation").filter(|k| *k != "none")?;
        if e.text("kind").is_some_and(|k| k != "collimated") {
            let d = Diagnostic::error(e.place("polarisation"), "this light has no plane of reference");
            self.out.push(d.help("polarised light is kind=\"collimated\""));
        }
        let degree = e.number("degree").unwrap_or(1.0);
        Some(match kind {
            "linear" => {
                let (s, c) = crate::math::sin_cos(2.0 * e.number("field").unwrap_or(0.0));
                Stokes { q: degree * c, u: degree * s, v: 0.0 }
            }
            "right" => Stokes { q: 0.0, u: 0.0, v: degree },
            _ => Stokes { q: 0.0, u: 0.0, v: -degree },
        })
    }

    pub fn source(&mut self, e: Option<Node<'_>>, sheet: bool, optics: Option<Node<'_>>) -> Source {
        let own = optics.and_then(|o| geometry(o).polar());
        let normal = Source::Collimated { polar: own.unwrap_or(0.0), azimuth: 0.0, radius: 0.0 };
        let Some(e) = e else { return normal };
        match e.text("kind") {
            Some("diffuse") => Source::Diffuse { trap: e.number("trap").unwrap_or(0.0) },
            Some("point") => self.point(e).unwrap_or(normal),
            _ => {
                let polar = e.number("polar").unwrap_or(0.0);
                if sheet && polar >= FRAC_PI_2 {
                    let d = Diagnostic::error(
                        e.place("polar"),
                        "this light never meets the top face of the sheet",
                    );
                    self.out.push(d.help("below 90 deg"));
                }
                Source::Collimated {
                    polar,
                    azimuth: e.number("azimuth").unwrap_or(0.0),
                    radius: e.number("radius").unwrap_or(0.0),
                }
            }
        }
    }

    fn point(&mut self, e: Node<'_>) -> Option<Source> {
        if !e.has("position") {
            self.error(e.own.place, "<source> with kind `point` needs `position`");
        }
        let half_angle = e.number("half-angle");
        let target = e.vector("target");
        let (position, target) = (e.vector("position")?, target?);
        if position == target {
            self.error(e.place("position"), "`position` and `target` are the same point");
        }
        Some(Source::Point { position, target, half_angle: half_angle? })
    }

    pub fn detect(&mut self, e: Option<Node<'_>>, source: &Source, run: &Run) -> Detect {
        let Some(e) = e else { return Detect::default() };
        let _ = e.text("total");
        let small = |name: &str| e.count(name).and_then(|n| u32::try_from(n).ok());
        let halftones: Vec<Halftone> = e.children("halftone").filter_map(|h| halftone(&h)).collect();
        let detect = Detect {
            angular: e.nside("angular"),
            depth: small("depth"),
            checkpoint: e.number("checkpoint"),
            path: e.yes("path"),
            time: e.yes("time"),
            analyser: match e.text("analyser") {
                Some("parallel") => Some(Analyser::Parallel),
                Some("perpendicular") => Some(Analyser::Perpendicular),
                _ => None,
            },
            gloss: e.yes("gloss").then(|| self.gloss(e, source)).flatten(),
            haze: e.number("haze"),
            lateral: e.number("lateral").map(|r| (r, small("rings").unwrap_or(1))),
            flight: e.number("path-histogram").map(|l| (l, small("path-bins").unwrap_or(1))),
            halftones,
            klems: e.yes("klems"),
            views: e
                .children("view")
                .filter_map(|v| Some((v.number("polar")?, v.number("azimuth")?)))
                .collect(),
        };
        self.check_detect(e, &detect, source, run);
        detect
    }

    /// Opening of the glossmeter's window, rad.
    fn gloss(&mut self, e: Node<'_>, source: &Source) -> Option<(f64, Option<f64>)> {
        const DEGREE: f64 = crate::math::PI / 180.0;
        if e.has("gloss-aperture") {
            return match e.list("gloss-aperture")?[..] {
                [circle] => Some((circle, None)),
                [in_plane, across] => Some((in_plane, Some(across))),
                _ => {
                    let d = Diagnostic::error(e.place("gloss-aperture"), "one angle or two");
                    self.out.push(d.help("a circle, or a rectangle in and across the plane of incidence"));
                    None
                }
            };
        }
        let Source::Collimated { polar, .. } = source else { return Some((5.0 * DEGREE, None)) };
        Some(match (polar / DEGREE).round() as i32 {
            20 => (5.0 * DEGREE, None),
            60 => (4.4 * DEGREE, Some(11.7 * DEGREE)),
            _ => (11.42 * DEGREE, None),
        })
    }

    /// Detectors that need another light, or paths one at a time.
    fn check_detect(&mut self, e: Node<'_>, detect: &Detect, source: &Source, run: &Run) {
        let parallel = matches!(source, Source::Collimated { .. });
        let pencil = matches!(source, Source::Collimated { radius: 0.0, .. } | Source::Diffuse { .. });
        let split = matches!(run.branching, Branching::Split { .. });
        let child = e.child("halftone").map_or(e.own.place, |h| h.own.place);
        for (asked, place, fault, help) in [
            (
                detect.gloss.is_some() && !parallel,
                e.place("gloss"),
                "gloss is that of parallel light",
                PARALLEL,
            ),
            (detect.haze.is_some() && !parallel, e.place("haze"), "haze is that of parallel light", PARALLEL),
            (detect.lateral.is_some() && !pencil, e.place("lateral"), SPREAD, PENCIL),
            (!detect.halftones.is_empty() && !pencil, child, SPREAD, PENCIL),
            (
                !detect.views.is_empty() && (split || !parallel),
                e.child("view").map_or(e.own.place, |v| v.own.place),
                "a view needs parallel light, and rays drawn one by one",
                "<source kind=\"collimated\" …/> and branching=\"sample\"",
            ),
            (
                detect.klems
                    && (!matches!(source, Source::Diffuse { trap: 0.0 }) || self.wavelengths.len() != 1),
                e.place("klems"),
                "the Klems matrix needs light from all directions, and one wavelength",
                "<source kind=\"diffuse\"/> and <spectrum at=\"550 nm\"/>",
            ),
            (
                detect.flight.is_some() && split,
                e.place("path-histogram"),
                "branches of a split history have no one path length",
                "branching=\"sample\"",
            ),
        ] {
            if asked {
                self.out.push(Diagnostic::error(place, fault).help(help));
            }
        }
    }

    pub fn optics(&mut self, e: Node<'_>, source: &Source) -> PaperOptics {
        let geometry = geometry(e);
        self.check_geometry(e, geometry, source);
        let backing = e.number("backing");
        if backing.is_some() && e.has("pile") {
            let d = Diagnostic::error(e.place("pile"), "`backing` and `pile` exclude each other");
            self.out.push(d.help("what lies below the sheet is either a backing or more sheets"));
        }
        let pile = e.count("pile").and_then(|n| u32::try_from(n).ok()).unwrap_or(1);
        use OpticsGeometry as G;
        let degrees = |x: f64| x * crate::math::PI / 180.0;
        PaperOptics {
            geometry,
            view: match geometry {
                G::DiffuseNormal | G::FortyFiveNormal => e.number("view").unwrap_or(0.0),
                _ => FRAC_PI_2,
            },
            trap: match geometry {
                G::NormalDiffuse => e.number("trap").unwrap_or(degrees(15.5)),
                G::EightDiffuse => e.number("trap").unwrap_or(0.0),
                _ => 0.0,
            },
            backing,
            pile: if backing.is_some() { 1 } else { pile },
            grammage: e.number("grammage"),
        }
    }

    /// The light must be that of the geometry.
    fn check_geometry(&mut self, e: Node<'_>, geometry: OpticsGeometry, source: &Source) {
        let Some(want) = geometry.polar() else { return };
        let right = matches!(source, Source::Collimated { polar, .. } if (polar - want).abs() < 1e-9);
        if !right {
            let word = geometry.word();
            let angle = want * 180.0 / crate::math::PI;
            let d = Diagnostic::error(
                e.place("geometry"),
                format!("geometry {word} needs parallel light from {angle:.0} deg"),
            );
            self.out.push(d.help(format!(
                "leave <source> out, or write <source kind=\"collimated\" polar=\"{angle:.0} deg\"/>"
            )));
        }
    }

    pub fn run(&mut self, e: Option<Node<'_>>, universe: &Universe) -> Run {
        let standard = Run {
            histories: 100_000,
            seed: 20_261_122,
            batch: crate::scene::BATCH,
            branching: Branching::Sample,
            roulette: 1e-3,
            event_cap: 1_000_000,
            shared: shared(universe, 100_000),
            weights: None,
            implicit_capture: true,
            generator: Generator::Pcg64Dxsm,
        };
        let Some(e) = e else { return standard };
        self.check_shared(e, universe);
        let histories = e.count("histories").unwrap_or(standard.histories);
        if self.polarised {
            for (name, bad, help) in [
                ("branching", "split", "patches know no plane of reference: branching=\"sample\""),
                ("absorption", "analog", "the full loop takes absorption as weight: absorption=\"implicit\""),
            ] {
                if e.text(name) == Some(bad) {
                    let d = Diagnostic::error(e.place(name), "not with polarised light");
                    self.out.push(d.help(help));
                }
            }
        }
        Run {
            histories,
            seed: e.count("seed").unwrap_or(standard.seed),
            batch: standard.batch,
            branching: match e.text("branching") {
                Some("split") => Branching::Split {
                    nside: e.nside("split-nside").unwrap_or(2),
                    floor: e.number("floor").unwrap_or(1e-3),
                },
                _ => Branching::Sample,
            },
            roulette: e.number("roulette").unwrap_or(standard.roulette),
            event_cap: e.count("event-cap").unwrap_or(standard.event_cap),
            shared: match e.count("histories-per-realisation") {
                Some(m) if e.has("histories-per-realisation") => m,
                _ => shared(universe, histories),
            },
            weights: match e.text("weights") {
                Some("yes") => Some(true),
                Some("no") => Some(false),
                _ => None,
            },
            implicit_capture: e.text("absorption") != Some("analog"),
            generator: match e.text("rng") {
                Some("philox") => Generator::Philox,
                _ => Generator::Pcg64Dxsm,
            },
        }
    }

    /// Histories can share a realisation only where one is remembered.
    fn check_shared(&mut self, e: Node<'_>, universe: &Universe) {
        const NAME: &str = "histories-per-realisation";
        let Some(m) = e.count(NAME).filter(|m| *m > 1) else { return };
        let place = e.place(NAME);
        let mut refuse = |problem: &str, help: &str| {
            self.out.push(Diagnostic::error(place, problem.to_owned()).help(help.to_owned()));
        };
        if !m.is_power_of_two() {
            refuse(
                "a batch of 4096 histories is no whole number of realisations",
                "a power of two: 2, 4, 8 … 4096",
            );
        } else if e.count("histories").is_some_and(|n| !n.is_multiple_of(m)) {
            refuse("the histories are no whole number of realisations", "make `histories` a multiple of it");
        }
        if e.text("branching") == Some("split") {
            refuse("branches of a split history share no realisation with the next", "branching=\"sample\"");
        }
        match universe {
            Universe::Statistical(s) if s.memory != Memory::Full => {
                refuse("histories share a realisation only where it is remembered", "memory=\"full\"");
            }
            Universe::Statistical(s) if s.edges == Edges::Cut && s.start == StartIn::Pore => {
                refuse(
                    "a later history may find a body where it should start in a pore",
                    "start=\"anywhere\"",
                );
            }
            Universe::Realised(r) if r.deposit.is_some() => {
                refuse(
                    "histories meet deposited sheets batch by batch",
                    "leave it out; <realise realisations>",
                );
            }
            Universe::Statistical(_) | Universe::Realised(_) => {}
            _ => refuse("only statistical sheets are drawn anew for each history", "leave it out"),
        }
    }

    pub fn expect(&mut self, e: Node<'_>) -> Expect {
        let wavelength = e.number("wavelength");
        if let Some(nm) = wavelength
            && !self.wavelengths.iter().any(|w| (w - nm).abs() < 1e-9 * nm)
        {
            let list = self.wavelengths.iter().take(8).map(f64::to_string).collect::<Vec<_>>().join(", ");
            let d = Diagnostic::error(e.place("wavelength"), format!("the scene does not simulate {nm} nm"));
            self.out.push(d.help(format!(
                "it simulates {list}{} nm",
                if self.wavelengths.len() > 8 { " …" } else { "" }
            )));
        }
        Expect {
            quantity: e.text("quantity").unwrap_or_default().to_string(),
            wavelength,
            component: e.text("component").map(str::to_string),
            value: e.number("value").unwrap_or(0.0),
            error: e.number("error").unwrap_or(0.0),
            source: e.text("source").unwrap_or_default().to_string(),
        }
    }

    /// Overrides of effects, applied one by one so that a refusal shows its line.
    pub fn effects(&mut self, e: Option<Node<'_>>, scene: &mut Scene) {
        scene.lines.clone_from(&self.lines);
        for e in e.iter().flat_map(|e| e.children("effect")) {
            let (name, state) = (e.text("name").unwrap_or_default(), e.text("state").unwrap_or_default());
            let reason = e.text("reason").unwrap_or_default();
            let Some(kind) = Kind::of(name) else { continue };
            let (on, reason) = (state == "on", reason.to_owned());
            let wanted = Override { kind, on, reason, called: Vec::new(), flag: false };
            if let Err(why) = apply(scene, vec![wanted]) {
                self.error(e.own.place, why);
            }
        }
    }

    /// Remembers the line of an element.
    pub fn line(&mut self, key: impl Into<String>, e: Node<'_>) {
        if e.own.place.file == 0 {
            let line = self.out.line_column(e.own.place).0;
            self.lines.insert(key.into(), line);
        }
    }
}

/// Histories that share a realisation if the scene does not say: explicit sheets take longer to make than a
/// history to trace.
fn shared(universe: &Universe, histories: u64) -> u64 {
    const MOST: u64 = 64;
    match universe {
        Universe::Realised(r) if histories > 0 && r.deposit.is_none() => {
            MOST.min(1 << histories.trailing_zeros().min(63))
        }
        _ => 1,
    }
}
