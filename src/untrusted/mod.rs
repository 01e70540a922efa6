//! `--untrusted`: inputs are a stranger's, and the work on them is confined.
//!
//! The command starts itself again, as a process that first gives up what it does not need: rights to files outside
//! the folders of those that the command line names, all calls of the kernel but a few, memory and time beyond the
//! limits. This process, the guard, takes what the other prints, and says what happened if it dies.

#[cfg(target_os = "linux")]
mod calls;
#[cfg(target_os = "linux")]
mod guard;
mod rooms;
#[cfg(target_os = "linux")]
mod sandbox;

pub(crate) use rooms::Rooms;

use crate::cli::{Command, Sweep};
use crate::failure::Failure;
use crate::limits::{self, Limits};
use srp_toolchain::files::{self, Confines};
use std::ffi::{OsStr, OsString};

/// The first argument of a confined process.
const CONFINED: &str = "--confined";

#[cfg(not(target_os = "linux"))]
const NO_SANDBOX: &str = "--untrusted needs Linux, whose Landlock and seccomp confine the work";

/// The arguments of this process, and true if it is to confine itself.
pub(crate) fn arguments() -> (Vec<OsString>, bool) {
    let mut arguments: Vec<OsString> = std::env::args_os().collect();
    let is_confined = (arguments.get(1)).is_some_and(|a| a == OsStr::new(CONFINED));
    if is_confined {
        arguments.remove(1);
    }
    (arguments, is_confined)
}

/// Does the work of a command line in a confined process; that process's status.
pub(crate) fn guard(
    command: Option<&Command>,
    matches: &clap::ArgMatches,
    limits: &Limits,
    rooms: &mut Rooms,
) -> Result<i32, Failure> {
    suits(command)?;
    if let Some(threads) = rooms::asked_threads(matches)
        && threads as u64 > limits.threads
    {
        return Err(Failure::usage(format_args!(
            "--threads {threads} is more than threads={} of --untrusted",
            limits.threads
        )));
    }
    let made = rooms.make()?;
    #[cfg(target_os = "linux")]
    let status = guard::run(limits, rooms);
    #[cfg(not(target_os = "linux"))]
    let status = Err(Failure::message(NO_SANDBOX));
    for folder in made {
        // One that has something in it by now stays.
        let _ = std::fs::remove_dir(folder);
    }
    status
}

/// Confines this process from now on.
pub(crate) fn confine(limits: &Limits, rooms: &Rooms) -> Result<(), Failure> {
    limits::keep_to(limits);
    files::confine(Confines {
        readable: rooms.read.clone(),
        writable: rooms.write.clone(),
        files: limits.files,
        read: limits.read,
        written: limits.written,
        memory: limits.memory,
    });
    #[cfg(target_os = "linux")]
    return sandbox::enter(limits, rooms);
    #[cfg(not(target_os = "linux"))]
    Err(Failure::message(NO_SANDBOX))
}

/// Refuses commands whose work is to start others, or to go on for ever.
fn suits(command: Option<&Command>) -> Result<(), Failure> {
    let why = match command {
        Some(Command::Watch(_)) => "srp watch goes on for ever",
        Some(Command::HardCases(_)) => "srp hard-cases starts the host's C compiler",
        Some(Command::Cache(_)) => "srp cache is about what others have left",
        Some(Command::Sweep(sweep)) if !is_local(sweep) => {
            "only --engine local measures in this process"
        }
        Some(Command::Render(args)) if args.sharing.share.is_some() => SHARED,
        Some(Command::Paper(args)) if args.sharing.share.is_some() => SHARED,
        Some(Command::Accuracy(args)) if args.sharing.share.is_some() => SHARED,
        Some(Command::Render(args)) if args.checkpoints.restore.is_some() => CHECKPOINT,
        Some(Command::Run(args)) if args.checkpoints.restore.is_some() => CHECKPOINT,
        _ => return Ok(()),
    };
    Err(Failure::usage(format_args!("{why}: leave --untrusted out")))
}

/// Why work is not shared.
const SHARED: &str = "--share believes what other processes have left in its folder";

/// Why nothing goes on from a checkpoint.
const CHECKPOINT: &str = "--restore believes its file, which says all of a simulator's state";

fn is_local(sweep: &Sweep) -> bool {
    sweep.engine == "local"
}
