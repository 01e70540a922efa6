//! Machine files, and the machines that come along.

use crate::Error;
use crate::files::{self, FileError, Kind};
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::{Messages, Source};
use srp_archdesc::machines;
use srp_archdesc::xml::{self, Change, EditError};
use std::path::Path;

/// Reads a machine file, or finds a machine that comes along by its name.
///
/// # Errors
///
/// The file cannot be read, or is wrong.
pub fn read(path: &Path) -> Result<Arch, Error> {
    changed(path, &[])
}

/// Reads a machine with attributes changed, one after the other. Messages show the lines as they are then.
///
/// # Errors
///
/// The file cannot be read, an attribute cannot be set, or the result is wrong.
pub fn changed(path: &Path, changes: &[Change]) -> Result<Arch, Error> {
    parse(&name_of(path, changes), &changed_text(path, changes)?)
}

/// A machine's name in messages. A line that they show of a changed one is in no file.
fn name_of(path: &Path, changes: &[Change]) -> String {
    let name = path.display();
    match changes.is_empty() {
        true => name.to_string(),
        false => {
            let changes: Vec<String> = changes.iter().map(Change::to_string).collect();
            format!("{name} with {}", changes.join(" "))
        }
    }
}

/// Warnings of a machine with attributes changed, for the people who changed them; none of one that cannot be read.
pub fn warnings(path: &Path, changes: &[Change]) -> Messages {
    let text = changed_text(path, changes).unwrap_or_default();
    warnings_of(&name_of(path, changes), &text)
}

/// The same of a machine's text, which messages know by `name`.
pub fn warnings_of(name: &str, text: &str) -> Messages {
    Messages {
        diagnostics: xml::warnings(name, text),
        sources: vec![Source::new(name, text)],
    }
}

/// The text of a machine with attributes changed; it keeps its comments.
///
/// # Errors
///
/// The file cannot be read, or an attribute cannot be set.
pub fn changed_text(path: &Path, changes: &[Change]) -> Result<String, Error> {
    change(&path.display().to_string(), text(path)?, changes)
}

/// Changes attributes in the text of a machine, which messages know by `name`.
///
/// # Errors
///
/// An attribute cannot be set.
pub fn change(name: &str, text: String, changes: &[Change]) -> Result<String, Error> {
    changes.iter().try_fold(text, |text, change| {
        change.make(&text).map_err(|why| match why {
            // What is wrong with the file has a place in it.
            EditError::Xml => parse(name, &text)
                .err()
                .unwrap_or_else(|| Error::invalid(why)),
            _ => Error::Invalid(format!("{name}: {why}")),
        })
    })
}

/// The text of a machine file, or of a machine that comes along.
///
/// # Errors
///
/// The file cannot be read.
pub fn text(path: &Path) -> Result<String, Error> {
    let name = path.display().to_string();
    match machines::ALL.iter().find(|m| m.name == name) {
        Some(machine) => Ok(machine.xml.to_owned()),
        None => files::read_text(path, Kind::Machine).map_err(|error| unknown(path, error)),
    }
}

/// Why a machine file cannot be read. If the path could be the name of a machine, the message lists the names.
fn unknown(path: &Path, error: FileError) -> Error {
    if path.exists() || path.extension().is_some() {
        return error.into();
    }
    let names: Vec<&str> = machines::ALL.iter().map(|m| m.name).collect();
    Error::Invalid(format!(
        "{error}, and no machine of this name comes along: there are {}",
        names.join(", ")
    ))
}

/// The machine of a text, which messages know by `name`.
///
/// # Errors
///
/// All that is wrong with it.
pub fn parse(name: &str, text: &str) -> Result<Arch, Error> {
    xml::parse(name, text).map_err(|diagnostics| {
        Error::Messages(Messages {
            diagnostics,
            sources: vec![Source::new(name, text)],
        })
    })
}

/// Refuses a machine whose parts do not fit each other for a simulation.
///
/// # Errors
///
/// The part that does not fit, with the machine's name.
pub fn check_system(name: &str, arch: &Arch) -> Result<(), Error> {
    let checked = srp_runtime::system::check(&arch.system);
    checked
        .map_err(|why| Error::Invalid(format!("{name}: this machine cannot be simulated: {why}")))
}
