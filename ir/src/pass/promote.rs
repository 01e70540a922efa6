//! Scalar promotion: what a loop keeps in a word of memory, it keeps in a value instead.

use super::alias::{Objects, Scopes};
use super::preheader::{find, with_preheaders};
use super::slots::{load, slot_for, store};
use crate::flow::{Dominators, Flow, LoopData};
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Effect, Opcode, Space, Ty};
use std::collections::BTreeMap;

/// Where a word stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Base {
    Global(Global),
    /// An address that was made before the loop.
    Address(Value),
}

/// A word or vector of a global, or at some distance from an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    base: Base,
    start: i32,
    vector: bool,
}

impl Place {
    /// True when it is a place of a global that can be accessed, be that in the program or not: a loop may have accesses that it
    /// never makes.
    fn is_there(&self, globals: &EntityMap<Global, GlobalData>) -> bool {
        let Base::Global(global) = self.base else {
            return false;
        };
        let GlobalData { size, align, .. } = globals[global];
        let bytes = self.bytes() as u32;
        let start = u32::try_from(self.start).ok();
        let end = start.and_then(|start| start.checked_add(bytes));
        let inside = end.is_some_and(|end| end <= size);
        inside && align >= bytes && start.is_some_and(|start| start.is_multiple_of(bytes))
    }

    fn bytes(&self) -> i64 {
        if self.vector { 16 } else { 4 }
    }

    /// True if two places of one base have bytes in common.
    fn overlaps(&self, other: &Place) -> bool {
        let (one, two) = (i64::from(self.start), i64::from(other.start));
        one < two + other.bytes() && two < one + self.bytes()
    }
}

/// The accesses of a loop to one place.
#[derive(Default)]
struct Accesses {
    insts: Vec<Inst>,
    /// An address that points to where the place is.
    near: Option<Value>,
    is_stored: bool,
    /// Every iteration makes one.
    is_sure: bool,
}

/// Loads a word that a marked loop stores to before the loop, and stores it behind, where all else
/// that the loop accesses is surely elsewhere. In between it is in a stack slot, which
/// [`mem2reg`](super::mem2reg) makes a value. The word is of a global, or an access to it is made in every iteration.
pub(crate) fn promote(func: &mut Function, globals: &EntityMap<Global, GlobalData>) -> bool {
    let wanted = |b: &Block| func.blocks[*b].kernel.as_ref().is_some_and(|m| !m.nest);
    if !func.layout.iter().any(wanted) {
        return false;
    }
    let flow = with_preheaders(func);
    let mut scopes = Scopes::default();
    let mut changed = false;
    for (id, data) in flow.loops.loops.iter() {
        if !flow.loops.is_innermost(id) || func.blocks[data.header].kernel.is_none() {
            continue;
        }
        let before = find(func, &flow.cfg, data).expect("every loop was given a preheader");
        let objects = scopes.of_block(func, data.header);
        for (place, accesses) in places(func, &flow, data, objects, globals) {
            keep(func, data, before, place, &accesses);
            changed = true;
        }
    }
    changed
}

/// The places that can be promoted, with their accesses.
fn places(
    func: &Function,
    flow: &Flow,
    data: &LoopData,
    objects: &Objects,
    globals: &EntityMap<Global, GlobalData>,
) -> BTreeMap<Place, Vec<Inst>> {
    let mut symbols = EntityMap::<Value, Option<(Global, i32)>>::filled(func.values.len(), None);
    let mut truths = EntityMap::<Value, bool>::filled(func.values.len(), false);
    for &inst in func.layout.iter().flat_map(|&b| &func.blocks[b].insts) {
        let InstData { kind, results, .. } = &func.insts[inst];
        match *kind {
            InstKind::SymbolAddr(Symbol::Global(global), offset) => {
                symbols[results[0]] = Some((global, offset));
            }
            InstKind::Const(Bits::Pred(true)) => truths[results[0]] = true,
            _ => {}
        }
    }
    let inside = made_inside(func, data);
    let mut found = BTreeMap::<Place, Accesses>::new();
    let mut others: Vec<Value> = Vec::new();
    for &block in &data.blocks {
        let in_all = is_in_all(func, &flow.dominators, data, block);
        for &inst in &func.blocks[block].insts {
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
            let address = args[1];
            let (base, start) = match symbols[address] {
                Some((global, offset)) => (Base::Global(global), offset.wrapping_add(imm)),
                None => (Base::Address(address), imm),
            };
            let whole = matches!(op, Opcode::Lw | Opcode::Sw | Opcode::Lv | Opcode::Sv);
            let changes = matches!(base, Base::Address(_)) && inside[address];
            if !whole || changes {
                others.push(address);
                continue;
            }
            let vector = matches!(op, Opcode::Lv | Opcode::Sv);
            let accesses = found
                .entry(Place {
                    base,
                    start,
                    vector,
                })
                .or_default();
            accesses.insts.push(inst);
            accesses.near = Some(address);
            accesses.is_stored |= op.info().effect == Effect::Store;
            accesses.is_sure |= in_all && truths[args[0]];
        }
    }
    let apart =
        |one: &Accesses, other: Value| one.near.is_some_and(|near| objects.are_apart(near, other));
    let alone = |place: &Place, accesses: &Accesses| {
        let disjoint = |(other, accesses_of): (&Place, &Accesses)| {
            other == place
                || match other.base == place.base {
                    true => !place.overlaps(other),
                    false => accesses_of.near.is_some_and(|near| apart(accesses, near)),
                }
        };
        found.iter().all(disjoint) && others.iter().all(|&other| apart(accesses, other))
    };
    let can = |place: &Place, accesses: &Accesses| {
        accesses.is_stored
            && (place.is_there(globals) || accesses.is_sure)
            && alone(place, accesses)
    };
    let kept = found
        .iter()
        .filter(|(place, accesses)| can(place, accesses));
    kept.map(|(&place, accesses)| (place, accesses.insts.clone()))
        .collect()
}

/// The values that a loop makes.
fn made_inside(func: &Function, data: &LoopData) -> EntityMap<Value, bool> {
    let mut inside = EntityMap::filled(func.values.len(), false);
    for &block in &data.blocks {
        let BlockData { params, insts, .. } = &func.blocks[block];
        let results = insts.iter().flat_map(|&i| &func.insts[i].results);
        for &value in params.iter().chain(results) {
            inside[value] = true;
        }
    }
    inside
}

/// True if every iteration that begins passes a block before it ends or leaves the loop.
fn is_in_all(func: &Function, dominators: &Dominators, data: &LoopData, block: Block) -> bool {
    let mut ends = data.latches.iter().copied();
    let mut exits = data.exits(func).map(|(from, _)| from);
    ends.all(|end| dominators.dominates(block, end))
        && exits.all(|exit| dominators.dominates(block, exit))
}

/// Keeps one place in a slot while a loop runs.
fn keep(func: &mut Function, data: &LoopData, before: Block, place: Place, accesses: &[Inst]) {
    let (ty, first, last) = match place.vector {
        true => (Ty::Vec, Opcode::Lv, Opcode::Sv),
        false => (Ty::Word, Opcode::Lw, Opcode::Sw),
    };
    let pos = func.insts[accesses[0]].pos;
    let slot = slot_for(func, ty);
    let address = |func: &mut Function, block: Block| match place.base {
        Base::Address(address) => (address, place.start),
        Base::Global(global) => {
            let symbol = InstKind::SymbolAddr(Symbol::Global(global), place.start);
            let inst = func.append(block, symbol, &[Ty::Word], pos);
            (func.insts[inst].results[0], 0)
        }
    };
    let (start, imm) = address(func, before);
    let truth = func.append_const(before, Bits::Pred(true), pos);
    let value = func.append_op(before, first, &[truth, start], imm, pos);
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
            let (start, imm) = address(func, behind);
            let truth = func.append_const(behind, Bits::Pred(true), pos);
            func.append_op(behind, last, &[truth, start, value], imm, pos);
            func.blocks[behind].end = Terminator::Jump(target);
            func.blocks[behind].end_pos = func.blocks[block].end_pos;
            if let Some(target) = func.blocks[block].end.targets_mut().nth(way) {
                *target = Target::to(behind);
            }
        }
    }
}
