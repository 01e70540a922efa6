//! The limits of confined work (`--untrusted`): their names, their defaults, how they are written, and what this process
//! makes of its own.

use srp_toolchain::amount;
use srp_toolchain::cache::{Cache, Place};
use srp_toolchain::files::Outside;
use std::sync::OnceLock;

/// How much work on a stranger's input may take.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Limits {
    /// Bytes of memory, beside the program itself.
    pub(crate) memory: u64,
    /// Seconds of processor time, of all threads together.
    pub(crate) seconds: u64,
    /// Seconds by the clock.
    pub(crate) elapsed: u64,
    /// Threads that work.
    pub(crate) threads: u64,
    /// Files that are read.
    pub(crate) files: u64,
    /// Bytes that are read.
    pub(crate) read: u64,
    /// Bytes that are written to files.
    pub(crate) written: u64,
    /// Bytes that are printed.
    pub(crate) output: u64,
    /// Cycles of a program or a frame.
    pub(crate) cycles: u64,
    /// False if the kernel need not have Landlock.
    pub(crate) landlock: bool,
}

const MIB: u64 = 1 << 20;
const GIB: u64 = 1 << 30;

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            memory: 4 * GIB,
            seconds: 60,
            elapsed: 300,
            threads: 4,
            files: 1000,
            read: GIB,
            written: 256 * MIB,
            output: 64 * MIB,
            cycles: 10_000_000_000,
            landlock: true,
        }
    }
}

/// A limit: its name, the least that makes sense, the most that the kernel can count, and its place.
type Row = (&'static str, u64, u64, fn(&mut Limits) -> &mut u64);

/// No process has more.
const MOST: u64 = 1 << 46;

/// The most seconds: a year is as good as for ever.
const YEAR: u64 = 365 * 24 * 3600;

const TABLE: [Row; 9] = [
    ("memory", 64 * MIB, MOST, |l| &mut l.memory),
    ("seconds", 1, YEAR, |l| &mut l.seconds),
    ("elapsed", 1, YEAR, |l| &mut l.elapsed),
    ("threads", 1, 256, |l| &mut l.threads),
    ("files", 1, MOST, |l| &mut l.files),
    ("read", 1, MOST, |l| &mut l.read),
    ("written", 1, MOST, |l| &mut l.written),
    ("output", 1, MOST, |l| &mut l.output),
    ("cycles", 1, u64::MAX, |l| &mut l.cycles),
];

/// The wish that does without Landlock.
const NO_LANDLOCK: &str = "no-landlock";

impl Limits {
    /// Limits as the command line has them: `NAME=NUMBER` and `no-landlock`, with commas between; what is not said
    /// is as by default.
    pub(crate) fn parse(text: &str) -> Result<Limits, String> {
        let mut limits = Limits::default();
        for wish in text.split(',').filter(|wish| !wish.is_empty()) {
            if wish == NO_LANDLOCK {
                limits.landlock = false;
                continue;
            }
            let (name, number) = wish.split_once('=').unwrap_or((wish, ""));
            let row = TABLE.iter().find(|(known, ..)| *known == name);
            let Some((_, least, most, place)) = row else {
                let names: Vec<&str> = TABLE.iter().map(|row| row.0).collect();
                return Err(format!(
                    "`{wish}` is no limit: write NAME=NUMBER of {}, or {NO_LANDLOCK}",
                    names.join(", ")
                ));
            };
            let number = amount::parse(number).filter(|n| (least..=most).contains(&n));
            *place(&mut limits) = number.ok_or_else(|| {
                format!(
                    "`{wish}`: write a number from {least} to {most}, such as 2000, 2e3, 500M or 2G"
                )
            })?;
        }
        Ok(limits)
    }
}

/// The limits of this process, where it is confined.
static LIMITS: OnceLock<Limits> = OnceLock::new();

/// From now on this process keeps to these limits.
pub(crate) fn keep_to(limits: &Limits) {
    // There is one command line.
    let _ = LIMITS.set(limits.clone());
}

/// What is done about files that other files name elsewhere.
pub(crate) fn outside() -> Outside {
    match LIMITS.get() {
        Some(_) => Outside::Refused,
        None => Outside::Told,
    }
}

/// True if this process may start others.
pub(crate) fn may_start() -> bool {
    LIMITS.get().is_none()
}

/// The most cycles that are simulated.
pub(crate) fn cycles() -> u64 {
    LIMITS.get().map_or(u64::MAX, |limits| limits.cycles)
}

/// The most threads.
pub(crate) fn threads() -> usize {
    LIMITS
        .get()
        .map_or(usize::MAX, |limits| limits.threads as usize)
}

/// The user's cache; one that is confined takes from it and puts nothing into it.
pub(crate) fn cache() -> Cache {
    match (LIMITS.get(), Place::of_user()) {
        (None, place) => Cache::at(place),
        (Some(_), Place::Folder(folder)) => Cache::at(Place::ReadOnly(folder)),
        (Some(_), _) => Cache::in_memory(),
    }
}

/// Refuses work that takes more memory than there may be, before it is begun.
///
/// # Errors
///
/// A sentence that says so.
pub(crate) fn fits(what: impl std::fmt::Display, bytes: u64) -> Result<(), String> {
    match LIMITS.get() {
        Some(limits) if bytes > limits.memory => Err(format!(
            "{what} takes {} MiB or more: more than memory={} of --untrusted",
            bytes >> 20,
            amount::of_bytes(limits.memory)
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_and_refused() {
        assert_eq!(Limits::parse(""), Ok(Limits::default()));
        let limits =
            Limits::parse("memory=2G,seconds=7,cycles=1e9,no-landlock").expect("it is right");
        let wanted = Limits {
            memory: 2 * GIB,
            seconds: 7,
            cycles: 1_000_000_000,
            landlock: false,
            ..Limits::default()
        };
        assert_eq!(limits, wanted);
        for wrong in [
            "memory",
            "memory=",
            "memory=1",
            "memory=2T",
            "seconds=0",
            "cycles=1e99",
            "speed=1",
            "threads=-1",
            "threads=1.5",
            "memory=99999999999999999999G",
            "landlock",
        ] {
            assert!(Limits::parse(wrong).is_err(), "{wrong}");
        }
    }

    /// The page has the limits and their defaults.
    #[test]
    fn limits_are_documented() {
        let page = include_str!("../docs/reliability.md");
        for (name, _, _, place) in TABLE {
            let number = *place(&mut Limits::default());
            let number = match name {
                "memory" | "read" | "written" | "output" => amount::of_bytes(number),
                "cycles" => "1e10".to_owned(),
                _ => number.to_string(),
            };
            let row = format!("| `{name}={number}` |");
            assert!(page.contains(&row), "{row}");
        }
    }
}
