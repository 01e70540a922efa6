//! The border between one simulated SRP and everything round it.
//!
//! An engine (the table interpreter or a generated simulator) implements [`Core`]; the system
//! implements [`Bus`]. The array and the VLIW engine are statically scheduled, so an engine's time
//! varies for two reasons only, and both are the bus's word: a cached access that misses ends a run
//! ([`Bus::stalled`]), after which the whole core may be frozen, and a port that is not ready holds the VLIW engine where it is.

/// The text of this file, which depends on nothing but `std`: it is part of every generated
/// simulator.
pub const SOURCE: &str = include_str!("core.rs");

use std::ops::Range;

/// A 128-bit value: four words, lane 0 first. Narrower values use lane 0.
pub type Lanes = [u32; 4];

/// The services that an SRP asks of the system. Every call happens in the current cycle of the core.
pub trait Bus {
    /// The core's SRAM, little endian. Engines check bounds themselves and trap.
    fn sram(&mut self) -> &mut [u8];

    /// Reads 1, 2, 4 or 16 bytes of system memory through the data cache, zero-extended. The value
    /// is there at once; a miss shows as [`stalled`](Self::stalled) afterwards. `None` where the
    /// address is not mapped or not aligned to its size.
    fn cached_load(&mut self, address: u32, bytes: u32) -> Option<Lanes>;

    /// Writes 1, 2, 4 or 16 bytes of system memory through the data cache. `None` as above.
    fn cached_store(&mut self, address: u32, bytes: u32, value: Lanes) -> Option<()>;

    /// Asks for the line of an address in the data cache, whether that is mapped or not. The core never waits for it.
    fn prefetch(&mut self, address: u32);

    /// Reads the 16 bytes of a texture's descriptor through the texture cache; a miss shows as
    /// [`stalled`](Self::stalled). `None` where the address is not mapped or not aligned.
    fn texture_descriptor(&mut self, address: u32) -> Option<Lanes>;

    /// Reads four texels of 4 bytes through the texture cache, one access for each line that they
    /// lie in; misses as above.
    ///
    /// # Errors
    ///
    /// The first of the addresses that is not mapped or not aligned.
    fn texels(&mut self, addresses: Lanes) -> Result<Lanes, u32>;

    /// The VLIW engine reads a bundle, by its number: the bundles that it can issue next without asking again; the one
    /// that it has asked for need not be one of them. Bytes that are not there show as [`stalled`](Self::stalled)
    /// afterwards. Asking again for the bundle that was read last changes nothing.
    fn fetch(&mut self, bundle: u32) -> Range<u32>;

    /// The VLIW engine launches a kernel. Contexts that are not there show as [`stalled`](Self::stalled).
    fn launch(&mut self, kernel: u32);

    /// The accesses to the SRAM of the cycle that ends here keep the core for `cycles` more, because of its banks.
    fn conflict(&mut self, cycles: u32);

    /// True if the run has to end after the cycle that made the last access: the core is frozen, or a load has missed.
    fn stalled(&self) -> bool;

    /// Takes a word from an input port, or `None` where the core has to wait for it.
    fn port_in(&mut self, port: u32) -> Option<u32>;

    /// Offers a word to an output port; `false` where the core has to wait.
    fn port_out(&mut self, port: u32, value: u32) -> bool;
}

/// The activity of a core in a run of cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// Issued VLIW bundles.
    Vliw,
    /// Ran a kernel, by its number in the scheduled program, on the array.
    Array(u32),
    /// Changed between the VLIW engine and the array, or set registers for a kernel.
    Switch,
    /// Waited for a port.
    Wait(u32),
    /// Returned from `main` with this value. Takes no cycle, and stays.
    Halted(i32),
}

/// A run of cycles of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Length in SRP cycles: at least 1, unless halted.
    pub cycles: u64,
    /// The activity in all of them.
    pub activity: Activity,
    /// The operations that were issued, those too whose guard was false: of bundles, with control transfers; on the
    /// array, all of an iteration that has begun, without moves of values.
    pub operations: u64,
}

/// Why a simulation cannot go on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trap {
    /// Its kind.
    pub kind: TrapKind,
    /// Source position, `file:line:column`, where known.
    pub at: Option<String>,
    /// Source positions of the open calls, innermost first: at most [`MAX_TOLD_CALLS`].
    pub calls: Vec<String>,
}

/// Open calls that a trap tells of.
pub const MAX_TOLD_CALLS: usize = 16;

/// Kinds of traps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrapKind {
    /// An access outside its memory, or not aligned to its size.
    Access {
        /// The address, in bytes.
        address: u32,
        /// The size, in bytes.
        bytes: u32,
    },
    /// An integer division by zero.
    DivisionByZero,
    /// The stack has run into the data below it.
    StackOverflow,
    /// A call through a pointer that is no function.
    BadCall(u32),
    /// Code that must not be reached.
    Unreachable,
}

impl std::fmt::Display for Trap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(at) = &self.at {
            write!(f, "{at}: ")?;
        }
        match self.kind {
            TrapKind::Access { address, bytes } => {
                let why = match address.is_multiple_of(bytes.max(1)) {
                    true => "outside memory",
                    false => "not aligned to its size",
                };
                write!(f, "access of {bytes} bytes at {address:#010x} is {why}")
            }
            TrapKind::DivisionByZero => f.write_str("integer division by zero"),
            TrapKind::StackOverflow => f.write_str("stack overflow"),
            TrapKind::BadCall(target) => write!(f, "call of {target:#x}, which is no function"),
            TrapKind::Unreachable => f.write_str("unreachable code was reached"),
        }?;
        self.calls
            .iter()
            .try_for_each(|call| write!(f, "\n  called at {call}"))
    }
}

impl std::error::Error for Trap {}

/// All state of a core, in words whose meaning is the engines' own: registers, values in flight, and the
/// place in the program. All engines of one program have the same words for the same state.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CoreState {
    /// The words.
    pub words: Vec<u32>,
}

/// One simulated SRP, ready to run from its entry.
pub trait Core {
    /// Runs at most `budget` (≥ 1) cycles, as long as they are of one kind. Stops after a cycle in
    /// which the bus stalled, and before a cycle that would talk to a port, unless that is the
    /// first: so the bus knows when ports are talked to, and a wait is one cycle long. The same
    /// program gives the same cycles however they are cut.
    fn run(&mut self, bus: &mut dyn Bus, budget: u64) -> Result<Run, Trap>;

    /// All of its state, between two runs; `None` from an engine that keeps it to itself, and where nothing but a trap
    /// follows.
    fn save(&self) -> Option<CoreState> {
        None
    }

    /// Goes on from a state that an engine of the same program has saved. `false`, and the core is
    /// of no use any more, where the words are none of this program's.
    fn restore(&mut self, state: &CoreState) -> bool {
        let _ = state;
        false
    }
}
