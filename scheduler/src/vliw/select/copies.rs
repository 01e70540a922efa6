//! Parallel copies: all sources are read before any destination is written.

use crate::vliw::lir::{Arg, Code, Split, Vreg};

/// The moves of a parallel copy one after another. Cycles go through a fresh register; constants
/// come last, when no destination is a source any more.
pub(super) fn sequence(code: &mut Code, moves: Vec<(Vreg, Arg)>) -> Vec<(Vreg, Arg)> {
    let (mut pending, constants): (Vec<_>, Vec<_>) = moves
        .into_iter()
        .filter(|&(dst, src)| src != Arg::Reg(dst))
        .partition(|(_, src)| matches!(src, Arg::Reg(_)));
    let mut done = Vec::new();
    while !pending.is_empty() {
        let is_free = |&(dst, _): &(Vreg, Arg)| pending.iter().all(|&(_, s)| s != Arg::Reg(dst));
        if let Some(i) = pending.iter().position(is_free) {
            done.push(pending.remove(i));
            continue;
        }
        // Every destination is still read: they form cycles. Save one to free it.
        let (dst, _) = pending[0];
        let saved = code.fresh(code.regs[dst].ty, Split::Whole);
        done.push((saved, Arg::Reg(dst)));
        for (_, src) in &mut pending {
            if *src == Arg::Reg(dst) {
                *src = Arg::Reg(saved);
            }
        }
    }
    done.extend(constants);
    done
}
