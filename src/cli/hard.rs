//! The command line of `srp hard-cases`.

use super::{MachineFile, Sharing, parse_threads};
use clap::Args;
use std::path::PathBuf;

/// `srp hard-cases`
#[derive(Args)]
#[command(after_help = "\
A case is tried on the host, on the simulated SRP and in the T&I unit, wherever it says, and with each
setting of the machine's precision. Status 1 where one is wrong that is not listed as failing by
design, or that leaves the bound it is listed with.

Examples:
  srp hard-cases
  srp hard-cases --machine my-machine.xml --html cases.html
  srp hard-cases church.obj --filter L
  srp hard-cases --filter T1 --json
  srp hard-cases --cases my.cases              cases of your own; docs/hard-cases.md has the form
  srp hard-cases --kernels mine                kernels of your own; srp new kernels mine makes them
  srp hard-cases --filter T --list
  srp hard-cases --export cases.c              the cases for another ray tracer")]
pub(crate) struct HardCases {
    /// Scene whose own edges and surfaces are tried, instead of the default scene's
    pub(crate) scene: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineFile,
    /// Cases of this file, or of all .cases files of this folder, instead of the catalogue's
    #[arg(long, value_name = "FILE|DIR")]
    pub(crate) cases: Vec<PathBuf>,
    /// Folder with the kernels in C, instead of those that come along
    #[arg(long, value_name = "DIR", conflicts_with_all = ["list", "export"])]
    pub(crate) kernels: Option<PathBuf>,
    /// Only cases whose identifier begins so
    #[arg(long, value_name = "ID")]
    pub(crate) filter: Option<String>,
    /// Print the cases, and try none
    #[arg(long, conflicts_with_all = ["html", "export"])]
    pub(crate) list: bool,
    /// Write the cases, and try none: as C, as JSON, or in the form that --cases reads
    #[arg(long, value_name = "FILE.c|json|cases", conflicts_with_all = ["html", "json"])]
    pub(crate) export: Option<PathBuf>,
    /// Write the matrix as a page too
    #[arg(long, value_name = "FILE.html")]
    pub(crate) html: Option<PathBuf>,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
    /// Settings at a time, as many as the host has processors by default; they change no verdict
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<usize>,
    #[command(flatten)]
    pub(crate) sharing: Sharing,
}
