//! `run --target`: a run that stops when figures are known well enough.
//!
//! Targets are looked at after numbers of batches that are fixed beforehand ([`is_look`]), so where a run
//! ends depends on scene, seed and targets alone, not on threads, time or interruptions.
//!
//! Looking often and stopping at the first lucky look makes intervals too short. The variance of figures
//! that are counted history by history is known from 40,000 scores and more at the first look; that of
//! figures from replicas (a jackknife) from as many numbers as there are batches: these are not believed
//! below [`REPLICAS`] batches. So intervals of nominal 95 % cover 94 to 95 % (docs/runs.md).

use crate::report::{Figure, RunResult, Status, text::digits, text::with_error};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Fewest batches of a run that stops at a target.
pub const FLOOR: u64 = 10;
/// Fewest batches where a wanted figure comes from replicas: with 10, intervals of 95 % would cover 93 %.
pub const REPLICAS: u64 = 16;
/// Degrees of freedom below which the error of a figure is not believed: VOV above 0.1.
const SPREAD: f64 = 20.0;
/// Most histories per wavelength group of a run with targets, unless told otherwise.
pub const MOST: u64 = 10_000_000_000;

/// The standard error wanted of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Within {
    /// Share of the value.
    Relative(f64),
    /// In the unit of the figure.
    Absolute(f64),
}

/// A figure and how well it should be known.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Name as in `result.json`.
    pub figure: String,
    /// Component, if one is meant; else all.
    pub component: Option<String>,
    /// Wavelength in nm, if one is meant; else all.
    pub wavelength_nm: Option<f64>,
    /// Wanted standard error.
    pub within: Within,
}

impl Target {
    /// `FIGURE[COMPONENT]@NM:ERROR`, component and wavelength only where meant: "reflectance:0.1%" is a
    /// standard error of a thousandth of the value, "brightness:0.1" one of 0.1 in the figure's unit.
    /// `brightness` is short for `brightness_r457`.
    ///
    /// # Errors
    /// What is wrong with the text.
    pub fn parse(text: &str) -> Result<Self, String> {
        const SHAPE: &str = "expected FIGURE:ERROR such as reflectance:0.1% (of the value), \
                             brightness:0.1 (in its unit) or reflectance@550:0.1%";
        let (what, error) = text.rsplit_once(':').ok_or(SHAPE)?;
        let (what, wavelength_nm) = match what.split_once('@') {
            None => (what, None),
            Some((w, nm)) => {
                let nm = nm.trim().trim_end_matches("nm").trim().parse::<f64>().ok();
                (w, Some(nm.filter(|x| x.is_finite()).ok_or(SHAPE)?))
            }
        };
        let (name, component) = match what.split_once('[') {
            None => (what, None),
            Some((n, c)) => (n, Some(c.strip_suffix(']').ok_or(SHAPE)?.to_owned())),
        };
        let name = match name.trim() {
            "" => return Err(SHAPE.to_owned()),
            "brightness" => "brightness_r457",
            n => n,
        };
        let error = error.trim();
        let (number, relative) = match error.strip_suffix('%') {
            Some(n) => (n.trim(), true),
            None => (error, false),
        };
        let x = number.parse::<f64>().ok().filter(|x| x.is_finite() && *x > 0.0).ok_or(SHAPE)?;
        let within = if relative { Within::Relative(x / 100.0) } else { Within::Absolute(x) };
        Ok(Target { figure: name.to_owned(), component, wavelength_nm, within })
    }

    /// Whether a figure is meant.
    pub fn means(&self, f: &Figure) -> bool {
        let wavelength = self.wavelength_nm.is_none_or(|nm| f.wavelength_nm == Some(nm));
        let component = self.component.is_none() || self.component == f.component;
        f.name == self.figure && wavelength && component
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.figure)?;
        self.component.as_ref().map_or(Ok(()), |c| write!(f, "[{c}]"))?;
        self.wavelength_nm.map_or(Ok(()), |nm| write!(f, "@{nm}"))?;
        match self.within {
            // As parse reads it, to the last bit.
            Within::Relative(x) => write!(f, ":{}%", percent(x)),
            Within::Absolute(x) => write!(f, ":{x}"),
        }
    }
}

/// The number whose hundredth is `x`.
fn percent(x: f64) -> f64 {
    let near = 100.0 * x;
    let rounded: f64 = format!("{near:.12e}").parse().unwrap_or(near);
    if rounded / 100.0 == x { rounded } else { near }
}

/// Whether targets are looked at after so many batches: from [`FLOOR`] on, four times per doubling
/// (10, 12, 14, 16, 20, 24 …).
pub fn is_look(batches: u64) -> bool {
    batches >= FLOOR && batches.trailing_zeros() + 3 >= u64::BITS - batches.leading_zeros()
}

/// A wanted figure at a look.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Seen {
    /// The target as typed.
    pub target: String,
    /// The figure.
    pub figure: String,
    /// Value.
    pub value: Option<f64>,
    /// Standard error.
    pub error: Option<f64>,
    /// Lower end of the 95 % interval.
    pub low95: Option<f64>,
    /// Upper end of the 95 % interval.
    pub high95: Option<f64>,
    /// Unit.
    pub unit: String,
    /// Standard error wanted.
    pub wanted: Option<f64>,
    /// It is reached.
    pub met: bool,
    /// Histories per wavelength group that should reach it, (error/wanted)² of those done.
    pub histories: Option<u64>,
    /// Why it is not reached, or what to know.
    pub note: Option<String>,
}

/// Looks at the figures of a run of so many batches. Every target is met or not; a target of several
/// figures (wavelengths, components) has a line for each.
pub fn look(targets: &[Target], result: &RunResult, batches: u64) -> Vec<Seen> {
    let mut out = Vec::new();
    for target in targets {
        let before = out.len();
        out.extend(
            result.figures.iter().filter(|f| target.means(f)).map(|f| seen(target, f, result, batches)),
        );
        if out.len() == before {
            let note = Some("no such figure so far: nothing was counted".to_owned());
            let (unit, figure) = ("1".to_owned(), target.figure.clone());
            let (value, error, low95, high95, wanted, histories) = (None, None, None, None, None, None);
            let target = target.to_string();
            out.push(Seen {
                target,
                figure,
                value,
                error,
                low95,
                high95,
                unit,
                wanted,
                met: false,
                histories,
                note,
            });
        }
    }
    out
}

fn seen(target: &Target, f: &Figure, result: &RunResult, batches: u64) -> Seen {
    let value = f.value.filter(|_| f.status != Status::UpperBound);
    let wanted = match target.within {
        Within::Relative(x) => value.map(|v| x * v.abs()),
        Within::Absolute(x) => Some(x),
    };
    let dof = f.dof.unwrap_or(0.0);
    let replicas = dof < batches as f64 && dof.fract() == 0.0;
    let doubtful = match f.status {
        Status::UpperBound => Some("nothing was counted"),
        Status::NotAvailable => Some("not available"),
        _ if replicas && batches < REPLICAS => Some("too few batches for its error"),
        _ if !replicas && dof < SPREAD => Some("unreliable: rare high scores rule its error"),
        _ => None,
    };
    let close = f.error.zip(wanted).is_some_and(|(e, w)| e <= w);
    let need = f.error.zip(wanted).filter(|(_, w)| *w > 0.0).map(|(e, w)| {
        let n = result.histories as f64 * (e / w) * (e / w);
        n.max(if replicas { (REPLICAS * crate::run::BATCH) as f64 } else { 0.0 }).ceil() as u64
    });
    let interval = f.interval95().filter(|_| value.is_some());
    let note = doubtful.map(str::to_owned).or_else(|| f.note.clone());
    Seen {
        target: target.to_string(),
        figure: f.title(),
        value,
        error: f.error,
        low95: interval.map(|i| i.0),
        high95: interval.map(|i| i.1),
        unit: f.unit.clone(),
        wanted,
        met: close && doubtful.is_none() && batches >= FLOOR,
        histories: need.filter(|_| f.status == Status::Ok || f.status == Status::Unreliable),
        note,
    }
}

/// Histories per wavelength group that should reach all targets: the most that any needs; `None` while a
/// figure has no error to judge by.
pub fn predicted(seen: &[Seen]) -> Option<u64> {
    seen.iter().map(|s| s.histories).collect::<Option<Vec<u64>>>()?.into_iter().max()
}

/// The targets for a terminal: figure, interval, what was wanted, whether it is met; then the figures of
/// the run whose errors cannot be believed, and those that nothing was counted of.
pub fn text(seen: &[Seen], result: &RunResult) -> String {
    let mut out = format!("targets after {} histories of each wavelength group\n", result.histories);
    for s in seen {
        let value = s.value.map_or("–".to_owned(), |v| with_error(v, s.error));
        let unit = if s.unit == "1" { String::new() } else { format!(" {}", s.unit) };
        let interval = s
            .low95
            .zip(s.high95)
            .map_or(String::new(), |(a, b)| format!(" (95 %: {} to {})", digits(a, 6), digits(b, 6)));
        let wanted = s.wanted.map_or(String::new(), |w| format!(", wanted ± {}", digits(w, 3)));
        let end = match (s.met, s.histories) {
            (true, _) => "met".to_owned(),
            (false, Some(n)) => format!("NOT met; about {n} histories would"),
            (false, None) => "NOT met".to_owned(),
        };
        let note = s.note.as_ref().map_or(String::new(), |n| format!("; {n}"));
        out += &format!("  {}  {value}{unit}{interval}{wanted}: {end}{note}\n", s.figure);
    }
    for (status, words) in [
        (Status::Unreliable, "errors not to be believed"),
        (Status::UpperBound, "nothing counted, upper bounds"),
    ] {
        let names: Vec<String> =
            result.figures.iter().filter(|f| f.status == status).map(Figure::title).collect();
        if !names.is_empty() {
            out += &format!("  {words}: {}\n", names.join(", "));
        }
    }
    out
}

/// Targets whose figure the scene does not have, in words; `probe` is the result of a short run of it.
///
/// # Errors
/// The first such target and the figures that there are.
pub fn check(targets: &[Target], probe: &RunResult) -> Result<(), String> {
    for t in targets {
        let named: Vec<&Figure> = probe.figures.iter().filter(|f| f.name == t.figure).collect();
        if named.is_empty() {
            let mut names: Vec<&str> = probe.figures.iter().map(|f| f.name.as_str()).collect();
            names.sort_unstable();
            names.dedup();
            return Err(format!(
                "--target {t}: the scene has no figure `{}`\nhelp: it has {}",
                t.figure,
                names.join(", ")
            ));
        }
        let at = |nm: f64| named.iter().any(|f| f.wavelength_nm == Some(nm));
        if let Some(nm) = t.wavelength_nm.filter(|nm| !at(*nm)) {
            return Err(format!("--target {t}: `{}` is not had at {nm} nm", t.figure));
        }
        let lacks = |f: &&&Figure| f.status == Status::NotAvailable && f.note.is_some();
        if let Some(f) = named.iter().find(lacks).filter(|_| named.len() == 1) {
            return Err(format!("--target {t}: {}", f.note.as_deref().unwrap_or_default()));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Ordered;

    fn result(figures: Vec<Figure>, histories: u64) -> RunResult {
        RunResult {
            lightpro: "0".into(),
            scene: "x".into(),
            complete: true,
            histories,
            figures,
            ledger: Ordered::default(),
            effects: Ordered::default(),
            memory: None,
            voxels: None,
        }
    }

    #[test]
    fn targets_are_read_and_written() {
        let t = Target::parse("reflectance:0.1%").unwrap();
        assert_eq!(
            (t.figure.as_str(), t.within, t.wavelength_nm),
            ("reflectance", Within::Relative(0.001), None)
        );
        let t = Target::parse("absorbed[birch wall]@550 nm:2e-4").unwrap();
        assert_eq!((t.component.as_deref(), t.wavelength_nm), (Some("birch wall"), Some(550.0)));
        assert_eq!(t.within, Within::Absolute(2e-4));
        for text in ["brightness:0.1", "reflectance@457.5:0.3%", "absorbed[a]:1e-5", "r0:0.07%", "s:12.7%"] {
            let t = Target::parse(text).unwrap();
            assert_eq!(Target::parse(&t.to_string()).unwrap(), t, "{t}");
        }
        for bad in ["", "reflectance", ":1%", "r:0%", "r:-1", "r:nan", "r@x:1%", "r[x:1%", "r:1 parsec"] {
            assert!(Target::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn looks_are_few_and_fixed() {
        let looks: Vec<u64> = (0..100).filter(|b| is_look(*b)).collect();
        assert_eq!(looks, [10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 56, 64, 80, 96]);
    }

    #[test]
    fn doubtful_errors_meet_no_target() {
        let t = [Target::parse("r:1%").unwrap()];
        let figure = |dof| Figure::new("r", 1.0, 0.009, "1").with_dof(dof);
        let met = |f: Figure, batches: u64| look(&t, &result(vec![f], 4096 * batches), batches)[0].met;
        assert!(met(figure(1e5), 10));
        assert!(!met(figure(1e5), 9), "below the floor");
        assert!(!met(figure(19.5), 10), "VOV above 0.1");
        assert!(!met(figure(9.0), 10), "10 replicas");
        assert!(met(figure(15.0), 16), "16 replicas");
        assert!(!met(figure(1e5).with_status(Status::UpperBound), 10));
        let seen = look(&t, &result(vec![], 40960), 10);
        assert!(!seen[0].met && seen[0].note.is_some() && predicted(&seen).is_none());
    }

    #[test]
    fn predictions_follow_the_square_root() {
        let t = [Target::parse("r:1%").unwrap()];
        let f = Figure::new("r", 0.5, 0.01, "1").with_dof(1e5);
        let seen = look(&t, &result(vec![f], 40960), 10);
        assert_eq!(predicted(&seen), Some(4 * 40960));
        assert!(text(&seen, &result(vec![], 40960)).contains("NOT met; about 163840"));
    }
}
