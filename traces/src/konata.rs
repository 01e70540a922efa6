//! A pipeline in the format of Konata (`Kanata` 0004): a line for each operation, transfer and branch.
//!
//! An operation is *issued* (`Is`), on its way (`Ex`), and in its last cycle its result goes to its places (`Wb`);
//! an operation of one cycle has `Is` only. While the core stands still, its operations are in `St`. Arrows go from an
//! operation to those that read its result.

use crate::event::{Doing, Done, Event, What};
use crate::flow::Flow;
use crate::names::{Names, control, short_place};
use crate::replay::replay;
use crate::trace::Trace;
use srp_archdesc::isa::Ty;
use srp_csimgen::SimSpec;
use srp_csimgen::preamble::ops::V4;
use srp_csimgen::spec::{Origin, Role};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// The bytes of a file with the pipeline of a trace.
pub fn write(trace: &Trace) -> Vec<u8> {
    let mut writer = Writer {
        spec: &trace.spec,
        names: &trace.names,
        text: format!("Kanata\t0004\nC=\t{}\n", trace.cycles.start),
        time: trace.cycles.start,
        next: 0,
        retired: 0,
        cores: BTreeMap::new(),
    };
    for core in &trace.cores {
        writer.cores.insert(core.core, Core::default());
    }
    replay(trace, &mut |event| writer.take(&event));
    writer.finish(trace.cycles.end);
    writer.text.into_bytes()
}

/// An operation that is not over.
struct InFlight {
    line: u64,
    /// Cycles in which the core advances until it is.
    left: u32,
    stage: &'static str,
}

#[derive(Default)]
struct Core {
    in_flight: Vec<InFlight>,
    /// The lines whose results registers have.
    flow: Flow<u64>,
    /// The cycle of the turn that is being taken, until it is over.
    turn: Option<u64>,
}

struct Writer<'t> {
    spec: &'t SimSpec,
    names: &'t Names,
    text: String,
    time: u64,
    next: u64,
    retired: u64,
    cores: BTreeMap<u32, Core>,
}

impl Writer<'_> {
    fn take(&mut self, event: &Event<'_>) {
        if !self.cores.contains_key(&event.core) {
            return;
        }
        self.end_turns(event.cycle);
        self.to(event.cycle);
        match event.what {
            What::Turn(_) => self.turn(event.core, event.cycle),
            What::Control(transfer, at) => {
                let label = control(self.spec, transfer);
                let label = format!("vliw {label}");
                let line = self.line(event.core, &label, short_place(self.spec, at), None);
                self.issue(event.core, line, 1);
            }
            What::Step(done) => self.step(event.core, &done),
            What::Does(Doing::Stands(_)) => self.stand(event.core),
            What::Preset(cell, _, source) => {
                self.cores
                    .entry(event.core)
                    .or_default()
                    .flow
                    .set(cell, source);
            }
            What::Does(Doing::Runs(_)) | What::Cell(..) | What::Outside(_) => {}
        }
    }

    /// Goes to a cycle.
    fn to(&mut self, cycle: u64) {
        if cycle > self.time {
            let _ = writeln!(self.text, "C\t{}", cycle - self.time);
            self.time = cycle;
        }
    }

    /// Ends the turns of cycles before this one: one after them, what is over is retired.
    fn end_turns(&mut self, cycle: u64) {
        let open = self
            .cores
            .iter()
            .filter_map(|(&n, core)| core.turn.map(|t| (t, n)));
        let mut open: Vec<(u64, u32)> = open.filter(|&(turn, _)| turn < cycle).collect();
        open.sort_unstable();
        for (turn, number) in open {
            self.to(turn + 1);
            self.end_turn(number);
        }
    }

    fn end_turn(&mut self, number: u32) {
        let core = self.cores.entry(number).or_default();
        core.turn = None;
        let Writer { text, retired, .. } = self;
        core.flow.end_turn();
        core.in_flight.retain_mut(|op| {
            op.left -= 1;
            if op.left > 0 {
                return true;
            }
            let _ = writeln!(text, "E\t{}\t0\t{}", op.line, op.stage);
            let _ = writeln!(text, "R\t{}\t{retired}\t0", op.line);
            *retired += 1;
            false
        });
    }

    /// The operations in flight come into the stages of this cycle.
    fn turn(&mut self, number: u32, cycle: u64) {
        let core = self.cores.entry(number).or_default();
        core.turn = Some(cycle);
        for op in &mut core.in_flight {
            let stage = if op.left == 1 { "Wb" } else { "Ex" };
            enter(&mut self.text, op, stage);
        }
    }

    fn stand(&mut self, number: u32) {
        let core = self.cores.entry(number).or_default();
        for op in &mut core.in_flight {
            enter(&mut self.text, op, "St");
        }
    }

    /// Begins a line.
    fn line(&mut self, core: u32, label: &str, place: &str, iteration: Option<u64>) -> u64 {
        let line = self.next;
        self.next += 1;
        let _ = writeln!(self.text, "I\t{line}\t{line}\t{core}");
        let _ = write!(self.text, "L\t{line}\t0\t");
        if let Some(iteration) = iteration {
            let _ = write!(self.text, "{iteration}: ");
        }
        let _ = writeln!(self.text, "{label}  {place}");
        line
    }

    /// Issues a line that takes so many cycles.
    fn issue(&mut self, number: u32, line: u64, cycles: u32) {
        let _ = writeln!(self.text, "S\t{line}\t0\tIs");
        let core = self.cores.entry(number).or_default();
        core.in_flight.push(InFlight {
            line,
            left: cycles.max(1),
            stage: "Is",
        });
    }

    fn step(&mut self, number: u32, done: &Done<'_>) {
        let step = done.step;
        let (who, latency) = match step.origin {
            Origin::Unit { unit, latency } => (self.names.unit(unit), latency),
            Origin::Over { carrier, latency } => (self.names.carrier(carrier), latency),
            // Whoever reads it there reads the result of the same line.
            Origin::Way => {
                return self.cores.entry(number).or_default().flow.pass_on(done);
            }
        };
        let label = self.label(who, done);
        let place = short_place(self.spec, step.at);
        let line = self.line(number, &label, place, done.iteration);
        let detail = detail(done);
        let _ = writeln!(self.text, "L\t{line}\t1\t{detail}");
        let core = self.cores.entry(number).or_default();
        let producers: BTreeSet<u64> = core.flow.producers(done).into_iter().flatten().collect();
        core.flow.make(done, line);
        self.issue(number, line, latency);
        for producer in producers {
            let _ = writeln!(self.text, "W\t{line}\t{producer}\t0");
        }
    }

    fn label(&self, who: &str, done: &Done<'_>) -> String {
        let name = done.step.opcode().map_or("transfer", |op| op.name());
        let mut label = format!("{who} {name}");
        let count = operands(done);
        for i in 0..count {
            let _ = write!(label, "{}", if i == 0 { " " } else { ", " });
            let _ = match done.sources[i] {
                Some(cell) => write!(label, "{}", self.names.cell(self.spec, cell)),
                None => write!(label, "{}", value(done.operands[i], ty_of(done, i))),
            };
        }
        // Where a result is on its way has no name of the machine.
        let is_place = |cell: &&u32| {
            let store = &self.spec.stores[self.names.store_of(**cell) as usize];
            !matches!(store.role, Role::Flight(_))
        };
        if let Some(&dest) = done.dests.iter().find(is_place) {
            let _ = write!(label, " -> {}", self.names.cell(self.spec, dest));
        }
        label
    }

    /// Ends what is not over: it is flushed.
    fn finish(&mut self, end: u64) {
        self.end_turns(end.max(self.time + 1));
        self.to(end);
        let cores = std::mem::take(&mut self.cores);
        for op in cores.into_values().flat_map(|core| core.in_flight) {
            let _ = writeln!(self.text, "E\t{}\t0\t{}", op.line, op.stage);
            let _ = writeln!(self.text, "R\t{}\t{}\t1", op.line, self.retired);
            self.retired += 1;
        }
    }
}

/// Brings an operation into a stage.
fn enter(text: &mut String, op: &mut InFlight, stage: &'static str) {
    if op.stage != stage {
        let _ = writeln!(text, "E\t{}\t0\t{}", op.line, op.stage);
        let _ = writeln!(text, "S\t{}\t0\t{stage}", op.line);
        op.stage = stage;
    }
}

fn operands(done: &Done<'_>) -> usize {
    let op = done.step.opcode();
    op.map_or(1, |op| op.info().operands.len()).min(3)
}

fn ty_of(done: &Done<'_>, operand: usize) -> Ty {
    let kinds = done.step.opcode().map(|op| op.info().operands);
    let kind = kinds.and_then(|kinds| kinds.get(operand));
    kind.map_or(done.step.ty.unwrap_or(Ty::Word), |kind| kind.ty())
}

/// A value in hexadecimal digits, lane 0 first.
fn value(V4(lanes): V4, ty: Ty) -> String {
    match ty {
        Ty::Pred => lanes[0].to_string(),
        Ty::Word => format!("{:#x}", lanes[0]),
        Ty::Vec => {
            let [x, y, z, w] = lanes;
            format!("({x:#x} {y:#x} {z:#x} {w:#x})")
        }
    }
}

/// The values of a line: operands, result, address.
fn detail(done: &Done<'_>) -> String {
    let values = (0..operands(done)).map(|i| value(done.operands[i], ty_of(done, i)));
    let mut text = values.collect::<Vec<_>>().join(", ");
    if let Some(ty) = done.step.ty {
        let _ = write!(text, " = {}", value(done.value, ty));
    }
    if let Some(address) = done.address() {
        let _ = write!(text, " at {address:#x}");
    }
    text
}
