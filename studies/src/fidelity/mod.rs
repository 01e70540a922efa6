//! Levels of simulation: what is left out, and what that saves; and frames at each of them.
//!
//! | level | SRP | T&I unit | memory |
//! |---|---|---|---|
//! | `functional` | computes, without stalls | answers at once | takes no time |
//! | `analytic` | cycle by cycle | rays one by one, a visit taking what it takes unhindered | fixed latency |
//! | `sampled` | cycle by cycle, for a sample of tiles or packets | the same | with banks |
//! | `cycle` | cycle by cycle | cycle by cycle | fixed latency |
//! | `cycle+dram` | cycle by cycle | cycle by cycle | as the machine says: with banks |
//!
//! Picture and counts are the same on all of them but where only a part is run. The fixed latency is the
//! mean of the machine's own memory for reads that come alone ([`with_fixed_latency`]).

mod figures;
mod host_time;
mod kept;
mod ledger;
mod prepared;
pub mod sampled;
mod table;
mod untimed;

use serde::Serialize;
use srp_archdesc::Arch;
use srp_runtime::memory::unloaded::with_fixed_latency;
use srp_runtime::system::Timing;

pub use figures::{FrameFigure, FrameQuantity, known};
pub use host_time::HostTime;
pub use ledger::{COLUMNS, Column, Part, Tally, render_tiles};
pub use prepared::{Prepared, Whole};
pub use table::{Cell, Row, Table, TableOptions, TrialFigure, Trials, table};
pub use untimed::{Untimed, untimed};

/// A level of simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Fidelity {
    /// Picture and counts, no clock.
    Functional,
    /// Cycles of the T&I unit from counts, hit rates and bounds.
    Analytic,
    /// A sample, with intervals.
    Sampled,
    /// Every cycle, with a memory of fixed latency.
    Cycle,
    /// Every cycle, with the machine's memory.
    CycleDram,
}

impl Fidelity {
    /// All of them, from the cheapest.
    pub const ALL: [Fidelity; 5] = [
        Fidelity::Functional,
        Fidelity::Analytic,
        Fidelity::Sampled,
        Fidelity::Cycle,
        Fidelity::CycleDram,
    ];

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Fidelity::Functional => "functional",
            Fidelity::Analytic => "analytic",
            Fidelity::Sampled => "sampled",
            Fidelity::Cycle => "cycle",
            Fidelity::CycleDram => "cycle+dram",
        }
    }

    /// How the units of a system keep time.
    pub const fn timing(self) -> Timing {
        match self {
            Fidelity::Functional => Timing::Untimed,
            Fidelity::Analytic => Timing::Estimated,
            _ => Timing::Full,
        }
    }

    /// The machine as it is simulated.
    pub fn machine(self, arch: &Arch) -> Arch {
        let mut arch = arch.clone();
        if matches!(self, Fidelity::Analytic | Fidelity::Cycle) {
            arch.system.dram = with_fixed_latency(&arch.system);
        }
        arch
    }
}
