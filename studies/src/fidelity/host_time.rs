//! Time that work takes on this host: on the wall, and of the processor, where the system tells it, which
//! other programs do not change.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use srp_archdesc::watch::Watch;
use std::time::Duration;

/// Clock ticks of `/proc` in a second (`USER_HZ`).
const TICKS: f64 = 100.0;

/// When work began.
pub(super) struct Start<'a> {
    watch: &'a dyn Watch,
    processor: Option<f64>,
    wall: Duration,
}

/// Host time of a piece of work.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
pub struct HostTime {
    /// Seconds on the wall.
    pub seconds: f64,
    /// Seconds of the processor, of all threads together.
    pub processor: Option<f64>,
}

impl<'a> Start<'a> {
    /// Work that begins now.
    pub(super) fn now(watch: &'a dyn Watch) -> Start<'a> {
        Start {
            watch,
            processor: processor(),
            wall: watch.elapsed(),
        }
    }

    /// Returns the time taken since then.
    pub(super) fn taken(&self) -> HostTime {
        let processor = processor().zip(self.processor);
        HostTime {
            seconds: (self.watch.elapsed() - self.wall).as_secs_f64(),
            processor: processor.map(|(to, from)| to - from),
        }
    }
}

/// Seconds of the processor that all threads of this process have had, as Linux tells them.
fn processor() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The name, in brackets, may have blanks in it; user and system time are fields 14 and 15.
    let mut fields = text.rsplit_once(')')?.1.split_whitespace().skip(11);
    let user: f64 = fields.next()?.parse().ok()?;
    let system: f64 = fields.next()?.parse().ok()?;
    Some((user + system) / TICKS)
}
