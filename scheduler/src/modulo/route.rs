//! The router: the cheapest way of a value from its producer to one consumer, through outputs,
//! links, wires, moves and register files, cycle by cycle.
//!
//! Best-first search by the cost so far plus a lower bound: the cost of holding the value for the
//! rest of the time. Items that the value has taken already cost nothing, so a value's routes grow
//! into a tree.

use super::problem::{MoveWay, Problem, Tag, UNREACHABLE};
use super::table::{Item, Table, Via};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::{Place, PlaceKind};
use srp_ir::dfg::Node;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Costs of steps. Units and their outputs are scarce; registers are cheap.
pub(super) const MOVE: u32 = 60;
const HOLD_OUT: u32 = 14;
const HOLD_REGISTER: u32 = 2;
const WRITE: u32 = 5;
const TRANSFER: u32 = 8;
const HOP: u32 = 6;

/// The price of holding a value, where that is cheapest.
pub(super) fn holding_price(cycles: u32) -> u32 {
    HOLD_REGISTER * cycles
}

/// The price of a move that takes so many cycles.
pub(super) fn move_price(cycles: u32) -> u32 {
    MOVE.max(holding_price(cycles))
}

/// The price of a transfer that takes so many cycles.
pub(super) fn transfer_price(cycles: u32) -> u32 {
    TRANSFER.max(holding_price(cycles))
}

/// The price of a hop that takes so many cycles.
pub(super) fn hop_price(cycles: u32) -> u32 {
    HOP.max(holding_price(cycles))
}

/// A way of a value: the items it takes, and how the consumer gets it.
#[derive(Clone, Debug)]
pub(super) struct Route {
    /// Items from the producer on, in order.
    pub(super) items: Vec<Item>,
    /// The consumer's read path; meaningless for live-outs.
    pub(super) read: u32,
    /// Which copies in the file it reads, if it reads a file.
    pub(super) tag: Tag,
    /// Stays in files: file, tag, first and last cycle.
    pub(super) runs: Vec<(Place, Tag, (i32, i32))>,
    /// The file that keeps a live-out.
    pub(super) kept: Option<(Place, Tag)>,
}

impl Route {
    pub(super) fn new(items: Vec<Item>, read: u32, tag: Tag) -> Route {
        let mut runs: Vec<(Place, Tag, (i32, i32))> = Vec::new();
        let mut kept = None;
        for &item in &items {
            match item {
                Item::Held(place, time, tag) => match runs.last_mut() {
                    Some((p, t, run)) if (*p, *t, run.1 + 1) == (place, tag, time) => run.1 = time,
                    _ => runs.push((place, tag, (time, time))),
                },
                Item::Kept(place, tag) => kept = Some((place, tag)),
                _ => {}
            }
        }
        Route {
            items,
            read,
            tag,
            runs,
            kept,
        }
    }
}

/// A request: route the value of `from`, which stands in the output of `fu` from cycle `ready`.
pub(super) struct Request {
    pub(super) from: Node,
    pub(super) ty: Ty,
    pub(super) fu: Fu,
    pub(super) ready: i32,
    /// The consumer's unit and the cycle in which it reads, in the producer's iteration.
    pub(super) target: Option<(Fu, i32)>,
    /// The last cycle in which a move or a transfer of the value may land.
    pub(super) until: i32,
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
    /// On to a wire.
    Hop,
}

#[derive(Clone, Copy)]
struct State {
    cost: u32,
    step: Step,
    before: u32,
    /// The cycle in which the value came to this place, and the cycles for which it has stood there on its way,
    /// now and before.
    since: i32,
    stayed: i32,
    /// The request that reached it; what an earlier one left does not count.
    request: u32,
}

const UNSEEN: State = State {
    cost: u32::MAX,
    step: Step::Start,
    before: u32::MAX,
    since: 0,
    stayed: 0,
    request: 0,
};

/// An open state: least whole cost, cycles left (so that, of equals, the furthest comes first),
/// cost so far, index.
type Open = Reverse<(u32, u32, u32, u32)>;

/// Buffers that are used again from request to request.
#[derive(Default)]
pub(super) struct Router {
    states: Vec<State>,
    open: BinaryHeap<Open>,
    requests: u32,
    /// States expanded so far, the measure of effort.
    pub(super) expanded: u64,
}

/// States that are expanded for one route at most, and for each of its cycles if these are more: a longer search
/// finds only ways that are too long, and a shorter one none to a consumer that is a long loop later.
const LARGEST_SEARCH: u32 = 3000;
const OF_A_CYCLE: u32 = 96;

/// One search.
struct Search<'s, 'p> {
    problem: &'s Problem<'p>,
    table: &'s Table,
    request: &'s Request,
    states: &'s mut Vec<State>,
    open: &'s mut BinaryHeap<Open>,
    number: u32,
    /// Places; twice if the request has a tag: untagged copies first.
    width: usize,
    /// The cycle from which on nothing the value has could make holding it free.
    paid_from: i32,
    /// The last cycle in which the value may still be on its way.
    last: i32,
    /// Files that are out of the question.
    banned: &'s [Place],
    /// True where a way is not to meet itself, as ways of many IIs do.
    is_careful: bool,
}

impl Router {
    /// The cheapest route, with its cost. One that is not careful may meet itself an II later.
    pub(super) fn route(
        &mut self,
        problem: &Problem<'_>,
        table: &Table,
        request: &Request,
        banned: &[Place],
        is_careful: bool,
    ) -> Option<(Route, u32)> {
        let last = match request.target {
            Some((_, arrival)) => arrival,
            None => request.until,
        };
        if last < request.ready {
            return None;
        }
        let width = problem.graph.places.len() * (1 + usize::from(request.tag.is_some()));
        let length = (last - request.ready + 1) as usize;
        if self.states.len() < width * length {
            self.states.resize(width * length, UNSEEN);
        }
        self.open.clear();
        self.requests += 1;
        Search {
            problem,
            table,
            request,
            states: &mut self.states,
            open: &mut self.open,
            number: self.requests,
            width,
            paid_from: table.last_cycle(request.from).max(request.ready),
            last,
            banned,
            is_careful,
        }
        .run(&mut self.expanded)
    }
}

impl Search<'_, '_> {
    fn run(&mut self, expanded: &mut u64) -> Option<(Route, u32)> {
        self.start();
        let cycles = (self.last - self.request.ready) as u32;
        let mut left = LARGEST_SEARCH.max(OF_A_CYCLE.saturating_mul(cycles));
        let mut best: Option<(u32, u32, u32)> = None; // cost, state, read path
        while let Some(Reverse((least, _, cost, index))) = self.open.pop() {
            if best.is_some_and(|(b, ..)| least >= b) {
                break;
            }
            if cost > self.states[index as usize].cost {
                continue;
            }
            let time = self.time_of(index);
            let (place, tag) = self.place_of(index as usize);
            if let Some((cost, read)) = self.arrives(place, tag, time, cost)
                && best.is_none_or(|(b, ..)| cost < b)
            {
                best = Some((cost, index, read));
            }
            if left == 0 {
                break;
            }
            left -= 1;
            *expanded += 1;
            self.expand(index as usize, place, tag, time, cost);
        }
        best.map(|(cost, state, read)| (self.unwind(state, read), cost))
    }

    /// Returns a lower bound on the cost of the rest of the way. Items that the value already has
    /// are free.
    fn rest(&self, place: Place, time: i32) -> u32 {
        let Some((fu, arrival)) = self.request.target else {
            return 0;
        };
        let cycles = arrival - self.problem.longest_read - time.max(self.paid_from);
        let holding = holding_price(cycles.max(0) as u32);
        if time < self.paid_from {
            holding
        } else {
            holding + self.problem.detour(self.request.ty, place, fu)
        }
    }

    /// The cost of a state so far.
    fn cost_of(&self, index: usize) -> u32 {
        let state = &self.states[index];
        if state.request == self.number {
            state.cost
        } else {
            u32::MAX
        }
    }

    fn place_of(&self, index: usize) -> (Place, Tag) {
        let places = self.problem.graph.places.len();
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
        let row = if tag == Tag::Plain {
            0
        } else {
            self.problem.graph.places.len()
        };
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
        self.relax(place, Tag::Plain, ready, 0, Step::Start, u32::MAX);
        let index = self.index(place, Tag::Plain, ready);
        self.write_result(fu, ready, index as u32, 0, Step::Result(fu));
    }

    /// Relaxes the files that a result landing in a unit's output at `time` can be written into.
    fn write_result(&mut self, fu: Fu, time: i32, before: u32, cost: u32, step: Step) {
        for i in 0..self.problem.graph.writes[fu].len() {
            let file = self.problem.graph.writes[fu][i];
            for tag in self.tags() {
                if !self.improves(file, tag, time, cost) {
                    continue;
                }
                if let Some(extra) = self.write_cost(file, time, tag, Via::Result(fu), WRITE) {
                    self.relax(file, tag, time, cost + extra, step, before);
                }
            }
        }
    }

    /// The tags under which a value may be written into a file.
    fn tags(&self) -> impl Iterator<Item = Tag> + use<> {
        let tagged = (self.tag() != Tag::Plain).then_some(self.tag());
        std::iter::once(Tag::Plain).chain(tagged)
    }

    /// Returns the cost of writing the value into a file; `None` if it does not fit.
    fn write_cost(&self, file: Place, time: i32, tag: Tag, via: Via, price: u32) -> Option<u32> {
        if self.problem.graph.places[file].width < self.request.ty.bits()
            || self.banned.contains(&file)
            || self
                .table
                .written_otherwise(self.request.from, file, time, tag)
        {
            return None;
        }
        if let Tag::LiveOut(_) = tag {
            let central = self.problem.srp.central(self.request.ty)?;
            if file != self.problem.graph.file[central] {
                return None;
            }
            let kept = self.take_cost(Item::Kept(file, tag), 0)?;
            return Some(kept + self.take_cost(Item::Written(file, time, tag, via), price)?);
        }
        let held = self.take_cost(Item::Held(file, time, tag), HOLD_REGISTER)?;
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

    /// Returns the whole cost and the read path if the consumer can take the value from here.
    fn arrives(&self, place: Place, tag: Tag, time: i32, cost: u32) -> Option<(u32, u32)> {
        let Some((fu, arrival)) = self.request.target else {
            let done = matches!(tag, Tag::LiveOut(_)) && self.problem.is_file(place);
            return done.then_some((cost, 0));
        };
        // A carried value must come from a register that was set before the loop.
        if time + self.problem.longest_read < arrival || self.request.tag.is_some_and(|t| t != tag)
        {
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
            if !self.problem.is_file(place) {
                return Some((cost, read));
            }
            if let Some(price) = self.take_cost(Item::Read(place, time, tag, fu), 1) {
                return Some((cost + price, read));
            }
        }
        None
    }

    /// True if a way to this state at this cost, or more, can be of use.
    fn improves(&self, place: Place, tag: Tag, time: i32, cost: u32) -> bool {
        time <= self.last
            && self.in_time(place, time)
            && cost < self.cost_of(self.index(place, tag, time))
    }

    fn relax(&mut self, place: Place, tag: Tag, time: i32, cost: u32, step: Step, before: u32) {
        let index = self.index(place, tag, time);
        if cost < self.cost_of(index) {
            let request = self.number;
            let (since, stayed) = match step {
                Step::Hold => {
                    let State { since, stayed, .. } = self.states[before as usize];
                    (since, stayed + 1)
                }
                _ => (time, self.stays_before(place, time, before) + 1),
            };
            let output = match step {
                Step::Move(fu, _) | Step::MoveAndWrite(fu, _) => Some(self.move_place(fu)),
                _ => Some(place).filter(|&place| !self.problem.is_file(place)),
            };
            if output.is_some_and(|output| self.is_in_own_way(output, time, before))
                || !self.may_stay(place, stayed)
            {
                return;
            }
            self.states[index] = State {
                cost,
                step,
                before,
                since,
                stayed,
                request,
            };
            let left = (self.last - time) as u32;
            self.open.push(Reverse((
                cost + self.rest(place, time),
                left,
                cost,
                index as u32,
            )));
        }
    }

    /// True if the consumer can still be reached in time.
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
        let holds = match self.problem.graph.places[place].kind {
            PlaceKind::File(_) => Some((Item::Held(place, time + 1, tag), HOLD_REGISTER)),
            PlaceKind::Out(_) | PlaceKind::PredOut(_) => {
                Some((Item::Out(place, time + 1), HOLD_OUT))
            }
            PlaceKind::Wire { .. } => None,
        };
        if let Some((item, price)) = holds
            && self.improves(place, tag, time + 1, cost)
            && let Some(extra) = self.take_cost(item, price)
        {
            self.relax(place, tag, time + 1, cost + extra, Step::Hold, before);
        }
        if tag != Tag::Plain {
            return;
        }
        self.expand_hops(place, time, cost, before);
        self.expand_transfers(place, time, cost, before);
        self.expand_moves(place, time, cost, before);
    }

    /// True if a file has registers for a value that stands in it for so many cycles: instances of later
    /// iterations come while it stays.
    fn may_stay(&self, place: Place, cycles: i32) -> bool {
        !self.is_careful
            || cycles <= self.table.ii as i32
            || cycles <= self.problem.longest_stay_in(self.table.ii, place)
    }

    /// Returns for how many cycles a value that comes to a place has stood there before.
    fn stays_before(&self, place: Place, time: i32, before: u32) -> i32 {
        let last =
            (self.stays(time, before)).find(|&index| self.place_of(index as usize).0 == place);
        last.map_or(0, |index| self.states[index as usize].stayed)
    }

    /// True if a value that stands in an output or on a wire meets itself there: an instance of another iteration.
    fn is_in_own_way(&self, output: Place, time: i32, before: u32) -> bool {
        let graph = &self.problem.graph;
        let wire = graph.as_wire(output);
        let is_same =
            |place: Place| place == output || wire.is_some() && graph.as_wire(place) == wire;
        let ii = self.table.ii as i32;
        self.stays(time, before).any(|last| {
            let since = self.states[last as usize].since;
            let until = self.time_of(last);
            let entered = last as usize - (until - since) as usize * self.width;
            let cycles = match self.states[entered].step {
                _ if is_same(self.place_of(entered).0) => until - since,
                // What is written into a file stands in the output for the cycle too.
                Step::MoveAndWrite(fu, _) if self.move_place(fu) == output => 0,
                _ => return false,
            };
            since < time && (cycles + 1 >= ii || (time - since).rem_euclid(ii) <= cycles)
        })
    }

    fn move_place(&self, fu: Fu) -> Place {
        self.problem.move_place(fu, self.request.ty)
    }

    /// The last states of the stays on the way to a state that follows `before` at this time, the latest stay
    /// first; none on ways shorter than the II, on which no value meets itself, and none if nobody cares.
    fn stays(&self, time: i32, before: u32) -> impl Iterator<Item = u32> {
        let is_long = time - self.request.ready >= self.table.ii as i32;
        let first = Some(before).filter(|&index| self.is_careful && is_long && index != u32::MAX);
        std::iter::successors(first, |&index| {
            let stay = self.time_of(index) - self.states[index as usize].since;
            let entered = index as usize - stay as usize * self.width;
            Some(self.states[entered].before).filter(|&index| index != u32::MAX)
        })
    }

    fn expand_hops(&mut self, place: Place, time: i32, cost: u32, before: u32) {
        let problem = self.problem;
        for hop in &problem.graph.hops[place] {
            let taken = time + hop.delay as i32;
            if hop.width < self.request.ty.bits() || !self.improves(hop.to, Tag::Plain, taken, cost)
            {
                continue;
            }
            let item = Item::Wire(hop.to, taken, place);
            if let Some(extra) = self.take_cost(item, hop_price(hop.delay)) {
                self.relax(hop.to, Tag::Plain, taken, cost + extra, Step::Hop, before);
            }
        }
    }

    fn expand_transfers(&mut self, place: Place, time: i32, cost: u32, before: u32) {
        let problem = self.problem;
        for (i, transfer) in problem.graph.transfers[place].iter().enumerate() {
            let lands = time + transfer.delay as i32 + 1;
            if transfer.width < self.request.ty.bits() || lands > self.request.until {
                continue;
            }
            for tag in self.tags() {
                if !self.improves(transfer.to, tag, lands, cost) {
                    continue;
                }
                let via = Via::Over(transfer.over);
                let price = transfer_price(transfer.delay + 1);
                if let Some(extra) = self.write_cost(transfer.to, lands, tag, via, price) {
                    let step = Step::Transfer(i as u32);
                    self.relax(transfer.to, tag, lands, cost + extra, step, before);
                }
            }
        }
    }

    fn expand_moves(&mut self, place: Place, time: i32, cost: u32, before: u32) {
        let problem = self.problem;
        for way in &problem.moves[self.request.ty as usize][place] {
            let lands = time + way.cycles;
            if lands > self.request.until || !self.in_time(way.out, lands) {
                continue;
            }
            let Some(extra) = self.move_cost(place, time, way) else {
                continue;
            };
            let cost = cost + extra;
            let step = Step::Move(way.fu, way.read);
            self.relax(way.out, Tag::Plain, lands, cost, step, before);
            let step = Step::MoveAndWrite(way.fu, way.read);
            self.write_result(way.fu, lands, before, cost, step);
        }
    }

    fn move_cost(&self, place: Place, time: i32, way: &MoveWay<'_>) -> Option<u32> {
        let issue = time + way.delay;
        let item = Item::Move(way.fu, issue, way.read, Tag::Plain);
        let mut cost = if self.table.has(self.request.from, item) {
            0
        } else if self.table.issues(way.fu, issue, way.timing) {
            move_price(way.cycles as u32)
        } else {
            return None;
        };
        if self.problem.is_file(place) {
            cost += self.take_cost(Item::Read(place, time, Tag::Plain, way.fu), 1)?;
        }
        let lands = time + way.cycles;
        Some(cost + self.take_cost(Item::Out(way.out, lands), 0)?)
    }

    /// The route that ends in `state`.
    fn unwind(&self, state: u32, read: u32) -> Route {
        let (_, tag) = self.place_of(state as usize);
        let mut items = Vec::new();
        if let Some((fu, _)) = self.request.target {
            let (place, tag) = self.place_of(state as usize);
            if self.problem.is_file(place) {
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
        Route::new(items, read, tag)
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
            _ if step == Step::Hop => Item::Wire(place, time, self.place_of(before as usize).0),
            _ if self.problem.is_output(place) => Item::Out(place, time),
            Tag::LiveOut(_) => Item::Kept(place, tag),
            Tag::Plain | Tag::Initial(_) => Item::Held(place, time, tag),
        };
        items.push(standing);
        match step {
            Step::Start | Step::Hold | Step::Hop => {}
            Step::Result(fu) => items.push(Item::Written(place, time, tag, Via::Result(fu))),
            Step::Transfer(i) => {
                let (from, _) = self.place_of(before as usize);
                let over = self.problem.graph.transfers[from][i as usize].over;
                items.push(Item::Written(place, time, tag, Via::Over(over)));
            }
            Step::Move(fu, read) | Step::MoveAndWrite(fu, read) => {
                if let Step::MoveAndWrite(..) = step {
                    items.push(Item::Written(place, time, tag, Via::Result(fu)));
                    items.push(Item::Out(self.move_place(fu), time));
                }
                let (from, _) = self.place_of(before as usize);
                let at = self.time_of(before);
                let delay = self.problem.graph.reads[fu][read as usize].delay as i32;
                items.push(Item::Move(fu, at + delay, read, Tag::Plain));
                if self.problem.is_file(from) {
                    items.push(Item::Read(from, at, Tag::Plain, fu));
                }
            }
        }
    }
}
