//! [`Watch`]: the interface through which long work tells its progress, and learns that it is to end.
//!
//! Work names its stages and counts their steps; the watcher shows them, measures them, or ignores them. A
//! stage may begin within another, and items of a stage may run side by side. Watching changes no result,
//! except that cancelled work returns what it has by then.

use std::time::Duration;

/// A watcher of work. [`Unwatched`] ignores everything.
pub trait Watch: Sync {
    /// The watch that answers and hears what this one does not.
    fn beneath(&self) -> Option<&dyn Watch> {
        None
    }

    /// True if the work is to end soon, with the results that it has.
    fn cancelled(&self) -> bool {
        self.beneath().is_some_and(Watch::cancelled)
    }

    /// True if work that is to end soon and has no result yet is not to make a poor one instead.
    fn is_urgent(&self) -> bool {
        self.beneath().is_some_and(Watch::is_urgent)
    }

    /// Takes notice of an event.
    fn tell(&self, event: Event<'_>) {
        if let Some(watch) = self.beneath() {
            watch.tell(event);
        }
    }

    /// Takes what a simulated program has printed since the last time. True if it is taken; else it is kept for the
    /// program's end.
    fn printed(&self, bytes: &[u8]) -> bool {
        self.beneath().is_some_and(|watch| watch.printed(bytes))
    }

    /// The time since some moment before the work began. Budgets of time use it: with a watcher that does
    /// not measure time, a budget never ends.
    fn elapsed(&self) -> Duration {
        self.beneath().map_or(Duration::ZERO, Watch::elapsed)
    }

    /// The processor time that this thread has taken. Budgets of work use it, so that other work on the host does
    /// not use them up. A watcher that does not measure it gives the [time](Self::elapsed).
    fn worked(&self) -> Duration {
        self.beneath().map_or_else(|| self.elapsed(), Watch::worked)
    }
}

/// An event of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event<'a> {
    /// A stage begins, with the number of its steps if that is known.
    Begin(&'static str, Option<u64>),
    /// This many more steps of the stage that began last are done.
    Done(u64),
    /// The stage that began last has ended.
    End,
    /// An item of the stage, such as a loop by its name, is begun.
    ItemBegins(&'a str),
    /// The item is done.
    ItemEnds(&'a str),
    /// The loop has a schedule at this II now.
    Reaches(u32),
    /// The item, which is a loop, has one.
    ItemReaches(&'a str, u32),
    /// A remark for the user, one line or several.
    Note(&'a str),
}

/// A watcher that ignores everything.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl Watch for Unwatched {}

/// A stage of work, from its beginning until this is dropped.
pub struct Stage<'a> {
    watch: &'a dyn Watch,
}

impl<'a> Stage<'a> {
    /// Begins a stage with this number of steps.
    pub fn of(watch: &'a dyn Watch, name: &'static str, steps: u64) -> Stage<'a> {
        watch.tell(Event::Begin(name, Some(steps)));
        Stage { watch }
    }

    /// Begins a stage with an unknown number of steps.
    pub fn unknown(watch: &'a dyn Watch, name: &'static str) -> Stage<'a> {
        watch.tell(Event::Begin(name, None));
        Stage { watch }
    }

    /// So many more steps are done.
    pub fn done(&self, steps: u64) {
        self.watch.tell(Event::Done(steps));
    }
}

impl Drop for Stage<'_> {
    fn drop(&mut self) {
        self.watch.tell(Event::End);
    }
}

/// The watch of an item: it hears what the item reaches with its name.
pub struct Named<'a> {
    watch: &'a dyn Watch,
    item: &'a str,
}

impl<'a> Named<'a> {
    /// Names an item to a watch.
    pub fn new(watch: &'a dyn Watch, item: &'a str) -> Named<'a> {
        Named { watch, item }
    }
}

impl Watch for Named<'_> {
    fn beneath(&self) -> Option<&dyn Watch> {
        Some(self.watch)
    }

    fn tell(&self, event: Event<'_>) {
        self.watch.tell(match event {
            Event::Reaches(ii) => Event::ItemReaches(self.item, ii),
            event => event,
        });
    }
}

/// The same watch, which hears of notes only: for work that runs beside other work of one stage, whose stages and
/// items would be taken for each other's.
pub struct Unstaged<'a>(&'a dyn Watch);

impl<'a> Unstaged<'a> {
    /// Hides all but notes from a watch.
    pub fn new(watch: &'a dyn Watch) -> Unstaged<'a> {
        Unstaged(watch)
    }
}

impl Watch for Unstaged<'_> {
    fn beneath(&self) -> Option<&dyn Watch> {
        Some(self.0)
    }

    fn tell(&self, event: Event<'_>) {
        if let Event::Note(_) = event {
            self.0.tell(event);
        }
    }
}

/// The same watch, whose work also ends when a time is over.
pub struct Limited<'a> {
    watch: &'a dyn Watch,
    until: Duration,
}

impl<'a> Limited<'a> {
    /// Ends the work once so much more time has [gone by](Watch::elapsed).
    pub fn new(watch: &'a dyn Watch, time: Duration) -> Limited<'a> {
        let until = watch.elapsed().saturating_add(time);
        Limited { watch, until }
    }
}

impl Watch for Limited<'_> {
    fn beneath(&self) -> Option<&dyn Watch> {
        Some(self.watch)
    }

    fn cancelled(&self) -> bool {
        self.watch.cancelled() || self.watch.elapsed() >= self.until
    }
}

/// The same watch for work of one thread, which also ends when the thread has worked for so long.
pub struct Worked<'a> {
    watch: &'a dyn Watch,
    until: Duration,
}

impl<'a> Worked<'a> {
    /// Ends the work once this thread has [worked](Watch::worked) for so much longer.
    pub fn new(watch: &'a dyn Watch, time: Duration) -> Worked<'a> {
        let until = watch.worked().saturating_add(time);
        Worked { watch, until }
    }
}

impl Watch for Worked<'_> {
    fn beneath(&self) -> Option<&dyn Watch> {
        Some(self.watch)
    }

    fn cancelled(&self) -> bool {
        self.watch.cancelled() || self.watch.worked() >= self.until
    }
}
