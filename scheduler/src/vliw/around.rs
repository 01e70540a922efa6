//! Values around calls. A call keeps no register, so a value that is read after one has to be on the stack
//! meanwhile. It is stored just before the call and comes back at its first use after it, where that costs
//! less than to leave it on the stack: where loops read it that do not call.

use super::allocate::is_remade;
use super::lir::{Arg, Code, FrameItem, Inst, Kind, Label, Vreg};
use super::liveness::{live_out, step};
use super::target::Target;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::program::{Bits, Pos};
use std::collections::{BTreeMap, BTreeSet};

/// Cycles that a load and a store take.
const LOAD: u64 = 3;
const STORE: u64 = 1;

/// Stores values before the calls that they outlive, and loads them after those.
pub(super) fn save_around_calls(code: &mut Code, target: &Target<'_>) {
    let outliving = outliving(code, target);
    let homes = chosen(code, target, &outliving);
    if homes.is_empty() {
        return;
    }
    let mut saver = Saver {
        homes,
        sp: Vreg::new(target.sp() as usize),
        stored: BTreeSet::new(),
        away: BTreeSet::new(),
        out: Vec::new(),
    };
    for label in code.order.clone() {
        let insts = std::mem::take(&mut code.blocks[label].insts);
        let mut calls = outliving[label].iter();
        for inst in insts {
            let across = if is_call(&inst) { calls.next() } else { None };
            saver.inst(code, inst, across);
        }
        let pos = code.blocks[label].end_pos;
        for reg in std::mem::take(&mut saver.away) {
            saver.load(code, reg, pos);
        }
        saver.stored.clear();
        code.blocks[label].insts = std::mem::take(&mut saver.out);
    }
}

fn is_call(inst: &Inst) -> bool {
    matches!(inst.kind, Kind::Call(_) | Kind::CallLink)
}

/// The virtual registers that hold a value across each call of each block.
fn outliving(code: &Code, target: &Target<'_>) -> EntityMap<Label, Vec<Vec<Vreg>>> {
    let out = live_out(code);
    let mut all = EntityMap::filled(code.blocks.len(), Vec::new());
    for &label in &code.order {
        let block = &code.blocks[label];
        let mut live = out[label].clone();
        block.end.uses().for_each(|r| live.insert(r));
        for inst in block.insts.iter().rev() {
            if is_call(inst) {
                let is_virtual = |r: &Vreg| r.index() >= target.physical() as usize;
                let across = live.iter().filter(is_virtual);
                all[label].push(across.filter(|r| !inst.defs.contains(r)).collect());
            }
            step(&mut live, inst);
        }
        all[label].reverse();
    }
    all
}

/// The stack places of the values that are worth it.
fn chosen(
    code: &mut Code,
    target: &Target<'_>,
    outliving: &EntityMap<Label, Vec<Vec<Vreg>>>,
) -> BTreeMap<Vreg, u32> {
    let sp = Vreg::new(target.sp() as usize);
    let mut around: BTreeMap<Vreg, u64> = BTreeMap::new();
    for &label in &code.order {
        for &reg in outliving[label].iter().flatten() {
            *around.entry(reg).or_insert(0) += (LOAD + STORE) * weight(code, label);
        }
    }
    around.retain(|&reg, _| code.regs[reg].ty != Ty::Pred);
    let mut always: BTreeMap<Vreg, u64> = BTreeMap::new();
    for &label in &code.order {
        let weight = weight(code, label);
        let mut here = BTreeSet::new();
        let block = &code.blocks[label];
        for inst in &block.insts {
            for reg in inst.uses().filter(|reg| here.insert(*reg)) {
                *always.entry(reg).or_insert(0) += LOAD * weight;
            }
            if is_call(inst) {
                here.clear();
            }
            for &def in &inst.defs {
                // What can be made anew needs no place on the stack.
                let cost = if is_remade(inst, sp) {
                    0
                } else {
                    STORE * weight
                };
                *always.entry(def).or_insert(0) += cost;
                if cost == 0 {
                    around.remove(&def);
                }
                here.insert(def);
            }
        }
        for reg in block.end.uses().filter(|reg| here.insert(*reg)) {
            *always.entry(reg).or_insert(0) += LOAD * weight;
        }
    }
    let worth = around
        .into_iter()
        .filter(|(reg, cost)| always.get(reg) > Some(cost));
    let worth: Vec<Vreg> = worth.map(|(reg, _)| reg).collect();
    let mut homes = BTreeMap::new();
    for reg in worth {
        let home = code.frame.homes.len() as u32;
        code.frame.homes.push(code.regs[reg].ty);
        code.regs[reg].home = Some(home);
        homes.insert(reg, home);
    }
    homes
}

/// How often a block runs, by the loops around it.
fn weight(code: &Code, label: Label) -> u64 {
    10_u64.pow(code.blocks[label].depth.min(6))
}

struct Saver {
    homes: BTreeMap<Vreg, u32>,
    sp: Vreg,
    /// Values that are on the stack too.
    stored: BTreeSet<Vreg>,
    /// Values that are only there.
    away: BTreeSet<Vreg>,
    out: Vec<Inst>,
}

impl Saver {
    fn inst(&mut self, code: &Code, inst: Inst, across: Option<&Vec<Vreg>>) {
        let used: Vec<Vreg> = inst.uses().filter(|r| self.away.contains(r)).collect();
        for reg in used {
            if self.away.remove(&reg) {
                self.load(code, reg, inst.pos);
            }
        }
        let across = across.into_iter().flatten().copied();
        let across: Vec<Vreg> = across.filter(|r| self.homes.contains_key(r)).collect();
        for &reg in &across {
            if self.stored.insert(reg) {
                self.store(code, reg, inst.pos);
            }
        }
        for def in &inst.defs {
            self.stored.remove(def);
            self.away.remove(def);
        }
        self.out.push(inst);
        self.away.extend(across);
    }

    fn store(&mut self, code: &Code, reg: Vreg, pos: Pos) {
        let op = match code.regs[reg].ty {
            Ty::Vec => Opcode::Sv,
            _ => Opcode::Sw,
        };
        let mut args = self.place();
        args.push(Arg::Reg(reg));
        let home = FrameItem::Home(self.homes[&reg]);
        self.out.push(Inst::private(op, args, home, pos));
    }

    fn load(&mut self, code: &Code, reg: Vreg, pos: Pos) {
        let op = match code.regs[reg].ty {
            Ty::Vec => Opcode::Lv,
            _ => Opcode::Lw,
        };
        let home = FrameItem::Home(self.homes[&reg]);
        self.out
            .push(Inst::private(op, self.place(), home, pos).to(reg));
    }

    fn place(&self) -> Vec<Arg> {
        vec![Arg::Const(Bits::Pred(true)), Arg::Reg(self.sp)]
    }
}
