//! Selections between sums on recurrences.

use super::Trees;
use crate::pass::cycle::Cycles;
use crate::pass::defs::Defs;
use crate::program::*;
use srp_archdesc::arch::Precision;
use srp_archdesc::isa::Opcode;
use srp_archdesc::ops::{self, V4};

/// Makes of `p ? s + x : s + y`, where a loop carries s and y may be nothing, the sum `s + (p ? x : y)`: the selection
/// leaves the recurrence, unless this leads through p.
pub(super) fn distribute(func: &mut Function, block: Block, precision: &Precision) -> bool {
    let cycles = Cycles::of(func, block);
    if cycles.is_empty() {
        return false;
    }
    let sums = Sums {
        trees: Trees::of(func, block),
        defs: Defs::of(func),
        cycles,
        block,
        precision,
    };
    let mut changed = false;
    for inst in func.blocks[block].insts.clone() {
        let InstKind::Op {
            op: Opcode::Sel | Opcode::Vsel,
            args,
            ..
        } = &func.insts[inst].kind
        else {
            continue;
        };
        let [on, yes, no] = args[..] else {
            continue;
        };
        let result = func.insts[inst].results[0];
        if sums.cycles.has(on, result) {
            continue;
        }
        let Some((op, kept, ways)) = sums.ways(func, result, [yes, no]) else {
            continue;
        };
        let (pos, ty) = (func.insts[inst].pos, func.values[result]);
        let nothing = neutral(op).expect("a sum has nothing to add");
        let nothing = func.make_inst(InstKind::Const(nothing), &[ty], pos);
        let none = func.insts[nothing].results[0];
        let ways = ways.map(|way| way.unwrap_or(none));
        let chosen = func.make_inst(
            InstKind::Op {
                op: Opcode::select(ty),
                args: vec![on, ways[0], ways[1]],
                imm: 0,
            },
            &[ty],
            pos,
        );
        let args = vec![kept, func.insts[chosen].results[0]];
        func.insts[inst].kind = InstKind::Op { op, args, imm: 0 };
        let insts = &mut func.blocks[block].insts;
        let place = insts.iter().position(|&i| i == inst).expect("it is there");
        insts.splice(place..place, [nothing, chosen]);
        changed = true;
    }
    changed
}

/// The second operand by which an operation leaves the first as it is: of floats, those that it has computed. −0 is the one zero that
/// a sum with +0 or −0 does not show.
fn neutral(op: Opcode) -> Option<Bits> {
    Some(match op {
        Opcode::Add | Opcode::Sub | Opcode::Or | Opcode::Xor | Opcode::Fsub => Bits::Word(0),
        Opcode::Fadd => Bits::Word((-0.0f32).to_bits()),
        Opcode::Fmul => Bits::Word(1f32.to_bits()),
        Opcode::Vfsub => Bits::Vec([0; 4]),
        Opcode::Vfadd => Bits::Vec([(-0.0f32).to_bits(); 4]),
        Opcode::Vfmul => Bits::Vec([1f32.to_bits(); 4]),
        _ => return None,
    })
}

/// The operations whose results are in the format of an operation's: no rounding, no flushing and no kind of NaN shows
/// whether it is done once more. Empty for integers, of which all are.
fn same_format(op: Opcode) -> &'static [Opcode] {
    match op {
        Opcode::Fadd | Opcode::Fsub => &[Opcode::Fadd, Opcode::Fsub],
        Opcode::Vfadd | Opcode::Vfsub => &[Opcode::Vfadd, Opcode::Vfsub],
        Opcode::Fmul => &[Opcode::Fmul],
        Opcode::Vfmul => &[Opcode::Vfmul],
        _ => &[],
    }
}

/// The sums of a block that is a loop.
struct Sums<'a> {
    trees: Trees,
    defs: Defs,
    cycles: Cycles,
    block: Block,
    precision: &'a Precision,
}

impl Sums<'_> {
    /// A value that the loop carries on the way to `result`, and what an operation adds to it on each of two ways, if it
    /// does.
    fn ways(
        &self,
        func: &Function,
        result: Value,
        [yes, no]: [Value; 2],
    ) -> Option<(Opcode, Value, [Option<Value>; 2])> {
        let added = |sum: Value, kept: Value| {
            let (_, op, args) = self.trees.inner(func, sum)?;
            let differs = matches!(op, Opcode::Sub | Opcode::Fsub | Opcode::Vfsub);
            let other = match args[..] {
                [a, other] if a == kept => other,
                [other, a] if a == kept && !differs => other,
                _ => return None,
            };
            let carried = |value| self.cycles.has(value, result);
            (neutral(op).is_some() && carried(kept) && !carried(other)).then_some((op, other))
        };
        if let Some((op, other)) = added(yes, no) {
            return self
                .stays(func, op, no)
                .then_some((op, no, [Some(other), None]));
        }
        if let Some((op, other)) = added(no, yes) {
            return self
                .stays(func, op, yes)
                .then_some((op, yes, [None, Some(other)]));
        }
        let (_, _, operands) = self.trees.inner(func, yes)?;
        operands.iter().find_map(|&kept| {
            let (op, one) = added(yes, kept)?;
            let (same, other) = added(no, kept)?;
            (op == same).then_some((op, kept, [Some(one), Some(other)]))
        })
    }

    /// True if an operation with what is neutral to it leaves a value as it is.
    fn stays(&self, func: &Function, op: Opcode, value: Value) -> bool {
        let computed = same_format(op);
        if computed.is_empty() {
            return true;
        }
        let (mut open, mut seen) = (vec![value], Vec::new());
        while let Some(value) = open.pop() {
            if seen.contains(&value) {
                continue;
            }
            seen.push(value);
            let params = &func.blocks[self.block].params;
            if let Some(place) = params.iter().position(|&param| param == value) {
                let targets = func.layout.iter();
                let targets = targets.flat_map(|&from| func.blocks[from].end.targets());
                let into = targets.filter(|target| target.block == self.block);
                open.extend(into.map(|target| target.args[place]));
                continue;
            }
            match self.defs.kind(func, value) {
                Some(InstKind::Op { op, .. }) if computed.contains(op) => {}
                Some(InstKind::Op {
                    op: Opcode::Sel | Opcode::Vsel,
                    args,
                    ..
                }) => open.extend(&args[1..]),
                Some(InstKind::Const(bits)) if self.is_kept(op, *bits) => {}
                _ => return false,
            }
        }
        true
    }

    /// True if a constant stays as it is.
    fn is_kept(&self, op: Opcode, constant: Bits) -> bool {
        let Some(nothing) = neutral(op) else {
            return false;
        };
        let args = [V4(constant.lanes()), V4(nothing.lanes())];
        let result = ops::eval(op, &args, 0, self.precision);
        matches!(result, Ok(Some(value)) if value == args[0])
    }
}
