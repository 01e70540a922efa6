//! Files: the only place that reads and writes them.

use srp_archdesc::diagnostic::Source;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// What went wrong with a file, and what to do.
#[derive(Debug)]
pub(crate) struct FileError {
    path: PathBuf,
    doing: &'static str,
    source: io::Error,
}

impl std::fmt::Display for FileError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let FileError {
            path,
            doing,
            source,
        } = self;
        let why = match source.kind() {
            io::ErrorKind::NotFound => "there is no such file or folder".to_owned(),
            io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
            io::ErrorKind::InvalidData => "it is not UTF-8 text".to_owned(),
            _ => source.to_string(),
        };
        write!(f, "cannot {doing} {}: {why}", path.display())
    }
}

impl std::error::Error for FileError {}

/// Reads a text file.
pub(crate) fn read_text(path: &Path) -> Result<String, FileError> {
    let error = |source| FileError {
        path: path.to_owned(),
        doing: "read",
        source,
    };
    std::fs::read_to_string(path).map_err(error)
}

/// Reads a text file as a source with its name.
pub(crate) fn read_source(path: &Path) -> Result<Source, FileError> {
    Ok(Source::new(path.display().to_string(), read_text(path)?))
}

/// Writes a file as a whole or not at all: into a temporary file beside it, which then takes its
/// name. `-` is standard output.
pub(crate) fn write(path: &Path, contents: &[u8]) -> Result<(), FileError> {
    let error = |source| FileError {
        path: path.to_owned(),
        doing: "write",
        source,
    };
    if path == Path::new("-") {
        let mut out = io::stdout().lock();
        return out
            .write_all(contents)
            .and_then(|()| out.flush())
            .map_err(error);
    }
    let name = path
        .file_name()
        .ok_or_else(|| error(io::ErrorKind::IsADirectory.into()))?;
    let mut temporary = std::ffi::OsString::from(".");
    temporary.push(name);
    temporary.push(format!(".{}.part", std::process::id()));
    let temporary = path.with_file_name(temporary);
    let written =
        std::fs::write(&temporary, contents).and_then(|()| std::fs::rename(&temporary, path));
    written.map_err(|e| {
        let _ = std::fs::remove_file(&temporary);
        error(e)
    })
}

/// Fails now if [`write()`] to this path would fail later, before any long work is done.
pub(crate) fn check_writable(path: &Path) -> Result<(), FileError> {
    let error = |source| FileError {
        path: path.to_owned(),
        doing: "write",
        source,
    };
    if path == Path::new("-") {
        return Ok(());
    }
    if path.is_dir() {
        return Err(error(io::ErrorKind::IsADirectory.into()));
    }
    let name = path
        .file_name()
        .ok_or_else(|| error(io::ErrorKind::IsADirectory.into()))?;
    let mut probe = std::ffi::OsString::from(".");
    probe.push(name);
    probe.push(format!(".{}.probe", std::process::id()));
    let probe = path.with_file_name(probe);
    std::fs::write(&probe, [])
        .and_then(|()| std::fs::remove_file(&probe))
        .map_err(error)
}

/// Makes a folder and those above it.
pub(crate) fn make_folder(path: &Path) -> Result<(), FileError> {
    let error = |source| FileError {
        path: path.to_owned(),
        doing: "make the folder",
        source,
    };
    std::fs::create_dir_all(path).map_err(error)
}

/// Where compiled simulators are kept: `SRP_CACHE`, else a folder in the user's cache.
pub(crate) fn cache_folder() -> PathBuf {
    let variable = |name| {
        std::env::var_os(name)
            .filter(|v| !v.is_empty())
            .map(PathBuf::from)
    };
    variable("SRP_CACHE")
        .or_else(|| variable("XDG_CACHE_HOME").map(|p| p.join("srp")))
        .or_else(|| variable("HOME").map(|p| p.join(".cache").join("srp")))
        .unwrap_or_else(|| std::env::temp_dir().join("srp-cache"))
}
