//! A core that runs on one engine, and in the window on another that records.

use crate::event::Doing;
use crate::listening::Listening;
use crate::shared::{Progress, Room, Shared, Wanted};
use crate::trace::CoreTrace;
use crate::window::{MAX_CYCLES, MAX_RECORDS};
use srp_csimgen::{Record, Recorder, SimSpec};
use srp_runtime::core::{Activity, Bus, Core, CoreState, Run, Trap};
use srp_runtime::system::Stall;
use std::ops::Range;
use std::sync::Arc;

/// A core that runs on one engine, and in the window on another that records.
pub(crate) struct Traced {
    number: u32,
    fast: Box<dyn Core>,
    recorder: Recorder,
    spec: Arc<SimSpec>,
    shared: Shared,
}

impl Core for Traced {
    fn run(&mut self, bus: &mut dyn Bus, budget: u64) -> Result<Run, Trap> {
        let (wanted, mut room, mut core) = self.shared.get().lend(self.number);
        let mut listening = Listening::to(bus, false);
        let bus = &mut listening;
        let run = match (core.begun, core.ended) {
            (None, _) => match self.before(&wanted, &mut core, bus, budget) {
                Ok(None) => self.within(&wanted, &mut core, &mut room, bus, budget),
                Ok(Some(run)) => Ok(run),
                Err(trap) => Err(trap),
            },
            (Some(_), None) => self.within(&wanted, &mut core, &mut room, bus, budget),
            (Some(_), Some(_)) => self.fast.run(bus, budget),
        };
        if let Ok(run) = run {
            core.ran(core.now, run);
            // A system tells of it too, at the same cycle. A program alone has nobody who does.
            if listening.kept > 0 {
                core.does(core.now, Doing::Stands(Stall::Banks));
                core.now += listening.kept;
            }
        }
        self.shared.get().give_back(room, core);
        run
    }

    fn save(&self) -> Option<CoreState> {
        match self.is_recording() {
            true => self.recorder.save(),
            false => self.fast.save(),
        }
    }

    fn restore(&mut self, state: &CoreState) -> bool {
        match self.is_recording() {
            true => self.recorder.restore(state),
            false => self.fast.restore(state),
        }
    }
}

impl Traced {
    /// The core of this number, on this engine.
    pub(crate) fn new(
        number: u32,
        fast: Box<dyn Core>,
        spec: Arc<SimSpec>,
        shared: Shared,
    ) -> Traced {
        Traced {
            number,
            fast,
            recorder: Recorder::new(&spec),
            spec,
            shared,
        }
    }

    fn is_recording(&self) -> bool {
        let state = self.shared.get();
        let core = &state.cores[self.number as usize];
        core.begun.is_some() && core.ended.is_none()
    }

    /// Runs towards the window; `None` where it begins.
    fn before(
        &mut self,
        wanted: &Wanted,
        core: &mut Progress,
        bus: &mut dyn Bus,
        budget: u64,
    ) -> Result<Option<Run>, Trap> {
        match *wanted {
            Wanted::Cycles(_, Some(of)) if of != self.number => {
                return self.fast.run(bus, budget).map(Some);
            }
            Wanted::Cycles(Range { start, .. }, _) if core.now < start => {
                let budget = budget.min(start - core.now);
                return self.fast.run(bus, budget).map(Some);
            }
            Wanted::Cycles(Range { end, .. }, _) if core.now >= end => {
                return self.fast.run(bus, budget).map(Some);
            }
            Wanted::Cycles(..) => {}
            Wanted::Launch {
                kernel,
                number,
                core: of,
            } => {
                if of != self.number || !self.comes_next(kernel, core.last) {
                    return self.fast.run(bus, budget).map(Some);
                }
                core.launches += 1;
                if core.launches != number {
                    return self.fast.run(bus, budget).map(Some);
                }
            }
            Wanted::Tile(tile) => return self.towards_tile(tile, core, bus, budget).map(Some),
        }
        Ok(match self.begin(core) {
            true => None,
            false => Some(self.fast.run(bus, budget)?),
        })
    }

    /// Runs at most to the cycle in which this tile is taken; there the window begins with the next.
    fn towards_tile(
        &mut self,
        tile: u32,
        core: &mut Progress,
        bus: &mut dyn Bus,
        budget: u64,
    ) -> Result<Run, Trap> {
        let mut listening = Listening::to(bus, true);
        let run = self.fast.run(&mut listening, budget)?;
        if !listening.refused {
            return Ok(run);
        }
        // That was a wait for nothing, without effect. Now the tile is taken, in a run of this one cycle.
        let mut listening = Listening::to(bus, false);
        let run = self.fast.run(&mut listening, 1)?;
        if listening.taken == Some(tile) {
            let now = core.now;
            core.now += run.cycles;
            self.begin(core);
            core.now = now;
        }
        Ok(run)
    }

    /// True if the next cycle is the first of a kernel on the array, where the core did `last`.
    fn comes_next(&mut self, kernel: u32, last: Option<Activity>) -> bool {
        let after = match self.spec.kernels[kernel as usize].enter_cycles {
            0 => matches!(last, Some(Activity::Vliw)),
            _ => matches!(last, Some(Activity::Switch)),
        };
        let state = after.then(|| self.fast.save()).flatten();
        let is_restored = state.is_some_and(|state| self.recorder.restore(&state));
        is_restored && self.recorder.next_kernel() == Some(kernel)
    }

    /// Lets the recorder go on where the engine is. `false` if that keeps its state to itself.
    fn begin(&mut self, core: &mut Progress) -> bool {
        let state = self.fast.save();
        let is_restored = state.is_some_and(|state| self.recorder.restore(&state));
        if is_restored {
            core.trace.start = self.recorder.snapshot();
            core.begun = Some(core.now);
        }
        is_restored
    }

    /// Runs in the window, or beyond it where that ends.
    fn within(
        &mut self,
        wanted: &Wanted,
        core: &mut Progress,
        room: &mut Room,
        bus: &mut dyn Bus,
        budget: u64,
    ) -> Result<Run, Trap> {
        let (now, begun) = (core.now, core.begun.unwrap_or(core.now));
        let last = match *wanted {
            Wanted::Cycles(Range { end, .. }, _) => end,
            Wanted::Launch { .. } | Wanted::Tile(_) => begun + MAX_CYCLES,
        };
        let is_over = match *wanted {
            Wanted::Launch { kernel, .. } => self.recorder.next_kernel() != Some(kernel),
            Wanted::Cycles(..) | Wanted::Tile(_) => false,
        };
        let is_full =
            room.records >= MAX_RECORDS || (now >= last && !matches!(wanted, Wanted::Cycles(..)));
        if is_over || is_full || now >= last {
            room.is_cut |= is_full && !is_over;
            return self.end(core, bus, budget);
        }
        let records = &mut core.trace.records;
        let before = records.len();
        // So that no more than one run goes beyond what there is room for.
        let budget = budget.min(last - now).min(MAX_BUDGET);
        let mut listening = Listening::to(bus, matches!(wanted, Wanted::Tile(_)));
        let run = self.recorder.run(&mut listening, budget, records);
        if listening.refused {
            return self.end(core, bus, budget);
        }
        room.records += records.len() - before;
        stamp(&mut core.trace, before, now);
        run
    }

    /// Ends the window, and goes on as fast as before it.
    fn end(&mut self, core: &mut Progress, bus: &mut dyn Bus, budget: u64) -> Result<Run, Trap> {
        let state = self.recorder.save();
        if state.is_some_and(|state| self.fast.restore(&state)) {
            core.ended = Some(core.now);
            return self.fast.run(bus, budget);
        }
        // Nothing but a trap follows.
        self.recorder.run(bus, budget, &mut Vec::new())
    }
}

/// Most cycles of a run that is recorded.
const MAX_BUDGET: u64 = 1 << 12;

/// Notes where the cycles of a run begin in the records, from `first` on.
fn stamp(trace: &mut CoreTrace, first: usize, now: u64) {
    let mut cycle = now;
    let mut begin = first;
    for (i, record) in trace.records.iter().enumerate().skip(first) {
        match record {
            // It belongs to the cycle that follows.
            Record::Entered(_) => begin = i,
            Record::Bundle(_) | Record::Context { .. } => {
                let is_entered =
                    begin + 1 == i && begin >= first && is_entry(&trace.records[begin]);
                trace
                    .turns
                    .push((cycle, if is_entered { begin } else { i }));
                cycle += 1;
            }
            _ => {}
        }
    }
}

fn is_entry(record: &Record) -> bool {
    matches!(record, Record::Entered(_))
}
