//! The command line of `srp dram`.

use super::MachineFile;
use clap::Args;
use clap::builder::PossibleValuesParser;
use srp_archdesc::dram::presets;
use srp_runtime::memory::dram::trace::MAX_CYCLE;
use std::path::PathBuf;

/// `srp dram`
#[derive(Args)]
#[command(after_help = "\
A line of a trace is a request: address (decimal, or hexadecimal after 0x), READ or WRITE, the memory
cycle from which on it is offered, and optionally its bytes, without which it is one burst. What follows
a # is a comment. Requests are offered in order, one in a cycle; where there is no room they wait.

Examples:
  srp dram requests.trace --preset lpddr3-1600 --cycles 80000
  srp dram requests.trace --machine my-machine.xml --json
  srp dram --presets")]
pub(crate) struct Dram {
    /// The trace
    #[arg(required_unless_present = "presets")]
    pub(crate) trace: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineFile,
    /// Memory of this name, instead of a machine's
    #[arg(
        long,
        value_name = "NAME",
        value_parser = PossibleValuesParser::new(memories()),
        conflicts_with_all = ["machine", "set"]
    )]
    pub(crate) preset: Option<String>,
    /// Simulate so many memory cycles; without it, until every request is answered
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_CYCLE))]
    pub(crate) cycles: Option<u64>,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
    /// List the memories that have a name, and where their figures come from
    #[arg(long)]
    pub(crate) presets: bool,
}

/// Names of the memories that `--preset` takes.
fn memories() -> impl Iterator<Item = &'static str> {
    presets().into_iter().map(|p| p.name).chain(["fixed"])
}
