//! The preprocessor: directives here, macro expansion in [`expand`], `#if` in [`condition`].
//!
//! A token from a macro body takes the span of the macro call, so that every message points at
//! text that the user wrote where the trouble is.

mod condition;
mod directive;
mod expand;

use crate::lex::{Interner, PpKind, PpToken, lex, lex_fragment};
use crate::library;
use crate::message::{Code, DIRECTIVE, INCLUDE, LIMIT, Messages};
use crate::source::{Name, SourceMap};
use crate::{Include, Options};
use expand::Macro;
use srp_archdesc::diagnostic::{Source, Span};
use srp_ir::program::SourceFile;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

/// Depth of includes.
pub(crate) const MAX_INCLUDES: usize = 100;

/// Tokens that one source file may come to, headers and macros expanded.
pub(crate) const MAX_TOKENS: usize = 4_000_000;

/// Macros that are always defined.
const PREDEFINED: &[(&str, &str)] = &[
    ("__SRP__", "1"),
    ("__STDC__", "1"),
    ("__STDC_HOSTED__", "1"),
    ("__STDC_VERSION__", "201112L"),
    ("__STDC_NO_ATOMICS__", "1"),
    ("__STDC_NO_COMPLEX__", "1"),
    ("__STDC_NO_THREADS__", "1"),
    ("__STDC_NO_VLA__", "1"),
    ("__CHAR_BIT__", "8"),
    ("__SCHAR_MAX__", "127"),
    ("__SHRT_MAX__", "32767"),
    ("__INT_MAX__", "2147483647"),
    ("__LONG_MAX__", "2147483647L"),
    ("__LONG_LONG_MAX__", "9223372036854775807LL"),
    ("__SIZEOF_SHORT__", "2"),
    ("__SIZEOF_INT__", "4"),
    ("__SIZEOF_LONG__", "4"),
    ("__SIZEOF_LONG_LONG__", "8"),
    ("__SIZEOF_POINTER__", "4"),
    ("__SIZEOF_FLOAT__", "4"),
    ("__SIZEOF_DOUBLE__", "8"),
    ("__SIZEOF_SIZE_T__", "4"),
    ("__SIZE_TYPE__", "unsigned long"),
    ("__PTRDIFF_TYPE__", "long"),
    ("__WCHAR_TYPE__", "int"),
    ("__INTPTR_TYPE__", "long"),
    ("__UINTPTR_TYPE__", "unsigned long"),
    ("__INT32_TYPE__", "int"),
    ("__UINT32_TYPE__", "unsigned"),
    ("__INT64_TYPE__", "long long"),
    ("__UINT64_TYPE__", "unsigned long long"),
    ("__ORDER_LITTLE_ENDIAN__", "1234"),
    ("__ORDER_BIG_ENDIAN__", "4321"),
    ("__BYTE_ORDER__", "__ORDER_LITTLE_ENDIAN__"),
    ("__FLT_EPSILON__", "0x1p-23f"),
    ("__FLT_MAX__", "0x1.fffffep127f"),
    ("__DBL_EPSILON__", "0x1p-52"),
    ("__DBL_MAX__", "0x1.fffffffffffffp1023"),
    ("__DATE__", "\"Jan  1 1970\""),
    ("__TIME__", "\"00:00:00\""),
];

/// State while one source file is preprocessed.
struct Preprocessor<'a> {
    sources: &'a mut SourceMap,
    messages: &'a mut Messages,
    resolve: &'a dyn Fn(&Include<'_>) -> Option<Source>,
    names: Interner,
    macros: HashMap<Name, Rc<Macro>>,
    once: HashSet<SourceFile>,
    /// Conditional sections around the current line, innermost last.
    sections: Vec<Section>,
    depth: usize,
    /// What `__COUNTER__` is next.
    counter: u32,
    /// Tokens that may still be produced.
    budget: usize,
    out: Vec<PpToken>,
}

/// One `#if … #endif`.
struct Section {
    start: Span,
    /// Lines here are taken.
    active: bool,
    /// A branch was taken already, or none may be.
    done: bool,
    /// `#else` was seen.
    last: bool,
}

/// The tokens of a source file after preprocessing. Included files are added to `sources`.
pub(crate) fn preprocess(
    file: SourceFile,
    options: &Options<'_>,
    sources: &mut SourceMap,
    messages: &mut Messages,
) -> Vec<PpToken> {
    let mut preprocessor = Preprocessor {
        sources,
        messages,
        resolve: options.resolve,
        names: Interner::default(),
        macros: HashMap::new(),
        once: HashSet::new(),
        sections: Vec::new(),
        depth: 0,
        counter: 0,
        budget: MAX_TOKENS,
        out: Vec::new(),
    };
    let nowhere = Span::point(preprocessor.sources.base(file));
    for &(name, body) in PREDEFINED {
        preprocessor.predefine(name, body, nowhere);
    }
    for (name, body) in &options.defines {
        preprocessor.predefine(name, body, nowhere);
    }
    preprocessor.file(file);
    if preprocessor.budget == 0 {
        // What is left of a text cut somewhere would only be mistaken for more mistakes.
        return Vec::new();
    }
    preprocessor.out
}

impl Preprocessor<'_> {
    fn predefine(&mut self, name: &str, body: &str, span: Span) {
        let body = lex_fragment(body, span, &mut self.names);
        let name = self.names.name(name);
        let defined = Macro::object(body, span);
        self.macros.insert(name, Rc::new(defined));
    }

    fn error(&mut self, code: Code, span: Span, text: impl Into<String>, label: &str) {
        let message = self.sources.error(code, span, text, label);
        self.messages.push(message);
    }

    /// Takes from the budget; `false` where it is used up, which is said once.
    fn spend(&mut self, tokens: usize, span: Span) -> bool {
        if self.budget == 0 {
            return false;
        }
        self.budget = self.budget.saturating_sub(tokens);
        if self.budget == 0 {
            let text = format!("the source comes to more than {MAX_TOKENS} tokens");
            self.error(LIMIT, span, text, "here");
        }
        self.budget > 0
    }

    fn active(&self) -> bool {
        self.sections.last().is_none_or(|s| s.active)
    }

    /// Appends the tokens of a file to the output.
    fn file(&mut self, file: SourceFile) {
        let tokens = lex(self.sources, file, &mut self.names, self.messages);
        if let Some(first) = tokens.first() {
            self.spend(tokens.len(), first.span);
        }
        let outer = self.sections.len();
        let mut text = Vec::new();
        let mut rest = tokens.into_iter().peekable();
        while let Some(token) = rest.next() {
            if token.first && token.is("#") {
                self.flush(&mut text);
                let mut line = Vec::new();
                while let Some(next) = rest.next_if(|t| !t.first) {
                    line.push(next);
                }
                self.directive(file, token.span, line);
            } else if self.active() {
                text.push(token);
            }
        }
        self.flush(&mut text);
        for section in self.sections.split_off(outer) {
            self.error(
                DIRECTIVE,
                section.start,
                "conditional without `#endif`",
                "starts here",
            );
        }
    }

    /// Expands the text collected so far.
    fn flush(&mut self, text: &mut Vec<PpToken>) {
        if text.is_empty() {
            return;
        }
        let mut expanded = self.expand(std::mem::take(text)).into_iter();
        while let Some(token) = expanded.next() {
            match expanded.as_slice() {
                [open, text, close, ..]
                    if token.is_word("_Pragma")
                        && open.is("(")
                        && text.kind == PpKind::Str
                        && close.is(")") =>
                {
                    let line = lex_fragment(&unquoted(&text.text), text.span, &mut self.names);
                    let span = token.span;
                    expanded.nth(2);
                    if let Some(file) = self.sources.file(span) {
                        self.pragma(file, span, &line);
                    }
                }
                _ => self.out.push(token),
            }
        }
    }

    fn include(&mut self, from: SourceFile, span: Span, name: &str, system: bool) {
        if self.depth >= MAX_INCLUDES {
            let text = format!("includes nest deeper than {MAX_INCLUDES} files");
            self.error(LIMIT, span, text, "");
            return;
        }
        if self.budget == 0 {
            return;
        }
        let from = self.sources.name(from).to_owned();
        let include = Include {
            name,
            from: &from,
            system,
        };
        let resolve = |include: &Include<'_>| {
            (self.resolve)(include).or_else(|| library::header(include.name))
        };
        match self.sources.include(&include, &resolve) {
            None => {
                let text = format!("file `{name}` was not found");
                let message = self
                    .sources
                    .error(INCLUDE, span, text, "")
                    .help("includes are looked up beside the file and in the kernel directory");
                self.messages.push(message);
            }
            Some(None) => self.error(LIMIT, span, "the sources are too large", ""),
            Some(Some(file)) if self.once.contains(&file) => {}
            Some(Some(file)) => {
                self.depth += 1;
                self.file(file);
                self.depth -= 1;
            }
        }
    }
}

/// The text that a string literal stands for in `_Pragma`.
fn unquoted(literal: &str) -> String {
    let start = literal.find('"').map_or(0, |at| at + 1);
    let end = literal.len().saturating_sub(1).max(start);
    literal[start..end]
        .replace("\\\"", "\"")
        .replace("\\\\", "\\")
}

/// The spelling of tokens, a space where white space stood.
fn spell(tokens: &[PpToken]) -> String {
    let mut text = String::new();
    for (i, token) in tokens.iter().enumerate() {
        if i > 0 && (token.space || token.first) {
            text.push(' ');
        }
        text.push_str(&token.text);
    }
    text
}
