//! Units for the reciprocals, roots and quotients of a program, of which a machine may have two each.
//!
//! A pragma before a loop says how exact a function has to be in it; the checker has found the cheapest
//! unit that is. It counts for all that the loop computes, so functions that the loop calls are copied, and
//! the copies use that unit. Calls of pointers are not followed, nor are functions of the library, whose
//! results rely on the units that they were written for; but `sqrtf` is a root like another.

use super::function::{KernelNames, Units, Wish};
use crate::options::Options;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::Opcode;
use srp_archdesc::structure::Special;
use srp_ir::program::*;
use std::collections::{BTreeMap, BTreeSet};

/// What is said of the units of one function.
pub(super) struct Wishes {
    /// Inner loops first.
    pub(super) loops: Vec<Wish>,
    /// Its operations stay as they are.
    pub(super) fixed: bool,
}

impl Wishes {
    /// The units for an instruction, in a copy of its function for `around`.
    fn units(&self, inst: Inst, around: &Units) -> Units {
        let mut units = around.clone();
        let of = self.loops.iter().rev();
        for wish in of.filter(|wish| wish.insts.contains(&inst.index())) {
            units.extend(wish.units.iter().map(|(&special, &op)| (special, op)));
        }
        units
    }
}

/// Gives operations the units that pragmas and [`Options::max_ulp`] ask for.
pub(super) fn choose(
    program: &mut Program,
    wishes: &EntityMap<Func, Wishes>,
    options: &Options<'_>,
    kernels: &mut KernelNames,
) {
    let everywhere = everywhere(options);
    if everywhere.is_empty() && wishes.values().all(|wishes| wishes.loops.is_empty()) {
        return;
    }
    let mut choosing = Choosing {
        original: program.funcs.clone(),
        wishes,
        everywhere,
        copies: BTreeMap::new(),
        funcs: &mut program.funcs,
        open: Vec::new(),
        kernels,
    };
    for func in choosing.original.keys() {
        choosing.body(func, func, &Units::new());
    }
    while let Some((copy, of, units)) = choosing.open.pop() {
        choosing.body(copy, of, &units);
    }
}

/// The units that are within the error that the whole program may have.
fn everywhere(options: &Options<'_>) -> Units {
    let Some(ulp) = options.max_ulp else {
        return Units::new();
    };
    let error = ulp / f64::from(1 << 24);
    let unit = |special| Some((special, options.choices.within(special, error)?.op));
    let ordinary = Special::ALL
        .into_iter()
        .filter(|special| !special.is_fast());
    ordinary.filter_map(unit).collect()
}

struct Choosing<'a> {
    original: EntityMap<Func, Function>,
    wishes: &'a EntityMap<Func, Wishes>,
    /// Units for operations of which no pragma says more.
    everywhere: Units,
    /// Copies of functions, by the units that they use.
    copies: BTreeMap<(Func, Units), Func>,
    funcs: &'a mut EntityMap<Func, Function>,
    /// Copies, their originals and units, that still have the original's operations.
    open: Vec<(Func, Func, Units)>,
    kernels: &'a mut KernelNames,
}

impl Choosing<'_> {
    /// Chooses the units of `func`, which is the function `of` or a copy of it for a loop that asks for `around`.
    fn body(&mut self, func: Func, of: Func, around: &Units) {
        let wishes = &self.wishes[of];
        if wishes.fixed {
            return;
        }
        let powers = powers_of_two(&self.original[of]);
        for inst in self.original[of].insts.keys() {
            let units = wishes.units(inst, around);
            match &self.original[of].insts[inst].kind {
                InstKind::Op { op, args, .. } => {
                    let Some(chosen) = self.unit(*op, &units) else {
                        continue;
                    };
                    // By a power of two it is a product.
                    if args.len() == 2 && powers.contains(&args[1]) {
                        continue;
                    }
                    if let InstKind::Op { op, .. } = &mut self.funcs[func].insts[inst].kind {
                        *op = chosen;
                    }
                }
                InstKind::Call {
                    callee: Callee::Func(callee),
                    ..
                } if !units.is_empty() => {
                    let copy = self.copy(*callee, units);
                    if let InstKind::Call { callee, .. } = &mut self.funcs[func].insts[inst].kind {
                        *callee = Callee::Func(copy);
                    }
                }
                _ => {}
            }
        }
    }

    /// The operation that computes what `op` does, if another is asked for than it.
    fn unit(&self, op: Opcode, units: &Units) -> Option<Opcode> {
        let special = Special::of(op)?;
        let asked = units.get(&special.ordinary());
        let chosen = match special.is_fast() {
            // What C says stays but for a pragma.
            true => asked,
            false => asked.or(self.everywhere.get(&special)),
        };
        chosen.copied().filter(|&chosen| chosen != op)
    }

    /// A copy of a function whose operations use some units; itself where it is fixed.
    fn copy(&mut self, of: Func, units: Units) -> Func {
        if self.wishes[of].fixed {
            return of;
        }
        let key = (of, units);
        if let Some(&copy) = self.copies.get(&key) {
            return copy;
        }
        let mut copy = self.original[of].clone();
        let names = key.1.values().map(|op| op.name());
        copy.name = names.fold(copy.name, |name, op| format!("{name}.{op}"));
        for block in copy.blocks.values_mut() {
            if let Some(kernel) = &mut block.kernel {
                kernel.name = self.kernels.after(&copy.name);
            }
        }
        let copy = self.funcs.push(copy);
        self.open.push((copy, of, key.1.clone()));
        self.copies.insert(key, copy);
        copy
    }
}

/// The constants whose reciprocals are exact.
fn powers_of_two(func: &Function) -> BTreeSet<Value> {
    let insts = func.insts.values().filter(|inst| {
        matches!(inst.kind, InstKind::Const(Bits::Word(word))
            if word & 0x007f_ffff == 0 && f32::from_bits(word).is_normal())
    });
    insts
        .flat_map(|inst| inst.results.first())
        .copied()
        .collect()
}
