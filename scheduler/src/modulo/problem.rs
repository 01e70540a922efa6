//! [`Problem`]: a loop and a machine brought together, as far as it does not depend on the II.

use rustc_hash::FxHashMap;
use srp_archdesc::arch::{Arch, FileKind, Fu, FuOp};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use srp_archdesc::resource::{Place, PlaceKind, ResourceGraph};
use srp_ir::dfg::{Dfg, Initial, Node, Operand};

/// A loop and a machine.
pub(super) struct Problem<'a> {
    pub(super) dfg: &'a Dfg,
    pub(super) arch: &'a Arch,
    pub(super) graph: ResourceGraph,
    /// Units that can run each node, with their timing.
    pub(super) units: EntityMap<Node, Vec<Fu>>,
    /// Values that have to be routed.
    pub(super) edges: Vec<Edge>,
    /// Edges that end in or start from each node; a self-edge is listed once.
    pub(super) edges_of: EntityMap<Node, Vec<usize>>,
    /// Memory orders.
    pub(super) orders: Vec<OrderEdge>,
    /// Memory orders of each node.
    pub(super) orders_of: EntityMap<Node, Vec<usize>>,
    /// Ways out of each place into the operands of units: unit and index into its reads.
    pub(super) readers: EntityMap<Place, Vec<(Fu, u32)>>,
    /// Units that can move each type.
    movers: [Vec<Fu>; 3],
    /// Fewest cycles from standing in a place to being readable by a unit, per type.
    reach: [EntityMap<Place, EntityMap<Fu, u32>>; 3],
    /// The register files in which each unit could find a loop invariant.
    pub(super) constant_files: EntityMap<Fu, Vec<Place>>,
}

/// A value on its way from a node.
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

/// A memory order: `t(to) + ii · distance ≥ t(from) + delay`.
pub(super) struct OrderEdge {
    pub(super) from: Node,
    pub(super) to: Node,
    pub(super) distance: u32,
    pub(super) delay: u32,
}

/// No way there.
pub(super) const UNREACHABLE: u32 = u32::MAX / 4;

impl<'a> Problem<'a> {
    pub(super) fn new(dfg: &'a Dfg, arch: &'a Arch) -> Problem<'a> {
        let graph = ResourceGraph::of(arch);
        let mut readers = EntityMap::filled(graph.places.len(), Vec::new());
        for (fu, reads) in graph.reads.iter() {
            for (i, read) in reads.iter().enumerate() {
                readers[read.from].push((fu, i as u32));
            }
        }
        let constant_files = (arch.fus.keys())
            .map(|fu| {
                let held = |p: &Place| match graph.as_file(*p) {
                    Some(rf) => arch.files[rf].kind == FileKind::Static,
                    None => false,
                };
                graph.reads[fu]
                    .iter()
                    .map(|r| r.from)
                    .filter(held)
                    .collect()
            })
            .collect();
        let mut problem = Problem {
            units: EntityMap::new(),
            edges: Vec::new(),
            edges_of: EntityMap::filled(dfg.nodes.len(), Vec::new()),
            orders: Vec::new(),
            orders_of: EntityMap::filled(dfg.nodes.len(), Vec::new()),
            movers: Ty::ALL.map(|ty| movers(arch, ty)),
            reach: Ty::ALL.map(|_| EntityMap::new()),
            readers,
            constant_files,
            dfg,
            arch,
            graph,
        };
        problem.units = dfg
            .nodes
            .keys()
            .map(|n| arch.fus.keys().filter(|&f| problem.runs(n, f)).collect())
            .collect();
        problem.add_edges();
        problem.reach = Ty::ALL.map(|ty| problem.reach_of(ty));
        problem
    }

    /// Whether a unit can run a node, its constants and invariants within reach.
    fn runs(&self, node: Node, fu: Fu) -> bool {
        let data = &self.dfg.nodes[node];
        let Some(_) = self.arch.fus[fu].op(data.op.class()) else {
            return false;
        };
        if data
            .op
            .result()
            .is_some_and(|ty| !self.result_fits(fu, data.op, ty))
        {
            return false;
        }
        let mut constants = self.arch.fus[fu].constants;
        data.operands.iter().all(|operand| match *operand {
            Operand::Node { .. } => true,
            Operand::Const(bits) if bits.ty() == Ty::Pred => true,
            Operand::Const(_) if constants > 0 => {
                constants -= 1;
                true
            }
            Operand::Const(bits) => self.constant_place(fu, bits.ty()).is_some(),
            Operand::LiveIn(i) => {
                let ty = self.dfg.live_ins[i as usize].ty;
                self.reads_central(fu, ty) || self.constant_place(fu, ty).is_some()
            }
        })
    }

    fn result_fits(&self, fu: Fu, op: Opcode, ty: Ty) -> bool {
        let place = self.graph.result_place(fu, op);
        place.is_some_and(|p| self.graph.places[p].width >= ty.bits())
    }

    /// Whether a unit can read the central file of a type.
    pub(super) fn reads_central(&self, fu: Fu, ty: Ty) -> bool {
        self.arch
            .central(ty)
            .is_some_and(|rf| self.arch.files[rf].readers.contains(&fu))
    }

    /// The file in which a unit finds invariants of a type, the narrowest first.
    pub(super) fn constant_place(&self, fu: Fu, ty: Ty) -> Option<Place> {
        let fits = |p: &&Place| self.graph.places[**p].width >= ty.bits();
        self.constant_files[fu]
            .iter()
            .filter(fits)
            .min_by_key(|p| self.graph.places[**p].width)
            .copied()
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
                let tag = (!init.is_empty())
                    .then(|| Tag::Initial(*tags.entry((*node, init.clone())).or_insert(next)));
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
                let index = self.orders.len();
                self.orders.push(OrderEdge {
                    from,
                    to,
                    distance: dep.distance,
                    delay,
                });
                self.orders_of[from].push(index);
                if to != from {
                    self.orders_of[to].push(index);
                }
            }
        }
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

    /// How a unit runs a node.
    pub(super) fn timing(&self, node: Node, fu: Fu) -> &'a FuOp {
        self.arch.fus[fu]
            .op(self.dfg.nodes[node].op.class())
            .expect("only units that run it are asked")
    }

    /// How a unit moves a type, or `None` where it cannot.
    pub(super) fn move_timing(&self, fu: Fu, ty: Ty) -> Option<&'a FuOp> {
        self.movers[ty as usize]
            .contains(&fu)
            .then(|| self.arch.fus[fu].op(Opcode::mov(ty).class()))?
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
        self.reach[ty as usize][place][fu]
    }

    /// Fewest cycles from standing in `place` to each unit's operands, by relaxation to a fixpoint
    /// over the moves and transfers (all of them take at least a cycle).
    fn reach_of(&self, ty: Ty) -> EntityMap<Place, EntityMap<Fu, u32>> {
        let fits = |width: u32| width >= ty.bits();
        let mut reach = EntityMap::filled(
            self.graph.places.len(),
            EntityMap::filled(self.arch.fus.len(), UNREACHABLE),
        );
        for reads in self.graph.reads.values() {
            for read in reads.iter().filter(|r| fits(r.width)) {
                let best: &mut u32 = &mut reach[read.from][read.to];
                *best = read.delay.min(*best);
            }
        }
        loop {
            let mut changed = false;
            for place in self.graph.places.keys() {
                let ways = self.ways_on(place, ty);
                for fu in self.arch.fus.keys() {
                    let best = ways
                        .iter()
                        .map(|&(to, cycles)| cycles + reach[to][fu])
                        .min();
                    if let Some(best) = best.filter(|&b| b < reach[place][fu]) {
                        reach[place][fu] = best;
                        changed = true;
                    }
                }
            }
            if !changed {
                return reach;
            }
        }
    }

    /// Places that a value can go on to from a place, with the cycles it takes.
    fn ways_on(&self, place: Place, ty: Ty) -> Vec<(Place, u32)> {
        let mut ways = Vec::new();
        for transfer in &self.graph.transfers[place] {
            if transfer.width >= ty.bits() {
                ways.push((transfer.to, transfer.delay + 1));
            }
        }
        for &(fu, read) in &self.readers[place] {
            let read = &self.graph.reads[fu][read as usize];
            let Some(timing) = self.move_timing(fu, ty).filter(|_| read.width >= ty.bits()) else {
                continue;
            };
            let cycles = read.delay + timing.latency;
            ways.push((self.move_place(fu, ty), cycles));
            for &file in &self.graph.writes[fu] {
                if self.graph.places[file].width >= ty.bits() {
                    ways.push((file, cycles));
                }
            }
        }
        ways
    }

    /// Whether a place is an output, which holds one value.
    pub(super) fn is_output(&self, place: Place) -> bool {
        !matches!(self.graph.places[place].kind, PlaceKind::File(_))
    }

    /// All nodes.
    pub(super) fn nodes(&self) -> impl Iterator<Item = Node> + use<> {
        (0..self.dfg.nodes.len()).map(Node::new)
    }
}

fn movers(arch: &Arch, ty: Ty) -> Vec<Fu> {
    let op = Opcode::mov(ty);
    let graph = ResourceGraph::of(arch);
    let moves = |&fu: &Fu| {
        let place = graph.result_place(fu, op);
        arch.fus[fu].op(op.class()).is_some()
            && place.is_some_and(|p| graph.places[p].width >= ty.bits())
    };
    arch.fus.keys().filter(moves).collect()
}
