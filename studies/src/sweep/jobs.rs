//! Sweeps beyond one host: a [job](crate::jobs) is a shard, which reads the plan in the folder that all hosts see, and appends
//! rows to a file of its own. Rows that are known are not measured again. Each generation of a search is started by itself,
//! when the rows of that before are known.

use super::agenda::Agenda;
use super::bench::Bench;
use super::plan::Plan;
use super::rows::{Folder, Job, Row};
use super::{Findings, of_plan};
use crate::Error;
use crate::jobs::{Jobs, quote};
use srp_archdesc::watch::Stage;
use srp_toolchain::{BUILD_ID, Session};
use std::collections::BTreeMap;
use std::path::Path;

/// Runs what is left of a sweep as jobs, and waits for them. `program` is `srp`, as all hosts find it.
///
/// # Errors
///
/// A subject cannot be read, the folder cannot be written, or the engine cannot be started. Jobs that failed are no error:
/// rows are missing then, and the watch hears why.
pub fn run(
    plan: &Plan,
    folder: &Folder,
    jobs: &Jobs,
    program: &Path,
    session: &Session<'_>,
) -> Result<Findings, Error> {
    let bench = Bench::new(plan, session)?;
    let mut agenda = Agenda::new(plan, &bench);
    let mut rows = folder.rows()?;
    let mut stage = None;
    let mut reused = 0;
    while let Some(further) = agenda.next(&rows)? {
        let size = further.len();
        let further = &agenda.jobs()[further];
        let mut seen = known(&rows, further);
        reused += seen;
        if seen == size {
            continue;
        }
        folder.write_plan(plan, agenda.jobs())?;
        let steps = (agenda.planned() - reused) as u64;
        let stage = &*stage.get_or_insert_with(|| Stage::of(session.watch, "rows", steps));
        // Each shard of a generation has a row at least.
        let round = Jobs {
            count: jobs.count.min(size),
            ..jobs.clone()
        };
        let place = folder.path("jobs");
        let command = shard(folder, program, &round);
        let about = "A shard of the sweep in this folder";
        round.run(&place, (about, &command), session, &mut || {
            rows = folder.rows()?;
            let now = known(&rows, further);
            stage.done((now - seen.min(now)) as u64);
            seen = now;
            Ok(())
        })?;
    }
    folder.write_plan(plan, agenda.jobs())?;
    Ok(Findings {
        rows: of_plan(agenda.jobs(), &rows),
        planned: agenda.planned(),
        reused,
    })
}

/// How many of these rows are known.
fn known(rows: &BTreeMap<String, Row>, jobs: &[Job]) -> usize {
    let known = jobs.iter().filter(|job| rows.contains_key(&job.key));
    known.count()
}

/// The command of a shard.
fn shard(folder: &Folder, program: &Path, jobs: &Jobs) -> String {
    let folder = folder.path("");
    let folder = folder.canonicalize().unwrap_or(folder);
    let quoted = |path: &Path| quote(&path.display().to_string());
    format!(
        "{} sweep {} -o {} --shard \"$1/{}\" --threads {} --build {BUILD_ID}",
        quoted(program),
        quoted(&folder.join("plan.toml")),
        quoted(&folder),
        jobs.count,
        jobs.threads,
    )
}
