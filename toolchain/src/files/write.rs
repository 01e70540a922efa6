//! The one writer of files.
//!
//! A file is written under another name in its folder, synced, and renamed. So it is there as a whole or not at
//! all, whatever happens meanwhile, and nobody sees half of it.

use super::{FileError, confines, ledger};
use std::fs::{File, Permissions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

static WRITING: Mutex<()> = Mutex::new(());

/// While this is held, no file is being written.
pub fn writing() -> MutexGuard<'static, ()> {
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How a path is written.
enum Target {
    /// Something other than a file, such as a device: in place.
    Device,
    /// A file: replaced as a whole. With the permissions of the one that it replaces.
    File(PathBuf, Option<Permissions>),
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
            Ok(found) => {
                let path = std::fs::canonicalize(path)?;
                Ok(Target::File(path, Some(found.permissions())))
            }
            Err(_) if path.file_name().is_none() => Err(io::ErrorKind::IsADirectory.into()),
            Err(_) => Ok(Target::File(path.to_owned(), None)),
        }
    }
}

/// The end of the names of files that are being written.
const PART: &str = ".part";

/// The beginning of the names of files that a process is writing.
fn part_prefix(process: u32) -> String {
    format!(".srp-{process}-")
}

/// True if a file is one that a process is writing, by its name.
fn is_part(name: &str, process: u32) -> bool {
    name.starts_with(&part_prefix(process)) && name.ends_with(PART)
}

/// Removes what a process that was killed has left of files in a folder and those below it.
pub fn remove_parts(folder: &Path, process: u32) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        match entry.file_type() {
            Ok(kind) if kind.is_dir() => remove_parts(&entry.path(), process),
            Ok(kind) if kind.is_file() && is_part(&name, process) => {
                // One that cannot be removed does no harm.
                let _ = std::fs::remove_file(entry.path());
            }
            _ => {}
        }
    }
}

/// An empty file beside `path`, under a name that nobody else has. It is gone with the value.
fn beside(path: &Path) -> io::Result<tempfile::NamedTempFile> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    let mut builder = tempfile::Builder::new();
    let prefix = part_prefix(std::process::id());
    builder.prefix(&prefix).suffix(PART);
    // As of any new file; what the user's mask takes away, it takes here.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder.unwrap_or(Path::new(".")))
}

fn replace(path: &Path, permissions: Option<Permissions>, contents: &[u8]) -> io::Result<()> {
    let _writing = writing();
    let mut part = beside(path)?;
    part.write_all(contents)?;
    if let Some(permissions) = permissions {
        part.as_file().set_permissions(permissions)?;
    }
    part.as_file().sync_all()?;
    part.persist(path)?;
    // Without this the old file may be back after a loss of power, as whole as the new one.
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    let _ = File::open(folder.unwrap_or(Path::new("."))).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Writes a file as a whole or not at all.
///
/// # Errors
///
/// The file cannot be written, or this command has read it.
pub fn write(path: &Path, contents: &[u8]) -> Result<(), FileError> {
    let written = Target::of(path).and_then(|target| match target {
        Target::Device => {
            confines::writes(contents.len() as u64)?;
            std::fs::write(path, contents)
        }
        Target::File(file, permissions) => {
            ledger::check(&file)?;
            confines::may_write(&file)?;
            confines::writes(contents.len() as u64)?;
            replace(&file, permissions, contents)
        }
    });
    written.map_err(|e| FileError::writing(path, e))
}

/// Fails now if [`write()`] to this path would fail later, before any long work is done. From now on the file is
/// an output: nothing else may be written there, and it is not read.
///
/// # Errors
///
/// The file cannot be written, this command has read it, or it is an output already.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    let checked = Target::of(path).and_then(|target| match target {
        Target::Device => Ok(()),
        Target::File(file, _) => {
            confines::may_write(&file)?;
            let _writing = writing();
            beside(&file)?.close()?;
            ledger::declare(&file)
        }
    });
    checked.map_err(|e| FileError::writing(path, e))
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
            format!("_{}-{}", name.trim_start_matches('.'), &digest[..16])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_their_folder() {
        for text in [
            "../../x",
            "/etc/passwd",
            "a/b",
            "..",
            ".",
            "",
            "a\0b",
            "über",
            "CON\n",
        ] {
            let name = file_name(text);
            assert_eq!(
                Path::new(&name).file_name(),
                Some(name.as_ref()),
                "{text:?}"
            );
            assert!(name.is_ascii() && !name.starts_with('.'), "{name}");
        }
        assert_eq!(file_name("shade_light"), "shade_light");
        let long = ["x", "y"].map(|last| file_name(&("n".repeat(100_000) + last)));
        assert!(long[0].len() <= 100 && long[0] != long[1], "{long:?}");
    }

    #[test]
    fn parts_of_one_process_are_removed() {
        let folder = tempfile::tempdir().expect("it can be made");
        let below = folder.path().join("below");
        std::fs::create_dir(&below).expect("it can be made");
        let _other = beside(&below.join("x")).expect("it can be made");
        let own = std::process::id();
        for name in [".srp-7-abc.part", ".srp-77-abc.part", "file"] {
            std::fs::write(below.join(name), "").expect("it can be written");
        }
        remove_parts(folder.path(), 7);
        let names = || std::fs::read_dir(&below).expect("it is there").count();
        assert_eq!(names(), 3);
        remove_parts(folder.path(), own);
        assert_eq!(names(), 2);
    }

    #[test]
    fn files_keep_their_permissions_and_links() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().expect("it can be made");
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("file"), "old").expect("it can be written");
        let shared = Permissions::from_mode(0o640);
        std::fs::set_permissions(path("file"), shared).expect("it is ours");
        symlink("file", path("link")).expect("it can be made");
        write(&path("link"), b"new").expect("it can be written");
        assert_eq!(std::fs::read(path("file")).expect("it is there"), b"new");
        assert!(path("link").is_symlink());
        let mode = std::fs::metadata(path("file"))
            .expect("it is there")
            .permissions()
            .mode();
        assert_eq!(mode & 0o777, 0o640);
        let names = std::fs::read_dir(folder.path())
            .expect("it is there")
            .count();
        assert_eq!(names, 2, "nothing else is left");
        let long = path(&"n".repeat(250));
        write(&long, b"").expect("as long a name as there may be");
    }
}
