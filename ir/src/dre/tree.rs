//! XML as a tree of elements that know where they stand, and the writing of it.
//!
//! All data are in attributes; text between elements is a mistake. Line breaks and tabs in values
//! are written as references, since XML would turn them into spaces.

use super::DreError;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use srp_archdesc::diagnostic::Span;
use srp_archdesc::nearest::nearest;
use std::borrow::Cow;
use std::fmt::{Display, Write};

/// Elements may be nested this deep; a file needs five levels.
const MAX_DEPTH: usize = 16;

/// Attributes of one element.
const MAX_ATTRIBUTES: usize = 32;

/// Longest file in bytes.
const MAX_BYTES: usize = 256 << 20;

/// What is wrong, and where.
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
    /// Whether the value stands in the file as it is, so that pieces have places of their own.
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

    /// What stands before and after the first `border`.
    pub(super) fn split_once(self, border: char) -> Option<(Text<'a>, Text<'a>)> {
        let at = self.text.find(border)?;
        let after = at + border.len_utf8();
        Some((self.piece(0, at), self.piece(after, self.text.len())))
    }

    /// What stands before `end`, if it ends in that.
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

/// An element.
#[derive(Debug)]
pub(super) struct Element<'x> {
    pub(super) name: &'x str,
    /// Where the name stands in the start tag.
    pub(super) span: Span,
    attributes: Vec<Attribute<'x>>,
    pub(super) children: Vec<Element<'x>>,
}

#[derive(Debug)]
struct Attribute<'x> {
    name: &'x str,
    name_span: Span,
    value: Cow<'x, str>,
    value_span: Span,
}

impl<'x> Element<'x> {
    /// An element that stands in no XML, with names, values and places of its attributes.
    pub(super) fn made(
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
}

impl Element<'_> {
    pub(super) fn fault<T>(&self, message: impl Into<String>) -> Read<T> {
        fault(self.span, message)
    }

    /// Refuses attributes but these.
    pub(super) fn only(&self, names: &[&str]) -> Read<()> {
        match self.attributes.iter().find(|a| !names.contains(&a.name)) {
            None => Ok(()),
            Some(a) => {
                let hint = hint(a.name, names);
                let message = format!("`<{}>` has no attribute `{}`{hint}", self.name, a.name);
                fault(a.name_span, message)
            }
        }
    }

    pub(super) fn optional(&self, name: &str) -> Option<Text<'_>> {
        let a = self.attributes.iter().find(|a| a.name == name)?;
        let length = (a.value_span.end - a.value_span.start) as usize;
        Some(Text {
            text: &a.value,
            span: a.value_span,
            verbatim: matches!(a.value, Cow::Borrowed(_)) && length == a.value.len(),
        })
    }

    pub(super) fn required(&self, name: &str) -> Read<Text<'_>> {
        match self.optional(name) {
            Some(text) => Ok(text),
            None => self.fault(format!("`<{}>` needs an attribute `{name}`", self.name)),
        }
    }

    /// The words of an attribute; none where it is missing.
    pub(super) fn words(&self, name: &str) -> impl Iterator<Item = Text<'_>> {
        self.optional(name).into_iter().flat_map(Text::words)
    }

    /// The mistake that this element is where only others may stand.
    pub(super) fn misplaced<T>(&self, allowed: &[&str]) -> Read<T> {
        let hint = hint(self.name, allowed);
        self.fault(format!("`<{}>` is not expected here{hint}", self.name))
    }
}

/// `: did you mean x?`, or what there is.
pub(super) fn hint(name: &str, allowed: &[&str]) -> String {
    match nearest(name, allowed.iter().copied()) {
        Some(near) => format!("; did you mean `{near}`?"),
        None => {
            let list: Vec<String> = allowed.iter().map(|a| format!("`{a}`")).collect();
            format!("; there are {}", list.join(", "))
        }
    }
}

/// The root element, which must be called `name`.
pub(super) fn parse<'x>(xml: &'x str, name: &str) -> Read<Element<'x>> {
    if xml.len() > MAX_BYTES {
        let message = format!("the file is longer than {} MiB", MAX_BYTES >> 20);
        return fault(Span::point(0), message);
    }
    let mut open: Vec<Element<'x>> = Vec::new();
    let mut root: Option<Element<'x>> = None;
    let mut reader = Reader::from_str(xml);
    reader.config_mut().expand_empty_elements = true;
    loop {
        let start = reader.buffer_position() as u32;
        let event = reader.read_event();
        let here = Span::new(start, reader.buffer_position() as u32);
        match event {
            Ok(Event::Start(tag)) => {
                if open.len() == MAX_DEPTH {
                    return fault(
                        here,
                        format!("elements are nested more than {MAX_DEPTH} deep"),
                    );
                }
                if open.is_empty() && root.is_some() {
                    return fault(here, "a second root element");
                }
                open.push(element(xml, &tag)?);
            }
            Ok(Event::End(_)) => {
                let element = open.pop().expect("the reader checks that tags match");
                match open.last_mut() {
                    Some(parent) => parent.children.push(element),
                    None => root = Some(element),
                }
            }
            Ok(Event::Text(text)) if text.trim().is_empty() => {}
            Ok(Event::Text(text)) => {
                let blank = text.len() - text.trim_start().len();
                let here = Span::new(start + blank as u32, here.end);
                return fault(here, "text between elements; all data are in attributes");
            }
            Ok(Event::CData(_) | Event::GeneralRef(_)) => {
                return fault(here, "text between elements; all data are in attributes");
            }
            Ok(Event::DocType(_)) => return fault(here, "document types are not understood"),
            Ok(Event::Decl(_) | Event::PI(_) | Event::Comment(_) | Event::Empty(_)) => {}
            Ok(Event::Eof) => break,
            Err(error) => {
                let at = Span::point(reader.error_position() as u32);
                return fault(at, format!("this is not XML: {error}"));
            }
        }
    }
    if let Some(element) = open.last() {
        return element.fault(format!("`<{}>` is never closed", element.name));
    }
    called(root, name, xml.len() as u32)
}

/// The root element, if it has this name.
fn called<'x>(root: Option<Element<'x>>, name: &str, end: u32) -> Read<Element<'x>> {
    match root {
        Some(root) if root.name == name => Ok(root),
        Some(root) => root.fault(format!("expected `<{name}>`, found `<{}>`", root.name)),
        None => fault(
            Span::point(end),
            format!("the file has no element; expected `<{name}>`"),
        ),
    }
}

/// The span of a slice of the text.
fn span_of(xml: &str, slice: &str) -> Span {
    let start = (slice.as_ptr() as usize).wrapping_sub(xml.as_ptr() as usize);
    match xml.get(start..start.wrapping_add(slice.len())) {
        Some(_) => Span::new(start as u32, (start + slice.len()) as u32),
        None => Span::point(0),
    }
}

fn slice(xml: &str, span: Span) -> &str {
    &xml[span.start as usize..span.end as usize]
}

fn element<'x>(xml: &'x str, tag: &BytesStart<'x>) -> Read<Element<'x>> {
    let span = span_of(xml, tag.name().0);
    let mut attributes = Vec::new();
    for attribute in tag.attributes() {
        if attributes.len() == MAX_ATTRIBUTES {
            let message = format!("an element has more than {MAX_ATTRIBUTES} attributes");
            return fault(span, message);
        }
        let attribute = match attribute {
            Ok(attribute) => attribute,
            Err(error) => return fault(span, format!("this is not XML: {error}")),
        };
        let name_span = span_of(xml, attribute.key.0);
        let value_span = span_of(xml, &attribute.value);
        let value = match attribute.normalized_value(XmlVersion::Explicit1_0) {
            Ok(Cow::Owned(value)) => Cow::Owned(value),
            Ok(Cow::Borrowed(_)) => Cow::Borrowed(slice(xml, value_span)),
            Err(error) => return fault(value_span, format!("this value cannot be read: {error}")),
        };
        attributes.push(Attribute {
            name: slice(xml, name_span),
            name_span,
            value,
            value_span,
        });
    }
    Ok(Element {
        name: slice(xml, span),
        span,
        attributes,
        children: Vec::new(),
    })
}

/// A start tag with its attributes.
pub(super) struct Tag {
    name: &'static str,
    text: String,
}

impl Tag {
    pub(super) fn new(name: &'static str) -> Tag {
        Tag {
            name,
            text: format!("<{name}"),
        }
    }

    pub(super) fn attr(mut self, name: &str, value: impl Display) -> Tag {
        self.text.push(' ');
        self.text.push_str(name);
        self.text.push_str("=\"");
        for c in value.to_string().chars() {
            match c {
                '&' => self.text.push_str("&amp;"),
                '<' => self.text.push_str("&lt;"),
                '"' => self.text.push_str("&quot;"),
                '\t' | '\n' | '\r' => drop(write!(self.text, "&#{};", u32::from(c))),
                c => self.text.push(c),
            }
        }
        self.text.push('"');
        self
    }

    /// The attribute, if there is anything to say.
    pub(super) fn attr_if(self, name: &str, value: Option<impl Display>) -> Tag {
        match value {
            Some(value) => self.attr(name, value),
            None => self,
        }
    }

    /// The attribute with the items, divided by spaces, if there are any.
    pub(super) fn list(self, name: &str, items: impl IntoIterator<Item = impl Display>) -> Tag {
        let items: Vec<String> = items.into_iter().map(|item| item.to_string()).collect();
        if items.is_empty() {
            self
        } else {
            self.attr(name, items.join(" "))
        }
    }
}

/// A document being written, two spaces a level.
#[derive(Default)]
pub(super) struct Xml {
    pub(super) text: String,
    open: Vec<&'static str>,
}

impl Xml {
    pub(super) fn new() -> Xml {
        Xml {
            text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned(),
            open: Vec::new(),
        }
    }

    fn indent(&mut self) {
        for _ in 0..self.open.len() {
            self.text.push_str("  ");
        }
    }

    /// An element without children.
    pub(super) fn leaf(&mut self, tag: Tag) {
        self.indent();
        self.text.push_str(&tag.text);
        self.text.push_str("/>\n");
    }

    /// The start of an element with children.
    pub(super) fn open(&mut self, tag: Tag) {
        self.indent();
        self.text.push_str(&tag.text);
        self.text.push_str(">\n");
        self.open.push(tag.name);
    }

    /// The end of the last element opened.
    pub(super) fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            self.indent();
            self.text.push_str("</");
            self.text.push_str(name);
            self.text.push_str(">\n");
        }
    }
}
