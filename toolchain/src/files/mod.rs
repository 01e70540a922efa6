//! Files: the one reader of files that a user names, and the one writer.
//!
//! * A file that is read is a regular one, or one that the shell hands over open, no larger than its [`Kind`] may
//!   be: a device or a pipe that never ends is no input. Nothing of a file of another kind is shown.
//! * A file that another file names should be in its folder: [`Outside`] says what is done about one that is not.
//! * A process whose inputs are a stranger's is [confined](confine) to some folders, and to so many bytes.
//! * A file is written as a whole or not at all, never where this process has read, and never twice by two
//!   outputs of one command.

mod confines;
mod kind;
mod ledger;
mod read;
mod room;
mod write;

pub use confines::{Confines, confine};
pub use kind::Kind;
pub use read::{check_input, read_bytes, read_mentioned, read_source, read_text, stand_in};
pub(crate) use read::{is_c, load};
pub use room::Outside;
pub(crate) use room::Room;
pub use write::{check_writable, file_name, remove_parts, write, writing};

use std::io;
use std::path::{Path, PathBuf};

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

    /// The file could not be read.
    pub fn reading(path: &Path, source: io::Error) -> FileError {
        FileError::new(path, "read", source)
    }

    /// The file could not be written.
    pub fn writing(path: &Path, source: io::Error) -> FileError {
        FileError::new(path, "write", source)
    }
}

/// Makes a folder and those above it.
///
/// # Errors
///
/// The folder cannot be made.
pub fn make_folder(path: &Path) -> Result<(), FileError> {
    let made = confines::may_write(path).and_then(|()| std::fs::create_dir_all(path));
    made.map_err(|e| FileError::new(path, "make the folder", e))
}
