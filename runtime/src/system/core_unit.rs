//! One SGRT core: an SRP engine, its SRAM, data cache and texture cache, its T&I unit, and the account of its
//! cycles.

use srp_archdesc::ports;
use srp_archdesc::system::SystemSpec;

use super::data_cache::DataCache;
use super::report::Account;
use super::texture_cache::TextureCache;
use super::{SystemError, TileQueue};
use crate::core::{Activity, Bus, Core, Lanes};
use crate::effect::{Guard, Missing};
use crate::memory::SystemMemory;
use crate::tni::{Runs, SubmitError, Tni, Tree};

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

/// One SGRT core.
pub(super) struct CoreUnit {
    number: u32,
    engine: Box<dyn Core>,
    sram: Vec<u8>,
    pub(super) data: DataCache,
    pub(super) texture: TextureCache,
    pub(super) tni: Tni,
    /// Whether the T&I unit answers at once.
    pub(super) recorded_hits: bool,
    pub(super) ports: Ports,
    pub(super) state: State,
    /// The cycle from which the engine can go on.
    pub(super) ready: u64,
    pub(super) account: Account,
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
            recorded_hits: false,
            ports: Ports::default(),
            state: State::Running,
            ready: 0,
            account: Account::default(),
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
            recorded_hits: self.recorded_hits,
            ports: &mut self.ports,
            memory,
            tiles,
            guard,
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
    recorded_hits: bool,
    ports: &'a mut Ports,
    memory: &'a mut SystemMemory,
    tiles: &'a mut TileQueue,
    guard: &'a Guard,
}

/// Whether an access of this size may be made at this address.
fn is_aligned(address: u32, bytes: u32) -> bool {
    matches!(bytes, 1 | 2 | 4 | 16) && address.is_multiple_of(bytes)
}

impl CoreBus<'_> {
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
            ports::TILE => Some(self.tiles.take()),
            ports::TNI_DONE => {
                if !self.guard.is_idle()
                    && let Some(missing) = self.guard.check(self.tni.finished()?)
                {
                    // The system stops after this run.
                    self.ports.missing = Some(missing.clone());
                }
                self.ports.runs = self.tni.take_finished()?;
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
                    Ok(()) if self.recorded_hits => self.tni.answer_at_once(self.memory, self.sram),
                    Ok(()) => {}
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
