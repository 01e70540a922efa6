//! The lexer: a text to preprocessing tokens. Comments and line splices end here.

use crate::message::{LEXICAL, Messages};
use crate::source::{Name, SourceMap};
use srp_archdesc::diagnostic::Span;
use srp_ir::program::SourceFile;
use std::collections::HashSet;

/// Kinds of preprocessing tokens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PpKind {
    /// An identifier or keyword.
    Ident,
    /// A preprocessing number.
    Number,
    /// A character constant with its quotes.
    Char,
    /// A string literal with its quotes.
    Str,
    /// An operator or punctuator.
    Punct,
    /// A quote without its partner: an error only where it is not skipped.
    Unterminated,
    /// A character that is no part of C.
    Stray,
    /// A pragma for the compiler, spelled without `#pragma srp`.
    Pragma,
}

/// A preprocessing token.
#[derive(Clone, Debug)]
pub(crate) struct PpToken {
    /// Its kind.
    pub(crate) kind: PpKind,
    /// Its spelling, without line splices.
    pub(crate) text: Name,
    /// Where it is; a token from a macro body is where the macro was called.
    pub(crate) span: Span,
    /// White space stands before it.
    pub(crate) space: bool,
    /// It is the first of its line.
    pub(crate) first: bool,
    /// It names a macro from whose own expansion it comes, and stays as it is.
    pub(crate) hidden: bool,
}

impl PpToken {
    /// True if it is this operator or punctuator.
    pub(crate) fn is(&self, punct: &str) -> bool {
        self.kind == PpKind::Punct && &*self.text == punct
    }

    /// True if it is this identifier.
    pub(crate) fn is_word(&self, word: &str) -> bool {
        self.kind == PpKind::Ident && &*self.text == word
    }
}

/// Spellings, each kept once.
#[derive(Debug, Default)]
pub(crate) struct Interner(HashSet<Name>);

impl Interner {
    /// The shared spelling.
    pub(crate) fn name(&mut self, text: &str) -> Name {
        if let Some(name) = self.0.get(text) {
            return name.clone();
        }
        let name: Name = text.into();
        self.0.insert(name.clone());
        name
    }
}

/// Operators and punctuators, longest first.
const PUNCTS: &[&str] = &[
    "%:%:", "...", "<<=", ">>=", "->", "++", "--", "<<", ">>", "<=", ">=", "==", "!=", "&&", "||",
    "*=", "/=", "%=", "+=", "-=", "&=", "^=", "|=", "##", "<:", ":>", "<%", "%>", "%:", "[", "]",
    "(", ")", "{", "}", ".", "&", "*", "+", "-", "~", "!", "/", "%", "<", ">", "^", "|", "?", ":",
    ";", "=", ",", "#",
];

/// The plain spelling of a digraph.
fn plain(punct: &'static str) -> &'static str {
    match punct {
        "<:" => "[",
        ":>" => "]",
        "<%" => "{",
        "%>" => "}",
        "%:" => "#",
        "%:%:" => "##",
        other => other,
    }
}

/// Reads characters of a text past line splices.
struct Cursor<'a> {
    text: &'a str,
    at: usize,
}

impl Cursor<'_> {
    /// Moves past any line splices here.
    fn splice(&mut self) {
        loop {
            let rest = &self.text.as_bytes()[self.at..];
            self.at += match rest {
                [b'\\', b'\n', ..] => 2,
                [b'\\', b'\r', b'\n', ..] => 3,
                _ => return,
            };
        }
    }

    /// The next character, if it is of ASCII and begins no splice: as nearly all are.
    #[inline(always)]
    fn plain(&self) -> Option<u8> {
        let byte = *self.text.as_bytes().get(self.at)?;
        (byte.is_ascii() && byte != b'\\').then_some(byte)
    }

    /// The next character.
    #[inline(always)]
    fn peek(&mut self) -> Option<char> {
        match self.plain() {
            Some(byte) => Some(char::from(byte)),
            None => self.peek_past_splices(),
        }
    }

    fn peek_past_splices(&mut self) -> Option<char> {
        self.splice();
        self.text[self.at..].chars().next()
    }

    /// The character after the next.
    fn peek_second(&mut self) -> Option<char> {
        let start = self.at;
        self.bump();
        let second = self.peek();
        self.at = start;
        second
    }

    /// Takes the next character.
    fn bump(&mut self) -> Option<char> {
        let c = self.peek()?;
        self.at += c.len_utf8();
        Some(c)
    }

    /// Takes characters while they fit.
    fn skip_while(&mut self, fits: impl Fn(char) -> bool) {
        while self.peek().is_some_and(&fits) {
            self.bump();
        }
    }

    /// Takes this text if it is next.
    fn take(&mut self, text: &str) -> bool {
        if (self.plain()).is_some_and(|next| text.as_bytes().first() != Some(&next)) {
            return false;
        }
        let start = self.at;
        for c in text.chars() {
            if self.bump() != Some(c) {
                self.at = start;
                return false;
            }
        }
        true
    }
}

/// True if an identifier may start with it: letters of any script, and GNU's `$`.
fn starts_ident(c: char) -> bool {
    c.is_alphabetic() || c == '_' || c == '$'
}

/// True if an identifier may contain it after the start.
fn continues_ident(c: char) -> bool {
    c.is_alphanumeric() || c == '_' || c == '$'
}

/// The tokens of a file, no more than `most` of them.
pub(crate) fn lex(
    sources: &SourceMap,
    file: SourceFile,
    most: usize,
    names: &mut Interner,
    messages: &mut Messages,
) -> Vec<PpToken> {
    let base = sources.base(file);
    let mut cursor = Cursor {
        text: sources.text(file),
        at: 0,
    };
    let mut tokens = Vec::new();
    let (mut space, mut first) = (false, true);
    while let Some(c) = cursor.peek().filter(|_| tokens.len() < most) {
        let start = cursor.at;
        if c == '\n' {
            cursor.bump();
            (space, first) = (false, true);
            continue;
        }
        if c.is_ascii_whitespace() || c == '\u{b}' || c == '\u{feff}' {
            cursor.bump();
            space = true;
            continue;
        }
        if cursor.take("//") {
            cursor.skip_while(|c| c != '\n');
            space = true;
            continue;
        }
        if cursor.take("/*") {
            while !cursor.take("*/") {
                if cursor.bump().is_none() {
                    let span = Span::new(base + start as u32, base + start as u32 + 2);
                    messages.push(sources.error(
                        LEXICAL,
                        span,
                        "comment without an end",
                        "starts here",
                    ));
                    break;
                }
            }
            space = true;
            continue;
        }
        let (kind, punct) = token(&mut cursor, c);
        let slice = &cursor.text[start..cursor.at];
        let text = match punct {
            Some(punct) => names.name(punct),
            None if slice.contains('\\') => names.name(&unspliced(slice)),
            None => names.name(slice),
        };
        tokens.push(PpToken {
            kind,
            text,
            span: Span::new(base + start as u32, base + cursor.at as u32),
            space,
            first,
            hidden: false,
        });
        (space, first) = (false, false);
    }
    tokens
}

/// The tokens of a short text, for pasting and predefined macros; all with one span.
pub(crate) fn lex_fragment(text: &str, span: Span, names: &mut Interner) -> Vec<PpToken> {
    let mut sources = SourceMap::new();
    let source = srp_archdesc::diagnostic::Source::new("", text);
    let Some(file) = sources.add(source) else {
        return Vec::new();
    };
    let mut tokens = lex(&sources, file, usize::MAX, names, &mut Messages::new());
    for token in &mut tokens {
        token.span = span;
        token.first = false;
    }
    tokens
}

/// A spelling without its line splices.
fn unspliced(slice: &str) -> String {
    slice.replace("\\\r\n", "").replace("\\\n", "")
}

/// Takes one token that starts with `c`; its plain spelling where it is a punctuator.
fn token(cursor: &mut Cursor<'_>, c: char) -> (PpKind, Option<&'static str>) {
    if starts_ident(c) {
        let start = cursor.at;
        cursor.skip_while(continues_ident);
        let prefix = matches!(&cursor.text[start..cursor.at], "L" | "u" | "U" | "u8");
        return match cursor.peek() {
            Some(quote @ ('"' | '\'')) if prefix => (quoted(cursor, quote), None),
            _ => (PpKind::Ident, None),
        };
    }
    let second = cursor.peek_second();
    if c.is_ascii_digit() || c == '.' && second.is_some_and(|d| d.is_ascii_digit()) {
        number(cursor);
        return (PpKind::Number, None);
    }
    if c == '"' || c == '\'' {
        return (quoted(cursor, c), None);
    }
    match PUNCTS.iter().find(|punct| cursor.take(punct)) {
        Some(punct) => (PpKind::Punct, Some(plain(punct))),
        None => {
            cursor.bump();
            (PpKind::Stray, None)
        }
    }
}

/// Takes a preprocessing number.
fn number(cursor: &mut Cursor<'_>) {
    while let Some(c) = cursor.peek() {
        let signed = matches!(c, 'e' | 'E' | 'p' | 'P');
        if !continues_ident(c) && c != '.' {
            return;
        }
        cursor.bump();
        if signed && matches!(cursor.peek(), Some('+' | '-')) {
            cursor.bump();
        }
    }
}

/// Takes a string or character constant; an unterminated one ends before the line does.
fn quoted(cursor: &mut Cursor<'_>, quote: char) -> PpKind {
    cursor.bump();
    loop {
        match cursor.peek() {
            None | Some('\n') => return PpKind::Unterminated,
            Some(c) => {
                cursor.bump();
                if c == quote {
                    break;
                }
                if c == '\\' && !matches!(cursor.peek(), None | Some('\n')) {
                    cursor.bump();
                }
            }
        }
    }
    if quote == '"' {
        PpKind::Str
    } else {
        PpKind::Char
    }
}
