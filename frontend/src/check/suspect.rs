//! Warnings about code that is C and probably not meant: an assignment as a condition, an `if` without a body, a comparison
//! that is always the same, a statement without effect, a variable that has no value yet.

use super::{Checker, Symbol};
use crate::ast::{self, ExprKind as K, Infix, Prefix};
use crate::message::{
    ASSIGNED_CONDITION, Code, EMPTY_BODY, NO_EFFECT, UNINITIALISED, UNSIGNED_RANGE,
};
use crate::typed::*;
use srp_archdesc::diagnostic::Span;

impl Checker<'_> {
    fn suspect(&mut self, code: Code, span: Span, text: String, help: &str) {
        // A macro may be right elsewhere, and what is behind a mistake may be a part of it.
        let in_macro = self.sources.is_expansion(span);
        if self.is_library(span) || in_macro || self.messages.errors() > 0 {
            return;
        }
        let message = self.sources.warning(code, span, text, "");
        self.messages.push(match help {
            "" => message,
            help => message.help(help),
        });
    }

    /// Warns of an assignment that is the condition of a statement, which has parentheses of its own where `enclosed`.
    pub(super) fn suspect_condition(&mut self, e: ast::ExprId, enclosed: bool) {
        let ast::Expr { kind, span, .. } = &self.unit.exprs[e];
        let K::Assign(None, ..) = kind else {
            return;
        };
        let (before, after) = self.sources.around(*span);
        let open = before.trim_end().strip_suffix('(');
        let further = open.is_some_and(|rest| rest.trim_end().ends_with('('));
        let parenthesised =
            after.trim_start().starts_with(')') && if enclosed { further } else { open.is_some() };
        if !parenthesised {
            let text = "an assignment is the condition".to_owned();
            let help = "`==` compares; where `=` is meant, write it in parentheses";
            self.suspect(ASSIGNED_CONDITION, *span, text, help);
        }
    }

    /// Warns of an `if` whose body is a semicolon on the same line as its condition.
    pub(super) fn suspect_body(&mut self, cond: ast::ExprId, body: ast::StmtId) {
        let ast::Stmt { kind, span, .. } = &self.unit.stmts[body];
        if !matches!(kind, ast::StmtKind::Empty) {
            return;
        }
        let start = self.unit.exprs[cond].span.end;
        let between = self.sources.spelled(Span::new(start, span.start));
        // What stands between may be a macro that is empty now.
        if between.trim_end().ends_with(')') && between.trim_matches([')', ' ']).is_empty() {
            let text = "the body of this `if` is empty".to_owned();
            let help = "leave the `;` out, or write `{}` where nothing is to be done";
            self.suspect(EMPTY_BODY, *span, text, help);
        }
    }

    /// Warns of a relation of an unsigned number and a written zero that is the same for all numbers.
    pub(super) fn suspect_relation(
        &mut self,
        relation: Relation,
        l: ExprId,
        r: ExprId,
        span: Span,
    ) {
        let number = |e| {
            let ty = self.ty(e);
            self.types.is_integer(ty) && self.types.is_unsigned(ty) && self.const_value(e).is_none()
        };
        let zero = |e| {
            let written = self.sources.spelled(self.span(e)).starts_with('0');
            written && self.const_number(e) == Some(0)
        };
        let always = match relation {
            Relation::Ge if number(l) && zero(r) => true,
            Relation::Le if zero(l) && number(r) => true,
            Relation::Lt if number(l) && zero(r) => false,
            Relation::Gt if zero(l) && number(r) => false,
            _ => return,
        };
        let text =
            format!("the comparison is always {always}: an unsigned number is never below 0");
        self.suspect(UNSIGNED_RANGE, span, text, "");
    }

    /// Warns of an expression that stands as a statement, and only computes a value.
    pub(super) fn suspect_statement(&mut self, e: ast::ExprId) {
        let ast::Expr { kind, span, .. } = &self.unit.exprs[e];
        let computes = match kind {
            K::Infix(op, ..) => !matches!(op, Infix::LogicalAnd | Infix::LogicalOr | Infix::Comma),
            K::Prefix(op, _) => matches!(
                op,
                Prefix::Plus | Prefix::Minus | Prefix::BitNot | Prefix::Not
            ),
            K::Name(_) | K::Int(_) | K::Float(_) | K::Char(_) | K::Index(..) | K::Member(..) => {
                true
            }
            _ => false,
        };
        // To read what is volatile is an effect elsewhere.
        if !computes || self.told_volatile || self.may_act(e, 0) {
            return;
        }
        let help = match kind {
            K::Infix(Infix::Eq, ..) => "`=` assigns, `==` compares",
            K::Name(name) if matches!(self.lookup(name), Some((Symbol::Function(_), _))) => {
                "`()` calls the function"
            }
            K::Name(name) if self.lookup(name).is_none() => return,
            _ => "",
        };
        let text = "the statement has no effect".to_owned();
        self.suspect(NO_EFFECT, *span, text, help);
    }

    /// True if an expression may do more than compute a value.
    fn may_act(&self, e: ast::ExprId, depth: u32) -> bool {
        let inner = |e: ast::ExprId| self.may_act(e, depth + 1);
        if depth > 64 {
            return true;
        }
        match &self.unit.exprs[e].kind {
            K::Name(_) | K::Int(_) | K::Float(_) | K::Char(_) | K::Str(_) => false,
            K::Member(a, ..) => inner(*a),
            K::Index(a, b) | K::Infix(_, a, b) => inner(*a) || inner(*b),
            K::Prefix(op, a) => matches!(op, Prefix::Increment | Prefix::Decrement) || inner(*a),
            _ => true,
        }
    }

    /// The variable without a value that an expression names.
    pub(super) fn unset(&self, e: ast::ExprId) -> Option<LocalId> {
        let K::Name(name) = &self.unit.exprs[e].kind else {
            return None;
        };
        match self.lookup(name) {
            Some((Symbol::Local(local), _)) if self.context.unset.contains_key(&local) => {
                Some(local)
            }
            _ => None,
        }
    }

    /// Notes that a variable has no value from here on.
    pub(super) fn note_unset(&mut self, local: LocalId) {
        self.context.unset.insert(local, self.context.branches);
    }

    /// Warns of a variable that is read and has no value, once.
    pub(super) fn suspect_read(&mut self, local: LocalId, span: Span) {
        let here = self.context.unset.get(&local) == Some(&self.context.branches);
        if here && self.context.quiet == 0 {
            self.context.unset.remove(&local);
            let text = format!("`{}` has no value here", self.body.locals[local].name);
            self.suspect(UNINITIALISED, span, text, "");
        }
    }

    /// Checks something that is not always computed: what it reads may have been set whenever it is.
    pub(super) fn branch<T>(&mut self, check: impl FnOnce(&mut Self) -> T) -> T {
        self.context.branches += 1;
        let result = check(self);
        self.context.branches -= 1;
        result
    }

    /// Checks something that reads no variables, or for nothing.
    pub(super) fn quietly<T>(&mut self, check: impl FnOnce(&mut Self) -> T) -> T {
        self.context.quiet += 1;
        let result = check(self);
        self.context.quiet -= 1;
        result
    }
}
