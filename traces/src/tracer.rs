//! Cores that record in a window, and the observer that listens meanwhile.

use crate::event::{Doing, Outside, Packet};
use crate::format::Format;
use crate::names::Names;
use crate::shared::{Shared, State, Wanted};
use crate::trace::Trace;
use crate::traced::Traced;
use crate::window::{MAX_RECORDS, Window};
use srp_csimgen::{SimSpec, TooManyStages, link};
use srp_ir::check::Checked;
use srp_runtime::core::{Activity, Core, Run};
use srp_runtime::system::{CoreView, MemoryRequest, Observer, SentPacket, Stall, TakenTile};
use srp_runtime::tni::{HitRecord, RayCost, Tni};
use std::ops::Range;
use std::sync::Arc;

/// Why there is no trace.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    /// Simulators have no room for one of the kernels.
    #[error(transparent)]
    TooManyStages(#[from] TooManyStages),
    /// The program has no kernel of this name.
    #[error("the program has no kernel `{name}` on the array; there are: {kernels}")]
    NoKernel {
        /// The name.
        name: String,
        /// Those that there are.
        kernels: String,
    },
    /// The program was over before.
    #[error("{window} were not reached: the program took {cycles} cycles{launches}")]
    NotReached {
        /// The window.
        window: Window,
        /// How many cycles there were.
        cycles: u64,
        /// How many launches, in words, where a launch was wanted.
        launches: String,
    },
}

/// Makes the cores of a program, which record in a window, and observes their system.
pub struct Tracer {
    spec: Arc<SimSpec>,
    names: Arc<Names>,
    clocks: (u32, u32),
    shared: Shared,
}

impl Tracer {
    /// A tracer of a program on the machine that it was checked for.
    ///
    /// # Errors
    ///
    /// Simulators have no room for one of the kernels, or the window's kernel is none of them.
    pub fn new(program: &Checked, window: Window) -> Result<Tracer, TraceError> {
        let spec = link(program)?;
        let wanted = match &window {
            Window::Cycles { cycles, core } => Wanted::Cycles(cycles.clone(), *core),
            Window::Tile(tile) => Wanted::Tile(*tile),
            Window::Launch {
                kernel,
                number,
                core,
            } => Wanted::Launch {
                kernel: kernel_named(&spec, kernel)?,
                number: *number,
                core: *core,
            },
        };
        Ok(Tracer {
            names: Arc::new(Names::of(&spec, program.arch())),
            clocks: (program.arch().system.srp_mhz, program.arch().system.tni_mhz),
            spec: Arc::new(spec),
            shared: Shared::of(window, wanted),
        })
    }

    /// The next core, which runs on this engine but in the window.
    pub fn core(&mut self, fast: Box<dyn Core>) -> Box<dyn Core> {
        let number = self.shared.get().add_core();
        let (spec, shared) = (Arc::clone(&self.spec), self.shared.clone());
        Box::new(Traced::new(number, fast, spec, shared))
    }

    /// The cores, all of which there are by now, go on from these cycles and not from the start. Launches count from
    /// there.
    pub fn begin_at(&mut self, cycles: &[u64]) {
        let mut state = self.shared.get();
        for (core, &cycle) in state.cores.iter_mut().zip(cycles) {
            core.now = cycle;
        }
    }

    /// Most bytes of a file with so many cycles of so many cores.
    pub fn largest(&self, format: Format, cycles: u64, cores: u32) -> u64 {
        let bundles = self
            .spec
            .bundles
            .iter()
            .map(|bundle| bundle.steps.len() + 1);
        let contexts = self.spec.kernels.iter().flat_map(|kernel| &kernel.contexts);
        let steps = bundles.chain(contexts.map(Vec::len)).max().unwrap_or(0) as u64;
        let all = (cycles * u64::from(cores) * (steps + 1)).min(MAX_RECORDS as u64);
        let carriers = self.names.links.len() + self.names.wires.len();
        let parts = self.spec.cells as usize + 8 * self.names.units.len() + carriers;
        all * format.bytes_of_step() + u64::from(cores) * 128 * parts as u64 + BASE
    }

    /// The cycles that were recorded, so far.
    ///
    /// # Errors
    ///
    /// The window was not reached.
    pub fn trace(&self) -> Result<Trace, TraceError> {
        let mut state = self.shared.get();
        let State { wanted, .. } = &*state;
        let launches = match wanted {
            Wanted::Launch { core, .. } => {
                let core = state.cores.get(*core as usize);
                let launches = core.map_or(0, |core| core.launches);
                format!(" and launched it {launches} times on that core")
            }
            _ => String::new(),
        };
        let begun = state.cores.iter().filter_map(|core| core.begun);
        let Some(start) = begun.min() else {
            return Err(TraceError::NotReached {
                window: state.window.clone(),
                cycles: state.cores.iter().map(|core| core.now).max().unwrap_or(0),
                launches,
            });
        };
        let cores = state.cores.iter().filter(|core| core.begun.is_some());
        let ends = cores.map(|core| core.ended.unwrap_or(core.now));
        let end = ends.max().unwrap_or(start).max(start + 1);
        let cycles = match &state.wanted {
            Wanted::Cycles(cycles, _) => cycles.start..cycles.end.min(end),
            _ => start..end,
        };
        let mut outside = std::mem::take(&mut state.outside);
        outside.retain(|event| cycles.contains(&event.0));
        // Cores run ahead of each other.
        outside.sort_by_key(|event| event.0);
        let cores = state.cores.iter_mut().filter(|core| core.begun.is_some());
        let cores = cores.map(|core| {
            let mut trace = std::mem::take(&mut core.trace);
            trace.doings.sort_by_key(|doing| doing.0);
            clip(&mut trace.doings, &cycles);
            trace
        });
        Ok(Trace {
            cores: cores.collect(),
            spec: Arc::clone(&self.spec),
            names: Arc::clone(&self.names),
            outside,
            clocks: self.clocks,
            is_cut: state.room.is_cut,
            cycles,
        })
    }
}

/// Bytes of a file about nothing.
const BASE: u64 = 1 << 12;

/// Leaves of what a core was busy with what it was in these cycles, each only where it is new.
fn clip(doings: &mut Vec<(u64, Doing)>, cycles: &Range<u64>) {
    let before = doings.iter().rev().find(|d| d.0 <= cycles.start).copied();
    doings.retain(|d| d.0 > cycles.start && d.0 < cycles.end);
    doings.splice(0..0, before.map(|(_, doing)| (cycles.start, doing)));
    // Of several in one cycle, the last is what it does.
    doings.dedup_by(|later, earlier| {
        let is_same = later.0 == earlier.0;
        if is_same {
            *earlier = *later;
        }
        is_same
    });
    doings.dedup_by_key(|d| d.1);
}

fn kernel_named(spec: &SimSpec, name: &str) -> Result<u32, TraceError> {
    let found = spec.kernels.iter().position(|kernel| kernel.name == name);
    found.map(|number| number as u32).ok_or_else(|| {
        let kernels: Vec<&str> = spec.kernels.iter().map(|k| k.name.as_str()).collect();
        TraceError::NoKernel {
            name: name.to_owned(),
            kernels: kernels.join(", "),
        }
    })
}

impl Observer for Tracer {
    fn tile_taken(&mut self, core: &CoreView<'_>, taken: Option<TakenTile>) {
        let event = || Outside::Tile(taken.map(|taken| taken.tile));
        self.note(core.core, core.cycle, event);
    }

    fn packet_sent(&mut self, core: &CoreView<'_>, packet: &SentPacket<'_>) {
        let event = || {
            Outside::PacketSent(Box::new(Packet {
                number: packet.number,
                buffers: packet.buffers,
                rays: packet.rays.to_vec(),
            }))
        };
        self.note(core.core, core.cycle, event);
    }

    fn ray_returned(&mut self, core: u32, cycle: u64, cost: &RayCost) {
        self.note(core, cycle, || Outside::Ray(*cost));
    }

    fn tni_ticked(&mut self, core: u32, cycle: u64, unit: &Tni) {
        // What happens in a cycle is seen from the next one on.
        if !self.notes(core, cycle + 1) {
            return;
        }
        let now = unit.occupancy();
        let mut state = self.shared.get();
        let last = &mut state.cores[core as usize].occupancy;
        if *last != now {
            last.clone_from(&now);
            drop(state);
            self.note(core, cycle + 1, || Outside::Occupancy(Box::new(now)));
        }
    }

    fn packet_returned(&mut self, core: &CoreView<'_>, packet: u64, hits: &[HitRecord]) {
        let event = || Outside::PacketReturned(packet, hits.to_vec());
        self.note(core.core, core.cycle, event);
    }

    fn requested(&mut self, core: &CoreView<'_>, request: &MemoryRequest) {
        self.note(core.core, core.cycle, || Outside::Requested(*request));
    }

    fn ran(&mut self, core: &CoreView<'_>, run: &Run) {
        {
            let mut state = self.shared.get();
            let of = &mut state.cores[core.core as usize];
            match run.activity {
                // The system knows of waits more than the core does.
                Activity::Wait(_) => of.ran(core.cycle, *run),
                _ => of.now = core.cycle + run.cycles,
            }
        }
        let counts = || {
            let counts = (*core.data_cache, *core.texture_cache, core.tni());
            Outside::Counts(Box::new(counts))
        };
        self.note(core.core, core.cycle, counts);
    }

    fn stall_began(&mut self, core: &CoreView<'_>, stall: Stall) {
        let mut state = self.shared.get();
        state.cores[core.core as usize].does(core.cycle, Doing::Stands(stall));
    }

    fn stall_ended(&mut self, core: &CoreView<'_>, _: Stall) {
        self.shared.get().cores[core.core as usize].now = core.cycle;
    }
}

impl Tracer {
    /// Notes an event, if it is in the window as far as that is known.
    fn note(&self, core: u32, cycle: u64, event: impl FnOnce() -> Outside) {
        if self.notes(core, cycle) {
            let mut state = self.shared.get();
            let event = event();
            state.room.records += event.records();
            state.outside.push((cycle, core, event));
        }
    }

    /// True if events of a core in this cycle are noted.
    fn notes(&self, core: u32, cycle: u64) -> bool {
        let state = self.shared.get();
        let of = &state.cores[core as usize];
        let is_in = match &state.wanted {
            Wanted::Cycles(cycles, only) => {
                cycles.contains(&cycle) && only.is_none_or(|only| only == core)
            }
            Wanted::Launch { .. } | Wanted::Tile(_) => {
                let has_begun = of.begun.is_some_and(|begun| begun <= cycle);
                has_begun && of.ended.is_none_or(|ended| cycle < ended)
            }
        };
        is_in && state.room.records < MAX_RECORDS
    }
}
