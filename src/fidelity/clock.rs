//! Time that work takes on this host: that of a clock on the wall, and that of the processor, where the system
//! tells it, which other programs do not change.

use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Clock ticks of `/proc` in a second (`USER_HZ`).
const TICKS: f64 = 100.0;

/// A watch that runs.
pub(crate) struct Watch {
    processor: Option<f64>,
    wall: Instant,
}

/// What work took.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Took {
    /// Seconds on the wall.
    pub(crate) seconds: f64,
    /// Seconds of the processor, of all threads together.
    pub(crate) processor: Option<f64>,
}

impl Watch {
    /// Starts one.
    pub(crate) fn start() -> Watch {
        Watch {
            processor: processor(),
            wall: Instant::now(),
        }
    }

    /// What was taken since then.
    pub(crate) fn took(&self) -> Took {
        let processor = processor().zip(self.processor);
        Took {
            seconds: self.wall.elapsed().as_secs_f64(),
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
