//! Stack slots to values.
//!
//! A slot whose address is only loaded from and stored to is cut into *cells*, each accessed as a
//! whole: words, vectors (whose words may be accessed as lanes), bytes or halves. Every cell becomes
//! a value; slots with a computed index stay in memory.

use super::cfg::remove_unreached;
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Ty;
use std::collections::BTreeMap;

mod ssa;

/// Makes the cells of stack slots into values. A cell that is read before it is written is zero.
pub(crate) fn mem2reg(func: &mut Function) -> bool {
    if func.slots.is_empty() {
        return false;
    }
    remove_unreached(func);
    let (accesses, cells) = cells(accesses(func));
    if cells.is_empty() {
        return false;
    }
    ssa::promote(func, &accesses, &cells);
    true
}

srp_archdesc::entity! {
    /// A part of a slot that is accessed as a whole.
    Cell = "cell";
}

/// One access of a cell.
#[derive(Clone, Copy, Debug)]
struct Access {
    cell: Cell,
    /// The lane of a vector cell that a word access goes to.
    lane: Option<u32>,
}

/// The bytes of a slot that one load or store accesses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Range {
    slot: Slot,
    start: u32,
    bytes: u32,
}

/// Returns the loads and stores of slots whose address does not escape, with their ranges.
fn accesses(func: &Function) -> BTreeMap<Inst, Range> {
    let mut addresses = EntityMap::<Value, Option<(Slot, i32)>>::filled(func.values.len(), None);
    for inst in listed(func) {
        if let InstKind::SlotAddr(slot, offset) = func.insts[inst].kind {
            addresses[func.insts[inst].results[0]] = Some((slot, offset));
        }
    }
    let mut escaped = EntityMap::<Slot, bool>::filled(func.slots.len(), false);
    let mut escape = |value: Value| {
        if let Some((slot, _)) = addresses[value] {
            escaped[slot] = true;
        }
    };
    let mut accesses = BTreeMap::new();
    for inst in listed(func) {
        let kind = &func.insts[inst].kind;
        match range(func, &addresses, kind) {
            Some(range) => {
                accesses.insert(inst, range);
                // The address itself may be what is stored.
                kind.args().iter().skip(2).copied().for_each(&mut escape);
            }
            None => kind.for_each_use(&mut escape),
        }
    }
    for &block in &func.layout {
        func.blocks[block].end.for_each_use(&mut escape);
    }
    accesses.retain(|_, range| !escaped[range.slot]);
    accesses
}

fn listed(func: &Function) -> impl Iterator<Item = Inst> + '_ {
    let blocks = func.layout.iter();
    blocks.flat_map(|&block| func.blocks[block].insts.iter().copied())
}

/// Returns the range that a load or store of a slot accesses, if it is aligned and inside the slot.
fn range(
    func: &Function,
    addresses: &EntityMap<Value, Option<(Slot, i32)>>,
    kind: &InstKind,
) -> Option<Range> {
    let InstKind::Op { op, args, imm } = kind else {
        return None;
    };
    let bytes = op.access_bytes()?;
    let (slot, offset) = addresses[args[1]]?;
    let start = u32::try_from(i64::from(offset) + i64::from(*imm)).ok()?;
    let SlotData { size, align, .. } = func.slots[slot];
    let inside = u64::from(start) + u64::from(bytes) <= u64::from(size);
    let aligned = bytes <= align && start.is_multiple_of(bytes);
    (inside && aligned).then_some(Range { slot, start, bytes })
}

/// The cells, and which of them each access goes to. Ranges are aligned to their size, so that of
/// two that overlap one contains the other.
fn cells(ranges: BTreeMap<Inst, Range>) -> (BTreeMap<Inst, Access>, EntityMap<Cell, Ty>) {
    let mut sorted: Vec<Range> = ranges.values().copied().collect();
    // The container first.
    sorted.sort_by_key(|r| (r.slot, r.start, std::cmp::Reverse(r.bytes)));
    sorted.dedup();
    let mut tys = EntityMap::new();
    let mut cell_of = BTreeMap::new();
    let mut rest = sorted.as_slice();
    while let Some(&outer) = rest.first() {
        let inside = |r: &Range| r.slot == outer.slot && r.start < outer.start + outer.bytes;
        let count = rest.iter().take_while(|r| inside(r)).count();
        let (parts, more) = rest.split_at(count);
        rest = more;
        let whole = parts.iter().all(|r| r == &outer);
        let lanes = outer.bytes == 16 && parts.iter().all(|r| r.bytes >= 4);
        if whole || lanes {
            let vector = outer.bytes == 16;
            let cell = tys.push(if vector { Ty::Vec } else { Ty::Word });
            for part in parts {
                let lane = (part.bytes != outer.bytes).then(|| (part.start - outer.start) / 4);
                cell_of.insert(*part, Access { cell, lane });
            }
        }
    }
    let access = |(inst, range)| Some((inst, *cell_of.get(&range)?));
    (ranges.into_iter().filter_map(access).collect(), tys)
}
