//! One SGRT core: an SRP engine, and the parts round it: SRAM, data cache and texture cache, T&I unit, ports,
//! and the account of its cycles.

use serde::{Deserialize, Serialize};
use srp_archdesc::isa::Class;
use srp_archdesc::system::SystemSpec;
use srp_archdesc::{Arch, ports};

use super::code::{Code, CodeMemory};
use super::core_bus::{CoreBus, Shared};
use super::data_cache::DataCache;
use super::observer::{CoreView, MemoryRequest, Requester, Stall};
use super::report::Account;
use super::sram::Banks;
use super::texture_cache::TextureCache;
use super::{SystemError, Timing};
use crate::core::{Activity, Core, CoreState, Run};
use crate::memory::unloaded;
use crate::tni::{Estimated, HitRecord, Runs, SubmitError, Tni, Tree, Unit, Untimed};

/// Cycles that an engine may run ahead: nothing from outside reaches it but through ports, which
/// it talks to in the first cycle of a run only, and the caches, where a request to the memory ends the run. While a
/// line is on its way, a run ends where it may arrive, and where the value of its load is due. So a frame does not
/// depend on where runs end.
const AHEAD: u64 = 1 << 16;

/// The state of a core.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum State {
    /// It runs, and goes on in cycle [`CoreUnit::ready`].
    Running,
    /// It waits for the port, and asks again in every cycle.
    Waiting(u32),
    /// It stands still since this cycle.
    Stalled(u64, Stall),
    /// It has ended.
    Halted,
}

/// The ports of one core.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Ports {
    pub(super) rays: u32,
    pub(super) hits: u32,
    pub(super) runs: Runs,
    /// Packets that were sent to the T&I unit, and taken from it.
    pub(super) sent: u64,
    pub(super) returned: u64,
    /// The hits that were taken in this run.
    pub(super) taken: Vec<HitRecord>,
    /// Output of the program.
    pub(super) output: Vec<u8>,
    /// Its exit status.
    pub(super) exit: Option<i32>,
    /// A submission that cannot be made.
    pub(super) fault: Option<SubmitError>,
}

/// The parts of a core round its engine.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Periphery {
    pub(super) number: u32,
    pub(super) sram: Vec<u8>,
    pub(super) banks: Banks,
    pub(super) data: DataCache,
    pub(super) texture: TextureCache,
    pub(super) code: Code,
    pub(super) tni: Unit,
    pub(super) ports: Ports,
    pub(super) account: Account,
}

/// All of a core at an instant.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct CoreSnapshot {
    #[serde(with = "words")]
    engine: CoreState,
    periphery: Periphery,
    state: State,
    ready: u64,
    kernel: Option<u32>,
}

/// One SGRT core.
pub(super) struct CoreUnit {
    engine: Box<dyn Core>,
    pub(super) periphery: Periphery,
    pub(super) state: State,
    /// The cycle from which the engine can go on.
    pub(super) ready: u64,
    /// The kernel that is on the array, if one is.
    kernel: Option<u32>,
}

/// A T&I unit that keeps time in this way. If it runs cycle by cycle and is `observed`, it notes what each ray
/// visits and costs.
fn unit(timing: Timing, spec: &SystemSpec, tree: Tree, observed: bool) -> Unit {
    let buffers = spec.buffers.ray_buffers;
    match timing {
        Timing::Full => {
            let mut unit = Tni::new(&spec.tni, tree, buffers);
            if observed {
                unit.note_costs();
                unit.note_visits();
            }
            Unit::Full(Box::new(unit))
        }
        Timing::Estimated => {
            let latency = unloaded::line_cycles(spec);
            Unit::Estimated(Box::new(Estimated::new(&spec.tni, tree, buffers, latency)))
        }
        Timing::RecordedHits | Timing::Untimed => {
            Unit::Untimed(Box::new(Untimed::new(&spec.tni, tree, buffers)))
        }
    }
}

impl Periphery {
    /// The core as an observer sees it.
    pub(super) fn view(&self, cycle: u64) -> CoreView<'_> {
        CoreView {
            core: self.number,
            cycle,
            account: &self.account,
            data_cache: &self.data.cache.counters,
            texture_cache: &self.texture.lines.cache.counters,
            texture_samples: self.texture.samples,
            tni: &self.tni,
        }
    }

    /// The stall for which the core has to stand still.
    pub(super) fn stall(&self) -> Option<Stall> {
        if self.data.waits() {
            Some(Stall::Data)
        } else if self.texture.lines.waits() {
            Some(Stall::Texture)
        } else {
            self.code.waits().map(|memory| match memory {
                CodeMemory::Instructions => Stall::Instructions,
                CodeMemory::Contexts => Stall::Contexts,
            })
        }
    }

    /// The next request of the caches to the memory.
    pub(super) fn next_request(&mut self) -> Option<MemoryRequest> {
        let of = |requester| {
            move |(address, bytes, is_write)| MemoryRequest {
                requester,
                address,
                bytes,
                is_write,
            }
        };
        let data = self.data.take_request().map(of(Requester::DataCache));
        let lines = &mut self.texture.lines;
        let textures = || lines.take_request().map(of(Requester::TextureCache));
        data.or_else(textures).or_else(|| {
            let (memory, address, bytes) = self.code.take_request()?;
            let requester = match memory {
                CodeMemory::Instructions => Requester::InstructionCache,
                CodeMemory::Contexts => Requester::ConfigurationMemory,
            };
            Some(of(requester)((address, bytes, false)))
        })
    }

    /// The next request of the T&I unit to the memory.
    #[inline]
    pub(super) fn next_line(&mut self) -> Option<MemoryRequest> {
        let line = self.tni.take_request()?;
        Some(MemoryRequest {
            requester: Requester::Tni(line.client),
            address: line.address,
            bytes: line.bytes,
            is_write: false,
        })
    }
}

/// The state of an engine as its words: it knows nothing of how it is kept.
mod words {
    use crate::core::CoreState;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(state: &CoreState, to: S) -> Result<S::Ok, S::Error> {
        state.words.serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<CoreState, D::Error> {
        let words = Vec::deserialize(from)?;
        Ok(CoreState { words })
    }
}

impl CoreSnapshot {
    /// The cycle from which its engine goes on.
    pub(super) fn ready(&self) -> u64 {
        self.ready
    }

    /// About how many bytes it takes.
    pub(super) fn bytes(&self) -> usize {
        // Caches and rays beside it are small.
        self.periphery.sram.len() + 4 * self.engine.words.len()
    }
}

impl CoreUnit {
    pub(super) fn new(
        number: u32,
        engine: Box<dyn Core>,
        arch: &Arch,
        sram: Vec<u8>,
        tree: Tree,
        timing: Timing,
        observed: bool,
    ) -> CoreUnit {
        let (spec, latency) = (&arch.system, |class| {
            arch.srp.least_latency(class).unwrap_or(1)
        });
        let immediate = timing == Timing::Untimed;
        CoreUnit {
            engine,
            periphery: Periphery {
                number,
                sram,
                banks: Banks::of(spec),
                data: DataCache::new(&spec.data_cache, latency(Class::Cload), immediate),
                texture: TextureCache::new(&spec.texture_cache, latency(Class::Tex), immediate),
                code: Code::new(arch, immediate),
                tni: unit(timing, spec, tree, observed),
                ports: Ports::default(),
                account: Account::default(),
            },
            state: State::Running,
            ready: 0,
            kernel: None,
        }
    }

    /// All of it; `None` where its engine keeps its state to itself.
    pub(super) fn snapshot(&self) -> Option<CoreSnapshot> {
        Some(CoreSnapshot {
            engine: self.engine.save()?,
            periphery: self.periphery.clone(),
            state: self.state,
            ready: self.ready,
            kernel: self.kernel,
        })
    }

    /// Goes on from a snapshot of the same core; `false` where the engine does not.
    pub(super) fn restore(&mut self, from: &CoreSnapshot) -> bool {
        let mut unit = self.periphery.tni.clone();
        unit.go_on_as(&from.periphery.tni);
        self.periphery.clone_from(&from.periphery);
        self.periphery.tni = unit;
        (self.state, self.ready, self.kernel) = (from.state, from.ready, from.kernel);
        self.engine.restore(&from.engine)
    }

    /// One cycle of the T&I unit, in SRP cycle `now`.
    pub(super) fn tick_tni(&mut self, cycle: u64, now: u64, shared: &mut Shared<'_>) {
        let Periphery {
            tni, sram, number, ..
        } = &mut self.periphery;
        if tni.is_idle() {
            return;
        }
        tni.tick(cycle, &shared.memory, sram);
        if let (Some(observer), Unit::Full(tni)) = (&mut shared.observer, tni) {
            tni.take_costs()
                .for_each(|cost| observer.ray_returned(*number, now, &cost));
            tni.give_visits(|visited| observer.tni_visited(*number, visited));
            observer.tni_ticked(*number, now, tni);
        }
    }

    /// True if the core may go on in cycle `now` while lines are on their way to it.
    #[inline]
    pub(super) fn is_open_to_lines(&self, now: u64) -> bool {
        let Periphery { data, texture, .. } = &self.periphery;
        now >= self.ready && data.under_way() + texture.lines.under_way() > 0
    }

    /// SRP cycle `now`: goes on, if it is time, and at most to the `arrival` of a line. Says whether the core is at
    /// work.
    pub(super) fn step(
        &mut self,
        now: u64,
        arrival: u64,
        shared: &mut Shared<'_>,
    ) -> Result<bool, SystemError> {
        if self.state == State::Halted {
            return Ok(false);
        }
        if now < self.ready {
            return Ok(true);
        }
        if self.is_stalled(now, shared) {
            return Ok(false);
        }
        self.periphery.ports.taken.clear();
        let slacks = [&self.periphery.data, &self.periphery.texture.lines].map(DataCache::slack);
        let ahead = arrival.saturating_sub(now).clamp(1, AHEAD);
        let ahead = slacks.into_iter().flatten().fold(ahead, u64::min);
        let mut bus = CoreBus {
            now,
            core: &mut self.periphery,
            shared,
        };
        let run = self
            .engine
            .run(&mut bus, ahead)
            .map_err(|trap| SystemError::Trap {
                core: self.periphery.number,
                trap,
                cycle: now,
                waits: String::new(),
            })?;
        if let Some(fault) = self.periphery.ports.fault {
            return Err(SystemError::submission(self.periphery.number, fault));
        }
        if !matches!(run.activity, Activity::Wait(_)) {
            self.periphery.data.ran(run.cycles);
            self.periphery.texture.lines.ran(run.cycles);
        }
        self.ready = now;
        self.count(run, shared);
        self.wait_for_banks(shared);
        if let Activity::Wait(ports::TNI_DONE) = run.activity
            && let Some(back) = shared.back(&self.periphery.tni)
            && back > self.ready
        {
            // When the packet is back is known.
            let wait = Run {
                cycles: back - self.ready,
                activity: run.activity,
                operations: 0,
            };
            self.count(wait, shared);
            self.state = State::Running;
            return Ok(true);
        }
        self.state = match run.activity {
            Activity::Wait(port) => State::Waiting(port),
            Activity::Halted(status) => {
                self.periphery.ports.exit.get_or_insert(status);
                State::Halted
            }
            _ => State::Running,
        };
        if self.periphery.ports.exit.is_some() {
            self.state = State::Halted;
            shared.tell(&self.periphery, self.ready, |o, core| o.halted(core));
            self.periphery.data.flush();
        }
        Ok(!matches!(self.state, State::Waiting(_)))
    }

    /// Accounts for a run from the cycle on in which the engine could go on.
    fn count(&mut self, run: Run, shared: &mut Shared<'_>) {
        self.kernel = match run.activity {
            Activity::Array(kernel) => Some(kernel),
            _ => None,
        };
        self.periphery.account.add(run);
        shared.tell(&self.periphery, self.ready, |o, core| o.ran(core, &run));
        self.ready += run.cycles;
    }

    /// Stands still, from the cycle on in which the engine could go on, until the banks of the SRAM have done what the
    /// last cycle asks of them.
    fn wait_for_banks(&mut self, shared: &mut Shared<'_>) {
        let cycles = std::mem::take(&mut self.periphery.banks.owed);
        if cycles == 0 {
            return;
        }
        shared.tell(&self.periphery, self.ready, |o, core| {
            o.stall_began(core, Stall::Banks)
        });
        self.ready += cycles;
        self.add_stall(Stall::Banks, cycles);
        shared.tell(&self.periphery, self.ready, |o, core| {
            o.stall_ended(core, Stall::Banks)
        });
    }

    /// True if the core has to stand still in cycle `now`.
    fn is_stalled(&mut self, now: u64, shared: &mut Shared<'_>) -> bool {
        self.count_stall(now);
        let before = match self.state {
            State::Stalled(_, stall) => Some(stall),
            _ => None,
        };
        let stall = self.periphery.stall();
        if stall != before {
            shared.tell(&self.periphery, now, |observer, core| {
                if let Some(before) = before {
                    observer.stall_ended(core, before);
                }
                if let Some(stall) = stall {
                    observer.stall_began(core, stall);
                }
            });
        }
        if let Some(stall) = stall {
            self.state = State::Stalled(now, stall);
        }
        stall.is_some()
    }

    /// Puts the cycles into the account since which the core, if it does, stands still.
    pub(super) fn count_stall(&mut self, now: u64) {
        if let State::Stalled(since, stall) = self.state {
            self.state = State::Stalled(now, stall);
            self.add_stall(stall, now - since);
        }
    }

    /// Puts cycles of standing still into the account.
    fn add_stall(&mut self, stall: Stall, cycles: u64) {
        let account = &mut self.periphery.account;
        match stall {
            Stall::Data => account.memory_stall += cycles,
            Stall::Texture => account.texture_stall += cycles,
            Stall::Instructions => account.instruction_stall += cycles,
            Stall::Contexts => account.context_stall += cycles,
            Stall::Banks => account.sram_stall += cycles,
        }
        if let Some(kernel) = self.kernel {
            let of_kernels = match stall {
                Stall::Banks => &mut account.kernel_sram_stalls,
                _ => &mut account.kernel_stalls,
            };
            *of_kernels.entry(kernel).or_default() += cycles;
        }
    }
}
