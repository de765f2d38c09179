//! The document as written: a tree of elements with the byte spans of every name and value.
//!
//! Refused, with place: truncated XML, two roots, no root, trailing text, NUL, undefined entities,
//! DOCTYPE (so no entity expansion at all), nesting beyond [`MAX_DEPTH`], text between elements.

use super::diagnostic::{Diagnostic, Place};
use quick_xml::Reader;
use quick_xml::errors::Error as XmlError;
use quick_xml::events::attributes::AttrError;
use quick_xml::events::{BytesStart, Event};
use std::cell::Cell;

/// Deepest nesting of elements.
pub const MAX_DEPTH: usize = 64;
/// Largest file read, bytes (64 MiB).
pub const MAX_BYTES: u64 = 64 << 20;

/// An element.
#[derive(Clone, Debug)]
pub struct Element {
    /// Name as written.
    pub name: String,
    /// Place of the name in the start tag.
    pub place: Place,
    /// From `<` of the start tag to `>` of the end tag.
    pub span: Place,
    /// Attributes in order, possibly repeated.
    pub attributes: Vec<Attribute>,
    /// Child elements in order.
    pub children: Vec<Element>,
    /// Was it asked for while the scene was built?
    pub used: Cell<bool>,
    /// Does it hold a misspelt name? Then what seems missing is not told too.
    pub misspelt: Cell<bool>,
}

/// An attribute.
#[derive(Clone, Debug)]
pub struct Attribute {
    /// Name as written.
    pub name: String,
    /// Place of the name.
    pub name_place: Place,
    /// Value, character references resolved, placeholders not yet.
    pub value: String,
    /// Place of the value between its quotes.
    pub value_place: Place,
    /// A placeholder in it could not be filled; that error is told already.
    pub broken: bool,
    /// Was it asked for while the scene was built?
    pub used: Cell<bool>,
}

impl Attribute {
    /// An attribute that stands in no file.
    pub fn new(name: &str, value: &str) -> Self {
        let nowhere = Place { file: 0, start: 0, end: 0 };
        let (name, value) = (name.to_string(), value.to_string());
        Attribute {
            name,
            name_place: nowhere,
            value,
            value_place: nowhere,
            broken: false,
            used: Cell::new(false),
        }
    }
}

impl Element {
    /// Whether `which` calls this element: its `id` or `name`, or what it is.
    fn is_called(&self, which: &str) -> bool {
        let given = |name| self.attribute(name).is_some_and(|a: &Attribute| a.value == which);
        self.name == which || given("id") || self.name != "define" && given("name")
    }

    /// How many elements below (and this one) are called `which`.
    pub fn count_matching(&self, which: &str) -> usize {
        usize::from(self.is_called(which))
            + self.children.iter().map(|c| c.count_matching(which)).sum::<usize>()
    }

    /// Sets an attribute of all elements called `which`; a new one stands at the element's name.
    pub fn set_matching(&mut self, which: &str, attribute: &str, value: &str) {
        if self.is_called(which) {
            match self.attributes.iter_mut().find(|a| a.name == attribute) {
                Some(a) => (a.value, a.broken) = (value.to_owned(), false),
                None => {
                    let mut new = Attribute::new(attribute, value);
                    (new.name_place, new.value_place) = (self.place, self.place);
                    self.attributes.push(new);
                }
            }
        }
        self.children.iter_mut().for_each(|c| c.set_matching(which, attribute, value));
    }

    /// The attribute of that name (the first, if repeated).
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|a| a.name == name)
    }
}

/// Reads one document; `file` numbers it in the places.
///
/// # Errors
/// The first fault of the XML itself.
pub fn parse(text: &str, file: usize) -> Result<Element, Box<Diagnostic>> {
    if let Some(at) = text.bytes().position(|b| b < 0x20 && !matches!(b, b'\t' | b'\n' | b'\r')) {
        let what = if text.as_bytes()[at] == 0 { "a NUL byte" } else { "a control character" };
        return Err(Box::new(
            Diagnostic::error(Place::new(file, at..at + 1), format!("{what} in the file"))
                .help("XML is plain text; is this a binary file, or was it damaged?"),
        ));
    }
    Parser { text, file, open: Vec::new(), root: None }.run()
}

/// An element whose end tag has not come yet, and where its start tag begins.
struct Open {
    element: Element,
    from: usize,
}

struct Parser<'a> {
    text: &'a str,
    file: usize,
    open: Vec<Open>,
    root: Option<Element>,
}

type Fault = Box<Diagnostic>;

impl Parser<'_> {
    fn fault(&self, start: usize, end: usize, message: impl Into<String>) -> Diagnostic {
        let end = end.min(self.text.len());
        Diagnostic::error(Place::new(self.file, start.min(end)..end), message)
    }

    fn run(mut self) -> Result<Element, Fault> {
        // The reader counts from behind a byte order mark.
        let body = self.text.trim_start_matches('\u{feff}');
        let mark = self.text.len() - body.len();
        let mut reader = Reader::from_str(body);
        reader.config_mut().check_end_names = false;
        reader.config_mut().allow_unmatched_ends = true;
        loop {
            let from = mark + reader.buffer_position() as usize;
            let event = reader
                .read_event()
                .map_err(|e| self.malformed(&e, mark + reader.error_position() as usize))?;
            let to = mark + reader.buffer_position() as usize;
            match event {
                Event::Start(tag) => self.start(&tag, from, to)?,
                Event::Empty(tag) => {
                    self.start(&tag, from, to)?;
                    self.close(to);
                }
                Event::End(tag) => self.end(tag.name().0, from, to)?,
                Event::Text(text) => self.blank(&text, from, to)?,
                Event::CData(_) => return Err(self.text_found(from, to)),
                Event::GeneralRef(_) => return Err(self.text_found(from, to)),
                Event::DocType(_) => {
                    return Err(Box::new(
                        self.fault(from, to, "a DOCTYPE is not allowed")
                            .help("delete it: a scene needs no document type, and entities are not expanded"),
                    ));
                }
                Event::Comment(_) | Event::PI(_) | Event::Decl(_) => {}
                Event::Eof => break,
            }
        }
        self.finish()
    }

    fn finish(self) -> Result<Element, Fault> {
        if let Some(open) = self.open.last() {
            let mut d = self
                .fault(
                    self.text.len(),
                    self.text.len(),
                    format!("the file ends inside <{}>", open.element.name),
                )
                .label("end of file")
                .help("the file is truncated, or an end tag is missing");
            d.other = Some((open.element.place, "opened here".into()));
            return Err(Box::new(d));
        }
        match self.root {
            Some(root) => Ok(root),
            None => Err(Box::new(
                self.fault(0, 0, "the file has no root element")
                    .help("a scene begins with <scene name=\"…\" version=\"1\">"),
            )),
        }
    }

    fn start(&mut self, tag: &BytesStart<'_>, from: usize, to: usize) -> Result<(), Fault> {
        let name = tag.name().0.to_string();
        let place = Place::new(self.file, from + 1..from + 1 + name.len());
        if let (true, Some(root)) = (self.open.is_empty(), &self.root) {
            let (first, first_name) = (root.place, &root.name);
            return Err(Box::new(
                Diagnostic::error(place, format!("a second root element <{name}>"))
                    .other(first, format!("the document is this <{first_name}>")),
            ));
        }
        if self.open.len() >= MAX_DEPTH {
            return Err(Box::new(Diagnostic::error(
                place,
                format!("elements are nested deeper than {MAX_DEPTH}"),
            )));
        }
        if name.is_empty() {
            return Err(Box::new(self.fault(from, to, "a tag without name")));
        }
        let attributes = self.attributes(tag, from, to)?;
        let element = Element {
            name,
            place,
            span: Place::new(self.file, from..to),
            attributes,
            children: Vec::new(),
            used: Cell::new(false),
            misspelt: Cell::new(false),
        };
        self.open.push(Open { element, from });
        Ok(())
    }

    fn attributes(&self, tag: &BytesStart<'_>, from: usize, to: usize) -> Result<Vec<Attribute>, Fault> {
        let mut found = Vec::new();
        // The tag's text begins one byte after `<`; attribute slices point into it.
        let base = tag.as_ref().as_ptr() as usize;
        let offset = |s: &str| from + 1 + (s.as_ptr() as usize).wrapping_sub(base);
        let mut attributes = tag.attributes();
        for attribute in attributes.with_checks(false) {
            let attribute = attribute.map_err(|e| self.bad_attribute(&e, from, to))?;
            let key = attribute.key.0;
            let raw: &str = &attribute.value;
            let (name_at, value_at) = (offset(key), offset(raw));
            let value_place = Place::new(self.file, value_at..value_at + raw.len());
            if let Some(i) = raw.find('<') {
                return Err(Box::new(
                    self.fault(value_at + i, value_at + i + 1, "`<` in an attribute value")
                        .help("is a closing quote missing before it? a real one is written &lt;"),
                ));
            }
            let value = quick_xml::escape::unescape(raw).map_err(|e| {
                let entity = raw.find('&').map_or(value_place, |i| {
                    let end = raw[i..].find(';').map_or(raw.len(), |j| i + j + 1);
                    Place::new(self.file, value_at + i..value_at + end)
                });
                Box::new(Diagnostic::error(entity, format!("undefined or malformed entity: {e}")).help(
                    "only &amp; &lt; &gt; &quot; &apos; and character references like &#181; are known",
                ))
            })?;
            found.push(Attribute {
                name: key.to_string(),
                name_place: Place::new(self.file, name_at..name_at + key.len()),
                value: value.into_owned(),
                value_place,
                broken: false,
                used: Cell::new(false),
            });
        }
        Ok(found)
    }

    fn bad_attribute(&self, e: &AttrError, from: usize, to: usize) -> Fault {
        let (at, message) = match e {
            AttrError::ExpectedEq(i) => (*i, "an attribute without `=` and value"),
            AttrError::ExpectedValue(i) => (*i, "an attribute without value"),
            AttrError::UnquotedValue(i) => (*i, "an attribute value without quotes"),
            AttrError::ExpectedQuote(i, _) => (*i, "an attribute value whose closing quote is missing"),
            AttrError::Duplicated(i, _) => (*i, "a repeated attribute"),
        };
        let start = (from + 1 + at).min(to);
        Box::new(
            self.fault(start, (start + 1).min(to), message).help("attributes are written name=\"value\""),
        )
    }

    fn end(&mut self, name: &str, from: usize, to: usize) -> Result<(), Fault> {
        match self.open.last() {
            None => Err(Box::new(self.fault(from, to, format!("end tag </{name}> without start tag")))),
            Some(open) if open.element.name != name => {
                let (place, expected) = (open.element.place, &open.element.name);
                Err(Box::new(
                    self.fault(from, to, format!("end tag </{name}> where </{expected}> is expected"))
                        .other(place, "opened here"),
                ))
            }
            Some(_) => {
                self.close(to);
                Ok(())
            }
        }
    }

    fn close(&mut self, end: usize) {
        if let Some(Open { mut element, .. }) = self.open.pop() {
            element.span.end = end;
            match self.open.last_mut() {
                Some(parent) => parent.element.children.push(element),
                None => self.root = Some(element),
            }
        }
    }

    /// Text may stand nowhere; blanks may.
    fn blank(&self, text: &str, from: usize, to: usize) -> Result<(), Fault> {
        let is_blank = |c: char| c.is_ascii_whitespace();
        if text.chars().all(is_blank) {
            return Ok(());
        }
        let written = &self.text[from..to.min(self.text.len())];
        let lead = written.len() - written.trim_start_matches(is_blank).len();
        let trail = written.len() - written.trim_end_matches(is_blank).len();
        Err(self.text_found(from + lead, to - trail))
    }

    fn text_found(&self, from: usize, to: usize) -> Fault {
        let message = match (self.open.last(), &self.root) {
            (Some(open), _) => {
                format!("text inside <{}>, where only elements are expected", open.element.name)
            }
            (None, Some(root)) => format!("text after the end of <{}>", root.name),
            (None, None) => "text before the root element".to_string(),
        };
        Box::new(
            self.fault(from, to, message)
                .help("values are written as attributes, remarks as <!-- comments -->"),
        )
    }

    fn malformed(&self, e: &XmlError, at: usize) -> Fault {
        let at = at.min(self.text.len());
        let mut d = self.fault(at, at + 1, format!("malformed XML: {e}"));
        if let Some(open) = self.open.last() {
            let line_of_start = Place::new(self.file, open.from..open.element.place.end);
            d = d.other(line_of_start, "inside this element");
        }
        Box::new(d)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_point_at_names_and_values() {
        let text = "<?xml version=\"1.0\"?>\n<a  b = 'x &amp; y'><!-- c --><d e=\"µ\"/></a>\n";
        let root = parse(text, 0).unwrap();
        let cut = |p: Place| &text[p.start..p.end];
        assert_eq!((root.name.as_str(), cut(root.place)), ("a", "a"));
        let b = &root.attributes[0];
        assert_eq!((b.value.as_str(), cut(b.value_place), cut(b.name_place)), ("x & y", "x &amp; y", "b"));
        let e = &root.children[0].attributes[0];
        assert_eq!((e.value.as_str(), cut(e.value_place), cut(e.name_place)), ("µ", "µ", "e"));
    }

    #[test]
    fn refused() {
        let deep = "<a>".repeat(65) + &"</a>".repeat(65);
        for (text, want) in [
            ("", "no root"),
            ("<!-- only -->", "no root"),
            ("<a>", "ends inside <a>"),
            ("<a><b></a>", "</a> where </b>"),
            ("<a/><b/>", "second root element <b>"),
            ("<a/>text", "text after the end"),
            ("text<a/>", "text before the root"),
            ("<a>text</a>", "text inside <a>"),
            ("<a><![CDATA[x]]></a>", "text inside <a>"),
            ("<a>&lt;</a>", "text inside <a>"),
            ("<a b=\"\0\"/>", "NUL"),
            ("<a b=\"&nope;\"/>", "entity"),
            ("<a b=\"&nope\"/>", "entity"),
            ("<!DOCTYPE a [<!ENTITY x \"y\">]><a/>", "DOCTYPE"),
            ("<a b=c/>", "without quotes"),
            ("<a b/>", "without `=`"),
            ("<a b=\"1/>", "not closed"),
            ("<a", "not closed"),
            ("</a>", "without start tag"),
            (deep.as_str(), "nested deeper than 64"),
        ] {
            let d = parse(text, 0).unwrap_err();
            assert!(d.message.contains(want), "{text}: {}", d.message);
            assert!(d.place.is_some());
        }
        assert!(parse(&("<a>".repeat(64) + &"</a>".repeat(64)), 0).is_ok());
    }
}
