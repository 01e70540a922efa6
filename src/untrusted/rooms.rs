//! The folders that a command line names: what confined work may read and write.

use crate::cli::parse_cameras;
use crate::failure::Failure;
use clap::{Arg, ArgMatches, Command};
use srp_toolchain::files;
use std::any::TypeId;
use std::ffi::OsStr;
#[cfg(unix)]
use std::os::unix::fs::FileTypeExt;
use std::path::{Path, PathBuf};

/// Arguments that say what is written.
const OUTPUTS: &[&str] = &[
    "checkpoint",
    "export",
    "heat",
    "hits",
    "html",
    "loops",
    "output",
    "pages",
    "path",
    "profile",
    "proof",
    "registers",
    "report",
    "share",
    "trace_output",
];

/// Arguments that say what is read: paths, and words that have paths in them.
const INPUTS: &[&str] = &[
    "beside", "cameras", "cases", "diff", "file", "files", "folder", "frame", "graphs", "include",
    "kernels", "machine", "new", "old", "ops", "plan", "program", "ray_file", "restore", "scene",
    "scenes", "trace",
];

/// Folders, and files and devices where only these themselves may be used.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Rooms {
    /// What is read.
    pub(crate) read: Vec<PathBuf>,
    /// What is written, and read.
    pub(crate) write: Vec<PathBuf>,
    /// Folders of outputs that are not there yet.
    missing: Vec<PathBuf>,
}

/// The command that is given, the innermost one, and its arguments.
fn innermost<'a>(command: &'a Command, matches: &'a ArgMatches) -> (&'a Command, &'a ArgMatches) {
    let inner = matches.subcommand();
    let inner = inner.and_then(|(name, matches)| Some((command.find_subcommand(name)?, matches)));
    match inner {
        Some((command, matches)) => innermost(command, matches),
        None => (command, matches),
    }
}

/// The threads that a command line asks for.
pub(super) fn asked_threads(matches: &ArgMatches) -> Option<usize> {
    let mut matches = matches;
    while let Some((_, inner)) = matches.subcommand() {
        matches = inner;
    }
    matches.try_get_one::<usize>("threads").ok()?.copied()
}

/// True if an argument is a path, or a word that may have one in it.
fn is_path(argument: &Arg) -> bool {
    let parsed = argument.get_value_parser().type_id();
    parsed == TypeId::of::<PathBuf>() || parsed == TypeId::of::<String>()
}

impl Rooms {
    /// The rooms of a command line.
    pub(crate) fn of(command: &Command, matches: &ArgMatches) -> Rooms {
        let (command, matches) = innermost(command, matches);
        let mut rooms = Rooms::default();
        for argument in command.get_arguments().filter(|a| is_path(a)) {
            let id = argument.get_id().as_str();
            let Ok(Some(values)) = matches.try_get_raw(id) else {
                continue;
            };
            // Where the window of a trace goes is said whether there is one or not.
            let is_idle = (id == "trace_output" && !matches.contains_id("trace"))
                || (id == "checkpoint" && !matches.contains_id("checkpoint_at"));
            let paths = values.map(|value| path_in(id, value));
            match (OUTPUTS.contains(&id), INPUTS.contains(&id)) {
                (true, _) if is_idle => {}
                (true, _) if is_folder(argument) => paths.for_each(|path| rooms.write_folder(path)),
                (true, _) => paths.for_each(|path| rooms.write_file(path)),
                (_, true) => paths.for_each(|path| rooms.read(path)),
                _ => {}
            }
        }
        if command.get_name() == "accuracy" && !matches.contains_id("output") {
            rooms.write_folder(Path::new(crate::accuracy::FOLDER));
        }
        rooms
    }

    /// Makes the folders of outputs that are not there; the new ones.
    ///
    /// # Errors
    ///
    /// One cannot be made.
    pub(crate) fn make(&mut self) -> Result<Vec<PathBuf>, Failure> {
        for folder in &self.missing {
            files::make_folder(folder)?;
            self.write.extend(std::fs::canonicalize(folder));
        }
        Ok(std::mem::take(&mut self.missing))
    }

    /// A file that is read, whose folder has others that it names; or a folder.
    fn read(&mut self, path: &Path) {
        let path = files::stand_in(path);
        match std::fs::metadata(path) {
            Ok(found) if found.is_dir() => self.read.extend(std::fs::canonicalize(path)),
            Ok(found) if found.is_file() => self.read.extend(folder_of(path)),
            // A pipe that the shell hands over is open, and in no folder that could be closed.
            #[cfg(unix)]
            Ok(found) if found.file_type().is_fifo() => {}
            Ok(_) => self.read.push(path.to_owned()),
            // A file that is not there, or a machine that comes along.
            Err(_) => {}
        }
    }

    fn write_folder(&mut self, path: &Path) {
        if crate::files::is_output(path) {
            return;
        }
        match std::fs::canonicalize(path) {
            Ok(folder) => self.write.push(folder),
            Err(_) => self.missing.push(path.to_owned()),
        }
    }

    fn write_file(&mut self, path: &Path) {
        let found = std::fs::metadata(path).ok();
        match found.is_some_and(|found| !found.is_file() && !found.is_dir()) {
            true => self.write.push(path.to_owned()),
            false if crate::files::is_output(path) => {}
            false => self.write.extend(folder_of(path)),
        }
    }
}

/// The folder of a file. What the shell hands over has none.
fn folder_of(path: &Path) -> Option<PathBuf> {
    if ["/dev", "/proc"]
        .iter()
        .any(|folder| path.starts_with(folder))
    {
        return Some(path.to_owned());
    }
    let folder = path.parent()?;
    let folder = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    std::fs::canonicalize(folder).ok()
}

/// True if an argument names a folder.
fn is_folder(argument: &Arg) -> bool {
    let names = argument.get_value_names().unwrap_or_default();
    names.iter().any(|name| name == "DIR")
}

/// The path in the value of an argument.
fn path_in<'v>(id: &str, value: &'v OsStr) -> &'v Path {
    let text = value.to_str();
    let part = match id {
        "cameras" => text.and_then(|text| Some(parse_cameras(text)?.0)),
        // A scene of a sweep may have its view behind it.
        "scene" if !Path::new(value).exists() => {
            text.and_then(|text| Some(Path::new(text.split_once('@')?.0)))
        }
        _ => None,
    };
    part.unwrap_or(Path::new(value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    /// Calls for every argument of every command.
    fn each(command: &Command, then: &mut dyn FnMut(&str, &Arg)) {
        for argument in command.get_arguments() {
            then(command.get_name(), argument);
        }
        for inner in command.get_subcommands() {
            each(inner, then);
        }
    }

    /// An argument with a path of which nobody says whether it is read or written would be neither.
    #[test]
    fn every_path_is_read_or_written() {
        let mut count = 0;
        each(&crate::cli::Cli::command(), &mut |command, argument| {
            let id = argument.get_id().as_str();
            let is_known = INPUTS.contains(&id) || OUTPUTS.contains(&id);
            let is_path = argument.get_value_parser().type_id() == TypeId::of::<PathBuf>();
            let names = argument.get_value_names().unwrap_or_default();
            let says_path =
                |name: &str| name.starts_with("FILE") || name == "DIR" || name == "SCENE";
            let says_path = names.iter().any(|name| says_path(name));
            assert!(is_known || !(is_path || says_path), "srp {command}: {id}");
            count += usize::from(is_path);
        });
        assert!(count > 40, "{count} paths");
    }
}
