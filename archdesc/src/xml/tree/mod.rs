//! An XML document as a tree that knows where everything stands, through which all forms that are XML
//! are read; and the writing of XML.
//!
//! All data are in attributes; text between elements is a mistake. [`parse`] goes on after mistakes as
//! far as that makes sense and says what it found; how that is worded is for the reader of each form.
//!
//! `quick_xml::de` has no positions; the events of `quick_xml::Reader` borrow from the text, so the
//! place of a name or a value is where its slice points to.

mod write;

pub use write::{Tag, Writer};

use std::borrow::Cow;

use quick_xml::XmlVersion;
use quick_xml::errors::{Error, IllFormedError};
use quick_xml::escape::EscapeError;
use quick_xml::events::attributes::AttrError;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use crate::diagnostic::Span;

/// More mistakes than this are not looked for: the text is hardly the form that was expected.
const MAX_MISTAKES: usize = 64;

/// How large a document may be, so that no text takes all memory.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Longest text in bytes, below 4 GiB.
    pub bytes: usize,
    /// Elements may be nested this deep.
    pub depth: usize,
    /// Attributes of one element. `quick_xml` looks for repeated names in quadratic time.
    pub attributes: usize,
}

/// An element.
#[derive(Debug)]
pub struct Element<'x> {
    /// Its name.
    pub name: &'x str,
    /// Where the name stands in the start tag.
    pub span: Span,
    /// Its attributes, in order, no name twice.
    pub attributes: Vec<Attribute<'x>>,
    /// Its child elements, in order.
    pub children: Vec<Element<'x>>,
}

/// An attribute.
#[derive(Debug)]
pub struct Attribute<'x> {
    /// Its name.
    pub name: &'x str,
    /// Where the name stands.
    pub name_span: Span,
    /// Its value, references resolved.
    pub value: Cow<'x, str>,
    /// Where the value stands, without quotes.
    pub value_span: Span,
}

/// The result of [`parse`].
#[derive(Debug)]
pub struct Document<'x> {
    /// The root element; `None` where the text has none, or is not XML to its end. Attributes and
    /// elements that are mistakes are left out.
    pub root: Option<Element<'x>>,
    /// The mistakes, in the order in which they were found.
    pub mistakes: Vec<Mistake<'x>>,
}

/// A mistake in a text.
#[derive(Debug)]
pub enum Mistake<'x> {
    /// It has more bytes than [`Limits`] allow.
    TooLong,
    /// An element is nested deeper than [`Limits`] allow.
    TooDeep {
        /// Its start tag.
        tag: Span,
        /// Its name.
        name: Span,
    },
    /// An element has more attributes than [`Limits`] allow.
    TooManyAttributes {
        /// Its name.
        element: Span,
    },
    /// A second root element.
    SecondRoot {
        /// Its start tag.
        tag: Span,
        /// Its name.
        name: Span,
        /// The name of the first.
        first: Span,
    },
    /// An attribute cannot be read.
    Attribute {
        /// The name of the element.
        element: Span,
        /// Why not.
        mistake: AttributeMistake,
        /// The same in the words of the XML reader.
        why: String,
    },
    /// Text between elements.
    Text(Span),
    /// A document type.
    DocumentType(Span),
    /// An element is never closed.
    Unclosed {
        /// Its name.
        name: &'x str,
        /// Where that stands.
        span: Span,
    },
    /// There is no element.
    Empty {
        /// Where the text ends.
        end: u32,
    },
    /// An end tag does not close the element that is open.
    Mismatched {
        /// The end tag.
        tag: Span,
        /// The name of the open element.
        open: &'x str,
        /// Where that stands.
        opened: Span,
        /// The name in the end tag.
        found: String,
        /// The same in the words of the XML reader.
        why: String,
    },
    /// An end tag closes nothing.
    Unmatched {
        /// The end tag.
        tag: Span,
        /// The name in it.
        name: String,
        /// The same in the words of the XML reader.
        why: String,
    },
    /// It is not XML.
    Malformed {
        /// From where it is not, to the end of the tag or the line.
        rest: Span,
        /// The mistake, in the words of the XML reader.
        reason: String,
        /// The same, with the kind of mistake before it.
        why: String,
    },
}

/// Why an attribute cannot be read.
#[derive(Debug)]
pub enum AttributeMistake {
    /// Its name is given twice.
    GivenTwice {
        /// Where it is given again.
        again: Span,
        /// Where it was given first.
        first: Span,
    },
    /// It has no value, or one without quotes.
    NoValue {
        /// The byte at which something else was expected.
        at: u32,
        /// True if that was an equals sign, and not a quote.
        equals: bool,
    },
    /// Its value cannot be read.
    BadValue {
        /// Its name.
        name: Span,
        /// The value.
        value: Span,
        /// The reference in it that is not defined, and where its name stands, if it is that.
        undefined: Option<(String, Span)>,
    },
}

/// The document that `xml` is, as far as it is one.
pub fn parse(xml: &str, limits: Limits) -> Document<'_> {
    let mut builder = Builder {
        xml,
        limits,
        mistakes: Vec::new(),
        open: Vec::new(),
        root: None,
    };
    let root = match builder.read() {
        Some(()) => builder.root,
        None => None,
    };
    Document {
        root,
        mistakes: builder.mistakes,
    }
}

fn position(offset: u64) -> u32 {
    u32::try_from(offset).expect("texts are shorter than 4 GiB")
}

struct Builder<'x> {
    xml: &'x str,
    limits: Limits,
    mistakes: Vec<Mistake<'x>>,
    open: Vec<Element<'x>>,
    root: Option<Element<'x>>,
}

impl<'x> Builder<'x> {
    /// Reads the whole text; `None` where it has no tree.
    fn read(&mut self) -> Option<()> {
        if self.xml.len() > self.limits.bytes {
            return self.fatal(Mistake::TooLong);
        }
        let mut reader = Reader::from_str(self.xml);
        reader.config_mut().expand_empty_elements = true;
        while self.mistakes.len() < MAX_MISTAKES {
            let start = position(reader.buffer_position());
            let event = reader.read_event();
            let here = Span::new(start, position(reader.buffer_position()));
            match event {
                Ok(Event::Start(tag)) => self.start(&tag, here)?,
                Ok(Event::End(_)) => self.end(),
                Ok(Event::Eof) => return self.finish(),
                Ok(Event::Text(text)) if text.trim().is_empty() => {}
                Ok(Event::Text(text)) => {
                    let span = self.span_of(text.trim());
                    self.mistakes.push(Mistake::Text(span));
                }
                Ok(Event::CData(_) | Event::GeneralRef(_)) => {
                    self.mistakes.push(Mistake::Text(here));
                }
                Ok(Event::DocType(_)) => self.mistakes.push(Mistake::DocumentType(here)),
                Ok(Event::Decl(_) | Event::PI(_) | Event::Comment(_) | Event::Empty(_)) => {}
                Err(error) => {
                    let at = position(reader.error_position());
                    let mistake = self.malformed(&error, at);
                    return self.fatal(mistake);
                }
            }
        }
        None
    }

    /// A mistake after which there is no reading on.
    fn fatal(&mut self, mistake: Mistake<'x>) -> Option<()> {
        self.mistakes.push(mistake);
        None
    }

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

    /// A start tag, which stands at `here`.
    fn start(&mut self, tag: &BytesStart<'x>, here: Span) -> Option<()> {
        let span = self.span_of(tag.name().0);
        let name = self.slice(span);
        if self.open.len() == self.limits.depth {
            let tag = here;
            return self.fatal(Mistake::TooDeep { tag, name: span });
        }
        if let (true, Some(root)) = (self.open.is_empty(), &self.root) {
            self.mistakes.push(Mistake::SecondRoot {
                tag: here,
                name: span,
                first: root.span,
            });
        }
        let mut attributes = Vec::new();
        for (count, attribute) in tag.attributes().enumerate() {
            if count == self.limits.attributes {
                return self.fatal(Mistake::TooManyAttributes { element: span });
            }
            let attribute = match attribute {
                Ok(attribute) => attribute,
                Err(error) => {
                    self.bad_attribute(&error, span);
                    continue;
                }
            };
            let name_span = self.span_of(attribute.key.0);
            let value_span = self.span_of(&attribute.value);
            let value = match attribute.normalized_value(XmlVersion::Explicit1_0) {
                Ok(Cow::Owned(value)) => Cow::Owned(value),
                Ok(Cow::Borrowed(_)) => Cow::Borrowed(self.slice(value_span)),
                Err(error) => {
                    let mistake = AttributeMistake::BadValue {
                        name: name_span,
                        value: value_span,
                        undefined: undefined(&error, value_span),
                    };
                    self.mistakes.push(Mistake::Attribute {
                        element: span,
                        mistake,
                        why: error.to_string(),
                    });
                    continue;
                }
            };
            attributes.push(Attribute {
                name: self.slice(name_span),
                name_span,
                value,
                value_span,
            });
        }
        self.open.push(Element {
            name,
            span,
            attributes,
            children: Vec::new(),
        });
        Some(())
    }

    /// An attribute that cannot be read, in the element whose name stands at `element`.
    fn bad_attribute(&mut self, error: &AttrError, element: Span) {
        let at = |offset: usize| element.start + position(offset as u64);
        let no_value = |offset, equals| AttributeMistake::NoValue {
            at: at(offset),
            equals,
        };
        let mistake = match *error {
            AttrError::Duplicated(again, first) => {
                let name = |offset| {
                    let start = at(offset);
                    let rest = &self.xml[start as usize..];
                    let end = rest.find(|c: char| c == '=' || c.is_whitespace());
                    Span::new(start, start + position(end.unwrap_or(0) as u64))
                };
                AttributeMistake::GivenTwice {
                    again: name(again),
                    first: name(first),
                }
            }
            AttrError::ExpectedEq(offset) => no_value(offset, true),
            AttrError::ExpectedValue(offset)
            | AttrError::UnquotedValue(offset)
            | AttrError::ExpectedQuote(offset, _) => no_value(offset, false),
        };
        self.mistakes.push(Mistake::Attribute {
            element,
            mistake,
            why: error.to_string(),
        });
    }

    fn end(&mut self) {
        if let Some(element) = self.open.pop() {
            match self.open.last_mut() {
                Some(parent) => parent.children.push(element),
                None if self.root.is_none() => self.root = Some(element),
                None => {}
            }
        }
    }

    fn finish(&mut self) -> Option<()> {
        for element in self.open.iter().rev() {
            self.mistakes.push(Mistake::Unclosed {
                name: element.name,
                span: element.span,
            });
        }
        if self.open.is_empty() && self.root.is_none() {
            let end = position(self.xml.len() as u64);
            self.mistakes.push(Mistake::Empty { end });
        }
        self.open.is_empty().then_some(())
    }

    fn malformed(&self, error: &Error, at: u32) -> Mistake<'x> {
        let text = &self.xml[self.xml.floor_char_boundary(at as usize)..];
        let line = text.find('\n').unwrap_or(text.len());
        let length = text.find('>').map_or(line, |end| (end + 1).min(line));
        let rest = Span::new(at, at + position(length as u64));
        let why = error.to_string();
        match (error, self.open.last()) {
            (Error::IllFormed(IllFormedError::MismatchedEndTag { found, .. }), Some(open)) => {
                Mistake::Mismatched {
                    tag: rest,
                    open: open.name,
                    opened: open.span,
                    found: found.clone(),
                    why,
                }
            }
            (Error::IllFormed(IllFormedError::UnmatchedEndTag(name)), _) => Mistake::Unmatched {
                tag: rest,
                name: name.clone(),
                why,
            },
            (error, _) => Mistake::Malformed {
                rest,
                reason: match error {
                    Error::Syntax(error) => error.to_string(),
                    Error::IllFormed(error) => error.to_string(),
                    error => error.to_string(),
                },
                why,
            },
        }
    }
}

/// The reference in a value that is not defined, and where its name stands.
fn undefined(error: &Error, value: Span) -> Option<(String, Span)> {
    let Error::Escape(EscapeError::UnrecognizedEntity(at, name)) = error else {
        return None;
    };
    let offset = |n: usize| value.start + position(n as u64);
    Some((name.clone(), Span::new(offset(at.start), offset(at.end))))
}
