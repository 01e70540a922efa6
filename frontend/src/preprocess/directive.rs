//! Directives.

use super::expand::Macro;
use super::{Preprocessor, Section, spell};
use crate::lex::{PpKind, PpToken};
use crate::message::{
    DIRECTIVE, IGNORED, MACRO, MACRO_REDEFINED, PRAGMA, USER_ERROR, USER_WARNING,
};
use crate::source::{Name, Range};
use srp_archdesc::diagnostic::Span;
use srp_archdesc::nearest::nearest;
use srp_ir::pass::MAX_UNROLL;
use srp_ir::program::SourceFile;
use std::rc::Rc;

/// Functions that `#pragma srp precision` is for.
const PRECISION: [&str; 4] = ["rcp", "rsqrt", "sqrt", "div"];

/// The words after `#pragma srp`.
const PRAGMAS: [&str; 5] = ["kernel", "unroll", "independent", "precision", "range"];

/// The words after `#`.
const DIRECTIVES: [&str; 13] = [
    "include", "define", "undef", "if", "ifdef", "ifndef", "elif", "else", "endif", "error",
    "warning", "pragma", "line",
];

impl Preprocessor<'_> {
    /// Follows the directive `# line`.
    pub(super) fn directive(&mut self, file: SourceFile, hash: Span, line: Vec<PpToken>) {
        let Some((word, rest)) = line.split_first() else {
            return;
        };
        let span = hash.to(word.span);
        let active = self.active();
        match &*word.text {
            "if" => self.open(span, |p| p.condition(span, rest)),
            "ifdef" => self.open(span, |p| p.is_defined(span, rest)),
            "ifndef" => self.open(span, |p| !p.is_defined(span, rest)),
            "elif" => self.elif(span, rest),
            "else" => self.otherwise(span),
            "endif" => {
                if self.sections.pop().is_none() {
                    self.error(DIRECTIVE, span, "`#endif` without `#if`", "");
                }
            }
            _ if !active => {}
            "include" => self.include_line(file, span, rest),
            "define" => self.define(span, rest),
            "undef" => match rest {
                [name] if name.kind == PpKind::Ident => {
                    self.macros.remove(&name.text);
                }
                _ => self.error(DIRECTIVE, span, "`#undef` takes one name", ""),
            },
            "error" => self.error(USER_ERROR, span, format!("#error {}", spell(rest)), ""),
            "warning" => {
                let text = format!("#warning {}", spell(rest));
                let message = self.sources.warning(USER_WARNING, span, text, "");
                self.messages.push(message);
            }
            "pragma" => self.pragma(file, span, rest),
            // Positions of messages stay those of the text.
            "line" => self.line_directive(file, span, rest),
            _ if word.kind == PpKind::Number => {
                self.line_directive(file, span, &line);
            }
            "ident" => {}
            other => {
                let text = format!("`#{other}` is no directive of this compiler");
                let message = self.sources.error(DIRECTIVE, span, text, "");
                self.messages.push(match nearest(other, DIRECTIVES) {
                    Some(near) => message.help(format!("did you mean `#{near}`?")),
                    None => message,
                });
            }
        }
    }

    /// `#line`, and what other preprocessors write for it: the number of the next line, and a name.
    fn line_directive(&mut self, file: SourceFile, span: Span, rest: &[PpToken]) {
        let rest = self.expand(rest.to_vec());
        let number = rest.first().and_then(|t| t.text.parse::<i64>().ok());
        let Some(number) = number else {
            return self.error(DIRECTIVE, span, "`#line` takes a number", "");
        };
        let named = rest.get(1).filter(|t| t.kind == PpKind::Str);
        let before = self.lines.get(&file).and_then(|(_, name)| name.clone());
        let name = named
            .map(|t| t.text.trim_matches('"').to_owned())
            .or(before);
        let here = i64::from(self.sources.pos(span).line);
        self.lines.insert(file, (number - here - 1, name));
    }

    /// Opens a conditional section; the condition is looked at only where it matters.
    fn open(&mut self, start: Span, condition: impl FnOnce(&mut Self) -> bool) {
        let outer = self.active();
        let taken = outer && condition(self);
        self.sections.push(Section {
            start,
            active: taken,
            done: taken || !outer,
            last: false,
        });
    }

    fn elif(&mut self, span: Span, rest: &[PpToken]) {
        let Some(section) = self.sections.last_mut() else {
            return self.error(DIRECTIVE, span, "`#elif` without `#if`", "");
        };
        section.active = false;
        if section.last {
            return self.error(DIRECTIVE, span, "`#elif` after `#else`", "");
        }
        if !section.done
            && self.condition(span, rest)
            && let Some(section) = self.sections.last_mut()
        {
            section.active = true;
            section.done = true;
        }
    }

    fn otherwise(&mut self, span: Span) {
        let Some(section) = self.sections.last_mut() else {
            return self.error(DIRECTIVE, span, "`#else` without `#if`", "");
        };
        section.active = !section.done && !section.last;
        section.done = true;
        if std::mem::replace(&mut section.last, true) {
            self.error(DIRECTIVE, span, "a second `#else`", "");
        }
    }

    fn is_defined(&mut self, span: Span, rest: &[PpToken]) -> bool {
        match rest.first() {
            Some(name) if name.kind == PpKind::Ident => {
                self.macros.contains_key(&name.text) || &*name.text == "__has_include"
            }
            _ => {
                self.error(DIRECTIVE, span, "a macro name must follow", "");
                false
            }
        }
    }

    fn include_line(&mut self, file: SourceFile, span: Span, rest: &[PpToken]) {
        let direct = |rest: &[PpToken]| match rest {
            [name] if name.kind == PpKind::Str => {
                Some((name.text.trim_matches('"').to_owned(), false))
            }
            [open, middle @ .., close] if open.is("<") && close.is(">") => {
                Some((spell(middle), true))
            }
            _ => None,
        };
        let span = rest.iter().fold(span, |span, token| span.to(token.span));
        let found = direct(rest).or_else(|| direct(&self.expand(rest.to_vec())));
        match found {
            Some((name, system)) => self.include(file, span, &name, system),
            None => self.error(
                DIRECTIVE,
                span,
                "`#include` takes `\"file\"` or `<file>`",
                "",
            ),
        }
    }

    fn define(&mut self, span: Span, rest: &[PpToken]) {
        let Some((name, body)) = rest.split_first() else {
            return self.error(DIRECTIVE, span, "`#define` needs a name", "");
        };
        if name.kind != PpKind::Ident || &*name.text == "defined" {
            return self.error(MACRO, name.span, "this cannot be the name of a macro", "");
        }
        let made = match body.first() {
            Some(open) if open.is("(") && !open.space => self.function_like(name.span, body),
            _ => Some(Macro::object(body.to_vec(), name.span)),
        };
        let Some(made) = made else {
            return;
        };
        for edge in [made.body.first(), made.body.last()].into_iter().flatten() {
            if edge.is("##") {
                let edge = edge.span;
                return self.error(MACRO, edge, "`##` needs a token on both sides", "");
            }
        }
        if let Some(old) = self.macros.get(&name.text)
            && !old.same(&made)
        {
            let text = format!("`{}` is defined anew with another meaning", name.text);
            let message = self.sources.warning(MACRO_REDEFINED, name.span, text, "");
            let message = self.sources.also(message, old.span, "defined before here");
            self.messages.push(message);
        }
        if !name.text.starts_with('_') && !self.sources.is_library(name.span) {
            self.sources.macros.insert(name.text.clone());
        }
        self.macros.insert(name.text.clone(), Rc::new(made));
    }

    /// A function-like macro from its parameter list on.
    fn function_like(&mut self, span: Span, rest: &[PpToken]) -> Option<Macro> {
        let close = rest.iter().position(|t| t.is(")"));
        let Some(close) = close else {
            self.error(MACRO, span, "the parameters of the macro have no `)`", "");
            return None;
        };
        let mut params: Vec<Name> = Vec::new();
        let mut variadic = false;
        let mut list = &rest[1..close];
        let mut rest_name: Name = "__VA_ARGS__".into();
        // GNU: the name of the rest.
        let named;
        if let [before @ .., name, dots] = list
            && dots.is("...")
            && name.kind == PpKind::Ident
        {
            rest_name = name.text.clone();
            named = before.iter().chain([dots]).cloned().collect::<Vec<_>>();
            list = &named;
        }
        for (i, token) in list.iter().enumerate() {
            let wanted = i % 2 == 0;
            let fits = match wanted {
                false => token.is(",") && i + 1 < list.len(),
                true if token.is("...") => {
                    variadic = true;
                    params.push(rest_name.clone());
                    i + 1 == list.len()
                }
                true => {
                    let fresh = token.kind == PpKind::Ident && !params.contains(&token.text);
                    params.push(token.text.clone());
                    fresh
                }
            };
            if !fits {
                let text = "macro parameters are different names with commas between";
                self.error(MACRO, token.span, text, "");
                return None;
            }
        }
        let body = rest[close + 1..].to_vec();
        for pair in body.windows(2) {
            if pair[0].is("#") && !params.contains(&pair[1].text) {
                let text = "`#` must stand before a parameter";
                self.error(MACRO, pair[0].span, text, "");
                return None;
            }
        }
        if let Some(hash) = body.last().filter(|t| t.is("#")) {
            self.error(MACRO, hash.span, "`#` must stand before a parameter", "");
            return None;
        }
        Some(Macro {
            params: Some(params),
            variadic,
            body,
            span,
        })
    }

    pub(super) fn pragma(&mut self, file: SourceFile, span: Span, rest: &[PpToken]) {
        let span = rest.iter().fold(span, |span, token| span.to(token.span));
        let words: Vec<&str> = rest.iter().map(|t| &*t.text).collect();
        match words.as_slice() {
            ["once"] => {
                self.once.insert(file);
            }
            ["srp", "kernel"] => self.emit_pragma(span, "kernel"),
            ["srp", "unroll", ..] => {
                let count = self.expand(rest[2..].to_vec());
                let count = match count.as_slice() {
                    [number] => number.text.parse().ok(),
                    _ => None,
                };
                match count {
                    Some(n @ 1..=MAX_UNROLL) => self.emit_pragma(span, &format!("unroll {n}")),
                    _ => {
                        let text = format!("`unroll` takes a number from 1 to {MAX_UNROLL}");
                        self.error(PRAGMA, span, text, "");
                    }
                }
            }
            ["srp", "independent", ..] => self.independent(span, rest),
            ["ivdep"] | ["GCC", "ivdep"] => self.emit_pragma(span, "ivdep"),
            ["srp", "precision", ..] => self.precision(span, &rest[2..]),
            ["srp", "range", ..] => self.range(span, &rest[2..]),
            ["srp", rest @ ..] => {
                let message = self.sources.error(PRAGMA, span, "unknown `srp` pragma", "");
                let near = rest.first().and_then(|word| nearest(word, PRAGMAS));
                let message = match near {
                    Some(near) => message.help(format!("did you mean `{near}`?")),
                    None => message.help("there are `kernel`, `unroll N`, `independent(NAME, …)`, `precision(FUNCTION, BITS)` and `range(NAME, LOW, HIGH)`"),
                };
                self.messages.push(message);
            }
            ["push_macro", "(", name, ")"] if name.starts_with('"') => {
                let name = self.names.name(name.trim_matches('"'));
                let now = self.macros.get(&name).cloned();
                self.pushed.entry(name).or_default().push(now);
            }
            ["pop_macro", "(", name, ")"] if name.starts_with('"') => {
                let name = self.names.name(name.trim_matches('"'));
                match self.pushed.get_mut(&name).and_then(Vec::pop) {
                    Some(Some(before)) => {
                        self.macros.insert(name, before);
                    }
                    Some(None) => {
                        self.macros.remove(&name);
                    }
                    None => {}
                }
            }
            ["pack" | "scalar_storage_order", ..] => {
                let text = "a pragma that lays out structs otherwise is not supported";
                self.error(PRAGMA, span, text, "");
            }
            ["STDC", "FP_CONTRACT", "OFF"] | ["GCC", "diagnostic", ..] => {}
            _ => {
                let message = self
                    .sources
                    .warning(IGNORED, span, "unknown pragma is ignored", "");
                let follows = words.get(1).is_some_and(|word| PRAGMAS.contains(word));
                self.messages.push(match follows {
                    true => message.help("did you mean `#pragma srp`?"),
                    false => message,
                });
            }
        }
    }

    /// `#pragma srp independent(NAME, …)`.
    fn independent(&mut self, span: Span, rest: &[PpToken]) {
        let tokens = self.expand(rest[2..].to_vec());
        let list = match tokens.as_slice() {
            [open, list @ .., close] if open.is("(") && close.is(")") => list,
            _ => &[],
        };
        let mut text = "independent".to_owned();
        for (i, token) in list.iter().enumerate() {
            let fits = match i % 2 {
                0 => token.kind == PpKind::Ident,
                _ => token.is(","),
            };
            if !fits || list.len() % 2 == 0 {
                text.clear();
                break;
            }
            if i % 2 == 0 {
                text.push(' ');
                text.push_str(&token.text);
            }
        }
        if list.is_empty() || text.is_empty() {
            let text = "`independent` takes names of arrays and pointers in parentheses";
            return self.error(PRAGMA, span, text, "");
        }
        self.emit_pragma(span, &text);
    }

    /// `precision(FUNCTION, BITS)`.
    fn precision(&mut self, span: Span, rest: &[PpToken]) {
        let asked = match rest {
            [open, function, comma, bits @ .., close]
                if open.is("(") && comma.is(",") && close.is(")") =>
            {
                let bits = self.expand(bits.to_vec());
                let number = match bits.as_slice() {
                    [number] => number.text.parse().ok(),
                    _ => None,
                };
                number.map(|bits: u32| (function.text.clone(), bits))
            }
            _ => None,
        };
        match asked {
            Some((function, bits @ 1..=24)) if PRECISION.contains(&&*function) => {
                self.emit_pragma(span, &format!("precision {function} {bits}"));
            }
            _ => {
                let text = format!(
                    "`precision` takes one of {} and a number of bits from 1 to 24: precision(rcp, 12)",
                    PRECISION.join(", ")
                );
                let message = self.sources.error(PRAGMA, span, text, "");
                let function = rest.get(1).map_or("", |token| &*token.text);
                let near = nearest(function, PRECISION).filter(|near| *near != function);
                self.messages.push(match near {
                    Some(near) => message.help(format!("did you mean `{near}`?")),
                    None => message,
                });
            }
        }
    }

    /// `range(name, low, high)`: between which numbers a parameter or object lies. Nothing depends on it but
    /// studies of accuracy.
    fn range(&mut self, span: Span, rest: &[PpToken]) {
        let text: String = match rest {
            [open, name, middle @ .., close] if open.is("(") && close.is(")") => {
                let middle = self.expand(middle.to_vec());
                let middle = middle.iter().map(|t| &*t.text);
                std::iter::once(&*name.text).chain(middle).collect()
            }
            _ => String::new(),
        };
        let parts: Vec<&str> = text.split(',').collect();
        let number = |text: &str| {
            let text = text.trim_end_matches(['f', 'F']);
            text.parse().ok().filter(|x: &f64| x.is_finite())
        };
        match parts.as_slice() {
            [name, low, high] if !name.is_empty() => {
                if let (Some(low), Some(high)) = (number(low), number(high))
                    && low <= high
                {
                    let name = (*name).to_owned();
                    self.sources.ranges.push(Range {
                        name,
                        low,
                        high,
                        span,
                    });
                    return;
                }
            }
            _ => {}
        }
        let text = "`range` takes a name and two numbers, the least first: range(x, 0.1, 10)";
        self.error(PRAGMA, span, text, "");
    }

    fn emit_pragma(&mut self, span: Span, text: &str) {
        let text = self.names.name(text);
        self.out.push(PpToken {
            kind: PpKind::Pragma,
            text,
            span,
            space: true,
            first: true,
            hidden: false,
        });
    }
}
