//! The meaning of the intermediate form: a run without schedules and without time.

use super::account::Account;
use super::printing::Printing;
use crate::cli::Run;
use crate::failure::Failure;
use crate::{diagnostics, limits, talk};
use srp_archdesc::arch::Arch;
use srp_archdesc::isa::Space;
use srp_archdesc::ops::Value;
use srp_archdesc::watch::Watch;
use srp_ir::dre::{self, Dre};
use srp_ir::interp::{self, FlatWorld, PortOut, World};
use srp_ir::layout::Layout;
use srp_ir::program::Program;
use srp_toolchain::{Error, Input, Options, divide, front_end, optimise};

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

/// Runs an input as it is meant; the program's exit status.
pub(super) fn run(
    input: Input,
    options: &Options,
    args: &Run,
    arch: &Arch,
) -> Result<i32, Failure> {
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
    let zeros = dre.control.funcs[main].zero_arguments();
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
