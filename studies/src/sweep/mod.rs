//! Many machines, not one: a [`Plan`] varies attributes of a machine file, forms of the kernels and options of the
//! compiler; every [`Point`](point::Point) is compiled and simulated for every [`Subject`](subject::Subject), a scene or a program, and
//! becomes a [`Row`].
//!
//! Rows go into a file of the sweep's [folder](rows::Folder) as they are done, so that a sweep that is stopped, however it is
//! stopped, goes on where it was. A row's key covers all that it depends on: rows are found again by
//! another plan, too, and a rebuilt tool does not find them. Shards of one plan may run anywhere that sees the
//! folder: each writes a file of its own, and whoever reads the folder reads them all. Nothing that is
//! measured depends on how many threads or shards there are.
//!
//! The points of a plan are drawn at once, or a search proposes them, generation by generation, from the rows before.
//! [`jobs`] runs shards on a cluster. [`analysis`] reads fronts and sensitivities from the rows.

mod agenda;
pub mod analysis;
mod bench;
mod columnar;
mod draw;
mod front;
pub mod jobs;
mod known;
mod measure;
mod objective;
pub mod plan;
mod point;
mod progress;
pub mod rows;
mod search;
mod space;
mod subject;
pub mod table;
mod values;

pub use analysis::Analysis;
pub use known::Known;
pub use measure::Measure;
pub use objective::Objective;
pub use plan::{Plan, PlanFile};
pub use progress::{Generation, Progress};
pub use rows::{Folder, Outcome, Row};
pub use values::{number, order};

use crate::Error;
use agenda::Agenda;
use bench::Bench;
use rows::{Job, Writer};
use srp_archdesc::threads;
use srp_archdesc::watch::{Stage, Unstaged};
use srp_toolchain::Session;
use std::collections::BTreeMap;

/// A part of a sweep: of so many shards the one with this number, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// The number.
    pub number: usize,
    /// All shards.
    pub of: usize,
}

impl Shard {
    /// The whole sweep.
    pub const WHOLE: Shard = Shard { number: 0, of: 1 };
}

/// The outcome of a sweep, as far as it is known.
#[derive(Clone, Debug)]
pub struct Findings {
    /// The rows that are known, by point and subject.
    pub rows: Vec<Row>,
    /// Rows that the plan has.
    pub planned: usize,
    /// Rows that were found as an earlier run had left them.
    pub reused: usize,
}

/// Runs what is left of a sweep, or of a shard of it. A point that is no machine, or fails, is a row that says why. A shard of a
/// search measures its part of each generation, as long as all rows of those before are known.
///
/// # Errors
///
/// A subject cannot be read, no row has an objective of a search, or the folder cannot be written. A cancelled sweep is no
/// error: it has fewer rows.
pub fn run(
    plan: &Plan,
    folder: &Folder,
    shard: Shard,
    session: &Session<'_>,
) -> Result<Findings, Error> {
    let bench = Bench::new(plan, session)?;
    let mut agenda = Agenda::new(plan, &bench);
    let mut known: BTreeMap<String, Row> = folder.rows()?;
    let writer = folder.writer(shard)?;
    let mut stage = None;
    let mut reused = 0;
    while let Some(further) = agenda.next(&known)? {
        let own = further.filter(|i| i % shard.of == shard.number);
        let (found, left): (Vec<usize>, Vec<usize>) =
            own.partition(|&i| known.contains_key(&agenda.jobs()[i].key));
        reused += found.len();
        if left.is_empty() {
            continue;
        }
        folder.write_plan(plan, agenda.jobs())?;
        let steps = match shard {
            Shard::WHOLE => agenda.planned() - reused,
            _ => left.len(),
        };
        let stage = &*stage.get_or_insert_with(|| Stage::of(session.watch, "rows", steps as u64));
        let jobs: Vec<&Job> = left.iter().map(|&i| &agenda.jobs()[i]).collect();
        for row in measured(&jobs, &bench, &writer, stage, session)? {
            known.insert(row.key.clone(), row);
        }
    }
    folder.write_plan(plan, agenda.jobs())?;
    Ok(Findings {
        reused,
        planned: agenda.planned(),
        rows: of_plan(agenda.jobs(), &known),
    })
}

/// Measures rows side by side, and writes each as it is done; fewer where that was cancelled.
fn measured(
    jobs: &[&Job],
    bench: &Bench<'_>,
    writer: &Writer,
    stage: &Stage<'_>,
    session: &Session<'_>,
) -> Result<Vec<Row>, Error> {
    let quiet = Unstaged::new(session.watch);
    let done = threads::some(
        session.threads,
        jobs.len(),
        || (),
        |(), i| {
            if session.watch.cancelled() {
                return None;
            }
            let row = bench.measure(jobs[i], &quiet)?;
            let written = writer.write(&row);
            stage.done(1);
            Some(written.map(|()| row))
        },
    );
    done.into_iter().flatten().collect()
}

/// The rows of a plan, in its order, among those that are known.
fn of_plan(jobs: &[Job], known: &BTreeMap<String, Row>) -> Vec<Row> {
    let row = |job: &Job| known.get(&job.key).map(|row| job.place(row));
    jobs.iter().filter_map(row).collect()
}
