//! Dead code.

use super::params::remove_params;
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Effect;

/// Removes instructions and block parameters that nothing needs. Stores, ports, calls, launches,
/// conditions and results are needed, and the values they are computed from. A load that nothing
/// needs goes too, and with it any trap of the load.
pub(crate) fn dce(func: &mut Function) -> bool {
    let defs = definitions(func);
    let mut needed = Needed {
        values: EntityMap::filled(func.values.len(), false),
        work: Vec::new(),
    };
    let mut kept = EntityMap::<Inst, bool>::filled(func.insts.len(), false);
    for &block in &func.layout {
        let data = &func.blocks[block];
        for &inst in &data.insts {
            if has_effect(&func.insts[inst].kind) {
                kept[inst] = true;
                func.insts[inst].kind.for_each_use(|v| needed.add(v));
            }
        }
        match &data.end {
            Terminator::Branch { cond, .. } => needed.add(*cond),
            Terminator::Return(values) => values.iter().for_each(|&v| needed.add(v)),
            Terminator::Jump(_) | Terminator::Unreachable => {}
        }
    }
    let incoming = incoming(func);
    while let Some(value) = needed.work.pop() {
        match defs[value] {
            Some(Def::Inst(inst)) => {
                kept[inst] = true;
                func.insts[inst].kind.for_each_use(|v| needed.add(v));
            }
            Some(Def::Param(block, place)) => {
                for target in targets(func, &incoming[block], block) {
                    needed.add(target.args[place]);
                }
            }
            None => {}
        }
    }
    sweep(func, &needed.values, &kept)
}

struct Needed {
    values: EntityMap<Value, bool>,
    work: Vec<Value>,
}

impl Needed {
    fn add(&mut self, value: Value) {
        if !std::mem::replace(&mut self.values[value], true) {
            self.work.push(value);
        }
    }
}

#[derive(Clone, Copy)]
enum Def {
    Inst(Inst),
    Param(Block, usize),
}

fn definitions(func: &Function) -> EntityMap<Value, Option<Def>> {
    let mut defs = EntityMap::filled(func.values.len(), None);
    for &block in &func.layout {
        for (place, &param) in func.blocks[block].params.iter().enumerate() {
            defs[param] = Some(Def::Param(block, place));
        }
        for &inst in &func.blocks[block].insts {
            for &result in &func.insts[inst].results {
                defs[result] = Some(Def::Inst(inst));
            }
        }
    }
    defs
}

fn has_effect(kind: &InstKind) -> bool {
    match kind {
        InstKind::Call { .. } | InstKind::Launch { .. } => true,
        InstKind::Op { op, .. } => {
            let effect = op.info().effect;
            matches!(effect, Effect::Store | Effect::Prefetch | Effect::Io)
        }
        InstKind::Const(_) | InstKind::SymbolAddr(..) | InstKind::SlotAddr(..) => false,
    }
}

/// Where jumps to each block come from.
fn incoming(func: &Function) -> EntityMap<Block, Vec<Block>> {
    let mut incoming = EntityMap::<Block, Vec<Block>>::filled(func.blocks.len(), Vec::new());
    for &block in &func.layout {
        for target in func.blocks[block].end.targets() {
            if incoming[target.block].last() != Some(&block) {
                incoming[target.block].push(block);
            }
        }
    }
    incoming
}

fn targets<'a>(
    func: &'a Function,
    from: &'a [Block],
    to: Block,
) -> impl Iterator<Item = &'a Target> {
    let ends = from.iter().map(|&b| &func.blocks[b].end);
    ends.flat_map(Terminator::targets)
        .filter(move |t| t.block == to)
}

fn sweep(
    func: &mut Function,
    needed: &EntityMap<Value, bool>,
    kept: &EntityMap<Inst, bool>,
) -> bool {
    let mut changed = false;
    let mut drop = EntityMap::<Block, Vec<bool>>::filled(func.blocks.len(), Vec::new());
    let entry = func.entry();
    for &block in &func.layout {
        let data = &mut func.blocks[block];
        let before = data.insts.len();
        data.insts.retain(|&inst| kept[inst]);
        changed |= data.insts.len() != before;
        if block != entry {
            drop[block] = data.params.iter().map(|&p| !needed[p]).collect();
            changed |= drop[block].contains(&true);
        }
    }
    remove_params(func, &drop);
    changed
}
