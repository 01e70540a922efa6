//! Dropping functions that nothing needs.

use crate::program::*;
use srp_archdesc::entity::EntityMap;

/// Drops the functions that `main` does not reach by calls or addresses, its own or those in
/// globals, and numbers the others anew in their order. Where there is no `main`, all are needed but the helpers of
/// the library that nothing calls.
pub(super) fn prune(program: &mut Program) {
    let mut needed = EntityMap::<Func, bool>::filled(program.funcs.len(), false);
    let is_helper = |id: &Func| program.funcs[*id].name.starts_with("__srp_");
    let mut work: Vec<Func> = match program.main {
        Some(main) => vec![main],
        None => program.funcs.keys().filter(|id| !is_helper(id)).collect(),
    };
    let relocs = program.globals.values().flat_map(|g| &g.relocs);
    work.extend(relocs.filter_map(|r| match r.symbol {
        Symbol::Func(func) => Some(func),
        Symbol::Global(_) => None,
    }));
    while let Some(id) = work.pop() {
        if std::mem::replace(&mut needed[id], true) {
            continue;
        }
        let func = &program.funcs[id];
        for &inst in func.layout.iter().flat_map(|&b| &func.blocks[b].insts) {
            match func.insts[inst].kind {
                InstKind::Call {
                    callee: Callee::Func(callee),
                    ..
                } => work.push(callee),
                InstKind::SymbolAddr(Symbol::Func(func), _) => work.push(func),
                _ => {}
            }
        }
    }
    let mut kept = EntityMap::new();
    let old = std::mem::take(&mut program.funcs).into_values();
    let numbers: EntityMap<Func, Option<Func>> = old
        .zip(needed.values())
        .map(|(func, &needed)| needed.then(|| kept.push(func)))
        .collect();
    program.funcs = kept;
    let number = |func: &mut Func| {
        // Instructions that are in no block may name functions that were dropped before.
        if let Some(&Some(new)) = numbers.get(*func) {
            *func = new;
        }
    };
    program.main.iter_mut().for_each(number);
    for reloc in program.globals.values_mut().flat_map(|g| &mut g.relocs) {
        if let Symbol::Func(func) = &mut reloc.symbol {
            number(func);
        }
    }
    for inst in program
        .funcs
        .values_mut()
        .flat_map(|f| f.insts.values_mut())
    {
        match &mut inst.kind {
            InstKind::Call {
                callee: Callee::Func(callee),
                ..
            } => number(callee),
            InstKind::SymbolAddr(Symbol::Func(func), _) => number(func),
            _ => {}
        }
    }
}
