//! From a problem to a formula.
//!
//! The encoder makes variables on demand, from the consumers back to the producers: an operand must be
//! read from some place; the value must stand there; and it must have stood there in the cycle before, or
//! arrive. Cycles are those of iteration 0; resources repeat every II cycles.
//!
//! | variable | holds if |
//! |---|---|
//! | `start(n, fu, t)` | node n is issued on unit fu in cycle t |
//! | `issued(n, t)` | node n is issued in cycle t or before |
//! | [`Item::Out`]`(p, t)` | the value stands in the output p in cycle t |
//! | [`Item::Held`]`(f, t, tag)` | a register of the file f holds the value in cycle t |
//! | [`Item::Written`]`(f, t, tag, via)` | the value is written into f, by a result or over a link, and stands there from t on |
//! | [`Item::Read`]`(f, t, tag, fu)` | unit fu reads the value from f in cycle t |
//! | [`Item::Move`]`(fu, t, …)` | unit fu issues a move of the value in cycle t |
//! | [`Item::Wire`]`(p, t, …)` | a wire takes the value in cycle t; there is a place for every number of hops by which it can |
//! | `invariant(f, v)` | the static file f holds the loop invariant v throughout |
//!
//! | clauses | made by |
//! |---|---|
//! | every node starts exactly once | [`Encoder::starts`] |
//! | `issued` is the order encoding of `start`: it rises once, in the cycle of issue | [`Encoder::issued_by`] |
//! | a node starts no earlier than its operands and memory orders allow | [`Encoder::order`] |
//! | a start implies, for each operand, a place from which it is read then | [`Encoder::edge`] |
//! | a live-out is written into a central register | [`Encoder::live_out`] |
//! | each item implies one of its causes: `Out` the same output a cycle before or a landing; `Held` the same file a cycle before or a write; `Written` a landing or an output at the link's start, and `Held`; `Read` `Held`; `Move` a place from which it reads; `Wire` an output or a wire among its inputs | [`Encoder::settle`] |
//! | a move or a result takes its output in the cycle in which it lands | [`Encoder::lands`], [`Encoder::results_land`] |
//! | a result goes into at most one register of a file | [`Encoder::one_write`] |
//! | in every slot of the II, units, outputs, wires, shared resources, registers and ports suffice | [`Encoder::limit_uses`] |

use super::Question;
use super::budget::Budget;
use super::formula::{Formula, Lit};
use super::names;
use crate::modulo::order::Freedom;
use crate::modulo::problem::{Edge, Goal, Problem, Tag, UNREACHABLE, longest_way_out};
use crate::modulo::table::{Item, Via};
use rustc_hash::FxHashMap;
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::{Hop, Place, PlaceKind};
use srp_ir::dfg::{Initial, Node};
use std::collections::BTreeMap;

/// A formula, and the meaning of its variables.
pub(super) struct Encoding {
    pub(super) formula: Formula,
    /// Units and cycles of each node.
    pub(super) starts: EntityMap<Node, Vec<(Fu, i32, Lit)>>,
    /// The items that each value may take. Moves have no read path: number 0. Wires take values from themselves.
    pub(super) items: FxHashMap<(Node, Item), Lit>,
}

/// Encodes a question; `None` where the formula would be too large. `spare` registers of each file
/// are left out.
pub(super) fn encode(
    problem: &Problem<'_>,
    question: &Question<'_>,
    slack: u32,
    freedom: &Freedom,
    spare: &EntityMap<Place, u32>,
) -> Option<Encoding> {
    let mut encoder = Encoder::new(problem, question, slack, freedom);
    encoder.starts()?;
    encoder.order();
    encoder.earliest = problem.nodes().map(|n| encoder.first_at(n)).collect();
    for edge in &problem.edges {
        encoder.edge(edge)?;
    }
    encoder.settle()?;
    encoder.one_write();
    encoder.budget.landings(problem, &encoder.encoding);
    encoder.limit_uses(spare);
    Some(encoder.encoding)
}

struct Encoder<'e, 'p> {
    problem: &'e Problem<'p>,
    question: &'e Question<'e>,
    /// Cycles beyond the critical path in which operations may be issued.
    slack: u32,
    freedom: &'e Freedom,
    encoding: Encoding,
    start: FxHashMap<(Node, Fu, i32), Lit>,
    /// The order variables of each node, one for each cycle of its window but the last, in which it is issued
    /// in any case.
    issued: EntityMap<Node, Vec<Lit>>,
    /// The first cycle in which each value can stand in each place.
    earliest: EntityMap<Node, EntityMap<Place, i32>>,
    /// Variables whose clause is still to be written.
    worklist: Vec<(Node, Item, Lit)>,
    budget: Budget,
    /// Invariants in static files.
    invariants: BTreeMap<(Place, Initial), Lit>,
    /// Live-outs that keep a register of each file.
    kept: EntityMap<Place, u32>,
}

impl<'e, 'p> Encoder<'e, 'p> {
    fn new(
        problem: &'e Problem<'p>,
        question: &'e Question<'e>,
        slack: u32,
        freedom: &'e Freedom,
    ) -> Encoder<'e, 'p> {
        let nodes = problem.dfg.nodes.len();
        Encoder {
            problem,
            question,
            slack,
            freedom,
            encoding: Encoding {
                formula: Formula::new(question.named),
                starts: EntityMap::filled(nodes, Vec::new()),
                items: FxHashMap::default(),
            },
            start: FxHashMap::default(),
            issued: EntityMap::filled(nodes, Vec::new()),
            earliest: EntityMap::new(),
            worklist: Vec::new(),
            budget: Budget::new(problem, question.ii),
            invariants: BTreeMap::new(),
            kept: EntityMap::filled(problem.graph.places.len(), 0),
        }
    }

    fn ii(&self) -> i32 {
        self.question.ii as i32
    }

    /// First and last cycle in which a node may be issued.
    fn window(&self, node: Node) -> (i32, i32) {
        let last = self.freedom.latest[node] + self.slack as i32;
        (self.freedom.earliest[node], last)
    }

    /// A unit and a cycle for every node.
    fn starts(&mut self) -> Option<()> {
        let problem = self.problem;
        for node in problem.nodes() {
            let (first, last) = self.window(node);
            let mut all = Vec::new();
            for time in first..=last {
                let from = all.len();
                for &fu in &problem.units[node] {
                    let timing = problem.timing(node, fu);
                    // A unit that is busy for longer than the II would meet itself in the next iteration.
                    let lands = time + timing.latency as i32;
                    if timing.interval <= self.question.ii && self.question.may_land(lands) {
                        let name = || format!("start {node} {} {time}", problem.srp.fus[fu].name);
                        let literal = self.encoding.formula.variable(name);
                        all.push(literal);
                        self.encoding.starts[node].push((fu, time, literal));
                        self.start.insert((node, fu, time), literal);
                        self.budget.issue(fu, time, timing, literal);
                        self.invariants_of(node, fu, time, literal);
                    }
                }
                self.issued_by(node, time, &all[from..], time == last);
            }
            self.encoding.formula.clause(all.iter().copied());
            self.encoding
                .formula
                .at_most_one(&all, || format!("one {node}"));
            if self.encoding.formula.variables() > self.question.largest_formula() {
                return None;
            }
        }
        Some(())
    }

    /// The order literal of a cycle: it holds from the cycle of issue on, and not before.
    fn issued_by(&mut self, node: Node, time: i32, here: &[Lit], last: bool) {
        let before = self.issued[node].last().copied();
        let formula = &mut self.encoding.formula;
        // Issued in this cycle, so not before.
        if let Some(before) = before {
            here.iter().for_each(|&l| formula.clause([-l, -before]));
        }
        // By the last cycle the node is issued anyway: that needs no variable.
        if last {
            return;
        }
        // issued = before or here.
        let issued = formula.variable(|| format!("issued {node} {time}"));
        here.iter().for_each(|&l| formula.clause([-l, issued]));
        match before {
            Some(before) => {
                formula.clause([-before, issued]);
                formula.clause([-issued, before].into_iter().chain(here.iter().copied()));
            }
            None => formula.clause(std::iter::once(-issued).chain(here.iter().copied())),
        }
        debug_assert_eq!(self.issued[node].len() as i32, time - self.window(node).0);
        self.issued[node].push(issued);
    }

    /// The registers and ports that a node's invariants take on a unit.
    fn invariants_of(&mut self, node: Node, fu: Fu, time: i32, literal: Lit) {
        let Some(needs) = self.problem.needs(node, fu) else {
            return;
        };
        for &wanted in &needs.constants {
            let formula = &mut self.encoding.formula;
            let kept = *(self.invariants.entry(wanted)).or_insert_with(|| {
                let file = self.problem.graph.name(self.problem.srp, wanted.0);
                formula.variable(|| format!("invariant {file} {:?}", wanted.1))
            });
            formula.clause([-literal, kept]);
        }
        for &place in &needs.reads {
            let slot = self.budget.slot(time);
            self.budget.reads[place][slot].push(literal);
        }
    }

    /// Nodes issue in the order that values and memory demand.
    fn order(&mut self) {
        let values = self.problem.edges.iter().filter_map(|e| {
            Some((
                e.from,
                e.to()?,
                e.distance,
                self.problem.min_latency(e.from),
            ))
        });
        let orders = self.problem.orders.iter();
        let all: Vec<(Node, Node, u32, u32)> = values
            .chain(orders.map(|o| (o.from, o.to, o.distance, o.delay)))
            .filter(|(from, to, ..)| from != to)
            .collect();
        for (from, to, distance, delay) in all {
            let (first, last) = self.window(from);
            for time in first..=last {
                // If `from` is issued at `time` or later, then `to` is issued at `least` or later. In order
                // variables: issued(from, time − 1) or not issued(to, least − 1). A literal that its window
                // makes false is left out; a clause that it makes true is skipped.
                let least = time + delay as i32 - self.ii() * distance as i32;
                let (early, latest) = self.window(to);
                if least <= early {
                    continue;
                }
                let mut clause = Vec::new();
                if time > first {
                    clause.push(self.issued[from][(time - first - 1) as usize]);
                }
                if least <= latest {
                    clause.push(-self.issued[to][(least - early - 1) as usize]);
                }
                self.encoding.formula.clause(clause);
            }
        }
    }

    /// The first cycle in which a node's value can stand in each place, by the distances of moves. No variables
    /// are made for earlier cycles, which keeps the formula small.
    fn first_at(&self, node: Node) -> EntityMap<Place, i32> {
        let problem = self.problem;
        let mut first = EntityMap::filled(problem.graph.places.len(), i32::MAX);
        let Some(ty) = problem.dfg.ty(node) else {
            return first;
        };
        for &fu in &problem.units[node] {
            let Some(place) = problem.graph.result_place(fu, problem.dfg.nodes[node].op) else {
                continue;
            };
            let lands = self.window(node).0 + problem.timing(node, fu).latency as i32;
            first[place] = lands.min(first[place]);
            for over in problem.srp.fus.keys() {
                let reach = problem.reach(ty, place, over);
                let Some(timing) = problem
                    .move_timing(over, ty)
                    .filter(|_| reach < UNREACHABLE)
                else {
                    continue;
                };
                let out = problem.move_place(over, ty);
                first[out] = (lands + (reach + timing.latency) as i32).min(first[out]);
            }
        }
        for (fu, files) in problem.graph.writes.iter() {
            let outputs = problem.graph.outputs(fu).map(|out| first[out]).min();
            for &file in files {
                first[file] = first[file].min(outputs.unwrap_or(i32::MAX));
            }
        }
        first_on_wires(problem, ty, &mut first);
        for transfer in problem.graph.transfers.values().flatten() {
            let lands = first[transfer.from].saturating_add(transfer.delay as i32 + 1);
            first[transfer.to] = first[transfer.to].min(lands);
        }
        first
    }

    fn ty(&self, value: Node) -> Ty {
        self.problem.dfg.ty(value).expect("only values are routed")
    }

    /// The variable of an item, made if need be; `None` where it cannot be.
    fn item(&mut self, value: Node, item: Item) -> Option<Lit> {
        let (place, time) = match item {
            Item::Out(place, time)
            | Item::Held(place, time, _)
            | Item::Written(place, time, ..)
            | Item::Wire(place, time, _)
            | Item::Read(place, time, ..) => (place, time),
            Item::Move(fu, time, ..) => {
                let timing = self.problem.move_timing(fu, self.ty(value))?;
                if timing.interval > self.question.ii {
                    return None;
                }
                let out = self.problem.move_place(fu, self.ty(value));
                (out, time + timing.latency as i32)
            }
            Item::Kept(..) => return None,
        };
        let wide = self.problem.graph.places[place].width >= self.ty(value).bits();
        // Too early for the value to be there, or too narrow for it.
        if time < self.earliest[value][place] || !wide {
            return None;
        }
        if matches!(item, Item::Move(..) | Item::Written(..)) && !self.question.may_land(time) {
            return None;
        }
        if let Some(&literal) = self.encoding.items.get(&(value, item)) {
            return Some(literal);
        }
        let problem = self.problem;
        let name = || names::item(problem, value, item);
        let literal = self.encoding.formula.variable(name);
        self.encoding.items.insert((value, item), literal);
        self.worklist.push((value, item, literal));
        match item {
            Item::Move(fu, time, ..) => {
                let timing = self
                    .problem
                    .move_timing(fu, self.ty(value))
                    .expect("it moves");
                self.budget.issue(fu, time, timing, literal);
            }
            item => self.budget.item(item, literal),
        }
        Some(literal)
    }

    /// The variable that lets a unit read a value over one of its paths. Tagged values are those that need a
    /// register set before the loop; they are read from files only.
    fn readable(&mut self, value: Node, fu: Fu, read: usize, tag: Tag, time: i32) -> Option<Lit> {
        let path = self.problem.graph.reads[fu][read];
        if path.width < self.ty(value).bits() {
            return None;
        }
        let stood = time - path.delay as i32;
        match self.problem.graph.places[path.from].kind {
            PlaceKind::File(_) => self.item(value, Item::Read(path.from, stood, tag, fu)),
            _ if tag == Tag::Plain => self.item(value, self.standing(path.from, stood)),
            _ => None,
        }
    }

    /// The item of a value that stands in an output or is taken by a wire.
    fn standing(&self, place: Place, time: i32) -> Item {
        match self.problem.graph.as_wire(place) {
            Some(_) => Item::Wire(place, time, place),
            None => Item::Out(place, time),
        }
    }

    /// The operand, or the live-out, that an edge feeds.
    fn edge(&mut self, edge: &Edge) -> Option<()> {
        match edge.goal {
            Goal::LiveOut(_) => self.live_out(edge),
            Goal::Operand(to, _) => {
                let tag = edge.tag.unwrap_or(Tag::Plain);
                for i in 0..self.encoding.starts[to].len() {
                    let (fu, time, literal) = self.encoding.starts[to][i];
                    // The consumer takes the value of `distance` iterations ago, so in the time of the
                    // producer's iteration it reads that many IIs later.
                    let read_at = time + self.ii() * edge.distance as i32;
                    let mut clause = vec![-literal];
                    for read in 0..self.problem.graph.reads[fu].len() {
                        clause.extend(self.readable(edge.from, fu, read, tag, read_at));
                    }
                    self.encoding.formula.clause(clause);
                }
            }
        }
        (self.encoding.formula.variables() <= self.question.largest_formula()).then_some(())
    }

    /// A live-out must be written into a central register at some time.
    fn live_out(&mut self, edge: &Edge) {
        let tag = edge.tag.expect("live-outs are tagged");
        let mut clause = Vec::new();
        if let Some(central) = self.problem.srp.central(edge.ty) {
            let file = self.problem.graph.file[central];
            self.kept[file] += 1;
            let (_, last) = self.window(edge.from);
            // Some cycles beyond the last result, for moves on the way to the file.
            let last = last + longest_way_out(self.ii());
            for time in self.earliest[edge.from][file]..=last {
                clause.extend(self.writes(edge.from, file, tag, time));
            }
        }
        self.encoding.formula.clause(clause);
    }

    /// All ways to write a value into a file, standing there from a cycle on.
    fn writes(&mut self, value: Node, file: Place, tag: Tag, time: i32) -> Vec<Lit> {
        let problem = self.problem;
        let over = |l: &srp_archdesc::resource::Transfer| l.to == file;
        let fus = problem.srp.fus.keys();
        let results = fus.filter(|&fu| problem.graph.writes[fu].contains(&file));
        let transfers = problem
            .graph
            .transfers
            .values()
            .flatten()
            .filter(|t| over(t));
        let mut vias: Vec<Via> = results.map(Via::Result).collect();
        vias.extend(transfers.map(|t| Via::Over(t.over)));
        // Links and wires lead there from several places that follow each other.
        vias.dedup();
        let item = |via| Item::Written(file, time, tag, via);
        vias.into_iter()
            .filter_map(|via| self.item(value, item(via)))
            .collect()
    }

    /// Writes the clause of every variable: it implies one of its causes. That may make more variables, whose
    /// clauses are written too.
    fn settle(&mut self) -> Option<()> {
        while let Some((value, item, literal)) = self.worklist.pop() {
            let mut clause = vec![-literal];
            match item {
                Item::Out(place, time) => {
                    clause.extend(self.item(value, Item::Out(place, time - 1)));
                    if let PlaceKind::Out(fu) | PlaceKind::PredOut(fu) =
                        self.problem.graph.places[place].kind
                    {
                        clause.extend(self.landings(value, fu, place, time));
                    }
                }
                Item::Held(place, time, tag) => {
                    clause.extend(self.item(value, Item::Held(place, time - 1, tag)));
                    clause.extend(self.writes(value, place, tag, time));
                }
                Item::Written(place, time, tag, via) => {
                    // A live-out keeps its register from then on, which `kept` counts.
                    if !matches!(tag, Tag::LiveOut(_)) {
                        let held = self.item(value, Item::Held(place, time, tag));
                        self.encoding
                            .formula
                            .clause([-literal].into_iter().chain(held));
                    }
                    clause.extend(self.sources(value, place, time, via));
                }
                Item::Read(place, time, tag, _) => {
                    clause.extend(self.item(value, Item::Held(place, time, tag)));
                }
                Item::Move(fu, time, ..) => {
                    for read in 0..self.problem.graph.reads[fu].len() {
                        clause.extend(self.readable(value, fu, read, Tag::Plain, time));
                    }
                    self.lands(value, fu, time, literal);
                }
                Item::Wire(place, time, _) => {
                    let problem = self.problem;
                    let bits = self.ty(value).bits();
                    for hop in problem.onto[place].iter().filter(|hop| hop.width >= bits) {
                        let item = self.standing(hop.from, time - hop.delay as i32);
                        clause.extend(self.item(value, item));
                    }
                }
                Item::Kept(..) => {}
            }
            self.encoding.formula.clause(clause);
            if self.encoding.formula.variables() > self.question.largest_formula() {
                return None;
            }
        }
        self.results_land();
        Some(())
    }

    /// The causes that can bring a value into a unit's output in a cycle: its node's result, or a move.
    fn landings(&mut self, value: Node, fu: Fu, place: Place, time: i32) -> Vec<Lit> {
        let mut all = Vec::new();
        let problem = self.problem;
        let op = problem.dfg.nodes[value].op;
        if problem.units[value].contains(&fu) && problem.graph.result_place(fu, op) == Some(place) {
            let issue = time - problem.timing(value, fu).latency as i32;
            all.extend(self.start.get(&(value, fu, issue)).copied());
        }
        all.extend(self.landing_move(value, fu, time));
        all
    }

    fn landing_move(&mut self, value: Node, fu: Fu, time: i32) -> Option<Lit> {
        let timing = self.problem.move_timing(fu, self.ty(value))?;
        self.item(
            value,
            Item::Move(fu, time - timing.latency as i32, 0, Tag::Plain),
        )
    }

    /// The causes of a write: a landing in the unit's output, or the value in the output at the link's start.
    fn sources(&mut self, value: Node, file: Place, time: i32, via: Via) -> Vec<Lit> {
        let problem = self.problem;
        match via {
            Via::Result(fu) => {
                let op = problem.dfg.nodes[value].op;
                match problem.graph.result_place(fu, op) {
                    Some(place) => self.landings(value, fu, place, time),
                    None => Vec::new(),
                }
            }
            Via::Over(over) => {
                let transfers = problem.graph.transfers.values().flatten();
                let here = transfers.filter(|t| t.over == over && t.to == file);
                let wide = here.filter(|t| t.width >= self.ty(value).bits());
                let stood = wide.map(|t| self.standing(t.from, time - t.delay as i32 - 1));
                let stood: Vec<Item> = stood.collect();
                stood
                    .into_iter()
                    .filter_map(|item| self.item(value, item))
                    .collect()
            }
        }
    }

    /// A move takes the output in the cycle it lands.
    fn lands(&mut self, value: Node, fu: Fu, time: i32, literal: Lit) {
        let ty = self.ty(value);
        let timing = self.problem.move_timing(fu, ty).expect("only movers move");
        let place = self.problem.move_place(fu, ty);
        let standing = self.item(value, Item::Out(place, time + timing.latency as i32));
        let standing = standing.expect("where a move lands it can stand");
        self.encoding.formula.clause([-literal, standing]);
    }

    /// A result takes the output in the cycle in which it lands, if a variable exists for that. The
    /// budget counts the other results.
    fn results_land(&mut self) {
        for (node, starts) in self.encoding.starts.iter() {
            for &(fu, time, literal) in starts {
                let op = self.problem.dfg.nodes[node].op;
                let Some(place) = self.problem.graph.result_place(fu, op) else {
                    continue;
                };
                let lands = time + self.problem.timing(node, fu).latency as i32;
                let standing = self.encoding.items.get(&(node, Item::Out(place, lands)));
                if let Some(&standing) = standing {
                    self.encoding.formula.clause([-literal, standing]);
                }
            }
        }
    }

    /// One result goes into at most one register of a file.
    fn one_write(&mut self) {
        let mut writes: BTreeMap<(Node, Place, i32), Vec<(Tag, Lit)>> = BTreeMap::new();
        for (&(value, item), &literal) in &self.encoding.items {
            if let Item::Written(place, time, tag, _) = item {
                let here = writes.entry((value, place, time)).or_default();
                here.push((tag, literal));
            }
        }
        for mut here in writes.into_values() {
            here.sort_unstable();
            for (i, &(tag, literal)) in here.iter().enumerate() {
                for &(other, theirs) in here[..i].iter().filter(|(other, _)| *other != tag) {
                    debug_assert_ne!(tag, other);
                    self.encoding.formula.clause([-literal, -theirs]);
                }
            }
        }
    }

    /// In every slot of the II, limits the uses of each unit, output, shared resource, register file and port.
    fn limit_uses(&mut self, spare: &EntityMap<Place, u32>) {
        let problem = self.problem;
        let formula = &mut self.encoding.formula;
        let budget = &self.budget;
        for (fu, slots) in budget.issue.iter() {
            for (slot, uses) in slots.iter().enumerate() {
                formula.at_most_one(uses, || {
                    names::slot("issue", &problem.srp.fus[fu].name, slot)
                });
            }
        }
        for (place, slots) in budget.outs.iter() {
            for (slot, uses) in slots.iter().enumerate() {
                let name = || problem.graph.name(problem.srp, place);
                formula.at_most_one(uses, || names::slot("output", &name(), slot));
            }
        }
        for (wire, slots) in budget.wires.iter() {
            for (slot, uses) in slots.iter().enumerate() {
                let name = &problem.srp.wires[wire].name;
                formula.at_most_one(uses, || names::slot("wire", name, slot));
            }
        }
        for (resource, slots) in budget.shared.iter() {
            let spec = &problem.srp.resources[resource];
            for (slot, uses) in slots.iter().enumerate() {
                formula.at_most(spec.count, uses, || names::slot("shared", &spec.name, slot));
            }
        }
        for (file, spec) in problem.srp.files.iter() {
            let place = problem.graph.file[file];
            let fixed = self
                .question
                .fixed
                .iter()
                .filter(|r| r.file == file)
                .count() as u32;
            // Registers that hold something else throughout, that live-outs keep, or that a tightened question
            // leaves out.
            let taken = fixed + self.kept[place] + spare[place];
            let invariants = self.invariants.iter().filter(|((p, _), _)| *p == place);
            let invariants: Vec<Lit> = invariants.map(|(_, &literal)| literal).collect();
            for slot in 0..budget.ii as usize {
                let mut held = budget.held[place][slot].clone();
                held.extend_from_slice(&invariants);
                let label = |what: &'static str| move || names::slot(what, &spec.name, slot);
                formula.at_most(spec.size.saturating_sub(taken), &held, label("registers"));
                let (reads, writes) = (&budget.reads[place][slot], &budget.writes[place][slot]);
                formula.at_most(spec.read_ports, reads, label("reads"));
                formula.at_most(spec.write_ports, writes, label("writes"));
            }
        }
    }
}

/// The first cycle in which a value can be on each wire, by the first in the outputs.
fn first_on_wires(problem: &Problem<'_>, ty: Ty, first: &mut EntityMap<Place, i32>) {
    let hops = problem.graph.hops.values().flatten();
    let hops: Vec<&Hop> = hops.filter(|hop| hop.width >= ty.bits()).collect();
    let mut changed = true;
    while std::mem::take(&mut changed) {
        for hop in &hops {
            let taken = first[hop.from].saturating_add(hop.delay as i32);
            changed |= taken < first[hop.to];
            first[hop.to] = taken.min(first[hop.to]);
        }
    }
}
