//! Time that work takes on this host: that of the processor, where the system tells it, so that neither
//! threads nor other programs change what is compared.

use std::time::Instant;

/// Clock ticks of `/proc` in a second (`USER_HZ`).
const TICKS: f64 = 100.0;

/// A watch that runs.
pub(crate) struct Watch {
    processor: Option<f64>,
    wall: Instant,
}

impl Watch {
    /// Starts one.
    pub(crate) fn start() -> Watch {
        Watch {
            processor: processor(),
            wall: Instant::now(),
        }
    }

    /// Seconds since then.
    pub(crate) fn seconds(&self) -> f64 {
        match (self.processor, processor()) {
            (Some(from), Some(to)) => (to - from).max(0.5 / TICKS),
            _ => self.wall.elapsed().as_secs_f64(),
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
