//! Sweeps beyond one host, on an engine that is there: Slurm, Dask, or any command that runs a command somewhere.
//!
//! A job is a shard: it reads the plan in the folder that all hosts see, and appends rows to a file of its own. Running
//! one again is always right, since rows that are known are not measured again; so jobs may be killed, requeued
//! and run twice. There is no server here: the engine starts jobs, and the folder has the results. Each generation of a search
//! is started by itself, when the rows of that before are known.

use super::agenda::Agenda;
use super::bench::Bench;
use super::plan::Plan;
use super::rows::{Folder, Job, Row};
use super::{Findings, of_plan};
use crate::Error;
use srp_archdesc::watch::{Event, Stage};
use srp_toolchain::{BUILD_ID, Session, files};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

/// The runner of jobs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Engine {
    /// A job array of Slurm. Partition, account and time come from `SBATCH_` variables, as for any job.
    Slurm,
    /// The workers of a Dask scheduler, with its address; without one `DASK_SCHEDULER_ADDRESS` has it.
    Dask(Option<String>),
    /// A command of the shell that runs what stands for `{}` and waits for it.
    Command(String),
}

/// The command that hosts run, and how many shards there are.
#[derive(Clone, Debug)]
pub struct Jobs {
    /// The engine.
    pub engine: Engine,
    /// The program `srp`, as all hosts find it.
    pub program: PathBuf,
    /// Shards.
    pub shards: usize,
    /// Threads of each.
    pub threads: usize,
}

/// Attempts at a shard on one host before its engine hears of the failure.
const ATTEMPTS: u32 = 3;
/// Between two looks at the folder.
const LOOK: Duration = Duration::from_millis(500);
/// Lines of a failed job's log that are shown.
const SHOWN: usize = 5;

const DASK: &str = include_str!("on_dask.py");

impl Engine {
    /// Reads `slurm`, `dask`, `dask:ADDRESS` or a command; `None` of `local`.
    pub fn parse(text: &str) -> Option<Engine> {
        match text.split_once(':').unwrap_or((text, "")) {
            ("local", "") => None,
            ("slurm", "") => Some(Engine::Slurm),
            ("dask", "") => Some(Engine::Dask(None)),
            ("dask", address) => Some(Engine::Dask(Some(address.to_owned()))),
            _ => Some(Engine::Command(text.to_owned())),
        }
    }

    fn name(&self) -> &str {
        match self {
            Engine::Slurm => "Slurm",
            Engine::Dask(_) => "Dask",
            Engine::Command(command) => command,
        }
    }
}

/// Runs what is left of a sweep as jobs, and waits for them.
///
/// # Errors
///
/// A subject cannot be read, the folder cannot be written, or the engine cannot be started. Jobs that failed are no error:
/// rows are missing then, and the watch hears why.
pub fn run(
    plan: &Plan,
    folder: &Folder,
    jobs: &Jobs,
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
            shards: jobs.shards.min(size),
            ..jobs.clone()
        };
        round.start_and_wait(folder, session, &mut || {
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

impl Jobs {
    /// Starts the jobs, and looks at the folder until they have ended.
    fn start_and_wait(
        &self,
        folder: &Folder,
        session: &Session<'_>,
        look: &mut dyn FnMut() -> Result<(), Error>,
    ) -> Result<(), Error> {
        let place = folder.path("jobs");
        files::make_folder(&place)?;
        let place = place.canonicalize().unwrap_or(place);
        let script = place.join("run.sh");
        files::write(&script, self.script(&place).as_bytes())?;
        let mut running = self.start(&place, &script)?;
        loop {
            std::thread::sleep(LOOK);
            look()?;
            if session.watch.cancelled() {
                running.end();
                return Ok(());
            }
            if let Some(failed) = running.ended()? {
                for why in failed {
                    session.watch.tell(Event::Note(&why));
                }
                return look();
            }
        }
    }

    /// The script of a shard, which takes its number.
    fn script(&self, place: &Path) -> String {
        let folder = place.parent().unwrap_or(place);
        let quoted = |path: &Path| quote(&path.display().to_string());
        format!(
            "#!/bin/sh\n\
             # A shard of the sweep in this folder: sh run.sh NUMBER. It goes on where it was.\n\
             attempt=0\n\
             while [ $attempt -lt {ATTEMPTS} ]; do\n  \
               {} sweep {} -o {} --shard \"$1/{}\" --threads {} --build {BUILD_ID}\n  \
               status=$?\n  \
               [ $status -eq 0 ] || [ $status -eq 2 ] || [ $status -eq 130 ] && exit $status\n  \
               attempt=$((attempt + 1))\n\
             done\n\
             exit $status\n",
            quoted(&self.program),
            quoted(&folder.join("plan.toml")),
            quoted(folder),
            self.shards,
            self.threads,
        )
    }

    fn start(&self, place: &Path, script: &Path) -> Result<Running, Error> {
        let mut running = Running {
            engine: self.engine.name().to_owned(),
            place: place.to_owned(),
            processes: Vec::new(),
            array: None,
        };
        let path = script.display().to_string();
        match &self.engine {
            Engine::Slurm => {
                let wrapper = place.join("slurm.sh");
                let text = format!(
                    "#!/bin/sh\nexec sh {} \"$SLURM_ARRAY_TASK_ID\"\n",
                    quote(&path)
                );
                files::write(&wrapper, text.as_bytes())?;
                let mut command = Command::new("sbatch");
                command.args(["--parsable", "--wait", "--requeue", "--open-mode=append"]);
                command.args(["--ntasks=1", "--job-name=srp-sweep"]);
                command.arg(format!("--cpus-per-task={}", self.threads));
                command.arg(format!("--array=0-{}", self.shards - 1));
                command
                    .arg("--output")
                    .arg(place.join("%a.log"))
                    .arg(wrapper);
                running.spawn("sbatch", &mut command, Stdio::piped())?;
                running.read_array();
            }
            Engine::Dask(address) => {
                let adapter = place.join("on_dask.py");
                files::write(&adapter, DASK.as_bytes())?;
                let address = match address {
                    Some(address) => address.clone(),
                    None => std::env::var("DASK_SCHEDULER_ADDRESS").map_err(|_| {
                        Error::Invalid(
                            "no Dask scheduler: say --engine dask:tcp://HOST:8786, or set \
                             DASK_SCHEDULER_ADDRESS"
                                .to_owned(),
                        )
                    })?,
                };
                let mut command = Command::new("python3");
                command
                    .arg(adapter)
                    .arg(address)
                    .arg(self.shards.to_string())
                    .arg(script);
                running.spawn("dask", &mut command, Stdio::null())?;
            }
            Engine::Command(template) => {
                for shard in 0..self.shards {
                    let job = format!("sh {} {shard}", quote(&path));
                    let line = match template.contains("{}") {
                        true => template.replace("{}", &job),
                        false => format!("{template} {job}"),
                    };
                    let mut command = Command::new("sh");
                    command.arg("-c").arg(line);
                    running.spawn(&shard.to_string(), &mut command, Stdio::null())?;
                }
            }
        }
        Ok(running)
    }
}

/// A word of the shell.
fn quote(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}

/// Processes that start jobs and wait for them, each with its log.
struct Running {
    engine: String,
    place: PathBuf,
    processes: Vec<(String, Child)>,
    /// The number of Slurm's job array.
    array: Option<String>,
}

impl Running {
    fn spawn(&mut self, name: &str, command: &mut Command, output: Stdio) -> Result<(), Error> {
        let path = self.place.join(format!("{name}.log"));
        let log = File::create(&path).map_err(|e| files::FileError::writing(&path, e))?;
        let child = command
            .stdin(Stdio::null())
            .stdout(output)
            .stderr(log)
            .spawn();
        let child = child.map_err(|e| {
            let program = command.get_program().display();
            Error::Invalid(format!(
                "cannot start `{program}` for --engine {}: {e}",
                self.engine
            ))
        })?;
        self.processes.push((name.to_owned(), child));
        Ok(())
    }

    /// Reads the number that `sbatch` prints before it waits.
    fn read_array(&mut self) {
        let output = self
            .processes
            .first_mut()
            .and_then(|(_, child)| child.stdout.take());
        let mut line = String::new();
        let read = output.map(|output| BufReader::new(output).read_line(&mut line));
        if let Some(Ok(_)) = read {
            let number = line.trim().split(';').next().unwrap_or_default();
            self.array = (!number.is_empty()).then(|| number.to_owned());
        }
    }

    /// The jobs that failed, when all have ended.
    fn ended(&mut self) -> Result<Option<Vec<String>>, Error> {
        let mut failed = Vec::new();
        for (name, child) in &mut self.processes {
            match child.try_wait().map_err(Error::invalid)? {
                None => return Ok(None),
                Some(status) if status.success() => {}
                Some(status) => failed.push((name.clone(), status)),
            }
        }
        Ok(Some(
            failed
                .iter()
                .map(|(name, status)| self.failure(name, *status))
                .collect(),
        ))
    }

    /// A sentence about a process that failed, with the end of its log.
    fn failure(&self, name: &str, status: ExitStatus) -> String {
        let own = self.place.join(format!("{name}.log"));
        let mut text = std::fs::read_to_string(own).unwrap_or_default();
        if self.array.is_some() {
            // Slurm writes a log for each job beside that of `sbatch`.
            let entries = std::fs::read_dir(&self.place)
                .into_iter()
                .flatten()
                .flatten();
            let mut logs: Vec<PathBuf> = entries.map(|e| e.path()).collect();
            logs.retain(|p| p.extension().is_some_and(|e| e == "log"));
            logs.sort();
            let texts = logs
                .iter()
                .filter_map(|log| std::fs::read_to_string(log).ok());
            text = texts.collect();
        }
        let lines: Vec<&str> = text.lines().filter(|l| !l.trim().is_empty()).collect();
        let end = lines[lines.len().saturating_sub(SHOWN)..].join("\n  ");
        let engine = &self.engine;
        format!(
            "warning: a job of {engine} failed ({status}); {}:\n  {end}",
            self.place.display()
        )
    }

    /// Ends all jobs.
    fn end(&mut self) {
        if let Some(array) = &self.array {
            // Where the array has ended already there is nothing to cancel.
            let _ = Command::new("scancel").arg(array).status();
        }
        for (_, child) in &mut self.processes {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
