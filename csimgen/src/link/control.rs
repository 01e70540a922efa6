//! The VLIW code.

use super::Linker;
use super::order::sequence;
use crate::spec::{Action, BundleSpec, Control, Landing, Operand, Origin, Step};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Effect;
use srp_ir::dre::scheduled::{self as dre, Bundle, BundleData, SlotOp, Src};

/// All bundles, in order.
pub(super) fn bundles(linker: &mut Linker) -> Vec<BundleSpec> {
    let bundles = linker.program.bundles.iter();
    bundles
        .map(|(bundle, data)| link_bundle(linker, bundle, data))
        .collect()
}

fn link_bundle(linker: &mut Linker, bundle: Bundle, data: &BundleData) -> BundleSpec {
    let mut steps = Vec::new();
    let mut port = Vec::new();
    for op in &data.ops {
        let step = operation(linker, op);
        let io = op.op.info().effect == Effect::Io;
        if io { &mut port } else { &mut steps }.push(step);
    }
    let mut ordered = port;
    ordered.extend(sequence(steps, |step| {
        step.landing = Landing::After(1);
        None
    }));
    let control = data.control.as_ref().map(|(control, pos)| {
        let control = transfer(linker, bundle, control);
        (control, linker.position(*pos))
    });
    BundleSpec {
        steps: ordered,
        control,
    }
}

fn operation(linker: &mut Linker, op: &SlotOp) -> Step {
    let latency = linker.latency(op.fu, op.op);
    let operand = |src: &Src| match *src {
        Src::Const(bits) => Operand::Const(bits),
        Src::Reg(reg) => Operand::Cell(linker.plain(reg)),
    };
    let operands = op.srcs.iter().map(operand).collect();
    let dests = op.dst.iter().map(|&reg| linker.plain(reg)).collect();
    let effect = op.op.info().effect;
    let in_place = op.op.result().is_none() || (latency == 1 && effect != Effect::Io);
    linker.max_latency = linker.max_latency.max(latency);
    Step {
        stage: None,
        action: Action::Op {
            op: op.op,
            operands,
            imm: op.imm,
        },
        ty: op.op.result(),
        dests,
        landing: if in_place {
            Landing::InPlace
        } else {
            Landing::After(latency)
        },
        origin: Origin::Unit {
            unit: op.fu,
            latency: if op.op.result().is_some() { latency } else { 1 },
        },
        at: linker.position(op.pos),
    }
}

fn transfer(linker: &mut Linker, bundle: Bundle, control: &dre::Control) -> Control {
    // The link register is written when the target issues.
    let latency = linker.arch.srp.branch_delay + 1;
    linker.max_latency = linker.max_latency.max(latency);
    let back = bundle.index() as u32 + latency;
    let number = |to: Bundle| to.index() as u32;
    let register = |reg| linker.plain(reg);
    match *control {
        dre::Control::Jump(to) => Control::Jump(number(to)),
        dre::Control::Branch {
            cond,
            sense,
            target,
        } => Control::Branch {
            cond: register(cond),
            sense,
            target: number(target),
        },
        dre::Control::Call { target, link } => Control::Call {
            target: number(target),
            link: register(link),
            back,
            latency,
        },
        dre::Control::CallReg { target, link } => Control::CallReg {
            target: register(target),
            link: register(link),
            back,
            latency,
        },
        dre::Control::Return(reg) => Control::Return(register(reg)),
        dre::Control::Launch(kernel) => Control::Launch(kernel.index() as u32),
        dre::Control::Halt(reg) => Control::Halt(register(reg)),
        dre::Control::Unreachable => Control::Unreachable,
        dre::Control::StackOverflow => Control::StackOverflow,
    }
}
