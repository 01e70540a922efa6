//! From files to a scheduled program: every stage in its order.

use crate::failure::Failure;
use crate::stopwatch::Stopwatch;
use crate::talk;
use crate::{cli, diagnostics, files, interrupt, kernels};
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::{Diagnostic, Severity, Source};
use srp_archdesc::entity::EntityMap;
use srp_frontend::{Include, Options, library};
use srp_ir::dfg::{Dfg, Order};
use srp_ir::dre::scheduled::{ModuloSchedule, ScheduledDre};
use srp_ir::dre::{self, Dre};
use srp_ir::pass;
use srp_ir::program::{Block, Func, Kernel, Program};
use srp_ir::split::{NotPipelined, Remark, split};
use srp_scheduler::modulo::{self, Unschedulable};
use srp_scheduler::{Known, LoopFacts, Schedule, ScheduleError};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What a command is given, by how far it is compiled already.
pub(crate) enum Input {
    /// C sources.
    C(Vec<Source>),
    /// A program in the intermediate form.
    Ir(Box<Program>),
    /// A divided program.
    Dre(Box<Dre>),
    /// A scheduled program.
    Scheduled(Box<ScheduledDre>),
}

/// A scheduled program.
pub(crate) struct Compiled {
    pub(crate) dre: Option<Dre>,
    pub(crate) schedule: Schedule,
    pub(crate) not_pipelined: Vec<NotPipelined>,
    /// Memory accesses of the kernels that are kept in order for want of knowledge.
    pub(crate) remarks: Vec<Remark>,
    /// The memory orders of each kernel that would be left if pointers were `restrict`.
    pub(crate) relaxed: BTreeMap<String, Vec<Order>>,
    /// Loops that the array could not run, and that went back to the control code.
    pub(crate) refused: Vec<Dfg>,
    /// How long the schedule of each kernel was looked for, by name.
    pub(crate) searched: BTreeMap<String, Duration>,
}

impl Compiled {
    /// The program, if there is a function to start with, and nobody wants it to end.
    pub(crate) fn runnable(&self) -> Result<&ScheduledDre, Failure> {
        interrupt::end_if_requested()?;
        match &self.dre {
            Some(dre) if dre.control.main.is_none() => Err(no_main()),
            _ => Ok(&self.schedule.program),
        }
    }
}

/// A program that is to run has no `main`.
pub(crate) fn no_main() -> Failure {
    Failure::message("the program has no function `main` to start with")
}

/// Reads C files, or one file of a later form.
pub(crate) fn read(paths: &[PathBuf], arch: &Arch) -> Result<Input, Failure> {
    let name = |p: &Path| p.display().to_string();
    let form = |p: &Path| match name(p) {
        n if n.ends_with(".ir") => Some("ir"),
        n if n.ends_with(".dre.xml") => Some("dre"),
        n if n.ends_with(".sched.xml") => Some("sched"),
        _ => None,
    };
    let Some(path) = paths.iter().find(|p| form(p).is_some()) else {
        let sources: Result<Vec<_>, _> = paths.iter().map(|p| files::read_source(p)).collect();
        return Ok(Input::C(sources?));
    };
    if paths.len() > 1 {
        let message = format!(
            "{} is compiled further than C: give it alone",
            path.display()
        );
        return Err(Failure::Message(message));
    }
    let text = files::read_text(path)?;
    let at = |line: u32, column: u32, why: &dyn std::fmt::Display| {
        Failure::Message(format!("{}:{line}:{column}: {why}", path.display()))
    };
    Ok(match form(path) {
        Some("ir") => {
            let program =
                srp_ir::text::read(&text).map_err(|e| at(e.line, e.column, &e.message))?;
            if let Err(violations) = srp_ir::verify(&program) {
                let lines: Vec<String> = violations.iter().map(|v| v.to_string()).collect();
                return Err(Failure::Message(format!(
                    "{}: {}",
                    path.display(),
                    lines.join("\n")
                )));
            }
            Input::Ir(Box::new(program))
        }
        Some("dre") => {
            let dre = dre::read(&text).map_err(|e| at(e.line, e.column, &e.message))?;
            Input::Dre(Box::new(dre))
        }
        _ => {
            let program =
                dre::read_scheduled(&text, arch).map_err(|e| at(e.line, e.column, &e.message))?;
            Input::Scheduled(Box::new(program))
        }
    })
}

/// The front end's view of a command line: macros of the machine and of the user, and where
/// included files are found.
pub(crate) struct FrontEnd<'a> {
    source: &'a cli::Source,
    arch: &'a Arch,
    /// Every text that has been read, by name, for messages.
    texts: RefCell<BTreeMap<String, String>>,
}

impl<'a> FrontEnd<'a> {
    pub(crate) fn new(source: &'a cli::Source, arch: &'a Arch) -> FrontEnd<'a> {
        FrontEnd {
            source,
            arch,
            texts: RefCell::default(),
        }
    }

    /// Runs `f` with the front end's options.
    pub(crate) fn with<R>(&self, f: impl FnOnce(&Options<'_>) -> R) -> R {
        let resolve = |include: &Include<'_>| self.resolve(include);
        let buffers = &self.arch.system.buffers;
        let features = self.source.features();
        let mut defines = vec![
            ("SRP_RAYS".to_owned(), buffers.rays.to_string()),
            (
                "SRP_RAY_BUFFERS".to_owned(),
                buffers.ray_buffers.to_string(),
            ),
            (
                "SRP_SRAM_BYTES".to_owned(),
                self.arch.system.sram_bytes.to_string(),
            ),
            (
                "SRP_HIT_BUFFERS".to_owned(),
                buffers.hit_buffers.to_string(),
            ),
        ];
        defines.extend(self.source.define.iter().map(|d| {
            let (name, value) = d.split_once('=').unwrap_or((d, "1"));
            (name.to_owned(), value.to_owned())
        }));
        f(&Options {
            defines,
            resolve: &resolve,
            auto_kernel: !self.source.no_auto_kernel && !features.no_auto_kernel,
            double_is_float: self.source.double == cli::Double::Float,
            single_constants: features.single_constants,
        })
    }

    /// An included file: beside the file that asks, in the folders of the command line, or one of
    /// those that come along.
    fn resolve(&self, include: &Include<'_>) -> Option<Source> {
        let beside = Path::new(include.from).parent().map(Path::to_owned);
        let folders = beside.into_iter().filter(|_| !include.system);
        let folders = folders.chain(self.source.include.iter().cloned());
        let found = folders
            .map(|folder| folder.join(include.name))
            .find_map(|path| files::read_source(&path).ok())
            .or_else(|| kernels::header(include.name))?;
        self.texts
            .borrow_mut()
            .insert(found.name.clone(), found.text.clone());
        Some(found)
    }

    /// The program after the passes.
    pub(crate) fn optimise(&self, mut program: Program) -> Program {
        let features = self.source.features();
        let options = pass::Options {
            precision: self.arch.precision,
            associative_math: features.associative_math,
            reciprocal_math: features.reciprocal_math,
            contract: features.contract,
        };
        let remarks = pass::optimise(&mut program, &options);
        if self.source.remarks.contains(&cli::RemarkKind::Pass) {
            // What stands in a loop's way is said again, with the loop's name, when it is divided.
            let told = [pass::REASSOCIATE, pass::RECIPROCAL, pass::CONTRACT];
            for remark in remarks.iter().filter(|r| told.contains(&r.pass)) {
                let place = program.show_pos(remark.pos);
                let (pass, message) = (remark.pass, &remark.message);
                talk::say(format_args!("remark: {place}: {message} (-f{pass})"));
            }
        }
        debug_assert_eq!(srp_ir::verify(&program), Ok(()));
        program
    }

    /// Compiles to the intermediate form, before the passes. Warnings go to standard error.
    pub(crate) fn compile(&self, sources: &[Source]) -> Result<Program, Failure> {
        for source in sources {
            self.texts
                .borrow_mut()
                .insert(source.name.clone(), source.text.clone());
        }
        diagnostics::check_names(self.source)?;
        let (program, messages) = match self.with(|options| srp_frontend::compile(sources, options))
        {
            Ok((program, messages)) => (Some(program), messages),
            Err(messages) => (None, messages),
        };
        let messages = diagnostics::chosen(messages, self.source);
        let refused = messages.iter().any(|m| m.severity == Severity::Error);
        match program {
            Some(program) if !refused => {
                talk::say_all(&self.render(&messages));
                Ok(program)
            }
            _ => Err(Failure::Reported(self.render(&messages))),
        }
    }

    /// Diagnostics as text, and how many errors they are.
    pub(crate) fn render(&self, diagnostics: &[Diagnostic]) -> String {
        let text = |name: &str| {
            let known = self.texts.borrow().get(name).cloned();
            known.or_else(|| library::text(name).map(str::to_owned))
        };
        diagnostics::show(diagnostics, self.source.error_format, &text)
    }
}

/// A divided program, and the loops that stay in the control code.
pub(crate) struct Divided {
    pub(crate) dre: Dre,
    not_pipelined: Vec<NotPipelined>,
    remarks: Vec<Remark>,
    relaxed: BTreeMap<String, Vec<Order>>,
    /// Loops that went back to the control code because the array cannot run them.
    refused: Vec<Dfg>,
    /// What stands in their way.
    returned: Vec<NotPipelined>,
}

/// Divides a program, whose loops that are none for the array lose their marks.
pub(crate) fn divide(program: &mut Program, arch: &Arch) -> Result<Divided, Failure> {
    let (mut returned, mut refused) = (Vec::new(), Vec::new());
    loop {
        let divided = split(program);
        let kernels = divided.dre.kernels.iter();
        let failed = kernels.filter_map(|(k, dfg)| Some((k, modulo::admit(dfg, arch).err()?)));
        let failed: Vec<_> = failed.collect();
        if failed.is_empty() {
            return Ok(Divided {
                dre: divided.dre,
                not_pipelined: divided.not_pipelined,
                remarks: divided.remarks,
                relaxed: divided.relaxed,
                refused,
                returned,
            });
        }
        for (kernel, why) in failed {
            refused.push(divided.dre.kernels[kernel].clone());
            returned.push(give_back(program, &divided.dre, kernel, why)?);
        }
    }
}

impl Divided {
    /// The loops that stay in the control code, with what stands in their way.
    pub(crate) fn not_pipelined(&self) -> impl Iterator<Item = &NotPipelined> {
        self.not_pipelined.iter().chain(&self.returned)
    }
}

/// Divides a program and schedules it. Loops that the array cannot run go back to the control code.
fn schedule(
    mut program: Program,
    arch: &Arch,
    effort: Effort,
    known: &Known,
) -> Result<Compiled, Failure> {
    let (mut unschedulable, mut refused) = (Vec::new(), Vec::new());
    let stopwatch = Stopwatch::default();
    loop {
        let divided = divide(&mut program, arch)?;
        let mut not_pipelined = divided.not_pipelined;
        unschedulable.extend(divided.returned);
        refused.extend(divided.refused);
        match schedule_dre(&divided.dre, arch, effort, known, &stopwatch) {
            Ok(schedule) => {
                not_pipelined.extend(unschedulable);
                return Ok(Compiled {
                    dre: Some(divided.dre),
                    schedule,
                    not_pipelined,
                    remarks: divided.remarks,
                    relaxed: divided.relaxed,
                    refused,
                    searched: stopwatch.times(),
                });
            }
            Err(ScheduleError::Kernels(failed)) => {
                for (kernel, why) in failed {
                    refused.push(divided.dre.kernels[kernel].clone());
                    unschedulable.push(give_back(&mut program, &divided.dre, kernel, why)?);
                }
            }
            Err(error) => return Err(Failure::message(error)),
        }
    }
}

/// Takes the mark from a loop that the array cannot run.
fn give_back(
    program: &mut Program,
    dre: &Dre,
    kernel: Kernel,
    why: Unschedulable,
) -> Result<NotPipelined, Failure> {
    let dfg = &dre.kernels[kernel];
    let Some((func, block)) = marked(program, &dfg.name) else {
        return Err(Failure::Message(format!("{}: {}", dfg.name, why.why)));
    };
    let mark = program.funcs[func].blocks[block].kernel.take();
    Ok(NotPipelined {
        name: dfg.name.clone(),
        pos: dfg.pos,
        reason: why.why,
        at: why.node.map_or(dfg.pos, |n| dfg.nodes[n].pos),
        required: mark.is_some_and(|m| m.required),
    })
}

/// Why a divided program, whose loops cannot go back to the control code, has no schedule.
fn refusal(dre: &Dre, error: ScheduleError) -> Failure {
    let ScheduleError::Kernels(failed) = error else {
        return Failure::message(error);
    };
    let line = |(kernel, why): (Kernel, Unschedulable)| {
        let dfg = &dre.kernels[kernel];
        let pos = why.node.map_or(dfg.pos, |n| dfg.nodes[n].pos);
        let file = dre.control.files.get(pos.file).map_or("", String::as_str);
        let (name, why) = (&dfg.name, why.why);
        format!(
            "{file}:{}:{}: {name} cannot run on the array: {why}",
            pos.line, pos.column
        )
    };
    Failure::Message(failed.into_iter().map(line).collect::<Vec<_>>().join("\n"))
}

/// The loop with this kernel name.
fn marked(program: &Program, name: &str) -> Option<(Func, Block)> {
    program.funcs.iter().find_map(|(func, data)| {
        let is = |&&block: &&Block| {
            data.blocks[block]
                .kernel
                .as_ref()
                .is_some_and(|mark| mark.name == name)
        };
        data.layout.iter().find(is).map(|&block| (func, block))
    })
}

/// How long the best schedules are looked for.
#[derive(Clone, Copy)]
pub(crate) enum Effort {
    /// As far as a fixed number of steps goes: the same for everybody.
    Steps,
    /// For so long beyond these steps, for each loop that has not reached its bound.
    Beyond(Duration),
}

impl Effort {
    /// What the command line asks for.
    pub(crate) fn of(search: &cli::Search) -> Effort {
        // A year is as good as for ever, and does not overflow.
        let seconds = |s: f64| Duration::from_secs_f64(s.clamp(0.0, 3.2e7));
        let beyond = |s| Effort::Beyond(seconds(s));
        search.optimal.map_or(Effort::Steps, beyond)
    }

    /// The options of this effort.
    pub(crate) fn options(self) -> modulo::Options {
        modulo::Options {
            beyond: match self {
                Effort::Steps => None,
                Effort::Beyond(time) => Some(time),
            },
            ..modulo::Options::default()
        }
    }
}

fn schedule_dre(
    dre: &Dre,
    arch: &Arch,
    effort: Effort,
    known: &Known,
    stopwatch: &Stopwatch,
) -> Result<Schedule, ScheduleError> {
    let options = srp_scheduler::Options {
        modulo: effort.options(),
        threads: std::thread::available_parallelism().map_or(1, usize::from),
        known: Some(known),
    };
    interrupt::looked_for(|| srp_scheduler::schedule(dre, arch, &options, stopwatch))
}

/// What is known of a loop whose schedule was made before.
pub(crate) fn facts_alone(schedule: &ModuloSchedule, arch: &Arch) -> LoopFacts {
    LoopFacts {
        bounds: modulo::bounds(&schedule.dfg, arch),
        obstacle: None,
        impossible: Vec::new(),
    }
}

/// Takes an input all the way to a schedule.
pub(crate) fn compile(
    input: Input,
    front_end: &FrontEnd<'_>,
    effort: Effort,
) -> Result<Compiled, Failure> {
    compile_knowing(input, front_end, effort, &Known::default())
}

/// The same; loops that are known are not scheduled again, and those that are become known.
pub(crate) fn compile_knowing(
    input: Input,
    front_end: &FrontEnd<'_>,
    effort: Effort,
    known: &Known,
) -> Result<Compiled, Failure> {
    let arch = front_end.arch;
    match input {
        Input::C(sources) => {
            let program = front_end.compile(&sources)?;
            schedule(front_end.optimise(program), arch, effort, known)
        }
        Input::Ir(program) => schedule(*program, arch, effort, known),
        Input::Dre(dre) => {
            let stopwatch = Stopwatch::default();
            let schedule = schedule_dre(&dre, arch, effort, known, &stopwatch)
                .map_err(|e| refusal(&dre, e))?;
            Ok(Compiled {
                dre: Some(*dre),
                schedule,
                not_pipelined: Vec::new(),
                remarks: Vec::new(),
                relaxed: BTreeMap::new(),
                refused: Vec::new(),
                searched: stopwatch.times(),
            })
        }
        Input::Scheduled(program) => {
            srp_scheduler::check::check(&program, arch)
                .map_err(|v| Failure::message(ScheduleError::Wrong(v)))?;
            let loops = program.kernels.values();
            let loops: EntityMap<_, _> = loops.map(|s| facts_alone(s, arch)).collect();
            let schedule = Schedule {
                program: *program,
                loops,
                control: Vec::new(),
            };
            Ok(Compiled {
                dre: None,
                schedule,
                not_pipelined: Vec::new(),
                remarks: Vec::new(),
                relaxed: BTreeMap::new(),
                refused: Vec::new(),
                searched: BTreeMap::new(),
            })
        }
    }
}
