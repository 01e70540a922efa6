//! Loops whose iterations end in several places, made loops that have one way back.
//!
//! An iteration that ends in an `if`, with no statement and no test behind, goes back from both of its ends.

use crate::flow::{Flow, LoopData};
use crate::program::*;

/// Gives each marked loop without loops inside it one way back to its header.
pub(super) fn join(func: &mut Function) {
    let flow = Flow::of(func);
    for (id, data) in flow.loops.loops.iter() {
        let is_marked = func.blocks[data.header].kernel.is_some();
        if is_marked && flow.loops.is_innermost(id) && ways_back(func, data) > 1 {
            join_one(func, data);
        }
    }
}

fn ways_back(func: &Function, data: &LoopData) -> usize {
    let targets = (data.latches.iter()).flat_map(|&latch| func.blocks[latch].end.targets());
    targets.filter(|target| target.block == data.header).count()
}

fn join_one(func: &mut Function, data: &LoopData) {
    let header = data.header;
    let tys: Vec<_> = (func.blocks[header].params.iter())
        .map(|&param| func.values[param])
        .collect();
    let mut after = data.latches.last().copied().unwrap_or(header);
    let mut put = |func: &mut Function, block: Block| {
        func.layout.retain(|&b| b != block);
        let place = func.layout.iter().position(|&b| b == after);
        let place = place.expect("a latch is in the layout");
        func.layout.insert(place + 1, block);
        after = block;
    };
    let pos = func.blocks[data.latches[0]].end_pos;
    let joint = func.add_block();
    let args = tys.iter().map(|&ty| func.add_param(joint, ty)).collect();
    func.blocks[joint].end = Terminator::Jump(Target {
        block: header,
        args,
    });
    func.blocks[joint].end_pos = pos;
    for &latch in &data.latches {
        let ends: Vec<usize> = (func.blocks[latch].end.targets().enumerate())
            .filter(|(_, target)| target.block == header)
            .map(|(way, _)| way)
            .collect();
        for (count, way) in ends.into_iter().enumerate() {
            // A branch that goes back on both ways brings different values: each has a block of its own.
            let own = (count > 0).then(|| func.add_block());
            let target = func.blocks[latch].end.targets_mut().nth(way);
            let target = target.expect("it was there");
            match own {
                None => target.block = joint,
                Some(own) => {
                    let old = std::mem::replace(target, Target::to(own));
                    let end = Target {
                        block: joint,
                        ..old
                    };
                    func.blocks[own].end = Terminator::Jump(end);
                    func.blocks[own].end_pos = pos;
                    put(func, own);
                }
            }
        }
    }
    put(func, joint);
}
