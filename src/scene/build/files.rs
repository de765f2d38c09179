//! Files that a scene names: where they may be, how they are read, what they hash to.

use super::{Node, Reading};
use crate::scene::diagnostic::{Diagnostic, SourceFile, nearest};
use crate::scene::document::{self, Attribute, Element, MAX_BYTES};
use crate::scene::table;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

pub const TOO_LARGE: &str = "the file is larger than 64 MiB";

/// 64-bit FNV-1a of bytes, for the manifest: detects change, not forgery.
pub fn fnv(bytes: &[u8]) -> u64 {
    fnv_on(0xcbf2_9ce4_8422_2325, bytes)
}

fn fnv_on(hash: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(hash, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
}

/// A text file of at most 64 MiB.
pub fn load(path: &Path) -> Result<String, String> {
    let file = std::fs::File::open(path).map_err(|e| plain(&e))?;
    if file.metadata().is_ok_and(|m| m.is_dir()) {
        return Err("is a folder".into());
    }
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(|e| plain(&e))?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(TOO_LARGE.into());
    }
    String::from_utf8(bytes).map_err(|e| format!("no UTF-8 text at byte {}", e.utf8_error().valid_up_to()))
}

fn plain(e: &std::io::Error) -> String {
    match e.kind() {
        std::io::ErrorKind::NotFound => "no such file".into(),
        std::io::ErrorKind::PermissionDenied => "may not be read (permission denied)".into(),
        _ => e.to_string(),
    }
}

/// Absolute path without `.` and `..`; links are followed as far as the path exists.
fn resolved(path: &Path) -> PathBuf {
    if let Ok(p) = path.canonicalize() {
        return p;
    }
    let mut out = PathBuf::new();
    for part in std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf()).components() {
        match part {
            Component::ParentDir => {
                out.pop();
            }
            Component::CurDir => {}
            part => out.push(part),
        }
    }
    match (out.parent(), out.file_name()) {
        (Some(parent), Some(name)) if parent.exists() => {
            parent.canonicalize().map(|p| p.join(name)).unwrap_or(out)
        }
        _ => out,
    }
}

/// Folders that a scene at `path` may read from: its own, and the nearest above that holds a
/// `distributions` folder.
pub fn roots(path: &Path) -> Vec<PathBuf> {
    let file = resolved(path);
    let folder = file.parent().unwrap_or(Path::new("/")).to_path_buf();
    let shared = folder.ancestors().find(|a| a.join("distributions").is_dir()).map(Path::to_path_buf);
    std::iter::once(folder).chain(shared).collect()
}

impl Reading<'_> {
    /// The file that an attribute names, as written and resolved, if it may be read.
    pub fn located(&mut self, a: &Attribute) -> Option<(PathBuf, PathBuf)> {
        let asking = self.out.files.get(a.value_place.file)?.path.clone();
        let folder = asking.parent().unwrap_or(Path::new(""));
        let path = folder.join(a.value.trim());
        self.allowed(a, path)
    }

    /// A path and what it resolves to, if the scene may read it.
    pub fn allowed(&mut self, a: &Attribute, path: PathBuf) -> Option<(PathBuf, PathBuf)> {
        let full = resolved(&path);
        if !self.options.allow_outside && !self.roots.iter().any(|r| full.starts_with(r)) {
            self.out.push(
                Diagnostic::error(
                    a.value_place,
                    format!("`{}` is outside the scene's folder", full.display()),
                )
                .label("leads out")
                .help(format!("allowed: {}", self.roots_text()))
                .help("move the file there, or allow files from anywhere with --allow-outside"),
            );
            return None;
        }
        Some((path, full))
    }

    /// Notes a file that the scene is made of, by the hash of its bytes, read in pieces.
    pub fn note_file(&mut self, path: &Path) -> Result<(), std::io::Error> {
        if self.files.iter().any(|f| f.0 == path) {
            return Ok(());
        }
        let mut file = std::fs::File::open(path)?;
        let (mut hash, mut piece) = (fnv(&[]), vec![0; 1 << 20]);
        loop {
            let n = file.read(&mut piece)?;
            if n == 0 {
                break;
            }
            hash = fnv_on(hash, &piece[..n]);
        }
        self.files.push((path.to_path_buf(), hash));
        Ok(())
    }

    /// The text of the file that an attribute names, and the file's name for messages.
    pub fn file(&mut self, a: &Attribute) -> Option<(PathBuf, String)> {
        let (path, full) = self.located(a)?;
        match load(&full) {
            Ok(text) => {
                if !self.files.iter().any(|f| f.0 == path) {
                    self.files.push((path.clone(), fnv(text.as_bytes())));
                }
                Some((path, text))
            }
            Err(why) => {
                let mut d = Diagnostic::error(a.value_place, format!("`{}`: {why}", full.display()));
                if let Some(near) = nearest_file(&full) {
                    d = d.help(format!("did you mean `{near}`?"));
                }
                self.out.push(d);
                None
            }
        }
    }

    fn roots_text(&self) -> String {
        let mut shown: Vec<String> = self.roots.iter().map(|r| r.display().to_string()).collect();
        shown.dedup();
        shown.join(", ")
    }

    /// The distribution file of `from=`: its one element, checked. `kind` is what the element may come
    /// from ("fibres", "flakes" or "filler").
    pub fn distribution(&mut self, e: Node<'_>, kind: &str) -> Option<Element> {
        let a = e.attribute("from")?;
        let (path, text) = self.file(a)?;
        let index = self.out.files.len();
        self.out.files.push(SourceFile { path, text: text.clone() });
        let mut root = match document::parse(&text, index) {
            Ok(root) => root,
            Err(d) => {
                self.out.push(*d);
                return None;
            }
        };
        let found = root.attribute("kind").map_or("", |k| k.value.trim()).to_string();
        if root.name != "distribution" || found != kind {
            let what = if root.name == "distribution" {
                format!("kind `{found}`")
            } else {
                format!("<{}>", root.name)
            };
            self.out.push(
                Diagnostic::error(
                    a.value_place,
                    format!("a distribution of kind `{kind}` is expected, the file holds {what}"),
                )
                .other(root.place, "this file"),
            );
            return None;
        }
        self.expand(&mut root);
        table::check(&root, table::rule(&format!("distribution/{kind}")), true, &mut self.out);
        let element = root.children.into_iter().find(|c| c.name == e.own.name);
        if element.is_none() {
            self.error(a.value_place, format!("the file holds no <{}>", e.own.name));
        }
        element
    }

    /// Puts the elements of included files in the place of every <include>; materials and surfaces join those
    /// of the scene.
    pub fn includes(&mut self, root: &mut Element) {
        let (parts, own): (Vec<Element>, Vec<Element>) =
            std::mem::take(&mut root.children).into_iter().partition(|c| c.name == "include");
        root.children = own;
        for part in parts {
            let Some(file) = part.attribute("file") else {
                self.error(part.place, "<include> needs the attribute `file`");
                continue;
            };
            for child in self.part(file).into_iter().flat_map(|p| p.children) {
                let joins = ["materials", "surfaces"].contains(&child.name.as_str());
                match root.children.iter_mut().find(|c| joins && c.name == child.name) {
                    Some(here) => here.children.extend(child.children),
                    None => root.children.push(child),
                }
            }
        }
    }

    /// The <scene-part> that a file holds.
    fn part(&mut self, a: &Attribute) -> Option<Element> {
        let (path, text) = self.file(a)?;
        let index = self.out.files.len();
        self.out.files.push(SourceFile { path, text: text.clone() });
        match document::parse(&text, index) {
            Ok(root) if root.name == "scene-part" => Some(root),
            Ok(root) => {
                let d = Diagnostic::error(a.value_place, format!("the file holds <{}>", root.name));
                self.out.push(
                    d.help("an included file is a <scene-part> with elements of a scene")
                        .other(root.place, "this"),
                );
                None
            }
            Err(d) => {
                self.out.push(*d);
                None
            }
        }
    }

    /// Rows of a CSV table of three columns (from, to, weight) as edges and weights. The first line may
    /// be a header; `#` begins a remark.
    pub fn histogram_file(&mut self, a: &Attribute) -> Option<(Vec<f64>, Vec<f64>)> {
        let (path, text) = self.file(a)?;
        match histogram(&text) {
            Ok(found) => Some(found),
            Err((line, why)) => {
                self.error(a.value_place, format!("{}:{line}: {why}", path.display()));
                None
            }
        }
    }
}

/// Line and numbers.
pub type Row = (u64, Vec<f64>);

/// Rows of numbers of a CSV text: (line, numbers). Lines without any number before the first row are
/// the header.
pub fn csv_rows(text: &str) -> Result<(Vec<String>, Vec<Row>), (u64, String)> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let (mut header, mut rows) = (Vec::new(), Vec::new());
    for record in reader.records() {
        let record = record.map_err(|e| (e.position().map_or(0, csv::Position::line), e.to_string()))?;
        let line = record.position().map_or(0, csv::Position::line);
        let numbers: Vec<Option<f64>> =
            record.iter().map(|f| f.parse::<f64>().ok().filter(|x| x.is_finite())).collect();
        if rows.is_empty() && header.is_empty() && numbers.first().is_none_or(Option::is_none) {
            header = record.iter().map(str::to_string).collect();
            continue;
        }
        match numbers.iter().position(Option::is_none) {
            Some(i) => return Err((line, format!("column {}: `{}` is no finite number", i + 1, &record[i]))),
            None => rows.push((line, numbers.into_iter().flatten().collect())),
        }
    }
    Ok((header, rows))
}

fn histogram(text: &str) -> Result<(Vec<f64>, Vec<f64>), (u64, String)> {
    let (_, rows) = csv_rows(text)?;
    let (mut edges, mut weights): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    for (line, row) in &rows {
        let [from, to, weight] = row[..] else {
            return Err((
                *line,
                format!("expected the columns from, to, weight; found {} columns", row.len()),
            ));
        };
        match edges.last() {
            None => edges.push(from),
            Some(last) if *last != from => {
                return Err((*line, format!("the bin begins at {from} where the one before ends at {last}")));
            }
            Some(_) => {}
        }
        edges.push(to);
        weights.push(weight);
    }
    if weights.is_empty() {
        return Err((1, "the histogram has no rows".into()));
    }
    Ok((edges, weights))
}

fn nearest_file(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_str()?;
    let mut names: Vec<String> = std::fs::read_dir(path.parent()?)
        .ok()?
        .filter_map(|e| e.ok()?.file_name().into_string().ok())
        .collect();
    names.sort();
    nearest(name, names.iter().map(String::as_str)).map(str::to_string)
}
