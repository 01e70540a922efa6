//! Addresses as sums whose constant comes last: `a + ((i + 1) << 2)` becomes `(a + (i << 2)) + 4`. The
//! constant goes into the access, and the copies of an unrolled loop share what is left.

use super::defs::Defs;
use crate::program::*;
use srp_archdesc::isa::Opcode;

/// Values whose sum an address is taken for.
const MAX_TERMS: usize = 4;

/// Puts the constants of addresses last.
pub(crate) fn addresses(func: &mut Function) -> bool {
    let defs = Defs::of(func);
    let mut changed = false;
    for block in func.layout.clone() {
        for inst in std::mem::take(&mut func.blocks[block].insts) {
            let pos = func.insts[inst].pos;
            if let InstKind::Op { op, args, .. } = &func.insts[inst].kind
                && op.access_bytes().is_some()
                && let Some(sum) = Sum::of(func, &defs, args[1])
            {
                let address = sum.append(func, block, pos);
                if let InstKind::Op { args, .. } = &mut func.insts[inst].kind {
                    args[1] = address;
                }
                changed = true;
            }
            func.blocks[block].insts.push(inst);
        }
    }
    changed
}

/// The sum of values, each shifted to the left, and of a constant.
struct Sum {
    terms: Vec<(Value, u32)>,
    constant: u32,
}

impl Sum {
    /// An address as a sum, if that finds a constant which is not the last summand already.
    fn of(func: &Function, defs: &Defs, address: Value) -> Option<Sum> {
        let constant = |value: Value| defs.word(func, value);
        let mut sum = Sum {
            terms: Vec::new(),
            constant: 0,
        };
        let mut found = false;
        // The value, how far it is shifted, and how many values it is part of.
        let mut open = vec![(address, 0, 0)];
        while let Some((value, shift, depth)) = open.pop() {
            if let Some(word) = constant(value) {
                sum.constant = sum.constant.wrapping_add(word.wrapping_shl(shift));
                found |= depth > 1;
                continue;
            }
            let fits = sum.terms.len() + open.len() + 2 <= MAX_TERMS;
            match defs.op(func, value) {
                Some((Opcode::Add, &[a, b])) if fits => {
                    open.extend([(a, shift, depth + 1), (b, shift, depth + 1)]);
                }
                Some((Opcode::Shl, &[a, by])) if shift == 0 => match constant(by) {
                    Some(by @ 1..=8) => open.push((a, by, depth)),
                    _ => sum.terms.push((value, shift)),
                },
                _ => sum.terms.push((value, shift)),
            }
        }
        sum.terms
            .sort_unstable_by_key(|&(value, shift)| (shift, value));
        (found && !sum.terms.is_empty()).then_some(sum)
    }

    /// Appends the sum to a block.
    fn append(self, func: &mut Function, block: Block, pos: Pos) -> Value {
        let word = |func: &mut Function, word| func.append_const(block, Bits::Word(word), pos);
        let op = |func: &mut Function, op, args: [Value; 2]| {
            let value = func.append_op(block, op, &args, 0, pos);
            value.expect("the operation has a result")
        };
        let mut sum = None;
        for (value, shift) in self.terms {
            let mut term = value;
            if shift > 0 {
                let by = word(func, shift);
                term = op(func, Opcode::Shl, [value, by]);
            }
            sum = Some(match sum {
                None => term,
                Some(sum) => op(func, Opcode::Add, [sum, term]),
            });
        }
        let sum = sum.expect("a sum has terms");
        let constant = word(func, self.constant);
        op(func, Opcode::Add, [sum, constant])
    }
}
