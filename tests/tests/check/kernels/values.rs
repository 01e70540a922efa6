//! Damage to registers, constants, and to what comes in and goes out.

use super::super::tally::Harm;
use super::{Kind, Loop};
use srp_archdesc::arch::{FileKind, RegFile};
use srp_archdesc::isa::Ty;
use srp_ir::check::Rule;
use srp_ir::dfg::Initial;
use srp_ir::dre::scheduled::{Reg, RegAt, Source};
use srp_ir::program::Bits;

/// Rules that a wrong register may break.
const REGISTERS: &[Rule] = &[
    Rule::Dataflow,
    Rule::LiveIn,
    Rule::LiveOut,
    Rule::Collision,
    Rule::ReadPorts,
    Rule::WritePorts,
    Rule::Range,
    Rule::Width,
    Rule::Contexts,
];

pub(super) const KINDS: &[Kind] = &[
    (
        "a register overwritten",
        Harm::Perhaps,
        REGISTERS,
        overwritten,
    ),
    (
        "a register that is not written",
        Harm::Perhaps,
        REGISTERS,
        not_written,
    ),
    (
        "a result in another register",
        Harm::Perhaps,
        REGISTERS,
        written_elsewhere,
    ),
    (
        "another register read",
        Harm::Perhaps,
        REGISTERS,
        read_elsewhere,
    ),
    (
        "a register of another iteration",
        Harm::Perhaps,
        REGISTERS,
        other_distance,
    ),
    (
        "a ring of another size",
        Harm::Perhaps,
        REGISTERS,
        other_ring,
    ),
    (
        "a ring of no register",
        Harm::Always,
        &[Rule::Range],
        no_ring,
    ),
    (
        "a transfer to another register",
        Harm::Perhaps,
        REGISTERS,
        transferred_elsewhere,
    ),
    (
        "a register beyond its file",
        Harm::Always,
        &[Rule::Range],
        beyond_the_file,
    ),
    (
        "a predicate turned round",
        Harm::Always,
        &[Rule::Dataflow],
        predicate,
    ),
    (
        "another constant",
        Harm::Always,
        &[Rule::Dataflow],
        constant,
    ),
    (
        "an operand of another operation",
        Harm::Perhaps,
        ANY,
        other_operand,
    ),
    (
        "a register that is not set at entry",
        Harm::Perhaps,
        REGISTERS,
        preload_gone,
    ),
    (
        "a register set to something else",
        Harm::Perhaps,
        REGISTERS,
        preload_value,
    ),
    (
        "a register set to a value of another type, or to none",
        Harm::Always,
        &[Rule::LiveIn],
        preload_type,
    ),
    (
        "another register set at entry",
        Harm::Perhaps,
        REGISTERS,
        preload_elsewhere,
    ),
    (
        "a register set twice",
        Harm::Always,
        &[Rule::LiveIn],
        preload_twice,
    ),
    (
        "two live-ins in a register",
        Harm::Always,
        &[Rule::LiveIn],
        live_ins_meet,
    ),
    (
        "a live-in in a local register",
        Harm::Always,
        &[Rule::LiveIn],
        live_in_local,
    ),
    (
        "a live-in without a register",
        Harm::Always,
        &[Rule::LiveIn],
        live_in_gone,
    ),
    (
        "a live-out looked for elsewhere",
        Harm::Perhaps,
        &[Rule::LiveOut],
        live_out_elsewhere,
    ),
    (
        "a live-out in a local register",
        Harm::Always,
        &[Rule::LiveOut],
        live_out_local,
    ),
];

/// Rules that any wrong operand may break.
const ANY: &[Rule] = &[
    Rule::Dataflow,
    Rule::Routing,
    Rule::Width,
    Rule::Form,
    Rule::Constants,
    Rule::Range,
    Rule::LiveOut,
    Rule::ReadPorts,
    Rule::Contexts,
];

fn is_register(source: &Source) -> bool {
    matches!(source, Source::Reg { .. })
}

/// A register that the schedule reads somewhere.
fn read_somewhere(broken: &mut Loop<'_>) -> Option<RegAt> {
    let (op, i) = broken.operand_like(is_register)?;
    match broken.schedule.ops[op].operands[i] {
        Source::Reg { reg, .. } => Some(reg),
        Source::Const(_) | Source::Out(_) | Source::Wire(_) => None,
    }
}

/// The register that an operand is read from.
fn operand<'a>(broken: &'a mut Loop<'_>) -> Option<(&'a mut RegAt, &'a mut u32)> {
    let (op, i) = broken.operand_like(is_register)?;
    match &mut broken.schedule.ops[op].operands[i] {
        Source::Reg { reg, distance } => Some((reg, distance)),
        Source::Const(_) | Source::Out(_) | Source::Wire(_) => None,
    }
}

/// The register that a result is written into.
fn written<'a>(broken: &'a mut Loop<'_>) -> Option<&'a mut RegAt> {
    let op = broken.op_like(|op| !op.writes.is_empty())?;
    let at = broken.dice.below(broken.schedule.ops[op].writes.len());
    broken.schedule.ops[op].writes.get_mut(at)
}

fn overwritten(broken: &mut Loop<'_>) -> Option<()> {
    let reg = read_somewhere(broken)?;
    let spec = &broken.arch.srp.files[reg.file];
    let dfg = broken.schedule.dfg.clone();
    let op = broken.op_like(|op| {
        let fits = dfg.ty(op.node).is_some_and(|ty| spec.holds(ty));
        let elsewhere = op.writes.iter().all(|w| w.file != reg.file);
        fits && elsewhere && spec.writers.contains(&op.fu)
    })?;
    broken.schedule.ops[op]
        .writes
        .push(RegAt { ring: 1, ..reg });
    Some(())
}

fn not_written(broken: &mut Loop<'_>) -> Option<()> {
    let op = broken.op_like(|op| !op.writes.is_empty())?;
    broken.schedule.ops[op].writes.pop().map(drop)
}

fn written_elsewhere(broken: &mut Loop<'_>) -> Option<()> {
    let up = broken.dice.step(7)?;
    let reg = written(broken)?;
    reg.index = (reg.index + up).checked_sub(7)?;
    Some(())
}

fn read_elsewhere(broken: &mut Loop<'_>) -> Option<()> {
    let up = broken.dice.step(7)?;
    let (reg, _) = operand(broken)?;
    reg.index = (reg.index + up).checked_sub(7)?;
    Some(())
}

fn other_distance(broken: &mut Loop<'_>) -> Option<()> {
    let up = broken.dice.step(7)?;
    let (_, distance) = operand(broken)?;
    *distance = (*distance + up).checked_sub(7)?;
    Some(())
}

fn other_ring(broken: &mut Loop<'_>) -> Option<()> {
    let reg = if broken.dice.chance() {
        operand(broken)?.0
    } else {
        written(broken)?
    };
    reg.ring += 1;
    Some(())
}

fn no_ring(broken: &mut Loop<'_>) -> Option<()> {
    let reg = if broken.dice.chance() {
        operand(broken)?.0
    } else {
        written(broken)?
    };
    reg.ring = 0;
    Some(())
}

fn transferred_elsewhere(broken: &mut Loop<'_>) -> Option<()> {
    let at = broken.dice.below(broken.schedule.transfers.len());
    let index = broken.schedule.transfers.get(at)?.to.index;
    broken.schedule.transfers[at].to.index = broken.dice.step(index)?;
    Some(())
}

fn beyond_the_file(broken: &mut Loop<'_>) -> Option<()> {
    let arch = broken.arch;
    let by = broken.dice.below(5) as u32;
    let reg = if broken.dice.chance() {
        operand(broken)?.0
    } else {
        written(broken)?
    };
    reg.index = arch.srp.files[reg.file].size + by;
    Some(())
}

fn predicate(broken: &mut Loop<'_>) -> Option<()> {
    let is = |source: &Source| matches!(source, Source::Const(Bits::Pred(_)));
    let (op, i) = broken.operand_like(is)?;
    if let Source::Const(Bits::Pred(p)) = &mut broken.schedule.ops[op].operands[i] {
        *p = !*p;
    }
    Some(())
}

fn constant(broken: &mut Loop<'_>) -> Option<()> {
    let is = |source: &Source| matches!(source, Source::Const(Bits::Word(_)));
    let (op, i) = broken.operand_like(is)?;
    let bit = 1 << broken.dice.below(32);
    if let Source::Const(Bits::Word(w)) = &mut broken.schedule.ops[op].operands[i] {
        *w ^= bit;
    }
    Some(())
}

fn other_operand(broken: &mut Loop<'_>) -> Option<()> {
    let (op, i) = broken.operand_like(|_| true)?;
    let (other, k) = broken.operand_like(|_| true)?;
    broken.schedule.ops[op].operands[i] = broken.schedule.ops[other].operands[k];
    Some(())
}

fn preload_gone(broken: &mut Loop<'_>) -> Option<()> {
    let at = broken.dice.below(broken.schedule.preloads.len());
    (at < broken.schedule.preloads.len()).then(|| broken.schedule.preloads.remove(at))?;
    Some(())
}

fn preload_value(broken: &mut Loop<'_>) -> Option<()> {
    let at = broken.dice.below(broken.schedule.preloads.len());
    let ty = broken.schedule.preloads.get(at)?.ty;
    let live_ins = broken.schedule.dfg.live_ins.iter().enumerate();
    let same = live_ins.filter(|(_, live_in)| live_in.ty == ty);
    let mut values: Vec<Initial> = same.map(|(k, _)| Initial::LiveIn(k as u32)).collect();
    values.push(Initial::Const(match ty {
        Ty::Pred => Bits::Pred(broken.dice.chance()),
        Ty::Word => Bits::Word(0x3f7f_ffff),
        Ty::Vec => Bits::Vec([0x3f7f_ffff; 4]),
    }));
    broken.schedule.preloads[at].value = broken.dice.pick(&values)?;
    Some(())
}

fn preload_type(broken: &mut Loop<'_>) -> Option<()> {
    let at = broken.dice.below(broken.schedule.preloads.len());
    let other = match broken.schedule.preloads.get(at)?.ty {
        Ty::Pred => Bits::Word(1),
        Ty::Word | Ty::Vec => Bits::Pred(true),
    };
    let values = [Initial::Const(other), Initial::Any];
    broken.schedule.preloads[at].value = broken.dice.pick(&values)?;
    Some(())
}

fn preload_elsewhere(broken: &mut Loop<'_>) -> Option<()> {
    let at = broken.dice.below(broken.schedule.preloads.len());
    let index = broken.schedule.preloads.get(at)?.index;
    broken.schedule.preloads[at].index = broken.dice.step(index)?;
    Some(())
}

fn preload_twice(broken: &mut Loop<'_>) -> Option<()> {
    let all = broken.schedule.preloads.clone();
    broken.schedule.preloads.push(broken.dice.pick(&all)?);
    Some(())
}

fn live_ins_meet(broken: &mut Loop<'_>) -> Option<()> {
    let regs = broken.schedule.live_in_regs.clone();
    let one = broken.dice.pick(&regs)?;
    let same: Vec<usize> = (0..regs.len())
        .filter(|&k| regs[k].file == one.file)
        .collect();
    let at = broken.dice.pick(&same)?;
    broken.schedule.live_in_regs[at] = one;
    Some(())
}

/// Some register of a file of the array itself.
fn local(broken: &mut Loop<'_>) -> Option<Reg> {
    let files = broken.arch.srp.files.iter();
    let local: Vec<RegFile> = files
        .filter(|(_, file)| file.kind != FileKind::Central)
        .map(|(file, _)| file)
        .collect();
    let file = broken.dice.pick(&local)?;
    let index = broken.dice.below(broken.arch.srp.files[file].size as usize) as u32;
    Some(Reg { file, index })
}

fn live_in_local(broken: &mut Loop<'_>) -> Option<()> {
    let reg = local(broken)?;
    let at = broken.dice.below(broken.schedule.live_in_regs.len());
    *broken.schedule.live_in_regs.get_mut(at)? = reg;
    Some(())
}

fn live_in_gone(broken: &mut Loop<'_>) -> Option<()> {
    broken.schedule.live_in_regs.pop().map(drop)
}

fn live_out_elsewhere(broken: &mut Loop<'_>) -> Option<()> {
    let at = broken.dice.below(broken.schedule.live_out_regs.len());
    let index = broken.schedule.live_out_regs.get(at)?.index;
    broken.schedule.live_out_regs[at].index = broken.dice.step(index)?;
    Some(())
}

fn live_out_local(broken: &mut Loop<'_>) -> Option<()> {
    let reg = local(broken)?;
    let at = broken.dice.below(broken.schedule.live_out_regs.len());
    *broken.schedule.live_out_regs.get_mut(at)? = reg;
    Some(())
}
