//! The VLIW code.

use super::order::sequence;
use super::{LinkError, Linker, Site};
use crate::spec::{Action, BundleSpec, Cell, Control, Landing, Operand, Step};
use srp_archdesc::arch::FileKind;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Class, Effect, Ty};
use srp_ir::dre::scheduled::{self as dre, Bundle, BundleData, Reg, SlotOp, Src};
use srp_ir::program::Pos;

/// All bundles, in order.
pub(super) fn bundles(linker: &mut Linker) -> Result<Vec<BundleSpec>, LinkError> {
    let program = linker.program;
    program
        .bundles
        .iter()
        .map(|(bundle, data)| link_bundle(linker, bundle, data))
        .collect()
}

fn link_bundle(
    linker: &mut Linker,
    bundle: Bundle,
    data: &BundleData,
) -> Result<BundleSpec, LinkError> {
    check_slots(linker, bundle, data)?;
    let mut steps = Vec::new();
    let mut port = Vec::new();
    let mut landings = Vec::new();
    for op in &data.ops {
        let site = Site {
            scope: format!("bundle {bundle}"),
            pos: op.pos,
        };
        let (step, latency) = operation(linker, op, &site)?;
        for &dest in &step.dests {
            if landings.contains(&(dest, latency)) {
                let message = "two results land in one register in the same cycle";
                return Err(site.error(linker, message));
            }
            landings.push((dest, latency));
        }
        let io = op.op.info().effect == Effect::Io;
        if io { &mut port } else { &mut steps }.push(step);
    }
    let mut ordered = port;
    ordered.extend(sequence(steps, |step| {
        step.landing = Landing::After(1);
        None
    }));
    let control = match &data.control {
        Some((control, pos)) => Some((
            transfer(linker, bundle, data, control, *pos)?,
            linker.position(*pos),
        )),
        None => None,
    };
    Ok(BundleSpec {
        steps: ordered,
        control,
    })
}

/// At most one operation a slot, in units that are slots, and one port operation in all.
fn check_slots(linker: &Linker, bundle: Bundle, data: &BundleData) -> Result<(), LinkError> {
    let mut taken = Vec::new();
    let mut ports = 0;
    for op in &data.ops {
        let site = Site {
            scope: format!("bundle {bundle}"),
            pos: op.pos,
        };
        let Some(spec) = linker.arch.srp.fus.get(op.fu) else {
            return Err(site.error(linker, format!("there is no unit {}", op.fu)));
        };
        if spec.slot.is_none() {
            return Err(site.error(linker, format!("unit {} is no VLIW slot", spec.name)));
        }
        if taken.contains(&op.fu) {
            let message = format!("unit {} has two operations", spec.name);
            return Err(site.error(linker, message));
        }
        taken.push(op.fu);
        ports += u32::from(op.op.info().effect == Effect::Io);
        if ports > 1 {
            return Err(site.error(linker, "there are two port operations"));
        }
    }
    Ok(())
}

/// The step of an operation, and its latency.
fn operation(linker: &mut Linker, op: &SlotOp, site: &Site) -> Result<(Step, u32), LinkError> {
    let latency = linker.latency(op.fu, op.op, site)?;
    let info = op.op.info();
    if op.srcs.len() != info.operands.len() {
        let message = format!("`{}` takes {} operands", op.op, info.operands.len());
        return Err(site.error(linker, message));
    }
    let mut operands = Vec::new();
    for (src, kind) in op.srcs.iter().zip(info.operands) {
        operands.push(match src {
            Src::Const(bits) => linker.constant(*bits, kind.ty(), site)?,
            Src::Reg(reg) => {
                linker.reads(op.fu, reg.file, site)?;
                Operand::Cell(central(linker, *reg, kind.ty(), site)?)
            }
        });
    }
    let dest = match (op.op.result(), op.dst) {
        (Some(ty), Some(reg)) => {
            linker.writes(op.fu, reg.file, site)?;
            Some(central(linker, reg, ty, site)?)
        }
        (None, None) => None,
        (Some(_), None) => return Err(site.error(linker, "the result goes nowhere")),
        (None, Some(_)) => return Err(site.error(linker, "there is no result to write")),
    };
    let in_place = op.op.result().is_none() || (latency == 1 && info.effect != Effect::Io);
    linker.max_latency = linker.max_latency.max(latency);
    let step = Step {
        stage: None,
        action: Action::Op {
            op: op.op,
            operands,
            imm: op.imm,
        },
        ty: op.op.result(),
        dests: dest.into_iter().collect(),
        landing: if in_place {
            Landing::InPlace
        } else {
            Landing::After(latency)
        },
        at: linker.position(op.pos),
    };
    Ok((step, latency))
}

/// A register that VLIW code can name.
fn central(linker: &Linker, reg: Reg, ty: Ty, site: &Site) -> Result<Cell, LinkError> {
    let cell = linker.plain(reg, ty, site)?;
    let spec = &linker.arch.srp.files[reg.file];
    if spec.kind != FileKind::Central {
        let message = format!("{} is no central register file", spec.name);
        return Err(site.error(linker, message));
    }
    Ok(cell)
}

fn transfer(
    linker: &mut Linker,
    bundle: Bundle,
    data: &BundleData,
    control: &dre::Control,
    pos: Pos,
) -> Result<Control, LinkError> {
    let site = Site {
        scope: format!("bundle {bundle}"),
        pos,
    };
    branch_unit(linker, data, &site)?;
    // The link register is written when the target issues.
    let latency = linker.arch.srp.branch_delay + 1;
    linker.max_latency = linker.max_latency.max(latency);
    let back = bundle.index() as u32 + linker.arch.srp.branch_delay + 1;
    let target = |to: Bundle| linker.bundle(to, &site.scope);
    let word = |reg: Reg| central(linker, reg, Ty::Word, &site);
    Ok(match *control {
        dre::Control::Jump(to) => Control::Jump(target(to)?),
        dre::Control::Branch {
            cond,
            sense,
            target: to,
        } => Control::Branch {
            cond: central(linker, cond, Ty::Pred, &site)?,
            sense,
            target: target(to)?,
        },
        dre::Control::Call { target: to, link } => Control::Call {
            target: target(to)?,
            link: word(link)?,
            back,
            latency,
        },
        dre::Control::CallReg { target, link } => Control::CallReg {
            target: word(target)?,
            link: word(link)?,
            back,
            latency,
        },
        dre::Control::Return(reg) => Control::Return(word(reg)?),
        dre::Control::Launch(kernel) => {
            if kernel.index() >= linker.program.kernels.len() {
                return Err(site.error(linker, format!("there is no kernel {kernel}")));
            }
            Control::Launch(kernel.index() as u32)
        }
        dre::Control::Halt(reg) => Control::Halt(word(reg)?),
        dre::Control::Unreachable => Control::Unreachable,
        dre::Control::StackOverflow => Control::StackOverflow,
    })
}

/// Whether a slot that can branch is left for a bundle's control transfer.
fn branch_unit(linker: &Linker, data: &BundleData, site: &Site) -> Result<(), LinkError> {
    let free = |fu: &srp_archdesc::arch::Fu| data.ops.iter().all(|op| op.fu != *fu);
    linker
        .arch
        .srp
        .slots()
        .into_iter()
        .filter(free)
        .find(|&fu| linker.arch.srp.fus[fu].op(Class::Branch).is_some())
        .map(|_| ())
        .ok_or_else(|| site.error(linker, "no slot is left that can branch"))
}
