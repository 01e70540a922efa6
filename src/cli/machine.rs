//! The command lines of what machine files are for by themselves: `srp machine`, `srp area`, `srp units`.

use super::{Changes, map};
use clap::{Args, Subcommand};
use srp_archdesc::arch::Arch;
use srp_toolchain::Error;
use std::path::PathBuf;

/// The machine that a command describes.
#[derive(Args)]
pub(crate) struct Described {
    /// Machine file, or one of the machines that come along: sgrt, decoupled, fpga, tiny, wide
    #[arg(default_value = "sgrt")]
    file: PathBuf,
    /// The same, as other commands have it
    #[arg(long, value_name = "FILE.xml", conflicts_with = "file")]
    machine: Option<PathBuf>,
    #[command(flatten)]
    changes: Changes,
}

impl Described {
    /// The machine, with its changes.
    ///
    /// # Errors
    ///
    /// The file cannot be read, or what comes of the changes is no machine.
    pub(crate) fn read(&self) -> Result<Arch, Error> {
        let file = self.machine.as_ref().unwrap_or(&self.file);
        self.changes.of(file)
    }
}

/// `srp area`
#[derive(Args)]
#[command(after_help = "\
Examples:
  srp area
  srp area my-machine.xml --json
  srp area --set tni.trvs=8")]
pub(crate) struct Area {
    #[command(flatten)]
    pub(crate) machine: Described,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

/// `srp units`
#[derive(Args)]
#[command(after_help = "\
Examples:
  srp units
  srp units my-machine.xml --json")]
pub(crate) struct Units {
    #[command(flatten)]
    pub(crate) machine: Described,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

/// `srp machine`
#[derive(Args)]
#[command(after_help = "\
Examples:
  srp machine check my-machine.xml
  srp machine show wide
  srp machine source sgrt > my-machine.xml
  srp machine source sgrt --set array.rows=6 > six-rows.xml
  srp machine expand wide
  srp machine schema > machine.xsd
  srp machine mesh --rows 8 --cols 8 -o mesh.xml")]
pub(crate) struct Machine {
    /// What to do with it
    #[command(subcommand)]
    pub(crate) action: MachineAction,
}

/// What to do with a machine file.
#[derive(Subcommand)]
pub(crate) enum MachineAction {
    /// Say everything that is wrong with it.
    Check {
        /// The file, or one of the machines that come along: sgrt, decoupled, fpga, tiny, wide
        #[arg(default_value = "sgrt")]
        file: PathBuf,
        #[command(flatten)]
        changes: Changes,
    },
    /// Show the array, the units and the peak rate.
    Show {
        /// The file, or one of the machines that come along: sgrt, decoupled, fpga, tiny, wide
        #[arg(default_value = "sgrt")]
        file: PathBuf,
        #[command(flatten)]
        changes: Changes,
    },
    /// Write it with every unit, link, file and default spelled out.
    Expand {
        /// The file, or one of the machines that come along: sgrt, decoupled, fpga, tiny, wide
        #[arg(default_value = "sgrt")]
        file: PathBuf,
        #[command(flatten)]
        changes: Changes,
    },
    /// Write a machine that comes along as it stands, with comments on what is known of it: a copy to edit.
    Source {
        /// Which
        #[arg(default_value = "sgrt", value_parser = ["sgrt", "decoupled", "fpga", "tiny", "wide"])]
        name: String,
        #[command(flatten)]
        changes: Changes,
    },
    /// Print the XML Schema of machine files, for editors.
    Schema,
    /// Write the machine file of a standard array: a mesh of equal units, or the like.
    Mesh(map::Mesh),
}
