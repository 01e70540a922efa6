//! Talk: what goes to standard error while a command works. Data goes to standard output.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Whether messages may be coloured: a terminal, and no `NO_COLOR`.
pub(crate) fn colour() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
}

/// Makes Ctrl-C ask for an end, which long work looks for; a second one ends at once.
pub(crate) fn catch_interrupts() {
    // Without a handler Ctrl-C still ends the program, so failing to set one is no error.
    let _ = ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
}

/// Whether the user has asked for an end.
pub(crate) fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// A progress bar on a terminal, nothing in a pipe. Clears itself when it goes out of scope.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// Progress towards a known number of steps.
    pub(crate) fn steps(what: &'static str, total: u64) -> Progress {
        let style = "{msg:>12} [{bar:32}] {pos}/{len} {elapsed}";
        Progress::new(what, Some(total), style)
    }

    /// Work of unknown length.
    pub(crate) fn spinner(what: &'static str) -> Progress {
        let progress = Progress::new(what, None, "{msg:>12} {spinner} {elapsed}");
        progress
            .0
            .enable_steady_tick(std::time::Duration::from_millis(120));
        progress
    }

    fn new(what: &'static str, total: Option<u64>, style: &str) -> Progress {
        let target = if std::io::stderr().is_terminal() {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(total, target);
        let style = ProgressStyle::with_template(style).expect("the template is well-formed");
        bar.set_style(style.progress_chars("=> "));
        bar.set_message(what);
        Progress(bar)
    }

    /// So many steps are done.
    pub(crate) fn at(&self, done: u64) {
        self.0.set_position(done);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
