//! `srp man`: manual pages, from what `--help` says.

use crate::cli::Cli;
use crate::failure::Failure;
use crate::talk;
use clap::{Command, CommandFactory};
use srp_toolchain::files::{self, FileError};
use std::path::Path;

/// Writes a page for the command and one for each command within it into a folder.
pub(crate) fn run(folder: &Path) -> Result<(), Failure> {
    files::make_folder(folder)?;
    let mut command = Cli::command();
    command.build();
    let count = write(&command, "srp", folder)?;
    talk::say(format_args!("wrote {count} pages to {}", folder.display()));
    Ok(())
}

/// Writes the page of a command, whose whole name has hyphens between its words, and those of commands within it; how
/// many.
fn write(command: &Command, name: &str, folder: &Path) -> Result<usize, Failure> {
    let path = folder.join(format!("{name}.1"));
    let mut page = Vec::new();
    clap_mangen::Man::new(command.clone())
        .render(&mut page)
        .map_err(|error| FileError::writing(&path, error))?;
    files::write(&path, &page)?;
    let within = command.get_subcommands();
    let within = within.filter(|command| command.get_name() != "help");
    let counts = within.map(|inner| write(inner, &format!("{name}-{}", inner.get_name()), folder));
    Ok(1 + counts.sum::<Result<usize, _>>()?)
}
