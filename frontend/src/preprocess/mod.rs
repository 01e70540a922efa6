//! The preprocessor: directives here, macro expansion in [`expand`], `#if` in [`condition`].
//!
//! A token from a macro body takes the span of the macro call, so that every message points at
//! text that the user wrote where the trouble is.

mod condition;
mod directive;
mod expand;

use crate::lex::{Interner, PpKind, PpToken, lex, lex_fragment};
use crate::library;
use crate::message::{Code, DIRECTIVE, INCLUDE, LIMIT, Messages, OUTSIDE};
use crate::options::{Include, Included, Options};
use crate::source::{Name, SourceMap};
use expand::Macro;
use srp_archdesc::diagnostic::Span;
use srp_ir::program::SourceFile;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

/// Depth of includes.
pub(crate) const MAX_INCLUDES: usize = 100;

/// Tokens that one source file may come to, headers and macros expanded.
pub(crate) const MAX_TOKENS: usize = 4_000_000;

/// Bytes of a file that count as a token at least.
const BYTES_OF_TOKEN: usize = 64;

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
    ("__ILP32__", "1"),
    ("_ILP32", "1"),
    ("__CHAR_BIT__", "8"),
    ("__SCHAR_MAX__", "127"),
    ("__SHRT_MAX__", "32767"),
    ("__INT_MAX__", "2147483647"),
    ("__LONG_MAX__", "2147483647L"),
    ("__LONG_LONG_MAX__", "9223372036854775807LL"),
    ("__INT8_MAX__", "127"),
    ("__INT16_MAX__", "32767"),
    ("__INT32_MAX__", "2147483647"),
    ("__INT64_MAX__", "9223372036854775807LL"),
    ("__UINT8_MAX__", "255"),
    ("__UINT16_MAX__", "65535"),
    ("__UINT32_MAX__", "4294967295U"),
    ("__UINT64_MAX__", "18446744073709551615ULL"),
    ("__INTMAX_MAX__", "9223372036854775807LL"),
    ("__UINTMAX_MAX__", "18446744073709551615ULL"),
    ("__INTPTR_MAX__", "2147483647L"),
    ("__UINTPTR_MAX__", "4294967295UL"),
    ("__PTRDIFF_MAX__", "2147483647L"),
    ("__SIZE_MAX__", "4294967295UL"),
    ("__WCHAR_MAX__", "2147483647"),
    ("__WCHAR_MIN__", "(-2147483647 - 1)"),
    ("__SCHAR_WIDTH__", "8"),
    ("__SHRT_WIDTH__", "16"),
    ("__INT_WIDTH__", "32"),
    ("__LONG_WIDTH__", "32"),
    ("__LONG_LONG_WIDTH__", "64"),
    ("__SIZEOF_LONG_DOUBLE__", "8"),
    ("__SIZEOF_PTRDIFF_T__", "4"),
    ("__SIZEOF_WCHAR_T__", "4"),
    ("__SIZEOF_WINT_T__", "4"),
    ("__BIGGEST_ALIGNMENT__", "16"),
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
    ("__INT8_TYPE__", "signed char"),
    ("__UINT8_TYPE__", "unsigned char"),
    ("__INT16_TYPE__", "short"),
    ("__UINT16_TYPE__", "unsigned short"),
    ("__INT32_TYPE__", "int"),
    ("__UINT32_TYPE__", "unsigned"),
    ("__INT_LEAST8_TYPE__", "signed char"),
    ("__UINT_LEAST8_TYPE__", "unsigned char"),
    ("__INT_FAST8_TYPE__", "signed char"),
    ("__UINT_FAST8_TYPE__", "unsigned char"),
    ("__INT_LEAST16_TYPE__", "short"),
    ("__UINT_LEAST16_TYPE__", "unsigned short"),
    ("__INT_FAST16_TYPE__", "int"),
    ("__UINT_FAST16_TYPE__", "unsigned"),
    ("__INT_LEAST32_TYPE__", "int"),
    ("__UINT_LEAST32_TYPE__", "unsigned"),
    ("__INT_FAST32_TYPE__", "int"),
    ("__UINT_FAST32_TYPE__", "unsigned"),
    ("__INT_LEAST64_TYPE__", "long long"),
    ("__UINT_LEAST64_TYPE__", "unsigned long long"),
    ("__INT_FAST64_TYPE__", "long long"),
    ("__UINT_FAST64_TYPE__", "unsigned long long"),
    ("__INTMAX_TYPE__", "long long"),
    ("__UINTMAX_TYPE__", "unsigned long long"),
    ("__CHAR16_TYPE__", "unsigned short"),
    ("__CHAR32_TYPE__", "unsigned"),
    ("__WINT_TYPE__", "unsigned"),
    ("__INT64_TYPE__", "long long"),
    ("__UINT64_TYPE__", "unsigned long long"),
    ("__ORDER_LITTLE_ENDIAN__", "1234"),
    ("__ORDER_BIG_ENDIAN__", "4321"),
    ("__BYTE_ORDER__", "__ORDER_LITTLE_ENDIAN__"),
    ("__FLOAT_WORD_ORDER__", "__ORDER_LITTLE_ENDIAN__"),
    ("__FLT_RADIX__", "2"),
    ("__FLT_EVAL_METHOD__", "0"),
    ("__FLT_MANT_DIG__", "24"),
    ("__FLT_DIG__", "6"),
    ("__FLT_MIN_EXP__", "(-125)"),
    ("__FLT_MAX_EXP__", "128"),
    ("__FLT_MIN_10_EXP__", "(-37)"),
    ("__FLT_MAX_10_EXP__", "38"),
    ("__FLT_MIN__", "0x1p-126f"),
    ("__FLT_DENORM_MIN__", "0x1p-149f"),
    ("__FLT_EPSILON__", "0x1p-23f"),
    ("__FLT_MAX__", "0x1.fffffep127f"),
    ("__DBL_MANT_DIG__", "53"),
    ("__DBL_DIG__", "15"),
    ("__DBL_MIN_EXP__", "(-1021)"),
    ("__DBL_MAX_EXP__", "1024"),
    ("__DBL_MIN_10_EXP__", "(-307)"),
    ("__DBL_MAX_10_EXP__", "308"),
    ("__DBL_MIN__", "0x1p-1022"),
    ("__DBL_DENORM_MIN__", "0x1p-1074"),
    ("__DBL_EPSILON__", "0x1p-52"),
    ("__DBL_MAX__", "0x1.fffffffffffffp1023"),
    ("__LDBL_MANT_DIG__", "53"),
    ("__LDBL_DIG__", "15"),
    ("__LDBL_MIN_EXP__", "(-1021)"),
    ("__LDBL_MAX_EXP__", "1024"),
    ("__LDBL_MIN__", "0x1p-1022L"),
    ("__LDBL_DENORM_MIN__", "0x1p-1074L"),
    ("__LDBL_EPSILON__", "0x1p-52L"),
    ("__LDBL_MAX__", "0x1.fffffffffffffp1023L"),
    ("__DECIMAL_DIG__", "17"),
    ("__DATE__", "\"Jan  1 1970\""),
    ("__TIME__", "\"00:00:00\""),
];

/// State while one source file is preprocessed.
struct Preprocessor<'a> {
    sources: &'a mut SourceMap,
    messages: &'a mut Messages,
    resolve: &'a dyn Fn(&Include<'_>) -> Included,
    names: Interner,
    macros: HashMap<Name, Rc<Macro>>,
    /// Definitions saved by `#pragma push_macro`: for each name, the latest last.
    pushed: HashMap<Name, Vec<Option<Rc<Macro>>>>,
    /// Effects of `#line` on each file: a number added to its line numbers, and a name.
    lines: HashMap<SourceFile, (i64, Option<String>)>,
    once: HashSet<SourceFile>,
    /// Conditional sections around the current line, innermost last.
    sections: Vec<Section>,
    depth: usize,
    /// The next value of `__COUNTER__`.
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
        pushed: HashMap::new(),
        once: HashSet::new(),
        lines: HashMap::new(),
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
    if options.double_is_float {
        preprocessor.predefine("__SRP_DOUBLE_IS_FLOAT", "1", nowhere);
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
        let bytes = self.sources.text(file).len();
        let tokens = lex(
            self.sources,
            file,
            self.budget,
            &mut self.names,
            self.messages,
        );
        // A file without a token takes time to read, too, and may be included again and again.
        let first = Span::point(self.sources.base(file));
        let first = tokens.first().map_or(first, |first| first.span);
        self.spend(tokens.len().max(bytes / BYTES_OF_TOKEN), first);
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

    /// True if `#include` would find the file named in the brackets of `__has_include`.
    pub(crate) fn has_include(&mut self, span: Span, tokens: &[PpToken]) -> bool {
        let (name, system) = match tokens {
            [name] if name.kind == PpKind::Str => (name.text.trim_matches('"').to_owned(), false),
            [open, middle @ .., close] if open.is("<") && close.is(">") => {
                (middle.iter().map(|t| &*t.text).collect(), true)
            }
            _ => return false,
        };
        let Some(from) = self.sources.file(span) else {
            return false;
        };
        let from = self.sources.name(from).to_owned();
        let include = Include {
            name: &name,
            from: &from,
            system,
        };
        let found = (self.resolve)(&include);
        matches!(found, Included::Found(_) | Included::Doubtful(..))
            || library::header(&name).is_some()
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
        let found = match (self.resolve)(&include) {
            Included::Missing => library::header(name).into(),
            found => found,
        };
        let source = match found {
            Included::Found(source) => source,
            Included::Doubtful(source, fact) => {
                let message = self.sources.note(OUTSIDE, span, fact);
                self.messages.push(message);
                source
            }
            Included::Refused(why) => {
                let text = format!("file `{name}` is not read: {why}");
                return self.error(INCLUDE, span, text, "");
            }
            Included::Missing => {
                let text = format!("file `{name}` was not found");
                let message = self.sources.error(INCLUDE, span, text, "");
                let near = library::nearest_header(name);
                let message = message.help(near.as_deref().unwrap_or("includes are looked up beside the file, in the folders of `-I`, and in the kernel directory"));
                return self.messages.push(message);
            }
        };
        match self.sources.add(source) {
            None => self.error(LIMIT, span, "the sources are too large", ""),
            Some(file) if self.once.contains(&file) => {}
            Some(file) => {
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
