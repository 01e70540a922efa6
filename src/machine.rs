//! `srp machine`.

use crate::cli::MachineAction;
use crate::cli::map::{Mesh, parse_class};
use crate::failure::Failure;
use crate::{files, talk};
use srp_archdesc::isa::Class;
use srp_archdesc::xml;
use srp_archdesc::xml::StandardArray;
use srp_toolchain::machine;
use std::path::Path;

/// Runs `srp machine`.
pub(crate) fn run(action: &MachineAction) -> Result<(), Failure> {
    match action {
        MachineAction::Check { file, changes } => {
            let arch = changes.of(file)?;
            machine::check_system(&file.display().to_string(), &arch)?;
            talk::say(format_args!(
                "{}: machine `{}` is well-formed",
                file.display(),
                arch.name
            ));
        }
        MachineAction::Show { file, changes } => {
            let arch = machine::changed(file, &changes.set)?;
            talk::print(srp_archdesc::show(&arch))?;
        }
        MachineAction::Expand { file, changes } => {
            let arch = machine::changed(file, &changes.set)?;
            talk::print(xml::write(&arch))?;
        }
        MachineAction::Source { name, changes } => {
            let text = machine::changed_text(Path::new(name), &changes.set)?;
            machine::parse(name, &text)?;
            talk::print(text)?;
        }
        MachineAction::Schema => talk::print(xml::schema())?,
        MachineAction::Mesh(args) => files::write_once(&args.output, mesh(args)?.as_bytes())?,
    }
    Ok(())
}

/// The file of a standard array.
fn mesh(args: &Mesh) -> Result<String, Failure> {
    let classes = match args.ops.as_str() {
        "all" => xml::scalar_classes(),
        list => {
            let classes: Result<Vec<Class>, String> = list.split(',').map(parse_class).collect();
            let mut classes = classes.map_err(Failure::Usage)?;
            classes.sort();
            classes.dedup();
            classes
        }
    };
    let array = StandardArray {
        topology: args.topology.into(),
        wires: args.wires.replace(',', " "),
        hops: args.hops,
        registers: args.registers,
        memory_columns: args.memory_columns,
        classes,
        latency: args.latency,
        contexts: args.contexts,
        ..StandardArray::mesh(args.rows, args.cols)
    };
    xml::standard(&array).map_err(Failure::Usage)
}

/// The file of the mesh of `--mesh ROWSxCOLS`.
pub(crate) fn standard_mesh(rows: u32, cols: u32) -> Result<String, Failure> {
    xml::standard(&StandardArray::mesh(rows, cols)).map_err(Failure::Usage)
}
