//! Estimates what loops take on an array with common units, so that a form can be chosen.

use crate::flow::Flow;
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Class, Effect, Opcode};

/// Cycles of a launch beyond its iterations.
const LAUNCH: u32 = 32;

/// Operations of an array in a cycle, most of the time; accesses; and the cycles for which special
/// functions and divisions keep their only unit.
const OPERATIONS: u32 = 11;
const ACCESSES: u32 = 4;
const SPECIAL: u32 = 2;
const DIVISION: u32 = 4;

/// A body, as far as an estimate looks at it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Work {
    operations: u32,
    /// Sums and shifts of integers among them: of those that make addresses little is left.
    integers: u32,
    accesses: u32,
    special: u32,
    divisions: u32,
}

impl Work {
    /// Adds a block that runs so often. None where no array can run it: a port, a function that is
    /// not simple.
    pub(super) fn add(
        &mut self,
        func: &Function,
        block: Block,
        times: u32,
        callees: &Callees,
    ) -> Option<()> {
        for &inst in &func.blocks[block].insts {
            let one = match &func.insts[inst].kind {
                InstKind::Op { op, .. } => match (op.info().effect, op.class()) {
                    (Effect::Io, _) => return None,
                    (Effect::Load | Effect::Store | Effect::Prefetch, _) => Work {
                        operations: 1,
                        accesses: 1,
                        ..Work::default()
                    },
                    (_, class) => Work {
                        operations: 1,
                        integers: u32::from(matches!(
                            op,
                            Opcode::Add | Opcode::Sub | Opcode::Shl | Opcode::Mul
                        )),
                        special: u32::from(matches!(class, Class::Sfu | Class::Fast)),
                        divisions: u32::from(matches!(class, Class::Fdiv | Class::Idiv)),
                        ..Work::default()
                    },
                },
                InstKind::Call {
                    callee: Callee::Func(callee),
                    ..
                } => callees.simple[*callee]?,
                InstKind::Call { .. } | InstKind::Launch { .. } => return None,
                InstKind::Const(_) | InstKind::SymbolAddr(..) | InstKind::SlotAddr(..) => continue,
            };
            self.operations += times * one.operations;
            self.integers += times * one.integers;
            self.accesses += times * one.accesses;
            self.special += times * one.special;
            self.divisions += times * one.divisions;
        }
        Some(())
    }

    /// Adds what another body does.
    pub(super) fn and(&mut self, other: &Work) {
        self.operations += other.operations;
        self.integers += other.integers;
        self.accesses += other.accesses;
        self.special += other.special;
        self.divisions += other.divisions;
    }

    /// Operations that are left when addresses are sums of constants.
    pub(super) fn size(&self) -> u32 {
        self.operations - self.integers * 2 / 3
    }

    /// Cycles from one iteration to the next.
    pub(super) fn interval(&self) -> u32 {
        let units = [
            self.size().div_ceil(OPERATIONS),
            self.accesses.div_ceil(ACCESSES),
            self.special * SPECIAL,
            self.divisions * DIVISION,
        ];
        units.into_iter().max().unwrap_or(1).max(1)
    }

    /// Cycles of a launch of so many iterations.
    pub(super) fn launched(&self, trip: u32) -> u32 {
        LAUNCH + trip * self.interval()
    }
}

/// Which functions can be put into a kernel, and what they do there.
pub(super) struct Callees {
    simple: EntityMap<Func, Option<Work>>,
}

impl Callees {
    /// Of functions that are simple themselves and call simple ones only: no loops, no ports.
    pub(super) fn of(program: &Program) -> Callees {
        let mut callees = Callees {
            simple: EntityMap::filled(program.funcs.len(), None),
        };
        let mut straight: Vec<(Func, &Function)> = program.funcs.iter().collect();
        straight.retain(|(_, func)| Flow::of(func).loops.loops.is_empty());
        // Callees first, as deep as functions are called in practice.
        for _ in 0..4 {
            let mut changed = false;
            for &(id, func) in &straight {
                if callees.simple[id].is_some() {
                    continue;
                }
                let mut work = Work::default();
                let add = |&block: &Block| work.add(func, block, 1, &callees);
                if func.layout.iter().try_for_each(add).is_some() {
                    callees.simple[id] = Some(work);
                    changed = true;
                }
            }
            if !changed {
                break;
            }
        }
        callees
    }
}
