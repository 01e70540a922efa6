//! [`Observer`]: who is told of everything that a run does with values.

use crate::program::{Func, Inst, Pos, Value as Ssa};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Opcode;
use srp_archdesc::ops::Value;

/// Told of everything that a run does with values. Each value has a number among those of all open
/// calls: the *base* of its call and its own index. By default nobody listens.
pub trait Observer<W> {
    /// A call is opened: its `len` values, from `base` on, are zero.
    fn enter(&mut self, base: usize, len: usize) {
        let _ = (base, len);
    }

    /// Value `to` is a constant or an address now.
    fn constant(&mut self, to: usize) {
        let _ = to;
    }

    /// An operation is done.
    fn done(&mut self, done: &Done<'_>, world: &mut W) {
        let _ = (done, world);
    }

    /// Values are handed on, all at once: by a jump, a call or a return. Where it is a return, the
    /// call that they come from is closed next.
    fn moved(&mut self, from: Values<'_>, to: Values<'_>) {
        let _ = (from, to);
    }

    /// Control goes one of two ways, by the predicate with this number.
    fn branch(&mut self, cond: usize, taken: bool, at: Pos) {
        let _ = (cond, taken, at);
    }
}

/// Nobody.
impl<W> Observer<W> for () {}

/// Some values of one call.
#[derive(Clone, Copy, Debug)]
pub struct Values<'a> {
    /// Where the values of the call start.
    pub base: usize,
    /// Which.
    pub values: &'a [Ssa],
}

impl Values<'_> {
    /// Their numbers, in order.
    pub fn numbers(&self) -> impl Iterator<Item = usize> + '_ {
        self.values.iter().map(|v| self.base + v.index())
    }
}

/// An operation that is done.
#[derive(Clone, Copy, Debug)]
pub struct Done<'a> {
    /// The function.
    pub func: Func,
    /// The instruction.
    pub inst: Inst,
    /// The opcode.
    pub op: Opcode,
    /// Its immediate.
    pub imm: i32,
    /// The numbers of its operands; the base of the call where it has fewer.
    pub args: [usize; 3],
    /// Its operands; zero where it has fewer.
    pub operands: &'a [Value; 3],
    /// The number and the value of its result, if it has one.
    pub result: Option<(usize, Value)>,
}
