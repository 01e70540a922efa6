//! Compares stretches of bundles with their operations in sequence. Both run with tokens for
//! values: a token names the operation that made a register's content. The bundles run with their
//! latencies; the sequence runs one operation after another.

use super::bundle::{control_read, control_write};
use super::objects::Proof;
use crate::check::sequence::{Step, Storage, Stretch};
use crate::check::{Place, Rule, Violation};
use crate::dre::scheduled::{Bundle, Control, Reg, ScheduledDre, SlotOp, Src};
use crate::program::{Bits, Func, Program};
use srp_archdesc::arch::Srp;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Effect, Opcode, Space};
use std::collections::{BTreeMap, VecDeque};

/// Where the bundles of `dre` do something else than `sequence`, whose stretches are in the order of
/// the bundles and leave none out. Both come from `control`, which says what accesses may meet.
/// Whether the machine can do it is for [`check_control`](super::check_control).
pub fn check_sequence(
    dre: &ScheduledDre,
    sequence: &[Stretch],
    control: &Program,
    srp: &Srp,
) -> Vec<Violation> {
    let mut violations = Vec::new();
    let mut proof: Option<(Func, Proof<'_>)> = None;
    let mut next = 0;
    for stretch in sequence {
        if stretch.first.index() != next || dre.bundles.len() - next < stretch.bundles {
            break;
        }
        next += stretch.bundles;
        let func = function_at(dre, stretch.first).filter(|&f| control.funcs.get(f).is_some());
        if func != proof.as_ref().map(|(func, _)| *func) {
            proof = func.map(|func| (func, Proof::of(&control.funcs[func])));
        }
        let mut checker = Checker {
            dre,
            srp,
            stretch,
            proof: proof.as_ref().map(|(_, proof)| proof),
            violations: &mut violations,
        };
        checker.check();
    }
    if next != dre.bundles.len() {
        violations.push(Violation {
            at: Place::Program,
            rule: Rule::Placement,
            message: format!("the sequence ends with bundle {next}"),
        });
    }
    violations.sort();
    violations.dedup();
    violations
}

/// The function with this bundle; `None` in the start code.
fn function_at(dre: &ScheduledDre, bundle: Bundle) -> Option<Func> {
    let before = dre.functions.iter().enumerate();
    let before = before.filter(|(_, entry)| entry.bundle <= bundle);
    let (last, entry) = before.max_by_key(|(_, entry)| entry.bundle)?;
    (dre.start > bundle || dre.start < entry.bundle).then(|| Func::new(last))
}

/// The content of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Token {
    /// Its content at the start of the stretch.
    Entry(Reg),
    /// The result of a step.
    Result(usize),
    /// Where the call goes on.
    Link,
}

/// Tokens of the registers that were written.
#[derive(Default)]
struct Registers(BTreeMap<Reg, Token>);

impl Registers {
    fn read(&self, reg: Reg) -> Token {
        self.0.get(&reg).copied().unwrap_or(Token::Entry(reg))
    }

    fn operands(&self, srcs: &[Src]) -> Vec<Option<Token>> {
        let token = |src: &Src| match src {
            Src::Reg(reg) => Some(self.read(*reg)),
            Src::Const(_) => None,
        };
        srcs.iter().map(token).collect()
    }
}

/// When a step issues, in cycles of the stretch, with the operands that it finds.
struct Issue {
    cycle: usize,
    operands: Vec<Option<Token>>,
}

struct Checker<'a> {
    dre: &'a ScheduledDre,
    srp: &'a Srp,
    stretch: &'a Stretch,
    /// `None` outside of functions.
    proof: Option<&'a Proof<'a>>,
    violations: &'a mut Vec<Violation>,
}

impl Checker<'_> {
    fn bundle(&self, cycle: usize) -> Bundle {
        Bundle::new(self.stretch.first.index() + cycle)
    }

    fn report(&mut self, cycle: usize, rule: Rule, message: String) {
        let at = Place::Bundle(self.bundle(cycle));
        self.violations.push(Violation { at, rule, message });
    }

    fn check(&mut self) {
        self.transfer();
        let Some(steps) = self.matched() else {
            return;
        };
        let mut in_sequence = Registers::default();
        let mut wanted = Vec::new();
        for (i, step) in self.stretch.steps.iter().enumerate() {
            wanted.push(in_sequence.operands(&step.srcs));
            if let Some(dst) = step.dst {
                in_sequence.0.insert(dst, Token::Result(i));
            }
        }
        let read = |registers: &Registers| {
            let read = self.stretch.exit.as_ref().and_then(control_read);
            read.map(|(reg, _)| registers.read(reg))
        };
        let wanted_by_exit = read(&in_sequence);
        let (issues, at_exit, mut at_end) = self.run(&steps);
        self.values(&wanted, &issues);
        if at_exit != wanted_by_exit {
            let cycle = self.exit_cycle().unwrap_or(0);
            let message = "the transfer reads its register too early or too late".to_owned();
            self.report(cycle, Rule::Dataflow, message);
        }
        if let Some(link) = self.stretch.exit.as_ref().and_then(control_write) {
            in_sequence.0.insert(link, Token::Link);
            at_end.0.insert(link, Token::Link);
        }
        let written = in_sequence.0.keys().chain(at_end.0.keys());
        if let Some(reg) = written
            .copied()
            .find(|&r| in_sequence.read(r) != at_end.read(r))
        {
            let name = &self.srp.files[reg.file].name;
            let message = format!("{name}[{}] is left with another value", reg.index);
            self.report(
                self.stretch.bundles.saturating_sub(1),
                Rule::Dataflow,
                message,
            );
        }
        self.memory(&wanted, &issues);
    }

    /// Cycles from the issue of the exit to the end of the stretch.
    fn exit_delay(&self, exit: &Control) -> usize {
        match exit {
            Control::Jump(_)
            | Control::Branch { .. }
            | Control::Call { .. }
            | Control::CallReg { .. }
            | Control::Return(_) => self.srp.branch_delay as usize + 1,
            Control::Launch(_)
            | Control::Halt(_)
            | Control::Unreachable
            | Control::StackOverflow => 1,
        }
    }

    /// The cycle in which the exit has to issue.
    fn exit_cycle(&self) -> Option<usize> {
        let exit = self.stretch.exit.as_ref()?;
        self.stretch.bundles.checked_sub(self.exit_delay(exit))
    }

    /// The transfer, and no other, issues so that the stretch ends when its target begins.
    fn transfer(&mut self) {
        let expected = self.exit_cycle();
        for cycle in 0..self.stretch.bundles {
            let control = self.dre.bundles[self.bundle(cycle)].control.as_ref();
            let control = control.map(|(control, _)| control);
            let wanted = self
                .stretch
                .exit
                .as_ref()
                .filter(|_| expected == Some(cycle));
            if control != wanted {
                let message = "not the transfer that belongs here".to_owned();
                self.report(cycle, Rule::ControlFlow, message);
            }
        }
    }

    /// Which step each operation of each bundle is, in order of issue; `None` where not every step is there
    /// once.
    fn matched(&mut self) -> Option<Vec<Vec<(usize, SlotOp)>>> {
        let mut left: BTreeMap<(Opcode, Option<Reg>, i32), VecDeque<usize>> = BTreeMap::new();
        for (i, step) in self.stretch.steps.iter().enumerate() {
            let list = left.entry((step.op, step.dst, step.imm)).or_default();
            list.push_back(i);
        }
        let mut all = Vec::new();
        let mut right = true;
        for cycle in 0..self.stretch.bundles {
            let mut ops = self.dre.bundles[self.bundle(cycle)].ops.clone();
            // Of steps that look alike the first is the one whose result stands first.
            ops.sort_by_key(|op| self.latency(op));
            let mut found = Vec::new();
            for op in ops {
                let is = |step: &Step| step.srcs == op.srcs && step.pos == op.pos;
                let list = left.entry((op.op, op.dst, op.imm)).or_default();
                match list.iter().position(|&i| is(&self.stretch.steps[i])) {
                    Some(at) => found.extend(list.remove(at).map(|i| (i, op))),
                    None => {
                        let message = format!("`{}` does not belong here", op.op.name());
                        self.report(cycle, Rule::Placement, message);
                        right = false;
                    }
                }
            }
            all.push(found);
        }
        for i in left.into_values().flatten() {
            let message = format!("`{}` is missing", self.stretch.steps[i].op.name());
            self.report(0, Rule::Placement, message);
            right = false;
        }
        right.then_some(all)
    }

    /// Where no unit runs it, which is reported elsewhere, any will do.
    fn latency(&self, op: &SlotOp) -> u32 {
        let unit = self.srp.fus.get(op.fu);
        let how = unit.and_then(|unit| unit.timing(op.op));
        how.map_or(1, |how| how.latency)
    }

    /// Runs the bundles: what each step finds, what the exit finds, and what is left in the end.
    fn run(&mut self, steps: &[Vec<(usize, SlotOp)>]) -> (Vec<Issue>, Option<Token>, Registers) {
        let mut registers = Registers::default();
        let mut landing: BTreeMap<usize, Vec<(Reg, usize)>> = BTreeMap::new();
        let mut issues: BTreeMap<usize, Issue> = BTreeMap::new();
        let mut at_exit = None;
        let exit_cycle = self.exit_cycle();
        for (cycle, ops) in steps.iter().enumerate() {
            for (reg, i) in landing.remove(&cycle).unwrap_or_default() {
                registers.0.insert(reg, Token::Result(i));
            }
            for (i, op) in ops {
                let operands = registers.operands(&op.srcs);
                issues.insert(*i, Issue { cycle, operands });
                if let Some(dst) = op.dst {
                    let lands = cycle + self.latency(op) as usize;
                    landing.entry(lands).or_default().push((dst, *i));
                }
            }
            if exit_cycle == Some(cycle) {
                let read = self.stretch.exit.as_ref().and_then(control_read);
                at_exit = read.map(|(reg, _)| registers.read(reg));
            }
        }
        for (cycle, list) in landing {
            for (reg, i) in list {
                registers.0.insert(reg, Token::Result(i));
                if cycle > self.stretch.bundles {
                    let name = self.stretch.steps[i].op.name();
                    let message = format!("the result of `{name}` comes after the end");
                    self.report(issues[&i].cycle, Rule::InFlight, message);
                }
            }
        }
        (issues.into_values().collect(), at_exit, registers)
    }

    fn values(&mut self, wanted: &[Vec<Option<Token>>], issues: &[Issue]) {
        for (i, (wanted, issue)) in wanted.iter().zip(issues).enumerate() {
            let mut operands = wanted.iter().zip(&issue.operands);
            if let Some(k) = operands.position(|(a, b)| a != b) {
                let name = self.stretch.steps[i].op.name();
                let message =
                    format!("operand {k} of `{name}` is not the value it has in sequence");
                self.report(issue.cycle, Rule::Dataflow, message);
            }
        }
    }

    /// The storage of an access, as far as it can be shown.
    fn storage(&self, step: &Step) -> Storage {
        match step.storage {
            Storage::Object(object, address) => {
                let shown = self.proof.is_some_and(|p| p.points_into(address, object));
                if shown {
                    step.storage
                } else {
                    Storage::Anywhere
                }
            }
            storage => storage,
        }
    }

    /// Accesses that may meet keep their order. A load reads at the start of its cycle, a store
    /// writes at the end; what the ports do lies between the accesses before and after.
    fn memory(&mut self, tokens: &[Vec<Option<Token>>], issues: &[Issue]) {
        let steps = self.stretch.steps.iter().zip(tokens).enumerate();
        let accesses: Vec<Access> = steps
            .filter_map(|(i, (step, tokens))| Access::of(i, step, tokens, self.storage(step)))
            .collect();
        for (k, second) in accesses.iter().enumerate() {
            for first in &accesses[..k] {
                let Some(wait) = first.wait(second) else {
                    continue;
                };
                let (before, after) = (&issues[first.step], &issues[second.step]);
                if after.cycle < before.cycle + wait {
                    let name = |access: &Access| self.stretch.steps[access.step].op.name();
                    let (a, b) = (name(first), name(second));
                    let message = format!("`{b}` comes too early after `{a}`");
                    self.report(after.cycle, Rule::MemoryOrder, message);
                }
            }
        }
    }
}

/// An access of memory or of a port.
struct Access {
    step: usize,
    effect: Effect,
    /// `None` for ports.
    place: Option<Location>,
}

/// Where an access reads or writes, as far as it is known.
struct Location {
    space: Space,
    storage: Storage,
    /// The base register's content; `None` if the base is zero.
    base: Option<Token>,
    offset: u32,
    /// `None`: anywhere.
    bytes: Option<u32>,
}

impl Access {
    fn of(step: usize, data: &Step, tokens: &[Option<Token>], storage: Storage) -> Option<Access> {
        let effect = data.op.info().effect;
        let place = match data.op.space() {
            Some(space) => {
                let fixed = match data.srcs.get(1) {
                    Some(Src::Const(Bits::Word(address))) => *address,
                    _ => 0,
                };
                Some(Location {
                    space,
                    storage,
                    base: tokens.get(1).copied().flatten(),
                    offset: fixed.wrapping_add_signed(data.imm),
                    bytes: data.op.access_bytes(),
                })
            }
            _ if effect == Effect::Io => None,
            _ => return None,
        };
        Some(Access {
            step,
            effect,
            place,
        })
    }

    /// How many cycles `next` has to wait after this one; `None` where the two cannot meet.
    fn wait(&self, next: &Access) -> Option<usize> {
        let (Some(a), Some(b)) = (&self.place, &next.place) else {
            return Some(1);
        };
        let both_load = self.effect == Effect::Load && next.effect == Effect::Load;
        let apart = a.space != b.space || a.storage.is_apart(b.storage) || a.is_beside(b);
        (!both_load && !apart).then_some(usize::from(self.effect == Effect::Store))
    }
}

impl Location {
    /// True if both have the same base and share no byte.
    fn is_beside(&self, other: &Location) -> bool {
        let (Some(bytes), Some(others)) = (self.bytes, other.bytes) else {
            return false;
        };
        let ahead = other.offset.wrapping_sub(self.offset);
        self.base == other.base && ahead >= bytes && ahead.wrapping_neg() >= others
    }
}
