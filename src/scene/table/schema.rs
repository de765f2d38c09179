//! The table written out: XML Schema and Markdown.

use super::{AttributeRule, Kind, Presence, RULES, Rule};
use crate::units::Quantity;
use std::fmt::Write;

const NUMBER: &str = r"[+\-]?(\d+\.?\d*|\.\d+)([eE][+\-]?\d+)?";
const PLACEHOLDER: &str = r".*\$\{[^}]*\}.*";

/// XML Schema 1.0 of scenes and distribution files: names, kinds, units and choices. What a schema
/// cannot say (exactly one of two attributes, ranges, references, files) is checked by the program.
pub fn xsd() -> String {
    let mut s = String::from(concat!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n",
        "<!-- Generated from src/scene/table/grammar.rs (`lightpro schema`); do not edit. -->\n",
        "<xs:schema xmlns:xs=\"http://www.w3.org/2001/XMLSchema\">\n"
    ));
    for root in ["scene", "scene-part", "distribution"] {
        let rules: Vec<&Rule> = RULES.iter().filter(|r| r.name() == root).collect();
        let _ = writeln!(s, "  <xs:element name=\"{root}\" type=\"{root}\"/>");
        if rules.len() > 1 {
            s += &complex_type(root, &rules);
        }
    }
    let mut merged = Vec::new();
    for rule in RULES.iter().filter(|r| !r.key.starts_with("distribution/")) {
        s += &complex_type(&type_name(rule.key), &[rule]);
        let same: Vec<&Rule> = RULES.iter().filter(|r| r.name() == rule.name()).collect();
        if same.len() > 1 && !merged.contains(&rule.name()) {
            merged.push(rule.name());
            s += &complex_type(&format!("{}-any", rule.name()), &same);
        }
    }
    s + "</xs:schema>\n"
}

fn type_name(key: &str) -> String {
    key.replace('/', "-")
}

/// One type; of several rules with the same name the union (in XSD 1.0 one parent cannot hold two
/// types under one name).
fn complex_type(name: &str, rules: &[&Rule]) -> String {
    let mut s = format!("  <xs:complexType name=\"{name}\">\n");
    let docs: Vec<&str> = rules.iter().map(|r| r.doc).collect();
    let _ = writeln!(
        s,
        "    <xs:annotation><xs:documentation>{}</xs:documentation></xs:annotation>",
        escape(&docs.join(" "))
    );
    let mut children: Vec<(&str, Vec<&str>)> = Vec::new();
    for child in rules.iter().flat_map(|r| r.children) {
        let element = super::rule(child.key).name();
        match children.iter_mut().find(|(n, _)| *n == element) {
            Some((_, keys)) if !keys.contains(&child.key) => keys.push(child.key),
            Some(_) => {}
            None => children.push((element, vec![child.key])),
        }
    }
    if !children.is_empty() {
        s += "    <xs:choice minOccurs=\"0\" maxOccurs=\"unbounded\">\n";
        for (element, keys) in children {
            let t = if keys.len() == 1 { type_name(keys[0]) } else { format!("{element}-any") };
            let _ = writeln!(s, "      <xs:element name=\"{element}\" type=\"{t}\"/>");
        }
        s += "    </xs:choice>\n";
    }
    // A distribution file may give what the table requires: only `from`-less elements require it here.
    let strict =
        rules.len() == 1 && !rules[0].all().any(|a| a.name == "from" && matches!(a.kind, Kind::File));
    let mut seen: Vec<&str> = Vec::new();
    for a in rules.iter().flat_map(|r| r.all()) {
        if !seen.contains(&a.name) {
            seen.push(a.name);
            s += &attribute(a, strict);
        }
    }
    s + "  </xs:complexType>\n"
}

fn attribute(a: &AttributeRule, strict: bool) -> String {
    let required = if strict && matches!(a.presence, Presence::Required) { " use=\"required\"" } else { "" };
    let mut s = format!("    <xs:attribute name=\"{}\"{required}>\n", a.name);
    let mut doc = a.doc.to_string();
    if let Presence::Default(d) = a.presence {
        doc += &format!(" Default: {d}.");
    }
    let _ = writeln!(
        s,
        "      <xs:annotation><xs:documentation>{}</xs:documentation></xs:annotation>",
        escape(&doc)
    );
    s += "      <xs:simpleType><xs:restriction base=\"xs:string\">";
    if let Some(pattern) = pattern(a.kind) {
        // Several patterns of one restriction are alternatives.
        let _ = write!(
            s,
            "<xs:pattern value=\"{}\"/><xs:pattern value=\"{}\"/>",
            escape(&pattern),
            escape(PLACEHOLDER)
        );
    }
    s + "</xs:restriction></xs:simpleType>\n    </xs:attribute>\n"
}

fn pattern(kind: Kind) -> Option<String> {
    let unit = |q: Quantity| {
        let known: Vec<String> = q
            .units()
            .iter()
            .map(|u| u.replace("um", "[uµμ]m").replace("2", "[2²]").replace("3", "[3³]"))
            .collect();
        match (known.is_empty(), q.has_unit()) {
            (true, _) => String::new(),
            (false, true) => format!(r"\s*({})", known.join("|").replace("deg", "deg|°")),
            (false, false) => format!(r"(\s*({}))?", known.join("|")),
        }
    };
    Some(match kind {
        Kind::Number(q) => format!(r"\s*{NUMBER}{}\s*", unit(q)),
        Kind::NumberOr(q, words) => format!(r"\s*({NUMBER}{}|{})\s*", unit(q), words.join("|")),
        Kind::List(q, _) if q.has_unit() => {
            format!(r"\s*{NUMBER}([\s,;]*({NUMBER}|{}))*\s*", unit(q).replacen(r"\s*", "", 1))
        }
        Kind::List(..) => format!(r"\s*{NUMBER}%?([\s,;]+{NUMBER}\s*%?)*\s*"),
        Kind::Choice(words) => words.join("|"),
        Kind::Integer => r"\s*[+\-]?\d+\s*".into(),
        Kind::Nside => r"\s*(nside)?\s*\d+\s*".into(),
        Kind::Id | Kind::Reference(_) => r"\s*[\w\-.]+\s*".into(),
        Kind::File | Kind::Text => return None,
    })
}

fn escape(s: &str) -> String {
    s.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The grammar as a Markdown page.
pub fn markdown() -> String {
    let mut s = String::from(concat!(
        "# The scene file\n\n",
        "Generated from `src/scene/table/grammar.rs` (`lightpro schema --markdown`); do not edit.\n\n",
        "Numbers with a dimension carry their unit: `12 um`, `80 g/m2`, `550 nm`, `30 deg`. `µm` and `um` are the same. ",
        "Lists may give one unit at the end: `0 0 -2 um`. Paths are relative to the file they stand in. ",
        "`${name}` in an attribute value is replaced by the value of `<define name=…>` or of `-D name=value`.\n\n",
        "Units: "
    ));
    let dimensions = [
        ("length", Quantity::Length),
        ("wavelength", Quantity::Wavelength),
        ("angle", Quantity::Angle),
        ("coefficient", Quantity::Coefficient),
        ("grammage", Quantity::Grammage),
        ("coarseness", Quantity::Coarseness),
        ("density", Quantity::Density),
        ("length density", Quantity::LengthDensity),
        ("number density", Quantity::NumberDensity),
    ];
    let units: Vec<String> = dimensions.iter().map(|(n, q)| format!("{n} {}", q.units().join(" "))).collect();
    s += &units.join("; ");
    s += ".\n";
    for rule in RULES {
        let wherein = rule.key.split_once('/').map_or(String::new(), |(_, w)| format!(" ({w})"));
        let _ = write!(s, "\n## `<{}>`{wherein}\n\n{}\n", rule.name(), rule.doc);
        if !rule.children.is_empty() {
            let names: Vec<String> = rule.children.iter().map(child_text).collect();
            let _ = write!(s, "\nHolds: {}.\n", names.join(", "));
        }
        if rule.all().next().is_some() {
            s += "\n| attribute | is | default | |\n| --- | --- | --- | --- |\n";
        }
        for a in rule.all() {
            let presence = match a.presence {
                Presence::Required => "required".to_string(),
                Presence::Optional => String::new(),
                Presence::Default(d) => format!("`{d}`"),
            };
            let _ = writeln!(
                s,
                "| `{}` | {} | {presence} | {} |",
                a.name,
                kind_text(a),
                a.doc.replace('|', "\\|")
            );
        }
    }
    s
}

fn child_text(c: &super::ChildRule) -> String {
    let times = match (c.required, c.many) {
        (true, true) => " (one or more)",
        (false, true) => " (any number)",
        (true, false) => " (one)",
        (false, false) => "",
    };
    format!("`<{}>`{times}", super::rule(c.key).name())
}

fn kind_text(a: &AttributeRule) -> String {
    let words = |w: &[&str]| w.iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", ");
    let ranged = |q: Quantity, text: String| match a.range.describe(q) {
        Some(r) if q.has_unit() || q == Quantity::Count || !r.is_empty() => format!("{text}, {r}"),
        _ => text,
    };
    match a.kind {
        Kind::Number(q) => ranged(q, q.name().to_string()),
        Kind::NumberOr(q, w) => ranged(q, format!("{} or {}", q.name(), words(w))),
        Kind::List(q, Some(n)) => ranged(q, format!("{n} numbers, each {}", q.name())),
        Kind::List(q, None) => ranged(q, format!("numbers, each {}", q.name())),
        Kind::Choice(w) => words(w),
        Kind::Integer => "a whole number".into(),
        Kind::Nside => ranged(Quantity::Number, "a granularity".into()),
        Kind::Id => "an identifier".into(),
        Kind::Reference(what) => format!("the id of a {what}"),
        Kind::File => "a file".into(),
        Kind::Text => "text".into(),
    }
}
