//! Turns a source file into its syntax tree: preprocessing, classification, the generated parser,
//! and messages for syntax errors.

use crate::ast::Unit;
use crate::ast::build::Builder;
use crate::classify::classify;
use crate::library;
use crate::message::{LIMIT, Messages, SYNTAX};
use crate::options::Options;
use crate::preprocess::preprocess;
use crate::source::{Name, SourceMap};
use crate::token::{Fixed, FloatConst, Tok, Token, tokens};
use crate::trouble::Trouble;
use srp_archdesc::diagnostic::{Diagnostic, Source, Span};
use srp_archdesc::nearest::nearest;
use std::collections::BTreeSet;

#[allow(missing_docs, unreachable_pub, unused, clippy::all, clippy::pedantic)]
mod grammar {
    lalrpop_util::lalrpop_mod!(pub file, "/grammar.rs");
    pub use file::*;
}

/// Parses one source file. Errors go to `messages`; the tree has everything that was understood.
pub fn parse(
    source: &Source,
    options: &Options<'_>,
    sources: &mut SourceMap,
    messages: &mut Messages,
) -> Unit {
    let Some(file) = sources.add(source.clone()) else {
        let text = "the sources are too large";
        messages.push(Diagnostic::error(LIMIT.0, &source.name, text));
        return Unit::default();
    };
    let preprocessed = preprocess(file, options, sources, messages);
    let mut plain = tokens(preprocessed, sources, messages);
    let end = sources.base(file) + sources.text(file).trim_end().len() as u32;
    let end = Span::point(end);
    let repairs = MAX_REPAIRS.min(MAX_READ_AGAIN / plain.len().max(1));
    if repairs == 0 {
        return Attempt::of(plain, sources).finish(end, sources, messages);
    }
    let mut attempt = Attempt::of(plain.clone(), sources);
    for _ in 0..repairs {
        let Some((at, message)) = attempt.missing_semicolon(end, sources) else {
            break;
        };
        let tok = Tok::Fixed(Fixed::Semicolon);
        let place = attempt.plain_index(at, &plain);
        let span = Span::point(attempt.tokens[at - 1].span.end);
        plain.insert(place, Token { tok, span });
        let next = Attempt::of(plain.clone(), sources);
        // Where the next token is not understood either, something else is wrong.
        let is_better = |first: &Trouble| first.at > at + 1;
        if !next.trouble.first().is_none_or(is_better) {
            break;
        }
        messages.push(message);
        attempt = next;
    }
    attempt.finish(end, sources, messages)
}

/// Most missing semicolons of a source that are put in, so that each of them is one error.
const MAX_REPAIRS: usize = 50;

/// Most tokens that are parsed again for that: a semicolon is put in by a parse of the whole source.
const MAX_READ_AGAIN: usize = 1 << 21;

/// Tokens, and what the parser makes of them.
struct Attempt {
    tokens: Vec<Token>,
    unit: Unit,
    trouble: Vec<Trouble>,
    messages: Messages,
}

impl Attempt {
    fn of(mut tokens: Vec<Token>, sources: &SourceMap) -> Attempt {
        let mut messages = Messages::new();
        classify(&mut tokens, sources, &mut messages);
        let mut builder = Builder::new(&tokens, sources, &mut messages);
        let numbered = tokens.iter().enumerate();
        let numbered = numbered.map(|(i, token)| Ok::<_, ()>((i, token.tok.clone(), i + 1)));
        let outcome = grammar::FileParser::new().parse(&mut builder, numbered);
        let Builder {
            unit, mut trouble, ..
        } = builder;
        if let Err(error) = outcome {
            trouble.push(Trouble::of_error(error));
        }
        Attempt {
            tokens,
            unit,
            trouble,
            messages,
        }
    }

    /// The token before which a semicolon is missing, if that is the first trouble, and the message: one at the end
    /// of a line, or before a brace.
    fn missing_semicolon(&self, end: Span, sources: &SourceMap) -> Option<(usize, Diagnostic)> {
        let trouble = self.trouble.first()?;
        let at = trouble.at;
        let (before, found) = (self.tokens.get(at.checked_sub(1)?)?, self.tokens.get(at)?);
        let line = |span: Span| sources.pos(span).line;
        let ends = found.tok == Tok::Fixed(Fixed::RBrace) || line(before.span) < line(found.span);
        let is_missing = ends && wanted(&trouble.expected, false) == Some("`;`");
        let message = is_missing.then(|| explain(trouble, &self.tokens, end, sources))??;
        Some((at, message))
    }

    /// The number that a token has in the tokens before they were classified, which adds types that are not written.
    fn plain_index(&self, at: usize, plain: &[Token]) -> usize {
        let int = Tok::Fixed(Fixed::Int);
        self.tokens[..at].iter().fold(0, |index, token| {
            let is_added = token.tok == int && plain.get(index).is_none_or(|p| p.tok != int);
            index + usize::from(!is_added)
        })
    }

    /// The tree, and all that is not understood.
    fn finish(self, end: Span, sources: &SourceMap, messages: &mut Messages) -> Unit {
        let Attempt {
            tokens,
            mut unit,
            trouble,
            messages: own,
        } = self;
        own.into_list().into_iter().for_each(|m| messages.push(m));
        unit.misunderstood = misunderstood(&tokens, &trouble);
        for trouble in trouble {
            if let Some(message) = explain(&trouble, &tokens, end, sources) {
                messages.push(message);
            }
        }
        let open = |pair: &[Token]| {
            let [first, second] = [&pair[0].tok, &pair[1].tok];
            *first == Tok::Fixed(Fixed::LParen) && *second == Tok::Fixed(Fixed::RParen)
        };
        let single = |token: &Token| token.tok == Tok::Fixed(Fixed::Float);
        unit.wide = tokens.iter().any(|token| is_wide(&token.tok))
            // A function declared without parameters takes floats as doubles.
            || tokens.iter().any(single) && tokens.windows(2).any(open);
        unit
    }
}

/// The names behind words that stand for types and are none, and behind those that the lexer refused.
fn misunderstood(tokens: &[Token], trouble: &[Trouble]) -> BTreeSet<Name> {
    let refused = tokens.windows(2).filter(|pair| pair[0].tok == Tok::Bad);
    let at = trouble.iter().map(|trouble| trouble.at);
    let unknown = at.filter_map(|at| tokens.get(at.checked_sub(1)?..=at));
    let unknown = unknown.filter(|pair| matches!(pair[0].tok, Tok::Ident(_)));
    let names = refused
        .chain(unknown)
        .filter_map(|pair| match &pair[1].tok {
            Tok::Ident(name) => Some(name.clone()),
            _ => None,
        });
    names.collect()
}

/// True if a token may bring in numbers of 64 bits; `...` takes floats as doubles.
fn is_wide(tok: &Tok) -> bool {
    match tok {
        Tok::Fixed(fixed) => matches!(
            fixed,
            Fixed::Double | Fixed::Long | Fixed::Ellipsis | Fixed::VaArg
        ),
        Tok::TypeName(name) => &**name == "__srp_double",
        Tok::Ident(name) => name.starts_with("__builtin_"),
        Tok::Int(int) => int.longs > 1 || int.value > u64::from(u32::MAX / 2),
        Tok::Float(float) => !matches!(float, FloatConst::Single(_)),
        _ => false,
    }
}

/// The message for something not understood; none where the token itself was complained about.
fn explain(
    trouble: &Trouble,
    tokens: &[Token],
    end: Span,
    sources: &SourceMap,
) -> Option<Diagnostic> {
    let token = tokens.get(trouble.at);
    let (found, span) = match token {
        Some(Token { tok: Tok::Bad, .. }) => return None,
        Some(token) => (show(&token.tok), token.span),
        None => ("the end of the file".to_owned(), end),
    };
    if complained_before(trouble.at, tokens, sources) {
        return None;
    }
    let wanted = wanted(&trouble.expected, token.is_none());
    let text = match wanted {
        Some(wanted) => format!("expected {wanted}, found {found}"),
        None => format!("{found} cannot stand here"),
    };
    let message = sources.error(SYNTAX, span, text, "");
    // A body where a declaration should end is that of the next function.
    let body = token.is_some_and(|token| token.tok == Tok::Fixed(Fixed::LBrace));
    if (token.is_none() || body && wanted == Some("`;`"))
        && let Some((brace, label)) = unclosed_brace(tokens, sources)
    {
        return Some(sources.also(message, brace, label));
    }
    let before = trouble.at.min(tokens.len()).checked_sub(1);
    let before = before.and_then(|i| tokens.get(i));
    match (wanted, before) {
        (Some("`;`"), Some(before)) if sources.pos(before.span).line < sources.pos(span).line => {
            let after = Span::point(before.span.end);
            Some(sources.also(message, after, "`;` missing here?"))
        }
        (_, Some(before)) => match &before.tok {
            Tok::Ident(name)
                if matches!(
                    token,
                    Some(Token {
                        tok: Tok::Ident(_),
                        ..
                    })
                ) =>
            {
                Some(message.help(unknown_type(name, tokens)))
            }
            Tok::Ident(name)
                if matches!(
                    token,
                    Some(Token {
                        tok: Tok::Int(_) | Tok::Float(_),
                        ..
                    })
                ) =>
            {
                Some(match nearest(name, ["return", "case"]) {
                    Some(near) => message.help(format!("did you mean `{near}`?")),
                    None => message,
                })
            }
            _ => Some(message),
        },
        _ => Some(message),
    }
}

/// The brace that has no other to close it, and what to say of it: the first that one of another indentation closes, or else
/// the innermost that none does.
fn unclosed_brace(tokens: &[Token], sources: &SourceMap) -> Option<(Span, &'static str)> {
    let indentation = |at: usize| {
        let place = |token: &Token| {
            let pos = sources.pos(token.span);
            (pos.file, pos.line)
        };
        let line = place(&tokens[at]);
        let before = tokens[..at].iter().rev();
        let first = before.take_while(|token| place(token) == line).last();
        let column = sources.pos(first.unwrap_or(&tokens[at]).span).column;
        (line, column, first.is_none())
    };
    let (mut open, mut doubtful) = (Vec::new(), None);
    for (at, token) in tokens.iter().enumerate() {
        match token.tok {
            Tok::Fixed(Fixed::LBrace) => open.push(at),
            Tok::Fixed(Fixed::RBrace) => {
                let from = open.pop()?;
                if doubtful.is_none() {
                    let ((start, from_column, _), (end, to_column, leads)) =
                        (indentation(from), indentation(at));
                    let differs = leads && start != end && from_column != to_column;
                    doubtful = differs.then_some(from);
                }
            }
            _ => {}
        }
    }
    let innermost = *open.last()?;
    Some(match doubtful {
        Some(at) => (tokens[at].span, "is this `{` not closed?"),
        None => (tokens[innermost].span, "this `{` is not closed"),
    })
}

/// Advice about a name that stands where a type, or another keyword, was probably meant.
fn unknown_type(name: &str, tokens: &[Token]) -> String {
    let text = format!("`{name}` is not known as a type");
    if let Some(header) = library::header_of(name) {
        return format!("{text}: {header}");
    }
    let types: BTreeSet<&str> = tokens
        .iter()
        .filter_map(|token| match &token.tok {
            Tok::TypeName(name) => Some(&**name),
            _ => None,
        })
        .collect();
    let keywords = Fixed::ALL.iter().map(|fixed| fixed.text());
    let keywords = keywords.filter(|text| text.starts_with(|c: char| c.is_ascii_lowercase()));
    match nearest(name, types.into_iter().chain(keywords)) {
        Some(near) => format!("{text}; did you mean `{near}`?"),
        None => text,
    }
}

/// True if a lexical error precedes a token on its line: a syntax error there is only a
/// consequence.
fn complained_before(at: usize, tokens: &[Token], sources: &SourceMap) -> bool {
    let at = at.min(tokens.len());
    let Some(before) = at.checked_sub(1).and_then(|at| tokens.get(at)) else {
        return false;
    };
    let line = |token: &Token| {
        let pos = sources.pos(token.span);
        (pos.file, pos.line)
    };
    let same_line = tokens[..at]
        .iter()
        .rev()
        .take_while(|t| line(t) == line(before));
    same_line.take(64).any(|token| token.tok == Tok::Bad)
}

/// Returns the expected token in words: the most helpful one only.
fn wanted(expected: &[String], at_end: bool) -> Option<&'static str> {
    let has = |name: &str| expected.iter().any(|e| e.trim_matches('"') == name);
    if at_end && has("}") {
        return Some("`}`");
    }
    if has("integer") {
        let statement = has("while");
        return Some(if statement {
            "a statement"
        } else {
            "an expression"
        });
    }
    if has("typedef") {
        return Some(if has("identifier") {
            "a name"
        } else {
            "a declaration"
        });
    }
    let single = [
        (";", "`;`"),
        (")", "`)`"),
        ("]", "`]`"),
        ("}", "`}`"),
        (":", "`:`"),
        ("(", "`(`"),
        ("while", "`while`"),
        ("identifier", "a name"),
        ("int", "a type"),
        (",", "`,`"),
        ("{", "`{`"),
    ];
    let found = single.iter().find(|(name, _)| has(name));
    found.map(|(_, words)| *words)
}

/// A token as a message shows it.
fn show(tok: &Tok) -> String {
    match tok {
        Tok::Fixed(fixed) => format!("`{}`", fixed.text()),
        Tok::Ident(name) => format!("`{name}`"),
        Tok::TypeName(name) => format!("the type `{name}`"),
        Tok::Int(_) | Tok::Float(_) => "a number".to_owned(),
        Tok::Char(_) => "a character constant".to_owned(),
        Tok::Str(_) | Tok::WideStr(_) => "a string".to_owned(),
        Tok::Kernel | Tok::Unroll(_) | Tok::Independent(_) | Tok::Ivdep | Tok::Precision(_) => {
            "a pragma, which must stand before a loop".to_owned()
        }
        Tok::Bad => "something unknown".to_owned(),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The tokens of a text with a `'` after each that names a type.
    pub(crate) fn classified(text: &str) -> String {
        let mut sources = SourceMap::new();
        let mut messages = Messages::new();
        let file = sources.add(Source::new("t.c", text)).expect("small");
        let pp = preprocess(file, &Options::default(), &mut sources, &mut messages);
        let mut tokens = tokens(pp, &sources, &mut messages);
        classify(&mut tokens, &sources, &mut messages);
        let words = tokens.iter().map(|token| match &token.tok {
            Tok::TypeName(name) => format!("{name}'"),
            Tok::Int(int) => int.value.to_string(),
            tok => show(tok).trim_matches('`').to_owned(),
        });
        words.collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn fixed_tokens_parse_back() {
        assert_eq!(Fixed::parse("<<="), Some(Fixed::ShlAssign));
        assert_eq!(Fixed::parse("__inline__"), Some(Fixed::Inline));
        assert_eq!(Fixed::parse("x"), None);
    }
}
