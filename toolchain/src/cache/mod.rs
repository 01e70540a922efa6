//! Keeps results that are needed again: schedules, simulators, frames, trials.
//!
//! A cache maps a [`Key`], a digest over everything that a result depends on, to the result's bytes.
//! It never answers with anything but the bytes that were put under this very key: each entry holds its key,
//! its length and a digest of its bytes, and the cache checks these before it answers. It removes a damaged
//! entry, which is then made again, and a note says so.
//!
//! Entries are written to a temporary name, synced, and renamed; they are never changed. So any number
//! of processes may use a folder at once, and may be killed at any moment. The folder is the user's
//! own: another user's, or one that others may write to, is not used, because a simulator from it would
//! be run. Where there is no folder to be had, or no room in it, entries live as long as the process.
//!
//! * [`key`](mod@key) makes keys of values.
//! * [`entry`] is the form of an entry.
//! * [`folder`] says where entries lie, and whom it may belong to.
//! * [`store`] reads, writes, removes and counts them.
//! * [`shared`] is not of the cache: a folder of entries that processes make together.

mod entry;
mod folder;
pub mod key;
mod shared;
mod store;

pub use entry::Damage;
pub use folder::{Place, Workplace};
pub use key::Key;
pub use shared::{Piece, Shared};
pub use store::{Counts, Found};

use serde::{Deserialize, Serialize};
use srp_archdesc::watch::{Event, Watch};
use std::collections::{BTreeSet, HashMap};
use std::fs::File;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use store::Store;

/// Kinds of entries: each has a folder of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Kind {
    /// Schedules of loops.
    Loops,
    /// Compiled simulators.
    Simulators,
    /// Frames at levels of simulation.
    Frames,
    /// Trials of settings of accuracy.
    Trials,
    /// Builds of kernels that are ready.
    Builds,
    /// Their scheduled programs.
    Programs,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 6] = [
        Kind::Loops,
        Kind::Simulators,
        Kind::Frames,
        Kind::Trials,
        Kind::Builds,
        Kind::Programs,
    ];

    /// Its name, which is that of its folder.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Loops => "loops",
            Kind::Simulators => "simulators",
            Kind::Frames => "frames",
            Kind::Trials => "trials",
            Kind::Builds => "builds",
            Kind::Programs => "programs",
        }
    }
}

/// Entries of this process, and, where there is one, of a folder.
pub struct Cache {
    /// Entries that this process has read or made.
    memory: Mutex<HashMap<Key, Arc<[u8]>>>,
    entries: Mutex<Entries>,
}

/// The entries that outlive the process.
enum Entries {
    /// There are none.
    None,
    /// They are in a place that nobody has asked yet: a command that fails early leaves no folder.
    Unopened(Place),
    /// They are in a folder.
    Open(Store),
}

impl Cache {
    /// A cache that lives as long as the process.
    pub fn in_memory() -> Cache {
        Cache {
            memory: Mutex::default(),
            entries: Mutex::new(Entries::None),
        }
    }

    /// A cache in a folder. Where that cannot be used, a note says why at the first use, and a private
    /// temporary folder takes its place.
    pub fn at(place: Place) -> Cache {
        Cache {
            memory: Mutex::default(),
            entries: Mutex::new(Entries::Unopened(place)),
        }
    }

    /// The value of a key, if it is known.
    pub fn get<T: serde::de::DeserializeOwned>(&self, key: Key, watch: &dyn Watch) -> Option<T> {
        let bytes = self.bytes(key, watch)?;
        // A value of another shape has another key; bytes that are no value are damage all the same.
        match postcard::from_bytes(&bytes) {
            Ok(value) => Some(value),
            Err(_) => {
                self.forget(key, Damage::Shape, watch);
                None
            }
        }
    }

    /// Keeps the value of a key. A value that cannot be kept is made again the next time.
    pub fn put<T: serde::Serialize>(&self, key: Key, value: &T, watch: &dyn Watch) {
        let Ok(bytes) = postcard::to_allocvec(value) else {
            return;
        };
        self.put_bytes(key, bytes.into(), watch);
    }

    /// Keeps the bytes of a key.
    pub fn put_bytes(&self, key: Key, bytes: Arc<[u8]>, watch: &dyn Watch) {
        self.with(watch, |store| store.put(key, &bytes, watch));
        let mut memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        memory.insert(key, bytes);
    }

    /// The bytes of a key.
    pub fn bytes(&self, key: Key, watch: &dyn Watch) -> Option<Arc<[u8]>> {
        let known = || {
            let memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
            memory.get(&key).cloned()
        };
        if let Some(bytes) = known() {
            return Some(bytes);
        }
        let bytes: Arc<[u8]> = self.if_there(watch, |store| store.get(key, watch))??.into();
        let mut memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        Some(Arc::clone(memory.entry(key).or_insert(bytes)))
    }

    /// All values of a kind, in the order of their keys. Entries of other builds of the tools, whose values may have another
    /// shape, are left out.
    pub fn all<T: serde::de::DeserializeOwned>(&self, kind: Kind, watch: &dyn Watch) -> Vec<T> {
        let kept = self.if_there(watch, |store| store.keys(kind));
        let memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        let known = memory.keys().copied().filter(|key| key.kind() == kind);
        let keys: BTreeSet<Key> = kept.into_iter().flatten().chain(known).collect();
        drop(memory);
        let value = |key| postcard::from_bytes(&self.bytes(key, watch)?).ok();
        keys.into_iter().filter_map(value).collect()
    }

    /// The turn to work on entries that nobody waits for. One process at a time has it for a folder, for as long as it or a process
    /// that it hands the file to keeps that open. `None` if another has it, or if no entry would outlive this process.
    pub fn turn(&self, watch: &dyn Watch) -> Option<File> {
        self.with(watch, |store| store.turn())?
    }

    /// The file of an entry whose bytes have just been found whole, for those who need a file: bytes
    /// of the entry's own follow those that were put there.
    pub fn file(&self, key: Key, watch: &dyn Watch) -> Option<PathBuf> {
        self.if_there(watch, |store| store.file(key, watch))?
    }

    /// A folder for work that makes an entry; it goes when this does.
    ///
    /// # Errors
    ///
    /// Neither the cache's folder nor a temporary one can be written.
    pub fn workplace(&self, watch: &dyn Watch) -> std::io::Result<Workplace> {
        match self.with(watch, |store| store.workplace()) {
            Some(Ok(place)) => Ok(place),
            Some(Err(_)) | None => Workplace::temporary(),
        }
    }

    /// Counts the entries of the folder, by kind.
    pub fn counts(&self, watch: &dyn Watch) -> Option<Counts> {
        self.with(watch, |store| store.counts())
    }

    /// Removes all entries of the folder. Returns how many entries and bytes these were.
    pub fn clean(&self, watch: &dyn Watch) -> Option<Found> {
        let mut memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        memory.clear();
        drop(memory);
        self.if_there(watch, |store| store.clean())
    }

    /// Checks all entries of the folder, and removes those that are damaged. Returns how many are whole, and each
    /// damaged one with its damage.
    pub fn verify(&self, watch: &dyn Watch) -> Option<(Found, Vec<(PathBuf, Damage)>)> {
        self.if_there(watch, |store| store.verify())
    }

    /// Removes an entry that cannot be trusted; a note says so.
    pub(crate) fn forget(&self, key: Key, damage: Damage, watch: &dyn Watch) {
        let mut memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        memory.remove(&key);
        drop(memory);
        self.with(watch, |store| store.remove(key, damage, watch));
    }

    /// Asks the entries that outlive the process, if there may be any yet.
    fn if_there<R>(&self, watch: &dyn Watch, f: impl FnOnce(&mut Store) -> R) -> Option<R> {
        let entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let may_be = match &*entries {
            Entries::None | Entries::Unopened(Place::Temporary) => false,
            Entries::Unopened(Place::Folder(folder) | Place::ReadOnly(folder)) => folder.exists(),
            Entries::Open(_) => true,
        };
        drop(entries);
        may_be.then(|| self.with(watch, f)).flatten()
    }

    /// Does something with the entries that outlive the process; their folder is made if need be.
    fn with<R>(&self, watch: &dyn Watch, f: impl FnOnce(&mut Store) -> R) -> Option<R> {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        if let Entries::Unopened(place) = &*entries {
            *entries = Entries::Open(Store::open(place, watch));
        }
        match &mut *entries {
            Entries::Open(store) => Some(f(store)),
            Entries::None | Entries::Unopened(_) => None,
        }
    }
}

/// Tells a user something about the cache.
fn note(watch: &dyn Watch, text: std::fmt::Arguments<'_>) {
    watch.tell(Event::Note(&format!("note: {text}")));
}
