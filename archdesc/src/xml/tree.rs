//! An XML document as a tree that knows where everything stands.
//!
//! `quick_xml::de` has no positions; the events of `quick_xml::Reader` borrow from the text, so the
//! place of a name or a value is where its slice points to.

use std::borrow::Cow;

use quick_xml::XmlVersion;
use quick_xml::errors::{Error, IllFormedError};
use quick_xml::escape::EscapeError;
use quick_xml::events::attributes::AttrError;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::findings::Findings;
use super::quote::{quoted, shortened};
use crate::diagnostic::Span;

/// Elements may be nested this deep; a machine file needs five levels.
const MAX_DEPTH: usize = 32;

/// Attributes of one element. `quick_xml` looks for repeated names in quadratic time.
const MAX_ATTRIBUTES: usize = 64;

/// Longest file in bytes. The expanded form of a 64×64 array takes less.
const MAX_BYTES: usize = 16 << 20;

/// An element.
pub(super) struct Element<'x> {
    /// Its name.
    pub(super) name: &'x str,
    /// Where the name stands in the start tag.
    pub(super) span: Span,
    /// Its attributes, in order, no name twice.
    pub(super) attributes: Vec<Attribute<'x>>,
    /// Its child elements, in order.
    pub(super) children: Vec<Element<'x>>,
}

/// An attribute.
pub(super) struct Attribute<'x> {
    /// Its name.
    pub(super) name: &'x str,
    /// Where the name stands.
    pub(super) name_span: Span,
    /// Its value, references resolved.
    pub(super) value: Cow<'x, str>,
    /// Where the value stands, without quotes.
    pub(super) value_span: Span,
}

/// The root element of `xml`, or `None` where the text has no tree (the reason is in `found`).
pub(super) fn parse<'x>(xml: &'x str, found: &Findings) -> Option<Element<'x>> {
    if xml.len() > MAX_BYTES {
        let message = format!("the file is longer than {} MiB", MAX_BYTES >> 20);
        found.push(found.error("A0107", Span::point(0), message, ""));
        return None;
    }
    let mut builder = Builder {
        xml,
        found,
        open: Vec::new(),
        root: None,
    };
    let mut reader = Reader::from_str(xml);
    reader.config_mut().expand_empty_elements = true;
    loop {
        let start = position(reader.buffer_position());
        match reader.read_event() {
            Ok(Event::Start(tag)) => builder.start(&tag)?,
            Ok(Event::End(_)) => builder.end(),
            Ok(Event::Eof) => return builder.finish(),
            Ok(Event::Text(text)) => builder.text(&text),
            Ok(Event::CData(_) | Event::GeneralRef(_)) => {
                builder.stray(Span::new(start, position(reader.buffer_position())));
            }
            Ok(Event::DocType(_)) => {
                let span = Span::new(start, position(reader.buffer_position()));
                let message = "a machine file has no document type";
                found.push(found.error("A0101", span, message, "not understood"));
            }
            Ok(Event::Decl(_) | Event::PI(_) | Event::Comment(_) | Event::Empty(_)) => {}
            Err(error) => {
                builder.malformed(&error, position(reader.error_position()));
                return None;
            }
        }
    }
}

/// A tag between backquotes, a very long name shortened.
fn tag(opening: &str, name: &str) -> String {
    format!("`{opening}{}>`", shortened(name))
}

fn position(offset: u64) -> u32 {
    u32::try_from(offset).expect("files are shorter than MAX_BYTES")
}

struct Builder<'x, 'f> {
    xml: &'x str,
    found: &'f Findings,
    open: Vec<Element<'x>>,
    root: Option<Element<'x>>,
}

impl<'x> Builder<'x, '_> {
    /// The span of a slice that an event borrowed from the text.
    fn span_of(&self, slice: &str) -> Span {
        let start = (slice.as_ptr() as usize).wrapping_sub(self.xml.as_ptr() as usize);
        match self.xml.get(start..start.wrapping_add(slice.len())) {
            Some(_) => Span::new(start as u32, (start + slice.len()) as u32),
            None => Span::point(0),
        }
    }

    fn slice(&self, span: Span) -> &'x str {
        &self.xml[span.start as usize..span.end as usize]
    }

    fn start(&mut self, tag: &BytesStart<'x>) -> Option<()> {
        let span = self.span_of(tag.name().0);
        if self.open.len() == MAX_DEPTH {
            let message = format!("elements are nested more than {MAX_DEPTH} deep");
            self.found
                .push(self.found.error("A0107", span, message, "too deep"));
            return None;
        }
        let mut element = Element {
            name: self.slice(span),
            span,
            attributes: Vec::new(),
            children: Vec::new(),
        };
        for (count, attribute) in tag.attributes().enumerate() {
            if count == MAX_ATTRIBUTES {
                let message = format!("an element has more than {MAX_ATTRIBUTES} attributes");
                self.found
                    .push(self.found.error("A0107", span, message, "this one"));
                return None;
            }
            match attribute {
                Ok(attribute) => {
                    let name_span = self.span_of(attribute.key.0);
                    let value_span = self.span_of(&attribute.value);
                    let value = match attribute.normalized_value(XmlVersion::Explicit1_0) {
                        Ok(Cow::Owned(value)) => Cow::Owned(value),
                        Ok(Cow::Borrowed(_)) => Cow::Borrowed(self.slice(value_span)),
                        Err(error) => {
                            self.found.suspect(span, self.slice(name_span));
                            self.bad_reference(value_span, &error);
                            continue;
                        }
                    };
                    element.attributes.push(Attribute {
                        name: self.slice(name_span),
                        name_span,
                        value,
                        value_span,
                    });
                }
                Err(error) => self.bad_attribute(&error, span),
            }
        }
        self.open.push(element);
        Some(())
    }

    fn bad_reference(&self, value: Span, error: &Error) {
        let (span, message) = match error {
            Error::Escape(EscapeError::UnrecognizedEntity(at, name)) => {
                let offset = |n: usize| value.start + position(n as u64);
                let span = Span::new(offset(at.start), offset(at.end));
                (span, format!("the reference `&{name};` is not defined"))
            }
            error => (value, format!("the value cannot be read: {error}")),
        };
        self.found.push(
            self.found
                .error("A0106", span, message, "in this value")
                .help("write `&amp;` for an ampersand and `&lt;` for a less-than sign"),
        );
    }

    fn bad_attribute(&self, error: &AttrError, tag: Span) {
        let at = |offset: &usize| tag.start + position(*offset as u64);
        let diagnostic = match error {
            AttrError::Duplicated(again, first) => {
                let name = |offset: &usize| {
                    let start = at(offset);
                    let rest = &self.xml[start as usize..];
                    let end = rest.find(|c: char| c == '=' || c.is_whitespace());
                    Span::new(start, start + position(end.unwrap_or(0) as u64))
                };
                let name_span = name(again);
                let message = format!("attribute {} is given twice", quoted(self.slice(name_span)));
                self.found
                    .error("A0104", name_span, message, "given again")
                    .also(name(first), "first given here")
            }
            AttrError::ExpectedEq(offset) => {
                self.suspect_before(at(offset), tag);
                let message = "an attribute has no value";
                let label = "expected `=` and a quoted value";
                self.found
                    .error("A0103", Span::point(at(offset)), message, label)
            }
            AttrError::ExpectedValue(offset)
            | AttrError::UnquotedValue(offset)
            | AttrError::ExpectedQuote(offset, _) => {
                self.suspect_before(at(offset), tag);
                let message = "the value of an attribute is not quoted";
                let label = "expected a value in quotes";
                self.found
                    .error("A0103", Span::point(at(offset)), message, label)
            }
        };
        self.found.push(diagnostic);
    }

    /// Notes that the attribute whose name stands before the byte at `at` cannot be read.
    fn suspect_before(&self, at: u32, tag: Span) {
        let before = self.xml.get(tag.start as usize..at as usize).unwrap_or("");
        let before = before.trim_end_matches(|c: char| c == '=' || c.is_whitespace());
        if let Some(name) = before.split_whitespace().next_back() {
            self.found.suspect(tag, name);
        }
    }

    fn end(&mut self) {
        if let Some(element) = self.open.pop() {
            match (self.open.last_mut(), &self.root) {
                (Some(parent), _) => parent.children.push(element),
                (None, None) => self.root = Some(element),
                (None, Some(root)) => {
                    let diagnostic = self
                        .found
                        .error(
                            "A0108",
                            element.span,
                            "a file holds one machine",
                            "a second one",
                        )
                        .also(root.span, "the first one");
                    self.found.push(diagnostic);
                }
            }
        }
    }

    fn text(&self, text: &str) {
        if !text.trim().is_empty() {
            self.stray(self.span_of(text.trim()));
        }
    }

    fn stray(&self, span: Span) {
        let message = "text between elements";
        let label = "elements have attributes and child elements only";
        self.found
            .push(self.found.error("A0105", span, message, label));
    }

    fn finish(self) -> Option<Element<'x>> {
        for element in &self.open {
            let message = format!("{} is never closed", tag("<", element.name));
            self.found.push(
                self.found
                    .error("A0102", element.span, message, "opened here"),
            );
        }
        if self.open.is_empty() && self.root.is_none() {
            let end = Span::point(position(self.xml.len() as u64));
            let diagnostic = self
                .found
                .error(
                    "A0108",
                    end,
                    "the file has no element",
                    "the text ends here",
                )
                .help("a machine file is one `<machine name=\"…\">` element");
            self.found.push(diagnostic);
        }
        if self.open.is_empty() {
            self.root
        } else {
            None
        }
    }

    fn malformed(&self, error: &Error, at: u32) {
        let rest = &self.xml[self.xml.floor_char_boundary(at as usize)..];
        let line = rest.find('\n').unwrap_or(rest.len());
        let length = rest.find('>').map_or(line, |end| (end + 1).min(line));
        let span = Span::new(at, at + position(length as u64));
        let diagnostic = match (error, self.open.last()) {
            (
                Error::IllFormed(IllFormedError::MismatchedEndTag { expected, found }),
                Some(open),
            ) => {
                let message = format!("{} is closed by {}", tag("<", expected), tag("</", found));
                let label = format!("expected {}", tag("</", expected));
                self.found
                    .error("A0102", span, message, label)
                    .also(open.span, "opened here")
            }
            (Error::IllFormed(IllFormedError::UnmatchedEndTag(name)), _) => {
                let message = format!("{} closes nothing", tag("</", name));
                self.found
                    .error("A0102", span, message, "no such element is open")
            }
            (Error::Syntax(error), _) => self.found.error("A0101", span, error.to_string(), ""),
            (Error::IllFormed(error), _) => self.found.error("A0101", span, error.to_string(), ""),
            (error, _) => self.found.error("A0101", span, error.to_string(), ""),
        };
        self.found.push(diagnostic);
    }
}
