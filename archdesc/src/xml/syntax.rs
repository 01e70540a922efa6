//! The text of a machine file as a tree, with messages about what is no XML.

use super::findings::Findings;
use super::quote::{quoted, shortened};
use super::tree::{self, AttributeMistake, Element, Limits, Mistake};
use crate::diagnostic::{Diagnostic, Span};

/// A machine file needs five levels. The expanded form of a 64×64 array is shorter.
pub(super) const LIMITS: Limits = Limits {
    bytes: 16 << 20,
    depth: 32,
    attributes: 64,
};

/// The root element of `xml`, or `None` where the text has no tree (the reason is in `found`).
pub(super) fn parse<'x>(xml: &'x str, found: &Findings) -> Option<Element<'x>> {
    let document = tree::parse(xml, LIMITS);
    for mistake in &document.mistakes {
        if let Some((element, name)) = left_out(xml, mistake) {
            found.suspect(element, name);
        }
        found.push(message(xml, mistake, found));
    }
    document.root
}

/// The name of the attribute that a mistake leaves out, and the element that it belongs to.
fn left_out<'x>(xml: &'x str, mistake: &Mistake<'x>) -> Option<(Span, &'x str)> {
    let Mistake::Attribute {
        element, mistake, ..
    } = mistake
    else {
        return None;
    };
    let name = match mistake {
        AttributeMistake::GivenTwice { .. } => None,
        AttributeMistake::NoValue { at, .. } => {
            let before = xml.get(element.start as usize..*at as usize)?;
            let before = before.trim_end_matches(|c: char| c == '=' || c.is_whitespace());
            before.split_whitespace().next_back()
        }
        AttributeMistake::BadValue { name, .. } => xml.get(name.start as usize..name.end as usize),
    };
    Some((*element, name?))
}

/// A tag between backquotes, a very long name shortened.
fn tag(opening: &str, name: &str) -> String {
    format!("`{opening}{}>`", shortened(name))
}

fn message(xml: &str, mistake: &Mistake<'_>, found: &Findings) -> Diagnostic {
    match mistake {
        Mistake::TooLong => {
            let message = format!("the file is longer than {} MiB", LIMITS.bytes >> 20);
            found.error("A0107", Span::point(0), message, "")
        }
        Mistake::TooDeep { name, .. } => {
            let message = format!("elements are nested more than {} deep", LIMITS.depth);
            found.error("A0107", *name, message, "too deep")
        }
        Mistake::TooManyAttributes { element } => {
            let message = format!("an element has more than {} attributes", LIMITS.attributes);
            found.error("A0107", *element, message, "this one")
        }
        Mistake::SecondRoot { name, first, .. } => found
            .error("A0108", *name, "a file holds one machine", "a second one")
            .also(*first, "the first one"),
        Mistake::Text(span) => {
            let label = "elements have attributes and child elements only";
            found.error("A0105", *span, "text between elements", label)
        }
        Mistake::DocumentType(span) => {
            let message = "a machine file has no document type";
            found.error("A0101", *span, message, "not understood")
        }
        Mistake::Empty { end } => found
            .error(
                "A0108",
                Span::point(*end),
                "the file has no element",
                "the text ends here",
            )
            .help("a machine file is one `<machine name=\"…\">` element"),
        Mistake::Attribute { mistake, why, .. } => attribute(xml, mistake, why, found),
        Mistake::Unclosed { name, span } => {
            let message = format!("{} is never closed", tag("<", name));
            found.error("A0102", *span, message, "opened here")
        }
        Mistake::Mismatched {
            tag: end,
            open,
            opened,
            found: name,
            ..
        } => {
            let message = format!("{} is closed by {}", tag("<", open), tag("</", name));
            let label = format!("expected {}", tag("</", open));
            found
                .error("A0102", *end, message, label)
                .also(*opened, "opened here")
        }
        Mistake::Unmatched { tag: end, name, .. } => {
            let message = format!("{} closes nothing", tag("</", name));
            found.error("A0102", *end, message, "no such element is open")
        }
        Mistake::Malformed { rest, reason, .. } => found.error("A0101", *rest, reason.as_str(), ""),
    }
}

fn attribute(xml: &str, mistake: &AttributeMistake, why: &str, found: &Findings) -> Diagnostic {
    match mistake {
        AttributeMistake::GivenTwice { again, first } => {
            let name = &xml[again.start as usize..again.end as usize];
            let message = format!("attribute {} is given twice", quoted(name));
            found
                .error("A0104", *again, message, "given again")
                .also(*first, "first given here")
        }
        AttributeMistake::NoValue { at, equals } => {
            let (message, label) = match equals {
                true => (
                    "an attribute has no value",
                    "expected `=` and a quoted value",
                ),
                false => (
                    "the value of an attribute is not quoted",
                    "expected a value in quotes",
                ),
            };
            found.error("A0103", Span::point(*at), message, label)
        }
        AttributeMistake::BadValue {
            value, undefined, ..
        } => {
            let (span, message) = match undefined {
                Some((name, span)) => (*span, format!("the reference `&{name};` is not defined")),
                None => (*value, format!("the value cannot be read: {why}")),
            };
            found
                .error("A0106", span, message, "in this value")
                .help("write `&amp;` for an ampersand and `&lt;` for a less-than sign")
        }
    }
}
