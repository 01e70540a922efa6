//! A place to compute something once before a loop.

use crate::flow::{Cfg, Flow, LoopData};
use crate::program::*;

/// The control flow of a function each of whose loops has a preheader: a block that jumps to the
/// header and nowhere else, and that all other ways into the loop pass.
pub(super) fn with_preheaders(func: &mut Function) -> Flow {
    let flow = Flow::of(func);
    let cfg = &flow.cfg;
    let mut added = Vec::new();
    for data in flow.loops.loops.values() {
        if find(func, cfg, data).is_none() {
            added.push((data.header, add(func, cfg, data)));
        }
    }
    if added.is_empty() {
        return flow;
    }
    // Each new block stands before its header.
    let mut place =
        srp_archdesc::entity::EntityMap::<Block, Option<Block>>::filled(func.blocks.len(), None);
    for (header, before) in added {
        place[header] = Some(before);
    }
    let listed = cfg.preds.len();
    let old = std::mem::take(&mut func.layout);
    let old = old
        .into_iter()
        .filter(|&b| srp_archdesc::entity::Entity::index(b) < listed);
    func.layout = old.flat_map(|b| place[b].into_iter().chain([b])).collect();
    Flow::of(func)
}

/// The preheader of a loop, where there is one.
pub(super) fn find(func: &Function, cfg: &Cfg, data: &LoopData) -> Option<Block> {
    let mut outside = entries(cfg, data);
    let only = outside.next()?;
    let jumps_only = matches!(func.blocks[only].end, Terminator::Jump(_));
    (outside.next().is_none() && jumps_only).then_some(only)
}

/// Where jumps from outside the loop to its header come from.
fn entries<'a>(cfg: &'a Cfg, data: &'a LoopData) -> impl Iterator<Item = Block> + 'a {
    let preds = cfg.preds[data.header].iter().copied();
    preds.filter(|pred| !data.latches.contains(pred))
}

fn add(func: &mut Function, cfg: &Cfg, data: &LoopData) -> Block {
    let header = data.header;
    let before = func.add_block();
    let tys: Vec<_> = func.blocks[header]
        .params
        .iter()
        .map(|&p| func.values[p])
        .collect();
    let args = tys
        .into_iter()
        .map(|ty| func.add_param(before, ty))
        .collect();
    func.blocks[before].end = Terminator::Jump(Target {
        block: header,
        args,
    });
    func.blocks[before].end_pos = func.blocks[header].end_pos;
    for pred in entries(cfg, data).collect::<Vec<_>>() {
        func.blocks[pred].end.retarget(header, before);
    }
    before
}
