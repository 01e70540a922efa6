//! `srp machine`, and machine files for every other command.

use crate::cli::MachineAction;
use crate::failure::Failure;
use crate::{files, talk};
use srp_archdesc::arch::Arch;
use srp_archdesc::{diagnostic, machines, xml};
use std::path::Path;

/// Reads a machine file, or finds a machine that comes along by its name.
pub(crate) fn read(path: &Path) -> Result<Arch, Failure> {
    let name = path.display().to_string();
    let text = match machines::ALL.iter().find(|m| m.name == name) {
        Some(machine) => machine.xml.to_owned(),
        None => files::read_text(path)?,
    };
    xml::parse(&name, &text).map_err(|errors| {
        let rendered = diagnostic::render_all(&errors, &text, talk::colour());
        Failure::Reported(rendered)
    })
}

/// Runs `srp machine`.
pub(crate) fn run(action: &MachineAction) -> Result<(), Failure> {
    match action {
        MachineAction::Check { file } => {
            let arch = read(file)?;
            talk::say(format_args!(
                "{}: machine `{}` is well-formed",
                file.display(),
                arch.name
            ));
        }
        MachineAction::Show { file } => talk::print(srp_archdesc::show(&read(file)?))?,
        MachineAction::Expand { file } => talk::print(xml::write(&read(file)?))?,
    }
    Ok(())
}
