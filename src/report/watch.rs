//! `srp watch`: the report again whenever a file is saved, with what got better or worse first. Bounds of IIs are told at
//! once, IIs above them as they are reached, and a search whose files are saved again is ended.

use super::command::{Asked, of_program};
use super::{diff, text};
use crate::cli::{self, Watch};
use crate::failure::Failure;
use crate::{interrupt, talk};
use notify_debouncer_full::notify::{EventKind, RecursiveMode};
use notify_debouncer_full::{DebounceEventResult, DebouncedEvent, new_debouncer};
use srp_archdesc::watch::Event;
use srp_studies::loops::{Options, Report, diff as differences};
use srp_toolchain::{LeastIi, Session};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Writes within this time of each other are one change.
const QUIET: Duration = Duration::from_millis(100);

/// Endings of files that a report can depend on.
const ENDINGS: [&str; 5] = ["c", "h", "xml", "obj", "mtl"];

/// Runs `srp watch`, until it is interrupted.
pub(crate) fn run(args: &Watch) -> Result<i32, Failure> {
    let session = talk::session();
    let machine = &args.of.compilation.machine;
    if !machine.machine.exists() {
        // No file that is saved would mend what is wrong.
        machine.read()?;
    }
    let at_hand = Arc::new(AtHand::default());
    let session = Session {
        watch: &*at_hand,
        ..session
    };
    let (sender, changes) = channel();
    let saved = Arc::clone(&at_hand);
    let took = move |events: DebounceEventResult| {
        if events
            .as_ref()
            .is_ok_and(|events| matter(events).next().is_some())
        {
            saved.is_stale.store(true, Ordering::Relaxed);
        }
        // Nobody hears of changes once the command has ended.
        let _ = sender.send(events);
    };
    let mut watcher = new_debouncer(QUIET, None, took).map_err(Failure::message)?;
    for folder in folders(&args.of) {
        let watched = watcher.watch(&folder, RecursiveMode::NonRecursive);
        watched.map_err(|e| {
            Failure::message(format_args!("cannot watch {}: {e}", folder.display()))
        })?;
    }
    let mut last = show(&args.of, None, &at_hand, &session)?;
    loop {
        interrupt::end_if_requested()?;
        let changed = next(&changes)?;
        let names: Vec<String> = changed.iter().map(|p| p.display().to_string()).collect();
        talk::print(format!("\n{} changed\n", names.join(", ")))?;
        last = show(&args.of, last, &at_hand, &session)?;
    }
}

/// Reports once, beside the last report that there was; gives the last that there is now. Sources that
/// are at fault are told, and watched on.
fn show(
    args: &cli::Reported,
    last: Option<Report>,
    at_hand: &AtHand,
    session: &Session<'_>,
) -> Result<Option<Report>, Failure> {
    let start = Instant::now();
    at_hand.begin(start);
    let asked = Asked {
        options: Options {
            kernel: args.kernel.clone(),
            restrict: true,
            ..Options::default()
        },
        proof: None,
        bounds: Some(&|bounds| {
            at_hand.bound(bounds);
            let line = in_words(bounds, last.as_ref());
            // A line that cannot be printed is missed with the report.
            let _ = talk::print(format!("{line} ({:.2} s)\n", start.elapsed().as_secs_f64()));
        }),
    };
    let made = args
        .compilation
        .machine
        .read()
        .map_err(Failure::from)
        .and_then(|arch| of_program(args, &asked, &arch, session));
    let is_stale = at_hand.is_stale.load(Ordering::Relaxed) && !interrupt::requested();
    let report = match made {
        // What is there now is reported next.
        _ if is_stale => return Ok(last),
        Ok(report) => report,
        Err(Failure::Interrupted) => return Err(Failure::Interrupted),
        Err(Failure::Message(what) | Failure::Usage(what)) => {
            talk::complain(format_args!("error: {what}"));
            return Ok(last);
        }
        Err(Failure::Reported(what)) => {
            talk::complain(what.trim_end());
            return Ok(last);
        }
    };
    let mut out = String::new();
    if let Some(last) = &last {
        out += &diff::text(&differences(last, &report));
    }
    out += &text::brief(&report);
    out += &format!("{:.2} s\n", start.elapsed().as_secs_f64());
    talk::print(out)?;
    Ok(Some(report))
}

/// The report at hand, which the terminal watches. It is stale, and its search ends, when a file has been saved again.
#[derive(Default)]
struct AtHand {
    is_stale: AtomicBool,
    /// When it began, and the loops that have bounds by their names.
    begun: Mutex<(Option<Instant>, BTreeMap<String, Ii>)>,
}

/// The II of a loop in a search.
struct Ii {
    /// The least that there may be.
    least: u32,
    /// The least that was reached.
    reached: u32,
}

impl AtHand {
    fn begin(&self, now: Instant) {
        *self.begun.lock().unwrap_or_else(PoisonError::into_inner) = (Some(now), BTreeMap::new());
        self.is_stale.store(false, Ordering::Relaxed);
    }

    fn bound(&self, bounds: &[LeastIi]) {
        let mut begun = self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        begun.1.extend(bounds.iter().map(|LeastIi { kernel, ii }| {
            let of_loop = Ii {
                least: *ii,
                reached: u32::MAX,
            };
            (kernel.clone(), of_loop)
        }));
    }

    /// A loop has reached an II. Those at their bounds at once have no line.
    fn reaches(&self, name: &str, ii: u32) {
        let mut begun = self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        let (Some(start), loops) = &mut *begun else {
            return;
        };
        if self.is_stale.load(Ordering::Relaxed) {
            return;
        }
        let Some(of_loop) = loops.get_mut(name).filter(|of_loop| ii < of_loop.reached) else {
            return;
        };
        let was_told = of_loop.reached < u32::MAX;
        of_loop.reached = ii;
        let seconds = start.elapsed().as_secs_f64();
        let least = of_loop.least;
        let line = match ii > least {
            true => format!("{name}: II {ii} so far, at least {least} ({seconds:.2} s)\n"),
            false if was_told => format!("{name}: II {ii}, the least ({seconds:.2} s)\n"),
            false => return,
        };
        // A line that cannot be printed is missed with the report.
        let _ = talk::print(line);
    }
}

impl srp_archdesc::Watch for AtHand {
    fn beneath(&self) -> Option<&dyn srp_archdesc::Watch> {
        Some(&talk::CONSOLE)
    }

    fn cancelled(&self) -> bool {
        talk::CONSOLE.cancelled() || self.is_stale.load(Ordering::Relaxed)
    }

    fn is_urgent(&self) -> bool {
        self.cancelled()
    }

    fn tell(&self, event: Event<'_>) {
        if let Event::ItemReaches(name, ii) = event {
            self.reaches(name, ii);
        }
        talk::CONSOLE.tell(event);
    }
}

/// The bounds of IIs in a line, with those of the last report where they are others.
fn in_words(bounds: &[LeastIi], last: Option<&Report>) -> String {
    let before = |kernel: &str| {
        let mut loops = last.iter().flat_map(|report| &report.loops);
        Some(loops.find(|l| l.kernel == kernel)?.bound())
    };
    let mut same = 0;
    let mut words = Vec::new();
    for LeastIi { kernel, ii } in bounds {
        match before(kernel) {
            Some(before) if before == *ii => same += 1,
            Some(before) => words.push(format!("{kernel} {before} → {ii}")),
            None => words.push(format!("{kernel} {ii}")),
        }
    }
    match (words.is_empty(), same) {
        (true, 0) => "no loops on the array".to_owned(),
        (true, _) => "II at least as before".to_owned(),
        (false, 0) => format!("II at least: {}", words.join(", ")),
        (false, same) => format!("II at least: {}, {same} as before", words.join(", ")),
    }
}

/// Waits for the next change of files that matter, and names them.
fn next(changes: &Receiver<DebounceEventResult>) -> Result<BTreeSet<PathBuf>, Failure> {
    loop {
        let events = changes.recv().map_err(Failure::message)?;
        let Ok(events) = events else {
            // What cannot be watched for a moment, such as a file that is just replaced, is seen again.
            continue;
        };
        let found: BTreeSet<PathBuf> = matter(&events).map(shortened).collect();
        if !found.is_empty() {
            return Ok(found);
        }
    }
}

/// The paths of changes that a report can depend on.
fn matter(events: &[DebouncedEvent]) -> impl Iterator<Item = &Path> {
    // A tool that looks at files must not take its own look for a change.
    let changes = (events.iter()).filter(|e| !matches!(e.kind, EventKind::Access(_)));
    let paths = changes.flat_map(|e| &e.paths).map(PathBuf::as_path);
    paths.filter(|path| {
        let ending = path.extension().and_then(|e| e.to_str());
        ending.is_some_and(|ending| ENDINGS.contains(&ending))
    })
}

/// A path as the user would write it, from the current folder.
fn shortened(path: &Path) -> PathBuf {
    let here = std::env::current_dir().ok();
    let inside = here.and_then(|here| path.strip_prefix(here).ok().map(Path::to_owned));
    inside.unwrap_or_else(|| path.to_owned())
}

/// The folders that the files of a report are in.
fn folders(args: &cli::Reported) -> BTreeSet<PathBuf> {
    let source = &args.compilation.source;
    let machine = &args.compilation.machine.machine;
    let scene = args.frame.iter().filter(|name| !name.is_empty());
    let files = (args.files.iter().map(PathBuf::as_path)).chain(scene.map(Path::new));
    let files = files.chain(machine.exists().then_some(machine.as_path()));
    let parents = files.map(|file| match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    });
    parents.chain(source.include.iter().cloned()).collect()
}
