//! Scalar promotion: what a loop keeps in a word of a global, it keeps in a value instead.

use super::alias::{Object, Objects};
use super::preheader::{find, with_preheaders};
use super::slots::{load, slot_for, store};
use crate::flow::{Flow, LoopData};
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Effect, Opcode, Space, Ty};
use std::collections::BTreeMap;

/// A word or vector of a global.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    global: Global,
    start: i32,
    vector: bool,
}

impl Place {
    /// True when it can be accessed, be that in the program or not: a loop may have accesses that it
    /// never makes.
    fn is_there(&self, globals: &EntityMap<Global, GlobalData>) -> bool {
        let GlobalData { size, align, .. } = globals[self.global];
        let bytes = if self.vector { 16 } else { 4 };
        let start = u32::try_from(self.start).ok();
        let end = start.and_then(|start| start.checked_add(bytes));
        let inside = end.is_some_and(|end| end <= size);
        inside && align >= bytes && start.is_some_and(|start| start.is_multiple_of(bytes))
    }
}

/// Loads a word that a marked loop stores to before the loop, and stores it behind, where all else
/// that the loop accesses is surely elsewhere. In between it is in a stack slot, which
/// [`mem2reg`](super::mem2reg) makes a value.
pub(crate) fn promote(func: &mut Function, globals: &EntityMap<Global, GlobalData>) -> bool {
    let wanted = |b: &Block| func.blocks[*b].kernel.as_ref().is_some_and(|m| !m.nest);
    if !func.layout.iter().any(wanted) {
        return false;
    }
    let Flow { cfg, loops, .. } = with_preheaders(func);
    let mut changed = false;
    for (id, data) in loops.loops.iter() {
        if !loops.is_innermost(id) || func.blocks[data.header].kernel.is_none() {
            continue;
        }
        let before = find(func, &cfg, data).expect("every loop was given a preheader");
        for (place, accesses) in places(func, data, globals) {
            keep(func, data, before, place, &accesses);
            changed = true;
        }
    }
    changed
}

/// The places that can be promoted, with their accesses.
fn places(
    func: &Function,
    data: &LoopData,
    globals: &EntityMap<Global, GlobalData>,
) -> BTreeMap<Place, Vec<Inst>> {
    let objects = Objects::of(func);
    let mut symbols = EntityMap::<Value, Option<(Global, i32)>>::filled(func.values.len(), None);
    for &inst in func.layout.iter().flat_map(|&b| &func.blocks[b].insts) {
        if let InstKind::SymbolAddr(Symbol::Global(global), offset) = func.insts[inst].kind {
            symbols[func.insts[inst].results[0]] = Some((global, offset));
        }
    }
    let mut found = BTreeMap::<Place, Vec<Inst>>::new();
    let mut stored = Vec::new();
    let mut others = Vec::new();
    for &inst in data.blocks.iter().flat_map(|&b| &func.blocks[b].insts) {
        let (op, args, imm) = match &func.insts[inst].kind {
            InstKind::Op { op, args, imm } => (*op, args, *imm),
            InstKind::Call { .. } | InstKind::Launch { .. } => return BTreeMap::new(),
            _ => continue,
        };
        match op.info().effect {
            Effect::Pure | Effect::Prefetch => continue,
            Effect::Io => return BTreeMap::new(),
            _ if op.space() != Some(Space::Sram) => continue,
            _ => {}
        }
        let Some(object) = objects.object(args[1]) else {
            return BTreeMap::new();
        };
        let whole = matches!(op, Opcode::Lw | Opcode::Sw | Opcode::Lv | Opcode::Sv);
        match symbols[args[1]].filter(|_| whole) {
            Some((global, offset)) => {
                let place = Place {
                    global,
                    start: offset.wrapping_add(imm),
                    vector: matches!(op, Opcode::Lv | Opcode::Sv),
                };
                if op.info().effect == Effect::Store {
                    stored.push(place);
                }
                found.entry(place).or_default().push(inst);
            }
            None => others.push(object),
        }
    }
    let all: Vec<Place> = found.keys().copied().collect();
    found.retain(|place, _| {
        let symbol = Object::Symbol(Symbol::Global(place.global));
        let start = |p: &Place| i64::from(p.start);
        let end = |p: &Place| start(p) + if p.vector { 16 } else { 4 };
        let overlaps =
            |p: &&Place| p.global == place.global && start(p) < end(place) && start(place) < end(p);
        stored.contains(place)
            && place.is_there(globals)
            && !others.contains(&symbol)
            && all.iter().filter(overlaps).count() == 1
    });
    found
}

/// Keeps one place in a slot while a loop runs.
fn keep(func: &mut Function, data: &LoopData, before: Block, place: Place, accesses: &[Inst]) {
    let (ty, first, last) = match place.vector {
        true => (Ty::Vec, Opcode::Lv, Opcode::Sv),
        false => (Ty::Word, Opcode::Lw, Opcode::Sw),
    };
    let pos = func.insts[accesses[0]].pos;
    let slot = slot_for(func, ty);
    let symbol = InstKind::SymbolAddr(Symbol::Global(place.global), place.start);
    let start = func.append(before, symbol.clone(), &[Ty::Word], pos);
    let start = func.insts[start].results[0];
    let truth = func.append_const(before, Bits::Pred(true), pos);
    let value = func.append_op(before, first, &[truth, start], 0, pos);
    let insts = store(func, slot, value.expect("loads have a result"), pos);
    func.blocks[before].insts.extend(insts);
    for &block in &data.blocks {
        let mut insts = Vec::new();
        for inst in std::mem::take(&mut func.blocks[block].insts) {
            if accesses.contains(&inst) {
                let pos = func.insts[inst].pos;
                let address = func.make_inst(InstKind::SlotAddr(slot, 0), &[Ty::Word], pos);
                insts.push(address);
                let address = func.insts[address].results[0];
                if let InstKind::Op { args, imm, .. } = &mut func.insts[inst].kind {
                    args[1] = address;
                    *imm = 0;
                }
            }
            insts.push(inst);
        }
        func.blocks[block].insts = insts;
    }
    for &block in &data.blocks {
        let ways = func.blocks[block].end.targets().count();
        for way in 0..ways {
            let target = func.blocks[block].end.targets().nth(way).cloned();
            let Some(target) = target.filter(|t| !data.contains(t.block)) else {
                continue;
            };
            let behind = func.add_block();
            let (insts, value) = load(func, slot, ty, pos);
            func.blocks[behind].insts = insts;
            let start = func.append(behind, symbol.clone(), &[Ty::Word], pos);
            let start = func.insts[start].results[0];
            let truth = func.append_const(behind, Bits::Pred(true), pos);
            func.append_op(behind, last, &[truth, start, value], 0, pos);
            func.blocks[behind].end = Terminator::Jump(target);
            func.blocks[behind].end_pos = func.blocks[block].end_pos;
            if let Some(target) = func.blocks[block].end.targets_mut().nth(way) {
                *target = Target::to(behind);
            }
        }
    }
}
