//! Where the values of a function are defined and used, and where its blocks are entered from: found
//! once, and kept right while the loops of the function are taken out of it one by one.

use crate::pass::restrict_pointers_stay;
use crate::program::{Block, Function, Inst, InstData, Value};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::Ty;
use std::collections::BTreeSet;

/// Where a value is defined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Def {
    /// Parameter of a block, by position.
    Param(Block, usize),
    /// Result of an instruction.
    Inst(Block, Inst),
}

/// The places of one function.
pub(super) struct Places {
    pub(super) defs: EntityMap<Value, Option<Def>>,
    /// The blocks that use each value, each once.
    users: EntityMap<Value, Vec<Block>>,
    /// The blocks that jump to each block, each once, in the order of the layout.
    preds: EntityMap<Block, Vec<Block>>,
    /// Nothing that is loaded is based on a `restrict` pointer.
    pub(super) restrict_stays: bool,
}

impl Places {
    pub(super) fn of(func: &Function) -> Places {
        let mut places = Places {
            defs: EntityMap::filled(func.values.len(), None),
            users: EntityMap::filled(func.values.len(), Vec::new()),
            preds: EntityMap::filled(func.blocks.len(), Vec::new()),
            restrict_stays: restrict_pointers_stay(func),
        };
        for &block in &func.layout {
            places.add(func, block);
            for target in func.blocks[block].end.targets() {
                let preds = &mut places.preds[target.block];
                if preds.last() != Some(&block) {
                    preds.push(block);
                }
            }
        }
        places
    }

    /// The blocks that use a value.
    pub(super) fn users(&self, value: Value) -> &[Block] {
        &self.users[value]
    }

    /// The blocks that jump to a block, in the order of the layout.
    pub(super) fn preds(&self, block: Block) -> &[Block] {
        &self.preds[block]
    }

    /// Removes the uses in `block`, before it changes.
    pub(super) fn remove_uses(&mut self, func: &Function, block: Block) {
        for value in used(func, block) {
            self.users[value].retain(|user| *user != block);
        }
    }

    /// Removes the definitions and uses of the loop of one block `block`, and the loop itself.
    pub(super) fn remove(&mut self, func: &Function, block: Block) {
        self.remove_uses(func, block);
        for &inst in &func.blocks[block].insts {
            for &result in &func.insts[inst].results {
                self.defs[result] = None;
            }
        }
        self.preds[block].retain(|from| *from != block);
    }

    /// Notes what `block` defines and uses now. It jumps to where it did, but for itself.
    pub(super) fn add(&mut self, func: &Function, block: Block) {
        while self.defs.len() < func.values.len() {
            self.defs.push(None);
            self.users.push(Vec::new());
        }
        let data = &func.blocks[block];
        for (i, &param) in data.params.iter().enumerate() {
            self.defs[param] = Some(Def::Param(block, i));
        }
        for &inst in &data.insts {
            for &result in &func.insts[inst].results {
                self.defs[result] = Some(Def::Inst(block, inst));
            }
        }
        for value in used(func, block) {
            self.users[value].push(block);
        }
    }
}

/// The values that a block uses, each once.
fn used(func: &Function, block: Block) -> BTreeSet<Value> {
    let mut used = BTreeSet::new();
    let data = &func.blocks[block];
    for &inst in &data.insts {
        func.insts[inst].kind.for_each_use(|v| {
            used.insert(v);
        });
    }
    data.end.for_each_use(|v| {
        used.insert(v);
    });
    used
}

/// Values and instructions that are to be added to a function.
pub(super) struct Additions {
    values: Vec<Ty>,
    insts: Vec<InstData>,
    first_value: usize,
    first_inst: usize,
}

impl Additions {
    /// None yet.
    pub(super) fn to(func: &Function) -> Additions {
        Additions {
            values: Vec::new(),
            insts: Vec::new(),
            first_value: func.values.len(),
            first_inst: func.insts.len(),
        }
    }

    /// A new value.
    pub(super) fn value(&mut self, ty: Ty) -> Value {
        self.values.push(ty);
        Value::new(self.first_value + self.values.len() - 1)
    }

    /// A new instruction.
    pub(super) fn inst(&mut self, data: InstData) -> Inst {
        self.insts.push(data);
        Inst::new(self.first_inst + self.insts.len() - 1)
    }

    /// Adds them; nothing else was added since.
    pub(super) fn apply(self, func: &mut Function) {
        for ty in self.values {
            func.values.push(ty);
        }
        for data in self.insts {
            func.insts.push(data);
        }
    }
}
