//! An element while the scene is built: values by name, with defaults from the table and from a
//! distribution file. Values that the table check refused are answered with None; that error is told.

use super::Reading;
use crate::scene::diagnostic::{Diagnostic, Place};
use crate::scene::document::{Attribute, Element};
use crate::scene::table::{self, Kind, Presence, Rule};
use crate::units::{self, Quantity};

/// An element, its rule, and the element of a distribution file that fills its gaps.
#[derive(Clone, Copy)]
pub struct Node<'a> {
    pub own: &'a Element,
    pub base: Option<&'a Element>,
    pub rule: &'static Rule,
}

impl<'a> Node<'a> {
    pub fn new(own: &'a Element, rule: &'static Rule) -> Self {
        Node { own, base: None, rule }
    }

    /// The attribute as written, here or in the distribution file; marks it used.
    pub fn attribute(&self, name: &str) -> Option<&'a Attribute> {
        debug_assert!(self.rule.attribute(name).is_some(), "{} {name}", self.rule.key);
        let a = self.own.attribute(name).or_else(|| self.base?.attribute(name))?;
        a.used.set(true);
        (!a.broken).then_some(a)
    }

    /// Is it written, here or in the distribution file?
    pub fn has(&self, name: &str) -> bool {
        self.own.attribute(name).is_some() || self.base.is_some_and(|b| b.attribute(name).is_some())
    }

    /// Text of the attribute, or its default.
    pub fn text(&self, name: &str) -> Option<&'a str> {
        if self.has(name) {
            return self.attribute(name).map(|a| a.value.trim());
        }
        match self.rule.attribute(name)?.presence {
            Presence::Default(d) => Some(d),
            _ => None,
        }
    }

    fn quantity(&self, name: &str) -> Option<Quantity> {
        match self.rule.attribute(name)?.kind {
            Kind::Number(q) | Kind::NumberOr(q, _) | Kind::List(q, _) => Some(q),
            _ => None,
        }
    }

    /// A number in internal units, if it is valid.
    pub fn number(&self, name: &str) -> Option<f64> {
        let x = self.quantity(name)?.parse(self.text(name)?).ok()?;
        self.rule.attribute(name)?.range.contains(x).then_some(x)
    }

    /// Numbers in internal units.
    pub fn list(&self, name: &str) -> Option<Vec<f64>> {
        self.quantity(name)?.parse_list(self.text(name)?).ok()
    }

    /// Three numbers.
    pub fn vector(&self, name: &str) -> Option<crate::math::DVec3> {
        let v = self.list(name)?;
        (v.len() == 3).then(|| crate::math::DVec3::new(v[0], v[1], v[2]))
    }

    /// A whole number.
    pub fn count(&self, name: &str) -> Option<u64> {
        units::count(self.text(name)?).ok()
    }

    /// A granularity.
    pub fn nside(&self, name: &str) -> Option<u32> {
        table::nside(self.text(name)?).filter(|n| *n > 0)
    }

    /// yes or no.
    pub fn yes(&self, name: &str) -> bool {
        self.text(name) == Some("yes")
    }

    /// Where the attribute's value stands; else the element.
    pub fn place(&self, name: &str) -> Place {
        let found = self.own.attribute(name).or_else(|| self.base.and_then(|b| b.attribute(name)));
        found.map_or(self.own.place, |a| a.value_place)
    }

    /// The only child of that name, here.
    pub fn child(&self, name: &str) -> Option<Node<'a>> {
        self.children(name).next()
    }

    /// All children of that name, here; marks them used.
    pub fn children(&self, name: &str) -> impl Iterator<Item = Node<'a>> + use<'a> {
        let rule = self.rule.child(name).map(|(_, r)| r);
        let name = name.to_string();
        self.own.children.iter().filter(move |c| c.name == name).filter_map(move |c| {
            c.used.set(true);
            Some(Node::new(c, rule?))
        })
    }

    /// All children in order, of every name that the rule knows.
    pub fn all_children(&self) -> impl Iterator<Item = Node<'a>> + use<'a> {
        let rule = self.rule;
        self.own.children.iter().filter_map(move |c| {
            let (_, child) = rule.child(&c.name)?;
            c.used.set(true);
            Some(Node::new(c, child))
        })
    }

    /// Marks every attribute used.
    pub fn use_all(&self) {
        self.own.attributes.iter().for_each(|a| a.used.set(true));
    }

    /// Which one of `names` is given. What stands here overrides the distribution file. More than one
    /// is an error, none too if `required` says what is missing.
    pub fn one_of(
        &self,
        r: &mut Reading<'_>,
        names: &[&'static str],
        required: Option<&str>,
    ) -> Option<&'static str> {
        for e in [Some(self.own), self.base].into_iter().flatten() {
            let given: Vec<&'static str> =
                names.iter().copied().filter(|n| e.attribute(n).is_some()).collect();
            if let [first, second, ..] = given[..] {
                let place = |n: &str| e.attribute(n).map_or(e.place, |a| a.name_place);
                r.out.push(
                    Diagnostic::error(place(second), format!("`{first}` and `{second}` exclude each other"))
                        .label("this one or the other")
                        .other(place(first), "first here"),
                );
                return Some(first);
            }
            if let Some(first) = given.first() {
                return Some(first);
            }
        }
        if let (Some(what), false) = (required, self.own.misspelt.get()) {
            let list = names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
            r.out.push(
                Diagnostic::error(self.own.place, format!("<{}> needs {what}", self.own.name))
                    .help(format!("exactly one of {list}")),
            );
        }
        None
    }

    /// An attribute that must be given, here or in the distribution file. The table check has told
    /// where elements without `from` lack it.
    pub fn required(&self, r: &mut Reading<'_>, name: &str) -> Option<&'a str> {
        if !self.has(name) && self.own.attribute("from").is_some() && !self.own.misspelt.get() {
            let doc = self.rule.attribute(name).map_or("", |a| a.doc);
            r.out.push(
                Diagnostic::error(
                    self.own.place,
                    format!("<{}> needs the attribute `{name}`", self.own.name),
                )
                .help(format!("{name}: {doc}")),
            );
        }
        self.text(name)
    }

    /// The number of an attribute that must be given because of another value; `why` says of which.
    pub fn needed(&self, r: &mut Reading<'_>, name: &str, why: &str) -> Option<f64> {
        if !self.has(name) && !self.own.misspelt.get() {
            r.out.push(
                Diagnostic::error(self.own.place, format!("<{}> with {why} needs `{name}`", self.own.name))
                    .help(format!("{name}: {}", self.rule.attribute(name).map_or("", |a| a.doc))),
            );
        }
        self.number(name)
    }
}
