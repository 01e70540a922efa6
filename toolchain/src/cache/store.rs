//! The entries of a folder: reading, writing, removing, counting.

use super::entry::{self, Damage};
use super::folder::{self, Place, Workplace};
use super::{Key, Kind, note};
use crate::amount;
use srp_archdesc::watch::Watch;
use std::collections::BTreeMap;
use std::fs::{self, DirEntry, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Most bytes of all entries together, unless `SRP_CACHE_LIMIT` sets another limit.
const LIMIT: u64 = 1 << 30;

/// The part of the limit that is left when entries are removed to make room.
const LEFT: f64 = 0.75;

/// Bytes that are written between two looks at how much there is.
const LOOK_AFTER: u64 = 32 << 20;

/// An entry's time of use is brought up to date when it is older than this.
const REMEMBER_USE: Duration = Duration::from_secs(60);

/// A number of entries, and their bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Entries.
    pub entries: u64,
    /// Bytes.
    pub bytes: u64,
}

/// The entries of a folder, counted.
#[derive(Clone, Debug)]
pub struct Counts {
    /// The folder.
    pub folder: PathBuf,
    /// Bytes that it may take.
    pub limit: u64,
    /// Entries by kind.
    pub kinds: BTreeMap<Kind, Found>,
}

/// The entries of a folder.
pub(super) struct Store {
    folder: PathBuf,
    /// Where the folder is a temporary one, it goes when this does.
    temporary: Option<tempfile::TempDir>,
    /// True if nothing is written to it.
    is_read_only: bool,
    limit: u64,
    /// Bytes written since the last look; at first as many as call for a look.
    written: u64,
    /// True if a note has said that something cannot be written.
    complained: bool,
}

impl Store {
    /// Opens the folder of a place, or a temporary one.
    pub(super) fn open(place: &Place, watch: &dyn Watch) -> Store {
        let asked = std::env::var("SRP_CACHE_LIMIT").ok();
        let limit = asked.as_deref().and_then(amount::parse);
        if let (Some(asked), None) = (&asked, limit) {
            note(
                watch,
                format_args!(
                    "SRP_CACHE_LIMIT={asked} is no number of bytes (write 500M or 2G): the limit is {}",
                    amount::of_bytes(LIMIT)
                ),
            );
        }
        let mut store = Store {
            folder: PathBuf::new(),
            temporary: None,
            is_read_only: false,
            limit: limit.unwrap_or(LIMIT),
            written: LOOK_AFTER,
            complained: false,
        };
        match place {
            Place::Folder(path) => match folder::open(path) {
                Ok(folder) => store.folder = folder,
                Err(why) => {
                    let path = path.display();
                    note(
                        watch,
                        format_args!("the cache {path} is not used: {why}; nothing is kept"),
                    );
                    store.move_away();
                }
            },
            Place::ReadOnly(path) => {
                store.is_read_only = true;
                // One that is not there, or not the user's, has no entries.
                store.folder = folder::find(path).unwrap_or_default();
            }
            Place::Temporary => store.move_away(),
        }
        store
    }

    /// Goes on in a private temporary folder.
    fn move_away(&mut self) {
        let made = folder::temporary("srp-cache-", &std::env::temp_dir());
        // Where even that fails, writing fails too, and nothing is kept.
        self.temporary = made.ok();
        let folder = self.temporary.as_ref().map(|t| t.path().to_owned());
        self.folder = folder.unwrap_or_default();
    }

    fn path(&self, key: Key) -> PathBuf {
        let (kind, name) = (key.kind().name(), key.to_string());
        self.folder.join(kind).join(&name[..2]).join(&name)
    }

    /// The bytes of an entry, if it is there and whole.
    pub(super) fn get(&mut self, key: Key, watch: &dyn Watch) -> Option<Vec<u8>> {
        if self.is_read_only && self.folder.as_os_str().is_empty() {
            return None;
        }
        let path = self.path(key);
        let file = fs::read(&path).ok()?;
        match entry::open(key, file) {
            Ok(bytes) => {
                if !self.is_read_only {
                    used(&path);
                }
                Some(bytes)
            }
            Err(damage) => {
                self.remove(key, damage, watch);
                None
            }
        }
    }

    /// The file of an entry, if it is there and whole.
    pub(super) fn file(&mut self, key: Key, watch: &dyn Watch) -> Option<PathBuf> {
        self.get(key, watch).map(|_| self.path(key))
    }

    /// Removes a damaged entry, and says so.
    pub(super) fn remove(&mut self, key: Key, damage: Damage, watch: &dyn Watch) {
        let path = self.path(key);
        note(
            watch,
            format_args!(
                "the cache's entry {} is damaged ({damage}) and is made again",
                path.display()
            ),
        );
        if self.is_read_only {
            return;
        }
        // An entry that cannot be removed is written over.
        let _ = fs::remove_file(path);
    }

    /// Writes an entry. Where the folder is full or cannot be written, a note says so once, and a
    /// temporary folder takes its place.
    pub(super) fn put(&mut self, key: Key, bytes: &[u8], watch: &dyn Watch) {
        if self.is_read_only {
            return;
        }
        self.make_room();
        let Err(why) = self.write(key, bytes) else {
            self.written += bytes.len() as u64;
            return;
        };
        if !self.complained {
            self.complained = true;
            let folder = self.folder.display();
            note(
                watch,
                format_args!("the cache {folder} cannot be written: {why}; nothing more is kept"),
            );
        }
        if self.temporary.is_none() {
            self.move_away();
            // A second failure was foretold by the note.
            let _ = self.write(key, bytes);
        }
    }

    fn write(&self, key: Key, bytes: &[u8]) -> io::Result<()> {
        let path = self.path(key);
        let folder = path.parent().unwrap_or(&self.folder);
        fs::create_dir_all(folder)?;
        let place = self.workplace()?;
        let part = place.path().join("entry");
        let mut file = File::create_new(&part)?;
        file.write_all(bytes)?;
        file.write_all(&entry::trailer(key, bytes))?;
        // Else a crash of the host could leave the name without the bytes.
        file.sync_all()?;
        fs::rename(&part, &path)?;
        File::open(folder)?.sync_all()
    }

    /// A folder for work that makes an entry.
    pub(super) fn workplace(&self) -> io::Result<Workplace> {
        Workplace::beside(&self.folder)
    }

    /// From time to time removes the workplaces of killed processes, and, if all entries take more than the
    /// limit, those that were used least recently.
    fn make_room(&mut self) {
        if self.written < LOOK_AFTER {
            return;
        }
        self.written = 0;
        folder::sweep(&self.folder);
        let mut entries = self.entries();
        let mut bytes: u64 = entries.iter().map(|e| e.bytes).sum();
        if bytes <= self.limit {
            return;
        }
        entries.sort_by_key(|e| e.used);
        for entry in entries {
            if bytes as f64 <= self.limit as f64 * LEFT {
                break;
            }
            if fs::remove_file(&entry.path).is_ok() {
                bytes -= entry.bytes;
            }
        }
    }

    /// All files that are named as entries are.
    fn entries(&self) -> Vec<Listed> {
        let listed = |(key, file): (Key, DirEntry)| {
            let found = file.metadata().ok()?;
            Some(Listed {
                path: file.path(),
                key,
                bytes: found.len(),
                used: found.modified().ok()?,
            })
        };
        let files = Kind::ALL.into_iter().flat_map(|kind| self.files(kind));
        files.filter_map(listed).collect()
    }

    /// The files that are named as entries of a kind are.
    fn files(&self, kind: Kind) -> Vec<(Key, DirEntry)> {
        let folders = fs::read_dir(self.folder.join(kind.name()));
        let folders = folders.into_iter().flatten().flatten();
        let files = folders.flat_map(|folder| fs::read_dir(folder.path()).into_iter().flatten());
        let named = |file: DirEntry| Some((Key::parse(kind, file.file_name().to_str()?)?, file));
        files.flatten().filter_map(named).collect()
    }

    /// The keys of all entries of a kind.
    pub(super) fn keys(&self, kind: Kind) -> Vec<Key> {
        self.files(kind).into_iter().map(|(key, _)| key).collect()
    }

    /// The folder, locked, if no other process has it so and what is written there stays.
    pub(super) fn turn(&self) -> Option<File> {
        if self.is_read_only || self.temporary.is_some() {
            return None;
        }
        let folder = File::open(&self.folder).ok()?;
        folder.try_lock().ok().map(|()| folder)
    }

    pub(super) fn counts(&self) -> Counts {
        let mut kinds: BTreeMap<Kind, Found> = BTreeMap::new();
        for entry in self.entries() {
            let found = kinds.entry(entry.key.kind()).or_default();
            found.entries += 1;
            found.bytes += entry.bytes;
        }
        Counts {
            folder: self.folder.clone(),
            limit: self.limit,
            kinds,
        }
    }

    pub(super) fn clean(&mut self) -> Found {
        folder::sweep(&self.folder);
        let mut removed = Found::default();
        for entry in self.entries() {
            if fs::remove_file(&entry.path).is_ok() {
                removed.entries += 1;
                removed.bytes += entry.bytes;
            }
        }
        removed
    }

    pub(super) fn verify(&mut self) -> (Found, Vec<(PathBuf, Damage)>) {
        let (mut whole, mut damaged) = (Found::default(), Vec::new());
        for entry in self.entries() {
            // It may have been removed meanwhile.
            let Ok(file) = fs::read(&entry.path) else {
                continue;
            };
            match entry::open(entry.key, file) {
                Ok(_) => {
                    whole.entries += 1;
                    whole.bytes += entry.bytes;
                }
                Err(damage) => {
                    let _ = fs::remove_file(&entry.path);
                    damaged.push((entry.path, damage));
                }
            }
        }
        (whole, damaged)
    }
}

/// The file of an entry.
struct Listed {
    path: PathBuf,
    key: Key,
    bytes: u64,
    used: SystemTime,
}

/// Remembers that an entry was used now.
fn used(path: &Path) {
    let Ok(file) = File::options().append(true).open(path) else {
        return;
    };
    let then = file.metadata().and_then(|found| found.modified()).ok();
    if then.is_none_or(|then| then.elapsed().is_ok_and(|age| age > REMEMBER_USE)) {
        // An entry whose use is not remembered goes a little sooner.
        let _ = file.set_modified(SystemTime::now());
    }
}
