//! Levels of simulation on the command line, and `srp fidelity`.

use super::frame::{BUILDERS, Frame, parse_size};
use super::{ENGINES, one_of, parse_threads};
use clap::{Args, ValueEnum};
use srp_runtime::bvh::Builder;
use srp_studies::fidelity::Fidelity;
use srp_toolchain::Engine;
use std::path::PathBuf;

/// How much is simulated.
#[derive(Args)]
pub(crate) struct Level {
    /// Level of simulation: functional has a picture and counts but no clock, analytic estimates
    /// the T&I unit, sampled measures a part, cycle has a memory of fixed latency
    #[arg(long, value_name = "LEVEL", default_value = "cycle+dram", value_parser = parse_level)]
    pub(crate) fidelity: Fidelity,
    /// With --fidelity sampled: measure until drawing leaves the 95 % interval of the cycles this narrow, to
    /// both sides; what a sample may be off by besides is added to the interval
    #[arg(long, value_name = "PERCENT", default_value = "1%", value_parser = parse_error)]
    pub(crate) error: f64,
    /// What is drawn with --fidelity sampled
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
}

impl Level {
    /// The same as studies take it.
    pub(crate) fn plain(&self) -> srp_studies::views::Level {
        srp_studies::views::Level {
            fidelity: self.fidelity,
            error: self.error,
            seed: self.seed,
        }
    }
}

fn parse_level(text: &str) -> Result<Fidelity, String> {
    let found = Fidelity::ALL.into_iter().find(|f| f.name() == text);
    found.ok_or_else(|| {
        let names: Vec<&str> = Fidelity::ALL.iter().map(|f| f.name()).collect();
        format!("there are {}", names.join(", "))
    })
}

/// A part of 1, from percent.
fn parse_error(text: &str) -> Result<f64, String> {
    let number = text.strip_suffix('%').unwrap_or(text).trim().parse().ok();
    number
        .filter(|n: &f64| (0.01..=100.0).contains(n))
        .map(|n| n / 100.0)
        .ok_or_else(|| "write 0.01% to 100%".to_owned())
}

/// Forms of a table.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TableForm {
    /// For people
    Text,
    /// For programs
    Json,
    /// For documents
    Markdown,
}

/// `srp fidelity`
#[derive(Args)]
#[command(after_help = "\
What has been simulated is kept in the cache, so that a run that was interrupted goes on where it was.

Examples:
  srp fidelity --size 320x240
  srp fidelity sibenik.obj --cameras cameras.json:sibenik/0 --size 1024x768 --error 3% --trials 200
  srp fidelity bunny.obj --error 2% --json")]
pub(crate) struct FidelityTable {
    #[command(flatten)]
    pub(crate) frame: Frame,
    /// Folder with the kernels in C, instead of those that come along
    #[arg(long, value_name = "DIR")]
    pub(crate) kernels: Option<PathBuf>,
    /// Width and height of the image in pixels
    #[arg(long, value_name = "WxH", default_value = "320x240", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// What simulates the SRP; without rustc, csim gives way to interp
    #[arg(long, value_name = "ENGINE", default_value = "auto", value_parser = one_of(ENGINES))]
    pub(crate) engine: Engine,
    /// How the bounding volume hierarchy is built
    #[arg(long, value_name = "BUILDER", default_value = "best", value_parser = one_of(BUILDERS))]
    pub(crate) bvh: Builder,
    /// Half the width that drawing may leave to the intervals of cycles; what samples may be off by besides is added
    #[arg(long, value_name = "PERCENT", default_value = "1%", value_parser = parse_error)]
    pub(crate) error: f64,
    /// Seed of the sample of the table, and of the first trial
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Samples of as many seeds: how often the intervals hold
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u64).range(0..=100_000))]
    pub(crate) trials: u64,
    /// Threads of the host for samples, as many as it has processors by default; they change no figure
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<usize>,
    /// Form of the table
    #[arg(id = "table_form", long = "form", value_enum, default_value_t = TableForm::Text)]
    pub(crate) form: TableForm,
    /// Print JSON instead of text, as --form json does
    #[arg(long, conflicts_with = "table_form")]
    pub(crate) json: bool,
}
