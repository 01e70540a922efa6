//! Files that a command writes; `-` is standard output.

use crate::failure::Failure;
use crate::talk;
use srp_toolchain::files;
use std::path::Path;

pub(crate) use srp_toolchain::files::{make_folder, read_source, read_text};

/// True if a path stands for standard output.
fn is_output(path: &Path) -> bool {
    path == Path::new("-")
}

/// Writes a file as a whole or not at all.
pub(crate) fn write(path: &Path, contents: &[u8]) -> Result<(), Failure> {
    match is_output(path) {
        true => Ok(talk::print(contents)?),
        false => Ok(files::write(path, contents)?),
    }
}

/// Fails now if [`write()`] to this path would fail later, before any long work is done.
pub(crate) fn check_writable(path: &Path) -> Result<(), Failure> {
    match is_output(path) {
        true => Ok(()),
        false => Ok(files::check_writable(path)?),
    }
}
