//! `srp run`

use crate::cli::{Engine, Run, RunEngine};
use crate::failure::Failure;
use crate::pipeline::{self, Effort, FrontEnd, Input};
use crate::{compile, engine, interrupt, machine, report, talk};
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::Entity;
use srp_ir::dre::scheduled::ScheduledDre;
use srp_ir::dre::{self, Dre};
use srp_ir::interp::{self, FlatWorld};
use srp_ir::layout::Layout;
use srp_ir::program::Kernel;
use srp_runtime::solo::{self, Finish, Solo, SoloError};

/// Runs `srp run`; the program's exit status.
pub(crate) fn run(args: &Run) -> Result<i32, Failure> {
    let arch = machine::read(&args.compilation.machine.machine)?;
    let front_end = FrontEnd::new(&args.compilation.source, &arch);
    let loops = report::Loops::to(&args.loops.loops)?;
    let input = pipeline::read(&args.files, &arch)?;
    let simulator = match args.engine {
        RunEngine::Csim => Engine::Csim,
        RunEngine::Interp => Engine::Interp,
        RunEngine::Ir if !args.loops.loops.is_empty() => {
            return Err(Failure::message(
                "--engine ir schedules no loop: there is nothing to write for --loops",
            ));
        }
        RunEngine::Ir => return interpret(input, &front_end, &arch, args.limit),
    };
    let compiled = pipeline::compile(input, &front_end, Effort::of(&args.compilation.search))?;
    compile::say_not_pipelined(&compiled, &arch, &args.compilation.source);
    loops.write(&compiled, &arch)?;
    let program = compiled.runnable()?;
    let mut cores = engine::cores(program, &arch, simulator, 1)?;
    let mut bus = Solo::new(&program.image, arch.system.sram_bytes);
    let core = cores.first_mut().expect("one core was asked for");
    let mut account = Finish::default();
    let ended = interrupt::looked_for(|| {
        solo::run_until(
            core.as_mut(),
            &mut bus,
            args.limit,
            &talk::CONSOLE,
            &mut account,
        )
    });
    talk::print(&bus.output)?;
    say_account(&account, program);
    match ended {
        Ok(()) => Ok(account.status),
        Err(SoloError::Stopped) => Err(Failure::Interrupted),
        Err(error) => Err(Failure::message(error)),
    }
}

fn say_account(account: &Finish, program: &ScheduledDre) {
    talk::say(format_args!(
        "{} cycles: {} VLIW, {} switching",
        account.cycles(),
        account.vliw,
        account.switch
    ));
    for (&kernel, cycles) in &account.kernels {
        let kernel = program.kernels.get(Kernel::new(kernel as usize));
        let name = kernel.map_or("a kernel", |k| k.dfg.name.as_str());
        talk::say(format_args!("  {cycles} in {name}"));
    }
}

/// Runs the meaning of the intermediate form.
fn interpret(
    input: Input,
    front_end: &FrontEnd<'_>,
    arch: &Arch,
    limit: u64,
) -> Result<i32, Failure> {
    let mut precision = arch.precision;
    let dre = match input {
        Input::C(sources) => {
            let control = front_end.compile(&sources)?;
            // Steps that the compiler would put into the program are not in it.
            precision = precision.in_units();
            Dre {
                control,
                kernels: Default::default(),
            }
        }
        Input::Ir(program) => Dre {
            control: *program,
            kernels: Default::default(),
        },
        Input::Dre(dre) => *dre,
        Input::Scheduled(_) => {
            return Err(Failure::message("a scheduled program has no --engine ir"));
        }
    };
    let layout = Layout::of(&dre.control, arch.system.sram_bytes).map_err(Failure::message)?;
    let main = dre.control.main.ok_or_else(pipeline::no_main)?;
    let mut world = FlatWorld::new(&layout, arch.system.sram_bytes);
    let options = interp::Options {
        precision,
        steps: limit,
        ..interp::Options::new(&layout)
    };
    let zeros = dre.control.funcs[main].blocks[dre.control.funcs[main].entry()]
        .params
        .iter();
    let zero = |&v: &_| srp_ir::program::Bits::zero(dre.control.funcs[main].values[v]);
    let args: Vec<_> = zeros.map(zero).collect();
    let outcome = dre::run(&dre, main, &args, &mut world, &options);
    talk::print(&world.output)?;
    let outcome = outcome.map_err(|trap| Failure::Message(trap.show(&dre.control)))?;
    talk::say(format_args!("{} steps", outcome.profile.steps));
    Ok(outcome.status())
}
