//! Work that processes share, on this host or on others.

use clap::Args;
use std::path::PathBuf;

/// How work is shared.
#[derive(Args, Debug)]
#[command(next_help_heading = "Several processes and hosts")]
pub(crate) struct Sharing {
    /// Share the work with all processes that run the same command with this folder: each makes the pieces that nobody has
    /// begun, and takes the others'. What is there from before is not made again
    #[arg(long, value_name = "DIR")]
    pub(crate) share: Option<PathBuf>,
    /// Start processes that share the work, and wait: slurm (a job array), dask or dask:ADDRESS, or a command that runs
    /// what stands for {} and waits, as 'hq submit --wait {}'
    #[arg(long, value_name = "ENGINE", requires = "share")]
    pub(crate) jobs_on: Option<String>,
    /// How many processes --jobs-on starts
    #[arg(long, value_name = "N", default_value = "8", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) jobs: u32,
    /// Refuse to run if this is another build of the tool
    #[arg(long, value_name = "ID", hide = true)]
    pub(crate) build: Option<String>,
}
