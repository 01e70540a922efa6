//! The tree as text: one line a declaration or statement with its position, expressions in
//! prefix form.

use super::*;
use crate::source::SourceMap;
use std::fmt::Write;

/// The printed form of a unit.
pub fn show(unit: &Unit, sources: &SourceMap) -> String {
    let mut printer = Printer {
        unit,
        sources,
        out: String::new(),
        indent: 0,
    };
    for item in &unit.items {
        match item {
            Item::Function(function) => printer.function(function),
            Item::Declaration(declaration) => printer.declaration(declaration),
            Item::StaticAssert(assert) => printer.static_assert(assert),
        }
    }
    printer.out
}

struct Printer<'a> {
    unit: &'a Unit,
    sources: &'a SourceMap,
    out: String,
    indent: usize,
}

impl Printer<'_> {
    /// Starts a line with the position of a span.
    fn line(&mut self, span: Span, text: &str) {
        let place = self.sources.show(span);
        let indent = 2 * self.indent;
        // Writing to a string does not fail, here and below.
        let _ = write!(self.out, "{place:<16} {:indent$}{text}", "");
    }

    fn end(&mut self) {
        self.out.push('\n');
    }

    fn function(&mut self, function: &FunctionDefinition) {
        self.line(function.declarator.span, "function ");
        self.declarator(&function.declarator);
        self.out.push_str(": ");
        self.derived(&function.declarator);
        self.specs(&function.specs);
        self.end();
        self.indent += 1;
        function.old_style.iter().for_each(|d| self.declaration(d));
        self.indent -= 1;
        self.nested(function.body);
    }

    fn nested(&mut self, stmt: StmtId) {
        self.indent += 1;
        self.stmt(stmt);
        self.indent -= 1;
    }

    fn declaration(&mut self, declaration: &Declaration) {
        if declaration.declarators.is_empty() {
            self.line(declaration.span, "declare ");
            self.specs(&declaration.specs);
            self.end();
        }
        for item in &declaration.declarators {
            self.line(item.declarator.span, "declare ");
            self.declarator(&item.declarator);
            self.out.push_str(": ");
            self.derived(&item.declarator);
            self.specs(&declaration.specs);
            for attribute in &item.attributes {
                self.attribute(attribute);
            }
            if let Some(init) = &item.init {
                self.out.push_str(" = ");
                self.initialiser(init);
            }
            self.end();
        }
    }

    fn static_assert(&mut self, assert: &StaticAssert) {
        self.line(assert.span, "static_assert ");
        self.expr(assert.condition);
        self.end();
    }

    fn declarator(&mut self, declarator: &Declarator) {
        let name = declarator.name.as_ref().map_or("_", |(name, _)| name);
        self.out.push_str(name);
    }

    /// Writes the derivation of a declarator in words, from the name outwards.
    fn derived(&mut self, declarator: &Declarator) {
        for (step, _) in &declarator.derived {
            match step {
                Derived::Pointer(qualifiers) => {
                    for (qualifier, _) in qualifiers {
                        let _ = write!(self.out, "{} ", word(qualifier));
                    }
                    self.out.push_str("pointer to ");
                }
                Derived::Array(length) => {
                    self.out.push_str("array[");
                    if let Some(length) = length {
                        self.expr(*length);
                    }
                    self.out.push_str("] of ");
                }
                Derived::ParamArray(qualifiers, length) => {
                    self.out.push_str("array[");
                    for (qualifier, _) in qualifiers {
                        let _ = write!(self.out, "{} ", word(qualifier));
                    }
                    if let Some(length) = length {
                        self.expr(*length);
                    }
                    self.out.push_str("] of ");
                }
                Derived::OldStyle(names) => {
                    let names: Vec<_> = names.iter().map(|(name, _)| &**name).collect();
                    let _ = write!(self.out, "function({}) to ", names.join(", "));
                }
                Derived::Function(params) => {
                    self.out.push_str("function(");
                    for (i, param) in params.list.iter().enumerate() {
                        self.out.push_str(if i > 0 { ", " } else { "" });
                        self.declarator(&param.declarator);
                        self.out.push_str(": ");
                        self.derived(&param.declarator);
                        self.specs(&param.specs);
                    }
                    self.out.push_str(if params.variadic {
                        ", ...) to "
                    } else {
                        ") to "
                    });
                }
            }
        }
    }

    fn specs(&mut self, specs: &Specs) {
        for (i, (spec, _)) in specs.list.iter().enumerate() {
            self.out.push_str(if i > 0 { " " } else { "" });
            match spec {
                Spec::Storage(storage) => self.out.push_str(&word(storage)),
                Spec::Inline => self.out.push_str("inline"),
                Spec::Noreturn => self.out.push_str("noreturn"),
                Spec::Qualifier(qualifier) => self.out.push_str(&word(qualifier)),
                Spec::Keyword(keyword) => self.out.push_str(&word(keyword)),
                Spec::Named(name) => self.out.push_str(name),
                Spec::Record(record) => self.record(record),
                Spec::Enum(spec) => self.enumeration(spec),
                Spec::Attributes(list) => list.iter().for_each(|a| self.attribute(a)),
                Spec::TypeofExpr(e) => self.form("typeof", &[*e]),
                Spec::TypeofType(name) => self.of_type("typeof", name),
            }
        }
    }

    fn attribute(&mut self, attribute: &Attribute) {
        let _ = write!(self.out, " (attribute {}", attribute.name);
        for &arg in &attribute.args {
            self.out.push(' ');
            self.expr(arg);
        }
        self.out.push(')');
    }

    fn record(&mut self, record: &RecordSpec) {
        let kind = if record.union { "union" } else { "struct" };
        let tag = record.tag.as_ref().map_or("_", |(tag, _)| tag);
        let _ = write!(self.out, "{kind} {tag}");
        let Some(members) = &record.members else {
            return;
        };
        self.out.push_str(" {");
        for member in members {
            if member.declarators.is_empty() {
                self.out.push(' ');
                self.specs(&member.specs);
                self.out.push(';');
            }
            for item in &member.declarators {
                self.out.push(' ');
                self.declarator(&item.declarator);
                self.out.push_str(": ");
                self.derived(&item.declarator);
                self.specs(&member.specs);
                if let Some(width) = item.width {
                    self.out.push_str(" : ");
                    self.expr(width);
                }
                self.out.push(';');
            }
        }
        self.out.push_str(" }");
    }

    fn enumeration(&mut self, spec: &EnumSpec) {
        let tag = spec.tag.as_ref().map_or("_", |(tag, _)| tag);
        let _ = write!(self.out, "enum {tag}");
        let Some(constants) = &spec.constants else {
            return;
        };
        self.out.push_str(" {");
        for constant in constants {
            let _ = write!(self.out, " {}", constant.name);
            if let Some(value) = constant.value {
                self.out.push_str(" = ");
                self.expr(value);
            }
            self.out.push(',');
        }
        self.out.push_str(" }");
    }

    fn initialiser(&mut self, init: &Initialiser) {
        let list = match &init.kind {
            InitialiserKind::Expr(e) => return self.expr(*e),
            InitialiserKind::List(list) => list,
        };
        self.out.push('{');
        for (path, init) in list {
            self.out.push(' ');
            for designator in path {
                match designator {
                    Designator::Index(e) => {
                        self.out.push('[');
                        self.expr(*e);
                        self.out.push(']');
                    }
                    Designator::Range(first, last) => {
                        self.out.push('[');
                        self.expr(*first);
                        self.out.push_str(" ... ");
                        self.expr(*last);
                        self.out.push(']');
                    }
                    Designator::Member(name, _) => {
                        let _ = write!(self.out, ".{name}");
                    }
                }
            }
            self.out.push_str(if path.is_empty() { "" } else { " = " });
            self.initialiser(init);
            self.out.push(',');
        }
        self.out.push_str(" }");
    }

    fn type_name(&mut self, name: &TypeName) {
        self.derived(&name.declarator);
        self.specs(&name.specs);
    }

    /// `(head a b …)`.
    fn form(&mut self, head: &str, parts: &[ExprId]) {
        let _ = write!(self.out, "({head}");
        for &part in parts {
            self.out.push(' ');
            self.expr(part);
        }
        self.out.push(')');
    }

    /// `(head [type])`.
    fn of_type(&mut self, head: &str, name: &TypeName) {
        let _ = write!(self.out, "({head} [");
        self.type_name(name);
        self.out.push_str("])");
    }

    fn expr(&mut self, e: ExprId) {
        let unit = self.unit;
        match &unit.exprs[e].kind {
            ExprKind::Int(int) => {
                let unsigned = if int.unsigned { "u" } else { "" };
                let longs = "l".repeat(int.longs.into());
                let _ = write!(self.out, "{}{unsigned}{longs}", int.value);
            }
            ExprKind::Float(FloatConst::Single(bits)) => {
                let _ = write!(self.out, "{:?}f", f32::from_bits(*bits));
            }
            ExprKind::Float(
                FloatConst::Double { double: bits, .. }
                | FloatConst::LongDouble { double: bits, .. },
            ) => {
                let _ = write!(self.out, "{:?}", f64::from_bits(*bits));
            }
            ExprKind::Char(value) => {
                let _ = write!(self.out, "(char {value})");
            }
            ExprKind::Str(bytes) => {
                let _ = write!(self.out, "\"{}\"", bytes.escape_ascii());
            }
            ExprKind::WideStr(chars) => {
                let text: String = chars.iter().filter_map(|&c| char::from_u32(c)).collect();
                let _ = write!(self.out, "L\"{}\"", text.escape_default());
            }
            ExprKind::Name(name) => self.out.push_str(name),
            ExprKind::Call(callee, args) => {
                let parts: Vec<_> = std::iter::once(*callee).chain(args.clone()).collect();
                self.form("call", &parts);
            }
            ExprKind::Index(a, i) => self.form("index", &[*a, *i]),
            ExprKind::Member(a, name, _, arrow) => {
                let head = format!("{}{name}", if *arrow { "->" } else { "." });
                self.form(&head, &[*a]);
            }
            ExprKind::Prefix(op, a) => self.form(op.text(), &[*a]),
            ExprKind::Postfix(a, 1) => self.form("post++", &[*a]),
            ExprKind::Postfix(a, _) => self.form("post--", &[*a]),
            ExprKind::Cast(name, a) => {
                self.out.push_str("(cast [");
                self.type_name(name);
                self.out.push_str("] ");
                self.expr(*a);
                self.out.push(')');
            }
            ExprKind::SizeofExpr(a) => self.form("sizeof", &[*a]),
            ExprKind::SizeofType(name) => self.of_type("sizeof", name),
            ExprKind::AlignofType(name) => self.of_type("alignof", name),
            ExprKind::AlignofExpr(a) => self.form("alignof", &[*a]),
            ExprKind::SameType(names) => {
                self.out.push_str("(same-type [");
                self.type_name(&names.0);
                self.out.push_str("] [");
                self.type_name(&names.1);
                self.out.push_str("])");
            }
            ExprKind::VaArg(list, name) => {
                self.out.push_str("(va-arg [");
                self.type_name(name);
                self.out.push_str("] ");
                self.expr(*list);
                self.out.push(')');
            }
            ExprKind::Statements(body) => {
                self.out.push_str("(statements");
                self.end();
                self.indent += 1;
                self.nested(*body);
                self.indent -= 1;
                self.line(unit.stmts[*body].span, ")");
            }
            ExprKind::Generic(value, list) => {
                self.form("generic", &[*value]);
                for (name, e) in list {
                    match name {
                        Some(name) => self.of_type("when", name),
                        None => self.out.push_str("(default)"),
                    }
                    self.expr(*e);
                }
            }
            ExprKind::Otherwise(a, b) => self.form("?:", &[*a, *b]),
            ExprKind::Compound(name, init) => {
                self.out.push_str("(literal [");
                self.type_name(name);
                self.out.push_str("] ");
                self.initialiser(init);
                self.out.push(')');
            }
            ExprKind::Infix(..) => self.chain(e),
            ExprKind::Assign(None, a, v) => self.form("=", &[*a, *v]),
            ExprKind::Assign(Some(op), a, v) => self.form(&format!("{}=", op.text()), &[*a, *v]),
            ExprKind::Conditional(c, t, f) => self.form("?:", &[*c, *t, *f]),
            ExprKind::Error => self.out.push_str("(error)"),
        }
    }

    /// An infix expression, without recursion along its left side.
    fn chain(&mut self, e: ExprId) {
        let mut rights = Vec::new();
        let mut first = e;
        while let ExprKind::Infix(op, left, right) = self.unit.exprs[first].kind {
            rights.push((op, right));
            first = left;
        }
        for (op, _) in &rights {
            let _ = write!(self.out, "({} ", op.text());
        }
        self.expr(first);
        for (_, right) in rights.into_iter().rev() {
            self.out.push(' ');
            self.expr(right);
            self.out.push(')');
        }
    }

    /// A line of a word and an expression.
    fn with(&mut self, span: Span, text: &str, e: ExprId) {
        self.line(span, text);
        self.out.push(' ');
        self.expr(e);
        self.end();
    }

    fn plain(&mut self, span: Span, text: &str) {
        self.line(span, text);
        self.end();
    }

    fn stmt(&mut self, s: StmtId) {
        let unit = self.unit;
        let Stmt { kind, span, .. } = &unit.stmts[s];
        let span = *span;
        match kind {
            StmtKind::Empty => self.plain(span, "empty"),
            StmtKind::Declaration(declaration) => self.declaration(declaration),
            StmtKind::StaticAssert(assert) => self.static_assert(assert),
            StmtKind::Expr(e) => self.with(span, "do", *e),
            StmtKind::Block(list) => {
                self.plain(span, "block");
                list.iter().for_each(|&s| self.nested(s));
            }
            StmtKind::If(..) => self.if_chain(s),
            StmtKind::While(c, body) => {
                self.with(span, "while", *c);
                self.nested(*body);
            }
            StmtKind::DoWhile(body, c) => {
                self.with(span, "do-while", *c);
                self.nested(*body);
            }
            StmtKind::For(init, c, step, body) => {
                self.line(span, "for ");
                for part in [c, step] {
                    match part {
                        Some(e) => self.expr(*e),
                        None => self.out.push('_'),
                    }
                    self.out.push(' ');
                }
                self.out.pop();
                self.end();
                self.nested(*init);
                self.nested(*body);
            }
            StmtKind::Switch(e, body) => {
                self.with(span, "switch", *e);
                self.nested(*body);
            }
            StmtKind::Labelled(labels, body) => {
                for label in labels {
                    match label {
                        Label::Case(e, None, span) => self.with(*span, "case", *e),
                        Label::Case(e, Some(last), span) => {
                            self.with(*span, "case from", *e);
                            self.with(*span, "case to", *last);
                        }
                        Label::Default(span) => self.plain(*span, "default"),
                        Label::Named(name, span) => self.plain(*span, &format!("label {name}")),
                    }
                }
                self.stmt(*body);
            }
            StmtKind::Pragmas(pragmas, body) => {
                for (pragma, span) in pragmas {
                    self.plain(*span, &format!("pragma {}", word(pragma)));
                }
                self.stmt(*body);
            }
            StmtKind::Goto(name, _) => self.plain(span, &format!("goto {name}")),
            StmtKind::Break => self.plain(span, "break"),
            StmtKind::Continue => self.plain(span, "continue"),
            StmtKind::Return(Some(e)) => self.with(span, "return", *e),
            StmtKind::Return(None) => self.plain(span, "return"),
            StmtKind::Error => self.plain(span, "error"),
        }
    }

    /// An `if`, without recursion along `else if`.
    fn if_chain(&mut self, s: StmtId) {
        let mut next = Some(s);
        while let Some(s) = next {
            let Stmt { kind, span, .. } = &self.unit.stmts[s];
            let StmtKind::If(c, then, other) = kind else {
                self.nested(s);
                return;
            };
            self.with(*span, "if", *c);
            self.nested(*then);
            if other.is_some() {
                self.plain(*span, "else");
            }
            next = *other;
        }
    }
}

/// A unit variant's name in lower case.
fn word(value: &impl std::fmt::Debug) -> String {
    format!("{value:?}").to_lowercase()
}
