//! The router: the cheapest way of a value from its producer to one consumer, through outputs,
//! links, moves and register files, cycle by cycle.
//!
//! Every step goes forward in time (a move takes its latency, a transfer at least a cycle, holding
//! one cycle), so one sweep over the cycles finds shortest paths without a queue. Whatever the value
//! has taken already costs nothing, so a value's routes grow into a tree.

use super::problem::{Problem, Tag, UNREACHABLE};
use super::table::{Item, Table, Via};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::Place;
use srp_ir::dfg::Node;

/// What steps cost. Units and their outputs are what runs out first; registers are cheap.
const MOVE: u32 = 60;
const HOLD_OUT: u32 = 14;
const HOLD_REGISTER: u32 = 2;
const WRITE: u32 = 5;
const TRANSFER: u32 = 8;

/// A way of a value: what it takes, and how the consumer gets it.
#[derive(Clone, Debug)]
pub(super) struct Route {
    /// Items from the producer on, in order.
    pub(super) items: Vec<Item>,
    /// The consumer's read path; meaningless for live-outs.
    pub(super) read: u32,
    /// Which copies in the file it reads, if it reads a file.
    pub(super) tag: Tag,
}

/// A request: route the value of `from`, which stands in the output of `fu` from cycle `ready`.
pub(super) struct Request {
    pub(super) from: Node,
    pub(super) ty: Ty,
    pub(super) fu: Fu,
    pub(super) ready: i32,
    /// The consumer's unit and the cycle in which it reads, in the producer's iteration.
    pub(super) target: Option<(Fu, i32)>,
    /// For carried values and live-outs: which copies in a file may be read.
    pub(super) tag: Option<Tag>,
}

/// Where a step came from: the state before, by its index.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Step {
    Start,
    Hold,
    /// Written into a file as the unit's result, in the cycle it lands in the output.
    Result(Fu),
    /// A move on a unit over one of its read paths, landing in its output.
    Move(Fu, u32),
    /// The same, and written into a file.
    MoveAndWrite(Fu, u32),
    Transfer(u32),
}

#[derive(Clone, Copy)]
struct State {
    cost: u32,
    step: Step,
    before: u32,
}

const UNSEEN: State = State {
    cost: u32::MAX,
    step: Step::Start,
    before: u32::MAX,
};

/// Buffers that are used again from request to request.
#[derive(Default)]
pub(super) struct Router {
    states: Vec<State>,
}

/// One search.
struct Search<'s, 'p> {
    problem: &'s Problem<'p>,
    table: &'s Table,
    request: &'s Request,
    states: &'s mut Vec<State>,
    /// Places, twice: untagged copies, and those of the request's tag.
    width: usize,
    /// The last cycle in which the value may still be on its way.
    last: i32,
    /// Extra cost per place, learned from failures.
    history: &'s EntityMap<Place, u32>,
}

impl Router {
    /// The cheapest route, with its cost.
    pub(super) fn route(
        &mut self,
        problem: &Problem<'_>,
        table: &Table,
        request: &Request,
        history: &EntityMap<Place, u32>,
    ) -> Option<(Route, u32)> {
        let last = match request.target {
            Some((_, arrival)) => arrival,
            None => request.ready + 2 * table.ii as i32 + 8,
        };
        if last < request.ready {
            return None;
        }
        let width = 2 * problem.graph.places.len();
        let length = (last - request.ready + 1) as usize;
        self.states.clear();
        self.states.resize(width * length, UNSEEN);
        Search {
            problem,
            table,
            request,
            states: &mut self.states,
            width,
            last,
            history,
        }
        .run()
    }
}

impl Search<'_, '_> {
    fn run(&mut self) -> Option<(Route, u32)> {
        self.start();
        let mut best: Option<(u32, u32, u32)> = None; // cost, state, read path
        for time in self.request.ready..=self.last {
            let base = (time - self.request.ready) as usize * self.width;
            for index in base..base + self.width {
                let state = self.states[index];
                if state.cost == u32::MAX {
                    continue;
                }
                let (place, tag) = self.place_of(index);
                if let Some((cost, read)) = self.arrives(place, tag, time, state.cost)
                    && best.is_none_or(|(b, ..)| cost < b)
                {
                    best = Some((cost, index as u32, read));
                }
                if best.is_none_or(|(b, ..)| state.cost < b) {
                    self.expand(index, place, tag, time, state.cost);
                }
            }
        }
        best.map(|(cost, state, read)| (self.unwind(state, read), cost))
    }

    fn place_of(&self, index: usize) -> (Place, Tag) {
        let places = self.width / 2;
        let in_row = index % self.width;
        let tag = if in_row < places {
            Tag::Plain
        } else {
            self.tag()
        };
        (Place::new(in_row % places), tag)
    }

    fn tag(&self) -> Tag {
        self.request.tag.unwrap_or(Tag::Plain)
    }

    fn index(&self, place: Place, tag: Tag, time: i32) -> usize {
        let row = if tag == Tag::Plain { 0 } else { self.width / 2 };
        (time - self.request.ready) as usize * self.width + row + place.index()
    }

    fn time_of(&self, index: u32) -> i32 {
        self.request.ready + (index as usize / self.width) as i32
    }

    /// The producer's output, and the files that its result can be written into.
    fn start(&mut self) {
        let Request { fu, ready, .. } = *self.request;
        let op = self.problem.dfg.nodes[self.request.from].op;
        let place = self
            .problem
            .graph
            .result_place(fu, op)
            .expect("a routed value has a place");
        let index = self.index(place, Tag::Plain, ready);
        self.states[index] = State {
            cost: 0,
            step: Step::Start,
            before: u32::MAX,
        };
        self.write_result(fu, ready, index as u32, 0, Step::Result(fu));
    }

    /// Relaxes the files that a result landing in a unit's output at `time` can be written into.
    fn write_result(&mut self, fu: Fu, time: i32, before: u32, cost: u32, step: Step) {
        for i in 0..self.problem.graph.writes[fu].len() {
            let file = self.problem.graph.writes[fu][i];
            for tag in self.tags() {
                if let Some(extra) = self.write_cost(file, time, tag, Via::Result(fu), WRITE) {
                    self.relax(
                        file,
                        tag,
                        time,
                        State {
                            cost: cost + extra,
                            step,
                            before,
                        },
                    );
                }
            }
        }
    }

    /// The tags under which a value may be written into a file.
    fn tags(&self) -> impl Iterator<Item = Tag> + use<> {
        let tagged = (self.tag() != Tag::Plain).then_some(self.tag());
        std::iter::once(Tag::Plain).chain(tagged)
    }

    /// What writing the value into a file costs, or `None` where it does not fit.
    fn write_cost(&self, file: Place, time: i32, tag: Tag, via: Via, price: u32) -> Option<u32> {
        if self.problem.graph.places[file].width < self.request.ty.bits()
            || self
                .table
                .written_otherwise(self.request.from, file, time, tag)
        {
            return None;
        }
        if let Tag::LiveOut(_) = tag {
            let central = self.problem.arch.central(self.request.ty)?;
            if file != self.problem.graph.file[central] {
                return None;
            }
            let kept = self.take_cost(Item::Kept(file, tag), 0)?;
            return Some(kept + self.take_cost(Item::Written(file, time, tag, via), price)?);
        }
        let held = self.take_cost(
            Item::Held(file, time, tag),
            HOLD_REGISTER + self.history[file],
        )?;
        Some(held + self.take_cost(Item::Written(file, time, tag, via), price)?)
    }

    /// The price of an item: nothing if the value has it, `None` if it does not fit.
    fn take_cost(&self, item: Item, price: u32) -> Option<u32> {
        if self.table.has(self.request.from, item) {
            return Some(0);
        }
        self.table
            .fits(self.request.from, item, None)
            .then_some(price)
    }

    /// Whether the consumer can take the value from here; the whole cost and its read path.
    fn arrives(&self, place: Place, tag: Tag, time: i32, cost: u32) -> Option<(u32, u32)> {
        let Some((fu, arrival)) = self.request.target else {
            let done = matches!(tag, Tag::LiveOut(_)) && !self.problem.is_output(place);
            return done.then_some((cost, 0));
        };
        // A carried value must come from a register that was set before the loop.
        if self.request.tag.is_some_and(|t| t != tag) {
            return None;
        }
        let reads = &self.problem.graph.reads[fu];
        let ways = self.problem.readers[place]
            .iter()
            .filter(|(reader, _)| *reader == fu);
        for &(_, read) in ways {
            let path = &reads[read as usize];
            if path.width < self.request.ty.bits() || time + path.delay as i32 != arrival {
                continue;
            }
            if self.problem.is_output(place) {
                return Some((cost, read));
            }
            if let Some(price) = self.take_cost(Item::Read(place, time, tag, fu), 1) {
                return Some((cost + price, read));
            }
        }
        None
    }

    fn relax(&mut self, place: Place, tag: Tag, time: i32, state: State) {
        if time > self.last || !self.in_time(place, time) {
            return;
        }
        let index = self.index(place, tag, time);
        if state.cost < self.states[index].cost {
            self.states[index] = state;
        }
    }

    /// Whether the consumer can still be reached in time.
    fn in_time(&self, place: Place, time: i32) -> bool {
        let Some((fu, arrival)) = self.request.target else {
            return true;
        };
        let reach = self.problem.reach(self.request.ty, place, fu);
        reach != UNREACHABLE && time + reach as i32 <= arrival
    }

    fn expand(&mut self, index: usize, place: Place, tag: Tag, time: i32, cost: u32) {
        if let Tag::LiveOut(_) = tag {
            return;
        }
        let before = index as u32;
        let (item, price) = if self.problem.is_output(place) {
            (Item::Out(place, time + 1), HOLD_OUT)
        } else {
            (Item::Held(place, time + 1, tag), HOLD_REGISTER)
        };
        if let Some(extra) = self.take_cost(item, price + self.history[place]) {
            let state = State {
                cost: cost + extra,
                step: Step::Hold,
                before,
            };
            self.relax(place, tag, time + 1, state);
        }
        if tag != Tag::Plain {
            return;
        }
        self.expand_transfers(place, time, cost, before);
        self.expand_moves(place, time, cost, before);
    }

    fn expand_transfers(&mut self, place: Place, time: i32, cost: u32, before: u32) {
        let problem = self.problem;
        for (i, transfer) in problem.graph.transfers[place].iter().enumerate() {
            let lands = time + transfer.delay as i32 + 1;
            if transfer.width < self.request.ty.bits() || lands > self.last {
                continue;
            }
            for tag in self.tags() {
                let via = Via::Link(transfer.link);
                if let Some(extra) = self.write_cost(transfer.to, lands, tag, via, TRANSFER) {
                    let step = Step::Transfer(i as u32);
                    self.relax(
                        transfer.to,
                        tag,
                        lands,
                        State {
                            cost: cost + extra,
                            step,
                            before,
                        },
                    );
                }
            }
        }
    }

    fn expand_moves(&mut self, place: Place, time: i32, cost: u32, before: u32) {
        let (problem, ty) = (self.problem, self.request.ty);
        for &(fu, read) in &problem.readers[place] {
            let path = &problem.graph.reads[fu][read as usize];
            let Some(timing) = problem
                .move_timing(fu, ty)
                .filter(|_| path.width >= ty.bits())
            else {
                continue;
            };
            let issue = time + path.delay as i32;
            let lands = issue + timing.latency as i32;
            let out = problem.move_place(fu, ty);
            if lands > self.last || !(self.in_time(out, lands) || self.request.target.is_none()) {
                continue;
            }
            let Some(extra) = self.move_cost(place, time, fu, issue, read, lands, timing) else {
                continue;
            };
            let cost = cost + extra;
            self.relax(
                out,
                Tag::Plain,
                lands,
                State {
                    cost,
                    step: Step::Move(fu, read),
                    before,
                },
            );
            self.write_result(fu, lands, before, cost, Step::MoveAndWrite(fu, read));
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn move_cost(
        &self,
        place: Place,
        time: i32,
        fu: Fu,
        issue: i32,
        read: u32,
        lands: i32,
        timing: &srp_archdesc::arch::FuOp,
    ) -> Option<u32> {
        let from = self.request.from;
        let item = Item::Move(fu, issue, read, Tag::Plain);
        let mut cost = if self.table.has(from, item) {
            0
        } else if self.table.issues(fu, issue, timing) {
            MOVE
        } else {
            return None;
        };
        if !self.problem.is_output(place) {
            cost += self.take_cost(Item::Read(place, time, Tag::Plain, fu), 1)?;
        }
        let out = self.problem.move_place(fu, self.request.ty);
        Some(cost + self.take_cost(Item::Out(out, lands), self.history[out])?)
    }

    /// The route that ends in `state`.
    fn unwind(&self, state: u32, read: u32) -> Route {
        let (_, tag) = self.place_of(state as usize);
        let mut items = Vec::new();
        if let Some((fu, _)) = self.request.target {
            let (place, tag) = self.place_of(state as usize);
            if !self.problem.is_output(place) {
                items.push(Item::Read(place, self.time_of(state), tag, fu));
            }
        }
        let mut index = state;
        loop {
            let (place, tag) = self.place_of(index as usize);
            let time = self.time_of(index);
            let State { step, before, .. } = self.states[index as usize];
            self.push_step(&mut items, step, before, place, tag, time);
            if step == Step::Start {
                break;
            }
            index = before;
        }
        items.reverse();
        Route { items, read, tag }
    }

    /// The items of one step, last first.
    fn push_step(
        &self,
        items: &mut Vec<Item>,
        step: Step,
        before: u32,
        place: Place,
        tag: Tag,
        time: i32,
    ) {
        let standing = match tag {
            _ if self.problem.is_output(place) => Item::Out(place, time),
            Tag::LiveOut(_) => Item::Kept(place, tag),
            Tag::Plain | Tag::Initial(_) => Item::Held(place, time, tag),
        };
        items.push(standing);
        match step {
            Step::Start | Step::Hold => {}
            Step::Result(fu) => items.push(Item::Written(place, time, tag, Via::Result(fu))),
            Step::Transfer(i) => {
                let (from, _) = self.place_of(before as usize);
                let link = self.problem.graph.transfers[from][i as usize].link;
                items.push(Item::Written(place, time, tag, Via::Link(link)));
            }
            Step::Move(fu, read) | Step::MoveAndWrite(fu, read) => {
                if let Step::MoveAndWrite(..) = step {
                    items.push(Item::Written(place, time, tag, Via::Result(fu)));
                    items.push(Item::Out(
                        self.problem.move_place(fu, self.request.ty),
                        time,
                    ));
                }
                let (from, _) = self.place_of(before as usize);
                let at = self.time_of(before);
                let delay = self.problem.graph.reads[fu][read as usize].delay as i32;
                items.push(Item::Move(fu, at + delay, read, Tag::Plain));
                if !self.problem.is_output(from) {
                    items.push(Item::Read(from, at, Tag::Plain, fu));
                }
            }
        }
    }
}
