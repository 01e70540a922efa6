//! Ctrl-C: the command prints what is known so far, leaves no half-written file, and ends with
//! status 130.

use crate::failure::Failure;
use crate::talk;
use srp_toolchain::files;
use std::sync::atomic::{AtomicBool, Ordering};

/// The exit status of a command that was interrupted.
pub(crate) const STATUS: u8 = 130;

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// True if the work at hand looks for an interrupt, and ends by itself.
static LOOKED_FOR: AtomicBool = AtomicBool::new(false);

/// From now on Ctrl-C is answered.
pub(crate) fn catch() {
    // Without a handler Ctrl-C still ends the program, so failing to set one is no error.
    let _ = ctrlc::set_handler(answer);
}

/// True if the user has asked for an end.
pub(crate) fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}

/// Takes an interrupt as answered: work that is asked for later begins anew.
pub(crate) fn forget() {
    REQUESTED.store(false, Ordering::Relaxed);
}

/// Does work that looks for an interrupt with [`requested`]; a second interrupt ends it at once.
pub(crate) fn looked_for<R>(work: impl FnOnce() -> R) -> R {
    LOOKED_FOR.store(true, Ordering::Relaxed);
    let result = work();
    LOOKED_FOR.store(false, Ordering::Relaxed);
    result
}

/// Ends a command that was interrupted, now that it has said what it knows.
pub(crate) fn end_if_requested() -> Result<(), Failure> {
    match requested() {
        true => Err(Failure::Interrupted),
        false => Ok(()),
    }
}

fn answer() {
    let again = REQUESTED.swap(true, Ordering::Relaxed);
    if LOOKED_FOR.load(Ordering::Relaxed) && !again {
        return;
    }
    let _no_file_is_being_written = files::writing();
    talk::clear();
    talk::say("interrupted");
    std::process::exit(i32::from(STATUS));
}
