//! Copy propagation: moves, and parameters of blocks that always get the same value.

use super::params::remove_params;
use super::rename::Renames;
use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Opcode;

/// Replaces each copy by its source: each move that makes no `restrict` pointer, and each parameter
/// for which all jumps to its block pass the same value. Constants are compared by their bits.
pub(crate) fn copyprop(func: &mut Function) -> bool {
    let mut renames = Renames::default();
    for &block in &func.layout {
        for &inst in &func.blocks[block].insts {
            let data = &func.insts[inst];
            if let InstKind::Op {
                op: Opcode::Mov | Opcode::Pmov | Opcode::Vmov,
                args,
                imm: 0,
            } = &data.kind
            {
                let (copy, source) = (data.results[0], renames.find(args[0]));
                // Code that is never reached may move values in a circle.
                if copy != source {
                    renames.replace(copy, source);
                }
            }
        }
    }
    let mut constants = constants(func);
    let mut drop = EntityMap::<Block, Vec<bool>>::filled(func.blocks.len(), Vec::new());
    for &block in &func.layout {
        drop[block] = vec![false; func.blocks[block].params.len()];
    }
    while merge_params(func, &mut renames, &mut constants, &mut drop) {}
    let changed = !renames.is_empty();
    renames.apply(func);
    remove_params(func, &drop);
    changed
}

fn constants(func: &Function) -> FxHashMap<Value, Bits> {
    let insts = func.layout.iter().flat_map(|&b| &func.blocks[b].insts);
    insts
        .filter_map(|&inst| match func.insts[inst].kind {
            InstKind::Const(bits) => Some((func.insts[inst].results[0], bits)),
            _ => None,
        })
        .collect()
}

/// The arguments of all jumps for one parameter.
#[derive(Clone, Copy)]
enum Brought {
    Nothing,
    One(Value),
    /// Different values, all of them this constant.
    Equal(Bits),
    Many,
}

fn merge_params(
    func: &mut Function,
    renames: &mut Renames,
    constants: &mut FxHashMap<Value, Bits>,
    drop: &mut EntityMap<Block, Vec<bool>>,
) -> bool {
    let mut brought: EntityMap<Block, Vec<Brought>> = func
        .blocks
        .values()
        .map(|b| vec![Brought::Nothing; b.params.len()])
        .collect();
    for &block in &func.layout {
        for target in func.blocks[block].end.targets() {
            let params = &func.blocks[target.block].params;
            for (place, (&arg, &param)) in target.args.iter().zip(params).enumerate() {
                let arg = renames.find(arg);
                if arg == param {
                    continue;
                }
                let constant = constants.get(&arg).copied();
                let so_far = &mut brought[target.block][place];
                *so_far = match *so_far {
                    Brought::Nothing => Brought::One(arg),
                    Brought::One(one) if one == arg => Brought::One(one),
                    Brought::One(one) => match (constants.get(&one), constant) {
                        (Some(&a), Some(b)) if a == b => Brought::Equal(a),
                        _ => Brought::Many,
                    },
                    Brought::Equal(bits) if constant == Some(bits) => Brought::Equal(bits),
                    Brought::Equal(_) | Brought::Many => Brought::Many,
                };
            }
        }
    }
    let mut changed = false;
    for i in 1..func.layout.len() {
        let block = func.layout[i];
        for place in 0..drop[block].len() {
            let param = func.blocks[block].params[place];
            let value = match brought[block][place] {
                _ if drop[block][place] => continue,
                Brought::One(value) => value,
                Brought::Equal(bits) => {
                    let inst = func.make_inst(InstKind::Const(bits), &[bits.ty()], Pos::nowhere());
                    func.blocks[block].insts.insert(0, inst);
                    let value = func.insts[inst].results[0];
                    constants.insert(value, bits);
                    value
                }
                Brought::Nothing | Brought::Many => continue,
            };
            // An earlier parameter of this round may have become this one.
            let value = renames.find(value);
            if value == param {
                continue;
            }
            renames.replace(param, value);
            drop[block][place] = true;
            changed = true;
        }
    }
    changed
}
