//! The syntax tree of one source file, apart from how it was parsed.
//!
//! Expressions and statements live in arenas, so that neither a deep tree nor a long chain needs
//! a deep stack to be dropped. [`Unit::show`](show) prints the tree.

pub mod build;
mod operator;
pub mod show;

pub use operator::{Infix, Prefix};

use crate::source::Name;
use crate::token::{FloatConst, IntConst};
use srp_archdesc::diagnostic::Span;
use srp_archdesc::entity;
use srp_archdesc::entity::EntityMap;
use std::collections::BTreeSet;
use std::rc::Rc;

entity! {
    /// An expression of a unit.
    ExprId = "e";
    /// A statement of a unit.
    StmtId = "s";
}

/// One source file with its includes.
#[derive(Clone, Debug, Default)]
pub struct Unit {
    /// Declarations and function definitions, in order.
    pub items: Vec<Item>,
    /// Expressions.
    pub exprs: EntityMap<ExprId, Expr>,
    /// Statements.
    pub stmts: EntityMap<StmtId, Stmt>,
    /// It may compute with numbers of 64 bits.
    pub wide: bool,
    /// Names that stand where the parser understood nothing: what they mean was never said.
    pub misunderstood: BTreeSet<Name>,
}

/// An item at file level.
#[derive(Clone, Debug)]
pub enum Item {
    /// A function definition.
    Function(FunctionDefinition),
    /// A declaration.
    Declaration(Declaration),
    /// `_Static_assert(condition, text)`.
    StaticAssert(StaticAssert),
}

/// A function definition.
#[derive(Clone, Debug)]
pub struct FunctionDefinition {
    /// Result type and storage.
    pub specs: Specs,
    /// Name and parameters.
    pub declarator: Declarator,
    /// Declarations of parameters that the declarator only names.
    pub old_style: Vec<Declaration>,
    /// The statements.
    pub body: StmtId,
}

/// A declaration.
#[derive(Clone, Debug)]
pub struct Declaration {
    /// The specifiers that all declarators share.
    pub specs: Specs,
    /// The names declared; empty where only a tag is.
    pub declarators: Vec<InitDeclarator>,
    /// All of it.
    pub span: Span,
}

/// `_Static_assert(condition, text)`.
#[derive(Clone, Debug)]
pub struct StaticAssert {
    /// The condition that must hold.
    pub condition: ExprId,
    /// The message shown if the condition is false.
    pub text: Option<Rc<[u8]>>,
    /// All of it.
    pub span: Span,
}

/// A declarator with its initialiser.
#[derive(Clone, Debug)]
pub struct InitDeclarator {
    /// The name and its derivation.
    pub declarator: Declarator,
    /// Attributes after it.
    pub attributes: Vec<Attribute>,
    /// The initial value.
    pub init: Option<Initialiser>,
}

/// Specifiers and qualifiers, in the order they are written.
#[derive(Clone, Debug, Default)]
pub struct Specs {
    /// Each with its place.
    pub list: Vec<(Spec, Span)>,
    /// All of them.
    pub span: Span,
}

/// One specifier or qualifier.
#[derive(Clone, Debug)]
pub enum Spec {
    /// A storage class.
    Storage(Storage),
    /// `inline`.
    Inline,
    /// `_Noreturn`.
    Noreturn,
    /// A qualifier.
    Qualifier(Qualifier),
    /// A keyword that is part of a type's name.
    Keyword(TypeKeyword),
    /// The name of a `typedef`.
    Named(Name),
    /// `struct` or `union`.
    Record(RecordSpec),
    /// `enum`.
    Enum(EnumSpec),
    /// `__attribute__((…))`, or `_Alignas(…)`.
    Attributes(Vec<Attribute>),
    /// `typeof(expression)`.
    TypeofExpr(ExprId),
    /// `typeof(type)`.
    TypeofType(Box<TypeName>),
}

/// Storage classes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // each is its keyword
pub enum Storage {
    Typedef,
    Extern,
    Static,
    Auto,
    Register,
}

/// Type qualifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // each is its keyword
pub enum Qualifier {
    Const,
    Volatile,
    Restrict,
    Global,
}

/// Keywords that name types, alone or together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // each is its keyword
pub enum TypeKeyword {
    Void,
    Char,
    Short,
    Int,
    Long,
    Signed,
    Unsigned,
    Float,
    Double,
    Bool,
}

/// `struct` or `union`.
#[derive(Clone, Debug)]
pub struct RecordSpec {
    /// True if it is a union.
    pub union: bool,
    /// Its tag.
    pub tag: Option<(Name, Span)>,
    /// Its members, where it is defined here.
    pub members: Option<Vec<Member>>,
    /// Attributes after the keyword.
    pub attributes: Vec<Attribute>,
}

/// One declaration of members.
#[derive(Clone, Debug)]
pub struct Member {
    /// The specifiers that all declarators share.
    pub specs: Specs,
    /// The members; empty for an anonymous struct or union.
    pub declarators: Vec<MemberDeclarator>,
    /// All of it.
    pub span: Span,
}

/// One member.
#[derive(Clone, Debug)]
pub struct MemberDeclarator {
    /// Name and type; the name is missing in an unnamed bit-field.
    pub declarator: Declarator,
    /// The width of a bit-field.
    pub width: Option<ExprId>,
    /// Attributes after it.
    pub attributes: Vec<Attribute>,
}

/// `enum`.
#[derive(Clone, Debug)]
pub struct EnumSpec {
    /// Its tag.
    pub tag: Option<(Name, Span)>,
    /// Its constants, where it is defined here.
    pub constants: Option<Vec<Enumerator>>,
}

/// A constant of an `enum`.
#[derive(Clone, Debug)]
pub struct Enumerator {
    /// Its name.
    pub name: Name,
    /// Where the name is.
    pub span: Span,
    /// Its value, where it is not the next.
    pub value: Option<ExprId>,
}

/// An attribute.
#[derive(Clone, Debug)]
pub struct Attribute {
    /// Its name without the optional double underscores round it.
    pub name: Name,
    /// Its arguments.
    pub args: Vec<ExprId>,
    /// Where it is.
    pub span: Span,
}

/// Attributes that say nothing about what a program does.
const HARMLESS: &[&str] = &[
    "alloc_align",
    "alloc_size",
    "always_inline",
    "artificial",
    "assume_aligned",
    "cold",
    "const",
    "deprecated",
    "designated_init",
    "externally_visible",
    "fallthrough",
    "flatten",
    "format",
    "format_arg",
    "gnu_inline",
    "hot",
    "inline",
    "leaf",
    "malloc",
    "may_alias",
    "no_icf",
    "no_reorder",
    "noclone",
    "noinline",
    "noipa",
    "nonnull",
    "nonstring",
    "noreturn",
    "nothrow",
    "optimize",
    "pure",
    "returns_nonnull",
    "sentinel",
    "stack_protect",
    "unused",
    "used",
    "visibility",
    "warn_if_not_aligned",
    "warn_unused_result",
    "error",
    "warning",
];

/// Attributes that change a layout or what is called, so that they cannot be left out.
const EFFECTIVE: &[&str] = &[
    "alias",
    "aligned",
    "cleanup",
    "constructor",
    "destructor",
    "ifunc",
    "mode",
    "ms_struct",
    "packed",
    "scalar_storage_order",
    "section",
    "transparent_union",
    "vector_size",
    "weak",
];

impl Attribute {
    /// True if the attribute changes a type, a layout or the function that is called.
    pub fn has_effect(&self) -> bool {
        EFFECTIVE.contains(&&*self.name)
    }

    /// True if the attribute is known to change nothing.
    pub fn is_harmless(&self) -> bool {
        HARMLESS.contains(&&*self.name)
    }
}

/// A name, and the derivation of its type from the specifiers.
#[derive(Clone, Debug)]
pub struct Declarator {
    /// The name, where there is one.
    pub name: Option<(Name, Span)>,
    /// From the name outwards: `*f[3]` is an array, then a pointer.
    pub derived: Vec<(Derived, Span)>,
    /// All of it; a point where it is empty.
    pub span: Span,
}

/// A step from a type to one derived from it.
#[derive(Clone, Debug)]
pub enum Derived {
    /// A pointer with these qualifiers of its own.
    Pointer(Vec<(Qualifier, Span)>),
    /// An array of this length.
    Array(Option<ExprId>),
    /// An array as only a parameter can be written: with qualifiers of the pointer that it is, and
    /// `static` or `*`.
    ParamArray(Vec<(Qualifier, Span)>, Option<ExprId>),
    /// A function.
    Function(Params),
    /// A function whose parameters are named here and declared before its body.
    OldStyle(Vec<(Name, Span)>),
}

/// Parameters of a function.
#[derive(Clone, Debug)]
pub struct Params {
    /// The parameters; `(void)` is one of type `void`.
    pub list: Vec<Param>,
    /// It ends in `...`.
    pub variadic: bool,
}

/// One parameter.
#[derive(Clone, Debug)]
pub struct Param {
    /// Its specifiers.
    pub specs: Specs,
    /// Its declarator, perhaps without a name.
    pub declarator: Declarator,
    /// All of it.
    pub span: Span,
}

/// The name of a type, as in a cast.
#[derive(Clone, Debug)]
pub struct TypeName {
    /// Its specifiers.
    pub specs: Specs,
    /// Its declarator, without a name.
    pub declarator: Declarator,
    /// All of it.
    pub span: Span,
}

impl TypeName {
    /// `void`, which stands at a place.
    pub(crate) fn void(span: Span) -> TypeName {
        TypeName {
            specs: Specs {
                list: vec![(Spec::Keyword(TypeKeyword::Void), span)],
                span,
            },
            declarator: Declarator {
                name: None,
                derived: Vec::new(),
                span: Span::point(span.end),
            },
            span,
        }
    }
}

/// An initialiser.
#[derive(Clone, Debug)]
pub struct Initialiser {
    /// Its kind and contents.
    pub kind: InitialiserKind,
    /// Where it is.
    pub span: Span,
}

/// Kinds of initialisers.
#[derive(Clone, Debug)]
pub enum InitialiserKind {
    /// A value.
    Expr(ExprId),
    /// `{ … }`.
    List(Vec<(Vec<Designator>, Initialiser)>),
}

/// A step to a part of the object being initialised.
#[derive(Clone, Debug)]
pub enum Designator {
    /// `[index]`.
    Index(ExprId),
    /// `[first ... last]`.
    Range(ExprId, ExprId),
    /// `.member`.
    Member(Name, Span),
}

/// An expression.
#[derive(Clone, Debug)]
pub struct Expr {
    /// Its kind and operands.
    pub kind: ExprKind,
    /// Where it is.
    pub span: Span,
    /// How deep a visit from here recurses.
    pub depth: u32,
}

/// Kinds of expressions.
#[derive(Clone, Debug)]
pub enum ExprKind {
    /// An integer constant.
    Int(IntConst),
    /// A floating constant.
    Float(FloatConst),
    /// A character constant.
    Char(i32),
    /// A string literal without its zero.
    Str(Rc<[u8]>),
    /// A wide string literal without its zero.
    WideStr(Rc<[u32]>),
    /// A name.
    Name(Name),
    /// A call.
    Call(ExprId, Vec<ExprId>),
    /// `a[b]`.
    Index(ExprId, ExprId),
    /// `a.b`, or `a->b` where the flag is set.
    Member(ExprId, Name, Span, bool),
    /// A prefix operator.
    Prefix(Prefix, ExprId),
    /// `a++` (1) or `a--` (−1).
    Postfix(ExprId, i32),
    /// `(type)a`.
    Cast(Box<TypeName>, ExprId),
    /// `sizeof a`.
    SizeofExpr(ExprId),
    /// `sizeof(type)`.
    SizeofType(Box<TypeName>),
    /// `_Alignof(type)`.
    AlignofType(Box<TypeName>),
    /// `_Alignof a`.
    AlignofExpr(ExprId),
    /// `__builtin_va_arg(list, type)`.
    VaArg(ExprId, Box<TypeName>),
    /// `__builtin_types_compatible_p(type, type)`.
    SameType(Box<(TypeName, TypeName)>),
    /// `({ … })`.
    Statements(StmtId),
    /// `_Generic(a, type: b, default: c)`; `None` is `default`.
    Generic(ExprId, Vec<(Option<TypeName>, ExprId)>),
    /// `a ?: b`.
    Otherwise(ExprId, ExprId),
    /// `(type){ … }`.
    Compound(Box<TypeName>, Box<Initialiser>),
    /// An infix operator.
    Infix(Infix, ExprId, ExprId),
    /// `a = b`, or `a op= b`.
    Assign(Option<Infix>, ExprId, ExprId),
    /// `a ? b : c`.
    Conditional(ExprId, ExprId, ExprId),
    /// Something that has been complained about.
    Error,
}

/// A statement.
#[derive(Clone, Debug)]
pub struct Stmt {
    /// Its kind and parts.
    pub kind: StmtKind,
    /// Where it is.
    pub span: Span,
    /// How deep a visit from here recurses.
    pub depth: u32,
}

/// Kinds of statements.
#[derive(Clone, Debug)]
pub enum StmtKind {
    /// `;`.
    Empty,
    /// A declaration among statements.
    Declaration(Box<Declaration>),
    /// `_Static_assert` among statements.
    StaticAssert(StaticAssert),
    /// An expression.
    Expr(ExprId),
    /// `{ … }`.
    Block(Vec<StmtId>),
    /// `if`.
    If(ExprId, StmtId, Option<StmtId>),
    /// `while`.
    While(ExprId, StmtId),
    /// `do … while`.
    DoWhile(StmtId, ExprId),
    /// `for`: initial statement, condition, step, body.
    For(StmtId, Option<ExprId>, Option<ExprId>, StmtId),
    /// `switch`.
    Switch(ExprId, StmtId),
    /// A statement with labels before it.
    Labelled(Vec<Label>, StmtId),
    /// A statement with pragmas before it.
    Pragmas(Vec<(Pragma, Span)>, StmtId),
    /// `goto`.
    Goto(Name, Span),
    /// `break`.
    Break,
    /// `continue`.
    Continue,
    /// `return`.
    Return(Option<ExprId>),
    /// Something that has been complained about.
    Error,
}

/// A label.
#[derive(Clone, Debug)]
pub enum Label {
    /// `case value:`, or `case first ... last:`.
    Case(ExprId, Option<ExprId>, Span),
    /// `default:`.
    Default(Span),
    /// `name:`.
    Named(Name, Span),
}

/// A pragma before a loop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Pragma {
    /// The loop is to run on the array.
    Kernel,
    /// The body is to be repeated this many times.
    Unroll(u32),
    /// Iterations access different elements by these variables, and different variables are different
    /// objects.
    Independent(Rc<[Name]>),
    /// Iterations access different elements.
    Ivdep,
    /// A function of the loop is good to so many bits, its name first.
    Precision(Name, u32),
}
