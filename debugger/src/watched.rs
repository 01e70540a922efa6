//! A core whose every cycle is noted: where it is, and which values variables and iterations have.

use crate::code::Code;
use crate::kept::StepOf;
use crate::variables::Name;
use srp_archdesc::isa::Ty;
use srp_csimgen::preamble::ops::V4;
use srp_csimgen::preamble::sequencer::Place;
use srp_csimgen::spec::{Position, Step};
use srp_csimgen::{Record, Recorder, SimSpec, Snapshot};
use srp_runtime::core::{Bus, Core, CoreState, Run, Trap};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Iterations behind those on their way that are remembered.
const REMEMBERED: u64 = 16;

/// A value that a step has made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Made {
    pub(crate) value: V4,
    pub(crate) ty: Ty,
    pub(crate) at: Position,
    /// The value that the variable had before.
    pub(crate) before: Option<V4>,
    /// The pass through a block in which it was made.
    pub(crate) stretch: u64,
}

/// Notes of an open call.
#[derive(Clone, Debug, Default)]
pub(crate) struct Call {
    pub(crate) variables: BTreeMap<Name, Made>,
    /// The passes through blocks so far.
    pub(crate) stretch: u64,
    /// The bundle that ran last.
    pub(crate) last: Option<u32>,
}

/// What is noted of a core.
#[derive(Clone, Debug)]
pub(crate) struct Marks {
    /// Where it goes on.
    pub(crate) place: Place,
    /// What it did last.
    pub(crate) done: Option<Place>,
    /// The bundle with lines that it issued last.
    pub(crate) last_lines: Option<u32>,
    /// Cycles in which it has advanced.
    pub(crate) turns: u64,
    /// Notes of each open call, that of `main`'s caller first.
    pub(crate) calls: Vec<Call>,
    /// The live-ins of the last launch.
    pub(crate) live_ins: Vec<V4>,
    /// Launches of each kernel.
    pub(crate) launches: Vec<u64>,
    /// The iterations of the last launch: their values in the order in which they were made.
    pub(crate) iterations: VecDeque<(u64, Vec<(StepOf, V4)>)>,
    /// The trap that ended it.
    pub(crate) trap: Option<Trap>,
}

/// A core and what is noted of it.
pub(crate) struct Watched {
    recorder: Recorder,
    tape: Vec<Record>,
    pub(crate) marks: Marks,
    spec: Arc<SimSpec>,
    code: Arc<Code>,
}

/// A core that a system runs and a session looks into.
#[derive(Clone)]
pub(crate) struct Shared(Arc<Mutex<Watched>>);

impl Shared {
    pub(crate) fn new(spec: &Arc<SimSpec>, code: &Arc<Code>) -> Shared {
        let recorder = Recorder::new(spec);
        let marks = Marks {
            place: recorder.place(),
            done: None,
            last_lines: None,
            turns: 0,
            calls: vec![Call::default()],
            live_ins: Vec::new(),
            launches: vec![0; spec.kernels.len()],
            iterations: VecDeque::new(),
            trap: None,
        };
        Shared(Arc::new(Mutex::new(Watched {
            recorder,
            tape: Vec::new(),
            marks,
            spec: Arc::clone(spec),
            code: Arc::clone(code),
        })))
    }

    pub(crate) fn get(&self) -> MutexGuard<'_, Watched> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Core for Shared {
    /// Runs one cycle, so that a session can stop before any.
    fn run(&mut self, bus: &mut dyn Bus, _: u64) -> Result<Run, Trap> {
        self.get().run(bus)
    }

    fn save(&self) -> Option<CoreState> {
        self.get().recorder.save()
    }

    fn restore(&mut self, state: &CoreState) -> bool {
        self.get().recorder.restore(state)
    }
}

impl Watched {
    fn run(&mut self, bus: &mut dyn Bus) -> Result<Run, Trap> {
        self.tape.clear();
        let before = self.recorder.place();
        if let Place::Context {
            kernel,
            slot: 0,
            iteration: 0,
            ..
        } = before
        {
            let snapshot = self.recorder.snapshot();
            let cells = self.code.kernels[kernel as usize].live_ins.iter();
            let value = |&cell: &u32| snapshot.cells.get(cell as usize).copied();
            self.marks.live_ins = cells.map(|cell| value(cell).unwrap_or_default()).collect();
        }
        let run = self.recorder.run(bus, 1, &mut self.tape);
        match &run {
            Ok(_) => self.note(before),
            Err(trap) => self.marks.trap = Some(trap.clone()),
        }
        self.marks.place = self.recorder.place();
        run
    }

    fn note(&mut self, before: Place) {
        let tape = std::mem::take(&mut self.tape);
        for (i, record) in tape.iter().enumerate() {
            match *record {
                Record::Bundle(number) => {
                    self.bundle(number, &tape[i + 1..]);
                    break;
                }
                Record::Context { .. } => {
                    self.context(before, &tape[i + 1..]);
                    break;
                }
                _ => {}
            }
        }
        self.tape = tape;
        if let (Place::Bundle(from), place) = (before, self.recorder.place())
            && place != Place::Bundle(from + 1)
        {
            let depth = self.recorder.open_calls().count() + 1;
            self.marks.calls.resize_with(depth, Call::default);
        }
        if let Place::Context { kernel, .. } = before
            && !matches!(self.recorder.place(), Place::Context { .. })
        {
            self.leave(kernel);
        }
        self.marks.done = Some(before);
        self.marks.turns += 1;
    }

    fn bundle(&mut self, number: u32, values: &[Record]) {
        let bundle = &self.spec.bundles[number as usize];
        let names = &self.code.bundle_names[number as usize];
        if let Some(call) = self.marks.calls.last_mut() {
            call.stretch += u64::from(!self.code.goes_on(call.last, number));
            call.last = Some(number);
            for ((step, names), record) in bundle.steps.iter().zip(names).zip(values) {
                for name in names {
                    let last = call.variables.get(name).map(|last| last.value);
                    let made = made(step, record, last, call.stretch);
                    call.variables.extend(made.map(|made| (*name, made)));
                }
            }
        }
        if !self.code.bundles[number as usize].is_empty() {
            self.marks.last_lines = Some(number);
        }
    }

    fn context(&mut self, place: Place, values: &[Record]) {
        let Place::Context {
            kernel,
            slot,
            iteration,
            stages,
        } = place
        else {
            return;
        };
        let marks = &mut self.marks;
        if (slot, iteration) == (0, 0) {
            marks.launches[kernel as usize] += 1;
            marks.iterations.clear();
            marks.last_lines = None;
        }
        if slot == 0 && stages & 1 != 0 {
            marks.iterations.push_back((iteration, Vec::new()));
        }
        let kept = REMEMBERED + u64::from(self.code.kernels[kernel as usize].stages);
        while marks.iterations.len() as u64 > kept {
            marks.iterations.pop_front();
        }
        let mut values = values.iter();
        let steps = &self.spec.kernels[kernel as usize].contexts[slot as usize];
        for (number, step) in (0..).zip(steps) {
            if step.stage.is_some_and(|stage| stages >> stage & 1 == 0) {
                continue;
            }
            let (Some(&Record::Value(value)), Some(stage)) = (values.next(), step.stage) else {
                continue;
            };
            let of = iteration.wrapping_sub(u64::from(stage));
            let first = marks.iterations.front().map_or(0, |(first, _)| *first);
            let entry = marks.iterations.get_mut(of.wrapping_sub(first) as usize);
            if let Some((_, values)) = entry {
                values.push(((slot, number), value));
            }
        }
    }

    /// Hands what a kernel has kept of variables to the call that has launched it.
    fn leave(&mut self, kernel: u32) {
        let of = &self.code.kernels[kernel as usize].of;
        let at = self.spec.kernels[kernel as usize].at;
        let Some(call) = self.marks.calls.last_mut() else {
            return;
        };
        // What the kernel makes and does not keep is over.
        let names = of.names.values().flatten().chain(of.refused.keys());
        for name in names {
            call.variables.remove(name);
        }
        let Some((last, values)) = self.marks.iterations.back() else {
            return;
        };
        for (&name, kept) in &of.kept {
            call.variables.remove(&name);
            let mut made = values.iter().rev();
            let made = made.find(|(step, _)| Some(*step) == kept.update);
            let value = match made {
                Some(&(_, value)) => Some(value),
                None => kept.counted(&self.marks.live_ins, last + 1),
            };
            let stretch = call.stretch;
            let made = value.map(|value| Made {
                value,
                ty: kept.ty,
                at,
                before: None,
                stretch: stretch.wrapping_sub(1),
            });
            call.variables.extend(made.map(|made| (name, made)));
        }
    }

    pub(crate) fn snapshot(&self) -> Snapshot {
        self.recorder.snapshot()
    }

    /// The positions of the open calls, innermost first.
    pub(crate) fn open_calls(&self) -> Vec<Position> {
        self.recorder.open_calls().collect()
    }
}

fn made(step: &Step, record: &Record, before: Option<V4>, stretch: u64) -> Option<Made> {
    let Record::Value(value) = *record else {
        return None;
    };
    let ty = step.ty?;
    Some(Made {
        value,
        ty,
        at: step.at,
        before,
        stretch,
    })
}
