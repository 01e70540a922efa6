//! **DRE**: the program divided between the two engines, and the same scheduled. Both are files:
//! any tool that reads and writes the XML can take a scheduler's place.

use crate::dfg::Dfg;
use crate::program::{Kernel, Program};
use srp_archdesc::entity::EntityMap;

mod run;
pub mod scheduled;

pub use run::run;

/// A program split in two: control code for the VLIW engine, loops for the array.
///
/// Always holds: the control code is a valid [`Program`]; its launches name kernels of `kernels`
/// and bring and take values as the [`Dfg`] says.
#[derive(Clone, Debug, PartialEq)]
pub struct Dre {
    /// Everything that runs on the VLIW engine.
    pub control: Program,
    /// The loops that run on the array.
    pub kernels: EntityMap<Kernel, Dfg>,
}
