//! The conditions of `#if` and `#elif`: integer constant expressions in 64 bits.

use super::Preprocessor;
use crate::lex::{PpKind, PpToken};
use crate::literal::{self, Literal};
use crate::message::{CONDITION, Code, LIMIT};
use srp_archdesc::diagnostic::Span;

/// Depth of brackets and operators in a condition.
const MAX_DEPTH: usize = 100;

/// A value of `intmax_t` or `uintmax_t`.
#[derive(Clone, Copy)]
struct Number {
    bits: i64,
    unsigned: bool,
}

/// Why a condition has no value.
struct Problem(Code, Span, String);

type Outcome = Result<Number, Problem>;

/// Reads a condition from left to right.
struct Reader<'a> {
    tokens: &'a [PpToken],
    at: usize,
    /// The whole line, for errors at its end.
    line: Span,
    depth: usize,
}

impl Preprocessor<'_> {
    /// True if the condition holds; false if it cannot be evaluated.
    pub(super) fn condition(&mut self, span: Span, rest: &[PpToken]) -> bool {
        let replaced = self.replace_defined(rest);
        let tokens = self.expand(replaced);
        let line = tokens.iter().fold(span, |span, token| {
            if token.span.start >= span.start {
                span.to(token.span)
            } else {
                span
            }
        });
        let mut reader = Reader {
            tokens: &tokens,
            at: 0,
            line,
            depth: 0,
        };
        let value = reader
            .conditional(true)
            .and_then(|value| match reader.peek() {
                Some(extra) => {
                    let text = format!("`{}` does not belong to the condition", extra.text);
                    Err(Problem(CONDITION, extra.span, text))
                }
                None => Ok(value),
            });
        match value {
            Ok(value) => value.bits != 0,
            Err(Problem(code, span, text)) => {
                self.error(code, span, text, "");
                false
            }
        }
    }

    /// Replaces `defined X` and `defined(X)` by 1 or 0.
    fn replace_defined(&mut self, tokens: &[PpToken]) -> Vec<PpToken> {
        let mut out = Vec::new();
        let mut rest = tokens;
        while let Some((token, after)) = rest.split_first() {
            rest = after;
            if token.is_word("__has_include")
                && let [open, inside @ ..] = after
                && open.is("(")
                && let Some(close) = inside.iter().position(|t| t.is(")"))
            {
                let found = self.has_include(token.span, &inside[..close]);
                out.push(PpToken {
                    kind: PpKind::Number,
                    text: self.names.name(if found { "1" } else { "0" }),
                    ..token.clone()
                });
                rest = &inside[close + 1..];
                continue;
            }
            let name = match after {
                _ if !token.is_word("defined") => None,
                [name, ..] if name.kind == PpKind::Ident => Some((name, 1)),
                [open, name, close, ..]
                    if open.is("(") && name.kind == PpKind::Ident && close.is(")") =>
                {
                    Some((name, 3))
                }
                _ => None,
            };
            let Some((name, used)) = name else {
                out.push(token.clone());
                continue;
            };
            let known = self.macros.contains_key(&name.text)
                || matches!(
                    &*name.text,
                    "__LINE__" | "__FILE__" | "__COUNTER__" | "__has_include"
                );
            out.push(PpToken {
                kind: PpKind::Number,
                text: self.names.name(if known { "1" } else { "0" }),
                ..token.clone()
            });
            rest = &after[used..];
        }
        out
    }
}

impl Reader<'_> {
    fn peek(&self) -> Option<&PpToken> {
        self.tokens.get(self.at)
    }

    fn take(&mut self, punct: &str) -> bool {
        let found = self.peek().is_some_and(|t| t.is(punct));
        self.at += usize::from(found);
        found
    }

    fn expect(&mut self, punct: &str) -> Result<(), Problem> {
        if self.take(punct) {
            return Ok(());
        }
        let span = self.peek().map_or(self.line, |t| t.span);
        Err(Problem(CONDITION, span, format!("expected `{punct}`")))
    }

    fn deeper(&mut self) -> Result<(), Problem> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            let text = format!("the condition nests deeper than {MAX_DEPTH}");
            return Err(Problem(LIMIT, self.line, text));
        }
        Ok(())
    }

    /// `live`: whether the value matters, so that a division by zero is an error.
    fn conditional(&mut self, live: bool) -> Outcome {
        self.deeper()?;
        let condition = self.binary(0, live)?;
        let value = if self.take("?") {
            let chosen = condition.bits != 0;
            let then = self.conditional(live && chosen)?;
            self.expect(":")?;
            let other = self.conditional(live && !chosen)?;
            Number {
                unsigned: then.unsigned || other.unsigned,
                ..if chosen { then } else { other }
            }
        } else {
            condition
        };
        self.depth -= 1;
        Ok(value)
    }

    fn binary(&mut self, lowest: u32, live: bool) -> Outcome {
        let mut left = self.unary(live)?;
        while let Some(token) = self.peek() {
            let Some(level) = precedence(token).filter(|&level| level >= lowest) else {
                break;
            };
            let (op, span) = (token.text.clone(), token.span);
            self.at += 1;
            self.deeper()?;
            let live = match &*op {
                "&&" => live && left.bits != 0,
                "||" => live && left.bits == 0,
                _ => live,
            };
            let right = self.binary(level + 1, live)?;
            self.depth -= 1;
            left = match apply(&op, left, right) {
                Some(value) => value,
                None if !live => right,
                None => {
                    let text = "division by zero in a condition".to_owned();
                    return Err(Problem(CONDITION, span, text));
                }
            };
        }
        Ok(left)
    }

    fn unary(&mut self, live: bool) -> Outcome {
        let Some(token) = self.peek().cloned() else {
            let text = "the condition ends where a value is expected".to_owned();
            return Err(Problem(CONDITION, self.line, text));
        };
        self.at += 1;
        let signed = |bits| Number {
            bits,
            unsigned: false,
        };
        if token.kind == PpKind::Punct {
            self.deeper()?;
            let value = match &*token.text {
                "(" => {
                    let value = self.conditional(live)?;
                    self.expect(")")?;
                    value
                }
                "!" => signed(i64::from(self.unary(live)?.bits == 0)),
                "-" => {
                    let value = self.unary(live)?;
                    Number {
                        bits: value.bits.wrapping_neg(),
                        ..value
                    }
                }
                "+" => self.unary(live)?,
                "~" => {
                    let value = self.unary(live)?;
                    Number {
                        bits: !value.bits,
                        ..value
                    }
                }
                _ => return Err(no_value(&token)),
            };
            self.depth -= 1;
            return Ok(value);
        }
        match token.kind {
            PpKind::Ident => Ok(signed(0)),
            PpKind::Number => match literal::number(&token.text) {
                Ok(Literal::Int(int)) => Ok(Number {
                    bits: int.value as i64,
                    unsigned: int.unsigned || int.value > i64::MAX as u64,
                }),
                _ => Err(no_value(&token)),
            },
            PpKind::Char => match literal::character(&token.text) {
                Ok(value) => Ok(signed(i64::from(value))),
                Err(why) => Err(Problem(why.code, token.span, why.text)),
            },
            _ => Err(no_value(&token)),
        }
    }
}

fn no_value(token: &PpToken) -> Problem {
    let text = format!("`{}` has no value in a condition", token.text);
    Problem(CONDITION, token.span, text)
}

fn precedence(token: &PpToken) -> Option<u32> {
    if token.kind != PpKind::Punct {
        return None;
    }
    Some(match &*token.text {
        "||" => 0,
        "&&" => 1,
        "|" => 2,
        "^" => 3,
        "&" => 4,
        "==" | "!=" => 5,
        "<" | ">" | "<=" | ">=" => 6,
        "<<" | ">>" => 7,
        "+" | "-" => 8,
        "*" | "/" | "%" => 9,
        _ => return None,
    })
}

/// The value of `l op r`; `None` for a division by zero.
fn apply(op: &str, l: Number, r: Number) -> Option<Number> {
    let unsigned = l.unsigned || r.unsigned;
    let (a, b) = (l.bits, r.bits);
    let (ua, ub) = (a as u64, b as u64);
    let truth = |value: bool| Number {
        bits: i64::from(value),
        unsigned: false,
    };
    let less = if unsigned { ua < ub } else { a < b };
    let bits = match op {
        "||" => return Some(truth(a != 0 || b != 0)),
        "&&" => return Some(truth(a != 0 && b != 0)),
        "==" => return Some(truth(a == b)),
        "!=" => return Some(truth(a != b)),
        "<" => return Some(truth(less)),
        ">=" => return Some(truth(!less)),
        ">" => return Some(truth(!less && a != b)),
        "<=" => return Some(truth(less || a == b)),
        "|" => a | b,
        "^" => a ^ b,
        "&" => a & b,
        "<<" => {
            return Some(Number {
                bits: a.wrapping_shl(b as u32),
                ..l
            });
        }
        ">>" if l.unsigned => {
            return Some(Number {
                bits: ua.wrapping_shr(b as u32) as i64,
                ..l
            });
        }
        ">>" => {
            return Some(Number {
                bits: a.wrapping_shr(b as u32),
                ..l
            });
        }
        "+" => a.wrapping_add(b),
        "-" => a.wrapping_sub(b),
        "*" => a.wrapping_mul(b),
        "/" if unsigned => ua.checked_div(ub)? as i64,
        "%" if unsigned => ua.checked_rem(ub)? as i64,
        "/" if b != 0 => a.wrapping_div(b),
        "%" if b != 0 => a.wrapping_rem(b),
        _ => return None,
    };
    Some(Number { bits, unsigned })
}
