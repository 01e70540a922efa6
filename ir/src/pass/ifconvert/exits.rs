//! Loops that are left in the middle, made loops that run a number of times that is known.
//!
//! The array runs a kernel as often as it is told when it starts. A loop with several ways out (a
//! `break`, a `return`, a test with `&&`) is run in *chunks*: until it has taken a way out it is
//! *alive*, and what is left of a chunk then does nothing, for its loads, stores and divisions are
//! under that predicate, but for loads that [need not wait](super::ahead). Control code goes on behind the chunk where the loop was left, or with the
//! next chunk, which is twice as long.
//!
//! ```text
//!   outer(p, m):     jump header(p, 0, true, 0, …)
//!   header(p, k, alive, way, values…):   br alive, body, latch(…)
//!   body:            … a way out: jump latch(any p, false, its number, what it brings)
//!                    … the way back: jump latch(next p, true, …)
//!   latch(p, alive, way, values…):       br k + 1 < m, header(…), after
//!   after:           br alive, outer(p, 2 m), the way out
//! ```

use super::ahead::{Ahead, latency};
use crate::flow::{Cfg, Dominators, LoopData, Loops};
use crate::pass::unroll::keep_in_slots;
use crate::program::*;
use rustc_hash::FxHashSet;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Effect, Opcode, Ty};

/// Iterations of the first chunk, and of the longest.
const FIRST_CHUNK: u32 = 16;
const LONGEST_CHUNK: u32 = 512;

/// Cycles that an iteration may have to wait for the one before: beyond, the array is not faster than
/// the VLIW engine, which ends a loop where it ends.
const MAX_RECURRENCE: u32 = 14;

/// Ways out that a loop may have.
const MAX_WAYS: usize = 12;

/// Arguments of jumps that may be anything: from where, to where, and at which place.
pub(super) type Free = FxHashSet<(Block, Block, usize)>;

/// True when a loop is one that would run on the array but for the places where it is left, and how
/// often it can run is bounded by one of its tests.
pub(super) fn is_left_early(func: &Function, data: &LoopData) -> bool {
    let inside = |block: Block| data.blocks.contains(&block);
    let [latch] = data.latches[..] else {
        return false;
    };
    let targets = func.blocks[latch].end.targets();
    if targets.filter(|t| t.block == data.header).count() > 1 {
        // Two ways back may give the header different values.
        return false;
    }
    let mut ways = 0;
    let mut early = false;
    for &block in &data.blocks {
        for &inst in &func.blocks[block].insts {
            match &func.insts[inst].kind {
                InstKind::Call { .. } | InstKind::Launch { .. } => return false,
                InstKind::Op { op, .. } if op.info().effect == Effect::Io => return false,
                _ => {}
            }
        }
        let leaving = func.blocks[block]
            .end
            .targets()
            .filter(|t| !inside(t.block));
        let leaving = leaving.count();
        ways += leaving;
        early |= leaving > 0 && block != latch;
    }
    early && ways <= MAX_WAYS && counts(func, data) && recurrence(func, data) <= MAX_RECURRENCE
}

/// True when one of the tests that end a loop compares what changes by a constant with what does not
/// change.
fn counts(func: &Function, data: &LoopData) -> bool {
    let mut home = EntityMap::<Value, bool>::filled(func.values.len(), false);
    let mut made = EntityMap::<Value, Option<Inst>>::filled(func.values.len(), None);
    for &block in &data.blocks {
        for &param in &func.blocks[block].params {
            home[param] = true;
        }
        for &inst in &func.blocks[block].insts {
            for &result in &func.insts[inst].results {
                home[result] = true;
                made[result] = Some(inst);
            }
        }
    }
    let constant =
        |v: Value| made[v].is_some_and(|i| matches!(func.insts[i].kind, InstKind::Const(_)));
    let unchanging = |v: Value| !home[v] || constant(v);
    let op = |v: Value| match &func.insts[made[v]?].kind {
        InstKind::Op { op, args, .. } => Some((*op, args.clone())),
        _ => None,
    };
    let params = &func.blocks[data.header].params;
    let latch = data.latches[0];
    let next = |place: usize| {
        let mut targets = func.blocks[latch].end.targets();
        targets
            .find(|t| t.block == data.header)
            .map(|t| t.args[place])
    };
    // A parameter that counts, or one step of it.
    let counter = |v: Value| {
        let own = params.iter().position(|&p| p == v);
        let (place, step) = match (own, op(v)) {
            (Some(place), _) => (place, next(place)),
            (None, Some((Opcode::Add | Opcode::Sub, args))) => {
                match params.iter().position(|&p| p == args[0]) {
                    Some(place) => (place, next(place)),
                    None => return false,
                }
            }
            _ => return false,
        };
        let Some((Opcode::Add | Opcode::Sub, args)) = step.and_then(op) else {
            return false;
        };
        args[0] == params[place] && unchanging(args[1])
    };
    data.blocks.iter().any(|&block| {
        let end = &func.blocks[block].end;
        let Terminator::Branch { cond, .. } = end else {
            return false;
        };
        let leaves = end.targets().any(|t| !data.blocks.contains(&t.block));
        let test = op(*cond).filter(|(op, _)| {
            use Opcode::{Eq, Le, Leu, Lt, Ltu, Ne};
            matches!(op, Eq | Ne | Lt | Le | Ltu | Leu)
        });
        leaves
            && test.is_some_and(|(_, args)| {
                counter(args[0]) && unchanging(args[1]) || counter(args[1]) && unchanging(args[0])
            })
    })
}

/// The longest way, in cycles of a common machine, from a value of the loop to what it is in the next
/// iteration.
fn recurrence(func: &Function, data: &LoopData) -> u32 {
    let header = &func.blocks[data.header];
    let mut back = func.blocks[data.latches[0]].end.targets();
    let Some(back) = back.find(|t| t.block == data.header) else {
        return 0;
    };
    let mut longest = 0;
    for (&param, &next) in header.params.iter().zip(&back.args) {
        let mut depth = EntityMap::<Value, Option<u32>>::filled(func.values.len(), None);
        depth[param] = Some(0);
        for &block in &data.blocks {
            for &inst in &func.blocks[block].insts {
                let InstData { kind, results, .. } = &func.insts[inst];
                let InstKind::Op { op, args, .. } = kind else {
                    continue;
                };
                let from = args.iter().filter_map(|&a| depth[a]).max();
                if let (Some(from), Some(&result)) = (from, results.first()) {
                    depth[result] = Some(from + latency(*op));
                }
            }
            for target in func.blocks[block].end.targets() {
                if target.block == data.header {
                    continue;
                }
                for (&param, &arg) in func.blocks[target.block].params.iter().zip(&target.args) {
                    depth[param] = depth[param].max(depth[arg].map(|d| d + 1));
                }
            }
        }
        longest = longest.max(depth[next].unwrap_or(0));
    }
    longest
}

/// Iterations by which the two engines are compared.
const USUAL: u32 = 80;
/// Cycles of a launch beyond its iterations.
const LAUNCH: u32 = 24;
/// Operations of an array in a cycle, most of the time, and of the VLIW engine; cycles that this takes for an iteration
/// at least, and beyond the recurrence.
const ARRAY_OPERATIONS: u32 = 11;
const VLIW_OPERATIONS: u32 = 2;
const LEAST: u32 = 3;
const BRANCH: u32 = 2;

/// Estimates the cycles of some iterations in chunks on the array, and on the VLIW engine.
pub(crate) struct Estimate {
    /// How many.
    pub(crate) iterations: u32,
    /// On the array, with all launches.
    pub(crate) array: u32,
    /// On the VLIW engine.
    pub(crate) vliw: u32,
}

impl Estimate {
    /// Of a loop that [is left early](is_left_early).
    fn of(func: &Function, data: &LoopData, ahead: &Ahead) -> Estimate {
        let insts = data
            .blocks
            .iter()
            .flat_map(|&block| &func.blocks[block].insts);
        let operations = insts.filter(|&&i| matches!(func.insts[i].kind, InstKind::Op { .. }));
        let size = operations.count() as u32;
        let recurrence = recurrence(func, data);
        let interval = (recurrence.max(ahead.wait(func, data)))
            .max(size.div_ceil(ARRAY_OPERATIONS))
            .max(1);
        let (mut iterations, mut launches, mut chunk) = (0, 0, FIRST_CHUNK);
        while iterations < USUAL {
            iterations += chunk;
            launches += 1;
            chunk = (2 * chunk).min(LONGEST_CHUNK);
        }
        let of_one = LEAST
            .max(size.div_ceil(VLIW_OPERATIONS))
            .max(recurrence + BRANCH);
        Estimate {
            iterations: USUAL,
            array: iterations * interval + launches * LAUNCH,
            vliw: USUAL * of_one,
        }
    }
}

/// The estimate of a loop that would run in chunks, if the array is no faster.
pub(crate) fn slower_in_chunks(
    func: &Function,
    globals: &EntityMap<Global, GlobalData>,
    data: &LoopData,
) -> Option<Estimate> {
    if !is_left_early(func, data) {
        return None;
    }
    let estimate = Estimate::of(func, data, &Ahead::of(func, globals, data));
    (estimate.array >= estimate.vliw).then_some(estimate)
}

/// Makes the loops that [are left early](is_left_early), and marked, loops of chunks, if a pragma asks for that or it is
/// estimated to take less time.
pub(super) fn run_in_chunks(func: &mut Function, globals: &EntityMap<Global, GlobalData>) -> Free {
    let mut free = Free::default();
    let cfg = Cfg::of(func);
    let loops = Loops::of(&cfg, &Dominators::of(&cfg));
    for (id, data) in loops.loops.iter() {
        let innermost = loops.loops.values().all(|l| l.parent != Some(id));
        let Some(mark) = &func.blocks[data.header].kernel else {
            continue;
        };
        let wanted = mark.required || slower_in_chunks(func, globals, data).is_none();
        if innermost && wanted && data.header != func.entry() && is_left_early(func, data) {
            // Before the slots, whose stores nothing has to wait for.
            let ahead = Ahead::of(func, globals, data);
            keep_in_slots(func, data);
            chunks(func, data, ahead, &mut free);
        }
    }
    free
}

/// Instructions put at the end of a block.
struct At<'a> {
    func: &'a mut Function,
    pos: Pos,
}

impl At<'_> {
    fn block(&mut self) -> Block {
        let block = self.func.blocks.push(BlockData::unreachable());
        self.func.blocks[block].end_pos = self.pos;
        block
    }

    fn constant(&mut self, block: Block, bits: Bits) -> Value {
        self.func.append_const(block, bits, self.pos)
    }

    fn op(&mut self, block: Block, op: Opcode, args: &[Value]) -> Value {
        let made = self.func.append_op(block, op, args, 0, self.pos);
        made.expect("operations of words have results")
    }

    fn params(&mut self, block: Block, tys: &[Ty]) -> Vec<Value> {
        tys.iter()
            .map(|&ty| self.func.add_param(block, ty))
            .collect()
    }
}

fn target(block: Block, args: Vec<Value>) -> Target {
    Target { block, args }
}

fn chunks(func: &mut Function, data: &LoopData, ahead: Ahead, free: &mut Free) {
    let mark = func.blocks[data.header].kernel.take();
    let pos = mark.as_ref().map_or(Pos::nowhere(), |mark| mark.pos);
    let body = data.header;
    let own = std::mem::take(&mut func.blocks[body].params);
    let tys: Vec<Ty> = own.iter().map(|&p| func.values[p]).collect();
    let ways = ways_out(func, data);
    let brought: Vec<Ty> = ways
        .iter()
        .flat_map(|(_, way)| way.args.iter().map(|&v| func.values[v]))
        .collect();
    let mut at = At { func, pos };
    let [entry, outer, header, latch, after, again, leave] = [(); 7].map(|()| at.block());

    // Entering: the first chunk.
    let first = at.params(entry, &tys);
    let chunk = at.constant(entry, Bits::Word(FIRST_CHUNK));
    let args = first.into_iter().chain([chunk]).collect();
    at.func.blocks[entry].end = Terminator::Jump(target(outer, args));
    let outer_params = at.params(outer, &tys);
    let chunk = at.func.add_param(outer, Ty::Word);
    let mut args = outer_params;
    args.push(at.constant(outer, Bits::Word(0)));
    args.push(at.constant(outer, Bits::Pred(true)));
    args.push(at.constant(outer, Bits::Word(0)));
    for &ty in &brought {
        args.push(at.constant(outer, Bits::zero(ty)));
    }
    at.func.blocks[outer].end = Terminator::Jump(target(header, args));

    // The kernel: its header takes over the parameters of the old one.
    at.func.blocks[header].params = own.clone();
    ahead.move_to(at.func, header);
    let count = at.func.add_param(header, Ty::Word);
    let alive = at.func.add_param(header, Ty::Pred);
    let way = at.func.add_param(header, Ty::Word);
    let kept = at.params(header, &brought);
    let state = |next: &[Value], alive: Value, way: Value, kept: &[Value]| {
        let args = next.iter().chain([&alive, &way]).chain(kept);
        target(latch, args.copied().collect())
    };
    let gone = at.constant(header, Bits::Pred(false));
    at.func.blocks[header].end = Terminator::Branch {
        cond: alive,
        then: target(body, Vec::new()),
        other: state(&own, gone, way, &kept),
    };
    at.func.blocks[header].kernel = mark;
    let mut dead = vec![header];

    // The ways out, each by a block of its own.
    let mut place = 0;
    for (number, (from, way_out)) in (0..).zip(&ways) {
        let block = at.block();
        let gone = at.constant(block, Bits::Pred(false));
        let number_of = at.constant(block, Bits::Word(number));
        let mut values = kept.clone();
        values[place..place + way_out.args.len()].copy_from_slice(&way_out.args);
        at.func.blocks[block].end = Terminator::Jump(state(&own, gone, number_of, &values));
        for other in 0..kept.len() {
            if !(place..place + way_out.args.len()).contains(&other) {
                // What another way would bring does not matter on this one.
                free.insert((block, latch, own.len() + 2 + other));
            }
        }
        place += way_out.args.len();
        redirect(at.func, *from, way_out, block);
        at.func.layout.push(block);
        dead.push(block);
    }
    for block in &dead {
        free.extend((0..own.len()).map(|place| (*block, latch, place)));
    }

    // The way back.
    let back = at.block();
    let old = data.latches[0];
    let on = at.constant(back, Bits::Pred(true));
    let next = {
        let mut targets = at.func.blocks[old].end.targets_mut();
        let target = targets
            .find(|t| t.block == body)
            .expect("a latch jumps back");
        target.block = back;
        std::mem::take(&mut target.args)
    };
    at.func.blocks[back].end = Terminator::Jump(state(&next, on, way, &kept));
    free.extend((0..=kept.len()).map(|place| (back, latch, own.len() + 1 + place)));
    at.func.layout.push(back);

    let next = at.params(latch, &tys);
    let still = at.func.add_param(latch, Ty::Pred);
    let taken = at.func.add_param(latch, Ty::Word);
    let values = at.params(latch, &brought);
    let one = at.constant(latch, Bits::Word(1));
    let counted = at.op(latch, Opcode::Add, &[count, one]);
    let more = at.op(latch, Opcode::Ltu, &[counted, chunk]);
    let mut args = next.clone();
    args.extend([counted, still, taken]);
    args.extend(&values);
    at.func.blocks[latch].end = Terminator::Branch {
        cond: more,
        then: target(header, args),
        other: target(after, Vec::new()),
    };

    // Behind a chunk.
    at.func.blocks[after].end = Terminator::Branch {
        cond: still,
        then: target(again, Vec::new()),
        other: target(leave, Vec::new()),
    };
    let doubled = at.op(again, Opcode::Add, &[chunk, chunk]);
    let longest = at.constant(again, Bits::Word(LONGEST_CHUNK));
    let longer = at.op(again, Opcode::Minu, &[doubled, longest]);
    let args = next.into_iter().chain([longer]).collect();
    at.func.blocks[again].end = Terminator::Jump(target(outer, args));
    at.func.layout.extend([latch, after, again]);
    dispatch(&mut at, leave, taken, &ways, &values);

    enter(at.func, data, entry);
    let place = at.func.layout.iter().position(|&b| b == body).unwrap_or(1);
    at.func.layout.splice(place..place, [entry, outer, header]);
}

/// The ways out of a loop, each with the block that takes it.
fn ways_out(func: &Function, data: &LoopData) -> Vec<(Block, Target)> {
    let blocks = data.blocks.iter();
    let ways = blocks.flat_map(|&from| {
        let targets = func.blocks[from].end.targets();
        let out = targets.filter(|t| !data.blocks.contains(&t.block));
        out.map(move |t| (from, t.clone()))
    });
    ways.collect()
}

/// Lets the jump `to` at the end of a block go to another one instead, and bring nothing.
fn redirect(func: &mut Function, from: Block, to: &Target, block: Block) {
    let mut targets = func.blocks[from].end.targets_mut();
    let found = targets.find(|t| *t == to).expect("it was found there");
    *found = target(block, Vec::new());
}

/// Goes the way out with the number that was taken.
fn dispatch(
    at: &mut At<'_>,
    leave: Block,
    taken: Value,
    ways: &[(Block, Target)],
    values: &[Value],
) {
    let mut block = leave;
    let mut rest = values;
    for (number, (_, way)) in (0..).zip(ways) {
        at.func.layout.push(block);
        let (own, more) = rest.split_at(way.args.len());
        rest = more;
        let out = target(way.block, own.to_vec());
        if number as usize + 1 == ways.len() {
            at.func.blocks[block].end = Terminator::Jump(out);
            return;
        }
        let number = at.constant(block, Bits::Word(number));
        let is = at.op(block, Opcode::Eq, &[taken, number]);
        let next = at.block();
        at.func.blocks[block].end = Terminator::Branch {
            cond: is,
            then: out,
            other: target(next, Vec::new()),
        };
        block = next;
    }
}

/// Lets all jumps into a loop from outside go to another block.
fn enter(func: &mut Function, data: &LoopData, entry: Block) {
    let layout = func.layout.clone();
    for block in layout {
        if !data.blocks.contains(&block) {
            for target in func.blocks[block].end.targets_mut() {
                if target.block == data.header {
                    target.block = entry;
                }
            }
        }
    }
}
