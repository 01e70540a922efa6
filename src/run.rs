//! `srp run`

mod account;
mod at_end;
mod registers;

pub(crate) use account::Account;
pub(crate) use registers::Registers;

use at_end::AtEnd;

use crate::cli::{Run, RunEngine};
use crate::failure::Failure;
use crate::profile::Target;
use crate::{
    checkpoint, compile, diagnostics, files, interrupt, limits, refused_kernel, report, talk, trace,
};
use srp_archdesc::arch::Arch;
use srp_archdesc::isa::Space;
use srp_archdesc::ops::Value;
use srp_archdesc::watch::Watch;
use srp_ir::dre::{self, Dre};
use srp_ir::interp::{self, FlatWorld, PortOut, World};
use srp_ir::layout::Layout;
use srp_ir::program::Program;
use srp_runtime::core::Core;
use srp_runtime::solo::{self, Finish, Solo, SoloError};
use srp_studies::profile::Profiler;
use srp_toolchain::envelope::About;
use srp_toolchain::files::FileError;
use srp_toolchain::{Engine, Engines, Error, Input, Options, divide, front_end, input, optimise};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Runs `srp run`; the program's exit status.
pub(crate) fn run(args: &Run) -> Result<i32, Failure> {
    let arch = args.compilation.machine.read()?;
    let options = args.compilation.options()?;
    let source = &args.compilation.source;
    let session = &talk::session();
    let loops = report::Loops::to(&args.loops.loops)?;
    let input = input::read(&args.files, &arch)?;
    let profile = Target::to(&args.profile)?;
    let trace = trace::Target::of_program(&args.trace)?;
    checkpoint::check(&args.checkpoints)?;
    for path in args.report.iter().chain(&args.registers) {
        files::check_writable(path)?;
    }
    if args.registers.is_some() && args.engine == RunEngine::Ir {
        return Err(Failure::Usage(NO_REGISTERS.to_owned()));
    }
    if profile.is_some() && matches!(args.engine, RunEngine::Csim | RunEngine::Ir) {
        return Err(Failure::Usage(COUNTS.to_owned()));
    }
    let kept = &args.checkpoints;
    let is_kept = kept.checkpoint_at.is_some() || kept.restore.is_some();
    if (trace.is_some() || is_kept) && args.engine == RunEngine::Ir {
        return Err(Failure::Usage(NO_CYCLES.to_owned()));
    }
    let engine = match args.engine {
        RunEngine::Auto => Engine::Auto,
        RunEngine::Csim => Engine::Generated,
        RunEngine::Interp => Engine::Interpreter,
        RunEngine::Ir if !args.loops.loops.is_empty() => {
            return Err(Failure::usage(
                "--engine ir schedules no loop: there is nothing to write for --loops",
            ));
        }
        RunEngine::Ir => return interpret(input, &options, args, &arch),
    };
    let compiled = compile::compile_and_say(input, &arch, &options, source, session)?;
    let format = source.error_format;
    refused_kernel::check(&compiled, &arch, &options.warnings, format, session)?;
    compile::say_not_pipelined(&compiled, &arch, source.remarks_passes(), session)?;
    loops.write(&compiled, &arch, session)?;
    interrupt::end_if_requested()?;
    let program = compiled.runnable()?;
    let mut profiler = match &profile {
        Some(_) => Some(Profiler::new(program).map_err(Error::from)?),
        None => None,
    };
    let mut tracer = match &trace {
        Some(target) => Some(target.tracer(program, 1)?),
        None => None,
    };
    let engine = match profile {
        Some(_) => Engine::Interpreter,
        None => engine,
    };
    let is_profiled = profiler.is_some();
    let engines = Engines::of(program, engine, session)?;
    let mut core = match (&mut profiler, &mut tracer) {
        (Some(profiler), _) => profiler.core(),
        (None, Some(tracer)) => tracer.core(engines.core()),
        (None, None) => engines.core(),
    };
    let fresh = Solo::new(&program.image, arch.system.sram_bytes);
    let kept = checkpoint::of_program(&args.checkpoints, program, core.as_mut())?;
    let (mut bus, mut account) = kept.unwrap_or((fresh, Finish::default()));
    if let Some(tracer) = &mut tracer {
        tracer.begin_at(&[account.cycles()]);
    }
    let printing = Printing::to(args.json);
    let limit = args.limit.min(session.cycles);
    let run = |core: &mut dyn Core, limit: u64, bus: &mut Solo, account: &mut Finish| {
        interrupt::looked_for(|| solo::run_until(core, bus, limit, &printing, account))
    };
    let ended = match args.checkpoints.checkpoint_at.filter(|&at| at < limit) {
        None => run(core.as_mut(), limit, &mut bus, &mut account),
        Some(at) => match run(core.as_mut(), at, &mut bus, &mut account) {
            Err(SoloError::Endless { .. }) => {
                let state = (&bus, &account);
                checkpoint::write_program(&args.checkpoints, program, core.as_ref(), state)?;
                run(core.as_mut(), limit, &mut bus, &mut account)
            }
            ended => ended,
        },
    };
    printing.end(&bus.output)?;
    let told = Account::of(&account, program, ended.is_ok());
    told.say();
    talk::say_shares(&engines);
    if let (Some(target), Some(profiler)) = (profile, profiler) {
        let about = About::machine(&arch);
        target.write(&title(&args.files), about, &profiler.profile())?;
    }
    if matches!(ended, Ok(()) | Err(SoloError::Stopped)) {
        told.write(args, &arch)?;
    }
    match (&trace, tracer) {
        (Some(target), Some(tracer)) if is_profiled => {
            let bus = Solo::new(&program.image, arch.system.sram_bytes);
            target.record_program(tracer, bus, &engines, limit)?;
        }
        (Some(target), Some(tracer)) => target.write(&tracer)?,
        _ => {}
    }
    let at_end = match args.registers.is_some() || ended.is_err() {
        true => AtEnd::of(core.as_ref(), program)?,
        false => None,
    };
    if let Some(path) = &args.registers {
        match &at_end {
            Some(at_end) => Registers::of(at_end, &arch).write(path, &arch)?,
            None => talk::complain("warning: after a trap no engine keeps registers"),
        }
    }
    let stands = || at_end.as_ref().map(AtEnd::notes).unwrap_or_default();
    match ended {
        Ok(()) => Ok(account.status),
        // Nobody reads what the program prints.
        Err(SoloError::Stopped) if printing.is_unread() => Ok(0),
        Err(SoloError::Stopped) => {
            talk::say(stands().trim_start());
            Err(Failure::Interrupted)
        }
        Err(error) => Err(Failure::message(format_args!("{error}{}", stands()))),
    }
}

/// Watches a program that prints: its text appears as it runs, and it ends where that cannot be written.
#[derive(Default)]
struct Printing {
    /// True if standard output is for a document: the program prints to standard error.
    to_errors: bool,
    failed: Mutex<Option<io::Error>>,
}

impl Printing {
    fn to(to_errors: bool) -> Printing {
        Printing {
            to_errors,
            ..Printing::default()
        }
    }

    fn print(&self, bytes: &[u8]) -> io::Result<()> {
        match self.to_errors {
            true => io::stderr().write_all(bytes),
            false => talk::print_part(bytes),
        }
    }

    fn failure(&self) -> MutexGuard<'_, Option<io::Error>> {
        self.failed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// True when the reader of the text has gone away.
    fn is_unread(&self) -> bool {
        let failure = self.failure();
        (failure.as_ref()).is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
    }

    /// Writes the rest.
    fn end(&self, rest: &[u8]) -> Result<(), FileError> {
        let failed = self.failure().take();
        match failed {
            None => match self.print(rest) {
                Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
                    Err(FileError::writing(Path::new("standard output"), e))
                }
                _ => Ok(()),
            },
            Some(error) if error.kind() == io::ErrorKind::BrokenPipe => {
                *self.failure() = Some(error);
                Ok(())
            }
            Some(error) => Err(FileError::writing(Path::new("standard output"), error)),
        }
    }
}

impl Watch for Printing {
    fn beneath(&self) -> Option<&dyn Watch> {
        Some(&talk::CONSOLE)
    }

    fn cancelled(&self) -> bool {
        self.failure().is_some() || talk::CONSOLE.cancelled()
    }

    fn printed(&self, bytes: &[u8]) -> bool {
        if let Err(error) = self.print(bytes) {
            *self.failure() = Some(error);
        }
        true
    }
}

/// A world without time whose text appears as the program prints it, and which ends where nobody reads it.
struct Printer<'a> {
    world: FlatWorld,
    printing: &'a Printing,
}

/// Bytes of text that are printed together.
const PRINTED: usize = 1 << 12;

impl World for Printer<'_> {
    fn load(&mut self, space: Space, address: u32, bytes: u32) -> Option<Value> {
        self.world.load(space, address, bytes)
    }

    fn store(&mut self, space: Space, address: u32, bytes: u32, value: Value) -> Option<()> {
        self.world.store(space, address, bytes, value)
    }

    fn port_in(&mut self, port: u32) -> Option<u32> {
        self.world.port_in(port)
    }

    fn port_out(&mut self, port: u32, value: u32) -> PortOut {
        let taken = self.world.port_out(port, value);
        if self.world.output.len() < PRINTED {
            return taken;
        }
        self.printing.printed(&self.world.output);
        self.world.output.clear();
        match self.printing.cancelled() {
            true => PortOut::Exit(0),
            false => taken,
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

/// The files of a program, as a title.
fn title(files: &[PathBuf]) -> String {
    let names: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
    names.join(", ")
}

/// Runs the meaning of the intermediate form.
fn interpret(input: Input, options: &Options, args: &Run, arch: &Arch) -> Result<i32, Failure> {
    let source = &args.compilation.source;
    let mut precision = arch.precision;
    let dre = match input {
        Input::C(sources) => {
            let compiled = front_end(&sources, arch, options);
            let (mut control, warnings) =
                compiled.map_err(|e| diagnostics::failure(e, source.error_format))?;
            talk::say_all(&diagnostics::show(&warnings, source.error_format));
            if says_independent(&control) {
                // What pragmas say of loops is checked of the loops that the array gets.
                optimise(&mut control, arch, options);
                divide(&mut control, arch)?.dre
            } else {
                // Steps that the compiler would put into the program are not in it.
                precision = precision.in_units();
                Dre {
                    control,
                    kernels: Default::default(),
                }
            }
        }
        Input::Ir(program) => Dre {
            control: *program,
            kernels: Default::default(),
        },
        Input::Dre(dre) => *dre,
        Input::Scheduled { .. } => {
            return Err(Failure::message("a scheduled program has no --engine ir"));
        }
    };
    let layout = Layout::of(&dre.control, arch.system.sram_bytes).map_err(Failure::message)?;
    let main = dre.control.main.ok_or(Error::NoMain)?;
    let printing = Printing::to(args.json);
    let mut world = Printer {
        world: FlatWorld::new(&layout, arch.system.sram_bytes),
        printing: &printing,
    };
    let options = interp::Options {
        precision,
        steps: args.limit.min(limits::cycles()),
        ..interp::Options::new(&layout)
    };
    let zeros = dre.control.funcs[main].blocks[dre.control.funcs[main].entry()]
        .params
        .iter();
    let zero = |&v: &_| srp_ir::program::Bits::zero(dre.control.funcs[main].values[v]);
    let zeros: Vec<_> = zeros.map(zero).collect();
    let outcome = dre::run(&dre, main, &zeros, &mut world, &options);
    printing.end(&world.world.output)?;
    if printing.is_unread() {
        return Ok(0);
    }
    let outcome = outcome.map_err(|trap| Failure::Message(trap.show(&dre.control)))?;
    let account = Account::of_steps(outcome.status(), outcome.profile.steps);
    account.say();
    account.write(args, arch)?;
    Ok(outcome.status())
}

/// True when a pragma of a program says that iterations are independent.
fn says_independent(program: &Program) -> bool {
    let blocks = program.funcs.values().flat_map(|f| f.blocks.values());
    let mut marks = blocks.filter_map(|block| block.kernel.as_ref());
    marks.any(|mark| !mark.independence.is_none())
}
