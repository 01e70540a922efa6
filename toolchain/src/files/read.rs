//! The one reader of files that a user, or a file of a user, names.

use super::{FileError, Kind, confines, ledger};
use srp_archdesc::diagnostic::Source;
use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::Path;

/// The path of standard input, which the command line calls `-`; any other path as it is.
pub fn stand_in(path: &Path) -> &Path {
    match path == Path::new("-") {
        true => Path::new(STANDARD_INPUT),
        false => path,
    }
}

const STANDARD_INPUT: &str = "/dev/stdin";

/// Reads a file that a user names; `-` is standard input.
///
/// # Errors
///
/// It cannot be read, is no regular file, is larger than its kind may be, or is of another kind.
pub fn read_bytes(path: &Path, kind: Kind) -> Result<Vec<u8>, FileError> {
    load(stand_in(path), kind).map_err(|source| FileError::reading(path, source))
}

/// Fails now if the file would not be read later because it is an output of this command.
///
/// # Errors
///
/// It is an output.
pub fn check_input(path: &Path) -> Result<(), FileError> {
    ledger::no_output(path).map_err(|source| FileError::reading(path, source))
}

/// As [`read_bytes`], for those who word their errors themselves.
pub(crate) fn load(path: &Path, kind: Kind) -> io::Result<Vec<u8>> {
    let bytes = bytes(path, kind, is_handed_over(path))?;
    ledger::name(path);
    Ok(bytes)
}

/// Reads a text file that a user names.
///
/// # Errors
///
/// Those of [`read_bytes`]; or the file is not UTF-8 text.
pub fn read_text(path: &Path, kind: Kind) -> Result<String, FileError> {
    let bytes = read_bytes(path, kind)?;
    String::from_utf8(bytes).map_err(|e| {
        let good = &e.as_bytes()[..e.utf8_error().valid_up_to()];
        let line = 1 + good.iter().filter(|&&b| b == b'\n').count();
        let start = good.iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
        let column = 1 + String::from_utf8_lossy(&good[start..]).chars().count();
        let byte = e.as_bytes()[good.len()];
        let why = format!("byte {byte:#04x} at {line}:{column} is not UTF-8 text");
        FileError::reading(path, io::Error::new(io::ErrorKind::InvalidData, why))
    })
}

/// Reads a text that a user names as a source with its name. It may be in any encoding that has ASCII in it.
///
/// # Errors
///
/// Those of [`read_bytes`].
pub fn read_source(path: &Path, kind: Kind) -> Result<Source, FileError> {
    let text = srp_frontend::bytes::decode(read_bytes(path, kind)?);
    Ok(Source::new(path.display().to_string(), text))
}

/// The text of a source that positions name, if it is one. Anything can be named by a `#line` or in a program that
/// somebody else compiled, so this is a file that the user names too, or C by its name and in the folder of one that
/// was read.
pub fn read_mentioned(path: &Path) -> Option<String> {
    let is_source = ledger::is_named(path) || (is_c(path) && ledger::has_read_beside(path));
    let bytes = is_source.then(|| bytes(path, Kind::Source, false).ok())??;
    Some(srp_frontend::bytes::decode(bytes))
}

/// Endings of the names of files that C includes.
const C: [&str; 12] = [
    "c", "h", "cc", "hh", "cpp", "hpp", "cl", "inc", "inl", "def", "tbl", "glsl",
];

/// True if a file is C by its name.
pub(crate) fn is_c(path: &Path) -> bool {
    let ending = path.extension().and_then(|e| e.to_str());
    ending.is_some_and(|e| C.contains(&e))
}

/// The bytes of a file; of something other than a file only where it is handed over.
pub(super) fn bytes(path: &Path, kind: Kind, handed_over: bool) -> io::Result<Vec<u8>> {
    if !handed_over {
        confines::may_read(path)?;
    }
    let file = open(path, handed_over)?;
    let length = file.metadata()?.len();
    let limit = kind.limit();
    let too_large = || {
        let (what, most) = (kind.what(), limit >> 20);
        let why = format!("it is larger than {most} MiB, the most that is read of a {what}");
        io::Error::new(io::ErrorKind::FileTooLarge, why)
    };
    if length > limit {
        return Err(too_large());
    }
    confines::reads(length)?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length as usize)?;
    // Its length is what was told when it was opened, or nothing of a file that is made as it is read.
    file.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(too_large());
    }
    if handed_over {
        confines::reads((bytes.len() as u64).saturating_sub(length))?;
    }
    if let Some(why) = kind.refusal(&bytes) {
        return Err(io::Error::new(io::ErrorKind::InvalidData, why));
    }
    ledger::read(path)?;
    Ok(bytes)
}

/// Opens a file, and does not wait for one that nobody writes.
fn open(path: &Path, handed_over: bool) -> io::Result<File> {
    if handed_over {
        let file = File::open(path)?;
        return match file.metadata()?.is_dir() {
            true => Err(io::ErrorKind::IsADirectory.into()),
            false => Ok(file),
        };
    }
    // Devices do something when they are opened.
    regular(&std::fs::metadata(path)?)?;
    let mut options = File::options();
    options.read(true);
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        use std::os::unix::fs::OpenOptionsExt;
        options.custom_flags((OFlags::NONBLOCK | OFlags::NOCTTY).bits() as i32);
    }
    let file = options.open(path)?;
    // Another may have taken its place.
    regular(&file.metadata()?)?;
    Ok(file)
}

fn regular(found: &Metadata) -> io::Result<()> {
    if found.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    match found.is_file() {
        true => Ok(()),
        false => {
            let why = "it is no regular file, but a device, a pipe or a socket";
            Err(io::Error::new(io::ErrorKind::InvalidInput, why))
        }
    }
}

/// True if a path stands for a file that a shell has opened, such as standard input.
fn is_handed_over(path: &Path) -> bool {
    let number = ["/dev/fd", "/proc/self/fd"]
        .iter()
        .find_map(|folder| path.strip_prefix(folder).ok()?.to_str());
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    path == Path::new(STANDARD_INPUT) || number.is_some_and(is_number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_open_files_are_handed_over() {
        for path in ["/dev/stdin", "/dev/fd/0", "/proc/self/fd/63"] {
            assert!(is_handed_over(Path::new(path)), "{path}");
        }
        for path in [
            "/dev/fd/../zero",
            "/dev/fd",
            "/dev/zero",
            "/dev/fd/1/x",
            "dev/fd/1",
        ] {
            assert!(!is_handed_over(Path::new(path)), "{path}");
        }
    }
}
