//! Damage to the bundles of VLIW code: times, registers, stack places, transfers.

use super::Dice;
use super::program::{Case, MACHINES};
use super::tally::{Harm, Tally};
use srp_archdesc::arch::{Arch, Fu};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Opcode;
use srp_ir::check::Rule;
use srp_ir::check::{check_control, check_sequence};
use srp_ir::dre::scheduled::{Bundle, Control, Reg, ScheduledDre, SlotOp, Src};
use srp_ir::program::{Bits, Pos};
use srp_scheduler::abi;

/// A way to damage code at an operation or a transfer of a bundle; `None` where it cannot.
type Damage = fn(&mut Code<'_>, Bundle) -> Option<()>;

/// A kind of damage: its name, whether it is always wrong, and the rules that it may break.
type Kind = (&'static str, Harm, &'static [Rule], Damage);

/// Rules that a change of times may break.
const TIMES: &[Rule] = &[
    Rule::Dataflow,
    Rule::MemoryOrder,
    Rule::Placement,
    Rule::IssueInterval,
    Rule::Resource,
    Rule::ReadPorts,
    Rule::WritePorts,
    Rule::Collision,
    Rule::InFlight,
    Rule::Undefined,
    Rule::ControlFlow,
    Rule::Class,
];

const KINDS: &[Kind] = &[
    (
        "an operation in another cycle",
        Harm::Perhaps,
        TIMES,
        in_another_cycle,
    ),
    (
        "two bundles in the other order",
        Harm::Perhaps,
        TIMES,
        bundles_swapped,
    ),
    (
        "an operation behind the end of its stretch",
        Harm::Always,
        TIMES,
        behind_the_end,
    ),
    (
        "a transfer a cycle early or late",
        Harm::Always,
        &[Rule::ControlFlow],
        transfer_moved,
    ),
    (
        "an operation that is gone",
        Harm::Always,
        &[Rule::Placement],
        op_gone,
    ),
    (
        "an operation twice",
        Harm::Always,
        &[Rule::Placement],
        op_twice,
    ),
    (
        "a result in another register",
        Harm::Always,
        &[Rule::Placement],
        result_elsewhere,
    ),
    (
        "a register overwritten",
        Harm::Always,
        &[Rule::Placement],
        overwritten,
    ),
    (
        "another register read",
        Harm::Always,
        &[Rule::Placement],
        other_operand,
    ),
    (
        "another constant",
        Harm::Always,
        &[Rule::Placement],
        other_constant,
    ),
    (
        "another place on the stack",
        Harm::Always,
        &[Rule::Placement],
        other_stack_place,
    ),
    (
        "a transfer to elsewhere",
        Harm::Always,
        &[Rule::ControlFlow],
        other_target,
    ),
    (
        "a branch the other way",
        Harm::Always,
        &[Rule::ControlFlow],
        other_sense,
    ),
    (
        "a transfer by another register",
        Harm::Always,
        &[Rule::ControlFlow],
        other_transfer_register,
    ),
];

/// The code that is damaged.
struct Code<'a> {
    program: ScheduledDre,
    arch: &'a Arch,
    dice: Dice,
}

impl Code<'_> {
    /// One of a bundle's operations.
    fn op(&mut self, bundle: Bundle) -> Option<usize> {
        let count = self.program.bundles[bundle].ops.len();
        (count > 0).then(|| self.dice.below(count))
    }

    /// One of a bundle's operations that is like this.
    fn op_like(&mut self, bundle: Bundle, is: impl Fn(&SlotOp) -> bool) -> Option<usize> {
        let ops = self.program.bundles[bundle].ops.iter().enumerate();
        let all: Vec<usize> = ops.filter(|(_, op)| is(op)).map(|(i, _)| i).collect();
        self.dice.pick(&all)
    }

    /// A bundle near this one, in which no operation is in slot `fu`.
    fn free_near(&mut self, bundle: Bundle, fu: Fu) -> Option<Bundle> {
        let distance = 1 + self.dice.below(4);
        let to = if self.dice.chance() {
            bundle.index() + distance
        } else {
            bundle.index().checked_sub(distance)?
        };
        let to = Bundle::new(to);
        let free = |ops: &[SlotOp]| ops.iter().all(|op| op.fu != fu);
        let data = self.program.bundles.get(to)?;
        free(&data.ops).then_some(to)
    }

    /// Another register of the file of `reg`.
    fn other(&mut self, reg: Reg) -> Option<Reg> {
        let index = self.dice.below(self.arch.srp.files[reg.file].size as usize) as u32;
        (index != reg.index).then_some(Reg { index, ..reg })
    }

    fn control(&mut self, bundle: Bundle) -> Option<&mut Control> {
        let control = self.program.bundles[bundle].control.as_mut();
        control.map(|(control, _)| control)
    }
}

fn in_another_cycle(code: &mut Code<'_>, bundle: Bundle) -> Option<()> {
    let at = code.op(bundle)?;
    let fu = code.program.bundles[bundle].ops[at].fu;
    let to = code.free_near(bundle, fu)?;
    let op = code.program.bundles[bundle].ops.remove(at);
    code.program.bundles[to].ops.push(op);
    Some(())
}

fn bundles_swapped(code: &mut Code<'_>, bundle: Bundle) -> Option<()> {
    let next = Bundle::new(bundle.index() + 1);
    let before = code.program.bundles[bundle].ops.clone();
    let after = code.program.bundles.get(next)?.ops.clone();
    (!before.is_empty() && !after.is_empty()).then_some(())?;
    code.program.bundles[bundle].ops = after;
    code.program.bundles[next].ops = before;
    Some(())
}

/// An operation before a jump, to the first bundle behind the delay.
fn behind_the_end(code: &mut Code<'_>, bundle: Bundle) -> Option<()> {
    let control = code.program.bundles[bundle].control.as_ref();
    let (Control::Jump(_) | Control::Branch { .. }, _) = control? else {
        return None;
    };
    let behind = Bundle::new(bundle.index() + code.arch.srp.branch_delay as usize + 1);
    let at = code.op(bundle)?;
    let fu = code.program.bundles[bundle].ops[at].fu;
    let ops = &code.program.bundles.get(behind)?.ops;
    ops.iter().all(|op| op.fu != fu).then_some(())?;
    let op = code.program.bundles[bundle].ops.remove(at);
    code.program.bundles[behind].ops.push(op);
    Some(())
}

fn transfer_moved(code: &mut Code<'_>, bundle: Bundle) -> Option<()> {
    let to = Bundle::new(code.dice.step(bundle.index() as u32)? as usize);
    code.program
        .bundles
        .get(to)?
        .control
        .is_none()
        .then_some(())?;
    let control = code.program.bundles[bundle].control.take()?;
    code.program.bundles[to].control = Some(control);
    Some(())
}

fn op_gone(code: &mut Code<'_>, bundle: Bundle) -> Option<()> {
    let at = code.op(bundle)?;
    code.program.bundles[bundle].ops.remove(at);
    Some(())
}

fn op_twice(code: &mut Code<'_>, bundle: Bundle) -> Option<()> {
    let at = code.op(bundle)?;
    let op = code.program.bundles[bundle].ops[at].clone();
    let to = code.free_near(bundle, op.fu)?;
    code.program.bundles[to].ops.push(op);
    Some(())
}

fn result_elsewhere(code: &mut Code<'_>, bundle: Bundle) -> Option<()> {
    let at = code.op(bundle)?;
    let dst = code.program.bundles[bundle].ops[at].dst?;
    code.program.bundles[bundle].ops[at].dst = Some(code.other(dst)?);
    Some(())
}

fn overwritten(code: &mut Code<'_>, bundle: Bundle) -> Option<()> {
    let file = abi::file(&code.arch.srp, srp_archdesc::Ty::Word);
    let slots: Vec<Fu> = code.arch.srp.slots();
    let fu = code.dice.pick(&slots)?;
    let ops = &mut code.program.bundles[bundle].ops;
    ops.iter().all(|op| op.fu != fu).then_some(())?;
    let index = code.dice.below(code.arch.srp.files[file].size as usize) as u32;
    ops.push(SlotOp {
        fu,
        op: Opcode::Mov,
        srcs: vec![Src::Const(Bits::Word(7))],
        imm: 0,
        dst: Some(Reg { file, index }),
        pos: Pos::nowhere(),
    });
    Some(())
}

fn other_operand(code: &mut Code<'_>, bundle: Bundle) -> Option<()> {
    let is_register = |src: &Src| matches!(src, Src::Reg(_));
    let at = code.op_like(bundle, |op| op.srcs.iter().any(is_register))?;
    let srcs = code.program.bundles[bundle].ops[at].srcs.clone();
    let k = srcs.iter().position(is_register)?;
    let Src::Reg(reg) = srcs[k] else { return None };
    code.program.bundles[bundle].ops[at].srcs[k] = Src::Reg(code.other(reg)?);
    Some(())
}

fn other_constant(code: &mut Code<'_>, bundle: Bundle) -> Option<()> {
    let at = code.op(bundle)?;
    let srcs = &mut code.program.bundles[bundle].ops[at].srcs;
    srcs.iter_mut().find_map(|src| {
        let Src::Const(bits) = src else { return None };
        *bits = match *bits {
            Bits::Pred(p) => Bits::Pred(!p),
            Bits::Word(w) => Bits::Word(w ^ 4),
            Bits::Vec(_) => return None,
        };
        Some(())
    })
}

fn other_stack_place(code: &mut Code<'_>, bundle: Bundle) -> Option<()> {
    let sp = Src::Reg(abi::stack_pointer(&code.arch.srp));
    let at = code.op_like(bundle, |op| {
        op.op.access_bytes().is_some() && op.srcs.get(1) == Some(&sp)
    })?;
    let by = if code.dice.chance() { 4 } else { -4 };
    code.program.bundles[bundle].ops[at].imm += by;
    Some(())
}

fn other_target(code: &mut Code<'_>, bundle: Bundle) -> Option<()> {
    let count = code.program.bundles.len();
    let other = Bundle::new(code.dice.below(count));
    match code.control(bundle)? {
        Control::Jump(target) | Control::Branch { target, .. } | Control::Call { target, .. } => {
            (*target != other).then(|| *target = other)
        }
        _ => None,
    }
}

fn other_sense(code: &mut Code<'_>, bundle: Bundle) -> Option<()> {
    match code.control(bundle)? {
        Control::Branch { sense, .. } => *sense = !*sense,
        _ => return None,
    }
    Some(())
}

fn other_transfer_register(code: &mut Code<'_>, bundle: Bundle) -> Option<()> {
    let reg = match *code.control(bundle)? {
        Control::Branch { cond: reg, .. }
        | Control::Call { link: reg, .. }
        | Control::CallReg { link: reg, .. }
        | Control::Return(reg)
        | Control::Halt(reg) => reg,
        _ => return None,
    };
    let other = code.other(reg)?;
    match code.control(bundle)? {
        Control::Branch { cond: reg, .. }
        | Control::Call { link: reg, .. }
        | Control::CallReg { link: reg, .. }
        | Control::Return(reg)
        | Control::Halt(reg) => *reg = other,
        _ => {}
    }
    Some(())
}

/// How often each kind is tried on each machine.
const ROUNDS: usize = 60;

#[test]
fn damaged_bundles_are_refused_or_do_the_same() {
    let mut tally = Tally::default();
    for (machine, name) in MACHINES.iter().enumerate() {
        let case = Case::on(machine);
        assert_eq!(
            check_sequence(&case.right, &case.sequence, case.control(), &case.arch.srp),
            []
        );
        for (number, &(kind, harm, rules, damage)) in KINDS.iter().enumerate() {
            let mut dice = Dice::new(number as u64, machine as u64);
            let mut tried = 0;
            for _ in 0..100 * ROUNDS {
                if tried == ROUNDS {
                    break;
                }
                let bundle = Bundle::new(dice.below(case.right.bundles.len()));
                let mut code = Code {
                    program: case.right.clone(),
                    arch: &case.arch,
                    dice,
                };
                let applied = damage(&mut code, bundle).is_some() && code.program != case.right;
                let program = code.program;
                dice = code.dice;
                if !applied {
                    continue;
                }
                tried += 1;
                let mut violations = check_control(&program, &case.arch);
                violations.extend(check_sequence(
                    &program,
                    &case.sequence,
                    case.control(),
                    &case.arch.srp,
                ));
                let place = format!("{name}, {bundle}");
                tally.note((kind, harm, rules), &place, &violations, || {
                    case.difference(&program)
                });
            }
        }
    }
    tally.finish(KINDS.iter().map(|(name, ..)| *name), 40);
}

#[test]
fn slower_machines_are_noticed() {
    for machine in 0..MACHINES.len() {
        let case = Case::on(machine);
        for class in [srp_archdesc::Class::Load, srp_archdesc::Class::Imul] {
            let mut arch = case.arch.clone();
            let ops = arch.srp.fus.values_mut().flat_map(|fu| &mut fu.ops);
            ops.filter(|op| op.class == class)
                .for_each(|op| op.latency += 1);
            let violations = check_sequence(&case.right, &case.sequence, case.control(), &arch.srp);
            let late = violations
                .iter()
                .any(|v| matches!(v.rule, Rule::Dataflow | Rule::InFlight));
            assert!(late, "{} with a slower {class}: {violations:?}", arch.name);
        }
    }
}
