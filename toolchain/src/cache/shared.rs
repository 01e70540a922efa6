//! A folder through which processes that do the same work, on one host or on many, share its pieces.
//!
//! Every process goes through all pieces: it takes those that are there, and makes those that nobody has begun. When all
//! are begun it waits for the others', and makes those whose makers have died. A process says what it makes by a *claim*, a file
//! with its name, and that it lives by touching another one. Claims save work and decide nothing: a piece is the same
//! whoever makes it, is written beside and renamed, and is protected like an entry of the cache. So any number of processes
//! may begin, be killed and begin again at any moment, and the worst is that a piece is made twice. Spare copies of slow
//! work, and results that appear as a whole, are those of MapReduce (Dean and Ghemawat, OSDI 2004).

use super::Key;
use super::entry;
use crate::files::{self, FileError};
use serde::Serialize;
use serde::de::DeserializeOwned;
use srp_archdesc::threads;
use srp_archdesc::watch::Watch;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};

/// Between two signs of life.
const BEAT: Duration = Duration::from_secs(1);
/// A process that gave no sign of life for so long is taken for dead.
const DEAD: Duration = Duration::from_secs(15);
/// Between two looks at pieces that others make.
const LOOK: Duration = Duration::from_millis(200);

/// A piece of work: any value that can be kept for other processes.
pub trait Piece: Serialize + DeserializeOwned + Send {}

impl<T: Serialize + DeserializeOwned + Send> Piece for T {}

/// A folder of pieces.
pub struct Shared {
    folder: PathBuf,
    /// This process, among all of all hosts.
    name: String,
    /// Ends the signs of life when it goes.
    ends: Option<Sender<()>>,
    beats: Option<JoinHandle<()>>,
}

/// A piece that this process makes. It goes with the work, whether that succeeds or not.
struct Claim(PathBuf);

impl Drop for Claim {
    fn drop(&mut self) {
        // One that stays is void as soon as its process is dead.
        let _ = fs::remove_file(&self.0);
    }
}

impl Shared {
    /// The folder, which is made where there is none.
    ///
    /// # Errors
    ///
    /// It cannot be written.
    pub fn at(folder: &Path) -> Result<Shared, FileError> {
        let claims = folder.join("claims");
        files::make_folder(folder)?;
        files::make_folder(&claims)?;
        let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
        let now = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
        let name = files::file_name(&format!(
            "{}-{}-{}",
            host.trim(),
            std::process::id(),
            now.as_nanos()
        ));
        let alive = claims.join(&name);
        beat(&alive).map_err(|e| FileError::writing(&alive, e))?;
        let (ends, ended) = mpsc::channel();
        let beats = std::thread::spawn(move || {
            while ended.recv_timeout(BEAT) == Err(RecvTimeoutError::Timeout) {
                // A sign that cannot be given makes others do this process's work, which does no harm.
                let _ = beat(&alive);
            }
            let _ = fs::remove_file(&alive);
        });
        Ok(Shared {
            folder: folder.to_owned(),
            name,
            ends: Some(ends),
            beats: Some(beats),
        })
    }

    /// Makes those pieces of work that nobody has begun, several at a time, and returns those that there are then, in the order of
    /// their keys; `None` if the watch ends the work.
    ///
    /// # Errors
    ///
    /// As of [`pieces`](Shared::pieces).
    pub fn begin<S, T, E>(
        &self,
        keys: &[Key],
        threads: usize,
        watch: &dyn Watch,
        state: impl Fn() -> S + Sync,
        make: impl Fn(&mut S, usize) -> Result<T, E> + Sync,
    ) -> Result<Option<Vec<Option<T>>>, E>
    where
        T: Piece,
        E: From<FileError> + Send,
    {
        let take = |state: &mut S, i: usize| {
            (!watch.cancelled()).then(|| self.take(keys[i], || make(state, i)))
        };
        let begun = threads::all(threads, keys.len(), state, take);
        begun.map(|all| all.into_iter().collect()).transpose()
    }

    /// Makes pieces of work, several at a time, and returns them in their order; `None` if the watch ends the work. Each
    /// thread has a state of its own to work with.
    ///
    /// # Errors
    ///
    /// That of a piece that fails, or that cannot be kept (`E: From<FileError>`).
    pub fn pieces<S, T, E>(
        &self,
        keys: &[Key],
        threads: usize,
        watch: &dyn Watch,
        state: impl Fn() -> S + Sync,
        make: impl Fn(&mut S, usize) -> Result<T, E> + Sync,
    ) -> Result<Option<Vec<T>>, E>
    where
        T: Piece,
        E: From<FileError> + Send,
    {
        let Some(mut pieces) = self.begin(keys, threads, watch, &state, &make)? else {
            return Ok(None);
        };
        let open: Vec<usize> = (0..keys.len()).filter(|&i| pieces[i].is_none()).collect();
        let wait = |state: &mut S, n: usize| {
            loop {
                if watch.cancelled() {
                    return None;
                }
                let i = open[n];
                match self.take(keys[i], || make(state, i)) {
                    Ok(None) => std::thread::sleep(LOOK),
                    Ok(Some(piece)) => return Some(Ok(piece)),
                    Err(error) => return Some(Err(error)),
                }
            }
        };
        let ended = threads::some(threads, open.len(), &state, wait);
        for (&i, piece) in open.iter().zip(ended) {
            let Some(piece) = piece else {
                return Ok(None);
            };
            pieces[i] = Some(piece?);
        }
        Ok(Some(pieces.into_iter().flatten().collect()))
    }

    /// A piece that is there, or that is made now; none if another process makes it.
    fn take<T, E>(&self, key: Key, make: impl FnOnce() -> Result<T, E>) -> Result<Option<T>, E>
    where
        T: Piece,
        E: From<FileError>,
    {
        if let Some(piece) = self.get(key) {
            return Ok(Some(piece));
        }
        let Some(claim) = self.claim(key) else {
            return Ok(None);
        };
        // It may have ended between the two looks.
        if let Some(piece) = self.get(key) {
            return Ok(Some(piece));
        }
        let piece = make()?;
        self.put(key, &piece)?;
        drop(claim);
        Ok(Some(piece))
    }

    fn path(&self, key: Key) -> PathBuf {
        self.folder.join(key.to_string())
    }

    /// A piece; none that is damaged.
    fn get<T: DeserializeOwned>(&self, key: Key) -> Option<T> {
        let bytes = fs::read(self.path(key)).ok()?;
        postcard::from_bytes(&entry::open(key, bytes).ok()?).ok()
    }

    fn put<T: Serialize>(&self, key: Key, piece: &T) -> Result<(), FileError> {
        let mut bytes = postcard::to_allocvec(piece).expect("pieces can be serialised");
        let trailer = entry::trailer(key, &bytes);
        bytes.extend(trailer);
        files::write(&self.path(key), &bytes)
    }

    /// Claims a piece, unless a process that lives has.
    fn claim(&self, key: Key) -> Option<Claim> {
        let path = self.folder.join("claims").join(key.to_string());
        for _ in 0..2 {
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(mut file) => {
                    // Without its name in it a claim is void, and the piece may be made twice.
                    let _ = file.write_all(self.name.as_bytes());
                    return Some(Claim(path));
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                    if self.is_held(&path) {
                        return None;
                    }
                    let _ = fs::remove_file(&path);
                }
                // A folder that takes no claims has each process do all of the work.
                Err(_) => return Some(Claim(path)),
            }
        }
        None
    }

    /// True if the process that has a claim lives. The file system's clock tells, not the host's.
    fn is_held(&self, claim: &Path) -> bool {
        let claims = self.folder.join("claims");
        let touched = |path: &Path| fs::metadata(path).and_then(|m| m.modified()).ok();
        let (Some(claimed), Some(now)) = (touched(claim), touched(&claims.join(&self.name))) else {
            return false;
        };
        let name = fs::read_to_string(claim).unwrap_or_default();
        let recent = |then: SystemTime| now.duration_since(then).unwrap_or_default() < DEAD;
        match name.is_empty() {
            // Its name is about to be written.
            true => recent(claimed),
            false => touched(&claims.join(files::file_name(&name))).is_some_and(recent),
        }
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        self.ends = None;
        if let Some(beats) = self.beats.take() {
            // It only sleeps and writes.
            let _ = beats.join();
        }
    }
}

/// Gives a sign of life.
fn beat(alive: &Path) -> io::Result<()> {
    fs::write(alive, b"alive\n")
}

#[cfg(test)]
mod tests {
    use super::super::Kind;
    use super::*;
    use crate::Error;
    use srp_archdesc::Unwatched;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn keys() -> Vec<Key> {
        let key = |i: u32| Key::of(Kind::Trials).value(&i).finish();
        (0..40).map(key).collect()
    }

    #[test]
    fn every_piece_is_made_once_among_all() {
        let folder = tempfile::tempdir().expect("a folder");
        let made = AtomicUsize::new(0);
        let work = || {
            let shared = Shared::at(folder.path()).expect("it can be written");
            let make = |(): &mut (), i: usize| {
                made.fetch_add(1, Ordering::Relaxed);
                std::thread::sleep(Duration::from_millis(5));
                Ok::<_, Error>(i * i)
            };
            shared.pieces(&keys(), 2, &Unwatched, || (), make)
        };
        std::thread::scope(|scope| {
            let all: Vec<_> = (0..3).map(|_| scope.spawn(work)).collect();
            for one in all {
                let pieces = one.join().expect("no panic").expect("no piece fails");
                assert!(pieces.is_some_and(|p| p.into_iter().eq((0..40).map(|i| i * i))));
            }
        });
        assert_eq!(made.into_inner(), 40);
        let left = fs::read_dir(folder.path().join("claims")).expect("it is there");
        assert_eq!(left.count(), 0, "claims go with their work");
    }

    #[test]
    fn claims_of_the_dead_and_damaged_pieces_are_void() {
        let folder = tempfile::tempdir().expect("a folder");
        let shared = Shared::at(folder.path()).expect("it can be written");
        let keys = keys();
        let claims = folder.path().join("claims");
        fs::write(claims.join(keys[3].to_string()), "a process that is gone").expect("written");
        fs::write(folder.path().join(keys[5].to_string()), "half a pie").expect("written");
        let pieces = shared.pieces(&keys, 1, &Unwatched, || (), |(), i| Ok::<_, Error>(i));
        assert!(matches!(pieces, Ok(Some(p)) if p.iter().copied().eq(0..40)));
    }

    #[test]
    fn a_piece_that_fails_is_no_piece() {
        let folder = tempfile::tempdir().expect("a folder");
        let shared = Shared::at(folder.path()).expect("it can be written");
        let fails = |(): &mut (), i: usize| match i {
            7 => Err(Error::invalid("no")),
            _ => Ok(i),
        };
        let pieces = shared.pieces(&keys(), 1, &Unwatched, || (), fails);
        assert!(matches!(pieces, Err(Error::Invalid(_))));
        let pieces = shared.pieces(&keys(), 1, &Unwatched, || (), |(), i| Ok::<_, Error>(i));
        assert!(matches!(pieces, Ok(Some(_))));
    }
}
