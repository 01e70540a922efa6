//! Renumbering.

use crate::program::*;
use srp_archdesc::entity::{Entity, EntityMap};

/// [`compact`] of every function.
pub fn compact_program(program: &mut Program) {
    program.funcs.values_mut().for_each(compact);
}

/// Drops blocks that are not in the layout, instructions that are in no block and slots whose
/// address is never taken, and numbers what is left in the order of the layout: parameters of the
/// entry first, then block by block.
///
/// A [verified](crate::verify()) function is one afterwards.
pub(crate) fn compact(func: &mut Function) {
    let values = number_values(func);
    let slots = keep_slots(func);
    let mut blocks = EntityMap::<Block, Option<Block>>::filled(func.blocks.len(), None);
    for (i, &block) in func.layout.iter().enumerate() {
        blocks[block] = Some(Block::new(i));
    }
    let old = std::mem::take(&mut func.blocks);
    let mut old: Vec<Option<BlockData>> = old.into_values().map(Some).collect();
    let mut insts: Vec<Option<InstData>> = std::mem::take(&mut func.insts)
        .into_values()
        .map(Some)
        .collect();
    let rename = |v: &mut Value| *v = values[*v].expect("uses of a verified function are defined");
    for block in std::mem::take(&mut func.layout) {
        let mut data = old[block.index()]
            .take()
            .expect("a block is in the layout once");
        data.params.iter_mut().for_each(rename);
        for inst in &mut data.insts {
            let mut inst_data = insts[inst.index()]
                .take()
                .expect("an instruction is listed once");
            inst_data.results.iter_mut().for_each(rename);
            inst_data.kind.for_each_use_mut(rename);
            if let InstKind::SlotAddr(slot, _) = &mut inst_data.kind {
                *slot = slots[*slot].expect("slots in use are kept");
            }
            *inst = func.insts.push(inst_data);
        }
        data.end.for_each_use_mut(rename);
        for target in data.end.targets_mut() {
            target.block = blocks[target.block].expect("targets are in the layout");
        }
        let block = func.blocks.push(data);
        func.layout.push(block);
    }
}

/// Numbers the values in the order of their definitions and keeps only their types.
fn number_values(func: &mut Function) -> EntityMap<Value, Option<Value>> {
    let mut numbers = EntityMap::filled(func.values.len(), None);
    let mut tys = EntityMap::new();
    for &block in &func.layout {
        let data = &func.blocks[block];
        let results = data.insts.iter().flat_map(|&i| &func.insts[i].results);
        for &value in data.params.iter().chain(results) {
            numbers[value] = Some(tys.push(func.values[value]));
        }
    }
    func.values = tys;
    numbers
}

/// Drops the slots that no instruction of the layout names.
fn keep_slots(func: &mut Function) -> EntityMap<Slot, Option<Slot>> {
    let mut used = EntityMap::<Slot, bool>::filled(func.slots.len(), false);
    for &block in &func.layout {
        for &inst in &func.blocks[block].insts {
            if let InstKind::SlotAddr(slot, _) = func.insts[inst].kind {
                used[slot] = true;
            }
        }
    }
    let mut kept = EntityMap::new();
    let old = std::mem::take(&mut func.slots).into_values();
    let numbers = old.zip(used.values());
    let numbers = numbers
        .map(|(data, &used)| used.then(|| kept.push(data)))
        .collect();
    func.slots = kept;
    numbers
}
