//! A core by itself: SRAM, system memory that answers at once, ports to standard output. Enough to
//! run a C program, and to try an engine.

use crate::core::{Activity, Bus, Core, Lanes, Run, Trap};
use crate::ports;
use serde::{Deserialize, Serialize};
use srp_archdesc::{Unwatched, Watch};
use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;

/// Where system memory begins.
pub use crate::memory::BASE as SYSTEM_BASE;

/// Words kept of those given to output ports, so that a program that writes for ever takes no memory.
pub const MAX_KEPT: usize = 1 << 20;

/// The surroundings of a core without a system. No access ever stalls, but for the banks of the SRAM.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Solo {
    /// SRAM, from address 0.
    pub sram: Vec<u8>,
    /// System memory, from [`SYSTEM_BASE`].
    pub memory: Vec<u8>,
    /// Words that wait at input ports.
    pub inputs: BTreeMap<u32, VecDeque<u32>>,
    /// Words given to output ports other than those of the standard output and the exit status: the first
    /// [`MAX_KEPT`] of all.
    pub outputs: BTreeMap<u32, Vec<u32>>,
    /// How many those are.
    kept: usize,
    /// Bytes written to the standard output, as far as a [`Watch`] has not taken them.
    pub output: Vec<u8>,
    /// The status given to the exit port, which ends the program.
    pub exit: Option<i32>,
    /// Cycles for which banks of the SRAM keep the core after its last run.
    owed: u64,
}

impl Solo {
    /// An SRAM of `sram_bytes` bytes that begins with `image` and is zero otherwise, core number 0,
    /// no tiles, and no system memory.
    pub fn new(image: &[u8], sram_bytes: u32) -> Solo {
        let mut sram = image.to_vec();
        sram.resize(sram.len().max(sram_bytes as usize), 0);
        Solo {
            sram,
            ..Solo::default()
        }
    }

    /// Cycles for which banks of the SRAM keep the core after its last run. Asked again, there are none.
    pub fn take_owed(&mut self) -> u64 {
        std::mem::take(&mut self.owed)
    }

    /// Stands still for one of these cycles; false if there is none.
    pub fn stand_still(&mut self) -> bool {
        let stands = self.owed > 0;
        self.owed -= u64::from(stands);
        stands
    }

    fn mapped(&mut self, address: u32, bytes: u32) -> Option<&mut [u8]> {
        if !address.is_multiple_of(bytes) {
            return None;
        }
        let start = address.checked_sub(SYSTEM_BASE)? as usize;
        self.memory.get_mut(start..start + bytes as usize)
    }
}

impl Bus for Solo {
    fn sram(&mut self) -> &mut [u8] {
        &mut self.sram
    }

    fn cached_load(&mut self, address: u32, bytes: u32) -> Option<Lanes> {
        let mut lanes = Lanes::default();
        for (i, &byte) in self.mapped(address, bytes)?.iter().enumerate() {
            lanes[i / 4] |= u32::from(byte) << (8 * (i % 4));
        }
        Some(lanes)
    }

    fn cached_store(&mut self, address: u32, bytes: u32, value: Lanes) -> Option<()> {
        for (i, byte) in self.mapped(address, bytes)?.iter_mut().enumerate() {
            *byte = (value[i / 4] >> (8 * (i % 4))) as u8;
        }
        Some(())
    }

    fn prefetch(&mut self, _address: u32) {}

    fn conflict(&mut self, cycles: u32) {
        self.owed += u64::from(cycles);
    }

    fn texture_descriptor(&mut self, address: u32) -> Option<Lanes> {
        self.cached_load(address, 16)
    }

    fn texels(&mut self, addresses: Lanes) -> Result<Lanes, u32> {
        let mut texels = Lanes::default();
        for (texel, address) in texels.iter_mut().zip(addresses) {
            *texel = self.cached_load(address, 4).ok_or(address)?[0];
        }
        Ok(texels)
    }

    fn fetch(&mut self, _bundle: u32) -> Range<u32> {
        0..u32::MAX
    }

    fn launch(&mut self, _kernel: u32) {}

    /// Also true when the program has ended, so that an engine goes no further.
    fn stalled(&self) -> bool {
        self.owed > 0 || self.exit.is_some()
    }

    fn port_in(&mut self, port: u32) -> Option<u32> {
        match (self.inputs.get_mut(&port), port) {
            (Some(queue), _) => queue.pop_front(),
            (None, ports::CORE) => Some(0),
            (None, ports::TILE) => Some(u32::MAX),
            (None, _) => None,
        }
    }

    fn port_out(&mut self, port: u32, value: u32) -> bool {
        match port {
            ports::PUTCHAR => self.output.push(value as u8),
            ports::EXIT => self.exit = Some(value as i32),
            _ if self.kept < MAX_KEPT => {
                self.kept += 1;
                self.outputs.entry(port).or_default().push(value);
            }
            _ => {}
        }
        true
    }
}

/// How a program ended, and the cycles it took.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finish {
    /// Its exit status.
    pub status: i32,
    /// Cycles of VLIW code.
    pub vliw: u64,
    /// Cycles of mode switches.
    pub switch: u64,
    /// Cycles of each kernel, by its number.
    pub kernels: BTreeMap<u32, u64>,
    /// Cycles in which it stood still because accesses met in a bank of the SRAM.
    pub sram_stall: u64,
}

impl Finish {
    /// All cycles.
    pub fn cycles(&self) -> u64 {
        self.vliw + self.switch + self.kernels.values().sum::<u64>() + self.sram_stall
    }
}

/// Why a program did not end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SoloError {
    /// It trapped.
    Trap(Trap),
    /// It waits for a port that nobody will ever serve.
    Deadlock {
        /// The port.
        port: u32,
    },
    /// It has not ended within the cycles it was given.
    Endless {
        /// How many they were.
        limit: u64,
    },
    /// It was stopped.
    Stopped,
}

impl std::fmt::Display for SoloError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            SoloError::Trap(trap) => trap.fmt(f),
            SoloError::Deadlock { port } => {
                write!(
                    f,
                    "the program waits for port {port}, where nothing is connected"
                )
            }
            SoloError::Endless { limit } => {
                write!(f, "the program has not ended after {limit} cycles")
            }
            SoloError::Stopped => f.write_str("the program was stopped"),
        }
    }
}

impl std::error::Error for SoloError {}

/// Runs a program to its end, for at most `limit` cycles.
///
/// # Errors
///
/// If it traps, waits for ever, or does not end in time.
pub fn run(core: &mut dyn Core, solo: &mut Solo, limit: u64) -> Result<Finish, SoloError> {
    let mut finish = Finish::default();
    run_until(core, solo, limit, &Unwatched, &mut finish)?;
    Ok(finish)
}

/// Cycles between two looks at whether to stop.
const LOOK_INTERVAL: u64 = 1 << 20;

/// The same, unless the watch ends it, which may take what is printed meanwhile; `finish` counts the cycles, however it ends.
///
/// # Errors
///
/// Those of [`run`], and [`SoloError::Stopped`].
pub fn run_until(
    core: &mut dyn Core,
    solo: &mut Solo,
    limit: u64,
    watch: &dyn Watch,
    finish: &mut Finish,
) -> Result<(), SoloError> {
    let mut look = LOOK_INTERVAL;
    loop {
        let done = finish.cycles();
        if done >= limit {
            return Err(SoloError::Endless { limit });
        }
        if done >= look {
            look = done + LOOK_INTERVAL;
            if !solo.output.is_empty() && watch.printed(&solo.output) {
                solo.output.clear();
            }
            if watch.cancelled() {
                return Err(SoloError::Stopped);
            }
        }
        let budget = limit.min(look) - done;
        let Run {
            cycles, activity, ..
        } = core.run(solo, budget).map_err(SoloError::Trap)?;
        finish.sram_stall += solo.take_owed();
        match activity {
            Activity::Vliw => finish.vliw += cycles,
            Activity::Switch => finish.switch += cycles,
            Activity::Array(kernel) => *finish.kernels.entry(kernel).or_default() += cycles,
            Activity::Wait(port) => return Err(SoloError::Deadlock { port }),
            Activity::Halted(status) => {
                finish.status = status;
                return Ok(());
            }
        }
        if let Some(status) = solo.exit {
            finish.status = status;
            return Ok(());
        }
    }
}
