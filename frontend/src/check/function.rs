//! Function definitions, their parameters in the new style and the old.

use super::declarator::Base;
use super::link::Definition;
use super::{Checker, Context, Scope, Symbol};
use crate::ast::{self, Derived, Spec, Storage};
use crate::ctype::{QualType, Signature, Type, TypeId};
use crate::message::{DECLARATION, IMPLICIT_INT, MISSING_RETURN};
use crate::source::Name;
use crate::typed::*;
use srp_archdesc::diagnostic::Span;

impl Checker<'_> {
    /// A function definition.
    pub(super) fn function(&mut self, definition: &ast::FunctionDefinition) {
        let declarator = &definition.declarator;
        let Some((name, span)) = declarator.name.clone() else {
            return;
        };
        let base = self.result_type(&definition.specs, span);
        let written = self.declared_type(base.ty, declarator);
        let params = match declarator.derived.first() {
            Some((step @ (Derived::Function(_) | Derived::OldStyle(_)), _)) => step,
            _ => {
                if !self.is_error(written.ty) {
                    let text = format!("`{name}` has a body but is no function");
                    self.error(DECLARATION, span, text, "");
                }
                return;
            }
        };
        let storage = base.storage.map(|(storage, _)| storage);
        if let Some((storage @ (Storage::Typedef | Storage::Auto | Storage::Register), at)) =
            base.storage
        {
            let word = format!("{storage:?}").to_lowercase();
            self.error(
                DECLARATION,
                at,
                format!("a function cannot be `{word}`"),
                "",
            );
        }
        let mut ty = written.ty;
        let old_style = match params {
            Derived::OldStyle(names) => {
                let list = self.old_style(names, &definition.old_style);
                ty = self.old_style_type(ty, &list);
                Some(list)
            }
            _ => None,
        };
        let known = match self.types.get(ty) {
            Type::Function(signature) => Some(signature.clone()),
            _ => None,
        };
        let function = self.declare_function(&name, ty, storage, base.inline, span);
        if let Some(function) = function {
            self.functions[function].noinline |= base.noinline;
            let definition = Definition {
                span,
                unit: self.number,
                full: true,
            };
            self.define(Symbol::Function(function), &name, definition);
            // The body goes by its own parameters.
            if known.is_some() {
                self.functions[function].ty = ty;
            }
        }
        let result = known.as_ref().map_or(self.types.known.error, |s| s.result);
        if result != self.types.known.void && !self.is_error(result) {
            self.complete(result, span, "the result of a function");
        }
        self.body = Body::default();
        self.context = Context {
            result: Some(result),
            function: Some(name.clone()),
            variadic: known.is_some_and(|s| s.variadic),
            ..Context::default()
        };
        self.scopes.push(Scope::default());
        let first = match (old_style, params) {
            (Some(list), _) => self.old_style_params(list),
            (None, Derived::Function(params)) => self.named_params(params),
            _ => Vec::new(),
        };
        let body = self.function_body(&name, result, first, definition.body);
        if let Some(function) = function {
            self.functions[function].body = Some(body);
            self.functions[function].optional = self.in_library;
            self.functions[function].pos = self.sources.pos(span);
        }
    }

    /// Specifiers of a function definition; without a type it returns an `int`.
    fn result_type(&mut self, specs: &ast::Specs, span: Span) -> Base {
        let typed = specs.list.iter().any(|(spec, _)| {
            !matches!(
                spec,
                Spec::Storage(_)
                    | Spec::Inline
                    | Spec::Noreturn
                    | Spec::Qualifier(_)
                    | Spec::Attributes(_)
            )
        });
        if typed {
            return self.specs(specs, false);
        }
        self.warning(
            IMPLICIT_INT,
            span,
            "the function's result is not declared: `int`",
        );
        let mut specs = specs.clone();
        specs
            .list
            .push((Spec::Keyword(ast::TypeKeyword::Int), specs.span));
        self.specs(&specs, false)
    }

    /// Parameters that a declarator names and declarations before the body give types.
    fn old_style(
        &mut self,
        names: &[(Name, Span)],
        declarations: &[ast::Declaration],
    ) -> Vec<(Name, QualType, Span)> {
        let int = QualType::plain(self.types.known.int);
        let mut list: Vec<_> = names
            .iter()
            .map(|(name, span)| (name.clone(), None, *span))
            .collect();
        for declaration in declarations {
            let base = self.specs(&declaration.specs, false);
            for item in &declaration.declarators {
                let ty = self.declared_type(base.ty, &item.declarator);
                let ty = self.decayed(ty);
                let Some((name, span)) = &item.declarator.name else {
                    continue;
                };
                match list.iter_mut().find(|(known, ..)| known == name) {
                    Some((_, known @ None, _)) => *known = Some(ty),
                    Some((.., before)) => {
                        let before = *before;
                        self.redeclared(name, *span, before);
                    }
                    None => {
                        let text = format!("`{name}` is no parameter of the function");
                        self.error(DECLARATION, *span, text, "");
                    }
                }
            }
        }
        let typed = list.into_iter().map(|(name, ty, span)| match ty {
            Some(ty) => (name, ty, span),
            None => {
                let text = format!("the parameter `{name}` is not declared: `int`");
                self.warning(IMPLICIT_INT, span, text);
                (name, int, span)
            }
        });
        typed.collect()
    }

    /// The type of an old-style function by what it takes: promoted arguments.
    fn old_style_type(&mut self, ty: TypeId, params: &[(Name, QualType, Span)]) -> TypeId {
        let Type::Function(signature) = self.types.get(ty).clone() else {
            return ty;
        };
        let params = params.iter().map(|(_, ty, _)| self.passed_type(ty.ty));
        let signature = Signature {
            params: params.collect(),
            ..signature
        };
        self.types.id(Type::Function(signature))
    }

    /// The type as which a value is passed where no parameter's type says it.
    fn passed_type(&self, ty: TypeId) -> TypeId {
        match self.types.get(ty) {
            Type::Float => self.types.known.double,
            _ => self.promoted(ty),
        }
    }

    /// Makes variables of old-style parameters, which begin as what was passed, converted.
    fn old_style_params(&mut self, list: Vec<(Name, QualType, Span)>) -> Vec<StmtId> {
        let mut first = Vec::new();
        for (name, ty, span) in list {
            if !self.is_error(ty.ty) {
                self.complete(ty.ty, span, "a parameter");
            }
            let passed = self.passed_type(ty.ty);
            let local = self.new_local(&name, ty);
            self.declare(&name, Symbol::Local(local), span);
            if passed == ty.ty {
                self.body.params.push(local);
                continue;
            }
            let from = self.new_local(&name, QualType::plain(passed));
            self.body.params.push(from);
            let place = self.place(PlaceKind::Local(from), QualType::plain(passed), span);
            let value = self.read_place(place);
            let value = self.convert(value, ty.ty);
            let init = Init {
                zero: false,
                parts: vec![Part {
                    offset: 0,
                    bits: None,
                    value,
                }],
            };
            first.push(self.stmt_at(StmtKind::Init(local, init), span));
        }
        first
    }

    pub(super) fn new_local(&mut self, name: &Name, ty: QualType) -> LocalId {
        self.body.locals.push(Local {
            name: name.clone(),
            ty,
            in_memory: false,
            align: 1,
        })
    }

    /// Makes variables of the parameters of a function.
    fn named_params(&mut self, params: &ast::Params) -> Vec<StmtId> {
        for (ty, param) in self.params(params) {
            if !self.is_error(ty.ty) {
                self.complete(ty.ty, param.span, "a parameter");
            }
            let (name, span) = match &param.declarator.name {
                Some((name, span)) => (name.clone(), *span),
                None => {
                    // A parameter without a name is not used.
                    let local = self.new_local(&"unnamed".into(), ty);
                    self.body.params.push(local);
                    continue;
                }
            };
            let local = self.new_local(&name, ty);
            self.body.params.push(local);
            self.declare(&name, Symbol::Local(local), span);
        }
        Vec::new()
    }

    /// The statements of a function, in the scope of its parameters, after what they begin with.
    fn function_body(
        &mut self,
        name: &Name,
        result: TypeId,
        first: Vec<StmtId>,
        root: ast::StmtId,
    ) -> Body {
        let errors = self.messages.errors();
        let (mut root_stmt, flow) = self.function_block(root);
        let span = self.unit.stmts[root].span;
        if !first.is_empty() {
            let all = first.into_iter().chain([root_stmt]).collect();
            root_stmt = self.stmt_at(StmtKind::Block(all), span);
        }
        self.end_labels();
        self.close_scope();
        let returns = result != self.types.known.void && !self.is_error(result);
        let sound = self.messages.errors() == errors;
        if flow && returns && sound && &**name != "main" {
            let end = Span::new(span.end.saturating_sub(1), span.end);
            let text = format!("`{name}` may end without returning a value");
            let message = self.sources.warning(MISSING_RETURN, end, text, "");
            let message = message.note("the value is then 0");
            self.messages.push(message);
        }
        self.body.root = Some(root_stmt);
        self.context = Context::default();
        std::mem::take(&mut self.body)
    }
}
