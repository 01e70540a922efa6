//! [`Problem`]: a loop and a machine brought together, as far as it does not depend on the II.

use super::needs::{Files, Needs};
use super::{MAX_STAGES, route};
use rustc_hash::FxHashMap;
use srp_archdesc::arch::{FileKind, Fu, FuOp, Srp};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use srp_archdesc::resource::{Hop, Place, PlaceKind, ReadPath, ResourceGraph};
use srp_ir::dfg::{Dfg, Initial, Node, Operand};
use std::cell::OnceCell;
use std::collections::BTreeSet;

/// A unit, and the cycle in which it issues; cycles may be negative.
pub(super) type Position = (Fu, i32);

/// Cycles for which a live-out is on its way to a central register at most: those in which each slot of the array comes
/// twice, and some for a way across it.
pub(super) fn longest_way_out(ii: i32) -> i32 {
    2 * ii + 8
}

/// A loop and a machine.
#[derive(Clone)]
pub(super) struct Problem<'a> {
    pub(super) dfg: &'a Dfg,
    pub(super) srp: &'a Srp,
    pub(super) graph: ResourceGraph,
    /// How often a kernel may be repeated for values that live longer than the II.
    pub(super) most_copies: u32,
    /// The class of each node's operation.
    opcodes: EntityMap<Node, Opcode>,
    /// Units that can run each node, in order.
    pub(super) units: EntityMap<Node, Vec<Fu>>,
    /// Values that have to be routed.
    pub(super) edges: Vec<Edge>,
    /// Edges that end in or start from each node; a self-edge is listed once.
    pub(super) edges_of: EntityMap<Node, Vec<usize>>,
    /// Orders of nodes.
    pub(super) orders: Vec<OrderEdge>,
    /// Orders of each node.
    pub(super) orders_of: EntityMap<Node, Vec<usize>>,
    /// Ways out of each place into the operands of units: unit and index into its reads.
    pub(super) readers: EntityMap<Place, Vec<(Fu, u32)>>,
    /// Hops on to each place.
    pub(super) onto: EntityMap<Place, Vec<Hop>>,
    /// How each unit runs each class, by class and unit.
    timings: Vec<Option<&'a FuOp>>,
    /// Moves that can start from each place, per type.
    pub(super) moves: [EntityMap<Place, Vec<MoveWay<'a>>>; 3],
    /// Longest delay of a way into an operand.
    pub(super) longest_read: i32,
    /// Fewest cycles from standing in a place to being readable by a unit, per type, made where they are asked for.
    reach_by_file: [OnceCell<Distances>; 3],
    reach: [OnceCell<Distances>; 3],
    /// Least price from a place to a unit, beyond that of holding the value for as long; made like the former.
    detour: [OnceCell<Distances>; 3],
    /// No entry where there are none.
    needs: FxHashMap<(Node, Fu), Needs>,
}

/// From each place to each unit.
type Distances = EntityMap<Place, EntityMap<Fu, u32>>;

/// A move of a value from a place over a unit.
#[derive(Clone)]
pub(super) struct MoveWay<'a> {
    pub(super) fu: Fu,
    /// Index into the unit's reads.
    pub(super) read: u32,
    /// Cycles until the move issues.
    pub(super) delay: i32,
    /// Cycles until the value stands in the unit's output.
    pub(super) cycles: i32,
    /// That output.
    pub(super) out: Place,
    pub(super) timing: &'a FuOp,
}

/// A place that a value can go on to.
struct WayOn {
    to: Place,
    cycles: u32,
    /// The router's price.
    price: u32,
}

/// A value on its way from a node.
#[derive(Clone)]
pub(super) struct Edge {
    pub(super) from: Node,
    pub(super) goal: Goal,
    pub(super) ty: Ty,
    pub(super) distance: u32,
    /// Initial values, shared by edges of one producer whose lists agree; `None` at distance 0.
    pub(super) tag: Option<Tag>,
}

/// Where a value has to go.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Goal {
    /// To this operand of a node.
    Operand(Node, u32),
    /// Into a central register that keeps it after the loop.
    LiveOut(u32),
}

impl Edge {
    /// The consumer, if it is a node.
    pub(super) fn to(&self) -> Option<Node> {
        match self.goal {
            Goal::Operand(node, _) => Some(node),
            Goal::LiveOut(_) => None,
        }
    }
}

/// Which copies of a value in register files are one and the same: those that no initial value
/// distinguishes, those set before the loop to a list of initial values, and live-outs.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub(super) enum Tag {
    Plain,
    /// An index into the lists of initial values of [`Problem::initials`].
    Initial(u16),
    LiveOut(u16),
}

/// An order of two nodes, most of them of memory: `t(to) + ii · distance ≥ t(from) + delay`.
#[derive(Clone)]
pub(super) struct OrderEdge {
    pub(super) from: Node,
    pub(super) to: Node,
    pub(super) distance: u32,
    pub(super) delay: u32,
}

/// Rings longer than this would take too many contexts.
pub(super) const LARGEST_RING: u32 = 8;

/// No way there.
pub(super) const UNREACHABLE: u32 = u32::MAX / 4;

impl<'a> Problem<'a> {
    pub(super) fn new(dfg: &'a Dfg, srp: &'a Srp) -> Problem<'a> {
        let graph = ResourceGraph::by_hops(srp);
        let mut readers = EntityMap::filled(graph.places.len(), Vec::new());
        for (fu, reads) in graph.reads.iter() {
            for (i, read) in reads.iter().enumerate() {
                readers[read.from].push((fu, i as u32));
            }
        }
        let mut onto = EntityMap::filled(graph.places.len(), Vec::new());
        for hop in graph.hops.values().flatten() {
            onto[hop.to].push(*hop);
        }
        let mut problem = Problem {
            opcodes: dfg.nodes.values().map(|n| n.op).collect(),
            units: EntityMap::new(),
            edges: Vec::new(),
            edges_of: EntityMap::filled(dfg.nodes.len(), Vec::new()),
            orders: Vec::new(),
            orders_of: EntityMap::filled(dfg.nodes.len(), Vec::new()),
            timings: timings(srp),
            moves: Ty::ALL.map(|_| EntityMap::new()),
            longest_read: longest_read(&graph),
            reach: Ty::ALL.map(|_| OnceCell::new()),
            reach_by_file: Ty::ALL.map(|_| OnceCell::new()),
            detour: Ty::ALL.map(|_| OnceCell::new()),
            readers,
            onto,
            needs: FxHashMap::default(),
            dfg,
            srp,
            graph,
            most_copies: LARGEST_RING,
        };
        problem.add_units();
        problem.add_edges();
        problem.moves = Ty::ALL.map(|ty| problem.moves_of(ty));
        problem
    }

    /// Returns how many registers of a file that does not rotate a value takes in turn at most.
    pub(super) fn largest_ring(&self, ii: u32) -> u32 {
        let copies = (self.srp.contexts / ii.max(1)).clamp(1, self.most_copies);
        1 << copies.ilog2()
    }

    /// Returns the cycles for which a value can stay in this file, if it has all of it.
    pub(super) fn longest_stay_in(&self, ii: u32, file: Place) -> i32 {
        let Some(rf) = self.graph.as_file(file) else {
            return i32::MAX;
        };
        let spec = &self.srp.files[rf];
        let copies = match spec.kind {
            FileKind::Rotating => spec.size,
            _ => self.largest_ring(ii).min(spec.size),
        };
        i32::try_from(u64::from(copies) * u64::from(ii)).unwrap_or(i32::MAX)
    }

    /// True if a unit has the operation of a node, wherever its constants and invariants are.
    pub(super) fn has_unit(&self, node: Node) -> bool {
        self.srp.fus.keys().any(|fu| self.has_operation(node, fu))
    }

    fn has_operation(&self, node: Node, fu: Fu) -> bool {
        let op = self.dfg.nodes[node].op;
        let fits = |ty| self.result_fits(fu, op, ty);
        self.srp.fus[fu].runs(op).is_some() && op.result().is_none_or(fits)
    }

    /// Lists the units that can run each node, its constants and values from outside the loop within reach.
    fn add_units(&mut self) {
        let files = Files::new(self.dfg, self.srp, &self.graph);
        let mut all = FxHashMap::default();
        for node in self.dfg.nodes.keys() {
            let mut units = Vec::new();
            for fu in self.srp.fus.keys() {
                let needs = match self.has_operation(node, fu) {
                    true => files.needs(node, fu),
                    false => None,
                };
                let Some(needs) = needs else { continue };
                units.push(fu);
                if !needs.is_empty() {
                    all.insert((node, fu), needs);
                }
            }
            self.units.push(units);
        }
        self.needs = all;
    }

    /// The needs of a node on a unit besides its issue slot; `None` if there are none.
    pub(super) fn needs(&self, node: Node, fu: Fu) -> Option<&Needs> {
        self.needs.get(&(node, fu))
    }

    fn result_fits(&self, fu: Fu, op: Opcode, ty: Ty) -> bool {
        let place = self.graph.result_place(fu, op);
        place.is_some_and(|p| self.graph.places[p].width >= ty.bits())
    }

    fn add_edges(&mut self) {
        let mut tags: FxHashMap<(Node, Vec<Initial>), u16> = FxHashMap::default();
        let dfg = self.dfg;
        for (to, data) in dfg.nodes.iter() {
            for (i, operand) in data.operands.iter().enumerate() {
                let Operand::Node { node, init } = operand else {
                    continue;
                };
                let next = tags.len() as u16;
                // What nothing depends on need not be in a register that is set before the loop.
                let set = init.iter().any(|value| *value != Initial::Any);
                let tag =
                    set.then(|| Tag::Initial(*tags.entry((*node, init.clone())).or_insert(next)));
                let goal = Goal::Operand(to, i as u32);
                self.add_edge(*node, goal, init.len() as u32, tag);
            }
        }
        for (i, &node) in dfg.live_outs.iter().enumerate() {
            self.add_edge(
                node,
                Goal::LiveOut(i as u32),
                0,
                Some(Tag::LiveOut(i as u16)),
            );
        }
        for (from, to, dep) in dfg.deps() {
            if let srp_ir::dfg::DepKind::Order = dep.kind {
                let delay = dfg.delay(from, dep, 0);
                self.add_order(OrderEdge {
                    from,
                    to,
                    distance: dep.distance,
                    delay,
                });
            }
        }
        self.keep_within_stages();
    }

    /// Adds an order for each value of many iterations ago. A consumer far ahead of its producer would keep the value
    /// for fewer cycles, but all of an iteration is done within [`MAX_STAGES`] IIs, which windows of issue cycles would
    /// not know.
    fn keep_within_stages(&mut self) {
        let far: BTreeSet<(Node, Node)> = (self.edges.iter())
            .filter(|edge| edge.distance > MAX_STAGES)
            .filter_map(|edge| Some((edge.from, edge.to()?)))
            .filter(|(from, to)| from != to)
            .collect();
        for (from, to) in far {
            self.add_order(OrderEdge {
                from,
                to,
                distance: MAX_STAGES,
                delay: self.min_latency(from),
            });
        }
    }

    fn add_order(&mut self, order: OrderEdge) {
        let index = self.orders.len();
        self.orders_of[order.from].push(index);
        if order.to != order.from {
            self.orders_of[order.to].push(index);
        }
        self.orders.push(order);
    }

    fn add_edge(&mut self, from: Node, goal: Goal, distance: u32, tag: Option<Tag>) {
        let ty = self
            .dfg
            .ty(from)
            .expect("an operand's producer has a result");
        let index = self.edges.len();
        self.edges.push(Edge {
            from,
            goal,
            ty,
            distance,
            tag,
        });
        self.edges_of[from].push(index);
        if let Goal::Operand(to, _) = goal
            && to != from
        {
            self.edges_of[to].push(index);
        }
    }

    /// The initial values of an edge, the one before iteration 0 first.
    pub(super) fn initials(&self, edge: &Edge) -> &'a [Initial] {
        match edge.goal {
            Goal::Operand(to, i) => match &self.dfg.nodes[to].operands[i as usize] {
                Operand::Node { init, .. } => init,
                Operand::Const(_) | Operand::LiveIn(_) => &[],
            },
            Goal::LiveOut(_) => &[],
        }
    }

    fn op_timing(&self, op: Opcode, fu: Fu) -> Option<&'a FuOp> {
        self.timings[op as usize * self.srp.fus.len() + fu.index()]
    }

    /// How a unit runs a node.
    pub(super) fn timing(&self, node: Node, fu: Fu) -> &'a FuOp {
        self.op_timing(self.opcodes[node], fu)
            .expect("only units that run it are asked")
    }

    /// How a unit moves a type, or `None` where it cannot.
    pub(super) fn move_timing(&self, fu: Fu, ty: Ty) -> Option<&'a FuOp> {
        let op = Opcode::mov(ty);
        let place = self.graph.result_place(fu, op);
        place.filter(|&p| self.graph.places[p].width >= ty.bits())?;
        self.op_timing(op, fu)
    }

    fn moves_of(&self, ty: Ty) -> EntityMap<Place, Vec<MoveWay<'a>>> {
        let way = |&(fu, read): &(Fu, u32)| {
            let path = &self.graph.reads[fu][read as usize];
            let timing = self
                .move_timing(fu, ty)
                .filter(|_| path.width >= ty.bits())?;
            Some(MoveWay {
                fu,
                read,
                delay: path.delay as i32,
                cycles: (path.delay + timing.latency) as i32,
                out: self.move_place(fu, ty),
                timing,
            })
        };
        let from = |readers: &Vec<(Fu, u32)>| readers.iter().filter_map(way).collect();
        self.readers.values().map(from).collect()
    }

    /// Smallest latency of a node over its units; 1 where no unit runs it.
    pub(super) fn min_latency(&self, node: Node) -> u32 {
        self.units[node]
            .iter()
            .map(|&fu| self.timing(node, fu).latency)
            .min()
            .unwrap_or(1)
    }

    /// The place of a move's result.
    pub(super) fn move_place(&self, fu: Fu, ty: Ty) -> Place {
        self.graph
            .result_place(fu, Opcode::mov(ty))
            .expect("moves have results")
    }

    /// Fewest cycles from standing in `place` to an operand of `fu`, or [`UNREACHABLE`].
    pub(super) fn reach(&self, ty: Ty, place: Place, fu: Fu) -> u32 {
        let made = || self.distances(ty, |read| Some(read.delay), |way| way.cycles);
        self.reach[ty as usize].get_or_init(made)[place][fu]
    }

    /// True if the array can write values of a type into the central registers.
    pub(super) fn keeps(&self, ty: Ty) -> bool {
        let Some(file) = self.srp.central(ty).map(|file| self.graph.file[file]) else {
            return false;
        };
        let mut written = self.graph.writes.values();
        let mut transfers = self.graph.transfers.values().flatten();
        written.any(|files| files.contains(&file)) || transfers.any(|way| way.to == file)
    }

    /// The places that a result of a type of a unit stands in as it lands: its output, and the files that the unit writes.
    pub(super) fn landings(&self, ty: Ty, from: Fu) -> impl Iterator<Item = Place> {
        let out = match ty {
            Ty::Pred => self.graph.pred_out[from],
            Ty::Word | Ty::Vec => self.graph.out[from],
        };
        let files = self.graph.writes[from].iter().copied();
        let wide = files.filter(move |&file| self.graph.places[file].width >= ty.bits());
        std::iter::once(out).chain(wide)
    }

    /// True if a result of a unit can come to an operand of another.
    pub(super) fn has_way(&self, ty: Ty, from: Fu, to: Fu) -> bool {
        self.reach_of_result(ty, from, to) != UNREACHABLE
    }

    /// The same, out of a register file, which holds the initial values too.
    pub(super) fn has_way_by_file(&self, ty: Ty, from: Fu, to: Fu) -> bool {
        let made = || {
            let of_file = |read: &ReadPath| self.is_file(read.from).then_some(read.delay);
            self.distances(ty, of_file, |way| way.cycles)
        };
        let reach = self.reach_by_file[ty as usize].get_or_init(made);
        self.landings(ty, from)
            .any(|place| reach[place][to] != UNREACHABLE)
    }

    /// True if a result of a unit can come to the central registers.
    pub(super) fn is_kept(&self, ty: Ty, from: Fu) -> bool {
        let Some(file) = self.srp.central(ty).map(|file| self.graph.file[file]) else {
            return false;
        };
        let mut seen = EntityMap::filled(self.graph.places.len(), false);
        let mut open: Vec<Place> = self.landings(ty, from).collect();
        while let Some(place) = open.pop() {
            if !std::mem::replace(&mut seen[place], true) {
                open.extend(self.ways_on(place, ty).iter().map(|way| way.to));
            }
        }
        seen[file]
    }

    /// Fewest cycles from the landing of a unit's result to an operand of another, or [`UNREACHABLE`].
    pub(super) fn reach_of_result(&self, ty: Ty, from: Fu, to: Fu) -> u32 {
        let reach = self
            .landings(ty, from)
            .map(|place| self.reach(ty, place, to));
        reach.min().unwrap_or(UNREACHABLE)
    }

    /// Returns the least cost of a route from `place` to an operand of `fu`, beyond holding the
    /// value.
    pub(super) fn detour(&self, ty: Ty, place: Place, fu: Fu) -> u32 {
        let detour = |way: &WayOn| way.price - route::holding_price(way.cycles);
        let made = || self.distances(ty, |_| Some(0), detour);
        self.detour[ty as usize].get_or_init(made)[place][fu]
    }

    /// The least sum over the ways on from each place until each unit's operands, by the reads that count: from each
    /// unit backwards.
    fn distances(
        &self,
        ty: Ty,
        reading: impl Fn(&ReadPath) -> Option<u32>,
        weight: impl Fn(&WayOn) -> u32,
    ) -> Distances {
        let places = self.graph.places.len();
        let mut back: EntityMap<Place, Vec<(Place, u32)>> = EntityMap::filled(places, Vec::new());
        for from in self.graph.places.keys() {
            for way in self.ways_on(from, ty) {
                back[way.to].push((from, weight(&way)));
            }
        }
        let mut least =
            EntityMap::filled(places, EntityMap::filled(self.srp.fus.len(), UNREACHABLE));
        for (fu, reads) in self.graph.reads.iter() {
            let wide = reads.iter().filter(|read| read.width >= ty.bits());
            let starts = wide.filter_map(|read| Some((read.from, reading(read)?)));
            for (place, distance) in backwards(&back, starts).iter() {
                least[place][fu] = *distance;
            }
        }
        least
    }

    /// Places that a value can go on to from a place.
    fn ways_on(&self, place: Place, ty: Ty) -> Vec<WayOn> {
        let mut ways = Vec::new();
        for transfer in &self.graph.transfers[place] {
            if transfer.width >= ty.bits() {
                let (to, cycles) = (transfer.to, transfer.delay + 1);
                let price = route::transfer_price(cycles);
                ways.push(WayOn { to, cycles, price });
            }
        }
        for hop in &self.graph.hops[place] {
            if hop.width >= ty.bits() {
                let (to, cycles) = (hop.to, hop.delay);
                let price = route::hop_price(cycles);
                ways.push(WayOn { to, cycles, price });
            }
        }
        for way in &self.moves[ty as usize][place] {
            let cycles = way.cycles as u32;
            let price = route::move_price(cycles);
            let files = &self.graph.writes[way.fu];
            let wide = files
                .iter()
                .filter(|&&f| self.graph.places[f].width >= ty.bits());
            let landings = std::iter::once(&way.out).chain(wide);
            ways.extend(landings.map(|&to| WayOn { to, cycles, price }));
        }
        ways
    }

    /// True if a place is an output, which holds one value.
    pub(super) fn is_output(&self, place: Place) -> bool {
        let kind = self.graph.places[place].kind;
        matches!(kind, PlaceKind::Out(_) | PlaceKind::PredOut(_))
    }

    /// True if a place is a register file.
    pub(super) fn is_file(&self, place: Place) -> bool {
        matches!(self.graph.places[place].kind, PlaceKind::File(_))
    }

    /// All nodes.
    pub(super) fn nodes(&self) -> impl Iterator<Item = Node> + use<> {
        (0..self.dfg.nodes.len()).map(Node::new)
    }
}

/// The distance of each place from some to start from, each with its own, by the ways into each place and their
/// weights: places are taken in the order of their distance (Dial 1969).
fn backwards(
    back: &EntityMap<Place, Vec<(Place, u32)>>,
    starts: impl Iterator<Item = (Place, u32)>,
) -> EntityMap<Place, u32> {
    let mut least = EntityMap::filled(back.len(), UNREACHABLE);
    // Places that may have each distance.
    let mut at: Vec<Vec<Place>> = Vec::new();
    let reaches = |at: &mut Vec<Vec<Place>>, place: Place, over: u32| {
        at.resize(at.len().max(over as usize + 1), Vec::new());
        at[over as usize].push(place);
    };
    for (place, distance) in starts {
        reaches(&mut at, place, distance);
    }
    let mut distance = 0;
    while distance < at.len() {
        // Ways without a weight add places at the same distance.
        while let Some(place) = at[distance].pop() {
            if least[place] <= distance as u32 {
                continue;
            }
            least[place] = distance as u32;
            for &(from, weight) in &back[place] {
                let over = distance as u32 + weight;
                if over < least[from] {
                    reaches(&mut at, from, over);
                }
            }
        }
        distance += 1;
    }
    least
}

fn timings(srp: &Srp) -> Vec<Option<&FuOp>> {
    let of_op = |op: &Opcode| {
        srp.fus
            .values()
            .map(|fu| fu.timing(*op))
            .collect::<Vec<_>>()
    };
    Opcode::ALL.iter().flat_map(of_op).collect()
}

fn longest_read(graph: &ResourceGraph) -> i32 {
    let delays = graph.reads.values().flatten().map(|read| read.delay as i32);
    delays.max().unwrap_or(0)
}
