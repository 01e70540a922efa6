//! `srp paper`: the paper's tables.

use super::fidelity::Level;
use super::frame::{BUILDERS, Building, parse_effects, parse_size};
use super::tni::{Measuring, ORDERS, parse_sample};
use super::{ENGINES, MachineFile, Sharing, one_of};
use clap::{Args, ValueEnum};
use srp_runtime::bvh::Builder;
use srp_studies::rays::Order;
use srp_toolchain::Engine;
use std::path::PathBuf;

/// Tables of the paper.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Table {
    /// Ray generation and shading by themselves, fed by recorded hits
    Table3,
    /// One unit, traversal with a single and with parallel pipelines
    Table4,
    /// Four units: utilisation, steps, hit rates, bandwidth
    Table5,
    /// Frames per second of the whole system
    Table6,
}

impl Table {
    /// Its name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Table::Table3 => "table3",
            Table::Table4 => "table4",
            Table::Table5 => "table5",
            Table::Table6 => "table6",
        }
    }
}

/// `srp paper`
#[derive(Args)]
#[command(mut_arg("fidelity", |arg| arg.default_value("sampled")))]
#[command(after_help = "\
Views come from a cameras.json beside the scene or one folder above that names it. The paper's figures
are those of the scene of the same name; for others only ours are printed.

Examples:
  srp paper table3 sibenik.obj --effects -texture
  srp paper table4 sibenik.obj
  srp paper table5 sibenik.obj --error 2%
  srp paper table4 sibenik.obj --fidelity cycle+dram --sample 1/64
  srp paper table6 lamborghini.obj --json
  srp paper table5 *.obj --share pieces --jobs-on slurm --jobs 32")]
pub(crate) struct Paper {
    /// Which table
    pub(crate) table: Table,
    /// Scenes to compare on
    pub(crate) scenes: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineFile,
    /// Width and height of the image in pixels [default: 1024x768; table6: 1920x1080]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    /// In tables 3 and 6 effects to add to those the scene calls for or to leave out: -texture,…
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, value_parser = parse_effects)]
    pub(crate) effects: Option<String>,
    #[command(flatten)]
    pub(crate) building: Building,
    /// What runs the kernels in tables 3 and 6
    #[arg(long, value_name = "ENGINE", default_value = "auto", value_parser = one_of(ENGINES))]
    pub(crate) engine: Engine,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// With another level than sampled: measure one run of packets of secondary rays in N, from cold caches
    /// [default: 1/64]
    #[arg(long, value_name = "1/N", value_parser = parse_sample)]
    pub(crate) sample: Option<u64>,
    /// The same of primary rays [default: 1/1]
    #[arg(long, value_name = "1/N", value_parser = parse_sample)]
    pub(crate) sample_primary: Option<u64>,
    #[command(flatten)]
    pub(crate) level: Level,
    /// How the bounding volume hierarchy is built; the paper's is by sweep
    #[arg(long, value_name = "BUILDER", default_value = "sweep", value_parser = one_of(BUILDERS))]
    pub(crate) bvh: Builder,
    /// Order of the rays
    #[arg(long, value_name = "ORDER", default_value = "morton", value_parser = one_of(ORDERS))]
    pub(crate) order: Order,
    #[command(flatten)]
    pub(crate) measuring: Measuring,
    #[command(flatten)]
    pub(crate) sharing: Sharing,
}

impl Paper {
    /// One run of packets in so many is measured of secondary rays, and of primary ones.
    pub(crate) fn one_in(&self) -> (u64, u64) {
        match self.level.fidelity {
            srp_studies::fidelity::Fidelity::Sampled => (1, 1),
            _ => (self.sample.unwrap_or(64), self.sample_primary.unwrap_or(1)),
        }
    }

    /// Width and height of the image in pixels: the paper's, unless others are asked for.
    pub(crate) fn size(&self) -> (u32, u32) {
        self.size.unwrap_or(match self.table {
            Table::Table6 => (1920, 1080),
            _ => (1024, 768),
        })
    }
}
