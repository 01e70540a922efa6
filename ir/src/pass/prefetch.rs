//! Prefetches: a loop on the array asks for the lines of system memory that it is to load from a few iterations later.
//!
//! An address, and with it the induction variables and loads from SRAM that it is made of, is computed once more for an
//! iteration [`AHEAD`], and the lines at it are asked for. That takes units, and so may take a larger II;
//! and a value from SRAM may be another by then, so that a line is brought for nothing. No result changes, and nothing
//! traps that did not: SRAM is read only for iterations that are to come, under the guards that they will have, and
//! where the loop stores to SRAM, at places that hang on nothing that it loads. (For loops of known strides: Mowry, Lam
//! and Gupta 1992.)

use super::nearby::Facts;
use super::preheader::{find, with_preheaders};
use super::strength::Linearity;
use crate::flow::{Flow, LoopData};
use crate::program::*;
use rustc_hash::{FxHashMap, FxHashSet};
use srp_archdesc::isa::{Class, Effect, Opcode, Space};
use std::collections::BTreeMap;

/// Iterations from a prefetch to its loads.
const AHEAD: u32 = 4;
/// Lines that a loop asks for in an iteration, at most, and operations that may be computed again for each address.
const MOST_LINES: usize = 8;
const MOST_OPERATIONS: usize = 16;
/// The largest step of an induction variable: limits of loops stay far from where numbers wrap.
const LARGEST_STEP: u32 = 1 << 20;

/// Adds prefetches to kernel loops of one block that have none; lines have so many bytes.
pub(crate) fn prefetch(func: &mut Function, line: u32) -> bool {
    let mut blocks = func.layout.iter();
    if !blocks.any(|&block| func.blocks[block].kernel.is_some()) {
        return false;
    }
    let Flow { cfg, loops, .. } = with_preheaders(func);
    let mut changed = false;
    for data in loops.loops.values() {
        if data.blocks.len() == 1 && func.blocks[data.header].kernel.is_some() {
            let before = find(func, &cfg, data).expect("every loop was given a preheader");
            changed |= of_loop(func, data, before, line.max(1));
        }
    }
    changed
}

fn of_loop(func: &mut Function, data: &LoopData, before: Block, line: u32) -> bool {
    let header = data.header;
    let Some(body) = Body::of(func, header) else {
        return false;
    };
    let Some(end) = body.end(func) else {
        return false;
    };
    let wanted = body.wanted(func, line);
    if wanted.is_empty() {
        return false;
    }
    let pos = func.blocks[header].end_pos;
    let guard = end.guard(func, header, before, pos);
    let mut later = Later {
        func,
        before,
        header,
        body: &body,
        guard,
        values: FxHashMap::default(),
    };
    for Wanted {
        address,
        offsets,
        operations,
        pos,
    } in wanted
    {
        operations.iter().for_each(|&inst| later.again(inst));
        let address = later.of(address);
        for offset in offsets {
            later.ask(address, offset, pos);
        }
    }
    true
}

/// A loop of one block.
struct Body {
    header: Block,
    facts: Facts,
    linearity: Linearity,
    /// The instructions of values that the block defines.
    defs: FxHashMap<Value, Inst>,
    params: FxHashSet<Value>,
    /// True if it stores to SRAM.
    stores: bool,
}

/// An address that the loop loads from, and what makes it.
struct Wanted {
    address: Value,
    /// From the address to the lines.
    offsets: Vec<i32>,
    /// The operations that it is made by, in order.
    operations: Vec<Inst>,
    pos: Pos,
}

/// The comparison that is true while an iteration follows: of a sum that grows by `step` with a value that stays.
struct End {
    op: Opcode,
    sum: Value,
    limit: Value,
    step: u32,
}

impl Body {
    /// `None` of a loop that has prefetches.
    fn of(func: &Function, header: Block) -> Option<Body> {
        let facts = Facts::of(func);
        let mut body = Body {
            header,
            linearity: Linearity::of(func, header, &facts.constants),
            facts,
            defs: FxHashMap::default(),
            params: func.blocks[header].params.iter().copied().collect(),
            stores: false,
        };
        for &inst in &func.blocks[header].insts {
            let data = &func.insts[inst];
            if let InstKind::Op { op, .. } = &data.kind {
                match op.info().effect {
                    Effect::Prefetch => return None,
                    Effect::Store => body.stores |= op.space() == Some(Space::Sram),
                    Effect::Pure | Effect::Load | Effect::Io => {}
                }
            }
            body.defs.extend(data.results.iter().map(|&r| (r, inst)));
        }
        Some(body)
    }

    fn is_inside(&self, value: Value) -> bool {
        self.params.contains(&value) || self.defs.contains_key(&value)
    }

    /// How the loop ends, if it does so by counting up to a limit.
    fn end(&self, func: &Function) -> Option<End> {
        let Terminator::Branch { cond, then, .. } = &func.blocks[self.header].end else {
            return None;
        };
        let InstKind::Op { op, args, .. } = &func.insts[*self.defs.get(cond)?].kind else {
            return None;
        };
        let counts = matches!(op, Opcode::Lt | Opcode::Ltu);
        if !counts || then.block != self.header {
            return None;
        }
        let &[sum, limit] = &args[..] else {
            return None;
        };
        let (iv, scale) = self.linearity.get(sum)?.iv?;
        let step = self.linearity.step(iv);
        let fits = scale == 1 && (1..=LARGEST_STEP).contains(&step);
        (fits && !self.is_inside(limit)).then_some(End {
            op: *op,
            sum,
            limit,
            step,
        })
    }

    /// The addresses of loads from system memory that can be computed ahead.
    fn wanted(&self, func: &Function, line: u32) -> Vec<Wanted> {
        // By address: the bytes from the first to the last, and the place of the first load.
        let mut ranges = BTreeMap::<Value, (i32, i32, Pos)>::new();
        for &inst in &func.blocks[self.header].insts {
            let data = &func.insts[inst];
            if let InstKind::Op { op, args, imm } = &data.kind
                && op.info().effect == Effect::Load
                && op.space() == Some(Space::Cached)
                && let Some(bytes) = op.access_bytes()
                && self.is_inside(args[1])
            {
                let last = imm.saturating_add_unsigned(bytes - 1);
                let range = ranges.entry(args[1]).or_insert((*imm, last, data.pos));
                (range.0, range.1) = (range.0.min(*imm), range.1.max(last));
            }
        }
        let mut wanted = Vec::new();
        let mut lines = 0;
        for (address, (first, last, pos)) in ranges {
            let Some(operations) = self.operations(func, address) else {
                continue;
            };
            let offsets: Vec<i32> = (first..=last)
                .step_by(line as usize)
                .take(MOST_LINES - lines)
                .collect();
            lines += offsets.len();
            if !offsets.is_empty() {
                wanted.push(Wanted {
                    address,
                    offsets,
                    operations,
                    pos,
                });
            }
        }
        wanted
    }

    /// The operations of the block that make a value, in order; `None` if they are too many, or it hangs on more than
    /// induction variables, SRAM and what is outside.
    fn operations(&self, func: &Function, value: Value) -> Option<Vec<Inst>> {
        let mut needed = FxHashSet::default();
        let mut work = vec![value];
        while let Some(value) = work.pop() {
            if self.params.contains(&value) {
                self.linearity.get(value)?;
                continue;
            }
            let Some(&inst) = self.defs.get(&value) else {
                continue;
            };
            let InstKind::Op { op, args, .. } = &func.insts[inst].kind else {
                continue;
            };
            let reads_sram = op.info().effect == Effect::Load && op.space() == Some(Space::Sram);
            let is_plain = op.is_pure() && op.class() != Class::Idiv;
            if !is_plain && !reads_sram {
                return None;
            }
            if needed.insert(inst) {
                work.extend(args);
            }
            if needed.len() > MOST_OPERATIONS {
                return None;
            }
        }
        let all = func.blocks[self.header].insts.iter().copied();
        let all: Vec<Inst> = all.filter(|inst| needed.contains(inst)).collect();
        self.may_be_early(func, &all).then_some(all)
    }

    /// True if none of these operations reads SRAM at a place, or under a guard, that a store before its time may change.
    fn may_be_early(&self, func: &Function, operations: &[Inst]) -> bool {
        let mut loaded = FxHashSet::<Value>::default();
        for &inst in operations {
            let InstData { kind, results, .. } = &func.insts[inst];
            let InstKind::Op { op, args, .. } = kind else {
                continue;
            };
            let hangs = args.iter().any(|arg| loaded.contains(arg));
            if self.stores && hangs && !op.is_pure() {
                return false;
            }
            if hangs || !op.is_pure() {
                loaded.extend(results);
            }
        }
        true
    }
}

impl End {
    /// Adds what is true where an iteration is to come that lies so far ahead.
    fn guard(&self, func: &mut Function, header: Block, before: Block, pos: Pos) -> Value {
        let far = (AHEAD - 1) * self.step;
        // Where the limit is so low that its difference would wrap there is no such iteration.
        let (larger, least) = match self.op {
            Opcode::Lt => (Opcode::Max, 0x8000_0000 + far),
            _ => (Opcode::Maxu, far),
        };
        let least = func.append_const(before, Bits::Word(least), pos);
        let far = func.append_const(before, Bits::Word(far), pos);
        let mut op = |block, op, args: &[Value]| {
            let value = func.append_op(block, op, args, 0, pos);
            value.expect("arithmetic has a result")
        };
        let limit = op(before, larger, &[self.limit, least]);
        let limit = op(before, Opcode::Sub, &[limit, far]);
        op(header, self.op, &[self.sum, limit])
    }
}

/// The values of the iteration that lies ahead.
struct Later<'a> {
    func: &'a mut Function,
    /// The block before the loop, for constants: a loop on the array has none of its own that others may use.
    before: Block,
    header: Block,
    body: &'a Body,
    guard: Value,
    values: FxHashMap<Value, Value>,
}

impl Later<'_> {
    /// The same value then.
    fn of(&mut self, value: Value) -> Value {
        if let Some(&later) = self.values.get(&value) {
            return later;
        }
        if !self.body.params.contains(&value) {
            return value;
        }
        let pos = self.func.blocks[self.header].end_pos;
        let far = AHEAD.wrapping_mul(self.body.linearity.step(value));
        let later = self.sum(value, far, pos);
        self.values.insert(value, later);
        later
    }

    /// Computes the result of an operation for then.
    fn again(&mut self, inst: Inst) {
        let InstData { kind, pos, results } = self.func.insts[inst].clone();
        let InstKind::Op { op, args, imm } = kind else {
            unreachable!("operations are asked for");
        };
        if self.values.contains_key(&results[0]) {
            return;
        }
        let mut args: Vec<Value> = args.into_iter().map(|arg| self.of(arg)).collect();
        if op.is_guarded() {
            args[0] = match self.body.facts.truths.contains(&args[0]) {
                true => self.guard,
                false => self.op(Opcode::Pand, &[args[0], self.guard], pos),
            };
        }
        let later = self.func.append_op(self.header, op, &args, imm, pos);
        self.values
            .insert(results[0], later.expect("it has a result"));
    }

    /// Asks for the line at an address.
    fn ask(&mut self, address: Value, offset: i32, pos: Pos) {
        let address = self.sum(address, offset as u32, pos);
        let args = [self.guard, address];
        (self.func).append_op(self.header, Opcode::Prefetch, &args, 0, pos);
    }

    fn sum(&mut self, value: Value, more: u32, pos: Pos) -> Value {
        if more == 0 {
            return value;
        }
        let more = self.func.append_const(self.before, Bits::Word(more), pos);
        self.op(Opcode::Add, &[value, more], pos)
    }

    fn op(&mut self, op: Opcode, args: &[Value], pos: Pos) -> Value {
        let value = self.func.append_op(self.header, op, args, 0, pos);
        value.expect("arithmetic has a result")
    }
}
