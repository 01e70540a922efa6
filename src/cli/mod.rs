//! The command line.

mod accuracy;
mod cache;
mod checkpoint;
mod compiling;
mod debug;
mod diff;
pub(crate) mod dram;
mod fidelity;
mod frame;
mod hard;
mod machine;
pub(crate) mod map;
mod paper;
mod render;
mod sharing;
mod start;
mod sweep;
mod tni;
mod trace;
mod watertight;

pub(crate) use accuracy::Accuracy;
pub(crate) use cache::{Cache, CacheAction};
pub(crate) use checkpoint::Checkpoints;
pub(crate) use compiling::{
    Compile, ErrorFormat, Feature, Form, Loops, Report, Reported, Run, RunEngine, Source, Watch,
    fast_math,
};
pub(crate) use debug::{Debug, Inspected, Tandem};
pub(crate) use diff::Diff;
pub(crate) use fidelity::{FidelityTable, TableForm};
pub(crate) use frame::{Building, Frame, parse_cameras};
pub(crate) use hard::HardCases;
pub(crate) use machine::{Area, Machine, MachineAction, Units};
pub(crate) use paper::{Paper, Table};
pub(crate) use render::{Effects, Render};
pub(crate) use sharing::Sharing;
pub(crate) use start::{Kind as StartKind, New};
pub(crate) use sweep::{Sweep, SweepAction};
pub(crate) use tni::{HeatOf, Latencies, Pipeline, RayKind, Tni, TniMemory};
pub(crate) use trace::{Trace, TraceOf};
pub(crate) use watertight::Watertight;

use crate::limits::{self, Limits};
use crate::talk::{self, Colour};

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use srp_archdesc::arch::Arch;
use srp_archdesc::xml::Change;
use srp_scheduler::modulo::Solver;
use srp_toolchain::{Effort, Engine, Error, machine as machines};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Compiler, scheduler and simulator generator for the SRP, the programmable half of the SGRT
/// ray-tracing GPU.
///
/// Kernels in C and a machine in XML become a schedule for the machine's VLIW engine and
/// reconfigurable array, and a cycle-accurate simulator of both beside the traversal and
/// intersection unit.
#[derive(Parser)]
#[command(
    name = "srp",
    version,
    arg_required_else_help = true,
    propagate_version = true,
    after_help = "\
Examples:
  srp render                                   the default scene, kernels and machine to out.png
  srp render church.obj --size 640x480 --camera 0,2,9/0,0,-1/60 -o church.png
  srp new program fog.c                        a commented program to begin with
  srp run program.c --engine interp            compile, schedule and simulate main()
  srp report kernels.c --html report.html      initiation intervals, and what sets them
  srp compile kernels.c --emit ir,dfg -o build
  srp dram requests.trace --preset lpddr3-1600
  srp machine check my-machine.xml
  srp sweep --set array.rows=4,5,6             variants of the machine, and what moves what
  srp map conv.dot --mesh 4x4                  a bare dataflow graph onto a standard array

Exit status: 0 done, 1 the input is at fault or a check failed, 2 the command line is, 130 interrupted
(what is known by then is printed)."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    /// Say what the code of a message stands for, such as C0502
    #[arg(long, value_name = "CODE")]
    pub(crate) explain: Option<String>,
    /// Colours of messages; auto: on a terminal, unless NO_COLOR is set, and anywhere if CLICOLOR_FORCE is
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto", value_parser = one_of(COLOURS))]
    pub(crate) color: Colour,
    /// Say errors and warnings only: no notes, no names of written files, no progress
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    /// Say also how long each stage of the work took
    #[arg(short, long, global = true, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
    /// Take the inputs for a stranger's: work in a sandbox, within limits such as
    /// memory=2G,seconds=60,cycles=1e9 (docs/reliability.md has all)
    #[arg(long, global = true, value_name = "LIMITS", num_args = 0..=1, require_equals = true,
        default_missing_value = "", value_parser = Limits::parse)]
    pub(crate) untrusted: Option<Limits>,
}

const COLOURS: &[Choice<Colour>] = &[
    Choice {
        value: Colour::Auto,
        name: "auto",
        what: "On a terminal",
    },
    Choice {
        value: Colour::Always,
        name: "always",
        what: "In files and pipes too",
    },
    Choice {
        value: Colour::Never,
        name: "never",
        what: "Nowhere",
    },
];

/// What to do.
#[derive(Subcommand)]
pub(crate) enum Command {
    /// Render a scene: the kernels run on the simulated SRPs beside their T&I units.
    Render(Render),
    /// What levels of simulation cost in host time, and what they are off by.
    Fidelity(FidelityTable),
    /// Say which effects a scene calls for, why, and what they cost.
    Effects(Effects),
    /// Say what accuracy costs in time: many settings, each compiled and simulated
    Accuracy(Box<Accuracy>),
    /// Make a commented starting point: a program, kernels, a machine, a plan of a sweep, hard cases.
    New(New),
    /// Compile C to any of its forms on the way to a simulator.
    Compile(Compile),
    /// Compile, schedule and simulate a C program; its status is the command's.
    Run(Run),
    /// Stop a program or a frame anywhere, look into it, and go back: for editors, or by commands.
    Debug(Debug),
    /// Run two engines in lock step, and say where they differ first.
    Tandem(Tandem),
    /// Report the initiation interval of every loop, and what sets it.
    Report(Report),
    /// Say what got slower and faster between two frames, profiles or reports, largest first.
    Diff(Diff),
    /// Report again whenever a file is saved, what got better or worse first.
    Watch(Watch),
    /// Vary a machine, and compare: intervals, cycles, energy, area, error of every variant.
    Sweep(Box<Sweep>),
    /// Run T&I units alone on rays, and account for every cycle.
    Tni(Tni),
    /// Hold the T&I units against the figures of the SGRT paper.
    Paper(Paper),
    /// Price the chip: SRP, T&I unit and bus by their parts, area at 65, 28 and 7 nm, energy of operations.
    Area(Area),
    /// Try the special functions of a machine on every mantissa: errors, order, exact powers.
    Units(Units),
    /// Map bare dataflow graphs onto an array: initiation intervals, bounds, and what sets them.
    Map(map::Map),
    /// Run a trace of requests through a memory: bandwidth, rows, latency.
    Dram(dram::Dram),
    /// Try cases that go wrong in float arithmetic, with each precision that the machine can have.
    HardCases(HardCases),
    /// Count rays that meshes lose, and rays that hit what they pass by, with every triangle test.
    Watertight(Watertight),
    /// Show, empty or check what is kept from one run to the next.
    Cache(Cache),
    /// Check a machine file, show what it describes, write it out in full, or make one.
    Machine(Machine),
    /// Print the JSON Schema of a format of documents, or the names of all formats.
    #[command(after_help = "\
docs/json.md describes the formats, and what may change of them.

Examples:
  srp schema
  srp schema srp-report > srp-report.json")]
    Schema {
        /// The format, such as srp-report; without it, the names of all formats are printed.
        #[arg(value_name = "NAME")]
        name: Option<String>,
    },
    /// Write manual pages: one for the command, one for each command within it.
    #[command(after_help = "\
Examples:
  srp man ~/.local/share/man/man1 && man srp-render")]
    Man {
        /// Folder for the pages
        #[arg(value_name = "DIR")]
        pages: PathBuf,
    },
    /// Print a completion script for a shell.
    #[command(after_help = "\
Examples:
  srp completions bash > ~/.local/share/bash-completion/completions/srp
  srp completions fish > ~/.config/fish/completions/srp.fish")]
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
}

/// The machine that everything is for.
#[derive(Args)]
pub(crate) struct MachineFile {
    /// Machine file, or one of the machines that come along: sgrt, decoupled, fpga, tiny, wide
    #[arg(long, value_name = "FILE.xml", default_value = "sgrt")]
    pub(crate) machine: PathBuf,
    #[command(flatten)]
    pub(crate) changes: Changes,
}

impl MachineFile {
    /// The machine, with its changes.
    ///
    /// # Errors
    ///
    /// The file cannot be read, or what comes of the changes is no machine.
    pub(crate) fn read(&self) -> Result<Arch, Error> {
        self.changes.of(&self.machine)
    }

    /// The text of it.
    ///
    /// # Errors
    ///
    /// The file cannot be read, or an attribute cannot be set.
    pub(crate) fn text(&self) -> Result<String, Error> {
        machines::changed_text(&self.machine, &self.changes.set)
    }
}

impl Changes {
    /// A machine with these changes, and says what of it is not as it seems.
    ///
    /// # Errors
    ///
    /// The file cannot be read, or what comes of the changes is no machine.
    pub(crate) fn of(&self, machine: &Path) -> Result<Arch, Error> {
        let arch = machines::changed(machine, &self.set)?;
        talk::warn(&machines::warnings(machine, &self.set));
        Ok(arch)
    }
}

/// Changes of a machine, without another file.
#[derive(Args)]
pub(crate) struct Changes {
    /// Set an attribute of the machine by its path, as in array.rows=5 or tni/trv-l1.size=8192; several are possible
    #[arg(long, value_name = "PATH=VALUE")]
    pub(crate) set: Vec<Change>,
}

/// Most threads of the host that can be asked for: more than any host has use for, and as many as
/// it will start.
const MAX_THREADS: usize = 256;

fn parse_threads(text: &str) -> Result<usize, String> {
    let threads = text.parse().ok().filter(|n| (1..=MAX_THREADS).contains(n));
    threads.ok_or_else(|| format!("write a number from 1 to {MAX_THREADS}"))
}

fn parse_pixel(text: &str) -> Result<(u32, u32), String> {
    text.split_once(',')
        .and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)))
        .ok_or_else(|| "a pixel is X,Y, from 0,0 in the upper left corner".to_owned())
}

/// The threads that are asked for, or as many as the host has processors.
pub(crate) fn threads(asked: Option<usize>) -> usize {
    let host = std::thread::available_parallelism().map_or(1, usize::from);
    asked.unwrap_or(host.min(MAX_THREADS).min(limits::threads()))
}

/// The longest search for a schedule, in hundredths of the usual one.
const MAX_EFFORT: f64 = 1e7;

fn parse_effort(text: &str) -> Result<u32, String> {
    let times = text.parse().ok().map(|times: f64| (times * 100.0).round());
    let percent = times.filter(|percent| (0.0..=MAX_EFFORT).contains(percent));
    // The range is that of the type.
    let percent = percent.map(|percent| percent as u32);
    percent.ok_or_else(|| format!("write a number from 0 to {}", MAX_EFFORT / 100.0))
}

/// How hard loops are scheduled.
#[derive(Args)]
pub(crate) struct Search {
    /// Look for schedules so many times as long as usual; that is a moment for a loop that reaches its bound, up to half a minute for one that does not, and a minute or two for graphs of hundreds of nodes
    #[arg(long, value_name = "TIMES", default_value = "1", value_parser = parse_effort)]
    pub(crate) effort: u32,
    /// Look for the smallest II by SAT too, or prove that there is none, for so many seconds (60) of processor time
    /// for each loop above its bound
    #[arg(long, value_name = "SECONDS", num_args = 0..=1, require_equals = true, default_missing_value = "60")]
    pub(crate) optimal: Option<f64>,
    /// The SAT solver; only batsat writes proofs
    #[arg(long, value_name = "NAME", default_value = "batsat", value_parser = one_of(SOLVERS))]
    pub(crate) solver: Solver,
}

/// The SAT solvers that this program was built with.
const SOLVERS: &[Choice<Solver>] = &[
    Choice {
        value: Solver::Batsat,
        name: "batsat",
        what: "Plain Rust",
    },
    #[cfg(feature = "cadical")]
    Choice {
        value: Solver::Cadical,
        name: "cadical",
        what: "CaDiCaL, for a second opinion",
    },
];

impl Search {
    /// How long loops are scheduled.
    pub(crate) fn effort(&self) -> Effort {
        // A year is as good as for ever, and does not overflow.
        let seconds = |s: f64| Duration::from_secs_f64(s.clamp(0.0, 3.2e7));
        Effort {
            percent: self.effort,
            beyond: self.optimal.map(seconds),
            solver: self.solver,
        }
    }
}

/// A value of a plain type, as the command line has it.
#[derive(Clone, Copy)]
pub(crate) struct Choice<T: 'static> {
    pub(crate) value: T,
    pub(crate) name: &'static str,
    pub(crate) what: &'static str,
}

/// A parser of one of some values.
pub(crate) fn one_of<T: Copy + Send + Sync>(
    choices: &'static [Choice<T>],
) -> impl TypedValueParser<Value = T> {
    let values = choices
        .iter()
        .map(|c| PossibleValue::new(c.name).help(c.what));
    PossibleValuesParser::new(values).map(move |name| {
        let chosen = choices.iter().find(|c| c.name == name);
        chosen.expect("the parser takes no other name").value
    })
}

/// What simulates the SRP.
pub(crate) const ENGINES: &[Choice<Engine>] = &[
    Choice {
        value: Engine::Auto,
        name: "auto",
        what: "A generated simulator if it is compiled already; else the interpreter begins, and gives way to \
               a simulator that is compiled beside it",
    },
    Choice {
        value: Engine::Generated,
        name: "csim",
        what: "A simulator generated for the program and compiled by rustc",
    },
    Choice {
        value: Engine::Interpreter,
        name: "interp",
        what: "The interpreter of the same tables",
    },
];
