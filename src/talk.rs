//! Talk: what goes to standard error while a command works. Data goes to standard output.

use crate::{interrupt, limits};
use cpu_time::ThreadTime;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use srp_archdesc::diagnostic::Messages;
use srp_archdesc::watch::{Event, Watch};
use srp_toolchain::engine::Shares;
use srp_toolchain::files::FileError;
use srp_toolchain::{Engines, Session};
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// When messages are coloured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Colour {
    /// Where that is of use.
    Auto,
    /// Everywhere.
    Always,
    /// Nowhere.
    Never,
}

/// How much is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Volume {
    /// Errors and warnings only.
    Quiet,
    /// Notes too.
    Usual,
    /// Also how long each stage of the work took.
    Verbose,
}

/// How the command line wants to be talked to.
static MANNER: OnceLock<(Colour, Volume)> = OnceLock::new();

/// Talks in this manner from now on.
pub(crate) fn set_manner(colour: Colour, volume: Volume) {
    // There is one command line, and it is read once.
    let _ = MANNER.set((colour, volume));
}

fn is(volume: Volume) -> bool {
    MANNER.get().is_some_and(|(_, asked)| *asked == volume)
}

fn is_quiet() -> bool {
    is(Volume::Quiet)
}

/// True if messages are coloured: as `--color` says, else by the environment, else on a terminal.
pub(crate) fn colour() -> bool {
    let wish = MANNER.get().map_or(Colour::Auto, |(colour, _)| *colour);
    let set = |name| std::env::var_os(name).filter(|value| !value.is_empty());
    match wish {
        Colour::Always => true,
        Colour::Never => false,
        Colour::Auto if set("NO_COLOR").is_some() => false,
        Colour::Auto if set("CLICOLOR_FORCE").is_some_and(|value| value != "0") => true,
        Colour::Auto => io::stderr().is_terminal(),
    }
}

/// A line to standard error, unless only errors are wanted. Where that cannot be written there is nobody to tell.
pub(crate) fn say(text: impl std::fmt::Display) {
    if !is_quiet() {
        complain(text);
    }
}

/// A line about an error or a doubt to standard error.
pub(crate) fn complain(text: impl std::fmt::Display) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Text that has its own line ends, if any, to standard error.
pub(crate) fn say_all(text: &str) {
    let _ = write!(io::stderr(), "{text}");
}

/// Messages that stop nothing.
pub(crate) fn warn(messages: &Messages) {
    if !messages.diagnostics.is_empty() {
        say_all(&messages.render(colour()));
    }
}

/// A part of the data to standard output.
pub(crate) fn print_part(data: &[u8]) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(data)?;
    out.flush()
}

/// Data to standard output; a reader that has gone away is no error.
pub(crate) fn print(data: impl AsRef<[u8]>) -> Result<(), FileError> {
    match print_part(data.as_ref()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(FileError::writing(Path::new("standard output"), e))
        }
        _ => Ok(()),
    }
}

/// The bar on the terminal; there is one at a time.
static BAR: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Clears the progress bar from the terminal.
pub(crate) fn clear() {
    if let Some(bar) = BAR.lock().unwrap_or_else(PoisonError::into_inner).take() {
        bar.finish_and_clear();
    }
}

/// A progress bar on a terminal, nothing in a pipe. Clears itself when it goes out of scope.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// Progress towards a known number of steps.
    pub(crate) fn steps(what: &'static str, total: u64) -> Progress {
        let style = "{msg:>12} [{bar:32}] {pos}/{len} {elapsed} {prefix}";
        Progress::new(what, Some(total), style)
    }

    /// Work of unknown length.
    pub(crate) fn spinner(what: &'static str) -> Progress {
        Progress::new(what, None, "{msg:>12} {spinner} {elapsed}")
    }

    fn new(what: &'static str, total: Option<u64>, style: &str) -> Progress {
        let target = if io::stderr().is_terminal() && !is_quiet() {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(total, target);
        let style = ProgressStyle::with_template(style).expect("the template is well-formed");
        bar.set_style(style.progress_chars("=> "));
        bar.set_message(what);
        bar.enable_steady_tick(Duration::from_millis(120));
        *BAR.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar.clone());
        Progress(bar)
    }

    /// An item of the work is begun.
    fn begins(&self, item: &str) {
        self.0.set_prefix(item.to_owned());
    }

    /// So many steps are done.
    pub(crate) fn at(&self, done: u64) {
        self.0.set_position(done);
    }
}

/// The terminal watches work: it shows a bar for the outermost stage, and Ctrl-C ends the work.
pub(crate) struct Console {
    start: OnceLock<Instant>,
    stages: Mutex<Vec<Running>>,
}

/// A stage that has begun.
struct Running {
    name: &'static str,
    begun: Instant,
    /// The bar of the outermost one, and the steps that are done.
    bar: Option<(Progress, u64)>,
}

/// A session that the terminal watches, with the user's cache.
pub(crate) fn session() -> Session<'static> {
    let session = Session::new(&CONSOLE).with_cache(limits::cache());
    let may_start = limits::may_start();
    Session {
        threads: session.threads.min(limits::threads()),
        outside: limits::outside(),
        builder: std::env::current_exe().ok().filter(|_| may_start),
        compiles: may_start,
        cycles: limits::cycles(),
        ..session
    }
}

/// Says which engine has simulated how much, where a simulator has taken over from the interpreter.
pub(crate) fn say_shares(engines: &Engines) {
    let Some(Shares {
        interpreted,
        generated,
    }) = engines.shares()
    else {
        return;
    };
    if generated > 0 {
        say(format_args!(
            "{interpreted} cycles of all cores were interpreted, then {generated} run by a simulator \
             compiled meanwhile"
        ));
    }
}

/// The one terminal.
pub(crate) static CONSOLE: Console = Console {
    start: OnceLock::new(),
    stages: Mutex::new(Vec::new()),
};

impl Watch for Console {
    fn cancelled(&self) -> bool {
        interrupt::requested()
    }

    fn is_urgent(&self) -> bool {
        interrupt::requested()
    }

    fn tell(&self, event: Event<'_>) {
        let mut stages = self.stages.lock().unwrap_or_else(PoisonError::into_inner);
        match event {
            Event::Begin(name, steps) => {
                let bar = || match steps {
                    Some(steps) => Progress::steps(name, steps),
                    None => Progress::spinner(name),
                };
                let bar = stages.is_empty().then(|| (bar(), 0));
                let begun = Instant::now();
                stages.push(Running { name, begun, bar });
            }
            Event::Done(steps) => {
                if let Some((bar, done)) = stages.last_mut().and_then(|s| s.bar.as_mut()) {
                    *done += steps;
                    bar.at(*done);
                }
            }
            Event::End => {
                if let Some(stage) = stages.pop() {
                    let (name, begun) = (stage.name, stage.begun);
                    // The bar leaves the terminal first.
                    drop(stage);
                    if is(Volume::Verbose) {
                        let indent = "  ".repeat(stages.len());
                        let seconds = begun.elapsed().as_secs_f64();
                        say(format_args!("{indent}{name}: {seconds:.3} s"));
                    }
                }
            }
            Event::ItemBegins(item) => {
                if let Some((bar, _)) = stages.last().and_then(|s| s.bar.as_ref()) {
                    bar.begins(item);
                }
            }
            Event::ItemReaches(item, ii) => {
                if let Some((bar, _)) = stages.last().and_then(|s| s.bar.as_ref()) {
                    bar.begins(&format!("{item} at II {ii}"));
                }
            }
            Event::ItemEnds(_) | Event::Reaches(_) => {}
            Event::Note(note) => say(note),
        }
    }

    fn elapsed(&self) -> Duration {
        self.start.get_or_init(Instant::now).elapsed()
    }

    fn worked(&self) -> Duration {
        ThreadTime::now().as_duration()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        clear();
    }
}
