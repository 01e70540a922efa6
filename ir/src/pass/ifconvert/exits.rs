//! Loops that are left where only running them tells, made loops that run a number of times that is known.
//!
//! The array runs a kernel as often as it is told when it starts. A loop with several ways out (a
//! `break`, a `return`, a test with `&&`), or with a test [of what it has computed](super::counted) (the end of
//! a list or of a string), is run in *chunks*: until it has taken a way out it is
//! *alive*, and what is left of a chunk then does nothing, for its loads, stores and divisions are
//! under that predicate, but for loads that [need not wait](super::ahead). Control code goes on behind the chunk where the loop was left, or with the
//! next chunk, which is twice as long, but no longer than [the loop may run](super::limit).
//!
//! ```text
//!   outer(p, m):     n = min(m, most(p)); jump header(p, 0, true, 0, …)
//!   header(p, k, alive, way, values…):   br alive, body, latch(…)
//!   body:            … a way out: jump latch(any p, false, its number, what it brings)
//!                    … the way back: jump latch(next p, true, …)
//!   latch(p, alive, way, values…):       br k + 1 < n, header(…), after
//!   after:           br alive, outer(p, 2 m), the way out
//! ```

use super::ahead::Ahead;
use super::at::At;
use super::counted::is_counted;
use super::estimate::{FIRST_CHUNK, LONGEST_CHUNK, estimate};
use super::limit::Limit;
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
        let limit = Limit::of(func, &dominators, data);
        let estimate = estimate(func, &dominators, data, &ahead, limit.as_ref());
        if required || estimate.array < estimate.vliw {
            demote(func, &data.blocks, Uses::Outside);
            chunks(func, data, ahead, limit.as_ref(), &mut free);
        } else if let Some(mark) = &mut func.blocks[data.header].kernel {
            mark.slower = Some(estimate);
        }
    }
    free
}

/// Makes a loop one of chunks.
fn chunks(
    func: &mut Function,
    data: &LoopData,
    ahead: Ahead,
    limit: Option<&Limit>,
    free: &mut Free,
) {
    let mark = func.blocks[data.header].kernel.take();
    let pos = mark.as_ref().map_or(Pos::nowhere(), |mark| mark.pos);
    let mut chunks = Chunks::of(func, pos, data);
    chunks.enter();
    let (longest, chunk) = chunks.outer(limit);
    let state = chunks.header(ahead, mark);
    chunks.ways_out(&state, free);
    chunks.way_back(&state, free);
    let ended = chunks.latch(state.count, chunk);
    chunks.after(&ended, longest);
    chunks.dispatch(&ended);
    chunks.lay_out();
}

/// A loop that becomes one of chunks; the lines of the diagram above are its blocks.
struct Chunks<'a> {
    at: At<'a>,
    data: &'a LoopData,
    /// The parameters of the old header, which the new one takes over.
    own: Vec<Value>,
    /// Their types.
    tys: Vec<Ty>,
    /// The ways out, each with the block that takes it.
    ways: Vec<(Block, Target)>,
    /// The types of what the ways out bring, one way after the other.
    brought: Vec<Ty>,
    /// The block that begins with the first chunk.
    entry: Block,
    outer: Block,
    header: Block,
    latch: Block,
    after: Block,
    /// The block that goes on to a longer chunk.
    again: Block,
    /// The block that goes the way out.
    leave: Block,
}

/// The parameters of the new header beyond those of the old one.
struct State {
    count: Value,
    way: Value,
    /// The values that ways out have brought.
    kept: Vec<Value>,
}

/// The parameters of the latch.
struct Ended {
    next: Vec<Value>,
    alive: Value,
    way: Value,
    kept: Vec<Value>,
}

impl<'a> Chunks<'a> {
    fn of(func: &'a mut Function, pos: Pos, data: &'a LoopData) -> Chunks<'a> {
        let own = std::mem::take(&mut func.blocks[data.header].params);
        let exits = data.exits(func).map(|(from, way)| (from, way.clone()));
        let ways: Vec<(Block, Target)> = exits.collect();
        let args = ways.iter().flat_map(|(_, way)| &way.args);
        let brought = args.map(|&v| func.values[v]).collect();
        let tys = own.iter().map(|&p| func.values[p]).collect();
        let mut at = At { func, pos };
        let [entry, outer, header, latch, after, again, leave] = [(); 7].map(|()| at.block());
        Chunks {
            at,
            data,
            own,
            tys,
            ways,
            brought,
            entry,
            outer,
            header,
            latch,
            after,
            again,
            leave,
        }
    }

    /// Begins with the first chunk.
    fn enter(&mut self) {
        let mut args = self.at.params(self.entry, &self.tys);
        args.push(self.at.constant(self.entry, Bits::Word(FIRST_CHUNK)));
        self.at.jump(self.entry, self.outer, args);
    }

    /// Begins a chunk. Returns the length that it may have, and the one that it has: no more than a limit of the loop.
    fn outer(&mut self, limit: Option<&Limit>) -> (Value, Value) {
        let outer = self.outer;
        let mut args = self.at.params(outer, &self.tys);
        let longest = self.at.func.add_param(outer, Ty::Word);
        let chunk = match limit {
            Some(limit) => limit.clip(&mut self.at, outer, &args, longest),
            None => longest,
        };
        args.push(self.at.constant(outer, Bits::Word(0)));
        args.push(self.at.constant(outer, Bits::Pred(true)));
        args.push(self.at.constant(outer, Bits::Word(0)));
        for &ty in &self.brought {
            args.push(self.at.constant(outer, Bits::zero(ty)));
        }
        self.at.jump(outer, self.header, args);
        (longest, chunk)
    }

    /// Begins an iteration of the kernel: goes on to the body while the loop is alive.
    fn header(&mut self, ahead: Ahead, mark: Option<KernelMark>) -> State {
        let header = self.header;
        self.at.func.blocks[header].params.clone_from(&self.own);
        ahead.move_to(self.at.func, header);
        let count = self.at.func.add_param(header, Ty::Word);
        let alive = self.at.func.add_param(header, Ty::Pred);
        let way = self.at.func.add_param(header, Ty::Word);
        let kept = self.at.params(header, &self.brought);
        let gone = self.at.constant(header, Bits::Pred(false));
        let end = Terminator::Branch {
            cond: alive,
            then: Target::to(self.data.header),
            other: self.end_with(&self.own, gone, way, &kept),
        };
        self.at.end(header, end);
        self.at.func.blocks[header].kernel = mark;
        State { count, way, kept }
    }

    /// The jump that ends an iteration.
    fn end_with(&self, next: &[Value], alive: Value, way: Value, kept: &[Value]) -> Target {
        let args = next.iter().chain([&alive, &way]).chain(kept);
        Target {
            block: self.latch,
            args: args.copied().collect(),
        }
    }

    /// The place among the parameters of the latch of the way that was taken.
    fn place_of_way(&self) -> usize {
        self.own.len() + 1
    }

    /// The place among the parameters of the latch of something that a way out brings.
    fn place_of_kept(&self, number: usize) -> usize {
        self.place_of_way() + 1 + number
    }

    /// Takes the ways out, each by a block of its own.
    fn ways_out(&mut self, state: &State, free: &mut Free) {
        let mut dead = vec![self.header];
        let mut start = 0;
        for (number, (from, way)) in (0..).zip(self.ways.clone()) {
            let block = self.at.block();
            let gone = self.at.constant(block, Bits::Pred(false));
            let number = self.at.constant(block, Bits::Word(number));
            let brings = start..start + way.args.len();
            let mut values = state.kept.clone();
            values[brings.clone()].copy_from_slice(&way.args);
            let end = self.end_with(&self.own, gone, number, &values);
            self.at.end(block, Terminator::Jump(end));
            // What another way would bring does not matter on this one.
            let others = (0..values.len()).filter(|other| !brings.contains(other));
            free.extend(others.map(|other| (block, self.latch, self.place_of_kept(other))));
            start = brings.end;
            redirect(self.at.func, from, &way, block);
            self.at.func.layout.push(block);
            dead.push(block);
        }
        let places = 0..self.own.len();
        for block in dead {
            free.extend(places.clone().map(|place| (block, self.latch, place)));
        }
    }

    /// Takes the way back by a block of its own.
    fn way_back(&mut self, state: &State, free: &mut Free) {
        let back = self.at.block();
        let alive = self.at.constant(back, Bits::Pred(true));
        let next = {
            let old = self.data.latches[0];
            let mut targets = self.at.func.blocks[old].end.targets_mut();
            let target = targets.find(|t| t.block == self.data.header);
            std::mem::replace(target.expect("a latch jumps back"), Target::to(back))
        };
        let end = self.end_with(&next.args, alive, state.way, &state.kept);
        self.at.end(back, Terminator::Jump(end));
        let places = self.place_of_way()..self.place_of_kept(state.kept.len());
        free.extend(places.map(|place| (back, self.latch, place)));
        self.at.func.layout.push(back);
    }

    /// Ends an iteration of the kernel: goes back until the chunk is over.
    fn latch(&mut self, count: Value, chunk: Value) -> Ended {
        let latch = self.latch;
        let next = self.at.params(latch, &self.tys);
        let alive = self.at.func.add_param(latch, Ty::Pred);
        let way = self.at.func.add_param(latch, Ty::Word);
        let kept = self.at.params(latch, &self.brought);
        let one = self.at.constant(latch, Bits::Word(1));
        let counted = self.at.op(latch, Opcode::Add, &[count, one]);
        let more = self.at.op(latch, Opcode::Lt, &[counted, chunk]);
        let state = next.iter().chain([&counted, &alive, &way]).chain(&kept);
        let end = Terminator::Branch {
            cond: more,
            then: Target {
                block: self.header,
                args: state.copied().collect(),
            },
            other: Target::to(self.after),
        };
        self.at.end(latch, end);
        Ended {
            next,
            alive,
            way,
            kept,
        }
    }

    /// Goes on behind a chunk: with the next one, which is twice as long, or out.
    fn after(&mut self, ended: &Ended, chunk: Value) {
        let end = Terminator::Branch {
            cond: ended.alive,
            then: Target::to(self.again),
            other: Target::to(self.leave),
        };
        self.at.end(self.after, end);
        let doubled = self.at.op(self.again, Opcode::Add, &[chunk, chunk]);
        let longest = self.at.constant(self.again, Bits::Word(LONGEST_CHUNK));
        let longer = (self.at).op(self.again, Opcode::Minu, &[doubled, longest]);
        let args = ended.next.iter().copied().chain([longer]).collect();
        self.at.jump(self.again, self.outer, args);
        let layout = &mut self.at.func.layout;
        layout.extend([self.latch, self.after, self.again]);
    }

    /// Goes the way out that was taken.
    fn dispatch(&mut self, ended: &Ended) {
        let mut block = self.leave;
        let mut rest = ended.kept.as_slice();
        for (number, (_, way)) in (0..).zip(&self.ways) {
            self.at.func.layout.push(block);
            let (own, more) = rest.split_at(way.args.len());
            rest = more;
            if number as usize + 1 == self.ways.len() {
                self.at.jump(block, way.block, own.to_vec());
                return;
            }
            let number = self.at.constant(block, Bits::Word(number));
            let is = self.at.op(block, Opcode::Eq, &[ended.way, number]);
            let next = self.at.block();
            let end = Terminator::Branch {
                cond: is,
                then: Target {
                    block: way.block,
                    args: own.to_vec(),
                },
                other: Target::to(next),
            };
            self.at.end(block, end);
            block = next;
        }
    }

    /// Puts what comes before the body there, and lets the loop be entered by it.
    fn lay_out(self) {
        let Chunks { at, data, .. } = self;
        enter(at.func, data, self.entry);
        let layout = &mut at.func.layout;
        let place = layout.iter().position(|&b| b == data.header).unwrap_or(1);
        layout.splice(place..place, [self.entry, self.outer, self.header]);
    }
}

/// Lets the jump `to` at the end of a block go to another one instead, and bring nothing.
fn redirect(func: &mut Function, from: Block, to: &Target, block: Block) {
    let mut targets = func.blocks[from].end.targets_mut();
    let found = targets.find(|t| *t == to).expect("it was found there");
    *found = Target::to(block);
}

/// Lets all jumps into a loop from outside go to another block.
fn enter(func: &mut Function, data: &LoopData, entry: Block) {
    for &block in func.layout.iter().filter(|&&b| !data.contains(b)) {
        func.blocks[block].end.retarget(data.header, entry);
    }
}
