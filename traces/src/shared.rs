//! What the cores of a tracer and its observer share.

use crate::event::{Doing, Outside};
use crate::trace::CoreTrace;
use crate::window::Window;
use srp_runtime::core::{Activity, Run};
use srp_runtime::tni::Occupancy;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A window, its kernel looked up.
#[derive(Clone, Debug)]
pub(crate) enum Wanted {
    Cycles(Range<u64>, Option<u32>),
    Launch { kernel: u32, number: u64, core: u32 },
    Tile(u32),
}

/// What all cores and the observer know.
#[derive(Debug)]
pub(crate) struct State {
    pub(crate) window: Window,
    pub(crate) wanted: Wanted,
    pub(crate) cores: Vec<Progress>,
    pub(crate) outside: Vec<(u64, u32, Outside)>,
    pub(crate) room: Room,
}

/// How much was recorded.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Room {
    /// Records of all cores.
    pub(crate) records: usize,
    /// There was no room for more.
    pub(crate) is_cut: bool,
}

impl State {
    /// Knows of another core. Its number.
    pub(crate) fn add_core(&mut self) -> u32 {
        let number = self.cores.len() as u32;
        let trace = CoreTrace {
            core: number,
            ..CoreTrace::default()
        };
        self.cores.push(Progress {
            trace,
            ..Progress::default()
        });
        number
    }

    /// Lends what is known of a core to it. While it runs, its bus may tell the observer of events.
    pub(crate) fn lend(&mut self, number: u32) -> (Wanted, Room, Progress) {
        let core = &mut self.cores[number as usize];
        let lent = Progress {
            trace: std::mem::take(&mut core.trace),
            occupancy: std::mem::take(&mut core.occupancy),
            ..*core
        };
        core.trace.core = number;
        (self.wanted.clone(), self.room, lent)
    }

    /// Takes it back.
    pub(crate) fn give_back(&mut self, room: Room, core: Progress) {
        self.room.records = self.room.records.max(room.records);
        self.room.is_cut |= room.is_cut;
        let number = core.trace.core as usize;
        self.cores[number] = core;
    }
}

/// What is known of a core.
#[derive(Debug, Default)]
pub(crate) struct Progress {
    /// The cycle in which it goes on.
    pub(crate) now: u64,
    /// What it did last, but for standing still.
    pub(crate) last: Option<Activity>,
    /// Launches of the window's kernel.
    pub(crate) launches: u64,
    pub(crate) begun: Option<u64>,
    pub(crate) ended: Option<u64>,
    pub(crate) occupancy: Occupancy,
    pub(crate) trace: CoreTrace,
}

#[derive(Clone)]
pub(crate) struct Shared(Arc<Mutex<State>>);

impl Shared {
    /// Of a tracer without cores.
    pub(crate) fn of(window: Window, wanted: Wanted) -> Shared {
        Shared(Arc::new(Mutex::new(State {
            window,
            wanted,
            cores: Vec::new(),
            outside: Vec::new(),
            room: Room::default(),
        })))
    }

    pub(crate) fn get(&self) -> MutexGuard<'_, State> {
        // A record is whole at any time.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Progress {
    /// It has done one thing for a run of cycles.
    pub(crate) fn ran(&mut self, cycle: u64, run: Run) {
        self.does(cycle, Doing::Runs(run.activity));
        self.last = Some(run.activity);
        self.now = cycle + run.cycles;
    }

    pub(crate) fn does(&mut self, cycle: u64, doing: Doing) {
        // Before the window, only the last is of use.
        if self.begun.is_none() {
            self.trace.doings.clear();
        }
        let is_told = self.trace.doings.last() == Some(&(cycle, doing));
        if !is_told && self.ended.is_none_or(|end| cycle < end) {
            self.trace.doings.push((cycle, doing));
        }
    }
}
