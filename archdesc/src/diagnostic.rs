//! Messages about a user's text: the mistake, its place, and advice.
//!
//! Every reader of text in the toolchain (the machine file, C) reports through [`Diagnostic`], an
//! owned value without lifetimes, so that messages can be collected, sorted and returned; only
//! [`render`] needs the text again, to show the lines a message is about.

use std::fmt;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};

/// Lines of more bytes in all are not shown with a message: laying them out takes long, and nobody
/// would read them.
const MAX_SHOWN: usize = 64 << 10;

/// A text and the name it is known by, usually its path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The name shown in messages.
    pub name: String,
    /// The text.
    pub text: String,
}

impl Source {
    /// A text with its name.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Source {
        Source {
            name: name.into(),
            text: text.into(),
        }
    }

    /// Line and column of a byte offset: see [`line_column`].
    pub fn line_column(&self, offset: u32) -> (u32, u32) {
        line_column(&self.text, offset)
    }
}

/// Line and column, both from 1 and columns counted in characters, of a byte offset into `text`.
/// An offset past the end gives the end.
pub fn line_column(text: &str, offset: u32) -> (u32, u32) {
    let before = &text[..boundary(text, offset)];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    let line = 1 + before.bytes().filter(|&b| b == b'\n').count();
    let column = 1 + before[line_start..].chars().count();
    (line as u32, column as u32)
}

/// The byte offset of a line and column, both from 1 and columns counted in characters: the inverse of
/// [`line_column`]. The end of the line, or of the text, where there are fewer.
pub fn offset(text: &str, line: u32, column: u32) -> u32 {
    let before: usize = (text.split_inclusive('\n'))
        .take(line.saturating_sub(1) as usize)
        .map(str::len)
        .sum();
    let line = text[before..].lines().next().unwrap_or_default();
    let column = column.saturating_sub(1) as usize;
    let inside = line
        .char_indices()
        .nth(column)
        .map_or(line.len(), |(at, _)| at);
    (before + inside) as u32
}

/// A range of bytes of one text.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Span {
    /// Offset of the first byte.
    pub start: u32,
    /// Offset after the last byte; equal to `start` for a point.
    pub end: u32,
}

impl Span {
    /// The bytes from `start` up to `end`.
    pub const fn new(start: u32, end: u32) -> Span {
        Span { start, end }
    }

    /// The point before the byte at `offset`.
    pub const fn point(offset: u32) -> Span {
        Span::new(offset, offset)
    }

    /// The word at a line and column of a text, in characters from 1; a point at its end where the text is shorter.
    pub fn of_word(text: &str, line: u32, column: u32) -> Span {
        let lines = text
            .split_inclusive('\n')
            .take(line.saturating_sub(1) as usize);
        let start: usize = lines.map(str::len).sum();
        let before = text[start..]
            .chars()
            .take(column.saturating_sub(1) as usize);
        let start = start + before.map(char::len_utf8).sum::<usize>();
        let word = text[start..].chars();
        let word: usize = word
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .map(char::len_utf8)
            .sum();
        Span::new(start as u32, (start + word.max(1)).min(text.len()) as u32)
    }

    /// The smallest span that covers both.
    pub fn to(self, other: Span) -> Span {
        Span::new(self.start.min(other.start), self.end.max(other.end))
    }
}

impl fmt::Debug for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.start, self.end)
    }
}

/// How serious a message is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Severity {
    /// The input cannot be used.
    Error,
    /// The input can be used, but is probably not meant so.
    Warning,
    /// Additional information.
    Note,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        })
    }
}

/// A marked place and a text about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// The place.
    pub span: Span,
    /// The text beside the mark; may be empty.
    pub text: String,
}

/// One message about one text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How serious it is.
    pub severity: Severity,
    /// Its stable code, such as `A0107`.
    pub code: &'static str,
    /// The mistake, in one line.
    pub message: String,
    /// Name of the text it is about: [`Source::name`].
    pub file: String,
    /// Where; `None` where the message is about the text as a whole.
    pub primary: Option<Label>,
    /// Other places in the same text that explain it.
    pub secondary: Vec<Label>,
    /// Further facts.
    pub notes: Vec<String>,
    /// Advice.
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error about the whole of `file`; the methods below add the rest.
    pub fn error(code: &'static str, file: &str, message: impl Into<String>) -> Diagnostic {
        Diagnostic {
            severity: Severity::Error,
            code,
            message: message.into(),
            file: file.to_owned(),
            primary: None,
            secondary: Vec::new(),
            notes: Vec::new(),
            help: None,
        }
    }

    /// A warning about the whole of `file`.
    pub fn warning(code: &'static str, file: &str, message: impl Into<String>) -> Diagnostic {
        Diagnostic {
            severity: Severity::Warning,
            ..Diagnostic::error(code, file, message)
        }
    }

    /// Says where it is.
    pub fn at(mut self, span: Span, label: impl Into<String>) -> Diagnostic {
        self.primary = Some(Label {
            span,
            text: label.into(),
        });
        self
    }

    /// Marks another place.
    pub fn also(mut self, span: Span, label: impl Into<String>) -> Diagnostic {
        self.secondary.push(Label {
            span,
            text: label.into(),
        });
        self
    }

    /// Adds a fact.
    pub fn note(mut self, text: impl Into<String>) -> Diagnostic {
        self.notes.push(text.into());
        self
    }

    /// Adds advice.
    pub fn help(mut self, text: impl Into<String>) -> Diagnostic {
        self.help = Some(text.into());
        self
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Diagnostic {
            file,
            severity,
            code,
            message,
            ..
        } = self;
        write!(f, "{file}: {severity}[{code}]: {message}")
    }
}

impl std::error::Error for Diagnostic {}

/// The message as a terminal shows it, in the manner of rustc: `file:line:column`, the lines of
/// `source` that it is about with carets, notes and help. Ends without a line break. Spans that do
/// not fit `source` are cut to it.
pub fn render(diagnostic: &Diagnostic, source: &str, colour: bool) -> String {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
        Severity::Note => Level::NOTE,
    };
    let title = level.primary_title(&diagnostic.message).id(diagnostic.code);
    let mut group = Group::with_title(title);
    group = match (snippet(diagnostic, source), &diagnostic.primary) {
        (Some(snippet), _) => group.element(snippet),
        (None, Some(primary)) => {
            let (line, column) = line_column(source, primary.span.start);
            let origin = Origin::path(&diagnostic.file).line(line as usize);
            group.element(origin.char_column(column as usize))
        }
        (None, None) => group.element(Origin::path(&diagnostic.file)),
    };
    for note in &diagnostic.notes {
        group = group.element(Level::NOTE.message(note));
    }
    if let Some(help) = &diagnostic.help {
        group = group.element(Level::HELP.message(help));
    }
    let renderer = if colour {
        Renderer::styled()
    } else {
        Renderer::plain()
    };
    renderer.render(&[group])
}

/// Messages one after another, an empty line between them, and a count of errors at the end.
pub fn render_all(diagnostics: &[Diagnostic], source: &str, colour: bool) -> String {
    let mut text = String::new();
    for diagnostic in diagnostics {
        text.push_str(&render(diagnostic, source, colour));
        text.push_str("\n\n");
    }
    text.push_str(&tally(diagnostics));
    text
}

/// Messages about several texts, with the texts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Messages {
    /// The messages, in the order in which they are shown.
    pub diagnostics: Vec<Diagnostic>,
    /// The texts that they are about. A message about another text comes without its lines.
    pub sources: Vec<Source>,
}

impl Messages {
    /// All messages as a terminal shows them, an empty line after each, and the number of errors
    /// at the end.
    pub fn render(&self, colour: bool) -> String {
        let mut text = String::new();
        for diagnostic in &self.diagnostics {
            text.push_str(&render(diagnostic, self.text(&diagnostic.file), colour));
            text.push_str("\n\n");
        }
        text + &tally(&self.diagnostics)
    }

    /// The text of this name; empty where it is not known.
    pub fn text(&self, name: &str) -> &str {
        let source = self.sources.iter().find(|s| s.name == name);
        source.map_or("", |s| s.text.as_str())
    }

    /// How many of them are errors.
    pub fn errors(&self) -> usize {
        let is_error = |d: &&Diagnostic| d.severity == Severity::Error;
        self.diagnostics.iter().filter(is_error).count()
    }
}

impl fmt::Display for Messages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for Messages {}

/// How many errors there are, as a line; nothing where there is none.
pub fn tally(diagnostics: &[Diagnostic]) -> String {
    let is_error = |d: &&Diagnostic| d.severity == Severity::Error;
    match diagnostics.iter().filter(is_error).count() {
        0 => String::new(),
        1 => "1 error\n".to_owned(),
        n => format!("{n} errors\n"),
    }
}

/// The lines that the labels are on, unless there are none or too much of them. Only these go to
/// the renderer, which would otherwise look through the whole text for each message.
fn snippet<'a>(
    diagnostic: &'a Diagnostic,
    source: &'a str,
) -> Option<Snippet<'a, annotate_snippets::Annotation<'a>>> {
    let primary = diagnostic.primary.as_ref()?;
    let labels = || {
        std::iter::once((AnnotationKind::Primary, primary)).chain(
            diagnostic
                .secondary
                .iter()
                .map(|label| (AnnotationKind::Context, label)),
        )
    };
    let ranges = || labels().map(|(_, label)| byte_range(source, label.span));
    let first = ranges().map(|r| r.start).min()?;
    let last = ranges().map(|r| r.end).max()?;
    let start = source[..first].rfind('\n').map_or(0, |newline| newline + 1);
    let end = source[last..].find('\n').map_or(source.len(), |n| last + n);
    if end - start > MAX_SHOWN {
        return None;
    }
    let mut snippet = Snippet::source(&source[start..end])
        .path(&diagnostic.file)
        .line_start(1 + source[..start].bytes().filter(|&b| b == b'\n').count());
    for ((kind, label), range) in labels().zip(ranges()) {
        let annotation = kind.span(range.start - start..range.end - start);
        snippet = snippet.annotation(match label.text.as_str() {
            "" => annotation,
            text => annotation.label(text),
        });
    }
    Some(snippet)
}

fn byte_range(text: &str, span: Span) -> Range<usize> {
    let start = boundary(text, span.start);
    start..boundary(text, span.end).max(start)
}

/// The last character boundary of `text` at or before `offset`.
fn boundary(text: &str, offset: u32) -> usize {
    text.floor_char_boundary(offset as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "<a>\n  <größe wert=\"1\"/>\n</b>\n";

    fn diagnostic(span: Span) -> Diagnostic {
        Diagnostic::error("A0001", "x.xml", "a message").at(span, "a label")
    }

    #[test]
    fn columns_count_characters() {
        let wert = TEXT.find("wert").expect("in the text") as u32;
        assert_eq!(line_column(TEXT, wert), (2, 10));
        assert_eq!(line_column(TEXT, 0), (1, 1));
        assert_eq!(line_column(TEXT, u32::MAX), (4, 1));
        assert_eq!((offset(TEXT, 2, 10), offset(TEXT, 1, 1)), (wert, 0));
        assert_eq!(offset(TEXT, 9, 9) as usize, TEXT.len());
    }

    #[test]
    fn looks_like_rustc() {
        let wert = TEXT.find("wert").expect("in the text") as u32;
        let d = diagnostic(Span::new(wert, wert + 4))
            .also(Span::new(1, 2), "opened here")
            .note("a fact")
            .help("an advice");
        let expected = "\
error[A0001]: a message
 --> x.xml:2:10
  |
1 | <a>
  |  - opened here
2 |   <größe wert=\"1\"/>
  |          ^^^^ a label
  |
  = note: a fact
  = help: an advice";
        assert_eq!(render(&d, TEXT, false), expected);
    }

    #[test]
    fn endless_lines_are_not_shown() {
        let text = "\nx".to_owned() + &"y".repeat(MAX_SHOWN);
        let shown = render(&diagnostic(Span::new(3, 4)), &text, false);
        assert_eq!(shown, "error[A0001]: a message\n--> x.xml:2:3");
    }

    #[test]
    fn any_span_renders_in_any_text() {
        for text in ["", "\n", "ä", "a\r\nb\tc\n", TEXT] {
            for start in (0..40).chain([u32::MAX]) {
                for end in (0..40).chain([u32::MAX]) {
                    let d = diagnostic(Span::new(start, end)).also(Span::point(end), "");
                    for colour in [false, true] {
                        assert!(render(&d, text, colour).contains("a message"));
                    }
                }
            }
        }
    }
}
