//! Functions that the grammar's actions call. They make nodes, compute spans and depths, and
//! replace trees deeper than [`MAX_DEPTH`] by an error.

use super::*;
use crate::message::{LIMIT, Messages, UNSUPPORTED};
use crate::source::SourceMap;
use crate::token::{IntConst, Token};

/// Depth of expressions and statements. Chains of operators of one level, and of `else if`, do
/// not count: no visitor recurses along them.
pub const MAX_DEPTH: u32 = 200;

/// A label or pragma before a statement.
#[derive(Debug)]
pub(crate) enum Before {
    Label(Label),
    Pragma(Pragma),
}

/// A qualifier or attributes after a `*`.
pub(crate) enum PointerWord {
    Qualifier((Qualifier, Span)),
    Attributes(Vec<Attribute>),
}

/// An operand of `asm`: its constraint and expression, or a clobbered register.
pub(crate) type AsmOperand = (Rc<[u8]>, Option<ExprId>);

/// A unit in the making. Positions of the grammar are numbers of tokens.
pub struct Builder<'a> {
    /// The unit under construction.
    pub(crate) unit: Unit,
    pub(crate) sources: &'a SourceMap,
    pub(crate) messages: &'a mut Messages,
    tokens: &'a [Token],
    /// Syntax errors, by number of the token.
    pub(crate) trouble: Vec<crate::trouble::Trouble>,
}

impl std::fmt::Debug for Builder<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Builder").field("unit", &self.unit).finish()
    }
}

impl<'a> Builder<'a> {
    /// An empty unit of these tokens.
    pub(crate) fn new(
        tokens: &'a [Token],
        sources: &'a SourceMap,
        messages: &'a mut Messages,
    ) -> Builder<'a> {
        Builder {
            unit: Unit::default(),
            sources,
            messages,
            tokens,
            trouble: Vec::new(),
        }
    }

    /// The span of the tokens from number `l` up to number `r`.
    pub(crate) fn span(&self, l: usize, r: usize) -> Span {
        let Some(first) = self.tokens.get(l).or(self.tokens.last()) else {
            return Span::point(0);
        };
        match self.tokens.get(l..r).and_then(<[Token]>::last) {
            // A later token may stand in another file, or come from a macro called before.
            Some(last) if last.span.end >= first.span.start => first.span.to(last.span),
            Some(_) => first.span,
            None => Span::point(first.span.start),
        }
    }

    /// Adds an expression of the tokens from `l` to `r` above these.
    pub(crate) fn expr(
        &mut self,
        kind: ExprKind,
        below: &[ExprId],
        (l, r): (usize, usize),
    ) -> ExprId {
        let deepest = below.iter().map(|&e| self.unit.exprs[e].depth).max();
        let depth = 1 + deepest.unwrap_or(0);
        self.expr_at(kind, depth, self.span(l, r))
    }

    /// Adds `l op r`.
    pub(crate) fn infix(
        &mut self,
        op: Infix,
        left: ExprId,
        right: ExprId,
        (l, r): (usize, usize),
    ) -> ExprId {
        let exprs = &self.unit.exprs;
        let chain = match exprs[left].kind {
            ExprKind::Infix(inner, ..) if inner.level() == op.level() => exprs[left].depth,
            _ => exprs[left].depth + 1,
        };
        let depth = chain.max(exprs[right].depth + 1);
        self.expr_at(ExprKind::Infix(op, left, right), depth, self.span(l, r))
    }

    fn expr_at(&mut self, kind: ExprKind, depth: u32, span: Span) -> ExprId {
        let (kind, depth) = if depth > MAX_DEPTH {
            self.too_deep("expressions", span);
            (ExprKind::Error, 1)
        } else {
            (kind, depth)
        };
        self.unit.exprs.push(Expr { kind, span, depth })
    }

    fn too_deep(&mut self, what: &str, span: Span) {
        let text = format!("{what} nest deeper than {MAX_DEPTH} levels");
        self.messages
            .push(self.sources.error(LIMIT, span, text, ""));
    }

    /// Adds a statement of the tokens from `l` to `r` above these.
    pub(crate) fn stmt(
        &mut self,
        kind: StmtKind,
        below: &[StmtId],
        (l, r): (usize, usize),
    ) -> StmtId {
        let deepest = below.iter().map(|&s| self.unit.stmts[s].depth).max();
        let span = self.span(l, r);
        self.stmt_at(kind, 1 + deepest.unwrap_or(0), span)
    }

    /// Adds an `if`.
    pub(crate) fn if_(
        &mut self,
        cond: ExprId,
        then: StmtId,
        other: Option<StmtId>,
        (l, r): (usize, usize),
    ) -> StmtId {
        let stmts = &self.unit.stmts;
        let chain = other.map_or(0, |other| match stmts[other].kind {
            StmtKind::If(..) => stmts[other].depth,
            _ => stmts[other].depth + 1,
        });
        let depth = chain.max(stmts[then].depth + 1);
        self.stmt_at(StmtKind::If(cond, then, other), depth, self.span(l, r))
    }

    /// Adds `({ … })`.
    pub(crate) fn statements(&mut self, body: StmtId, (l, r): (usize, usize)) -> ExprId {
        let depth = 1 + self.unit.stmts[body].depth;
        self.expr_at(ExprKind::Statements(body), depth, self.span(l, r))
    }

    /// The member `id` of an object of type `ty` at address 0.
    pub(crate) fn member_at_zero(
        &mut self,
        mut ty: TypeName,
        id: (Name, Span),
        at: (usize, usize),
    ) -> ExprId {
        let span = ty.span;
        let derived = &mut ty.declarator.derived;
        derived.insert(0, (Derived::Pointer(Vec::new()), span));
        let zero = IntConst {
            value: 0,
            unsigned: false,
            longs: 0,
            decimal: true,
        };
        let zero = self.expr(ExprKind::Int(zero), &[], at);
        let object = self.expr(ExprKind::Cast(Box::new(ty), zero), &[zero], at);
        self.expr(ExprKind::Member(object, id.0, id.1, true), &[object], at)
    }

    /// The address of a member of an object at address 0, as a number.
    pub(crate) fn offset(&mut self, member: ExprId, at: (usize, usize)) -> ExprId {
        let span = self.span(at.0, at.1);
        let address = self.expr(ExprKind::Prefix(Prefix::AddressOf, member), &[member], at);
        let words = [TypeKeyword::Unsigned, TypeKeyword::Long];
        let list = words.map(|word| (Spec::Keyword(word), span)).to_vec();
        let size = TypeName {
            specs: Specs { list, span },
            declarator: self.no_declarator(at.0),
            span,
        };
        self.expr(ExprKind::Cast(Box::new(size), address), &[address], at)
    }

    /// The qualifiers of a pointer. Its attributes say nothing, or are refused.
    pub(crate) fn pointer(&mut self, words: Vec<PointerWord>) -> Vec<(Qualifier, Span)> {
        let mut qualifiers = Vec::new();
        for word in words {
            match word {
                PointerWord::Qualifier(qualifier) => qualifiers.push(qualifier),
                PointerWord::Attributes(list) => {
                    let told = list.iter().filter(|a| a.has_effect());
                    for attribute in told {
                        let text = format!("the attribute `{}` cannot stand here", attribute.name);
                        let message = self.sources.error(UNSUPPORTED, attribute.span, text, "");
                        self.messages.push(message);
                    }
                }
            }
        }
        qualifiers
    }

    /// Adds an `asm` statement. An empty text only keeps the compiler from moving things, and adds
    /// nothing; other texts are refused. An output that shares its register with an input is set to
    /// the input.
    pub(crate) fn assembly(
        &mut self,
        text: &[u8],
        parts: Vec<Vec<AsmOperand>>,
        (l, r): (usize, usize),
    ) -> StmtId {
        let mut refused = !text.trim_ascii().is_empty();
        let outputs = parts.first().map_or(&[][..], Vec::as_slice);
        let mut values = Vec::new();
        for (number, (constraint, output)) in outputs.iter().enumerate() {
            let Some(output) = *output else {
                refused = true;
                continue;
            };
            if constraint.starts_with(b"+") {
                values.push(output);
                continue;
            }
            let same = |c: &[u8]| c.trim_ascii() == number.to_string().as_bytes();
            let inputs = parts.get(1).into_iter().flatten();
            match inputs.into_iter().find(|(c, _)| same(c)) {
                Some((_, Some(input))) => {
                    let kind = ExprKind::Assign(None, output, *input);
                    values.push(self.expr(kind, &[output, *input], (l, r)));
                }
                _ => refused = true,
            }
        }
        if refused {
            let text = "`asm` is supported with an empty text only, its outputs being inputs too";
            let span = self.span(l, r);
            self.messages
                .push(self.sources.error(UNSUPPORTED, span, text, ""));
        }
        let plain = |constraint: &[u8]| !constraint.first().is_some_and(u8::is_ascii_digit);
        let inputs = parts.iter().skip(1).flatten();
        let inputs = inputs.filter(|(constraint, _)| plain(constraint));
        values.extend(inputs.filter_map(|(_, e)| *e));
        let used: Vec<_> = values
            .into_iter()
            .map(|e| {
                // The value is for nothing, as after a cast to `void`.
                let span = self.span(l, r);
                let void = Box::new(TypeName::void(span));
                let unused = self.expr(ExprKind::Cast(void, e), &[e], (l, r));
                self.stmt(StmtKind::Expr(unused), &[], (l, r))
            })
            .collect();
        self.stmt(StmtKind::Block(used.clone()), &used, (l, r))
    }

    /// Adds a statement with labels and pragmas before it; a label goes with the whole.
    pub(crate) fn prefixed(
        &mut self,
        before: Vec<(Before, Span)>,
        body: StmtId,
        (l, r): (usize, usize),
    ) -> StmtId {
        let (mut labels, mut pragmas) = (Vec::new(), Vec::new());
        for (before, span) in before {
            match before {
                Before::Label(label) => labels.push(label),
                Before::Pragma(pragma) => pragmas.push((pragma, span)),
            }
        }
        let mut whole = body;
        if !pragmas.is_empty() {
            whole = self.stmt(StmtKind::Pragmas(pragmas, whole), &[whole], (l, r));
        }
        if !labels.is_empty() {
            whole = self.stmt(StmtKind::Labelled(labels, whole), &[whole], (l, r));
        }
        whole
    }

    fn stmt_at(&mut self, kind: StmtKind, depth: u32, span: Span) -> StmtId {
        let (kind, depth) = if depth > MAX_DEPTH {
            self.too_deep("statements", span);
            (StmtKind::Error, 1)
        } else {
            (kind, depth)
        };
        self.unit.stmts.push(Stmt { kind, span, depth })
    }

    /// An attribute by its name, `vector_size` and `__vector_size__` being the same.
    pub(crate) fn attribute(&self, name: &str, args: Vec<ExprId>, at: (usize, usize)) -> Attribute {
        let bare = name
            .strip_prefix("__")
            .and_then(|name| name.strip_suffix("__"));
        Attribute {
            name: bare.unwrap_or(name).into(),
            args,
            span: self.span(at.0, at.1),
        }
    }

    /// A declarator without a name, at token `at`.
    pub(crate) fn no_declarator(&self, at: usize) -> Declarator {
        Declarator {
            name: None,
            derived: Vec::new(),
            span: self.span(at, at),
        }
    }

    /// Specifiers with the span of all of them.
    pub(crate) fn specs(&self, list: Vec<(Spec, Span)>, (l, r): (usize, usize)) -> Specs {
        Specs {
            list,
            span: self.span(l, r),
        }
    }
}
