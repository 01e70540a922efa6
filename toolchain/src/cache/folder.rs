//! The folder of entries: where it is, and who may own it.

use std::fs::{self, DirBuilder, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The place of a cache.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// In this folder, made if it is not there.
    Folder(PathBuf),
    /// In this folder, if it is there: entries are read and none is written, so that nothing that a stranger's input
    /// does is there for others.
    ReadOnly(PathBuf),
    /// Nowhere that stays: the host does not say where the user's files are.
    Temporary,
}

impl Place {
    /// The user's: `SRP_CACHE`, else a folder in the user's cache. Without any, a temporary one: a
    /// folder of a fixed name that all users share could be another's.
    pub fn of_user() -> Place {
        let variable = |name| {
            let value = std::env::var_os(name).filter(|v| !v.is_empty());
            value.map(PathBuf::from)
        };
        let found = variable("SRP_CACHE")
            .or_else(|| variable("XDG_CACHE_HOME").map(|p| p.join("srp")))
            .or_else(|| variable("HOME").map(|p| p.join(".cache").join("srp")));
        found.map_or(Place::Temporary, Place::Folder)
    }
}

/// The name of the folder of entries in the place; another form of entries has another.
const ENTRIES: &str = "entries-1";

/// The name of the folder for work under way.
const WORK: &str = "work";

/// A workplace without a lock is left alone for so long: it may just be in the making.
const FRESH: Duration = Duration::from_secs(60);

/// Opens the folder of entries in a place.
///
/// # Errors
///
/// It cannot be made, or must not be trusted.
pub(super) fn open(place: &Path) -> io::Result<PathBuf> {
    let folder = place.join(ENTRIES);
    private_folder(&folder)?;
    check_owner(place)?;
    check_owner(&folder)?;
    Ok(folder)
}

/// Finds the folder of entries in a place, in which nothing is written.
///
/// # Errors
///
/// It is not there, or must not be trusted.
pub(super) fn find(place: &Path) -> io::Result<PathBuf> {
    let folder = place.join(ENTRIES);
    #[cfg(unix)]
    for folder in [place, &folder] {
        check_found(&fs::metadata(folder)?, rustix::process::geteuid().as_raw())?;
    }
    Ok(folder)
}

/// Makes a folder and those above it. New folders belong to the user alone.
fn private_folder(path: &Path) -> io::Result<()> {
    let mut builder = DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(path)
}

/// Makes a folder of a name that nobody knows before, for the user alone.
pub(super) fn temporary(prefix: &str, folder: &Path) -> io::Result<tempfile::TempDir> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
    builder.prefix(prefix).tempdir_in(folder)
}

/// Refuses a folder that another user owns or may write to.
#[cfg(unix)]
fn check_owner(folder: &Path) -> io::Result<()> {
    use std::os::unix::fs::MetadataExt;
    let found = fs::symlink_metadata(folder)?;
    // What this process makes belongs to this user.
    let probe = tempfile::NamedTempFile::new_in(folder)?;
    let user = probe.as_file().metadata()?.uid();
    if found.file_type().is_symlink() && fs::metadata(folder)?.uid() != user {
        return refuse("it leads to another user's folder");
    }
    check_found(&fs::metadata(folder)?, user)
}

/// Refuses a folder that does not belong to a user, or that others may write to.
#[cfg(unix)]
fn check_found(found: &fs::Metadata, user: u32) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    if found.uid() != user {
        return refuse("it is another user's");
    }
    if found.permissions().mode() & 0o022 != 0 {
        return refuse("other users may write to it");
    }
    Ok(())
}

#[cfg(unix)]
fn refuse(why: &str) -> io::Result<()> {
    Err(io::Error::new(io::ErrorKind::PermissionDenied, why))
}

#[cfg(not(unix))]
fn check_owner(_: &Path) -> io::Result<()> {
    Ok(())
}

/// A folder for work that makes an entry, locked as long as the work goes on. It goes when this does,
/// and if the process is killed, with the next one that looks.
pub struct Workplace {
    folder: tempfile::TempDir,
    _lock: File,
}

impl Workplace {
    /// A workplace beside the entries.
    pub(super) fn beside(entries: &Path) -> io::Result<Workplace> {
        let work = entries.join(WORK);
        private_folder(&work)?;
        Workplace::in_folder(&work)
    }

    /// A workplace among the host's temporary files.
    pub(super) fn temporary() -> io::Result<Workplace> {
        Workplace::in_folder(&std::env::temp_dir())
    }

    fn in_folder(folder: &Path) -> io::Result<Workplace> {
        let folder = temporary("srp-", folder)?;
        let lock = File::create_new(folder.path().join("lock"))?;
        lock.lock()?;
        Ok(Workplace {
            folder,
            _lock: lock,
        })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Removes the workplaces of processes that are no more.
pub(super) fn sweep(entries: &Path) {
    let Ok(left) = fs::read_dir(entries.join(WORK)) else {
        return;
    };
    for place in left.flatten() {
        let path = place.path();
        let is_left = match File::open(path.join("lock")) {
            // A process that goes, however it goes, gives up its locks.
            Ok(lock) => lock.try_lock().is_ok(),
            Err(_) => age(&path).is_some_and(|age| age > FRESH),
        };
        if is_left {
            // A workplace that cannot be removed takes up room and does no harm.
            let _ = fs::remove_dir_all(&path);
        }
    }
}

/// The time since a file was changed.
fn age(path: &Path) -> Option<Duration> {
    fs::metadata(path).ok()?.modified().ok()?.elapsed().ok()
}
