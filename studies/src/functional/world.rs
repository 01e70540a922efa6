//! The world of the program of one tile: its SRAM, system memory, and the ports of its core.

use super::{Counts, FunctionalError, Stage};
use srp_archdesc::isa::Space;
use srp_archdesc::ops::{V4, Value};
use srp_archdesc::ports;
use srp_ir::interp::{Outcome, PortOut, Trap, World};
use srp_ir::layout::FIRST_ADDRESS;
use srp_runtime::effect::{Guard, Missing};
use srp_runtime::memory::SystemMemory;
use srp_runtime::tni::{Buffers, HitRecord, Runs, SubmitError, Untimed};

/// Why a program is stopped that has done nothing wrong by itself.
#[derive(Clone, Debug)]
pub(crate) enum Fault {
    Submission { address: u32, bytes: u32 },
    Effect(Missing),
}

/// The world of one tile.
pub(crate) struct TileWorld<'a> {
    memory: &'a SystemMemory,
    guard: &'a Guard,
    sram: Vec<u8>,
    /// Where the frame buffer starts, and what it holds.
    frame: u32,
    buffer: Vec<u8>,
    /// Words that were written, as bytes from its start.
    written: Vec<u32>,
    tile: Option<u32>,
    tni: Untimed,
    rays: u32,
    hits: u32,
    runs: Runs,
    counts: Counts,
    fault: Option<Fault>,
    /// The ray buffer and the hit buffer of the last submission, and its hits.
    submitted: Option<(u32, u32)>,
    records: Vec<HitRecord>,
}

impl<'a> TileWorld<'a> {
    /// The world of a tile, or of a core for which there is none.
    pub(crate) fn new(stage: &Stage<'a>, tile: Option<u32>) -> TileWorld<'a> {
        let image = stage.image;
        let system = &stage.arch.system;
        let mut sram = stage.layout.image.clone();
        sram.resize(system.sram_bytes as usize, 0);
        let frame = image.frame.address;
        let bytes = image.frame.stride * image.frame.rows * 4;
        let buffer = image.memory.get(frame, bytes).unwrap_or_default().to_vec();
        TileWorld {
            memory: &image.memory,
            guard: stage.guard,
            sram,
            frame,
            buffer,
            written: Vec::new(),
            tile,
            tni: stage.tni.clone(),
            rays: 0,
            hits: 0,
            runs: Runs::default(),
            counts: Counts::default(),
            fault: None,
            submitted: None,
            records: Vec::new(),
        }
    }

    /// Addresses of the ray buffer and the hit buffer of the last submission.
    pub(crate) fn submitted(&self) -> Option<(u32, u32)> {
        self.submitted
    }

    /// Its hits, in the order of the hit buffer.
    pub(crate) fn records(&self) -> &[HitRecord] {
        &self.records
    }

    /// A word of the SRAM.
    pub(crate) fn sram_word(&self, address: u32) -> u32 {
        let bytes = self.sram.get(address as usize..address as usize + 4);
        bytes.map_or(0, |bytes| value(bytes).as_word())
    }

    /// Returns the outcome of a run, or its fault as an error of a frame.
    pub(crate) fn judge(
        &mut self,
        ran: Result<Outcome, Trap>,
        tile: Option<u32>,
        program: &srp_ir::Program,
    ) -> Result<Outcome, FunctionalError> {
        match (self.fault.take(), ran) {
            (Some(Fault::Submission { address, bytes }), _) => {
                Err(FunctionalError::Submission { address, bytes })
            }
            (Some(Fault::Effect(missing)), _) => Err(FunctionalError::Effect(missing)),
            (None, Err(trap)) => Err(FunctionalError::Trap {
                tile,
                what: trap.show(program),
            }),
            (None, Ok(outcome)) => Ok(outcome),
        }
    }

    /// Returns the counts, and the words written to the frame buffer, in order: bytes from its start, and the
    /// word.
    pub(crate) fn finish(mut self) -> (Counts, Vec<(u32, u32)>) {
        self.written.sort_unstable();
        self.written.dedup();
        let word = |&at: &u32| {
            let at = at as usize;
            let bytes = self.buffer[at..at + 4].try_into();
            u32::from_le_bytes(bytes.expect("a word has 4 bytes"))
        };
        let writes = self.written.iter().map(|at| (*at, word(at))).collect();
        self.counts.rays = self.tni.counts;
        (self.counts, writes)
    }

    /// The bytes of system memory from `address` on.
    #[inline]
    fn cached(&self, address: u32, bytes: u32) -> Option<&[u8]> {
        match address.checked_sub(self.frame) {
            None => self.memory.get(address, bytes),
            Some(at) => self.buffer.get(at as usize..at as usize + bytes as usize),
        }
    }

    fn submit(&mut self, count: u32) -> bool {
        let (rays, hits) = (self.rays, self.hits);
        let buffers = Buffers { rays, hits, count };
        match self.tni.submit(buffers, self.memory, &mut self.sram) {
            Ok(records) => {
                self.records.clear();
                self.records.extend_from_slice(records);
                self.submitted = Some((rays, hits));
                true
            }
            Err(SubmitError::Busy) => false,
            Err(SubmitError::OutOfBounds { address, bytes }) => {
                self.fault = Some(Fault::Submission { address, bytes });
                false
            }
        }
    }

    /// Takes the answer to the oldest submission.
    fn take_finished(&mut self) -> Option<u32> {
        let finished = self.tni.take_finished()?;
        if let Some(missing) = self.guard.check(&finished.hits) {
            self.fault = Some(Fault::Effect(missing.clone()));
            return None;
        }
        self.runs = finished.runs;
        Some(self.runs.shadow_hits)
    }
}

/// The value of 1, 2, 4 or 16 bytes.
#[inline]
fn value(bytes: &[u8]) -> Value {
    let word = |i: usize| u32::from_le_bytes([bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]]);
    match bytes.len() {
        16 => V4([word(0), word(4), word(8), word(12)]),
        4 => Value::word(word(0)),
        2 => Value::word(u32::from(u16::from_le_bytes([bytes[0], bytes[1]]))),
        _ => Value::word(u32::from(bytes[0])),
    }
}

/// The low bytes of a value.
#[inline]
fn put(value: Value, to: &mut [u8]) {
    for (bytes, word) in to.chunks_mut(4).zip(value.0) {
        bytes.copy_from_slice(&word.to_le_bytes()[..bytes.len()]);
    }
}

impl World for TileWorld<'_> {
    #[inline]
    fn load(&mut self, space: Space, address: u32, bytes: u32) -> Option<Value> {
        if !address.is_multiple_of(bytes) {
            return None;
        }
        match space {
            Space::Sram if address < FIRST_ADDRESS => None,
            Space::Sram => {
                let at = address as usize;
                self.sram.get(at..at + bytes as usize).map(value)
            }
            Space::Cached => {
                self.counts.cached_loads += 1;
                self.cached(address, bytes).map(value)
            }
        }
    }

    #[inline]
    fn store(&mut self, space: Space, address: u32, bytes: u32, value: Value) -> Option<()> {
        if !address.is_multiple_of(bytes) {
            return None;
        }
        let target = match space {
            Space::Sram if address < FIRST_ADDRESS => return None,
            Space::Sram => {
                let at = address as usize;
                self.sram.get_mut(at..at + bytes as usize)?
            }
            Space::Cached => {
                self.counts.cached_stores += 1;
                let at = address.checked_sub(self.frame)?;
                let range = at as usize..at as usize + bytes as usize;
                let target = self.buffer.get_mut(range)?;
                self.written.extend((at & !3..at + bytes).step_by(4));
                target
            }
        };
        put(value, target);
        Some(())
    }

    fn texture_descriptor(&mut self, address: u32) -> Option<Value> {
        self.counts.texture_lookups += 1;
        let aligned = address.is_multiple_of(16);
        aligned.then(|| self.cached(address, 16).map(value))?
    }

    fn texel(&mut self, address: u32) -> Option<u32> {
        let aligned = address.is_multiple_of(4);
        aligned.then(|| self.cached(address, 4).map(|bytes| value(bytes).as_word()))?
    }

    fn port_in(&mut self, port: u32) -> Option<u32> {
        match port {
            ports::TILE => Some(self.tile.take().unwrap_or(u32::MAX)),
            ports::TNI_DONE => self.take_finished(),
            ports::TNI_SHADOW_MISSES => Some(self.runs.shadow_misses),
            ports::TNI_OTHER_HITS => Some(self.runs.other_hits),
            ports::TNI_OTHER_MISSES => Some(self.runs.other_misses),
            ports::CORE => Some(0),
            _ => None,
        }
    }

    fn port_out(&mut self, port: u32, value: u32) -> PortOut {
        match port {
            ports::TNI_RAYS => self.rays = value,
            ports::TNI_HITS => self.hits = value,
            ports::TNI_START => {
                if !self.submit(value) {
                    return PortOut::Blocked;
                }
            }
            ports::PUTCHAR => {}
            ports::EXIT => return PortOut::Exit(value as i32),
            _ => return PortOut::Blocked,
        }
        PortOut::Taken
    }
}
