//! The moves that make the values of `restrict` pointers, and the addresses of variables that a pragma
//! calls independent. They stand in the way of nothing but
//! [copy propagation](super::copyprop), and go when no loop needs to know of them any more.

use super::rename::Renames;
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Effect, Opcode};
use std::collections::{BTreeMap, BTreeSet};

/// The number of the `restrict` pointer or independent variable whose address an instruction makes.
pub(crate) fn restrict_number(kind: &InstKind) -> Option<u32> {
    match *kind {
        InstKind::Op {
            op: Opcode::Mov,
            imm: number @ 1..,
            ..
        } => Some(number.unsigned_abs()),
        _ => None,
    }
}

/// True if no address that may be based on a `restrict` pointer is stored, or passed on: then nothing that is loaded is based on one.
pub(crate) fn restrict_pointers_stay(func: &Function) -> bool {
    let mut based = EntityMap::<Value, bool>::filled(func.values.len(), false);
    loop {
        let mut changed = false;
        let mut set = |based: &mut EntityMap<Value, bool>, value: Value| {
            changed |= !based[value];
            based[value] = true;
        };
        for &block in &func.layout {
            for &inst in &func.blocks[block].insts {
                let InstData { kind, results, .. } = &func.insts[inst];
                let loads =
                    matches!(kind, InstKind::Op { op, .. } if op.info().effect == Effect::Load);
                let mut any = restrict_number(kind).is_some();
                kind.for_each_use(|value| any |= based[value]);
                if any && !loads {
                    results.iter().for_each(|&result| set(&mut based, result));
                }
            }
            for target in func.blocks[block].end.targets() {
                for (&param, &arg) in func.blocks[target.block].params.iter().zip(&target.args) {
                    if based[arg] {
                        set(&mut based, param);
                    }
                }
            }
        }
        if !changed {
            break;
        }
    }
    let insts = func.layout.iter().flat_map(|&b| &func.blocks[b].insts);
    insts.into_iter().all(|&inst| match &func.insts[inst].kind {
        InstKind::Op { op, args, .. } => match op.info().effect {
            // Behind the guard and the address.
            Effect::Store => args.iter().skip(2).all(|&value| !based[value]),
            Effect::Io => args.iter().all(|&value| !based[value]),
            Effect::Pure | Effect::Load | Effect::Prefetch => true,
        },
        InstKind::Call { args, .. } => args.iter().all(|&arg| !based[arg]),
        InstKind::Launch { .. } => false,
        _ => true,
    })
}

/// The numbers that a mark counts on.
fn counted_on(mark: &KernelMark) -> impl Iterator<Item = &u32> {
    let groups = mark.independence.groups.iter();
    mark.restrict.iter().chain(groups.flatten())
}

/// Forgets that the moves of a function make `restrict` pointers where no loop of it counts on that.
pub(super) fn forget_unused(func: &mut Function) {
    let marks = func.layout.iter().map(|&b| &func.blocks[b].kernel);
    let used: BTreeSet<u32> = marks.flatten().flat_map(counted_on).copied().collect();
    for inst in func.insts.values_mut() {
        if restrict_number(&inst.kind).is_some_and(|number| !used.contains(&number))
            && let InstKind::Op { imm, .. } = &mut inst.kind
        {
            *imm = 0;
        }
    }
}

/// Takes the moves that make `restrict` pointers out of a function: nothing asks for them after the
/// split.
pub(crate) fn settle_restrict(func: &mut Function) {
    let mut renames = Renames::default();
    for &block in &func.layout {
        let insts = &func.insts;
        let mut kept = std::mem::take(&mut func.blocks[block].insts);
        kept.retain(|&inst| {
            let data = &insts[inst];
            let found = restrict_number(&data.kind).is_some();
            if found {
                let source = renames.find(data.kind.args()[0]);
                // Code that is never reached may move values in a circle.
                if source == data.results[0] {
                    return true;
                }
                renames.replace(data.results[0], source);
            }
            !found
        });
        func.blocks[block].insts = kept;
    }
    renames.apply(func);
}

/// Numbers for the `restrict` pointers of copied functions.
pub(super) struct FreshNumbers(u32);

impl FreshNumbers {
    /// Numbers that a program does not have.
    pub(super) fn of(program: &Program) -> FreshNumbers {
        let insts = program.funcs.values().flat_map(|f| f.insts.values());
        let numbers = insts.filter_map(|inst| restrict_number(&inst.kind));
        let marks = program.funcs.values().flat_map(|f| f.blocks.values());
        let listed = marks.filter_map(|b| b.kernel.as_ref()).flat_map(counted_on);
        FreshNumbers(numbers.chain(listed.copied()).max().unwrap_or(0))
    }

    /// Renumbers the `restrict` pointers in a copy of a function: `insts` and the marks of
    /// `blocks`.
    pub(super) fn renumber<'a>(
        &mut self,
        insts: impl Iterator<Item = &'a mut InstData>,
        marks: impl Iterator<Item = &'a mut KernelMark>,
    ) {
        let mut fresh = BTreeMap::new();
        let mut number = |old: u32| {
            *fresh.entry(old).or_insert_with(|| {
                self.0 += 1;
                self.0
            })
        };
        for inst in insts {
            if let Some(old) = restrict_number(&inst.kind)
                && let InstKind::Op { imm, .. } = &mut inst.kind
            {
                *imm = i32::try_from(number(old)).unwrap_or(0);
            }
        }
        for mark in marks {
            let groups = mark.independence.groups.iter_mut();
            let all = mark.restrict.iter_mut().chain(groups.flatten());
            all.for_each(|n| *n = number(*n));
        }
    }
}
