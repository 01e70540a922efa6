//! The checked program: what [`check`](crate::check()) makes and [`lower`](crate::lower()) takes.
//!
//! Every name is resolved, every conversion explicit, every operand of the type that its operator
//! wants. Operators have C's meaning; which opcodes they become is the lowering's business.

use crate::ctype::{BitRange, QualType, TypeId, TypeTable};
use crate::operator::Support;
pub use crate::operator::{BinaryOp, Relation};
use crate::source::Name;
use srp_archdesc::diagnostic::Span;
use srp_archdesc::entity;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Opcode;
use srp_archdesc::structure::Special;
use srp_ir::program::{Pos, SourceFile};
use std::collections::BTreeMap;

entity! {
    /// An expression of a function.
    ExprId = "x";
    /// Something with an address in a function.
    PlaceId = "l";
    /// A statement of a function.
    StmtId = "s";
    /// A variable of a function.
    LocalId = "n";
    /// An object with static storage.
    ObjectId = "o";
    /// A function.
    FunctionId = "f";
}

/// A checked program.
#[derive(Debug)]
pub struct Checked {
    /// Its types.
    pub types: TypeTable,
    /// Names of the source files.
    pub files: EntityMap<SourceFile, String>,
    /// Objects with static storage.
    pub objects: EntityMap<ObjectId, Object>,
    /// Functions.
    pub functions: EntityMap<FunctionId, Function>,
    /// The functions of the library that compute what no opcode does.
    pub(crate) support: BTreeMap<Support, FunctionId>,
}

/// An object with static storage.
#[derive(Clone, Debug)]
pub struct Object {
    /// Its name, unique.
    pub name: String,
    /// Its type.
    pub ty: QualType,
    /// Its initial contents, of known size once it is defined.
    pub image: Image,
    /// True if some source defines it.
    pub defined: bool,
    /// A library object; dropped if nothing references it.
    pub optional: bool,
    /// The alignment asked for beyond that of its type, bytes.
    pub align: u32,
    /// Where it is declared.
    pub pos: Pos,
}

/// Initial contents.
#[derive(Clone, Debug, Default)]
pub struct Image {
    /// The first bytes; the rest is zero.
    pub bytes: Vec<u8>,
    /// Addresses in it: offset, target, and the number added.
    pub addresses: Vec<(u32, Address, i32)>,
}

/// The target of a constant address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Address {
    /// An object.
    Object(ObjectId),
    /// A function.
    Function(FunctionId),
}

/// A function.
#[derive(Debug)]
pub struct Function {
    /// Its name, unique.
    pub name: String,
    /// Its type.
    pub ty: TypeId,
    /// Its body; `None` if no source defines it.
    pub body: Option<Body>,
    /// No other source knows it; dropped if nothing uses it.
    pub internal: bool,
    /// A library function; dropped if nothing uses it.
    pub optional: bool,
    /// An attribute asks that no call of it is inlined.
    pub noinline: bool,
    /// Where it is defined, or declared.
    pub pos: Pos,
}

/// The body of a function.
#[derive(Debug, Default)]
pub struct Body {
    /// Its parameters.
    pub params: Vec<LocalId>,
    /// Its variables, the parameters among them.
    pub locals: EntityMap<LocalId, Local>,
    /// Its expressions.
    pub exprs: EntityMap<ExprId, Expr>,
    /// Its places: lvalues.
    pub places: EntityMap<PlaceId, Place>,
    /// Its statements.
    pub stmts: EntityMap<StmtId, Stmt>,
    /// How many labels it has for `goto`.
    pub labels: usize,
    /// All of it.
    pub root: Option<StmtId>,
}

/// A variable.
#[derive(Clone, Debug)]
pub struct Local {
    /// Its name, for listings.
    pub name: Name,
    /// Its type.
    pub ty: QualType,
    /// Its address is used, so that it must lie in memory as one piece.
    pub in_memory: bool,
    /// The alignment asked for beyond that of its type, bytes: up to [`MAX_LOCAL_ALIGN`].
    pub align: u32,
}

/// Largest alignment of a variable of a function, that of the stack.
pub const MAX_LOCAL_ALIGN: u32 = 16;

/// An expression.
#[derive(Clone, Debug)]
pub struct Expr {
    /// Its kind and operands.
    pub kind: ExprKind,
    /// Its type.
    pub ty: TypeId,
    /// Where it is.
    pub pos: Pos,
    /// The same with its end, for messages.
    pub span: Span,
}

/// Kinds of expressions.
#[derive(Clone, Debug)]
pub enum ExprKind {
    /// A constant of a scalar type, in its bits; those above a word are zero in all but the types
    /// of 64 bits.
    Const(u64),
    /// The value in a scalar, pointer or vector place.
    Load(PlaceId),
    /// The value in a struct or union place.
    Aggregate(PlaceId),
    /// The address of a place.
    AddressOf(PlaceId),
    /// The address of a function.
    Function(FunctionId),
    /// The same value in another scalar type, or the same bits in another vector type.
    Convert(ExprId),
    /// A scalar in all lanes of a vector.
    Splat(ExprId),
    /// Arithmetic negation.
    Negate(ExprId),
    /// Bitwise complement.
    Complement(ExprId),
    /// 1 where the operand is zero, else 0.
    LogicalNot(ExprId),
    /// Arithmetic on two values of the result's type; the count of a shift may be another integer.
    Binary(BinaryOp, ExprId, ExprId),
    /// A relation of two values of one type: an `int`, or for vectors an `int4`.
    Compare(Relation, ExprId, ExprId),
    /// `&&`, or `||` where the flag is set.
    Logical(bool, ExprId, ExprId),
    /// `c ? a : b`.
    Conditional(ExprId, ExprId, ExprId),
    /// A pointer plus an integer times this many bytes.
    Offset(ExprId, ExprId, i32),
    /// The distance of two pointers in units of this many bytes.
    Distance(ExprId, ExprId, u32),
    /// Sets a place; returns the value that it then holds.
    Assign(PlaceId, ExprId),
    /// Changes a place.
    Update(Update),
    /// The second value, after the first was computed.
    Comma(ExprId, ExprId),
    /// A call.
    Call(Callee, Vec<ExprId>),
    /// An operation of the opcode table with its immediate; predicates are conditions here.
    Operation(Opcode, Vec<ExprId>, i32),
    /// A vector of four words.
    Build([ExprId; 4]),
    /// A lane of a vector.
    Lane(ExprId, ExprId),
    /// The address of the arguments that `...` stands for.
    Variadic,
    /// Is never reached.
    Unreachable,
    /// The value of the last of these statements, where there is one.
    Statements(Vec<StmtId>, Option<ExprId>),
}

/// A change of a place by its own value.
#[derive(Clone, Debug)]
pub struct Update {
    /// The place.
    pub place: PlaceId,
    /// How its value changes.
    pub step: Step,
    /// The operand, in the type that the operation is done in (but the count of a shift).
    pub operand: ExprId,
    /// The value of the expression is the one that the place held before.
    pub post: bool,
}

/// How an update changes a value.
#[derive(Clone, Copy, Debug)]
pub enum Step {
    /// By an operation in this type.
    Arithmetic(BinaryOp, TypeId),
    /// A pointer, by this many bytes times the operand.
    Pointer(i32),
}

/// Who is called.
#[derive(Clone, Copy, Debug)]
pub enum Callee {
    /// A function by name.
    Function(FunctionId),
    /// The function at an address.
    Pointer(ExprId),
}

/// Something with an address, or a lane of it.
#[derive(Clone, Debug)]
pub struct Place {
    /// Its kind and operands.
    pub kind: PlaceKind,
    /// Its type.
    pub ty: QualType,
    /// Where it is.
    pub span: Span,
}

/// Kinds of places.
#[derive(Clone, Debug)]
pub enum PlaceKind {
    /// A variable.
    Local(LocalId),
    /// A variable that is set first: a compound literal.
    Literal(LocalId, Init),
    /// An object with static storage.
    Object(ObjectId),
    /// The target of a pointer.
    Deref(ExprId),
    /// A part of another place at this offset.
    Member(PlaceId, u32),
    /// A bit-field in the unit at this offset of another place.
    Bits(PlaceId, u32, BitRange),
    /// A lane of a vector.
    Lane(PlaceId, ExprId),
    /// The value of this struct expression.
    Temporary(ExprId),
    /// Memory of its own that holds the value of this struct expression.
    Stored(ExprId),
}

/// How a variable is set.
#[derive(Clone, Debug, Default)]
pub struct Init {
    /// It is set to zero first.
    pub zero: bool,
    /// Then parts of it.
    pub parts: Vec<Part>,
}

/// A part of a variable and its initial value.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Byte offset; of a bit-field, of its unit.
    pub offset: u32,
    /// The bits that a bit-field is.
    pub bits: Option<BitRange>,
    /// The value, in the part's type.
    pub value: ExprId,
}

/// A statement.
#[derive(Clone, Debug)]
pub struct Stmt {
    /// Its kind and operands.
    pub kind: StmtKind,
    /// Where it is.
    pub pos: Pos,
}

/// Kinds of statements.
#[derive(Clone, Debug)]
pub enum StmtKind {
    /// Statements one after another.
    Block(Vec<StmtId>),
    /// An expression.
    Expr(ExprId),
    /// A variable begins with this value.
    Init(LocalId, Init),
    /// `if`.
    If(ExprId, StmtId, Option<StmtId>),
    /// A loop.
    Loop(Loop),
    /// `switch`.
    Switch(Switch),
    /// A label of the innermost `switch`, by its number.
    Label(usize),
    /// A label of the function, by its number.
    Target(usize),
    /// `goto` to a label of the function.
    Goto(usize),
    /// `break`.
    Break,
    /// `continue`.
    Continue,
    /// `return`.
    Return(Option<ExprId>),
}

/// A loop.
#[derive(Clone, Debug)]
pub struct Loop {
    /// The statement before the first iteration.
    pub init: Option<StmtId>,
    /// Goes on while it holds; for ever where there is none.
    pub cond: Option<ExprId>,
    /// The condition is tested after the body only.
    pub body_first: bool,
    /// The expression evaluated after each iteration.
    pub step: Option<ExprId>,
    /// The body.
    pub body: StmtId,
    /// A pragma asks for the array.
    pub kernel: bool,
    /// How often a pragma repeats the body.
    pub unroll: u32,
    /// A pragma says that iterations access different elements.
    pub ivdep: bool,
    /// Groups of variables that a pragma calls independent.
    pub independent: Vec<Vec<Variable>>,
    /// Which operations pragmas have compute functions in it.
    pub units: Vec<(Special, Opcode)>,
    /// How often it runs, where that is plain.
    pub trip: Option<Trip>,
    /// A label of the function stands in it, or it is left or entered by `goto`.
    pub labelled: bool,
}

/// A variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    /// Of the function.
    Local(LocalId),
    /// With static storage.
    Object(ObjectId),
}

/// How often a loop runs that counts with constants.
#[derive(Clone, Copy, Debug)]
pub struct Trip {
    /// The number of iterations.
    pub count: u32,
    /// The variable that counts. Where it must lie in memory, something else may change it, and
    /// the number means nothing.
    pub counter: LocalId,
}

/// A `switch`.
#[derive(Clone, Debug)]
pub struct Switch {
    /// The value compared.
    pub value: ExprId,
    /// Ranges of values, first and last in their order, with the number of the label they go to.
    pub cases: Vec<(i128, i128, usize)>,
    /// The label of all other values.
    pub default: Option<usize>,
    /// How many labels there are.
    pub labels: usize,
    /// The statements.
    pub body: StmtId,
}
