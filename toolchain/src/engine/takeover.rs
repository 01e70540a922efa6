//! Cores that begin at once, interpreted, and go on in a generated simulator when there is one.
//!
//! The simulator is compiled by another process, which starts when the work has gone on for a while:
//! short work is over before a compiler has begun. It keeps the simulator in the cache even where the
//! work ends first, so that the next run has it. A core changes its engine between two runs, by the
//! words of its state; since both engines do the same in every cycle, nothing shows but the time.

use super::generated::{Source, ask};
use crate::cache::Cache;
use srp_csimgen::load::GeneratedCore;
use srp_csimgen::{Interpreter, SimSpec, Simulator};
use srp_runtime::core::{Bus, Core, CoreState, Run, Trap};
use std::io::Write;
use std::path::PathBuf;
use std::process::{Child, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Work of less time than this is done before a compiler would be of use.
const PATIENCE: Duration = Duration::from_millis(250);

/// Runs of a core between two looks at whether there is a simulator.
const RUNS: u32 = 64;

/// The state that all cores of a program share.
pub struct Takeover {
    spec: SimSpec,
    interpreter: Interpreter,
    source: Source,
    builder: PathBuf,
    cache: Arc<Cache>,
    progress: Mutex<Progress>,
    interpreted: AtomicU64,
    generated: AtomicU64,
}

/// How far the simulator is.
enum Progress {
    /// Nobody has asked for a core to run yet.
    Idle,
    /// Cores have run since then.
    Waits(Instant),
    /// It is being compiled.
    Compiling(Child),
    /// It is there.
    Ready(Simulator),
    /// There will be none.
    Never,
}

/// Cycles of all cores, by the engine that simulated them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shares {
    /// Cycles of the interpreter.
    pub interpreted: u64,
    /// Cycles of the generated simulator.
    pub generated: u64,
}

impl Takeover {
    pub(super) fn new(
        spec: SimSpec,
        source: Source,
        builder: PathBuf,
        cache: Arc<Cache>,
    ) -> Takeover {
        Takeover {
            interpreter: Interpreter::new(&spec),
            spec,
            source,
            builder,
            cache,
            progress: Mutex::new(Progress::Idle),
            interpreted: AtomicU64::new(0),
            generated: AtomicU64::new(0),
        }
    }

    pub(super) fn core(shared: &Arc<Takeover>) -> TakeoverCore {
        let progress = shared.progress.lock();
        let engine = match &*progress.unwrap_or_else(PoisonError::into_inner) {
            Progress::Ready(simulator) => Active::Generated(simulator.core()),
            _ => Active::Interpreted(Box::new(shared.interpreter.clone())),
        };
        TakeoverCore {
            shared: Arc::clone(shared),
            engine,
            runs: 0,
        }
    }

    pub(super) fn shares(&self) -> Shares {
        Shares {
            interpreted: self.interpreted.load(Ordering::Relaxed),
            generated: self.generated.load(Ordering::Relaxed),
        }
    }

    /// The simulator, if it is there; brings it on its way.
    fn simulator(&self) -> Option<Simulator> {
        let mut progress = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        match &mut *progress {
            Progress::Idle => *progress = Progress::Waits(Instant::now()),
            Progress::Waits(since) if since.elapsed() >= PATIENCE => {
                *progress = self.compile().map_or(Progress::Never, Progress::Compiling);
            }
            Progress::Compiling(child) => match child.try_wait() {
                Ok(None) => {}
                Ok(Some(_)) => {
                    let made = self.source.kept_by_another(&self.spec, &self.cache);
                    *progress = made.map_or(Progress::Never, Progress::Ready);
                }
                Err(_) => *progress = Progress::Never,
            },
            Progress::Waits(_) | Progress::Ready(_) | Progress::Never => {}
        }
        match &*progress {
            Progress::Ready(simulator) => Some(simulator.clone()),
            _ => None,
        }
    }

    /// Starts the process that compiles. It is not waited for at the end, and a Ctrl-C that ends the
    /// work does not end it.
    fn compile(&self) -> Option<Child> {
        let mut command = ask(&self.builder);
        command.stdin(Stdio::piped()).stdout(Stdio::null());
        command.stderr(Stdio::null());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().ok()?;
        let mut to = child.stdin.take()?;
        let request = self.source.request();
        // A request that the process does not take comes to nothing there.
        std::thread::spawn(move || to.write_all(&request));
        Some(child)
    }
}

/// A core that changes its engine once.
pub(super) struct TakeoverCore {
    shared: Arc<Takeover>,
    engine: Active,
    /// Runs since the last look.
    runs: u32,
}

enum Active {
    Interpreted(Box<Interpreter>),
    Generated(GeneratedCore),
}

impl TakeoverCore {
    /// Changes the engine, if it is time.
    fn look(&mut self) {
        let Active::Interpreted(interpreter) = &self.engine else {
            return;
        };
        let Some(simulator) = self.shared.simulator() else {
            return;
        };
        let mut core = simulator.core();
        let state = interpreter.save();
        if state.is_some_and(|state| core.restore(&state)) {
            self.engine = Active::Generated(core);
        }
    }
}

impl Core for TakeoverCore {
    fn run(&mut self, bus: &mut dyn Bus, budget: u64) -> Result<Run, Trap> {
        if self.runs == 0 {
            self.look();
        }
        self.runs = (self.runs + 1) % RUNS;
        let (run, cycles) = match &mut self.engine {
            Active::Interpreted(core) => (core.run(bus, budget), &self.shared.interpreted),
            Active::Generated(core) => (core.run(bus, budget), &self.shared.generated),
        };
        if let Ok(run) = &run {
            cycles.fetch_add(run.cycles, Ordering::Relaxed);
        }
        run
    }

    fn save(&self) -> Option<CoreState> {
        match &self.engine {
            Active::Interpreted(core) => core.save(),
            Active::Generated(core) => core.save(),
        }
    }

    fn restore(&mut self, state: &CoreState) -> bool {
        match &mut self.engine {
            Active::Interpreted(core) => core.restore(state),
            Active::Generated(core) => core.restore(state),
        }
    }
}
