//! Work beyond one host, on an engine that is there: Slurm, Dask, or any command that runs a command somewhere.
//!
//! A job is a command of the shell with a number. Running one again is always right, because jobs take from a folder that all
//! hosts see what is known already; so they may be killed, requeued and run twice. There is no server here: the engine starts
//! jobs, and the folder has the results.

use crate::Error;
use rustix::process::{Pid, Signal, kill_process_group};
use srp_archdesc::watch::Event;
use srp_toolchain::{Session, files};
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
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

/// Jobs that an engine starts.
#[derive(Clone, Debug)]
pub struct Jobs {
    /// The engine.
    pub engine: Engine,
    /// How many there are.
    pub count: usize,
    /// Threads of each.
    pub threads: usize,
}

/// Attempts at a job on one host before its engine hears of the failure.
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

impl Jobs {
    /// Starts the jobs, which run a command with their numbers, and looks on until they have ended. `command` is of the shell,
    /// and has `$1` for the number; `about` says what it does. Scripts and logs are in `place`.
    ///
    /// # Errors
    ///
    /// The place cannot be written, or the engine cannot be started. Jobs that fail are no error: the watch hears why.
    pub fn run(
        &self,
        place: &Path,
        (about, command): (&str, &str),
        session: &Session<'_>,
        look: &mut dyn FnMut() -> Result<(), Error>,
    ) -> Result<(), Error> {
        files::make_folder(place)?;
        let place = place.canonicalize().unwrap_or_else(|_| place.to_owned());
        let script = place.join("run.sh");
        files::write(&script, script_of(about, command).as_bytes())?;
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
                command.args(["--ntasks=1", "--job-name=srp"]);
                command.arg(format!("--cpus-per-task={}", self.threads));
                command.arg(format!("--array=0-{}", self.count - 1));
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
                    .arg(self.count.to_string())
                    .arg(script);
                running.spawn("dask", &mut command, Stdio::null())?;
            }
            Engine::Command(template) => {
                for number in 0..self.count {
                    let job = format!("sh {} {number}", quote(&path));
                    let line = match template.contains("{}") {
                        true => template.replace("{}", &job),
                        false => format!("{template} {job}"),
                    };
                    let mut command = Command::new("sh");
                    command.arg("-c").arg(line);
                    running.spawn(&number.to_string(), &mut command, Stdio::null())?;
                }
            }
        }
        Ok(running)
    }
}

/// The script of a job, which takes its number.
fn script_of(about: &str, command: &str) -> String {
    format!(
        "#!/bin/sh\n\
         # {about}: sh run.sh NUMBER. It goes on where it was.\n\
         attempt=0\n\
         while [ $attempt -lt {ATTEMPTS} ]; do\n  \
           {command}\n  \
           status=$?\n  \
           [ $status -eq 0 ] || [ $status -eq 2 ] || [ $status -eq 130 ] && exit $status\n  \
           attempt=$((attempt + 1))\n\
         done\n\
         exit $status\n"
    )
}

/// A word of the shell.
pub fn quote(text: &str) -> String {
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
        // A group of its own, so that all that it starts ends with it.
        let child = command
            .process_group(0)
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
            // One that has ended by itself has no group any more.
            let _ = kill_process_group(Pid::from_child(child), Signal::TERM);
            let _ = child.wait();
        }
    }
}
