//! Declarations and function definitions.

use super::attribute::noinline;
use super::declarator::Base;
use super::link::Definition;
use super::{Checker, Symbol};
use crate::ast::{self, InitDeclarator, Spec, Storage};
use crate::ctype::{QualType, Type, TypeId};
use crate::message::{BAD_TYPE, DECLARATION, INITIALISER, LIBRARY_TYPE, REDECLARED, STATIC_ASSERT};
use crate::source::Name;
use crate::typed::*;
use srp_archdesc::diagnostic::Span;
use srp_archdesc::entity::Entity;

impl Checker<'_> {
    /// Puts a name into the innermost scope; an error where it is there already.
    pub(super) fn declare(&mut self, name: &Name, symbol: Symbol, span: Span) {
        let before = self.scope().names.insert(name.clone(), (symbol, span));
        if let Some((_, before)) = before {
            self.redeclared(name, span, before);
        }
    }

    pub(super) fn redeclared(&mut self, name: &str, span: Span, before: Span) {
        let text = format!("`{name}` is declared a second time");
        let message = self.sources.error(REDECLARED, span, text, "");
        let message = self.sources.also(message, before, "declared here");
        self.messages.push(message);
    }

    /// A declaration; the statements that set its variables.
    pub(super) fn declaration(&mut self, declaration: &ast::Declaration) -> Vec<StmtId> {
        // `__attribute__((fallthrough));` declares nothing.
        let mut specs = declaration.specs.list.iter();
        if declaration.declarators.is_empty()
            && specs.all(|(spec, _)| matches!(spec, Spec::Attributes(_)))
        {
            return Vec::new();
        }
        let base = self.specs(&declaration.specs, declaration.declarators.is_empty());
        let enumeration = self.enumeration_of(&declaration.specs);
        let items = declaration.declarators.iter();
        items
            .filter_map(|item| {
                let made = self.declarator(base, item);
                if let (Some((_, span)), Some(enumeration)) = (&item.declarator.name, enumeration) {
                    self.enumerations.insert(*span, enumeration);
                }
                made
            })
            .collect()
    }

    fn declarator(&mut self, base: Base, item: &InitDeclarator) -> Option<StmtId> {
        let (name, span) = item.declarator.name.clone()?;
        let (lane, align) = self.attributed(base.ty.ty, &item.attributes);
        let align = align.max(base.align);
        let base_ty = QualType {
            ty: lane,
            quals: base.ty.quals,
        };
        let ty = self.declared_type(base_ty, &item.declarator);
        let storage = base.storage.map(|(storage, _)| storage);
        if storage == Some(Storage::Typedef) {
            self.align_typedef(ty.ty, align, span);
            self.declare_type(&name, ty, span, item.init.as_ref());
            return None;
        }
        if let Type::Function(_) = self.types.get(ty.ty) {
            if let Some(init) = &item.init {
                let text = "a function has no initial value";
                self.error(DECLARATION, init.span, text, "");
            }
            let function = self.declare_function(&name, ty.ty, storage, base.inline, span);
            if let Some(function) = function {
                self.functions[function].noinline |= base.noinline || noinline(&item.attributes);
            }
            return None;
        }
        if self.is_error(ty.ty) {
            // The name is known from here on, so that its uses are no further mistakes.
            if let Some(init) = &item.init {
                self.look_at(init);
            }
            self.declare_erroneous(&name, span);
            return None;
        }
        if ty.quals.global {
            let text = format!("`{name}` cannot lie in system memory");
            let help = "`__srp_global` is for what a pointer points to";
            self.error_help(BAD_TYPE, span, text, help);
        }
        if self.at_file_level() || matches!(storage, Some(Storage::Static | Storage::Extern)) {
            self.declare_object(&name, ty, storage, span, item);
            if let Some((Symbol::Object(object), _)) = self.lookup(&name) {
                let known = &mut self.objects[object].align;
                *known = align.max(*known);
            }
            None
        } else {
            if self.types.align(ty.ty).max(align) > MAX_LOCAL_ALIGN {
                let text = format!(
                    "a variable of a function is aligned to at most {MAX_LOCAL_ALIGN} bytes"
                );
                self.error(BAD_TYPE, span, text, "");
            }
            self.declare_local(&name, ty, align, span, item)
        }
    }

    /// Checks the expressions of an initialiser whose object has no type.
    fn look_at(&mut self, init: &ast::Initialiser) {
        match &init.kind {
            ast::InitialiserKind::Expr(e) => {
                self.value(*e);
            }
            ast::InitialiserKind::List(list) => {
                list.iter().for_each(|(_, init)| self.look_at(init));
            }
        }
    }

    fn declare_erroneous(&mut self, name: &Name, span: Span) {
        let ty = QualType::plain(self.types.known.error);
        let local = self.body.locals.push(Local {
            name: name.clone(),
            ty,
            in_memory: false,
            align: 1,
        });
        let symbol = if self.at_file_level() {
            Symbol::Object(self.new_object(name, ty, span))
        } else {
            Symbol::Local(local)
        };
        self.scope().names.insert(name.clone(), (symbol, span));
        if let Symbol::Object(object) = symbol {
            self.objects[object].defined = true;
        }
    }

    fn declare_type(
        &mut self,
        name: &Name,
        ty: QualType,
        span: Span,
        init: Option<&ast::Initialiser>,
    ) {
        if let Some(init) = init {
            self.error(DECLARATION, init.span, "a type has no initial value", "");
        }
        let built_in = self.at_file_level() && self.scopes[0].names.contains_key(name);
        let before = self.scope().names.get(name).copied();
        let before = before.or(built_in.then(|| self.scopes[0].names[name]));
        match before {
            Some((Symbol::Typedef(old), _))
                if old.quals == ty.quals && self.types.compatible(old.ty, ty.ty) => {}
            Some((_, at)) => self.redeclared(name, span, at),
            None => {
                let symbol = (Symbol::Typedef(ty), span);
                self.scope().names.insert(name.clone(), symbol);
            }
        }
    }

    fn new_object(&mut self, name: &str, ty: QualType, span: Span) -> ObjectId {
        self.objects.push(Object {
            name: name.to_owned(),
            ty,
            image: Image::default(),
            defined: false,
            optional: self.in_library,
            align: 1,
            pos: self.sources.pos(span),
        })
    }

    /// The thing of this name that a declaration in this scope declares again: one of the scope
    /// itself, or one with linkage.
    fn earlier(&mut self, name: &Name, internal: bool) -> Option<(Symbol, Span)> {
        if let Some(&found) = self.scope().names.get(name) {
            return Some(found);
        }
        if let Some((symbol @ (Symbol::Object(_) | Symbol::Function(_)), at)) =
            self.scopes[1].names.get(name).copied()
        {
            return Some((symbol, at));
        }
        if internal {
            return None;
        }
        let external = self.externals.names.get(name).copied();
        // What a program defines itself is not the library's.
        let external = external.filter(|symbol| {
            !self.owned.contains(name)
                || self.in_library
                || match symbol {
                    Symbol::Object(object) => object.index() >= self.library_end.0,
                    Symbol::Function(function) => function.index() >= self.library_end.1,
                    _ => true,
                }
        });
        external.map(|symbol| (symbol, self.definition_span(symbol)))
    }

    fn definition_span(&self, symbol: Symbol) -> Span {
        let found = match symbol {
            Symbol::Object(object) => self.externals.objects.get(&object),
            Symbol::Function(function) => self.externals.functions.get(&function),
            _ => None,
        };
        found.map_or(Span::default(), |definition| definition.span)
    }

    fn declare_object(
        &mut self,
        name: &Name,
        ty: QualType,
        storage: Option<Storage>,
        span: Span,
        item: &InitDeclarator,
    ) {
        let internal = storage == Some(Storage::Static);
        let local_static = internal && !self.at_file_level();
        let object = if local_static {
            let function = self.context.function.clone().unwrap_or_else(|| "".into());
            let object = self.new_object(&format!("{function}.{name}"), ty, span);
            self.declare(name, Symbol::Object(object), span);
            object
        } else {
            match self.earlier(name, internal) {
                Some((Symbol::Object(object), before)) => {
                    let old = self.objects[object].ty;
                    let merged = self.same_declaration(name, old.ty, ty.ty, span, before);
                    self.objects[object].ty.ty = merged;
                    object
                }
                Some((_, before)) => return self.redeclared(name, span, before),
                None => self.new_object(name, ty, span),
            }
        };
        if !local_static {
            let symbol = Symbol::Object(object);
            self.scope().names.insert(name.clone(), (symbol, span));
            let known_internal = self.is_internal(symbol);
            if !internal && !known_internal {
                self.externals.names.insert(name.clone(), symbol);
            } else if !known_internal {
                self.internal(symbol, name, span);
            }
        }
        let tentative = storage != Some(Storage::Extern);
        if let Some(init) = &item.init {
            if storage == Some(Storage::Extern) && !self.at_file_level() {
                let text = "an `extern` declaration in a block has no initial value";
                self.error(DECLARATION, init.span, text, "");
            }
            self.define_object(object, name, init, span);
        } else if tentative {
            if local_static {
                self.complete(ty.ty, span, "a variable");
            }
            let definition = Definition {
                span,
                unit: self.number,
                full: local_static,
            };
            self.define(Symbol::Object(object), name, definition);
            self.objects[object].pos = self.sources.pos(span);
        }
    }

    /// True if a symbol of this source has internal linkage.
    fn is_internal(&self, symbol: Symbol) -> bool {
        match symbol {
            Symbol::Function(function) => self.functions[function].internal,
            Symbol::Object(object) => {
                let name = self.objects[object].name.as_str();
                let defined = self.externals.objects.contains_key(&object);
                let external = self.externals.names.get(name);
                let same = matches!(external, Some(Symbol::Object(o)) if *o == object);
                defined && !same
            }
            _ => false,
        }
    }

    /// A thing becomes internal, which it cannot once it is external.
    fn internal(&mut self, symbol: Symbol, name: &str, span: Span) {
        let external = match (symbol, self.externals.names.get(name)) {
            (Symbol::Object(a), Some(Symbol::Object(b))) => a == *b,
            (Symbol::Function(a), Some(Symbol::Function(b))) => a == *b,
            _ => false,
        };
        if external {
            let text = format!("`{name}` is `static` here and was not before");
            self.error(REDECLARED, span, text, "");
        }
    }

    fn define_object(&mut self, object: ObjectId, name: &str, init: &ast::Initialiser, span: Span) {
        let ty = self.objects[object].ty;
        let definition = Definition {
            span,
            unit: self.number,
            full: true,
        };
        self.define(Symbol::Object(object), name, definition);
        self.objects[object].pos = self.sources.pos(span);
        let function = self.context.function.take();
        let known = self.initialise(ty, init, span);
        self.context.function = function;
        if let Some((ty, parts)) = known {
            self.objects[object].ty = ty;
            self.objects[object].image = self.image(ty.ty, &parts);
        }
    }

    fn declare_local(
        &mut self,
        name: &Name,
        ty: QualType,
        align: u32,
        span: Span,
        item: &InitDeclarator,
    ) -> Option<StmtId> {
        let local = self.new_local(name, ty);
        self.body.locals[local].align = align;
        self.declare(name, Symbol::Local(local), span);
        let scalar = self.types.is_scalar(ty.ty) && !self.is_error(ty.ty);
        let Some(init) = &item.init else {
            self.complete(ty.ty, span, "a variable");
            if scalar {
                self.note_unset(local);
            }
            return None;
        };
        // `int x = x;` is how programs keep compilers from warning.
        let itself = matches!(init.kind, ast::InitialiserKind::Expr(e)
            if matches!(&self.unit.exprs[e].kind, ast::ExprKind::Name(own) if own == name));
        if scalar && !itself {
            self.note_unset(local);
        }
        let known = self.initialise(ty, init, span);
        self.context.unset.remove(&local);
        let (ty, parts) = known?;
        if self.reaches_past_end(ty.ty, &parts) {
            let text = "only a static object has values for a member of unknown length";
            self.error(INITIALISER, span, text, "");
            return None;
        }
        self.body.locals[local].ty = ty;
        Some(self.stmt_at(StmtKind::Init(local, parts), span))
    }

    pub(super) fn declare_function(
        &mut self,
        name: &Name,
        ty: TypeId,
        storage: Option<Storage>,
        inline: bool,
        span: Span,
    ) -> Option<FunctionId> {
        if !self.at_file_level() && storage == Some(Storage::Static) {
            let text = "a function in a block cannot be `static`";
            self.error(DECLARATION, span, text, "");
        }
        // An `inline` function without `extern` is one of its source alone.
        let internal =
            storage == Some(Storage::Static) || inline && storage != Some(Storage::Extern);
        let function = match self.earlier(name, internal) {
            Some((Symbol::Function(function), before)) => {
                let old = self.functions[function].ty;
                // The library's own type of a function of the library is the right one.
                if !self.functions[function].optional || self.types.compatible(old, ty) {
                    let merged = self.same_declaration(name, old, ty, span, before);
                    self.functions[function].ty = merged;
                } else {
                    let text = format!("the library's `{name}` is {}", self.show(old));
                    self.warning(LIBRARY_TYPE, span, text);
                }
                if storage == Some(Storage::Static) && !self.functions[function].internal {
                    self.internal(Symbol::Function(function), name, span);
                }
                function
            }
            Some((_, before)) => {
                self.redeclared(name, span, before);
                return None;
            }
            None => {
                let function = self.functions.push(Function {
                    name: name.to_string(),
                    ty,
                    body: None,
                    internal,
                    optional: false,
                    noinline: false,
                    pos: self.sources.pos(span),
                });
                if !internal {
                    let symbol = Symbol::Function(function);
                    self.externals.names.insert(name.clone(), symbol);
                }
                function
            }
        };
        let symbol = Symbol::Function(function);
        self.scope().names.insert(name.clone(), (symbol, span));
        Some(function)
    }

    pub(super) fn static_assert(&mut self, assert: &ast::StaticAssert) {
        let holds = self.const_int(assert.condition, "the condition");
        if let Some((0, _)) = holds {
            let text = match &assert.text {
                Some(text) => format!("assertion failed: {}", String::from_utf8_lossy(text)),
                None => "assertion failed".to_owned(),
            };
            let span = self.unit.exprs[assert.condition].span;
            self.error(STATIC_ASSERT, span, text, "");
        }
    }
}
