//! The confines of the process: the folders that it may read and write, and how much.
//!
//! A process is one command. Where its inputs are a stranger's, it is confined before it reads any.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The folders that a process may use, with all below them, and how much of files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Confines {
    /// Folders and files that are read; links are resolved.
    pub readable: Vec<PathBuf>,
    /// Folders and files that are written, and read too.
    pub writable: Vec<PathBuf>,
    /// The most files that are read.
    pub files: u64,
    /// The most bytes that are read in all.
    pub read: u64,
    /// The most bytes that are written in all.
    pub written: u64,
    /// Bytes of memory that the process may take: a file takes some of them.
    pub memory: u64,
}

/// A file and what is made of it take at least so many times its length.
const GROWTH: u64 = 4;

/// The confines, of which files take their part.
static CONFINES: Mutex<Option<Confines>> = Mutex::new(None);

fn confines() -> MutexGuard<'static, Option<Confines>> {
    CONFINES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Confines this process from now on.
pub fn confine(to: Confines) {
    *confines() = Some(to);
}

impl Confines {
    fn may_read(&self, place: &Path) -> bool {
        let mut all = self.readable.iter().chain(&self.writable);
        all.any(|folder| place.starts_with(folder))
    }

    fn may_write(&self, place: &Path) -> bool {
        self.writable.iter().any(|folder| place.starts_with(folder))
    }
}

/// Refuses a file outside of the confines, without a look at whether it is there.
pub(super) fn may_read(path: &Path) -> io::Result<()> {
    match &*confines() {
        Some(confines) if !confines.may_read(&place(path)) => Err(outside()),
        _ => Ok(()),
    }
}

/// Refuses to write outside of the confines.
pub(super) fn may_write(path: &Path) -> io::Result<()> {
    match &*confines() {
        Some(confines) if !confines.may_write(&place(path)) => Err(outside()),
        _ => Ok(()),
    }
}

/// Counts a file of this length that is about to be read.
pub(super) fn reads(length: u64) -> io::Result<()> {
    let mut confines = confines();
    let Some(confines) = &mut *confines else {
        return Ok(());
    };
    if length.saturating_mul(GROWTH) > confines.memory {
        let needs = (length.saturating_mul(GROWTH) >> 20) + 1;
        return Err(too_much(format_args!(
            "it takes {needs} MiB of memory or more: more than `memory` allows"
        )));
    }
    confines.files = match confines.files.checked_sub(1) {
        Some(left) => left,
        None => return Err(too_much("more files are read than `files` allows")),
    };
    confines.read = match confines.read.checked_sub(length) {
        Some(left) => left,
        None => {
            return Err(too_much(
                "the files that are read have more bytes than `read` allows",
            ));
        }
    };
    Ok(())
}

/// Counts bytes that are about to be written.
pub(super) fn writes(length: u64) -> io::Result<()> {
    let mut confines = confines();
    let Some(confines) = &mut *confines else {
        return Ok(());
    };
    confines.written = match confines.written.checked_sub(length) {
        Some(left) => left,
        None => {
            return Err(too_much(
                "the files that are written have more bytes than `written` allows",
            ));
        }
    };
    Ok(())
}

fn outside() -> io::Error {
    let why = "it is outside the folders of the files that the command names, and --untrusted uses no others";
    io::Error::new(io::ErrorKind::InvalidInput, why)
}

fn too_much(why: impl std::fmt::Display) -> io::Error {
    let why = format!("{why} (a limit of --untrusted)");
    io::Error::new(io::ErrorKind::QuotaExceeded, why)
}

/// The place that a path leads to: what is there with all links resolved, else the nearest folder that is.
fn place(path: &Path) -> PathBuf {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut ancestors = path.ancestors();
    let found = ancestors.find_map(|above| {
        let real = std::fs::canonicalize(above).ok()?;
        let rest = path.strip_prefix(above).ok()?;
        // What is not there has no links; what climbs from there is no place in the folder.
        let climbs = rest.components().any(|c| c.as_os_str() == "..");
        (!climbs).then(|| real.join(rest))
    });
    found.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_and_climbing_lead_out() {
        let folder = tempfile::tempdir().expect("it can be made");
        let real = std::fs::canonicalize(folder.path()).expect("it is there");
        let inside = real.join("inside");
        std::fs::create_dir(&inside).expect("it can be made");
        std::os::unix::fs::symlink("/etc/passwd", inside.join("link")).expect("it can be made");
        std::os::unix::fs::symlink("..", inside.join("up")).expect("it can be made");
        let confines = Confines {
            readable: vec![inside.clone()],
            writable: Vec::new(),
            files: 1,
            read: 1,
            written: 1,
            memory: 1,
        };
        let may = |name: &str| confines.may_read(&place(&inside.join(name)));
        assert!(may("new") && may("new/newer") && may("./x"));
        for name in [
            "../x",
            "link",
            "up/x",
            "new/../../x",
            "/etc/passwd",
            "up/inside/../x",
        ] {
            assert!(!may(name), "{name}");
        }
        assert!(!confines.may_write(&inside));
    }
}
