//! Document → [`Scene`]: placeholders, table checks, references, files, consistency.

mod bodies;
mod check;
mod conversion;
mod files;
mod law;
mod light;
mod materials;
mod mixture;
mod node;
mod sheet;
pub mod topography;
mod voxel;

use super::diagnostic::{Diagnostic, Diagnostics, Place, SourceFile, nearest};
use super::document::{self, Element, MAX_BYTES};
use super::effects::{self, Lines, Override};
use super::model::{Scene, Universe};
use super::table;
pub use check::{implied_coarseness, section_areas};
use node::Node;
use std::path::{Path, PathBuf};

/// How a scene is read.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Files outside the scene's folder tree may be read.
    pub allow_outside: bool,
    /// Values of placeholders from the command line, `-D name=value`; they override `<define>`.
    pub defines: Vec<(String, String)>,
    /// Decisions on effects from the command line; they come beside those of the scene.
    pub effects: Vec<Override>,
}

/// A placeholder's value and who asked for it.
struct Define {
    name: String,
    value: String,
    /// Place of its `<define>`; None: given on the command line only.
    place: Option<Place>,
    overridden: bool,
    used: bool,
}

/// State of one reading: everything found so far.
struct Reading<'o> {
    out: Diagnostics,
    options: &'o Options,
    /// Folders that files may come from, absolute.
    roots: Vec<PathBuf>,
    files: Vec<(PathBuf, u64)>,
    defines: Vec<Define>,
    wavelengths: Vec<f64>,
    materials: Vec<String>,
    surfaces: Vec<String>,
    /// The sheet is deposited: fibres need a length.
    deposits: bool,
    /// Polarised light or an analyser: laws without a state are refused.
    polarised: bool,
    lines: Lines,
}

/// Reads a scene file.
///
/// # Errors
/// All errors of the file, each with its place; also where the file cannot be read.
pub fn read(path: &Path, options: &Options) -> Result<Scene, Diagnostics> {
    match files::load(path) {
        Ok(text) => read_text(&text, path, options),
        Err(why) => {
            let mut out = Diagnostics::default();
            out.push(Diagnostic::nowhere(format!("{}: {why}", path.display())));
            Err(out)
        }
    }
}

/// Reads a scene from text; `path` is where it stands (or would stand): file names in it are relative
/// to its folder.
///
/// # Errors
/// All errors of the text, each with its place.
pub fn read_text(text: &str, path: &Path, options: &Options) -> Result<Scene, Diagnostics> {
    let mut r = Reading::new(text, path, options);
    if text.len() as u64 > MAX_BYTES {
        r.out.push(Diagnostic::nowhere(format!("{}: {}", path.display(), files::TOO_LARGE)));
        return Err(r.out);
    }
    let Some(root) = r.settled(text) else { return Err(r.out) };
    let rule = table::rule("scene");
    table::check(&root, rule, false, &mut r.out);
    let node = Node::new(&root, rule);
    let mut scene = r.scene(node);
    r.effects(node.child("effects"), &mut scene);
    r.unused_defines();
    if r.out.error_count() == 0 {
        r.unused(&root);
    }
    if r.out.error_count() > 0 {
        return Err(r.out);
    }
    let warnings = r.out.warnings().map(|d| r.out.render_one(d, false)).collect();
    let mut scene = Scene { path: path.to_path_buf(), warnings, files: r.files, lines: r.lines, ..scene };
    if let Err(why) = effects::apply(&mut scene, options.effects.clone()) {
        r.out.push(Diagnostic::nowhere(format!("{}: {why}", path.display())));
        return Err(r.out);
    }
    Ok(scene)
}

/// The elements of a scene as they are read: with what it includes, placeholders filled, values of the command line
/// set. Places still tell where in `text` each stands.
///
/// # Errors
/// XML that cannot be read, placeholders without a value.
pub(super) fn settled(text: &str, path: &Path, options: &Options) -> Result<Element, Diagnostics> {
    let mut r = Reading::new(text, path, options);
    match r.settled(text) {
        Some(root) if r.out.error_count() == 0 => Ok(root),
        _ => Err(r.out),
    }
}

impl<'o> Reading<'o> {
    fn new(text: &str, path: &Path, options: &'o Options) -> Self {
        let mut out = Diagnostics::default();
        out.files.push(SourceFile { path: path.to_path_buf(), text: text.to_string() });
        Reading {
            out,
            options,
            roots: files::roots(path),
            files: vec![(path.to_path_buf(), files::fnv(text.as_bytes()))],
            defines: Vec::new(),
            wavelengths: Vec::new(),
            materials: Vec::new(),
            surfaces: Vec::new(),
            polarised: false,
            deposits: false,
            lines: Lines::new(),
        }
    }

    fn error(&mut self, place: Place, message: impl Into<String>) {
        self.out.push(Diagnostic::error(place, message));
    }

    /// The parts in the order in which they need each other. After an error the rest is still read
    /// with stand-in values, so that all errors of a file come at once; the scene is then refused.
    fn scene(&mut self, root: Node<'_>) -> Scene {
        root.children("define").for_each(|d| d.use_all());
        let _ = root.text("version");
        for name in ["source", "spectrum", "detect", "optics", "run"] {
            if let Some(e) = root.child(name) {
                self.line(name, e);
            }
        }
        self.wavelengths = self.spectrum(root.child("spectrum"));
        let asks = |name: &str, what: &str| {
            root.child(name).is_some_and(|e| e.has(what) && e.text(what) != Some("none"))
        };
        self.polarised = asks("source", "polarisation") || asks("detect", "analyser");
        let materials = self.materials(root.child("materials"));
        let surfaces = self.surfaces(root.child("surfaces"));
        let universe = self.universe(root.child("universe"), &materials, &surfaces);
        let optics = root.child("optics");
        let source = self.source(root.child("source"), !matches!(universe, Universe::Synthetic(_)), optics);
        let polarised = root.child("source").and_then(|e| self.polarisation(e));
        let run = self.run(root.child("run"), &universe);
        let detect = self.detect(root.child("detect"), &source, &run);
        let optics = optics.map(|o| self.optics(o, &source));
        Scene {
            name: root.text("name").unwrap_or_default().to_string(),
            path: PathBuf::new(),
            materials,
            surfaces,
            universe,
            source,
            polarised,
            wavelengths: self.wavelengths.clone(),
            detect,
            optics,
            run,
            overrides: Vec::new(),
            lines: Lines::new(),
            expects: root.children("expect").map(|e| self.expect(e)).collect(),
            warnings: Vec::new(),
            files: Vec::new(),
        }
    }

    /// The document with what it includes, placeholders filled and values of the command line in their places.
    fn settled(&mut self, text: &str) -> Option<Element> {
        let mut root = document::parse(text, 0).map_err(|d| self.out.push(*d)).ok()?;
        if root.name != table::rule("scene").name() {
            let d = Diagnostic::error(root.place, format!("the root element is <{}>", root.name));
            self.out.push(d.help("a scene begins with <scene name=\"…\" version=\"1\">"));
            return None;
        }
        self.includes(&mut root);
        self.collect_defines(&root);
        self.expand(&mut root);
        self.set_attributes(&mut root);
        Some(root)
    }

    fn collect_defines(&mut self, root: &Element) {
        for e in root.children.iter().filter(|c| c.name == "define") {
            let (Some(name), Some(value)) = (e.attribute("name"), e.attribute("value")) else { continue };
            if let Some(first) = self.defines.iter().find(|d| d.name == name.value) {
                let mut d = Diagnostic::error(name.value_place, format!("`{}` is defined twice", name.value));
                d.other = first.place.map(|p| (p, "first here".into()));
                self.out.push(d);
                continue;
            }
            self.defines.push(Define {
                name: name.value.clone(),
                value: value.value.clone(),
                place: Some(name.value_place),
                overridden: false,
                used: false,
            });
        }
        for (name, value) in self.options.defines.iter().filter(|d| !d.0.contains('.')) {
            match self.defines.iter_mut().find(|d| d.name == *name) {
                Some(d) => (d.value, d.overridden) = (value.clone(), true),
                None => self.defines.push(Define {
                    name: name.clone(),
                    value: value.clone(),
                    place: None,
                    overridden: true,
                    used: false,
                }),
            }
        }
    }

    /// Fills the placeholders in all attribute values below `e`.
    fn expand(&mut self, e: &mut Element) {
        for a in e.attributes.iter_mut().filter(|a| a.value.contains("${")) {
            let mut value = String::new();
            let mut rest = a.value.as_str();
            while let Some((before, tail)) = rest.split_once("${") {
                value += before;
                let (name, after) = match tail.split_once('}') {
                    Some((name, after)) => (name, after),
                    None => {
                        a.broken = true;
                        let d = Diagnostic::error(a.value_place, "a placeholder without `}`");
                        self.out.push(d.help("placeholders are written ${name}"));
                        (tail, "")
                    }
                };
                match self.defines.iter_mut().find(|d| d.name == name) {
                    Some(d) => {
                        d.used = true;
                        value += &d.value;
                    }
                    None if a.broken => {}
                    None => {
                        a.broken = true;
                        self.out.push(undefined(name, a.value_place, &self.defines));
                    }
                }
                rest = after;
            }
            a.value = value + rest;
        }
        for child in &mut e.children {
            self.expand(child);
        }
    }

    /// `-D element.attribute=value`: the element by its `id` or `name`, or by its own name if there is only
    /// one of it.
    fn set_attributes(&mut self, root: &mut Element) {
        let options = self.options;
        for (path, value) in options.defines.iter().filter(|d| d.0.contains('.')) {
            let (which, attribute) = path.rsplit_once('.').unwrap_or((path, ""));
            let found = root.count_matching(which);
            let problem = match found {
                1 => {
                    root.set_matching(which, attribute, value);
                    continue;
                }
                0 => format!(
                    "-D {path}={value}: no element has the id or name `{which}`, and none is <{which}>"
                ),
                n => format!("-D {path}={value}: {n} elements are called `{which}`"),
            };
            let d = Diagnostic::nowhere(problem);
            self.out.push(
                d.help("written id.attribute, as in wall.index, or element.attribute, as in source.polar"),
            );
        }
    }

    /// A `-D` that nothing asks for is a mistyped name; a `<define>` likewise.
    fn unused_defines(&mut self) {
        for d in self.defines.iter().filter(|d| !d.used) {
            let names = self.defines.iter().filter(|o| o.name != d.name).map(|o| o.name.as_str());
            let message = format!("no attribute asks for ${{{}}}", d.name);
            let mut diagnostic = match d.place {
                Some(place) => Diagnostic::error(place, message),
                None => Diagnostic::nowhere(format!("-D {}={}: {message}", d.name, d.value)),
            };
            if let Some(n) = nearest(&d.name, names) {
                diagnostic = diagnostic.help(format!("did you mean `{n}`?"));
            }
            self.out.push(diagnostic);
        }
    }

    /// Attributes and elements that are known but that nothing asked for: they would have no effect.
    fn unused(&mut self, e: &Element) {
        for a in e.attributes.iter().filter(|a| !a.used.get()) {
            let d = Diagnostic::error(a.name_place, format!("attribute `{}` has no effect here", a.name));
            let doc = table::RULES.iter().filter(|r| r.name() == e.name).find_map(|r| r.attribute(&a.name));
            self.out.push(match doc {
                Some(rule) => d.label("not used").help(format!("{}: {}", a.name, rule.doc)),
                None => d.label("not used"),
            });
        }
        for c in &e.children {
            if c.used.get() {
                self.unused(c);
            } else {
                self.out.push(
                    Diagnostic::error(c.place, format!("<{}> has no effect here", c.name)).label("not used"),
                );
            }
        }
    }
}

fn undefined(name: &str, place: Place, defines: &[Define]) -> Diagnostic {
    let names: Vec<&str> = defines.iter().map(|d| d.name.as_str()).collect();
    let d = Diagnostic::error(place, format!("the placeholder ${{{name}}} has no value"));
    match nearest(name, names.iter().copied()) {
        Some(n) => d.label(format!("did you mean ${{{n}}}?")),
        None => d.help(format!(
            "add <define name=\"{name}\" value=\"…\"/> at the top of the scene, or -D {name}=…"
        )),
    }
}
