//! A C program with a loop on the array: what it prints, on an engine and by its meaning, and what the loop takes.

use srp_archdesc::arch::Arch;
use srp_archdesc::entity::Entity;
use srp_csimgen::{Interpreter, link};
use srp_ir::Program;
use srp_ir::interp::{self, FlatWorld};
use srp_ir::layout::Layout;
use srp_runtime::core::Core;
use srp_runtime::solo::{self, Finish, Solo};
use srp_toolchain::{Engine, Input, Options, Session, compile, front_end, optimise};

/// Cycles after which a program is said not to end.
const LIMIT: u64 = 1_000_000;

/// A run of a program.
pub struct Ran {
    /// The bytes that it printed.
    pub output: Vec<u8>,
    /// Cycles of the loop on the array.
    pub cycles: u64,
    /// Its initiation interval.
    pub ii: u32,
}

/// Compiles and runs a program whose loop is of the function `kernel`.
///
/// # Panics
///
/// If it cannot be, or the loop is not on the array.
pub fn run(
    input: Input,
    arch: &Arch,
    options: &Options,
    engine: Engine,
    session: &Session<'_>,
    kernel: &str,
) -> Ran {
    let compiled = compile(input, arch, options, session);
    let compiled = compiled.unwrap_or_else(|error| panic!("{kernel}: {error}"));
    let program = compiled.runnable().expect("it has a main");
    let mut bus = Solo::new(&program.image, arch.system.sram_bytes);
    let mut finish = Finish::default();
    let simulator = (engine == Engine::Generated).then(|| crate::generated(program));
    let mut core: Box<dyn Core> = match simulator.flatten() {
        Some(simulator) => Box::new(simulator.core()),
        None => Box::new(Interpreter::new(&link(program).expect("it links"))),
    };
    let ended = solo::run_until(core.as_mut(), &mut bus, LIMIT, session.watch, &mut finish);
    ended.expect("it ends");
    let (number, schedule) = (program.kernels.iter())
        .find(|(_, k)| k.dfg.name.contains(kernel))
        .expect("its loop is on the array");
    Ran {
        output: bus.output,
        cycles: finish.kernels[&(Entity::index(number) as u32)],
        ii: schedule.ii,
    }
}

/// The bytes that C prints by the meaning of its intermediate form, before or after the passes.
///
/// # Panics
///
/// If it is no C, or traps.
pub fn meaning(input: Input, arch: &Arch, options: &Options, passes: bool) -> Vec<u8> {
    let Input::C(sources) = input else {
        panic!("it is no C")
    };
    let (mut program, _) = front_end(&sources, arch, options).expect("it compiles");
    if passes {
        optimise(&mut program, arch, options);
    }
    printed(&program, arch)
}

/// The bytes that a program of the intermediate form prints.
///
/// # Panics
///
/// If it traps.
pub fn printed(program: &Program, arch: &Arch) -> Vec<u8> {
    let layout = Layout::of(program, arch.system.sram_bytes).expect("it fits");
    let mut world = FlatWorld::new(&layout, arch.system.sram_bytes);
    let main = program.main.expect("a main function");
    let options = interp::Options {
        precision: arch.precision,
        ..interp::Options::new(&layout)
    };
    let ran = interp::run(program, main, &[], &mut world, &options);
    ran.unwrap_or_else(|trap| panic!("{}", trap.show(program)));
    world.output
}
