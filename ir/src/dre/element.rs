//! Elements of the XML forms, with accessors for required attributes and numbers. The first error
//! ends the reading.

use super::DreError;
use srp_archdesc::diagnostic::Span;
use srp_archdesc::nearest::nearest;
use srp_archdesc::xml::tree::{self, Attribute, AttributeMistake, Limits, Mistake};
use std::borrow::Cow;

pub(super) use srp_archdesc::xml::tree::Element;

/// A file needs five levels.
pub(crate) const LIMITS: Limits = Limits {
    bytes: 256 << 20,
    depth: 16,
    attributes: 32,
};

/// An error and its place.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) span: Span,
    pub(super) message: String,
}

pub(super) type Read<T> = Result<T, Fault>;

pub(super) fn fault<T>(span: Span, message: impl Into<String>) -> Read<T> {
    Err(Fault {
        span,
        message: message.into(),
    })
}

impl Fault {
    pub(super) fn in_text(self, xml: &str) -> DreError {
        DreError::new(xml, self.span, self.message)
    }
}

/// A piece of an attribute's value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Text<'a> {
    pub(super) text: &'a str,
    /// The whole value, where its pieces cannot be told apart in the file.
    span: Span,
    /// True if the file contains the value verbatim, so that its pieces have spans of their own.
    verbatim: bool,
}

impl<'a> Text<'a> {
    pub(super) fn fault<T>(self, message: impl Into<String>) -> Read<T> {
        fault(self.span, message)
    }

    /// The bytes from `start` up to `end` of it.
    pub(super) fn piece(self, start: usize, end: usize) -> Text<'a> {
        let span = if self.verbatim {
            Span::new(self.span.start + start as u32, self.span.start + end as u32)
        } else {
            self.span
        };
        Text {
            text: &self.text[start..end],
            span,
            ..self
        }
    }

    /// The words that spaces divide it into.
    pub(super) fn words(self) -> impl Iterator<Item = Text<'a>> {
        self.split(|c| c.is_whitespace())
            .filter(|word| !word.text.is_empty())
    }

    /// The pieces between the characters that `is_border` accepts.
    pub(super) fn split(self, is_border: impl Fn(char) -> bool) -> impl Iterator<Item = Text<'a>> {
        let mut rest = Some(0);
        std::iter::from_fn(move || {
            let start = rest?;
            let found = self.text[start..]
                .char_indices()
                .find(|(_, c)| is_border(*c));
            let end = match found {
                Some((at, c)) => {
                    rest = Some(start + at + c.len_utf8());
                    start + at
                }
                None => {
                    rest = None;
                    self.text.len()
                }
            };
            Some(self.piece(start, end))
        })
    }

    /// Returns the text before and after the first `border`.
    pub(super) fn split_once(self, border: char) -> Option<(Text<'a>, Text<'a>)> {
        let at = self.text.find(border)?;
        let after = at + border.len_utf8();
        Some((self.piece(0, at), self.piece(after, self.text.len())))
    }

    /// Returns the text before `end`; `None` if it does not end so.
    pub(super) fn strip_suffix(self, end: char) -> Option<Text<'a>> {
        let rest = self.text.strip_suffix(end)?;
        Some(self.piece(0, rest.len()))
    }

    /// A number, decimal or with `0x`.
    pub(super) fn u32(self) -> Read<u32> {
        let parsed = match self.text.strip_prefix("0x") {
            Some(hex) if !hex.starts_with('+') => u32::from_str_radix(hex, 16).ok(),
            _ => self.text.parse().ok(),
        };
        match parsed {
            Some(number) => Ok(number),
            None => self.fault(format!("`{}` is not a number below 2^32", self.text)),
        }
    }

    pub(super) fn i32(self) -> Read<i32> {
        match self.text.parse() {
            Ok(number) => Ok(number),
            Err(_) => self.fault(format!(
                "`{}` is not an integer between -2^31 and 2^31 - 1",
                self.text
            )),
        }
    }

    pub(super) fn bool(self) -> Read<bool> {
        match self.text {
            "true" => Ok(true),
            "false" => Ok(false),
            other => self.fault(format!("`{other}` is neither `true` nor `false`")),
        }
    }
}

/// An element that stands in no XML, with names, values and places of its attributes.
pub(super) fn made<'x>(
    name: &'x str,
    span: Span,
    attributes: Vec<(&'x str, &'x str, Span)>,
) -> Element<'x> {
    let attribute = |(name, value, span): (&'x str, &'x str, Span)| Attribute {
        name,
        name_span: span,
        value: Cow::Borrowed(value),
        value_span: span,
    };
    Element {
        name,
        span,
        attributes: attributes.into_iter().map(attribute).collect(),
        children: Vec::new(),
    }
}

/// Accessors of an element.
pub(super) trait ElementExt {
    /// A mistake at its name.
    fn fault<T>(&self, message: impl Into<String>) -> Read<T>;

    /// Refuses attributes but these.
    fn only(&self, names: &[&str]) -> Read<()>;

    /// The value of an attribute, if it is given.
    fn optional(&self, name: &str) -> Option<Text<'_>>;

    /// The value of an attribute that must be given.
    fn required(&self, name: &str) -> Read<Text<'_>>;

    /// The words of an attribute; none where it is missing.
    fn words(&self, name: &str) -> impl Iterator<Item = Text<'_>>;

    /// The mistake that this element is where only others may stand.
    fn misplaced<T>(&self, allowed: &[&str]) -> Read<T>;
}

impl ElementExt for Element<'_> {
    fn fault<T>(&self, message: impl Into<String>) -> Read<T> {
        fault(self.span, message)
    }

    fn only(&self, names: &[&str]) -> Read<()> {
        match self.attributes.iter().find(|a| !names.contains(&a.name)) {
            None => Ok(()),
            Some(a) => {
                let hint = hint(a.name, names);
                let message = format!("`<{}>` has no attribute `{}`{hint}", self.name, a.name);
                fault(a.name_span, message)
            }
        }
    }

    fn optional(&self, name: &str) -> Option<Text<'_>> {
        let a = self.attributes.iter().find(|a| a.name == name)?;
        let length = (a.value_span.end - a.value_span.start) as usize;
        Some(Text {
            text: &a.value,
            span: a.value_span,
            verbatim: matches!(a.value, Cow::Borrowed(_)) && length == a.value.len(),
        })
    }

    fn required(&self, name: &str) -> Read<Text<'_>> {
        match self.optional(name) {
            Some(text) => Ok(text),
            None => self.fault(format!("`<{}>` needs an attribute `{name}`", self.name)),
        }
    }

    fn words(&self, name: &str) -> impl Iterator<Item = Text<'_>> {
        self.optional(name).into_iter().flat_map(Text::words)
    }

    fn misplaced<T>(&self, allowed: &[&str]) -> Read<T> {
        let hint = hint(self.name, allowed);
        self.fault(format!("`<{}>` is not expected here{hint}", self.name))
    }
}

/// The root element of `xml`, which must be called `name`.
pub(super) fn parse<'x>(xml: &'x str, name: &str) -> Read<Element<'x>> {
    let document = tree::parse(xml, LIMITS);
    if let Some(mistake) = document.mistakes.into_iter().next() {
        return worded(mistake, name);
    }
    match document.root {
        Some(root) if root.name == name => Ok(root),
        Some(root) => root.fault(format!("expected `<{name}>`, found `<{}>`", root.name)),
        None => unreachable!("a document without a root has a mistake"),
    }
}

/// A mistake in a file that is a `<name>`.
fn worded<T>(mistake: Mistake<'_>, name: &str) -> Read<T> {
    match mistake {
        Mistake::TooLong => {
            let message = format!("the file is longer than {} MiB", LIMITS.bytes >> 20);
            fault(Span::point(0), message)
        }
        Mistake::TooDeep { tag, .. } => {
            let message = format!("elements are nested more than {} deep", LIMITS.depth);
            fault(tag, message)
        }
        Mistake::TooManyAttributes { element } => {
            let message = format!("an element has more than {} attributes", LIMITS.attributes);
            fault(element, message)
        }
        Mistake::SecondRoot { tag, .. } => fault(tag, "a second root element"),
        Mistake::Attribute {
            mistake: AttributeMistake::BadValue { value, .. },
            why,
            ..
        } => fault(value, format!("this value cannot be read: {why}")),
        Mistake::Attribute { element, why, .. } => {
            fault(element, format!("this is not XML: {why}"))
        }
        Mistake::Text(span) => fault(span, "text between elements; all data are in attributes"),
        Mistake::DocumentType(span) => fault(span, "document types are not understood"),
        Mistake::Unclosed { name, span } => fault(span, format!("`<{name}>` is never closed")),
        Mistake::Empty { end } => fault(
            Span::point(end),
            format!("the file has no element; expected `<{name}>`"),
        ),
        Mistake::Mismatched { tag: at, why, .. }
        | Mistake::Unmatched { tag: at, why, .. }
        | Mistake::Malformed { rest: at, why, .. } => {
            fault(Span::point(at.start), format!("this is not XML: {why}"))
        }
    }
}

/// `: did you mean x?`, or the list of known names.
pub(super) fn hint(name: &str, allowed: &[&str]) -> String {
    match nearest(name, allowed.iter().copied()) {
        Some(near) => format!("; did you mean `{near}`?"),
        None => {
            let list: Vec<String> = allowed.iter().map(|a| format!("`{a}`")).collect();
            format!("; there are {}", list.join(", "))
        }
    }
}
