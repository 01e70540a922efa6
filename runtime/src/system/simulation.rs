//! The cores of a system, their units and their memory under one clock.

use std::sync::Arc;

use srp_archdesc::watch::{Stage, Watch};
use srp_archdesc::{Arch, ports};

use super::code::{CodeLayout, CodeMemory};
use super::core_bus::Shared;
use super::core_unit::{CoreUnit, Periphery, State};
use super::observer::{MemoryRequest, Requester, Stall};
use super::sharing::Sharing;
use super::snapshot::{Instant, SystemSnapshot};
use super::tiles::{TileQueue, frame_blocks};
use super::{Checkpoint, Options, SystemError, Timing};
use crate::core::Core;
use crate::effect::Guard;
use crate::memory::dram::Request;
use crate::memory::path::{Clock, MemoryPath};
use crate::memory::{self, SystemMemory};
use crate::scene_image::{FrameBuffer, SceneImage};
use crate::tni::Client;

/// Cycles without progress after which a frame is given up.
pub const MAX_SILENCE: u64 = 4_000_000;

/// Cycles after which cores that all wait are given up, where nothing is on the way to them.
const MAX_STILLNESS: u64 = 64;

/// SRP cycles between two looks at the outside.
const REPORT_INTERVAL: u64 = 1 << 16;

/// Numbers of the requesters of a core: the data cache is 0, the level-2 cache 1, the texture cache 2, the
/// instruction cache 3, the configuration memory 4, and the intersection units follow. The next core begins after this many.
const CLIENTS: u32 = 1 << 16;
const DATA: u32 = 0;
const TRV_L2: u32 = 1;
const TEXTURE: u32 = 2;
const INSTRUCTIONS: u32 = 3;
const CONTEXTS: u32 = 4;
const IST: u32 = 5;

/// A request as the memory has it, from this core.
fn request_of(core: u32, request: &MemoryRequest) -> Request {
    let client = match request.requester {
        Requester::DataCache => DATA,
        Requester::TextureCache => TEXTURE,
        Requester::InstructionCache => INSTRUCTIONS,
        Requester::ConfigurationMemory => CONTEXTS,
        Requester::Tni(Client::TrvL2) => TRV_L2,
        Requester::Tni(Client::IstL1(i)) => i + IST,
    };
    Request {
        address: request.address,
        bytes: request.bytes,
        is_write: request.is_write,
        source: core * CLIENTS + client,
    }
}

/// A time before which no line arrives for the data or texture cache of this core.
fn earliest_line(core: &CoreUnit, path: &MemoryPath) -> Option<u64> {
    let first = core.periphery.number * CLIENTS;
    path.earliest_answer(|source| source == first + DATA || source == first + TEXTURE)
}

/// A frame that is simulated.
pub(super) struct Simulation<'a> {
    pub(super) cores: Vec<CoreUnit>,
    pub(super) shared: Shared<'a>,
    pub(super) frame: FrameBuffer,
    /// The bus and memory of all cores, or those of each core.
    pub(super) paths: Vec<MemoryPath>,
    /// True if requests need not go to the memory, because it takes no time.
    immediate: bool,
    max_cycles: u64,
    guard: Guard,
    start: Option<&'a SystemSnapshot>,
    checkpoint: Option<&'a mut Checkpoint>,
    watch: &'a dyn Watch,
}

impl<'a> Simulation<'a> {
    pub(super) fn new(
        image: SceneImage,
        engines: Vec<Box<dyn Core>>,
        arch: &Arch,
        options: Options<'a>,
    ) -> Result<Simulation<'a>, SystemError> {
        let spec = &arch.system;
        let scene_end = u64::from(memory::BASE) + image.memory.bytes().len() as u64;
        let code = CodeLayout::behind(scene_end, &options.code, arch)?;
        let mut sram = options.sram_image.to_vec();
        sram.resize(spec.sram_bytes as usize, 0);
        let (timing, observed) = (options.timing, options.observer.is_some());
        let core = |(i, engine)| {
            let sram = sram.clone();
            CoreUnit::new(i, engine, arch, sram, image.tree, timing, observed)
        };
        let paths = if spec.dram.shared { 1 } else { engines.len() };
        let tiles =
            (options.tiles).unwrap_or_else(|| TileQueue::of_blocks(frame_blocks(&image, spec)));
        let core_count = engines.len();
        Ok(Simulation {
            cores: (0..).zip(engines).map(core).collect(),
            paths: (0..paths).map(|_| MemoryPath::new(spec)).collect(),
            shared: Shared {
                sharing: Sharing::of(&image.memory, core_count),
                memory: image.memory,
                tiles,
                code,
                srp: Clock::new(spec.srp_mhz),
                tni: Clock::new(spec.tni_mhz),
                observer: options.observer,
            },
            frame: image.frame,
            immediate: timing == Timing::Untimed,
            max_cycles: options.max_cycles,
            guard: options.guard,
            start: options.start,
            checkpoint: options.checkpoint,
            watch: options.watch,
        })
    }

    /// The memory as the cores have left it.
    pub(super) fn into_memory(self) -> SystemMemory {
        self.shared.memory
    }

    /// Runs until all cores have halted and everything is written, or the user has had enough.
    /// Returns the SRP cycles.
    pub(super) fn run(&mut self) -> Result<u64, SystemError> {
        let stage = Stage::of(
            self.watch,
            "rendering",
            u64::from(self.shared.tiles.count()),
        );
        let mut told = 0;
        let mut at = match self.start.take() {
            None => Instant::default(),
            Some(from) => self.restore(from).ok_or(SystemError::NoState)?,
        };
        while !self.is_over() {
            self.take_checkpoint(at)?;
            self.advance(&mut at)?;
            if at.srp >= at.look_up {
                at.look_up = at.srp + REPORT_INTERVAL;
                let taken = self.shared.tiles.taken();
                stage.done(u64::from(taken - told));
                told = taken;
                if self.watch.cancelled() {
                    break;
                }
                self.check_length(at.srp)?;
            }
        }
        let srp = at.srp;
        for core in &mut self.cores {
            core.count_stall(srp);
            self.shared
                .tell(&core.periphery, srp, |o, core| o.finished(core));
        }
        let ends = self.cores.iter().map(|c| c.ready);
        Ok(ends.fold(srp, u64::max))
    }

    /// Takes the snapshot that is wanted, where its time has come.
    fn take_checkpoint(&mut self, at: Instant) -> Result<(), SystemError> {
        let Some(wanted) = self.checkpoint.take_if(|wanted| wanted.cycle <= at.srp) else {
            return Ok(());
        };
        wanted.taken = self.snapshot(at, None);
        match wanted.taken {
            Some(_) => Ok(()),
            None => Err(SystemError::NoState),
        }
    }

    /// Advances everything to the next instant at which something can happen.
    pub(super) fn advance(&mut self, at: &mut Instant) -> Result<(), SystemError> {
        let (mut srp, mut tni) = (at.srp, at.tni);
        let (srp_time, tni_time) = (self.shared.srp.start(srp), self.shared.tni.start(tni));
        let time = srp_time.min(tni_time);
        if self.take_answers(time, tni) {
            // What is written back in the place of new lines goes before what the cores do in this cycle.
            self.send_requests(time, time);
        }
        if tni_time == time {
            for core in &mut self.cores {
                core.tick_tni(tni, srp, &mut self.shared);
            }
            tni += 1;
        }
        if srp_time == time {
            let moved = self.step(srp)?;
            let results = self.cores.iter().map(|c| c.periphery.tni.results()).sum();
            if moved || results != at.results || self.in_flight() > 0 {
                (at.progress, at.results) = (srp, results);
            }
            self.check_silence(srp, srp - at.progress)?;
            srp += 1;
        }
        self.send_requests(time, time + self.shared.srp.start(1));
        (at.srp, at.tni) = self.skip(srp, tni);
        Ok(())
    }

    /// Refuses a frame that has gone on for longer than it may.
    pub(super) fn check_length(&self, srp: u64) -> Result<(), SystemError> {
        match srp > self.max_cycles {
            true => Err(SystemError::TooLong {
                cycles: self.max_cycles,
                waits: self.waits(),
            }),
            false => Ok(()),
        }
    }

    /// SRP cycle `now` of all cores. Says whether any is at work.
    fn step(&mut self, now: u64) -> Result<bool, SystemError> {
        let mut moved = false;
        let count = self.paths.len();
        for i in 0..self.cores.len() {
            let core = &mut self.cores[i];
            let arrival = match core.is_open_to_lines(now) {
                true => earliest_line(core, &self.paths[i % count]),
                false => None,
            };
            let arrival = arrival.map_or(u64::MAX, |at| self.shared.srp.cycle_from(at));
            match core.step(now, arrival, &mut self.shared) {
                Ok(at_work) => moved |= at_work,
                Err(mut error) => {
                    if let SystemError::Trap { waits, .. } = &mut error {
                        *waits = self.waits();
                    }
                    return Err(error);
                }
            }
            let hits = &core.periphery.ports.taken;
            if !hits.is_empty()
                && let Some(missing) = self.guard.check(hits)
            {
                return Err(SystemError::Effect {
                    core: core.periphery.number,
                    missing: missing.clone(),
                });
            }
        }
        Ok(moved)
    }

    pub(super) fn is_over(&self) -> bool {
        self.cores
            .iter()
            .all(|c| c.state == State::Halted && c.periphery.tni.is_idle())
            && self.in_flight() == 0
    }

    /// How many requests are on the way to the memory and back.
    fn in_flight(&self) -> u32 {
        self.paths.iter().map(MemoryPath::in_flight).sum()
    }

    /// Gives the cores the lines that have arrived. Says whether there were any.
    fn take_answers(&mut self, time: u64, tni_cycle: u64) -> bool {
        let mut arrived = false;
        for path in &mut self.paths {
            while let Some(answer) = path.answer(time) {
                if answer.is_write {
                    continue;
                }
                arrived = true;
                let core = &mut self.cores[(answer.source / CLIENTS) as usize];
                let core = &mut core.periphery;
                let address = answer.address;
                match answer.source % CLIENTS {
                    DATA => core.data.fill(address),
                    TRV_L2 => core.tni.fill(tni_cycle, Client::TrvL2, address),
                    TEXTURE => core.texture.lines.fill(address),
                    INSTRUCTIONS => core.code.fill(CodeMemory::Instructions, address),
                    CONTEXTS => core.code.fill(CodeMemory::Contexts, address),
                    i => core.tni.fill(tni_cycle, Client::IstL1(i - IST), address),
                }
            }
        }
        arrived
    }

    /// Sends what the cores that may go on by `end` have asked for. The request of one that has run ahead is of its last
    /// cycle.
    fn send_requests(&mut self, time: u64, end: u64) {
        let Simulation {
            cores,
            shared,
            paths,
            immediate,
            ..
        } = self;
        let count = paths.len();
        for (i, core) in cores.iter_mut().enumerate() {
            let due = *immediate || shared.srp.start(core.ready) <= end;
            let core = &mut core.periphery;
            let path = &mut paths[i % count];
            let mut send = |core: &Periphery, request: MemoryRequest| {
                let cycle = shared.srp.cycle_from(time);
                shared.tell(core, cycle, |o, core| o.requested(core, &request));
                if !*immediate {
                    path.request(time, request_of(core.number, &request));
                }
            };
            while due && let Some(request) = core.next_request() {
                send(core, request);
            }
            while let Some(request) = core.next_line() {
                send(core, request);
            }
        }
    }

    /// Leaves out cycles in which nothing can happen: no T&I unit has rays, and every core is
    /// ahead, halted, or waits for the memory.
    fn skip(&self, srp: u64, tni: u64) -> (u64, u64) {
        let clocks = &self.shared;
        let mut until = u64::MAX;
        for core in &self.cores {
            match core.state {
                _ if !core.periphery.tni.is_idle() => return (srp, tni),
                State::Waiting(_) => return (srp, tni),
                State::Halted => {}
                State::Running if core.ready > srp => {
                    until = until.min(clocks.srp.start(core.ready - 1));
                }
                State::Stalled(_, stall) if core.periphery.stall() == Some(stall) => {}
                State::Running | State::Stalled(..) => return (srp, tni),
            }
        }
        let events = self.paths.iter().filter_map(MemoryPath::next_event);
        until = events.fold(until, u64::min);
        if until == u64::MAX {
            return (srp, tni);
        }
        let srp = srp.max(clocks.srp.cycle_from(until));
        (srp, tni.max(clocks.tni.cycle_from(until)))
    }

    fn check_silence(&self, cycle: u64, silence: u64) -> Result<(), SystemError> {
        let idle = || self.cores.iter().all(|c| c.periphery.tni.is_idle());
        if silence > MAX_SILENCE || (silence > MAX_STILLNESS && idle()) {
            return Err(SystemError::Deadlock {
                cycle,
                waits: self.waits(),
            });
        }
        Ok(())
    }

    /// Who waits for what, one line each.
    pub(super) fn waits(&self) -> String {
        let mut text = String::new();
        for (i, core) in self.cores.iter().enumerate() {
            let what = match core.state {
                State::Running => "runs".to_owned(),
                State::Halted => "has ended".to_owned(),
                State::Stalled(since, stall) => {
                    let what = match stall {
                        Stall::Data => "its data cache",
                        Stall::Texture => "its texture cache",
                        Stall::Instructions => "its instruction cache",
                        Stall::Contexts => "the contexts of a kernel",
                        Stall::Banks => "the banks of its SRAM",
                    };
                    format!("waits for {what} since cycle {since}")
                }
                State::Waiting(port) => format!("waits for port {port} ({})", port_name(port)),
            };
            text.push_str(&format!(
                "  core {i} {what}; its T&I unit: {}\n",
                core.periphery.tni.describe_state()
            ));
        }
        let in_flight = self.in_flight();
        text.push_str(&format!("  {in_flight} memory requests are on the way"));
        text
    }
}

impl Simulation<'_> {
    /// All of it. Where the memory is as in `last`, the two share it. `None` where an engine keeps its state to
    /// itself.
    pub(super) fn snapshot(
        &self,
        at: Instant,
        last: Option<&SystemSnapshot>,
    ) -> Option<SystemSnapshot> {
        let shared = &self.shared;
        let cores = self.cores.iter().map(|core| core.snapshot());
        let shared_memory = last
            .map(|last| &last.memory)
            .filter(|memory| memory.bytes() == shared.memory.bytes());
        Some(SystemSnapshot {
            cores: cores.collect::<Option<_>>()?,
            memory: match shared_memory {
                Some(memory) => Arc::clone(memory),
                None => Arc::new(shared.memory.clone()),
            },
            sharing: shared.sharing.clone(),
            tiles: shared.tiles.clone(),
            paths: self.paths.clone(),
            at,
        })
    }

    /// Goes back, or on, to a snapshot of the same frame: its instant. `None` where an engine does not, after which
    /// the frame is of no use.
    pub(super) fn restore(&mut self, from: &SystemSnapshot) -> Option<Instant> {
        if self.cores.len() != from.cores.len() || self.paths.len() != from.paths.len() {
            return None;
        }
        self.shared.memory.clone_from(&from.memory);
        self.shared.sharing.clone_from(&from.sharing);
        self.shared.tiles.clone_from(&from.tiles);
        self.paths.clone_from(&from.paths);
        let mut both = self.cores.iter_mut().zip(&from.cores);
        both.all(|(core, from)| core.restore(from))
            .then_some(from.at)
    }
}

/// The purpose of a port, in words.
pub(super) fn port_name(port: u32) -> &'static str {
    match port {
        ports::TILE => "next tile",
        ports::TNI_RAYS => "ray buffer",
        ports::TNI_HITS => "hit buffer",
        ports::TNI_START => "room for a submission",
        ports::TNI_DONE => "a finished submission",
        ports::TNI_SHADOW_MISSES => "shadow misses",
        ports::TNI_OTHER_HITS => "other hits",
        ports::TNI_OTHER_MISSES => "other misses",
        ports::CORE => "core number",
        ports::PUTCHAR => "output",
        ports::EXIT => "exit",
        _ => "which does not exist",
    }
}
