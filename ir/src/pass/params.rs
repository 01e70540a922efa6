//! Removing parameters of blocks together with the arguments that jumps pass for them.

use crate::program::{Block, Function};
use srp_archdesc::entity::EntityMap;

/// Removes the parameters that `drop` names, by block and place.
pub(super) fn remove_params(func: &mut Function, drop: &EntityMap<Block, Vec<bool>>) {
    let kept = |drops: &[bool], i: usize| !drops.get(i).copied().unwrap_or(false);
    for &block in &func.layout {
        let data = &mut func.blocks[block];
        let mut place = 0..;
        data.params
            .retain(|_| place.next().is_some_and(|i| kept(&drop[block], i)));
        for target in data.end.targets_mut() {
            let mut place = 0..;
            let drops = &drop[target.block];
            target
                .args
                .retain(|_| place.next().is_some_and(|i| kept(drops, i)));
        }
    }
}
