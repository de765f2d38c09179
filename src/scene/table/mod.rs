//! The one table of elements and attributes: parser checks, schema and documentation come from it.

// A table reads best with one row a line.
#[rustfmt::skip]
mod attributes;
#[rustfmt::skip]
mod grammar;
mod schema;

pub use grammar::RULES;
pub use schema::{markdown, xsd};

use super::diagnostic::{Diagnostic, Diagnostics, nearest};
use super::document::{Attribute, Element};
use crate::units::{self, Quantity};

/// What the text of an attribute is.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A number with the unit of its quantity.
    Number(Quantity),
    /// A number or one of some words.
    NumberOr(Quantity, &'static [&'static str]),
    /// Numbers; how many, if fixed.
    List(Quantity, Option<usize>),
    /// One of some words.
    Choice(&'static [&'static str]),
    /// A whole number, possibly negative.
    Integer,
    /// HEALPix granularity: "8" or "nside 8".
    Nside,
    /// A new identifier.
    Id,
    /// The id of a material or surface.
    Reference(&'static str),
    /// A file, relative to the file it is named in.
    File,
    /// Any text.
    Text,
}

/// Allowed values, internal units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Lower end.
    pub min: f64,
    /// Upper end.
    pub max: f64,
    /// Is the lower end excluded?
    pub above: bool,
    /// Is the upper end excluded?
    pub below: bool,
}

impl Range {
    /// Every finite number.
    pub const ANY: Range = Range::closed(f64::NEG_INFINITY, f64::INFINITY);
    /// x > 0.
    pub const POSITIVE: Range = Range { min: 0.0, max: f64::INFINITY, above: true, below: false };
    /// x ≥ 0.
    pub const NOT_NEGATIVE: Range = Range::closed(0.0, f64::INFINITY);
    /// 0 ≤ x ≤ 1.
    pub const SHARE: Range = Range::closed(0.0, 1.0);

    /// a ≤ x ≤ b.
    pub const fn closed(a: f64, b: f64) -> Range {
        Range { min: a, max: b, above: false, below: false }
    }
    /// a < x < b.
    pub const fn open(a: f64, b: f64) -> Range {
        Range { min: a, max: b, above: true, below: true }
    }
    /// a < x ≤ b.
    pub const fn above(a: f64, b: f64) -> Range {
        Range { min: a, max: b, above: true, below: false }
    }
    /// a ≤ x < b.
    pub const fn below(a: f64, b: f64) -> Range {
        Range { min: a, max: b, above: false, below: true }
    }

    /// Is x inside?
    pub fn contains(&self, x: f64) -> bool {
        (if self.above { x > self.min } else { x >= self.min })
            && (if self.below { x < self.max } else { x <= self.max })
    }

    /// As text with units: "> 0 um", "from 0 to 1".
    pub fn describe(&self, q: Quantity) -> Option<String> {
        let show = |x: f64| {
            if q == Quantity::Angle {
                format!("{} deg", Quantity::Angle.in_unit(x, "deg").unwrap_or(x))
            } else {
                q.show(x)
            }
        };
        let low = self
            .min
            .is_finite()
            .then(|| format!("{} {}", if self.above { ">" } else { "≥" }, show(self.min)));
        let high = self
            .max
            .is_finite()
            .then(|| format!("{} {}", if self.below { "<" } else { "≤" }, show(self.max)));
        match (low, high) {
            (Some(l), Some(h)) => Some(format!("{l} and {h}")),
            (l, h) => l.or(h),
        }
    }
}

/// Must an attribute stand there?
#[derive(Clone, Copy, Debug)]
pub enum Presence {
    /// Yes.
    Required,
    /// No; what its absence means is said by the documentation.
    Optional,
    /// No; this text is taken.
    Default(&'static str),
}

/// An attribute of the grammar.
#[derive(Clone, Copy, Debug)]
pub struct AttributeRule {
    /// Name.
    pub name: &'static str,
    /// What its text is.
    pub kind: Kind,
    /// Allowed numbers.
    pub range: Range,
    /// Required, optional or with default.
    pub presence: Presence,
    /// One sentence.
    pub doc: &'static str,
}

/// A child element of the grammar.
#[derive(Clone, Copy, Debug)]
pub struct ChildRule {
    /// Key of its rule.
    pub key: &'static str,
    /// At least one?
    pub required: bool,
    /// More than one?
    pub many: bool,
}

/// An element of the grammar. The same name may have several rules (`<particles>` in a material and in
/// a layer): the key tells them apart, as "name" or "name/where".
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Key.
    pub key: &'static str,
    /// One sentence.
    pub doc: &'static str,
    /// Attributes, in groups that several elements share.
    pub attributes: &'static [&'static [AttributeRule]],
    /// Children.
    pub children: &'static [ChildRule],
}

impl Rule {
    /// Name of the element.
    pub fn name(&self) -> &'static str {
        self.key.split('/').next().unwrap_or(self.key)
    }
    /// All attributes.
    pub fn all(&self) -> impl Iterator<Item = &'static AttributeRule> + use<> {
        self.attributes.iter().flat_map(|group| group.iter())
    }
    /// The attribute of that name.
    pub fn attribute(&self, name: &str) -> Option<&'static AttributeRule> {
        self.all().find(|a| a.name == name)
    }
    /// The rule of a child by element name.
    pub fn child(&self, name: &str) -> Option<(&'static ChildRule, &'static Rule)> {
        self.children.iter().map(|c| (c, rule(c.key))).find(|(_, r)| r.name() == name)
    }
}

/// The rule of a key. Keys are written in the table itself; a test checks that each exists.
pub fn rule(key: &str) -> &'static Rule {
    RULES.iter().find(|r| r.key == key).unwrap_or(&RULES[0])
}

/// Checks an element and all below it against the table: names, repetition, presence, kind and range of
/// every value. `partial`: required attributes may be missing (they may come from a distribution file).
pub fn check(e: &Element, rule: &Rule, partial: bool, out: &mut Diagnostics) {
    let partial = partial
        || e.attribute("from").is_some()
            && rule.attribute("from").is_some_and(|a| matches!(a.kind, Kind::File));
    check_attributes(e, rule, partial, out);
    for (i, c) in e.children.iter().enumerate() {
        let Some((child, child_rule)) = rule.child(&c.name) else {
            e.misspelt.set(true);
            out.push(unknown_element(c, e, rule));
            continue;
        };
        if let Some(first) = e.children[..i].iter().find(|b| b.name == c.name)
            && !child.many
        {
            out.push(
                Diagnostic::error(c.place, format!("<{}> is repeated in <{}>", c.name, e.name))
                    .label("only one may stand here")
                    .other(first.place, "the first is here"),
            );
        }
        check(c, child_rule, partial, out);
    }
    for child in rule.children.iter().filter(|c| c.required && !partial && !e.misspelt.get()) {
        let name = self::rule(child.key).name();
        if !e.children.iter().any(|c| c.name == name) {
            out.push(
                Diagnostic::error(e.place, format!("<{}> needs a <{name}>", e.name))
                    .help(format!("<{name}>: {}", self::rule(child.key).doc)),
            );
        }
    }
}

fn check_attributes(e: &Element, rule: &Rule, partial: bool, out: &mut Diagnostics) {
    for (i, a) in e.attributes.iter().enumerate() {
        if let Some(first) = e.attributes[..i].iter().find(|b| b.name == a.name) {
            out.push(
                Diagnostic::error(a.name_place, format!("attribute `{}` is repeated", a.name))
                    .other(first.name_place, "the first is here"),
            );
            continue;
        }
        match rule.attribute(&a.name) {
            Some(known) => {
                if !a.broken
                    && let Some(d) = check_value(a, known)
                {
                    out.push(d);
                }
            }
            None if is_xml_housekeeping(&a.name) => a.used.set(true),
            None => {
                e.misspelt.set(true);
                out.push(unknown_attribute(a, e, rule));
            }
        }
    }
    for known in rule.all().filter(|a| matches!(a.presence, Presence::Required)) {
        if !partial && !e.misspelt.get() && e.attribute(known.name).is_none() {
            out.push(
                Diagnostic::error(e.place, format!("<{}> needs the attribute `{}`", e.name, known.name))
                    .help(format!("{}: {}", known.name, known.doc)),
            );
        }
    }
}

/// `xmlns…`, `xsi:…`: written by XML editors to find the schema.
fn is_xml_housekeeping(name: &str) -> bool {
    name == "xmlns" || name.starts_with("xmlns:") || name.starts_with("xsi:")
}

fn unknown_element(c: &Element, parent: &Element, rule: &Rule) -> Diagnostic {
    let names: Vec<&str> = rule.children.iter().map(|k| self::rule(k.key).name()).collect();
    let d = Diagnostic::error(c.place, format!("unknown element <{}> in <{}>", c.name, parent.name));
    let elsewhere = RULES.iter().any(|r| r.name() == c.name);
    let d = match nearest(&c.name, names.iter().copied()) {
        Some(n) => d.label(format!("did you mean `{n}`?")),
        None if elsewhere => d.label("does not belong here"),
        None => d.label("not known"),
    };
    if names.is_empty() {
        d.help(format!("<{}> holds no elements", parent.name))
    } else {
        d.help(format!("<{}> holds: {}", parent.name, names.join(", ")))
    }
}

fn unknown_attribute(a: &Attribute, e: &Element, rule: &Rule) -> Diagnostic {
    let names: Vec<&str> = rule.all().map(|k| k.name).collect();
    let d = Diagnostic::error(a.name_place, format!("unknown attribute `{}` of <{}>", a.name, e.name));
    let d = match nearest(&a.name, names.iter().copied()) {
        Some(n) => d.label(format!("did you mean `{n}`?")),
        None => d.label("not known"),
    };
    if names.is_empty() { d } else { d.help(format!("<{}> takes: {}", e.name, names.join(", "))) }
}

fn check_value(a: &Attribute, known: &AttributeRule) -> Option<Diagnostic> {
    let text = a.value.trim();
    let problem = match known.kind {
        Kind::Number(q) => number_problem(q, text, known.range),
        Kind::NumberOr(_, words) if words.contains(&text) => None,
        Kind::NumberOr(q, words) => {
            number_problem(q, text, known.range).map(|(m, h)| (m, format!("{h}; or: {}", words.join(", "))))
        }
        Kind::List(q, n) => list_problem(q, text, known.range, n),
        Kind::Choice(words) => choice_problem(text, words),
        Kind::Integer => text
            .parse::<i32>()
            .err()
            .map(|_| (format!("expected a whole number, found `{text}`"), "as -1, 0 or 12".to_string())),
        Kind::Nside => nside_problem(text, known.range),
        Kind::Id => id_problem(text),
        Kind::Reference(_) | Kind::File | Kind::Text => {
            text.is_empty().then(|| (format!("`{}` is empty", a.name), known.doc.to_string()))
        }
    };
    problem.map(|(message, help)| {
        let d = Diagnostic::error(a.value_place, format!("attribute `{}`: {message}", a.name));
        if help.is_empty() { d } else { d.help(help) }
    })
}

type Problem = Option<(String, String)>;

fn range_problem(q: Quantity, x: f64, text: &str, range: Range) -> Problem {
    if range.contains(x) {
        return None;
    }
    let allowed = range.describe(q).unwrap_or_default();
    Some((format!("`{text}` is out of range"), format!("allowed: {allowed}")))
}

fn number_problem(q: Quantity, text: &str, range: Range) -> Problem {
    let value = if q == Quantity::Count { units::count(text).map(|n| n as f64) } else { q.parse(text) };
    match value {
        Ok(x) => range_problem(q, x, text, range),
        Err(e) => Some((e.to_string(), e.help())),
    }
}

fn list_problem(q: Quantity, text: &str, range: Range, n: Option<usize>) -> Problem {
    match q.parse_list(text) {
        Err(e) => Some((e.to_string(), e.help())),
        Ok(values) => {
            if let Some(n) = n
                && values.len() != n
            {
                let unit = q.units().first().map(|u| format!(" {u}")).unwrap_or_default();
                return Some((
                    format!("expected {n} numbers, found {}", values.len()),
                    format!("as \"{}{unit}\"", vec!["1"; n].join(" ")),
                ));
            }
            values.iter().find_map(|&x| range_problem(q, x, &q.show(x), range))
        }
    }
}

fn choice_problem(text: &str, words: &[&'static str]) -> Problem {
    if words.contains(&text) {
        return None;
    }
    let help = match nearest(text, words.iter().copied()) {
        Some(n) => format!("did you mean `{n}`? known: {}", words.join(", ")),
        None => format!("known: {}", words.join(", ")),
    };
    Some((format!("`{text}` is not known"), help))
}

/// "8" or "nside 8".
pub fn nside(text: &str) -> Option<u32> {
    let text = text.trim();
    let digits = text.strip_prefix("nside").map_or(text, str::trim_start);
    digits.parse().ok()
}

fn nside_problem(text: &str, range: Range) -> Problem {
    match nside(text) {
        None => Some((format!("expected a granularity, found `{text}`"), "as \"8\" or \"nside 8\"".into())),
        Some(n) => range_problem(Quantity::Number, f64::from(n), text, range),
    }
}

fn id_problem(text: &str) -> Problem {
    let ok = !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || "-_.".contains(c));
    (!ok).then(|| (format!("`{text}` is no identifier"), "letters, digits, `-`, `_` and `.`".into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every child key has its rule, keys and names are unique where they must be, defaults are valid.
    #[test]
    fn the_table_is_sound() {
        for (i, r) in RULES.iter().enumerate() {
            assert!(RULES[..i].iter().all(|o| o.key != r.key), "{} twice", r.key);
            let names: Vec<_> = r.all().map(|a| a.name).collect();
            for (j, n) in names.iter().enumerate() {
                assert!(!names[..j].contains(n), "{}: {n} twice", r.key);
            }
            for c in r.children {
                assert!(RULES.iter().any(|o| o.key == c.key), "{}: no rule {}", r.key, c.key);
            }
            for a in r.all() {
                assert!(a.doc.ends_with('.'), "{} {}: {}", r.key, a.name, a.doc);
                if let Presence::Default(text) = a.presence {
                    let value = Attribute::new(a.name, text);
                    let d = check_value(&value, a);
                    assert!(d.is_none(), "{} {}: {d:?}", r.key, a.name);
                }
            }
        }
    }
}
