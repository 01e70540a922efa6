//! A run of a kernel with tokens: which value of which iteration stands where, cycle by cycle.
//!
//! A few trip counts suffice: small ones, in which filling and draining overlap, and one that goes
//! through every register of every ring and rotating file after the pipeline is full. From there on
//! everything repeats.

use super::table::contexts;
use super::{Checker, MAX_STEPS};
use crate::check::Rule;
use crate::dfg::{Initial, Node, Operand};
use crate::dre::scheduled::{Placed, PlacedHop, PlacedOp, PlacedTransfer, RegAt, Source};
use crate::program::Bits;
use srp_archdesc::arch::{Carrier, FileKind, Input, RegFile, Wire};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::resource::Place;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// The content of a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Token {
    /// The result of a node in an iteration.
    Value(Node, i64),
    Const(Bits),
    LiveIn(u32),
}

/// Returns the token of an initial value; `None` if nothing depends on it.
fn initial(value: Initial) -> Option<Token> {
    match value {
        Initial::Const(bits) => Some(Token::Const(bits)),
        Initial::LiveIn(k) => Some(Token::LiveIn(k)),
        Initial::Any => None,
    }
}

impl fmt::Display for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Token::Value(node, i) => write!(f, "{node} of iteration {i}"),
            Token::Const(bits) => write!(f, "{bits}"),
            Token::LiveIn(k) => write!(f, "live-in {k}"),
        }
    }
}

fn show(token: Option<Token>) -> String {
    token.map_or_else(|| "nothing".to_owned(), |t| t.to_string())
}

impl Checker<'_> {
    pub(super) fn run(&mut self) {
        let schedule = self.schedule;
        let distances = schedule.dfg.nodes.values().flat_map(|n| &n.operands);
        let distances = distances.filter_map(Operand::producer).map(|(_, d)| d);
        let distance = distances.max().unwrap_or(0);
        let rotating = self.srp.files.values();
        let rotating = rotating.filter(|f| f.kind == FileKind::Rotating);
        let period =
            contexts(1, &self.rings()).max(rotating.map(|f| u64::from(f.size)).max().unwrap_or(0));
        let stages = u64::from(schedule.length.div_ceil(schedule.ii));
        let long = 2 * stages + period + u64::from(distance) + 1;
        let actions = schedule.ops.len() + schedule.transfers.len() + schedule.hops.len();
        let actions = actions as u64;
        if long * actions.max(1) > MAX_STEPS || long > MAX_STEPS {
            let message = format!("{stages} stages are too many to follow");
            return self.report(Rule::Contexts, message);
        }
        let trips = BTreeSet::from([1, 2, 3, stages, long]);
        for trip in trips {
            let mut run = Run::new(self, trip as i64, i64::from(distance));
            run.go();
            let found = run.found;
            for (op, rule, message) in found {
                match op {
                    Some(op) => self.report_op(op, rule, message),
                    None => self.report(rule, message),
                }
            }
            if !self.violations.is_empty() {
                return;
            }
        }
    }
}

struct Run<'a> {
    checker: &'a Checker<'a>,
    trip: i64,
    /// The largest distance of the loop: iterations from which all values of before exist.
    distance: i64,
    /// Operations, transfers and hops by their cycle modulo the II.
    ops: Vec<Vec<Placed>>,
    transfers: Vec<Vec<PlacedTransfer>>,
    hops: Vec<Vec<PlacedHop>>,
    /// Values that each output received, in order, with the cycle from which it holds them.
    outputs: EntityMap<Place, Vec<(i64, Option<Token>)>>,
    files: EntityMap<RegFile, Vec<Option<Token>>>,
    /// Values under way, by the cycle in which they arrive.
    landing: BTreeMap<i64, Vec<Landing>>,
    found: Vec<(Option<Placed>, Rule, String)>,
    /// Operations that a mistake was found with; one each is enough.
    known: BTreeSet<(Option<Placed>, Rule)>,
}

struct Landing {
    to: Destination,
    /// `None` where a move found nothing.
    token: Option<Token>,
    /// Whose it is.
    op: Option<Placed>,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Destination {
    Output(Place),
    Register(RegFile, u32),
}

impl<'a> Run<'a> {
    fn new(checker: &'a Checker<'a>, trip: i64, distance: i64) -> Run<'a> {
        let schedule = checker.schedule;
        let ii = schedule.ii as usize;
        let mut ops = vec![Vec::new(); ii];
        for (i, op) in schedule.ops.values().enumerate() {
            ops[op.time as usize % ii].push(Placed::new(i));
        }
        let mut transfers = vec![Vec::new(); ii];
        for transfer in &schedule.transfers {
            transfers[transfer.time as usize % ii].push(*transfer);
        }
        let mut hops = vec![Vec::new(); ii];
        for hop in &schedule.hops {
            hops[hop.time as usize % ii].push(*hop);
        }
        let files = checker.srp.files.values();
        let mut files: EntityMap<RegFile, Vec<Option<Token>>> =
            files.map(|f| vec![None; f.size as usize]).collect();
        for (k, reg) in schedule.live_in_regs.iter().enumerate() {
            files[reg.file][reg.index as usize] = Some(Token::LiveIn(k as u32));
        }
        for preload in &schedule.preloads {
            files[preload.file][preload.index as usize] = initial(preload.value);
        }
        Run {
            checker,
            trip,
            distance,
            ops,
            transfers,
            hops,
            outputs: EntityMap::filled(checker.graph.places.len(), Vec::new()),
            files,
            landing: BTreeMap::new(),
            found: Vec::new(),
            known: BTreeSet::new(),
        }
    }

    fn report(&mut self, op: Option<Placed>, rule: Rule, message: String) {
        if self.known.insert((op, rule)) {
            self.found.push((op, rule, message));
        }
    }

    fn go(&mut self) {
        let schedule = self.checker.schedule;
        let ii = i64::from(schedule.ii);
        let end = ii * (self.trip - 1) + i64::from(schedule.length);
        for cycle in 0..end {
            self.land(cycle);
            let slot = (cycle % ii) as usize;
            let mut read: BTreeMap<RegFile, BTreeSet<u32>> = BTreeMap::new();
            for op in self.ops[slot].clone() {
                let placed = &schedule.ops[op];
                let iteration = (cycle - i64::from(placed.time)).div_euclid(ii);
                if (0..self.trip).contains(&iteration) {
                    self.issue(op, placed, cycle, iteration, &mut read);
                }
            }
            for transfer in self.transfers[slot].clone() {
                let iteration = (cycle - i64::from(transfer.time)).div_euclid(ii);
                if (0..self.trip).contains(&iteration) {
                    self.transfer(&transfer, cycle, iteration);
                }
            }
            for hop in self.hops[slot].clone() {
                let iteration = (cycle - i64::from(hop.time)).div_euclid(ii);
                if (0..self.trip).contains(&iteration) {
                    let token = self.on_wire(hop.wire, cycle);
                    self.moved(None, hop.node, token, iteration);
                }
            }
            self.read_ports(&read);
        }
        self.land(end);
        self.live_outs();
    }

    /// Puts the values that arrive in `cycle` in their places.
    fn land(&mut self, cycle: i64) {
        let mut seen: BTreeSet<Destination> = BTreeSet::new();
        let mut arrivals: BTreeMap<RegFile, u32> = BTreeMap::new();
        for landing in self.landing.remove(&cycle).unwrap_or_default() {
            if !seen.insert(landing.to) {
                let message = format!("meets another result in cycle {cycle}");
                self.report(landing.op, Rule::Collision, message);
            }
            match landing.to {
                Destination::Output(place) => {
                    self.outputs[place].push((cycle, landing.token));
                }
                Destination::Register(file, index) => {
                    self.files[file][index as usize] = landing.token;
                    *arrivals.entry(file).or_insert(0) += 1;
                }
            }
        }
        for (file, count) in arrivals {
            let spec = &self.checker.srp.files[file];
            if count > spec.write_ports {
                let (name, ports) = (&spec.name, spec.write_ports);
                let message =
                    format!("{count} results arrive in {name} in cycle {cycle}, {ports} ports");
                self.report(None, Rule::WritePorts, message);
            }
        }
    }

    fn read_ports(&mut self, read: &BTreeMap<RegFile, BTreeSet<u32>>) {
        for (&file, regs) in read {
            let spec = &self.checker.srp.files[file];
            if regs.len() > spec.read_ports as usize {
                let (count, name, ports) = (regs.len(), &spec.name, spec.read_ports);
                let message = format!("{count} registers of {name} are read, {ports} ports");
                self.report(None, Rule::ReadPorts, message);
            }
        }
    }

    fn issue(
        &mut self,
        op: Placed,
        placed: &PlacedOp,
        cycle: i64,
        iteration: i64,
        read: &mut BTreeMap<RegFile, BTreeSet<u32>>,
    ) {
        let checker = self.checker;
        let types = checker.operand_types(placed);
        let mut first = None;
        for (i, (source, ty)) in placed.operands.iter().zip(types).enumerate() {
            let token = match *source {
                Source::Const(bits) => Some(Token::Const(bits)),
                Source::Out(None) => self.standing(checker.output(placed.fu, ty), cycle),
                Source::Out(Some(link)) => {
                    let spec = &checker.srp.links[link];
                    let from = checker.output(spec.from, ty);
                    self.standing(from, cycle - i64::from(spec.delay))
                }
                Source::Wire(wire) => {
                    let delay = checker.srp.wires[wire].delay;
                    self.on_wire(wire, cycle - i64::from(delay))
                }
                Source::Reg { reg, distance } => {
                    let index = self.physical(reg, iteration - i64::from(distance));
                    read.entry(reg.file).or_default().insert(index);
                    self.files[reg.file][index as usize]
                }
            };
            first = first.or(Some(token));
            if !placed.is_move {
                let wanted = self.wanted(placed.node, i, iteration);
                if let Some(wanted) = wanted.filter(|w| token != Some(*w)) {
                    let found = show(token);
                    let message = format!(
                        "operand {i} in iteration {iteration} is {found} instead of {wanted}"
                    );
                    self.report(Some(op), Rule::Dataflow, message);
                }
            }
        }
        let token = if placed.is_move {
            let token = first.flatten();
            self.moved(Some(op), placed.node, token, iteration);
            token
        } else {
            Some(Token::Value(placed.node, iteration))
        };
        let Some(ty) = checker.ty(placed) else {
            return;
        };
        let lands = cycle + i64::from(checker.how(placed).latency);
        let mut to = vec![Destination::Output(checker.output(placed.fu, ty))];
        for at in &placed.writes {
            to.push(Destination::Register(
                at.file,
                self.physical(*at, iteration),
            ));
        }
        let landings = to.into_iter().map(|to| Landing {
            to,
            token,
            op: Some(op),
        });
        self.landing.entry(lands).or_default().extend(landings);
    }

    fn transfer(&mut self, transfer: &PlacedTransfer, cycle: i64, iteration: i64) {
        let checker = self.checker;
        let token = match transfer.over {
            Carrier::Link(link) => {
                let ty = checker.schedule.dfg.ty(transfer.node);
                let ty = ty.expect("transfers were found to move values");
                self.standing(checker.output(checker.srp.links[link].from, ty), cycle)
            }
            Carrier::Wire(wire) => self.on_wire(wire, cycle),
        };
        self.moved(None, transfer.node, token, iteration);
        let index = self.physical(transfer.to, iteration);
        let lands = cycle + i64::from(checker.srp.delay(transfer.over)) + 1;
        self.landing.entry(lands).or_default().push(Landing {
            to: Destination::Register(transfer.to.file, index),
            token,
            op: None,
        });
    }

    /// Checks the value of `node` that a move or transfer passes on, once all values exist.
    fn moved(&mut self, op: Option<Placed>, node: Node, token: Option<Token>, iteration: i64) {
        let right = matches!(token, Some(Token::Value(n, _)) if n == node);
        if !right && iteration >= self.distance {
            let found = show(token);
            let message =
                format!("a move of {node} in iteration {iteration} finds {found} instead");
            self.report(op, Rule::Dataflow, message);
        }
    }

    /// Returns the token that an operand must be in an iteration; `None` if any will do.
    fn wanted(&self, node: Node, operand: usize, iteration: i64) -> Option<Token> {
        match &self.checker.schedule.dfg.nodes[node].operands[operand] {
            Operand::Const(bits) => Some(Token::Const(*bits)),
            Operand::LiveIn(k) => Some(Token::LiveIn(*k)),
            Operand::Node { node, init } => {
                let from = iteration - init.len() as i64;
                match usize::try_from(-1 - from) {
                    Ok(before) => initial(init[before]),
                    Err(_) => Some(Token::Value(*node, from)),
                }
            }
        }
    }

    /// Returns the token that a wire takes in a cycle: what stands in the output at the other end of the wires
    /// that are set to lead there.
    fn on_wire(&self, mut wire: Wire, mut cycle: i64) -> Option<Token> {
        let checker = self.checker;
        loop {
            let hop = &checker.hops[&(wire, checker.slot(cycle))];
            match hop.from {
                Input::Unit(fu) => {
                    let ty = checker.schedule.dfg.ty(hop.node);
                    let ty = ty.expect("hops were found to carry values");
                    return self.standing(checker.output(fu, ty), cycle);
                }
                Input::Wire(before) => {
                    wire = before;
                    cycle -= i64::from(checker.srp.wires[before].delay);
                }
            }
        }
    }

    /// Returns the token that an output holds in a cycle.
    fn standing(&self, place: Place, cycle: i64) -> Option<Token> {
        let all = self.outputs[place].iter().rev();
        let mut before = all.skip_while(|&&(from, _)| from > cycle);
        before.next().and_then(|&(_, token)| token)
    }

    fn physical(&self, at: RegAt, iteration: i64) -> u32 {
        let file = &self.checker.srp.files[at.file];
        at.physical(iteration, file.kind == FileKind::Rotating, file.size)
    }

    fn live_outs(&mut self) {
        let schedule = self.checker.schedule;
        let all = schedule.live_out_regs.iter().zip(&schedule.dfg.live_outs);
        for (k, (reg, &node)) in all.enumerate() {
            let wanted = Token::Value(node, self.trip - 1);
            let token = self.files[reg.file][reg.index as usize];
            if token != Some(wanted) {
                let (found, trip) = (show(token), self.trip);
                let message =
                    format!("live-out {k} of {trip} iterations is {found} instead of {wanted}");
                self.report(None, Rule::LiveOut, message);
            }
        }
        let late = self.landing.keys().next().copied();
        if let Some(cycle) = late {
            let message = format!("something arrives in cycle {cycle}, after the end");
            self.report(None, Rule::Contexts, message);
        }
    }
}
