//! Loop-invariant code motion.

use super::alias::{Objects, Scopes};
use super::preheader::{find, with_preheaders};
use crate::flow::{Flow, Loop, LoopData};
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Class, Effect, Space};

/// Moves instructions with the same value in every iteration in front of the loop.
///
/// Pure instructions always; divisions, which may trap, and loads only from loops without ports, calls
/// and launches and from blocks that every iteration passes before it leaves; loads, besides, only if
/// the loop does not store to their memory, or only to other objects. A kernel's load from a place in a
/// global cannot trap, and need not be in such a block.
pub(crate) fn licm(func: &mut Function, globals: &EntityMap<Global, GlobalData>) -> bool {
    let flow = with_preheaders(func);
    let mut home = EntityMap::<Value, Option<Block>>::filled(func.values.len(), None);
    for &block in &flow.cfg.order {
        let data = &func.blocks[block];
        let results = data.insts.iter().flat_map(|&i| &func.insts[i].results);
        for &value in data.params.iter().chain(results) {
            home[value] = Some(block);
        }
    }
    let mut scopes = Scopes::default();
    let safe = safe_addresses(func, globals);
    let mut changed = false;
    // Inner loops first: what leaves one may leave the next.
    for id in flow.loops.loops.keys().rev() {
        let objects = scopes.of_block(func, flow.loops.loops[id].header);
        changed |= hoist(func, &flow, id, (objects, &safe), &mut home);
    }
    changed
}

/// Loads that are made before a kernel though not every iteration makes them: each takes a register.
const MAX_SPECULATED: u32 = 32;

/// For an address in a global, how far from its beginning, and how long that is.
type Safe = EntityMap<Value, Option<(i64, i64)>>;

/// The addresses of places in globals.
fn safe_addresses(func: &Function, globals: &EntityMap<Global, GlobalData>) -> Safe {
    let mut safe = EntityMap::filled(func.values.len(), None);
    for &inst in func.layout.iter().flat_map(|&b| &func.blocks[b].insts) {
        if let InstKind::SymbolAddr(Symbol::Global(global), offset) = func.insts[inst].kind {
            let data = &globals[global];
            // Up to its alignment, where it lies does not matter.
            if data.align >= 4 {
                let place = (i64::from(offset), i64::from(data.size));
                safe[func.insts[inst].results[0]] = Some(place);
            }
        }
    }
    safe
}

/// True if a load is aligned and inside an object that exists.
fn is_safe(kind: &InstKind, safe: &Safe) -> bool {
    let InstKind::Op { op, args, imm } = kind else {
        return false;
    };
    let (Effect::Load, Some(bytes)) = (op.info().effect, op.access_bytes()) else {
        return false;
    };
    safe[args[1]].is_some_and(|(offset, size)| {
        let (start, bytes) = (offset + i64::from(*imm), i64::from(bytes));
        bytes <= 4 && start >= 0 && start % bytes == 0 && start + bytes <= size
    })
}

/// Effects of a loop that forbid moving instructions out of it.
struct Effects<'a> {
    objects: &'a Objects,
    /// The addresses in SRAM that it stores to.
    stored: Vec<Value>,
    stores_cached: bool,
    opaque: bool,
}

fn effects<'a>(func: &Function, data: &LoopData, objects: &'a Objects) -> Effects<'a> {
    let mut effects = Effects {
        objects,
        stored: Vec::new(),
        stores_cached: false,
        opaque: false,
    };
    let insts = data.blocks.iter().flat_map(|&b| &func.blocks[b].insts);
    for &inst in insts {
        match &func.insts[inst].kind {
            InstKind::Call { .. } | InstKind::Launch { .. } => effects.opaque = true,
            InstKind::Op { op, args, .. } => match (op.info().effect, op.space()) {
                (Effect::Io, _) => effects.opaque = true,
                (Effect::Store, Some(Space::Sram)) => {
                    effects.stored.push(args[1]);
                }
                (Effect::Store, _) => effects.stores_cached = true,
                (Effect::Pure | Effect::Load | Effect::Prefetch, _) => {}
            },
            InstKind::Const(_) | InstKind::SymbolAddr(..) | InstKind::SlotAddr(..) => {}
        }
    }
    effects
}

/// Moves the invariant instructions of one loop to its preheader.
fn hoist(
    func: &mut Function,
    flow: &Flow,
    id: Loop,
    (objects, safe): (&Objects, &Safe),
    home: &mut EntityMap<Value, Option<Block>>,
) -> bool {
    let Flow {
        cfg,
        dominators,
        loops,
    } = flow;
    let data = &loops.loops[id];
    let before = find(func, cfg, data).expect("every loop was given a preheader");
    let effects = effects(func, data, objects);
    let exits: Vec<Block> = data.exits(func).map(|(from, _)| from).collect();
    let mut changed = false;
    // Control code makes a load under a condition only where it is met.
    let kernel = func.blocks[data.header].kernel.is_some();
    let mut speculated = 0;
    for &block in &data.blocks {
        let passed = block == data.header
            || !exits.is_empty() && exits.iter().all(|&exit| dominators.dominates(block, exit));
        let (moved, kept) = std::mem::take(&mut func.blocks[block].insts)
            .into_iter()
            .partition(|&inst| {
                let inst = &func.insts[inst];
                let speculates = !passed && kernel && speculated < MAX_SPECULATED;
                let cannot_trap = speculates && is_safe(&inst.kind, safe);
                let mut invariant = may_move(&inst.kind, &effects, passed || cannot_trap);
                inst.kind.for_each_use(|value| {
                    invariant &= home[value].is_some_and(|home| !data.contains(home));
                });
                if invariant {
                    speculated += u32::from(cannot_trap);
                    inst.results
                        .iter()
                        .for_each(|&result| home[result] = Some(before));
                }
                invariant
            });
        let moved: Vec<Inst> = moved;
        changed |= !moved.is_empty();
        func.blocks[block].insts = kept;
        func.blocks[before].insts.extend(moved);
    }
    changed
}

fn may_move(kind: &InstKind, effects: &Effects<'_>, passed: bool) -> bool {
    let InstKind::Op { op, args, .. } = kind else {
        return kind.is_pure();
    };
    let trapping = passed && !effects.opaque;
    match (op.info().effect, op.space()) {
        (Effect::Pure, _) => op.class() != Class::Idiv || trapping,
        (Effect::Load, Some(Space::Sram)) => {
            let mut stored = effects.stored.iter();
            trapping && stored.all(|&to| effects.objects.are_apart(args[1], to))
        }
        (Effect::Load, _) => trapping && !effects.stores_cached,
        (Effect::Store | Effect::Prefetch | Effect::Io, _) => false,
    }
}
