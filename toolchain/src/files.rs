//! Files: reading, and writing as a whole or not at all.

use srp_archdesc::diagnostic::Source;
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A failure to use a file, and advice.
#[derive(Debug)]
pub struct FileError {
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
            io::ErrorKind::IsADirectory => "it is a folder".to_owned(),
            _ => source.to_string(),
        };
        write!(f, "cannot {doing} {}: {why}", path.display())
    }
}

impl std::error::Error for FileError {}

impl FileError {
    fn new(path: &Path, doing: &'static str, source: io::Error) -> FileError {
        FileError {
            path: path.to_owned(),
            doing,
            source,
        }
    }

    /// The file could not be written.
    pub fn writing(path: &Path, source: io::Error) -> FileError {
        FileError::new(path, "write", source)
    }
}

/// Reads a text file.
///
/// # Errors
///
/// The file cannot be read, or is not UTF-8 text.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    let error = |source| FileError::new(path, "read", source);
    let bytes = std::fs::read(path).map_err(error)?;
    String::from_utf8(bytes).map_err(|e| {
        let good = &e.as_bytes()[..e.utf8_error().valid_up_to()];
        let line = 1 + good.iter().filter(|&&b| b == b'\n').count();
        let start = good.iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
        let column = 1 + String::from_utf8_lossy(&good[start..]).chars().count();
        let byte = e.as_bytes()[good.len()];
        let why = format!("byte {byte:#04x} at {line}:{column} is not UTF-8 text");
        error(io::Error::new(io::ErrorKind::InvalidData, why))
    })
}

/// Reads a text file as a source with its name.
///
/// # Errors
///
/// As of [`read_text`].
pub fn read_source(path: &Path) -> Result<Source, FileError> {
    Ok(Source::new(path.display().to_string(), read_text(path)?))
}

static WRITING: Mutex<()> = Mutex::new(());

/// While this is held, no file is being written.
pub fn writing() -> MutexGuard<'static, ()> {
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How a path is written.
enum Target {
    /// Something other than a file, such as a device: in place.
    Device,
    /// A file: under another name in the same folder, and renamed to this.
    File(PathBuf),
}

impl Target {
    fn of(path: &Path) -> io::Result<Target> {
        match std::fs::metadata(path) {
            Ok(found) if found.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
            Ok(found) if !found.is_file() => Ok(Target::Device),
            Ok(found) if found.permissions().readonly() => {
                Err(io::ErrorKind::PermissionDenied.into())
            }
            // What a link points to is replaced, not the link.
            Ok(_) => std::fs::canonicalize(path).map(Target::File),
            Err(_) => Ok(Target::File(path.to_owned())),
        }
    }
}

/// A hidden file of this process in the same folder.
fn beside(path: &Path) -> io::Result<PathBuf> {
    let mut name = OsString::from(".");
    name.push(path.file_name().ok_or(io::ErrorKind::IsADirectory)?);
    name.push(format!(".{}.part", std::process::id()));
    Ok(path.with_file_name(name))
}

/// Writes a file as a whole or not at all.
///
/// # Errors
///
/// The file cannot be written.
pub fn write(path: &Path, contents: &[u8]) -> Result<(), FileError> {
    let replace = |path: &Path| {
        let part = beside(path)?;
        let _writing = writing();
        let written = std::fs::write(&part, contents).and_then(|()| std::fs::rename(&part, path));
        if written.is_err() {
            let _ = std::fs::remove_file(&part);
        }
        written
    };
    let written = match Target::of(path) {
        Ok(Target::Device) => std::fs::write(path, contents),
        Ok(Target::File(path)) => replace(&path),
        Err(e) => Err(e),
    };
    written.map_err(|e| FileError::writing(path, e))
}

/// Fails now if [`write()`] to this path would fail later, before any long work is done.
///
/// # Errors
///
/// The file cannot be written.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    let probe = |path: &Path| {
        let part = beside(path)?;
        let _writing = writing();
        std::fs::write(&part, []).and_then(|()| std::fs::remove_file(&part))
    };
    let checked = match Target::of(path) {
        Ok(Target::File(path)) => probe(&path),
        Ok(Target::Device) => Ok(()),
        Err(e) => Err(e),
    };
    checked.map_err(|e| FileError::writing(path, e))
}

/// Makes a folder and those above it.
///
/// # Errors
///
/// The folder cannot be made.
pub fn make_folder(path: &Path) -> Result<(), FileError> {
    std::fs::create_dir_all(path).map_err(|e| FileError::new(path, "make the folder", e))
}

/// Where compiled simulators are kept: `SRP_CACHE`, else a folder in the user's cache.
pub fn cache_folder() -> PathBuf {
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
