//! Unrolling of short loops inside others.
//!
//! A launch of the array costs more than a few iterations bring back, and only an innermost loop can be
//! launched. Where all loops inside a marked one run a constant, small number of times, they are
//! written out, and the loop around them becomes the kernel, if that is estimated to take less time.

use super::defs::Defs;
use crate::flow::{Dominators, Flow, Loop, LoopData};
use crate::program::*;
use rustc_hash::{FxHashMap, FxHashSet};
use srp_archdesc::arch::Precision;
use srp_archdesc::isa::{Opcode, Ty};
use srp_archdesc::ops;

mod estimate;
mod flatten;

use estimate::{Callees, Work};
use flatten::flatten;

/// Iterations that are written out at most.
const MAX_TRIP: u32 = 32;

/// Operations that a loop may have when those inside it are written out, and where they have branches,
/// which become predicates: beyond, it takes long to find a schedule.
const MAX_OPERATIONS: u32 = 230;
const MAX_CONDITIONAL: u32 = 110;

/// How deep a value of a loop is followed to constants.
const MAX_DEPTH: u32 = 24;

/// Unrolls the loops inside marked ones; whether there were any. A loop with a pragma of its own
/// stays, and so do all loops beside it.
pub(crate) fn unroll(program: &mut Program, precision: &Precision) -> bool {
    if !program.funcs.values().any(has_marks) {
        return false;
    }
    let callees = Callees::of(program);
    let mut changed = false;
    for func in program.funcs.values_mut() {
        while unroll_in_one(func, &callees, precision) {
            changed = true;
        }
    }
    changed
}

fn has_marks(func: &Function) -> bool {
    func.layout.iter().any(|&b| func.blocks[b].kernel.is_some())
}

/// Forgets the marks of loops that count only without loops inside them and still have some.
pub(crate) fn unnest(func: &mut Function) -> bool {
    if !has_marks(func) {
        return false;
    }
    let loops = Flow::of(func).loops;
    let mut changed = false;
    for (id, data) in loops.loops.iter() {
        let mark = &mut func.blocks[data.header].kernel;
        if !loops.is_innermost(id) && mark.as_ref().is_some_and(|m| m.nest) {
            *mark = None;
            changed = true;
        }
    }
    changed
}

/// Unrolls all loops inside one marked loop, if there is one whose loops can be.
fn unroll_in_one(func: &mut Function, callees: &Callees, precision: &Precision) -> bool {
    if !has_marks(func) {
        return false;
    }
    let flow = Flow::of(func);
    for (id, outer) in flow.loops.loops.iter() {
        if func.blocks[outer.header].kernel.is_none() {
            continue;
        }
        let unrolled = worth_unrolling(func, &flow, id, callees, precision);
        let Some(inner) = unrolled else {
            if flatten(func, &flow, id, callees, precision) {
                return true;
            }
            continue;
        };
        let named = inner.iter().find_map(|(data, _)| {
            let mark = func.blocks[data.header].kernel.take();
            mark.map(|mark| mark.name)
        });
        for (data, trip) in inner {
            func.blocks[data.header].kernel = None;
            write_out(func, data, trip);
        }
        let mark = func.blocks[outer.header].kernel.as_mut();
        let mark = mark.expect("only marked loops are looked at");
        if let (true, Some(name)) = (mark.nest, named) {
            mark.name = name;
        }
        mark.nest = false;
        return true;
    }
    false
}

/// The loops inside one, with how often they run, if all of them can be written out and that is
/// estimated to gain.
fn worth_unrolling<'a>(
    func: &Function,
    flow: &'a Flow,
    outer: Loop,
    callees: &Callees,
    precision: &Precision,
) -> Option<Vec<(&'a LoopData, Trip)>> {
    let loops = &flow.loops;
    let mut inner = Vec::new();
    for (id, data) in loops.inside(outer) {
        let required = func.blocks[data.header].kernel.as_ref();
        if !loops.is_innermost(id) || required.is_some_and(|mark| mark.required) {
            return None;
        }
        inner.push((
            data,
            trip(func, &flow.dominators, data, MAX_TRIP, precision)?,
        ));
    }
    if inner.is_empty() {
        return None;
    }
    let mut whole = Work::default();
    let mut apart = 0;
    for &block in &loops.loops[outer].blocks {
        let around = inner.iter().find(|(data, _)| data.contains(block));
        let times = around.map_or(1, |(_, trip)| trip.count);
        whole.add(func, block, times, callees)?;
    }
    for (data, trip) in &inner {
        let mut one = Work::default();
        for &block in &data.blocks {
            one.add(func, block, 1, callees)?;
        }
        apart += one.launched(trip.count);
    }
    let branches = |b: Block| matches!(func.blocks[b].end, Terminator::Branch { .. });
    let straight = inner.iter().all(|(data, trip)| {
        let mut others = data.blocks.iter().filter(|&&b| b != trip.test);
        others.all(|&b| !branches(b))
    });
    let most = if straight {
        MAX_OPERATIONS
    } else {
        MAX_CONDITIONAL
    };
    let fits = whole.size() <= most;
    (fits && whole.interval() < apart).then_some(inner)
}

/// How often a loop begins an iteration, and the block whose test says so.
#[derive(Clone, Copy)]
pub(super) struct Trip {
    pub(super) count: u32,
    test: Block,
}

/// How often a loop runs, if one of its tests that every iteration makes depends on constants alone.
pub(super) fn trip(
    func: &Function,
    dominators: &Dominators,
    data: &LoopData,
    limit: u32,
    precision: &Precision,
) -> Option<Trip> {
    let [latch] = data.latches[..] else {
        return None;
    };
    let mut backs = func.blocks[latch].end.targets();
    let back = backs.find(|t| t.block == data.header)?;
    if backs.any(|t| t.block == data.header) {
        // Two ways back may give the header different values.
        return None;
    }
    let mut entries = func.layout.iter().flat_map(|&from| {
        let targets = func.blocks[from].end.targets();
        targets
            .filter(|t| t.block == data.header)
            .map(move |t| (from, t))
    });
    let outside = |&(from, _): &(Block, &Target)| !data.contains(from);
    let (_, entry) = entries.find(outside)?;
    let others: Vec<&Target> = entries.filter(outside).map(|(_, t)| t).collect();
    let params = &func.blocks[data.header].params;
    let mut tests: Vec<(Block, Value, bool)> = data
        .blocks
        .iter()
        .filter(|&&block| dominators.dominates(block, latch))
        .filter_map(|&block| {
            let Terminator::Branch { cond, then, other } = &func.blocks[block].end else {
                return None;
            };
            let inside = |t: &Target| data.contains(t.block);
            (inside(then) != inside(other)).then(|| (block, *cond, inside(then)))
        })
        .collect();
    if tests.is_empty() {
        return None;
    }
    let mut known = Known::of(func, precision);
    // All ways in have to agree.
    let first = |(place, &v): (usize, &Value)| {
        let value = known.value(v, 0)?;
        let mut others = others.iter().map(|t| known.value(t.args[place], 0));
        others.all(|other| other == Some(value)).then_some(value)
    };
    let mut state: Vec<Option<ops::Value>> = entry.args.iter().enumerate().map(first).collect();
    for count in 1..=limit {
        let pairs = params.iter().copied().zip(state.iter().copied());
        known.params = pairs.filter_map(|(p, v)| Some((p, v?))).collect();
        known.memo.clear();
        // A test that is unknown in one iteration may end the loop there: it is not the test that
        // counts, even if it is known later.
        tests.retain(|&(_, cond, _)| known.value(cond, 0).is_some());
        if tests.is_empty() {
            return None;
        }
        for &(test, cond, stays) in &tests {
            if known.value(cond, 0).is_some_and(|v| (v.0[0] != 0) != stays) {
                return Some(Trip { count, test });
            }
        }
        state = back.args.iter().map(|&v| known.value(v, 0)).collect();
    }
    None
}

/// Values that follow from constants and from known parameters.
struct Known<'a> {
    func: &'a Function,
    precision: &'a Precision,
    defs: Defs,
    params: FxHashMap<Value, ops::Value>,
    memo: FxHashMap<Value, Option<ops::Value>>,
}

impl<'a> Known<'a> {
    fn of(func: &'a Function, precision: &'a Precision) -> Known<'a> {
        Known {
            func,
            precision,
            defs: Defs::of(func),
            params: FxHashMap::default(),
            memo: FxHashMap::default(),
        }
    }

    fn value(&mut self, value: Value, depth: u32) -> Option<ops::Value> {
        if let Some(&known) = self.params.get(&value) {
            return Some(known);
        }
        if let Some(&known) = self.memo.get(&value) {
            return known;
        }
        if depth > MAX_DEPTH {
            return None;
        }
        let found = match self.defs.kind(self.func, value)? {
            InstKind::Const(bits) => Some(ops::Value::from(*bits)),
            InstKind::Op { op, args, imm } if op.is_pure() => {
                let args: Option<Vec<ops::Value>> =
                    args.iter().map(|&a| self.value(a, depth + 1)).collect();
                args.and_then(|args| ops::eval(*op, &args, *imm, self.precision).ok()?)
            }
            _ => None,
        };
        self.memo.insert(value, found);
        found
    }
}

/// Writes a loop out: copies of its blocks follow each other, and the last goes where the loop ended.
pub(super) fn write_out(func: &mut Function, data: &LoopData, trip: Trip) {
    let latch = data.latches[0];
    if data.exits(func).any(|(from, _)| from != trip.test) {
        keep_in_slots(func, &data.blocks);
    }
    let mut names: Vec<FxHashMap<Value, Value>> = vec![FxHashMap::default()];
    let mut copies = vec![data.blocks.clone()];
    for _ in 1..trip.count {
        let (blocks, map) = copy(func, &data.blocks);
        copies.push(blocks);
        names.push(map);
    }
    let at = |block: Block| data.blocks.iter().position(|&b| b == block);
    let header = at(data.header).expect("the header is in its loop");
    let tail = at(latch).expect("the latch is in its loop");
    let test = at(trip.test).expect("the test is in its loop");
    for number in 0..copies.len() {
        let (own, next) = (&copies[number], copies.get(number + 1));
        // In the copies, jumps back go to the copy's own header so far.
        if let Some(next) = next {
            let end = &mut func.blocks[own[tail]].end;
            end.retarget(own[header], next[header]);
        }
        let stays =
            |t: &Target| own.contains(&t.block) || next.is_some_and(|n| n[header] == t.block);
        let mut targets = func.blocks[own[test]].end.targets();
        let way = targets.find(|t| stays(t) == next.is_some()).cloned();
        drop(targets);
        let way = way.expect("a test goes on or ends the loop");
        func.blocks[own[test]].end = Terminator::Jump(way);
        if next.is_none() && test != tail {
            // Never reached.
            func.blocks[own[tail]].end = Terminator::Unreachable;
        }
    }
    // What is used after the loop is what the last copy made.
    let last = names.pop().expect("there is one copy at least");
    if copies.len() > 1 {
        let inside: Vec<Block> = copies.iter().flatten().copied().collect();
        rename_outside(func, &inside, &last);
    }
    let place = func.layout.iter().position(|&b| b == latch);
    let place = place.map_or(func.layout.len(), |p| p + 1);
    let added = copies.into_iter().skip(1).flatten();
    func.layout.splice(place..place, added);
}

/// Copies of the blocks of a loop, not in the layout, and of what they define.
pub(super) fn copy(func: &mut Function, old: &[Block]) -> (Vec<Block>, FxHashMap<Value, Value>) {
    let mut map = FxHashMap::default();
    let mut blocks = Vec::new();
    for &block in old {
        let mut copied = func.blocks[block].clone();
        for param in &mut copied.params {
            let fresh = func.values.push(func.values[*param]);
            map.insert(*param, fresh);
            *param = fresh;
        }
        for inst in &mut copied.insts {
            let mut made = func.insts[*inst].clone();
            for result in &mut made.results {
                let fresh = func.values.push(func.values[*result]);
                map.insert(*result, fresh);
                *result = fresh;
            }
            *inst = func.insts.push(made);
        }
        blocks.push(func.blocks.push(copied));
    }
    let rename = |v: &mut Value| *v = map.get(v).copied().unwrap_or(*v);
    for &block in &blocks {
        for &inst in &func.blocks[block].insts {
            func.insts[inst].kind.for_each_use_mut(rename);
        }
        let end = &mut func.blocks[block].end;
        end.for_each_use_mut(rename);
        for target in end.targets_mut() {
            if let Some(at) = old.iter().position(|&b| b == target.block) {
                target.block = blocks[at];
            }
        }
    }
    (blocks, map)
}

/// Gives the uses outside some blocks other values.
pub(super) fn rename_outside(func: &mut Function, inside: &[Block], map: &FxHashMap<Value, Value>) {
    let rename = |v: &mut Value| *v = map.get(v).copied().unwrap_or(*v);
    for &block in &func.layout {
        if inside.contains(&block) {
            continue;
        }
        for &inst in &func.blocks[block].insts {
            func.insts[inst].kind.for_each_use_mut(rename);
        }
        func.blocks[block].end.for_each_use_mut(rename);
    }
}

/// Keeps what some blocks define and others use in stack slots, which [`mem2reg`](super::mem2reg)
/// makes values again: a loop with several ways out may leave any of its copies.
pub(super) fn keep_in_slots(func: &mut Function, blocks: &[Block]) {
    let mut defined = Vec::new();
    for &block in blocks {
        defined.extend(func.blocks[block].params.iter().map(|&v| (v, block, None)));
        for &inst in &func.blocks[block].insts {
            let results = func.insts[inst].results.iter();
            defined.extend(results.map(|&v| (v, block, Some(inst))));
        }
    }
    let mut used = FxHashSet::default();
    let inside: FxHashSet<Block> = blocks.iter().copied().collect();
    let outside: Vec<Block> = func
        .layout
        .iter()
        .copied()
        .filter(|b| !inside.contains(b))
        .collect();
    for &block in &outside {
        for &inst in &func.blocks[block].insts {
            func.insts[inst].kind.for_each_use(|v| {
                used.insert(v);
            });
        }
        func.blocks[block].end.for_each_use(|v| {
            used.insert(v);
        });
    }
    for (value, block, inst) in defined {
        if !used.contains(&value) {
            continue;
        }
        if let Some(inst) = inst.filter(|&inst| is_constant(&func.insts[inst].kind)) {
            for &user in &outside {
                make_where_used(func, user, value, inst);
            }
            continue;
        }
        let ty = func.values[value];
        let (size, align) = if ty == Ty::Vec { (16, 16) } else { (4, 4) };
        let slot = func.slots.push(SlotData {
            name: "left".to_owned(),
            size,
            align,
        });
        let place = inst.map_or(0, |inst| {
            let insts = &func.blocks[block].insts;
            insts.iter().position(|&i| i == inst).map_or(0, |p| p + 1)
        });
        let pos = inst.map_or(Pos::nowhere(), |inst| func.insts[inst].pos);
        let store = access(func, slot, ty, Some(value), pos).0;
        func.blocks[block].insts.splice(place..place, store);
        for &user in &outside {
            load_where_used(func, user, value, slot, ty);
        }
    }
}

/// The instructions of a store of a value to a slot, or of a load and what it gives.
pub(super) fn access(
    func: &mut Function,
    slot: Slot,
    ty: Ty,
    stored: Option<Value>,
    pos: Pos,
) -> (Vec<Inst>, Option<Value>) {
    let mut insts = Vec::new();
    let mut make = |func: &mut Function, kind: InstKind, ty: Option<Ty>| {
        let inst = func.make_inst(kind, ty.as_slice(), pos);
        insts.push(inst);
        func.insts[inst].results.first().copied()
    };
    let op = |op, args| InstKind::Op { op, args, imm: 0 };
    let truth = make(func, InstKind::Const(Bits::Pred(true)), Some(Ty::Pred));
    let address = make(func, InstKind::SlotAddr(slot, 0), Some(Ty::Word));
    let (Some(truth), Some(address)) = (truth, address) else {
        unreachable!("both have results")
    };
    let loaded = match (stored, ty) {
        (Some(value), Ty::Vec) => make(func, op(Opcode::Sv, vec![truth, address, value]), None),
        (Some(value), Ty::Word) => make(func, op(Opcode::Sw, vec![truth, address, value]), None),
        (Some(value), Ty::Pred) => {
            let word = make(func, op(Opcode::Ptoi, vec![value]), Some(Ty::Word));
            let word = word.expect("it has a result");
            make(func, op(Opcode::Sw, vec![truth, address, word]), None)
        }
        (None, Ty::Vec) => make(func, op(Opcode::Lv, vec![truth, address]), Some(ty)),
        (None, Ty::Word) => make(func, op(Opcode::Lw, vec![truth, address]), Some(ty)),
        (None, Ty::Pred) => {
            let word = make(func, op(Opcode::Lw, vec![truth, address]), Some(Ty::Word));
            let zero = make(func, InstKind::Const(Bits::Word(0)), Some(Ty::Word));
            let args = word.into_iter().chain(zero).collect();
            make(func, op(Opcode::Ne, args), Some(ty))
        }
    };
    (insts, loaded)
}

/// True when an instruction can be made again anywhere.
fn is_constant(kind: &InstKind) -> bool {
    matches!(
        kind,
        InstKind::Const(_) | InstKind::SymbolAddr(..) | InstKind::SlotAddr(..)
    )
}

/// Makes a constant again at the beginning of a block that uses it.
fn make_where_used(func: &mut Function, block: Block, value: Value, inst: Inst) {
    let InstData { kind, pos, .. } = func.insts[inst].clone();
    let ty = func.values[value];
    replace_uses(func, block, value, |func| {
        let made = func.make_inst(kind, &[ty], pos);
        (vec![made], func.insts[made].results[0])
    });
}

/// Loads a slot at the beginning of a block that uses the value, and lets it use what is loaded.
fn load_where_used(func: &mut Function, block: Block, value: Value, slot: Slot, ty: Ty) {
    let pos = func.blocks[block].end_pos;
    replace_uses(func, block, value, |func| {
        let (load, loaded) = access(func, slot, ty, None, pos);
        (load, loaded.expect("loads have a result"))
    });
}

/// Lets a block use another value, which instructions at its beginning make, if it uses this one.
fn replace_uses(
    func: &mut Function,
    block: Block,
    value: Value,
    make: impl FnOnce(&mut Function) -> (Vec<Inst>, Value),
) {
    let mut uses = false;
    let insts = func.blocks[block].insts.clone();
    for &inst in &insts {
        func.insts[inst].kind.for_each_use(|v| uses |= v == value);
    }
    func.blocks[block].end.for_each_use(|v| uses |= v == value);
    if !uses {
        return;
    }
    let (first, made) = make(func);
    let rename = |v: &mut Value| {
        if *v == value {
            *v = made;
        }
    };
    for inst in insts {
        func.insts[inst].kind.for_each_use_mut(rename);
    }
    func.blocks[block].end.for_each_use_mut(rename);
    func.blocks[block].insts.splice(0..0, first);
}
