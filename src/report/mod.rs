//! The report of initiation intervals: what every loop reached, what bounds it, and what stands
//! where in the modulo reservation table. Text, JSON and one self-contained page show the same data.

mod command;
mod html;
mod text;

pub(crate) use command::run;
use html::page;
pub(crate) use text::not_pipelined;
use text::text;

use crate::failure::Failure;
use crate::interrupt;
use crate::pipeline::Compiled;
use serde::Serialize;
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::Opcode;
use srp_ir::dfg::{Dfg, Node, Operand};
use srp_ir::dre::scheduled::{ModuloSchedule, PlacedOp, Source};
use srp_ir::program::{Pos, SourceFile};
use srp_ir::split::Remark;
use srp_scheduler::LoopFacts;

/// The report of a program on a machine.
#[derive(Serialize)]
pub(crate) struct Report {
    /// The machine's name.
    pub(crate) machine: String,
    /// Whether the search for schedules went its whole way; not where it was interrupted.
    pub(crate) complete: bool,
    /// Loops on the array, in program order.
    pub(crate) loops: Vec<LoopReport>,
    /// Loops that were to run on the array and do not.
    pub(crate) not_pipelined: Vec<NotPipelined>,
}

impl Report {
    /// Leaves out all loops but those of one name.
    pub(crate) fn keep_only(&mut self, kernel: &str) -> Result<(), Failure> {
        let names = self.loops.iter().map(|l| l.kernel.clone());
        let names: Vec<String> = names
            .chain(self.not_pipelined.iter().map(|n| n.kernel.clone()))
            .collect();
        self.loops.retain(|l| l.kernel == kernel);
        self.not_pipelined.retain(|n| n.kernel == kernel);
        if self.loops.is_empty() && self.not_pipelined.is_empty() {
            let names = names.join(", ");
            return Err(Failure::Message(format!(
                "no kernel is named {kernel}; there are {names}"
            )));
        }
        Ok(())
    }
}

/// A loop on the array.
#[derive(Serialize)]
pub(crate) struct LoopReport {
    /// The kernel's name.
    pub(crate) kernel: String,
    /// Where the loop statement is.
    pub(crate) at: Position,
    /// Operations of an iteration.
    pub(crate) operations: usize,
    /// Routing moves of an iteration.
    pub(crate) moves: usize,
    /// Initiation interval, cycles.
    pub(crate) ii: u32,
    /// Bound set by units and shared resources.
    pub(crate) res_mii: u32,
    /// What sets it.
    pub(crate) res_mii_why: String,
    /// Bound set by recurrences.
    pub(crate) rec_mii: u32,
    /// The recurrence that sets it, in order.
    pub(crate) recurrence: Vec<Step>,
    /// Why the II is above both bounds, if it is.
    pub(crate) why_not_lower: Option<String>,
    /// Lower IIs that were proved impossible.
    pub(crate) impossible: Vec<Impossible>,
    /// Changes of the machine that lower the II; empty unless they were asked for.
    pub(crate) what_if: Vec<Change>,
    /// Accesses that are kept in order because nothing shows that they need not be.
    pub(crate) ordered: Vec<Ordered>,
    /// Iterations that overlap.
    pub(crate) stages: u32,
    /// Cycles of one iteration from its first issue to its last result.
    pub(crate) length: u32,
    /// Contexts of the configuration memory.
    pub(crate) contexts: u32,
    /// Registers set when the kernel is entered.
    pub(crate) preloads: usize,
    /// Cycles an iteration takes where a launch runs as many as a ray buffer holds, entry and exit
    /// included.
    pub(crate) cycles_per_ray: f64,
    /// Issue slots taken of each unit, by name.
    pub(crate) utilisation: Vec<UnitLoad>,
    /// The modulo reservation table: a row a slot, a cell a unit.
    pub(crate) table: Vec<Vec<Option<Cell>>>,
}

/// A change of the machine.
#[derive(Serialize)]
pub(crate) struct Change {
    /// What changes.
    pub(crate) what: String,
    /// The II that the loop then has.
    pub(crate) ii: u32,
}

/// A proof that there is no schedule with this II.
#[derive(Serialize)]
pub(crate) struct Impossible {
    /// The II.
    pub(crate) ii: u32,
    /// It holds where no operation is issued later than so many cycles after its latest start on
    /// the critical path.
    pub(crate) slack: u32,
}

/// Two memory accesses that are kept in order.
#[derive(Serialize)]
pub(crate) struct Ordered {
    /// The one.
    pub(crate) first: Position,
    /// The other.
    pub(crate) second: Position,
    /// What is not known of them.
    pub(crate) why: String,
}

/// A source position.
#[derive(Clone, Serialize)]
pub(crate) struct Position {
    /// The file.
    pub(crate) file: String,
    /// The line, from 1; 0 where there is none.
    pub(crate) line: u32,
    /// The column, from 1.
    pub(crate) column: u32,
}

impl std::fmt::Display for Position {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.line == 0 {
            return f.write_str("(made by the compiler)");
        }
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// A step of a recurrence.
#[derive(Serialize)]
pub(crate) struct Step {
    /// The operation.
    pub(crate) op: &'static str,
    /// Cycles until its result can be read.
    pub(crate) latency: u32,
    /// Where it comes from.
    pub(crate) at: Position,
}

/// How busy a unit is.
#[derive(Serialize)]
pub(crate) struct UnitLoad {
    /// The unit's name.
    pub(crate) unit: String,
    /// Its row, from 0 at the top.
    pub(crate) row: u32,
    /// Its column, from 0 at the left.
    pub(crate) column: u32,
    /// Slots of the II in which it issues an operation of the loop.
    pub(crate) operations: u32,
    /// Slots in which it issues a routing move.
    pub(crate) moves: u32,
    /// Slots in which it can issue nothing yet, because of an operation before.
    pub(crate) held: u32,
}

impl UnitLoad {
    /// Slots in which it can issue nothing else.
    fn busy(&self) -> u32 {
        self.operations + self.moves + self.held
    }
}

/// What a unit issues in a slot.
#[derive(Clone, Serialize)]
pub(crate) struct Cell {
    /// The operation.
    pub(crate) op: &'static str,
    /// Its class.
    pub(crate) class: &'static str,
    /// Whether it was issued before, and the unit cannot issue again yet.
    pub(crate) held: bool,
    /// Its number in the loop.
    pub(crate) node: usize,
    /// Whether it only moves the value of that operation.
    pub(crate) is_move: bool,
    /// Its stage.
    pub(crate) stage: u32,
    /// Its operands, in words.
    pub(crate) operands: Vec<String>,
    /// Where it comes from.
    pub(crate) at: Position,
}

/// A loop that was to run on the array and does not.
#[derive(Serialize)]
pub(crate) struct NotPipelined {
    /// The kernel's name.
    pub(crate) kernel: String,
    /// Where the loop statement is.
    pub(crate) at: Position,
    /// What is in the way.
    pub(crate) reason: String,
    /// Where that is.
    pub(crate) reason_at: Position,
    /// Whether a pragma asked for it.
    pub(crate) required: bool,
}

/// The report of a compiled program.
pub(crate) fn report(compiled: &Compiled, arch: &Arch) -> Report {
    let program = &compiled.schedule.program;
    let files = &program.files;
    let view = View {
        files,
        arch,
        remarks: &compiled.remarks,
    };
    let loops = program.kernels.iter();
    Report {
        machine: arch.name.clone(),
        complete: !interrupt::requested(),
        loops: loops
            .map(|(k, s)| view.of_loop(s, &compiled.schedule.loops[k]))
            .collect(),
        not_pipelined: compiled
            .not_pipelined
            .iter()
            .map(|n| view.not_pipelined(n))
            .collect(),
    }
}

/// What names and positions are looked up in.
struct View<'a> {
    files: &'a EntityMap<SourceFile, String>,
    arch: &'a Arch,
    remarks: &'a [Remark],
}

impl View<'_> {
    fn position(&self, pos: Pos) -> Position {
        let file = self.files.get(pos.file).cloned().unwrap_or_default();
        Position {
            file,
            line: pos.line,
            column: pos.column,
        }
    }

    fn not_pipelined(&self, n: &srp_ir::split::NotPipelined) -> NotPipelined {
        NotPipelined {
            kernel: n.name.clone(),
            at: self.position(n.pos),
            reason: n.reason.clone(),
            reason_at: self.position(n.at),
            required: n.required,
        }
    }

    fn of_loop(&self, schedule: &ModuloSchedule, facts: &LoopFacts) -> LoopReport {
        let dfg = &schedule.dfg;
        let arch = self.arch;
        let rays = arch.system.buffers.rays;
        let entry = (schedule.preloads.len() as u32).div_ceil(arch.preload_width.max(1));
        let launch = entry + 2 * arch.mode_switch + schedule.ii * (rays - 1) + schedule.length;
        let moves = schedule.ops.values().filter(|op| op.is_move).count();
        let step = |&node: &Node| Step {
            op: dfg.nodes[node].op.name(),
            latency: self.latency(schedule, node),
            at: self.position(dfg.nodes[node].pos),
        };
        let impossible = |i: &srp_scheduler::modulo::Impossible| Impossible {
            ii: i.ii,
            slack: i.slack,
        };
        LoopReport {
            kernel: dfg.name.clone(),
            at: self.position(dfg.pos),
            operations: dfg.nodes.len(),
            moves,
            ii: schedule.ii,
            res_mii: facts.bounds.resources,
            res_mii_why: facts.bounds.resources_why.clone(),
            rec_mii: facts.bounds.recurrences,
            recurrence: facts.bounds.critical_cycle.iter().map(step).collect(),
            why_not_lower: facts.obstacle.clone(),
            impossible: facts.impossible.iter().map(impossible).collect(),
            what_if: Vec::new(),
            ordered: self.ordered(&dfg.name),
            stages: schedule.stages(),
            length: schedule.length,
            contexts: schedule.contexts(),
            preloads: schedule.preloads.len(),
            cycles_per_ray: f64::from(launch) / f64::from(rays),
            utilisation: self.utilisation(schedule),
            table: self.table(schedule),
        }
    }

    fn ordered(&self, kernel: &str) -> Vec<Ordered> {
        let of_kernel = self.remarks.iter().filter(|r| r.kernel == kernel);
        let ordered = |r: &Remark| Ordered {
            first: self.position(r.first),
            second: self.position(r.second),
            why: r.text.clone(),
        };
        of_kernel.map(ordered).collect()
    }

    fn latency(&self, schedule: &ModuloSchedule, node: Node) -> u32 {
        let class = schedule.dfg.nodes[node].op.class();
        let placed = schedule
            .ops
            .values()
            .find(|op| op.node == node && !op.is_move);
        placed
            .and_then(|op| self.arch.fus[op.fu].op(class))
            .map_or(1, |op| op.latency)
    }

    fn utilisation(&self, schedule: &ModuloSchedule) -> Vec<UnitLoad> {
        let load = |(fu, spec): (_, &srp_archdesc::arch::FuSpec)| {
            let ops = schedule.ops.values().filter(|op| op.fu == fu);
            let held = ops.clone().map(|op| self.interval(schedule, op) - 1).sum();
            let (moves, operations): (Vec<_>, Vec<_>) = ops.partition(|op| op.is_move);
            UnitLoad {
                unit: spec.name.clone(),
                row: spec.row,
                column: spec.col,
                operations: operations.len() as u32,
                moves: moves.len() as u32,
                held,
            }
        };
        self.arch.fus.iter().map(load).collect()
    }

    fn table(&self, schedule: &ModuloSchedule) -> Vec<Vec<Option<Cell>>> {
        let mut table = vec![vec![None; self.arch.fus.len()]; schedule.ii as usize];
        for op in schedule.ops.values() {
            for after in 0..self.interval(schedule, op) {
                let slot = ((op.time + after) % schedule.ii) as usize;
                table[slot][op.fu.index()] = Some(Cell {
                    held: after > 0,
                    ..self.cell(schedule, op)
                });
            }
        }
        table
    }

    /// Cycles from an operation's issue until its unit can issue again.
    fn interval(&self, schedule: &ModuloSchedule, op: &PlacedOp) -> u32 {
        let class = opcode(&schedule.dfg, op).class();
        self.arch.fus[op.fu].op(class).map_or(1, |o| o.interval)
    }

    fn cell(&self, schedule: &ModuloSchedule, op: &PlacedOp) -> Cell {
        let dfg = &schedule.dfg;
        let data = &dfg.nodes[op.node];
        let opcode = opcode(dfg, op);
        Cell {
            op: opcode.name(),
            class: opcode.class().name(),
            held: false,
            node: op.node.index(),
            is_move: op.is_move,
            stage: op.time / schedule.ii,
            operands: op
                .operands
                .iter()
                .enumerate()
                .map(|o| self.operand(dfg, op, o))
                .collect(),
            at: self.position(data.pos),
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
                format!(
                    "{what} of {}",
                    self.arch.fus[self.arch.links[link].from].name
                )
            }
            Source::Reg { reg, .. } => {
                format!(
                    "{what} in {}[{}]",
                    self.arch.files[reg.file].name, reg.index
                )
            }
        }
    }
}

/// What a unit is told to do.
fn opcode(dfg: &Dfg, op: &PlacedOp) -> Opcode {
    if op.is_move {
        Opcode::mov(dfg.ty(op.node).expect("only values are moved"))
    } else {
        dfg.nodes[op.node].op
    }
}
