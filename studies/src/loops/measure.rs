//! From a scheduled loop to its report: names and positions for what scheduler and schedule say.

use super::model::{
    Carried, Cell, Edge, FileKind, FileLoad, Graph, LinkLoad, LoopReport, Obstacle, Operation,
    Ordered, PortLoad, Position, Resource, SharedLoad, Status, Step, UnitLoad,
};
use super::resource::resource_name;
use super::wires;
use crate::proofs::{Impossible, Search};
use srp_archdesc::arch::{self, Arch};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_ir::dfg::{Dep, Dfg, Node, Operand, Order};
use srp_ir::dre::scheduled::{ModuloSchedule, PlacedOp, Source};
use srp_ir::program::{Pos, SourceFile};
use srp_ir::split::{Doubt, Remark};
use srp_kernels::libc;
use srp_scheduler::LoopFacts;
use srp_scheduler::demand::{Demand, Dependence, Need};
use srp_scheduler::modulo::{self, Bounds, FailedIi};
use srp_scheduler::usage::{self, FileUse, LinkUse, Taker, Usage, opcode, usage};
use std::collections::{BTreeMap, BTreeSet};

/// The names of a program's files.
pub(super) struct Names<'a>(pub(super) &'a EntityMap<SourceFile, String>);

impl Names<'_> {
    pub(super) fn position(&self, pos: Pos) -> Position {
        Position {
            file: self.0.get(pos.file).cloned().unwrap_or_default(),
            line: pos.line,
            column: pos.column,
        }
    }
}

/// Facts of the program and the machine that a report needs beside loops.
pub(super) struct View<'a> {
    pub(super) names: Names<'a>,
    pub(super) arch: &'a Arch,
    pub(super) remarks: &'a [Remark],
    /// The memory orders of each loop that would be left if pointers were `restrict`.
    pub(super) relaxed: Option<&'a BTreeMap<String, Vec<Order>>>,
}

impl View<'_> {
    fn position(&self, pos: Pos) -> Position {
        self.names.position(pos)
    }

    pub(super) fn of_loop(&self, schedule: &ModuloSchedule, facts: &LoopFacts) -> LoopReport {
        let dfg = &schedule.dfg;
        let usage = usage(schedule, &self.arch.srp);
        let bounds = &facts.bounds;
        LoopReport {
            kernel: dfg.name.clone(),
            at: self.position(dfg.pos),
            operations: dfg.nodes.len() as u32,
            software: self.in_software(dfg),
            moves: schedule.ops.values().filter(|op| op.is_move).count() as u32,
            ii: schedule.ii,
            status: status(schedule.ii, facts),
            res_mii: bounds.resources,
            res_mii_why: bounds.resources_why.clone(),
            resources: bounds.demands.iter().map(|d| self.resource(d)).collect(),
            rec_mii: bounds.recurrences,
            recurrence: self.recurrence(dfg, facts),
            recurrence_graph: self.recurrence_graph(schedule, facts),
            why_not_lower: (facts.why_not_lower.as_ref()).map(|failed| self.obstacle(dfg, failed)),
            impossible: facts.impossible.iter().map(Impossible::of).collect(),
            search: facts.search.as_ref().map(Search::of).unwrap_or_default(),
            what_if: None,
            hint: String::new(),
            ordered: self.ordered(&dfg.name),
            restrict_bound: self.restrict_bound(dfg, bounds),
            restrict_ii: None,
            stages: schedule.stages(),
            length: schedule.length,
            least_length: facts.least_length,
            contexts: schedule.contexts(),
            preloads: schedule.preloads.len() as u32,
            cycles_per_ray: self.cycles_per_ray(schedule),
            units: self.units(&usage),
            shared: self.shared(&usage),
            links: self.links(&usage),
            wires: wires::wires(schedule, &self.arch.srp, &usage),
            files: self.register_files(&usage),
            table: self.table(schedule),
            seconds: None,
        }
    }

    /// Operations that stand in for units.
    fn in_software(&self, dfg: &Dfg) -> u32 {
        let stands_in = |pos: Pos| self.position(pos).file == libc::SOFTWARE;
        dfg.nodes.values().filter(|n| stands_in(n.pos)).count() as u32
    }

    fn cycles_per_ray(&self, schedule: &ModuloSchedule) -> f64 {
        let arch = self.arch;
        let rays = arch.system.buffers.rays;
        let entry = (schedule.preloads.len() as u32).div_ceil(arch.srp.preload_width.max(1));
        let kernel = schedule.ii * rays.saturating_sub(1) + schedule.length;
        f64::from(entry + 2 * arch.srp.mode_switch + kernel) / f64::from(rays.max(1))
    }

    fn resource(&self, demand: &Demand) -> Resource {
        Resource {
            resource: resource_name(&demand.need, &self.arch.srp),
            shared: matches!(demand.need, Need::Shared(_)),
            operations: demand.operations,
            uses: demand.cycles,
            offered: demand.offered,
            bound: demand.bound,
        }
    }

    fn recurrence(&self, dfg: &Dfg, facts: &LoopFacts) -> Vec<Step> {
        let bounds = &facts.bounds;
        let steps = bounds.critical_cycle.iter();
        steps
            .zip(&bounds.critical_dependences)
            .map(|(&node, dependence)| Step {
                op: dfg.nodes[node].op.name().to_owned(),
                node: node.index() as u32,
                latency: dependence.delay,
                distance: dependence.distance,
                at: self.position(dfg.nodes[node].pos),
            })
            .collect()
    }

    /// The dependences among all nodes that are in circles with those of the recurrence.
    fn recurrence_graph(&self, schedule: &ModuloSchedule, facts: &LoopFacts) -> Graph {
        let (dfg, bounds) = (&schedule.dfg, &facts.bounds);
        let Some(&start) = bounds.critical_cycle.first() else {
            return Graph::default();
        };
        let after = reached(dfg, start, |from, to| (from, to));
        let before = reached(dfg, start, |from, to| (to, from));
        let within = |node: Node| after.contains(&node) && before.contains(&node);
        let cycle = bounds.critical_cycle.iter();
        let next = cycle.clone().cycle().skip(1);
        let steps = cycle.zip(next).zip(&bounds.critical_dependences);
        let steps: Vec<((&Node, &Node), &Dependence)> = steps.collect();
        let edge = |(from, to, dep): (Node, Node, Dep)| {
            let latency = dfg.delay(from, dep, self.least_latency(dfg, from));
            let same = |((a, b), d): &((&Node, &Node), &Dependence)| {
                (**a, **b) == (from, to) && (d.delay, d.distance) == (latency, dep.distance)
            };
            Edge {
                from: from.index() as u32,
                to: to.index() as u32,
                latency,
                distance: dep.distance,
                critical: steps.iter().any(same),
            }
        };
        let edges = dfg
            .deps()
            .filter(|&(from, to, _)| within(from) && within(to));
        let mut edges: Vec<Edge> = edges.map(edge).collect();
        edges.sort_by_key(|e| (e.from, e.to, e.distance, e.latency));
        edges.dedup_by_key(|e| (e.from, e.to, e.distance, e.latency));
        Graph {
            nodes: (dfg.nodes.keys().filter(|&n| within(n)))
                .map(|n| self.operation(dfg, n))
                .collect(),
            edges,
        }
    }

    /// Fewest cycles until the result of a node can be read.
    fn least_latency(&self, dfg: &Dfg, node: Node) -> u32 {
        let op = dfg.nodes[node].op;
        let ways = self.arch.srp.fus.values().filter_map(|fu| fu.runs(op));
        ways.map(|way| way.latency).min().unwrap_or(1)
    }

    fn operation(&self, dfg: &Dfg, node: Node) -> Operation {
        Operation {
            op: dfg.nodes[node].op.name().to_owned(),
            node: node.index() as u32,
            at: self.position(dfg.nodes[node].pos),
        }
    }

    /// Returns the obstacle of an II that failed, with the operations that it names.
    fn obstacle(&self, dfg: &Dfg, failed: &FailedIi) -> Obstacle {
        let operations = failed.obstacle.operations();
        // Operations of inlined functions may come from another file than the loop.
        let name = |operation: &modulo::Operation| {
            let pos = dfg.nodes[operation.node].pos;
            match pos.file == dfg.pos.file {
                true => operation.to_string(),
                false => {
                    let Position { file, line, .. } = self.position(pos);
                    format!("`{}` of {file}:{line}", operation.op)
                }
            }
        };
        Obstacle {
            text: failed.words(&name),
            operations: (operations.iter())
                .map(|o| self.operation(dfg, o.node))
                .collect(),
        }
    }

    /// The bound of the II if the pointers that may alias were `restrict`, where that is lower.
    fn restrict_bound(&self, dfg: &Dfg, bounds: &Bounds) -> Option<u32> {
        let relaxed = Dfg {
            order: self.relaxed?.get(&dfg.name)?.clone(),
            ..dfg.clone()
        };
        let bound = modulo::bounds(&relaxed, &self.arch.srp).min_ii();
        (bound < bounds.min_ii()).then_some(bound)
    }

    fn ordered(&self, kernel: &str) -> Vec<Ordered> {
        let of_kernel = self.remarks.iter().filter(|r| r.kernel == kernel);
        let ordered = |r: &Remark| Ordered {
            first: self.position(r.first),
            second: self.position(r.second),
            why: r.doubt.to_string(),
            in_one_object: matches!(r.doubt, Doubt::SameElement),
        };
        of_kernel.map(ordered).collect()
    }

    fn units(&self, usage: &Usage) -> Vec<UnitLoad> {
        let load = |(fu, spec): (arch::Fu, &arch::FuSpec)| UnitLoad {
            unit: spec.name.clone(),
            row: spec.row,
            column: spec.col,
            operations: usage.units[fu].operations,
            moves: usage.units[fu].moves,
            held: usage.units[fu].held,
        };
        self.arch.srp.fus.iter().map(load).collect()
    }

    fn shared(&self, usage: &Usage) -> Vec<SharedLoad> {
        let load = |(resource, spec): (_, &arch::ResourceSpec)| SharedLoad {
            resource: spec.name.clone(),
            offered: spec.count,
            uses: usage.resources[resource].clone(),
        };
        self.arch.srp.resources.iter().map(load).collect()
    }

    fn links(&self, usage: &Usage) -> Vec<LinkLoad> {
        let load = |(link, spec): (arch::Link, &arch::LinkSpec)| {
            let used: &LinkUse = &usage.links[link];
            let carried = |c: &usage::Carried| Carried {
                slot: c.slot,
                node: c.node.index() as u32,
                file: match c.to {
                    Taker::Op(_) | Taker::Wire(_) => None,
                    Taker::File(file) => Some(self.arch.srp.files[file].name.clone()),
                },
            };
            LinkLoad {
                from: self.arch.srp.fus[spec.from].name.clone(),
                to: self.arch.srp.fus[spec.to].name.clone(),
                width: spec.width,
                delay: spec.delay,
                slots: used.slots(),
                carries: used.carried.iter().map(carried).collect(),
            }
        };
        self.arch.srp.links.iter().map(load).collect()
    }

    fn register_files(&self, usage: &Usage) -> Vec<FileLoad> {
        let load = |(file, spec): (arch::RegFile, &arch::FileSpec)| {
            let used: &FileUse = &usage.files[file];
            let (live, live_slot) = used.worst();
            FileLoad {
                file: spec.name.clone(),
                kind: match spec.kind {
                    arch::FileKind::Rotating => FileKind::Rotating,
                    arch::FileKind::Static => FileKind::Static,
                    arch::FileKind::Central => FileKind::Central,
                },
                unit: match (spec.readers.as_slice(), spec.writers.as_slice()) {
                    ([reader], [writer]) if reader == writer => {
                        Some(self.arch.srp.fus[*reader].name.clone())
                    }
                    _ => None,
                },
                width: spec.width,
                capacity: spec.size,
                live,
                live_slot,
                live_by_slot: used.live.clone(),
                kept: used.kept,
                read: ports(spec.read_ports, used.most_read(), &used.reads),
                write: ports(spec.write_ports, used.most_written(), &used.writes),
            }
        };
        self.arch.srp.files.iter().map(load).collect()
    }

    fn table(&self, schedule: &ModuloSchedule) -> Vec<Vec<Option<Cell>>> {
        let mut table = vec![vec![None; self.arch.srp.fus.len()]; schedule.ii as usize];
        for op in schedule.ops.values() {
            let interval =
                usage::timing(schedule, &self.arch.srp, op).map_or(1, |how| how.interval);
            for after in 0..interval {
                let slot = ((op.time + after) % schedule.ii) as usize;
                table[slot][op.fu.index()] = Some(Cell {
                    held: after > 0,
                    ..self.cell(schedule, op)
                });
            }
        }
        table
    }

    fn cell(&self, schedule: &ModuloSchedule, op: &PlacedOp) -> Cell {
        let dfg = &schedule.dfg;
        let opcode = opcode(schedule, op);
        let operands = op.operands.iter().enumerate();
        Cell {
            op: opcode.name().to_owned(),
            class: opcode.class().name().to_owned(),
            held: false,
            node: op.node.index() as u32,
            is_move: op.is_move,
            stage: op.time / schedule.ii,
            operands: operands.map(|o| self.operand(dfg, op, o)).collect(),
            at: self.position(dfg.nodes[op.node].pos),
        }
    }

    fn operand(&self, dfg: &Dfg, op: &PlacedOp, (i, source): (usize, &Source)) -> String {
        let what = if op.is_move {
            format!("n{}", op.node.index())
        } else {
            match &dfg.nodes[op.node].operands[i] {
                Operand::Const(bits) => return bits.to_string(),
                Operand::LiveIn(k) => format!("live-in {k}"),
                Operand::Node { node, init } if init.is_empty() => format!("n{}", node.index()),
                Operand::Node { node, init } => format!("n{}[−{}]", node.index(), init.len()),
            }
        };
        match *source {
            Source::Const(_) => what,
            Source::Out(None) => format!("{what} of itself"),
            Source::Out(Some(link)) => {
                let from = self.arch.srp.links[link].from;
                format!("{what} of {}", self.arch.srp.fus[from].name)
            }
            Source::Wire(wire) => format!("{what} over {}", self.arch.srp.wires[wire].name),
            Source::Reg { reg, .. } => {
                let file = &self.arch.srp.files[reg.file].name;
                format!("{what} in {file}[{}]", reg.index)
            }
        }
    }
}

/// Returns the nodes that a walk along dependences reaches; `way` may reverse each dependence.
fn reached(dfg: &Dfg, start: Node, way: impl Fn(Node, Node) -> (Node, Node)) -> BTreeSet<Node> {
    let mut next: BTreeMap<Node, Vec<Node>> = BTreeMap::new();
    for (from, to, _) in dfg.deps() {
        let (from, to) = way(from, to);
        next.entry(from).or_default().push(to);
    }
    let (mut seen, mut open) = (BTreeSet::from([start]), vec![start]);
    while let Some(node) = open.pop() {
        let found = next.get(&node).into_iter().flatten();
        open.extend(found.filter(|&&n| seen.insert(n)));
    }
    seen
}

/// How an II stands to its bounds.
fn status(ii: u32, facts: &LoopFacts) -> Status {
    let bound = facts.bounds.min_ii();
    let proof = |lower: u32| facts.impossible.iter().find(|i| i.ii == lower);
    if ii <= bound {
        Status::Bound
    } else if (bound..ii).all(|lower| proof(lower).is_some_and(|proof| proof.outright)) {
        Status::Least
    } else if (bound..ii).all(|lower| proof(lower).is_some()) {
        Status::Proved
    } else {
        Status::Open
    }
}

fn ports(ports: u32, (most, most_slot): (u32, u32), by_slot: &[u32]) -> PortLoad {
    PortLoad {
        ports,
        most,
        most_slot,
        uses: by_slot.iter().sum(),
    }
}
