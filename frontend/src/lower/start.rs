//! Where a program starts whose `main` takes arguments or returns nothing.

use srp_archdesc::isa::Ty;
use srp_ir::program::{
    Bits, Callee, Function, Global, GlobalData, InstKind, Program, Reloc, Symbol, Terminator,
};

/// The name that the program gets as `argv[0]`.
const NAME: &[u8] = b"program\0";

/// Makes a function that calls `main` with its own name as the only argument, where `main` takes
/// any.
pub(super) fn with_arguments(program: &mut Program) {
    let Some(main) = program.main else {
        return;
    };
    let data = &program.funcs[main];
    let entry = data.entry();
    let params: Vec<Ty> = data.blocks[entry]
        .params
        .iter()
        .map(|&param| data.values[param])
        .collect();
    let (pos, results) = (data.pos, data.results.clone());
    if params.is_empty() {
        return;
    }
    let global = |name: &str, init: Vec<u8>, align, relocs| GlobalData {
        name: name.to_owned(),
        size: init.len() as u32,
        align,
        init,
        relocs,
        pos,
    };
    let name = program
        .globals
        .push(global(".name", NAME.to_vec(), 1, Vec::new()));
    let list = program.globals.push(global(
        ".arguments",
        vec![0; 8],
        4,
        vec![Reloc {
            offset: 0,
            symbol: Symbol::Global(name),
            addend: 0,
        }],
    ));
    let mut start = Function::new(".start", &[], results.clone(), pos);
    let block = start.entry();
    let address = |start: &mut Function, global: Global, offset| {
        let kind = InstKind::SymbolAddr(Symbol::Global(global), offset);
        let inst = start.append(block, kind, &[Ty::Word], pos);
        start.insts[inst].results[0]
    };
    let args = params.iter().enumerate().map(|(i, _)| match i {
        0 => start.append_const(block, Bits::Word(1), pos),
        1 => address(&mut start, list, 0),
        // The environment, which is empty.
        _ => address(&mut start, list, 4),
    });
    let args = args.collect();
    let kind = InstKind::Call {
        callee: Callee::Func(main),
        args,
    };
    let call = start.append(block, kind, &results, pos);
    let values = start.insts[call].results.clone();
    start.blocks[block].end = Terminator::Return(values);
    start.blocks[block].end_pos = pos;
    program.main = Some(program.funcs.push(start));
}
