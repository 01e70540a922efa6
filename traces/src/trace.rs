//! What is recorded of a window.

use crate::event::{Doing, Outside};
use crate::names::Names;
use srp_csimgen::{Record, SimSpec, Snapshot};
use std::ops::Range;
use std::sync::Arc;

/// A window of a simulation.
#[derive(Clone, Debug)]
pub struct Trace {
    /// The program and the machine.
    pub spec: Arc<SimSpec>,
    /// What their parts are called.
    pub names: Arc<Names>,
    /// The cycles that were recorded.
    pub cycles: Range<u64>,
    /// SRP cycles and T&I cycles of the same time, where there is a T&I unit.
    pub clocks: (u32, u32),
    /// The cores that were.
    pub cores: Vec<CoreTrace>,
    /// What the system's observer saw meanwhile: cycle, core, event, by cycles.
    pub outside: Vec<(u64, u32, Outside)>,
    /// True if the window was longer, and there was no room for the rest.
    pub is_cut: bool,
}

/// The part of a core in a trace.
#[derive(Clone, Debug, Default)]
pub struct CoreTrace {
    /// Its number.
    pub core: u32,
    /// The registers at the beginning.
    pub start: Snapshot,
    /// What it did.
    pub records: Vec<Record>,
    /// Where in them each cycle begins in which it advanced.
    pub turns: Vec<(u64, usize)>,
    /// Since when it was busy with what.
    pub doings: Vec<(u64, Doing)>,
}
