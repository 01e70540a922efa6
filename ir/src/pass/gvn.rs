//! Common subexpressions, by value numbering over the dominator tree.

use super::alias::Objects;
use super::rename::Renames;
use crate::flow::{Cfg, Dominators};
use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::isa::{Effect, Opcode, Space};

/// Loads that are remembered at a time.
const MAX_LOADS: usize = 128;

/// Uses the first of equal pure instructions wherever it dominates the second, and the first of
/// equal loads, or the value stored there, with no store to the place in between: within a block,
/// and on from it into blocks that are entered from nowhere else. A store leaves other [`Objects`] as
/// they are; ports, calls and launches may write any memory.
pub(crate) fn gvn(func: &mut Function) -> bool {
    let cfg = Cfg::of(func);
    let dominators = Dominators::of(&cfg);
    let mut numbering = Numbering {
        known: FxHashMap::default(),
        renames: Renames::default(),
        loads: Loads::default(),
        objects: Objects::of(func),
    };
    // A walk over the tree; leaving a block forgets what it made known.
    let mut stack = vec![numbering.visit(func, func.entry())];
    while let Some(visit) = stack.last_mut() {
        match dominators.children(visit.block).get(visit.next) {
            Some(&child) => {
                visit.next += 1;
                numbering.loads = match cfg.preds[child].iter().all(|&p| p == visit.block) {
                    true => visit.loads.clone(),
                    false => Loads::default(),
                };
                stack.push(numbering.visit(func, child));
            }
            None => {
                for key in std::mem::take(&mut visit.made) {
                    numbering.known.remove(&key);
                }
                stack.pop();
            }
        }
    }
    let changed = !numbering.renames.is_empty();
    numbering.renames.apply(func);
    changed
}

/// A key that is equal for instructions which compute the same value.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Key {
    Const(Bits),
    Op(Opcode, Vec<Value>, i32),
    Symbol(Symbol, i32),
    Slot(Slot, i32),
}

struct Numbering {
    known: FxHashMap<Key, Value>,
    renames: Renames,
    loads: Loads,
    objects: Objects,
}

/// A block under way, and how many of those below it are done.
struct Visit {
    block: Block,
    next: usize,
    /// Keys that it added to the known ones.
    made: Vec<Key>,
    /// Values known to be in memory at its end.
    loads: Loads,
}

impl Numbering {
    /// Numbers the values of a block.
    fn visit(&mut self, func: &mut Function, block: Block) -> Visit {
        let mut made = Vec::new();
        for i in 0..func.blocks[block].insts.len() {
            let inst = &mut func.insts[func.blocks[block].insts[i]];
            inst.kind.for_each_use_mut(|v| *v = self.renames.find(*v));
            let result = inst.results.first().copied();
            let Some(key) = key_of(&inst.kind) else {
                let is_true = |guard| self.known.get(&Key::Const(Bits::Pred(true))) == Some(&guard);
                if let Some(same) = self.loads.see(&inst.kind, result, &self.objects, is_true)
                    && let Some(result) = result
                {
                    self.renames.replace(result, same);
                }
                continue;
            };
            let result = result.expect("pure instructions have a result");
            match self.known.get(&key) {
                Some(&same) => self.renames.replace(result, same),
                None => {
                    self.known.insert(key.clone(), result);
                    made.push(key);
                }
            }
        }
        Visit {
            block,
            next: 0,
            made,
            loads: std::mem::take(&mut self.loads),
        }
    }
}

/// Returns the key of a pure instruction; `None` if the instruction is not pure.
fn key_of(kind: &InstKind) -> Option<Key> {
    Some(match kind {
        InstKind::Const(bits) => Key::Const(*bits),
        InstKind::SymbolAddr(symbol, offset) => Key::Symbol(*symbol, *offset),
        InstKind::SlotAddr(slot, offset) => Key::Slot(*slot, *offset),
        InstKind::Op { op, args, imm } if op.is_pure() => {
            let mut args = args.clone();
            if op.info().commutative {
                args[..2].sort();
            }
            Key::Op(*op, args, *imm)
        }
        InstKind::Op { .. } | InstKind::Call { .. } | InstKind::Launch { .. } => return None,
    })
}

/// Values known to be in memory at a point.
#[derive(Clone, Default)]
struct Loads {
    known: Vec<Known>,
}

/// The load `op` of `base + imm` under `guard` would give `value`.
#[derive(Clone, Copy)]
struct Known {
    op: Opcode,
    guard: Value,
    base: Value,
    imm: i32,
    value: Value,
}

impl Loads {
    /// Notes what an instruction does to memory; the value that it would load, if that is known.
    fn see(
        &mut self,
        kind: &InstKind,
        result: Option<Value>,
        objects: &Objects,
        is_true: impl Fn(Value) -> bool,
    ) -> Option<Value> {
        let (op, args, imm) = match kind {
            InstKind::Op { op, args, imm } => (*op, args, *imm),
            _ => {
                self.known.clear();
                return None;
            }
        };
        match (op.info().effect, op.space()) {
            // Where a texture is read is no sum of two operands.
            (Effect::Load, _) if op.access_bytes().is_none() => {}
            (Effect::Load, _) => {
                let same =
                    |k: &&Known| (k.op, k.guard, k.base, k.imm) == (op, args[0], args[1], imm);
                if let Some(known) = self.known.iter().find(same) {
                    return Some(known.value);
                }
                self.note(op, args, imm, result?);
            }
            (Effect::Store, Some(space)) => {
                self.known
                    .retain(|k| !may_overlap(k, space, op, args[1], imm, objects));
                // The load of a whole word or vector gives back what was stored.
                if let Some(load) = load_back(op)
                    && is_true(args[0])
                {
                    self.note(load, args, imm, args[2]);
                }
            }
            _ => self.known.clear(),
        }
        None
    }

    fn note(&mut self, op: Opcode, args: &[Value], imm: i32, value: Value) {
        if self.known.len() >= MAX_LOADS {
            self.known.clear();
        }
        self.known.push(Known {
            op,
            guard: args[0],
            base: args[1],
            imm,
            value,
        });
    }
}

/// True if a store may overwrite a known value: same memory, not of another object, and not disjoint from the same base.
fn may_overlap(
    known: &Known,
    space: Space,
    op: Opcode,
    base: Value,
    imm: i32,
    objects: &Objects,
) -> bool {
    if known.op.space() != Some(space) {
        return false;
    }
    if base != known.base {
        let (stored, loaded) = (objects.object(base), objects.object(known.base));
        return stored.is_none() || loaded.is_none() || stored == loaded;
    }
    let bytes = |op: Opcode| op.access_bytes().map_or(0, i64::from);
    let (start, end) = (i64::from(imm), i64::from(imm) + bytes(op));
    let (known_start, known_end) = (i64::from(known.imm), i64::from(known.imm) + bytes(known.op));
    start < known_end && known_start < end
}

fn load_back(store: Opcode) -> Option<Opcode> {
    match store {
        Opcode::Sw => Some(Opcode::Lw),
        Opcode::Sv => Some(Opcode::Lv),
        Opcode::Gsw => Some(Opcode::Glw),
        Opcode::Gsv => Some(Opcode::Glv),
        _ => None,
    }
}
