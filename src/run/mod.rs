//! `srp run`

mod account;
mod at_end;
mod meaning;
mod printing;
mod registers;

pub(crate) use account::Account;
pub(crate) use registers::Registers;

use crate::cli::{Run, RunEngine};
use crate::failure::Failure;
use crate::profile::Target;
use crate::{checkpoint, compile, files, interrupt, refused_kernel, report, talk, trace};
use at_end::AtEnd;
use printing::Printing;
use srp_archdesc::arch::Arch;
use srp_ir::check::Checked;
use srp_runtime::core::Core;
use srp_runtime::solo::{self, Finish, Solo, SoloError};
use srp_studies::profile::Profiler;

use srp_toolchain::envelope::About;
use srp_toolchain::{Engine, Engines, Error, Session, input};
use srp_traces::Tracer;
use std::path::PathBuf;

/// Runs `srp run`; the program's exit status.
pub(crate) fn run(args: &Run) -> Result<i32, Failure> {
    let arch = args.compilation.machine.read()?;
    let options = args.compilation.options()?;
    let source = &args.compilation.source;
    let session = &talk::session();
    let loops = report::Loops::to(&args.loops.loops)?;
    let input = input::read(&args.files, &arch)?;
    let observed = Observed::of(args)?;
    checkpoint::check(&args.checkpoints)?;
    for path in args.report.iter().chain(&args.registers) {
        files::check_writable(path)?;
    }
    let Some(engine) = engine(args, &observed)? else {
        return meaning::run(input, &options, args, &arch);
    };
    let compiled = compile::compile_and_say(input, &arch, &options, source, session)?;
    let format = source.error_format;
    refused_kernel::check(&compiled, &arch, &options.warnings, format, session)?;
    if source.remarks_passes() {
        compile::say_not_pipelined(&compiled, &arch, session)?;
    }
    loops.write(&compiled, &arch, session)?;
    interrupt::end_if_requested()?;
    let program = compiled.runnable()?;
    let mut running = Running::of(program, args, observed, engine, &arch, session)?;
    let ended = running.run(args, args.limit.min(session.cycles))?;
    running.end(ended, args, &arch, session)
}

/// The engine that is asked for; `None` for the meaning of the intermediate form.
fn engine(args: &Run, observed: &Observed) -> Result<Option<Engine>, Failure> {
    let usage = |why: &str| Err(Failure::Usage(why.to_owned()));
    let Observed { profile, trace } = observed;
    let kept = &args.checkpoints;
    let is_kept = kept.checkpoint_at.is_some() || kept.restore.is_some();
    Ok(match args.engine {
        RunEngine::Csim | RunEngine::Ir if profile.is_some() => return usage(COUNTS),
        RunEngine::Ir if args.registers.is_some() => return usage(NO_REGISTERS),
        RunEngine::Ir if trace.is_some() || is_kept => return usage(NO_CYCLES),
        RunEngine::Ir if !args.loops.loops.is_empty() => return usage(NO_LOOPS),
        RunEngine::Ir => None,
        RunEngine::Auto | RunEngine::Interp if profile.is_some() => Some(Engine::Interpreter),
        RunEngine::Auto => Some(Engine::Auto),
        RunEngine::Csim => Some(Engine::Generated),
        RunEngine::Interp => Some(Engine::Interpreter),
    })
}

/// Where what is observed of each cycle goes.
struct Observed {
    profile: Option<Target>,
    trace: Option<trace::Target>,
}

impl Observed {
    fn of(args: &Run) -> Result<Observed, Failure> {
        Ok(Observed {
            profile: Target::to(&args.profile)?,
            trace: trace::Target::of_program(&args.trace)?,
        })
    }
}

/// A program on its way.
struct Running<'a> {
    program: &'a Checked,
    engines: Engines,
    core: Box<dyn Core>,
    bus: Solo,
    account: Finish,
    printing: Printing,
    profile: Option<(Target, Profiler)>,
    trace: Option<(trace::Target, Tracer)>,
}

impl<'a> Running<'a> {
    /// At the program's start, or where a checkpoint stands.
    fn of(
        program: &'a Checked,
        args: &Run,
        observed: Observed,
        engine: Engine,
        arch: &Arch,
        session: &Session<'_>,
    ) -> Result<Running<'a>, Failure> {
        let mut profile = match observed.profile {
            Some(target) => Some((target, Profiler::new(program).map_err(Error::from)?)),
            None => None,
        };
        let mut trace = match observed.trace {
            Some(target) => {
                let tracer = target.tracer(program, 1)?;
                Some((target, tracer))
            }
            None => None,
        };
        let engines = Engines::of(program, engine, session)?;
        let mut core = match (&mut profile, &mut trace) {
            (Some((_, profiler)), _) => profiler.core(),
            (None, Some((_, tracer))) => tracer.core(engines.core()),
            (None, None) => engines.core(),
        };
        let fresh = Solo::new(&program.image, arch.system.sram_bytes);
        let kept = checkpoint::of_program(&args.checkpoints, program, core.as_mut())?;
        let (bus, account) = kept.unwrap_or((fresh, Finish::default()));
        if let Some((_, tracer)) = &mut trace {
            tracer.begin_at(&[account.cycles()]);
        }
        Ok(Running {
            program,
            engines,
            core,
            bus,
            account,
            printing: Printing::to(args.json),
            profile,
            trace,
        })
    }

    /// Goes on to the end or to a limit of cycles, and writes a checkpoint where one is asked for.
    fn run(&mut self, args: &Run, limit: u64) -> Result<Result<(), SoloError>, Failure> {
        if let Some(at) = args.checkpoints.checkpoint_at.filter(|&at| at < limit) {
            let ended = self.until(at);
            if !matches!(ended, Err(SoloError::Endless { .. })) {
                return Ok(ended);
            }
            let state = (&self.bus, &self.account);
            checkpoint::write_program(&args.checkpoints, self.program, self.core.as_ref(), state)?;
        }
        Ok(self.until(limit))
    }

    fn until(&mut self, limit: u64) -> Result<(), SoloError> {
        let (core, bus) = (self.core.as_mut(), &mut self.bus);
        let (printing, account) = (&self.printing, &mut self.account);
        interrupt::looked_for(|| solo::run_until(core, bus, limit, printing, account))
    }

    /// Writes what is known when it has ended; the program's exit status.
    fn end(
        self,
        ended: Result<(), SoloError>,
        args: &Run,
        arch: &Arch,
        session: &Session<'_>,
    ) -> Result<i32, Failure> {
        self.printing.end(&self.bus.output)?;
        let told = Account::of(&self.account, self.program, ended.is_ok());
        told.say();
        talk::say_shares(&self.engines);
        if let Some((target, profiler)) = &self.profile {
            let about = About::machine(arch);
            target.write(&title(&args.files), about, &profiler.profile())?;
        }
        if matches!(ended, Ok(()) | Err(SoloError::Stopped)) {
            told.write(args, arch)?;
        }
        let at_end = match args.registers.is_some() || ended.is_err() {
            true => AtEnd::of(self.core.as_ref(), self.program)?,
            false => None,
        };
        if let Some((target, tracer)) = self.trace {
            match self.profile {
                // The profiler's core is not the tracer's: the program runs again.
                Some(_) => {
                    let bus = Solo::new(&self.program.image, arch.system.sram_bytes);
                    let limit = args.limit.min(session.cycles);
                    target.record_program(tracer, bus, &self.engines, limit)?;
                }
                None => target.write(&tracer)?,
            }
        }
        if let Some(path) = &args.registers {
            match &at_end {
                Some(at_end) => Registers::of(at_end, arch).write(path, arch)?,
                None => talk::complain("warning: after a trap no engine keeps registers"),
            }
        }
        let stands = || at_end.as_ref().map(AtEnd::notes).unwrap_or_default();
        match ended {
            Ok(()) => Ok(self.account.status),
            // Nobody reads what the program prints.
            Err(SoloError::Stopped) if self.printing.is_unread() => Ok(0),
            Err(SoloError::Stopped) => {
                talk::say(stands().trim_start());
                Err(Failure::Interrupted)
            }
            Err(error) => Err(Failure::message(format_args!("{error}{}", stands()))),
        }
    }
}

/// Why an engine and a profile do not go together.
pub(crate) const COUNTS: &str =
    "a profile is counted by the interpreter: leave --engine out, or give --engine interp";

/// Why an engine and registers do not go together.
const NO_REGISTERS: &str = "--engine ir has no registers: leave it out";

/// Why an engine and a trace do not go together.
const NO_CYCLES: &str = "--engine ir has no cycles to trace or to keep: leave it out";

/// Why an engine and schedules of loops do not go together.
const NO_LOOPS: &str = "--engine ir schedules no loop: there is nothing to write for --loops";

/// The files of a program, as a title.
fn title(files: &[PathBuf]) -> String {
    let names: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
    names.join(", ")
}
