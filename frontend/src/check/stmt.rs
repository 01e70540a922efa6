//! Statements, and whether control reaches their ends.

use super::{Cases, Checker, Scope, Symbol};
use crate::ast::{self, Label, Pragma};
use crate::ctype::Type;
use crate::message::{PRAGMA, RETURN_VALUE, STATEMENT, UNDECLARED, UNROLL};
use crate::source::Name;
use crate::typed::*;
use srp_archdesc::diagnostic::Span;
use srp_archdesc::isa::Opcode;
use srp_archdesc::structure::Special;
use std::collections::BTreeMap;

/// Requests of pragmas for a loop.
#[derive(Clone)]
struct Asked {
    kernel: bool,
    unroll: u32,
    ivdep: bool,
    independent: Vec<Vec<Variable>>,
    units: Vec<(Special, Opcode)>,
}

impl Asked {
    fn nothing() -> Asked {
        Asked {
            kernel: false,
            unroll: 1,
            ivdep: false,
            independent: Vec::new(),
            units: Vec::new(),
        }
    }
}

impl Checker<'_> {
    pub(super) fn stmt_at(&mut self, kind: StmtKind, span: Span) -> StmtId {
        let pos = self.sources.pos(span);
        self.body.stmts.push(Stmt { kind, pos })
    }

    /// The block of a function, in the scope of its parameters; whether control reaches its end.
    pub(super) fn function_block(&mut self, s: ast::StmtId) -> (StmtId, bool) {
        match &self.unit.stmts[s].kind {
            ast::StmtKind::Block(list) => self.block(list, self.unit.stmts[s].span),
            _ => self.stmt(s),
        }
    }

    pub(super) fn block(&mut self, list: &[ast::StmtId], span: Span) -> (StmtId, bool) {
        let mut stmts = Vec::new();
        let mut flow = true;
        for &s in list {
            if let ast::StmtKind::Declaration(declaration) = &self.unit.stmts[s].kind {
                stmts.extend(self.declaration(declaration));
                continue;
            }
            let (stmt, after) = self.stmt(s);
            stmts.push(stmt);
            // What a label makes reachable again says so itself.
            flow = after && (flow || self.is_labelled(s));
        }
        (self.stmt_at(StmtKind::Block(stmts), span), flow)
    }

    /// True if a label in a statement makes it reachable.
    fn is_labelled(&self, s: ast::StmtId) -> bool {
        // A label anywhere below counts: this only keeps a warning from being missed.
        match &self.unit.stmts[s].kind {
            ast::StmtKind::Labelled(..) => true,
            ast::StmtKind::Block(list) => list.iter().any(|&s| self.is_labelled(s)),
            ast::StmtKind::Pragmas(_, body)
            | ast::StmtKind::While(_, body)
            | ast::StmtKind::DoWhile(body, _)
            | ast::StmtKind::For(_, _, _, body) => self.is_labelled(*body),
            ast::StmtKind::If(_, then, None) => self.is_labelled(*then),
            _ => false,
        }
    }

    /// A statement in a scope of its own.
    fn inner(&mut self, s: ast::StmtId) -> (StmtId, bool) {
        self.scopes.push(Scope::default());
        let result = self.stmt(s);
        self.close_scope();
        result
    }

    /// A statement, and whether control reaches its end if it reaches its start.
    fn stmt(&mut self, s: ast::StmtId) -> (StmtId, bool) {
        let unit = self.unit;
        let ast::Stmt { kind, span, .. } = &unit.stmts[s];
        let span = *span;
        use ast::StmtKind as K;
        let (kind, flow) = match kind {
            K::Empty | K::Error => (StmtKind::Block(Vec::new()), true),
            K::Declaration(declaration) => {
                let stmts = self.declaration(declaration);
                (StmtKind::Block(stmts), true)
            }
            K::StaticAssert(assert) => {
                self.static_assert(assert);
                (StmtKind::Block(Vec::new()), true)
            }
            K::Expr(e) => {
                self.suspect_statement(*e);
                (StmtKind::Expr(self.value(*e)), true)
            }
            K::Block(list) => {
                self.scopes.push(Scope::default());
                let result = self.block(list, span);
                self.close_scope();
                return result;
            }
            K::If(..) => return self.if_chain(s),
            K::While(..) | K::DoWhile(..) | K::For(..) => {
                let asked = Asked::nothing();
                return self.loop_(s, asked);
            }
            K::Switch(e, body) => {
                self.scopes.push(Scope::default());
                let switch = self.switch(*e, *body, span);
                self.close_scope();
                return switch;
            }
            K::Labelled(labels, body) => return self.labelled(labels, *body, span),
            K::Pragmas(pragmas, body) => return self.pragmas(pragmas, *body),
            K::Goto(name, at) => {
                let number = self.label(name, None, Some(*at));
                (StmtKind::Goto(number), false)
            }
            K::Break => {
                match self.context.breaks.last_mut() {
                    Some(breaks) => *breaks = true,
                    None => {
                        let text = "`break` outside of a loop or `switch`";
                        self.error(STATEMENT, span, text, "");
                    }
                }
                (StmtKind::Break, false)
            }
            K::Continue => {
                if self.context.loops == 0 {
                    self.error(STATEMENT, span, "`continue` outside of a loop", "");
                }
                (StmtKind::Continue, false)
            }
            K::Return(value) => (self.return_(*value, span), false),
        };
        (self.stmt_at(kind, span), flow)
    }

    fn return_(&mut self, value: Option<ast::ExprId>, span: Span) -> StmtKind {
        let result = self.context.result.unwrap_or(self.types.known.error);
        let void = result == self.types.known.void;
        let value = match value {
            Some(e) => {
                let value = self.value(e);
                if void {
                    if self.ty(value) != result {
                        let at = self.span(value);
                        self.warning(RETURN_VALUE, at, "the function returns nothing");
                    }
                    // `return f();` in a function that returns nothing as `f` does.
                    let call = self.stmt_at(StmtKind::Expr(value), span);
                    let leave = self.stmt_at(StmtKind::Return(None), span);
                    return StmtKind::Block(vec![call, leave]);
                }
                Some(self.assign_to(value, result, "the result"))
            }
            None if !void => {
                let text = format!("the function returns {}", self.show(result));
                self.warning(RETURN_VALUE, span, text);
                None
            }
            None => None,
        };
        StmtKind::Return(value)
    }

    /// An `if`; `else if` is gone along without recursion.
    fn if_chain(&mut self, s: ast::StmtId) -> (StmtId, bool) {
        let mut links = Vec::new();
        let mut next = Some(s);
        let mut last = None;
        while let Some(s) = next {
            let ast::Stmt { kind, span, .. } = &self.unit.stmts[s];
            let ast::StmtKind::If(c, then, other) = kind else {
                last = Some(self.branch(|checker| checker.inner(s)));
                break;
            };
            // The statement is a block, of which what follows `else` is a part (C11 6.8.4p3).
            self.scopes.push(Scope::default());
            self.suspect_condition(*c, true);
            if other.is_none() {
                self.suspect_body(*c, *then);
            }
            let cond = match links.is_empty() {
                true => self.condition(*c),
                false => self.branch(|checker| checker.condition(*c)),
            };
            let (then, flow) = self.branch(|checker| checker.inner(*then));
            links.push((cond, then, flow, *span));
            next = *other;
        }
        links.iter().for_each(|_| self.close_scope());
        let mut other = last.map(|(stmt, _)| stmt);
        let mut flow = last.is_none_or(|(_, flow)| flow);
        for (cond, then, then_flow, span) in links.into_iter().rev() {
            flow = match self.const_truth(cond) {
                Some(true) => then_flow,
                Some(false) => flow,
                None => then_flow || flow,
            };
            other = Some(self.stmt_at(StmtKind::If(cond, then, other), span));
        }
        let first = other.unwrap_or_else(|| {
            let span = self.unit.stmts[s].span;
            self.stmt_at(StmtKind::Block(Vec::new()), span)
        });
        (first, flow)
    }

    fn pragmas(&mut self, pragmas: &[(Pragma, Span)], body: ast::StmtId) -> (StmtId, bool) {
        let mut asked = Asked::nothing();
        for (pragma, span) in pragmas {
            match pragma {
                Pragma::Kernel => asked.kernel = true,
                Pragma::Unroll(count) => asked.unroll = *count,
                Pragma::Ivdep => asked.ivdep = true,
                Pragma::Independent(names) => {
                    let variables = names
                        .iter()
                        .filter_map(|name| self.variable_of(name, *span));
                    let variables = variables.collect();
                    asked.independent.push(variables);
                }
                Pragma::Precision(function, bits) => {
                    asked.units.extend(self.unit_of(function, *bits, *span));
                }
            }
        }
        use ast::StmtKind as K;
        match self.unit.stmts[body].kind {
            K::While(..) | K::DoWhile(..) | K::For(..) => self.loop_(body, asked),
            _ => {
                for (_, span) in pragmas {
                    self.error(PRAGMA, *span, "this pragma must stand before a loop", "");
                }
                self.stmt(body)
            }
        }
    }

    /// The cheapest unit of the machine that computes a function to so many bits.
    fn unit_of(&mut self, function: &Name, bits: u32, span: Span) -> Option<(Special, Opcode)> {
        let special = (Special::ALL.into_iter()).find(|special| special.name() == &**function)?;
        if let Some(unit) = self.choices.to_bits(special, bits) {
            return Some((special, unit.op));
        }
        let units = self.choices.of_function(special).iter();
        let units: Vec<String> = units
            .map(|unit| format!("`{}` to {}", unit.op, unit.bits()))
            .collect();
        let text = format!("no unit of the machine computes `{function}` to {bits} bits");
        let message = self.sources.error(PRAGMA, span, text, "");
        let help = format!("it has {}", units.join(" and "));
        self.messages.push(message.help(help));
        None
    }

    /// The array, struct or pointer that a pragma names.
    fn variable_of(&mut self, name: &Name, span: Span) -> Option<Variable> {
        let (variable, ty) = match self.lookup(name) {
            Some((Symbol::Local(local), _)) => {
                (Variable::Local(local), self.body.locals[local].ty.ty)
            }
            Some((Symbol::Object(object), _)) => {
                (Variable::Object(object), self.objects[object].ty.ty)
            }
            Some(_) => {
                self.error(PRAGMA, span, format!("`{name}` is no variable"), "");
                return None;
            }
            None => {
                let advice = self.advice_for_name(name);
                let text = format!("`{name}` is not declared");
                self.error_advice(UNDECLARED, span, text, advice);
                return None;
            }
        };
        let fits = matches!(
            self.types.get(ty),
            Type::Array(..) | Type::Record(_) | Type::Pointer(_)
        );
        if !fits {
            let text = format!(
                "`independent` takes arrays and pointers; `{name}` is {}",
                self.show(ty)
            );
            self.error(PRAGMA, span, text, "");
            return None;
        }
        Some(variable)
    }

    /// The body of a loop; whether a `break` leaves it.
    fn loop_body(&mut self, body: ast::StmtId) -> (StmtId, bool) {
        self.context.breaks.push(false);
        self.context.loops += 1;
        let (body, _) = self.inner(body);
        self.context.loops -= 1;
        let breaks = self.context.breaks.pop().unwrap_or(false);
        (body, breaks)
    }

    fn loop_(&mut self, s: ast::StmtId, asked: Asked) -> (StmtId, bool) {
        let ast::Stmt { kind, span, .. } = &self.unit.stmts[s];
        let jumps = self.context.jumps;
        self.scopes.push(Scope::default());
        let (mut init, mut step, mut trip) = (None, None, None);
        if !matches!(kind, ast::StmtKind::For(..)) {
            // What the first round reads, another may have set.
            self.context.unset.clear();
        }
        let cond;
        let (body, breaks, body_first);
        match kind {
            ast::StmtKind::While(c, inner) => {
                self.suspect_condition(*c, true);
                cond = Some(self.condition(*c));
                (body, breaks) = self.loop_body(*inner);
                body_first = false;
            }
            ast::StmtKind::DoWhile(inner, c) => {
                self.suspect_condition(*c, true);
                (body, breaks) = self.loop_body(*inner);
                cond = Some(self.condition(*c));
                body_first = true;
            }
            ast::StmtKind::For(first, c, next, inner) => {
                init = Some(self.stmt(*first).0);
                self.context.unset.clear();
                if let Some(c) = c {
                    self.suspect_condition(*c, false);
                }
                if let Some(next) = next {
                    self.suspect_statement(*next);
                }
                cond = c.map(|c| self.condition(c));
                step = next.map(|next| self.value(next));
                let before = self.context.assigned.len();
                (body, breaks) = self.loop_body(*inner);
                body_first = false;
                trip = self.trip(init, cond, step, &self.context.assigned[before..]);
            }
            _ => {
                self.close_scope();
                return self.stmt(s);
            }
        }
        self.context.unset.clear();
        self.close_scope();
        let forever = cond.is_none_or(|cond| self.const_truth(cond) == Some(true));
        let cond = cond.filter(|_| !forever);
        let labelled = self.context.jumps > jumps;
        if labelled && asked.unroll > 1 {
            let text = "a loop with labels in it is not unrolled";
            self.warning(UNROLL, *span, text);
        }
        let kind = StmtKind::Loop(Loop {
            init,
            cond,
            body_first,
            step,
            body,
            kernel: asked.kernel,
            ivdep: asked.ivdep,
            independent: asked.independent,
            units: asked.units,
            unroll: if labelled { 1 } else { asked.unroll },
            trip,
            labelled,
        });
        (self.stmt_at(kind, *span), !forever || breaks)
    }

    fn switch(&mut self, e: ast::ExprId, body: ast::StmtId, span: Span) -> (StmtId, bool) {
        let value = self.value(e);
        if !self.types.is_integer(self.ty(value)) {
            let text = format!(
                "`switch` takes an integer, not {}",
                self.show(self.ty(value))
            );
            self.error(STATEMENT, self.span(value), text, "");
        }
        let value = self.promote(value);
        self.context.unset.clear();
        self.context.switches.push(Cases {
            ty: self.ty(value),
            cases: Vec::new(),
            seen: BTreeMap::new(),
            default: None,
            labels: 0,
            loops: self.context.loops,
        });
        self.context.breaks.push(false);
        let (body, flow) = self.inner(body);
        let breaks = self.context.breaks.pop().unwrap_or(false);
        let Some(cases) = self.context.switches.pop() else {
            return (body, flow);
        };
        let kind = StmtKind::Switch(Switch {
            value,
            cases: cases.cases,
            default: cases.default.map(|(label, _)| label),
            labels: cases.labels,
            body,
        });
        let flow = flow || breaks || cases.default.is_none();
        (self.stmt_at(kind, span), flow)
    }

    fn labelled(&mut self, labels: &[Label], body: ast::StmtId, span: Span) -> (StmtId, bool) {
        let mut stmts = Vec::new();
        self.context.unset.clear();
        for label in labels {
            let number = match label {
                Label::Case(e, last, at) => self.case(*e, *last, *at),
                Label::Default(at) => self.default(*at),
                Label::Named(name, at) => {
                    let number = self.label(name, Some(*at), None);
                    stmts.push(self.stmt_at(StmtKind::Target(number), span));
                    continue;
                }
            };
            if let Some(number) = number {
                stmts.push(self.stmt_at(StmtKind::Label(number), span));
            }
        }
        let (body, flow) = self.stmt(body);
        stmts.push(body);
        (self.stmt_at(StmtKind::Block(stmts), span), flow)
    }

    /// The number of a label for `goto`, which is defined or used here.
    fn label(&mut self, name: &Name, defined: Option<Span>, used: Option<Span>) -> usize {
        self.context.jumps += usize::from(defined.is_some());
        let next = self.context.labels.len();
        let label = self
            .context
            .labels
            .entry(name.clone())
            .or_insert(super::Label {
                number: next,
                defined: None,
                used: None,
            });
        let number = label.number;
        label.used = label.used.or(used);
        let before = label.defined;
        label.defined = before.or(defined);
        if let (Some(before), Some(span)) = (before, defined) {
            let text = format!("a second label `{name}`");
            let message = self.sources.error(STATEMENT, span, text, "");
            let message = self.sources.also(message, before, "the first");
            self.messages.push(message);
        }
        number
    }

    /// At the end of a function: every label that is gone to stands somewhere.
    pub(super) fn end_labels(&mut self) {
        let labels = std::mem::take(&mut self.context.labels);
        self.body.labels = labels.len();
        for (name, label) in labels {
            if let (None, Some(used)) = (label.defined, label.used) {
                let text = format!("there is no label `{name}` in this function");
                self.error(UNDECLARED, used, text, "");
            }
        }
    }

    /// A `case` of one value or of a range; the number of its label.
    fn case(&mut self, e: ast::ExprId, last: Option<ast::ExprId>, span: Span) -> Option<usize> {
        self.jump_into_loop();
        let first = self.const_int(e, "the value of a `case`");
        let last = last.map(|e| self.const_int(e, "the value of a `case`"));
        let Some(ty) = self.context.switches.last().map(|cases| cases.ty) else {
            self.error(STATEMENT, span, "`case` outside of a `switch`", "");
            return None;
        };
        let number = |value: i128| match self.types.get(ty) {
            Type::Int(int) => int.number(int.wrap(value as u64)),
            _ => value,
        };
        let first = number(first?.0);
        let last = match last {
            Some(last) => number(last?.0),
            None => first,
        };
        if last < first {
            self.error(STATEMENT, span, "the range is empty", "");
            return None;
        }
        let cases = self.context.switches.last_mut()?;
        let below = cases.seen.range(..=last).next_back();
        if let Some((_, &(_, before))) = below.filter(|(_, (end, _))| *end >= first) {
            let text = "the value has a `case` already";
            let message = self.sources.error(STATEMENT, span, text, "");
            let message = self.sources.also(message, before, "here");
            self.messages.push(message);
            return None;
        }
        cases.seen.insert(first, (last, span));
        let label = cases.labels;
        cases.labels += 1;
        cases.cases.push((first, last, label));
        Some(label)
    }

    /// Notes a label of a `switch` that stands outside of the innermost loop.
    fn jump_into_loop(&mut self) {
        let outside = self.context.switches.last().map(|cases| cases.loops);
        if outside.is_some_and(|loops| loops < self.context.loops) {
            self.context.jumps += 1;
        }
    }

    fn default(&mut self, span: Span) -> Option<usize> {
        self.jump_into_loop();
        let Some(cases) = self.context.switches.last_mut() else {
            self.error(STATEMENT, span, "`default` outside of a `switch`", "");
            return None;
        };
        if let Some((_, before)) = cases.default {
            let message = self
                .sources
                .error(STATEMENT, span, "a second `default`", "");
            let message = self.sources.also(message, before, "the first");
            self.messages.push(message);
            return None;
        }
        let label = cases.labels;
        cases.labels += 1;
        cases.default = Some((label, span));
        Some(label)
    }
}
