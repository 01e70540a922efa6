//! Values that pass between functions, and between control code and kernels: more than there are
//! registers, of all types, directly and through pointers.

use super::engine::End;
use super::{compare, compare_program, machines, strange_machine};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::dfg::{Dfg, Initial, LiveIn, Node, NodeData, Operand};
use srp_ir::dre::Dre;
use srp_ir::dre::scheduled::{ModuloSchedule, Placed, PlacedOp, RegAt};
use srp_ir::program::*;
use srp_scheduler::abi;

fn types(rng: &mut Pcg32, count: u32) -> Vec<Ty> {
    let ty = |_| Ty::ALL[(rng.next_u32() % 3) as usize];
    (0..count).map(ty).collect()
}

fn constant(ty: Ty, number: u32) -> Bits {
    match ty {
        Ty::Pred => Bits::Pred(number.is_multiple_of(3)),
        _ => Bits::of_lanes(ty, [number, !number, number * 7, number ^ 0x55]),
    }
}

/// Appends words that tell all of `values`, each of them multiplied by its place, into a sum.
fn fold(func: &mut Function, block: Block, values: &[Value], pos: Pos) -> Value {
    let mut sum = func.append_const(block, Bits::Word(1), pos);
    for &value in values {
        let word = match func.values[value] {
            Ty::Word => Some(value),
            Ty::Pred => func.append_op(block, Opcode::Ptoi, &[value], 0, pos),
            Ty::Vec => func.append_op(block, Opcode::Vext, &[value], 2, pos),
        };
        let factor = func.append_const(block, Bits::Word(31), pos);
        let product = func.append_op(block, Opcode::Mul, &[sum, factor], 0, pos);
        let args = [product.expect("a product"), word.expect("a word")];
        sum = func
            .append_op(block, Opcode::Add, &args, 0, pos)
            .expect("a sum");
    }
    sum
}

fn give(func: &mut Function, block: Block, pos: Pos, to: i32, value: Value) {
    func.append_op(block, Opcode::Out, &[value], to, pos);
}

/// A function that takes values of `params`, writes out their sum, and returns some of them.
fn echo(params: &[Ty], results: &[Ty], pos: Pos) -> Function {
    let mut func = Function::new("echo", params, results.to_vec(), pos);
    let entry = func.entry();
    let values = func.blocks[entry].params.clone();
    let sum = fold(&mut func, entry, &values, pos);
    give(&mut func, entry, pos, 20, sum);
    let pick = |func: &mut Function, i: usize, ty: Ty| {
        let fits = values.iter().rev().filter(|&&v| func.values[v] == ty);
        let fits: Vec<Value> = fits.copied().collect();
        match fits.get(i % fits.len().max(1)) {
            Some(&value) => value,
            None => func.append_const(entry, constant(ty, i as u32), pos),
        }
    };
    let back = results.iter().enumerate();
    let back = back.map(|(i, &ty)| pick(&mut func, i, ty)).collect();
    func.blocks[entry].end = Terminator::Return(back);
    func
}

/// A `main` that calls `echo` three times, values living across the calls.
fn caller(params: &[Ty], results: &[Ty], pos: Pos) -> Function {
    let mut func = Function::new("main", &[Ty::Word; 2], vec![Ty::Word], pos);
    let entry = func.entry();
    let mut args: Vec<Value> = Vec::new();
    for (i, &ty) in params.iter().enumerate() {
        let bits = constant(ty, i as u32);
        args.push(func.append_const(entry, bits, pos));
    }
    let mut all = Vec::new();
    for round in 0..3 {
        let callee = if round == 1 {
            let kind = InstKind::SymbolAddr(Symbol::Func(Func::new(0)), 0);
            let inst = func.append(entry, kind, &[Ty::Word], pos);
            Callee::Indirect(func.insts[inst].results[0], results.to_vec())
        } else {
            Callee::Func(Func::new(0))
        };
        let kind = InstKind::Call {
            callee,
            args: args.clone(),
        };
        let inst = func.append(entry, kind, results, pos);
        let got = func.insts[inst].results.clone();
        // The next call gets what this one gave, where the types allow it.
        for (i, &ty) in params.iter().enumerate() {
            let fits = got.iter().find(|&&v| func.values[v] == ty);
            if i % 2 == round % 2 {
                args[i] = fits.copied().unwrap_or(args[i]);
            }
        }
        all.extend(got);
    }
    let sum = fold(&mut func, entry, &all, pos);
    func.blocks[entry].end = Terminator::Return(vec![sum]);
    func
}

#[test]
fn calls_pass_any_number_of_values() {
    let pos = Pos::nowhere();
    let shipped = machines();
    for seed in 0..60u64 {
        let mut rng = Pcg32::new(seed, 11);
        let (params, results) = (rng.next_u32() % 40, 1 + rng.next_u32() % 30);
        let (params, results) = (types(&mut rng, params), types(&mut rng, results));
        let mut program = Program::default();
        program.funcs.push(echo(&params, &results, pos));
        program.main = Some(program.funcs.push(caller(&params, &results, pos)));
        assert_eq!(srp_ir::verify(&program), Ok(()));
        let strange = strange_machine(seed);
        for arch in shipped.iter().chain([&strange]) {
            compare_program(&format!("seed {seed}"), &program, arch);
        }
    }
}

/// A loop that sums words and turns a predicate and a vector round, with `extra` more live-ins.
fn kernel(extra: &[Ty]) -> Dfg {
    let pos = Pos::nowhere();
    let mut types = vec![Ty::Word, Ty::Word, Ty::Pred, Ty::Vec];
    types.extend(extra);
    let mut nodes = EntityMap::new();
    let mut node = |op, operands| {
        nodes.push(NodeData {
            op,
            operands,
            imm: 0,
            pos,
        })
    };
    let carried = |n: usize, k: u32| Operand::Node {
        node: Node::new(n),
        init: vec![Initial::LiveIn(k)],
    };
    node(Opcode::Add, vec![carried(0, 1), Operand::LiveIn(0)]);
    node(Opcode::Pnot, vec![carried(1, 2)]);
    node(Opcode::Vadd, vec![carried(2, 3), carried(2, 3)]);
    let live_in = |&ty: &Ty| LiveIn { ty, pos };
    Dfg {
        name: "turn".to_owned(),
        pos,
        live_ins: types.iter().map(live_in).collect(),
        trip: Some(0),
        nodes,
        order: Vec::new(),
        assumed: Vec::new(),
        live_outs: (0..3).map(Node::new).collect(),
    }
}

/// Where a kernel's values pass and what it overwrites; the engine of these tests needs no more.
fn interface(dfg: Dfg, arch: &Arch, rng: &mut Pcg32) -> Option<ModuloSchedule> {
    let ins = abi::passing(&arch.srp, dfg.live_ins.iter().map(|l| l.ty));
    let outs = abi::passing(&arch.srp, dfg.live_outs.iter().filter_map(|&n| dfg.ty(n)));
    let writes = Ty::ALL.map(|ty| {
        let file = abi::file(&arch.srp, ty);
        let count = abi::allocatable(&arch.srp, ty);
        let index = rng.next_u32() % count;
        let ring = 1 + rng.next_u32() % (count - index);
        RegAt { file, index, ring }
    });
    let ops: EntityMap<Placed, PlacedOp> = dfg
        .nodes
        .keys()
        .zip(writes)
        .map(|(node, write)| PlacedOp {
            node,
            is_move: false,
            fu: arch.srp.slots()[0],
            time: 0,
            operands: Vec::new(),
            writes: vec![write],
        })
        .collect();
    Some(ModuloSchedule {
        ii: 1,
        length: 1,
        ops,
        transfers: Vec::new(),
        hops: Vec::new(),
        preloads: Vec::new(),
        live_in_regs: ins.into_iter().collect::<Option<_>>()?,
        live_out_regs: outs.into_iter().collect::<Option<_>>()?,
        dfg,
    })
}

#[test]
fn launches_keep_what_the_kernel_does_not_write() {
    let pos = Pos::nowhere();
    let mut launched = 0;
    for seed in 0..200u64 {
        let mut rng = Pcg32::new(seed, 13);
        let count = rng.next_u32() % 4;
        let dfg = kernel(&types(&mut rng, count));
        let arch = match seed % 4 {
            0..3 => machines()[(seed % 4) as usize].clone(),
            _ => strange_machine(seed),
        };
        let Some(schedule) = interface(dfg.clone(), &arch, &mut rng) else {
            continue;
        };
        launched += 1;
        let mut func = Function::new("main", &[], vec![Ty::Word], pos);
        let entry = func.entry();
        let mut values: Vec<Value> = Vec::new();
        for i in 0..24 {
            // Sums of what comes in: nothing that could be made anew.
            let ty = Ty::ALL[(rng.next_u32() % 3) as usize];
            let bits = constant(ty, 2 + i);
            let value = func.append_const(entry, bits, pos);
            let op = Opcode::mov(ty);
            let moved = func.append_op(entry, op, &[value], 0, pos);
            values.push(moved.expect("a move has a result"));
        }
        for round in 0..3 {
            let trip = func.append_const(entry, Bits::Word(1 + round), pos);
            let mut args = vec![trip];
            for live_in in &dfg.live_ins[1..] {
                let fits = values.iter().filter(|&&v| func.values[v] == live_in.ty);
                let fits: Vec<Value> = fits.copied().collect();
                args.push(
                    match fits.get(rng.next_u32() as usize % fits.len().max(1)) {
                        Some(&value) => value,
                        None => func.append_const(entry, constant(live_in.ty, 9), pos),
                    },
                );
            }
            let kind = InstKind::Launch {
                kernel: Kernel::new(0),
                args,
            };
            let inst = func.append(entry, kind, &[Ty::Word, Ty::Pred, Ty::Vec], pos);
            values.extend(func.insts[inst].results.clone());
        }
        let sum = fold(&mut func, entry, &values, pos);
        func.blocks[entry].end = Terminator::Return(vec![sum]);
        let mut control = Program::default();
        control.main = Some(control.funcs.push(func));
        let dre = Dre {
            control,
            kernels: [dfg].into_iter().collect(),
        };
        let kernels = [schedule].into_iter().collect();
        let end = compare(&format!("seed {seed}"), &dre, kernels, &arch);
        assert!(matches!(end, End::Halted(_)));
    }
    assert!(
        launched > 150,
        "most machines have the registers: {launched}"
    );
}
