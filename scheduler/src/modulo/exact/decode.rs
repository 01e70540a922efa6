//! From a model back to routes.

use super::Question;
use super::encode::Encoding;
use crate::modulo::order::Freedom;
use crate::modulo::place::{Placement, adopt};
use crate::modulo::problem::{Edge, Goal, Problem, Tag};
use crate::modulo::route::Route;
use crate::modulo::table::{Item, Via};
use srp_archdesc::arch::{Carrier, Fu};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::resource::{Place, PlaceKind};
use srp_ir::dfg::Node;

/// Reads the placement of a model; where registers do not suffice, returns
/// the file of each route that found none.
pub(super) fn decode(
    problem: &Problem<'_>,
    question: &Question<'_>,
    freedom: &Freedom,
    encoding: &Encoding,
    model: &[bool],
) -> Result<Placement, Vec<Place>> {
    let placed = |starts: &Vec<_>| {
        let holds = |&&(_, _, literal): &&(Fu, i32, i32)| model[literal as usize];
        let &(fu, time, _) = starts.iter().find(holds).expect("every node is placed");
        (fu, time)
    };
    let decoder = Decoder {
        problem,
        ii: question.ii as i32,
        encoding,
        model,
        at: encoding.starts.values().map(placed).collect(),
    };
    let routes = problem
        .edges
        .iter()
        .map(|edge| decoder.route(edge))
        .collect();
    adopt(
        problem,
        question.ii,
        freedom,
        question.fixed,
        &decoder.at,
        routes,
    )
}

struct Decoder<'d, 'p> {
    problem: &'d Problem<'p>,
    ii: i32,
    encoding: &'d Encoding,
    model: &'d [bool],
    at: EntityMap<Node, (Fu, i32)>,
}

impl Decoder<'_, '_> {
    fn holds(&self, value: Node, item: Item) -> bool {
        let literal = self.encoding.items.get(&(value, item));
        literal.is_some_and(|&l| self.model[l as usize])
    }

    fn route(&self, edge: &Edge) -> Route {
        let value = edge.from;
        let mut items = Vec::new();
        match edge.goal {
            Goal::LiveOut(_) => {
                let tag = edge.tag.expect("live-outs are tagged");
                let (place, time, via) = self.written_live_out(value, tag);
                items.push(Item::Kept(place, tag));
                self.back_from_write(&mut items, value, place, time, tag, via);
                items.reverse();
                Route::new(items, 0, tag)
            }
            Goal::Operand(to, _) => {
                let (fu, time) = self.at[to];
                let time = time + self.ii * edge.distance as i32;
                let tag = edge.tag.unwrap_or(Tag::Plain);
                let read = self.back_from_read(&mut items, value, fu, tag, time);
                items.reverse();
                let from = self.problem.graph.reads[fu][read as usize].from;
                let tag = if self.problem.is_output(from) {
                    Tag::Plain
                } else {
                    tag
                };
                Route::new(items, read, tag)
            }
        }
    }

    fn written_live_out(&self, value: Node, tag: Tag) -> (Place, i32, Via) {
        let mut all: Vec<(i32, Place, Via)> = Vec::new();
        for (&(v, item), &literal) in &self.encoding.items {
            if let Item::Written(place, time, t, via) = item
                && v == value
                && t == tag
                && self.model[literal as usize]
            {
                all.push((time, place, via));
            }
        }
        let (time, place, via) = all.into_iter().min().expect("a live-out is written");
        (place, time, via)
    }

    /// Follows a value from where a unit reads it; the items go in last first.
    fn back_from_read(
        &self,
        items: &mut Vec<Item>,
        value: Node,
        fu: Fu,
        tag: Tag,
        time: i32,
    ) -> u32 {
        for (read, path) in self.problem.graph.reads[fu].iter().enumerate() {
            let stood = time - path.delay as i32;
            match self.problem.graph.places[path.from].kind {
                PlaceKind::File(_) => {
                    let item = Item::Read(path.from, stood, tag, fu);
                    if self.holds(value, item) {
                        items.push(item);
                        self.back_from_file(items, value, path.from, stood, tag);
                        return read as u32;
                    }
                }
                PlaceKind::Out(_) | PlaceKind::PredOut(_) => {
                    if tag == Tag::Plain && self.holds(value, Item::Out(path.from, stood)) {
                        self.back_from_output(items, value, path.from, stood);
                        return read as u32;
                    }
                }
                PlaceKind::Wire { .. } => {
                    if tag == Tag::Plain && self.is_on_wire(value, path.from, stood) {
                        self.back_from_wire(items, value, path.from, stood);
                        return read as u32;
                    }
                }
            }
        }
        unreachable!("the formula gives every operand something to read")
    }

    fn back_from_file(
        &self,
        items: &mut Vec<Item>,
        value: Node,
        place: Place,
        mut time: i32,
        tag: Tag,
    ) {
        loop {
            items.push(Item::Held(place, time, tag));
            let fus = self.problem.srp.fus.keys().map(Via::Result);
            let links = self.problem.srp.links.keys().map(Carrier::Link);
            let wires = self.problem.srp.wires.keys().map(Carrier::Wire);
            let over = links.chain(wires).map(Via::Over);
            let written = |&via: &Via| self.holds(value, Item::Written(place, time, tag, via));
            if let Some(via) = fus.chain(over).find(written) {
                return self.back_from_write(items, value, place, time, tag, via);
            }
            time -= 1;
        }
    }

    fn back_from_write(
        &self,
        items: &mut Vec<Item>,
        value: Node,
        place: Place,
        time: i32,
        tag: Tag,
        via: Via,
    ) {
        items.push(Item::Written(place, time, tag, via));
        match via {
            Via::Over(over) => {
                let transfers = self.problem.graph.transfers.values().flatten();
                let mut here = transfers.filter(|t| t.over == over && t.to == place);
                let stood = |t: &srp_archdesc::resource::Transfer| time - t.delay as i32 - 1;
                let from = here
                    .find(|t| self.stands(value, t.from, stood(t)))
                    .expect("a transfer has a source");
                match self.problem.is_output(from.from) {
                    true => self.back_from_output(items, value, from.from, stood(from)),
                    false => self.back_from_wire(items, value, from.from, stood(from)),
                }
            }
            Via::Result(fu) => {
                let place = self.landing_place(value, fu, time);
                self.back_from_landing(items, value, fu, place, time);
            }
        }
    }

    fn is_on_wire(&self, value: Node, place: Place, time: i32) -> bool {
        self.holds(value, Item::Wire(place, time, place))
    }

    /// True if a value stands in an output or is taken by a wire.
    fn stands(&self, value: Node, place: Place, time: i32) -> bool {
        self.holds(value, Item::Out(place, time)) || self.is_on_wire(value, place, time)
    }

    /// Follows a value back from a wire to the output from which it came onto the first.
    fn back_from_wire(&self, items: &mut Vec<Item>, value: Node, mut place: Place, mut time: i32) {
        let ty = self.problem.dfg.ty(value).expect("only values are routed");
        while !self.problem.is_output(place) {
            let mut wide = (self.problem.onto[place].iter()).filter(|hop| hop.width >= ty.bits());
            let hop = wide
                .find(|hop| self.stands(value, hop.from, time - hop.delay as i32))
                .expect("a wire takes what stands somewhere");
            items.push(Item::Wire(place, time, hop.from));
            (place, time) = (hop.from, time - hop.delay as i32);
        }
        self.back_from_output(items, value, place, time);
    }

    /// The output that a value lands in on a unit: its own result's, or a move's.
    fn landing_place(&self, value: Node, fu: Fu, time: i32) -> Place {
        let (unit, issue) = self.at[value];
        let ty = self.problem.dfg.ty(value).expect("only values are routed");
        if unit == fu && issue + self.problem.timing(value, fu).latency as i32 == time {
            let op = self.problem.dfg.nodes[value].op;
            self.problem
                .graph
                .result_place(fu, op)
                .expect("it has a result")
        } else {
            self.problem.move_place(fu, ty)
        }
    }

    fn back_from_output(&self, items: &mut Vec<Item>, value: Node, place: Place, mut time: i32) {
        let (PlaceKind::Out(fu) | PlaceKind::PredOut(fu)) = self.problem.graph.places[place].kind
        else {
            unreachable!("only outputs are asked");
        };
        while !self.landed(value, fu, place, time) {
            items.push(Item::Out(place, time));
            time -= 1;
        }
        self.back_from_landing(items, value, fu, place, time);
    }

    fn landed(&self, value: Node, fu: Fu, place: Place, time: i32) -> bool {
        let (unit, issue) = self.at[value];
        let op = self.problem.dfg.nodes[value].op;
        let own = unit == fu
            && self.problem.graph.result_place(fu, op) == Some(place)
            && issue + self.problem.timing(value, fu).latency as i32 == time;
        own || self.moved(value, fu, time).is_some()
    }

    /// The cycle in which a move was issued that lands now.
    fn moved(&self, value: Node, fu: Fu, time: i32) -> Option<i32> {
        let ty = self.problem.dfg.ty(value)?;
        let issue = time - self.problem.move_timing(fu, ty)?.latency as i32;
        (self.holds(value, Item::Move(fu, issue, 0, Tag::Plain))).then_some(issue)
    }

    fn back_from_landing(
        &self,
        items: &mut Vec<Item>,
        value: Node,
        fu: Fu,
        place: Place,
        time: i32,
    ) {
        items.push(Item::Out(place, time));
        let (unit, issue) = self.at[value];
        if unit == fu && issue + self.problem.timing(value, fu).latency as i32 == time {
            return;
        }
        let issue = self
            .moved(value, fu, time)
            .expect("what did not issue here was moved");
        let before = items.len();
        items.push(Item::Move(fu, issue, 0, Tag::Plain));
        let read = self.back_from_read(items, value, fu, Tag::Plain, issue);
        items[before] = Item::Move(fu, issue, read, Tag::Plain);
    }
}
