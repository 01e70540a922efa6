//! One SGRT core: an SRP engine, its SRAM, data cache and texture cache, its T&I unit, and the account of its
//! cycles.

use std::collections::VecDeque;

use srp_archdesc::ports;
use srp_archdesc::system::SystemSpec;

use super::data_cache::DataCache;
use super::ledger::{Ledger, Sources};
use super::report::Account;
use super::tags::Tags;
use super::texture_cache::TextureCache;
use super::tiles::TileQueue;
use super::{SystemError, TEXTURE, Timing};
use crate::core::{Activity, Bus, Core, Lanes, Run};
use crate::effect::{Guard, Missing};
use crate::fidelity;
use crate::memory::SystemMemory;
use crate::memory::dram::Request;
use crate::memory::path::Clock;
use crate::tni::{Runs, SubmitError, Tni, TniCounters, Tree};

/// Cycles that an engine may run ahead: nothing from outside reaches it but through ports, which
/// it talks to in the first cycle of a run only, and the caches, where a miss ends the run.
const AHEAD: u64 = 1 << 16;

/// What a core waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Miss {
    /// Its data cache, and perhaps its texture cache too.
    Data,
    /// Its texture cache.
    Texture,
}

/// What a core does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// It runs, and goes on in cycle [`CoreUnit::ready`].
    Running,
    /// It waits for the port, and asks again in every cycle.
    Waiting(u32),
    /// It waits for a cache since this cycle.
    Stalled(u64, Miss),
    /// It has ended.
    Halted,
}

/// The ports of one core.
#[derive(Clone, Debug, Default)]
pub(super) struct Ports {
    rays: u32,
    hits: u32,
    runs: Runs,
    /// What the program has printed.
    pub(super) output: Vec<u8>,
    /// Its exit status.
    pub(super) exit: Option<i32>,
    /// A submission that cannot be made.
    fault: Option<SubmitError>,
    /// What the program was not built for and has met.
    missing: Option<Missing>,
}

/// The clocks of a core, and what memory takes, for estimates.
#[derive(Clone, Copy, Debug)]
struct Clocks {
    srp: Clock,
    tni: Clock,
    /// Cycles of the T&I unit from a request to its line.
    latency: u64,
}

impl Clocks {
    fn of(spec: &SystemSpec) -> Clocks {
        Clocks {
            srp: Clock::new(spec.srp_mhz),
            tni: Clock::new(spec.tni_mhz),
            latency: 0,
        }
    }
}

/// One SGRT core.
pub(super) struct CoreUnit {
    number: u32,
    engine: Box<dyn Core>,
    sram: Vec<u8>,
    pub(super) data: DataCache,
    pub(super) texture: TextureCache,
    pub(super) tni: Tni,
    /// How its units keep time.
    pub(super) timing: Timing,
    /// Where that is estimated: when the packets in the T&I unit are back, and its clocks.
    answers: VecDeque<u64>,
    clocks: Clocks,
    pub(super) ports: Ports,
    pub(super) state: State,
    /// The cycle from which the engine can go on.
    pub(super) ready: u64,
    pub(super) account: Account,
    /// What each tile takes, where that is wanted.
    pub(super) ledger: Option<Ledger>,
}

impl CoreUnit {
    pub(super) fn new(
        number: u32,
        engine: Box<dyn Core>,
        spec: &SystemSpec,
        sram: Vec<u8>,
        tree: Tree,
    ) -> CoreUnit {
        CoreUnit {
            number,
            engine,
            sram,
            data: DataCache::new(&spec.data_cache),
            texture: TextureCache::new(&spec.texture_cache),
            tni: Tni::new(&spec.tni, tree, spec.buffers.ray_buffers),
            timing: Timing::Full,
            answers: VecDeque::new(),
            clocks: Clocks::of(spec),
            ports: Ports::default(),
            state: State::Running,
            ready: 0,
            account: Account::default(),
            ledger: None,
        }
    }

    /// Sets how its units keep time, before the first cycle.
    pub(super) fn set_timing(&mut self, timing: Timing, spec: &SystemSpec) {
        self.timing = timing;
        if timing == Timing::Full && self.ledger.is_some() {
            self.tni.note_costs();
        }
        let at_once = timing == Timing::Untimed;
        (self.data.at_once, self.texture.lines.at_once) = (at_once, at_once);
        if timing == Timing::Estimated {
            self.clocks.latency = fidelity::line_cycles(spec);
        }
    }

    /// One cycle of the T&I unit.
    pub(super) fn tick_tni(&mut self, now: u64, memory: &SystemMemory) {
        if !self.tni.is_idle() {
            self.tni.tick(now, memory, &mut self.sram);
        }
    }

    /// SRP cycle `now`: goes on, if it is time. Says whether the core is at work.
    pub(super) fn step(
        &mut self,
        now: u64,
        memory: &mut SystemMemory,
        tiles: &mut TileQueue,
        guard: &Guard,
    ) -> Result<bool, SystemError> {
        if self.state == State::Halted {
            return Ok(false);
        }
        if now < self.ready {
            return Ok(true);
        }
        self.count_stall(now);
        if let Some(miss) = self.misses() {
            self.state = State::Stalled(now, miss);
            return Ok(false);
        }
        let mut bus = CoreBus {
            number: self.number,
            sram: &mut self.sram,
            data: &mut self.data,
            texture: &mut self.texture,
            tni: &mut self.tni,
            timing: self.timing,
            now,
            answers: &mut self.answers,
            clocks: self.clocks,
            ports: &mut self.ports,
            memory,
            tiles,
            guard,
            account: &self.account,
            ledger: self.ledger.as_mut(),
        };
        let run = self
            .engine
            .run(&mut bus, AHEAD)
            .map_err(|trap| SystemError::Trap {
                core: self.number,
                trap,
            })?;
        if let Some(fault) = self.ports.fault {
            return Err(SystemError::submission(self.number, fault));
        }
        if let Some(missing) = self.ports.missing.take() {
            return Err(SystemError::Effect {
                core: self.number,
                missing,
            });
        }
        self.ready = now + run.cycles;
        self.account.add(run);
        if let (Activity::Wait(ports::TNI_DONE), Some(&answer)) =
            (run.activity, self.answers.front())
            && answer > self.ready
        {
            // When the answer comes is known.
            self.account.add(Run {
                cycles: answer - self.ready,
                activity: run.activity,
            });
            self.ready = answer;
            self.state = State::Running;
            return Ok(true);
        }
        self.state = match run.activity {
            Activity::Wait(port) => State::Waiting(port),
            Activity::Halted(status) => {
                self.ports.exit.get_or_insert(status);
                State::Halted
            }
            _ => State::Running,
        };
        if self.ports.exit.is_some() && self.state != State::Halted {
            self.state = State::Halted;
        }
        if self.state == State::Halted {
            self.data.flush();
        }
        Ok(!matches!(self.state, State::Waiting(_)))
    }

    /// The next request of its caches to the memory.
    pub(super) fn next_request(&mut self, source: u32) -> Option<Request> {
        let lines = &mut self.texture.lines;
        let request =
            (self.data.take_request(source)).or_else(|| lines.take_request(source + TEXTURE))?;
        if let Some(ledger) = &mut self.ledger {
            let bytes = u64::from(request.bytes);
            match request.is_write {
                true => ledger.written += bytes,
                false => ledger.read += bytes,
            }
        }
        Some(request)
    }

    /// Charges what was not charged yet.
    pub(super) fn close_ledger(&mut self) {
        if let Some(ledger) = &mut self.ledger {
            ledger.take_rays(&self.tni.take_costs());
        }
        let sources = Sources {
            account: &self.account,
            data: &self.data,
            texture: &self.texture,
            tni: &self.tni,
        };
        if let Some(ledger) = &mut self.ledger {
            ledger.charge(&sources);
        }
    }

    /// The cache that the core has to wait for.
    pub(super) fn misses(&self) -> Option<Miss> {
        if self.data.waits() {
            Some(Miss::Data)
        } else {
            self.texture.lines.waits().then_some(Miss::Texture)
        }
    }

    /// Puts the cycles into the account since which the core, if it does, waits for a cache.
    pub(super) fn count_stall(&mut self, now: u64) {
        if let State::Stalled(since, miss) = &mut self.state {
            match miss {
                Miss::Data => self.account.memory_stall += now - *since,
                Miss::Texture => self.account.texture_stall += now - *since,
            }
            *since = now;
        }
    }
}

/// What an engine sees of its core.
struct CoreBus<'a> {
    number: u32,
    sram: &'a mut Vec<u8>,
    data: &'a mut DataCache,
    texture: &'a mut TextureCache,
    tni: &'a mut Tni,
    timing: Timing,
    now: u64,
    answers: &'a mut VecDeque<u64>,
    clocks: Clocks,
    ports: &'a mut Ports,
    memory: &'a mut SystemMemory,
    tiles: &'a mut TileQueue,
    guard: &'a Guard,
    account: &'a Account,
    ledger: Option<&'a mut Ledger>,
}

/// Whether an access of this size may be made at this address.
fn is_aligned(address: u32, bytes: u32) -> bool {
    matches!(bytes, 1 | 2 | 4 | 16) && address.is_multiple_of(bytes)
}

impl CoreBus<'_> {
    /// Tells the ledger, where there is one, what happens at a port.
    fn note(&mut self, happens: impl FnOnce(&mut Ledger, &Sources<'_>)) {
        if let Some(ledger) = &mut self.ledger {
            ledger.take_rays(&self.tni.take_costs());
        }
        let sources = Sources {
            account: self.account,
            data: self.data,
            texture: self.texture,
            tni: self.tni,
        };
        if let Some(ledger) = &mut self.ledger {
            happens(ledger, &sources);
        }
    }

    /// Puts into the caches what a tile is to find there; what was written goes to memory.
    fn find(&mut self, tags: &Tags) {
        self.data.flush();
        self.data.cache.hold_lines_of(&tags.data);
        self.texture.lines.cache.hold_lines_of(&tags.texture);
        self.tni.hold(&tags.tni);
    }

    /// Answers what has been sent to a T&I unit that is not run cycle by cycle.
    fn answer(&mut self) {
        let Clocks { srp, tni, latency } = self.clocks;
        match self.timing {
            Timing::Full => {}
            Timing::RecordedHits | Timing::Untimed => {
                self.tni.answer_at_once(self.memory, self.sram);
            }
            Timing::Estimated => {
                let now = tni.cycle_from(srp.start(self.now));
                let before = self.tni.progress();
                let back = (self.tni).answer_by_estimate(now, latency, self.memory, self.sram);
                self.answers.push_back(srp.cycle_from(tni.start(back + 1)));
                let after = self.tni.progress();
                let lines = |c: &TniCounters| c.trv_l2.misses + c.ist_l1.misses;
                if let Some(ledger) = &mut self.ledger {
                    let bytes = u64::from(self.tni.line_bytes());
                    ledger.tni_read += (lines(&after) - lines(&before)) * bytes;
                }
            }
        }
    }

    /// What system memory holds, zero-extended.
    fn words(&self, address: u32, bytes: u32) -> Option<Lanes> {
        let source = self.memory.get(address, bytes)?;
        let mut padded = [0; 16];
        padded[..bytes as usize].copy_from_slice(source);
        let word = |i: usize| {
            let bytes = padded[4 * i..4 * i + 4].try_into();
            u32::from_le_bytes(bytes.expect("a word has 4 bytes"))
        };
        Some([word(0), word(1), word(2), word(3)])
    }
}

impl Bus for CoreBus<'_> {
    fn sram(&mut self) -> &mut [u8] {
        self.sram
    }

    fn cached_load(&mut self, address: u32, bytes: u32) -> Option<Lanes> {
        if !is_aligned(address, bytes) {
            return None;
        }
        let value = self.words(address, bytes)?;
        self.data.load(address);
        Some(value)
    }

    fn cached_store(&mut self, address: u32, bytes: u32, value: Lanes) -> Option<()> {
        if !is_aligned(address, bytes) {
            return None;
        }
        let target = self.memory.get_mut(address, bytes)?;
        for (byte, value) in target
            .iter_mut()
            .zip(value.iter().flat_map(|w| w.to_le_bytes()))
        {
            *byte = value;
        }
        self.data.store(address, bytes);
        Some(())
    }

    fn texture_descriptor(&mut self, address: u32) -> Option<Lanes> {
        if !is_aligned(address, 16) {
            return None;
        }
        let words = self.words(address, 16)?;
        self.texture.descriptor(address);
        Some(words)
    }

    fn texels(&mut self, addresses: Lanes) -> Result<Lanes, u32> {
        let mut texels = Lanes::default();
        for (texel, address) in texels.iter_mut().zip(addresses) {
            let word = is_aligned(address, 4).then(|| self.words(address, 4));
            *texel = word.flatten().ok_or(address)?[0];
        }
        self.texture.texels(addresses);
        Ok(texels)
    }

    /// Also true when the program has ended, so that the engine goes no further.
    fn stalled(&self) -> bool {
        self.data.waits() || self.texture.lines.waits() || self.ports.exit.is_some()
    }

    fn port_in(&mut self, port: u32) -> Option<u32> {
        match port {
            ports::TILE => {
                let taken = self.tiles.take(self.number);
                let place = taken.as_ref().map(|t| t.0);
                self.note(|ledger, sources| ledger.take_tile(place, sources));
                let errand = taken.map(|t| t.1);
                if let Some(tags) = errand.as_ref().and_then(|e| e.find.as_ref()) {
                    self.find(tags);
                }
                Some(errand.map_or(u32::MAX, |e| e.tile))
            }
            ports::TNI_DONE => {
                if self.answers.front().is_some_and(|&at| at > self.now) {
                    return None;
                }
                if !self.guard.is_idle()
                    && let Some(missing) = self.guard.check(self.tni.finished()?)
                {
                    // The system stops after this run.
                    self.ports.missing = Some(missing.clone());
                }
                self.ports.runs = self.tni.take_finished()?;
                self.answers.pop_front();
                self.note(Ledger::take_packet);
                Some(self.ports.runs.shadow_hits)
            }
            ports::TNI_SHADOW_MISSES => Some(self.ports.runs.shadow_misses),
            ports::TNI_OTHER_HITS => Some(self.ports.runs.other_hits),
            ports::TNI_OTHER_MISSES => Some(self.ports.runs.other_misses),
            ports::CORE => Some(self.number),
            _ => None,
        }
    }

    fn port_out(&mut self, port: u32, value: u32) -> bool {
        match port {
            ports::TNI_RAYS => self.ports.rays = value,
            ports::TNI_HITS => self.ports.hits = value,
            ports::TNI_START => {
                let Ports { rays, hits, .. } = *self.ports;
                match self.tni.submit(rays, hits, value, self.sram.len()) {
                    Ok(()) => {
                        self.note(|ledger, _| ledger.send_packet());
                        self.answer();
                    }
                    Err(SubmitError::Busy) => return false,
                    // The system stops after this run.
                    Err(fault) => self.ports.fault = Some(fault),
                }
            }
            ports::PUTCHAR => self.ports.output.push(value as u8),
            ports::EXIT => self.ports.exit = Some(value as i32),
            _ => return false,
        }
        true
    }
}
