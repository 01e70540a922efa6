//! Why a frame was not finished.

use std::fmt;

use crate::core::Trap;
use crate::effect::Missing;
use crate::tni::SubmitError;

/// Why a frame was not finished.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SystemError {
    /// There are no cores.
    NoCores,
    /// The machine cannot be simulated.
    Machine(String),
    /// A core's program did something that cannot be done.
    Trap {
        /// The core.
        core: u32,
        /// Its trap.
        trap: Trap,
        /// The SRP cycle.
        cycle: u64,
        /// What each core does, one line each.
        waits: String,
    },
    /// A core handed the T&I unit buffers that are not in its SRAM.
    Submission {
        /// The core.
        core: u32,
        /// Address of the buffer.
        address: u32,
        /// Its size in bytes.
        bytes: u32,
    },
    /// A snapshot was to be taken or gone on from, and an engine keeps its state to itself.
    NoState,
    /// The program needs an effect that it was not built for.
    Effect {
        /// The core.
        core: u32,
        /// The effect that is missing.
        missing: Missing,
    },
    /// Nothing can move any more.
    Deadlock {
        /// The SRP cycle.
        cycle: u64,
        /// Who waits for what, one line each.
        waits: String,
    },
    /// More than [`Options::max_cycles`](super::Options::max_cycles).
    TooLong {
        /// The limit.
        cycles: u64,
        /// What each core does, one line each.
        waits: String,
    },
}

impl SystemError {
    pub(super) fn submission(core: u32, fault: SubmitError) -> SystemError {
        let (address, bytes) = match fault {
            SubmitError::OutOfBounds { address, bytes } => (address, bytes),
            SubmitError::Busy => (0, 0),
        };
        SystemError::Submission {
            core,
            address,
            bytes,
        }
    }
}

impl fmt::Display for SystemError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SystemError::NoCores => f.write_str("the system has no cores"),
            SystemError::Machine(why) => write!(f, "this machine cannot be simulated: {why}"),
            SystemError::Trap {
                core,
                trap,
                cycle,
                waits,
            } => write!(
                f,
                "core {core} trapped: {trap}\nthat was in cycle {cycle}:\n{waits}"
            ),
            SystemError::Submission {
                core,
                address,
                bytes,
            } => write!(
                f,
                "core {core} handed its T&I unit a buffer of {bytes} bytes at {address:#x}, which \
                 is outside the SRAM or not aligned to 4 bytes"
            ),
            SystemError::NoState => f.write_str(
                "the engine of a core can neither save its state nor go on from this one",
            ),
            SystemError::Effect { core, missing } => write!(f, "core {core} stops: {missing}"),
            SystemError::Deadlock { cycle, waits } => {
                write!(f, "nobody moves any more in cycle {cycle}:\n{waits}")
            }
            SystemError::TooLong { cycles, waits } => {
                write!(f, "the frame takes more than {cycles} cycles:\n{waits}")
            }
        }
    }
}

impl std::error::Error for SystemError {}
