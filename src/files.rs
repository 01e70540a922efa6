//! Files that a command writes; `-` is standard output.

use crate::failure::Failure;
use crate::talk;
use srp_toolchain::files;
use std::path::Path;

pub(crate) use srp_toolchain::files::{Kind, check_input, read_source, read_text};

/// True if a path stands for standard output.
pub(crate) fn is_output(path: &Path) -> bool {
    path == Path::new("-")
}

/// Makes a folder for several files, which standard output cannot be.
pub(crate) fn make_folder(path: &Path) -> Result<(), Failure> {
    match is_output(path) {
        true => Err(Failure::usage(
            "- is standard output, and several files are written: name a folder",
        )),
        false => Ok(files::make_folder(path)?),
    }
}

/// Writes a file as a whole or not at all.
pub(crate) fn write(path: &Path, contents: &[u8]) -> Result<(), Failure> {
    match is_output(path) {
        true => Ok(talk::print(contents)?),
        false => Ok(files::write(path, contents)?),
    }
}

/// Writes a file that is no other output of this command.
pub(crate) fn write_once(path: &Path, contents: &[u8]) -> Result<(), Failure> {
    check_writable(path)?;
    write(path, contents)
}

/// Fails now if [`write()`] to this path would fail later, before any long work is done. From now on the file is an
/// output of this command: it is not read, and no other output is written there.
pub(crate) fn check_writable(path: &Path) -> Result<(), Failure> {
    match is_output(path) {
        true => Ok(()),
        false => Ok(files::check_writable(path)?),
    }
}

/// The text of a source file that positions name, which may be one of those that come along; empty where it cannot
/// be read.
pub(crate) fn source_text(name: &str) -> String {
    let built_in = srp_kernels::SOURCES.iter().chain(srp_kernels::HEADERS);
    let built_in = built_in.chain(srp_kernels::MICRO);
    let mut own = built_in.chain(srp_kernels::libc::at(name));
    if let Some(file) = own.find(|file| file.path == name) {
        return file.text.to_owned();
    }
    files::read_mentioned(Path::new(name)).unwrap_or_default()
}
