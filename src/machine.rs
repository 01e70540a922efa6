//! `srp machine`, and machine files for every other command.

use crate::cli::MachineAction;
use crate::cli::map::{Mesh, parse_class};
use crate::failure::Failure;
use crate::files::FileError;
use crate::{files, talk};
use srp_archdesc::arch::Arch;
use srp_archdesc::isa::Class;
use srp_archdesc::xml::StandardArray;
use srp_archdesc::{diagnostic, machines, xml};
use std::path::Path;

/// Reads a machine file, or finds a machine that comes along by its name.
pub(crate) fn read(path: &Path) -> Result<Arch, Failure> {
    let name = path.display().to_string();
    let text = match machines::ALL.iter().find(|m| m.name == name) {
        Some(machine) => machine.xml.to_owned(),
        None => files::read_text(path).map_err(|error| unknown(path, error))?,
    };
    parse(&name, &text)
}

/// Why a machine file cannot be read; what might be a name may be meant as one.
fn unknown(path: &Path, error: FileError) -> Failure {
    if path.exists() || path.extension().is_some() {
        return error.into();
    }
    let names: Vec<&str> = machines::ALL.iter().map(|m| m.name).collect();
    Failure::Message(format!(
        "{error}, and no machine of this name comes along: there are {}",
        names.join(", ")
    ))
}

/// Refuses a machine whose parts do not fit each other for a simulation.
pub(crate) fn check_system(name: &str, arch: &Arch) -> Result<(), Failure> {
    srp_runtime::system::check(&arch.system)
        .map_err(|why| Failure::Message(format!("{name}: this machine cannot be simulated: {why}")))
}

fn parse(name: &str, text: &str) -> Result<Arch, Failure> {
    xml::parse(name, text).map_err(|errors| {
        let rendered = diagnostic::render_all(&errors, text, talk::colour());
        Failure::Reported(rendered)
    })
}

/// Runs `srp machine`.
pub(crate) fn run(action: &MachineAction) -> Result<(), Failure> {
    match action {
        MachineAction::Check { file } => {
            let arch = read(file)?;
            check_system(&file.display().to_string(), &arch)?;
            talk::say(format_args!(
                "{}: machine `{}` is well-formed",
                file.display(),
                arch.name
            ));
        }
        MachineAction::Show { file } => talk::print(srp_archdesc::show(&read(file)?))?,
        MachineAction::Expand { file } => talk::print(xml::write(&read(file)?))?,
        MachineAction::Source { name } => {
            let machine = machines::ALL.iter().find(|m| m.name == name);
            talk::print(machine.map_or("", |m| m.xml))?;
        }
        MachineAction::Mesh(args) => files::write(&args.output, mesh(args)?.as_bytes())?,
    }
    Ok(())
}

/// The file of a standard array.
fn mesh(args: &Mesh) -> Result<String, Failure> {
    let classes = match args.ops.as_str() {
        "all" => xml::scalar_classes(),
        list => {
            let classes: Result<Vec<Class>, String> = list.split(',').map(parse_class).collect();
            let mut classes = classes.map_err(Failure::Message)?;
            classes.sort();
            classes.dedup();
            classes
        }
    };
    let array = StandardArray {
        topology: args.topology.into(),
        registers: args.registers,
        memory_columns: args.memory_columns,
        classes,
        latency: args.latency,
        contexts: args.contexts,
        ..StandardArray::mesh(args.rows, args.cols)
    };
    xml::standard(&array).map_err(Failure::Message)
}

/// The mesh of `--mesh ROWSxCOLS`.
pub(crate) fn standard_mesh(rows: u32, cols: u32) -> Result<Arch, Failure> {
    let text = xml::standard(&StandardArray::mesh(rows, cols)).map_err(Failure::Message)?;
    parse("--mesh", &text)
}
