//! The recurrences of a block that is a loop: which of its values lie on the way of a value around it.

use crate::program::*;
use rustc_hash::{FxHashMap, FxHashSet};
use srp_archdesc::isa::{Class, Opcode};

/// The recurrences of a block.
pub(super) struct Cycles(Vec<Cycle>);

/// The recurrence of a parameter that the block gives itself.
struct Cycle {
    param: Value,
    /// The values of the block that depend on it.
    behind: FxHashSet<Value>,
    /// Those that what it becomes depends on.
    before: FxHashSet<Value>,
}

impl Cycles {
    /// The recurrences of a block; none where it does not lead to itself.
    pub(super) fn of(func: &Function, block: Block) -> Cycles {
        let data = &func.blocks[block];
        let back = data.end.targets().filter(|target| target.block == block);
        let around = back.flat_map(|target| data.params.iter().zip(&target.args));
        let of = |(&param, &next): (&Value, &Value)| {
            let (mut behind, mut before) = (FxHashSet::default(), FxHashSet::default());
            behind.insert(param);
            before.insert(next);
            for &inst in &data.insts {
                let mut depends = false;
                func.insts[inst]
                    .kind
                    .for_each_use(|v| depends |= behind.contains(&v));
                if depends {
                    behind.extend(&func.insts[inst].results);
                }
            }
            for &inst in data.insts.iter().rev() {
                let made = &func.insts[inst];
                if made.results.iter().any(|v| before.contains(v)) {
                    made.kind.for_each_use(|v| {
                        before.insert(v);
                    });
                }
            }
            Cycle {
                param,
                behind,
                before,
            }
        };
        Cycles(around.map(of).collect())
    }

    /// True if there is none.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// True if the way of some value around the loop leads through `from`, and then through `to`.
    pub(super) fn has(&self, from: Value, to: Value) -> bool {
        (self.0.iter()).any(|cycle| cycle.behind.contains(&from) && cycle.before.contains(&to))
    }

    /// The cycles, about, from the parameters whose ways around the loop lead through `to` to each value that
    /// depends on them.
    pub(super) fn waits(&self, func: &Function, block: Block, to: Value) -> FxHashMap<Value, u32> {
        let mut waits = FxHashMap::default();
        let through = |cycle: &&Cycle| cycle.behind.contains(&to) && cycle.before.contains(&to);
        waits.extend(self.0.iter().filter(through).map(|cycle| (cycle.param, 0)));
        for &inst in &func.blocks[block].insts {
            let InstData { kind, results, .. } = &func.insts[inst];
            let mut from = None;
            kind.for_each_use(|v| from = from.max(waits.get(&v).copied()));
            if let Some(from) = from {
                let stands = match kind {
                    InstKind::Op { op, .. } => from + latency(*op),
                    _ => from + 1,
                };
                waits.extend(results.iter().map(|&v| (v, stands)));
            }
        }
        waits
    }
}

/// About how many cycles an integer operation takes: machines differ, but products take no less than sums.
pub(super) fn latency(op: Opcode) -> u32 {
    match op.class() {
        Class::Imul => 2,
        Class::Load | Class::Cload => 3,
        _ => 1,
    }
}
