//! Words with positions: OBJ and MTL are lines of words, `#` starts a comment, and a backslash
//! before the line break continues a line.

use std::borrow::Cow;

use srp_archdesc::diagnostic::{Diagnostic, Severity, Span};

/// Most messages kept about one file; further ones are only counted.
pub(super) const MAX_MESSAGES: usize = 20;

/// Words of a line that are kept, so that a line as long as a file takes no memory: more than any
/// statement has.
const MAX_WORDS: usize = 2048;

/// A text with continued lines joined: the same bytes at the same offsets, backslash and line
/// break replaced by blanks.
pub(super) fn join_continued(text: &str) -> Cow<'_, str> {
    let is_continued = |end: &str| text.contains(end);
    match is_continued("\\\n") || is_continued("\\\r\n") {
        true => Cow::Owned(text.replace("\\\r\n", "   ").replace("\\\n", "  ")),
        false => Cow::Borrowed(text),
    }
}

/// One line that says something.
pub(super) struct Line<'a> {
    /// Its first word.
    pub(super) key: Word<'a>,
    /// The others, no more than [`MAX_WORDS`].
    pub(super) words: Vec<Word<'a>>,
    /// The rest of the line after the first word, without the blanks round it.
    pub(super) rest: Word<'a>,
}

/// A piece of text and where it stands.
#[derive(Clone, Copy)]
pub(super) struct Word<'a> {
    pub(super) text: &'a str,
    pub(super) start: usize,
}

impl Word<'_> {
    pub(super) fn span(&self) -> Span {
        Span::new(self.start as u32, (self.start + self.text.len()) as u32)
    }
}

impl Line<'_> {
    /// The whole line, without comment and surrounding blanks.
    pub(super) fn span(&self) -> Span {
        self.key.span().to(self.rest.span())
    }
}

/// The lines of `text`, which [`join_continued`] has been through, but for empty ones and
/// comments.
pub(super) fn lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    let mut start = 0;
    text.split_inclusive('\n').filter_map(move |line| {
        let at = start;
        start += line.len();
        let line = line.split('#').next().unwrap_or_default();
        let word = |text: &'_ str, offset: usize| (offset, text.len());
        let key = line.split_whitespace().next()?;
        let (key_at, key_len) = word(key, offset_in(line, key));
        let rest = line[key_at + key_len..].trim();
        let rest_at = if rest.is_empty() {
            key_at + key_len
        } else {
            offset_in(line, rest)
        };
        Some(Line {
            key: Word {
                text: &line[key_at..key_at + key_len],
                start: at + key_at,
            },
            words: rest
                .split_whitespace()
                .take(MAX_WORDS)
                .map(|w| Word {
                    text: w,
                    start: at + offset_in(line, w),
                })
                .collect(),
            rest: Word {
                text: rest,
                start: at + rest_at,
            },
        })
    })
}

/// Where `part`, a slice of `whole`, starts in it.
fn offset_in(whole: &str, part: &str) -> usize {
    part.as_ptr() as usize - whole.as_ptr() as usize
}

/// Messages about one file, at most [`MAX_MESSAGES`] of them.
pub(super) struct Findings {
    pub(super) messages: Vec<Diagnostic>,
    pub(super) errors: usize,
    unsaid: usize,
}

impl Findings {
    pub(super) fn new() -> Findings {
        Findings {
            messages: Vec::new(),
            errors: 0,
            unsaid: 0,
        }
    }

    pub(super) fn push(&mut self, message: Diagnostic) {
        if message.severity == Severity::Error {
            self.errors += 1;
        }
        if self.messages.len() < MAX_MESSAGES {
            self.messages.push(message);
        } else {
            self.unsaid += 1;
        }
    }

    /// The messages, with a word about those left out.
    pub(super) fn finish(mut self, file: &str) -> Vec<Diagnostic> {
        if self.unsaid > 0 {
            let mut rest = Diagnostic::warning(
                "R0001",
                file,
                format!("{} more messages about this file are left out", self.unsaid),
            );
            rest.severity = Severity::Note;
            self.messages.push(rest);
        }
        self.messages
    }
}

/// Reads a finite number, or returns the mistake.
pub(super) fn number(word: &str) -> Result<f32, String> {
    let value: f32 = word
        .parse()
        .map_err(|_| format!("`{word}` is not a number"))?;
    if value.is_nan() {
        return Err("not a number (NaN)".to_owned());
    }
    if value.is_infinite() {
        return Err(format!("`{word}` is infinite in 32 bits"));
    }
    Ok(value)
}

/// `1 number`, `2 numbers`.
pub(super) fn numbers(count: usize) -> String {
    match count {
        1 => "1 number".to_owned(),
        n => format!("{n} numbers"),
    }
}
