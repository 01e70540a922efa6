//! [`SourceMap`]: all texts of one compilation in one space of offsets, so that a [`Span`] alone
//! says which file and where.

use crate::message::Code;
use srp_archdesc::diagnostic::{Diagnostic, Severity, Source, Span};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_ir::program::{Pos, SourceFile};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// Bytes that all texts of a compilation may have together.
pub const MAX_SOURCE_BYTES: usize = 1 << 28;

/// An identifier or other spelling, shared.
pub type Name = Rc<str>;

/// One text and where its offsets start.
#[derive(Debug)]
struct File {
    source: Source,
    base: u32,
    /// Offset within the text of the start of each line.
    lines: Vec<u32>,
    /// Offsets of the bytes that go on with a character.
    inner: Vec<u32>,
}

/// A macro call: the macro's name and the place of its definition.
#[derive(Debug)]
struct Expansion {
    name: Name,
    defined: Span,
}

/// All texts of a compilation. A span of the front end counts from the start of the first text
/// through all of them in the order of their addition.
#[derive(Debug, Default)]
pub struct SourceMap {
    files: EntityMap<SourceFile, File>,
    expansions: BTreeMap<Span, Expansion>,
    /// The ranges that `#pragma srp range` has stated, in the order of the text.
    pub(crate) ranges: Vec<Range>,
    /// The macros that the program defines.
    pub(crate) macros: BTreeSet<Name>,
}

/// The range that a `#pragma srp range(name, low, high)` states.
#[derive(Clone, Debug)]
pub(crate) struct Range {
    pub(crate) name: String,
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) span: Span,
}

impl SourceMap {
    /// A map without texts.
    pub fn new() -> SourceMap {
        SourceMap::default()
    }

    /// Adds a text, or finds the equal one of the same name. `None` where there is no room.
    pub fn add(&mut self, source: Source) -> Option<SourceFile> {
        let known = self.files.iter().find(|(_, f)| f.source == source);
        if let Some((file, _)) = known {
            return Some(file);
        }
        let base = self.files.values().last().map_or(0, File::end);
        if base as usize + source.text.len() >= MAX_SOURCE_BYTES {
            return None;
        }
        let newlines = source.text.bytes().enumerate().filter(|(_, b)| *b == b'\n');
        let starts = newlines.map(|(at, _)| at as u32 + 1);
        let lines = std::iter::once(0).chain(starts).collect();
        let bytes = source.text.bytes().enumerate();
        let inner = bytes.filter(|(_, b)| b & 0xc0 == 0x80);
        let inner = inner.map(|(at, _)| at as u32).collect();
        Some(self.files.push(File {
            source,
            base,
            lines,
            inner,
        }))
    }

    /// The text of a file.
    pub fn text(&self, file: SourceFile) -> &str {
        &self.files[file].source.text
    }

    /// The text of a span; empty where it is in no file.
    pub(crate) fn spelled(&self, span: Span) -> &str {
        let Some(file) = self.file(span) else {
            return "";
        };
        let (_, local) = self.local(span);
        let text = &self.files[file].source.text;
        text.get(local.start as usize..local.end as usize)
            .unwrap_or("")
    }

    /// The text of a span's file before and after it.
    pub(crate) fn around(&self, span: Span) -> (&str, &str) {
        let Some(file) = self.file(span) else {
            return ("", "");
        };
        let (_, local) = self.local(span);
        let text = &self.files[file].source.text;
        let part = |from: usize, to: usize| text.get(from..to).unwrap_or("");
        (
            part(0, local.start as usize),
            part(local.end as usize, text.len()),
        )
    }

    /// True if a span begins with what a macro was expanded to.
    pub(crate) fn is_expansion(&self, span: Span) -> bool {
        let mut from = self.expansions.range(Span::point(span.start)..);
        from.next().is_some_and(|(at, _)| at.start == span.start)
    }

    /// The name of a file.
    pub fn name(&self, file: SourceFile) -> &str {
        &self.files[file].source.name
    }

    /// True if a place lies in a file of the library.
    pub(crate) fn is_library(&self, span: Span) -> bool {
        let file = self.file(span);
        file.is_some_and(|file| srp_kernels::libc::at(self.name(file)).is_some())
    }

    /// The names of all files, in order: what [`Program::files`](srp_ir::Program::files) wants.
    /// Different texts of one name get numbers.
    pub fn names(&self) -> EntityMap<SourceFile, String> {
        let mut taken = BTreeSet::new();
        let names = self.files.values().map(|file| {
            let mut name = file.source.name.clone();
            let mut number = 1;
            while !taken.insert(name.clone()) {
                number += 1;
                name = format!("{} ({number})", file.source.name);
            }
            name
        });
        names.collect()
    }

    /// The offset of the first byte of a file.
    pub fn base(&self, file: SourceFile) -> u32 {
        self.files[file].base
    }

    /// The file that a span starts in.
    pub fn file(&self, span: Span) -> Option<SourceFile> {
        let files = self.files.values().as_slice();
        let after = files.partition_point(|f| f.base <= span.start);
        after.checked_sub(1).map(SourceFile::new)
    }

    /// Line and column of the start of a span.
    pub fn pos(&self, span: Span) -> Pos {
        let Some(file) = self.file(span) else {
            return Pos::nowhere();
        };
        let data = &self.files[file];
        let text = &data.source.text;
        let at = text.floor_char_boundary((span.start - data.base) as usize);
        let line = data.lines.partition_point(|&start| start as usize <= at);
        let start = data.lines[line - 1];
        let at = at as u32;
        let inner = |end: u32| data.inner.partition_point(|&byte| byte < end) as u32;
        Pos {
            file,
            line: line as u32,
            column: 1 + (at - start) - (inner(at) - inner(start)),
        }
    }

    /// `file:line:column` of the start of a span.
    pub fn show(&self, span: Span) -> String {
        let Pos { file, line, column } = self.pos(span);
        match self.files.get(file) {
            Some(data) => format!("{}:{line}:{column}", data.source.name),
            None => "-".to_owned(),
        }
    }

    /// Notes that the tokens with this span come from a macro.
    pub(crate) fn expanded(&mut self, span: Span, name: &Name, defined: Span) {
        self.expansions.entry(span).or_insert_with(|| Expansion {
            name: name.clone(),
            defined,
        });
    }

    /// A message of this severity about a span, with a note where the span is a macro call.
    pub fn message(
        &self,
        severity: Severity,
        code: Code,
        span: Span,
        text: impl Into<String>,
        label: impl Into<String>,
    ) -> Diagnostic {
        let (file, local) = self.local(span);
        let mut message = Diagnostic::error(code.0, file, text).at(local, label);
        message.severity = severity;
        let first = self.expansions.range(Span::point(span.start)..).next();
        match first {
            Some((at, macro_)) if at.start == span.start => {
                let place = self.show(macro_.defined);
                message.note(format!("`{}` is a macro, defined at {place}", macro_.name))
            }
            _ => message,
        }
    }

    /// An error about a span.
    pub fn error(
        &self,
        code: Code,
        span: Span,
        text: impl Into<String>,
        label: impl Into<String>,
    ) -> Diagnostic {
        self.message(Severity::Error, code, span, text, label)
    }

    /// A warning about a span.
    pub fn warning(
        &self,
        code: Code,
        span: Span,
        text: impl Into<String>,
        label: impl Into<String>,
    ) -> Diagnostic {
        self.message(Severity::Warning, code, span, text, label)
    }

    /// A fact about a place.
    pub fn note(&self, code: Code, span: Span, text: impl Into<String>) -> Diagnostic {
        self.message(Severity::Note, code, span, text, "")
    }

    /// Adds another place to a message: a mark where it is in the same file, else a note.
    pub fn also(&self, message: Diagnostic, span: Span, label: &str) -> Diagnostic {
        let (file, local) = self.local(span);
        if file == message.file {
            message.also(local, label)
        } else {
            let place = self.show(span);
            message.note(format!("{label}: {place}"))
        }
    }

    /// The file of a span and the span within its text.
    fn local(&self, span: Span) -> (&str, Span) {
        let Some(file) = self.file(span) else {
            return ("", span);
        };
        let data = &self.files[file];
        let start = span.start - data.base;
        let end = match span.end {
            end if end >= span.start && end <= data.end() => end - data.base,
            _ => start,
        };
        (&data.source.name, Span::new(start, end))
    }
}

impl File {
    /// The offset after the text's last byte and one more, so that no two files touch.
    fn end(&self) -> u32 {
        self.base + self.source.text.len() as u32 + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_name_their_file() {
        let mut map = SourceMap::new();
        let a = map.add(Source::new("a.c", "int\nä x;")).expect("room");
        let b = map.add(Source::new("b.c", "y")).expect("room");
        assert_eq!(map.add(Source::new("a.c", "int\nä x;")), Some(a));
        let x = map.text(a).find('x').expect("in the text") as u32;
        assert_eq!(map.show(Span::point(x)), "a.c:2:3");
        assert_eq!(map.show(Span::point(map.base(b))), "b.c:1:1");
        // Offsets past the end do not fail.
        assert_eq!(map.show(Span::point(u32::MAX)), "b.c:1:2");
    }
}
