//! Loads of globals that nothing writes.

use super::alias::{Object, Objects};
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Effect, Opcode};

/// Replaces loads from known places of globals whose values never change by constants. Only where
/// there is a `main`: then the whole program is known.
pub(crate) fn constants(program: &mut Program) -> bool {
    if program.main.is_none() {
        return false;
    }
    let fixed = never_written(program);
    let Program { globals, funcs, .. } = program;
    let changed = funcs
        .values_mut()
        .map(|f| load_constants(f, globals, &fixed));
    changed.fold(false, |any, changed| any | changed)
}

/// Replaces the loads of one function from known places of globals that are fixed.
pub(super) fn load_constants(
    func: &mut Function,
    globals: &EntityMap<Global, GlobalData>,
    fixed: &EntityMap<Global, bool>,
) -> bool {
    let mut places = EntityMap::<Value, Option<(Global, i32)>>::filled(func.values.len(), None);
    for i in 0..func.layout.len() {
        for &inst in &func.blocks[func.layout[i]].insts {
            if let InstKind::SymbolAddr(Symbol::Global(global), offset) = func.insts[inst].kind {
                places[func.insts[inst].results[0]] = Some((global, offset));
            }
        }
    }
    let mut truths = EntityMap::<Value, bool>::filled(func.values.len(), false);
    for data in func.insts.values() {
        if let InstKind::Const(Bits::Pred(true)) = data.kind {
            truths[data.results[0]] = true;
        }
    }
    let mut changed = false;
    for i in 0..func.layout.len() {
        let block = func.layout[i];
        for at in 0..func.blocks[block].insts.len() {
            let inst = func.blocks[block].insts[at];
            let InstKind::Op { op, args, imm } = &func.insts[inst].kind else {
                continue;
            };
            let Some((global, offset)) = args.get(1).and_then(|&a| places[a]) else {
                continue;
            };
            if op.info().effect != Effect::Load || !fixed[global] || !truths[args[0]] {
                continue;
            }
            let start = i64::from(offset) + i64::from(*imm);
            if let Some(bits) = loaded(&globals[global], *op, start) {
                func.insts[inst].kind = InstKind::Const(bits);
                changed = true;
            }
        }
    }
    changed
}

/// The globals that no instruction can write: their addresses go nowhere but into loads.
pub(super) fn never_written(program: &Program) -> EntityMap<Global, bool> {
    let mut fixed = EntityMap::filled(program.globals.len(), true);
    for reloc in program.globals.values().flat_map(|g| &g.relocs) {
        if let Symbol::Global(global) = reloc.symbol {
            fixed[global] = false;
        }
    }
    for func in program.funcs.values() {
        let objects = Objects::of(func);
        let spoil = |value: Value, fixed: &mut EntityMap<Global, bool>| {
            if let Some(Object::Symbol(Symbol::Global(global))) = objects.object(value) {
                fixed[global] = false;
            }
        };
        // What mixes addresses, so that nothing is known of the result any more, gives them away.
        let mixes = |result: Value| objects.object(result).is_none() && !objects.is_number(result);
        for &block in &func.layout {
            for &inst in &func.blocks[block].insts {
                let InstData { kind, results, .. } = &func.insts[inst];
                match kind {
                    InstKind::Op { op, args, .. } => match op.info().effect {
                        Effect::Load => {}
                        Effect::Pure if !results.iter().any(|&r| mixes(r)) && kept(*op) => {}
                        _ => args.iter().for_each(|&arg| spoil(arg, &mut fixed)),
                    },
                    InstKind::Call { .. } | InstKind::Launch { .. } => {
                        kind.for_each_use(|arg| spoil(arg, &mut fixed));
                    }
                    InstKind::Const(_) | InstKind::SymbolAddr(..) | InstKind::SlotAddr(..) => {}
                }
            }
            match &func.blocks[block].end {
                Terminator::Return(values) => values.iter().for_each(|&v| spoil(v, &mut fixed)),
                end => {
                    for target in end.targets() {
                        let params = &func.blocks[target.block].params;
                        for (&param, &arg) in params.iter().zip(&target.args) {
                            if mixes(param) {
                                spoil(arg, &mut fixed);
                            }
                        }
                    }
                }
            }
        }
    }
    fixed
}

/// True if an operation on an address returns an address of the same object, or a number that
/// cannot serve as an address.
fn kept(op: Opcode) -> bool {
    matches!(
        op,
        Opcode::Mov | Opcode::Add | Opcode::Sub | Opcode::Sel | Opcode::And | Opcode::Or
    ) || op.result() != Some(srp_archdesc::isa::Ty::Word) && op.result().is_some()
}

/// Returns the constant that a load at an offset of a global reads; `None` if it is outside or
/// reads an address.
fn loaded(global: &GlobalData, op: Opcode, start: i64) -> Option<Bits> {
    let bytes = op.access_bytes()?;
    let start = u32::try_from(start).ok()?;
    let end = start.checked_add(bytes).filter(|&end| end <= global.size)?;
    if !start.is_multiple_of(bytes) || bytes > global.align {
        return None;
    }
    let touches = |r: &Reloc| r.offset < end && start < r.offset + 4;
    if global.relocs.iter().any(touches) {
        return None;
    }
    let byte = |at: u32| global.init.get(at as usize).copied().unwrap_or(0);
    let word = |at: u32| u32::from_le_bytes([byte(at), byte(at + 1), byte(at + 2), byte(at + 3)]);
    let half = || u16::from_le_bytes([byte(start), byte(start + 1)]);
    Some(match op {
        Opcode::Lb => Bits::Word(i32::from(byte(start) as i8) as u32),
        Opcode::Lbu => Bits::Word(byte(start).into()),
        Opcode::Lh => Bits::Word(i32::from(half() as i16) as u32),
        Opcode::Lhu => Bits::Word(half().into()),
        Opcode::Lw => Bits::Word(word(start)),
        Opcode::Lv => Bits::Vec([start, start + 4, start + 8, start + 12].map(word)),
        _ => return None,
    })
}
