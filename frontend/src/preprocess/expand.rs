//! Macro expansion: a stack of token lists, the innermost expansion on top. The macros whose
//! bodies are on the stack do not expand again, as the standard wants.

use super::{Preprocessor, spell};
use crate::lex::{PpKind, PpToken, lex_fragment};
use crate::message::{LIMIT, MACRO};
use crate::source::Name;
use srp_archdesc::diagnostic::Span;

/// Depth of macro calls in arguments of macro calls, and of expansions within expansions.
pub(crate) const MAX_EXPANSIONS: usize = 200;

/// A macro.
pub(super) struct Macro {
    /// Parameters of a function-like macro; the last is `__VA_ARGS__` where it is variadic.
    pub(super) params: Option<Vec<Name>>,
    /// The last parameter takes all further arguments.
    pub(super) variadic: bool,
    /// The replacement list.
    pub(super) body: Vec<PpToken>,
    /// Its name in the definition.
    pub(super) span: Span,
}

impl Macro {
    /// A macro without parameters.
    pub(super) fn object(body: Vec<PpToken>, span: Span) -> Macro {
        Macro {
            params: None,
            variadic: false,
            body,
            span,
        }
    }

    /// True if a second definition is equivalent.
    pub(super) fn same(&self, other: &Macro) -> bool {
        self.params == other.params
            && self.variadic == other.variadic
            && spell(&self.body) == spell(&other.body)
    }
}

/// A list of tokens being read; of a macro body where `name` is set.
struct Context {
    tokens: std::vec::IntoIter<PpToken>,
    name: Option<Name>,
}

/// The stack of an expansion.
struct Stack(Vec<Context>);

impl Stack {
    /// Takes the next token; one that names a macro being expanded is marked.
    fn next(&mut self) -> Option<PpToken> {
        loop {
            let top = self.0.last_mut()?;
            match top.tokens.next() {
                Some(mut token) => {
                    token.hidden |= token.kind == PpKind::Ident
                        && self.0.iter().any(|c| c.name.as_ref() == Some(&token.text));
                    return Some(token);
                }
                None => {
                    self.0.pop();
                }
            }
        }
    }

    /// True if the next token is `(`.
    fn at_call(&self) -> bool {
        let mut nexts = self.0.iter().rev();
        nexts
            .find_map(|c| c.tokens.as_slice().first())
            .is_some_and(|t| t.is("("))
    }
}

impl Preprocessor<'_> {
    /// Expands all macros in a list of tokens.
    pub(super) fn expand(&mut self, tokens: Vec<PpToken>) -> Vec<PpToken> {
        self.expand_at(tokens, 0)
    }

    fn expand_at(&mut self, tokens: Vec<PpToken>, depth: usize) -> Vec<PpToken> {
        let mut out = Vec::new();
        let mut stack = Stack(vec![Context {
            tokens: tokens.into_iter(),
            name: None,
        }]);
        while let Some(token) = stack.next() {
            if token.kind != PpKind::Ident || token.hidden {
                out.push(token);
                continue;
            }
            if let Some(made) = self.builtin(&token) {
                out.push(made);
                continue;
            }
            let Some(found) = self.macros.get(&token.text).cloned() else {
                out.push(token);
                continue;
            };
            let (mut body, call) = match &found.params {
                None => {
                    let call = token.span;
                    (self.substitute(&found, call, &[], &[]), call)
                }
                Some(_) if !stack.at_call() => {
                    out.push(token);
                    continue;
                }
                Some(params) => {
                    if depth >= MAX_EXPANSIONS {
                        let text = format!("macro calls nest deeper than {MAX_EXPANSIONS}");
                        self.error(LIMIT, token.span, text, "");
                        return out;
                    }
                    let Some((args, call)) = self.arguments(&mut stack, &token, params, &found)
                    else {
                        continue;
                    };
                    let expanded: Vec<_> = args
                        .iter()
                        .map(|arg| self.expand_at(arg.clone(), depth + 1))
                        .collect();
                    (self.substitute(&found, call, &args, &expanded), call)
                }
            };
            if stack.0.len() >= MAX_EXPANSIONS {
                let text = format!("macros expand deeper than {MAX_EXPANSIONS}");
                self.error(LIMIT, token.span, text, "");
                return out;
            }
            if !self.spend(body.len() + 1, token.span) {
                return out;
            }
            self.sources.expanded(call, &token.text, found.span);
            if let Some(first) = body.first_mut() {
                first.space = token.space;
                first.first = token.first;
            }
            stack.0.push(Context {
                tokens: body.into_iter(),
                name: Some(token.text),
            });
        }
        out
    }

    /// `__LINE__`, `__FILE__` and `__COUNTER__`.
    fn builtin(&mut self, token: &PpToken) -> Option<PpToken> {
        let (kind, text) = match &*token.text {
            "__LINE__" => {
                let line = i64::from(self.sources.pos(token.span).line);
                let file = self.sources.file(token.span);
                let moved = file.and_then(|file| self.lines.get(&file));
                let line = line + moved.map_or(0, |(by, _)| *by);
                (PpKind::Number, line.to_string())
            }
            "__FILE__" => {
                let file = self.sources.file(token.span)?;
                let named = self.lines.get(&file).and_then(|(_, name)| name.as_deref());
                (PpKind::Str, quote(named.unwrap_or(self.sources.name(file))))
            }
            "__COUNTER__" => {
                self.counter += 1;
                (PpKind::Number, (self.counter - 1).to_string())
            }
            _ => return None,
        };
        Some(PpToken {
            kind,
            text: self.names.name(&text),
            ..token.clone()
        })
    }

    /// The arguments of the call whose `(` is next, and the span of the whole call.
    fn arguments(
        &mut self,
        stack: &mut Stack,
        name: &PpToken,
        params: &[Name],
        found: &Macro,
    ) -> Option<(Vec<Vec<PpToken>>, Span)> {
        stack.next();
        let mut args = vec![Vec::new()];
        let mut nested = 0usize;
        let close = loop {
            let Some(token) = stack.next() else {
                let text = format!("the call of the macro `{}` has no `)`", name.text);
                self.error(MACRO, name.span, text, "");
                return None;
            };
            let rest = found.variadic && args.len() == params.len();
            match &*token.text {
                ")" if token.is(")") && nested == 0 => break token.span,
                "," if token.is(",") && nested == 0 && !rest => {
                    args.push(Vec::new());
                    continue;
                }
                "(" if token.is("(") => nested += 1,
                ")" if token.is(")") => nested -= 1,
                _ => {}
            }
            if let Some(arg) = args.last_mut() {
                arg.push(token);
            }
        };
        if params.is_empty() && args.len() == 1 && args[0].is_empty() {
            args.clear();
        }
        if found.variadic && args.len() + 1 == params.len() {
            args.push(Vec::new());
        }
        let call = if close.end >= name.span.start {
            name.span.to(close)
        } else {
            name.span
        };
        if args.len() != params.len() {
            let text = format!(
                "the macro `{}` takes {} arguments, not {}",
                name.text,
                params.len(),
                args.len()
            );
            let message = self.sources.error(MACRO, call, text, "");
            let message = self.sources.also(message, found.span, "defined here");
            self.messages.push(message);
            return None;
        }
        Some((args, call))
    }

    /// The body of a macro with its arguments in place.
    fn substitute(
        &mut self,
        found: &Macro,
        call: Span,
        args: &[Vec<PpToken>],
        expanded: &[Vec<PpToken>],
    ) -> Vec<PpToken> {
        let params = found.params.as_deref().unwrap_or(&[]);
        let param = |t: &PpToken| match t.kind {
            PpKind::Ident => params.iter().position(|p| *p == t.text),
            _ => None,
        };
        let body = &found.body;
        let mut out: Vec<PpToken> = Vec::new();
        let mut paste = false;
        let mut i = 0;
        while i < body.len() {
            let start = i;
            let token = &body[i];
            if token.is("##") {
                paste = true;
                i += 1;
                continue;
            }
            let before_paste = body.get(i + 1).is_some_and(|t| t.is("##"));
            let mut piece = if token.is("#") && found.params.is_some() {
                i += 1;
                let arg = param(&body[i]).map_or(&[][..], |p| &args[p]);
                let text = self.names.name(&stringised(arg));
                vec![PpToken {
                    kind: PpKind::Str,
                    text,
                    span: call,
                    ..token.clone()
                }]
            } else if let Some(p) = param(token) {
                let arg = if paste || before_paste {
                    &args[p]
                } else {
                    &expanded[p]
                };
                let mut arg = arg.clone();
                if let Some(first) = arg.first_mut() {
                    first.space = token.space;
                }
                arg
            } else {
                vec![PpToken {
                    span: call,
                    ..token.clone()
                }]
            };
            if paste {
                // GNU: `, ## __VA_ARGS__` drops the comma where there is nothing to follow.
                let after_comma = out.last().is_some_and(|t| t.is(","));
                let rest = found.variadic && param(token) == Some(params.len() - 1);
                if after_comma && rest {
                    if piece.is_empty() {
                        out.pop();
                    }
                } else if !piece.is_empty() && !pasted_nothing(body, start, args, &param) {
                    self.paste(&mut out, &mut piece, call);
                }
            }
            paste = false;
            out.extend(piece);
            if self.budget <= out.len() {
                break;
            }
            i += 1;
        }
        out
    }

    /// Joins the last token of `out` with the first of `piece`.
    fn paste(&mut self, out: &mut Vec<PpToken>, piece: &mut [PpToken], call: Span) {
        let Some(left) = out.pop() else {
            return;
        };
        let text = format!("{}{}", left.text, piece[0].text);
        let mut made = lex_fragment(&text, call, &mut self.names);
        match made.as_mut_slice() {
            [one] if one.kind != PpKind::Stray => {
                one.space = left.space;
                piece[0] = one.clone();
            }
            _ => {
                let text = format!("`##` makes `{text}`, which is no token");
                self.error(MACRO, call, text, "");
                out.push(left);
            }
        }
    }
}

/// True if everything left of the `##` before `body[at]` was empty, back to the last token that no
/// `##` joins to it.
fn pasted_nothing(
    body: &[PpToken],
    at: usize,
    args: &[Vec<PpToken>],
    param: &dyn Fn(&PpToken) -> Option<usize>,
) -> bool {
    let mut left = at;
    while left >= 2 && body[left - 1].is("##") {
        left -= 2;
        // A stringised parameter is never empty.
        let stringised = left > 0 && body[left - 1].is("#");
        match param(&body[left]) {
            Some(p) if args[p].is_empty() && !stringised => {}
            _ => return false,
        }
    }
    true
}

/// A string literal with this content.
fn quote(text: &str) -> String {
    let escaped = text.replace('\\', "\\\\").replace('"', "\\\"");
    format!("\"{escaped}\"")
}

/// Makes a string literal from an argument, as `#` does.
fn stringised(arg: &[PpToken]) -> String {
    let mut text = String::new();
    for (i, token) in arg.iter().enumerate() {
        if i > 0 && (token.space || token.first) {
            text.push(' ');
        }
        match token.kind {
            PpKind::Str | PpKind::Char => {
                text.push_str(&token.text.replace('\\', "\\\\").replace('"', "\\\""));
            }
            _ => text.push_str(&token.text),
        }
    }
    format!("\"{text}\"")
}
