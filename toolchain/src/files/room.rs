//! Files that other files name: a scene its materials and pictures, a program its headers.

use super::{Kind, read};
use serde::Serialize;
use std::io;
use std::path::{Component, Path, PathBuf};

/// What is done about files outside the folder of the file that names them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Outside {
    /// They are read, and a note says so.
    #[default]
    Told,
    /// They are not read. So they are not looked for either: that would tell whether they are there.
    Refused,
}

/// A file that another names.
pub(crate) struct Named {
    /// Its bytes.
    pub(crate) bytes: Vec<u8>,
    /// True if it is outside the folders that it should be in.
    pub(crate) is_outside: bool,
}

/// The folders in which files should be that others name.
pub(crate) struct Room {
    folders: Vec<PathBuf>,
    outside: Outside,
}

impl Room {
    /// The room of these folders and those below them.
    pub(crate) fn of<'a>(folders: impl IntoIterator<Item = &'a Path>, outside: Outside) -> Room {
        let folder = |folder: &Path| {
            let folder = match folder.as_os_str().is_empty() {
                true => Path::new("."),
                false => folder,
            };
            std::fs::canonicalize(folder).ok()
        };
        Room {
            folders: folders.into_iter().filter_map(folder).collect(),
            outside,
        }
    }

    /// Reads a file that another names.
    pub(crate) fn read(&self, path: &Path, kind: Kind) -> io::Result<Named> {
        let refused = || {
            let why = "it is outside the folder of the file that names it";
            Err(io::Error::new(io::ErrorKind::InvalidInput, why))
        };
        let is_refused = self.outside == Outside::Refused;
        if is_refused && !self.leads_inside(path) {
            return refused();
        }
        let place = std::fs::canonicalize(path)?;
        let is_outside = !self.has(&place);
        if is_refused && is_outside {
            return refused();
        }
        // What no link leads out of, nothing does after this.
        let path = if is_refused { &place } else { path };
        let bytes = read::bytes(path, kind, false)?;
        Ok(Named { bytes, is_outside })
    }

    fn has(&self, place: &Path) -> bool {
        self.folders.iter().any(|folder| place.starts_with(folder))
    }

    /// True if a path stays in the room by its words, whatever links it leads through.
    fn leads_inside(&self, path: &Path) -> bool {
        let Ok(path) = std::path::absolute(path) else {
            return false;
        };
        let mut plain = PathBuf::new();
        for part in path.components() {
            match part {
                Component::ParentDir => {
                    plain.pop();
                }
                part => plain.push(part),
            }
        }
        // The path may lead to the folder through links itself.
        let mut above = plain.ancestors().skip(1);
        above.any(|above| std::fs::canonicalize(above).is_ok_and(|a| self.folders.contains(&a)))
    }
}
