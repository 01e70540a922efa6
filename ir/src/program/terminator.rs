//! [`Terminator`]: the ways in which a block ends.

use super::{Block, Value};

/// A jump's target with the values of its parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Target {
    /// Where to.
    pub block: Block,
    /// One value for each of its parameters.
    pub args: Vec<Value>,
}

/// The end of a block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Terminator {
    /// Goes on elsewhere.
    Jump(Target),
    /// Goes one of two ways.
    Branch {
        /// The predicate.
        cond: Value,
        /// Where to if it is true.
        then: Target,
        /// Where to if it is false.
        other: Target,
    },
    /// Returns to the caller.
    Return(Vec<Value>),
    /// Cannot be reached; traps if it is.
    Unreachable,
}

impl Target {
    /// A jump to a block without parameters.
    pub fn to(block: Block) -> Target {
        Target {
            block,
            args: Vec::new(),
        }
    }
}

impl Terminator {
    /// True for one that always goes to this block.
    pub fn is_jump_to(&self, block: Block) -> bool {
        matches!(self, Terminator::Jump(target) if target.block == block)
    }

    /// Lets what goes to one block go to another, which takes the same arguments.
    pub fn retarget(&mut self, old: Block, new: Block) {
        for target in self.targets_mut().filter(|t| t.block == old) {
            target.block = new;
        }
    }

    /// The targets, in order.
    pub fn targets(&self) -> impl Iterator<Item = &Target> {
        let (a, b) = match self {
            Terminator::Jump(t) => (Some(t), None),
            Terminator::Branch { then, other, .. } => (Some(then), Some(other)),
            Terminator::Return(_) | Terminator::Unreachable => (None, None),
        };
        a.into_iter().chain(b)
    }

    /// The targets, in order, mutably.
    pub fn targets_mut(&mut self) -> impl Iterator<Item = &mut Target> {
        let (a, b) = match self {
            Terminator::Jump(t) => (Some(t), None),
            Terminator::Branch { then, other, .. } => (Some(then), Some(other)),
            Terminator::Return(_) | Terminator::Unreachable => (None, None),
        };
        a.into_iter().chain(b)
    }

    /// Calls `f` on every value used.
    pub fn for_each_use(&self, mut f: impl FnMut(Value)) {
        match self {
            Terminator::Branch { cond, .. } => f(*cond),
            Terminator::Return(values) => values.iter().copied().for_each(&mut f),
            Terminator::Jump(_) | Terminator::Unreachable => {}
        }
        self.targets().flat_map(|t| &t.args).copied().for_each(f);
    }

    /// Calls `f` on every value used, mutably.
    pub fn for_each_use_mut(&mut self, mut f: impl FnMut(&mut Value)) {
        match self {
            Terminator::Branch { cond, .. } => f(cond),
            Terminator::Return(values) => values.iter_mut().for_each(&mut f),
            Terminator::Jump(_) | Terminator::Unreachable => {}
        }
        self.targets_mut().flat_map(|t| &mut t.args).for_each(f);
    }
}
