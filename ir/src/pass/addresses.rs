//! Addresses as sums whose constant comes last: `a + ((i + 1) << 2)` becomes `(a + (i << 2)) + 4`. The
//! constant goes into the access, and the copies of an unrolled loop share what is left.

use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::isa::Opcode;

/// Values whose sum an address is taken for.
const MAX_TERMS: usize = 4;

/// Puts the constants of addresses last.
pub(crate) fn addresses(func: &mut Function) -> bool {
    let mut defs = FxHashMap::default();
    for &inst in func.layout.iter().flat_map(|&b| &func.blocks[b].insts) {
        let results = func.insts[inst].results.iter();
        defs.extend(results.map(|&v| (v, inst)));
    }
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
    fn of(func: &Function, defs: &FxHashMap<Value, Inst>, address: Value) -> Option<Sum> {
        let op = |value: Value| match &func.insts[*defs.get(&value)?].kind {
            InstKind::Op { op, args, .. } => Some((*op, [*args.first()?, *args.get(1)?])),
            _ => None,
        };
        let constant = |value: Value| match func.insts[*defs.get(&value)?].kind {
            InstKind::Const(Bits::Word(word)) => Some(word),
            _ => None,
        };
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
            match op(value) {
                Some((Opcode::Add, [a, b])) if fits => {
                    open.extend([(a, shift, depth + 1), (b, shift, depth + 1)]);
                }
                Some((Opcode::Shl, [a, by])) if shift == 0 => match constant(by) {
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
