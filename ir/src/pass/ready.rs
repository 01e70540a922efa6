//! Estimates of when the values of a block stand, for passes that shorten its longest chain.

use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::isa::Class;

/// The cycle in which each value of `block` stands if nothing waits for a slot; what comes from other
/// blocks stands at the start.
pub(super) fn ready(func: &Function, block: Block) -> FxHashMap<Value, u32> {
    let mut ready = FxHashMap::default();
    for &inst in &func.blocks[block].insts {
        let data = &func.insts[inst];
        let mut start = 0;
        let at = |v: Value| ready.get(&v).copied().unwrap_or(0);
        data.kind.for_each_use(|v| start = start.max(at(v)));
        let stands = start + cycles(&data.kind);
        ready.extend(data.results.iter().map(|&v| (v, stands)));
    }
    ready
}

/// The latency of an operation on a common machine.
fn cycles(kind: &InstKind) -> u32 {
    let InstKind::Op { op, .. } = kind else {
        return 0;
    };
    match op.class() {
        Class::Imul | Class::Cvt | Class::Vmul => 2,
        Class::Load | Class::Cload | Class::Fadd | Class::Fmul | Class::Vfadd | Class::Vfmul => 3,
        Class::Pair | Class::Vpair => 3,
        Class::Fma | Class::Vfma => 4,
        Class::Vdot => 6,
        Class::Idiv | Class::Fdiv | Class::Sfu | Class::Tex => 12,
        _ => 1,
    }
}
