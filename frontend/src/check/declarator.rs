//! Types from specifiers and declarators.

use super::attribute::noinline;
use super::{Checker, Operand, Symbol};
use crate::ast;
use crate::ast::{
    Declarator, Derived, Param, Params, Qualifier, Spec, Specs, Storage, TypeKeyword,
};
use crate::ctype::{self, MAX_TYPE_DEPTH, QualType, Quals, Signature, Type, TypeId};
use crate::message::{
    BAD_TYPE, DECLARATION, DOUBLE_AS_FLOAT, IMPLICIT_INT, LIMIT, NOT_CONSTANT, SPECIFIERS,
    UNDECLARED, UNSUPPORTED, VOLATILE,
};
use crate::source::Name;
use srp_archdesc::diagnostic::Span;

/// The meaning of a list of specifiers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Base {
    pub(super) ty: QualType,
    pub(super) storage: Option<(Storage, Span)>,
    pub(super) inline: bool,
    pub(super) noinline: bool,
    /// The alignment asked for, bytes, or 1.
    pub(super) align: u32,
}

/// How often each keyword is written.
#[derive(Default)]
struct Keywords {
    count: [u8; 10],
}

impl Keywords {
    fn of(&self, keyword: TypeKeyword) -> u8 {
        self.count[keyword as usize]
    }

    fn any(&self) -> bool {
        self.count.iter().any(|&n| n > 0)
    }
}

/// The type that keywords name together.
fn named(keywords: &Keywords) -> Option<Type> {
    use TypeKeyword::*;
    let n = |keyword| keywords.of(keyword);
    let alone = |keyword| n(keyword) == 1 && keywords.count.iter().sum::<u8>() == 1;
    let (signed, unsigned) = (n(Signed), n(Unsigned));
    let bases = n(Void) + n(Char) + n(Float) + n(Double) + n(Bool);
    if n(Double) == 1 && n(Long) <= 1 && bases == 1 && signed + unsigned + n(Short) == 0 {
        return Some(Type::Double).filter(|_| n(Int) == 0);
    }
    if [Void, Float, Bool].into_iter().any(&alone) {
        return Some(match () {
            () if n(Void) == 1 => Type::Void,
            () if n(Float) == 1 => Type::Float,
            () => Type::Bool,
        });
    }
    if signed + unsigned > 1 || n(Int) > 1 || n(Short) > 1 || n(Char) > 1 {
        return None;
    }
    if n(Void) + n(Float) + n(Double) + n(Bool) > 0 {
        return None;
    }
    let int = match (n(Char), n(Short), n(Long), n(Int), unsigned == 1) {
        (1, 0, 0, 0, true) => ctype::Int::UChar,
        (1, 0, 0, 0, false) if signed == 1 => ctype::Int::SChar,
        (1, 0, 0, 0, false) => ctype::Int::Char,
        (0, 1, 0, _, true) => ctype::Int::UShort,
        (0, 1, 0, _, false) => ctype::Int::Short,
        (0, 0, 1, _, true) => ctype::Int::ULong,
        (0, 0, 1, _, false) => ctype::Int::Long,
        (0, 0, 2, _, true) => ctype::Int::ULongLong,
        (0, 0, 2, _, false) => ctype::Int::LongLong,
        (0, 0, 0, _, true) => ctype::Int::UInt,
        (0, 0, 0, _, false) => ctype::Int::Int,
        _ => return None,
    };
    Some(Type::Int(int))
}

impl Checker<'_> {
    /// Checks specifiers and returns their meaning. `alone`: nothing is declared but a tag.
    pub(super) fn specs(&mut self, specs: &Specs, alone: bool) -> Base {
        let mut keywords = Keywords::default();
        let mut whole: Option<QualType> = None;
        let mut quals = Quals::NONE;
        let (mut storage, mut inline) = (None, false);
        let mut conflict = false;
        let mut attributes = Vec::new();
        for (i, (spec, span)) in specs.list.iter().enumerate() {
            let before = i.checked_sub(1).map(|i| &specs.list[i].0);
            let own_record = match (before, whole) {
                (Some(Spec::Record(spec)), Some(ty)) if spec.members.is_some() => {
                    match self.types.get(ty.ty) {
                        Type::Record(record) => Some(*record),
                        _ => None,
                    }
                }
                _ => None,
            };
            match spec {
                Spec::Storage(found) => {
                    if storage.replace((*found, *span)).is_some() {
                        self.error(SPECIFIERS, *span, "a second storage class", "");
                    }
                }
                Spec::Inline => inline = true,
                Spec::Noreturn => {}
                Spec::Qualifier(qualifier) => {
                    if *qualifier == Qualifier::Volatile && !self.told_volatile {
                        self.told_volatile = true;
                        let text = "`volatile` keeps no access: nothing else reads or writes the memory of a \
                                    program that computes";
                        self.warning(VOLATILE, *span, text);
                    }
                    qualify(&mut quals, *qualifier);
                }
                Spec::Keyword(keyword) => {
                    let count = &mut keywords.count[*keyword as usize];
                    *count = count.saturating_add(1);
                }
                // After the members of a struct they are its own.
                Spec::Attributes(list) => match own_record {
                    Some(record) => self.align_record(record, list),
                    None => attributes.extend(list.iter().cloned()),
                },
                Spec::Named(_)
                | Spec::Record(_)
                | Spec::Enum(_)
                | Spec::TypeofExpr(_)
                | Spec::TypeofType(_) => {
                    let ty = match spec {
                        Spec::Named(name) => self.typedef(name, *span),
                        Spec::Record(record) => QualType::plain(self.record(record, *span, alone)),
                        Spec::Enum(spec) => QualType::plain(self.enumeration(spec, *span)),
                        Spec::TypeofExpr(e) => {
                            let operand = self.unevaluated(*e);
                            match operand {
                                Operand::Place(place) => self.body.places[place].ty,
                                _ => QualType::plain(self.operand_type(operand)),
                            }
                        }
                        Spec::TypeofType(name) => self.type_name(name),
                        _ => QualType::plain(self.types.known.error),
                    };
                    conflict |= whole.replace(ty).is_some();
                }
            }
        }
        let implicit = !keywords.any() && whole.is_none() && !alone && !specs.list.is_empty();
        if implicit {
            let text = "the type is not declared: `int`";
            self.warning(IMPLICIT_INT, specs.span, text);
            keywords.count[TypeKeyword::Int as usize] = 1;
        }
        let base = self.base_type(&keywords, whole, conflict, specs.span);
        let (ty, align) = self.attributed(base.ty, &attributes);
        let quals = base.quals.and(quals);
        Base {
            ty: self.types.qualified(QualType { ty, quals }),
            storage,
            inline,
            noinline: noinline(&attributes),
            align,
        }
    }

    fn base_type(
        &mut self,
        keywords: &Keywords,
        whole: Option<QualType>,
        conflict: bool,
        span: Span,
    ) -> QualType {
        let error = QualType::plain(self.types.known.error);
        if let Some(whole) = whole {
            if conflict || keywords.any() {
                self.error(SPECIFIERS, span, "two types where one is wanted", "");
                return error;
            }
            return whole;
        }
        if !keywords.any() {
            let text = "the declaration names no type";
            self.error(SPECIFIERS, span, text, "");
            return error;
        }
        match named(keywords) {
            Some(Type::Double) if self.double_is_float => {
                self.note(
                    DOUBLE_AS_FLOAT,
                    span,
                    "`double` is `float` here, as asked for",
                );
                QualType::plain(self.types.known.float)
            }
            Some(ty) => QualType::plain(self.types.id(ty)),
            None => {
                self.error(SPECIFIERS, span, "these words together name no type", "");
                error
            }
        }
    }

    fn typedef(&mut self, name: &str, span: Span) -> QualType {
        match self.lookup(name) {
            Some((Symbol::Typedef(ty), _)) => ty,
            _ => {
                let text = format!("`{name}` is not declared as a type");
                let advice = self.advice_for_type(name);
                self.error_advice(UNDECLARED, span, text, advice);
                QualType::plain(self.types.known.error)
            }
        }
    }

    /// The type that a declarator derives.
    pub(super) fn declared_type(&mut self, base: QualType, declarator: &Declarator) -> QualType {
        let mut ty = base;
        for (step, span) in declarator.derived.iter().rev() {
            if self.is_error(ty.ty) {
                // Lengths and parameters are still looked at for their own mistakes.
                if let Derived::Function(params) = step {
                    self.params(params);
                }
                continue;
            }
            ty = match step {
                Derived::Pointer(qualifiers) => {
                    let mut quals = Quals::NONE;
                    for (qualifier, _) in qualifiers {
                        qualify(&mut quals, *qualifier);
                    }
                    QualType {
                        ty: self.types.pointer(ty),
                        quals,
                    }
                }
                Derived::Array(length) => self.array(ty, *length, *span),
                Derived::ParamArray(..) => {
                    let text = "`static`, `*` and qualifiers stand in the outermost brackets of a \
                                parameter only";
                    self.error(BAD_TYPE, *span, text, "");
                    QualType::plain(self.types.known.error)
                }
                Derived::Function(params) => self.function_type(ty, params, *span),
                Derived::OldStyle(_) => {
                    let open = Params {
                        list: Vec::new(),
                        variadic: false,
                    };
                    self.function_type(ty, &open, *span)
                }
            };
            if self.types.depth(ty.ty) > MAX_TYPE_DEPTH {
                let text = format!("the type is derived in more than {MAX_TYPE_DEPTH} steps");
                self.error(LIMIT, *span, text, "");
                ty = QualType::plain(self.types.known.error);
            }
        }
        ty
    }

    fn array(&mut self, of: QualType, length: Option<ast::ExprId>, span: Span) -> QualType {
        let error = QualType::plain(self.types.known.error);
        if self.types.size(of.ty).is_none() {
            let text = format!("there is no array of {}", self.show(of.ty));
            self.error(BAD_TYPE, span, text, "");
            return error;
        }
        let length = match length {
            None => None,
            Some(e) => {
                let at = self.unit.exprs[e].span;
                let advice = "arrays of variable length are not supported: take the largest length, by `#define` or `enum`";
                match self.const_int_or(e, "the length of an array", Some(advice)) {
                    None => return error,
                    Some((length, _)) if length < 0 => {
                        self.error(BAD_TYPE, at, "the length of an array is negative", "");
                        return error;
                    }
                    Some((length, _)) => Some(u32::try_from(length).unwrap_or(u32::MAX)),
                }
            }
        };
        let ty = self.types.id(Type::Array(of, length));
        let too_large = |size: Option<u32>| size.is_none_or(|size| size > i32::MAX as u32);
        if length.is_some() && too_large(self.types.size(ty)) {
            self.error(LIMIT, span, "the array is larger than memory", "");
            return error;
        }
        QualType::plain(ty)
    }

    fn function_type(&mut self, result: QualType, params: &Params, span: Span) -> QualType {
        if let Type::Array(..) | Type::Function(_) = self.types.get(result.ty) {
            let text = format!("a function cannot return {}", self.show(result.ty));
            self.error(BAD_TYPE, span, text, "");
            return QualType::plain(self.types.known.error);
        }
        let (variadic, open) = (params.variadic, params.list.is_empty());
        let params = self.params(params);
        let signature = Signature {
            result: result.ty,
            params: params.into_iter().map(|(ty, _)| ty.ty).collect(),
            variadic,
            open: open && !variadic,
        };
        QualType::plain(self.types.id(Type::Function(signature)))
    }

    /// Types of parameters, with the parameters as written.
    pub(super) fn params<'p>(&mut self, params: &'p Params) -> Vec<(QualType, &'p Param)> {
        if let [only] = params.list.as_slice() {
            let nothing = only.declarator.derived.is_empty() && only.declarator.name.is_none();
            let void = matches!(
                only.specs.list.as_slice(),
                [(Spec::Keyword(TypeKeyword::Void), _)]
            );
            if nothing && void {
                return Vec::new();
            }
        }
        self.scopes.push(super::Scope::default());
        let mut list = Vec::new();
        for param in &params.list {
            let base = self.specs(&param.specs, false);
            match base.storage {
                None | Some((Storage::Register, _)) => {}
                Some((_, span)) => {
                    let text = "a parameter has no storage class but `register`";
                    self.error(DECLARATION, span, text, "");
                }
            }
            self.no_alignment(base.align, param.span);
            // The length of an array as a parameter says nothing: it is a pointer.
            let mut declarator = param.declarator.clone();
            let mut quals = Quals::NONE;
            if let Some((first, _)) = declarator.derived.first_mut()
                && let Derived::ParamArray(qualifiers, length) = first
            {
                for (qualifier, _) in qualifiers {
                    qualify(&mut quals, *qualifier);
                }
                *first = Derived::Array(*length);
            }
            if let Some((Derived::Array(length), _)) = declarator.derived.first_mut()
                && let Some(length) = length.take()
                && self.has_effect(length)
            {
                let at = self.unit.exprs[length].span;
                let text = "the length of a parameter that is an array is not computed";
                self.error(UNSUPPORTED, at, text, "");
            }
            let ty = match self.length_by(&declarator, &list) {
                Some(at) => {
                    let text = "the length of an array must be an integer constant";
                    let help = "arrays of variable length are not supported, also as parameters";
                    self.error(NOT_CONSTANT, at, text, help);
                    QualType::plain(self.types.known.error)
                }
                None => self.declared_type(base.ty, &declarator),
            };
            let mut ty = self.decayed(ty);
            ty.quals = ty.quals.and(quals);
            if ty.ty == self.types.known.void {
                self.error(BAD_TYPE, param.span, "a parameter cannot be `void`", "");
                ty = QualType::plain(self.types.known.error);
            }
            list.push((ty, param));
        }
        self.close_scope();
        list
    }

    /// The length of an array in a declarator that an earlier parameter says.
    fn length_by(&self, declarator: &Declarator, earlier: &[(QualType, &Param)]) -> Option<Span> {
        let is_earlier = |name: &Name| {
            let mut names = earlier
                .iter()
                .filter_map(|(_, p)| p.declarator.name.as_ref());
            names.any(|(known, _)| known == name)
        };
        let lengths = declarator
            .derived
            .iter()
            .filter_map(|(step, _)| match step {
                Derived::Array(length) => *length,
                _ => None,
            });
        let named = |e: ast::ExprId| match &self.unit.exprs[e].kind {
            ast::ExprKind::Name(name) if is_earlier(name) => Some(self.unit.exprs[e].span),
            _ => None,
        };
        lengths.filter_map(named).next()
    }

    /// True if an expression may do more than compute a value.
    fn has_effect(&self, e: ast::ExprId) -> bool {
        use ast::ExprKind as K;
        match &self.unit.exprs[e].kind {
            K::Assign(..) | K::Postfix(..) | K::Call(..) | K::Statements(_) | K::VaArg(..) => true,
            K::Prefix(ast::Prefix::Increment | ast::Prefix::Decrement, _) => true,
            K::Prefix(_, a) | K::Cast(_, a) | K::Member(a, ..) => self.has_effect(*a),
            K::Infix(_, a, b) | K::Index(a, b) | K::Otherwise(a, b) => {
                self.has_effect(*a) || self.has_effect(*b)
            }
            K::Conditional(c, a, b) => [c, a, b].into_iter().any(|&e| self.has_effect(e)),
            _ => false,
        }
    }

    /// The type that a type's name names.
    pub(super) fn type_name(&mut self, name: &ast::TypeName) -> QualType {
        let base = self.specs(&name.specs, false);
        if let Some((_, span)) = base.storage {
            self.error(SPECIFIERS, span, "a type's name has no storage class", "");
        }
        self.no_alignment(base.align, name.span);
        self.declared_type(base.ty, &name.declarator)
    }

    /// True if an object can have this type; reports an error if not.
    pub(super) fn complete(&mut self, ty: TypeId, span: Span, what: &str) -> bool {
        if self.types.size(ty).is_some() {
            return true;
        }
        let text = match self.types.get(ty) {
            Type::Array(..) => format!("{what} needs the length of its array"),
            _ => format!(
                "{what} cannot be {}, which has no known size",
                self.show(ty)
            ),
        };
        let advice = match *self.types.get(ty) {
            Type::Record(record) => self.advice_for_record(record),
            _ => None,
        };
        self.error_advice(BAD_TYPE, span, text, advice);
        false
    }
}

fn qualify(quals: &mut Quals, qualifier: Qualifier) {
    match qualifier {
        Qualifier::Const => quals.constant = true,
        Qualifier::Volatile => quals.volatile = true,
        Qualifier::Restrict => quals.restrict = true,
        Qualifier::Global => quals.global = true,
    }
}
