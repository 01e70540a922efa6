//! The control code in sequence, one operation after another, in registers of the machine. A
//! scheduler makes it along with the bundles, so that [`check_sequence`](super::check_sequence) can
//! compare the two.

use crate::dre::scheduled::{Bundle, Control, Reg, Src};
use crate::pass::Object;
use crate::program::{Pos, Value};
use srp_archdesc::isa::Opcode;

/// Operations that end with at most one control transfer, and the bundles that do them. Control
/// enters at the first bundle only. When the next stretch begins, here or at the target, all
/// results stand in their registers.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// Its first bundle.
    pub first: Bundle,
    /// How many bundles it has, those of the branch delay included.
    pub bundles: usize,
    /// The operations, in order.
    pub steps: Vec<Step>,
    /// The transfer after them.
    pub exit: Option<Control>,
}

/// An operation without its slot.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The opcode.
    pub op: Opcode,
    /// Its operands.
    pub srcs: Vec<Src>,
    /// The immediate.
    pub imm: i32,
    /// Where the result goes.
    pub dst: Option<Reg>,
    /// The storage that it accesses, if any.
    pub storage: Storage,
    /// Where it comes from.
    pub pos: Pos,
}

/// The storage that an access goes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// Any object of the program.
    Anywhere,
    /// One object, into which this value of the function points. The checker does not take the
    /// scheduler's word for it.
    Object(Object, Value),
    /// Storage that no pointer of the program reaches: spilled values, arguments.
    Compiler,
}

impl Storage {
    /// True if accesses of the two never meet.
    pub fn is_apart(self, other: Storage) -> bool {
        match (self, other) {
            (Storage::Compiler, Storage::Compiler) => false,
            (Storage::Compiler, _) | (_, Storage::Compiler) => true,
            (Storage::Object(a, _), Storage::Object(b, _)) => a != b,
            _ => false,
        }
    }
}
