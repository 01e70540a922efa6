//! How long things take on this host.

use crate::talk::CONSOLE;
use srp_archdesc::watch::{Event, Watch};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Times of named things, which may overlap and come again.
/// It watches work for the terminal, and takes the time of its items.
#[derive(Default)]
pub(crate) struct Stopwatch(Mutex<BTreeMap<String, Lap>>);

/// The time of one of them.
#[derive(Default)]
struct Lap {
    before: Duration,
    started: Option<Instant>,
}

impl Watch for Stopwatch {
    fn cancelled(&self) -> bool {
        CONSOLE.cancelled()
    }

    fn tell(&self, event: Event<'_>) {
        match event {
            Event::ItemBegins(name) => self.start(name),
            Event::ItemEnds(name) => self.stop(name),
            event => CONSOLE.tell(event),
        }
    }

    fn elapsed(&self) -> Duration {
        CONSOLE.elapsed()
    }
}

impl Stopwatch {
    /// Starts the time of `name`, which goes on from where it stopped.
    fn start(&self, name: &str) {
        self.with(name, |lap| lap.started = Some(Instant::now()));
    }

    /// Stops the time of `name`.
    fn stop(&self, name: &str) {
        self.with(name, |lap| {
            lap.before += lap.started.take().map_or(Duration::ZERO, |s| s.elapsed());
        });
    }

    fn with(&self, name: &str, change: impl FnOnce(&mut Lap)) {
        let mut laps = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        change(laps.entry(name.to_owned()).or_default());
    }

    /// All times.
    pub(crate) fn times(&self) -> BTreeMap<String, Duration> {
        let laps = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let time = |(name, lap): (&String, &Lap)| (name.clone(), lap.before);
        laps.iter().map(time).collect()
    }
}
