//! The ledger of the process: which files it has read, and which it writes.
//!
//! A process is one command. What it reads is not what it writes, however the two are named.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Inputs and outputs, each under its one path.
struct Ledger {
    inputs: BTreeSet<PathBuf>,
    /// The inputs that the user names, rather than another file.
    named: BTreeSet<PathBuf>,
    outputs: BTreeSet<PathBuf>,
}

static LEDGER: Mutex<Ledger> = Mutex::new(Ledger {
    inputs: BTreeSet::new(),
    named: BTreeSet::new(),
    outputs: BTreeSet::new(),
});

fn ledger() -> MutexGuard<'static, Ledger> {
    LEDGER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Notes that a file was read.
///
/// # Errors
///
/// It is an output.
pub(super) fn read(path: &Path) -> io::Result<()> {
    no_output(path)?;
    ledger().inputs.insert(identity(path));
    Ok(())
}

/// Refuses to read a file that will be written.
///
/// # Errors
///
/// It is an output.
pub(super) fn no_output(path: &Path) -> io::Result<()> {
    match has(&ledger().outputs, &identity(path)) {
        true => Err(io::Error::other("it is an output of this command")),
        false => Ok(()),
    }
}

/// Notes that the user names a file, which is read.
pub(super) fn name(path: &Path) {
    ledger().named.insert(identity(path));
}

/// True if the user names a file.
pub(super) fn is_named(path: &Path) -> bool {
    ledger().named.contains(&identity(path))
}

/// True if a file was read that is in the same folder, or in one above it.
pub(super) fn has_read_beside(path: &Path) -> bool {
    let path = identity(path);
    let ledger = ledger();
    let mut folders = ledger.inputs.iter().filter_map(|input| input.parent());
    folders.any(|folder| path.starts_with(folder))
}

/// Notes that a file will be written.
///
/// # Errors
///
/// It is an input, or an output already.
pub(super) fn declare(path: &Path) -> io::Result<()> {
    let path = identity(path);
    let mut ledger = ledger();
    no_input(&ledger, &path)?;
    match has(&ledger.outputs, &path) {
        true => Err(io::Error::other(
            "it is another output of this command already",
        )),
        false => {
            ledger.outputs.insert(path);
            Ok(())
        }
    }
}

/// Refuses to write a file that was read.
///
/// # Errors
///
/// It is an input.
pub(super) fn check(path: &Path) -> io::Result<()> {
    no_input(&ledger(), &identity(path))
}

fn no_input(ledger: &Ledger, path: &Path) -> io::Result<()> {
    match has(&ledger.inputs, path) {
        true => Err(io::Error::other("it is an input of this command")),
        false => Ok(()),
    }
}

/// True if one of these files is the file at `path`, which may have other names.
fn has(files: &BTreeSet<PathBuf>, path: &Path) -> bool {
    files.contains(path) || number(path).is_some_and(|n| files.iter().any(|f| number(f) == Some(n)))
}

/// The number of a file that is there: one for all its names, and for no other file while it is there.
#[cfg(unix)]
fn number(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    let found = std::fs::metadata(path).ok()?;
    Some((found.dev(), found.ino()))
}

#[cfg(not(unix))]
fn number(_: &Path) -> Option<(u64, u64)> {
    None
}

/// One path for all that lead to a file, which need not be there yet.
fn identity(path: &Path) -> PathBuf {
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty());
    let folder = std::fs::canonicalize(parent.unwrap_or(Path::new(".")));
    let inside = || Some(folder.ok()?.join(path.file_name()?));
    let there = std::fs::canonicalize(path).ok();
    there.or_else(inside).unwrap_or_else(|| path.to_owned())
}
