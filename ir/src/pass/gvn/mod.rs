//! Common subexpressions, by value numbering over the dominator tree.

mod loads;

use super::alias::{Objects, Scopes};
use super::guards::Guards;
use super::rename::Renames;
use crate::flow::{Cfg, Dominators};
use crate::program::*;
use loads::Loads;
pub(super) use loads::returns;
use rustc_hash::FxHashMap;
use srp_archdesc::isa::{Effect, Opcode};

/// Uses the first of equal pure instructions wherever it dominates the second, and the first of
/// equal loads, or the value stored there, with no store to the place in between: within a block,
/// and on from it into blocks that are entered from nowhere else. After a store under a predicate the value is a
/// selection. A store leaves other [objects](super::alias::Objects) as they are; ports, calls and launches may write any memory.
pub(crate) fn gvn(func: &mut Function) -> bool {
    let cfg = Cfg::of(func);
    let dominators = Dominators::of(&cfg);
    let mut numbering = Numbering {
        known: FxHashMap::default(),
        renames: Renames::default(),
        loads: Loads::default(),
        scopes: Scopes::default(),
        guards: Guards::of(func),
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
    scopes: Scopes,
    guards: Guards,
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
        // Only a store asks which objects are apart, and to find them out is more than half of the work.
        let stores = func.blocks[block].insts.iter().any(|&inst| {
            let InstKind::Op { op, .. } = func.insts[inst].kind else {
                return false;
            };
            op.info().effect == Effect::Store
        });
        let unknown = Objects::default();
        let objects = match stores {
            true => self.scopes.of_block(func, block),
            false => &unknown,
        };
        let mut open = std::mem::take(&mut func.blocks[block].insts);
        open.reverse();
        while let Some(inst) = open.pop() {
            func.blocks[block].insts.push(inst);
            let data = &mut func.insts[inst];
            data.kind.for_each_use_mut(|v| *v = self.renames.find(*v));
            let result = data.results.first().copied();
            let Some(key) = key_of(&data.kind) else {
                let held = self.loads.see(&data.kind, result, objects, &self.guards);
                if let (Some(held), Some(result)) = (held, result) {
                    let (steps, value) = held.build(func, inst);
                    self.renames.replace(result, value);
                    open.extend(steps.into_iter().rev());
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
