//! The recurrences of a block that is a loop: which of its values lie on the way of a value around it.

use crate::program::*;
use rustc_hash::FxHashSet;

/// For each parameter that the block gives itself, the values of the block that depend on it, and those that what it
/// becomes depends on.
pub(super) struct Cycles(Vec<[FxHashSet<Value>; 2]>);

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
            [behind, before]
        };
        Cycles(around.map(of).collect())
    }

    /// True if there is none.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// True if the way of some value around the loop leads through `from`, and then through `to`.
    pub(super) fn has(&self, from: Value, to: Value) -> bool {
        (self.0.iter()).any(|[behind, before]| behind.contains(&from) && before.contains(&to))
    }
}
