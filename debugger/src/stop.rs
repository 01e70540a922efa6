//! Where a session stops: breakpoints, watched bytes, and goals that are reached.

use crate::breakpoint::Place as Where;
use crate::session::{Goal, Reason, Session, Stopped, Until};
use crate::watched::Marks;
use srp_csimgen::preamble::sequencer::Place;

impl Session<'_> {
    /// The stop of this instant, if it is one.
    pub(crate) fn stop(&mut self, goal: &Goal, counts: bool) -> Option<Stopped> {
        let changed = self.changed();
        for core in 0..self.cores.len() {
            let marks = self.moved(core);
            if let Some(stop) = marks.and_then(|marks| self.met(core as u32, &marks, counts)) {
                return Some(stop);
            }
        }
        if let Some(stop) = self.cycle_met(goal.core) {
            return Some(stop);
        }
        if let Some((id, text, core)) = changed {
            return Some(self.stopped(Reason::Watch(id, text), core));
        }
        let marks = self.moved(goal.core as usize)?;
        let stop = self.stopped(Reason::Step, goal.core);
        if let (Until::Line, Place::Context { .. }) = (goal.until, marks.place) {
            let iteration = goal.iteration.and_then(|of| self.further(goal, &marks, of));
            return iteration.map(|iteration| Stopped {
                iteration: Some(iteration),
                ..stop
            });
        }
        self.is_reached(goal, &marks).then_some(stop)
    }

    /// What is to be known of a core that has advanced: where it goes on, what it did last, its last bundle with
    /// lines, its open calls, and its launches of the kernel that it goes on with.
    fn moved(&self, core: usize) -> Option<Moved> {
        let watched = self.cores[core].get();
        let marks = &watched.marks;
        (marks.turns != self.turns[core]).then(|| Moved::of(marks))
    }

    /// True if a line of VLIW code begins.
    fn begins_line(&self, moved: &Moved) -> bool {
        let Place::Bundle(number) = moved.place else {
            return false;
        };
        let lines = &self.code.bundles[number as usize];
        let last = moved
            .last_lines
            .map(|last| &self.code.bundles[last as usize]);
        let is_back = moved.last_lines.is_some_and(|last| number <= last);
        !lines.is_empty() && (is_back || last.is_none_or(|last| last.first() != lines.first()))
    }

    fn is_reached(&self, goal: &Goal, moved: &Moved) -> bool {
        let on_array = match moved.place {
            Place::Context {
                slot, iteration, ..
            } => Some((slot, iteration)),
            _ => None,
        };
        match (goal.until, on_array) {
            (Until::Breakpoint, _) => false,
            (Until::Cycle, _) => true,
            (Until::Into, Some(at)) => goal.on_array || at == (0, 0),
            (Until::Line | Until::Out, Some(_)) => false,
            (Until::Into, None) => self.begins_line(moved),
            (Until::Line, None) => self.begins_line(moved) && moved.depth <= goal.depth,
            (Until::Out, None) => {
                let is_out = match goal.on_array {
                    true => moved.depth <= goal.depth,
                    false => moved.depth < goal.depth,
                };
                is_out && self.begins_line(moved)
            }
        }
    }

    /// The iteration that has come to another line: the one that is followed, or the next where that one is over; on the
    /// way back the one before, where it has not begun.
    fn further(&self, goal: &Goal, moved: &Moved, of: u64) -> Option<u64> {
        if self.is_on_its_way(moved.place, of) {
            let line = self.line_ahead(moved.place, of);
            return (line.is_some() && line != goal.line).then_some(of);
        }
        match moved.place {
            _ if self.is_on_its_way(moved.place, of + 1) => Some(of + 1),
            Place::Context { iteration, .. } if iteration < of => Some(iteration),
            Place::Context {
                slot: 0, iteration, ..
            } => Some(iteration),
            _ => None,
        }
    }

    /// The breakpoints that a core has met.
    fn met(&mut self, core: u32, moved: &Moved, counts: bool) -> Option<Stopped> {
        let mut met = Vec::new();
        let (mut of_iteration, mut line) = (None, None);
        for i in 0..self.breakpoints.len() {
            let Some(iteration) = self.is_met(&self.breakpoints[i].place, core, moved) else {
                continue;
            };
            let condition = self.breakpoints[i].condition.as_ref();
            if condition.is_some_and(|c| !self.holds(c, core, iteration)) {
                continue;
            }
            let breakpoint = &mut self.breakpoints[i];
            if counts {
                breakpoint.met += 1;
            }
            if breakpoint.met >= breakpoint.count {
                met.push(breakpoint.id);
                if let (None, Some(_), Where::Line(of)) = (line, iteration, &breakpoint.place) {
                    (of_iteration, line) = (iteration, Some(*of));
                }
                of_iteration = of_iteration.or(iteration);
            }
        }
        if met.is_empty() {
            return None;
        }
        let stop = self.stopped(Reason::Breakpoint(met), core);
        Some(Stopped {
            iteration: of_iteration.or(stop.iteration),
            line,
            ..stop
        })
    }

    /// The iteration for which a core has come to a place, where it has.
    fn is_met(&self, place: &Where, core: u32, moved: &Moved) -> Option<Option<u64>> {
        match (place, moved.place) {
            (Where::Line(line), Place::Bundle(number)) => {
                let has = |bundle: u32| self.code.bundles[bundle as usize].contains(line);
                let is_new = |last: u32| !has(last) || number <= last;
                (has(number) && moved.last_lines.is_none_or(is_new)).then_some(None)
            }
            (
                Where::Line(line),
                Place::Context {
                    kernel,
                    slot,
                    iteration,
                    stages,
                },
            ) => {
                let &(at, stage) = self.code.kernels[kernel as usize].first.get(line)?;
                let is_there = at == slot && stages >> stage & 1 == 1;
                is_there.then(|| Some(iteration - u64::from(stage)))
            }
            (Where::Function(entry), Place::Bundle(number)) => {
                (*entry == number && moved.done != Some(moved.place)).then_some(None)
            }
            (
                Where::Launch {
                    kernel,
                    number,
                    core: of,
                },
                Place::Context {
                    kernel: on_array,
                    slot: 0,
                    iteration: 0,
                    ..
                },
            ) => {
                let is_it = *kernel == on_array
                    && of.is_none_or(|of| of == core)
                    && number.is_none_or(|n| n == moved.launches + 1);
                is_it.then_some(Some(0))
            }
            _ => None,
        }
    }

    fn cycle_met(&mut self, core: u32) -> Option<Stopped> {
        let passed = self.last_cycle + 1..=self.machine.cycle();
        let met = self.breakpoints.iter().filter_map(|b| match b.place {
            Where::Cycle(cycle) => passed.contains(&cycle).then_some(b.id),
            _ => None,
        });
        let met: Vec<u64> = met.collect();
        (!met.is_empty()).then(|| self.stopped(Reason::Breakpoint(met), core))
    }

    /// The first watch whose bytes have changed, what they were and are, and its core.
    fn changed(&mut self) -> Option<(u64, String, u32)> {
        let mut found = None;
        for i in 0..self.watches.len() {
            let watch = &self.watches[i];
            let now = self.machine.read(watch.core, watch.address, watch.bytes);
            if now == watch.last {
                continue;
            }
            let (was, is) = (
                self.shown_bytes(&watch.last, watch.ty),
                self.shown_bytes(now, watch.ty),
            );
            let text = format!("{} was {was} and is {is}", watch.name);
            found = found.or(Some((watch.id, text, watch.core)));
            self.watches[i].last = now.to_vec();
        }
        found
    }
}

/// What is to be known of a core that has advanced.
struct Moved {
    place: Place,
    done: Option<Place>,
    last_lines: Option<u32>,
    depth: usize,
    /// Of the kernel that comes next.
    launches: u64,
}

impl Moved {
    fn of(marks: &Marks) -> Moved {
        let launches = match marks.place {
            Place::Context { kernel, .. } => marks.launches[kernel as usize],
            _ => 0,
        };
        Moved {
            place: marks.place,
            done: marks.done,
            last_lines: marks.last_lines,
            depth: marks.calls.len(),
            launches,
        }
    }
}
