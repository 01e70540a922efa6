//! Attribute values: texts to numbers, flags, words and names. Each function reports what is wrong
//! with a value and then gives the default, so that reading can go on.

use std::fmt::Display;
use std::num::IntErrorKind;

use super::findings::Findings;
use super::limits::{Limit, MAX_NAME};
use super::quote::quoted;
use super::raw::Text;
use crate::diagnostic::Span;
use crate::nearest::nearest;

/// A value, unless it is not given or was reported before.
fn given<'t>(found: &Findings, text: &'t Option<Text>) -> Option<&'t Text> {
    text.as_ref().filter(|text| !found.is_void(text.span))
}

/// A number within `limit`, or `default` where it is not given.
pub(super) fn number(found: &Findings, text: &Option<Text>, limit: Limit, default: u32) -> u32 {
    let Some(text) = given(found, text) else {
        return default;
    };
    let Limit { name, min, max, .. } = limit;
    match integer(text, limit.bytes) {
        Some(n) if (u64::from(min)..=u64::from(max)).contains(&n) => n as u32,
        Some(n) => {
            let message = format!(
                "`{name}` is from {} to {}",
                show(min, limit),
                show(max, limit)
            );
            let label = if n < u64::from(min) {
                "too small"
            } else {
                "too large"
            };
            found.push(found.error("A0302", text.span, message, label));
            default
        }
        None => {
            let negative = text.value.strip_prefix('-');
            if negative.is_some_and(|digits| digits.parse::<u64>().is_ok()) {
                let message = format!(
                    "`{name}` is from {} to {}",
                    show(min, limit),
                    show(max, limit)
                );
                found.push(found.error("A0302", text.span, message, "too small"));
                return default;
            }
            let message = format!("`{name}` is a number, not {}", quoted(text));
            let mut diagnostic = found.error("A0301", text.span, message, "not a whole number");
            if limit.bytes {
                diagnostic = diagnostic.help("a size is a number of bytes, or like `64K`, `2M`");
            }
            found.push(diagnostic);
            default
        }
    }
}

/// A number that must be a power of two.
pub(super) fn power(found: &Findings, text: &Option<Text>, limit: Limit, default: u32) -> u32 {
    let n = number(found, text, limit, default);
    if let Some(text) = text
        && !n.is_power_of_two()
    {
        let message = format!("`{}` is not a power of two", limit.name);
        let below = 1 << n.ilog2();
        found.push(
            found
                .error("A0602", text.span, message, "not a power of two")
                .help(format!("the nearest are {below} and {}", below * 2)),
        );
        return default;
    }
    n
}

/// A number that has no default; reported as missing from the element called `element` at `at`.
pub(super) fn required_number(
    found: &Findings,
    text: &Option<Text>,
    limit: Limit,
    element: &str,
    at: Span,
) -> u32 {
    if text.is_none() {
        missing(found, limit.name, element, at);
    }
    number(found, text, limit, limit.min)
}

/// Decimal or `0x` hexadecimal; for sizes also with `K` or `M` behind. Numbers beyond 64 bits give
/// the largest.
fn integer(text: &str, bytes: bool) -> Option<u64> {
    let (digits, unit) = match text.as_bytes().last() {
        Some(b'K') if bytes => (&text[..text.len() - 1], 1 << 10),
        Some(b'M') if bytes => (&text[..text.len() - 1], 1 << 20),
        _ => (text, 1),
    };
    let (digits, radix) = match digits.strip_prefix("0x") {
        Some(digits) => (digits, 16),
        None => (digits, 10),
    };
    if !digits.starts_with(|c: char| c.is_ascii_hexdigit()) {
        return None;
    }
    match u64::from_str_radix(digits, radix) {
        Ok(n) => Some(n.saturating_mul(unit)),
        Err(error) if *error.kind() == IntErrorKind::PosOverflow => Some(u64::MAX),
        Err(_) => None,
    }
}

fn show(n: u32, limit: Limit) -> String {
    match n {
        n if limit.bytes && n >= 1 << 20 && n % (1 << 20) == 0 => format!("{}M", n >> 20),
        n if limit.bytes && n >= 1 << 10 && n % (1 << 10) == 0 => format!("{}K", n >> 10),
        n => n.to_string(),
    }
}

/// `true` or `false`, or `default` where it is not given.
pub(super) fn flag(found: &Findings, text: &Option<Text>, name: &str, default: bool) -> bool {
    word(found, text, name, &[("true", true), ("false", false)]).unwrap_or(default)
}

/// One of a few words; `None` where it is not given or not one of them.
pub(super) fn word<T: Copy>(
    found: &Findings,
    text: &Option<Text>,
    name: &str,
    choices: &[(&str, T)],
) -> Option<T> {
    let text = given(found, text)?;
    let choice = choices.iter().find(|(word, _)| *word == text.value);
    if choice.is_none() {
        let words = choices.iter().map(|(word, _)| *word);
        let message = format!("`{name}` cannot be {}", quoted(text));
        let help = match nearest(text, words.clone()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("it is one of {}", list(words)),
        };
        found.push(
            found
                .error("A0303", text.span, message, "not one of its values")
                .help(help),
        );
        found.suspect(text.span, name);
    }
    choice.map(|&(_, value)| value)
}

/// A width in bits; `None` where it is not given or not one of those.
pub(super) fn width(
    found: &Findings,
    text: &Option<Text>,
    name: &str,
    choices: &[u32],
) -> Option<u32> {
    let words: Vec<String> = choices.iter().map(u32::to_string).collect();
    let choices: Vec<(&str, u32)> = words
        .iter()
        .map(String::as_str)
        .zip(choices.iter().copied())
        .collect();
    word(found, text, name, &choices)
}

/// A name that can stand in generated code: a letter or `_`, then letters, digits and `_`.
pub(super) fn identifier(found: &Findings, text: &Text) -> Option<String> {
    let starts = |c: char| c.is_ascii_alphabetic() || c == '_';
    let goes_on = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if found.is_void(text.span) {
        return None;
    }
    if text.len() <= MAX_NAME && text.starts_with(starts) && text.chars().all(goes_on) {
        return Some(text.value.clone());
    }
    let message = format!("{} is not a name", quoted(text));
    found.push(
        found
            .error("A0304", text.span, message, "not a name")
            .help(format!(
                "a name is a letter or `_`, then letters, digits and `_`, at most {MAX_NAME} in all"
            )),
    );
    None
}

/// The identifier of an element that must have one in its attribute `name`.
pub(super) fn required_identifier(
    found: &Findings,
    text: &Option<Text>,
    element: &str,
    at: Span,
) -> Option<String> {
    match text {
        Some(text) => identifier(found, text),
        None => {
            missing(found, "name", element, at);
            None
        }
    }
}

/// Reports that an element lacks an attribute.
pub(super) fn missing(found: &Findings, attribute: &str, element: &str, at: Span) {
    if found.is_full() || found.suspects(at, attribute) {
        // A misspelt or misplaced one was reported.
        return;
    }
    let message = format!("`{element}` needs the attribute `{attribute}`");
    found.push(found.error("A0205", at, message, format!("has no `{attribute}`")));
    // What follows from its absence would only be said again.
    found.suspect(at, attribute);
}

/// The words of a list with their places.
pub(super) fn words(text: &Text) -> impl Iterator<Item = Text> {
    let start_of_value = text.span.start;
    // References (`&amp;`) make the text shorter than its place in the file; mark it all then.
    let exact = text.span.end - text.span.start == text.value.len() as u32;
    text.value.split_ascii_whitespace().map(move |word| {
        let offset = (word.as_ptr() as usize - text.value.as_ptr() as usize) as u32;
        let start = start_of_value + offset;
        let span = if exact {
            Span::new(start, start + word.len() as u32)
        } else {
            text.span
        };
        Text {
            value: word.to_owned(),
            span,
        }
    })
}

/// Names in a sentence: `a`, `b` or `c`.
pub(super) fn list<T: Display>(names: impl IntoIterator<Item = T>) -> String {
    let names: Vec<String> = names.into_iter().map(|n| format!("`{n}`")).collect();
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        Some((last, _)) => last.clone(),
        None => "none".to_owned(),
    }
}

/// Reports a name that nothing has, with the nearest one that something has.
pub(super) fn unknown<'n>(
    found: &Findings,
    code: &'static str,
    text: &Text,
    what: &str,
    known: impl IntoIterator<Item = &'n str>,
) {
    if found.is_full() {
        return;
    }
    let known: Vec<&str> = known.into_iter().collect();
    let message = format!("there is no {what} {}", quoted(text));
    let diagnostic = found.error(code, text.span, message, format!("unknown {what}"));
    const SHOWN: usize = 30;
    found.push(match nearest(text, known.iter().copied()) {
        Some(near) => diagnostic.help(format!("did you mean `{near}`?")),
        None if known.is_empty() => diagnostic.help(format!("the file has no {what}")),
        None if known.len() <= SHOWN => {
            diagnostic.help(format!("the known ones are {}", known.join(", ")))
        }
        None => diagnostic,
    });
}
