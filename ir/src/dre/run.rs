//! The semantics of a [`Dre`]: interprets the control code, and runs a kernel's loop at each
//! launch.

use super::Dre;
use crate::dfg;
use crate::interp::{Kernels, Options, Outcome, Trap, TrapKind, World, run_with};
use crate::program::{Bits, Func, Kernel};
use srp_archdesc::arch::Precision;

/// The kernels of a [`Dre`], run iteration by iteration.
struct Loops<'a> {
    dre: &'a Dre,
    precision: Precision,
}

impl Kernels for Loops<'_> {
    fn launch(
        &mut self,
        kernel: Kernel,
        args: &[Bits],
        world: &mut dyn World,
        steps: &mut u64,
    ) -> Result<Vec<Bits>, Trap> {
        let dfg = self.dre.kernels.get(kernel);
        let dfg = dfg.ok_or_else(|| TrapKind::NoKernel(kernel).nowhere())?;
        dfg::run(dfg, args, world, &self.precision, steps)
    }
}

/// Runs a function of a divided program, as [`interp::run`](crate::interp::run) runs one that is
/// not. A launched operation counts as one step.
pub fn run(
    dre: &Dre,
    func: Func,
    args: &[Bits],
    world: &mut dyn World,
    options: &Options<'_>,
) -> Result<Outcome, Trap> {
    let mut loops = Loops {
        dre,
        precision: options.precision,
    };
    run_with(&dre.control, func, args, world, &mut loops, options)
}
