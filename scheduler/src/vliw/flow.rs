//! The order of the blocks: empty ones go, chains merge, and the rest is laid out so that the
//! edges taken most often need no jump (bottom-up positioning after Pettis and Hansen). A loop
//! whose header tests gets its header below its body that way: one branch an iteration.

use super::lir::{Code, End, Label};
use srp_archdesc::entity::{Entity, EntityMap};
use std::cmp::Reverse;

/// Simplifies the flow of `code` and chooses the order of its blocks.
pub(super) fn straighten(code: &mut Code) {
    skip_empty(code);
    merge_chains(code);
    code.order = arrange(code);
}

/// Sends every jump to an empty block on to where that block jumps.
fn skip_empty(code: &mut Code) {
    let onward = |code: &Code, mut label: Label| {
        // A loop of empty blocks stays as it is.
        for _ in 0..code.blocks.len() {
            match &code.blocks[label] {
                block if !block.insts.is_empty() => break,
                block => match block.end {
                    End::Jump(to) => label = to,
                    _ => break,
                },
            }
        }
        label
    };
    for label in code.order.clone() {
        let mut end = code.blocks[label].end.clone();
        end.retarget(|to| onward(code, to));
        if let End::Branch { then, other, .. } = end
            && then == other
        {
            end = End::Jump(then);
        }
        code.blocks[label].end = end;
    }
    keep_reachable(code);
}

fn keep_reachable(code: &mut Code) {
    let mut seen = EntityMap::filled(code.blocks.len(), false);
    let mut work = vec![code.order[0]];
    while let Some(label) = work.pop() {
        if !std::mem::replace(&mut seen[label], true) {
            work.extend(code.blocks[label].end.targets());
        }
    }
    code.order.retain(|&label| seen[label]);
}

/// Appends to each block the one it jumps to, if nothing else goes there.
fn merge_chains(code: &mut Code) {
    let preds = code.predecessors();
    let mut gone = EntityMap::filled(code.blocks.len(), false);
    for label in code.order.clone() {
        while let End::Jump(to) = code.blocks[label].end
            && !gone[label]
            && to != label
            && to != code.order[0]
            && preds[to].len() == 1
        {
            let end = std::mem::replace(&mut code.blocks[to].end, End::Unreachable);
            let insts = std::mem::take(&mut code.blocks[to].insts);
            let end_pos = code.blocks[to].end_pos;
            let block = &mut code.blocks[label];
            block.insts.extend(insts);
            block.end = end;
            block.end_pos = end_pos;
            gone[to] = true;
        }
    }
    code.order.retain(|&label| !gone[label]);
}

fn arrange(code: &Code) -> Vec<Label> {
    let position: EntityMap<Label, usize> = {
        let mut position = EntityMap::filled(code.blocks.len(), usize::MAX);
        for (i, &label) in code.order.iter().enumerate() {
            position[label] = i;
        }
        position
    };
    let mut edges = Vec::new();
    for &from in &code.order {
        let end = &code.blocks[from].end;
        let is_jump = matches!(end, End::Jump(_));
        for to in end.targets() {
            let depth = code.blocks[from].depth.min(code.blocks[to].depth);
            let rank = (Reverse(depth), !is_jump, position[to], position[from]);
            edges.push((rank, from, to));
        }
    }
    edges.sort_unstable();
    // Each chain is known by its first block; `tail` and `head` say which chain a block ends or begins.
    let mut next: EntityMap<Label, Option<Label>> = EntityMap::filled(code.blocks.len(), None);
    let mut head: EntityMap<Label, Label> = code.blocks.keys().collect();
    let mut tail = head.clone();
    let mut has_before = EntityMap::filled(code.blocks.len(), false);
    has_before[code.order[0]] = true;
    for (_, from, to) in edges {
        if next[from].is_some() || has_before[to] || head[from] == to {
            continue;
        }
        next[from] = Some(to);
        has_before[to] = true;
        let (first, last) = (head[from], tail[to]);
        head[last] = first;
        tail[first] = last;
    }
    has_before[code.order[0]] = false;
    let mut order = Vec::with_capacity(code.order.len());
    for &label in &code.order {
        if !has_before[label] {
            let mut at = Some(label);
            while let Some(label) = at {
                order.push(label);
                at = next[label];
            }
        }
    }
    debug_assert_eq!(order.len(), code.order.len());
    debug_assert!(order.iter().all(|l| l.index() < code.blocks.len()));
    order
}
