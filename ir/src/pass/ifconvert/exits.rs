//! Loops that are left where only running them tells, made loops that run a number of times that is known.
//!
//! The array runs a kernel as often as it is told when it starts. A loop with several ways out (a
//! `break`, a `return`, a test with `&&`), or with a test [of what it has computed](super::counted) (the end of
//! a list or of a string), is run in *chunks*: until it has taken a way out it is
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

use super::ahead::Ahead;
use super::counted::is_counted;
use super::estimate::{FIRST_CHUNK, LONGEST_CHUNK, estimate};
use crate::flow::{Flow, LoopData};
use crate::pass::slots::{Uses, demote};
use crate::program::*;
use rustc_hash::FxHashSet;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Effect, Opcode, Ty};

/// Ways out that a loop may have.
const MAX_WAYS: usize = 12;

/// Arguments of jumps that may be anything: from where, to where, and at which place.
pub(super) type Free = FxHashSet<(Block, Block, usize)>;

/// True when a loop is one that would run on the array but for the places where it is left, or for a
/// number of iterations that only running it tells.
pub(super) fn is_left_early(func: &Function, data: &LoopData) -> bool {
    let [latch] = data.latches[..] else {
        return false;
    };
    let targets = func.blocks[latch].end.targets();
    if targets.filter(|t| t.block == data.header).count() > 1 {
        // Two ways back may give the header different values.
        return false;
    }
    for &block in &data.blocks {
        for &inst in &func.blocks[block].insts {
            match &func.insts[inst].kind {
                InstKind::Call { .. } | InstKind::Launch { .. } => return false,
                InstKind::Op { op, .. } if op.info().effect == Effect::Io => return false,
                _ => {}
            }
        }
    }
    let ways = data.exits(func).count();
    let early = data.exits(func).any(|(from, _)| from != latch);
    (early || !is_counted(func, data)) && (1..=MAX_WAYS).contains(&ways)
}

/// Makes the loops that [are left early](is_left_early), and marked, loops of chunks, if a pragma asks for that or it is
/// estimated to take less time.
pub(super) fn run_in_chunks(func: &mut Function, globals: &EntityMap<Global, GlobalData>) -> Free {
    let mut free = Free::default();
    let Flow {
        dominators, loops, ..
    } = Flow::of(func);
    for (id, data) in loops.loops.iter() {
        let Some(mark) = &func.blocks[data.header].kernel else {
            continue;
        };
        let required = mark.required;
        if !loops.is_innermost(id) || data.header == func.entry() || !is_left_early(func, data) {
            continue;
        }
        // Before the slots, whose stores nothing has to wait for.
        let ahead = Ahead::of(func, globals, data);
        let estimate = estimate(func, &dominators, data, &ahead);
        if required || estimate.array < estimate.vliw {
            demote(func, &data.blocks, Uses::Outside, "left");
            chunks(func, data, ahead, &mut free);
        } else if let Some(mark) = &mut func.blocks[data.header].kernel {
            mark.slower = Some(estimate);
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
        then: Target::to(body),
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
        other: Target::to(after),
    };

    // Behind a chunk.
    at.func.blocks[after].end = Terminator::Branch {
        cond: still,
        then: Target::to(again),
        other: Target::to(leave),
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
    let exits = data.exits(func);
    exits.map(|(from, target)| (from, target.clone())).collect()
}

/// Lets the jump `to` at the end of a block go to another one instead, and bring nothing.
fn redirect(func: &mut Function, from: Block, to: &Target, block: Block) {
    let mut targets = func.blocks[from].end.targets_mut();
    let found = targets.find(|t| *t == to).expect("it was found there");
    *found = Target::to(block);
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
            other: Target::to(next),
        };
        block = next;
    }
}

/// Lets all jumps into a loop from outside go to another block.
fn enter(func: &mut Function, data: &LoopData, entry: Block) {
    for &block in func.layout.iter().filter(|&&b| !data.contains(b)) {
        func.blocks[block].end.retarget(data.header, entry);
    }
}
