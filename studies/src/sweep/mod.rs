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
//! [`jobs`] runs shards on a cluster. [`analysis`] reads fronts and sensitivities from the rows.

pub mod analysis;
mod bench;
mod draw;
pub mod jobs;
mod measure;
pub mod plan;
mod point;
pub mod rows;
mod subject;
mod values;

pub use analysis::Analysis;
pub use measure::Measure;
pub use plan::{Plan, PlanFile};
pub use rows::{Folder, Outcome, Row};

use crate::Error;
use bench::Bench;
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

/// Runs what is left of a sweep, or of a shard of it. A point that is no machine, or fails, is a row that says why.
///
/// # Errors
///
/// A subject cannot be read, the plan has no valid point at all, or the folder cannot be written. A cancelled sweep
/// is no error: it has fewer rows.
pub fn run(
    plan: &Plan,
    folder: &Folder,
    shard: Shard,
    session: &Session<'_>,
) -> Result<Findings, Error> {
    let bench = Bench::new(plan, session)?;
    let jobs = bench.jobs()?;
    folder.write_plan(plan, &jobs)?;
    let known: BTreeMap<String, Row> = folder.rows()?;
    let of_shard = |i: &usize| i % shard.of == shard.number;
    let left: Vec<usize> = (0..jobs.len())
        .filter(of_shard)
        .filter(|&i| !known.contains_key(&jobs[i].key))
        .collect();
    let writer = folder.writer(shard)?;
    let stage = Stage::of(session.watch, "rows", left.len() as u64);
    let quiet = Unstaged::new(session.watch);
    let done = threads::some(
        session.threads,
        left.len(),
        || (),
        |(), i| {
            if session.watch.cancelled() {
                return None;
            }
            let job = &jobs[left[i]];
            let row = bench.measure(job, &quiet)?;
            let written = writer.write(&row);
            stage.done(1);
            Some(written.map(|()| row))
        },
    );
    drop(stage);
    let mut rows: BTreeMap<String, Row> = known;
    for row in done.into_iter().flatten() {
        let row = row?;
        rows.insert(row.key.clone(), row);
    }
    Ok(Findings {
        reused: (0..jobs.len()).filter(of_shard).count() - left.len(),
        planned: jobs.len(),
        rows: of_plan(&jobs, &rows),
    })
}

/// The rows of a plan, in its order, among those that are known.
fn of_plan(jobs: &[rows::Job], known: &BTreeMap<String, Row>) -> Vec<Row> {
    let row = |job: &rows::Job| known.get(&job.key).map(|row| job.place(row));
    jobs.iter().filter_map(row).collect()
}
