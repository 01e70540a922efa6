//! Checkpoints of a simulation.

use clap::Args;
use std::path::PathBuf;

/// The state on the way, to be kept and to go on from.
#[derive(Args)]
pub(crate) struct Checkpoints {
    /// Keep the whole state as it is in this cycle, or in the first after it at which it can be told, and go on
    #[arg(long, value_name = "CYCLE")]
    pub(crate) checkpoint_at: Option<u64>,
    /// The file for the state
    #[arg(
        long,
        value_name = "FILE",
        requires = "checkpoint_at",
        default_value = "srp.checkpoint"
    )]
    pub(crate) checkpoint: PathBuf,
    /// Go on from a state that was kept: of the same program, machine, scene and build of srp
    #[arg(long, value_name = "FILE", conflicts_with = "profile")]
    pub(crate) restore: Option<PathBuf>,
}
