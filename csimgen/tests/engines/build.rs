//! Scheduled programs written by hand.

use srp_archdesc::Arch;
use srp_archdesc::arch::{Fu, Input, Link, RegFile, Wire, WireSpec};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::check::{Checked, check};
use srp_ir::dfg::{Dfg, Initial, LiveIn, Node, NodeData, Operand};
use srp_ir::dre::scheduled::*;
use srp_ir::program::{Bits, Kernel, Pos, SourceFile};

/// The machine that the cases are written for: with two ports to the SRAM, so that it can be read and
/// written in one cycle, with two constants in a context, and with wires: from unit 0 to unit 1, from there on
/// to unit 3, and from there, or unit 1, through two registers back to unit 1.
pub(crate) fn tiny() -> Arch {
    let tiny = srp_archdesc::parse("tiny.xml", srp_archdesc::machines::TINY.xml);
    let mut arch = tiny.expect("it is shipped");
    let mut resources = arch.srp.resources.values_mut();
    let port = resources.find(|resource| resource.name == "sram_port");
    port.expect("a resource of the machine").count = 2;
    arch.srp.fus.values_mut().for_each(|fu| fu.constants = 2);
    let unit = |fu| Input::Unit(Fu::new(fu));
    let wire = |wire| Input::Wire(Wire::new(wire));
    let wires = [
        (vec![unit(0)], 1, 0),
        (vec![unit(0), wire(0)], 3, 0),
        (vec![unit(1), wire(1)], 1, 2),
    ];
    let spec = |(from, to, delay)| WireSpec {
        name: "wire".to_owned(),
        from,
        to: vec![Fu::new(to)],
        delay,
        width: 32,
    };
    arch.srp.wires = wires.into_iter().map(spec).collect();
    arch.srp.hops = 3;
    arch
}

/// A program that must keep the rules of its machine.
pub(crate) fn checked(program: ScheduledDre, arch: &Arch) -> Checked {
    check(program, arch).unwrap_or_else(|refused| panic!("{refused}"))
}

/// Line `line` of the cases' imaginary source.
pub(crate) fn pos(line: u32) -> Pos {
    Pos {
        file: SourceFile::new(0),
        line,
        column: 1,
    }
}

/// The file called `name` in the machine.
pub(crate) fn file(name: &str) -> RegFile {
    let arch = tiny();
    let found = arch.srp.files.iter().find(|(_, f)| f.name == name);
    found.expect("a file of the machine").0
}

pub(crate) fn reg(name: &str, index: u32) -> Reg {
    Reg {
        file: file(name),
        index,
    }
}

/// Word register `index`.
pub(crate) fn w(index: u32) -> Reg {
    reg("word", index)
}

/// Vector register `index`.
pub(crate) fn v(index: u32) -> Reg {
    reg("vec", index)
}

/// Predicate register `index`.
pub(crate) fn p(index: u32) -> Reg {
    reg("pred", index)
}

/// A word operand.
pub(crate) fn k(word: u32) -> Src {
    Src::Const(Bits::Word(word))
}

/// The guard that is always true.
pub(crate) fn yes() -> Src {
    Src::Const(Bits::Pred(true))
}

/// An operation in slot `slot`, at line `line`.
pub(crate) fn op(slot: usize, op: Opcode, srcs: &[Src], dst: Option<Reg>, line: u32) -> SlotOp {
    SlotOp {
        fu: Fu::new(slot),
        op,
        srcs: srcs.to_vec(),
        imm: 0,
        dst,
        pos: pos(line),
    }
}

/// With an immediate.
pub(crate) fn with_imm(mut op: SlotOp, imm: i32) -> SlotOp {
    op.imm = imm;
    op
}

/// A bundle without control transfer.
pub(crate) fn ops(ops: &[SlotOp]) -> BundleData {
    BundleData {
        ops: ops.to_vec(),
        control: None,
    }
}

/// A bundle with control transfer, at line `line`.
pub(crate) fn then(ops: &[SlotOp], control: Control, line: u32) -> BundleData {
    BundleData {
        ops: ops.to_vec(),
        control: Some((control, pos(line))),
    }
}

/// Bundle `index` of the case.
pub(crate) fn b(index: usize) -> Bundle {
    Bundle::new(index)
}

/// Stores `value` at `address` from slot 0.
pub(crate) fn put(address: u32, value: Reg) -> BundleData {
    ops(&[op(
        0,
        Opcode::Sw,
        &[yes(), k(address), Src::Reg(value)],
        None,
        0,
    )])
}

/// A case's program: its bundles begin at 0 and its kernels too.
#[derive(Clone, Default)]
pub(crate) struct Code {
    pub(crate) bundles: Vec<BundleData>,
    pub(crate) kernels: Vec<ModuloSchedule>,
    /// Entries of functions, in bundles of the case.
    pub(crate) functions: Vec<usize>,
}

/// One operation of a kernel: its opcode, unit, time, operands and their places, and further places of its
/// result.
pub(crate) struct KernelOp {
    pub(crate) op: Opcode,
    pub(crate) fu: usize,
    pub(crate) time: u32,
    pub(crate) operands: Vec<Take>,
    pub(crate) writes: Vec<RegAt>,
    pub(crate) imm: i32,
}

/// An operand of a kernel's operation: where it is taken from, and what must be found there.
pub(crate) type Take = (Source, Operand);

pub(crate) fn kop(
    op: Opcode,
    fu: usize,
    time: u32,
    operands: &[Take],
    writes: &[RegAt],
) -> KernelOp {
    KernelOp {
        op,
        fu,
        time,
        operands: operands.to_vec(),
        writes: writes.to_vec(),
        imm: 0,
    }
}

/// A word constant of a context.
pub(crate) fn c(word: u32) -> Take {
    let bits = Bits::Word(word);
    (Source::Const(bits), Operand::Const(bits))
}

/// A predicate constant of a context.
pub(crate) fn cp(value: bool) -> Take {
    let bits = Bits::Pred(value);
    (Source::Const(bits), Operand::Const(bits))
}

/// The result of node `node` in this iteration.
pub(crate) fn now(node: usize) -> Operand {
    before(node, &[])
}

/// The result of node `node` as many iterations before as there are initial values.
pub(crate) fn before(node: usize, init: &[Initial]) -> Operand {
    Operand::Node {
        node: Node::new(node),
        init: init.to_vec(),
    }
}

/// A value in the unit's own output.
pub(crate) fn own(value: Operand) -> Take {
    (Source::Out(None), value)
}

/// A value in another unit's output, over link `link`.
pub(crate) fn over(link: usize, value: Operand) -> Take {
    (Source::Out(Some(Link::new(link))), value)
}

/// A value on wire `wire`.
pub(crate) fn on(wire: usize, value: Operand) -> Take {
    (Source::Wire(Wire::new(wire)), value)
}

pub(crate) fn at(name: &str, index: u32, ring: u32) -> RegAt {
    RegAt {
        file: file(name),
        index,
        ring,
    }
}

/// A value in a register, as the iteration `distance` before names that.
pub(crate) fn from(reg: RegAt, distance: u32, value: Operand) -> Take {
    (Source::Reg { reg, distance }, value)
}

/// A kernel whose trip count is in word register 0 and whose further live-ins are the words behind. What
/// it writes into central registers is live-out.
pub(crate) fn kernel(
    name: &str,
    ii: u32,
    length: u32,
    live_ins: u32,
    ops: Vec<KernelOp>,
) -> ModuloSchedule {
    let live_in = |_| LiveIn {
        ty: Ty::Word,
        pos: pos(1),
    };
    let nodes = ops.iter().zip(100..).map(|(op, line)| NodeData {
        op: op.op,
        operands: op.operands.iter().map(|(_, value)| value.clone()).collect(),
        imm: op.imm,
        pos: pos(line),
    });
    let placed = ops.iter().enumerate().map(|(i, op)| PlacedOp {
        node: Node::new(i),
        is_move: false,
        fu: Fu::new(op.fu),
        time: op.time,
        operands: op.operands.iter().map(|(source, _)| *source).collect(),
        writes: op.writes.clone(),
    });
    let central = ["word", "vec", "pred"].map(file);
    let written = ops.iter().enumerate().flat_map(|(i, op)| {
        let writes = op.writes.iter().filter(|at| central.contains(&at.file));
        writes.map(move |&RegAt { file, index, .. }| (Node::new(i), Reg { file, index }))
    });
    let (live_outs, live_out_regs) = written.unzip();
    ModuloSchedule {
        dfg: Dfg {
            name: name.to_owned(),
            pos: pos(99),
            live_ins: (0..=live_ins).map(live_in).collect(),
            trip: Some(0),
            nodes: nodes.collect(),
            order: Vec::new(),
            assumed: Vec::new(),
            live_outs,
        },
        ii,
        length,
        ops: placed.collect(),
        transfers: Vec::new(),
        hops: Vec::new(),
        preloads: Vec::new(),
        live_in_regs: (0..=live_ins).map(w).collect(),
        live_out_regs,
    }
}

/// Sets a register of a kernel at its entry.
pub(crate) fn preload(kernel: &mut ModuloSchedule, name: &str, index: u32, value: Initial, ty: Ty) {
    kernel.preloads.push(Preload {
        file: file(name),
        index,
        value,
        ty,
    });
}

/// Cycles from the start of a program of [`combine`] to the first bundle of the case.
pub(crate) const DISPATCH: u64 = 4;

/// The source line of the call of a case.
pub(crate) const CALL_LINE: u32 = 1;

/// Combines all cases into one program; each case is a function. The program reads the address of the
/// function to call from port 8; the result says whose is which. The functions of a case itself come before
/// those of all cases, in their order.
pub(crate) fn combine<'a>(cases: impl IntoIterator<Item = &'a Code>) -> (ScheduledDre, Vec<u32>) {
    let mut program = ScheduledDre {
        machine: "tiny".to_owned(),
        files: EntityMap::from_iter(["case.c".to_owned()]),
        image: Vec::new(),
        symbols: Vec::new(),
        bundles: EntityMap::new(),
        functions: Vec::new(),
        start: Bundle::new(0),
        kernels: EntityMap::new(),
    };
    let port = with_imm(op(0, Opcode::In, &[], Some(w(31)), 1), 8);
    let (target, link) = (w(31), w(30));
    let call = Control::CallReg { target, link };
    program.bundles.push(ops(&[port]));
    program.bundles.push(ops(&[]));
    program.bundles.push(then(&[], call, CALL_LINE));
    program.bundles.push(ops(&[]));
    program.bundles.push(then(&[], Control::Halt(w(31)), 1));
    let mut starts = Vec::new();
    for case in cases {
        let (bundle, kernel) = (program.bundles.len(), program.kernels.len());
        starts.push(Bundle::new(bundle));
        for data in &case.bundles {
            let mut data = data.clone();
            if let Some((control, _)) = &mut data.control {
                relocate(control, bundle, kernel);
            }
            program.bundles.push(data);
        }
        for schedule in &case.kernels {
            program.kernels.push(schedule.clone());
        }
        for &entry in &case.functions {
            function(&mut program, Bundle::new(bundle + entry));
        }
    }
    let starts = starts.into_iter().map(|b| function(&mut program, b));
    let starts = starts.collect();
    (program, starts)
}

/// Makes a bundle the entry of a function, and gives its address.
fn function(program: &mut ScheduledDre, bundle: Bundle) -> u32 {
    let number = program.functions.len();
    let name = format!("f{number}");
    program.functions.push(FunctionEntry { name, bundle });
    FUNC_BASE + 4 * number as u32
}

fn relocate(control: &mut Control, bundle: usize, kernel: usize) {
    match control {
        Control::Jump(target) | Control::Branch { target, .. } | Control::Call { target, .. } => {
            *target = Bundle::new(target.index() + bundle);
        }
        Control::Launch(launched) => *launched = Kernel::new(launched.index() + kernel),
        _ => {}
    }
}
