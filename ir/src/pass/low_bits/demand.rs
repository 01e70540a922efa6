//! The number of low bits of each word that are used, and operands without the extensions that nobody sees.
//!
//! The low bits of a sum, a difference, a product, a shift to the left, and of logic depend on as many low bits of the
//! operands and on nothing else (Warren, Hacker's Delight 2-2, calls such functions *computable from right to left*).

use super::WORD;
use crate::pass::defs::Defs;
use crate::pass::narrow::extended;
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Opcode;

/// For each value the number of its low bits that something depends on; 0 for values that nobody uses.
struct Demands {
    bits: EntityMap<Value, u32>,
    open: Vec<Value>,
}

impl Demands {
    fn of(func: &Function, defs: &Defs) -> Demands {
        let mut demands = Demands {
            bits: EntityMap::filled(func.values.len(), 0),
            open: Vec::new(),
        };
        let mut params: EntityMap<Value, Vec<Value>> =
            EntityMap::filled(func.values.len(), Vec::new());
        for &block in &func.layout {
            let data = &func.blocks[block];
            for &inst in &data.insts {
                let kind = &func.insts[inst].kind;
                if !kind.is_pure() {
                    demands.raise_operands(func, defs, kind, WORD);
                }
            }
            match &data.end {
                Terminator::Branch { cond, .. } => demands.raise(*cond, WORD),
                Terminator::Jump(_) => {}
                end => end.for_each_use(|value| demands.raise(value, WORD)),
            }
            for target in data.end.targets() {
                for (&param, &arg) in func.blocks[target.block].params.iter().zip(&target.args) {
                    params[param].push(arg);
                }
            }
        }
        while let Some(value) = demands.open.pop() {
            let bits = demands.bits[value];
            for &arg in &params[value] {
                demands.raise(arg, bits);
            }
            if let Some(inst) = defs.inst(value)
                && func.insts[inst].kind.is_pure()
            {
                demands.raise_operands(func, defs, &func.insts[inst].kind, bits);
            }
        }
        demands
    }

    fn raise(&mut self, value: Value, bits: u32) {
        if self.bits[value] < bits {
            self.bits[value] = bits;
            self.open.push(value);
        }
    }

    fn raise_operands(&mut self, func: &Function, defs: &Defs, kind: &InstKind, of_result: u32) {
        let mut place = 0;
        kind.for_each_use(|value| {
            let bits = operand(func, defs, kind, place, of_result);
            self.raise(value, bits);
            place += 1;
        });
    }
}

/// The low bits of an operand on which so many low bits of the result depend, or what the operation does.
fn operand(func: &Function, defs: &Defs, kind: &InstKind, place: usize, of_result: u32) -> u32 {
    let InstKind::Op { op, args, .. } = kind else {
        return WORD;
    };
    let constant = || args.get(1).and_then(|&by| defs.word(func, by));
    let by = || constant().filter(|_| place == 0).map(|by| by % WORD);
    match op {
        Opcode::Add | Opcode::Sub | Opcode::Mul | Opcode::Or | Opcode::Xor => of_result,
        Opcode::And => match constant().filter(|_| place == 0) {
            Some(mask) => of_result.min(WORD - mask.leading_zeros()),
            None => of_result,
        },
        Opcode::Sel if place > 0 => of_result,
        Opcode::Shl => by().map_or(WORD, |by| of_result.saturating_sub(by)),
        Opcode::Shr | Opcode::Sar => by().map_or(WORD, |by| (of_result + by).min(WORD)),
        Opcode::Sb | Opcode::Gsb if place == 2 => 8,
        Opcode::Sh | Opcode::Gsh if place == 2 => 16,
        _ => WORD,
    }
}

/// The value that a value has its low bits from, past extensions and masks that change others only.
fn source(func: &Function, defs: &Defs, mut value: Value, bits: u32) -> Value {
    if !(1..WORD).contains(&bits) {
        return value;
    }
    loop {
        let masked = match defs.op(func, value) {
            Some((Opcode::And, &[wide, mask])) => defs
                .word(func, mask)
                .filter(|mask| mask.trailing_ones() >= bits)
                .map(|_| wide),
            _ => None,
        };
        let wide = masked.or_else(|| {
            let (wide, narrow) = extended(func, defs, value)?;
            (narrow.bits >= bits).then_some(wide)
        });
        match wide {
            Some(wide) => value = wide,
            None => return value,
        }
    }
}

/// Takes operands without the extensions that change bits which nobody uses; whether there were any.
pub(super) fn leave_out(func: &mut Function) -> bool {
    let defs = Defs::of(func);
    let demands = Demands::of(func, &defs);
    let mut uses: Vec<(Use, Value)> = Vec::new();
    for &block in &func.layout {
        let data = &func.blocks[block];
        for &inst in &data.insts {
            let InstData { kind, results, .. } = &func.insts[inst];
            let of_result = match kind.is_pure() {
                true => results.iter().map(|&r| demands.bits[r]).max().unwrap_or(0),
                false => WORD,
            };
            for (place, &arg) in kind.args().iter().enumerate() {
                let bits = operand(func, &defs, kind, place, of_result);
                let from = source(func, &defs, arg, bits);
                if from != arg {
                    uses.push((Use::Operand(inst, place), from));
                }
            }
        }
        for (way, target) in data.end.targets().enumerate() {
            for (place, &arg) in target.args.iter().enumerate() {
                let bits = demands.bits[func.blocks[target.block].params[place]];
                let from = source(func, &defs, arg, bits);
                if from != arg {
                    uses.push((Use::Argument(block, way, place), from));
                }
            }
        }
    }
    for (at, from) in &uses {
        match *at {
            Use::Operand(inst, place) => {
                if let InstKind::Op { args, .. } = &mut func.insts[inst].kind {
                    args[place] = *from;
                }
            }
            Use::Argument(block, way, place) => {
                let target = func.blocks[block].end.targets_mut().nth(way);
                target.expect("it was there").args[place] = *from;
            }
        }
    }
    !uses.is_empty()
}

/// A use of a value.
enum Use {
    /// The operand of an instruction.
    Operand(Inst, usize),
    /// An argument of a block's jump: on which of its ways, as which parameter.
    Argument(Block, usize, usize),
}
