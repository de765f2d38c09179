//! Materials and surfaces.

use super::{Node, Reading};
use crate::material::RefractiveIndex;
use crate::phase::Phase;
use crate::scene::adapters;
use crate::scene::diagnostic::{Diagnostic, Place, nearest};
use crate::scene::model::*;
use crate::spectrum::Spectrum;
use crate::universe::{MediumId, SurfaceId};

impl Reading<'_> {
    pub fn materials(&mut self, e: Option<Node<'_>>) -> Vec<Material> {
        let list: Vec<Node<'_>> = e.iter().flat_map(|e| e.children("material")).collect();
        self.materials = self.ids(&list, &[]);
        list.into_iter().map(|m| self.one_material(m)).collect()
    }

    /// Ids of elements; told where one comes twice. The list keeps its length and order.
    fn ids(&mut self, list: &[Node<'_>], reserved: &[&str]) -> Vec<String> {
        let ids: Vec<String> = list.iter().map(|m| m.text("id").unwrap_or_default().to_string()).collect();
        for (i, id) in ids.iter().enumerate().filter(|(_, id)| !id.is_empty()) {
            if reserved.contains(&id.as_str()) {
                self.error(list[i].place("id"), format!("the id `{id}` is taken: it is always there"));
            } else if let Some(first) = ids[..i].iter().position(|o| o == id) {
                self.out.push(
                    Diagnostic::error(list[i].place("id"), format!("the id `{id}` is given twice"))
                        .label("again")
                        .other(list[first].place("id"), "first here"),
                );
            }
        }
        ids
    }

    fn one_material(&mut self, e: Node<'_>) -> Material {
        self.line(format!("material {}", e.text("id").unwrap_or_default()), e);
        let index = self.index(e);
        let absorption = e
            .one_of(self, &["absorption", "absorption-file"], None)
            .and_then(|which| self.spectrum_or_file(e, which, (0.0, f64::INFINITY)));
        let mut scattering: Vec<Scatterer> = Vec::new();
        scattering.extend(e.children("scattering").map(|s| self.scattering(s)));
        scattering.extend(e.children("particles").map(|p| self.mie(p)));
        let conversions = self.conversions(e);
        let sap = e.child("sap").map(|s| self.patches(s));
        let id = e.text("id").unwrap_or_default().to_string();
        Material { id, index, absorption, scattering, conversions, sap }
    }

    /// `index` and `kappa`, or `index-file`.
    fn index(&mut self, e: Node<'_>) -> RefractiveIndex {
        let stand_in = || adapters::index(adapters::flat(1.0), None);
        match e.one_of(self, &["index", "index-file"], Some("a refractive index")) {
            Some("index") => {
                let k = e.number("kappa").filter(|k| *k > 0.0).map(adapters::flat);
                adapters::index(adapters::flat(e.number("index").unwrap_or(1.0)), k)
            }
            Some(_) => self.index_file(e).unwrap_or_else(stand_in),
            None => stand_in(),
        }
    }

    fn index_file(&mut self, e: Node<'_>) -> Option<RefractiveIndex> {
        let a = e.attribute("index-file")?;
        let clamp = e.text("extrapolate") == Some("clamp");
        let (path, text) = self.file(a)?;
        let name = short(&path);
        let (n, k) = match adapters::index_rii(&text, &name) {
            Ok(found) => found,
            Err(why) => {
                self.error(a.value_place, why);
                return None;
            }
        };
        let n = self.ranged(n, &name, "n", clamp, a.value_place)?;
        let k = match k {
            Some(k) => Some(self.ranged(k, &name, "κ", clamp, a.value_place)?),
            None => None,
        };
        let index = adapters::index(n, k);
        for nm in self.wavelengths.clone() {
            if let Err(why) = adapters::index_at(&index, nm) {
                self.error(a.value_place, format!("{name}: {why}"));
                return None;
            }
        }
        Some(index)
    }

    /// A constant attribute `name`, or the CSV file of `name-file`; values must lie in `limits`.
    pub(super) fn spectrum_or_file(
        &mut self,
        e: Node<'_>,
        which: &str,
        limits: (f64, f64),
    ) -> Option<Spectrum> {
        let Some(quantity) = which.strip_suffix("-file") else { return e.number(which).map(adapters::flat) };
        let a = e.attribute(which)?;
        let clamp = e.text("extrapolate") == Some("clamp");
        let (path, text) = self.file(a)?;
        let name = short(&path);
        let found = match adapters::spectrum_csv(&text, &name) {
            Ok(s) => s,
            Err(why) => {
                self.error(a.value_place, why);
                return None;
            }
        };
        let found = self.ranged(found, &name, quantity, clamp, a.value_place)?;
        for nm in self.wavelengths.clone() {
            let value = found.at(nm).unwrap_or(limits.0);
            if !(limits.0..=limits.1).contains(&value) {
                let d = Diagnostic::error(a.value_place, format!("{name}: {quantity} is {value} at {nm} nm"));
                self.out.push(d.help(format!("allowed: {} to {}", limits.0, limits.1)));
                return None;
            }
        }
        Some(found)
    }

    /// The spectrum, known at every wavelength of the scene; clamped with a warning if it is told so.
    fn ranged(&mut self, s: Spectrum, file: &str, what: &str, clamp: bool, place: Place) -> Option<Spectrum> {
        let Some((low, high)) = adapters::range(&s) else { return Some(s) };
        let inside = |nm: f64| s.at(nm).is_ok();
        let outside: Vec<f64> = self.wavelengths.iter().copied().filter(|nm| !inside(*nm)).collect();
        let (Some(first), Some(last)) = (outside.first(), outside.last()) else { return Some(s) };
        let asked = if first == last { format!("{first} nm") } else { format!("{first} … {last} nm") };
        let message =
            format!("{file}: {what} is known from {low} nm to {high} nm, the scene asks for {asked}");
        if !clamp {
            self.out.push(
                Diagnostic::error(place, message)
                    .label("wavelength outside this table")
                    .help("change <spectrum>, or hold the end values with extrapolate=\"clamp\""),
            );
            return None;
        }
        match adapters::clamped(s) {
            Some(s) => {
                self.out.push(Diagnostic::warning(place, format!("{message}; its end values are held")));
                Some(s)
            }
            None => {
                let d = Diagnostic::error(place, message);
                self.out.push(
                    d.help("a dispersion formula beyond its range is no measurement: it is not clamped"),
                );
                None
            }
        }
    }

    fn scattering(&mut self, e: Node<'_>) -> Scatterer {
        let mu_s = e
            .one_of(self, &["mu-s", "mu-s-file"], Some("a scattering coefficient"))
            .and_then(|which| self.spectrum_or_file(e, which, (0.0, f64::INFINITY)))
            .unwrap_or(adapters::flat(0.0));
        let phase = match e.text("phase").unwrap_or(if e.has("g") { "hg" } else { "isotropic" }) {
            "hg" => e.needed(self, "g", "phase `hg`").map(adapters::henyey_greenstein),
            "two-term-hg" => {
                let mut n = |name| e.needed(self, name, "phase `two-term-hg`");
                let (w, g1, g2) = (n("w"), n("g1"), n("g2"));
                w.zip(g1).zip(g2).map(|((w, g1), g2)| adapters::two_term(w, g1, g2))
            }
            "rayleigh" => Some(Ok(adapters::rayleigh())),
            "table" => self.phase_table(e),
            _ => None,
        };
        let depolarises = e.yes("depolarises");
        if depolarises && matches!(phase, Some(Ok(Phase::Rayleigh))) {
            self.error(e.place("depolarises"), "Rayleigh scattering has a matrix: it does not depolarise");
        }
        if self.polarised && !depolarises && !matches!(phase, Some(Ok(Phase::Rayleigh))) {
            let d = Diagnostic::error(e.own.place, "this law says nothing of polarised light");
            self.out.push(d.help(
                "scattering with a matrix is <particles …> (Mie) or phase=\"rayleigh\"; or say depolarises=\"yes\"",
            ));
        }
        let phase = phase.and_then(|p| p.map_err(|why| self.error(e.own.place, why)).ok());
        Scatterer::Coefficient { mu_s, phase: phase.unwrap_or(Phase::Isotropic) }
    }

    fn phase_table(&mut self, e: Node<'_>) -> Option<Result<Phase, String>> {
        let Some(a) = e.attribute("file") else {
            self.error(e.own.place, "<scattering> with phase `table` needs `file`");
            return None;
        };
        let (path, text) = self.file(a)?;
        Some(adapters::phase_table(&text, &short(&path)))
    }

    fn mie(&mut self, own: Node<'_>) -> Scatterer {
        let base = self.distribution(own, "filler");
        let e = Node { base: base.as_ref(), ..own };
        let _ = (e.text("name"), e.text("density"));
        let diameter = self.size(e, "diameter", 3.0, 1.0, None);
        let index = self.index(e);
        let amounts = ["volume-fraction", "mass-concentration"];
        let volume_fraction = match e.one_of(self, &amounts, Some("an amount")) {
            Some("mass-concentration") => {
                let density = e.needed(self, "density", "`mass-concentration`");
                let share = e.number("mass-concentration").zip(density).map_or(0.0, |(c, d)| c / d);
                if share > 0.5 {
                    let d = Diagnostic::error(
                        e.place("mass-concentration"),
                        format!("the particles would fill {:.1} % of the medium", 100.0 * share),
                    );
                    self.out.push(d.help("particles of independent scattering are far apart: at most 50 %"));
                }
                share
            }
            _ => e.number("volume-fraction").unwrap_or(0.0),
        };
        let fibril = e.text("shape") == Some("fibril");
        if fibril && self.polarised {
            let d = Diagnostic::error(e.place("shape"), "fibrils say nothing of polarised light");
            self.out.push(d.help("shape=\"sphere\" has a matrix; or leave the polarisation out"));
        }
        Scatterer::Mie {
            shape: if fibril { ParticleShape::Fibril } else { ParticleShape::Sphere },
            diameter: diameter.unwrap_or(crate::law::SizeLaw::Constant(1.0)),
            index,
            volume_fraction,
        }
    }

    pub fn surfaces(&mut self, e: Option<Node<'_>>) -> Vec<Surface> {
        let list: Vec<Node<'_>> = e.iter().flat_map(|e| e.children("surface")).collect();
        let ids = self.ids(&list, &["smooth"]);
        self.surfaces = std::iter::once("smooth".to_string()).chain(ids).collect();
        let smooth = Surface {
            id: "smooth".into(),
            kind: SurfaceKind::Smooth,
            ratio: Ratio::Fresnel,
            opaque: false,
            sap: None,
        };
        std::iter::once(smooth).chain(list.into_iter().map(|s| self.surface(s))).collect()
    }

    fn surface(&mut self, e: Node<'_>) -> Surface {
        self.line(format!("surface {}", e.text("id").unwrap_or_default()), e);
        let kind = match e.text("kind") {
            Some("lambertian") => SurfaceKind::Lambertian { per_patch: e.yes("per-patch") },
            Some("rough") => SurfaceKind::Rough {
                slopes: match e.text("slopes") {
                    Some("exponential") => Slopes::Exponential,
                    Some("ggx") => Slopes::Ggx,
                    _ => Slopes::Gaussian,
                },
                m: e.needed(self, "m", "kind `rough`").unwrap_or(0.0),
                multiple_bounce: match e.text("multiple-bounce") {
                    Some("renormalised") => MultipleBounce::Renormalised,
                    Some("walk") => self.walk(e),
                    _ => MultipleBounce::Off,
                },
            },
            _ => SurfaceKind::Smooth,
        };
        let ratio = match e.one_of(self, &["ratio", "reflectance", "reflectance-file", "film-index"], None) {
            Some("film-index") => {
                let thickness = e.needed(self, "film-thickness", "`film-index`");
                e.number("film-index")
                    .zip(thickness)
                    .map(|(index, thickness)| Ratio::Film { index, thickness })
            }
            Some("reflectance-file") => self.reflectance_file(e),
            Some("reflectance") => e.number("reflectance").map(|x| Ratio::Spectrum(adapters::flat(x))),
            _ if e.text("ratio") == Some("paper-amplitude") => Some(Ratio::PaperAmplitude),
            _ => None,
        };
        let sap = e.child("sap").map(|s| self.patches(s));
        if let (SurfaceKind::Lambertian { per_patch: true }, None) = (kind, sap) {
            self.error(
                e.place("per-patch"),
                "equal power per patch needs patches: a <sap nside=…> in this surface",
            );
        }
        let id = e.text("id").unwrap_or_default().to_string();
        Surface { id, kind, ratio: ratio.unwrap_or(Ratio::Fresnel), opaque: e.yes("opaque"), sap }
    }

    /// A walk between facets, where it is possible.
    fn walk(&mut self, e: Node<'_>) -> MultipleBounce {
        let why = if e.text("slopes") == Some("ggx") {
            Some(("heights and slopes of GGX have no walk here", "slopes=\"gaussian\" or \"exponential\""))
        } else if e.child("sap").is_some() {
            Some(("patches hold single bounces", "without <sap>, or multiple-bounce=\"renormalised\""))
        } else if self.polarised {
            Some(("walks keep no state of polarisation", "multiple-bounce=\"off\" or \"renormalised\""))
        } else {
            None
        };
        if let Some((problem, help)) = why {
            let d = Diagnostic::error(e.place("multiple-bounce"), problem);
            self.out.push(d.help(help));
        }
        MultipleBounce::Walk
    }

    fn patches(&mut self, e: Node<'_>) -> SapSpec {
        if self.polarised {
            let d = Diagnostic::error(e.own.place, "patches know no plane of reference for polarised light");
            self.out.push(d.help("the continuous law: without <sap>"));
        }
        sap(e)
    }

    /// Two columns: a spectrum. More: a table over wavelength (rows) and incidence angle (columns).
    fn reflectance_file(&mut self, e: Node<'_>) -> Option<Ratio> {
        let a = e.attribute("reflectance-file")?;
        let (path, text) = self.file(a)?;
        let (header, rows) = match super::files::csv_rows(&text) {
            Ok(found) => found,
            Err((line, why)) => {
                self.error(a.value_place, format!("{}:{line}: {why}", path.display()));
                return None;
            }
        };
        if rows.first().is_none_or(|r| r.1.len() <= 2) {
            return self.spectrum_or_file(e, "reflectance-file", (0.0, 1.0)).map(Ratio::Spectrum);
        }
        match reflectance_table(&header, &rows, &self.wavelengths, e.text("extrapolate") == Some("clamp")) {
            Ok(ratio) => Some(ratio),
            Err(why) => {
                self.error(a.value_place, format!("{}: {why}", short(&path)));
                None
            }
        }
    }

    /// The material that an attribute names.
    pub fn material(&mut self, e: Node<'_>, name: &str) -> Option<MediumId> {
        let id = e.text(name)?;
        let found = self.materials.iter().position(|m| m == id);
        if found.is_none() && !id.is_empty() {
            let d = Diagnostic::error(e.place(name), format!("no material has the id `{id}`"));
            let d = with_nearest(d, id, &self.materials);
            self.out.push(d);
        }
        Some(MediumId(u16::try_from(found.unwrap_or(0)).unwrap_or(0)))
    }

    /// The surface that an attribute names.
    pub fn surface_id(&mut self, e: Node<'_>, name: &str) -> SurfaceId {
        let Some(id) = e.text(name) else { return SurfaceId::SMOOTH };
        let found = self.surfaces.iter().position(|s| s == id);
        if found.is_none() && !id.is_empty() {
            let d = Diagnostic::error(e.place(name), format!("no surface has the id `{id}`"));
            let d = with_nearest(d, id, &self.surfaces);
            self.out.push(d);
        }
        SurfaceId(u16::try_from(found.unwrap_or(0)).unwrap_or(0))
    }
}

fn with_nearest(d: Diagnostic, id: &str, known: &[String]) -> Diagnostic {
    let d = match nearest(id, known.iter().map(String::as_str)) {
        Some(n) => d.label(format!("did you mean `{n}`?")),
        None => d.label("not defined"),
    };
    if known.is_empty() {
        d.help("the scene defines none")
    } else {
        d.help(format!("defined: {}", known.join(", ")))
    }
}

/// A path's last part, for messages.
pub(super) fn short(path: &std::path::Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned())
}

fn sap(e: Node<'_>) -> SapSpec {
    SapSpec {
        nside: e.nside("nside").unwrap_or(1),
        populate: if e.text("populate") == Some("centre") { Populate::Centre } else { Populate::Exact },
        directions: match e.text("directions") {
            Some("centre") => Directions::Centre,
            Some("uniform") => Directions::Uniform,
            _ => Directions::Density,
        },
        frame: if e.text("frame") == Some("rotated") { SapFrame::Rotated } else { SapFrame::Resolved },
        roll_random: e.text("roll") != Some("fixed"),
    }
}

fn reflectance_table(
    header: &[String],
    rows: &[(u64, Vec<f64>)],
    scene: &[f64],
    clamp: bool,
) -> Result<Ratio, String> {
    let degree = |h: &String| h.trim_end_matches("deg").trim_end_matches('°').trim().parse::<f64>().ok();
    let angles: Vec<f64> = header.iter().skip(1).filter_map(degree).collect();
    if angles.len() + 1 != header.len() || angles.len() < 2 {
        return Err("the header must give the incidence angles in degrees: wavelength_nm,0,15,…,90".into());
    }
    if angles[0] != 0.0 || angles[angles.len() - 1] != 90.0 || angles.windows(2).any(|w| w[0] >= w[1]) {
        return Err("the incidence angles must ascend from 0 to 90 degrees".into());
    }
    let (mut wavelengths, mut values): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    for (line, row) in rows {
        if row.len() != angles.len() + 1 {
            return Err(format!("line {line}: {} columns where the header has {}", row.len(), header.len()));
        }
        if wavelengths.last().is_some_and(|w| *w >= row[0]) {
            return Err(format!("line {line}: wavelengths must ascend"));
        }
        if let Some(bad) = row[1..].iter().find(|v| !(0.0..=1.0).contains(*v)) {
            return Err(format!("line {line}: reflectance {bad} is not between 0 and 1"));
        }
        wavelengths.push(row[0]);
        values.extend(&row[1..]);
    }
    let (low, high) = (wavelengths[0], wavelengths[wavelengths.len() - 1]);
    if let Some(nm) = scene.iter().find(|nm| !clamp && !(low..=high).contains(*nm)) {
        return Err(format!("reflectance is known from {low} nm to {high} nm, the scene asks for {nm} nm"));
    }
    let angles = angles.iter().map(|a| a * (crate::math::PI / 180.0)).collect();
    Ok(Ratio::Table { wavelengths, angles, values })
}
