//! Predicates that hold wherever others do.

use crate::program::*;
use rustc_hash::FxHashSet;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Opcode;

/// How deep the definitions of predicates are followed.
const MAX_DEPTH: u32 = 6;

/// The logic that the predicates of a function are made by.
pub(super) struct Guards {
    logic: EntityMap<Value, Option<(Opcode, [Value; 2])>>,
    truths: FxHashSet<Value>,
}

impl Guards {
    pub(super) fn of(func: &Function) -> Guards {
        let mut guards = Guards {
            logic: EntityMap::filled(func.values.len(), None),
            truths: FxHashSet::default(),
        };
        for &inst in func.layout.iter().flat_map(|&b| &func.blocks[b].insts) {
            let InstData { kind, results, .. } = &func.insts[inst];
            match kind {
                InstKind::Const(Bits::Pred(true)) => guards.truths.extend(results),
                InstKind::Op { op, args, .. } if matches!(op, Opcode::Pand | Opcode::Por) => {
                    guards.logic[results[0]] = Some((*op, [args[0], args[1]]));
                }
                _ => {}
            }
        }
        guards
    }

    /// True of the constant *true*.
    pub(super) fn is_true(&self, guard: Value) -> bool {
        self.truths.contains(&guard)
    }

    /// True if a predicate surely holds wherever another one does.
    pub(super) fn implies(&self, one: Value, other: Value) -> bool {
        self.implies_within(one, other, MAX_DEPTH)
    }

    fn implies_within(&self, one: Value, other: Value, depth: u32) -> bool {
        if one == other || self.is_true(other) {
            return true;
        }
        let Some(depth) = depth.checked_sub(1) else {
            return false;
        };
        let logic = |value| self.logic.get(value).copied().flatten();
        if let Some((Opcode::Pand, [a, b])) = logic(other) {
            return self.implies_within(one, a, depth) && self.implies_within(one, b, depth);
        }
        if let Some((Opcode::Por, [a, b])) = logic(one) {
            return self.implies_within(a, other, depth) && self.implies_within(b, other, depth);
        }
        let by = |both: [Value; 2]| both.into_iter();
        match (logic(one), logic(other)) {
            (Some((_, both)), _) if by(both).any(|v| self.implies_within(v, other, depth)) => true,
            (_, Some((_, both))) => by(both).any(|v| self.implies_within(one, v, depth)),
            _ => false,
        }
    }
}
