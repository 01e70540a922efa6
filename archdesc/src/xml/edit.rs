//! Changing attributes of a machine file by their paths, so that sweeps can vary any number of a machine without
//! knowing what it means. The text keeps its comments and its order; whether the result is a machine is for
//! [`parse`](super::parse) to say.

use super::raw::{self, Fields};
use super::syntax::LIMITS;
use super::tree::{self, Element};
use crate::nearest::nearest;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// The path of an attribute: `array.rows`, `special[function=rcp].bits`, `array/file[name=word].size`,
/// `fu-type[*]/file[*].size`.
///
/// Before the last dot stand elements, the outer ones first, each with what chooses among those of its name: an
/// attribute with its value, a number from 1, or `*` for all. Elements that are named lie in each other, with
/// others between them or without. The first is the machine's own where a machine can have one: `special` is a
/// function of the SRP, `tni/special` that of the T&I unit.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct AttributePath {
    steps: Vec<Step>,
    attribute: String,
}

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Step {
    element: String,
    chosen: Option<Chosen>,
}

/// The choice among elements of one name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Chosen {
    All,
    Number(usize),
    With { attribute: String, value: String },
}

/// An attribute and what it is to be, `PATH=VALUE`: `array.rows=5`, `special[function=rcp].bits=8`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    path: AttributePath,
    value: String,
}

impl Change {
    /// Returns a machine file with the change made.
    ///
    /// # Errors
    ///
    /// As of [`AttributePath::set`].
    pub fn make(&self, xml: &str) -> Result<String, EditError> {
        self.path.set(xml, &self.value)
    }
}

impl FromStr for Change {
    type Err = EditError;

    fn from_str(text: &str) -> Result<Change, EditError> {
        let (path, value) =
            split_setting(text).ok_or_else(|| EditError::Change(text.to_owned()))?;
        Ok(Change {
            path: path.parse()?,
            value: value.to_owned(),
        })
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.path, self.value)
    }
}

/// The two sides of `PATH=VALUE`; a choice in the path's brackets has an equals sign of its own.
pub fn split_setting(text: &str) -> Option<(&str, &str)> {
    let mut inside = false;
    let (at, _) = text.char_indices().find(|&(_, c)| {
        inside = (inside || c == '[') && c != ']';
        c == '=' && !inside
    })?;
    (at > 0).then(|| (&text[..at], &text[at + 1..]))
}

/// Why an attribute cannot be set, in one sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EditError {
    /// The text is no path.
    #[error(
        "`{0}` is no path of an attribute: write ELEMENT.ATTRIBUTE, as in array.rows, \
         special[function=rcp].bits or array/file[name=word].size"
    )]
    Path(String),
    /// The text is no change of an attribute.
    #[error("`{0}` sets nothing: write ELEMENT.ATTRIBUTE=VALUE, as in array.rows=5")]
    Change(String),
    /// The machine is not XML.
    #[error("the machine file is not XML")]
    Xml,
    /// The machine has no such element.
    #[error("`{path}`: the machine has no `<{element}>`{hint}")]
    NoElement {
        /// The path.
        path: String,
        /// The element.
        element: String,
        /// The element that may be meant.
        hint: String,
    },
    /// There are several such elements.
    #[error(
        "`{path}`: the machine has {count} of these; choose by {choices}, or write [*] for all"
    )]
    Several {
        /// The path.
        path: String,
        /// The elements.
        count: usize,
        /// How to choose.
        choices: String,
    },
}

impl FromStr for AttributePath {
    type Err = EditError;

    fn from_str(text: &str) -> Result<AttributePath, EditError> {
        let wrong = || EditError::Path(text.to_owned());
        let (elements, attribute) = text.rsplit_once('.').ok_or_else(wrong)?;
        let steps: Option<Vec<Step>> = split(elements).map(Step::parse).collect();
        match steps {
            Some(steps) if is_name(attribute) => Ok(AttributePath {
                steps,
                attribute: attribute.to_owned(),
            }),
            _ => Err(wrong()),
        }
    }
}

impl fmt::Display for AttributePath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, step) in self.steps.iter().enumerate() {
            let between = if i > 0 { "/" } else { "" };
            write!(f, "{between}{}", step.element)?;
            match &step.chosen {
                None => {}
                Some(Chosen::All) => f.write_str("[*]")?,
                Some(Chosen::Number(n)) => write!(f, "[{n}]")?,
                Some(Chosen::With { attribute, value }) => write!(f, "[{attribute}={value}]")?,
            }
        }
        write!(f, ".{}", self.attribute)
    }
}

/// The steps of a path; slashes in brackets are part of a value.
fn split(elements: &str) -> impl Iterator<Item = &str> {
    let mut inside = false;
    elements.split(move |c| {
        inside = (inside || c == '[') && c != ']';
        c == '/' && !inside
    })
}

fn is_name(text: &str) -> bool {
    let letter = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.chars().all(letter)
}

impl Step {
    fn parse(text: &str) -> Option<Step> {
        let (element, chosen) = match text.split_once('[') {
            None => (text, None),
            Some((element, rest)) => (element, Some(Chosen::parse(rest.strip_suffix(']')?)?)),
        };
        is_name(element).then(|| Step {
            element: element.to_owned(),
            chosen,
        })
    }
}

impl Chosen {
    fn parse(text: &str) -> Option<Chosen> {
        if text == "*" {
            return Some(Chosen::All);
        }
        match text.split_once('=') {
            Some((attribute, value)) if is_name(attribute) => Some(Chosen::With {
                attribute: attribute.to_owned(),
                value: value.trim_matches('"').to_owned(),
            }),
            Some(_) => None,
            None => text.parse().ok().filter(|&n| n > 0).map(Chosen::Number),
        }
    }
}

impl AttributePath {
    /// Returns a machine file with this attribute set. An element that the file does not have is added where there is
    /// one that can have it.
    ///
    /// # Errors
    ///
    /// The file is not XML, has no such element, or several and the path does not choose.
    pub fn set(&self, xml: &str, value: &str) -> Result<String, EditError> {
        let document = tree::parse(xml, LIMITS);
        let root = match document.root {
            Some(root) if document.mistakes.is_empty() => root,
            _ => return Err(EditError::Xml),
        };
        let found = self.find(&root, &self.steps)?;
        let mut edits: Vec<(Range<usize>, String)> = Vec::new();
        for element in &found {
            let mut attributes = element.attributes.iter();
            edits.push(match attributes.find(|a| a.name == self.attribute) {
                Some(attribute) => {
                    let span = attribute.value_span;
                    (span.start as usize..span.end as usize, escaped(value))
                }
                None => {
                    let end = element.span.end as usize;
                    let set = format!(" {}=\"{}\"", self.attribute, escaped(value));
                    (end..end, set)
                }
            });
        }
        if found.is_empty() {
            edits.push(self.added(xml, &root, value)?);
        }
        let mut text = xml.to_owned();
        edits.sort_by_key(|(range, _)| std::cmp::Reverse(range.start));
        for (range, new) in edits {
            text.replace_range(range, &new);
        }
        Ok(text)
    }

    /// The elements that some steps lead to.
    fn find<'e, 'x>(
        &self,
        root: &'e Element<'x>,
        steps: &[Step],
    ) -> Result<Vec<&'e Element<'x>>, EditError> {
        let mut within = vec![root];
        for (i, step) in steps.iter().enumerate() {
            let name = &step.element;
            let mut found: Vec<&Element<'_>> = Vec::new();
            match i {
                0 if name == root.name => found.push(root),
                0 if has(raw::Machine::FIELDS, name) => {
                    found.extend(root.children.iter().filter(|child| child.name == name));
                }
                _ => within
                    .iter()
                    .for_each(|element| inner(element, name, &mut found)),
            }
            match &step.chosen {
                Some(Chosen::All) => {}
                Some(Chosen::Number(n)) => found = found.get(n - 1).copied().into_iter().collect(),
                Some(Chosen::With { attribute, value }) => found.retain(|element| {
                    let mut all = element.attributes.iter();
                    all.any(|a| a.name == attribute && a.value == value.as_str())
                }),
                None if found.len() > 1 => return Err(self.several(&found)),
                None => {}
            }
            within = found;
        }
        Ok(within)
    }

    fn several(&self, found: &[&Element<'_>]) -> EditError {
        let first = found[0];
        let names = first.attributes.iter().map(|a| a.name);
        let differs = names.into_iter().find(|name| {
            let of = |e: &&Element<'_>| {
                let mut all = e.attributes.iter();
                all.find(|a| a.name == *name).map(|a| a.value.to_string())
            };
            let mut values: Vec<_> = found.iter().map(of).collect();
            values.sort();
            values.windows(2).all(|pair| pair[0] != pair[1])
        });
        let choices = match differs {
            Some(name) => {
                let of = |e: &&Element<'_>| {
                    let mut all = e.attributes.iter();
                    let value = all.find(|a| a.name == name).map(|a| a.value.to_string());
                    format!("[{name}={}]", value.unwrap_or_default())
                };
                let some: Vec<String> = found.iter().take(3).map(of).collect();
                some.join(", ")
            }
            None => "number, [1] and so on, or by the element that it lies in".to_owned(),
        };
        EditError::Several {
            path: self.to_string(),
            count: found.len(),
            choices,
        }
    }

    /// The edit that adds the element.
    fn added(
        &self,
        xml: &str,
        root: &Element<'_>,
        value: &str,
    ) -> Result<(Range<usize>, String), EditError> {
        let (last, outer) = self.steps.split_last().expect("a path has an element");
        let nothing = || self.nothing(root, &last.element);
        let parents = match (outer, has(raw::Machine::FIELDS, &last.element)) {
            ([], true) => vec![root],
            ([], false) => {
                let all = [
                    ("array", raw::Array::FIELDS),
                    ("system", raw::System::FIELDS),
                    ("tni", raw::Tni::FIELDS),
                ];
                let mut parents = Vec::new();
                let of = all.iter().filter(|(_, fields)| has(fields, &last.element));
                of.for_each(|(name, _)| inner(root, name, &mut parents));
                parents
            }
            (outer, _) => self.find(root, outer)?,
        };
        let [parent] = parents[..] else {
            return Err(nothing());
        };
        let chosen = match &last.chosen {
            None => String::new(),
            // What has a name is of use to what names it, and nothing names what is new.
            Some(Chosen::With { attribute, .. }) if attribute == "name" => return Err(nothing()),
            Some(Chosen::With { attribute, value }) => {
                format!(" {attribute}=\"{}\"", escaped(value))
            }
            Some(_) => return Err(nothing()),
        };
        let (name, set) = (&last.element, &self.attribute);
        let element = format!("<{name}{chosen} {set}=\"{}\"/>", escaped(value));
        let open = end_of_start(xml, parent).ok_or_else(nothing)?;
        if xml[..open].ends_with('/') {
            let all = format!(">{element}</{}>", parent.name);
            return Ok((open - 1..open + 1, all));
        }
        let begin = parent.children.last();
        let begin = begin.map_or(Some(open + 1), |child| end_of_start(xml, child));
        let begin = begin.ok_or_else(nothing)?;
        let end = begin + end_tag(&xml[begin..], parent.name).ok_or_else(nothing)?;
        let is_alone = xml[..end].trim_end_matches([' ', '\t']).ends_with('\n');
        Ok((end..end, if is_alone { element + "\n" } else { element }))
    }

    fn nothing(&self, root: &Element<'_>, element: &str) -> EditError {
        let mut known = Vec::new();
        names(root, &mut known);
        EditError::NoElement {
            path: self.to_string(),
            element: element.to_owned(),
            hint: match nearest(element, known.iter().copied()) {
                Some(near) if near != element => format!("; did you mean `{near}`?"),
                Some(_) => " that its brackets choose".to_owned(),
                None => String::new(),
            },
        }
    }
}

/// Where the start tag of an element ends: its `>`, behind the last attribute.
fn end_of_start(xml: &str, element: &Element<'_>) -> Option<usize> {
    let last = element.attributes.iter().map(|a| a.value_span.end);
    let from = last.max().unwrap_or(element.span.end) as usize;
    Some(from + xml.get(from..)?.find('>')?)
}

/// Where the first end tag of a name begins that stands in no comment.
fn end_tag(xml: &str, name: &str) -> Option<usize> {
    let mut at = 0;
    loop {
        at += xml[at..].find('<')?;
        let tag = &xml[at..];
        if tag
            .strip_prefix("</")
            .is_some_and(|rest| rest.starts_with(name))
        {
            return Some(at);
        }
        let (end, skipped) = if tag.starts_with("<!--") {
            ("-->", 4)
        } else {
            (">", 1)
        };
        at += skipped + tag[skipped..].find(end)? + end.len();
    }
}

/// True when an element can have an attribute or element of this name.
fn has(fields: &[&str], name: &str) -> bool {
    fields.iter().any(|field| field.replace('_', "-") == name)
}

/// Collects the elements of a name anywhere in an element.
fn inner<'e, 'x>(element: &'e Element<'x>, name: &str, found: &mut Vec<&'e Element<'x>>) {
    for child in &element.children {
        if child.name == name {
            found.push(child);
        }
        inner(child, name, found);
    }
}

fn names<'x>(element: &Element<'x>, all: &mut Vec<&'x str>) {
    all.push(element.name);
    element.children.iter().for_each(|child| names(child, all));
}

/// A value as it stands between quotes.
fn escaped(value: &str) -> String {
    let mut text = String::with_capacity(value.len());
    for c in value.chars() {
        match c {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '"' => text.push_str("&quot;"),
            '\'' => text.push_str("&apos;"),
            c => text.push(c),
        }
    }
    text
}
