//! The process that starts the confined one, takes what it prints, and outlives it.

use super::{CONFINED, Rooms};
use crate::failure::Failure;
use crate::limits::Limits;
use crate::talk;
use rustix::process::{Pid, Signal, kill_process};
use srp_toolchain::amount;
use srp_toolchain::cache::Place;
use srp_toolchain::files;
use std::io::{self, Read, Write};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// How the confined process ended.
enum End {
    /// By itself, or by a signal that it was not sent here.
    Itself(ExitStatus),
    /// It printed too much.
    Flooded,
    /// It took too long.
    Late,
}

/// True if the user has asked for an end.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Does the work of this command line in a confined process; its status.
pub(super) fn run(limits: &Limits, rooms: &Rooms) -> Result<i32, Failure> {
    // Without a handler Ctrl-C ends this process, and the other with it.
    let _ = ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::Relaxed));
    let mut child = start().map_err(|why| {
        Failure::message(format_args!("--untrusted cannot start the work: {why}"))
    })?;
    let process = child.id();
    let end = attend(&mut child, limits)
        .map_err(|why| Failure::message(format_args!("--untrusted has lost the work: {why}")))?;
    for folder in &rooms.write {
        files::remove_parts(folder, process);
    }
    let why = match end {
        End::Itself(status) => match (status.code(), status.signal()) {
            (Some(code), _) => return Ok(code),
            (None, signal) => of_signal(signal.unwrap_or(0), limits),
        },
        End::Flooded => format!(
            "it printed more than output={} allows",
            amount::of_bytes(limits.output)
        ),
        End::Late => format!("it took more than elapsed={} seconds", limits.elapsed),
    };
    Err(Failure::message(format_args!(
        "the work was ended: {why} (docs/reliability.md tells of --untrusted)"
    )))
}

/// What a signal says of work that it has ended.
fn of_signal(signal: i32, limits: &Limits) -> String {
    let memory = amount::of_bytes(limits.memory);
    match Signal::from_named_raw(signal) {
        Some(Signal::XCPU) => format!(
            "it took more than seconds={} of processor time",
            limits.seconds
        ),
        Some(Signal::XFSZ) => format!(
            "it wrote a file of more than written={}",
            amount::of_bytes(limits.written)
        ),
        Some(Signal::ABORT) => format!("it aborted, as it does without memory (memory={memory}) or stack"),
        Some(Signal::KILL) => {
            "it was killed by the host or by somebody else; the host kills what takes more memory than it has".to_owned()
        }
        Some(Signal::SEGV | Signal::BUS | Signal::ILL) => format!("it crashed (signal {signal})"),
        _ => format!("signal {signal}"),
    }
}

/// Starts this program again, with few variables, in a group of its own: a Ctrl-C comes to this process.
fn start() -> io::Result<Child> {
    let mut command = Command::new(std::env::current_exe()?);
    command.arg(CONFINED).args(std::env::args_os().skip(1));
    command.env_clear();
    let colour = match talk::colour() {
        true => "CLICOLOR_FORCE",
        false => "NO_COLOR",
    };
    command.env(colour, "1");
    if let Place::Folder(cache) = Place::of_user() {
        command.env("SRP_CACHE", cache);
    }
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command.process_group(0).spawn()
}

/// Passes on what a process prints until it ends, or ends it where it goes too far.
fn attend(child: &mut Child, limits: &Limits) -> io::Result<End> {
    let out = child.stdout.take();
    let errors = child.stderr.take();
    let printed = AtomicU64::new(0);
    let is_flooded = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let pass = |from: &mut dyn Read, to: &mut dyn Write| {
            pass_on(from, to, &printed, limits.output, &is_flooded);
        };
        if let Some(mut out) = out {
            scope.spawn(move || pass(&mut out, &mut io::stdout()));
        }
        if let Some(mut errors) = errors {
            scope.spawn(move || pass(&mut errors, &mut io::stderr()));
        }
        let result = watch(child, limits, &is_flooded);
        if result.is_err() {
            // The pipes close with it, and with them the threads end.
            let _ = child.kill();
        }
        result
    })
}

/// The longest time between two looks at a process.
const LOOK: Duration = Duration::from_millis(20);

fn watch(child: &mut Child, limits: &Limits, is_flooded: &AtomicBool) -> io::Result<End> {
    let start = Instant::now();
    let mut pause = Duration::from_millis(1);
    let mut interrupts = false;
    loop {
        if let Some(status) = child.try_wait()? {
            // It may have been sent the signal of a reader that has gone away.
            return Ok(match is_flooded.load(Ordering::Relaxed) {
                true => End::Flooded,
                false => End::Itself(status),
            });
        }
        let is_late = start.elapsed() > Duration::from_secs(limits.elapsed);
        if is_flooded.load(Ordering::Relaxed) || is_late {
            child.kill()?;
            child.wait()?;
            return Ok(match is_late {
                true => End::Late,
                false => End::Flooded,
            });
        }
        if INTERRUPTED.swap(false, Ordering::Relaxed) {
            let process = Pid::from_raw(child.id() as i32);
            // The second time it may be deaf.
            let signal = if interrupts {
                Signal::KILL
            } else {
                Signal::INT
            };
            interrupts = true;
            if let Some(process) = process {
                kill_process(process, signal)?;
            }
        }
        std::thread::sleep(pause);
        pause = (pause * 2).min(LOOK);
    }
}

/// Passes on bytes until there are no more, or too many.
fn pass_on(
    from: &mut dyn Read,
    to: &mut dyn Write,
    printed: &AtomicU64,
    most: u64,
    is_flooded: &AtomicBool,
) {
    let mut bytes = vec![0; 1 << 16];
    loop {
        let count = match from.read(&mut bytes) {
            Ok(0) => return,
            Ok(count) => count,
            Err(why) if why.kind() == io::ErrorKind::Interrupted => continue,
            Err(_) => return,
        };
        let before = printed.fetch_add(count as u64, Ordering::Relaxed);
        let left = most.saturating_sub(before).min(count as u64) as usize;
        // Where the reader has gone away, this end of the pipe goes too, and the work hears of it.
        if to
            .write_all(&bytes[..left])
            .and_then(|()| to.flush())
            .is_err()
        {
            return;
        }
        if left < count {
            is_flooded.store(true, Ordering::Relaxed);
            return;
        }
    }
}
