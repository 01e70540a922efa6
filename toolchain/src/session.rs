//! The session, which all work of one process shares.

use crate::cache::{Cache, Key, Piece, Shared};
use crate::files::{FileError, Outside};
use srp_archdesc::threads;
use srp_archdesc::watch::{Event, Unwatched, Watch};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// The surroundings of work: its watcher, and the means that it may use.
pub struct Session<'a> {
    /// The watcher.
    pub watch: &'a dyn Watch,
    /// Threads of the host; no result depends on them.
    pub threads: usize,
    /// Results that were made before.
    pub cache: Arc<Cache>,
    /// The folder through which processes share pieces of this work.
    pub shared: Option<Arc<Shared>>,
    /// What is done about files that a scene names outside its folder.
    pub outside: Outside,
    /// The program that builds simulators beside the work: it calls [`build`](crate::engine::build) if its
    /// first argument asks for that. Without one, no simulators are built beside the work.
    pub builder: Option<PathBuf>,
    /// True if `rustc` may be started for a simulator that is not in the cache.
    pub compiles: bool,
    /// The most cycles that a program or a frame is simulated, or steps that it is interpreted.
    pub cycles: u64,
}

impl<'a> Session<'a> {
    /// A session on all processors of the host, with a cache of its own.
    pub fn new(watch: &'a dyn Watch) -> Session<'a> {
        Session {
            watch,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            cache: Arc::new(Cache::in_memory()),
            shared: None,
            outside: Outside::default(),
            builder: None,
            compiles: true,
            cycles: u64::MAX,
        }
    }

    /// The same with another cache.
    pub fn with_cache(self, cache: Cache) -> Session<'a> {
        Session {
            cache: Arc::new(cache),
            ..self
        }
    }

    /// A session for work beside other work of this one: another watches it, it has one thread, and it neither builds simulators nor
    /// is shared by itself.
    pub fn beside<'b>(&self, watch: &'b dyn Watch) -> Session<'b> {
        Session {
            watch,
            threads: 1,
            cache: Arc::clone(&self.cache),
            shared: None,
            outside: self.outside,
            builder: None,
            compiles: self.compiles,
            cycles: self.cycles,
        }
    }

    /// Makes pieces of work, so many at a time, and returns them in their order; `None` if the watch ends the work. Processes that
    /// [share](Shared) the work make each of them once among all. Each thread has a state of its own to work with.
    ///
    /// # Errors
    ///
    /// That of a key or of a piece that fails, or a piece cannot be kept for the other processes.
    pub fn pieces<S, T, E>(
        &self,
        threads: usize,
        parts: usize,
        key: impl Fn(usize) -> Result<Key, E>,
        state: impl Fn() -> S + Sync,
        make: impl Fn(&mut S, usize) -> Result<T, E> + Sync,
    ) -> Result<Option<Vec<T>>, E>
    where
        T: Piece,
        E: From<FileError> + Send,
    {
        if let Some(shared) = &self.shared {
            let keys: Vec<Key> = (0..parts).map(key).collect::<Result<_, _>>()?;
            return shared.pieces(&keys, threads, self.watch, state, make);
        }
        let made = |state: &mut S, i| (!self.watch.cancelled()).then(|| make(state, i));
        let all = threads::all(threads, parts, state, made);
        all.map(|all| all.into_iter().collect()).transpose()
    }

    /// The error of work that was cancelled, if it was.
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub fn check(&self) -> Result<(), crate::Error> {
        match self.watch.cancelled() {
            true => Err(crate::Error::Cancelled),
            false => Ok(()),
        }
    }
}

impl Default for Session<'_> {
    /// A session without a watcher.
    fn default() -> Self {
        Session::new(&Unwatched)
    }
}

/// A watch that also takes the time of stages and items. Times of one name add up.
pub struct Timed<'a> {
    watch: &'a dyn Watch,
    laps: Mutex<Laps>,
}

#[derive(Default)]
struct Laps {
    /// Stages that have begun, the last one last.
    stages: Vec<(&'static str, Duration)>,
    /// Items that have begun.
    items: BTreeMap<String, Duration>,
    times: Times,
}

/// How long work took.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Times {
    /// Each stage, by its name.
    pub stages: BTreeMap<&'static str, Duration>,
    /// Each item of any stage, by its name.
    pub items: BTreeMap<String, Duration>,
}

impl<'a> Timed<'a> {
    /// Takes times and passes everything on.
    pub fn new(watch: &'a dyn Watch) -> Timed<'a> {
        Timed {
            watch,
            laps: Mutex::default(),
        }
    }

    /// The times so far.
    pub fn times(&self) -> Times {
        let laps = self.laps.lock().unwrap_or_else(PoisonError::into_inner);
        laps.times.clone()
    }
}

impl Watch for Timed<'_> {
    fn beneath(&self) -> Option<&dyn Watch> {
        Some(self.watch)
    }

    fn tell(&self, event: Event<'_>) {
        let now = self.watch.elapsed();
        let mut laps = self.laps.lock().unwrap_or_else(PoisonError::into_inner);
        match event {
            Event::Begin(name, _) => laps.stages.push((name, now)),
            Event::End => {
                if let Some((name, since)) = laps.stages.pop() {
                    *laps.times.stages.entry(name).or_default() += now - since;
                }
            }
            Event::ItemBegins(name) => {
                laps.items.insert(name.to_owned(), now);
            }
            Event::ItemEnds(name) => {
                if let Some(since) = laps.items.remove(name) {
                    *laps.times.items.entry(name.to_owned()).or_default() += now - since;
                }
            }
            Event::Done(_) | Event::Note(_) | Event::Reaches(_) | Event::ItemReaches(..) => {}
        }
        drop(laps);
        self.watch.tell(event);
    }
}
