//! From a map of deliveries back to the route that it promises.

use super::deliver::Map;
use super::state::{Path, State};
use crate::modulo::problem::Tag;
use crate::modulo::rows::NEVER;
use crate::modulo::table::{Item, Via};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::Place;
use srp_ir::dfg::Node;

/// A point that a route passes.
#[derive(Clone, Copy)]
enum Point {
    /// The value stands in a place.
    Stands(Place, i32),
    /// It stands in registers that are set before the loop.
    Tagged(Place, i32),
    /// It lands in a unit's output.
    Lands(Fu, i32),
}

/// The least of some ways with costs.
struct Least<W> {
    cost: i32,
    way: Option<W>,
}

impl<W> Least<W> {
    fn new() -> Least<W> {
        Least {
            cost: i32::from(NEVER),
            way: None,
        }
    }

    fn offer(&mut self, cost: i32, way: W) {
        if cost < self.cost {
            (self.cost, self.way) = (cost, Some(way));
        }
    }
}

/// Walks back through a map.
pub(super) struct Trace<'t, 'a, 'p> {
    pub(super) state: &'t State<'a, 'p>,
    pub(super) map: &'t Map,
    pub(super) node: Node,
    pub(super) ty: Ty,
    pub(super) tag: Option<Tag>,
    /// True when the map has the prices of values that live long.
    pub(super) lives_long: bool,
}

impl Trace<'_, '_, '_> {
    /// The cheapest route to an operand of a unit that reads in a cycle, in an empty list.
    pub(super) fn to_operand(&self, fu: Fu, at: i32, mut items: Vec<Item>) -> Option<Path> {
        let (read, from) = self.reading(fu, at, self.tag.is_some())?;
        let (place, time, tag) = match from {
            Point::Stands(place, time) => (place, time, Tag::Plain),
            Point::Tagged(place, time) => (place, time, self.tag.unwrap_or(Tag::Plain)),
            Point::Lands(..) => return None,
        };
        if !self.state.problem.is_output(place) {
            items.push(Item::Read(place, time, tag, fu));
        }
        self.back(from, &mut items)?;
        items.reverse();
        Some(Path { items, read, tag })
    }

    /// The cheapest route into a file that keeps the value after the loop, in an empty list.
    pub(super) fn to_keep(&self, place: Place, mut items: Vec<Item>) -> Option<Path> {
        let tag = self.tag?;
        let lane = self.state.lanes.of[place];
        let mut least = Least::new();
        for time in self.map.from..self.map.from + self.map.cycles as i32 {
            least.offer(i32::from(self.map.tagged(time, lane)), time);
        }
        let time = least.way?;
        // It was cheapest when it came in.
        let (via, before) = self.entering(place, time)?;
        items.extend([Item::Kept(place, tag), Item::Written(place, time, tag, via)]);
        self.back(before, &mut items)?;
        items.reverse();
        Some(Path {
            items,
            read: 0,
            tag,
        })
    }

    /// How a unit reads the value in a cycle most cheaply: the path, and where it stands then.
    fn reading(&self, fu: Fu, at: i32, tagged: bool) -> Option<(u32, Point)> {
        let State {
            problem,
            lanes,
            market,
            ..
        } = self.state;
        let mut least = Least::new();
        for (i, path) in problem.graph.reads[fu].iter().enumerate() {
            if path.width < self.ty.bits() || !lanes.has(path.from) {
                continue;
            }
            let (lane, time) = (lanes.of[path.from], at - path.delay as i32);
            let (cost, point) = match tagged {
                true => (self.map.tagged(time, lane), Point::Tagged(path.from, time)),
                false => (self.map.stands(time, lane), Point::Stands(path.from, time)),
            };
            let price = market.price(market.read_good(time, lane));
            least.offer(i32::from(cost) + price, (i as u32, point));
        }
        least.way
    }

    /// How the value gets into a file most cheaply so that it stands there from a cycle on.
    fn entering(&self, place: Place, time: i32) -> Option<(Via, Point)> {
        let problem = self.state.problem;
        let mut least = Least::new();
        for &fu in &self.state.lanes.writers[place] {
            let cost = self.map.lands(time, fu.index());
            least.offer(i32::from(cost), (Via::Result(fu), Point::Lands(fu, time)));
        }
        let in_time = self.state.deadline.is_none_or(|last| time <= last);
        for &(from, i) in self.state.lanes.transfers[place].iter().filter(|_| in_time) {
            let transfer = &problem.graph.transfers[from][i];
            if transfer.width < self.ty.bits() {
                continue;
            }
            let left = time - transfer.delay as i32 - 1;
            let cost = self.map.stands(left, self.state.lanes.of[from]);
            let via = Via::Over(transfer.over);
            least.offer(i32::from(cost), (via, Point::Stands(from, left)));
        }
        least.way
    }

    /// The price of being written into a file and standing there from a cycle on.
    fn enter_price(&self, place: Place, time: i32) -> i32 {
        let market = &self.state.market;
        let lane = self.state.lanes.of[place];
        i32::from(market.enter_row(market.slot(time))[lane])
    }

    /// The price of standing for a cycle where the value stood before.
    fn stay_price(&self, time: i32, lane: usize) -> i32 {
        let market = &self.state.market;
        let slot = market.slot(time);
        let row = match self.lives_long {
            true => market.hold_long_row(slot),
            false => market.hold_row(slot),
        };
        i32::from(row[lane])
    }

    /// The items from a point back to the producer, last first.
    fn back(&self, from: Point, items: &mut Vec<Item>) -> Option<()> {
        let mut point = from;
        loop {
            if self.is_own(point) {
                return self.prefix(point, items);
            }
            point = match point {
                Point::Stands(place, time) => self.before_standing(place, time, items)?,
                Point::Tagged(place, time) => self.before_tagged(place, time, items)?,
                Point::Lands(fu, time) => self.before_landing(fu, time, items)?,
            };
        }
    }

    fn is_own(&self, point: Point) -> bool {
        let lanes = &self.state.lanes.of;
        let cost = match point {
            Point::Stands(place, time) => self.map.stands(time, lanes[place]),
            Point::Tagged(place, time) => self.map.tagged(time, lanes[place]),
            Point::Lands(fu, time) => self.map.lands(time, fu.index()),
        };
        cost == 0
    }

    fn before_standing(&self, place: Place, time: i32, items: &mut Vec<Item>) -> Option<Point> {
        let State { problem, lanes, .. } = self.state;
        let lane = lanes.of[place];
        let mut least = Least::new();
        let hold = self.stay_price(time, lane);
        let held = i32::from(self.map.stands(time - 1, lane)) + hold;
        least.offer(held, (None, Point::Stands(place, time - 1)));
        if problem.is_output(place) {
            items.push(Item::Out(place, time));
            for &fu in &lanes.landers[self.ty as usize][place] {
                let cost = i32::from(self.map.lands(time, fu.index()));
                least.offer(cost, (None, Point::Lands(fu, time)));
            }
        } else {
            items.push(Item::Held(place, time, Tag::Plain));
            if let Some((via, point)) = self.entering(place, time) {
                let cost = self.cost(point) + self.enter_price(place, time);
                least.offer(cost, (Some(via), point));
            }
        }
        let (via, point) = least.way?;
        if let Some(via) = via {
            items.push(Item::Written(place, time, Tag::Plain, via));
        }
        // The output that it lands in is an item of the landing.
        if let Point::Lands(..) = point
            && problem.is_output(place)
        {
            items.pop();
        }
        Some(point)
    }

    fn before_tagged(&self, place: Place, time: i32, items: &mut Vec<Item>) -> Option<Point> {
        let State { lanes, .. } = self.state;
        let tag = self.tag?;
        let lane = lanes.of[place];
        items.push(Item::Held(place, time, tag));
        let mut least = Least::new();
        let hold = self.stay_price(time, lane);
        let held = i32::from(self.map.tagged(time - 1, lane)) + hold;
        least.offer(held, (None, Point::Tagged(place, time - 1)));
        if let Some((via, point)) = self.entering(place, time) {
            let cost = self.cost(point) + self.enter_price(place, time);
            least.offer(cost, (Some(via), point));
        }
        let (via, point) = least.way?;
        if let Some(via) = via {
            items.push(Item::Written(place, time, tag, via));
        }
        Some(point)
    }

    /// The move that lands, and where it takes the value from.
    fn before_landing(&self, fu: Fu, time: i32, items: &mut Vec<Item>) -> Option<Point> {
        let problem = self.state.problem;
        let latency = problem.move_timing(fu, self.ty)?.latency as i32;
        let issue = time - latency;
        let (read, from) = self.reading(fu, issue, false)?;
        items.push(Item::Out(problem.move_place(fu, self.ty), time));
        items.push(Item::Move(fu, issue, read, Tag::Plain));
        if let Point::Stands(place, stood) = from
            && !problem.is_output(place)
        {
            items.push(Item::Read(place, stood, Tag::Plain, fu));
        }
        Some(from)
    }

    fn cost(&self, point: Point) -> i32 {
        let lanes = &self.state.lanes.of;
        i32::from(match point {
            Point::Stands(place, time) => self.map.stands(time, lanes[place]),
            Point::Tagged(place, time) => self.map.tagged(time, lanes[place]),
            Point::Lands(fu, time) => self.map.lands(time, fu.index()),
        })
    }

    /// The way that the value takes already to a point of its own, last item first.
    fn prefix(&self, point: Point, items: &mut Vec<Item>) -> Option<()> {
        let state = self.state;
        let problem = state.problem;
        let (fu, _) = state.at[self.node];
        let ready = state.ready(self.node);
        let op = problem.dfg.nodes[self.node].op;
        let first = Item::Out(problem.graph.result_place(fu, op)?, ready);
        let wanted = match point {
            Point::Lands(unit, time) if (unit, time) == (fu, ready) => first,
            Point::Lands(unit, time) => {
                let latency = problem.move_timing(unit, self.ty)?.latency as i32;
                return self.prefix_to(
                    |item| matches!(item, Item::Move(u, t, ..) if (u, t) == (unit, time - latency)),
                    1,
                    items,
                );
            }
            Point::Stands(place, time) => match problem.is_output(place) {
                true => Item::Out(place, time),
                false => Item::Held(place, time, Tag::Plain),
            },
            Point::Tagged(place, time) => Item::Held(place, time, self.tag?),
        };
        if wanted == first {
            items.push(first);
            return Some(());
        }
        self.prefix_to(|item| item == wanted, 0, items)
    }

    /// The items of the first of the value's routes that has an item, up to it and so many more.
    fn prefix_to(
        &self,
        wanted: impl Fn(Item) -> bool,
        more: usize,
        items: &mut Vec<Item>,
    ) -> Option<()> {
        let state = self.state;
        for &e in &state.problem.edges_of[self.node] {
            if state.problem.edges[e].from != self.node {
                continue;
            }
            let Some(route) = &state.routes[e] else {
                continue;
            };
            if let Some(end) = route.items.iter().position(|&item| wanted(item)) {
                let prefix = &route.items[..=end + more];
                items.extend(prefix.iter().rev());
                return Some(());
            }
        }
        None
    }
}
