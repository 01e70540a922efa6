//! Copies of blocks.

use crate::program::*;
use rustc_hash::FxHashMap;

/// Copies of the blocks of a loop, not in the layout, and of what they define.
pub(super) fn copy(func: &mut Function, old: &[Block]) -> (Vec<Block>, FxHashMap<Value, Value>) {
    let mut map = FxHashMap::default();
    let mut blocks = Vec::new();
    for &block in old {
        let mut copied = func.blocks[block].clone();
        for param in &mut copied.params {
            let fresh = func.values.push(func.values[*param]);
            map.insert(*param, fresh);
            *param = fresh;
        }
        for inst in &mut copied.insts {
            let mut made = func.insts[*inst].clone();
            for result in &mut made.results {
                let fresh = func.values.push(func.values[*result]);
                map.insert(*result, fresh);
                *result = fresh;
            }
            *inst = func.insts.push(made);
        }
        blocks.push(func.blocks.push(copied));
    }
    let rename = |v: &mut Value| *v = map.get(v).copied().unwrap_or(*v);
    for &block in &blocks {
        for &inst in &func.blocks[block].insts {
            func.insts[inst].kind.for_each_use_mut(rename);
        }
        let end = &mut func.blocks[block].end;
        end.for_each_use_mut(rename);
        for target in end.targets_mut() {
            if let Some(at) = old.iter().position(|&b| b == target.block) {
                target.block = blocks[at];
            }
        }
    }
    (blocks, map)
}

/// Gives the uses outside some blocks other values.
pub(super) fn rename_outside(func: &mut Function, inside: &[Block], map: &FxHashMap<Value, Value>) {
    let rename = |v: &mut Value| *v = map.get(v).copied().unwrap_or(*v);
    for &block in &func.layout {
        if inside.contains(&block) {
            continue;
        }
        for &inst in &func.blocks[block].insts {
            func.insts[inst].kind.for_each_use_mut(rename);
        }
        func.blocks[block].end.for_each_use_mut(rename);
    }
}
