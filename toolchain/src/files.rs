//! Files: the one reader of files that a user names, and the one writer.
//!
//! A file to be read is a regular one, or one that the shell hands over open, and no larger than its kind may
//! be: a device or a pipe that never ends is no input. Output is written as a whole or not at all, never over
//! a file that this process has read, and never twice under one name.

use srp_archdesc::diagnostic::Source;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::io::{self, Read};
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

/// Bytes of a text at most: sources, machines, graphs, schedules.
pub const MAX_TEXT: u64 = 256 << 20;

/// Bytes of a scene's file at most: geometry, materials, textures.
pub const MAX_SCENE: u64 = 4 << 30;

/// Reads a file of at most so many bytes.
///
/// # Errors
///
/// It cannot be read, is no regular file, or is larger.
pub fn read_bytes(path: &Path, limit: u64) -> Result<Vec<u8>, FileError> {
    read_limited(path, limit).map_err(|source| FileError::new(path, "read", source))
}

/// As [`read_bytes`], for those who word their errors themselves.
pub(crate) fn read_limited(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    // To open a pipe would be to wait for it.
    let found = std::fs::metadata(path)?;
    if found.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if !found.is_file() && !is_handed_over(path) {
        let why = "it is no regular file, but a device, a pipe or a socket";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    }
    let file = std::fs::File::open(path)?;
    let mut bytes = Vec::with_capacity(found.len().min(limit) as usize);
    file.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        let why = format!(
            "it is larger than {} MiB, the most that is read",
            limit >> 20
        );
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, why));
    }
    if let Ok(path) = std::fs::canonicalize(path) {
        if OUTPUTS
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .contains(&path)
        {
            return Err(io::Error::other("it is an output of this command"));
        }
        let mut inputs = INPUTS.lock().unwrap_or_else(PoisonError::into_inner);
        inputs.insert(path);
    }
    Ok(bytes)
}

/// True if a path stands for a file that a shell has opened, such as standard input.
fn is_handed_over(path: &Path) -> bool {
    let handed_over = ["/dev/stdin", "/dev/fd", "/proc/self/fd"];
    handed_over.iter().any(|start| path.starts_with(start))
}

/// Files that this process has read.
static INPUTS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Files that [`check_writable`] was asked for.
static OUTPUTS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Reads a text file.
///
/// # Errors
///
/// The file cannot be read, or is not UTF-8 text.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    let error = |source| FileError::new(path, "read", source);
    let bytes = read_limited(path, MAX_TEXT).map_err(error)?;
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

/// Reads a C file as a source with its name. It may be in any encoding that has ASCII in it.
///
/// # Errors
///
/// The file cannot be read.
pub fn read_source(path: &Path) -> Result<Source, FileError> {
    let bytes = read_limited(path, MAX_TEXT).map_err(|e| FileError::new(path, "read", e))?;
    let text = srp_frontend::bytes::decode(bytes);
    Ok(Source::new(path.display().to_string(), text))
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
            // Replaces the target of a link, not the link.
            Ok(_) => {
                let path = std::fs::canonicalize(path)?;
                let inputs = INPUTS.lock().unwrap_or_else(PoisonError::into_inner);
                match inputs.contains(&path) {
                    true => Err(io::Error::other("it is an input of this command")),
                    false => Ok(Target::File(path)),
                }
            }
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
    let once = |path: &Path| {
        let mut outputs = OUTPUTS.lock().unwrap_or_else(PoisonError::into_inner);
        match outputs.insert(identity(path)) {
            true => Ok(()),
            false => Err(io::Error::other(
                "it is another output of this command already",
            )),
        }
    };
    let checked = match Target::of(path) {
        Ok(Target::File(path)) => probe(&path).and_then(|()| once(&path)),
        Ok(Target::Device) => Ok(()),
        Err(e) => Err(e),
    };
    checked.map_err(|e| FileError::writing(path, e))
}

/// One path for all that lead to a file, which need not be there yet.
fn identity(path: &Path) -> PathBuf {
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty());
    let folder = std::fs::canonicalize(parent.unwrap_or(Path::new(".")));
    let inside = || Some(folder.ok()?.join(path.file_name()?));
    let there = std::fs::canonicalize(path).ok();
    there.or_else(inside).unwrap_or_else(|| path.to_owned())
}

/// Bytes of a [`file_name`] at most.
const LONGEST_NAME: usize = 80;

/// A name from a text that anybody may have written: one file in one folder, whatever the text has.
pub fn file_name(text: &str) -> String {
    let plain = |c: char| match c {
        'a'..='z' | 'A'..='Z' | '0'..='9' | '_' | '-' | '.' | '+' => c,
        _ => '_',
    };
    let name: String = text.chars().map(plain).take(LONGEST_NAME).collect();
    let is_whole = name == text && !name.starts_with('.') && !name.is_empty();
    match is_whole {
        true => name,
        // Two texts must not become one file.
        false => {
            let digest = blake3::hash(text.as_bytes()).to_hex();
            format!("_{}-{}", name.trim_start_matches('.'), &digest[..8])
        }
    }
}

/// Makes a folder and those above it.
///
/// # Errors
///
/// The folder cannot be made.
pub fn make_folder(path: &Path) -> Result<(), FileError> {
    std::fs::create_dir_all(path).map_err(|e| FileError::new(path, "make the folder", e))
}
