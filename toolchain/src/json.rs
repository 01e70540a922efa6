//! JSON that a user names.

use crate::Error;
use serde::Deserialize;
use srp_archdesc::diagnostic::{Diagnostic, Messages, Source, Span, offset};

/// A document from its text.
///
/// # Errors
///
/// The text is no JSON, or not of this document: with the place.
pub fn read<'t, T: Deserialize<'t>>(source: &'t Source) -> Result<T, Error> {
    serde_json::from_str(&source.text).map_err(|e| wrong(source, 0, &e))
}

/// The error of a part of a text that begins at this byte.
pub(crate) fn wrong(source: &Source, start: usize, error: &serde_json::Error) -> Error {
    wrong_with(source, start, error, &[])
}

/// The same with advice.
pub(crate) fn wrong_with(
    source: &Source,
    start: usize,
    error: &serde_json::Error,
    help: &[String],
) -> Error {
    let part = &source.text[start..];
    // The reader counts columns in bytes, and those of the last line from its start.
    let line = error.line() as u32;
    let begins = match line {
        0 => part.len(),
        line => offset(part, line, 1) as usize,
    };
    let at = start + (begins + error.column().saturating_sub(1)).min(part.len());
    let text = error.to_string();
    let why = text.split(" at line ").next().unwrap_or(&text);
    advise(source, Span::point(at as u32), why, help)
}

/// A mistake at a place of a text.
pub(crate) fn at_byte(source: &Source, span: Span, why: &str) -> Error {
    advise(source, span, why, &[])
}

/// The same with advice.
pub(crate) fn advise(source: &Source, span: Span, why: &str, help: &[String]) -> Error {
    let mut mistake = Diagnostic::error("J0001", &source.name, why).at(span, "");
    if !help.is_empty() {
        mistake = mistake.help(help.join("; "));
    }
    Error::Messages(Messages {
        diagnostics: vec![mistake],
        sources: vec![source.clone()],
    })
}
