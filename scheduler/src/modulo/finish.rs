//! From a placement to a [`ModuloSchedule`]: registers allocated, times counted from zero, every
//! operand's source spelled out.

use super::place::Placement;
use super::problem::{Edge, Goal, Problem, Tag};
use super::registers::Keeper;
use super::table::{Item, Via};
use srp_archdesc::arch::{Carrier, Fu, Input, RegFile};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::{Place, PlaceKind};
use srp_ir::dfg::{Initial, Node, Operand};
use srp_ir::dre::scheduled::{
    ModuloSchedule, Placed, PlacedHop, PlacedOp, PlacedTransfer, Preload, Reg, RegAt, Source,
};

/// The schedule of a placement; the first of the fixed registers bring the live-ins.
pub(super) fn finish(
    problem: &Problem<'_>,
    placement: &Placement,
    fixed: &[Reg],
) -> ModuloSchedule {
    let finish = Finish {
        problem,
        placement,
        live_ins: &fixed[..problem.dfg.live_ins.len()],
        start: placement.start(),
        stays: stays(problem, placement),
    };
    finish.schedule()
}

/// A value's stay in a file, as a schedule names it.
struct Standing {
    node: Node,
    place: Place,
    tag: Tag,
    first: i32,
    last: i32,
    /// How it got there.
    via: Via,
    reg: RegAt,
}

/// The stays of all values, by value, file, tag and cycle.
fn stays(problem: &Problem<'_>, placement: &Placement) -> Vec<Standing> {
    let mut stays = Vec::new();
    for place in problem.graph.file.values().copied() {
        for s in placement.registers.stays(place) {
            let written = written(placement, s.node, place, s.tag, Some(s.first));
            let (first, via) = written.expect("a stay begins with a write");
            stays.push(Standing {
                node: s.node,
                place,
                tag: s.tag,
                first,
                last: s.last,
                via,
                reg: s.reg(problem, place),
            });
        }
        for (keeper, index) in placement.registers.kept(place) {
            let Keeper::LiveOut(node, tag) = keeper else {
                continue;
            };
            let file = problem.graph.as_file(place).expect("these are files");
            let (first, via) =
                written(placement, node, place, tag, None).expect("a kept value was written");
            let reg = RegAt {
                file,
                index,
                ring: 1,
            };
            stays.push(Standing {
                node,
                place,
                tag,
                first,
                last: first,
                via,
                reg,
            });
        }
    }
    stays.sort_by_key(|s| (s.node, s.place, s.tag, s.first));
    stays
}

/// When and how a value got into a file.
fn written(
    placement: &Placement,
    node: Node,
    place: Place,
    tag: Tag,
    time: Option<i32>,
) -> Option<(i32, Via)> {
    let items = placement.table.items(node);
    items.iter().find_map(|&item| match item {
        Item::Written(p, t, g, via) if p == place && g == tag => {
            (time.is_none_or(|time| time == t)).then_some((t, via))
        }
        _ => None,
    })
}

struct Finish<'a, 'p> {
    problem: &'a Problem<'p>,
    placement: &'a Placement,
    live_ins: &'a [Reg],
    start: i32,
    stays: Vec<Standing>,
}

impl Finish<'_, '_> {
    fn schedule(&self) -> ModuloSchedule {
        let mut ops: EntityMap<Placed, PlacedOp> =
            self.problem.nodes().map(|n| self.node(n)).collect();
        for node in self.problem.nodes() {
            for item in self.placement.table.items(node) {
                if let Item::Move(fu, time, read, tag) = item {
                    ops.push(self.mov(node, fu, time, read, tag));
                }
            }
        }
        let transfers = self.transfers();
        let landing = |op: &PlacedOp| {
            let timing = if op.is_move {
                let ty = self.ty(op.node);
                self.problem
                    .move_timing(op.fu, ty)
                    .expect("moves were routed over movers")
            } else {
                self.problem.timing(op.node, op.fu)
            };
            op.time + timing.latency
        };
        let arrives = |t: &PlacedTransfer| t.time + self.problem.srp.delay(t.over) + 1;
        let length = ops
            .values()
            .map(landing)
            .chain(transfers.iter().map(arrives))
            .max();
        ModuloSchedule {
            dfg: self.problem.dfg.clone(),
            ii: self.placement.table.ii,
            length: length.unwrap_or(1),
            transfers,
            hops: self.hops(),
            preloads: self.preloads(),
            live_in_regs: self.live_ins.to_vec(),
            live_out_regs: self.live_outs(),
            ops,
        }
    }

    fn ty(&self, node: Node) -> Ty {
        self.problem.dfg.ty(node).expect("only values are routed")
    }

    fn cycle(&self, time: i32) -> u32 {
        u32::try_from(time - self.start).expect("nothing issues before the first cycle")
    }

    fn node(&self, node: Node) -> PlacedOp {
        let (fu, time) = self.placement.at[node];
        let lands = time + self.problem.timing(node, fu).latency as i32;
        PlacedOp {
            node,
            is_move: false,
            fu,
            time: self.cycle(time),
            operands: self.operands(node, fu),
            writes: self.writes(node, fu, lands),
        }
    }

    /// Registers that a result of `node` landing on a unit in a cycle is written into.
    fn writes(&self, node: Node, fu: Fu, lands: i32) -> Vec<RegAt> {
        let here = |s: &&Standing| s.node == node && s.first == lands && s.via == Via::Result(fu);
        self.stays.iter().filter(here).map(|s| s.reg).collect()
    }

    fn operands(&self, node: Node, fu: Fu) -> Vec<Source> {
        let needs = self.problem.needs(node, fu);
        let kept = |i: usize| needs.and_then(|needs| needs.kept[i]);
        let data = &self.problem.dfg.nodes[node];
        let source = |(i, operand): (usize, &Operand)| match *operand {
            Operand::Const(bits) => match kept(i) {
                Some(place) => self.constant(place, Initial::Const(bits)),
                None => Source::Const(bits),
            },
            Operand::LiveIn(k) => match kept(i) {
                Some(place) => self.constant(place, Initial::LiveIn(k)),
                None => {
                    let Reg { file, index } = self.live_ins[k as usize];
                    Source::Reg {
                        reg: RegAt {
                            file,
                            index,
                            ring: 1,
                        },
                        distance: 0,
                    }
                }
            },
            Operand::Node { .. } => self.routed(node, i as u32, fu),
        };
        data.operands.iter().enumerate().map(source).collect()
    }

    fn constant(&self, place: Place, value: Initial) -> Source {
        let file = self
            .problem
            .graph
            .as_file(place)
            .expect("invariants are kept in files");
        let invariant = Keeper::Invariant(value);
        let mut kept = self.placement.registers.kept(place);
        let (_, index) = (kept.find(|(k, _)| *k == invariant)).expect("operands have been kept");
        Source::Reg {
            reg: RegAt {
                file,
                index,
                ring: 1,
            },
            distance: 0,
        }
    }

    /// The source of an operand that another node computes.
    fn routed(&self, node: Node, operand: u32, fu: Fu) -> Source {
        let goal = Goal::Operand(node, operand);
        let e = self.problem.edges_of[node]
            .iter()
            .copied()
            .find(|&e| self.problem.edges[e].goal == goal)
            .expect("every operand from a node is an edge");
        let edge = &self.problem.edges[e];
        let route = &self.placement.routes[e];
        let (_, time) = self.placement.at[node];
        let arrival = time + (self.placement.table.ii * edge.distance) as i32;
        self.source(edge.from, fu, route.read, route.tag, arrival, edge.distance)
    }

    /// Returns the source that a unit reads over one of its paths in a cycle.
    fn source(&self, value: Node, fu: Fu, read: u32, tag: Tag, time: i32, distance: u32) -> Source {
        let path = &self.problem.graph.reads[fu][read as usize];
        match self.problem.graph.places[path.from].kind {
            PlaceKind::Out(_) | PlaceKind::PredOut(_) => match path.over {
                Some(Carrier::Link(link)) => Source::Out(Some(link)),
                _ => Source::Out(None),
            },
            PlaceKind::Wire { wire, .. } => Source::Wire(wire),
            PlaceKind::File(_) => {
                let here = |s: &&Standing| {
                    s.node == value
                        && s.place == path.from
                        && s.tag == tag
                        && (s.first..=s.last).contains(&time)
                };
                let stay = self
                    .stays
                    .iter()
                    .find(here)
                    .expect("a register that is read is held");
                Source::Reg {
                    reg: stay.reg,
                    distance,
                }
            }
        }
    }

    fn mov(&self, node: Node, fu: Fu, time: i32, read: u32, tag: Tag) -> PlacedOp {
        let ty = self.ty(node);
        let timing = self
            .problem
            .move_timing(fu, ty)
            .expect("moves were routed over movers");
        PlacedOp {
            node,
            is_move: true,
            fu,
            time: self.cycle(time),
            operands: vec![self.source(node, fu, read, tag, time, 0)],
            writes: self.writes(node, fu, time + timing.latency as i32),
        }
    }

    fn transfers(&self) -> Vec<PlacedTransfer> {
        let transfer = |s: &Standing| match s.via {
            Via::Result(_) => None,
            Via::Over(over) => {
                let delay = self.problem.srp.delay(over) as i32;
                let time = self.cycle(s.first - delay - 1);
                Some(PlacedTransfer {
                    node: s.node,
                    over,
                    time,
                    to: s.reg,
                })
            }
        };
        self.stays.iter().filter_map(transfer).collect()
    }

    fn hops(&self) -> Vec<PlacedHop> {
        let graph = &self.problem.graph;
        let hop = |node: Node, item: Item| {
            let Item::Wire(place, time, from) = item else {
                return None;
            };
            let from = match graph.places[from].kind {
                PlaceKind::Out(fu) | PlaceKind::PredOut(fu) => Input::Unit(fu),
                PlaceKind::Wire { wire, .. } => Input::Wire(wire),
                PlaceKind::File(_) => return None,
            };
            let (wire, time) = (graph.as_wire(place)?, self.cycle(time));
            Some(PlacedHop {
                node,
                wire,
                from,
                time,
            })
        };
        let mut hops: Vec<PlacedHop> = (self.problem.nodes())
            .flat_map(|node| {
                let items = self.placement.table.items(node);
                items.into_iter().filter_map(move |item| hop(node, item))
            })
            .collect();
        hops.sort_unstable_by_key(|hop| (hop.time, hop.wire));
        hops
    }

    /// Invariants and initial values, by file and register.
    fn preloads(&self) -> Vec<Preload> {
        let ty_of = |value: Initial| match value {
            Initial::Const(bits) => Some(bits.ty()),
            Initial::LiveIn(i) => Some(self.problem.dfg.live_ins[i as usize].ty),
            Initial::Any => None,
        };
        let mut preloads: Vec<Preload> = Vec::new();
        for (place, file) in self.files() {
            for (keeper, index) in self.placement.registers.kept(place) {
                if let Keeper::Invariant(value) = keeper
                    && let Some(ty) = ty_of(value)
                {
                    preloads.push(Preload {
                        file,
                        index,
                        value,
                        ty,
                    });
                }
            }
        }
        for stay in &self.stays {
            let file = stay.reg.file;
            let rotating = self.problem.graph.rotates(self.problem.srp, stay.place);
            let size = self.problem.srp.files[file].size;
            let tagged = |e: &&Edge| e.from == stay.node && e.tag == Some(stay.tag);
            let edge = self.problem.edges.iter().find(tagged);
            let initials = edge.map_or(&[][..], |e| self.problem.initials(e));
            for (k, &value) in initials.iter().enumerate() {
                let Some(ty) = ty_of(value) else {
                    continue;
                };
                let index = stay.reg.physical(-1 - k as i64, rotating, size);
                preloads.push(Preload {
                    file,
                    index,
                    value,
                    ty,
                });
            }
        }
        preloads.sort_by_key(|p| (p.file, p.index));
        // Stays of one value in one register, apart from each other, begin with the same initial value.
        preloads.dedup();
        preloads
    }

    /// The register files, as places.
    fn files(&self) -> impl Iterator<Item = (Place, RegFile)> {
        self.problem
            .graph
            .file
            .iter()
            .map(|(file, &place)| (place, file))
    }

    fn live_outs(&self) -> Vec<Reg> {
        let place = |(i, &node): (usize, &Node)| {
            let tag = Tag::LiveOut(i as u16);
            let stay = self.stays.iter().find(|s| s.node == node && s.tag == tag);
            let RegAt { file, index, .. } = stay.expect("live-outs were routed").reg;
            Reg { file, index }
        };
        self.problem
            .dfg
            .live_outs
            .iter()
            .enumerate()
            .map(place)
            .collect()
    }
}
