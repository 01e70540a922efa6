//! The type checker: syntax trees to the checked program.
//!
//! One `Checker` goes over all sources in order, keeping what has external linkage. Every error
//! gives a value of [`Type::Error`], which fits everywhere, so that one mistake makes one message.

mod access;
mod advice;
mod attribute;
mod binary;
mod builtin;
mod call;
mod constant;
mod convert;
mod declarator;
mod declare;
mod expr;
mod format;
mod function;
mod image;
mod init;
mod link;
mod record;
mod stmt;
mod suspect;
mod trip;

pub(crate) use constant::truth;

use crate::ast;
use crate::ctype::{QualType, RecordId, Type, TypeId, TypeTable};
use crate::message::{Code, Messages};
use crate::operator::Support;
use crate::options::Options;
use crate::source::{Name, SourceMap};
use crate::typed::*;
use link::Externals;
use srp_archdesc::choice::Choices;
use srp_archdesc::diagnostic::{Severity, Span};
use srp_archdesc::entity::EntityMap;
use std::collections::{BTreeMap, HashMap, HashSet};

/// The sources that are checked together.
#[derive(Clone, Copy, Debug)]
pub struct Sources<'a> {
    /// The program.
    pub units: &'a [ast::Unit],
    /// The parts of the library that the program needs.
    pub library: &'a [ast::Unit],
    /// Names of the library that the program defines itself.
    pub owned: &'a HashSet<Name>,
    /// The texts of both.
    pub map: &'a SourceMap,
}

/// Checks all sources together. `None` where there were errors; `messages` has them.
pub fn check(
    sources: &Sources<'_>,
    options: &Options<'_>,
    messages: &mut Messages,
) -> Option<Checked> {
    let empty = ast::Unit::default();
    let mut checker = Checker::new(&empty, sources, &options.choices, messages);
    checker.double_is_float = options.double_is_float;
    checker.single_constants = options.single_constants;
    // The library comes first, so that its types are known.
    for (number, unit) in sources.library.iter().chain(sources.units).enumerate() {
        checker.unit = unit;
        checker.number = number;
        checker.in_library = number < sources.library.len();
        checker.scopes = vec![checker.built_in(), Scope::default()];
        for item in &unit.items {
            checker.item(item);
        }
        checker.end_of_unit();
        checker.close_scope();
        if checker.in_library {
            checker.library_end = (checker.objects.len(), checker.functions.len());
        }
    }
    checker.finish()
}

/// The meaning of a name.
#[derive(Clone, Copy, Debug)]
enum Symbol {
    Local(LocalId),
    Object(ObjectId),
    Function(FunctionId),
    Typedef(QualType),
    /// A constant of an `enum`.
    Constant(u64, TypeId),
}

/// The meaning of a tag.
#[derive(Clone, Copy, Debug)]
enum Tag {
    Record(RecordId),
    Enum(TypeId),
    /// An enumeration whose constants are not known yet.
    Announced(TypeId),
}

/// The names of a block or file.
#[derive(Debug, Default)]
struct Scope {
    names: HashMap<Name, (Symbol, Span)>,
    tags: HashMap<Name, (Tag, Span)>,
}

/// An expression before it is used as a value.
#[derive(Clone, Copy, Debug)]
enum Operand {
    Place(PlaceId),
    Function(FunctionId, Span),
    Value(ExprId),
}

/// A `switch` being checked.
#[derive(Debug)]
struct Cases {
    ty: TypeId,
    cases: Vec<(i128, i128, usize)>,
    /// First and last value of each case by first, with its place.
    seen: BTreeMap<i128, (i128, Span)>,
    default: Option<(usize, Span)>,
    labels: usize,
    /// How many loops are around the `switch`.
    loops: usize,
}

/// A label for `goto`.
#[derive(Debug)]
struct Label {
    number: usize,
    defined: Option<Span>,
    used: Option<Span>,
}

/// The surroundings of the current statement.
#[derive(Debug, Default)]
struct Context {
    /// The result of the current function.
    result: Option<TypeId>,
    function: Option<Name>,
    /// For each loop and `switch` around: true if a `break` leaves it.
    breaks: Vec<bool>,
    /// How many of them are loops.
    loops: usize,
    switches: Vec<Cases>,
    /// Labels for `goto`: number, where each stands, and where it is first used.
    labels: BTreeMap<Name, Label>,
    /// True if the function takes arguments by `...`.
    variadic: bool,
    /// How many labels and `goto` statements there have been, to see whether a loop has some.
    jumps: usize,
    /// Variables assigned so far in the function, in order, to see what a loop changes.
    assigned: Vec<LocalId>,
    /// Variables that have certainly no value here, declared without one in the straight line that led here; each with the
    /// number of branches around its declaration.
    unset: BTreeMap<LocalId, u32>,
    /// How many branches are around: bodies of `if`, and operands that are not always computed.
    branches: u32,
    /// How many operands around are not evaluated, or for nothing.
    quiet: u32,
}

struct Checker<'a> {
    unit: &'a ast::Unit,
    /// The number of the unit.
    number: usize,
    sources: &'a SourceMap,
    /// Names of the library that the program defines itself.
    owned: &'a HashSet<Name>,
    messages: &'a mut Messages,
    types: TypeTable,
    objects: EntityMap<ObjectId, Object>,
    functions: EntityMap<FunctionId, Function>,
    externals: Externals,
    /// String literals, each once.
    strings: BTreeMap<Vec<u8>, ObjectId>,
    /// Innermost last; the first has the built-in names, the second those of the file.
    scopes: Vec<Scope>,
    /// The function being checked, or room for the expressions of a declaration at file level.
    body: Body,
    context: Context,
    /// The operand of `&` is being checked, so that the end of an array is no mistake.
    past_end: bool,
    /// The unit is one of the library.
    in_library: bool,
    /// How many objects and functions the library has.
    library_end: (usize, usize),
    /// `double` means `float`.
    double_is_float: bool,
    /// Floating constants without suffix are floats.
    single_constants: bool,
    /// The units of the machine.
    choices: &'a Choices,
    /// The enumerations of what is declared as one, by the places of both. The types are integers, and tell
    /// them apart no more.
    enumerations: HashMap<Span, Span>,
    /// The warning about `volatile` has been given.
    told_volatile: bool,
    /// Calls of functions that are not declared, with advice about the name.
    implicit: HashMap<Span, Option<String>>,
}

impl<'a> Checker<'a> {
    fn new(
        unit: &'a ast::Unit,
        sources: &Sources<'a>,
        choices: &'a Choices,
        messages: &'a mut Messages,
    ) -> Checker<'a> {
        Checker {
            unit,
            number: 0,
            sources: sources.map,
            owned: sources.owned,
            messages,
            types: TypeTable::default(),
            objects: EntityMap::new(),
            functions: EntityMap::new(),
            externals: Externals::default(),
            strings: BTreeMap::new(),
            scopes: Vec::new(),
            body: Body::default(),
            context: Context::default(),
            past_end: false,
            in_library: false,
            library_end: (0, 0),
            double_is_float: false,
            single_constants: false,
            choices,
            enumerations: HashMap::new(),
            told_volatile: false,
            implicit: HashMap::new(),
        }
    }

    fn built_in(&mut self) -> Scope {
        let known = self.types.known;
        let types = [known.float4, known.int4, known.double, self.va_list()];
        let mut scope = Scope::default();
        for (name, ty) in crate::classify::BUILT_IN.into_iter().zip(types) {
            let symbol = Symbol::Typedef(QualType::plain(ty));
            scope.names.insert(name.into(), (symbol, Span::default()));
        }
        scope
    }

    fn item(&mut self, item: &ast::Item) {
        match item {
            ast::Item::Function(function) => self.function(function),
            ast::Item::Declaration(declaration) => {
                self.declaration(declaration);
                // Expressions of a declaration at file level are constants by now.
                self.body = Body::default();
            }
            ast::Item::StaticAssert(assert) => self.static_assert(assert),
        }
    }

    fn error(&mut self, code: Code, span: Span, text: impl Into<String>, label: &str) {
        self.messages
            .push(self.sources.error(code, span, text, label));
    }

    /// An error with advice, where there is some.
    fn error_advice(&mut self, code: Code, span: Span, text: String, advice: Option<String>) {
        let message = self.sources.error(code, span, text, "");
        self.messages.push(match advice {
            Some(advice) => message.help(advice),
            None => message,
        });
    }

    fn error_help(&mut self, code: Code, span: Span, text: impl Into<String>, help: &str) {
        let message = self.sources.error(code, span, text, "").help(help);
        self.messages.push(message);
    }

    /// True if a place lies in the library, for which only errors are reported.
    fn is_library(&self, span: Span) -> bool {
        self.in_library || self.sources.is_library(span)
    }

    fn warning(&mut self, code: Code, span: Span, text: impl Into<String>) {
        if self.is_library(span) {
            return;
        }
        self.messages
            .push(self.sources.warning(code, span, text, ""));
    }

    fn note(&mut self, code: Code, span: Span, text: impl Into<String>) {
        if self.is_library(span) {
            return;
        }
        let message = self.sources.message(Severity::Note, code, span, text, "");
        self.messages.push(message);
    }

    /// The type of a list of arguments that `...` stands for.
    fn va_list(&mut self) -> TypeId {
        let char = QualType::plain(self.types.known.char);
        self.types.pointer(char)
    }

    fn lookup(&self, name: &str) -> Option<(Symbol, Span)> {
        let found = self.scopes.iter().rev().find_map(|s| s.names.get(name));
        found.copied()
    }

    fn lookup_tag(&self, name: &str) -> Option<(Tag, Span)> {
        let found = self.scopes.iter().rev().find_map(|s| s.tags.get(name));
        found.copied()
    }

    /// The innermost scope.
    fn scope(&mut self) -> &mut Scope {
        self.scopes.last_mut().expect("the file's scope stays")
    }

    fn at_file_level(&self) -> bool {
        self.scopes.len() <= 2
    }

    /// A type as messages show it.
    fn show(&self, ty: TypeId) -> String {
        format!("`{}`", self.types.show_plain(ty))
    }

    fn ty(&self, e: ExprId) -> TypeId {
        self.body.exprs[e].ty
    }

    fn span(&self, e: ExprId) -> Span {
        self.body.exprs[e].span
    }

    fn is_error(&self, ty: TypeId) -> bool {
        matches!(self.types.get(ty), Type::Error)
    }

    /// Adds an expression, as its value where that is plain.
    fn make(&mut self, kind: ExprKind, ty: TypeId, span: Span) -> ExprId {
        let kind = match constant::fold(&kind, ty, &self.body.exprs, &self.types) {
            Some(bits) => ExprKind::Const(bits),
            None => kind,
        };
        let pos = self.sources.pos(span);
        self.body.exprs.push(Expr {
            kind,
            ty,
            pos,
            span,
        })
    }

    fn place(&mut self, kind: PlaceKind, ty: QualType, span: Span) -> PlaceId {
        self.body.places.push(Place { kind, ty, span })
    }

    /// A value where there is none.
    fn error_value(&mut self, span: Span) -> ExprId {
        let ty = self.types.known.error;
        self.make(ExprKind::Const(0), ty, span)
    }

    fn int_const(&mut self, value: u64, ty: TypeId, span: Span) -> ExprId {
        self.make(ExprKind::Const(value), ty, span)
    }

    /// The constant that an expression is, if it is a scalar one.
    fn const_value(&self, e: ExprId) -> Option<u64> {
        match self.body.exprs[e].kind {
            ExprKind::Const(bits) => Some(bits),
            _ => None,
        }
    }

    /// The number that an expression is, if it is a constant integer.
    fn const_number(&self, e: ExprId) -> Option<i128> {
        let ty = self.types.get(self.ty(e));
        let bits = self.const_value(e)?;
        matches!(ty, Type::Int(_) | Type::Bool).then(|| constant::number(bits, ty))
    }

    fn finish(mut self) -> Option<Checked> {
        self.link();
        if self.messages.errors() > 0 {
            return None;
        }
        let support = Support::ALL.iter().filter_map(|&support| {
            match self.externals.names.get(support.name()) {
                Some(Symbol::Function(function)) => Some((support, *function)),
                _ => None,
            }
        });
        Some(Checked {
            support: support.collect(),
            types: self.types,
            files: self.sources.names(),
            objects: self.objects,
            functions: self.functions,
        })
    }
}
