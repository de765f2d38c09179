//! Errors and warnings of a scene in the compiler's style: file, line, column, the text underlined,
//! what was expected, a way out. All errors of a reading are collected before any is shown.

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use std::fmt;
use std::io::IsTerminal;
use std::ops::Range;
use std::path::PathBuf;

/// A file that was read, for quoting.
#[derive(Clone, Debug)]
pub struct SourceFile {
    /// Path as shown in messages.
    pub path: PathBuf,
    /// Whole text.
    pub text: String,
}

/// A stretch of text in one of the files read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Index into [`Diagnostics::files`].
    pub file: usize,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Place {
    /// Place of a byte range.
    pub fn new(file: usize, span: Range<usize>) -> Self {
        Place { file, start: span.start, end: span.end }
    }
}

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The scene is refused.
    Error,
    /// The scene runs; the results record the warning.
    Warning,
}

/// One error or warning.
#[derive(Clone, Debug)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// What is wrong, one sentence.
    pub message: String,
    /// Where, if it has a place.
    pub place: Option<Place>,
    /// Text beside the underline.
    pub label: String,
    /// A second place (the first of two equal ids), with its text.
    pub other: Option<(Place, String)>,
    /// Ways out.
    pub help: Vec<String>,
}

impl Diagnostic {
    /// An error at a place.
    pub fn error(place: Place, message: impl Into<String>) -> Self {
        Diagnostic {
            severity: Severity::Error,
            message: message.into(),
            place: Some(place),
            label: String::new(),
            other: None,
            help: Vec::new(),
        }
    }
    /// A warning at a place.
    pub fn warning(place: Place, message: impl Into<String>) -> Self {
        Diagnostic { severity: Severity::Warning, ..Self::error(place, message) }
    }
    /// An error that has no place in any text (the file cannot be read, the command line).
    pub fn nowhere(message: impl Into<String>) -> Self {
        Diagnostic { place: None, ..Self::error(Place { file: 0, start: 0, end: 0 }, message) }
    }
    /// With text beside the underline.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }
    /// With a way out.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help.push(help.into());
        self
    }
    /// With a second place.
    pub fn other(mut self, place: Place, label: impl Into<String>) -> Self {
        self.other = Some((place, label.into()));
        self
    }
}

/// All that was found in one reading, with the texts to quote. Its `Display` is the plain rendering.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    /// Files read so far; [`Place::file`] indexes them.
    pub files: Vec<SourceFile>,
    /// In the order found.
    pub entries: Vec<Diagnostic>,
}

impl Diagnostics {
    /// Adds one.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.entries.push(diagnostic);
    }

    /// The errors.
    pub fn errors(&self) -> impl Iterator<Item = &Diagnostic> {
        self.entries.iter().filter(|d| d.severity == Severity::Error)
    }

    /// The warnings.
    pub fn warnings(&self) -> impl Iterator<Item = &Diagnostic> {
        self.entries.iter().filter(|d| d.severity == Severity::Warning)
    }

    /// Number of errors.
    pub fn error_count(&self) -> usize {
        self.errors().count()
    }

    /// Number of warnings.
    pub fn warning_count(&self) -> usize {
        self.warnings().count()
    }

    /// Line and column (both from 1, columns in characters) of a place.
    pub fn line_column(&self, place: Place) -> (usize, usize) {
        let Some(file) = self.files.get(place.file) else { return (1, 1) };
        let before = &file.text[..floor_boundary(&file.text, place.start)];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }

    /// Everything in file order without colour, or in the terminal's colours.
    pub fn render(&self, colour: bool) -> String {
        let mut order: Vec<&Diagnostic> = self.entries.iter().collect();
        order.sort_by_key(|d| d.place.map_or((usize::MAX, 0), |p| (p.file, p.start)));
        let mut text = order.iter().map(|d| self.render_one(d, colour) + "\n\n").collect::<String>();
        let (errors, warnings) = (self.error_count(), self.warning_count());
        if errors > 0 {
            let plural = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
            text += &plural(errors, "error");
            if warnings > 0 {
                text += &format!(", {}", plural(warnings, "warning"));
            }
            text.push('\n');
        }
        text
    }

    /// [`Diagnostics::render`] with colour exactly where standard error is a terminal and `NO_COLOR`
    /// is unset.
    pub fn render_for_stderr(&self) -> String {
        self.render(std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none())
    }

    /// One diagnostic, without a newline at its end.
    pub fn render_one(&self, d: &Diagnostic, colour: bool) -> String {
        let level = match d.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let mut group = Group::with_title(level.primary_title(visible(&d.message)));
        let mut places: Vec<(Place, &str, AnnotationKind)> = Vec::new();
        places.extend(d.place.map(|p| (p, d.label.as_str(), AnnotationKind::Primary)));
        places.extend(d.other.as_ref().map(|(p, l)| (*p, l.as_str(), AnnotationKind::Context)));
        let mut shown = Vec::new();
        for &(place, _, _) in &places {
            if shown.contains(&place.file) {
                continue;
            }
            shown.push(place.file);
            let Some(file) = self.files.get(place.file) else { continue };
            let quote = Quote::of(&file.text, places.iter().map(|p| p.0).filter(|p| p.file == place.file));
            let mut snippet = Snippet::source(quote.text.clone())
                .line_start(quote.line)
                .path(file.path.display().to_string());
            for &(p, label, kind) in places.iter().filter(|p| p.0.file == place.file) {
                let annotation = kind.span(quote.span(p));
                snippet = snippet.annotation(if label.is_empty() {
                    annotation
                } else {
                    annotation.label(visible(label))
                });
            }
            group = group.element(snippet);
        }
        for help in &d.help {
            group = group.element(Level::HELP.message(visible(help)));
        }
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        renderer.render(&[group])
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}
impl std::error::Error for Diagnostics {}

/// The lines around some places, cut out so that rendering costs nothing in a large file and a line of
/// megabytes is not printed.
struct Quote {
    text: String,
    line: usize,
    from: usize,
}

impl Quote {
    const LONGEST_LINE: usize = 400;

    fn of(text: &str, places: impl Iterator<Item = Place>) -> Quote {
        let (mut from, mut to) = (text.len(), 0);
        for p in places {
            from = from.min(p.start);
            to = to.max(p.end.max(p.start));
        }
        let from = floor_boundary(text, from.min(text.len()));
        let to = floor_boundary(text, to.min(text.len())).max(from);
        let line = text[..from].matches('\n').count() + 1;
        let mut start = text[..from].rfind('\n').map_or(0, |i| i + 1);
        let mut end = text[to..].find('\n').map_or(text.len(), |i| to + i);
        if from - start > Self::LONGEST_LINE {
            start = floor_boundary(text, from - Self::LONGEST_LINE / 4);
        }
        if end - to > Self::LONGEST_LINE {
            end = floor_boundary(text, to + Self::LONGEST_LINE / 4);
        }
        // Control characters would garble the terminal; each keeps its width in bytes.
        let quoted = text[start..end]
            .chars()
            .map(|c| if c.is_control() && c != '\n' && c != '\t' && c.len_utf8() == 1 { '?' } else { c })
            .collect();
        Quote { text: quoted, line, from: start }
    }

    fn span(&self, p: Place) -> Range<usize> {
        let at = |i: usize| floor_boundary(&self.text, i.saturating_sub(self.from).min(self.text.len()));
        let (start, end) = (at(p.start), at(p.end));
        start..end.max(start)
    }
}

/// Control characters of quoted input made visible.
fn visible(text: &str) -> String {
    text.chars().map(|c| if c.is_control() && c != '\n' { '\u{FFFD}' } else { c }).collect()
}

/// The character boundary at or before `i`.
fn floor_boundary(text: &str, i: usize) -> usize {
    let mut i = i.min(text.len());
    while !text.is_char_boundary(i) {
        i -= 1;
    }
    i
}

/// The name of `names` nearest to `word` by edit distance (insert, delete, replace, swap of
/// neighbours), if it is near enough to be meant: at most a third of the word's length, at least 1.
pub fn nearest<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (word.chars().count().max(3) / 3).max(1);
    names
        .into_iter()
        .map(|n| (edit_distance(&word.to_lowercase(), &n.to_lowercase()), n))
        .filter(|(d, _)| *d <= limit)
        .min_by_key(|(d, _)| *d)
        .map(|(_, n)| n)
}

/// Optimal string alignment distance; words longer than 64 characters are cut.
fn edit_distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().take(64).collect();
    let b: Vec<char> = b.chars().take(64).collect();
    let mut d = vec![vec![0; b.len() + 1]; a.len() + 1];
    for (i, row) in d.iter_mut().enumerate() {
        row[0] = i;
    }
    for (j, cell) in d[0].iter_mut().enumerate() {
        *cell = j;
    }
    for i in 1..=a.len() {
        for j in 1..=b.len() {
            let replace = d[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            d[i][j] = replace.min(d[i - 1][j] + 1).min(d[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                d[i][j] = d[i][j].min(d[i - 2][j - 2] + 1);
            }
        }
    }
    d[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_name() {
        let names = ["thickness", "material", "grammage", "pore"];
        assert_eq!(nearest("thicknes", names), Some("thickness"));
        assert_eq!(nearest("gramage", names), Some("grammage"));
        assert_eq!(nearest("proe", names), Some("pore"));
        assert_eq!(nearest("wavelength", names), None);
        assert_eq!(edit_distance("kitten", "sitting"), 3);
    }

    #[test]
    fn the_text_is_underlined() {
        let text = "<scene>\n  <sheet thicknes=\"1 um\"/>\n</scene>";
        let mut all = Diagnostics::default();
        all.files.push(SourceFile { path: "a.xml".into(), text: text.into() });
        let start = text.find("thicknes").unwrap();
        all.push(Diagnostic::error(Place::new(0, start..start + 8), "unknown").label("here").help("try"));
        let shown = all.to_string();
        assert!(shown.contains("a.xml:2:10"), "{shown}");
        assert!(shown.contains("^^^^^^^^ here"), "{shown}");
        assert!(shown.contains("help: try"), "{shown}");
        assert_eq!(all.line_column(all.entries[0].place.unwrap()), (2, 10));
        assert!(all.render(true).contains("\u{1b}["));
    }
}
